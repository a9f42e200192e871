"""Designs as columns: demands by task, limit and part, and rows of unequal columns."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from infinivar.limits import Limit
from infinivar.sizing.geared.result import LimitCount
from infinivar.sizing.geared.sampled import TaskDemand

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
