"""A platform on rods drawn from its geometry at one pose: forces of its rods, headings of its wheels, and their slip limits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar._core.array_namespace import Array
from infinivar.errors import InputError
from infinivar.figures import style
from infinivar.transmission.legs import Legs, LegsPoint
from infinivar.transmission.platform import Platform, rotated

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_AZIMUTH, _ELEVATION = np.radians(-62.0), np.radians(24.0)
_MAP = "coolwarm"
_FORCE, _VELOCITY = "#000000", style.COLOURS[2]
_EDGE = "#555555"
_BLANK = {"boxstyle": "square,pad=0.05", "facecolor": "white", "edgecolor": "none", "alpha": 0.8}
_ROUND = np.linspace(0.0, 2.0 * np.pi, 73)
_NEAR, _SHORT = 0.35, 0.55
"""Distance of the ends of two arrows, over their length, from which the second is shortened, and to what share."""

_REST = 1e-12
"""Share of the largest number below which an arrow is not drawn."""


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
        origin (3,) of the platform; lower and upper (n, 3): ends of the rods; wheel (n, 3): contacts on the cylinder; outward,
        rolling (n, 3): unit normal of the cylinder there and direction in which the wheel rolls; cylinder_radius, wheel_radius;
        range: of heights [mm]. around (n,): angle of each wheel about the cylinder [deg]; steering (n,) [deg]; tension (n,) of
        the rods, negative in compression [N]; limit (n,): of the tension, at which an ideal wheel slips [N]; slip (n,): demand
        over the slip limit; stroke [mm] or None; force (3,), moment (3,), of the user; velocity (3,) [m/s]; surface_speed [m/s].

    Raises
    ------
    InputError
        If the point is not at one pose within reach, or is beyond the slip limit.
    """
    pose = platform.at(position, rotation)
    links = np.asarray(point.link_speed)
    if pose.jacobian.ndim != 2 or links.ndim != 1 or not np.all(np.isfinite([*links, *np.asarray(point.link_force)])):
        raise InputError(
            "a machine is drawn at one pose within reach and below the slip limit: its point must be one of finite numbers"
        )
    origin, height = np.asarray(position, dtype=float), np.asarray(pose.link_position)
    upper = origin + np.stack(rotated(np.asarray(rotation, dtype=float), platform.joints), axis=-1)
    lower = np.asarray(platform.base) + height[:, None] * [0.0, 0.0, 1.0]
    steepness = (upper - lower)[:, 2] / platform.rod_length
    around = np.arctan2(lower[:, 1], lower[:, 0])
    angle = np.arctan(np.asarray(point.steering_tangent))
    flat = np.zeros_like(around)
    outward = np.stack([np.cos(around), np.sin(around), flat], axis=-1)
    along = np.stack([-np.sin(around), np.cos(around), flat], axis=-1)
    axis = np.array([0.0, 0.0, 1.0])
    radius = float(legs.transmission.cylinder_radius)
    wide = float(np.max(legs.transmission.wheel_radius))
    ends = np.array(platform.stroke or (height.min() - radius, height.max() + radius))
    return {
        "origin": 1e3 * origin,
        "lower": 1e3 * lower,
        "upper": 1e3 * upper,
        "wheel": 1e3 * (radius * outward + lower[:, 2:] * axis),
        "outward": outward,
        "rolling": np.cos(angle)[:, None] * along + np.sin(angle)[:, None] * axis,
        "cylinder_radius": 1e3 * radius,
        "wheel_radius": 1e3 * wide,
        "range": 1e3 * (ends + float(np.mean(platform.base[:, 2])) + np.array([-1.5, 1.5]) * wide),
        "around": np.degrees(around) % 360.0,
        "steering": np.degrees(angle),
        "tension": -np.asarray(point.link_force) / steepness,
        "limit": legs.force_limits(links, point.cylinder_speed) / steepness,
        "slip": np.asarray(point.slip_demand),
        "stroke": None if platform.stroke is None else 1e3 * np.array(platform.stroke),
        "force": -np.asarray(point.wrench)[:3],
        "moment": -np.asarray(point.wrench)[3:],
        "velocity": np.asarray(point.twist)[:3],
        "surface_speed": radius * float(point.cylinder_speed),
        "provenance": platform.provenance,
    }


def seen(points: np.ndarray) -> np.ndarray:
    """Points in space, (..., 3), as a viewer far away sees them: to the right and up."""
    right = np.array([-np.sin(_AZIMUTH), np.cos(_AZIMUTH), 0.0])
    return np.stack([points @ right, points @ np.cross(viewer(), right)], axis=-1)


def viewer() -> np.ndarray:
    """Unit vector towards the viewer. (3,)"""
    return np.array([np.cos(_ELEVATION) * np.cos(_AZIMUTH), np.cos(_ELEVATION) * np.sin(_AZIMUTH), np.sin(_ELEVATION)])


def _colours(numbers: Mapping[str, Any]) -> list[Any]:
    """Of each leg, by its share of the slip limit, in tension or compression."""
    from matplotlib import colormaps

    share = np.sign(numbers["tension"]) * np.minimum(numbers["slip"], 1.0)
    return [colormaps[_MAP](0.5 + 0.5 * one) for one in share]


def draw(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw the machine in space, with the force of the user and the velocity of the platform."""
    draw_solid(ax, numbers, _colours(numbers))
    _arrows(ax, numbers)
    draw_frame(ax, numbers)
    ax.set_aspect("equal")
    ax.set_axis_off()


def draw_solid(ax: Axes, numbers: Mapping[str, Any], colours: Sequence[Any]) -> None:
    """Draw cylinder and wheels, if it has a cylinder, and guideways, rods in their colours and platform."""
    front = numbers["outward"] @ viewer() > 0
    steered = numbers["cylinder_radius"] is not None
    if steered:
        _cylinder(ax, numbers)
    for place, colour in enumerate(colours):
        above = 4 if front[place] else 1
        _guideway(ax, numbers, place, above)
        if steered:
            _wheel(ax, numbers, place, above)
        rod = seen(np.stack([numbers["lower"][place], numbers["upper"][place]]))
        ax.plot(*rod.T, color=_EDGE, lw=5.2, solid_capstyle="round", zorder=above + 0.4)
        ax.plot(*rod.T, color=colour, lw=3.8, solid_capstyle="round", zorder=above + 0.5)
        low = seen(numbers["lower"][place])
        ax.text(
            low[0],
            low[1],
            str(place + 1),
            ha="center",
            va="center",
            fontsize=7,
            zorder=above + 0.8,
            bbox={"boxstyle": "circle,pad=0.2", "facecolor": "white", "edgecolor": _EDGE, "linewidth": 0.8},
        )
    ax.fill(*seen(numbers["upper"]).T, facecolor="#F4E3B2", edgecolor=_EDGE, lw=1.0, alpha=0.9, zorder=6)


def _cylinder(ax: Axes, numbers: Mapping[str, Any]) -> None:
    radius, (low, high) = numbers["cylinder_radius"], numbers["range"]
    ring = np.stack([np.cos(_ROUND), np.sin(_ROUND), 0.0 * _ROUND], axis=-1) * radius
    from scipy.spatial import ConvexHull

    rims = [seen(ring + np.array([0.0, 0.0, height])) for height in (low, high)]
    both = np.concatenate(rims)
    ax.fill(*both[ConvexHull(both).vertices].T, facecolor="#D8DCE0", edgecolor=_EDGE, lw=0.8, alpha=0.75, zorder=2)
    ax.fill(*rims[1].T, facecolor="#E9ECEF", edgecolor=_EDGE, lw=0.8, alpha=0.75, zorder=2.1)


def _guideway(ax: Axes, numbers: Mapping[str, Any], place: int, above: float) -> None:
    guide = np.stack([[*numbers["lower"][place][:2], end] for end in numbers["range"]])
    ax.plot(*seen(guide).T, color="#AAAAAA", lw=1.0, zorder=above)


def _wheel(ax: Axes, numbers: Mapping[str, Any], place: int, above: float) -> None:
    """Wheel, and its carriage out to the rod."""
    radius, outward, contact = numbers["wheel_radius"], numbers["outward"][place], numbers["wheel"][place]
    hub, lower = contact + radius * outward, numbers["lower"][place]
    disc = hub + radius * (np.cos(_ROUND)[:, None] * outward + np.sin(_ROUND)[:, None] * numbers["rolling"][place])
    ax.plot(*seen(np.stack([hub, lower])).T, color=_EDGE, lw=2.0, zorder=above + 0.2)
    ax.fill(*seen(disc).T, facecolor="#6C7A89", edgecolor="black", lw=0.7, zorder=above + 0.3)


def _arrows(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Force of the user, on its way to the platform if it points down, and the velocity of the platform."""
    length = 0.7 * np.ptp(numbers["range"])
    taken = None
    shown = [
        ("force", _FORCE, f"force of the user {np.linalg.norm(numbers['force']):.3g} N"),
        ("velocity", _VELOCITY, f"velocity {np.linalg.norm(numbers['velocity']):.3g} m/s"),
    ]
    for name, colour, words in shown:
        vector = np.asarray(numbers[name])
        size = np.linalg.norm(vector)
        if size <= _REST:
            continue
        inward = name == "force" and vector[2] < 0
        outer = numbers["origin"] + (-1.0 if inward else 1.0) * length * vector / size
        ends = seen(np.stack([numbers["origin"], outer]))
        if taken is not None and np.linalg.norm(ends[1] - taken) < _NEAR * length:
            ends[1] = ends[0] + _SHORT * (ends[1] - ends[0])
        taken = ends[1]
        tail, head = ends[::-1] if inward else ends
        arrow = {"arrowstyle": "-|>", "color": colour, "lw": 2.0, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 14}
        ax.annotate("", xy=tuple(head), xytext=tuple(tail), arrowprops=arrow, zorder=8)
        ax.update_datalim([tuple(ends[1])])
        side = "left" if ends[1][0] >= ends[0][0] else "right"
        ax.text(
            ends[1][0], ends[1][1], f" {words} ", color=colour, ha=side, va="bottom", fontsize=8, zorder=8, bbox=_BLANK
        )


def draw_frame(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Axes x, y and z at the lower left, as long as a round number of millimetres."""
    span = float(np.max(np.linalg.norm(numbers["lower"][:, :2], axis=1)))
    size = 10.0 ** np.floor(np.log10(span))
    size *= max(step for step in (1.0, 2.0, 5.0) if step * size <= span)
    everything = seen(np.concatenate([numbers["lower"], [[0.0, 0.0, numbers["range"][0]]]]))
    start = np.array([everything[:, 0].min() - 0.75 * size, everything[:, 1].min() - 0.35 * span])
    for name, unit in zip("xyz", np.eye(3), strict=True):
        ax.plot(*np.stack([start, start + 0.6 * size * seen(unit)]).T, color=_EDGE, lw=1.2)
        tip = start + 0.75 * size * seen(unit)
        ax.text(tip[0], tip[1], name, ha="center", va="center", fontsize=8)
    left = np.array([-0.5 * size, start[1] - 0.1 * size])
    ax.plot([left[0], left[0] + size], [left[1]] * 2, color="black", lw=2.0, solid_capstyle="butt")
    ax.text(left[0] + 0.5 * size, left[1] - 0.08 * size, f"{size:g} mm", ha="center", va="top", fontsize=8)


def draw_surface(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw the surface of the cylinder unrolled, with each wheel along its heading."""
    per_degree = np.radians(numbers["cylinder_radius"])
    start = _widest_gap(numbers["around"])
    middle = ((numbers["around"] - start) % 360.0 + start) * per_degree
    height = numbers["wheel"][:, 2]
    angle, half = np.radians(numbers["steering"]), numbers["wheel_radius"]
    for place, colour in enumerate(_colours(numbers)):
        run = np.array([np.cos(angle[place]), np.sin(angle[place])]) * half
        x, y = middle[place], height[place]
        ax.plot([x - run[0], x + run[0]], [y - run[1], y + run[1]], color="black", lw=5.5, solid_capstyle="round")
        ax.plot([x - run[0], x + run[0]], [y - run[1], y + run[1]], color=colour, lw=4.0, solid_capstyle="round")
        way = 1.0 if place % 2 else -1.0
        ax.text(
            x,
            y + way * 1.3 * half,
            f"{place + 1}: {_signed(numbers['steering'][place])}°",
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
    ax.set_ylim(*numbers["range"])
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
    with style.styled():
        made, unused = style.figure(9.6, 5.2)
        unused.remove()
        grid = made.add_gridspec(3, 2, width_ratios=[1.0, 1.2], height_ratios=[1.0, 1.0, 0.05])
        places = (grid[:2, 0], grid[0, 1], grid[1:, 1], grid[2, 0])
        space, surface, forces, scale = (made.add_subplot(place) for place in places)
        draw(space, numbers)
        draw_surface(surface, numbers)
        draw_forces(forces, numbers)
        words = [] if numbers["provenance"] == "given" else [f"{numbers['provenance']} geometry"]
        if np.any(numbers["moment"]):
            words.append("moment of the user ({}) N m".format(", ".join(f"{one:.3g}" for one in numbers["moment"])))
        space.set_title("\n".join(words), fontsize=9)
        bar = made.colorbar(ScalarMappable(Normalize(-1.0, 1.0), colormaps[_MAP]), cax=scale, orientation="horizontal")
        bar.set_ticks([-1.0, -0.5, 0.0, 0.5, 1.0], labels=["100 %", "50 %", "0", "50 %", "100 %"])
        bar.set_label(r"$\leftarrow$ rod in compression    share of the slip limit    rod in tension $\rightarrow$")
    return made
