"""Creep stiffness of a patch that is turned from the rolling direction, against the solver of exact rolling contact."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar.contact import kalker, turned
from sampled import sampled

rng = np.random.default_rng(18)


def _solved(ratio, poisson, turn):
    """Lateral force by lateral creepage at no longitudinal force, from derivatives of the solver at no creepage."""
    by = iv.contact.RollingPatch(ratio, poisson, turn).steady(0.0, 1e-9, 0.0, gradient=True).gradient
    return by[1, 1] - by[0, 1] * by[1, 0] / by[0, 0]


@pytest.mark.slow
@sampled(
    ("largest", "error"),
    [
        (1.4, 0.001),
        *(pytest.param(*one, marks=pytest.mark.slow) for one in ((2.0, 0.0015), (4.0, 0.005))),
        (6.0, 0.013),
    ],
    every=2,
    slow=3,
)
def test_against_the_solver(largest, error):
    """Relative to the aligned patch of the solver, so that the errors of Kalker's table, 0.3 %, stay out."""
    for _ in range(8):
        ratio = math.exp(math.log(largest) * rng.uniform(-1.0, 1.0))
        poisson, turn = rng.uniform(0.0, 0.5), rng.uniform(-1.5, 1.5)
        c1, c2 = _solved(ratio, poisson, 0.0), _solved(1.0 / ratio, poisson, 0.0)
        table = [kalker.coefficients(g, poisson).c22 for g in (ratio, 1.0 / ratio)]
        # The tensor's error by errors of the table, taken out exactly.
        share = math.sin(turn) ** 2
        solved, tabulated = ((1.0 - share) / one + share / two for one, two in ((c1, c2), table))
        found = turned.lateral_coefficient(ratio, poisson, turn) * tabulated / solved
        assert_allclose(found, _solved(ratio, poisson, turn), rtol=error)


def test_aligned_patches_have_the_tables_coefficients():
    """Exactly along, to rounding across; a circle has no direction, and the sign of the turn does not matter."""
    ratios, turns = np.array([0.2, 0.7, 1.0, 3.0]), np.linspace(-1.5, 1.5, 7)
    c22 = kalker.coefficients(ratios, 0.3).c22
    assert_allclose(turned.lateral_coefficient(ratios, 0.3, 0.0), c22, rtol=0)
    assert_allclose(turned.lateral_coefficient(1.0 / ratios, 0.3, 0.5 * math.pi), c22, rtol=1e-12)
    assert_allclose(turned.lateral_coefficient(1.0, 0.3, turns), c22[2], rtol=1e-12)
    assert_allclose(turned.lateral_coefficient(1.7, 0.3, turns), turned.lateral_coefficient(1.7, 0.3, -turns), rtol=0)


def test_naming_the_other_axis_changes_nothing():
    for turn in (0.2, 0.8, 1.3):
        one = turned.lateral_coefficient(3.0, 0.3, turn)
        assert_allclose(turned.lateral_coefficient(1.0 / 3.0, 0.3, turn - 0.5 * math.pi), one, rtol=1e-12)


def test_the_stiffness_of_a_steered_wheel_is_continuous():
    """Also where the rotated patch renames its axes; there the coefficient of the patch without its turn jumps."""
    steel = iv.contact.bodies.Material(youngs_modulus=210e9, poisson=0.3)
    bearing = iv.load_study("hand_controller").drives["cobotic"].transmission.geometry.axle_bearing
    geometry = iv.transmission.ContactGeometry(
        crown_radius=0.02, wheel_material=steel, cylinder_material=steel, axle_bearing=bearing
    )
    angles = np.linspace(0.0, 0.5 * math.pi, 401)
    contact = geometry.press(wheel_radius=0.012, cylinder_radius=0.02, preload=500.0, steering_angle=angles)
    stiffness = contact.creep_stiffness
    assert np.max(np.abs(np.diff(contact.coefficients.c22))) > 0.1 * contact.coefficients.c22[0]
    assert np.max(np.abs(np.diff(stiffness))) < 0.005 * stiffness[0]
