"""Columns by their names, each with its unit: of files in which the names are fixed, or stated beside the file."""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from infinivar import units
from infinivar._core.frozen import FrozenDict
from infinivar.errors import InputError, ParameterError, nearest
from infinivar.tables.formats import opened
from infinivar.tables.headings import bracketed, folded, name_of, unit_and_per_kg
from infinivar.tables.sheet import Headed, headings_of, listed, refuse, shown


class NamedColumn(NamedTuple):
    """Place of a column in its file, and its unit as studies spell it, with the factor to SI; "" and 1 for a text."""

    place: int
    unit: str
    factor: float


class Named(NamedTuple):
    """Columns read by their names."""

    columns: dict[str, np.ndarray]
    """Values in SI, by name."""
    lines: np.ndarray
    """Line of the file for each row. (n,)"""
    empty: FrozenDict[int, str]
    """Rows left out, as a cell is empty: what is said of each, by its line."""


def read_named(
    file: str | Path, si_units: Mapping[str, str], required: Sequence[str], columns: Mapping[str, str] | None = None
) -> Named:
    """Read columns by their exact names, each with its unit in the heading; other columns are ignored.

    A row with an empty cell in a column that is read is left out.

    Parameters
    ----------
    file : str or Path
    si_units : mapping    SI unit of each column to read, by its name.
    required : sequence   Names of columns that the file must have.
    columns : mapping     Headings by name, where they differ: ``{"mass": "m [kg]"}``.

    Returns
    -------
    Named

    Raises
    ------
    InputError
        If the file is invalid; the message names file, line and column.
    """
    requested = {folded(text) for entry in (columns or {}).values() for text in (entry, bracketed(entry).name)}
    source = opened(
        file, lambda one: name_of(one) in si_units or bool(requested & {folded(one.text), folded(one.name)})
    )
    found = named_columns(source, si_units, columns)
    missing = [name for name in required if name not in found]
    if missing:
        plural = "" if len(required) == 1 else "s"
        raise InputError(
            f"{source.file}: {source.top}: must name the column{plural} {' and '.join(required)}; missing: "
            f"{' and '.join(missing)} (found {headings_of(source)})"
        )
    raw, lines, _ = source.numbers([one.place for one in found.values()], blank=True)
    raw, lines, empty = filled(raw, lines, list(found))
    read = {name: raw[:, at] * one.factor for at, (name, one) in enumerate(found.items())}
    return Named(read, lines, FrozenDict(empty))


def named_columns(
    source: Headed, si_units: Mapping[str, str | None], columns: Mapping[str, str] | None = None, *, bare: bool = False
) -> dict[str, NamedColumn]:
    """Find columns by their names.

    Parameters
    ----------
    source : Headed
    si_units : mapping    SI unit of each column, by its name; None for a column of texts.
    columns : mapping     Headings by name, where they differ.
    bare : bool           Whether a pure number needs no unit.

    Raises
    ------
    InputError
        If a column is there twice, or its unit is missing, unknown or of another quantity.
    """
    known_names("columns", columns or {}, tuple(si_units))
    requested = {
        place: (name, unit) for name, entry in (columns or {}).items() for place, unit in [place_of(source, entry)]
    }
    found: dict[str, NamedColumn] = {}
    for place, heading in enumerate(source.headings):
        name, unit = requested.get(place, (name_of(heading), None))
        if name not in si_units or (place not in requested and name in (columns or {})):
            continue
        if name in found:
            refuse(source, [place], "stands there twice")
        measured = si_units[name]
        if measured is None:
            found[name] = NamedColumn(place, "", 1.0)
            continue
        unit = unit or heading.unit or ("1" if bare and measured == "1" else None)
        if unit is None:
            usual = units.EXAMPLES.get(measured, f"1 {measured}").partition(" ")[2] or "%"
            refuse(source, [place], f"must state its unit, such as {shown(f'{name} [{usual}]')}")
        unit = units.standard_unit(unit)
        try:
            found[name] = NamedColumn(place, unit, units.parse(f"1 {unit}", measured))
        except InputError as problem:
            refuse(source, [place], str(problem))
    return found


def place_of(source: Headed, entry: str) -> tuple[int, str | None]:
    """Return the place of the column that a study asks for, and the unit if the study states it."""
    requested = bracketed(entry)
    ways: tuple[tuple[list[int], str | None], ...] = (
        ([place for place, one in enumerate(source.headings) if folded(one.text) == folded(entry)], None),
        (
            [place for place, one in enumerate(source.headings) if folded(one.text) == folded(requested.name)],
            requested.unit,
        ),
        (
            [place for place, one in enumerate(source.headings) if folded(one.name) == folded(requested.name)],
            requested.unit,
        ),
    )
    places, unit = next((way for way in ways if way[0]), ([], None))
    if not places:
        texts = [heading.text for heading in source.headings if heading.text]
        others = f"{nearest(entry, texts)}; it has {listed(texts)}" if source.tabular else ""
        raise InputError(f"{source.file}: {source.top}: has no column {shown(entry)}{others}")
    if len(places) > 1:
        refuse(source, places[1:], f"stands there {len(places)} times, so that {shown(entry)} in columns is not clear")
    own = source.headings[places[0]].unit
    if (
        unit is not None
        and own is not None
        and unit_and_per_kg(own) != unit_and_per_kg(unit)
        and (requested.name != source.headings[places[0]].text or unit_and_per_kg(own)[1])
    ):
        refuse(source, places, f"states the unit {own!r}, but columns states {unit!r}; remove one of the two")
    return places[0], unit


def known_names(key: str, names: Sequence[str] | Mapping[str, str], known: Sequence[str]) -> None:
    """Raise ParameterError if a key names a column that no file of this kind has."""
    for name in names:
        if name not in known:
            raise ParameterError(
                f"{key} has an unknown column {name!r}{nearest(str(name), known)}; known: {', '.join(known)}"
            )


def filled(
    raw: np.ndarray, lines: np.ndarray, names: Sequence[str], *, zero: Container[str] = ()
) -> tuple[np.ndarray, np.ndarray, dict[int, str]]:
    """Leave out rows with empty cells.

    Parameters
    ----------
    raw : (n, m) float    Cells; nan where one is empty.
    lines : (n,) int      Line of each row.
    names : (m,) str      Names of the columns.
    zero : container      Names of columns in which an empty cell is 0.

    Returns
    -------
    raw, lines, empty   Rows that stay, their lines, and what is said of the others, by line.
    """
    missing = np.isnan(raw)
    for place, name in enumerate(names):
        if name in zero:
            raw[missing[:, place], place], missing[:, place] = 0.0, False
    left_out = missing.any(axis=1)
    empty = {}
    for row in np.flatnonzero(left_out):
        gaps = [name for name, gap in zip(names, missing[row], strict=True) if gap]
        empty[int(lines[row])] = f"{' and '.join(gaps)}: empty cell"
    return raw[~left_out], lines[~left_out], empty
