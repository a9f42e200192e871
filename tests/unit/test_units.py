"""Units at the edge."""

import math

import pytest

from infinivar import units
from infinivar.errors import InputError


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("26.3 mN m", "N m", 0.0263),
        ("8040 rpm", "rad/s", 8040 * 2 * math.pi / 60),
        ("2 rev/s", "rad/s", 4 * math.pi),
        ("0.278 mH", "H", 0.278e-3),
        ("14.9 g cm^2", "kg m^2", 14.9e-7),
        ("14.9 g cm²", "kg m^2", 14.9e-7),
        ("100 degC", "K", 373.15),
        ("2.14 Ω", "ohm", 2.14),
        ("75 deg", "rad", math.radians(75)),
        ("12 %", "1", 0.12),
        (0.12, "1", 0.12),
        (3, "1", 3.0),
        ("-1.5e-3 N", "N", -1.5e-3),
        (".5 m", "m", 0.5),
    ],
)
def test_reads(text, unit, value):
    assert units.parse(text, unit) == pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize(
    ("text", "unit", "message"),
    [
        (5, "N", "needs a unit"),
        ("5", "N", "needs a unit"),
        ("N", "N", "must begin with a number"),
        ("nan N", "N", "must begin with a number"),
        ("", "N", "must begin with a number"),
        ("1e400 N", "N", "must be a finite number"),
        (float("nan"), "1", "must be a finite number"),
        ("5 kg", "N", "has the unit 'kg' where N is needed"),
        ("5 parsnips", "m/s", "has an unknown unit 'parsnips'"),
        ("5 mNm", "N m", "has the unit 'mNm': separate the units of a product"),
        ("14 Hz", "rad/s", "must name the angle"),
        ("14 1/s", "rad/s", "must name the angle"),
        ("1,5 N", "N", "not a comma"),
        ("5 N", "1", "has the unit 'N' where a pure number is needed"),
        (True, "1", "must be a number"),
        ([5, "N"], "N", "must be a number with a unit"),
    ],
)
def test_refuses(text, unit, message):
    with pytest.raises(InputError) as raised:
        units.parse(text, unit)
    assert message in str(raised.value)


@pytest.mark.parametrize("unit", units.EXAMPLES)
def test_every_example_is_read(unit):
    """The advice that messages give must itself be right."""
    assert math.isfinite(units.parse(units.EXAMPLES[unit], unit))
