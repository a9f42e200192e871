"""Units of the efforts and flows of a drive's graph, from those of its parameters."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from infinivar.bondgraph.graph import JUNCTIONS, SOURCES, TWO_PORTS, Bond, BondGraph, Element, Signal


class Domain(NamedTuple):
    """Units of effort, flow and displacement: their products are powers and energies."""

    effort: str
    flow: str
    displacement: str


UNKNOWN = Domain("", "", "")
ELECTRICAL, LINEAR, ROTARY = Domain("V", "A", "A s"), Domain("N", "m/s", "m"), Domain("N m", "rad/s", "rad")

_OF_PARAMETER = {
    "I": {"kg": LINEAR, "kg m^2": ROTARY, "H": ELECTRICAL},
    "C": {"m/N": LINEAR, "rad/(N m)": ROTARY},
    "R": {"ohm": ELECTRICAL, "N m s": ROTARY, "N s/m": LINEAR},
}
"""Domain of a linear element, by the unit of its parameter."""

_OF_FRICTION = {"N": LINEAR, "N m": ROTARY}
"""Domain of an element with a law, by the unit of the size of its effort."""

_LOAD = ("force", "motion")
"""Sources of the load."""


def domains(graph: BondGraph, *, rotary: bool) -> Mapping[Bond, Domain]:
    """Domain of every bond of a drive's graph; UNKNOWN where no parameter decides it.

    Parameters
    ----------
    graph : BondGraph
    rotary : bool   Whether the load turns about a joint.

    Source: karnopp2012, Table 2.2 and section 3.2.
    """
    found: dict[Bond, Domain] = {}
    waiting = [one for element in graph.elements for one in _stated(graph, element, rotary)]
    while waiting:
        bonds, domain = waiting.pop(0)
        for bond in bonds:
            if bond not in found and domain is not UNKNOWN:
                found[bond] = domain
                waiting += [
                    each for name in (bond.tail, bond.head) for each in _beyond(graph, graph[name], bond, domain)
                ]
    return dict.fromkeys(graph.bonds, UNKNOWN) | found


def _stated(graph: BondGraph, element: Element, rotary: bool) -> Iterator[tuple[Sequence[Bond], Domain]]:
    """Yield the bonds whose domain an element states by itself."""
    bonds = graph.bonds_of(element.name)
    if element.name in _LOAD:
        yield bonds, ROTARY if rotary else LINEAR
    elif element.kind in _OF_PARAMETER and element.parameter is not None:
        yield bonds, _OF_PARAMETER[element.kind].get(element.parameter.unit, UNKNOWN)
    elif element.kind == "R" and "size" in element.parameters and len(bonds) == 1:
        yield bonds, _OF_FRICTION.get(element.parameters["size"].unit, UNKNOWN)


def _beyond(graph: BondGraph, element: Element, bond: Bond, domain: Domain) -> Iterable[tuple[Sequence[Bond], Domain]]:
    """Bonds beyond an element, and the domain that they have as one of its bonds has it."""
    others = [other for other in graph.bonds_of(element.name) if other != bond]
    if element.kind in JUNCTIONS:
        return [(others, domain)]
    if element.kind not in TWO_PORTS:
        return []
    modulus = [*([element.parameter] if element.parameter else []), *element.parameters.values()]
    if element.kind == "GY":
        moved = LINEAR if modulus[0].unit == "N/A" else ROTARY
        return [(others, moved if domain is ELECTRICAL else ELECTRICAL)]
    if not modulus:
        return []  # a law of signals alone: the bonds beyond it are reached another way
    lengths = sum(one.unit == "m" for one in modulus)
    return [(others, (LINEAR if domain is ROTARY else ROTARY) if lengths else domain)]


def unit_of_signal(graph: BondGraph, signal: Signal, found: Mapping[Bond, Domain]) -> str:
    """Unit of a signal: of the flow of a one-port or 1-junction, of the effort of a 0-junction or two-port, or of its integral.

    A signal from outside commands the current of a motor.
    """
    if not signal.of:
        return "A"
    kind = graph[signal.of].kind
    bonds = [bond for bond in graph.bonds_of(signal.of) if kind not in TWO_PORTS or bond.head == signal.of]
    domain = found[bonds[0]]
    if kind == "0" or kind in TWO_PORTS:
        return domain.effort
    return domain.displacement if signal.integral else domain.flow


def unit_of_state(graph: BondGraph, name: str, kind: str, found: Mapping[Bond, Domain]) -> str:
    """Unit of a state: flow of an inertia, displacement of a compliance, or an integral signal."""
    if kind == "signal":
        return unit_of_signal(graph, next(one for one in graph.signals if one.name == name), found)
    domain = found[graph.bonds_of(name)[0]]
    return domain.flow if kind == "flow" else domain.displacement


def unit_of_input(graph: BondGraph, name: str, found: Mapping[Bond, Domain]) -> str:
    """Unit of an input: effort or flow of a source, or a signal from outside."""
    element = next((one for one in graph.elements if one.name == name), None)
    if element is None or element.kind not in SOURCES:
        return unit_of_signal(graph, next(one for one in graph.signals if one.name == name), found)
    domain = found[graph.bonds_of(name)[0]]
    return domain.effort if element.kind == "Se" else domain.flow
