"""Recordings that may be misread: what is in doubt is refused or said, never guessed."""

import numpy as np
import pytest

import infinivar as iv
from infinivar import InputError, ParameterError

TIME = np.linspace(0.0, 1.0, 101)
WAVE = np.sin(2.0 * np.pi * TIME)


def table(path, headings, *columns):
    """A file with the given headings and columns."""
    np.savetxt(path, np.column_stack(columns), delimiter=",", header=headings, comments="", fmt="%.6f")
    return path


@pytest.mark.parametrize(
    "heading", ["ankle_moment_Nm/kg", "ankle moment Nm/kg", "Ankle moment per kg", "ankle_moment_kg"]
)
def test_a_moment_per_kilogram_by_its_name_is_not_read_as_another(tmp_path, heading):
    """Advice, followed to the letter, leads to a moment per kilogram, which needs a body mass."""
    for unit in ("", " [N m]"):
        file = table(tmp_path / "gait.csv", f"%GC,ankle_angle_deg,{heading}{unit}", 100.0 * TIME, WAVE, WAVE)
        with pytest.raises(InputError, match="kg"):
            iv.read_table(file)
    columns = {"phase": "%GC", "angle": "ankle_angle_deg", "moment": f"{heading} [N m]"}
    file = table(tmp_path / "gait.csv", f"%GC,ankle_angle_deg,{heading}", 100.0 * TIME, WAVE, WAVE)
    with pytest.raises(InputError, match="kg"):
        iv.read_table(file, columns=columns)
    if "/kg" not in heading or " " in heading:
        columns["moment"] = f"{heading} [N m/kg]"
    else:
        columns["moment"] = heading
    found = iv.read_table(file, columns=columns, body_mass=75.0).columns["moment"].values
    np.testing.assert_allclose(found, 75.0 * WAVE, atol=1e-4)


@pytest.mark.parametrize("mass", [0.0, -75.0, float("nan")])
def test_a_body_mass_is_positive(tmp_path, mass):
    file = table(tmp_path / "gait.csv", "%GC,ankle_angle_deg,ankle_moment_Nm/kg", 100.0 * TIME, WAVE, WAVE)
    with pytest.raises(ParameterError, match="body_mass must be > 0 kg"):
        iv.read_table(file, body_mass=mass)


def test_percent_of_the_gait_cycle_keeps_its_sign(tmp_path):
    file = table(tmp_path / "gait.csv", "%GC,ankle_angle_deg", 100.0 * TIME, WAVE)
    assert iv.read_table(file).columns["phase"].heading == "%GC"
    mapped = iv.read_table(file, columns={"phase": "%GC", "angle": "ankle_angle_deg"})
    np.testing.assert_allclose(mapped.columns["phase"].values, TIME, atol=1e-7)


def test_a_sign_reversed_twice_over_is_said_once(tmp_path):
    file = table(tmp_path / "log.csv", "Time / s,POSITION_MM", TIME, WAVE)
    found = iv.read_table(file, flip=("position", "position"))
    assert found.remarks == ("sign of the position reversed",)
    np.testing.assert_allclose(found.columns["position"].values, -1e-3 * WAVE, atol=1e-9)


def test_joints_that_a_study_names_are_read(tmp_path):
    """What the headings leave in doubt, a study decides."""
    file = table(tmp_path / "two.csv", "Time (s),Knee angle (deg),Hip moment (Nm)", TIME, WAVE, WAVE)
    for chosen in (None, {"time": "Time", "angle": "Knee angle", "moment": "Hip moment"}):
        if chosen is None:
            with pytest.raises(InputError, match="different joints"):
                iv.read_table(file)
        else:
            assert set(iv.read_table(file, columns=chosen).columns) == set(chosen)


TURN = 2.0 * np.pi


@pytest.mark.parametrize("order", ["Pos (mm),Speed (mm/s)", "Angle (deg),Angular speed (deg/s)"])
@pytest.mark.parametrize(("factor", "said"), [(1.0, None), (-1.0, "200 %"), (0.0, "100 %"), (0.5, "50 %"), (0.9, None)])
def test_a_speed_beside_a_position_is_compared_and_not_used(tmp_path, order, factor, said):
    """Amplitudes of 1 and f times the true speed differ by |1 - f| of the larger."""
    rng = np.random.default_rng(7)
    place = np.round(30.0 * WAVE, 1)  # counts of 0.1, whose slope from row to row is noise
    speed = factor * 30.0 * TURN * np.cos(TURN * TIME) + rng.normal(0.0, 5.0, TIME.size)
    file = table(tmp_path / "both.csv", f"Time (s),{order}", TIME, place, speed)
    alone = table(tmp_path / "alone.csv", f"Time (s),{order.partition(',')[0]}", TIME, place)
    read = iv.motion.Recording.read(str(file))
    assert read == iv.motion.Recording.read(str(alone))
    found = iv.inspect_motion(file)
    other = order.partition(",")[2]
    assert found.table.ignored == (other,)
    assert any("is not used beside" in remark and other in remark for remark in found.table.remarks)
    for warnings in (read.warnings, found.warnings):
        doubts = [warning for warning in warnings if "contradict" in warning]
        assert len(doubts) == (said is not None)
        if said is not None:
            share = float(doubts[0].partition(" is ")[2].partition(" %")[0])
            assert share == pytest.approx(float(said.partition(" ")[0]), abs=5.0)


def test_a_rested_load_with_a_speed_of_zero_agrees(tmp_path):
    file = table(tmp_path / "rest.csv", "Time (s),Pos (mm),Speed (mm/s)", TIME, 0.0 * TIME, 0.0 * TIME)
    assert not any("contradict" in warning for warning in iv.motion.Recording.read(str(file)).warnings)


def strides(path, times=True):
    """Four strides of 1 s that a phase marks."""
    time = np.arange(401) / 100.0
    columns = [time] if times else []
    angle = 20.0 * np.sin(TURN * time)
    return table(path, "Time (s)," * times + "phase (%),Knee angle (deg)", *columns, 100.0 * (time % 1.0), angle)


def test_strides_that_a_phase_marks_are_shown_whole(tmp_path):
    found = iv.inspect_motion(strides(tmp_path / "long.csv"))
    assert len(found.strides) == 4
    assert found.strides.method == "phase"
    assert found.motion.period == pytest.approx(4.0)
    found = iv.inspect_motion(strides(tmp_path / "phase.csv", times=False), cycle_time=1.0)
    assert len(found.strides) == 4
    assert found.extremes["position"][1] == pytest.approx(np.radians(20.0), rel=1e-3)


def test_strides_that_a_phase_marks_are_a_run_if_a_study_says_so(tmp_path):
    file = str(strides(tmp_path / "long.csv"))
    with pytest.raises(InputError, match=r"starts another stride; .* closed = false"):
        iv.motion.Recording.read(file)
    assert iv.motion.Recording.read(file, closed=False).period == pytest.approx(4.0)


STUDY = """
[requirement]
base = "faulring2006"
[drives.cobotic]
base = "faulring2006.cobotic"
[duty.fast]
shape = "sinusoid"
distance = "10 mm"
frequency = "1 Hz"
time_share = "60 %"
[duty.slow]
shape = "sinusoid"
distance = "10 mm"
frequency = "{frequency}"
time_share = "{share}"
"""


def test_a_faulty_duty_table_is_one_fault(tmp_path):
    """The shares are not added up while one is unknown."""
    file = tmp_path / "mixed.toml"
    file.write_text(STUDY.format(frequency="1 m", share="40 %"), "utf-8")
    with pytest.raises(InputError, match=r"duty\.slow\.frequency") as fault:
        iv.load_study(file)
    assert len(str(fault.value).splitlines()) == 1
    file.write_text(STUDY.format(frequency="1 Hz", share="30 %"), "utf-8")
    with pytest.raises(InputError, match="add up to 90 %"):
        iv.load_study(file)


def test_comments_between_rows_are_said(tmp_path):
    """A row behind a comment sign may be a comment by mistake; blank lines and comments above the rows are not."""
    file = table(tmp_path / "log.csv", "Time (s),Pos (mm)", TIME, WAVE)
    lines = file.read_text("utf-8").splitlines()
    assert iv.read_table(file).remarks == ()
    lines[50] = "# " + lines[50]
    file.write_text("\n".join(["# a logger", *lines[:70], "", *lines[70:], "# the end"]), "utf-8")
    found = iv.read_table(file)
    assert len(found) == len(TIME) - 1
    assert found.remarks == ("1 comment between the rows not read: line 52",)


def test_a_faulty_unit_below_the_headings_is_found_where_it_stands(tmp_path):
    file = tmp_path / "log.csv"
    file.write_text("a logger\nTime,Pos,Fz\ns,mm,bananas\n" + "\n".join(f"{t:.2f},1,2" for t in TIME), "utf-8")
    with pytest.raises(InputError, match=r"log\.csv: line 3, column 'Fz': has an unknown unit 'bananas'"):
        iv.read_table(file)
