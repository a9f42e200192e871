"""From a validated table to the frozen parts it describes, with the provenance of every value."""

from __future__ import annotations

import dataclasses
import typing
from typing import Any

import pydantic

from infinivar.errors import InputError, ParameterError
from infinivar.parts.motor import Motor
from infinivar.study.layers import Raw, over_parts
from infinivar.study.messages import StudyError, explained
from infinivar.study.schema import CATALOGUES, Entry, described, part_of, table
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
    tree = over_parts(part, tree, path)
    try:
        checked = table(part).model_validate(tree)
    except pydantic.ValidationError as problem:
        raise StudyError(*(explained(error, part, path) for error in problem.errors(include_url=False))) from None
    return _instance(part, checked, path, owner, "", rows)


def _instance(part: type, checked: Any, path: str, owner: str, prefix: str, rows: list[Provenance]) -> Any:
    """Dataclass instance from a validated table, its parts first."""
    hints = typing.get_type_hints(part)
    values: dict[str, Any] = {}
    for field in described(part):
        given = getattr(checked, field.name)
        unit = field.metadata.get("unit", "")
        here = f"{prefix}{field.name}"
        inner = part_of(hints[field.name])
        if isinstance(given, Entry):
            values[field.name] = given.value
            rows.append(_row(owner, here, given, unit))
        elif inner is not None and given is not None:
            values[field.name] = _instance(inner, given, f"{path}.{field.name}", owner, f"{here}.", rows)
        elif inner is not None and field.default_factory is not dataclasses.MISSING:
            empty = table(inner).model_validate({})
            values[field.name] = _instance(inner, empty, f"{path}.{field.name}", owner, f"{here}.", rows)
        elif inner is None and field.default not in (None, dataclasses.MISSING) and field.name != "name":
            default = Entry(field.default, field.default, "assumed", DEFAULT)
            rows.append(_row(owner, here, default, unit))
    try:
        made = part(**values)
    except ParameterError as problem:
        raise StudyError(f"{path}.{problem}") from None
    except InputError as problem:
        raise StudyError(f"{path}: {problem}") from None
    scale = getattr(checked, "scale", None)
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
