"""Simulate machines of a study on their paths and in their tasks: platforms and arms, with legs or separate motors, and spheres.

A path is followed for two periods, of which the first settles; one that does not repeat, once. A task is held, or passed through
at its twist with its pose in the middle, for `HELD`, of which the first half settles. Wheels start at the angles that hold the
wrench against creep, with the pose error by which the controllers command them. The wrenches of tasks and paths are those on
the load; the user exerts the opposite on the machine. What accelerates the load is inertia of the machine here, not a wrench.
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
from infinivar.drivetrain.drive import EVERY_MACHINE, axis_of, is_machine, type_words
from infinivar.errors import ParameterError
from infinivar.machines.control import loops as control
from infinivar.machines.course import passing
from infinivar.machines.kinds.planar import PlanarDrive
from infinivar.machines.kinds.platform import ArmDrive, PlatformDrive
from infinivar.machines.kinds.sphere import SphereDrive
from infinivar.machines.many_legs import LeggedDrive
from infinivar.motion.histories import VectorHistory
from infinivar.motion.machine_scenario import MachineScenario
from infinivar.motion.machine_tasks import MachinePath, MachineTask
from infinivar.transmission.configuration import Configuration

HELD = 0.2
"""Time for which a task is simulated. [s]"""

_STEPS = 200
"""Of a steady motion in a task."""


def simulated(
    drive: Any,
    asked: MachinePath | MachineTask,
    *,
    title: str = "",
    progress: Callable[[float], None] | None = None,
) -> MachineRun:
    """Simulate a machine on a path or in a task; see the module.

    Parameters
    ----------
    drive : PlatformDrive, ArmDrive or SphereDrive   With the masses that motion requires.
    asked : MachinePath or MachineTask
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
    for name in asked.beyond(drive.coordinates) if isinstance(asked, MachinePath) else ():
        raise ParameterError(f"{name} is no coordinate of the machine, which has {', '.join(drive.coordinates)}")
    if isinstance(asked, MachinePath):
        machine = drive.moving(given(asked.load_mass, 0.0), given(asked.load_inertia, 0.0))
        time, pose, wrench = _along(drive, asked)
    else:
        machine = drive.moving()
        time, pose, wrench = _through(drive, asked)
    if isinstance(drive, SphereDrive):
        scenario = _of_sphere(drive, machine, time, pose, wrench, isinstance(asked, MachineTask) or asked.closed)
        return simulate_machine(machine, scenario, title=title, progress=progress)
    duration = float(time[-1])
    # The wrench acts at the pose to follow; the pose error is small beside the machine.
    followed, forces = drive.followed(pose, wrench)
    if not np.all(np.isfinite(followed)):
        raise ParameterError(f"the motion leaves the reach of the machine of type {type_words(drive)}")
    closed = isinstance(asked, MachineTask) or asked.closed
    motion = VectorHistory(time=time, values=followed)
    scenario = MachineScenario(
        duration=duration,
        motion=motion,
        pose=None if drive.legs is None else list(_started(drive.legs, machine, motion, forces[0])),
        wrench=VectorHistory(time=time, values=forces, smooth=False) if np.any(forces) else None,
        settling_time=0.5 * duration if closed else None,
    )
    return simulate_machine(machine, scenario, title=title, progress=progress)


def _started(legs: LeggedDrive, machine: Any, motion: VectorHistory, force: np.ndarray) -> np.ndarray:
    r"""Configuration at the start at which the controllers command the angles that hold a force against creep.

    They command :math:`-R\omega\tan\phi = J(\xi + k\,e)` by the pose error e, so that
    :math:`k\,e = -J^{-1} R\omega\tan\phi - \xi`. Without it the wheels would first have to turn there.
    """
    mechanics = machine.mechanics(1.0)
    pose, twist = control.pose_twist(mechanics.load, motion, 0.0)
    jacobian = mechanics.load.at(pose[None], twist[None]).jacobian[0]
    held = legs.operate(Configuration(jacobian=jacobian), wrench=force, twist=twist).legs.steering_tangent
    surface = mechanics.transmission.cylinder_radius * machine.set_speed
    commanded = np.linalg.lstsq(jacobian, -surface * np.nan_to_num(held), rcond=None)[0]
    error = (commanded - twist) / (2.0 * np.pi * machine.control.link_bandwidth)
    return pose - error if np.all(np.isfinite(held)) else pose


def check_moves(drive: Any, where: str = "drive") -> None:
    """Raise ParameterError unless a drive is a platform, arm or sphere; the message says what works.

    Parameters
    ----------
    drive : object
    where : str      Path of the drive, such as "drives.cart".
    """
    if isinstance(drive, (PlatformDrive, ArmDrive, SphereDrive)):
        return
    if not is_machine(drive):
        moves = "about one joint" if axis_of(drive).rotary else "along one axis"
        raise ParameterError(f"{where} moves {moves}: simulate it with --scenario, in a study with [scenarios.NAME]")
    works = [*EVERY_MACHINE, *getattr(drive, "commands", ())]
    why = "simulate works with drives of one axis, platforms, arms and spheres"
    if isinstance(drive, PlanarDrive):
        why = "a user pushes it: state a task with a type, and run it with infinivar session"
    raise ParameterError(
        f"{where} is a machine of type {type_words(drive)}: {why}; commands for this machine: {', '.join(works)}"
    )


def _of_sphere(
    drive: SphereDrive, machine: Any, time: np.ndarray, pose: np.ndarray, wrench: np.ndarray, closed: bool
) -> MachineScenario:
    """Shaft 2 follows a motion by prescribed steering angles: those of steady operation with the inertia of shaft 2."""
    moves = VectorHistory(time=time, values=pose)
    speed = np.array([moves.rate(float(one))[0] for one in time])
    torque = machine.output_inertia * np.array([moves.acceleration(float(one))[0] for one in time]) - wrench[:, 0]
    angle, point = drive.steer(speed, torque)
    if not np.all(np.isfinite(angle)):
        raise ParameterError("a roller of the sphere slips: no steering angle gives the motion")
    steering = VectorHistory(time=time, values=angle[:, None])
    shafts = np.concatenate([0.0 * wrench, wrench], axis=-1)
    return MachineScenario(
        duration=float(time[-1]),
        steering=steering,
        servos=False,
        rates=[drive.input_speed, float(speed[0]), *np.asarray(point.sphere_velocity)[0]],
        wrench=VectorHistory(time=time, values=shafts, smooth=False) if np.any(shafts) else None,
        settling_time=0.5 * float(time[-1]) if closed else None,
    )


def _along(drive: Any, path: MachinePath) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Instants of a path, twice over if it repeats, with poses and wrenches of the user on the machine."""
    bare = replace(path, load_mass=None, load_inertia=None)
    count = len(bare.instants(drive.coordinates, drive.home).time)
    once = np.linspace(0.0, path.period, count + 1)
    if path.closed:
        once = once[:-1]
    found = bare.at(once, drive.coordinates, drive.home)
    if not path.closed:
        return once, found.pose, -found.wrench
    time = np.concatenate([once, path.period + once, [2.0 * path.period]])
    pose, wrench = (np.concatenate([row, row, row[:1]]) for row in (found.pose, -found.wrench))
    return time, pose, wrench


def _through(drive: Any, task: MachineTask) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Instants of a steady motion with the pose of the task in its middle, as `_along`."""
    names = drive.coordinates
    time = np.linspace(0.0, HELD, _STEPS + 1)
    pose = passing(task.pose.row(names, drive.home), task.twist.row(names), names, time - 0.5 * HELD)
    return time, pose, np.tile(-task.wrench.row(names), (len(time), 1))
