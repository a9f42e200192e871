"""Structure against a benchmark of shell elements and tabulated cases."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar import units
from internals import CylinderTube, beams, catalogue, ring_moments, shells


@pytest.mark.source("lindberg1969")
def test_pinched_cylinder():
    """Two opposite forces midway between diaphragms, R/t = 100, L/R = 2, nu = 0.3: w = 164.24 P/(E t) by a double series.

    The series is of another theory of thin shells, which differs by t/R: 0.1 %.
    """
    wall = shells.Wall(radius=100.0, thickness=1.0, length=200.0, youngs_modulus=1.0, poisson=0.3)
    assert shells.give(wall, 100.0, count=2) == pytest.approx(164.24, rel=1e-3)


@pytest.mark.source("young2002", "Table 11.4")
@pytest.mark.parametrize("area", [0.02, 0.08, 0.4])
def test_stress_of_a_flat_strip(area):
    """Case 1b for a/b = infinity, whose beta is 1.000: 3 W/(2 pi t^2) ((1 + nu) ln(2 b/(pi r0')) + beta) in the middle."""
    breadth, thickness, poisson = 10.0, 0.1, 0.3
    flat = shells.Wall(radius=1e6, thickness=thickness, length=breadth, youngs_modulus=1.0, poisson=poisson)
    small = math.sqrt(1.6 * area**2 + thickness**2) - 0.675 * thickness if area < 0.5 * thickness else area
    tabulated = 1.5 / (math.pi * thickness**2) * ((1.0 + poisson) * math.log(2.0 * breadth / (math.pi * small)) + 1.0)
    assert shells.tension(flat, 0.5 * breadth, area) == pytest.approx(tabulated, rel=1e-4)


@pytest.mark.source("young2002", "Table 11.4")
def test_deflection_of_a_flat_strip():
    """Case 1b for a/b = infinity: alpha W b^2/(E t^3) with alpha = 0.1851, rounded to 4 digits."""
    flat = shells.Wall(radius=1e6, thickness=0.1, length=10.0, youngs_modulus=1.0, poisson=0.3)
    assert shells.give(flat, 5.0) == pytest.approx(0.1851 * 10.0**2 / 0.1**3, rel=1e-3)


@pytest.mark.source("young2002", "Table 8.1")
def test_beam_between_two_supports():
    """Case 1e in the middle: the moment W L/4."""
    section = beams.Section(0.01, 0.007)
    second = math.pi * (0.01**4 - 0.007**4) / 4.0
    assert beams.stress(section, 0.3, 0.15) == pytest.approx(0.25 * 0.3 * 0.01 / second, rel=1e-12)


def test_tube_of_steel():
    """A tube of 50 mm radius, 5 mm wall and 100 mm length: 1.17 kg, 2.65 g m^2; end plates of 5 mm: 0.62 kg, by hand."""
    steel = iv.contact.Material(youngs_modulus=206e9, poisson=0.3, density=7850.0)
    tube = CylinderTube(radius=0.05, wall=0.005, length=0.1, material=steel)
    closed = CylinderTube(radius=0.05, wall=0.005, length=0.1, end_plate=0.005, material=steel)
    assert tube.mass == pytest.approx(7850.0 * math.pi * (0.05**2 - 0.045**2) * 0.1)
    assert (tube.mass, 1e3 * tube.inertia) == (pytest.approx(1.17, abs=0.005), pytest.approx(2.65, abs=0.005))
    assert closed.mass - tube.mass == pytest.approx(0.617, abs=0.001)
    assert closed.inertia - tube.inertia == pytest.approx(0.5 * (closed.mass - tube.mass) * 0.05**2)


@pytest.mark.parametrize("name", ["bearing-steel", "440c", "c45", "ti-6al-4v", "al-7075-t6"])
def test_heat_per_volume_is_density_times_heat_per_mass(name):
    """Specific heats of metals are 3 R/M of their main element within 20 % (Dulong and Petit): a check of both columns."""
    molar = {"bearing-steel": 55.85, "440c": 55.0, "c45": 55.85, "ti-6al-4v": 45.9, "al-7075-t6": 28.0}[name]
    row = catalogue.rows("materials")[name]
    heat, density = units.parse(row["heat_capacity"], "J/m^3/K"), units.parse(row["density"], "kg/m^3")
    assert heat / density == pytest.approx(3.0 * 8.314 / (1e-3 * molar), rel=0.2)


@pytest.mark.source("young2002", "Table 9.2")
@pytest.mark.parametrize("wheels", [2, 3])
def test_ring_by_integration(wheels):
    # Half a bay of a thin ring: N and M0 at the middle between loads; sections do not turn at both ends of it.
    load, radius, half = 1000.0, 0.08, math.pi / wheels
    middle = np.linspace(0.0, half, 200_001)
    middle = 0.5 * (middle[1:] + middle[:-1])
    across = 0.5 * load / math.sin(half)  # tension at the middle of a bay carries half a load at each end
    bent = across * radius * (1.0 - np.cos(middle))  # less M0
    least = np.mean(bent)
    at_load = across * radius * (1.0 - math.cos(half)) - least
    moment, tension = ring_moments(load, radius, wheels)
    assert_allclose(moment, at_load, rtol=1e-9)
    assert_allclose(tension, across * math.cos(half), rtol=1e-9, atol=1e-9)
