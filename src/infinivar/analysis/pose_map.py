"""Loss and limits of a machine over the positions of its end point."""

from __future__ import annotations

from typing import Any

import numpy as np

from infinivar._core.result import Result, result
from infinivar.limits import Limit
from infinivar.machines.machine import as_machine
from infinivar.motion.machine_tasks import MachineTask


@result
class PoseMap(Result):
    """Loss and limits of a machine over positions along x and y, at the twist and wrench of a task.

    Attributes
    ----------
    title : str
    x, y : (nx,), (ny,) float     [m]
    loss : (nx, ny) float         nan beyond reach and slip. [W]
    margin : (nx, ny) float       [-]
    limit : (nx, ny) int8         The tightest limit where it is exceeded.
    """

    title: str
    x: np.ndarray
    y: np.ndarray
    loss: np.ndarray
    margin: np.ndarray
    limit: np.ndarray

    @property
    def share(self) -> float:
        """Share of the positions within all limits. [-]"""
        return float(np.mean(self.limit == Limit.OK))


def pose_map(drive: Any, task: MachineTask, span: Any, points: int = 81) -> PoseMap | None:
    """Map a machine over x and y, in the task's other coordinates; None for a machine without both.

    Parameters
    ----------
    drive : Machine
    task : MachineTask
    span : ((low, high), (low, high))   Of x and y. [m]
    points : int                        Along each.
    """
    machine = as_machine(drive)
    names = machine.coordinates
    if "x" not in names or "y" not in names:
        return None
    x, y = (np.linspace(low, high, points) for low, high in span)
    pose = np.broadcast_to(task.pose.row(names, machine.home), (points, points, len(names))).copy()
    pose[..., names.index("x")], pose[..., names.index("y")] = x[:, None], y[None, :]
    point = machine.perform(pose=pose, twist=task.twist.row(names), wrench=task.wrench.row(names))
    return PoseMap(title=task.title, x=x, y=y, loss=np.asarray(point.loss), margin=point.margin, limit=point.limit)
