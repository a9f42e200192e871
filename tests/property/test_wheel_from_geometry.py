"""The element with every creep law, from measured groups and from random geometry: still passive, still invertible."""

from dataclasses import replace

import array_api_strict as strict
import jax
import numpy as np
import pytest
from designs import POINTS, elements, seeds, states
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar import Limit, bearings
from infinivar.contact import creep
from sampled import examples, sampled

jax.config.update("jax_enable_x64", True)

every_law = st.sampled_from(list(creep.LAWS))
bending = st.sampled_from([name for name, law in creep.LAWS.items() if not law.straight])


@st.composite
def materials(draw):
    return iv.contact.Material(
        youngs_modulus=draw(st.floats(1e9, 7e11)),
        poisson=draw(st.floats(0.0, 0.5)),
        yield_strength=draw(st.none() | st.floats(1e7, 3e9)),
        hardness=draw(st.none() | st.floats(1e8, 2e10)),
        hysteresis_factor=draw(st.floats(0, 0.05)),
    )


@st.composite
def wheels(draw, law=every_law):
    """A wheel described by geometry, with a bearing that is not asked for the absurd."""
    radius, preload = draw(st.floats(0.004, 0.1)), draw(st.floats(10, 2000))
    bearing = bearings()[draw(st.sampled_from(["608", "625", "6000", "6004"]))]
    falls = draw(st.booleans())
    geometry = iv.transmission.ContactGeometry(
        crown_radius=draw(st.floats(0.001, 1.0)),
        wheel_material=draw(materials()),
        cylinder_material=draw(materials()),
        axle_bearing=replace(
            bearing,
            friction_model=draw(st.sampled_from(["skf", "coefficient"])),
            viscosity=draw(st.floats(5e-6, 5e-4)),
        ),
        bearing_span=draw(st.none() | st.floats(0.005, 0.1)),
        lateral_share=draw(st.floats(0, 1)),
        fast_friction_ratio=draw(st.floats(0.3, 1)) if falls else 1.0,
        friction_decay_speed=draw(st.floats(0.1, 10)) if falls else None,
    )
    return iv.RotaryLinearIVT(
        cylinder_radius=draw(st.floats(0.01, 0.3)),
        wheel_radius=radius,
        preload=preload,
        friction=draw(st.floats(0.05, 0.8)),
        geometry=geometry,
        creep_law=draw(law),
    )


def points(element, seed, largest=1.0, largest_angle=1.5):
    """States in all four quadrants up to a share of the slip force at the speed at hand."""
    random = np.random.default_rng(seed)
    angle = random.uniform(-largest_angle, largest_angle, POINTS)
    speed = random.uniform(0.1, 100, POINTS) * random.choice([-1, 1], POINTS)
    groups = element.groups(speed)
    ratio = random.uniform(-largest, largest, POINTS)
    rolling = -np.sign(speed) * groups.rolling_force
    return speed, angle, -ratio * groups.slip_force * np.cos(angle) - rolling * np.sin(angle)


def assert_balanced(point):
    scale = np.maximum(np.abs(point.power_in), np.abs(point.power_out))
    for name, loss in point.losses.items():
        assert np.all((loss >= -1e-12 * scale) | np.isnan(loss)), name
    rest = point.power_in - point.power_out - sum(point.losses.values())
    assert np.all((np.abs(rest) <= 1e-12 * scale) | np.isnan(rest))


@given(wheels(), seeds)
def test_passive_and_closed_from_geometry(element, seed):
    speed, angle, force = points(element, seed)
    point = element.operate(cylinder_speed=speed, steering_angle=angle, link_force=force)
    assert (point.limit == Limit.OK).sum() > POINTS // 4
    assert_balanced(point)
    moving = 1.5 * np.where(np.isnan(point.link_speed), 0.3, point.link_speed)  # beyond slip as well
    assert_balanced(element.operate(cylinder_speed=speed, steering_angle=angle, link_speed=moving))


@given(wheels(), st.floats(0.5, 100.0))
def test_bearings_carry_their_share_of_the_slip_force(element, speed):
    """Worked out from the bearings themselves, at the speed of the wheel."""
    groups, geometry = element.groups(speed), element.geometry
    surface = element.cylinder_radius * speed
    alone = geometry.axle.moment(
        element.preload,
        geometry.lateral_share * groups.slip_force,
        element.wheel_radius,
        surface / element.wheel_radius,
    )
    assert_allclose(groups.bearing_torque, alone.total, rtol=1e-12)


@given(elements(law=bending), seeds)
def test_passive_and_closed_with_laws_that_bend(element, seed):
    speed, angle, force = states(element, seed)
    point = element.operate(cylinder_speed=speed, steering_angle=angle, link_force=force)
    assert_balanced(point)
    assert_balanced(element.operate(cylinder_speed=speed, steering_angle=angle, link_speed=1.5 * point.link_speed))


@given(elements(law=bending), seeds)
def test_speed_and_force_modes_agree(element, seed):
    speed, angle, force = states(element, seed)
    one = element.operate(cylinder_speed=speed, steering_angle=angle, link_force=force)
    well = (one.limit == Limit.OK) & (np.abs(one.lateral_force) < 0.99 * element.slip_force)
    other = element.operate(cylinder_speed=speed, steering_angle=angle, link_speed=one.link_speed)
    # A creepage is the difference of two speeds: it has 1e-16 of them, which the stiffness magnifies.
    tolerance = 1e-12 * element.groups(1.0).creep_group * element.slip_force
    assert_allclose(other.link_force[well], force[well], rtol=0, atol=tolerance)
    assert np.all(other.limit[well] == Limit.OK)


@given(elements(law=every_law), seeds)
def test_slip_is_named(element, seed):
    speed, angle, force = states(element, seed, largest_angle=1.2)
    groups = element.groups(speed)
    more = np.sign(force) * (1.05 * groups.slip_force + np.abs(groups.rolling_force)) * 1.5
    point = element.operate(cylinder_speed=speed, steering_angle=angle, link_force=more / np.cos(angle))
    assert np.all(point.limit == Limit.SLIP)
    assert np.all(np.isnan(point.link_speed))


@given(elements(law=bending, smallest_k=50.0), seeds)
def test_steer_inverts_operate(element, seed):
    """Up to 0.99 of slip, at angles where one motion has one angle; the angle found is never farther from locked."""
    largest = np.arctan(min(0.3 * element.groups(1.0).creep_group, 30.0))
    speed, angle, force = states(element, seed, largest_angle=largest)
    point = element.operate(cylinder_speed=speed, steering_angle=angle, link_force=force)
    well = (point.limit == Limit.OK) & (np.abs(point.lateral_force) < 0.99 * element.slip_force)
    found = element.steer(cylinder_speed=speed, link_speed=point.link_speed, link_force=force)
    assert not np.any(np.isnan(found[well]))
    assert np.all(np.abs(found[well]) <= np.abs(angle[well]) + 1e-9)
    again = element.operate(cylinder_speed=speed, steering_angle=np.where(well, found, 0.0), link_force=force)
    scale = np.abs(point.link_speed) + element.cylinder_radius * np.abs(speed)
    assert np.all(np.abs(again.link_speed - point.link_speed)[well] <= 1e-9 * scale[well])


@given(wheels(), seeds)
def test_measured_groups_of_a_geometry_are_that_geometry(element, seed):
    """Whatever gives the groups, the element is the same; with a nonlinear law at angle 0, where measured values belong."""
    groups = element.groups(14.0)
    measured = replace(
        element,
        geometry=None,
        friction=groups.slip_force / element.preload,
        creep_stiffness=groups.creep_stiffness,
        rolling_torque=groups.rolling_torque,
        bearing_torque=groups.bearing_torque,
        creep_law=creep.pinned(element.creep_law, groups.axis_ratio, groups.poisson),
    )
    _, angle, force = points(element, seed)
    angle = angle if groups.yielding is None else 0.0 * angle
    one, other = (
        wheel.operate(cylinder_speed=14.0, steering_angle=angle, link_force=force) for wheel in (element, measured)
    )
    assert_allclose(other.link_speed, one.link_speed, rtol=1e-12)
    assert_allclose(other.torque, one.torque, rtol=1e-9, atol=1e-12 * element.slip_force)
    # Full slip of the measured wheel is that of a circular patch: a few percent of slip from where it is.
    near = np.abs(one.lateral_force) > 0.9 * groups.slip_force
    assert np.all((one.limit == other.limit) | near)


@given(wheels(law=st.just("linear")))
def test_groups_scale_with_the_preload(element):
    """johnson1985: axes go with P^(1/3), so C with P^(2/3) and hysteresis with P^(4/3); bearings carry more."""
    heavier = replace(element, preload=8 * element.preload)
    light, heavy = element.groups(14.0), heavier.groups(14.0)
    assert heavy.creep_stiffness == pytest.approx(4 * light.creep_stiffness, rel=1e-9)
    assert heavy.rolling_torque == pytest.approx(16 * light.rolling_torque, rel=1e-9)
    assert heavy.bearing_torque > light.bearing_torque
    assert element.groups(-14.0) == light
    for limit, demand in element.utilisation.items():
        assert heavier.utilisation[limit] > demand > 0 or limit == iv.Limit.CLEARANCE


@given(wheels(), seeds)
@examples(10)
def test_geometry_uses_only_the_standard(element, seed):
    speed, angle, force = points(element, seed, largest=0.95, largest_angle=1.2)
    expected = element.operate(cylinder_speed=speed, steering_angle=angle, link_force=force)
    arrays = [strict.asarray(values) for values in (speed, angle, force)]
    point = element.operate(cylinder_speed=arrays[0], steering_angle=arrays[1], link_force=arrays[2])
    for field in ("torque", "link_speed", "efficiency"):
        assert_allclose(np.asarray(getattr(point, field)), getattr(expected, field), rtol=1e-9, atol=1e-12)


# The laws' own gradients are in test_creep_laws.
@sampled("law", ["linear", "fastsim", "vermeulen-johnson", "polach"], slow=4)
def test_gradients_by_the_design(element, law):
    """Input power by preload, crown radius and viscosity, straight through Hertz, Kalker and the SKF model."""
    geometry = element.geometry

    def power_in(preload, crown, viscosity):
        bearing = replace(geometry.axle_bearing, friction_model="skf", viscosity=viscosity)
        changed = replace(geometry, crown_radius=crown, axle_bearing=bearing)
        wheel = replace(element, preload=preload, geometry=changed, creep_law=law)
        return wheel.deliver(cylinder_speed=14.0, link_speed=0.3, link_force=40.0).power_in

    at = (650.0, 0.008, 1e-4)
    exact = jax.jit(jax.grad(power_in, argnums=(0, 1, 2)))(*at)
    for index, value in enumerate(at):
        less, more = (power_in(*at[:index], value * factor, *at[index + 1 :]) for factor in (1 - 1e-5, 1 + 1e-5))
        # Central differences with 1e-5 keep about eight digits of a power of which a hundredth depends on the design.
        assert float(exact[index]) == pytest.approx(float(more - less) / (2e-5 * value), rel=1e-4)
