"""Text files with columns: commas, semicolons, tabs or blanks between them, decimal points or commas."""

from __future__ import annotations

import dataclasses
import re

from infinivar._core.encodings import Text
from infinivar.errors import InputError
from infinivar.motion.files.headings import Heading, family_of, heading_of, spelt
from infinivar.motion.files.sheet import TextSheet, cells_of, fault, is_comment, is_number, shown

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
"""Units by which a row of units is told from a row of headings."""


def delimited(file: str, text: Text) -> TextSheet:
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
    header = _header(lines, bare)
    top = _COMMENT.sub("", lines[header], count=1)
    first = next((lines[place] for place in range(header + 1, len(lines)) if not is_comment(lines[place])), "")
    mark = _mark(top, first)
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


def _header(lines: list[str], bare: int) -> int:
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
    count = len(_parts(line, _mark(line, line)))
    fitting = [place for place in above if len(_parts(lines[place], _mark(lines[place], line))) == count]
    return max(fitting or above, key=lambda place: (*_merits(lines[place], line), place))


def _merits(line: str, row: str) -> tuple[int, bool]:
    """Return how many cells of a line name a quantity, and whether it is no row of units."""
    cells = [heading_of(cell) for cell in _parts(line, _mark(line, row)) if cell.strip()]
    units = sum(spelt(cell.text.strip("[]()"))[0] in _USUAL_UNITS for cell in cells)
    return sum(family_of(cell.name, cell.unit) is not None for cell in cells), 2 * units < len(cells)


def _parts(line: str, mark: str | None) -> list[str]:
    """Split a line into cells, whether or not its quotes are closed."""
    try:
        return cells_of(line, mark)
    except ValueError:
        return line.split(mark)


def _is_row(line: str) -> bool:
    """Whether most cells of a line are numbers."""
    cells = _parts(line, _mark(line, line))
    return 2 * sum(map(is_number, cells)) > len(cells)


def _is_numeric(line: str) -> bool:
    """Whether a line holds numbers only, whatever stands between them."""
    return all(is_number(cell) for cell in re.split(r"[\s,;]+", line.strip(" \t,;")))


def _mark(top: str, first: str) -> str | None:
    """Return the mark between the columns: one in both the headings and the first row, else one in the headings."""
    named = [mark for mark in ("\t", ";", ",") if mark in top]
    return next(iter([mark for mark in named if mark in first] or named), None)


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
        raise InputError(
            f"{file}: line {header + 1}, column {place}: has a quote that is not closed, or text behind the closing one"
        ) from None
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
        if heading.unit is not None and cell and spelt(heading.unit) != spelt(cell):
            fault(
                sheet, row + 1, place,
                f"must be a number, or repeat the unit {heading.unit!r}, got {shown(cell)}",
            )  # fmt: skip
        made.append(heading if not cell else Heading(heading.text, heading.name, cell, row + 1))
    return dataclasses.replace(sheet, headings=tuple(made), start=row + 1)
