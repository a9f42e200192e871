"""Rows of a file below its headings: split into cells and read as numbers, quickly, or cell by cell to find a fault."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import NoReturn, Protocol

import numpy as np

from infinivar._core.text import few
from infinivar.errors import InputError
from infinivar.tables.headings import Heading, heading_of

MOST_ROWS = 1_000_000
_SHOWN = 24
"""Characters of a cell shown in a message: enough to find it, without revealing much of a file given by mistake."""
_LONGEST_HEADING = 60
_MOST_LISTED, _MOST_HEADINGS = 5, 6

_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)
MARKS = {",": "commas", ";": "semicolons", "\t": "tabs", None: "blanks"}
"""Marks between columns, in words; None is any run of blanks."""
_COMMENTS = ("#", "//", "%")
_DECIMAL = re.compile(r"\s*[+-]?(?:([\d.]*,\d+)(?:[eE][+-]?\d+)?\s*$|[\d,]*\.)", re.ASCII)
"""A number with decimals behind a comma (group 1), or the begin of one with a point; the other mark may be between thousands."""
QUOTE = "has a quote that is not closed, or text behind the closing one"
"""What is said of a cell whose quotes do not match."""


class Headed(Protocol):
    """Headings of a table, by which columns are chosen and faults are placed."""

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


class Source(Headed, Protocol):
    """What every format of numbers offers, from which columns are then chosen."""

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


def listed(texts: Sequence[str]) -> str:
    """Return a few headings for a message."""
    return few([*map(shown, texts)], _MOST_HEADINGS)


def headings_of(source: Headed) -> str:
    """Return the headings of a file for a message."""
    return listed([heading.text for heading in source.headings]) if source.tabular else "no row of numbers below"


def in_column(source: Headed, place: int, said: str) -> str:
    """Return what is said of a cell, with its column by heading, or by number where there is none."""
    known = place < len(source.headings) and source.headings[place].text
    return f"column {shown(source.headings[place].text) if known else place + 1}: {said}"


def fault(source: Headed, number: int, place: int, said: str) -> NoReturn:
    """Raise InputError about one cell."""
    raise InputError(f"{source.file}: {source.place} {number}, {in_column(source, place, said)}")


def refuse(source: Headed, places: Sequence[int], said: str) -> NoReturn:
    """Raise InputError about headings."""
    texts = [source.headings[place].text or str(place + 1) for place in places]
    raise InputError(f"{source.file}: {source.top}, column{'' if len(texts) == 1 else 's'} {listed(texts)}: {said}")


def miscounted(source: Headed, cells: Sequence[str], least: int = 0) -> tuple[int, str] | None:
    """Return the column at which a row has fewer cells than headings, or more that are not empty, and what is said of it.

    Cells before column `least` are not read.
    """
    required = len(source.headings)
    if len(cells) == required:
        return None
    counted = (
        f"{source.top} has {required} heading{'' if required == 1 else 's'}, this line "
        f"{len(cells)} cell{'' if len(cells) == 1 else 's'}"
    )
    if len(cells) < required:
        return max(len(cells), least), f"has no cell: {counted}"
    return (required, f"has no heading: {counted}") if any(cell.strip() for cell in cells[required:]) else None


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


def number_in(cell: str, comma: bool) -> float:
    """Number of a cell, with a decimal point, or a comma where the file has decimal commas.

    Raises
    ------
    InputError
        If it is no finite number; the message says what it must be.
    """
    written = cell[:_SHOWN]
    if comma and "." in cell:
        raise InputError(f"must have a decimal comma and no other mark, as cells above, got {written!r}")
    found = _NUMBER.fullmatch(cell.replace(",", ".", 1) if comma else cell)
    if found is None and "," in cell and not comma:
        raise InputError(f"must be a number with a point before its decimals, got {written!r}")
    value = float(found[0]) if found else math.nan
    if not math.isfinite(value):
        raise InputError(f"must be a finite number, got {written!r}")
    return value


def decimal_commas(cells: Iterable[str]) -> bool:
    """Whether the first number with a decimal mark has a comma."""
    found = (_DECIMAL.match(cell) for cell in cells if "," in cell or "." in cell)
    return next((one[1] is not None for one in found if one), False)


def mark_between(top: str, first: str) -> str | None:
    """Return the mark between the columns: one in both the headings and the first row, else one in the headings."""
    named = [mark for mark in ("\t", ";", ",") if mark in top]
    return next(iter([mark for mark in named if mark in first] or named), None)


@dataclass(frozen=True, slots=True)
class TextList:
    """Rows of words and numbers under headings in the first row, such as a list of parts.

    Cells are texts here, and each row is for the caller to take or to refuse, so that one that is wrong does not cost the
    others. It is no log, as `TextSheet` is: nothing stands above the headings, "#" may begin a row, a row without numbers is
    no row of units, and a cell in quotes may go on over lines.

    Attributes
    ----------
    file : str          Name of the file, printable.
    headings : tuple    From left to right.
    top : str           Place of the headings.
    rows : list         Line and cells of each row that is not empty, that of the headings first.
    """

    file: str
    headings: tuple[Heading, ...]
    top: str
    rows: list[tuple[int, list[str]]]
    place: str = "line"
    tabular: bool = True

    @classmethod
    def of(cls, file: str, lines: Sequence[str]) -> TextList:
        """Split the lines of a file.

        Raises
        ------
        InputError
            If the file is empty or a quote is not closed.
        """
        try:
            rows = list(_quoted_rows(file, lines))
        except csv.Error as problem:
            raise InputError(f"{file}: is not valid CSV: {problem}") from problem
        if not rows:
            raise InputError(f"{file}: line 1: must name the columns, but the file is empty")
        top, written = rows[0]
        while not written[-1]:
            written.pop()
        return cls(file, tuple(map(heading_of, written)), f"line {top}", rows)


def _quoted_rows(file: str, lines: Sequence[str]) -> Iterator[tuple[int, list[str]]]:
    """Yield line and cells of each row with any; a cell in quotes may go on over lines."""
    first, second, *_ = [*(line for line in lines if line.strip()), "", ""]
    mark, ended = mark_between(first, second) or ",", [f"{line}\n" for line in lines]
    reader = csv.reader(ended, delimiter=mark, skipinitialspace=True, strict=True)
    while True:
        begin = reader.line_num
        try:
            cells = next(reader)
        except StopIteration:
            return
        except csv.Error as problem:
            if "end of data" in str(problem):
                raise InputError(f"{file}: line {begin + 1}: {QUOTE}") from None
            # Text behind a closing quote belongs to its cell, so that one slip does not cost the file.
            cells = next(csv.reader(ended[begin : reader.line_num], delimiter=mark, skipinitialspace=True))
        cells = [cell.strip() for cell in cells]
        if any(cells):
            yield reader.line_num, cells


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
            refuse(self, [*places, 0][:1], f"must have at least two rows of numbers below, got {len(kept)}")
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
        """Whether the first number with a decimal mark, in columns that are read, has a comma."""
        split = (cells_of(row, self.mark) for row in rows if "," in row or "." in row)
        try:
            return decimal_commas(cells[place] for cells in split for place in places if place < len(cells))
        except ValueError:
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
                fault(self, number, line[: line.rfind('"')].count(self.mark or " "), QUOTE)
            wrong = miscounted(self, cells, min(places, default=0))
            if wrong is not None:
                hint = "; decimal commas need semicolons, tabs or blanks between columns" if self.mark == "," else ""
                fault(self, number, wrong[0], wrong[1] + (hint if len(cells) > len(self.headings) else ""))
            for one, place in enumerate(places):
                cell = cells[place].strip()
                try:
                    values[row, one] = math.nan if blank and not cell else number_in(cell, comma)
                except InputError as problem:
                    fault(self, number, place, str(problem))
        return values
