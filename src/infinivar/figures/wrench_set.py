"""Wrenches that a machine can hold, in planes of two components: the section with the other components 0, and the projection."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.errors import InputError
from infinivar.figures import style
from infinivar.limits import Limit
from infinivar.transmission.wrench_set import WrenchSet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SPATIAL = (
    "force $W_x$ [N]",
    "force $W_y$ [N]",
    "force $W_z$ [N]",
    "moment $M_x$ [N m]",
    "moment $M_y$ [N m]",
    "moment $M_z$ [N m]",
)
_PLANES = ((0, 1), (0, 2), (3, 4))
_COLOURS = {Limit.SLIP: style.COLOURS[0], Limit.THERMAL: style.COLOURS[1]}
_OTHER = style.COLOURS[3]
_PARALLEL, _SHORT = 1e-9, 1e-6
"""Relative sizes: of a normal along the plane, below which a facet does not meet it, and of an edge left out."""

_SECTION, _PROJECTION = "#CFE3F1", "#EDEDED"


def data(found: WrenchSet, plane: tuple[int, int]) -> dict[str, Any]:
    """Outlines of a set in the plane of two of its components.

    Parameters
    ----------
    found : WrenchSet      Of two components or more.
    plane : (int, int)     Components along the horizontal and the vertical axis, from 0.

    Returns
    -------
    dict
        names of the components; section (s, 2): corners in order with all other components 0; limits (s,): `Limit` beyond the
        edge from each corner to the next; projection (p, 2): corners in order where the other components take any value.
    """
    from scipy.spatial import ConvexHull

    freedoms = found.normals.shape[1]
    pair = list(plane)
    if len(set(pair) & set(range(freedoms))) < 2:
        raise InputError(f"plane must be two of the components 0 to {freedoms - 1} of the wrench, got {plane}")
    size = 1.01 * np.sum(np.abs(found.generators[pair, :]), axis=1)
    section, limits = _section(found.normals[:, pair], found.bounds, found.limits, size)
    seen = found.vertices()[:, pair]
    hull = ConvexHull(seen / np.max(np.abs(seen), axis=0)).vertices
    names = _SPATIAL if freedoms == 6 else [f"component {place + 1} of the wrench" for place in range(freedoms)]
    return {
        "names": (names[pair[0]], names[pair[1]]),
        "section": section,
        "limits": limits,
        "projection": seen[hull],
    }


def _section(
    normals: np.ndarray, bounds: np.ndarray, limits: np.ndarray, size: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Polygon ``normals . w <= bounds``, by cutting a rectangle of half sides `size` that holds it at one line after another."""
    corners = [np.array(corner) * size for corner in ((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0))]
    edges = [int(Limit.OK)] * 4
    for normal, bound, limit in zip(normals * size, bounds, limits, strict=True):
        if np.any(np.abs(normal) > _PARALLEL * abs(bound)):
            corners, edges = _cut(corners, edges, normal / size, float(bound), int(limit))
    polygon = np.array(corners)
    long = np.linalg.norm((np.roll(polygon, -1, axis=0) - polygon) / size, axis=1) > _SHORT
    return polygon[long], np.array(edges)[long]


def _cut(
    corners: list[np.ndarray], edges: list[int], normal: np.ndarray, bound: float, limit: int
) -> tuple[list[np.ndarray], list[int]]:
    """The part of a polygon with ``normal . w <= bound``; an edge belongs to the corner where it starts."""
    height = [float(normal @ corner) - bound for corner in corners]
    kept, named = [], []
    for place, corner in enumerate(corners):
        after = (place + 1) % len(corners)
        here, there = height[place], height[after]
        if here <= 0:
            kept.append(corner)
            named.append(edges[place])
        if (here <= 0) != (there <= 0):
            kept.append(corner + here / (here - there) * (corners[after] - corner))
            named.append(limit if here <= 0 else edges[place])
    return kept, named


def draw(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw projection and section, with the edges of the section in the colour of their limits."""
    section, limits = numbers["section"], numbers["limits"]
    ax.fill(*numbers["projection"].T, facecolor=_PROJECTION, edgecolor="#999999", lw=0.8, ls=(0, (4, 2)), zorder=1)
    ax.fill(*section.T, facecolor=_SECTION, edgecolor="none", zorder=2)
    for place, limit in enumerate(limits):
        ends = section[[place, (place + 1) % len(section)]]
        ax.plot(*ends.T, color=_COLOURS.get(Limit(limit), _OTHER), lw=1.8, solid_capstyle="round", zorder=3)
    ax.plot(0, 0, marker="+", color="black", ms=6, mew=0.8, zorder=4)
    ax.margins(0.06)
    ax.set_xlabel(numbers["names"][0])
    ax.set_ylabel(numbers["names"][1])


def draw_all(
    found: WrenchSet | Sequence[WrenchSet],
    titles: Sequence[str] = (),
    planes: Sequence[tuple[int, int]] | None = None,
) -> Figure:
    """Draw the figure: a row for each set, with its title; a column for each plane.

    Raises
    ------
    InputError
        If a set has one component, or a plane is not two of the components.
    """
    rows = [found] if isinstance(found, WrenchSet) else list(found)
    freedoms = min(one.normals.shape[1] for one in rows)
    if freedoms < 2:
        raise InputError("a set of wrenches of one component cannot be drawn: its bounds are all of it")
    if planes is None:
        planes = _PLANES if freedoms == 6 else [(0, place) for place in range(1, freedoms)]
    with style.styled():
        made, axes = style.figure(
            2.9 * len(planes) + 0.3,
            0.9 + 2.6 * len(rows),
            len(rows),
            len(planes),
            squeeze=False,
            sharex="col",
            sharey="col",
        )
        seen: set[int] = set()
        for one, row, title in zip(rows, axes, [*titles, *[""] * len(rows)], strict=False):
            for ax, plane in zip(row, planes, strict=True):
                numbers = data(one, plane)
                seen.update(numbers["limits"].tolist())
                draw(ax, numbers)
            if title:
                row[0].set_title(title, loc="left")
        for ax in axes[:-1].flat:
            ax.set_xlabel("")
        _legend(made, sorted(seen))
    return made


def _legend(made: Figure, limits: Sequence[int]) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles: list[Any] = [
        Line2D([], [], color=_COLOURS.get(Limit(limit), _OTHER), lw=1.8, label=f"limit: {Limit(limit).words}")
        for limit in limits
    ]
    handles += [
        Patch(facecolor=_SECTION, label="held without other components"),
        Patch(facecolor=_PROJECTION, edgecolor="#999999", ls=(0, (4, 2)), label="held with the best other components"),
    ]
    made.legend(handles=handles, loc="outside lower center", ncols=len(handles))
