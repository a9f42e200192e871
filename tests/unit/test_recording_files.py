"""One recording in many writings is one table; what a file does not state is never guessed."""

import dataclasses
import importlib
import sys
import types

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import infinivar as iv
from infinivar import DutyCycle, InputError, Output, ParameterError, duty_cycle, read_table
from infinivar.motion import RecordedTable, Recording
from infinivar.parts import Linkage
from internals import (
    LINEAR,
    ROTARY,
    TextSheet,
    family_of,
    heading_of,
    read_timed,
    shipped_study,
    unit_and_per_kg,
    windowed,
)
from internals import TableColumn as Column
from internals import resampled_table as resampled
from sampled import examples

ARM = 0.0625
"""Lever arm of the joint, a power of two, so that angles and moments are exact. [m]"""

TIME = np.linspace(0.0, 1.0, 201)
POSITION = 50.0 * np.sin(2 * np.pi * TIME) + 10.0 * np.cos(4 * np.pi * TIME)
FORCE = -4.0 + 3.0 * np.cos(2 * np.pi * TIME)
DIGITS = [[f"{t:.4f}", f"{x:.6f}", f"{f:.6f}"] for t, x, f in zip(TIME, POSITION, FORCE, strict=True)]


def joined(mark, *top, rows=DIGITS, end="\n"):
    return end.join([*top, *[mark.join(row) for row in rows]]) + end


def comma(text):
    return text.replace(".", ",")


CSV = joined(",", "time [s],position [mm],force [N]")
STO = ["motion", "version=1", "nRows=201", "nColumns=3", "inDegrees=no", "endheader", "time\tposition_mm\tforce_N"]
WRITINGS = {
    "logger": joined(",", "Time (s),Pos (mm),Fz (N)"),
    "underscores": joined(",", "time_s,pos_mm,force_N"),
    "semicolons": joined(";", "Time (s);Pos (mm);Fz (N)"),
    "decimal commas": comma(joined(";", "Time [s];Pos [mm];F [N]")),
    "byte-order mark": joined(",", "Time (s),Pos (mm),Fz (N)").encode("utf-8-sig"),
    "UTF-16": joined("\t", "Time (s)\tPos (mm)\tFz (N)").encode("utf-16"),
    "Windows line ends": joined(",", "Time (s),Pos (mm),Fz (N)", end="\r\n"),
    "old Macintosh line ends": joined(",", "Time (s),Pos (mm),Fz (N)", end="\r"),
    "tabs with decimal commas": comma(joined("\t", "Time (s)\tPos (mm)\tFz (N)")),
    "blanks": joined("   ", "  time [s]   pos [mm]   force [N]"),
    "blanks with decimal commas": comma(joined(" ", "time_s pos_mm force_N")),
    "comment above": joined(",", "# logger 7", "", "# Time (s),Pos (mm),Fz (N)"),
    "comments": joined(",", "# logger 7", "Time (s),Pos (mm),Fz (N)", "// started", ""),
    "preamble of a logger": joined(
        ";", "Logger 7", "Date;2024-05-01", "Rate;1000", "", "Time;Pos;Fz", "s;mm;N", "", rows=DIGITS
    ),
    "row of units": joined(",", "Time,Pos,Fz", "s,mm,N"),
    "row of units in brackets": joined(";", "Time;Pos;Fz", "[s];[mm];[N]"),
    "other columns": joined(
        ",", "sample,Time (s),Pos (mm),Setpoint (mm),Fz (N),note", rows=[["x", a, b, "", c, "on"] for a, b, c in DIGITS]
    ),
    "quotes": joined(",", '"Time (s)","Pos (mm)","Fz (N)"', rows=[[f'"{cell}"' for cell in row] for row in DIGITS]),
    "marks at the end": joined(",", "Time (s),Pos (mm),Fz (N),", rows=[[*row, ""] for row in DIGITS]),
    "heading in Latin-1": joined(
        ",", "Time (s),Pos (mm),Fz (N),Temperature (°C)", rows=[[*row, "20"] for row in DIGITS]
    ).encode("latin-1"),
    "OpenSim": joined("\t", *STO),
    "OpenSim with blanks": joined("  ", *STO[:-1], "time position_mm  force_N"),
}


def saved(folder, content, name="motion.csv"):
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return str(path)


@pytest.fixture
def reference(tmp_path):
    return read_table(saved(tmp_path, CSV, "reference.csv"))


def drive():
    return shipped_study("faulring2006").drives["cobotic"]


@pytest.mark.parametrize("name", WRITINGS)
def test_a_motion_in_every_writing_is_one_motion(tmp_path, reference, name):
    """Exactly: the same digits are the same numbers, so that any result is the same, such as the energy of the cycle."""
    path = saved(tmp_path, WRITINGS[name], "motion.sto" if "OpenSim" in name else "motion.csv")
    table = read_table(path)
    assert list(table.columns) == ["time", "position", "force"]
    for role, column in table.columns.items():
        assert np.array_equal(column.values, reference.columns[role].values)
    assert table.axis is LINEAR
    assert Recording.read(path) == Recording.of(reference)


def test_what_was_understood_is_said(tmp_path):
    def said(name):
        return read_table(saved(tmp_path, WRITINGS[name], "motion.sto" if "OpenSim" in name else "motion.csv"))

    assert said("logger").format == "CSV with commas, UTF-8"
    assert said("decimal commas").format == "CSV with semicolons and decimal commas, UTF-8"
    assert said("byte-order mark").format == "CSV with commas, UTF-8 with byte-order mark"
    assert said("UTF-16").format == "text with tabs, UTF-16"
    assert said("OpenSim").format == "OpenSim storage with angles in rad with tabs, UTF-8"
    found = said("other columns")
    assert found.ignored == ("sample", "Setpoint (mm)", "note")
    assert [(column.heading, column.unit) for column in found.columns.values()] == [
        ("Time (s)", "s"),
        ("Pos (mm)", "mm"),
        ("Fz (N)", "N"),
    ]
    assert found.lines[0] == 2
    assert said("comments").lines[0] == 5


def test_energies_are_equal_too(tmp_path):
    """A shape, and its rows as CSV, with decimal commas, of OpenSim, and as angle and moment about a joint behind a lever.

    Straight lines between rows a time h apart change a sinusoid by (w h)^2/8 at most, here 5e-6 of it, and the force, which is
    linear in the acceleration, by as much; smoothing leaves a sinusoid below half of the cutoff.
    """
    shape = DutyCycle(motion=iv.motion.Sinusoid(distance=0.02, frequency=1.0), force=-4.0, load_mass=0.8)
    at = np.arange(1001) / 1000
    metres = (0.02 * np.sin(2 * np.pi * at)).tolist()
    along = [[f"{t:.3f}", repr(x), "-4.0"] for t, x in zip(at, metres, strict=True)]
    about = [[f"{t:.3f}", repr(x / ARM), repr(-4.0 * ARM)] for t, x in zip(at, metres, strict=True)]
    top = [line.replace("201", "1001").replace("position_mm", "position_m") for line in STO]
    linear = [
        joined(",", "Time (s),Pos (m),Fz (N)", rows=along),
        comma(joined(";", "Time (s);Pos (m);Fz (N)", rows=along)),
        joined("\t", *top, rows=along),
    ]
    cobotic = drive()
    expected = duty_cycle(cobotic, shape).energy
    found = [
        duty_cycle(cobotic, DutyCycle(motion=Recording.read(saved(tmp_path, text)), load_mass=0.8)).energy
        for text in linear
    ]
    assert found == [found[0]] * 3
    assert found[0] == pytest.approx(expected, rel=1e-4)
    motion = Recording.read(saved(tmp_path, joined(",", "Time (s),Knee angle (rad),Knee moment (N-m)", rows=about)))
    lever = dataclasses.replace(cobotic, output=Output(linkage=Linkage(arm=ARM)))
    turned = duty_cycle(lever, DutyCycle(motion=motion, load_inertia=0.8 * ARM**2)).energy
    assert turned == pytest.approx(found[0], rel=1e-9)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_angle_and_moment_are_position_and_force_about_a_joint(tmp_path, sign):
    """Through a constant arm: the same work and the same spectrum, exactly."""
    metres = (POSITION / 1e3).tolist()
    about = [
        [t, repr(x / ARM), repr(sign * f * ARM)] for (t, _, _), x, f in zip(DIGITS, metres, FORCE.tolist(), strict=True)
    ]
    along = [[t, repr(x), repr(f)] for (t, _, _), x, f in zip(DIGITS, metres, FORCE.tolist(), strict=True)]
    joint = read_table(
        saved(tmp_path, joined(",", "Time (s),Ankle angle (rad),Ankle torque (N-m)", rows=about)),
        flip=() if sign > 0 else ("moment",),
    )
    line = read_table(saved(tmp_path, joined(",", "time [s],x pos [m],F [N]", rows=along)))
    assert (joint.axis, line.axis) == (ROTARY, LINEAR)
    assert np.array_equal(joint.values["position"] * ARM, line.values["position"])
    assert np.array_equal(joint.values["force"] / ARM, line.values["force"])
    turning, moving = Recording.of(joint), Recording.of(line)
    assert turning.axis is ROTARY
    at = np.linspace(0.0, 1.0, 997)
    turns, moves = turning.derivatives(at, 4), moving.derivatives(at, 4)
    for one, other in zip(turns, moves, strict=True):
        assert np.array_equal(one * ARM, other)
    power = turning.push(at, 0)[0] * turns[1]
    assert np.array_equal(power, moving.push(at, 0)[0] * moves[1])
    assert abs(np.mean(power)) < 0.2 * np.max(np.abs(power))


HEADINGS = {
    "Time (s)": ("time", "s"),
    "t [ms]": ("time", "ms"),
    "timestamp_us": ("time", "us"),
    "Pos (mm)": ("position", "mm"),
    "pos_mm": ("position", "mm"),
    "Link position_m": ("position", "m"),
    "velocity (mm/s)": ("speed", "mm/s"),
    "speed_m_s": ("speed", "m/s"),
    "Fz (N)": ("force", "N"),
    "GRF force_kN": ("force", "kN"),
    "Ankle angle (rad)": ("position", "rad"),
    "knee_flexion_angle_ipsi_rad": ("position", "rad"),
    "knee_flexion_velocity_ipsi_rad_s": ("speed", "rad/s"),
    "knee_flexion_moment_ipsi_Nm": ("force", "N m"),
    "knee_flexion_moment_ipsi_Nm_kg": ("force", "N m"),
    "Ankle torque (N-m)": ("force", "N m"),
    "Ankle moment [N·m/kg]": ("force", "N m"),
    "AnkleMoment (Nm kg^-1)": ("force", "N m"),
    "ankle_moment_Nm/kg": ("force", "N m"),
    "ankle_moment_N-m/kg": ("force", "N m"),
    "hip_velocity_rad/s": ("speed", "rad/s"),
    "TIME_S": ("time", "s"),
    "POSITION_MM": ("position", "mm"),
    "SPEED_MM_S": ("speed", "mm/s"),
    "FORCE_N": ("force", "N"),
    "Time / s": ("time", "s"),
    "Pos / mm": ("position", "mm"),
    "Speed / (mm/s)": ("speed", "mm/s"),
    "Torque / Nm/kg": ("force", "N m"),
    "%GC": ("phase", "%"),
    "Gait cycle (%)": ("phase", "%"),
    "% gait cycle": ("phase", "%"),
    "stride_percent": ("phase", "%"),
    "phase_ipsi": ("phase", None),
    "Heel strike": ("heel_strike", None),
    "left_heel_strike": ("heel_strike", None),
    "Ankle angular velocity (deg/s)": ("speed", "deg/s"),
    "Moment arm (mm)": (None, "mm"),
    "Setpoint position (mm)": (None, "mm"),
    "Knee angle SD (deg)": (None, "deg"),
    "Temperature (degC)": (None, "degC"),
    "acceleration (m/s^2)": (None, "m/s^2"),
}


@pytest.mark.parametrize("text", HEADINGS)
def test_headings_are_taken_apart(text):
    family, unit = HEADINGS[text]
    found = heading_of(text)
    assert family_of(found.name, found.unit) == family
    assert (found.unit and unit_and_per_kg(found.unit)[0]) == unit
    assert unit_and_per_kg(found.unit or "")[1] == ("kg" in text)


def test_units_are_converted(tmp_path):
    text = "t [min],Angle (deg),Torque (mNm)\n0,180,5\n0.5,90,-5\n"
    table = read_table(saved(tmp_path, text))
    assert table.columns["time"].values.tolist() == [0.0, 30.0]
    assert table.columns["angle"].values == pytest.approx([np.pi, np.pi / 2], rel=1e-15)
    assert table.columns["moment"].values == pytest.approx([5e-3, -5e-3], rel=1e-15)
    assert table.columns["moment"].unit == "mNm"


def test_a_position_is_an_angle_if_its_unit_says_so(tmp_path):
    table = read_table(saved(tmp_path, "t [s],Position [deg],Velocity [deg/s]\n0,1,0\n1,2,0\n"))
    assert list(table.columns) == ["time", "angle", "angular_speed"]


@pytest.mark.parametrize(
    ("columns", "top"),
    [
        ({"time": "t", "angle": "Knee angle", "moment": "M [N m]"}, "t [s],Knee angle (deg),M [N m],Hip angle (deg)"),
        ({"time": "t [s]", "angle": "knee  ANGLE [deg]", "moment": "M [N m]"}, "t,Knee angle,M,Hip angle"),
        ({"time": "t", "angle": "Angle (left) [deg]", "moment": "M"}, "t [s],Angle (left),M [Nm],Angle (right)"),
    ],
)
def test_columns_as_a_study_names_them(tmp_path, columns, top):
    table = read_table(saved(tmp_path, f"{top}\n0,180,1,7\n1,90,2,7\n"), columns=columns)
    assert list(table.columns) == ["time", "angle", "moment"]
    assert table.columns["angle"].values == pytest.approx([np.pi, np.pi / 2], rel=1e-15)
    assert table.columns["moment"].values.tolist() == [1.0, 2.0]
    assert len(table.ignored) == 1


def test_a_study_maps_flips_and_scales(tmp_path):
    """An own heading for each column, a moment per kilogram in the other direction, over a phase."""
    rows = [[f"{100 * t:.1f}", f"{10 * np.sin(2 * np.pi * t):.4f}", f"{np.cos(2 * np.pi * t):.4f}"] for t in TIME]
    saved(tmp_path, comma(joined(";", "p;Knie;M", rows=rows)), "gait.csv")
    study = """
        [requirement]
        base = "faulring2006"
        [drives.cobotic]
        base = "faulring2006.cobotic"
        [duty.gait]
        shape = "file"
        file = "gait.csv"
        columns = { phase = "p [%]", angle = "Knie [deg]", moment = "M [N m/kg]" }
        flip = ["moment"]
        body_mass = "75 kg"
        cycle_time = "1.1 s"
        cutoff = "6 Hz"
        angle_resolution = "0.1 deg"
    """
    motion = iv.load_study(saved(tmp_path, study, "study.toml")).duty["gait"].motion
    assert isinstance(motion, Recording)
    assert motion.axis is ROTARY
    assert motion.period == pytest.approx(1.1, rel=1e-12)
    assert motion.position == pytest.approx(np.radians(10 * np.sin(2 * np.pi * TIME)), abs=1e-6)
    assert motion.force == pytest.approx(-75 * np.cos(2 * np.pi * TIME), abs=4e-3)
    assert motion.resolved == pytest.approx(np.radians(0.1))
    assert (motion.flip, motion.body_mass, dict(motion.columns)) == (
        ("moment",),
        75.0,
        {"phase": "p [%]", "angle": "Knie [deg]", "moment": "M [N m/kg]"},
    )


def test_a_gait_table_of_a_textbook(tmp_path):
    """Neither time nor phase: equal steps over the cycle, both ends included."""
    rows = [[f"{a:.5f}", f"{m:.5f}"] for a, m in zip(np.sin(2 * np.pi * TIME), np.cos(2 * np.pi * TIME), strict=True)]
    path = saved(tmp_path, joined(",", "Ankle angle (rad),Ankle torque (N-m)", rows=rows))
    table = read_timed(path, cycle_time=1.1)
    assert table.columns["time"].values == pytest.approx(1.1 * TIME, abs=1e-15)
    assert table.remarks == ("equal steps from 0 to 100 % of a cycle of 1.1 s",)
    assert Recording.read(path, cycle_time=1.1).period == 1.1


def test_a_phase_that_stops_before_the_end_is_closed(tmp_path):
    rows = [[f"{k}", f"{np.sin(2 * np.pi * k / 100):.6f}"] for k in range(100)]
    table = read_timed(saved(tmp_path, joined(",", "% gait cycle,angle (rad)", rows=rows)), cycle_time=2.0)
    assert len(table) == 101
    assert table.columns["time"].values[-1] == 2.0
    assert table.columns["angle"].values[-1] == table.columns["angle"].values[0]
    assert table.remarks == ("phase times a cycle of 2 s; closed with the first row over the last 1.0 %",)


def test_opensim_states_the_unit_of_angles(tmp_path):
    top = "ik\nversion=1\nnRows=2\nnColumns=3\ninDegrees={}\n\nUnits are S.I. units\n\nendheader\n"
    top += "time knee_angle_r knee_angle_r_moment\n"
    rows = "0 180 1\n0.01 90 2\n"
    for said, factor in (("yes", np.pi / 180), ("no", 1.0)):
        table = read_table(saved(tmp_path, top.format(said) + rows, "ik.mot"))
        assert table.columns["angle"].values == pytest.approx([180 * factor, 90 * factor], rel=1e-15)
        assert table.columns["moment"].values.tolist() == [1.0, 2.0]
        assert table.lines.tolist() == [11, 12]


def test_a_file_of_opensim_is_known_by_its_header(tmp_path):
    assert "OpenSim" in read_table(saved(tmp_path, joined("\t", *STO), "motion.txt")).format


def test_windows_hold_whole_rows(reference):
    part = windowed(reference, (0.25, 0.5))
    assert len(part) == 51
    assert (part.columns["time"].values[0], part.columns["time"].values[-1]) == (0.25, 0.5)
    assert part.lines[0] == 52
    assert part.remarks == ("window from 0.25 s to 0.5 s: 51 of 201 rows",)
    assert windowed(reference, None) is reference


def errors_of(method, counts):
    """Largest errors of a resampled sinusoid given at some numbers of rows."""
    found = []
    for count in counts:
        time = np.linspace(0.0, 1.0, count + 1)
        column = reference_column(time)
        table = resampled(column, 977.0, method)
        at = table.columns["time"].values
        error = np.abs(table.columns["position"].values - np.sin(2 * np.pi * at))
        found.append(np.max(error[(at > 0.2) & (at < 0.8)]))  # away from the ends, where a spline knows less
    return found


def reference_column(time):
    made = {
        role: Column(role=role, heading=role, unit="", values=values)
        for role, values in {"time": time, "position": np.sin(2 * np.pi * time)}.items()
    }
    return RecordedTable(file="x", format="", columns=made, ignored=(), lines=np.arange(time.size) + 2)


def test_resampling_errors_are_those_stated():
    """Straight lines: h^2/8 max|x''|; a cubic spline: fourth order."""
    lines = errors_of("linear", (50, 100))
    for count, error in zip((50, 100), lines, strict=True):
        assert error == pytest.approx((2 * np.pi / count) ** 2 / 8, rel=0.03)
    coarse, fine = errors_of("cubic", (50, 100))
    assert coarse / fine == pytest.approx(16, rel=0.2)
    assert fine < 1e-3 * lines[1]


def test_means_keep_out_what_a_rate_cannot_resolve():
    """A ripple at 400 Hz under samples at 100 Hz: gone with means, an alias with single values; the area is kept."""
    time = np.linspace(0.0, 1.0, 8001)
    table = reference_column(time)
    slow = table.columns["position"].values
    rippled = reference_column(time)
    column = rippled.columns["position"]
    rippled = dataclasses.replace(
        rippled,
        columns={
            "time": rippled.columns["time"],
            "position": dataclasses.replace(column, values=slow + 0.1 * np.cos(2 * np.pi * 400 * time)),
        },
    )
    at = np.linspace(0.0, 1.0, 101)
    means, single = (resampled(rippled, 100.0, method).columns["position"].values for method in ("mean", "linear"))
    attenuated = np.sin(2 * np.pi * at) * np.sinc(
        1 / 100
    )  # a mean over a step H turns sin(w t) to sinc(w H/2) sin(w t)
    assert np.max(np.abs(means - attenuated)[1:-1]) < 1e-4
    assert np.max(np.abs(single - np.sin(2 * np.pi * at))) > 0.09


@pytest.mark.parametrize("start", [0.0, 7.5])
def test_heel_strikes_stay_marks(tmp_path, start):
    rows = (f"{start + k / 100:.2f},{k},{int(k in (20, 77))}\n" for k in range(101))
    text = "t [s],pos [mm],heel strike\n" + "".join(rows)
    table = resampled(read_table(saved(tmp_path, text)), 50.0)
    assert np.flatnonzero(table.columns["heel_strike"].values).tolist() == [10, 38]
    assert table.columns["time"].values == pytest.approx(start + np.arange(51) / 50)


def test_rate_and_method_of_a_study(tmp_path):
    path = saved(tmp_path, CSV)
    motion = Recording.read(path, sample_rate=400.0, resampling="cubic")
    assert len(motion.time) == 401
    with pytest.raises(ParameterError, match=r"resampling must be one of linear, cubic, mean, got 'spline'"):
        Recording.read(path, sample_rate=400.0, resampling="spline")


CELLS = ["1", "-2.5", "1e3", ".5", "7.", "", "x", "nan", " 3 ", "1,5", "1.000,5", "0x1", "1_0", '"4"', "+6", "1e999"]


@given(
    st.lists(st.lists(st.sampled_from(CELLS), min_size=2, max_size=4), min_size=2, max_size=6),
    st.sampled_from([",", ";", "\t", " "]),
)
@examples(150)
def test_the_quick_way_reads_what_the_careful_way_reads(tmp_path_factory, rows, mark):
    """Both read the same numbers, or both refuse."""
    text = mark.join(["t [s]", "x [mm]", "F [N]"]) if mark != " " else "t_s x_mm F_N"
    path = saved(tmp_path_factory.mktemp("rows"), "\n".join([text, *[mark.join(row) for row in rows]]))

    def read():
        try:
            return [
                column.values.tolist()
                for column in read_table(path, columns={"force": "F", "position": "x"}).columns.values()
            ]
        except InputError as problem:
            return str(problem)

    usual = read()
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(TextSheet, "_quickly", lambda *args: None)
        assert read() == usual


JUNK = [*(bytes([one]) for one in b',;\t\n"%#[( -\0\xff\xc3'), b"nan", b"endheader", b"1e400", b""]


@given(
    st.sampled_from(sorted(WRITINGS)),
    st.sampled_from([150, 400, 100_000]),
    st.lists(st.tuples(st.integers(0, 120), st.integers(0, 6), st.sampled_from(JUNK)), max_size=3),
    st.sampled_from(
        [{}, {"cycle_time": 1.1}, {"columns": {"time": "Time (s)", "position": "Pos"}}, {"window": (0.1, 0.5)}]
    ),
)
@examples(200)
def test_a_broken_file_is_read_or_refused(tmp_path_factory, name, length, edits, how):
    """Never anything else, and the message is fit to print."""
    content = WRITINGS[name]
    content = (content if isinstance(content, bytes) else content.encode())[:length]
    for place, removed, added in edits:
        content = content[:place] + added + content[place + removed :]
    path = saved(tmp_path_factory.mktemp("broken"), content)
    said = ""
    try:
        table = read_timed(path, **how)
        assert all(np.all(np.isfinite(column.values)) for column in table.columns.values())
    except InputError as problem:
        said = str(problem)
    assert len(said) < 600
    assert said.isprintable()


def test_a_minute_at_a_thousand_hertz_is_read_whole(tmp_path):
    """How long that takes is the benchmark recording_files."""
    at = np.arange(60001) / 1000
    rows = [[f"{t:.3f}", f"{100 * np.sin(t):.4f}", f"{np.cos(t):.5f}", f"{t:.2f}"] for t in at.tolist()]
    for mark, decimal in ((",", "."), (";", ",")):
        text = joined(mark, mark.join(["t [s]", "pos [mm]", "F [N]", "T [degC]"]), rows=rows).replace(".", decimal)
        table = read_table(saved(tmp_path, text))
        np.testing.assert_allclose(table.columns["position"].values, 0.1 * np.sin(at), atol=1e-7)
        assert len(table) == 60001


class FakeParquet:
    """What the reader uses of pyarrow: a file of named columns."""

    def __init__(self, columns):
        self.columns = columns
        self.schema_arrow = types.SimpleNamespace(names=list(columns))
        self.metadata = types.SimpleNamespace(num_rows=len(next(iter(columns.values()))))

    def read(self, columns, use_threads):
        assert not use_threads  # a thread at work while the interpreter ends aborts the process
        chosen = {name: self.columns[name] for name in columns}
        return types.SimpleNamespace(num_rows=self.metadata.num_rows, column=lambda name: FakeColumn(chosen[name]))


class FakeColumn(list):
    type = "string"

    def cast(self, kind):
        return types.SimpleNamespace(to_numpy=lambda: np.array([float(value) for value in self]))


LOCOHUB = {
    "subject": ["S1"] * 101,
    "phase_ipsi": list(np.linspace(0.0, 100.0, 101)),
    "knee_flexion_angle_ipsi_rad": list(np.sin(2 * np.pi * np.linspace(0, 1, 101))),
    "knee_flexion_velocity_ipsi_rad_s": list(np.cos(2 * np.pi * np.linspace(0, 1, 101))),
    "knee_flexion_moment_ipsi_Nm": list(np.cos(2 * np.pi * np.linspace(0, 1, 101))),
}


@pytest.fixture
def parquet(monkeypatch):
    """Parquet files hold the name of an entry in a dictionary here."""
    held = {}
    fake = types.SimpleNamespace(ParquetFile=lambda file: FakeParquet(held[file[4:].decode()]))
    monkeypatch.setitem(sys.modules, "pyarrow", types.SimpleNamespace(parquet=fake, BufferReader=bytes))
    monkeypatch.setitem(sys.modules, "pyarrow.parquet", fake)
    return held


def test_locohub_columns(tmp_path, parquet):
    parquet["gait"] = LOCOHUB
    table = read_timed(saved(tmp_path, b"PAR1gait", "gait.parquet"), cycle_time=1.2, flip=["moment"])
    assert list(table.columns) == ["time", "phase", "angle", "angular_speed", "moment"]
    assert table.format == "Parquet"
    assert table.columns["time"].values == pytest.approx(np.linspace(0, 1.2, 101))
    assert table.columns["moment"].values.tolist() == [-value for value in LOCOHUB["knee_flexion_moment_ipsi_Nm"]]
    assert table.ignored == ("subject",)


def test_faults_in_parquet_files(tmp_path, parquet):
    path = saved(tmp_path, b"PAR1gait", "gait.parquet")
    for name, values, said in (
        ("knee_flexion_angle_ipsi_rad", ["x"] * 101, r"row 1, column 'knee_flexion_angle_ipsi_rad': must hold numbers"),
        (
            "phase_ipsi",
            [*range(50), float("nan"), *range(51, 101)],
            r"row 51, column 'phase_ipsi': must be a finite number",
        ),
        (
            "hip_flexion_angle_ipsi_rad",
            [0.0] * 101,
            r"schema, columns .*: could each be the angle; choose in the study",
        ),
    ):
        parquet["gait"] = {**LOCOHUB, name: values}
        with pytest.raises(InputError, match=said):
            read_timed(path, cycle_time=1.2)


def test_parquet_needs_pyarrow(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(
        InputError, match=r"a Parquet file needs pyarrow; install it with: pip install 'infinivar\[parquet\]'"
    ):
        read_table(saved(tmp_path, b"PAR1...", "gait.parquet"))


def test_a_real_parquet_file(tmp_path):
    pyarrow = pytest.importorskip("pyarrow")
    parquet = importlib.import_module("pyarrow.parquet")
    parquet.write_table(pyarrow.table(LOCOHUB), tmp_path / "gait.parquet")
    table = read_timed(tmp_path / "gait.parquet", cycle_time=1.2)
    assert table.columns["angle"].values.tolist() == LOCOHUB["knee_flexion_angle_ipsi_rad"]
    (tmp_path / "cut.parquet").write_bytes((tmp_path / "gait.parquet").read_bytes()[:-20])
    with pytest.raises(InputError, match="is not a whole Parquet file"):
        read_table(tmp_path / "cut.parquet")


@pytest.mark.parametrize(
    ("kind", "text", "how"),
    [
        (
            iv.motion.Waypoints,
            "Zeit;Pos (mm)\n0;0\n0,05;2,5\n0,1;0\n",
            {"columns": {"time": "Zeit [s]", "position": "Pos"}},
        ),
        (iv.motion.RecordedForce, "# t [ms] Fz [N]\n0 1\n50 2\n100 3\n", {"flip": ["force"]}),
        (iv.motion.Waypoints, "Angle (deg)\n0\n90\n0\n", {"cycle_time": 0.1}),
    ],
)
def test_scenarios_read_the_same_files(tmp_path, kind, text, how):
    made = kind.read(saved(tmp_path, text), **how)
    assert made.time.tolist() == [0.0, 0.05, 0.1]
    if kind is iv.motion.RecordedForce:
        assert made.force.tolist() == [-1.0, -2.0, -3.0]
    else:
        assert made.position[1] == pytest.approx(np.pi / 2 if made.rotary else 2.5e-3, rel=1e-15)
    assert made.axis is (ROTARY if made.rotary else LINEAR)


def test_bare_names_of_a_scenario_mean_si_and_others_do_not(tmp_path):
    assert iv.motion.Waypoints.read(saved(tmp_path, "time,position\n0,0\n1,2\n")).position.tolist() == [0.0, 2.0]
    with pytest.raises(InputError, match="line 1, column 'pos': must state its unit"):
        iv.motion.Waypoints.read(saved(tmp_path, "time,pos\n0,0\n1,2\n"))


def test_a_table_is_frozen_and_compares(reference, tmp_path):
    assert reference == read_table(saved(tmp_path, CSV, "reference.csv"))
    assert reference != read_table(saved(tmp_path, CSV.replace("-1.0", "-1.5"), "reference.csv"))
    with pytest.raises(ValueError, match="read-only"):
        reference.columns["time"].values[0] = 1.0
    with pytest.raises(TypeError, match="frozen"):
        reference.columns["force"] = reference.columns["position"]


def strides(count, points=51):
    """Strides of a phase from 0 to 100 %, both included, one below the other, each a little larger."""
    phase = np.linspace(0.0, 1.0, points)
    rows = [
        [f"{100 * p:.1f}", f"{(1 + 0.01 * k) * np.sin(2 * np.pi * p):.9f}"]
        for k in range(count)
        for p in phase.tolist()
    ]
    return joined(",", "phase (%),angle (rad)", rows=rows)


def test_strides_of_a_phase_follow_one_another(tmp_path):
    path = saved(tmp_path, strides(4))
    table = read_timed(path, cycle_time=1.2)
    assert len(table) == 4 * 50 + 1
    assert table.columns["time"].values == pytest.approx(np.arange(201) * 1.2 / 50, abs=1e-12)
    assert table.remarks == ("phase times a cycle of 1.2 s, 4 strides",)
    with pytest.raises(
        InputError, match=r"line 53, column 'phase \(%\)': starts another stride; average the strides with"
    ):
        Recording.read(path, cycle_time=1.2)
    mean = Recording.read(path, cycle_time=1.2, strides="average")
    assert mean.period == pytest.approx(1.2, rel=1e-12)
    assert np.max(mean.derivatives(np.linspace(0, 1.2, 500), 0)[0]) == pytest.approx(1.015, rel=2e-3)
    slower = resampled(table, 25.0)
    assert np.all((slower.columns["phase"].values >= 0.0) & (slower.columns["phase"].values <= 1.0))
    assert np.count_nonzero(np.diff(slower.columns["phase"].values) < -0.5) == 4
