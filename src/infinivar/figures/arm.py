"""A planar arm drawn from its geometry in one task: members, joints with their torques, and the forces it can exert."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.errors import InputError
from infinivar.figures import style
from infinivar.limits import Limit
from infinivar.machines.kinds.arm import ArmDrive

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_FORCE, _VELOCITY, _MEMBER = "#000000", style.COLOURS[2], "#56646F"
_ARROW = 0.3
"""Length of the arrows of force and velocity, over the length of the arm."""

_ALONG, _SHORT = 0.95, 0.6
"""Cosine of the angle between both arrows from which that of the force is shortened, and to what share."""

_WAYS = 72
"""Directions in which the largest force is sought."""

_DOUBLINGS, _HALVINGS = 30, 30
_LEAST = 1e-3
"""Force with which the search starts. [N]"""

_EDGES = {Limit.SLIP: style.COLOURS[0], Limit.THERMAL: style.COLOURS[1]}
_OTHER = style.COLOURS[3]
_AREAS = {"at rest": ("#CFE3F1", "-"), "in the task": ("#F3E3CF", "--")}


def data(drive: ArmDrive, pose: Any, twist: Any, wrench: Any) -> dict[str, Any]:
    """Geometry, torques and forces of an arm at one point.

    Parameters
    ----------
    drive : ArmDrive
    pose, twist, wrench : (d,) float   In its coordinates; the wrench on the load.

    Returns
    -------
    dict
        points (n + 1, 2): base, joints and end point [m]; torque (n,): of the joints on the load [N m]; loads: words for the
        largest demand on each joint; force, velocity (2,): of the end point [N], [m/s]; moment [N m]; turning [rad/s]; sets: by
        "at rest" and "in the task", outlines of the forces (m, 2) within all limits, with the limit beyond each (m,).

    Raises
    ------
    InputError
        If the point is not one within reach, or has no steady motion.
    """
    row, rate, load = (np.asarray(one, dtype=float) for one in (pose, twist, wrench))
    n = len(drive.lengths)
    point = drive.perform(pose=row, twist=rate, wrench=load)
    angles = drive.angles(row)
    torque = np.asarray(point.part_forces)
    if row.shape != (n,) or not np.all(np.isfinite([*angles, *torque])):
        raise InputError("an arm is drawn at one pose within reach, in steady motion")
    along = np.cumsum(angles)
    members = np.asarray(drive.lengths)[:, None] * np.stack([np.cos(along), np.sin(along)], axis=-1)
    points = np.concatenate([np.zeros((1, 2)), np.cumsum(members, axis=0)])
    across = np.array([-points[-1, 1], points[-1, 0]])
    return {
        "points": points,
        "torque": torque,
        "loads": [_most(point.demands, part) for part in point.parts],
        "force": load[:2] if n > 1 else np.zeros(2),
        "velocity": rate[:2] if n > 1 else rate[0] * across,
        "moment": 0.0 if n == 2 else float(load[-1]),
        "turning": 0.0 if n == 2 else float(rate[-1]),
        "sets": {} if n == 1 else _sets(drive, row, rate, load),
    }


def _most(demands: Mapping[Any, Any], part: str) -> str:
    own = {limit: float(demand) for (limit, what), demand in demands.items() if what == part}
    known = {limit: demand for limit, demand in own.items() if np.isfinite(demand)}
    if not known:
        return ""
    worst = max(known, key=lambda limit: known[limit])
    return f"{100.0 * known[worst]:.0f} % of {worst.words}"


def _sets(drive: ArmDrive, pose: np.ndarray, twist: np.ndarray, wrench: np.ndarray) -> dict[str, Any]:
    """Forces within all limits, at rest and in motion, if the moment stays that of the task."""
    found = {}
    for name, rate in (("at rest", np.zeros_like(twist)), ("in the task", twist)):
        if name == "at rest" or np.any(twist):
            outline = _outline(drive, pose, rate, wrench)
            if outline is not None:
                found[name] = outline
    return found


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


def draw(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw base, members and joints with their torques, and force and velocity of the end point."""
    points = numbers["points"]
    reach = float(np.sum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
    draw_members(ax, points, reach)
    end = points[-1]
    ax.plot(*end, marker="o", ms=4, color="black", zorder=5)
    ways = {name: numbers[name] / (float(np.linalg.norm(numbers[name])) or 1.0) for name in ("velocity", "force")}
    hidden = float(ways["velocity"] @ ways["force"]) > _ALONG
    for name, colour in (("velocity", _VELOCITY), ("force", _FORCE)):
        if np.any(numbers[name]):
            arrow = {"arrowstyle": "-|>", "color": colour, "lw": 1.8, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 11}
            tip = end + (_SHORT if hidden and name == "force" else 1.0) * _ARROW * reach * ways[name]
            ax.annotate("", xy=tuple(tip), xytext=tuple(end), arrowprops=arrow, zorder=4)
    for place, (spot, torque, load) in enumerate(zip(points[:-1], numbers["torque"], numbers["loads"], strict=True)):
        # Away from the members that meet there.
        above = sum(points[near][1] - spot[1] for near in (place - 1, place + 1) if near >= 0) < 0.0
        ax.annotate(
            f"joint {place + 1}: {torque:.3g} N m" + (f",\n{load}" if load else ""),
            tuple(spot),
            (0, 10 if above else -10),
            textcoords="offset points",
            ha="center",
            va="bottom" if above else "top",
            fontsize=7,
            zorder=6,
            bbox={"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none", "alpha": 0.85},
        )
    shown = np.concatenate([points, [end + [0.45 * reach] * 2, end - [0.45 * reach] * 2]])
    low = shown.min(axis=0) - np.array([0.25, 0.2]) * reach
    high = shown.max(axis=0) + np.array([0.1, 0.05]) * reach
    ax.set_xlim(low[0], high[0])
    ax.set_ylim(low[1], high[1])
    ax.set_aspect("equal")
    ax.set_xlabel("x [m]")
    ax.set_ylabel("y [m]")


def draw_members(ax: Axes, points: np.ndarray, reach: float) -> None:
    """Draw the base, and members and joints from base to end point (n + 1, 2)."""
    ax.plot([-0.08 * reach, 0.08 * reach], [0.0, 0.0], color="#999999", lw=5.0, solid_capstyle="butt", zorder=1)
    ax.plot(*points.T, color=_MEMBER, lw=6.0, solid_capstyle="round", solid_joinstyle="round", zorder=2)
    ax.plot(*points[:-1].T, ls="", marker="o", ms=9, mfc="white", mec="black", zorder=3)


def draw_forces(ax: Axes, numbers: Mapping[str, Any]) -> set[int]:
    """Draw the forces within all limits, with that of the task; returns the limits beyond them."""
    beyond: set[int] = set()
    for name, (outline, limits) in numbers["sets"].items():
        area, line = _AREAS[name]
        ax.fill(*outline.T, facecolor=area, edgecolor="none", alpha=0.8, zorder=1)
        for place, limit in enumerate(limits):
            ends = outline[[place, (place + 1) % len(outline)]]
            ax.plot(*ends.T, color=_EDGES.get(Limit(int(limit)), _OTHER), lw=1.6, ls=line, zorder=2)
        beyond |= set(limits.tolist())
    ax.plot(0.0, 0.0, marker="+", color="black", ms=6, mew=0.8, zorder=3)
    if np.any(numbers["force"]):
        arrow = {"arrowstyle": "-|>", "color": _FORCE, "lw": 1.6, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 10}
        ax.annotate("", xy=tuple(numbers["force"]), xytext=(0.0, 0.0), arrowprops=arrow, zorder=4)
    ax.margins(0.08)
    ax.set_aspect("equal", adjustable="datalim")
    ax.set_xlabel("force on the load along x [N]")
    ax.set_ylabel("along y [N]")
    ax.set_title("forces within all limits", fontsize=9)
    return beyond


def draw_all(drive: ArmDrive, pose: Any, twist: Any, wrench: Any) -> Figure:
    """Draw the figure; arguments as in `data`."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    numbers = data(drive, pose, twist, wrench)
    force, speed = float(np.linalg.norm(numbers["force"])), float(np.linalg.norm(numbers["velocity"]))
    words = [f"{force:.3g} N"] * (len(drive.lengths) > 1) + [f"{numbers['moment']:.3g} N m"] * (len(drive.lengths) != 2)
    turning = f", turning at {numbers['turning']:.3g} rad/s" if numbers["turning"] else ""
    key: list[Any] = [
        Line2D([], [], color=_FORCE, lw=1.8, label=f"on the load: {', '.join(words)}"),
        Line2D([], [], color=_VELOCITY, lw=1.8, label=f"velocity {speed:.3g} m/s{turning}"),
    ]
    with style.styled():
        if not numbers["sets"]:
            made, ax = style.figure(5.0, 5.0)
            draw(ax, numbers)
        else:
            made, (ax, beside) = style.figure(8.6, 4.6, 1, 2)
            draw(ax, numbers)
            beyond = draw_forces(beside, numbers)
            for name in numbers["sets"]:
                area, line = _AREAS[name]
                key.append(Patch(facecolor=area, edgecolor="#555555", ls=line, label=f"forces {name}"))
            names: dict[str, list[str]] = {}
            for limit in sorted(beyond):
                names.setdefault(_EDGES.get(Limit(limit), _OTHER), []).append(Limit(limit).words)
            key += [
                Line2D([], [], color=colour, lw=1.8, label=f"limit: {', '.join(one)}") for colour, one in names.items()
            ]
        made.legend(handles=key, loc="outside lower center", ncols=3 if numbers["sets"] else 1)
    return made
