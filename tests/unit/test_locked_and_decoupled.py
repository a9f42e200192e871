"""What no other transmission does: lock, decouple, and slip where it must."""

import math
from dataclasses import replace

import numpy as np
import pytest

import infinivar as iv
from infinivar import Scenario
from infinivar.motion import ConstantForce, Cruise, Sinusoid, SinusoidalForce
from sampled import sampled


def locked(drive, force, cylinder="running", duration=0.5):
    scenario = Scenario(
        duration=duration, steering="locked", cylinder=cylinder, load_mass=0.8, force=ConstantForce(size=force)
    )
    return iv.simulate(drive, scenario)


@pytest.fixture
def drive(study):
    return study.drives["cobotic"]


def test_a_locked_link_moves_by_creep_only(drive):
    """At 99 % of slip the wheel drifts at the creepage of the linear law, 0.99/K of the surface speed."""
    groups = drive.transmission.groups(drive.cylinder_speed)
    drag = drive.guideway.friction_force(drive.transmission.preload)
    force = -(0.99 * groups.slip_force + drag)
    result = locked(drive, force)
    surface = drive.transmission.cylinder_radius * drive.cylinder_speed
    assert result.columns["speed_m_s"][-1] == pytest.approx(-0.99 / groups.creep_group * surface, rel=1e-3)
    assert result.columns["slip_ratio"][-1] == pytest.approx(-0.99, rel=1e-4)
    assert result.feasible


def test_a_locked_link_stands_while_the_cylinder_stands(drive):
    """What should stick creeps at most with the stick speed over K: 0.2 um/s here, and in proportion to it."""
    groups = drive.transmission.groups(drive.cylinder_speed)
    result = locked(drive, -0.99 * groups.slip_force, cylinder="at rest")
    assert result.feasible
    bound = 1e-4 / groups.creep_group
    assert 0.0 < -result.columns["speed_m_s"][-1] < bound < 3e-7
    assert abs(result.columns["position_m"][-1]) < 2e-7
    scenario = replace(result.scenario, stick_speed=1e-5)
    closer = iv.simulate(drive, scenario)
    assert -closer.columns["speed_m_s"][-1] < 0.1 * bound


@pytest.mark.parametrize("cylinder", ["running", "at rest"])
def test_above_slip_it_says_slip(drive, cylinder):
    """The link is accelerated by what the contact cannot hold."""
    groups = drive.transmission.groups(drive.cylinder_speed)
    drag = drive.guideway.friction_force(drive.transmission.preload)
    force = -(1.05 * groups.slip_force + drag)
    result = locked(drive, force, cylinder, duration=0.1)
    assert result.exceeded == ("wheel slip (wheel)",)
    expected = -0.05 * groups.slip_force / (0.8 + drive.link_mass) * 0.1
    assert result.columns["speed_m_s"][-1] == pytest.approx(expected, rel=0.02)
    assert result.trajectory.lost["slip"][-1] > 0.0


@pytest.mark.slow
def test_a_decoupled_wheel_carries_no_torque(drive):
    """At a right angle the link feels rolling resistance and its guideway only; nothing reaches the cylinder."""
    scenario = Scenario(
        duration=1.0,
        link="imposed",
        steering="decoupled",
        cylinder="at rest",
        load_mass=0.8,
        motion=Cruise(speed=0.3),
    )
    result = iv.simulate(drive, scenario)
    run = result.trajectory
    torque = run.efforts["cylinder.cylinder", "transmission.surface"]
    groups = drive.transmission.groups(drive.cylinder_speed)
    assert np.abs(torque).max() < 1e-8 * drive.transmission.cylinder_radius * groups.slip_force
    assert np.abs(run.signals["omega"]).max() < 1e-8
    drag = drive.guideway.friction_force(drive.transmission.preload) + groups.rolling_force
    assert result.columns["force_N"][-1] == pytest.approx(drag, rel=1e-9)


def test_a_decoupled_wheel_grinds_on_a_turning_cylinder(drive):
    """The paper's remark: at a right angle the cylinder cannot turn. It slides, and says so."""
    scenario = Scenario(duration=0.2, link="free", steering="decoupled", load_mass=0.8)
    result = iv.simulate(drive, scenario)
    assert "wheel slip (wheel)" in result.exceeded
    assert result.trajectory.lost["slip"][-1] > result.trajectory.lost["creep"][-1]


def test_a_servo_holds_the_angle_asked_for(drive):
    """Nothing of the transmission's power reaches the steering: held at 20 degrees under load it takes no current."""
    angle = math.radians(20.0)
    scenario = Scenario(
        duration=0.3, link="free", steering="held", steering_angle=angle, load_mass=0.8, force=ConstantForce(size=-20.0)
    )
    result = iv.simulate(drive, scenario)
    assert np.abs(result.columns["steering_angle_rad"] - angle).max() < 1e-12
    assert np.abs(result.columns["steering_current_A"]).max() < 1e-9


def test_a_law_with_a_flow_loss_has_no_force_in_motion(drive):
    bent = replace(drive, transmission=replace(drive.transmission, creep_law="faulring"))
    with pytest.raises(ValueError, match=r"creep_law must be one of linear, .*got 'faulring'"):
        locked(bent, -10.0)


@sampled("law", ["vermeulen-johnson", "polach", "fastsim"], every=3)
def test_other_creep_laws_hold_and_slip_alike(drive, law):
    """The locked wheel drifts as the law says at the force, and the steady element agrees."""
    bent = replace(drive, transmission=replace(drive.transmission, creep_law=law))
    result = locked(bent, -40.0)
    drag = drive.guideway.friction_force(drive.transmission.preload)
    steady = bent.transmission.operate(
        cylinder_speed=result.trajectory.signals["omega"][-1], steering_angle=0.0, link_force=40.0 - drag
    )
    assert result.columns["speed_m_s"][-1] == pytest.approx(float(steady.link_speed), rel=1e-4)


def test_a_wheel_that_is_led_follows(drive):
    """The load moved by hand: the wheel is steered along. It slips while its servo lags: slip is 1.7 mm/s, 0.2 degrees, away."""
    scenario = Scenario(
        duration=0.5,
        link="imposed",
        load_mass=0.8,
        motion=Sinusoid(distance=0.01, frequency=2.0),
    )
    result = iv.simulate(drive, scenario)
    assert np.abs(result.columns["slip_ratio"]).max() <= 1.0
    np.testing.assert_allclose(result.columns["position_m"], result.columns["wanted_position_m"], atol=1e-6)
    expected = -np.arctan(result.columns["speed_m_s"] / (0.05 * result.columns["cylinder_speed_rad_s"]))
    assert np.abs(result.columns["steering_angle_rad"] - expected)[250:].max() < 0.02


def test_a_free_link_needs_a_wheel_that_is_kept(drive):
    with pytest.raises(ValueError, match="has no motion to follow with link = 'free'"):
        iv.simulate(drive, Scenario(duration=0.1, link="free", load_mass=0.8))


def test_limits_of_parts_are_events(study):
    """A gearhead, a motor and an amplifier that are too small for the motion: each is named, with its time."""
    base = study.drives["motor2-gear4"]
    weak = replace(
        base,
        gearhead=replace(base.gearhead, continuous_torque=0.05),
        motor=replace(base.motor, max_speed=100.0),
        amplifier=iv.parts.Amplifier(regeneration="none"),
    )
    scenario = Scenario(duration=0.5, load_mass=2.0, motion=Sinusoid(distance=0.05, frequency=2.0))
    result = iv.simulate(weak, scenario)
    met = {event.limit for event in result.events}
    assert met >= {iv.Limit.GEAR, iv.Limit.SPEED, iv.Limit.REGENERATION}
    fast = next(event for event in result.events if event.limit == iv.Limit.SPEED and event.start > 0.1)
    # The shaft passes 100 rad/s where |cos| of the motion does; the load lags by less than a hundredth of the period.
    share = 100.0 * 0.005 / 4.0 / (0.05 * 2 * math.pi * 2.0)
    assert fast.start == pytest.approx((math.pi - math.acos(share)) / (2 * math.pi * 2.0), abs=5e-3)


@pytest.mark.parametrize(
    ("load", "output"), [(0.8, 2e-5), (None, 2e-5), (None, None)], ids=["load", "pulley", "motor alone"]
)
def test_a_drive_begins_with_the_speed_of_its_motion(study, load, output):
    """Whichever inertia carries the state: that of load, pulley or rotor."""
    drive = replace(study.drives["motor2-gear4"], output_inertia=output)
    scenario = Scenario(
        duration=0.02,
        load_mass=load,
        motion=Cruise(speed=0.3),
        electrical="current",
    )
    result = iv.simulate(drive, scenario)
    assert result.columns["speed_m_s"][0] == pytest.approx(0.3)
    assert result.position_error.max() < 1e-3


@pytest.mark.slow
@sampled("method", ["Radau", "BDF", "CVODES"], every=2)
def test_every_solver_gives_the_same_motion(study, method):
    """With a moving input from outside, which CVODES takes as a cubic between samples, and energies to 1e-5."""
    drive = study.drives["motor2-gear4"]
    scenario = Scenario(
        duration=0.1,
        output_step=0.005,
        load_mass=0.8,
        motion=Sinusoid(distance=0.02, frequency=3.0),
        force=SinusoidalForce(size=20.0, frequency=25.0),
    )
    expected, found = (iv.simulate(drive, replace(scenario, method=name)) for name in ("LSODA", method))
    np.testing.assert_allclose(found.columns["position_m"], expected.columns["position_m"], atol=1e-8)
    for name, energy in expected.trajectory.lost.items():
        assert found.trajectory.lost[name][-1] == pytest.approx(energy[-1], rel=1e-5, abs=1e-9)
