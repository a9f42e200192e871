"""Where sets of parts are looked up: beside a study, in the user's folder, and in installed packages; one is shipped."""

from __future__ import annotations

import functools
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from infinivar import units
from infinivar._core import files, plugins
from infinivar.errors import InputError, nearest, printable
from infinivar.parts import catalogue
from infinivar.parts.tables import tomls
from infinivar.parts.tables.checked_rows import Collector
from infinivar.parts.tables.columns import check_kind, number_columns
from infinivar.parts.tables.importing import SUFFIXES, PartImport, read_set
from infinivar.parts.tables.table import PartSet

SHIPPED = "shipped"
"""Name of the set that comes with the program."""

VARIABLE = "INFINIVAR_PARTS"
"""Environment variable that names the user's folder of sets."""

GROUP = "infinivar.catalogues"
"""Group of entry points under which packages register sets."""

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,63}")
"""What a set may be called."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """A set that can be had, and where it comes from."""

    name: str
    where: str
    path: Path | None = None


def users_folder() -> Path:
    """Folder of the user's own sets; INFINIVAR_PARTS names another."""
    requested = os.environ.get(VARIABLE)
    if requested:
        return Path(requested)
    return files.of_user("data") / "parts"


@functools.cache
def shipped() -> PartSet:
    """The shipped parts as tables."""
    collector = Collector(defaults={})
    for kind in catalogue.PARTS:
        for key, row in catalogue.rows(kind).items():
            tomls.read_row(collector, kind, key, row, f"{kind}.toml", None)
    if collector.faults:
        raise RuntimeError("; ".join(map(str, collector.faults)))
    return collector.finished(SHIPPED)


def places(beside: Sequence[Path] = ()) -> list[Place]:
    """Every set by name, in the order of precedence: shipped, beside the study, the user's, those of packages.

    Parameters
    ----------
    beside : paths   Folders, or single files, in which sets are looked up before those of the user.
    """
    found: dict[str, Place] = {SHIPPED: Place(name=SHIPPED, where="comes with the program")}
    for path in _files(beside):
        found.setdefault(path.stem, Place(name=path.stem, where=str(path), path=path))
    for path in _files([users_folder()]):
        found.setdefault(path.stem, Place(name=path.stem, where=str(path), path=path))
    for name in plugins.registered(GROUP):
        found.setdefault(name, Place(name=name, where="installed package"))
    return list(found.values())


def _files(folders: Sequence[Path]) -> Iterator[Path]:
    """Files that can hold a set: those named, and those in the folders named."""
    for folder in folders:
        if folder.is_file():
            yield folder
            continue
        try:
            inside = sorted(folder.iterdir())
        except OSError:  # no such folder: nobody has put a set there
            continue
        known = [path for path in inside if path.suffix.lower() in SUFFIXES and NAME.fullmatch(path.stem)]
        yield from sorted(known, key=lambda path: SUFFIXES.index(path.suffix.lower()))


def find(name: str, beside: Sequence[Path] = ()) -> PartImport:
    """A set by its name, with the rows of its file that were refused.

    Parameters
    ----------
    name : str       Name of a set, or the path of a file that holds one.
    beside : paths   As for `places`.

    Raises
    ------
    InputError
        If there is no such set, or it cannot be read.
    """
    if name == SHIPPED:
        return PartImport(parts=shipped(), faults=(), remarks=())
    path = next((path for path in _files([*beside, users_folder()]) if path.stem == name), None)
    if path is not None:
        return _read(path)
    if Path(name).suffix.lower() in SUFFIXES:
        return _read(Path(name))
    if name in plugins.registered(GROUP):
        return _of_package(name)
    known = [place.name for place in places(beside)]
    raise InputError(
        f"{name!r} is not a set of parts{nearest(name, known)}; sets: {', '.join(known)} (your own are in "
        f"{printable(users_folder())}, or in the folder parts beside the study)"
    )


def readable(beside: Sequence[Path] = ()) -> tuple[list[PartImport], list[str]]:
    """Every set that can be had and read, in the order of `places`, and why the others cannot be read, a line each.

    One bad file in a folder of sets must not keep the others from being used where none is named.
    """
    found, problems = [], []
    for place in places(beside):
        try:
            found.append(find(place.name, beside))
        except InputError as problem:
            problems.append(f"the set {place.name} was left out, as it cannot be read: {problem}")
    return found, problems


def load_parts(name: str | Path = SHIPPED) -> PartSet:
    """A set of parts as tables of columns in SI.

    Parameters
    ----------
    name : str or path   Name of a set: "shipped", one of the user's folder, or one that an installed package registers; or the
        path of a file that holds one.

    Raises
    ------
    InputError
        If there is no such set, it cannot be read, or rows of its file were refused; `import_parts` keeps the good ones.
    """
    found = find(str(name))
    if found.faults:
        raise InputError("\n".join(str(fault) for fault in found.faults))
    return found.parts


def _read(path: Path) -> PartImport:
    try:
        found = path.stat()
        stamp = found.st_mtime_ns, found.st_size, found.st_ino
    except OSError:
        stamp = 0, 0, 0
    return _cached(path.absolute(), stamp)


@functools.lru_cache(maxsize=16)
def _cached(path: Path, stamp: tuple[int, int, int]) -> PartImport:
    return read_set(path)


def _of_package(name: str) -> PartImport:
    """The set that a package registers: a set, the path of a file, or a function without arguments that returns either."""
    loaded = plugins.load(GROUP, name, _not_a_set, (SHIPPED,))
    if isinstance(loaded, PartSet):
        return PartImport(parts=replace(loaded, name=name), faults=(), remarks=())
    made = plugins.call(GROUP, name, loaded) if callable(loaded) else loaded
    if isinstance(made, PartSet):
        return PartImport(parts=replace(made, name=name), faults=(), remarks=())
    if isinstance(made, str | Path):
        return read_set(Path(made), name)
    raise InputError(f"the set of parts {name!r} must be a PartSet or the path of a file, got a {type(made).__name__}")


def _not_a_set(loaded: Any) -> str | None:
    fits = isinstance(loaded, PartSet | str | Path) or callable(loaded)
    return None if fits else "a PartSet, the path of a file, or a function that returns one of them"


def entry(kind: str, name: str, beside: Sequence[Path] = ()) -> Mapping[str, Any]:
    """What a study takes over of a part: values as text with units, their kind and source.

    Parameters
    ----------
    kind : str       "motors", "gearheads", "bearings", "rails", "belts", "springs", "tubes" or "materials".
    name : str       Key of a shipped part, or SET:KEY.
    beside : paths   As for `places`.

    Raises
    ------
    InputError
        If there is no such part; the message suggests the closest key, or says why its row was refused.
    """
    check_kind(kind)
    required, colon, key = name.partition(":")
    if not colon or required == SHIPPED:
        return catalogue.entry(kind, key if colon else name)
    found = find(required, beside)
    table = found.parts.tables[kind]
    refused = next((fault for fault in found.faults if fault.what == key), None)
    if key not in table.part_keys:
        if refused is not None:
            raise InputError(f"{name!r} was refused: {refused}")
        raise InputError(f"{name!r} is not among the {kind} of {required}{nearest(key, table.part_keys)}")
    return _entry(table.stated(key), kind, name)


def _entry(said: Mapping[str, Any], kind: str, name: str) -> dict[str, Any]:
    columns = number_columns(kind)
    derived = str(said.get("derived", "")).split()
    fields = catalogue.PARTS[kind].__dataclass_fields__
    made: dict[str, Any] = {"kind": said.get("kind", "catalogue"), "where": origin_of(said, name)}
    for column, value in said.items():
        outer, _, inner = column.partition(".")
        if outer not in fields or outer in ("kind", "where"):
            continue
        if column not in columns:
            made[column] = value
        elif inner:
            made.setdefault(outer, {})[inner] = units.exact(value, columns[column].unit)
        elif column in derived:
            made[column] = {"value": units.exact(value, columns[column].unit), "kind": "derived"}
        else:
            made[column] = units.exact(value, columns[column].unit)
    made.setdefault("name", said["key"])
    return made


def origin_of(said: Mapping[str, Any], name: str) -> str:
    """Source of a row for its provenance: set and key, manufacturer and order number, source and date."""
    maker = " ".join(filter(None, (said.get("manufacturer"), said.get("order_number"))))
    return ", ".join(filter(None, (name, maker, said.get("source"), said.get("date"))))
