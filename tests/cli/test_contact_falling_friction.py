"""`infinivar contact` of a wheel whose friction limit falls with speed: the limit is that at the drive's speed."""

import math

import pytest

import infinivar as iv
from infinivar import contact_sheets

FALLING = """
[requirement]
base = "faulring2006"
[drives.c]
base = "faulring2006.cobotic"
[drives.c.transmission.geometry]
fast_friction_ratio = {ratio}
friction_decay_speed = "0.1 m/s"
"""
CONSTANT = """
[requirement]
base = "faulring2006"
[drives.c]
base = "faulring2006.cobotic"
[drives.c.transmission]
friction = {friction}
"""


@pytest.mark.parametrize("ratio", [0.1, 0.45, 0.6])
def test_rolling_parts_of_the_sheet_are_those_of_a_constant_limit(write, tmp_path, ratio):
    """At its own speed, the wheel is that of a constant friction limit mu(V)."""
    (sheet,) = contact_sheets(iv.load_study(tmp_path / write(FALLING.format(ratio=ratio))))
    friction = 0.12 * (ratio + (1.0 - ratio) * math.exp(-0.7 / 0.1))
    assert sheet.value("friction limit at rest") == 0.12
    assert sheet.value("friction limit") == pytest.approx(friction, rel=1e-12)
    assert sheet.value("slip force") == pytest.approx(friction * 650.0, rel=1e-12)
    (known,) = contact_sheets(iv.load_study(tmp_path / write(CONSTANT.format(friction=repr(friction)))))
    for name in (
        "creepage",
        "bearing torque",
        "axle bearings, L10",
        "static safety",
        "rolling to 10 um of wear",
        "creep power",
        "flash temperature",
        "at 1:1",
        "at 8:1",
        "at 100:1",
    ):
        assert sheet.value(name) == pytest.approx(known.value(name), rel=1e-9, nan_ok=True), name
    assert math.isfinite(sheet.value("flash temperature"))
    assert sheet.value("at 8:1") > 0.5


def test_what_happens_at_rest_keeps_the_limit_at_rest(write, tmp_path):
    """Turning on the spot, starting and shakedown, which is lowest with the highest friction; and the sheet says so."""
    text = FALLING.format(ratio=0.5) + '[drives.c.transmission]\ncreep_law = "exact"\n'
    (sheet,) = contact_sheets(iv.load_study(tmp_path / write(text)))
    (known,) = contact_sheets(
        iv.load_study(
            tmp_path / write(CONSTANT.format(friction=0.12) + 'creep_law = "exact"\nsteering_model = "spin"\n')
        )
    )
    names = (
        "to turn the patch",
        "creep on the spot",
        "moment on the spot",
        "bearing torque at start",
        "shakedown pressure, wheel",
    )
    for name in names:
        assert sheet.value(name) == known.value(name), name
    said = {line.name: line.how for line in sheet.lines}
    assert "39 N, half the slip force at rest" in said["creep on the spot"]
    assert "lateral force 39 N" in said["bearing torque at start"]
    assert "friction limit at rest" in said["shakedown pressure, wheel"]
