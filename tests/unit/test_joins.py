"""Where a closed recording joins its own start: steps of force and speed are warned of with their size."""

import math
import re

import numpy as np
import pytest

from infinivar.motion import Recording
from sampled import sampled


def written(path, time, place, force=None, heading="Pos (mm)"):
    columns = [time, place] if force is None else [time, place, force]
    header = f"Time (s),{heading}" + ("" if force is None else ",Fz (N)")
    np.savetxt(path, np.column_stack(columns), delimiter=",", header=header, comments="", fmt="%.9g")
    return str(path)


def test_a_step_of_the_force_is_told_with_its_size(tmp_path):
    """The position closes, the force does not: -10 N at the start, +6 N at the end of a ramp."""
    time = np.linspace(0.0, 1.0, 501)
    file = written(tmp_path / "a.csv", time, 10.0 * np.sin(2 * math.pi * time), -10.0 + 16.0 * time)
    (said,) = Recording.read(file).warnings
    assert "the force jumps by 16 N, 100 % of its range" in said
    assert "speed" not in said


@pytest.mark.parametrize("noise", [0.0, 0.003])
def test_a_kink_is_told_as_a_step_of_the_speed(tmp_path, noise):
    """A parabola closes in position, with a speed of -40 mm/s at its start and +40 mm/s at its end."""
    time = np.linspace(0.0, 1.0, 501)
    place = 40.0 * time * (time - 1.0) + noise * np.random.default_rng(1).standard_normal(501)
    said = Recording.read(written(tmp_path / "a.csv", time, place)).warnings
    (step,) = (found for one in said for found in re.findall(r"speed jumps by ([\d.]+) m/s", one))
    assert float(step) == pytest.approx(0.08, rel=0.05)


def test_a_step_of_a_recorded_speed_is_told(tmp_path):
    time = np.linspace(0.0, 1.0, 501)
    said = Recording.read(written(tmp_path / "a.csv", time, time - 0.5, heading="Velocity (m/s)")).warnings
    assert any("speed jumps by 1 m/s, 100 % of its range" in one for one in said)


@sampled("seed", range(8), every=6)
@pytest.mark.parametrize("noise", [0.0, 0.02, 0.2])
@pytest.mark.parametrize("rows", [41, 101, 1001])
def test_closed_cycles_are_not_warned_of(tmp_path, seed, noise, rows):
    """Cycles of up to six harmonics with any phases, with noise, and a force with a step inside."""
    random = np.random.default_rng(seed)
    time = np.linspace(0.0, 1.0, rows)
    place = sum(
        30.0 / order**2 * random.uniform() * np.cos(2 * math.pi * (order * time + random.uniform()))
        for order in range(1, 7)
    )
    force = -5.0 + 10.0 * ((time > 0.2) & (time < 0.6)) + 5.0 * noise * random.standard_normal(rows)
    place = place + noise * random.standard_normal(rows)
    said = Recording.read(written(tmp_path / "a.csv", time, place, force), cutoff=14.0).warnings
    assert not any("jumps" in one for one in said)
