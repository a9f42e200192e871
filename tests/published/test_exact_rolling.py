"""The solver of exact rolling contact against kalker1990: coefficients, reference curves, closed forms."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar.contact import exact_tables, kalker


def _lateral(curve, cells):
    """Force ratio at the points of one reference curve."""
    ratio = curve["a_over_b"]
    patch, c22 = iv.RollingPatch(ratio, 0.3, 0.0, cells), kalker.coefficients(ratio, 0.3).c22
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
    patch, small = iv.RollingPatch(ratio, poisson, 0.0, cells), 1e-6
    gradient = patch.steady(0.0, small, 0.0, gradient=True).gradient
    return gradient[0, 0], gradient[1, 1], gradient[1, 2], -gradient[2, 1], gradient[2, 2]


@pytest.mark.parametrize("poisson", [0.0, 0.25, 0.5])
@pytest.mark.parametrize("ratio", [0.1, 0.2, 0.5, 1.0, 1.0 / 0.6, 1.0 / 0.3, 10.0])
def test_coefficients_of_the_linear_theory(ratio, poisson):
    """Within 1.2 % of Kalker's table on 20 x 20 cells; C23 from the force is that from the moment."""
    c11, c22, c23, reverse, _ = _coefficients(ratio, poisson, 20)
    table = kalker.coefficients(ratio, poisson)
    assert_allclose([c11, c22, c23], [table.c11, table.c22, table.c23], rtol=0.012)
    assert_allclose(reverse, c23, rtol=1e-9)


@pytest.mark.parametrize("poisson", [0.0, 0.3])
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
        patch = iv.RollingPatch(ratio, poisson, 0.0, 20)
        parts = np.array([0.1, 0.3, 0.6, 0.9])
        forces = [patch.steady(part * 2.0 * (1.0 - poisson) * p0).fx for part in parts]
        strips = [np.sum(weight * (1.0 - np.maximum(1.0 - part / s, 0.0) ** 2)) for part in parts]
        differences.append(np.max(np.abs(np.subtract(forces, strips))))
    assert differences[0] < 0.005
    assert differences[0] < differences[1]
