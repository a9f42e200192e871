"""Words in messages and reports: rows of words, counts of things, and tables for a terminal."""

from __future__ import annotations

import itertools
import re
from collections.abc import Container, Sequence

WIDTH = 98
"""Columns of a terminal that tables fill, below a heading from which they are indented."""
_GAP = "  "


def joined(words: Sequence[str], last: str = "and") -> str:
    """One or more words as a row: "a", "a and b", "a, b and c"."""
    return f"{', '.join(words[:-1])} {last} {words[-1]}" if len(words) > 1 else words[0]


def capitalise(text: str) -> str:
    """Text with its first letter in upper case and the others as they are, unlike `str.capitalize` and the filter of Jinja."""
    return text[:1].upper() + text[1:]


def few(words: Sequence[str], most: int, between: str = ", ") -> str:
    """The first words of many: "a, b and 3 more"; all of them, without "and", up to `most`."""
    more = len(words) - most
    return between.join(words[:most]) + (f" and {more} more" if more > 0 else "")


def counted(count: int, what: str) -> str:
    """A number of things in words: "1 motor", "1,897 gearheads", "2 compatible pairs"."""
    return f"{count:,} {what.removesuffix('s') if count == 1 else what}"


_BREAKS = re.compile(r"[^\s-]*(?:-|\s+|$)")
"""Pieces of a cell that lines may end with."""


def aligned(table: Sequence[Sequence[str]], whole: Container[int] = ()) -> list[str]:
    """Lines of a table, whose first row are the heads of its columns.

    Where it would be wider than `WIDTH`, the widest cells are wrapped between words and behind hyphens; below the heads, those
    of the columns `whole` stay in one line.
    """
    pieces = [
        [[cell] if row and place in whole else _BREAKS.findall(cell) for place, cell in enumerate(cells)]
        for row, cells in enumerate(table)
    ]
    columns = list(zip(*pieces, strict=True))
    widths = [max(len("".join(cell)) for cell in column) for column in columns]
    least = [max(len(piece.rstrip()) for cell in column for piece in cell) for column in columns]
    gap = _GAP if sum(least) + len(_GAP) * (len(least) - 1) <= WIDTH else " "
    while sum(widths) + len(gap) * (len(widths) - 1) > WIDTH and widths != least:
        place = max(range(len(widths)), key=lambda one: (widths[one] > least[one], widths[one]))
        widths[place] -= 1
    lines = []
    for row in pieces:
        cells = [_wrapped(cell, width) for cell, width in zip(row, widths, strict=True)]
        lines += [
            gap.join(f"{part:<{width}}" for part, width in zip(parts, widths, strict=True)).rstrip()
            for parts in itertools.zip_longest(*cells, fillvalue="")
        ]
    return lines


def _wrapped(pieces: list[str], width: int) -> list[str]:
    lines = [""]
    for piece in pieces:
        if len((lines[-1] + piece).rstrip()) > width:
            lines.append("")
        lines[-1] += piece
    return [line.rstrip() for line in lines]
