"""Tracing: convert a formula over an array namespace to a SymPy expression.

A law is called with `Traced` values, whose array namespace records every operation in SymPy. The result is the formula, used
to print equations, take derivatives and generate code.

A value that a law uses several times appears as often in the formula, so a formula of repeated steps, such as those of Newton's
method, would grow exponentially with their number. `Parts` gives a large intermediate value a name of its own.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Callable, Iterator
from typing import Any

import sympy
from sympy.core.function import ArgumentIndexError

_LARGEST = 100
"""Most operations in one part of a formula; laws of a few lines have fewer."""


class Parts:
    """Named parts of formulas: symbols, and the expressions they stand for, each in terms of earlier ones."""

    def __init__(self, numbers: Iterator[int] | None = None) -> None:
        """No parts yet; `numbers` count them, to tell parts of several formulas apart."""
        self.found: dict[sympy.Symbol, Any] = {}
        self._symbols: dict[Any, sympy.Symbol] = {}
        self._numbers = itertools.count(1) if numbers is None else numbers

    def named(self, expression: Any) -> sympy.Symbol:
        """Symbol of an expression, the same for the same expression."""
        symbol = self._symbols.get(expression)
        if symbol is None:
            symbol = sympy.Dummy(f"y_{{{next(self._numbers)}}}", real=True)
            self._symbols[expression], self.found[symbol] = symbol, expression
        return symbol


class Traced:
    """A scalar that records the operations on it, in place of an array."""

    __slots__ = ("expression", "parts", "size")
    shape = ()
    ndim = 0
    dtype = float

    def __init__(self, expression: Any, parts: Parts | None = None, size: int = 1) -> None:
        """Wrap a SymPy expression or relation of a number of operations; `parts` names large ones."""
        self.expression = expression
        self.parts = parts
        self.size = size

    def __array_namespace__(self, api_version: str | None = None) -> type[TracingNamespace]:
        """Array namespace of this class, as the Python array API requires."""
        return TracingNamespace

    def __bool__(self) -> bool:
        """Values are not known during tracing: formulas must choose by `where`."""
        raise TypeError("a traced value has no truth value: use where() to choose")

    def __neg__(self) -> Traced:
        """-x."""
        return _made(-self.expression, self)

    def __pos__(self) -> Traced:
        """+x."""
        return self

    def __abs__(self) -> Traced:
        """|x|."""
        return _made(sympy.Abs(self.expression), self)

    def __invert__(self) -> Traced:
        """Logical not."""
        return _made(sympy.Not(self.expression), self)

    def __and__(self, other: Any) -> Traced:
        """Logical and."""
        return _made(sympy.And(self.expression, symbolic(other)), self, other)

    def __or__(self, other: Any) -> Traced:
        """Logical or."""
        return _made(sympy.Or(self.expression, symbolic(other)), self, other)


def _made(expression: Any, *operands: Any) -> Traced:
    """The result of an operation, under a name if it has grown large."""
    traced = [operand for operand in operands if isinstance(operand, Traced)]
    size = 1 + sum(operand.size for operand in traced)
    parts = next((operand.parts for operand in traced if operand.parts is not None), None)
    if parts is None or size <= _LARGEST or not isinstance(expression, sympy.Expr):
        return Traced(expression, parts, size)
    return Traced(parts.named(expression), parts)


def _operator(name: str, apply: Callable[[Any, Any], Any], swapped: bool = False) -> None:
    def method(self: Traced, other: Any) -> Any:
        if isinstance(other, (Traced, int, float)) or hasattr(other, "__float__"):
            one, two = self.expression, symbolic(other)
            return _made(apply(two, one) if swapped else apply(one, two), self, other)
        return NotImplemented

    setattr(Traced, name, method)


for _name, _apply in {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "truediv": lambda a, b: a / b,
    "pow": lambda a, b: a**b,
}.items():
    _operator(f"__{_name}__", _apply)
    _operator(f"__r{_name}__", _apply, swapped=True)
for _name, _apply in {
    "lt": sympy.Lt,
    "le": sympy.Le,
    "gt": sympy.Gt,
    "ge": sympy.Ge,
    "eq": sympy.Eq,
    "ne": sympy.Ne,
}.items():
    _operator(f"__{_name}__", _apply)


def symbolic(value: Any) -> Any:
    """SymPy expression of a traced value or a number; whole floats become integers, which print shorter."""
    if isinstance(value, Traced):
        return value.expression
    if isinstance(value, bool):
        return sympy.true if value else sympy.false
    value = float(value)
    if math.isinf(value):
        return sympy.oo if value > 0 else -sympy.oo
    return sympy.Integer(int(value)) if value.is_integer() and abs(value) < 1e6 else sympy.Float(value, 17)


def _function(apply: Callable[..., Any]) -> Callable[..., Traced]:
    return staticmethod(lambda *values: _made(apply(*map(symbolic, values)), *values))  # type: ignore[return-value]


def _where(condition: Any, yes: Any, no: Any) -> Any:
    if condition in (sympy.true, sympy.false):
        return yes if condition == sympy.true else no
    return yes if yes == no else sympy.Piecewise((yes, condition), (no, sympy.true), evaluate=False)


class clip(sympy.Function):  # noqa: N801  (named as in the array namespace, for code and print)
    """Value cut off at a lower and an upper bound."""

    nargs = 3

    @classmethod
    def eval(cls, value: Any, low: Any, high: Any) -> Any:  # pyright: ignore[reportIncompatibleMethodOverride]
        """Evaluate if all arguments are real numbers; SymPy tries complex ones where it looks for the sign of a result."""
        if value.is_comparable and low.is_comparable and high.is_comparable:
            return sympy.Max(low, sympy.Min(value, high))
        return None

    def fdiff(self, argindex: int = 1) -> Any:
        """Derivative: 1 for the argument that the result equals, 0 for the others."""
        value, low, high = self.args
        below, above = value < low, value > high  # type: ignore[operator]
        if argindex == 1:
            return sympy.Piecewise((0, below), (0, above), (1, sympy.true), evaluate=False)
        return sympy.Piecewise((1, below if argindex == 2 else above), (0, sympy.true), evaluate=False)

    def _latex(self, printer: Any, exp: str | None = None) -> str:
        value, low, high = map(printer._print, self.args)
        text = rf"\left[{value}\right]_{{{low}}}^{{{high}}}"
        return text if exp is None else rf"\left({text}\right)^{{{exp}}}"


class Called(sympy.Function):
    """Call of a function of the package, which generated code imports: see `infinivar._core.array_namespace.recorded`."""

    module: str
    is_real = True

    def fdiff(self, argindex: int = 1) -> Any:
        """The derivative is not known."""
        raise ArgumentIndexError(self, argindex)


@functools.cache
def _call_of(module: str, name: str) -> type[Called]:
    return type(name, (Called,), {"module": module})


class TracingNamespace:
    """The functions of the Python array API that formulas use, on traced scalars."""

    float64 = float
    pi, inf, nan = math.pi, math.inf, math.nan

    @staticmethod
    def asarray(value: Any, dtype: Any = None) -> Traced:
        """Convert a number or traced value to a traced value."""
        return value if isinstance(value, Traced) else Traced(symbolic(value))

    @staticmethod
    def broadcast_arrays(*values: Any) -> list[Traced]:
        """Scalars broadcast to themselves."""
        return [TracingNamespace.asarray(value) for value in values]

    @staticmethod
    def call(module: str, name: str, *values: Any) -> Traced:
        """Record a call of a function by its name."""
        return _made(_call_of(module, name)(*map(symbolic, values)), *values)

    where = _function(_where)
    abs = _function(sympy.Abs)
    sign = _function(sympy.sign)
    sqrt = _function(sympy.sqrt)
    exp = _function(sympy.exp)
    log = _function(sympy.log)
    expm1 = _function(lambda value: sympy.exp(value) - 1)
    log1p = _function(lambda value: sympy.log(1 + value))
    sin = _function(sympy.sin)
    cos = _function(sympy.cos)
    tan = _function(sympy.tan)
    asin = _function(sympy.asin)
    acos = _function(sympy.acos)
    atan = _function(sympy.atan)
    atan2 = _function(sympy.atan2)
    tanh = _function(sympy.tanh)
    minimum = _function(lambda a, b: _where(a < b, a, b))
    maximum = _function(lambda a, b: _where(a > b, a, b))
    clip = _function(lambda x, low, high: _where(x < low, low, x) if high == sympy.oo else clip(x, low, high))
    full_like = _function(lambda like, value: value)
    ones_like = _function(lambda like: sympy.Integer(1))
    zeros_like = _function(lambda like: sympy.Integer(0))
    isfinite = _function(lambda value: sympy.true)


def _traced(value: Any, parts: Parts | None) -> Any:
    """An expression, or a tuple of them such as the efforts of a field."""
    return tuple(Traced(one, parts) for one in value) if isinstance(value, tuple) else Traced(value, parts)


def trace(law: Callable[..., Any], *arguments: Any, parts: Parts | None = None, **named: Any) -> Any:
    """Evaluate a law for SymPy expressions.

    Parameters
    ----------
    law : callable               Over an array namespace.
    arguments, named             SymPy expressions or numbers.
    parts : Parts                Receives large parts of the formula; None leaves it whole.

    Returns
    -------
    SymPy expression, or a tuple or dict of such, as the law returns.
    """
    given = [Traced(value, parts) for value in arguments]
    result = law(*given, **{name: _traced(value, parts) for name, value in named.items()})
    if isinstance(result, tuple):
        return tuple(symbolic(value) for value in result)
    if isinstance(result, dict):
        return {name: symbolic(value) for name, value in result.items()}
    return symbolic(result)
