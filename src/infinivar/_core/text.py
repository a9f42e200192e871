"""Words in messages and reports: rows of words, and counts of things."""

from __future__ import annotations

from collections.abc import Sequence


def joined(words: Sequence[str], last: str = "and") -> str:
    """One or more words as a row: "a", "a and b", "a, b and c"."""
    return f"{', '.join(words[:-1])} {last} {words[-1]}" if len(words) > 1 else words[0]


def few(words: Sequence[str], most: int, between: str = ", ") -> str:
    """The first words of many: "a, b and 3 more"; all of them, without "and", up to `most`."""
    more = len(words) - most
    return between.join(words[:most]) + (f" and {more} more" if more > 0 else "")


def counted(count: int, what: str) -> str:
    """A number of things in words: "1 motor", "1,897 gearheads", "2 compatible pairs"."""
    return f"{count:,} {what.removesuffix('s') if count == 1 else what}"
