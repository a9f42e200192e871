"""Words of a study file that installed packages add: creep laws, drives, parts, motions and forces."""

from __future__ import annotations

import contextlib
import dataclasses
import functools
from collections.abc import Callable, Collection, Mapping
from typing import Any

from infinivar._core import plugins
from infinivar._core.fields import missing_members
from infinivar.contact.creep import CreepLaw
from infinivar.drivetrain.drive import DRIVE_NEEDS
from infinivar.errors import InputError, nearest

VARIANT = "variant"
"""Key of a part's table that asks for a part of another package."""

_MOTION, _FORCE = ("at", "breaks"), ("value", "rate", "breaks")


def creep_law(word: str, known: Collection[str]) -> CreepLaw | None:
    """The creep law that a package registers under a word; None if there is none."""
    return plugins.load("infinivar.creep_laws", word, _not_a_law, known)


def drive_type(word: str, known: Collection[str]) -> type | None:
    """The type of drive that a package registers under a word; None if there is none."""
    return plugins.load("infinivar.drives", word, functools.partial(_not_a_class, DRIVE_NEEDS), known)


def kind(field: str, word: str, known: Collection[str]) -> type | None:
    """The motion or force that a package registers under a shape; None if there is none."""
    needs = _MOTION if field == "motion" else _FORCE
    return plugins.load(f"infinivar.{field}s", word, functools.partial(_not_a_class, needs), known)


def part(word: str) -> type | None:
    """The part that a package registers under a word; None if there is none."""
    return plugins.load("infinivar.parts", word, functools.partial(_not_a_class, ()))


def variant_of(base: type, table: Any, path: str) -> type:
    """The part that a table asks for: of another package if it has a variant, else `base`.

    Raises
    ------
    InputError
        If the variant is unknown or stands for another part; the message names the key.
    """
    requested = table.get(VARIANT) if isinstance(table, dict) else None
    if requested is None:
        return base
    word = requested.get("value") if isinstance(requested, dict) else requested
    found = part(word) if isinstance(word, str) else None
    if found is None:
        known = plugins.registered("infinivar.parts")
        words = (
            f"one of {', '.join(known)}{nearest(str(word), known)}" if known else "removed: no package registers parts"
        )
        raise InputError(f"{path}.{VARIANT} = {word!r} must be {words}")
    if not issubclass(found, base):
        raise InputError(f"{path}.{VARIANT} = {word!r} is a {found.__name__}, which is no {base.__name__}")
    return found


def word_of(group: str, kind: type, find: Callable[[str], Any]) -> str | None:
    """The word under which a package registers a class; None if none does. Packages that cannot be used do not matter."""
    for word in plugins.registered(group):
        with contextlib.suppress(InputError):
            if find(word) is kind:
                return word
    return None


Skip = Callable[[str], None]
"""Called with what is wrong with an extension that is left out."""


def drive_types(known: Mapping[str, type], skip: Skip) -> dict[str, type]:
    """Every type of drive that can be used, by word."""
    return _with_own(known, "infinivar.drives", lambda word: drive_type(word, known), skip)


def kinds(field: dataclasses.Field[Any], skip: Skip) -> dict[str, type]:
    """Every kind of a motion or force that can be used, by shape."""
    known = field.metadata["kinds"]
    found = _with_own(known, f"infinivar.{field.name}s", lambda word: kind(field.name, word, known), skip)
    return {word: one for word, one in found.items() if word in known or usable(field, one)}


def usable(field: dataclasses.Field[Any], own: type) -> bool:
    """Whether a registered motion serves for a field: a duty cycle needs one that repeats."""
    return not field.metadata["flat"] or not missing_members(own, ("period", "derivatives", "push"))


def creep_laws(known: Mapping[str, CreepLaw], skip: Skip) -> dict[str, CreepLaw]:
    """Every creep law that can be used, by word."""
    return _with_own(known, "infinivar.creep_laws", lambda word: creep_law(word, known), skip)


def parts(skip: Skip) -> dict[str, type]:
    """Every part of another package that can be used, by word."""
    return _with_own({}, "infinivar.parts", part, skip)


def _with_own(known: Mapping[str, Any], group: str, find: Callable[[str], Any], skip: Skip) -> dict[str, Any]:
    found = dict(known)
    for word in plugins.registered(group):
        try:
            found[word] = find(word)
        except InputError as problem:
            skip(str(problem))
    return found


def _not_a_law(loaded: Any) -> str | None:
    return None if isinstance(loaded, CreepLaw) else "a CreepLaw"


def _not_a_class(needs: tuple[str, ...], loaded: Any) -> str | None:
    """What a class of an own drive, motion or part must be; None if it is that."""
    if not isinstance(loaded, type) or not dataclasses.is_dataclass(loaded):
        return "a class that is a dataclass"
    missing = missing_members(loaded, needs)
    if missing:
        return f"a dataclass with {', '.join(needs)} (it has no {missing[0]})"
    unknown = [
        field.name
        for field in dataclasses.fields(loaded)
        if field.init and "meaning" not in field.metadata and field.default is field.default_factory
    ]
    if unknown:
        return f"a dataclass whose fields are made with infinivar.quantity or infinivar.component (not {unknown[0]})"
    return None
