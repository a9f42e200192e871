"""Results of the calibration of a geared drive: loss measured and fitted, residuals, correlations."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.calibration.geared.result import GearedCalibration
from infinivar.figures import style
from infinivar.figures.calibration import three_panels
from infinivar.study.spreads import NORMAL_95

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_UNITS = {"current": "A", "voltage": "V", "power": "W", "efficiency": "1"}


def data(calibration: GearedCalibration) -> dict[str, Any]:
    """Readings and fit of the rows used, residuals in standard deviations, and correlations.

    Returns
    -------
    dict
        ``read`` and ``fitted`` (n, m) by ``signals``; ``over`` (n,) with its label ``axis``: torque, or time; ``residuals``
        (n, m); ``correlations`` (p, p) of ``names``.
    """
    fit, problem = calibration.fit, calibration.fit.problem
    runs = problem.data
    at, axis = (runs.torque, "torque on the load [N m]") if runs.kind == "dynamometer" else (runs.time, "time [s]")
    return {
        "signals": runs.signals,
        "read": runs.read,
        "fitted": problem.expected(fit.unknowns),
        "over": np.asarray(at),
        "axis": axis,
        "residuals": problem.of_runs(problem.residuals(fit.unknowns)),
        "names": [name for name in fit.names if name in fit.told],
        "correlations": fit.correlations[np.ix_(*2 * ([name in fit.told for name in fit.names],))],
    }


def draw_readings(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw the first reading, measured and fitted."""
    name = numbers["signals"][0]
    ax.plot(numbers["over"], numbers["read"][:, 0], "o", color=style.COLOURS[0], ms=4, label="measured")
    ax.plot(numbers["over"], numbers["fitted"][:, 0], "+", color=style.COLOURS[1], ms=6, label="fitted")
    ax.set(xlabel=numbers["axis"], ylabel=f"motor {name} [{_UNITS[name]}]")
    ax.set_title(f"Measured and fitted {name}")
    ax.legend(loc="best", fontsize=8)


def draw_residuals(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw the residuals in standard deviations of the noise."""
    residuals = numbers["residuals"]
    for place, (name, marker) in enumerate(zip(numbers["signals"], "osD^", strict=False)):
        ax.plot(numbers["over"], residuals[:, place], marker, color=style.COLOURS[place], ms=3.5, label=name)
    ax.axhspan(-NORMAL_95, NORMAL_95, color="#e8edf2", zorder=0)
    reach = max(3.2, 1.15 * float(np.max(np.abs(residuals), initial=0.0)))
    ax.set(xlabel=numbers["axis"], ylabel="residual / standard deviation", ylim=(-reach, 1.45 * reach))
    ax.set_title("Residuals (95 % expected in the grey band)")
    ax.legend(loc="upper center", ncols=4, fontsize=8)


def draw_all(calibration: GearedCalibration) -> Figure:
    """Draw all three panels."""
    return three_panels(data(calibration), draw_readings, draw_residuals)
