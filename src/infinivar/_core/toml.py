"""TOML: read from files of unknown origin, and written, the little of it that studies need.

Keys that cost the parser more than they can mean are refused before it sees them. Python reads TOML but does not write it.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from infinivar.errors import InputError

if TYPE_CHECKING:
    from tomlkit import TOMLDocument
    from tomlkit.items import Table

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

_MOST_ROWS = 100
"""Most rows by which a list may grow or shrink row by row, each a pass over it; beyond, it is written anew."""


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
    str   Reads back as the tables. Comments above a heading go with it. Where the text is no TOML, or parts of one table stand
        apart in an order that the library cannot edit, that of `dumps`.
    """
    import tomlkit  # of the extra `web`: needed only where a file is saved over another
    from tomlkit.exceptions import TOMLKitError

    try:
        loads(text)
        document = tomlkit.parse(text)
        above = _above_headings(document)
        _merge(document, tables)
        for table, words in above:
            table.trivia.indent = words
        found = document.as_string()
        return found if loads(found) == tables else dumps(tables)
    except (InputError, TOMLKitError, AttributeError, LookupError, TypeError, ValueError):
        return dumps(tables)


def _above_headings(document: TOMLDocument) -> list[tuple[Table, str]]:
    """Take out what stands above each heading, comments and blank lines, which would else end the table before."""
    from tomlkit.items import Table, Whitespace

    found, free = [], []
    for body, place, item in list(_entries(document.body)):
        if isinstance(item, Table) and item.is_super_table():
            item.trivia.comment_ws = item.trivia.comment = ""  # a heading that it gets has not the words of its child
            continue
        if isinstance(item, Table):
            found.append((item, "".join(one[at][1].as_string() for one, at in free) + item.trivia.indent))
            for one, at in free:
                one[at] = (None, Whitespace(""))
        if body[place][0] is None:
            free.append((body, place))
        else:
            free.clear()
    return found


def _entries(body: list[Any]) -> Iterator[tuple[list[Any], int, Any]]:
    """Yield headings, keys and lines without either in the order of the text, each with its list and its place there."""
    from tomlkit.items import AoT, Table

    for place, (_, item) in enumerate(body):
        if not isinstance(item, Table | AoT):
            yield body, place, item
        for table in item.body if isinstance(item, AoT) else [item] if isinstance(item, Table) else []:
            yield body, place, table
            yield from _entries(table.value.body)


def _merge(held: Any, new: Any) -> None:
    """Give a table or a list of the document the content of another, one entry at a time."""
    import tomlkit

    if isinstance(new, Mapping):
        for key in [key for key in held if key not in new]:
            del held[key]
        places = new
    else:
        both = min(len(held), len(new))
        first = next((place for place in range(both) if held[place] != new[place]), both)
        for _ in range(len(held) - len(new)):
            del held[first]
        for place in range(first, first + len(new) - len(held)):
            held.insert(place, new[place])
        places = range(len(new))
    for key in places:
        old, value = held.get(key) if isinstance(new, Mapping) else held[key], new[key]
        tables = isinstance(old, Mapping) and isinstance(value, Mapping)
        lists = isinstance(old, list) and isinstance(value, list)
        if tables or (lists and abs(len(old) - len(value)) <= _MOST_ROWS):
            _merge(old, value)
        elif old != value or isinstance(old, bool) != isinstance(value, bool):
            held[key] = value if old is None and _stands_alone(value) else tomlkit.value(_value(value, lines=True))
