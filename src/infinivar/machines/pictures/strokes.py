"""Strokes of which a picture of a machine is made: lines, areas, arrows and words in metres, in the plane of the viewer.

A kind of machine gives a `Picture`. Painters turn it into a figure (`infinivar.figures.pictures`) and a scene of a page
(`infinivar.web.answers.shapes`), in the order of its strokes. The *look* of a stroke names what it shows, such as "wheel"; each
painter has colours and line widths for it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

_CORNERS = np.array([(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)])


@dataclass(frozen=True, slots=True)
class Line:
    """A line through points, or the area within them.

    Attributes
    ----------
    points : (n, 2) float   [m]
    look : str
    closed : bool           An area.
    framed : bool           Whether a drawing must have room for all of it.
    share : float or None   Of its limit, from -1 to 1, where colours show that.
    """

    points: Any
    look: str
    closed: bool = False
    framed: bool = True
    share: float | None = None


@dataclass(frozen=True, slots=True)
class Disc:
    """A circle that faces the viewer, of a radius [m] about a centre (2,) [m]."""

    centre: Any
    radius: float
    look: str


@dataclass(frozen=True, slots=True)
class Arrow:
    """An arrow from one point (2,) to another. [m]"""

    start: Any
    end: Any
    look: str


@dataclass(frozen=True, slots=True)
class Label:
    """Words at a point.

    Attributes
    ----------
    at : (2,) float   [m]
    words : str
    more : str        A second line, where there is room for it.
    anchor : str      The end of the words that is at the point: start, middle or end.
    rises : int       1: lines stand above the point; -1: they hang below it.
    look : str        "words", or "number" of words within a disc.
    """

    at: Any
    words: str
    more: str = ""
    anchor: str = "middle"
    rises: int = 0
    look: str = "words"


@dataclass(frozen=True, slots=True, kw_only=True)
class Turning:
    """Lines on a turning body: at the angle q each goes from ``ends[0] + cosine[0] cos(q) + sine[0] sin(q)`` to the same of [1].

    They are seen where they turn; a figure, which stands still, leaves them out.

    Attributes
    ----------
    ends, cosine, sine : pairs of points   [m]
    rate : float                           Of the angle q. [rad/s]
    count : int                            Lines at equal angles.
    look : str
    face : pair or None                    Only where ``face[0] cos(q) + face[1] sin(q) > 0`` a line is seen; None: everywhere.
    """

    ends: tuple[Any, ...]
    cosine: tuple[Any, ...]
    sine: tuple[Any, ...]
    rate: float
    count: int
    look: str = "mark"
    face: tuple[float, float] | None = None


Stroke = Line | Disc | Arrow | Label | Turning


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """A machine at one steady point.

    Attributes
    ----------
    title : str
    strokes : tuple of Stroke
    keys : tuple of pairs          Looks, with what they stand for.
    rows : tuple of pairs          Labels of quantities, and their values in words.
    notes : tuple of str           What is not to scale, or assumed.
    heading : str                  What a figure says above.
    axes : pair of str, or None    Names of the axes along which it is drawn; None of what is seen in space.
    lever : float                  Radius over which links of legs on a cylinder beside it turn its parts; 0 without such a
        cylinder. [m]
    """

    title: str
    strokes: tuple[Stroke, ...]
    keys: tuple[tuple[str, str], ...] = ()
    rows: tuple[tuple[str, str], ...] = ()
    notes: tuple[str, ...] = ()
    heading: str = ""
    axes: tuple[str, str] | None = None
    lever: float = 0.0


def tyre(spot: Any, half: Any, rate: float | None = None, look: str = "wheel") -> Iterator[Stroke]:
    """A wheel from above, with half its length (2,) along its heading; with treads that roll at a rate. [rad/s]"""
    half, width = np.asarray(half), 0.3 * np.array([-half[1], half[0]])
    yield Line(spot + _CORNERS @ np.stack([half, width]), look, closed=True)
    if rate is not None:
        yield treads((spot - width, spot + width), (np.zeros(2),) * 2, (half, half), rate, face=(1.0, 0.0))


def treads(ends: Any, cosine: Any, sine: Any, rate: float, count: int = 8, face: Any = None) -> Turning:
    """Treads of a wheel; arguments as of `Turning`."""
    return Turning(ends=ends, cosine=cosine, sine=sine, rate=rate, count=count, look="tread", face=face)


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
