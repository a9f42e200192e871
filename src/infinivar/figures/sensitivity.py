"""Tornado chart of the influence of each parameter over its range, with Sobol indices beside it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar import units
from infinivar.analysis.robustness.sensitivity import LARGEST, Sensitivity
from infinivar.figures import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LOW, _HIGH = style.COLOURS[0], style.COLOURS[1]


def data(sensitivity: Sensitivity) -> dict[str, Any]:
    """Rows by decreasing swing: name, range in words, outcome at both ends, Sobol indices (nan where not computed)."""
    rows = sensitivity.influences[:LARGEST]
    return {
        "words": sensitivity.outcome.words,
        "unit": sensitivity.outcome.unit,
        "value": sensitivity.value,
        "names": [row.words for row in rows],
        "ranges": [(units.show(row.low, row.unit), units.show(row.high, row.unit)) for row in rows],
        "at_low": np.asarray([row.at_low for row in rows]),
        "at_high": np.asarray([row.at_high for row in rows]),
        "first": np.asarray([np.nan if row.first is None else row.first for row in rows]),
        "lost": ["" if row.finite else f"{row.lost} at one end" for row in rows],
        "total": np.asarray([np.nan if row.total is None else row.total for row in rows]),
    }


def draw_tornado(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw bars from the nominal outcome to the outcome at either end of each parameter's range."""
    value, count = numbers["value"], len(numbers["names"])
    ends = np.concatenate([numbers["at_low"], numbers["at_high"], [value]])
    ends = ends[np.isfinite(ends)]
    reach = 0.42 * max(float(np.ptp(ends)), 1e-12 * abs(value) + 1e-300)
    left, right = float(ends.min()) - reach, float(ends.max()) + reach
    for row in range(count):
        for at, colour, said in (
            (numbers["at_low"][row], _LOW, numbers["ranges"][row][0]),
            (numbers["at_high"][row], _HIGH, numbers["ranges"][row][1]),
        ):
            if not np.isfinite(at) or at == value:
                continue
            ax.barh(row, at - value, left=value, color=colour, height=0.62)
            leftwards = at < value
            ax.annotate(
                said, (at, row), (-3 if leftwards else 3, 0), textcoords="offset points",
                ha="right" if leftwards else "left", va="center", fontsize=7,
            )  # fmt: skip
        if numbers["lost"][row]:
            ax.text(right, row, numbers["lost"][row], ha="right", va="center", fontsize=7, color="#B3400A")
    ax.axvline(value, color="black", lw=0.9)
    ax.set_xlim(left, right)
    ax.set_ylim(count - 0.4, -0.6)
    ax.set_yticks(range(count), numbers["names"], parse_math=False)
    unit = "" if numbers["unit"] == "1" else f" [{numbers['unit']}]"
    ax.set_xlabel(f"{numbers['words']}{unit}", parse_math=False)
    ax.set_title("One at a time: low end blue, high end orange")


def draw_sobol(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw first-order and total indices of the same parameters."""
    rows = np.arange(len(numbers["names"]))
    ax.barh(rows - 0.17, numbers["total"], height=0.32, color="#B9D7EA", label="total")
    ax.barh(rows + 0.17, numbers["first"], height=0.32, color=_LOW, label="first order")
    ax.set_ylim(len(rows) - 0.4, -0.6)
    ax.set_yticks([])
    ax.set_xlim(0.0, 1.0)
    ax.set_xlabel("share of the variance [-]")
    ax.set_title("All together: Sobol indices")
    ax.legend(loc="lower right")


def draw_all(sensitivity: Sensitivity) -> Figure:
    """Draw both side by side."""
    numbers = data(sensitivity)
    with style.styled():
        height = 1.5 + 0.36 * max(len(numbers["names"]), 2)
        made, axes = style.figure(10.8, height, 1, 2, width_ratios=(1.9, 1.0))
        draw_tornado(axes[0], numbers)
        draw_sobol(axes[1], numbers)
    return made
