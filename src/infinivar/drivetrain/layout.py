"""Where the bodies of a drive are, and the space that they fill.

Lengths are along x, in which the load travels, y across it, and z from the axis of cylinder, pulley or screw to the rail, with
the load in the middle of its travel. Springs, linkage and what a drive turns are not placed.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator
from typing import Any, Literal, NamedTuple

from infinivar._core.array_namespace import Array, as_floats, namespace, plain
from infinivar.drivetrain.building.base import Building, Frame
from infinivar.drivetrain.building.cobotic import CoboticBuilding
from infinivar.drivetrain.building.geared import GearedBuilding
from infinivar.drivetrain.service import Service
from infinivar.parts.structure.structure import Structure

Form = Literal["box", "x", "y", "z"]
"""A box, or what is round about an axis."""

Range = tuple[Array, Array]
"""From, to. [m]"""


class Solid(NamedTuple):
    """A body, or one of its parts, as a box or something round; arrays that broadcast."""

    body: str
    form: Form
    x: Range
    y: Range
    z: Range


class Space(NamedTuple):
    """Box around solids. [m]"""

    length: Array
    width: Array
    height: Array

    @property
    def volume(self) -> Array:
        """Of the box. [m^3]"""
        return self.length * self.width * self.height

    @property
    def diameter(self) -> Array:
        """Of the tube along x that holds the box. [m]"""
        xp = namespace(self.width, self.height)
        width, height = as_floats(xp, self.width, self.height)
        return xp.sqrt(width**2 + height**2)


class Layout(NamedTuple):
    """Where the bodies of a drive are."""

    solids: tuple[Solid, ...]
    open: tuple[str, ...]
    """Bodies whose place or size is not known, and why."""

    @property
    def space(self) -> Space:
        """Box around what is placed; nan without any. [m]"""
        return Space(*(_extent([getattr(one, axis) for one in self.solids]) for axis in "xyz"))


def cobotic_layout(drive: Any, service: Service) -> Layout:
    """Layout of a cobotic drive.

    Parameters
    ----------
    drive : CoboticDrive   Its values may be arrays of many designs.
    service : Service
    """
    return _layout(_cobotic(CoboticBuilding(drive, service)))


def geared_layout(drive: Any, service: Service) -> Layout:
    """Layout of a conventional drive; see `cobotic_layout`."""
    return _layout(_geared(GearedBuilding(drive, service)))


def size_of(part: Any, structure: Structure) -> tuple[Array, Array] | None:
    """Length and diameter of a motor or gearhead, as stated, else estimated of its mass; None if not known. [m], [m]"""
    mass, diameter, length = (getattr(part, name, None) for name in ("mass", "diameter", "length"))
    if mass is None:
        return None if diameter is None or length is None else (length, diameter)
    return estimated_size(mass, diameter, length, structure)


def estimated_size(
    mass: Array, diameter: Array | None, length: Array | None, structure: Structure
) -> tuple[Array, Array]:
    """Length and diameter of something round, each as stated, or of its mass where it is None or nan. [m], [m]"""
    volume = 4.0 * mass / (math.pi * structure.motor_density)
    wide = _or(diameter, (volume / structure.motor_slenderness) ** (1.0 / 3.0))
    return _or(length, volume / wide**2), wide


def _or(stated: Array | None, otherwise: Array) -> Array:
    """A stated value, or another where it is None or nan."""
    if stated is None:
        return otherwise
    xp = namespace(stated, otherwise)
    (stated,) = as_floats(xp, stated)
    return plain(xp.where(xp.isnan(stated), otherwise, stated))


def _extent(ranges: list[Range]) -> Array:
    if not ranges:
        return math.nan
    low, high = ranges[0]
    xp = namespace(*(end for pair in ranges for end in pair))
    for below, above in ranges[1:]:
        low, high = xp.minimum(*as_floats(xp, low, below)), xp.maximum(*as_floats(xp, high, above))
    return high - low


def _layout(found: Iterator[Solid | str]) -> Layout:
    every = list(found)
    return Layout(
        tuple(one for one in every if isinstance(one, Solid)), tuple(one for one in every if isinstance(one, str))
    )


def _around(made: CoboticBuilding, solids: Iterator[Solid]) -> Iterator[Solid]:
    """Solids of the first of several wheels, and those of the others, turned about the cylinder's axis.

    What is round and stays so is exact at half a turn; else it is the box around the box turned.
    """
    count = made.drive.transmission.wheels
    for one in solids:
        yield one
        for place in range(1, count):
            if 2 * place == count:
                (low, high), (left, right) = one.z, one.y
                yield one._replace(y=(-right, -left), z=(-high, -low))
                continue
            angle = 2.0 * math.pi * place / count
            cosine, sine = math.cos(angle), math.sin(angle)
            (left, right), (low, high) = one.y, one.z
            wide = abs(cosine) * (right - left) + abs(sine) * (high - low)
            tall = abs(sine) * (right - left) + abs(cosine) * (high - low)
            y, z = 0.5 * (left + right), 0.5 * (low + high)
            turned = _about(y * cosine - z * sine, wide), _about(y * sine + z * cosine, tall)
            yield Solid(one.body, "box", one.x, *turned)
    ring = made.ring()
    if ring is not None:
        middle, thickness, width = ring
        yield _round("carriage ring", "x", _about(0.0, width), 2.0 * middle + thickness)


def _about(centre: Array, size: Array) -> Range:
    return centre - 0.5 * size, centre + 0.5 * size


def _onwards(start: Array, size: Array) -> Range:
    return start, start + size


def _round(body: str, along: Literal["x", "y", "z"], span: Range, diameter: Array, x=0.0, y=0.0, z=0.0) -> Solid:
    """Something round about an axis through a point."""
    ranges = {axis: _about(at, diameter) for axis, at in (("x", x), ("y", y), ("z", z))}
    return Solid(body, along, **{**ranges, along: span})


def _bought(made: Any, name: str, part: Any) -> tuple[Array, Array] | str:
    size = size_of(part, made.structure)
    return f"{name} (neither its mass nor its length and diameter are stated)" if size is None else size


def _in_line(
    made: Any, parts: dict[str, Any], along: Literal["x", "y"], start: Array, x: Array
) -> Iterator[Solid | str]:
    """Gearhead and motor behind each other on the axis of what they turn; x is that of an axis across."""
    for name, part in parts.items():
        size = _bought(made, name, part)
        if isinstance(size, str):
            yield size
            continue
        length, diameter = size
        yield _round(name, along, _onwards(start, length), diameter, x=x)
        start = start + length


def _guide(made: Building, frame: Frame) -> Iterator[Solid]:
    """Carriage and rail, whose height is that of both together, and the bar of the frame under them."""
    rail, reach = made.rail, frame.reach
    back, half = reach - rail["height"], 0.5 * rail["height"]
    yield Solid(
        "carriage", "box", _about(0.0, rail["carriage_length"]), _about(0.0, rail["width"]), (back, reach - half)
    )
    # A rail is about half as wide as its carriage.
    yield Solid("rail", "box", _about(0.0, made.rail_length), _about(0.0, 0.5 * rail["width"]), (reach - half, reach))
    yield Solid("frame", "box", _about(0.0, frame.length), _about(0.0, frame.width), _onwards(reach, frame.height))


def _between_ends(made: CoboticBuilding | GearedBuilding, frame: Frame, name: str) -> Iterator[Solid]:
    """Bearings of a shaft along the travel, and the plates that hold them."""
    for end in (-0.5 * frame.length, 0.5 * frame.length):
        place = _about(end, made.held["breadth"])
        yield _round(name, "x", place, made.held["outside_diameter"])
        yield Solid("frame", "box", place, _about(0.0, frame.across), (-frame.beyond, frame.reach))


def _cobotic(made: CoboticBuilding) -> Iterator[Solid | str]:
    drive, element = made.drive, made.drive.transmission
    geometry = element.geometry
    tube, frame = (None, None) if geometry is None else (made.tube, made.sizes())
    if geometry is None or tube is None or frame is None:
        yield f"cylinder, wheel and frame ({made.lacking})"
        return
    bell, axle, rail = made.bell, geometry.axle_bearing, made.rail
    radius, wheel = element.cylinder_radius, element.wheel_radius
    high = radius + wheel
    yield _round("cylinder", "x", _about(0.0, tube.length + 2.0 * tube.end_plate), 2.0 * radius)
    yield from _between_ends(made, frame, "cylinder bearings")
    outside, thickness = made.bell_bearing_sizes()
    pressed = [
        _round("wheel", "x", _about(0.0, geometry.wheel_width), 2.0 * wheel, z=high),
        *(
            _round("axle bearings", "x", _about(end, axle.breadth), axle.outside_diameter, z=high)
            for end in (-0.5 * bell.span, 0.5 * bell.span)
        ),
        _round("bell", "z", (high - bell.drop, high + bell.rise), 2.0 * bell.outer),
        _round("bell bearing", "z", (high + made.top - thickness, high + made.top), outside),
    ]
    yield from _around(made, iter(pressed))
    yield from _guide(made, frame)
    turning = {"gearhead": drive.gearhead, "cylinder motor": drive.motor}
    yield from _in_line(made, turning, "x", 0.5 * (frame.length + frame.thickness), 0.0)
    if drive.steering is not None:
        size = _bought(made, "steering motor", drive.steering.motor)
        if isinstance(size, str):
            yield size
            return
        length, diameter = size
        xp = namespace(outside, rail["width"], bell.outer)
        widest = functools.reduce(xp.maximum, as_floats(xp, outside, rail["width"], 2.0 * bell.outer))
        beside = 0.5 * widest + 0.5 * diameter
        yield _round("steering motor", "z", _onwards(high - bell.drop, length), diameter, y=beside)


def _geared(made: GearedBuilding) -> Iterator[Solid | str]:
    drive, stage, service = made.drive, made.drive.stage, made.service
    turning = {"gearhead": drive.gearhead, "motor": drive.motor}
    if stage.title == "shaft":
        yield from _in_line(made, turning, "x", 0.0, 0.0)
        return
    frame = None
    if stage.title in ("pulley", "belt", "rack", "screw") and service.travel is not None and service.force is not None:
        frame = made.sizes()
    if frame is None:
        yield f"{stage.title} and frame (travel, force or material are not known)"
        return
    rail, held, half = made.rail, made.held, 0.5 * frame.length
    yield from _guide(made, frame)
    if stage.title == "screw":
        yield _round("screw", "x", _about(0.0, frame.length), stage.diameter)
        yield _round("screw", "x", _about(0.0, made.guided), 2.0 * stage.diameter)
        yield from _between_ends(made, frame, "screw bearings")
        yield from _in_line(made, turning, "x", 0.5 * (frame.length + frame.thickness), 0.0)
        return
    wide, radius = made.wheel_width, stage.travel_per_radian
    if stage.title == "rack":
        sweep = _about(0.0, frame.length + service.travel)  # it moves with the carriage
        yield Solid("rack", "box", sweep, _about(0.0, wide), _onwards(radius, wide))
    shafts = (-half, half) if made.belted else (0.0,)
    xp = namespace(wide, rail["width"])
    room, carriage = as_floats(xp, wide, rail["width"])
    # A rack passes between the plates of its pinion with the carriage.
    aside = 0.5 * ((xp.maximum(room, carriage) if stage.title == "rack" else wide) + held["breadth"])
    for x in shafts:
        yield _round(stage.title, "y", _about(0.0, wide), 2.0 * radius, x=x)
        for end in (-aside, aside):
            place = _about(end, held["breadth"])
            yield _round(f"{stage.title} bearings", "y", place, held["outside_diameter"], x=x)
            yield Solid("frame", "box", _about(x, frame.across), place, (-frame.beyond, frame.reach))
    if made.belted:
        for side in (-1.0, 1.0):
            yield Solid(
                stage.title, "box", _about(0.0, frame.length), _about(0.0, 0.8 * wide), _about(side * radius, 1e-3)
            )
    yield from _in_line(made, turning, "y", aside + 0.5 * held["breadth"], shafts[-1])
