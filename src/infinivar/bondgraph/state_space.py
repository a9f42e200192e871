"""State space of a bond graph as SymPy expressions: what a derivation finds, and printing and code generation read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import sympy

from infinivar.bondgraph.causality import Causality
from infinivar.bondgraph.graph import Bond, BondGraph, BondGraphError
from infinivar.bondgraph.loops import LawValue

Expression = Any
"""A SymPy expression."""


@dataclass(frozen=True, slots=True)
class State:
    """One state: the symbol, and the element or integral signal it belongs to."""

    symbol: sympy.Symbol
    name: str
    kind: Literal["flow", "displacement", "signal"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Equations:
    """State space of a graph.

    Attributes
    ----------
    graph, causality
    states, derivatives   States and their time derivatives.
    inputs                Symbols of sources and outside signals, by name.
    rates                 Symbols of time derivatives of inputs, by name of the input, for dependent storages.
    laws                  Values of laws, and of large parts of expressions, in order of evaluation.
    efforts, flows        Effort and flow of every bond.
    signals               Value of every signal.
    stored                Energy in every storage.
    power                 Power absorbed by each storage and resistance or supplied by each source, by element.
    losses                Power lost, by element and name of the loss, including losses upstream of sources.

    All expressions are in terms of states, inputs, rates, parameters and symbols of laws.
    """

    graph: BondGraph
    causality: Causality
    states: tuple[State, ...]
    derivatives: tuple[Expression, ...]
    inputs: Mapping[str, sympy.Symbol]
    rates: Mapping[str, sympy.Symbol]
    laws: tuple[LawValue, ...]
    efforts: Mapping[Bond, Expression]
    flows: Mapping[Bond, Expression]
    signals: Mapping[str, Expression]
    stored: Mapping[str, Expression]
    power: Mapping[str, Expression]
    losses: Mapping[str, Mapping[str, Expression]]

    def expanded(self, expression: Expression) -> Expression:
        """Expression with the values of all laws substituted."""
        for law in reversed(self.laws):
            expression = expression.subs(law.symbol, law.value)
        return expression

    def state_space(self) -> tuple[sympy.Matrix, sympy.Matrix]:
        """Matrices A and B of a linear graph, ``dx/dt = A x + B u``.

        Raises
        ------
        BondGraphError
            If the graph is not linear; the message names the element.
        """
        states, inputs = [state.symbol for state in self.states], list(self.inputs.values())
        rows = sympy.Matrix([self.expanded(derivative) for derivative in self.derivatives])
        a, b = rows.jacobian(states), rows.jacobian(inputs) if inputs else sympy.zeros(len(states), 0)
        if (a.free_symbols | b.free_symbols) & {*states, *inputs}:
            curved = [law.element for law in self.laws] or [e.name for e in self.graph.elements if e.modulated]
            raise BondGraphError(f"{self.graph.name} is not linear because of {', '.join(dict.fromkeys(curved))}")
        return a.applyfunc(sympy.factor), b.applyfunc(sympy.factor)
