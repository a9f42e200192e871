"""Lower bound of the winding temperature of many candidates in a cycle, from mean squares.

Over a settled cycle the heat that enters winding and housing leaves them, so that with the mean powers of winding loss J and
friction F the winding is ``(R_wh + R_ha) J + R_ha F`` above ambient on average, and thus at some instant. It is nowhere below
ambient, where its resistance gives a lower bound of J.

The law divides the cycle into steps of at most a fiftieth of the winding's time constant, within which temperatures err by a
small part of their change in a step, for which `SPARE` leaves ample room; where steps are longer, the bound is not used.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.parts.heat_steps import step_count
from infinivar.sizing.geared.candidates import Pairs
from infinivar.sizing.geared.sampled import HOT
from infinivar.sizing.geared.tasks import MotionTask, Task

SPARE = 0.01
"""Share by which the bound may exceed the permissible rise before it excludes a candidate."""
_SHORT = 1.0 / 50.0 * (1.0 + 1e-9)
"""Longest step, in multiples of the winding's time constant."""


class Warmth(NamedTuple):
    """Thermal values of many candidates. (k,) each"""

    known: np.ndarray
    """Whether the bound applies. bool"""
    by_winding: np.ndarray
    """Rise per winding loss, over the permissible rise; 0 where the bound does not apply. [W^-1]"""
    by_friction: np.ndarray
    """Rise per friction and iron loss, over the permissible rise. [W^-1]"""
    hopeless: np.ndarray
    """Whether the surroundings alone are warmer than the winding may be. bool"""


def warmth(found: Pairs, task: Task, rows: np.ndarray) -> Warmth | None:
    """Thermal values of candidates; None for a task other than a cycle, and where no motor has them."""
    if not isinstance(task, MotionTask) or not task.duty.closed:
        return None
    inner, outer, lag, limit = (
        found.values("motor", name, rows)
        for name in ("winding_to_housing", "housing_to_ambient", "winding_time_constant", "max_winding_temperature")
    )
    allowed, stated = limit - task.duty.ambient, found.stated(HOT, rows)
    known, hopeless = stated & (allowed > 0.0), stated & (allowed < 0.0)
    count = step_count(np.where(known, lag, 1.0), task.period, len(task.instants.time))
    known = known & (task.period <= _SHORT * count * lag)
    if not (known | hopeless).any():
        return None
    most = np.where(known, allowed, 1.0) * (1.0 + SPARE)
    return Warmth(known, np.where(known, (inner + outer) / most, 0.0), np.where(known, outer / most, 0.0), hopeless)


def friction_factors(drive: ConventionalDrive) -> tuple[np.ndarray, np.ndarray]:
    """Friction and iron loss of many motors per speed of the gear's output, and per square of it. (k,), (k,) [W s], [W s^2]"""
    motor, ratio = drive.motor, np.ravel(drive.gearhead.ratio)
    viscous = 0.0 if motor.viscous_friction is None else np.ravel(motor.viscous_friction)
    return np.ravel(motor.friction_torque) * ratio, viscous * ratio * ratio
