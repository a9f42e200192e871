"""Figure 15: continuous operating ranges of the conventional drives, with the efficiency of the Motor 2 drive."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.figures import operating_map, style
from infinivar.paper.claims.claim import Machine

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TITLE = "Operating ranges of the conventional drives"

CAPTION = (
    "Continuous operating range of each conventional drive. Colour and white lines: efficiency of Motor 2 with its gear; "
    "outlines: Motor 1 with three other gears, limited on the right by continuous torque and at the top by supply voltage. "
    "Dashed: required region. Ratios, pulley and requirement are reconstructed."
)


def data(machine: Machine) -> dict[str, Any]:
    """Map of the drive with the largest motor, and the margins of the others on the same axes."""
    results = [result for result in machine.comparison.results.values() if isinstance(result.drive, ConventionalDrive)]
    torque = {
        result.name: result.drive.motor.continuous_torque
        for result in results
        if isinstance(result.drive, ConventionalDrive)
    }
    largest = max(results, key=lambda result: torque[result.name])
    return {
        "largest": operating_map.data(largest.map, machine.requirement),
        "title": largest.title,
        "others": {result.title: result.map.margin for result in results if result is not largest},
    }


def draw(ax: Axes, numbers: Mapping[str, Any]) -> operating_map.Drawn:
    """Draw the map and the outlines; return what the colour bar needs."""
    largest = numbers["largest"]
    filled = operating_map.draw(ax, largest)
    colours = ("#CC79A7", "#E69F00", "#56B4E9")
    for colour, (title, margin) in zip(colours, numbers["others"].items(), strict=False):
        clipped = np.clip(margin, 0.0, 2.0)
        ax.contour(largest["force"], largest["speed"], clipped, levels=[1.0], colors=colour, linewidths=2.0)
        ax.plot([], [], color=colour, lw=2.0, label=title)
    ax.plot([], [], color="black", lw=1.4, label=numbers["title"] + " (with efficiency)")
    ax.plot([], [], **operating_map.REQUIRED, label="required region")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=3)
    return filled


def draw_all(machine: Machine) -> Figure:
    """Draw the figure."""
    with style.styled():
        made, ax = style.figure(7.2, 4.8)
        filled = draw(ax, data(machine))
        operating_map.colour_bar(made, filled, ax)
    return made
