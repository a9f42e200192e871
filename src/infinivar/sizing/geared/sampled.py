"""Demands and energy of candidates from every instant of a motion, by the laws of `duty_cycle` and `steady_map`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np

from infinivar._core.array_namespace import Array, namespace
from infinivar.analysis.cycles import performance
from infinivar.analysis.cycles.duty_cycle import warmed
from infinivar.analysis.cycles.performance import heating, motors_of
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import MOTOR_LIMITS, placed
from infinivar.limits import Demand, Limit
from infinivar.parts.heat import missing
from infinivar.parts.heat_steps import MARGIN, Windings, step_count, windings
from infinivar.parts.motor import Motor
from infinivar.parts.stage import OutputStage
from infinivar.sizing.geared.candidates import Candidates, Pairs
from infinivar.sizing.geared.tasks import MotionTask, RegionTask, Task, heat_counts
from infinivar.sizing.margins import TaskDemand

_POINTS = 40_000
"""Instants of all candidates computed at once, so that intermediate arrays fit the processor's caches."""

HOT = (Limit.TEMPERATURE, "motor")

UNCHECKED = -1.0
"""Demand of a limit that does not apply to a candidate, such as a temperature without thermal data."""


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

    def laws(places: np.ndarray) -> Laws:
        some = stage(places) if callable(stage) else stage
        return Laws(candidates.drives(rows[places], some), len(places))

    done = sample_by(candidates, rows, tasks, laws)
    sized = candidates.sized(rows, stage(np.arange(len(rows))) if callable(stage) else stage)
    fits = [demand <= 1.0 for demand in sized.values()]
    return done._replace(demands={**done.demands, **sized}, feasible=np.logical_and.reduce([done.feasible, *fits]))


def sample_by(
    candidates: Pairs, rows: np.ndarray, tasks: Sequence[Task], laws_of: Callable[[np.ndarray], TaskLaws]
) -> Sampled:
    """Evaluate candidates at every instant by laws, made for some of `rows` by place; other arguments as for `sample`."""
    demands: dict[TaskDemand, np.ndarray] = {}
    power = {task.name: np.empty(len(rows)) for task in tasks if isinstance(task, MotionTask)}
    feasible = np.ones(len(rows), dtype=bool)
    for places in batches(candidates, rows, tasks):
        laws = laws_of(places)
        for task in tasks:
            if isinstance(task, MotionTask):
                found, cool, power[task.name][places] = over_motion(laws, task)
                for one in cool.values():
                    feasible[places] &= one
            else:
                found = laws.within(task)
            for (limit, part), demand in found.items():
                key = task.name, limit, part
                demands.setdefault(key, np.full(len(rows), UNCHECKED))[places] = demand
                if limit != Limit.TEMPERATURE:  # judged with its own allowance for rounding
                    feasible[places] &= demands[key][places] <= 1.0
    return Sampled(demands, power, feasible)


def batches(candidates: Pairs, rows: np.ndarray, tasks: Sequence[Task]) -> Iterator[np.ndarray]:
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


class TaskLaws(Protocol):
    """What many candidates as one do in tasks."""

    count: int

    @property
    def motors(self) -> Mapping[str, Motor]: ...  # noqa: D102

    def heat_sources(self, task: MotionTask) -> Mapping[str, tuple[Array, Array]]: ...  # noqa: D102

    def over(self, task: MotionTask, warm: Mapping[str, Any]) -> tuple[dict[Demand, Array], Array]: ...  # noqa: D102

    def within(self, task: RegionTask) -> dict[Demand, Array]: ...  # noqa: D102


class Laws:
    """What many drives as one do in tasks, by the laws of the drive.

    Parameters
    ----------
    drive   With arrays of shape (count, 1) for values that differ.
    """

    def __init__(self, drive: ConventionalDrive | CoboticDrive, count: int) -> None:
        """Compute nothing yet."""
        self.drive, self.count = drive, count
        self._rolled: dict[str, Any] = {}

    @property
    def motors(self) -> Mapping[str, Motor]:
        """Motors by their name among the parts of a drive."""
        return motors_of(self.drive)

    def heat_sources(self, task: MotionTask) -> dict[str, tuple[Array, Array]]:
        """Current, and power of friction and iron loss, of each motor with thermal data while windings are cold. [A], [W]"""
        heated = [what for what, motor in self.motors.items() if not missing(motor)]
        point = self._follow(self.drive, task) if heated else None
        return {what: heating(point, what) for what in heated if point is not None}

    def over(self, task: MotionTask, warm: Mapping[str, Array]) -> tuple[dict[Demand, Array], Array]:
        """Demands over a motion and mean power, with windings at temperatures. [-], [W]"""
        point = self._follow(warmed(self.drive, warm), task)
        demands = performance.demands(point)
        xp = namespace(point.power_in)
        return demands, xp.mean(xp.broadcast_to(point.power_in, (self.count, len(task.instants.time))), axis=-1)

    def within(self, task: RegionTask) -> dict[Demand, Array]:
        """Largest demands at the points of the required region. [-]"""
        point = self.drive.operate(speed=task.speed, force=task.force)
        rest = self.drive.stage.title if isinstance(self.drive, ConventionalDrive) else "wheel"
        return {
            (limit, "motor" if limit in MOTOR_LIMITS else part): namespace(demand).max(demand, axis=-1)
            if np.ndim(demand)
            else demand
            for (limit, part), demand in placed(point.utilisation, rest).items()
        }

    def _follow(self, drive: ConventionalDrive | CoboticDrive, task: MotionTask) -> Any:
        course, mass = task.instants.course, task.duty.moved_mass
        if not isinstance(drive, CoboticDrive):
            return drive.follow(course, load_mass=mass)
        if task.name not in self._rolled:
            self._rolled[task.name] = drive.roll(course, load_mass=mass)
        return drive.follow(course, load_mass=mass, rolled=self._rolled[task.name])


def over_motion(
    laws: TaskLaws, task: MotionTask
) -> tuple[dict[Demand, np.ndarray], dict[Demand, np.ndarray], np.ndarray]:
    """Demands over a motion of many drives as one, whether each winding stays within its limit, and the mean power.

    Returns
    -------
    demands : by limit and part   (count,), or one number that all share. [-]
    cool : by limit and part      Of motors with thermal data; false where the motion has no solution. (count,) bool
    power : (count,) float        [W]
    """
    duty, shape = task.duty, (laws.count, len(task.instants.time))
    motors = laws.motors
    hot, warm = {}, {}
    for what, sources in laws.heat_sources(task).items():
        current, friction = (np.broadcast_to(np.asarray(part), shape) for part in sources)
        # Heat has no meaning where a wheel slips; slip itself is a demand beyond its allowance.
        lost = np.asarray(~np.isfinite(current).all(axis=-1))
        if lost.any():
            current, friction = (np.where(lost[..., None], 0.0, part) for part in (current, friction))
        start = None if duty.closed else duty.start
        found = windings(motors[what], current, friction, duty.period, duty.ambient, start)
        rise, cool = overheating(motors[what], task, found)
        hot[Limit.TEMPERATURE, what] = rise, cool & ~lost
        warm[what] = temperatures(motors[what], task, found)
    demands, power = laws.over(task, warm)
    for key, (rise, _) in hot.items():
        demands[key] = rise
        if heat_counts(task):
            del demands[Limit.THERMAL, key[1]]
    if task.travel is not None:
        demands[Limit.TRAVEL, "load"] = np.asarray(np.ptp(task.instants.position) / task.travel)
    return demands, {key: cool for key, (_, cool) in hot.items()}, power


def overheating(motor: Motor, task: MotionTask, hot: Windings) -> tuple[np.ndarray, np.ndarray]:
    """Rise over permissible rise of many windings, and whether each stays within its limit. (k,), (k,) bool"""
    duty, limit = task.duty, np.ravel(np.asarray(motor.max_winding_temperature))
    allowed = limit - duty.ambient
    rise = (hot.highest - duty.ambient) / np.where(allowed > 0.0, allowed, 1.0)
    cool = hot.highest <= limit * (1.0 + MARGIN)
    if duty.closed:
        cool = cool & (duty.ambient <= limit)
    return np.where(allowed > 0.0, rise, np.inf), cool


def temperatures(motor: Motor, task: MotionTask, hot: Windings) -> np.ndarray:
    """Winding temperature with which a motion counts: its mean, in a run that at each instant; at most the limit. [K]"""
    limit = np.asarray(motor.max_winding_temperature)
    if task.duty.closed:
        return np.minimum(hot.mean[:, None], limit)
    time = task.instants.time
    place = np.clip(np.searchsorted(hot.time, time, side="right") - 1, 0, len(hot.time) - 2)
    share = (time - hot.time[place]) / np.diff(hot.time)[place]
    return np.minimum(hot.history[:, place] * (1.0 - share) + hot.history[:, place + 1] * share, limit)
