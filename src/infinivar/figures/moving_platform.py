"""Frames of a platform on rods in space, with its cylinder, wheels, and what guides its handle."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.analysis.moving_parts import Parts
from infinivar.analysis.sessions.guides import Line, Plane, Rod, Round, Shape, Solid, Track
from infinivar.figures import machine
from infinivar.figures.moving_flat import GUIDE, HANDLE, SLIPS, draw_force
from infinivar.machines.outline import OnRods

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_ROD, _LONGEST = "#9DB4C8", 0.22
_STRIPE = np.radians(60.0)
_ROUND = np.linspace(0.0, 2.0 * np.pi, 61)
_MOST_FACES = 3000
"""Of a mesh with all its edges; of others, some are left out."""


def data(parts: Parts, outline: OnRods, shapes: tuple[Shape, ...]) -> dict[str, Any]:
    """Numbers of a platform at its frames.

    Returns
    -------
    dict
        frames: as in `infinivar.figures.machine`, of each frame; turned (t,) or None [rad]; slips (t, n) or None; guides:
        polygons and lines (m, 3) with whether they are filled; handle (t, 3) [mm]; force (t, 3) or None, most [N].
    """
    platform, drum = outline.platform, outline.drum
    rods = outline.rods(parts.configuration)
    around = np.arctan2(platform.base[:, 1], platform.base[:, 0])
    flat = np.zeros_like(around)
    outward = np.stack([np.cos(around), np.sin(around), flat], axis=-1)
    along = np.stack([-np.sin(around), np.cos(around), flat], axis=-1)
    axis = np.array([0.0, 0.0, 1.0])
    radius, wide = (None, 0.1 * platform.rod_length) if drum is None else (drum.radius, drum.wheel_radius)
    links = rods.link_position
    ends = np.array([min(links.min(), *(platform.stroke or ())), max(links.max(), *(platform.stroke or ()))])
    span = float(np.mean(platform.base[:, 2])) + ends + np.array([-1.5, 1.5]) * wide
    frames = []
    for place, lower in enumerate(rods.lower):
        one = {
            "lower": 1e3 * lower,
            "upper": 1e3 * rods.upper[place],
            "outward": outward,
            "cylinder_radius": None if radius is None else 1e3 * radius,
            "wheel_radius": 1e3 * wide,
            "range": 1e3 * span,
        }
        if radius is not None:
            angle = parts.steering[place]
            one["wheel"] = 1e3 * (radius * outward + lower[:, 2:] * axis)
            one["rolling"] = np.cos(angle)[:, None] * along + np.sin(angle)[:, None] * axis
        frames.append(one)
    size = 1e3 * float(np.max(np.linalg.norm(platform.joints, axis=1)))
    return {
        "frames": frames,
        "turned": parts.cylinder_angle,
        "slips": None if drum is None else parts.sliding,
        "guides": [one for shape in shapes for one in _drawn(shape, 1e3 * parts.handle[0], size)],
        "handle": 1e3 * parts.handle,
        "force": parts.force,
        "most": 0.0 if parts.force is None else float(np.max(np.linalg.norm(parts.force, axis=1))),
        "bounds": _bounds(frames),
    }


def _bounds(frames: list[dict[str, Any]]) -> tuple[np.ndarray, np.ndarray]:
    """Corners around all frames, with room for the axes below and a force at the handle."""
    wide = frames[0]["wheel_radius"] * np.array([1.0, 1.0, 0.0])
    points = [one[name] for one in frames for name in ("lower", "upper")]
    rims = [np.array([[0.0, 0.0, end]]) for end in frames[0]["range"]]
    seen = machine.seen(np.concatenate([*points, *(one["lower"] + wide for one in frames), *rims]))
    low, high = seen.min(axis=0), seen.max(axis=0)
    size = float(np.max(high - low))
    return low - np.array([0.3, 0.3]) * size, high + np.array([0.12, 0.25]) * size


def _drawn(shape: Shape, start: np.ndarray, size: float) -> list[tuple[np.ndarray, bool]]:
    """Outlines (m, 3) of a shape near the handle [mm], and whether they are filled."""
    if isinstance(shape, Track):
        return [(1e3 * shape.points, False)]
    if isinstance(shape, Line):
        return [(1e3 * shape.point + 1.5 * size * np.outer([-1.0, 1.0], shape.direction), False)]
    if isinstance(shape, Plane):
        first, second = _across(shape.normal)
        foot = start - (start - 1e3 * shape.point) @ shape.normal * shape.normal
        square = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])
        return [(foot + 1.5 * size * square @ np.stack([first, second]), True)]
    if isinstance(shape, Round):
        return [(1e3 * shape.centre + 1e3 * shape.radius * _ring(machine.viewer()), True)]
    if isinstance(shape, Rod):
        way = 1.5 * size * shape.axis
        foot = 1e3 * shape.point + (start - 1e3 * shape.point) @ shape.axis * shape.axis
        rims = [foot + sign * way + 1e3 * shape.radius * _ring(shape.axis) for sign in (-1.0, 1.0)]
        return [
            *((rim, True) for rim in rims),
            *((np.stack([rims[0][one], rims[1][one]]), False) for one in range(0, 60, 10)),
        ]
    assert isinstance(shape, Solid)
    step = -(-len(shape.faces) // _MOST_FACES)
    return [(1e3 * shape.vertices[[*face, face[0]]], False) for face in shape.faces[::step]]


def _across(axis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    other = np.eye(3)[int(np.argmin(np.abs(axis)))]
    first = np.cross(axis, other)
    first = first / np.linalg.norm(first)
    return first, np.cross(axis, first)


def _ring(axis: np.ndarray) -> np.ndarray:
    first, second = _across(axis)
    return np.cos(_ROUND)[:, None] * first + np.sin(_ROUND)[:, None] * second


def draw(ax: Axes, numbers: Mapping[str, Any], place: int) -> None:
    """Draw the machine at a frame."""
    frame = numbers["frames"][place]
    slips = [False] * len(frame["lower"]) if numbers["slips"] is None else numbers["slips"][place]
    machine.draw_solid(ax, frame, [SLIPS if one else _ROD for one in slips])
    if numbers["turned"] is not None:
        _stripe(ax, frame, float(numbers["turned"][place]))
    for outline, filled in numbers["guides"]:
        flat = machine.seen(outline)
        if filled:
            ax.fill(*flat.T, fc=GUIDE, ec=GUIDE, alpha=0.25, lw=1.0, zorder=6.5)
        else:
            ax.plot(*flat.T, color=GUIDE, ls="--", lw=1.0, zorder=6.5)
    at = machine.seen(numbers["handle"][place])
    ax.plot(*at, marker="o", ms=6, color=HANDLE, mec="white", zorder=9)
    low, high = numbers["bounds"]
    if numbers["most"] > 0.0:
        scale = _LONGEST * float(np.max(high - low)) / numbers["most"]
        draw_force(ax, at, machine.seen(scale * numbers["force"][place]))
    machine.draw_frame(ax, numbers["frames"][0])
    ax.set_xlim(low[0], high[0])
    ax.set_ylim(low[1], high[1])
    ax.set_aspect("equal", adjustable="box")
    ax.set_axis_off()


def _stripe(ax: Axes, frame: Mapping[str, Any], turned: float) -> None:
    """Stripes of the surface, where they are in front."""
    for start, colour in ((0.0, "#9AA4AE"), (np.pi, "#BCC4CB")):
        around = turned + start + np.linspace(0.0, _STRIPE, 13)
        out = np.stack([np.cos(around), np.sin(around), 0.0 * around], axis=-1)
        front = out @ machine.viewer() >= 0.0
        if np.count_nonzero(front) < 2:
            continue
        rim = frame["cylinder_radius"] * out[front]
        low, high = (rim + np.array([0.0, 0.0, end]) for end in frame["range"])
        ax.fill(*machine.seen(np.concatenate([low, high[::-1]])).T, fc=colour, ec="none", alpha=0.8, zorder=2.05)
