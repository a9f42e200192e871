r"""Guidance of planar cobots: along a path, as a virtual caster, and along a wall, by the direction in which the handle moves.

Each law gives the rate :math:`W = d\psi/dt` of the direction of motion of the handle. The wheels then head across the lines to
the instant centre, less their slip angles under the force that they carry; a body on two wheels or more keeps its orientation.
They let the handle move along psi only, at the speed u that the user gives it, so that whatever turns psi does no work.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from annotated_types import Ge, Gt, Interval

from infinivar._core.fields import check, component, given, quantity
from infinivar.bondgraph.recorded import vector
from infinivar.bondgraph.scalars import (
    angle_of,
    arc_sine,
    choose,
    cosine,
    length_of,
    root,
    signed,
    sine,
    within,
    wrapped,
)
from infinivar.bondgraph.tape import Number
from infinivar.errors import ParameterError
from infinivar.machines.control.controller import Law, Measured, Plant, Unremembering
from infinivar.machines.control.planar_steering import Attitude, Going, Steering, Turning
from infinivar.machines.hand import BodyGrip
from infinivar.transmission.guiding import largest_turn_rate
from infinivar.transmission.planar import PlanarCobot

_WITHIN = 0.6
"""Share of the fastest turn from which a wheel begins to turn off a wall ahead."""

_FAR = 1e9
"""A turn that no law demands. [rad s^-1]"""


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


_kept: Attitude = Unremembering(lambda going: (0.0, 0.0))
"""A body that does not turn."""


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
        return Steering(self, cobot, plant.grip, plant.period, turning, usual, attitude)


def _along(way: np.ndarray) -> Number:
    return angle_of(way[1], way[0])


@dataclass(slots=True)
class _OnPath:
    """The law of a path in a session."""

    settings: PathGuide
    near: Number | None = None
    """Arc length of the closest point."""

    @property
    def memory(self) -> list[np.ndarray] | None:
        """The arc length; None before the first sample."""
        return None if self.near is None else [np.array([self.near])]

    @memory.setter
    def memory(self, kept: Sequence[np.ndarray]) -> None:
        ((self.near,),) = kept

    def __call__(self, going: Going) -> Number:
        """W of the direction of motion."""
        settings = self.settings
        if self.near is None:
            self.near = settings.curve.nearest(going.position, None).arc_length

        def moves() -> tuple[Number, Number]:
            there = settings.curve.nearest(going.position, self.near)
            off = wrapped(going.direction - _along(there.tangent), 2.0 * math.pi)
            # Along the line, whichever end leads.
            back = choose(abs(off) > 0.5 * math.pi, lambda: -1.0, lambda: 1.0)
            sense = signed(1.0, going.speed) * back
            # Wheels cannot stop the handle: past an end of an open path it goes straight on.
            past = getattr(there, "beyond", 0.0) != 0.0
            bend = choose(past, lambda: 0.0, lambda: there.curvature)
            by_metre = path_turning(sense * bend, sense * there.offset, wrapped(off, math.pi), settings.k1)
            return abs(going.speed) * by_metre, there.arc_length

        rests = abs(going.speed) < settings.rest_speed
        turning, self.near = choose(rests, lambda: (0.0, self.near), moves)
        return turning


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

        def usual(measured: Measured) -> float:
            return _along(self.curve.nearest(measured.position, None).tangent)

        return self._law(plant, _OnPath(self), usual, attitude)


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

        def turning(going: Going) -> Number:
            return choose(
                abs(going.speed) < self.rest_speed,
                lambda: at_rest(going, self.least_force, plant.period),
                lambda: caster_rate(going.force @ going.left, mass, going.speed),
            )

        return Unremembering(turning)


def at_rest(going: Going, least_force: float, period: float) -> Number:
    """W of a handle at rest: to the line of the user's force within a sample, the shorter way."""
    return choose(
        length_of(*going.force.tolist()) <= least_force,
        lambda: 0.0,
        lambda: wrapped(_along(going.force) - going.direction, math.pi) / period,
    )


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

        def turning(going: Going) -> Number:
            distance, normal = self.wall.distance(going.position), self.wall.normal(going.position)
            way, speed = signed(1.0, going.speed), abs(going.speed)
            moves = way * vector(cosine(going.direction), sine(going.direction))
            away = normal @ moves  # sine of the angle from the wall to the motion
            pushed = -(normal @ going.force)
            freely = free(going)

            def stands() -> Number:
                # At the wall, a push into it starts no motion but along it.
                line = angle_of(-normal[0], normal[1])
                along = wrapped(line - going.direction, math.pi) / plant.period
                return choose((distance > self.margin) | (pushed <= 0.0), lambda: freely, lambda: along)

            def leads() -> Number:
                angle = arc_sine(within(away, 1.0))
                along = moves - away * normal
                bend = -(along @ np.asanyarray(self.wall.hessian(going.position)) @ along)
                # Seen with the wall to the right: the free side is to the left.
                return speed * path_turning(bend, distance, angle, self.k1)

            def ahead() -> Number:
                short = 1.0 - away * away
                rest = root(choose(short > 0.0, lambda: short, lambda: 0.0))
                arc = speed * (1.0 - rest) / (distance - 0.5 * self.margin)
                return choose((away < 0.0) & (arc >= _WITHIN * fastest), lambda: arc, lambda: -_FAR)

            # Turning with this sign leads away from the wall.
            sense = way * choose(normal @ going.left >= 0.0, lambda: 1.0, lambda: -1.0)
            into = choose(pushed > 0.0, lambda: pushed, lambda: 0.0)

            def moving() -> Number:
                least = choose(distance <= self.margin, leads, ahead)
                least = choose(least < fastest, lambda: least, lambda: fastest)
                wanted = sense * freely
                return sense * choose(wanted > least, lambda: wanted, lambda: least)

            rests = speed < self.rest_speed
            turns = choose(rests, lambda: self.rest_speed, lambda: speed)
            most = largest_turn_rate(self.share * held, vector(into), body, vector(turns))[0]
            fastest = choose(most < self.largest_rate, lambda: most, lambda: self.largest_rate)
            return choose(rests, stands, moving)

        return self._law(plant, Unremembering(turning), _towards_force)


def path_turning(curvature: Number, offset: Number, angle: Number, k1: float) -> Number:
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
    around = 1.0 - curvature * offset
    beside = choose(around > 0.1, lambda: around, lambda: 0.1)  # beyond the centre of curvature there is no way around
    return curvature * cosine(angle) / beside - k1 * offset - 2.0 * math.sqrt(k1) * angle


def caster_rate(force: Number, mass: float, speed: Number) -> Number:
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
