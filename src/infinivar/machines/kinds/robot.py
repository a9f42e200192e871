"""Arms in space from a URDF or MJCF file: joints moved side by side by legs or by drives of their own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import ClassVar

import numpy as np
from annotated_types import Ge, Gt

from infinivar._core.array_namespace import Array
from infinivar._core.bounds import FINITE
from infinivar._core.fields import brief, check, chosen_words, component, quantities, quantity
from infinivar._core.text import joined
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import axis_of, needed
from infinivar.errors import InputError, ParameterError, require
from infinivar.limits import Limit
from infinivar.machines.bodies import Moved, SpatialBody, joined_in_space, spatial_arm
from infinivar.machines.hand import Grip, Held, Turned
from infinivar.machines.kinds.jointed import Jointed, check_payload
from infinivar.machines.kinds.linked import OnCylinder, SeparateMachine, check_leg
from infinivar.machines.linkage import LeggedMechanics, LinkMotion, Load
from infinivar.machines.machine import TaskPoint
from infinivar.machines.many_legs import LeggedDrive
from infinivar.machines.pictures import robots
from infinivar.machines.pictures.robots import TurningMembers
from infinivar.machines.pictures.slides import Drum
from infinivar.machines.pictures.strokes import Picture
from infinivar.motion.vectors import ROTATIONS, TRANSLATIONS
from infinivar.transmission.mjcf_arm import SUFFIXES, read_mjcf_arm
from infinivar.transmission.turning_chain import TurningChain
from infinivar.transmission.urdf_arm import read_urdf_arm

AXES = (*TRANSLATIONS, *ROTATIONS)
_FALL = (0.0, 0.0, -9.81)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RobotLoad(Load):
    """Members of an arm in space, with a pulley on each joint and a load at the tool whose weight is a part of the wrench."""

    chain: TurningChain
    bodies: tuple[SpatialBody, ...]
    pulleys: np.ndarray
    """Radii. (n,) [m]"""
    gravity: np.ndarray
    """(3,) [m s^-2]"""
    load_mass: float = 0.0
    load_inertia: float = 0.0
    """The same about all axes. [kg m^2]"""

    slides: ClassVar[bool] = False

    @property
    def links(self) -> int:
        """Number of joints."""
        return len(self.bodies)

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Rates of the joints."""
        return tuple(f"q{place + 1}_rate_rad_s" for place in range(self.links))

    @property
    def configuration(self) -> tuple[str, ...]:
        """Joint angles."""
        return tuple(f"q{place + 1}_rad" for place in range(self.links))

    @property
    def demands(self) -> tuple[tuple[Limit, str], ...]:
        """Travel of the joints that have ends."""
        ends = zip(self.chain.names, self.chain.ranges, strict=True)
        return tuple((Limit.TRAVEL, f"joint {name}") for name, range_ in ends if range_ is not None)

    @property
    def _held(self) -> SpatialBody:
        """The load at the tool."""
        return SpatialBody(self.load_mass, self.chain.tool_place, self.load_inertia * np.eye(3))

    def inertia(self, angles: np.ndarray, rates: np.ndarray) -> Moved:
        """Of the arm without pulleys and links; the bias holds its weight."""
        return spatial_arm(self.chain, self.chain.standing(angles), self.bodies, self._held, rates, self.gravity)

    def at(self, pose: np.ndarray, twist: np.ndarray) -> LinkMotion:
        """Kinematics and inertia."""
        jacobian = np.broadcast_to(np.diag(self.pulleys), (len(pose), self.links, self.links))
        limits = travel(self.chain, pose)
        demand = np.stack(limits, axis=-1) if limits else np.zeros((len(pose), 0))
        return LinkMotion(jacobian, self.pulleys * twist, 0.0 * twist, twist, self.inertia(pose, twist), demand)

    def grip(self, coordinates: int) -> Grip:
        """The origin of the tool."""
        return ToolGrip(chain=self.chain, coordinates=coordinates)

    def outline(self, link_mass: float, drum: Drum | None) -> TurningMembers:
        """Members and pulleys."""
        return TurningMembers(
            chain=self.chain,
            members=(*self.bodies[:-1], joined_in_space(self.bodies[-1], self._held)),
            pulleys=self.pulleys,
            link_mass=link_mass,
            drum=drum,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class ToolGrip:
    """The tool of an arm in space, whose joint rates are the first coordinates."""

    chain: TurningChain
    coordinates: int
    """Of the machine."""
    axes: tuple[str, ...] = TRANSLATIONS
    turns: tuple[str, ...] = ROTATIONS

    def at(self, configuration: np.ndarray, rates: np.ndarray) -> Held:
        """The handle in fixed axes."""
        at = self.chain.standing(configuration)
        jacobian = np.zeros_like(rates, shape=(len(rates), 6, self.coordinates))
        joints = configuration.shape[-1]
        jacobian[:, :, :joints] = self.chain.jacobian(at)
        place, turn = self.chain.tool(at)

        def drift() -> np.ndarray:
            return self.chain.drift(at, rates[:, :joints])

        return Held(
            place, jacobian[:, :3], lambda: drift()[:, :3], lambda: Turned(turn, jacobian[:, 3:], drift()[:, 3:])
        )


def travel(chain: TurningChain, angles: np.ndarray) -> list[np.ndarray]:
    """Demand on the range of each joint that has ends, at angles (..., n). (...,) each [-]"""
    ends = [(place, *one) for place, one in enumerate(chain.ranges) if one is not None]
    return [np.abs(angles[..., place] - 0.5 * (low + high)) / (0.5 * (high - low)) for place, low, high in ends]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RobotMachine(OnCylinder):
    """An arm in space, each joint moved over a pulley by a leg on a common cylinder; `RobotDrive.moving` makes it.

    Raises
    ------
    ParameterError
        If the leg has springs or a linkage of its own.
    """

    leg: CoboticDrive = component("One of the legs, with its motor, cylinder, steering and control")
    load: RobotLoad = component("Joints, pulleys and masses")
    home: np.ndarray = component("Joint angles at the start [rad]")

    ungraphed: ClassVar[str] = (
        "machine must be an arm in a plane, or another kind, for a bond graph; got an arm in space"
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_leg(self.leg)

    def mechanics(self, stick_speed: float) -> LeggedMechanics:
        """Contacts and inertia."""
        return self.on_cylinder(self.load, self.load.links, stick_speed)


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotDrive(Jointed):
    """An arm in space from a file, each of its turning joints moved by a leg on one common cylinder, or by a drive of its own.

    Masses are those of the file; joints that are not named stay at 0. The end point is the origin of the tool.
    """

    WORD: ClassVar[str] = "robot"
    shown: ClassVar[str] = (
        ", drawn from the places and axes in its file: torques of the joints on the load, force and velocity of the tool."
    )
    FILES: ClassVar[tuple[str, ...]] = ("model",)
    """Fields that name a file beside the study."""
    MASSES: ClassVar[tuple[str, ...]] = ()
    one_of: ClassVar[tuple[str, ...]] = ("leg", "separate")
    """Fields of which exactly one is given."""

    model: str = component("File of the robot, URDF or, with the ending .xml or .mjcf, MJCF, beside the study")
    home_angles: tuple[float, ...] = quantities(
        "rad", FINITE, "Angles of the joints at home, from the base; no singular pose"
    )
    pulley_radius: float | None = quantity(
        "m", Gt(0), "Radius of the pulley by which a leg or linear drive moves each joint", default=None
    )
    tool: str = component(
        "Link whose origin is the end point, or site of an MJCF file; by default the last link", default=""
    )
    joints: tuple[str, ...] | None = chosen_words(
        "Names of the joints that move; by default all between base and tool, else the others stay at 0",
        (),
        default=None,
    )
    axes: tuple[str, ...] | None = chosen_words(
        "Coordinates of the end point, as many as joints; by default x, y, z and, of six joints, rx, ry, rz",
        AXES,
        default=None,
    )
    leg: CoboticDrive | None = component("One leg with the motor of the common cylinder", default=None)
    separate: ConventionalDrive | None = component("Drive of each joint, with a motor of its own", default=None)
    payload_mass: float = quantity("kg", Ge(0), "Mass of what the tool carries", default=0.0)
    payload_centre: tuple[float, ...] | None = quantities(
        "m", FINITE, "Its centre of mass from the end point, along the axes of the tool", default=None
    )
    payload_inertia: float = quantity(
        "kg m^2", Ge(0), "Its moment of inertia about its centre of mass, the same about all axes", default=0.0
    )
    gravity: tuple[float, ...] = quantities(  # type: ignore[assignment]
        "m/s^2", FINITE, "Acceleration of free fall along x, y and z of the base", default=_FALL
    )
    chain: TurningChain = field(init=False, repr=False, compare=False, default=None)  # type: ignore[assignment]
    bodies: tuple[SpatialBody, ...] = field(init=False, repr=False, compare=False, default=())
    massless: tuple[str, ...] = field(init=False, repr=False, compare=False, default=())
    """Links of which the file states no mass."""
    legs: LeggedDrive | None = field(init=False, repr=False, compare=False, default=None)

    __repr__ = brief

    def __post_init__(self) -> None:
        """Validate the fields and read the file."""
        check(self)
        self._check_pulley()
        for name in ("payload_centre", "gravity"):
            row = getattr(self, name)
            if row is not None:
                require(len(row) == 3, name, f"{len(row)} values", "3: along x, y and z")
        check_payload(self)
        try:
            read = read_mjcf_arm if Path(self.model).suffix.lower() in SUFFIXES else read_urdf_arm
            found = read(self.model, self.tool, self.joints)
        except ParameterError:
            raise
        except InputError as problem:
            raise ParameterError(f"model = {Path(self.model).name!r}: {problem}") from None
        bodies = tuple(SpatialBody(*one) for one in found.bodies)
        for name, value in (("chain", found.chain), ("bodies", bodies), ("massless", found.massless)):
            object.__setattr__(self, name, value)
        self._check_axes()
        object.__setattr__(self, "legs", self._legs(self.links))

    def _check_axes(self) -> None:
        count, names = self.links, ", ".join(self.chain.names)
        if self.axes is None:
            if count not in (3, 6):
                raise ParameterError(
                    f"axes is missing: {count} joints move ({names}); name as many of {', '.join(AXES)}"
                )
            object.__setattr__(self, "axes", AXES[:count])
        axes = self.coordinates
        require(len(axes) == count, "axes", f"{len(axes)}", f"as many as joints that move, {count}: {names}")
        turning = [one for one in axes if one in ROTATIONS]
        require(len(turning) in (0, 3), "axes", ", ".join(turning), "with all of rx, ry and rz, or none")
        object.__setattr__(self, "axes", tuple(one for one in AXES if one in axes))
        angles = np.array(self.home_angles)
        require(len(angles) == count, "home_angles", f"{len(angles)} values", f"{count}, one for each of {names}")
        for name, angle, ends in zip(self.chain.names, angles, self.chain.ranges, strict=True):
            if ends is not None and not ends[0] <= angle <= ends[1]:
                raise ParameterError(
                    f"home_angles must be {ends[0]:g} to {ends[1]:g} rad for joint {name!r}, got {angle:g} rad"
                )
        _, values, rates = np.linalg.svd(self._jacobian(angles))
        idle = [repr(name) for name, rate in zip(self.chain.names, np.abs(rates[-1]), strict=True) if rate > 0.01]
        require(
            values[-1] > 1e-4 * values[0],
            "home_angles",
            f"a singular one, by the places and axes in the model: turning {joined(idle)} moves it along none of them",
            "a pose in which the end point moves along all axes",
        )

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Of the end point."""
        return self.axes or ()

    @property
    def links(self) -> int:
        """Number of joints."""
        return len(self.bodies)

    @property
    def home(self) -> tuple[float, ...]:
        """The end point at the home angles."""
        return tuple(self.chain.pose(np.array(self.home_angles))[self._rows].tolist())

    @property
    def _rows(self) -> list[int]:
        return [AXES.index(one) for one in self.coordinates]

    @property
    def _required(self) -> str:
        """What no motion in time can be computed without, if neither the file nor the payload states it; else empty.

        Tasks, maps and paths do without: there forces follow from motion, and what has no mass adds none.
        """
        last, about = self._members().bodies[-1], self.chain.axes[-1]
        lever = np.cross(about, last.centre)
        turned = about @ last.inertia @ about + last.mass * (lever @ lever)
        return "" if turned > 0.0 else f"moment of inertia about joint {self.chain.names[-1]}"

    @property
    def lacking(self) -> Mapping[str, str]:
        """As of all arms; links without a mass count as massless."""
        links = {f"masses of links {', '.join(self.massless)}": "the model states none"} if self.massless else {}
        return {**Jointed.lacking.__get__(self), **links}

    def angles(self, pose: Array) -> np.ndarray:
        """See `Jointed`; of all solutions, the one that a straight line from home leads to."""
        return self._solved(np.asarray(pose, dtype=float))[0]

    def _solved(self, pose: np.ndarray) -> tuple[np.ndarray, dict[Limit, np.ndarray]]:
        row = np.reshape(pose, (-1, self.links))
        alone, back = np.unique(row, axis=0, return_inverse=True)
        found, singular = self.chain.angles(np.array(self.home_angles), alone, self._rows)
        angles, singular = (one[back.ravel()].reshape((*pose.shape[:-1], *one.shape[1:])) for one in (found, singular))
        utilisation = {Limit.LINKAGE: singular}
        limits = travel(self.chain, angles)
        if limits:
            utilisation[Limit.TRAVEL] = np.nan_to_num(np.max(np.stack(limits), axis=0), nan=np.inf)
        return angles, utilisation

    def picture(self, point: TaskPoint, pose: np.ndarray, twist: np.ndarray, wrench: np.ndarray) -> Picture:
        """Its members in space, with axes and torques of its joints."""
        return robots.picture(self, point, pose, twist, wrench)

    def _jacobian(self, angles: np.ndarray) -> np.ndarray:
        row = np.reshape(angles, (-1, self.links))
        found = self.chain.jacobian(self.chain.standing(row))[:, self._rows]
        return found.reshape(*angles.shape[:-1], self.links, self.links)

    def _members(self) -> RobotLoad:
        """Masses of the arm; the payload is a part of the last member."""
        bodies = list(self.bodies)
        if self.payload_mass:
            held = self.chain.tool_place + self.chain.tool_turn @ np.array(self.payload_centre or (0.0, 0.0, 0.0))
            bodies[-1] = joined_in_space(
                bodies[-1], SpatialBody(self.payload_mass, held, self.payload_inertia * np.eye(3))
            )
        return RobotLoad(
            chain=self.chain,
            bodies=tuple(bodies),
            pulleys=np.full(self.links, self.link_lever),
            gravity=np.array(self.gravity),
        )

    def moving(self, load_mass: float = 0.0, load_inertia: float = 0.0) -> RobotMachine | SeparateMachine:
        """The arm with its masses, and a load at its end point, for `infinivar.simulate_machine`.

        Parameters
        ----------
        load_mass, load_inertia : float   Moved with the tool; the weight is a part of the wrench. [kg], [kg m^2]

        Raises
        ------
        ParameterError
            If a mass that motion requires is missing, or a separate drive cannot be simulated.
        """
        if self._required and not (load_mass or load_inertia):
            raise ParameterError(
                f"model must state masses beyond each joint to move in time: there is no {self._required}; or state a payload"
            )
        load, home = (
            replace(self._members(), load_mass=load_mass, load_inertia=load_inertia),
            np.array(self.home_angles),
        )
        if self.leg is None:
            assert self.separate is not None
            rim = 1.0 if axis_of(self.separate).rotary else self.link_lever
            return SeparateMachine(
                separate=self.separate, load=replace(load, pulleys=np.full(self.links, rim)), home=home
            )
        needed(self.leg.steering, "leg.steering")
        return RobotMachine(leg=self.leg, load=load, home=home)
