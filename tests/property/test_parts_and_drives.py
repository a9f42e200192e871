"""Power balances of parts and whole drives in all four quadrants, on random machines."""

import numpy as np
import pytest
from designs import POINTS, amplifiers, elements, gearheads, motors, seeds
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

import infinivar as iv
from infinivar import Limit, power

ROUNDING = 1e-12


def quadrants(seed, first, second):
    """Points uniform over +-first and +-second."""
    random = np.random.default_rng(seed)
    return random.uniform(-first, first, POINTS), random.uniform(-second, second, POINTS)


def assert_closed(power_in, power_out, losses):
    # Losses can be many times the power at the ends when both ends feed them: relative to all of it.
    total = np.abs(power_in) + np.abs(power_out) + sum(np.abs(loss) for loss in losses)
    assert np.all(np.abs(power_in - power_out - sum(losses)) <= ROUNDING * total)
    assert all(np.all(loss >= -ROUNDING * total) for loss in losses)


@given(motors(), seeds)
def test_motor(motor, seed):
    torque, speed = quadrants(seed, 3 * motor.continuous_torque, 2 * motor.voltage / motor.torque_constant)
    point = motor.operate(torque=torque, speed=speed)
    assert_closed(point.power, torque * speed, point.losses.values())


@given(motors(), st.floats(0.1, 20), seeds)
def test_scaled_motor_is_that_many_motors(motor, factor, seed):
    """n motors sharing torque and speed draw n times the power and reach their limits together."""
    torque, speed = quadrants(seed, 3 * motor.continuous_torque, 2 * motor.voltage / motor.torque_constant)
    one, many = (
        motor.operate(torque=torque, speed=speed),
        motor.scaled(factor).operate(torque=torque * factor, speed=speed),
    )
    assert_allclose(many.power, one.power * factor, rtol=1e-9, atol=1e-9)
    for limit in (Limit.THERMAL, Limit.VOLTAGE):
        assert_allclose(many.utilisation[limit], one.utilisation[limit], rtol=1e-9, atol=1e-12)
    for name, loss in one.losses.items():
        assert_allclose(many.losses[name], loss * factor, rtol=1e-9, atol=1e-9)
    assert_closed(many.power, factor * torque * speed, many.losses.values())
    assert motor.scaled(factor).peak_efficiency == pytest.approx(motor.peak_efficiency, rel=1e-12)


@given(gearheads(), st.floats(0.001, 1), seeds)
def test_gearhead(gearhead, rated, seed):
    torque, speed = quadrants(seed, 3 * rated * gearhead.ratio, 100)
    point = gearhead.operate(output_torque=torque, output_speed=speed, motor_rated_torque=rated)
    assert_closed(point.motor_torque * point.motor_speed, torque * speed, [point.loss])


@given(gearheads(), st.floats(0.001, 1), seeds)
def test_overhauling_load_returns_at_most_eta(gearhead, rated, seed):
    """Within rated torque neither loss model returns more than eta of what the load puts in."""
    torque, speed = quadrants(seed, rated * gearhead.ratio, 100)
    torque = -np.abs(torque) * np.sign(speed)  # the load drives
    point = gearhead.operate(output_torque=torque, output_speed=speed, motor_rated_torque=rated)
    received, returned = -torque * speed, -point.motor_torque * point.motor_speed
    assert np.all(returned <= gearhead.efficiency * received * (1 + ROUNDING))


@given(gearheads(loss_model="proportional"), st.floats(0.001, 1), seeds)
def test_proportional_gear_delivers_eta_of_what_it_receives(gearhead, rated, seed):
    torque, speed = quadrants(seed, 10 * rated * gearhead.ratio, 100)
    point = gearhead.operate(output_torque=torque, output_speed=speed, motor_rated_torque=rated)
    motor, load = point.motor_torque * point.motor_speed, torque * speed
    received, delivered = np.maximum(motor, -load), np.minimum(np.abs(motor), np.abs(load))
    assert_allclose(delivered, gearhead.efficiency * received, rtol=1e-12, atol=0)


@given(amplifiers(), seeds)
def test_amplifier(amplifier, seed):
    motor_power, _ = quadrants(seed, 200, 1)
    power_in, loss, limits = amplifier.supply(motor_power)
    assert_closed(power_in, motor_power, [loss])
    if amplifier.regeneration == "store":
        kept = amplifier.standby_power - power_in[motor_power < 0]
        assert np.all(kept <= amplifier.storage_efficiency * -motor_power[motor_power < 0] + 1e-9)
    else:
        assert np.all(power_in >= 0)
    assert (Limit.REGENERATION in limits) == (amplifier.regeneration == "none")


@st.composite
def conventional_drives(draw):
    return iv.ConventionalDrive(
        motor=draw(motors()),
        gearhead=draw(gearheads()),
        amplifier=draw(amplifiers()),
        pulley=iv.parts.Pulley(radius=draw(st.floats(0.001, 0.1)), friction_torque=draw(st.floats(0, 0.05))),
        guideway=iv.parts.Guideway(friction=draw(st.floats(0, 10))),
    )


@st.composite
def cobotic_drives(draw):
    element = draw(elements())
    return iv.CoboticDrive(
        motor=draw(motors()),
        gearhead=draw(gearheads()),
        amplifier=draw(amplifiers()),
        transmission=element,
        cylinder_speed=draw(st.floats(0.5, 200)) * draw(st.sampled_from([-1, 1])),
        guideway=iv.parts.Guideway(coefficient=draw(st.floats(0, 0.01)), friction=draw(st.floats(0, 2))),
    )


@given(st.one_of(conventional_drives(), cobotic_drives()), st.floats(0.1, 1000), st.floats(0.01, 20), seeds)
def test_drive(drive, largest_force, largest_speed, seed):
    """Closure, no loss below zero, and powers missing only where the wheel slips."""
    force, speed = quadrants(seed, largest_force, largest_speed)
    point = drive.operate(speed=speed, force=force)
    moves = ~np.isnan(np.broadcast_to(point.power_in, force.shape))
    assert np.all(moves | (point.limit == Limit.SLIP))
    every = [np.broadcast_to(loss, force.shape)[moves] for loss in point.losses.values()]
    assert_closed(np.broadcast_to(point.power_in, force.shape)[moves], (force * speed)[moves], every)
    efficiency = point.efficiency
    assert np.all(((efficiency >= 0) & (efficiency <= 1)) | np.isnan(efficiency))


@given(st.one_of(conventional_drives(), cobotic_drives()), seeds)
def test_steady_map_is_the_drive_point_by_point(drive, seed):
    """Tiling changes nothing, in any quadrant."""
    random = np.random.default_rng(seed)
    speed, force = np.sort(random.uniform(-2, 2, 23)), np.sort(random.uniform(-50, 50, 31))
    steady = iv.steady_map(drive, speed, force)
    point = drive.operate(speed=speed[:, None], force=force[None, :])
    assert_array_equal(steady.power_in, np.broadcast_to(point.power_in, steady.power_in.shape))
    assert_array_equal(steady.limit, point.limit)
    assert_array_equal(steady.efficiency, point.efficiency)
    assert steady.audit_residual < power.AUDIT_TOLERANCE


@given(cobotic_drives(), st.floats(0.1, 1000), st.floats(0.01, 20), seeds)
def test_reversing_speed_and_force_changes_nothing(drive, largest_force, largest_speed, seed):
    force, speed = quadrants(seed, largest_force, largest_speed)
    one, other = drive.operate(speed=speed, force=force), drive.operate(speed=-speed, force=-force)
    assert_allclose(other.power_in, one.power_in, rtol=1e-12, atol=0)
    assert_array_equal(other.limit, one.limit)
