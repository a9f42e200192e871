"""A platform on rods drawn from its geometry at one pose: forces of its rods, headings of its wheels, and their slip limits."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar._core.array_namespace import Array
from infinivar.errors import InputError
from infinivar.figures import pictures, style
from infinivar.machines.pictures import rods
from infinivar.transmission.legs import Legs, LegsPoint
from infinivar.transmission.platform import Platform

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_EDGE = "#555555"


def data(
    platform: Platform, legs: Legs, point: LegsPoint, position: Array, rotation: Array = (0.0, 0.0, 0.0)
) -> dict[str, Any]:
    """Geometry and forces of a machine at one pose.

    Parameters
    ----------
    platform, legs : Platform, Legs    The machine.
    point : LegsPoint                  Where it stands, from `Legs.operate` at this pose, such as `MachinePoint.legs`.
    position, rotation : (3,) float    The pose, as in `Platform.at`. [m], [rad]

    Returns
    -------
    dict
        machine: `rods.Standing`; tension (n,) of the rods, negative in compression [N]; limit (n,): of the tension, at which an
        ideal wheel slips [N]; slip (n,): demand over the slip limit; shares (n,): the same, at most 1, with the sign of the
        tension; stroke [mm] or None; force, moment (3,), of the user; velocity (3,) [m/s]; surface_speed [m/s]; provenance.

    Raises
    ------
    InputError
        If the point is not at one pose within reach, or is beyond the slip limit.
    """
    links = np.asarray(point.link_speed)
    if (
        np.shape(position) != (3,)
        or links.ndim != 1
        or not np.all(np.isfinite([*links, *np.asarray(point.link_force)]))
    ):
        raise InputError(
            "a machine is drawn at one pose within reach and below the slip limit: its point must be one of finite numbers"
        )
    steering = np.arctan(np.asarray(point.steering_tangent))
    found = rods.standing(platform, np.concatenate([position, rotation]), legs.transmission, steering=steering)
    steepness = (found.upper - found.lower)[:, 2] / platform.rod_length
    tension, slip = -np.asarray(point.link_force) / steepness, np.asarray(point.slip_demand)
    return {
        "machine": found,
        "tension": tension,
        "limit": legs.force_limits(links, point.cylinder_speed) / steepness,
        "slip": slip,
        "shares": np.sign(tension) * np.minimum(slip, 1.0),
        "stroke": None if platform.stroke is None else 1e3 * np.array(platform.stroke),
        "force": -np.asarray(point.wrench)[:3],
        "moment": -np.asarray(point.wrench)[3:],
        "velocity": np.asarray(point.twist)[:3],
        "surface_speed": float(legs.transmission.cylinder_radius) * float(point.cylinder_speed),
        "provenance": platform.provenance,
    }


def _colours(numbers: Mapping[str, Any]) -> list[Any]:
    """Of each leg, by its share of the slip limit, in tension or compression."""
    from matplotlib import colormaps

    return [colormaps[pictures.SHARES](0.5 + 0.5 * one) for one in numbers["shares"]]


def draw_surface(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw the surface of the cylinder unrolled, with each wheel along its heading."""
    machine = numbers["machine"]
    per_degree, around = np.radians(1e3 * machine.cylinder_radius), np.degrees(machine.around) % 360.0
    start = _widest_gap(around)
    middle = ((around - start) % 360.0 + start) * per_degree
    height = 1e3 * machine.lower[:, 2]
    angle, half = machine.steering, 1e3 * machine.wheel_radius
    for place, colour in enumerate(_colours(numbers)):
        run = np.array([np.cos(angle[place]), np.sin(angle[place])]) * half
        x, y = middle[place], height[place]
        ax.plot([x - run[0], x + run[0]], [y - run[1], y + run[1]], color="black", lw=5.5, solid_capstyle="round")
        ax.plot([x - run[0], x + run[0]], [y - run[1], y + run[1]], color=colour, lw=4.0, solid_capstyle="round")
        way = 1.0 if place % 2 else -1.0
        ax.text(
            x,
            y + way * 1.3 * half,
            f"{place + 1}: {_signed(np.degrees(angle[place]))}°",
            ha="center",
            va="bottom" if way > 0 else "top",
            fontsize=7,
        )
    if numbers["stroke"] is not None:
        for end, (off, side) in zip(numbers["stroke"], ((2, "bottom"), (-2, "top")), strict=True):
            ax.axhline(end, color="black", lw=0.9, ls=(0, (5, 2)))
            ax.annotate(
                "end of stroke",
                ((start + 120.0) * per_degree, end),
                (0, off),
                textcoords="offset points",
                ha="center",
                va=side,
                fontsize=7,
            )
    ax.set_xlim(start * per_degree, (start + 360.0) * per_degree)
    ax.set_ylim(*(1e3 * end for end in machine.ends))
    ax.set_aspect("equal")
    speed = numbers["surface_speed"]
    way = "right" if speed >= 0 else "left"
    ax.set_xlabel(f"along the circumference [mm]; surface moves {abs(speed):.3g} m/s to the {way}")
    ax.set_ylabel("link position [mm]")


def _signed(value: float) -> str:
    return f"{value:.1f}".replace("-", "\N{MINUS SIGN}")


def _widest_gap(around: np.ndarray) -> float:
    """Angle, from -180 to 180 degrees, in the middle of the widest gap between wheels."""
    rising = np.sort(around)
    gap = np.diff(rising, append=rising[0] + 360.0)
    # The last of equal gaps, which rounding may tell apart.
    widest = int(np.flatnonzero(gap > gap.max() - 1e-6)[-1])
    return float((rising[widest] + 0.5 * gap[widest] + 180.0) % 360.0 - 180.0)


def draw_forces(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw the forces of the rods, with the slip limits of their wheels."""
    tension, limit = numbers["tension"], numbers["limit"]
    legs = np.arange(1, len(tension) + 1)
    ax.bar(legs, tension, color=_colours(numbers), edgecolor=_EDGE, linewidth=0.8, width=0.6)
    for sign in (1.0, -1.0):
        ax.hlines(sign * limit, legs - 0.4, legs + 0.4, color="black", lw=1.2)
    ax.axhline(0.0, color="black", lw=0.6)
    most = float(np.max(limit))
    ax.text(
        0.5 * (legs[0] + legs[-1]), 1.1 * most, "wheel slips beyond these lines", ha="center", va="bottom", fontsize=7
    )
    for leg, force, share in zip(legs, tension, numbers["slip"], strict=True):
        up = force >= 0
        ax.annotate(
            f"{100.0 * share:.0f} %",
            (leg, force),
            (0, 2 if up else -2),
            textcoords="offset points",
            ha="center",
            va="bottom" if up else "top",
            fontsize=7,
        )
    ax.set_ylim(-1.1 * most, 1.3 * most)
    ax.set_xticks(legs)
    ax.set_xlabel("leg; numbers at the bars are shares of its slip limit")
    ax.set_ylabel("rod force, tension > 0 [N]")


def draw_all(
    platform: Platform, legs: Legs, point: LegsPoint, position: Array, rotation: Array = (0.0, 0.0, 0.0)
) -> Figure:
    """Draw the figure: machine, cylinder unrolled, and forces; arguments as in `data`."""
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    numbers = data(platform, legs, point, position, rotation)
    shown = (("force", "force of the user", numbers["force"]), ("velocity", "velocity", numbers["velocity"]))
    picture = rods.picture(numbers["machine"], position, shown, shares=numbers["shares"])
    with style.styled():
        made, unused = style.figure(9.6, 5.2)
        unused.remove()
        grid = made.add_gridspec(3, 2, width_ratios=[1.0, 1.2], height_ratios=[1.0, 1.0, 0.05])
        places = (grid[:2, 0], grid[0, 1], grid[1:, 1], grid[2, 0])
        space, surface, forces, scale = (made.add_subplot(place) for place in places)
        pictures.draw(space, picture)
        draw_surface(surface, numbers)
        draw_forces(forces, numbers)
        words = [] if numbers["provenance"] == "given" else [f"{numbers['provenance']} geometry"]
        if np.any(numbers["moment"]):
            words.append("moment of the user ({}) N m".format(", ".join(f"{one:.3g}" for one in numbers["moment"])))
        space.set_title("\n".join(words), fontsize=9)
        space.legend(handles=pictures.handles(picture), loc="upper center", bbox_to_anchor=(0.5, 0.02), ncols=2)
        bar = made.colorbar(
            ScalarMappable(Normalize(-1.0, 1.0), colormaps[pictures.SHARES]), cax=scale, orientation="horizontal"
        )
        bar.set_ticks([-1.0, -0.5, 0.0, 0.5, 1.0], labels=["100 %", "50 %", "0", "50 %", "100 %"])
        bar.set_label(r"$\leftarrow$ rod in compression    share of the slip limit    rod in tension $\rightarrow$")
    return made
