"""Running against the rows that it was fitted to.

Source: duarte2018 (one stride of one runner, by inverse dynamics with the body of rajagopal2016). Tolerances:
- the series are those of the rows, recomputed here: the file has six digits;
- rows: rms residuals as stated in the file; the torques jump at foot contact, which 14 harmonics smooth over;
- work: 2 %, between harmonics and trapezoids over rows;
- stride time: 0.5 %, by the impulse of both feet, which carries the weight over a stride.
"""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.interpolate import PchipInterpolator

from infinivar import DutyCycle, ParameterError
from infinivar.motion import Running

MASS = 70.0
GRAVITY = 9.80665
JOINTS = ("hip", "knee", "ankle")
TABLE = np.genfromtxt(Path(__file__).parent / "running_stride.csv", delimiter=",", skip_header=5)
ROWS = len(TABLE) - 1  # the last row is the first of the next stride
SHARE = np.arange(ROWS) / ROWS
RMS = {"hip": (0.036, 0.38), "knee": (0.0125, 0.58), "ankle": (0.0095, 0.88)}  # torque [N m/kg], angle [deg]


def rows(joint):
    """Extension angle without drift [rad], torque per mass, gaps filled [N m/kg], and which torques are recorded."""
    column = 1 + JOINTS.index(joint)
    angle, torque = -np.radians(TABLE[:, column]), -TABLE[:-1, column + 3] / MASS
    known = np.isfinite(torque)
    whole = np.concatenate([SHARE[known] + turn for turn in (-1, 0, 1)])
    filled = PchipInterpolator(whole, np.tile(torque[known], 3))(SHARE)
    angle = angle[:-1] - (angle[-1] - angle[0]) * SHARE
    return angle - angle.mean(), filled, known


def fitted(joint):
    motion = Running(joint=joint, body_mass=MASS)
    time = SHARE * motion.period
    angle = motion.derivatives(time, 0)[0]
    return angle - angle.mean(), -motion.push(time, 0)[0] / MASS


@pytest.mark.parametrize("joint", JOINTS)
def test_series_are_those_of_the_rows(joint):
    angle, torque, _ = rows(joint)
    for values, harmonics, found in zip((angle, torque), (8, 14), fitted(joint), strict=True):
        spectrum = np.fft.rfft(values)
        spectrum[harmonics + 1 :] = 0.0
        assert_allclose(found, np.fft.irfft(spectrum, ROWS), atol=2e-5 * np.ptp(values))


@pytest.mark.parametrize("joint", JOINTS)
def test_rows_are_met(joint):
    (angle, torque, known), (bend, moment) = rows(joint), fitted(joint)
    assert np.std((moment - torque)[known]) < RMS[joint][0]
    assert np.degrees(np.std(bend - angle)) < RMS[joint][1]
    swing = known & (SHARE > 0.4)  # smooth there: a digit wrong in the table would stand out
    assert np.max(np.abs(moment - torque)[swing]) < 4.0 * RMS[joint][0]
    assert np.max(np.abs(bend - angle)) < 4.05 * np.radians(RMS[joint][1])


@pytest.mark.parametrize("joint", JOINTS)
def test_work_is_that_of_the_rows(joint):
    """The moment over the angle, without any speed, against torque times speed over time."""
    angle, torque, _ = rows(joint)
    around = np.append(torque, torque[0])
    by_rows = np.sum(0.5 * (around[1:] + around[:-1]) * np.diff(np.append(angle, angle[0])))
    whole = DutyCycle(motion=Running(joint=joint, body_mass=MASS)).instants()
    power = -whole.course.force * whole.course.speed / MASS
    assert np.mean(power) * Running(joint=joint, body_mass=MASS).period == pytest.approx(by_rows, rel=0.02)


def test_feet_carry_the_weight():
    """Vertical impulses of the right and the left foot in the recording, by trapezoids over its force plates. [N s]"""
    assert Running(joint="hip", body_mass=MASS).period == pytest.approx((234.6 + 249.0) / (MASS * GRAVITY), rel=0.005)


def test_the_ankle_drives_and_the_knee_brakes():
    """Over a stride of steady running; the ankle's torque peaks in stance, and the knee bends most in swing."""
    found = {}
    for joint in JOINTS:
        whole = DutyCycle(motion=Running(joint=joint, body_mass=MASS)).instants()
        found[joint] = (
            whole.time / 0.7067,
            whole.position,
            -whole.course.force,
            -whole.course.force * whole.course.speed,
        )
    share, _, torque, power = found["ankle"]
    assert -np.minimum(power, 0).sum() < np.maximum(power, 0).sum()
    assert 0.1 < share[np.argmax(torque)] < share[np.argmax(power)] < (0.3 - 0.0533) / 0.7067
    assert power[share < 0.1].min() < 0.0  # it yields before it pushes off
    share, angle, torque, power = found["knee"]
    assert power.sum() < 0.0
    assert 0.55 < share[np.argmin(angle)] < 0.75
    assert share[np.argmax(torque)] < 0.35


def test_stride_time_is_that_of_the_recording_unless_it_is_given():
    recorded, slow = (Running(joint="knee", body_mass=MASS, stride_time=time) for time in (None, 1.4134))
    assert (recorded.period, slow.period) == (0.7067, 1.4134)
    (angle, speed), (same, half) = (each.derivatives(SHARE * each.period, 1) for each in (recorded, slow))
    assert_allclose(same, angle, atol=1e-12)
    assert_allclose(half, 0.5 * speed, atol=1e-12)
    assert slow.fastest == pytest.approx(14 / 1.4134)
    with pytest.raises(ParameterError, match="stride_time must be > 0 s"):
        Running(joint="knee", body_mass=MASS, stride_time=-1.0)
