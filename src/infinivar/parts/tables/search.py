"""Search tables of parts by conditions on their columns, such as "mass < 0.3 kg", and on figures that follow from them.

The figures are the laws of the part, over all rows of its table.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from infinivar import units
from infinivar._core.result import Frozen, result
from infinivar._core.text import counted
from infinivar.errors import InputError, nearest
from infinivar.parts.motor import Motor
from infinivar.parts.tables.columns import Column, check_kind, number_columns, text_columns
from infinivar.parts.tables.table import PartSet, PartTable

_MOTORS = {
    "no_load_speed": ("rad/s", "Speed at the supply voltage without load"),
    "no_load_torque": ("N m", "Friction torque at the no-load speed"),
    "friction_torque": ("N m", "Friction torque independent of speed"),
    "continuous_current": ("A", "Current at the continuous torque"),
    "stall_current": ("A", "Current at the supply voltage at rest"),
    "stall_torque": ("N m", "Torque at the supply voltage at rest, less friction"),
    "peak_efficiency": ("1", "Peak efficiency at the supply voltage"),
}
_OF: Mapping[str, Mapping[str, tuple[str, str]]] = {"motors": _MOTORS}


class Rows:
    """The columns of a table under the names of the part's fields, so that the laws of the part apply to all rows at once."""

    def __init__(self, table: PartTable) -> None:
        """Take the table."""
        self._table = table

    def __getattr__(self, name: str) -> Any:
        """A column, or a figure that follows from the columns by a law of the motor.

        Viscous friction that is not stated is none.
        """
        columns: Mapping[str, np.ndarray] = self._table.columns
        if name == "viscous_friction" and name in columns:
            return np.nan_to_num(columns[name])
        if name in columns:
            return columns[name]
        if name in self._table.texts:
            return self._table.texts[name]
        law = getattr(Motor, name, None) if self._table.kind == "motors" else None
        if not isinstance(law, property) or law.fget is None:
            raise AttributeError(name)
        with np.errstate(all="ignore"):
            return law.fget(self)

    @property
    def stall_current(self) -> np.ndarray:
        """Current at the supply voltage at rest. [A]

        Source: data sheets, maxon2020.
        """
        return self.voltage / self.resistance

    @property
    def stall_torque(self) -> np.ndarray:
        """Torque at the supply voltage at rest, less friction. [N m]

        Source: data sheets, maxon2020.
        """
        return self.torque_constant * self.stall_current - self.friction_torque


def derived_columns(kind: str) -> dict[str, Column]:
    """Figures that can be derived for a kind of table; nan where a row lacks a value that they need."""
    voltage = number_columns("motors")["voltage"].bound
    return {
        name: Column(name=name, unit=unit, bound=voltage, meaning=f"{meaning}; derived")
        for name, (unit, meaning) in _OF.get(kind, {}).items()
    }


def derived(table: PartTable, name: str) -> np.ndarray:
    """One of `derived_columns` for all rows, in SI."""
    return np.asarray(getattr(Rows(table), name), dtype=float)


_CONDITION = re.compile(r"\s*([A-Za-z_][\w. ]*?)\s*(<=|>=|!=|==|=|<|>|~)\s*(.*?)\s*$", re.DOTALL)
_SAME = 1e-6
"""Relative difference up to which two numbers count as equal: values that were written in different units."""

_NUMBERS: Mapping[str, Callable[[np.ndarray, float], np.ndarray]] = {
    "<": lambda column, value: column < value,
    ">": lambda column, value: column > value,
    "<=": lambda column, value: column <= value * (1.0 + np.copysign(_SAME, value)),
    ">=": lambda column, value: column >= value * (1.0 - np.copysign(_SAME, value)),
    "=": lambda column, value: np.abs(column - value) <= _SAME * abs(value),
    "!=": lambda column, value: np.abs(column - value) > _SAME * abs(value),
}
EXAMPLE = '"mass < 0.3 kg" or "manufacturer = maxon"'


@dataclass(frozen=True, slots=True, kw_only=True)
class Condition:
    """One condition on a column."""

    column: str
    sign: str
    value: float | str
    written: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Hit:
    """A part that meets all conditions."""

    set: str
    key: str
    row: int
    values: Mapping[str, Any]
    """Values of the columns shown: numbers in SI, None where not stated, and texts."""

    @property
    def part(self) -> str:
        """What a study writes as `part`."""
        return self.key if self.set == "shipped" else f"{self.set}:{self.key}"


@result
class PartSearch(Frozen):
    """Outcome of a search.

    Attributes
    ----------
    kind         Kind of the parts.
    columns      Columns shown, in order.
    hits         Parts that meet all conditions, sorted, at most as many as requested.
    count        Number of all parts that meet them.
    searched     Number of all parts searched.
    unstated     Number of parts that were left out because they do not state a column of a condition, by column.
    """

    kind: str
    columns: tuple[str, ...]
    hits: tuple[Hit, ...]
    count: int
    searched: int
    unstated: Mapping[str, int]

    @property
    def verdict(self) -> str:
        """One line on the outcome."""
        shown = f", {len(self.hits)} shown" if len(self.hits) < self.count else ""
        left = "".join(
            f"; {count:,} {'does' if count == 1 else 'do'} not state {name}"
            for name, count in self.unstated.items()
            if count
        )
        return f"{self.count:,} of {counted(self.searched, self.kind)}{shown}{left}"


def columns_of(kind: str) -> dict[str, Column | None]:
    """Columns that a search of a kind of part knows; None for texts."""
    texts: dict[str, Column | None] = dict.fromkeys(text_columns(kind))
    return {**number_columns(kind), **derived_columns(kind), **texts}


def condition(kind: str, text: str) -> Condition:
    """Parse a condition.

    Raises
    ------
    InputError
        If the column, the sign or the value is not understood; the message says what would be right.
    """
    found = _CONDITION.match(text)
    if found is None:
        raise InputError(
            f"condition {text!r} must be COLUMN SIGN VALUE with one of < <= > >= = != ~, such as {EXAMPLE}"
        )
    name, sign, value = found[1].lower().replace(" ", "_"), found[2].replace("==", "="), found[3]
    column = _column(kind, name, f"condition {text!r}")
    if column is None:
        if sign not in ("=", "!=", "~"):
            raise InputError(f"condition {text!r}: {name} is text; use =, != or ~ (contains)")
        return Condition(column=name, sign=sign, value=value, written=text)
    if sign == "~":
        raise InputError(f"condition {text!r}: {name} is a number; ~ is for texts")
    try:
        return Condition(column=name, sign=sign, value=units.parse(value, column.unit), written=text)
    except InputError as problem:
        raise InputError(f"condition {text!r}: the value {value[:40]!r} {problem}") from None


def _column(kind: str, name: str, where: str) -> Column | None:
    known = columns_of(kind)
    if name not in known:
        raise InputError(f"{where}: {name!r} is no column of {kind}{nearest(name, known)}; columns: {', '.join(known)}")
    return known[name]


def values(table: PartTable, name: str) -> np.ndarray:
    """A column of a table, stated or derived."""
    return derived(table, name) if name in derived_columns(table.kind) else table[name]


def _meets(table: PartTable, one: Condition) -> tuple[np.ndarray, np.ndarray]:
    """Which rows meet a condition, and which state its column."""
    column = values(table, one.column)
    if not isinstance(one.value, str):
        return _NUMBERS[one.sign](column, one.value), ~np.isnan(column)
    required, stated = one.value.casefold(), column != ""
    texts = [str(text).casefold() for text in column]
    if one.sign == "~":
        return np.array([required in text for text in texts], dtype=bool), stated
    same = np.array([required == text for text in texts], dtype=bool)
    return (same if one.sign == "=" else ~same), stated


def search_parts(
    sets: PartSet | Iterable[PartSet],
    kind: str,
    conditions: str | Sequence[str] = (),
    *,
    sort: str | None = None,
    descending: bool = False,
    limit: int | None = None,
    show: Sequence[str] = (),
    fits: str | None = None,
) -> PartSearch:
    """Find the parts that meet conditions.

    Parameters
    ----------
    sets : PartSet or iterable of them   Sets to search.
    kind : str                "motors", "gearheads", "bearings", "rails", "belts", "springs", "tubes" or "materials".
    conditions : str or sequence of str   All must hold: a column, one of < <= > >= = != and a value with its unit, such as
        "mass < 0.3 kg". For texts = and != compare without regard to case, and ~ asks for a part of the text. Numbers are
        equal if they agree to 1e-6. A part that does not state a column meets no condition on it.
    sort : str                Column to sort by; parts that do not state it come last. By default the order of the sets.
    descending : bool         Whether the largest value comes first.
    limit : int               Most parts returned; all by default.
    show : sequence of str    Further columns to return, besides those of the conditions and of `sort`.
    fits : str                Only gearheads that fit this motor, or motors that fit this gearhead: SET:KEY, or the KEY of a
        shipped part. Only its set is searched, which must state what fits.

    Returns
    -------
    PartSearch

    Raises
    ------
    InputError
        If a condition or a column is not understood, or `fits` is not among the sets.
    """
    check_kind(kind)
    chosen = [sets] if isinstance(sets, PartSet) else list(sets)
    fitting = None if fits is None else _fitting(chosen, kind, fits)
    requested = [condition(kind, text) for text in ([conditions] if isinstance(conditions, str) else conditions)]
    for name in [*show, *([sort] if sort else [])]:
        _column(kind, name, "show" if name in show else "sort")
    if limit is not None and limit < 1:
        raise InputError(f"limit must be >= 1, got {limit}")
    required: list[str] = [*(one.column for one in requested), *([] if sort is None else [sort]), *show]
    columns = tuple(dict.fromkeys(required))
    hits: list[Hit] = []
    unstated = dict.fromkeys((one.column for one in requested), 0)
    searched = 0
    for parts in chosen if fitting is None else [fitting[0]]:
        table = parts.tables[kind]
        kept = np.ones(len(table), dtype=bool) if fitting is None else np.isin(table.texts["key"], fitting[1])
        searched += int(kept.sum())
        for one in requested:
            meets, stated = _meets(table, one)
            unstated[one.column] = unstated[one.column] + int((kept & ~stated).sum())
            kept &= meets & stated
        shown = {name: values(table, name) for name in columns}
        hits += [_hit(parts, table, int(row), shown) for row in np.flatnonzero(kept)]
    if sort:
        hits = _sorted(hits, sort, descending)
    return PartSearch(
        kind=kind,
        columns=columns,
        hits=tuple(hits if limit is None else hits[:limit]),
        count=len(hits),
        searched=searched,
        unstated=unstated,
    )


def _fitting(sets: Sequence[PartSet], kind: str, fits: str) -> tuple[PartSet, tuple[str, ...]]:
    """The set of a part, and the keys of the parts of a kind that fit it."""
    name, colon, key = fits.partition(":")
    name, key = (name, key) if colon else ("shipped", fits)
    parts = next((one for one in sets if one.name == name), None)
    if kind not in ("motors", "gearheads"):
        raise InputError(f"fits {fits!r} is for motors and gearheads, not for {kind}")
    if parts is None:
        raise InputError(
            f"fits {fits!r}: {name!r} is not among the sets searched, {', '.join(one.name for one in sets)}"
        )
    if not parts.pairs_stated:
        raise InputError(f"fits {fits!r}: the set {name} does not state what fits together")
    own = "motors" if kind == "gearheads" else "gearheads"
    if key not in parts.tables[own].part_keys and key in parts.tables[kind].part_keys:
        raise InputError(
            f"fits {fits!r}: this is among the {kind} of {name}; what fits it is found among the {own}, not the {kind}"
        )
    return parts, parts.gearheads_for(key) if kind == "gearheads" else parts.motors_for(key)


def _hit(parts: PartSet, table: PartTable, row: int, columns: Mapping[str, np.ndarray]) -> Hit:
    found = {name: column[row].item() for name, column in columns.items()}
    clear = {name: None if value != value or value == "" else value for name, value in found.items()}
    return Hit(set=parts.name, key=str(table.texts["key"][row]), row=row, values=clear)


def _sorted(hits: list[Hit], by: str, descending: bool) -> list[Hit]:
    stated = [hit for hit in hits if hit.values[by] is not None]
    stated.sort(key=lambda hit: hit.values[by], reverse=descending)
    return [*stated, *(hit for hit in hits if hit.values[by] is None)]
