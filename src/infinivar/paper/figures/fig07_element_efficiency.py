"""Figure 7: efficiency of the rolling-contact element against reduction ratio, by Eq 16, by Eq 17, and on a virtual rig."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.calibration import reduce, virtual_rig
from infinivar.figures import style
from infinivar.paper.claims.claim import Machine, efficiency_by
from infinivar.study.spreads import NORMAL_95

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LOADS = (0.15, 0.35, 0.5, 0.8, 0.95)
"""Link force over slip force. The paper names 0.15, 0.5 and 0.95 of its five loads."""

PRINTED = ((100.0, 0.50), (8.0, 0.94), (1.0, 0.50))
"""Ratio and efficiency of the points that the text states for half load."""

TITLE = "Efficiency of the element"

CAPTION = (
    "Efficiency of the element against reduction ratio. Solid: linear creep (Eq 16). Dashed: with the paper's correction above "
    "70 % of the slip force (Eq 17), which keeps the 0.95 curve below one third. Crosses: the three points that the text "
    "states for half load; 50 % at 1:1 does not follow from the equations. Curves end at the slip force. Slightly above 70 % of "
    "it, the link speed by Eq 17 implies a creepage beyond full slip, which the program reports as slip. "
    "Circles: a simulated experiment, not the paper's data. It follows the paper's protocol on the virtual rig, with sensor "
    "noise and errors, evaluated by Eq 18. The load is the weight plus the guideway friction, which is assumed known; bars are "
    "95 % intervals of efficiency and ratio."
)


def data(machine: Machine, count: int = 1201) -> dict[str, Any]:
    """Curves and simulated measurements.

    Returns
    -------
    dict
        ratio; linear, faulring: efficiency (nan beyond the slip force) by load, for Eq 16 and Eq 17; measured: by load, see
        `measured`.
    """
    ratio = np.geomspace(0.3, 1000.0, count)
    curves = {
        law: {load: efficiency_by(replace(machine.element, creep_law=law), load, ratio) for load in LOADS}
        for law in ("linear", "faulring")
    }
    return {"ratio": ratio, **curves, "measured": measured(machine)}


def measured(machine: Machine, seed: int = 0) -> dict[float, dict[str, np.ndarray]]:
    """Simulate the paper's experiment on the virtual rig: lift a mass at fixed steering angles under two loads.

    Parameters
    ----------
    seed : int   Seed of the sensor errors.

    Returns
    -------
    dict
        By load: ratio, as set; efficiency by Eq 18; and their standard deviations `ratio_deviation` and
        `efficiency_deviation`.

    Source: faulring2006, section IV-B.
    """
    drive, rig, element = machine.drive, machine.study.rig, machine.element
    drag = drive.guideway.friction_force(element.preload)
    # The link lifts the mass against guideway friction; the load is the sum of both.
    weights = [load - drag / element.slip_force for load in virtual_rig.LOADS]
    settings = virtual_rig.protocol(drive, rig, loads=weights)
    runs = virtual_rig.experiment(drive, rig, settings, seed=seed, simulated=False).data
    found = reduce.efficiencies(drive, rig, runs, guideway_friction=drag, nominal=0.0)
    off = np.hypot(rig.steering_zero_deviation, rig.steering_resolution / np.sqrt(12.0))
    by_load = {}
    for load, weight in zip(virtual_rig.LOADS, weights, strict=True):
        rows = np.flatnonzero(found.lifts & np.isfinite(found.value) & np.isclose(found.load, weight, rtol=1e-6))
        rows = rows[np.argsort(found.ratio[rows])]
        ratio = found.ratio[rows]
        by_load[load] = {
            "ratio": ratio,
            "efficiency": found.value[rows],
            "ratio_deviation": off * (1.0 + ratio**2),  # ratio = 1/tan(angle)
            "efficiency_deviation": found.deviation[rows],
        }
    return by_load


def draw(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw the curves, the printed points and the simulated measurements."""
    ratio = numbers["ratio"]
    colours = dict(zip(LOADS, style.COLOURS, strict=False))
    for load, colour in colours.items():
        ax.semilogx(ratio, numbers["linear"][load], color=colour, label=f"$f_l/(\\mu P)$ = {load:g}")
        ax.semilogx(ratio, numbers["faulring"][load], color=colour, ls="--", lw=1.1)
    for load, points in numbers["measured"].items():
        ax.errorbar(
            points["ratio"],
            points["efficiency"],
            NORMAL_95 * points["efficiency_deviation"],
            NORMAL_95 * points["ratio_deviation"],
            fmt="o",
            color=colours[load],
            mfc="white",
            ms=4.5,
            lw=1.0,
            capsize=2,
            zorder=3,
        )
    ax.plot(*zip(*PRINTED, strict=True), "kx", ms=7, mew=1.6, zorder=4, label="stated for 0.5")
    ax.plot([], [], color="grey", label="Eq 16 (solid)")
    ax.plot([], [], color="grey", ls="--", lw=1.1, label="Eq 17 (dashed)")
    ax.errorbar([], [], [], fmt="o", color="grey", mfc="white", ms=4.5, lw=1.0, capsize=2, label="simulated experiment")
    ratio_axis(ax)
    ax.set_ylim(0.0, 1.02)
    ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))


def ratio_axis(ax: Axes) -> None:
    """Set up the axes of figures that show efficiency against reduction ratio."""
    ax.set_xlim(0.3, 1000.0)
    ax.set_xticks([1, 10, 100, 1000], ["1:1", "10:1", "100:1", "1000:1"])
    ax.set_ylim(0.0, 1.0)
    ax.set_xlabel(r"reduction ratio $1/|\tan\phi|$, cylinder surface speed : link speed")
    ax.set_ylabel("efficiency [-]")


def draw_all(machine: Machine) -> Figure:
    """Draw the figure."""
    with style.styled():
        made, ax = style.figure(7.4, 4.0)
        draw(ax, data(machine))
    return made
