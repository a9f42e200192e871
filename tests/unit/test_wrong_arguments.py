"""Arguments that are no numbers, too many or of the wrong kind are refused in words that name them."""

import copy
import pickle

import numpy as np
import pytest

import infinivar as iv
from made import parameter_study

STUDY = parameter_study("faulring2006")
CYCLE = {"motion": iv.motion.Hold(time=1.0)}


@pytest.mark.parametrize("number", [2, 2.0, np.float64(2.0), np.float32(2.0), np.int64(2), np.array(2.0), np.array(2)])
def test_a_field_of_a_motion_is_a_plain_number(number):
    reach = iv.motion.Reach(distance=0.1, time=number)
    assert type(reach.time) in (int, float)
    assert reach == iv.motion.Reach(distance=0.1, time=2.0)
    assert hash(reach) == hash(pickle.loads(pickle.dumps(reach)))


def test_a_motion_does_not_follow_the_callers_array():
    mine = np.array(2.0)
    reach = iv.motion.Reach(distance=0.1, time=mine)
    mine[...] = -5.0
    assert reach.time == 2.0


@pytest.mark.parametrize(
    "wrong", [np.array([1.0, 2.0]), np.array([1.0]), 1 + 0j, np.array(1j), True, np.True_, "1", [1.0], None, object()]
)
@pytest.mark.parametrize(
    ("make", "field"),
    [
        (lambda x: iv.motion.Cruise(speed=0.1, start=x), "start"),
        (lambda x: iv.motion.SinusoidalForce(size=1.0, frequency=x), "frequency"),
        (lambda x: iv.DutyCycle(**CYCLE, ambient=x), "ambient"),
        (lambda x: iv.Scenario(duration=x), "duration"),
        (lambda x: iv.motion.Waypoints(file="way", time=[0.0, 1.0], position=[0.0, 1.0], start=x), "start"),
    ],
)
def test_a_field_of_a_motion_takes_one_real_number(make, field, wrong):
    with pytest.raises(iv.ParameterError, match=rf"^{field} must be a real number, got "):
        make(wrong)


@pytest.mark.parametrize(
    "value",
    [
        iv.DutyCycle(**CYCLE),
        iv.Scenario(duration=1.0),
        iv.motion.Waypoints(file="way", time=[0.0, 1.0], position=[0.0, 0.01]),
        iv.motion.Cruise(speed=1.0),
        iv.motion.Rest(),
        iv.motion.Hold(time=1.0),
        iv.motion.StepForce(size=1.0),
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
