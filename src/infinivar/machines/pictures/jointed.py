"""A planar arm from its base to its end point, with the torques of its joints."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np

from infinivar._core.fields import given
from infinivar.errors import InputError
from infinivar.machines.bodies import PlanarBody
from infinivar.machines.pictures.geometry import normalised, off, unit
from infinivar.machines.pictures.slides import Drum
from infinivar.machines.pictures.strokes import Arrow, Disc, Label, Line, Picture, Stroke
from infinivar.machines.pictures.words import length, part_rows, quantity

_ARROW = 0.3
"""Length of the arrows of force and velocity, over the length of the arm."""

_ALONG, _SHORT = 0.95, 0.6
"""Cosine of the angle between both arrows from which that of the force is shortened, and to what share."""


def points_of(lengths: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Base, joints and end point of members (n,) at joint angles (t, n). (t, n + 1, 2) [m]"""
    members = lengths[:, None] * unit(np.cumsum(angles, axis=-1))
    return np.concatenate([np.zeros((len(angles), 1, 2)), np.cumsum(members, axis=1)], axis=1)


@dataclass(frozen=True, slots=True, kw_only=True)
class Chain:
    """Members in a plane, each turning about the end of the one before, over pulleys.

    Attributes
    ----------
    lengths : (n,) float             Of the members. [m]
    members : n bodies               In axes from their joints along themselves.
    tip_mass, tip_inertia : float    [kg], [kg m^2]
    pulleys : (n,) float             Radii over which links move the joints. [m]
    link_mass : float                [kg]
    drum : Drum or None
    """

    shape: ClassVar[Literal["arm"]] = "arm"
    seen: ClassVar[Literal["above"]] = "above"

    lengths: np.ndarray
    members: Sequence[PlanarBody]
    tip_mass: float
    tip_inertia: float
    pulleys: np.ndarray
    link_mass: float
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


def picture(drive: Any, point: Any, pose: Any, twist: Any, wrench: Any) -> Picture:
    """An `infinivar.machines.ArmDrive` at one of its operating points: joints with torques, force and velocity of the end point.

    Parameters
    ----------
    drive : ArmDrive
    point : TaskPoint                  Of it.
    pose, twist, wrench : (d,) float   In its coordinates; the wrench on the load.

    Raises
    ------
    InputError
        If the point is not one within reach.
    """
    row, rate, load = (np.asarray(one, dtype=float) for one in (pose, twist, wrench))
    n, angles = len(drive.lengths), drive.angles(row)
    if row.shape != (n,) or not np.all(np.isfinite([*angles, *np.asarray(point.part_forces)])):
        raise InputError("an arm is drawn at one pose within reach, and does not reach this one")
    points = points_of(np.asarray(drive.lengths), angles[None])[0]
    end, pulley = points[-1], given(drive.pulley_radius, 0.0)
    force = load[:2] if n > 1 else np.zeros(2)
    velocity = rate[:2] if n > 1 else rate[0] * np.array([-end[1], end[0]])
    words = [length(force, "N")] * (n > 1) + [quantity(load[-1], "N m")] * (n != 2)
    turning = f", turning at {quantity(rate[-1], 'rad/s')}" if n != 2 and rate[-1] else ""
    degrees = (quantity(math.degrees(one), "°") for one in angles)
    return Picture(
        title="Arm, with the torques of its joints",
        axes=("x [m]", "y [m]"),
        strokes=(
            *members(points, pulley),
            *arrows(end, _reach(points), normalised(velocity), normalised(force)),
            *_labels(points, point, pulley),
        ),
        keys=(
            ("force", f"on the load: {', '.join(words)}"),
            ("velocity", f"velocity {length(velocity, 'm/s')}{turning}"),
        ),
        rows=(*part_rows(point), *((f"angle of joint {place}", one) for place, one in enumerate(degrees, 1))),
        notes=("circles at the joints are the pulleys, to scale",) if pulley else (),
        lever=pulley,
    )


def members(points: np.ndarray, pulley: float = 0.0) -> Iterator[Stroke]:
    """Base, and members and joints from base to end point (n + 1, 2), over pulleys of a radius."""
    reach = _reach(points)
    yield Line(np.array([[-0.08 * reach, 0.0], [0.08 * reach, 0.0]]), "base")
    if pulley:
        yield from (Disc(spot, pulley, "pulley") for spot in points[:-1])
    yield Line(points, "member")
    yield from joints(points[:-1], reach)


def joints(points: np.ndarray, reach: float) -> Iterator[Stroke]:
    """Joints at points (n, 2) of an arm of a length."""
    yield from (Disc(spot, 0.022 * reach, "joint") for spot in points)


def _reach(points: np.ndarray) -> float:
    """Length of all members. [m]"""
    return float(np.sum(np.linalg.norm(np.diff(points, axis=0), axis=1)))


def arrows(end: np.ndarray, reach: float, velocity: np.ndarray, force: np.ndarray) -> Iterator[Stroke]:
    """End point (2,) of an arm of a length, with its velocity and force: unit vectors as they are seen (2,), or 0."""
    yield Disc(end, 0.009 * reach, "point")
    hidden = float(normalised(velocity) @ normalised(force)) > _ALONG
    for look, vector, share in (("velocity", velocity, 1.0), ("force", force, _SHORT if hidden else 1.0)):
        if np.any(vector):
            yield Arrow(end, end + share * _ARROW * reach * vector, look)


def _labels(points: np.ndarray, point: Any, pulley: float) -> Iterator[Stroke]:
    """Torque of each joint on the load, with the largest demand on it."""
    for place, (spot, torque, part) in enumerate(zip(points[:-1], point.part_forces, point.parts, strict=True)):
        # Away from the members that meet there.
        near = (one for one in (place - 1, place + 1) if one >= 0)
        side = 1 if sum(points[one][1] - spot[1] for one in near) < 0.0 else -1
        at = off(spot, 0.0, side * max(1.2 * pulley, 0.04 * _reach(points)))
        words = f"joint {place + 1}: {quantity(torque, 'N m')}"
        yield Label(at, words, more=most(point.demands, part), rises=side)


def most(demands: Mapping[Any, Any], part: str) -> str:
    """Words for the largest demand on a part."""
    own = {limit: float(demand) for (limit, what), demand in demands.items() if what == part}
    known = {limit: demand for limit, demand in own.items() if np.isfinite(demand)}
    if not known:
        return ""
    worst = max(known, key=lambda limit: known[limit])
    return f"{100.0 * known[worst]:.0f} % of {worst.words}"
