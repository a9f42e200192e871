"""Where the handle of a session went, against the path or wall that guides it, in one plane or two."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.analysis.sessions.session_result import Session
from infinivar.figures import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_GRID = 161
"""Points along each side of the map of a wall."""

_AROUND = 0.15
"""Margin around the motion, over its extent."""

_ARROWS = 9
"""Forces drawn along the motion."""

_LONGEST = 0.22
"""Longest arrow over the extent."""


def data(run: Session) -> list[dict[str, Any]]:
    """Numbers of each plane drawn: x and y, or in space the two planes with the most motion; none of a handle on one axis.

    Returns
    -------
    list of dict
        axes: two names; moved (t, 2) [mm]; path (n, 2) [mm] or None; wall: None, or sides x (n,), y (n,) [mm] and distance (n, n)
        [mm]; arrows: tails (k, 2) [mm] and forces (k, 2) [N]; slips, touches: (m, 2) places where they begin [mm].
    """
    if len(run.axes) < 2:
        return []
    extent = np.ptp(run.position, axis=0)
    pairs = sorted(itertools.combinations(range(len(run.axes)), 2), key=lambda pair: -float(extent[list(pair)].sum()))
    return [_plane(run, list(pair)) for pair in pairs[: 1 if len(run.axes) == 2 else 2]]


def _plane(run: Session, pair: list[int]) -> dict[str, Any]:
    moved = 1e3 * run.position[:, pair]
    every = [moved]
    path = path_in(run, pair)
    every += [] if path is None else [path]
    low, high, size = bounds(np.concatenate(every))
    places = np.unique(np.linspace(0, len(run.time) - 1, _ARROWS).round().astype(int))
    return {
        "axes": [run.axes[one] for one in pair],
        "moved": moved,
        "path": path,
        "wall": wall_in(run, pair, low, high),
        "arrows": (moved[places], run.force[places][:, pair]),
        "size": size,
        "bounds": (low, high),
        "slips": _at(run, moved, run.slips),
        "touches": _at(run, moved, [touch.start for touch in run.touches]),
    }


def bounds(points: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """Corners of a drawing around points (n, 2), not too narrow, and the extent of the points."""
    low, high = np.min(points, axis=0), np.max(points, axis=0)
    size = max(float(np.max(high - low)), 1e-3)
    middle, half = 0.5 * (low + high), 0.5 * np.maximum(high - low, 0.4 * size) + _AROUND * size
    return middle - half, middle + half, size


def path_in(run: Session, pair: list[int]) -> np.ndarray | None:
    """Path in the plane of two axes. (n, 2) [mm]"""
    if run.path is None or not hasattr(run.path, "length"):
        return None
    curve = 1e3 * np.asarray(run.path.at(np.linspace(0.0, run.path.length, 400))[0])
    return curve[:, pair] if curve.shape[1] == len(run.axes) else None


def _at(run: Session, moved: np.ndarray, times: Any) -> np.ndarray:
    return np.array([[np.interp(time, run.time, column) for column in moved.T] for time in times]).reshape(-1, 2)


def wall_in(run: Session, pair: list[int], low: np.ndarray, high: np.ndarray) -> dict[str, Any] | None:
    """Distance from the wall in the plane of two axes, through the end of the session, between corners [mm]."""
    if run.wall is None:
        return None
    x, y = np.linspace(low[0], high[0], _GRID), np.linspace(low[1], high[1], _GRID)
    points = np.tile(run.position[-1], (_GRID, _GRID, 1))
    points[..., pair[0]], points[..., pair[1]] = np.meshgrid(1e-3 * x, 1e-3 * y)
    dimension = getattr(run.wall, "dimension", len(run.axes))
    flat = points.reshape(-1, len(run.axes))[:, :dimension]
    return {"x": x, "y": y, "distance": 1e3 * np.asarray(run.wall.distance(flat)).reshape(_GRID, _GRID)}


def draw(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw one plane."""
    moved = numbers["moved"]
    draw_guides(ax, numbers)
    ax.plot(*moved.T, color=style.COLOURS[0], label="handle")
    ax.plot(*moved[0], marker="o", ms=5, color="black", ls="none", label="start")
    tails, forces = numbers["arrows"]
    most = float(np.max(np.linalg.norm(forces, axis=1), initial=0.0))
    if most > 0.0:
        scale = _LONGEST * numbers["size"] / most
        for tail, force in zip(tails, forces, strict=True):
            if np.linalg.norm(force) > 0.02 * most:
                style.arrow(ax, tail - scale * force, tail, style.COLOURS[1], lw=0.9, size=7, zorder=3)
        ax.plot([], [], color=style.COLOURS[1], lw=0.9, label="user's force")
    for name, mark in (("slips", "x"), ("touches", "v")):
        if len(numbers[name]):
            words = "a wheel slips" if name == "slips" else "wall reached"
            ax.plot(*numbers[name][:1].T, marker=mark, ms=6, color="#B3400A", ls="none", label=words)
    frame(ax, numbers)


def frame(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Bound and label the plane of two axes."""
    low, high = numbers["bounds"]
    ax.set_xlim(low[0], high[0])
    ax.set_ylim(low[1], high[1])
    ax.set_aspect("equal", adjustable="box")
    ax.set_xlabel(f"{numbers['axes'][0]} [mm]")
    ax.set_ylabel(f"{numbers['axes'][1]} [mm]")


def draw_guides(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw wall and path."""
    wall, path = numbers["wall"], numbers["path"]
    if wall is not None and np.any(wall["distance"] < 0.0):
        ax.contourf(wall["x"], wall["y"], wall["distance"], levels=[-1e9, 0.0], colors=["#E3E6EA"], zorder=-1)
        if np.any(wall["distance"] > 0.0):
            ax.contour(wall["x"], wall["y"], wall["distance"], levels=[0.0], colors=["#6B7280"], linewidths=1.2)
        ax.plot([], [], color="#6B7280", lw=1.2, label="wall")
    if path is not None:
        ax.plot(*path.T, color="#6B7280", ls="--", lw=1.2, label="path")


def draw_all(run: Session) -> Figure | None:
    """Draw the planes side by side; None of a handle on one axis."""
    planes = data(run)
    if not planes:
        return None
    with style.styled():
        low, high = planes[0]["bounds"]
        shape = float((high[1] - low[1]) / (high[0] - low[0]))
        width = 7.4
        height = min(max(width / len(planes) * shape, 2.4), 5.2) + 0.9
        made, axes = style.figure(width, height, 1, len(planes), squeeze=False)
        for ax, numbers in zip(axes.ravel(), planes, strict=True):
            draw(ax, numbers)
        handles, labels = axes[0, 0].get_legend_handles_labels()
        made.legend(handles, labels, loc="outside lower center", ncols=min(len(labels), 3), fontsize=8)
    return made
