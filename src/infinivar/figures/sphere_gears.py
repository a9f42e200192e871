"""A sphere between rollers against gears: efficiency over the speed ratio at constant output torque."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.analysis.sphere_efficiency import efficiency_by_ratio
from infinivar.figures import gear_points, style
from infinivar.transmission.spherical import SphericalIVT

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LOADS = (0.15, 0.5, 0.95)
"""Force of the output drive roller over mu P. [-]"""

_LINES = ("solid", (0, (5, 2)), (0, (1, 1.5)))


def data(transmissions: Mapping[str, SphericalIVT], sphere_speed: float) -> dict[str, Any]:
    """Efficiency by title and load over the ratio, and gears by type as (ratio, efficiency, confidence)."""
    ratio = np.geomspace(0.3, 1000.0, 161)
    return {
        "ratio": ratio,
        "efficiency": {
            title: {load: efficiency_by_ratio(one, ratio, load, sphere_speed=sphere_speed) for load in LOADS}
            for title, one in transmissions.items()
        },
        "gears": gear_points.gears(),
    }


def draw(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw the curves and the gears."""
    for (title, curves), line in zip(numbers["efficiency"].items(), _LINES, strict=False):
        for (load, curve), width in zip(curves.items(), (1.0, 1.7, 2.4), strict=True):
            label = rf"{title}, $F/(\mu P)$ = {load:g}"
            ax.semilogx(numbers["ratio"], curve, color="black", lw=width, ls=line, label=label)
    gear_points.draw(ax, numbers["gears"])
    ax.set_xlim(0.3, 2000.0)
    ax.set_xticks([1, 10, 100, 1000], ["1:1", "10:1", "100:1", "1000:1"])
    ax.set_ylim(0.0, 1.0)
    ax.set_xlabel("reduction ratio, speed of shaft 1 : shaft 2")
    ax.set_ylabel("efficiency [-]")
    style.name_beside(ax, fontsize=8)


def draw_all(transmissions: Mapping[str, SphericalIVT], sphere_speed: float) -> Figure:
    """Draw the figure."""
    with style.styled():
        made, ax = style.figure(7.4, 4.4)
        draw(ax, data(transmissions, sphere_speed))
    return made
