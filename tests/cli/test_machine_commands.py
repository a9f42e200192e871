"""Commands on machines: the ones that work, and the one message of those that do not."""

import json

import pytest

from folders import results
from machine_studies import EVERY, PLATFORM
from pages import needs_no_network
from sampled import sampled
from small_catalogue import SLOW

FIGURES = {
    "platform": ["losses", "path-circle", "positions", "machine-cobotic", "wrenches-cobotic"],
    "arm": ["losses", "path-reach", "positions", "machine-cobotic", "machine-separate"],
    "sphere": ["losses", "sphere-ball", "machine-ball"],
    "planar": ["losses", "machine-cart", "machine-two"],
}


@pytest.fixture
def write(tmp_path):
    def write_study(text):
        (tmp_path / "mine.toml").write_text(text, "utf-8")

    return write_study


@sampled("name", EVERY, every=2)
def test_check_and_compare(name, write, infinivar, tmp_path):
    write(EVERY[name])
    assert "no faults found" in infinivar("check", "mine.toml").out
    outcome = infinivar("compare", "mine.toml", "--out", "out")
    assert (outcome.code, outcome.err) == (0, "")
    assert "tightest limit" in outcome.out
    names = results(tmp_path / "out")
    assert {"report.html", "results.json"} <= {*names}
    assert [one for one in names if one.endswith(".svg")] == sorted(f"report-{one}.svg" for one in FIGURES[name])
    page = (tmp_path / "out" / "report.html").read_text("utf-8")
    needs_no_network(tmp_path / "out" / "report.html")
    for words in ("Verdicts", "Source of every value", "parts and limits", "tightest limit"):
        assert words in page
    assert "nan" not in page.replace("nance", "")


def test_json_has_every_number(write, infinivar):
    write(PLATFORM)
    outcome = infinivar("compare", "mine.toml", "--quick", "--json")
    said = json.loads(outcome.out)
    assert said["drives"]["cobotic"]["tasks"]["lift"]["parts"]["leg 1"]["loss_W"] > 0.0
    assert said["drives"]["separate"]["paths"]["circle"]["energy_J"] > 0.0
    assert said["best"] == "separate"  # at steady points: cobotic
    power = {name: one["steady_power_W"] for name, one in said["drives"].items()}
    assert power["cobotic"] < power["separate"]
    assert "mass is missing" in said["verdict"]


def test_exit_code_says_that_no_machine_is_feasible(write, infinivar):
    write(PLATFORM.replace('y = "20 N", z = "20 N"', 'y = "900 N"'))
    outcome = infinivar("compare", "mine.toml", "--quick")
    assert outcome.code == 1
    assert "None of the 2 machines is feasible" in outcome.out


def test_sensitivity_of_a_task(write, infinivar):
    write(EVERY["planar"])
    outcome = infinivar("sensitivity", "mine.toml", "--of", "power", "--drive", "cart", "--task", "turn")
    assert (outcome.code, outcome.err) == (0, "")
    assert "wheel.wheel_radius (0.03 m): -" in outcome.out
    outcome = infinivar("sensitivity", "mine.toml", "--of", "efficiency", "--drive", "cart")
    assert (outcome.code, outcome.out) == (2, "")
    assert "must be one of power, loss, margin" in outcome.err
    for option, value in (("--out", "here"), ("--force", "2 N"), ("--method", "jax"), ("--duty", "d")):
        outcome = infinivar("sensitivity", "mine.toml", "--of", "power", "--drive", "cart", option, value)
        assert (outcome.code, outcome.out) == (2, "")
        assert (
            f"{option} is of drives of one axis; of a machine, sensitivity takes --of, --drive, --task and --json"
            in outcome.err
        )
    outcome = infinivar("sensitivity", "mine.toml", "--of", "loss", "--drive", "cart", "--task", "trun")
    assert "did you mean 'turn'" in outcome.err


def test_a_cart_is_not_simulated(write, infinivar):
    write(EVERY["planar"])
    outcome = infinivar("simulate", "mine.toml", "--drive", "cart")
    assert (outcome.code, outcome.out) == (2, "")
    assert "mine.toml: drives.cart is a machine of type planar: a user pushes it" in outcome.err
    assert outcome.err.rstrip().endswith("commands for this machine: check, compare, sensitivity, export, session")


@pytest.mark.parametrize("name", EVERY)
@pytest.mark.parametrize(
    "command",
    [
        ("graph",),
        ("export", "--as", "mujoco"),
        ("rig",),
        ("contact", "--drive"),
        ("sweep", "size"),
    ],
)
def test_one_message_where_a_command_does_not_work(name, command, write, infinivar, tmp_path):
    write(EVERY[name])
    first = {"platform": "cobotic", "arm": "cobotic", "sphere": "ball", "planar": "cart"}[name]
    if command[0] == "contact":
        if first == "cobotic":
            pytest.skip("legs have a wheel on a cylinder")
        command = (*command, first)
    if command[0] == "sweep":
        arguments = ("sweep", "builds", "mine.toml", "--folder", "sweep")
    elif command[0] in ("graph", "export"):
        arguments = (command[0], "mine.toml", first, *command[1:])
    else:
        arguments = (command[0], "mine.toml", *command[1:])
    outcome = infinivar(*arguments)
    assert outcome.code == 2, outcome
    (line,) = [one for one in outcome.err.splitlines() if "no --drive given" not in one]
    assert f"mine.toml: drives.{first} is a machine of type {name}" in line
    works = line.split("commands for this machine: check, compare")[1].split(", ")
    assert ("session" in works) == (name != "sphere")
    assert command[0] not in works


def test_machines_are_sized_to_study_files_or_the_nearest_miss_with_exit_code_1(write, infinivar, tmp_path):
    write(EVERY["arm"])
    (tmp_path / "parts.toml").write_text(SLOW, "utf-8")
    arguments = ("size", "mine.toml", "--drive", "separate", "--set", "parts.toml", "--out", "out", "--json")
    outcome = infinivar(*arguments)
    assert outcome.code == 0, outcome
    found = json.loads(outcome.out)
    assert set(found["designs"][0]["parts"]) == {"separate.motor", "separate.gearhead"}
    compared = infinivar("compare", "out/design-01.toml", "--json", "--quick")
    assert compared.code == 0, compared
    power = found["designs"][0]["power_W"]
    there = json.loads(compared.out)["drives"]["separate"]
    # Without shares of time both count alike.
    both = there["tasks"]["push"]["power_in_W"], there["paths"]["reach"]["mean_power_W"]
    assert sum(both) / 2 == pytest.approx(power, rel=1e-9)
    page = (tmp_path / "out" / "sizing.html").read_text("utf-8")
    assert found["best_of"]["separate"]["parts"]["separate.motor"]["name"] in page
    write(EVERY["arm"].replace('x = "3 N"', 'x = "3000 N"'))
    outcome = infinivar(*arguments[:-3], "--out", "none")
    assert outcome.code == 1, outcome
    assert "nearest miss" in outcome.out
    assert "Note: the nearest miss like separate" in outcome.out
