"""Write nested tables as TOML: the little of it that a study needs, as Python reads TOML but does not write it."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

_BARE = re.compile(r"[A-Za-z0-9_-]+")
_ESCAPES = {"\\": "\\\\", '"': '\\"', "\b": "\\b", "\t": "\\t", "\n": "\\n", "\f": "\\f", "\r": "\\r"}
_CONTROL = re.compile(r'[\\"\x00-\x1f\x7f]')
_WIDTH = 120


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
