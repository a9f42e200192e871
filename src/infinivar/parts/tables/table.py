"""Tables of parts: one array a column, in SI, and the set of such tables that a file or a package provides."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from infinivar._core.frozen import FrozenDict
from infinivar._core.result import Frozen, result
from infinivar._core.text import counted
from infinivar.errors import InputError, ParameterError, nearest
from infinivar.parts.catalogue import PARTS
from infinivar.parts.gearhead import LAWS, PARTS_OF_LAWS, foreign_fields
from infinivar.parts.tables.columns import ONE, check_kind, choices, number_columns, text_columns

NO_PAIRS = np.empty((0, 2), dtype=np.int64)


@result
class PartTable(Frozen):
    """Parts of one kind, a row each.

    Attributes
    ----------
    kind      "motors", "gearheads", "bearings", "rails", "belts", "springs", "tubes" or "materials".
    columns   Numbers in SI by name, `(rows,)` each: the fields of the part, and further figures of its data sheet. nan: not
              stated. `number_columns(kind)` describes them.
    texts     Texts by name, `(rows,)` each: key, name, manufacturer, order number, source, date, kind and so on. "": not stated.
    """

    kind: str
    columns: Mapping[str, np.ndarray]
    texts: Mapping[str, np.ndarray]

    def __len__(self) -> int:
        """Number of rows."""
        return len(self.texts["key"])

    def __bool__(self) -> bool:
        """Whether there are rows."""
        return len(self) > 0

    def __getitem__(self, column: str) -> np.ndarray:
        """A column of numbers in SI, or of texts."""
        found = self.columns.get(column)
        found = self.texts.get(column) if found is None else found
        if found is None:
            known = [*self.columns, *self.texts]
            raise InputError(
                f"{column!r} is no column of {self.kind}{nearest(column, known)}; columns: {', '.join(known)}"
            )
        return found

    @property
    def part_keys(self) -> tuple[str, ...]:
        """Keys of the parts, in the order of the rows."""
        return tuple(self.texts["key"].tolist())

    def row(self, key: str | int) -> int:
        """Row of a part.

        Parameters
        ----------
        key : str or int   Key, or the row itself.

        Raises
        ------
        InputError
            If there is no such part; the message suggests the closest key.
        """
        if isinstance(key, str):
            found = np.flatnonzero(self.texts["key"] == key)
            if found.size:
                return int(found[0])
            raise InputError(f"{key!r} is not among the {len(self)} {self.kind}{nearest(key, self.part_keys)}")
        if not 0 <= key < len(self):
            raise InputError(f"row {key} must be >= 0 and < {len(self)}, the number of {self.kind}")
        return int(key)

    def stated(self, key: str | int) -> dict[str, Any]:
        """What a row states, by column: numbers in SI, and texts."""
        at = self.row(key)
        numbers = {name: float(column[at]) for name, column in self.columns.items()}
        texts = {name: str(column[at]) for name, column in self.texts.items()}
        return {**{name: text for name, text in texts.items() if text}, **_known(numbers)}

    def part(self, key: str | int) -> Any:
        """The part of a row, ready to use.

        Raises
        ------
        InputError
            If there is no such row, or it does not describe a part: a required value is missing or values conflict.
        """
        said = self.stated(key)
        part = PARTS[self.kind]
        fields = {field.name for field in dataclasses.fields(part)} - set(text_columns(self.kind))
        values = {name: value for name, value in said.items() if name in {*fields, *choices(self.kind)}}
        # A data sheet may state what another law needs.
        values = _without(values, foreign_fields(values.get("loss_model", "coulomb")))
        try:
            values |= {name: PARTS_OF_LAWS[name](**one) for name, one in _nested(said).items()}
            missing = self.missing(key)
            if missing:
                raise InputError(f"{missing[0]} is not stated")
            return part(name=said.get("name", said["key"]), **values)
        except InputError as problem:
            raise InputError(f"{ONE[self.kind]} {said['key']}: {problem}") from None

    def missing(self, key: str | int) -> tuple[str, ...]:
        """Required values that a row does not state: without them it is no part."""
        at = self.row(key)
        return tuple(name for name, lack in self._lacks.items() if lack[at])

    @property
    def complete(self) -> np.ndarray:
        """Whether each row states all that its part requires; `(rows,)` bool."""
        lacks = self._lacks.values()
        return ~np.logical_or.reduce([np.zeros(len(self), dtype=bool), *lacks])

    @property
    def _lacks(self) -> dict[str, np.ndarray]:
        required = [name for name, column in number_columns(self.kind).items() if column.required]
        found = {name: np.isnan(self.columns[name]) for name in required}
        if self.kind == "gearheads":
            words = np.where(self.texts["loss_model"] == "", "coulomb", self.texts["loss_model"])
            needs = [word for word, law in LAWS.items() if "efficiency" in law.NEEDS]
            found["efficiency"] = np.isnan(self.columns["efficiency"]) & np.isin(words, needs)
        return found

    def _rows(self) -> Iterator[tuple[str, str]]:
        yield "kind", self.kind
        yield "rows", str(len(self))
        for name, column in self.columns.items():
            known = column[np.isfinite(column)]
            if known.size:
                unit = number_columns(self.kind)[name].unit
                yield name, f"{known.min():.4g} to {known.max():.4g}{'' if unit == '1' else f' {unit}'}"


def _without(values: Mapping[str, Any], names: Sequence[str]) -> dict[str, Any]:
    return {name: value for name, value in values.items() if name not in names}


def _nested(said: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """What a row states of components of the part, by their fields: columns such as ``friction.viscous``."""
    found: dict[str, dict[str, Any]] = {}
    for column, value in said.items():
        outer, _, inner = column.partition(".")
        if inner:
            found.setdefault(outer, {})[inner] = value
    return found


def _known(numbers: Mapping[str, float]) -> dict[str, float]:
    return {name: value for name, value in numbers.items() if value == value}


def table(kind: str, rows: Sequence[Mapping[str, Any]]) -> PartTable:
    """Make a table from rows of numbers in SI and texts, by column; what a row does not have is not stated.

    Raises
    ------
    InputError
        If a row has no key, an unknown column or a value of the wrong sort, or two rows have one key.
    """
    check_kind(kind)
    numbers, texts = number_columns(kind), text_columns(kind)
    seen: set[str] = set()
    for place, row in enumerate(rows):
        key = row.get("key")
        if not isinstance(key, str) or not key:
            raise InputError(f"{kind}[{place}].key must be text that names the part, got {key!r}")
        if key in seen:
            raise InputError(f"{kind}[{place}].key = {key!r} must differ from those of the other rows")
        seen.add(key)
        unknown = next((name for name in row if name not in numbers and name not in texts), None)
        if unknown is not None:
            raise InputError(f"{unknown!r} is no column of {kind}{nearest(unknown, [*numbers, *texts])}")
    return PartTable(
        kind=kind,
        columns={name: _numbers(row.get(name, np.nan) for row in rows) for name in numbers},
        texts={name: _texts([str(row.get(name, "")) for row in rows]) for name in texts},
    )


def _numbers(values: Iterable[Any]) -> np.ndarray:
    column = np.array([float(value) for value in values])
    # A column that no row states is one nan, spread.
    return np.broadcast_to(np.nan, column.shape) if np.isnan(column).all() else column


def _texts(values: list[str]) -> np.ndarray:
    if len(set(values)) == 1:
        return np.broadcast_to(np.array(values[0]), (len(values),))
    return np.array(values, dtype=f"U{max(map(len, values), default=1) or 1}")


@functools.cache
def empty(kind: str) -> PartTable:
    """A table without rows."""
    return table(kind, ())


@result
class PartSet(Frozen):
    """Parts of one source: a table of each kind, and which gearheads fit which motors.

    Attributes
    ----------
    name            Name of the set, by which studies ask for its parts: ``part = "NAME:KEY"``.
    tables          Tables by kind. `motors`, `gearheads`, `bearings`, `rails`, `belts`, `springs`, `tubes` and
                    `materials` are short for them.
    pairs           Compatible motors and gearheads, `(n, 2)` rows of both tables; if the set states none, see `pairs_stated`.
    pairs_stated    Whether the source says what fits together. If not, `pairs` has every motor with every gearhead, and whether
                    they can be joined is for the user to check.
    path            File that the set was read from; None if it is not from a file.
    """

    name: str
    tables: Mapping[str, PartTable]
    pairs: np.ndarray
    pairs_stated: bool = True
    path: Path | None = dataclasses.field(default=None, compare=False)

    @property
    def motors(self) -> PartTable:
        """Table of motors."""
        return self.tables["motors"]

    @property
    def gearheads(self) -> PartTable:
        """Table of gearheads."""
        return self.tables["gearheads"]

    @property
    def bearings(self) -> PartTable:
        """Table of bearings."""
        return self.tables["bearings"]

    @property
    def rails(self) -> PartTable:
        """Table of rails with carriages."""
        return self.tables["rails"]

    @property
    def belts(self) -> PartTable:
        """Table of timing belts."""
        return self.tables["belts"]

    @property
    def springs(self) -> PartTable:
        """Table of springs from stock."""
        return self.tables["springs"]

    @property
    def tubes(self) -> PartTable:
        """Table of tubes from stock."""
        return self.tables["tubes"]

    @property
    def materials(self) -> PartTable:
        """Table of materials."""
        return self.tables["materials"]

    @property
    def contents(self) -> str:
        """How many parts of each kind, in words."""
        counts = [counted(len(table), kind) for kind, table in self.tables.items() if table]
        if self.pairs_stated and len(self.pairs):
            counts.append(counted(len(self.pairs), "compatible pairs"))
        return ", ".join(counts) or "no parts"

    def gearheads_for(self, motor: str | int) -> tuple[str, ...]:
        """Keys of the gearheads that fit a motor, given by its key or row."""
        rows = self.pairs[self.pairs[:, 0] == self.motors.row(motor), 1]
        return tuple(self.gearheads.texts["key"][rows].tolist())

    def motors_for(self, gearhead: str | int) -> tuple[str, ...]:
        """Keys of the motors that fit a gearhead, given by its key or row."""
        rows = self.pairs[self.pairs[:, 1] == self.gearheads.row(gearhead), 0]
        return tuple(self.motors.texts["key"][rows].tolist())

    def _rows(self) -> Iterator[tuple[str, str]]:
        yield "name", self.name
        yield "contents", self.contents
        if not self.pairs_stated:
            yield "pairs", "not stated: every motor with every gearhead"


def part_set(
    name: str,
    tables: Iterable[PartTable],
    pairs: np.ndarray | None = None,
    path: Path | None = None,
) -> PartSet:
    """Make a set of tables; without `pairs`, every motor is paired with every gearhead.

    Gearheads with the measured friction of a whole actuator are left out there: that friction is of gear and motor together.

    Raises
    ------
    ParameterError
        If two tables are of one kind, or a pair names a row that there is not.
    """
    given = list(tables)
    found = {kind: empty(kind) for kind in PARTS} | {one.kind: one for one in given}
    if len({one.kind for one in given}) < len(given):
        raise ParameterError(f"tables must be of different kinds, got {', '.join(one.kind for one in given)}")
    sizes = len(found["motors"]), len(found["gearheads"])
    if pairs is None:
        alone = [word for word, law in LAWS.items() if not law.SEARCHED]
        fitting = np.flatnonzero(~np.isin(found["gearheads"].texts["loss_model"], alone))
        rows = np.stack(np.meshgrid(np.arange(sizes[0]), fitting, indexing="ij"), axis=-1).reshape(-1, 2)
    else:
        rows = np.asarray(pairs).reshape(-1, 2)
        if rows.size and not ((rows >= 0) & (rows < np.array(sizes))).all():
            raise ParameterError(f"pairs must be rows of {sizes[0]} motors and {sizes[1]} gearheads")
    stated = pairs is not None or not rows.size
    return PartSet(name=name, tables=FrozenDict(found), pairs=rows.astype(np.int64), pairs_stated=stated, path=path)
