"""Readable equations of a graph: plain text, and a LaTeX document."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from infinivar.bondgraph.graph import SOURCES, BondGraph
from infinivar.bondgraph.state_space import Equations, State
from infinivar.units import plain

_KIND = {"flow": "flow of", "displacement": "displacement of", "signal": "integral signal"}


def text(equations: Equations) -> str:
    """States, state equations, laws and parameters, one per line, with LaTeX symbols."""
    lines = [equations.graph.name, "", "States" if equations.states else "No states"]
    lines += [f"  {state.symbol.name:<16} {_meaning(equations.graph, state)}" for state in equations.states]
    lines += ["", "Inputs", *(f"  {symbol.name:<16} {name}" for name, symbol in equations.inputs.items())]
    if equations.causality.dependent:
        lines += ["", "Dependent storages (their energy follows from the states)"]
        lines += [f"  {equations.graph[name].symbol:<16} {name}" for name in equations.causality.dependent]
    lines += ["", "State equations"] if equations.states else []
    for state, derivative in zip(equations.states, equations.derivatives, strict=True):
        lines.append(f"  d/dt {state.symbol.name} = {derivative}")
    lines += ["", "Response at the sources"]
    lines += [f"  {what} of {name} = {value}" for what, name, value in _responses(equations)]
    if equations.laws:
        lines += ["", "Laws"]
        for law in equations.laws:
            given = ", ".join(f"{symbol.name} = {value}" for symbol, value in law.arguments)
            lines += [f"  {law.symbol.name} = {_named(law.formula)}", *([f"      with {given}"] if given else [])]
    lines += ["", "Parameters"]
    for symbol, parameter in equations.graph.parameters.items():
        lines.append(f"  {symbol:<20} {plain(parameter.value, 6)} {parameter.unit}".rstrip())
    return "\n".join(lines) + "\n"


def latex(equations: Equations) -> str:
    """States, state equations, laws and parameters as a LaTeX document."""
    graph = equations.graph
    lines = [
        r"\documentclass{article}",
        r"\usepackage{amsmath,longtable}",
        r"\usepackage[landscape,margin=20mm]{geometry}",
        r"\begin{document}",
        rf"\section*{{{_plain(graph.name)}}}",
    ]
    if equations.states:
        lines += [
            r"\subsection*{States}",
            *_list((state.symbol.name, _meaning(graph, state)) for state in equations.states),
            r"\subsection*{State equations}",
            *_aligned(
                (rf"\frac{{d}}{{dt}} {state.symbol.name}", _latex(value))
                for state, value in zip(equations.states, equations.derivatives, strict=True)
            ),
        ]
    if equations.inputs:
        lines += [r"\subsection*{Inputs}", *_list((symbol.name, name) for name, symbol in equations.inputs.items())]
    lines += [
        r"\subsection*{Response at the sources}",
        *_aligned(
            (rf"\text{{{what} of {_plain(name)}}}", _latex(value)) for what, name, value in _responses(equations)
        ),
    ]
    if equations.laws:
        lines += [r"\subsection*{Laws}"]
        for law in equations.laws:
            rows = [(law.symbol.name, _latex(law.formula))]
            rows += [(symbol.name, _latex(value)) for symbol, value in law.arguments]
            lines += [rf"\paragraph{{{_plain(graph[law.element].title)}}}", *_aligned(rows)]
    lines += [r"\subsection*{Parameters}", r"\begin{longtable}{lll}"]
    for symbol, parameter in graph.parameters.items():
        size = re.sub(r"e(-?\d+)$", r" \\times 10^{\1}", plain(parameter.value, 6))
        lines.append(rf"${symbol}$ & ${size}$ & {_plain(parameter.unit)} \\")
    return "\n".join([*lines, r"\end{longtable}", r"\end{document}", ""])


def _responses(equations: Equations) -> list[tuple[str, str, Any]]:
    """Response of the graph to each source: the quantity that the source does not impose."""
    found = []
    for element in equations.graph.elements:
        if element.kind in SOURCES:
            (bond,) = equations.graph.bonds_of(element.name)
            flow = element.kind == "Se"
            found.append(
                ("flow" if flow else "effort", element.name, (equations.flows if flow else equations.efforts)[bond])
            )
    return found


def _aligned(rows: Any) -> list[str]:
    return [r"\begin{align*}", " \\\\\n".join(f"{left} &= {right}" for left, right in rows), r"\end{align*}"]


def _list(rows: Any) -> Iterator[str]:
    yield r"\begin{itemize}"
    for symbol, meaning in rows:
        yield rf"\item ${symbol}$: {_plain(meaning)}"
    yield r"\end{itemize}"


def _meaning(graph: BondGraph, state: State) -> str:
    of = state.name if state.kind == "signal" else f"{graph[state.name].kind} {state.name}"
    return f"{_KIND[state.kind]} {of}"


def _named(expression: Any) -> Any:
    """Expression with plain names for the arguments of laws."""
    import sympy

    return expression.xreplace({symbol: sympy.Symbol(symbol.name) for symbol in expression.atoms(sympy.Dummy)})


def _latex(expression: Any) -> str:
    import sympy

    # Symbols are LaTeX already: the printer must not split "m_{l}".
    return sympy.latex(expression, symbol_names={symbol: symbol.name for symbol in expression.free_symbols})


def _plain(words: str) -> str:
    return words.replace("_", r"\_").replace("^", r"\textasciicircum{}").replace("%", r"\%")
