"""Links of a machine, moved by legs on one common cylinder or by a geared motor each: steady points, and inverse dynamics.

Along a course the links carry what the machine exerts on its load and what accelerates the machine itself. Links, rotors and
steering have the inertias that the drives state; a common cylinder keeps its speed.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from infinivar._core.array_namespace import Array
from infinivar.contact import creep
from infinivar.contact.friction import STICK_SPEED, coulomb
from infinivar.drivetrain.cobotic import CoboticDrive, Rolled
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import GEAR_LIMITS, MOTOR_LIMITS, MovingPoint, axis_of, followed
from infinivar.errors import ParameterError
from infinivar.limits import Demand, Limit
from infinivar.machines.course import CREEPING, MachineCourse
from infinivar.machines.machine import SLOW_FRICTION, TaskPoint, held, moving, worst
from infinivar.machines.many_legs import LeggedDrive
from infinivar.motion.course import Course
from infinivar.transmission.configuration import Configuration, over_links

RIM = 0.1
"""Radius at which a joint that a drive turns directly counts as moving. [m]"""


def moved(
    configuration: Configuration,
    leg: LeggedDrive | None,
    separate: ConventionalDrive | None,
    twist: np.ndarray,
    wrench: np.ndarray,
    *,
    lever: float = 1.0,
    words: str = "leg",
    units: tuple[str, str] = ("N", "m/s"),
) -> TaskPoint:
    """Operate the links of a machine, with legs on one cylinder or with drives of their own.

    Parameters
    ----------
    configuration : Configuration
    leg, separate                   One of the two; the other is None.
    twist, wrench : (..., d) float  In the coordinates of the configuration; the wrench on the load.
    lever : float                   Radius over which a linear drive moves a joint; 1 for links along a line. [m]
    words : str                     What a link is called: "leg", "joint".
    units : two texts               Of the force and speed of a link in the result.
    """
    n = configuration.links
    parts = tuple(f"{words} {place + 1}" for place in range(n))
    kinematic: dict[Demand, np.ndarray] = {
        (limit, "geometry"): np.broadcast_to(demand, twist.shape[:-1])
        for limit, demand in configuration.utilisation.items()
    }
    if leg is not None:
        return _with_legs(configuration, leg, twist, wrench, parts, kinematic, lever, units)
    assert separate is not None
    with np.errstate(invalid="ignore", over="ignore"):
        speed, force = configuration.link_speeds(twist), configuration.link_forces(wrench)
    reaches = np.all(np.isfinite(speed) & np.isfinite(force), axis=-1)
    safe = reaches[..., None]
    # Links of a configuration over pulleys move at the rim; a drive about the joint has the joint's own rate and torque.
    rim = lever if axis_of(separate).rotary else 1.0
    found = held(separate, np.where(safe, speed / rim, 0.0), np.where(safe, force * rim, 0.0))
    lost = np.where(safe, 0.0, np.nan)
    losses = {name: one + lost for name, one in found.losses.items()}
    return TaskPoint(
        power_in=np.sum(found.power_in + lost, axis=-1),
        power_out=np.sum(wrench * twist, axis=-1) + lost[..., 0],
        losses={name: np.sum(loss, axis=-1) for name, loss in losses.items()},
        demands={**worst({limit: demand + lost for limit, demand in found.utilisation.items()}, parts), **kinematic},
        parts=parts,
        part_losses=sum(losses.values()),
        part_forces=(force * lever) + lost,
        part_speeds=(speed / lever) + lost,
        steering=np.full(speed.shape, np.nan),
        part_units=units,
    )


def _with_legs(
    configuration: Configuration,
    leg: LeggedDrive,
    twist: np.ndarray,
    wrench: np.ndarray,
    parts: tuple[str, ...],
    kinematic: dict[Demand, np.ndarray],
    lever: float,
    units: tuple[str, str],
) -> TaskPoint:
    found = leg.operate(configuration, wrench=wrench, twist=twist)
    legs = found.legs
    shape = legs.link_force.shape
    known = {limit: one for limit, one in found.utilisation.items() if limit not in configuration.utilisation}
    demands = judged_legs(legs.slip_demand, known, parts)
    return TaskPoint(
        power_in=np.broadcast_to(found.power_in, shape[:-1]),
        power_out=np.broadcast_to(found.power_out, shape[:-1]),
        losses={name: np.broadcast_to(loss, shape[:-1]) for name, loss in found.losses.items()},
        demands={**demands, **kinematic},
        parts=parts,
        part_losses=np.broadcast_to(legs.loss_of_legs, shape),
        part_forces=legs.link_force * lever,
        part_speeds=legs.link_speed / lever,
        steering=np.arctan(legs.steering_tangent),
        part_units=units,
        states={name: np.broadcast_to(value, shape[:-1]) for name, value in found.states.items()},
    )


def lifting(point: TaskPoint, weight: np.ndarray, rates: np.ndarray) -> TaskPoint:
    """A steady point of which a part of the wrench lifts the machine itself: that power is stored, not delivered."""
    stored = np.sum(weight * rates, axis=-1) + 0.0 * point.power_out
    return replace(point, power_out=point.power_out - stored, stored={"machine": stored})


def judged_legs(slip: np.ndarray, utilisation: Mapping[Limit, Array], parts: Sequence[str]) -> dict[Demand, np.ndarray]:
    """Demands of legs on a common cylinder: slip (..., n) of each, and others (...,) of wheels, motor and gearhead."""
    demands = worst({Limit.SLIP: slip}, parts)
    for limit, demand in utilisation.items():
        if limit is not Limit.SLIP:
            what = "gearhead" if limit in GEAR_LIMITS else "motor" if limit in MOTOR_LIMITS else "wheel"
            demands[limit, what] = np.broadcast_to(demand, slip.shape[:-1])
    return demands


@dataclass(frozen=True, kw_only=True, eq=False)
class Carried:
    """What the links of a machine carry along a course, in the coordinates of its configuration.

    Speeds and forces of links are computed once for all drives that are compared on them.
    """

    course: MachineCourse
    configuration: Configuration
    """At the five instants."""
    twist: np.ndarray
    """(5, ..., d)"""
    load: np.ndarray
    """Exerted by the links: on the load, and on the moving machine. (3, ..., d)"""

    @functools.cached_property
    def delivered(self) -> np.ndarray:
        """Power to the load. (...,) [W]"""
        return np.sum(self.course.wrench[2] * self.course.twist[2], axis=-1)

    @functools.cached_property
    def speed(self) -> np.ndarray:
        """Of the links. (5, ..., n)"""
        return self.configuration.link_speeds(self.twist)

    @property
    def link_position(self) -> np.ndarray:
        """Of the links; 0 where the configuration states none. (..., n) [m]"""
        return np.broadcast_to(self.configuration.link_position, self.configuration.jacobian.shape[:-1])[2]

    @functools.cached_property
    def force(self) -> np.ndarray:
        """Of the links, without what accelerates them. (3, ..., n)"""
        held = replace(
            self.configuration,
            jacobian=self.configuration.jacobian[1:4],
            link_position=0.0,
            utilisation={},
        )
        return held.link_forces(self.load)

    @property
    def stored(self) -> np.ndarray:
        """Power into the moving machine, without its links. (...,) [W]"""
        return np.sum(self.load[1] * self.twist[2], axis=-1) - self.delivered

    def motion(self, scale: float = 1.0) -> Course:
        """Course of the links, or of joints at links over a lever; forces on the links."""
        with np.errstate(invalid="ignore", over="ignore"):
            return self.course.along(self.speed / scale, self.force * scale)

    @property
    def kinematic(self) -> dict[Demand, np.ndarray]:
        """Demands on the geometry."""
        shape = self.delivered.shape
        return {
            (limit, "geometry"): np.broadcast_to(np.asarray(demand)[2], shape)
            for limit, demand in self.configuration.utilisation.items()
        }


def lacking_of_leg(leg: CoboticDrive) -> dict[str, str]:
    """What of the motion of a leg does not count, with the reason: "steering", "links"."""
    try:
        creep.law_in_motion(leg.transmission.creep_law)
    except ParameterError:
        return {"steering": "its creep law is for steady motion", "links": "its creep law is for steady motion"}
    if leg.mass_of_link is None:
        return {"steering": "leg.link_mass is missing", "links": "leg.link_mass is missing"}
    if leg.steering is None:
        return {"steering": "no steering plant is stated"}
    if leg.steering.motor.rotor_inertia is None:
        return {"steering": "leg.steering.motor.rotor_inertia is missing"}
    return {}


class RolledLegs(NamedTuple):
    """What legs on a common cylinder do along a course, whichever motors turn and steer them."""

    course: Course
    """Of the links."""
    legs: Rolled
    """Without the bearings of the cylinder, which carry all wheels together. (..., n)"""
    shape: tuple[int, ...]
    torque: np.ndarray
    """On the cylinder: of all legs, and of its bearings. (...,) [N m]"""
    rubbed: Mapping[str, np.ndarray]
    """Losses in the bearings of the cylinder. (...,) [W]"""

    @property
    def slip(self) -> np.ndarray:
        """Demand on the slip force of each leg. (..., n) [-]"""
        return np.broadcast_to(self.legs.utilisation[Limit.SLIP], self.shape)

    @property
    def utilisation(self) -> dict[Limit, np.ndarray]:
        """Demands on the worst wheel. (...,) [-]"""
        every = {limit: np.broadcast_to(demand, self.shape) for limit, demand in self.legs.utilisation.items()}
        return {limit: over_links(np.maximum, demand) for limit, demand in every.items()}


def rolled_legs(carried: Carried, legs: LeggedDrive, leg: CoboticDrive) -> RolledLegs:
    """Roll the wheels of legs along a course; below `CREEPING` they count as not steering."""
    course = carried.motion()
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        rolled = replace(leg, cylinder_bearings=None).roll(course)
        angle = rolled.steering
        turns = np.abs(angle.rate) > CREEPING
        rolled = rolled._replace(
            steering=angle._replace(
                rate=np.where(turns | np.isnan(angle.rate), angle.rate, 0.0),
                curvature=np.where(turns | np.isnan(angle.rate), angle.curvature, 0.0),
            )
        )
        shape = np.broadcast_shapes(np.shape(rolled.torque), course.speed.shape)
        torque = np.broadcast_to(rolled.torque, shape)
        rubbing, rubbed = legs.turned(
            np.asarray(legs.cylinder_speed), torque, np.broadcast_to(rolled.force, shape), carried.link_position
        )
        return RolledLegs(course, rolled, shape, over_links(np.add, torque) + rubbing, rubbed)


def with_legs(
    carried: Carried,
    legs: LeggedDrive,
    leg: CoboticDrive,
    parts: tuple[str, ...],
    lever: float,
    units: tuple[str, str],
) -> TaskPoint:
    """Legs on a common cylinder along a course; arguments as for `moved`."""
    rolled = rolled_legs(carried, legs, leg)
    course, angle, shape = rolled.course, rolled.legs.steering, rolled.shape
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        lost, demands = dict(rolled.legs.losses), {}
        drawn, turning, slow = np.zeros(shape), np.zeros(shape), np.zeros(shape)
        if "steering" not in lacking_of_leg(leg):
            steered, lost = leg.steered(rolled.legs)
            drawn, burnt, returned = leg.steering_amplifier.supply(steered.power)
            turning, lost["steering amplifier"] = steered.stored, burnt
            slow = np.broadcast_to(leg.slow_friction(rolled.legs), shape)
            for limit, demand in {**steered.utilisation, **returned}.items():
                row = np.broadcast_to(demand, shape)
                demands |= {(limit, f"steering motor {place + 1}"): row[..., place] for place in range(shape[-1])}
        behind = legs.driven(rolled.torque, np.asarray(legs.cylinder_speed))
    inertia = leg.mass_of_link * course.acceleration * course.speed  # type: ignore[operator]
    every = {name: np.broadcast_to(loss, shape) for name, loss in lost.items()}
    return TaskPoint(
        power_in=behind.power_in + np.sum(drawn, axis=-1),
        power_out=carried.delivered + 0.0 * behind.power_in,
        losses={
            name: np.broadcast_to(loss, shape[:-1])
            for name, loss in (
                *behind.losses.items(),
                *rolled.rubbed.items(),
                *((name, np.sum(loss, axis=-1)) for name, loss in every.items()),
            )
        },
        demands={
            **judged_legs(rolled.slip, {**rolled.utilisation, **behind.utilisation, **legs.legs.pressed}, parts),
            **demands,
            **carried.kinematic,
        },
        parts=parts,
        part_losses=sum(every.values()),
        part_forces=-np.broadcast_to(course.force, shape) * lever,
        part_speeds=np.broadcast_to(course.speed, shape) / lever,
        steering=np.arctan(np.broadcast_to(angle.value, shape)),
        part_units=units,
        states={
            **{name: np.broadcast_to(value, shape[:-1]) for name, value in behind.states.items()},
            SLOW_FRICTION: np.sum(slow, axis=-1),
        },
        stored={
            "machine": carried.stored + 0.0 * behind.power_in,
            "links": np.sum(inertia + np.zeros(shape), axis=-1),
            "steering": np.sum(np.broadcast_to(turning, shape), axis=-1),
        },
    )


def with_motors(
    carried: Carried, separate: ConventionalDrive, parts: tuple[str, ...], lever: float, units: tuple[str, str]
) -> TaskPoint:
    """A drive on each link along a course; arguments as for `moved`."""
    rim = lever if axis_of(separate).rotary else 1.0
    course = carried.motion(rim)
    with np.errstate(invalid="ignore", over="ignore"):
        found = moving(separate, course)
        slow = _slow_friction(separate, course, found)
    shape = np.broadcast_shapes(np.shape(found.power_in), course.speed.shape)
    losses = {name: np.broadcast_to(loss, shape) for name, loss in found.losses.items()}
    rotors = sum(np.broadcast_to(one, shape) for one in found.stored.values())
    demands = {}
    for (limit, _), demand in found.utilisation.items():
        row = np.broadcast_to(demand, shape)
        demands[limit] = row if limit not in demands else np.maximum(demands[limit], row)
    return TaskPoint(
        power_in=np.sum(np.broadcast_to(found.power_in, shape), axis=-1),
        power_out=carried.delivered + 0.0 * np.sum(course.speed, axis=-1),
        losses={name: np.sum(loss, axis=-1) for name, loss in losses.items()},
        demands={**worst(demands, parts), **carried.kinematic},
        parts=parts,
        part_losses=sum(losses.values()),
        part_forces=-course.force / rim * lever + np.zeros(shape),
        part_speeds=course.speed * rim / lever + np.zeros(shape),
        steering=np.full(shape, np.nan),
        part_units=units,
        states={SLOW_FRICTION: np.sum(np.broadcast_to(slow, shape), axis=-1)},
        stored={"machine": carried.stored + 0.0 * np.sum(rotors, axis=-1), "rotors": np.sum(rotors, axis=-1)},
    )


def _slow_friction(drive: ConventionalDrive, course: Course, found: MovingPoint) -> Array:
    """Change of the supply's power by friction that falls below the stick speed, as in a simulation. [W]"""
    stick_speed = STICK_SPEED / (RIM if axis_of(drive).rotary else 1.0)
    share = np.abs(coulomb(course.speed, 1.0, stick_speed))
    full, free = (
        point.states["motor_current_A"] for point in (found, followed(drive.without_static_friction(), course))
    )
    winding = drive.motor.resistance
    induced = found.states["motor_voltage_V"] - winding * full
    slow, now = (
        drive.amplifier.supply((winding * current + induced) * current)[0]
        for current in (free + share * (full - free), full)
    )
    return slow - now
