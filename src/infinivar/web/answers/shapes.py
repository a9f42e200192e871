"""Shapes of a drawing in millimetres: what a page paints, what of it turns, and what slides along.

A scene has items in the order in which they are painted, with y upwards. Items that belong to a slide move along with it; marks
lie on what turns, at angles that grow at a rate. All rates are true; the page divides them by one factor, which it states.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

import numpy as np

from infinivar.machines.pictures.strokes import Arrow, Disc, Label, Line, Picture, Stroke, Turning, bounds

Item = dict[str, Any]

MM = 1e3
_FASTEST_TURN = 9.0
"""Rate at which the fastest shape of a drawing turns at most, as painted. [rad/s]"""

_SHORTEST_PASS = 2.5
"""Shortest time in which a slide passes its whole range, as painted. [s]"""

_ARROWS = frozenset({"force", "load-force", "contact-force", "velocity", "gravity"})
"""Looks that a page lists with what they stand for."""


class Sliding(NamedTuple):
    """A stroke that moves along with a slide."""

    stroke: Stroke
    slide: str


Shape = Stroke | Sliding


def sliding(strokes: Iterable[Stroke], slide: str) -> Iterator[Sliding]:
    """Yield strokes that move along with a slide."""
    return (Sliding(one, slide) for one in strokes)


def box(low: Any, high: Any, look: str, slide: str = "") -> Shape:
    """A rectangle along the axes, perhaps on a slide."""
    (left, bottom), (right, top) = low, high
    drawn = Line([(left, bottom), (right, bottom), (right, top), (left, top)], look, closed=True)
    return Sliding(drawn, slide) if slide else drawn


def spokes(centre: Any, radius: float, rate: float, *, clockwise: bool = False, count: int = 6) -> Turning:
    """Spokes of a wheel seen along its axle, from 0.35 of the radius to the rim."""
    across, inner = -radius if clockwise else radius, 0.35
    cosine, sine = ((0.0, inner * radius), (0.0, radius)), ((-inner * across, 0.0), (-across, 0.0))
    return Turning(ends=(centre, centre), cosine=cosine, sine=sine, rate=rate, count=count)


def slide(direction: Any, rate: float, span: float, *, wraps: bool = False) -> dict[str, Any]:
    """What moves along a line at a rate [mm/s], within half a span to either side; `wraps` for a pattern of that pitch."""
    return {"direction": xy(direction), "rate": _finite(rate), "span": _round(span), "wraps": wraps}


def key(look: str, words: str) -> dict[str, str]:
    """What arrows of a look stand for, to be written beside the drawing; look "" for words without an arrow."""
    return {"look": look, "text": words}


def painted(picture: Picture) -> dict[str, Any]:
    """A picture of a machine as a scene."""
    keys = (key(look, words) for look, words in picture.keys if look in _ARROWS)
    return scene(picture.title, picture.strokes, keys=keys, scale=MM)


def scene(
    title: str,
    shapes: Iterable[Shape],
    *,
    note: str = "",
    keys: Iterable[dict[str, str]] = (),
    scale: float = 1.0,
) -> dict[str, Any]:
    """Shapes in millimetres, or in units with as many, with a frame around what must be seen, and the key of their arrows."""
    shapes = list(shapes)
    low, high = frame(shapes)
    pad = 0.04 * float(np.max(high - low))
    corners = [_round(scale * one) for one in (*(low - pad), *(high + pad))]
    items = [_item(one, scale) for one in shapes]
    return {"title": title, "note": note, "frame": corners, "items": items, "keys": list(keys)}


def frame(shapes: Iterable[Shape]) -> tuple[np.ndarray, np.ndarray]:
    """Corners (2,) around shapes."""
    return bounds(one.stroke if isinstance(one, Sliding) else one for one in shapes)


def slow_down(scenes: Iterable[dict[str, Any]], slides: Iterable[dict[str, Any]]) -> float:
    """The factor of 1, 2 or 5 times a power of ten by which a page slows all motion down, 1 at least."""
    turns = [abs(item["rate"]) for one in scenes for item in one["items"] if item["kind"] == "marks"]
    passes = [abs(one["rate"]) / one["span"] for one in slides if one["span"] > 0 and not one["wraps"]]
    required = max([rate / _FASTEST_TURN for rate in turns] + [rate * _SHORTEST_PASS for rate in passes] + [1.0])
    power = 10.0 ** math.floor(math.log10(required))
    return next(step * power for step in (1.0, 2.0, 5.0, 10.0) if step * power >= required * (1.0 - 1e-9))


def _item(shape: Shape, scale: float) -> Item:
    """A shape as a page paints it."""
    if isinstance(shape, Sliding):
        return {**_item(shape.stroke, scale), "slide": shape.slide}

    def xys(points: Any) -> list[list[float]]:
        return [xy(scale * np.asarray(point, dtype=float)) for point in points]

    own: Item
    match shape:
        case Line():
            own = {"kind": "poly", "points": xys(shape.points), "closed": shape.closed}
        case Disc():
            own = {"kind": "circle", "centre": xys([shape.centre])[0], "radius": _round(scale * shape.radius)}
        case Arrow():
            own = {"kind": "arrow", "start": xys([shape.start])[0], "end": xys([shape.end])[0]}
        case Label():
            own = {"kind": "text", "at": xys([shape.at])[0], "text": shape.words, "anchor": shape.anchor}
        case Turning():
            lines = {"ends": xys(shape.ends), "cosine": xys(shape.cosine), "sine": xys(shape.sine)}
            face = None if shape.face is None else [float(one) for one in shape.face]
            own = {"kind": "marks", **lines, "rate": _finite(shape.rate), "count": shape.count, "face": face}
    return {**own, "look": shape.look}


def xy(point: Any) -> list[float]:
    """A point or vector of the plane, rounded to 0.1 micrometre."""
    return [_round(point[0]), _round(point[1])]


def _round(value: float) -> float:
    return round(float(value), 4)


def _finite(value: float) -> float:
    """A rate; what has none, because nothing is known of its motion, stands still."""
    return float(value) if math.isfinite(value) else 0.0
