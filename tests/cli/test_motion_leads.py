"""`infinivar compare` where motions lead: without a requirement, with shares, and about a joint."""

import json

import pytest

from folders import results
from sampled import sampled

DRIVES = """
[drives.light]
base = "faulring2006.motor2-gear4"
[drives.heavy]
base = "faulring2006.cobotic"
"""
MOTION = """
[duty.reaching]
shape = "reaches"
distance = "50 mm"
time = "0.4 s"
load_mass = "0.5 kg"
{more}
"""
HOLDING = """
[duty.holding]
shape = "hold"
time = "1 s"
force = "-10 N"
{more}
"""


def study(more="", rest=""):
    return MOTION.format(more=more) + rest + DRIVES


@pytest.mark.slow
@pytest.mark.renders("svg")
def test_a_motion_is_enough(infinivar, write, tmp_path, monkeypatch):
    # Simulating it and searching for cylinder speeds take most of the time.
    monkeypatch.setattr("infinivar.analysis.cycles.tracking.LONGEST", 0.1)
    monkeypatch.setattr("infinivar.analysis.compare.policies", lambda drive, duty: ())
    outcome = infinivar("compare", write(study('distance_per_cycle = "0.1 m"')), "--out", "out")
    assert (outcome.code, outcome.err) == (0, "")
    first, second, *rest = outcome.out.splitlines()
    assert "reaching: 2 of 2 drives are feasible; lowest energy: " in first
    assert second == "reaching:"
    assert all("J/m, " in line for line in rest[:2])
    assert "required region" not in outcome.out
    made = results(tmp_path / "out")
    assert "report-losses.svg" not in made
    assert {"report-least-loss.svg", "report-least-loss.nc", "report-maps.svg", "light.nc"} <= set(made)
    page = (tmp_path / "out" / "report.html").read_text("utf-8").replace("\N{NO-BREAK SPACE}", " ")
    assert page.index(first[:40]) < page.index("Duty cycle: ") < page.index("Which drive loses least")
    for absent in ("Required:", "required region", "Losses at the corners", "nan"):
        assert absent not in page.split("<h2>Source")[0]
    assert json.loads((tmp_path / "out" / "results.json").read_text("utf-8"))["requirement"] is None


def test_quick_and_json_answer_the_same(infinivar, write):
    name = write(study("time_share = 0.6", HOLDING.format(more='time_share = "40 %"')))
    lines = infinivar("compare", name, "--quick").out.splitlines()
    said = json.loads(infinivar("compare", name, "--quick", "--json").out)
    assert lines[0] == said["verdict"]
    assert lines[0].startswith("Mixed use (60 % reaching, 40 % holding): 2 of 2 drives are feasible; lowest energy: ")
    assert lines[1] == "Mixed use, 60 % reaching, 40 % holding:"
    assert said["mixed_use"]["best"] == said["best"]
    for drive in said["mixed_use"]["drives"].values():
        assert any(line.endswith(drive["verdict"]) for line in lines)
    for name, drive in said["mixed_use"]["drives"].items():
        powers = [said["duty"][task]["drives"][name]["power_from_supply_net_W"] for task in ("reaching", "holding")]
        assert drive["power_W"] == pytest.approx(0.6 * powers[0] + 0.4 * powers[1], rel=1e-12)


@sampled(
    ("text", "code"),
    [
        (study(), 0),
        (study('force = "-500 N"'), 1),  # no drive follows the motion
        (study() + '[requirement]\nforce = "5 N"\nspeed = "0.1 m/s"\n', 0),
        (study() + '[requirement]\nforce = "900 N"\nspeed = "1 m/s"\n', 1),  # none covers what is required beside it
    ],
    every=2,
)
def test_the_exit_code_is_about_motions_and_requirement(infinivar, write, text, code):
    outcome = infinivar("compare", write(text), "--quick", "--json")
    assert outcome.code == code
    assert json.loads(outcome.out)["feasible"] is (code == 0)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (DRIVES, "requirement is missing: write a table [requirement], or a motion in a table [duty.NAME]"),
        (
            study("time_share = 0.6", HOLDING.format(more="")),
            "duty.holding.time_share is missing: duty.reaching has one",
        ),
        (
            study("time_share = 0.6", HOLDING.format(more="time_share = 0.6")),
            "the shares add up to 120 %, not to 100 %",
        ),
        (study("time_share = 1.5"), "duty.reaching.time_share = 1.5 must be > 0 and <= 1"),
        (study('distance_per_cycle = "0 m"'), "duty.reaching.distance_per_cycle"),
    ],
)
def test_refuses(infinivar, write, text, said):
    outcome = infinivar("check", write(text))
    assert (outcome.code, outcome.out) == (2, "")
    assert said in outcome.err


def test_sensitivity_says_what_to_add(infinivar, write, tmp_path):
    name = write(study())
    outcome = infinivar("sensitivity", name, "--drive", "light", "--of", "coverage")
    assert (outcome.code, outcome.out) == (2, "")
    assert "coverage: the study has no requirement; add a table [requirement] with force and speed" in outcome.err
    outcome = infinivar("sensitivity", name, "--drive", "light", "--of", "loss", "--moment", "2 N m")
    assert "--moment '2 N m' does not apply to a drive along a line; use --force" in outcome.err
    assert not (tmp_path / "out").exists()
    outcome = infinivar("sensitivity", name, "--drive", "light", "--of", "loss", "--force", "9 N", "--speed", "0.2 m/s")
    assert outcome.code == 0
    assert outcome.out.startswith("loss at 9 N, 0.2 m/s: ")


def test_sensitivity_about_a_joint(infinivar, write):
    text = """
        requirement = { moment = "2 N m", angular_speed = "60 rpm", power = "6 W" }
        [drives.knee]
        base = "faulring2006.motor2-gear4"
        output = { linkage = { arm = "50 mm" } }
    """
    name = write(text)
    outcome = infinivar("sensitivity", name, "--of", "loss", "--moment", "1 N m", "--angular-speed", "30 rpm")
    assert (outcome.code, outcome.err) == (0, "")
    assert outcome.out.startswith("loss at 1 N m, 3.14 rad/s: ")
    outcome = infinivar("sensitivity", name, "--of", "loss", "--speed", "0.2 m/s")
    assert "--speed '0.2 m/s' does not apply to a drive about a joint; use --angular-speed" in outcome.err
    outcome = infinivar("compare", name, "--quick")
    assert outcome.code in (0, 1)
    assert " N m, " in outcome.out
    assert " m/s" not in outcome.out
