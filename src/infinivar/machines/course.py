"""A machine's task or path with the instants just before and after: rates of links, forces and wheels along it follow.

A task is a steady motion through its pose; its twist and wrench are constant. On a path the wrench accelerates the load.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from infinivar.motion.course import Course
from infinivar.motion.machine_tasks import MachinePath
from infinivar.motion.vectors import ROTATIONS, TRANSLATIONS
from infinivar.transmission.platform import rotation_matrix, rotation_vector
from infinivar.transmission.rates import Varying

_AROUND = (-2, -1, 0, 1, 2)
"""Instants about each one, in steps."""

_PART = 1.0 / 16.0
"""Step over the time between two instants of a path. With 40 instants a wave its derivatives err by 2e-5."""

_SHORT, _TURNED = 1e-5, 1e-4
"""Way of the end point within a step of a task. [m], [rad]"""

CREEPING = 1e-9
"""Steering rate that counts as rest; rounding leaves less. [rad s^-1]"""


@dataclass(frozen=True, slots=True)
class MachineCourse:
    """Motion of the end point of a machine and wrenches on its load, at five instants in equal steps about each one.

    Arrays (5, ..., d) in the coordinates of the machine, which broadcast; a sixth index before the last one, such as one over
    wrenches, is of one motion.
    """

    step: float | np.ndarray
    """One, or one for each instant (..., 1). [s]"""
    pose: np.ndarray
    twist: np.ndarray
    acceleration: np.ndarray
    wrench: np.ndarray

    @property
    def moves(self) -> bool:
        """Whether the end point moves at all."""
        return bool(np.any(self.twist) or np.any(self.acceleration))

    @property
    def accelerates(self) -> bool:
        """Whether the end point accelerates at any instant."""
        return bool(np.any(self.acceleration))

    def rate(self, values: np.ndarray) -> np.ndarray:
        """Time derivative of values (k, ...): (k - 2, ...), by central differences."""
        return (values[2:] - values[:-2]) / (2.0 * self.step)

    def varying(self, values: np.ndarray) -> Varying:
        """Values (3, ...) or (5, ...) with their first and second time derivative at the instants: (...) each."""
        before, now, after = values[len(values) // 2 - 1 : len(values) // 2 + 2]
        return Varying(
            now,
            (after - before) / (2.0 * self.step),
            ((after - now) - (now - before)) / (self.step * self.step),
        )

    def along(self, speed: np.ndarray, force: np.ndarray, position: np.ndarray | None = None) -> Course:
        """Course of one axis from its speeds (5, ...), the forces that it exerts (3 or 5, ...) and its positions (5, ...)."""
        moved, pushed = self.varying(speed), self.varying(force)
        return Course(
            speed=moved.value,
            acceleration=moved.rate,
            jerk=moved.curvature,
            snap=(speed[4] - 2.0 * speed[3] + 2.0 * speed[1] - speed[0]) / (2.0 * self.step**3),
            force=-pushed.value,
            force_rate=-pushed.rate,
            force_curvature=-pushed.curvature,
            position=None if position is None else position[2],
        )


def together(courses: Sequence[MachineCourse]) -> MachineCourse:
    """Courses with arrays (5, 1 or k, d) as one, their instants side by side; a single one is returned as it is."""
    if len(courses) == 1:
        return courses[0]
    each = [np.broadcast_arrays(one.pose, one.twist, one.acceleration, one.wrench) for one in courses]
    steps = [np.full((row[0].shape[1], 1), one.step) for one, row in zip(courses, each, strict=True)]
    return MachineCourse(np.concatenate(steps), *(np.concatenate(rows, axis=1) for rows in zip(*each, strict=True)))


def on_path(path: MachinePath, coordinates: Sequence[str], home: Sequence[float]) -> tuple[np.ndarray, MachineCourse]:
    """Instants (t,) of a path and its course, with arrays (5, t, d)."""
    time = path.instants(coordinates, home).time
    step = _PART * path.period / len(time)
    found = path.at(np.concatenate([time + place * step for place in _AROUND]), coordinates, home)
    arrays = (found.pose, found.twist, found.acceleration, found.wrench)
    return time, MachineCourse(step, *(row.reshape(len(_AROUND), len(time), -1) for row in arrays))


def through(pose: np.ndarray, twist: np.ndarray, coordinates: Sequence[str], wrenches: np.ndarray) -> MachineCourse:
    """Course of a steady motion through a pose (d,) at a twist (d,) under wrenches (m, d), with arrays (5, 1 or m, d)."""
    along = [
        abs(rate) / (_SHORT if name in TRANSLATIONS else _TURNED) for name, rate in zip(coordinates, twist, strict=True)
    ]
    step = 1.0 / max(1.0, *along)  # within a second, however slow the task
    poses = passing(pose, twist, coordinates, step * np.array(_AROUND))
    moving = np.broadcast_to(twist, poses.shape)
    five = (len(_AROUND), *np.shape(wrenches))
    return MachineCourse(
        step, poses[:, None], moving[:, None], np.zeros_like(poses)[:, None], np.broadcast_to(wrenches, five)
    )


def passing(pose: np.ndarray, twist: np.ndarray, coordinates: Sequence[str], away: np.ndarray) -> np.ndarray:
    """Poses (t, d) of a steady motion at times (t,) from that of a pose (d,); rotations turn about fixed axes."""
    found = pose + away[:, None] * twist
    turning = [place for place, name in enumerate(coordinates) if name in ROTATIONS]
    if len(turning) == 3 and np.any(twist[turning]):
        further = rotation_matrix(away[:, None] * twist[turning])
        found[:, turning] = rotation_vector(further @ rotation_matrix(pose[turning]))
    return found
