"""Studies that extend another study: values of this file override those of the extended one."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from infinivar.errors import InputError, nearest, printable
from infinivar.motion.files.fields import FILE_KEYS
from infinivar.study.layers import Raw, alternatives_over, annotated, layered, merged
from infinivar.study.messages import StudyError, quoted
from infinivar.study.shipped import shipped_studies
from infinivar.study.spreads import is_group, leaves

_DEEPEST = 8
KEYS = (
    "title", "description", "extends", "requirement", "envelope", "drives", "scenarios", "duty", "tasks", "paths", "rig",
    "uncertainty", "correlations", "reconstruction", "name", "parts", "format",
)  # fmt: skip
"""Keys of a study at the top level."""
FORMAT = 1
"""Format of study files that this version reads; a file that states none has format 1."""
DRIVE_FILES = ("model",)
"""Keys of drives that name a file."""
PARTS_FOLDER = "parts"
"""Folder beside a study in which sets of parts are looked up."""

_TABLES = ("requirement", "envelope", "rig")
_GROUPS = ("drives", "scenarios", "duty", "tasks", "paths")


def extended(raw: Raw, path: Path, read: Callable[[Path], Raw], depth: int = 0) -> Raw:
    """Lay the tables of a study over those of the file it extends, if any.

    Parameters
    ----------
    raw : dict       Tables as written in the file at `path`.
    path : Path      Path of the file; `extends` is relative to its folder.
    read : callable  Takes a path and returns the tables of that file.

    Raises
    ------
    StudyError
        If a file cannot be read or has another format, or files extend each other in a circle.
    """
    # Faults of an extended file name it.
    where = f"{printable(path.name)}: " if depth else ""
    _check_format(raw, where)
    if depth and (unknown := unknown_keys(raw)):
        raise StudyError(where + next(iter(unknown.values())))
    if "extends" not in raw:
        return raw
    name = raw["extends"]
    if not isinstance(name, str) or not name:
        raise StudyError(
            f"{where}extends = {quoted(name)} must be the path of a study file, or the name of a shipped study"
        )
    if depth == _DEEPEST:
        raise StudyError(f"{where}extends = {quoted(name)}: more than {_DEEPEST} levels of extends; check for a circle")
    try:
        below = extended_file(path.parent, name)
    except StudyError as problem:
        raise StudyError(*(where + line for line in problem.lines)) from None
    try:
        beneath = read(below)
    except InputError as problem:
        raise StudyError(f"{where}extends = {quoted(name)}: {problem}") from problem
    folder = Path(name).parent if below == path.parent / name else below.parent
    under = _with_paths(extended(beneath, below, read, depth + 1), folder)
    over = {key: value for key, value in raw.items() if key != "extends"}
    under.pop("name", None)
    parts = {"parts": list(dict.fromkeys([*parts_of(over), *under["parts"]]))}
    return {**under, **over, **parts, **_merged_tables(under, over, below.name, path.name)}


def _check_format(raw: Raw, where: str) -> None:
    """Raise StudyError if a file states another format than that of this version."""
    number = raw.get("format", FORMAT)
    if type(number) is not int or number != FORMAT:
        newer = type(number) is int and number > FORMAT
        hint = "; the file is for a newer infinivar: pip install --upgrade infinivar" if newer else ""
        raise StudyError(f"{where}format = {quoted(number)} must be {FORMAT}{hint}")


def extended_file(folder: Path, name: str) -> Path:
    """Return the file that a study in a folder extends: a path from there, or the name of a shipped study.

    Raises
    ------
    StudyError
        If a bare name is neither; the message lists the shipped studies.
    """
    known, file = shipped_studies(), folder / name
    if name in known and not file.is_file():
        return known[name]
    if os.path.exists(file) or Path(name).suffix or Path(name).name != name:  # noqa: PTH110 (Path.exists raises on odd names)
        return file
    raise StudyError(
        f"extends = {quoted(name)} is neither a file beside this one nor a shipped study{nearest(name, known)}; shipped "
        f"studies: {', '.join(known)}"
    )


def unknown_keys(raw: Raw) -> dict[str, str]:
    """Keys that a study does not have at its top level, and what is wrong with each."""
    return {
        key: f"{printable(key)} is not a known key{nearest(key, KEYS)}; known keys: {', '.join(KEYS)}"
        for key in raw
        if key not in KEYS
    }


def parts_of(raw: Raw) -> list[str]:
    """Files and folders with sets of parts that a study names; by default the folder `parts`.

    Raises
    ------
    StudyError
        If `parts` is neither text nor a list of texts.
    """
    named = raw.get("parts", PARTS_FOLDER)
    listed = [named] if isinstance(named, str) else named
    if not isinstance(listed, list) or not all(isinstance(one, str) and one for one in listed):
        raise StudyError(
            f"parts = {quoted(named)} must be the path of a file or folder with sets of parts, or a list of paths"
        )
    return listed


def _with_paths(raw: Raw, folder: Path) -> Raw:
    """Resolve the files that a study names against its own folder, as seen from the study that extends it."""
    result = {**raw, "parts": [str(folder / one) for one in parts_of(raw)]}
    for group in ("scenarios", "duty", "paths"):
        tasks = result.get(group)
        if isinstance(tasks, dict):
            result[group] = {name: _resolved(task, folder) for name, task in tasks.items()}
    drives = result.get("drives")
    if isinstance(drives, dict):
        result["drives"] = {name: _resolved(one, folder, DRIVE_FILES) for name, one in drives.items()}
    return result


def _resolved(table: Any, folder: Path, keys: Sequence[str] = FILE_KEYS) -> Any:
    if not isinstance(table, dict):
        return table
    result = {key: _resolved(value, folder, keys) for key, value in table.items()}
    for key in keys:
        file = table.get(key)
        if isinstance(file, str):
            result[key] = str(folder / file)
        elif isinstance(file, dict) and isinstance(file.get("value"), str):
            result[key] = {**file, "value": str(folder / file["value"])}
    return result


def _merged_tables(under: Raw, over: Raw, below: str, above: str) -> Raw:
    """Merge the tables that both files have; each value records the file it comes from."""
    result: Raw = {}
    for key in _TABLES:
        if isinstance(under.get(key), dict) and isinstance(over.get(key), dict):
            result[key] = merged(annotated(under[key], key, below), annotated(over[key], key, above))
    for group in _GROUPS:
        if not isinstance(under.get(group), dict):
            continue
        found = dict(under[group])
        for name, table in found.items():
            if isinstance(table, dict):
                found[name] = annotated(table, f"{group}.{name}", below)
        for name, table in over.get(group, {}).items() if isinstance(over.get(group, {}), dict) else ():
            if isinstance(table, dict) and isinstance(found.get(name), dict):
                mine = annotated(table, f"{group}.{name}", above)
                found[name] = layered(found[name], mine)
            else:
                found[name] = table
        result[group] = found
    return {**result, **_merged_spreads(under, over)}


def _merged_spreads(under: Raw, over: Raw) -> Raw:
    """Merge the spreads of both files; drop spreads of values that the upper file replaced.

    A spread that the upper file states anew also drops the correlations of the spread it replaces.
    """
    before, mine, drives = under.get("uncertainty"), over.get("uncertainty", {}), over.get("drives", {})
    if not (isinstance(before, dict) and isinstance(mine, dict) and isinstance(drives, dict)):
        return {}
    after = {
        name: _still_stated(table, drives.get(name)) if isinstance(table, dict) else table
        for name, table in before.items()
    }
    renewed = _spread_paths(mine) | (_spread_paths(before) - _spread_paths(after))
    result: Raw = {"uncertainty": _deep(after, mine)}
    if isinstance(under.get("correlations"), list):
        kept = [row for row in under["correlations"] if not renewed & _correlated_paths(row)]
        added = over.get("correlations", [])
        result["correlations"] = [*kept, *added] if isinstance(added, list) else added
    return result


def _still_stated(under: Raw, over: Any) -> Raw:
    """Drop the spreads of values that a drive's table states in another way."""
    if not isinstance(over, dict):
        return under
    kept = alternatives_over(under, over)
    return {key: _still_stated(one, over.get(key)) if is_group(one) else one for key, one in kept.items()}


def _deep(under: Any, over: Any) -> Any:
    if not (is_group(under) and is_group(over)):
        return over
    return {**under, **{key: _deep(under.get(key), value) for key, value in over.items()}}


def _spread_paths(table: Raw) -> set[str]:
    """Return the dotted paths of all spreads."""
    return {path for path, *_ in leaves(table)}


def _correlated_paths(row: Any) -> set[str]:
    """Return the paths of a correlated pair; empty if the row is malformed, which is reported later."""
    between = row.get("between") if isinstance(row, dict) else None
    return {f"{row.get('drive')}.{path}" for path in between} if isinstance(between, list) else set()
