"""The candidate that comes nearest to keeping all limits, where none keeps them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from infinivar.parts.linear import Pulley
from infinivar.parts.stage import OutputStage
from infinivar.sizing.geared.at_stages import closed_forms
from infinivar.sizing.geared.candidates import Candidates
from infinivar.sizing.geared.over_radius import RadiusSearch, nodes, ordered
from infinivar.sizing.geared.radius_bounds import Bounds
from infinivar.sizing.geared.radius_limits import load_of, region_points
from infinivar.sizing.geared.ranking import design, mixed
from infinivar.sizing.geared.regeneration import returning, union, windows
from infinivar.sizing.geared.result import Design
from infinivar.sizing.geared.sampled import Sampled, sample
from infinivar.sizing.geared.tally import Tally
from infinivar.sizing.geared.tasks import MotionTask, RegionTask, Task

_EVALUATED = 64
"""Candidates that are evaluated at every instant."""


def nearest_stage(
    found: Candidates, tasks: Sequence[Task], stages: Sequence[OutputStage], shares: Mapping[str, float]
) -> Design | None:
    """The candidate at one of some stages; see `nearest_geared`."""
    if not found.usable.size:
        return None
    ranking = _of_candidates(tasks)
    demand = np.stack([_bound(found, ranking, stage) for stage in stages])
    stage_of, best = np.argmin(demand, axis=0), np.min(demand, axis=0)
    first = np.argsort(best, kind="stable")[:_EVALUATED]
    least, chosen = np.inf, None
    for place in np.unique(stage_of[first]):
        rows = found.usable[first[stage_of[first] == place]]
        worst = _missed(sample(found, rows, ranking, stages[place]), tasks)
        if worst.min() < least:
            least, chosen = float(worst.min()), (int(rows[np.argmin(worst)]), stages[place])
    return None if chosen is None else _design(found, *chosen, tasks, shares)


def _missed(done: Sampled, tasks: Sequence[Task]) -> np.ndarray:
    """Largest demands in their order; inf for candidates that keep all limits, unless it is the travel that all exceed."""
    kept = done.feasible & (not any(isinstance(task, MotionTask) and task.exceeds_travel for task in tasks))
    return np.where(kept, np.inf, ordered(done))


def nearest_over_radius(
    found: Candidates, tasks: Sequence[Task], radii: tuple[float, float], shares: Mapping[str, float]
) -> Design | None:
    """The candidate at its best radius; see `nearest_geared`."""
    pulley = found.template.pulley
    assert pulley is not None
    if not found.usable.size:
        return None
    tried = nodes(*(np.array([end]) for end in radii))[0]
    stages = [replace(pulley, radius=float(radius)) for radius in tried]
    ranking = _of_candidates(tasks)
    best = np.min([_bound(found, ranking, stage) for stage in stages], axis=0)
    rows = found.usable[np.argsort(best, kind="stable")[:_EVALUATED]]
    judged = tuple(region_points(task, found.template) if isinstance(task, RegionTask) else task for task in ranking)
    search = RadiusSearch(found, judged, "mass", shares)
    whole = Bounds(*(np.full(len(rows), end) for end in radii))
    made = search.best(rows, whole)
    worst = _missed(made.done, tasks)
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
            worst = _missed(made.done, tasks)
    first = int(np.argmin(worst))
    if np.isinf(worst[first]):
        return None
    stage = Pulley(radius=float(made.radius[first]), friction_torque=pulley.friction_torque)
    return _design(found, int(rows[first]), stage, tasks, shares)


def _of_candidates(tasks: Sequence[Task]) -> tuple[Task, ...]:
    """The tasks without the travel, which is the same for all candidates."""
    return tuple(replace(task, travel=None) if isinstance(task, MotionTask) else task for task in tasks)


def _bound(found: Candidates, tasks: Sequence[Task], stage: OutputStage) -> np.ndarray:
    """Lower bound of the largest demand over allowance of the usable pairs, by closed forms; inf out of reach. (k,)"""
    worst, tally = np.zeros(len(found.usable)), Tally(found)
    for task in tasks:
        here = task.critical(found.template, stage) if isinstance(task, RegionTask) else task
        for key, demand in closed_forms(found, here, stage):
            counted = np.where(np.isnan(demand), np.inf, demand)
            worst = np.maximum(worst, np.where(tally.checked(task, key, found.usable), counted, 0.0))
    return worst


def _design(
    found: Candidates, row: int, stage: OutputStage, tasks: Sequence[Task], shares: Mapping[str, float]
) -> Design | None:
    """A pair at a stage; None if it is out of reach."""
    done = sample(found, np.array([row]), tasks, stage)
    if np.isnan([demand[0] for demand in done.demands.values()]).any():
        return None
    return design(found, row, stage, done, 0, float(np.ravel(mixed(done.power, shares))[0]))
