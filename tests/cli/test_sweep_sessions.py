"""`infinivar sweep sessions`: how well a rig would determine a drive."""

import json

import pytest

OPTIONS = ("--ratios", "20,4", "--loads", "0.2,0.5", "--sessions", "3", "--size", "2")


@pytest.mark.full
def test_sessions_are_told_by_parameter(infinivar, tmp_path):
    folder = tmp_path / "sweep"
    said = infinivar("sweep", "sessions", "hand_controller", "--folder", folder, *OPTIONS)
    assert said.code == 0
    assert said.out.splitlines()[0].startswith("3 sessions; creep law fitted:")
    assert "  rolling_torque: not identifiable by itself" in said.out.splitlines()
    again = infinivar("sweep", "sessions", "hand_controller", "--folder", folder, *OPTIONS, "--resume", "--json")
    parameters = json.loads(again.out)["parameters"]
    assert parameters["creep_stiffness"]["unit"] == "N"
    assert parameters["rolling_torque + bearing_torque"]["identifiable"] == 1.0


def test_wrong_options_are_named_and_nothing_is_written(infinivar, tmp_path):
    folder = tmp_path / "sweep"
    for options, words in (
        (("--loads", "1.5"), "loads must be"),
        (("--ratios", "x"), "--ratios 'x' must be numbers"),
        (("--drive", "motor1-gear1"), "motor1-gear1"),
    ):
        said = infinivar("sweep", "sessions", "hand_controller", "--folder", folder, *options)
        assert said.code == 2
        assert words in said.err
        assert not folder.exists()
