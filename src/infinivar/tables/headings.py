"""Headings of columns: their names and units."""

from __future__ import annotations

import re
from typing import NamedTuple

from infinivar import units

_BRACKETS = re.compile(r"(.*?)\s*[\[(]([^\[\]()]*)[\])]\s*", re.DOTALL)
_BLANK = re.compile("[\u00a0\u2007\u2009\u202f]")
"""Blanks of spreadsheets at which no line breaks."""
_PER_KG = re.compile(r"\s*(?:/\s*kg|[ *·⋅.]kg\^?-1|[ *·⋅.]kg⁻¹)")

_SUFFIXES = {
    **{unit: unit for unit in ("m", "cm", "mm", "um", "s", "ms", "us", "min", "rad", "mrad", "deg", "rev", "rpm")},
    **{unit: unit for unit in ("N", "mN", "kN", "Nm", "mNm", "kNm", "Nmm", "N_m", "mN_m", "kN_m", "N_mm")},
    **{f"{unit}_s": f"{unit}/s" for unit in ("m", "cm", "mm", "rad", "mrad", "deg", "rev")},
    **{f"{unit}/s": f"{unit}/s" for unit in ("m", "cm", "mm", "rad", "mrad", "deg", "rev")},
    **{f"{unit}{per}kg": f"{unit}/kg" for unit in ("N", "Nm", "N_m", "N-m", "N.m", "N·m") for per in ("_", "/")},
    **dict.fromkeys(("pct", "percent"), "%"),
}
"""Units behind an underscore at the end of a heading."""

_LOUD = {suffix.upper(): unit for suffix, unit in _SUFFIXES.items() if not suffix.startswith("mN")}
"""The same for headings in capitals alone; "MN" could be a thousandth or a million of newtons."""

_QUOTIENT = re.compile(r"(.+?)\s+/\s*(\S.*)")
_OF_QUOTIENTS = ("s", "1", "m", "m/s", "N", "rad", "rad/s", "N m")
"""Quantities whose unit may stand behind a stroke, as in "Pos / mm"."""

_NAMED_PER_KG = re.compile(r"(?:/|\bper|_per)[\s_]*kg|[\s_]kg$|kg\^?-1|kg⁻¹", re.IGNORECASE)


class Heading(NamedTuple):
    """Heading of a column as written, its name without the unit, and the unit as written; None without one.

    ``below`` is the line of the unit if it stands in a row of units below the headings, else 0.
    """

    text: str
    name: str
    unit: str | None
    below: int = 0


def bracketed(text: str) -> Heading:
    """Take a heading apart whose unit, if any, stands in brackets."""
    text = _BLANK.sub(" ", text).strip()
    found = _BRACKETS.fullmatch(text)
    return Heading(text, found[1].rstrip("/ \t").strip(), found[2].strip()) if found else Heading(text, text, None)


def heading_of(text: str) -> Heading:
    """Take a heading apart: ``Pos (mm)``, ``pos [mm]``, ``pos_mm``, ``POS_MM``, ``Pos / mm``, ``% gait cycle``."""
    found = bracketed(text)
    if found.unit is not None:
        return found
    text = found.text
    if text.startswith("%") or text.endswith("%"):
        return Heading(text, text.strip("% "), "%")
    ratio = _QUOTIENT.fullmatch(text)
    if ratio and any(units.measures(unit_and_per_kg(ratio[2])[0], unit) for unit in _OF_QUOTIENTS):
        return Heading(text, ratio[1].strip(), ratio[2].strip())
    parts = text.split("_")
    known = _LOUD if text.isupper() else _SUFFIXES
    for count in (3, 2, 1):
        unit = known.get("_".join(parts[-count:]))
        if unit is not None and len(parts) > count:
            return Heading(text, "_".join(parts[:-count]), unit)
    return Heading(text, text, None)


def unit_and_per_kg(unit: str) -> tuple[str, bool]:
    """Return a unit as studies spell it, and whether it is per kilogram of body mass: "Nm/kg" is "N m" per kilogram."""
    base = _PER_KG.sub("", unit)
    per_kg, unit = base != unit, base.strip()
    return units.standard_unit(unit), per_kg


def named_per_kg(name: str) -> bool:
    """Whether the name of a column, without its unit, says that its values are per kilogram: "ankle moment Nm/kg"."""
    return _NAMED_PER_KG.search(name) is not None


def folded(text: str) -> str:
    """Return a heading without differences of case and blanks, for comparison."""
    return " ".join(text.casefold().split())


def name_of(heading: Heading) -> str:
    """Return the name of a column as keys are written: "Motor speed (rpm)" as "motor_speed"."""
    return folded(heading.name).replace(" ", "_")
