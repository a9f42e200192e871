"""Machines whose joints or links are driven side by side: by legs on one common cylinder, or by a drive of its own each.

Both share the kinematic map (`Configuration`); they differ in what moves the links. So a cobotic machine and its conventional
rival are one class with another field, `leg` or `separate`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np
from annotated_types import Ge, Gt, Interval

from infinivar._core.array_namespace import Array
from infinivar._core.bounds import FINITE
from infinivar._core.fields import brief, check, component, quantities, quantity, several
from infinivar._core.text import joined
from infinivar.axis import LINEAR
from infinivar.bondgraph.graph import Parameter, Signal
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ALONG_A_LINE, ConventionalDrive
from infinivar.drivetrain.drive import axis_of, needed
from infinivar.errors import InputError, ParameterError, require
from infinivar.limits import Limit
from infinivar.machines import bonds
from infinivar.machines.bodies import (
    Moved,
    rigid_body,
)
from infinivar.machines.course import MachineCourse
from infinivar.machines.kinds.linked import Linked, OnCylinder, SeparateMachine, check_leg
from infinivar.machines.linkage import LeggedMechanics
from infinivar.machines.links import Carried, lifting, moved
from infinivar.machines.machine import TaskPoint, rows
from infinivar.machines.many_legs import LeggedDrive
from infinivar.machines.pictures import rods
from infinivar.machines.pictures.strokes import Picture
from infinivar.machines.platform_load import PlatformLoad
from infinivar.motion.vectors import Point
from infinivar.transmission.configuration import Configuration
from infinivar.transmission.platform import Platform


@dataclass(frozen=True, slots=True, kw_only=True)
class PlatformGeometry:
    """Six rods in three pairs, or rods anywhere: the positions of the guideways and of the platform's joints."""

    rod_length: float = quantity("m", Gt(0), "Length of the rods between their joints")
    base_radius: float | None = quantity(
        "m", Gt(0), "Radius of the circle of guideways, for rods in pairs", default=None
    )
    joint_radius: float | None = quantity(
        "m", Gt(0), "Radius of the circle of platform joints, for rods in pairs", default=None
    )
    base_spread: float | None = quantity(
        "rad", Interval(gt=0, lt=1.6), "Half the angle between the guideways of a pair", default=None
    )
    joint_spread: float | None = quantity(
        "rad", Interval(gt=0, lt=1.6), "Half the angle between the joints of two rods that meet", default=None
    )
    guideways: tuple[Point, ...] | None = several("Positions of the guideways, instead of pairs", Point, default=None)
    joints: tuple[Point, ...] | None = several("Joints in axes of the platform, instead of pairs", Point, default=None)
    lowest: float | None = quantity("m", FINITE, "Lowest position of the links; unlimited if not given", default=None)
    highest: float | None = quantity("m", FINITE, "Highest position of the links; unlimited if not given", default=None)
    platform: Platform = field(init=False, repr=False, compare=False, default=None)  # type: ignore[assignment]

    def __post_init__(self) -> None:
        """Validate the fields and make the platform."""
        check(self)
        pairs = [name for name in _PAIRS if getattr(self, name) is not None]
        points = [name for name in _POINTS if getattr(self, name) is not None]
        if pairs and points:
            raise ParameterError(
                f"{points[0]} and {pairs[0]} exclude each other: state rods in pairs by {', '.join(_PAIRS)}, or "
                f"{' and '.join(_POINTS)}"
            )
        missing = [name for name in (_POINTS if points else _PAIRS) if getattr(self, name) is None]
        if missing:
            raise ParameterError(f"{missing[0]} is missing: rods need {', '.join(_PAIRS)}, or {' and '.join(_POINTS)}")
        if (self.lowest is None) is not (self.highest is None):
            lacking = "lowest" if self.lowest is None else "highest"
            raise ParameterError(f"{lacking} is missing: a stroke has both ends, lowest and highest")
        stroke = None if self.lowest is None or self.highest is None else (self.lowest, self.highest)
        if stroke is not None:
            require(stroke[0] < stroke[1], "highest", f"{stroke[1]:g} m", f"> lowest, {stroke[0]:g} m")
        if points:
            rows = [[one.row(("x", "y", "z")) for one in getattr(self, name)] for name in _POINTS]
            for name, row in zip(_POINTS, rows, strict=True):
                require(len(row) >= 6, name, f"{len(row)} points", "6 or more, one for each rod")
            require(len(rows[0]) == len(rows[1]), "joints", f"{len(rows[1])}", f"as many as guideways, {len(rows[0])}")
            made = Platform(base=rows[0], joints=rows[1], rod_length=self.rod_length, stroke=stroke)
        else:
            pairs = {name: getattr(self, name) for name in _PAIRS}
            made = replace(Platform.hexapod(**pairs, rod_length=self.rod_length, stroke=stroke), provenance="given")
        _ = made.home  # refuses rods that do not reach the platform
        object.__setattr__(self, "platform", made)


RODS = "Mass of each rod, uniform between its joints and slender"
GRAVITY = "Acceleration of free fall along x, y and z, the axis of the cylinder; without it nothing weighs"

_ROUNDED = 0.01
"""Part of the largest moment of inertia by which the other two may fall short of it, as rounded values of a flat body do."""

_PAIRS = ("base_radius", "joint_radius", "base_spread", "joint_spread")
_POINTS = ("guideways", "joints")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlatformMachine(OnCylinder):
    """A platform on rods, moved by legs on a common cylinder. Its origin is the centre of mass.

    Raises
    ------
    ParameterError
        If a field is out of range, or the leg has springs or a linkage of its own.
    """

    leg: CoboticDrive = component("One of the legs, with its motor, cylinder, steering and control")
    platform: Platform = component("Geometry")
    mass: float = quantity("kg", Gt(0), "Mass of the platform with what it carries")
    inertia: Sequence[float] = quantities("kg m^2", Gt(0), "Moments of inertia about its axes x, y and z")
    rod_mass: float = quantity("kg", Ge(0), RODS, default=0.0)
    gravity: Sequence[float] | None = quantities("m/s^2", FINITE, GRAVITY, default=None)
    load_mass: float = quantity("kg", Ge(0), "Part of the mass whose weight is a part of the wrench", default=0.0)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        check_leg(self.leg)
        require(len(self.inertia) == 3, "inertia", f"{len(self.inertia)} values", "three")
        _check_gravity(self)
        most = f"at most mass, {self.mass:g}"
        require(self.load_mass <= self.mass, "load_mass", f"{self.load_mass:g}", most, "kg")

    @property
    def home(self) -> np.ndarray:
        """Pose at the start: unrotated, with all links at 0 on average. (6,)"""
        return np.array([0.0, 0.0, self.platform.home, 0.0, 0.0, 0.0])

    def bonds(self, stick_speed: float) -> bonds.Bonds:
        """Platform in its own axes, rods and legs.

        Raises
        ------
        ParameterError
            If rods have masses, or there is weight.
        """
        for name in ("rod_mass", "gravity"):
            if getattr(self, name):
                raise ParameterError(
                    f"{name} must be left out for a bond graph: in it rods are massless and nothing weighs"
                )
        mechanics = self.mechanics(stick_speed)
        unrotated = np.zeros((1, 6))
        moves = [bonds.Coordinate(f"v_{one}", f"v_{one}", f"I_v_{one}", "m_p", "kg", "platform") for one in "xyz"]
        turns = [
            bonds.Coordinate(f"w_{one}", rf"\omega_{one}", f"I_w_{one}", f"I_{one}", "kg m^2", "platform")
            for one in "xyz"
        ]
        inertia = rigid_body(self.mass, np.asarray(self.inertia), np.eye(3)[None], unrotated).inertia[0]
        body = bonds.inertias([*moves, *turns], inertia)
        body.signals.extend(Signal(name=f"turn_{one}", symbol=rf"\omega_{one}", of=f"w_{one}") for one in "xyz")
        # Euler's equations: I_x dw_x = (I_y - I_z) w_y w_z; three gyrators, each modulated by a momentum about its own axis.
        euler = []
        for first, second, third in ("xyz", "yzx", "zxy"):
            moment = Parameter(f"I_{third}", float(self.inertia["xyz".index(third)]), "kg m^2")
            between, turn = (f"w_{first}", f"w_{second}"), f"turn_{third}"
            euler.append(
                bonds.axes_that_turn(f"euler_{third}", rf"I_{third}\omega_{third}", between, turn, moment, 1.0)
            )
        ports = [one.name for one in (*moves, *turns)]
        rods, legs = bonds.jacobian(ports, mechanics.count), bonds.legs(mechanics, stick_speed)
        return bonds.Bonds.of(body, *euler, rods, legs, bonds.user(ports))

    def mechanics(self, stick_speed: float) -> LeggedMechanics:
        """Contacts and inertia."""
        load = PlatformLoad(
            platform=self.platform,
            mass=self.mass,
            inertia=np.asarray(self.inertia),
            rod_mass=self.rod_mass,
            gravity=None if self.gravity is None else tuple(self.gravity),
            load_mass=self.load_mass,
            link_mass=float(self.leg.mass_of_link or 0.0),
        )
        return self.on_cylinder(load, len(self.platform.base), stick_speed)


def _check_gravity(machine: PlatformMachine | PlatformDrive) -> None:
    row = machine.gravity
    require(row is None or len(row) == 3, "gravity", f"{len(row or ())} values", "3: along x, y and z")


@dataclass(frozen=True, slots=True, kw_only=True)
class PlatformDrive(Linked):
    """A platform on rods, whose links are moved by legs on one common cylinder, or by a drive of its own each.

    Source: faulring2006, section I and section VI, for the legs; its geometry is not published.
    """

    WORD: ClassVar[str] = "platform"
    shown: ClassVar[str] = ", drawn from its geometry. Forces are those of the user on the machine."
    MASSES: ClassVar[tuple[str, ...]] = ("mass", "inertia")
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
    rod_mass: float = quantity("kg", Ge(0), RODS, default=0.0)
    gravity: tuple[float, ...] | None = quantities("m/s^2", FINITE, GRAVITY, default=None)
    legs: LeggedDrive | None = field(init=False, repr=False, compare=False, default=None)

    __repr__ = brief

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        _check_gravity(self)
        for name in ("rod_mass", "gravity"):
            if getattr(self, name) and self._massless:
                raise ParameterError(f"{self._massless} is missing: {name} is stated")
        object.__setattr__(self, "legs", self._legs(self.links))
        if self.inertia is not None:
            require(len(self.inertia) == 3, "inertia", f"{len(self.inertia)} values", "three: about x, y and z")
            third = max(self.inertia)
            fits = (1.0 - _ROUNDED) * third <= sum(self.inertia) - third
            said = ", ".join(f"{one:g}" for one in self.inertia)
            require(
                fits,
                "inertia",
                said,
                "moments of which two add up to no less than the third, as of all bodies",
                "kg m^2",
            )
        if self.separate is not None and axis_of(self.separate) is not LINEAR:
            raise ParameterError(
                f"separate must move a link along a line, not a joint: give it a {joined(ALONG_A_LINE, 'or')}"
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

    @property
    def link_travel(self) -> float | None:
        """See `Linked.link_travel`: the stroke."""
        ends = self.platform.stroke
        return None if ends is None else ends[1] - ends[0]

    def link_positions(self, pose: np.ndarray) -> np.ndarray:
        """See `Linked.link_positions`."""
        return np.asarray(self.configuration(pose).link_position)

    def part_speeds(self, pose: np.ndarray, twist: np.ndarray) -> np.ndarray:
        """Of the links. (..., n) [m s^-1]"""
        return self.configuration(pose).link_speeds(twist)

    def perform(self, *, pose: Array, twist: Array, wrench: Array) -> TaskPoint:
        """As `infinivar.machines.machine.Machine.perform`."""
        pose, twist, wrench = rows(self, pose, twist, wrench)
        if self.gravity is None:
            return moved(self.configuration(pose), self.legs, self.separate, twist, wrench)
        weight = self._moved(pose, 0.0 * twist).bias.reshape(twist.shape)
        point = moved(self.configuration(pose), self.legs, self.separate, twist, wrench + weight)
        return lifting(point, weight, twist)

    def picture(self, point: TaskPoint, pose: np.ndarray, twist: np.ndarray, wrench: np.ndarray) -> Picture:
        """The platform on its rods, in space."""
        leg, platform = self.leg, self.platform
        found = rods.standing(platform, pose, None if leg is None else leg.transmission)
        if leg is not None:
            for place in np.flatnonzero(~np.isfinite(point.steering)):
                raise InputError(
                    f"the wheel of leg {place + 1} slips here: there is no steering angle at which its link moves as requested"
                )
            found = replace(found, steering=point.steering, cylinder_speed=leg.cylinder_speed)
        notes = () if platform.provenance == "given" else (f"geometry: {platform.provenance}",)
        shown = (("velocity", "velocity", twist[:3]), ("force", "force on the load", wrench[:3]))
        return rods.picture(found, pose[:3], shown, point=point, notes=notes)

    def carried(self, course: MachineCourse) -> Carried:
        """What the rods carry along a course, with what accelerates the platform.

        Source: Newton and Euler.
        """
        load = course.wrench[1:4]
        if not self._massless:
            pose, twist = np.broadcast_arrays(course.pose[1:4], course.twist[1:4])
            load = load + self._moved(pose, twist).forces(np.broadcast_to(course.acceleration[1:4], twist.shape))
        return Carried(course=course, configuration=self.configuration(course.pose), twist=course.twist, load=load)

    def _moved(self, pose: np.ndarray, twist: np.ndarray) -> Moved:
        """Inertia of platform and rods, with weights, at poses and twists (..., 6), in rows."""
        return self._load().at(pose.reshape(-1, 6), twist.reshape(-1, 6)).moved

    def _load(self, load_mass: float = 0.0, load_inertia: float = 0.0) -> PlatformLoad:
        """Platform and rods, with a load at the end point.

        Raises
        ------
        ParameterError
            If mass or inertia of the platform is missing.
        """
        return PlatformLoad(
            platform=self.platform,
            mass=needed(self.mass, "mass") + load_mass,
            inertia=np.array(needed(self.inertia, "inertia")) + load_inertia,
            rod_mass=self.rod_mass,
            gravity=self.gravity,
            load_mass=load_mass,
            link_mass=0.0 if self.leg is None else float(self.leg.mass_of_link or 0.0),
        )

    def along(self, carried: Carried) -> TaskPoint:
        """See `infinivar.machines.links`."""
        return self._along(carried)

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
        load = self._load(load_mass, load_inertia)
        if self.leg is None:
            assert self.separate is not None
            return SeparateMachine(separate=self.separate, load=load, home=np.array(self.home))
        needed(self.leg.steering, "leg.steering")
        return PlatformMachine(
            leg=self.leg,
            platform=self.platform,
            mass=load.mass,
            inertia=load.inertia.tolist(),
            rod_mass=load.rod_mass,
            gravity=load.gravity,
            load_mass=load_mass,
        )
