r"""Curves of virtual paths, in the plane and in space, by arc length.

All kinds have the members of `Curve`. With the unit tangent e and the arc length s, the curvature vector is
``de/ds``. In the plane the normal is to the left of e, so that

.. math:: \frac{de}{ds} = \kappa\, n, \qquad \frac{dn}{ds} = -\kappa\, e

and a point at the offset d to the left is ``r(s) + d n(s)``.

Source: docarmo1976, section 1-5.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar, Self

import numpy as np

from infinivar._core.array_namespace import Array
from infinivar._core.arrays import Whole, real_array, shown
from infinivar._core.bounds import FINITE, NonZero
from infinivar._core.fields import check_real, component, quantities, quantity
from infinivar.bondgraph.recorded import Recorded
from infinivar.bondgraph.scalars import choose, length_of
from infinivar.bondgraph.tape import Number
from infinivar.errors import ParameterError, require
from infinivar.motion.virtual import sampled_curve
from infinivar.motion.virtual.arc_length import CurvePoint, Pieces
from infinivar.motion.virtual.rows import SIZE, placed, unit

_FULL_TURN = 2.0 * math.pi


class Curve(Whole):
    """Base of the curves. A curve may cross itself: `nearest` then gives the closest branch, or the one that is near."""

    __slots__ = ()
    _pieces: Pieces

    @property
    def dimension(self) -> int:
        """2 in the plane, 3 in space."""
        return self._pieces.dimension

    @property
    def length(self) -> float:
        """From end to end, or around. [m]"""
        return self._pieces.length

    @property
    def is_closed(self) -> bool:
        """Whether it has no ends."""
        return self._pieces.closed

    @property
    def ends(self) -> np.ndarray:
        """First and last point; the same of a closed curve. (2, d) [m]"""
        return self._pieces.nodes[[0, -1]]

    def at(self, arc_length: Array) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Point [m], unit tangent and curvature vector [m^-1] at arc lengths.

        Parameters
        ----------
        arc_length : (...,) float   On a closed curve it goes around; on an open one it stops at the ends. [m]

        Returns
        -------
        point, tangent, curvature_vector : (..., d) float

        Raises
        ------
        ParameterError
            If an arc length is not finite.
        """
        there = real_array("arc_length", arc_length)
        require(bool(np.all(np.isfinite(there))), "arc_length", "nan or inf", "finite", "m")
        return self._pieces.at(there)

    def nearest(self, point: Array, near: Array | None = None) -> CurvePoint:
        """The point of the curve closest to a point, or to each row of points.

        Parameters
        ----------
        point : (d,) or (n, d) float     [m]
        near : float or (n,), optional   Arc length from which the closest point is followed downhill, as in the loop
            of a controller: several times faster, and true to its branch where a curve crosses itself. Without it,
            the whole curve is searched. [m]

        Returns
        -------
        CurvePoint

        Raises
        ------
        ParameterError
            If a point has another number of coordinates, or a value is not finite.
        """
        points = placed("point", point, self.dimension)
        if isinstance(points, Recorded):
            components = points.tolist()
            return self._single(components, self._pieces.follow(components, near))
        starts = None if near is None else _starts(near, points)
        if points.ndim == 1:
            there = self._pieces.nearest_to(points) if starts is None else self._followed(points, starts[0])
            return self._single(points.tolist(), there)
        require(
            points.ndim == 2, "point", f"shape {points.shape}", f"of shape ({self.dimension},) or (n, {self.dimension})"
        )
        if starts is None:
            return self._many(points, self._pieces.nearest(points))
        return self._many(points, np.array([self._followed(*pair) for pair in zip(points, starts, strict=True)], float))

    def _followed(self, point: np.ndarray, near: float) -> float:
        found = self._pieces.follow(point.tolist(), near)
        return self._pieces.nearest_to(point) if found is None else found

    def _single(self, point: list[Number], there: Number) -> CurvePoint:
        """What a `CurvePoint` tells, in plain numbers."""
        place, slope, bend = self._pieces.local(there)
        speed = length_of(*slope)
        tangent = [one / speed for one in slope]
        gap = [p - a for p, a in zip(point, place, strict=True)]
        beyond: Number = 0.0
        if not self._pieces.closed:
            along = sum(t * g for t, g in zip(tangent, gap, strict=True))
            beyond = choose((there <= 0.0) | (there >= self._pieces.length), lambda: along, lambda: 0.0)
        if len(place) == 2:
            turn = tangent[0] * bend[1] - tangent[1] * bend[0]
            offset = tangent[0] * gap[1] - tangent[1] * gap[0]
        else:
            turn = length_of(*bend)
            offset = length_of(*(g - beyond * t for t, g in zip(tangent, gap, strict=True)))
        return CurvePoint(there, np.array(place), np.array(tangent), np.array(bend), turn, offset, beyond)

    def _many(self, points: np.ndarray, there: np.ndarray) -> CurvePoint:
        place, tangent, bend = self._pieces.at(there)
        gap = points - place
        at_end = (there <= 0.0) | (there >= self.length) if not self.is_closed else np.zeros(len(there), dtype=bool)
        beyond = np.where(at_end, np.sum(tangent * gap, axis=-1), 0.0)
        if self.dimension == 2:
            turn = tangent[:, 0] * bend[:, 1] - tangent[:, 1] * bend[:, 0]
            offset = tangent[:, 0] * gap[:, 1] - tangent[:, 1] * gap[:, 0]
        else:
            turn = np.sqrt(np.sum(bend**2, axis=-1))
            offset = np.sqrt(np.sum((gap - beyond[:, None] * tangent) ** 2, axis=-1))
        return CurvePoint(there, place, tangent, bend, turn, offset, beyond)


def _starts(near: Array, points: np.ndarray) -> list[float]:
    """Arc lengths from which to follow, one a point; raises ParameterError if they do not fit the points."""
    if type(near) is float and math.isfinite(near) and points.ndim == 1:
        return [near]
    starts = real_array("near", near)
    expected = "one number" if points.ndim == 1 else f"one number, or {len(points)} of them"
    require(starts.shape in ((), points.shape[:-1]), "near", f"shape {starts.shape}", expected)
    require(bool(np.isfinite(starts).all()), "near", "nan or inf", "finite", "m")
    return np.broadcast_to(starts, points.shape[:-1] or (1,)).tolist()


@dataclass(frozen=True, slots=True, kw_only=True)
class PointCurve(Curve):
    """A smooth curve through points: a cubic spline, in the plane or in space.

    A turn by more than 45 degrees, and by more than three times the mean turn at the two neighbours, is a kink; so is any
    turn by more than 150 degrees. Where points far apart follow points close together, a spline may swing out: look at it.

    Raises
    ------
    ParameterError
        If there are too few points, their coordinates differ in number, two points in a row are the same, or there is
        a kink.
    """

    shape: ClassVar[str] = "points"
    x: Sequence[float] = quantities("m", FINITE, "Positions along x")
    y: Sequence[float] = quantities("m", FINITE, "Positions along y")
    z: Sequence[float] | None = quantities("m", FINITE, "Positions along z; left out in the plane", default=None)
    closed: bool = component("Whether the last point is joined to the first", default=False)
    _pieces: Pieces = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Validate the fields and lay the spline."""
        check_real(self)
        require(isinstance(self.closed, bool), "closed", shown(self.closed), "true or false")
        rows = [self.x, self.y] if self.z is None else [self.x, self.y, self.z]
        for name, row in zip("yz", rows[1:], strict=False):
            require(len(row) == len(self.x), name, f"{len(row)} values", f"as many as x: {len(self.x)}")
        points = placed("points", np.array(rows, dtype=float).T, len(rows))
        object.__setattr__(self, "_pieces", sampled_curve.through(points, self.closed))

    @classmethod
    def through(cls, points: Array, *, closed: bool = False) -> Self:
        """The curve through points (n, 2) or (n, 3). [m]

        Raises
        ------
        ParameterError
            As for the class.
        """
        rows = real_array("points", points)
        fits = rows.ndim == 2 and rows.shape[-1] in (2, 3)
        require(fits, "points", f"shape {rows.shape}", "of shape (n, 2) or (n, 3)")
        wrong = np.flatnonzero(~np.isfinite(rows).all(axis=1))
        if len(wrong):
            raise ParameterError(f"point {wrong[0] + 1} must have finite coordinates, got {rows[wrong[0]].tolist()}")
        return cls(**{name: tuple(row) for name, row in zip("xyz", rows.T.tolist(), strict=False)}, closed=closed)


@dataclass(frozen=True, slots=True, kw_only=True)
class LineCurve(Curve):
    """A straight line between two points.

    Raises
    ------
    ParameterError
        If a point has not two or three coordinates, or they are the same.
    """

    shape: ClassVar[str] = "line"
    start: Sequence[float] = quantities("m", FINITE, "First point: two or three coordinates")
    end: Sequence[float] = quantities("m", FINITE, "Last point")
    _pieces: Pieces = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_real(self)
        start = placed("start", self.start)
        end = placed("end", self.end, len(start))
        require(bool(np.any(start != end)), "end", f"{list(self.end)} m", "another point than start")
        object.__setattr__(self, "_pieces", sampled_curve.through(np.array([start, end]), False))


@dataclass(frozen=True, slots=True, kw_only=True)
class ArcCurve(Curve):
    """An arc of a circle, a whole circle, or with a pitch a helix.

    In the plane it starts at the angle `start_angle` from x and turns left for a positive `turn`. In space it turns
    about `axis` by the right-hand rule; the angle is measured from the direction x across the axis, or from y where
    the axis is along x. A turn of 360 degrees without a pitch closes the circle.

    Raises
    ------
    ParameterError
        If a field is outside its range, the turn of a flat arc is over 360 degrees, or a pitch is given in the plane.
    """

    shape: ClassVar[str] = "arc"
    centre: Sequence[float] = quantities("m", FINITE, "Centre: two or three coordinates")
    radius: float = quantity("m", SIZE, "Radius")
    start_angle: float = quantity("rad", FINITE, "Angle of the start", default=0.0)
    turn: float = quantity(
        "rad", NonZero(), "Angle from the start to the end; negative turns right", default=_FULL_TURN
    )
    axis: Sequence[float] | None = quantities("1", FINITE, "Direction of the axis, in space", default=None)
    pitch: float = quantity("m", FINITE, "Advance along the axis in one turn, in space", default=0.0)
    _pieces: Pieces = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_real(self)
        centre = placed("centre", self.centre)
        if len(centre) == 2:
            require(self.axis is None, "axis", shown(self.axis), "left out in the plane")
            require(self.pitch == 0.0, "pitch", f"{self.pitch:g} m", "left out in the plane")
            first, second, axis = np.eye(2)[0], np.eye(2)[1], np.zeros(2)
        else:
            require(self.axis is not None, "axis", None, "given in space: three numbers")
            axis = unit("axis", self.axis, 3)  # type: ignore[arg-type]
            across = np.array([1.0, 0.0, 0.0]) - axis[0] * axis
            if across @ across < 1e-12:
                across = np.array([0.0, 1.0, 0.0]) - axis[1] * axis
            first = across / np.sqrt(across @ across)
            second = np.cross(axis, first)
        whole = abs(abs(self.turn) - _FULL_TURN) <= 1e-12
        require(
            self.pitch != 0.0 or whole or abs(self.turn) < _FULL_TURN,
            "turn",
            f"{math.degrees(self.turn):g} degrees",
            "at most 360 degrees without a pitch",
        )
        r, rise, way, begin = (
            self.radius,
            self.pitch / _FULL_TURN * math.copysign(1.0, self.turn),
            math.copysign(1.0, self.turn),
            self.start_angle,
        )

        def base(u: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
            cos, sin = np.cos(begin + way * u)[:, None], np.sin(begin + way * u)[:, None]
            out, on = cos * first + sin * second, cos * second - sin * first
            return centre + r * out + rise * u[:, None] * axis, way * r * on + rise * axis, -r * out

        count = max(2, math.ceil(abs(self.turn) / 0.1))
        pieces = Pieces.of(base, np.linspace(0.0, abs(self.turn), count + 1), whole and self.pitch == 0.0)
        object.__setattr__(self, "_pieces", pieces)


CURVES: dict[str, type] = {kind.shape: kind for kind in (PointCurve, LineCurve, ArcCurve)}
"""Kinds of curves by their name in `shape`."""
