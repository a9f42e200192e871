"""Machines of a study: losses in each task and on each path, power over time, and the map of positions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.analysis.machine_tasks import PathResult
from infinivar.analysis.machines import MachineComparison
from infinivar.analysis.pose_map import PoseMap
from infinivar.figures import losses, style
from infinivar.limits import Limit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


_SHADES = {Limit.LINKAGE: "#d9d9d9", Limit.TRAVEL: "#f0c9b0", Limit.THERMAL: "#f6b9c4", Limit.SLIP: "#c9d7e6"}
_OTHER = "#d7c9e6"
"""Shades of limits in maps of positions."""

_FAR = 1.0
"""Displacement beyond which lengths are shown in metres. [m]"""


def data(comparison: MachineComparison, key: str) -> dict[str, Any]:
    """Losses and source power [W] by machine in a task or on a path, such as "tasks.lift", with the limit exceeded, if any."""
    every = {one.title: one.found[key] for one in comparison.results.values()}
    return {
        "title": next(iter(every.values())).title,
        "unit": "W",
        "losses": {title: found.losses for title, found in every.items()},
        "power_in": {title: found.mean_power for title, found in every.items()},
        "limit": {title: Limit.OK if found.feasible else found.demand[0] for title, found in every.items()},
    }


def draw_all(comparison: MachineComparison) -> Figure:
    """Draw the losses: stacked bars, one panel for each task and path."""
    keys = list(next(iter(comparison.results.values())).found)
    with style.styled():
        made, axes = style.figure(
            7.2, 0.5 + len(keys) * (0.75 + 0.3 * len(comparison.results)), len(keys), squeeze=False
        )
        for ax, key in zip(axes[:, 0], keys, strict=True):
            losses.draw(ax, data(comparison, key))
        for ax in axes[:-1, 0]:
            ax.set_xlabel("")
        made.legend(*losses.legend(axes[:, 0]), loc="outside lower center", ncols=5)
    return made


def path_data(found: Mapping[str, PathResult]) -> dict[str, Any]:
    """Time [s], power in and to the load [W] of each machine, by title, and the end point's displacement by coordinate."""
    first = next(iter(found.values()))
    middle = first.pose.mean(axis=0)
    moving = [place for place in range(first.pose.shape[1]) if np.ptp(first.pose[:, place]) > 0.0]
    return {
        "title": first.title,
        "time": first.time,
        "moved": {first.coordinates[place]: first.pose[:, place] - middle[place] for place in moving},
        "power_in": {title: np.asarray(one.point.power_in) for title, one in found.items()},
        "power_out": np.asarray(first.point.power_out),
    }


def draw_path(axes: Sequence[Axes], numbers: Mapping[str, Any]) -> None:
    """Draw the motion above the powers."""
    above, below = axes
    far = any(np.max(np.abs(values)) > _FAR for name, values in numbers["moved"].items() if name in ("x", "y", "z"))
    for place, (name, values) in enumerate(numbers["moved"].items()):
        turns = name not in ("x", "y", "z")
        scale, unit = (180.0 / np.pi, "degrees") if turns else (1.0, "m") if far else (1e3, "mm")
        above.plot(numbers["time"], scale * values, color=style.colour(place), label=f"{name} [{unit}]")
    above.set_title(numbers["title"])
    above.set_ylabel("displacement")
    if numbers["moved"]:
        style.name_beside(above, fontsize=8)
    else:
        above.text(0.5, 0.5, "at rest", transform=above.transAxes, ha="center", va="center")
        above.set_yticks([])
    sources = {f"source, {title}": values for title, values in numbers["power_in"].items()}
    style.curves(below, numbers["time"], sources, "power [W]")
    below.plot(numbers["time"], numbers["power_out"], color="#444444", ls=(0, (4, 2)), lw=1.2, label="to the load")
    below.set_xlabel("time [s]")
    style.name_beside(below, fontsize=8)


def draw_paths(found: Mapping[str, PathResult]) -> Figure:
    """Draw one path of all machines, by title."""
    with style.styled():
        made, axes = style.figure(8.2, 4.4, 2, 1, sharex=True, height_ratios=[1.0, 1.4])
        draw_path(axes, path_data(found))
    return made


def map_data(found: PoseMap) -> dict[str, Any]:
    """Positions [mm], loss within all limits [W], and limits."""
    return {
        "title": found.title,
        "x": 1e3 * found.x,
        "y": 1e3 * found.y,
        "loss": np.where(found.limit == Limit.OK, found.loss, np.nan),
        "limit": found.limit,
    }


def shade(code: int) -> str:
    """Colour of a limit in maps of positions."""
    return _SHADES.get(Limit(code), _OTHER)


def draw_map(ax: Axes, numbers: Mapping[str, Any], scale: Any = None, *, legend: bool = True) -> Any:
    """Draw the loss as colours where all limits hold, on a scale, and each limit as a shade with its name."""
    from matplotlib.patches import Patch

    x, y = numbers["x"], numbers["y"]
    codes = [int(code) for code in np.unique(numbers["limit"]) if code != Limit.OK]
    handles = []
    for code in codes:
        colour = shade(code)
        inside = np.where(numbers["limit"] == code, 1.0, np.nan)
        ax.pcolormesh(x, y, inside.T, cmap=_plain(colour), shading="nearest", rasterized=True)
        handles.append(Patch(facecolor=colour, label=Limit(code).words))
    mesh = None
    if np.any(np.isfinite(numbers["loss"])):
        mesh = ax.pcolormesh(x, y, numbers["loss"].T, cmap="viridis", norm=scale, shading="nearest", rasterized=True)
    ax.set_aspect("equal")
    ax.set_xlabel("x [mm]")
    ax.set_ylabel("y [mm]")
    ax.set_title(numbers["title"])
    if handles and legend:
        ax.legend(handles=handles, loc="upper left", bbox_to_anchor=(0.0, -0.16), ncols=2)
    return mesh


def _plain(colour: str) -> Any:
    from matplotlib.colors import ListedColormap

    return ListedColormap([colour])


def draw_maps(found: Mapping[str, PoseMap]) -> Figure:
    """Draw maps of machines side by side, by title."""
    with style.styled():
        made, axes = style.figure(4.2 * len(found), 4.0, 1, len(found), squeeze=False)
        made.get_layout_engine().set(wspace=0.12)  # type: ignore[union-attr]
        for ax, (title, one) in zip(axes[0], found.items(), strict=True):
            mesh = draw_map(ax, map_data(one))
            ax.set_title("\n".join(words for words in (title, one.title) if words), fontsize=9)
            if mesh is not None:
                made.colorbar(mesh, cax=ax.inset_axes((1.05, 0.0, 0.05, 1.0)), label="loss [W]")
    return made


def draw_pose_map(found: PoseMap) -> Figure:
    """Draw one map."""
    return draw_maps({"": found})
