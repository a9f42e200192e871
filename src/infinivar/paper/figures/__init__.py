"""The paper's seventeen figures by number, drawn from the models; `figures.toml` has their titles and captions."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterator, Mapping
from importlib import resources
from typing import TYPE_CHECKING, Any, NamedTuple

from infinivar._core import extras
from infinivar.bondgraph.graph import BondGraph
from infinivar.drivetrain.graphs.plants import plant_graph
from infinivar.figures import bond_graph, style
from infinivar.paper.claims.claim import PaperMachine
from infinivar.paper.figures import (
    architectures,
    curves,
    maps,
    polygons,
    steered_wheel,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure


Numbers = Callable[[PaperMachine], Mapping[str, Any]]
Drawing = Callable[[PaperMachine], "Figure"]


class PaperFigure(NamedTuple):
    """A figure of the paper."""

    title: str
    caption: str
    data: Numbers
    """The numbers that the figure shows."""
    draw_all: Drawing
    plant: tuple[str, str] | None
    """Drive of the machine, and the plant of it whose bond graph this is; None for other figures."""


def _in_one(data: Numbers, draw: Callable[..., None], width: float = 7.4) -> tuple[Numbers, Drawing]:
    """Data, and what draws them into one pair of axes."""

    def drawn(machine: PaperMachine) -> Figure:
        with style.styled():
            made, ax = style.figure(width, 4.0)
            draw(ax, data(machine))
        return made

    return data, drawn


def _bond_graph(drive: str, plant: str) -> tuple[Numbers, Drawing]:
    """Data and drawing of the graph of a drive, or of one of its plants; sources stand for the neighbours of a plant."""

    def graph(machine: PaperMachine) -> BondGraph:
        load_mass = machine.load_mass if plant == "system" else None
        return plant_graph(machine.study.drives[drive], plant, load_mass=load_mass)

    return lambda machine: bond_graph.data(graph(machine)), lambda machine: bond_graph.draw_all(graph(machine))


_DRAWN: Mapping[int, tuple[Numbers, Drawing]] = {
    1: (steered_wheel.data, steered_wheel.draw_all),
    3: (polygons.velocities, lambda machine: polygons.draw(polygons.VELOCITIES, polygons.velocities(machine))),
    4: (polygons.forces, lambda machine: polygons.draw(polygons.FORCES, polygons.forces(machine))),
    5: _in_one(curves.creep_curves, curves.draw_creep, 7.2),
    7: _in_one(curves.efficiency, curves.draw_efficiency),
    8: _in_one(curves.against_gears, curves.draw_against_gears),
    9: (architectures.data, architectures.draw_all),
    15: (maps.conventional, maps.draw_conventional),
    16: (maps.cobotic, maps.draw_cobotic),
    17: (maps.dynamic_maps, maps.draw_all_dynamic),
}
"""Data of each figure that is no bond graph, and what draws it."""


def _read() -> Iterator[tuple[int, PaperFigure]]:
    text = (resources.files("infinivar.paper") / "figures" / "figures.toml").read_text("utf-8")
    for row in tomllib.loads(text)["figure"]:
        plant = (row["drive"], row["plant"]) if "plant" in row else None
        drawn = _DRAWN[row["number"]] if plant is None else _bond_graph(*plant)
        yield row["number"], PaperFigure(row["title"], row["caption"], *drawn, plant)


FIGURES: Mapping[int, PaperFigure] = dict(_read())


def missing_for(number: int) -> str:
    """A sentence that says what to install before a figure can be drawn; empty if nothing is missing."""
    if FIGURES[number].plant is not None and not extras.there("igraph"):
        return f"Figure {number} is a bond graph, and its layout needs igraph: pip install 'infinivar[graph]'"
    return ""
