"""`infinivar simulate` of machines: files, words, JSON, exit codes, and every typical mistake in one line."""

import json

import pytest

from folders import results
from machine_studies import ARM, PLATFORM, SPHERE
from pages import needs_no_network

MASSES = 'member_masses = ["0.4 kg", "0.3 kg"]'
MOVED = ARM.replace("[drives.cobotic.leg]", f"{MASSES}\n[drives.cobotic.leg]")
BODY = 'mass = "0.3 kg"\ninertia = ["1.5e-4 kg m^2", "1.5e-4 kg m^2", "3e-4 kg m^2"]'
HEAVY = PLATFORM.replace('title = "six legs, one motor"', f'title = "six legs, one motor"\n{BODY}')


def alone(text):
    """A study without its second drive, which is like the first one, with its faults."""
    begin, end = text.index("[drives.separate]"), text.index("[tasks.")
    return text[:begin] + text[end:]


@pytest.fixture
def write(tmp_path):
    def write_study(text):
        (tmp_path / "mine.toml").write_text(text, "utf-8")

    return write_study


def test_files_and_words_of_a_task(write, infinivar, tmp_path):
    write(MOVED)
    outcome = infinivar("simulate", "mine.toml", "--drive", "separate", "--task", "push", "--out", "out")
    assert (outcome.code, outcome.err) == (0, "")
    assert outcome.out.startswith("separate, push: within limits after 0.1 s of settling; position error ")
    assert "W for power; energy balance closed to 1e-6" in outcome.out
    names = results(tmp_path / "out")
    assert {f"separate-push.{kind}" for kind in ("html", "json", "csv", "nc")} <= {*names}
    assert {"separate-push-history.svg", "separate-push-energy.svg"} <= {*names}
    needs_no_network(tmp_path / "out" / "separate-push.html")
    page = (tmp_path / "out" / "separate-push.html").read_text("utf-8")
    assert "a wheel slips" not in page
    assert "currents" in page
    first = (tmp_path / "out" / "separate-push.csv").read_text("utf-8").splitlines()[0]
    assert {"time_s", "q1_rad", "motor_2_current_A"} <= set(first.split(","))


@pytest.mark.slow
def test_json_has_the_mean_powers_and_the_balance(write, infinivar):
    write(HEAVY)
    outcome = infinivar("simulate", "mine.toml", "--drive", "cobotic", "--task", "hold", "--json")
    assert outcome.code == 0, outcome.err
    said = json.loads(outcome.out)
    assert said["feasible"]
    assert said["closure"] < 1e-6
    assert {*said["mean_power_W"]} == {"supply", "steering supply"}
    compared = json.loads(infinivar("compare", "mine.toml", "--quick", "--json").out)
    steady = compared["drives"]["cobotic"]["tasks"]["hold"]["power_in_W"]
    assert said["mean_power_W"]["supply"] == pytest.approx(steady, rel=5e-3)
    assert said["files"][0].endswith("cobotic-hold.html")


@pytest.mark.slow
def test_a_limit_that_is_exceeded_exits_with_1(write, infinivar):
    write(HEAVY.replace('wrench = { z = "30 N" }', 'wrench = { z = "900 N" }'))
    outcome = infinivar("simulate", "mine.toml", "--drive", "cobotic", "--task", "hold")
    assert outcome.code == 1
    assert "wheel slip" in outcome.out


@pytest.mark.slow
def test_without_names_the_first_machine_and_path_are_meant(write, infinivar):
    quick = MOVED.replace('time = "0.5 s", pause = "0.2 s"', 'time = "30 ms", pause = "20 ms"').replace(
        "60 mm", "0.5 mm"
    )
    write(quick)
    outcome = infinivar("simulate", "mine.toml")
    assert outcome.code == 0, outcome.out
    assert "no --drive given: using cobotic" in outcome.err
    assert "no --task given: using paths.reach, the first of paths.reach, tasks.push" in outcome.err
    assert outcome.out.startswith("cobotic, reach: within limits after 0.1 s of settling")


WRONG = {
    "no masses": (ARM, (), "drives.cobotic, paths.reach: member_masses is missing"),
    "no mass": (PLATFORM, (), "drives.cobotic, paths.circle: mass is missing"),
    "no inertia": (SPHERE, (), "drives.ball, tasks.turn: input_inertia is missing"),
    "too few masses": (
        alone(MOVED).replace('"0.4 kg", ', ""),
        (),
        "drives.cobotic.member_masses must be 2, one for each member",
    ),
    "a mass below 0": (alone(MOVED).replace("0.4 kg", "-0.4 kg"), (), "drives.cobotic.member_masses"),
    "no mass at the end": (alone(MOVED).replace("0.3 kg", "0 kg"), (), "drives.cobotic.member_masses must be > 0 kg"),
    "masses in metres": (alone(MOVED).replace("0.4 kg", "0.4 m"), (), "drives.cobotic.member_masses"),
    "one mass": (alone(MOVED).replace(MASSES, 'member_masses = "0.4 kg"'), (), "drives.cobotic.member_masses"),
    "a platform without mass": (
        alone(HEAVY).replace('"0.3 kg"', '"0 kg"'),
        (),
        'drives.cobotic.mass = "0 kg" must be > 0 kg',
    ),
    "two inertias": (alone(HEAVY).replace('"1.5e-4 kg m^2", ', "", 1), (), "drives.cobotic.inertia must be three"),
    "an inertia of 0": (alone(HEAVY).replace("3e-4 kg m^2", "0 kg m^2"), (), "drives.cobotic.inertia"),
    "an inertia in kg": (alone(HEAVY).replace("3e-4 kg m^2", "3e-4 kg"), (), "drives.cobotic.inertia"),
    "a mass that is none": (alone(HEAVY).replace('"0.3 kg"', '"nan kg"'), (), "drives.cobotic.mass"),
    "a key of another": (alone(HEAVY).replace("mass =", "masses =", 1), (), "drives.cobotic.masses"),
    "a scenario": (MOVED, ("--scenario", "run"), "--scenario 'run' is of drives of one axis"),
    "an unknown task": (MOVED, ("--task", "pusch"), "did you mean 'push'"),
}


@pytest.mark.parametrize("name", WRONG)
def test_one_line_for_a_mistake(name, write, infinivar, tmp_path):
    text, more, said = WRONG[name]
    write(text)
    outcome = infinivar("simulate", "mine.toml", *more, "--out", "out")
    assert (outcome.code, outcome.out) == (2, "")
    line = [one for one in outcome.err.splitlines() if "given: using" not in one]
    assert len(line) == 1, outcome.err
    assert said in line[0]
    assert not results(tmp_path / "out") if (tmp_path / "out").exists() else True
