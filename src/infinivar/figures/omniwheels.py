"""A platform on omniwheels drawn from above: wheels, axles of their rollers, and the forces of the ground."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.figures import style
from infinivar.figures.planar_cobot import arrow, draw_body, draw_wheel, outline, size_of
from infinivar.machines.kinds.omniwheels import OmniwheelDrive

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_GROUND, _VELOCITY, _LOAD = style.COLOURS[1], style.COLOURS[2], style.COLOURS[3]

_LONGEST = 0.45
"""Longest arrow of force over the size of the body."""


def data(drive: OmniwheelDrive, pose: Any, twist: Any, wrench: Any) -> dict[str, Any]:
    """Geometry and forces at one steady point, in axes of the plane about the reference point.

    Parameters
    ----------
    drive : OmniwheelDrive
    pose, twist, wrench : (3,) float   In its coordinates; the wrench on the load.

    Returns
    -------
    dict
        positions, headings, axles (n, 2): of the wheels [m], and unit vectors along their rolling directions and the axles of the
        rollers on the ground; force (n, 2): of the ground on each wheel [N]; slip (n,) or None: demand over allowance; radius:
        of the wheels [m]; twist, load (3,): the load's wrench is that on the machine.
    """
    place, rate, load = (np.asarray(one, dtype=float) for one in (pose, twist, wrench))
    point = drive.perform(pose=place, twist=rate, wrench=load)
    along, across = drive.on_ground(point, place, rate)
    turn, wheels = place[2], drive.wheels
    heading = turn + np.asarray(wheels.headings)
    axle = heading + np.asarray(wheels.roller_angles)
    axles = np.stack([np.cos(axle), np.sin(axle)], axis=-1)
    aside = np.stack([-np.sin(axle), np.cos(axle)], axis=-1)
    force = along[:, None] * axles + across[:, None] * aside
    spots = np.asarray(wheels.positions, dtype=float)
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    grip = None if drive.grip is None else np.linalg.norm(force, axis=1) / (drive.grip * drive.load_of_wheel)
    return {
        "positions": spots @ rotation.T,
        "headings": np.stack([np.cos(heading), np.sin(heading)], axis=-1),
        "axles": axles,
        "force": force,
        "slip": grip,
        "radius": drive.wheel_radius,
        "twist": rate,
        "load": 0.0 - load,
    }


def draw(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw body, wheels, axles of rollers, forces of the ground and of the load, and velocity."""
    spots, force, load = numbers["positions"], numbers["force"], numbers["load"]
    radius = numbers["radius"]
    size = size_of(spots, np.full(len(spots), radius))
    largest = max(float(np.linalg.norm(force, axis=1).max()), float(np.linalg.norm(load[:2])))
    scale = _LONGEST * size / (largest or 1.0)
    draw_body(ax, outline(spots, size))
    middle = spots.mean(axis=0)
    for place, spot in enumerate(spots):
        draw_wheel(ax, spot, radius * numbers["headings"][place])
        ends = spot + np.outer([-1.6 * radius, 1.6 * radius], numbers["axles"][place])
        ax.plot(*ends.T, color="#999999", lw=1.0, ls=(0, (3, 2)), zorder=4)
        arrow(ax, spot, spot + scale * force[place], _GROUND)
        words = f"wheel {place + 1}: {np.linalg.norm(force[place]):.3g} N"
        if numbers["slip"] is not None:
            words += f",\n{100.0 * numbers['slip'][place]:.0f} % of slip limit"
        out = (spot - middle) / (np.linalg.norm(spot - middle) or 1.0)
        at = spot + 0.62 * size * out
        box = {"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none", "alpha": 0.85}
        ax.text(at[0], at[1], words, ha="center", va="center", fontsize=7, zorder=6, bbox=box)
    velocity = numbers["twist"][:2]
    if np.any(velocity):
        arrow(ax, np.zeros(2), 0.5 * size * velocity / np.linalg.norm(velocity), _VELOCITY)
    if np.any(load[:2]):
        arrow(ax, np.zeros(2), scale * load[:2], _LOAD)
    ax.plot(0.0, 0.0, marker="o", ms=3, color="black", zorder=5)
    shown = np.concatenate([spots - 1.0 * size, spots + 1.0 * size])
    ax.set_xlim(shown[:, 0].min(), shown[:, 0].max())
    ax.set_ylim(shown[:, 1].min(), shown[:, 1].max())
    ax.set_aspect("equal")
    ax.set_xlabel("x from the reference point [m]")
    ax.set_ylabel("y from the reference point [m]")


def draw_all(drive: OmniwheelDrive, pose: Any, twist: Any, wrench: Any) -> Figure:
    """Figure of `draw`, with a legend below; arguments as for `data`."""
    from matplotlib.lines import Line2D

    numbers = data(drive, pose, twist, wrench)
    twist, load = numbers["twist"], numbers["load"]
    key = [Line2D([], [], color=_GROUND, lw=1.8, label="force of the ground on a wheel")]
    if np.any(load):
        words = f"force of the load {np.linalg.norm(load[:2]):.3g} N, with {load[2] + 0.0:.3g} N m"
        key.append(Line2D([], [], color=_LOAD, lw=1.8, label=words))
    if np.any(twist):
        words = f"velocity {np.linalg.norm(twist[:2]):.3g} m/s, turning at {twist[2]:.3g} rad/s"
        key.append(Line2D([], [], color=_VELOCITY, lw=1.8, label=words))
    key.append(Line2D([], [], color="#999999", lw=1.0, ls=(0, (3, 2)), label="axle of the roller on the ground"))
    with style.styled():
        made, ax = style.figure(6.4, 6.6)
        draw(ax, numbers)
        made.legend(handles=key, loc="outside lower center", ncols=2)
    return made
