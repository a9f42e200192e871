"""Formats of files with columns: delimited text, storage and motion files of OpenSim, and Parquet.

Delimited text has commas, semicolons, tabs or blanks between its columns, decimal points or commas. Files of OpenSim (.sto, .mot)
have a header that ends with ``endheader``, then columns between tabs or blanks; lengths, forces and moments are in SI, and
``inDegrees`` states the unit of angles. Parquet files, such as those of the LocoHub standard of locomotion data, need pyarrow.
"""

from __future__ import annotations

import dataclasses
import importlib
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

import numpy as np

from infinivar._core import extras, files
from infinivar.errors import InputError, printable
from infinivar.tables.encodings import Text, text_of
from infinivar.tables.headings import Heading, bracketed, heading_of, unit_and_per_kg
from infinivar.tables.sheet import (
    MOST_ROWS,
    QUOTE,
    Source,
    TextSheet,
    cells_of,
    fault,
    is_comment,
    is_number,
    mark_between,
    shown,
)

Known = Callable[[Heading], bool]
"""Whether a heading names a quantity that the reader looks for, by which the line of the headings is found."""

_MAGIC = b"PAR1"
_MOST_BYTES = 200_000_000

_END = "endheader"
_LONGEST_HEADER = 200
_LINE = re.compile(r"\s*([A-Za-z_]\w*)\s*(?:=|\s)\s*(.*?)\s*")
_COUNTS = {"nrows": "rows", "datarows": "rows", "ncolumns": "columns", "datacolumns": "columns"}
_GENERALIZED = {"_moment": "N m", "_force": "N"}
"""Units of generalized forces by the end of their headings, as inverse dynamics writes them."""


_HEADED = re.compile(r"[^\s\[(]\S*?(?:\s*(?:\[[^\]]*\]|\([^)]*\)))?(?=\s|$)")
"""A heading in a line of headings between blanks: a word, with its unit in brackets if it has one."""

_COMMENT = re.compile(r"^\s*(?:#|//)\s*|^\s*%\s*(?!\s*(?:gait|stride|cycle|of|gc)\b)", re.IGNORECASE)
"""Sign of a comment at the start of a line; "% gait cycle" is a heading."""

_MOST_COLUMNS = 10_000
_LONGEST_PREAMBLE = 200
"""Lines above the first row of numbers."""

_USUAL_UNITS = {
    "s", "ms", "us", "min", "m", "mm", "cm", "um", "rad", "deg", "mrad", "rev", "rpm", "N", "kN", "mN", "m/s",
    "mm/s", "rad/s", "deg/s", "m/s^2", "V", "mV", "A", "mA", "W", "K", "degC", "°C", "Hz", "g", "kg", "Pa",
    "kPa", "bar", "%", "1", "N m", "mN m", "kN m",
}  # fmt: skip
"""Units that tell a row of units from a row of headings."""


def opened(file: str | Path, known: Known) -> Source:
    """Open a file of columns in the format that its content reveals.

    Parameters
    ----------
    file : str or Path
    known : callable     Whether a heading names a quantity that is looked for.

    Raises
    ------
    InputError
        If it cannot be read or is in no known format.
    """
    path = Path(file)
    content = files.read(path, _MOST_BYTES)
    name = printable(path)
    if content.startswith(_MAGIC):
        return ParquetSheet(name, content)
    text = text_of(name, content)
    if path.suffix.lower() in (".sto", ".mot") or looks_like_opensim(text.lines):
        return opensim(name, text)
    return delimited(name, text, known)


def delimited(file: str, text: Text, known: Known) -> TextSheet:
    """Find the headings of a text file, what stands between its columns, and their units.

    Headings stand above the first row of numbers, possibly in a comment; what a logger writes above them is skipped. A row of
    units may follow.

    Raises
    ------
    InputError
        If there are no headings; the message names file and line.
    """
    lines = text.lines
    bare = next((place for place, line in enumerate(lines) if not is_comment(line) or _is_percent(line)), None)
    if bare is None:
        first = next(place for place, line in enumerate(lines) if line.strip())
        raise InputError(f"{file}: line {first + 1}: must name the columns; the file has comments only")
    header = _header(lines, bare, known)
    top = _COMMENT.sub("", lines[header], count=1)
    first = next((lines[place] for place in range(header + 1, len(lines)) if not is_comment(lines[place])), "")
    mark = mark_between(top, first)
    written = _headings(file, header, top, first, mark)
    sheet = TextSheet(
        file=file,
        kind="CSV" if mark == "," or mark == ";" else "text",
        encoding=text.encoding,
        lines=lines,
        mark=mark,
        header=header + 1,
        headings=tuple(map(heading_of, written)),
        start=header + 1,
        units={},
    )
    after = next((place for place in range(header + 1, len(lines)) if lines[place].strip()), None)
    return sheet if after is None else with_units_row(sheet, after)


def _is_percent(line: str) -> bool:
    """Whether a line starts with "% gait cycle", a heading rather than a comment."""
    return line.lstrip().startswith("%") and _COMMENT.match(line) is None


def _header(lines: list[str], bare: int, known: Known) -> int:
    """Return the line of the headings, given the first line that is no comment.

    If that line holds numbers, the headings are the comment above. Otherwise they are the line above the first row of numbers
    with most headings that name a quantity; of several such lines the one that is no row of units, and the last.
    """
    if _is_row(lines[bare]):
        return next((place for place in range(bare - 1, -1, -1) if lines[place].strip()), bare)
    above = []
    for place in range(bare, min(bare + _LONGEST_PREAMBLE, len(lines))):
        line = lines[place]
        if not is_comment(line) or place == bare:
            if _is_row(line):
                break
            above.append(place)
    else:
        return bare
    count = len(_parts(line, mark_between(line, line)))
    fitting = [place for place in above if len(_parts(lines[place], mark_between(lines[place], line))) == count]
    return max(fitting or above, key=lambda place: (*_merits(lines[place], line, known), place))


def _merits(line: str, row: str, known: Known) -> tuple[int, bool]:
    """Return how many cells of a line name a quantity, and whether it is no row of units."""
    cells = [heading_of(cell) for cell in _parts(line, mark_between(line, row)) if cell.strip()]
    units = sum(unit_and_per_kg(cell.text.strip("[]()"))[0] in _USUAL_UNITS for cell in cells)
    return sum(map(known, cells)), 2 * units < len(cells)


def _parts(line: str, mark: str | None) -> list[str]:
    """Split a line into cells, whether or not its quotes are closed."""
    try:
        return cells_of(line, mark)
    except ValueError:
        return line.split(mark)


def _is_row(line: str) -> bool:
    """Whether most cells of a line are numbers."""
    cells = _parts(line, mark_between(line, line))
    return 2 * sum(map(is_number, cells)) > len(cells)


def _is_numeric(line: str) -> bool:
    """Whether a line holds numbers only, whatever stands between them."""
    return all(is_number(cell) for cell in re.split(r"[\s,;]+", line.strip(" \t,;")))


def _headings(file: str, header: int, top: str, first: str, mark: str | None) -> list[str]:
    """Split the line of headings.

    Raises
    ------
    InputError
        If it holds numbers, a quote is not closed, or it cannot be split as the rows are.
    """
    if _is_numeric(top):
        raise InputError(f"{file}: line {header + 1}, column 1: must name the columns, got a number")
    if mark is None:
        return _between_blanks(file, header, top, len(first.split()))
    try:
        written = cells_of(top, mark)
    except ValueError:
        place = top[: top.rfind('"')].count(mark) + 1
        raise InputError(f"{file}: line {header + 1}, column {place}: {QUOTE}") from None
    while len(written) > 1 and not written[-1].strip():
        written.pop()
    if len(written) > _MOST_COLUMNS:
        raise InputError(f"{file}: line {header + 1}, column {_MOST_COLUMNS + 1}: is one too many")
    return written


def _between_blanks(file: str, header: int, top: str, count: int) -> list[str]:
    """Split headings between blanks, which may also stand inside a heading, into as many as a row has cells."""
    ways = (re.split(r"\s{2,}", top.strip()), _HEADED.findall(top.strip()), top.split(), [top.strip()])
    for way in ways:
        if len(way) == count:
            return way
    if not count:
        return ways[1] or ways[0]
    raise InputError(
        f"{file}: line {header + 1}, column {min(count, len(ways[1])) + 1}: has {len(ways[1])} headings above rows of "
        f"{count} cells; set headings apart by commas, semicolons, tabs or two blanks"
    )


def with_units_row(sheet: TextSheet, row: int) -> TextSheet:
    """Take the units from the row below the headings, if it is one: cells without any number.

    Raises
    ------
    InputError
        If its units contradict those of the headings.
    """
    try:
        cells = cells_of(sheet.lines[row], sheet.mark)
    except ValueError:
        return sheet
    count = len(cells) if cells[-1].strip() else len(sheet.headings)
    if any(map(is_number, cells)) or count != len(sheet.headings) or is_comment(sheet.lines[row].replace("%", "")):
        return sheet
    made = []
    for place, heading in enumerate(sheet.headings):
        cell = cells[place].strip().strip("[]()").strip() if place < len(cells) else ""
        if heading.unit is not None and cell and unit_and_per_kg(heading.unit) != unit_and_per_kg(cell):
            fault(
                sheet, row + 1, place,
                f"must be a number, or repeat the unit {heading.unit!r}, got {shown(cell)}",
            )  # fmt: skip
        made.append(heading if not cell else Heading(heading.text, heading.name, cell, row + 1))
    return dataclasses.replace(sheet, headings=tuple(made), start=row + 1)


class _Entry(NamedTuple):
    """An entry of the header: line, key and text."""

    line: int
    key: str
    text: str


def looks_like_opensim(lines: list[str]) -> bool:
    """Whether lines are those of an OpenSim file: its header ends with a certain word."""
    return any(line.strip().lower() == _END for line in lines[:_LONGEST_HEADER])


class OpenSimSheet(TextSheet):
    """Rows of an OpenSim file."""

    __slots__ = ()

    def usual_unit(self, role: str, heading: Heading) -> str | None:
        """Unit that the format states: by ``inDegrees`` for angles, else by the kind of generalized force."""
        if role in self.units:
            return self.units[role]
        ends = next((unit for end, unit in _GENERALIZED.items() if heading.text.endswith(end)), None)
        return ends if ends == {"moment": "N m", "force": "N"}.get(role) else None


def opensim(file: str, text: Text) -> OpenSimSheet:
    """Read the header of an OpenSim file and check what it states about its columns and rows.

    Raises
    ------
    InputError
        If the header does not end, or states other numbers of rows or columns than the file has; the message names the line.
    """
    lines = text.lines
    end = next((place for place, line in enumerate(lines) if line.strip().lower() == _END), None)
    if end is None:
        raise InputError(
            f"{file}: line {min(len(lines), _LONGEST_HEADER)}, column 1: must be {_END!r} here or above, the end of the header "
            "of an OpenSim file"
        )
    stated = _stated(file, lines[:end])
    below = [place for place in range(end + 1, len(lines)) if not is_comment(lines[place])]
    if not below:
        raise InputError(f"{file}: line {end + 2}, column 1: must name the columns below {_END!r}; the file ends there")
    header = below[0]
    mark = "\t" if "\t" in lines[header] else None
    written = [cell.strip() for cell in lines[header].strip().split(mark)]
    said = stated.get("indegrees", _Entry(0, "", ""))
    degrees = said.text.lower()
    angle = {"yes": "deg", "true": "deg", "1": "deg", "no": "rad", "false": "rad", "0": "rad"}.get(degrees)
    if degrees and angle is None:
        _refuse(file, said.line, said.key, f"must be yes or no, got {shown(degrees)}")
    sheet = OpenSimSheet(
        file=file,
        kind=f"OpenSim storage{f' with angles in {angle}' if angle else ''}",
        encoding=text.encoding,
        lines=[line.strip() for line in lines],
        mark=mark,
        header=header + 1,
        headings=tuple(bracketed(one) if "/" in one else heading_of(one) for one in written),
        start=header + 1,
        units={"time": "s", **({"angle": angle, "angular_speed": f"{angle}/s"} if angle else {})},
    )
    counts = {"rows": len(below) - 1, "columns": len(written)}
    for name, entry in stated.items():
        what = _COUNTS.get(name)
        if what is not None and entry.text != str(counts[what]):
            _refuse(file, entry.line, entry.key, f"states {shown(entry.text)} {what}, but the file has {counts[what]}")
    return sheet


def _stated(file: str, lines: list[str]) -> dict[str, _Entry]:
    """Return what the header states, by key in lower case."""
    found: dict[str, _Entry] = {}
    for number, line in enumerate(lines, 1):
        entry = _LINE.fullmatch(line)
        if entry:
            found[entry[1].lower()] = _Entry(number, entry[1], entry[2])
    line, _, kind = found.get("datatype", _Entry(0, "", "double"))
    if kind.lower() not in ("double", "float"):
        _refuse(file, line, "DataType", f"must be double, one number per column, got {shown(kind)}")
    return found


def _refuse(file: str, line: int, key: str, said: str) -> NoReturn:
    raise InputError(f"{file}: line {line}, {key}: {said}")


def parquet_file(content: bytes) -> Any:
    """Open a Parquet file; read it with ``use_threads=False``.

    `read_table` of pyarrow leaves the closing of a Python file to one of its threads; if that thread runs while the interpreter
    ends, the process aborts (exit code 134). A buffer of pyarrow, read in this thread alone, has nothing to close late.
    """
    arrow, parquet = (importlib.import_module(name) for name in ("pyarrow", "pyarrow.parquet"))
    return parquet.ParquetFile(arrow.BufferReader(content))


class ParquetSheet:
    """Columns of a Parquet file, read when chosen."""

    place = "row"
    tabular = True
    top = "schema"

    def __init__(self, file: str, content: bytes) -> None:
        """Open the file.

        Raises
        ------
        InputError
            If pyarrow is missing, or the file is broken or too long.
        """
        extras.load("pyarrow", "parquet", f"{file}: a Parquet file")
        self.file = file
        try:
            self._data = parquet_file(content)
            names = list(self._data.schema_arrow.names)
            rows = int(self._data.metadata.num_rows)
        except (OSError, ValueError, NotImplementedError) as problem:
            raise InputError(
                f"{file}: is not a whole Parquet file: {printable(str(problem).splitlines()[0])}"
            ) from problem
        self.headings: Sequence[Heading] = tuple(map(heading_of, names))
        if rows > MOST_ROWS:
            raise InputError(
                f"{file}: row {MOST_ROWS + 1}: is beyond the {MOST_ROWS} rows allowed; choose some of its strides"
            )
        if rows < 2:
            raise InputError(
                f"{file}: row 1, column {shown(names[0] if names else '')}: must have at least two rows, got {rows}"
            )

    def usual_unit(self, role: str, heading: Heading) -> str | None:
        """Unit that the format itself states: none."""
        del role, heading
        return None

    def passed_over(self, lines: np.ndarray) -> tuple[str, ...]:
        """Return a remark about what was not read: none, as the format has no comments."""
        del lines
        return ()

    def numbers(self, places: Sequence[int], *, blank: bool = False) -> tuple[np.ndarray, np.ndarray, str]:
        """Return the columns at some places, the number of each row, and the format in words."""
        names = [self.headings[place].text for place in places]
        read = self._data.read(columns=names, use_threads=False)
        values = np.empty((read.num_rows, len(places)))
        for one, (place, name) in enumerate(zip(places, names, strict=True)):
            column = read.column(name)
            try:
                values[:, one] = column.cast("float64").to_numpy()
            except (ValueError, NotImplementedError):
                fault(self, 1, place, f"must hold numbers, got {column.type}")
            missing = np.isnan(values[:, one]) if blank else False
            wrong = np.flatnonzero(~(np.isfinite(values[:, one]) | missing))
            if wrong.size:
                got = values[wrong[0], one]
                fault(self, int(wrong[0]) + 1, place, f"must be a finite number, got {float(got)!r}")
        return values, np.arange(1, len(values) + 1), "Parquet"
