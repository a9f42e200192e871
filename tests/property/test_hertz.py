"""Limits and symmetries of Hertzian contacts, their friction and their elliptic integrals."""

import math

import array_api_strict as strict
import jax
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy import special

from infinivar.contact import Material, friction, hertz, hysteresis, spin, wear
from internals import ContactWheel as Wheel
from internals import Cylinder, elliptic

jax.config.update("jax_enable_x64", True)

moduli = st.floats(1e9, 1e12)
poissons = st.floats(0.0, 0.5)
loads = st.floats(1e-2, 1e5)
curvatures = st.floats(0.1, 1e5)
ratios = st.floats(-6, 6).map(lambda power: 10.0**power)


@given(ratios)
def test_elliptic_integrals_against_scipy(ratio):
    """scipy's Carlson forms are another algorithm."""
    plain, along_a, along_b, mixed = elliptic.ellipse_integrals(np.float64(ratio))
    g = ratio * ratio
    assert plain == pytest.approx(2 * special.elliprf(0, g, 1), rel=1e-13)
    assert along_a == pytest.approx(2 / 3 * special.elliprd(0, 1, g), rel=1e-13)
    assert along_b == pytest.approx(2 / 3 * special.elliprd(0, g, 1), rel=1e-13)
    if abs(1 - g) > 0.01:
        assert mixed == pytest.approx((along_a - along_b) / (1 - g), rel=1e-12)


@given(st.floats(0.98, 1.02))
def test_mixed_integral_near_the_circle(ratio):
    """Its integral over the angle has no singularity there: 32 midpoints are exact to rounding."""
    angle = np.pi / 2 * (np.arange(32) + 0.5) / 32
    root = np.sqrt((ratio * np.cos(angle)) ** 2 + np.sin(angle) ** 2)
    expected = np.pi / 2 * np.mean(2.0 * np.cos(angle) ** 4 / root**3)
    assert elliptic.ellipse_integrals(np.float64(ratio)).mixed == pytest.approx(expected, rel=1e-10)


@given(st.floats(1e-8, 1e3), st.floats(1e-8, 1e3), st.floats(1e-8, 1e3))
def test_carlson_against_scipy(x, y, z):
    assert elliptic.carlson_rd(np.float64(x), y, z) == pytest.approx(special.elliprd(x, y, z), rel=1e-12)
    assert elliptic.carlson_rd(np.float64(0), y, z) == pytest.approx(special.elliprd(0, y, z), rel=1e-12)


@given(loads, curvatures, moduli)
def test_equal_curvatures_make_a_circle(load, curvature, e_star):
    """johnson1985, Eqs 4.22-4.24 for a sphere of radius 1/c."""
    a, b, peak, approach = hertz.ellipse(load, curvature, curvature, e_star)
    radius = 1.0 / curvature
    expected = (0.75 * load * radius / e_star) ** (1 / 3)
    assert_allclose([a, b], expected, rtol=1e-12)
    assert peak == pytest.approx((6 * load * e_star**2 / (math.pi**3 * radius**2)) ** (1 / 3), rel=1e-12)
    assert approach == pytest.approx(expected**2 / radius, rel=1e-12)


@given(loads, curvatures, curvatures, moduli)
def test_ellipse_carries_the_load_and_closes_the_gap(load, along, across, e_star):
    """The pressure adds up to the load; x and y are alike; sizes go with the cube root of the load."""
    a, b, peak, approach = hertz.ellipse(load, along, across, e_star)
    assert 2 / 3 * math.pi * a * b * peak == pytest.approx(load, rel=1e-12)
    swapped = hertz.ellipse(load, across, along, e_star)
    assert_allclose(swapped, [b, a, peak, approach], rtol=1e-10)
    assert_allclose(hertz.ellipse(8 * load, along, across, e_star), [2 * a, 2 * b, 2 * peak, 4 * approach], rtol=1e-10)
    assert (a > b) == (along < across) or along == pytest.approx(across, rel=1e-9)
    # Surface displacement of the pressure at the rim, on both axes, is the approach less the gap: scipy's integrals.
    plain, along_a, along_b = _integrals(a, b)
    shift = 0.75 / math.pi * load / e_star
    assert shift * (plain - along_a * a * a) == pytest.approx(approach - along * a * a / 2, rel=1e-9)
    assert shift * (plain - along_b * b * b) == pytest.approx(approach - across * b * b / 2, rel=1e-9)


def _integrals(a, b):
    scale = max(a, b)
    a, b = a / scale, b / scale
    plain = 2 * special.elliprf(0, a * a, b * b) / scale
    along_a = 2 / 3 * special.elliprd(0, b * b, a * a) / scale**3
    along_b = 2 / 3 * special.elliprd(0, a * a, b * b) / scale**3
    return plain, along_a, along_b


@given(curvatures, moduli, st.floats(1e-9, 1e-7))
def test_a_long_ellipse_is_a_line_in_its_middle(curvature, e_star, thinness):
    """As the lateral curvature vanishes, pressure and half-width in the middle tend to those of a line contact."""
    a, _, peak, _ = hertz.ellipse(1.0, curvature, curvature * thinness, e_star)
    line_load = math.pi * a * peak / 2
    half_width, line_peak = hertz.line(line_load, 1.0 / curvature, e_star)
    assert (half_width, line_peak) == (pytest.approx(a, rel=1e-3), pytest.approx(peak, rel=1e-3))


steel = Material(youngs_modulus=210e9, poisson=0.3)
radii = st.floats(1e-3, 1.0)


@given(radii, radii, radii, loads)
def test_steering_from_circumference_to_axis(rolling_radius, crown, cylinder, load):
    """At 0 the cylinder adds to the rolling curvature, at 90 degrees to the lateral one; the sum of both never changes."""
    wheel = Wheel(rolling_radius=rolling_radius, crown_radius=crown, material=steel)
    body = Cylinder(radius=cylinder, material=steel)
    e_star = 210e9 / (2 * (1 - 0.09))
    locked, turned = (hertz.crossed(load, wheel, body, angle) for angle in (0.0, math.pi / 2))
    expected = hertz.ellipse(load, 1 / rolling_radius + 1 / cylinder, 1 / crown, e_star)
    assert_allclose(locked.ellipse, expected, rtol=1e-9)
    expected = hertz.ellipse(load, 1 / rolling_radius, 1 / crown + 1 / cylinder, e_star)
    assert_allclose(turned.ellipse, expected, rtol=1e-7)  # cos(pi/2) is 6e-17, which a circle magnifies
    assert locked.rotation == 0.0
    left, right = (hertz.crossed(load, wheel, body, angle) for angle in (-0.6, 0.6))
    assert_allclose(left.ellipse, right.ellipse, rtol=1e-12)
    assert left.rotation == -right.rotation


@given(radii, radii, loads, st.floats(-1.5, 1.5))
def test_ball_on_cylinder_does_not_care_how_it_is_steered(ball, cylinder, load, angle):
    """The patch turns with the cylinder: same ellipse, its axis at minus the steering angle from rolling."""
    wheel = Wheel(rolling_radius=ball, crown_radius=ball, material=steel)
    body = Cylinder(radius=cylinder, material=steel)
    locked, turned = hertz.crossed(load, wheel, body, 0.0), hertz.crossed(load, wheel, body, angle)
    small, large = sorted((locked.ellipse.a, locked.ellipse.b))
    assert sorted((turned.ellipse.a, turned.ellipse.b)) == pytest.approx([small, large], rel=1e-6)
    apart = (turned.rotation + angle) % (math.pi / 2)
    assert min(apart, math.pi / 2 - apart) == pytest.approx(0.0, abs=1e-5)


@given(ratios, poissons)
def test_stresses_at_the_surface(ratio, poisson):
    """Just below the surface the vertical stress is the pressure; an incompressible body is under pressure all round."""
    a, b = min(ratio, 1.0), min(1.0 / ratio, 1.0)
    sigma_x, sigma_y, sigma_z = hertz.axis_stresses(1e-8 * min(a, b), a, b, 1.0, poisson)
    assert sigma_z == pytest.approx(-1.0, abs=1e-6)
    # johnson1985, Eq 4.29 and its neighbours: -2 nu p0 - (1 - 2 nu) p0 b/(a + b) along a.
    assert sigma_x == pytest.approx(-2 * poisson - (1 - 2 * poisson) * b / (a + b), abs=1e-5)
    assert sigma_y == pytest.approx(-2 * poisson - (1 - 2 * poisson) * a / (a + b), abs=1e-5)
    shear, depth = hertz.largest_shear(a, b, 1.0, poisson)
    assert 0.25 <= shear <= 0.5
    assert 0.0 <= depth <= 0.8 * min(a, b)
    depths = np.append(np.linspace(1e-3, 2.0, 2000), depth / min(a, b) or 1e-9) * min(a, b)
    sigma_x, sigma_y, sigma_z = hertz.axis_stresses(depths, a, b, 1.0, poisson)
    assert shear == pytest.approx(np.max(0.5 * (np.maximum(sigma_x, sigma_y) - sigma_z)), rel=1e-6)


@given(loads, st.floats(1e-5, 1e-2), ratios, st.floats(0, 1))
def test_moments_of_the_patch(load, size, ratio, coefficient):
    """A circle gives 3 pi/16 mu P a, a thin ellipse 3/8 mu P b: a quarter less than a uniform line of its length."""
    circle = spin.ellipse_moment(load, size, size, coefficient)
    assert circle == pytest.approx(3 * math.pi / 16 * coefficient * load * size, rel=1e-12)
    thin = spin.ellipse_moment(load, 1e-6 * size, size, coefficient)
    assert thin == pytest.approx(0.75 * spin.line_moment(load, size, coefficient), rel=1e-9)
    a, b = size, size / ratio
    moment = spin.ellipse_moment(load, a, b, coefficient)
    large = max(a, b)
    expected = 0.375 * coefficient * load * large * special.ellipe(1 - (min(a, b) / large) ** 2)
    assert moment == pytest.approx(expected, rel=1e-12)


@pytest.mark.source("faulring2006", "Eq 10", "Eq 11", "Eq 12")
@given(loads, st.floats(1e-5, 1e-2), st.floats(0, 1))
def test_hysteresis_is_the_work_on_the_front_half(load, a, factor):
    """Both closed forms against the integral of pressure times distance over the half patch ahead."""
    x = (np.arange(20000) + 0.5) / 20000
    pressure = np.sqrt(1 - x * x)
    line = load * factor * a * np.mean(x * pressure) / (2 * np.mean(pressure))
    assert hysteresis.line_torque(load, a, factor) == pytest.approx(line, rel=1e-5)
    # An ellipse is full of lines: pressure integrated over y at x goes with 1 - x^2.
    ellipse = load * factor * a * np.mean(x * pressure**2) / (2 * np.mean(pressure**2))
    assert hysteresis.ellipse_torque(load, a, factor) == pytest.approx(ellipse, rel=1e-5)


@given(poissons, poissons, moduli, moduli, st.floats(0, 1), st.floats(0, 1))
def test_hysteresis_of_unlike_bodies_lies_between(nu_1, nu_2, e_1, e_2, factor_1, factor_2):
    one = Material(youngs_modulus=e_1, poisson=nu_1, hysteresis_factor=factor_1)
    two = Material(youngs_modulus=e_2, poisson=nu_2, hysteresis_factor=factor_2)
    low, high = sorted((factor_1, factor_2))
    assert low - 1e-15 <= hysteresis.combined_hysteresis(one, two) <= high + 1e-15
    assert hysteresis.combined_hysteresis(one, one) == pytest.approx(factor_1)


@given(st.floats(-100, 100), st.floats(0.01, 1), st.floats(0.1, 1), st.floats(0.01, 10))
def test_friction_falls_between_its_limits(speed, at_rest, ratio, decay):
    value = friction.falling(speed, at_rest, ratio, decay)
    assert at_rest * ratio * (1 - 1e-12) <= value <= at_rest * (1 + 1e-12)
    assert value == friction.falling(-speed, at_rest, ratio, decay)
    assert friction.falling(0.0, at_rest, ratio, decay) == pytest.approx(at_rest)
    assert friction.falling(1e6, at_rest, ratio, decay) == pytest.approx(at_rest * ratio)


@given(st.floats(1, 100), st.floats(1e-5, 1e-2), st.floats(1e-8, 1e-2))
def test_wear_by_hand(force, creepage, coefficient):
    """Archard written out: volume = k x load x sliding distance / hardness, load x distance = friction work / mu."""
    depth, radius, width, mu, hardness = 1e-5, 0.01, 6e-4, 0.12, 7e9
    distance = wear.rolling_distance(depth, radius, width, force, creepage, mu, hardness, coefficient)
    worn = coefficient * (force * creepage * distance / mu) / hardness
    assert worn == pytest.approx(depth * 2 * math.pi * radius * width, rel=1e-12)
    assert wear.rolling_distance(depth, radius, width, 0.0, creepage, mu, hardness, coefficient) == math.inf


@pytest.mark.slow
def test_array_libraries_and_gradients():
    """The strict standard library gives the same; JAX gives b ~ P^(1/3), also at the circle."""
    expected = hertz.ellipse(100.0, np.array([50.0, 120.0, 400.0]), 120.0, 1e11)
    found = hertz.ellipse(100.0, strict.asarray([50.0, 120.0, 400.0]), 120.0, 1e11)
    for ours, theirs in zip(found, expected, strict=True):
        assert_allclose(np.asarray(ours), theirs, rtol=1e-12)
    stressed = hertz.largest_shear(strict.asarray(1.0), 2.0, 1.0, 0.3)
    assert_allclose([float(part) for part in stressed], hertz.largest_shear(1.0, 2.0, 1.0, 0.3), rtol=1e-9)
    size = jax.value_and_grad(lambda load, curvature: hertz.ellipse(load, curvature, 120.0, 1e11).b)
    along = jax.grad(lambda curvature: hertz.ellipse(100.0, curvature, 120.0, 1e11).a)
    curvatures = np.array([50.0, 120.0, 400.0])
    (b, slope), by_curvature = jax.jit(jax.vmap(lambda curvature: (size(100.0, curvature), along(curvature))))(
        curvatures
    )
    assert_allclose(slope, b / 300.0, rtol=1e-9)
    step = 1e-4 * curvatures
    difference = [hertz.ellipse(100.0, curvatures + sign * step, 120.0, 1e11).a for sign in (1, -1)]
    assert_allclose(by_curvature, (difference[0] - difference[1]) / (2 * step), rtol=1e-6)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((-1.0, 1.0, 1.0, 1e9), "load must be > 0 N, got -1"),
        ((1.0, 0.0, 1.0, 1e9), "curvature_x must be > 0 1/m, got 0"),
        ((1.0, 1.0, math.nan, 1e9), "curvature_y must be > 0 1/m, got nan"),
        ((1.0, 1.0, 1.0, 0.0), "e_star must be > 0 Pa, got 0"),
    ],
)
def test_arguments_out_of_range_are_refused(arguments, said):
    with pytest.raises(ValueError, match=said):
        hertz.ellipse(*arguments)
