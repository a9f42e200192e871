"""Screws, belts and elastic gearheads over time: against inverse dynamics, closed forms and their rigid limits."""

import math
from dataclasses import replace

import numpy as np
import pytest

import infinivar as iv
from infinivar import Limit, Output, Scenario
from infinivar.motion import ConstantForce, Reach, Rest, Sinusoid
from infinivar.parts import Linkage
from internals import compliances, passed_both_ways
from sampled import sampled

MOTOR = iv.parts.Motor(
    voltage=48.0,
    resistance=0.6,
    torque_constant=0.05,
    no_load_current=0.15,
    continuous_torque=0.15,
    rotor_inertia=1e-5,
    inductance=0.3e-3,
)
GEAR = iv.parts.Gearhead(ratio=5.0, efficiency=0.9, loss_model="proportional", backdriving_efficiency=0.85)
DIRECT = iv.parts.Gearhead(ratio=1.0, efficiency=1.0)
BALL = iv.parts.Screw(shape="ball", lead=5e-3, diameter=16e-3, efficiency=0.9, friction_torque=5e-3)
LOCKING = iv.parts.Screw(lead=2e-3, diameter=9e-3, friction_coefficient=0.15, flank_angle=math.radians(15.0))
BELT = iv.parts.Belt(pitch=3e-3, teeth=20, efficiency=0.96, backdriving_efficiency=0.94, friction_torque=5e-3)
STRETCH = {"specific_stiffness": 1e5, "span": 0.4, "other_span": 0.8}


def drive(gearhead=GEAR, **stage):
    guideway = iv.parts.Guideway(friction=0.0 if "shaft" in stage else 4.0)
    return iv.ConventionalDrive(motor=MOTOR, gearhead=gearhead, guideway=guideway, output_inertia=2e-6, **stage)


SINUSOID = Sinusoid(distance=0.03, frequency=1.0)

PAIRS = {
    "ball screw": drive(DIRECT, screw=BALL),
    "ball screw behind a lossy gear": drive(replace(GEAR, ratio=1.5), screw=BALL),
    "self-locking screw": drive(DIRECT, screw=LOCKING),
    "belt": drive(belt=BELT),
    "belt that stretches": drive(belt=replace(BELT, **STRETCH)),
    "rack on an elastic gear": drive(
        replace(GEAR, stiffness=40.0), rack=iv.parts.Rack(module=1e-3, teeth=20, efficiency=0.95)
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", [one if place % 2 else pytest.param(one, marks=pytest.mark.slow) for place, one in enumerate(PAIRS)]
)
def test_inverse_dynamics_and_simulation_agree(name):
    """A weight moved up and down: energy from the supply, and the loss of the stage, within 2 %; both audits close."""
    machine = PAIRS[name]
    duty = iv.DutyCycle(motion=SINUSOID, force=-40.0, load_mass=4.0)
    ways = iv.analysis.two_ways(machine, duty)
    assert ways.followed == pytest.approx(ways.prescribed, rel=0.02)
    title = machine.stage.title
    assert ways.lost_followed[title] == pytest.approx(ways.lost_prescribed[title], rel=0.02)
    assert ways.simulation.trajectory.closure < 1e-6
    assert iv.duty_cycle(machine, duty).closure < 1e-9


@sampled(("share", "moves"), [(0.9, True), (1.02, False), (2.0, False)], every=3)
def test_a_screw_holds_its_load_without_current_beyond_its_lead_angle(share, moves):
    """Motor without current and without friction of its own: 200 N drive the screw back only below rho = lambda."""
    part = iv.parts.Screw(lead=2e-3, diameter=9e-3, friction_angle=share * float(LOCKING.lead_angle))
    machine = replace(drive(DIRECT, screw=part), motor=MOTOR.without_friction(), guideway=iv.parts.Guideway())
    run = iv.simulate(
        machine, Scenario(duration=0.5, link="free", force=ConstantForce(size=-200.0), load_mass=5.0, output_step=0.05)
    )
    travel = abs(run.columns["position_m"][-1])
    assert run.trajectory.closure < 1e-6
    if not moves:
        assert travel < 0.5 * 1e-5  # no faster than the stick speed
        return
    # Constant acceleration: torque F r eta' on rotor, screw and load, whose inertia is driven through the screw as well.
    r, backward = part.travel_per_radian, part.efficiencies[1]
    turning = MOTOR.rotor_inertia + 2e-6
    expected = 200.0 * r * backward / (turning + backward * 5.0 * r * r) * r * 0.5**2 / 2.0
    assert travel == pytest.approx(expected, rel=1e-3)


def test_a_screw_that_jams_is_refused():
    """The boundary is where the inertia that turns equals that of the load times how much the screw locks."""
    machine, r = drive(DIRECT, screw=LOCKING), LOCKING.travel_per_radian
    most = (MOTOR.rotor_inertia + 2e-6) / (-LOCKING.efficiencies[1] * r * r)
    scenario = Scenario(duration=0.01, motion=Reach(distance=0.01, time=0.5), load_mass=0.99 * most)
    assert iv.simulate(machine, scenario).complete
    with pytest.raises(iv.ParameterError, match=r"load_mass must be < .* kg.*self-locking screw jams"):
        iv.simulate(machine, replace(scenario, load_mass=1.01 * most))
    with pytest.raises(iv.ParameterError, match="'imposed' cannot move a self-locking screw"):
        iv.simulate(machine, replace(scenario, link="imposed"))


def test_a_self_locking_screw_is_held_without_current():
    """After a lift the load rests: the controller leaves it to friction, and the current goes to nearly zero."""
    machine = drive(DIRECT, screw=LOCKING)
    scenario = Scenario(
        duration=0.6, motion=Reach(distance=0.005, time=0.3), force=ConstantForce(size=-40.0), load_mass=4.0
    )
    run = iv.simulate(machine, scenario)
    unaided = 40.0 * LOCKING.travel_per_radian / MOTOR.torque_constant
    assert abs(run.columns["motor_current_A"][-1]) < 0.02 * unaided
    assert run.position_error[-1] < 2e-4


@pytest.mark.parametrize("gear", [GEAR, replace(GEAR, loss_model="coulomb", backdriving_efficiency=None)])
@pytest.mark.parametrize("stage", [BALL, LOCKING, BELT])
def test_controllers_know_the_friction_of_gear_and_stage(gear, stage):
    """Ratio of currents with and without the load's force, driving and driven, as the steady drive has them."""
    machine = drive(gear, **{stage.title: stage})
    gain = MOTOR.torque_constant * gear.ratio / float(stage.travel_per_radian)
    for speed, passed in zip((0.01, -0.01), passed_both_ways(machine), strict=True):
        light, heavy = (float(machine.operate(speed=speed, force=f).states["motor_current_A"]) for f in (1e5, 2e5))
        assert (heavy - light) * gain / 1e5 == pytest.approx(passed, rel=1e-9)


def reversing(gearhead, duration=2.0):
    """A load that friction holds, moved to and fro by a motor with an encoder."""
    machine = drive(gearhead, pulley=iv.parts.Pulley(radius=0.01))
    scenario = Scenario(
        duration=duration, motion=Sinusoid(distance=0.01, frequency=1.0), load_mass=1.0, output_step=duration / 4000
    )
    return machine, iv.simulate(machine, scenario)


def lost_motion(run, machine):
    """Difference of motor angle, at the gear output, and load angle, between both directions of slow motion."""
    turned = run.trajectory.signals["motor_angle"] / machine.gearhead.ratio - run.columns["position_m"] / 0.01
    late = run.columns["time_s"] > 1.0
    return np.percentile(turned[late], 99) - np.percentile(turned[late], 1)


@pytest.mark.slow
def test_backlash_is_lost_at_each_reversal():
    """Backlash and the twist under the friction of the guideway, of which the motor turns in vain."""
    angle, stiffness = math.radians(1.5), 40.0
    machine, run = reversing(replace(GEAR, stiffness=stiffness, backlash=angle))
    assert run.trajectory.closure < 1e-6
    _, rigid = reversing(replace(GEAR, stiffness=stiffness))
    assert lost_motion(run, machine) - lost_motion(rigid, machine) == pytest.approx(angle, rel=0.02)
    # The load stands still while the flanks change, longer than without backlash.
    still = [np.mean(np.abs(one.columns["speed_m_s"]) < 1e-4) for one in (run, rigid)]
    assert still[0] > 2.0 * still[1]


def test_backlash_alone_leaves_a_gear_open():
    """Within the backlash the load moves freely: 20 mm/s for half of 2 deg, then the flank."""
    angle = math.radians(2.0)
    torque = compliances.dead_zone(np.array([-angle, -0.5 * angle, 0.0, 0.4 * angle, angle]), 50.0, angle)
    np.testing.assert_allclose(torque, 50.0 * np.array([-0.5, 0.0, 0.0, 0.0, 0.5]) * angle, atol=1e-15)
    steps = np.linspace(-angle, angle, 2001)
    energy = compliances.dead_zone_energy(steps, 50.0, angle)
    np.testing.assert_allclose(np.gradient(energy, steps), compliances.dead_zone(steps, 50.0, angle), atol=1e-3)
    random = np.random.default_rng(1)
    speed, twist = random.uniform(-5, 5, 1000), random.uniform(-angle, angle, 1000)
    torque = compliances.touching_damper(speed, twist, 0.1, angle)
    assert np.all(torque * speed >= 0)
    assert np.all(torque[np.abs(twist) < 0.5 * angle] == 0)
    assert np.all(np.abs(torque) <= 0.1 * np.abs(speed))


@pytest.mark.slow
def test_a_stiff_gear_is_a_rigid_gear():
    """The twist falls as 1/k: a tenfold stiffness has a tenth of the difference to the rigid gear."""
    scenario = Scenario(
        duration=0.5, motion=Reach(distance=0.02, time=0.3), force=ConstantForce(size=-30.0), load_mass=2.0
    )
    rigid = iv.simulate(drive(belt=BELT), scenario).columns["position_m"]
    ends = {}
    for stiffness in (20.0, 200.0, 2000.0):
        run = iv.simulate(drive(replace(GEAR, stiffness=stiffness), belt=BELT), scenario)
        assert run.trajectory.closure < 1e-6
        ends[stiffness] = np.max(np.abs(run.columns["position_m"] - rigid))
    assert ends[200.0] < 0.2 * ends[20.0]
    assert ends[2000.0] < 2e-5


@pytest.mark.slow
def test_a_belt_stretches_by_force_over_stiffness():
    """At rest under a weight the load hangs lower than the motor by F/k, without friction of the guideway."""
    part = replace(BELT, **STRETCH)
    machine = replace(drive(belt=part), guideway=iv.parts.Guideway())
    scenario = Scenario(duration=0.3, motion=Rest(), force=ConstantForce(size=-200.0), load_mass=2.0)
    run = iv.simulate(machine, scenario)
    turned = run.trajectory.signals["motor_angle"] / GEAR.ratio * part.travel_per_radian
    sunk = turned[-1] - run.columns["position_m"][-1]
    # The start has this stretch already: only its change shows.
    assert sunk == pytest.approx(0.0, abs=1e-7)
    force, _ = run.trajectory.at("belt_spring")
    assert force[-1] == pytest.approx(200.0, rel=1e-4)


@pytest.mark.slow
def test_limits_of_a_screw_over_time():
    """Buckling and speed are events; rated life is one demand of the whole run."""
    part = replace(
        BALL, length=1.2, root_diameter=4e-3, ends="fixed-free", max_speed=20.0, dynamic_load=1000.0, life=3.6e10
    )
    scenario = Scenario(
        duration=0.5, motion=Reach(distance=0.05, time=0.4), force=ConstantForce(size=-40.0), load_mass=4.0
    )
    run = iv.simulate(drive(DIRECT, screw=part), scenario)
    found = {event.limit for event in run.events if event.what == "screw"}
    assert found == {Limit.BUCKLING, Limit.OUTPUT_SPEED, Limit.LIFE, Limit.CRITICAL_SPEED}
    (life,) = (event for event in run.events if event.limit == Limit.LIFE)
    assert (life.start, life.end) == (0.0, 0.5)


@pytest.mark.slow
def test_a_geared_shaft_turns_a_joint_over_time():
    machine = drive(shaft=iv.parts.Shaft(friction_torque=0.05))
    run = iv.simulate(machine, Scenario(duration=0.6, motion=Reach(angle=0.5, time=0.4), load_inertia=0.02))
    assert run.trajectory.closure < 1e-6
    assert run.trajectory.signals["l"][-1] == pytest.approx(0.5, abs=1e-3)


@pytest.mark.parametrize(
    ("machine", "words"),
    [
        (drive(belt=replace(BELT, **STRETCH)), "load_mass is missing: the stretch of the belt"),
        (replace(drive(replace(GEAR, stiffness=9.0), belt=BELT), output_inertia=None), "output_inertia is missing: gearhead"),
    ],
)  # fmt: skip
def test_missing_inertias_are_named(machine, words):
    with pytest.raises(iv.ParameterError, match=words):
        iv.simulate(machine, Scenario(duration=0.01, motion=Rest()))


def test_backlash_needs_a_stiffness():
    with pytest.raises(iv.ParameterError, match="stiffness is missing: backlash needs it"):
        replace(GEAR, backlash=0.01)


@pytest.mark.slow
def test_a_geared_shaft_moves_a_joint_by_a_four_bar():
    """Inverse dynamics and simulation of the same swing within 2 %; both audits close."""
    linkage = Linkage(shape="four-bar", base=0.2, arm=0.06, crank=0.05, coupler=0.2, offset=1.5)
    gear = replace(GEAR, loss_model="coulomb", backdriving_efficiency=None)
    machine = replace(drive(gear, shaft=iv.parts.Shaft(friction_torque=0.02)), output=Output(linkage=linkage))
    ways = iv.analysis.two_ways(
        machine, iv.DutyCycle(motion=Sinusoid(angle=0.3, frequency=1.0), moment=-2.0, load_inertia=0.03)
    )
    assert ways.followed == pytest.approx(ways.prescribed, rel=0.02)
    assert ways.simulation.trajectory.closure < 1e-6
    with pytest.raises(iv.ParameterError, match="needs a drive that moves along a line; use four-bar"):
        replace(machine, output=Output(linkage=Linkage(shape="lever", arm=0.1)))
    with pytest.raises(iv.ParameterError, match="needs a drive that moves about a shaft"):
        replace(drive(belt=BELT), output=Output(linkage=linkage))


@sampled("stage", [{"belt": BELT}, {"screw": BALL}], every=2)
@pytest.mark.parametrize("inertia", [None, 0.0])
def test_the_rotor_is_inertia_enough(stage, inertia):
    """No inertia at the gear output is the limit of a small one, by inverse dynamics and in closed loop."""
    bare = replace(drive(**stage), output_inertia=inertia)
    small = replace(bare, output_inertia=1e-12)
    duty = iv.DutyCycle(motion=SINUSOID, load_mass=2.0)
    assert iv.duty_cycle(bare, duty).energy == pytest.approx(iv.duty_cycle(small, duty).energy, rel=1e-6)
    scenario = Scenario(duration=0.1, motion=Reach(distance=5e-3, time=0.08), load_mass=2.0)
    runs = [iv.simulate(one, scenario) for one in (bare, small)]
    assert all(run.trajectory.closure < 1e-6 for run in runs)
    ends = [run.trajectory.signals["l"][-1] for run in runs]
    assert ends[0] == pytest.approx(ends[1], abs=1e-7)
    with pytest.raises(iv.ParameterError, match=r"motor.rotor_inertia is missing"):
        replace(bare, motor=replace(bare.motor, rotor_inertia=None)).check_motion()


@pytest.mark.slow
def test_peaks_of_a_gearhead_are_those_of_inverse_dynamics():
    """A load shaken along a rack, with ratings of half the peaks: the run exceeds them as motor and continuous rating."""
    still = drive(rack=iv.parts.Rack(module=1e-3, teeth=20, efficiency=0.95))
    load = {"load_mass": 2.0}
    motion = Sinusoid(distance=0.02, frequency=3.0)
    point = iv.duty_cycle(still, iv.DutyCycle(motion=motion, **load)).point
    torque = np.max(np.abs(point.states["gear_output_torque_Nm"]))
    speed = np.max(np.abs(point.states["motor_speed_rad_s"]))
    rated = replace(still, gearhead=replace(GEAR, intermittent_torque=0.5 * torque, max_input_speed=0.5 * speed))
    demands = iv.duty_cycle(rated, iv.DutyCycle(motion=motion, **load)).demands
    assert demands[Limit.GEAR_PEAK, "gearhead"] == pytest.approx(2.0, rel=1e-12)
    assert demands[Limit.GEAR_SPEED, "gearhead"] == pytest.approx(2.0, rel=1e-12)
    both = replace(
        rated,
        gearhead=replace(rated.gearhead, continuous_torque=0.5 * torque),
        motor=replace(MOTOR, max_speed=0.5 * speed),
    )
    run = iv.simulate(both, Scenario(motion=motion, duration=1.0, **load))
    worst = {limit: [event.worst for event in run.events if event.limit == limit] for limit in Limit}
    assert worst[Limit.GEAR_SPEED] == pytest.approx(worst[Limit.SPEED], rel=1e-9)
    assert worst[Limit.GEAR_PEAK] == pytest.approx(worst[Limit.GEAR], rel=1e-9)
    assert np.median(worst[Limit.GEAR_SPEED]) == pytest.approx(2.0, rel=0.02)
    assert np.median(worst[Limit.GEAR_PEAK]) == pytest.approx(2.0, rel=0.1)  # the controller corrects at reversals
