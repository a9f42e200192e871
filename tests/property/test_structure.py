"""Walls of tubes against their double series by brute force, and what must grow with what."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.special import j1

import infinivar as iv
from internals import CylinderTube, beams, shells
from sampled import examples, sampled

STEEL = iv.contact.Material(youngs_modulus=206e9, poisson=0.3, density=7850.0)
WALLS = [(0.0475, 0.005, 0.1), (0.0235, 0.003, 0.1), (0.0135, 0.003, 0.1), (0.05, 0.001, 0.3)]


def series(wall, place, count, area=None, terms=(2000, 3000)):
    """Terms of w under the force for waves along and around, with s and the wave numbers along: the sum that has a closed form.

    On an area, each term is that of the force times 2 J1(r q)/(r q), the mean of a wave of number q over a circle.
    """
    radius, thickness, length, modulus, poisson = wall
    rigid = modulus * thickness**3 / (12.0 * (1.0 - poisson**2))
    along = np.arange(1, terms[0] + 1)[:, None] * np.pi / length
    around = np.arange(0, terms[1] + 1, count)[None, :] / radius
    s = along**2 + around**2
    stiff = rigid * (s - radius**-2.0) ** 2 + modulus * thickness / radius**2 * along**4 / s**2
    w = count / (np.pi * radius * length) * np.where(around == 0, 1.0, 2.0) * np.sin(along * place) ** 2 / stiff
    if area is not None:
        small = np.sqrt(1.6 * area**2 + thickness**2) - 0.675 * thickness if area < 0.5 * thickness else area
        w *= 2.0 * j1(small * np.sqrt(s)) / (small * np.sqrt(s))
    return w, along, around, rigid


@sampled("wall", WALLS, every=2)
@pytest.mark.parametrize("count", [1, 2, 3])
def test_give_is_the_double_series(wall, count):
    """What a round tube bends as a beam is the waves n = 1. Both are cut off: 5e-4, where the force is near an end."""
    wall = shells.Wall(*wall, 206e9, 0.3)
    for share in (0.5, 0.2, 0.07):
        terms, *_ = series(wall, share * wall.length, count)
        if count == 1:
            terms[:, 1] = 0.0
        assert shells.give(wall, share * wall.length, count) == pytest.approx(terms.sum(), rel=5e-4)


@sampled(("wall", "count", "area"), [(WALLS[3], 1, 2e-3), (WALLS[1], 1, 5e-4), (WALLS[0], 2, 2e-3)], every=3)
def test_tension_is_that_of_the_double_series(wall, count, area):
    """The closed form takes an area as small beside the curvature: 2 %."""
    wall = shells.Wall(*wall, 206e9, 0.3)
    w, along, around, rigid = series(wall, 0.3 * wall.length, count, area, terms=(2000, 3000))
    s = along**2 + around**2
    bent = (
        rigid * np.sum((along**2 + wall.poisson * around**2) * w),
        rigid * np.sum((around**2 - wall.radius**-2.0 + wall.poisson * along**2) * w),
    )
    scale = wall.youngs_modulus / wall.radius
    thrust = (scale * np.sum((along * around / s) ** 2 * w), scale * np.sum((along**2 / s) ** 2 * w))
    expected = max(6.0 * m / wall.thickness**2 - n for m, n in zip(bent, thrust, strict=True))
    assert shells.tension(wall, 0.3 * wall.length, area, count) == pytest.approx(expected, rel=0.02)


def test_a_long_tube_bends_as_a_beam():
    """W L^3/(48 E I) of young2002, Table 8.1, case 1e: what it leaves out is shear, 2 (pi R/L)^2 = 2e-4."""
    wall = shells.Wall(0.01, 0.0005, 3.0, 206e9, 0.3)
    section = beams.Section(0.01025, 0.00975)
    assert shells.bend(wall, 1.5) == pytest.approx(3.0**3 / (48.0 * 206e9 * section.second_moment), rel=1e-3)


@pytest.mark.parametrize(("thickness", "length"), [(0.001, 1.0), (0.003, 1.0), (0.00025, 0.5)])
def test_long_and_thin_tubes_have_terms_enough(thickness, length):
    """Bending, ovalisation and their sum against the double series, at the ends of the range that a study may state."""
    wall = shells.Wall(0.05 - 0.5 * thickness, thickness, length, 206e9, 0.3)
    terms, *_ = series(wall, 0.5 * length, 1, terms=(3000, 1500))
    once = terms[:, 1].sum()
    assert shells.bend(wall, 0.5 * length) == pytest.approx(once, rel=1e-3)
    assert shells.give(wall, 0.5 * length) == pytest.approx(terms.sum() - once, rel=2e-3)
    w, along, around, rigid = series(wall, 0.5 * length, 1, 1e-3, terms=(3000, 1500))
    moment = rigid * np.sum((around**2 - wall.radius**-2.0 + wall.poisson * along**2) * w)
    thrust = wall.youngs_modulus / wall.radius * np.sum(along**4 / (along**2 + around**2) ** 2 * w)
    assert shells.tension(wall, 0.5 * length, 1e-3) == pytest.approx(6.0 * moment / thickness**2 - thrust, rel=0.05)


def test_arrays_and_numbers_agree():
    """Of several walls the longest and thinnest sets the number of terms: 1e-5 of displacements, 5e-4 of tensions."""
    radius = np.array([0.03, 0.05])
    wall = shells.Wall(radius, 0.003, np.array([[0.1], [0.3]]), 206e9, 0.3)
    both = shells.give(wall, 0.04), shells.tension(wall, 0.04, 1e-3, 2)
    for (row, column), one in np.ndenumerate(both[0]):
        alone = shells.Wall(radius[column], 0.003, (0.1, 0.3)[row], 206e9, 0.3)
        assert_allclose(one, shells.give(alone, 0.04), rtol=1e-4)
        assert_allclose(both[1][row, column], shells.tension(alone, 0.04, 1e-3, 2), rtol=1e-3)


RADII = st.floats(0.008, 0.1)
SHARES = st.floats(0.02, 0.3)


@given(RADII, SHARES, st.floats(1.0, 8.0), st.floats(0.1, 0.9))
@examples(200)
def test_all_is_positive_and_monotone(radius, share, slender, place):
    """A thicker wall is heavier, gives way less and is stressed less."""
    length = slender * radius

    def tube(wall):
        return CylinderTube(radius=radius, wall=wall, length=length, material=STEEL)

    thin, thick = tube(share * radius), tube(1.2 * share * radius)
    at = place * length
    for value in (
        thin.mass,
        thin.inertia,
        thin.bending(at),
        thin.ovalisation(at),
        thin.tension(at, 5e-4),
        thin.first_mode,
    ):
        assert 0.0 < value < np.inf
    assert thick.mass > thin.mass
    assert thick.inertia > thin.inertia
    assert thick.ovalisation(at) < thin.ovalisation(at)
    assert thick.tension(at, 5e-4) < thin.tension(at, 5e-4)
    assert thick.bending(at) < thin.bending(at)
    # Forces that are shared evenly around hold each other.
    assert thin.ovalisation(at, 3) > 0.0
