"""Importer of plain CSV files: a column a value, with its unit in the heading, such as ``torque_constant [mN m/A]``."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from infinivar import units
from infinivar._core.text import counted
from infinivar.errors import InputError, nearest
from infinivar.parts.tables.checked_rows import NOT_STATED, Collector, checked_number
from infinivar.parts.tables.columns import Column, kind_by_columns, number_columns, text_columns
from infinivar.parts.tables.mgdb import Line

_HEADING = re.compile(r"\s*([^\[\(]*?)\s*(?:[\[\(]\s*(.*?)\s*[\]\)])?\s*$")
_PAIRS = ("motor", "gearhead")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")


@dataclass(frozen=True, slots=True)
class _Heading:
    name: str
    unit: str | None
    written: str


def kind_of(headings: Sequence[str], file: str) -> str:
    """Kind of the parts of a file, "pairs" for one that says what fits together: by the columns that only one kind has.

    Raises
    ------
    InputError
        If the headings are those of no kind; the message gives an example.
    """
    names = {heading.name for heading in _headings(headings)}
    if names == set(_PAIRS):
        return "pairs"
    kind = kind_by_columns(names)
    if kind is None or "key" not in names:
        raise InputError(
            f"{file}:1: must have headings with key and the columns of one kind of part, such as "
            '"key, voltage [V], torque_constant [mN m/A]" for motors or "key, ratio, efficiency" for gearheads'
        )
    return kind


def _headings(cells: Sequence[str]) -> list[_Heading]:
    found = []
    for cell in cells:
        parts = _HEADING.match(cell)
        name, unit = (parts[1], parts[2]) if parts else (cell.strip(), None)
        found.append(
            _Heading(name.lower().replace(" ", "_"), units.standard_unit(unit) if unit else None, cell.strip())
        )
    return found


def renamed(headings: Sequence[str], columns: Mapping[str, str], file: str) -> list[str]:
    """Headings of a file in which some columns have other names.

    Parameters
    ----------
    headings : sequence   As in the file.
    columns : mapping     Heading of the file by name of a column; with its unit in brackets where the file states none.

    Raises
    ------
    InputError
        If the file has no such heading.
    """
    made = list(headings)
    for name, entry in columns.items():
        requested = _headings([entry])[0]
        known = [one.written for one in _headings(headings)]
        place = next(
            (
                place
                for place, one in enumerate(_headings(headings))
                if one.written == entry or one.name == requested.name
            ),
            None,
        )
        if place is None:
            raise InputError(
                f"{file}:1: has no column {entry!r}{nearest(entry, known)}; it has {', '.join(map(repr, known))}"
            )
        unit = requested.unit or _headings(headings)[place].unit
        made[place] = f"{name} [{unit}]" if unit else name
    return made


def read_parts(collector: Collector, kind: str, lines: Sequence[Line], file: str) -> None:
    """Take the rows of a file; the first line has the headings."""
    headings = _headings(lines[0][1])
    columns = _columns(collector, kind, headings, file)
    lines = [lines[0], *_with_points(headings, columns, lines[1:])]
    _remark_small_shares(collector, columns, file, [dict(zip(headings, cells, strict=False)) for _, cells in lines[1:]])
    for line, cells in lines[1:]:
        if not any(cell.strip() for cell in cells):
            continue
        cells = [cell.strip() for cell in cells]
        said = {heading.name: cell for heading, cell in zip(headings, cells, strict=False)}
        try:
            if len(cells) != len(headings):
                raise InputError(
                    f"has {counted(len(cells), 'cells')}, but there are {counted(len(headings), 'headings')}"
                )
            row = _row(kind, said, columns)
        except InputError as problem:
            collector.refuse(file, line, said.get("key", ""), str(problem), kind)
            continue
        collector.add(kind, row, file, line)


def _with_points(headings: Sequence[_Heading], columns: Mapping[str, Any], lines: Sequence[Line]) -> Sequence[Line]:
    """Rows with decimal points where the file has decimal commas: where the first number with either mark has a comma."""
    places = [place for place, heading in enumerate(headings) if heading.name in columns]
    cells = (line[place].strip() for _, line in lines for place in places if place < len(line))
    first = next(
        (cell for cell in cells if _NUMBER.fullmatch(cell.replace(",", ".", 1)) and ("," in cell or "." in cell)), ""
    )
    if "," not in first:
        return lines
    return [
        (
            number,
            [
                cell.replace(",", ".", 1) if place in places and "." not in cell else cell
                for place, cell in enumerate(line)
            ],
        )
        for number, line in lines
    ]


def _columns(collector: Collector, kind: str, headings: Sequence[_Heading], file: str) -> dict[str, tuple[Column, str]]:
    """Columns of numbers that the file has, with the unit of each; unknown columns become remarks.

    Raises
    ------
    InputError
        If a unit is missing, unknown or of another quantity, or a column appears twice.
    """
    numbers, texts = number_columns(kind), text_columns(kind)
    found: dict[str, tuple[Column, str]] = {}
    seen: set[str] = set()
    for heading in headings:
        place = f"{file}:1: column {heading.written!r}"
        if heading.name in seen:
            raise InputError(f"{place}: appears twice")
        seen.add(heading.name)
        if heading.name in numbers:
            column = numbers[heading.name]
            unit = heading.unit or ("1" if column.unit == "1" else None)
            if unit is None:
                example = units.EXAMPLES.get(column.unit, f"1 {column.unit}").partition(" ")[2]
                raise InputError(f"{place} needs a unit: write for example {heading.name} [{example}]")
            _check_unit(place, unit, column)
            found[heading.name] = column, unit
        elif heading.name not in texts:
            hint = nearest(heading.name, [*numbers, *texts])
            collector.remark(file, None, f"column {heading.written!r} is no column of {kind} and was left out{hint}")
    return found


def _remark_small_shares(
    collector: Collector,
    columns: Mapping[str, tuple[Column, str]],
    file: str,
    rows: Sequence[Mapping[_Heading, str]],
) -> None:
    """Note columns in percent of which no value exceeds 1: these may be meant as fractions."""
    for name, (column, unit) in columns.items():
        if unit != "%" or column.unit != "1":
            continue
        cells = [cell.strip() for row in rows for heading, cell in row.items() if heading.name == name]
        known = [float(cell) for cell in cells if _NUMBER.fullmatch(cell)]
        if known and max(known) <= 1.0:
            collector.remark(
                file,
                None,
                f"column '{name} [%]' was read in percent, {max(known):g} as {max(known):g} %; if its values are fractions, "
                f"write {name} [1]",
            )


def _check_unit(place: str, unit: str, column: Column) -> None:
    try:
        units.parse(f"1 {unit}" if unit != "1" else 1.0, column.unit)
    except InputError as problem:
        raise InputError(f"{place} {problem}") from None


def _row(kind: str, said: Mapping[str, str], columns: Mapping[str, tuple[Column, str]]) -> dict[str, Any]:
    row: dict[str, Any] = {
        name: said[name] for name in text_columns(kind) if said.get(name, "").lower() not in NOT_STATED
    }
    for name, (column, unit) in columns.items():
        row[name] = _number(name, said[name], unit, column)
    return row


def _number(name: str, cell: str, unit: str, column: Column) -> float:
    if cell.lower() in NOT_STATED:
        return math.nan
    if cell.lower() in ("inf", "infinite", "infinity"):
        return math.inf
    try:
        value = units.parse(cell if unit == "1" else f"{cell} {unit}", column.unit)
    except InputError as problem:
        raise InputError(f"{name} = {cell[:40]!r} {problem}") from None
    try:
        return checked_number(column, value)
    except InputError as problem:
        written = "" if unit == column.unit else f", written as {cell[:40]} {unit}"
        raise InputError(f"{problem}{written}") from None


def read_pairs(collector: Collector, lines: Sequence[Line], file: str) -> None:
    """Take the lines of a file with the columns motor and gearhead; * in a key stands for any text."""
    names = [heading.name for heading in _headings(lines[0][1])]
    for line, cells in lines[1:]:
        if not any(cell.strip() for cell in cells):
            continue
        said = dict(zip(names, (cell.strip() for cell in cells), strict=False))
        if len(cells) != len(names) or not all(said.values()):
            collector.refuse(file, line, said.get("motor", ""), "must name a motor and a gearhead")
        else:
            collector.fit(file, line, said["motor"], [said["gearhead"]])
