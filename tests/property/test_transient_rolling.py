"""Rolling under changing creepage: energy balance, passivity, steady limit, start states, order of convergence."""

import dataclasses

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad

import infinivar as iv
from infinivar.contact import kalker
from internals import Friction
from sampled import sampled

LINEAR = kalker.coefficients(1.0, 0.3)
SMALL = iv.contact.RollingPatch(1.0, cells=10)


def _forces(rolling):
    return np.stack([rolling.fx, rolling.fy, rolling.mz], axis=-1)


@pytest.mark.slow
def test_step_from_rest():
    """A circle under a scaled lateral creepage of 1.5: forces that another program computed, to 0.005."""
    rolling = iv.contact.RollingPatch(1.0).transient([0.25, 1.0, 4.0], lateral=1.5 / LINEAR.c22)
    assert_allclose(rolling.fy, [0.222, 0.692, 0.894], atol=0.005)
    assert np.all(np.abs(rolling.balance) < 0.01 * rolling.work)


@pytest.mark.parametrize("ratio", [0.2, 0.5, 1.0, 2.0])
def test_first_step_is_a_shift(ratio):
    r"""Before anything has rolled through, force is stiffness times distance: for a patch that sticks, after Mindlin,

    4 pi/integral of ((1 - nu) + nu sin^2) (cos^2/a^2 + sin^2/b^2)^(-1/2). Its tractions are singular at the edges, which costs
    2 % on 20 x 20 cells, of first order in the cells.
    """
    a, b = np.sqrt(ratio), 1.0 / np.sqrt(ratio)

    def integrand(angle):
        return (0.7 + 0.3 * np.sin(angle) ** 2) / np.hypot(np.cos(angle) / a, np.sin(angle) / b)

    stiffness = 4.0 * np.pi / quad(integrand, 0.0, 2.0 * np.pi)[0]
    shift = 1e-6
    coarse, fine = (
        iv.contact.RollingPatch(ratio, 0.3, 0.0, cells).transient([1e-5], lateral=shift / 1e-5).fy[0]
        / (stiffness * shift)
        for cells in (10, 20)
    )
    assert abs(fine - 1.0) < 0.02
    assert abs(2.0 * fine - coarse - 1.0) < 0.005


@sampled("creepage", [(0.0, 0.6, 0.0), (0.0, 1.5, 0.0), (0.0, 3.6, 0.0), (0.0, 0.0, 1.0), (0.0, -0.6, 0.5)], every=3)
@sampled("ratio", [0.2, 1.0, 5.0], every=2)
def test_balance(ratio, creepage):
    """On 20 x 20 cells, work of the creepages is stored or dissipated to 0.5 %, already after a/2 from rest."""
    linear = kalker.coefficients(ratio, 0.3)
    creepage = creepage / np.array([linear.c11, linear.c22, linear.c23])
    rolling = iv.contact.RollingPatch(ratio, 0.3, 0.0, 20).transient(np.array([0.5, 1.0]) * np.sqrt(ratio), *creepage)
    assert np.all(np.abs(rolling.balance) < 0.005 * rolling.work)
    assert np.all(rolling.dissipated > 0.0)
    assert np.all(rolling.energy > 0.0)


@pytest.mark.slow
def test_order():
    """Steps of half the length divide the error by about 4, in the forces and in the balance."""
    creepage = {"lateral": [0.4, -0.3], "spin": [0.0, 0.4]}
    found = [SMALL.transient([1.0, 2.0], **creepage, step=0.5**halving) for halving in range(7)]
    errors = [np.max(np.abs(_forces(rolling) - _forces(found[-1]))) for rolling in found]
    balances = np.array([rolling.balance[-1] for rolling in found])
    assert errors[2] < 0.0025
    assert errors[3] < 0.001  # the default step
    assert errors[0] > 5.0 * errors[2]
    assert errors[0] > 100.0 * errors[4]
    changes = np.abs(np.diff(balances))
    assert changes[0] > 30.0 * changes[3]


@sampled("turned", [0.0, 0.5], every=4)
@sampled("creepage", [(0.2, 0.3, 0.2), (0.0, 0.4, -0.3), (0.3, 0.0, 0.0), (0.0, 0.0, 2.0)], every=2)
def test_steady_limit(creepage, turned):
    """Rolled far enough, from rest or from the opposite state, the patch is in the state that the steady solver finds."""
    patch = iv.contact.RollingPatch(0.6, 0.3, turned, 8)
    steady = patch.steady(*creepage)
    opposite = patch.steady(*np.negative(creepage))
    for start in (None, opposite):
        rolling = patch.transient([15.0], *creepage, start=start)
        assert_allclose(_forces(rolling)[-1], steady.forces, atol=1e-4)
        assert_allclose(rolling.traction[-1], steady.traction, atol=1e-3)


def test_steady_state_lasts():
    """From the steady state nothing changes but work and dissipation, which are equal."""
    patch = iv.contact.RollingPatch(2.0, 0.3, 0.3, 10)
    steady = patch.steady(0.1, 0.3, 0.2)
    rolling = patch.transient([0.5, 3.0], 0.1, 0.3, 0.2, start=steady)
    assert_allclose(_forces(rolling), np.tile(steady.forces, (2, 1)), atol=1e-7)
    assert_allclose(rolling.energy, rolling.start_energy, rtol=1e-6)
    assert_allclose(rolling.dissipated, rolling.distance * steady.power, rtol=1e-3)


def test_continued_path():
    """A path rolled in two parts is the same as in one, and so are more distances on the same steps."""
    distance, lateral, spin = np.linspace(0.25, 2.0, 8), np.linspace(0.1, 0.8, 8), np.linspace(0.4, -0.4, 8)
    whole = SMALL.transient(distance, lateral=lateral, spin=spin, keep=range(8))
    first = SMALL.transient(distance[:3], lateral=lateral[:3], spin=spin[:3])
    second = SMALL.transient(distance[3:] - distance[2], lateral=lateral[3:], spin=spin[3:], start=first)
    assert_allclose(_forces(second), _forces(whole)[3:], atol=1e-7)
    assert_allclose(second.energy, whole.energy[3:], atol=1e-7)
    assert_allclose(first.work[-1] + second.work, whole.work[3:], atol=1e-7)
    assert_allclose(second.start_energy, first.energy[-1], rtol=1e-12)
    assert_allclose(whole.traction[2], first.traction[-1], atol=1e-7)
    finer = SMALL.transient(np.arange(1, 17) / 8.0, lateral=np.repeat(lateral, 2), spin=np.repeat(spin, 2), step=0.125)
    coarse = SMALL.transient(distance, lateral=lateral, spin=spin, step=0.125)
    assert_allclose(_forces(finer)[1::2], _forces(coarse), atol=1e-7)


def test_half_of_the_patch_serves_for_the_whole():
    """A start or a creepage that is not mirrored takes the equations of all cells."""
    half = SMALL.transient([0.5, 1.0], lateral=0.3, spin=0.2)
    assert_allclose(_forces(SMALL.transient([0.5, 1.0], 1e-12, 0.3, 0.2)), _forces(half), atol=1e-8)
    pulled = SMALL.steady(0.3)
    released = SMALL.transient([12.0], lateral=0.3, spin=0.2, start=pulled)
    assert_allclose(_forces(released)[-1], SMALL.steady(0.0, 0.3, 0.2).forces, atol=1e-4)


def _steered_at_random(patch, steps, longitudinal):
    """Creepages that jump every fourth step, and steps of random length: passive, within bounds and balanced."""
    linear = kalker.coefficients(patch.a_over_b, patch.poisson)
    rng = np.random.default_rng(5)
    jumps = np.repeat(rng.normal(size=(steps // 4, 3)), 4, axis=0)
    jumps *= [2.0 / linear.c11 if longitudinal else 0.0, 2.0 / linear.c22, 1.0 / linear.c23]
    half = 1.0 / patch.grid.reach
    distance = half * np.cumsum(np.exp(rng.uniform(np.log(0.02), np.log(0.25), steps)))
    rolling = patch.transient(distance, *jumps.T, step=half, keep=range(0, steps, 10))
    assert set(rolling.outcome) == {"converged"}
    assert np.all(np.diff(rolling.dissipated, prepend=0.0) >= 0.0)
    assert np.all(rolling.energy >= 0.0)
    assert np.all(np.hypot(rolling.traction[:, 0], rolling.traction[:, 1]) <= rolling.grid.bound * (1.0 + 1e-7))
    assert np.max(np.abs(rolling.balance)) < 0.01 * rolling.work[-1]


@pytest.mark.slow
@sampled("ratio", [0.3, 4.0], every=2)
def test_random_steering(ratio):
    _steered_at_random(iv.contact.RollingPatch(ratio, cells=10), 300 if ratio > 1.0 else 100, False)


@pytest.mark.slow
def test_random_creepage_of_a_turned_patch():
    _steered_at_random(iv.contact.RollingPatch(0.6, 0.3, 0.5, 8), 100, True)


@pytest.mark.full
@pytest.mark.parametrize("ratio", [1.0, 0.1, 10.0])
def test_random_steering_on_the_usual_grid(ratio):
    _steered_at_random(iv.contact.RollingPatch(ratio), 300, False)


@sampled(("ratio", "turned"), [(0.1, 0.0), (1.0, 0.0), (10.0, 0.0), (0.3, 0.7)], every=2)
def test_default_step(ratio, turned):
    """After jumps of creepage and spin, forces err by about 0.001 of mu N, the moment by 0.0015 of mu N a."""
    patch, linear = iv.contact.RollingPatch(ratio, 0.3, turned, 8), kalker.coefficients(ratio, 0.3)
    half = 1.0 / patch.grid.reach
    creepage = {"lateral": np.array([1.2, -0.9]) / linear.c22, "spin": np.array([0.0, 0.5]) / linear.c23}
    error = _forces(patch.transient([half, 2.0 * half], **creepage)) - _forces(
        patch.transient([half, 2.0 * half], **creepage, step=half / 64.0)
    )
    assert np.max(np.abs(error[:, :2])) < 0.0015
    assert np.max(np.abs(error[:, 2])) < 0.0015 * max(half, 1.0)


def test_slip_opposes_traction():
    """Where a cell slides, the slip in its middle opposes its traction; where it sticks there is none."""
    rolling = iv.contact.RollingPatch(1.0, cells=20).transient([0.5], lateral=0.6, spin=0.3)
    traction, slip, slides = rolling.traction[0], rolling.slip[0], rolling.slides[0]
    along = np.sum(traction * slip, axis=0)
    inside = slides[:, :-1] & slides[:, 1:]  # the mean over a cell at the border of both areas holds half of each
    size = np.hypot(*traction) * np.hypot(*slip)
    assert np.all(along[:, :-1][inside] > 0.8 * size[:, :-1][inside])
    stuck = ~slides
    stuck[:, 1:] &= ~slides[:, :-1]
    stuck[:, 0] = False
    assert np.max(size[stuck]) < 1e-6 * np.max(size)


def test_what_does_not_converge_is_nan(monkeypatch):
    """From the first step that fails, even in parts, outcomes say so and no number is given."""
    solve, lateral = Friction.solve, [0.3, 0.5, 0.2]

    def failing(self, free_slip, start=None):
        found = solve(self, free_slip, start)
        return found._replace(outcome="not converged") if np.max(np.abs(found.traction)) > 0.2 else found

    good = SMALL.transient([0.1, 2.0, 3.0], lateral=lateral)
    monkeypatch.setattr(Friction, "solve", failing)
    rolling = SMALL.transient([0.1, 2.0, 3.0], lateral=lateral)
    assert rolling.outcome == ("converged", "not converged", "not converged")
    assert rolling.fy[0] == good.fy[0]
    for field in ("fx", "fy", "mz", "energy", "work", "dissipated"):
        assert np.all(np.isnan(getattr(rolling, field)[1:]))
    assert np.all(np.isnan(rolling.traction))


def test_progress():
    """The share done, after each distance."""
    shares = []
    SMALL.transient([0.1, 0.2, 0.3, 0.4], lateral=0.1, progress=shares.append)
    assert shares == [0.25, 0.5, 0.75, 1.0]


@pytest.mark.parametrize(
    ("distance", "options", "said"),
    [
        ([0.2, 0.1], {}, "distance must be a list of finite distances that increase, the first above 0"),
        ([0.0, 0.1], {}, "distance must be"),
        ([], {}, "distance must be"),
        ([[0.1]], {}, "distance must be"),
        ([0.1, float("nan")], {}, "distance must be"),
        ([0.1, 0.2], {"lateral": [0.1, 0.2, 0.3]}, "lateral must be one finite value, or 2: one until each distance"),
        ([0.1, 0.2], {"spin": float("inf")}, "spin must be"),
        ([0.1], {"step": 0.0}, "step must be"),
        ([0.1], {"keep": [1]}, "keep must be indices of the 1 distances, got 1"),
        (
            [0.1],
            {"start": iv.contact.RollingPatch(1.0, cells=8).steady()},
            "start must be a state of a patch with a_over_b",
        ),
        (
            [0.1],
            {"start": dataclasses.replace(SMALL.steady(), outcome="not converged")},
            "start must be a state that has converged",
        ),
    ],
)
def test_bad_arguments(distance, options, said):
    """One message that names the argument."""
    with pytest.raises(iv.ParameterError, match=said):
        SMALL.transient(distance, **options)
