"""Motions and forces over time: their derivatives are those of their values, and they begin and end as they say."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

from infinivar import DutyCycle, Scenario
from infinivar.motion import (
    ConstantForce,
    Cruise,
    Hold,
    Reach,
    RecordedForce,
    Rest,
    Sinusoid,
    SinusoidalForce,
    Step,
    StepForce,
    Waypoints,
)

MOTIONS = {
    "hold": Rest(),
    "cruise": Cruise(speed=0.3, start=0.1),
    "sinusoid": Sinusoid(distance=0.02, frequency=3.0, start=0.05),
    "reach": Reach(distance=-0.1, time=0.4, start=0.1),
}


@pytest.fixture
def recorded(tmp_path):
    times = np.linspace(0.0, 1.0, 21)
    (tmp_path / "gait.csv").write_text(
        "time,position,remark\n" + "".join(f"{t},{0.05 * math.sin(math.pi * t) ** 2},x\n\n" for t in times), "utf-8"
    )
    (tmp_path / "push.csv").write_text("time,force\n0,0\n0.5,10\n0.6,-4\n", "utf-8")
    return tmp_path


def check_derivatives(motion, times):
    step = 1e-5
    for time in times:
        before, at, after = (motion.at(time + shift) for shift in (-step, 0.0, step))
        assert at.speed == pytest.approx((after.position - before.position) / (2 * step), abs=1e-6)
        assert at.acceleration == pytest.approx((after.speed - before.speed) / (2 * step), abs=1e-4)


@pytest.mark.parametrize("name", MOTIONS)
def test_speed_and_acceleration_are_derivatives(name):
    check_derivatives(MOTIONS[name], [0.02, 0.13, 0.2, 0.31, 0.44, 0.7])


def test_a_reach_has_the_least_jerk():
    """At half time half the way, 15/8 of the mean speed, and no acceleration; at rest before and after."""
    reach = MOTIONS["reach"]
    middle = reach.at(0.3)
    assert middle.position == pytest.approx(-0.05)
    assert middle.speed == pytest.approx(-15 / 8 * 0.1 / 0.4)
    assert middle.acceleration == pytest.approx(0.0, abs=1e-12)
    assert reach.at(0.1) == (0.0, 0.0, 0.0)
    assert reach.at(0.5) == (-0.1, 0.0, 0.0)
    assert reach.breaks == (0.1, 0.5)
    # The largest acceleration of this polynomial is 10/sqrt(3) d/T^2.
    fastest = max(abs(reach.at(0.1 + 0.4 * share).acceleration) for share in np.linspace(0.0, 1.0, 2001))
    assert fastest == pytest.approx(10 / math.sqrt(3) * 0.1 / 0.4**2, rel=1e-5)


def test_a_step_jumps():
    step = Step(distance=0.01, start=0.2)
    assert step.at(0.1999).position == 0.0
    assert step.at(0.2).position == 0.01
    assert step.breaks == (0.2,)


def test_a_recorded_motion_is_smooth_and_rests_at_its_ends(recorded):
    motion = Waypoints.read(str(recorded / "gait.csv"), start=0.1)
    check_derivatives(motion, [0.17, 0.31, 0.55, 0.98])
    assert motion.at(0.6).position == pytest.approx(0.05)
    assert motion.at(0.05).speed == motion.at(1.3).speed == 0.0
    assert motion.at(1.3).position == pytest.approx(0.0, abs=1e-12)
    for time in (0.12, 0.38, 0.83):
        assert motion.at(time).position == pytest.approx(0.05 * math.sin(math.pi * (time - 0.1)) ** 2, abs=1e-5)


def test_a_recorded_force_is_straight_between_its_rows(recorded):
    force = RecordedForce.read(str(recorded / "push.csv"), start=1.0)
    assert [force.value(time) for time in (0.0, 1.0, 1.25, 1.5, 1.55, 1.6, 9.0)] == pytest.approx(
        [0, 0, 5, 10, 3, -4, -4]
    )
    assert [force.rate(time) for time in (0.9, 1.2, 1.57, 2.0)] == pytest.approx([0.0, 20.0, -140.0, 0.0])
    assert force.breaks == (1.0, 1.5, 1.6)


def test_forces_by_shape():
    wave = SinusoidalForce(size=5.0, frequency=2.0)
    times = np.linspace(0.0, 1.0, 37)
    assert_allclose([wave.value(t) for t in times], 5.0 * np.sin(4 * np.pi * times), atol=1e-12)
    assert_allclose([wave.rate(t) for t in times], 20.0 * np.pi * np.cos(4 * np.pi * times), atol=1e-9)
    step = StepForce(size=-3.0, start=0.4)
    assert (step.value(0.39), step.value(0.4), step.breaks) == (0.0, -3.0, (0.4,))


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (lambda: Sinusoid(distance=0.0, frequency=2.0), "distance must be != 0 m, got 0.0"),
        (lambda: Cruise(speed=math.nan), "speed must be finite and not 0 m/s, got nan"),
        (lambda: ConstantForce(size=0.0), "size must be != 0 N, got 0.0"),
        (
            lambda: Waypoints(file="way", time=[0.0, 1.0, 1.0], position=[0.0, 1.0, 2.0]),
            "time must increase from row to row",
        ),
        (
            lambda: Waypoints(file="way", time=[0.0, 1.0], position=[0.0]),
            "position must have as many numbers as time, 2, got shape",
        ),
        (
            lambda: RecordedForce(file="push", time=[0.0, 1.0], force=[0.0, math.inf]),
            "force must be finite, got inf",
        ),
        (lambda: Scenario(duration=1.0, motion="reach"), "motion must be one of Rest, Cruise, Sinusoid, Step, Reach"),
        (lambda: Scenario(duration=1.0, force=-5.0), "force must be one of ConstantForce"),
        (lambda: DutyCycle(motion=Reach(distance=0.1, time=1.0)), "motion must be one of Hold, Sinusoid, Reaches"),
        (lambda: DutyCycle(motion=Hold), "motion must be one of Hold, Sinusoid, Reaches"),
    ],
)
def test_incomplete_profiles(given, said):
    with pytest.raises(ValueError, match=said):
        given()
