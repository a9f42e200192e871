"""`infinivar measured list|add|check|report`: what they print, and exit codes."""

import json
import math

import pytest

ROWS = "\n".join(f"{speed},{(8e-3 + 2e-5 * speed) / 0.05 + 1e-3 * (-1) ** speed}" for speed in range(10, 40))
SET = """
title = "Made"
bench = "no_load"
source = "made up"
licence = "CC0"
[known]
torque_constant = "50 mN m/A"
[goal]
current = "0.002 A"
"""


@pytest.fixture
def folder(tmp_path):
    made = tmp_path / "mine"
    made.mkdir()
    (made / "measured.toml").write_text(SET, "utf-8")
    (made / "rows.csv").write_text(f"speed [rad/s],current [A]\n{ROWS}\n", "utf-8")
    return made


def test_list_names_sets_and_licences(infinivar):
    done = infinivar("measured", "list")
    assert done.code == 0
    assert "screws_and_worm: " in done.out
    assert "GPL-3.0" in done.out
    assert {"name", "title", "bench", "licence"} == set(json.loads(infinivar("measured", "list", "--json").out)[0])


def test_check_of_sound_and_of_misread_rows(infinivar, folder):
    done = infinivar("measured", "check", folder)
    assert (done.code, done.out) == (0, "mine: 30 rows, no faults\n")
    (folder / "rows.csv").write_text(f"speed [rad/s],current [A]\n{ROWS}\n20,170\n", "utf-8")
    done = infinivar("measured", "check", folder, "--json")
    assert done.code == 1
    assert "line 32: current is 170 A" in json.loads(done.out)["faults"][0]


def test_report_begins_with_residual_and_goal(infinivar, folder):
    first = infinivar("measured", "report", folder).out.splitlines()[0]
    assert first.startswith("mine: current 0.000998 A rms")
    assert first.endswith("goal 0.002 A, met")
    found = json.loads(infinivar("measured", "report", folder, "--predict", folder / "rows.csv", "--json").out)
    assert found["totals"][0]["goal_met"] is True
    (part,) = found["parts"]
    assert part["predicted"][0]["rows"] == 30
    assert "motor_friction" in part["parameters"]


def test_an_unknown_set_is_refused(infinivar, tmp_path):
    done = infinivar("measured", "report", "screws_and_worms")
    assert done.code == 2
    assert "screws_and_worm" in done.err


START = """[start]
motor_friction = "8 mN m"
motor_viscous = "2e-5 N m s"
"""


def described(folder, rows=ROWS, head="speed [rad/s],current [A]", toml=SET + START):
    (folder / "measured.toml").write_text(toml, "utf-8")
    (folder / "rows.csv").write_text(f"{head}\n{rows}\n", "utf-8")
    return folder


@pytest.fixture
def own(tmp_path, monkeypatch):
    monkeypatch.setenv("INFINIVAR_MEASURED", str(tmp_path / "own"))
    return tmp_path / "own"


def test_a_set_that_is_added_is_known_by_name(infinivar, folder, own):
    described(folder)
    done = infinivar("measured", "add", folder)
    assert (done.code, done.out) == (0, f"mine: 30 rows added (made up, CC0) to {own / 'mine'}\n")
    assert "mine: Made (made up, CC0; bench no_load)" in infinivar("measured", "list").out
    assert infinivar("measured", "check", "mine").out == "mine: 30 rows, no faults\n"
    assert infinivar("measured", "report", "mine").out.startswith("mine: current 0.000998 A rms")
    again = infinivar("measured", "add", folder)
    assert (again.code, "there is such a set already" in again.err) == (2, True)
    assert infinivar("measured", "add", folder / "rows.csv", "--name", "other").code == 0
    assert sorted(one.name for one in own.iterdir()) == ["mine", "other"]
    assert sorted(one.name for one in (own / "other").iterdir()) == ["measured.toml", "rows.csv"]


PAIRS = [tuple(map(float, line.split(","))) for line in ROWS.splitlines()]


def changed(of):
    return "\n".join(f"{speed:.8g},{current:.8g}" for speed, current in (of(*pair) for pair in PAIRS))


DRIFTING = "\n".join(
    f"{speed},{current + 0.2 * place / 30}"
    for place, (speed, current) in enumerate(PAIRS[7 * k % 30] for k in range(30))
)
"""Speeds in mixed order, and a sensor that drifts by 0.2 A from the first row to the last."""


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"rows": changed(lambda w, i: (i, w))}, "speed and current fit if their columns are exchanged"),
        ({"rows": changed(lambda w, i: (w, 1e3 * i))}, "current fits if divided by 1000: is it in thousandths"),
        ({"rows": changed(lambda w, i: (w * 30 / math.pi, i))}, "speed fits if divided by 9.549: is it in rpm?"),
        ({"rows": DRIFTING}, "lines 2 to 31: current drifts by 0.1"),
        ({"rows": DRIFTING}, "expected: residuals without a trend"),
        ({"rows": changed(lambda w, i: (i, w))}, "rows.csv: lines 2 to 31: "),
        (
            {"rows": changed(lambda w, i: (i, w))},
            "expected: by [start], motor_friction near 0.008 N m, motor_viscous near 2e-5 N m s",
        ),
        ({"head": "speed [rad/s],current"}, "must state its unit"),
        ({"head": "speed [rad/s],current [V]"}, "current"),
        ({"head": "speed [rad/s],amps [A]"}, "has no column current"),
        ({"toml": SET}, "[start] is missing"),
        ({"toml": SET.replace('licence = "CC0"', "") + START}, "licence is missing"),
        ({"toml": SET.replace('source = "made up"', "") + START}, "source is missing"),
        ({"toml": 'rows = "../rows.csv"\n' + SET + START}, "no such file"),
    ],
)
def test_a_misread_set_is_refused_and_nothing_is_written(infinivar, folder, own, change, said):
    done = infinivar("measured", "add", described(folder, **change))
    assert done.code == 2
    assert said in done.err
    assert not own.exists()
