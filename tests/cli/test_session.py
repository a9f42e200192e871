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


@pytest.mark.slow
def test_a_video_and_a_scene_beside_the_report(infinivar, study, tmp_path):
    video, scene = tmp_path / "cart.gif", tmp_path / "made" / "cart.xml"
    given = ("--video", video, "--video-speed", "0.25", "--scene", scene)
    outcome = infinivar("session", study, "--task", "wall", "--out", tmp_path / "out", *given)
    assert (outcome.code, outcome.err) == (0, "")
    assert outcome.out.splitlines()[-3:] == [
        f"Also written: {file}" for file in (video, scene, scene.with_suffix(".npz"))
    ]
    assert video.read_bytes().startswith(b"GIF89a")
    assert "<mujoco " in scene.read_text("utf-8")
    again = infinivar("session", study, "--task", "wall", "--out", tmp_path / "out", "--video", video, "--json")
    assert json.loads(again.out)["files"][-1] == str(video)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (("--video", "cart.avi"), "cart.avi: a video must end in .gif or .mp4"),
        (("--scene", "cart.mjcf"), "cart.mjcf: a scene must end in .xml"),
        (("--video", "cart.gif", "--video-speed", "0"), "--video-speed: speed must be > 0, got 0.0"),
        (("--video", "cart.gif", "--video-speed", "nan"), "--video-speed: speed must be > 0, got nan"),
        (
            ("--video", "cart.gif", "--video-speed", "1e-6"),
            "--video-speed: 0.02 s at speed 1e-06 and 25 frames per second are 5e+05 frames, over 5000: raise speed, or lower "
            "frame_rate",
        ),
    ],
)
def test_a_wrong_video_is_refused_before_anything_is_computed(infinivar, study, tmp_path, given, message):
    before = sorted(tmp_path.iterdir())
    outcome = infinivar("session", study, "--task", "path", "--out", tmp_path / "out", *given)
    assert (outcome.code, outcome.out, outcome.err) == (2, "", f"infinivar: {message}\n")
    assert sorted(tmp_path.iterdir()) == before


def test_a_video_replaces_no_input(infinivar, study):
    study.rename(study.parent / "cart.gif")
    outcome = infinivar("session", study.parent / "cart.gif", "--task", "path", "--video", study.parent / "cart.gif")
    assert outcome.code == 2
    assert "is the study itself, and the results" in outcome.err
