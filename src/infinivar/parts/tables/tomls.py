"""Importer of TOML files: one table a part, in the words of a study file.

A file holds tables ``[motors.KEY]``, ``[gearheads.KEY]`` and so on, and ``[pairs]`` with the gearheads of each motor; or tables
``[KEY]`` of parts of one kind, as in the files of the shipped catalogue. ``manufacturer``, ``where``, ``date`` and ``kind`` at
the top hold for all rows that do not state their own.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from typing import Any

from infinivar import units
from infinivar._core import toml
from infinivar.errors import InputError, nearest, printable
from infinivar.parts.catalogue import PARTS
from infinivar.parts.gearhead import PARTS_OF_LAWS
from infinivar.parts.tables.checked_rows import Collector
from infinivar.parts.tables.columns import ONE, kind_by_columns, number_columns, text_columns

_KINDS = ("stated", "catalogue", "derived", "fitted", "assumed")
_FOR_ALL = {"manufacturer": "manufacturer", "where": "source", "source": "source", "date": "date", "kind": "kind"}
"""Keys that a row or the top of a file can have, and the columns they go to."""
_PAIRS = "pairs"
_HEADER = re.compile(r"^\s*(\[[^\[].*\])\s*(?:#.*)?$")


def read(collector: Collector, text: str, file: str) -> None:
    """Take the parts of a file.

    Raises
    ------
    InputError
        If it is not valid TOML, or what is at its top cannot be understood.
    """
    try:
        raw = toml.loads(text)
    except InputError as problem:
        raise InputError(f"{printable(file)}: {problem}") from problem
    lines = _lines(text)
    shared, tables = _top(raw, file)
    for kind, path, row in tables:
        line = lines.get(path)
        read_row(collector, kind, path[-1], {**shared, **row} if isinstance(row, dict) else row, file, line)
    for motor, gearheads in _pairs(raw, file):
        collector.fit(file, lines.get((_PAIRS,)), motor, gearheads)


def _top(raw: Mapping[str, Any], file: str) -> tuple[dict[str, Any], list[tuple[str, tuple[str, ...], Any]]]:
    """What holds for all rows, and each row with its kind and path."""
    shared: dict[str, Any] = {}
    found: list[tuple[str, tuple[str, ...], Any]] = []
    for key, value in raw.items():
        if key in _FOR_ALL and not isinstance(value, dict):
            shared[key] = value
        elif key == _PAIRS:
            continue
        elif not isinstance(value, dict):
            hint = nearest(key, [*_FOR_ALL, *PARTS, _PAIRS])
            raise InputError(
                f"{printable(file)}: {printable(key)} must be a table of parts, such as [motors.{key}]{hint}"
            )
        elif key in PARTS:
            found += [(key, (key, name), row) for name, row in value.items()]
        else:
            found.append((_kind_of(key, value, file), (key,), value))
    return shared, found


def _kind_of(key: str, row: Mapping[str, Any], file: str) -> str:
    """Kind of a part by the values that only one kind has."""
    kind = kind_by_columns(name for name, _ in _flat(row))
    if kind is None:
        known = ", ".join(f"[{kind}.{key}]" for kind in PARTS)
        raise InputError(
            f"{printable(file)}: [{printable(key)}] has no value that tells its kind; write one of {known}"
        )
    return kind


def read_row(collector: Collector, kind: str, key: str, row: Any, file: str, line: int | None) -> None:
    """Take the table of one part, or refuse it."""
    collector.take(kind, file, line, key, lambda: _row(kind, key, row))


def _row(kind: str, key: str, raw: Any) -> tuple[dict[str, Any], list[str]]:
    """A row in our columns, and remarks on what it cannot hold."""
    if not isinstance(raw, Mapping):
        raise InputError("must be a table of values")
    numbers, texts = number_columns(kind), text_columns(kind)
    row: dict[str, Any] = {}
    remarks = []
    for name, value in _flat(raw):
        if name in _FOR_ALL or name in texts:
            if not isinstance(value, str | int | float) or isinstance(value, bool):
                raise InputError(f"{name} must be text, got {value!r}")
            row[_FOR_ALL.get(name, name)] = str(value)
        elif name not in numbers:
            known = [*numbers, *texts]
            raise InputError(f"{name} is not a known key of a {ONE[kind]}{nearest(name, known)}")
        else:
            row[name] = _number(name, value, numbers[name].unit)
            if isinstance(value, Mapping) and {"kind", "where"} & value.keys():
                remarks.append(f"kind and where of the single value {name} were left out: a row has one source")
    if row.get("kind", _KINDS[0]) not in _KINDS:
        raise InputError(f"kind = {row['kind']!r} must be one of {', '.join(_KINDS)}{nearest(row['kind'], _KINDS)}")
    return {**row, "key": key}, remarks


def _flat(raw: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Values by name; those of components that only some kinds have under names such as ``friction.viscous``."""
    for name, value in raw.items():
        if name in PARTS_OF_LAWS and isinstance(value, Mapping) and "value" not in value:
            yield from ((f"{name}.{inner}", one) for inner, one in value.items())
        else:
            yield name, value


def _number(name: str, raw: Any, unit: str) -> float:
    said = raw
    try:
        if isinstance(raw, Mapping):
            if "value" not in raw:
                raise InputError("must be a value, or a table with value, unit, kind and where")
            said = raw["value"] if "unit" not in raw else f"{raw['value']} {raw['unit']}"
        if isinstance(said, float) and math.isinf(said):
            return said
        return units.parse(said, unit)
    except InputError as problem:
        raise InputError(f"{name} = {str(said)[:40]!r} {problem}") from None


def _pairs(raw: Mapping[str, Any], file: str) -> Iterator[tuple[str, list[str]]]:
    table = raw.get(_PAIRS, {})
    if not isinstance(table, dict):
        raise InputError(f"{printable(file)}: pairs must be a table [pairs] of gearheads by motor")
    for motor, gearheads in table.items():
        named = [gearheads] if isinstance(gearheads, str) else gearheads
        if not isinstance(named, list) or not named or not all(isinstance(one, str) for one in named):
            where = f"{printable(file)}: pairs.{printable(motor)}"
            raise InputError(f'{where} must be a list of keys of gearheads, such as ["gp-22-*"]')
        yield motor, named


def _lines(text: str) -> dict[tuple[str, ...], int]:
    """Line of the header of each table, by path."""
    found: dict[tuple[str, ...], int] = {}
    for number, line in enumerate(text.splitlines(), 1):
        header = _HEADER.match(line)
        if header is None:
            continue
        try:
            level: Any = toml.loads(header[1])
        except InputError:  # a list over several lines, not a header
            continue
        path: list[str] = []
        while isinstance(level, dict) and level:
            path.append(next(iter(level)))
            level = level[path[-1]]
        found.setdefault(tuple(path), number)
    return found
