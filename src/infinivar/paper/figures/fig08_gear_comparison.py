"""Figure 8: the rolling-contact element against gears on the market."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.figures import gear_points, style
from infinivar.paper.claims.claim import Machine, at_ratio
from infinivar.paper.figures.fig07_element_efficiency import ratio_axis

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LOADS = (0.15, 0.5, 0.95)

TITLE = "The element against gears"

CAPTION = (
    "Efficiency of the element (Eq 16) at three loads, and of catalogue gears, each at its rated load. Filled: read from "
    "catalogue pages; half filled: models and tables by others; hollow: second-hand values, mostly of worm and harmonic "
    "drives. Gears of unknown ratio are left out."
)


def data(machine: Machine) -> dict[str, Any]:
    """Element curves by load, and gears by type as (ratio, efficiency, confidence)."""
    ratio = np.geomspace(0.3, 1000.0, 801)
    return {
        "ratio": ratio,
        "element": {load: at_ratio(machine.element, load, ratio).efficiency for load in LOADS},
        "gears": gear_points.gears(),
    }


def draw(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw the curves and the gears; the lower the confidence, the paler and smaller the marker."""
    for load, width in zip(LOADS, (1.0, 1.7, 2.4), strict=True):
        label = f"element, $f_l/(\\mu P)$ = {load:g}"
        ax.semilogx(numbers["ratio"], numbers["element"][load], color="black", lw=width, label=label)
    gear_points.draw(ax, numbers["gears"])
    ratio_axis(ax)
    ax.set_xlim(0.3, 2000.0)
    ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))


def draw_all(machine: Machine) -> Figure:
    """Draw the figure."""
    with style.styled():
        made, ax = style.figure(7.4, 4.0)
        draw(ax, data(machine))
    return made
