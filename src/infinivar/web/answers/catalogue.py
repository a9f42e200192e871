"""Parts of the catalogue, found by words and conditions, to be picked for a study."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import infinivar as iv
from infinivar import units
from infinivar.parts.catalogue import PARTS
from infinivar.parts.tables.search import columns_of
from infinivar.parts.tables.stores import readable
from infinivar.web.answers.answer import Answer
from infinivar.web.answers.document import source
from infinivar.web.answers.payload import text, whole, word

MOST_ROWS = 200
"""Most parts listed."""

_MOST_CONDITIONS = 12

_COLUMNS: Mapping[str, tuple[tuple[str, str], ...]] = {
    "motors": (
        ("voltage", "V"),
        ("continuous_torque", "mN m"),
        ("max_speed", "rpm"),
        ("resistance", "ohm"),
        ("mass", "g"),
        ("diameter", "mm"),
    ),
    "gearheads": (
        ("ratio", "1"),
        ("efficiency", "1"),
        ("continuous_torque", "N m"),
        ("max_speed", "rpm"),
        ("mass", "g"),
        ("diameter", "mm"),
    ),
    "bearings": (
        ("bore", "mm"),
        ("outside_diameter", "mm"),
        ("dynamic_rating", "kN"),
        ("static_rating", "kN"),
        ("mass", "g"),
    ),
    "rails": (
        ("static_rating", "kN"),
        ("width", "mm"),
        ("carriage_mass", "g"),
        ("rail_density", "kg/m"),
    ),
    "belts": (
        ("pitch", "mm"),
        ("width", "mm"),
        ("belt_density", "g/m"),
        ("permissible_force", "N"),
    ),
    "springs": (
        ("stiffness", "N/mm"),
        ("permissible_force", "N"),
        ("wire_diameter", "mm"),
        ("outer_diameter", "mm"),
        ("free_length", "mm"),
        ("mass", "g"),
    ),
    "tubes": (
        ("outer_diameter", "mm"),
        ("wall", "mm"),
        ("tube_density", "kg/m"),
    ),
    "materials": (
        ("youngs_modulus", "GPa"),
        ("poisson", "1"),
        ("yield_strength", "MPa"),
        ("hysteresis_factor", "1"),
    ),
}
"""Columns shown of each kind of part, with the unit in which data sheets state them."""

_WORDS = ("name", "manufacturer")
_CONDITION = re.compile(r"[<>=~!]")


def parts(payload: Mapping[str, Any]) -> Answer:
    """Parts of a kind that have all words of a query and meet its conditions, such as "maxon, mass < 0.3 kg".

    With `sort`, the name of a column, from the least value, or with "-" before it from the largest; parts without one come last.
    """
    kind = word(payload, "kind", list(PARTS))
    query, limit = text(payload, "query", ""), whole(payload, "limit", 1, MOST_ROWS, 50)
    requested = [one.strip() for one in re.split(r"[,;\n]", query) if one.strip()][:_MOST_CONDITIONS]
    conditions = [one for one in requested if _CONDITION.search(one)]
    said = [one.casefold() for phrase in requested if phrase not in conditions for one in phrase.split()]
    known = columns_of(kind)
    shown = [(name, unit) for name, unit in _COLUMNS[kind] if name in known]
    sets, problems = readable(list(_beside()))
    found = iv.search_parts([one.parts for one in sets], kind, conditions, show=[*_WORDS, *(name for name, _ in shown)])
    hits = [one for one in found.hits if _has(one, said)]
    column = text(payload, "sort", "")
    if column:
        sign = -1.0 if column.startswith("-") else 1.0
        by = word({"sort": column.removeprefix("-")}, "sort", [name for name, _ in shown])
        hits.sort(key=lambda one: math.inf if one.values.get(by) is None else sign * float(one.values[by]))
    columns = [
        {"name": name, "label": name.replace("_", " "), "unit": "" if unit == "1" else unit} for name, unit in shown
    ]
    return Answer(
        header={
            "kind": kind,
            "columns": columns,
            "rows": [_row(one, shown, known) for one in hits[:limit]],
            "count": len(hits),
            "searched": found.searched,
            "verdict": found.verdict if not said else f"{len(hits):,} of {found.searched:,} {kind}",
            "problems": problems,
        }
    )


def _beside() -> Iterator[Path]:
    """Files and folders with sets of parts of the study with which the explorer was started."""
    begun = source()
    for name in sorted(begun.parts):
        if (begun.folder / name).exists():
            yield begun.folder / name


def _has(hit: Any, said: list[str]) -> bool:
    """Whether the part's key or its texts have every word."""
    within = " ".join([hit.part, *(str(hit.values.get(name) or "") for name in _WORDS)]).casefold()
    return all(one in within for one in said)


def _row(hit: Any, shown: list[tuple[str, str]], known: Mapping[str, Any]) -> dict[str, Any]:
    values, texts = {}, {}
    for name, unit in shown:
        value, column = hit.values.get(name), known[name]
        values[name] = value
        if value is None or column is None:
            texts[name] = "–"
        else:
            texts[name] = units.show_in(value, column.unit, unit).removesuffix(f" {unit}")
    return {
        "part": hit.part,
        "set": hit.set,
        "name": hit.values.get("name") or hit.key,
        "manufacturer": hit.values.get("manufacturer") or "",
        "values": values,
        "texts": texts,
    }
