"""Units at the edge."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from infinivar import InputError, units
from sampled import examples


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
        ("5 mm/rev", "m", "names an angle, where a length is needed"),
        ("5 mm/rad", "m", "names an angle, where a length is needed"),
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


def _kind(unit):
    # Units that are read by pint alone have none.
    return (units._common(unit) or (1.0, None))[1] if unit != "1" else None


def _si(quantity):
    """Magnitude in SI; pint's base units are those but for the radian, which is 1."""
    return quantity.magnitude


def _outcome(factor, unit, si_unit):
    try:
        scale, offset = factor(unit, si_unit)
    except InputError as problem:
        return str(problem)
    return pytest.approx(scale, rel=1e-14, abs=0.0), offset


@pytest.mark.parametrize("unit", units._COMMON)
def test_every_common_unit_is_that_of_pint(unit):
    """Units that are read without pint have its factors, to a rounding of pint's own products."""
    target = next(si for si in (*units.EXAMPLES, "J") if si != "1" and _kind(si) == _kind(unit))
    (scale, offset), (known, zero) = units._factor(unit, target), units._factor_by_pint(unit, target)
    assert scale == pytest.approx(known, rel=4e-16, abs=0.0)
    assert offset == zero == 0.0


@pytest.mark.parametrize("unit", ["degC", "°C"])
def test_temperatures_are_those_of_pint(unit):
    assert units._factor(unit, "K") == pytest.approx(units._factor_by_pint(unit, "K"), rel=4e-16, abs=0.0)


@pytest.mark.parametrize(
    ("unit", "si_unit"),
    [("g cm^2", "kg m^2"), ("mm^2/s", "m^2/s"), ("mN m/A", "N m/A"), ("kg m/s^2", "N"), ("rpm", "rad/s"), ("mH", "H")],
)
def test_usual_products_round_as_those_of_pint(unit, si_unit):
    """To the last bit: a study gives the numbers that it would give with pint."""
    assert units._factor(unit, si_unit) == units._factor_by_pint(unit, si_unit)


NAMES = st.sampled_from([*units._COMMON, "C", "lb", "oz", "parsnip", "degC", "mmm", "%", "1", "cycle", "bar"])
POWERS = st.sampled_from(["", "", "", "^2", "²", "³", "^3", "^-1", "**2", "^0", "^0.5", "2"])
EXPRESSIONS = st.lists(
    st.tuples(st.sampled_from([" ", " ", "/", " / ", "*", "·", "  ", "//", "."]), NAMES, POWERS), min_size=1, max_size=4
).map(lambda words: "".join(gap + name + power for gap, name, power in words).lstrip(" /*·."))


@pytest.mark.slow
@given(EXPRESSIONS, st.sampled_from([*(unit for unit in units.EXAMPLES if unit != "1"), "J"]))
@examples(400)
def test_expressions_mean_what_they_mean_to_pint(unit, si_unit):
    """The same factor, or the same message."""
    assert _outcome(units._factor, unit, si_unit) == _outcome(units._factor_by_pint, unit, si_unit)


@given(
    st.lists(st.tuples(st.sampled_from(list(units._COMMON)), st.sampled_from(["", "^2", "³"])), min_size=1, max_size=4)
)
def test_products_and_quotients_of_common_units_are_those_of_pint(words):
    """Each expression to base units, as nearly none would be of the kind that a study asks for."""
    above, *below = [name + power for name, power in words]
    for unit in ("/".join([above, *below]), " ".join([above, *below])):
        factor, dimension = units._common(unit)
        base = units._registry().Quantity(1.0, unit).to_base_units()
        assert factor == pytest.approx(_si(base), rel=1e-14)
        kinds = {"[length]": 0, "[mass]": 1, "[time]": 2, "[current]": 3, "[temperature]": 4}
        assert {kinds[kind]: power for kind, power in base.dimensionality.items() if power} == {
            place: power for place, power in enumerate(dimension) if power
        }


@pytest.mark.parametrize("unit", units.EXAMPLES)
def test_every_example_is_read(unit):
    """The advice that messages give must itself be right."""
    assert math.isfinite(units.parse(units.EXAMPLES[unit], unit))


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [
        (1500.0, 2, "1500"),
        (1543.2, 3, "1540"),
        (26.3, 3, "26.3"),
        (0.0263, 3, "0.0263"),
        (-0.000123456, 4, "-0.0001235"),
        (0.0001, 3, "0.0001"),
        (0.000099999, 5, "9.9999e-5"),
        (9.9996, 4, "10"),
        (99.96, 3, "100"),
        (1234567.0, 4, "1235000"),
        (9.9999e6, 3, "1e7"),
        (2.1e11, 4, "2.1e11"),
        (1e-12, 4, "1e-12"),
        (1e9, 4, "1e9"),
        (0.0, 4, "0"),
        (-0.0, 4, "0"),
        (10.0, 4, "10"),
        (100.0, 1, "100"),
        (1e300, 3, "1e300"),
        (math.nan, 3, "–"),
        (math.inf, 3, "infinite"),
    ],
)
def test_numbers_for_people(value, digits, text):
    assert units.plain(value, digits) == text


@pytest.mark.parametrize("digits", [1, 2, 3, 4, 9])
@pytest.mark.parametrize("exponent", range(-15, 16))
def test_numbers_for_people_are_the_numbers(exponent, digits):
    """Read back, what is shown is the value to its digits."""
    for mantissa in (1.0, -1.2345678912, 5.55, 9.9999999999):
        value = mantissa * 10.0**exponent
        assert float(units.plain(value, digits)) == pytest.approx(value, rel=0.51 * 10.0 ** (1 - digits))


def test_values_with_units_for_people():
    assert units.show(1543.2, "N", 3) == "1540 N"
    assert units.show(0.12, "1") == "0.12"
    assert units.show_in(0.0263, "N m", "mN m") == "26.3 mN m"
    assert units.show_in(0.88, "1", "%") == "88 %"
    assert units.signed(0.25) == "+0.25"
    assert units.signed(-1500.0) == "-1500"
    assert units.celsius(365.4) == "92 °C"
    assert units.celsius(math.inf) == "infinite"


def test_numbers_on_pages():
    from internals import report_numbers as numbers

    bound = "\N{NO-BREAK SPACE}"
    assert str(numbers.si(1543.2)) == "1540"
    assert str(numbers.si(1.5e-9)) == f"1.5{bound}×{bound}10<sup>−9</sup>"
    assert str(numbers.si(None)) == "–"
    assert numbers.si(math.inf) == "infinite"
    assert str(numbers.watts(4.567)) == "4.57 W"
    assert str(numbers.watts(0.00012)) == f"0.00012{bound}W"
    assert str(numbers.watts(5e8)) == f"5{bound}×{bound}10<sup>8</sup>{bound}W"
    assert numbers.watts(math.nan) == "–"
    assert numbers.percent(0.1234) == "12.3 %"


@pytest.mark.parametrize(
    ("value", "margin", "demand"),
    [
        (0.9996, "0.9996", "1 times"),
        (0.99951, "0.9995", "1 times"),
        (1.0 - 2e-9, "just under 1", "1 times"),
        (1.0, "1.00", "1 times"),
        (1.0004, "1.00", "1.0004 times"),
        (1.0 + 1e-12, "1.00", "just over 1 times"),
        (0.5, "0.50", "0.5 times"),
        (1.5206, "1.52", "1.52 times"),
        (math.inf, "inf", "infinite times"),
    ],
)
def test_what_fails_by_little_does_not_read_as_one(value, margin, demand):
    assert (units.margin_words(value), units.times(value)) == (margin, demand)


def test_margins_to_some_digits():
    assert [units.margin_words(value, 3) for value in (0.9996, 1.0004, 0.57216, 1e9)] == ["0.9996", "1", "0.572", "1e9"]
