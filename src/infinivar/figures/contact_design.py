"""The contact of a wheel: patch, creep curve of each law, losses over preload."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.analysis.contact_sheet import HALF, ContactSheet
from infinivar.analysis.design_trends import Duty, sweep
from infinivar.contact import creep
from infinivar.figures import style
from infinivar.units import plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

RATIO = 8.0
"""Reduction ratio at which losses are drawn."""


def data(sheet: ContactSheet, count: int = 41) -> dict[str, Any]:
    """Patch by steering angle [mm, rad], force ratio by law over creepage [‰], losses [W] over preload [N]."""
    drive = sheet.drive
    element, geometry = drive.transmission, drive.transmission.geometry
    assert geometry is not None
    groups = element.groups(drive.cylinder_speed)
    patches = {}
    for degrees in (0, 45, 90):
        turned = geometry.press(
            wheel_radius=element.wheel_radius,
            cylinder_radius=element.cylinder_radius,
            preload=element.preload,
            steering_angle=math.radians(degrees),
        )
        patches[degrees] = (1e3 * turned.patch.a, 1e3 * turned.patch.b, turned.rotation)
    scaled = np.linspace(0.0, 4.0, 301)
    laws = {name: groups.formulas(law).force(scaled) for name, law in creep.LAWS.items() if law.flow_factor is None}
    duty = Duty(cylinder_speed=drive.cylinder_speed, link_force=HALF * float(groups.slip_force), ratio=RATIO)
    preload = np.linspace(0.45, 2.0, count) * element.preload
    return {
        "patches": patches,
        "peak_pressure": element.contact.patch.peak_pressure,  # type: ignore[union-attr]
        "creepage": 1e3 * scaled / groups.creep_group,
        "laws": laws,
        "law": element.creep_law.name,
        "preload": element.preload,
        "duty": duty,
        "trend": sweep(element, "preload", preload, [duty])[0],
    }


def draw_patch(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw the outline of the patch, seen from above, at three steering angles."""
    around = np.linspace(0.0, 2.0 * math.pi, 181)
    for (degrees, (a, b, rotation)), colour in zip(numbers["patches"].items(), style.COLOURS, strict=False):
        x, y = a * np.cos(around), b * np.sin(around)
        x, y = x * math.cos(rotation) - y * math.sin(rotation), x * math.sin(rotation) + y * math.cos(rotation)
        ax.plot(x, y, color=colour, ls=("-", "--", ":")[degrees // 45], label=f"steered {degrees}°")
    reach = 1.25 * max(max(a, b) for a, b, _ in numbers["patches"].values())
    ax.annotate("rolling", (reach, 0.0), (0.35 * reach, 0.0), arrowprops={"arrowstyle": "->"}, va="center", fontsize=8)
    ax.set_xlim(-reach, reach)
    ax.set_ylim(-reach, reach)
    ax.set_aspect("equal")
    ax.set_xlabel("along rolling [mm]")
    ax.set_ylabel("lateral [mm]")
    ax.set_title(f"patch, peak pressure {numbers['peak_pressure'] / 1e9:.2f} GPa")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=3)


def draw_creep(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw the force ratio over creepage for each law; the law in use is bold."""
    for (name, force), colour in zip(numbers["laws"].items(), style.COLOURS, strict=False):
        bold = name == numbers["law"]
        label = f"{name}{' (in use)' if bold else ''}"
        ax.plot(numbers["creepage"], force, color=colour, lw=2.4 if bold else 1.2, label=label)
    ax.set_xlim(0.0, numbers["creepage"][-1])
    ax.set_ylim(0.0, 1.08)
    ax.set_xlabel(r"creepage $u/|v|$ [‰]")
    ax.set_ylabel(r"lateral force over slip force $f_u/(\mu P)$ [-]")
    ax.set_title("creep by law")
    ax.legend(loc="lower right")


def draw_losses(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw the losses over preload at a fixed link force, with the slipping and over-stressed ranges and the present preload."""
    trend, duty = numbers["trend"], numbers["duty"]
    for name in ("creep", "rolling", "bearing"):
        label = {"rolling": "hysteresis", "bearing": "axle bearings"}.get(name, name)
        ax.plot(trend.values, trend.losses[name], color=style.loss_colour(name), label=label)
    total = sum(trend.losses.values())
    ax.plot(trend.values, total, color="black", label="total")
    top = 1.25 * float(np.max(np.nan_to_num(total))) or 1.0  # the wheel may slip at every preload
    style.name_limits(ax, trend.values, trend.limit, "top")
    ax.axvline(numbers["preload"], color="grey", lw=0.8, ls="--")
    ax.text(numbers["preload"], 0.98 * top, " present", va="top", fontsize=8, color="grey")
    ax.set_xlim(trend.values[0], trend.values[-1])
    ax.set_ylim(0.0, top)
    ax.set_xlabel("preload [N]")
    ax.set_ylabel("loss of the element [W]")
    ax.set_title(f"losses at {plain(duty.link_force, 3)} N and {duty.ratio:g}:1")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=4)


def draw_all(sheet: ContactSheet) -> Figure:
    """Draw all three panels."""
    with style.styled():
        made, axes = style.figure(12.0, 4.2, 1, 3)
        numbers = data(sheet)
        draw_patch(axes[0], numbers)
        draw_creep(axes[1], numbers)
        draw_losses(axes[2], numbers)
        made.suptitle(sheet.title, parse_math=False)
    return made
