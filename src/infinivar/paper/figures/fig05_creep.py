"""Figure 5: lateral creep by the linear law and by exact rolling theory."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.contact import creep, exact_tables
from infinivar.figures import style
from infinivar.paper.claims.claim import Machine

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TITLE = "Lateral creep"

CAPTION = (
    "Lateral force against creepage, both scaled so that the linear law is a straight line up to slip. Exact rolling theory "
    "deviates early: at 60-70 % of the slip force (shaded) it predicts 1.3 to 1.4 times the creepage of the linear law."
)


def data(machine: Machine) -> dict[str, Any]:
    """Scaled creepage ``C u/(mu P |v|)`` and force ratio ``fu/(mu P)`` by the linear law and by exact theory."""
    creepage = np.linspace(0.0, 3.0, 301)
    curves = {
        float(curve["a_over_b"]): (3.0 * curve["scaled_creepage"], curve["force_ratio"])
        for curve in exact_tables.lateral_creep()
    }
    return {"linear": (creepage, creep.linear_force(creepage)), "exact": curves}


def draw(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw the curves."""
    ax.axhspan(0.6, 0.7, color="#eeeeee")
    for colour, (a_over_b, curve) in zip(style.COLOURS, numbers["exact"].items(), strict=False):
        ax.plot(*curve, "o-", ms=3, color=colour, label=f"exact rolling theory, a/b = {a_over_b:g}")
    ax.plot(*numbers["linear"], color="black", ls="--", label="linear law, then slip (Eq 7)")
    ax.text(2.95, 0.65, "60-70 % of slip force", ha="right", va="center", fontsize=8)
    ax.set_xlim(0.0, 3.0)
    ax.set_ylim(0.0, 1.08)
    ax.set_xlabel(r"scaled creepage  $C_{22}Gab\,u\,/\,(\mu P\,|r\dot\theta|)$  [-]")
    ax.set_ylabel(r"lateral force over slip force  $f_u/(\mu P)$  [-]")
    ax.legend(loc="lower right")


def draw_all(machine: Machine) -> Figure:
    """Draw the figure."""
    with style.styled():
        made, ax = style.figure(7.2, 4.0)
        draw(ax, data(machine))
    return made
