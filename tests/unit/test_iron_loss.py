"""Loss of a motor that grows with speed: split of the no-load current, power balance, heat, and the bond graph."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar import Scenario
from infinivar.motion import ConstantForce, Cruise
from infinivar.parts import heat

PLAIN = iv.parts.Motor(
    voltage=24.0,
    resistance=1.5,
    torque_constant=0.024,
    no_load_current=0.2,
    continuous_torque=0.06,
    rotor_inertia=2e-6,
    winding_to_housing=3.0,
    housing_to_ambient=9.0,
    winding_time_constant=20.0,
    housing_time_constant=500.0,
    max_winding_temperature=400.0,
)
SHARE = 0.6
MOTOR = replace(PLAIN, viscous_friction=SHARE * PLAIN.no_load_torque / PLAIN.no_load_speed)


def test_the_no_load_point_is_that_of_the_data_sheet():
    """At supply voltage and without load: the stated current and speed, whatever the split; its torque is split as stated."""
    for motor in (PLAIN, MOTOR):
        point = motor.operate(torque=0.0, speed=motor.no_load_speed)
        assert point.voltage == pytest.approx(24.0, rel=1e-14)
        assert point.current == pytest.approx(0.2, rel=1e-14)
    losses = MOTOR.operate(torque=0.0, speed=MOTOR.no_load_speed).losses
    assert losses["motor iron"] == pytest.approx(SHARE * PLAIN.no_load_torque * PLAIN.no_load_speed)
    assert losses["motor friction"] == pytest.approx((1 - SHARE) * PLAIN.no_load_torque * PLAIN.no_load_speed)
    assert "motor iron" not in PLAIN.operate(torque=0.0, speed=1.0).losses


def test_iron_loss_grows_with_the_square_of_speed_and_does_not_hold():
    speed = np.array([0.0, 100.0, 200.0, -200.0])
    losses = MOTOR.operate(torque=0.01, speed=speed).losses
    assert_allclose(losses["motor iron"] / losses["motor iron"][1], [0.0, 1.0, 4.0, 4.0])
    held = MOTOR.friction_torque
    assert MOTOR.operate(torque=held, speed=0.0).current == 0.0
    assert MOTOR.operate(torque=1.1 * held, speed=0.0).current == pytest.approx(0.1 * held / 0.024)


def test_peak_efficiency_is_that_of_the_curve():
    torque = np.linspace(1e-4, 0.38, 200_001)
    # On the line of constant voltage.
    drag = MOTOR.viscous_friction
    speed = (24.0 - 1.5 / 0.024 * (torque + MOTOR.friction_torque)) / (0.024 + 1.5 / 0.024 * drag)
    point = MOTOR.operate(torque=torque, speed=speed)
    assert_allclose(point.voltage, 24.0, rtol=1e-12)
    assert np.max(torque * speed / point.power) == pytest.approx(MOTOR.peak_efficiency, rel=1e-8)


def test_a_warm_winding_leaves_friction_and_iron_loss():
    warm = heat.warm(MOTOR, 390.0)
    assert warm.resistance > 1.3 * MOTOR.resistance
    assert warm.friction_torque == pytest.approx(MOTOR.friction_torque, rel=1e-12)
    assert warm.viscous_friction == MOTOR.viscous_friction
    point = warm.operate(torque=0.0, speed=warm.no_load_speed)
    assert (point.voltage, point.current) == (pytest.approx(24.0), pytest.approx(warm.no_load_current))


def test_motors_side_by_side_and_without_friction():
    double = MOTOR.scaled(2.0)
    assert double.no_load_speed == pytest.approx(MOTOR.no_load_speed)
    one, two = MOTOR.operate(torque=0.02, speed=300.0), double.operate(torque=0.04, speed=300.0)
    for name, loss in one.losses.items():
        assert two.losses[name] == pytest.approx(2.0 * loss)
    bare = MOTOR.without_friction()
    assert set(bare.operate(torque=0.0, speed=100.0).losses.values()) == {0.0}
    assert bare.continuous_current == pytest.approx(MOTOR.continuous_current)


def test_more_iron_loss_than_no_load_torque_is_refused():
    most = PLAIN.no_load_torque / PLAIN.no_load_speed
    assert replace(PLAIN, viscous_friction=most).friction_torque == pytest.approx(0.0, abs=1e-15)
    with pytest.raises(
        iv.ParameterError, match=r"viscous_friction must be <= 4.86e-6 N m s, which is all of the no-load torque"
    ):
        replace(PLAIN, viscous_friction=1.01 * most)


DRIVE = iv.ConventionalDrive(
    motor=MOTOR,
    gearhead=iv.parts.Gearhead(ratio=5.0, efficiency=0.9),
    pulley=iv.parts.Pulley(radius=0.01),
    guideway=iv.parts.Guideway(friction=1.0),
    output_inertia=1e-6,
)


def test_inverse_dynamics_and_simulation_agree():
    """Settled at constant speed: current and iron loss of the bond graph are those of the steady point."""
    speed, force = 0.8, 15.0
    steady = DRIVE.operate(speed=speed, force=force)
    scenario = Scenario(
        duration=0.3, output_step=0.05, motion=Cruise(speed=speed), force=ConstantForce(size=-force), load_mass=0.5
    )
    run = iv.simulate(DRIVE, scenario)
    assert run.columns["motor_current_A"][-1] == pytest.approx(float(steady.states["motor_current_A"]), rel=1e-4)
    lost = run.trajectory.lost["motor iron"]
    assert (lost[-1] - lost[-2]) / 0.05 == pytest.approx(float(steady.losses["motor iron"]), rel=1e-3)
    assert run.trajectory.closure < 1e-6


def test_iron_loss_heats_the_housing():
    """Settled temperatures of a lossy idle motor: the housing carries friction and iron loss to ambient."""
    motion = iv.motion.Sinusoid(distance=0.05, frequency=2.0)
    duty = iv.DutyCycle(motion=motion, load_mass=0.5)
    result = iv.duty_cycle(DRIVE, duty)
    hot = result.heat["motor"]
    power = sum(np.mean(result.point.losses[name]) for name in ("winding", "motor friction", "motor iron"))
    assert np.mean(result.point.losses["motor iron"]) > 0.05
    assert hot.housing - hot.ambient == pytest.approx(9.0 * power, rel=0.01)
    assert math.isclose(result.closure, 0.0, abs_tol=1e-9)


@pytest.mark.parametrize("drag", [0.0, 0.5e-6])
def test_iron_loss_in_a_cycle_with_rest(drag):
    """Where the load rests, neither friction nor iron loss; the energy is that of a motor without the share, plus the share."""
    drive = iv.load_study("hand_controller").drives["motor1-gear1"]
    drive = replace(drive, motor=replace(drive.motor, viscous_friction=drag or None))
    reaches = iv.DutyCycle(motion=iv.motion.Reaches(distance=0.02, time=0.5, pause=0.5), load_mass=1.0, force=-3.0)
    found = iv.duty_cycle(drive, reaches)
    speed = found.point.states["motor_speed_rad_s"]
    assert np.mean(speed == 0.0) == pytest.approx(0.5, abs=0.01)
    iron = found.point.losses.get("motor iron", np.zeros_like(speed))
    assert_allclose(iron, drag * speed**2, rtol=1e-12, atol=1e-18)
    assert found.without_help.energy > found.energy
    hold = iv.duty_cycle(drive, iv.DutyCycle(motion=iv.motion.Hold(time=1.0), force=-3.0, load_mass=1.0))
    plain = iv.duty_cycle(replace(drive, motor=replace(drive.motor, viscous_friction=None)), hold.duty)
    assert hold.without_help.energy == pytest.approx(plain.without_help.energy, rel=1e-12)


def test_rounding_leaves_no_negative_friction():
    """All of the no-load torque grows with speed: the rest is 0 to rounding, which may be on either side."""
    for current in np.random.default_rng(1).uniform(1e-4, 0.1, 200).tolist():
        motor = iv.parts.Motor(
            voltage=24.0, resistance=2.1, torque_constant=0.031, no_load_current=current, continuous_torque=0.1
        )
        drag = motor.no_load_torque / motor.no_load_speed
        assert replace(motor, viscous_friction=drag).friction_torque >= 0.0
