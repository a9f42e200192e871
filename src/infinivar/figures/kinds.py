"""Figures of a machine in a task: its picture, and for some kinds sets of wrenches or maps beside it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from infinivar.analysis.machine_tasks import PathResult, TaskResult
from infinivar.analysis.sphere_efficiency import sphere_map
from infinivar.drivetrain.drive import type_words
from infinivar.figures import arm, machine, pictures, wrench_set
from infinivar.figures import sphere_map as sphere_figure
from infinivar.machines.kinds.arm import ArmDrive
from infinivar.machines.kinds.platform import PlatformDrive
from infinivar.machines.kinds.robot import RobotDrive
from infinivar.machines.kinds.sphere import SphereDrive
from infinivar.machines.pictures import robots

Drawing = tuple[str, Callable[[], Any], str]
"""Name, function that draws, and caption of a figure."""

_SHARE = 0.95
"""Largest load of a sphere map, over the slip force."""


def drawings(
    name: str,
    title: str,
    drive: Any,
    task: TaskResult | None,
    assumed: str = "",
    paths: Mapping[str, PathResult] | None = None,
) -> Iterator[Drawing]:
    """Yield the figures of a drive of a study; none of a kind that has none.

    Parameters
    ----------
    name, title : str     Of the drive.
    drive : object
    task : TaskResult     The task drawn, if there is one.
    assumed : str         What its captions say of its dimensions.
    paths : mapping       Results on paths, by name, shown behind a robot.
    """
    kind, shown = type_words(drive), getattr(drive, "shown", "")
    if kind == SphereDrive.WORD:
        yield _sphere_map(name, title, drive)
    if task is None or not shown:
        return
    if kind == PlatformDrive.WORD:
        if drive.legs is not None:
            yield from _platform(name, title, drive, task, f"{title}, task {task.title}{shown}{assumed}")
        return

    def draw() -> Any:
        if kind == ArmDrive.WORD:
            return arm.draw_all(drive, task.steady, task.pose, task.twist, task.wrench)
        picture = drive.picture(task.steady, task.pose, task.twist, task.wrench)
        if kind == RobotDrive.WORD:
            picture = robots.traced(picture, drive, {one.title: one.pose for one in (paths or {}).values()})
        return pictures.draw_all(picture)

    yield f"machine-{name}", draw, f"{title}, task {task.title}{shown}{assumed}"


def _sphere_map(name: str, title: str, drive: SphereDrive) -> Drawing:
    ivt = drive.transmission
    angles = np.radians(np.linspace(-88.0, 88.0, 45))
    loads = np.linspace(0.0, _SHARE * float(ivt.drive.slip_force), 13)
    speed = abs(abs(drive.input_speed) / float(ivt.ideal_speeds(0.5 * np.pi)[0]))
    return (
        f"sphere-{name}",
        lambda: sphere_figure.draw_all(sphere_map(ivt, angles, loads, sphere_speed=speed)),
        f"{title}: efficiency and losses of the transmission over steering angle and load, at {speed:.3g} rad/s of "
        "the sphere, without the motor.",
    )


def _platform(name: str, title: str, drive: PlatformDrive, task: TaskResult, caption: str) -> Iterator[Drawing]:
    legs, pose = drive.legs, drive.configuration(task.pose)
    assert legs is not None
    point = legs.operate(pose, wrench=task.wrench, twist=task.twist).legs
    yield (
        f"machine-{name}",
        lambda: machine.draw_all(drive.platform, legs.legs, point, task.pose[:3], task.pose[3:]),
        caption,
    )
    yield (
        f"wrenches-{name}",
        lambda: wrench_set.draw_all(
            [legs.wrench_set(pose), legs.wrench_set(pose, twist=task.twist)], titles=("at rest", task.title)
        ),
        f"{title}: wrenches on the load that ideal wheels can exert at the pose of {task.title}, at rest and in that motion.",
    )
