"""Files as users have them: digitised phases, open cycles, changed shapes, two files, other spellings, empty cells."""

import math

import numpy as np
import pytest

import infinivar as iv
from infinivar import units
from internals import read_dynamometer, virtual_rig
from internals import save_calibration_data as save_data

SHARE = np.linspace(0.0, 1.0, 101)
TURN = 2.0 * np.pi * SHARE


def written(path, headings, *columns):
    rows = "".join(",".join(f"{value:.6g}" for value in row) + "\n" for row in zip(*columns, strict=True))
    path.write_text(",".join(headings) + "\n" + rows)
    return str(path)


def phased(path, phase, moment=3.0):
    return written(path, ("phase [%]", "angle [deg]", "moment [Nm]"), phase, 20.0 * np.sin(TURN), moment * np.cos(TURN))


def test_a_digitised_phase_is_clipped_and_said(tmp_path):
    table = iv.read_table(phased(tmp_path / "a.csv", -0.15 + 100.45 * SHARE))
    phase = table.columns["phase"].values
    assert (phase[0], phase[-1]) == (0.0, 1.0)
    assert phase[1:-1] == pytest.approx(-0.0015 + 1.0045 * SHARE[1:-1], abs=1e-6)
    assert "phase beyond the cycle by up to 0.3 % clipped, as digitising explains: lines 2, 102" in table.remarks
    assert iv.motion.Recording.read(str(tmp_path / "a.csv"), cycle_time=1.1).period == 1.1


@pytest.mark.parametrize(
    ("before", "after", "kept"),
    [((-0.4, -0.2), (100.2, 100.4), 101), ((-0.4, -0.2, 0.0), (100.0, 100.3), 101), ((-0.2,), (), 100)],
)
def test_of_several_rows_beyond_the_cycle_one_stays(tmp_path, before, after, kept):
    """A curve read off a page has a few points beyond its axis."""
    phases = [*before, *np.linspace(1.0, 99.0, 99), *after]
    rows = [f"{phase},{10.0 * math.sin(2.0 * math.pi * phase / 100.0)}" for phase in phases]
    file = tmp_path / "curve.csv"
    file.write_text("\n".join(["phase [%],angle [deg]", *rows]), "utf-8")
    table = iv.read_table(file)
    phase = table.columns["phase"].values
    assert len(table) == kept
    assert phase[0] == 0.0
    assert np.all(np.diff(phase) > 0.0)
    assert any("as digitising explains: lines 2" in remark or "line 2" in remark for remark in table.remarks)


def test_a_row_that_is_left_out_is_no_comment(tmp_path):
    rows = [f"{0.01 * row},{math.sin(row)}" for row in range(50)]
    rows[10] = "0.1,"
    file = tmp_path / "log.csv"
    file.write_text("\n".join(["time [s],position [mm]", *rows[:20], "# a pause", *rows[20:]]), "utf-8")
    table = iv.read_table(file, leave_out=True)
    assert [remark for remark in table.remarks if "comment" in remark] == [
        "1 comment between the rows not read: line 22"
    ]


def test_strides_of_a_digitised_phase_are_clipped(tmp_path):
    phase = -0.15 + 100.45 * SHARE
    file = written(tmp_path / "a.csv", ("phase [%]", "angle [deg]"), np.tile(phase, 3), np.tile(20.0 * np.sin(TURN), 3))
    assert len(iv.motion.Recording.read(file, cycle_time=1.1, strides="average").averaged) == 3


@pytest.mark.parametrize(
    ("phase", "said"),
    [
        (101.0 * SHARE, r"line 102, column 'phase \[%\]': must be within 0 and 100 % of the cycle, got 101"),
        (np.append(100.2 * SHARE[:-1], 100.4) + (SHARE > 0.985) * 0.8, "must be within 0 and 100 % of the cycle"),
    ],
)
def test_a_phase_that_digitising_does_not_explain_is_refused(tmp_path, phase, said):
    with pytest.raises(iv.InputError, match=said):
        iv.read_table(phased(tmp_path / "a.csv", phase))


OPEN = ("time [s]", "position [mm]")


def test_an_open_cycle_states_the_ways_out_and_each_of_them_works(tmp_path):
    drift = 0.12 * 44.0 * SHARE
    position, speed = 20.0 * np.sin(TURN) + drift, 40.0 * np.pi * np.cos(TURN)
    file = written(tmp_path / "a.csv", (*OPEN, "velocity [mm/s]"), SHARE, position, speed)
    with pytest.raises(iv.InputError) as refused:
        iv.motion.Recording.read(file)
    for way in ("with window", "speed = ...", 'closure = "spread"', "closed = false"):
        assert way in str(refused.value)
    spread = iv.motion.Recording.read(file, closure="spread")
    assert any("removed evenly over the cycle" in one for one in spread.warnings)
    time = np.linspace(0.0, 1.0, 50)
    assert spread.derivatives(time, 0)[0] == pytest.approx(0.02 * np.sin(2.0 * np.pi * time), abs=2e-4)
    read = iv.motion.Recording.read(file, columns={"time": "time", "speed": "velocity"})
    assert read.derivatives(time, 1)[1] == pytest.approx(0.04 * np.pi * np.cos(2.0 * np.pi * time), abs=2e-3)
    assert not iv.motion.Recording.read(file, closed=False).repeats
    with pytest.raises(iv.ParameterError, match="closure does not apply with closed = false"):
        iv.motion.Recording.read(file, closed=False, closure="spread")


BELOW = """
[requirement]
force = "20 N"
speed = "0.2 m/s"
[drives.one]
base = "faulring2006.cobotic"
[duty.d]
shape = "sinusoid"
distance = "20 mm"
frequency = "1 Hz"
force = "3 N"
[scenarios.s]
duration = "1 s"
motion = { shape = "reach", distance = "20 mm", time = "0.5 s" }
force = { shape = "sinusoid", size = "2 N", frequency = "2 Hz" }
"""


def test_another_shape_drops_inherited_keys_that_do_not_apply_to_it(tmp_path):
    (tmp_path / "below.toml").write_text(BELOW)
    above = tmp_path / "above.toml"
    above.write_text(
        'extends = "below.toml"\n[duty.d]\nshape = "reaches"\ntime = "0.5 s"\npause = "0.2 s"\n'
        '[scenarios.s]\nmotion = { shape = "cruise", speed = "0.1 m/s" }\nforce = { shape = "constant" }\n'
    )
    study = iv.load_study(above)
    assert study.duty["d"].motion == iv.motion.Reaches(distance=0.02, time=0.5, pause=0.2)
    assert study.duty["d"].force == 3.0
    assert study.scenarios["s"].motion == iv.motion.Cruise(speed=0.1)
    assert study.scenarios["s"].force == iv.motion.ConstantForce(size=2.0)
    above.write_text('extends = "below.toml"\n[duty.d]\nshape = "reaches"\ntime = "0.5 s"\nfrequency = "2 Hz"\n')
    with pytest.raises(iv.InputError, match=r"duty\.d\.frequency does not apply with shape = 'reaches'"):
        iv.load_study(above)


def test_a_shipped_base_takes_another_shape(tmp_path):
    raw = {"requirement": {"force": "20 N", "speed": "0.2 m/s"}, "drives": {"one": {"base": "faulring2006.cobotic"}}}
    cycle = {"base": "faulring2006.shake", "shape": "reaches", "time": "0.5 s", "distance": "10 mm"}
    study = iv.Study.from_dict({**raw, "duty": {"d": cycle}}, name="based")
    assert isinstance(study.duty["d"].motion, iv.motion.Reaches)


@pytest.mark.parametrize(
    ("written_as", "si_unit", "factor"),
    [
        ("Nm", "N m", 1.0),
        ("mNm", "N m", 1e-3),
        ("N-m", "N m", 1.0),
        ("mNm/A", "N m/A", 1e-3),
        ("gcm2", "kg m^2", 1e-7),
        ("g·cm²", "kg m^2", 1e-7),
        ("kgm^2", "kg m^2", 1.0),
        ("Ohm", "ohm", 1.0),
        ("mOhm", "ohm", 1e-3),
        ("mNms", "N m s", 1e-3),
        ("N m s", "N m s", 1.0),
        ("degrees", "rad", np.pi / 180.0),
    ],
)
def test_units_as_files_spell_them(written_as, si_unit, factor):
    assert units.parse(f"1 {units.standard_unit(written_as)}", si_unit) == pytest.approx(factor, rel=1e-12)
    assert units.standard_unit(units.standard_unit(written_as)) == units.standard_unit(written_as)


def test_a_set_with_decimal_commas_usual_units_and_other_headings(tmp_path, infinivar):
    """The same part as with points and the units of studies."""
    headings = "key;voltage [V];torque_constant [mNm/A];R [Ohm];rotor_inertia [gcm2];no_load_current [mA];continuous_torque [mNm]"
    (tmp_path / "own.csv").write_text(f"{headings}\na;24;25,6;2,14;14,9;53;26,3\nb;24;25,6;;14,9;53;26,3\n")
    plain = "key,voltage [V],torque_constant [mN m/A],resistance [ohm],rotor_inertia [g cm^2],no_load_current [mA]"
    (tmp_path / "plain.csv").write_text(f"{plain},continuous_torque [mN m]\na,24,25.6,2.14,14.9,53,26.3\n")
    own = iv.import_parts(tmp_path / "own.csv", columns={"resistance": "R"})
    assert own.parts.motors.part("a") == iv.import_parts(tmp_path / "plain.csv").parts.motors.part("a")
    assert own.incomplete == {"motors": {"resistance": 1}}
    with pytest.raises(iv.InputError, match=r"own.csv: line 1: has no column 'Rx'; it has 'key', 'voltage \[V\]'"):
        iv.import_parts(tmp_path / "own.csv", columns={"resistance": "Rx"})
    done = infinivar("catalogue", "import", "own", "own.csv", "--columns", "resistance=R [Ohm]", "--to", "sets")
    assert done.code == 0
    assert "  1 motor does not state resistance: it cannot be used in a drive: b" in done.out.splitlines()


def test_a_comma_and_a_point_in_one_cell_are_refused(tmp_path):
    (tmp_path / "own.csv").write_text("key;ratio;efficiency [%]\na;57;88,5\nb;1.057,5;88\n")
    found = iv.import_parts(tmp_path / "own.csv")
    assert found.parts.gearheads.part_keys == ("a",)
    assert found.faults[0].reason == (
        "column 'ratio': must have a decimal comma and no other mark, as cells above, got '1.057,5'"
    )


RUNS = "hand_controller"


def test_calibrate_reads_files_as_motion_does(tmp_path):
    """Decimal commas, another heading with its unit, and a run whose current is not stated."""
    study = iv.load_study(RUNS)
    measured = study.drives["cobotic"]
    protocol = virtual_rig.protocol(measured, study.rig, ratios=(20.0, 2.0))
    save_data(virtual_rig.experiment(measured, study.rig, protocol, simulated=False).data, tmp_path / "runs.csv")
    rows = [line.split(",") for line in (tmp_path / "runs.csv").read_text().splitlines()]
    place = rows[0].index("motor_current [A]")
    kept = [list(row) for number, row in enumerate(rows) if number != 5]
    rows[0][rows[0].index("mass [kg]")] = "m"
    rows[5][place] = ""
    own = "\n".join(";".join(cell.replace(".", ",") for cell in row) for row in rows)
    (tmp_path / "own.csv").write_text(own + "\n")
    (tmp_path / "kept.csv").write_text("\n".join(map(",".join, kept)) + "\n")
    found = iv.calibrate(study, "cobotic", tmp_path / "own.csv", columns={"mass": "m [kg]"}, creep_laws=["linear"])
    same = iv.calibrate(study, "cobotic", tmp_path / "kept.csv", creep_laws=["linear"])
    assert found.fit.values == same.fit.values
    assert found.data.empty == {6: "motor_current: empty cell"}
    with pytest.raises(iv.InputError, match=r"own.csv: line 1, column 'm': must state its unit"):
        iv.calibrate(study, "cobotic", tmp_path / "own.csv", columns={"mass": "m"})
    with pytest.raises(iv.InputError, match=r"unknown column 'mas' \(did you mean 'mass'\?\)"):
        iv.calibrate(study, "cobotic", tmp_path / "own.csv", columns={"mas": "m"})


def test_points_of_a_dynamometer_have_usual_units_and_gaps(tmp_path):
    (tmp_path / "bench.csv").write_text(
        "motor_speed [rpm];motor_torque [mNm];current [mA]\n1000;10,5;500\n2000;;600\n3000;11,5;700\n"
    )
    read = read_dynamometer(tmp_path / "bench.csv", 1.0)
    assert read.torque == pytest.approx([0.0105, 0.0115])
    assert read.empty == {3: "motor_torque: empty cell"}


@pytest.mark.parametrize("encoding", ["latin-1", "utf-16"])
def test_parts_in_other_encodings(tmp_path, encoding):
    (tmp_path / "own.csv").write_bytes("key;ratio;efficiency [%];source\na;57;88;Größe\n".encode(encoding))
    found = iv.import_parts(tmp_path / "own.csv")
    assert found.parts.gearheads.part_keys == ("a",)
    assert any(
        f"read as {encoding.title() if encoding == 'latin-1' else 'UTF-16'}" in one.text for one in found.remarks
    )


def test_an_open_cycle_of_a_recording_is_shown_with_the_ways_out(tmp_path):
    share = np.linspace(0.0, 1.0, 41)
    rows = np.column_stack([2.0 * share, np.cos(2.0 * np.pi * share) + 0.25 * share])
    path = str(tmp_path / "open.csv")
    np.savetxt(path, rows, delimiter=",", header="time [s],angle [rad]", comments="", fmt="%.6g")
    found = iv.inspect_motion(path)
    assert not found.closed
    (said,) = [one for one in found.warnings if "shown as a run" in one]
    assert "0.25 rad from its start, 12 % of the range" in said
    assert all(way in said for way in ("window", 'closure = "spread"', "closed = false", "angular_speed = ..."))
    assert not any("shown as a run" in one for one in iv.inspect_motion(path, closed=False).warnings)


def test_a_row_with_an_empty_cell_is_left_out_by_name(tmp_path):
    lines = ["time [s],angle [rad]", *(f"{0.02 * row:.6g},{np.cos(np.pi * 0.02 * row):.6g}" for row in range(101))]
    lines[7] = lines[7].partition(",")[0] + ","
    (tmp_path / "gap.csv").write_text("\n".join(lines) + "\n")
    found = iv.motion.Recording.read(str(tmp_path / "gap.csv"))
    assert len(found.time) == 100
    assert any("gap.csv: line 8 left out: angle: empty cell" in one for one in found.warnings)
    bare = ["angle [rad],moment [Nm]", *(line.partition(",")[2] + ",1" for line in lines[1:])]
    (tmp_path / "gap.csv").write_text("\n".join(bare) + "\n")
    with pytest.raises(iv.InputError, match=r"line 8, column 'angle .rad.': must be a finite number, got ''"):
        iv.motion.Recording.read(str(tmp_path / "gap.csv"), cycle_time=2.0)
