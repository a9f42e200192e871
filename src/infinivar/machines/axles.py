"""Axles of wheels, each turned by a geared drive of its own, and servos that steer them: steady points, and along a course."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import axis_of
from infinivar.drivetrain.steering import SteeringPlant
from infinivar.limits import Limit
from infinivar.machines.course import MachineCourse
from infinivar.machines.machine import TaskPoint, held, moving
from infinivar.parts.amplifier import Amplifier
from infinivar.transmission.mechanism import MechanismPoint


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


@dataclass(frozen=True, slots=True)
class Rolled:
    """A course, with the wheels of carts along it that are known."""

    course: MachineCourse
    known: list[tuple[tuple[Any, ...], MechanismPoint]]

    def points(self, key: tuple[Any, ...], made: Callable[[], MechanismPoint]) -> MechanismPoint:
        """The wheels of a cart, by what decides on them."""
        for other, points in self.known:
            if other == key:
                return points
        self.known.append((key, made()))
        return self.known[-1][1]


def at_instant(points: MechanismPoint, place: int) -> MechanismPoint:
    """Points at one instant of several."""
    rows = {name: np.asarray(getattr(points, name))[place] for name in _BY_INSTANT}
    losses = {name: np.asarray(loss)[place] for name, loss in points.wheel_losses.items()}
    return replace(points, wheel_losses=losses, **rows)


_BY_INSTANT = (
    *("rates", "applied", "cosine", "sine", "creep_speed", "rolling_speed", "lateral_force", "moment", "steering_rate"),
    "slip_demand",
)


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


def steered(
    found: TaskPoint, plant: SteeringPlant, contact: Any, rate: np.ndarray, rise: np.ndarray, moment: np.ndarray | None
) -> TaskPoint:
    """A point of a machine on k wheels with their servos.

    Parameters
    ----------
    found : TaskPoint              Without the servos.
    plant : SteeringPlant          Of each wheel.
    contact : RollingContact       Of each wheel.
    rate, rise : (..., k) float    Of the headings. [rad s^-1], [rad s^-2]
    moment : (..., k) float        Of patches that roll as they turn, whose losses the point has; None: they turn on the spot.

    Source: faulring2006, Fig 11.
    """
    servo = plant.follow(contact, rate=rate, acceleration=rise, patch_moment=moment)
    drawn, burnt, returned = Amplifier().supply(servo.power)
    lost = {**servo.losses, "steering amplifier": burnt}
    if moment is not None:
        del lost["steering patch"]
    shape = found.steering.shape
    lost = {name: np.broadcast_to(loss, shape) for name, loss in lost.items()}
    demands = {
        (limit, f"steering motor {place + 1}"): np.broadcast_to(demand, shape)[..., place]
        for limit, demand in {**servo.utilisation, **returned}.items()
        for place in range(shape[-1])
    }
    return replace(
        found,
        power_in=found.power_in + np.sum(np.broadcast_to(drawn, shape), axis=-1),
        losses={**found.losses, **{name: np.sum(loss, axis=-1) for name, loss in lost.items()}},
        demands={**found.demands, **demands},
        part_losses=found.part_losses + sum(lost.values()),
        stored={**found.stored, "steering": np.sum(np.broadcast_to(servo.stored, shape), axis=-1)},
    )
