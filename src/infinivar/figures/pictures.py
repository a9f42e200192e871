"""Pictures of machines painted by matplotlib."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.figures import style
from infinivar.machines.pictures.strokes import Arrow, Disc, Label, Line, Picture, Stroke, Turning, bounds

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SHARES = "coolwarm"
"""Colours of shares of a limit, from -1 to 1."""

SLIPS = "#B3400A"
"""Of a wheel that slips."""

_EDGE, _BLACK = "#555555", "#000000"
_LOOKS: dict[str, dict[str, Any]] = {
    "plate": {"facecolor": "#E9ECEF", "edgecolor": _EDGE, "lw": 1.0},
    "platform": {"facecolor": "#F4E3B2", "edgecolor": _EDGE, "lw": 1.0, "alpha": 0.9},
    "steel": {"facecolor": "#DEE2E6", "edgecolor": _EDGE, "lw": 0.8, "alpha": 0.8},
    "wheel": {"facecolor": "#39424B", "edgecolor": _BLACK, "lw": 0.7},
    "wheel-slips": {"facecolor": SLIPS, "edgecolor": _BLACK, "lw": 0.7},
    "roller-drive": {"facecolor": "#E69F00", "edgecolor": _BLACK, "lw": 0.8},
    "roller-steering": {"facecolor": "#56B4E9", "edgecolor": _BLACK, "lw": 0.8},
    "roller-idler": {"facecolor": "#BBBBBB", "edgecolor": _BLACK, "lw": 0.8},
    "joint": {"facecolor": "white", "edgecolor": _BLACK, "lw": 1.0},
    "point": {"facecolor": _BLACK, "edgecolor": "none"},
    "limit": {"facecolor": "none", "edgecolor": style.COLOURS[1], "lw": 0.8, "ls": (0, (1, 2))},
    "stripe": {"facecolor": "#9AA4AE", "edgecolor": "none", "alpha": 0.8},
    "stripe-pale": {"facecolor": "#BCC4CB", "edgecolor": "none", "alpha": 0.8},
    "pulley": {"facecolor": "none", "edgecolor": "#AAAAAA", "lw": 1.0},
    "guide": {"color": "#AAAAAA", "lw": 1.0},
    "base": {"color": "#999999", "lw": 5.0, "solid_capstyle": "butt"},
    "member": {"color": "#56646F", "lw": 6.0, "solid_capstyle": "round"},
    "rod": {"color": "#9DB4C8", "lw": 3.8, "solid_capstyle": "round", "edged": 5.2},
    "rod-slips": {"color": SLIPS, "lw": 3.8, "solid_capstyle": "round", "edged": 5.2},
    "carriage-line": {"color": _EDGE, "lw": 2.0},
    "heading": {"color": "#999999", "lw": 0.8, "ls": (0, (4, 3))},
    "axis": {"color": _BLACK, "lw": 1.2, "ls": (0, (6, 2, 1, 2))},
    "equator": {"color": style.COLOURS[2], "lw": 1.2},
    "scale": {"color": _BLACK, "lw": 1.6, "solid_capstyle": "butt"},
    "force": {"color": _BLACK},
    "load-force": {"color": style.COLOURS[3]},
    "contact-force": {"color": style.COLOURS[1]},
    "velocity": {"color": style.COLOURS[2]},
    "gravity": {"color": "#888888"},
    "track": {"color": style.COLOURS[0], "lw": 5.0, "alpha": 0.5, "solid_capstyle": "round"},
}
"""How matplotlib paints each look."""

_ANCHORS = {"start": "left", "middle": "center", "end": "right"}
_RISES = {1: "bottom", 0: "center", -1: "top"}

_WIDTH, _AROUND, _BARE, _PAD = 6.4, 1.5, 0.9, 0.1
"""Width of a figure, height of what stands around the drawing with and without a heading, and room above that. [inch]"""

_ROOM, _LITTLE = 0.16, 0.06
"""Margins over the extent of what is drawn, beside it, and above and below what has no axes."""


def paint(ax: Axes, strokes: Iterable[Stroke], *, scale: float = 1.0, above: float = 2.0) -> None:
    """Paint strokes one over the other, words over all.

    Parameters
    ----------
    ax : Axes
    strokes : iterable of Stroke
    scale : float   Units of the axes in a metre.
    above : float   Order of painting of the first; the last is below 1 more.
    """
    from matplotlib import colormaps
    from matplotlib.patches import Circle
    from matplotlib.patheffects import withStroke

    for place, one in enumerate(strokes):
        order = above + 1e-3 * place
        look = {} if isinstance(one, (Label, Turning)) else {**_LOOKS[one.look], "zorder": order}
        match one:
            case Line():
                if one.share is not None:
                    look["color"] = colormaps[SHARES](0.5 + 0.5 * one.share)
                if "edged" in look:
                    look["path_effects"] = [withStroke(linewidth=look.pop("edged"), foreground=_EDGE)]
                (ax.fill if one.closed else ax.plot)(*(scale * np.asarray(one.points)).T, **look)
            case Disc():
                ax.add_patch(Circle(tuple(scale * np.asarray(one.centre)), scale * one.radius, **look))
            case Arrow():
                style.arrow(ax, scale * np.asarray(one.start), scale * np.asarray(one.end), look["color"], zorder=order)
            case Label():
                within = one.look == "number"
                ax.text(
                    scale * one.at[0],
                    scale * one.at[1],
                    f"{one.words},\n{one.more}" if one.more else one.words,
                    ha=_ANCHORS[one.anchor],
                    va=_RISES[one.rises],
                    fontsize=7,
                    zorder=order if within else above + 1.0,
                    bbox=None if within else style.BLANK,
                )


def draw(ax: Axes, picture: Picture) -> None:
    """Draw a picture, with its axes if it has some."""
    paint(ax, picture.strokes)
    low, high = bounds(picture.strokes)
    room = float(np.max(high - low)) * np.array([_ROOM, _ROOM if picture.axes else _LITTLE])
    (left, bottom), (right, top) = low - room, high + room
    ax.set_xlim(left, right)
    ax.set_ylim(bottom, top)
    ax.set_aspect("equal")
    if picture.axes is None:
        ax.set_axis_off()
    else:
        ax.set_xlabel(picture.axes[0])
        ax.set_ylabel(picture.axes[1])
    ax.set_title(picture.heading, fontsize=9)


def handles(picture: Picture) -> list[Any]:
    """Entries of a legend for what is drawn."""
    from matplotlib.lines import Line2D

    looks = [(_LOOKS.get(look, {}), words) for look, words in picture.keys]
    shown = [{"color": one.get("color", one.get("edgecolor", "none")), "ls": one.get("ls", "-")} for one, _ in looks]
    return [
        Line2D([], [], lw=look.get("lw", 1.8), label=words, **own)
        for (look, words), own in zip(looks, shown, strict=True)
    ]


def draw_all(picture: Picture) -> Figure:
    """Draw the figure of a picture, with a legend below."""
    with style.styled():
        made, ax = style.figure(_WIDTH, _WIDTH)
        draw(ax, picture)
        (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
        made.get_layout_engine().set(h_pad=_PAD)  # type: ignore[union-attr]
        made.set_figheight(_WIDTH * min(1.2, 0.85 * (high - low) / (right - left)) + _AROUND)
        made.legend(handles=handles(picture), loc="outside lower center", ncols=2)
        if picture.axes is None:
            # Words beside what is drawn take width, so that it needs less height.
            made.get_layout_engine().execute(made)  # type: ignore[union-attr]
            wide = _WIDTH * ax.get_position(original=True).width
            made.set_figheight(wide * (high - low) / (right - left) + (_AROUND if picture.heading else _BARE))
    return made
