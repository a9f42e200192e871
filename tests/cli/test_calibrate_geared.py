"""`infinivar calibrate` of a geared drive: report, calibrated study, and files that are refused."""

import json
from dataclasses import replace

import numpy as np
import pytest

import infinivar as iv
from conftest import STUDY
from infinivar import InputError
from internals import save_calibration_data as save_data
from internals import virtual_rig, write_csv

NAME = "motor1-gear1"
DRIVE = ("--study", STUDY, "--drive", NAME)


@pytest.fixture
def bench(tmp_path):
    study = iv.load_study(STUDY)
    speed, torque = (part.ravel() for part in np.meshgrid([10.0, 30.0, 60.0], np.linspace(-0.25, 0.25, 6)))
    data = virtual_rig.dynamometer(
        study.drives[NAME], study.rig, speed=speed, torque=torque, noise={"current": 0.003, "voltage": 0.02}
    )
    save_data(data, tmp_path / "bench.csv")
    return tmp_path / "bench.csv"


@pytest.mark.slow
@pytest.mark.renders("svg")
def test_from_the_bench_to_a_calibrated_study(infinivar, bench, tmp_path):
    done = infinivar("calibrate", bench, *DRIVE, "--out", "out", "--json")
    assert done.code == 0, done.err
    report = json.loads(done.out)
    assert report["kind"] == "dynamometer"
    assert all((tmp_path / file).exists() for file in report["files"])
    page = (tmp_path / "out" / "calibration.html").read_text("utf-8")
    assert "load share" in page

    study = iv.load_study(tmp_path / "out" / "calibrated.toml")
    gear = study.drives[NAME].gearhead
    assert gear.loss_model == "stribeck"
    assert gear.friction.load_motor == pytest.approx(report["parameters"]["load_share"]["value"], rel=1e-6, abs=1e-9)
    fitted = {row.field: row for row in study.provenance if row.owner == NAME and row.kind == "fitted"}
    assert fitted["motor.resistance"].where == "bench.csv, dynamometer, 18 rows"
    spreads = {spread.path: spread for spread in study.uncertainty.spreads[NAME]}
    deviation = report["parameters"]["resistance"]["standard_deviation"]
    assert spreads["motor.resistance"].deviation == pytest.approx(deviation, rel=1e-5)
    again = infinivar("calibrate", bench, "--study", "out/calibrated.toml", "--drive", NAME, "--out", "out2")
    assert again.code == 0, again.err
    assert "Calibrated study:" in again.out
    with (tmp_path / "out" / "calibrated.toml").open("a", encoding="utf-8") as file:
        file.write("\n[uncertainty]\ndraws = 64\n")
    compared = infinivar("compare", "out/calibrated.toml", "--drive", NAME, "--out", "compared")
    assert compared.code in (0, 1), compared.err
    assert "measured friction" in (tmp_path / "compared" / "report.html").read_text("utf-8")


def test_exit_code_1_if_the_data_do_not_identify_every_parameter(infinivar, bench, tmp_path):
    rows = [line.split(",") for line in bench.read_text("utf-8").splitlines()[1:]]
    power = [",".join([*row[:2], repr(float(row[2]) * float(row[3]))]) for row in rows]
    bench.write_text("\n".join(["speed [rad/s],torque [N m],power [W]", *power]), "utf-8")
    done = infinivar("calibrate", bench, *DRIVE, "--out", "out")
    assert done.code == 1, done.err
    assert "Not identifiable separately: resistance and torque_constant." in done.out
    text = (tmp_path / "out" / "calibrated.toml").read_text("utf-8")
    assert "not identifiable separately" in text
    bench.write_text("\n".join(["speed [rad/s],torque [N m],power [W]", *power[:3]]), "utf-8")
    done = infinivar("calibrate", bench, *DRIVE, "--out", "few")
    assert done.code == 2
    assert "3 rows are too few to fit 5 parameters" in done.err


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("torque [N m]", "torque [kg]", "line 1, column 'torque [kg]': has the unit 'kg' where N m is needed"),
        ("current [A]", "current", "line 1, column 'current': must state its unit, such as 'current [mA]'"),
        (
            "torque [N m]",
            "moment [N m]",
            "has no wheel to measure; data of a geared drive have columns speed and torque",
        ),
        ("speed [rad/s],torque", "speed [rad/s],motor_torque", "motor_torque needs the speed of the motor"),
        ("current [A],voltage [V]", "a [A],b [V]", "must have a column current, voltage, power or efficiency"),
        ("\n30,", "\nx,", "line 3, column 'speed [rad/s]': must be a finite number, got 'x'"),
    ],
)
def test_bad_files_are_one_message_and_nothing_is_written(infinivar, bench, tmp_path, old, new, said):
    text = bench.read_text("utf-8")
    assert old in text
    bench.write_text(text.replace(old, new, 1), "utf-8")
    done = infinivar("calibrate", bench, *DRIVE, "--out", "out")
    assert done.code == 2
    assert said in done.err
    assert len(done.err.strip().splitlines()) == 1
    assert not (tmp_path / "out").exists()


def test_impossible_efficiencies_are_refused_by_line(infinivar, tmp_path):
    rows = [f"{speed},{torque},{150 + speed}" for speed in (10, 20, 30) for torque in (0.1, 0.2, 0.3)]
    (tmp_path / "e.csv").write_text("\n".join(["speed [rad/s],torque [N m],efficiency [%]", *rows]), "utf-8")
    done = infinivar("calibrate", "e.csv", *DRIVE, "--out", "out")
    assert done.code == 2
    assert "e.csv: line 2: efficiency must be within 0 and 1, got 1.6" in done.err
    assert not (tmp_path / "out").exists()


def test_creep_laws_do_not_apply_to_a_geared_drive(infinivar, bench):
    done = infinivar("calibrate", bench, *DRIVE, "--creep-laws", "linear")
    assert done.code == 2
    assert "has no wheel" in done.err


def test_a_study_that_does_not_fit_is_named_by_its_file_or_itself(study, bench):
    for place, said in (("bench.toml", "bench.toml: "), (None, f"{study.name}: ")):
        with pytest.raises(InputError) as refused:
            iv.calibrate(replace(study, path=place), "motor1-gear1", bench, creep_laws=("linear",))
        assert str(refused.value) == f"{said}drives.motor1-gear1 has no wheel: creep laws do not apply"


STUDY_OF_PENDULUM = """
extends = "{study}"
[rig]
pendulum_mass = "150 g"
pendulum_length = "20 cm"
"""


@pytest.fixture
def swinging(tmp_path):
    (tmp_path / "swing.toml").write_text(STUDY_OF_PENDULUM.format(study=STUDY.as_posix()), "utf-8")
    study = iv.load_study(tmp_path / "swing.toml")
    columns = virtual_rig.swing(
        study.drives[NAME],
        study.rig,
        duration=10.0,
        rate=200.0,
        amplitudes={0.5: 1.0, 1.3: 0.3},
        noise={"angle": 1e-4, "current": 0.01},
        values={"friction": 0.015, "load_share": 0.03, "viscous": 1e-3},
    )
    write_csv(columns, tmp_path / "swing.csv")
    return tmp_path / "swing.csv"


@pytest.mark.slow
@pytest.mark.renders("svg")
def test_from_a_pendulum_to_a_calibrated_study(infinivar, swinging, tmp_path):
    done = infinivar("calibrate", swinging, "--study", "swing.toml", "--drive", NAME, "--out", "out", "--json")
    assert done.code == 0, done.err
    report = json.loads(done.out)
    assert report["kind"] == "pendulum"
    low, high = report["parameters"]["load_share"]["interval_95"]
    assert low < 0.03 < high
    assert iv.load_study(tmp_path / "out" / "calibrated.toml").drives[NAME].gearhead.loss_model == "stribeck"
    assert "pendulum" in (tmp_path / "out" / "calibration.html").read_text("utf-8")


@pytest.mark.parametrize(
    ("study", "change", "said"),
    [
        (STUDY, lambda rows: rows, "need pendulum_mass and pendulum_length in [rig]"),
        ("swing.toml", lambda rows: [*rows[:50], *rows[40:]], "line 51, column 'time': must be later"),
        ("swing.toml", lambda rows: rows[:30], "must have at least 8 rows in each of 8 windows a period"),
        (
            "swing.toml",
            lambda rows: [rows[0].replace("angle [rad]", "angle"), *rows[1:]],
            "must state its unit, such as",
        ),
        (
            "swing.toml",
            lambda rows: [rows[0], *(f"{i},1.0,0.1" for i in range(100))],
            "the angle does not change",
        ),
    ],
)
def test_bad_recordings_of_a_pendulum_are_refused(infinivar, swinging, tmp_path, study, change, said):
    rows = swinging.read_text("utf-8").splitlines()
    swinging.write_text("\n".join(change(rows)), "utf-8")
    done = infinivar("calibrate", swinging, "--study", study, "--drive", NAME, "--out", "out")
    assert done.code == 2
    assert said in done.err
    assert not (tmp_path / "out").exists()
