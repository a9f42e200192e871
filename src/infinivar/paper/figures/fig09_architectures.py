"""Figure 9: the cobotic and the conventional architecture, with the power through each at an operating point."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.drivetrain.drive import needed
from infinivar.figures import style
from infinivar.paper.claims.claim import Machine
from infinivar.units import plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TITLE = "Cobotic and conventional architecture"

CAPTION = (
    "Both architectures of the paper with the power through them where the required region has both its maximum force and its "
    "maximum power. The width of a band is its power; what leaves downwards is lost, and parts without such a band lose "
    "nothing here. In steady motion the steering motor stands still and takes no power; Figure 17 counts what steering takes "
    "when the load is shaken. Figures 15 and 16 have all other points."
)

DRIVES = {"A": "cobotic", "B": "motor2-gear4"}
"""The paper's letters, and the drives of the set that stand for them."""

STAGES = {
    "A": {
        "amplifier": ("amplifier",),
        "Motor 1": ("winding", "motor friction"),
        "gearhead": ("gearhead",),
        "cylinder\nand wheel": ("creep", "rolling", "bearing"),
        "link": ("guideway",),
    },
    "B": {
        "amplifier": ("amplifier",),
        "Motor 2": ("winding", "motor friction"),
        "gearhead": ("gearhead",),
        "pulley\nand cable": ("pulley", "guideway"),
    },
}
"""Parts in the order of the flow of power, with the losses of each."""

_BOX = 0.92
"""Half the width of a part, where parts are `_STEP` apart."""
_STEP = 3.4
_SCALE = 0.055
"""Height of a band for a watt."""
_HEIGHTS = {"A": (-2.5, 1.8), "B": (-2.2, 0.8)}
_NAMED = 0.005
"""Losses below are not named. [W]"""


def data(machine: Machine) -> dict[str, Any]:
    """Power after every part, and what is lost in it.

    Returns
    -------
    dict
        force [N], speed [m/s]; architectures, by the paper's letter: title, power_in, power_out [W], stages: list of
        (part, {loss: W}, power that leaves it in W), efficiency [-].
    """
    required = machine.study.requirement
    force, power = needed(required.force, "requirement.force"), machine.power
    speed = power / force
    architectures = {}
    for letter, name in DRIVES.items():
        point = machine.moving(name).operate(speed=np.float64(speed), force=np.float64(force))
        left, stages = float(point.power_in), []
        for part, losses in STAGES[letter].items():
            lost = {loss: float(point.losses[loss]) for loss in losses}
            left -= sum(lost.values())
            stages.append((part, lost, left))
        architectures[letter] = {
            "title": machine.study.titles[name],
            "power_in": float(point.power_in),
            "power_out": float(point.power_out),
            "stages": stages,
            "efficiency": float(point.efficiency),
        }
    return {"force": force, "speed": speed, "architectures": architectures}


def draw(ax: Axes, numbers: Mapping[str, Any], letter: str) -> None:
    """Draw one architecture from left to right: battery, parts, load."""
    shown = numbers["architectures"][letter]
    at, power = 0.0, shown["power_in"]
    _battery(ax, at)
    for part, lost, left in shown["stages"]:
        _flow(ax, at, power)
        at += _STEP
        _losses(ax, at, power, lost)
        _part(ax, at, part)
        power = left
    _flow(ax, at, power)
    _part(ax, at + _STEP, "load")
    if letter == "A":
        _steering(ax, at)
    ax.set(xlim=(-1.4, 6 * _STEP + 1.3), ylim=_HEIGHTS[letter])
    ax.axis("off")
    where = f"{plain(numbers['force'], 3)} N, {plain(numbers['speed'], 3)} m/s"
    ax.set_title(f"{letter}. {shown['title']}: {100 * shown['efficiency']:.0f} % at {where}", loc="left")


def _flow(ax: Axes, at: float, power: float) -> None:
    """Band of power to the next part."""
    from matplotlib.patches import Rectangle

    half = 0.5 * _SCALE * power
    ax.add_patch(Rectangle((at + 0.4, -half), _STEP - 0.8, 2 * half, facecolor="#C7DCEC", edgecolor="none", zorder=0))
    ax.text(at + 0.5 * _STEP, 0, f"{power:.2f} W", ha="center", va="center", fontsize=8.5)


def _losses(ax: Axes, at: float, power: float, lost: Mapping[str, float]) -> None:
    """Bands that leave a part downwards, each with its watts."""
    from matplotlib.patches import Rectangle

    total = sum(lost.values())
    left = at - 0.5 * _SCALE * total
    for loss, watts in lost.items():
        ax.add_patch(
            Rectangle(
                (left, -1.25), _SCALE * watts, 1.25, facecolor=style.LOSS_COLOURS[loss], edgecolor="none", zorder=0
            )
        )
        left += _SCALE * watts
    said = "\n".join(f"{loss} {watts:.2f} W" for loss, watts in lost.items() if watts >= _NAMED)
    ax.text(at, -1.33, said, ha="center", va="top", fontsize=7.5, linespacing=1.25)


def _part(ax: Axes, at: float, name: str) -> None:
    from matplotlib.patches import FancyBboxPatch

    ax.add_patch(
        FancyBboxPatch(
            (at - _BOX, -0.62),
            2 * _BOX,
            1.24,
            boxstyle="round,pad=0,rounding_size=0.12",
            facecolor="white",
            edgecolor="#333333",
        )
    )
    ax.text(at, 0, name, ha="center", va="center", fontsize=8.5)


def _battery(ax: Axes, at: float) -> None:
    from matplotlib.patches import Rectangle

    ax.add_patch(Rectangle((at - _BOX, -0.62), 2 * _BOX - 0.15, 1.24, facecolor="white", edgecolor="#333333"))
    ax.add_patch(Rectangle((at + _BOX - 0.15, -0.25), 0.15, 0.5, facecolor="#333333", edgecolor="#333333"))
    ax.text(at - 0.08, 0, "battery", ha="center", va="center", fontsize=8.5)


def _steering(ax: Axes, link: float) -> None:
    """The steering motor above the wheel, which it turns, fed by the battery."""
    wheel, motor = link - _STEP, link - 2 * _STEP
    height = 1.35
    ax.plot([0, 0, motor - _BOX - 0.25], [0.62, height, height], color="#333333", lw=1.0, ls=(0, (4, 2)))
    ax.text(0.5 * (motor - _BOX), height + 0.06, "steering: 0 W in steady motion", ha="center", va="bottom", fontsize=8)
    from matplotlib.patches import FancyBboxPatch

    ax.add_patch(
        FancyBboxPatch(
            (motor - _BOX - 0.25, height - 0.36),
            2 * _BOX + 0.5,
            0.72,
            boxstyle="round,pad=0,rounding_size=0.12",
            facecolor="white",
            edgecolor="#333333",
        )
    )
    ax.text(motor, height, "steering motor", ha="center", va="center", fontsize=8.5)
    ax.annotate(
        "",
        xy=(wheel, 0.62),
        xytext=(motor + _BOX + 0.25, height),
        arrowprops={
            "arrowstyle": "-|>",
            "connectionstyle": "angle,angleA=0,angleB=90,rad=3",
            "color": "#333333",
            "lw": 1.0,
            "ls": (0, (4, 2)),
            "shrinkA": 0,
            "shrinkB": 0,
        },
    )
    ax.text(wheel + 0.12, height - 0.28, "angle $\\phi$", fontsize=8, va="center")


def draw_all(machine: Machine) -> Figure:
    """The figure."""
    numbers = data(machine)
    with style.styled():
        made, axes = style.figure(9.6, 4.1, 2, 1, gridspec_kw={"height_ratios": [4.3, 3.0]})
        for ax, letter in zip(axes, numbers["architectures"], strict=True):
            draw(ax, numbers, letter)
    return made
