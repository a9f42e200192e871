"""The element in its special states: locked, decoupled, at rest, slipping, and misused."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar import Limit


def test_locked_link_creeps_under_load_and_does_not_drift(element):
    """phi = 0: no load, no motion; under load the link yields by the creep 1/K of the surface speed at most."""
    surface = element.cylinder_radius * 14.0
    free = element.operate(cylinder_speed=14.0, steering_angle=0.0, link_force=0.0)
    assert free.link_speed == 0.0
    loaded = element.operate(cylinder_speed=14.0, steering_angle=0.0, link_force=0.9 * element.slip_force)
    assert loaded.link_speed == pytest.approx(-0.9 * surface / element.groups(14.0).creep_group, rel=1e-12)
    assert loaded.torque == pytest.approx(element.groups(14.0).rolling_force * element.cylinder_radius, rel=1e-12)
    assert np.isnan(loaded.efficiency)  # load and cylinder both feed the losses


def test_holding_a_load_still_needs_a_small_angle_and_torque(element):
    force = 0.5 * element.slip_force
    angle = element.steer(cylinder_speed=14.0, link_speed=0.0, link_force=force)
    point = element.operate(cylinder_speed=14.0, steering_angle=angle, link_force=force)
    assert 0 > angle > -1.1 * 0.5 / element.groups(14.0).creep_group
    assert point.link_speed == pytest.approx(0.0, abs=1e-15)
    assert point.torque > element.groups(14.0).rolling_force * element.cylinder_radius
    assert point.power_in > 0


def test_exact_standstill_has_efficiency_zero(element):
    """Power is spent and none comes out: that is 0, not nan."""
    point = element.deliver(cylinder_speed=14.0, link_speed=0.0, link_force=0.5 * element.slip_force)
    assert point.limit == Limit.OK
    assert point.power_in > 0
    assert point.power_out == 0.0
    assert point.efficiency == 0.0


def test_decoupled_link_rolls_freely(element):
    """phi = pi/2 with the cylinder at rest: the link feels rolling resistance only, and the cylinder no torque."""
    for angle in (math.pi / 2, -math.pi / 2):
        point = element.operate(cylinder_speed=0.0, steering_angle=angle, link_speed=1.0)
        assert point.link_force == pytest.approx(-element.groups(0.0).rolling_force, rel=1e-12)
        assert point.torque == 0.0
        assert point.limit == Limit.OK
        assert point.losses["creep"] == 0.0


def test_decoupled_wheel_brakes_a_turning_cylinder(element):
    """With the wheel across, the cylinder cannot turn: it slides under mu P."""
    point = element.operate(cylinder_speed=14.0, steering_angle=math.pi / 2, link_speed=0.0)
    assert point.limit == Limit.SLIP
    assert point.torque == pytest.approx(element.slip_force * element.cylinder_radius, rel=1e-12)
    assert point.losses["creep"] == pytest.approx(element.slip_force * element.cylinder_radius * 14.0, rel=1e-12)


def test_steering_for_a_moving_link_at_rest_is_decoupling(element):
    angle = element.steer(cylinder_speed=0.0, link_speed=np.array([-0.1, 0.0, 0.1]), link_force=0.0)
    assert_allclose(angle, [math.pi / 2, 0.0, -math.pi / 2])


def test_force_beyond_slip_is_data(element):
    point = element.operate(cylinder_speed=14.0, steering_angle=[0.0, 0.3], link_force=1.01 * element.slip_force)
    assert list(point.limit) == [Limit.SLIP, Limit.SLIP]
    assert np.isnan(point.link_speed).all()
    assert np.isnan(point.power_in).all()
    assert np.isnan(element.steer(cylinder_speed=14.0, link_speed=0.1, link_force=1.01 * element.slip_force))


def test_dragged_link_slides_at_the_slip_force(element):
    """A link dragged at 1 m/s across a locked wheel meets mu P, and all of the work is lost in sliding."""
    point = element.operate(cylinder_speed=14.0, steering_angle=0.0, link_speed=1.0)
    assert point.limit == Limit.SLIP
    assert point.link_force == pytest.approx(-element.slip_force, rel=1e-12)
    assert point.losses["creep"] == pytest.approx(element.slip_force, rel=1e-12)


def test_nothing_is_known_of_forces_at_rest(element):
    point = element.operate(cylinder_speed=0.0, steering_angle=0.2, link_speed=0.0)
    assert np.isnan(point.link_force)
    assert np.isnan(point.torque)


def test_steering_range_is_a_limit(element):
    narrow = replace(element, steering_range=math.radians(30))
    angles = np.radians([10, 29, 31])
    point = narrow.operate(cylinder_speed=14.0, steering_angle=-angles, link_force=5.0)
    assert list(point.limit) == [Limit.OK, Limit.OK, Limit.STEERING]
    assert np.isnan(point.efficiency[2])
    assert point.margin[0] == pytest.approx(3.0)


def test_equation_17_never_creates_power_when_the_load_drives(element):
    """The paper's factor slows the link; a driving load must make it run away faster instead, at the same torque."""
    angle, force = 0.2, 0.85 * element.slip_force
    linear = element.operate(cylinder_speed=14.0, steering_angle=angle, link_force=force)
    reduced = replace(element, creep_law="faulring").operate(
        cylinder_speed=14.0, steering_angle=angle, link_force=force
    )
    assert linear.power_out < 0
    assert linear.power_in < 0
    assert reduced.torque == linear.torque
    assert abs(reduced.link_speed) > abs(linear.link_speed)


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("preload", 0.0, "preload must be > 0 N, got 0.0"),
        ("wheel_radius", -0.01, "wheel_radius must be > 0 m, got -0.01"),
        ("rolling_torque", -1e-3, "rolling_torque must be >= 0 N m, got -0.001"),
        ("friction", float("nan"), "friction must be > 0, got nan"),
        ("creep_stiffness", float("inf"), "creep_stiffness must be > 0 N, got inf"),
        (
            "creep_law",
            "liner",
            "creep_law must be one of linear, faulring, vermeulen-johnson, polach, fastsim, exact, got 'liner' "
            "(did you mean 'linear'?)",
        ),
    ],
)
def test_refuses_what_is_not_physical(element, field, value, message):
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        replace(element, **{field: value})


@pytest.mark.parametrize("value", ["650 N", None, [650.0], True])
def test_refuses_what_is_no_number(element, value):
    with pytest.raises(ValueError, match="preload must be a number > 0 N"):
        replace(element, preload=value)


def test_misuse_is_an_exception(element):
    with pytest.raises(ValueError, match="either link_force or link_speed"):
        element.operate(cylinder_speed=14.0, steering_angle=0.1)
    with pytest.raises(ValueError, match="between -pi/2 and pi/2"):
        element.operate(cylinder_speed=14.0, steering_angle=2.0, link_force=1.0)


def test_array_parameters_sweep_designs(element):
    """A parameter may be an array: one call sweeps a design."""
    preloads = np.array([400.0, 650.0, 900.0])
    swept = replace(element, preload=preloads)
    point = swept.operate(cylinder_speed=14.0, steering_angle=-0.2, link_force=30.0)
    assert_allclose(point.margin, 0.12 * preloads / np.abs(point.lateral_force), rtol=1e-12)
    with pytest.raises(ValueError, match="preload must be > 0 N"):
        replace(element, preload=np.array([1.0, -1.0]))


def test_inputs_broadcast(element):
    point = element.operate(cylinder_speed=np.ones((3, 1)), steering_angle=np.zeros(4), link_force=1.0)
    assert point.torque.shape == point.efficiency.shape == point.losses["rolling"].shape == (3, 4)


@pytest.mark.parametrize(
    ("stiffness", "rolling", "radius", "cylinder_speed", "link_speed", "load"),
    [
        (1448.8966479510639, 0.00786626394536647, 0.05, 14.0, 0.7 * 2.9582955090880434, -0.9914873627046771),
        # A link 53 times as fast as the cylinder's surface: what an ulp of the angle is worth grows with its square.
        (522.0, 0.015625, 0.015625, -1.0, -52.765710494785694 / 64, 0.9126693188452377),
    ],
)
def test_a_hair_from_slip_rounding_is_no_fault(stiffness, rolling, radius, cylinder_speed, link_speed, load):
    """A law that only tends to slip makes a part in 1e5 of the last place of a force: the balance closes all the same."""
    wheel = iv.RotaryLinearIVT(
        cylinder_radius=radius,
        wheel_radius=0.125,
        preload=1.0,
        friction=1.0,
        creep_stiffness=stiffness,
        rolling_torque=0.0,
        bearing_torque=rolling * 0.125,
        creep_law="polach",
    )
    point = wheel.deliver(cylinder_speed=cylinder_speed, link_speed=link_speed, link_force=load)
    assert 1 - abs(point.lateral_force) < 1e-8
    assert point.power_in - point.power_out == pytest.approx(sum(point.losses.values()), rel=1e-9)
