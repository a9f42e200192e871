"""Phases of a cycle that are misread or incomplete are refused, with what is wrong."""

import numpy as np
import pytest

import infinivar as iv
from infinivar import InputError
from infinivar.motion import Recording
from internals import motion_summary_rows as rows


def written(path, phase, heading="phase_ipsi"):
    lines = [f"{one:.4f},{np.sin(2 * np.pi * place):.5f}" for place, one in zip(phase / phase[-1], phase, strict=True)]
    path.write_text(f"{heading},knee_angle (rad)\n" + "\n".join(lines) + "\n")
    return str(path)


def test_a_phase_from_0_to_1_is_no_percentage(tmp_path):
    file = written(tmp_path / "a.csv", np.linspace(0.0, 1.0, 51))
    with pytest.raises(
        InputError, match=r"line 1, column 'phase_ipsi': is in %, but reaches only 1 %; if it counts .* \[1\]"
    ):
        Recording.read(file, cycle_time=1.1)
    columns = {"phase": "phase_ipsi [1]", "angle": "knee_angle (rad)"}
    assert Recording.read(file, cycle_time=1.1, columns=columns).period == pytest.approx(1.1)
    stated = written(tmp_path / "b.csv", np.linspace(0.0, 1.0, 51), "phase [1]")
    assert Recording.read(stated, cycle_time=1.1).period == pytest.approx(1.1)


def test_a_part_of_a_cycle_is_no_cycle(tmp_path):
    file = written(tmp_path / "a.csv", np.linspace(0.0, 60.0, 51))
    said = r"line 52, column 'phase_ipsi': must cover the cycle, but ends at 60\.0 % and leaves out 40\.0 % of it"
    with pytest.raises(InputError, match=said):
        Recording.read(file, cycle_time=1.1)
    twice = tmp_path / "b.csv"
    head, *body = (tmp_path / "a.csv").read_text().splitlines()
    twice.write_text("\n".join([head, *body, *body]) + "\n")
    with pytest.raises(InputError, match=said):
        Recording.read(str(twice), cycle_time=1.1, strides="average")


@pytest.mark.parametrize("count", [20, 50, 100, 101, 200])
def test_a_last_row_before_the_end_closes(tmp_path, count):
    file = written(tmp_path / "a.csv", np.arange(count) * (100.0 / count))
    assert Recording.read(file, cycle_time=1.1).period == pytest.approx(1.1)


def test_first_values_are_shown_in_their_unit(tmp_path):
    found = iv.inspect_motion(
        written(tmp_path / "a.csv", np.linspace(0.0, 100.0, 201), "Gait cycle [%]"), cycle_time=1.1
    )
    phase = next(one for one in rows(found) if one["role"] == "phase")
    assert phase["first"] == "0, 0.5, 1, ... %"
