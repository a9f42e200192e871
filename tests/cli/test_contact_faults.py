"""A cobotic drive described part by part, from its sheet to a comparison; mistakes in it are rows of tests/faults."""

import math

import pytest

import infinivar as iv
from cobotic_study import GOOD
from infinivar import contact_sheets
from sampled import sampled


def put(old, new):
    assert old in GOOD
    return GOOD.replace(old, new)


@pytest.mark.full
def test_a_drive_of_its_own(infinivar, write):
    """From the sheet to a comparison."""
    done = infinivar("contact", write(GOOD), "--out", "result")
    assert (done.code, done.err) == (0, "")
    assert "–" not in done.out
    # By hand: SKF's formulas in mm, N and r/min for 225.7 N with 30 N axial and for 174.3 N, 397.9 r/min, 50 mm2/s.
    assert "bearing torque             tau_wa      4.425 mN m   two 608, SKF model, lateral force 30 N" in done.out
    # By scipy's elliptic integrals and a root finder.
    assert "peak pressure              p0            2.16 GPa" in done.out
    assert infinivar("compare", "study.toml", "--out", "result").code == 0


@pytest.mark.parametrize("law", ["linear", "faulring", "vermeulen-johnson", "polach"])
def test_every_law_by_name(write, tmp_path, law):
    (sheet,) = contact_sheets(iv.load_study(tmp_path / write(put('"fastsim"', f'"{law}"'))))
    assert sheet.drive.transmission.creep_law.name == law
    missing = [(line.name, line.how) for line in sheet.lines if not math.isfinite(line.value)]
    # At 1:1 half the slip force is 0.71 of it sideways: there the loss of Eq 17 already means a creepage beyond full slip.
    slips = ("at 1:1", "surface speed : link speed; the wheel slips, or the rolling loss exceeds the transmitted power")
    assert missing == ([slips] if law == "faulring" else [])


@pytest.mark.parametrize(
    "table",
    [
        'viscosity = "200 mm^2/s"',
        'part = "608"',
        'part = "6000"\nfriction_model = "coefficient"',
        'type = "angular_contact"',
    ],
)
def test_parts_of_a_base_can_be_changed(write, tmp_path, table):
    base = '[requirement]\nbase = "faulring2006"\n[drives.arm]\nbase = "faulring2006.cobotic"\n'
    bearing = "[drives.arm.transmission.geometry.axle_bearing]"
    (sheet,) = contact_sheets(iv.load_study(tmp_path / write(f"{base}{bearing}\n{table}\n")))
    assert all(math.isfinite(line.value) for line in sheet.lines)


@sampled("preload", ["1e6 N", "1e-9 N"], slow=2)
@pytest.mark.renders("svg")
def test_the_absurd_has_a_sheet_too(infinivar, write, preload):
    """No nan, no traceback: where nothing moves the sheet has a dash and says why."""
    done = infinivar("contact", write(put('"400 N"', f'"{preload}"')), "--out", "result")
    assert done.code == (1 if preload == "1e6 N" else 0)
    assert " nan" not in done.out
    assert "–   surface speed : link speed; the wheel slips" in done.out
