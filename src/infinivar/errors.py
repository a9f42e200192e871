"""Exceptions of the package, and helpers for their messages."""

from __future__ import annotations

from collections.abc import Iterable
from os import PathLike
from pathlib import Path


class InfinivarError(Exception):
    """Base of every error the package raises on purpose."""


class InputError(InfinivarError):
    """The user's input is invalid; the message names the place, the value and what is accepted."""


class ParameterError(InputError, ValueError):
    """A value is out of range or conflicts with other values; the message names field, value and unit.

    The only ValueError that counts as invalid input: any other is a bug in the program.
    """


class AuditError(InfinivarError):
    """Power in, power out and losses do not balance: a bug in the program, never invalid input."""


def require(condition: bool, field: str, value: object, required: str, unit: str = "") -> None:
    """Raise ParameterError with "field must be required unit, got value" unless `condition` holds.

    A nan fails every comparison, so a condition such as `value > 0` rejects nan as well.
    """
    if not condition:
        raise ParameterError(f"{field} must be {required}{' ' + unit if unit else ''}, got {value}")


def path_of(value: object, what: str) -> Path:
    """A path as a Path; ParameterError if it is something else."""
    require(isinstance(value, str | PathLike), what, f"a {type(value).__name__}", "the path of a file or folder")
    return Path(value)  # type: ignore[arg-type]


def nearest(word: str, choices: Iterable[str]) -> str:
    """Hint for a misspelt word: " (did you mean 'x'?)", or "" if no choice is close."""
    import difflib

    close = difflib.get_close_matches(word, list(choices), n=1, cutoff=0.6)
    return f" (did you mean {close[0]!r}?)" if close else ""


def printable(text: object, keep: str = "") -> str:
    """Escape the control characters of a text or path, except those in `keep`, so that it cannot control a terminal."""
    return "".join(
        letter if letter.isprintable() or letter in keep else letter.encode("unicode_escape").decode()
        for letter in str(text)
    )
