"""Differential evolution over wheel designs, and what it finds: the lightest drive, and the front of mass and power.

A search by power alone finds the heavy end of the front, one by mass alone the light end. What is between them is then searched
at once, from the designs that both met on their way.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from infinivar._core.pareto import front
from infinivar.sizing.cobotic.bounds import Side
from infinivar.sizing.cobotic.evaluation import NOT_FEASIBLE, Evaluation, Value
from infinivar.sizing.cobotic.space import FREE, Heads, Points
from infinivar.sizing.geared.tasks import Task
from infinivar.sizing.measures import MEASURES
from infinivar.sizing.progress import Progress, part_of

_LIGHTER = 1.0 - 1e-9
"""Less by more than rounding."""

_APART = 1_000_003
"""Between the seeds of searches for one seed, so that the next seed's are others."""

_LIGHTEST = -(10**6)
"""In place of a step of the mass."""

_TRIES = 12
"""Most searches among the lighter parts."""

_STARTS = 5
"""Searches for the least power that begin anew; a last one begins from what they found."""

_SHORTER = 3
"""Each of them has as many generations as the last one, divided by this."""


_FARTHEST, _NEAREST = 0.15, 0.02
"""Standard deviations of the logarithms of values in the first and last round along the front."""

_NEXT = 0.8
"""That of a rank in a list."""

Key = tuple[int, int, int]
"""Pair of motor and gearhead, axle bearing with wheels (`Heads.apart`), pair of steering motor and ratio."""

_STEPS = math.log(1.05)
"""Of the logarithm of the mass: of the same parts, one wheel design is kept in each."""


class Box(NamedTuple):
    """Where wheel designs are searched."""

    low: np.ndarray
    """Of the values in the order of `FREE`. (5,)"""
    high: np.ndarray
    """(5,)"""
    heads: Heads
    own: Points
    """The template, where the search starts if its values are within."""


class Stage(NamedTuple):
    """A part of the search."""

    tasks: Sequence[Task]
    """What wheel designs are judged by."""
    whole: Sequence[Task]
    """The same at all instants: no wheel may slip at the critical ones among them."""
    generations: int

    def shorter(self, times: int) -> Stage:
        """The same with fewer generations."""
        return self._replace(generations=max(1, self.generations // times))


class Entry(NamedTuple):
    """A wheel design with the best motors behind it."""

    value: float
    """Of the objective."""
    values: np.ndarray
    """In the order of `FREE`. (5,)"""
    head: int
    """Place of the head."""
    mass: float
    power: float


class Record:
    """Feasible designs: the best values of every combination of parts, and the infeasible wheel design nearest to feasible."""

    def __init__(self, heads: Heads) -> None:
        """Nothing is known yet."""
        self.heads = heads
        self.best: dict[Key, Entry] = {}
        """By the objective."""
        self.light: dict[tuple[Key, int], Entry] = {}
        """By power in each step of the mass; and by mass, as step `_LIGHTEST`."""
        self.nearest: tuple[float, np.ndarray, int] | None = None
        """Value, values and head."""

    def add(self, points: Points, found: Value) -> None:
        """Add wheel designs."""
        for place in np.flatnonzero(found.feasible):
            value, mass, power = (float(one[place]) for one in (found.value, found.mass, found.power))
            one = Entry(value, points.values[place], int(points.head[place]), mass, power)
            key = int(found.pair[place]), self.heads.apart(one.head), int(found.steering[place])
            if key not in self.best or one.value < self.best[key].value:
                self.best[key] = one
            self._add_light(key, one)
        if len(found.value):
            first = int(np.argmin(found.value))
            if self.nearest is None or found.value[first] < self.nearest[0]:
                self.nearest = float(found.value[first]), points.values[first], int(points.head[first])

    def _add_light(self, key: Key, one: Entry) -> None:
        """Keep a design if it needs the least power of its step, or is the lightest of its parts."""
        step = math.floor(math.log(one.mass) / _STEPS) if one.mass > 0.0 else 0
        if (key, step) not in self.light or one.power < self.light[key, step].power:
            self.light[key, step] = one
        known = self.light.get((key, _LIGHTEST))
        if known is None or (one.mass, one.power) < (known.mass, known.power):
            self.light[key, _LIGHTEST] = one

    @property
    def least(self) -> float:
        """Least value of a feasible design; inf if there is none."""
        return min((one.value for one in self.best.values()), default=np.inf)

    def front(self) -> list[tuple[Key, int]]:
        """Keys of `light` of which no other has less mass and less power, by power."""
        keys = sorted(self.light)
        mass, power = (np.array([getattr(self.light[key], name) for key in keys]) for name in ("mass", "power"))
        known = np.flatnonzero(np.isfinite(mass) & np.isfinite(power)) if keys else np.empty(0, dtype=int)
        places = known[front(mass[known], power[known])] if known.size else known
        return [keys[place] for place in places]

    def points(self, most: int) -> Points:
        """Wheel designs of the front, and of the best combinations."""
        entries = [self.light[key] for key in self.front()]
        best = sorted(self.best, key=lambda key: (self.best[key].value, key))[:most]
        return _points([*entries, *(self.best[key] for key in best)])

    def points_near(self, mass: float, most: int) -> Points:
        """Wheel designs of the front nearest to a mass, heavier and lighter, and of the least power among the lighter ones."""
        nearest = sorted(self.front(), key=lambda key: (abs(self.light[key].mass - mass), key))[: most // 2]
        lighter = [key for key, one in self.light.items() if one.mass <= mass and key not in nearest]
        lighter.sort(key=lambda key: (self.light[key].power, key))
        return _points([self.light[key] for key in (*nearest, *lighter)][:most])

    def merge_best(self, other: Record) -> None:
        """Add the designs of another record, found with the same objective."""
        for key, one in other.best.items():
            if key not in self.best or one.value < self.best[key].value:
                self.best[key] = one
        if self.nearest is None or (other.nearest is not None and other.nearest[0] < self.nearest[0]):
            self.nearest = other.nearest
        self.merge(other)

    def by_power(self) -> Record:
        """All designs by their power."""
        made = Record(self.heads)
        made.light = {key: one._replace(value=one.power) for key, one in self.light.items()}
        for (key, _), one in made.light.items():
            if key not in made.best or one.power < made.best[key].power:
                made.best[key] = one
        return made

    def merge(self, other: Record) -> None:
        """Add the designs of another record, found with another objective: they count by power and mass alone."""
        for (key, _), one in other.light.items():
            self._add_light(key, one)


def _points(entries: Sequence[Entry]) -> Points:
    """Wheel designs of entries."""
    values = np.array([one.values for one in entries]).reshape(-1, len(FREE))
    return Points(values, np.array([one.head for one in entries], dtype=int))


class Hunt(NamedTuple):
    """What every search over a problem has in common."""

    evaluation: Evaluation
    box: Box
    population: int
    top: int
    """Designs to return."""

    @property
    def kept(self) -> int:
        """Designs kept from one stage to the next, besides the front: the best may not be feasible at more instants."""
        return max(self.top, self.population // 2)


def evolve(
    hunt: Hunt,
    stages: Sequence[Stage],
    seed: int,
    progress: Progress | None,
    start: Points | None = None,
    wheels: int | None = None,
) -> tuple[Record, np.ndarray]:
    """Search a box in stages, each from the last generation of the one before: designs of the last stage, and the history.

    Values are searched on a logarithmic scale. Bearings are whole numbers, their places in the order of static ratings. The
    history has the best value after each generation. Designs of `start` take the place of some of the first generation. With
    `wheels`, only designs with this number of them are searched.
    """
    evaluation, space = hunt.evaluation, _Space(hunt.box, wheels)
    record, history = Record(hunt.box.heads), []
    total = sum(stage.generations for stage in stages)
    generation = space.start(hunt.population, seed, start)

    def objective(x: np.ndarray) -> np.ndarray:
        points = space.points(x)
        found = evaluation.values(points)
        record.add(points, found)
        return found.value

    def said(intermediate_result: Any) -> None:
        best = float(intermediate_result.fun)
        history.append(best if best < NOT_FEASIBLE else np.inf)
        if progress is not None:
            shown = MEASURES[evaluation.objective].shown
            words = f"best so far: {shown(best)}" if best < NOT_FEASIBLE else "no feasible design so far"
            progress(words, len(history) / total)

    for place, stage in enumerate(stages):
        evaluation.look_at(stage.tasks, stage.whole)
        again, record = record.points(hunt.kept), Record(hunt.box.heads)
        if len(again.head):
            record.add(again, evaluation.values(again))
        if not len(generation[0]):
            objective(np.empty((0, 1)))
            history.append(record.least)
            continue
        generation = _evolved(objective, space, generation, stage.generations, seed + place, said)
    return record, np.array(history)


class _Space:
    """Wheel designs as vectors of numbers: logarithms of the free values, and ranks in the lists of heads."""

    def __init__(self, box: Box, wheels: int | None = None) -> None:
        self._low, self._high = np.log(box.low), np.log(box.high)
        self._own = box.own._replace(values=np.clip(box.own.values, box.low, box.high))
        self._free = np.flatnonzero(self._high > self._low)
        self._heads, self._orders = box.heads, box.heads.orders
        if wheels is not None:
            self._orders[1] = np.array([box.heads.wheels.index(wheels)])
        self._several = [place for place, order in enumerate(self._orders) if len(order) > 1]

    @property
    def bounds(self) -> list[tuple[float, float]]:
        """Of each number."""
        ends = list(zip(self._low[self._free], self._high[self._free], strict=True))
        return [*ends, *((0.0, len(self._orders[place]) - 1.0) for place in self._several)]

    @property
    def integrality(self) -> list[bool]:
        """Which of them are whole."""
        return [*[False] * len(self._free), *[True] * len(self._several)]

    def points(self, x: np.ndarray) -> Points:
        """Wheel designs of vectors. (n, k)"""
        values = np.broadcast_to(self._low, (x.shape[1], len(FREE))).copy()
        values[:, self._free] = np.clip(x[: len(self._free)].T, self._low[self._free], self._high[self._free])
        places = [np.full(x.shape[1], order[0]) for order in self._orders]
        for row, place in enumerate(self._several, len(self._free)):
            order = self._orders[place]
            places[place] = order[np.clip(np.rint(x[row]), 0, len(order) - 1).astype(int)]
        return Points(np.exp(values), self._heads.at(places))

    def vectors(self, points: Points) -> np.ndarray:
        """Vectors of wheel designs. (k, n)"""
        places = self._heads.places(points.head)
        ranks = [np.argsort(self._orders[place])[places[place], None] for place in self._several]  # of all in the list
        return np.hstack([np.log(points.values)[:, self._free], *ranks])

    def start(self, population: int, seed: int, known: Points | None) -> np.ndarray:
        """Vectors of the first generation: the template, designs that are known, and a Latin hypercube. (population, n)"""
        from scipy.stats import qmc

        ends = np.array(self.bounds, dtype=float).reshape(-1, 2)
        if not len(ends):
            return np.empty((1, 0))
        spread = qmc.LatinHypercube(len(ends), rng=np.random.default_rng(seed)).random(population)
        made = ends[:, 0] + spread * (ends[:, 1] - ends[:, 0])
        made[0] = self.vectors(self._own)[0]
        if known is not None:
            made[1 : 1 + len(known.head)] = self.vectors(known)
        return made


def _evolved(objective: Any, space: _Space, start: np.ndarray, generations: int, seed: int, said: Any) -> np.ndarray:
    """Last generation of differential evolution from a first one. (population, n)"""
    from scipy.optimize import differential_evolution

    return differential_evolution(
        objective,
        space.bounds,
        integrality=space.integrality,
        init=start,  # type: ignore[arg-type]
        maxiter=generations,
        tol=0.0,
        mutation=(0.4, 0.9),
        recombination=0.8,
        polish=False,
        updating="deferred",
        vectorized=True,
        rng=np.random.default_rng(seed),
        callback=said,
    ).population


def find_least(hunt: Hunt, stages: Sequence[Stage], seed: int, progress: Progress | None) -> tuple[Record, np.ndarray]:
    """Search for the least value several times, and once more from what was found: record and history.

    One search may end with the parts that are best for the wheels it happened to begin with. Each begins with one number of
    wheels: with more of them and less preload, two values change at once, which a search rarely tries.
    """
    known, histories, numbers = Record(hunt.box.heads), [], hunt.box.heads.wheels
    for place in range(_STARTS):
        said = part_of(progress, place / (2 * _STARTS), (place + 1) / (2 * _STARTS))
        of = numbers[place % len(numbers)]
        found, history = evolve(hunt, [stages[0].shorter(_SHORTER)], seed + _APART * place, said, wheels=of)
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
    """Search for the least mass, and then among lighter motors alone until none of them is feasible: record and history.

    The mass of motors changes in steps, on which a search sees no way on. Where none is feasible, it sees by how much. Lighter
    are those that would make a lighter whole with the lightest structure found.
    """
    evaluation = hunt.evaluation
    record, history = Record(hunt.box.heads), np.empty(0)
    numbers = hunt.box.heads.wheels
    for place, wheels in enumerate(numbers):
        said = part_of(progress, place / len(numbers), (place + 1) / len(numbers))
        found, more = evolve(hunt, stages, seed + _APART * place, said, wheels=wheels)
        record.merge_best(found)
        history = np.concatenate([history, more])
    history = np.minimum.accumulate(history)
    sides, shorter = evaluation.sides, [one.shorter(2) for one in stages]
    for place in range(1, _TRIES + 1):
        best = min((one.mass for one in record.best.values()), default=np.inf)
        carried = min((one.mass - _chosen(sides, key) for key, one in record.best.items()), default=0.0)
        evaluation.sides = _lighter(sides, best * _LIGHTER - carried)
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


def _chosen(sides: Sequence[Side], key: Key) -> float:
    """Mass of the motors and gearhead of a combination of parts. [kg]"""
    rows = [key[0], key[2]]
    return sum(float(side.found.mass(np.array([row]))[0]) for side, row in zip(sides, rows, strict=False))


def _lighter(sides: Sequence[Side], mass: float) -> list[Side]:
    """The candidates of each side with which the lightest of the others make less than a mass."""
    least = [float(side.found.mass(side.rows).min(initial=np.inf)) for side in sides]
    found = []
    for side, own in zip(sides, least, strict=True):
        kept = side.rows[side.found.mass(side.rows) + sum(least) - own < mass]
        found.append(replace(side, found=replace(side.found, usable=kept)))
    return found


def fill_front(hunt: Hunt, stage: Stage, known: Record, rounds: int, seed: int, progress: Progress | None) -> None:
    """Search the whole front at once, from the designs on it that are known, and add what is found.

    Each design begins from one of the front and moves by the difference of two others, and a little in any direction. Its motors
    are those of the least power that make it not heavier than a mass between its parent's and that of the next lighter design.

    Parameters
    ----------
    stage    The last of a search: judges at all instants.
    known    Holds the designs of least power and of least mass.
    rounds   Of as many designs as a generation has. Small moves become smaller from `_FARTHEST` to `_NEAREST`.

    Source: storn1997, for the differences.
    """
    space, random, count = _Space(hunt.box), np.random.default_rng(seed), hunt.population
    hunt.evaluation.look_at(stage.tasks, stage.whole)
    for place, small in enumerate(np.geomspace(_FARTHEST, _NEAREST, rounds)):
        front = [known.light[key] for key in known.front()]
        if not front:
            return
        x, mass = space.vectors(_points(front)), np.array([one.mass for one in front])
        lighter = np.append(mass[1:], mass[-1])
        parents, first, second = random.integers(len(front), size=(3, count))
        share = random.random((count, 1))
        differs = random.random((count, 1)) < 0.5
        step = np.where(space.integrality, _NEXT, small) * np.where(differs, 0.3, 1.0)
        moved = step * random.standard_normal(step.shape) + differs * share * (x[first] - x[second])
        moved *= random.random(step.shape) < 0.6
        heaviest = lighter[parents] + random.random(count) * (mass - lighter)[parents]
        points = space.points((x[parents] + moved).T)._replace(heaviest=heaviest)
        known.add(points, hunt.evaluation.values(points))
        if progress is not None:
            progress("searching along the front", (place + 1) / rounds)
