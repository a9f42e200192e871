"""Every pair of motor and gearhead with the best radius of a pulley, best first.

Closed forms bound the radii of each pair, and its power from below; its mass is known. Pairs are then evaluated at every instant
in the order of that bound, and the search ends when no other pair can be among the best.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from infinivar.parts.linear import Pulley
from infinivar.sizing.geared.candidates import Candidates
from infinivar.sizing.geared.radius_bounds import Bounds
from infinivar.sizing.geared.radius_limits import Load, least_power, limits, load_of, region_points
from infinivar.sizing.geared.ranking import design, front, mixed, unchecked
from infinivar.sizing.geared.result import Design, GearedSizing, Objective, Progress, best_so_far
from infinivar.sizing.geared.sampled import Sampled, sample
from infinivar.sizing.geared.tally import Tally
from infinivar.sizing.geared.tasks import MotionTask, RegionTask, Task

_AT_ONCE = 32
"""Pairs evaluated together."""
_NODES = 13
"""Radii of a first look at a range."""
_GOLDEN_STEPS = 24
_GOLDEN = 0.5 * (5.0**0.5 - 1.0)
_BEYOND = 1e9
"""Above every demand of interest."""
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

    def look(self, rows: np.ndarray, radii: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Largest demand of pairs at several radii each, and mean power, inf where infeasible. (k, m), (k, m)"""
        done = self.at(np.repeat(rows, radii.shape[1]), radii.ravel())
        worst = ordered(done)
        power = np.where(done.feasible, mixed(done.power, self.shares), np.inf)
        return worst.reshape(radii.shape), np.where(np.isnan(power), 0.0, power).reshape(radii.shape)

    def best(self, rows: np.ndarray, bounds: Bounds) -> _Found:
        """Best radius of pairs within bounds: of the largest margin, or of the least power at which every limit is kept.

        Every limit is kept on one interval of radii, so that the largest demand falls towards the radius with the largest
        margin from both sides; the power is sought beside the best of several radii.
        """
        radii = nodes(bounds.low, bounds.high)
        worst, power = self.look(rows, radii)
        radius = np.empty(len(rows))
        cheap = np.isfinite(power).any(axis=1) & (self.objective != "mass")
        if not cheap.all():
            some = np.flatnonzero(~cheap)
            radius[some] = _narrowed(radii[some], worst[some], lambda tried: self.look(rows[some], tried)[0])
            if self.objective != "mass":  # a range between the radii tried may be feasible
                ends = (self._end(rows[some], radius[some], end[some]) for end in bounds)
                radii[some] = nodes(*ends)
                power[some] = self.look(rows[some], radii[some])[1]
                cheap = np.isfinite(power).any(axis=1)
        if cheap.any():
            some = np.flatnonzero(cheap)
            radius[some] = _narrowed(radii[some], power[some], lambda tried: self.look(rows[some], tried)[1])
        done = self.at(rows, radius)
        return _Found(radius, done, np.broadcast_to(mixed(done.power, self.shares), rows.shape))

    def ends(self, rows: np.ndarray, radius: np.ndarray, bounds: Bounds) -> Bounds:
        """Feasible radii around feasible ones, within bounds."""
        return Bounds(*(self._end(rows, radius, end) for end in bounds))

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
    found: Candidates,
    tasks: Sequence[Task],
    radii: tuple[float, float],
    *,
    objective: Objective,
    shares: Mapping[str, float],
    top: int,
    prune: bool,
    progress: Progress | None = None,
) -> GearedSizing:
    """Find the best pairs, each with its best radius; arguments as for `size_geared`."""
    count, rows, tally = len(found.pairs), found.usable, Tally(found)
    template = found.template
    judged = tuple(region_points(task, template) if isinstance(task, RegionTask) else task for task in tasks)
    loads = [load_of(found, task, radii) for task in judged]
    bounds = _bounds(found, loads, tally, radii)
    able = ~bounds.empty
    reachable = all(demand <= 1.0 for load in loads for demand in load.others.values())
    whole = Bounds(np.full(len(rows), radii[0]), np.full(len(rows), radii[1]))
    if not prune:
        # Where nothing is feasible by the closed forms, the search looks at the whole range all the same.
        bounds = Bounds(np.where(able, bounds.low, whole.low), np.where(able, bounds.high, whole.high))
    tried = np.flatnonzero(able) if prune or not reachable else np.arange(len(rows))
    bounds = Bounds(bounds.low[tried], bounds.high[tried])
    least = _least(found, loads, rows[tried], bounds, objective, shares)
    search = RadiusSearch(found, judged, objective, shares)
    designs, evaluated, power = _best_first(
        search, rows[tried], bounds, least, top, all_of_them=not prune, progress=progress
    )
    limits_of = np.full((count, 2), np.nan)
    limits_of[rows[tried]] = np.where(able[tried][:, None], np.stack(bounds, axis=-1), np.nan)
    feasible = np.zeros((1, count), dtype=bool)
    feasible[0, rows[able]] = True
    drawn, seen = np.full((1, count), np.nan), np.zeros((1, count), dtype=bool)
    drawn[0, rows[tried]], seen[0, rows[tried]] = power, evaluated
    return GearedSizing(
        objective=objective,
        candidates=count,
        excluded=dict(found.excluded),
        counts=tally.counts(),
        designs=tuple(designs),
        feasible=feasible,
        evaluated=seen,
        power=drawn,
        radii=limits_of,
        unchecked=unchecked(found, 1),
    )


def _bounds(found: Candidates, loads: Sequence[Load], tally: Tally, radii: tuple[float, float]) -> Bounds:
    """Radii that closed forms leave to each usable pair; pairs without one are counted by limit."""
    rows = found.usable
    bounds = Bounds(np.full(len(rows), radii[0]), np.full(len(rows), radii[1]))
    for load in loads:
        if any(not demand <= 1.0 for demand in load.others.values()):
            for key, demand in load.others.items():
                beyond = np.full(len(rows), not demand <= 1.0)
                tally.add((load.task.name, *key), np.ones_like(beyond), beyond, beyond & ~bounds.empty)
            return Bounds(bounds.high + 1.0, bounds.low)
        for key, one in limits(found, load, rows):
            checked = tally.checked(load.task, key, rows)
            # Rounding must not part an interval that is a single radius.
            one = Bounds(one.low * (1.0 - 1e-12), one.high * (1.0 + 1e-12))
            left = ~bounds.empty
            bounds = bounds.both(one)
            tally.add((load.task.name, *key), checked, one.empty, left & bounds.empty)
    return bounds


def _least(
    found: Candidates,
    loads: Sequence[Load],
    rows: np.ndarray,
    bounds: Bounds,
    objective: Objective,
    shares: Mapping[str, float],
) -> np.ndarray:
    """Lower bound of the objective. (k,)"""
    if objective == "mass":
        return found.mass(rows)
    total = np.zeros(len(rows))
    for load in loads:
        if isinstance(load.task, MotionTask) and len(rows):
            total = total + shares[load.task.name] * least_power(found, load, rows, bounds)
    return total


def _best_first(
    search: RadiusSearch,
    rows: np.ndarray,
    bounds: Bounds,
    least: np.ndarray,
    top: int,
    *,
    all_of_them: bool,
    progress: Progress | None,
) -> tuple[list[Design], np.ndarray, np.ndarray]:
    """The best designs, in order; which pairs were evaluated, and their power."""
    evaluated, power = np.zeros(len(rows), dtype=bool), np.full(len(rows), np.nan)
    radius, worst = np.full(len(rows), np.nan), np.full(len(rows), np.nan)
    value, mass = np.full(len(rows), np.inf), search.found.mass(rows)
    order = np.argsort(least, kind="stable")
    while True:
        promising = least <= _to_beat(search.objective, value, mass, top)
        waiting = order[~evaluated[order] & (promising[order] | all_of_them)]
        some = waiting[:_AT_ONCE]
        if not some.size:
            break
        if progress is not None:
            first = int(np.argmin(value))
            known = np.isfinite(value[first])
            said = best_so_far(power[first], mass[first]) if known else best_so_far(np.nan, np.nan)
            progress(said, float(evaluated.sum() / (evaluated.sum() + len(waiting))))
        made = search.best(rows[some], Bounds(bounds.low[some], bounds.high[some]))
        able = made.done.feasible
        evaluated[some], radius[some], worst[some] = True, made.radius, made.done.worst
        power[some] = np.where(able, made.power, np.nan)
        value[some] = np.where(able, least[some] if search.objective == "mass" else made.power, np.inf)
    able = np.flatnonzero(np.isfinite(value))
    if search.objective == "front":
        best = able[front(mass[able], value[able])]
    else:
        best = able[np.lexsort((rows[able], worst[able], value[able]))][:top]
    return _designs(search, rows[best], radius[best], Bounds(bounds.low[best], bounds.high[best])), evaluated, power


def _to_beat(objective: Objective, value: np.ndarray, mass: np.ndarray, top: int) -> Any:
    """Value above which pairs are not among the best, whatever their radius; of a front, that of each pair's mass."""
    if objective != "front":
        return np.sort(value)[min(top, len(value)) - 1] if len(value) else np.inf
    order = np.argsort(mass)
    least = np.minimum.accumulate(value[order])
    return least[np.searchsorted(mass[order], mass, side="right") - 1] if len(value) else np.inf


def _designs(search: RadiusSearch, rows: np.ndarray, radius: np.ndarray, bounds: Bounds) -> list[Design]:
    """Pairs at feasible radii as designs."""
    if not rows.size:
        return []
    done, ends = search.at(rows, radius), search.ends(rows, radius, bounds)
    drawn = np.broadcast_to(mixed(done.power, search.shares), rows.shape)
    found = []
    for place, row in enumerate(rows):
        stage = Pulley(radius=float(radius[place]), friction_torque=search.pulley.friction_torque)
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
