"""The paper's seventeen figures by number, drawn from the models.

Each figure has a title, a caption, ``data(machine)``, which returns its numbers, and ``draw_all(machine)``. The bond graphs
share one module; every other figure has its own, with ``draw(ax, ...)``.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Protocol

from infinivar.paper.figures import (
    bond_graphs,
    fig01_steered_wheel,
    fig03_velocities,
    fig04_forces,
    fig05_creep,
    fig07_element_efficiency,
    fig08_gear_comparison,
    fig09_architectures,
    fig15_conventional_ranges,
    fig16_cobotic_range,
    fig17_dynamic_performance,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from infinivar.paper.claims.claim import Machine


class PaperFigure(Protocol):
    """Interface of a figure of the paper."""

    @property
    def TITLE(self) -> str:  # noqa: N802 - a constant in modules
        """Short title."""
        ...

    @property
    def CAPTION(self) -> str:  # noqa: N802 - a constant in modules
        """Caption, in full sentences."""
        ...

    def data(self, machine: Machine) -> Mapping[str, Any]:
        """The numbers that the figure shows."""
        ...

    def draw_all(self, machine: Machine) -> Figure:
        """Draw the figure."""
        ...


FIGURES: Mapping[int, PaperFigure] = dict(
    sorted(
        {
            1: fig01_steered_wheel,
            3: fig03_velocities,
            4: fig04_forces,
            5: fig05_creep,
            7: fig07_element_efficiency,
            8: fig08_gear_comparison,
            9: fig09_architectures,
            15: fig15_conventional_ranges,
            16: fig16_cobotic_range,
            17: fig17_dynamic_performance,
            **bond_graphs.BOND_GRAPHS,
        }.items()
    )
)


def missing_for(number: int) -> str:
    """A sentence that says what to install before a figure can be drawn; empty if nothing is missing."""
    if number in bond_graphs.BOND_GRAPHS and importlib.util.find_spec("igraph") is None:
        return f"Figure {number} is a bond graph, and its layout needs igraph: pip install 'infinivar[graph]'"
    return ""
