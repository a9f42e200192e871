"""A planar arm from its base to its end point, with the torques of its joints."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np

from infinivar.errors import InputError
from infinivar.machines.pictures.slides import Drum
from infinivar.machines.pictures.strokes import (
    Arrow,
    Disc,
    Label,
    Line,
    Picture,
    Stroke,
    length_words,
    off,
    part_rows,
    quantity,
)

_ARROW = 0.3
"""Length of the arrows of force and velocity, over the length of the arm."""

_ALONG, _SHORT = 0.95, 0.6
"""Cosine of the angle between both arrows from which that of the force is shortened, and to what share."""


def points_of(lengths: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Base, joints and end point of members (n,) at joint angles (t, n). (t, n + 1, 2) [m]"""
    along = np.cumsum(angles, axis=-1)
    members = lengths[:, None] * np.stack([np.cos(along), np.sin(along)], axis=-1)
    return np.concatenate([np.zeros((len(angles), 1, 2)), np.cumsum(members, axis=1)], axis=1)


@dataclass(frozen=True, slots=True, kw_only=True)
class Chain:
    """Members in a plane, each turning about the end of the one before, over pulleys."""

    shape: ClassVar[Literal["arm"]] = "arm"
    seen: ClassVar[Literal["above"]] = "above"
    """Whether the plane of the handle is also that of its frames."""

    lengths: np.ndarray
    """(n,) [m]"""
    masses: np.ndarray
    """Of the members, which are uniform. (n,) [kg]"""
    tip_mass: float
    """[kg]"""
    tip_inertia: float
    """[kg m^2]"""
    pulleys: np.ndarray
    """Radii over which links move the joints. (n,) [m]"""
    link_mass: float
    """[kg]"""
    drum: Drum | None

    def points(self, angles: np.ndarray) -> np.ndarray:
        """Base, joints and end point at joint angles (t, n). (t, n + 1, 2) [m]"""
        return points_of(self.lengths, angles)

    def link_positions(self, configuration: np.ndarray) -> np.ndarray:
        """Of the links since their position 0. (t, n) [m]"""
        return self.pulleys * configuration

    def frames(
        self, configuration: np.ndarray, steering: np.ndarray, slips: np.ndarray, turned: np.ndarray | None
    ) -> Callable[[int], list[Stroke]]:
        """Members at a place among joint angles (t, n)."""
        points = self.points(configuration)
        return lambda place: list(members(points[place]))


@dataclass(frozen=True, slots=True, kw_only=True)
class Jointed:
    """An arm of n members at one point."""

    points: np.ndarray
    """Base, joints and end point. (n + 1, 2) [m]"""
    angles: np.ndarray
    """Of the joints. (n,) [rad]"""
    torque: np.ndarray
    """Of the joints on the load. (n,) [N m]"""
    loads: tuple[str, ...]
    """Words for the largest demand on each joint."""
    force: np.ndarray
    """Of the end point on the load. (2,) [N]"""
    velocity: np.ndarray
    """Of the end point. (2,) [m/s]"""
    moment: float
    """On the load. [N m]"""
    turning: float
    """[rad/s]"""

    @property
    def reach(self) -> float:
        """Length of all members. [m]"""
        return float(np.sum(np.linalg.norm(np.diff(self.points, axis=0), axis=1)))


def held(drive: Any, point: Any, pose: Any, twist: Any, wrench: Any) -> Jointed:
    """An `infinivar.ArmDrive` at an operating point of it, at a pose, twist and wrench (d,) in its coordinates.

    Raises
    ------
    InputError
        If the point is not one within reach, or has no steady motion.
    """
    row, rate, load = (np.asarray(one, dtype=float) for one in (pose, twist, wrench))
    n = len(drive.lengths)
    angles, torque = drive.angles(row), np.asarray(point.part_forces)
    if row.shape != (n,) or not np.all(np.isfinite([*angles, *torque])):
        raise InputError("an arm is drawn at one pose within reach, and does not reach this one")
    points = points_of(np.asarray(drive.lengths), angles[None])[0]
    across = np.array([-points[-1, 1], points[-1, 0]])
    return Jointed(
        points=points,
        angles=angles,
        torque=torque,
        loads=tuple(_most(point.demands, part) for part in point.parts),
        force=load[:2] if n > 1 else np.zeros(2),
        velocity=rate[:2] if n > 1 else rate[0] * across,
        moment=0.0 if n == 2 else float(load[-1]),
        turning=0.0 if n == 2 else float(rate[-1]),
    )


def _most(demands: Mapping[Any, Any], part: str) -> str:
    own = {limit: float(demand) for (limit, what), demand in demands.items() if what == part}
    known = {limit: demand for limit, demand in own.items() if np.isfinite(demand)}
    if not known:
        return ""
    worst = max(known, key=lambda limit: known[limit])
    return f"{100.0 * known[worst]:.0f} % of {worst.words}"


def picture(drive: Any, point: Any, pose: Any, twist: Any, wrench: Any) -> Picture:
    """Members and joints with their torques, and force and velocity of the end point; arguments as for `held`."""
    found = held(drive, point, pose, twist, wrench)
    n = len(found.torque)
    words = [length_words(found.force, "N")] * (n > 1) + [quantity(found.moment, "N m")] * (n != 2)
    turning = f", turning at {quantity(found.turning, 'rad/s')}" if found.turning else ""
    degrees = [quantity(math.degrees(one), "°") for one in found.angles]
    return Picture(
        title="Arm, with the torques of its joints",
        axes=("x [m]", "y [m]"),
        strokes=(*members(found.points, drive.pulley_radius), *_annotations(found, drive.pulley_radius)),
        keys=(
            ("force", f"on the load: {', '.join(words)}"),
            ("velocity", f"velocity {length_words(found.velocity, 'm/s')}{turning}"),
        ),
        rows=(*part_rows(point), *((f"angle of joint {place + 1}", one) for place, one in enumerate(degrees))),
        notes=("circles at the joints are the pulleys, to scale",),
        lever=drive.pulley_radius,
    )


def members(points: np.ndarray, pulley: float = 0.0) -> Iterator[Stroke]:
    """Base, and members and joints from base to end point (n + 1, 2), over pulleys of a radius."""
    reach = float(np.sum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
    yield Line(np.array([[-0.08 * reach, 0.0], [0.08 * reach, 0.0]]), "base")
    if pulley:
        yield from (Disc(spot, pulley, "pulley") for spot in points[:-1])
    yield Line(points, "member")
    yield from (Disc(spot, 0.022 * reach, "joint") for spot in points[:-1])


def _annotations(found: Jointed, pulley: float) -> Iterator[Stroke]:
    points, reach = found.points, found.reach
    end = points[-1]
    yield Disc(end, 0.009 * reach, "point")
    unit = {
        name: one / (float(np.linalg.norm(one)) or 1.0) for name, one in (("v", found.velocity), ("f", found.force))
    }
    hidden = float(unit["v"] @ unit["f"]) > _ALONG
    if np.any(found.velocity):
        yield Arrow(end, end + _ARROW * reach * unit["v"], "velocity")
    if np.any(found.force):
        yield Arrow(end, end + (_SHORT if hidden else 1.0) * _ARROW * reach * unit["f"], "force")
    for place, (spot, torque, load) in enumerate(zip(points[:-1], found.torque, found.loads, strict=True)):
        # Away from the members that meet there.
        near = (one for one in (place - 1, place + 1) if one >= 0)
        side = 1 if sum(points[one][1] - spot[1] for one in near) < 0.0 else -1
        at = off(spot, 0.0, side * max(1.2 * pulley, 0.04 * reach))
        yield Label(at, f"joint {place + 1}: {quantity(torque, 'N m')}", more=load, rises=side)
