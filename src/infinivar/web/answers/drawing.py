"""The machine of a drive drawn from its geometry at one place: what turns, what is steered and what moves, in millimetres."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import axis_of, is_machine
from infinivar.errors import InputError
from infinivar.machines.pictures.geometry import CIRCLE, hull, off, rim, round_number
from infinivar.machines.pictures.strokes import Arrow, Disc, Label, Line, treads
from infinivar.parts.belt import Belt, Rack
from infinivar.parts.linkage import Linkage
from infinivar.parts.motor import Motor
from infinivar.parts.screw import Screw
from infinivar.parts.stage import OutputStage, Shaft
from infinivar.study.study import Study
from infinivar.transmission.geometry import PressedContact
from infinivar.transmission.operating_point import OperatingPoint
from infinivar.transmission.rotary_linear import RotaryLinearIVT
from infinivar.web.answers import drawing_machines, shapes, words
from infinivar.web.answers.contact import element_point
from infinivar.web.answers.places import Place, place_of
from infinivar.web.answers.shapes import Shape

MM = 1e3
_TRAVEL = 0.15
"""Travel drawn where the study states none. [m]"""

Slides = dict[str, dict[str, Any]]


def drawing(study: Study, request: Mapping[str, Any]) -> dict[str, Any]:
    """Scenes of a drive or machine at a place, as a page paints them.

    Parameters
    ----------
    study : Study
    request : mapping   As in `places.place_of`.

    Returns
    -------
    dict
        drive, title, place; reason: why there is nothing to draw, else None; scenes and slides, as `shapes` has them; slow:
        factor by which motion is slowed down; state: rows of label and text; notes: what is not to scale or assumed;
        description: the drawing in words.

    Raises
    ------
    InputError
        If a name is unknown.
    """
    place = place_of(study, request)
    head = {"drive": place.name, "title": place.title, "place": place.words, "task": place.task, "reason": None}
    try:
        scenes, slides, state, notes = _drawn(place, study.travel)
    except InputError as problem:  # a machine beyond its reach, or with a wheel that slips
        return {**head, "reason": str(problem), "scenes": [], "slides": {}, "slow": 1.0, "state": [], "notes": []}
    return {
        **head,
        "scenes": scenes,
        "slides": slides,
        "slow": shapes.slow_down(scenes, slides.values()),
        "state": state,
        "notes": notes,
        "description": f"{place.title} at {place.words}. "
        + "; ".join(f"{row['label']} {row['text']}" for row in state),
    }


Drawn = tuple[list[dict[str, Any]], Slides, list[dict[str, str]], list[str]]


def _drawn(place: Place, travel: float | None) -> Drawn:
    drive = place.drive
    if is_machine(drive):
        return drawing_machines.drawn(place)
    speed, force = (place.twist[0], place.wrench[0]) if place.in_task else (place.speed, place.force)  # type: ignore[index]
    if isinstance(drive, CoboticDrive):
        return _cobotic(drive, float(speed), float(force), travel)
    if isinstance(drive, ConventionalDrive):
        return _geared(drive, float(speed), float(force), travel)
    raise InputError(f"{place.title} is of a type that has no drawing")


def _range(drive: Any, travel: float | None) -> tuple[float, list[str]]:
    """Travel along a line to draw, and what to say of it. [mm]"""
    if travel is not None and not axis_of(drive).rotary:
        return MM * travel, []
    return MM * _TRAVEL, [f"the travel of {MM * _TRAVEL:.0f} mm is assumed for the drawing"]


# ---- cobotic drive


def _cobotic(drive: CoboticDrive, speed: float, force: float, travel: float | None) -> Drawn:
    element = drive.transmission
    point = element_point(drive, speed, force)
    angle = float(np.arctan(point.steering_tangent))
    if not (math.isfinite(angle) and math.isfinite(float(point.link_speed))):
        raise InputError("the wheel slips here: there is no steering angle at which the link moves as requested")
    span, notes = _range(drive, travel)
    moving = float(point.link_speed)
    slides = {"link": shapes.slide((1.0, 0.0), MM * moving, span)}
    above = [
        *drawing_machines.cylinder_from_above(element, drive.cylinder_speed, span + 2.0 * MM * element.cylinder_radius)
    ]
    above += shapes.sliding(drawing_machines.wheel_from_above(element, point, 0.0), "link")
    above += _link(element, span, moving, force)
    scenes = [shapes.scene("Seen from above, the wheel on top", above)]
    scenes.append(shapes.scene("Seen along the cylinder", _end_view(element, drive.cylinder_speed, point)))
    if element.geometry is not None:
        pressed = element.geometry.press(
            wheel_radius=element.wheel_radius,
            cylinder_radius=element.cylinder_radius,
            preload=element.preload,
            steering_angle=angle,
        )
        scenes.append(_patch_scene(pressed, angle, element))
    else:
        notes.append("the contact patch has no known size: the wheel is stated by measured values")
    scenes += [] if drive.output.linkage is None else [_linkage_scene(drive.output.linkage)]
    notes.append("the width of the wheel, the carriage and the length of the cylinder are not to scale")
    rolled = abs(float(point.rolling_speed)) / element.wheel_radius
    state = [
        *words.steering(math.tan(angle)),
        words.row("cylinder", words.quantity(30.0 / math.pi * drive.cylinder_speed, "rpm")),
        words.row("surface of the cylinder", words.quantity(element.cylinder_radius * drive.cylinder_speed, "m/s")),
        words.row("wheel", words.quantity(30.0 / math.pi * rolled, "rpm")),
        words.row("link", words.quantity(moving, "m/s")),
        words.row("cylinder radius", words.quantity(MM * element.cylinder_radius, "mm")),
        words.row("wheel radius", words.quantity(MM * element.wheel_radius, "mm")),
    ]
    return scenes, slides, state, notes


def _link(element: RotaryLinearIVT, span: float, speed: float, force: float) -> Iterator[Shape]:
    """Carriage around the wheel, the link beside the cylinder, and force and speed of the link."""
    radius, wheel = MM * element.cylinder_radius, MM * element.wheel_radius
    beside, half = -1.32 * radius, 1.5 * wheel
    end = 0.5 * span + radius
    yield Line([(-end, beside), (end, beside)], "guide")
    yield shapes.box((-half, -half), (half, half), "carriage", slide="link")
    yield shapes.box((-0.35 * wheel, beside), (0.35 * wheel, -half), "carriage", slide="link")
    yield shapes.box((-1.2 * half, beside - 0.3 * wheel), (1.2 * half, beside + 0.3 * wheel), "carriage", slide="link")
    yield Label((-end, beside - 0.16 * radius), "link on its guideway", anchor="start")
    length = 0.75 * radius
    for value, unit, look, what, low in (
        (force, "N", "force", "force on the load", beside - 0.36 * radius),
        (speed, "m/s", "velocity", "speed of the link", beside - 0.58 * radius),
    ):
        label = f"{what} {words.quantity(value, unit)}"
        if value:
            yield Arrow((0.0, low), (math.copysign(length, value), low), look)
            anchor = "start" if value > 0 else "end"
            yield Label((math.copysign(1.05 * length, value), low), label, anchor=anchor)
        else:
            yield Label((0.0, low), label)


def _end_view(element: RotaryLinearIVT, speed: float, point: OperatingPoint) -> Iterator[Shape]:
    """Cylinder and wheel along the cylinder's axis; at a positive speed the top of the cylinder moves to the right."""
    radius, wheel = MM * element.cylinder_radius, MM * element.wheel_radius
    cosine = float(np.cos(np.arctan(point.steering_tangent)))
    sine = math.sqrt(max(0.0, 1.0 - cosine * cosine))
    hub = (0.0, radius + wheel)
    yield Disc((0.0, 0.0), radius, "steel")
    yield shapes.spokes((0.0, 0.0), radius, speed, clockwise=True, count=10)
    yield Disc((0.0, 0.0), 0.04 * radius, "axis")
    width = 0.28 * wheel * sine
    disc = rim(hub, wheel, (0.0, 1.0), (cosine, 0.0))
    yield Line(hull(np.concatenate([off(disc, -width, 0.0), off(disc, width, 0.0)])), "wheel", closed=True)
    ups, sides = ((0.0, 0.35 * wheel), (0.0, wheel)), ((0.35 * wheel * cosine, 0.0), (wheel * cosine, 0.0))
    yield treads((hub, hub), ups, sides, float(point.rolling_speed) / element.wheel_radius, count=6)
    top = radius + 2.0 * wheel
    preload = f"preload {words.quantity(element.preload, 'N')}"
    yield Arrow((0.0, top + 0.55 * radius), (0.0, top + 0.06 * radius), "preload")
    yield Label((0.1 * radius, top + 0.42 * radius), preload, anchor="start")
    yield Label((0.0, -0.55 * radius), f"R = {words.quantity(radius, 'mm')}")
    yield Label((1.35 * wheel, radius + wheel), f"r = {words.quantity(wheel, 'mm')}", anchor="start")


def _patch_scene(pressed: PressedContact, angle: float, element: RotaryLinearIVT) -> dict[str, Any]:
    """The contact ellipse from above, magnified to half of the cylinder's radius, in axes of the drawing beside it."""
    a, b = MM * float(pressed.patch.a), MM * float(pressed.patch.b)
    radius = MM * element.cylinder_radius
    scale = round_number(0.55 * radius / max(a, b))
    heading = np.array([math.sin(angle), math.cos(angle)])
    lateral = np.array([math.cos(angle), -math.sin(angle)])
    turn = float(pressed.rotation)
    first = math.cos(turn) * heading + math.sin(turn) * lateral
    second = -math.sin(turn) * heading + math.cos(turn) * lateral
    edge = scale * CIRCLE @ np.stack([a * first, b * second])
    reach = 1.5 * scale * max(a, b)
    low = -0.85 * reach
    bar = round_number(1.4 * max(a, b))
    items = [
        Line([(-reach, 0.0), (reach, 0.0)], "axis"),
        Line([-0.9 * reach * heading, 0.9 * reach * heading], "heading"),
        Line(edge, "contact", closed=True),
        Label(0.98 * reach * heading, "rolling"),
        Label((0.78 * reach, 0.06 * reach), "link"),
        Line([(-0.5 * scale * bar, low), (0.5 * scale * bar, low)], "scale"),
        Label((0.0, low - 0.17 * reach), f"{bar:g} mm"),
    ]
    size = f"{words.quantity(2e3 * max(a, b), 'µm')} by {words.quantity(2e3 * min(a, b), 'µm')}"
    return shapes.scene(f"Contact ellipse, magnified {scale:g} times", items, note=size)


# ---- geared drive


def _geared(drive: ConventionalDrive, speed: float, force: float, travel: float | None) -> Drawn:
    stage = drive.stage
    found = drive.operate(speed=speed, force=force)
    own = next(
        (float(found.states[name]) for name in ("drive_speed_m_s", "drive_speed_rad_s") if name in found.states), speed
    )
    own = own if math.isfinite(own) else 0.0
    turning = own / float(stage.travel_per_radian)
    linear = not drive.own_axis.rotary
    span, notes = _range(drive, travel) if linear else (0.0, [])
    slides: Slides = {"load": shapes.slide((1.0, 0.0), MM * own, span)} if linear else {}
    items = list(_stage(stage, drive.motor, turning, MM * own, span, slides))
    items += _load_arrows(items, force, speed, linear=not drive.axis.rotary)
    title = f"Motor, gearhead {words.quantity(drive.gearhead.ratio, '')}:1 and {stage.title}"
    scenes = [shapes.scene(title, items, keys=_load_keys(drive, force, speed))]
    scenes += [] if drive.output.linkage is None else [_linkage_scene(drive.output.linkage)]
    notes.append(
        "motor, gearhead and load are symbols" if drive.motor.diameter is None else "gearhead and load are symbols"
    )
    state = [
        words.row("motor", words.quantity(30.0 / math.pi * found.states["motor_speed_rad_s"], "rpm")),
        words.row(f"{stage.title}", words.quantity(30.0 / math.pi * turning, "rpm")),
        words.row("load", words.quantity(speed, drive.axis.speed_unit)),
        words.row("gearhead", f"{words.quantity(drive.gearhead.ratio, '')}:1"),
        words.row("travel per turn", words.quantity(2e3 * math.pi * float(stage.travel_per_radian), "mm"))
        if linear
        else words.row("output", "shaft"),
    ]
    return scenes, slides, state, notes


def _stage(
    stage: OutputStage, motor: Motor, turning: float, speed: float, span: float, slides: Slides
) -> Iterator[Shape]:
    """The output stage, with the motor behind it or in line with it."""
    if isinstance(stage, Screw):
        yield from _screw(stage, motor, speed, span, slides)
        return
    radius = 30.0 if isinstance(stage, Shaft) else MM * float(stage.travel_per_radian)
    housing = 0.5 * MM * motor.diameter if motor.diameter is not None else 1.5 * radius
    yield Disc((0.0, 0.0), housing, "symbol")
    # The load is on the line that the top of the pulley moves along, to the right of it.
    start = max(radius, housing) + 0.12 * span
    height = max(0.05 * span, 0.6 * radius, 4.0)
    end = start + span + 2.0 * height
    middle = start + height + 0.5 * span
    if isinstance(stage, Shaft):
        yield Disc((0.0, 0.0), radius, "steel")
        yield shapes.spokes((0.0, 0.0), 1.6 * radius, turning, count=1)
        yield shapes.spokes((0.0, 0.0), radius, turning, count=6)
        yield Label((0.0, -1.25 * max(housing, radius)), "shaft and load (symbol)")
        return
    if isinstance(stage, Rack):
        yield from _rack(stage, radius, turning, speed, middle, height, span, slides)
        return
    if isinstance(stage, Belt):
        yield Line([(0.0, -radius), (end, -radius)], "cable")
        yield Disc((end, 0.0), radius, "steel")
        yield shapes.spokes((end, 0.0), radius, turning, clockwise=True)
    yield Line([(0.0, radius), (end, radius)], "cable")
    yield Disc((0.0, 0.0), radius, "steel")
    yield shapes.spokes((0.0, 0.0), radius, turning, clockwise=True)
    yield from _block(middle, radius, height, span)
    what = "belt" if isinstance(stage, Belt) else "pulley"
    yield Label((0.0, -1.25 * max(housing, radius) - 1.0), f"{what}, r = {words.quantity(radius, 'mm')}")


def _block(middle: float, line: float, height: float, span: float) -> Iterator[Shape]:
    """The load on its guideway, hung to a line at a height."""
    low = line - 0.6 * height
    yield Line([(middle - 0.5 * span - height, low), (middle + 0.5 * span + height, low)], "guide")
    yield shapes.box((middle - height, low), (middle + height, low + 1.2 * height), "load", slide="load")


def _rack(
    stage: Rack, radius: float, turning: float, speed: float, middle: float, height: float, span: float, slides: Slides
) -> Iterator[Shape]:
    """Pinion below a rack, which carries the load."""
    pitch = math.pi * MM * stage.module
    yield Disc((0.0, 0.0), radius, "steel")
    yield shapes.spokes((0.0, 0.0), radius, turning, clockwise=True, count=min(int(stage.teeth), 24))
    thick = max(0.5 * radius, 2.0)
    left, right = -0.6 * span - radius, middle + 0.5 * span + height
    slides["teeth"] = shapes.slide((1.0, 0.0), speed, pitch, wraps=True)
    yield shapes.box((left, radius), (right, radius + thick), "cable")
    every = max(1, round((right - left) / pitch / 60.0))
    slides["teeth"]["span"] = every * pitch
    for place in np.arange(left, right - every * pitch, every * pitch):
        yield shapes.Sliding(Line([(place, radius), (place, radius + 0.35 * thick)], "mark"), "teeth")
    yield shapes.box(
        (middle - height, radius + thick), (middle + height, radius + thick + height), "load", slide="load"
    )
    yield Label((0.0, -1.3 * radius), f"pinion, r = {words.quantity(radius, 'mm')}")


def _screw(stage: Screw, motor: Motor, speed: float, span: float, slides: Slides) -> Iterator[Shape]:
    """Motor, gearhead and screw in line, and the nut with the load."""
    radius, lead = 0.5 * MM * stage.diameter, MM * stage.lead
    housing = 0.5 * MM * motor.diameter if motor.diameter is not None else 1.5 * radius
    height = max(1.6 * radius, 0.06 * span)
    end = span + 3.0 * height
    yield shapes.box((-4.5 * housing, -housing), (-1.8 * housing, housing), "symbol")
    yield shapes.box((-1.8 * housing, -0.8 * housing), (0.0, 0.8 * housing), "symbol")
    yield Label((-2.25 * housing, 1.25 * max(height, housing)), "motor and gearhead")
    yield shapes.box((0.0, -radius), (end, radius), "steel")
    every = max(1, round(end / lead / 60.0))
    slides["thread"] = shapes.slide((1.0, 0.0), speed, every * lead, wraps=True)
    for place in np.arange(0.0, end - (every + 1) * lead, every * lead):
        yield shapes.Sliding(Line([(place, -radius), (place + 0.5 * lead, radius)], "mark"), "thread")
    middle = 0.5 * end
    yield shapes.box((middle - 0.8 * height, -height), (middle + 0.8 * height, height), "load", slide="load")
    label = f"screw {words.quantity(2 * radius, 'mm')}, lead {words.quantity(lead, 'mm')}"
    yield Label((middle, -1.25 * max(height, housing) - 2.0), label)


def _load_arrows(items: list[Shape], force: float, speed: float, *, linear: bool) -> Iterator[Shape]:
    """Force and speed of a load along a line, above the drawing."""
    (left, _), (right, top) = shapes.frame(items)
    middle, length = 0.5 * (left + right), 0.16 * (right - left)
    for place, (value, look) in enumerate(((force, "force"), (speed, "velocity"))):
        if value and linear:
            high = top + (0.03 + 0.035 * place) * (right - left)
            yield Arrow((middle, high), (middle + math.copysign(length, value), high), look)


def _load_keys(drive: ConventionalDrive, force: float, speed: float) -> Iterator[dict[str, str]]:
    """What the arrows stand for; of a joint, which has none, the same in words."""
    axis = drive.axis
    for value, look, text in (
        (force, "force", f"{axis.force} on the load {words.quantity(force, axis.force_unit)}"),
        (speed, "velocity", f"{axis.speed} of the load {words.quantity(speed, axis.speed_unit)}"),
    ):
        yield shapes.key(look if value and not axis.rotary else "", text)


# ---- linkage

_LINKAGES = {
    "lever": "lever arm",
    "table": "lever arm by angle",
    "crank": "actuator across the joint",
    "four-bar": "four-bar",
}


def _linkage_scene(linkage: Linkage) -> dict[str, Any]:
    """The linkage at the joint angle 0, at which the plane of force and speed is computed."""
    origin = np.zeros(2)
    items: list[Shape] = []
    if linkage.shape in ("lever", "table"):
        arm = MM * abs(float(np.asarray(linkage.derivatives(0.0, 1)[1])))
        items += [
            Disc(origin, arm, "guide"),
            Line([(-2.2 * arm, arm), (0.0, arm)], "cable"),
            Line([(0.0, 0.0), (1.9 * arm, -0.9 * arm)], "rod"),
            Line([(0.0, 0.0), (0.0, arm)], "rod"),
            Label((0.12 * arm, 0.45 * arm), words.quantity(arm, "mm"), anchor="start"),
        ]
    elif linkage.shape == "crank":
        base, arm, offset = _lengths(linkage, "base", "arm", "offset")
        fixed = np.array([-MM * base, 0.0])
        turn = math.pi - offset
        tip = MM * arm * np.array([math.cos(turn), math.sin(turn)])
        items += [
            Line([fixed, origin], "guide"),
            Line([origin, tip], "rod"),
            Line([fixed, tip], "cable"),
            Disc(fixed, 0.03 * MM * base, "joint"),
            Label(off(fixed, 0.0, -0.13 * MM * base), "fixed pivot"),
            Label(off(origin, 0.0, -0.13 * MM * base), "joint"),
            Disc(tip, 0.03 * MM * base, "joint"),
            Label(
                off(0.5 * (fixed + tip), 0.0, 0.08 * MM * base),
                f"actuator {words.quantity(MM * linkage.position(0.0), 'mm')}",
            ),
        ]
    else:
        base, arm, offset, turned = _lengths(linkage, "base", "arm", "offset", "crank")
        joint = np.array([MM * base, 0.0])
        crank = float(np.asarray(linkage.position(0.0)))
        near = MM * turned * np.array([math.cos(crank), math.sin(crank)])
        far = joint + MM * arm * np.array([math.cos(offset), math.sin(offset)])
        size = 0.035 * MM * base
        items += [
            Line([origin, joint], "guide"),
            Line([origin, near], "rod"),
            Line([joint, far], "rod"),
            Line([near, far], "cable"),
            *(Disc(one, size, "joint") for one in (joint, near, far)),
            Label(off(joint, 0.0, -3.0 * size), "joint"),
            Label(off(origin, 0.0, -3.0 * size), "drive"),
        ]
    reach = float(np.max(np.abs(shapes.frame(items))))
    items.append(Disc(origin, 0.03 * reach, "joint"))
    return shapes.scene(f"Linkage: {_LINKAGES[linkage.shape]}, at joint angle 0", items)


def _lengths(linkage: Linkage, *names: str) -> list[float]:
    """Values of fields that the shape of the linkage needs, so that it has them."""
    return [float(getattr(linkage, name)) for name in names]
