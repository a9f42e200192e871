"""Results of a calibration: measured and fitted efficiency over the ratio, residuals, correlations."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.calibration.result import Calibration
from infinivar.calibration.virtual_rig import with_preload
from infinivar.figures import style
from infinivar.study.spreads import NORMAL_95
from infinivar.units import plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_READINGS = ("link travel", "motor current", "motor voltage")


def data(calibration: Calibration, count: int = 401) -> dict[str, Any]:
    """Efficiencies measured and fitted by load and direction, residuals by run, correlations.

    Returns
    -------
    dict
        ``curves``: one a load and direction, with the measured points that were fitted; ``residuals`` (n, m) in standard
        deviations, of the runs used, in ``lines``; ``correlations`` (p, p) of ``names``.
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
    fit = calibration.fit
    return {
        "curves": curves,
        "residuals": fit.problem.of_runs(fit.problem.residuals(fit.unknowns)),
        "pressed": fit.problem.data.pressed,
        "lines": np.asarray(fit.problem.data.lines),
        "names": [name for name in fit.names if name in fit.told],
        "correlations": fit.correlations[np.ix_(*2 * ([name in fit.told for name in fit.names],))],
    }


def draw_efficiency(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw efficiency over the reduction ratio, in the form of Fig 7."""
    from matplotlib.ticker import StrMethodFormatter

    kinds = sorted({(curve["preload"], curve["load"]) for curve in numbers["curves"]}, reverse=True)
    several = len({preload for preload, _ in kinds}) > 1
    for curve in numbers["curves"]:
        colour = style.COLOURS[kinds.index((curve["preload"], curve["load"])) % len(style.COLOURS)]
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
    """Draw the residuals of the fitted runs, in standard deviations of the sensors."""
    residuals = numbers["residuals"]
    for column, marker, colour in zip(range(residuals.shape[1]), "osD", style.COLOURS, strict=False):
        values = np.where(numbers["pressed"], residuals[:, column], np.nan) if column == 0 else residuals[:, column]
        ax.plot(numbers["lines"], values, marker, color=colour, ms=3.5, label=_READINGS[column])
    ax.axhspan(-NORMAL_95, NORMAL_95, color="#e8edf2", zorder=0)
    reach = max(3.2, 1.15 * float(np.max(np.abs(residuals), initial=0.0)))
    ax.set(xlabel="line of the data file", ylabel="residual / standard deviation", ylim=(-reach, 1.45 * reach))
    ax.set_title("Residuals (95 % expected in the grey band)")
    ax.legend(loc="upper center", ncols=3, fontsize=8)


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


def draw_all(calibration: Calibration) -> Figure:
    """Draw all three panels."""
    return three_panels(data(calibration), draw_efficiency, draw_residuals)


def three_panels(
    numbers: dict[str, Any], draw_readings: Callable[..., None], draw_residuals: Callable[..., None]
) -> Figure:
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
