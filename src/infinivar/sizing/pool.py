"""Parts of several sets in one table of each kind, with the set that each row is from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import field
from pathlib import Path

import numpy as np

from infinivar._core.result import Frozen, result
from infinivar.errors import InputError
from infinivar.parts.tables.columns import ONE, number_columns
from infinivar.parts.tables.stores import find, origin_of, places
from infinivar.parts.tables.table import PartSet

_KINDS = ("motors", "gearheads")


@result
class ChosenPart(Frozen):
    """A part of a set.

    Attributes
    ----------
    set, key       Set and key in it; studies write ``part = "SET:KEY"``.
    name           For reports.
    manufacturer, order_number, source, date   As the set states them; "": not stated.
    kind           Kind of its values: stated, catalogue, derived, fitted or assumed.
    derived        Values that were derived when the set was imported.
    where          All of this in one text, as provenance has it.
    """

    set: str
    key: str
    name: str
    manufacturer: str = ""
    order_number: str = ""
    source: str = ""
    date: str = ""
    kind: str = "catalogue"
    derived: tuple[str, ...] = ()
    where: str = ""

    @property
    def part(self) -> str:
        """As a study names it."""
        return f"{self.set}:{self.key}"


@result
class SearchedSet(Frozen):
    """A set that was searched.

    Attributes
    ----------
    pairs          Number of pairs of motor and gearhead.
    pairs_stated   Whether the set states what fits together; if not, every motor was tried with every gearhead.
    refused        Rows of its file that were refused, each with its reason.
    """

    name: str
    motors: int
    gearheads: int
    pairs: int
    pairs_stated: bool
    refused: tuple[str, ...] = ()


@result
class PartPool(Frozen):
    """Motors and gearheads of several sets, and all their pairs; pairs across sets are not made."""

    motors: Mapping[str, np.ndarray]
    gearheads: Mapping[str, np.ndarray]
    pairs: np.ndarray
    sets: tuple[SearchedSet, ...]
    sources: tuple[PartSet, ...] = field(repr=False)

    def part(self, kind: str, row: int) -> ChosenPart:
        """Set and data sheet of a row of "motors" or "gearheads"."""
        for one in self.sources:
            table = one.tables[kind]
            if row < len(table):
                said = table.stated(row)
                named = {name: said.get(name, "") for name in ("manufacturer", "order_number", "source", "date")}
                return ChosenPart(
                    **named,
                    set=one.name,
                    key=said["key"],
                    name=said.get("name", said["key"]),
                    kind=said.get("kind", "catalogue"),
                    derived=tuple(str(said.get("derived", "")).split()),
                    where=origin_of(said, f"{one.name}:{said['key']}"),
                )
            row -= len(table)
        raise IndexError(f"{ONE[kind]} {row}")


def pool(sets: Sequence[str | Path] | None = None, beside: Sequence[Path] = ()) -> PartPool:
    """Gather the motors and gearheads of sets.

    Parameters
    ----------
    sets : names or files   All sets that can be had by default, of which those without motors or gearheads are left out.
    beside : paths          Folders in which sets are looked up first.

    Raises
    ------
    InputError
        If a set does not exist or cannot be read, or none has a pair of motor and gearhead.
    """
    asked = [place.name for place in places(beside)] if sets is None else list(dict.fromkeys(map(str, sets)))
    found = [find(name, beside) for name in asked]
    for name, one in zip(asked, found, strict=True):
        if sets is not None and not len(one.parts.pairs):
            raise InputError(f"the set {name} has no pair of motor and gearhead: {one.parts.contents}")
    found = [one for one in found if len(one.parts.pairs)]
    if not found:
        raise InputError("sets must name at least one set of parts")
    used = tuple(one.parts for one in found)
    tables = {kind: _joined(used, kind) for kind in _KINDS}
    starts = {kind: np.cumsum([0, *(len(one.tables[kind]) for one in used)]) for kind in _KINDS}
    first = np.stack([starts[kind] for kind in _KINDS], axis=-1)
    pairs = [one.pairs + first[place] for place, one in enumerate(used)]
    return PartPool(
        motors=tables["motors"],
        gearheads=tables["gearheads"],
        pairs=np.concatenate(pairs),
        sets=tuple(
            SearchedSet(
                name=one.parts.name,
                motors=len(one.parts.motors),
                gearheads=len(one.parts.gearheads),
                pairs=len(one.parts.pairs),
                pairs_stated=one.parts.pairs_stated,
                refused=tuple(map(str, one.faults)),
            )
            for one in found
        ),
        sources=used,
    )


def _joined(sets: Sequence[PartSet], kind: str) -> dict[str, np.ndarray]:
    """Columns of a kind of all sets, one below the other, with names for reports."""
    tables = [one.tables[kind] for one in sets]
    columns = {name: np.concatenate([table.columns[name] for table in tables]) for name in number_columns(kind)}
    names = [np.where(table["name"] == "", table["key"], table["name"]) for table in tables]
    return {**columns, "name": np.concatenate(names)}
