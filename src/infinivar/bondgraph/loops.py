"""Values of laws, their order of evaluation, and algebraic loops between them.

A law whose argument depends on its own value forms an algebraic loop; an example is a gear with load-proportional friction
between two inertias. If the law is proportional to that argument on each side of zero, as such friction is, one Newton step
from zero is the exact solution.
"""

from __future__ import annotations

import random
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import sympy

from infinivar.bondgraph.graph import BondGraphError


@dataclass(frozen=True, slots=True)
class LawValue:
    """Value of a law at one port: its symbol, and its expression in arguments and parameters."""

    symbol: sympy.Symbol
    element: str
    arguments: tuple[tuple[sympy.Symbol, Any], ...]
    """Symbols of flows and signals in `formula`, and the expressions they stand for."""
    formula: Any
    value: Any
    """The formula with the arguments substituted; in an algebraic loop, the solution of the loop."""


def ordered(graph: str, laws: Iterable[LawValue]) -> tuple[LawValue, ...]:
    """Sort the laws so that each depends only on earlier ones, and solve the loops.

    Raises
    ------
    BondGraphError
        If a loop cannot be solved exactly; the message names its elements.
    """
    waiting = {law.symbol: law for law in laws}
    done: list[LawValue] = []
    while waiting:
        ready = [law for law in waiting.values() if not law.value.free_symbols & (set(waiting) - {law.symbol})]
        if not ready:
            names = ", ".join(dict.fromkeys(law.element for law in waiting.values()))
            raise BondGraphError(f"{graph}: the laws of {names} depend on each other in an algebraic loop")
        for law in ready:
            done.append(_solved(graph, law) if law.symbol in law.value.free_symbols else law)
            del waiting[law.symbol]
    return tuple(done)


def _solved(graph: str, law: LawValue) -> LawValue:
    looped = [(argument, value) for argument, value in law.arguments if law.symbol in value.free_symbols]
    if len(looped) == 1:
        argument, value = looped[0]
        gain = sympy.expand(value).coeff(law.symbol, 1)
        rest = sympy.expand(value - gain * law.symbol)
        if law.symbol not in rest.free_symbols and _proportional(law.formula, argument):
            others = {symbol: expression for symbol, expression in law.arguments if symbol != argument}
            at_rest = {**others, argument: rest}
            slope = law.formula.diff(argument).xreplace(at_rest)
            return replace(law, value=law.formula.xreplace(at_rest) / (1 - gain * slope))
    raise BondGraphError(
        f"{graph}: the law of {law.element!r} depends on its own value in an algebraic loop and is not proportional to "
        f"that argument; add a storage to break the loop"
    )


def _proportional(formula: Any, argument: Any) -> bool:
    """Whether the formula is proportional to the argument on each side of zero, tested at random points."""
    chance = random.Random(1)
    others = formula.free_symbols - {argument}
    for _ in range(8):
        point = {symbol: sympy.Float(chance.uniform(-2.0, 2.0)) for symbol in others}
        size = sympy.Float(chance.choice((-1, 1)) * chance.uniform(0.1, 2.0))
        one, two = (formula.subs({**point, argument: factor * size}) for factor in (1, 3))
        if abs(two - 3 * one) > 1e-9 * (abs(two) + abs(one)):
            return False
    return True
