"""Machines as a page draws them: their pictures, and the wheels of legs beside them in a row."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.errors import InputError
from infinivar.web.answers import contact, drawing_wheels, shapes, words
from infinivar.web.answers.places import Place

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
    items = [*drawing_wheels.cylinder_from_above(element, leg.cylinder_speed, length)]
    for index, name in enumerate(point.parts):
        found = contact.element_point(
            leg, float(point.part_speeds[index]) * lever, float(point.part_forces[index]) / lever
        )
        if not math.isfinite(float(found.link_speed)):
            raise InputError(f"the steered wheel of {name} slips here")
        at = apart * (index - 0.5 * (count - 1))
        items += drawing_wheels.wheel_from_above(element, found, at, str(index + 1))
    part = point.parts[0].rsplit(" ", 1)[0]
    return shapes.scene(f"Common cylinder with the steered wheel that moves each {part}", items)
