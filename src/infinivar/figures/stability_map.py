"""Coupled stability of a display and an arm over two parameters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.displays.kinds import TITLES
from infinivar.displays.stability import StabilityMap
from infinivar.figures import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_WIDE = 50.0
"""Ratio of the ends of an axis from which it is logarithmic."""


def data(found: StabilityMap) -> dict[str, Any]:
    """Axes with names, growth per sample (Y, X), and the refined boundary as (n, 2) points; SI."""
    first, second = (
        f"{name.replace('_', ' ')} [{unit}]"
        for name, unit in zip((found.first, found.second), found.units, strict=True)
    )
    return {
        "x": found.x,
        "y": found.y,
        "growth": found.growth,
        "boundary": found.boundary,
        "labels": (first, second),
        "title": f"{TITLES[found.display]}, {found.held}",
    }


def draw(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw where the loop is stable, and the refined boundary."""
    x, y, growth = numbers["x"], numbers["y"], numbers["growth"]
    ax.set_facecolor("#f3ddd2")
    ax.contourf(x, y, np.log(growth), levels=[-np.inf, 0.0], colors=["#cfe5f2"])
    points = numbers["boundary"]
    ax.plot(points[:, 0], points[:, 1], ".", ms=3, color=style.COLOURS[0])
    for axis, values in (("x", x), ("y", y)):
        if values[0] > 0.0 and values[-1] > _WIDE * values[0]:
            getattr(ax, f"set_{axis}scale")("log")
    for words, colour, where in (
        ("stable", style.COLOURS[0], growth <= 1.0),
        ("unstable", style.COLOURS[1], growth > 1.0),
    ):
        if np.any(where):
            rows, columns = np.nonzero(where)
            place = np.argmin(np.abs(rows - np.median(rows)) + np.abs(columns - np.median(columns)))
            ax.text(x[columns[place]], y[rows[place]], words, color=colour, ha="center", va="center", fontsize=9)
    ax.set_xlim(x[0], x[-1])
    ax.set_ylim(y[0], y[-1])
    ax.set_xlabel(numbers["labels"][0])
    ax.set_ylabel(numbers["labels"][1])


def draw_all(found: StabilityMap) -> Figure:
    """Draw the figure."""
    with style.styled():
        made, ax = style.figure(4.6, 3.6)
        numbers = data(found)
        draw(ax, numbers)
        ax.set_title(numbers["title"])
    return made
