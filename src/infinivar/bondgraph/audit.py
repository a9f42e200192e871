"""Trajectory of an integration, and its energy audit.

The audit makes two checks. At every output time the powers of each element must balance and its losses must not be negative;
this detects wrong equations and names the element. Over time, the energy from the sources must equal the energy lost and
stored; this detects integration errors.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from typing import TYPE_CHECKING, Any, NamedTuple

from infinivar._core.result import Result, result
from infinivar.bondgraph.graph import JUNCTIONS, SOURCES, TWO_PORTS, BondGraph, Element
from infinivar.errors import AuditError

if TYPE_CHECKING:
    from infinivar.bondgraph.march import Instants, March
    from infinivar.bondgraph.model import Model

CLOSURE = 1e-6
"""Largest accepted error of the energy balance, relative to the energy moved."""

RESOLVED = 1e-9
"""Energy below which a balance is not meaningful: in a drive that hardly moves, the residual is rounding error. [J]"""

_BALANCE = 1e-9
"""Largest accepted error of an element's power balance, relative to the sum of its powers; rounding leaves 1e-13."""


class ClosureError(AuditError):
    """Energy supplied differs from energy lost and stored: integration was too coarse, or an equation is wrong."""


class ElementEnergy(NamedTuple):
    """Cumulative energies of one element over time. [J]"""

    came: Any
    """Energy received through bonds that point to it."""
    went: Any
    """Energy delivered through bonds that point away."""
    given: Any
    """Energy supplied by a source."""
    lost: Any
    """Energy lost in the element; losses upstream of a source are not included."""
    stored: Any
    """Change of stored energy since the start."""


@result
class Trajectory(Result):
    """Simulated motion of a graph; arrays over time, SI.

    Attributes
    ----------
    graph                The graph.
    time                 (n,) [s]
    states, inputs       By name.
    signals              By name.
    efforts, flows       Efforts and flows of the bonds, by (tail, head).
    supplied             Cumulative energy from each source, by title. [J]
    lost                 Cumulative energy lost, by name of the loss. [J]
    stored               Energy in each storage, by title. [J]
    by_element           Cumulative energy from a source (element, "") and lost (element, name of the loss). [J]
    storages             Energy in each storage, by element. [J]
    passed               Cumulative energy through each bond along its half arrow, by (tail, head). [J] Always a sum over nodes
        between samples, which misses 1e-4 of the energy moved where friction reverses at 8 Hz.
    residual             Cumulative residual of the energy balance, over the energy moved in the whole motion. [-]
    outcome              "" if the motion is complete, else the reason and what to try.
    peaks                Largest of each demand that was watched, since the output before. [-]
    squares, cubes       Integrals of their squares and cubes since then. [s]
    """

    graph: BondGraph
    time: Any
    states: Mapping[str, Any]
    inputs: Mapping[str, Any]
    signals: Mapping[str, Any]
    efforts: Mapping[tuple[str, str], Any]
    flows: Mapping[tuple[str, str], Any]
    supplied: Mapping[str, Any]
    lost: Mapping[str, Any]
    stored: Mapping[str, Any]
    by_element: Mapping[tuple[str, str], Any]
    storages: Mapping[str, Any]
    passed: Mapping[tuple[str, str], Any]
    residual: Any
    outcome: str
    peaks: Mapping[Any, Any] = field(default_factory=dict)
    squares: Mapping[Any, Any] = field(default_factory=dict)
    cubes: Mapping[Any, Any] = field(default_factory=dict)

    @property
    def closure(self) -> float:
        """Largest residual. [-]"""
        import numpy as np

        return float(np.max(np.abs(self.residual)))

    @property
    def instants(self) -> Instants:
        """The outputs as `Instants`."""
        from infinivar.bondgraph.march import Instants

        return Instants(
            graph=self.graph,
            time=self.time,
            states=self.states,
            signals=self.signals,
            efforts=self.efforts,
            flows=self.flows,
        )

    def at(self, name: str) -> tuple[Any, Any]:
        """Effort and flow of a one-port, or of any other element at its first bond."""
        return self.instants.at(name)

    def energy(self, name: str) -> ElementEnergy:
        """Cumulative energy received, delivered, supplied, lost and stored by an element."""
        import numpy as np

        element, bonds = self.graph[name], self.graph.bonds_of(name)
        nothing = np.zeros_like(self.time)
        came = sum((self.passed[b.tail, b.head] for b in bonds if b.head == name), nothing)
        went = sum((self.passed[b.tail, b.head] for b in bonds if b.tail == name), nothing)
        mine = {key: energy for key, energy in self.by_element.items() if key[0] == name}
        source = element.kind in SOURCES
        lost = nothing if source else sum((energy for (_, what), energy in mine.items() if what), nothing)
        given = sum((energy for (_, what), energy in mine.items() if not what), nothing)
        stored = self.storages.get(name, nothing)
        return ElementEnergy(came, went, given, lost, stored - stored[0])

    def power(self, name: str) -> Any:
        """Power that a one-port absorbs, or that a source supplies. [W]"""
        effort, flow = self.at(name)
        gives = self.graph.bonds_of(name)[0].tail == name
        return effort * flow * (1.0 if gives == (self.graph[name].kind in SOURCES) else -1.0)


def audited(
    graph: BondGraph,
    made: Model,
    parameters: Mapping[str, float],
    run: March,
    outcome: str,
    closure: float = CLOSURE,
) -> Trajectory:
    """Trajectory with all quantities derived from states and energies, after a passed audit.

    The energy balance must close within `closure` of the energy moved, or within `RESOLVED`.

    Raises
    ------
    AuditError
        If an element's powers do not balance or a loss is negative; the message names the element.
    ClosureError
        If the energy balance does not close within `closure`; the message names the element with the largest residual.
    """
    import numpy as np

    time, states, inputs = run.times[: run.reached], run.states(), run.inputs()
    energies, passed = run.energies()
    outputs = made.function("outputs", np, parameters)
    values = iter(outputs(tuple(states.T), tuple(inputs[0].T), tuple(inputs[1].T)))

    def take(names: Any) -> dict[Any, Any]:
        return {name: np.broadcast_to(np.asarray(next(values), dtype=float), time.shape) for name in names}

    efforts, flows, signals, stored = take(made.bonds), take(made.bonds), take(made.signals), take(made.storages)
    take(made.sources)
    losses = take(made.losses)
    _check_elements(graph, efforts, flows, losses, time)

    supplied = _by_title(graph, made.sources, energies.T[: len(made.sources)])
    lost: dict[str, Any] = {}
    for (element, name), energy in zip(made.losses, energies.T[len(made.sources) :], strict=True):
        lost[name] = lost.get(name, 0.0) + energy
        if graph[element].kind in SOURCES:
            supplied[graph[element].title] = supplied[graph[element].title] + energy
    kept = _by_title(graph, made.storages, stored.values())
    change = sum((energy - energy[0] for energy in kept.values()), np.zeros_like(time))
    missing = sum(supplied.values(), np.zeros_like(time)) - sum(lost.values(), np.zeros_like(time)) - change
    moved = 0.5 * sum(
        float(np.max(np.abs(energy - energy[0]))) for group in (supplied, lost, kept) for energy in group.values()
    )
    scale = moved + RESOLVED / closure
    residual = missing / scale
    result = Trajectory(
        graph=graph,
        time=time,
        states=dict(zip(made.states, states.T, strict=True)),
        inputs=dict(zip(made.inputs, inputs[0].T, strict=True)),
        signals=signals,
        efforts=efforts,
        flows=flows,
        supplied=supplied,
        lost=lost,
        stored=kept,
        by_element=dict(zip([*((name, "") for name in made.sources), *made.losses], energies.T, strict=True)),
        storages=stored,
        passed=dict(zip(made.bonds, passed.T, strict=True)),
        residual=residual,
        outcome=outcome,
        **run.watched.until(run.reached),
    )
    if not result.closure <= closure:
        worst = max(graph.elements, key=lambda element: _missing(result, element.name))
        raise ClosureError(
            f"{graph.name}: the energy balance has a residual of {result.closure:.2g} of the energy moved, above the limit of "
            f"{closure:g}, largest at {worst.kind} {worst.name!r}. If integration is the cause, reduce the tolerance"
        )
    return result


def _missing(run: Trajectory, name: str) -> float:
    """Largest residual of an element's energy balance. [J]"""
    import numpy as np

    energy = run.energy(name)
    return float(np.max(np.abs(energy.given + energy.came - energy.went - energy.lost - energy.stored)))


def _by_title(graph: BondGraph, names: Any, energies: Any) -> dict[str, Any]:
    """Energies by title; elements that share a title add up."""
    found: dict[str, Any] = {}
    for name, energy in zip(names, energies, strict=True):
        title = graph[name].title
        found[title] = found.get(title, 0.0) + energy
    return found


def _check_elements(
    graph: BondGraph, efforts: Mapping[Any, Any], flows: Mapping[Any, Any], losses: Mapping[Any, Any], time: Any
) -> None:
    import numpy as np

    def refuse(element: Element, what: str, where: Any) -> None:
        index = int(np.argmax(where))
        raise AuditError(f"{graph.name}: {element.kind} {element.name!r} {what} at {time[index]:.6g} s")

    for element in graph.elements:
        powers = [
            efforts[bond.tail, bond.head] * flows[bond.tail, bond.head] * (1.0 if bond.head == element.name else -1.0)
            for bond in graph.bonds_of(element.name)
        ]
        scale = _BALANCE * sum(np.abs(power) for power in powers) + 1e-300
        if element.kind in (*JUNCTIONS, *TWO_PORTS):
            wrong = np.abs(sum(powers)) > scale
            if wrong.any():
                refuse(element, "does not conserve power", wrong)
        mine = [loss for (name, _), loss in losses.items() if name == element.name]
        if element.kind == "R":
            wrong = np.abs(sum(powers) - sum(mine)) > scale
            if wrong.any():
                refuse(element, "has losses that differ from the power it absorbs", wrong)
        for loss in mine:
            if (loss < -scale).any():
                refuse(element, "creates power", loss < -scale)
