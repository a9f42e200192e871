"""What a machine does in a task or on a path: inverse dynamics, steady points and limits; see `machine_tasks`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from infinivar import power
from infinivar._core.frozen import FrozenDict
from infinivar.analysis.machine_tasks import PathResult, TaskResult
from infinivar.analysis.tightest import ALIKE, tightest_of
from infinivar.errors import ParameterError, require
from infinivar.limits import LEADING, ROOT_MEAN_SQUARE, Demand
from infinivar.machines.course import MachineCourse, on_path, through, together
from infinivar.machines.machine import Machine, TaskPoint, as_machine
from infinivar.motion.machine_tasks import MachinePath, MachineTask

_PARTS = 100
"""Of a load, of which the number that is borne is looked for."""

_BETWEEN = 15
"""Points between the ends of a range of wrenches of one coordinate at which limits are judged."""


class _Placed(NamedTuple):
    """A task or path of a machine: instants (t,) of a path, motion with wrenches, and words for messages."""

    time: np.ndarray | None
    course: MachineCourse
    where: str

    @property
    def size(self) -> int:
        """Corners of a task, or instants of a path."""
        return self.course.wrench.shape[1]

    @property
    def loads(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Pose, twist and wrench (k, d) of its steady points: all of a path; of a task its own, and at rest also without load."""
        pose, twist, wrench = np.broadcast_arrays(self.course.pose[2], self.course.twist[2], self.course.wrench[2])
        if self.time is not None:
            return pose, twist, wrench
        if np.any(twist):
            return pose[:1], twist[:1], wrench[:1]
        return pose[[0, 0]], twist[[0, 0]], wrench[[0, 0]] * np.array([[1.0], [0.0]])


class Prepared:
    """Tasks and paths of a machine, by key, with what all machines of its geometry and moving masses have in common."""

    def __init__(self, drive: Any, tasks: Mapping[str, MachineTask | MachinePath]) -> None:
        """Place them, and side by side those that count more than steady points do, as a call has its own cost."""
        self._machine = as_machine(drive)
        self.placed = {key: _placed(self._machine, one) for key, one in tasks.items()}
        groups: dict[bool, list[str]] = {}
        for key, one in self.placed.items():
            groups.setdefault(_counts(self._machine, one.course), []).append(key)
        self._groups = [(keys, counted, self._ahead(keys, counted)) for counted, keys in groups.items()]

    def _ahead(self, keys: list[str], counted: bool) -> Any:
        course = together([self.placed[key].course for key in keys])
        return self._machine.carried(course) if counted and hasattr(self._machine, "carried") else course  # type: ignore[attr-defined]

    @property
    def carried(self) -> tuple[Any, dict[str, slice]]:
        """What the links of a machine carry in all tasks and on all paths side by side, and the instants of each."""
        ((keys, _, ahead),) = self._groups
        ends = np.cumsum([self.placed[key].size for key in keys]).tolist()
        return ahead, {key: slice(end - self.placed[key].size, end) for key, end in zip(keys, ends, strict=True)}

    def points(self, machine: Any) -> dict[str, tuple[TaskPoint, bool]]:
        """Points of each, of such a machine, and whether they count more than steady points do."""
        found: dict[str, tuple[TaskPoint, bool]] = {}
        for keys, counted, ahead in self._groups:
            if not counted:
                point = machine.perform(pose=ahead.pose[2], twist=ahead.twist[2], wrench=ahead.wrench[2])
            else:
                point = machine.along(ahead) if hasattr(machine, "carried") else machine.follow(ahead)
            parts = _parted(point, {key: self.placed[key].size for key in keys})
            found |= {key: (part, counted) for key, part in parts.items()}
        return {key: found[key] for key in self.placed}


def power_and_margin(drive: Any, prepared: Prepared) -> dict[str, tuple[float, float]]:
    """What decides between machines: `mean_power` [W] and `margin` of what `evaluated` returns, and nothing else."""
    found = {}
    for key, (point, _) in prepared.points(as_machine(drive)).items():
        one = prepared.placed[key]
        _audit(point, one.where)
        found[key] = float(np.mean(point.power_in if one.time is not None else point.power_in[0])), _margin(point, one)
    return found


def power_and_demands(drive: Any, prepared: Prepared) -> dict[str, tuple[float, dict[Demand, float]]]:
    """Mean power [W] and the largest demand over allowance on each limit, in each task and on each path."""
    found = {}
    for key, (point, _) in prepared.points(as_machine(drive)).items():
        one = prepared.placed[key]
        _audit(point, one.where)
        if one.time is not None:
            found[key] = float(np.mean(point.power_in)), _of_path(point)
        else:
            found[key] = float(point.power_in[0]), {of: float(np.max(row)) for of, row in point.demands.items()}
    return found


def _margin(point: TaskPoint, placed: _Placed) -> float:
    """Of a task or path."""
    if placed.time is not None:
        return tightest_of(_of_path(point))[1]
    return min(margin for _, margin in _of_corners(point, placed.size))


def evaluated(drive: Any, tasks: Mapping[str, MachineTask | MachinePath]) -> dict[str, TaskResult | PathResult]:
    """`perform_task` and `follow_path` of several tasks and paths, by key."""
    machine, prepared = as_machine(drive), Prepared(drive, tasks)
    placed, points = prepared.placed, prepared.points(machine)
    steady = {key: point for key, (point, counted) in points.items() if not counted}
    rest = {key: placed[key].loads for key in tasks if key not in steady}
    if rest:
        pose, twist, wrench = (np.concatenate(rows) for rows in zip(*rest.values(), strict=True))
        every = machine.perform(pose=pose, twist=twist, wrench=wrench)
        steady |= _parted(every, {key: len(row[0]) for key, row in rest.items()})
    found: dict[str, TaskResult | PathResult] = {}
    for key, one in tasks.items():
        make = _task_result if isinstance(one, MachineTask) else _path_result
        found[key] = make(machine, one, placed[key], points[key][0], steady[key])  # type: ignore[arg-type]
    return found


def _placed(machine: Machine, task: MachineTask | MachinePath) -> _Placed:
    names = machine.coordinates
    if isinstance(task, MachinePath):
        return _Placed(*on_path(task, names, machine.home), f"path {task.title!r}")
    for key, vector in task.vectors.items():
        for name in vector.beyond(names):
            raise ParameterError(f"{key}.{name} does not apply: the machine has {', '.join(names)} only")
    pose, twist, corners = task.pose.row(names, machine.home), task.twist.row(names), _judged(task.corners(names))
    return _Placed(None, through(pose, twist, names, corners), f"task {task.title!r}")


def _parted(point: TaskPoint, counts: Mapping[str, int]) -> dict[str, TaskPoint]:
    """Points side by side, by the key of each stretch of them."""
    if len(counts) == 1:
        return dict.fromkeys(counts, point)
    ends = np.cumsum(list(counts.values()))
    return {
        key: point.at(slice(end - count, end)) for (key, count), end in zip(counts.items(), map(int, ends), strict=True)
    }


def perform_task(drive: Any, task: MachineTask) -> TaskResult:
    """One machine, or drive of one axis, in a task: all losses, and limits at every corner of its polytope of wrenches.

    Raises
    ------
    ParameterError
        If the task states a coordinate that the machine does not have, or `drive` or `task` is something else.

    Notes
    -----
    Between the corners the demands of most machines are smaller: at one twist and pose they are convex in the wrench, as forces
    of links are linear in it. Where creep by spin changes with the load, as on a sphere, they need not be: a machine of one
    coordinate is judged at points between them, too.
    """
    kind = f"a {type(task).__name__}" + ("; write follow_path" if isinstance(task, MachinePath) else "")
    require(isinstance(task, MachineTask), "task", kind, "a MachineTask")
    return evaluated(drive, {"": task})[""]  # type: ignore[return-value]


def _task_result(machine: Any, task: MachineTask, placed: _Placed, every: TaskPoint, alone: TaskPoint) -> TaskResult:
    corners, twist = placed.course.wrench[2], placed.course.twist[2, 0]
    residual = _audit(every, placed.where)
    turns = work = float("nan")
    friction = getattr(machine, "steering_friction", float("nan"))
    if not np.any(twist) and np.isfinite(friction) and alone is not every:
        turned = np.abs(np.asarray(alone.steering)[0] - np.asarray(alone.steering)[1])
        turns, work = float(np.max(turned)), friction * float(np.sum(turned))
    tightest = _of_corners(every, len(corners))
    least = min(margin for _, margin in tightest)
    corner = next(place for place, (_, margin) in enumerate(tightest) if margin <= least * (1.0 + ALIKE))
    return TaskResult(
        title=task.title,
        coordinates=machine.coordinates,
        pose=placed.course.pose[2, 0],
        twist=twist,
        wrench=corners[0],
        corners=corners,
        point=every.at(0),
        steady=alone.at(0),
        demand=tightest[corner][0],
        margin=tightest[corner][1],
        corner=corner,
        bears=_bearable(machine, placed) if least < 1.0 else float("nan"),
        audit_residual=residual,
        load_turns=turns,
        load_work=work,
        battery=getattr(machine, "battery", None),
    )


def passing_point(machine: Machine, pose: np.ndarray, twist: np.ndarray, wrench: np.ndarray) -> TaskPoint:
    """A machine that passes through a pose at a twist under a wrench on its load, as a task has it: (d,) each."""
    return _performed(machine, through(pose, twist, machine.coordinates, wrench[None])).at(0)


def _performed(machine: Any, course: MachineCourse) -> TaskPoint:
    """A machine along a course: with all that it counts there, or at steady points."""
    if _counts(machine, course):
        return machine.follow(course)
    return machine.perform(pose=course.pose[2], twist=course.twist[2], wrench=course.wrench[2])


def _of_corners(point: TaskPoint, count: int) -> list[tuple[Demand, float]]:
    """The tightest limit and its margin at each corner of a task."""
    return [tightest_of({key: float(values[place]) for key, values in point.demands.items()}) for place in range(count)]


def _of_path(point: TaskPoint) -> dict[Demand, float]:
    """Demands over a path."""
    return {key: _over_time(key, np.asarray(values)) for key, values in point.demands.items()}


def _counts(machine: Any, course: MachineCourse) -> bool:
    """Whether a machine counts more along a course than steady points do."""
    counts = getattr(machine, "counts", None)
    return hasattr(machine, "follow") and (counts is None or counts(course))


def _audit(point: TaskPoint, where: str) -> float:
    """Largest residual of the power balance, in which what is stored within the machine is power out."""
    return power.audit(point.power_in, point.power_out + sum(point.stored.values()), point.losses, where)


def _judged(corners: np.ndarray) -> np.ndarray:
    """The wrenches at which a task is judged: the corners, and of one coordinate as many between them as show a maximum."""
    if corners.shape[-1] > 1 or len(corners) == 1:
        return corners
    between = np.linspace(np.min(corners), np.max(corners), _BETWEEN + 2)[1:-1]
    return np.concatenate([corners, between[~np.isin(between, corners[:, 0])][:, None]])


def follow_path(drive: Any, path: MachinePath) -> PathResult:
    """One machine, or drive of one axis, on a path: inverse dynamics at every instant, and steady operation beside it.

    The wrench accelerates the load. The jump of a steering angle where a link reverses, and the warming of windings, are left
    out.

    Raises
    ------
    ParameterError
        If `drive` or `path` is something else.
    """
    kind = f"a {type(path).__name__}" + ("; write perform_task" if isinstance(path, MachineTask) else "")
    require(isinstance(path, MachinePath), "path", kind, "a MachinePath")
    return evaluated(drive, {"": path})[""]  # type: ignore[return-value]


def _path_result(
    machine: Machine, path: MachinePath, placed: _Placed, point: TaskPoint, steady: TaskPoint
) -> PathResult:
    course = placed.course
    residual = _audit(steady, f"{placed.where}, steady")
    if point is not steady:
        residual = max(residual, _audit(point, placed.where))
    demands = _of_path(point)
    demand, margin = tightest_of(demands)
    return PathResult(
        title=path.title,
        per=path.per,
        coordinates=machine.coordinates,
        period=path.period,
        time=placed.time,  # type: ignore[arg-type]
        pose=course.pose[2],
        twist=course.twist[2],
        wrench=course.wrench[2],
        point=point,
        steady=steady,
        demands=FrozenDict(demands),
        demand=demand,
        margin=margin,
        instant=_worst_instant(demand, point),
        battery=getattr(machine, "battery", None),
        bears=_bearable(machine, placed) if margin < 1.0 else float("nan"),
        audit_residual=residual,
    )


def _worst_instant(demand: Demand, point: TaskPoint) -> int:
    """The instant at which a demand is the largest; -1 where it counts over the whole path, or there is none."""
    if demand[0] in ROOT_MEAN_SQUARE or demand not in point.demands:
        return -1
    values = np.asarray(point.demands[demand], dtype=float)
    return int(np.argmax(np.where(np.isnan(values), np.inf, values)))


def _bearable(machine: Any, placed: _Placed) -> float:
    """Share of the wrenches of a task or path with which all limits hold, rounded down; nan without any wrench.

    Of a load that is borne in part, the share next to that of no load.
    """
    course = placed.course
    if not np.any(course.wrench):
        return float("nan")

    def borne(part: int) -> bool:
        scaled = replace(course, wrench=course.wrench * (part / _PARTS))
        return _margin(_performed(machine, scaled), placed) >= 1.0

    if not borne(0):
        return 0.0
    low, high = 0, _PARTS
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if borne(middle) else (low, middle)
    return low / _PARTS


def _over_time(key: Demand, values: np.ndarray) -> float:
    """Demand over a path at equal steps; inf where it is undefined at an instant at which a wheel slips."""
    if key[0] in LEADING:
        return float(np.max(np.where(np.isnan(values), np.inf, values)))
    return float(np.sqrt(np.mean(values * values))) if key[0] in ROOT_MEAN_SQUARE else float(np.max(values))
