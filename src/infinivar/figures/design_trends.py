"""Efficiency of the element over preload, friction, wheel radius, crown radius and material."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.analysis.contact_sheet import HALF
from infinivar.analysis.design_trends import SWEPT, Duty, Trend, sweep
from infinivar.figures import style
from infinivar.limits import Limit
from infinivar.study.catalogue import materials
from infinivar.units import plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from infinivar.drivetrain.cobotic import CoboticDrive

RATIOS = (2.0, 8.0, 30.0)

PANELS = {
    "preload": ("preload P [N]", 1.0, 0.5, 2.0),
    "friction": ("friction coefficient $\\mu$ [-], preload as $1/\\mu$", 1.0, 0.4, 4.0),
    "wheel_radius": ("rolling radius of the wheel r [mm]", 1e3, 0.3, 4.0),
    "crown_radius": ("crown radius of the wheel [mm]", 1e3, 0.25, 8.0),
}
"""Axis label, scale of its unit, and range in multiples of the present value."""

CAPTION = (
    "Efficiency of the element at a fixed link force (half the present slip force) and three reduction ratios as one "
    "design parameter varies. Dashed grey: present design. Shaded: the wheel slips or the contact yields. "
    "Materials: wheel and cylinder of the same material; pale bars are over-stressed; ceramics have no yield strength."
)


def data(drive: CoboticDrive, count: int = 31) -> dict[str, Any]:
    """Trends by parameter and ratio, in SI, the present values, and the link force [N]."""
    element = drive.transmission
    force = HALF * float(element.groups(drive.cylinder_speed).slip_force)
    duties = [Duty(cylinder_speed=drive.cylinder_speed, link_force=force, ratio=ratio) for ratio in RATIOS]
    trends = {}
    for name, (_, _, low, high) in PANELS.items():
        values = np.geomspace(low, high, count) * SWEPT[name][1](element)
        trends[name] = dict(zip(RATIOS, sweep(element, name, values, duties), strict=True))
    (material,) = sweep(element, "material", list(materials()), duties[1:2])
    return {
        "trends": trends,
        "present": {name: SWEPT[name][1](element) for name in PANELS},
        "material": material,
        "force": force,
    }


def draw(ax: Axes, name: str, by_ratio: Mapping[float, Trend], present: float) -> None:
    """Draw the trend of one parameter."""
    label, scale, *_ = PANELS[name]
    ax.set_xscale("log")
    for (ratio, trend), colour in zip(by_ratio.items(), style.COLOURS, strict=False):
        ax.plot(scale * trend.values, trend.efficiency, color=colour, label=f"{ratio:g}:1")
    some = next(iter(by_ratio.values()))
    ax.axvline(scale * present, color="grey", lw=0.8, ls="--")
    ax.set_xlim(scale * some.values[0], scale * some.values[-1])
    ax.set_ylim(0.5, 1.0)
    style.name_limits(ax, scale * some.values, some.limit, "bottom")
    style.plain_log_ticks(ax)
    ax.set_xlabel(label)
    ax.set_ylabel("efficiency of the element [-]")


def draw_materials(ax: Axes, trend: Trend) -> None:
    """Draw the losses of each material as bars."""
    names = [str(name) for name in trend.values]
    left = np.zeros(len(names))
    for name in ("creep", "rolling", "bearing"):
        label = {"rolling": "hysteresis", "bearing": "axle bearings"}.get(name, name)
        bars = ax.barh(names, trend.losses[name], left=left, color=style.loss_colour(name), label=label)
        for bar, limit in zip(bars, trend.limit, strict=True):
            bar.set_alpha(1.0 if limit == Limit.OK else 0.35)
        left = left + trend.losses[name]
    for row, limit in enumerate(trend.limit):
        if limit != Limit.OK:
            ax.text(left[row], row, f" {limit.words}", va="center", fontsize=8)
    ax.set_xlim(0.0, 1.45 * float(np.max(np.nan_to_num(left))) or 1.0)
    ax.set_ylim(len(names) - 0.5, -0.5)
    ax.set_xlabel(f"loss of the element at {RATIOS[1]:g}:1 [W]")
    ax.legend(loc="upper center", bbox_to_anchor=(0.4, -0.22), ncols=3)


def draw_all(drive: CoboticDrive) -> Figure:
    """Draw all four parameters and the materials."""
    numbers = data(drive)
    with style.styled():
        made, axes = style.figure(11.5, 6.6, 2, 3)
        for ax, (name, by_ratio) in zip(axes.flat, numbers["trends"].items(), strict=False):
            draw(ax, name, by_ratio, numbers["present"][name])
        draw_materials(axes[1, 1], numbers["material"])
        axes[1, 2].axis("off")
        handles, labels = axes[0, 0].get_legend_handles_labels()
        title = f"reduction ratio,\nlink force {plain(numbers['force'], 3)} N"
        axes[1, 2].legend(handles, labels, loc="center left", title=title)
    return made
