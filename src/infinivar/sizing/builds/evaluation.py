"""Builds of a design: drives with other values, and what a study demands of them.

Of a required region the points that decide on the builds are found first, so that not all of its points are computed for each.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from infinivar._core.fields import quantities_of, value_at, with_values
from infinivar.analysis.robustness.derivatives import varied
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import with_rated_gear
from infinivar.parts.gearhead import Gearhead
from infinivar.parts.motor import Motor
from infinivar.sizing.cobotic.wheels import static_demands
from infinivar.sizing.geared.sampled import Laws, over_motion
from infinivar.sizing.geared.tasks import MotionTask, RegionTask, Task, judging_points
from infinivar.sizing.margins import TaskDemand

_POINTS, _LEAST = 40_000, 16
"""Instants of all builds computed at once, so that intermediate arrays fit the processor's caches; and least number of builds."""
_CONSTANTS = ("torque_constant", "resistance")


class BuildResults(NamedTuple):
    """Results of some builds, in their order."""

    demands: Mapping[TaskDemand, np.ndarray]
    """Demand over allowance. (k,) [-]"""
    exceeded: Mapping[TaskDemand, np.ndarray]
    """Whether the limit is exceeded, with the allowance for rounding of winding temperatures. (k,) bool"""
    power: np.ndarray
    """Mean power from the supply over all motions, by their shares of time; nan without a motion. (k,) [W]"""
    feasible: np.ndarray
    """Whether all limits are kept. (k,) bool"""


def built(drive: Any, values: Mapping[str, Any]) -> Any:
    """The drive with other values at dotted paths, as a machine made with these would be.

    Motors keep friction torque, permissible winding loss and peak current (`Motor.specimen`). Constant gear friction is stated at
    the rated torque of the type. A gear that loses more while driving loses more in proportion while driven.
    """
    drive = with_rated_gear(drive)
    motors = {
        path.removesuffix(".torque_constant")
        for path in quantities_of(drive)
        if path.endswith(".torque_constant") and isinstance(value_at(drive, path.rpartition(".")[0]), Motor)
    }
    ours = {f"{motor}.{name}" for motor in motors for name in _CONSTANTS}
    others = {path: value for path, value in values.items() if path not in ours}
    drive = varied(drive, {**_backwards(drive, others), **others})
    made = {}
    for path in motors:
        if not any(f"{path}.{name}" in values for name in _CONSTANTS):
            continue
        motor = value_at(drive, path)
        constants = {name: values.get(f"{path}.{name}", getattr(motor, name)) for name in _CONSTANTS}
        made[path] = motor.specimen(**constants)
    return with_values(drive, made)


def _backwards(drive: Any, values: Mapping[str, Any]) -> dict[str, Any]:
    """Efficiency while the load drives, where it is stated beside one that varies."""
    forward, back = "gearhead.efficiency", "gearhead.backdriving_efficiency"
    if forward not in values or back in values or drive.gearhead.backdriving_efficiency is None:
        return {}
    lost = (1.0 - values[forward]) / (1.0 - drive.gearhead.efficiency)
    return {back: np.maximum(1.0 - lost * (1.0 - drive.gearhead.backdriving_efficiency), 0.0)}


def judge(laws: Laws, tasks: Sequence[Task], shares: Mapping[str, float]) -> BuildResults:
    """Judge many builds as one drive.

    Parameters
    ----------
    tasks : sequence of Task   Motions and the required region.
    shares : mapping           Share of time of each motion. [-]
    """
    drive, count = laws.drive, laws.count
    demands: dict[TaskDemand, np.ndarray] = {}
    exceeded: dict[TaskDemand, np.ndarray] = {}
    power = np.zeros(count) if shares else np.full(count, np.nan)
    feasible = np.ones(count, dtype=bool)
    if isinstance(drive, CoboticDrive):
        demands |= static_demands(drive, count)
    for task in tasks:
        if isinstance(task, MotionTask):
            found, cool, drawn = over_motion(laws, task)
            power = power + shares[task.name] * drawn
            exceeded |= {(task.name, *key): ~np.broadcast_to(one, (count,)) for key, one in cool.items()}
        else:
            found = laws.within(task)
        demands |= {
            (task.name, limit, part): np.broadcast_to(demand, (count,)) for (limit, part), demand in found.items()
        }
    for key, demand in demands.items():
        # What has no value where a wheel slips counts there by the slip alone.
        exceeded.setdefault(key, demand > 1.0)
        feasible &= ~exceeded[key] & ~np.isnan(demand)
    return BuildResults(demands, exceeded, power, feasible)


def points(task: Task) -> int:
    """Number of instants of a motion, or of points of a required region."""
    return len(task.instants.time if isinstance(task, MotionTask) else task.speed)


def at_once(tasks: Sequence[Task]) -> int:
    """Number of builds to compute together."""
    return max(_LEAST, _POINTS // max(map(points, tasks)))


def decisive(drive: Any, tasks: Sequence[Task], values: Mapping[str, np.ndarray]) -> tuple[Task, ...]:
    """The tasks, with the required region at those of its points that can have the largest demand in some build.

    Demands on motor and gearhead are convex in torque and speed of the output of a gear. In a geared drive they are largest at
    corners of the hull of these; in a cobotic drive, whose cylinder speed is constant, at the ends of the cylinder's torque. No
    motor or gearhead changes either. What others change is looked at with the values of the design, and at both ends of each
    other value's samples; the points that decide there count.
    """
    return tuple(task if isinstance(task, MotionTask) else _decisive(drive, task, values) for task in tasks)


def _decisive(drive: Any, task: RegionTask, values: Mapping[str, np.ndarray]) -> RegionTask:
    if drive.amplifier.regeneration == "none":
        return task  # a little power returned is too much: where that is depends on motor and gearhead
    if not isinstance(drive, ConventionalDrive):
        task = judging_points(task)  # demands of a wheel are largest there, see `outer`
    keep: list[np.ndarray] = []
    for probe in _probes(drive, values):
        if isinstance(probe, ConventionalDrive):
            keep.append(_places(task, task.critical(probe, probe.stage)))
        else:
            keep.append(_extremes(probe, task))
    places = np.unique(np.concatenate(keep))
    return replace(task, speed=task.speed[places], force=task.force[places])


def _probes(drive: Any, values: Mapping[str, np.ndarray]) -> Iterator[Any]:
    """The design, and the design with each value that is neither of a motor nor of a gearhead at both ends."""
    yield drive
    for path, samples in values.items():
        owner = path.rpartition(".")[0]
        if not owner or not isinstance(value_at(drive, owner), Motor | Gearhead):
            for end in (np.min(samples), np.max(samples)):
                yield built(drive, {path: float(end)})


def _extremes(drive: Any, task: RegionTask) -> np.ndarray:
    """Places of the largest demand of each limit, and of the largest torque of the cylinder in both directions."""
    point = drive.operate(speed=task.speed, force=task.force)
    torque = np.asarray(point.states["cylinder_torque_Nm"])
    columns = [torque, -torque, *(np.asarray(one) for one in point.utilisation.values())]
    return np.array(
        [np.argmax(np.where(np.isnan(one), -np.inf, one)) for one in columns if np.shape(one) == task.speed.shape]
    )


def _places(task: RegionTask, some: RegionTask) -> np.ndarray:
    """Places in a task of the points of a part of it."""
    whole, part = (one.speed + 1j * one.force for one in (task, some))
    order = np.argsort(whole)
    return order[np.searchsorted(whole, part, sorter=order)]
