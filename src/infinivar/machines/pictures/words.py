"""Quantities in words, as figures, pages and rows beside them have them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from infinivar.units import plain


def quantity(value: Any, unit: str, digits: int = 3) -> str:
    """A value with its unit, "–" where it is undefined."""
    found = float(value)
    if not math.isfinite(found):
        return "–"
    return f"{plain(found, digits)}{'' if unit in ('', '°') else ' '}{unit}"


def length(vector: Any, unit: str) -> str:
    """The length of a vector."""
    return quantity(np.linalg.norm(np.asarray(vector, dtype=float)), unit)


def share_of_slip(demand: float) -> str:
    """A demand on friction over its allowance."""
    return f"{100.0 * demand:.0f} % of slip limit"


def slip_rows(names: Iterable[str], forces: Any, demands: Any) -> Iterator[tuple[str, str]]:
    """Yield the force (d,) of each wheel and its share of the slip limit."""
    for name, force, demand in zip(names, forces, demands, strict=True):
        yield name, f"{length(force, 'N')}, {quantity(100.0 * demand, '%', 2)} of its slip limit"


def part_rows(point: Any) -> Iterator[tuple[str, str]]:
    """Yield each part of a `infinivar.machines.machine.TaskPoint` with its force, and steering angle if it has one."""
    for name, force, steering in zip(point.parts, point.part_forces, point.steering, strict=True):
        angle = "" if math.isnan(steering) else f", steered {quantity(math.degrees(steering), '°')}"
        yield name, f"{quantity(force, point.part_units[0])}{angle}"
