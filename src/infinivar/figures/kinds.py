"""Figures of a machine in a task, by its kind: geometry with forces, sets of wrenches, or maps."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from infinivar.analysis.machine_tasks import TaskResult
from infinivar.analysis.sphere_map import sphere_map
from infinivar.drivetrain.drive import type_words
from infinivar.figures import arm, machine, omniwheels, planar_cobot, sphere, wrench_set
from infinivar.figures import sphere_map as sphere_figure
from infinivar.machines.kinds.arm import ArmDrive
from infinivar.machines.kinds.omniwheels import OmniwheelDrive
from infinivar.machines.kinds.planar import PlanarDrive
from infinivar.machines.kinds.platform import PlatformDrive
from infinivar.machines.kinds.sphere import SphereDrive

Drawing = tuple[str, Callable[[], Any], str]
"""Name, function that draws, and caption of a figure."""

_SHARE = 0.95
"""Largest load of a sphere map, over the slip force."""


def drawings(name: str, title: str, drive: Any, task: TaskResult | None, assumed: str = "") -> Iterator[Drawing]:
    """Yield the figures of a drive of a study; none of a kind that has none.

    Parameters
    ----------
    name, title : str     Of the drive.
    drive : object
    task : TaskResult     The task drawn, if there is one.
    assumed : str         What its captions say of its dimensions.
    """
    drawn = _DRAWN.get(type_words(drive))
    if drawn is not None:
        yield from drawn(name, title, drive, task, assumed)


def _sphere(name: str, title: str, drive: SphereDrive, task: TaskResult | None, assumed: str) -> Iterator[Drawing]:
    ivt = drive.transmission
    angles = np.radians(np.linspace(-88.0, 88.0, 45))
    loads = np.linspace(0.0, _SHARE * float(ivt.drive.slip_force), 13)
    speed = abs(drive.input_speed) / float(ivt.ideal_speeds(0.5 * np.pi)[0])
    yield (
        f"sphere-{name}",
        lambda: sphere_figure.draw_all(sphere_map(ivt, angles, loads, sphere_speed=abs(speed))),
        f"{title}: efficiency and losses of the transmission over steering angle and load, at {abs(speed):.3g} rad/s of "
        "the sphere, without the motor.",
    )
    if task is not None:
        yield (
            f"machine-{name}",
            lambda: sphere.draw_all(ivt, drive.steer(task.twist[0], task.wrench[0])[1]),
            f"{title}, task {task.title}: the rollers in their places, and their forces on the sphere. A steered roller "
            "has its axle along that part of the axis of the sphere which is tangential there.",
        )


def _planar(name: str, title: str, drive: PlanarDrive, task: TaskResult | None, assumed: str) -> Iterator[Drawing]:
    if task is not None:
        yield (
            f"machine-{name}",
            lambda: planar_cobot.draw_all(drive.machine, drive.operated(task.twist, task.wrench), task.wrench),
            f"{title}, task {task.title}: wheels along their headings, and the forces on the machine: those of the ground, "
            "of the source that pushes it, and of its load.",
        )


def _arm(name: str, title: str, drive: ArmDrive, task: TaskResult | None, assumed: str) -> Iterator[Drawing]:
    if task is not None:
        yield (
            f"machine-{name}",
            lambda: arm.draw_all(drive, task.pose, task.twist, task.wrench),
            f"{title}, task {task.title}, drawn from its geometry: torques of the joints on the load, force and velocity "
            "of the end point, and the forces that it can exert there within all limits.",
        )


def _platform(name: str, title: str, drive: PlatformDrive, task: TaskResult | None, assumed: str) -> Iterator[Drawing]:
    legs = drive.legs
    if task is None or legs is None:
        return
    pose = drive.configuration(task.pose)
    point = legs.operate(pose, wrench=task.wrench, twist=task.twist).legs
    yield (
        f"machine-{name}",
        lambda: machine.draw_all(drive.platform, legs.legs, point, task.pose[:3], task.pose[3:]),
        f"{title}, task {task.title}, drawn from its geometry. Forces are those of the user on the machine.{assumed}",
    )
    yield (
        f"wrenches-{name}",
        lambda: wrench_set.draw_all(
            [legs.wrench_set(pose), legs.wrench_set(pose, twist=task.twist)], titles=("at rest", task.title)
        ),
        f"{title}: wrenches on the load that ideal wheels can exert at the pose of {task.title}, at rest and in that motion.",
    )


def _omniwheels(
    name: str, title: str, drive: OmniwheelDrive, task: TaskResult | None, assumed: str
) -> Iterator[Drawing]:
    if task is not None:
        yield (
            f"machine-{name}",
            lambda: omniwheels.draw_all(drive, task.pose, task.twist, task.wrench),
            f"{title}, task {task.title}, from above: wheels along their rolling directions, the axles of the rollers that "
            "stand on the ground, and the forces on the machine.",
        )


_DRAWN: dict[str, Callable[..., Iterator[Drawing]]] = {
    kind.WORD: drawn
    for kind, drawn in (
        (SphereDrive, _sphere),
        (PlanarDrive, _planar),
        (ArmDrive, _arm),
        (PlatformDrive, _platform),
        (OmniwheelDrive, _omniwheels),
    )
}
