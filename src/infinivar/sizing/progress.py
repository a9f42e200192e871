"""How far a search is."""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[str, float], None]
"""Takes words on the best so far and the share of work done, 0 to 1."""


def part_of(progress: Progress | None, begin: float, end: float, lead: str = "") -> Progress | None:
    """A progress of a part of the work, with words before those on the best so far."""
    if progress is None:
        return None
    return lambda said, share: progress(f"{lead}{said}", begin + share * (end - begin))
