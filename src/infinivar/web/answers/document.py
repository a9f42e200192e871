"""The study that the page holds: its tables become a `Study`, and what is wrong with them is stated field by field.

The page sends the tables of a study file with each request. They may name files - recordings, meshes, robots, sets of parts -
only as the study does with which the server was started: no other path of a page is opened.
"""

from __future__ import annotations

import contextlib
import copy
import functools
import hashlib
import json
import pickle
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from infinivar._core import toml
from infinivar.errors import InputError, printable
from infinivar.motion.files.fields import FILE_KEYS
from infinivar.parts.tables.stores import NAME
from infinivar.study.extend import DRIVE_FILES, extended, parts_of
from infinivar.study.load import load_study, read_tables, study_from_dict
from infinivar.study.shipped import study_file
from infinivar.study.study import Study
from infinivar.web.answers.answer import FaultyError, RefusedError
from infinivar.web.answers.recent import Recent

FIRST = "hand_controller"
"""Shipped study that is shown if none is named."""

_KEPT = 24
"""Studies kept, so that answers about the same tables build them once."""

_PLACE = re.compile(
    r"(requirement|drives|scenarios|duty|tasks|paths|rig|uncertainty|correlations|parts|title|description|name|reconstruction|"
    r"extends|format)((?:\.[\w-]+)*)"
)

_OF_EVERY_DRIVE = ("duty", "tasks", "paths", "extends")
"""Tables with which the part of the plane that maps show may depend on every drive."""

_APART = ("scenarios", "uncertainty", "correlations", "rig")
"""Tables on which maps do not depend."""

Tables = dict[str, Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class Source:
    """The study with which the explorer was started.

    Attributes
    ----------
    name     Of the study.
    tables   Of its file, those of files that it extends included.
    text     Of its file.
    folder   Of the files that it names.
    files    Those files, as written in the tables.
    parts    Files and folders with sets of parts, as written; by default the folder `parts`.
    read     Its file, and those that it extends.
    stamp    State of all these files when they were read, see `stamp`.
    """

    name: str
    tables: Tables
    text: str
    folder: Path
    files: frozenset[str] = frozenset()
    parts: frozenset[str] = frozenset()
    read: tuple[Path, ...] = ()
    stamp: str = ""


_sources: list[Source] = []
_studies: Recent[str, tuple[Study, Mapping[str, str]]] = Recent(_KEPT)


def begin(path: str | None = None) -> Study:
    """Start with a study file or shipped study, by default the first shipped one.

    Raises
    ------
    InputError
        If the study is invalid.
    """
    file = study_file(Path(FIRST if path is None else path))
    read: list[Path] = []

    def reading(one: Path) -> Tables:
        read.append(one)
        return read_tables(one)

    study = load_study(file)
    tables = extended(reading(file), file, reading)
    tables.pop("name", None)
    shipped = file in _shipped_files()
    made = Source(
        name=study.name,
        tables=tables,
        text=file.read_text("utf-8"),
        folder=file.resolve().parent,
        files=frozenset(_files_in(tables)),
        parts=frozenset() if shipped else frozenset(parts_of(tables)),
        read=tuple(read),
    )
    _sources[:] = [replace(made, stamp=stamp(made))]
    _studies.clear()
    return study


def begin_again() -> None:
    """Read the files of the study anew.

    Raises
    ------
    InputError
        If the study is invalid now; the one that was read before stays.
    """
    begin(str(source().read[0]))


def stamp(of: Source | None = None) -> str:
    """State on disk of the files of the study with which the explorer was started: the same text until one of them changes."""
    known = source() if of is None else of
    return key_of([_state_of(one) for one in (*known.read, *(known.folder / name for name in sorted(known.files)))])


def _state_of(file: Path) -> tuple[int, int] | None:
    try:
        found = file.stat()
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size


def source() -> Source:
    """The study with which the explorer was started."""
    if not _sources:
        begin()
    return _sources[0]


@functools.cache
def _shipped_files() -> frozenset[Path]:
    from infinivar.study.shipped import shipped_studies

    return frozenset(shipped_studies().values())


def _files_in(tables: Any) -> Iterator[str]:
    """Yield every file that tables name by a key."""
    for _, name in _named_files(tables, ""):
        yield name


def _named_files(tables: Any, path: str) -> Iterator[tuple[str, str]]:
    """Yield path and content of every key that names a file, bare or as a table with a value."""
    if isinstance(tables, list):
        for one in tables:
            yield from _named_files(one, path)
    if not isinstance(tables, dict):
        return
    for key, value in tables.items():
        here = f"{path}.{key}" if path else str(key)
        if key in (*FILE_KEYS, *DRIVE_FILES):
            content = value.get("value") if isinstance(value, dict) and "value" in value else value
            if isinstance(content, str):
                yield here, content
                continue
        yield from _named_files(value, here)


def _named_parts(tables: Any, path: str) -> Iterator[tuple[str, str]]:
    """Yield path and content of every key `part` that names a set of parts."""
    if not isinstance(tables, dict):
        return
    for key, value in tables.items():
        here = f"{path}.{key}" if path else str(key)
        content = value.get("value") if isinstance(value, dict) and "value" in value else value
        if key == "part" and isinstance(content, str) and ":" in content:
            yield here, content
        else:
            yield from _named_parts(value, here)


def _check_files(tables: Tables) -> None:
    """Refuse files other than those of the study with which the explorer was started.

    Raises
    ------
    FaultyError
        With each key that names another file.
    """
    faults = _refused(tables)
    if faults and source().stamp != stamp():  # the files may name others by now
        with contextlib.suppress(InputError):
            begin_again()
            faults = _refused(tables)
    if faults:
        raise FaultyError(faults)


def _refused(tables: Tables) -> list[dict[str, str]]:
    """Faults of the keys that name files which are not those of the study with which the explorer was started."""
    known, faults = source(), []
    own = f"the explorer opens only files of the study it was started with: infinivar serve {known.name}.toml"
    if "extends" in tables:
        faults.append(_fault("extends", f"extends = {_short(tables['extends'])}: {own}; remove extends"))
    for path, name in _named_files(tables, ""):
        if name not in known.files:
            faults.append(_fault(path, f"{path} = {_short(name)}: {own}, and it names no such file"))
    for path, name in _named_parts(tables, ""):
        if not NAME.fullmatch(name.partition(":")[0]):
            faults.append(_fault(path, f"{path} = {_short(name)}: a set of parts must be named, not given as a file"))
    named = tables.get("parts", [])
    listed = [one for one in (named if isinstance(named, list) else [named]) if isinstance(one, str)]
    others = [one for one in listed if one not in known.parts]
    faults += [_fault("parts", f"parts = {_short(name)}: {own}, and it names no such sets of parts") for name in others]
    return faults


def _short(value: Any) -> str:
    text = printable(repr(value) if not isinstance(value, str) else f'"{value}"')
    return text if len(text) <= 80 else f"{text[:60]} ..."


def _fault(at: str, message: str) -> dict[str, str]:
    return {"at": at, "message": message}


def name_and_tables(payload: Mapping[str, Any]) -> tuple[str, Tables]:
    """Name and tables of the study of a request.

    Raises
    ------
    RefusedError
        If they are missing or of another kind.
    """
    name, tables = payload.get("name"), payload.get("tables")
    if not isinstance(name, str) or not isinstance(tables, dict):
        raise RefusedError("name must be text, and tables must be a JSON object: the tables of a study file")
    return name, tables


def with_values(tables: Tables, changes: Iterable[tuple[Sequence[str], Any]]) -> Tables:
    """A copy of tables with values changed, each at a list of keys.

    Raises
    ------
    RefusedError
        If a key leads through what is no table.
    """
    made = copy.deepcopy(tables)
    for keys, value in changes:
        inside = made
        for key in keys[:-1]:
            inside = inside.setdefault(key, {})
            if not isinstance(inside, dict):
                raise RefusedError(f"{'.'.join(keys)} leads through a value")
        inside[keys[-1]] = value
    return made


def study_of(payload: Mapping[str, Any]) -> Study:
    """The study of a request.

    Raises
    ------
    RefusedError
        If the request has no tables.
    FaultyError
        If the tables are invalid.
    """
    return with_keys(payload)[0]


def with_keys(payload: Mapping[str, Any], drives: Any = None) -> tuple[Study, Mapping[str, str]]:
    """The study of a request, and of each of its drives a text that is the same as long as all its values are.

    With the names of some drives, as a map asks for them, the others may be missing: building them takes longer than a small map.
    Raises as `study_of`.
    """
    name, tables = name_and_tables(payload)
    tables = _with_drives(tables, drives) if isinstance(drives, list) else tables
    try:
        key = key_of(json.dumps([name, tables]), stamp())
    except RecursionError as problem:
        raise RefusedError("the tables are nested too deeply") from problem
    if key in _studies:
        return _studies[key]
    with faults_by_field(name):
        _check_files(tables)
        parts = {"parts": []} if "parts" not in tables and not source().parts else {}
        made = study_from_dict({**tables, **parts}, name=name, folder=source().folder)
    # At once: drives keep what they have computed, and would be written otherwise later.
    keys = {one: key_of(type(drive).__qualname__, drive, made.requirement) for one, drive in made.drives.items()}
    _studies[key] = made, keys
    return made, keys


def _with_drives(tables: Tables, required: list[Any]) -> Tables:
    """The tables with these drives and those that they are like, without runs; all of them if motions concern every drive."""
    every = tables.get("drives")
    if not isinstance(every, dict) or not tables.get("requirement") or any(key in tables for key in _OF_EVERY_DRIVE):
        return tables
    needed: set[str] = set()
    for name in required:
        while isinstance(name, str) and name in every and name not in needed:
            needed.add(name)
            name = every[name].get("like") if isinstance(every[name], dict) else None
    kept = {name: drive for name, drive in every.items() if name in needed}
    return {**{key: value for key, value in tables.items() if key not in _APART}, "drives": kept} if kept else tables


def key_of(*values: Any) -> str:
    """The same text for the same values."""
    return hashlib.sha256(pickle.dumps(values, protocol=5)).hexdigest()[:24]


@contextlib.contextmanager
def faults_by_field(name: str) -> Iterator[None]:
    """Turn the message of an `InputError` into faults, each at its field.

    Raises
    ------
    FaultyError
        With one fault per line of the message.
    """
    try:
        yield
    except InputError as problem:
        raise FaultyError([located(line, name) for line in str(problem).split("\n")]) from problem


def located(line: str, name: str) -> dict[str, str]:
    """A line of a message with the path of the field that it is about, "" if it names none."""
    line = line.removeprefix(f"{printable(name)}: ")
    found = _PLACE.match(line)
    return _fault(found[0] if found else "", line)


def tables_of(text: str, name: str) -> Tables:
    """The tables of a TOML text.

    Raises
    ------
    FaultyError
        If it is not TOML, or holds what no study does.
    """
    try:
        return toml.loads(text)
    except InputError as problem:
        raise FaultyError([_fault("", f"{printable(name)}: {problem}")]) from None
