"""Machines drawn from their geometry: platform on rods, cart on wheels, planar arm, sphere between rollers."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.drive import type_words
from infinivar.errors import InputError
from infinivar.figures import planar_cobot, sphere
from infinivar.machines.kinds.arm import ArmDrive
from infinivar.machines.kinds.planar import PlanarDrive
from infinivar.machines.kinds.platform import PlatformDrive
from infinivar.machines.kinds.sphere import SphereDrive
from infinivar.transmission.platform import rotated
from infinivar.web.answers import contact, drawing_wheels, shapes, words
from infinivar.web.answers.places import Place
from infinivar.web.answers.shapes import Item

MM = 1e3
_PLATFORM_VIEW = shapes.View(-62.0, 24.0)
_SPHERE_VIEW = shapes.View(-38.0, 24.0)
"""The directions of view of the figures."""

_LIMIT = 0.4
"""Length of an arrow of the slip limit of a cart's wheel, over the size of the cart."""


def drawn(place: Place) -> Any:
    """Scenes, slides, state and notes of a machine; see `drawing.drawing`.

    Raises
    ------
    InputError
        If nothing can be drawn, as a wheel slips or the pose is out of reach.
    """
    made = _DRAWN.get(type_words(place.drive))
    if made is None:
        raise InputError(f"{place.title} is of a type that has no drawing")
    return made(place, place.drive)


def _vector_words(vector: np.ndarray, unit: str) -> str:
    return words.quantity(float(np.linalg.norm(vector)), unit)


# ---- platform


def _platform(place: Place, drive: PlatformDrive) -> Any:
    see, platform = _PLATFORM_VIEW, drive.platform
    pose = np.asarray(place.pose)
    kinematics = platform.at(pose[:3], pose[3:])
    height = np.asarray(kinematics.link_position)
    if not np.all(np.isfinite(height)):
        raise InputError(f"{place.title} does not reach this pose")
    upper = MM * (pose[:3] + np.stack(rotated(pose[3:], np.asarray(platform.joints)), axis=-1))
    lower = MM * (np.asarray(platform.base) + height[:, None] * [0.0, 0.0, 1.0])
    ends = MM * (
        np.array(platform.stroke or (height.min() - 0.03, height.max() + 0.03)) + float(np.mean(platform.base[:, 2]))
    )
    behind, front = [], []
    around = np.arctan2(lower[:, 1], lower[:, 0])
    point = place.point()
    for index in range(len(lower)):
        near = see.toward((math.cos(around[index]), math.sin(around[index]), 0.0)) > 0
        items = front if near else behind
        guide = np.array([[*lower[index, :2], end] for end in ends])
        items.append(shapes.poly(see(guide), "guide", closed=False))
        if drive.leg is not None:
            items += _leg_wheel(drive.leg, point, index, around[index], lower[index], see)
        items.append(shapes.poly(see([lower[index], upper[index]]), "rod", closed=False))
        items.append(shapes.circle(see(lower[index]), 4.0, "joint"))
        items.append(
            shapes.text(shapes.off(see(lower[index]), 7.0 if see(lower[index])[0] > 0 else -7.0, -9.0), str(index + 1))
        )
    middle = list(_drum(drive.leg, ends, see)) if drive.leg is not None else []
    plate = [shapes.poly(shapes.hull(see(upper)), "plate")]
    arrows = list(_space_arrows(place, MM * pose[:3], float(np.ptp(ends)), see))
    items = [*behind, *middle, *front, *plate, *arrows]
    scenes = [shapes.scene("Platform on its rods", items, keys=_keys(place, 3))]
    notes = [f"geometry: {platform.provenance}"] if platform.provenance != "given" else []
    state = [words.row("force on the load", _vector_words(place.wrench[:3], "N"))]  # type: ignore[index]
    state.append(words.row("velocity", _vector_words(place.twist[:3], "m/s")))  # type: ignore[index]
    state += _part_rows(point)
    if drive.leg is not None:
        state.insert(0, words.row("cylinder", words.quantity(30.0 / math.pi * drive.leg.cylinder_speed, "rpm")))
    return scenes, {}, state, notes


def _part_rows(point: Any) -> Iterator[dict[str, str]]:
    """Each part with its force, and steering angle if it has one."""
    unit = point.part_units[0]
    for index, name in enumerate(point.parts):
        steering = float(point.steering[index])
        angle = "" if math.isnan(steering) else f", steered {words.quantity(math.degrees(steering), '°')}"
        yield words.row(name, f"{words.quantity(point.part_forces[index], unit)}{angle}")


def _leg_wheel(
    leg: CoboticDrive, point: Any, index: int, around: float, lower: np.ndarray, see: shapes.View
) -> Iterator[Item]:
    """The wheel of a leg on the cylinder, its hub out to the rod, with spokes that turn."""
    element = leg.transmission
    force, speed = float(point.part_forces[index]), float(point.part_speeds[index])
    found = contact.element_point(leg, speed, force)
    angle = float(np.arctan(found.steering_tangent))
    if not math.isfinite(float(found.link_speed)):
        raise InputError(
            f"the wheel of leg {index + 1} slips here: there is no steering angle at which its link moves as asked"
        )
    radius = MM * element.wheel_radius
    outward = np.array([math.cos(around), math.sin(around), 0.0])
    along = np.array([-math.sin(around), math.cos(around), 0.0])
    heading = math.cos(angle) * along + math.sin(angle) * np.array([0.0, 0.0, 1.0])
    hub = (MM * element.cylinder_radius + radius) * outward + [0.0, 0.0, lower[2]]
    disc = hub + radius * (np.cos(shapes.ROUND)[:, None] * outward + np.sin(shapes.ROUND)[:, None] * heading)
    yield shapes.poly(see([hub, lower]), "carriage-line", closed=False)
    yield shapes.poly(see(disc), "wheel")
    rate = float(found.rolling_speed) / element.wheel_radius
    yield shapes.marks(
        (see(hub), see(hub)),
        (see(0.3 * radius * outward), see(radius * outward)),
        (see(0.3 * radius * heading), see(radius * heading)),
        rate,
        count=4,
        look="tread",
    )


def _drum(leg: CoboticDrive, ends: np.ndarray, see: shapes.View) -> Iterator[Item]:
    """The common cylinder, upright, with lines along it that turn."""
    radius = MM * leg.transmission.cylinder_radius
    low, high = float(ends[0]) - 0.3 * radius, float(ends[1]) + 0.3 * radius
    rim = radius * np.stack([np.cos(shapes.ROUND), np.sin(shapes.ROUND), 0.0 * shapes.ROUND], axis=-1)
    lower, upper = (see(rim + np.array([0.0, 0.0, end])) for end in (low, high))
    yield shapes.poly(shapes.hull(np.concatenate([lower, upper])), "steel")
    yield shapes.poly(upper, "steel")
    first, second = np.array([radius, 0.0, 0.0]), np.array([0.0, radius, 0.0])
    yield shapes.marks(
        (see([0.0, 0.0, low]), see([0.0, 0.0, high])),
        (see(first), see(first)),
        (see(second), see(second)),
        leg.cylinder_speed,
        count=10,
        face=(see.toward(first), see.toward(second)),
    )


def _space_arrows(place: Place, origin: np.ndarray, length: float, see: shapes.View) -> Iterator[Item]:
    """Force on the load and velocity at the platform; a direction that points at the viewer is short."""
    size = 0.75 * max(length, 40.0)
    for vector, look, share in ((place.twist, "velocity", 1.0), (place.wrench, "force", 0.7)):
        way = np.asarray(vector)[:3]
        long = float(np.linalg.norm(way))
        if long > 0.0:
            yield shapes.arrow(see(origin), see(origin + share * size * way / long), look)


def _keys(place: Place, count: int) -> Iterator[dict[str, str]]:
    """What the arrows of force and velocity stand for, of the first coordinates, which are along axes."""
    for vector, look, label, unit in (
        (place.wrench, "force", "force on the load", "N"),
        (place.twist, "velocity", "velocity", "m/s"),
    ):
        long = float(np.linalg.norm(np.asarray(vector)[:count]))
        if long > 0.0:
            yield shapes.key(look, f"{label} {words.quantity(long, unit)}")


# ---- cart


def _cart(place: Place, drive: PlanarDrive) -> Any:
    positions = MM * (np.array(drive.machine.positions) if drive.positions is not None else np.zeros((1, 2)))  # type: ignore[union-attr]
    middle = positions.mean(axis=0)
    size = float(np.max(np.linalg.norm(positions - middle, axis=1))) or 4.0 * MM * drive.wheel.wheel_radius
    ring = 0.14 * size * np.stack([np.cos(shapes.ROUND), np.sin(shapes.ROUND)], axis=-1)
    items: list[Item] = [shapes.poly(shapes.hull((positions[:, None] + ring).reshape(-1, 2)), "plate")]
    radius = MM * drive.wheel.wheel_radius
    state = [
        words.row("force on the load", _vector_words(np.asarray(place.wrench)[:2], "N")),
        words.row("velocity", _vector_words(np.asarray(place.twist)[:2], "m/s")),
    ]
    if np.any(place.twist):
        point = drive.operated(place.twist, place.wrench)
        numbers = planar_cobot.data(drive.machine, point)
        scale = _LIMIT * size / float(np.max(numbers["limit"]))
        for index, spot in enumerate(positions):
            items += _cart_wheel(spot, numbers, index, radius, scale, middle, float(point.rolling_speed[index]))
        items += _centre(MM * numbers["centre"], middle, size)
        for index, demand in enumerate(numbers["slip"]):
            force = float(np.linalg.norm(numbers["force"][index]))
            text = f"{words.quantity(force, 'N')}, {words.quantity(100.0 * demand, '%', 2)} of its slip limit"
            state.append(words.row(f"wheel {index + 1}", text))
        notes = ["dotted circles are the slip limits, to the scale of the forces; axes of the body"]
    else:
        items += [shapes.circle(spot, radius, "wheel") for spot in positions]
        notes = ["at rest the wheels are locked; their headings are free, and drawn as circles"]
    items += _flat_arrows(place, np.zeros(2), 0.55 * size)
    keys = [*_keys(place, 2)]
    if np.any(place.twist):
        keys.append(shapes.key("contact-force", "force of the ground on a wheel"))
    return [shapes.scene("Cart from above", items, keys=keys)], {}, state, notes


def _cart_wheel(
    spot: np.ndarray, numbers: Any, index: int, radius: float, scale: float, middle: np.ndarray, speed: float
) -> Iterator[Item]:
    """One wheel: its normal, its slip limit as a circle, its force, and treads that roll."""
    heading = numbers["headings"][index]
    across = np.array([-heading[1], heading[0]])
    yield shapes.poly([spot - 3.0 * radius * across, spot + 3.0 * radius * across], "heading", closed=False)
    yield shapes.circle(spot, scale * numbers["limit"][index], "limit")
    width = 0.3 * radius
    corners = [
        spot + along * radius * heading + side * width * across for along, side in ((1, 1), (1, -1), (-1, -1), (-1, 1))
    ]
    yield shapes.poly(corners, "wheel")
    yield shapes.marks(
        (spot - width * across, spot + width * across),
        ((0.0, 0.0), (0.0, 0.0)),
        (radius * heading, radius * heading),
        speed / (radius / MM),
        count=8,
        look="tread",
        face=(1.0, 0.0),
    )
    force = numbers["force"][index]
    tip = spot + scale * force
    yield shapes.arrow(spot, tip, "contact-force", "")
    out = 1.0 if spot[1] >= middle[1] else -1.0
    label = f"{index + 1}: {words.quantity(float(np.linalg.norm(force)), 'N')}"
    yield shapes.text(
        shapes.off(spot, 0.0, out * (1.15 * scale * numbers["limit"][index] + (0.0 if out > 0 else 0.5 * radius))),
        label,
    )


def _centre(centre: np.ndarray, middle: np.ndarray, size: float) -> Iterator[Item]:
    """The instant centre, if it is near."""
    if np.all(np.isfinite(centre)) and np.linalg.norm(centre - middle) < 3.0 * size:
        yield shapes.circle(centre, 0.04 * size, "joint")
        yield shapes.text(shapes.off(centre, 0.0, 0.08 * size), "instant centre")


def _flat_arrows(place: Place, origin: np.ndarray, length: float) -> Iterator[Item]:
    """Force on the load and velocity in the plane."""
    yield shapes.circle(origin, 0.03 * length, "joint")
    for vector, look, share in ((place.twist, "velocity", 1.0), (place.wrench, "force", 0.7)):
        way = np.asarray(vector)[:2]
        long = float(np.linalg.norm(way))
        if long > 0.0:
            yield shapes.arrow(origin, origin + share * length * way / long, look)


# ---- arm


def _arm(place: Place, drive: ArmDrive) -> Any:
    pose = np.asarray(place.pose)
    angles = np.asarray(drive.angles(pose))
    if not np.all(np.isfinite(angles)):
        raise InputError(f"{place.title} does not reach this pose")
    direction = np.cumsum(angles)
    members = MM * np.asarray(drive.lengths)[:, None] * np.stack([np.cos(direction), np.sin(direction)], axis=-1)
    points = np.concatenate([np.zeros((1, 2)), np.cumsum(members, axis=0)])
    reach = MM * float(np.sum(drive.lengths))
    pulley = MM * drive.pulley_radius
    point = place.point()
    items: list[Item] = [shapes.poly([(-0.1 * reach, 0.0), (0.1 * reach, 0.0)], "base", closed=False)]
    items += [shapes.circle(spot, pulley, "guide") for spot in points[:-1]]
    items += [shapes.poly(points[index : index + 2], "member", closed=False) for index in range(len(members))]
    for index, spot in enumerate(points[:-1]):
        items.append(shapes.circle(spot, 0.022 * reach, "joint"))
        label = f"{index + 1}: {words.quantity(point.part_forces[index], 'N m')}"
        items.append(shapes.text(shapes.off(spot, 0.0, -pulley - 0.05 * reach), label))
    if len(drive.lengths) > 1:
        items += _flat_arrows(place, points[-1], 0.32 * reach)
    keys = _keys(place, 2) if len(drive.lengths) > 1 else ()
    scenes = [shapes.scene("Arm, with the torques of its joints", items, keys=keys)]
    notes = ["circles at the joints are the pulleys, to scale"]
    if drive.leg is not None:
        scenes.append(_row_of_wheels(drive, drive.leg, point))
        notes.append("the places of the wheels along the common cylinder are not to scale; their sizes and angles are")
    state = [*_part_rows(point)]
    state += [
        words.row(f"angle of joint {index + 1}", words.quantity(math.degrees(one), "°"))
        for index, one in enumerate(angles)
    ]
    return scenes, {}, state, notes


def _row_of_wheels(drive: ArmDrive, leg: CoboticDrive, point: Any) -> dict[str, Any]:
    """The wheels of all joints in a row on the common cylinder, from above."""
    element, count = leg.transmission, drive.links
    apart = 1.8 * MM * element.cylinder_radius
    length = apart * (count + 0.4)
    items = [*drawing_wheels.cylinder_from_above(element, leg.cylinder_speed, length)]
    for index in range(count):
        force, speed = point.part_forces[index] / drive.pulley_radius, point.part_speeds[index] * drive.pulley_radius
        found = contact.element_point(leg, float(speed), float(force))
        if not math.isfinite(float(found.link_speed)):
            raise InputError(f"the wheel of joint {index + 1} slips here")
        items += drawing_wheels.wheel_from_above(
            element, found, apart * (index - 0.5 * (count - 1)), label=str(index + 1)
        )
    return shapes.scene("Common cylinder with the wheel of each joint", items)


# ---- sphere


def _sphere(place: Place, drive: SphereDrive) -> Any:
    see = _SPHERE_VIEW
    angle, point = drive.turned(place.point(), np.asarray(place.wrench))
    numbers = sphere.data(drive.transmission, point)
    size = MM * drive.sphere_radius
    axis = numbers["axis"]
    rim = size * np.stack([np.cos(shapes.ROUND), np.sin(shapes.ROUND)], axis=-1)
    velocity = np.asarray(point.sphere_velocity)
    behind: list[Item] = []
    front: list[Item] = []
    for index, normal in enumerate(numbers["normals"]):
        items = front if see.toward(normal) > 0 else behind
        items += _roller(numbers, index, size, velocity, see)
    first = np.cross(axis, [0.3, -0.5, 0.8])
    first = size * first / np.linalg.norm(first)
    second = np.cross(axis, first)
    half = 0.3 * size * axis
    ball = [
        shapes.poly(rim, "steel"),
        shapes.marks(
            (see(-half), see(half)),
            (see(0.954 * first), see(0.954 * first)),
            (see(0.954 * second), see(0.954 * second)),
            float(np.linalg.norm(velocity)),
            count=8,
            face=(see.toward(first), see.toward(second)),
        ),
    ]
    for sign in (1.0, -1.0):
        line = shapes.poly(see(np.outer([size, 1.65 * size], sign * axis)), "axis", closed=False)
        (front if see.toward(sign * axis) > 0 else behind).append(line)
    speeds, torques = numbers["speeds"], numbers["torques"]
    state = [
        words.row("steering angle", words.quantity(math.degrees(angle), "°")),
        words.row("shaft 1", f"{words.quantity(torques[0], 'N m')} at {words.quantity(speeds[0], 'rad/s')}"),
        words.row("shaft 2", f"{words.quantity(torques[1], 'N m')} at {words.quantity(speeds[1], 'rad/s')}"),
    ]
    for index, kind in enumerate(numbers["kinds"]):
        force, share = float(np.linalg.norm(numbers["force"][index])), 100.0 * numbers["slip"][index]
        text = f"{words.quantity(force, 'N')}, {words.quantity(share, '%', 2)} of its slip limit"
        state.append(words.row(f"{index + 1}, {kind} roller", text))
    return (
        [
            shapes.scene(
                "Sphere between its rollers",
                [*behind, *ball, *front],
                keys=[shapes.key("contact-force", "force of a roller on the sphere")],
            )
        ],
        {},
        state,
        ["the width of the rollers is not to scale"],
    )


def _roller(numbers: Any, index: int, size: float, velocity: np.ndarray, see: shapes.View) -> Iterator[Item]:
    """A roller with stripes on its rim, and its force on the sphere."""
    normal, axle, kind = numbers["normals"][index], numbers["axles"][index], numbers["kinds"][index]
    radius = size * numbers["radius"][index]
    hub, across = (size + radius) * normal, np.cross(axle, normal)
    disc = hub + radius * (np.cos(shapes.ROUND)[:, None] * normal + np.sin(shapes.ROUND)[:, None] * across)
    width = 0.35 * radius
    near = width if see.toward(axle) > 0 else -width
    both = see(np.concatenate([disc - near * axle, disc + near * axle]))
    yield shapes.poly(shapes.hull(both), f"roller-{kind}")
    yield shapes.poly(see(disc + near * axle), f"roller-{kind}")
    # Where they touch, rim and sphere move alike, creep aside.
    rate = -float(np.cross(velocity, size * normal) @ across) / radius
    yield shapes.marks(
        (see(hub - width * axle), see(hub + width * axle)),
        (see(radius * normal), see(radius * normal)),
        (see(radius * across), see(radius * across)),
        rate,
        count=8,
        look="tread",
        face=(see.toward(normal), see.toward(across)),
    )
    scale = 1.1 * size / float(np.max(numbers["limit"]))
    start = size * normal
    yield shapes.arrow(see(start), see(start + scale * numbers["force"][index]), "contact-force", "")
    yield shapes.text(see((size + 2.35 * radius) * normal), f"{index + 1} {kind}")


_DRAWN: dict[str, Callable[..., Any]] = {
    kind.WORD: drawn
    for kind, drawn in ((PlatformDrive, _platform), (PlanarDrive, _cart), (ArmDrive, _arm), (SphereDrive, _sphere))
}
