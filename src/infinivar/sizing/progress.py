"""How far a search is."""

from __future__ import annotations

import math
from collections.abc import Callable

Progress = Callable[[str, float], None]
"""Takes words on the best so far and the share of work done, 0 to 1."""


def part_of(progress: Progress | None, begin: float, end: float, lead: str = "") -> Progress | None:
    """A progress of a part of the work, with words before those on the best so far."""
    if progress is None:
        return None
    return lambda said, share: progress(f"{lead}{said}", begin + share * (end - begin))


def best_so_far(power: float, mass: float) -> str:
    """Words on the best design that a search has found until now."""
    said = [f"{value:.3g} {unit}" for value, unit in ((power, "W"), (mass, "kg")) if math.isfinite(value)]
    return f"best: {', '.join(said)}" if said else "no feasible design yet"
