"""Fault messages of study files: one short line each, with field, value and what would be right."""

from __future__ import annotations

from typing import Any

from infinivar.errors import printable


class StudyError(Exception):
    """Faults found in a study, each of the form "field = value must be ..."; the caller adds the file."""

    @property
    def lines(self) -> tuple[str, ...]:
        """The faults, one line each."""
        return self.args


def quoted(value: Any) -> str:
    """Show a value roughly as written in the file, on one short line."""
    if isinstance(value, str):
        return short(f'"{printable(value)}"')
    if isinstance(value, int) and not isinstance(value, bool) and abs(value) >= 10**60:
        return "an integer of more than 60 digits" if abs(value) >= 10**4000 else short(str(value))
    return short(printable(str(value).lower() if isinstance(value, bool) else str(value)))


def short(text: str) -> str:
    """Cut long text in the middle."""
    return text if len(text) <= 80 else f"{text[:60]} ... {text[-15:]}"
