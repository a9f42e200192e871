"""Extensions that installed packages register as entry points; looked up only where a word is not known otherwise."""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable, Collection
from typing import TYPE_CHECKING, Any

from infinivar.errors import InputError

if TYPE_CHECKING:
    from importlib import metadata

GROUPS = {
    "infinivar.catalogues": "set of parts",
    "infinivar.creep_laws": "creep law",
    "infinivar.drives": "drive",
    "infinivar.forces": "force",
    "infinivar.limits": "limit",
    "infinivar.motions": "motion",
    "infinivar.parts": "part",
}
"""Groups of entry points, and what each of them registers."""

Check = Callable[[Any], str | None]
"""Returns what an extension must be if it is something else, such as "a CreepLaw"."""


def is_own(thing: Any) -> bool:
    """Whether a drive, part or motion is of another package than this program."""
    return type(thing).__module__.partition(".")[0] != __name__.partition(".")[0]


def registered(group: str) -> tuple[str, ...]:
    """Words that installed packages add to a group, whether or not they can be used."""
    return tuple(_found(group, tuple(sys.path)))


def packages() -> set[str]:
    """Names of the packages of all extensions that are installed."""
    return {
        point.module.partition(".")[0]
        for group in GROUPS
        for points in _found(group, tuple(sys.path)).values()
        for point in points
    }


def _one(group: str, name: str, known: Collection[str]) -> metadata.EntryPoint:
    """The one entry point of a registered word; raises InputError if the program or two packages have it."""
    points = _found(group, tuple(sys.path))[name]
    if name in known:
        raise InputError(f"{_described(group, points[0])} has the name of a built-in one; it must have another name")
    if len({point.value for point in points}) > 1:
        packages = " and ".join(_package(point) for point in points)
        raise InputError(f"the {GROUPS[group]} {name!r} is registered by {packages}; remove one of them")
    return points[0]


def load(group: str, name: str, check: Check, known: Collection[str] = ()) -> Any:
    """Load an extension, or return None if no installed package registers the word; other words may be faulty.

    Parameters
    ----------
    group : str           One of `GROUPS`.
    name : str            The word.
    check : callable      Judges what is loaded.
    known : collection    Words of the program itself.

    Raises
    ------
    InputError
        If the extension cannot be imported or is not what the group asks for, has the name of a built-in one, or two
        packages register it.
    """
    if name not in registered(group):
        return None
    point = _one(group, name, known)
    try:
        loaded = point.load()
    except Exception as problem:  # the code of others may fail in any way
        raise InputError(
            f"{_described(group, point)} cannot be loaded: {type(problem).__name__}: {problem}"
        ) from problem
    required = check(loaded)
    if required is not None:
        raise InputError(f"{_described(group, point)} must be {required}, got {_shown(loaded)}")
    return loaded


def call(group: str, name: str, function: Callable[[], Any]) -> Any:
    """What a loaded extension that is a function without arguments returns.

    Raises
    ------
    InputError
        If the function fails.
    """
    try:
        return function()
    except Exception as problem:  # the code of others may fail in any way
        raise InputError(
            f"{_described(group, _one(group, name, ()))} fails when it is called: {type(problem).__name__}: {problem}"
        ) from problem


@functools.lru_cache(maxsize=32)
def _found(group: str, path: tuple[str, ...]) -> dict[str, list[metadata.EntryPoint]]:
    """Entry points of a group by name, for the current search path of modules."""
    from importlib import metadata  # a tenth of the time to load a study that needs no extension

    found: dict[str, list[metadata.EntryPoint]] = {}
    for point in metadata.entry_points(group=group):
        found.setdefault(point.name, []).append(point)
    return found


def _package(point: metadata.EntryPoint) -> str:
    return f"{point.dist.name} {point.dist.version}" if point.dist is not None else "an unknown package"


def _described(group: str, point: metadata.EntryPoint) -> str:
    return f"the {GROUPS[group]} {point.name!r} ({point.value} of {_package(point)})"


def _shown(value: Any) -> str:
    return f"the class {value.__name__}" if isinstance(value, type) else f"a {type(value).__name__}"
