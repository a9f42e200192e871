"""Text files with columns: commas, semicolons, tabs or blanks between them, decimal points or commas."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Sequence

from infinivar.errors import InputError
from infinivar.motion.files.headings import Heading, heading_of, spelt
from infinivar.motion.files.sheet import TextSheet, cells_of, fault, is_comment, is_number, shown
from infinivar.motion.files.text import Text

_HEADED = re.compile(r"[^\s\[(]\S*?(?:\s*(?:\[[^\]]*\]|\([^)]*\)))?(?=\s|$)")
"""A heading in a line of headings between blanks: a word, with its unit in brackets if it has one."""

_COMMENT = re.compile(r"\s*(?:#|//)\s*|\s*%\s*(?!\s*(?:gait|stride|cycle|of)\b)", re.IGNORECASE)
"""Sign of a comment at the start of a line; "% gait cycle" is a heading."""

_MOST_COLUMNS = 10_000


def delimited(file: str, text: Text) -> TextSheet:
    """Find the headings of a text file, what stands between its columns, and their units.

    Headings are the first line that is neither empty nor a comment, or the comment above the first numbers. A row of units
    may follow.

    Raises
    ------
    InputError
        If there are no headings; the message names file and line.
    """
    lines = text.lines
    filled = [place for place, line in enumerate(lines) if line.strip()]
    bare = next((place for place in filled if not is_comment(lines[place]) or _is_percent(lines[place])), None)
    if bare is None:
        raise InputError(f"{file}: line {filled[0] + 1}: must name the columns; the file has comments only")
    header = _header_above(lines, filled, bare)
    top = _COMMENT.sub("", lines[header], count=1)
    below = [place for place in filled if place > header and not is_comment(lines[place])]
    first = lines[below[0]] if below else ""
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
    after = next((place for place in filled if place > header), None)
    return sheet if after is None else with_units_row(sheet, after)


def _is_percent(line: str) -> bool:
    """Whether a line starts with "% gait cycle", a heading rather than a comment."""
    return line.lstrip().startswith("%") and _COMMENT.match(line) is None


def _header_above(lines: list[str], filled: Sequence[int], bare: int) -> int:
    """Return the line of the headings: the first that is no comment, or the comment above it if it holds numbers."""
    first = lines[bare]
    numeric = _is_numeric(first)
    if not numeric:
        return bare
    above = [place for place in filled if place < bare]
    return above[-1] if above else bare


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
        made.append(heading if not cell else Heading(heading.text, heading.name, cell))
    return dataclasses.replace(sheet, headings=tuple(made), start=row + 1)
