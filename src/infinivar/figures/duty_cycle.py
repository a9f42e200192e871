"""A duty cycle of all drives: motion and power over the cycle, temperatures over hours, energy by loss."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.analysis.cycles.duty_comparison import DutyComparison
from infinivar.figures import losses, style
from infinivar.limits import Limit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Panel by title of its axis: column and factor, for each drive.
_DRIVES = {
    "supply\npower [W]": ("power_from_supply_W", 1.0),
    "motor\ncurrent [A]": ("motor_current_A", 1.0),
    "steering\nangle [deg]": ("steering_angle_rad", 180.0 / np.pi),
    "steering\ncurrent [A]": ("steering_current_A", 1.0),
}
_MOST_POINTS = 1000
_BRIEF = 300.0
"""Runs shorter than this have seconds on the axis of temperatures, all others minutes. [s]"""
_HOTTEST = 1.3
"""Temperatures are drawn up to this factor times the highest permissible one."""


def data(found: DutyComparison) -> dict[str, Any]:
    """Curves over the cycle by panel and drive, temperatures over time by motor, and losses for `losses.draw`.

    Returns
    -------
    dict
        closed: whether the cycle repeats; time [s]; panels: title of axis to curves by drive; heat: motor of a drive to
        (time in heat_unit, winding [°C], permissible [°C]); losses: as `infinivar.figures.losses.data` gives, in J.
    """
    results = list(found.results.values())
    first = results[0].columns
    thin = slice(None, None, max(1, len(first["time_s"]) // _MOST_POINTS))
    panels: dict[str, dict[str, Any]] = {
        f"{words} {joining}\nload [{unit}]": {"": first[name][thin]} for words, joining, unit, name in _task(found)
    }
    for title, (name, factor) in _DRIVES.items():
        curves = {result.title: factor * result.columns[name][thin] for result in results if name in result.columns}
        if curves:
            panels[title] = curves
    brief = not found.duty.closed and found.duty.period < _BRIEF
    heat = {
        f"{result.title}, {what}": (
            hot.time / (1.0 if brief else 60.0),
            hot.winding_history - 273.15,
            hot.permissible - 273.15,
        )
        for result in results
        for what, hot in result.heat.items()
        if hot is not None
    }
    return {
        "closed": found.duty.closed,
        "heat_unit": "s" if brief else "min",
        "time": first["time_s"][thin],
        "titles": [result.title for result in results],
        "panels": panels,
        "heat": heat,
        "losses": {
            "title": f"losses {found.duty.per}",
            "unit": "J",
            "losses": {result.title: result.losses for result in results},
            "power_in": {result.title: result.energy for result in results},
            "limit": {result.title: result.exceeded[0][0] if result.exceeded else Limit.OK for result in results},
        },
    }


def _task(found: DutyComparison) -> list[tuple[str, str, str, str]]:
    """Word, preposition, unit and column of the load's speed and of the force on it.

    The unit shows that a speed is angular; the panels are too low for the full term.
    """
    axis = found.axis
    _, speed, force = axis.columns
    return [("speed", "of", axis.speed_unit, speed), (axis.force, "on", axis.force_unit, force)]


def _colour(numbers: Mapping[str, Any], title: str) -> str:
    """The colour of a drive in all panels."""
    return style.colour(numbers["titles"].index(title))


def draw(ax: Axes, numbers: Mapping[str, Any], panel: str) -> None:
    """Draw one panel over the cycle."""
    for title, values in numbers["panels"][panel].items():
        colour = _colour(numbers, title) if title else "black"
        ax.plot(numbers["time"], values, color=colour, linewidth=1.2, label=title)
    ax.set_ylabel(panel)
    ax.margins(x=0.0, y=0.1)


def draw_heat(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw winding temperatures from a cold start and their permissible values; a thermal runaway leaves the plot."""
    limits = []
    top = _HOTTEST * max(permissible for _, _, permissible in numbers["heat"].values())
    for key, (time, winding, permissible) in numbers["heat"].items():
        title = max((title for title in numbers["titles"] if key.startswith(f"{title}, ")), key=len)
        colour = _colour(numbers, title)
        dashes = "dashed" if key.endswith("steering motor") else "solid"
        shown = _up_to(time, winding, top)
        if shown is not None:
            ax.plot(*shown, color=colour, ls=dashes, lw=1.4, label=key)
            limits.append(permissible)
    for permissible in dict.fromkeys(limits):
        ax.axhline(permissible, color="#777777", lw=0.9, ls="dotted")
        ax.text(
            1.0,
            permissible,
            f"{permissible:.0f} °C allowed",
            transform=ax.get_yaxis_transform(),
            ha="right",
            va="bottom",
            fontsize=7,
        )
    repeated = numbers["closed"]
    ax.set_xlabel(f"time {'from a cold start' if repeated else 'in the run'} [{numbers['heat_unit']}]")
    ax.set_ylabel("winding temperature [°C]")
    ax.set_title("winding temperature, cycle repeated" if repeated else "winding temperature")
    ax.margins(x=0.02, y=0.12)  # a winding that runs away at once is beside the axis, not under it
    if limits:
        _literally(ax.legend(loc="upper left", bbox_to_anchor=(0.0, -0.11), fontsize=7))


def _literally(legend: Any) -> None:
    """Show titles literally: a dollar sign does not start a formula."""
    for text in legend.get_texts():
        text.set_parse_math(False)


def _up_to(time: np.ndarray, winding: np.ndarray, top: float) -> tuple[np.ndarray, np.ndarray] | None:
    """A temperature history up to `top`, and the point where it passes it; None if nothing can be drawn. [min], [°C]"""
    beyond = ~(winding <= top)
    end = int(np.argmax(beyond)) if beyond.any() else len(winding)
    if end == 0 or len(winding) < 2:
        return None
    if end == len(winding):
        return time, winding
    steep = winding[end]
    share = (top - winding[end - 1]) / (steep - winding[end - 1]) if np.isfinite(steep) else 0.0
    passed = time[end - 1] + share * (time[end] - time[end - 1])
    return np.append(time[:end], passed), np.append(winding[:end], top)


def draw_all(found: DutyComparison) -> Figure:
    """Draw the cycle on the left, temperatures on the right, losses below."""
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
        axes[-1].set_xlabel("time in the cycle [s]" if numbers["closed"] else "time in the run [s]")
        axes[0].set_title("one cycle" if numbers["closed"] else "the run")
        made.align_ylabels(axes)
        if numbers["heat"]:
            draw_heat(made.add_subplot(upper[1]), numbers)
        below = made.add_subplot(grid[1])
        losses.draw(below, numbers["losses"])
        from matplotlib.lines import Line2D

        shown = [title for title in numbers["titles"] if any(title in curves for curves in numbers["panels"].values())]
        drives = [Line2D([], [], color=_colour(numbers, title), lw=1.2, label=title) for title in shown]
        _literally(made.legend(handles=drives, loc="outside upper left", ncols=min(4, len(drives)), fontsize=8))
        handles, names = losses.legend([below])
        made.legend(handles, names, loc="outside lower center", ncols=6)
    return made
