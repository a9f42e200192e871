"""`infinivar compare` with duty cycles: energy, heat, limits, holding and cylinder speed; recordings that are wrong."""

import csv
import json
import math
import re
import sys
from pathlib import Path

import pytest

from folders import results

STUDIES = Path(__file__).parents[2] / "studies"

RECORDED = """
[requirement]
force = "20 N"
speed = "0.4 m/s"
load_mass = "0.8 kg"
[drives.geared]
base = "faulring2006.motor2-gear4"
[duty.recorded]
shape = "file"
file = "motion.csv"
{more}
"""


def wave(heading="time [s],position [mm]", rows=200):
    times = [k / rows for k in range(rows + 1)]
    return "\n".join([heading, *(f"{t:.4f},{50 * math.sin(2 * math.pi * t):.6f}" for t in times)]) + "\n"


def test_knee_study_has_the_known_answer(walked):
    outcome, _, said = walked
    assert (outcome.code, outcome.err) == (0, "")
    drives = said["duty"]["walking"]["drives"]
    assert list(drives) == ["cobotic", "geared"]
    assert all(drive["feasible"] for drive in drives.values())
    # 5.755 and 5.294 J without the bearings of pulley and cylinder.
    assert drives["geared"]["energy_per_cycle_J"] == pytest.approx(5.786, rel=1e-3)
    assert drives["cobotic"]["energy_per_cycle_J"] == pytest.approx(5.698, rel=1e-3)
    assert "not counted" not in said["verdict"]


def test_energies_add_up_in_the_json(walked):
    for drive in walked[2]["duty"]["walking"]["drives"].values():
        given = drive["energy_per_cycle_J"] + drive["work_of_load_J"] - drive["work_on_load_J"]
        assert sum(drive["losses_J"].values()) == pytest.approx(
            given, rel=1e-4
        )  # but for jumps of the angle at reversals
        assert drive["closure"] < 1e-9
        assert drive["energy_per_hour_Wh"] == pytest.approx(drive["energy_per_cycle_J"] / drive["period_s"])
        assert drive["heat"]["motor"]["winding_C"] < drive["heat"]["motor"]["permissible_C"]
        assert drive["demands"]["THERMAL (motor)"] < 1 < 1.5 * drive["peak_torque_over_continuous"]["motor"] + 1


def test_cylinder_speed_is_worth_something(walked):
    drives = walked[2]["duty"]["walking"]["drives"]
    assert drives["geared"]["cylinder"] == []
    powers = [policy["power_W"] for policy in drives["cobotic"]["cylinder"]]
    assert len(powers) == 4
    assert powers[2] < powers[1] < powers[0]


@pytest.mark.slow
def test_prescribed_and_followed_stand_side_by_side(walked, followed):
    """The rest is the same: nothing but the simulation is left out of what the other tests look at."""
    assert "Prescribed and simulated motion" in (followed[1] / "report.html").read_text("utf-8")
    for name, drive in followed[2]["duty"]["walking"]["drives"].items():
        both = drive.pop("simulated")
        plain = {
            key: value for key, value in walked[2]["duty"]["walking"]["drives"][name].items() if key != "simulated"
        }
        assert drive == plain
        assert both["followed_J"] == pytest.approx(both["prescribed_J"], rel=0.1)
        assert "work on the load" in both["explanation"]


def test_holding_in_the_locked_state_is_free(walked):
    drives = walked[2]["duty"]["walking"]["drives"]
    assert drives["cobotic"]["holding"]["parked_W"] == 0.0
    assert drives["geared"]["holding"]["parked_W"] is None
    assert drives["geared"]["holding"]["power_W"] > 1.0


def test_report_reads_as_a_designer_would(walked):
    _, folder, said = walked
    page = (folder / "report.html").read_text("utf-8").replace("\N{NO-BREAK SPACE}", " ")
    for heading in (
        "Duty cycle: Level walking, 75 kg, 1.1 s per stride",
        "Energy from the battery",
        "Power",
        "Limits and heat",
        "Holding still",
        "Choice of cylinder speed",
    ):
        assert heading in page
    # The motion leads; requirement and maps come after.
    first = page.index('<p class="headline">Undecidable: Geared, DCX 32 L wins with ')
    assert first < page.index("Level walking, 75 kg, 1.1 s per stride: 2 of 2 drives are feasible; lowest energy: ")
    assert first < page.index("What this verdict hangs on") < page.index("Duty cycle: ")
    assert first < page.index("Duty cycle: ") < page.index("Required:") < page.index("Which drive loses least")
    assert "5.26 Wh" in page
    assert "Grimmer" in page
    figures = [
        f"report-{name}.{kind}" for name in ("maps", "least-loss", "losses", "duty-walking") for kind in ("png", "svg")
    ]
    tables = [
        "report.html",
        "results.json",
        "cobotic.nc",
        "geared.nc",
        "report-least-loss.nc",
        "cobotic-walking.csv",
        "geared-walking.csv",
    ]
    assert [Path(file).name for file in said["files"]] == [*tables, *figures]
    assert results(folder) == sorted([*tables, *figures])


def test_cycles_come_as_tables(walked):
    _, folder, said = walked
    with (folder / "cobotic-walking.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0])[:3] == ["time_s", "position_m", "speed_m_s"]
    assert {"steering_angle_rad", "motor_current_A", "power_from_supply_W"} <= set(rows[0])
    mean = sum(float(row["power_from_supply_W"]) for row in rows) / len(rows)
    drive = said["duty"]["walking"]["drives"]["cobotic"]
    assert mean * drive["period_s"] == pytest.approx(drive["energy_per_cycle_J"], rel=1e-6)


@pytest.mark.slow
def test_the_verdict_is_printed_before_what_completes_it(infinivar, monkeypatch):
    """The search for cylinder speeds, which the verdict does not need, takes longer than all before it."""
    said = []
    monkeypatch.setattr("infinivar.analysis.cycles.tracking.LONGEST", 0.0)
    monkeypatch.setattr(
        "infinivar.analysis.compare.policies", lambda drive, duty: said.append(sys.stdout.getvalue()) or ()
    )
    outcome = infinivar("compare", "knee_walking", "--out", "out")
    assert outcome.code == 0
    assert said == [outcome.out.splitlines(keepends=True)[0]]
    assert said[0].startswith("Undecidable: ")


@pytest.mark.slow
def test_reach_and_hold(infinivar, tmp_path, monkeypatch):
    """Held under load the geared motor burns what a locked wheel does not; the cylinder that idles burns more than either."""
    # Simulating it and searching for cylinder speeds take most of the time.
    monkeypatch.setattr("infinivar.analysis.cycles.tracking.LONGEST", 4.0)
    monkeypatch.setattr("infinivar.analysis.compare.policies", lambda drive, duty: ())
    outcome = infinivar("compare", STUDIES / "reach_and_hold.toml", "--out", ".")
    assert (outcome.code, outcome.err) == (0, "")
    assert "Lift 200 mm in 0.6 s, hold for 1.5 s, lower, wait:" in outcome.out
    assert outcome.out.count("feasible; tightest limit: ") == 3
    said = json.loads((tmp_path / "results.json").read_text("utf-8"))
    drives = said["duty"]["reach-and-hold"]["drives"]
    assert all("longer than 4 s, the longest" in drive["simulated"]["left_out"] for drive in drives.values())
    held = {name: drive["holding"] for name, drive in drives.items()}
    assert held["cobotic"]["parked_W"] == 0.0 < held["geared"]["power_W"] < held["cobotic"]["power_W"]


@pytest.mark.slow
@pytest.mark.renders("svg")
def test_a_drive_that_cannot_do_the_cycle_decides(infinivar, write, tmp_path):
    (tmp_path / "motion.csv").write_text(wave().replace("50", "50"), "utf-8")
    study = RECORDED.format(more='cutoff = "5 Hz"\nforce = "-100 N"').replace('"20 N"', '"2 N"')
    outcome = infinivar("compare", write(study))
    assert outcome.code == 1
    assert "infeasible: motor continuous torque, " in outcome.out
    assert "the cycle exceeds the limits of the drive" in (tmp_path / "out" / "report.html").read_text("utf-8")


def test_gaps_are_reported_by_line(infinivar, write, tmp_path):
    lines = wave().splitlines()
    (tmp_path / "motion.csv").write_text("\n".join([*lines[:50], *lines[70:]]), "utf-8")
    outcome = infinivar("compare", write(RECORDED.format(more="")))
    assert outcome.code == 0
    assert "warning: duty.recorded: " in outcome.err
    assert "line 51: 0.105 s without data" in outcome.err


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (wave("time [s],position"), "line 1, column 'position': must state its unit, such as 'position [mm]'"),
        (wave().replace("0.0300,", "0.0030,"), "line 8, column 'time [s]': must have a later time than the row above"),
        (
            wave().replace("0.0300,", "0.0300,nan,"),
            "line 8, column 3: has no heading: line 1 has 2 headings, this line 3 cells",
        ),
        ("", "line 1: must name the columns, but the file is empty"),
        (None, "no such file"),
    ],
)
def test_wrong_recordings_are_refused_by_line(infinivar, write, tmp_path, text, said):
    if text is not None:
        (tmp_path / "motion.csv").write_text(text, "utf-8")
    outcome = infinivar("compare", write(RECORDED.format(more="")))
    assert (outcome.code, outcome.out) == (2, "")
    assert said in outcome.err
    assert "study.toml: duty.recorded: " in outcome.err
    assert "motion.csv" in outcome.err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ('cutof = "5 Hz"', "duty.recorded.cutof"),
        ('cutoff = "5 rad/s"', "duty.recorded.cutoff"),
        ('pause = "1 s"', "pause does not apply with shape = 'file'; remove it"),
        ('base = "faulring2006.shak"', "is not a shipped duty cycle (did you mean 'faulring2006.shake'?)"),
    ],
)
def test_mistakes_in_the_table(infinivar, write, tmp_path, more, said):
    (tmp_path / "motion.csv").write_text(wave(), "utf-8")
    outcome = infinivar("compare", write(RECORDED.format(more=more)))
    assert (outcome.code, outcome.out) == (2, "")
    assert said in outcome.err


@pytest.mark.parametrize("stated", ["", 'output_inertia = "0 g m^2"'])
def test_the_rotor_is_inertia_enough(infinivar, write, stated):
    study = f"""
[drives.mine]
type = "conventional"
{stated}
motor = {{ part = "dcx-26-l-24v" }}
gearhead = {{ part = "gpx-22-up-3-9" }}
pulley = {{ radius = "5 mm" }}
[duty.hold]
shape = "hold"
time = "1 s"
force = "-5 N"
"""
    outcome = infinivar("compare", write(study), "--quick")
    assert (outcome.code, outcome.err) == (0, "")
    assert "is feasible with " in outcome.out


def test_json_has_the_warnings_that_results_have(walked):
    assert walked[2]["warnings"] == json.loads((walked[1] / "results.json").read_text("utf-8"))["warnings"]


def test_the_report_says_what_its_numbers_are(walked):
    page = (walked[1] / "report.html").read_text("utf-8").replace("\xa0", " ")
    (still,) = re.findall(r"<h3>Holding still</h3>\s*<p class=\"soft\">(.*?)</p>", page, re.DOTALL)
    assert "with windings at 25 °C" in still
    assert "root mean square of the current; peak " in page
    assert not re.search(r"[a-z] 0 J[,<]", page)
