"""Variables of a plant, and their names."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator
from typing import Literal, NamedTuple

from infinivar.limits import Limit

Role = Literal["time", "state", "derivative", "input", "command", "rate", "output", "parameter", "goal"]

MOST_LETTERS = 64
"""In a name: longer ones are cut, as some importers refuse them."""


class Variable(NamedTuple):
    """One number of a plant.

    `start` is None where it is computed. `fixed`: a parameter that decides tables, which are data of the export. `least`, `most`:
    what it may be, both included.
    """

    name: str
    role: Role
    unit: str
    description: str
    start: float | None = None
    fixed: bool = False
    least: float = -math.inf
    most: float = math.inf


def rate_of(one: Variable, name: str, role: Role, start: float | None) -> Variable:
    """Time derivative of a variable."""
    unit = {"m/s": "m/s^2", "rad/s": "rad/s^2"}.get(one.unit, f"{one.unit}/s" if one.unit else "")
    return Variable(name, role, unit, f"time derivative of {one.name}", start)


def demand_of(limit: Limit, part: str) -> Variable:
    """The demand on a limit of a part."""
    said = f"demand over allowance, 1 at the limit: {limit.words} ({part})"
    return Variable(f"demand.{limit.name}.{letters(part)}", "output", "1", said)


def letters(text: str) -> str:
    """A text in letters, digits and underscores."""
    return re.sub(r"[\W_]+", "_", text).strip("_")


def distinct(rows: Iterable[Variable]) -> Iterator[Variable]:
    """Yield variables with names of bounded length; of two of one name the second has a number."""
    known: set[str] = set()
    for one in rows:
        names = (one.name[:MOST_LETTERS], *(f"{one.name[: MOST_LETTERS - 4]}_{count}" for count in range(2, 1000)))
        name = next(name for name in names if name not in known)
        known.add(name)
        yield one._replace(name=name)
