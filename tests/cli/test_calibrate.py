"""`infinivar rig` and `infinivar calibrate`: from the bench to a calibrated study, and data that no rig can give."""

import csv
import json
import shutil

import numpy as np
import pytest

import infinivar as iv
from conftest import STUDY
from internals import save_calibration_data as save_data
from internals import virtual_rig
from rigs import session, under
from sampled import sampled

DRIVE = ("--study", STUDY, "--drive", "cobotic")
ONE_LAW = ("--creep-laws", "linear")
"""Where the choice of the creep law does not matter: each that is tried is a fit."""


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    """Data of one session."""
    study = iv.load_study(STUDY)
    drive = study.drives["cobotic"]
    protocol = virtual_rig.protocol(drive, study.rig, ratios=(100.0, 20.0, 8.0, 3.0, 1.0))
    file = tmp_path_factory.mktemp("rig") / "rig.csv"
    save_data(virtual_rig.experiment(drive, study.rig, protocol, seed=3, simulated=False).data, file)
    return file


def edited(measured, folder, change):
    """The data with `change(rows)` done to them; the first row is the header."""
    with measured.open(newline="") as file:
        rows = list(csv.reader(file))
    change(rows)
    with (folder / "rig.csv").open("w", newline="") as file:
        csv.writer(file).writerows(rows)
    return folder / "rig.csv"


@pytest.mark.slow
def test_from_the_rig_to_a_calibrated_study(infinivar, tmp_path):
    done = infinivar("rig", STUDY, "--drive", "cobotic", "--ratios", "8", "--loads", "0.2,0.5", "--out", "rig.csv")
    assert done.code == 0, done.err
    assert "7 runs written to rig.csv" in done.out
    found = infinivar("calibrate", "rig.csv", *DRIVE, "--out", "out", "--json")
    assert found.code == 1  # one preload does not tell hysteresis from bearing friction
    report = json.loads(found.out)
    assert report["combinations"][0]["weights"].keys() == {"rolling_torque", "bearing_torque"}
    assert report["parameters"]["creep_stiffness"]["identifiable"]
    assert report["parameters"]["rolling_torque"]["standard_deviation"] is None
    assert all((tmp_path / file).exists() for file in report["files"])
    page = (tmp_path / "out" / "calibration.html").read_text("utf-8")
    assert "Not identifiable separately: rolling_torque and bearing_torque." in page

    study = iv.load_study(tmp_path / "out" / "calibrated.toml")
    fitted = {row.field: row for row in study.provenance if row.owner == "cobotic" and row.kind == "fitted"}
    assert fitted.keys() == {"transmission.creep_stiffness", "guideway.coefficient", "gearhead.efficiency"}
    assert fitted["transmission.creep_stiffness"].value == pytest.approx(
        report["parameters"]["creep_stiffness"]["value"]
    )
    assert fitted["transmission.creep_stiffness"].where == "rig.csv, 7 runs"
    spreads = {spread.path: spread for spread in study.uncertainty.spreads["cobotic"]}
    deviation = report["parameters"]["creep_stiffness"]["standard_deviation"]
    assert spreads["transmission.creep_stiffness"].deviation == pytest.approx(deviation, rel=1e-5)
    assert "transmission.bearing_torque" in spreads  # carries the interval of the sum
    assert iv.load_study(STUDY).drives.keys() == study.drives.keys()


@pytest.mark.full
def test_a_calibrated_study_is_calibrated_again(infinivar, tmp_path):
    infinivar("rig", STUDY, "--drive", "cobotic", "--ratios", "8", "--loads", "0.2,0.5", "--out", "rig.csv")
    infinivar("calibrate", "rig.csv", *DRIVE, "--out", "out")
    study = iv.load_study(tmp_path / "out" / "calibrated.toml")
    again = infinivar("calibrate", "rig.csv", "--study", "out/calibrated.toml", "--drive", "cobotic", "--out", "out2")
    assert "creep_stiffness" in again.out
    twice = iv.load_study(tmp_path / "out2" / "calibrated.toml")
    assert twice.title == study.title
    assert twice.title.endswith(", calibrated")


@pytest.mark.slow
def test_other_commands_take_the_calibrated_study(infinivar, write, measured, tmp_path):
    bases = {
        "requirement": "faulring2006",
        "drives.cobotic": "faulring2006.cobotic",
        "scenarios.hold": "faulring2006.hold",
    }
    spreads = (
        "[uncertainty]\ndraws = 64\n[uncertainty.cobotic.guideway]\ncoefficient = { low = 5e-4, high = 2e-3 }\n"
        '[uncertainty.cobotic.transmission.geometry]\ncrown_radius = "5 %"\n'
    )
    study = write("".join(f'[{table}]\nbase = "{base}"\n' for table, base in bases.items()) + spreads)
    infinivar("calibrate", measured, "--study", study, "--out", "out")
    for command in (
        ("compare", "out/calibrated.toml"),
        ("simulate", "out/calibrated.toml", "--drive", "cobotic", "--scenario", "hold"),
    ):
        outcome = infinivar(*command)
        assert outcome.code in (0, 1), outcome.err
        assert not outcome.err


def column(rows, name):
    return next(place for place, heading in enumerate(rows[0]) if heading.startswith(name))


def swap(one, other):
    def change(rows):
        a, b = column(rows, one), column(rows, other)
        for row in rows[1:]:
            row[a], row[b] = row[b], row[a]

    return change


def scaled(name, factor, lines=slice(1, None)):
    def change(rows):
        place = column(rows, name)
        for row in rows[lines]:
            row[place] = repr(float(row[place]) * factor)

    return change


def set_to(name, value, lines):
    def change(rows):
        for line in lines:
            rows[line - 1][column(rows, name)] = value

    return change


def heading(name, text):
    def change(rows):
        rows[0][column(rows, name)] = text

    return change


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            heading("link_travel", "link_travel [kg]"),
            "line 1, column 'link_travel [kg]': has the unit 'kg' where m is needed",
        ),
        (
            heading("link_travel", "link_travel"),
            "line 1, column 'link_travel': must state its unit, such as 'link_travel [mm]'",
        ),
        (heading("preload", "load [N]"), "line 1: must name the columns"),
        (heading("link_travel", "link_travel [mm]"), "is it in metres?"),
        (scaled("link_travel", 1e3), "is it in millimetres?"),
        (heading("steering_angle", "steering_angle [deg]"), "was an angle in radians labelled as degrees?"),
        (heading("cylinder_angle", "cylinder_angle [rev]"), "rad/s at most"),
        (scaled("cylinder_angle", 57.0), "is it the motor angle instead of the cylinder angle?"),
        (scaled("link_travel", -1.0), "is a sign reversed?"),
        (swap("cylinder_angle", "link_travel"), "are link_travel and cylinder_angle swapped?"),
        (swap("mass", "preload"), "are mass and preload swapped?"),
        (swap("motor_current", "motor_voltage"), "motor_current is 20.8"),
        (scaled("motor_current", 1e3), "above the motor's stall current"),
        (set_to("mass", "nan", [6]), "line 6, column 'mass [kg]': must be a finite number, got 'nan'"),
        (set_to("duration", "0", [6]), "line 6: duration must be > 0 s"),
        (set_to("mass", "-1", [6]), "line 6: mass must be >= 0"),
        (set_to("steering_angle", "2", [6]), "line 6: steering_angle must be within -90 and 90 deg"),
        (heading("duration", "duration [ms]"), "rad/s at most"),
        (scaled("duration", 1e3), "check the units of both headings"),
        (scaled("motor_current", 1.2, slice(4, None, 2)), "too many for outliers"),
        pytest.param(
            scaled("motor_current", -1.0, slice(4, None)),
            "the link receives work but the cylinder supplies none",
            marks=pytest.mark.slow,
        ),
        (lambda rows: rows.__delitem__(slice(1, None)), "at least two rows of numbers"),
        (lambda rows: rows.__setitem__(0, [";".join(rows[0])]), "line 1 has 8 headings, this line 1 cell"),
    ],
)
def test_data_that_no_rig_can_give(infinivar, measured, tmp_path, change, said):
    outcome = infinivar("calibrate", edited(measured, tmp_path, change), *DRIVE, "--out", "out")
    assert outcome.code == 2
    assert said in outcome.err
    assert "rig.csv" in outcome.err
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
@sampled(
    ("change", "lines", "said"),
    [
        pytest.param(
            set_to("link_travel", "0", [9, 10]), [9, 10], "line 9: link_travel is zero", marks=pytest.mark.slow
        ),
        (
            set_to("link_travel", "0.1985", [11, 12]),
            [11, 12],
            "line 12: link_travel repeats the value of the previous line",
        ),
        pytest.param(
            set_to("cylinder_angle", "0", [7]), [7], "line 7: cylinder_angle is 0 rad in", marks=pytest.mark.slow
        ),
        pytest.param(
            set_to("motor_current", "0.17", [11]), [11], "line 11: efficiency by Eq 18 is", marks=pytest.mark.slow
        ),
        (scaled("motor_current", -1.0, slice(1, 2)), [2], "line 2: motor_current is -0.1785 A and brakes a cylinder"),
        (scaled("motor_current", 1.1, slice(8, 9)), [9], "standard deviations off"),
    ],
    every=5,
    slow=3,
)
def test_single_readings_that_no_rig_can_give_are_left_out(infinivar, measured, tmp_path, change, lines, said):
    """The same faults in all runs, or in most of a kind, are refused: see above."""
    file = edited(measured, tmp_path, change)
    outcome = infinivar("calibrate", file, *DRIVE, "--out", "out", "--json")
    assert outcome.code == 1
    report = json.loads(outcome.out)
    assert [one["line"] for one in report["left_out_lines"]] == lines
    assert f"excluded: line {lines[0]}: " in outcome.err
    assert said in outcome.err
    page = (tmp_path / "out" / "calibration.html").read_text("utf-8").replace("\N{NO-BREAK SPACE}", " ")
    assert all(one["reason"] in page for one in report["left_out_lines"])
    options = [word for line in lines for word in ("--leave-out", str(line))]
    without = json.loads(infinivar("calibrate", file, *DRIVE, *options, "--json").out)
    for name, one in without["parameters"].items():
        assert report["parameters"][name]["value"] == pytest.approx(one["value"], rel=1e-4)


def test_a_pattern_of_readings_that_no_rig_can_give_is_refused(infinivar, measured, tmp_path):
    file = edited(measured, tmp_path, set_to("link_travel", "0", [7, 8, 17, 18]))
    outcome = infinivar("calibrate", file, *DRIVE, "--out", "out")
    assert outcome.code == 2
    assert "line 7: link_travel is zero" in outcome.err
    assert "4 of the 4 runs steered to 2.86 deg in either direction are implausible: a systematic error" in outcome.err
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_data_of_another_creep_law_are_told_first(infinivar, write, tmp_path):
    study = iv.load_study(STUDY)
    drive = under(study.drives["cobotic"], "polach")
    save_data(session(drive, 3, loads=(0.2, 0.5, 0.65)), tmp_path / "bent.csv")
    outcome = infinivar("calibrate", "bent.csv", *DRIVE, "--out", "out")
    assert outcome.out.startswith("The data contradict the study's creep law: polach fits better than linear by ")
    assert 'creep_law = { value = "polach", kind = "fitted"' in (tmp_path / "out" / "calibrated.toml").read_text(
        "utf-8"
    )
    small = tmp_path / "small.toml"
    small.write_text('extends = "out/calibrated.toml"\n[uncertainty]\ndraws = 16\n', "utf-8")
    compared = infinivar("compare", small)
    assert compared.code in (0, 1), compared.err
    page = next(tmp_path.glob("**/report.html")).read_text("utf-8")
    assert "<td>polach</td>" in page
    kept = infinivar("calibrate", "bent.csv", *DRIVE, "--creep-laws", "polach, fastsim", "--out", "kept", "--json")
    assert [one["law"] for one in json.loads(kept.out)["creep_law"]["laws"]] == ["polach", "fastsim"]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--creep-laws", "lienar"), "creep_law must be one of linear"),
        (("--creep-laws", ","), "no creep law to fit"),
        (("--fit", "creep"), "'creep' cannot be fitted; choose from creep_stiffness"),
        (("--fit", ","), "no parameter to fit"),
        (("--leave-out", "99"), "line 99 is not a run; runs are in lines 2 to 24"),
        (("--drive", "motor1-gear1"), "has no wheel to measure"),
        (("--drive", "cobotc"), "did you mean 'cobotic'?"),
    ],
)
def test_wishes_that_mean_nothing(infinivar, measured, tmp_path, options, said):
    outcome = infinivar("calibrate", measured, *DRIVE, *options, "--out", "out")
    assert outcome.code == 2
    assert said in outcome.err
    assert not (tmp_path / "out").exists()


def test_resistance_needs_a_voltage(infinivar, measured, tmp_path):
    file = edited(measured, tmp_path, heading("motor_voltage", "remark"))
    outcome = infinivar("calibrate", file, *DRIVE, "--fit", "resistance")
    assert outcome.code == 2
    assert "fitting the resistance requires a column motor_voltage" in outcome.err
    assert infinivar("calibrate", file, *DRIVE, *ONE_LAW).code == 1


def test_lines_left_out_are_not_used(infinivar, measured, tmp_path):
    file = edited(measured, tmp_path, set_to("motor_current", "0.17", [11]))
    outcome = infinivar("calibrate", file, *DRIVE, "--leave-out", "11", *ONE_LAW, "--json")
    assert outcome.code == 1
    assert json.loads(outcome.out)["runs"] == 22


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--ratios", "8;1"), "--ratios '8;1' must be numbers separated by commas"),
        (("--loads", "1.5"), "loads must be >= 0 and < 1, got 1.5"),
        (("--drive", "motor2-gear4"), "has no wheel to measure"),
    ],
)
def test_rigs_that_cannot_be(infinivar, tmp_path, options, said):
    outcome = infinivar("rig", STUDY, "--drive", "cobotic", *options)
    assert outcome.code == 2
    assert said in outcome.err
    assert not list(tmp_path.iterdir())


def test_the_only_drive_with_a_wheel_need_not_be_named(infinivar, write):
    study = write(
        '[requirement]\nbase = "faulring2006"\n[drives.ivt]\nbase = "faulring2006.cobotic"\n'
        '[drives.gear]\nbase = "faulring2006.motor2-gear4"\n'
    )
    assert "drives.ivt: loads must be" in infinivar("rig", study, "--loads", "1.5").err
    assert "gone.csv: no such file" in infinivar("calibrate", "gone.csv", "--study", study).err


@pytest.mark.slow
def test_the_figure_shows_fitted_curves_through_the_data(measured):
    from infinivar import calibrate
    from internals import calibration_figure as figure

    found = calibrate(iv.load_study(STUDY), "cobotic", measured)
    numbers = figure.data(found)
    assert len(numbers["curves"]) == 4
    for curve in numbers["curves"]:
        known = np.isfinite(curve["measured"])
        fitted = np.interp(np.log(curve["at"][known]), np.log(curve["ratio"]), np.nan_to_num(curve["fitted"]))
        assert np.all(np.abs(fitted - curve["measured"][known]) < 5 * curve["deviation"][known] + 2e-3)
    assert numbers["correlations"].shape == (3, 3)


def test_a_study_without_the_file_it_extends(infinivar, measured, tmp_path):
    infinivar("calibrate", measured, *DRIVE, *ONE_LAW, "--out", "out")
    shutil.move(tmp_path / "out" / "calibrated.toml", tmp_path / "moved.toml")
    text = (tmp_path / "moved.toml").read_text("utf-8").replace("hand_controller", "gone")
    (tmp_path / "moved.toml").write_text(text, "utf-8")
    outcome = infinivar("compare", "moved.toml")
    assert outcome.code == 2
    assert "gone.toml: no such file" in outcome.err
