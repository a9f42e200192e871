"""Rows on their way into a set: each is checked; bad ones are kept as faults with file, line and reason."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from infinivar._core.fields import check_value
from infinivar.errors import InputError, ParameterError, nearest, printable
from infinivar.parts.catalogue import PARTS
from infinivar.parts.gearhead import LAWS
from infinivar.parts.tables.columns import ONE, UNLIMITED, Column, choices, number_columns, text_columns
from infinivar.parts.tables.table import PartSet, part_set, table

DATE = re.compile(r"\d{4}(-(0[1-9]|1[0-2])(-(0[1-9]|[12]\d|3[01]))?)?")
"""Year, year and month, or day."""

_LONGEST = 200
"""Longest text of a cell, in characters."""
_SHOWN_LINES = 5


@dataclass(frozen=True, slots=True, kw_only=True)
class Fault:
    """A row, or an entry of one, that was refused."""

    file: str
    line: int | None
    what: str
    """The part, by key where it has one."""
    reason: str

    def __str__(self) -> str:
        """One line for a terminal."""
        at = printable(self.file) if self.line is None else f"{printable(self.file)}:{self.line}"
        return ": ".join(filter(None, (at, printable(self.what), printable(self.reason))))


@dataclass(frozen=True, slots=True, kw_only=True)
class Remark:
    """Something that was read in another way than written, or left out, with the lines that it concerns."""

    file: str
    lines: tuple[int, ...]
    text: str

    def __str__(self) -> str:
        """One line for a terminal."""
        if not self.lines:
            return f"{printable(self.file)}: {printable(self.text)}"
        more = ", ..." if len(self.lines) > _SHOWN_LINES else ""
        lines = ", ".join(map(str, self.lines[:_SHOWN_LINES])) + more
        count = f"{len(self.lines)} line{'s' if len(self.lines) > 1 else ''}"
        return f"{printable(self.file)}: {printable(self.text)} ({count}: {lines})"


@dataclass(frozen=True, slots=True, kw_only=True)
class Fit:
    """A line that names the gearheads of a motor, by keys or patterns."""

    file: str
    line: int | None
    motor: str
    gearheads: tuple[str, ...]


@dataclass(slots=True, kw_only=True)
class Collector:
    """Rows read so far."""

    defaults: Mapping[str, str]
    """Texts of rows that do not state their own, such as source and date."""
    rows: dict[str, list[dict[str, Any]]] = field(default_factory=lambda: {kind: [] for kind in PARTS})
    faults: list[Fault] = field(default_factory=list)
    fits: list[Fit] | None = None
    _keys: dict[tuple[str, str], str] = field(default_factory=dict)
    _refused: set[tuple[str, str]] = field(default_factory=set)
    _remarks: dict[tuple[str, str], list[int]] = field(default_factory=dict)

    @property
    def remarks(self) -> tuple[Remark, ...]:
        """All remarks, each once."""
        return tuple(Remark(file=file, lines=tuple(lines), text=text) for (file, text), lines in self._remarks.items())

    def remark(self, file: str, line: int | None, text: str) -> None:
        """Note something about a line."""
        self._remarks.setdefault((file, text), []).extend([] if line is None else [line])

    def refuse(self, file: str, line: int | None, what: str, reason: str, kind: str | None = None) -> None:
        """Note a fault; with a kind, of the row of a part."""
        if kind is not None:
            self._refused.add((kind, what))
        self.faults.append(Fault(file=file, line=line, what=what, reason=reason))

    def take(
        self, kind: str, file: str, line: int | None, key: str, made: Callable[[], tuple[dict[str, Any], list[str]]]
    ) -> None:
        """Take a row, or refuse it.

        Parameters
        ----------
        kind : str       Of the part.
        file, line       Place of the row.
        key : str        Key of the part.
        made : callable  Returns the row, numbers in SI and texts, and remarks on it; InputError refuses it.
        """
        try:
            row, remarks = made()
            checked = checked_row(kind, {**self.defaults, **row})
            if (kind, key) in self._keys:
                raise InputError(f"the key is that of another {ONE[kind]}, in {self._keys[kind, key]}")
        except InputError as problem:
            self.refuse(file, line, key, str(problem), kind)
            return
        if not DATE.fullmatch(row.get("date", "") or "2000"):
            wrong = f"date {row['date']!r} is no date such as 2026, 2026-03 or 2026-03-31; it was kept as text"
            remarks = [wrong, *remarks]
        for text in remarks:
            self.remark(file, line, text)
        self._keys[kind, key] = file if line is None else f"line {line} of {file}"
        self.rows[kind].append(checked)

    def fit(self, file: str, line: int | None, motor: str, gearheads: Sequence[str]) -> None:
        """Take a line that names the gearheads of a motor."""
        if self.fits is None:
            self.fits = []
        self.fits.append(Fit(file=file, line=line, motor=motor, gearheads=tuple(gearheads)))

    def finished(self, name: str) -> PartSet:
        """The set of all rows taken; entries that name unknown parts become faults."""
        tables = [table(kind, rows) for kind, rows in self.rows.items() if rows]
        return part_set(name, tables, None if self.fits is None else self._pairs(self.fits))

    def _pairs(self, fits: Sequence[Fit]) -> np.ndarray:
        motors, gearheads = (_Keys([row["key"] for row in self.rows[kind]]) for kind in ("motors", "gearheads"))
        found: dict[tuple[int, int], None] = {}
        for one in fits:
            rows = self._matches("motors", motors, one.motor, one)
            fitting = [at for pattern in one.gearheads for at in self._matches("gearheads", gearheads, pattern, one)]
            found |= dict.fromkeys((motor, gearhead) for motor in rows for gearhead in fitting)
        return np.array(list(found), dtype=np.int64).reshape(-1, 2)

    def _matches(self, kind: str, keys: _Keys, pattern: str, fit: Fit) -> Sequence[int]:
        rows = keys.matching(pattern)
        if not rows:
            if (kind, pattern) in self._refused:
                why = f"the {ONE[kind]} was refused"
            else:
                hint = "" if "*" in pattern else nearest(pattern, keys.rows)
                why = f"no {ONE[kind]} has {'such a' if '*' in pattern else 'this'} key{hint}"
            self.refuse(fit.file, fit.line, pattern, why)
        return rows


class _Keys:
    """Rows by key, found by patterns in which * stands for any text."""

    def __init__(self, keys: Sequence[str]) -> None:
        self.rows = {key: (at,) for at, key in enumerate(keys)}
        self._known: dict[str, tuple[int, ...]] = {}

    def matching(self, pattern: str) -> tuple[int, ...]:
        if "*" not in pattern:
            return self.rows.get(pattern, ())
        if pattern not in self._known:
            required = re.compile(".*".join(map(re.escape, pattern.split("*"))), re.DOTALL)
            self._known[pattern] = tuple(at for at, key in enumerate(self.rows) if required.fullmatch(key))
        return self._known[pattern]


def checked_row(kind: str, row: Mapping[str, Any]) -> dict[str, Any]:
    """A row whose values keep the bounds of their columns; nan and "" are left out.

    Raises
    ------
    InputError
        If it has no key, or a value is not permitted.
    """
    numbers, texts, words = number_columns(kind), text_columns(kind), choices(kind)
    made: dict[str, Any] = {}
    for name, value in row.items():
        if name in numbers:
            number = checked_number(numbers[name], value)
            if not math.isnan(number):
                made[name] = number
        elif name in texts and value != "":
            if not isinstance(value, str) or not value.isprintable() or len(value) > _LONGEST:
                raise InputError(f"{name} must be text of at most {_LONGEST} characters on one line")
            if name in words and value not in words[name]:
                raise InputError(
                    f"{name} = {value!r} must be one of {', '.join(words[name])}{nearest(value, words[name])}"
                )
            made[name] = value
    if "key" not in made:
        raise InputError("key is missing")
    nested = {name.partition(".")[0] for name in made if "." in name}
    for word, law in LAWS.items() if nested else ():
        if nested & {*law.NEEDS}:
            made.setdefault("loss_model", word)
    return made


def checked_number(column: Column, value: float) -> float:
    """A value of a column, nan if it states none; an infinite limit is none.

    Raises
    ------
    InputError
        If it is not permitted.
    """
    if math.isnan(value) or (value == math.inf and column.name in UNLIMITED):
        return math.nan
    try:
        check_value(column.name, value, column.unit, column.bound)
    except ParameterError:
        pass
    else:
        return value
    try:
        # Units leave digits that nobody has written.
        check_value(column.name, float(f"{value:.12g}"), column.unit, column.bound)
    except ParameterError as problem:
        raise InputError(str(problem)) from None
    return value
