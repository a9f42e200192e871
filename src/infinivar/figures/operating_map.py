"""Efficiency on the force-speed plane with the requirement and the limits exceeded (the form of Figs 15 and 16).

Where the load drives and the supply gets nothing back, efficiency is zero or means nothing: the loss is drawn there.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from infinivar._core.array_namespace import Array, namespace
from infinivar.analysis.compare import Comparison
from infinivar.analysis.robustness.verdicts import BAND, BuildsMap
from infinivar.analysis.steady_map import SteadyMap
from infinivar.figures import style
from infinivar.limits import Limit
from infinivar.study.requirement import Requirement
from infinivar.units import plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

REQUIRED: dict[str, Any] = {"color": "#D55E00", "lw": 1.5, "ls": "--"}
"""Line style of the outline of the required region."""

LEVELS = np.arange(0.0, 1.01, 0.1)
_LINES = (0.2, 0.4, 0.5, 0.6, 0.65, 0.7, 0.75, 0.8, 0.85, 0.9)
CLEAR = 2.0
"""Margin above which it does not matter how large it is: infinite ones would spoil the interpolation of the boundary."""
_LOSS_STEPS, _LOSS_REACH = 7, 1.5
"""Approximate number of loss levels, and their upper end as a multiple of the largest loss in the required region."""
_LOSS_COLOURS = ("YlOrBr", 0.02, 0.62)
"""Pale part of a colour map, distinct from the colours of efficiency and from the outline of the required region."""
_OUTSIDE = "#EDEDED"
_TEXT_HALF_SIZE = (0.08, 0.125)  # of the map's height and width: regions that hold less get no text
WORDS = {
    Limit.SLIP: "beyond\nwheel slip",
    Limit.THERMAL: "beyond motor\ncontinuous\ntorque",
    Limit.VOLTAGE: "beyond\nsupply voltage",
    Limit.STEERING: "beyond\nsteering range",
    Limit.SPEED: "beyond\nmotor speed",
    Limit.GEAR: "beyond\ngearhead torque",
    Limit.PEAK: "beyond motor\npeak torque",
    Limit.REGENERATION: "supply cannot\nabsorb power",
}


def words_of(limit: Limit) -> str:
    """Label of the region where a limit is exceeded."""
    return WORDS.get(limit, "beyond\n" + limit.words.replace(" ", "\n"))


class Drawn(NamedTuple):
    """Filled contours of a map, for colour bars: efficiency, and loss where drawn."""

    efficiency: Any
    loss: Any = None


def data(steady: SteadyMap, requirement: Requirement | None) -> dict[str, Any]:
    """Numbers of one map, with or without a required region.

    Returns
    -------
    dict
        axis: along a line or about a joint; force [N], speed [m s^-1], or [N m], [rad s^-1]: axes of the map; limit, margin:
        as of the map; efficiency (n, m) [-]: nan beyond limits, and where the load drives and the supply gets nothing back;
        loss (n, m) [W]: there, else nan; outline: of the requirement, in one quadrant; signs: of force and speed in the
        quadrants required; largest_loss [W]: in the required region, 0 where none is drawn there.
    """
    within = steady.limit == Limit.OK
    spent = spent_on_load(steady.limit, steady.power_in, steady.power_out)
    loss = np.where(spent, steady.power_in - steady.power_out, np.nan)
    required, outline, signs = spent, np.empty((0, 2)), []
    if requirement is not None:
        required = required & (np.abs(steady.force) <= requirement.force)
        required = required & (np.abs(steady.speed)[:, None] <= requirement.speed_at(steady.force)[None, :])
        outline, signs = outline_of(requirement)
    return {
        "force": steady.force,
        "speed": steady.speed,
        "efficiency": np.where(within & ~spent, steady.efficiency, np.nan),
        "loss": loss,
        "largest_loss": float(np.max(loss, where=required, initial=0.0)),
        "limit": steady.limit,
        "margin": steady.margin,
        "outline": outline,
        "signs": signs,
        "axis": steady.axis,
    }


def spent_on_load(limit: Array, power_in: Array, power_out: Array) -> Array:
    """Where a drive is within limits, the load drives, and the supply gets nothing back."""
    xp = namespace(power_in, power_out)
    return (limit == int(Limit.OK)) & (power_out < 0) & (power_in >= -1e-9 * xp.abs(power_out))


def outline_of(requirement: Requirement) -> tuple[np.ndarray, list[tuple[int, int]]]:
    """Outline of the required region in one quadrant, (force, speed), and the signs of both in the quadrants required."""
    force = np.linspace(0.0, requirement.force, 200)
    edge = np.column_stack([force, requirement.speed_at(force)])
    signs = {1: [(1, 1)], 2: [(1, 1), (-1, 1)], 4: [(1, 1), (-1, 1), (1, -1), (-1, -1)]}[requirement.quadrants]
    return np.vstack([edge, [requirement.force, 0.0]]), signs


def loss_levels(maps: Iterable[Mapping[str, Any]]) -> np.ndarray:
    """Loss levels shared by several maps, from 0; empty if no loss is drawn in the required region. [W]"""
    from matplotlib.ticker import MaxNLocator

    most = _LOSS_REACH * max((one["largest_loss"] for one in maps), default=0.0)
    return np.asarray(MaxNLocator(_LOSS_STEPS).tick_values(0.0, most)) if most > 0 else np.empty(0)


def draw(
    ax: Axes,
    numbers: Mapping[str, Any],
    title: str = "",
    builds: BuildsMap | None = None,
    levels: np.ndarray | None = None,
) -> Drawn:
    """Draw one map, with the limit band of samples within tolerances and the given loss levels."""
    force, speed, limit = numbers["force"], numbers["speed"], numbers["limit"]
    ax.set_facecolor(_OUTSIDE)
    within = numbers["efficiency"]
    ax.contourf(force, speed, limit == Limit.OK, levels=[0.5, 1.5], colors=["white"])
    filled = ax.contourf(force, speed, within, levels=LEVELS, cmap="viridis", vmin=0.0, vmax=1.0)
    if np.isfinite(within).any():
        lines = ax.contour(force, speed, within, levels=_LINES, colors="white", linewidths=0.6)
        ax.clabel(lines, fmt="%.2g", fontsize=7)
    lost = _draw_loss(ax, numbers, loss_levels([numbers]) if levels is None else levels)
    for code in np.unique(limit[limit != Limit.OK])[1:]:
        ax.contour(force, speed, limit == code, levels=[0.5], colors="#888888", linewidths=0.8, linestyles="dotted")
    margin = np.clip(numbers["margin"], 0.0, CLEAR)
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
    name_regions(
        ax, force, speed, {words_of(Limit(int(code))): limit == code for code in np.unique(limit) if code != Limit.OK}
    )
    half = 0.5 * (force[1] - force[0]), 0.5 * (speed[1] - speed[0])  # axes hold the centres of cells
    ax.set_xlim(force[0] - half[0], force[-1] + half[0])
    ax.set_ylim(speed[0] - half[1], speed[-1] + half[1])
    style.label_plane(ax, numbers["axis"])
    ax.set_title(title, parse_math=False)
    return Drawn(filled, lost)


def _draw_loss(ax: Axes, numbers: Mapping[str, Any], levels: np.ndarray) -> Any:
    """Draw the loss where efficiency is undefined; returns its filled contours, or None."""
    if not np.isfinite(numbers["loss"]).any() or len(levels) < 2:
        return None
    from matplotlib import colormaps
    from matplotlib.colors import BoundaryNorm, ListedColormap

    name, first, last = _LOSS_COLOURS
    *shades, beyond = colormaps[name](np.linspace(first, last, len(levels)))
    colours = ListedColormap(shades).with_extremes(over=beyond)
    grid = numbers["force"], numbers["speed"], numbers["loss"]
    filled = ax.contourf(*grid, levels=levels, cmap=colours, norm=BoundaryNorm(levels, colours.N), extend="max")
    lines = ax.contour(*grid, levels=levels[1:], colors="#7A4A12", linewidths=0.5)
    ax.clabel(lines, fmt=lambda watts: f"{plain(watts, 3)} W", fontsize=7, colors="#5A3408")
    return filled


def colour_bar(made: Figure, drawn: Drawn, beside: Any) -> None:
    """Add the colour bar of efficiency beside the axes, and that of loss where drawn."""
    if drawn.loss is not None:
        made.colorbar(drawn.loss, ax=beside, label="loss [W] where the load drives\nand no power returns")
    made.colorbar(drawn.efficiency, ax=beside, label="efficiency,\nuseful / supplied power [-]", ticks=LEVELS[::2])


def name_regions(
    ax: Axes, force: np.ndarray, speed: np.ndarray, regions: Mapping[str, np.ndarray], **options: Any
) -> set[str]:
    """Label each region where it is widest, unless it is too small for text; return the labels drawn."""
    from scipy.ndimage import distance_transform_edt

    box = {"boxstyle": "round,pad=0.1", "facecolor": _OUTSIDE, "edgecolor": "none", "alpha": 0.8}
    drawn = set()
    for words, region in regions.items():
        # Distance to the edge of the region in units of the text's size; a frame keeps the text off the axes.
        cell = tuple(1.0 / (size * count) for size, count in zip(_TEXT_HALF_SIZE, region.shape, strict=True))
        depth: Any = distance_transform_edt(np.pad(region, 1), sampling=cell)
        depth = depth[1:-1, 1:-1]
        row, column = np.unravel_index(np.argmax(depth), depth.shape)
        if depth[row, column] < 1.0:
            continue
        drawn.add(words)
        style_of = {
            "ha": "center",
            "va": "center",
            "fontsize": 7.5,
            "color": "#333333",
            "bbox": box,
            "parse_math": False,
        }
        ax.text(force[column], speed[row], words, **{**style_of, **options})
    return drawn


def draw_all(comparison: Comparison) -> Figure:
    """Draw the maps of all drives side by side with one colour bar."""
    results = list(comparison.results.values())
    columns = 2 if len(results) == 4 else min(3, len(results))
    rows = -(-len(results) // columns)
    with style.styled():
        maps = [data(result.map, comparison.study.requirement) for result in results]
        levels = loss_levels(maps)
        bars = 1.0 + 0.9 * (levels.size > 0)
        width = {1: 4.6, 2: 4.0, 3: 3.2}[columns]
        made, axes = style.figure(
            width * columns + bars, 0.86 * width * rows, rows, columns, squeeze=False, sharex=True, sharey=True
        )
        found = []
        for index, (ax, result) in enumerate(zip(axes.flat, results, strict=False)):
            drawn = comparison.builds.get(result.name)
            found.append(draw(ax, maps[index], result.title, None if drawn is None else drawn.map, levels))
            ax.label_outer()
            if index + columns >= len(results):  # nothing below it
                ax.tick_params(labelbottom=True)
                axis = maps[index]["axis"]
                ax.set_xlabel(f"{axis.force} on the load [{axis.force_unit}]")
        for ax in axes.flat[len(results) :]:
            ax.set_visible(False)  # removed axes would still take part in the layout of the colour bar
        loss = next((one.loss for one in found if one.loss is not None), None)
        colour_bar(made, Drawn(found[0].efficiency, loss), axes[:, -1])
    return made
