"""Frames of a machine in space: its handle, the force there, and what guides it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.analysis.moving_parts import Parts
from infinivar.analysis.sessions.guides import Line, Plane, Rod, Round, Shape, Solid, Track
from infinivar.figures.moving_flat import GUIDE, HANDLE, draw_force
from infinivar.machines.pictures.geometry import CIRCLE
from infinivar.machines.pictures.rods import VIEW

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LONGEST, _GUIDE = 0.22, 0.12
"""Longest arrow of force, and size of a guide, over that of the drawing."""

_MOST_FACES = 3000
"""Of a mesh with all its edges; of others, some are left out."""


def data(parts: Parts, shapes: tuple[Shape, ...], low: np.ndarray, high: np.ndarray) -> dict[str, Any]:
    """Numbers of a handle in space at the frames of a machine that is seen between two corners (2,). [mm]

    Returns
    -------
    dict
        guides: polygons and lines (m, 3) with whether they are filled; handle (t, 3), bounds [mm]; force (t, 3) or None, most [N]
    """
    size, handle = float(np.max(high - low)), 1e3 * parts.handle
    return {
        "guides": [one for shape in shapes for one in _drawn(shape, handle[0], _GUIDE * size)],
        "handle": handle,
        "force": parts.force,
        "most": 0.0 if parts.force is None else float(np.max(np.linalg.norm(parts.force, axis=1))),
        # With room for a force at the handle.
        "bounds": (low - 0.05 * size, high + np.array([0.12, 0.25]) * size),
    }


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
        return [(1e3 * shape.centre + 1e3 * shape.radius * _ring(VIEW.viewer), True)]
    if isinstance(shape, Rod):
        way = 1.5 * size * shape.axis
        foot = 1e3 * shape.point + (start - 1e3 * shape.point) @ shape.axis * shape.axis
        rims = [foot + sign * way + 1e3 * shape.radius * _ring(shape.axis) for sign in (-1.0, 1.0)]
        return [
            *((rim, True) for rim in rims),
            *((np.stack([rims[0][one], rims[1][one]]), False) for one in range(0, 72, 12)),
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
    return CIRCLE @ np.stack(_across(axis))


def draw(ax: Axes, numbers: Mapping[str, Any], place: int) -> None:
    """Draw handle, force and what guides it at a frame, over the machine."""
    for outline, filled in numbers["guides"]:
        flat = VIEW(outline)
        if filled:
            ax.fill(*flat.T, fc=GUIDE, ec=GUIDE, alpha=0.25, lw=1.0, zorder=6.5)
        else:
            ax.plot(*flat.T, color=GUIDE, ls="--", lw=1.0, zorder=6.5)
    at = VIEW(numbers["handle"][place])
    ax.plot(*at, marker="o", ms=6, color=HANDLE, mec="white", zorder=9)
    low, high = numbers["bounds"]
    if numbers["most"] > 0.0:
        scale = _LONGEST * float(np.max(high - low)) / numbers["most"]
        draw_force(ax, at, VIEW(scale * numbers["force"][place]))
    ax.set_xlim(low[0], high[0])
    ax.set_ylim(low[1], high[1])
    ax.set_aspect("equal", adjustable="box")
    ax.set_axis_off()
