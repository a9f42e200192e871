"""Frames of machines: the plane in which the handle moves, a slide from its side, and its history."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.analysis.moving_parts import Parts
from infinivar.analysis.sessions.guides import Line, Plane, Shape, Track
from infinivar.analysis.sessions.session_result import Session
from infinivar.figures import session_motion, style
from infinivar.figures.pictures import SLIPS
from infinivar.machines.pictures.slides import Drum

if TYPE_CHECKING:
    from matplotlib.axes import Axes

HANDLE, FORCE, GUIDE = style.COLOURS[0], style.COLOURS[1], "#6B7280"
"""Colours of the handle's trace, of the user's force, and of what guides it."""

_LONGEST = 0.25
"""Longest arrow of force over the extent of the drawing."""

_STRIPE = np.radians(60.0)
"""Of the surface of a cylinder, drawn dark, to see it turn."""

_ACROSS = 0.25
"""Half-width of a wheel seen from outside, over its radius."""


def in_plane(
    run: Any, parts: Parts, trace: np.ndarray, pair: list[int], around: np.ndarray, shapes: Any
) -> dict[str, Any]:
    """Numbers of the plane of two axes of the handle.

    Parameters
    ----------
    run : Session or MachineRun
    parts : Parts                  At the frames.
    trace : (r, d) float           Handle at all results. [m]
    pair : list of int             Places of the axes.
    around : (n, 2) float          Points that the drawing includes beside trace and path. [mm]
    shapes : sequence of Shape     Of what guides the handle.

    Returns
    -------
    dict   axes: names; trace (r, 2), handle (t, 2), path (n, 2) or None, lines: (m, 2) each, bounds, and push: arrows of the
        user's force (t, 2), or None [mm]; wall as in `infinivar.figures.session_motion`.
    """
    guided = isinstance(run, Session)
    path = session_motion.path_in(run, pair) if guided else None
    moved = 1e3 * trace[:, pair]
    every = [moved, around.reshape(-1, 2), *([] if path is None else [path])]
    force = None if parts.force is None else parts.force[:, pair]
    most = 0.0 if force is None else float(np.max(np.linalg.norm(force, axis=1)))
    low, high, _ = session_motion.bounds(np.concatenate(every))
    handle = 1e3 * parts.handle[:, pair]
    push = None
    if force is not None and most > 0.0:
        # With room for the arrow of the force in every frame.
        push = _LONGEST * float(np.max(high - low)) / most * force
        low, high, _ = session_motion.bounds(np.concatenate([*every, handle - push]))
    return {
        "axes": [parts.axes[one] for one in pair],
        "trace": moved,
        "handle": handle,
        "push": push,
        "path": path,
        "wall": session_motion.wall_in(run, pair, low, high) if guided else None,
        "lines": [line for shape in shapes for line in _line(shape, pair, float(np.linalg.norm(high - low)))]
        if path is None
        else [],
        "bounds": (low, high),
    }


def _line(shape: Shape, pair: list[int], length: float) -> list[np.ndarray]:
    """Line or curve of a fixture in the plane of two axes, or the line in which a plane across them cuts it. [mm]"""
    if max(pair) > 2:
        return []
    if isinstance(shape, Track):
        return [1e3 * shape.points[:, pair]]
    if isinstance(shape, Line):
        way = shape.direction[pair]
    elif isinstance(shape, Plane) and not shape.solid and np.linalg.norm(shape.normal[pair]) > 1.0 - 1e-9:
        way = np.array([-shape.normal[pair][1], shape.normal[pair][0]])
    else:
        return []
    return [1e3 * shape.point[pair] + np.outer([-length, length], way)]


def draw_plane(ax: Axes, numbers: Mapping[str, Any], place: int, upto: int) -> None:
    """Draw what guides the handle, its trace up to a result, and handle and force of a frame."""
    session_motion.draw_guides(ax, numbers)
    for line in numbers["lines"]:
        ax.plot(*line.T, color=GUIDE, ls="--", lw=1.2)
    ax.plot(*numbers["trace"][:upto].T, color=HANDLE, lw=1.4, zorder=4)
    ax.plot(*numbers["handle"][place], marker="o", ms=6, color=HANDLE, mec="white", zorder=6)
    if numbers["push"] is not None:
        draw_force(ax, numbers["handle"][place], numbers["push"][place])
    session_motion.frame(ax, numbers)


def draw_force(ax: Axes, head: np.ndarray, along: np.ndarray) -> None:
    """Draw an arrow that pushes the handle."""
    if np.any(along):
        style.arrow(ax, head - along, head, FORCE, lw=2.0, size=12, gap=3, zorder=7, annotation_clip=False)


def slide(parts: Parts, drum: Drum | None, shapes: Any) -> dict[str, Any]:
    """Numbers of a slide.

    Returns
    -------
    dict   axes: names; position (t, n) [mm]; steering (t, n) or None; slips (t, k); turned (t,) or None [rad]; cylinder_radius,
        wheel_radius [mm]; range: least and largest position drawn [mm]; wall: None, or position [mm] and way (1 or -1) to its
        free side, of a handle on one axis; force (t, n) or None, most [N].
    """
    position = 1e3 * parts.configuration
    radius, wheel = (12.0, 12.0) if drum is None else (1e3 * drum.radius, 1e3 * drum.wheel_radius)
    walls = [
        (1e3 * float(one.point[0]), float(np.sign(one.normal[0])))
        for one in shapes
        if isinstance(one, Plane) and one.solid and len(parts.axes) == 1
    ]
    shown = np.concatenate([position.ravel(), [place for place, _ in walls]])
    room = max(0.6 * float(np.ptp(shown)), 3.0 * wheel, 2.0 * radius)
    return {
        "axes": parts.axes,
        "position": position,
        "steering": None if drum is None else parts.steering,
        "slips": parts.sliding,
        "turned": parts.cylinder_angle,
        "cylinder_radius": radius,
        "wheel_radius": wheel,
        "range": (float(shown.min()) - room, float(shown.max()) + room),
        "wall": walls[0] if walls else None,
        "force": parts.force,
        "most": 0.0 if parts.force is None else float(np.max(np.abs(parts.force))),
    }


def draw_slide(ax: Axes, numbers: Mapping[str, Any], place: int, axis: int) -> None:
    """Draw cylinder or rail, wheel, carriage, handle, wall and force of one axis at a frame."""
    from matplotlib.patches import Rectangle

    low, high = numbers["range"]
    radius, wheel, at = numbers["cylinder_radius"], numbers["wheel_radius"], float(numbers["position"][place, axis])
    top, inset = radius + 1.6 * wheel, 0.06 * (high - low)
    if numbers["wall"] is not None:
        edge, way = numbers["wall"]
        beyond = (low, edge) if way > 0 else (edge, high)
        ax.add_patch(
            Rectangle((beyond[0], radius + 0.4 * wheel), beyond[1] - beyond[0], 2.6 * wheel, fc="#D4D9DF", ec="none")
        )
        ax.plot([edge, edge], [radius + 0.4 * wheel, radius + 3.0 * wheel], color=GUIDE, lw=1.6)
    if numbers["steering"] is None:
        ax.add_patch(
            Rectangle((low + inset, -0.15 * radius), high - low - 2 * inset, 0.3 * radius, fc="#B9C0C7", ec="#555555")
        )
        half = np.array([0.8 * wheel, 0.5 * wheel])
        ax.add_patch(Rectangle((at - half[0], -half[1]), *(2.0 * half), fc="#6C7A89", ec="black", lw=0.8, zorder=3))
    else:
        ax.add_patch(
            Rectangle((low + inset, -radius), high - low - 2 * inset, 2 * radius, fc="#E3E6EA", ec="#555555", lw=0.8)
        )
        _stripe(ax, numbers, place, axis, (low + inset, high - inset))
        angle = float(numbers["steering"][place, axis])
        along, across = np.array([np.sin(angle), -np.cos(angle)]), np.array([np.cos(angle), np.sin(angle)])
        corners = [one * wheel * along + other * _ACROSS * wheel * across for one, other in _CORNERS]
        slips = bool(numbers["slips"][place, axis])
        ax.fill(
            *(np.array(corners) + np.array([at, 0.0])).T, fc=SLIPS if slips else "black", ec="white", lw=0.6, zorder=5
        )
    ax.plot([at, at], [0.0, top], color="#56646F", lw=3.0, solid_capstyle="butt", zorder=2)
    ax.plot(at, top, marker="o", ms=9, color=HANDLE, mec="white", zorder=6)
    if numbers["most"] > 0.0:
        push = _LONGEST * (high - low) * float(numbers["force"][place, axis]) / numbers["most"]
        draw_force(ax, np.array([at, top]), np.array([push, 0.0]))
    ax.set_xlim(low, high)
    ax.set_ylim(-1.15 * radius, radius + 3.0 * wheel)
    ax.set_aspect("equal", adjustable="box")
    ax.set_xlabel(f"along {numbers['axes'][axis]} [mm]")
    ax.set_ylabel("across [mm]")


_CORNERS = ((1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0))


def _stripe(ax: Axes, numbers: Mapping[str, Any], place: int, axis: int, ends: tuple[float, float]) -> None:
    """A dark stripe of the surface, which moves down in front as the cylinder turns; seen from another side for each axis."""
    from matplotlib.patches import Rectangle

    seen_from = 2.0 * np.pi * axis / len(numbers["axes"])
    first = seen_from - float(numbers["turned"][place])
    for turn in (0.0, np.pi):
        # From the middle of the front, -pi to pi; what is behind is not seen.
        start = (first + turn + np.pi) % (2.0 * np.pi) - np.pi
        for shift in (0.0, -2.0 * np.pi):
            low, high = np.clip([start + shift, start + shift + _STRIPE], -0.5 * np.pi, 0.5 * np.pi)
            if high > low:
                y = numbers["cylinder_radius"] * np.sin([low, high])
                colour = "#AEB6BE" if turn == 0.0 else "#CBD1D6"
                ax.add_patch(Rectangle((ends[0], y[0]), ends[1] - ends[0], y[1] - y[0], fc=colour, ec="none", zorder=1))


def draw_history(ax: Axes, numbers: Mapping[str, Any], place: int, upto: int) -> None:
    """Draw the positions of the axes over time, up to a result."""
    time, trace = numbers["known"], numbers["history"]
    for axis, (name, values) in enumerate(zip(numbers["axes"], trace.T, strict=True)):
        colour = style.COLOURS[(0, 2, 3, 4, 5, 6)[axis % 6]]
        ax.plot(time, values, color=colour, lw=0.8, alpha=0.35)
        ax.plot(time[:upto], values[:upto], color=colour, label=name)
        ax.plot(numbers["time"][place], numbers["position"][place, axis], marker="o", ms=5, color=colour)
    if numbers["wall"] is not None:
        ax.axhline(numbers["wall"][0], color=GUIDE, lw=1.2)
    if trace.shape[1] > 1:
        style.name_beside(ax, fontsize=8)
    shown = np.append(trace, [] if numbers["wall"] is None else numbers["wall"][0])
    room = 0.05 * float(np.ptp(shown)) or 1.0
    ax.locator_params(axis="x", nbins=5)
    ax.set_xlim(time[0], max(time[-1], time[0] + 1e-9))
    ax.set_ylim(float(shown.min()) - room, float(shown.max()) + room)
    ax.set_xlabel("time [s]")
    ax.set_ylabel("handle [mm]")
