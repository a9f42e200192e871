"""Drives with any output stage: power balances in all four quadrants, at rest, and over time."""

from dataclasses import replace

import numpy as np
import pytest
from designs import POINTS, amplifiers, gearheads, motors, output_stages, seeds
from hypothesis import given
from hypothesis import strategies as st
from test_motion import ROUNDING, assert_balanced, courses, inertias, with_rotor

import infinivar as iv
from internals import AUDIT_CLOSURE as CLOSURE
from made import parameter_study
from sampled import sampled

SHIPPED = parameter_study("faulring2006")


@st.composite
def drives(draw, stages=None):
    stage = draw(stages if stages is not None else output_stages())
    return iv.ConventionalDrive(
        motor=with_rotor(draw(motors()), draw(inertias)),
        gearhead=replace(draw(gearheads()), inertia=draw(inertias)),
        amplifier=draw(amplifiers()),
        # A shaft has friction of its own.
        guideway=iv.parts.Guideway(friction=0.0 if stage.axis.rotary else draw(st.floats(0, 10))),
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
    bare = drive.without_static_friction()
    point = bare.follow(courses(seed))
    scale = np.abs(point.power_out) + np.abs(point.power_in)
    for name in ("gearhead", bare.stage.title, "guideway"):
        assert np.all(np.abs(point.losses[name]) <= ROUNDING * scale)


def moving_drive(random):
    """A drive that a simulation can move, with any stage, and a gearhead and belt that may give way."""
    friction = random.uniform(0, 0.05)
    stretch = {"specific_stiffness": random.uniform(2e4, 2e5), "span": 0.3} if random.random() < 0.5 else {}
    lossy = {
        "efficiency": random.uniform(0.3, 1),
        "backdriving_efficiency": random.uniform(0, 1),
        "friction_torque": friction,
    }
    teeth, sliding = int(random.integers(12, 60)), random.uniform(0, 0.1)
    stages = [
        iv.parts.Pulley(radius=random.uniform(0.005, 0.05), friction_torque=friction),
        iv.parts.Screw(lead=5e-3, diameter=16e-3, friction_coefficient=sliding, friction_torque=friction),
        iv.parts.Belt(pitch=3e-3, teeth=teeth, **lossy, **stretch),
        iv.parts.Rack(module=random.uniform(0.5e-3, 3e-3), teeth=20, **lossy),
        iv.parts.Shaft(friction_torque=friction),
    ]
    stage = stages[random.integers(len(stages))]
    base = SHIPPED.drives["motor2-gear4"]
    model = ["coulomb", "proportional"][random.integers(2)]
    gear = replace(base.gearhead, ratio=random.uniform(2, 20), loss_model=model)
    if random.random() < 0.5:
        gear = replace(gear, stiffness=random.uniform(5, 200), backlash=[None, 0.005, 0.02][random.integers(3)])
    guide = iv.parts.Guideway(friction=0.0 if stage.axis.rotary else random.uniform(0, 5))
    return replace(base, gearhead=gear, guideway=guide, output_inertia=1e-5, **{"pulley": None, stage.title: stage})


def run_of(random, rotary):
    size = random.uniform(0.002, 0.02) * random.choice([-1, 1]) * (20 if rotary else 1)
    pull, frequency = random.uniform(1, 30) * (0.02 if rotary else 1), random.uniform(1, 20)
    mass = random.uniform(0.2, 2) * (0.01 if rotary else 1)
    way = {"angle" if rotary else "distance": size}
    motions = [iv.motion.Sinusoid(frequency=4.0, **way), iv.motion.Reach(time=0.1, **way)]
    return iv.Scenario(
        duration=0.15,
        output_step=0.01,
        motion=motions[random.integers(2)],
        force=iv.motion.SinusoidalForce(frequency=frequency, **{"moment" if rotary else "size": pull}),
        electrical=["current", "voltage"][random.integers(2)],
        **{"load_inertia" if rotary else "load_mass": mass},
    )


@sampled(
    "seed",
    [
        *range(8),
        *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(8, 20)),
        *(pytest.param(seed, marks=pytest.mark.full) for seed in range(20, 150)),
    ],
    every=4,
)
def test_energy_over_time_closes(seed):
    random = np.random.default_rng(seed)
    drive = moving_drive(random)
    run = iv.simulate(drive, run_of(random, drive.axis.rotary)).trajectory
    assert not run.outcome
    assert run.closure < CLOSURE == 1e-6
    moved = max(float(np.abs(energy).max()) for energy in [*run.supplied.values(), *run.lost.values()])
    for energy in run.lost.values():
        assert np.all(np.diff(energy) >= -1e-9 * moved)
