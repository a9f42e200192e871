r"""Surfaces of virtual walls: half-spaces, balls and tubes, and several at once.

All have the members of `Surface`. The signed distance d is > 0 on the free side; its gradient is the unit normal n,
towards the free side, and its second derivatives H, symmetric with ``H n = 0``, give the curvature. Along the motion
of a point with the velocity v, ``dn/dt = H v``; to keep its distance, the point needs the acceleration ``-v^T H v``
along n.

In the plane the half-space is a half-plane and the ball a disc.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Literal, NamedTuple, Protocol, runtime_checkable

import numpy as np

from infinivar._core.array_namespace import Array
from infinivar._core.arrays import HoldsArrays, Whole, shown
from infinivar._core.bounds import FINITE
from infinivar._core.fields import check_number, check_real, component, missing_members, quantities, quantity, several
from infinivar._core.frozen import frozen
from infinivar.errors import ParameterError, require
from infinivar.motion.virtual.rows import SIZE, placed, unit

Side = Literal["outside", "inside"]

_CENTRE = 1e-9
"""Distance from a centre or an axis, over the radius, below which the normal has a fixed direction."""


@runtime_checkable
class Surface(Protocol):
    """What a virtual wall needs of a surface. Points are (d,) or (n, d), in metres."""

    @property
    def dimension(self) -> int:
        """2 in the plane, 3 in space."""
        ...

    def distance(self, point: Array) -> np.ndarray:
        """Signed distance, > 0 on the free side. (...,) [m]"""
        ...

    def normal(self, point: Array) -> np.ndarray:
        """Gradient of the distance: a unit vector towards the free side. (..., d)"""
        ...

    def hessian(self, point: Array) -> np.ndarray:
        """Second derivatives of the distance. (..., d, d) [m^-1]"""
        ...


MEMBERS = ("dimension", "distance", "normal", "hessian")
"""Members of `Surface`, for messages about what a user's class lacks."""


class _Local(NamedTuple):
    distance: np.ndarray
    normal: np.ndarray
    hessian: np.ndarray


class _Smooth:
    """Base of the surfaces whose distance has one formula everywhere."""

    __slots__ = ()

    @property
    def dimension(self) -> int:
        """2 in the plane, 3 in space."""
        raise NotImplementedError

    def _local(self, points: np.ndarray) -> _Local:
        raise NotImplementedError

    def _placed(self, point: Array) -> np.ndarray:
        return placed("point", point, self.dimension)

    def distance(self, point: Array) -> np.ndarray:
        """Signed distance of points (..., d), > 0 on the free side. (...,) [m]"""
        return self._local(self._placed(point)).distance

    def normal(self, point: Array) -> np.ndarray:
        """Gradient of the distance: a unit vector towards the free side. (..., d)"""
        return self._local(self._placed(point)).normal

    def hessian(self, point: Array) -> np.ndarray:
        """Second derivatives of the distance. (..., d, d) [m^-1]"""
        return self._local(self._placed(point)).hessian


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class HalfSpace(_Smooth, HoldsArrays):
    """The side of a plane to which its normal points; in the plane, the side of a line; on one axis, of a point.

    Raises
    ------
    ParameterError
        If the normal is zero, or has another number of components than the point.
    """

    shape: ClassVar[str] = "half-space"
    point: Sequence[float] = quantities(
        "m", FINITE, "A point of the surface: as many coordinates as the handle has axes"
    )
    direction: Sequence[float] = quantities("1", FINITE, "Normal, towards the free side; of any length")
    _frame: Any = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_real(self)
        point = placed("point", self.point, on_axis=True)
        object.__setattr__(self, "_frame", (frozen(point), frozen(unit("direction", self.direction, len(point)))))

    @property
    def dimension(self) -> int:
        """1 on an axis, 2 in the plane, 3 in space."""
        return len(self.point)

    def _local(self, points: np.ndarray) -> _Local:
        point, normal = self._frame
        flat = np.zeros((*points.shape, len(point)))
        return _Local((points - point) @ normal, np.broadcast_to(normal, points.shape), flat)


def _round(away: np.ndarray, radius: float, free: Side, first: np.ndarray, across: np.ndarray) -> _Local:
    """Distance from a circle, sphere or cylinder of points at positions `away` from its centre, across its axis.

    `first` is the direction out where there is none, and `across` projects on the space of `away`.
    """
    far = np.sqrt(np.sum(away**2, axis=-1))
    kept = far > _CENTRE * radius
    safe = np.where(kept, far, _CENTRE * radius)
    out = np.where(kept[..., None], away / safe[..., None], first)
    sign = 1.0 if free == "outside" else -1.0
    bend = (across - out[..., :, None] * out[..., None, :]) / safe[..., None, None]
    return _Local(sign * (far - radius), sign * out, sign * bend)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Ball(_Smooth, HoldsArrays):
    """A ball that is solid, or a round cavity; in the plane a disc or a round hole.

    At the centre itself, where all directions lead out, the normal is along x and the curvature that of a point 1e-9
    of the radius away.

    Raises
    ------
    ParameterError
        If a field is outside its range.
    """

    shape: ClassVar[str] = "ball"
    centre: Sequence[float] = quantities("m", FINITE, "Centre: two or three coordinates")
    radius: float = quantity("m", SIZE, "Radius")
    free: Side = component("Free side: outside a solid ball, or inside a cavity", default="outside")
    _centre: np.ndarray = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_real(self)
        object.__setattr__(self, "_centre", frozen(placed("centre", self.centre)))

    @property
    def dimension(self) -> int:
        """2 in the plane, 3 in space."""
        return len(self.centre)

    def _local(self, points: np.ndarray) -> _Local:
        every = np.eye(self.dimension)
        return _round(points - self._centre, self.radius, self.free, every[0], every)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Tube(_Smooth, HoldsArrays):
    """An endless round rod that is solid, or a bore; in space.

    On the axis itself, where all directions across lead out, the normal has a fixed one of them.

    Raises
    ------
    ParameterError
        If a field is outside its range, or a point has not three coordinates.
    """

    shape: ClassVar[str] = "tube"
    point: Sequence[float] = quantities("m", FINITE, "A point of the axis: three coordinates")
    axis: Sequence[float] = quantities("1", FINITE, "Direction of the axis")
    radius: float = quantity("m", SIZE, "Radius")
    free: Side = component("Free side: outside a solid rod, or inside a bore", default="outside")
    _frame: Any = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_real(self)
        point, axis = placed("point", self.point, 3), unit("axis", self.axis, 3)
        across = np.eye(3) - np.outer(axis, axis)
        first = across[int(np.argmin(np.abs(axis)))]
        first = first / np.sqrt(first @ first)
        object.__setattr__(self, "_frame", tuple(frozen(part) for part in (point, across, first)))

    @property
    def dimension(self) -> int:
        """Always 3."""
        return 3

    def _local(self, points: np.ndarray) -> _Local:
        point, across, first = self._frame
        return _round((points - point) @ across, self.radius, self.free, first, across)


class Active(NamedTuple):
    """A surface that counts at a point."""

    place: int
    """Among the surfaces, from 0."""
    distance: float
    """[m]"""
    normal: np.ndarray
    """(d,)"""
    hessian: np.ndarray
    """(d, d) [m^-1]"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Surfaces(Whole):
    """Several surfaces at once: walls that all hold, or obstacles that are one where they meet.

    With `free` = "all" a point is free where it is on the free side of all of them: in a corner or a channel, or
    among several solids. The distance is the least: on the free side that to the nearest wall; beyond a wall beside a
    corner the true depth may be larger. With `free` = "any" it is free where it is on the free side of any of them,
    such as outside a block that its faces bound; the distance is the largest: exact within the block, and outside it,
    beside an edge, the true distance may be larger.

    Raises
    ------
    ParameterError
        If there is none, one is no surface, or they differ in their number of coordinates.
    """

    surfaces: tuple[Surface, ...] = component("Surfaces, one or more")
    free: Literal["all", "any"] = component("Whether a free point is free of all of them, or of any", default="all")

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_real(self)
        given = self.surfaces
        require(isinstance(given, Sequence) and len(given) > 0, "surfaces", shown(given), "one surface or more")
        object.__setattr__(self, "surfaces", tuple(given))
        for place, one in enumerate(self.surfaces, 1):
            check_surface(f"surfaces {place}", one)
            expected = self.surfaces[0].dimension
            require(
                one.dimension == expected,
                f"surfaces {place}",
                f"one in {one.dimension}",
                f"in {expected} dimensions, as surfaces 1",
            )

    @property
    def dimension(self) -> int:
        """2 in the plane, 3 in space."""
        return self.surfaces[0].dimension

    def _decisive(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Distance, and the place of the surface that decides it."""
        every = np.stack([np.asarray(one.distance(points)) for one in self.surfaces])
        place = np.argmin(every, axis=0) if self.free == "all" else np.argmax(every, axis=0)
        return np.take_along_axis(every, place[None], axis=0)[0], place

    def _of(self, point: Array, what: str) -> np.ndarray:
        points = placed("point", point, self.dimension)
        place = self._decisive(points)[1]
        found = np.stack([getattr(one, what)(points) for one in self.surfaces])
        return np.take_along_axis(found, place.reshape(1, *place.shape, *(1,) * (found.ndim - 1 - place.ndim)), axis=0)[
            0
        ]

    def distance(self, point: Array) -> np.ndarray:
        """Signed distance of points (..., d), > 0 on the free side. (...,) [m]"""
        return self._decisive(placed("point", point, self.dimension))[0]

    def normal(self, point: Array) -> np.ndarray:
        """Normal of the surface that decides the distance. (..., d)"""
        return self._of(point, "normal")

    def hessian(self, point: Array) -> np.ndarray:
        """Second derivatives of the distance from the surface that decides it. (..., d, d) [m^-1]"""
        return self._of(point, "hessian")

    def active(self, point: Array, within: float = 0.0) -> tuple[Active, ...]:
        """The surfaces that count at one point, the most urgent first.

        With `free` = "all", those that are nearer than `within`, or penetrated. With "any", if the distance is less
        than `within`, those whose distance is within `within` of the largest: one on a face, two at an edge.

        Parameters
        ----------
        point : (d,) float   [m]
        within : float       >= 0. [m]

        Raises
        ------
        ParameterError
            If it is not one point, or `within` is negative.
        """
        there = placed("point", point, self.dimension)
        require(there.ndim == 1, "point", f"shape {there.shape}", f"one point of {self.dimension} coordinates")
        check_number("within", within, "m", FINITE)
        require(within >= 0.0, "within", within, ">= 0", "m")
        distances = [float(one.distance(there)) for one in self.surfaces]
        if self.free == "all":
            kept = [place for place, one in enumerate(distances) if one <= within]
        else:
            largest = max(distances)
            kept = [place for place, one in enumerate(distances) if largest <= within and one >= largest - within]
        urgent = sorted(kept, key=lambda place: distances[place] if self.free == "all" else -distances[place])
        return tuple(
            Active(place, distances[place], self.surfaces[place].normal(there), self.surfaces[place].hessian(there))
            for place in urgent
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class FlatWalls(Whole):
    """Several half-spaces as one surface, such as a corner, a channel or a block; see `Surfaces`.

    Raises
    ------
    ParameterError
        If they differ in their number of coordinates.
    """

    shape: ClassVar[str] = "flat walls"
    walls: tuple[HalfSpace, ...] = several("Half-spaces, each by a point and a direction", HalfSpace)
    free: Literal["all", "any"] = component("Whether a free point is free of all of them, or of any", default="all")
    together: Surfaces = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_real(self)
        object.__setattr__(self, "together", Surfaces(surfaces=self.walls, free=self.free))

    @property
    def dimension(self) -> int:
        """2 in the plane, 3 in space."""
        return self.together.dimension

    def distance(self, point: Array) -> np.ndarray:
        """As `Surfaces.distance`. (...,) [m]"""
        return self.together.distance(point)

    def normal(self, point: Array) -> np.ndarray:
        """As `Surfaces.normal`. (..., d)"""
        return self.together.normal(point)

    def hessian(self, point: Array) -> np.ndarray:
        """As `Surfaces.hessian`: zero. (..., d, d) [m^-1]"""
        return self.together.hessian(point)


def check_surface(name: str, value: Any) -> None:
    """Raise ParameterError unless a value has the members of `Surface`."""
    missing = missing_members(value, MEMBERS)
    if isinstance(value, type) or "distance" in missing:
        raise ParameterError(
            f"{name} must be a surface, such as a HalfSpace, Ball, Tube or TriangleMesh, got {shown(value)}"
        )
    if missing:
        raise ParameterError(
            f"{name} must be a surface with {', '.join(MEMBERS)}, but a {type(value).__name__} has no {missing[0]}"
        )
