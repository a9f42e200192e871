"""Rows of a text file below its headings: split into cells and read as numbers, quickly, or cell by cell to find a fault."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NoReturn, Protocol

import numpy as np

from infinivar.errors import InputError
from infinivar.motion.files.headings import Heading

MOST_ROWS = 1_000_000
_SHOWN = 24
"""Characters of a cell shown in a message: enough to find it, without revealing much of a file given by mistake."""
_LONGEST_HEADING = 60
_MOST_LISTED = 5

_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)
MARKS = {",": "commas", ";": "semicolons", "\t": "tabs", None: "blanks"}
"""Marks between columns, in words; None is any run of blanks."""
_COMMENTS = ("#", "//", "%")


class Source(Protocol):
    """What every file format offers, from which columns are then chosen."""

    @property
    def file(self) -> str:
        """Name of the file, printable."""
        ...

    @property
    def headings(self) -> Sequence[Heading]:
        """Headings from left to right."""
        ...

    @property
    def top(self) -> str:
        """Place of the headings for messages: "line 1"."""
        ...

    @property
    def place(self) -> str:
        """What rows are counted in: "line" or "row"."""
        ...

    @property
    def tabular(self) -> bool:
        """Whether numbers stand below the headings; if not, the file was named by mistake, and is not quoted."""
        ...

    def usual_unit(self, role: str, heading: Heading) -> str | None:
        """Unit of a heading that states none, where the format itself does; None where it does not."""
        ...

    def numbers(self, places: Sequence[int], *, blank: bool = False) -> tuple[np.ndarray, np.ndarray, str]:
        """Return the columns at some places, (rows, places), the line of each row, and the format in words.

        All are finite; with `blank`, those of empty cells are nan.
        """
        ...

    def passed_over(self, lines: np.ndarray) -> tuple[str, ...]:
        """Return a remark about what stands between rows, given their lines, and was not read."""
        ...


def shown(text: str) -> str:
    """Return a heading or a cell for a message."""
    text = text.strip()
    return repr(text if len(text) <= _LONGEST_HEADING else text[:_LONGEST_HEADING] + "...")


def fault(source: Source, number: int, place: int, said: str) -> NoReturn:
    """Raise InputError about one cell."""
    known = place < len(source.headings) and source.headings[place].text
    column = shown(source.headings[place].text) if known else str(place + 1)
    raise InputError(f"{source.file}: {source.place} {number}, column {column}: {said}")


def is_comment(line: str) -> bool:
    """Whether a line is empty or a comment."""
    line = line.lstrip()
    return not line or line.startswith(_COMMENTS)


def cells_of(line: str, mark: str | None) -> list[str]:
    """Split a line into cells.

    Raises
    ------
    ValueError
        If a quote is not closed, or text follows a closing quote.
    """
    if mark is None:
        return line.split()
    if '"' not in line:
        return line.split(mark)
    try:
        return next(csv.reader([line], delimiter=mark, strict=True, skipinitialspace=True))
    except csv.Error as problem:
        raise ValueError(str(problem)) from problem


def is_number(cell: str) -> bool:
    """Whether a cell is a number, with a decimal point or comma."""
    return bool(_NUMBER.fullmatch(cell.strip().replace(",", ".", 1))) or cell.strip().lower() in ("nan", "inf", "-inf")


@dataclass(frozen=True, slots=True)
class TextSheet:
    """Rows of cells in a text file.

    Attributes
    ----------
    file : str               Name of the file, printable.
    kind : str               Kind of the file for its description: "CSV", "OpenSim storage".
    encoding : str           In words.
    lines : list of str      All lines of the file.
    mark : str               Between columns; None for runs of blanks.
    header : int             Line of the headings, from 1.
    headings : tuple         From left to right.
    start : int              Index of the first line that may hold numbers.
    units : dict             Units that the format states by itself, by role.
    """

    file: str
    kind: str
    encoding: str
    lines: list[str]
    mark: str | None
    header: int
    headings: tuple[Heading, ...]
    start: int
    units: dict[str, str]

    @property
    def top(self) -> str:
        """Place of the headings."""
        return f"line {self.header}"

    @property
    def place(self) -> str:
        """What rows are counted in."""
        return "line"

    @property
    def tabular(self) -> bool:
        """Whether at least half of the cells in the first row are numbers."""
        first = next((line for line in self.lines[self.start :] if not is_comment(line)), "")
        try:
            cells = cells_of(first, self.mark)
        except ValueError:
            return False
        return 2 * sum(map(is_number, cells)) >= max(len(cells), 1)

    def usual_unit(self, role: str, heading: Heading) -> str | None:
        """Unit that the format states for a role."""
        del heading
        return self.units.get(role)

    def numbers(self, places: Sequence[int], *, blank: bool = False) -> tuple[np.ndarray, np.ndarray, str]:
        """Return the columns at some places, the line of each row, and the format in words."""
        kept = [
            place
            for place, line in enumerate(self.lines[self.start :], self.start)
            if line[:1].isdigit() or not is_comment(line)
        ]
        if len(kept) > MOST_ROWS:
            raise InputError(
                f"{self.file}: line {kept[MOST_ROWS] + 1}: is beyond the {MOST_ROWS} rows allowed; "
                "shorten the recording or lower its sample rate"
            )
        if len(kept) < 2:
            raise InputError(
                f"{self.file}: {self.top}, column {shown(self.headings[places[0]].text)}: must have at least two rows of "
                f"numbers below, got {len(kept)}"
            )
        rows = [self.lines[place] for place in kept]
        comma = self.mark != "," and self._has_decimal_commas(rows, places)
        values = self._quickly(rows, places, comma)
        if values is None:
            values = self._one_by_one(rows, kept, places, comma, blank)
        said = f"{self.kind} with {MARKS[self.mark]}{' and decimal commas' if comma else ''}, {self.encoding}"
        return values, np.asarray(kept) + 1, said

    def passed_over(self, lines: np.ndarray) -> tuple[str, ...]:
        """Return a remark about comments between rows: a row of numbers may be one by mistake."""
        if lines[-1] - lines[0] < len(lines):
            return ()
        inside = set(range(int(lines[0]), int(lines[-1]))) - set(lines.tolist())
        found = sorted(number for number in inside if self.lines[number - 1].strip())
        if not found:
            return ()
        listed = ", ".join(map(str, found[:_MOST_LISTED])) + (", ..." if len(found) > _MOST_LISTED else "")
        plural = "" if len(found) == 1 else "s"
        return (f"{len(found)} comment{plural} between the rows not read: line{plural} {listed}",)

    def _has_decimal_commas(self, rows: Iterable[str], places: Sequence[int]) -> bool:
        """Whether the first cell with a decimal mark, in columns that are read, has a comma."""
        for row in rows:
            if "," not in row and "." not in row:
                continue
            try:
                cells = cells_of(row, self.mark)
            except ValueError:
                return False
            for cell in (cells[place] for place in places if place < len(cells)):
                if "," in cell or "." in cell:
                    return "," in cell
        return False

    def _quickly(self, rows: list[str], places: Sequence[int], comma: bool) -> np.ndarray | None:
        """Read all rows at once; None if any is not a row of finite numbers."""
        if self.mark is not None:
            between = len(self.headings) - 1
            more = self.mark * (rows[0].count(self.mark) - between)
            if more and all(row.endswith(more) for row in rows):
                rows = [row[: -len(more)] for row in rows]
            if any(row.count(self.mark) != between or '"' in row for row in rows):
                return None
        elif len({len(row.split()) for row in rows} | {len(self.headings)}) > 1:
            return None
        if comma:
            if any("." in row for row in rows):
                return None
            rows = [row.replace(",", ".") for row in rows]
        try:
            values = np.loadtxt(rows, delimiter=self.mark, comments=None, usecols=places, ndmin=2)
        except ValueError:
            return None
        return values if len(values) == len(rows) and np.all(np.isfinite(values)) else None

    def _one_by_one(
        self, rows: list[str], kept: list[int], places: Sequence[int], comma: bool, blank: bool
    ) -> np.ndarray:
        """Read row by row, as the quick way does, and raise InputError at the first cell that is no number."""
        values = np.empty((len(rows), len(places)))
        for row, (line, index) in enumerate(zip(rows, kept, strict=True)):
            number = index + 1
            try:
                cells = cells_of(line, self.mark)
            except ValueError:
                fault(
                    self, number, self._unclosed(line), "has a quote that is not closed, or text behind the closing one"
                )
            self._check_count(number, cells, places)
            for one, place in enumerate(places):
                cell = cells[place].strip()
                values[row, one] = math.nan if blank and not cell else self._number(number, place, cell, comma)
        return values

    def _unclosed(self, line: str) -> int:
        """Return the column in which the last quote of a line stands."""
        return line[: line.rfind('"')].count(self.mark or " ")

    def _check_count(self, number: int, cells: list[str], places: Sequence[int]) -> None:
        """Refuse a row with fewer cells than headings, or more unless they are empty."""
        required = len(self.headings)
        counted = (
            f"{self.top} has {required} heading{'' if required == 1 else 's'}, this line "
            f"{len(cells)} cell{'' if len(cells) == 1 else 's'}"
        )
        if len(cells) < required:
            fault(self, number, max(len(cells), min(places)), f"has no cell: {counted}")
        if any(cell.strip() for cell in cells[required:]):
            hint = "; decimal commas need semicolons, tabs or blanks between columns" if self.mark == "," else ""
            fault(self, number, required, f"has no heading: {counted}{hint}")

    def _number(self, number: int, place: int, cell: str, comma: bool) -> float:
        """Read one cell."""
        written = cell[:_SHOWN]
        if comma and "." in cell:
            fault(self, number, place, f"must have a decimal comma and no other mark, as cells above, got {written!r}")
        found = _NUMBER.fullmatch(cell.replace(",", ".", 1) if comma else cell)
        if found is None and "," in cell and not comma:
            fault(self, number, place, f"must be a number with a point before its decimals, got {written!r}")
        value = float(found[0]) if found else math.nan
        if not math.isfinite(value):
            fault(self, number, place, f"must be a finite number, got {written!r}")
        return value
