"""`infinivar contact --transient`: a step of the steering angle on the terminal, in JSON and as a figure."""

import json
from pathlib import Path

import pytest

from folders import results
from pages import pages

STUDY = Path(__file__).parents[2] / "studies" / "hand_controller.toml"
MEASURED = """[requirement]
base = "faulring2006"
[drives.mine]
base = "faulring2006.cobotic"
[drives.mine.transmission]
creep_stiffness = "17 kN"
rolling_torque = "0.2 mN m"
bearing_torque = "2 mN m"
[drives.mine.steering]
patch_half_length = "0.5 mm"
"""
BOTH = MEASURED + '[drives.theirs]\nbase = "faulring2006.cobotic"\n'


@pytest.mark.slow
@pytest.mark.renders("svg")
def test_terminal_and_files(infinivar, tmp_path):
    done = infinivar("contact", STUDY, "--transient", "--drive", "cobotic", "--out", tmp_path / "out")
    assert done.code == 0
    for said in (
        "Relaxation length 0.492 mm (1.49 a), 0.703 ms at 0.7 m/s, after a step of 1.48 mrad.",
        "steady lateral force               39 N   0.50 of mu P",
        "small steps                    0.598 mm",
        "  distance      time   slip angle     force      moment",
    ):
        assert said in done.out, said
    assert max(map(len, done.out.splitlines()[:-1])) < 130
    name = "contact-cobotic-transient"
    files = ["contact-transient.html", *(f"{name}.{kind}" for kind in ("txt", "png", "svg"))]
    assert results(tmp_path / "out") == sorted(files)
    page = pages(tmp_path / "out")["contact-transient.html"].text.replace("\u00a0", " ")
    assert "Relaxation length 0.492 mm (1.49 a)" in page
    assert "0.598 mm" in page
    assert (tmp_path / "out" / f"{name}.txt").read_text("utf-8") in done.out
    assert "slip angle" in (tmp_path / "out" / f"{name}.svg").read_text("utf-8")


@pytest.mark.slow
def test_json_at_a_rate(infinivar, tmp_path):
    arguments = ("--drive", "cobotic", "--angle", "1 mrad", "--rate", "1 rad/s", "--json", "--out", tmp_path / "out")
    done = infinivar("contact", STUDY, "--transient", *arguments)
    printed = json.loads(done.out)
    (step,) = printed["steps"]
    assert all(Path(file).exists() for file in printed["files"])
    assert step["angle_rad"] == pytest.approx(1e-3)
    assert step["rate_rad_s"] == pytest.approx(1.0)
    assert step["relaxation_time_s"] == pytest.approx(step["relaxation_length_m"] / step["surface_speed_m_s"])
    series = [step[name] for name in ("distance_m", "slip_angle_rad", "force_N", "moment_Nm")]
    assert {len(values) for values in series} == {len(series[0])}
    assert step["slip_angle_rad"][0] == 0.0
    assert step["force_N"][-1] == pytest.approx(step["steady_force_N"], rel=0.01)


def test_stated_contact_is_refused(infinivar, write, tmp_path):
    path = write(MEASURED)
    done = infinivar("contact", path, "--transient", "--out", tmp_path / "out")
    assert done.code == 2
    assert f"{path}: drives.mine.transmission: its contact is stated by creep_stiffness" in done.err
    assert "give geometry instead" in done.err
    assert done.err.count("\n") == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_stated_contact_beside_others(infinivar, write, tmp_path):
    """Without --drive, those with geometry are shown."""
    path = write(BOTH)
    done = infinivar("contact", path, "--transient", "--json", "--out", tmp_path / "out")
    assert [step["drive"] for step in json.loads(done.out)["steps"]] == ["theirs"]
    named = infinivar("contact", path, "--transient", "--drive", "mine", "--out", tmp_path / "out")
    assert named.code == 2


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--angle", "1 mrad"), "--angle is of the step that --transient shows: add --transient"),
        (("--rate", "1 rad/s"), "--rate is of the step that --transient shows: add --transient"),
        (("--transient", "--angle", "1 N"), "--angle '1 N'"),
        (("--transient", "--rate", "0.001 rad/s"), "rate must be at least 0.0"),
        (("--transient", "--angle", "0.5 rad"), "angle must be > 0 and <= 0.2 rad, got 0.5"),
        (("--transient", "--drive", "motor1-gear1"), "drive 'motor1-gear1' must be one of cobotic, cobotic-b"),
    ],
)
def test_wrong_options(infinivar, tmp_path, arguments, said):
    done = infinivar("contact", STUDY, *arguments, "--out", tmp_path / "out")
    assert done.code == 2
    assert said in done.err
    assert not (tmp_path / "out").exists()


def test_patch_out_of_range(infinivar, write, tmp_path):
    """A crown so flat that the patch is nearly a line."""
    path = write(
        '[requirement]\nbase = "faulring2006"\n[drives.mine]\nbase = "faulring2006.cobotic"\n'
        '[drives.mine.transmission.geometry]\ncrown_radius = "5 m"\n'
    )
    done = infinivar("contact", path, "--transient", "--out", tmp_path / "out")
    assert done.code == 2
    assert "drives.mine.transmission.geometry: patch outside the range of the solver: a_over_b must be" in done.err
