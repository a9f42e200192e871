"""The fields of a study as the page shows and edits them: every value with its unit, range, choices and provenance.

All follows from the fields' own metadata (`infinivar._core.fields`), as the parsers and the schema of study files do.
"""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Iterator, Mapping
from typing import Any

from infinivar import units
from infinivar._core.bounds import Bound, NonZero, permitted, words
from infinivar._core.fields import Place
from infinivar._core.text import capitalise
from infinivar.errors import InputError
from infinivar.study.provenance import DEFAULT, GIVEN, by_field, is_table, recorded, same, text_of, values
from infinivar.study.schema import CATALOGUES, stocked, table_keys
from infinivar.study.study import Study

_SPAN = 5.0
"""Sliders of positive values reach from a fifth of the value to five times it, within what is permitted."""

_KELVINS = 60.0
"""Sliders of temperatures reach so far up and down. [K]"""

_SPLIT = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*$")


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
        for one in values(instance, owner, known):
            row = known.get((owner, one.path))
            if is_table(one):
                stock = stocked(type(one.value))
                found += [] if stock is None else [_part(owner, at, one, CATALOGUES[stock], row)]
            elif one.field.name != "name" or not stocked(type(one.owner)):
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


def _provenance(one: Place, row: Any, study: str) -> dict[str, str]:
    """Where a value comes from: as recorded, else - as of motions, which are requests - as the study states it."""
    if row is not None and same(row.value, recorded(one.value)):
        where = "" if row.where == GIVEN else row.where
        return {"written": row.written, "kind": row.kind, "where": where}
    default = same(one.value, one.field.default)
    return {"written": text_of(one.field, one.value), "kind": "assumed", "where": DEFAULT if default else study}


def _part(owner: str, at: list[str], one: Place, kind: str, row: Any) -> dict[str, Any]:
    """A part that may come from the catalogue: its key `part` is what is set."""
    made, name = _row(owner, at, one.path), getattr(one.value, "name", "")
    return {
        **made,
        "at": [*made["at"], "part"],
        "meaning": one.field.metadata.get("meaning", ""),
        "written": name,
        "value": name,
        "type": "part",
        "kind": "catalogue" if row is None else row.kind,
        "where": "" if row is None else row.where,
        "part_kind": kind,
    }


def _field(owner: str, at: list[str], one: Place, row: Any, study: str) -> dict[str, Any]:
    made = {**_row(owner, at, one.path), "meaning": one.field.metadata.get("meaning", "")}
    made |= _provenance(one, row, study)
    metadata = one.field.metadata
    if "kinds" in metadata:
        return made | {"type": "choice", "value": one.value, "choices": list(metadata["kinds"])}
    if "unit" in metadata and isinstance(one.value, int | float):
        return made | _quantity(float(one.value), metadata["unit"], metadata["bound"], made["written"])
    return made | {"value": _shown_value(one.value), "type": _type_of(one), "choices": _choices(one)}


def _shown_value(value: Any) -> Any:
    value = recorded(value)
    return value if isinstance(value, bool | int | float | str) else None


def _type_of(one: Place) -> str:
    if _choices(one) is not None:
        return "choice"
    metadata = one.field.metadata
    if "row of" in metadata or "words of" in metadata:
        return "row"
    if "several" in metadata or "texts of" in metadata:
        return "list"
    return "flag" if isinstance(one.value, bool) else "whole" if isinstance(one.value, int) else "text"


def _choices(one: Place) -> list[Any] | None:
    key = table_keys(type(one.owner)).get(one.field.name)
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
