"""Efficiency on the force-speed plane with the requirement and the limits that bind (the form of Figs 15 and 16)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.analysis.compare import Comparison
from infinivar.analysis.steady_map import SteadyMap
from infinivar.analysis.uncertainty import BAND, BuildsMap
from infinivar.drivetrain.requirement import Requirement
from infinivar.figures import style
from infinivar.limits import Limit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

REQUIRED = {"color": "#D55E00", "lw": 1.5, "ls": "--"}
"""How the outline of the required region is drawn."""

LEVELS = np.arange(0.0, 1.01, 0.1)
_LINES = (0.2, 0.4, 0.5, 0.6, 0.65, 0.7, 0.75, 0.8, 0.85, 0.9)
_OUTSIDE = "#EDEDED"
_TEXT_HALF_SIZE = (0.10, 0.12)  # of the map's height and width: regions that hold less get no text
_WORDS = {
    Limit.SLIP: "beyond\nwheel slip",
    Limit.THERMAL: "beyond motor\ncontinuous\ntorque",
    Limit.VOLTAGE: "beyond\nsupply voltage",
    Limit.STEERING: "beyond\nsteering range",
    Limit.SPEED: "beyond\nmotor speed",
    Limit.GEAR: "beyond\ngearhead torque",
    Limit.PEAK: "beyond motor\npeak torque",
    Limit.REGENERATION: "cannot take\npower back",
}


def data(steady: SteadyMap, requirement: Requirement) -> dict[str, Any]:
    """Numbers of one map: axes, efficiency, limit codes, margin, and the outline of the requirement."""
    force = np.linspace(0.0, requirement.force, 200)
    outline = np.column_stack([np.append(force, [requirement.force]), np.append(requirement.speed_at(force), [0.0])])
    return {
        "force": steady.force,
        "speed": steady.speed,
        "efficiency": steady.efficiency,
        "limit": steady.limit,
        "margin": steady.margin,
        "outline": outline,
        "signs": {1: [(1, 1)], 2: [(1, 1), (-1, 1)], 4: [(1, 1), (-1, 1), (1, -1), (-1, -1)]}[requirement.quadrants],
    }


def draw(ax: Axes, numbers: Mapping[str, Any], title: str = "", builds: BuildsMap | None = None) -> Any:
    """Draw one map, with the band in which builds within tolerances have their limits; returns the filled contours."""
    force, speed, limit = numbers["force"], numbers["speed"], numbers["limit"]
    ax.set_facecolor(_OUTSIDE)
    within = np.where(limit == Limit.OK, numbers["efficiency"], np.nan)
    # White shows where the drive works but both ends feed the losses, so that efficiency means nothing.
    ax.contourf(force, speed, limit == Limit.OK, levels=[0.5, 1.5], colors=["white"])
    filled = ax.contourf(force, speed, within, levels=LEVELS, cmap="viridis", vmin=0.0, vmax=1.0)
    if np.isfinite(within).any():
        lines = ax.contour(force, speed, within, levels=_LINES, colors="white", linewidths=0.6)
        ax.clabel(lines, fmt="%.2g", fontsize=7)
    for code in np.unique(limit[limit != Limit.OK])[1:]:
        ax.contour(force, speed, limit == code, levels=[0.5], colors="#888888", linewidths=0.8, linestyles="dotted")
    # Infinite margins (nothing demanded) would spoil the interpolation of the boundary.
    margin = np.clip(numbers["margin"], 0.0, 2.0)
    if margin.min() < 1.0 < margin.max():
        ax.contour(force, speed, margin, levels=[1.0], colors="black", linewidths=1.4)
    if builds is not None and builds.within.min() < BAND[1] and builds.within.max() > BAND[0]:
        band = builds.force, builds.speed, builds.within
        ax.contourf(*band, levels=BAND, colors=["#D81B60"], alpha=0.35)
        ax.contour(*band, levels=BAND, colors="#D81B60", linewidths=0.7)
    for across, along in numbers["signs"]:
        x, y = numbers["outline"].T
        ax.fill(
            np.append(across * x, 0),
            np.append(along * y, 0),
            facecolor="none",
            hatch="////",
            edgecolor="#ffffff66",
            lw=0,
        )
        ax.plot(across * x, along * y, color="white", lw=2.6)
        ax.plot(across * x, along * y, **REQUIRED)
    _name_limits(ax, force, speed, limit)
    half = 0.5 * (force[1] - force[0]), 0.5 * (speed[1] - speed[0])  # axes hold the centres of cells
    ax.set_xlim(force[0] - half[0], force[-1] + half[0])
    ax.set_ylim(speed[0] - half[1], speed[-1] + half[1])
    ax.set_xlabel("force on the load [N]")
    ax.set_ylabel("speed of the load [m/s]")
    ax.set_title(title, parse_math=False)
    return filled


def colour_bar(made: Figure, filled: Any, beside: Any) -> None:
    """Add the scale of the efficiency beside one or several axes."""
    made.colorbar(filled, ax=beside, label="efficiency, useful over spent power [-]", ticks=LEVELS[::2])


def _name_limits(ax: Axes, force: np.ndarray, speed: np.ndarray, limit: np.ndarray) -> None:
    """Write each binding limit where its region is widest."""
    from scipy.ndimage import distance_transform_edt

    for code in np.unique(limit):
        if code == Limit.OK:
            continue
        # Distance to the edge of the region in units of the text's size; a frame keeps the text off the axes.
        cell = tuple(1.0 / (size * count) for size, count in zip(_TEXT_HALF_SIZE, limit.shape, strict=True))
        depth: Any = distance_transform_edt(np.pad(limit == code, 1), sampling=cell)
        depth = depth[1:-1, 1:-1]
        row, column = np.unravel_index(np.argmax(depth), depth.shape)
        if depth[row, column] < 1.0:
            continue
        ax.text(
            force[column], speed[row], _WORDS[Limit(int(code))], ha="center", va="center", fontsize=7.5, color="#333333"
        )


def draw_all(comparison: Comparison) -> Figure:
    """Maps of all drives of a comparison, side by side, with one colour bar."""
    results = list(comparison.results.values())
    columns = 2 if len(results) == 4 else min(3, len(results))
    rows = -(-len(results) // columns)
    with style.styled():
        made, axes = style.figure(
            3.5 * columns + 0.6, 3.0 * rows, rows, columns, squeeze=False, sharex=True, sharey=True
        )
        filled: Any = None
        for index, (ax, result) in enumerate(zip(axes.flat, results, strict=False)):
            drawn = comparison.builds.get(result.name)
            numbers = data(result.map, comparison.study.requirement)
            filled = draw(ax, numbers, result.title, None if drawn is None else drawn.map)
            ax.label_outer()
            if index + columns >= len(results):  # nothing below it
                ax.tick_params(labelbottom=True)
                ax.set_xlabel("force on the load [N]")
        for ax in axes.flat[len(results) :]:
            ax.set_visible(False)  # a removed one would still be asked to make room for the colour bar
        colour_bar(made, filled, axes[:, -1])
    return made
