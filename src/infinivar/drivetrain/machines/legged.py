"""Machines whose joints or links are driven side by side: by legs on one common cylinder, or by a drive of its own each.

Both share the kinematic map (`Configuration`); they differ in what moves the links. So a cobotic machine and its conventional
rival are one class with another field, `leg` or `separate`.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Literal

import numpy as np
from annotated_types import Ge, Gt

from infinivar._core.array_namespace import Array
from infinivar._core.fields import check, component, quantities, quantity
from infinivar.axis import LINEAR
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import GEAR_LIMITS, axis_of, needed
from infinivar.drivetrain.machines.machine import TaskPoint, checked, held, rows, worst
from infinivar.drivetrain.machines.rods import PlatformGeometry
from infinivar.drivetrain.many_legs import LeggedDrive
from infinivar.drivetrain.moving.legged import ArmLoad, PlatformLoad
from infinivar.drivetrain.moving.machines import ArmMachine, PlatformMachine, SeparateMachine
from infinivar.errors import ParameterError, require
from infinivar.limits import Demand, Limit
from infinivar.transmission.arm import PlanarArm
from infinivar.transmission.configuration import Configuration
from infinivar.transmission.platform import Platform

Elbow = Literal["left", "right"]

_OF_CYLINDER = (Limit.THERMAL, Limit.VOLTAGE, Limit.SPEED, Limit.PEAK, Limit.REGENERATION, *GEAR_LIMITS)
"""Limits of the motor of the cylinder, its gearhead and amplifier."""


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
        speed, force = configuration.link_speeds(twist), configuration.link_forces(-wrench)
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
    found = leg.operate(configuration, wrench=-wrench, twist=twist)
    legs = found.legs
    shape = legs.link_force.shape
    demands = worst({Limit.SLIP: legs.slip_demand}, parts)
    for limit, demand in found.utilisation.items():
        if limit in configuration.utilisation or limit is Limit.SLIP:
            continue
        what = "gearhead" if limit in GEAR_LIMITS else "motor" if limit in _OF_CYLINDER else "wheel"
        demands[limit, what] = np.broadcast_to(demand, shape[:-1])
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


class _Side:
    """What platform and arm share: legs on one cylinder, or a drive for each link."""

    __slots__ = ()

    leg: CoboticDrive | None
    separate: ConventionalDrive | None

    @property
    def commands(self) -> tuple[str, ...]:
        """Commands that work besides those of all machines."""
        return ("contact", "simulate") if self.leg is not None else ("simulate",)

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

    def perform(self, *, pose: Array, twist: Array, wrench: Array) -> TaskPoint:
        """As `infinivar.drivetrain.machines.machine.Machine.perform`."""
        pose, twist, wrench = rows(self, pose, twist, wrench)
        return moved(self.configuration(pose), self.legs, self.separate, twist, wrench)

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

    def perform(self, *, pose: Array, twist: Array, wrench: Array) -> TaskPoint:
        """As `infinivar.drivetrain.machines.machine.Machine.perform`; beyond reach all is nan."""
        pose, twist, wrench = rows(self, pose, twist, wrench)
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
