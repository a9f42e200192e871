"""What a machine offers to studies and analyses: one protocol for all, which drives of one axis meet as well.

A machine has an end point with some coordinates, a pose of it at home, and one method, `perform`: at poses, twists and wrenches
in these coordinates it gives a `TaskPoint`, with powers, losses by name and by part, and demands on every limit of every part.
Wrenches are those that the machine exerts on its load, so that ``wrench . twist`` is the power out. Comparisons, paths, reports
and commands know nothing else of a machine: a new one needs a map and no analysis. Where inertia, rotors or steering count, a
machine has `follow`, which gives a `TaskPoint` along a `MachineCourse`, `counts`, where it counts no more than `perform` on some
courses, and `lacking`, which says what `follow` leaves out. A
class variable `WORD` names its type in studies, and `commands` the commands that work with it besides those of all machines.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol, runtime_checkable

import numpy as np

from infinivar._core.array_namespace import Array, check_broadcast
from infinivar._core.arrays import real_array
from infinivar._core.result import Result, result
from infinivar.drivetrain.drive import (
    MovingPoint,
    axis_of,
    check_drive,
    chosen,
    followed,
    is_machine,
    operated,
    orders_of,
)
from infinivar.errors import ParameterError, require
from infinivar.limits import Demand, Limit
from infinivar.machines.course import MachineCourse
from infinivar.motion.course import Course
from infinivar.motion.vectors import TRANSLATIONS
from infinivar.power import PowerPoint

SLOW_FRICTION = "slow_friction_W"
"""State: change of the power from the source by friction that falls below the stick speed, as in a simulation."""


@result
class TaskPoint(PowerPoint, Result):
    """Where a machine stands in a task; arrays (...,), or (..., n) over the parts that share the load; SI.

    Attributes
    ----------
    power_in, power_out : (...,) float   From the source, and to the load. [W]
    losses : name to (...,) float        From source to load. [W]
    demands : (Limit, part) to (...,)    Demand over allowance. nan where no steady motion exists. [-]
    states : name to (...,) float        Each name ends in its unit.
    stored : name to (...,) float        Power into what moves within the machine; none of a steady point. [W]
    parts : n names                      Such as "leg 1".
    part_losses : (..., n) float         Losses in each part. [W]
    part_forces, part_speeds : (..., n)  Of each part, in the units that `part_units` names.
    steering : (..., n) float            Steering angle of each part; nan where there is none. [rad]
    """

    power_in: Array
    power_out: Array
    losses: Mapping[str, Array]
    demands: Mapping[Demand, Array]
    parts: tuple[str, ...]
    part_losses: Array
    part_forces: Array
    part_speeds: Array
    steering: Array
    part_units: tuple[str, str] = ("N", "m/s")
    states: Mapping[str, Array] = field(default_factory=dict)
    stored: Mapping[str, Array] = field(default_factory=dict)

    @property
    def loss(self) -> Array:
        """Sum of all losses. [W]"""
        return sum(self.losses.values())  # type: ignore[return-value]

    @property
    def utilisation(self) -> Mapping[Limit, Array]:  # type: ignore[override]
        """Demand over allowance by limit, of the worst part. [-]"""
        found: dict[Limit, Array] = {}
        for (limit, _), demand in self.demands.items():
            found[limit] = demand if limit not in found else np.maximum(found[limit], demand)
        return found

    def at(self, place: int | slice) -> TaskPoint:
        """One of many points along the first axis, or some."""
        return replace(
            self,
            power_in=self.power_in[place],
            power_out=self.power_out[place],
            losses={name: loss[place] for name, loss in self.losses.items()},
            demands={key: demand[place] for key, demand in self.demands.items()},
            part_losses=self.part_losses[place],
            part_forces=self.part_forces[place],
            part_speeds=self.part_speeds[place],
            steering=self.steering[place],
            states={name: state[place] for name, state in self.states.items()},
            stored={name: power[place] for name, power in self.stored.items()},
        )


@runtime_checkable
class Machine(Protocol):
    """A drive that moves an end point with any number of coordinates; see the module."""

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the coordinates of twists and wrenches, some of `infinivar.motion.vectors.COORDINATES`."""
        ...

    @property
    def home(self) -> tuple[float, ...]:
        """Pose where a task states none, by coordinate. [m], [rad]"""
        ...

    def perform(self, *, pose: Array, twist: Array, wrench: Array) -> TaskPoint:
        """Steady operation at poses, twists and wrenches (..., d) that broadcast, in all quadrants."""
        ...


@dataclass(frozen=True, slots=True)
class SingleAxis:
    """A drive of one axis as a machine: along x, or about a joint."""

    drive: Any

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Its one coordinate."""
        return ("angle",) if axis_of(self.drive).rotary else ("x",)

    @property
    def home(self) -> tuple[float, ...]:
        """0."""
        return (0.0,)

    def perform(self, *, pose: Array, twist: Array, wrench: Array) -> TaskPoint:
        """As `Machine.perform`; at rest, friction does not help to hold the load."""
        _, rates, forces = rows(self, pose, twist, wrench)
        found = held(self.drive, rates, forces)
        axis = axis_of(self.drive)
        part = "drive"
        return TaskPoint(
            power_in=found.power_in[..., 0],
            power_out=found.power_out[..., 0],
            losses={name: loss[..., 0] for name, loss in found.losses.items()},
            demands={(limit, part): demand[..., 0] for limit, demand in found.utilisation.items()},
            parts=(part,),
            part_losses=sum(found.losses.values()),
            part_forces=forces,
            part_speeds=rates,
            steering=np.full(rates.shape, np.nan),
            part_units=(axis.force_unit, axis.speed_unit),
        )

    @property
    def lacking(self) -> Mapping[str, str]:
        """What of its motion `follow` does not count, with the reason."""
        return lacking_of_drive(self.drive)

    def counts(self, course: MachineCourse) -> bool:
        """Whether `follow` counts more than `perform`: unless `lacking` says why not."""
        return not self.lacking

    def follow(self, course: MachineCourse) -> TaskPoint:
        """Operation along a course with steering and rotors, of a drive that lacks nothing of them."""
        axis, moved = axis_of(self.drive), course.along(course.twist, course.wrench, course.pose)
        found = moving(self.drive, moved)
        shape = np.broadcast_shapes(np.shape(found.power_in), np.shape(moved.force))

        def one(values: Array) -> np.ndarray:
            return np.broadcast_to(values, shape)[..., 0]

        demands: dict[Demand, np.ndarray] = {}
        for (limit, part), demand in found.utilisation.items():
            key = limit, part if part == "steering motor" else "drive"
            demands[key] = one(demand) if key not in demands else np.maximum(demands[key], one(demand))
        return TaskPoint(
            power_in=one(found.power_in),
            power_out=one(found.power_out),
            losses={name: one(loss) for name, loss in found.losses.items()},
            demands=demands,
            parts=("drive",),
            part_losses=sum(np.broadcast_to(loss, shape) for loss in found.losses.values()),
            part_forces=-np.broadcast_to(moved.force, shape),
            part_speeds=np.broadcast_to(moved.speed, shape),
            steering=np.full(shape, np.nan),
            part_units=(axis.force_unit, axis.speed_unit),
            stored={name: one(power) for name, power in found.stored.items()},
        )


def lacking_of_drive(drive: Any) -> dict[str, str]:
    """What of the motion of a drive of one axis does not count, with the reason: "rotors", or "steering" with them."""
    what = "steering" if hasattr(drive, "steering") else "rotors"
    if not hasattr(drive, "follow"):
        return {what: f"{type(drive).__name__} has no method follow"}
    output = getattr(drive, "output", None)
    if getattr(drive, "chain", () if output is None else output.chain) or orders_of(drive) > 4:
        return {what: "springs or a linkage are between drive and load"}
    try:
        check = getattr(drive, "check_motion", None)
        if check is not None:
            check()
    except ParameterError as problem:
        return {what: str(problem).partition(":")[0]}
    return {}


def moving(drive: Any, course: Course) -> MovingPoint:
    """A drive of one axis along a course; at rest without the friction that a load which moves by a hair takes away."""
    found = followed(drive, course)
    if not hasattr(drive, "without_static_friction") or not np.any(course.at_rest):
        return found
    return chosen(course.at_rest, followed(drive.without_static_friction(), course), found)


@result
class Held(Result):
    """Drives at speeds and forces, arrays of one shape; see `held`."""

    power_in: Array
    power_out: Array
    losses: Mapping[str, Array]
    utilisation: Mapping[Limit, Array]


def held(drive: Any, speed: np.ndarray, force: np.ndarray) -> Held:
    """Operate a drive of one axis; at rest without the friction that a load which moves by a hair takes away.

    Parameters
    ----------
    drive : Drive
    speed, force : (...,) float   Of the load, and on it. [m s^-1], [N] or about a joint.
    """
    shape = np.broadcast_shapes(np.shape(speed), np.shape(force))
    moving = operated(drive, speed=speed, force=force)
    loose = (
        operated(drive.without_static_friction(), speed=speed, force=force)
        if hasattr(drive, "without_static_friction")
        else moving
    )
    still = np.broadcast_to(np.asarray(speed) == 0.0, shape)

    def mixed(mine: Any, others: Any) -> np.ndarray:
        return np.where(still, np.broadcast_to(others, shape), np.broadcast_to(mine, shape))

    return Held(
        power_in=mixed(moving.power_in, loose.power_in),
        power_out=mixed(moving.power_out, loose.power_out),
        losses={name: mixed(loss, loose.losses.get(name, 0.0)) for name, loss in moving.losses.items()},
        utilisation={
            limit: mixed(demand, loose.utilisation.get(limit, 0.0)) for limit, demand in moving.utilisation.items()
        },
    )


def as_machine(drive: Any) -> Machine:
    """The drive itself if it is a machine, else the machine of its one axis."""
    if is_machine(drive):
        return drive
    check_drive(drive, "drive")
    return SingleAxis(drive)


def rows(machine: Machine, pose: Array, twist: Array, wrench: Array) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Poses, twists and wrenches as arrays of one shape (..., d).

    Raises
    ------
    ParameterError
        If one has another number of components, a value is not finite, or their shapes do not broadcast.
    """
    d, found = len(machine.coordinates), []
    for name, value in (("pose", pose), ("twist", twist), ("wrench", wrench)):
        row = real_array(name, value)
        require(
            row.shape[-1:] == (d,), name, f"shape {row.shape}", f"of shape (..., {d}): {', '.join(machine.coordinates)}"
        )
        require(bool(np.all(np.isfinite(row))), name, "nan or inf", "finite")
        found.append(row)
    names = ("pose", "twist", "wrench")
    check_broadcast(**{name: row.shape for name, row in zip(names, found, strict=True)})
    pose, twist, wrench = np.broadcast_arrays(*found)
    return pose, twist, wrench


def unit_of(coordinate: str, quantity: str) -> str:
    """Unit of a coordinate's "pose", "twist" or "wrench"."""
    along = coordinate in TRANSLATIONS
    return {"pose": ("m", "rad"), "twist": ("m/s", "rad/s"), "wrench": ("N", "N m")}[quantity][0 if along else 1]


def worst(demands: Mapping[Limit, np.ndarray], parts: Sequence[str]) -> dict[Demand, np.ndarray]:
    """Demands (..., n) of the parts, each under its name."""
    return {(limit, part): demand[..., place] for limit, demand in demands.items() for place, part in enumerate(parts)}


def checked(machine: Any) -> None:
    """Raise ParameterError for a field of a machine that is missing although one of several must be given."""
    names = getattr(type(machine), "one_of", ())
    if not names:
        return
    stated = [name for name in names if getattr(machine, name) is not None]
    if len(stated) != 1:
        said = f"{' and '.join(stated)} are given" if stated else f"{names[0]} is missing"
        raise ParameterError(f"{said}: the machine must have exactly one of {', '.join(names)}")
