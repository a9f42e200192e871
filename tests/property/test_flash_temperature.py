"""Flash temperature: exact limits, the integral of moving point sources, and where the heat is released."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad
from scipy.optimize import brentq

import infinivar as iv
from infinivar.contact import flash
from sampled import sampled

K, C = 46.0, 3.7e6


def _jaeger(a, b, speed):
    """Largest temperature along the middle of a source shaped like the Hertz pressure, per watt, by point sources.

    In polar coordinates about each point the singularity cancels; radii are clustered at it.
    """
    angle = (np.arange(360) + 0.5) / 180.0 * np.pi
    cosine, sine = np.cos(angle)[:, None], np.sin(angle)[:, None]
    node, weight = np.polynomial.legendre.leggauss(80)
    node, weight = 0.5 * (node + 1.0), 0.5 * weight
    square, hottest = (cosine / a) ** 2 + (sine / b) ** 2, 0.0
    for x in np.linspace(-a, a, 41):
        half = x * cosine / a**2
        rim = (-half + np.sqrt(np.maximum(half**2 - square * ((x / a) ** 2 - 1.0), 0.0))) / square
        radius, step = rim * node**3, 3.0 * rim * node**2 * weight
        place = x + radius * cosine
        flux = 1.5 / (np.pi * a * b) * np.sqrt(np.maximum(1.0 - (place / a) ** 2 - (radius * sine / b) ** 2, 0.0))
        reach = np.exp(-0.5 * speed * C / K * (radius + place - x))
        hottest = max(hottest, float(np.sum(flux * reach * step)) / (360.0 * K))
    return hottest


@sampled(("ratio", "error"), [(0.25, 0.06), (0.5, 0.055), (1.0, 0.015), (2.0, 0.08), (4.0, 0.19)], every=5)
def test_against_moving_point_sources(ratio, error):
    """From Peclet number 0.1 to 300; the docstring states these errors."""
    b = 1e-3 / math.sqrt(ratio)
    a = ratio * b
    for peclet in (0.1, 1.0, 3.0, 10.0, 30.0, 300.0):
        speed = peclet * K / (C * a)
        assert_allclose(flash.resistance(a, b, speed, K, C), _jaeger(a, b, speed), rtol=error)


def test_limits_of_slow_and_fast_sources():
    """Peclet number 0: 3/(8 k a) for a circle. Infinity: heat flows straight into the depth, along the middle strip."""
    a = 0.4e-3
    assert_allclose(flash.resistance(a, a, 0.0, K, C), 3.0 / (8.0 * K * a), rtol=1e-12)
    assert_allclose(flash.resistance(a, 0.3e-3, 0.0, K, C), _jaeger(a, 0.3e-3, 0.0), rtol=1e-3)
    b, speed = 0.3e-3, 1e7

    def strip(place):
        """Integral of the flux over the root of the time since a point at `place` passed it."""
        return quad(lambda s: 2.0 * math.sqrt(max(1.0 - (place - s * s) ** 2, 0.0)), 0.0, math.sqrt(1.0 + place))[0]

    hottest = max(strip(place) for place in np.linspace(0.6, 0.7, 201))
    assert hottest == pytest.approx(flash.FAST, rel=1e-6)
    peak_flux = 1.5 / (math.pi * a * b)
    expected = peak_flux * hottest * math.sqrt(a / (math.pi * K * C * speed))
    assert_allclose(flash.resistance(a, b, speed, K, C), expected, rtol=1e-4)
    assert_allclose(flash.resistance(a, b, -speed, K, C), expected, rtol=1e-4)


def test_the_colder_body_takes_more_heat():
    """Both surfaces reach one temperature, and their shares of the heat add up to it."""
    steel, ceramic = flash.resistance(1e-3, 1e-3, 2.0, 46.0, 3.7e6), flash.resistance(1e-3, 1e-3, 2.0, 2.0, 2.5e6)
    rise = flash.temperature_rise(5.0, steel, ceramic)
    assert_allclose(rise / steel + rise / ceramic, 5.0)
    assert rise < 5.0 * steel < 5.0 * ceramic
    assert_allclose(flash.temperature_rise(5.0, steel, steel), 2.5 * steel)


def _fast_peak(flux, grid):
    """Largest temperature of fast strips under a flux in cells, up to a factor."""
    hottest = 0.0
    for heat, middle, length in zip(flux, grid.x, grid.length, strict=True):
        edge = middle[:, None] - 0.5 * length  # the trailing edge of each cell
        ahead = middle - edge
        since = np.sqrt(np.maximum(ahead + 0.5 * length, 0.0)) - np.sqrt(np.maximum(ahead - 0.5 * length, 0.0))
        hottest = max(hottest, float(np.max(2.0 * since @ heat)))
    return hottest


@pytest.mark.slow
@pytest.mark.parametrize(("load", "low", "high"), [(0.5, 1.9, 2.3), (0.9, 1.3, 1.45), (1.0, 0.99, 1.03)])
def test_heat_released_where_the_patch_slides(load, low, high):
    """The sheet spreads heat like the pressure and states twice its result at half the slip force; exact in gross slip."""
    patch = iv.contact.RollingPatch(1.03, 0.3, 0.0, 30)
    creepage = brentq(lambda one: patch.steady(0.0, one).fy - load, 0.0, 2.0, xtol=1e-5) if load < 1.0 else 5.0
    found = patch.steady(0.0, creepage)
    heat = np.sum(found.traction * found.slip, axis=0)
    heat, spread = (one / np.sum(one * found.grid.area) for one in (heat, found.grid.bound))
    assert low < _fast_peak(heat, found.grid) / _fast_peak(spread, found.grid) < high


def test_on_the_sheet():
    (sheet, *_) = iv.contact_sheets(iv.load_study("hand_controller"))
    wheel, patch = sheet.drive.transmission, sheet.drive.transmission.contact.patch
    steel = wheel.geometry.wheel_material
    speed = wheel.cylinder_radius * sheet.drive.cylinder_speed
    found = flash.resistance(patch.a, patch.b, speed, steel.conductivity, steel.heat_capacity)
    point = wheel.operate(
        cylinder_speed=sheet.drive.cylinder_speed, steering_angle=0.0, link_force=0.5 * wheel.slip_force
    )
    assert sheet.value("creep power") == pytest.approx(float(point.losses["creep"]), rel=1e-9)
    assert sheet.value("flash temperature") == pytest.approx(0.5 * found * float(point.losses["creep"]), rel=1e-9)
