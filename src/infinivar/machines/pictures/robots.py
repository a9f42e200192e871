"""An arm in space from its base to its tool, with the axes and torques of its joints."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np

from infinivar._core.fields import given
from infinivar.errors import InputError
from infinivar.machines.bodies import SpatialBody
from infinivar.machines.pictures.geometry import normalised, off, round_number
from infinivar.machines.pictures.jointed import arrows, joints, most
from infinivar.machines.pictures.rods import VIEW, axes
from infinivar.machines.pictures.slides import Drum
from infinivar.machines.pictures.strokes import Arrow, Disc, Label, Line, Picture, Stroke, bounds
from infinivar.machines.pictures.words import length, part_rows, quantity
from infinivar.motion.vectors import ROTATIONS, TRANSLATIONS
from infinivar.transmission.turning_chain import TurningChain

_PLATE = np.array([(1.0, 1.0, 0.0), (1.0, -1.0, 0.0), (-1.0, -1.0, 0.0), (-1.0, 1.0, 0.0)])
_AXIS, _BASE, _PAYLOAD = 0.08, 0.09, 0.03
"""Half of a line along the axis of a joint, half of the base, and radius of a payload, over the length of the arm."""

_APART, _BESIDE, _FRAME = 0.17, 0.1, 0.25
"""Words beside the arm from each other, and from the arm; and its largest axes; over the extent of the arm."""

_ROUNDING = 1e-9
"""Torque or rate over the largest one, below which it is rounding."""


class Spots(NamedTuple):
    """Base, n joints and tool of an arm in space at t instants: (t, n + 2, 3) [m]; unit vectors along axes (t, n, 3)."""

    points: np.ndarray
    axes: np.ndarray


def spots_of(chain: TurningChain, angles: np.ndarray) -> Spots:
    """Where an arm is at joint angles (t, n)."""
    at = chain.standing(angles)
    tool = chain.tool(at)[0]
    return Spots(np.stack([0.0 * tool, *at.place, tool], axis=1), np.stack(at.axis, axis=1))


@dataclass(frozen=True, slots=True, kw_only=True)
class TurningMembers:
    """Members in space, each turning about an axis of the one before, over pulleys.

    Attributes
    ----------
    chain : TurningChain
    members : n bodies     With what the last one carries, in axes of their joints.
    pulleys : (n,) float   Radii over which links move the joints. [m]
    link_mass : float      [kg]
    drum : Drum or None
    """

    shape: ClassVar[Literal["robot"]] = "robot"
    seen: ClassVar[Literal["space"]] = "space"

    chain: TurningChain
    members: Sequence[SpatialBody]
    pulleys: np.ndarray
    link_mass: float
    drum: Drum | None

    def link_positions(self, configuration: np.ndarray) -> np.ndarray:
        """Of the links since their position 0. (t, n) [m]"""
        return self.pulleys * configuration

    def frames(
        self, configuration: np.ndarray, steering: np.ndarray, slips: np.ndarray, turned: np.ndarray | None
    ) -> Callable[[int], list[Stroke]]:
        """Members at a place among joint angles (t, n)."""
        found = spots_of(self.chain, configuration)
        return lambda place: list(arm(found.points[place], found.axes[place], self.chain.reach))


def picture(drive: Any, point: Any, pose: Any, twist: Any, wrench: Any) -> Picture:
    """An `infinivar.machines.RobotDrive` at one of its operating points: torques of joints, force and velocity of the tool.

    Parameters
    ----------
    drive : RobotDrive
    point : TaskPoint                  Of it.
    pose, twist, wrench : (d,) float   In its coordinates; the wrench on the load.

    Raises
    ------
    InputError
        If the point is not one within reach.
    """
    row, load = np.asarray(pose, dtype=float), dict(zip(drive.coordinates, np.asarray(wrench, float), strict=True))
    angles, torques = drive.angles(row), np.asarray(point.part_forces, dtype=float)
    if row.shape != (drive.links,) or not np.all(np.isfinite([*angles, *torques])):
        raise InputError("a robot is drawn at one pose within reach, and does not reach this one")
    torques = _rounded(torques)
    chain, found = drive.chain, spots_of(drive.chain, angles[None])
    at = chain.standing(angles[None])
    motion = _rounded(chain.jacobian(at)[0] @ np.asarray(point.part_speeds, dtype=float))
    force, moment = (np.array([load.get(axis, 0.0) for axis in some]) for some in (TRANSLATIONS, ROTATIONS))
    payload = None
    if drive.payload_mass:
        place, turn = (one[0] for one in chain.tool(at))
        payload = place + turn @ np.array(drive.payload_centre or (0.0, 0.0, 0.0))
    points, reach = found.points[0], chain.reach
    drawn = [*arm(points, found.axes[0], reach)]
    rows = [*part_rows(replace(point, part_forces=torques))]
    shares = [most(point.demands, part) for part in point.parts]
    callouts = [
        (VIEW(spot), f"{part}: {quantity(torque, 'N m')}", share)
        for spot, part, torque, share in zip(points[1:-1], point.parts, torques, shares, strict=True)
    ]
    if payload is not None:
        drawn.append(Disc(VIEW(payload), _PAYLOAD * reach, "platform"))
        callouts.append((VIEW(payload), "payload", quantity(drive.payload_mass, "kg")))
    ways = (VIEW(normalised(one)) for one in (motion[:3], force))
    drawn += arrows(VIEW(points[-1]), reach, *ways)
    turning = f", turning at {length(motion[3:], 'rad/s')}" if np.any(motion[3:]) else ""
    moments = f", {length(moment, 'N m')}" if np.any(moment) else ""
    degrees = (quantity(math.degrees(one), "°") for one in _rounded(angles))
    names = (f"angle of {part}, {name}" for part, name in zip(point.parts, chain.names, strict=True))
    beside = [*_callouts(drawn, callouts)]
    lines, words = ([one for one in beside if isinstance(one, kind)] for kind in (Line, Label))
    return Picture(
        title="Robot, with the torques of its joints",
        strokes=(*lines, *drawn, *words, *_frame(drawn, drive.gravity)),
        keys=(
            ("force", f"on the load: {length(force, 'N')}{moments}"),
            *([("velocity", f"velocity {length(motion[:3], 'm/s')}{turning}")] if np.any(motion) else []),
            ("axis", "axes of the joints"),
            *([("gravity", f"gravity, {length(drive.gravity, 'm/s²')}")] if np.any(drive.gravity) else []),
        ),
        rows=(
            *((name, ", ".join(filter(None, (said, share)))) for (name, said), share in zip(rows, shares, strict=True)),
            *zip(names, degrees, strict=True),
        ),
        notes=("members are drawn as straight lines between the joints",),
        lever=given(drive.pulley_radius, 0.0),
    )


def traced(shown: Picture, drive: Any, paths: Mapping[str, np.ndarray]) -> Picture:
    """A picture with the paths of the tool that are within reach, at poses (t, d) by their titles."""
    turned = {title: drive.angles(pose) for title, pose in paths.items()}
    within = {title: angles for title, angles in turned.items() if np.all(np.isfinite(angles))}
    if not within:
        return shown
    lines = (Line(VIEW(spots_of(drive.chain, angles).points[:, -1]), "track") for angles in within.values())
    words = f"path{'s' * (len(within) > 1)} of the tool: {', '.join(within)}"
    return replace(shown, strokes=(*shown.strokes, *lines), keys=(*shown.keys, ("track", words)))


def arm(points: np.ndarray, axes: np.ndarray, reach: float) -> Iterator[Stroke]:
    """Base, members and joints from base to tool (n + 2, 3), with axes of the joints (n, 3), of an arm of a length."""
    yield Line(VIEW(_BASE * reach * _PLATE), "plate", closed=True)
    yield Line(VIEW(points), "member")
    for spot, axis in zip(points[1:-1], axes, strict=True):
        yield Line(VIEW(spot + np.outer([-_AXIS * reach, _AXIS * reach], axis)), "axis")
    yield from joints(VIEW(points[1:-1]), reach)


def _callouts(drawn: list[Stroke], words: list[tuple[np.ndarray, str, str]]) -> Iterator[Stroke]:
    """Words in columns to the left and right of all that is drawn, with lines to the places (2,) that they are about."""
    low, high = bounds(drawn)
    extent = float(np.max(high - low))
    order = sorted(words, key=lambda one: one[0][0])
    half = (len(order) + 1) // 2
    for column, side in ((order[:half], -1), (order[half:], 1)):
        across = (high[0] if side > 0 else low[0]) + side * _BESIDE * extent
        column = sorted(column, key=lambda one: one[0][1])
        heights = _spread([one[0][1] for one in column], _APART * extent, low[1])
        for (spot, said, more), height in zip(column, heights, strict=True):
            at = np.array([across, height])
            yield Line(np.stack([spot, at]), "guide")
            yield Label(at, said, more=more, anchor="start" if side > 0 else "end")


def _spread(heights: list[float], apart: float, low: float) -> np.ndarray:
    """Heights of words in ascending order moved apart, about their mean, with all words above a lowest."""
    gap = apart * np.arange(len(heights))
    found = np.maximum.accumulate(np.array(heights) - gap) + gap
    if not len(found):
        return found
    found = found + np.mean(heights) - np.mean(found)
    return found + max(low + 0.5 * apart - found[0], 0.0)


def _rounded(values: np.ndarray) -> np.ndarray:
    """Values with 0 for those that are rounding beside the largest."""
    return np.where(np.abs(values) > _ROUNDING * np.abs(values).max(), values, 0.0)


def _frame(drawn: list[Stroke], gravity: Any) -> Iterator[Stroke]:
    """Axes x, y and z with a scale below all that is drawn, and beside them the direction of gravity."""
    low, high = bounds(drawn)
    extent = float(np.max(high - low))
    size = round_number(_FRAME * extent)
    start = np.array([low[0] - 0.75 * size, low[1] - size])
    yield from axes(start, size, start[0] + 1.6 * size)
    if np.any(gravity):
        way = 0.6 * size * VIEW(normalised(gravity))
        middle = np.array([high[0], start[1] + 0.2 * size])
        yield Arrow(middle - 0.5 * way, middle + 0.5 * way, "gravity")
        yield Label(off(middle, 0.15 * size, 0.0), "g", anchor="start")
