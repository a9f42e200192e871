"""Points of a required region that decide on the builds of a design, so that not all of its points are computed for each."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from infinivar._core.fields import value_at
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.parts.gearhead import Gearhead
from infinivar.parts.motor import Motor
from infinivar.sizing.builds.judged import built
from infinivar.sizing.geared.tasks import MotionTask, RegionTask, Task


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
