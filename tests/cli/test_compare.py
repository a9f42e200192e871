"""`infinivar compare`: verdicts, JSON, report, maps, and what it leaves alone."""

import json
import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray

from folders import results
from infinivar import Limit
from pages import Links, needs_no_network
from sampled import sampled

STUDY = Path(__file__).parents[2] / "studies" / "hand_controller.toml"
KINDS = ("png", "svg")
FIGURES = [f"report-{name}.{kind}" for name in ("maps", "losses") for kind in KINDS]
OF_SEVERAL = [f"report-{name}.{kind}" for name in ("maps", "least-loss", "losses") for kind in KINDS]
LEAST = "report-least-loss.nc"
DRIVES = ["cobotic", "cobotic-b", "motor1-gear1", "motor1-gear2", "motor1-gear3", "motor2-gear4"]

ONE_DRIVE = """
[requirement]
force = "{force}"
speed = "1.05 m/s"
power = "{power}"
[drives.mine]
base = "faulring2006.{base}"
"""


def numbers(value):
    """Every number in nested lists and tables."""
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list):
        return [number for item in value for number in numbers(item)]
    return [value] if isinstance(value, float) else []


def test_the_shipped_study_has_the_known_answer(compared):
    outcome, _, said = compared
    assert (outcome.code, outcome.err) == (0, "")
    coverage = {name: drive["coverage"] for name, drive in said["drives"].items()}
    assert list(coverage) == DRIVES
    assert coverage["cobotic"] == coverage["cobotic-b"] == coverage["motor2-gear4"] == 1.0
    assert all(0.3 < coverage[f"motor1-gear{ratio}"] < 0.9 for ratio in (1, 2, 3))


def test_json_has_the_promised_keys(compared):
    _, folder, said = compared
    assert list(said) == [
        "study",
        "feasible",
        "best",
        "verdict",
        "warnings",
        "drives",
        "masses",
        "hangs_on",
        "least_loss",
        "files",
    ]
    assert (said["feasible"], said["best"]) == (True, "cobotic-b")
    assert said["verdict"].startswith(
        "3 of 6 drives cover the requirement; lowest mean loss over the required region: "
    )
    assert said["study"] == "hand_controller"
    names = ("report.html", "results.json", *(f"{d}.nc" for d in DRIVES), LEAST, *OF_SEVERAL)
    assert said["files"] == [str(folder / name) for name in names]
    for drive in said["drives"].values():
        assert {"title", "verdict", "coverage", "peak_efficiency", "peak_efficiency_in_region"} < drive.keys()
        assert 0.0 < drive["peak_efficiency_in_region"] <= drive["peak_efficiency"] < 1.0
        assert 0.0 <= drive["audit_residual"] < 1e-9
        tight = drive["tightest_margin"]
        assert list(tight) == ["limit", "value", "force", "speed"]
        assert tight["limit"] in Limit.__members__
        assert tight["limit"] != "OK"
        # The tightest point lies in the region, and a drive covers exactly where the margin there is at least 1.
        assert 0 < tight["force"] <= 50
        assert 0 < tight["speed"] <= 1.05
        assert tight["force"] * tight["speed"] <= 12 * (1 + 1e-12)
        assert (tight["value"] >= 1) == (drive["coverage"] == 1)


def test_results_file_is_strict_json_and_agrees(compared):
    _, folder, said = compared

    def refuse(word):
        raise AssertionError(f"{word} is not JSON")

    stored = json.loads((folder / "results.json").read_text("utf-8"), parse_constant=refuse)
    for name, drive in said["drives"].items():
        assert {key: stored["drives"][name][key] for key in drive} == drive
        for corner in stored["drives"][name]["corners"].values():
            if corner["limit"] != "SLIP":
                power_out = corner["force"] * corner["speed"]
                assert corner["power_in"] == pytest.approx(power_out + sum(corner["losses"].values()), rel=1e-9)
    assert stored["requirement"] == {
        "force": 50.0,
        "speed": 1.05,
        "power": 12.0,
        "load_mass": 0.8,
        "travel": None,
        "quadrants": 1,
    }
    assert {row["owner"] for row in stored["provenance"]} == {"requirement", *DRIVES}
    assert all(map(math.isfinite, numbers(stored)))


@sampled("drive", DRIVES, every=3)
def test_map_is_labelled_and_adds_up(compared, drive):
    _, folder, said = compared
    with xarray.open_dataset(folder / f"{drive}.nc") as data:
        assert {"power_in", "power_out", "efficiency", "limit", "margin"} < set(data.data_vars)
        assert all(data[name].attrs["units"] for name in data.variables)
        assert (data.force.attrs["units"], data.speed.attrs["units"]) == ("N", "m s-1")
        losses = [data[name] for name in data.data_vars if str(name).startswith("loss_")]
        assert len(losses) >= 6
        assert all(loss.attrs["units"] == "W" for loss in losses)
        scale = np.maximum(abs(data.power_in), abs(data.power_out))
        missing = abs(data.power_in - data.power_out - sum(losses)) / scale
        assert float(missing.max()) < 1e-9
        assert np.isfinite(data.power_in).mean() > 0.5
        # Efficiency is a number between 0 and 1 within limits, and nothing outside them.
        within = data.limit == Limit.OK
        assert bool(np.isnan(data.efficiency).where(~within, True).all())
        assert float(data.efficiency.min()) >= 0
        assert float(data.efficiency.max()) <= said["drives"][drive]["peak_efficiency"]


def test_page_needs_no_network(compared):
    needs_no_network(compared[1] / "report.html")


def test_report_says_what_was_found(compared):
    _, folder, said = compared
    text = Links((folder / "report.html").read_text("utf-8")).text
    for drive in said["drives"].values():
        assert drive["title"] in text
    assert "reconstruct" in text
    assert "nan" not in text.lower().split()


def test_other_files_stay_and_old_results_go(compared):
    outcome, folder, _ = compared
    assert outcome.code == 0
    assert (folder / "notes.txt").read_text("utf-8") == "keep me"
    assert (folder / "report.html").stat().st_size > 100_000
    assert results(folder) == sorted(
        ["notes.txt", "report.html", "results.json", *(f"{drive}.nc" for drive in DRIVES), LEAST, *OF_SEVERAL]
    )
    for name in OF_SEVERAL:
        head = (folder / name).read_bytes()[:300]
        assert {"png": b"\x89PNG", "svg": b"<svg"}[name.rpartition(".")[2]] in head


def test_plain_output_is_one_line_a_drive(infinivar, write):
    outcome = infinivar("compare", write(ONE_DRIVE.format(force="50 N", power="12 W", base="cobotic")))
    assert (outcome.code, outcome.err) == (0, "")
    verdict, left_out, table, *_, report = outcome.out.splitlines()
    assert "covers 100 %" in verdict
    assert left_out == "Not counted: cylinder bearings."
    assert table.startswith("What this verdict hangs on (mean loss over the required region")
    assert report.startswith("Report: ")


def test_exit_code_1_where_no_drive_covers(infinivar, write, tmp_path):
    name = write(ONE_DRIVE.format(force="500 N", power="1 kW", base="motor1-gear1"))
    outcome = infinivar("compare", name, "--out", "out", "--json")
    assert (outcome.code, outcome.err) == (1, "")
    drive = json.loads(outcome.out)["drives"]["mine"]
    assert drive["coverage"] < 0.1
    assert drive["tightest_margin"]["value"] < 0.2
    # "Not feasible" is an answer: everything is written.
    assert results(tmp_path / "out") == sorted(["mine.nc", "report.html", "results.json", *FIGURES])


def test_coverage_is_a_share_of_the_area(infinivar, write):
    """Half the force at every speed on a rectangle: a drive that just makes the half covers half."""
    text = """
        requirement = { force = "20 N", speed = "1 m/s" }
        [drives.mine]
        type = "conventional"
        [drives.mine.motor]
        part = "re-40-24v"
        [drives.mine.gearhead]
        ratio = 1
        efficiency = 1
        continuous_torque = "0.1 N m"
        [drives.mine.pulley]
        radius = "10 mm"
    """
    outcome = infinivar("compare", write(text), "--json")
    drive = json.loads(outcome.out)["drives"]["mine"]
    assert drive["tightest_margin"]["limit"] == "GEAR"
    assert drive["tightest_margin"]["value"] == pytest.approx(0.5)
    assert drive["coverage"] == pytest.approx(0.5, abs=0.01)


def test_coverage_where_the_power_binds_over_most_of_the_force_axis(infinivar, write):
    """|F v| <= P out to 50 kN: of the area P (1 + ln(F V/P)) a gear that bears 50 N covers 0.264."""
    text = """
        requirement = { force = "50 kN", speed = "1.05 m/s", power = "12 W" }
        [drives.mine]
        type = "conventional"
        [drives.mine.motor]
        part = "re-40-24v"
        voltage = "240 V"
        continuous_torque = "2 N m"
        [drives.mine.gearhead]
        ratio = 1
        efficiency = 1
        continuous_torque = "0.5 N m"
        [drives.mine.pulley]
        radius = "10 mm"
    """
    outcome = infinivar("compare", write(text), "--json")
    drive = json.loads(outcome.out)["drives"]["mine"]
    assert drive["tightest_margin"]["limit"] == "GEAR"
    exact = (1 + math.log(50 * 1.05 / 12)) / (1 + math.log(50_000 * 1.05 / 12))
    assert drive["coverage"] == pytest.approx(exact, abs=0.01)
    assert drive["peak_efficiency"] is not None


@sampled("quadrants", [2, 4], every=2)
def test_more_quadrants_ask_for_more(infinivar, write, quadrants):
    """An amplifier that takes no power back covers only the driving half of the region."""
    text = f"""
        requirement = {{ base = "faulring2006", quadrants = {quadrants} }}
        [drives.mine]
        base = "faulring2006.motor2-gear4"
        amplifier = {{ regeneration = "none" }}
    """
    outcome = infinivar("compare", write(text), "--json")
    drive = json.loads(outcome.out)["drives"]["mine"]
    assert outcome.code == 1
    assert drive["tightest_margin"]["limit"] == "REGENERATION"
    assert 0.5 <= drive["coverage"] < 0.9


@sampled("title", ["$x^$", "cost $5 or $6", "x [/b] y", "<script>alert(1)</script>", "Größe µ", "日本", "_"], every=3)
@pytest.mark.renders("svg")
def test_titles_are_only_text(infinivar, write, tmp_path, title):
    """Whatever a title contains is shown as it is, not taken for a formula, for markup or for code."""
    text = ONE_DRIVE.format(force="50 N", power="12 W", base="motor2-gear4") + f"title = {json.dumps(title)}\n"
    outcome = infinivar("compare", write(text))
    assert (outcome.code, outcome.err) == (0, "")
    assert title in outcome.out
    page = Links((tmp_path / "out" / "report.html").read_text("utf-8"))
    assert page.scripts == 0
    assert title in page.text


@pytest.mark.slow
def test_drives_of_one_base_are_told_apart(infinivar, write, tmp_path):
    """Two variants of a shipped drive have its title both: neither may vanish from output, figure or report."""
    text = """
        requirement.base = "faulring2006"
        drives.light = { base = "faulring2006.motor1-gear1" }
        drives.heavy = { base = "faulring2006.motor1-gear1", motor = { scale = 3 } }
    """
    outcome = infinivar("compare", write(text))
    _, first, second, *_ = outcome.out.splitlines()
    assert "light" in first
    assert "heavy" in second
    from infinivar import compare, load_study
    from internals import losses_figure as losses

    comparison = compare(load_study(tmp_path / "study.toml"))
    assert len(losses.data(comparison, "maximum force")["losses"]) == 2


@sampled("occupied", ["mine.nc", "report.html", "results.json"], every=3)
def test_nothing_is_replaced_unless_everything_can_be(infinivar, write, tmp_path, occupied):
    """A folder in the place of one result: the other results of the run before stay whole."""
    names = ("mine.nc", "report.html", "results.json")
    (tmp_path / "out" / occupied).mkdir(parents=True)
    for name in names:
        if name != occupied:
            (tmp_path / "out" / name).write_text("before", "utf-8")
    name = write(ONE_DRIVE.format(force="50 N", power="12 W", base="cobotic"))
    outcome = infinivar("compare", name, "--out", "out")
    assert outcome.code == 2
    assert occupied in outcome.err
    assert results(tmp_path / "out") == sorted(names)
    assert all((tmp_path / "out" / name).read_text("utf-8") == "before" for name in names if name != occupied)


@pytest.mark.parametrize("out", ["taken", "taken/below", "study.toml/deep/er"])
def test_a_folder_that_cannot_be_is_bad_input(infinivar, write, tmp_path, out):
    (tmp_path / "taken").write_text("a file", "utf-8")
    outcome = infinivar("compare", write(ONE_DRIVE.format(force="50 N", power="12 W", base="cobotic")), "--out", out)
    assert (outcome.code, outcome.out) == (2, "")
    assert outcome.err.startswith(f"infinivar: {out}: ")
    assert len(outcome.err.splitlines()) == 1
    assert (tmp_path / "taken").read_text("utf-8") == "a file"


@pytest.mark.slow
def test_odd_folder_names(infinivar, write, tmp_path):
    outcome = infinivar(
        "compare", write(ONE_DRIVE.format(force="50 N", power="12 W", base="cobotic")), "--out", "a b/ü/x.y"
    )
    assert outcome.code == 0
    assert (tmp_path / "a b" / "ü" / "x.y" / "report.html").is_file()


@pytest.mark.slow
def test_console_script_on_a_terminal_that_knows_only_ascii(write, tmp_path):
    """The real console script: a title the terminal cannot show is no reason to fail."""
    text = ONE_DRIVE.format(force="50 N", power="12 W", base="cobotic") + 'title = "Größe"\n'
    script = Path(sys.executable).with_name("infinivar")
    done = subprocess.run(
        [script, "compare", write(text)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONIOENCODING": "ascii"},
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert "covers 100 %" in done.stdout


@pytest.mark.slow
def test_the_report_does_not_depend_on_matplotlib_settings(write, tmp_path):
    """A user's matplotlibrc, here one that asks for LaTeX and for a backend without a window, changes nothing."""
    (tmp_path / "matplotlibrc").write_text("text.usetex: True\naxes.titlesize: 40\n", "utf-8")
    done = subprocess.run(
        [
            sys.executable,
            "-W",
            "error",
            "-m",
            "infinivar",
            "compare",
            write(ONE_DRIVE.format(force="50 N", power="12 W", base="cobotic")),
        ],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        env={**os.environ, "MPLBACKEND": "TkAgg"},
    )
    assert (done.returncode, done.stderr) == (0, "")


def test_verdicts_come_before_the_report_is_drawn(infinivar, monkeypatch):
    """Whoever waits for the drawing has read the verdicts by then."""
    from internals import report_saving as saving

    def never(*arguments, **options):
        raise OSError(28, "No space left on device", "report.html")

    monkeypatch.setattr(saving, "save", never)
    outcome = infinivar("compare", "hand_controller", "--drive", "cobotic")
    assert outcome.code == 2
    assert "covers 100 % of the required region" in outcome.out
    assert "Report" not in outcome.out


def test_only_the_drives_asked_for(infinivar, tmp_path, compared):
    outcome = infinivar("compare", "hand_controller", "--drive", "motor1-gear3", "--drive", "cobotic", "--json")
    found, (_, _, every) = json.loads(outcome.out), compared
    assert list(found["drives"]) == ["cobotic", "motor1-gear3"]
    assert all(found["drives"][name] == every["drives"][name] for name in found["drives"])
    stored = json.loads((tmp_path / "out" / "results.json").read_text("utf-8"))
    assert {row["owner"] for row in stored["provenance"]} == {"requirement", "cobotic", "motor1-gear3"}
    assert not (tmp_path / "out" / "motor1-gear1.nc").exists()


def test_a_drive_that_is_not_there(infinivar, tmp_path):
    outcome = infinivar("compare", "hand_controller", "--drive", "cobotics")
    assert (outcome.code, outcome.out) == (2, "")
    assert "hand_controller: the study has no drive 'cobotics' (did you mean 'cobotic'?); its drives: " in outcome.err
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_quick_leaves_out_what_it_says_and_changes_no_number(infinivar, tmp_path, followed):
    """Verdicts and numbers are those of the full run; nothing is written, and the last line says what is missing."""
    _, _, full = followed
    quick = json.loads(infinivar("compare", "knee_walking", "--quick", "--json").out)
    assert quick.pop("files") == []
    assert quick["drives"] == full["drives"]
    for task, found in quick["duty"].items():
        for name, drive in found["drives"].items():
            assert drive.pop("cylinder") == []
            assert drive.pop("simulated") == {"left_out": "omitted from a quick comparison"}
            assert drive.items() <= full["duty"][task]["drives"][name].items()
    assert quick.get("builds") is None
    outcome = infinivar("compare", "knee_walking", "--quick")
    assert (outcome.code, outcome.err) == (0, "")
    assert outcome.out.split("\n")[-2].startswith("Quick run: the verdicts equal those of a full run. Skipped: ")
    assert not list(tmp_path.iterdir())
