"""The fields of a study as the page shows and edits them: every value with its unit, range, choices and provenance.

All follows from the fields' own metadata (`infinivar._core.fields`), as the parsers and the schema of study files do.
"""

from __future__ import annotations

import dataclasses
import functools
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from annotated_types import Gt

from infinivar import units
from infinivar._core.bounds import Bound, NonZero, permitted, words
from infinivar._core.fields import hints, quantity
from infinivar._core.text import capitalise
from infinivar.errors import InputError
from infinivar.parts.motor import Motor
from infinivar.study.provenance import DEFAULT, GIVEN, Rows, by_field, recorded, same, text_of, unscaled
from infinivar.study.schema import CATALOGUES, SHAPE, described, in_kinds, part_of, table_keys
from infinivar.study.study import Study

_SPAN = 5.0
"""Sliders of positive values reach from a fifth of the value to five times it, within what is permitted."""

_KELVINS = 60.0
"""Sliders of temperatures reach so far up and down. [K]"""

_SPLIT = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*$")

_SCALE: Any = quantity("1", Gt(0), "Number of identical motors on one shaft (may be fractional)")


@dataclass(frozen=True, slots=True)
class _Value:
    """One value of an owner: the path of its field, the class that has the field, and the value."""

    path: str
    part: type
    field: dataclasses.Field[Any]
    value: Any
    key: str = ""
    """Key that selects a kind, if the value is a kind; its word is `value`."""


def fields_of(study: Study) -> list[dict[str, Any]]:
    """Every value of a study, in the order of its owners.

    Returns
    -------
    list of dict
        owner: drive, "requirement", "rig", or "duty.NAME" and so on; path: of the field in the owner's table; at: keys from the
        top of the study's tables, where a new value is set; label, meaning: in words; group: the part that has it; written:
        as text; value: in SI; unit: SI; type: quantity, whole, flag, choice, text, row, list or part; kind, where: provenance;
        minimum, maximum, bounds_open: what is permitted, in SI; bounds: the same in words; choices: of a choice; part_kind:
        the catalogue of a part; slider: low, high in SI and log, or None; shown: number and unit as written, and factor and
        offset with which a number in this unit becomes SI.
    """
    known = by_field(study.provenance)
    found = []
    for owner, at, instance in _owners(study):
        for one in _values(instance, owner, "", known):
            row = known.get((owner, one.path))
            if one.field.metadata.get("part of catalogue"):
                found.append(_part(owner, at, one, row))
            else:
                found.append(_field(owner, at, one, row, study.name))
    return found


def _owners(study: Study) -> Iterator[tuple[str, list[str], Any]]:
    """Yield what has values: its name in provenance, the keys of its table, and the value."""
    if study.requirement is not None:
        yield "requirement", ["requirement"], study.requirement.stated
    for name, drive in study.drives.items():
        yield name, ["drives", name], drive
    for group in ("tasks", "paths", "duty", "scenarios"):
        for name, one in getattr(study, group).items():
            yield f"{group}.{name}", [group, name], one
    for name, one in study.sessions.items():
        yield f"tasks.{name}", ["tasks", name], one
    if any(row.owner == "rig" for row in study.provenance):
        yield "rig", ["rig"], study.rig


def _values(instance: Any, owner: str, prefix: str, known: Rows) -> Iterator[_Value]:
    """Yield the values of an instance and of its parts, in the order of the fields; of several motors those of one."""
    part = type(instance)
    if not dataclasses.is_dataclass(part):
        return
    single = unscaled(instance, known, owner, prefix) if isinstance(instance, Motor) else None
    if single is not None:
        yield _Value(f"{prefix}scale", part, _SCALE, known[owner, f"{prefix}scale"].value)
        instance = single
    for field in described(part):
        value = getattr(instance, field.name)
        if value is None:
            continue
        inner = part_of(hints(part)[field.name])
        if inner is None:
            if field.name != "name" or part not in CATALOGUES:
                yield _Value(prefix + field.name, part, field, value)
            continue
        stock = next((one for one in type(value).__mro__ if one in CATALOGUES), None)
        if stock is not None:
            marked = dataclasses.field(metadata={**field.metadata, "part of catalogue": CATALOGUES[stock]})
            yield _Value(prefix + field.name, part, marked, getattr(value, "name", ""))
        yield from _values(value, owner, f"{prefix}{field.name}.", known)
    for field in in_kinds(part):
        value = getattr(instance, field.name)
        if value is None:
            continue
        inside = prefix if field.metadata["flat"] else f"{prefix}{field.name}."
        key = field.metadata["key"]
        word = getattr(type(value), SHAPE if key == SHAPE else "word", type(value).__name__)
        yield _Value(f"{inside}{key}", part, field, word, key)
        yield from _values(value, owner, inside, known)


def _row(owner: str, at: list[str], path: str) -> dict[str, Any]:
    """What every field has; `label` and `group` in plain words."""
    *groups, last = path.split(".")
    return {
        "owner": owner,
        "path": path,
        "at": [*at, *path.split(".")],
        "label": _label(last),
        "group": " › ".join(_label(one) for one in groups),
        "meaning": "",
        "value": None,
        "unit": "",
        "minimum": None,
        "maximum": None,
        "bounds_open": False,
        "bounds": "",
        "choices": None,
        "part_kind": None,
        "slider": None,
        "shown": None,
    }


def _label(name: str) -> str:
    """A key in words: "cylinder radius" of cylinder_radius."""
    return capitalise(name.replace("_", " "))


def _provenance(one: _Value, row: Any, study: str) -> dict[str, str]:
    """Where a value comes from: as recorded, else - as of motions, which are requests - as the study states it."""
    if row is not None and same(row.value, recorded(one.value)):
        where = "" if row.where == GIVEN else row.where
        return {"written": row.written, "kind": row.kind, "where": where}
    default = not one.key and same(one.value, one.field.default)
    written = str(one.value) if one.key else text_of(one.field, one.value)
    return {"written": written, "kind": "assumed", "where": DEFAULT if default else study}


def _part(owner: str, at: list[str], one: _Value, row: Any) -> dict[str, Any]:
    """A part that may come from the catalogue: its key `part` is what is set."""
    made = _row(owner, at, one.path)
    return {
        **made,
        "at": [*made["at"], "part"],
        "meaning": one.field.metadata.get("meaning", ""),
        "written": one.value,
        "value": one.value,
        "type": "part",
        "kind": "catalogue" if row is None else row.kind,
        "where": "" if row is None else row.where,
        "part_kind": one.field.metadata["part of catalogue"],
    }


def _field(owner: str, at: list[str], one: _Value, row: Any, study: str) -> dict[str, Any]:
    made = {**_row(owner, at, one.path), "meaning": one.field.metadata.get("meaning", "")}
    made |= _provenance(one, row, study)
    if one.key:
        return made | {"type": "choice", "value": one.value, "choices": list(one.field.metadata["kinds"])}
    metadata = one.field.metadata
    if "unit" in metadata and isinstance(one.value, int | float):
        return made | _quantity(float(one.value), metadata["unit"], metadata["bound"], made["written"])
    return made | {"value": _shown_value(one.value), "type": _type_of(one), "choices": _choices(one)}


def _shown_value(value: Any) -> Any:
    value = recorded(value)
    return value if isinstance(value, bool | int | float | str) else None


def _type_of(one: _Value) -> str:
    if _choices(one) is not None:
        return "choice"
    metadata = one.field.metadata
    if "row of" in metadata or "words of" in metadata:
        return "row"
    if "several" in metadata or "texts of" in metadata:
        return "list"
    return "flag" if isinstance(one.value, bool) else "whole" if isinstance(one.value, int) else "text"


def _choices(one: _Value) -> list[Any] | None:
    key = table_keys(one.part).get(one.field.name)
    return None if key is None else _enumerated(key.schema or {})


def _enumerated(schema: Mapping[str, Any]) -> list[Any] | None:
    """The options of a choice, by the schema of its key: a value, or a table with a value."""
    for option in schema.get("anyOf", [schema]):
        if "enum" in option:
            return list(option["enum"])
    return None


def _quantity(value: float, unit: str, bound: Bound, written: str) -> dict[str, Any]:
    """Range, slider and unit of a number in SI."""
    low, high = permitted(bound, value or 1.0)
    shown = _as_written(written, unit)
    return {
        "type": "quantity",
        "value": value,
        "unit": unit,
        "minimum": low if math.isfinite(low) and not isinstance(bound, NonZero) else None,
        "maximum": high if math.isfinite(high) else None,
        "bounds_open": "> " in f"{words(bound)} " or "< " in words(bound),
        "bounds": words(bound),
        "slider": slider(value, unit, low, high),
        "shown": shown,
    }


def slider(value: float, unit: str, low: float, high: float) -> dict[str, Any] | None:
    """Ends of a slider about a value, in SI, within the ends of what is permitted; None if nothing tells a scale."""
    if math.isfinite(low) and math.isfinite(high):
        wide = low > 0.0 and high > 100.0 * low
        return {"low": low, "high": high, "log": wide} if not wide else _about(value, low, high)
    if unit == "K":
        return {"low": max(low, value - _KELVINS), "high": min(high, value + _KELVINS), "log": False}
    if value == 0.0:
        return None
    return _about(value, low, high)


def _about(value: float, low: float, high: float) -> dict[str, Any] | None:
    if value > 0.0:
        ends = max(low, value / _SPAN), min(high, value * _SPAN)
        return {"low": ends[0], "high": ends[1], "log": True} if ends[0] < ends[1] else None
    ends = max(low, value * _SPAN), min(high, 0.0)
    return {"low": ends[0], "high": ends[1], "log": False} if ends[0] < ends[1] else None


def _as_written(written: str, unit: str) -> dict[str, Any] | None:
    """Number and unit of a text such as "26.3 mN m", and how a number in that unit becomes SI."""
    found = _SPLIT.match(written)
    if found is None:
        return None
    scale = _scale_of(found[2], unit)
    return (
        None if scale is None else {"number": float(found[1]), "unit": found[2], "factor": scale[0], "offset": scale[1]}
    )


@functools.lru_cache(maxsize=512)
def _scale_of(written: str, unit: str) -> tuple[float, float] | None:
    """Factor and offset to SI of a unit as written; None if the text does not parse."""
    try:
        offset = units.parse(f"0 {written}".strip() if written else 0.0, unit)
        return units.parse(f"1 {written}".strip() if written else 1.0, unit) - offset, offset
    except InputError:
        return None
