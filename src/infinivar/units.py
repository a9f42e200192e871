"""Parse quantities such as "26.3 mN m" to SI floats, and format SI floats for people. All other code uses SI floats."""

from __future__ import annotations

import functools
import math
import re
from typing import Any

from infinivar.errors import InputError

_NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*$", re.DOTALL)

_NAMES_AN_ANGLE = re.compile(r"rad|deg|°|rev|turn|rpm|rps|cycle|arcmin|arcsec")
# Unit libraries interpret these differently.
_RUN_TOGETHER = re.compile(r"(?<![A-Za-z])[munkM]?Nm(?![A-Za-z])|gcm|kgm")
_STRANGE = re.compile(r"[^\w\s*·/^().²³⁻¹°Ω-]")
# Other dimensionless units (rad, dB, bit) are mistakes where a pure number is expected.
_PURE = {"": 1.0, "1": 1.0, "%": 1e-2, "percent": 1e-2, "‰": 1e-3, "permille": 1e-3, "ppm": 1e-6}
_STANDARD = {
    **dict.fromkeys(("sec", "secs", "second", "seconds"), "s"),
    **dict.fromkeys(("msec", "millisecond", "milliseconds"), "ms"),
    **dict.fromkeys(("deg.", "degree", "degrees", "°"), "deg"),
    **dict.fromkeys(("radian", "radians"), "rad"),
    **dict.fromkeys(("deg/sec", "degrees/s", "degrees/sec", "°/s"), "deg/s"),
    **dict.fromkeys(("rad/sec", "radians/s"), "rad/s"),
    **dict.fromkeys(("m/sec",), "m/s"),
    **dict.fromkeys(("newton", "newtons"), "N"),
    **dict.fromkeys(("meter", "meters", "metre", "metres"), "m"),
    **dict.fromkeys(("pct", "percent"), "%"),
    "ohms": "ohm",
    "-": "1",
}
"""Units as files write them, where studies write them otherwise."""

_FORCE_TIMES_LENGTH = re.compile(r"(?<![A-Za-z])([munkM]?N)(?:[-_.*·⋅ ]?([mc]?m)|([mc]?m)(s))(?![A-Za-z])")
_MASS_TIMES_AREA = re.compile(r"(?<![A-Za-z])(k?g)[-_.*·⋅ ]?([mc]?m)(?:\^?2|²)")
_OHM = re.compile(r"(?<![A-Za-z])([mkM]?)[Oo]hms?(?![A-Za-z])")

_LARGEST = 1e20
"""Magnitudes above this, or below its inverse, are mistakes, and their products would overflow."""

_PLAIN = (1e-4, 1e7)
"""Magnitudes between these are written without an exponent."""

_NEAR_ONE = 1e-6
"""Below this a difference to 1 is put in words."""

ZERO_CELSIUS = 273.15
"""[K]"""

STANDARD_GRAVITY = 9.80665
"""[m s^-2]"""

EXAMPLES = {
    "N": "50 N",
    "m": "10 mm",
    "m/s": "1.05 m/s",
    "m/s^2": "9.81 m/s^2",
    "kg": "0.4 kg",
    "W": "12 W",
    "rad": "75 deg",
    "rad/s": "8040 rpm",
    "N m": "26.3 mN m",
    "N m/A": "25.6 mN m/A",
    "V": "24 V",
    "A": "53 mA",
    "ohm": "2.14 ohm",
    "H": "0.278 mH",
    "kg m^2": "14.9 g cm^2",
    "N/m": "20 N/mm",
    "N m/rad": "250 N m/rad",
    "N s/m": "12 N s/m",
    "N m s": "0.4 mN m s",
    "1/(N m)": "0.01 1/(N m)",
    "K/W": "13.2 K/W",
    "K": "100 degC",
    "W/m/K": "46 W/m/K",
    "J/m^3/K": "3.7 MJ/m^3/K",
    "s": "17.8 s",
    "Hz": "5 Hz",
    "Pa": "210 GPa",
    "m^2/s": "100 mm^2/s",
    "1": "0.12",
}
"""A valid example for every unit of the study file."""

_USUAL = {
    "N": ("kN", "mN"),
    "m": ("mm", "um"),
    "m/s": ("mm/s",),
    "kg": ("g",),
    "W": ("mW", "kW"),
    "rad": ("deg", "mrad"),
    "rad/s": ("rpm", "deg/s"),
    "N m": ("mN m",),
    "N m/A": ("mN m/A",),
    "A": ("mA",),
    "ohm": ("mohm",),
    "H": ("mH", "uH"),
    "kg m^2": ("g cm^2", "g m^2"),
    "N/m": ("N/mm", "kN/m"),
    "N m s": ("mN m s",),
    "K": ("degC",),
    "J/m^3/K": ("MJ/m^3/K",),
    "s": ("ms", "us"),
    "Hz": ("kHz", "mHz"),
    "Pa": ("GPa", "MPa"),
    "m^2/s": ("mm^2/s",),
}
"""Units in which a quantity is usually written, besides its SI unit."""

_SHORT = 6
"""Characters up to which a number in SI needs no other unit."""


# Powers of m, kg, s, A and K.
_NEWTON, _JOULE, _WATT = (1, 1, -2, 0, 0), (2, 1, -2, 0, 0), (2, 1, -3, 0, 0)
_SECOND, _PER_SECOND, _ANGLE = (0, 0, 1, 0, 0), (0, 0, -1, 0, 0), (0, 0, 0, 0, 0)
_Entry = tuple[float, tuple[int, ...]]
"""Factor to SI, and the dimension."""

_PREFIXES = {"": 1.0, "G": 1e9, "M": 1e6, "k": 1e3, "c": 1e-2, "m": 1e-3, "u": 1e-6, "µ": 1e-6, "μ": 1e-6, "n": 1e-9}


def _prefixed(symbols: str, prefixes: str, dimension: tuple[int, ...]) -> dict[str, _Entry]:
    """Units of one dimension with the prefixes that they are written with, and without any."""
    return {prefix + symbol: (_PREFIXES[prefix], dimension) for symbol in symbols.split() for prefix in ("", *prefixes)}


_COMMON: dict[str, _Entry] = {
    **_prefixed("m", "kcmuµμn", (1, 0, 0, 0, 0)),
    "kg": (1.0, (0, 1, 0, 0, 0)),
    "g": (1e-3, (0, 1, 0, 0, 0)),
    "mg": (1e-6, (0, 1, 0, 0, 0)),
    **_prefixed("s", "muµμn", _SECOND),
    **_prefixed("A", "kmuµμ", (0, 0, 0, 1, 0)),
    **_prefixed("K", "m", (0, 0, 0, 0, 1)),
    **_prefixed("N", "MkmuµμnG", _NEWTON),
    **_prefixed("J", "MkmuµμG", _JOULE),
    **_prefixed("W", "MkmuµμG", _WATT),
    **_prefixed("V", "kmuµμ", (2, 1, -3, -1, 0)),
    **_prefixed("ohm Ω", "Mkmuµμ", (2, 1, -3, -2, 0)),
    **_prefixed("H", "muµμn", (2, 1, -2, -2, 0)),
    **_prefixed("Pa", "GMkm", (-1, 1, -2, 0, 0)),
    **_prefixed("Hz", "GMkm", _PER_SECOND),
    **_prefixed("rad", "muµμ", _ANGLE),
    **dict.fromkeys(("deg", "°"), (math.pi / 180.0, _ANGLE)),
    **dict.fromkeys(("rev", "turn"), (2.0 * math.pi, _ANGLE)),
    "rpm": (math.pi / 30.0, _PER_SECOND),
    "min": (60.0, _SECOND),
    "h": (3600.0, _SECOND),
    "Wh": (3600.0, _JOULE),
    "kWh": (3.6e6, _JOULE),
}
"""Units that nearly every study is written in. Reading them here spares loading pint, which takes longer than the rest of a
study; whatever is not here goes to pint, and a test holds every line against it."""

_POWER = re.compile(r"([^\W\d_²³]+|°)(?:\^([1-9])|([²³]))?")
_SUPERSCRIPTS = {"²": 2, "³": 3}


def _common(text: str) -> _Entry | None:
    """Factor and dimension of a product of common units, divided or not; None where pint is needed.

    A product behind a stroke ("J/kg K") is left to pint, which has its own rules for that.
    """
    above, *below = text.split("/")
    factor, dimension = 1.0, (0, 0, 0, 0, 0)
    for part, sign in ((above, 1), *((part, -1) for part in below)):
        words = part.split()
        if not words or (sign < 0 and len(words) > 1):
            return None
        for word in words:
            found = _POWER.fullmatch(word)
            if found is None or found[1] not in _COMMON:
                return None
            one, powers = _COMMON[found[1]]
            power = int(found[2] or _SUPERSCRIPTS.get(found[3], 1))
            for _ in range(power):  # one after the other rounds as pint does
                factor = factor * one if sign > 0 else factor / one
            dimension = tuple(had + sign * power * more for had, more in zip(dimension, powers, strict=True))
    return factor, dimension


@functools.cache
def _registry() -> Any:
    import pint

    registry = pint.UnitRegistry()
    registry.define("@alias turn = rev")
    return registry


@functools.cache
def _factor(unit: str, si_unit: str) -> tuple[float, float]:
    """Scale and offset that convert a value in `unit` to `si_unit`.

    Raises
    ------
    InputError
        If the unit is unknown or has the wrong dimension.
    """
    if si_unit == "K" and unit in ("degC", "°C"):
        return 1.0, ZERO_CELSIUS
    if unit == si_unit:
        return 1.0, 0.0
    source, target = _common(unit), _common(si_unit)
    if source is not None and target is not None and source[1] == target[1]:
        return source[0] / target[0], 0.0
    return _factor_by_pint(unit, si_unit)


def _factor_by_pint(unit: str, si_unit: str) -> tuple[float, float]:
    """The same for any unit there is; every message about a unit comes from here."""
    if unit in _PURE:
        raise InputError(f"has the unit {unit!r} where {si_unit} is needed; {_example(si_unit)}")
    import pint

    registry = _registry()
    try:
        if _STRANGE.search(unit) or len(unit) > 60:
            raise ValueError
        source = registry.Unit(unit)
    except Exception as problem:  # pint raises many kinds, down to tokenizer errors
        hint = "write products with a space and powers with ^, as in mN m or g cm^2"
        raise InputError(f"has an unknown unit {unit[:60]!r}; {hint}") from problem
    try:
        zero, one, two = (registry.Quantity(x, source).to(si_unit).magnitude for x in (0.0, 1.0, 2.0))
        if abs(two - 2 * one + zero) > 1e-9 * abs(two):
            raise InputError(f"has the logarithmic unit {unit!r}; {_example(si_unit)}")
        thousand = registry.Quantity(1000.0, source).to(si_unit).magnitude
    except pint.DimensionalityError as problem:
        raise InputError(f"has the unit {unit!r} where {si_unit} is needed; {_example(si_unit)}") from problem
    # Over a span of 1000 the factor of an offset unit (degC) is exact.
    scale = one if zero == 0.0 else (thousand - zero) / 1000.0
    return float(scale), float(zero)


def _example(si_unit: str, example: str | None = None) -> str:
    return f'write for example "{example or EXAMPLES.get(si_unit, "1 " + si_unit)}"'


def parse(text: object, si_unit: str, example: str | None = None) -> float:
    """Convert a number with a unit to SI.

    Parameters
    ----------
    text : object    "26.3 mN m"; a bare number is accepted only if `si_unit` is "1".
    si_unit : str    Unit of the result, in pint's notation; "1" for a pure number.
    example : str    Example shown in error messages; by default one for the unit.

    Returns
    -------
    float   Finite.

    Raises
    ------
    InputError
        If the unit is missing, unknown or of the wrong dimension, or the number is not finite; the message gives a valid
        example.
    """
    hint = _example(si_unit, example)
    number, unit = _split(text, si_unit, hint)
    wrong = _misspelt(unit, si_unit)
    if wrong is not None:
        raise InputError(f"{wrong}; {hint}")
    scale, offset = (_PURE[unit], 0.0) if si_unit == "1" else _factor(unit, si_unit)
    value = number * scale + offset
    if not math.isfinite(value):
        raise InputError(f"must be a finite number; {hint}")
    if value and not 1 / _LARGEST <= abs(value) <= _LARGEST:
        raise InputError(f"must be between {1 / _LARGEST:g} and {_LARGEST:g} in SI units; {hint}")
    return value


def standard_unit(unit: str) -> str:
    """Return a unit of a file as studies spell it: "Nm" as "N m", "mNm/A" as "mN m/A", "gcm2" as "g cm^2", "Ohm" as "ohm"."""
    unit = _STANDARD.get(unit.lower(), unit)
    unit = _FORCE_TIMES_LENGTH.sub(lambda found: " ".join(filter(None, found.groups())), unit)
    return _OHM.sub(r"\1ohm", _MASS_TIMES_AREA.sub(r"\1 \2^2", unit))


def measures(unit: str, si_unit: str) -> bool:
    """Whether a unit measures the same quantity as an SI unit; common units are distinguished without loading a library."""
    source, target = _common(unit), _common(si_unit)
    if source is not None and target is not None and source[1] != target[1]:
        return False
    try:
        parse(f"1 {unit}", si_unit)
    except InputError:
        return False
    return True


def _split(text: object, si_unit: str, hint: str) -> tuple[float, str]:
    """Number and unit as written; no unit where there is a bare number."""
    if isinstance(text, bool) or not isinstance(text, (str, int, float)):
        raise InputError(f"must be a number{'' if si_unit == '1' else ' with a unit'}; {hint}")
    if isinstance(text, str):
        found = _NUMBER.match(text)
        if found is None:
            raise InputError(f"must begin with a number; {hint}")
        return float(found[1]), found[2]
    try:
        return float(text), ""
    except OverflowError:
        return math.inf, ""


def _misspelt(unit: str, si_unit: str) -> str | None:
    """What is wrong with the way a unit is written, whether or not a library of units knows it; None if nothing is."""
    if unit.startswith(","):
        return "must have a point before its decimals, not a comma"
    if si_unit == "1":
        return None if unit in _PURE else f"has the unit {unit[:60]!r} where a pure number is needed"
    if not unit:
        return "needs a unit"
    if _RUN_TOGETHER.search(unit):
        return f"has the unit {unit!r}: separate the units of a product"
    if si_unit == "m" and _NAMES_AN_ANGLE.search(unit):
        return f"has the unit {unit!r}, which names an angle, where a length is needed"
    if si_unit == "Hz":
        return "must count cycles, not an angle" if _NAMES_AN_ANGLE.search(unit) else None
    if re.search("[Hh](ert)?z", unit):
        return f"must name the angle, which {unit!r} does not"
    if si_unit in ("rad", "rad/s") and not _NAMES_AN_ANGLE.search(unit):
        # pint converts 1/s and Hz to rad/s as if a turn were a radian, which is most likely a mistake.
        choices = "rpm, rev/s, deg/s or rad/s" if si_unit == "rad/s" else "deg, rad or rev"
        return f"must name the angle ({choices})"
    return None


def plain(value: float | None, digits: int = 4) -> str:
    """Format a number for people: 1543.2 to three digits is "1540", never "1.54e+03".

    From 0.0001 to 10 000 000 there is no exponent; outside, a power of ten follows: "1.5e-6", "2.1e11".

    Parameters
    ----------
    value : float
    digits : int    Significant digits; trailing zeros after the decimal point are dropped.

    Returns
    -------
    str   "–" for nan and None, "infinite" for infinity.
    """
    if value is None or math.isnan(value):
        return "–"
    if math.isinf(value):
        return "infinite" if value > 0 else "-infinite"
    rounded = float(f"{value:.{digits - 1}e}") + 0.0  # no -0
    if rounded == 0.0 or _PLAIN[0] <= abs(rounded) < _PLAIN[1]:
        places = max(0, digits - 1 - math.floor(math.log10(abs(rounded)))) if rounded else 0
        text = f"{rounded:.{places}f}"
        return text.rstrip("0").rstrip(".") if "." in text else text
    mantissa, exponent = f"{rounded:.{digits - 1}e}".split("e")
    return f"{mantissa.rstrip('0').rstrip('.') if '.' in mantissa else mantissa}e{int(exponent)}"


def signed(value: float, digits: int = 3) -> str:
    """Format a change with its sign: "+1.5", "-0.02"."""
    return ("+" if value > 0 else "") + plain(value, digits)


def rounded_up(value: float, digits: int = 3) -> str:
    """Format a positive number for people, rounded up: 16.667 as "16.7", 16.61 as "16.7"."""
    unit = 10.0 ** (digits - 1 - math.floor(math.log10(value)))
    return plain(math.ceil(value * unit * (1.0 - 1e-9)) / unit, digits)


def unlike_one(value: float, text: str) -> str:
    """The text of a number; where it reads as 1 and the number is not 1, one with more digits, or "just over 1".

    For margins and demands over allowances: what fails by little must not read as kept.
    """
    off = abs(value - 1.0)
    if off == 0.0 or not math.isfinite(off) or float(text) != 1.0:
        return text
    if off < _NEAR_ONE:
        return "just over 1" if value > 1.0 else "just under 1"
    return f"{value:.{math.ceil(-math.log10(off))}f}"


def margin_words(margin: float, digits: int | None = None) -> str:
    """Format a margin, allowance over demand: to 0.01, or to `digits`; one below 1 never reads as 1."""
    text = f"{margin:.2f}" if digits is None else plain(margin, digits)
    return unlike_one(margin, text) if margin < 1.0 else text


def times(demand: float, digits: int = 3) -> str:
    """Format a demand over its allowance: "1.52 times"; one above 1 never reads as 1."""
    return f"{unlike_one(demand, plain(demand, digits)) if demand > 1.0 else plain(demand, digits)} times"


def percent(share: float, places: int = 0, sign: str = "") -> str:
    """Format a fraction as a percentage: "4.2 %"; with its sign if `sign` is "+"."""
    return f"{100.0 * share:{sign}.{places}f} %"


def show(value: float, si_unit: str, digits: int = 4) -> str:
    """Format an SI value with its unit: "0.0263 N m", "1500 N"."""
    return plain(value, digits) + ("" if si_unit == "1" else f" {si_unit}")


def show_in(value: float, si_unit: str, unit: str, digits: int = 4) -> str:
    """Format an SI value in another unit: 0.0263 N m as "26.3 mN m"."""
    scale = _PURE[unit] if si_unit == "1" else _factor(unit, si_unit)[0]
    return plain(value / scale, digits) + ("" if unit == "1" else f" {unit}")


def celsius(temperature: float) -> str:
    """Format a temperature given in kelvin: "92 °C"."""
    return f"{temperature - ZERO_CELSIUS:.0f} °C" if math.isfinite(temperature) else "infinite"


def exact(value: float, si_unit: str) -> str:
    """Write a number so that `parse` gives back the same float: "26.3 mN m", "8040 rpm", "0.02 kg m^2".

    Of the usual units, the one with the shortest number is used; SI if none is shorter.
    """
    plain_number = repr(float(value)).removesuffix(".0")
    if si_unit == "1":
        return plain_number
    shortest = plain_number, si_unit
    if len(plain_number) > _SHORT:
        for unit in _USUAL.get(si_unit, ()):
            found = _number_in(value, si_unit, unit)
            if found is not None and len(found) < len(shortest[0]):
                shortest = found, unit
    return " ".join(shortest)


def _number_in(value: float, si_unit: str, unit: str) -> str | None:
    """Shortest number that gives the value in another unit; None if that takes as many digits as a float has."""
    scale, offset = _factor(unit, si_unit)
    there = (value - offset) / scale
    for digits in range(1, 13):
        number = float(f"{there:.{digits}g}")
        if number * scale + offset == value:
            return repr(number).removesuffix(".0")
    return None
