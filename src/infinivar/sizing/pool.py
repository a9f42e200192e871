"""Parts of several sets in one table of each kind, with the set that each row is from."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import field, fields, replace
from pathlib import Path

import numpy as np

from infinivar._core.described import at, reported
from infinivar._core.frozen import FrozenDict
from infinivar._core.result import Frozen, result
from infinivar.errors import InputError
from infinivar.parts.bearing import Bearing
from infinivar.parts.motor import multiple
from infinivar.parts.tables.columns import ONE, number_columns
from infinivar.parts.tables.consistency import contradictions_of
from infinivar.parts.tables.stores import find, origin_of, readable, shipped
from infinivar.parts.tables.table import PartSet
from infinivar.study.study import Study

_KINDS = ("motors", "gearheads")
_SAME = 1e-9
_OF_BEARING = (
    "name",
    "series",
    "bore",
    "outside_diameter",
    "width",
    "dynamic_rating",
    "static_rating",
    "calculation_factor",
    "contact_angle",
    "seal_torque",
    "mass",
)
"""What a bearing of a set brings with it; friction model and lubricant are those of the drive."""


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
    number         Of them on one shaft; 1 but for the motor of a template with a `scale`.
    """

    set: str
    key: str
    name: str = reported()
    manufacturer: str = reported(default="")
    order_number: str = reported(default="")
    source: str = reported(default="")
    date: str = reported(default="")
    kind: str = "catalogue"
    derived: tuple[str, ...] = ()
    where: str = ""
    number: float = 1.0

    _also = (at("part"),)

    @property
    def title(self) -> str:
        """Its name, with the number on one shaft."""
        return self.name if self.number == 1.0 else f"{self.number:g} x {self.name}"

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

    name: str = reported()
    motors: int
    gearheads: int
    pairs: int = reported()
    pairs_stated: bool = reported()
    refused: tuple[str, ...] = reported(default=())


@result
class PartPool(Frozen):
    """Motors and gearheads of several sets, and all their pairs; pairs across sets are not made."""

    motors: Mapping[str, np.ndarray]
    gearheads: Mapping[str, np.ndarray]
    pairs: np.ndarray
    sets: tuple[SearchedSet, ...]
    sources: tuple[PartSet, ...] = field(repr=False)
    numbers: Mapping[str, float] = field(default_factory=dict)
    """Motors on one shaft by role, where there is not one: "motor", "steering.motor"."""
    unread: tuple[str, ...] = ()
    """Sets that were left out, as they cannot be read, with the reason."""

    def like(self, study: Study, template: str) -> PartPool:
        """The pool for a search over drives like one of a study: with as many motors on a shaft as the template has.

        A `scale` that is no whole number stands for a motor of another size, in the place of which single ones are searched.
        """
        numbers = {
            row.field.removesuffix(".scale"): float(row.value)
            for row in study.provenance
            if row.owner == template and row.field.endswith("motor.scale") and float(row.value).is_integer()
        }
        return replace(self, numbers=FrozenDict(numbers)) if numbers else self

    def motors_as(self, role: str) -> Mapping[str, np.ndarray]:
        """Columns of the motors for "motor" or "steering.motor" of a drive, of as many on one shaft as the template has."""
        number = self.numbers.get(role, 1.0)
        if number == 1.0:
            return self.motors
        names = np.array([f"{number:g} x {name}" for name in self.motors["name"]])
        return {**multiple(self.motors, number), "name": names}

    def contradictions(self, chosen: Iterable[tuple[str, ChosenPart]]) -> tuple[str, ...]:
        """What the data sheets of parts, each with its role, state that contradicts itself, a line each, the worst first."""
        required: dict[tuple[str, str], list[str]] = {}
        for role, one in chosen:
            kind = next(kind for kind, word in ONE.items() if word in role)
            required.setdefault((one.set, kind), []).append(one.key)
        known = {one.name: one for one in self.sources}
        found = [
            (set_name, one)
            for (set_name, kind), keys in required.items()
            if set_name in known
            for one in contradictions_of(known[set_name], kind, keys)
        ]
        found.sort(key=lambda pair: pair[1].tolerance - abs(pair[1].deviation))
        return tuple(f"the data sheet contradicts itself: {set_name}, {one.text}" for set_name, one in found)

    def motor(self, role: str, row: int) -> ChosenPart:
        """Set and data sheet of a row of the motors, for "motor" or "steering.motor" of a drive."""
        return replace(self.part("motors", row), number=self.numbers.get(role, 1.0))

    def part(self, kind: str, row: int) -> ChosenPart:
        """Set and data sheet of a row of "motors" or "gearheads"."""
        for one in self.sources:
            table = one.tables[kind]
            if row < len(table):
                return _chosen(one, kind, row)
            row -= len(table)
        raise IndexError(f"{ONE[kind]} {row}")

    def bearings_like(self, own: Bearing) -> list[tuple[ChosenPart | None, Bearing]]:
        """Bearings for a shaft: its own, and those of its type in the sets, or shipped ones if the sets have none.

        Friction model and lubricant are those of its own bearing.
        """
        sources = [one for one in self.sources if len(one.bearings)] or [shipped()]
        found: list[tuple[ChosenPart | None, Bearing]] = [(None, own)]
        for one in sources:
            for row in np.flatnonzero(one.bearings.complete):
                part = one.bearings.part(int(row))
                if part.type != own.type:
                    continue
                made = replace(own, **{name: getattr(part, name) for name in _OF_BEARING})
                if not any(_alike(made, known) for _, known in found):
                    found.append((_chosen(one, "bearings", int(row)), made))
                elif found[0][0] is None and _alike(made, own):
                    found[0] = (_chosen(one, "bearings", int(row)), own)
        return found


def _chosen(source: PartSet, kind: str, row: int) -> ChosenPart:
    """A part of a set by its row."""
    said = source.tables[kind].stated(row)
    named = {name: said.get(name, "") for name in ("manufacturer", "order_number", "source", "date")}
    return ChosenPart(
        **named,
        set=source.name,
        key=said["key"],
        name=said.get("name", said["key"]),
        kind=said.get("kind", "catalogue"),
        derived=tuple(str(said.get("derived", "")).split()),
        where=origin_of(said, f"{source.name}:{said['key']}"),
    )


_TOLD_BY = tuple(one.name for one in fields(Bearing) if one.name not in ("name", "width", "mass"))


def _alike(one: Bearing, other: Bearing) -> bool:
    """Whether two bearings differ in name, width and mass at most."""
    return all(getattr(one, name) == getattr(other, name) for name in _TOLD_BY)


def pool_of(study: Study, sets: str | Path | Sequence[str | Path] | None) -> PartPool:
    """Gather the sets that a search for a study is over: one, several, or by default all, those beside the study first."""
    beside = [] if study.path is None else [study.path.parent / "parts"]
    return pool([sets] if isinstance(sets, str | Path) else sets, [*beside, Path("parts")])


def pool(sets: Sequence[str | Path] | None = None, beside: Sequence[Path] = ()) -> PartPool:
    """Gather the motors and gearheads of sets.

    Parameters
    ----------
    sets : names or files   All sets that can be had by default, of which those without motors or gearheads are left out.
    beside : paths          Folders in which sets are looked up first.

    Raises
    ------
    InputError
        If a set that is named does not exist or cannot be read, or none has a pair of motor and gearhead.
    """
    unread: list[str] = []
    if sets is None:
        found, unread = readable(beside)
    else:
        requested = list(dict.fromkeys(map(str, sets)))
        found = [find(name, beside) for name in requested]
        for name, one in zip(requested, found, strict=True):
            if not len(one.parts.pairs):
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
        unread=tuple(unread),
    )


def _joined(sets: Sequence[PartSet], kind: str) -> dict[str, np.ndarray]:
    """Columns of a kind of all sets, one below the other, with names for reports."""
    tables = [one.tables[kind] for one in sets]
    columns = {name: np.concatenate([table.columns[name] for table in tables]) for name in number_columns(kind)}
    names = [np.where(table["name"] == "", table["key"], table["name"]) for table in tables]
    return {**columns, "name": np.concatenate(names)}
