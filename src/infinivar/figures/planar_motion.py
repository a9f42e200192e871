"""Motion in time of a planar cobot: its path from above, speeds, slip demands of its wheels, and energies."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.analysis.planar_motion import PlanarMotion
from infinivar.figures import style

if TYPE_CHECKING:
    from collections.abc import Mapping

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_BODIES = 9
"""Poses along the path at which the heading of the body is drawn."""

_SIZE = 0.08
"""Length of a heading over the extent of the path."""


def data(found: PlanarMotion) -> dict[str, Any]:
    """Numbers of a motion.

    Returns
    -------
    dict
        time (t,) [s]; path (t, 2) [m]; angle (t,) [rad]; speed [m/s] and turning [rad/s] (t,); slip (t, k); slips: times [s];
        energies: kinetic, work of the user and of the steering, by name (t,) [J]; lost: by name (t,) [J]; ended.
    """
    return {
        "time": np.asarray(found.time),
        "path": np.asarray(found.pose)[:, :2],
        "angle": np.asarray(found.pose)[:, 2],
        "speed": np.hypot(*np.asarray(found.twist)[:, :2].T),
        "turning": np.asarray(found.twist)[:, 2],
        "slip": np.asarray(found.slip_demand),
        "slips": found.slips,
        "energies": {"kinetic": found.energy, "work of the user": found.work, "work of steering": found.steering_work},
        "lost": {name: values for name, values in found.losses.items() if np.any(values)},
        "ended": found.ended,
    }


def draw(axes: Mapping[str, Axes], numbers: Mapping[str, Any]) -> None:
    """Draw into the axes "path", "speed", "slip" and "energy"."""
    path, time = numbers["path"], numbers["time"]
    above = axes["path"]
    above.plot(*path.T, color=style.COLOURS[0])
    size = _SIZE * (float(np.max(np.ptp(path, axis=0))) or 1.0)
    for place in np.unique(np.linspace(0, len(time) - 1, _BODIES).round().astype(int)):
        ahead = size * np.array([np.cos(numbers["angle"][place]), np.sin(numbers["angle"][place])])
        style.arrow(above, path[place], path[place] + ahead, "#444444", lw=1.0, size=8, zorder=3)
    above.plot(*path[0], marker="o", ms=4, color="black")
    above.set_aspect("equal", adjustable="datalim")
    above.set_xlabel("x [m]")
    above.set_ylabel("y [m]")
    above.set_title(
        f"from the dot, x axis of the body; ends at {time[-1]:.3g} s" + " at rest" * (numbers["ended"] == "rest")
    )
    speeds = {"speed [m/s]": numbers["speed"], "turning [rad/s]": numbers["turning"]}
    style.curves(axes["speed"], time, speeds, "velocity")
    wheels = {f"wheel {place}": values for place, values in enumerate(numbers["slip"].T, 1)}
    style.curves(axes["slip"], time, wheels, "slip demand [-]")
    axes["slip"].axhline(1.0, color="0.5", ls=":", lw=1.0)
    for begin in numbers["slips"]:
        axes["slip"].axvline(begin, color="0.7", lw=0.8)
    axes["slip"].set_ylim(0.0, max(1.15, min(float(np.nanmax(numbers["slip"])), 3.0)))
    for place, (name, values) in enumerate(numbers["energies"].items()):
        if name == "kinetic" or np.any(values):
            axes["energy"].plot(time, values, color=style.colour(place), label=name)
    for name, values in numbers["lost"].items():
        axes["energy"].plot(time, values, color=style.loss_colour(name), ls="--", label=f"lost: {name}")
    axes["energy"].set_ylabel("energy [J]")
    axes["energy"].set_xlabel("time [s]")
    style.name_beside(axes["energy"])


def draw_all(found: PlanarMotion) -> Figure:
    """Draw the figure."""
    with style.styled():
        made, axes = style.figure(7.4, 9.0, 4, 1, height_ratios=[1.8, 1.0, 1.0, 1.2])
        for ax in axes[1:3]:
            ax.sharex(axes[3])
            ax.tick_params(labelbottom=False)
        draw(dict(zip(("path", "speed", "slip", "energy"), axes, strict=True)), data(found))
    return made
