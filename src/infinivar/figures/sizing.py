"""Designs of a search in the plane of mass and power, with the front."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.errors import InputError
from infinivar.figures import style
from infinivar.sizing.design import SizedDrive
from infinivar.sizing.result import Sizing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import XAxis, YAxis
    from matplotlib.figure import Figure

_FAR = 8.0
"""Ratio of the largest to the least value above which an axis is logarithmic."""
_NAMED = 6
"""Most designs of the front that are named."""


def data(sizing: Sizing) -> dict[str, Any]:
    """Mass of the designs, and their mean power; their margin where there is no motion.

    Returns
    -------
    dict
        ``designs`` and ``front`` (n, 2), ``cloud`` (m, 2) of the feasible candidates evaluated, ``label`` of the second column.
    """
    moving = bool(sizing.study.duty)

    def places(found: tuple[SizedDrive, ...]) -> np.ndarray:
        return np.array([(one.mass, one.power if moving else one.margin) for one in found]).reshape(-1, 2)

    clouds = [search.cloud for search in sizing.searches.values()] if moving else []
    return {
        "designs": places(sizing.designs),
        "front": places(sizing.front),
        "cloud": np.concatenate([np.empty((0, 2)), *clouds]),
        "label": "mean power from the supply [W]" if moving else "margin of the tightest limit",
    }


def draw(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw the designs, and the front as a stair: no candidate is below and to the left of it."""
    cloud, designs, front = (numbers[name] for name in ("cloud", "designs", "front"))
    grams = 1e3
    if len(cloud):
        ax.plot(grams * cloud[:, 0], cloud[:, 1], ".", color="#b8c0ca", ms=4, label="feasible candidates evaluated")
    ax.plot(grams * designs[:, 0], designs[:, 1], "o", mfc="white", color=style.COLOURS[0], ms=5, label="best designs")
    if len(front):
        order = np.argsort(front[:, 0])
        ax.step(grams * front[order, 0], front[order, 1], where="post", color=style.COLOURS[1], lw=1.3)
        ax.plot(grams * front[:, 0], front[:, 1], "s", color=style.COLOURS[1], ms=5, label="front")
        for number in np.unique(front, axis=0, return_index=True)[1][:_NAMED]:  # equal designs have one name
            mass, power = front[number]
            ax.annotate(f"front {number + 1}", (grams * mass, power), (6, 5), textcoords="offset points", fontsize=8)
    ax.set(xlabel="mass of motor and gearhead [g]", ylabel=numbers["label"])
    for axis, column in ((ax.xaxis, 0), (ax.yaxis, 1)):
        _wide(axis, np.concatenate([cloud, designs, front])[:, column] * (grams if column == 0 else 1.0))
    ax.legend(loc="upper right")


def _wide(axis: XAxis | YAxis, values: np.ndarray) -> None:
    """Make an axis logarithmic where its values differ by much, with plain numbers."""
    known = values[np.isfinite(values) & (values > 0.0)]
    if known.size and known.max() > _FAR * known.min():
        from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

        {"x": axis.axes.set_xscale, "y": axis.axes.set_yscale}[axis.axis_name]("log")
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.set_major_formatter(StrMethodFormatter("{x:g}"))
        axis.set_minor_formatter(NullFormatter())


def draw_all(sizing: Sizing) -> Figure:
    """Draw the figure.

    Raises
    ------
    InputError
        If there is no feasible design.
    """
    if not sizing.designs:
        raise InputError("there is no feasible design to draw")
    with style.styled():
        made, axes = style.figure(7.2, 4.4, squeeze=False)
        draw(axes[0, 0], data(sizing))
    return made
