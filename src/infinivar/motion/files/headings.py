"""Headings of columns: name, unit, and the quantity that the name speaks of."""

from __future__ import annotations

import functools
import re
from typing import NamedTuple

from infinivar import units
from infinivar.motion.files.table import ROLES

_BRACKETS = re.compile(r"(.*?)\s*[\[(]([^\[\]()]*)[\])]\s*", re.DOTALL)
_BLANK = re.compile("[\u00a0\u2007\u2009\u202f]")
"""Blanks of spreadsheets at which no line breaks."""
_WORDS = re.compile(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])")
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
_NAMED_PER_KG = re.compile(r"(?:/|\bper|_per)[\s_]*kg|[\s_]kg$|kg\^?-1|kg⁻¹", re.IGNORECASE)

FAMILIES: dict[str, tuple[str, ...]] = {
    "time": ("time",),
    "phase": ("phase",),
    "position": ("position", "angle"),
    "speed": ("speed", "angular_speed"),
    "force": ("moment", "force"),
    "heel_strike": ("heel_strike",),
}
"""Families of quantities that names speak of, with the roles that the unit chooses from."""

_NAMED = {
    "time": {"time", "t", "timestamp"},
    "speed": {"speed", "velocity", "vel"},
    "force": {"force", "f", "fx", "fy", "fz", "moment", "torque"},
    "position": {"position", "pos", "displacement", "disp", "stroke", "travel", "angle", "theta", "rotation"},
}
"""Words of each family; the first family with a word in the heading counts, as in "angle velocity"."""

_OF_A_ROLE = {
    "angle": {"angle", "theta", "rotation"},
    "angular_speed": {"angular", "angle", "theta", "rotation"},
    "moment": {"moment", "torque"},
    "force": {"force", "f", "fx", "fy", "fz"},
}
"""Words that leave no choice between the roles of a family."""

_JOINTS = {"hip", "knee", "ankle", "toe", "shoulder", "elbow", "wrist"}
_SIDES = {"left": "left", "l": "left", "right": "right", "r": "right", "ipsi": "ipsi", "contra": "contra"}
"""Words of the joints and sides of a body, by which columns belong together."""

_OF_A_CYCLE = {"phase", "gait", "stride", "cycle", "gc"}
_NOT_THE_MOTION = {
    "acceleration", "acc", "power", "work", "energy", "jerk", "error", "setpoint", "target", "reference", "desired",
    "command", "cmd", "std", "sd", "deviation", "arm",
}  # fmt: skip
"""Words of headings that are not the recorded motion itself; such a column is read only if a study names it."""


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
    if ratio and any(units.measures(unit_and_per_kg(ratio[2])[0], unit) for unit in ROLES.values() if unit):
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


@functools.lru_cache(maxsize=4096)
def family_of(name: str, unit: str | None) -> str | None:
    """Return the family of quantities that a name speaks of, if any."""
    words = {word.lower() for word in _WORDS.findall(name)}
    if {"heel", "strike"} <= words or "heelstrike" in words:
        return "heel_strike"
    if words & _NOT_THE_MOTION:
        return None
    if "phase" in words or (words & _OF_A_CYCLE and unit is not None and unit_and_per_kg(unit)[0] == "%"):
        return "phase"
    return next((family for family, named in _NAMED.items() if words & named), None)


def role_by_name(name: str, family: str) -> str | None:
    """Return the role among those of a family that a name leaves no choice of; None if the unit decides."""
    words = {word.lower() for word in _WORDS.findall(name)}
    return next((role for role in FAMILIES[family] if words & _OF_A_ROLE.get(role, set())), None)


def places_of(name: str) -> list[set[str]]:
    """Return the joint and the side that a name speaks of, each empty where it names none."""
    words = {word.lower() for word in _WORDS.findall(name)}
    return [words & _JOINTS, {_SIDES[word] for word in words & set(_SIDES)}]


def folded(text: str) -> str:
    """Return a heading without differences of case and blanks, for comparison."""
    return " ".join(text.casefold().split())
