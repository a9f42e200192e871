"""Sets of parts as text: one line per part, a part with all it states, the outcome of a search and of a check."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from infinivar._core.text import counted
from infinivar.parts.tables.columns import ONE, number_columns, shown, text_columns
from infinivar.parts.tables.consistency import CatalogueCheck
from infinivar.parts.tables.importing import PartImport
from infinivar.parts.tables.search import Hit, PartSearch, columns_of, derived, derived_columns, values
from infinivar.parts.tables.stores import SHIPPED, Place, shipped
from infinivar.parts.tables.table import PartSet

_LISTED: dict[str, tuple[tuple[str, str, str, float], ...]] = {
    "motors": (
        ("voltage", "voltage", "V", 1.0),
        ("cont. torque", "continuous_torque", "mN m", 1e3),
        ("no-load speed", "no_load_speed", "rpm", 30.0 / math.pi),
        ("peak efficiency", "peak_efficiency", "%", 1e2),
        ("mass", "mass", "g", 1e3),
    ),
    "gearheads": (
        ("ratio", "ratio", "", 1.0),
        ("efficiency", "efficiency", "%", 1e2),
        ("cont. torque", "continuous_torque", "N m", 1.0),
        ("mass", "mass", "g", 1e3),
    ),
    "bearings": (
        ("bore", "bore", "mm", 1e3),
        ("outside", "outside_diameter", "mm", 1e3),
        ("dynamic rating", "dynamic_rating", "kN", 1e-3),
        ("static rating", "static_rating", "kN", 1e-3),
        ("mass", "mass", "g", 1e3),
    ),
    "rails": (
        ("static rating", "static_rating", "kN", 1e-3),
        ("width", "width", "mm", 1e3),
        ("carriage", "carriage_mass", "g", 1e3),
        ("rail", "rail_density", "kg/m", 1.0),
    ),
    "belts": (
        ("pitch", "pitch", "mm", 1e3),
        ("width", "width", "mm", 1e3),
        ("mass", "belt_density", "g/m", 1e3),
        ("force", "permissible_force", "N", 1.0),
    ),
    "springs": (
        ("stiffness", "stiffness", "N/mm", 1e-3),
        ("force", "permissible_force", "N", 1.0),
        ("wire", "wire_diameter", "mm", 1e3),
        ("outer diameter", "outer_diameter", "mm", 1e3),
        ("mass", "mass", "g", 1e3),
    ),
    "tubes": (
        ("outer diameter", "outer_diameter", "mm", 1e3),
        ("wall", "wall", "mm", 1e3),
        ("mass", "tube_density", "kg/m", 1.0),
    ),
    "materials": (
        ("Young's modulus", "youngs_modulus", "GPa", 1e-9),
        ("Poisson", "poisson", "", 1.0),
        ("yield strength", "yield_strength", "MPa", 1e-6),
        ("hardness", "hardness", "GPa", 1e-9),
    ),
}
"""Columns of a listing: heading, column, unit, factor from SI."""

_WORST = 10
_WIDTH = 14


def text(parts: PartSet | None = None, kinds: Iterable[str] = ()) -> str:
    """All parts of a set, by default those of the shipped one, a line each; of some kinds or of all."""
    parts = shipped() if parts is None else parts
    chosen = list(kinds) or [kind for kind, table in parts.tables.items() if table]
    return "".join(f"{line}\n" for kind in chosen for line in _listing(parts, kind))


def _listing(parts: PartSet, kind: str) -> Iterator[str]:
    """Table of one kind of part, blank where a value is unknown."""
    table = parts.tables[kind]
    keys = table.part_keys
    width = max([29, *map(len, keys)]) + 1
    yield f"{ONE[kind]:<{width}}" + "".join(f"{heading:>18}" for heading, *_ in _LISTED[kind])
    columns = [(values(table, name) * factor, unit) for _, name, unit, factor in _LISTED[kind]]
    for row, key in enumerate(keys):
        cells = (_cell(float(column[row]), unit) for column, unit in columns)
        yield f"{key:<{width}}" + "".join(f"{cell:>18}" for cell in cells)
    yield ""


def _cell(value: float, unit: str) -> str:
    return "" if math.isnan(value) else f"{value:{'.0f' if value >= 1e3 else '.4g'}} {unit}".rstrip()


def sets(places: Sequence[tuple[Place, str]]) -> Iterator[str]:
    """A line for each set: name, contents, place."""
    width = max(len(place.name) for place, _ in places)
    for place, contents in places:
        yield f"{place.name:<{width}}  {contents}  ({place.where})"


def part(parts: PartSet, kind: str, key: str) -> Iterator[str]:
    """All that a set states of a part, what follows from it, and what fits it."""
    table = parts.tables[kind]
    said = table.stated(key)
    origin = ", ".join(str(said[name]) for name in ("manufacturer", "order_number", "source", "date") if name in said)
    yield f"{ONE[kind]} {key if parts.name == SHIPPED else f'{parts.name}:{key}'}: {said.get('name', key)}"
    yield f"  from: {origin or 'not stated'}"
    numbers = {name: column for name, column in number_columns(kind).items() if name in said}
    for name, column in numbers.items():
        yield _line(name, shown(said[name], column.unit, kind), column.meaning)
    for name, meaning in text_columns(kind).items():
        if name in said and name not in ("key", "name", "manufacturer", "order_number", "source", "date"):
            yield _line(name, str(said[name]), meaning)
    row = table.row(key)
    for name, column in derived_columns(kind).items():
        value = float(derived(table, name)[row])
        if not math.isnan(value):
            yield _line(name, shown(value, column.unit, kind), column.meaning)
    missing = table.missing(key)
    if missing:
        yield f"  cannot be used in a drive: {', '.join(missing)} not stated"
    if kind == "motors" and parts.gearheads:
        yield _fitting(parts, key)


def _line(name: str, value: str, meaning: str) -> str:
    return f"  {name:<28} {value:<16} {meaning}"


def _fitting(parts: PartSet, key: str) -> str:
    if not parts.pairs_stated:
        return "  gearheads: the set does not state which fit"
    fitting = parts.gearheads_for(key)
    some = ", ".join(fitting[:3]) + (", ..." if len(fitting) > 3 else "")
    return f"  gearheads: {len(fitting)} fit{f' ({some})' if fitting else ''}"


def search(found: PartSearch) -> Iterator[str]:
    """The parts found, a line each, and how many they are."""
    if found.hits:
        names = [hit.part for hit in found.hits]
        width = max([len("part"), *map(len, names)]) + 2
        cells = [[_value(found.kind, hit, name) for name in found.columns] for hit in found.hits]
        widths = [
            max([_WIDTH, len(name), *(len(row[place]) for row in cells)]) + 2
            for place, name in enumerate(found.columns)
        ]
        yield f"{'part':<{width}}" + "".join(f"{name:>{w}}" for name, w in zip(found.columns, widths, strict=True))
        for name, row in zip(names, cells, strict=True):
            yield (f"{name:<{width}}" + "".join(f"{cell:>{w}}" for cell, w in zip(row, widths, strict=True))).rstrip()
    yield found.verdict


def _value(kind: str, hit: Hit, name: str) -> str:
    value, column = hit.values[name], columns_of(kind)[name]
    if value is None or column is None:
        return "–" if value is None else str(value)
    return shown(float(value), column.unit, kind)


def check(found: CatalogueCheck, every: bool = False) -> Iterator[str]:
    """The verdict, what cannot be used, and the contradictions: the worst, or every one."""
    yield found.verdict
    for kind, count in found.incomplete.items():
        verb = "lacks" if count == 1 else "lack"
        yield f"  {count} of {counted(found.rows[kind], kind)} {verb} a value that a drive needs"
    yield from _worst([one.text for one in found.contradictions], every)
    yield from _worst([f"cannot be used: {reason}" for reason in found.unusable], every)


def _worst(lines: Sequence[str], every: bool) -> Iterator[str]:
    some = lines if every else lines[:_WORST]
    yield from (f"  {line}" for line in some)
    if len(lines) > len(some):
        yield f"  ... and {len(lines) - len(some)} more; --all lists them"


def imported(found: PartImport) -> Iterator[str]:
    """What was read, and what was read in another way than written."""
    yield found.verdict
    for kind, counts in found.unstated.items():
        yield f"  {kind} that do not state: " + ", ".join(f"{name} {count:,}" for name, count in counts.items())
    for kind, counts in found.incomplete.items():
        for name, count in counts.items():
            verb, they = ("does", "it") if count == 1 else ("do", "they")
            table = found.parts.tables[kind]
            keys = [key for key in table.part_keys if name in table.missing(key)]
            listed = ", ".join(keys[:_WORST]) + (", ..." if len(keys) > _WORST else "")
            yield f"  {counted(count, kind)} {verb} not state {name}: {they} cannot be used in a drive: {listed}"
    for remark in found.remarks:
        yield f"  {remark}"


def row_values(parts: PartSet, kind: str, key: str) -> dict[str, object]:
    """All that a set states of a part, for JSON: numbers in SI, and texts."""
    said = parts.tables[kind].stated(key)
    return {name: value.item() if isinstance(value, np.generic) else value for name, value in said.items()}
