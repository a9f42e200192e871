"""Drives in time: the energy balance closes whatever the machine, and motion left to settle is the steady point."""

from dataclasses import replace

import numpy as np
import pytest
from designs import seeds
from hypothesis import given
from hypothesis import strategies as st

import infinivar as iv
from infinivar import Scenario
from infinivar.motion import ConstantForce, Cruise, Reach, Sinusoid, SinusoidalForce, Step
from internals import AUDIT_CLOSURE as CLOSURE
from internals import CoboticControl, ConventionalControl
from made import parameter_study
from sampled import examples, sampled

SHIPPED = parameter_study("faulring2006")


@st.composite
def cobotic_drives(draw):
    """A shipped cobotic drive with other sizes, laws, gear and friction, no part of it lossless or massless."""
    base = SHIPPED.drives[draw(st.sampled_from(["cobotic", "cobotic-b"]))]
    element = base.transmission
    slip = element.slip_force
    return replace(
        base,
        transmission=iv.RotaryLinearIVT(
            cylinder_radius=draw(st.floats(0.02, 0.1)),
            wheel_radius=element.wheel_radius,
            preload=element.preload,
            friction=element.friction,
            creep_stiffness=slip * draw(st.floats(100, 1000)),
            rolling_torque=slip * element.wheel_radius * draw(st.floats(0, 0.01)),
            bearing_torque=slip * element.wheel_radius * draw(st.floats(0, 0.01)),
            creep_law=draw(st.sampled_from(["linear", "vermeulen-johnson", "polach", "fastsim"])),
        ),
        steering=replace(base.steering, patch_half_length=draw(st.floats(1e-4, 1e-3))),
        gearhead=replace(
            base.gearhead,
            efficiency=draw(st.floats(0.5, 1.0)),
            loss_model=draw(st.sampled_from(["coulomb", "proportional"])),
        ),
        guideway=iv.parts.Guideway(friction=draw(st.floats(0, 5))),
        amplifier=iv.parts.Amplifier(efficiency=draw(st.floats(0.7, 1.0)), standby_power=draw(st.floats(0, 1))),
        cylinder_inertia=draw(st.floats(5e-4, 1e-2)),
        link_mass=draw(st.floats(0.1, 1.0)),
    )


@st.composite
def conventional_drives(draw):
    """A shipped conventional drive with other gear, pulley and friction."""
    base = SHIPPED.drives[draw(st.sampled_from(["motor1-gear1", "motor2-gear4"]))]
    return replace(
        base,
        gearhead=replace(
            base.gearhead,
            ratio=draw(st.floats(2, 20)),
            efficiency=draw(st.floats(0.5, 1.0)),
            loss_model=draw(st.sampled_from(["coulomb", "proportional"])),
        ),
        pulley=iv.parts.Pulley(radius=draw(st.floats(0.005, 0.03)), friction_torque=draw(st.floats(0, 0.02))),
        guideway=iv.parts.Guideway(friction=draw(st.floats(0, 5))),
        amplifier=iv.parts.Amplifier(efficiency=draw(st.floats(0.7, 1.0)), standby_power=draw(st.floats(0, 1))),
    )


@st.composite
def scenarios(draw, cobotic):
    """A short run of any kind."""
    kinds = ["sinusoid", "reach", "step", "push", "imposed", "free"]
    kind = draw(st.sampled_from([*kinds, "locked", "run-up"] if cobotic else kinds))
    size = draw(st.floats(0.002, 0.03)) * draw(st.sampled_from([-1, 1]))
    force = SinusoidalForce(size=draw(st.floats(1, 60)), frequency=draw(st.floats(1, 20)))
    motion = {
        "sinusoid": Sinusoid(distance=size, frequency=draw(st.floats(0.5, 6))),
        "reach": Reach(distance=size, time=0.1, start=0.02),
        "step": Step(distance=size, start=0.02),
        "imposed": Sinusoid(distance=size, frequency=draw(st.floats(0.5, 6))),
    }.get(kind)
    return Scenario(
        duration=0.15,
        output_step=0.01,
        load_mass=draw(st.floats(0.1, 3)),
        motion=motion,
        force=None if kind == "imposed" else force,
        link={"imposed": "imposed", "free": "free"}.get(kind, "controlled"),
        steering="locked" if kind == "locked" or (cobotic and kind == "free") else "controlled",
        cylinder="run-up" if kind == "run-up" else "running",
        run_up_time=0.1 if kind == "run-up" else None,
        electrical=draw(st.sampled_from(["current", "voltage"])),
    )


@pytest.mark.slow
@given(cobotic_drives(), scenarios(cobotic=True))
@examples(10)
def test_energy_of_a_cobotic_drive_closes(drive, scenario):
    """Closure is also what `simulate` refuses to miss; here every loss grows, too, and every power is there."""
    check_energy(drive, scenario)


@pytest.mark.slow
@given(conventional_drives(), scenarios(cobotic=False))
@examples(10)
def test_energy_of_a_conventional_drive_closes(drive, scenario):
    check_energy(drive, scenario)


@pytest.mark.full
@given(cobotic_drives(), scenarios(cobotic=True), conventional_drives(), scenarios(cobotic=False))
@examples(40)
def test_energy_of_more_drives_closes(cobotic, its_scenario, conventional, scenario):
    check_energy(cobotic, its_scenario)
    check_energy(conventional, scenario)


def check_energy(drive, scenario):
    result = iv.simulate(drive, scenario)
    run = result.trajectory
    assert result.complete, run.outcome
    assert run.closure < CLOSURE == 1e-6
    moved = max(float(np.abs(energy).max()) for energy in [*run.supplied.values(), *run.lost.values()])
    for energy in run.lost.values():
        assert np.all(np.diff(energy) >= -1e-9 * moved)
    assert set(run.lost) >= {"winding", "amplifier"}


def points(drive, seed, count):
    """Random feasible points in all four quadrants, away from the axes, where friction has no direction."""
    random, found = np.random.default_rng(seed), 0
    while found < count:
        speed, force = random.uniform(0.05, 1.0) * random.choice([-1, 1]), random.uniform(-50, 50)
        steady = drive.operate(speed=speed, force=force)
        # A wheel near slip cannot also accelerate the link from rest.
        if steady.limit == iv.Limit.OK and steady.utilisation.get(iv.Limit.SLIP, 0.0) < 0.85:
            found += 1
            yield float(speed), float(force), steady


def settled(drive, scenario):
    result = iv.simulate(drive, scenario)
    assert result.complete
    return result.columns


@sampled(("name", "count"), [("cobotic", 6), ("cobotic", 60), ("cobotic-b", 4), ("cobotic-b", 40)], slow=2)
def test_a_settled_cobotic_drive_is_the_steady_map(name, count):
    """10 points, 100 with -m slow, to 1e-4: bond graph in time against the element's own steady solution.

    The wheel is held at the angle that the steady map steers to; the load is pushed back by the force; link speed, motor
    current and power of the supply must come out. The load's stick speed of 1e-4 m/s adds 1e-8 to the creep at most.
    """
    drive = replace(SHIPPED.drives[name], control=CoboticControl(cylinder_bandwidth=15.0, sample_rate=500.0))
    for speed, force, steady in points(drive, 1, count):
        scenario = Scenario(
            duration=0.25,
            output_step=0.05,
            link="free",
            steering="held",
            steering_angle=float(np.arctan(steady.states["steering_tangent"])),
            force=ConstantForce(size=-force),
            load_mass=0.8,
        )
        compare(settled(drive, scenario), speed, steady)


@pytest.mark.slow
@pytest.mark.parametrize("count", [25, pytest.param(100, marks=pytest.mark.slow)])
def test_a_settled_conventional_drive_is_the_steady_map(count):
    drive = replace(
        SHIPPED.drives["motor2-gear4"],
        control=ConventionalControl(speed_bandwidth=40.0, link_bandwidth=15.0, sample_rate=500.0),
    )
    for speed, force, steady in points(drive, 2, count):
        scenario = Scenario(
            duration=0.25,
            output_step=0.05,
            motion=Cruise(speed=speed),
            force=ConstantForce(size=-force),
            load_mass=0.8,
        )
        compare(settled(drive, scenario), speed, steady)


def compare(found, speed, steady):
    assert found["speed_m_s"][-1] == pytest.approx(speed, rel=1e-4)
    assert found["motor_current_A"][-1] == pytest.approx(float(steady.states["motor_current_A"]), rel=1e-4, abs=1e-5)
    assert found["supply_power_W"][-1] == pytest.approx(float(steady.power_in), rel=1e-4, abs=1e-4)


@given(seeds)
@examples(5)
def test_both_directions_are_alike(seed):
    """Motion, force and cylinder turned round give the mirrored run."""
    random = np.random.default_rng(seed)
    drive = SHIPPED.drives["cobotic"]
    distance, force = random.uniform(0.005, 0.03), random.uniform(-30, 30)

    def run(sign, drive):
        return iv.simulate(
            drive,
            Scenario(
                duration=0.1,
                output_step=0.01,
                load_mass=0.5,
                motion=Sinusoid(distance=sign * distance, frequency=3.0),
                force=ConstantForce(size=sign * force),
            ),
        ).columns

    forward, backward = run(1, drive), run(-1, drive)
    turned = run(1, replace(drive, cylinder_speed=-drive.cylinder_speed))
    for name in ("position_m", "speed_m_s", "steering_angle_rad"):
        np.testing.assert_allclose(forward[name], -backward[name], atol=1e-7)
    np.testing.assert_allclose(forward["position_m"], turned["position_m"], atol=1e-7)
    np.testing.assert_allclose(forward["motor_current_A"], backward["motor_current_A"], atol=1e-5)
    np.testing.assert_allclose(forward["motor_current_A"], -turned["motor_current_A"], atol=1e-5)


@pytest.mark.parametrize("drive", ["cobotic", "cobotic-b", "motor2-gear4"])
@sampled("scenario", SHIPPED.scenarios, every=6)
def test_every_shipped_scenario_closes(drive, scenario):
    expected = SHIPPED.scenarios[scenario]
    wheel = expected.steering != "controlled" or expected.cylinder != "running"
    if drive == "motor2-gear4" and wheel:
        with pytest.raises(ValueError, match="requires a cobotic drive"):
            iv.simulate(SHIPPED.drives[drive], expected)
        return
    result = iv.simulate(SHIPPED.drives[drive], expected)
    assert result.complete
    assert result.trajectory.closure < 1e-6
    if expected.motion is not None:
        assert abs(result.columns["position_m"][-1] - result.columns["wanted_position_m"][-1]) < 2e-3
