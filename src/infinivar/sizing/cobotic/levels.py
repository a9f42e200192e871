"""The lightest drive, and the front of mass and power: the least power at every mass.

A search by power alone finds the heavy end of the front, one by mass alone the light end. Between them each level is a search for
the least power with motors and gearhead of less than a given mass, which starts from the wheel designs known so far.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from infinivar.sizing.cobotic.bounds import Side
from infinivar.sizing.cobotic.evolution import Hunt, Record, Stage, evolve
from infinivar.sizing.progress import Progress, part_of

_LIGHTER = 1.0 - 1e-9
"""Less by more than rounding."""

_APART = 1_000_003
"""Between the seeds of searches for one seed, so that the next seed's are others."""

_TRIES = 12
"""Most searches among the lighter parts."""

_STARTS = 5
"""Searches for the least power that begin anew; a last one begins from what they found."""

_SHORTER = 3
"""Each of them has as many generations as the last one, divided by this."""


def find_thriftiest(
    hunt: Hunt, stages: Sequence[Stage], seed: int, progress: Progress | None
) -> tuple[Record, np.ndarray]:
    """Search for the least power several times, and once more from what was found: record and history.

    One search may end with the parts that are best for the wheels it happened to begin with.
    """
    known, histories = Record(), []
    for place in range(_STARTS):
        said = part_of(progress, place / (2 * _STARTS), (place + 1) / (2 * _STARTS))
        found, history = evolve(hunt, [stages[0].shorter(_SHORTER)], seed + _APART * place, said)
        known.merge_best(found)
        histories.append(history)
    most = hunt.population // 2
    start = known.points(most).of(slice(most))
    record, history = evolve(hunt, stages, seed, part_of(progress, 0.5, 1.0), start)
    again = known.points(hunt.kept)  # at all instants, of which the last search may have lost the best
    record.add(again, hunt.evaluation.values(again))
    history[-1:] = np.minimum(history[-1:], record.least)
    longest = max(map(len, histories))  # a search whose designs have become one ends early
    held = [np.pad(one, (0, longest - len(one)), mode="edge") for one in histories]
    return record, np.concatenate([np.min(held, axis=0), history])


def find_lightest(
    hunt: Hunt, stages: Sequence[Stage], seed: int, progress: Progress | None
) -> tuple[Record, np.ndarray]:
    """Search for the least mass, and then among lighter parts alone until none of them is feasible: record and history.

    Mass changes in steps, on which a search sees no way on. Where no part is feasible, it sees by how much.
    """
    evaluation = hunt.evaluation
    record, history = evolve(hunt, stages, seed, progress)
    sides, shorter = evaluation.sides, [one.shorter(2) for one in stages]
    for place in range(1, _TRIES + 1):
        best = min((one.mass for one in record.best.values()), default=np.inf)
        evaluation.sides = _lighter(sides, best * _LIGHTER)
        if not np.isfinite(best) or not all(side.rows.size for side in evaluation.sides):
            break
        start = record.points_near(best, hunt.population // 2)
        found, more = evolve(hunt, shorter, seed + place, None, start)
        record.merge_best(found)
        history = np.concatenate([history, np.minimum(more, history[-1])])
        if progress is not None:
            progress(f"best so far: {min(one.mass for one in record.best.values()):.5g} kg", 1.0)
        if not any(one.mass < best for one in found.best.values()):
            break
    evaluation.sides = sides
    return record, history


def _lighter(sides: Sequence[Side], mass: float) -> list[Side]:
    """The candidates of each side with which the lightest of the others make less than a mass."""
    least = [float(side.found.mass(side.rows).min(initial=np.inf)) for side in sides]
    found = []
    for side, own in zip(sides, least, strict=True):
        kept = side.rows[side.found.mass(side.rows) + sum(least) - own < mass]
        found.append(replace(side, found=replace(side.found, usable=kept)))
    return found


def fill_front(
    hunt: Hunt, stages: Sequence[Stage], known: Record, levels: int, seed: int, progress: Progress | None
) -> None:
    """Search between the ends of the front that are known, and add what is found.

    Parameters
    ----------
    stages   Of each level.
    known    Holds the designs of least power and of least mass.
    levels   Most levels. The mass falls from one to the next by at least one part in `levels` of the range.
    """
    ends = [known.light[key].mass for key in known.front()]
    if len(ends) < 2:
        return
    lightest, step = min(ends), (max(ends) - min(ends)) / levels
    heaviest, place = np.inf, 0  # the first level is the least power once more, from all that is known
    while heaviest >= lightest:
        hunt.evaluation.heaviest = heaviest
        start = known.points_near(min(heaviest, max(ends)), hunt.population // 2)
        found, _ = evolve(hunt, stages, seed + place, None, start)
        known.merge(found)
        under = [one for one in known.light.values() if one.mass <= heaviest]
        best = min(under, key=lambda one: one.power)
        if progress is not None and np.isfinite(heaviest):
            progress(f"least so far at {heaviest:.3g} kg: {best.power:.5g} W", (place + 1) / (levels + 1))
        heaviest, place = min(best.mass * _LIGHTER, min(heaviest, max(ends)) - step if place else np.inf), place + 1
    hunt.evaluation.heaviest = np.inf
