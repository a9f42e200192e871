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


def regions(found: SharedMotor) -> np.ndarray:
    """Which machine draws less power. (N, F, D) int, duty rising

    0: separate motors; 1: the shared motor if the cylinder stops while idle; 2: also if it always turns; 3: one of them cannot
    hold the force.
    """
    order = np.argsort(found.duty)
    turning, stopping, separate = (
        np.moveaxis(np.asarray(one)[order], 0, -1) for one in (found.turning, found.stopping, found.separate)
    )
    # Turning may be better where idle spells are shorter than a run-up pays for.
    won = np.where(turning < separate, 2, np.where(stopping < separate, 1, 0))
    held = np.asarray(found.turning_feasible) & np.asarray(found.separate_feasible)
    return np.where(held[..., None], won, 3)


def draw_map(found: SharedMotor | Sequence[SharedMotor], titles: Sequence[str] = ()) -> Figure:
    """Draw which machine draws less over duty and holding force: a row for each comparison, a column for each number of legs."""
    from matplotlib.colors import BoundaryNorm, ListedColormap
    from matplotlib.patches import Patch

    rows = [found] if isinstance(found, SharedMotor) else list(found)
    columns = max(len(one.legs) for one in rows)
    shades = ["#F3C6A5", "#BFD9EA", "#5B9BC8", "#DDDDDD"]
    words = [
        "conventional, a motor for each axis, draws less",
        "cobotic, one motor, if its cylinder stops while idle",
        "cobotic, one motor, even if its cylinder turns",
        "one of them cannot hold the force",
    ]
    with style.styled():
        made, axes = style.figure(
            1.6 + 1.5 * columns, 1.0 + 2.1 * len(rows), len(rows), columns, sharex=True, sharey=True, squeeze=False
        )
        shown: set[int] = set()
        for one, row, title in zip(rows, axes, [*titles, *[""] * len(rows)], strict=False):
            duty, force = 100.0 * np.sort(np.asarray(one.duty)), np.asarray(one.force)
            for ax, count, area in zip(row, one.legs, regions(one), strict=False):
                shown.update(np.unique(area).tolist())
                ax.pcolormesh(
                    duty,
                    force,
                    area,
                    cmap=ListedColormap(shades),
                    norm=BoundaryNorm(np.arange(5) - 0.5, 4),
                    shading="nearest",
                    rasterized=True,
                )
                ax.set_title(f"{count} ax{'i' if count == 1 else 'e'}s")
                ax.set_xlim(0.0, 100.0)
                ax.set_ylim(force[0], force[-1])
            row[0].set_ylabel(f"{title}\nforce of each axis [N]" if title else "force of each axis [N]")
        for ax in axes[1:].flat:
            ax.set_title("")
        for ax in axes[-1]:
            ax.set_xlabel("time held [%]")
        patches = [Patch(facecolor=shades[one], label=words[one]) for one in sorted(shown)]
        made.legend(handles=patches, loc="outside lower center", ncols=2)
    return made


def _colours(count: int) -> list[str]:
    return [style.colour(place) for place in range(count)]
