"""Step of the steering angle: lateral force and slip angle over the distance rolled."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.analysis.steering_step import RELAXED, SteeringStep
from infinivar.figures import style
from infinivar.units import plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


_ROOM = 0.25
"""Part of the axis from which the patch's length has room for its name."""


def data(step: SteeringStep) -> dict[str, Any]:
    """Distances [mm], forces [N], slip angle [mrad], time per distance [ms/mm].

    The force after creep alone has settled when a slow turn has not: to its end it is the steady one.
    """
    beyond = step.distance[-1:][step.distance[-1:] > step.creep_distance[-1]]
    return {
        "distance": 1e3 * step.distance,
        "force": step.force,
        "slip_angle": 1e3 * step.slip_angle,
        "creep_distance": 1e3 * np.append(step.creep_distance, beyond),
        "creep_force": np.append(step.creep_force, np.full_like(beyond, step.steady_force)),
        "steady_force": step.steady_force,
        "relaxation_length": 1e3 * step.relaxation_length,
        "creep_relaxation_length": 1e3 * step.creep_relaxation_length,
        "patch_length": 2e3 * step.half_length,
        "time_per_distance": 1.0 / step.surface_speed,
    }


def draw_force(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw the force after the step and after creep alone, with the relaxation lengths."""
    steady = numbers["steady_force"]
    ax.axhline(steady, color="grey", lw=0.8, ls="--")
    ax.axvspan(0.0, numbers["patch_length"], color="#eeeeee", zorder=0)
    series = (("step of the steering angle", "", style.COLOURS[0]), ("lateral creep alone", "creep_", style.COLOURS[1]))
    for label, prefix, colour in series:
        length = numbers[f"{prefix}relaxation_length"]
        ax.plot(
            numbers[f"{prefix}distance"],
            numbers[f"{prefix}force"],
            color=colour,
            ls="--" if prefix else "-",
            label=f"{label}: 63 % at {plain(length, 3)} mm",
        )
        ax.plot([length], [RELAXED * steady], "o", color=colour, ms=5)
    ax.set_ylim(0.0, 1.12 * float(max(steady, np.nanmax(numbers["creep_force"]))))
    ax.text(
        0.99, steady, "steady", transform=ax.get_yaxis_transform(), ha="right", va="bottom", fontsize=8, color="grey"
    )
    ax.set_ylabel("lateral force [N]")
    ax.legend(loc="lower right")


def draw_slip_angle(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw the slip angle after the step, and how long the patch is."""
    ax.axvspan(0.0, numbers["patch_length"], color="#eeeeee", zorder=0)
    ax.plot(numbers["distance"], numbers["slip_angle"], color=style.COLOURS[0])
    length, end = numbers["patch_length"], numbers["distance"][-1]
    inside = length > _ROOM * end
    ax.text(
        0.5 * length if inside else length + 0.01 * end,
        0.97,
        "patch length",
        transform=ax.get_xaxis_transform(),
        ha="center" if inside else "left",
        va="top",
        fontsize=8,
        color="grey",
    )
    ax.set_xlim(0.0, end)
    ax.set_ylim(0.0, 1.5 * numbers["slip_angle"][-1])
    ax.set_ylabel("slip angle\n[mrad]")
    ax.set_xlabel("distance rolled [mm]")


def draw_all(step: SteeringStep) -> Figure:
    """Draw force and slip angle, with the time above."""
    with style.styled():
        made, axes = style.figure(6.4, 4.8, 2, 1, sharex=True, height_ratios=(3, 1))
        numbers = data(step)
        draw_force(axes[0], numbers)
        draw_slip_angle(axes[1], numbers)
        scale = numbers["time_per_distance"]
        above = axes[0].secondary_xaxis("top", functions=(lambda mm: mm * scale, lambda ms: ms / scale))
        above.set_xlabel(f"time at {plain(step.surface_speed, 3)} m/s [ms]")
        made.suptitle(step.title, parse_math=False)
    return made
