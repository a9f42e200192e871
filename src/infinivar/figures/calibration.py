"""Results of a calibration: efficiency over the ratio or a reading, measured and fitted; residuals, correlations."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.calibration.fit import Fit
from infinivar.calibration.geared import SIGNALS
from infinivar.calibration.result import Calibration, GearedCalibration
from infinivar.calibration.virtual_rig import with_preload
from infinivar.figures import style
from infinivar.study.spreads import NORMAL_95
from infinivar.units import plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def data(calibration: Calibration, count: int = 401) -> dict[str, Any]:
    """Efficiencies measured and fitted by load and direction, residuals by run, correlations.

    Returns
    -------
    dict
        ``curves``: one a load and direction, with the measured points that were fitted; and what `_of_fit` states.
    """
    found, rig = calibration.efficiencies, calibration.study.rig
    runs, drive = calibration.data, calibration.calibrated
    used = np.isfinite(found.ratio) & np.isfinite(found.load)
    used[[one.row for one in calibration.left_out]] = False
    ratio = np.geomspace(0.8 * found.ratio[used].min(initial=1.0), 1.25 * found.ratio[used].max(initial=100.0), count)
    curves = []
    groups = {
        (float(runs.preload[row]), round(float(found.load[row]), 6), bool(found.lifts[row]))
        for row in np.flatnonzero(used)
    }
    for preload, load, lifts in sorted(groups):
        members = used & (np.abs(found.load - load) < 1e-5) & (found.lifts == lifts) & (runs.preload == preload)
        way = 1.0 if lifts else -1.0
        angle = -way * np.sign(drive.cylinder_speed) * np.arctan(1.0 / ratio)
        force = float(runs.mass[members][0]) * rig.gravity + way * drive.guideway.friction_force(preload)
        point = with_preload(drive.transmission, preload).operate(
            cylinder_speed=drive.cylinder_speed, steering_angle=angle, link_force=force
        )
        curves.append(
            {
                "load": load,
                "preload": preload,
                "lifts": lifts,
                "ratio": ratio,
                "fitted": point.efficiency,
                "at": found.ratio[members],
                "measured": found.value[members],
                "deviation": found.deviation[members],
            }
        )
    return {"curves": curves, **_of_fit(calibration.fit)}


def _of_fit(fit: Fit) -> dict[str, Any]:
    """``residuals`` (n, m) by ``signals`` in standard deviations, nan where a reading is not used; ``over`` (n,) with its label
    ``axis``; ``correlations`` (p, p) of the identifiable ``names``."""
    problem, identifiable = fit.problem, [name in fit.identifiable for name in fit.names]
    over, axis = problem.data.abscissa
    return {
        "signals": problem.data.signals,
        "residuals": np.where(problem.used, problem.of_rows(problem.residuals(fit.unknowns)), np.nan),
        "over": over,
        "axis": axis,
        "names": list(fit.identifiable),
        "correlations": fit.correlations[np.ix_(identifiable, identifiable)],
    }


def draw_efficiency(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw efficiency over the reduction ratio, in the form of Fig 7."""
    from matplotlib.ticker import StrMethodFormatter

    kinds = sorted({(curve["preload"], curve["load"]) for curve in numbers["curves"]}, reverse=True)
    several = len({preload for preload, _ in kinds}) > 1
    for curve in numbers["curves"]:
        colour = style.colour(kinds.index((curve["preload"], curve["load"])))
        pressed = f", {plain(curve['preload'], 3)} N" if several else ""
        lifts = curve["lifts"]
        ax.semilogx(curve["ratio"], curve["fitted"], color=colour, ls="-" if lifts else "--", lw=1.3)
        ax.errorbar(
            curve["at"],
            curve["measured"],
            NORMAL_95 * curve["deviation"],
            fmt="o" if lifts else "s",
            mfc=colour if lifts else "white",
            color=colour,
            ms=4.5,
            capsize=2,
            lw=1,
            label=f"$f_l/(\\mu P)$ = {curve['load']:.2g}, {'lifting' if lifts else 'lowering'}{pressed}",
        )
    ax.set(xlabel="reduction ratio $1/|\\tan\\phi|$", ylabel="efficiency of the element", ylim=(0, 1.03))
    ax.xaxis.set_major_formatter(StrMethodFormatter("{x:g}:1"))
    ax.set_title("Measured (Eq 18) and fitted efficiency")
    ax.legend(loc="lower left", fontsize=8)


def draw_residuals(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw the residuals of the fitted rows, in standard deviations."""
    for place, (name, marker) in enumerate(zip(numbers["signals"], "osD^", strict=False)):
        ax.plot(
            numbers["over"],
            numbers["residuals"][:, place],
            marker,
            color=style.colour(place),
            ms=3.5,
            label=name.replace("_", " "),
        )
    ax.axhspan(-NORMAL_95, NORMAL_95, color="#e8edf2", zorder=0)
    reach = max(3.2, 1.15 * float(np.nanmax(np.abs(numbers["residuals"]), initial=0.0)))
    ax.set(xlabel=numbers["axis"], ylabel="residual / standard deviation", ylim=(-reach, 1.45 * reach))
    ax.set_title("Residuals (95 % expected in the grey band)")
    ax.legend(loc="upper center", ncols=4, fontsize=8)


def draw_correlations(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw the correlation matrix of the identifiable parameters."""
    names = [name.replace("_", "\n", 1) for name in numbers["names"]]
    matrix = numbers["correlations"]
    ax.imshow(matrix, cmap="coolwarm", vmin=-1, vmax=1)
    for (row, column), value in np.ndenumerate(matrix):
        ink = "white" if abs(value) > 0.75 else "black"
        ax.text(column, row, f"{value:.2f}", ha="center", va="center", color=ink, fontsize=8)
    ax.set_xticks(range(len(names)), names, fontsize=8)
    ax.set_yticks(range(len(names)), names, fontsize=8)
    ax.tick_params(length=0)
    ax.spines[:].set_visible(False)
    ax.set_title("Correlations of the estimates")


def geared_data(calibration: GearedCalibration) -> dict[str, Any]:
    """Readings and fit of the rows used.

    Returns
    -------
    dict
        ``read`` and ``fitted`` (n, m) by ``signals``; and what `_of_fit` states.
    """
    fit, problem = calibration.fit, calibration.fit.problem
    return {"read": problem.data.read, "fitted": problem.expected(fit.unknowns), **_of_fit(fit)}


def draw_readings(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw the first reading, measured and fitted."""
    name = numbers["signals"][0]
    ax.plot(numbers["over"], numbers["read"][:, 0], "o", color=style.COLOURS[0], ms=4, label="measured")
    ax.plot(numbers["over"], numbers["fitted"][:, 0], "+", color=style.COLOURS[1], ms=6, label="fitted")
    ax.set(xlabel=numbers["axis"], ylabel=f"motor {name} [{SIGNALS[name]}]")
    ax.set_title(f"Measured and fitted {name}")
    ax.legend(loc="best", fontsize=8)


def draw_all(calibration: Calibration) -> Figure:
    """Draw all three panels."""
    return _three_panels(data(calibration), draw_efficiency)


def draw_geared(calibration: GearedCalibration) -> Figure:
    """Draw all three panels of a geared drive."""
    return _three_panels(geared_data(calibration), draw_readings)


def _three_panels(numbers: dict[str, Any], draw_readings: Callable[..., None]) -> Figure:
    """Draw readings above residuals and correlations."""
    with style.styled():
        made, axes = style.figure(10.5, 7.6, 2, 2, height_ratios=(1.25, 1.0), width_ratios=(1.6, 1.0))
        grid = axes[0, 0].get_gridspec()
        axes[0, 0].remove()
        axes[0, 1].remove()
        draw_readings(made.add_subplot(grid[0, :]), numbers)
        draw_residuals(axes[1, 0], numbers)
        draw_correlations(axes[1, 1], numbers)
    return made
