"""A steered wheel on its cylinder from above, to scale: shared by drives of one axis and by machines of many legs."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from infinivar.machines.pictures.geometry import off
from infinivar.transmission.operating_point import OperatingPoint
from infinivar.transmission.rotary_linear import RotaryLinearIVT
from infinivar.web.answers import shapes, words
from infinivar.web.answers.shapes import Item

MM = 1e3


def cylinder_from_above(element: RotaryLinearIVT, speed: float, length: float) -> Iterator[Item]:
    """The cylinder along x from above; at a positive speed its top moves upwards in the drawing, to positive y."""
    radius, half = MM * element.cylinder_radius, 0.5 * length
    yield shapes.box((-half, -radius), (half, radius), "steel")
    yield shapes.marks(
        ((-half, 0.0), (half, 0.0)),
        ((0.0, 0.0), (0.0, 0.0)),
        ((0.0, radius), (0.0, radius)),
        speed,
        count=10,
        face=(1.0, 0.0),
    )
    yield shapes.poly([(-1.04 * half, 0.0), (1.04 * half, 0.0)], "axis", closed=False)


def wheel_from_above(
    element: RotaryLinearIVT, point: OperatingPoint, at: float, *, slide: str | None = None, label: str = ""
) -> Iterator[Item]:
    """A steered wheel on top of the cylinder, with its heading and steering angle; a label stands above the cylinder."""
    angle = float(np.arctan(point.steering_tangent))
    radius, width = MM * element.wheel_radius, 0.28 * MM * element.wheel_radius
    heading = np.array([math.sin(angle), math.cos(angle)])
    axle = np.array([math.cos(angle), -math.sin(angle)])
    middle = np.array([at, 0.0])
    reach = 1.9 * radius
    yield shapes.poly([off(middle, 0.0, -0.6 * reach), off(middle, 0.0, reach)], "angle", closed=False, slide=slide)
    yield shapes.poly([middle - 0.6 * reach * heading, middle + reach * heading], "heading", closed=False, slide=slide)
    corners = [middle + along * radius * heading + across * width * axle for along, across in _CORNERS]
    yield shapes.poly(corners, "wheel", slide=slide)
    rate = float(point.rolling_speed) / element.wheel_radius
    yield shapes.marks(
        (middle - width * axle, middle + width * axle),
        ((0.0, 0.0), (0.0, 0.0)),
        (radius * heading, radius * heading),
        rate,
        count=8,
        look="tread",
        face=(1.0, 0.0),
        slide=slide,
    )
    side = 1.0 if angle >= 0 else -1.0
    sweep = [
        middle + 0.82 * reach * np.array([math.sin(part * angle), math.cos(part * angle)])
        for part in np.linspace(0, 1, 13)
    ]
    yield shapes.poly(sweep, "angle", closed=False, slide=slide)
    words_of = f"φ = {words.quantity(math.degrees(angle), '°')}"
    if label:
        high = 1.12 * MM * element.cylinder_radius
        yield shapes.text((at, high), f"{label}: {words_of}", slide=slide)
        return
    place = off(middle, side * 0.12 * reach, 1.02 * reach)
    yield shapes.text(place, words_of, anchor="start" if side > 0 else "end", slide=slide)


_CORNERS = ((1, 1), (1, -1), (-1, -1), (-1, 1))
"""Of a wheel from above, along its heading and its axle."""
