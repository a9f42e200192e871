"""The solver of exact rolling contact against kalker1990: coefficients, reference curves, closed forms."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad

import infinivar as iv
from infinivar.contact import exact_tables, kalker, rolling_forces
from internals import Friction
from internals import exact_grid as cells_of
from internals import extrapolated_forces as extrapolated
from internals import influence_of_cells as influence
from sampled import sampled


def _lateral(curve, cells):
    """Force ratio at the points of one reference curve."""
    ratio = curve["a_over_b"]
    patch, c22 = iv.contact.RollingPatch(ratio, 0.3, 0.0, cells), kalker.coefficients(ratio, 0.3).c22
    return np.array([patch.steady(0.0, 3.0 * k / c22).fy for k in curve["scaled_creepage"]])


@pytest.mark.parametrize("curve", exact_tables.lateral_creep(), ids=lambda curve: f"a/b={curve['a_over_b']}")
def test_lateral_creep(curve):
    """20 x 20 cells within 0.004 of mu N; extrapolated with 10 x 10 at the order 1.5 within 0.002."""
    coarse, fine = _lateral(curve, 10), _lateral(curve, 20)
    assert np.max(np.abs(fine - curve["force_ratio"])) < 0.004
    better = fine + (fine - coarse) / (2.0**1.5 - 1.0)
    assert np.max(np.abs(better - curve["force_ratio"])) < 0.002


def _coefficients(ratio, poisson, cells):
    """C11, C22, C23 from the force, C23 from the moment, C33."""
    patch, small = iv.contact.RollingPatch(ratio, poisson, 0.0, cells), 1e-6
    gradient = patch.steady(0.0, small, 0.0, gradient=True).gradient
    return gradient[0, 0], gradient[1, 1], gradient[1, 2], -gradient[2, 1], gradient[2, 2]


@sampled("poisson", [0.0, 0.25, 0.5], every=4)
@pytest.mark.parametrize("ratio", [0.1, 0.2, 0.5, 1.0, 1.0 / 0.6, 1.0 / 0.3, 10.0])
def test_coefficients_of_the_linear_theory(ratio, poisson):
    """Within 1.2 % of Kalker's table on 20 x 20 cells; C23 from the force is that from the moment."""
    c11, c22, c23, reverse, _ = _coefficients(ratio, poisson, 20)
    table = kalker.coefficients(ratio, poisson)
    assert_allclose([c11, c22, c23], [table.c11, table.c22, table.c23], rtol=0.012)
    assert_allclose(reverse, c23, rtol=1e-9)


@sampled("poisson", [0.0, 0.3], every=2)
def test_strips_of_carter(poisson):
    r"""As a/b tends to 0, each row is a strip, with Carter's force 1 - (1 - upsilon/upsilon_c)^2 and its own upsilon_c.

    At the row with the share s of the longest chord, upsilon_c = 2 (1 - nu) p0 s/G. The sum over the rows is the limit of
    the patch; at a/b = 0.05 the rows' influence on each other leaves 0.005, at 0.1 more.
    """
    p0 = 1.5 / np.pi
    s = np.cos((np.arange(2000) + 0.5) / 2000 * np.pi - 0.5 * np.pi)
    weight = s**3 / np.sum(s**3)
    differences = []
    for ratio in (0.05, 0.1):
        patch = iv.contact.RollingPatch(ratio, poisson, 0.0, 20)
        parts = np.array([0.1, 0.3, 0.6, 0.9])
        forces = [patch.steady(part * 2.0 * (1.0 - poisson) * p0).fx for part in parts]
        strips = [np.sum(weight * (1.0 - np.maximum(1.0 - part / s, 0.0) ** 2)) for part in parts]
        differences.append(np.max(np.abs(np.subtract(forces, strips))))
    assert differences[0] < 0.005
    assert differences[0] < differences[1]


def _spinning(curve):
    """Creepages of a curve with spin."""
    linear = kalker.coefficients(curve["a_over_b"], 0.3)
    k = curve["scaled_creepage"]
    return np.zeros_like(k), 3.0 * k / linear.c22, curve["spin"] / linear.c23 + 0.0 * k


def _slanting(curve):
    """Creepages of a curve with longitudinal and lateral creepage."""
    linear = kalker.coefficients(curve["a_over_b"], 0.3)
    k, angle = curve["scaled_creepage"], np.radians(curve["direction"])
    return 3.0 * k * np.cos(angle) / linear.c11, 3.0 * k * np.sin(angle) / linear.c22, 0.0 * k


@sampled("curve", exact_tables.spin_creep(), ids=lambda c: f"a/b={c['a_over_b']},psi={c['spin']}", every=6)
def test_lateral_creep_with_spin(curve):
    """Force and moment within 0.005 of curves that are good to 0.002."""
    found = rolling_forces(curve["a_over_b"], *_spinning(curve))
    assert_allclose(found.fy, curve["lateral_force"], rtol=0, atol=0.005)
    assert_allclose(found.mz, curve["moment"], rtol=0, atol=0.005)


@sampled("curve", exact_tables.combined_creep(), ids=lambda c: f"a/b={c['a_over_b']},at={c['direction']}", every=4)
def test_creep_in_both_directions(curve):
    """Forces and moment within 0.005 of curves that are good to 0.001."""
    found = rolling_forces(curve["a_over_b"], *_slanting(curve))
    assert_allclose(found.fx, curve["longitudinal_force"], rtol=0, atol=0.005)
    assert_allclose(found.fy, curve["lateral_force"], rtol=0, atol=0.005)
    assert_allclose(found.mz, curve["moment"], rtol=0, atol=0.005)


@pytest.mark.full
def test_self_convergence():
    """From 20 x 20 to 40 x 40 cells the extrapolated forces change by less than 0.003, those of 20 x 20 by less than 0.006."""
    for curves, creepages in ((exact_tables.spin_creep(), _spinning), (exact_tables.combined_creep()[1::2], _slanting)):
        for curve in curves:
            given = [part[::3] for part in creepages(curve)]
            twenty, forty = (rolling_forces(curve["a_over_b"], *given, cells=cells) for cells in (20, 40))
            change = np.abs(np.stack(twenty[:3], axis=-1) - np.stack(forty[:3], axis=-1))
            assert np.max(change) < 0.003
            assert np.max(change + twenty.error) < 0.006


@pytest.mark.full
def test_order_of_convergence():
    """The error of the lateral force against 48 x 48 cells falls with an order above 1.2 from 8 to 24 cells."""
    linear = kalker.coefficients(1.0, 0.3)
    forces = {}
    for cells in (8, 24, 48):
        patch = iv.contact.RollingPatch(1.0, 0.3, 0.0, cells)
        forces[cells] = np.array([patch.steady(0.0, 3.0 * k / linear.c22).fy for k in np.linspace(0.1, 0.8, 8)])
    errors = {cells: np.sqrt(np.mean((forces[cells] - forces[48]) ** 2)) for cells in (8, 24)}
    order = math.log(errors[8] / errors[24]) / math.log(3.0)
    print(f"errors {errors}, order {order:.2f}")
    assert order > 1.2


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [0.2, 1.0, 5.0])
def test_turning_moment_without_slip(ratio):
    """C33, extrapolated from 20 and 40 cells, within 2 % of other boundary elements, which err where patches are slender."""
    coarse, fine = (_coefficients(ratio, 0.3, cells)[4] for cells in (20, 40))
    assert_allclose(2.0 * fine - coarse, kalker.coefficients(ratio, 0.3).c33, rtol=0.02)


@pytest.mark.parametrize("ratio", [0.3, 1.0, 3.0])
def test_onset_of_full_slip(ratio):
    r"""Without lateral contraction the last point sticks up to the lateral creepage D a.

    There the displacement's gradient of the fully sliding patch is D, of the traction :math:`\mu p`. The last cell lets go
    earlier by a part that falls with its length: extrapolated to none it is within 2 %.
    """
    a, b = math.sqrt(ratio), 1.0 / math.sqrt(ratio)
    onset = (
        a
        * 1.5
        / np.pi
        * quad(lambda t: math.sin(t) ** 2 * (math.cos(t) ** 2 / a**2 + math.sin(t) ** 2 / b**2) ** -1.5, 0, np.pi)[0]
    )
    shares = []
    for cells in (10, 20):
        patch = iv.contact.RollingPatch(ratio, 0.0, 0.0, cells)
        low, high = 0.0, 2.0 * onset
        while high - low > 1e-3 * onset:
            middle = 0.5 * (low + high)
            low, high = (low, middle) if patch.steady(0.0, middle).slip_share == 1.0 else (middle, high)
        shares.append(high / onset)
    assert 0.85 < shares[0] < shares[1] < 1.0
    assert_allclose(2.0 * shares[1] - shares[0], 1.0, atol=0.02)


@pytest.mark.parametrize("shift", [0.25, 0.5, 0.75, 0.9])
def test_cattaneo(monkeypatch, shift):
    """Shifted without rolling, a sphere's force is 1 - (1 - d/d_most)^(3/2): 7/8 at three quarters. nu = 0, so it is exact.

    Cells lie in the middle here, and displacements take the place of slip. 20 x 20 cells err by up to 0.003.
    """
    monkeypatch.setattr(cells_of, "AHEAD", 0.0)
    patch = cells_of.grid.__wrapped__(1.0, 0.0, 20)
    friction = Friction.of(influence.__wrapped__(patch, 0.0, False).displacement, patch.bound)
    most = 3.0 * 2.0 / 8.0
    free = np.zeros((2, 400))
    free[0] = shift * most
    found = friction.solve(free)
    assert found.outcome == "converged"
    force = -np.sum(patch.area * found.traction[0].reshape(20, 20))
    assert_allclose(force, 1.0 - (1.0 - shift) ** 1.5, atol=0.003)


@sampled(("lateral", "spin"), [(-0.1, 1.0), (-0.3, 1.0), (-1.66, 1.5)], every=3)
def test_slender_patches_under_spin_are_refined_where_two_grids_do_not_agree(lateral, spin):
    """At a/b = 0.1, 10 and 20 cells extrapolated err by 0.008, more than 20 cells alone; with 20 and 40 by 0.001."""
    linear = kalker.coefficients(0.1, 0.3)
    creepage = (0.0, lateral / linear.c22, spin / linear.c23)
    rough = extrapolated(iv.contact.RollingPatch(0.1), creepage, 10)
    fine = iv.contact.RollingPatch(0.1, cells=40).steady(*creepage)
    assert rough.error[1] > 0.005
    assert abs(rough.forces[1] - fine.fy) > 0.006 > 0.003 > abs(rough.fine.fy - fine.fy)
    found = rolling_forces(0.1, *creepage)
    assert_allclose(found.fy, fine.fy, rtol=0, atol=0.001)
    assert_allclose(found.mz, fine.mz, rtol=0, atol=0.003)
    assert found.error.max() < 0.003


@pytest.mark.full
def test_rolling_forces_at_fresh_random_points():
    """Against 20 and 40 cells, extrapolated: within 0.003 up to a/b = 5."""
    rng = np.random.default_rng(90210)
    for _ in range(24):
        ratio, poisson = float(np.exp(rng.uniform(np.log(0.05), np.log(5.0)))), float(rng.uniform(0.0, 0.5))
        linear, (angle, size) = kalker.coefficients(ratio, poisson), rng.uniform([0.0, 0.02], [2.0 * np.pi, 0.97])
        rho = 2.0 * size / (1.0 - size)
        creepage = (0.0, rho * np.cos(angle) / linear.c22, rho * np.sin(angle) / np.sqrt(linear.c22 * linear.c33))
        fine = extrapolated(iv.contact.RollingPatch(ratio, poisson, cells=40), creepage, 20)
        found = rolling_forces(ratio, *creepage, poisson=poisson)
        assert_allclose([found.fx, found.fy, found.mz], fine.forces, rtol=0, atol=0.003)
