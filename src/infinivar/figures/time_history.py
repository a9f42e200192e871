"""Time history of a run: motion, forces, angles, currents and power in stacked panels."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.analysis.simulate import Simulation
from infinivar.drivetrain.drive import GEAR_LIMITS, MOTOR_LIMITS
from infinivar.figures import style
from infinivar.limits import Limit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Panels: axis title, factor, and columns with their labels.
_PANELS: tuple[tuple[str, float, dict[str, str]], ...] = (
    ("position\n[mm]", 1e3, {"position_m": "link", "wanted_position_m": "wanted"}),
    ("angle\n[deg]", 180.0 / np.pi, {"angle_rad": "joint", "wanted_angle_rad": "wanted"}),
    ("speed\n[m/s]", 1.0, {"speed_m_s": "link"}),
    ("speed\n[rad/s]", 1.0, {"speed_rad_s": "joint"}),
    ("force on\nload [N]", 1.0, {"force_N": "external"}),
    ("moment on\nload [N m]", 1.0, {"moment_Nm": "external"}),
    ("drive\n[mm]", 1e3, {"drive_position_m": "drive"}),
    ("drive\n[deg]", 180.0 / np.pi, {"drive_position_rad": "drive"}),
    ("deflection\n[mm]", 1e3, {"series_spring_deflection_m": "series spring"}),
    ("deflection\n[deg]", 180.0 / np.pi, {"series_torsion_spring_deflection_rad": "series spring"}),
    ("steering\nangle [deg]", 180.0 / np.pi, {"steering_angle_rad": "wheel"}),
    ("cylinder\n[rad/s]", 1.0, {"cylinder_speed_rad_s": "cylinder"}),
    ("lateral over\nslip force [-]", 1.0, {"slip_ratio": "wheel"}),
    ("current\n[A]", 1.0, {"motor_current_A": "motor", "steering_current_A": "steering motor"}),
    ("supply\npower [W]", 1.0, {"supply_power_W": "supply"}),
)

# The panel that shows each limit, identified by one of its columns.
_WHERE = {
    Limit.SLIP: "slip_ratio",
    **dict.fromkeys((*MOTOR_LIMITS, *GEAR_LIMITS), "motor_current_A"),
    Limit.STEERING: "steering_angle_rad",
    Limit.REGENERATION: "supply_power_W",
    Limit.LINKAGE: "angle_rad",
    Limit.SPRING: "series_spring_deflection_m",
}

_LEAST = 0.005
"""Smallest shaded share of the run, so that short events stay visible."""

_GREYS = (0xDE, 0xBE, 0x9E, 0x86, 0x70, 0x5C, 0x4A)
"""Shades of the limits of a panel, from the lightest; a panel with more limits has shades between these."""


def data(simulation: Simulation) -> dict[str, Any]:
    """Panels with their curves over time and the intervals beyond a limit.

    Returns
    -------
    dict
        time [s]; panels: axis title to curves by name, in the unit of the title; limits: axis title to (start, end, words).
    """
    columns = simulation.columns
    panels, limits = {}, {}
    for title, factor, required in _PANELS:
        curves = {words: factor * np.asarray(columns[name]) for name, words in required.items() if name in columns}
        if not curves or ("external" in curves and not np.any(curves["external"])):
            continue
        panels[title] = curves
        limits[title] = [
            (event.start, event.end, f"{event.limit.words} ({event.what})")
            for event in simulation.events
            if _WHERE.get(event.limit) in required
        ]
    return {"time": np.asarray(columns["time_s"]), "panels": panels, "limits": limits}


def draw(ax: Axes, numbers: Mapping[str, Any], panel: str) -> None:
    """Draw the curves of one panel and, in grey, the intervals beyond a limit, labelled above the curves."""
    time, curves = numbers["time"], numbers["panels"][panel]
    for index, (words, values) in enumerate(curves.items()):
        if words == "wanted":
            ax.plot(time, values, color="black", linewidth=0.9, linestyle=(0, (4, 2)), label=words)
        else:
            ax.plot(time, values, color=style.colour(index), linewidth=1.2, label=words)
    ax.set_ylabel(panel)
    ax.margins(x=0.0, y=0.12)
    ax.set_xlim(auto=False)
    if len(curves) > 1:
        # Kept beside a second legend, and outside the panel, where it must not be clipped.
        ax.add_artist(ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))).set_clip_on(False)
    shades = _shade(ax, numbers["limits"][panel], _LEAST * (time[-1] - time[0]))
    if shades:
        place = {"loc": "lower left", "bbox_to_anchor": (0.0, 0.97), "ncols": 2, "borderaxespad": 0.0}
        ax.legend(handles=shades, fontsize=7, handlelength=1.2, **place)


def _shade(ax: Axes, limits: Sequence[tuple[float, float, str]], least: float) -> list[Any]:
    """Shade intervals with one shade per limit and a minimum width; returns the legend entries."""
    lasting: dict[str, float] = {}
    for start, end, words in limits:
        lasting[words] = lasting.get(words, 0.0) + end - start
    named = []
    # Shorter intervals are darker and lie on top of longer ones.
    for grey, name in zip(_greys(len(lasting)), sorted(lasting, key=lambda words: -lasting[words]), strict=True):
        shades = [
            ax.axvspan(start - wider, end + wider, color=grey, linewidth=0, zorder=0)
            for start, end, words in limits
            if words == name
            for wider in [0.5 * max(least - (end - start), 0.0)]
        ]
        shades[0].set_label(name)
        named.append(shades[0])
    return named


def _greys(count: int) -> list[str]:
    """A shade for each of some limits."""
    places = np.linspace(0.0, min(count, len(_GREYS)) - 1.0, count)
    return [f"#{3 * f'{round(level):02X}'}" for level in np.interp(places, range(len(_GREYS)), _GREYS)]


def draw_all(simulation: Simulation) -> Figure:
    """Draw all panels over one time axis."""
    numbers = data(simulation)
    panels = list(numbers["panels"])
    with style.styled():
        made, axes = style.stack(panels, 7.6, 0.6 + 1.15 * len(panels))
        for panel, ax in axes.items():
            draw(ax, numbers, panel)
        axes[panels[-1]].set_xlabel("time [s]")
        made.align_ylabels()
    return made
