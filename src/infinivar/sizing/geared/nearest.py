"""The candidate that comes nearest to keeping all limits, where none keeps them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from infinivar.parts.stage import OutputStage
from infinivar.sizing.found import Design
from infinivar.sizing.geared.at_stages import closed_forms
from infinivar.sizing.geared.candidates import Candidates
from infinivar.sizing.geared.over_radius import RadiusSearch, nodes
from infinivar.sizing.geared.radius_bounds import Radii
from infinivar.sizing.geared.radius_limits import load_of, region_points
from infinivar.sizing.geared.regeneration import returning, union, windows
from infinivar.sizing.geared.sampled import Sampled, sample
from infinivar.sizing.geared.tally import Tally, design, mixed
from infinivar.sizing.geared.tasks import MotionTask, RegionTask, Task, without_travel
from infinivar.sizing.margins import nearest_of, shortfalls
from infinivar.sizing.tables import GearedRequest

_EVALUATED = 64
"""Candidates that are evaluated at every instant."""
_DIGITS = 6
"""Of logarithms of demands: those that differ by less count as equal, see `SAME`."""


def nearest_stage(found: Candidates, tasks: Sequence[Task], request: GearedRequest) -> Design | None:
    """The candidate at one of some stages; see `nearest_geared`."""
    stages = request.stages or (found.template.stage,)
    if not found.usable.size:
        return None
    ranking = without_travel(tasks)
    first, stage_of = _first(found, ranking, stages)
    tried: list[_Tried] = []
    for place in np.unique(stage_of[first]):
        rows = found.usable[first[stage_of[first] == place]]
        tried.append(_missed(rows, np.full(len(rows), place), sample(found, rows, ranking, stages[place]), tasks))
    chosen = _nearest(found, _joined(tried))
    if chosen is None:
        return None
    row, place = chosen
    return _design(found, row, stages[int(place)], tasks, request.shares)


def nearest_over_radius(found: Candidates, tasks: Sequence[Task], request: GearedRequest) -> Design | None:
    """The candidate at its best radius; see `nearest_geared`."""
    pulley, radii = found.template.pulley, request.radius
    assert pulley is not None
    assert radii is not None
    if not found.usable.size:
        return None
    tried = nodes(*(np.array([end]) for end in radii))[0]
    stages = [replace(pulley, radius=float(radius)) for radius in tried]
    ranking = without_travel(tasks)
    rows = found.usable[_first(found, ranking, stages)[0]]
    judged = tuple(region_points(task, found.template) if isinstance(task, RegionTask) else task for task in ranking)
    search = RadiusSearch(found, judged, "mass", request.shares)
    whole = Radii(*(np.full(len(rows), end) for end in radii))
    made = search.best(rows, whole)
    if found.template.amplifier.regeneration == "none":
        loads = [load_of(found, task, radii) for task in judged]
        gaps = [
            union(np.concatenate(all_of))
            for all_of in zip(*(returning(found, load, rows) for load in loads), strict=True)
        ]
        places, left = windows(gaps, whole)
        if places.size:
            rows = rows[places]
            made = search.best(rows, left)
    chosen = _nearest(found, _missed(rows, made.radius, made.done, tasks))
    if chosen is None:
        return None
    row, radius = chosen
    return _design(found, row, replace(pulley, radius=radius), tasks, request.shares)


class _Tried(NamedTuple):
    """Infeasible candidates that were evaluated. (k,) each"""

    rows: np.ndarray
    where: np.ndarray
    """Radius, or place of the stage."""
    beyond: np.ndarray
    """See `shortfalls`. (m, k)"""


def _missed(rows: np.ndarray, where: np.ndarray, done: Sampled, tasks: Sequence[Task]) -> _Tried:
    """Those of some candidates that exceed a limit, or all if all exceed the travel."""
    short = any(isinstance(task, MotionTask) and task.exceeds_travel for task in tasks)
    beyond = np.flatnonzero(~done.feasible | short)
    return _Tried(rows[beyond], where[beyond], shortfalls(list(done.demands.values()))[:, beyond])


def _joined(parts: Sequence[_Tried]) -> _Tried:
    """Candidates at several stages, of which one may have limits that another has not."""
    most = max(len(one.beyond) for one in parts)
    beyond = [np.pad(one.beyond, ((0, most - len(one.beyond)), (0, 0)), constant_values=1.0) for one in parts]
    rows, where = (np.concatenate([getattr(one, name) for one in parts]) for name in ("rows", "where"))
    return _Tried(rows, where, np.concatenate(beyond, axis=1))


def _nearest(found: Candidates, tried: _Tried) -> tuple[int, float] | None:
    """Row, and radius or place of the stage, of the candidate that comes nearest; None if there is none."""
    if not tried.rows.size:
        return None
    first = nearest_of(tried.beyond, found.mass(tried.rows))
    return int(tried.rows[first]), float(tried.where[first])


def _first(found: Candidates, tasks: Sequence[Task], stages: Sequence[OutputStage]) -> tuple[np.ndarray, np.ndarray]:
    """Usable pairs that closed forms rank first, and for all of them the best stage.

    Returns
    -------
    first : (n,) int      Places among the usable pairs, in rising order.
    stage_of : (k,) int   Place of the stage.
    """
    best, stage_of = _bounds(found, tasks, stages[0]), np.zeros(len(found.usable), dtype=int)
    for place, stage in enumerate(stages[1:], 1):
        here = _bounds(found, tasks, stage)
        best, here = (
            np.pad(one, ((0, max(len(best), len(here)) - len(one)), (0, 0)), constant_values=0.0)
            for one in (best, here)
        )
        differs = np.argmax(best != here, axis=0)[None]
        nearer = np.take_along_axis(here, differs, 0)[0] < np.take_along_axis(best, differs, 0)[0]
        best, stage_of = np.where(nearer, here, best), np.where(nearer, place, stage_of)
    mass = np.nan_to_num(found.mass(found.usable), nan=np.inf)
    return np.sort(np.lexsort((mass, *best[::-1]))[:_EVALUATED]), stage_of


def _bounds(found: Candidates, tasks: Sequence[Task], stage: OutputStage) -> np.ndarray:
    """Logarithms of lower bounds of what `shortfalls` of the usable pairs gives, by closed forms. (m, k)"""
    demands, tally = list(found.sized(found.usable, stage).values()), Tally(found)
    for task in tasks:
        here = task.critical(found.template, stage) if isinstance(task, RegionTask) else task
        for key, demand in closed_forms(found, here, stage, all_of_them=True):
            demands.append(np.where(tally.checked(task, key, found.usable), demand, 0.0))
    return np.round(np.log(shortfalls(demands)), _DIGITS)


def _design(
    found: Candidates, row: int, stage: OutputStage, tasks: Sequence[Task], shares: Mapping[str, float]
) -> Design | None:
    """A pair at a stage; None if it is out of reach."""
    done = sample(found, np.array([row]), tasks, stage)
    if np.isnan([demand[0] for demand in done.demands.values()]).any():
        return None
    return design(found, row, stage, done, 0, float(np.ravel(mixed(done.power, shares))[0]))
