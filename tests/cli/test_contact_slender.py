"""Patches more slender than the tables of exact rolling: refused with spin before anything is computed, noted with the law."""

import pytest

import infinivar as iv
from cobotic_study import GOOD
from infinivar import contact_sheets
from infinivar.contact import exact_law
from internals import spin_map

SLENDER = """
[requirement]
force = "50 N"
speed = "1.05 m/s"
power = "12 W"
[drives.c]
base = "faulring2006.cobotic"
[drives.c.transmission]
{keys}
[drives.c.transmission.geometry]
crown_radius = "5 m"
[duty.shake]
shape = "sinusoid"
distance = "20 mm"
frequency = "3 Hz"
load_mass = "0.8 kg"
"""
SPIN = 'steering_model = "spin"'
EXACT = 'creep_law = "exact"'
NOTE = "; fitted for a/b from 0.05 to 20: that of the nearest"


def test_one_range():
    assert (spin_map.A_OVER_B[0], spin_map.A_OVER_B[-1]) == (exact_law.NARROWEST, exact_law.WIDEST)


@pytest.mark.parametrize("command", ["check", "compare", "contact"])
def test_spin_names_drive_and_key(infinivar, write, tmp_path, command):
    path = write(SLENDER.format(keys=SPIN))
    options = () if command == "check" else ("--out", "result")
    done = infinivar(command, path, *options)
    assert (done.code, done.out) == (2, "")
    (line,) = [one for one in done.err.splitlines() if "faults" not in one and "fault found" not in one]
    assert "drives.c.transmission.steering_model must be shear, got 'spin'" in line
    assert "a/b = 0.0196, and forces with spin are known for 0.05 to 20" in line
    assert not (tmp_path / "result").exists()


@pytest.mark.parametrize("crown", ["5 m", "8 mm"])
def test_the_default_is_spin_only_where_it_is_known(write, tmp_path, crown):
    """And the sheet says that the law is that of another patch."""
    text = SLENDER.format(keys=EXACT).replace("5 m", crown)
    study = iv.load_study(tmp_path / write(text))
    assert study.drives["c"].transmission.turns_with_spin == (crown == "8 mm")
    (sheet,) = contact_sheets(study)
    assert any(line.name == "creep on the spot" for line in sheet.lines) == (crown == "8 mm")
    noted = [line.how for line in sheet.lines if NOTE in line.how]
    assert noted == ([] if crown == "8 mm" else [f"at half the slip force, law exact, in use{NOTE}"])


def test_creep_of_a_locked_link_is_stated_without_a_steering_plant(write, tmp_path):
    """It is a matter of the contact alone."""
    alone = GOOD.partition("[drives.arm.steering]")[0].replace('creep_law = "fastsim"\n', "")
    study = iv.load_study(tmp_path / write(alone))
    (sheet,) = contact_sheets(study)
    assert sheet.drive.steering is None
    assert sheet.value("creep on the spot") > 0.0
