"""Bearings at random: limits, symmetries, growth with load, power balance, array libraries and gradients."""

import math
from dataclasses import replace

import array_api_strict as strict
import jax
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from infinivar.parts import Bearing
from internals import BearingPair
from sampled import examples, sampled

jax.config.update("jax_enable_x64", True)

POINTS = 300
SERIES = ("2", "43", "60", "62", "63", "64", "160", "628", "619")
KINDS = [("deep_groove", series, "skf") for series in SERIES]
KINDS += [("angular_contact", "other", "skf"), ("thrust_ball", "other", "skf")]
KINDS += [(kind, "other", "coefficient") for kind in ("deep_groove", "angular_contact", "cylindrical", "needle")]
RADIAL = [kind for kind in KINDS if kind[0] != "thrust_ball"]
SOURCES = ("rolling", "sliding", "seal", "drag")

seeds = st.integers(0, 2**32 - 1)


@st.composite
def bearings(draw, kinds=KINDS, wet=False):
    """A bearing from 3 to 100 mm bore; its ratings go with its size as catalogue bearings' do."""
    kind, series, model = draw(st.sampled_from(kinds))
    bore = draw(st.floats(0.003, 0.1))
    outside = bore * draw(st.floats(1.4, 3.0))
    rating = draw(st.floats(0.5, 2.0)) * 3e7 * (outside - bore) * bore**0.5 * outside**0.5
    bath = {"lubrication": "oil_bath", "oil_level": draw(st.floats(0.01, 2)) * bore, "drag_factor": 5e-4} if wet else {}
    return Bearing(
        type=kind,
        series=series,
        friction_model=model,
        bore=bore,
        outside_diameter=outside,
        dynamic_rating=rating,
        static_rating=rating * draw(st.floats(0.3, 0.8)),
        viscosity=draw(st.floats(2e-6, 500e-6)),
        seal_torque=draw(st.floats(0, 0.05)),
        **bath,
    )


def loads(bearing, seed):
    """Radial and axial loads up to half the rating and speeds, of either sign; some are exactly zero."""
    random = np.random.default_rng(seed)
    radial, axial = random.uniform(-0.5, 0.5, (2, POINTS)) * bearing.dynamic_rating
    speed = random.uniform(-500, 500, POINTS)
    for values in (radial, axial, speed):
        values[random.random(POINTS) < 0.2] = 0.0
    return radial, axial, speed


@given(bearings(), seeds)
def test_friction_takes_power_and_does_not_care_for_signs(bearing, seed):
    radial, axial, speed = loads(bearing, seed)
    moment = bearing.moment(radial, axial, speed)
    mirrored = bearing.moment(-radial, np.abs(axial), -speed)
    for source in SOURCES:
        values = getattr(moment, source)
        assert values.shape == speed.shape
        assert np.all(np.isfinite(values))
        assert np.all(values >= 0)
        assert_allclose(getattr(mirrored, source), values, rtol=0, atol=0)
    assert np.all(moment.total * np.abs(speed) >= 0)
    assert_allclose(moment.total, sum(getattr(moment, source) for source in SOURCES), rtol=1e-15)


@given(bearings(RADIAL), seeds, st.floats(0.005, 0.2), st.booleans())
def test_pair_takes_power_in_every_quadrant(bearing, seed, span, tilts):
    pair = BearingPair(bearing=bearing, span=span if tilts else None)
    random = np.random.default_rng(seed)
    preload = random.uniform(0, 0.5, POINTS) * bearing.dynamic_rating
    lateral, speed = random.uniform(-1, 1, POINTS) * preload, random.uniform(-500, 500, POINTS)
    moment = pair.moment(preload, lateral, 0.03, speed)
    assert np.all(moment.total * np.abs(speed) >= 0)
    for sign_lateral, sign_speed in ((1, -1), (-1, 1), (-1, -1)):
        quadrant = pair.moment(preload, sign_lateral * lateral, 0.03, sign_speed * speed)
        assert_allclose(quadrant.total, moment.total, rtol=1e-14)
    # What the bearings carry is what the axle bears, and the more loaded one locates it.
    (radial_1, axial_1), (radial_2, axial_2) = pair.loads(preload, lateral, 0.03)
    tilt = lateral * 0.03 / span if tilts else np.zeros(POINTS)
    upright = np.abs(tilt) < 0.5 * preload
    assert_allclose((radial_1 + radial_2)[upright], preload[upright], rtol=1e-12)
    assert_allclose(np.abs(radial_1 - radial_2)[~upright], preload[~upright], rtol=1e-9, atol=1e-9 * np.max(preload))
    assert_allclose(axial_1 + axial_2, np.abs(lateral), rtol=1e-15)
    assert np.all(np.where(axial_1 > 0, radial_1 >= radial_2, radial_2 >= radial_1))


@given(bearings(), seeds)
def test_moment_grows_and_life_falls_with_load(bearing, seed):
    radial, axial, speed = (np.abs(values) for values in loads(bearing, seed))
    more = 1.0 + np.random.default_rng(seed).uniform(0.001, 1.0, POINTS)
    heavier = ((radial * more, axial), (radial, axial * more), (radial * more, axial * more))
    before, life, safety = (
        bearing.moment(radial, axial, speed), bearing.life(radial, axial), bearing.static_safety(radial, axial)
    )  # fmt: skip
    for loads_after in heavier:
        after = bearing.moment(*loads_after, speed)
        for source in SOURCES:
            assert np.all(getattr(after, source) >= getattr(before, source) * (1 - 1e-12))
        assert np.all(bearing.life(*loads_after) <= life * (1 + 1e-12))
        assert np.all(bearing.static_safety(*loads_after) <= safety * (1 + 1e-12))


@given(bearings([kind for kind in KINDS if kind[2] == "coefficient"]), st.floats(1, 1e5), st.floats(0.01, 100))
def test_simple_rule_is_proportional(bearing, radial, factor):
    friction = bearing.moment(radial, 0.0, 20.0).sliding
    assert float(bearing.moment(factor * radial, 0.0, 20.0).sliding) == pytest.approx(factor * float(friction))
    assert float(bearing.moment(radial, 0.0, 0.0).sliding) == float(friction)
    twice = replace(bearing, friction_coefficient=0.004)
    share = 0.004 * 0.5 * radial * bearing.bore
    assert float(twice.moment(radial, 0.0, 20.0).sliding) == pytest.approx(share)


@given(bearings([kind for kind in KINDS if kind[:2] != ("angular_contact", "other") and kind[2] == "skf"]), seeds)
def test_film_takes_sliding_from_boundary_to_full_film(bearing, seed):
    """Angular contact bearings are left out: there the balls' centrifugal force adds to the load."""
    random = np.random.default_rng(seed)
    radial, axial = random.uniform(0.01, 0.3, (2, POINTS)) * bearing.dynamic_rating
    rest = bearing.moment(radial, axial, 0.0)
    assert_allclose(bearing.starting_moment(radial, axial), rest.sliding + bearing.seal_torque, rtol=1e-15)
    assert np.all(rest.rolling == 0)
    unit = rest.sliding / bearing.starting_friction
    slow, fast = bearing.moment(radial, axial, 1e-6), bearing.moment(radial, axial, 1e6)
    assert_allclose(slow.sliding, unit * bearing.boundary_friction, rtol=1e-5)
    assert_allclose(fast.sliding, unit * bearing.ehl_friction, rtol=1e-12)
    between = bearing.moment(radial, axial, random.uniform(0, 1e4, POINTS)).sliding / unit
    assert np.all((between >= bearing.ehl_friction * (1 - 1e-12)) & (between <= bearing.boundary_friction))


@given(bearings([kind for kind in KINDS if kind[0] == "deep_groove" and kind[2] == "skf"]), st.floats(0.01, 0.3))
def test_sliding_jumps_as_an_axial_load_appears(bearing, share):
    """The published model's own step: dm^-0.26 without axial load, dm^-0.145 with one, dm in mm."""
    radial = share * bearing.dynamic_rating
    mean = 500 * (bearing.bore + bearing.outside_diameter)
    without, touched = bearing.moment(radial, 0.0, 10.0), bearing.moment(radial, 1e-6 * radial, 10.0)
    assert float(touched.sliding / without.sliding) == pytest.approx(mean**0.115, rel=1e-6)
    # The rolling moment has no such step.
    assert float(touched.rolling / without.rolling) == pytest.approx(1.0, rel=1e-2)


@given(bearings(RADIAL), seeds)
def test_pair_lives_less_than_either_bearing(bearing, seed):
    pair = BearingPair(bearing=bearing, span=0.02)
    random = np.random.default_rng(seed)
    preload = random.uniform(0, 0.3, POINTS) * bearing.dynamic_rating
    lateral = random.uniform(-0.3, 0.3, POINTS) * preload
    first, second = pair.loads(preload, lateral, 0.01)
    lesser = np.minimum(bearing.life(*first), bearing.life(*second))
    life = pair.life(preload, lateral, 0.01)
    assert np.all(life <= lesser)
    roller = bearing.type in ("cylindrical", "needle")
    slope = 9 / 8 if roller else 10 / 9
    assert np.all(life >= lesser * 2 ** (-1 / slope) * (1 - 1e-12))
    equal = pair.life(preload, 0.0, 0.01)
    assert_allclose(equal, bearing.life(preload / 2, 0.0) * 2 ** (-1 / slope), rtol=1e-12)
    assert_allclose(
        pair.static_safety(preload, lateral, 0.01),
        np.minimum(bearing.static_safety(*first), bearing.static_safety(*second)),
        rtol=0,
    )


@given(bearings(RADIAL))
@examples(20)
def test_nothing_is_nan_without_load(bearing):
    pair = BearingPair(bearing=bearing)
    for speed in (0.0, 100.0):
        for axial in (0.0, 10.0):
            assert np.isfinite(bearing.moment(0.0, axial, speed).total)
        assert np.isfinite(pair.moment(0.0, 0.0, 0.03, speed).total)
    for part, none in ((bearing, (0.0, 0.0)), (pair, (0.0, 0.0, 0.03))):
        assert part.life(*none) == math.inf
        assert part.static_safety(*none) == math.inf
    resting = bearing.moment(0.0, 0.0, 0.0)
    assert float(resting.total) == pytest.approx(bearing.seal_torque)


@given(bearings([("deep_groove", "60", "skf"), ("angular_contact", "other", "skf")], wet=True), seeds)
@examples(20)
def test_oil_bath_drags_more_with_speed_and_depth(bearing, seed):
    radial, axial, speed = loads(bearing, seed)
    moment = bearing.moment(radial, axial, speed)
    assert np.all(np.isfinite(moment.drag))
    assert np.all((moment.drag > 0) == (speed != 0))
    assert np.all(bearing.moment(radial, axial, 1.5 * speed).drag >= moment.drag)
    deeper = replace(bearing, oil_level=1.2 * bearing.oil_level)
    assert np.all(deeper.moment(radial, axial, speed).drag >= moment.drag * 0.999)


@given(bearings(), seeds)
@examples(20)
def test_bearings_use_only_the_standard(bearing, seed):
    """array-api-strict has nothing beyond the standard, and refuses to mix with NumPy: a slip would raise."""
    values = loads(bearing, seed)
    radial, axial, speed = (strict.asarray(value) for value in values)
    expected, found = bearing.moment(*values), bearing.moment(radial, axial, speed)
    for source in SOURCES:
        assert_allclose(np.asarray(getattr(found, source)), getattr(expected, source), rtol=1e-13)
    assert_allclose(np.asarray(bearing.life(radial, axial)), bearing.life(*values[:2]), rtol=1e-13)
    assert_allclose(np.asarray(bearing.static_safety(radial, axial)), bearing.static_safety(*values[:2]), rtol=1e-13)
    if bearing.type != "thrust_ball":
        pair = BearingPair(bearing=bearing, span=0.05)
        preload = np.abs(values[0])
        arrays = strict.asarray(preload), axial, strict.asarray(0.03)
        total = pair.moment(*arrays, speed).total
        assert_allclose(np.asarray(total), pair.moment(preload, values[1], 0.03, values[2]).total, rtol=1e-13)
        assert_allclose(np.asarray(pair.life(*arrays)), pair.life(preload, values[1], 0.03), rtol=1e-12)
        assert pair.static_safety(*arrays).shape == preload.shape


@pytest.mark.slow
@given(bearings(wet=True), seeds)
@examples(4)  # each compiles three derivatives
def test_gradients_agree_with_differences(bearing, seed):
    random = np.random.default_rng(seed)
    radial, axial = random.uniform(0.02, 0.3, (2, 30)) * bearing.dynamic_rating
    point = (radial, axial, random.uniform(1, 300, 30))

    def total(radial, axial, speed):
        return bearing.moment(radial, axial, speed).total

    exact = jax.jit(jax.vmap(jax.grad(total, argnums=(0, 1, 2))))(*point)
    for index, derivative in enumerate(exact):
        step = 1e-6 * point[index]
        above, below = ([*point[:index], point[index] + sign * step, *point[index + 1 :]] for sign in (1, -1))
        difference = (total(*above) - total(*below)) / (2 * step)
        # Central differences in float64 with a relative step of 1e-6 keep about seven digits.
        assert_allclose(derivative, difference, rtol=1e-5, atol=1e-7 * np.max(np.abs(difference)))


@sampled("kind", KINDS, ids=lambda kind: "-".join(kind), every=6)
def test_gradients_stay_finite_at_rest_and_without_load(kind):
    bearing = Bearing(
        type=kind[0], series=kind[1], friction_model=kind[2],
        bore=0.008, outside_diameter=0.022, dynamic_rating=3450.0, static_rating=1370.0,
    )  # fmt: skip

    def total(radial, axial, speed):
        return bearing.moment(radial, axial, speed).total

    gradient = jax.jit(jax.grad(total, argnums=(0, 1, 2)))
    for point in ((250.0, 50.0, 0.0), (250.0, 0.0, 20.0), (0.0, 50.0, 20.0), (0.0, 0.0, 0.0)):
        assert all(np.isfinite(part) for part in gradient(*point)), point


@pytest.mark.slow
def test_gradient_by_a_design_parameter():
    """Validation lets traced values through, so bearings can be differentiated by their own figures."""
    bearing = Bearing(series="60", bore=0.008, outside_diameter=0.022, dynamic_rating=3450.0, static_rating=1370.0)

    def total(viscosity, outside):
        traced = replace(bearing, viscosity=viscosity, outside_diameter=outside)
        return BearingPair(bearing=traced, span=0.02).moment(500.0, 100.0, 0.03, 50.0).total

    point = (100e-6, 0.022)
    exact = jax.jit(jax.grad(total, argnums=(0, 1)))(*point)
    for index, derivative in enumerate(exact):
        step = 1e-6 * point[index]
        above, below = ([*point[:index], point[index] + sign * step, *point[index + 1 :]] for sign in (1, -1))
        assert float(derivative) == pytest.approx(float((total(*above) - total(*below)) / (2 * step)), rel=1e-5)
