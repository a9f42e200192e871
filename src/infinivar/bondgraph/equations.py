"""Equations of a bond graph: explicit state space, every effort and flow, every power, as SymPy expressions.

States are the flows of the independent inertias, the displacements of the independent compliances, and the integral
signals. The effort of a dependent storage is proportional to state derivatives, which then follow from a linear system that
is solved exactly. Values of laws remain symbols, for readable equations; their expressions are listed in order of evaluation.

Source: karnopp2012, chapter 5.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import Any, Literal

import sympy

from infinivar.bondgraph.causality import assign
from infinivar.bondgraph.graph import SOURCES, STORAGES, Bond, BondGraph, BondGraphError, Element, Signal
from infinivar.bondgraph.loops import LawValue, ordered
from infinivar.bondgraph.state_space import Equations, Expression, State
from infinivar.bondgraph.trace import Parts, trace

_MOST_EXPLICIT = 3
"""Most coupled rates that are solved by one expression each; its length grows with the factorial of their number."""

_FEW = 20
"""Most operations of an expression without a name in the solution of a loop, which expands products."""


def derive(graph: BondGraph) -> Equations:
    """Equations of a complete graph.

    Parameters
    ----------
    graph : BondGraph

    Returns
    -------
    Equations

    Raises
    ------
    BondGraphError
        If the graph has no consistent causality (see `infinivar.bondgraph.causality.assign`), an algebraic loop has no exact
        solution, or a dependent storage depends on the law of a resistance; the message names the elements.
    """
    return _Derivation(graph).run()


def _symbol(latex: str) -> sympy.Symbol:
    return sympy.Symbol(latex, real=True)


def _plain_name(name: str) -> str:
    return name.replace("_", r"\_")


class _Derivation:
    def __init__(self, graph: BondGraph) -> None:
        self.graph = graph
        self.causality = assign(graph)
        self.element = {element.name: element for element in graph.elements}
        self.at = {name: graph.bonds_of(name) for name in self.element}
        self.signal = {signal.name: signal for signal in graph.signals}
        self.known: dict[tuple[Bond, str], Expression] = {}
        self.underway: set[tuple[Bond, str]] = set()
        self.cuts: dict[sympy.Symbol, Expression] = {}
        self.outputs: dict[str, tuple[sympy.Symbol, ...]] = {}
        self.rates: dict[str, sympy.Symbol] = {}
        self.numbers = itertools.count(1)
        self.parts = Parts(self.numbers)
        self.part_of: dict[sympy.Symbol, str] = {}
        self.slopes: dict[tuple[sympy.Symbol, sympy.Symbol], Expression] = {}
        self.inputs = {
            **{e.name: _symbol(e.symbol) for e in graph.elements if e.kind in SOURCES and e.law is None},
            **{signal.name: _symbol(signal.symbol) for signal in graph.signals if not signal.of},
        }
        self.states = self._states()
        self._check_symbols()
        self.state_of = {state.name: state.symbol for state in self.states}
        # Dummies: the rate of an angle and the flow of its shaft have the same name but are separate unknowns.
        self.rate_of = {state.symbol: sympy.Dummy(f"\\dot{{{state.symbol.name}}}", real=True) for state in self.states}

    def _states(self) -> tuple[State, ...]:
        states: list[State] = []
        taken: set[str] = {symbol.name for symbol in self.inputs.values()}
        for name in self.causality.independent:
            (bond,) = self.at[name]
            at = self.element[bond.tail]
            required = at.symbol if (self.element[name].kind, at.kind) == ("I", "1") else ""
            if not required or required in taken:
                letter = "f" if self.element[name].kind == "I" else "q"
                required = f"{letter}_{{{_plain_name(name)}}}"
            taken.add(required)
            states.append(State(_symbol(required), name, "flow" if self.element[name].kind == "I" else "displacement"))
        states += [State(_symbol(s.symbol), s.name, "signal") for s in self.graph.signals if s.of and s.integral]
        return tuple(states)

    def _check_symbols(self) -> None:
        """Every symbol must have one meaning: terms with a shared symbol would be added silently."""
        meanings: dict[str, str] = {}
        for what, names in (
            ("a parameter", list(self.graph.parameters)),
            ("an input", [symbol.name for symbol in self.inputs.values()]),
            ("a state", [state.symbol.name for state in self.states]),
        ):
            for name in names:
                if name in meanings:
                    raise BondGraphError(
                        f"{self.graph.name}: the symbol {name} is used for {meanings[name]} and for {what}; rename one"
                    )
                meanings[name] = what

    def run(self) -> Equations:
        derivatives = [self._rate(state) for state in self.states]
        for bond in self.graph.bonds:  # finds every law on the way
            self.effort(bond)
            self.flow(bond)
        signals = {name: self.signal_value(name) for name in self.signal}
        solved = self._solve(derivatives)

        def plain(expression: Expression) -> Expression:
            return expression.xreplace(solved)

        laws = self._law_values(plain)
        efforts = {bond: plain(self.effort(bond)) for bond in self.graph.bonds}
        flows = {bond: plain(self.flow(bond)) for bond in self.graph.bonds}
        power = self._powers(efforts, flows)
        stored = {e.name: plain(self._stored(e)) for e in self.graph.elements if e.kind in STORAGES}
        losses = {
            e.name: self._losses(e, power, flows, plain)
            for e in self.graph.elements
            if e.kind == "R" or (e.kind in SOURCES and e.losses is not None)
        }
        return Equations(
            graph=self.graph,
            causality=self.causality,
            states=self.states,
            derivatives=tuple(plain(self.rate_of[state.symbol]) for state in self.states),
            inputs=self.inputs,
            rates=self.rates,
            laws=ordered(self.graph.name, [*self._part_values(plain), *laws]),
            efforts=efforts,
            flows=flows,
            signals={name: plain(value) for name, value in signals.items()},
            stored=stored,
            power=power,
            losses=losses,
        )

    def _powers(self, efforts: Mapping[Bond, Expression], flows: Mapping[Bond, Expression]) -> dict[str, Expression]:
        """Power that each source gives, and that each storage and resistance takes."""

        def taken(name: str) -> Expression:
            return sum(efforts[bond] * flows[bond] * (1 if bond.head == name else -1) for bond in self.at[name])

        powers = {e.name: taken(e.name) for e in self.graph.elements if e.kind in (*SOURCES, *STORAGES, "R")}
        return {name: -power if self.element[name].kind in SOURCES else power for name, power in powers.items()}

    # Efforts and flows, each computed from the end that determines it.

    def effort(self, bond: Bond) -> Expression:
        return self._variable(bond, "effort", bond.other(self.causality.stroke[bond]))

    def flow(self, bond: Bond) -> Expression:
        return self._variable(bond, "flow", self.causality.stroke[bond])

    def _variable(self, bond: Bond, what: str, decider: str) -> Expression:
        key = (bond, what)
        if key in self.known:
            return self.known[key]
        if key in self.underway:  # an algebraic loop: cut it here
            cut = sympy.Dummy(f"z_{{{len(self.cuts) + 1}}}", real=True)
            self.cuts[cut] = sympy.Integer(0)  # until its value is known
            self.known[key] = cut
            return cut
        self.underway.add(key)
        value = self._decided(self.element[decider], bond, what)
        self.underway.discard(key)
        if key in self.known:
            self.cuts[self.known[key]] = value
        return self.known.setdefault(key, value)

    def _decided(self, element: Element, bond: Bond, what: str) -> Expression:
        name, kind = element.name, element.kind
        if kind in ("0", "1"):
            return self._junction(element, bond, what)
        if kind in SOURCES:
            return self.inputs[name] if element.law is None else self._traced(element)
        if kind in ("TF", "GY"):
            return self._two_port(element, bond, what)
        if element.law is not None:  # of an R or C
            return self._law_symbols(element)[self.at[name].index(bond)]
        assert element.parameter is not None
        value = _symbol(element.parameter.symbol)
        if kind == "R":
            return value * self.flow(bond) if what == "effort" else self.effort(bond) / value
        state = self.state_of.get(name)
        if kind == "I":
            return state if state is not None else value * self._time_derivative(self.flow(bond), name)
        return state / value if state is not None else value * self._time_derivative(self.effort(bond), name)

    def _junction(self, element: Element, bond: Bond, what: str) -> Expression:
        common, variable = ("effort", self.effort) if element.kind == "0" else ("flow", self.flow)
        if what == common:
            return variable(self._strong(element))
        balanced = self.flow if element.kind == "0" else self.effort

        def sign(at: Bond) -> int:
            return 1 if at.head == element.name else -1

        others = (sign(other) * balanced(other) for other in self.at[element.name] if other != bond)
        return -sign(bond) * sum(others, sympy.Integer(0))

    def _strong(self, element: Element) -> Bond:
        """The bond that determines the common quantity of a junction."""
        into = element.kind == "0"
        return next(b for b in self.at[element.name] if self.causality.effort_into(b, element.name) == into)

    def _two_port(self, element: Element, bond: Bond, what: str) -> Expression:
        modulus = self._modulus(element)
        (first,) = [b for b in self.at[element.name] if b.head == element.name]
        (second,) = [b for b in self.at[element.name] if b.tail == element.name]
        if element.kind == "TF":
            if what == "effort":
                return modulus * self.effort(second) if bond == first else self.effort(first) / modulus
            return self.flow(second) / modulus if bond == first else modulus * self.flow(first)
        other = second if bond == first else first
        return modulus * self.flow(other) if what == "effort" else self.effort(other) / modulus

    def _modulus(self, element: Element) -> Expression:
        if element.parameter is not None:
            return _symbol(element.parameter.symbol)
        return self._short(self._traced(element), element.name)

    def _short(self, expression: Expression, element: str) -> Expression:
        """A symbol for an expression with roots, many terms, or cases such as a table's: no solution of a loop expands it."""
        rational = all(power.exp.is_integer for power in expression.atoms(sympy.Pow))
        if rational and not expression.has(sympy.Piecewise) and expression.count_ops() <= _FEW:
            return expression
        symbol = self.parts.named(expression)
        self.part_of.setdefault(symbol, element)
        return symbol

    def _traced(self, element: Element) -> Expression:
        """Value of a law of signals."""
        assert element.law is not None
        return self._of(element, element.law, *(self.signal_value(signal) for signal in element.signals))

    def _of(self, element: Element, law: Any, *arguments: Expression, **named: Expression) -> Any:
        """A function of an element at expressions of the graph; its large parts become those of the equations."""
        value = trace(law, *arguments, parts=self.parts, **named, **self._parameters(element))
        for symbol in self.parts.found:
            self.part_of.setdefault(symbol, element.name)
        return value

    def _part_values(self, plain: Any) -> list[LawValue]:
        values = [(symbol, plain(value)) for symbol, value in self.parts.found.items()]
        return [LawValue(symbol, self.part_of[symbol], (), value, value) for symbol, value in values]

    @staticmethod
    def _parameters(element: Element) -> dict[str, Any]:
        return {name: _symbol(given.symbol) for name, given in element.parameters.items()}

    def signal_value(self, name: str) -> Expression:
        signal = self.signal[name]
        if not signal.of:
            return self.inputs[name]
        return self.state_of[name] if signal.integral else self._measured(signal)

    def _measured(self, signal: Signal) -> Expression:
        element = self.element[signal.of]
        if element.kind in ("0", "1"):
            strong = self._strong(element)
            return self.effort(strong) if element.kind == "0" else self.flow(strong)
        bond = next(b for b in self.at[element.name] if element.kind in SOURCES or b.head == element.name)
        return self.effort(bond) if element.kind in ("TF", "GY") else self.flow(bond)

    def _law_symbols(self, element: Element) -> tuple[sympy.Symbol, ...]:
        if element.name not in self.outputs:
            count = len(self.at[element.name])
            # The value gets the element's symbol, unless a parameter has it.
            letter = "f" if element.of_effort else "e"
            base = element.symbol or f"{letter}_{{{_plain_name(element.name)}}}"
            taken = {
                *self.graph.parameters,
                *(s.name for s in self.inputs.values()),
                *(s.symbol.name for s in self.states),
            }
            base = f"{letter}_{{{base}}}" if base in taken else base
            names = [base] if count == 1 else [f"{{{base}}}_{{{port}}}" for port in range(1, count + 1)]
            self.outputs[element.name] = tuple(_symbol(name) for name in names)
        return self.outputs[element.name]

    def _time_derivative(self, expression: Expression, element: str) -> Expression:
        springs = {self._law_symbols(self.element[n])[0]: n for n in self.outputs if self.element[n].kind == "C"}
        laws = {symbol for symbols in self.outputs.values() for symbol in symbols} - set(springs)
        if self._reached(expression) & (laws | set(self.cuts)):
            raise BondGraphError(
                f"{self.graph.name}: the dependent storage {element!r} depends on a quantity that a resistance determines; "
                f"add a storage for that quantity"
            )
        inner = {effort: (self._of_state(name, "law"), name) for effort, name in springs.items()}
        inner |= {symbol: (value, self.part_of[symbol]) for symbol, value in self.parts.found.items()}
        total = sympy.Integer(0)
        for state, rate in self.rate_of.items():
            total += self._slope(expression, state, inner) * rate
        for name, symbol in self.inputs.items():
            slope = expression.diff(symbol)
            if slope != 0:
                rate = self.rates.setdefault(name, sympy.Symbol(f"\\dot{{{symbol.name}}}", real=True))
                total += slope * rate
        return total

    def _reached(self, expression: Expression) -> set[sympy.Symbol]:
        """Symbols that an expression depends on, directly or through parts."""
        reached, fresh = set(), expression.free_symbols
        while fresh:
            reached |= fresh
            fresh = set().union(*(self.parts.found[s].free_symbols for s in fresh & set(self.parts.found))) - reached
        return reached

    def _slope(
        self, expression: Expression, state: sympy.Symbol, inner: Mapping[sympy.Symbol, tuple[Expression, str]]
    ) -> Expression:
        """Derivative of an expression by a state, through the symbols that stand for the `inner` expressions of elements."""
        total = expression.diff(state)
        for symbol in sorted(expression.free_symbols & set(inner), key=str):
            if (symbol, state) not in self.slopes:
                value, element = inner[symbol]
                self.slopes[symbol, state] = self._short(self._slope(value, state, inner), element)
            total += expression.diff(symbol) * self.slopes[symbol, state]
        return total

    def _rate(self, state: State) -> Expression:
        if state.kind == "signal":
            return self._measured(self.signal[state.name])
        (bond,) = self.at[state.name]
        if state.kind == "displacement":
            return self.flow(bond)
        parameter = self.element[state.name].parameter
        assert parameter is not None
        return self.effort(bond) / _symbol(parameter.symbol)

    def _solve(self, derivatives: Sequence[Expression]) -> dict[sympy.Symbol, Expression]:
        """Rates of states and cut variables, from the linear equations that couple them."""
        equations = {self.rate_of[state.symbol]: d for state, d in zip(self.states, derivatives, strict=True)}
        equations |= self.cuts
        unknown = list(equations)
        coupled = {symbol for value in equations.values() for symbol in value.free_symbols & set(unknown)}
        solved: dict[sympy.Symbol, Expression] = {}
        remaining = [symbol for symbol in unknown if symbol in coupled]
        if remaining:
            residuals = [symbol - equations[symbol] for symbol in remaining]
            matrix, right = sympy.linear_eq_to_matrix(residuals, remaining)
            if len(remaining) > _MOST_EXPLICIT:
                solved |= dict(zip(remaining, self._eliminated(matrix, right), strict=True))
                remaining = []
            elif matrix.det() == 0:
                names = ", ".join(self.causality.looped or self.causality.dependent)
                raise BondGraphError(f"{self.graph.name}: the algebraic loop through {names} has no unique solution")
            if remaining:
                for symbol, value in zip(remaining, matrix.LUsolve(right), strict=True):
                    solved[symbol] = _tidy(value)
        for symbol in unknown:
            if symbol not in coupled:
                solved[symbol] = equations[symbol].xreplace(dict(solved))
        return solved

    def _eliminated(self, matrix: Any, right: Any) -> list[Expression]:
        """Solution of many linear equations by elimination, with a name for every intermediate value.

        The equations are those of inertias, whose diagonal does not vanish on the way.
        """
        element = next(iter((*self.causality.dependent, *self.causality.looped)), "")

        def named(value: Expression) -> Expression:
            if value.is_Atom:
                return value
            symbol = self.parts.named(value)
            self.part_of.setdefault(symbol, element)
            return symbol

        size = len(right)
        rows = [[named(matrix[i, j]) for j in range(size)] + [named(right[i])] for i in range(size)]
        for pivot in range(size):
            for row in range(pivot + 1, size):
                factor = named(rows[row][pivot] / rows[pivot][pivot])
                if factor != 0:
                    for column in range(pivot + 1, size + 1):
                        rows[row][column] = named(rows[row][column] - factor * rows[pivot][column])
        found: list[Expression] = [sympy.Integer(0)] * size
        for row in reversed(range(size)):
            known = sum((rows[row][column] * found[column] for column in range(row + 1, size)), sympy.Integer(0))
            found[row] = named((rows[row][size] - known) / rows[row][row])
        return found

    def _law_values(self, plain: Any) -> list[LawValue]:
        values = []
        for name, symbols in self.outputs.items():
            element = self.element[name]
            assert element.law is not None
            at_ports = self._at_ports(element)
            given = [*at_ports, *map(self.signal_value, element.signals)]
            arguments = self._argument_symbols(element, len(symbols))
            parts = Parts(self.numbers)
            formula = trace(element.law, *arguments, parts=parts, **self._parameters(element))
            formulas = formula if isinstance(formula, tuple) else (formula,)
            pairs = tuple(zip(arguments, map(plain, given), strict=True))
            solution = None
            if element.solved is not None:
                gain = sympy.Dummy("g", real=True)
                solution = gain, trace(element.solved, *arguments, gain=gain, **self._parameters(element))
            for symbol, one in zip(symbols, formulas, strict=True):
                value = one.xreplace(dict(pairs))
                values.append(LawValue(symbol, name, pairs, one, value, solution, tuple(parts.found.items())))
        return values

    def _at_ports(self, element: Element) -> list[Expression]:
        """What the law of an element receives at its ports: flows, efforts, or the displacement of a compliance."""
        if element.kind == "C":
            return [self.state_of[element.name]]
        return [self.effort(bond) if element.of_effort else self.flow(bond) for bond in self.at[element.name]]

    def _of_state(self, name: str, what: Literal["law", "energy"]) -> Expression:
        """Law or energy of a compliance as an expression of its displacement."""
        element = self.element[name]
        return self._of(element, getattr(element, what), self.state_of[name])

    def _argument_symbols(self, element: Element, ports: int) -> tuple[sympy.Symbol, ...]:
        # Dummies: a parameter of the law may have the same symbol.
        letter = "q" if element.kind == "C" else "e" if element.of_effort else "w"
        flows = [letter] if ports == 1 else [f"{letter}_{port}" for port in range(1, ports + 1)]
        names = (*flows, *(self.signal[name].symbol for name in element.signals))
        return tuple(sympy.Dummy(name, real=True) for name in names)

    def _losses(
        self, element: Element, power: Mapping[str, Expression], flows: Mapping[Bond, Expression], plain: Any
    ) -> dict[str, Expression]:
        if element.losses is None:
            return {element.title: power[element.name]}
        if element.kind in SOURCES:
            return self._of(element, element.losses, power[element.name])
        bonds = self.at[element.name]
        symbols = self._law_symbols(element)
        given = [*(flows[bond] for bond in bonds), *(plain(self.signal_value(name)) for name in element.signals)]
        effort = symbols[0] if len(symbols) == 1 else symbols
        return self._of(element, element.losses, *given, effort=effort)

    def _stored(self, element: Element) -> Expression:
        (bond,) = self.at[element.name]
        if element.law is not None:
            return self._of_state(element.name, "energy")
        assert element.parameter is not None
        value = _symbol(element.parameter.symbol)
        if element.kind == "I":
            return value * self.flow(bond) ** 2 / 2
        return value * self.effort(bond) ** 2 / 2


def _tidy(value: Expression) -> Expression:
    """A fraction with the dependent inertias collected in its denominator."""
    numerator, denominator = sympy.fraction(sympy.together(value))
    return sympy.expand(numerator) / sympy.factor_terms(sympy.expand(denominator))
