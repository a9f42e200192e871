"""A duty cycle, drive beside drive: motion and power over the cycle, heat over the hours, and where the energy goes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.analysis.compare import DutyComparison
from infinivar.figures import losses, style
from infinivar.limits import Limit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Panel by title of its axis: column and factor. The first two belong to the task, the others to each drive.
_TASK = {"speed of\nload [m/s]": ("speed_m_s", 1.0), "force on\nload [N]": ("force_N", 1.0)}
_DRIVES = {
    "from supply\n[W]": ("power_from_supply_W", 1.0),
    "motor\ncurrent [A]": ("motor_current_A", 1.0),
    "steering\nangle [deg]": ("steering_angle_rad", 180.0 / np.pi),
    "steering\ncurrent [A]": ("steering_current_A", 1.0),
}
_MOST_POINTS = 1000


def data(found: DutyComparison) -> dict[str, Any]:
    """Curves over the cycle by panel and drive, temperatures over time by motor, and losses for `losses.draw`.

    Returns
    -------
    dict
        time [s]; panels: title of axis to curves by drive; heat: motor of a drive to (time [min], winding [C], permissible
        [C]); losses: as `infinivar.figures.losses.data` gives, in J of a cycle.
    """
    results = list(found.results.values())
    first = results[0].columns
    thin = slice(None, None, max(1, len(first["time_s"]) // _MOST_POINTS))
    panels: dict[str, dict[str, Any]] = {
        title: {"": factor * first[name][thin]} for title, (name, factor) in _TASK.items()
    }
    for title, (name, factor) in _DRIVES.items():
        curves = {result.title: factor * result.columns[name][thin] for result in results if name in result.columns}
        if curves:
            panels[title] = curves
    heat = {
        f"{result.title}, {what}": (hot.time / 60.0, hot.winding_history - 273.15, hot.permissible - 273.15)
        for result in results
        for what, hot in result.heat.items()
        if hot is not None
    }
    return {
        "time": first["time_s"][thin],
        "titles": [result.title for result in results],
        "panels": panels,
        "heat": heat,
        "losses": {
            "title": "where the energy of a cycle goes",
            "unit": "J",
            "losses": {result.title: result.losses for result in results},
            "power_in": {result.title: result.energy for result in results},
            "limit": {result.title: result.exceeded[0][0] if result.exceeded else Limit.OK for result in results},
        },
    }


def draw(ax: Axes, numbers: Mapping[str, Any], panel: str) -> None:
    """Draw one panel over the cycle."""
    for title, values in numbers["panels"][panel].items():
        colour = style.COLOURS[numbers["titles"].index(title) % len(style.COLOURS)] if title else "black"
        ax.plot(numbers["time"], values, color=colour, linewidth=1.2, label=title)
    ax.set_ylabel(panel)
    ax.margins(x=0.0, y=0.1)


def draw_heat(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw the windings' temperatures from a cold start, and what they may have."""
    limits: dict[float, list[str]] = {}
    for key, (time, winding, permissible) in numbers["heat"].items():
        title = next(title for title in numbers["titles"] if key.startswith(f"{title}, "))
        colour = style.COLOURS[numbers["titles"].index(title) % len(style.COLOURS)]
        dashes = "dashed" if key.endswith("steering motor") else "solid"
        known = winding < 1.6 * permissible
        ax.plot(time[known], winding[known], color=colour, ls=dashes, lw=1.4, label=key)
        limits.setdefault(permissible, []).append(key)
    for permissible in limits:
        ax.axhline(permissible, color="#777777", lw=0.9, ls="dotted")
        ax.text(
            1.0,
            permissible,
            f"{permissible:.0f} C allowed",
            transform=ax.get_yaxis_transform(),
            ha="right",
            va="bottom",
            fontsize=7,
        )
    ax.set_xlabel("time from a cold start [min]")
    ax.set_ylabel("winding [C]")
    ax.set_title("heat, the cycle repeated")
    ax.margins(x=0.0, y=0.12)
    ax.legend(loc="upper left", bbox_to_anchor=(0.0, -0.22), fontsize=7)


def draw_all(found: DutyComparison) -> Figure:
    """The figure: the cycle at the left, heat at the right, losses below."""
    numbers = data(found)
    panels = list(numbers["panels"])
    rows = len(panels)
    with style.styled():
        bars = 0.7 + 0.32 * len(numbers["titles"])
        made, _ = style.figure(10.6, 1.0 * rows + bars + 1.5, 1, 1)
        made.clear()
        grid = made.add_gridspec(2, 1, height_ratios=[rows, bars])
        upper = grid[0].subgridspec(1, 2, width_ratios=[1.7, 1.0])
        history = upper[0].subgridspec(rows, 1)
        axes = [made.add_subplot(history[0])]
        axes += [made.add_subplot(history[row], sharex=axes[0]) for row in range(1, rows)]
        for ax, panel in zip(axes, panels, strict=True):
            draw(ax, numbers, panel)
            ax.tick_params(labelbottom=ax is axes[-1])
        axes[-1].set_xlabel("time in the cycle [s]")
        axes[0].set_title("one cycle")
        made.align_ylabels(axes)
        if numbers["heat"]:
            draw_heat(made.add_subplot(upper[1]), numbers)
        below = made.add_subplot(grid[1])
        losses.draw(below, numbers["losses"])
        lines, labels = next(
            (
                ax.get_legend_handles_labels()
                for ax in axes
                if len(ax.get_legend_handles_labels()[1]) >= len(numbers["titles"])
            ),
            ([], []),
        )
        named = [(line, label) for line, label in zip(lines, labels, strict=True) if label]
        if named:
            # In the panel that shows every drive, above its curves.
            axes[2].legend(
                *zip(*named, strict=True),
                loc="lower left",
                bbox_to_anchor=(0.0, 0.98),
                ncols=4,
                fontsize=7,
                borderaxespad=0.0,
            )
        handles, names = losses.legend([below])
        made.legend(handles, names, loc="outside lower center", ncols=6)
    return made
