"""The command on sessions: verdict, measures, files, exit codes."""

import json

import pytest

import session_studies
from session_studies import tables


@pytest.fixture
def study(tmp_path):
    fast = {"x": "3 m/s", "y": "-4 m/s"}
    raw = tables(
        ("crash", {**session_studies.TASKS["wall"], "twist": fast, "duration": "30 ms"}),
    )
    path = tmp_path / "mine.toml"
    path.write_text(session_studies.text(raw), "utf-8")
    return path


def test_verdict_measures_and_files(infinivar, study, tmp_path):
    outcome = infinivar("session", study, "--task", "path", "--out", tmp_path / "out")
    lines = outcome.out.splitlines()
    assert (outcome.code, outcome.err) == (0, "")
    assert lines[0].startswith("cart, path: within limits; offset from the path ")
    assert "  largest offset from the path: " in outcome.out
    assert lines[-1].startswith("Report: ")
    assert lines[-1].endswith("cart-path.html")
    names = {file.name for file in (tmp_path / "out").iterdir()}
    assert {f"cart-path.{kind}" for kind in ("html", "json", "csv", "nc")} <= names
    assert {f"cart-path-{what}.svg" for what in ("motion", "history", "energy")} <= names


def test_json_and_the_exit_code_of_an_infeasible_session(infinivar, study, tmp_path):
    outcome = infinivar("session", study, "--task", "crash", "--out", tmp_path / "out", "--json")
    found = json.loads(outcome.out)
    assert outcome.code == 1
    assert found["feasible"] is False
    assert found["task"] == "wall"
    assert found["measures"]["penetration_mm"] > 1.0
    assert any(event["limit"] == "SLIP" for event in found["events"])
    assert found["closure"] < 1e-6
    assert found["files"][0].endswith("cart-crash.html")


def test_the_first_task_is_chosen_aloud(infinivar, study, tmp_path):
    outcome = infinivar("session", study, "--out", tmp_path / "out")
    assert outcome.err == "infinivar: no --task given: using path, the first of path, wall, free, crash\n"
    assert outcome.code == 0


def test_a_drive_that_is_not_there(infinivar, study, tmp_path):
    outcome = infinivar("session", study, "--task", "path", "--drive", "crat", "--out", tmp_path / "out")
    assert (outcome.code, outcome.out) == (2, "")
    assert "drive 'crat' is no drive of the study (did you mean 'cart'?); it has cart" in outcome.err
    assert not (tmp_path / "out").exists()


def test_results_replace_no_input(infinivar, study):
    study.rename(study.parent / "cart-path.json")
    outcome = infinivar("session", study.parent / "cart-path.json", "--task", "path", "--out", study.parent)
    assert outcome.code == 2
    assert "is the study itself, and the results" in outcome.err


def test_check_counts_sessions(infinivar, study):
    outcome = infinivar("check", study)
    assert (outcome.code, outcome.out) == (0, f"{study}: 1 drive, 4 sessions; no faults found\n")


@pytest.mark.parametrize(
    "command", [("compare",), ("compare", "--quick"), ("simulate",), ("sensitivity", "--of", "loss")]
)
def test_other_commands_say_what_runs_sessions(infinivar, study, command):
    outcome = infinivar(*command[:1], study, *command[1:])
    assert (outcome.code, outcome.out) == (2, "")
    assert "infinivar session" in outcome.err
    assert outcome.err.count("\n") == 1
