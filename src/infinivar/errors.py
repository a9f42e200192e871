"""What can go wrong, in the user's terms."""

from __future__ import annotations

from collections.abc import Iterable


class InfinivarError(Exception):
    """Base of every error the package raises on purpose."""


class InputError(InfinivarError):
    """The user's input cannot be used; the message names the place, the value and what would be right."""


class AuditError(InfinivarError):
    """Power in, power out and losses do not add up: a fault of the program, never of the input."""


def require(condition: bool, field: str, value: object, wanted: str, unit: str = "") -> None:
    """Raise ValueError with "field must be wanted unit, got value" unless `condition` holds.

    A nan fails every comparison, so conditions written as `value > 0` refuse it too.
    """
    if not condition:
        raise ValueError(f"{field} must be {wanted}{' ' + unit if unit else ''}, got {value}")


def nearest(word: str, choices: Iterable[str]) -> str:
    """A hint for a misspelt word: " (did you mean 'x'?)", or "" where nothing is close."""
    import difflib

    close = difflib.get_close_matches(word, list(choices), n=1, cutoff=0.6)
    return f" (did you mean {close[0]!r}?)" if close else ""
