"""Code generated from equations: one source text over an array namespace, for plain floats, NumPy, JAX and CasADi.

The text defines a function of a namespace that returns a function, which computes a list of expressions. Common
subexpressions are computed once.
"""

from __future__ import annotations

import ast
import functools
import re
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from infinivar.bondgraph.namespaces import FUNCTIONS

if TYPE_CHECKING:
    from infinivar.bondgraph.state_space import Equations


def source(equations: Equations, outputs: Mapping[str, Any], name: str = "equations") -> str:
    """Text of a module with one function ``make(xp, parameters)``, which returns ``name(states, inputs, rates)``.

    Parameters
    ----------
    equations : Equations
    outputs : mapping of str to SymPy expression   What the function returns, in this order.
    name : str                                    Of the inner function.

    Returns
    -------
    str   Python. `parameters` is a mapping from symbols to values; states, inputs and rates of inputs are sequences in
        the order of `equations`; the result is a tuple.
    """
    import sympy

    from infinivar.bondgraph.printing import printer

    parameters = [sympy.Symbol(symbol, real=True) for symbol in equations.graph.parameters]
    reduced = _reduced(equations, outputs, parameters)
    states = [state.symbol for state in equations.states]
    inputs, rates = list(equations.inputs.values()), list(equations.rates.values())
    text = printer(
        _numbered(
            s=states,
            u=inputs,
            du=rates,
            p=parameters,
            law=list(dict(reduced.laws)),
            x=list(dict(reduced.shared)),
            c=list(dict(reduced.constants)),
        )
    )
    needed: set[Any] = set().union(*(result.free_symbols for result in reduced.results))
    steps = _in_order([*reduced.shared, *reduced.laws], needed)
    once = [f"{text(symbol)} = {text(value)}" for symbol, value in reduced.constants]
    body = [f"{text(symbol)} = {text(value)}" for symbol, value in steps]
    results = [text(result) for result in reduced.results]
    used = needed.union(*(value.free_symbols for _, value in (*reduced.constants, *steps)))
    lines = [
        "def make(xp, parameters):",
        *(f"    from {module} import {name}" for module, name in _imported(reduced)),
        *(f"    {function} = xp.{function}" for function in _called([*once, *body, *results])),
        *(f"    p{i} = parameters[{symbol.name!r}]" for i, symbol in enumerate(parameters) if symbol in used),
        *(f"    {line}" for line in once),
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


_Step: TypeAlias = tuple[Any, Any]
"""A symbol and the expression that it stands for."""


class _Reduced(NamedTuple):
    """Expressions cut into steps: those of parameters only, those shared by several, the laws, and the outputs."""

    constants: list[_Step]
    shared: list[_Step]
    laws: list[_Step]
    results: list[Any]


def _reduced(equations: Equations, required: Mapping[str, Any], parameters: Sequence[Any]) -> _Reduced:
    """Every law once, under its own symbol, then the outputs; shared terms are found across all of them."""
    import sympy

    constants = _Constants(set(parameters))
    values = [constants.out_of(value) for value in (*(law.value for law in equations.laws), *required.values())]
    shared, found = sympy.cse(values, symbols=sympy.numbered_symbols("x_"), order="none")
    rest: list[Any] = list(found)
    laws = [(law.symbol, value) for law, value in zip(equations.laws, rest, strict=False)]
    return _Reduced(
        [(symbol, value) for value, symbol in constants.found.items()], list(shared), laws, rest[len(laws) :]
    )


def _numbered(**groups: Sequence[Any]) -> dict[Any, str]:
    """Names of symbols in the text: the letters of their group and a number."""
    return {symbol: f"{letters}{i}" for letters, group in groups.items() for i, symbol in enumerate(group)}


def _called(lines: Sequence[str]) -> list[str]:
    """Functions of the namespace that the lines call."""
    called = set(re.findall(r"\b([a-z]+)\(", " ".join(lines)))
    return [function for function in FUNCTIONS if function in called]


def _imported(reduced: _Reduced) -> list[tuple[str, str]]:
    """Modules and names of functions of the package that the expressions call."""
    from infinivar.bondgraph.trace import Called

    steps = [value for steps in (reduced.constants, reduced.shared, reduced.laws) for _, value in steps]
    calls = set().union(*(value.atoms(Called) for value in (*steps, *reduced.results)))
    return sorted({(call.module, type(call).__name__) for call in calls})


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

    def __init__(self) -> None:
        self._clips = 0

    def visit_Call(self, node: ast.Call) -> ast.AST:
        self.generic_visit(node)
        name = node.func.id if isinstance(node.func, ast.Name) else ""
        if name == "where":
            return ast.IfExp(*node.args)
        if name != "clip":
            return node
        value, low, high = node.args
        # The bounds may contain clips as well, which must not overwrite this value.
        self._clips += 1
        named = ast.NamedExpr(ast.Name(f"clipped{self._clips}", ast.Store()), value)
        kept = ast.Name(f"clipped{self._clips}", ast.Load())
        above = ast.IfExp(ast.Compare(kept, [ast.Gt()], [high]), high, kept)
        return ast.IfExp(ast.Compare(named, [ast.Lt()], [low]), low, above)


def _unpack(letter: str, symbols: Sequence[Any], source: str) -> list[str]:
    return [f"        {''.join(f'{letter}{i}, ' for i in range(len(symbols)))}= {source}"] if symbols else []


def _in_order(steps: Sequence[tuple[Any, Any]], needed: set[Any]) -> list[tuple[Any, Any]]:
    """The required steps, each after the steps it depends on."""
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
    """Extracts from expressions the parts that depend on parameters only: subexpressions, factors and terms."""

    def __init__(self, parameters: set[Any]) -> None:
        self.parameters = parameters
        self.found: dict[Any, Any] = {}
        # Expressions share most of their parts, and SymPy collects symbols anew at each level.
        self._free: dict[Any, frozenset[Any]] = {}
        self._done: dict[Any, Any] = {}

    def out_of(self, expression: Any) -> Any:
        if expression not in self._done:
            self._done[expression] = self._without(expression)
        return self._done[expression]

    def _without(self, expression: Any) -> Any:
        if self.constant(expression):
            return self.named(expression)
        if not expression.args or not self.free(expression) & self.parameters:
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

        return isinstance(expression, sympy.Expr) and self.free(expression) <= self.parameters

    def free(self, expression: Any) -> frozenset[Any]:
        """Symbols of the expression."""
        import sympy

        if expression not in self._free:
            plain = type(expression).free_symbols is sympy.Basic.free_symbols
            found = map(self.free, expression.args) if plain else [expression.free_symbols]
            self._free[expression] = frozenset().union(*found)
        return self._free[expression]

    def named(self, expression: Any) -> Any:
        import sympy

        if expression.is_Atom:
            return expression
        # A name that no parameter can have, and a deterministic one, so that code does not change between runs.
        return self.found.setdefault(expression, sympy.Symbol(f"constant {len(self.found)}", real=True))
