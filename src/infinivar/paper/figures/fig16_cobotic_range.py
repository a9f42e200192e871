"""Figure 16: operating range of the cobotic drive with Motor 1, in both reconstructions of the machine."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.figures import operating_map, style
from infinivar.paper.claims.claim import Machine

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TITLE = "Operating range of the cobotic drive"

CAPTION = (
    "Operating range and efficiency of the cobotic drive in two reconstructions, which differ mainly in the loss of the "
    "cylinder gear: a constant friction torque (left), or a loss proportional to power (right). Dashed: required region."
)


def data(machine: Machine) -> dict[str, Any]:
    """Map of each cobotic drive, by title."""
    requirement = machine.requirement
    return {
        result.title: operating_map.data(result.map, requirement)
        for result in machine.comparison.results.values()
        if isinstance(result.drive, CoboticDrive)
    }


def draw(ax: Axes, numbers: Mapping[str, Any], title: str) -> operating_map.Drawn:
    """Draw one of the maps; return what the colour bar needs."""
    return operating_map.draw(ax, numbers[title], title)


def draw_all(machine: Machine) -> Figure:
    """Draw the figure."""
    numbers = data(machine)
    with style.styled():
        made, axes = style.figure(4.4 * len(numbers) + 0.6, 3.8, 1, len(numbers), sharey=True, squeeze=False)
        filled: Any = None
        for ax, title in zip(axes.flat, numbers, strict=True):
            filled = draw(ax, numbers, title)
            ax.label_outer()
        operating_map.colour_bar(made, filled, axes)
    return made
