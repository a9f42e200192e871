"""`infinivar sensitivity`, and `infinivar compare` of a study with tolerances."""

import json

import pytest

from sampled import sampled

STUDY = """
[requirement]
base = "faulring2006"
[drives.cobotic]
base = "faulring2006.cobotic"
[duty.shake]
base = "faulring2006.shake"
[uncertainty]
draws = 16
[uncertainty.cobotic.transmission]
friction = { low = 0.07, high = 0.13, where = "dry steel" }
[uncertainty.cobotic.gearhead]
efficiency = { deviation = 0.02 }
"""


@pytest.mark.slow
@pytest.mark.renders
def test_a_ranking_in_words_figures_and_numbers(infinivar, write, tmp_path):
    done = infinivar(
        "sensitivity", write(STUDY), "--of", "loss", "--force", "20 N", "--speed", "0.3 m/s", "--out", "out"
    )
    assert done.code == 0, done.err
    assert "loss at 20 N, 0.3 m/s: " in done.out
    assert "1. gearhead efficiency: +1 % lowers the loss by " in done.out
    assert "higher friction, less preload" in done.out
    found = json.loads((tmp_path / "out" / "sensitivity-loss.json").read_text("utf-8"))
    by_path = {row["path"]: row for row in found["parameters"]}
    assert by_path["transmission.preload"]["range_stated"] is False
    assert by_path["gearhead.efficiency"]["range_stated"] is True
    assert by_path["gearhead.efficiency"]["elasticity"] < 0 < by_path["motor.resistance"]["elasticity"]
    page = (tmp_path / "out" / "sensitivity-loss.html").read_text("utf-8")
    assert "Recommendations of the paper" in page
    for kind in ("png", "svg"):
        assert (tmp_path / "out" / f"sensitivity-loss.{kind}").exists()


@pytest.mark.full
def test_what_is_ranked_by_default(infinivar, write):
    """The energy of a duty cycle, else the margin of a requirement."""
    assert infinivar("sensitivity", write(STUDY), "--out", "out").out.startswith("energy per cycle of ")
    assert infinivar("sensitivity", write(GEARED), "--out", "out").out.startswith("tightest margin ")


GEARED = """
[requirement]
base = "faulring2006"
[drives.geared]
base = "faulring2006.motor1-gear2"
"""


def test_a_ranking_beyond_the_limits_is_labelled(infinivar, write, tmp_path):
    """A ranking at an efficiency of 4e-8 was printed without a word."""
    command = ("sensitivity", write(GEARED), "--of", "efficiency", "--force", "1e9 N", "--out", "out")
    done = infinivar(*command)
    assert done.code == 1, done.err
    assert "limit exceeded" in done.out
    assert "The drive exceeds its limits, so these numbers describe an infeasible operation: " in done.out
    assert "supply voltage" in done.out
    assert "The drive exceeds its limits, so these numbers describe an infeasible operation: " in (
        tmp_path / "out" / "sensitivity-efficiency.html"
    ).read_text("utf-8")
    assert "supply voltage" in json.loads(infinivar(*command, "--json").out)["beyond_limits"]


WEAK = GEARED.replace("gear2", "gear1")


@sampled("question", ["margin", "coverage"], slow=2)
def test_a_region_that_is_not_covered_is_labelled(infinivar, write, tmp_path, question):
    """A margin of 0.4 was printed with exit code 0."""
    done = infinivar("sensitivity", write(WEAK), "--of", question, "--json")
    assert done.code == 1, done.err
    found = json.loads(done.out)
    assert found["value"] < 1.0
    assert "times the allowance" in found["beyond_limits"]
    assert "The drive exceeds its limits: " in found["remarks"][0]
    done = infinivar(
        "sensitivity",
        write(WEAK.replace("[drives", 'power = "1 W"\nforce = "1 N"\nspeed = "0.05 m/s"\n[drives')),
        "--of",
        question,
    )
    assert done.code == 0, done.err
    assert "beyond" not in done.out


HOT = """
[requirement]
force = "150 N"
speed = "0.4 m/s"
power = "30 W"
[drives.geared]
type = "conventional"
output_inertia = "0.02 g m^2"
motor = { part = "re-40-24v" }
gearhead = { part = "gp-42-c-12" }
pulley = { radius = "10 mm" }
[duty.push]
force = "%s N"
time = "1 s"
[uncertainty.geared.motor]
continuous_torque = "10 %%"
resistance = "60 %%"
"""


@pytest.mark.slow
def test_a_temperature_without_end(infinivar, write, tmp_path):
    """The figure was to be drawn to infinity: a fault of the program."""
    command = ("sensitivity", write(HOT % 600), "--of", "temperature", "--out", "out")
    done = infinivar(*command)
    assert done.code == 2
    assert "unbounded, so parameters cannot be ranked: " in done.err
    assert "motor winding temperature grows without bound; limit 155 °C exceeded after " in done.err
    assert not (tmp_path / "out").exists()


@pytest.mark.full
@pytest.mark.renders("svg")
def test_a_temperature_without_end_within_a_range(infinivar, write, tmp_path):
    done = infinivar("sensitivity", write(HOT % 440), "--of", "temperature", "--out", "out")
    assert done.code == 1, done.err
    assert "; unbounded at one end of " in done.out
    assert "motor winding reaches" in done.out
    page = (tmp_path / "out" / "sensitivity-temperature.html").read_text("utf-8")
    assert "infinite" in page


def test_a_range_that_does_nothing_is_not_said_to_be_missing(infinivar, write, tmp_path):
    done = infinivar("sensitivity", write(HOT % 10), "--of", "efficiency", "--out", "out")
    assert "parameters without a range in the study are varied by ± 10 %" in done.out
    assert "Parameters with a stated range that have no effect here: motor.continuous_torque." in done.out


@pytest.mark.slow
def test_numbers_alone(infinivar, write):
    done = infinivar("sensitivity", write(STUDY), "--of", "efficiency", "--method", "difference", "--json")
    assert json.loads(done.out)["of"] == "efficiency"


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (
            ("--of", "energie"),
            "'energie' is not one of efficiency, loss, margin, coverage, energy, temperature (did you mean",
        ),
        (
            ("--of", "power"),
            "--of power is of machines; the study has no tasks or paths: use energy, or loss at a point",
        ),
        (("--task", "push"), "--task 'push' is of machines; the study has no tasks or paths"),
        (("--of", "energy", "--duty", "walk"), "unknown duty cycle 'walk'"),
        (("--of", "loss", "--force", "20"), "--force '20' needs a unit"),
        (("--of", "loss", "--speed", "3 N"), "--speed '3 N' has the unit 'N' where m/s is needed"),
        (("--of", "loss", "--force", "500 N"), "infeasible, so parameters cannot be ranked"),
        (("--of", "loss", "--method", "adjoint"), "--method 'adjoint' must be one of complex, jax, difference"),
        (("--of", "loss", "--drive", "geared"), "--drive 'geared' is not in the study"),
    ],
)
def test_questions_that_mean_nothing(infinivar, write, tmp_path, options, said):
    done = infinivar("sensitivity", write(STUDY), *options, "--out", "out")
    assert done.code == 2
    assert said in done.err
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
@pytest.mark.renders("svg")
def test_a_comparison_says_how_many_builds_are_able(infinivar, write, tmp_path):
    done = infinivar("compare", write(STUDY), "--out", "out", "--json")
    assert done.code in (0, 1), done.err
    found = json.loads(done.out)["builds"]["cobotic"]
    assert found["builds"] == 16
    assert 0.0 < found["covering"] < 1.0
    assert found["weakest_margin"]["low"] < found["weakest_margin"]["median"] < found["weakest_margin"]["high"]
    assert found["duty"]["shake"]["energy_J"]["low"] < found["duty"]["shake"]["energy_J"]["high"]
    page = (tmp_path / "out" / "report.html").read_text("utf-8")
    assert "Samples within tolerances" in page
    assert "dry steel" in page
