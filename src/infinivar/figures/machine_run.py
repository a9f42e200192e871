"""A simulated run of a machine of many contacts: its motion, its wheels' angles and slip, and where the energy went."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.analysis.machine_run import MachineRun, configuration_names
from infinivar.figures import style
from infinivar.figures.energy_flow import largest, line_colour

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOTION = {"m": ("displacement [mm]", 1e3), "rad": ("angle [degrees]", 180.0 / np.pi)}
_LEAST = 0.05
"""Half the least range of steering angles: a constant one has rounding. [degrees]"""


def data(run: MachineRun) -> dict[str, Any]:
    """Numbers of a run.

    Returns
    -------
    dict
        title; time (t,) [s]; motion: by unit, names and changes since the start in that unit of the axis; angles: names and
        (t,) [degrees]; slip: (t,) demand of the worst wheel; slips: start and end of slip [s]; currents: names and (t,) of the
        motors of links [A]; lost: names and (t,) [J], largest first; panels: names of what there is.
    """
    names = configuration_names(run.machine)
    motion: dict[str, dict[str, np.ndarray]] = {}
    for name in names:
        unit = name.rsplit("_", 1)[1]
        label, scale = _MOTION[unit]
        values = run.columns[name]
        motion.setdefault(label, {})[name[: -len(unit) - 1]] = scale * (values - values[0])
    steered = run.machine.mechanics(run.scenario.stick_speed).steered
    angles = {name.removesuffix("_rad"): np.degrees(run.columns[name]) for name in steered}
    demands = [values for name, values in run.columns.items() if name.startswith("slip_demand")]
    currents = {
        f"motor {name.split('_')[1]}": values
        for name, values in run.columns.items()
        if name.startswith("motor_") and name.endswith("_current_A") and name.split("_")[1].isdigit()
    }
    panels = {"motion": True, "angles": angles, "slip": demands, "currents": currents, "lost": True}
    return {
        "title": run.title,
        "panels": [name for name, shown in panels.items() if shown],
        "currents": currents,
        "time": run.time,
        "motion": motion,
        "angles": angles,
        "slip": np.max(demands, axis=0) if demands else np.zeros(len(run.time)),
        "slips": [(event.start, event.end) for event in run.events if event.start in run.slips],
        "lost": largest(run.lost),
    }


def draw(axes: Mapping[str, Axes], numbers: Mapping[str, Any]) -> None:
    """Draw into the axes of the panels: of "motion", "angles", "slip", "currents" and "lost" those that there are."""
    time, label = numbers["time"], ", ".join(numbers["motion"]).replace("], ", "],\n")
    for curves, line in zip(numbers["motion"].values(), ("-", "--"), strict=False):
        style.curves(axes["motion"], time, _named(curves), label, line=line)
    if "angles" in axes:
        style.curves(axes["angles"], time, _named(numbers["angles"]), "steering angle\n[degrees]")
        low, high = axes["angles"].get_ylim()
        middle, half = 0.5 * (low + high), max(0.5 * (high - low), _LEAST)
        axes["angles"].set_ylim(middle - half, middle + half)
    if "slip" in axes:
        _draw_slip(axes["slip"], numbers)
    if "currents" in axes:
        style.curves(axes["currents"], time, numbers["currents"], "motor current [A]")
    style.curves(axes["lost"], time, numbers["lost"], "energy lost [J]", line_colour)
    axes["lost"].set_xlabel("time [s]")
    axes["motion"].set_title(numbers["title"])


def _draw_slip(ax: Axes, numbers: Mapping[str, Any]) -> None:
    ax.plot(numbers["time"], numbers["slip"], color=style.COLOURS[0])
    ax.axhline(1.0, color="0.5", linestyle=":")
    for begin, end in numbers["slips"]:
        ax.axvspan(begin, end, color="0.85")
    ax.set_ylim(0.0, max(1.15, min(float(np.max(numbers["slip"])), 3.0)))
    ax.set_ylabel("slip demand of\nthe worst wheel")


def draw_all(run: MachineRun) -> Figure:
    """Draw the figure of a run."""
    numbers = data(run)
    names = numbers["panels"]
    with style.styled():
        made, axes = style.stack(names, 7.4, 2.0 * len(names))
        draw(axes, numbers)
    return made


def _named(curves: Mapping[str, Any]) -> dict[str, Any]:
    return {_words(name): values for name, values in curves.items()}


def _words(name: str) -> str:
    letters = {"theta": r"\theta", "phi": r"\phi", "gamma": r"\gamma"}
    first, *rest = name.split("_")
    first = letters.get(first, first)
    symbol = len(first) == 1 or "\\" in first
    if not symbol:
        return " ".join([first, *rest[:1]])
    return f"${first}_{{{rest[0]}}}$" if rest else f"${first}$"
