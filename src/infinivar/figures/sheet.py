"""A drive to scale: side and front view with dimensions, masses, and loads on bearings and rail."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from infinivar._core.text import capitalise
from infinivar.analysis.whole_mass import WholeMass
from infinivar.drivetrain.building.base import Load
from infinivar.figures import style
from infinivar.units import plain, show

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MM = 1e3
_VIEWS = {"side": "xz", "front": "yz"}
"""Axes along and up of each view."""
_BEHIND = ("frame", "rail", "carriage")
"""Drawn first: other bodies stand before them."""
_COLOURS = {"frame": "#DDDDDD", "rail": "#B0B8C4", "carriage": "#8C98A8", "bell": "#CDE7DD", "wheel": "#009E73"}
_OTHERS = {"motor": "#E69F00", "gearhead": "#0072B2", "bearing": "#56B4E9", "cylinder": "#F3E3C3"}
"""Colours by the last word of a name."""
_PLAIN = "#D8C8E8"
_NAMED = (
    "cylinder",
    "wheel",
    "bell",
    "carriage",
    "gearhead",
    "motor",
    "steering motor",
    "cylinder motor",
    "pulley",
    "screw",
    "rack",
)


def data(mass: WholeMass, loads: Sequence[Load]) -> dict[str, Any]:
    """Outlines by view, and rows of the tables.

    Returns
    -------
    dict
        ``side`` and ``front``: rows (body, form, left, bottom, width, height) in mm, the form "box" or "round"; ``sizes``:
        extents of the whole in mm by name; ``masses``: rows (body, g, share, kind); ``loads``: rows (place, part, radial N, axial
        N, margin).
    """
    views = {
        name: [
            (one.body, "round" if one.form not in ("box", along, up) else "box", *_rectangle(one, along, up))
            for one in mass.layout.solids
        ]
        for name, (along, up) in _VIEWS.items()
    }
    known = mass.known
    return {
        **views,
        "sizes": {name: _MM * float(side) for name, side in mass.layout.space._asdict().items()},
        "masses": [
            (
                body.name,
                None if body.mass is None else 1e3 * body.mass,
                0.0 if body.mass is None else body.mass / known,
                body.kind,
            )
            for body in mass.bodies
        ],
        "loads": [(one.body, one.part, one.radial, one.axial, one.margin) for one in loads],
    }


def _rectangle(solid: Any, along: str, up: str) -> tuple[float, float, float, float]:
    (left, right), (bottom, top) = getattr(solid, along), getattr(solid, up)
    return _MM * float(left), _MM * float(bottom), _MM * float(right - left), _MM * float(top - bottom)


def draw(ax: Axes, numbers: Mapping[str, Any], view: str) -> None:
    """Draw one view to scale, with the extents of the whole and of its main bodies."""
    from matplotlib.patches import Ellipse, Rectangle

    rows = sorted(numbers[view], key=lambda row: row[0] not in _BEHIND)
    seen: dict[str, tuple[float, float, float, float]] = {}
    turned: set[str] = set()
    for body, form, left, bottom, width, height in rows:
        looks = {"facecolor": _colour(body), "edgecolor": "black", "linewidth": 0.6, "alpha": 0.85}
        if form == "round":
            ax.add_patch(Ellipse((left + 0.5 * width, bottom + 0.5 * height), width, height, **looks))
        else:
            ax.add_patch(Rectangle((left, bottom), width, height, **looks))
        if body not in seen or (form == "round" and body not in turned):
            seen[body] = left, bottom, width, height
        if form == "round":
            turned.add(body)
    (left, bottom, right, top), gap = _box(rows)
    _dimension(ax, (left, bottom - gap), (right, bottom - gap), right - left)
    _dimension(ax, (left - gap, bottom), (left - gap, top), top - bottom)
    if view == "side":
        named = {body: place for body, place in seen.items() if body in _NAMED}
        _name(ax, named, turned, (right, top), gap)
    across, up = _frame(rows, view)
    ax.set_xlim(*across)
    ax.set_ylim(*up)
    ax.set_aspect("equal")
    ax.axis("off")
    ax.set_title(f"{view} view [mm]")


def _box(rows: Any) -> tuple[tuple[float, float, float, float], float]:
    """Left, bottom, right and top of a view, and the distance of its dimensions. [mm]"""
    low = [min(row[place] for row in rows) for place in (2, 3)]
    high = [max(row[place] + row[place + 2] for row in rows) for place in (2, 3)]
    return (*low, *high), 0.07 * max(high[0] - low[0], high[1] - low[1])  # type: ignore[return-value]


def _frame(rows: Any, view: str) -> tuple[tuple[float, float], tuple[float, float]]:
    """Limits of the axes of a view, with room for dimensions and names. [mm]"""
    (left, bottom, right, top), gap = _box(rows)
    beside = right - left if view == "side" else 0.0
    return (left - 2.4 * gap, right + gap + 0.5 * beside), (bottom - 2.2 * gap, top + gap)


def _dimension(ax: Axes, start: tuple[float, float], end: tuple[float, float], size: float) -> None:
    """An arrow along an extent, with its size."""
    ax.annotate("", start, end, arrowprops={"arrowstyle": "<->", "linewidth": 0.7, "shrinkA": 0, "shrinkB": 0})
    upright = start[0] == end[0]
    middle = 0.5 * (start[0] + end[0]), 0.5 * (start[1] + end[1])
    ax.annotate(
        plain(size, 3),
        middle,
        (-3, 0) if upright else (0, -2),
        textcoords="offset points",
        rotation=90 if upright else 0,
        ha="right" if upright else "center",
        va="center" if upright else "top",
        fontsize=8,
    )


def _name(
    ax: Axes,
    places: Mapping[str, tuple[float, float, float, float]],
    turned: Collection[str],
    corner: tuple[float, float],
    gap: float,
) -> None:
    """Names to the right, in the order of heights, with width and height or the diameter of what is seen along its axis."""
    right, top = corner
    order = sorted(places, key=lambda body: -(places[body][1] + 0.5 * places[body][3]))
    low = min(bottom for _, bottom, _, _ in places.values())
    for place, body in enumerate(order):
        left, bottom, width, height = places[body]
        level = top - (top - low) * (place + 0.5) / len(order)
        ax.annotate(
            f"{body} ⌀ {plain(width, 3)}" if body in turned else f"{body} {plain(width, 3)} x {plain(height, 3)}",
            (left + 0.5 * width, bottom + 0.5 * height),
            (right + 0.8 * gap, level),
            fontsize=7,
            va="center",
            arrowprops={"arrowstyle": "-", "linewidth": 0.4, "shrinkA": 0, "shrinkB": 0, "relpos": (0.0, 0.5)},
        )


def _colour(body: str) -> str:
    return _COLOURS.get(body, _OTHERS.get(body.split()[-1].removesuffix("s"), _PLAIN))


def draw_all(mass: WholeMass, loads: Sequence[Load], title: str) -> Figure:
    """Both views above the tables of masses and loads."""
    numbers = data(mass, loads)
    with style.styled():
        views = [_frame(numbers[view], view)[0] for view in _VIEWS] if mass.layout.solids else [(0.0, 1.0)] * 2
        ratios = [
            max(end - start, 0.55 * sum(b - a for a, b in views)) if not place else end - start
            for place, (start, end) in enumerate(views)
        ]
        ratios[1] = max(ratios[1], 0.6 * ratios[0])  # for the table below
        made, axes = style.figure(11.0, 7.8, 2, 2, width_ratios=ratios, height_ratios=(1.25, 1.0), squeeze=False)
        made.suptitle(f"{title}: {mass.size_words}")
        if mass.layout.solids:
            for ax, view, wide in zip(axes[0], _VIEWS, ratios, strict=True):
                draw(ax, numbers, view)
                spare = 0.5 * (wide - sum(end * sign for end, sign in zip(ax.get_xlim(), (-1, 1), strict=True)))
                ax.set_xlim(ax.get_xlim()[0] - spare, ax.get_xlim()[1] + spare)  # one scale for both
            low, high = zip(*(ax.get_ylim() for ax in axes[0]), strict=True)
            for ax in axes[0]:
                ax.set_ylim(min(low), max(high))
        else:
            axes[0, 0].axis("off")
            axes[0, 1].axis("off")
        _table(
            axes[1, 0],
            ("load on", "part", "radial", "axial", "static rating\nover load"),
            [
                (
                    body,
                    part,
                    show(radial, "N", 3),
                    show(axial, "N", 3),
                    plain(margin, 3) if math.isfinite(margin) else "–",
                )
                for body, part, radial, axial, margin in numbers["loads"]
            ],
            (0.28, 0.26, 0.15, 0.15, 0.16),
        )
        _table(
            axes[1, 1],
            ("body", "mass", "share", "kind"),
            [
                (
                    body,
                    "not known" if grams is None else f"{plain(grams, 3)} g",
                    "–" if grams is None else plain(100.0 * share, 2) + " %",
                    kind,
                )
                for body, grams, share, kind in numbers["masses"]
            ],
            (0.4, 0.22, 0.16, 0.22),
        )
    return made


def _table(ax: Axes, head: Sequence[str], rows: Sequence[Sequence[str]], widths: Sequence[float]) -> None:
    """A table that fills its axes from the top."""
    ax.axis("off")
    if not rows:
        return
    made = ax.table(
        [[capitalise(rows_of[0]), *rows_of[1:]] for rows_of in rows],
        colLabels=list(head),
        colWidths=list(widths),
        loc="upper center",
        cellLoc="left",
    )
    made.auto_set_font_size(False)
    made.set_fontsize(7)
    for (row, _), cell in made.get_celld().items():
        cell.set_linewidth(0.3)
        cell.set_height(0.07 if row else 0.09)
        cell.PAD = 0.04
