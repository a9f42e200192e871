"""A steered wheel on its cylinder from above, to scale: shared by drives of one axis and by machines of many legs."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from infinivar.machines.pictures.geometry import off
from infinivar.machines.pictures.strokes import Label, Line, Stroke, Turning, tyre
from infinivar.transmission.operating_point import OperatingPoint
from infinivar.transmission.rotary_linear import RotaryLinearIVT
from infinivar.web.answers import shapes, words
from infinivar.web.answers.shapes import Shape

MM = 1e3


def cylinder_from_above(element: RotaryLinearIVT, speed: float, length: float) -> Iterator[Shape]:
    """The cylinder along x from above; at a positive speed its top moves upwards in the drawing, to positive y. [mm]"""
    radius, half = MM * element.cylinder_radius, 0.5 * length
    nothing, over = ((0.0, 0.0), (0.0, 0.0)), ((0.0, radius), (0.0, radius))
    ends = ((-half, 0.0), (half, 0.0))
    yield shapes.box((-half, -radius), (half, radius), "steel")
    yield Turning(ends=ends, cosine=nothing, sine=over, rate=speed, count=10, face=(1.0, 0.0))
    yield Line([(-1.04 * half, 0.0), (1.04 * half, 0.0)], "axis")


def wheel_from_above(element: RotaryLinearIVT, point: OperatingPoint, at: float, label: str = "") -> Iterator[Stroke]:
    """A steered wheel on top of the cylinder, with its heading and steering angle; a label stands above the cylinder. [mm]"""
    angle = float(np.arctan(point.steering_tangent))
    radius, middle = MM * element.wheel_radius, np.array([at, 0.0])
    reach, heading = 1.9 * radius, np.array([math.sin(angle), math.cos(angle)])
    yield Line([off(middle, 0.0, -0.6 * reach), off(middle, 0.0, reach)], "angle")
    yield Line([middle - 0.6 * reach * heading, middle + reach * heading], "heading")
    yield from tyre(middle, radius * heading, float(point.rolling_speed) / element.wheel_radius)
    swept = np.linspace(0.0, angle, 13)
    yield Line(middle + 0.82 * reach * np.stack([np.sin(swept), np.cos(swept)], axis=-1), "angle")
    words_of = f"φ = {words.quantity(math.degrees(angle), '°')}"
    if label:
        yield Label((at, 1.12 * MM * element.cylinder_radius), f"{label}: {words_of}")
        return
    side = 1.0 if angle >= 0 else -1.0
    yield Label(off(middle, side * 0.12 * reach, 1.02 * reach), words_of, anchor="start" if side > 0 else "end")
