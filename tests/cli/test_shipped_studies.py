"""Studies that ship with the package, by name."""

import re

import pytest

import infinivar as iv
from infinivar import InputError
from internals import shipped_studies

NAMES = [
    *(
        "ankle_walking",
        "driven_cart",
        "guided_cart",
        "hand_controller",
        "knee_walking",
        "omniwheel_platform",
        "one_axis_display",
        "planar_cart",
        "reach_and_hold",
    ),
    *("six_leg_display", "sphere_joint", "tool_on_six_legs", "two_joint_arm"),
]


@pytest.mark.parametrize("name", NAMES)
def test_loads_by_name_from_any_folder(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert name in shipped_studies()
    study = iv.load_study(name)
    assert (study.name, study.drives) == (name, iv.load_study(shipped_studies()[name]).drives)


def test_a_machine_of_assumed_geometry_says_so():
    study = iv.load_study("six_leg_display")
    assert any("geometry of the platform" in one and "assumed" in one for one in study.reconstruction)
    rows = {row.field: row for row in study.provenance if row.owner == "one-motor-b"}
    assert rows["geometry.rod_length"].kind == "assumed"
    assert rows["leg.cylinder_speed"].kind == "stated"


def test_commands_take_a_name(infinivar):
    outcome = infinivar("check", "hand_controller")
    assert (outcome.code, outcome.err) == (0, "")
    assert outcome.out.startswith("hand_controller: 6 drives")


def test_a_file_of_that_name_goes_before(infinivar, tmp_path):
    (tmp_path / "hand_controller").write_text('title = "mine"\n', "utf-8")
    assert "requirement is missing" in infinivar("check", "hand_controller").err


def test_a_folder_of_that_name_does_not(infinivar, tmp_path):
    (tmp_path / "hand_controller").mkdir()
    assert infinivar("check", "hand_controller").code == 0


def test_a_name_of_neither_lists_the_shipped_studies(infinivar):
    outcome = infinivar("check", "hand_controler")
    assert (outcome.code, outcome.out) == (2, "")
    assert outcome.err == (
        "infinivar: hand_controler: neither a file nor a shipped study (did you mean 'hand_controller'?); "
        f"shipped studies: {', '.join(NAMES)}\n"
    )


@pytest.mark.parametrize("path", ["hand_controler.toml", "studies/hand_controller", "./hand_controller"])
def test_paths_are_only_paths(path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    if path.startswith("./"):  # pathlib has the same words for it
        assert iv.load_study(path).name == "hand_controller"
        return
    with pytest.raises(InputError, match="no such file"):
        iv.load_study(path)


@pytest.mark.slow
def test_the_report_on_a_joint_with_a_screw_and_a_spring(infinivar, tmp_path):
    outcome = infinivar("compare", "ankle_walking", "--drive", "geared-series", "--out", tmp_path)
    assert outcome.code == 0
    page = (tmp_path / "report.html").read_text("utf-8")
    assert re.search(r"screw: rated life</td>.*?<td>cubic mean</td>", page)
    assert "linkage range" in page
    assert "spring travel" not in page  # a linear spring has no end
    assert "the load is held at angle 0; a series spring only transmits there" in page
