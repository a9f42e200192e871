"""The best motors behind each of many wheel designs.

Behind a given wheel the choice of cylinder motor and gearhead and that of steering motor and ratio are independent: each has its
own power, mass and limits. Lower bounds of the demands leave out candidates that cannot be feasible; the others are evaluated in
the order of a lower bound of the objective until no other can be better.

The least power of both motors together that a total mass permits follows from the same bounds.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from infinivar.sizing.cobotic.sampled import SideSampled
from infinivar.sizing.geared.tally import SPARE

NOT_CHOSEN = -1
"""Row where no candidate is feasible."""

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
    evaluate: Callable[[np.ndarray, np.ndarray], SideSampled]
    """Of candidates (m,) behind wheel designs (m,)."""


class ChosenMotors(NamedTuple):
    """Best candidate of one side behind each wheel design. (k,) each"""

    row: np.ndarray
    """`NOT_CHOSEN` where no candidate is feasible. int"""
    value: np.ndarray
    """Of the objective; inf where none is feasible."""
    power: np.ndarray
    """[W]"""
    excess: np.ndarray
    """Largest demand over allowance of the candidate nearest to feasible; 1 where one is feasible. [-]"""
    evaluated: int
    """Candidates evaluated at every instant."""


def together(parts: Sequence[ChosenMotors]) -> ChosenMotors:
    """Choices behind some wheel designs and others, as one."""
    row, value, power, excess = (np.concatenate([one[place] for one in parts]) for place in range(4))
    return ChosenMotors(row, value, power, excess, sum(one.evaluated for one in parts))


def best_behind(behind: Behind, *, by_mass: bool, prune: bool, added: np.ndarray | None = None) -> ChosenMotors:
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
    row, nearest, evaluated = np.full(count, NOT_CHOSEN), np.full(count, np.inf), 0
    for order in _by_bound(bound):
        bounds = np.take_along_axis(bound, order, axis=0)
        required = np.isfinite(bounds) & ((bounds <= value) | (not prune))
        if not required.any():
            break
        step, places = np.nonzero(required)
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
    excess = np.where(
        row != NOT_CHOSEN, 1.0, np.where(left, np.maximum(nearest, 1.0), np.maximum(worst.min(axis=0), 1.0))
    )
    return ChosenMotors(row, value, power, excess, evaluated)


def _by_bound(bound: np.ndarray) -> Iterator[np.ndarray]:
    """Yield candidates of each wheel design in the order of their bounds: one, as it may be enough, then `AT_ONCE`. (m, k)"""
    likely, size = min(len(bound), _LIKELY), 1
    places = np.argpartition(bound, likely - 1, axis=0) if likely else np.empty(bound.shape, dtype=int)
    for part in (places[:likely], places[likely:]):  # the second is rarely needed, and most of the work to sort
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


class Both(NamedTuple):
    """Best candidates of both sides behind each wheel design. (k,) each"""

    cylinder: np.ndarray
    """Row of the pair of cylinder motor and gearhead; `NOT_CHOSEN` where nothing is feasible."""
    steering: np.ndarray
    """Row of the pair of steering motor and ratio; `NOT_CHOSEN` where nothing is feasible."""
    power: np.ndarray
    """Of both; inf where nothing is feasible. [W]"""
    mass: np.ndarray
    """Of both; nan where nothing is feasible. [kg]"""
    excess: np.ndarray
    """Largest demand over allowance of what is nearest to feasible; 1 where something is. [-]"""
    evaluated: int
    """Candidates evaluated at every instant."""


class _ByMass(NamedTuple):
    """Least power of a side by the mass it may have. (p, k)"""

    mass: np.ndarray
    """In rising order. (p,) [kg]"""
    power: np.ndarray
    """Of the best candidate that is not heavier; inf where none is feasible. [W]"""
    place: np.ndarray
    """Of that candidate among those given, `NOT_CHOSEN` where none is feasible. int"""
    worst: np.ndarray
    """Largest demand over allowance of each candidate, or a lower bound of it. [-]"""
    excess: np.ndarray
    """Largest demand over allowance of the candidate nearest to feasible; 1 where one is feasible. (k,) [-]"""
    evaluated: int


def least_power(cylinder: Behind, steering: Behind, heaviest: np.ndarray, *, prune: bool) -> Both:
    """Find both motors of the least power whose masses together are at most `heaviest` behind each wheel design. (k,) [kg]"""
    count = cylinder.worst.shape[1]
    heaviest = np.broadcast_to(heaviest, (count,))
    most = float(np.max(heaviest, initial=0.0))
    turning = _up_to(cylinder, most - steering.mass.min(initial=np.inf))
    steered = _up_to(steering, most - cylinder.mass.min(initial=np.inf))
    if not (len(turning.rows) and len(steered.rows)):
        none, unknown = np.full(count, NOT_CHOSEN), np.full(count, np.nan)
        return Both(none, none, np.full(count, np.inf), unknown, np.full(count, np.inf), 0)
    known = _by_mass(steered, prune=prune)
    designs = np.arange(count)
    # Place of the heaviest steering motor that a cylinder motor leaves room for; -1: none. (p, k)
    room = np.searchsorted(known.mass, heaviest - turning.mass[:, None], side="right") - 1
    added = np.where(room >= 0, known.power[room, designs], np.inf)
    chosen = best_behind(turning, by_mass=False, prune=prune, added=added)
    feasible = chosen.row != NOT_CHOSEN
    first = np.searchsorted(turning.rows, np.where(feasible, chosen.row, turning.rows[0]))
    second = known.place[room[first, designs], designs]
    # Each side alone may be feasible, and both together too heavy.
    over = _lightest(turning.mass, turning.worst) + _lightest(known.mass, known.worst)
    lacking = np.maximum(np.maximum(chosen.excess, known.excess), over / np.maximum(heaviest, 1e-3 * over))
    return Both(
        cylinder=chosen.row,
        steering=np.where(feasible, steered.rows[second], NOT_CHOSEN),
        power=chosen.value,
        mass=np.where(feasible, turning.mass[first] + steered.mass[second], np.nan),
        excess=np.where(feasible, 1.0, lacking),
        evaluated=chosen.evaluated + known.evaluated,
    )


def _up_to(behind: Behind, heaviest: float) -> Behind:
    """The candidates of at most a mass."""
    kept = behind.mass <= heaviest
    return behind._replace(
        rows=behind.rows[kept], mass=behind.mass[kept], power=behind.power[kept], worst=behind.worst[kept]
    )


def _lightest(mass: np.ndarray, worst: np.ndarray) -> np.ndarray:
    """Least mass of the candidates that may be feasible; the largest mass where none may. (k,) [kg]"""
    return np.min(np.where(worst <= 1.0 + SPARE, mass[:, None], mass.max()), axis=0)


def _by_mass(behind: Behind, *, prune: bool) -> _ByMass:
    """Evaluate every candidate that may draw less than all that are not heavier."""
    order = np.argsort(behind.mass, kind="stable")
    bound = np.where((behind.worst <= 1.0 + SPARE) | (not prune), behind.power * (1.0 - SPARE), np.inf)[order]
    shape = bound.shape
    power, worst = np.full(shape, np.inf), behind.worst[order]
    best, open_to, evaluated = np.full(shape[1], np.inf), np.isfinite(bound), 0
    while True:
        required = open_to & ((bound < best) | (not prune))
        required &= np.cumsum(required, axis=0) <= AT_ONCE
        if not required.any():
            break
        tried, places = np.nonzero(required)
        done = behind.evaluate(behind.rows[order[tried]], places)
        evaluated += len(tried)
        power[tried, places] = np.where(done.feasible, done.power, np.inf)
        worst[tried, places] = np.where(done.feasible, np.minimum(done.worst, 1.0), np.maximum(done.worst, 1.0 + SPARE))
        best = power.min(axis=0)
        last = np.where(required.any(axis=0), shape[0] - 1 - np.argmax(required[::-1], axis=0), -1)
        open_to &= np.arange(shape[0])[:, None] > last
    least = np.minimum.accumulate(power, axis=0)
    improved = np.where((power == least) & np.isfinite(power), np.arange(shape[0])[:, None], NOT_CHOSEN)
    place = np.maximum.accumulate(improved, axis=0)
    return _ByMass(
        mass=behind.mass[order],
        power=least,
        place=np.where(place != NOT_CHOSEN, order[place], NOT_CHOSEN),
        worst=worst,
        excess=np.maximum(worst.min(axis=0), 1.0),
        evaluated=evaluated,
    )
