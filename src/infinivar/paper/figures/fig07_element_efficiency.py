"""Figure 7: efficiency of the rolling-contact element by reduction ratio, at five loads, by Eq 16 and by Eq 17."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.figures import style
from infinivar.paper.claims.claim import Machine, efficiency_by

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LOADS = (0.15, 0.35, 0.5, 0.8, 0.95)
"""Link force over slip force. The paper names 0.15, 0.5 and 0.95 of its five loads."""

PRINTED = ((100.0, 0.50), (8.0, 0.94), (1.0, 0.50))
"""Points that the text gives at half load."""

CAPTION = (
    "Efficiency of the element by reduction ratio. Solid: linear creep (Eq 16). Dashed: with the paper's correction above "
    "70 % of the slip force (Eq 17), which holds the 0.95 curve below a third. Crosses: the three points that the text "
    "prints for half load; 50 % at 1:1 does not follow from the equations. Curves end at the slip force; the link speed that "
    "Eq 17 leaves means a creepage beyond full slip soon after 70 % of it, where the program's limits name slip."
)


def data(machine: Machine, count: int = 1201) -> dict[str, Any]:
    """Ratios, and efficiency (nan beyond the slip force) by load for Eq 16 ("linear") and Eq 17 ("faulring")."""
    ratio = np.geomspace(0.3, 1000.0, count)
    curves = {
        law: {load: efficiency_by(replace(machine.element, creep_law=law), load, ratio) for load in LOADS}
        for law in ("linear", "faulring")
    }
    return {"ratio": ratio, **curves}


def draw(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw the curves and the printed points."""
    ratio = numbers["ratio"]
    for colour, load in zip(style.COLOURS, LOADS, strict=False):
        ax.semilogx(ratio, numbers["linear"][load], color=colour, label=f"$f_l/(\\mu P)$ = {load:g}")
        ax.semilogx(ratio, numbers["faulring"][load], color=colour, ls="--", lw=1.1)
    ax.plot(*zip(*PRINTED, strict=True), "kx", ms=7, mew=1.6, label="printed for 0.5")
    ax.plot([], [], color="grey", label="Eq 16 (solid)")
    ax.plot([], [], color="grey", ls="--", lw=1.1, label="Eq 17 (dashed)")
    ratio_axis(ax)
    ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))


def ratio_axis(ax: Axes) -> None:
    """Shared by the figures with reduction ratios."""
    ax.set_xlim(0.3, 1000.0)
    ax.set_xticks([1, 10, 100, 1000], ["1:1", "10:1", "100:1", "1000:1"])
    ax.set_ylim(0.0, 1.0)
    ax.set_xlabel(r"reduction ratio $1/|\tan\phi|$, cylinder surface speed : link speed")
    ax.set_ylabel("efficiency [-]")


def draw_all(machine: Machine) -> Figure:
    """The figure."""
    with style.styled():
        made, ax = style.figure(7.2, 3.8)
        draw(ax, data(machine))
    return made
