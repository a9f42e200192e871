"""Machines as a page draws them: their pictures, and the wheels of legs beside them in a row; and a wheel on its cylinder."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.errors import InputError
from infinivar.machines.pictures.geometry import off
from infinivar.machines.pictures.strokes import Label, Line, Stroke, Turning, tyre
from infinivar.transmission.operating_point import OperatingPoint
from infinivar.transmission.rotary_linear import RotaryLinearIVT
from infinivar.web.answers import contact, shapes, words
from infinivar.web.answers.places import Place
from infinivar.web.answers.shapes import Shape

MM = 1e3


def drawn(place: Place) -> Any:
    """Scenes, slides, state and notes of a machine; see `drawing.drawing`.

    Raises
    ------
    InputError
        If nothing can be drawn, as a wheel slips or the pose is out of reach.
    """
    point = place.point()
    picture = place.drive.picture(point, *(np.asarray(one) for one in (place.pose, place.twist, place.wrench)))
    if picture is None:
        raise InputError(f"{place.title} is of a type that has no drawing")
    scenes, notes = [shapes.painted(picture)], list(picture.notes)
    leg = getattr(place.drive, "leg", None)
    if picture.lever and leg is not None:
        scenes.append(_row_of_wheels(leg, point, picture.lever))
        notes.append("the places of the wheels along the common cylinder are not to scale; their sizes and angles are")
    return scenes, {}, [words.row(*one) for one in picture.rows], notes


def _row_of_wheels(leg: CoboticDrive, point: Any, lever: float) -> dict[str, Any]:
    """The wheels of all legs in a row on the common cylinder, from above; their links move parts over a lever. [m]"""
    element, count = leg.transmission, len(point.parts)
    apart = 1.8 * MM * element.cylinder_radius
    length = apart * (count + 0.4)
    items = [*cylinder_from_above(element, leg.cylinder_speed, length)]
    for index, name in enumerate(point.parts):
        found = contact.element_point(
            leg, float(point.part_speeds[index]) * lever, float(point.part_forces[index]) / lever
        )
        if not math.isfinite(float(found.link_speed)):
            raise InputError(f"the steered wheel of {name} slips here")
        at = apart * (index - 0.5 * (count - 1))
        items += wheel_from_above(element, found, at, str(index + 1))
    part = point.parts[0].rsplit(" ", 1)[0]
    return shapes.scene(f"Common cylinder with the steered wheel that moves each {part}", items)


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
