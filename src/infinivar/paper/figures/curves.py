"""Figures 5, 7 and 8: creep of the contact, and efficiency of the element, on a virtual rig and against gears."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.calibration import reduce, virtual_rig
from infinivar.contact import creep, exact_tables
from infinivar.figures import gear_points, style
from infinivar.paper.claims.claim import PaperMachine, at_ratio, efficiency_by
from infinivar.study.spreads import NORMAL_95

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LOADS = (0.15, 0.35, 0.5, 0.8, 0.95)
"""Link force over slip force. The paper names 0.15, 0.5 and 0.95 of its five loads."""

PRINTED = ((100.0, 0.50), (8.0, 0.94), (1.0, 0.50))
"""Ratio and efficiency of the points that the text states for half load."""

_THREE_LOADS = (0.15, 0.5, 0.95)


def creep_curves(machine: PaperMachine) -> dict[str, Any]:
    """Scaled creepage ``C u/(mu P |v|)`` and force ratio ``fu/(mu P)`` by the linear law and by exact theory.

    Source: faulring2006, Fig 5.
    """
    creepage = np.linspace(0.0, 3.0, 301)
    curves = {
        float(curve["a_over_b"]): (3.0 * curve["scaled_creepage"], curve["force_ratio"])
        for curve in exact_tables.lateral_creep()
    }
    return {"linear": (creepage, creep.linear_force(creepage)), "exact": curves}


def draw_creep(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw the curves of the linear law and of exact theory."""
    ax.axhspan(0.6, 0.7, color="#eeeeee")
    for colour, (a_over_b, curve) in zip(style.COLOURS, numbers["exact"].items(), strict=False):
        ax.plot(*curve, "o-", ms=3, color=colour, label=f"exact rolling theory, a/b = {a_over_b:g}")
    ax.plot(*numbers["linear"], color="black", ls="--", label="linear law, then slip (Eq 7)")
    ax.text(2.95, 0.65, "60-70 % of slip force", ha="right", va="center", fontsize=8)
    ax.set_xlim(0.0, 3.0)
    ax.set_ylim(0.0, 1.08)
    ax.set_xlabel(r"scaled creepage  $C_{22}Gab\,u\,/\,(\mu P\,|r\dot\theta|)$  [-]")
    ax.set_ylabel(r"lateral force over slip force  $f_u/(\mu P)$  [-]")
    ax.legend(loc="lower right")


def efficiency(machine: PaperMachine, count: int = 1201) -> dict[str, Any]:
    """Curves by Eq 16 and by Eq 17, and simulated measurements.

    Returns
    -------
    dict
        ratio; linear, faulring: efficiency (nan beyond the slip force) by load, for Eq 16 and Eq 17; measured: by load, see
        `measured`.

    Source: faulring2006, Fig 7.
    """
    ratio = np.geomspace(0.3, 1000.0, count)
    curves = {
        law: {load: efficiency_by(replace(machine.element, creep_law=law), load, ratio) for load in LOADS}
        for law in ("linear", "faulring")
    }
    return {"ratio": ratio, **curves, "measured": measured(machine)}


def measured(machine: PaperMachine, seed: int = 0) -> dict[float, dict[str, np.ndarray]]:
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


def draw_efficiency(ax: Axes, numbers: Mapping[str, Any]) -> None:
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


def against_gears(machine: PaperMachine) -> dict[str, Any]:
    """Element curves by load, and gears by type as (ratio, efficiency, confidence).

    Source: faulring2006, Fig 8.
    """
    ratio = np.geomspace(0.3, 1000.0, 801)
    return {
        "ratio": ratio,
        "element": {load: at_ratio(machine.element, load, ratio).efficiency for load in _THREE_LOADS},
        "gears": gear_points.gears(),
    }


def draw_against_gears(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw the curves and the gears; the lower the confidence, the paler and smaller the marker."""
    for load, width in zip(_THREE_LOADS, (1.0, 1.7, 2.4), strict=True):
        label = f"element, $f_l/(\\mu P)$ = {load:g}"
        ax.semilogx(numbers["ratio"], numbers["element"][load], color="black", lw=width, label=label)
    gear_points.draw(ax, numbers["gears"])
    ratio_axis(ax)
    ax.set_xlim(0.3, 2000.0)
    ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
