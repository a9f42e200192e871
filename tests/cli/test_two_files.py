"""A motion in one file and its force or moment in another: the same as one file with both, or a message that says why not."""

import json

import numpy as np
import pytest

import infinivar as iv
from internals import input_files

PERIOD = 1.1
STUDY = """
[requirement]
base = "faulring2006"
[drives.cobotic]
base = "faulring2006.cobotic"
[duty.walk]
shape = "file"
file = "angle.csv"
force_file = "moment.csv"
cutoff = "8 Hz"
{more}
"""


def angle(share):
    return 20.0 * np.sin(2.0 * np.pi * share) + 6.0 * np.cos(4.0 * np.pi * share)


def moment(share):
    return 3.0 + 2.0 * np.cos(2.0 * np.pi * share) - 0.5 * np.sin(6.0 * np.pi * share)


CURVED = (2.0 * (2.0 * np.pi) ** 2 + 0.5 * (6.0 * np.pi) ** 2) / 8.0
"""Bound of the second derivative of the moment in the share of the cycle, over 8: times the square of the step of the second
file it bounds the error of straight lines."""


def written(path, headings, *columns):
    rows = "".join(",".join(f"{value:.9g}" for value in row) + "\n" for row in zip(*columns, strict=True))
    path.write_text(headings + "\n" + rows)
    return str(path)


def by_time(folder, start=-0.2, end=1.3, rate=260.0, more=0.0):
    """Angle at 100 Hz over a cycle, and the moment at another rate and over other times."""
    one, two = np.linspace(0.0, PERIOD, 111), np.arange(start, end + 1e-9, 1.0 / rate)
    first = written(folder / "angle.csv", "time [s],Knee angle [deg]", one, angle(one / PERIOD))
    second = written(folder / "moment.csv", "t [ms],Knee moment [Nm]", 1e3 * two + more, moment(two / PERIOD))
    both = written(folder / "both.csv", "t [s],angle [deg],moment [Nm]", one, angle(one / PERIOD), moment(one / PERIOD))
    return first, second, both


def assert_same(found, known, tolerance):
    at = np.linspace(0.0, known.period, 400)
    assert found.period == known.period
    for mine, other in zip(found.derivatives(at, 2), known.derivatives(at, 2), strict=True):
        assert mine == pytest.approx(other, abs=1e-12)
    assert found.push(at, 0)[0] == pytest.approx(known.push(at, 0)[0], abs=tolerance)


def test_two_rates_give_the_course_of_one_file(tmp_path):
    """The force differs by the error of straight lines through the second file, times 2 for the ripple of the smoothing."""
    first, second, both = by_time(tmp_path)
    found, known = iv.motion.Recording.read(first, force_file=second), iv.motion.Recording.read(both)
    assert_same(found, known, 2.0 * CURVED / (260.0 * PERIOD) ** 2)
    assert found.warnings == known.warnings == ()
    summary = iv.inspect_motion(first, force_file=second)
    assert summary.work == pytest.approx(iv.inspect_motion(both).work, rel=1e-3)
    (remark,) = summary.table.remarks
    assert remark.endswith("391 rows from -0.2 s to 1.3 s, interpolated linearly at 111 rows of the motion")
    assert "moment 'Knee moment [Nm]' of " in remark


def test_two_phases_give_the_course_of_one_file(tmp_path):
    """The moment has other phases, from 1.5 to 99.5 %, or equal steps of the cycle."""
    one, two, steps = np.linspace(0.0, 1.0, 101), np.linspace(0.015, 0.995, 60), np.linspace(0.0, 1.0, 51)
    first = written(tmp_path / "angle.csv", "phase [%],angle [deg]", 100.0 * one, angle(one))
    known = iv.motion.Recording.read(
        written(tmp_path / "both.csv", "phase [%],angle [deg],moment [Nm]", 100.0 * one, angle(one), moment(one)),
        cycle_time=PERIOD,
    )
    phased = written(tmp_path / "phased.csv", "gait cycle [%],moment [Nm]", 100.0 * two, moment(two))
    assert_same(iv.motion.Recording.read(first, force_file=phased, cycle_time=PERIOD), known, 2.0 * CURVED * 0.02**2)
    stepped = written(tmp_path / "stepped.csv", "moment [Nm]", moment(steps))
    assert_same(iv.motion.Recording.read(first, force_file=stepped, cycle_time=PERIOD), known, 2.0 * CURVED * 0.02**2)


@pytest.mark.parametrize("strides", [1, 3])
def test_the_same_rows_are_one_file(tmp_path, strides):
    """Strides that state 100 % of one and 0 % of the next keep the ends of each, also of the moment."""
    share = np.linspace(0.0, 1.0, 51)
    size = np.repeat(1.0 + 0.1 * np.arange(strides), 51)
    phase, one, two = (
        100.0 * np.tile(share, strides),
        size * np.tile(angle(share), strides),
        size * np.tile(moment(share), strides),
    )
    first = written(tmp_path / "a.csv", "phase [%],angle [deg]", phase, one)
    second = written(tmp_path / "b.csv", "phase [%],moment [Nm]", phase, two)
    both = written(tmp_path / "c.csv", "phase [%],angle [deg],moment [Nm]", phase, one, two)
    how = {"cycle_time": PERIOD, "strides": "average" if strides > 1 else "one"}
    found, known = iv.motion.Recording.read(first, force_file=second, **how), iv.motion.Recording.read(both, **how)
    assert found == known
    assert found.as_cycles == known.as_cycles
    assert len(found.as_cycles) == (strides if strides > 1 else 0)


def test_signs_masses_and_columns_belong_to_the_file_that_has_them(tmp_path):
    time = np.linspace(0.0, 1.0, 51)
    first = written(tmp_path / "a.csv", "time [s],A [deg],Fz [N]", time, angle(time), time)
    second = written(
        tmp_path / "b.csv", "time [s],knee angle [deg],M1 [Nm/kg],M2 [Nm/kg]", time, time, moment(time), time
    )
    both = written(tmp_path / "c.csv", "time [s],angle [deg],moment [Nm]", time, -angle(time), -50.0 * moment(time))
    how = {"columns": {"time": "time", "angle": "A"}, "force_columns": {"time": "time", "moment": "M1"}}
    found = iv.motion.Recording.read(first, force_file=second, **how, flip=["angle", "moment"], body_mass=50.0)
    assert found.force == pytest.approx(iv.motion.Recording.read(both).force, rel=1e-7)
    assert found.position == pytest.approx(iv.motion.Recording.read(both).position, rel=1e-7)


def test_what_is_not_used_is_said(tmp_path):
    time = np.linspace(0.0, 1.0, 51)
    first = written(tmp_path / "a.csv", "time [s],angle [deg],Fz [N]", time, angle(time), time)
    second = written(tmp_path / "b.csv", "time [s],angle [deg],moment [Nm]", time, time, moment(time))
    remarks = "\n".join(iv.inspect_motion(first, force_file=second).table.remarks)
    assert f"'Fz [N]' of {first} is not used: the moment is that of {second}" in remarks
    assert f"'angle [deg]' of {second} is not used: the motion is that of {first}" in remarks


def test_rows_beyond_the_second_file_are_left_out_and_said(tmp_path):
    """Within a step the last value holds, so that a cycle keeps its period; beyond, rows are left out."""
    first, second, _ = by_time(tmp_path, start=0.0, end=1.093)
    summary = iv.inspect_motion(first, force_file=second)
    assert summary.motion.period == PERIOD
    assert "the value at its end holds for up to 0.00769 s" in summary.table.remarks[0]
    first, second, both = by_time(tmp_path, start=0.0, end=0.7)
    found = iv.motion.Recording.read(first, force_file=second, closed=False)
    known = iv.motion.Recording.read(both, closed=False, window=[0.0, 0.7])
    assert found.period == pytest.approx(0.7)
    assert found.force == pytest.approx(known.force, abs=CURVED / (260.0 * PERIOD) ** 2)
    assert found.warnings == (
        f"{first}: 40 of 111 rows are left out: they are from 0 s to 1.1 s, but {second} has the moment from 0 s to 0.7 s",
    )
    assert not iv.motion.Recording.read(first, force_file=second, closed=False, window=[0.1, 0.6]).warnings


def test_a_gap_in_the_second_file_is_named(tmp_path):
    time = np.linspace(0.0, 1.0, 101)
    first = written(tmp_path / "a.csv", "time [s],angle [deg]", time, angle(time))
    kept = (time < 0.4) | (time > 0.6)
    second = written(tmp_path / "b.csv", "time [s],moment [Nm]", time[kept], moment(time[kept]))
    (warning,) = iv.motion.Recording.read(first, force_file=second).warnings
    assert warning == f"{second}: line 42: 0.22 s without data, 22 times the median step; interpolated linearly"


FAULTS = {
    "no such file": (None, "", "nope", "nope.csv: no such file"),
    "no common time": ("t [s],moment [Nm]\n5,1\n6,2\n", "", "moment",
        "moment.csv: lines 2 to 3, column 't [s]': must have times in common with "),
    "no time": ("moment [Nm]\n1\n2\n", "", "moment", "moment.csv: line 1: must name a column of time, as "),
    "a phase beside times": ("phase [%],moment [Nm]\n0,1\n100,2\n", "", "moment",
        "moment.csv: line 1: must name a column of time, as "),
    "no moment": ("t [s],angle [deg]\n0,1\n1,2\n", "", "moment", "moment.csv: line 1: must name a column of moment, as "),
    "a force about a joint": ("t [s],Fz [N]\n0,1\n1,2\n", "", "moment",
        "moment.csv: line 1: must name a column of moment, not only of force, as "),
    "another joint": ("t [s],hip moment [Nm]\n0,1\n1,2\n", "", "moment",
        "moment.csv: line 1, column 'hip moment [Nm]': is of another joint or side than 'Knee angle [deg]' of "),
    "two moments": ("t [s],moment a [Nm],moment b [Nm]\n0,1,2\n1,2,2\n", "", "moment",
        "(for this file, the key is force_columns)"),
    "a bad cell": ("t [s],moment [Nm]\n0,1\n1,x\n", "", "moment", "moment.csv: line 3, column 'moment [Nm]': must be a finite"),
    "no unit": ("t [s],moment\n0,1\n1,2\n", "", "moment", "moment.csv: line 1, column 'moment': must state its unit"),
    "per kilogram": ("t [s],moment [Nm/kg]\n0,1\n1,2\n", "", "moment", "column 'moment [Nm/kg]': is per kilogram"),
    "an unknown column": ("t [s],moment [Nm]\n0,1\n1,2\n", 'force_columns = { time = "t", moment = "M" }', "moment",
        "moment.csv: line 1: has no column 'M'"),
    "a motion in force_columns": ("t [s],moment [Nm]\n0,1\n1,2\n", 'force_columns = { angle = "t" }', "moment", "'angle'"),
    "a moment in both": ("t [s],moment [Nm]\n0,1\n1,2\n", 'columns = { time = "time", angle = "Knee angle", moment = "x [Nm]" }',
        "moment", "columns names a moment, and so does force_file; move it to force_columns, or remove one of them"),
    "a cycle time beside times": ("t [s],moment [Nm]\n0,1\n1,2\n", 'cycle_time = "1.1 s"', "moment",
        "angle.csv: line 1, column 'time [s]': states times, so cycle_time does not apply"),
    "a cycle that is cut off": ("t [s],moment [Nm]\n0,1\n0.3,2\n0.5,2\n", "", "moment",
        "angle.csv: 60 of 111 rows are left out: they are from 0 s to 1.1 s, but moment.csv"),
}  # fmt: skip


@pytest.mark.parametrize("name", FAULTS)
def test_faults_are_one_line(infinivar, write, tmp_path, name):
    text, more, file, message = FAULTS[name]
    by_time(tmp_path)
    if text is not None:
        (tmp_path / "moment.csv").write_text(text)
    done = infinivar("check", write(STUDY.format(more=more).replace("moment.csv", f"{file}.csv")))
    assert done.code == 2
    assert done.err.count("\n") == 1, done.err
    assert message in done.err
    assert not done.out


def test_strides_by_phase_need_the_same_rows(tmp_path):
    share = np.linspace(0.0, 1.0, 51)
    first = written(tmp_path / "a.csv", "phase [%],angle [deg]", np.tile(100.0 * share, 3), np.tile(angle(share), 3))
    second = written(tmp_path / "b.csv", "phase [%],moment [Nm]", 100.0 * share, moment(share))
    with pytest.raises(
        iv.InputError, match=r"b.csv: line 1: must have the same rows of phase as .*a.csv.*got 51 rows for 151"
    ):
        iv.motion.Recording.read(first, force_file=second, cycle_time=PERIOD, strides="average")
    with pytest.raises(iv.ParameterError, match="force_columns does not apply without force_file"):
        iv.motion.Recording.read(first, force_columns={"moment": "moment"}, cycle_time=PERIOD)


def test_a_study_finds_keeps_and_protects_both_files(tmp_path):
    """From its own folder, extended from another, saved to a third; the data replace files that are gone."""
    inner, other = tmp_path / "inner", tmp_path / "other"
    inner.mkdir()
    by_time(inner)
    (inner / "base.toml").write_text(STUDY.format(more='force_columns = { time = "t", moment = "Knee moment" }'))
    (tmp_path / "mine.toml").write_text('extends = "inner/base.toml"\n')
    base, mine = iv.load_study(inner / "base.toml"), iv.load_study(tmp_path / "mine.toml")
    assert mine.duty == base.duty
    for study in (base, mine):
        assert {one.resolve().name for one in input_files(study)} >= {"angle.csv", "moment.csv"}
    again = iv.load_study(mine.save(other / "again.toml"))
    assert again.duty == base.duty
    assert 'force_file = "../inner/moment.csv"' in (other / "again.toml").read_text()
    (inner / "moment.csv").unlink()
    gone = iv.load_study(again.save(tmp_path / "gone.toml"))
    assert gone.duty == base.duty
    assert "force_file" not in (tmp_path / "gone.toml").read_text()


def test_the_command_reads_both(infinivar, tmp_path):
    by_time(tmp_path)
    done = infinivar(
        "motion", "angle.csv", "--force-file", "moment.csv", "--force-columns", "time=t, moment=Knee moment", "--json"
    )
    assert done.code == 0
    found = json.loads(done.out)
    assert [one["role"] for one in found["columns"]] == ["time", "angle", "moment"]
    assert "of moment.csv" in found["remarks"][0]
    assert infinivar("motion", "angle.csv", "--force-columns", "moment=M").code == 2
