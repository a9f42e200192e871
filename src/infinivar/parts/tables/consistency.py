"""Rows that contradict themselves: figures of a data sheet against those that follow from its other figures."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from infinivar import units
from infinivar._core.result import Frozen, result
from infinivar._core.text import counted
from infinivar.errors import InputError
from infinivar.parts.tables.columns import ONE, shown
from infinivar.parts.tables.relations import RELATIONS, Relation
from infinivar.parts.tables.table import PartSet, PartTable


@dataclass(frozen=True, slots=True, kw_only=True)
class Contradiction:
    """A row whose figures are farther apart than a relation tolerates."""

    kind: str
    key: str
    relation: str
    stated: float
    follows: float
    unit: str
    deviation: float
    tolerance: float
    words: str
    """What the second figure follows from, or is."""
    at_most: bool

    @property
    def text(self) -> str:
        """One line for a terminal."""
        one, other = (shown(value, self.unit, self.kind) for value in (self.stated, self.follows))
        apart, room = units.percent(abs(self.deviation), 1), units.percent(self.tolerance)
        verb = "exceeds" if self.at_most else "is stated, but"
        tail = f"{self.words}, {other}" if self.at_most else f"{self.words} gives {other}"
        measure = "points" if self.unit == "1" and not self.at_most else ""
        by = f"{apart.removesuffix(' %')} points" if measure else apart
        return f"{ONE[self.kind]} {self.key}: {self.relation} {one} {verb} {tail} ({by} off, tolerance {room})"


@result
class CatalogueCheck(Frozen):
    """Contradictions within the rows of a set.

    Attributes
    ----------
    name             Name of the set.
    rows             Number of rows by kind.
    tested           Number of rows that a relation could be tested on, by kind and relation.
    contradictions   Every row and relation out of tolerance, the worst first: by its excess over the tolerance.
    incomplete       Number of rows by kind that lack a value which their part requires.
    unusable         What the part says of complete rows that it refuses, a line each.
    """

    name: str
    rows: Mapping[str, int]
    tested: Mapping[str, int]
    contradictions: tuple[Contradiction, ...]
    incomplete: Mapping[str, int]
    unusable: tuple[str, ...]

    @property
    def consistent(self) -> bool:
        """Whether no row contradicts itself, and every complete row is a part."""
        return not self.contradictions and not self.unusable

    @property
    def verdict(self) -> str:
        """One line on the outcome."""
        rows = ", ".join(counted(count, kind) for kind, count in self.rows.items() if count) or "no parts"
        found = len({(one.kind, one.key) for one in self.contradictions})
        answer = f"{found} rows contradict themselves" if found > 1 else f"{found or 'no'} row contradicts itself"
        return f"{self.name}: {rows}; {counted(sum(self.tested.values()), 'comparisons')}; {answer}"


def _unusable(parts: PartSet) -> Iterator[str]:
    """Why complete rows are no parts."""
    for table in parts.tables.values():
        for row in np.flatnonzero(table.complete):
            try:
                table.part(int(row))
            except InputError as problem:
                yield str(problem)


def _contradictions(table: PartTable) -> Iterator[tuple[Relation, int, list[Contradiction]]]:
    """Each relation of a kind of table, the number of rows it was tested on, and the rows out of tolerance."""
    for relation in RELATIONS:
        if relation.kind != table.kind or not table:
            continue
        one, other, apart = relation.deviations(table)
        # Rounding of units must not decide about a bound that a row just keeps.
        rows = np.flatnonzero(np.abs(apart) > relation.tolerance + 1e-12)
        yield (
            relation,
            int(np.isfinite(apart).sum()),
            [
                Contradiction(
                    kind=relation.kind,
                    key=str(table.texts["key"][row]),
                    relation=relation.name,
                    stated=float(one[row]),
                    follows=float(other[row]),
                    unit=relation.unit,
                    deviation=float(apart[row]),
                    tolerance=relation.tolerance,
                    words=relation.follows,
                    at_most=relation.at_most,
                )
                for row in rows
            ],
        )


def _worst_first(found: Iterable[Contradiction]) -> tuple[Contradiction, ...]:
    return tuple(sorted(found, key=lambda one: one.tolerance - abs(one.deviation)))


def contradictions_of(parts: PartSet, kind: str, keys: Iterable[str]) -> tuple[Contradiction, ...]:
    """Contradictions of some parts of a set, the worst first; see `check_parts`.

    Parameters
    ----------
    parts : PartSet
    kind : str         "motors", "gearheads", "bearings", "rails", "belts", "springs", "tubes" or "materials".
    keys : iterable    Keys of parts.

    Raises
    ------
    InputError
        If the set has no such part.
    """
    table = parts.tables[kind]
    rows = sorted({table.row(key) for key in keys})
    some = replace(
        table,
        columns={name: column[rows] for name, column in table.columns.items()},
        texts={name: column[rows] for name, column in table.texts.items()},
    )
    return _worst_first(one for _, _, found in _contradictions(some) for one in found)


def check_parts(parts: PartSet) -> CatalogueCheck:
    """Find rows of a set whose figures contradict each other.

    Parameters
    ----------
    parts : PartSet

    Returns
    -------
    CatalogueCheck
        Each relation of `RELATIONS` is tested on the rows that state all it needs.
    """
    found: list[Contradiction] = []
    tested: dict[str, int] = {}
    for table in parts.tables.values():
        for relation, count, some in _contradictions(table):
            tested[f"{ONE[relation.kind]}: {relation.name}"] = count
            found += some
    return CatalogueCheck(
        name=parts.name,
        rows={kind: len(table) for kind, table in parts.tables.items()},
        tested=tested,
        contradictions=_worst_first(found),
        unusable=tuple(_unusable(parts)),
        incomplete={
            kind: int((~table.complete).sum()) for kind, table in parts.tables.items() if not table.complete.all()
        },
    )
