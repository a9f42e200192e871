"""A sphere between its rollers: axis of the sphere, rollers along their headings, and forces on the sphere."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from infinivar.errors import InputError
from infinivar.machines.pictures.strokes import (
    CIRCLE,
    Arrow,
    Label,
    Line,
    Picture,
    Stroke,
    Turning,
    View,
    hull,
    quantity,
    rim,
    share_of_slip,
    slip_rows,
)
from infinivar.transmission.spherical import SphericalIVT, SphericalPoint

_VIEW = View(-38.0, 24.0)
_LONGEST = 1.1
"""Arrow of the slip limit over the radius of the sphere."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Rollers:
    """k rollers about a sphere at one point."""

    size: float
    """Radius of the sphere. [m]"""
    normals: np.ndarray
    """Unit vectors to the contacts. (k, 3)"""
    axles: np.ndarray
    """Unit vectors along the axles. (k, 3)"""
    radius: np.ndarray
    """(k,) [m]"""
    force: np.ndarray
    """Tangential, of each roller on the sphere. (k, 3) [N]"""
    limit: np.ndarray
    """Slip force at rest. (k,) [N]"""
    slip: np.ndarray
    """Demand over allowance. (k,)"""
    velocity: np.ndarray
    """Angular, of the sphere. (3,) [rad/s]"""
    kinds: tuple[str, ...]
    speeds: np.ndarray
    """Of shafts 1 and 2. (2,) [rad/s]"""
    torques: np.ndarray
    """Of shaft 1, by the source, and of shaft 2, on the load. (2,) [N m]"""
    angle: float
    """Of steering. [rad]"""

    @property
    def axis(self) -> np.ndarray:
        """Unit vector along the angular velocity. (3,)"""
        return self.velocity / np.linalg.norm(self.velocity)


def turned(ivt: SphericalIVT, point: SphericalPoint) -> Rollers:
    """Geometry and forces of one point of a machine, of `SphericalIVT.operate`.

    Raises
    ------
    InputError
        If there are many points, a roller slips, or the point is of another machine.
    """
    velocity = np.asarray(point.sphere_velocity)
    if velocity.shape != (3,) or not np.all(np.isfinite(velocity)) or not np.any(velocity):
        raise InputError("a sphere between rollers is drawn at one point, at which it turns and no roller slips")
    if point.kinds != ivt.kinds:
        raise InputError(f"ivt must be the machine of the point, with the rollers {', '.join(point.kinds)}")
    rollers = ivt.rollers
    contacts = [getattr(ivt, one.kind) for one in rollers]  # type: ignore[union-attr]
    normals = np.array([one.position for one in rollers])  # type: ignore[union-attr]
    axis = velocity / np.linalg.norm(velocity)
    # The axle of a steered roller is that part of the axis of the sphere which is tangential at the contact.
    steered = axis - (normals @ axis)[:, None] * normals
    fixed = [one.axis for one in rollers]  # type: ignore[union-attr]
    axles = np.array([own if own is not None else free for own, free in zip(fixed, steered, strict=True)])
    length = np.linalg.norm(axles, axis=1, keepdims=True)
    return Rollers(
        size=float(ivt.sphere_radius),
        normals=normals,
        axles=axles / np.where(length > 0, length, 1.0),
        radius=np.array([one.wheel_radius for one in contacts]),
        force=np.asarray(point.contact_force),
        limit=np.array([float(one.slip_force) for one in contacts]),
        slip=np.asarray(point.slip_demand),
        velocity=velocity,
        kinds=point.kinds,
        speeds=np.array([float(point.input_speed), float(point.output_speed)]),
        torques=np.array([float(point.input_torque), float(point.output_torque)]),
        angle=float(point.steering_angle),
    )


def picture(found: Rollers) -> Picture:
    """The sphere, its axis and equator, the rollers and their forces."""
    angle = quantity(math.degrees(found.angle), "°", 4)
    shafts = [
        (f"shaft {place + 1}", f"{quantity(torque, 'N m')} at {quantity(speed, 'rad/s')}")
        for place, (torque, speed) in enumerate(zip(found.torques, found.speeds, strict=True))
    ]
    names = [f"{place + 1}, {kind} roller" for place, kind in enumerate(found.kinds)]
    return Picture(
        title="Sphere between its rollers",
        heading="; ".join([f"{angle} of steering", *(f"{name}: {words}" for name, words in shafts)]),
        strokes=tuple(_strokes(found)),
        keys=(
            ("contact-force", "force of a roller on the sphere"),
            ("axis", "axis of the sphere"),
            ("equator", "its equator"),
        ),
        rows=(("steering angle", angle), *shafts, *slip_rows(names, found.force, found.slip)),
        notes=("the width of the rollers is not to scale",),
    )


def _strokes(found: Rollers) -> Iterator[Stroke]:
    see, size, axis = _VIEW, found.size, found.axis
    behind: list[Stroke] = []
    front: list[Stroke] = []
    for sign in (1.0, -1.0):
        line = Line(see(np.outer([size, 1.7 * size], sign * axis)), "axis")
        (front if see.toward(sign * axis) > 0 else behind).append(line)
    for place, normal in enumerate(found.normals):
        (front if see.toward(normal) > 0 else behind).extend(_roller(found, place))
    yield from behind
    yield from _ball(found)
    yield from front
    for place, normal in enumerate(found.normals):
        start, scale = size * normal, _LONGEST * size / float(np.max(found.limit))
        yield Arrow(see(start), see(start + scale * found.force[place]), "contact-force")
    for place in range(len(found.kinds)):
        yield from _label(found, place)


def _ball(found: Rollers) -> Iterator[Stroke]:
    """The sphere with marks on both sides of its equator, which turn."""
    see, size = _VIEW, found.size
    first = np.cross(found.axis, [0.3, -0.5, 0.8])
    first = first / np.linalg.norm(first)
    second = np.cross(found.axis, first)
    half = 0.3 * size * found.axis
    yield Line(size * CIRCLE, "steel", closed=True)
    # Of its equator the half in front.
    shown = math.atan2(see.toward(second), see.toward(first)) + np.linspace(-0.5 * np.pi, 0.5 * np.pi, 37)
    yield Line(size * see(np.cos(shown)[:, None] * first + np.sin(shown)[:, None] * second), "equator")
    near = 0.954 * size
    yield Turning(
        ends=(see(-half), see(half)),
        cosine=(see(near * first), see(near * first)),
        sine=(see(near * second), see(near * second)),
        rate=float(np.linalg.norm(found.velocity)),
        count=8,
        face=(see.toward(first), see.toward(second)),
    )


def _roller(found: Rollers, place: int) -> Iterator[Stroke]:
    """A roller with the end of its axle, and treads on its rim."""
    see, size = _VIEW, found.size
    normal, axle, radius = found.normals[place], found.axles[place], found.radius[place]
    hub, across, look = (size + radius) * normal, np.cross(axle, normal), f"roller-{found.kinds[place]}"
    disc, width = rim(hub, radius, normal, across), 0.35 * radius
    near = width if see.toward(axle) > 0 else -width
    yield Line(hull(see(np.concatenate([disc - near * axle, disc + near * axle]))), look, closed=True)
    yield Line(see(disc + near * axle), look, closed=True)
    yield Line(see(hub + np.outer([near, 2.2 * near], axle)), "carriage-line")
    yield Turning(
        ends=(see(hub - width * axle), see(hub + width * axle)),
        cosine=(see(radius * normal), see(radius * normal)),
        sine=(see(radius * across), see(radius * across)),
        # Where they touch, rim and sphere move alike, creep aside.
        rate=-float(np.cross(found.velocity, size * normal) @ across) / radius,
        count=8,
        look="tread",
        face=(see.toward(normal), see.toward(across)),
    )


def _label(found: Rollers, place: int) -> Iterator[Stroke]:
    """Number, kind and force of a roller, beside all, with a line to it."""
    see, size, normal, radius = _VIEW, found.size, found.normals[place], found.radius[place]
    far = see((size + 2.0 * radius) * normal)
    side = float(np.sign(np.round(far[0] / size, 6)) or 1.0)
    at = np.array([side * 2.1 * size, 1.05 * far[1] + (0.12 if far[1] >= 0 else -0.12) * size])
    yield Line(np.stack([see((size + radius) * normal), at]), "guide")
    force, share = share_of_slip(found.force[place], found.slip[place])
    anchor = "start" if side > 0 else "end"
    yield Label(at, f"{place + 1} {found.kinds[place]}: {force}", more=share, anchor=anchor)
