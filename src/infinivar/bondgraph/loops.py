"""Values of laws, their order of evaluation, and algebraic loops between them.

A law whose argument depends on its own value forms an algebraic loop; an example is a gear with load-proportional friction
between two inertias. If the law is proportional to that argument on each side of zero, as such friction is, one Newton step
from zero is the exact solution. Several such laws that depend on each other, as of a gear and a screw in one drive, are solved
for every combination of signs; the combination whose solution has these signs is the solution. Any other law, such as friction
with a constant part and squares of the load, must state its own solution of the loop.
"""

from __future__ import annotations

import itertools
import random
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import sympy

from infinivar.bondgraph.graph import BondGraphError

_MOST_JOINT = 3
"""Most laws that are solved together; each doubles the number of cases."""


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
    solution: tuple[sympy.Symbol, Any] | None = None
    """Symbol of the gain of the argument per value of the law, and the law's own solution of a loop, in its arguments and this
    gain; None if the law states none."""


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
            ready = _jointly(graph, _circle(waiting))
        for law in ready:
            done += _solved(graph, law) if law.symbol in law.value.free_symbols else [law]
            waiting.pop(law.symbol, None)
    return tuple(done)


def _circle(waiting: dict[sympy.Symbol, LawValue]) -> list[LawValue]:
    """Laws that all depend on each other, and on no other law that waits."""
    needs = {symbol: law.value.free_symbols & set(waiting) for symbol, law in waiting.items()}
    for _ in waiting:
        needs = {symbol: needed.union(*(needs[other] for other in needed)) for symbol, needed in needs.items()}
    fewest = min(needs.values(), key=len)
    return [waiting[symbol] for symbol in waiting if symbol in fewest]


def _jointly(graph: str, laws: Sequence[LawValue]) -> list[LawValue]:
    """Solve laws that depend on each other, each proportional to one argument on each side of zero.

    With the arguments ``T = a + G f`` and the laws ``f_i = k_i T_i``, whose k_i has one value for each sign of T_i, the
    arguments are ``(1 - G K)^-1 a`` for one combination of signs.
    """
    symbols = [law.symbol for law in laws]
    parts = [_affine(law, symbols) for law in laws]
    if len(laws) > _MOST_JOINT or any(part is None for part in parts) or any(law.solution is not None for law in laws):
        names = ", ".join(dict.fromkeys(law.element for law in laws))
        raise BondGraphError(f"{graph}: the laws of {names} depend on each other in an algebraic loop")
    size = len(laws)
    steps, rests, slopes, gains = [], [], [], []
    for law, part in zip(laws, parts, strict=True):
        assert part is not None
        argument, rest, row = part
        own = [_step(law, "a", rest)]
        own += [_step(law, side, slope) for side, slope in zip("+-", _slopes(law, argument), strict=True)]
        rests.append(own[0].symbol)
        slopes.append([step.symbol for step in own[1:]])
        gains.append(row)
        steps += own
    diagonal = [sympy.Dummy() for _ in range(size)]
    coupling = sympy.Matrix(size, size, lambda *_: sympy.Dummy())
    arguments = list((sympy.eye(size) - coupling * sympy.diag(*diagonal)).LUsolve(sympy.Matrix(rests)))
    known = dict(zip(coupling.flat(), itertools.chain(*gains), strict=True))
    cases: list[list[tuple]] = [[] for _ in laws]
    for sides in itertools.product((0, 1), repeat=size):
        chosen = [pair[side] for pair, side in zip(slopes, sides, strict=True)]
        found = [value.xreplace(known | dict(zip(diagonal, chosen, strict=True))) for value in arguments]
        agrees = sympy.And(*(value <= 0 if side else value >= 0 for side, value in zip(sides, found, strict=True)))
        for case, slope, value in zip(cases, chosen, found, strict=True):
            case.append((slope * value, agrees))
    solved = [
        replace(law, value=sympy.Piecewise(*case[:-1], (case[-1][0], sympy.true), evaluate=False))
        for law, case in zip(laws, cases, strict=True)
    ]
    return [*steps, *solved]


def _step(law: LawValue, mark: str, value: Any) -> LawValue:
    """An intermediate value of a law's solution: its argument without the laws, its gain, or its slope on one side of zero."""
    symbol = sympy.Symbol(rf"{{{law.symbol.name}}}^{{{mark}}}", real=True)
    return LawValue(symbol, law.element, (), value, value)


def _affine(law: LawValue, symbols: Sequence[sympy.Symbol]) -> tuple[Any, Any, list[Any]] | None:
    """The argument of a law that depends on symbols, its value without them and its gains; None if that is not its form."""
    looped = [(argument, value) for argument, value in law.arguments if value.free_symbols & set(symbols)]
    if len(looped) != 1:
        return None
    argument, value = looped[0][0], sympy.expand(looped[0][1])
    gains = [value.coeff(symbol, 1) for symbol in symbols]
    rest = sympy.expand(value - sum(gain * symbol for gain, symbol in zip(gains, symbols, strict=True)))
    left = rest.free_symbols.union(*(gain.free_symbols for gain in gains))
    solvable = law.solution is not None or _proportional(law.formula, argument)
    return (argument, rest, gains) if solvable and not left & set(symbols) else None


def _slopes(law: LawValue, argument: Any) -> list[Any]:
    """Slope of a law above and below zero of an argument."""
    others = {symbol: expression for symbol, expression in law.arguments if symbol != argument}
    return [sign * law.formula.xreplace({**others, argument: sympy.Integer(sign)}) for sign in (1, -1)]


def _solved(graph: str, law: LawValue) -> list[LawValue]:
    """Laws that solve a loop, the last of them for the symbol of the law."""
    looped = _affine(law, [law.symbol])
    if looped is not None:
        argument, rest, (gain,) = looped
        if law.solution is not None:
            own, formula = law.solution
            steps = [_step(law, "a", rest), _step(law, "g", gain)]
            here = {**dict(law.arguments), argument: steps[0].symbol, own: steps[1].symbol}
            return [*steps, replace(law, value=formula.xreplace(here))]
        at_rest = {symbol: expression for symbol, expression in law.arguments if symbol != argument} | {argument: rest}
        slope = law.formula.diff(argument).xreplace(at_rest)
        return [replace(law, value=law.formula.xreplace(at_rest) / (1 - gain * slope))]
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
        one, two = (formula.xreplace({**point, argument: factor * size}) for factor in (1, 3))
        if abs(two - 3 * one) > 1e-9 * (abs(two) + abs(one)):
            return False
    return True
