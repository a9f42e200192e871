"""What a sweep computes: a fixed number of chunks, each a pure function of its number, and how they are merged.

The result depends on the chunks alone, not on the order in which they were computed.
"""

from __future__ import annotations

import functools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, ClassVar, NamedTuple, Protocol

import numpy as np

from infinivar._core.pareto import front
from infinivar.errors import InputError
from infinivar.sizing.margins import nearest_of

Columns = Mapping[str, np.ndarray]

LIST = "list"
"""Column that tells which list a row belongs to."""
TOP, FRONT, NEAREST = "top", "front", "nearest"


class Reducer(Protocol):
    """Rule that merges the rows of chunks, given in the order of their numbers."""

    def __call__(self, rows: Columns) -> Columns:
        """Rows to keep of those of all chunks, one below the other."""
        ...

    def to_dict(self) -> dict[str, Any]:
        """Name and options."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Best:
    """Keep the best designs, and those of which no other has less of two values; or the nearest miss where there is none.

    Attributes
    ----------
    top        Number of best designs to keep.
    order      Columns by which designs are ordered, the first being the most important.
    front      Two columns, mass first, of which none of the front is exceeded in both by another design.
    same       Columns that identify a design; of several with the same values the first in order is kept. All by default.
    demands    Begin of the names of columns of demands, by which the nearest miss is chosen; none is kept by default.
    """

    top: int
    order: tuple[str, ...]
    front: tuple[str, str]
    same: tuple[str, ...] = ()
    demands: str = ""

    def __call__(self, rows: Columns) -> Columns:
        """See `Reducer`."""
        if not rows:
            return rows
        listed = np.flatnonzero(rows[LIST] == TOP)
        keys = [rows[name][listed] for name in reversed(self.order)]
        best = listed[np.lexsort(keys)] if listed.size else listed
        best = _first_of_each(rows, self.same, best)[: self.top]
        fronted = np.flatnonzero(rows[LIST] == FRONT)
        missed = self._nearest(rows, np.flatnonzero(rows[LIST] == NEAREST)) if not best.size else best[:0]
        return taken(rows, np.concatenate([best, self._front(rows, fronted), missed]))

    def _nearest(self, rows: Columns, places: np.ndarray) -> np.ndarray:
        """Place of the nearest miss; empty if there is none. A limit that does not load a design is nan there."""
        columns = [column[places] for name, column in rows.items() if self.demands and name.startswith(self.demands)]
        if not columns or not places.size:
            return places[:0]
        first = nearest_of(np.where(np.isnan(columns), 0.0, columns), rows[self.front[0]][places])
        return places[first : first + 1]

    def _front(self, rows: Columns, places: np.ndarray) -> np.ndarray:
        """Places of the front, by the second of its columns, then in the order of the chunks."""
        found = places[front(*(rows[name][places] for name in self.front))]
        return _first_of_each(rows, (*self.same, *self.front) if self.same else (), found)

    def to_dict(self) -> dict[str, Any]:
        """See `Reducer`."""
        return {"name": "best", **{name: value for name, value in asdict(self).items() if value != ""}}


@dataclass(frozen=True, slots=True, kw_only=True)
class Rows:
    """Keep all rows, in the order of the chunks."""

    def __call__(self, rows: Columns) -> Columns:
        """See `Reducer`."""
        return rows

    def to_dict(self) -> dict[str, Any]:
        """See `Reducer`."""
        return {"name": "rows"}


def reducer_of(said: Mapping[str, Any]) -> Reducer:
    """The reducer that `to_dict` described."""
    name, options = said.get("name"), {key: value for key, value in said.items() if key != "name"}
    if name == "rows":
        return Rows()
    if name == "best":
        lists = {key: tuple(options[key]) for key in ("order", "front", "same")}
        return Best(**{**options, **lists})
    raise InputError(f"unknown way to merge chunks: {name!r}")


def taken(rows: Columns, places: np.ndarray) -> dict[str, np.ndarray]:
    """Some rows of all columns."""
    return {name: column[places] for name, column in rows.items()}


def stacked(tables: Sequence[Columns]) -> dict[str, np.ndarray]:
    """Tables one below the other; numbers that one lacks are nan there."""
    tables = [table for table in tables if table]
    names = merged_order([list(table) for table in tables])
    return {name: np.concatenate([_column(table, name) for table in tables]) for name in names}


def merged_order(lists: Iterable[Sequence[str]]) -> list[str]:
    """Names of all lists, each after the name that it follows in the first list that has it."""
    known: list[str] = []
    for names in lists:
        place = 0
        for name in names:
            if name in known:
                place = known.index(name) + 1
            else:
                known.insert(place, name)
                place += 1
    return known


def added(counts: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Sum of counts, entry by entry."""
    names = merged_order([list(one) for one in counts])
    found = {}
    for name in names:
        entries = [one[name] for one in counts if name in one]
        nested = isinstance(entries[0], Mapping)
        found[name] = added(entries) if nested else functools.reduce(_sum, entries)
    return found


def _sum(one: Any, other: Any) -> Any:
    return [a + b for a, b in zip(one, other, strict=True)] if isinstance(one, list) else one + other


def _column(table: Columns, name: str) -> np.ndarray:
    return table[name] if name in table else np.full(len(next(iter(table.values()))), np.nan)


def _first_of_each(rows: Columns, names: Sequence[str], places: np.ndarray) -> np.ndarray:
    """The first place of each combination of values, in the given order."""
    if not names or not places.size:
        return places
    keys = np.stack([np.unique(rows[name][places], return_inverse=True)[1].ravel() for name in names], axis=-1)
    _, first = np.unique(keys, axis=0, return_index=True)
    return places[np.sort(first)]


CANDIDATES = "candidates"
"""Entry of the counts that every chunk has: how many designs or samples it covers."""


class Chunk(NamedTuple):
    """What is kept of a chunk."""

    rows: Mapping[str, np.ndarray]
    """Columns of one length: numbers, truth values or texts. (n,) each"""
    counts: Mapping[str, Any]
    """Numbers and arrays that are added over chunks, by name; groups of them may be nested."""


class Problem(Protocol):
    """What `sweep` runs. The chunks together are the whole result, and the same number always gives the same chunk.

    Instances are sent to other processes, so they must be picklable.
    """

    kind: ClassVar[str]
    """Name of the kind of problem, such as "size"."""

    @property
    def title(self) -> str:
        """For reports."""
        ...

    @property
    def chunks(self) -> int:
        """Number of chunks, at least 1."""
        ...

    @property
    def reducer(self) -> Reducer:
        """How chunks are merged: by default all rows are kept."""
        return Rows()

    @property
    def identity(self) -> Mapping[str, Any]:
        """All that decides the result, by a name in words: numbers, texts, lists of them, or a `fingerprint`."""
        ...

    def run(self, number: int) -> Chunk:
        """Compute a chunk, 0 to `chunks` - 1."""
        ...

    def best(self, chunk: Chunk) -> tuple[float, str] | None:
        """A value of which less is better, with words for a progress bar; by default None: nothing is sought."""
        return None
