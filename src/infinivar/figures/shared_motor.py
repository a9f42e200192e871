"""Break-even of one power motor with n legs against a motor for each joint, over duty and holding force."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.analysis.shared_motor import SharedMotor
from infinivar.figures import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_WAYS = {"turning": "cylinder always turning", "stopped": "cylinder stopped while idle"}


def data(found: SharedMotor) -> dict[str, Any]:
    """Break-even forces.

    Returns
    -------
    dict
        duty (D,) [%], rising; legs (N,); turning and stopped (D, N): force from which the shared motor draws less [N], inf if
        none of those compared; highest: largest force compared [N].
    """
    order = np.argsort(found.duty)
    return {
        "duty": 100.0 * np.asarray(found.duty)[order],
        "legs": found.legs,
        "turning": found.least_force()[order],
        "stopped": found.least_force(stopped=True)[order],
        "highest": float(np.max(found.force)),
    }


def draw(ax: Axes, numbers: dict[str, Any], way: str) -> None:
    """Draw the break-even forces with the cylinder "turning" or "stopped" while idle."""
    duty, highest = numbers["duty"], numbers["highest"]
    for place, (count, colour) in enumerate(zip(numbers["legs"], _colours(len(numbers["legs"])), strict=True)):
        force = numbers[way][:, place]
        ax.plot(
            duty,
            np.where(np.isfinite(force), force, np.nan),
            color=colour,
            label=f"{count} leg{'' if count == 1 else 's'}",
        )
    ax.set_xlim(0.0, 100.0)
    ax.set_ylim(0.0, highest)
    ax.set_title(_WAYS[way])
    ax.set_xlabel("share of time in which the force is held [%]")


def draw_all(found: SharedMotor | Sequence[SharedMotor], titles: Sequence[str] = ()) -> Figure:
    """Draw the figure: a row for each comparison, with its title."""
    rows = [found] if isinstance(found, SharedMotor) else list(found)
    with style.styled():
        made, axes = style.figure(7.4, 0.7 + 2.9 * len(rows), len(rows), 2, sharex=True, sharey=True, squeeze=False)
        for one, row, title in zip(rows, axes, [*titles, *[""] * len(rows)], strict=False):
            numbers = data(one)
            for ax, way in zip(row, _WAYS, strict=True):
                draw(ax, numbers, way)
            row[0].set_ylabel(
                f"{title}\nholding force of each joint [N]" if title else "holding force of each joint [N]"
            )
        for ax in axes[:-1].flat:
            ax.set_xlabel("")
        for ax in axes[1:].flat:
            ax.set_title("")
        handles, labels = axes[0, 0].get_legend_handles_labels()
        words = "One motor draws less power than a motor for each joint above the line of"
        made.legend(handles, labels, loc="outside lower center", ncols=len(labels), title=words, title_fontsize=8)
    return made


def _colours(count: int) -> list[str]:
    return [style.COLOURS[place % len(style.COLOURS)] for place in range(count)]
