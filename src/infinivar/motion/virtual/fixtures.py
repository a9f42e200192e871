r"""Fixtures: what a user can move a handle along or about, as rows ``A xi = 0`` on its twist.

The twist xi has the velocity v of the handle's end point at p and the angular velocity w, both along fixed axes. The
kinds of fixtures here are stated in space, by points and directions; `rows` gives them in the coordinates that a
machine has, some of x, y, z, rx, ry, rz, and in the plane x, y and angle, where z stands still and the angle turns
about z.

For a body that turns about an axis a through c and advances by h a radian,

.. math:: v = \left(a \times (p - c) + h a\right) (a \cdot w), \qquad w = (a \cdot w)\, a

so that A depends on p, and changes along a motion at the rate ``dA/dt``.

Source: featherstone2008, chapter 3, for constraints by rows; lynch2017, section 3.3, for the screw.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np

from infinivar._core.array_namespace import Array
from infinivar._core.arrays import Whole, real_array, shown
from infinivar._core.bounds import FINITE
from infinivar._core.fields import check_real, component, quantities, quantity, several
from infinivar._core.frozen import frozen
from infinivar.errors import InputError, ParameterError, nearest, require
from infinivar.motion.vectors import COORDINATES, ROTATIONS, Vector
from infinivar.motion.virtual.arc_length import coordinates
from infinivar.motion.virtual.constrained import rank_of
from infinivar.motion.virtual.curves import Curve
from infinivar.motion.virtual.rows import cross, perpendicular, perpendicular_in_motion, placed, unit
from infinivar.motion.virtual.surfaces import Surface, check_surface

_SPACE = COORDINATES[:6]
_CENTRE = 1e-6
"""Distance from a centre of curvature over the radius, within which a curve does not guide."""

_ZERO = 1e-12
"""Entries of unit rows below which a row constrains nothing in the coordinates of a machine."""


class FixtureRows(NamedTuple):
    """The constraints of a fixture at one pose."""

    rows: np.ndarray
    """A. (k, d)"""
    rates: np.ndarray
    """dA/dt along the motion; zero at rest. (k, d)"""


@functools.cache
def _spread(names: tuple[str, ...]) -> np.ndarray:
    """Twists in space of the coordinates of a machine, (6, d); raises ParameterError if they are none of an end point's."""
    known = ", ".join(COORDINATES)
    require(len(names) > 0, "coordinates", "none", f"some of {known}")
    for name in names:
        if name not in COORDINATES:
            hint = nearest(name, COORDINATES) if isinstance(name, str) else ""
            raise ParameterError(f"coordinates must be some of {known}, got {name!r}{hint}")
    require(len(set(names)) == len(names), "coordinates", shown(names), "different")
    turning = "angle" in names and any(name in ROTATIONS for name in names)
    require(not turning, "coordinates", shown(names), "without rx, ry and rz beside angle, which is about z")
    found = np.zeros((6, len(names)))
    for column, name in enumerate(names):
        found[5 if name == "angle" else _SPACE.index(name), column] = 1.0
    return frozen(found)


class Allowed(Whole):
    """Base of the kinds of fixtures: what is allowed to move."""

    __slots__ = ()

    def _in_space(self, position: np.ndarray, velocity: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rows (k, 6) and their rates at a position, for a velocity of the end point."""
        raise NotImplementedError

    def rows(
        self, coordinates: Sequence[str], position: Array = (0.0, 0.0, 0.0), twist: Array | None = None
    ) -> FixtureRows:
        """The constraints on the twist of a machine, without those that its coordinates keep anyway.

        Parameters
        ----------
        coordinates : names        Of the machine's twist: some of x, y, z, rx, ry, rz, or angle.
        position : (3,) or (2,)    p, of the end point. [m]
        twist : (d,), optional     xi, for the rates; None: at rest.

        Returns
        -------
        FixtureRows

        Raises
        ------
        ParameterError
            If a value has the wrong shape.
        InputError
            If the fixture leaves the machine no freedom, constrains nothing of it, or cannot guide it at the position.
        """
        listed = isinstance(coordinates, (tuple, list)) and all(isinstance(one, str) for one in coordinates)
        require(listed, "coordinates", shown(coordinates), f"some of {', '.join(COORDINATES)}")
        names = tuple(coordinates)
        spread = _spread(names)
        flat = np.shape(position) == (2,)
        place = placed("position", position, 2 if flat else 3)
        require(place.ndim == 1, "position", f"shape {place.shape}", "one point")
        place = np.concatenate([place, np.zeros(3 - len(place))])
        rates = np.zeros(len(names)) if twist is None else real_array("twist", twist)
        require(rates.shape == (len(names),), "twist", f"shape {rates.shape}", f"of shape ({len(names)},)")
        require(bool(np.isfinite(rates).all()), "twist", "nan or inf", "finite")
        space, changes = self._in_space(place, (spread @ rates)[:3])
        A, dA = space @ spread, changes @ spread
        kept = np.any(np.abs(A) > _ZERO * np.max(np.abs(space), axis=1, keepdims=True), axis=1)
        if not kept.any():
            raise InputError(f"the fixture constrains nothing of a machine that moves {', '.join(names)}")
        A, dA = A[kept], dA[kept]
        rank = rank_of(A)
        if rank >= len(names):
            raise InputError(f"the fixture leaves nothing free of a machine that moves {', '.join(names)}")
        if rank < len(A):
            raise InputError(
                f"the fixture has {len(A)} dependent constraints of rank {rank} on a machine that moves {', '.join(names)}"
            )
        return FixtureRows(A, dA)

    def freedoms(self, coordinates: Sequence[str], position: Array = (0.0, 0.0, 0.0)) -> int:
        """Number of free dimensions of a machine with these coordinates; 1 to 5. Parameters and errors as `rows`."""
        made = self.rows(coordinates, position).rows
        return made.shape[1] - made.shape[0]


_TURNS = np.hstack([np.zeros((3, 3)), np.eye(3)])
"""Rows that stop all turning."""


def _moving(*vectors: np.ndarray) -> np.ndarray:
    """Rows on the velocity, by vectors (3,)."""
    return np.hstack([np.array(vectors), np.zeros((len(vectors), 3))])


@dataclass(frozen=True, slots=True, kw_only=True)
class AlongLine(Allowed):
    """Sliding along a line: 1 free dimension, or with turning 4.

    Raises
    ------
    ParameterError
        If the direction is zero, or a field is outside its range.
    """

    shape: ClassVar[str] = "line"
    direction: Sequence[float] = quantities("1", FINITE, "Direction of the line: two or three components")
    turning: bool = component("Whether the handle turns freely", default=False)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_real(self)
        _flag("turning", self.turning)
        _in_three("direction", self.direction, True)

    def _in_space(self, position: np.ndarray, velocity: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        across = _moving(*perpendicular(_in_three("direction", self.direction, True)))
        found = across if self.turning else np.vstack([across, _TURNS])
        return found, np.zeros_like(found)


@dataclass(frozen=True, slots=True, kw_only=True)
class InPlane(Allowed):
    """Sliding in a plane: 2 free dimensions; turning about its normal too, 3; or turning in any way, 5.

    Raises
    ------
    ParameterError
        If the normal is zero, or a field is outside its range.
    """

    shape: ClassVar[str] = "plane"
    normal: Sequence[float] = quantities("1", FINITE, "Normal of the plane: three components")
    turning: Literal["none", "normal", "any"] = component(
        "Turning that is free: none, about the normal, or any", default="none"
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_real(self)
        unit("normal", self.normal, 3)

    def _in_space(self, position: np.ndarray, velocity: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        normal = unit("normal", self.normal, 3)
        found = _moving(normal)
        if self.turning == "normal":
            found = np.vstack([found, np.roll(_moving(*perpendicular(normal)), 3, axis=1)])
        elif self.turning == "none":
            found = np.vstack([found, _TURNS])
        return found, np.zeros_like(found)


@dataclass(frozen=True, slots=True, kw_only=True)
class AboutAxis(Allowed):
    """Turning about an axis; with a pitch a screw: 1 free dimension. With sliding, a shaft in a bushing: 2.

    Raises
    ------
    ParameterError
        If the axis is zero, a pitch is stated beside sliding, or a field is outside its range.
    """

    shape: ClassVar[str] = "axis"
    point: Sequence[float] = quantities("m", FINITE, "A point of the axis: two or three coordinates")
    axis: Sequence[float] = quantities("1", FINITE, "Direction of the axis", default=(0.0, 0.0, 1.0))
    pitch: float = quantity("m", FINITE, "Advance along the axis in one turn by the right-hand rule", default=0.0)
    sliding: bool = component("Whether the handle slides freely along the axis", default=False)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_real(self)
        _flag("sliding", self.sliding)
        if self.sliding and self.pitch != 0.0:
            raise ParameterError("pitch and sliding exclude each other: a screw advances as it turns; remove one")
        _in_three("point", self.point, False)
        unit("axis", self.axis, 3)

    def _in_space(self, position: np.ndarray, velocity: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        a = unit("axis", self.axis, 3)
        first, second = perpendicular(a)
        arm = cross(a, position - _in_three("point", self.point, False)) + self.pitch / (2.0 * math.pi) * a
        along = np.eye(3) if not self.sliding else np.array([first, second])
        motion = np.hstack([along, -np.outer(along @ arm, a)])
        change = np.hstack([np.zeros((len(along), 3)), -np.outer(along @ cross(a, velocity), a)])
        turns = np.roll(_moving(first, second), 3, axis=1)
        return np.vstack([motion, turns]), np.vstack([change, np.zeros_like(turns)])


@dataclass(frozen=True, slots=True, kw_only=True)
class AboutPoint(Allowed):
    """Turning in any way about a point, as in a ball joint: 3 free dimensions; in the plane 1.

    Raises
    ------
    ParameterError
        If a coordinate is not finite.
    """

    shape: ClassVar[str] = "ball joint"
    point: Sequence[float] = quantities("m", FINITE, "Centre: two or three coordinates")

    def __post_init__(self) -> None:
        """Validate the field."""
        check_real(self)
        _in_three("point", self.point, False)

    def _in_space(self, position: np.ndarray, velocity: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        arm = position - _in_three("point", self.point, False)
        return np.hstack([np.eye(3), _crossed(arm)]), np.hstack([np.zeros((3, 3)), _crossed(velocity)])


@dataclass(frozen=True, slots=True, kw_only=True)
class Row(Vector):
    """One constraint: a combination of the rates that must stay zero; what is not stated is 0.

    Raises
    ------
    ParameterError
        If nothing is stated, or all is zero.
    """

    x: float | None = quantity("1", FINITE, "Factor of the velocity along x", default=None)
    y: float | None = quantity("1", FINITE, "Factor of the velocity along y", default=None)
    z: float | None = quantity("1", FINITE, "Factor of the velocity along z", default=None)
    rx: float | None = quantity("m", FINITE, "Factor of the angular velocity about x", default=None)
    ry: float | None = quantity("m", FINITE, "Factor of the angular velocity about y", default=None)
    rz: float | None = quantity("m", FINITE, "Factor of the angular velocity about z", default=None)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_real(self)
        require(any(self.stated.values()), "row", "only zeros", "a constraint: a factor of one of x, y, z, rx, ry, rz")


@dataclass(frozen=True, slots=True, kw_only=True)
class ByRows(Allowed):
    """What 1 to 5 constant constraints on the twist leave free.

    Raises
    ------
    ParameterError
        If there are more than five, or they are dependent.
    """

    shape: ClassVar[str] = "rows"
    constraints: tuple[Row, ...] = several("Constraints, each a combination of rates that stays zero", Row)

    def __post_init__(self) -> None:
        """Validate the field."""
        check_real(self)
        require(
            len(self.constraints) <= 5, "constraints", len(self.constraints), "at most 5, which leave 1 dimension free"
        )
        A = np.array([one.row(_SPACE) for one in self.constraints])
        rank = rank_of(A)
        require(rank == len(A), "constraints", f"{len(A)} of rank {rank}", "independent: remove what others imply")

    def _in_space(self, position: np.ndarray, velocity: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        found = np.array([one.row(_SPACE) for one in self.constraints])
        return found, np.zeros_like(found)


@dataclass(frozen=True, slots=True, kw_only=True)
class OnSurface(Allowed):
    """The end point keeps its distance from a surface: 5 free dimensions, or without turning 2; in the plane 1 less.

    Raises
    ------
    ParameterError
        If it is no surface.
    """

    surface: Surface = component("A surface, such as a HalfSpace, Ball, Tube or TriangleMesh")
    turning: bool = component("Whether the handle turns freely", default=True)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_surface("surface", self.surface)
        _flag("turning", self.turning)

    def _in_space(self, position: np.ndarray, velocity: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        d = self.surface.dimension
        row, rate = np.zeros((1, 6)), np.zeros((1, 6))
        row[0, :d] = self.surface.normal(position[:d])
        rate[0, :d] = self.surface.hessian(position[:d]) @ velocity[:d]
        return _with_turns(row, rate, self.turning)


@dataclass(frozen=True, slots=True, kw_only=True)
class OnCurve(Allowed):
    """The end point moves along a curve, or parallel to it: 1 free dimension, or with turning 4; in the plane 1 or 2.

    Raises
    ------
    ParameterError
        If it is no curve.
    """

    curve: Curve = component("A curve, such as a PointCurve or an ArcCurve")
    turning: bool = component("Whether the handle turns freely", default=False)

    def __post_init__(self) -> None:
        """Validate the fields."""
        require(
            isinstance(self.curve, Curve),
            "curve",
            shown(self.curve),
            "a curve, such as a PointCurve or an ArcCurve",
        )
        _flag("turning", self.turning)

    def _in_space(self, position: np.ndarray, velocity: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        d = self.curve.dimension
        here = self.curve.nearest(position[:d])
        e, bend, gap = np.zeros(3), np.zeros(3), np.zeros(3)
        e[:d], bend[:d], gap[:d] = here.tangent, here.curvature_vector, position[:d] - here.point
        # The closest point moves on at ds/dt = v.e/(1 - gap.bend); past an end it stays.
        room = 1.0 - float(gap @ bend)
        if abs(room) < _CENTRE:
            raise InputError(
                f"the fixture cannot guide at {coordinates(position[:d])}, a centre of curvature of its curve"
            )
        pace = 0.0 if here.beyond else float(velocity @ e) / room
        rows, rates = (_moving(*pair) for pair in perpendicular_in_motion(e, pace * bend))
        return _with_turns(rows, rates, self.turning)


def _with_turns(rows: np.ndarray, rates: np.ndarray, turning: bool) -> tuple[np.ndarray, np.ndarray]:
    if turning:
        return rows, rates
    return np.vstack([rows, _TURNS]), np.vstack([rates, np.zeros_like(_TURNS)])


def _crossed(vector: np.ndarray) -> np.ndarray:
    """Matrix S of a vector a with ``S b = a x b``."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def _in_three(name: str, value: Sequence[float], direction: bool) -> np.ndarray:
    """A point or direction of two or three components in space; of two, it lies in the plane of x and y."""
    given = placed(name, value)
    flat = unit(name, given, len(given)) if direction else given
    return np.concatenate([flat, np.zeros(3 - len(flat))])


def _flag(name: str, value: Any) -> None:
    require(isinstance(value, bool), name, shown(value), "true or false")


FIXTURES: dict[str, type] = {kind.shape: kind for kind in (AlongLine, InPlane, AboutAxis, AboutPoint, ByRows)}
"""Kinds of fixtures by their name in `shape`."""
