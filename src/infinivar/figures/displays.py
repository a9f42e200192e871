"""Energy of a session on a cobotic display and on conventional ones, by part and number of axes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.displays.comparison import DisplayComparison
from infinivar.figures import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_WORDS = {
    "free": "free motion",
    "contact": "contact",
    "hold": "holding",
    "explore": "exploring",
    "idle": "idle",
    "run-up": "run-ups",
}


def data(found: DisplayComparison) -> dict[str, Any]:
    """Energies of a round.

    Returns
    -------
    dict
        axes (N,); parts; displays; energy (D, N, 6) as shown [J]; low, high (D, N): of the variants that meet the requirement,
        nan where none does [J].
    """
    total = np.where(found.feasible, found.total, np.nan)
    known = np.any(np.isfinite(total), axis=0)
    low, high = (np.where(known, end, np.nan) for end in (np.nanmin(np.where(known, total, 0.0), axis=0),
                                                          np.nanmax(np.where(known, total, 0.0), axis=0)))  # fmt: skip
    return {
        "axes": np.asarray(found.axes),
        "parts": found.parts,
        "displays": found.displays,
        "energy": np.asarray(found.energy)[0],
        "low": low,
        "high": high,
    }


def draw(ax: Axes, numbers: dict[str, Any], place: int) -> None:
    """Draw the energies of one display as stacked bars, with the range of the variants."""
    axes, base = numbers["axes"], np.zeros(len(numbers["axes"]))
    for part, colour in zip(range(len(numbers["parts"])), style.COLOURS, strict=False):
        energy = numbers["energy"][place, :, part]
        name = numbers["parts"][part]
        ax.bar(axes, energy, 0.7, bottom=base, color=colour, label=_WORDS.get(name, name))
        base = base + energy
    low, high = numbers["low"][place], numbers["high"][place]
    ax.vlines(axes, low, high, color="black", linewidth=1.2)
    for end in (low, high):
        ax.plot(axes, end, linestyle="none", marker="_", color="black", markersize=7)
    ax.set_title(numbers["displays"][place])
    ax.set_xticks(axes)
    ax.set_xlabel("axes")


def draw_all(found: DisplayComparison) -> Figure:
    """Draw the figure: a panel for each way to run a display."""
    numbers = data(found)
    with style.styled():
        made, panels = style.figure(2.25 * len(numbers["displays"]), 3.6, 1, len(numbers["displays"]), sharey=True)
        for place, ax in enumerate(np.atleast_1d(panels)):
            draw(ax, numbers, place)
        panels[0].set_ylabel(f"energy of a round of {found.session.round_time:g} s [J]")
        handles, labels = panels[0].get_legend_handles_labels()
        made.legend(
            handles,
            labels,
            loc="outside lower center",
            ncols=len(labels),
            title="Lines: range with other assumed values",
            title_fontsize=8,
        )
    return made
