"""Demands and energy of candidates from every instant of a motion, by the laws of `duty_cycle` and `steady_map`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from infinivar.analysis.cycles import performance
from infinivar.analysis.cycles.duty_cycle import heating, warmed
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import placed
from infinivar.limits import Demand, Limit
from infinivar.parts.heat_steps import MARGIN, Windings, step_count, windings
from infinivar.parts.stage import OutputStage
from infinivar.sizing.geared.candidates import Candidates
from infinivar.sizing.geared.tasks import MotionTask, RegionTask, Task, heat_counts

_POINTS = 40_000
"""Instants of all candidates computed at once, so that intermediate arrays fit the processor's caches."""

HOT = (Limit.TEMPERATURE, "motor")

UNCHECKED = -1.0
"""Demand of a limit that does not apply to a candidate, such as a temperature without thermal data."""

TaskDemand = tuple[str, Limit, str]
"""Name of a task, limit and part."""


class Sampled(NamedTuple):
    """Results of some candidates, in their order."""

    demands: Mapping[TaskDemand, np.ndarray]
    """Demand over allowance; about 0 where the limit is not stated, `UNCHECKED` where it does not apply. (k,) [-]"""
    power: Mapping[str, np.ndarray]
    """Mean power from the supply by motion. (k,) [W]"""
    feasible: np.ndarray
    """Whether every limit is kept and no winding overheats. (k,) bool"""

    @property
    def worst(self) -> np.ndarray:
        """Largest demand over allowance of all limits. (k,) [-]"""
        return np.max(list(self.demands.values()), axis=0)


def sample(
    candidates: Candidates,
    rows: np.ndarray,
    tasks: Sequence[Task],
    stage: OutputStage | Callable[[np.ndarray], OutputStage],
) -> Sampled:
    """Evaluate candidates at every instant.

    Parameters
    ----------
    rows : (k,) int   Pairs; one may occur several times.
    tasks : sequence of Task
    stage             Of all of them; or a function that makes, for some of `rows` by place, a stage of columns.
    """
    demands: dict[TaskDemand, np.ndarray] = {}
    power = {task.name: np.empty(len(rows)) for task in tasks if isinstance(task, MotionTask)}
    feasible = np.ones(len(rows), dtype=bool)
    for places in _batches(candidates, rows, tasks):
        drive = candidates.drives(rows[places], stage(places) if callable(stage) else stage)
        for task in tasks:
            if isinstance(task, MotionTask):
                found, cool, power[task.name][places] = _over_motion(drive, task)
                feasible[places] &= cool
            else:
                found = _over_region(drive, task)
            for (limit, part), demand in found.items():
                key = task.name, limit, part
                demands.setdefault(key, np.full(len(rows), UNCHECKED))[places] = demand
                if limit != Limit.TEMPERATURE:  # judged with its own allowance for rounding
                    feasible[places] &= demands[key][places] <= 1.0
    return Sampled(demands, power, feasible)


def _batches(candidates: Candidates, rows: np.ndarray, tasks: Sequence[Task]) -> Iterator[np.ndarray]:
    """Yield places of candidates to be computed together: of motors with thermal data and equal steps, or without."""
    motions = [task for task in tasks if isinstance(task, MotionTask)]
    known = candidates.stated(HOT, rows)
    lag = np.where(known, candidates.values("motor", "winding_time_constant", rows), np.inf)
    # No steps of their own: motors without data belong together.
    counts = [np.where(known, step_count(lag, task.period, len(task.instants.time)), -1) for task in motions]
    together = np.stack([known, *counts], axis=-1)
    longest = max(len(task.instants.time if isinstance(task, MotionTask) else task.speed) for task in tasks)
    size = max(1, _POINTS // longest)
    _, group = np.unique(together, axis=0, return_inverse=True)
    group = np.ravel(group)
    order = np.argsort(group, kind="stable")
    for one in np.split(order, np.flatnonzero(np.diff(group[order])) + 1):
        for start in range(0, len(one), size):
            yield one[start : start + size]


def _over_motion(drive: ConventionalDrive, task: MotionTask) -> tuple[dict[Demand, np.ndarray], np.ndarray, np.ndarray]:
    """Demands over a motion, whether windings stay within their limit, and the mean power."""
    duty, course = task.duty, task.instants.course
    point = drive.follow(course, load_mass=duty.moved_mass)
    hot = None
    if drive.motor.max_winding_temperature is not None:
        current, friction = heating(point, "motor")
        start = None if duty.closed else duty.start
        hot = windings(drive.motor, np.asarray(current), np.asarray(friction), duty.period, duty.ambient, start)
        point = warmed(drive, {"motor": _temperatures(drive, task, hot)}).follow(course, load_mass=duty.moved_mass)
    found = performance.demands(point)
    cool = np.ones(len(np.ravel(drive.motor.resistance)), dtype=bool)
    if hot is not None:
        limit = np.ravel(np.asarray(drive.motor.max_winding_temperature))
        allowed = limit - duty.ambient
        rise = (hot.highest - duty.ambient) / np.where(allowed > 0.0, allowed, 1.0)
        found[HOT] = np.where(allowed > 0.0, rise, np.inf)
        cool = hot.highest <= limit * (1.0 + MARGIN)
        if duty.closed:
            cool = cool & (duty.ambient <= limit)
        if heat_counts(task):
            del found[Limit.THERMAL, "motor"]
    if task.travel is not None:
        found[Limit.TRAVEL, "load"] = np.asarray(np.ptp(task.instants.position) / task.travel)
    return found, cool, np.mean(np.broadcast_to(point.power_in, (len(cool), len(task.instants.time))), axis=-1)


def _temperatures(drive: ConventionalDrive, task: MotionTask, hot: Windings) -> np.ndarray:
    """Winding temperature with which a motion counts: its mean, in a run that at each instant; at most the limit. [K]"""
    limit = np.asarray(drive.motor.max_winding_temperature)
    if task.duty.closed:
        return np.minimum(hot.mean[:, None], limit)
    time = task.instants.time
    place = np.clip(np.searchsorted(hot.time, time, side="right") - 1, 0, len(hot.time) - 2)
    share = (time - hot.time[place]) / np.diff(hot.time)[place]
    return np.minimum(hot.history[:, place] * (1.0 - share) + hot.history[:, place + 1] * share, limit)


def _over_region(drive: ConventionalDrive, task: RegionTask) -> dict[Demand, np.ndarray]:
    """Largest demands at the points of the required region."""
    point = drive.operate(speed=task.speed, force=task.force)
    found = placed(point.utilisation, drive.stage.title)
    motor = {*drive.motor.utilisation(current=0.0, voltage=0.0, speed=0.0), Limit.REGENERATION}
    count = len(np.ravel(drive.motor.resistance))
    return {
        (limit, "motor" if limit in motor else part): np.broadcast_to(
            np.max(demand, axis=-1) if np.ndim(demand) else demand, (count,)
        )
        for (limit, part), demand in found.items()
    }
