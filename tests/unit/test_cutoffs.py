"""What the cutoff of a recording keeps and removes, and what is said of it."""

import math

import numpy as np
import pytest

import infinivar as iv
from infinivar import InputError, ParameterError
from infinivar.motion import Recording


def sine(path, frequency, *, waves=1, rows=81, amplitude=5.0, noise=0.0):
    """Whole waves of a sine, closed."""
    time = np.linspace(0.0, waves / frequency, waves * (rows - 1) + 1)
    place = amplitude * np.sin(2.0 * math.pi * frequency * time)
    place[1:-1] += noise * np.random.default_rng(2).standard_normal(len(time) - 2)
    np.savetxt(path, np.column_stack([time, place, 0.0 * time - 5.0]), delimiter=",", header="Time (s),Pos (mm),Fz (N)",
               comments="", fmt="%.9g")  # fmt: skip
    return path


@pytest.mark.parametrize("frequency", [1.0, 4.0, 8.33, 12.5])
def test_the_spectrum_of_one_cycle_does_not_leak(tmp_path, frequency):
    found = iv.inspect_motion(sine(tmp_path / "one.csv", frequency), cutoff=8.0 * frequency)
    assert found.spectrum.passed == pytest.approx(frequency, rel=1e-6)
    assert found.spectrum.above < 1e-12
    assert found.spectrum.removed_speed < 1e-12


def test_a_cutoff_keeps_the_fundamental(tmp_path):
    """Below twice the frequency of a cycle, its fundamental itself would be attenuated."""
    path = sine(tmp_path / "one.csv", 8.33)
    with pytest.raises(
        ParameterError, match=r"cutoff must be >= 16\.7 Hz, to keep one cycle in a recording of 0\.12 s"
    ):
        Recording.read(str(path))
    kept = Recording.read(str(path), cutoff=16.7)
    assert np.max(np.abs(kept.derivatives(np.linspace(0.0, kept.period, 200), 0)[0])) == pytest.approx(5e-3, rel=2e-3)
    assert kept.warnings == ()
    for frequency in (8.33, 12.5):
        found = iv.inspect_motion(sine(tmp_path / "one.csv", frequency))
        assert found.motion.cutoff == pytest.approx(2.0 * frequency)
        assert found.extremes["position"][1] == pytest.approx(5e-3, rel=2e-3)
        assert found.resting == 0.0


@pytest.mark.parametrize("closed", [True, False])
def test_a_cutoff_that_removes_motion_is_warned_of_with_its_share(tmp_path, closed):
    """The filter passes 0.25 of the amplitude of 8.33 Hz at a cutoff of 10 Hz: 94 % of its power is lost."""
    path = sine(tmp_path / "many.csv", 8.33, waves=12, noise=0.002)
    lost = 1.0 - (0.5 * (1.0 + math.cos(math.pi * (2.0 * 0.833 - 1.0)))) ** 2
    (said,) = Recording.read(str(path), closed=closed).warnings
    share = lost if closed else lost - 0.01  # the window of a run spreads the line to its neighbours
    assert f"removes {100.0 * share:.0f} % of the power of the recorded speed" in said
    enough = 16.7 if closed else 18.1
    assert f'cutoff = "{enough} Hz" keeps it' in said
    assert Recording.read(str(path), closed=closed, cutoff=enough).warnings == ()


def test_a_small_fast_part_counts_by_its_speed(tmp_path):
    """2 mm at 9 Hz beside 30 mm at 1 Hz are 0.4 % of the power of the position, but 26 % of that of the speed."""
    time = np.linspace(0.0, 1.0, 501)
    place = 30.0 * np.sin(2 * math.pi * time) + 2.0 * np.sin(18 * math.pi * time)
    rows = np.column_stack([time, place])
    np.savetxt(tmp_path / "two.csv", rows, delimiter=",", header="Time (s),Pos (mm)", comments="", fmt="%.9g")
    share = 18.0**2 / (18.0**2 + 30.0**2)
    passed = 0.5 * (1.0 + math.cos(math.pi * 0.8))
    found = iv.inspect_motion(tmp_path / "two.csv")
    assert found.spectrum.removed_speed == pytest.approx(share * (1.0 - passed**2), rel=1e-3)
    assert any("removes 26 %" in one for one in found.warnings)


def test_noise_is_no_motion(tmp_path):
    """White noise of the position holds most of the speed's power at 500 Hz; it is what the cutoff is there to remove."""
    random = np.random.default_rng(4)
    time = np.linspace(0.0, 2.0, 1001)
    place = 30.0 * np.sin(2 * math.pi * time) + 0.3 * random.standard_normal(1001)
    rows = np.column_stack([time, place])
    np.savetxt(tmp_path / "noisy.csv", rows, delimiter=",", header="Time (s),Pos (mm)", comments="", fmt="%.9g")
    assert not any("removes" in one for one in iv.inspect_motion(tmp_path / "noisy.csv").warnings)


def test_a_recording_too_short_for_its_cutoff_is_refused_as_a_run(tmp_path):
    with pytest.raises((InputError, ParameterError), match=r"cutoff must be >= 12\.5 Hz, one period in a recording"):
        Recording.read(str(sine(tmp_path / "one.csv", 12.5)), closed=False)
