"""Shapes of a drawing in millimetres: what a page paints, what of it turns, and what slides along.

A scene has items in the order in which they are painted, with y upwards. Items that belong to a slide move along with it; marks
lie on what turns, at angles that grow at a rate. All rates are true; the page divides them by one factor, which it states.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from infinivar.machines.pictures.strokes import Arrow, Disc, Label, Line, Picture, Stroke, bounds

Vector = Sequence[float] | np.ndarray
Item = dict[str, Any]

MM = 1e3
_FASTEST_TURN = 9.0
"""Rate at which the fastest shape of a drawing turns at most, as painted. [rad/s]"""

_SHORTEST_PASS = 2.5
"""Shortest time in which a slide passes its whole range, as painted. [s]"""


def poly(points: Iterable[Vector], look: str, *, closed: bool = True, slide: str | None = None) -> Item:
    """A polygon or line through points."""
    return _item("poly", look, slide, points=[xy(point) for point in points], closed=closed)


def circle(centre: Vector, radius: float, look: str, *, slide: str | None = None) -> Item:
    """A circle."""
    return _item("circle", look, slide, centre=xy(centre), radius=_round(radius))


def box(low: Vector, high: Vector, look: str, *, slide: str | None = None) -> Item:
    """A rectangle along the axes."""
    (left, bottom), (right, top) = low, high
    return poly([(left, bottom), (right, bottom), (right, top), (left, top)], look, slide=slide)


def text(at: Vector, words: str, look: str = "words", *, anchor: str = "middle", slide: str | None = None) -> Item:
    """A line of text at a point: anchor start, middle or end."""
    return _item("text", look, slide, at=xy(at), text=words, anchor=anchor)


def arrow(start: Vector, end: Vector, look: str, words: str = "", *, slide: str | None = None) -> Item:
    """An arrow with words beside its head."""
    return _item("arrow", look, slide, start=xy(start), end=xy(end), text=words)


def marks(
    ends: tuple[Vector, Vector],
    cosine: tuple[Vector, Vector],
    sine: tuple[Vector, Vector],
    rate: float,
    *,
    count: int,
    look: str = "mark",
    face: tuple[float, float] | None = None,
    slide: str | None = None,
) -> Item:
    """Lines on a turning body: at the angle q each goes from ``ends[0] + cosine[0] cos(q) + sine[0] sin(q)`` to the same of [1].

    Parameters
    ----------
    ends, cosine, sine : pairs of points   [mm]
    rate : float     Rate of the angle q. [rad/s]
    count : int      Lines at equal angles.
    look, slide      As of all items.
    face             Only where ``face[0] cos(q) + face[1] sin(q) > 0`` a line is seen; None: everywhere.
    """
    return _item(
        "marks",
        look,
        slide,
        ends=[xy(one) for one in ends],
        cosine=[xy(one) for one in cosine],
        sine=[xy(one) for one in sine],
        rate=_finite(rate),
        count=count,
        face=None if face is None else [float(one) for one in face],
    )


def spokes(
    centre: Vector, radius: float, rate: float, *, clockwise: bool = False, count: int = 6, slide: str | None = None
) -> Item:
    """Spokes of a wheel seen along its axle, from 0.35 of the radius to the rim."""
    across = -radius if clockwise else radius
    inner = 0.35
    return marks(
        (centre, centre),
        ((0.0, inner * radius), (0.0, radius)),
        ((-inner * across, 0.0), (-across, 0.0)),
        rate,
        count=count,
        slide=slide,
    )


def slide(direction: Vector, rate: float, span: float, *, wraps: bool = False) -> dict[str, Any]:
    """What moves along a line at a rate [mm/s], within half a span to either side; `wraps` for a pattern of that pitch."""
    return {"direction": xy(direction), "rate": _finite(rate), "span": _round(span), "wraps": wraps}


def key(look: str, words: str) -> dict[str, str]:
    """What arrows of a look stand for, to be written beside the drawing; look "" for words without an arrow."""
    return {"look": look, "text": words}


def scene(
    title: str,
    items: Iterable[Item],
    *,
    note: str = "",
    margin: float = 0.04,
    keys: Iterable[dict[str, str]] = (),
    around: tuple[np.ndarray, np.ndarray] | None = None,
) -> dict[str, Any]:
    """Items with their frame around them, or around corners [m], and the key of their arrows."""
    items = list(items)
    if around is None:
        points = np.array([point for item in items for point in _extent(item)])
        low, high = points.min(axis=0), points.max(axis=0)
    else:
        low, high = (MM * one for one in around)
    pad = margin * float(np.max(high - low))
    frame = [*(low - pad), *(high + pad)]
    return {"title": title, "note": note, "frame": [_round(one) for one in frame], "items": items, "keys": list(keys)}


def slow_down(scenes: Iterable[dict[str, Any]], slides: Iterable[dict[str, Any]]) -> float:
    """The factor of 1, 2 or 5 times a power of ten by which a page slows all motion down, 1 at least."""
    turns = [abs(item["rate"]) for one in scenes for item in one["items"] if item["kind"] == "marks"]
    passes = [abs(one["rate"]) / one["span"] for one in slides if one["span"] > 0 and not one["wraps"]]
    required = max([rate / _FASTEST_TURN for rate in turns] + [rate * _SHORTEST_PASS for rate in passes] + [1.0])
    power = 10.0 ** math.floor(math.log10(required))
    return next(step * power for step in (1.0, 2.0, 5.0, 10.0) if step * power >= required * (1.0 - 1e-9))


def painted(picture: Picture) -> dict[str, Any]:
    """A picture of a machine as a scene, with room for what must be seen."""
    keys = (key(look, words) for look, words in picture.keys if look in _ARROWS)
    return scene(picture.title, map(_painted, picture.strokes), keys=keys, around=bounds(picture.strokes))


_ARROWS = frozenset({"force", "load-force", "contact-force", "velocity"})


def _painted(stroke: Stroke) -> Item:
    """A stroke in millimetres."""
    match stroke:
        case Line():
            return poly(MM * np.asarray(stroke.points), stroke.look, closed=stroke.closed)
        case Disc():
            return circle(MM * np.asarray(stroke.centre), MM * stroke.radius, stroke.look)
        case Arrow():
            return arrow(MM * np.asarray(stroke.start), MM * np.asarray(stroke.end), stroke.look)
        case Label():
            return text(MM * np.asarray(stroke.at), stroke.words, anchor=stroke.anchor)
    ends, cosine, sine = (
        tuple(MM * np.asarray(one) for one in pair) for pair in (stroke.ends, stroke.cosine, stroke.sine)
    )
    return marks(ends, cosine, sine, stroke.rate, count=stroke.count, look=stroke.look, face=stroke.face)  # type: ignore[arg-type]


def xy(point: Vector) -> list[float]:
    """A point or vector of the plane, rounded to 0.1 micrometre."""
    return [_round(point[0]), _round(point[1])]


def _round(value: float) -> float:
    return round(float(value), 4)


def _finite(value: float) -> float:
    """A rate; what has none, because nothing is known of its motion, stands still."""
    return float(value) if math.isfinite(value) else 0.0


def _item(kind: str, look: str, moves: str | None, **values: Any) -> Item:
    return {"kind": kind, "look": look, **values, **({"slide": moves} if moves else {})}


def _extent(item: Item) -> list[list[float]]:
    """Points that a frame must contain; marks lie within what they are on."""
    match item["kind"]:
        case "poly":
            return item["points"]
        case "circle":
            (x, y), r = item["centre"], item["radius"]
            return [[x - r, y - r], [x + r, y + r]]
        case "text":
            return [item["at"]]
        case "arrow":
            return [item["start"], item["end"]]
    return []
