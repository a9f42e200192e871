"""Figure 9: cobotic and conventional architecture with their power flows at an operating point."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.drivetrain.drive import needed
from infinivar.figures import style
from infinivar.paper.claims.claim import PaperMachine
from infinivar.paper.figures.steered_wheel import arrow
from infinivar.units import plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DRIVES = {"A": "cobotic", "B": "motor2-gear4"}
"""Drive of the shipped set for each letter of the paper."""

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
"""Parts in the direction of power flow, with the losses of each."""

_BOX, _HALF = 0.92, 0.82
"""Half the width and height of a part; parts are `_STEP` apart."""
_STEP = 3.4
_SCALE = 0.07
"""Height of a band per watt."""
_HEIGHTS = {"A": (-2.9, 2.15), "B": (-2.5, 0.95)}
_INK, _FILL = "#333333", "#DDE3EA"
_NAMED = 0.005
"""Smallest loss that gets a label. [W]"""


def data(machine: PaperMachine) -> dict[str, Any]:
    """Power after each part, and the losses in it.

    Returns
    -------
    dict
        force [N], speed [m/s]; architectures, by the paper's letter: title, power_in, power_out [W], stages: list of
        (part, {loss: W}, power that leaves it in W), efficiency [-].

    Source: faulring2006, Fig 9.
    """
    required = machine.requirement
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
    _part(ax, at, "battery")
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
    ax.set_aspect("equal")  # a watt has the same width in vertical and horizontal bands
    ax.set(xlim=(-1.4, 6 * _STEP + 1.3), ylim=_HEIGHTS[letter])
    ax.axis("off")
    where = f"{plain(numbers['force'], 3)} N, {plain(numbers['speed'], 3)} m/s"
    ax.set_title(f"{letter}. {shown['title']}: {100 * shown['efficiency']:.0f} % at {where}", loc="left")


def _flow(ax: Axes, at: float, power: float) -> None:
    """Draw the power band to the next part."""
    from matplotlib.patches import Rectangle

    half = 0.5 * _SCALE * power
    ax.add_patch(Rectangle((at + 0.4, -half), _STEP - 0.8, 2 * half, facecolor="#C7DCEC", edgecolor="none", zorder=0))
    ax.text(at + 0.5 * _STEP, 0, f"{power:.2f} W", ha="center", va="center", fontsize=8.5)


def _losses(ax: Axes, at: float, power: float, lost: Mapping[str, float]) -> None:
    """Draw the loss bands that leave a part downwards, each labelled in watts."""
    from matplotlib.patches import Rectangle

    total = sum(lost.values())
    left = at - 0.5 * _SCALE * total
    for loss, watts in lost.items():
        ax.add_patch(
            Rectangle(
                (left, -1.42), _SCALE * watts, 1.42, facecolor=style.LOSS_COLOURS[loss], edgecolor="none", zorder=0
            )
        )
        left += _SCALE * watts
    said = "\n".join(f"{loss} {watts:.2f} W" for loss, watts in lost.items() if watts >= _NAMED)
    ax.text(at, -1.5, said, ha="center", va="top", fontsize=7.5, linespacing=1.25)


def _part(ax: Axes, at: float, name: str) -> None:
    """Draw the box of a part with its icon."""
    _box(ax, at, 0.0, _BOX, _HALF)
    for icon in _ICONS[name](at, 0.27):
        ax.add_patch(icon)
    ax.text(at, -0.48, name, ha="center", va="center", fontsize=7.5, linespacing=0.95)


def _box(ax: Axes, x: float, y: float, half_width: float, half_height: float) -> None:
    from matplotlib.patches import FancyBboxPatch

    corner, size = (x - half_width, y - half_height), (2 * half_width, 2 * half_height)
    ax.add_patch(
        FancyBboxPatch(corner, *size, boxstyle="round,pad=0,rounding_size=0.12", facecolor="white", edgecolor=_INK)
    )


def _battery_icon(x: float, y: float) -> list[Any]:
    from matplotlib.patches import Rectangle

    return [
        Rectangle((x - 0.45, y - 0.22), 0.85, 0.44, facecolor="white", edgecolor=_INK),
        Rectangle((x + 0.4, y - 0.1), 0.09, 0.2, facecolor=_INK, edgecolor=_INK),
    ]


def _amplifier_icon(x: float, y: float) -> list[Any]:
    from matplotlib.patches import Polygon

    corners = [(x - 0.35, y - 0.33), (x - 0.35, y + 0.33), (x + 0.4, y)]
    return [Polygon(corners, facecolor="white", edgecolor=_INK)]


def _motor_icon(x: float, y: float) -> list[Any]:
    from matplotlib.patches import Rectangle

    return [
        Rectangle((x - 0.5, y - 0.3), 0.75, 0.6, facecolor=_FILL, edgecolor=_INK),
        Rectangle((x + 0.25, y - 0.05), 0.3, 0.1, facecolor=_INK, edgecolor=_INK),
    ]


def _gear_icon(x: float, y: float) -> list[Any]:
    from matplotlib.patches import Circle

    return [
        Circle((x - 0.38, y), 0.17, facecolor=_FILL, edgecolor=_INK),
        Circle((x + 0.15, y), 0.36, facecolor=_FILL, edgecolor=_INK),
    ]


def _cylinder_icon(x: float, y: float) -> list[Any]:
    from matplotlib.patches import Rectangle

    return [
        Rectangle((x - 0.6, y - 0.3), 1.2, 0.6, facecolor=_FILL, edgecolor=_INK),
        Rectangle(
            (x - 0.07, y - 0.22), 0.14, 0.44, angle=30, rotation_point="center", facecolor="white", edgecolor=_INK
        ),
    ]


def _link_icon(x: float, y: float) -> list[Any]:
    from matplotlib.patches import Rectangle

    return [
        Rectangle((x - 0.7, y - 0.08), 1.4, 0.16, facecolor=_FILL, edgecolor=_INK),
        *(
            Rectangle((x + side - 0.13, y - 0.24), 0.26, 0.48, facecolor="white", edgecolor=_INK)
            for side in (-0.4, 0.4)
        ),
    ]


def _pulley_icon(x: float, y: float) -> list[Any]:
    from matplotlib.patches import Circle, Rectangle

    return [
        Circle((x - 0.25, y), 0.33, facecolor=_FILL, edgecolor=_INK),
        Rectangle((x - 0.25, y + 0.32), 0.95, 0.02, facecolor=_INK, edgecolor=_INK),
    ]


def _load_icon(x: float, y: float) -> list[Any]:
    from matplotlib.patches import Rectangle

    return [Rectangle((x - 0.38, y - 0.28), 0.76, 0.56, facecolor="#8A94A1", edgecolor=_INK)]


_ICONS: dict[str, Callable[[float, float], list[Any]]] = {
    "battery": _battery_icon,
    "amplifier": _amplifier_icon,
    "Motor 1": _motor_icon,
    "Motor 2": _motor_icon,
    "gearhead": _gear_icon,
    "cylinder\nand wheel": _cylinder_icon,
    "link": _link_icon,
    "pulley\nand cable": _pulley_icon,
    "load": _load_icon,
}


def _steering(ax: Axes, link: float) -> None:
    """Draw the steering motor above the wheel, with its supply from the battery."""
    wheel, motor, height, half = link - _STEP, link - 2 * _STEP, 1.6, _BOX + 0.25
    ax.plot([0, 0, motor - half], [_HALF, height, height], color=_INK, lw=1.0, ls=(0, (4, 2)))
    ax.text(0.5 * (motor - half), height + 0.06, "steering: 0 W in steady motion", ha="center", va="bottom", fontsize=8)
    _box(ax, motor, height, half, 0.34)
    ax.text(motor, height, "steering motor", ha="center", va="center", fontsize=8)
    ax.plot([motor + half, wheel, wheel], [height, height, _HALF + 0.3], color=_INK, lw=1.0, ls=(0, (4, 2)))
    arrow(ax, (wheel, _HALF + 0.3), (wheel, _HALF), _INK, lw=1.0)
    ax.text(wheel + 0.14, 0.5 * (height + _HALF), "angle $\\phi$", fontsize=8, va="center")


def draw_all(machine: PaperMachine) -> Figure:
    """Draw the figure."""
    numbers = data(machine)
    with style.styled():
        made, axes = style.figure(10.4, 4.2, 2, 1, gridspec_kw={"height_ratios": [5.05, 3.45]})
        for ax, letter in zip(axes, numbers["architectures"], strict=True):
            draw(ax, numbers, letter)
    return made
