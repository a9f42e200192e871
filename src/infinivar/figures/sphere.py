"""A sphere between its rollers drawn at one point: axis of the sphere, rollers along their headings, and forces on the sphere."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.errors import InputError
from infinivar.figures import style
from infinivar.transmission.spherical import SphericalIVT, SphericalPoint

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_AZIMUTH, _ELEVATION = np.radians(-38.0), np.radians(24.0)
_ROUND = np.linspace(0.0, 2.0 * np.pi, 73)
_ROLLERS = {"drive": "#E69F00", "steering": "#56B4E9", "idler": "#BBBBBB"}
_FORCE, _AXIS, _TURNING = style.COLOURS[1], "#000000", style.COLOURS[2]
_LONGEST = 1.1
"""Arrow of the slip limit over the radius of the sphere."""


def data(ivt: SphericalIVT, point: SphericalPoint) -> dict[str, Any]:
    """Geometry and forces of one point.

    Parameters
    ----------
    ivt : SphericalIVT       The machine.
    point : SphericalPoint   One point of it, of `SphericalIVT.operate`.

    Returns
    -------
    dict
        normals (k, 3): unit vectors to the contacts; axles (k, 3): unit vectors along the axles of the rollers; radius (k,): of
        the rollers over that of the sphere; force (k, 3): tangential force of each roller on the sphere [N]; limit (k,): slip
        force at rest [N]; slip (k,): demand over allowance; axis (3,): unit vector along the angular velocity of the sphere;
        kinds (k,); speeds, torques (2,): of shaft 1, by the source, and of shaft 2, on the load [rad/s], [N m].

    Raises
    ------
    InputError
        If there are many points, a roller slips, or the point is of another machine.
    """
    velocity = np.asarray(point.sphere_velocity)
    if velocity.shape != (3,) or not np.all(np.isfinite(velocity)) or not np.any(velocity):
        raise InputError("a sphere between rollers is drawn at one point, at which it turns and no roller slips")
    if point.kinds != ivt.kinds:
        raise InputError(f"ivt must be the machine of the point, with the rollers {', '.join(point.kinds)}")
    rollers = ivt.rollers
    contacts = [getattr(ivt, one.kind) for one in rollers]  # type: ignore[union-attr]
    normals = np.array([one.position for one in rollers])  # type: ignore[union-attr]
    axis = velocity / np.linalg.norm(velocity)
    # The axle of a steered roller is that part of the axis of the sphere which is tangential at the contact.
    steered = axis - (normals @ axis)[:, None] * normals
    fixed = [one.axis for one in rollers]  # type: ignore[union-attr]
    axles = np.array([own if own is not None else free for own, free in zip(fixed, steered, strict=True)])
    length = np.linalg.norm(axles, axis=1, keepdims=True)
    return {
        "normals": normals,
        "axles": axles / np.where(length > 0, length, 1.0),
        "radius": np.array([one.wheel_radius for one in contacts]) / ivt.sphere_radius,
        "force": np.asarray(point.contact_force),
        "limit": np.array([float(one.slip_force) for one in contacts]),
        "slip": np.asarray(point.slip_demand),
        "axis": axis,
        "kinds": point.kinds,
        "speeds": np.array([float(point.input_speed), float(point.output_speed)]),
        "torques": np.array([float(point.input_torque), float(point.output_torque)]),
        "angle": float(point.steering_angle),
    }


def _seen(points: Any) -> np.ndarray:
    """Points in space, (..., 3), as a viewer far away sees them: to the right and up."""
    right = np.array([-np.sin(_AZIMUTH), np.cos(_AZIMUTH), 0.0])
    return np.stack([points @ right, points @ np.cross(_viewer(), right)], axis=-1)


def _viewer() -> np.ndarray:
    return np.array([np.cos(_ELEVATION) * np.cos(_AZIMUTH), np.cos(_ELEVATION) * np.sin(_AZIMUTH), np.sin(_ELEVATION)])


def draw(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw the sphere, its axis and equator, the rollers and the forces, with the radius of the sphere as unit."""
    rim = np.stack([np.cos(_ROUND), np.sin(_ROUND)], axis=-1)
    ax.fill(*rim.T, facecolor="#E9ECEF", edgecolor="#555555", lw=1.0, alpha=0.85, zorder=2)
    first = np.cross(numbers["axis"], [0.3, -0.5, 0.8])
    first /= np.linalg.norm(first)
    equator = np.cos(_ROUND)[:, None] * first + np.sin(_ROUND)[:, None] * np.cross(numbers["axis"], first)
    front = np.where((equator @ _viewer() > 0)[:, None], _seen(equator), np.nan)
    ax.plot(*front.T, color=_TURNING, lw=1.2, zorder=2.5)
    for sign in (1.0, -1.0):
        ends = _seen(np.outer([1.0, 1.7], sign * numbers["axis"]))
        above = 5 if sign * numbers["axis"] @ _viewer() > 0 else 1
        ax.plot(*ends.T, color=_AXIS, lw=1.4, ls=(0, (6, 2, 1, 2)), zorder=above)
    for place in range(len(numbers["kinds"])):
        _roller(ax, numbers, place)
    ax.set_aspect("equal")
    ax.set_axis_off()


def _roller(ax: Axes, numbers: Mapping[str, Any], place: int) -> None:
    """Disc of a roller, its number and its force."""
    from scipy.spatial import ConvexHull

    normal, axle, radius = numbers["normals"][place], numbers["axles"][place], numbers["radius"][place]
    kind, force = numbers["kinds"][place], numbers["force"][place]
    hub, across = (1.0 + radius) * normal, np.cross(axle, normal)
    disc = hub + radius * (np.cos(_ROUND)[:, None] * normal + np.sin(_ROUND)[:, None] * across)
    above = 4.0 if normal @ _viewer() > 0 else 1.0
    width = 0.35 * radius
    near = width if axle @ _viewer() > 0 else -width
    both = _seen(np.concatenate([disc - near * axle, disc + near * axle]))
    ax.fill(*both[ConvexHull(both).vertices].T, facecolor=_ROLLERS[kind], edgecolor="black", lw=0.8, zorder=above)
    ax.fill(*both[len(disc) :].T, facecolor=_ROLLERS[kind], edgecolor="black", lw=0.8, zorder=above + 0.1)
    ax.plot(*_seen(hub + np.outer([near, 2.2 * near], axle)).T, color="black", lw=2.0, zorder=above + 0.2)
    scale = _LONGEST / float(np.max(numbers["limit"]))
    start, end = _seen(normal), _seen(normal + scale * force)
    arrow = {"arrowstyle": "-|>", "color": _FORCE, "lw": 1.8, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 11}
    ax.annotate("", xy=tuple(end), xytext=tuple(start), arrowprops=arrow, zorder=6)
    words = f"{place + 1} {kind}: {np.linalg.norm(force):.3g} N,\n{100.0 * numbers['slip'][place]:.0f} % of slip limit"
    at = _seen((1.0 + 2.0 * radius) * normal)
    side = np.sign(np.round(at[0], 6)) or 1.0
    ax.annotate(
        words,
        tuple(_seen(hub)),
        (side * 2.1, 1.05 * at[1] + (0.12 if at[1] >= 0 else -0.12)),
        ha="left" if side > 0 else "right",
        va="center",
        fontsize=7,
        zorder=7,
        arrowprops={"arrowstyle": "-", "color": "#999999", "lw": 0.6},
    )
    ax.update_datalim([tuple(end), (side * 3.2, at[1])])


def draw_all(ivt: SphericalIVT, point: SphericalPoint) -> Figure:
    """Draw the figure; arguments as in `data`."""
    from matplotlib.lines import Line2D

    numbers = data(ivt, point)
    (first, second), (given, taken) = numbers["speeds"], numbers["torques"]
    with style.styled():
        made, ax = style.figure(7.2, 5.2)
        draw(ax, numbers)
        ax.autoscale_view()
        made.suptitle(
            f"{np.degrees(numbers['angle']):.4g}° of steering; shaft 1: {given:.3g} N m at {first:.3g} rad/s; "
            f"shaft 2: {taken:.3g} N m at {second:.3g} rad/s",
            fontsize=9,
        )
        key = [
            Line2D([], [], color=_FORCE, lw=1.8, label="force of a roller on the sphere"),
            Line2D([], [], color=_AXIS, lw=1.4, ls=(0, (6, 2, 1, 2)), label="axis of the sphere"),
            Line2D([], [], color=_TURNING, lw=1.2, label="its equator"),
        ]
        made.legend(handles=key, loc="outside lower center", ncols=3)
    return made
