"""Read TOML of unknown origin: keys that cost the parser more than they can mean are refused before it sees them."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
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
