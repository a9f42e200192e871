r"""What a machine must do: tasks, each a wrench at a twist in a pose, and paths, on which its end point moves over time.

Wrenches are those that the machine exerts on its load, so that ``wrench . twist`` is the power to the load, as force times speed
is for a drive of one axis.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from annotated_types import Ge, Gt, Interval

from infinivar._core.arrays import Whole
from infinivar._core.fields import check, check_kind, check_real, component, given, quantity, several, tagged
from infinivar.errors import InputError, ParameterError
from infinivar.motion.motion import PeriodicMotion
from infinivar.motion.motions import Hold, Reaches, Sinusoid, Tremor
from infinivar.motion.recordings import Recording
from infinivar.motion.through import Most, MoveProfile, Through, through
from infinivar.motion.vectors import COORDINATES, ROTATIONS, TRANSLATIONS, Pose, Twist, Vector, Wrench

MOTIONS: dict[str, type] = {kind.shape: kind for kind in (Hold, Sinusoid, Reaches, Tremor, Recording)}
"""Kinds of motion along or about one coordinate of a path, by their name in `shape`."""

SAMPLES = 400
"""Fewest instants of a path."""

_PER_WAVE = 40
_MOST = 20_000
_SAME = 1e-9
"""Relative difference of periods that counts as rounding."""

_OF_WAYPOINTS = ("speed", "acceleration", "turning_speed", "turning_acceleration", "pause", "profile", "back")

_SHARE = "Share of the time spent in it; those of all tasks and paths add up to 100 %"


@dataclass(frozen=True, slots=True, kw_only=True)
class MachineTask(Whole):
    """A steady motion of a machine's end point at one pose, with the wrenches that the machine must exert there.

    The losses are those of `wrench`; the limits must hold for every wrench of the polytope that `box` or `wrenches` adds.

    Raises
    ------
    ParameterError
        If a field is outside its range, or both a box and other wrenches are given.
    """

    title: str = component("Name for reports", default="")
    pose: Pose = component("Pose of the end point; that of the machine at home where not stated", default_factory=Pose)
    twist: Twist = component("Velocity of the end point; at rest where not stated", default_factory=Twist)
    wrench: Wrench = component("Wrench that the machine exerts on its load", default_factory=Wrench)
    box: Wrench | None = component(
        "Half-widths of a box of wrenches about `wrench`, within which all limits must hold", default=None
    )
    wrenches: tuple[Wrench, ...] | None = several(
        "Corners of a polytope of wrenches, with `wrench`, within which all limits must hold", Wrench, default=None
    )
    time_share: float | None = quantity("1", Interval(gt=0, le=1), _SHARE, default=None)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_real(self)
        if self.box is not None and self.wrenches is not None:
            raise ParameterError(
                "box and wrenches exclude each other: state the corners of the polytope by one of them"
            )
        for name, value in ({} if self.box is None else self.box.stated).items():
            if value < 0.0:
                unit = "N" if name in TRANSLATIONS else "N m"
                raise ParameterError(f"box.{name} must be >= 0 {unit}, as it is a half-width, got {value:g} {unit}")

    @property
    def vectors(self) -> Mapping[str, Vector]:
        """What is stated by coordinate, under its key."""
        rows = {"pose": self.pose, "twist": self.twist, "wrench": self.wrench}
        if self.box is not None:
            rows["box"] = self.box
        return rows | {f"wrenches {place}": one for place, one in enumerate(self.wrenches or (), 1)}

    def corners(self, coordinates: Sequence[str]) -> np.ndarray:
        """Corners of the polytope of wrenches, the task's own wrench first: (m, d)."""
        own = self.wrench.row(coordinates)
        if self.wrenches is not None:
            return np.array([own, *(one.row(coordinates) for one in self.wrenches)])
        half = np.zeros_like(own) if self.box is None else self.box.row(coordinates)
        wide = np.flatnonzero(half)
        found = [own]
        for signs in itertools.product((-1.0, 1.0), repeat=len(wide)) if len(wide) else ():
            corner = own.copy()
            corner[wide] += np.array(signs) * half[wide]
            found.append(corner)
        return np.array(found)


class PathInstants(NamedTuple):
    """A path at the midpoints of equal steps of time: arrays (t, d) by coordinate, and (t,)."""

    time: np.ndarray
    pose: np.ndarray
    twist: np.ndarray
    acceleration: np.ndarray
    wrench: np.ndarray


@dataclass(frozen=True, slots=True, kw_only=True)
class MachinePath(Whole):
    """A motion of a machine's end point over time: one motion for each coordinate that moves, all of one period.

    A recorded force of a coordinate is that on the load, positive along the motion, as in a duty cycle; the machine exerts the
    opposite, and what accelerates the mass of the load.

    Raises
    ------
    ParameterError
        If a field is outside its range, or the motions differ in their period.
    InputError
        If no coordinate moves.
    """

    title: str = component("Name for reports", default="")
    pose: Pose = component("Pose about which the end point moves", default_factory=Pose)
    wrench: Wrench = component("Constant wrench that the machine exerts on its load", default_factory=Wrench)
    load_mass: float | None = quantity("kg", Ge(0), "Mass moved with the end point", default=None)
    load_inertia: float | None = quantity(
        "kg m^2", Ge(0), "Moment of inertia moved with the end point, the same about all axes", default=None
    )
    time_share: float | None = quantity("1", Interval(gt=0, le=1), _SHARE, default=None)
    x: PeriodicMotion | None = tagged("Motion along x, added to the pose", MOTIONS, default=None)
    y: PeriodicMotion | None = tagged("Motion along y, added to the pose", MOTIONS, default=None)
    z: PeriodicMotion | None = tagged("Motion along z, added to the pose", MOTIONS, default=None)
    rx: PeriodicMotion | None = tagged("Motion about x, added to the pose", MOTIONS, default=None)
    ry: PeriodicMotion | None = tagged("Motion about y, added to the pose", MOTIONS, default=None)
    rz: PeriodicMotion | None = tagged("Motion about z, added to the pose", MOTIONS, default=None)
    angle: PeriodicMotion | None = tagged("Motion of the angle, added to the pose", MOTIONS, default=None)
    waypoints: tuple[Pose, ...] | None = several(
        "Places visited in turn along straight lines, added to the pose, in place of motions by coordinate",
        Pose,
        default=None,
    )
    speed: float | None = quantity("m/s", Gt(0), "Largest speed between waypoints", default=None)
    acceleration: float | None = quantity("m/s^2", Gt(0), "Largest acceleration between waypoints", default=None)
    turning_speed: float | None = quantity("rad/s", Gt(0), "Largest rate of turning between waypoints", default=None)
    turning_acceleration: float | None = quantity(
        "rad/s^2", Gt(0), "Largest angular acceleration between waypoints", default=None
    )
    pause: float | None = quantity("s", Ge(0), "Pause at each waypoint; default: none", default=None)
    profile: MoveProfile | None = component(
        "Profile of the speed between waypoints; minimum-jerk by default", default=None
    )
    back: bool | None = component("Whether it returns to the first waypoint, the default, or is a run", default=None)
    _through: Mapping[str, Through] = dataclasses.field(init=False, repr=False, compare=False, default_factory=dict)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_real(self)
        check(self)
        self._check_waypoints()
        moving = self.motions
        if not moving:
            raise InputError(
                'no coordinate moves: state the motion of one, such as z = { shape = "sinusoid", distance = "10 mm", '
                'frequency = "1 Hz" }, or waypoints'
            )
        if self.waypoints is not None:
            return
        for name, motion in moving.items():
            check_kind(name, motion, MOTIONS, "derivatives")
            rotary = name not in TRANSLATIONS
            if not isinstance(motion, Hold) and motion.axis.rotary is not rotary:
                words = ("angle", "distance") if rotary else ("distance", "angle")
                raise ParameterError(
                    f"{name} must be a motion {'about an axis' if rotary else 'along a line'}: state {words[0]}, not {words[1]}"
                )
        first = next(iter(moving))
        for name, motion in moving.items():
            if abs(motion.period - moving[first].period) > _SAME * motion.period:
                raise ParameterError(
                    f"{name} must have the period of {first}, {moving[first].period:g} s, got {motion.period:g} s"
                )

    def _check_waypoints(self) -> None:
        """Make the motions through waypoints, or raise ParameterError for what does not go with them."""
        if self.waypoints is None:
            for name in _OF_WAYPOINTS:
                if getattr(self, name) is not None:
                    raise ParameterError(f"{name} does not apply without waypoints; remove it")
            return
        for name in COORDINATES:
            if getattr(self, name) is not None:
                raise ParameterError(f"{name} and waypoints exclude each other: state the whole motion by one of them")
        along = None if self.speed is None else Most(self.speed, self.acceleration)
        turning = None if self.turning_speed is None else Most(self.turning_speed, self.turning_acceleration)
        profile, back = given(self.profile, "minimum-jerk"), given(self.back, True)
        found = through(self.waypoints, profile, given(self.pause, 0.0), back, along, turning)
        object.__setattr__(self, "_through", found)

    @property
    def motions(self) -> Mapping[str, PeriodicMotion]:
        """Motions by coordinate."""
        if self.waypoints is not None:
            return self._through
        found = {name: getattr(self, name) for name in COORDINATES}
        return {name: motion for name, motion in found.items() if motion is not None}

    @property
    def vectors(self) -> Mapping[str, Vector]:
        """What is stated by coordinate, under its key."""
        return {"pose": self.pose, "wrench": self.wrench}

    @property
    def period(self) -> float:
        """Time of one cycle, or of the run. [s]"""
        return next(iter(self.motions.values())).period

    @property
    def closed(self) -> bool:
        """Whether all motions repeat; if not, the path is a run."""
        return all(motion.repeats for motion in self.motions.values())

    @property
    def per(self) -> str:
        """What energies refer to."""
        return "per cycle" if self.closed else "over the run"

    @property
    def warnings(self) -> tuple[str, ...]:
        """Valid input that looks like an oversight."""
        return tuple(
            f"{name}: {one}" for name, motion in self.motions.items() for one in getattr(motion, "warnings", ())
        )

    def beyond(self, coordinates: Sequence[str]) -> Iterator[str]:
        """Yield the coordinates that move and are none of these."""
        return (name for name in self.motions if name not in coordinates)

    def instants(self, coordinates: Sequence[str], home: Sequence[float]) -> PathInstants:
        """The path in the coordinates of a machine, about a pose that is `home` where not stated."""
        fastest = max(motion.fastest for motion in self.motions.values())
        count = 4 * -(-min(max(SAMPLES, int(_PER_WAVE * fastest * self.period)), _MOST) // 4)
        return self.at((np.arange(count) + 0.5) * (self.period / count), coordinates, home)

    def at(self, time: np.ndarray, coordinates: Sequence[str], home: Sequence[float]) -> PathInstants:
        """As `instants`, at given instants (t,). [s]

        Source: Newton's law for the mass, Euler's for a sphere; `angular_velocity` for rotations.
        """
        count = len(time)
        pose = np.tile(self.pose.row(coordinates, home), (count, 1))
        rate, second = np.zeros_like(pose), np.zeros_like(pose)
        wrench = np.tile(self.wrench.row(coordinates), (count, 1))
        for name, motion in self.motions.items():
            place = list(coordinates).index(name)
            position, speed, acceleration = motion.derivatives(time, 2)[:3]
            pose[:, place] += position
            rate[:, place], second[:, place] = speed, acceleration
            wrench[:, place] -= motion.push(time, 0)[0]
        twist, acceleration = rate.copy(), second.copy()
        turning = [place for place, name in enumerate(coordinates) if name in ROTATIONS]
        if len(turning) == 3:
            twist[:, turning] = angular_velocity(pose[:, turning], rate[:, turning])
            acceleration[:, turning] = _angular_acceleration(pose[:, turning], rate[:, turning], second[:, turning])
        masses = [given(self.load_mass if name in TRANSLATIONS else self.load_inertia, 0.0) for name in coordinates]
        return PathInstants(time, pose, twist, acceleration, wrench + np.array(masses) * acceleration)


def angular_velocity(rotation: np.ndarray, rate: np.ndarray) -> np.ndarray:
    r"""Angular velocity in fixed axes of a body whose rotation vector changes at a rate.

    .. math:: \omega = \dot\rho + \frac{1-\cos\theta}{\theta^2}\,\rho\times\dot\rho
        + \frac{\theta-\sin\theta}{\theta^3}\,\rho\times(\rho\times\dot\rho), \qquad \theta = |\rho|

    Parameters
    ----------
    rotation, rate : (..., 3) float   [rad], [rad s^-1]

    Returns
    -------
    (..., 3) float   [rad s^-1]

    Source: Rodrigues' formula, differentiated.
    """
    angle = np.sqrt(np.sum(rotation * rotation, axis=-1, keepdims=True))
    turns = angle > 1e-4
    safe = np.where(turns, angle, 1.0)
    one = np.where(turns, 2.0 * (np.sin(0.5 * safe) / safe) ** 2, 0.5 - angle**2 / 24.0)
    two = np.where(turns, (safe - np.sin(safe)) / safe**3, 1.0 / 6.0 - angle**2 / 120.0)
    across = np.cross(rotation, rate)
    return rate + one * across + two * np.cross(rotation, across)


_STEP = 1e-5
"""Half the time over which the angular velocity is differenced. [s]"""


def _angular_acceleration(rotation: np.ndarray, rate: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Rate of `angular_velocity`, by a central difference along the motion; error of the order of the step squared."""
    ahead, behind = (
        angular_velocity(rotation + sign * rate + 0.5 * sign**2 * second, rate + sign * second)
        for sign in (_STEP, -_STEP)
    )
    return (ahead - behind) / (2.0 * _STEP)


def named(tasks: Mapping[str, Any]) -> dict[str, Any]:
    """The tasks or paths, each with a title, its name by default."""
    return {name: one if one.title else dataclasses.replace(one, title=name) for name, one in tasks.items()}
