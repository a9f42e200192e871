"""A sphere between rollers: efficiency and loss over steering angle and load, and the losses by name over steering angle."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.analysis.sphere_efficiency import SphereMap
from infinivar.errors import InputError
from infinivar.figures import operating_map, style
from infinivar.limits import Limit
from infinivar.units import plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SHARE = 0.5
"""Load over slip force at which losses are shown by name. [-]"""

_STEPS = 5
"""Approximate number of contours of loss."""

_RATIO_TICKS = (-90.0, -75.0, -60.0, -45.0, -30.0, 0.0, 30.0, 45.0, 60.0, 75.0, 90.0)
_SLIPS = "#D9D9D9"


def data(found: SphereMap) -> dict[str, Any]:
    """Numbers of a map.

    Returns
    -------
    dict
        title; angle (n,) [deg]; load (m,) over slip force; efficiency, loss [W] and slips, (m, n); levels of loss [W]; slip_limit
        (n,): load without losses at which a drive roller slips, over slip force; share: load of `losses` over slip force; losses
        by name (n,) [W].
    """
    angle = found.steering_angle
    share = found.load / found.slip_force
    at = int(np.argmin(np.abs(share - SHARE)))
    loss = np.asarray(found.loss).T
    return {
        "title": found.title,
        "angle": np.degrees(angle),
        "load": share,
        "efficiency": np.asarray(found.efficiency).T,
        "loss": loss,
        "slips": np.equal(found.limit, int(Limit.SLIP)).T,
        "levels": _levels(loss),
        "slip_limit": 1.0 / np.maximum(np.abs(np.sin(angle)), np.abs(np.cos(angle))),
        "share": float(share[at]),
        "losses": {name: np.asarray(one)[:, at] for name, one in found.losses.items()},
        "sphere_speed": found.sphere_speed,
    }


def _levels(loss: np.ndarray) -> np.ndarray:
    from matplotlib.ticker import MaxNLocator

    known = loss[np.isfinite(loss)]
    if not known.size:
        return np.empty(0)
    least, most = np.percentile(known, (2.0, 95.0))
    return np.asarray(MaxNLocator(_STEPS).tick_values(least, most)) if most > least else np.empty(0)


def draw(ax: Axes, numbers: Mapping[str, Any]) -> Any:
    """Draw the map of efficiency with contours of loss; returns the coloured mesh."""
    from matplotlib.colors import ListedColormap

    angle, load = numbers["angle"], numbers["load"]
    ax.set_facecolor("white")
    mesh = ax.pcolormesh(
        angle, load, numbers["efficiency"], cmap="viridis", vmin=0.0, vmax=1.0, shading="nearest", rasterized=True
    )
    slips = np.where(numbers["slips"], 1.0, np.nan)
    ax.pcolormesh(angle, load, slips, cmap=ListedColormap([_SLIPS]), shading="nearest", rasterized=True)
    if numbers["levels"].size:
        lines = ax.contour(angle, load, numbers["loss"], levels=numbers["levels"], colors="black", linewidths=0.7)
        labels = ax.clabel(lines, fmt=lambda watts: f"{plain(watts, 3)} W", fontsize=7, colors="black")
        for text in labels or ():
            text.set_bbox({"boxstyle": "round,pad=0.1", "facecolor": "white", "edgecolor": "none", "alpha": 0.8})
    limit = numbers["slip_limit"]
    for sign, inside in zip((1.0, -1.0), _within(numbers), strict=True):
        if inside.any():
            ax.plot(angle, np.where(inside, sign * limit, np.nan), color="black", lw=1.2, ls=(0, (5, 2)))
    operating_map.name_regions(ax, angle, load, {"a roller slips": numbers["slips"]})
    ax.set_xlim(angle.min(), angle.max())
    ax.set_ylim(load.min(), load.max())
    ax.set_title(f"{numbers['title']} layout")
    ax.set_ylabel(r"load $\kappa/(\mu P)$ [-]")
    _angle_axis(ax)
    _ratio_axis(ax)
    return mesh


def _within(numbers: Mapping[str, Any]) -> np.ndarray:
    """Where the slip limits of both directions of load lie within the map, (2, n)."""
    low, high = numbers["load"].min() * (1 + 1e-9), numbers["load"].max() * (1 + 1e-9)
    limits = np.array([[1.0], [-1.0]]) * numbers["slip_limit"]
    return (limits >= low) & (limits <= high)


def _angle_axis(ax: Axes) -> None:
    from matplotlib.ticker import MultipleLocator

    span = np.ptp(ax.get_xlim())
    ax.xaxis.set_major_locator(MultipleLocator(45.0 if span <= 200.0 else 90.0))
    ax.set_xlabel(r"steering angle $\gamma$ [°]")


def _ratio_axis(ax: Axes) -> None:
    """Speed ratio w_1/w_2 along the top."""
    low, high = ax.get_xlim()
    top = ax.secondary_xaxis("top")
    ticks = [one for one in _RATIO_TICKS if low <= one <= high]
    top.set_xticks(ticks, [_ratio(one) for one in ticks])
    top.tick_params(labelsize=7, length=2)
    top.set_xlabel(r"speed ratio $w_1/w_2$", fontsize=8)


def _ratio(angle: float) -> str:
    if abs(angle) == 90.0:
        return r"$\pm\infty$"
    found = math.tan(math.radians(angle))
    return plain(round(found, 2) + 0.0, 2)


def draw_losses(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw the losses by name, stacked, over the steering angle at one load."""
    names = [name for name, one in numbers["losses"].items() if np.nanmax(np.abs(one), initial=0.0) > 0.0]
    ax.stackplot(
        numbers["angle"],
        *(numbers["losses"][name] for name in names),
        labels=names,
        colors=[style.loss_colour(name) for name in names],
        lw=0.0,
    )
    ax.set_xlim(numbers["angle"].min(), numbers["angle"].max())
    ax.set_ylabel(rf"loss at $\kappa/(\mu P)$ = {numbers['share']:.2g} [W]")
    _angle_axis(ax)


def draw_all(found: SphereMap | Sequence[SphereMap]) -> Figure:
    """Draw maps side by side, above the losses by name.

    Raises
    ------
    InputError
        If a map has fewer than two angles or loads.
    """
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    maps = (found,) if isinstance(found, SphereMap) else tuple(found)
    if any(min(one.steering_angle.size, one.load.size) < 2 for one in maps):
        raise InputError("a map of one angle or load cannot be drawn: use its to_xarray() instead")
    with style.styled():
        made, axes = style.figure(
            max(3.9 * len(maps) + 0.9, 6.4), 6.4, 2, len(maps), squeeze=False, height_ratios=[1.6, 1.0], sharey="row"
        )
        meshes = []
        for column, one in enumerate(maps):
            numbers = data(one)
            meshes.append(draw(axes[0, column], numbers))
            draw_losses(axes[1, column], numbers)
            if column:
                axes[0, column].set_ylabel("")
                axes[1, column].set_ylabel("")
        made.colorbar(meshes[0], ax=list(axes[0]), label="efficiency [-]", shrink=0.9)
        handles, labels = axes[1, 0].get_legend_handles_labels()
        handles, labels = handles[::-1], labels[::-1]
        if any(_within(data(one)).any() for one in maps):
            handles.append(Line2D([], [], color="black", lw=1.2, ls=(0, (5, 2))))
            labels.append("slip of drive rollers without losses and spin")
        handles.append(Patch(facecolor="white", edgecolor="#444444", linewidth=0.6))
        labels.append("both shafts feed the losses")
        made.legend(handles=handles, labels=labels, loc="outside lower center", ncols=3 if len(maps) > 1 else 2)
    return made
