"""Code from equations: one source text over an array namespace, for plain floats, NumPy, JAX and CasADi alike.

The text is a function of a namespace that returns a function; what it computes is decided by the list of expressions it
is made for. Common subexpressions are computed once.
"""

from __future__ import annotations

import ast
import functools
import math
import re
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from infinivar.bondgraph.graph import BondGraphError

if TYPE_CHECKING:
    import sympy

    from infinivar.bondgraph.equations import Equations


class FloatNamespace:
    """The functions that generated code calls, on plain floats: several times as fast as NumPy on scalars."""

    where = clip = None  # `compiled` writes them as choices
    sign = staticmethod(lambda value: (value > 0) - (value < 0))
    abs, sqrt, exp, log = abs, math.sqrt, math.exp, math.log
    sin, cos, tan, asin, acos, atan, tanh = math.sin, math.cos, math.tan, math.asin, math.acos, math.atan, math.tanh


def casadi_namespace() -> Any:
    """The functions that generated code calls, on CasADi expressions.

    Raises
    ------
    ImportError
        If CasADi is not installed.
    """
    import casadi

    class CasadiNamespace:
        where, sign = staticmethod(casadi.if_else), casadi.sign
        clip = staticmethod(lambda value, low, high: casadi.fmin(casadi.fmax(value, low), high))
        abs, sqrt, exp, log = casadi.fabs, casadi.sqrt, casadi.exp, casadi.log
        sin, cos, tan, asin, acos = casadi.sin, casadi.cos, casadi.tan, casadi.asin, casadi.acos
        atan, tanh = casadi.atan, casadi.tanh

    return CasadiNamespace


def source(equations: Equations, wanted: Mapping[str, Any], name: str = "equations") -> str:
    """Text of a module with one function ``make(xp, parameters)``, which returns ``name(states, inputs, rates)``.

    Parameters
    ----------
    equations : Equations
    wanted : mapping of str to SymPy expression   What the function returns, in this order.
    name : str                                    Of the inner function.

    Returns
    -------
    str   Python. `parameters` is a mapping from symbols to values; states, inputs and rates of inputs are sequences in
        the order of `equations`; the result is a tuple.
    """
    import sympy

    # Every law once, under its own symbol, then what is wanted; what depends on parameters only is done once for all,
    # shared terms are found across all of them.
    parameters = [sympy.Symbol(symbol, real=True) for symbol in equations.graph.parameters]
    constants = _Constants(set(parameters))
    values = [constants.out_of(value) for value in (*(law.value for law in equations.laws), *wanted.values())]
    shared, found = sympy.cse(values, symbols=sympy.numbered_symbols("x_"), order="none")
    reduced: list[Any] = list(found)
    laws = [(law.symbol, value) for law, value in zip(equations.laws, reduced, strict=False)]
    expressions = reduced[len(laws) :]

    states = [state.symbol for state in equations.states]
    inputs, rates = list(equations.inputs.values()), list(equations.rates.values())
    print_ = _printer(
        {symbol: f"s{i}" for i, symbol in enumerate(states)}
        | {symbol: f"u{i}" for i, symbol in enumerate(inputs)}
        | {symbol: f"du{i}" for i, symbol in enumerate(rates)}
        | {symbol: f"p{i}" for i, symbol in enumerate(parameters)}
        | {symbol: f"law{i}" for i, (symbol, _) in enumerate(laws)}
        | {symbol: f"x{i}" for i, (symbol, _) in enumerate(shared)}
        | {symbol: f"c{i}" for i, symbol in enumerate(constants.found.values())}
    )

    needed: set[Any] = set().union(*(result.free_symbols for result in expressions))
    steps = _in_order([*shared, *laws], needed)
    body = [f"{print_(symbol)} = {print_(value)}" for symbol, value in steps]
    before = [f"{print_(symbol)} = {print_(value)}" for value, symbol in constants.found.items()]
    used = set().union(needed, *(value.free_symbols for value in (*constants.found, *(value for _, value in steps))))
    results = [print_(result) for result in expressions]
    called = set(re.findall(r"\b([a-z]+)\(", " ".join([*before, *body, *results])))
    lines = [
        "def make(xp, parameters):",
        *(f"    {function} = xp.{function}" for function in _FUNCTIONS if function in called),
        *(f"    p{i} = parameters[{symbol.name!r}]" for i, symbol in enumerate(parameters) if symbol in used),
        *(f"    {line}" for line in before),
        f"    def {name}(states, inputs, rates):",
        *_unpack("s", states, "states"),
        *_unpack("u", inputs, "inputs"),
        *_unpack("du", rates, "rates"),
        *(f"        {line}" for line in body),
        f"        return ({' '.join(f'{result},' for result in results)})",
        f"    return {name}",
        "",
    ]
    return "\n".join(lines)


@functools.lru_cache(maxsize=64)
def compiled(
    text: str, *, floats: bool = False
) -> Callable[[Any, Mapping[str, float]], Callable[..., tuple[Any, ...]]]:
    """The function `make` of a text from `source`; for plain floats its choices become those of Python, which is faster."""
    tree = ast.parse(text)
    if floats:
        tree = ast.fix_missing_locations(_Choices().visit(tree))
    space: dict[str, Any] = {}
    exec(compile(tree, "<equations of a bond graph>", "exec"), space)
    return space["make"]


class _Choices(ast.NodeTransformer):
    """``where(c, a, b)`` as ``a if c else b``, and ``clip(x, low, high)`` likewise."""

    def visit_Call(self, node: ast.Call) -> ast.AST:
        self.generic_visit(node)
        name = node.func.id if isinstance(node.func, ast.Name) else ""
        if name == "where":
            return ast.IfExp(*node.args)
        if name != "clip":
            return node
        value, low, high = node.args
        named = ast.NamedExpr(ast.Name("clipped", ast.Store()), value)
        kept = ast.Name("clipped", ast.Load())
        above = ast.IfExp(ast.Compare(kept, [ast.Gt()], [high]), high, kept)
        return ast.IfExp(ast.Compare(named, [ast.Lt()], [low]), low, above)


def _unpack(letter: str, symbols: Sequence[Any], source: str) -> list[str]:
    return [f"        {''.join(f'{letter}{i}, ' for i in range(len(symbols)))}= {source}"] if symbols else []


def _in_order(steps: Sequence[tuple[Any, Any]], needed: set[Any]) -> list[tuple[Any, Any]]:
    """Those of the steps that are needed, each after those it needs."""
    by_symbol = dict(steps)
    done: dict[Any, Any] = {}

    def visit(symbol: Any) -> None:
        if symbol in by_symbol and symbol not in done:
            for inner in sorted(by_symbol[symbol].free_symbols, key=str):
                visit(inner)
            done[symbol] = by_symbol[symbol]

    for symbol in sorted(needed, key=str):
        visit(symbol)
    return list(done.items())


class _Constants:
    """Takes out of expressions what depends on parameters only: whole subexpressions, factors and terms."""

    def __init__(self, parameters: set[Any]) -> None:
        self.parameters = parameters
        self.found: dict[Any, Any] = {}

    def out_of(self, expression: Any) -> Any:
        if self.constant(expression):
            return self.named(expression)
        if not expression.args or not expression.free_symbols & self.parameters:
            return expression
        if expression.is_Mul or expression.is_Add:
            fixed = [part for part in expression.args if self.constant(part)]
            rest = [self.out_of(part) for part in expression.args if part not in fixed]
            return expression.func(self.named(expression.func(*fixed)), *rest) if fixed else expression.func(*rest)
        return expression.func(
            *map(self.out_of, expression.args), **({"evaluate": False} if expression.is_Piecewise else {})
        )

    def constant(self, expression: Any) -> bool:
        import sympy

        return isinstance(expression, sympy.Expr) and not expression.free_symbols - self.parameters

    def named(self, expression: Any) -> Any:
        import sympy

        if expression.is_Atom:
            return expression
        # A name that nobody gives, and the same every time: code should not change from run to run.
        return self.found.setdefault(expression, sympy.Symbol(f"constant {len(self.found)}", real=True))


_ATOM = 1000
"""Precedence of names and numbers: anything else gets parentheses."""

_FUNCTIONS = ("where", "clip", "abs", "sign", "sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan", "tanh")


def _printer(names: Mapping[sympy.Symbol, str]) -> Callable[[Any], str]:
    """Prints expressions as Python over the names of an array namespace."""
    import sympy
    from sympy.printing.pycode import AbstractPythonCodePrinter

    half = sympy.Rational(1, 2)

    class Printer(AbstractPythonCodePrinter):
        def _print_Symbol(self, expr: Any) -> str:  # noqa: N802
            return names[expr]

        def _print_Piecewise(self, expr: Any) -> str:  # pyright: ignore[reportIncompatibleMethodOverride]  # noqa: N802
            *first, (last, _) = expr.args
            text = self._print(last)
            for value, condition in reversed(first):
                text = f"where({self._print(condition)}, {self._print(value)}, {text})"
            return text

        def _print_Pow(self, expr: Any, rational: bool = False) -> str:  # noqa: N802
            base, exponent = expr.args
            if exponent == half:
                return f"sqrt({self._print(base)})"
            if exponent == -half:
                return f"(1.0/sqrt({self._print(base)}))"
            inner = self.parenthesize(base, _ATOM, strict=True)
            if exponent == 2:
                return f"({inner}*{inner})"
            if exponent == -1:
                return f"(1.0/{inner})"
            return f"({inner}**{self.parenthesize(exponent, _ATOM, strict=True)})"

        def _print_And(self, expr: Any) -> str:  # noqa: N802
            return " & ".join(f"({self._print(part)})" for part in expr.args)

        def _print_Or(self, expr: Any) -> str:  # noqa: N802
            return " | ".join(f"({self._print(part)})" for part in expr.args)

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
            if known not in _FUNCTIONS:
                raise BondGraphError(f"the function {known} in a law has no name in the array namespace")
            return f"{known}({', '.join(map(self._print, expr.args))})"

    printer = Printer()
    return lambda expression: str(printer.doprint(expression))
