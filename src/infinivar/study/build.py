"""From a validated table to the frozen parts it describes, with the provenance of every value."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from infinivar._core.fields import hints
from infinivar.errors import InputError, ParameterError, nearest, printable
from infinivar.parts.motor import Motor
from infinivar.study.layers import Raw, over_parts
from infinivar.study.messages import StudyError, quoted
from infinivar.study.schema import CATALOGUES, Entry, described, keys, part_of, table_keys
from infinivar.study.study import DEFAULT, Provenance


def built_part(part: type, key: str) -> Any:
    """A part as the catalogue has it.

    Raises
    ------
    InputError
        If the catalogue has no such part.
    """
    try:
        return built(part, {"part": key}, CATALOGUES[part], key, [])
    except StudyError as problems:
        raise InputError("\n".join(problems.lines)) from None


def built(part: type, tree: Raw, path: str, owner: str, rows: list[Provenance]) -> Any:
    """The dataclass that a table describes; appends the provenance of its values to `rows`."""
    faults: list[str] = []
    checked = _read(part, over_parts(part, tree, path), path, faults)
    if faults:
        raise StudyError(*faults)
    return _instance(part, checked, path, owner, "", rows)


def _read(part: type, tree: Raw, path: str, faults: list[str]) -> dict[str, Any]:
    """What a table says, by key: an entry each, or what the table of a part says; appends a line a fault to `faults`."""
    known = table_keys(part)
    said: dict[str, Any] = {}
    for name, key in known.items():
        here, raw = f"{path}.{name}", tree.get(name, {})
        if name not in tree:
            if key.required:
                hint = f"; write a table [{here}]" if key.part is not None else ""
                faults.append(f"{here} is missing ({key.meaning}){hint}")
        elif key.part is not None:
            said[name] = _read(key.part, raw, here, faults)
        elif key.read is not None:
            try:
                said[name] = key.read(raw)
            except ValueError as problem:
                faults.append(f"{here}{_shown(raw)} {problem}")
    for name in tree:
        if name not in known:
            words = keys(part)
            hint = f"{nearest(name, words)}; known are {', '.join(words)}"
            faults.append(f"{path}.{printable(name)}{_shown(tree[name])} is not a known key{hint}")
    return said


def _shown(raw: Any) -> str:
    return f" = {quoted(raw['value'])}" if isinstance(raw, dict) and "value" in raw else ""


def _instance(
    part: type, checked: Mapping[str, Any], path: str, owner: str, prefix: str, rows: list[Provenance]
) -> Any:
    """Dataclass instance from a validated table, its parts first."""
    values: dict[str, Any] = {}
    for field in described(part):
        given = checked.get(field.name)
        unit = field.metadata.get("unit", "")
        here = f"{prefix}{field.name}"
        inner = part_of(hints(part)[field.name])
        if isinstance(given, Entry):
            values[field.name] = given.value
            rows.append(_row(owner, here, given, unit))
        elif inner is not None and given is not None:
            values[field.name] = _instance(inner, given, f"{path}.{field.name}", owner, f"{here}.", rows)
        elif inner is not None and field.default_factory is not dataclasses.MISSING:
            values[field.name] = _instance(inner, {}, f"{path}.{field.name}", owner, f"{here}.", rows)
        elif inner is None and field.default not in (None, dataclasses.MISSING) and field.name != "name":
            default = Entry(field.default, field.default, "assumed", DEFAULT)
            rows.append(_row(owner, here, default, unit))
    try:
        made = part(**values)
    except ParameterError as problem:
        raise StudyError(f"{path}.{problem}") from None
    except InputError as problem:
        raise StudyError(f"{path}: {problem}") from None
    scale = checked.get("scale")
    if part is Motor and scale is not None:
        rows.append(_row(owner, f"{prefix}scale", scale, "1"))
        made = made.scaled(scale.value)
    return made


def _row(owner: str, field: str, entry: Entry, unit: str) -> Provenance:
    return Provenance(
        owner=owner,
        field=field,
        written=str(entry.written),
        value=entry.value,
        unit=unit,
        kind=entry.kind or "assumed",
        where=entry.where or "",
    )
