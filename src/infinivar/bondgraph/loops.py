"""Values of laws, their order of evaluation, and algebraic loops between them.

A law whose argument depends on its own value forms an algebraic loop; an example is a gear with load-proportional friction
between two inertias. If the law is proportional to that argument on each side of zero, as such friction is, one Newton step
from zero is the exact solution. Several such laws that depend on each other, as of a gear and a screw in one drive, are solved
for every combination of signs; the combination whose solution has these signs is the solution. Any other law, such as friction
with a constant part and squares of the load, must state its own solution of the loop. One such law can depend on others that
are proportional: for each combination of their signs they add to what its own solution receives.
"""

from __future__ import annotations

import itertools
import random
from collections.abc import Iterable, Mapping, Sequence
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
    parts: tuple[tuple[sympy.Symbol, Any], ...] = ()
    """Named parts of the formula, each in terms of arguments and earlier parts."""

    def steps(self) -> list[LawValue]:
        """The named parts and the law, as values in order of evaluation."""
        given = dict(self.arguments)
        parts = [(symbol, part.xreplace(given)) for symbol, part in self.parts]
        return [*(LawValue(symbol, self.element, (), value, value) for symbol, value in parts), self]

    def needs(self) -> set[sympy.Symbol]:
        """Symbols that the value depends on."""
        steps = self.steps()
        found = set().union(*(step.value.free_symbols for step in steps))
        return found - {step.symbol for step in steps[:-1]}

    def whole(self) -> LawValue:
        """The law with its named parts written out."""
        formula, value = self.formula, self.value
        given = dict(self.arguments)
        for symbol, part in reversed(self.parts):
            formula, value = formula.xreplace({symbol: part}), value.xreplace({symbol: part.xreplace(given)})
        return replace(self, formula=formula, value=value, parts=())


def ordered(graph: str, laws: Iterable[LawValue]) -> tuple[LawValue, ...]:
    """Sort the laws so that each depends only on earlier ones, and solve the loops.

    Raises
    ------
    BondGraphError
        If a loop cannot be solved exactly; the message names its elements.
    """
    waiting = {law.symbol: law for law in laws}
    needs = {symbol: law.needs() for symbol, law in waiting.items()}
    done: list[LawValue] = []
    while waiting:
        ready = [law for symbol, law in waiting.items() if not needs[symbol] & (set(waiting) - {symbol})]
        joint = [] if ready else _jointly(graph, [waiting[symbol].whole() for symbol in _circle(waiting, needs)])
        for law in ready:
            done += _solved(graph, law.whole()) if law.symbol in needs[law.symbol] else law.steps()
        done += joint
        for law in (*ready, *joint):
            waiting.pop(law.symbol, None)
    return tuple(done)


def _circle(waiting: Iterable[sympy.Symbol], needs: Mapping[sympy.Symbol, set[sympy.Symbol]]) -> list[sympy.Symbol]:
    """Laws that all depend on each other, and on no other law that waits."""
    order = list(waiting)
    found = {symbol: needs[symbol] & set(order) for symbol in order}
    for _ in order:
        found = {symbol: needed.union(*(found[other] for other in needed)) for symbol, needed in found.items()}
    fewest = min(found.values(), key=len)
    return [symbol for symbol in order if symbol in fewest]


def _jointly(graph: str, laws: Sequence[LawValue]) -> list[LawValue]:
    """Solve laws that depend on each other: proportional to one argument on each side of zero, but for one of any form.

    With the arguments ``T = a + G f`` and the laws ``f_i = k_i T_i``, whose k_i has one value for each sign of T_i, the
    arguments are ``(1 - G K)^-1 a`` for one combination of signs. The law of another form, with its own solution, belongs to a
    there: its value f_0 follows from ``a_0 + G_0 K (1 - G K)^-1 a`` and the gain ``G_00 + G_0 K (1 - G K)^-1 G^0``.
    """
    symbols = [law.symbol for law in laws]
    parts = [_affine(law, symbols) for law in laws]
    other = [place for place, law in enumerate(laws) if law.solution is not None]
    if len(laws) > _MOST_JOINT or any(part is None for part in parts) or len(other) > 1:
        names = ", ".join(dict.fromkeys(law.element for law in laws))
        raise BondGraphError(f"{graph}: the laws of {names} depend on each other in an algebraic loop")
    looped = [_Looped.of(law, part) for law, part in zip(laws, parts, strict=True) if part is not None]
    straight = [place for place in range(len(laws)) if place not in other]
    steps = list(itertools.chain.from_iterable(one.steps for one in looped))
    size = len(straight)
    diagonal, right = ([sympy.Dummy() for _ in range(size)] for _ in range(2))
    coupling = sympy.Matrix(size, size, lambda *_: sympy.Dummy())
    arguments = list((sympy.eye(size) - coupling * sympy.diag(*diagonal)).LUsolve(sympy.Matrix(right)))
    gains = itertools.chain.from_iterable([looped[row].gains[column] for column in straight] for row in straight)
    known = dict(zip(coupling.flat(), gains, strict=True))
    cases: list[list[Any]] = [[] for _ in laws]
    for count, sides in enumerate(itertools.product((0, 1), repeat=size), 1):
        chosen = [looped[place].slopes[side] for place, side in zip(straight, sides, strict=True)]
        here = known | dict(zip(diagonal, chosen, strict=True))

        def solved(values: Sequence[Any], here: dict[Any, Any] = here) -> list[Any]:
            return [value.xreplace(here | dict(zip(right, values, strict=True))) for value in arguments]

        rests = [looped[place].rest for place in straight]
        for place in other:
            one = looped[place]
            passed = [one.gains[i] * slope for i, slope in zip(straight, chosen, strict=True)]
            per_value = solved([looped[i].gains[place] for i in straight])
            own = one.alone(count, _sum(one.rest, passed, solved(rests)), _sum(one.gains[place], passed, per_value))
            steps += own
            cases[place].append(own[-1].symbol)
            rests = [rest + looped[i].gains[place] * own[-1].symbol for i, rest in zip(straight, rests, strict=True)]
        found = solved(rests)
        agrees = sympy.And(*(value <= 0 if side else value >= 0 for side, value in zip(sides, found, strict=True)))
        for place, slope, value in zip(straight, chosen, found, strict=True):
            cases[place].append(slope * value)
        cases = [[*case[:-1], (case[-1], agrees)] for case in cases]
    values = [sympy.Piecewise(*case[:-1], (case[-1][0], sympy.true), evaluate=False) for case in cases]
    return [*steps, *(replace(law, value=value) for law, value in zip(laws, values, strict=True))]


@dataclass(frozen=True, slots=True)
class _Looped:
    """One of several laws that depend on each other: its argument without them, their gains, its slopes beside zero."""

    law: LawValue
    argument: Any
    rest: Any
    gains: list[Any]
    slopes: list[Any]
    steps: list[LawValue]

    @classmethod
    def of(cls, law: LawValue, affine: tuple[Any, Any, list[Any]]) -> _Looped:
        """From the result of `_affine`."""
        argument, rest, gains = affine
        steps = [_step(law, "a", rest)]
        if law.solution is None:
            steps += [_step(law, side, slope) for side, slope in zip("+-", _slopes(law, argument), strict=True)]
        return cls(law, argument, steps[0].symbol, gains, [step.symbol for step in steps[1:]], steps)

    def alone(self, case: int, rest: Any, gain: Any) -> list[LawValue]:
        """Steps to the value by the law's own solution, in one case of the others' signs."""
        steps = [_step(self.law, f"a,{case}", rest), _step(self.law, f"g,{case}", gain)]
        value = _own_solution(self.law, self.argument, *(step.symbol for step in steps))
        return [*steps, _step(self.law, f"({case})", value)]


def _sum(start: Any, factors: Sequence[Any], values: Sequence[Any]) -> Any:
    return start + sum(factor * value for factor, value in zip(factors, values, strict=True))


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
            steps = [_step(law, "a", rest), _step(law, "g", gain)]
            return [*steps, replace(law, value=_own_solution(law, argument, *(step.symbol for step in steps)))]
        at_rest = {symbol: expression for symbol, expression in law.arguments if symbol != argument} | {argument: rest}
        slope = law.formula.diff(argument).xreplace(at_rest)
        return [replace(law, value=law.formula.xreplace(at_rest) / (1 - gain * slope))]
    raise BondGraphError(
        f"{graph}: the law of {law.element!r} depends on its own value in an algebraic loop and is not proportional to "
        f"that argument; add a storage to break the loop"
    )


def _own_solution(law: LawValue, argument: Any, rest: Any, gain: Any) -> Any:
    """The law's own solution of a loop, at the argument without its effect and the argument's gain per value of the law."""
    assert law.solution is not None
    symbol, formula = law.solution
    return formula.xreplace({**dict(law.arguments), argument: rest, symbol: gain})


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
