"""A planar arm in one task: its picture, and the forces it can exert."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.figures import pictures, style
from infinivar.limits import Limit
from infinivar.machines.kinds.arm import ArmDrive

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_WAYS = 72
"""Directions in which the largest force is sought."""

_DOUBLINGS, _HALVINGS = 30, 30
_LEAST = 1e-3
"""Force with which the search starts. [N]"""

_EDGES = {Limit.SLIP: style.COLOURS[0], Limit.THERMAL: style.COLOURS[1]}
_OTHER = style.COLOURS[3]
_AREAS = {"at rest": ("#CFE3F1", "-"), "in the task": ("#F3E3CF", "--")}

Sets = Mapping[str, tuple[np.ndarray, np.ndarray]]
"""By "at rest" and "in the task": outlines of the forces (m, 2) within all limits, with the limit beyond each (m,). [N]"""


def data(drive: ArmDrive, pose: Any, twist: Any, wrench: Any) -> Sets:
    """Forces within all limits, at rest and in motion, if the moment stays that of the task; none of an arm of one joint.

    Parameters
    ----------
    drive : ArmDrive
    pose, twist, wrench : (d,) float   In its coordinates; the wrench on the load.
    """
    row, rate, load = (np.asarray(one, dtype=float) for one in (pose, twist, wrench))
    if len(drive.lengths) == 1:
        return {}
    rates = {"at rest": np.zeros_like(rate), **({"in the task": rate} if np.any(rate) else {})}
    found = {name: _outline(drive, row, one, load) for name, one in rates.items()}
    return {name: one for name, one in found.items() if one is not None}


def _outline(
    drive: ArmDrive, pose: np.ndarray, twist: np.ndarray, wrench: np.ndarray
) -> tuple[np.ndarray, np.ndarray] | None:
    """Largest force in each direction within all limits, by bisection from no force, and the limit beyond it."""
    way = 2.0 * np.pi * np.arange(_WAYS) / _WAYS
    unit = np.stack([np.cos(way), np.sin(way)], axis=-1)

    def limit(size: np.ndarray) -> np.ndarray:
        requested = np.broadcast_to(wrench, (_WAYS, len(wrench))).copy()
        requested[:, :2] = size[:, None] * unit
        return np.asarray(drive.perform(pose=pose, twist=twist, wrench=requested).limit)

    low, high = np.zeros(_WAYS), np.full(_WAYS, _LEAST)
    if np.any(limit(low) != Limit.OK):
        return None
    for _ in range(_DOUBLINGS):
        good = limit(high) == Limit.OK
        if not good.any():
            break
        low, high = np.where(good, high, low), np.where(good, 2.0 * high, high)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        good = limit(middle) == Limit.OK
        low, high = np.where(good, middle, low), np.where(good, high, middle)
    return low[:, None] * unit, limit(high)


def draw(ax: Axes, sets: Sets, force: np.ndarray) -> set[int]:
    """Draw the forces within all limits, with that of the task (2,); returns the limits beyond them."""
    beyond: set[int] = set()
    for name, (outline, limits) in sets.items():
        area, line = _AREAS[name]
        ax.fill(*outline.T, facecolor=area, edgecolor="none", alpha=0.8, zorder=1)
        for place, limit in enumerate(limits):
            ends = outline[[place, (place + 1) % len(outline)]]
            ax.plot(*ends.T, color=_EDGES.get(Limit(int(limit)), _OTHER), lw=1.6, ls=line, zorder=2)
        beyond |= set(limits.tolist())
    ax.plot(0.0, 0.0, marker="+", color="black", ms=6, mew=0.8, zorder=3)
    if np.any(force):
        style.arrow(ax, np.zeros(2), force, "#000000", lw=1.6, size=10)
    ax.margins(0.08)
    ax.set_aspect("equal", adjustable="datalim")
    ax.set_xlabel("force on the load along x [N]")
    ax.set_ylabel("along y [N]")
    ax.set_title("forces within all limits", fontsize=9)
    return beyond


def draw_all(drive: ArmDrive, point: Any, pose: Any, twist: Any, wrench: Any) -> Figure:
    """Draw the figure of an operating point of it; the rest as in `data`."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    picture, sets = drive.picture(point, pose, twist, wrench), data(drive, pose, twist, wrench)
    key = pictures.handles(picture)
    with style.styled():
        if not sets:
            return pictures.draw_all(picture)
        made, (ax, beside) = style.figure(8.6, 4.6, 1, 2)
        pictures.draw(ax, picture)
        beyond = draw(beside, sets, np.asarray(wrench, dtype=float)[:2])
        for name in sets:
            area, line = _AREAS[name]
            key.append(Patch(facecolor=area, edgecolor="#555555", ls=line, label=f"forces {name}"))
        names: dict[str, list[str]] = {}
        for limit in sorted(beyond):
            names.setdefault(_EDGES.get(Limit(limit), _OTHER), []).append(Limit(limit).words)
        key += [Line2D([], [], color=colour, lw=1.8, label=f"limit: {', '.join(one)}") for colour, one in names.items()]
        made.legend(handles=key, loc="outside lower center", ncols=3)
    return made
