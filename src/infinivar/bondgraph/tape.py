"""A tape: a formula over an array namespace as a list of operations on scalars, with exact derivatives, from which C is printed.

Each operation is recorded once, however often it is used, and operations on numbers are carried out.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from infinivar.bondgraph.namespaces import FUNCTIONS, FloatNamespace

OPERATIONS: Mapping[str, Callable[..., Any]] = {
    "add": operator.add,
    "sub": operator.sub,
    "mul": operator.mul,
    "truediv": operator.truediv,
    "pow": operator.pow,
    "lt": operator.lt,
    "le": operator.le,
    "gt": operator.gt,
    "ge": operator.ge,
    "eq": operator.eq,
    "ne": operator.ne,
    "and": lambda one, other: bool(one) and bool(other),
    "or": lambda one, other: bool(one) or bool(other),
    "not": operator.not_,
    "neg": operator.neg,
    "where": lambda condition, yes, no: yes if condition else no,
    "floor": math.floor,
    "isfinite": math.isfinite,
    "isnan": math.isnan,
    "atan2": math.atan2,
    "copysign": math.copysign,
    "expm1": math.expm1,
    "log1p": math.log1p,
    **{name: getattr(FloatNamespace, name) for name in FUNCTIONS if name not in ("where", "clip")},
}
"""What is recorded, as it is on numbers."""

CONDITIONS = frozenset({"lt", "le", "gt", "ge", "eq", "ne", "and", "or", "not", "isfinite", "isnan"})
"""Operations whose results are true or false."""

Number = Any
"""A float, or a `Value` of a tape."""


class Node(NamedTuple):
    """One operation, or a number that is known when the code runs: one of a group, such as the states."""

    operation: str
    arguments: tuple[float | int, ...]
    """Numbers as floats, places of earlier nodes as integers; of an input its place in the group."""


_ALONG = -1
"""In place of an input: the direction of `Tape.changes`."""


class Tape:
    """Operations in the order of their evaluation."""

    def __init__(self, parameters: Mapping[str, float]) -> None:
        """Nothing is recorded yet; values of parameters state the shapes of what is held."""
        self.parameters = parameters
        self.nodes: list[Node] = []
        self.held: list[tuple[Callable[..., Any], tuple[str | float, ...]]] = []
        """Functions whose results are data, and the names of the parameters that they have as arguments, or numbers."""
        self._known: dict[Any, Value] = {}
        self._looped = 0
        self._tables: dict[int, tuple[np.ndarray, Table]] = {}
        self._slopes: dict[tuple[int, int], Number] = {}

    def input(self, group: str, place: int) -> Value:
        """A number that is known when the code runs."""
        return self._added(Node(group, (place,)))

    def _added(self, node: Node) -> Value:
        key = node.operation, *((type(one), one) for one in node.arguments)
        if key not in self._known:
            self._known[key] = Value(self, len(self.nodes))
            self.nodes.append(node)
        return self._known[key]

    def record(self, operation: str, *arguments: Number) -> Number:
        """The result of an operation: a number if all arguments are."""
        given = tuple(one.place if isinstance(one, Value) else float(one) for one in arguments)
        if not any(isinstance(one, int) for one in given):
            return float(OPERATIONS[operation](*given))
        if operation == "where" and isinstance(given[0], float):
            return arguments[1] if given[0] else arguments[2]
        simple = _SIMPLE.get(operation, _nothing)(*given)
        if simple is None:
            return self._added(Node(operation, given))
        return Value(self, simple) if isinstance(simple, int) else simple

    def copied(self, operation: str, arguments: Sequence[Number]) -> Number:
        """The operation of a node of another tape."""
        if operation in OPERATIONS:
            return self.record(operation, *arguments)
        return self._added(Node(operation, tuple(one.place if isinstance(one, Value) else one for one in arguments)))

    def hold(self, function: Callable[..., Any], *arguments: Number) -> Any:
        """What a function of parameters and numbers gives, as data: named tuples of numbers and arrays, of shapes that do not
        change."""
        every = tuple(self.parameters)
        one = (
            function,
            tuple(
                every[int(self.nodes[argument.place].arguments[0])] if isinstance(argument, Value) else float(argument)
                for argument in arguments
            ),
        )
        if one not in self.held:
            self.held.append(one)
        return self._pieces(_held(one, self.parameters), self.held.index(one), [0])

    def table(self, array: np.ndarray) -> Table:
        """An array that does not change, as data."""
        if id(array) not in self._tables:
            self._tables[id(array)] = array, self.hold(lambda: array)
        return self._tables[id(array)][1]

    def data(self, parameters: Mapping[str, float]) -> list[Any]:
        """What the functions held give for values of the parameters."""
        return [_held(one, parameters) for one in self.held]

    def _pieces(self, data: Any, place: int, start: list[int]) -> Any:
        if isinstance(data, tuple):
            return type(data)(*(self._pieces(one, place, start) for one in data))
        begin = start[0]
        start[0] += np.size(data)
        group = f"held{place}"
        return Table(self, group, begin, np.shape(data)) if np.ndim(data) else self.input(group, begin)

    def loop(
        self, step: Callable[..., tuple[Sequence[Number], Number]], starts: Sequence[Number], steps: int
    ) -> tuple[Value, ...]:
        """Repeat a step, which gives the next values and whether to end there, from some starts, at most `steps` times."""
        values = [self.input("looped", self._looped + place) for place in range(len(starts))]
        self._looped += len(starts)
        new, ends = step(*values)
        numbers = (*starts, *values, *new, ends, steps)
        given = tuple(one.place if isinstance(one, Value) else float(one) for one in numbers)
        place = self._added(Node("loop", given)).place
        return tuple(self._added(Node("last", (place, one.place))) for one in values)

    def slope(self, of: Number, by: Value) -> Number:
        """Derivative of a value by an input."""
        if not isinstance(of, Value):
            return 0.0
        for place in range(of.place + 1):
            if (place, by.place) not in self._slopes:
                self._slopes[place, by.place] = self._slope(place, by.place)
        return self._slopes[of.place, by.place]

    def changes(self, of: Sequence[Number], seeds: Sequence[tuple[Number, Value]]) -> list[Number]:
        """Change of values along a direction: seeds, which are numbers of the tape, of inputs."""
        self._slopes |= {(by.place, _ALONG): seed for seed, by in seeds}
        for place in range(1 + max((one.place for one in of if isinstance(one, Value)), default=-1)):
            if (place, _ALONG) not in self._slopes:
                self._slopes[place, _ALONG] = self._slope(place, _ALONG)
        return [self._slopes[one.place, _ALONG] if isinstance(one, Value) else 0.0 for one in of]

    def _slope(self, place: int, by: int) -> Number:
        if place == by:
            return 1.0
        operation, arguments = self.nodes[place]
        if operation == "last":
            raise TypeError("what a loop gives has no recorded derivative")
        if operation not in OPERATIONS:
            return 0.0  # an input, or a place in a table
        inner = [self._slopes[one, by] if isinstance(one, int) else 0.0 for one in arguments]
        values = [Value(self, one) if isinstance(one, int) else one for one in arguments]
        if operation == "where":
            return self.record("where", values[0], inner[1], inner[2])
        rules = _SLOPES.get(operation)
        if rules is None:
            return 0.0  # a condition, a sign, a whole number
        found: Number = 0.0
        for rule, one in zip(rules, inner, strict=True):
            if isinstance(one, Value) or one != 0.0:
                found = found + rule(Value(self, place), *values) * one
        return found


def _held(one: tuple[Callable[..., Any], tuple[str | float, ...]], parameters: Mapping[str, float]) -> Any:
    """What a function of parameters gives for values of them."""
    function, names = one
    return function(*(float(parameters[name]) if isinstance(name, str) else name for name in names))


def _nothing(*arguments: float | int) -> None:
    """No simpler form is known."""


def _is(value: float | int, number: float) -> bool:
    return isinstance(value, float) and value == number


_SIMPLE: Mapping[str, Callable[..., float | int | None]] = {
    "add": lambda a, b: b if _is(a, 0.0) else a if _is(b, 0.0) else None,
    "sub": lambda a, b: a if _is(b, 0.0) else None,
    "mul": lambda a, b: 0.0 if _is(a, 0.0) or _is(b, 0.0) else b if _is(a, 1.0) else a if _is(b, 1.0) else None,
    "truediv": lambda a, b: 0.0 if _is(a, 0.0) else a if _is(b, 1.0) else None,
    "where": lambda condition, yes, no: yes if type(yes) is type(no) and yes == no else None,
}
"""What an operation comes to where no arithmetic is left. A product with 0 is 0: infinite factors do not occur in formulas."""

_SLOPES: Mapping[str, tuple[Callable[..., Number], ...]] = {
    "add": (lambda y, a, b: 1.0, lambda y, a, b: 1.0),
    "sub": (lambda y, a, b: 1.0, lambda y, a, b: -1.0),
    "mul": (lambda y, a, b: b, lambda y, a, b: a),
    "truediv": (lambda y, a, b: 1.0 / b, lambda y, a, b: -y / b),
    "pow": (lambda y, a, b: b * a ** (b - 1.0), lambda y, a, b: y * y.tape.record("log", a)),
    "neg": (lambda y, a: -1.0,),
    "abs": (lambda y, a: y.tape.record("sign", a),),
    "sqrt": (lambda y, a: 0.5 / y,),
    "exp": (lambda y, a: y,),
    "log": (lambda y, a: 1.0 / a,),
    "expm1": (lambda y, a: y + 1.0,),
    "log1p": (lambda y, a: 1.0 / (1.0 + a),),
    "sin": (lambda y, a: y.tape.record("cos", a),),
    "cos": (lambda y, a: -y.tape.record("sin", a),),
    "tan": (lambda y, a: 1.0 + y * y,),
    "asin": (lambda y, a: 1.0 / y.tape.record("sqrt", 1.0 - a * a),),
    "acos": (lambda y, a: -1.0 / y.tape.record("sqrt", 1.0 - a * a),),
    "atan": (lambda y, a: 1.0 / (1.0 + a * a),),
    "atan2": (lambda y, a, b: b / (a * a + b * b), lambda y, a, b: -a / (a * a + b * b)),
    "tanh": (lambda y, a: 1.0 - y * y,),
    "copysign": (lambda y, a, b: y.tape.record("copysign", 1.0, a * b), lambda y, a, b: 0.0),
}
"""Derivative of the result y by each argument."""


class Value:
    """A scalar on a tape, in place of an array."""

    __slots__ = ("place", "tape")
    __hash__ = None  # type: ignore[assignment]
    shape = ()
    ndim = 0
    dtype = float

    def __init__(self, tape: Tape, place: int) -> None:
        """The result of a node."""
        self.tape, self.place = tape, place

    def __array_namespace__(self, api_version: str | None = None) -> TapeNamespace:
        """Array namespace of this class, as the Python array API requires."""
        return TapeNamespace(self.tape)

    def __bool__(self) -> bool:
        """Values are not known while they are recorded: formulas must choose by `where`."""
        raise TypeError("a recorded value has no truth value: use where() to choose")

    def __pos__(self) -> Value:
        """+x."""
        return self


def _method(operation: str, swapped: bool) -> Callable[..., Number]:
    def method(self: Value, *others: Any) -> Number:
        if not all(isinstance(one, (Value, int, float, np.number, np.bool_)) for one in others):
            return NotImplemented
        return self.tape.record(operation, *((*others, self) if swapped else (self, *others)))

    return method


for _name in ("add", "sub", "mul", "truediv", "pow", "and", "or"):
    setattr(Value, f"__{_name}__", _method(_name, swapped=False))
    setattr(Value, f"__r{_name}__", _method(_name, swapped=True))
for _name in ("lt", "le", "gt", "ge", "eq", "ne", "neg", "abs"):
    setattr(Value, f"__{_name}__", _method(_name, swapped=False))
Value.__invert__ = _method("not", swapped=False)  # type: ignore[attr-defined]


class Table(NamedTuple):
    """Data in an array: only picked from, by a place that is computed."""

    tape: Tape
    group: str
    begin: int
    shape: tuple[int, ...]

    def __array_namespace__(self, api_version: str | None = None) -> TapeNamespace:
        """Array namespace of this class, as the Python array API requires."""
        return TapeNamespace(self.tape)


class TapeNamespace:
    """The functions of the Python array API that formulas use, on scalars of a tape."""

    __name__ = "tape"
    float64 = int64 = int8 = float
    pi, inf, nan = math.pi, math.inf, math.nan

    def __init__(self, tape: Tape) -> None:
        """Record on a tape."""
        self._tape = tape
        self.hold, self.loop = tape.hold, tape.loop

    @property
    def settled(self) -> Value:
        """Relative change of a value by which an iteration has converged: what the code computes with decides."""
        return self._tape.input("settled", 0)

    def __getattr__(self, name: str) -> Callable[..., Number]:
        """Function that records an operation of that name."""
        if name not in OPERATIONS:
            raise AttributeError(f"the tape has no function {name}")
        return lambda *values: self._tape.record(name, *values)

    def clip(self, value: Number, low: Number, high: Number) -> Number:
        """Cut off at a lower and an upper bound."""
        record = self._tape.record
        return record("where", value < low, low, record("where", value > high, high, value))

    def maximum(self, one: Number, other: Number) -> Number:
        """The larger."""
        return self._tape.record("where", one > other, one, other)

    def minimum(self, one: Number, other: Number) -> Number:
        """The smaller."""
        return self._tape.record("where", one < other, one, other)

    def asarray(self, value: Number, dtype: Any = None) -> Number:
        """The same."""
        return value

    def astype(self, value: Number, dtype: Any) -> Number:
        """The same: whole numbers are kept as floats."""
        return value

    def broadcast_arrays(self, *values: Number) -> tuple[Number, ...]:
        """Scalars broadcast to themselves."""
        return values

    def zeros_like(self, value: Number) -> float:
        """Zero."""
        return 0.0

    def reshape(self, table: Any, shape: Any) -> Any:
        """The same: a table is one row of numbers."""
        return table

    def take(self, table: Table | np.ndarray, place: Number) -> Number:
        """Element of a table, or of an array that does not change."""
        if isinstance(table, np.ndarray):
            table = self._tape.table(table)
        where = place.place if isinstance(place, Value) else float(place)
        return self._tape._added(Node(f"take {table.group} {table.begin}", (where,)))
