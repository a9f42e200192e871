"""Provenance of the values of a study: where each number comes from, complete and true for any study."""

from __future__ import annotations

import dataclasses
import numbers
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from infinivar import units
from infinivar._core.fields import Place, described, hints, part_of, walk
from infinivar.contact.creep import CreepLaw
from infinivar.errors import ParameterError
from infinivar.parts.motor import Motor
from infinivar.study.schema import SCALE

DEFAULT = "program default"
"""Source of values that the study does not state."""

GIVEN = "given in Python"
"""Source of values of a study built in Python."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Provenance:
    """Provenance of one value."""

    owner: str
    """Drive that the value belongs to, "requirement", "envelope" or "rig"."""
    field: str
    """Path of the field in the owner's table, such as "transmission.preload"."""
    written: str
    """The value as written in the file."""
    value: Any
    """The value in SI, or the word chosen."""
    unit: str
    """SI unit; "1" for pure numbers, "" for words."""
    kind: str
    """stated, catalogue, derived, fitted or assumed."""
    where: str
    """Place in the source, catalogue key or file."""


Rows = Mapping[tuple[str, str], Provenance]
"""Provenance by owner and field."""


def by_field(rows: Iterable[Provenance]) -> Rows:
    """Provenance by owner and field."""
    return {(row.owner, row.field): row for row in rows}


def same(one: Any, other: Any) -> bool:
    """Whether two values are equal; arrays, which no file states, count as different."""
    try:
        return bool(one == other)
    except ValueError:
        return False


def recorded(value: Any) -> Any:
    """The value as provenance records it: a creep law by its name."""
    return value.name if isinstance(value, CreepLaw) else value


def text_of(field: dataclasses.Field[Any], value: Any) -> str:
    """A value as a study file states it."""
    if "several" in field.metadata and isinstance(value, tuple):
        return "; ".join(", ".join(f"{key} = {text}" for key, text in texts_of(one).items()) for one in value)
    unit = field.metadata.get("unit", field.metadata.get("row of"))
    if unit is not None:
        members = value if isinstance(value, tuple) else (value,)
        if all(isinstance(one, numbers.Real) for one in members):
            return ", ".join(units.exact(one, unit) for one in members)
    return ", ".join(map(str, value)) if isinstance(value, tuple) else str(recorded(value))


def texts_of(instance: Any) -> dict[str, str]:
    """The quantities of one of several values, as a study file states them; without those left at their defaults."""
    stated = {field: getattr(instance, field.name) for field in described(type(instance))}
    return {field.name: text_of(field, value) for field, value in stated.items() if not same(value, field.default)}


def unscaled(motor: Motor, rows: Rows, owner: str, prefix: str) -> Motor | None:
    """The motor of which `motor` is a multiple, if its provenance records a scale and still holds."""
    scale = rows.get((owner, f"{prefix}scale"))
    if scale is None:
        return None
    found = {field.name: rows.get((owner, prefix + field.name)) for field in described(Motor)}
    try:
        one = Motor(**{name: row.value for name, row in found.items() if row is not None})
    except (ParameterError, TypeError):  # the records are those of another motor
        return None
    return one if one.scaled(scale.value) == motor else None


def values(instance: Any, owner: str, known: Rows, prefix: str = "") -> list[Place]:
    """All that a study states of an owner and of its parts, as `walk`; of several motors on one shaft one, and their number."""
    single = unscaled(instance, known, owner, prefix) if isinstance(instance, Motor) else None
    part = instance if single is None else single
    found = [*walk(part, prefix, lambda inner, inside: values(inner, owner, known, inside))]
    if single is not None:
        scale = f"{prefix}{SCALE.name}"
        found.append(Place(scale, single, SCALE, known[owner, scale].value))
    return found


def is_table(place: Place) -> bool:
    """Whether a study states a value as a table of its own, not as a number or word."""
    return part_of(hints(type(place.owner)).get(place.field.name)) is not None and "kinds" not in place.field.metadata


def completed(owners: Mapping[str, Any], rows: Iterable[Provenance]) -> tuple[Provenance, ...]:
    """One row per value of the owners, in the order of their fields: the known row if it is still true, else a new one."""
    known = by_field(rows)
    return tuple(row for owner, instance in owners.items() for row in _rows(instance, owner, known))


def _rows(instance: Any, owner: str, known: Rows) -> Iterator[Provenance]:
    if not dataclasses.is_dataclass(instance):
        yield from (row for (name, _), row in known.items() if name == owner)
    for place in values(instance, owner, known):
        if not is_table(place) and (row := _row(place, known.get((owner, place.path)), owner)) is not None:
            yield row


def _row(place: Place, row: Provenance | None, owner: str) -> Provenance | None:
    """The known row of a value if it is still true, else a new one; none for a default name."""
    field, value = place.field, place.value
    if row is not None and same(row.value, recorded(value)):
        return row
    default = same(value, field.default)
    if default and field.name == "name":
        return None
    return Provenance(
        owner=owner,
        field=place.path,
        written=str(field.default) if default else text_of(field, value),
        value=recorded(value),
        unit=field.metadata.get("unit", ""),
        kind="assumed",
        where=DEFAULT if default else GIVEN,
    )
