"""The contacts of a machine: checked, grouped by kind, and their results joined again."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from infinivar._core.array_namespace import Array
from infinivar._core.arrays import shown
from infinivar._core.result import equal
from infinivar.errors import ParameterError, require
from infinivar.transmission.rolling_contact import RollingContact


def contacts_of(given: Any, count: int, each: str) -> tuple[RollingContact, ...]:
    """One contact for each of `count` wheels, from a row of contacts or one for all.

    Raises
    ------
    ParameterError
        If their number does not fit, one is no `RollingContact`, or its creep law has a flow loss.
    """
    if not isinstance(given, (RollingContact, Sequence)) or isinstance(given, (str, bytes)):
        raise ParameterError(f"contacts must be RollingContact, one for all or one for each {each}, got {shown(given)}")
    contacts = (given,) * count if isinstance(given, RollingContact) else tuple(given)
    require(len(contacts) == count, "contacts", len(contacts), f"{count}, one for each {each}")
    for contact in contacts:
        if not isinstance(contact, RollingContact):
            raise ParameterError(f"contacts must be RollingContact, got {contact!r}")
        if contact.creep_law.flow_factor is not None:
            raise ParameterError(
                f"creep_law must be one without a flow loss, got {contact.creep_law.name!r}: Eq 17 is a loss of the link "
                "speed of a wheel on a cylinder (RotaryLinearIVT)"
            )
    return contacts


def kinds_of(contacts: Sequence[RollingContact]) -> tuple[tuple[RollingContact, tuple[int, ...]], ...]:
    """Contacts that differ, with the wheels that have them."""
    found: list[tuple[RollingContact, list[int]]] = []
    for place, contact in enumerate(contacts):
        for known, wheels in found:
            if known is contact or equal(known, contact):
                wheels.append(place)
                break
        else:
            found.append((contact, [place]))
    return tuple((contact, tuple(wheels)) for contact, wheels in found)


def joined(xp: Any, parts: Sequence[Any], back: Array) -> Any:
    """Tuples of arrays and of dictionaries of arrays, joined along the wheels; what a kind lacks is zero."""
    joined = []
    for place, first in enumerate(parts[0]):
        pieces = [part[place] for part in parts]
        if isinstance(first, dict):
            like = [part[0] for part in parts]
            names = dict.fromkeys(name for piece in pieces for name in piece)
            joined.append(
                {
                    name: _wheels(xp, [p.get(name, 0.0 * one) for p, one in zip(pieces, like, strict=True)], back)
                    for name in names
                }
            )
        else:
            joined.append(_wheels(xp, pieces, back))
    return type(parts[0])(*joined)


def _wheels(xp: Any, pieces: Sequence[Array], back: Array) -> Array:
    return xp.take(xp.concat(pieces, axis=-1), back, axis=-1)
