"""Figures 2, 6 and 10 to 14: the bond graphs that `infinivar.drivetrain.graphs` builds and simulates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from infinivar.bondgraph.graph import BondGraph
from infinivar.drivetrain.graphs.plants import plant_graph
from infinivar.figures import bond_graph
from infinivar.paper.claims.claim import Machine

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@dataclass(frozen=True, slots=True, kw_only=True)
class PlantFigure:
    """Bond graph of a drive of the machine, or of one of its plants."""

    drive: str
    plant: str
    TITLE: str
    CAPTION: str

    def graph(self, machine: Machine) -> BondGraph:
        """The graph; sources stand for the neighbours of a plant."""
        load_mass = machine.load_mass if self.plant == "system" else None
        return plant_graph(machine.study.drives[self.drive], self.plant, load_mass=load_mass)

    def data(self, machine: Machine) -> dict[str, Any]:
        """Positions, texts and causality of the elements."""
        return bond_graph.data(self.graph(machine))

    def draw(self, ax: Axes, numbers: Mapping[str, Any]) -> None:
        """Draw into axes with data coordinates in inches."""
        bond_graph.draw(ax, numbers)

    def draw_all(self, machine: Machine) -> Figure:
        """Draw the figure."""
        return bond_graph.draw_all(self.graph(machine))


BOND_GRAPHS = {
    2: PlantFigure(
        drive="cobotic",
        plant="lossless",
        TITLE="Bond graph of the lossless transmission",
        CAPTION=(
            "A single transformer, modulated by the steering angle (Eqs 1 and 2). At angle 0 its modulus is zero and the link is "
            "locked. The sources at both ends stand for the cylinder plant and the link plant."
        ),
    ),
    6: PlantFigure(
        drive="cobotic",
        plant="transmission",
        TITLE="Bond graph of the transmission plant with its losses",
        CAPTION=(
            "The transmission of Figure 2 with creep, rolling and bearing losses. The paper's text puts the loss of effort "
            "before the loss of flow; its Eqs 3 to 6 need all four transformers, because creep speed and rolling speed each "
            "depend on both speeds, and both losses act on both sides. A bar across a bond marks the end where the effort "
            "acts; dashed arrows are signals."
        ),
    ),
    10: PlantFigure(
        drive="cobotic",
        plant="system",
        TITLE="Bond graph of the cobotic system",
        CAPTION=(
            "The four plants of Figures 6 and 11 to 13 with the load. The inputs are two currents and an external force. The "
            "steering angle only modulates the transmission; no power flows between the two."
        ),
    ),
    11: PlantFigure(
        drive="cobotic",
        plant="steering",
        TITLE="Bond graph of the steering plant",
        CAPTION=(
            "From current to steering angle: winding loss, inertia and friction of the motor, a lossless gear, the inertia of "
            "the bell, and the friction of its bearing and of the contact patch, which turns on the spot. The paper omits the "
            "friction of the motor."
        ),
    ),
    12: PlantFigure(
        drive="cobotic",
        plant="cylinder",
        TITLE="Bond graph of the cylinder plant",
        CAPTION=(
            "From current to torque and speed of the cylinder: winding loss, inertia and friction of the motor, the gearhead "
            "with its loss, and the inertia of the cylinder. The effort source stands for the transmission."
        ),
    ),
    13: PlantFigure(
        drive="cobotic",
        plant="link",
        TITLE="Bond graph of the link plant",
        CAPTION=(
            "Power from the transmission to the load, less the friction of the guideway and the power that accelerates the link. "
            "The effort source stands for the transmission and the load together."
        ),
    ),
    14: PlantFigure(
        drive="motor2-gear4",
        plant="system",
        TITLE="Bond graph of the conventional system",
        CAPTION=(
            "Motor 2 with its fixed ratio: winding loss, friction and inertia of motor, gear, pulley and cable, and the pulley "
            "that converts rotation into translation."
        ),
    ),
}
"""The bond graphs by figure number."""
