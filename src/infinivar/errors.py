"""What can go wrong, in the user's terms."""

from __future__ import annotations

from collections.abc import Iterable


class InfinivarError(Exception):
    """Base of every error the package raises on purpose."""


class InputError(InfinivarError):
    """The user's input cannot be used; the message names the place, the value and what would be right."""


class ParameterError(InputError, ValueError):
    """A value is outside its range or does not go with the others; the message names field, value and unit.

    The only ValueError that counts as bad input: any other is a fault of the program.
    """


class AuditError(InfinivarError):
    """Power in, power out and losses do not add up: a fault of the program, never of the input."""


def require(condition: bool, field: str, value: object, wanted: str, unit: str = "") -> None:
    """Raise ParameterError with "field must be wanted unit, got value" unless `condition` holds.

    A nan fails every comparison, so conditions written as `value > 0` refuse it too.
    """
    if not condition:
        raise ParameterError(f"{field} must be {wanted}{' ' + unit if unit else ''}, got {value}")


def nearest(word: str, choices: Iterable[str]) -> str:
    """A hint for a misspelt word: " (did you mean 'x'?)", or "" where nothing is close."""
    import difflib

    close = difflib.get_close_matches(word, list(choices), n=1, cutoff=0.6)
    return f" (did you mean {close[0]!r}?)" if close else ""


def printable(text: object, keep: str = "") -> str:
    """Text, or a path, with control characters spelt out, so that it cannot steer a terminal; those in `keep` stay."""
    return "".join(
        letter if letter.isprintable() or letter in keep else letter.encode("unicode_escape").decode()
        for letter in str(text)
    )
