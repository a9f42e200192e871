"""Causality: which end of each bond determines the effort and which the flow.

The sequential causality assignment procedure: sources first, then storages in integral causality, then resistances whose
laws need flows, then the remaining bonds; each choice is propagated through the graph. A storage that cannot have integral
causality is dependent; a bond assigned only in the last step is part of an algebraic loop.

Source: karnopp2012, section 3.4 and chapter 5.
"""

from __future__ import annotations

from dataclasses import dataclass

from infinivar.bondgraph.graph import JUNCTIONS, SOURCES, STORAGES, TWO_PORTS, Bond, BondGraph, BondGraphError, Element


@dataclass(frozen=True, slots=True)
class Causality:
    """Causality of a graph.

    Attributes
    ----------
    stroke       End of each bond that receives the effort, where the causal stroke is drawn.
    independent  Storages in integral causality, each with its own state.
    dependent    Storages in derivative causality: their energy follows from other states.
    looped       Elements whose causality was a free choice: resistances in an algebraic loop.
    """

    stroke: dict[Bond, str]
    independent: tuple[str, ...]
    dependent: tuple[str, ...]
    looped: tuple[str, ...]

    def effort_into(self, bond: Bond, element: str) -> bool:
        """Whether the element receives the effort of the bond (and so determines its flow)."""
        return self.stroke[bond] == element


def assign(graph: BondGraph) -> Causality:
    """Causality of a complete graph.

    Parameters
    ----------
    graph : BondGraph

    Returns
    -------
    Causality

    Raises
    ------
    BondGraphError
        If two elements determine the same quantity (two flow sources on one 1-junction); the message names both. Also if a
        law would not receive what it needs: the displacement of a compliance, the flow of a resistance (of a conductance,
        the effort).
    """
    return _Procedure(graph).run()


class _Procedure:
    def __init__(self, graph: BondGraph) -> None:
        self.graph = graph
        self.at = {element.name: graph.bonds_of(element.name) for element in graph.elements}
        self.element = {element.name: element for element in graph.elements}
        self.stroke: dict[Bond, str] = {}
        self.cause: dict[Bond, str] = {}

    def run(self) -> Causality:
        """Sources, then storages, laws, linear resistances and last what no element decides: each step settles what follows."""
        self.settle_sources()
        independent, dependent = self.settle_storages()
        for element in self.graph.elements:
            if element.kind == "R" and element.law is not None:
                self.settle_law(element)
        looped = self.settle_rest()
        self.check()
        return Causality(self.stroke, tuple(independent), tuple(dependent), tuple(looped))

    def settle_sources(self) -> None:
        for element in self.graph.elements:
            if element.kind in SOURCES:
                (bond,) = self.at[element.name]
                self.settle(bond, element.name, bond.other(element.name) if element.kind == "Se" else element.name)

    def settle_storages(self) -> tuple[list[str], list[str]]:
        """Storages that keep integral causality, and those that what is settled already deprives of it."""
        independent, dependent = [], []
        # Those with a law first: they have no other causality.
        for element in sorted(self.graph.elements, key=lambda element: element.law is None):
            if element.kind in STORAGES:
                (bond,) = self.at[element.name]
                required = self.integral(element, bond)
                if bond not in self.stroke:
                    self.settle(bond, element.name, required)
                elif element.law is not None and self.stroke[bond] != required:
                    raise BondGraphError(
                        f"{self.graph.name}: the law of C {element.name!r} needs a displacement, but {self.cause[bond]!r} "
                        f"imposes its effort; put an inertia between the two"
                    )
                (independent if self.stroke[bond] == required else dependent).append(element.name)
        return independent, dependent

    def settle_rest(self) -> list[str]:
        """Elements that had a choice: a linear resistance, or as a last resort a junction, takes what is left."""
        looped = []
        for element in self.graph.elements:
            for bond in self.at[element.name]:
                if bond not in self.stroke and element.kind == "R":
                    looped.append(element.name)
                    self.settle(bond, element.name, bond.other(element.name))
        for bond in self.graph.bonds:
            if bond not in self.stroke:
                looped.append(bond.tail)
                self.settle(bond, bond.tail, bond.head)
        return looped

    @staticmethod
    def integral(element: Element, bond: Bond) -> str:
        """End of the bond that receives the effort when the storage has integral causality."""
        return element.name if element.kind == "I" else bond.other(element.name)

    def settle_law(self, element: Element) -> None:
        """A law maps flows to efforts, or efforts to flows: it must receive all of them."""
        needs, imposed = ("an effort", "flow") if element.of_effort else ("a flow", "effort")
        for bond in self.at[element.name]:
            required = element.name if element.of_effort else bond.other(element.name)
            if bond not in self.stroke:
                self.settle(bond, element.name, required)
            elif self.stroke[bond] != required:
                raise BondGraphError(
                    f"{self.graph.name}: the law of R {element.name!r} needs {needs}, but {self.cause[bond]!r} imposes its "
                    f"{imposed}; put a storage between the two"
                )

    def settle(self, bond: Bond, element: str, end: str) -> None:
        """Let `end` receive the effort of the bond, as `element` requires, and propagate the consequences."""
        waiting = [(bond, element, end)]
        while waiting:
            bond, cause, end = waiting.pop()
            known = self.stroke.get(bond)
            if known is not None:
                if known != end:
                    self.refuse(bond, cause)
                continue
            self.stroke[bond], self.cause[bond] = end, cause
            for place in (bond.tail, bond.head):
                waiting += [(other, cause, at) for other, at in self.follows(self.element[place])]

    def follows(self, element: Element) -> list[tuple[Bond, str]]:
        """Assignments of an element's open bonds that follow from its assigned bonds."""
        open_bonds = [bond for bond in self.at[element.name] if bond not in self.stroke]
        if not open_bonds:
            return []
        if element.kind in TWO_PORTS:
            return self.follows_through(element, open_bonds)
        return self.follows_at_junction(element, open_bonds) if element.kind in JUNCTIONS else []

    def follows_through(self, element: Element, open_bonds: list[Bond]) -> list[tuple[Bond, str]]:
        """A two-port with one bond settled decides the other."""
        name = element.name
        settled = [bond for bond in self.at[name] if bond not in open_bonds]
        if not settled:
            return []
        in_here = (self.stroke[settled[0]] == name) == (element.kind == "GY")
        return [(open_bonds[0], name if in_here else open_bonds[0].other(name))]

    def follows_at_junction(self, element: Element, open_bonds: list[Bond]) -> list[tuple[Bond, str]]:
        """One bond decides: at a 0-junction the one that brings the effort, at a 1-junction the one that takes it away."""
        name, zero = element.name, element.kind == "0"
        if any(bond in self.stroke and self.decides(element, bond) for bond in self.at[name]):
            return [(bond, bond.other(name) if zero else name) for bond in open_bonds]
        if len(open_bonds) == 1:
            return [(open_bonds[0], name if zero else open_bonds[0].other(name))]
        return []

    def decides(self, element: Element, bond: Bond) -> bool:
        """Whether the bond determines the common quantity of a junction."""
        return (self.stroke[bond] == element.name) == (element.kind == "0")

    def check(self) -> None:
        for element in self.graph.elements:
            bonds = self.at[element.name]
            if element.kind in JUNCTIONS:
                strong = [bond for bond in bonds if self.decides(element, bond)]
                if len(strong) != 1:
                    self.clash(element, strong or list(bonds))
            elif element.kind in TWO_PORTS:
                inward = sum(self.stroke[bond] == element.name for bond in bonds)
                if inward not in ((1,) if element.kind == "TF" else (0, 2)):
                    self.clash(element, list(bonds))

    def refuse(self, bond: Bond, cause: str) -> None:
        raise BondGraphError(
            f"{self.graph.name}: {cause!r} and {self.cause[bond]!r} both determine the same quantity "
            f"on the bond {bond.tail} > {bond.head}; put a storage or a resistance between them"
        )

    def clash(self, element: Element, bonds: list[Bond]) -> None:
        causes = " and ".join(dict.fromkeys(repr(self.cause[bond]) for bond in bonds))
        what = {"0": "effort", "1": "flow"}.get(element.kind, "effort and flow")
        raise BondGraphError(
            f"{self.graph.name}: the {what} at {element.kind} {element.name!r} is determined by {causes} instead of exactly "
            f"one element; put a storage or a resistance between them"
        )
