"""Shakedown under repeated rolling: known limits, and the shear stress from point loads."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar.contact import hertz, shakedown
from sampled import sampled


@pytest.mark.source("johnson1985", "section 9.2")
def test_published_shakedown_pressures():
    """4.00 k for a line contact across the rolling direction; 4.7 k for a circle; k/mu where the surface yields first."""
    assert shakedown.shakedown_pressure(1e-6, 1e-3, 1.0) == pytest.approx(4.0, abs=0.005)
    assert shakedown.shakedown_pressure(1e-3, 1e-3, 1.0) == pytest.approx(4.7, abs=0.05)
    assert shakedown.shakedown_pressure(1e-3, 1e-3, 1.0, 0.4) == pytest.approx(2.5)
    assert shakedown.shakedown_pressure(1e-3, 1e-3, 1.0, 0.2) == shakedown.shakedown_pressure(1e-3, 1e-3, 1.0)


def test_line_contact_has_its_shear_at_half_of_its_half_width():
    shear, depth = shakedown.orthogonal_shear(1e-6, 1e-2)
    assert_allclose([shear, depth], [0.25, 0.5e-6], rtol=1e-4)


def _shear(a, b, x, z):
    """Shear stress between x and depth under a Hertz pressure of peak 1, summed over point loads."""
    angle, radius = np.meshgrid((np.arange(200) + 0.5) / 100.0 * np.pi, (np.arange(200) + 0.5) / 200.0)
    away, across = x - a * radius * np.cos(angle), b * radius * np.sin(angle)
    load = np.sqrt(1.0 - radius**2) * a * b * radius * (np.pi / 100.0) / 200.0
    distance = np.sqrt(away**2 + across**2 + z**2)
    return float(np.sum(1.5 / np.pi * load * away * z**2 / distance**5))


@sampled("ratio", [0.2, 0.5, 1.0, 2.0, 4.0], every=5)
def test_against_boussinesqs_point_loads(ratio):
    """No place near the middle of the patch has a larger shear, and its depth is where the formula says."""
    b = 1.0 / math.sqrt(ratio)
    a = ratio * b
    shear, depth = shakedown.orthogonal_shear(a, b)
    along = np.linspace(0.6, 1.2, 25) * a
    at_depth = [max(_shear(a, b, x, z) for x in along) for z in (0.8 * depth, depth, 1.25 * depth)]
    assert at_depth[1] == pytest.approx(shear, rel=2e-3)
    assert at_depth[1] > at_depth[0]
    assert at_depth[1] > at_depth[2]


def test_shakedown_lies_between_first_yield_and_its_double():
    """By the same criterion of Tresca: the double is an upper limit, as each point is free of stress between passes."""
    ratios = np.geomspace(0.05, shakedown.LONGEST, 25)
    ratios[-1] = shakedown.LONGEST  # without rounding
    first = 1.0 / hertz.largest_shear(ratios, 1.0, 1.0, 0.3)[0]
    found = shakedown.shakedown_pressure(ratios, 1.0, 1.0)
    assert np.all(found > 1.15 * first)
    assert np.all(found < 2.0 * first)
    assert np.isnan(shakedown.shakedown_pressure(2.1, 1.0, 1.0))


def test_on_the_sheet():
    (sheet, *_) = iv.contact_sheets(iv.load_study("hand_controller"))
    geometry, patch = sheet.drive.transmission.geometry, sheet.drive.transmission.contact.patch
    limit = shakedown.shakedown_pressure(patch.a, patch.b, 0.5 * geometry.wheel_material.yield_strength, 0.12)
    assert sheet.value("shakedown pressure, wheel") == pytest.approx(float(limit))
    assert limit > patch.peak_pressure
