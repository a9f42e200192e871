"""SymPy expressions as Python text over an array namespace; imported when code is made, as SymPy is slow to import."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import sympy
from sympy.printing.pycode import AbstractPythonCodePrinter

from infinivar.bondgraph.graph import BondGraphError
from infinivar.bondgraph.namespaces import FUNCTIONS
from infinivar.bondgraph.trace import Called

_ATOM = 1000
"""Precedence of names and numbers: anything else gets parentheses."""

_HALF = sympy.Rational(1, 2)


def printer(names: Mapping[sympy.Symbol, str]) -> Callable[[Any], str]:
    """Function that prints an expression of the named symbols."""
    made = _Printer(names)
    return lambda expression: str(made.doprint(expression))


class _Printer(AbstractPythonCodePrinter):
    """Prints expressions as Python over the names of an array namespace; SymPy calls a method by the kind of expression."""

    def __init__(self, names: Mapping[sympy.Symbol, str]) -> None:
        super().__init__()
        self._names = names

    def _print_Symbol(self, expr: Any) -> str:  # noqa: N802
        return self._names[expr]

    _print_Dummy = _print_Symbol  # noqa: N815

    def _print_Piecewise(self, expr: Any) -> str:  # pyright: ignore[reportIncompatibleMethodOverride]  # noqa: N802
        *first, (last, _) = expr.args
        text = self._print(last)
        for value, condition in reversed(first):
            text = f"where({self._print(condition)}, {self._print(value)}, {text})"
        return text

    def _print_Pow(self, expr: Any, rational: bool = False) -> str:  # noqa: N802
        base, exponent = expr.args
        if exponent == _HALF:
            return f"sqrt({self._print(base)})"
        if exponent == -_HALF:
            return f"(1.0/sqrt({self._print(base)}))"
        inner = self.parenthesize(base, _ATOM, strict=True)
        if exponent == 2:
            return f"({inner}*{inner})"
        if exponent == -1:
            return f"(1.0/{inner})"
        return f"({inner}**{self.parenthesize(exponent, _ATOM, strict=True)})"

    # CasADi has comparisons, but neither & nor | of them; products and sums are the same for booleans.
    def _print_And(self, expr: Any) -> str:  # noqa: N802
        return "*".join(f"({self._print(part)})" for part in expr.args)

    def _print_Or(self, expr: Any) -> str:  # noqa: N802
        return f"({' + '.join(f'({self._print(part)})' for part in expr.args)}) > 0"

    def _print_Rational(self, expr: Any) -> str:  # noqa: N802
        return f"({expr.p}/{expr.q})"

    def _print_Float(self, expr: Any) -> str:  # noqa: N802
        return repr(float(expr))

    def _print_Integer(self, expr: Any) -> str:  # noqa: N802
        return f"{int(expr)}.0"

    def _print_Abs(self, expr: Any) -> str:  # noqa: N802
        return f"abs({self._print(expr.args[0])})"

    def _print_Function(self, expr: Any) -> str:  # noqa: N802
        known = type(expr).__name__
        if known not in FUNCTIONS and not isinstance(expr, Called):
            raise BondGraphError(f"the function {known} in a law has no name in the array namespace")
        return f"{known}({', '.join(map(self._print, expr.args))})"
