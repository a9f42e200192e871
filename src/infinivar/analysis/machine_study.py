"""Simulate machines of a study on their paths and in their tasks: platforms and arms, with legs or separate motors, and spheres.

A path is followed for two periods, of which the first settles; one that does not repeat, once. A task is held, or passed through
at its twist with its pose in the middle, for the machine's `held_time`, of which the first half settles. Wheels start at the
angles that hold the wrench against creep, with the pose error by which the controllers command them. What accelerates the load
is inertia of the machine here, not a part of the wrench.
Platforms and arms follow the pose in closed loops. The steering angles of a sphere are prescribed: those of steady operation.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from infinivar._core.fields import given
from infinivar.analysis.machine_motion import simulate_machine
from infinivar.analysis.machine_run import MachineRun
from infinivar.drivetrain.drive import axis_of, commands_of, is_machine, type_words
from infinivar.errors import ParameterError
from infinivar.machines.course import passing
from infinivar.machines.kind import MachineDrive
from infinivar.motion.machine_tasks import MachinePath, MachineTask

_STEPS = 200
"""Of a steady motion in a task."""


def simulated(
    drive: Any,
    task: MachinePath | MachineTask,
    *,
    title: str = "",
    progress: Callable[[float], None] | None = None,
) -> MachineRun:
    """Simulate a machine on a path or in a task; see the module.

    Parameters
    ----------
    drive : PlatformDrive, ArmDrive or SphereDrive   With the masses that motion requires.
    task : MachinePath or MachineTask
    title : str                         Name for reports.
    progress : callable                 Called with the share done.

    Returns
    -------
    MachineRun

    Raises
    ------
    ParameterError
        If the machine cannot be simulated or lacks a value that motion requires, or the path leaves its reach.

    Source: faulring2006, section V, for plants and controllers.
    """
    check_moves(drive)
    for name in task.beyond(drive.coordinates) if isinstance(task, MachinePath) else ():
        raise ParameterError(f"{name} is no coordinate of the machine, which has {', '.join(drive.coordinates)}")
    if isinstance(task, MachinePath):
        machine = drive.moving(given(task.load_mass, 0.0), given(task.load_inertia, 0.0))
        time, pose, wrench = _along(drive, task)
    else:
        machine = drive.moving()
        time, pose, wrench = _through(drive, task)
    closed = isinstance(task, MachineTask) or task.closed
    scenario = drive.scenario(machine, time, pose, wrench, closed)
    return simulate_machine(machine, scenario, title=title, progress=progress)


def check_moves(drive: Any, where: str = "drive") -> None:
    """Raise ParameterError unless a drive is a platform, arm or sphere; the message says what works.

    Parameters
    ----------
    drive : object
    where : str      Path of the drive, such as "drives.cart".
    """
    if hasattr(drive, "scenario"):
        return
    if not is_machine(drive):
        moves = "about one joint" if axis_of(drive).rotary else "along one axis"
        raise ParameterError(f"{where} moves {moves}: simulate it with --scenario, in a study with [scenarios.NAME]")
    why = getattr(drive, "unmoved", MachineDrive.unmoved)
    raise ParameterError(f"{where} is a machine of type {type_words(drive)}: {why}; {commands_of(drive)}")


def _along(drive: Any, path: MachinePath) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Instants of a path, twice over if it repeats, with poses and wrenches on the load."""
    bare = replace(path, load_mass=None, load_inertia=None)
    count = len(bare.instants(drive.coordinates, drive.home).time)
    once = np.linspace(0.0, path.period, count + 1)
    if path.closed:
        once = once[:-1]
    found = bare.at(once, drive.coordinates, drive.home)
    if not path.closed:
        return once, found.pose, found.wrench
    time = np.concatenate([once, path.period + once, [2.0 * path.period]])
    pose, wrench = (np.concatenate([row, row, row[:1]]) for row in (found.pose, found.wrench))
    return time, pose, wrench


def _through(drive: Any, task: MachineTask) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Instants of a steady motion with the pose of the task in its middle, as `_along`."""
    names = drive.coordinates
    held: float = drive.held_time
    time = np.linspace(0.0, held, _STEPS + 1)
    pose = passing(task.pose.row(names, drive.home), task.twist.row(names), names, time - 0.5 * held)
    return time, pose, np.tile(task.wrench.row(names), (len(time), 1))
