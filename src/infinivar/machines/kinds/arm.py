"""Planar arms: joints moved side by side by legs or by drives of their own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Literal

import numpy as np
from annotated_types import Ge, Gt

from infinivar._core.array_namespace import Array
from infinivar._core.arrays import real_array
from infinivar._core.bounds import FINITE
from infinivar._core.fields import brief, check, component, quantities, quantity
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import axis_of, needed
from infinivar.errors import ParameterError, require
from infinivar.limits import Limit
from infinivar.machines import bonds
from infinivar.machines.bodies import Moved, PlanarBody, joined, planar_arm
from infinivar.machines.hand import ArmGrip, Grip
from infinivar.machines.kinds.jointed import Jointed, check_payload
from infinivar.machines.kinds.linked import OnCylinder, SeparateMachine, check_leg
from infinivar.machines.linkage import LeggedMechanics, LinkMotion, Load
from infinivar.machines.machine import TaskPoint
from infinivar.machines.many_legs import LeggedDrive
from infinivar.machines.pictures import jointed
from infinivar.machines.pictures.jointed import Chain
from infinivar.machines.pictures.slides import Drum
from infinivar.machines.pictures.strokes import Picture
from infinivar.transmission.arm import PlanarArm

Elbow = Literal["left", "right"]

CENTRES = "Distance of each member's centre of mass from its joint, along the member"
OFFSETS = "Distance of each member's centre of mass to the left of the member, if not on it"
INERTIAS = "Moments of inertia of the members about their centres of mass"
GRAVITY = "Acceleration of free fall along x and y; none of an arm in a horizontal plane"


@dataclass(frozen=True, slots=True, kw_only=True)
class ArmLoad(Load):
    """An arm of members, uniform unless stated otherwise, with a pulley on each joint and a mass at the end point."""

    arm: PlanarArm
    pulleys: np.ndarray
    """Radii. (n,) [m]"""
    masses: np.ndarray
    """Of the members. (n,) [kg]"""
    tip_mass: float = 0.0
    tip_inertia: float = 0.0
    """Moment of inertia at the end point, which turns with the last member. [kg m^2]"""
    demands: tuple[tuple[Limit, str], ...] = ()
    inertias: np.ndarray | None = None
    """Of the members about their centres of mass; None: of uniform rods. (n,) [kg m^2]"""
    centres: np.ndarray | None = None
    """See `planar_arm`. (n, 2) [m]"""
    gravity: tuple[float, ...] | None = None
    """Along x and y. (2,) [m s^-2]"""

    slides: ClassVar[bool] = False

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Rates of the joints."""
        return tuple(f"q{place + 1}_rate_rad_s" for place in range(self.arm.joints))

    @property
    def configuration(self) -> tuple[str, ...]:
        """Joint angles."""
        return tuple(f"q{place + 1}_rad" for place in range(self.arm.joints))

    @property
    def bodies(self) -> list[PlanarBody]:
        """The members in axes from their joints along themselves, without what is at the end point."""
        lengths = np.asarray(self.arm.lengths)
        inertias = self.masses * lengths**2 / 12.0 if self.inertias is None else self.inertias
        centres = np.stack([0.5 * lengths, 0.0 * lengths], axis=-1) if self.centres is None else self.centres
        return [PlanarBody(*one) for one in zip(self.masses.tolist(), centres, inertias.tolist(), strict=True)]

    def inertia(self, angles: np.ndarray, rates: np.ndarray) -> Moved:
        """Of the arm without pulleys and links; the bias holds its weight."""
        inertias = np.array([one.inertia for one in self.bodies])
        inertias[-1] += self.tip_inertia
        return planar_arm(
            np.asarray(self.arm.lengths),
            self.masses,
            inertias,
            self.tip_mass,
            angles,
            rates,
            centres=self.centres,
            gravity=self.gravity,
        )

    def at(self, pose: np.ndarray, twist: np.ndarray) -> LinkMotion:
        """Kinematics and inertia."""
        jacobian = np.broadcast_to(np.diag(self.pulleys), (len(pose), *np.diag(self.pulleys).shape))
        nothing = np.zeros((len(pose), 0))
        return LinkMotion(jacobian, self.pulleys * twist, 0.0 * twist, twist, self.inertia(pose, twist), nothing)

    @property
    def links(self) -> int:
        """Number of links."""
        return self.arm.joints

    def grip(self, coordinates: int) -> Grip:
        """The end point."""
        return ArmGrip(arm=self.arm, coordinates=coordinates)

    def outline(self, link_mass: float, drum: Drum | None) -> Chain:
        """Members and pulleys."""
        return Chain(
            lengths=np.asarray(self.arm.lengths),
            members=self.bodies,
            tip_mass=self.tip_mass,
            tip_inertia=self.tip_inertia,
            pulleys=self.pulleys,
            link_mass=link_mass,
            drum=drum,
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ArmMachine(OnCylinder):
    """A planar arm, each joint moved over a pulley by a leg on a common cylinder; members are uniform unless stated otherwise.

    Raises
    ------
    ParameterError
        If a field is out of range, numbers differ, or the leg has springs or a linkage of its own.
    """

    leg: CoboticDrive = component("One of the legs, with its motor, cylinder, steering and control")
    arm: PlanarArm = component("Geometry")
    pulley_radius: float | Sequence[float] = component("Radius of each joint's pulley [m]")
    member_masses: Sequence[float] = quantities("kg", Ge(0), "Masses of the members")
    tip_mass: float = quantity("kg", Ge(0), "Mass at the end point", default=0.0)
    tip_inertia: float = quantity(
        "kg m^2", Ge(0), "Moment of inertia at the end point, which turns with the last member", default=0.0
    )
    member_centres: Sequence[float] | None = quantities("m", FINITE, CENTRES, default=None)
    member_offsets: Sequence[float] | None = quantities("m", FINITE, OFFSETS, default=None)
    member_inertias: Sequence[float] | None = quantities("kg m^2", Ge(0), INERTIAS, default=None)
    gravity: Sequence[float] | None = quantities("m/s^2", FINITE, GRAVITY, default=None)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        check_leg(self.leg)
        check_members(self, self.arm.joints)
        _ = self.arm.parallel(self.pulley_radius)

    @property
    def home(self) -> np.ndarray:
        """Joint angles at the start."""
        return np.zeros(self.arm.joints)

    def bonds(self, stick_speed: float) -> bonds.Bonds:
        """Legs, pulleys and members; links first: their masses are the independent storages."""
        mechanics = self.mechanics(stick_speed)
        radii = mechanics.load.pulleys  # type: ignore[attr-defined]
        joints = [f"q_{joint}" for joint in range(1, len(radii) + 1)]
        legs = bonds.legs(mechanics, stick_speed)
        return bonds.Bonds.of(legs, bonds.pulleys(radii), bonds.members(mechanics.load), bonds.user(joints))

    def mechanics(self, stick_speed: float) -> LeggedMechanics:
        """Contacts and inertia."""
        radii = np.diag(self.arm.parallel(self.pulley_radius).jacobian)
        load = arm_load(self, radii, tip_mass=self.tip_mass, tip_inertia=self.tip_inertia)
        return self.on_cylinder(load, self.arm.joints, stick_speed)


def check_members(machine: Any, count: int) -> None:
    """Raise `ParameterError` unless each member has a mass, the last one more than 0, and what else is stated of them fits."""
    for name in ("member_masses", "member_centres", "member_offsets", "member_inertias"):
        row = getattr(machine, name)
        if row is not None:
            require(len(row) == count, name, f"{len(row)} values", f"{count}, one for each member")
    for name, two in (("payload_centre", "along and to the left"), ("gravity", "along x and y")):
        row = getattr(machine, name, None)
        if row is not None:
            require(len(row) == 2, name, f"{len(row)} values", f"2: {two}")
    masses = machine.member_masses
    if masses is None:
        return
    require(masses[-1] > 0, "member_masses", f"{masses[-1]:g} at the end", "> 0", "kg")
    uneven = next((name for name in ("member_centres", "member_offsets") if getattr(machine, name) is not None), None)
    if uneven and machine.member_inertias is None:
        raise ParameterError(f"member_inertias is missing: with {uneven}, members are not uniform")


def arm_load(machine: Any, pulleys: np.ndarray, tip_mass: float = 0.0, tip_inertia: float = 0.0) -> ArmLoad:
    """The members of an arm that has the fields of `ArmMachine`, with pulleys of some radii on the joints."""
    centres, lengths = None, np.array(machine.arm.lengths)
    if machine.member_centres is not None or machine.member_offsets is not None:
        along = 0.5 * lengths if machine.member_centres is None else machine.member_centres
        across = 0.0 * lengths if machine.member_offsets is None else machine.member_offsets
        centres = np.stack([along, across], axis=-1)
    return ArmLoad(
        arm=machine.arm,
        pulleys=pulleys,
        masses=real_array("member_masses", machine.member_masses),
        inertias=None if machine.member_inertias is None else np.array(machine.member_inertias, dtype=float),
        centres=centres,
        gravity=None if machine.gravity is None else tuple(map(float, machine.gravity)),
        tip_mass=tip_mass,
        tip_inertia=tip_inertia,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class ArmDrive(Jointed):
    """A planar arm of one to three joints, each moved by a leg on one common cylinder, or by a drive of its own.

    With two joints the end point has x and y, with three its direction as well, with one only the angle of the joint.
    """

    WORD: ClassVar[str] = "arm"
    shown: ClassVar[str] = (
        ", drawn from its geometry: torques of the joints on the load, force and velocity of the end point, and the forces that "
        "it can exert there within all limits."
    )
    MASSES: ClassVar[tuple[str, ...]] = ("member_masses",)
    one_of: ClassVar[tuple[str, ...]] = ("leg", "separate")
    """Fields of which exactly one is given."""

    lengths: tuple[float, ...] = quantities("m", Gt(0), "Lengths of the members, from the base")
    pulley_radius: float | None = quantity(
        "m", Gt(0), "Radius of the pulley by which a leg or linear drive moves each joint", default=None
    )
    elbow: Elbow = component("Side to which the elbow points, seen from the base to the end point", default="right")
    leg: CoboticDrive | None = component("One leg with the motor of the common cylinder", default=None)
    separate: ConventionalDrive | None = component("Drive of each joint, with a motor of its own", default=None)
    member_masses: tuple[float, ...] | None = quantities(
        "kg", Ge(0), "Masses of the members from the base; uniform unless their centres are stated", default=None
    )
    member_centres: tuple[float, ...] | None = quantities("m", FINITE, CENTRES, default=None)
    member_offsets: tuple[float, ...] | None = quantities("m", FINITE, OFFSETS, default=None)
    member_inertias: tuple[float, ...] | None = quantities("kg m^2", Ge(0), INERTIAS, default=None)
    payload_mass: float = quantity("kg", Ge(0), "Mass of what the last member carries, such as a tool", default=0.0)
    payload_centre: tuple[float, ...] | None = quantities(
        "m", FINITE, "Its centre of mass from the end point: ahead along the last member, and to its left", default=None
    )
    payload_inertia: float = quantity(
        "kg m^2", Ge(0), "Its moment of inertia about its centre of mass, turning with the last member", default=0.0
    )
    gravity: tuple[float, ...] | None = quantities("m/s^2", FINITE, GRAVITY, default=None)
    arm: PlanarArm = field(init=False, repr=False, compare=False, default=None)  # type: ignore[assignment]
    legs: LeggedDrive | None = field(init=False, repr=False, compare=False, default=None)

    __repr__ = brief

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        self._check_pulley()
        require(1 <= len(self.lengths) <= 3, "lengths", f"{len(self.lengths)} members", "one to three members")
        self._check_masses()
        object.__setattr__(self, "arm", PlanarArm(lengths=self.lengths))
        object.__setattr__(self, "legs", self._legs(self.links))

    def _check_masses(self) -> None:
        check_members(self, self.links)
        if self.member_masses is None and self._massive:
            raise ParameterError(f"member_masses is missing: {self._massive[0]} is stated")
        check_payload(self)

    @property
    def _massive(self) -> list[str]:
        """Stated fields of masses besides those of uniform members in a horizontal plane."""
        rows = ("member_centres", "member_offsets", "member_inertias", "payload_centre", "gravity")
        numbers = ("payload_mass", "payload_inertia")
        return [name for name in numbers if getattr(self, name)] + [
            name for name in rows if getattr(self, name) is not None
        ]

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

    def picture(self, point: TaskPoint, pose: np.ndarray, twist: np.ndarray, wrench: np.ndarray) -> Picture:
        """Its members, with the torques of its joints."""
        return jointed.picture(self, point, pose, twist, wrench)

    def _solved(self, pose: np.ndarray) -> tuple[np.ndarray, dict[Limit, np.ndarray]]:
        angles, reach = self.angles(pose), self.reach(pose)
        within = np.isfinite(angles).all(axis=-1) & (reach < 1.0)
        demand = np.where(within, reach, np.maximum(reach, 1.0 + 1e-12))
        return np.where(within[..., None], angles, np.nan), {} if self.links == 1 else {Limit.LINKAGE: demand}

    def _members(self) -> ArmLoad:
        """Masses of the arm; the payload is a part of the last member."""
        load = arm_load(self, np.full(self.links, self.link_lever))
        if not self.payload_mass:
            return load
        held = np.array([self.lengths[-1], 0.0]) + np.array(self.payload_centre or (0.0, 0.0))
        members = load.bodies
        members[-1] = joined(members[-1], PlanarBody(self.payload_mass, held, self.payload_inertia))
        masses, centres, inertias = (np.array(one) for one in zip(*members, strict=True))
        return replace(load, masses=masses, centres=centres, inertias=inertias)

    def moving(self, load_mass: float = 0.0, load_inertia: float = 0.0) -> ArmMachine | SeparateMachine:
        """The arm with the masses of its members, and a load at its end point, for `infinivar.simulate_machine`.

        Parameters
        ----------
        load_mass, load_inertia : float   Moved with the end point; the inertia turns with the last member, and the weight is
            a part of the wrench. [kg], [kg m^2]

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
        needed(self.member_masses, "member_masses")
        load = self._members()
        if self.leg is None:
            assert self.separate is not None
            rim = 1.0 if axis_of(self.separate).rotary else self.link_lever
            load = replace(load, pulleys=np.full(self.links, rim), tip_mass=load_mass, tip_inertia=load_inertia)
            return SeparateMachine(separate=self.separate, load=load, home=np.zeros(self.links))
        needed(self.leg.steering, "leg.steering")
        centres = (None, None) if load.centres is None else load.centres.T.tolist()
        return ArmMachine(
            leg=self.leg,
            arm=self.arm,
            pulley_radius=self.link_lever,
            member_masses=load.masses.tolist(),
            member_centres=centres[0],
            member_offsets=centres[1],
            member_inertias=None if load.inertias is None else load.inertias.tolist(),
            tip_mass=load_mass,
            tip_inertia=load_inertia,
            gravity=load.gravity,
        )

    def _jacobian(self, angles: np.ndarray) -> np.ndarray:
        """Of the end point in `coordinates`. (..., n, n)"""
        full = self.arm.jacobian(angles)
        return {1: full[..., 2:, :], 2: full[..., :2, :], 3: full}[len(self.lengths)]
