"""Faults that recordings have in practice leave the energy of the motion as it is, or are told: drift, noise, filters."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import butter, filtfilt

from infinivar import DutyCycle, duty_cycle
from infinivar.motion import Hold, Reaches, Recording, Sinusoid, Walking
from made import parameter_study
from motions import recorded

DRIVES = parameter_study("faulring2006").drives
GEARED, STIFF = DRIVES["motor2-gear4"], DRIVES["cobotic-b"]
REACH = DutyCycle(motion=Reaches(distance=0.2, time=0.6, pause=1.0), force=-25.0, load_mass=0.8)


def energies(duty):
    return [duty_cycle(drive, duty).energy for drive in (GEARED, STIFF)]


@pytest.fixture(scope="module")
def clean():
    """What the motion takes by its shape."""
    return energies(REACH)


@pytest.mark.parametrize("total", [1e-6, 1e-4, 8e-3])
def test_a_drift_of_the_sensor_hides_no_rest(tmp_path, clean, total):
    """Over the cycle, evenly: it is taken out, and the stays are what they are without it."""
    drift = np.linspace(0.0, total, round(REACH.period * 200) + 1)
    duty = recorded(REACH, tmp_path / "drift.csv", 200, noise=drift)
    assert duty.resting == pytest.approx(2.0, abs=0.02)
    assert energies(duty) == pytest.approx(clean, rel=2e-3)


@pytest.mark.parametrize("bias", [1e-6, 1e-4])
def test_a_bias_of_the_speed_hides_no_rest(tmp_path, clean, bias):
    duty = recorded(REACH, tmp_path / "bias.csv", 200, column="speed", noise=bias)
    assert energies(duty) == pytest.approx(clean, rel=2e-3)


@pytest.mark.parametrize("resolution", [1e-4, 2e-3, 5e-3])
def test_a_coarse_resolution_leaves_the_moves_as_they_are(tmp_path, clean, resolution):
    """A stay ends where the load sets out, not where it has gone as far as the resolution."""
    duty = recorded(REACH, tmp_path / "clean.csv", 200)
    coarse = DutyCycle(motion=replace(duty.motion, resolution=resolution), load_mass=REACH.load_mass)
    assert energies(coarse) == pytest.approx(clean, rel=2e-3)


def test_filtered_noise_is_told_and_a_resolution_helps(tmp_path, clean):
    """As motion capture delivers it: 0.1 mm of noise, then a low-pass filter of second order at 6 Hz, both ways."""
    count = round(REACH.period * 100)
    random, filters = np.random.default_rng(3), butter(2, 6.0 / 50.0)
    noise = filtfilt(*filters, np.tile(1e-4 * random.standard_normal(count), 3))[count : 2 * count]
    duty = recorded(REACH, tmp_path / "filtered.csv", 100, noise=np.append(noise, noise[0]))
    (warning,) = duty.warnings
    assert 'set resolution = "' in warning
    advised = float(warning.rpartition('"')[0].rpartition('"')[2].removesuffix(" mm"))
    finer = DutyCycle(motion=replace(duty.motion, resolution=1e-3 * advised), load_mass=REACH.load_mass)
    assert not finer.warnings
    assert finer.resting == pytest.approx(2.0, abs=0.2)
    assert energies(finer) == pytest.approx(clean, rel=0.03)  # the noise of the moves steers the wheel


def test_motions_without_stays_are_not_warned_about(tmp_path):
    """The slowest hundredth about the turns of a sinusoid, and level walking."""
    sinusoid = DutyCycle(motion=Sinusoid(distance=0.1, frequency=0.2), load_mass=0.8)
    walking = DutyCycle(motion=Walking(joint="knee", body_mass=75.0, stride_time=1.1, lever_arm=0.05))
    for number, duty in enumerate((sinusoid, walking)):
        assert not recorded(duty, tmp_path / f"{number}.csv", 200).warnings


@pytest.mark.parametrize("seed", range(4))
def test_noise_of_a_force_does_not_tilt_it(tmp_path, seed):
    """A hold under 20 N with 1 N of noise, whose last sample is off the first by anything."""
    hold = DutyCycle(motion=Hold(time=4.0), force=-20.0, load_mass=0.8)
    time = np.linspace(0.0, 4.0, 401)
    force = -20.0 + np.random.default_rng(seed).standard_normal(time.size)
    force[-1] = -20.0 + 4.0
    path = tmp_path / "hold.csv"
    rows = [f"{t:.6f},0,{f:.6f}" for t, f in zip(time, force, strict=True)]
    path.write_text("\n".join(["time [s],position [m],force [N]", *rows]), "utf-8")
    noisy = DutyCycle(motion=Recording.read(str(path)), load_mass=0.8)
    assert duty_cycle(GEARED, noisy).energy == pytest.approx(duty_cycle(GEARED, hold).energy, rel=0.04)


def test_a_force_may_end_elsewhere_than_it_begins(tmp_path):
    """From -20 N to nothing along a straight line: held as such, with the jump back smoothed and nothing taken out."""
    time = np.linspace(0.0, 4.0, 401)
    path = tmp_path / "ramp.csv"
    rows = [f"{t:.6f},0,{-20.0 + 5.0 * t:.6f}" for t in time]
    path.write_text("\n".join(["time [s],position [m],force [N]", *rows]), "utf-8")
    duty = DutyCycle(motion=Recording.read(str(path)), load_mass=0.8)
    found = duty.instants()
    inner = (found.time > 0.2) & (found.time < 3.8)
    assert found.course.force[inner] == pytest.approx(-20.0 + 5.0 * found.time[inner], abs=0.3)  # 1.5 % of the jump
