"""Columns of numbers from CSV files, with units in the header."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Mapping
from pathlib import Path

from infinivar import units
from infinivar._core import files
from infinivar.errors import InputError

_MOST_ROWS = 1_000_000
_MOST_BYTES = 200_000_000
_SHOWN = 24
"""Characters of a cell shown in a message: enough to find it, without revealing much of a file given by mistake."""
_HEADING = re.compile(r"(.*?)\s*(?:[\[(](.*?)[\])])?\s*")


def read_columns(
    file: str,
    wanted: tuple[tuple[str, str], ...],
    required: tuple[str, ...],
    *,
    units_needed: bool = True,
    rising: str | None = "time",
) -> tuple[dict[str, list[float]], list[int]]:
    """Read columns of a CSV file.

    Parameters
    ----------
    file : str            Path of the file: a header, then rows of numbers; empty lines are skipped.
    wanted : tuple        Names of the columns to read, with their SI units; other columns are ignored.
    required : tuple      Wanted columns that the file must have.
    units_needed : bool   Whether each heading must state its unit, as in "position [mm]"; if not, the default is SI.
    rising : str          Column whose values must increase from line to line; None for none.

    Returns
    -------
    columns : dict        Values in SI, by name.
    lines : list of int   Line of the file for each row.

    Raises
    ------
    InputError
        If the file is invalid; the message names file, line and what would be right.
    """
    path = Path(file)
    content = files.read(path, _MOST_BYTES)
    values: dict[str, list[float]] = {}
    numbers: list[int] = []
    try:
        rows = csv.reader(io.StringIO(content.decode("utf-8-sig"), newline=""))
        places = _places(path, next(rows, []), dict(wanted), required, units_needed)
        values = {name: [] for name in places}
        for row in rows:
            if not any(cell.strip() for cell in row):
                continue
            line = rows.line_num
            for name, (place, factor) in places.items():
                values[name].append(_number(path, line, row, place, name) * factor)
            order = values[rising] if rising else []
            if len(order) > 1 and not order[-1] > order[-2]:
                raise InputError(f"{path}: line {line} must have a later {rising} than the line before")
            numbers.append(line)
            if len(numbers) > _MOST_ROWS:
                raise InputError(f"{path}: has more than {_MOST_ROWS} lines of numbers")
    except (UnicodeDecodeError, csv.Error) as problem:
        raise InputError(f"{path}: is not a CSV file in UTF-8") from problem
    if len(numbers) < 2:
        raise InputError(f"{path}: must have at least two lines of numbers below its header")
    return values, numbers


def _places(
    path: Path, header: list[str], wanted: Mapping[str, str], required: tuple[str, ...], units_needed: bool
) -> dict[str, tuple[int, float]]:
    """Return position and factor to SI of each wanted column in the header."""
    found: dict[str, tuple[int, float]] = {}
    for mark, called in {";": "semicolons", "\t": "tabs"}.items():
        if len(header) == 1 and mark in header[0]:
            raise InputError(
                f"{path}: must use commas between columns and points as decimal marks; line 1 has {called}"
            )
    for place, heading in enumerate(header):
        match = _HEADING.fullmatch(heading.strip())
        name, unit = (match[1].lower(), match[2]) if match else (heading, None)
        if name not in wanted:
            continue
        if name in found:
            raise InputError(f"{path}: line 1 has the column {name} twice")
        if unit is None and units_needed:
            example = f"{name} [{units.EXAMPLES[wanted[name]].split(' ', 1)[1]}]"
            raise InputError(f"{path}: line 1 must state the unit of {name}, such as {example!r}")
        try:
            factor = 1.0 if unit is None else units.parse(f"1 {unit}", wanted[name])
        except InputError as problem:
            raise InputError(f"{path}: line 1, column {name}: {problem}") from problem
        found[name] = place, factor
    _check_columns(path, header, found, required)
    return found


def _check_columns(path: Path, header: list[str], found: Mapping[str, object], required: tuple[str, ...]) -> None:
    if not found.keys() >= set(required):
        missing = " and ".join(name for name in required if name not in found)
        count = f"{len(header)} column{'' if len(header) == 1 else 's'}"
        have = f"found {', '.join(found) or 'none'} in {count}"
        wanted = f"column{'' if len(required) == 1 else 's'} {' and '.join(required)}"
        raise InputError(f"{path}: line 1 must name the {wanted}; missing: {missing} ({have})")


def _number(path: Path, line: int, row: list[str], place: int, name: str) -> float:
    """Read a finite number from one cell."""
    cell = row[place].strip() if place < len(row) else ""
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"{path}: line {line} must have a number as {name}, got {cell[:_SHOWN]!r}")
    return value
