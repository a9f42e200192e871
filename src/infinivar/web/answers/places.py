"""Where a drive of a study is looked at: at a speed and force, or in a task of its end point."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from infinivar.analysis.performing import passing_point
from infinivar.analysis.tightest import vector_words
from infinivar.drivetrain.drive import axis_of, is_machine, operated
from infinivar.errors import InputError, nearest
from infinivar.machines.machine import as_machine
from infinivar.motion.machine_tasks import MachineTask
from infinivar.study.study import Study
from infinivar.units import plain
from infinivar.web.answers import payload
from infinivar.web.answers.answer import RefusedError

Row = tuple[float, ...]

_LARGEST = 1e9
"""Largest speed and force that a page may ask for. [m/s], [N] or about a joint"""


@dataclass(frozen=True)
class Place:
    """One drive of a study at one place.

    Attributes
    ----------
    name, title, drive   Of the study.
    speed, force         Of the load, of a drive of one axis. [m s^-1], [N] or about a joint
    pose, twist, wrench  Of the end point, if the place is a task, or the drive a machine; else None.
    """

    name: str
    title: str
    drive: Any
    speed: float = 0.0
    force: float = 0.0
    pose: np.ndarray | None = None
    twist: np.ndarray | None = None
    wrench: np.ndarray | None = None
    task: str = ""

    @property
    def in_task(self) -> bool:
        """Whether it is a task, or a machine."""
        return self.pose is not None

    def point(self) -> Any:
        """The operation: a steady `DrivePoint`, or in a task a `TaskPoint` with steering, as comparisons have them."""
        if self.pose is None:
            return operated(self.drive, speed=self.speed, force=self.force)
        rows = (self.pose, self.twist, self.wrench)
        return _performed(as_machine(self.drive), *(tuple(map(float, row)) for row in rows))  # type: ignore[arg-type]

    @property
    def words(self) -> str:
        """The place in words, such as "40 N at 0.3 m/s"."""
        if self.pose is None:
            axis = axis_of(self.drive)
            return f"{plain(self.force, 3)} {axis.force_unit} at {plain(self.speed, 3)} {axis.speed_unit}"
        names = as_machine(self.drive).coordinates
        load = ", ".join(vector_words(names, self.wrench, "wrench")) or "no load"  # type: ignore[arg-type]
        motion = ", ".join(vector_words(names, self.twist, "twist"))  # type: ignore[arg-type]
        return f"{load}; {motion or 'at rest'}"


@functools.lru_cache(maxsize=64)
def _performed(machine: Any, pose: Row, twist: Row, wrench: Row) -> Any:
    """A machine in a task; kept, as several views ask for it, and a sphere between rollers takes its time."""
    return passing_point(machine, np.array(pose), np.array(twist), np.array(wrench))


def place_of(study: Study, request: Mapping[str, Any]) -> Place:
    """The place that a request names: `drive`, and `speed` and `force`, or `task`.

    Parameters
    ----------
    study : Study
    request : mapping   drive: name, by default the first; task: name of a task of the study; speed, force: of a drive of one axis
        without a task. [m s^-1], [N] or about a joint. A machine without a task is at rest at home.

    Raises
    ------
    InputError
        If a name is unknown.
    RefusedError
        If a value is of another kind than a page sends.
    """
    name = payload.text(request, "drive", next(iter(study.drives)))
    drive, title = study.drive(name), study.titles[name]
    task = payload.text(request, "task", "") or (next(iter(study.tasks), "") if is_machine(drive) else "")
    if task:
        if task not in study.tasks:
            tasks = f"its tasks: {', '.join(study.tasks)}" if study.tasks else "it has none"
            raise InputError(f"the study has no task {task!r}{nearest(task, study.tasks)}; {tasks}")
        return _in_task(name, title, drive, study.tasks[task])
    if is_machine(drive):
        still = np.zeros(len(drive.coordinates))
        return Place(name, title, drive, pose=np.array(drive.home, dtype=float), twist=still, wrench=still)
    return Place(name, title, drive, _number(request, "speed"), _number(request, "force"))


def _number(requested: Mapping[str, Any], key: str) -> float:
    """A speed or force of a request, which must be one of a machine: squares of larger ones exceed all numbers."""
    value = payload.number(requested, key)
    if abs(value) > _LARGEST:
        raise RefusedError(f"{key} must be from {-_LARGEST:g} to {_LARGEST:g}")
    return value


def _in_task(name: str, title: str, drive: Any, task: MachineTask) -> Place:
    """A machine, or drive of one axis, in a task, under the task's own wrench."""
    machine = as_machine(drive)
    names = machine.coordinates
    for key, vector in task.vectors.items():
        for other in vector.beyond(names):
            raise InputError(f"tasks: {key}.{other} does not apply: {title} has {', '.join(names)} only")
    pose, twist, wrench = task.pose.row(names, machine.home), task.twist.row(names), task.corners(names)[0]
    return Place(name, title, drive, pose=pose, twist=twist, wrench=wrench, task=task.title)
