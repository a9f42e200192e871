"""Every pair of motor and gearhead with the best radius of a pulley, best first.

Closed forms bound the radii of each pair, and its power from below; its mass is known. Pairs are then evaluated at every instant
in the order of that bound, and the search ends when no other pair can be among the best.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from infinivar._core.pareto import spread_front
from infinivar.sizing.found import Design, GearedSizing
from infinivar.sizing.geared.candidates import STRUCTURE, Candidates
from infinivar.sizing.geared.radius_bounds import Radii
from infinivar.sizing.geared.radius_limits import Load, least_power, limits, load_of, region_points
from infinivar.sizing.geared.regeneration import RETURNED, returning, union, windows
from infinivar.sizing.geared.sampled import Sampled, sample
from infinivar.sizing.geared.tally import Tally, design, mixed, unchecked
from infinivar.sizing.geared.tasks import MotionTask, RegionTask, Task
from infinivar.sizing.margins import TaskDemand
from infinivar.sizing.progress import Progress, best_so_far
from infinivar.sizing.tables import MOVING, GearedRequest, Objective

_AT_ONCE = 32
"""Pairs evaluated together."""
_NODES = 13
"""Radii of a first look at a range."""
_GOLDEN_STEPS = 24
_GOLDEN = 0.5 * (5.0**0.5 - 1.0)
_BEYOND = 1e9
"""Above every demand of interest."""
_LIGHTER = 33
"""Radii of a pair that may be on the front, from the smallest feasible one to that of its least power."""
_HALVINGS = 30
"""Bisections of the ends of the feasible radii, on a logarithmic scale."""


class _Found(NamedTuple):
    """Best radius of some pairs. (k,) each"""

    radius: np.ndarray
    done: Sampled
    """At the best radius."""
    power: np.ndarray


class RadiusSearch:
    """Evaluation of pairs at every instant, at radii of their own."""

    def __init__(
        self, found: Candidates, tasks: Sequence[Task], objective: Objective, shares: Mapping[str, float]
    ) -> None:
        """Search among candidates for tasks."""
        assert found.template.pulley is not None
        self.found, self.tasks, self.pulley = found, tasks, found.template.pulley
        self.objective: Objective = objective
        self.shares = shares

    def at(self, rows: np.ndarray, radii: np.ndarray) -> Sampled:
        """Evaluate pairs, each at its radius."""
        return sample(self.found, rows, self.tasks, lambda places: replace(self.pulley, radius=radii[places][:, None]))

    @property
    def by_power(self) -> bool:
        """Whether designs are ordered by their power; else by what a smaller pulley has no more of."""
        return self.objective in MOVING

    def whole(self, rows: np.ndarray, radii: np.ndarray, objective: Objective = "mass") -> np.ndarray:
        """Mass of pairs, each with a pulley of its radius; or what else an objective asks for the least of. (k,) [kg]"""
        return self.found.measure(objective, rows, replace(self.pulley, radius=radii[:, None]))

    def look(self, rows: np.ndarray, radii: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Largest demand of pairs at several radii each, and mean power, inf where infeasible. (k, m), (k, m)"""
        done = self.at(np.repeat(rows, radii.shape[1]), radii.ravel())
        worst = ordered(done)
        power = np.where(done.feasible, mixed(done.power, self.shares), np.inf)
        return worst.reshape(radii.shape), np.where(np.isnan(power), 0.0, power).reshape(radii.shape)

    def best(self, rows: np.ndarray, bounds: Radii) -> _Found:
        """Best radius of pairs within bounds: the smallest, or that of the least power, at which every limit is kept.

        Of a pair that has none the radius of the largest margin.
        Within bounds every limit is kept on one interval of radii, so that the largest demand falls towards the radius with the
        largest margin from both sides; the power is sought beside the best of several radii.
        """
        radii = nodes(bounds.low, bounds.high)
        worst, power = self.look(rows, radii)
        radius = np.empty(len(rows))
        cheap = np.isfinite(power).any(axis=1) & self.by_power
        if not cheap.all():
            some = np.flatnonzero(~cheap)
            radius[some] = _narrowed(radii[some], worst[some], lambda tried: self.look(rows[some], tried)[0])
            if self.by_power:  # a range between the radii tried may be feasible
                ends = (self._end(rows[some], radius[some], end[some]) for end in bounds)
                radii[some] = nodes(*ends)
                power[some] = self.look(rows[some], radii[some])[1]
                cheap = np.isfinite(power).any(axis=1)
        if cheap.any():
            some = np.flatnonzero(cheap)
            radius[some] = _narrowed(radii[some], power[some], lambda tried: self.look(rows[some], tried)[1])
        if not self.by_power:
            radius = self._end(rows, radius, bounds.low)
        done = self.at(rows, radius)
        return _Found(radius, done, np.broadcast_to(mixed(done.power, self.shares), rows.shape))

    def ends(self, rows: np.ndarray, radius: np.ndarray, bounds: Radii) -> Radii:
        """Feasible radii around feasible ones, within bounds."""
        return Radii(*(self._end(rows, radius, end) for end in bounds))

    def _end(self, rows: np.ndarray, inside: np.ndarray, end: np.ndarray) -> np.ndarray:
        """Last feasible radius on the way from a radius to an end; the radius itself if it is infeasible."""
        found = inside.copy()
        feasible = self.at(rows, inside).feasible
        reached = feasible & self.at(rows, end).feasible
        found[reached] = end[reached]
        some = np.flatnonzero(feasible & ~reached)
        if some.size:
            good, bad = np.log(inside[some]), np.log(end[some])
            for _ in range(_HALVINGS):
                middle = 0.5 * (good + bad)
                able = self.at(rows[some], np.exp(middle)).feasible
                good, bad = np.where(able, middle, good), np.where(able, bad, middle)
            found[some] = np.where(good == np.log(inside[some]), inside[some], np.exp(good))
        return found


def best_over_radius(
    found: Candidates, tasks: Sequence[Task], request: GearedRequest, progress: Progress | None = None
) -> GearedSizing:
    """Find the best pairs, each with its best radius."""
    assert request.radius is not None
    radii, objective, shares = request.radius, request.objective, request.shares
    count, rows, tally = len(found.pairs), found.usable, Tally(found)
    template = found.template
    judged = tuple(region_points(task, template) if isinstance(task, RegionTask) else task for task in tasks)
    loads = [load_of(found, task, radii) for task in judged]
    places, bounds = _left(found, loads, tally, radii)
    able = np.isin(np.arange(len(rows)), places)
    limits_of = np.full((count, 2), np.nan)
    for column, one, of in ((0, bounds.low, np.fmin), (1, bounds.high, np.fmax)):
        of.at(limits_of[:, column], rows[places], one)
    if not request.prune and all(demand <= 1.0 for load in loads for demand in load.others.values()):
        # Where nothing is feasible by the closed forms, the search looks at the whole range all the same.
        others = np.flatnonzero(~able)
        places = np.concatenate([places, others])
        bounds = Radii(*(np.append(one, np.full(len(others), end)) for one, end in zip(bounds, radii, strict=True)))
    tried = rows[places]
    search = RadiusSearch(found, judged, objective, shares)
    least = _least(search, loads, tried, bounds)
    first = _best_first(search, tried, bounds, least, request.top, all_of_them=not request.prune, progress=progress)
    seen, drawn, weighs = np.zeros((1, count), dtype=bool), np.full((1, count), np.nan), np.full((1, count), np.nan)
    seen[0, tried[first.evaluated]] = True
    order = np.argsort(-first.power, kind="stable")  # of a pair with several ranges the one of least power comes last
    order = order[np.isfinite(first.power[order])]
    drawn[0, tried[order]], weighs[0, tried[order]] = first.power[order], first.mass[order]
    _tally_evaluated(tally, first, np.where(able[places], places, -1))
    feasible = np.zeros((1, count), dtype=bool)
    feasible[0, rows[able]] = True
    return GearedSizing(
        objective=objective,
        candidates=count,
        excluded=dict(found.excluded),
        counts=tally.counts(),
        designs=tuple(first.designs),
        feasible=feasible,
        evaluated=seen,
        power=drawn,
        mass=weighs,
        radii=limits_of,
        unchecked=unchecked(found, 1),
    )


def _left(
    found: Candidates, loads: Sequence[Load], tally: Tally, radii: tuple[float, float]
) -> tuple[np.ndarray, Radii]:
    """Radii that closed forms leave to usable pairs; pairs without one are counted by limit.

    Returns
    -------
    places : (m,) int   Pair of each range of radii, in rising order: one range, or several where no power may be returned.
    bounds : Radii     (m,)
    """
    rows = found.usable
    whole = Radii(np.full(len(rows), radii[0]), np.full(len(rows), radii[1]))
    bounds, gaps, places = whole, None, np.arange(len(rows))
    for key, one in _fitting(found, rows, radii):
        bounds = bounds.both(one)
        before, places = places, places[~bounds.empty[places]]
        tally.add(key, np.ones(len(rows), dtype=bool), one.empty, _lost(before, places, len(rows)))
    for load in loads:
        if any(not demand <= 1.0 for demand in load.others.values()):
            for key, demand in load.others.items():
                before, places = places, places if demand <= 1.0 else places[:0]
                beyond = np.full(len(rows), not demand <= 1.0)
                tally.add((load.task.name, *key), np.ones_like(beyond), beyond, _lost(before, places, len(rows)))
            return places, Radii(np.empty(0), np.empty(0))
        for key, one in limits(found, load, rows):
            checked = tally.checked(load.task, key, rows)
            # Rounding must not part an interval that is a single radius.
            one = Radii(one.low * (1.0 - 1e-12), one.high * (1.0 + 1e-12))
            bounds = bounds.both(one)
            before, places = places, places[~bounds.empty[places]]
            tally.add((load.task.name, *key), checked, one.empty, _lost(before, places, len(rows)))
        if found.template.amplifier.regeneration == "none":
            more = returning(found, load, rows)
            gaps = more if gaps is None else [union(np.concatenate(both)) for both in zip(gaps, more, strict=True)]
            before, places = places, windows(gaps, bounds)[0]
            beyond = _lost(np.arange(len(rows)), windows(more, whole)[0], len(rows))
            tally.add((load.task.name, *RETURNED), np.ones_like(beyond), beyond, _lost(before, places, len(rows)))
    return windows(gaps, bounds)


def _fitting(found: Candidates, rows: np.ndarray, radii: tuple[float, float]) -> Iterator[tuple[TaskDemand, Radii]]:
    """Yield each limit of structure and envelope with the radii at which it is kept.

    A smaller pulley has less room for its shaft, a larger one needs more space and mass.
    """
    pulley = found.template.pulley
    assert pulley is not None

    def demands(radius: np.ndarray) -> dict[TaskDemand, np.ndarray]:
        return found.sized(rows, replace(pulley, radius=radius[:, None]))

    low, high = (np.full(len(rows), end) for end in radii)
    least, most = demands(low), demands(high)
    for key in least:
        if key[0] == STRUCTURE:  # inverse to the radius
            yield key, Radii(low * np.maximum(least[key], 1.0), high)
            continue
        good, bad = np.log(low), np.log(high)
        for _ in range(_HALVINGS if (most[key] > 1.0).any() else 0):
            middle = 0.5 * (good + bad)
            fits = demands(np.exp(middle))[key] <= 1.0
            good, bad = np.where(fits, middle, good), np.where(fits, bad, middle)
        end = np.where(most[key] <= 1.0, high, np.exp(good))
        yield key, Radii(low, np.where(least[key] <= 1.0, end, 0.5 * low))


def _lost(before: np.ndarray, after: np.ndarray, count: int) -> np.ndarray:
    """Which of some candidates are among places before, but not after. (count,) bool"""
    every = np.arange(count)
    return np.isin(every, before) & ~np.isin(every, after)


def _tally_evaluated(tally: Tally, first: _First, places: np.ndarray) -> None:
    """Count pairs that turned out infeasible in all their ranges, by the tightest limit; places below 0 do not count."""
    order = np.lexsort((first.worst, places))
    order = order[places[order] >= 0]
    pairs, begin = np.unique(places[order], return_index=True)
    if not pairs.size:
        return
    failed = np.logical_and.reduceat((first.evaluated & ~first.able)[order], begin)
    tally.tightest(first.keys, first.tightest[order[begin[failed]]])


def _least(search: RadiusSearch, loads: Sequence[Load], rows: np.ndarray, bounds: Radii) -> np.ndarray:
    """Lower bound of the objective: a smaller pulley weighs less. (k,)"""
    if not search.by_power:
        return search.whole(rows, bounds.low, search.objective)
    total = np.zeros(len(rows))
    for load in loads:
        if isinstance(load.task, MotionTask) and len(rows):
            total = total + search.shares[load.task.name] * least_power(search.found, load, rows, bounds)
    return total


class _First(NamedTuple):
    """What became of ranges of radii, best first. (m,) each"""

    designs: list[Design]
    evaluated: np.ndarray
    able: np.ndarray
    """Found to be feasible. bool"""
    power: np.ndarray
    mass: np.ndarray
    worst: np.ndarray
    """Largest demand at the best radius, in the order of `ordered`."""
    tightest: np.ndarray
    """Place of its limit among `keys`."""
    keys: tuple[TaskDemand, ...]


def _best_first(
    search: RadiusSearch,
    rows: np.ndarray,
    bounds: Radii,
    least: np.ndarray,
    top: int,
    *,
    all_of_them: bool,
    progress: Progress | None,
) -> _First:
    """Evaluate ranges of radii of pairs, of which one may have several, until no other can be among the best."""
    evaluated, power = np.zeros(len(rows), dtype=bool), np.full(len(rows), np.nan)
    radius, worst = np.full(len(rows), np.nan), np.full(len(rows), np.nan)
    value, mass = np.full(len(rows), np.inf), search.whole(rows, bounds.low)  # of those not evaluated a lower bound
    tightest, keys = np.zeros(len(rows), dtype=int), ()
    order = np.argsort(least, kind="stable")
    while True:
        promising = least <= _to_beat(search.objective, rows, value, mass, top)
        waiting = order[~evaluated[order] & (promising[order] | all_of_them)]
        some = waiting[:_AT_ONCE]
        if not some.size:
            break
        if progress is not None:
            first = int(np.argmin(value))
            known = np.isfinite(value[first])
            said = best_so_far(power[first], mass[first]) if known else best_so_far(np.nan, np.nan)
            progress(said, float(evaluated.sum() / (evaluated.sum() + len(waiting))))
        made = search.best(rows[some], Radii(bounds.low[some], bounds.high[some]))
        able = made.done.feasible
        evaluated[some], radius[some], worst[some] = True, made.radius, ordered(made.done)
        mass[some] = search.whole(rows[some], made.radius)
        keys = tuple(made.done.demands)
        tightest[some] = np.argmax(list(made.done.demands.values()), axis=0)
        power[some] = np.where(able, made.power, np.nan)
        needed = made.power if search.by_power else search.whole(rows[some], made.radius, search.objective)
        value[some] = np.where(able, needed, np.inf)
    able = np.isfinite(value)
    best = np.flatnonzero(able)
    best = best[np.lexsort((rows[best], worst[best], np.nan_to_num(mass[best], nan=np.inf), value[best]))]
    best = best[np.sort(np.unique(rows[best], return_index=True)[1])]  # of a pair with several ranges the best
    if search.objective == "front":
        best, tried = _front(search, rows, radius, bounds, best)
    else:
        best, tried = best[:top], radius[best[:top]]
    designs = _designs(search, rows[best], tried, Radii(bounds.low[best], bounds.high[best]))
    return _First(designs, evaluated, able, power, mass, worst, tightest, keys)


def _front(
    search: RadiusSearch, rows: np.ndarray, radius: np.ndarray, bounds: Radii, best: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The front of ranges at feasible radii up to that of their least power: a smaller pulley weighs less. (k,), (k,)"""
    low = search.ends(rows[best], radius[best], Radii(bounds.low[best], bounds.high[best])).low
    tried = (low[:, None] * (radius[best] / low)[:, None] ** np.linspace(0.0, 1.0, _LIGHTER)).ravel()
    every = np.repeat(best, _LIGHTER)
    done, mass = search.at(rows[every], tried), search.whole(rows[every], tried)
    able = np.flatnonzero(done.feasible)
    power = np.broadcast_to(mixed(done.power, search.shares), mass.shape)
    kept = able[spread_front(mass[able], power[able])]
    return every[kept], tried[kept]


def _to_beat(objective: Objective, rows: np.ndarray, value: np.ndarray, mass: np.ndarray, top: int) -> Any:
    """Value above which pairs are not among the best, whatever their radius; of a front, that of each pair's mass."""
    if not len(value):
        return np.inf
    if objective != "front":
        order = np.argsort(value, kind="stable")
        first = np.sort(np.unique(rows[order], return_index=True)[1])
        return value[order[first[min(top, len(first)) - 1]]]
    order = np.argsort(mass)
    least = np.minimum.accumulate(value[order])
    return least[np.searchsorted(mass[order], mass, side="right") - 1]


def _designs(search: RadiusSearch, rows: np.ndarray, radius: np.ndarray, bounds: Radii) -> list[Design]:
    """Pairs at feasible radii as designs."""
    if not rows.size:
        return []
    done, ends = search.at(rows, radius), search.ends(rows, radius, bounds)
    drawn = np.broadcast_to(mixed(done.power, search.shares), rows.shape)
    found = []
    for place, row in enumerate(rows):
        stage = replace(search.pulley, radius=float(radius[place]))
        radii = float(ends.low[place]), float(ends.high[place])
        found.append(design(search.found, int(row), stage, done, place, float(drawn[place]), radii))
    return found


def ordered(done: Sampled) -> np.ndarray:
    """Largest demand; where one has no bound, such as a temperature, beyond all others but in the order of the finite ones."""
    demands = np.stack(list(done.demands.values()))
    finite = np.where(np.isfinite(demands), demands, 0.0).max(axis=0)
    return np.where(np.isfinite(demands).all(axis=0), finite, _BEYOND * (1.0 + finite))


def nodes(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Radii from the least to the largest of each pair, in equal ratios. (k, m)"""
    radii = low[:, None] * (high / low)[:, None] ** np.linspace(0.0, 1.0, _NODES)
    radii[:, -1] = high
    return radii


def _narrowed(radii: np.ndarray, values: np.ndarray, of: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """Radius of the least value of each row, by golden section between the neighbours of the best radius known."""
    place, every = np.argmin(values, axis=1), np.arange(len(radii))
    known, at_known = radii[every, place], values[every, place]
    low = np.log(radii[every, np.maximum(place - 1, 0)])
    high = np.log(radii[every, np.minimum(place + 1, radii.shape[1] - 1)])
    left, right = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
    at_left, at_right = of(np.exp(np.stack([left, right], axis=-1))).T
    for _ in range(_GOLDEN_STEPS):
        down = at_left <= at_right
        low, high = np.where(down, low, left), np.where(down, right, high)
        new = np.where(down, high - _GOLDEN * (high - low), low + _GOLDEN * (high - low))
        at_new = of(np.exp(new)[:, None])[:, 0]
        left, right = np.where(down, new, right), np.where(down, left, new)
        at_left, at_right = np.where(down, at_new, at_right), np.where(down, at_left, at_new)
    for one, value in ((left, at_left), (right, at_right)):
        better = value < at_known
        known, at_known = np.where(better, np.exp(one), known), np.where(better, value, at_known)
    return known
