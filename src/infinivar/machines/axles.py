"""Axles of wheels, each turned by a geared drive of its own: steady points, and along a course."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import axis_of
from infinivar.limits import Limit
from infinivar.machines.course import MachineCourse
from infinivar.machines.machine import held, moving


@dataclass(frozen=True, kw_only=True, eq=False)
class Axles:
    """Drives of n axles; (..., n) each, nan where the torque is."""

    torque: np.ndarray
    """On the axle, along its turning where it drives. [N m]"""
    power_in: np.ndarray
    """From the supply. [W]"""
    losses: Mapping[str, np.ndarray]
    """By name. [W]"""
    demands: Mapping[Limit, np.ndarray]
    """Demand over allowance. [-]"""
    stored: Mapping[str, np.ndarray] = field(default_factory=dict)
    """Power into rotors and gears, along a course. [W]"""


def turned(drive: ConventionalDrive, lever: float, torque: np.ndarray, speed: np.ndarray) -> Axles:
    """Axles at steady torques and speeds, (..., n) each; a linear drive turns them over a pulley.

    Parameters
    ----------
    drive : ConventionalDrive          Of each axle.
    lever : float                      Radius of the pulley of a linear drive. [m]
    torque, speed : (..., n) float     [N m], [rad s^-1]
    """
    rim = 1.0 if axis_of(drive).rotary else lever
    found = held(drive, np.nan_to_num(speed) * rim, np.nan_to_num(torque) / rim)
    lost = 0.0 * (torque + speed)
    return Axles(
        torque=torque,
        power_in=found.power_in + lost,
        losses={name: loss + lost for name, loss in found.losses.items()},
        demands={limit: demand + lost for limit, demand in found.utilisation.items()},
    )


def turned_along(
    drive: ConventionalDrive, lever: float, course: MachineCourse, torque: np.ndarray, speed: np.ndarray
) -> Axles:
    """Axles along a course, at its five instants: torques and speeds (5, ..., n); with the inertia of rotors and gears."""
    rim = 1.0 if axis_of(drive).rotary else lever
    with np.errstate(invalid="ignore"):
        found = moving(drive, course.along(speed * rim, torque / rim))
    lost = 0.0 * (torque[2] + speed[2])
    demands: dict[Limit, np.ndarray] = {}
    for (limit, _), demand in found.utilisation.items():
        demands[limit] = np.maximum(demands.get(limit, 0.0), demand + lost)
    return Axles(
        torque=torque[2],
        power_in=found.power_in + lost,
        losses={name: loss + lost for name, loss in found.losses.items()},
        demands=demands,
        stored={"rotors": sum(found.stored.values()) + lost},
    )
