"""Build frozen parts from study tables, with the provenance of every value."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from infinivar._core.fields import described, hints, in_kinds, part_of
from infinivar.errors import InputError, ParameterError, nearest, printable
from infinivar.study.layers import Raw, over_part
from infinivar.study.messages import StudyError, quoted
from infinivar.study.provenance import DEFAULT, Provenance, recorded
from infinivar.study.schema import (
    CATALOGUES,
    ORIGIN,
    SCALE,
    Entry,
    Key,
    keys,
    kind_keys,
    kinds_for,
    shape_key,
    suggestion,
    table_keys,
)


def built_part(part: type, key: str) -> Any:
    """Build a part from its catalogue entry.

    Raises
    ------
    InputError
        If the catalogue has no such part.
    """
    try:
        return built(part, {"part": key}, CATALOGUES[part], key, [])
    except StudyError as problems:
        raise InputError("\n".join(problems.lines)) from None


def built(part: type, tree: Raw, path: str, owner: str, rows: list[Provenance], beside: Sequence[Path] = ()) -> Any:
    """Build the dataclass that a table describes; append the provenance of its values to `rows`.

    `beside` are the folders and files, other than the user's, in which sets of parts are looked up.
    """
    faults: list[str] = []
    tree = dict(tree)
    made: dict[str, Any] = {}
    for field in in_kinds(part):
        # If its own kind cannot be used, nothing can be said of a table's other keys.
        kinds = _kinds(field, tree, path) if field.metadata["flat"] else {}
        try:
            if field.metadata["flat"]:
                table = {key: tree.pop(key) for key in kind_keys(kinds, field.metadata["key"]) if key in tree}
                made[field.name] = _kind(field, kinds, table, path, owner, "", rows)
            elif field.name in tree:
                table = tree.pop(field.name)
                here = f"{path}.{field.name}"
                made[field.name] = _kind(field, _kinds(field, table, here), table, here, owner, f"{field.name}.", rows)
        except StudyError as found:
            faults += found.lines
    checked = _read(part, tree, path, faults, beside)
    if faults:
        raise StudyError(*faults)
    return _instance(checked, path, owner, "", rows, made)


def _kinds(field: dataclasses.Field, tree: Any, path: str) -> Mapping[str, type]:
    """Kinds of a field, with that of an installed package if its table asks for it."""
    key = field.metadata["key"]
    word = tree.get(key) if isinstance(tree, dict) else None
    try:
        return kinds_for(field, word.get("value") if isinstance(word, dict) else word)
    except InputError as problem:
        raise StudyError(f"{path}.{key}: {problem}") from None


def _kind(
    field: dataclasses.Field,
    kinds: Mapping[str, type],
    tree: Any,
    path: str,
    owner: str,
    prefix: str,
    rows: list[Provenance],
) -> Any:
    """Build the value of a field that comes in kinds; `shape`, or another key, selects the kind, and thus the other keys allowed.

    The provenance of its values is appended to `rows`.

    Raises
    ------
    StudyError
        If a value is wrong, a required key is missing, or a key does not apply to the kind.
    """
    faults: list[str] = []
    if not isinstance(tree, dict) or "value" in tree:
        written = tree["value"] if isinstance(tree, dict) else tree
        raise StudyError(f"{path} = {quoted(written)} must be a table [{path}]")
    key, every = field.metadata["key"], kind_keys(kinds, field.metadata["key"])
    requested = _values({key: shape_key(tuple(kinds), f"infinivar.{field.name}s")}, tree, path, faults)
    if faults:
        raise StudyError(*faults)
    usual = next(iter(kinds))
    if key not in tree and any(name in every and name not in kind_keys({"": kinds[usual]}, key) for name in tree):
        raise StudyError(f"{path}.{key} is missing: must be {' or '.join(kinds)}")
    shape = requested[key].value if requested else usual
    own = table_keys(kinds[shape])
    given = _values(own, tree, path, faults)
    words = [*every, *ORIGIN]
    _refuse_unknown(tree, every, words, lambda name: nearest(name, words), path, faults)
    faults = faults or [*_misfits(tree, kinds[shape], key, shape, path)]
    inner: dict[str, Any] = {}
    inner_rows: list[Provenance] = []
    for one in in_kinds(kinds[shape]):
        if one.name in tree and not faults:
            table, here = tree[one.name], f"{path}.{one.name}"
            try:
                found = _kinds(one, table, here)
                inner[one.name] = _kind(one, found, table, here, owner, f"{prefix}{one.name}.", inner_rows)
            except StudyError as problem:
                faults += problem.lines
    if faults:
        raise StudyError(*faults)
    # Kinds stored in a file are read here, once.
    make = getattr(kinds[shape], "read", kinds[shape])
    units = {one.name: one.metadata.get("unit", "") for one in dataclasses.fields(kinds[shape])}
    said = {key: requested.get(key, Entry(shape, shape, "assumed", DEFAULT)), **given}
    rows += [_row(owner, f"{prefix}{name}", entry, units.get(name, "")) for name, entry in said.items()]
    rows += inner_rows
    return _constructed(make, {**{name: entry.value for name, entry in given.items()}, **inner}, path)


def _misfits(tree: Raw, kind: type, key: str, shape: str, path: str) -> Iterator[str]:
    """Yield one line per required key that is missing, and one per key that does not apply to the kind."""
    own = table_keys(kind)
    tables = {field.name: field for field in in_kinds(kind)}
    for name, one in own.items():
        if one.required and name not in tree:
            yield f"{path}.{name} is missing: {key} = {shape!r} needs it"
    for name, field in tables.items():
        if field.default is dataclasses.MISSING and name not in tree:
            yield f"{path}.{name} is missing: {key} = {shape!r} needs it; write a table [{path}.{name}]"
    for name in tree:
        if name not in own and name not in tables and name != key:
            yield f"{path}.{name} does not apply with {key} = {shape!r}; remove it"


def _values(known: Mapping[str, Key], tree: Raw, path: str, faults: list[str]) -> dict[str, Entry]:
    """Read the entries of a table, by key; append one line to `faults` for each invalid entry."""
    entries: dict[str, Entry] = {}
    for name, key in known.items():
        if key.read is not None and name in tree:
            try:
                entries[name] = key.read(tree[name])
            except ValueError as problem:
                faults.append(f"{path}.{name}{_shown(tree[name])} {problem}")
    return entries


def _refuse_unknown(
    tree: Raw, known: Container[str], words: list[str], hint: Callable[[str], str], path: str, faults: list[str]
) -> None:
    """Append one line to `faults` for each unknown key of a table, with a hint; `words` are the keys it may have."""
    for name, raw in tree.items():
        if name not in known:
            end = f"is not a known key{hint(name)}; known keys: {', '.join(words)}"
            faults.append(f"{path}.{printable(name)}{_shown(raw)} {end}")


class _Checked(NamedTuple):
    """A valid table: the part that it describes, an entry for each value, and the tables of the parts within."""

    part: type
    entries: Mapping[str, Entry]
    within: Mapping[str, _Checked]


def _read(part: type, tree: Raw, path: str, faults: list[str], beside: Sequence[Path]) -> _Checked:
    """Read a table over the catalogue parts that it names; append one line per fault to `faults`."""
    part, tree = over_part(part, tree, path, beside)
    known = table_keys(part)
    entries = _values(known, tree, path, faults)
    within: dict[str, _Checked] = {}
    for name, key in known.items():
        here = f"{path}.{name}"
        if name not in tree:
            if key.required:
                hint = f"; write a table [{here}]" if key.part is not None else ""
                faults.append(f"{here} is missing ({key.meaning}){hint}")
        elif key.part is not None:
            within[name] = _read(key.part, tree[name], here, faults, beside)
    _refuse_unknown(tree, known, keys(part), lambda name: suggestion(name, [part]), path, faults)
    _check_alternatives(part, tree, path, faults)
    return _Checked(part, entries, within)


def _check_alternatives(part: type, tree: Raw, path: str, faults: list[str]) -> None:
    """Append a line to `faults` unless the table has exactly one of the tables of which the part needs one."""
    names = getattr(part, "one_of", ())
    written = [name for name in names if name in tree]
    if names and not written:
        tables = ", ".join(f"[{path}.{name}]" for name in names)
        faults.append(f"{path} needs one of {', '.join(names)}; write one of the tables {tables}")
    words = f"beside {written[0]}: a drive has one of {', '.join(names)}; remove it" if written else ""
    faults.extend(f"{path}.{name} does not apply {words}" for name in written[1:])


def _shown(raw: Any) -> str:
    return f" = {quoted(raw['value'])}" if isinstance(raw, dict) and "value" in raw else ""


def _constructed(make: Callable[..., Any], values: Mapping[str, Any], path: str) -> Any:
    """Construct a class from its values; prefix its error messages with the path of the table."""
    try:
        return make(**values)
    except ParameterError as problem:
        raise StudyError(f"{path}.{problem}") from None
    except InputError as problem:
        raise StudyError(f"{path}: {problem}") from None


def _instance(
    checked: _Checked,
    path: str,
    owner: str,
    prefix: str,
    rows: list[Provenance],
    made: Mapping[str, Any] | None = None,
) -> Any:
    """Build a dataclass instance from a validated table, its parts first; `made` holds values already built."""
    part, entries, within = checked
    inner = {field.name: part_of(hints(part)[field.name]) for field in described(part)}
    values = {**(made or {}), **{name: entry.value for name, entry in entries.items() if name in inner}}
    faults: list[str] = []
    for field in described(part):
        kind, name = inner[field.name], field.name
        if kind is not None and (name in within or field.default_factory is not dataclasses.MISSING):
            table = within.get(name, _Checked(kind, {}, {}))
            try:
                values[name] = _instance(table, f"{path}.{name}", owner, f"{prefix}{name}.", rows)
            except StudyError as found:
                faults += found.lines
    if faults:
        raise StudyError(*faults)
    instance = _constructed(part, values, path)
    for field in described(part):
        entry, value = entries.get(field.name), getattr(instance, field.name)
        if entry is None and value is not None and inner[field.name] is None and field.name != "name":
            # By default, or chosen by the part by its other values.
            entry = Entry(value, recorded(value), "assumed", DEFAULT)
        if entry is not None:
            rows.append(_row(owner, f"{prefix}{field.name}", entry, field.metadata.get("unit", "")))
    scale = None if SCALE.name in inner else entries.get(SCALE.name)
    if scale is None:
        return instance
    rows.append(_row(owner, f"{prefix}{SCALE.name}", scale, SCALE.metadata["unit"]))
    return instance.scaled(scale.value)


def _row(owner: str, field: str, entry: Entry, unit: str) -> Provenance:
    return Provenance(
        owner=owner,
        field=field,
        written=str(entry.written),
        value=recorded(entry.value),
        unit=unit,
        kind=entry.kind or "assumed",
        where=entry.where or "",
    )
