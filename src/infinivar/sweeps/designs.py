"""Designs that a sweep keeps, as columns and in words, and what it counts, in words."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from infinivar._core.text import counted
from infinivar.limits import Limit
from infinivar.sizing.design import COBOTIC_PATHS, UNITS, demand_words, limit_words, outcome_words, path_words, shown
from infinivar.sizing.found import FoundDesign, LimitCount
from infinivar.sizing.margins import TaskDemand
from infinivar.sizing.records import limit_lines
from infinivar.sweeps.problem import FRONT, LIST, NEAREST, TOP
from infinivar.units import plain, show

DEMAND = "demand: "
"""Begin of the name of a column of a demand."""


def column_of(key: TaskDemand) -> str:
    """Name of the column of a demand; the name of a task may hold anything."""
    task, limit, part = key
    return f"{DEMAND}{task}, {limit.name}, {part}"


def key_of(name: str) -> TaskDemand:
    """Task, limit and part of a column."""
    task, limit, part = name.removeprefix(DEMAND).rsplit(", ", 2)
    return task, next(one for one in Limit.every() if one.name == limit), part


def demands_of(row: Mapping[str, Any]) -> dict[TaskDemand, float]:
    """Demands of a row; nan stands for a limit that does not load the design."""
    found = {name: float(value) for name, value in row.items() if name.startswith(DEMAND)}
    return {key_of(name): value for name, value in found.items() if not math.isnan(value)}


def design_row(name: str, one: FoundDesign, value: float, own: Mapping[str, Any]) -> dict[str, Any]:
    """A design as a row of a list, with its value of the objective; `own` has the columns of its architecture.

    A limit that does not load it has no column.
    """
    return {
        LIST: name,
        "value": value,
        **own,
        "mass_kg": one.mass,
        "power_W": one.power,
        # In a row nan stands for a limit that does not load the design.
        **{column_of(key): np.inf if np.isnan(demand) else demand for key, demand in one.demands.items()},
    }


def rows_of(rows: Sequence[Mapping[str, Any]]) -> dict[str, np.ndarray]:
    """Rows as columns; what a row lacks is nan."""
    names = dict.fromkeys(name for row in rows for name in row)
    return {name: np.array([row.get(name, np.nan) for row in rows]) for name in names}


def each(rows: Mapping[str, np.ndarray]) -> Iterable[dict[str, Any]]:
    """Columns as rows, one by one."""
    for place in range(len(next(iter(rows.values()), ()))):
        yield {name: column[place] for name, column in rows.items()}


def limit_counts(counts: Mapping[str, Mapping[str, int]]) -> Iterable[LimitCount]:
    """Candidates that each limit excludes, from counts by column."""
    for name, one in counts.items():
        yield LimitCount(*key_of(name), one["checked"], one["exceeded"], one["first"])


_INTERNAL = (LIST, "value", "worst", "pair", "stage", "seed", "bearing", "steering")
"""Columns that place a design, and say nothing to people."""
_LEAD = {"steering motor": "steering ", "axle bearing": "bearings "}
"""What precedes the name of a part, by column."""
_TITLES = {TOP: "Best", FRONT: "Front, least power first", NEAREST: "Nearest miss"}
_COUNTS = {
    "left": "left by closed forms",
    "evaluated": "evaluated at every instant",
    "wheels": "wheel designs",
    "rolled": "wheel designs that roll",
    "sampled": "motors evaluated at every instant",
    "blocked": "infeasible wheel designs by their tightest limit",
    "excluded": "left out",
    "limits": "limits in the order in which they are checked",
    "unchecked": "not stated, not checked",
}
"""What is counted, by the name of the count."""


def list_title(name: str, number: int) -> str:
    """Title of a list of designs."""
    return f"{_TITLES.get(name, name.capitalize())}, {counted(number, 'designs')}:"


def row_of(rows: Mapping[str, np.ndarray], place: int) -> dict[str, Any]:
    """What is known of one row."""
    known = {name: column[place].item() for name, column in rows.items() if column[place] == column[place]}
    return {name: value for name, value in known.items() if value != ""}


def design_words(row: Mapping[str, Any]) -> str:
    """Parts, values, power, mass and margin of a row; its other demands are left to the files."""
    listed = {name: value for name, value in row.items() if name not in _INTERNAL and not name.startswith(DEMAND)}
    said = [f"{_LEAD.get(name, '')}{value}" for name, value in listed.items() if isinstance(value, str)]
    said += [_value_words(name, value) for name, value in listed.items() if not isinstance(value, str)]
    return "; ".join([*said, *outcome_words(demands_of(row))])


def _value_words(name: str, value: float) -> str:
    if name in COBOTIC_PATHS:
        path = COBOTIC_PATHS[name]
        return f"{path_words(path)} {shown(value, UNITS[path])}"
    if name == "ratio":
        return f"steering ratio {plain(value)}"
    words, _, unit = name.rpartition("_")
    if unit == "m":
        return f"{words.replace('_', ' ')} {shown(value, 'm')}"
    if unit in ("kg", "W"):
        return f"{words.replace('_', ' ')} {show(value, unit)}"
    return f"{name.replace('_', ' ')} {plain(value)}"


def count_lines(counts: Mapping[str, Any]) -> Iterator[str]:
    """Yield the counts, one line each; arrays are left out."""
    for name, value in counts.items():
        words = _words_of(name)
        if isinstance(value, Mapping):
            lines = list(_LINES.get(name, count_lines)(value))
            if lines:
                yield f"{words}:"
                yield from (f"  {line}" for line in lines)
        elif not isinstance(value, np.ndarray | list):
            yield f"{words}: {f'{value:,}' if isinstance(value, int) else plain(value)}"


def _limits(counts: Mapping[str, Mapping[str, int]]) -> Iterator[str]:
    """Lines on the limits of geared drives."""
    return limit_lines(limit_counts(counts))


def _unchecked(counts: Mapping[str, int]) -> Iterator[str]:
    """Lines on limits that data sheets do not state."""
    for name, number in counts.items():
        yield f"{demand_words(*key_of(f', {name}')[1:])}: {number:,}"


_LINES = {"limits": _limits, "unchecked": _unchecked}
"""What writes a group of counts, by its name."""


def _words_of(name: str) -> str:
    """Name of a count for people."""
    if name.startswith(DEMAND):
        return limit_words(key_of(name))
    return _COUNTS.get(name, name.replace("_", " "))
