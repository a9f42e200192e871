"""Machines whose joints or links are driven side by side: by legs on one common cylinder, or by a drive of its own each.

Both share the kinematic map (`Configuration`); they differ in what moves the links. So a cobotic machine and its conventional
rival are one class with another field, `leg` or `separate`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Literal

import numpy as np
from annotated_types import Ge, Gt

from infinivar._core.array_namespace import Array
from infinivar._core.fields import brief, check, component, quantities, quantity
from infinivar.axis import LINEAR
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import axis_of, needed
from infinivar.errors import ParameterError, require
from infinivar.limits import Limit
from infinivar.machines.bodies import rigid_body
from infinivar.machines.course import MachineCourse
from infinivar.machines.kinds.moving import ArmMachine, PlatformMachine, SeparateMachine
from infinivar.machines.kinds.rods import PlatformGeometry
from infinivar.machines.linkage import ArmLoad, PlatformLoad
from infinivar.machines.links import Carried, lacking_of_leg, moved, with_legs, with_motors
from infinivar.machines.machine import TaskPoint, checked, lacking_of_drive, rows
from infinivar.machines.many_legs import LeggedDrive
from infinivar.transmission.arm import PlanarArm
from infinivar.transmission.configuration import Configuration
from infinivar.transmission.platform import Platform, rotation_matrix

Elbow = Literal["left", "right"]


class _Side:
    """What platform and arm share: legs on one cylinder, or a drive for each link."""

    __slots__ = ()

    leg: CoboticDrive | None
    separate: ConventionalDrive | None
    legs: LeggedDrive | None

    @property
    def _carries(self) -> bool:
        """Whether the masses that move with the links are stated."""
        raise NotImplementedError

    @property
    def _massless(self) -> str:
        """Why they are not."""
        raise NotImplementedError

    @property
    def commands(self) -> tuple[str, ...]:
        """Commands that work besides those of all machines."""
        return ("contact", "simulate") if self.leg is not None else ("simulate",)

    @property
    def lacking(self) -> Mapping[str, str]:
        """What of its motion `follow` does not count, with the reason."""
        moves = {} if self._carries else {"moving masses": self._massless}
        own = lacking_of_drive(self.separate) if self.leg is None else lacking_of_leg(self.leg)
        return {**own, **moves}

    @property
    def steering_friction(self) -> float:
        """Torque at the bell against steering; nan without a steering plant. [N m]"""
        if self.leg is None or "steering" in lacking_of_leg(self.leg):
            return float("nan")
        return float(self.leg.steering.coulomb_torque(self.leg.transmission))  # type: ignore[union-attr]

    def carried(self, course: MachineCourse) -> Carried:
        """What the links carry along a course; it does not depend on what moves them."""
        raise NotImplementedError

    def follow(self, course: MachineCourse) -> TaskPoint:
        """Operation along a course with the inertia of the machine and its links, steering or rotors."""
        return self.along(self.carried(course))

    def along(self, carried: Carried) -> TaskPoint:
        """Links along a course; those whose own motion does not count as at steady points."""
        raise NotImplementedError

    def _along(
        self, carried: Carried, lever: float = 1.0, words: str = "leg", units: tuple[str, str] = ("N", "m/s")
    ) -> TaskPoint:
        parts = tuple(f"{words} {place + 1}" for place in range(carried.configuration.links))
        if self.leg is not None and "links" not in lacking_of_leg(self.leg):
            assert self.legs is not None
            return with_legs(carried, self.legs, self.leg, parts, lever, units)
        if self.separate is not None and not lacking_of_drive(self.separate):
            return with_motors(carried, self.separate, parts, lever, units)
        known = carried.configuration
        here = replace(
            known,
            jacobian=np.broadcast_to(known.jacobian[2], (*carried.delivered.shape, *known.jacobian.shape[-2:])),
            link_position=0.0,
            utilisation={limit: demand for (limit, _), demand in carried.kinematic.items()},
        )
        twist, load = np.broadcast_arrays(carried.twist[2], carried.load[1])
        point = moved(here, self.legs, self.separate, twist, load, lever=lever, words=words, units=units)
        return replace(point, power_out=carried.delivered, stored={"machine": carried.stored})

    def _legs(self, count: int) -> LeggedDrive | None:
        """The drive of the common cylinder; None with separate drives."""
        checked(self)
        if self.leg is None:
            return None
        try:
            return LeggedDrive.of(self.leg, count)
        except ParameterError as problem:
            raise ParameterError(f"leg.{problem}") from None


@dataclass(frozen=True, slots=True, kw_only=True)
class PlatformDrive(_Side):
    """A platform on rods, whose links are moved by legs on one common cylinder, or by a drive of its own each.

    Source: faulring2006, section I and section VI, for the legs; its geometry is not published.
    """

    WORD: ClassVar[str] = "platform"
    one_of: ClassVar[tuple[str, ...]] = ("leg", "separate")
    """Fields of which exactly one is given."""

    geometry: PlatformGeometry = component("Rods and their joints")
    leg: CoboticDrive | None = component("One leg with the motor of the common cylinder", default=None)
    separate: ConventionalDrive | None = component("Drive of each link, with a motor of its own", default=None)
    mass: float | None = quantity("kg", Gt(0), "Mass of the platform without a load, for simulation", default=None)
    inertia: tuple[float, ...] | None = quantities(
        "kg m^2",
        Gt(0),
        "Moments of inertia of the platform about its axes x, y and z, for simulation; its origin is the centre of mass",
        default=None,
    )
    legs: LeggedDrive | None = field(init=False, repr=False, compare=False, default=None)

    __repr__ = brief

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        object.__setattr__(self, "legs", self._legs(self.links))
        if self.inertia is not None:
            require(len(self.inertia) == 3, "inertia", f"{len(self.inertia)} values", "three: about x, y and z")
        if self.separate is not None and axis_of(self.separate) is not LINEAR:
            raise ParameterError(
                "separate must move a link along a line, not a joint: give it a pulley, screw, belt or rack"
            )

    @property
    def platform(self) -> Platform:
        """The kinematics."""
        return self.geometry.platform

    @property
    def links(self) -> int:
        """Number of rods."""
        return len(self.platform.base)

    @property
    def span(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Positions along x and y worth a map: a little beyond the rods' reach. [m]"""
        reach = 0.75 * self.platform.rod_length
        return (-reach, reach), (-reach, reach)

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Along and about fixed axes."""
        return ("x", "y", "z", "rx", "ry", "rz")

    @property
    def home(self) -> tuple[float, ...]:
        """On the axis, with the links at 0 on average."""
        return (0.0, 0.0, self.platform.home, 0.0, 0.0, 0.0)

    def configuration(self, pose: Array) -> Configuration:
        """The kinematic map at poses (..., 6); at singular ones the demand of `Limit.LINKAGE` is infinite."""
        row = np.asarray(pose, dtype=float)
        found = self.platform.at(row[..., :3], row[..., 3:])
        singular = self.platform.singular(found.jacobian)
        if not np.any(singular):
            return found
        demand = np.where(singular, np.inf, found.utilisation[Limit.LINKAGE])
        return replace(found, utilisation={**found.utilisation, Limit.LINKAGE: demand})

    def part_speeds(self, pose: np.ndarray, twist: np.ndarray) -> np.ndarray:
        """Of the links. (..., n) [m s^-1]"""
        return self.configuration(pose).link_speeds(twist)

    def perform(self, *, pose: Array, twist: Array, wrench: Array) -> TaskPoint:
        """As `infinivar.machines.machine.Machine.perform`."""
        pose, twist, wrench = rows(self, pose, twist, wrench)
        return moved(self.configuration(pose), self.legs, self.separate, twist, wrench)

    def carried(self, course: MachineCourse) -> Carried:
        """What the rods carry along a course, with what accelerates the platform.

        Source: Newton and Euler.
        """
        load = course.wrench[1:4]
        if self._carries:
            pose, twist = np.broadcast_arrays(course.pose[1:4], course.twist[1:4])
            turn = rotation_matrix(pose[..., 3:].reshape(-1, 3))
            body = rigid_body(self.mass, np.array(self.inertia), turn, twist.reshape(-1, 6))  # type: ignore[arg-type]
            pushed = np.matmul(body.inertia.reshape(*twist.shape, 6), course.acceleration[1:4, ..., None])[..., 0]
            load = load + pushed + body.bias.reshape(twist.shape)
        delivered = np.sum(course.wrench[2] * course.twist[2], axis=-1)
        return Carried(
            course=course,
            configuration=self.configuration(course.pose),
            twist=course.twist,
            load=load,
            delivered=delivered,
        )

    def along(self, carried: Carried) -> TaskPoint:
        """See `infinivar.machines.links`."""
        return self._along(carried)

    @property
    def _carries(self) -> bool:
        return self.mass is not None and self.inertia is not None

    @property
    def _massless(self) -> str:
        return f"{'mass' if self.mass is None else 'inertia'} is missing"

    def moving(self, load_mass: float = 0.0, load_inertia: float = 0.0) -> PlatformMachine | SeparateMachine:
        """The platform with its inertia, and that of a load, for `infinivar.simulate_machine`.

        Parameters
        ----------
        load_mass, load_inertia : float   Moved with the end point; the inertia is the same about all axes. [kg], [kg m^2]

        Raises
        ------
        ParameterError
            If an inertia that motion requires is missing, or a separate drive cannot be simulated.
        """
        mass = needed(self.mass, "mass") + load_mass
        inertia = [one + load_inertia for one in needed(self.inertia, "inertia")]
        if self.leg is None:
            assert self.separate is not None
            load = PlatformLoad(platform=self.platform, mass=mass, inertia=np.array(inertia))
            return SeparateMachine(separate=self.separate, load=load, home=np.array(self.home))
        needed(self.leg.steering, "leg.steering")
        return PlatformMachine(leg=self.leg, platform=self.platform, mass=mass, inertia=inertia)

    def followed(self, pose: Array, wrench: Array) -> tuple[np.ndarray, np.ndarray]:
        """Configuration of the machine in motion, and forces on it, of poses and wrenches (..., 6): these themselves."""
        return np.asarray(pose, dtype=float), np.asarray(wrench, dtype=float)


@dataclass(frozen=True, slots=True, kw_only=True)
class ArmDrive(_Side):
    """A planar arm of one to three joints, each moved by a leg on one common cylinder, or by a drive of its own.

    With two joints the end point has x and y, with three its direction as well, with one only the angle of the joint.
    """

    WORD: ClassVar[str] = "arm"
    one_of: ClassVar[tuple[str, ...]] = ("leg", "separate")
    """Fields of which exactly one is given."""

    lengths: tuple[float, ...] = quantities("m", Gt(0), "Lengths of the members, from the base")
    pulley_radius: float = quantity("m", Gt(0), "Radius of the pulley by which a leg or linear drive moves each joint")
    elbow: Elbow = component("Side to which the elbow points, seen from the base to the end point", default="right")
    leg: CoboticDrive | None = component("One leg with the motor of the common cylinder", default=None)
    separate: ConventionalDrive | None = component("Drive of each joint, with a motor of its own", default=None)
    member_masses: tuple[float, ...] | None = quantities(
        "kg", Ge(0), "Masses of the members, which are uniform, from the base, for simulation", default=None
    )
    arm: PlanarArm = field(init=False, repr=False, compare=False, default=None)  # type: ignore[assignment]
    legs: LeggedDrive | None = field(init=False, repr=False, compare=False, default=None)

    __repr__ = brief

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        require(1 <= len(self.lengths) <= 3, "lengths", f"{len(self.lengths)} members", "one to three members")
        if self.member_masses is not None:
            count = len(self.lengths)
            require(
                len(self.member_masses) == count,
                "member_masses",
                f"{len(self.member_masses)} values",
                f"{count}, one for each member",
            )
            require(self.member_masses[-1] > 0, "member_masses", f"{self.member_masses[-1]:g} at the end", "> 0", "kg")
        object.__setattr__(self, "arm", PlanarArm(lengths=self.lengths))
        object.__setattr__(self, "legs", self._legs(self.links))

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Of the end point."""
        return {1: ("angle",), 2: ("x", "y"), 3: ("x", "y", "angle")}[len(self.lengths)]

    @property
    def links(self) -> int:
        """Number of joints."""
        return len(self.lengths)

    @property
    def span(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Positions along x and y worth a map: the reach. [m]"""
        reach = 1.02 * sum(self.lengths)
        return (-reach, reach), (-reach, reach)

    @property
    def home(self) -> tuple[float, ...]:
        """The end point with the first joint at 0 and all others at a right angle."""
        angles = np.zeros(len(self.lengths))
        angles[1:] = 0.5 * np.pi * (1.0 if self.elbow == "right" else -1.0)
        return tuple(map(float, self._end(angles)))

    def _end(self, angles: np.ndarray) -> np.ndarray:
        found = self.arm.end_point(angles)
        return {1: found[..., 2:], 2: found[..., :2], 3: found}[len(self.lengths)]

    def angles(self, pose: Array) -> np.ndarray:
        """Joint angles at which the end point is at a pose; nan beyond reach.

        Parameters
        ----------
        pose : (..., d) float   In `coordinates`. [m], [rad]

        Returns
        -------
        (..., n) float   [rad]

        Source: law of cosines.
        """
        row = np.asarray(pose, dtype=float)
        if len(self.lengths) == 1:
            return row
        first, second = self.lengths[:2]
        x, y = row[..., 0], row[..., 1]
        if len(self.lengths) == 3:
            x, y = x - self.lengths[2] * np.cos(row[..., 2]), y - self.lengths[2] * np.sin(row[..., 2])
        cosine = (x * x + y * y - first**2 - second**2) / (2.0 * first * second)
        side = 1.0 if self.elbow == "right" else -1.0
        inner = np.where(np.abs(cosine) <= 1.0, cosine, np.nan)
        bend = side * np.arccos(inner)
        shoulder = np.arctan2(y, x) - np.arctan2(second * np.sin(bend), first + second * np.cos(bend))
        found = [shoulder, bend]
        if len(self.lengths) == 3:
            found.append(row[..., 2] - shoulder - bend)
        return np.stack(found, axis=-1)

    def reach(self, pose: Array) -> np.ndarray:
        """Demand on the reach: 1 with the arm stretched or folded. (...,) [-]"""
        row = np.asarray(pose, dtype=float)
        if len(self.lengths) == 1:
            return np.zeros(row.shape[:-1])
        first, second = self.lengths[:2]
        x, y = row[..., 0], row[..., 1]
        if len(self.lengths) == 3:
            x, y = x - self.lengths[2] * np.cos(row[..., 2]), y - self.lengths[2] * np.sin(row[..., 2])
        return np.abs(x * x + y * y - first**2 - second**2) / (2.0 * first * second)

    def part_speeds(self, pose: np.ndarray, twist: np.ndarray) -> np.ndarray:
        """Of the links, or of belts at the joints' pulleys; nan beyond reach. (..., n) [m s^-1]"""
        return self.pulley_radius * self._placed(pose, twist, 0.0 * twist)[1]

    def perform(self, *, pose: Array, twist: Array, wrench: Array) -> TaskPoint:
        """As `infinivar.machines.machine.Machine.perform`; beyond reach all is nan."""
        pose, twist, wrench = rows(self, pose, twist, wrench)
        _, rates, torques, configuration = self._placed(pose, twist, wrench)
        return moved(
            configuration,
            self.legs,
            self.separate,
            rates,
            torques,
            lever=self.pulley_radius,
            words="joint",
            units=("N m", "rad/s"),
        )

    def carried(self, course: MachineCourse) -> Carried:
        """What the joints carry along a course, with what accelerates the members; beyond reach all is nan.

        Source: `infinivar.machines.bodies.planar_arm`.
        """
        angles, rates, torques, configuration = self._placed(course.pose, course.twist, course.wrench)
        load = torques[1:4]
        if self._carries:
            arm = ArmLoad(
                arm=self.arm,
                pulleys=np.full(self.links, self.pulley_radius),
                masses=np.array(self.member_masses),
                tip_mass=0.0,
            )
            shape, n = rates[1:4].shape, self.links
            members = arm.inertia(angles[1:4].reshape(-1, n), rates[1:4].reshape(-1, n))
            pushed = np.matmul(members.inertia.reshape(*shape, n), course.rate(rates)[..., None])[..., 0]
            load = load + pushed + members.bias.reshape(shape)
        delivered = np.sum(course.wrench[2] * course.twist[2], axis=-1)
        return Carried(course=course, configuration=configuration, twist=rates, load=load, delivered=delivered)

    def along(self, carried: Carried) -> TaskPoint:
        """See `infinivar.machines.links`."""
        return self._along(carried, self.pulley_radius, "joint", ("N m", "rad/s"))

    @property
    def _carries(self) -> bool:
        return self.member_masses is not None

    @property
    def _massless(self) -> str:
        return "member_masses is missing"

    def _placed(
        self, pose: np.ndarray, twist: np.ndarray, wrench: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, Configuration]:
        """Joint angles, rates and torques, and the links over the pulleys; nan beyond reach."""
        angles, n = self.angles(pose), len(self.lengths)
        reach = self.reach(pose)
        within = np.isfinite(angles).all(axis=-1) & (reach < 1.0)
        safe = np.where(within[..., None], angles, np.linspace(0.3, 0.6, n))
        jacobian = self._jacobian(safe)
        rates = np.linalg.solve(jacobian, twist[..., None])[..., 0]
        torques = np.matmul(np.swapaxes(jacobian, -1, -2), wrench[..., None])[..., 0]
        utilisation = {} if n == 1 else {Limit.LINKAGE: np.where(within, reach, np.maximum(reach, 1.0 + 1e-12))}
        rim = np.diag(np.full(n, self.pulley_radius))
        configuration = Configuration(jacobian=np.where(within[..., None, None], rim, np.nan), utilisation=utilisation)
        return safe, rates, torques, configuration

    def moving(self, load_mass: float = 0.0, load_inertia: float = 0.0) -> ArmMachine | SeparateMachine:
        """The arm with the masses of its members, and a load at its end point, for `infinivar.simulate_machine`.

        Parameters
        ----------
        load_mass, load_inertia : float   Moved with the end point; the inertia turns with the last member. [kg], [kg m^2]

        Raises
        ------
        ParameterError
            If a value that motion requires is missing, or a separate drive cannot be simulated; or with one joint, whose angle
            is the coordinate, if there is a mass.
        """
        if load_mass and len(self.lengths) == 1:
            raise ParameterError(
                f"load_mass must be 0 for an arm of one joint, got {load_mass:g} kg: state load_inertia about the joint"
            )
        masses = needed(self.member_masses, "member_masses")
        if self.leg is None:
            assert self.separate is not None
            rim = 1.0 if axis_of(self.separate).rotary else self.pulley_radius
            load = ArmLoad(
                arm=self.arm,
                pulleys=np.full(self.links, rim),
                masses=np.array(masses),
                tip_mass=load_mass,
                tip_inertia=load_inertia,
            )
            return SeparateMachine(separate=self.separate, load=load, home=np.zeros(self.links))
        needed(self.leg.steering, "leg.steering")
        return ArmMachine(
            leg=self.leg,
            arm=self.arm,
            pulley_radius=self.pulley_radius,
            member_masses=masses,
            tip_mass=load_mass,
            tip_inertia=load_inertia,
        )

    def followed(self, pose: Array, wrench: Array) -> tuple[np.ndarray, np.ndarray]:
        """Joint angles (..., n), without turns between neighbours, and joint torques of poses and wrenches (..., n) of the end
        point; nan beyond reach."""
        angles = self.angles(pose)
        if angles.ndim > 1:
            angles = np.unwrap(angles, axis=0)
        across = np.swapaxes(self._jacobian(np.nan_to_num(angles)), -1, -2)
        torques = np.matmul(across, np.asarray(wrench, dtype=float)[..., None])[..., 0]
        return angles, torques + 0.0 * angles

    def _jacobian(self, angles: np.ndarray) -> np.ndarray:
        """Of the end point in `coordinates`. (..., n, n)"""
        full = self.arm.jacobian(angles)
        return {1: full[..., 2:, :], 2: full[..., :2, :], 3: full}[len(self.lengths)]


def legs_of(drive: Any) -> CoboticDrive | None:
    """The cobotic leg of a machine, if it has one."""
    leg = getattr(drive, "leg", None)
    return leg if isinstance(leg, CoboticDrive) else None


def motor_mass(drive: Any) -> float:
    """Mass of all motors of a machine, the steering motors included; nan where one is unknown or there is none. [kg]"""
    leg, separate = getattr(drive, "leg", None), getattr(drive, "separate", None)
    if leg is not None:
        steering = 0.0 if leg.steering is None else _mass(leg.steering.motor)
        return _mass(leg.motor) + drive.links * steering
    if separate is not None:
        return drive.links * _mass(separate.motor)
    return _mass(getattr(drive, "motor", None))


def _mass(motor: Any) -> float:
    mass = getattr(motor, "mass", None)
    return float("nan") if mass is None else float(mass)
