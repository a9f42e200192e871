"""The least power of both motors together that a total mass permits, behind each of many wheel designs."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from infinivar.sizing.cobotic.choice import AT_ONCE, Behind, best_behind
from infinivar.sizing.geared.tally import SPARE


class Both(NamedTuple):
    """Best candidates of both sides behind each wheel design. (k,) each"""

    cylinder: np.ndarray
    """Row of the pair of cylinder motor and gearhead; -1 where nothing is feasible."""
    steering: np.ndarray
    """Row of the pair of steering motor and ratio; -1 where nothing is feasible."""
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
    """Of that candidate among those given, -1 where none is feasible. int"""
    worst: np.ndarray
    """Largest demand over allowance of each candidate, or a lower bound of it. [-]"""
    excess: np.ndarray
    """Largest demand over allowance of the candidate nearest to feasible; 1 where one is feasible. (k,) [-]"""
    evaluated: int


def least_power(cylinder: Behind, steering: Behind, heaviest: float, *, prune: bool) -> Both:
    """Find both motors of the least power whose masses together are at most `heaviest`. [kg]"""
    count = cylinder.worst.shape[1]
    turning = _up_to(cylinder, heaviest - steering.mass.min(initial=np.inf))
    steered = _up_to(steering, heaviest - cylinder.mass.min(initial=np.inf))
    if not (len(turning.rows) and len(steered.rows)):
        none, unknown = np.full(count, -1), np.full(count, np.nan)
        return Both(none, none, np.full(count, np.inf), unknown, np.full(count, np.inf), 0)
    known = _by_mass(steered, prune=prune)
    room = (
        np.searchsorted(known.mass, heaviest - turning.mass, side="right") - 1
    )  # at least 0, by the choice of `turning`
    chosen = best_behind(turning, by_mass=False, prune=prune, added=known.power[room])
    feasible, designs = chosen.row >= 0, np.arange(count)
    first = np.searchsorted(turning.rows, np.where(feasible, chosen.row, turning.rows[0]))
    second = known.place[room[first], designs]
    # Each side alone may be feasible, and both together too heavy.
    over = _lightest(turning.mass, turning.worst) + _lightest(known.mass, known.worst)
    lacking = np.maximum(np.maximum(chosen.excess, known.excess), over / heaviest)
    return Both(
        cylinder=chosen.row,
        steering=np.where(feasible, steered.rows[second], -1),
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
        wanted = open_to & ((bound < best) | (not prune))
        wanted &= np.cumsum(wanted, axis=0) <= AT_ONCE
        if not wanted.any():
            break
        tried, places = np.nonzero(wanted)
        done = behind.evaluate(behind.rows[order[tried]], places)
        evaluated += len(tried)
        power[tried, places] = np.where(done.feasible, done.power, np.inf)
        worst[tried, places] = np.where(done.feasible, np.minimum(done.worst, 1.0), np.maximum(done.worst, 1.0 + SPARE))
        best = power.min(axis=0)
        last = np.where(wanted.any(axis=0), shape[0] - 1 - np.argmax(wanted[::-1], axis=0), -1)
        open_to &= np.arange(shape[0])[:, None] > last
    least = np.minimum.accumulate(power, axis=0)
    improved = np.where((power == least) & np.isfinite(power), np.arange(shape[0])[:, None], -1)
    place = np.maximum.accumulate(improved, axis=0)
    return _ByMass(
        mass=behind.mass[order],
        power=least,
        place=np.where(place >= 0, order[place], -1),
        worst=worst,
        excess=np.maximum(worst.min(axis=0), 1.0),
        evaluated=evaluated,
    )
