"""Best speeds of a common cylinder: nominal, one for all motions, one for each, and over a cycle, with the mean powers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.analysis.common_speed import CommonSpeed
from infinivar.figures import style
from infinivar.limits import Limit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_NOMINAL, _FIXED, _EACH, _SCHEDULED = style.COLOURS[7], style.COLOURS[0], style.COLOURS[2], style.COLOURS[1]


def data(found: CommonSpeed) -> dict[str, Any]:
    """Speeds [rad/s] over the motions or instants, and mean powers [W], by what they are; without those that do not exist."""
    speeds = {
        "nominal": np.full(len(found.by_motion), float(found.nominal)),
        "best constant": np.full(len(found.by_motion), float(found.fixed)),
        "best of each motion": np.asarray(found.by_motion),
    }
    powers = {
        "nominal": float(found.nominal_power),
        "best constant": float(found.fixed_power),
        "best of each motion": float(found.by_motion_power),
    }
    if found.scheduled is not None:
        speeds["over the cycle"] = np.asarray(found.scheduled.value)
        powers["over the cycle"] = float(found.scheduled_power)
    return {
        "speeds": {name: values for name, values in speeds.items() if np.any(np.isfinite(values))},
        "powers": powers,
        "limit": Limit(int(found.limit)),
    }


def draw(above: Axes, below: Axes, numbers: dict[str, Any]) -> None:
    """Draw the speeds, and the powers as bars."""
    colours = dict(zip(numbers["powers"], (_NOMINAL, _FIXED, _EACH, _SCHEDULED), strict=False))
    for name, values in numbers["speeds"].items():
        place = np.arange(1, len(values) + 1)
        marks: dict[str, Any] = {"ls": "", "marker": "o", "ms": 3} if name == "best of each motion" else {"lw": 1.6}
        if len(values) == 1:
            marks = {"ls": "", "marker": "o" if name == "best of each motion" else "_", "ms": 9}
        above.plot(place, values, color=colours[name], label=name, **marks)
    above.set_xlabel("motion" if "over the cycle" not in numbers["powers"] else "instant of the cycle")
    above.set_ylabel("cylinder speed [rad/s]")
    style.name_beside(above, fontsize=8)
    names = list(numbers["powers"])
    values = np.array(list(numbers["powers"].values()))
    below.barh(names, np.nan_to_num(values), color=[colours[name] for name in names], height=0.6)
    for place, value in enumerate(values):
        words = f" {value:.3g} W" if np.isfinite(value) else f" infeasible: {numbers['limit'].words}".rstrip(": ")
        if not np.isfinite(value) and numbers["limit"] is Limit.OK:
            words = " infeasible"
        below.text(float(np.nan_to_num(value)), place, words, va="center", fontsize=8)
    below.invert_yaxis()
    below.margins(x=0.2)
    below.set_xlabel("mean power from the supply [W]")


def draw_all(found: CommonSpeed) -> Figure:
    """Draw the figure."""
    with style.styled():
        made, (above, below) = style.figure(6.8, 4.4, 2, 1, height_ratios=[1.4, 1.0])
        draw(above, below, data(found))
    return made
