"""The best motors behind each of many wheel designs.

Behind a given wheel the choice of cylinder motor and gearhead and that of steering motor and ratio are independent: each has its
own power, mass and limits. Lower bounds of the demands leave out candidates that cannot be feasible; the others are evaluated in
the order of a lower bound of the objective until no other can be better.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from infinivar.sizing.cobotic.sampled import Sampled
from infinivar.sizing.geared.tally import SPARE

AT_ONCE = 3
"""Candidates of each wheel design that are evaluated together."""

_LIKELY = 16
"""Candidates of each wheel design, by their bounds, among which the best is nearly always."""


class Behind(NamedTuple):
    """Candidates of one side behind each wheel design, by lower bounds."""

    rows: np.ndarray
    """(p,) int"""
    mass: np.ndarray
    """(p,) [kg]"""
    power: np.ndarray
    """Lower bound of the mean power. (p, k) [W]"""
    worst: np.ndarray
    """Lower bound of the largest demand over allowance. (p, k) [-]"""
    evaluate: Callable[[np.ndarray, np.ndarray], Sampled]
    """Of candidates (m,) behind wheel designs (m,)."""


class Chosen(NamedTuple):
    """Best candidate of one side behind each wheel design. (k,) each"""

    row: np.ndarray
    """-1 where no candidate is feasible. int"""
    value: np.ndarray
    """Of the objective; inf where none is feasible."""
    power: np.ndarray
    """[W]"""
    excess: np.ndarray
    """Largest demand over allowance of the candidate nearest to feasible; 1 where one is feasible. [-]"""
    evaluated: int
    """Candidates evaluated at every instant."""


def together(parts: Sequence[Chosen]) -> Chosen:
    """Choices behind some wheel designs and others, as one."""
    row, value, power, excess = (np.concatenate([one[place] for one in parts]) for place in range(4))
    return Chosen(row, value, power, excess, sum(one.evaluated for one in parts))


def best_behind(behind: Behind, *, by_mass: bool, prune: bool, added: np.ndarray | None = None) -> Chosen:
    """Find the feasible candidate of the least power, or mass, behind each wheel design; of equals the first row.

    Parameters
    ----------
    by_mass : bool          Whether the objective is the mass.
    prune : bool            False: evaluate every candidate.
    added : (p, k) float    Counts with the power of each candidate; inf excludes it. [W]
    """
    rows, worst = behind.rows, behind.worst
    least = np.broadcast_to(behind.mass[:, None], worst.shape) if by_mass else behind.power
    if added is not None:
        least = least + added
    count = least.shape[1]
    # Bounds may exceed the truth by rounding.
    bound = np.where((worst <= 1.0 + SPARE) | (not prune), least * (1.0 - SPARE), np.inf)
    value, power = np.full(count, np.inf), np.full(count, np.nan)
    row, nearest, evaluated = np.full(count, -1), np.full(count, np.inf), 0
    for order in _by_bound(bound):
        bounds = np.take_along_axis(bound, order, axis=0)
        wanted = np.isfinite(bounds) & ((bounds <= value) | (not prune))
        if not wanted.any():
            break
        step, places = np.nonzero(wanted)
        tried = order[step, places]
        done = behind.evaluate(rows[tried], places)
        evaluated += len(tried)
        drawn = done.power if added is None else done.power + added[tried, places]
        aims = np.where(done.feasible, least[tried, places] if by_mass else drawn, np.inf)
        kept = worst[tried, places] <= 1.0 + SPARE
        np.minimum.at(nearest, places[kept], done.worst[kept])
        for ahead in np.unique(step):  # one candidate of each wheel design at a time
            some = step == ahead
            at, row_of = places[some], rows[tried[some]]
            better = (aims[some] < value[at]) | ((aims[some] == value[at]) & done.feasible[some] & (row_of < row[at]))
            value[at[better]], row[at[better]] = aims[some][better], row_of[better]
            power[at[better]] = done.power[some][better]
    left = np.isfinite(bound).any(axis=0) & (worst.min(axis=0) <= 1.0 + SPARE)
    excess = np.where(row >= 0, 1.0, np.where(left, np.maximum(nearest, 1.0), np.maximum(worst.min(axis=0), 1.0)))
    return Chosen(row, value, power, excess, evaluated)


def _by_bound(bound: np.ndarray) -> Iterator[np.ndarray]:
    """Yield candidates of each wheel design in the order of their bounds: one, as it may be enough, then `AT_ONCE`. (m, k)"""
    likely, size = min(len(bound), _LIKELY), 1
    places = np.argpartition(bound, likely - 1, axis=0) if likely else np.empty(bound.shape, dtype=int)
    for part in (places[:likely], places[likely:]):  # the second is rarely asked for, and most of the work to sort
        order = np.take_along_axis(part, np.argsort(np.take_along_axis(bound, part, axis=0), axis=0), axis=0)
        start = 0
        while start < len(order):
            yield order[start : start + size]
            start, size = start + size, AT_ONCE


def towards_lighter(mass: np.ndarray, worst: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """Mass of the lightest feasible candidate, less the part of the way to the next lighter one that a wheel design has come.

    A search by mass alone would see plateaus. The value is between both masses, nearer to the lighter the less its demands exceed
    what is allowed.

    Parameters
    ----------
    mass : (p,) float       Of the candidates. [kg]
    worst : (p, k) float    Lower bound of the largest demand over allowance.
    chosen : (k,) float     Mass of the lightest feasible candidate; inf where none is feasible. [kg]
    """
    lighter = mass[:, None] < chosen
    heaviest = np.max(np.where(lighter, mass[:, None], -np.inf), axis=0)
    next_one = lighter & (mass[:, None] == heaviest)
    near = np.min(np.where(next_one, worst, np.inf), axis=0)
    known = np.isfinite(heaviest) & np.isfinite(chosen)
    gap = np.where(known, np.where(known, chosen, 0.0) - np.where(known, heaviest, 0.0), 0.0)
    return chosen - gap * 0.999 / np.maximum(near, 1.0)
