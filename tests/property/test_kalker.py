"""Kalker's coefficients as functions: smooth, positive, monotonic, and the same over every array library."""

import array_api_strict as strict
import jax
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from infinivar.contact import kalker

jax.config.update("jax_enable_x64", True)

poissons = st.floats(0.0, 0.5)
moduli = st.floats(1e6, 1e12)
ratios = st.floats(-12.0, 12.0).map(lambda exponent: 10.0**exponent)


@given(ratios, poissons)
def test_positive_and_finite(a_over_b, poisson):
    values = np.asarray(kalker.coefficients(a_over_b, poisson))
    assert np.all(np.isfinite(values) & (values > 0))


@given(poissons)
def test_monotonic_in_the_axis_ratio(poisson):
    """As every column of the table: C22 and C23 rise with a/b, C33 falls, C11 rises from a/b = 0.5 on."""
    ratio = np.geomspace(0.1, 10.0, 2001)
    c11, c22, c23, c33 = kalker.coefficients(ratio, poisson)
    assert np.all(np.diff(c11[ratio >= 0.5]) > 0)
    assert np.all(np.diff(c22) > 0)
    assert np.all(np.diff(c23) > 0)
    assert np.all(np.diff(c33) < 0)


@given(ratios)
def test_monotonic_in_poissons_ratio(a_over_b):
    """More of it: stiffer against creepage, softer across the slender ellipse against spin."""
    poisson = np.linspace(0.0, 0.5, 101)
    c11, c22, c23, c33 = kalker.coefficients(a_over_b, poisson)
    assert np.all(np.diff(c11) > 0)
    if a_over_b > 0.1:
        assert np.all(np.diff(c22) > 0)
        assert np.all(np.diff(c23) > 0)
    if not 0.5 < a_over_b < 1.2:
        assert np.all(np.diff(c33) * (1 if a_over_b < 1 else -1) > 0)


def logarithms(exponent, poisson):
    return np.log(np.asarray(kalker.coefficients(np.exp(exponent), poisson)))


@given(st.sampled_from([-1.0, 1.0]), poissons)
def test_smooth_across_the_ends_of_the_table(side, poisson):
    """Value and slope of ln C over ln(a/b) from inside meet those from outside at a/b = 0.1 and 10."""
    end, step = side * np.log(10.0), 1e-5
    inner, at, outer = (logarithms(end + side * step * k, poisson) for k in (-1, 0, 1))
    # A kink would leave its jump in slope, of order 0.1; curvature of order 1 leaves a step.
    assert_allclose((outer - at) / step, (at - inner) / step, rtol=0, atol=20 * step)
    assert_allclose(outer, inner, rtol=0, atol=5 * step)


def traced_logarithms(exponent, poisson):
    return jax.numpy.log(jax.numpy.stack(kalker.coefficients(jax.numpy.exp(exponent), poisson)))


gradients = jax.jit(lambda *at: jax.numpy.stack(jax.jacrev(traced_logarithms, (0, 1))(*at), axis=-1))


@pytest.mark.slow
@given(st.floats(-7.0, 7.0) | st.sampled_from([0.0, *np.log([0.1, 0.5, 10.0])]), st.floats(0.01, 0.49))
def test_gradients(exponent, poisson):
    """jax.grad of ln C against central differences: inside and outside the table, at its nodes and ends."""
    step = 1e-5
    by_ratio = (logarithms(exponent + step, poisson) - logarithms(exponent - step, poisson)) / (2 * step)
    by_poisson = (logarithms(exponent, poisson + step) - logarithms(exponent, poisson - step)) / (2 * step)
    # Rounding leaves 1e-14/1e-5, a third derivative of order 10 leaves 1e-9, a jump of the second, at the ends, a step.
    atol = 1e-8 if abs(abs(exponent) - np.log(10.0)) > step else step
    found = np.asarray(gradients(exponent, poisson))
    assert_allclose(found[:, 0], by_ratio, rtol=0, atol=atol)
    assert_allclose(found[:, 1], by_poisson, rtol=1e-6, atol=1e-8)


@pytest.mark.slow
def test_array_libraries():
    ratio, poisson = np.geomspace(0.01, 100, 12).reshape(3, 4), np.array([0.0, 0.1, 0.3, 0.5])
    expected = kalker.coefficients(ratio, poisson)
    found = kalker.coefficients(strict.asarray(ratio), strict.asarray(poisson))
    compiled = jax.jit(kalker.coefficients)(ratio, poisson)
    for one, two, three in zip(expected, found, compiled, strict=True):
        assert one.shape == two.shape == three.shape == (3, 4)
        assert_allclose(np.asarray(two), one, rtol=1e-12)
        assert_allclose(np.asarray(three), one, rtol=1e-12)
    pair = kalker.combined(strict.asarray(8e10), 0.3, strict.asarray([7e10, 6e10]), 0.25)
    assert_allclose(np.asarray(pair[0]), kalker.combined(8e10, 0.3, np.array([7e10, 6e10]), 0.25)[0])


def test_outside_the_range():
    for a_over_b in (0.0, -1.0, np.nan, np.inf, np.array([1.0, -2.0])):
        with pytest.raises(ValueError, match=r"a_over_b must be > 0, got"):
            kalker.coefficients(a_over_b, 0.3)
    for poisson in (-0.1, 0.51, np.nan):
        with pytest.raises(ValueError, match=r"poisson must be >= 0 and <= 0.5, got"):
            kalker.coefficients(1.0, poisson)
        with pytest.raises(ValueError, match="poisson_2"):
            kalker.combined(1.0, 0.3, 1.0, poisson)
    with pytest.raises(ValueError, match=r"shear_modulus_1 must be > 0 Pa, got 0.0"):
        kalker.combined(0.0, 0.3, 1.0, 0.3)
    # Traced values are not known: nan, where they are no ellipse or no material.
    ratio, poisson = jax.numpy.asarray([1.0, -1.0, 0.0, 1.0]), jax.numpy.asarray([0.3, 0.3, 0.3, 0.6])
    found = np.asarray(jax.jit(kalker.coefficients)(ratio, poisson))
    assert np.all(np.isnan(found) == [False, True, True, True])


@given(moduli, poissons)
def test_equal_bodies_combine_to_themselves(shear_modulus, poisson):
    g, nu = kalker.combined(shear_modulus, poisson, shear_modulus, poisson)
    assert g == pytest.approx(shear_modulus, rel=1e-14)
    assert nu == poisson


@given(moduli, poissons, moduli, poissons)
def test_combined(g1, nu1, g2, nu2):
    """The definition, and what follows: order does not matter, values lie between, a rigid body doubles G."""
    g, nu = kalker.combined(g1, nu1, g2, nu2)
    assert 1 / g == pytest.approx((1 / g1 + 1 / g2) / 2, rel=1e-12)
    # A step from one ratio to the other is rounded as these are, not as a small result.
    assert nu == pytest.approx(g * (nu1 / g1 + nu2 / g2) / 2, rel=1e-12, abs=1e-15)
    assert_allclose(kalker.combined(g2, nu2, g1, nu1), (g, nu), rtol=1e-12, atol=1e-14)
    assert min(nu1, nu2) - 1e-15 <= nu <= min(max(nu1, nu2) + 1e-15, 0.5)
    assert kalker.combined(g1, nu1, 1e20 * g1, nu2) == (pytest.approx(2 * g1), pytest.approx(nu1))


def test_coefficients_follow_an_array_that_is_written_to():
    ratio = np.array([1.0, 2.0])
    before = kalker.coefficients(ratio, 0.3).c22[0]
    ratio[0] = 3.0
    after = kalker.coefficients(ratio, 0.3).c22[0]
    assert_allclose(after, kalker.coefficients(3.0, 0.3).c22, rtol=1e-12)
    assert after != before
