"""A sphere between its rollers: axis of the sphere, rollers along their headings, and forces on the sphere."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from infinivar.errors import InputError
from infinivar.machines.pictures.geometry import CIRCLE, View, hull, normalised, rim
from infinivar.machines.pictures.strokes import Arrow, Label, Line, Picture, Stroke, Turning, treads
from infinivar.machines.pictures.words import length, quantity, share_of_slip, slip_rows
from infinivar.transmission.spherical import SphericalIVT, SphericalPoint

_VIEW = View(-38.0, 24.0)
_LONGEST = 1.1
"""Arrow of the slip limit over the radius of the sphere."""


class Rollers(NamedTuple):
    """Places of k rollers about a sphere; unit vectors to their contacts and along their axles (k, 3), radii (k,) [m]."""

    normals: np.ndarray
    axles: np.ndarray
    radius: np.ndarray


def placed(ivt: SphericalIVT, point: SphericalPoint) -> Rollers:
    """The rollers of a machine at one point of it, of `SphericalIVT.operate`.

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
    rollers, axis = ivt.rollers, normalised(velocity)
    normals = np.array([one.position for one in rollers])  # type: ignore[union-attr]
    # The axle of a steered roller is that part of the axis of the sphere which is tangential at the contact.
    steered = axis - (normals @ axis)[:, None] * normals
    fixed = [one.axis for one in rollers]  # type: ignore[union-attr]
    axles = np.array([own if own is not None else free for own, free in zip(fixed, steered, strict=True)])
    radius = np.array([getattr(ivt, kind).wheel_radius for kind in point.kinds])
    return Rollers(normals, normalised(axles), radius)


def picture(ivt: SphericalIVT, point: SphericalPoint) -> Picture:
    """The sphere, its axis and equator, the rollers and their forces; arguments and errors as in `placed`."""
    found = placed(ivt, point)
    angle = quantity(math.degrees(point.steering_angle), "°", 4)
    shafts = (
        ("shaft 1", f"{quantity(point.input_torque, 'N m')} at {quantity(point.input_speed, 'rad/s')}"),
        ("shaft 2", f"{quantity(point.output_torque, 'N m')} at {quantity(point.output_speed, 'rad/s')}"),
    )
    names = (f"{place}, {kind} roller" for place, kind in enumerate(point.kinds, 1))
    return Picture(
        title="Sphere between its rollers",
        heading="; ".join([f"{angle} of steering", *(f"{name}: {words}" for name, words in shafts)]),
        strokes=tuple(_strokes(ivt, point, found)),
        keys=(
            ("contact-force", "force of a roller on the sphere"),
            ("axis", "axis of the sphere"),
            ("equator", "its equator"),
        ),
        rows=(("steering angle", angle), *shafts, *slip_rows(names, point.contact_force, point.slip_demand)),
        notes=("the width of the rollers is not to scale",),
    )


def _strokes(ivt: SphericalIVT, point: SphericalPoint, found: Rollers) -> Iterator[Stroke]:
    see, size, velocity = _VIEW, float(ivt.sphere_radius), np.asarray(point.sphere_velocity)
    sides: dict[bool, list[Stroke]] = {False: [], True: []}
    for way in (normalised(velocity), -normalised(velocity)):
        sides[see.toward(way) > 0].append(Line(see(np.outer([size, 1.7 * size], way)), "axis"))
    for normal, axle, radius, kind in zip(*found, point.kinds, strict=True):
        sides[see.toward(normal) > 0] += _roller(size, normal, axle, radius, kind, velocity)
    yield from sides[False]
    yield from _ball(size, velocity)
    yield from sides[True]
    scale = _LONGEST * size / max(float(getattr(ivt, kind).slip_force) for kind in point.kinds)
    for normal, force in zip(found.normals, np.asarray(point.contact_force), strict=True):
        yield Arrow(see(size * normal), see(size * normal + scale * force), "contact-force")
    for place, (normal, radius) in enumerate(zip(found.normals, found.radius, strict=True)):
        words = f"{place + 1} {point.kinds[place]}: {length(point.contact_force[place], 'N')}"
        yield from _label(size, (size + radius) * normal, radius, words, share_of_slip(point.slip_demand[place]))


def _ball(size: float, velocity: np.ndarray) -> Iterator[Stroke]:
    """The sphere, with marks on both sides of its equator, which turn."""
    see, axis, near = _VIEW, normalised(velocity), 0.954 * size
    first = normalised(np.cross(axis, [0.3, -0.5, 0.8]))
    second, half = np.cross(axis, first), 0.3 * size * axis
    face = (see.toward(first), see.toward(second))
    yield Line(size * CIRCLE, "steel", closed=True)
    # Of its equator the half in front.
    shown = math.atan2(face[1], face[0]) + np.linspace(-0.5 * np.pi, 0.5 * np.pi, 37)
    yield Line(size * see(np.cos(shown)[:, None] * first + np.sin(shown)[:, None] * second), "equator")
    yield Turning(
        ends=(see(-half), see(half)),
        cosine=(see(near * first),) * 2,
        sine=(see(near * second),) * 2,
        rate=float(np.linalg.norm(velocity)),
        count=8,
        face=face,
    )


def _roller(
    size: float, normal: np.ndarray, axle: np.ndarray, radius: float, kind: str, velocity: np.ndarray
) -> Iterator[Stroke]:
    """A roller with the end of its axle, and treads on its rim."""
    see, hub, across, look = _VIEW, (size + radius) * normal, np.cross(axle, normal), f"roller-{kind}"
    disc, width = rim(hub, radius, normal, across), 0.35 * radius
    near = width if see.toward(axle) > 0 else -width
    yield Line(hull(see(np.concatenate([disc - near * axle, disc + near * axle]))), look, closed=True)
    yield Line(see(disc + near * axle), look, closed=True)
    yield Line(see(hub + np.outer([near, 2.2 * near], axle)), "carriage-line")
    # Where they touch, rim and sphere move alike, creep aside.
    rate = -float(np.cross(velocity, size * normal) @ across) / radius
    ends, face = (see(hub - width * axle), see(hub + width * axle)), (see.toward(normal), see.toward(across))
    yield treads(ends, (see(radius * normal),) * 2, (see(radius * across),) * 2, rate, face=face)


def _label(size: float, hub: np.ndarray, radius: float, words: str, more: str) -> Iterator[Stroke]:
    """Words beside all, with a line to a roller."""
    far = _VIEW(hub + radius * normalised(hub))
    side = float(np.sign(np.round(far[0] / size, 6)) or 1.0)
    at = np.array([side * 2.1 * size, 1.05 * far[1] + (0.12 if far[1] >= 0 else -0.12) * size])
    yield Line(np.stack([_VIEW(hub), at]), "guide")
    yield Label(at, words, more=more, anchor="start" if side > 0 else "end")
