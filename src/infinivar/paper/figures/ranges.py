"""Figures 15 and 16: continuous operating ranges of the conventional drives and of the cobotic drive, with efficiencies."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.figures import operating_map, style
from infinivar.paper.claims.claim import Machine

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def conventional(machine: Machine) -> dict[str, Any]:
    """Map of the drive with the largest motor, and the margins of the others on the same axes.

    Source: faulring2006, Fig 15.
    """
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


def _draw_conventional(ax: Axes, numbers: Mapping[str, Any]) -> operating_map.Drawn:
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


def draw_conventional(machine: Machine) -> Figure:
    """Draw Figure 15."""
    with style.styled():
        made, ax = style.figure(7.2, 4.8)
        filled = _draw_conventional(ax, conventional(machine))
        operating_map.colour_bar(made, filled, ax)
    return made


def cobotic(machine: Machine) -> dict[str, Any]:
    """Map of each cobotic drive, by title.

    Source: faulring2006, Fig 16.
    """
    requirement = machine.requirement
    return {
        result.title: operating_map.data(result.map, requirement)
        for result in machine.comparison.results.values()
        if isinstance(result.drive, CoboticDrive)
    }


def draw_cobotic(machine: Machine) -> Figure:
    """Draw Figure 16."""
    numbers = cobotic(machine)
    with style.styled():
        made, axes = style.figure(4.4 * len(numbers) + 0.6, 3.8, 1, len(numbers), sharey=True, squeeze=False)
        filled: Any = None
        for ax, title in zip(axes.flat, numbers, strict=True):
            filled = operating_map.draw(ax, numbers[title], title)
            ax.label_outer()
        operating_map.colour_bar(made, filled, axes)
    return made
