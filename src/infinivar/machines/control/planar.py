r"""Guidance of planar cobots: along a path, as a virtual caster, and along a wall, by the direction in which the handle moves.

Each law gives the rate :math:`W = d\psi/dt` of the direction of motion of the handle. The wheels then head across the lines to
the instant centre, less their slip angles under the force that they carry; a body on two wheels or more keeps its orientation.
They let the handle move along psi only, at the speed u that the user gives it, so that whatever turns psi does no work.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol

import numpy as np
from annotated_types import Ge, Gt, Interval

from infinivar._core.fields import check, component, given, quantity
from infinivar.errors import ParameterError
from infinivar.machines.control.controller import Law, Measured, Plant
from infinivar.machines.control.loops import Commands
from infinivar.machines.hand import BodyGrip
from infinivar.transmission.guiding import largest_turn_rate
from infinivar.transmission.planar import PlanarCobot, drift

_NEVER_SLIPS = 0.95
"""Most of the slip force for which a slip angle is fed forward."""

_RETURN = 5.0
"""With which a body on several wheels returns to its orientation as it moves. [m^-1]"""

_WITHIN = 0.6
"""Share of the fastest turn from which a wheel begins to turn off a wall ahead."""

_AHEAD = 1.5
"""Samples from a measurement to the middle of the time in which what follows from it acts."""


class OnCurve(Protocol):
    """What guidance needs of the closest point of a curve."""

    @property
    def arc_length(self) -> Any:
        """[m]"""
        ...

    @property
    def tangent(self) -> np.ndarray:
        """Unit vector. (2,)"""
        ...

    @property
    def curvature(self) -> Any:
        """Positive to the left. [m^-1]"""
        ...

    @property
    def offset(self) -> Any:
        """Of the point to the left of the curve. [m]"""
        ...


class Curve(Protocol):
    """A virtual path in the plane."""

    def nearest(self, point: Any, near: Any = None) -> OnCurve:
        """The closest point of the curve, on the branch near an arc length."""
        ...


class Surface(Protocol):
    """A virtual wall; points are (d,) or (m, d)."""

    def distance(self, point: Any) -> Any:
        """Signed distance, > 0 on the free side. [m]"""
        ...

    def normal(self, point: Any) -> np.ndarray:
        """Unit vector towards the free side."""
        ...

    def hessian(self, point: Any) -> np.ndarray:
        """Second derivatives of the distance. [m^-1]"""
        ...


class Going(NamedTuple):
    """How the handle moves when a command acts."""

    position: np.ndarray
    """(2,) [m]"""
    direction: float
    """psi, in which it may move. [rad]"""
    speed: float
    """u along psi; negative backwards. [m s^-1]"""
    force: np.ndarray
    """Of the user. (2,) [N]"""

    @property
    def left(self) -> np.ndarray:
        """Unit vector to the left of psi."""
        return np.array([-math.sin(self.direction), math.cos(self.direction)])


Turning = Callable[[Going], float]
"""W of a direction of motion. [rad s^-1]"""

Attitude = Callable[[Going], tuple[float, float]]
"""Turn of the body by metre of the handle along psi [rad m^-1], and its orientation less that at the start [rad]."""


def _kept(going: Going) -> tuple[float, float]:
    """A body that does not turn."""
    return 0.0, 0.0


def cobot_of(plant: Plant, doing: str) -> PlanarCobot:
    """The body on wheels that a machine is; `doing` says what requires one.

    Raises
    ------
    ParameterError
        If it is none.
    """
    cobot = getattr(plant.machine, "cobot", None)
    if cobot is None:
        raise ParameterError(f"{doing} a PlanarMachine, got a {type(plant.machine).__name__}")
    return cobot


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Guided:
    """What all laws of planar cobots share."""

    direction: float | None = quantity(
        "rad",
        Interval(ge=-2.0 * math.pi, le=2.0 * math.pi),
        "Direction of motion at the start; by default that of the speed, or of the law",
        default=None,
    )
    slip_feedforward: bool = component("Whether slip angles of the wheels are fed forward", default=True)
    largest_rate: float = quantity("rad/s", Gt(0), "Fastest turn of the direction of motion", default=20.0)
    rest_speed: float = quantity("m/s", Gt(0), "Speed below which the handle counts as at rest", default=1e-3)

    def _law(
        self, plant: Plant, turning: Turning, usual: Callable[[Measured], float], attitude: Attitude = _kept
    ) -> Law:
        cobot = cobot_of(plant, f"{type(self).__name__} guides")
        assert isinstance(plant.grip, BodyGrip)
        return _Steering(self, cobot, plant.grip, plant.period, turning, usual, attitude).commands


@dataclass(slots=True)
class _Steering:
    """Directions of motion in a session, and the wheels that permit them."""

    settings: _Guided
    cobot: PlanarCobot
    grip: BodyGrip
    period: float
    turning: Turning
    usual: Callable[[Measured], float]
    attitude: Attitude
    direction: float = math.nan
    orientation: float = 0.0
    mass: float = field(init=False)
    inertia: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        self.mass = float(self.cobot.mass)  # type: ignore[arg-type]
        self.inertia = np.diag([self.mass, self.mass, float(self.cobot.inertia)])  # type: ignore[arg-type]

    def commands(self, measured: Measured) -> Commands:
        """Angles and rates of the wheels."""
        period = self.period
        begins = math.isnan(self.direction)
        if begins:
            self.direction, self.orientation = self._first(measured), float(measured.configuration[2])
        # The first command acts at once, and for two samples. All laws look at the middle of the time in which they act.
        lead, half = (period, period) if begins else (_AHEAD * period, 0.5 * period)
        going = self._going(measured, self.direction, lead)
        rate = self._limited(going)
        going = self._going(measured, self.direction + half * rate, lead)
        rate = self._limited(going)
        spin = self._turning_of_body(measured, going)
        slips = self._slip_angles(measured, going, rate, spin)
        first = self._headings(self.direction, spin, measured, 0.0 if begins else period)
        then = self._headings(self.direction + period * rate, spin, measured, period if begins else 2.0 * period)
        first = _nearest(first + slips, measured.steering)
        steering_rate = (_nearest(then + slips, first) - first) / period
        self.direction += (2.0 if begins else 1.0) * period * rate
        return Commands(steering=first, steering_rate=steering_rate)

    def _going(self, measured: Measured, direction: float, lead: float) -> Going:
        """How the handle moves some time after a measurement."""
        cosine, sine = math.cos(direction), math.sin(direction)
        force, velocity = measured.force, measured.velocity
        pushed = float(force[0]) * cosine + float(force[1]) * sine
        speed = float(velocity[0]) * cosine + float(velocity[1]) * sine
        return Going(measured.position + lead * velocity, direction, speed + lead * pushed / self.mass, force)

    def _limited(self, going: Going) -> float:
        most = self.settings.largest_rate
        return min(max(self.turning(going), -most), most)

    def _first(self, measured: Measured) -> float:
        if self.settings.direction is not None:
            return self.settings.direction
        if np.hypot(*measured.velocity) > self.settings.rest_speed:
            return math.atan2(measured.velocity[1], measured.velocity[0])
        return self.usual(measured)

    def _turning_of_body(self, measured: Measured, going: Going) -> float:
        """omega of the body over the speed of the handle. [rad m^-1]"""
        if self.cobot.mechanism.wheels == 1:
            return 0.0
        spin, turned = self.attitude(going)
        off = float(measured.configuration[2]) - self.orientation - turned
        return spin - math.copysign(_RETURN * off, going.speed * off)

    def _twist(self, direction: float, spin: float, angle: float) -> np.ndarray:
        """Twist of the body, in its axes, for a unit speed of the handle along a direction."""
        along = direction - angle
        x, y = self.grip.point
        return np.array([math.cos(along) + spin * y, math.sin(along) - spin * x, spin])

    def _headings(self, direction: float, spin: float, measured: Measured, after: float) -> np.ndarray:
        """Directions of the wheels' carriers in the body, some time after the measurement. (k,)"""
        angle = float(measured.configuration[2]) + after * float(measured.rates[2])
        moves = self.cobot.mechanism.jacobian @ self._twist(direction, spin, angle)
        return np.arctan2(moves[:, 1], moves[:, 0])

    def _slip_angles(self, measured: Measured, going: Going, rate: float, spin: float) -> np.ndarray:
        """What the wheels' headings have beyond the directions of their carriers. (k,)"""
        cobot = self.cobot
        count = cobot.mechanism.wheels
        found = np.zeros(count)
        if not self.settings.slip_feedforward:
            return found
        angle = float(measured.configuration[2])
        if count == 1:
            load = float(going.force @ going.left) - self.mass * going.speed * rate
            carried, ways = np.array([load]), np.array([going.speed])
        else:
            carried, ways = self._carried(going, rate, spin, angle)
        for contact, wheels in cobot.mechanism.kinds:
            places, most = list(wheels), _NEVER_SLIPS * contact.slip_force
            found[places] = drift(contact, np.clip(carried[places], -most, most))
        return -np.copysign(1.0, ways) * found

    def _carried(self, going: Going, rate: float, spin: float, angle: float) -> tuple[np.ndarray, np.ndarray]:
        """Load of the body on each wheel across its heading, the least that balances the motion, and how fast it rolls. (k,)"""
        inertia = self.inertia
        unit = self._twist(going.direction, spin, angle)
        turned = self._twist(going.direction + 0.5 * math.pi, 0.0, angle)
        changing = going.speed * (rate - going.speed * spin) * turned
        twist = going.speed * unit
        bias = self.mass * twist[2] * np.array([-twist[1], twist[0], 0.0])
        cosine, sine = math.cos(angle), math.sin(angle)
        x, y = cosine * going.force[0] + sine * going.force[1], cosine * going.force[1] - sine * going.force[0]
        push = np.array([x, y, self.grip.point[0] * y - self.grip.point[1] * x])
        gained = float(unit @ (push - bias - inertia @ changing)) / float(unit @ inertia @ unit)
        needed = inertia @ (gained * unit + changing) + bias - push
        rows = self.cobot.mechanism.jacobian
        moves = rows @ unit
        size = np.maximum(np.hypot(moves[:, 0], moves[:, 1]), 1e-9)
        across = (moves[:, :1] * rows[:, 1] - moves[:, 1:] * rows[:, 0]) / size[:, None]
        shares = np.linalg.lstsq(across.T, needed, rcond=1e-9)[0]
        return -shares, going.speed * size


def _nearest(angles: np.ndarray, to: np.ndarray) -> np.ndarray:
    """The same lines of wheels, as angles within a quarter turn of others."""
    return to + np.remainder(angles - to + 0.5 * math.pi, math.pi) - 0.5 * math.pi


def _along(vector: np.ndarray) -> float:
    return math.atan2(float(vector[1]), float(vector[0]))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PathGuide(_Guided):
    """Guides the handle along a path in the plane; the user gives the speed, forwards or backwards. Past the ends of an open
    path, the handle is guided along its tangent there.

    Raises
    ------
    ParameterError
        If a field is out of range.
    """

    curve: Curve = component("The path: with nearest(point, near)")
    k1: float = quantity(
        "1/m^2", Gt(0), "Gain of the offset: the inverse square of a length in which it decays", default=400.0
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        if not hasattr(self.curve, "nearest"):
            raise ParameterError(f"curve must have nearest(point, near), got {self.curve!r}")

    def begin(self, plant: Plant, attitude: Attitude = _kept) -> Law:
        """The law of one session, of a body that keeps its orientation unless stated otherwise."""
        near: list[Any] = [None]

        def turning(going: Going) -> float:
            if abs(going.speed) < self.rest_speed:
                return 0.0
            there = self.curve.nearest(going.position, near[0])
            near[0] = float(there.arc_length)
            way = math.copysign(1.0, going.speed)
            off = math.remainder(going.direction - _along(there.tangent), 2.0 * math.pi)
            # Along the line, whichever end leads.
            back = -1.0 if abs(off) > 0.5 * math.pi else 1.0
            off = math.remainder(off, math.pi)
            sense = way * back
            # Wheels cannot stop the handle: past an end of an open path it goes straight on.
            bend = 0.0 if getattr(there, "beyond", 0.0) else float(there.curvature)
            by_metre = path_turning(sense * bend, sense * float(there.offset), off, self.k1)
            return abs(going.speed) * by_metre

        def usual(measured: Measured) -> float:
            return _along(self.curve.nearest(measured.position, None).tangent)

        return self._law(plant, turning, usual, attitude)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CasterGuide(_Guided):
    """Free mode: the handle turns as a free mass would. Its mass along the motion is that of the machine.

    The law is singular at rest. Below `rest_speed` the direction of motion turns to the line of the force instead, the shorter
    way, as fast as `largest_rate`: that is how a free mass sets off. A force below `least_force` does not turn it.

    Raises
    ------
    ParameterError
        If a field is out of range.
    """

    mass: float | None = quantity(
        "kg", Gt(0), "Virtual mass M across the motion; by default the machine's own", default=None
    )
    least_force: float = quantity("N", Ge(0), "Force at rest below which the wheels stay", default=0.1)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)

    def begin(self, plant: Plant) -> Law:
        """The law of one session."""
        return self._law(plant, self.turning(plant), _towards_force)

    def turning(self, plant: Plant) -> Turning:
        """W of the direction of motion."""
        mass = given(self.mass, getattr(getattr(plant.machine, "cobot", None), "mass", None))

        def turning(going: Going) -> float:
            if abs(going.speed) < self.rest_speed:
                return at_rest(going, self.least_force, plant.period)
            return caster_rate(float(going.force @ going.left), mass, going.speed)

        return turning


def at_rest(going: Going, least_force: float, period: float) -> float:
    """W of a handle at rest: to the line of the user's force within a sample, the shorter way."""
    if float(np.hypot(*going.force)) <= least_force:
        return 0.0
    return math.remainder(_along(going.force) - going.direction, math.pi) / period


def _towards_force(measured: Measured) -> float:
    return _along(measured.force) if np.any(measured.force) else 0.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class WallGuide(_Guided):
    """A wall by steering: free on one side, and along the wall where the user pushes into it.

    Ahead of the wall the direction of motion turns on an arc that ends along it, no faster than the contacts allow
    (`infinivar.transmission.guiding.largest_turn_rate`): a handle that is too fast, or pushed too hard, goes through.

    Raises
    ------
    ParameterError
        If a field is out of range.
    """

    wall: Surface = component("The wall: with distance(point), normal(point) and hessian(point), in the plane")
    mass: float | None = quantity(
        "kg", Gt(0), "Virtual mass M in free motion; by default the machine's own", default=None
    )
    k1: float = quantity("1/m^2", Gt(0), "Gain of the distance along the wall", default=2500.0)
    margin: float = quantity("m", Ge(0), "Distance at which the wall begins to lead", default=5e-4)
    share: float = quantity("1", Interval(gt=0, le=1), "Share of the slip force that turning may use", default=0.9)
    least_force: float = quantity("N", Ge(0), "Force at rest below which the wheels stay", default=0.1)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        for name in ("distance", "normal", "hessian"):
            if not hasattr(self.wall, name):
                raise ParameterError(
                    f"wall must have distance, normal and hessian, but a {type(self.wall).__name__} has no {name}"
                )

    def begin(self, plant: Plant) -> Law:
        """The law of one session."""
        free = CasterGuide(mass=self.mass, rest_speed=self.rest_speed, least_force=self.least_force).turning(plant)
        cobot = getattr(plant.machine, "cobot", None)
        body, held = getattr(cobot, "mass", 1.0), sum(one.slip_force for one in getattr(cobot, "contacts", ()))

        def turning(going: Going) -> float:
            distance = float(self.wall.distance(going.position))
            normal = np.asarray(self.wall.normal(going.position))
            way = math.copysign(1.0, going.speed)
            moves = way * np.array([math.cos(going.direction), math.sin(going.direction)])
            away = float(normal @ moves)  # sine of the angle from the wall to the motion
            pushed = -float(normal @ going.force)
            freely = free(going)
            if abs(going.speed) < self.rest_speed:
                if distance > self.margin or pushed <= 0.0:
                    return freely
                # At the wall, a push into it starts no motion but along it.
                line = math.atan2(-normal[0], normal[1])
                return math.remainder(line - going.direction, math.pi) / plant.period
            # Turning with this sign leads away from the wall.
            sense = way * (1.0 if float(normal @ going.left) >= 0.0 else -1.0)
            speed = abs(going.speed)
            fastest = float(largest_turn_rate(self.share * held, max(pushed, 0.0), body, speed))
            fastest = min(fastest, self.largest_rate)
            least = -math.inf
            if distance <= self.margin:
                angle = math.asin(min(max(away, -1.0), 1.0))
                along = moves - away * normal
                bend = -float(along @ np.asarray(self.wall.hessian(going.position)) @ along)
                # Seen with the wall to the right: the free side is to the left.
                least = speed * path_turning(bend, distance, angle, self.k1)
            elif away < 0.0:
                arc = speed * (1.0 - math.sqrt(max(1.0 - away * away, 0.0))) / (distance - 0.5 * self.margin)
                least = arc if arc >= _WITHIN * fastest else -math.inf
            demanded = max(sense * freely, min(least, fastest))
            return sense * demanded

        return self._law(plant, turning, _towards_force)


def path_turning(curvature: float, offset: float, angle: float, k1: float) -> float:
    r"""Turning per metre that leads a point back to a path.

    .. math:: \frac{d\psi}{ds} = \frac{\kappa \cos e}{1 - \kappa d} - k_1 d - 2\sqrt{k_1} e

    Near the path ``d'' + 2 sqrt(k1) d' + k1 d = 0`` by travelled length, which is critically damped.

    Parameters
    ----------
    curvature : float   kappa of the path at the closest point, positive to the left. [m^-1]
    offset : float      d, of the point to the left of the path; below the radius of curvature. [m]
    angle : float       e, from the path's tangent to the direction of motion. [rad]
    k1 : float          [m^-2]

    Returns
    -------
    float   [rad m^-1]

    Source: kinematics of a point beside a curve.
    """
    beside = max(1.0 - curvature * offset, 0.1)  # beyond the centre of curvature there is no way around
    return curvature * math.cos(angle) / beside - k1 * offset - 2.0 * math.sqrt(k1) * angle


def caster_rate(force: float, mass: float, speed: float) -> float:
    r"""Rate at which a free mass turns under a force across its motion, :math:`F_n/(M u)`. [rad s^-1]

    With the mass of the machine itself it moves as a free mass; the force along the motion always acts on the machine's mass.

    Parameters
    ----------
    force : float   F_n, to the left of the direction of motion. [N]
    mass : float    M, virtual. [kg]
    speed : float   u along the direction of motion, not 0; negative backwards. [m s^-1]

    Source: Newton.
    """
    return force / (mass * speed)
