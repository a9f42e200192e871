"""Losses of gears: what holds them when other values move, and gears that the load drives or cannot drive."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar import DutyCycle, Scenario, duty_cycle
from infinivar.analysis import two_ways
from infinivar.motion import ConstantForce, Hold, Reaches, Rest
from internals import DERIVATIVE_METHODS as METHODS
from internals import evaluated, gradient
from internals import loss_outcome as loss
from made import parameter_study
from sampled import sampled

STUDY = parameter_study("faulring2006")
COBOTIC, GEARED = STUDY.drives["cobotic"], STUDY.drives["motor2-gear4"]


@sampled("drive", [COBOTIC, GEARED], ids=["cobotic", "geared"], every=2)
def test_a_better_cooled_motor_does_not_rub_more(drive):
    """The gear's friction is stated at the motor's continuous torque; a build with another one has the same gear."""
    assert drive.gearhead.rated_torque is None
    path = "motor.continuous_torque"
    point = {"speed": 0.3, "force": 20.0}
    for method in METHODS:
        value, slope = gradient(lambda d: loss(d, **point), drive, [path], method=method)
        assert slope[0] == pytest.approx(0.0, abs=1e-9 * float(value))
    more = np.array([[1.1 * drive.motor.continuous_torque]])
    built = evaluated(lambda d: loss(d, **point), drive, [path], more)
    assert built[0] == pytest.approx(float(loss(drive, **point)), rel=1e-12)
    # Chosen as another motor, though, with a gear for it, it is another design.
    other = replace(drive, motor=replace(drive.motor, continuous_torque=float(more[0, 0])))
    assert float(loss(other, **point)) > float(loss(drive, **point))


def worm(**changed):
    return iv.parts.Gearhead(**{"ratio": 20.0, "efficiency": 0.4, "loss_model": "proportional", **changed})


def test_a_gear_has_an_efficiency_each_way():
    """By hand, in all four quadrants: 1/eta of the load's torque while driving, eta_b of it while driven, none at rest of 0."""
    gear = worm(backdriving_efficiency=0.1)
    torque = np.array([2.0, -2.0, -2.0, 2.0])
    speed = np.array([3.0, -3.0, 3.0, -3.0])
    point = gear.operate(output_torque=torque, output_speed=speed, motor_rated_torque=1.0)
    ideal = torque / 20.0
    assert_allclose(point.motor_torque, ideal * np.array([2.5, 2.5, 0.1, 0.1]))
    received, delivered = point.motor_torque * point.motor_speed, torque * speed
    assert_allclose(delivered[:2], 0.4 * received[:2])
    assert_allclose(received[2:], 0.1 * delivered[2:])
    assert_allclose(point.loss, received - delivered)
    assert np.all(point.loss > 0)


def test_one_figure_is_both_ways_and_zero_locks():
    speed, torque = np.array([3.0, -3.0, 0.0]), np.array([2.0, 2.0, 2.0])
    both = worm().operate(output_torque=torque, output_speed=speed, motor_rated_torque=1.0)
    assert_allclose(both.motor_torque, 0.1 * np.array([2.5, 0.4, 0.4]))
    locks = worm(backdriving_efficiency=0.0).operate(output_torque=torque, output_speed=speed, motor_rated_torque=1.0)
    assert_allclose(locks.motor_torque, 0.1 * np.array([2.5, 0.0, 0.0]), atol=1e-15)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"backdriving_efficiency": -0.1}, "backdriving_efficiency must be >= 0 and <= 1, got -0.1"),
        ({"backdriving_efficiency": 1.1}, "backdriving_efficiency must be >= 0 and <= 1, got 1.1"),
        (
            {"loss_model": "coulomb", "backdriving_efficiency": 0.1},
            "backdriving_efficiency does not apply with loss_model = 'coulomb'; remove it",
        ),
    ],
)
def test_what_is_refused(changed, message):
    with pytest.raises(iv.InputError, match=message.replace("(", r"\(")):
        worm(**changed)


def wormed(back):
    gear = worm(ratio=4.0, efficiency=0.7, backdriving_efficiency=back)
    return replace(GEARED, gearhead=gear, guideway=iv.parts.Guideway(friction=0.5))


@pytest.mark.slow
@sampled("back", [0.7, 0.35, 0.0], every=3)
def test_motion_and_simulation_agree_when_the_load_drives(back):
    """Lifting and lowering against 25 N: by inverse dynamics and in time, through every efficiency back."""
    duty = DutyCycle(motion=Reaches(distance=0.1, time=0.6, pause=0.3), force=-25.0, load_mass=0.8)
    both = two_ways(wormed(back), duty)
    assert both.rms_error < 1e-3 * duty.motion.distance
    assert both.followed == pytest.approx(both.prescribed, rel=0.02)
    assert both.lost_followed["gearhead"] == pytest.approx(both.lost_prescribed["gearhead"], rel=0.02)


def test_the_less_comes_back_the_less_it_takes_to_hold():
    """A gear that locks itself holds for nothing, a lossless one for the whole current."""
    duty = DutyCycle(motion=Hold(time=1.0), force=-25.0, load_mass=0.8)
    power = [duty_cycle(wormed(back), duty).power_in for back in (0.0, 0.35, 0.7)]
    assert power[0] == 0.0
    assert 0.0 < power[1] < power[2]


def test_a_gear_that_locks_itself_stays_where_it_is():
    """Pushed with 40 N and no current, in time: it creeps by less than the stick speed; one of 0.7 runs away."""
    gone = {}
    for back in (0.0, 0.7):
        run = iv.simulate(
            wormed(back), Scenario(duration=0.5, link="free", force=ConstantForce(size=-40.0), load_mass=0.8)
        )
        gone[back] = abs(run.columns["position_m"][-1])
        assert run.trajectory.closure < 1e-6
    assert gone[0.0] < 0.5 * 1e-4
    assert gone[0.7] > 0.1


def test_maps_of_a_gear_that_locks_itself_have_no_efficiency_back():
    """Braking at any speed, the load's power is all lost in the gear, or the motor has to help."""
    drive = wormed(0.0)
    steady = iv.steady_map(drive, np.linspace(0.05, 1.0, 20), np.linspace(-40.0, -5.0, 20))
    assert np.all(steady.power_in >= 0)
    assert not np.any(steady.efficiency > 0)
    assert Rest().shape == "hold"
