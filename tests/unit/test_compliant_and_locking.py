"""Drives with compliant gearheads and stages, self-locking screws, tables of lever arms, and measured gears: in simulation."""

import dataclasses
import math

import numpy as np
import pytest

import infinivar as iv
from infinivar import ParameterError
from infinivar.analysis import TwoWays
from infinivar.bondgraph import BondGraphError
from internals import ConventionalControl, bandwidths
from sampled import sampled

MOTOR = iv.motors()["dcx-32-l-24v"]
assert MOTOR.rotor_inertia is not None
ROTOR = 100 * MOTOR.rotor_inertia
"""Inertia of the rotor behind a gear of 10:1. [kg m^2]"""
SWING = iv.motion.Sinusoid(angle=0.4, frequency=0.8)
STROKE = iv.motion.Sinusoid(distance=0.03, frequency=0.8)
MEASURED = iv.parts.GearFriction(friction=0.02, viscous=0.001, load_motor=0.1, load_output=0.05, friction_stribeck=0.02)
STAGES = {
    "screw": {"screw": iv.parts.Screw(lead=0.01, diameter=0.016, efficiency=0.85)},
    "locking": {"screw": iv.parts.Screw(lead=0.01, diameter=0.016, friction_coefficient=0.22)},
    "rack": {"rack": iv.parts.Rack(module=1e-3, teeth=20, efficiency=0.9)},
    "belt": {"belt": iv.parts.Belt(pitch=3e-3, teeth=20, efficiency=0.9)},
}


def elastic(stiffness=600.0, **control):
    gear = iv.parts.Gearhead(ratio=10, efficiency=0.85, stiffness=stiffness)
    return iv.ConventionalDrive(
        motor=MOTOR, gearhead=gear, shaft=iv.parts.Shaft(), control=ConventionalControl(**control)
    )


def test_resonances_of_two_bodies_and_of_three():
    drive, inertia = elastic(), 0.01
    line = bandwidths.of(drive, 0.0, inertia).line
    free = math.sqrt(600.0 * (1 / inertia + 1 / ROTOR)) / (2 * math.pi)
    assert line.frequencies() == pytest.approx((math.sqrt(600.0 / inertia) / (2 * math.pi), free), rel=1e-12)
    belt = iv.parts.Belt(pitch=3e-3, teeth=20, specific_stiffness=1e5, span=0.5)
    both = iv.ConventionalDrive(motor=MOTOR, gearhead=drive.gearhead, belt=belt, output_inertia=1e-4)
    line = bandwidths.of(both, 0.0, 2.0).line
    assert line.names == ("gearhead", "belt")
    radius = float(belt.travel_per_radian)
    masses, springs = [ROTOR / radius**2, 1e-4 / radius**2, 2.0], [600.0 / radius**2, float(belt.stiffness or 0.0)]
    assert line.masses == pytest.approx(masses)
    assert line.stiffness == pytest.approx(springs)
    # The free resonances solve w^4 - p w^2 + q = 0.
    p = springs[0] * (1 / masses[0] + 1 / masses[1]) + springs[1] * (1 / masses[1] + 1 / masses[2])
    q = springs[0] * springs[1] * sum(masses) / math.prod(masses)
    assert line.frequencies()[1] == pytest.approx(math.sqrt(p / 2 - math.sqrt(p * p / 4 - q)) / (2 * math.pi), rel=1e-9)


def test_a_rigid_drive_has_the_default_bandwidths():
    rigid = dataclasses.replace(elastic(), gearhead=iv.parts.Gearhead(ratio=10, efficiency=0.85))
    found = bandwidths.of(rigid, 0.0, 0.05)
    assert (found.speed, found.link, found.stable, str(found)) == (25.0, 4.0, math.inf, "")


@pytest.mark.slow
@pytest.mark.parametrize("inertia", [pytest.param(0.005, marks=pytest.mark.slow), 0.05])
def test_the_default_loops_of_an_elastic_gearhead_are_stable(inertia):
    """The simulated energy is that of inverse dynamics, and the resonance is named as the reason of slower loops."""
    drive = elastic()
    found = bandwidths.of(drive, 0.0, inertia)
    assert found.speed == pytest.approx(0.5 * found.stable)
    assert found.link == pytest.approx(0.16 * found.speed)
    both = iv.analysis.two_ways(drive, iv.DutyCycle(motion=SWING, load_inertia=inertia))
    assert both.followed == pytest.approx(both.prescribed, rel=0.01)
    assert both.rms_error < 0.005 * 0.4
    assert "the speed loop is slowed to" in both.explanation
    assert "resonance of the gearhead at" in both.explanation


@sampled(("share", "grows"), [(0.9, False), (1.15, True)], every=2)
def test_the_largest_stable_bandwidth_separates_decay_from_growth(share, grows):
    """A disturbance of the load decays below it, and grows above it up to what the supply allows."""
    stable = bandwidths.of(elastic(), 0.0, 0.02).stable
    drive = elastic(speed_bandwidth=share * stable, link_bandwidth=0.16 * share * stable)
    start = iv.Scenario(duration=0.6, motion=SWING, load_inertia=0.02)
    speed = np.abs(iv.simulate(drive, start).trajectory.signals["motor_speed"])
    expected = 10 * 0.4 * 2 * math.pi * 0.8
    assert (np.max(speed[600:]) > 3 * expected) == grows


def test_a_stated_bandwidth_that_is_unstable_is_named_in_the_verdicts():
    drive = elastic(speed_bandwidth=25.0)
    run = iv.simulate(drive, iv.Scenario(duration=0.3, motion=SWING, load_inertia=0.05))
    limit = bandwidths.of(drive, 0.0, 0.05).stable
    said = (
        "the speed loop of 25 Hz is unstable, as it excites the resonance of the gearhead at 146 Hz (17.4 Hz with the motor "
        f"locked); set control.speed_bandwidth below {limit:.1f} Hz"
    )
    assert said in run.verdict
    assert not run.feasible
    assert len(run.events) > 20
    assert len(run.event_lines) <= 10
    assert any(line.endswith(" times") for line in run.event_lines)
    study = iv.Study(
        name="elastic", drives={"joint": drive}, duty={"swing": iv.DutyCycle(motion=SWING, load_inertia=0.05)}
    )
    found = iv.compare(study, quick=True)
    assert said in found.verdict
    assert said in found.to_dict()["duty"]["swing"]["drives"]["joint"]["caution"]


@pytest.mark.slow
@pytest.mark.parametrize("force", [-50.0, None])
def test_a_screw_far_beyond_its_friction_angle_does_not_chatter(force):
    """Its current suits a load that helps as well as one that resists; the controllers choose between them."""
    screw = iv.parts.Screw(lead=0.01, diameter=0.016, friction_coefficient=0.3, inertia=1e-5)
    drive = iv.ConventionalDrive(motor=MOTOR, gearhead=iv.parts.Gearhead(ratio=1.0, efficiency=0.95), screw=screw)
    both = iv.analysis.two_ways(drive, iv.DutyCycle(motion=STROKE, load_mass=2.0, force=force))
    assert both.followed == pytest.approx(both.prescribed, rel=0.005)
    assert both.rms_error < 4e-5
    assert np.mean(np.abs(np.diff(both.simulation.columns["motor_current_A"])) > 3.0) < 0.02


@sampled("stage", ["belt", "screw", "rack", "locking"], slow=4)
def test_a_measured_gear_with_a_stage_that_has_losses(stage):
    """Both losses follow their own laws at what they receive, and the energy is that of inverse dynamics."""
    gear = iv.parts.Gearhead(ratio=5, loss_model="stribeck", friction=MEASURED)
    drive = iv.ConventionalDrive(motor=MOTOR, gearhead=gear, **STAGES[stage])
    both = iv.analysis.two_ways(drive, iv.DutyCycle(motion=STROKE, load_mass=1.0, force=-20.0))
    assert both.followed == pytest.approx(both.prescribed, rel=0.02)
    run = both.simulation.trajectory
    part, moved = drive.stage, np.abs(run.signals["ldot"]) > 1e-3
    turning = run.signals["ldot"] / float(part.travel_per_radian)
    torque = run.signals[f"{part.title}_torque"]
    lost = run.at(f"{part.title}_loss")[0]
    assert lost[moved] == pytest.approx(
        np.asarray(part.friction(speed=turning, torque=torque))[moved], rel=1e-6, abs=1e-9
    )
    own = gear.load_friction(turning * 5, run.signals["gear_torque"])
    assert run.at("gear_loss")[0][moved] == pytest.approx(np.asarray(own)[moved], rel=1e-6, abs=1e-9)


@sampled(("gear", "rows"), [({"loss_model": "proportional"}, 5), ({}, 300), ({}, 5)], slow=2)
def test_a_table_of_equal_lever_arms_is_a_lever_with_a_screw(gear, rows):
    """The table's spline is a part of the equations that is evaluated once, not written out in the loop of the losses."""

    def drive(**linkage):
        output = iv.Output(linkage=iv.parts.Linkage(**linkage))
        return iv.ConventionalDrive(motor=MOTOR, gearhead=geared, output=output, **STAGES["screw"])

    geared = iv.parts.Gearhead(ratio=4, efficiency=0.9, **gear)
    angles = tuple(np.linspace(-0.7, 0.7, rows).tolist())
    scenario = iv.Scenario(duration=0.02, motion=iv.motion.Sinusoid(angle=0.35, frequency=1.0), load_inertia=0.05)
    table = iv.simulate(drive(shape="table", angles=angles, arms=(0.05,) * rows), scenario)
    lever = iv.simulate(drive(shape="lever", arm=0.05), scenario)
    spent = [sum(energy[-1] for energy in run.trajectory.supplied.values()) for run in (table, lever)]
    assert spent[0] == pytest.approx(spent[1], rel=1e-6)


@pytest.mark.slow
def test_a_drive_that_cannot_be_simulated_does_not_stop_the_comparison(monkeypatch):
    refused = dataclasses.replace(elastic(), gearhead=iv.parts.Gearhead(ratio=12, efficiency=0.85))
    original = iv.simulate

    def simulate(drive, *args, **kwargs):
        if drive.gearhead.ratio == 12:
            raise BondGraphError("graph: the laws of gear_loss depend on each other in an algebraic loop")
        return original(drive, *args, **kwargs)

    monkeypatch.setattr("infinivar.analysis.cycles.tracking.simulate", simulate)
    duty = {"swing": iv.DutyCycle(motion=SWING, load_inertia=0.001)}
    found = iv.compare(iv.Study(name="two", drives={"refused": refused, "other": elastic()}, duty=duty)).duty["swing"]
    assert found.two_ways["refused"] == "graph: the laws of gear_loss depend on each other in an algebraic loop"
    assert isinstance(found.two_ways["other"], TwoWays)
    assert all(result.feasible for result in found.results.values())


def test_a_locking_screw_behind_an_elastic_gearhead_needs_an_inertia():
    drive = dataclasses.replace(elastic(), shaft=None, **STAGES["locking"])
    with pytest.raises(
        ParameterError, match=r"output_inertia is missing: a self-locking screw behind gearhead\.stiffness"
    ):
        iv.simulate(drive, iv.Scenario(duration=0.1, motion=STROKE, load_mass=0.5))


def test_losses_of_a_gear_leave_less_room_for_a_locking_screw():
    """The rotor pulls the screw through the gear, whose losses multiply what the screw asks for."""
    screw = iv.parts.Screw(lead=0.01, diameter=0.016, friction_coefficient=0.3)

    def most(efficiency):
        gear = iv.parts.Gearhead(ratio=1.0, efficiency=efficiency, loss_model="proportional")
        drive = iv.ConventionalDrive(motor=MOTOR, gearhead=gear, screw=screw)
        with pytest.raises(ParameterError, match=r"load_mass must be < [\d.]+ kg") as caught:
            iv.simulate(drive, iv.Scenario(duration=0.1, motion=STROKE, load_mass=50.0))
        return float(str(caught.value).split("< ")[1].split(" kg")[0])

    assert most(0.5) == pytest.approx(0.5 * most(1.0), rel=0.01)
