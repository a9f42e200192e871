"""A body on steered wheels drawn from above: headings, their normals, the instant centre, and the forces at the contacts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.errors import InputError
from infinivar.figures import style
from infinivar.transmission.mechanism import MechanismPoint
from infinivar.transmission.planar import PlanarCarriage, PlanarCobot, instant_centre

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_CONTACT, _APPLIED, _VELOCITY, _LOAD = style.COLOURS[1], "#000000", style.COLOURS[2], style.COLOURS[3]
_NEAR = 3.0
"""Distance of an instant centre within the drawing, over the size of the body."""

_LIMIT = 0.4
"""Radius of the circle of the largest slip limit, over the size of the body."""

_ROUNDING = 1e-9
"""Force or moment over that of the forces on the wheels and of the load below which it is rounding."""

_WIDTH, _AROUND = 6.4, 1.5
"""Width of the figure, and height of what stands around the drawing. [inch]"""

_PAD = 0.1
"""Above the title. [inch]"""

_ROUND = np.linspace(0.0, 2.0 * np.pi, 73)


def data(
    cobot: PlanarCobot | PlanarCarriage, point: MechanismPoint, wrench: Sequence[float] | np.ndarray | None = None
) -> dict[str, Any]:
    """Geometry and forces of one motion, in axes of the body.

    Parameters
    ----------
    cobot : PlanarCobot or PlanarCarriage   The machine; a carriage does not turn.
    point : MechanismPoint                  One point of its mechanism, in motion.
    wrench : (3,) or (2,) float             Of the machine on its load; the rest of what the wheels exert is on the source.

    Returns
    -------
    dict
        positions, headings (k, 2): of the wheels [m] and unit vectors along them; force (k, 2): of the ground on each wheel [N];
        limit (k,): slip force at rest [N]; slip (k,): demand over allowance; radius (k,): of the wheels [m]; twist (3,); applied
        (3,): of source and load on the machine together; source (3,) and load (3,): of each, None if `wrench` is; centre (2,):
        instant centre, perhaps infinite [m].

    Raises
    ------
    InputError
        If there are many points, or one without a steady motion.
    """
    rates, cosine, sine = (np.asarray(one) for one in (point.rates, point.cosine, point.sine))
    turns = isinstance(cobot, PlanarCobot)
    if rates.shape != ((3,) if turns else (2,)) or not np.all(np.isfinite([*rates, *np.asarray(point.lateral_force)])):
        raise InputError("a planar cobot is drawn at one point in steady motion, at which all wheels roll or slide")
    forces, _ = cobot.mechanism.forces(rates, (cosine, sine), np.asarray(point.steering_rate))
    force = np.stack([np.asarray(forces.x), np.asarray(forces.y)], axis=-1)
    contacts = cobot.mechanism.contacts
    twist, applied = (np.append(row, np.zeros(3 - len(rates))) for row in (rates, -np.asarray(point.applied)))
    load = None if wrench is None else -np.append(np.asarray(wrench, dtype=float), np.zeros(3 - len(wrench)))
    return {
        "positions": np.array(cobot.positions) if isinstance(cobot, PlanarCobot) else np.zeros((1, 2)),
        "headings": np.stack([cosine, sine], axis=-1),
        "force": force,
        "limit": np.array([float(one.slip_force) for one in contacts]),  # type: ignore[union-attr]
        "slip": np.asarray(point.slip_demand),
        "radius": np.array([float(one.wheel_radius) for one in contacts]),  # type: ignore[union-attr]
        "twist": twist,
        "applied": applied,
        "source": None if load is None else applied - load,
        "load": load,
        "centre": np.array([float(one) for one in instant_centre(twist)]) if turns else np.full(2, np.inf),
    }


def draw(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw body, wheels, normals, instant centre and forces."""
    spots, force = numbers["positions"], numbers["force"]
    middle = spots.mean(axis=0)
    size = size_of(spots, numbers["radius"])
    scale = _LIMIT * size / float(numbers["limit"].max())
    near = bool(np.all(np.isfinite(numbers["centre"]))) and np.linalg.norm(numbers["centre"] - middle) < _NEAR * size
    shown = np.concatenate([spots, numbers["centre"][None]]) if near else spots
    low, high = shown.min(axis=0) - 0.75 * size, shown.max(axis=0) + 0.75 * size
    draw_body(ax, outline(spots, size))
    for place, (spot, heading) in enumerate(zip(spots, numbers["headings"], strict=True)):
        across = np.array([-heading[1], heading[0]])
        ends = spot + np.outer([-9.0 * size, 9.0 * size], across)
        ax.plot(*ends.T, color="#999999", lw=0.8, ls=(0, (4, 3)), zorder=1)
        rim = spot + scale * numbers["limit"][place] * np.stack([np.cos(_ROUND), np.sin(_ROUND)], axis=-1)
        ax.plot(*rim.T, color=_CONTACT, lw=0.8, ls=(0, (1, 2)), zorder=2)
        draw_wheel(ax, spot, numbers["radius"][place] * heading)
        arrow(ax, spot, spot + scale * force[place], _CONTACT)
        out = (spot - middle) / (np.linalg.norm(spot - middle) or 1.0)
        words = f"wheel {place + 1}: {np.linalg.norm(force[place]):.3g} N,\n{100.0 * numbers['slip'][place]:.0f} % of slip limit"
        at = spot + 1.12 * scale * numbers["limit"][place] * np.array([0.0, 1.0 if out[1] > 0.3 else -1.0])
        ax.text(
            at[0],
            at[1],
            words,
            ha="center",
            va="bottom" if out[1] > 0.3 else "top",
            fontsize=7,
            zorder=6,
            bbox={"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none", "alpha": 0.85},
        )
    _motion(ax, numbers, size, scale)
    if near:
        ax.plot(*numbers["centre"], marker="o", ms=6, mfc="white", mec="black", zorder=5)
        ax.annotate(
            "instant centre", tuple(numbers["centre"]), (8, 4), textcoords="offset points", fontsize=8, zorder=6
        )
    ax.set_xlim(low[0], high[0])
    ax.set_ylim(low[1], high[1])
    ax.set_aspect("equal")
    ax.set_xlabel("x of the body [m]")
    ax.set_ylabel("y of the body [m]")
    ax.set_title("" if near else _far(numbers["centre"]), fontsize=9)


def _far(centre: np.ndarray) -> str:
    if not np.all(np.isfinite(centre)):
        return "instant centre at infinity"
    return f"instant centre at ({centre[0]:.3g}, {centre[1]:.3g}) m"


def size_of(spots: np.ndarray, radius: np.ndarray) -> float:
    """Size of a body with wheels at spots (k, 2) of radii (k,)."""
    return float(np.max(np.linalg.norm(spots - spots.mean(axis=0), axis=1))) or 4.0 * float(radius.max())


def outline(spots: np.ndarray, size: float) -> np.ndarray:
    """Outline of a body, a little way around its wheels. (m, 2)"""
    from scipy.spatial import ConvexHull

    ring = 0.12 * size * np.stack([np.cos(_ROUND), np.sin(_ROUND)], axis=-1)
    around = (spots[:, None] + ring).reshape(-1, 2)
    return around[ConvexHull(around).vertices]


def draw_body(ax: Axes, around: np.ndarray) -> None:
    """Fill an outline (m, 2)."""
    ax.fill(*around.T, facecolor="#E9ECEF", edgecolor="#555555", lw=1.0, zorder=0)


def draw_wheel(ax: Axes, spot: np.ndarray, half: np.ndarray, colour: str = "black") -> None:
    """Draw a wheel at a spot (2,), with half its length (2,) along its heading."""
    ax.plot(*(spot + np.outer([-1.0, 1.0], half)).T, color=colour, lw=6.0, solid_capstyle="butt", zorder=3)


def _motion(ax: Axes, numbers: Mapping[str, Any], size: float, scale: float) -> None:
    """Velocity of the reference point, and the forces applied there."""
    origin = np.zeros(2)
    velocity = np.asarray(numbers["twist"][:2])
    if np.any(velocity):
        arrow(ax, origin, 0.5 * size * velocity / np.linalg.norm(velocity), _VELOCITY)
    for name, _, colour in _applied(numbers):
        if np.any(numbers[name][:2]):
            arrow(ax, origin, scale * numbers[name][:2], colour)
    ax.plot(0.0, 0.0, marker="o", ms=3, color="black", zorder=5)


def _applied(numbers: Mapping[str, Any]) -> tuple[tuple[str, str, str], ...]:
    """Key, words and colour of the wrenches applied to the machine."""
    if numbers["load"] is None:
        return (("applied", "applied force", _APPLIED),)
    return (("source", "force of the source", _APPLIED), ("load", "force of the load", _LOAD))


def _said(numbers: Mapping[str, Any], name: str, words: str) -> str:
    """A wrench in words."""
    arms = np.linalg.norm(numbers["positions"], axis=1)
    wheels, wrenches = np.linalg.norm(numbers["force"], axis=1), [numbers[key] for key, _, _ in _applied(numbers)]
    force = float(np.linalg.norm(numbers[name][:2]))
    moment = float(numbers[name][2])
    largest = max(float(wheels.sum()), *(float(np.linalg.norm(one[:2])) for one in wrenches))
    turning = max(float(wheels @ arms), *(abs(float(one[2])) for one in wrenches))
    force = 0.0 if force <= _ROUNDING * largest else force
    moment = 0.0 if abs(moment) <= _ROUNDING * turning else moment
    return f"{words} {force:.3g} N, with {moment:.3g} N m"


def arrow(ax: Axes, start: np.ndarray, end: np.ndarray, colour: str) -> None:
    """Draw an arrow from a point (2,) to another."""
    arrow = {"arrowstyle": "-|>", "color": colour, "lw": 1.8, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 11}
    ax.annotate("", xy=tuple(end), xytext=tuple(start), arrowprops=arrow, zorder=4)


def draw_all(
    cobot: PlanarCobot | PlanarCarriage, point: MechanismPoint, wrench: Sequence[float] | np.ndarray | None = None
) -> Figure:
    """Draw the figure; arguments as in `data`."""
    from matplotlib.lines import Line2D

    numbers = data(cobot, point, wrench)
    speed, turning = float(np.linalg.norm(numbers["twist"][:2])), float(numbers["twist"][2])
    with style.styled():
        made, ax = style.figure(_WIDTH, _WIDTH)
        draw(ax, numbers)
        (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
        made.get_layout_engine().set(h_pad=_PAD)  # type: ignore[union-attr]
        made.set_figheight(_WIDTH * min(1.2, 0.85 * (high - low) / (right - left)) + _AROUND)
        key = [
            Line2D([], [], color=_CONTACT, lw=1.8, label="force of the ground on a wheel"),
            Line2D([], [], color=_CONTACT, lw=0.8, ls=(0, (1, 2)), label="slip limit, to the same scale"),
            *(
                Line2D([], [], color=colour, lw=1.8, label=_said(numbers, name, words))
                for name, words, colour in _applied(numbers)
            ),
            Line2D([], [], color=_VELOCITY, lw=1.8, label=f"velocity {speed:.3g} m/s, turning at {turning:.3g} rad/s"),
            Line2D([], [], color="#999999", lw=0.8, ls=(0, (4, 3)), label="normal of a heading"),
        ]
        made.legend(handles=key, loc="outside lower center", ncols=2)
    return made
