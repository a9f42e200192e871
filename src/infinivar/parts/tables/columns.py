"""Columns of the tables of parts: the fields of each part, and the further figures that data sheets state."""

from __future__ import annotations

import dataclasses
import functools
import math
import typing
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Literal

from annotated_types import Ge, Gt, Interval

from infinivar import units
from infinivar._core.bounds import Bound, NonZero
from infinivar._core.fields import hints
from infinivar.errors import InputError, nearest
from infinivar.parts.catalogue import PARTS
from infinivar.parts.gearhead import PARTS_OF_LAWS

Kind = Literal["motors", "gearheads", "bearings", "rails", "belts", "springs", "tubes", "materials"]

ONE = {
    "motors": "motor",
    "gearheads": "gearhead",
    "bearings": "bearing",
    "rails": "rail",
    "belts": "belt",
    "springs": "spring",
    "tubes": "tube",
    "materials": "material",
}
"""One row of each table, in words."""

ORIGIN = {
    "key": "Key of the part in its set",
    "name": "Name for reports",
    "manufacturer": "Manufacturer",
    "order_number": "Order number of the manufacturer",
    "source": "Data sheet, file or publication that states the values",
    "date": "Date of the source, as precise as it is known",
    "kind": "stated, catalogue, derived, fitted or assumed",
    "derived": "Columns that the importer derived from others, separated by spaces",
}
"""Text columns of every table."""

UNLIMITED = frozenset(
    {"peak_torque", "max_speed", "continuous_torque", "intermittent_torque", "continuous_speed", "continuous_power"}
)
"""Columns in which an infinite value means that no limit is stated."""

_USUAL = {
    "rad/s": "rpm",
    "N m/A": "mN m/A",
    "kg": "g",
    "m": "mm",
    "H": "mH",
    "kg m^2": "g cm^2",
    "Pa": "MPa",
    "N": "kN",
    "m^2/s": "mm^2/s",
    "N/m": "N/mm",
}
"""Units in which data sheets state values."""

_USUAL_OF = {"motors": {"N m": "mN m"}, "springs": {"N": "N"}}
"""Those of a kind of part, where they differ."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """A column of numbers in SI; nan where a row does not state the value."""

    name: str
    unit: str
    bound: Bound
    meaning: str
    required: bool = False


def _stated(name: str, unit: str, bound: Bound, meaning: str) -> Column:
    return Column(name=name, unit=unit, bound=bound, meaning=meaning)


_SHARE = Interval(gt=0, le=1)
_FURTHER: Mapping[str, tuple[Column, ...]] = {
    "motors": (
        _stated("stated_no_load_speed", "rad/s", Gt(0), "No-load speed as stated"),
        _stated("continuous_speed", "rad/s", Gt(0), "Speed of continuous operation as stated; no limit"),
        _stated("continuous_power", "W", Gt(0), "Mechanical power of continuous operation as stated; no limit"),
        _stated("stated_stall_torque", "N m", Gt(0), "Stall torque as stated"),
        _stated("stated_stall_current", "A", Gt(0), "Stall current as stated"),
        _stated("stated_continuous_current", "A", Gt(0), "Continuous current as stated"),
        _stated("stated_peak_efficiency", "1", _SHARE, "Peak efficiency as stated"),
        _stated("stated_friction_torque", "N m", Ge(0), "Friction torque independent of speed as stated"),
    ),
    "gearheads": (
        _stated("stages", "1", Gt(0), "Number of stages"),
        _stated("direction", "1", NonZero(), "1: output turns as the input; -1: the other way"),
    ),
}
"""Figures of data sheets that are no fields of the part. Those of motors follow from the others, which `check` compares."""

_FURTHER_TEXTS: Mapping[str, Mapping[str, str]] = {
    "motors": {"type": "Type, such as DC or BLDC"},
    "gearheads": {"type": "Type, such as planetary or spur"},
}


@functools.cache
def number_columns(kind: str) -> Mapping[str, Column]:
    """Columns of numbers of a kind of table, by name: fields of the part, those of the laws of gears, further figures."""
    found = {column.name: column for column in _of(PARTS[kind], "")}
    if kind == "gearheads":
        found |= {column.name: column for name, part in PARTS_OF_LAWS.items() for column in _of(part, f"{name}.")}
    return {**found, **{column.name: column for column in _FURTHER.get(kind, ())}}


def _of(part: type, prefix: str) -> list[Column]:
    return [
        Column(
            name=prefix + field.name,
            unit=field.metadata["unit"],
            bound=field.metadata["bound"],
            meaning=field.metadata["meaning"],
            required=not prefix and field.default is dataclasses.MISSING,
        )
        for field in dataclasses.fields(part)
        if "unit" in field.metadata
    ]


@functools.cache
def text_columns(kind: str) -> Mapping[str, str]:
    """Columns of texts of a kind of table, and what they mean."""
    part = PARTS[kind]
    words = {field.name: field.metadata["meaning"] for field in dataclasses.fields(part) if field.name in choices(kind)}
    return {**ORIGIN, **_FURTHER_TEXTS.get(kind, {}), **words}


@functools.cache
def choices(kind: str) -> Mapping[str, tuple[str, ...]]:
    """Text columns that are fields of the part, with the words they accept."""
    found = {}
    for field in dataclasses.fields(PARTS[kind]):
        hint = hints(PARTS[kind])[field.name]
        if typing.get_origin(hint) is Literal and all(isinstance(word, str) for word in typing.get_args(hint)):
            found[field.name] = typing.get_args(hint)
    return found


def shown(value: float, unit: str, kind: str = "") -> str:
    """A value in SI in the unit in which data sheets state it; "–" where it is not stated."""
    if math.isnan(value):
        return "–"
    if unit == "K":
        return units.celsius(value)
    usual = _USUAL_OF.get(kind, {}).get(unit, _USUAL.get(unit, unit))
    return units.show(value, unit) if usual == unit else units.show_in(value, unit, usual)


def kind_by_columns(names: Iterable[str]) -> str | None:
    """Kind of table that has most of some columns which no other kind has; None if no kind has any."""
    requested = set(names)
    scores = {kind: len(requested & own) for kind, own in _own_columns().items()}
    best = max(scores, key=lambda kind: scores[kind])
    return best if scores[best] else None


@functools.cache
def _own_columns() -> Mapping[str, frozenset[str]]:
    known = {kind: frozenset(number_columns(kind)) for kind in PARTS}
    return {
        kind: own.difference(*(other for one, other in known.items() if one != kind)) for kind, own in known.items()
    }


def check_kind(kind: str) -> None:
    """Raise InputError unless it is a kind of table."""
    if kind not in PARTS:
        raise InputError(f"{kind!r} must be one of {', '.join(PARTS)}{nearest(kind, PARTS)}")
