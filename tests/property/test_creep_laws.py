"""What every creep law must do whatever the numbers."""

import pickle
from dataclasses import replace

import array_api_strict as strict
import jax
import numpy as np
import pytest
from designs import seeds
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from infinivar.contact import creep
from internals import shipped_study, study_from
from sampled import examples, sampled

jax.config.update("jax_enable_x64", True)

EPS = np.finfo(float).eps
BENT = ("vermeulen-johnson", "polach", "fastsim", "exact")
laws = st.sampled_from(list(creep.LAWS))


def ratios(seed, size=500):
    """Force ratios of either sign over the whole range, tiny ones and ones next to slip among them."""
    random = np.random.default_rng(seed)
    spread = random.choice([-1, 1], size) * 10 ** random.uniform(-12, 0, size)
    return np.concatenate([random.uniform(-1, 1, size), spread, np.sign(spread) * (1 - np.abs(spread))])


@given(laws, seeds)
def test_odd_passive_monotone_and_saturating(law, seed):
    k = np.sort(ratios(seed)) * 5.0
    force = creep.lateral_force(law, k)
    assert_array_equal(creep.lateral_force(law, -k), -force)
    assert np.all(force * k >= 0)
    assert np.all(np.diff(force) >= -4 * EPS)
    assert np.all(np.abs(force) <= 1.0)
    slip = creep.LAWS[law].slip_creepage / 3.0
    ends = [slip, 2 * slip, np.inf, -np.inf, -slip]
    assert_array_equal(creep.lateral_force(law, np.asarray(ends)), [1.0, 1.0, 1.0, -1.0, -1.0])
    if np.isfinite(slip):
        assert creep.lateral_force(law, 0.99 * slip) < 1.0


@given(laws, seeds)
def test_inverse(law, seed):
    """Both ways round. Near slip a rounding of the force is a change of the creepage `slope` times as large."""
    ratio = ratios(seed)
    k = creep.lateral_creep(law, ratio)
    assert_allclose(creep.lateral_force(law, k), ratio, rtol=8 * EPS, atol=0)
    assert_array_equal(creep.lateral_creep(law, -ratio), -k)
    again = creep.lateral_creep(law, creep.lateral_force(law, k))
    tolerance = 8 * EPS * (np.abs(k) + np.abs(ratio) * creep.LAWS[law].slope(ratio))
    assert np.all(np.abs(again - k) <= tolerance)


@given(laws, seeds)
def test_slope_is_the_derivative(law, seed):
    ratio = np.random.default_rng(seed).uniform(-0.99, 0.99, 500)
    found, step = creep.LAWS[law], 1e-6
    difference = (found.creepage(ratio + step) - found.creepage(ratio - step)) / (2 * step)
    # Truncation is step^2 times the third derivative, which is below 1e7 up to 0.99.
    assert_allclose(found.slope(ratio) * np.ones_like(ratio), difference, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("law", creep.LAWS)
def test_small_creepage_is_kalkers(law):
    """All laws start with the linear force, 3 k."""
    k = np.asarray([1e-9, -1e-7])
    assert_allclose(creep.lateral_force(law, k), 3.0 * k, rtol=1e-6)
    assert_allclose(creep.lateral_creep(law, 3.0 * k), k, rtol=1e-6)
    assert creep.LAWS[law].slope(np.float64(0.0)) == pytest.approx(1.0, abs=4 * EPS)


@pytest.mark.parametrize("law", BENT)
def test_at_slip_and_beyond(law):
    """Constant creepage, no slope: an iteration that overshoots stays finite. The slope just before is capped."""
    found = creep.LAWS[law]
    beyond = np.asarray([1.0, 1.0 + EPS, 2.0, 1e6, np.inf])
    creepage = found.creepage(np.concatenate([beyond, -beyond]))
    assert np.all(np.isfinite(creepage))
    assert_array_equal(np.abs(creepage), creepage[0])
    assert creepage[0] >= found.creepage(np.float64(1.0 - EPS))
    assert_array_equal(found.slope(beyond[1:]), 0.0)
    assert 1e9 < found.slope(np.float64(1.0)) < np.inf
    assert np.isnan(found.creepage(np.float64(np.nan)))
    slip = found.slip_creepage / 3.0
    found_slip = creep.lateral_creep(law, np.asarray([1.0, -1.0, 1.01, -2.0]))
    assert_allclose(found_slip, [slip, -slip, np.nan, np.nan], rtol=1e-14)


@sampled("law", BENT, every=4)
def test_gradients(law):
    """jax.grad of creepage and force, at zero too."""
    found = creep.LAWS[law]
    ratio = np.append(np.random.default_rng(1).uniform(-0.999, 0.999, 500), [0.0, 0.999, -0.999])
    gradient = jax.jit(jax.vmap(jax.grad(found.creepage)))(ratio)
    # The derivative of an iteration is one order behind its value, and near slip both feel the rounding of 1 - x.
    assert_allclose(gradient, found.slope(ratio), rtol=1e-9)
    assert_allclose(
        jax.jit(jax.vmap(jax.grad(found.force)))(found.creepage(ratio)), 1.0 / found.slope(ratio), rtol=1e-9
    )
    for function in (found.creepage, found.slope, found.force):
        assert np.all(np.isfinite(jax.jit(jax.vmap(jax.grad(function)))(np.asarray([1.0, -1.0, 1.5, 40.0]))))


@given(seeds)
@examples(10)
def test_laws_use_only_the_standard(seed):
    ratio = ratios(seed, 50)
    for name, found in creep.LAWS.items():
        for function in (found.creepage, found.slope, found.force):
            assert_allclose(np.asarray(function(strict.asarray(ratio))), function(ratio), rtol=1e-14)
        again = creep.lateral_creep(name, strict.asarray(ratio), strict.asarray(2.0))
        assert_allclose(np.asarray(again), creep.lateral_creep(name, ratio, 2.0), rtol=1e-14)


def test_misuse_is_named():
    with pytest.raises(
        ValueError, match=r"creep_law must be one of linear, .*, got 'polack' \(did you mean 'polach'\?\)"
    ):
        creep.lateral_force("polack", 0.1)


@pytest.mark.parametrize("shape", [(0,), (3, 0), (0, 2)])
def test_no_contacts_give_no_forces(shape):
    """A selection of contacts may be empty: nothing is left to be computed, in the shape asked for."""
    none = np.zeros(shape)
    for law in creep.LAWS:
        assert creep.lateral_force(law, none).shape == shape
        assert creep.lateral_creep(law, none).shape == shape


@pytest.mark.parametrize("name", creep.LAWS)
def test_a_law_is_a_value(name):
    """By name or as itself: to the public functions, to a wheel, and in a study, where it is parsed once."""
    law = creep.LAWS[name]
    assert creep.law(name) is creep.law(law) is law
    assert (law.name, str(law), repr(law)) == (name, name, f"CreepLaw({name!r})")
    sent = pickle.loads(pickle.dumps(law))
    assert sent == law
    assert hash(sent) == hash(law)
    assert [other for other in creep.LAWS.values() if other == law] == [law]
    k = np.linspace(-1.5, 1.5, 30)  # without 0, where infinity times nothing warns
    assert_array_equal(creep.lateral_force(law, k), creep.lateral_force(name, k))
    assert_array_equal(creep.lateral_creep(law, 0.5 * k), creep.lateral_creep(name, 0.5 * k))
    drive = shipped_study("faulring2006").drives["cobotic"]
    by_name, by_value = (replace(drive.transmission, creep_law=given) for given in (name, law))
    assert by_name == by_value
    assert by_name.creep_law is law
    assert pickle.loads(pickle.dumps(by_value)) == by_name
    raw = {
        "requirement": {"base": "faulring2006"},
        "drives": {"mine": {"base": "faulring2006.cobotic", "transmission": {"creep_law": name}}},
    }
    study = study_from(raw, name="laws", origin="test")
    assert study.drives["mine"].transmission.creep_law is law
    (row,) = [row for row in study.provenance if row.field == "transmission.creep_law"]
    assert (row.value, row.written) == (name, name)


def test_a_wheel_takes_any_law():
    """Its formulas are used as they are, without being registered anywhere."""
    softer = creep.CreepLaw(
        name="softer",
        creepage=lambda ratio: ratio + ratio * np.abs(ratio),
        slope=lambda ratio: 1.0 + 2.0 * np.abs(ratio),
        force=lambda xi: np.sign(xi) * 0.5 * (np.sqrt(1.0 + 4.0 * np.minimum(np.abs(xi), 2.0)) - 1.0),
        slip_creepage=2.0,
    )
    element = replace(shipped_study("faulring2006").drives["cobotic"].transmission, creep_law=softer)
    linear = replace(element, creep_law="linear")
    setting = {"cylinder_speed": 14.0, "steering_angle": 0.0, "link_force": 30.0}
    point, plain = element.operate(**setting), linear.operate(**setting)
    ratio = float(abs(point.lateral_force)) / (element.friction * element.preload)
    assert float(point.link_speed) == pytest.approx((1.0 + ratio) * float(plain.link_speed), rel=1e-9)


def test_the_law_of_a_wheel_that_names_none():
    """Exact theory where the patch is known, the paper's linear law where only measured values are."""
    element = shipped_study("faulring2006").drives["cobotic"].transmission
    assert replace(element, creep_law=None).creep_law is creep.EXACT
    groups = element.groups(14.0)
    named = ("creep_stiffness", "rolling_torque", "bearing_torque")
    measured = {name: getattr(groups, name) for name in named}
    assert replace(element, creep_law=None, geometry=None, **measured).creep_law is creep.LINEAR
    raw = {
        "requirement": {"base": "faulring2006"},
        "drives": {"mine": {"base": "faulring2006.cobotic"}},
    }
    stated = study_from(raw, name="laws", origin="test")
    assert stated.drives["mine"].transmission.creep_law is creep.LINEAR


@pytest.mark.parametrize("wrong", ["polack", 5, ["linear"]])
def test_what_is_no_law_is_refused(wrong):
    element = shipped_study("faulring2006").drives["cobotic"].transmission
    with pytest.raises(ValueError, match="creep_law must be one of linear, faulring"):
        replace(element, creep_law=wrong)
