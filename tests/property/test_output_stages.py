"""Drives with any output stage: power balances in all four quadrants, at rest, and over time."""

from dataclasses import replace

import numpy as np
import pytest
from designs import POINTS, amplifiers, gearheads, motors, output_stages, seeds
from hypothesis import given, settings
from hypothesis import strategies as st
from test_motion import ROUNDING, assert_balanced, courses, inertias, with_rotor

import infinivar as iv
from infinivar.bondgraph.audit import CLOSURE
from infinivar.study.load import shipped_study


@st.composite
def drives(draw, stages=None):
    stage = draw(stages if stages is not None else output_stages())
    return iv.ConventionalDrive(
        motor=with_rotor(draw(motors()), draw(inertias)),
        gearhead=replace(draw(gearheads()), inertia=draw(inertias)),
        amplifier=draw(amplifiers()),
        guideway=iv.Guideway(friction=draw(st.floats(0, 10))),
        output_inertia=draw(inertias),
        **{stage.title: stage},
    )


@given(output_stages(), seeds)
def test_stages_create_no_power(stage, seed):
    """In all four quadrants and on the axes; the loss is what the shaft gives less what the load receives."""
    random = np.random.default_rng(seed)
    force, speed = random.uniform(-500, 500, POINTS), random.uniform(-2, 2, POINTS)
    force[::7], speed[::11] = 0.0, 0.0
    torque, turning, loss = stage.operate(force=force, speed=speed)
    given_power, taken = torque * turning, force * speed
    assert np.all(np.abs(given_power - taken - loss) <= ROUNDING * (np.abs(given_power) + np.abs(taken) + np.abs(loss)))
    assert np.all(loss >= 0)
    # At rest the shaft gives no more torque than without friction, and in its direction.
    rest = speed == 0
    free = (force * float(stage.travel_per_radian))[rest]
    assert np.all(np.abs(torque[rest]) <= np.abs(free))
    assert np.all(torque[rest] * free >= 0)


@given(output_stages(), seeds)
def test_efficiencies_are_those_stated(stage, seed):
    """Without the constant friction torque, power divides as the two efficiencies say."""
    random = np.random.default_rng(seed)
    bare = replace(stage, friction_torque=0.0)
    forward, backward = bare.efficiencies or (1.0, 1.0)
    force, speed = random.uniform(1, 500, POINTS), random.uniform(0.01, 2, POINTS)
    torque, turning, _ = bare.operate(force=force, speed=speed)
    np.testing.assert_allclose(force * speed / (torque * turning), forward, rtol=1e-9)
    torque, turning, _ = bare.operate(force=force, speed=-speed)
    np.testing.assert_allclose(torque * turning / (force * -speed), backward, rtol=1e-9, atol=1e-9)


@given(drives(), st.floats(0, 5), seeds)
def test_drives_balance_along_a_course(drive, mass, seed):
    assert_balanced(drive.follow(courses(seed), load_mass=mass), np.ones(POINTS, dtype=bool))


@given(drives(), seeds)
def test_drives_balance_in_steady_operation(drive, seed):
    random = np.random.default_rng(seed)
    speed, force = random.uniform(-1, 1, POINTS), random.uniform(-50, 50, POINTS)
    speed[::9] = 0.0
    point = drive.operate(speed=speed, force=force)
    flows = [np.broadcast_to(flow, speed.shape) for flow in (point.power_in, -point.power_out)]
    flows += [-np.broadcast_to(loss, speed.shape) for loss in point.losses.values()]
    assert np.all(np.abs(sum(flows)) <= ROUNDING * sum(np.abs(flow) for flow in flows))


@given(drives(), seeds)
def test_losses_vanish_without_friction(drive, seed):
    bare = drive.unheld()
    point = bare.follow(courses(seed))
    scale = np.abs(point.power_out) + np.abs(point.power_in)
    for name in ("gearhead", bare.stage.title, "guideway"):
        assert np.all(np.abs(point.losses[name]) <= ROUNDING * scale)


@st.composite
def moving_drives(draw):
    """A drive that a simulation can move, with any stage, and a gearhead and belt that may give way."""
    base = shipped_study("faulring2006").drives["motor2-gear4"]
    stage = draw(output_stages())
    if isinstance(stage, iv.Screw):  # one that does not jam
        stage = replace(stage, lead=0.3 * stage.diameter, efficiency=None, friction_angle=None)
        stage = replace(stage, backdriving_efficiency=None, friction_coefficient=draw(st.floats(0.0, 0.1)))
    if isinstance(stage, iv.Belt) and draw(st.booleans()):
        stage = replace(stage, specific_stiffness=draw(st.floats(2e4, 2e5)), span=0.3)
    gear = replace(
        base.gearhead, ratio=draw(st.floats(2, 20)), loss_model=draw(st.sampled_from(["coulomb", "proportional"]))
    )
    if draw(st.booleans()):
        gear = replace(gear, stiffness=draw(st.floats(5, 200)), backlash=draw(st.sampled_from([None, 0.005, 0.02])))
    guide = iv.Guideway() if stage.axis.rotary else iv.Guideway(friction=draw(st.floats(0, 5)))
    return replace(base, pulley=None, gearhead=gear, guideway=guide, output_inertia=1e-5, **{stage.title: stage})


@st.composite
def runs(draw, rotary):
    size = draw(st.floats(0.002, 0.02)) * draw(st.sampled_from([-1, 1])) * (20 if rotary else 1)
    return iv.Scenario(
        duration=0.15,
        output_step=0.01,
        load_mass=draw(st.floats(0.2, 2)) * (0.01 if rotary else 1),
        motion=draw(st.sampled_from([iv.Sinusoid(distance=size, frequency=4.0), iv.Reach(distance=size, time=0.1)])),
        force=iv.SinusoidalForce(
            size=draw(st.floats(1, 30)) * (0.02 if rotary else 1), frequency=draw(st.floats(1, 20))
        ),
        electrical=draw(st.sampled_from(["current", "voltage"])),
    )


def check_energy(data):
    drive = data.draw(moving_drives())
    run = iv.simulate(drive, data.draw(runs(drive.axis.rotary))).trajectory
    assert not run.outcome
    assert run.closure < CLOSURE == 1e-6
    moved = max(float(np.abs(energy).max()) for energy in [*run.supplied.values(), *run.lost.values()])
    for energy in run.lost.values():
        assert np.all(np.diff(energy) >= -1e-9 * moved)


@given(st.data())
@settings(max_examples=5)
def test_energy_over_time_closes(data):
    check_energy(data)


@pytest.mark.slow
@given(st.data())
@settings(max_examples=60)
def test_energy_of_more_drives_closes(data):
    check_energy(data)
