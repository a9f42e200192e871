"""Which drive loses least over the force-speed plane, by how many watts, and where the motions cross it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.analysis.loss_ranking import EQUAL, NONE, LeastLoss
from infinivar.errors import InputError
from infinivar.figures import operating_map, style
from infinivar.limits import Limit
from infinivar.units import plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_STEPS = 5
"""Approximate number of steps in which the lead is shaded."""
_MOST = 95.0
"""Percentile of the lead at which shades and contours end, so that a few points near a limit do not decide them."""
_TINTS = (0.22, 0.85)
"""Least and most opaque shade of a drive's colour."""
_PATHS = ("solid", (0, (5, 2)), (0, (1, 1.5)), (0, (5, 2, 1, 2)))
_DOTS = 40
"""Points at equal steps of time on a motion."""
_ALONE = 0.45
"""Shade of a drive's colour where it is the only feasible one."""
_HATCH: dict[str, Any] = {"hatch": "//", "edgecolor": "#555555", "linewidth": 0.0}
_REQUIRED: dict[str, Any] = {**operating_map.REQUIRED, "color": "#111111", "lw": 1.7}
_LONG = 36
"""Characters of a label above which the legend has two columns."""
_OUTSIDE = "#EDEDED"


def data(found: LeastLoss) -> dict[str, Any]:
    """Numbers of the map.

    Returns
    -------
    dict
        axis, force, speed, best, saved [W], limit: as of the result; titles: of the drives; alone (n, m) bool: where a single
        drive is feasible; levels [W]: steps of the lead, from 0, may be empty; motions: (force, speed) by title, closed;
        outline, signs: of the required region, as `operating_map.outline_of` gives.
    """
    outline, signs = np.empty((0, 2)), []
    if found.requirement is not None:
        outline, signs = operating_map.outline_of(found.requirement)
    return {
        "axis": found.axis,
        "force": found.force,
        "speed": found.speed,
        "titles": list(found.titles.values()),
        "best": found.best,
        "alone": (found.best != NONE) & (found.runner_up == NONE),
        "saved": found.saved,
        "limit": found.limit,
        "levels": _levels(found.saved[found.best >= 0]),
        "motions": {one.title: (np.append(one.force, one.force[:1]), np.append(one.speed, one.speed[:1]))
                    for one in found.motions.values()},
        "outline": outline,
        "signs": signs,
    }  # fmt: skip


def _levels(saved: np.ndarray) -> np.ndarray:
    """Steps of the lead; empty if fewer than two drives are feasible anywhere. [W]"""
    from matplotlib.ticker import MaxNLocator

    known = saved[np.isfinite(saved)]
    most = float(np.percentile(known, _MOST)) if known.size else 0.0
    return np.asarray(MaxNLocator(_STEPS).tick_values(0.0, most)) if most > 0 else np.empty(0)


def draw(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw the map."""
    from matplotlib.colors import to_rgb

    force, speed, best, levels = (numbers[name] for name in ("force", "speed", "best", "levels"))
    ax.set_facecolor(_OUTSIDE)
    image = np.ones((*best.shape, 4))
    image[best == NONE, 3] = 0.0
    for place in range(len(numbers["titles"])):
        mine = best == place
        tint = _tints(numbers["saved"], levels)[mine][:, None]
        image[mine, :3] = 1.0 - tint * (1.0 - np.array(to_rgb(style.colour(place))))
    ax.pcolormesh(force, speed, image, shading="nearest", rasterized=True)
    for place in range(len(numbers["titles"])):
        mine = best == place
        if not mine.any():
            continue
        if (levels.size > 1) and np.nanmax(np.where(mine, numbers["saved"], -np.inf)) > levels[1]:
            lead = np.where(mine, numbers["saved"], np.nan)
            lines = ax.contour(force, speed, lead, levels=levels[1:], colors="#222222", linewidths=0.6)
            ax.clabel(lines, fmt=lambda watts: f"{plain(watts, 3)} W", fontsize=7, colors="#111111")
        if not mine.all():
            ax.contour(force, speed, mine, levels=[0.5], colors="white", linewidths=1.6)
            ax.contour(force, speed, mine, levels=[0.5], colors="#222222", linewidths=0.7)
    if numbers["alone"].any():
        hatched = ax.contourf(
            force, speed, numbers["alone"], levels=[0.5, 1.5], colors="none", hatches=[_HATCH["hatch"]]
        )
        hatched.set_edgecolor(_HATCH["edgecolor"])
        hatched.set_linewidth(_HATCH["linewidth"])
    for across, along in numbers["signs"]:
        x, y = numbers["outline"].T
        ax.plot(across * x, along * y, color="white", lw=2.6)
        ax.plot(across * x, along * y, **_REQUIRED)
    _draw_motions(ax, numbers["motions"])
    _name(ax, numbers)
    half = 0.5 * (force[1] - force[0]), 0.5 * (speed[1] - speed[0])  # axes hold the centres of cells
    ax.set_xlim(force[0] - half[0], force[-1] + half[0])
    ax.set_ylim(speed[0] - half[1], speed[-1] + half[1])
    style.label_plane(ax, numbers["axis"])


def _tints(saved: np.ndarray, levels: np.ndarray) -> np.ndarray:
    """Opacity of a drive's colour, by steps of its lead; `_ALONE` where there is no runner-up."""
    low, high = _TINTS
    if levels.size < 2:
        return np.full(saved.shape, _ALONE)
    step = np.digitize(np.nan_to_num(saved), levels[1:])
    return np.where(np.isfinite(saved), low + (high - low) * step / (levels.size - 1), _ALONE)


def _draw_motions(ax: Axes, motions: Mapping[str, tuple[np.ndarray, np.ndarray]]) -> None:
    """Draw each motion as a path with dots at equal steps of time, which lie close where it dwells."""
    for place, (force, speed) in enumerate(motions.values()):
        dots = slice(None, None, max(1, len(force) // _DOTS))
        ax.plot(force, speed, color="white", lw=2.4, alpha=0.8)
        ax.plot(force, speed, color="black", lw=1.0, ls=_PATHS[place % len(_PATHS)])
        ax.plot(force[dots], speed[dots], ls="none", marker="o", ms=3.2, mfc="white", mec="black", mew=0.7)


def _name(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Label the drives' regions and the limits where none is feasible, each where it is widest."""
    grid = numbers["force"], numbers["speed"]
    limits = {
        f"no drive:\n{operating_map.words_of(Limit(int(code)))}": numbers["limit"] == code
        for code in np.unique(numbers["limit"])
        if code != Limit.OK
    }
    operating_map.name_regions(ax, *grid, limits)
    drives = {title: numbers["best"] == place for place, title in enumerate(numbers["titles"])}
    drives["equal loss"] = numbers["best"] == EQUAL
    white = {"boxstyle": "round,pad=0.2", "facecolor": "white", "edgecolor": "#444444", "lw": 0.6}
    operating_map.name_regions(ax, *grid, drives, fontsize=8, fontweight="bold", color="black", bbox=white, zorder=10)


def legend(numbers: Mapping[str, Any]) -> list[Any]:
    """Legend entries: drives that lose least somewhere, where only one is feasible, motions, required region."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    made: list[Any] = [
        Patch(facecolor=style.colour(place), label=title)
        for place, title in enumerate(numbers["titles"])
        if (numbers["best"] == place).any()
    ]
    if (numbers["best"] == EQUAL).any():
        made.append(Patch(facecolor="white", edgecolor="#444444", linewidth=0.6, label="two or more lose the same"))
    if numbers["alone"].any():
        made.append(Patch(facecolor="white", **{**_HATCH, "linewidth": 0.6}, label="only one drive feasible"))
    made += [
        Line2D(
            [], [], color="black", lw=1.0, ls=_PATHS[place % len(_PATHS)], marker="o", ms=3.2, mfc="white", label=title
        )
        for place, title in enumerate(numbers["motions"])
    ]
    return [*made, *([Line2D([], [], **_REQUIRED, label="required region")] if numbers["signs"] else [])]


def draw_all(found: LeastLoss) -> Figure:
    """Draw the map with its legend."""
    if min(found.speed.size, found.force.size) < 2:
        raise InputError("a map of one row or column cannot be drawn: use its to_xarray() instead")
    numbers = data(found)
    with style.styled():
        handles = legend(numbers)
        columns = 2 if max(len(handle.get_label()) for handle in handles) > _LONG else 3
        made, ax = style.figure(7.4, 5.4 + 0.2 * -(-len(handles) // columns))
        draw(ax, numbers)
        ax.set_title("drive with the least loss; contours: by how much")
        shown = made.legend(handles=handles, loc="outside lower center", ncols=min(columns, len(handles)))
        for text in shown.get_texts():
            text.set_parse_math(False)
    return made
