"""Recordings with faults: one clear message with file, line and column, exit code 2, and nothing written."""

import numpy as np
import pytest

from commands import run
from infinivar.motion.files import reading, sheet

STUDY = """
[requirement]
base = "faulring2006"
[drives.cobotic]
base = "faulring2006.cobotic"
[duty.recorded]
shape = "file"
file = "{file}"
{more}
"""
TIME = np.linspace(0.0, 1.0, 41)
ROWS = [f"{t:.3f},{50.0 * np.sin(2 * np.pi * t):.4f},{-4.0:.1f}" for t in TIME]
CSV = "\n".join(["time [s],Pos (mm),Fz (N)", *ROWS]) + "\n"
STO = "\n".join(
    ["run", "version=1", "nRows=41", "nColumns=3", "inDegrees=yes", "endheader", "time\tposition_mm\tforce_N"]
    + [row.replace(",", "\t") for row in ROWS]
)
GAIT = "\n".join(
    ["phase (%),Ankle angle (deg),Ankle torque (N-m/kg)"]
    + [f"{100 * t:.1f},{10 * np.sin(2 * np.pi * t):.4f},{np.cos(2 * np.pi * t):.4f}" for t in TIME]
)
JOINT = 'cycle_time = "1.1 s"\nbody_mass = "75 kg"'


def at(line, text, whole=CSV):
    """The file with another line."""
    lines = whole.splitlines()
    lines[line - 1] = text
    return "\n".join(lines) + "\n"


FAULTS = {
    # Cells
    "text in a cell": (at(5, "0.075,abc,-4.0"), "", "line 5, column 'Pos (mm)': must be a finite number, got 'abc'"),
    "nan": (at(6, "0.1,nan,-4.0"), "", "line 6, column 'Pos (mm)': must be a finite number, got 'nan'"),
    "inf": (at(6, "0.1,1.0,-inf"), "", "line 6, column 'Fz (N)': must be a finite number, got '-inf'"),
    "overflow": (at(6, "0.1,1e999,-4.0"), "", "line 6, column 'Pos (mm)': must be a finite number, got '1e999'"),
    "too large": (at(6, "0.1,1e300,-4.0"), "", "line 6, column 'Pos (mm)': must be within 1e+20 in SI units"),
    "underscore": (at(6, "0.1,1_000,-4.0"), "", "line 6, column 'Pos (mm)': must be a finite number, got '1_000'"),
    "number and unit": (at(6, "0.1,1 mm,-4.0"), "", "line 6, column 'Pos (mm)': must be a finite number, got '1 mm'"),
    "short row": (
        at(7, "0.125,1.0"),
        "",
        "line 7, column 'Fz (N)': has no cell: line 1 has 3 headings, this line 2 cells",
    ),
    "long row": (
        at(7, "0.125,1.0,-4.0,9"),
        "",
        "line 7, column 4: has no heading: line 1 has 3 headings, this line 4 cells",
    ),
    "cut off at the end": (CSV[:-9], "", "line 42, column "),
    "decimal commas between commas": (
        at(3, "0,025,7,8217,-4,0"),
        "",
        "line 3, column 4: has no heading: line 1 has 3 headings, this line 6 cells; decimal commas need",
    ),
    "decimal comma in quotes": (
        at(3, '0.025,"7,8217",-4.0'),
        "",
        "line 3, column 'Pos (mm)': must be a number with a point",
    ),
    "point among decimal commas": (
        at(5, "0.075;22.7;-4,0", CSV.replace(",", ";").replace(".", ",")),
        "",
        "line 5, column 'time [s]': must have a decimal comma and no other mark",
    ),
    "comma among decimal points": (
        at(5, "0.075;22,7;-4.0", CSV.replace(",", ";")),
        "",
        "line 5, column 'Pos (mm)': must be a number with a point",
    ),
    "thousands": (
        at(5, "0,075;1.022,7;-4,0", CSV.replace(",", ";").replace(".", ",")),
        "",
        "line 5, column 'Pos (mm)': must have a decimal comma and no other mark, as cells above, got '1.022,7'",
    ),
    "unclosed quote": (at(5, '0.075,"22.7,-4.0'), "", "line 5, column 'Pos (mm)': has a quote that is not closed"),
    "unclosed quote in a heading": (
        at(1, 'time [s],"Pos (mm),Fz (N)'),
        "",
        "line 1, column 2: has a quote that is not closed",
    ),
    # Headings and units
    "unit missing": (at(1, "time [s],Pos,Fz (N)"), "", "line 1, column 'Pos': must state its unit, such as 'Pos [mm]'"),
    "unit of time missing": (
        at(1, "t,Pos (mm),Fz (N)"),
        "",
        "line 1, column 't': must state its unit, such as 't [s]'",
    ),
    "unknown unit": (
        at(1, "time [s],Pos (smoot),Fz (N)"),
        "",
        "line 1, column 'Pos (smoot)': has an unknown unit 'smoot'",
    ),
    "wrong dimension": (
        at(1, "time [s],Pos (kg),Fz (N)"),
        "",
        "line 1, column 'Pos (kg)': has the unit 'kg' where m is needed",
    ),
    "unit of a moment that is one of a force": (
        GAIT.replace("torque (N-m/kg)", "torque (N)"),
        'cycle_time = "1.1 s"',
        "line 1, column 'Ankle torque (N)': has the unit 'N' where N m is needed",
    ),
    "row of units with a fault": (
        at(1, "time,Pos,Fz\ns,V,N"),
        "",
        "line 2, column 'Pos': has the unit 'V' where m is needed",
    ),
    "row of units that contradicts": (
        at(1, "time [s],Pos (mm),Fz (N)\ns,m,N"),
        "",
        "line 2, column 'Pos (mm)': must be a number, or repeat the unit 'mm'",
    ),
    "no headings": (CSV.partition("\n")[2], "", "line 1, column 1: must name the columns, got a number"),
    "no position": (at(1, "time [s],u [mm],Fz (N)"), "", "line 1: must name a column of position or speed"),
    "nothing known": (at(1, "a,b,c"), "", "line 1: must name columns of a motion"),
    "no time": (at(1, "u [s],Pos (mm),Fz (N)"), "", "line 1: must name a column of time, found 'Pos (mm)', 'Fz (N)'"),
    "two positions": (
        at(1, "time [s],Pos A (mm),Pos B (mm)"),
        "",
        "line 1, columns 'Pos A (mm)', 'Pos B (mm)': could each be the position; choose in the study with one line for all "
        'columns, such as columns = { time = "time [s]", position = "Pos A (mm)" }',
    ),
    "two angles and heel strikes": (
        at(1, "time [s],Knee angle (deg),Hip angle (deg),heel strike").replace(",-4.0", ",-4.0,0"),
        "",
        'such as columns = { time = "time [s]", angle = "Knee angle (deg)", heel_strike = "heel strike" }',
    ),
    "heading twice": (
        at(1, "time [s],Pos (mm),Pos (mm)"),
        "",
        "line 1, columns 'Pos (mm)', 'Pos (mm)': could each be the position",
    ),
    "force about a joint": (
        at(1, "time [s],Angle (deg),Fz (N)"),
        "",
        "line 1, column 'Fz (N)': is a force, but 'Angle (deg)' is about",
    ),
    "preamble without headings": (
        "Logger 7\nRate: 1 kHz\n" + CSV.partition("\n")[2],
        "",
        "line 2: must name columns of a motion",
    ),
    # Times
    "time goes back": (
        at(8, "0.1,1.0,-4.0"),
        "",
        "line 8, column 'time [s]': must have a later time than the row above, got 0.1 s",
    ),
    "time stands": (
        "\n".join(["time [s],Pos (mm)", *[f"2.5,{k}" for k in range(9)]]),
        "",
        "line 3, column 'time [s]': must have a later time than the row above, got 2.5 s after 2.5 s",
    ),
    # The whole file
    "empty": ("", "", "line 1: must name the columns, but the file is empty"),
    "blank": (" \n\n \n", "", "line 1: must name the columns, but the file is empty"),
    "comments only": ("# nothing\n", "", "line 1: must name the columns; the file has comments only"),
    "header only": (
        CSV.partition("\n")[0],
        "",
        "line 1, column 'time [s]': must have at least two rows of numbers below, got 0",
    ),
    "one row": (
        "\n".join(CSV.splitlines()[:2]),
        "",
        "line 1, column 'time [s]': must have at least two rows of numbers below, got 1",
    ),
    "few rows": ("\n".join(CSV.splitlines()[:6]), "", "line 6: must have at least 8 rows of numbers, got 5"),
    "workbook": (
        b"PK\x03\x04\x14\x00\x06\x00",
        "",
        "line 1, character 1: is not text; the file seems to be an Excel workbook",
    ),
    "binary": (b"\x93NUMPY\x01\x00v\x00\x81\x02", "", "line 1, character 1: is neither UTF-8 nor Latin-1"),
    "null bytes": (at(4, "0.05,\0\0,-4.0"), "", "line 4, character 6: is '\\x00', which is no text"),
    "UTF-16 without a mark": (
        CSV.encode("utf-16-le"),
        "",
        "line 1, character 2: is '\\x00', which is no text; the file may be binary; UTF-16",
    ),
    "half a UTF-16 file": (
        b"\xff\xfe" + CSV.encode("utf-16-le")[:-1],
        "",
        "is not UTF-16, which its byte-order mark announces",
    ),
    "Windows-1252": (
        CSV.replace("Pos (mm)", "Pos \u2013 x (mm)").encode("cp1252"),
        "",
        "line 1, character 14: is neither UTF-8 nor",
    ),
    # What the study says of the file
    "unknown column": (
        CSV,
        'columns = { time = "time", position = "Poss (mm)" }',
        "line 1: has no column 'Poss (mm)' (did you mean 'Pos (mm)'?)",
    ),
    "column of two roles": (
        CSV,
        'columns = { time = "time", position = "Pos", speed = "Pos" }',
        "line 1, column 'Pos (mm)': cannot be both",
    ),
    "mapped heading twice": (
        at(1, "time [s],x (mm),x (mm)"),
        'columns = { time = "time", position = "x" }',
        "line 1, column 'x (mm)': stands there 2 times",
    ),
    "two units": (
        CSV,
        'columns = { time = "time", position = "Pos [m]" }',
        "line 1, column 'Pos (mm)': states the unit 'mm', but columns states 'm'",
    ),
    "mapped without unit": (
        at(1, "t,x,F"),
        'columns = { time = "t [s]", position = "x" }',
        "line 1, column 'x': must state its unit, such as 'x [mm]'",
    ),
    "mapped with a wrong unit": (
        at(1, "t,x,F"),
        'columns = { time = "t [s]", position = "x [deg]" }',
        "line 1, column 'x': has the unit 'deg', which names an angle, where a length is needed",
    ),
    "two axes": (
        at(1, "t,x,M"),
        'columns = { time = "t [s]", position = "x [mm]", moment = "M [N m]" }',
        "line 1, columns 'x', 'M': are along a line and about a joint",
    ),
    "no such role": (
        CSV,
        'columns = { time = "time", postion = "Pos" }',
        "duty.recorded.columns has an unknown entry 'postion' (did you mean 'position'?)",
    ),
    "columns as text": (
        CSV,
        'columns = "Pos"',
        'duty.recorded.columns = "Pos" must be a table of texts, such as { time = "..." }',
    ),
    "column as a table": (
        CSV,
        'columns = { time = { heading = "t" } }',
        "duty.recorded.columns entry time must be text",
    ),
    "column as a number": (CSV, "columns = { time = 1 }", "duty.recorded.columns entry time must be text"),
    "no columns": (CSV, "columns = {}", "duty.recorded.columns must be a table of texts by time, phase, "),
    "flip of times": (
        CSV,
        'flip = ["time"]',
        "duty.recorded.flip = ['time'] must hold words of position, speed, force",
    ),
    "flip as text": (
        CSV,
        'flip = "force"',
        "duty.recorded.flip = \"force\" must be a list of words, such as ['position']",
    ),
    "flip twice": (CSV, 'flip = ["force", "force"]', "must be different words, got 'force' twice"),
    "one end of a window": (CSV, 'window = ["1 s"]', "duty.recorded.window must be a start and a later end, got 1 s"),
    "method without a rate": (
        CSV,
        'resampling = "cubic"',
        "resampling = 'cubic' does not apply without sample_rate",
    ),
    "body mass of nothing": (GAIT, JOINT.replace("75", "0"), "duty.recorded.body_mass"),
    "other joint": (
        at(1, "time [s],Knee angle (deg),Hip moment (Nm)"),
        "",
        "line 1, columns 'Knee angle (deg)', 'Hip moment (Nm)': are of different joints or sides; choose in the study what "
        'belongs together: columns = { time = "time [s]", angle = "Knee angle (deg)" } for the first alone, or columns = '
        '{ time = "time [s]", angle = "Knee angle (deg)", moment = "Hip moment (Nm)" } to read both',
    ),
    "other side": (
        at(1, "time [s],knee_angle_r_deg,knee_moment_l_Nm"),
        "",
        "columns 'knee_angle_r_deg', 'knee_moment_l_Nm': are of different joints or sides",
    ),
    "two angles and a moment": (
        at(1, "time [s],Knee angle (deg),Hip angle (deg),Hip moment (Nm),Knee moment (Nm)").replace(
            ",-4.0", ",1,-4.0,-4.0"
        ),
        "",
        "line 1, columns 'Knee angle (deg)', 'Hip angle (deg)': could each be the angle; choose in the study with one line for "
        'all columns, such as columns = { time = "time [s]", angle = "Knee angle (deg)", moment = "Knee moment (Nm)" }',
    ),
    "position of an unknown name": (
        at(1, "t [s],F [N],x [mm]"),
        "",
        "line 1: must name a column of position or speed, or of angle or angular speed; found 't [s]' as time, 'F [N]' as "
        "force; other headings: 'x [mm]'; if one of them is the motion, name it with columns, such as columns = "
        '{ time = "t [s]", force = "F [N]", position = "x [mm]" }',
    ),
    "unknown method": (
        CSV,
        'resampling = "spline"',
        'duty.recorded.resampling = "spline" must be one of linear, cubic, mean',
    ),
    "nothing to flip": (
        at(1, "time [s],Pos (mm),x"),
        'flip = ["force"]',
        "line 1: has no column of force to flip; found time, position",
    ),
    "window outside": (
        CSV,
        'window = ["0.5 s", "2 s"]',
        "line 42, column 'time [s]': the recording ends at 1 s, so the end of window, 2 s, is outside",
    ),
    "window reversed": (
        CSV,
        'window = ["0.5 s", "0.2 s"]',
        "duty.recorded.window must be a start and a later end, got 0.5 s and 0.2 s",
    ),
    "window between rows": (
        CSV,
        'window = ["0.501 s", "0.502 s"]',
        "line 23, column 'time [s]': the window from 0.501 s to 0.502 s holds 0 rows",
    ),
    "cycle time with times": (
        CSV,
        'cycle_time = "1 s"',
        "line 1, column 'time [s]': states times, so cycle_time does not apply",
    ),
    "body mass without per kg": (
        CSV,
        'body_mass = "75 kg"',
        "line 1, column 'Fz (N)': is not per kilogram; body_mass does not apply",
    ),
    "per kg without body mass": (
        GAIT,
        'cycle_time = "1.1 s"',
        "line 1, column 'Ankle torque (N-m/kg)': is per kilogram of body mass; state that mass",
    ),
    "phase without cycle time": (
        GAIT,
        'body_mass = "75 kg"',
        "line 1, column 'phase (%)': is a share of the cycle; state the time",
    ),
    "phase beyond the cycle": (
        at(42, "102.5,1,1", GAIT),
        JOINT,
        "line 42, column 'phase (%)': must be within 0 and 100 % of the cycle, got 102.5 %",
    ),
    "phase goes back": (
        at(9, "12.0,1,1", GAIT),
        JOINT,
        "line 9, column 'phase (%)': must have a later phase than the row above, or start",
    ),
    "distance about a joint": (
        GAIT,
        JOINT + '\nresolution = "1 mm"',
        "duty.recorded.resolution is a distance, but the motion is about a joint",
    ),
    "rate beyond reason": (CSV, 'sample_rate = "10 MHz"', "duty.recorded.sample_rate must be <= 2000000 Hz for 1 s"),
}

OPENSIM = {
    "wrong count of rows": (
        STO.replace("nRows=41", "nRows=42"),
        "",
        "line 3, nRows: states '42' rows, but the file has 41",
    ),
    "wrong count of columns": (
        STO.replace("nColumns=3", "nColumns=4"),
        "",
        "line 4, nColumns: states '4' columns, but the file has 3",
    ),
    "header without end": (STO.replace("endheader\n", ""), "", "column 1: must be 'endheader' here or above"),
    "nothing below the header": (
        STO.partition("time\t")[0],
        "",
        "line 7, column 1: must name the columns below 'endheader'",
    ),
    "degrees or not": (
        STO.replace("inDegrees=yes", "inDegrees=maybe"),
        "",
        "line 5, inDegrees: must be yes or no, got 'maybe'",
    ),
    "angle of unstated unit": (
        STO.replace("inDegrees=yes\n", "").replace("position_mm", "knee_angle_r").replace("force_N", "x"),
        "",
        "line 6, column 'knee_angle_r': must state its unit, such as 'knee_angle_r [deg]'",
    ),
    "vectors": (STO.replace("version=1", "DataType=Vec3"), "", "line 2, DataType: must be double"),
}


@pytest.mark.parametrize("name", [*FAULTS, *OPENSIM])
def test_one_clear_message_and_nothing_written(tmp_path, name):
    content, more, said = {**FAULTS, **OPENSIM}[name]
    file = "motion.sto" if name in OPENSIM else "motion.csv"
    (tmp_path / file).write_bytes(content if isinstance(content, bytes) else content.encode())
    (tmp_path / "study.toml").write_text(STUDY.format(file=file, more=more), "utf-8")
    outcome = run("compare", "study.toml", "--out", "out", folder=tmp_path)
    assert (outcome.code, outcome.out) == (2, "")
    assert len(outcome.err.splitlines()) == 1
    assert outcome.err.startswith("infinivar: study.toml: duty.recorded")
    assert said in outcome.err
    assert file in outcome.err or "duty.recorded." in outcome.err
    assert sorted(path.name for path in tmp_path.iterdir()) == [file, "study.toml"]


def test_files_too_long_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(sheet, "MOST_ROWS", 40)
    (tmp_path / "motion.csv").write_text(CSV, "utf-8")
    (tmp_path / "study.toml").write_text(STUDY.format(file="motion.csv", more=""), "utf-8")
    said = run("compare", "study.toml", folder=tmp_path)
    assert (said.code, said.out) == (2, "")
    assert "motion.csv: line 42: is beyond the 40 rows allowed" in said.err
    monkeypatch.setattr(reading, "_MOST_BYTES", 100)
    said = run("compare", "study.toml", folder=tmp_path)
    assert (said.code, said.out) == (2, "")
    assert "motion.csv: has 0.000" in said.err
    assert "more than the 0.0001 MB allowed" in said.err


def test_names_of_files_and_headings_cannot_control_a_terminal(tmp_path):
    name = "mo\x1b[31mtion.csv"
    (tmp_path / name).write_text(at(1, "time [s],Pos \u202e (mm),Pos \u202e x (mm)"), "utf-8")
    study = STUDY.format(file="mo\\u001b[31mtion.csv", more="")
    (tmp_path / "study.toml").write_text(study, "utf-8")
    said = run("compare", "study.toml", folder=tmp_path)
    assert (said.code, said.out) == (2, "")
    assert said.err.rstrip("\n").isprintable()
