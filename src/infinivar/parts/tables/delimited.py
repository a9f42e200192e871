"""Importer of CSV files: a column a value, with its unit in the heading, such as ``torque_constant [mN m/A]``, or as in MGDB."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from infinivar import units
from infinivar.errors import InputError, nearest
from infinivar.parts.tables import mgdb
from infinivar.parts.tables.checked_rows import Collector, checked_number
from infinivar.parts.tables.columns import Column, kind_by_columns, number_columns, text_columns
from infinivar.tables.headings import name_of
from infinivar.tables.named import NamedColumn, named_columns
from infinivar.tables.sheet import TextList, decimal_commas, in_column, is_number, miscounted, number_in

_PAIRS = ["motor", "gearhead"]
_NOT_STATED = frozenset({"", "-", "–", "nan", "n/a", "na"})
_INFINITE = frozenset({"inf", "+inf", "infinite", "infinity"})
"""Cells, in lower case, that state no value, and no limit."""


def read(collector: Collector, listed: TextList, path: Path, columns: Mapping[str, str]) -> None:
    """Take the rows of a file of parts, of the parts that fit together, or of the MGDB format.

    Parameters
    ----------
    collector : Collector
    listed : TextList
    path : Path
    columns : mapping   Headings by name of a column, where they differ.

    Raises
    ------
    InputError
        If the headings are those of no kind of part, or a unit is missing, unknown or of another quantity.
    """
    headings, file, rows = [heading.text for heading in listed.headings], path.name, listed.rows[1:]
    names = [name_of(heading) for heading in listed.headings]
    kind = mgdb.kind_of(headings)
    if kind is not None:
        _take(collector, kind, listed, mgdb.columns_of(kind, headings), file, mgdb.completed)
    elif path.stem.lower().endswith("compatibility"):
        mgdb.read_compatibility(collector, listed.rows, file)
    elif sorted(names, reverse=True) == _PAIRS:
        _take_pairs(collector, rows, names, file)
    else:
        kind = kind_by_columns({*names, *columns})
        if kind is None or "key" not in {*names, *columns}:
            raise InputError(
                f"{listed.file}: {listed.top}: must have headings with key and the columns of one kind of part, such as "
                '"key, voltage [V], torque_constant [mN m/A]" for motors or "key, ratio, efficiency" for gearheads'
            )
        units = {name: column.unit for name, column in number_columns(kind).items()}
        found = named_columns(listed, {**units, **dict.fromkeys(text_columns(kind))}, columns, bare=True)
        _take(collector, kind, listed, found, file)


def _take(
    collector: Collector,
    kind: str,
    listed: TextList,
    found: Mapping[str, NamedColumn],
    file: str,
    complete: Callable[[str, dict[str, Any]], list[str]] = lambda kind, row: [],
) -> None:
    """Take the rows of parts of a kind, completed; bad ones become faults, columns that are not used remarks."""
    numbers, rows = number_columns(kind), listed.rows[1:]
    used = {one.place for one in found.values()}
    for place, heading in enumerate(listed.headings):
        if place not in used:
            hint = nearest(name_of(heading), [*numbers, *text_columns(kind)])
            collector.remark(file, None, f"column {heading.text!r} is no column of {kind} and was left out{hint}")
    measured = {name: one for name, one in found.items() if name in numbers}
    _remark_small_shares(collector, measured, rows, file)
    places = [one.place for one in measured.values()]
    comma = decimal_commas(cells[place] for _, cells in rows for place in places if place < len(cells))
    for line, cells in rows:
        said = {name: cells[one.place] for name, one in found.items() if one.place < len(cells)}

        def made(cells: list[str] = cells, said: dict[str, str] = said) -> tuple[dict[str, Any], list[str]]:
            if wrong := miscounted(listed, cells):
                raise InputError(in_column(listed, *wrong))
            row: dict[str, Any] = {name: text for name, text in said.items() if text.lower() not in _NOT_STATED}
            row |= {name: _number(listed, one, said[name], numbers[name], comma) for name, one in measured.items()}
            return row, complete(kind, row)

        collector.take(kind, file, line, said.get("key", ""), made)


def _remark_small_shares(
    collector: Collector, measured: Mapping[str, NamedColumn], rows: Sequence[tuple[int, list[str]]], file: str
) -> None:
    """Note columns in percent of which no value exceeds 1: these may be meant as fractions."""
    for name, one in measured.items():
        cells = (cells[one.place] for _, cells in rows if one.unit == "%" and one.place < len(cells))
        known = [float(cell.replace(",", ".", 1)) for cell in cells if is_number(cell)]
        known = [value for value in known if math.isfinite(value)]
        if known and max(known) <= 1.0:
            collector.remark(
                file,
                None,
                f"column '{name} [%]' was read in percent, {max(known):g} as {max(known):g} %; if its values are fractions, "
                f"write {name} [1]",
            )


def _number(listed: TextList, one: NamedColumn, cell: str, column: Column, comma: bool) -> float:
    """Value of a cell in SI, nan where none is stated; a bound is checked here where the file has another unit, to name it."""
    if cell.lower() in _NOT_STATED:
        return math.nan
    if cell.lower() in _INFINITE:
        return math.inf
    try:
        value = units.parse(f"{number_in(cell, comma)!r} {one.unit}", column.unit)
    except InputError as problem:
        raise InputError(in_column(listed, one.place, str(problem))) from None
    if one.unit == column.unit:
        return value
    try:
        return checked_number(column, value)
    except InputError as problem:
        raise InputError(f"{problem}, written as {cell[:40]} {one.unit}") from None


def _take_pairs(collector: Collector, rows: Sequence[tuple[int, list[str]]], names: Sequence[str], file: str) -> None:
    """Take rows with the columns motor and gearhead; * in a key stands for any text."""
    for line, cells in rows:
        said = dict(zip(names, cells, strict=False))
        if len(cells) != len(names) or not all(cells):
            collector.refuse(file, line, said.get("motor", ""), "must name a motor and a gearhead")
        else:
            collector.fit(file, line, said["motor"], [said["gearhead"]])
