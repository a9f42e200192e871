r"""Fixtures and holding of planar cobots: what wheels leave free of a body, and how they lock it.

A body on two wheels or more moves about one instant centre at a time. With the constraints ``A xi = 0`` of a fixture on
its twist,

.. math:: \xi = (v, \omega), \qquad A\,\xi = 0,

two rows leave one motion: along a line if omega = 0, else about the point ``c = p + J v/omega``. One row on the turning alone
leaves a body that keeps its orientation.

Source: `infinivar.motion.virtual.fixtures` for the rows; kinematics of a body in the plane.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from annotated_types import Gt

from infinivar._core.fields import check, component, quantity
from infinivar.bondgraph.recorded import vector
from infinivar.bondgraph.scalars import angle_of, length_of, sine, wrapped
from infinivar.bondgraph.tape import Number
from infinivar.errors import InputError, ParameterError
from infinivar.machines.control.controller import Law, Measured, Plant, Unremembering
from infinivar.machines.control.loops import Commands
from infinivar.machines.control.planar import CasterGuide, PathGuide, Surface, cobot_of
from infinivar.machines.control.planar_steering import Going
from infinivar.motion.virtual.fixtures import Allowed
from infinivar.motion.virtual.surfaces import Ball, HalfSpace
from infinivar.transmission.planar import COORDINATES

_STILL = 1e-9
"""Turn of a body by metre below which it moves along a line [rad m^-1], and distance below which points are the same. [m]"""

_NEAR = 1e-3
"""Least distance of a handle from the point about which it turns: nearer, its motion does not tell the turn. [m]"""

_LOCKED = 0.05
"""Least singular value, over the largest, of wheels that hold a body."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Beside:
    """The line of a surface in the plane as a path, with the free side to the left."""

    surface: Surface = component("The surface")

    def nearest(self, point: Any, near: Any = None) -> BesidePoint:
        """The line through the point that keeps its distance, and how far it is from the surface."""
        normal = self.surface.normal(point)
        tangent = vector(normal[1], -normal[0])
        distance = self.surface.distance(point)
        bend = -(tangent @ self.surface.hessian(point) @ tangent)
        return BesidePoint(0.0, tangent, bend / (1.0 + bend * distance), distance)


@dataclass(frozen=True, slots=True)
class BesidePoint:
    """What `Beside.nearest` finds; as `infinivar.machines.control.planar.OnCurve`."""

    arc_length: float
    tangent: np.ndarray
    curvature: Number
    offset: Number


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlanarFixtureGuide:
    """Guides a planar cobot in a fixture: along a line, about a point, or without turning.

    Raises
    ------
    ParameterError
        If a field is out of range.
    """

    allowed: Allowed = component("What is allowed to move")
    settling_length: float = quantity("m", Gt(0), "Distance over which an offset decays", default=0.05)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        if not hasattr(self.allowed, "rows"):
            raise ParameterError(f"allowed must be a fixture, such as AlongLine or AboutPoint, got {self.allowed!r}")

    def begin(self, plant: Plant) -> Law:
        """The law of one session, about the pose at its start.

        Raises
        ------
        InputError
            At the first sample, if the cobot cannot be guided so.
        """
        wheels = cobot_of(plant, "PlanarFixtureGuide guides").mechanism.wheels
        return _Chosen(lambda measured: self._chosen(measured, plant, wheels))

    def _chosen(self, measured: Measured, plant: Plant, wheels: int) -> Law:
        rows = self.allowed.rows(COORDINATES, measured.position).rows
        if wheels == 1 and len(rows) == 1 and np.any(rows[0, :2]) and abs(rows[0, 2]) < _STILL:
            # The body turns freely about its wheel.
            return self._along(np.array([-rows[0, 1], rows[0, 0]]), measured).begin(plant)
        if wheels > 1 and len(rows) == 1 and not np.any(np.abs(rows[0, :2]) > _STILL * abs(rows[0, 2])):
            return CasterGuide().begin(plant)
        if wheels > 1 and len(rows) == 2:
            free = np.cross(rows[0], rows[1])
            x, y, turn = free / np.max(np.abs(free))
            pace = math.hypot(x, y)
            if abs(turn) <= _STILL * pace:
                return self._along(np.array([x, y]), measured).begin(plant)
            if pace >= _NEAR * abs(turn):
                centre = measured.position + np.array([-y, x]) / turn
                return self._about(centre, math.hypot(x, y) / abs(turn), plant)
            raise InputError(
                f"the handle must be {1e3 * _NEAR:g} mm or more from the point about which a fixture turns it"
            )
        raise InputError(
            "a planar cobot on several wheels is guided along a line without turning, about a point, or freely without turning,"
            " and one wheel along a line with turning; "
            f"the fixture leaves {3 - len(rows)} of x, y and angle free on {wheels} wheels"
        )

    def _path(self, surface: Any) -> PathGuide:
        return PathGuide(curve=Beside(surface=surface), k1=self.settling_length**-2)

    def _along(self, way: np.ndarray, measured: Measured) -> PathGuide:
        return self._path(HalfSpace(point=measured.position.tolist(), direction=[-float(way[1]), float(way[0])]))

    def _about(self, centre: np.ndarray, radius: float, plant: Plant) -> Law:
        circle = Ball(centre=centre.tolist(), radius=radius)
        return self._path(circle).begin(plant, _About(centre))


@dataclass(slots=True)
class _Chosen:
    """A law that the first measurement chooses."""

    choice: Callable[[Measured], Any]
    law: Any = None

    @property
    def memory(self) -> list[np.ndarray] | None:
        """That of the law."""
        return self.law.memory

    @memory.setter
    def memory(self, kept: Sequence[np.ndarray]) -> None:
        self.law.memory = kept

    def __call__(self, measured: Measured) -> Commands:
        """What the law commands."""
        if self.law is None:
            self.law = self.choice(measured)
        return self.law(measured)


@dataclass(slots=True)
class _About:
    """Attitude of a body that turns about a point."""

    centre: np.ndarray
    first: float | None = None
    """Direction from the centre to the handle, when the handle first moves. [rad]"""
    last: Number = 0.0

    @property
    def memory(self) -> list[np.ndarray] | None:
        """The last direction, whole turns counted; None before the first."""
        return None if self.first is None else [np.array([self.last])]

    @memory.setter
    def memory(self, kept: Sequence[np.ndarray]) -> None:
        ((self.last,),) = kept

    def __call__(self, going: Going) -> tuple[Number, Number]:
        """As `Attitude`."""
        out = going.position - self.centre
        around = angle_of(out[1], out[0])
        if self.first is None:
            self.first = self.last = around
        self.last = self.last + wrapped(around - self.last, 2.0 * math.pi)
        return sine(going.direction - around) / length_of(*out), self.last - self.first


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlanarHoldGuide:
    """Holds a planar cobot by wheels of which no motion lets all roll: its steering servos then rest, and friction keeps them.

    Raises
    ------
    ParameterError
        If fewer than three wheels, or no headings of theirs, lock the body.
    """

    def begin(self, plant: Plant) -> Law:
        """The law of one session."""
        headings = locking_headings(cobot_of(plant, "PlanarHoldGuide holds").positions)
        first: list[Commands] = [Commands(steering=headings, steering_rate=0.0 * headings)]
        return Unremembering(lambda measured: first.pop() if first else Commands())


def locking_headings(positions: Any) -> np.ndarray:
    r"""Headings of wheels that lock a body in the plane best.

    A wheel at p with the heading gamma resists the velocity along its axle, ``n . (v + omega J p)`` with ``n = J (cos, sin)``.
    The headings make the least singular value of these rows as large as possible, lengths in units of the wheels' rms distance
    from their mean.

    Parameters
    ----------
    positions : (k, 2) float   Of the wheels in the body. [m]

    Returns
    -------
    (k,) float   In axes of the body. [rad]

    Raises
    ------
    ParameterError
        If the wheels cannot lock the body: fewer than three, or all at one point.
    """
    from scipy.optimize import differential_evolution

    points = np.asarray(positions, dtype=float)
    points = points - points.mean(axis=0)
    size = float(np.sqrt(np.mean(np.sum(points**2, axis=1))))
    if len(points) < 3 or size < _STILL:
        raise ParameterError(f"a planar cobot is held by three wheels or more at different points, got {len(points)}")
    points = points / size

    def least(headings: np.ndarray) -> float:
        across = np.stack([-np.sin(headings), np.cos(headings)], axis=-1)
        moment = across[:, 1] * points[:, 0] - across[:, 0] * points[:, 1]
        values = np.linalg.svd(np.column_stack([across, moment]), compute_uv=False)
        return -float(values[-1] / values[0])

    best = differential_evolution(least, [(0.0, math.pi)] * len(points), rng=1, tol=1e-6)
    if -best.fun < _LOCKED:
        raise ParameterError("no headings of the wheels lock the planar cobot: its wheels must be at different points")
    return np.asarray(best.x)
