"""A measured set compared with its law: predicted over measured, and residuals."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.calibration.measured.report import MeasuredReport
from infinivar.calibration.measured.words import scaled
from infinivar.figures import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST = 150
"""Points drawn of a part; of more, every second, third ..."""


def data(report: MeasuredReport) -> dict[str, dict[str, Any]]:
    """By signal: ``unit``, ``axis``, ``by`` (column that names the parts) and ``parts``: by name what is drawn of each.

    A part has ``over``, ``measured``, ``expected``, ``predicted`` and ``half`` (n,).
    """
    found, axis = {}, report.parts[0].rows.abscissa[1]
    for place, signal in enumerate(report.parts[0].rows.signals):
        parts = {}
        unit, factor = scaled(report.totals[place].mean, report.totals[place].unit)
        for part in report.parts:
            parts[part.name] = {
                "over": part.rows.abscissa[0],
                "measured": factor * part.rows.read[:, place],
                "expected": factor * part.expected[:, place],
                "predicted": factor * part.predicted[:, place],
                "half": factor * part.half[:, place],
            }
        found[signal] = {"unit": unit, "axis": axis, "by": report.set.by, "parts": parts}
    return found


def draw_predicted(ax: Axes, signal: str, numbers: Mapping[str, Any]) -> None:
    """Draw expected over measured readings; crosses are rows predicted by fits without them."""
    ends = np.concatenate([part["measured"] for part in numbers["parts"].values()])
    ax.plot([ends.min(), ends.max()], [ends.min(), ends.max()], color="black", lw=0.8)
    for place, (name, part) in enumerate(numbers["parts"].items()):
        every = slice(None, None, max(len(part["measured"]) // _MOST, 1))
        colour = style.colour(place)
        ax.plot(
            part["measured"][every], part["expected"][every], "o", ms=3, mfc="none", color=colour, label=name or None
        )
        ax.plot(part["measured"][every], part["predicted"][every], "x", ms=3, lw=0.6, color=colour, alpha=0.6)
    ax.set(xlabel=f"{signal} measured [{numbers['unit']}]", ylabel=f"fitted (o), left out (x) [{numbers['unit']}]")
    if any(numbers["parts"]):
        ax.legend(title=numbers["by"], fontsize="x-small", title_fontsize="x-small")


def draw_residual(ax: Axes, signal: str, numbers: Mapping[str, Any]) -> None:
    """Draw measured less expected over a column of the set, with the mean half-width of the 95 % prediction intervals."""
    halves = [float(np.nanmean(part["half"])) for part in numbers["parts"].values() if np.isfinite(part["half"]).any()]
    if halves:
        half = float(np.mean(halves))
        ax.axhspan(-half, half, color="#e8edf2", zorder=0)
    for place, part in enumerate(numbers["parts"].values()):
        every = slice(None, None, max(len(part["measured"]) // _MOST, 1))
        off = (part["measured"] - part["expected"])[every]
        ax.plot(part["over"][every], off, "o", ms=3, mfc="none", color=style.colour(place))
    ax.axhline(0.0, color="black", lw=0.8)
    ax.set(xlabel=numbers["axis"], ylabel=f"{signal}, measured less fitted [{numbers['unit']}]")


def draw_all(report: MeasuredReport) -> Figure:
    """Draw each signal: fitted and predicted over measured, and residuals."""
    numbers = data(report)
    with style.styled():
        made, axes = style.figure(9.0, 3.4 * len(numbers), rows=len(numbers), columns=2)
        for row, (signal, one) in zip(np.reshape(axes, (-1, 2)), numbers.items(), strict=True):
            draw_predicted(row[0], signal, one)
            draw_residual(row[1], signal, one)
    return made
