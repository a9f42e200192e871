"""Bodies of each machine: masses and moments of inertia are its own; bodies without mass in the machine have 1e-9 kg.

A cylinder has its moment of inertia, and the mass of a solid cylinder with that. Wheels turn with the inertia of their servos.
Heights of carriages and knobs, and widths of wheels, are for looking only.
"""

from __future__ import annotations

from typing import Any, NamedTuple
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from infinivar.analysis.moving_parts import STICK_SPEED, Parts
from infinivar.errors import ParameterError
from infinivar.machines.bodies import PlanarBody, joined
from infinivar.machines.pictures.jointed import Chain
from infinivar.machines.pictures.robots import TurningMembers, spots_of
from infinivar.machines.pictures.rods import OnRods, heights
from infinivar.machines.pictures.slides import Drum, Slides
from infinivar.machines.pictures.wheeled import Wheeled
from infinivar.report.scene.elements import LEAST, Scene, text

_X, _Y, _Z = np.eye(3)
_NONE = (0.0, 0.0, 0.0)
_WIDE = 0.25
"""Half-width of a wheel over its radius."""


class Extent(NamedTuple):
    """What a camera looks at."""

    centre: np.ndarray
    """(3,) [m]"""
    radius: float
    """[m]"""


def add_machine(scene: Scene, machine: Any, parts: Parts) -> Extent:
    """Add the bodies of a machine with their joints."""
    shapes = {"planar": _planar, "platform": _platform, "arm": _arm, "robot": _robot, "slide": _slide}
    return shapes[parts.outline.shape](scene, parts, parts.outline, _servo_inertia(machine))


def _servo_inertia(machine: Any) -> float:
    """Of a wheel with what steers it, about the steering axis; 0 if it is not known. [kg m^2]"""
    try:
        servo = machine.servo(STICK_SPEED)
    except ParameterError:
        return 0.0
    return 0.0 if servo is None else servo.inertia


def _wheel(
    scene: Scene, parent: Element, name: str, hub: Any, axes: Any, radius: float, angle: np.ndarray, turning: float
) -> None:
    """A wheel that steers about the third of its axes and rolls along the first; axes: the first two, in the parent."""
    body = scene.body(parent, name, hub, 0.0, _NONE, axes=axes)
    scene.joint(body, f"{name}_steering", "hinge", angle, _Z, turning)
    scene.geom(body, "cylinder", "wheel", size=[radius, _WIDE * radius], zaxis=_Y)


def _planar(scene: Scene, parts: Parts, cobot: Wheeled, turning: float) -> Extent:
    """Heights are below the handle, which is at 0."""
    spots, radii = cobot.spots, cobot.radii
    wide = float(radii.max())
    around = cobot.around
    own = LEAST if cobot.headings is None else 0.0  # of a wheel that turns against the body
    mass = cobot.mass - own * len(spots)
    moment = cobot.inertia - own * float(np.sum(spots**2))
    centre = np.append(-own * spots.sum(axis=0) / mass, 0.0)
    body = scene.body(scene.world, "body", [0.0, 0.0, 0.0], mass, [0.5 * moment, 0.5 * moment, moment], centre=centre)
    pose = parts.configuration
    for place, (name, kind, axis) in enumerate((("x", "slide", _X), ("y", "slide", _Y), ("angle", "hinge", _Z))):
        scene.joint(body, name, kind, pose[:, place], axis)
    slab = np.concatenate([np.column_stack([around, np.full(len(around), height * wide)]) for height in (-2.6, -2.0)])
    scene.mesh("slab", slab)
    scene.geom(body, "mesh", "body", mesh="slab")
    held = np.append(parts.held_at, 0.0)
    scene.geom(body, "capsule", "link", fromto=[*held[:2], -2.0 * wide, *held], size=[0.2 * wide])
    scene.handle(body, held, 0.45 * wide)
    for place, (spot, radius) in enumerate(zip(spots, radii, strict=True)):
        hub = [*spot, -4.2 * wide + radius]
        if cobot.headings is not None:
            across = [-np.sin(cobot.headings[place]), np.cos(cobot.headings[place]), 0.0]
            scene.geom(body, "cylinder", "wheel", pos=hub, size=[float(radius), _WIDE * float(radius)], zaxis=across)
            continue
        _wheel(scene, body, f"wheel_{place + 1}", hub, [*_X, *_Y], float(radius), parts.steering[:, place], turning)
    middle = 0.5 * (pose[:, :2].min(axis=0) + pose[:, :2].max(axis=0))
    reach = 0.5 * float(np.max(np.ptp(pose[:, :2], axis=0))) + 1.2 * cobot.size
    scene.geom(scene.world, "plane", "floor", pos=[*middle, -4.2 * wide], size=[3.0 * reach, 3.0 * reach, 0.1])
    return Extent(np.append(middle, 0.0), reach)


def _cylinder(scene: Scene, parts: Parts, drum: Drum, middle: np.ndarray, axis: np.ndarray, half: float) -> None:
    """The cylinder about an axis, with two stripes that show it turn."""
    assert parts.cylinder_angle is not None
    radius, inertia = drum.radius, drum.inertia
    mass = 2.0 * inertia / radius**2
    across = 0.5 * inertia + mass * half**2 / 3.0
    first = _Y if axis[0] else _X
    second = np.cross(axis, first)
    body = scene.body(scene.world, "cylinder", middle, mass, [across, across, inertia], axes=[*first, *second])
    scene.joint(body, "cylinder_turning", "hinge", parts.cylinder_angle, _Z)
    scene.geom(body, "cylinder", "cylinder", size=[radius, half])
    for sign in (1.0, -1.0):
        scene.geom(body, "box", "stripe", pos=[sign * radius, 0.0, 0.0], size=[0.01 * radius, 0.12 * radius, half])


def _slide(scene: Scene, parts: Parts, load: Slides, turning: float) -> Extent:
    """Links on a cylinder along x below the handle; on one axis the handle is on the link."""
    masses, count, drum = load.masses, len(load.masses), load.drum
    position = parts.link_positions
    radius, wheel = (0.02, 0.01) if drum is None else (drum.radius, drum.wheel_radius)
    middle = 0.5 * float(position.min() + position.max())
    half = 0.5 * float(np.ptp(position)) + 2.0 * radius
    below = (
        -(radius + 6.0 * wheel)
        if count == 1
        else -(2.0 * radius + 6.0 * wheel + float(np.max(np.abs(parts.handle[:, 1:]))))
    )
    if drum is not None:
        _cylinder(scene, parts, drum, np.array([middle, 0.0, below]), _X, half)
    else:
        for place in range(count):
            _, out = _around(place, count)
            rail = np.array([middle, 0.0, below]) + radius * out
            scene.geom(scene.world, "box", "cylinder", pos=rail, size=[half, 0.15 * wheel, 0.15 * wheel])
    for place in range(count):
        name = f"link_{place + 1}"
        along, out = _around(place, count)
        own = load.link_mass + (masses[place] if count == 1 or count > 3 else 0.0)
        link = scene.body(scene.world, name, np.array([0.0, 0.0, below]), own, _NONE)
        scene.joint(link, f"{name}_sliding", "slide", position[:, place], _X)
        hub = (radius + wheel) * out
        top = -below * _Z if count == 1 else (radius + 3.0 * wheel) * out
        scene.geom(link, "capsule", "link", fromto=[*(hub + 1.2 * wheel * out), *top], size=[0.25 * wheel])
        if drum is not None:
            angle = parts.steering[:, place]
            _wheel(scene, link, f"wheel_{place + 1}", hub, [*along, *_X], wheel, angle, turning)
        else:
            scene.geom(link, "box", "link", pos=radius * out, size=[0.8 * wheel, 0.5 * wheel, 0.5 * wheel])
        if count == 1:
            scene.handle(link, top, 0.6 * wheel)
    if 1 < count <= 3:
        _carried(scene, parts, masses, 0.6 * wheel)
    centre = np.array([middle, 0.0, 0.5 * below])
    if 1 < count <= 3:
        centre = centre + np.append(0.0, np.pad(parts.handle[:, 1:].mean(axis=0), (0, 3 - count)))
    return Extent(centre, half + 0.5 * abs(below) + float(np.max(np.abs(parts.handle))))


def _around(place: int, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Direction around the cylinder along x at a link, and outward, the first link on top."""
    angle = 2.0 * np.pi * place / count
    out = np.array([0.0, np.sin(angle), np.cos(angle)])
    return np.cross(_X, out), out


def _carried(scene: Scene, parts: Parts, masses: np.ndarray, size: float) -> None:
    """The handle on its axes, heaviest first: each body adds what the axes outside it move more. Links follow the axes."""
    order = np.argsort(-masses, kind="stable")
    parent, place = scene.world, 0
    while place < len(order):
        together = [one for one in order[place:] if masses[one] == masses[order[place]]]
        inner = order[place + len(together) :]
        own = masses[order[place]] - (masses[inner[0]] if len(inner) else 0.0)
        name = "carriage_" + "".join(parts.axes[one] for one in together)
        parent = scene.body(parent, name, [0.0, 0.0, 0.0], float(own), _NONE)
        for one in together:
            scene.joint(parent, f"handle_{parts.axes[one]}", "slide", parts.handle[:, one], np.eye(3)[one])
        place += len(together)
    scene.handle(parent, [0.0, 0.0, 0.0], size)
    for one, axis in enumerate(parts.axes):
        ties = {"joint1": f"link_{one + 1}_sliding", "joint2": f"handle_{axis}", "polycoef": "0 1 0 0 0"}
        SubElement(scene.equality, "joint", ties)


def _platform(scene: Scene, parts: Parts, load: OnRods, turning: float) -> Extent:
    platform, pose, drum = load.platform, parts.configuration, load.drum
    rods = load.rods(pose)
    links, length = rods.link_position, platform.rod_length
    radius, wheel = (0.0, 0.07 * length) if drum is None else (drum.radius, drum.wheel_radius)
    low, high = heights(platform, links, wheel)
    if drum is not None:
        _cylinder(scene, parts, drum, np.array([0.0, 0.0, 0.5 * (low + high)]), _Z, 0.5 * (high - low))
    for place, base in enumerate(platform.base):
        name = f"link_{place + 1}"
        scene.geom(scene.world, "capsule", "link", fromto=[*base[:2], low, *base[:2], high], size=[0.08 * wheel])
        link = scene.body(scene.world, name, base, load.link_mass, _NONE)
        scene.joint(link, f"{name}_sliding", "slide", links[:, place], _Z)
        scene.geom(link, "sphere", "link", size=[0.35 * wheel])
        if drum is not None:
            out = np.array([*base[:2], 0.0]) / np.hypot(*base[:2])
            hub = (radius + wheel) * out - np.array([*base[:2], 0.0])
            scene.geom(link, "capsule", "link", fromto=[*(0.3 * hub), 0.0, 0.0, 0.0], size=[0.2 * wheel])
            along = [*np.cross(_Z, out), *_Z]
            _wheel(scene, link, f"wheel_{place + 1}", hub, along, wheel, parts.steering[:, place], turning)
        slender = (*[load.rod_mass * length**2 / 12.0] * 2, 0.0)
        rod = scene.body(
            link, f"rod_{place + 1}", [0.0, 0.0, 0.0], load.rod_mass, slender, centre=[0.0, 0.0, 0.5 * length]
        )
        scene.joint(rod, f"rod_{place + 1}_joint", "ball", _from_z((rods.upper - rods.lower)[:, place] / length))
        scene.geom(rod, "capsule", "rod", fromto=[0.0, 0.0, 0.0, 0.0, 0.0, length], size=[0.2 * wheel])
        SubElement(rod, "site", name=f"rod_{place + 1}_end", pos=text([0.0, 0.0, length]), size=text(0.25 * wheel))
    body = scene.body(scene.world, "platform", [0.0, 0.0, 0.0], load.mass, load.inertia)
    scene.joint(body, "platform_pose", "free", np.concatenate([pose[:, :3], _turned(pose[:, 3:])], axis=1))
    plate = np.concatenate([platform.joints + shift * _Z for shift in (-0.2 * wheel, 0.2 * wheel)])
    scene.mesh("plate", plate)
    scene.geom(body, "mesh", "body", mesh="plate")
    scene.handle(body, [0.0, 0.0, 0.0], 0.5 * wheel)
    for place, joint in enumerate(platform.joints):
        SubElement(body, "site", name=f"joint_{place + 1}", pos=text(joint), size=text(0.25 * wheel))
        ties = {"site1": f"rod_{place + 1}_end", "site2": f"joint_{place + 1}"}
        SubElement(scene.equality, "connect", ties)
    top = float(np.max(pose[:, 2]))
    return Extent(
        np.array([0.0, 0.0, 0.5 * (low + top)]), 0.6 * (top - low) + float(np.max(np.abs(platform.base[:, :2])))
    )


def _from_z(direction: np.ndarray) -> np.ndarray:
    """Quaternions that turn z to unit vectors (t, 3) above the plane of x and y. (t, 4)"""
    found = np.stack([1.0 + direction[:, 2], -direction[:, 1], direction[:, 0], 0.0 * direction[:, 0]], axis=-1)
    return found / np.linalg.norm(found, axis=-1, keepdims=True)


def _turned(rotation: np.ndarray) -> np.ndarray:
    """Quaternions of rotation vectors (t, 3). (t, 4)"""
    angle = np.linalg.norm(rotation, axis=-1, keepdims=True)
    # sin(a/2)/a, with its series near 0.
    share = np.where(angle > 1e-6, np.sin(0.5 * angle) / np.where(angle > 1e-6, angle, 1.0), 0.5 - angle**2 / 48.0)
    return np.concatenate([np.cos(0.5 * angle), share * rotation], axis=-1)


def _arm(scene: Scene, parts: Parts, load: Chain, turning: float) -> Extent:
    """Members with their joints; pulleys on the joints of legs, whose links count as inertia of the joints."""
    lengths = load.lengths
    reach = float(np.sum(lengths))
    thick = 0.02 * reach
    parent, at = scene.world, np.zeros(3)
    for place, (length, own) in enumerate(zip(lengths, load.members, strict=True)):
        if place == len(lengths) - 1:
            own = joined(own, PlanarBody(load.tip_mass, np.array([length, 0.0]), load.tip_inertia))
        name = f"member_{place + 1}"
        inertia = [0.5 * own.inertia, own.inertia, own.inertia]
        body = scene.body(parent, name, at, max(own.mass, LEAST), inertia, centre=[*own.centre, 0.0])
        link = float(load.link_mass * load.pulleys[place] ** 2)
        scene.joint(body, f"joint_{place + 1}", "hinge", parts.configuration[:, place], _Z, link)
        scene.geom(body, "capsule", "link", fromto=[0.0, 0.0, 0.0, length, 0.0, 0.0], size=[0.7 * thick])
        radius = 1.2 * thick if load.drum is None else float(load.pulleys[place])
        scene.geom(body, "cylinder", "cylinder", pos=[0.0, 0.0, -1.2 * thick], size=[radius, 0.3 * thick])
        parent, at = body, length * _X
    scene.handle(parent, at, 1.2 * thick)
    scene.geom(scene.world, "cylinder", "link", pos=[0.0, 0.0, -2.5 * thick], size=[2.0 * thick, thick])
    points = load.points(parts.configuration).reshape(-1, 2)
    low, high = points.min(axis=0), points.max(axis=0)
    return Extent(np.append(0.5 * (low + high), 0.0), 0.5 * float(np.max(high - low)) + 0.15 * reach)


def _robot(scene: Scene, parts: Parts, load: TurningMembers, turning: float) -> Extent:
    """Members with their joints; links of legs count as inertia of the joints."""
    chain, thick = load.chain, 0.02 * load.chain.reach
    ends = [*chain.places, chain.tool_place]
    parent = scene.world
    _bar(scene, parent, ends[0], thick)
    scene.geom(scene.world, "box", "link", pos=[0.0, 0.0, -0.5 * thick], size=[4.0 * thick, 4.0 * thick, 0.5 * thick])
    for place, own in enumerate(load.members):
        turn, name = chain.turns[place], f"member_{place + 1}"
        axes = [*turn[:, 0], *turn[:, 1]]
        parent = scene.body(parent, name, ends[place], own.mass, own.inertia, centre=own.centre, axes=axes)
        link = float(load.link_mass * load.pulleys[place] ** 2)
        scene.joint(parent, f"joint_{place + 1}", "hinge", parts.configuration[:, place], chain.axes[place], link)
        half = 1.6 * thick * chain.axes[place]
        scene.geom(parent, "cylinder", "cylinder", fromto=[*-half, *half], size=[1.2 * thick])
        _bar(scene, parent, ends[place + 1], thick)
    scene.handle(parent, ends[-1], 1.2 * thick)
    points = spots_of(chain, parts.configuration).points.reshape(-1, 3)
    low, high = points.min(axis=0), points.max(axis=0)
    return Extent(0.5 * (low + high), 0.5 * float(np.max(high - low)) + 0.15 * chain.reach)


def _bar(scene: Scene, body: Element, end: np.ndarray, thick: float) -> None:
    """A member from the origin of a body to a place in it, unless that is there."""
    if np.linalg.norm(end) > 1e-3 * thick:
        scene.geom(body, "capsule", "link", fromto=[0.0, 0.0, 0.0, *end], size=[0.7 * thick])
