"""Steady rolling of a contact patch: tractions, stick and slip areas, and the traction along its middle row."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.contact.exact.patch import SteadyRolling
from infinivar.errors import InputError
from infinivar.figures import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import PolyCollection
    from matplotlib.figure import Figure

_ARROWS = 11
"""Most arrows along a row."""

_LONGEST = 1.1
"""Longest arrow over the mean distance of arrows along the patch's longer side."""

_HEIGHT, _MARGIN = 0.62, 1.12
"""Height of the patch's panel over its width, and its extent over that of the patch."""

_SLENDER = 4.0
"""Ratio of the patch's extents, relative to the panel's, from which the axes have different scales."""

_SHADE = ("#FFFFFF", "#7CC4EF")
_STICK, _SLIP = style.COLOURS[0], style.COLOURS[1]


def data(found: SteadyRolling) -> dict[str, Any]:
    """Outline, cells, tractions and slip of the patch, places over c, and the middle row.

    Raises
    ------
    InputError
        If the state has not converged.
    """
    if found.outcome == "not converged":
        raise InputError("a state that has not converged has no figure: outcome is 'not converged'")
    grid = found.grid
    share = np.hypot(*found.traction) / grid.bound
    middle = grid.rows // 2
    return {
        "outline": _outline(grid.a_over_b, grid.turned),
        "x": grid.x,
        "y": np.broadcast_to(grid.y[:, None], grid.x.shape),
        "length": grid.length,
        "width": grid.width,
        "share": share,
        "traction": found.traction,
        "slip": np.where(found.slides, found.slip, 0.0),
        "slides": found.slides,
        "border": _border(found, share),
        "row": {
            "edges": np.append(
                grid.x[middle] - 0.5 * grid.length[middle], grid.x[middle, -1] + 0.5 * grid.length[middle]
            ),
            "x": found.traction[0, middle],
            "y": found.traction[1, middle],
            "bound": grid.bound[middle],
        },
        "forces": {"F_x": found.fx, "F_y": found.fy, "M_z": found.mz},
        "slip_share": found.slip_share,
    }


def _outline(a_over_b: float, turned: float) -> np.ndarray:
    """Edge of the ellipse, (2, n)."""
    around = np.linspace(0.0, 2.0 * math.pi, 181)
    a = math.sqrt(a_over_b)
    along, across = a * np.cos(around), np.sin(around) / a
    cosine, sine = math.cos(turned), math.sin(turned)
    return np.array([along * cosine - across * sine, along * sine + across * cosine])


def _border(found: SteadyRolling, share: np.ndarray) -> dict[str, np.ndarray]:
    """Field that is positive where the patch sticks and falls through 0 at the border, on the cells and around them."""
    grid = found.grid
    slip = np.hypot(*found.slip)
    most = float(np.max(slip, where=found.slides, initial=1e-300))
    field = np.where(found.slides, -slip / most, np.maximum(1.0 - share, 1e-6))
    half = 0.5 * grid.length[:, None]
    x = np.concatenate([grid.x[:, :1] - half, grid.x, grid.x[:, -1:] + half], axis=1)
    y = np.broadcast_to(grid.y[:, None], x.shape)
    # Outside the patch nothing sticks: the border closes along the edge.
    edge = -1e-9
    field = np.pad(field, 1, constant_values=edge)
    x = np.pad(x, ((1, 1), (0, 0)), mode="edge")
    y = np.concatenate([y[:1] - 0.5 * grid.width, y, y[-1:] + 0.5 * grid.width])
    return {"x": x, "y": y, "stick": field}


def draw_patch(ax: Axes, numbers: Mapping[str, Any]) -> PolyCollection:
    """Draw tractions over the share of the friction bound, the stick area and slip; returns the shading."""
    from matplotlib.collections import PolyCollection
    from matplotlib.colors import LinearSegmentedColormap
    from matplotlib.patches import Polygon

    outline = numbers["outline"]
    extent = np.abs(outline).max(axis=1)
    colours = LinearSegmentedColormap.from_list("share", _SHADE)
    cells = PolyCollection(list(_rectangles(numbers, extent)), array=numbers["share"].ravel(), cmap=colours)
    cells.set(clim=(0.0, 1.0), edgecolor="face", linewidth=0.4, zorder=1)
    ax.add_collection(cells)
    edge = ax.add_patch(Polygon(outline.T, closed=True, fill=False, edgecolor="grey", lw=0.9, zorder=2))
    cells.set_clip_path(edge)
    border = numbers["border"]
    if 0.0 < numbers["slip_share"] < 1.0:
        line = ax.contour(
            border["x"], border["y"], border["stick"], levels=[0.0], colors=_STICK, linewidths=1.8, zorder=3
        )
        line.set_clip_path(edge)
    half = _MARGIN * extent
    stretched = max(half[0] * _HEIGHT / half[1], half[1] / (half[0] * _HEIGHT)) > _SLENDER
    if not stretched:
        half[0] = max(half[0], half[1] / _HEIGHT)
        half[1] = half[0] * _HEIGHT
    ax.set_xlim(-half[0], half[0])
    ax.set_ylim(-half[1], half[1])
    ax.set_box_aspect(_HEIGHT)
    part = max(extent[0] / half[0], _HEIGHT * extent[1] / half[1])
    _arrows(ax, numbers, numbers["slip"], 1, part, _SLIP)
    _arrows(ax, numbers, numbers["traction"], 0, part, "black")
    ax.set_xlabel("along rolling, forwards to the right, $x/c$ [-]")
    ax.set_ylabel("lateral $y/c$ [-]" + (", stretched" if stretched else ""))
    return cells


def _rectangles(numbers: Mapping[str, Any], extent: np.ndarray) -> np.ndarray:
    """Corners of the cells, (n, 4, 2); those at the edge reach beyond it, to be clipped there."""
    half = 0.5 * numbers["length"][:, None]
    left, right = numbers["x"] - half, numbers["x"] + half
    left[:, 0], right[:, -1] = -2.0 * extent[0], 2.0 * extent[0]
    low, high = numbers["y"] - 0.5 * numbers["width"], numbers["y"] + 0.5 * numbers["width"]
    low[0], high[-1] = -2.0 * extent[1], 2.0 * extent[1]
    corners = [(left, low), (right, low), (right, high), (left, high)]
    return np.stack([np.stack(corner, axis=-1) for corner in corners], axis=-2).reshape(-1, 4, 2)


def _arrows(ax: Axes, numbers: Mapping[str, Any], vectors: np.ndarray, first: int, part: float, colour: str) -> None:
    """Draw vectors in every second cell or fewer, with the patch's part of the panel's width. Angles are those of equal axes."""
    step = 2 * math.ceil(len(numbers["x"]) / _ARROWS / 2)
    cells = slice((step - 2) // 4 + first * step // 2, None, step)
    u, v = vectors[:, cells, cells]
    longest = float(np.hypot(*vectors).max())
    shown = np.hypot(u, v) > 0.02 * longest
    if not np.any(shown):
        return
    x, y = numbers["x"][cells, cells][shown], numbers["y"][cells, cells][shown]
    scale = _ARROWS * longest / (_LONGEST * part)
    ax.quiver(
        x, y, u[shown], v[shown], color=colour, angles="uv", pivot="mid", scale=scale, scale_units="width",
        units="width", width=0.0042, zorder=4,
    )  # fmt: skip


def draw_row(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw the components of the traction along the middle row, between the friction bound and its negative."""
    row = numbers["row"]
    edges = row["edges"]
    top = 1.08 * float(row["bound"].max())
    ax.stairs(row["bound"], edges, baseline=-row["bound"], fill=True, color="#eeeeee")
    ax.stairs(row["bound"], edges, color="grey", ls="--", lw=1.0, label="friction bound")
    ax.stairs(-row["bound"], edges, color="grey", ls="--", lw=1.0)
    ax.stairs(row["x"], edges, baseline=None, color=style.COLOURS[4], lw=1.6, label="along rolling")
    ax.stairs(row["y"], edges, baseline=None, color=style.COLOURS[2], lw=1.6, label="lateral")
    reach = _MARGIN * max(-edges[0], edges[-1])
    ax.set_xlim(-reach, reach)
    ax.set_ylim(-top, top)
    ax.set_xlabel("along rolling in the middle row, $x/c$ [-]")
    ax.set_ylabel(r"traction $p\,c^2/(\mu N)$ [-]")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, 1.2), ncols=3)


def draw_all(found: SteadyRolling) -> Figure:
    """Draw the patch, and its middle row below."""
    from matplotlib.lines import Line2D

    numbers = data(found)
    with style.styled():
        made, axes = style.figure(5.6, 6.0, 2, 1, height_ratios=(3.4, 2.0))
        shading = draw_patch(axes[0], numbers)
        made.colorbar(shading, ax=axes[0], label="traction over friction bound [-]", shrink=0.8)
        keys = [
            Line2D([], [], color="black", marker=r"$\rightarrow$", ls="", ms=12, label="traction on the track"),
            Line2D([], [], color=_SLIP, marker=r"$\rightarrow$", ls="", ms=12, label="slip of the wheel"),
            Line2D([], [], color=_STICK, lw=1.8, label="stick area"),
        ]
        shown = [True, bool(numbers["slides"].any()), 0.0 < numbers["slip_share"] < 1.0]
        handles = [key for key, drawn in zip(keys, shown, strict=True) if drawn]
        axes[0].legend(handles=handles, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3)
        draw_row(axes[1], numbers)
        units = {"F_x": r"\mu N", "F_y": r"\mu N", "M_z": r"\mu N c"}
        words = [f"${name} = {round(value, 3) + 0.0:.3f}\\,{units[name]}$" for name, value in numbers["forces"].items()]
        made.suptitle(f"{', '.join(words)}; slip in {100.0 * numbers['slip_share']:.0f} % of the area")
    return made
