"""`infinivar measured list|check|report`: what they print, and exit codes."""

import json

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
