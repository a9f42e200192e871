"""TOML: read from files of unknown origin, and written, the little of it that studies need.

Keys that cost the parser more than they can mean are refused before it sees them. Python reads TOML but does not write it.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from infinivar.errors import InputError

_DEEPEST = 64
"""Most parts of one dotted key, and most brackets open at once; a study needs six."""

_LONGEST = 256
"""Most characters of one part of a key."""

_TOKEN = re.compile(
    r"""
      (?P<text>\"{3}(?:[^\\]|\\.)*?(?:\"{3,5}|\Z) | '{3}.*?(?:'{3,5}|\Z))
    | (?P<part>"(?:[^"\\\n]|\\.)*" | '[^'\n]*' | [A-Za-z0-9_-]+)
    | (?P<dot>[ \t]*\.[ \t]*)
    | (?P<opens>[\[{]) | (?P<closes>[\]}])
    | (?P<rest>\#[^\n]* | [ \t]+ | .)
    """,
    re.VERBOSE | re.DOTALL,
)

_BARE = re.compile(r"[A-Za-z0-9_-]+")
_ESCAPES = {"\\": "\\\\", '"': '\\"', "\b": "\\b", "\t": "\\t", "\n": "\\n", "\f": "\\f", "\r": "\\r"}
_CONTROL = re.compile(r'[\\"\x00-\x1f\x7f]')
_WIDTH = 120


def loads(text: str) -> dict[str, Any]:
    """Tables of a TOML text.

    Parameters
    ----------
    text : str   Of any origin.

    Returns
    -------
    dict   As `tomllib.loads` gives it.

    Raises
    ------
    InputError
        If it is not TOML, or a key has more parts, or brackets are nested deeper, than any study needs: the parser of
        Python's library keeps every beginning of a dotted key, 5 GB for one of 30,000 parts.
    """
    if problem := _too_much(text):
        raise InputError(problem)
    try:
        tables = tomllib.loads(text)
    except RecursionError as problem:
        raise InputError("is nested too deeply") from problem
    except ValueError as problem:  # TOMLDecodeError, or a number with thousands of digits
        raise InputError(f"is not valid TOML: {str(problem).partition(';')[0]}") from problem
    for key in _keys(tables):
        if len(key) > _LONGEST:
            raise InputError(f"has a key of {len(key)} characters, which begins with {key[:40]!r}; at most {_LONGEST}")
    return tables


def _keys(value: Any) -> Iterator[str]:
    """Yield every part of every key."""
    if isinstance(value, dict):
        yield from value
    for one in value.values() if isinstance(value, dict) else value:
        if isinstance(one, dict | list):
            yield from _keys(one)


def _too_much(text: str) -> str | None:
    """What is refused of a text, with its line; None for nothing."""
    brackets = text.count("[") + text.count("{")
    if brackets <= _DEEPEST and all(line.count(".") < _DEEPEST for line in text.splitlines()):
        return None  # nothing can be too long or too deep, as in nearly every file
    parts = depth = 0
    for found in _TOKEN.finditer(text):
        kind = found.lastgroup
        if kind == "part":
            parts += 1
        elif kind != "dot":
            parts = 0
            depth = max(depth + (kind == "opens") - (kind == "closes"), 0)
        if parts > _DEEPEST or depth > _DEEPEST:
            line = text.count("\n", 0, found.start()) + 1
            what = f"has a key of more than {_DEEPEST} parts" if parts > _DEEPEST else "is nested too deeply"
            return f"{what} (at line {line})"
    return None


class Inline(dict[str, Any]):
    """A table to be written on one line, such as a value with its source."""


def dumps(tables: Mapping[str, Any]) -> str:
    """Text of a TOML file.

    Parameters
    ----------
    tables : mapping   Text, numbers, lists, and tables of the same by name; a list of `dict` becomes an array of tables.

    Returns
    -------
    str   Python's `tomllib` reads it back as the same tables.
    """
    return "\n".join(_lines(tables, ())).strip("\n") + "\n"


def _lines(table: Mapping[str, Any], path: tuple[str, ...]) -> Iterator[str]:
    inner = {key: value for key, value in table.items() if _stands_alone(value)}
    own = {key: value for key, value in table.items() if key not in inner}
    if path and (own or not inner):
        yield ""
        yield f"[{'.'.join(map(_key, path))}]"
    for key, value in own.items():
        yield f"{_key(key)} = {_value(value, lines=True)}"
    for key, value in inner.items():
        if isinstance(value, Mapping):
            yield from _lines(value, (*path, key))
            continue
        for row in value:
            yield ""
            yield f"[[{'.'.join(map(_key, (*path, key)))}]]"
            yield from (f"{_key(name)} = {_value(one)}" for name, one in row.items())


def _stands_alone(value: Any) -> bool:
    """Whether a value has a heading of its own."""
    if isinstance(value, list):
        return bool(value) and all(isinstance(one, dict) and not isinstance(one, Inline) for one in value)
    return isinstance(value, Mapping) and not isinstance(value, Inline)


def _key(key: str) -> str:
    return key if _BARE.fullmatch(key) else _text(key)


def _value(value: Any, *, lines: bool = False) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, float):
        return repr(value)
    if isinstance(value, int):
        return str(value)
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_key(key)} = {_value(one)}" for key, one in value.items()) + " }" if value else "{}"
    if isinstance(value, Sequence):
        return _list([_value(one) for one in value], lines)
    raise TypeError(f"TOML has no {type(value).__name__}")


def _list(items: list[str], lines: bool) -> str:
    flat = f"[{', '.join(items)}]"
    return flat if len(flat) <= _WIDTH or not lines else "\n".join(["[", *(f"    {one}," for one in items), "]"])


def _text(text: str) -> str:
    """A text in quotes; anything that could end it or is invisible is escaped."""
    return '"' + _CONTROL.sub(lambda found: _ESCAPES.get(found[0], f"\\u{ord(found[0]):04x}"), text) + '"'


def edited(text: str, tables: Mapping[str, Any]) -> str:
    """The text of a TOML file with other tables: what is the same stays as it stands, with comments, order and layout.

    Parameters
    ----------
    text : str         Of the file as it was, of any origin.
    tables : mapping   As for `dumps`.

    Returns
    -------
    str   Reads back as the tables. Changed values stand in their lines, new ones at the end of their table. Where that cannot be,
        as in arrays of tables with other rows, or where the text is no TOML, that of `dumps`.
    """
    try:
        loads(text)
        found = "".join(_edited(text, tables)).strip("\n") + "\n"
        return found if loads(found) == tables else dumps(tables)
    except (InputError, LookupError, TypeError, ValueError):
        return dumps(tables)


def _edited(text: str, tables: Mapping[str, Any]) -> Iterator[str]:
    """Yield the statements of a text, each with the value that the tables have."""
    seen: set[tuple[Any, ...]] = set()
    at: tuple[Any, ...] = ()
    blank: list[str] = []  # comments and blank lines go with the statement that follows them
    rows: dict[tuple[Any, ...], int] = {}
    for statement in _statements(text):
        bare = statement.strip()
        if not bare or bare.startswith("#"):
            blank.append(statement)
            continue
        if bare.startswith("["):
            yield from _added(tables, at, seen)
            at = _path(bare)
            if bare.startswith("[["):
                rows[at] = rows.get(at, -1) + 1
                at = (*at, rows[at])
            gone = _at(tables, at) is None
            yield from [*blank, *([] if gone else [statement])]
        else:
            key, value, comment = _split(bare)
            path = (*at, *_path(f"[{key}]"))
            new = _at(tables, path)
            seen.add(path)
            if new is not None and _value(new) == _value(value):
                yield from [*blank, statement]
            elif new is not None:
                yield from [*blank, f"{key} = {_value(new, lines=True)}{comment and '  '}{comment}\n"]
        blank = []
    yield from _added(tables, at, seen)
    yield from blank
    yield from (f"{line}\n" for line in _lines(_unseen(tables, (), seen), ()))


def _statements(text: str) -> Iterator[str]:
    """Yield headings, keys with their values, which may span lines, and lines with neither."""
    held = ""
    for line in text.splitlines(keepends=True):
        inside = bool(held)
        held += line
        if inside and line.rstrip().endswith(","):  # a list of thousands of lines is read once
            continue
        try:
            tomllib.loads(held)
        except tomllib.TOMLDecodeError:
            continue
        yield held if held.endswith("\n") else f"{held}\n"
        held = ""


def _path(heading: str) -> tuple[str, ...]:
    """The keys of a heading."""
    path, inside = [], tomllib.loads(heading)
    while isinstance(inside, dict) and inside:
        ((key, inside),) = inside.items()
        path.append(key)
    return tuple(path)


def _split(statement: str) -> tuple[str, Any, str]:
    """Key as written, value, and comment behind it."""
    for sign in re.finditer("=", statement):
        key = statement[: sign.start()].strip()
        try:
            path = _path(f"[{key}]")
        except tomllib.TOMLDecodeError:  # the sign is within a quoted key
            continue
        value = _at(tomllib.loads(statement), path)
        for mark in re.finditer("#", statement):
            try:
                if _at(tomllib.loads(statement[: mark.start()]), path) == value:
                    return key, value, statement[mark.start() :]
            except tomllib.TOMLDecodeError:  # the mark is within the value
                continue
        return key, value, ""
    raise ValueError(f"no key in {statement!r}")


def _at(tables: Any, path: Sequence[Any]) -> Any:
    """The value at a path of keys and places; None if there is none."""
    for key in path:
        inside = isinstance(tables, Mapping) and key in tables
        inside |= isinstance(tables, list) and isinstance(key, int) and key < len(tables)
        if not inside:
            return None
        tables = tables[key]
    return tables


def _added(tables: Any, at: tuple[Any, ...], seen: set[tuple[Any, ...]]) -> Iterator[str]:
    """Yield what a table of the text lacks, without tables of their own, and note it as seen."""
    table = _at(tables, at)
    for key, value in table.items() if isinstance(table, Mapping) else ():
        path = (*at, key)
        if not _stands_alone(value) and not any(one[: len(path)] == path for one in seen):
            seen.add(path)
            yield f"{_key(key)} = {_value(value, lines=True)}\n"


def _unseen(table: Mapping[str, Any], at: tuple[Any, ...], seen: set[tuple[Any, ...]]) -> dict[str, Any]:
    """What of the tables the text lacks."""
    found = {}
    for key, value in table.items():
        path = (*at, key)
        if path in seen:
            continue
        if isinstance(value, Mapping):
            if inner := _unseen(value, path, seen):
                found[key] = inner
        elif not any(one[: len(path)] == path for one in seen):
            found[key] = value
    return found
