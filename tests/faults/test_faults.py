"""Bad studies, parts, recordings and sessions: exit code 2, a short message that names what is wrong, nothing written."""

import numpy as np
import pytest

import cobotic_study
import session_studies
from faults.rows import PIECES, STUDIES, VALUES, changed, refused, rows, sections, study, toml, with_value
from internals import file_formats
from internals import sheets as sheet
from run_cli import run


def faults(tables, others=()):
    return pytest.mark.parametrize(
        ("table", "change", "words"), [pytest.param(*row, id=name) for name, *row in [*rows(tables), *others]]
    )


TRANSMISSION = "[drives.mine.transmission]\n"
# What no text file can hold, or not well: other encodings, and sizes.
FILES = {
    "binary": (bytes(range(256)), "UTF-8"),
    "UTF-16": (PIECES["good"].encode("utf-16"), "UTF-8"),
    "Latin-1": ("title = 'Größe'".encode("latin-1"), "UTF-8", "byte 11"),
    "zeros": (b"\0\0\0", "TOML", "line 1"),
    "nested without end": ("title = " + "[" * 5000, "nested"),
    "keys nested without end": ("$requirement${mine}" + ".".join("a" * 3000) + " = 1", "key of more than 64 parts"),
    "number of 5000 digits": (f"$requirement$mine{TRANSMISSION}friction = 1" + "0" * 5000, "TOML"),
    "number beyond floats": (
        f"$requirement$mine{TRANSMISSION}friction = 1" + "0" * 400,
        "drives.mine.transmission.friction",
        "1" + "0" * 39,
        "finite",
    ),
    "long name": (
        f"$requirement[drives.{'x' * 200}]\nbase = 'faulring2006.cobotic'",
        "drives.'" + "x" * 32,
        "letters, digits",
    ),
}


@faults(STUDIES, [(name, {}, change, words) for name, (change, *words) in FILES.items()])
def test_studies(tmp_path, table, change, words):
    text = change if isinstance(change, bytes) else study(change, around=table.get("study", "$row"))
    more = [table["says"]] if "says" in table else []
    refused(tmp_path, table.get("command", "compare study.toml"), {"study.toml": text}, words + more)


@pytest.mark.parametrize(
    ("field", "value", "advice"),
    [
        pytest.param(field, value, advice, id=f"{field.split('.')[-1]} = {toml(value)[:20]}")
        for field, values in VALUES.items()
        for advice, every in values.items()
        for value in every
    ],
)
def test_values(tmp_path, field, value, advice):
    shown = [toml(value)[:40].partition("\\u")[0]] if isinstance(value, str | int | float) else []
    refused(tmp_path, "compare study.toml", {"study.toml": with_value(field, value)}, [field, *shown, advice])


PARTS = {"good": cobotic_study.GOOD} | {
    f"above_{name}": cobotic_study.GOOD.partition(f"[drives.arm.{table}]")[0]
    for name, table in (("geometry", "transmission.geometry"), ("bell", "steering.bell_bearing"))
}


@faults(sections("parts"))
def test_parts(tmp_path, table, change, words):
    files = {"study.toml": study(change, PARTS)}
    refused(tmp_path, "contact study.toml --out result", files, words, begins="drives.arm.")


RECORDED = """
[requirement]
base = "faulring2006"
[drives.cobotic]
base = "faulring2006.cobotic"
[duty.recorded]
shape = "file"
file = "{file}"
{study}
"""
TIME = np.linspace(0.0, 1.0, 41)
ROWS = [f"{t:.3f},{50.0 * np.sin(2 * np.pi * t):.4f},{-4.0:.1f}" for t in TIME]
CSV = "\n".join(["time [s],Pos (mm),Fz (N)", *ROWS]) + "\n"
OPENSIM = ["run", "version=1", "nRows=41", "nColumns=3", "inDegrees=yes", "endheader", "time\tposition_mm\tforce_N"]
STRIDE = [f"{100 * t:.1f},{10 * np.sin(2 * np.pi * t):.4f},{np.cos(2 * np.pi * t):.4f}" for t in TIME]
RECORDINGS = {
    "csv": CSV,
    "semicolons": CSV.replace(",", ";"),
    "commas": CSV.replace(",", ";").replace(".", ","),
    "gait": "\n".join(["phase (%),Ankle angle (deg),Ankle torque (N-m/kg)", *STRIDE]),
    "sto": "\n".join([*OPENSIM, *(row.replace(",", "\t") for row in ROWS)]),
}
BYTES = {
    "workbook": (
        b"PK\x03\x04\x14\x00\x06\x00",
        "line 1, character 1: is not text; the file seems to be an Excel workbook",
    ),
    "binary": (b"\x93NUMPY\x01\x00v\x00\x81\x02", "line 1, character 1: is neither UTF-8 nor Latin-1"),
    "UTF-16 without a mark": (
        CSV.encode("utf-16-le"),
        "line 1, character 2: is '\\x00', which is no text; the file may be binary; UTF-16",
    ),
    "half a UTF-16 file": (
        b"\xff\xfe" + CSV.encode("utf-16-le")[:-1],
        "is not UTF-16, which its byte-order mark announces",
    ),
    "Windows-1252": (
        CSV.replace("Pos (mm)", "Pos \u2013 x (mm)").encode("cp1252"),
        "line 1, character 14: is neither UTF-8 nor",
    ),
}


@faults(sections("recordings"), [(name, {"title": "csv"}, content, words) for name, (content, *words) in BYTES.items()])
def test_recordings(tmp_path, table, change, words):
    title, more = table["title"], ""
    if isinstance(change, dict):
        more = change.get("study", "")
        change = changed(RECORDINGS[title], {old: new for old, new in change.items() if old != "study"})
    file = "motion.sto" if title == "sto" else "motion.csv"
    files = {file: change, "study.toml": RECORDED.format(file=file, study=more)}
    begins = "duty.recorded." if words[0].startswith("duty.recorded.") else f"duty.recorded: {file}: "
    refused(tmp_path, "compare study.toml --out out", files, words, begins)


def test_files_too_long_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(sheet, "MOST_ROWS", 40)
    (tmp_path / "motion.csv").write_text(RECORDINGS["csv"], "utf-8")
    (tmp_path / "study.toml").write_text(RECORDED.format(file="motion.csv", study=""), "utf-8")
    said = run("compare", "study.toml", folder=tmp_path)
    assert (said.code, said.out) == (2, "")
    assert "motion.csv: line 42: is beyond the 40 rows allowed" in said.err
    monkeypatch.setattr(file_formats, "_MOST_BYTES", 100)
    said = run("compare", "study.toml", folder=tmp_path)
    assert (said.code, said.out) == (2, "")
    assert "motion.csv: has 0.000" in said.err
    assert "more than the 0.0001 MB allowed" in said.err


def test_names_of_files_and_headings_cannot_control_a_terminal(tmp_path):
    name = "mo\x1b[31mtion.csv"
    (tmp_path / name).write_text(
        changed(RECORDINGS["csv"], {"1": "time [s],Pos \u202e (mm),Pos \u202e x (mm)"}), "utf-8"
    )
    study = RECORDED.format(file="mo\\u001b[31mtion.csv", study="")
    (tmp_path / "study.toml").write_text(study, "utf-8")
    said = run("compare", "study.toml", folder=tmp_path)
    assert (said.code, said.out) == (2, "")
    assert said.err.rstrip("\n").isprintable()


@faults(sections("sessions"))
def test_sessions(tmp_path, table, change, words):
    task = table["title"]
    changes = change | dict.fromkeys(change.get("without", []))
    paths = {key: key.split(".") for key in changes if key != "without"}
    elsewhere = ("drives", *session_studies.TASKS)
    made = session_studies.tables(
        *[(*(path if path[0] in elsewhere else [task, *path]), changes[key]) for key, path in paths.items()],
        slide=task == "slide",
    )
    command = table.get("command", f"session study.toml --task {task} --out out")
    refused(tmp_path, command, {"study.toml": session_studies.text(made)}, words)
