"""`infinivar contact`: a calculation sheet, its figures, and what it says of a contact that is asked too much."""

import json
from pathlib import Path

import pytest

import infinivar as iv
from folders import results
from infinivar import Limit, contact_sheets
from pages import is_set_well, needs_no_network, pages

STUDY = Path(__file__).parents[2] / "studies" / "hand_controller.toml"

MINE = '[requirement]\nbase = "faulring2006"\n[drives.mine]\nbase = "faulring2006.cobotic"\n'
MEASURED = """[drives.mine.transmission]
creep_stiffness = "17 kN"
rolling_torque = "0.2 mN m"
bearing_torque = "2 mN m"
[drives.mine.steering]
patch_half_length = "0.5 mm"
"""


@pytest.fixture(scope="module")
def sheet():
    return contact_sheets(iv.load_study(STUDY), "cobotic")[0]


def test_sheet_of_the_shipped_study(infinivar, tmp_path):
    """Every group of results is there, in the units that people use, with the source of what went in."""
    done = infinivar("contact", STUDY, "--out", tmp_path)
    assert done.code == 0
    for said in (
        "Cobotic, Motor 1 (reconstruction A)",
        "Within stress limits; tightest limit: contact yield (margin 1.10).",
        "peak pressure              p0           2.929 GPa   3 P/(2 pi a b)",
        "creep group                K                413.1   C/(mu P)",
        "rolling group              H             0.003641",
        "fastsim",
        "stated: III-B.2",
        "Reconstruction. The paper states few dimensions",
    ):
        assert said in done.out, said
    assert max(map(len, done.out.splitlines()[:-1])) < 200
    names = [f"contact-{drive}{part}" for drive in ("cobotic", "cobotic-b") for part in ("", "-trends")]
    expected = [f"{name}.{kind}" for name in names for kind in ("png", "svg")]
    expected += ["contact-cobotic.txt", "contact-cobotic-b.txt", "contact.html"]
    assert results(tmp_path) == sorted(expected)
    assert (tmp_path / "contact-cobotic.txt").read_text("utf-8") in done.out
    assert done.out.splitlines()[-1] == f"Report: {tmp_path / 'contact.html'}"
    needs_no_network(tmp_path / "contact.html")
    is_set_well(tmp_path)
    page = pages(tmp_path)["contact.html"].text.replace("\u00a0", " ")
    for said in (
        "Within stress limits; tightest limit: contact yield (margin 1.10).",
        "2.929 GPa",
        "C/(mu P)",
        "III-B.2",
    ):
        assert said in page, said


def test_sheet_agrees_with_the_element(sheet):
    """The sheet computes nothing of its own: it shows what the drive computes with."""
    drive = sheet.drive
    groups, contact = drive.transmission.groups(drive.cylinder_speed), drive.transmission.contact
    assert sheet.value("creep group") == groups.creep_group
    assert sheet.value("rolling group") == groups.rolling_group
    assert sheet.value("hysteresis torque") == groups.rolling_torque
    assert sheet.value("bearing torque") == groups.bearing_torque
    assert sheet.value("peak pressure") == contact.patch.peak_pressure
    torques = drive.steering.friction_torques(drive.transmission)
    assert sheet.value("to turn the patch") == torques["patch"]
    with pytest.raises(KeyError, match="nothing"):
        sheet.value("nothing")


@pytest.mark.slow
def test_json(infinivar, tmp_path, sheet):
    done = infinivar("contact", STUDY, "--drive", "cobotic", "--json", "--out", tmp_path)
    printed = json.loads(done.out)
    (found,) = printed["sheets"]
    assert [Path(file).exists() for file in printed["files"]] == [True] * 6
    assert found["drive"] == "cobotic"
    assert found["verdict"] == sheet.verdict
    assert found["utilisation"]["YIELD"] == pytest.approx(0.91, abs=0.005)
    assert {line["name"]: line["value"] for line in found["lines"]}["slip force"] == pytest.approx(78.0)
    assert any(row["kind"] == "catalogue" for row in found["given"])


@pytest.mark.slow
def test_overstressed_contact_is_flagged_by_name(infinivar, write, tmp_path):
    """A sharp crown in soft steel: the sheet says so with exit code 1, and `compare` warns."""
    path = write(
        MINE + '[drives.mine.transmission.geometry]\ncrown_radius = "2 mm"\n'
        '[drives.mine.transmission.geometry.wheel_material]\npart = "c45"\n'
    )
    done = infinivar("contact", path, "--out", tmp_path / "sheet")
    assert done.code == 1
    assert "OVER-STRESSED: contact yield" in done.out
    assert "EXCEEDED" in done.out
    compared = infinivar("compare", path, "--out", tmp_path / "out")
    assert "warning: drives.mine.transmission: contact yield exceeded, " in compared.err
    assert "times the limit" in (tmp_path / "out" / "report.html").read_text("utf-8")


def test_crushed_contact_and_bearing(write, tmp_path):
    """Far beyond yield every limit is named; the largest is the verdict."""
    geometry = '[drives.mine.transmission]\npreload = "400 kN"\n'
    (sheet,) = contact_sheets(iv.load_study(tmp_path / write(MINE + geometry)))
    assert sheet.exceeded == (Limit.YIELD, Limit.HARDNESS, Limit.BEARING, Limit.AXLE)
    assert sheet.verdict.startswith("OVER-STRESSED: bearing static load")


def test_measured_groups_have_a_shorter_sheet(infinivar, write, tmp_path):
    """No patch to draw, but creep, rolling, steering and efficiency can be told."""
    path = write(MINE + MEASURED)
    done = infinivar("contact", path, "--out", tmp_path / "sheet")
    assert done.code == 0
    assert "Stress limits unknown" in done.out
    assert "creep group                K                217.9" in done.out
    assert "assumed for law exact, with Poisson's ratio 0.3" in done.out
    assert "Patch" not in done.out
    assert results(tmp_path / "sheet") == ["contact-mine.txt", "contact.html"]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--drive", "cobotik"), "drive 'cobotik' must be one of cobotic, cobotic-b"),
        (("--drive", "motor1-gear1"), "drive 'motor1-gear1' must be one of cobotic, cobotic-b"),
    ],
)
def test_wrong_drive(infinivar, tmp_path, arguments, said):
    done = infinivar("contact", STUDY, *arguments, "--out", tmp_path / "sheet")
    assert done.code == 2
    assert said in done.err
    assert not (tmp_path / "sheet").exists()


def test_study_without_a_wheel(infinivar, write, tmp_path):
    path = write(MINE.replace("cobotic", "motor1-gear1"))
    done = infinivar("contact", path, "--out", tmp_path / "sheet")
    assert done.code == 2
    assert f"{path}: no drive of type cobotic" in done.err


def test_parts_of_the_full_bearing_model(write, tmp_path):
    """The full model of the axle bearings shows its parts, which add up."""
    text = MINE + '[drives.mine.transmission.geometry.axle_bearing]\nfriction_model = "skf"\nviscosity = "50 mm^2/s"\n'
    (sheet,) = contact_sheets(iv.load_study(tmp_path / write(text)))
    parts = [sheet.value(f"  {name} part") for name in ("rolling", "sliding", "seal", "drag")]
    assert sum(parts) == pytest.approx(sheet.value("bearing torque"))
    groups = sheet.drive.transmission.groups(sheet.drive.cylinder_speed)
    assert groups.bearing_torque == pytest.approx(sheet.value("bearing torque"), rel=1e-12)
    assert sheet.value("wheel speed") == pytest.approx(0.05 * 14.0 / 0.010)
    assert sheet.value("bearing torque at start") > sheet.value("bearing torque")
