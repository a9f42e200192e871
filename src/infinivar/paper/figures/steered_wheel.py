"""Figure 1: the steered wheel on its cylinder at several steering angles, to scale, with its contact patch."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.drivetrain.drive import needed
from infinivar.figures import style
from infinivar.paper.claims.claim import PaperMachine

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ANGLES = (0.0, -math.atan(1.0 / 8.0), -math.pi / 4.0, math.atan(1.0 / 8.0), -math.pi / 2.0)
"""Steering angles; with the cylinder turning forward, negative angles move the link forward. [rad]"""

_HALF_WIDTH = 4.0
"""Half the width of the wheel, which the model does not use. [mm]"""

_LINK, _SURFACE, _STEEL, _EDGE = style.COLOURS[0], style.COLOURS[1], "#E3E7EC", "#5B6675"
_WINDOW = 34.0
"""Half the length of the cylinder section shown. [mm]"""
_ROD = 66.0
"""Distance between the axes of link and cylinder in the views from above. [mm]"""
_SURFACE_ARROW = 24.0
"""Length of the arrow for the surface speed. [mm]"""


def data(machine: PaperMachine) -> dict[str, Any]:
    """Radii [m], and for each steering angle the ratio, link speed over surface speed, and contact patch.

    Returns
    -------
    dict
        cylinder_radius, wheel_radius, crown_radius [m]; snapshots: list of dict with angle [rad], ratio (inf at 0), speed
        (link over surface, without creep; nan where the link is decoupled), a, b: semi-axes of the patch, closest to the
        rolling and to the lateral direction [m], turn: angle from the rolling direction to a, positive towards the lateral
        direction [rad].

    Source: faulring2006, Fig 1.
    """
    element = machine.element
    geometry = needed(element.geometry, "transmission.geometry")
    snapshots = []
    for angle in ANGLES:
        contact = geometry.press(
            wheel_radius=element.wheel_radius,
            cylinder_radius=element.cylinder_radius,
            preload=element.preload,
            steering_angle=angle,
        )
        slope, decoupled = math.tan(angle), abs(angle) > 0.4999 * math.pi
        snapshots.append(
            {
                "angle": angle,
                "ratio": math.inf if angle == 0 else 0.0 if decoupled else 1.0 / abs(slope),
                "speed": math.nan if decoupled else -slope + 0.0,
                "a": float(contact.patch.a),
                "b": float(contact.patch.b),
                "turn": float(contact.rotation),
            }
        )
    return {
        "cylinder_radius": element.cylinder_radius,
        "wheel_radius": element.wheel_radius,
        "crown_radius": geometry.crown_radius,
        "snapshots": snapshots,
    }


def directions(angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Lateral and rolling direction of the wheel, n1 and n2, seen from above: link to the right, surface moving up."""
    return np.array([math.cos(angle), -math.sin(angle)]), np.array([math.sin(angle), math.cos(angle)])


def silhouette(radius: float, crown: float, half_width: float, angle: float) -> np.ndarray:
    """Outline of the crowned wheel seen from above, (n, 2), in the unit of the arguments."""
    across = np.linspace(-half_width, half_width, 41)
    along = radius - crown + np.sqrt(crown**2 - across**2)
    outline = np.concatenate([np.stack([across, along], -1), np.stack([across, -along], -1)[::-1]])
    lateral, rolling = directions(angle)
    return outline @ np.stack([lateral, rolling])


def arrow(ax: Axes, start: Any, end: Any, colour: str, **options: Any) -> None:
    """Draw an arrow whose tips touch both end points."""
    look = {
        "arrowstyle": "-|>",
        "color": colour,
        "lw": 1.8,
        "shrinkA": 0,
        "shrinkB": 0,
        "mutation_scale": 10,
        **options,
    }
    ax.annotate("", xy=tuple(end), xytext=tuple(start), arrowprops=look)


def _clean(ax: Axes, reach: tuple[float, float, float, float]) -> None:
    ax.set_aspect("equal")
    ax.set(xlim=reach[:2], ylim=reach[2:])
    ax.axis("off")


def draw_end(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw the view along the cylinder axis, at steering angle 0."""
    from matplotlib.patches import Arc, Circle, Rectangle

    big, small = (1e3 * numbers[name] for name in ("cylinder_radius", "wheel_radius"))
    ax.add_patch(Circle((0, 0), big, facecolor=_STEEL, edgecolor=_EDGE))
    ax.add_patch(Circle((0, big + small), small, facecolor="#B9C2CE", edgecolor="black"))
    ax.add_patch(Rectangle((-5, big + small), 10, 20, facecolor="none", edgecolor=_EDGE))
    ax.plot([0], [big + small], "k+", ms=5)
    ax.plot([0], [0], "k+", ms=7)
    arrow(ax, (0, big + 47), (0, big + 31), "black")
    ax.text(4, big + 41, "preload $P$", ha="left", va="center", fontsize=8)
    arrow(ax, (0, 0), (big * math.cos(-0.6), big * math.sin(-0.6)), _EDGE, lw=1.0)
    ax.text(15, -20, f"$R$ = {big:g} mm", fontsize=8, ha="right", va="top")
    ax.text(0, -0.78 * big, "cylinder", fontsize=8, ha="center")
    ax.text(small + 3, big + small, f"wheel,\n$r$ = {small:g} mm", fontsize=8, va="center")
    ax.add_patch(Arc((0, 0), 1.3 * big, 1.3 * big, theta1=100, theta2=170, color=_SURFACE, lw=1.8))
    tip = 0.65 * big * np.array([math.cos(math.radians(100)), math.sin(math.radians(100))])
    arrow(ax, tip - np.array([4.0, -0.7]), tip + np.array([2.0, -0.3]), _SURFACE)
    ax.text(-0.33 * big, 0.22 * big, r"$\omega$", fontsize=10, color=_SURFACE)
    _clean(ax, (-big - 4, big + 4, -big - 3, _ROD + 32))
    ax.set_title("along the cylinder\nat $\\phi$ = 0", fontsize=9)


def draw_above(ax: Axes, numbers: Mapping[str, Any], snapshot: Mapping[str, Any]) -> None:
    """Draw the view from above: cylinder, wheel, link and both speeds."""
    from matplotlib.patches import Polygon, Rectangle

    big, small, crown = (1e3 * numbers[name] for name in ("cylinder_radius", "wheel_radius", "crown_radius"))
    ax.add_patch(Rectangle((-_WINDOW, -big), 2 * _WINDOW, 2 * big, facecolor=_STEEL, edgecolor="none"))
    for edge in (-big, big):
        ax.plot([-_WINDOW, _WINDOW], [edge, edge], color=_EDGE, lw=1)
    # Lines on the surface, closer together where it curves away from the viewer.
    for around in np.radians(np.arange(-80.0, 81.0, 20.0)):
        ax.plot([-_WINDOW, _WINDOW], 2 * [big * math.sin(around)], color="#CBD2DA", lw=0.6)
    ax.add_patch(Rectangle((-_WINDOW, _ROD - 4), 2 * _WINDOW, 8, facecolor="white", edgecolor=_EDGE))
    if snapshot["angle"] == 0:
        ax.text(-_WINDOW + 3, _ROD - 0.5, "link", fontsize=7, va="center")
    ax.plot([0, 0], [0, _ROD - 4], color=_EDGE, lw=3.5, alpha=0.55, solid_capstyle="butt")
    _, rolling = directions(snapshot["angle"])
    ax.plot(*np.stack([-30.0 * rolling, 30.0 * rolling], -1), color="black", lw=0.8, ls=(0, (5, 3)))
    outline = silhouette(small, crown, _HALF_WIDTH, snapshot["angle"])
    ax.add_patch(Polygon(outline, facecolor="#B9C2CE", edgecolor="black", zorder=3))
    arrow(ax, (-24, -44), (-24, -44 + _SURFACE_ARROW), _SURFACE)
    ax.text(-20, -44, "$R\\omega$", color=_SURFACE, fontsize=9, va="bottom")
    length = _SURFACE_ARROW * snapshot["speed"]
    if math.isnan(length):
        for way in (-1, 1):
            arrow(ax, (0, _ROD + 12), (way * 0.9 * _SURFACE_ARROW, _ROD + 12), _LINK, linestyle="--", lw=1.2)
        said = "link free"
    elif length:
        start = -0.5 * length
        arrow(ax, (start, _ROD + 12), (start + length, _ROD + 12), _LINK, shrinkA=0, mutation_scale=8)
        said = r"$\dot{l}$ = " + f"{snapshot['speed']:.3g} $R\\omega$".replace("-", "\N{MINUS SIGN}")
    else:
        ax.plot([0], [_ROD + 12], "s", color=_LINK, ms=4)
        said = r"$\dot{l}$ = 0"
    ax.text(0, _ROD + 18, said, color=_LINK, fontsize=9, ha="center", va="bottom")
    _clean(ax, (-_WINDOW - 2, _WINDOW + 2, -big - 3, _ROD + 32))
    degrees = f"{math.degrees(snapshot['angle']):.3g}°".replace("-", "\N{MINUS SIGN}")
    ax.set_title(f"$\\phi$ = {degrees}\n{_words(snapshot)}", fontsize=9)


def _words(snapshot: Mapping[str, Any]) -> str:
    if snapshot["angle"] == 0:
        return "link locked"
    if math.isnan(snapshot["speed"]):
        return "link decoupled"
    return f"{snapshot['ratio']:.3g}:1, {'forward' if snapshot['speed'] > 0 else 'backward'}"


def draw_patch(ax: Axes, snapshot: Mapping[str, Any]) -> None:
    """Draw the contact patch from above, with its axes and the rolling direction."""
    from matplotlib.patches import Ellipse

    a, b = 1e3 * snapshot["a"], 1e3 * snapshot["b"]
    _, rolling = directions(snapshot["angle"])
    heading = math.degrees(math.atan2(rolling[1], rolling[0]))
    # Seen from above, the lateral direction is clockwise from the rolling direction.
    along = heading - math.degrees(snapshot["turn"])
    ax.add_patch(Ellipse((0, 0), 2 * a, 2 * b, angle=along, facecolor="#F7E3D7", edgecolor=style.COLOURS[1]))
    ax.plot(*np.stack([-0.5 * rolling, 0.5 * rolling], -1), color="black", lw=0.8, ls=(0, (5, 3)))
    for semi, turned in ((a, along), (b, along + 90.0)):
        end = semi * np.array([math.cos(math.radians(turned)), math.sin(math.radians(turned))])
        ax.plot(*np.stack([-end, end], -1), color=style.COLOURS[1], lw=1.0)
    ax.set_aspect("equal")
    ax.set(xlim=(-0.52, 0.52), ylim=(-0.52, 0.52), xticks=(-0.4, 0, 0.4), yticks=(-0.4, 0, 0.4))
    ax.tick_params(labelsize=7)
    ax.set_title(f"$a$ = {a:.3f} mm\n$b$ = {b:.3f} mm", fontsize=8)


def draw(axes: Any, numbers: Mapping[str, Any]) -> None:
    """Draw into two rows of axes: the views above, the contact patches below."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    draw_end(axes[0, 0], numbers)
    for column, snapshot in enumerate(numbers["snapshots"], start=1):
        draw_above(axes[0, column], numbers, snapshot)
        draw_patch(axes[1, column], snapshot)
        axes[1, column].set_xlabel("along the link [mm]", fontsize=8)
    axes[1, 1].set_ylabel("around the\ncylinder [mm]", fontsize=8)
    key = axes[1, 0]
    key.axis("off")
    handles = [
        Line2D([], [], color=_SURFACE, lw=1.8, label="surface speed"),
        Line2D([], [], color=_LINK, lw=1.8, label="link speed"),
        Line2D([], [], color="black", lw=0.8, ls=(0, (5, 3)), label="rolling direction"),
        Patch(facecolor="#F7E3D7", edgecolor=style.COLOURS[1], label="contact patch"),
    ]
    key.legend(handles=handles, loc="center")


def draw_all(machine: PaperMachine) -> Figure:
    """Draw the figure."""
    numbers = data(machine)
    with style.styled():
        made, axes = style.figure(
            10.4,
            5.3,
            2,
            1 + len(ANGLES),
            gridspec_kw={"height_ratios": [3.0, 1.15], "width_ratios": [1.5, 1, 1, 1, 1, 1]},
        )
        draw(axes, numbers)
    return made
