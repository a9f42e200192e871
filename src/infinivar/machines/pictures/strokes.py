"""Strokes of which a picture of a machine is made: lines, areas, arrows and words in metres, in the plane of the viewer.

A kind of machine gives a `Picture`. Painters turn it into a figure (`infinivar.figures.pictures`) and a scene of a page
(`infinivar.web.answers.shapes`), in the order of its strokes. The *look* of a stroke names what it shows, such as "wheel"; each
painter has colours and line widths for it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from infinivar.units import plain

Vector = Any
"""(2,) [m]"""

ROUND = np.linspace(0.0, 2.0 * math.pi, 73)
CIRCLE = np.stack([np.cos(ROUND), np.sin(ROUND)], axis=-1)
"""A circle of radius 1. (m, 2)"""

_CORNERS = np.array([(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)])


@dataclass(frozen=True, slots=True)
class Line:
    """A line through points, or the area within them."""

    points: Any
    """(n, 2) [m]"""
    look: str
    closed: bool = False
    framed: bool = True
    """Whether a drawing must have room for all of it."""
    share: float | None = None
    """Of its limit, from -1 to 1, where colours show that."""


@dataclass(frozen=True, slots=True)
class Disc:
    """A circle that faces the viewer."""

    centre: Vector
    radius: float
    """[m]"""
    look: str


@dataclass(frozen=True, slots=True)
class Arrow:
    """An arrow from one point to another."""

    start: Vector
    end: Vector
    look: str


@dataclass(frozen=True, slots=True)
class Label:
    """Words at a point."""

    at: Vector
    words: str
    more: str = ""
    """A second line, where there is room for it."""
    anchor: str = "middle"
    """The end of the words that is at the point: start, middle or end."""
    rises: int = 0
    """1: lines stand above the point; -1: they hang below it."""
    look: str = "words"
    """Or "number", of words within a disc."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Turning:
    """Lines on a turning body: at the angle q each goes from ``ends[0] + cosine[0] cos(q) + sine[0] sin(q)`` to the same of [1].

    They are seen where they turn; a figure, which stands still, leaves them out.
    """

    ends: tuple[Vector, Vector]
    cosine: tuple[Vector, Vector]
    sine: tuple[Vector, Vector]
    rate: float
    """Of the angle q. [rad/s]"""
    count: int
    """Lines at equal angles."""
    look: str = "mark"
    face: tuple[float, float] | None = None
    """Only where ``face[0] cos(q) + face[1] sin(q) > 0`` a line is seen; None: everywhere."""


Stroke = Line | Disc | Arrow | Label | Turning


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """A machine at one steady point."""

    title: str
    strokes: tuple[Stroke, ...]
    keys: tuple[tuple[str, str], ...] = ()
    """Looks, with what they stand for; look "" for words alone."""
    rows: tuple[tuple[str, str], ...] = ()
    """Labels of quantities, and their values in words."""
    notes: tuple[str, ...] = ()
    """What is not to scale, or assumed."""
    heading: str = ""
    """What a figure says above."""
    axes: tuple[str, str] | None = None
    """Names of the axes along which it is drawn; None of what is seen in space."""
    lever: float = 0.0
    """Radius over which links of legs on a cylinder beside it turn its parts; 0 without such a cylinder. [m]"""


class View:
    """Points in space as a viewer far away sees them: to the right and up; z is up."""

    def __init__(self, azimuth: float, elevation: float) -> None:
        """Take the direction from which the viewer looks, from x towards y and above the plane. [degrees]"""
        around, above = math.radians(azimuth), math.radians(elevation)
        self.viewer = np.array(
            [math.cos(above) * math.cos(around), math.cos(above) * math.sin(around), math.sin(above)]
        )
        self._right = np.array([-math.sin(around), math.cos(around), 0.0])
        self._up = np.cross(self.viewer, self._right)

    def __call__(self, points: Any) -> np.ndarray:
        """Places (..., 2) of points (..., 3)."""
        points = np.asarray(points, dtype=float)
        return np.stack([points @ self._right, points @ self._up], axis=-1)

    def toward(self, vector: Any) -> float:
        """How far a vector points to the viewer."""
        return float(np.asarray(vector, dtype=float) @ self.viewer)


def hull(points: Any) -> np.ndarray:
    """Corners of the convex hull of points in the plane, in order."""
    from scipy.spatial import ConvexHull

    points = np.asarray(points, dtype=float)
    return points[ConvexHull(points).vertices]


def off(point: Vector, right: float, up: float) -> np.ndarray:
    """The point to the right of another and above it."""
    return np.asarray(point, dtype=float) + np.array([right, up])


def rim(centre: Any, radius: float, first: Any, second: Any) -> np.ndarray:
    """A circle about a point in space or in the plane, in the plane of two unit vectors. (m, d)"""
    return np.asarray(centre) + radius * CIRCLE @ np.stack([first, second])


def round_number(wanted: float) -> float:
    """The largest of 1, 2 or 5 times a power of ten that is not above a number > 0."""
    power = 10.0 ** math.floor(math.log10(wanted))
    return max(step * power for step in (1.0, 2.0, 5.0) if step * power <= wanted * (1.0 + 1e-9))


def quantity(value: Any, unit: str, digits: int = 3) -> str:
    """A value with its unit, "–" where it is undefined."""
    found = float(value)
    if not math.isfinite(found):
        return "–"
    return f"{plain(found, digits)}{'' if unit in ('', '°') else ' '}{unit}"


def length_words(vector: Any, unit: str) -> str:
    """The length of a vector in words."""
    return quantity(np.linalg.norm(np.asarray(vector, dtype=float)), unit)


def share_of_slip(force: Any, demand: float) -> tuple[str, str]:
    """Words for a force (d,) of a wheel, and for its share of the slip limit."""
    return length_words(force, "N"), f"{100.0 * demand:.0f} % of slip limit"


def slip_rows(names: Iterable[str], forces: Any, demands: Any) -> Iterator[tuple[str, str]]:
    """Yield the force (d,) of each wheel and its share of the slip limit."""
    for name, force, demand in zip(names, forces, demands, strict=True):
        yield name, f"{length_words(force, 'N')}, {quantity(100.0 * demand, '%', 2)} of its slip limit"


def part_rows(point: Any) -> Iterator[tuple[str, str]]:
    """Yield each part of a `infinivar.machines.machine.TaskPoint` with its force, and steering angle if it has one."""
    for name, force, steering in zip(point.parts, point.part_forces, point.steering, strict=True):
        angle = "" if math.isnan(steering) else f", steered {quantity(math.degrees(steering), '°')}"
        yield name, f"{quantity(force, point.part_units[0])}{angle}"


def tyre(spot: Any, half: Any, rate: float | None = None, look: str = "wheel") -> Iterator[Stroke]:
    """A wheel from above, with half its length (2,) along its heading; with treads that roll at a rate. [rad/s]"""
    half, width = np.asarray(half), 0.3 * np.array([-half[1], half[0]])
    yield Line(spot + _CORNERS @ np.stack([half, width]), look, closed=True)
    if rate is not None:
        nothing = np.zeros(2)
        ends, over = (spot - width, spot + width), (half, half)
        yield Turning(
            ends=ends, cosine=(nothing, nothing), sine=over, rate=rate, count=8, look="tread", face=(1.0, 0.0)
        )


def bounds(strokes: Iterable[Stroke]) -> tuple[np.ndarray, np.ndarray]:
    """Least and largest places of what a drawing must have room for. (2,) each [m]"""
    points = np.concatenate([np.reshape(one, (-1, 2)) for stroke in strokes for one in _extent(stroke)])
    return points.min(axis=0), points.max(axis=0)


def _extent(stroke: Stroke) -> list[Any]:
    """Points that a frame must contain; marks lie within what they are on."""
    match stroke:
        case Line():
            return [stroke.points] if stroke.framed else []
        case Disc():
            return [np.asarray(stroke.centre) + sign * stroke.radius for sign in (-1.0, 1.0)]
        case Arrow():
            return [stroke.start, stroke.end]
        case Label():
            return [stroke.at]
    return []
