"""Arguments that are no numbers, too many or of the wrong kind are refused in words that name them."""

import copy
import math
import pickle

import numpy as np
import pytest

import infinivar as iv
from infinivar.contact import creep
from infinivar.study.load import shipped_study

STUDY = shipped_study("faulring2006")
DRIVE = STUDY.drives["cobotic"]
CYCLE = {"motion": iv.Hold(time=1.0)}


def waypoints(time, position=(0.0, 0.01)):
    return iv.Waypoints(file="way", time=time, position=position)


def law(**changed):
    values = {name: getattr(creep.LINEAR, name) for name in ("creepage", "slope", "force", "slip_creepage")}
    return creep.CreepLaw(**{"name": "mine", **values, **changed})


@pytest.mark.parametrize("number", [2, 2.0, np.float64(2.0), np.float32(2.0), np.int64(2), np.array(2.0), np.array(2)])
def test_a_field_of_a_motion_is_a_plain_number(number):
    reach = iv.Reach(distance=0.1, time=number)
    assert type(reach.time) in (int, float)
    assert reach == iv.Reach(distance=0.1, time=2.0)
    assert hash(reach) == hash(pickle.loads(pickle.dumps(reach)))


def test_a_motion_does_not_follow_the_callers_array():
    mine = np.array(2.0)
    reach = iv.Reach(distance=0.1, time=mine)
    mine[...] = -5.0
    assert reach.time == 2.0


@pytest.mark.parametrize(
    "wrong", [np.array([1.0, 2.0]), np.array([1.0]), 1 + 0j, np.array(1j), True, np.True_, "1", [1.0], None, object()]
)
@pytest.mark.parametrize(
    ("make", "field"),
    [
        (lambda x: iv.Cruise(speed=0.1, start=x), "start"),
        (lambda x: iv.SinusoidalForce(size=1.0, frequency=x), "frequency"),
        (lambda x: iv.DutyCycle(**CYCLE, ambient=x), "ambient"),
        (lambda x: iv.Scenario(duration=x), "duration"),
        (lambda x: iv.Waypoints(file="way", time=[0.0, 1.0], position=[0.0, 1.0], start=x), "start"),
    ],
)
def test_a_field_of_a_motion_takes_one_real_number(make, field, wrong):
    with pytest.raises(iv.ParameterError, match=rf"^{field} must be a real number, got "):
        make(wrong)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: iv.DutyCycle(**CYCLE, load_mass=1j), "load_mass must be a real number, got 1j"),
        (lambda: iv.DutyCycle(**CYCLE, force=[1, 2]), "force must be a real number, got [1, 2]"),
        (lambda: iv.DutyCycle(**CYCLE, force=math.inf), "force must be finite N, got inf"),
        (lambda: iv.Cruise(speed=math.nan), "speed must be finite and not 0 m/s, got nan"),
        (lambda: iv.Cruise(speed=[1.0]), "speed must be a real number, got [1.0]"),
        (lambda: iv.Cruise(), "speed is missing: give speed, or angular_speed about a joint"),
        (
            lambda: iv.Reach(distance=0.1, angle=0.1, time=1.0),
            "distance and angle exclude each other: distance is along a line, angle about a joint",
        ),
        (lambda: iv.ConstantForce(), "size is missing: give size, or moment about a joint"),
        (
            lambda: iv.DutyCycle(motion=iv.Sinusoid(angle=0.1, frequency=1.0), force=1.0),
            "force is along a line, but the motion is about a joint; write moment",
        ),
        (
            lambda: iv.DutyCycle(motion=iv.Hold(time=1.0), force=1.0, load_inertia=0.1),
            "force is along a line, but load_inertia is about a joint; write moment",
        ),
        (
            lambda: iv.Scenario(duration=1.0, motion=iv.Reach(angle=0.1, time=0.5), load_mass=1.0),
            "load_mass is along a line, but the motion is about a joint; write load_inertia",
        ),
        (lambda: iv.Cruise(speed=0.0), "speed must be != 0 m/s, got 0.0"),
        (lambda: iv.Cruise(speed=math.inf), "speed must be finite and not 0 m/s, got inf"),
        (lambda: waypoints([0.0]), "time must be at least two numbers in a row, got [0.0]"),
        (lambda: waypoints(None), "time must be a real number or an array of them, got None"),
        (lambda: waypoints([0.0, 1.0], None), "position must be a real number or an array of them, got None"),
        (lambda: waypoints(["a", "b"]), "time must be a real number or an array of them, got ['a', 'b']"),
        (lambda: waypoints([0.0, 0.0]), "time must increase from row to row, got 0, then 0"),
        (lambda: waypoints([0.0, math.nan]), "time must be finite, got nan"),
        (
            lambda: waypoints([0.0, 1.0], np.zeros(500)),
            "position must have as many numbers as time, 2, got shape (500,)",
        ),
        (lambda: law(name=""), "name must be text that is not empty, got ''"),
        (lambda: law(creepage=3), "creepage must be a function, got 3"),
        (lambda: law(slope=None), "slope must be a function, got None"),
        (lambda: law(force="a"), "force must be a function, got 'a'"),
        (lambda: law(flow_factor=1.0), "flow_factor must be a function or None, got 1.0"),
        (lambda: law(slip_creepage=-1.0), "slip_creepage must be a number > 0, or inf, got -1.0"),
        (lambda: law(slip_creepage=math.nan), "slip_creepage must be a number > 0, or inf, got nan"),
        (lambda: law(slip_creepage="1"), "slip_creepage must be a number > 0, or inf, got '1'"),
        (lambda: iv.reproduce(True), "figure must be a whole number from 1 to 17, got True"),
        (lambda: iv.reproduce(7.0), "figure must be a whole number from 1 to 17, got 7.0"),
        (lambda: iv.reproduce("7"), "figure must be a whole number from 1 to 17, got '7'"),
        (lambda: iv.steady_map(DRIVE, ["a"], [10]), "speed must be a real number or an array of them, got ['a']"),
        (lambda: iv.steady_map(DRIVE, [0.1], None), "force must be a real number or an array of them, got None"),
        (lambda: iv.steady_map(DRIVE, [0.1], ["10"]), "force must be a real number or an array of them, got ['10']"),
    ],
)
def test_the_message_names_the_argument(make, said):
    with pytest.raises(iv.InputError) as caught:
        make()
    assert str(caught.value) == said


@pytest.mark.parametrize("name", ["cobotic", "motor2-gear4"])
@pytest.mark.parametrize(
    ("speed", "force", "said"),
    [
        ([0.1, 0.2], [1, 2, 3], "speed and force must broadcast to one shape, got shapes (2,) and (3,)"),
        ("fast", 1.0, "speed must be a real number or an array of them, got 'fast'"),
        ("0.1", 1.0, "speed must be a real number or an array of them, got '0.1'"),
        (None, 1.0, "speed must be a real number or an array of them, got None"),
        ([0.1, None], 1.0, "speed must be a real number or an array of them, got [0.1, None]"),
        (0.1, [[1.0], [2.0, 3.0]], "force must be a real number or an array of them, got [[1.0], [2.0, 3.0]]"),
        (0.1, 1j, "force must be a real number or an array of them, got 1j"),
    ],
)
def test_a_drive_names_the_argument(name, speed, force, said):
    with pytest.raises(iv.ParameterError) as caught:
        STUDY.drives[name].operate(speed=speed, force=force)
    assert str(caught.value) == said


@pytest.mark.parametrize(
    "value",
    [
        iv.DutyCycle(**CYCLE),
        iv.Scenario(duration=1.0),
        waypoints([0.0, 1.0]),
        iv.Cruise(speed=1.0),
        iv.Rest(),
        iv.Hold(time=1.0),
        iv.StepForce(size=1.0),
    ],
    ids=lambda value: type(value).__name__,
)
def test_equality_with_an_array_is_one_bool(value):
    for other in (np.arange(3), np.float64(1.0)):
        assert (value == other) is False
        assert (other == value) is False
        assert (value != other) is True
    assert value == copy.deepcopy(value)


def test_a_single_drive_may_be_named_by_itself():
    assert list(STUDY.with_drives("cobotic").drives) == ["cobotic"]
    with pytest.raises(iv.InputError, match="no drive 'cobotc'"):
        STUDY.with_drives("cobotc")
