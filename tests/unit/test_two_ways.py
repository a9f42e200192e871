"""Why a motion takes another energy when controllers follow it, in words."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import brentq

import infinivar as iv
from infinivar.analysis import TwoWays
from internals import ConventionalControl, sampled_springs
from made import loaded

HAND, KNEE, REACH = (loaded(name) for name in ("hand_controller", "knee_walking", "reach_and_hold"))
GEARED = [drive for name, drive in HAND.drives.items() if "motor" in name]
DRIVEN = {
    "geared": [*GEARED, KNEE.drives["geared"], REACH.drives["geared"]],
    "cobotic": [
        *(study.drives[name] for study, name in ((HAND, "cobotic"), (HAND, "cobotic-b"), (KNEE, "cobotic"))),
        *(REACH.drives[name] for name in ("cobotic", "cobotic-b")),
    ],
}
EXACT = {"prescribed": 2.0, "as_turning": 2.0, "as_resting": 2.0, "stopping": 0.0, "followed": 2.3, "rms_error": 2.5e-4}
AT_REST = {"left_at_rest": 0.24, "slowest": 1e-4}


def two_ways(lost_prescribed, lost_followed, **changes):
    given = {
        **EXACT,
        **AT_REST,
        "speed_ripple": 0.0,
        "stored": 0.0,
        "simulation": SimpleNamespace(warnings=()),
        **changes,
    }
    return TwoWays(lost_prescribed=lost_prescribed, lost_followed=lost_followed, **given)


def test_a_loss_that_one_way_does_not_have_counts_as_none_there():
    """0.4, -0.2 and 0.1 J by subtraction, which add up to the difference; less than its last digit is not named."""
    said = two_ways(
        {"winding": 1.0, "slip": 0.2, "guideway": 0.5},
        {"winding": 1.1, "pulley": 0.4, "guideway": 0.501},
    ).explanation
    assert said == ("+0.30 J (+15.0 %): pulley +0.40 J, slip -0.20 J, winding +0.10 J; RMS position error 0.25 mm")


@pytest.mark.parametrize(("change", "named"), [(0.004, False), (0.006, True)])
def test_losses_below_the_last_digit_are_not_named(change, named):
    said = two_ways({"winding": 1.0}, {"winding": 1.0 + change}).explanation
    assert ("winding" in said) == named


def test_what_no_loss_explains_is_work_on_the_load_or_kept():
    """0.3 J, of which inertias keep 0.05 J and losses take 0.01 to 0.05 J: all of it is told."""
    lost = {"a": 0.05, "b": 0.04, "c": 0.02, "d": 0.01}
    said = two_ways({}, lost, stored=0.05).explanation
    assert "work on the load +0.13 J, " in said
    assert "stored in inertias +0.05 J" in said
    assert "other +0.03 J; " in said


def test_what_cylinder_and_rest_do_is_said():
    """0.3 J in all: 0.05 J as the cylinder turns, -0.03 J at rest, 0.08 J to get there, and 0.2 J more."""
    changes = {"as_turning": 2.05, "speed_ripple": 0.031, "as_resting": 2.02, "stopping": 0.08}
    said = two_ways({}, {}, **changes).explanation
    assert said.startswith("+0.30 J (+15.0 %): work on the load +0.30 J; RMS position error")
    assert "varies by 3.1 %" in said
    assert "with the simulated speed prescribed, the difference is +0.25 J" in said
    assert "below 0.1 mm/s (0.24 s of the cycle) the controllers leave the load at rest" in said
    assert "steering as slow meets less friction: -0.03 J" in said
    assert said.endswith("bringing it to rest and holding it takes +0.08 J; +0.20 J remain")
    assert two_ways({}, {}, prescribed=0.0, followed=0.0).explanation.startswith("+0 J; RMS position error")


def test_what_changes_nothing_is_not_said():
    """Less than half of the last digit shown, 0.01 J."""
    said = two_ways({}, {}, as_turning=2.004, speed_ripple=0.031, as_resting=2.001, stopping=-0.004).explanation
    assert "cylinder" not in said
    assert "at rest" not in said


@pytest.mark.slow
def test_slow_ends_of_a_smooth_reach_by_hand():
    """A reach of 5 mm in 0.8 s with v = 630 d/T (s (1 - s))^4 stays below 0.1 mm/s for T s_1 at each of four ends in a cycle.

    Inverse dynamics counts the winding loss of the friction current there; the inertial current is below 1 % of it. The
    simulation, whose controllers leave the load at rest, spends less, so the difference is negative.
    """
    drive = HAND.drives["motor2-gear4"]
    duty = iv.DutyCycle(motion=iv.motion.Reaches(distance=5e-3, time=0.8, pause=0.5, profile="smooth"), load_mass=0.5)
    found = iv.analysis.two_ways(drive, duty)
    share = brentq(lambda s: 630 * 5e-3 / 0.8 * (s * (1 - s)) ** 4 - 1e-4, 0.0, 0.5)
    assert found.left_at_rest == pytest.approx(4 * 0.8 * share, abs=4 * 2.6 / 2000)
    current = float(drive.operate(speed=1e-9, force=0.0).states["motor_current_A"])
    lost = drive.motor.resistance * current**2 * found.left_at_rest
    assert found.prescribed - found.as_resting == pytest.approx(lost, rel=0.02)
    assert found.followed == pytest.approx(found.prescribed - lost, rel=0.005)
    assert found.followed < 0.9 * found.prescribed
    assert f"{-lost:+.3f} J" in found.explanation


def measured_gear(random, drive):
    """The drive with the loss model of its study, one proportional to power, or friction that depends on the load."""
    gear, kind = drive.gearhead, random.integers(3)
    if kind == 0:
        return drive
    if kind == 1:
        losses = {"loss_model": "proportional", "efficiency": random.uniform(0.4, 0.95)}
    else:
        constant = random.uniform(0.0, 0.05) * drive.motor.continuous_torque * gear.ratio
        load = dict(zip(("load_motor", "load_output"), random.uniform(0.0, 0.2, 2), strict=True))
        losses = {
            "loss_model": "stribeck",
            "efficiency": None,
            "friction": iv.parts.GearFriction(friction=constant, **load),
        }
    return replace(drive, gearhead=replace(gear, rated_torque=None, backdriving_efficiency=None, **losses))


def any_motion(random):
    """Reaches of either profile with or without pauses, or a sinusoid, of 3 to 200 mm, half of them under a force."""
    distance = float(10 ** random.uniform(np.log10(0.003), np.log10(0.2)))
    kind = random.integers(4)
    if kind < 2:
        time, pause = random.uniform(0.3, 1.2), float(random.choice([0.0, random.uniform(0.1, 1.0)]))
        size, profile = distance * min(1.0, time), ("smooth", "minimum-jerk")[kind]
        motion = iv.motion.Reaches(distance=size, time=time, pause=pause, profile=profile)
    else:
        slow = min(random.uniform(0.3, 3.0), 0.35 / (2 * np.pi * distance))
        motion = iv.motion.Sinusoid(distance=distance, frequency=slow)
    force = float(random.choice([0.0, random.uniform(-25.0, 25.0)]))
    return iv.DutyCycle(motion=motion, load_mass=random.uniform(0.2, 2.0), force=force or None)


def unexplained(kind, seed):
    """Share of the simulated energy that the laws leave open, and that of the plain difference; None if not tracked."""
    random = np.random.default_rng(seed)
    duty, drives = any_motion(random), DRIVEN[kind]
    drive = drives[random.integers(len(drives))]
    both = iv.analysis.two_ways(measured_gear(random, drive) if kind == "geared" else drive, duty)
    if both.rms_error > 0.01 * duty.motion.distance:
        return None
    return tuple(abs(one / both.followed - 1.0) for one in (both.as_controlled, both.prescribed))


A_HUNDRED = [
    pytest.param(kind, range(first, first + 25), marks=pytest.mark.full)
    for kind in ("geared", "cobotic")
    for first in range(100, 200, 25)
]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "seeds"),
    [("geared", (3, 34, 70)), pytest.param("cobotic", (8, 17), marks=pytest.mark.slow), *A_HUNDRED],
)
def test_a_motion_that_is_tracked_takes_the_same_both_ways(kind, seeds):
    """2 %, where the load follows within 1 %: cylinder speed, rest, and coming to rest explain the rest of the difference.

    The single seeds are among those with the largest differences of the first hundred. The load of 70 sinks by 0.1 mm until the
    controllers know its force; a cycle that begins before it is brought back takes 2.6 % more.
    """
    found = [each for each in (unexplained(kind, seed) for seed in seeds) if each is not None]
    left, plain = (max(each) for each in zip(*found, strict=True))
    print(f"{kind}: {left:.2%} unexplained of up to {plain:.1%}, in {len(found)} of {len(seeds)} that track")
    assert left < 0.02
    assert len(found) > 0.7 * len(seeds)


@pytest.mark.slow
def test_a_load_that_friction_brakes_does_not_drive_the_motor():
    """The gear of 46 % locks: while a guideway takes more than inertia gives back, the motor still drives through it. 1 %."""
    left, plain = unexplained("geared", 8)
    assert plain > 0.05
    assert left < 0.01


def stiff_drive(stiffness, **changed):
    """Motor behind a series spring; reflected mass 2.51 kg."""
    motor = iv.parts.Motor(
        voltage=48.0,
        resistance=0.6,
        torque_constant=0.05,
        no_load_current=0.15,
        continuous_torque=0.15,
        rotor_inertia=1e-5,
        inductance=1e-4,
    )
    return iv.ConventionalDrive(
        motor=motor,
        gearhead=iv.parts.Gearhead(ratio=5, efficiency=0.9, loss_model="proportional"),
        pulley=iv.parts.Pulley(radius=0.01),
        guideway=iv.parts.Guideway(friction=1.0),
        output_inertia=1e-6,
        output=iv.Output(series_spring=iv.parts.Spring(stiffness=stiffness)),
        **changed,
    )


# Free resonances 461, 595 and 1031 Hz at a sample rate of 1 kHz.
@pytest.mark.slow
@pytest.mark.parametrize(
    ("stiffness", "excites"),
    [(6e6, False), (1e7, True), (3e7, False)],
)
def test_a_resonance_that_the_sampled_controllers_excite_is_named(stiffness, excites):
    """The warning stands exactly where simulation and inverse dynamics part, in a motion that leaves it time to grow."""
    duty = iv.DutyCycle(motion=iv.motion.Sinusoid(distance=0.01, frequency=1.0), load_mass=1.0, force=-20.0)
    two = iv.analysis.two_ways(stiff_drive(stiffness), duty)
    if excites:
        assert two.followed > 1.2 * two.prescribed
    else:
        assert two.followed == pytest.approx(two.prescribed, rel=0.01)
    for text in (two.explanation, two.simulation.verdict):
        assert ("the series spring resonates at 595 Hz (503 Hz with the motor locked)" in text) is excites
    assert len(two.simulation.warnings) == excites


def test_a_faster_controller_damps_the_resonance():
    scenario = iv.Scenario(duration=0.1, motion=iv.motion.Sinusoid(distance=0.01, frequency=3.0), load_mass=1.0)
    assert sampled_springs.excited(stiff_drive(1e7), scenario)
    quick = stiff_drive(1e7, control=ConventionalControl(sample_rate=1200.0))
    assert sampled_springs.excited(quick, scenario) == ()
    assert sampled_springs.excited(stiff_drive(1e7), replace(scenario, load_mass=0.5)) != ()
