"""Arrays of numbers on a tape: functions of NumPy arrays are recorded as they stand, element by element.

Sums, products and copies are NumPy's own, on arrays of objects. What decides by a value is recorded as a choice, and systems of
linear equations are solved without pivots, so that their matrices must be symmetric and positive definite.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from infinivar.bondgraph.scalars import number
from infinivar.bondgraph.tape import OPERATIONS, Number, Tape, TapeNamespace, Value

_DIRECT = (np.add, np.subtract, np.multiply, np.matmul, np.negative, np.positive)
"""NumPy's own on arrays of objects."""

_NAMES = {
    "absolute": "abs",
    "arccos": "acos",
    "arcsin": "asin",
    "arctan": "atan",
    "arctan2": "atan2",
    "bitwise_and": "and",
    "bitwise_or": "or",
    "divide": "truediv",
    "equal": "eq",
    "greater": "gt",
    "greater_equal": "ge",
    "invert": "not",
    "less": "lt",
    "less_equal": "le",
    "logical_and": "and",
    "logical_not": "not",
    "logical_or": "or",
    "not_equal": "ne",
    "power": "pow",
}
"""Operations of a tape by the names of NumPy's functions, where they differ."""


_INDEPENDENT = 1e-9
"""Square of the least sine of the angle between a row and those before it: the rest of least squares is rounding."""


class Recorded(np.ndarray):
    """An array whose elements are floats and values of one tape."""

    tape: Tape

    def __new__(cls, tape: Tape, elements: Any) -> Recorded:
        """Elements in nested sequences."""
        found = np.array(elements, dtype=object).view(cls)
        found.tape = tape
        return found

    def __array_finalize__(self, other: Any) -> None:
        """Views and copies share the tape."""
        self.tape = getattr(other, "tape", None)  # type: ignore[assignment]

    def __array_namespace__(self, api_version: str | None = None) -> RecordedNamespace:  # type: ignore[override]
        """Array namespace of this class, as the Python array API requires."""
        return RecordedNamespace(self.tape)

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, out: Any = None, **options: Any) -> Any:
        """Record a function of NumPy."""
        tape = next(one.tape for one in inputs if isinstance(one, Recorded))
        if ufunc in _DIRECT:
            found = getattr(ufunc, method)(*(_plain(one) for one in inputs), **options)
        elif method == "__call__":
            found = _each(functools.partial(_recorded, tape, ufunc.__name__), *map(_objects, inputs))
        else:
            raise TypeError(f"the tape has no {ufunc.__name__}.{method}")
        made = Recorded(tape, found)
        if out is None:
            return made
        out[0][...] = made
        return out[0]

    def __array_function__(self, function: Any, types: Any, inputs: Any, options: Any) -> Any:
        """Choices and linear equations are recorded; all else rearranges elements."""
        own = _OWN.get(function)
        if own is not None:
            return Recorded(self.tape, own(self.tape, *inputs, **options))
        if function is np.linalg.lstsq:
            return Recorded(self.tape, _least(self.tape, *inputs[:2])), None, None, None
        found = super().__array_function__(function, types, inputs, options)
        return Recorded(self.tape, found) if isinstance(found, np.ndarray) and found.dtype == object else found


def as_recorded(value: Any) -> Recorded | None:
    """An array that has values of a tape; None for one of numbers."""
    if isinstance(value, Recorded):
        return value
    if not isinstance(value, np.ndarray) or value.dtype != object:
        return None
    tape = next((one.tape for one in value.flat if isinstance(one, Value)), None)
    return None if tape is None else Recorded(tape, value)


class RecordedNamespace:
    """The functions of the Python array API that formulas use, on arrays of a tape."""

    __name__ = "tape"
    float64 = int64 = float
    pi, inf, nan = math.pi, math.inf, math.nan

    def __init__(self, tape: Tape) -> None:
        """Record on a tape."""
        self._tape, self._scalars = tape, TapeNamespace(tape)

    @property
    def settled(self) -> Value:
        """As on scalars."""
        return self._scalars.settled

    def __getattr__(self, name: str) -> Callable[..., Any]:
        """Function of scalars, of each element, or one that rearranges elements."""
        if name not in OPERATIONS and name not in ("clip", "maximum", "minimum", "hold"):
            return getattr(np, name)
        function = getattr(self._scalars, name)
        if name == "hold":
            return function
        return lambda *arrays: Recorded(self._tape, _each(function, *map(_objects, arrays)))

    def asarray(self, value: Any, dtype: Any = None) -> Any:
        """The same."""
        return value

    def astype(self, value: Any, dtype: Any) -> Any:
        """The same: whole numbers are kept as floats."""
        return value

    def take(self, table: Any, place: Any, axis: int | None = None) -> Any:
        """Elements of a table, or of an array that does not change, or those of any array at places that do not change."""
        if axis is not None:
            return np.take(table, np.asarray(place, dtype=int), axis=axis)
        return Recorded(self._tape, _each(lambda one: self._scalars.take(table, one), _objects(place)))

    def broadcast_arrays(self, *arrays: Any) -> tuple[Recorded, ...]:
        """All in one shape."""
        return tuple(Recorded(self._tape, one) for one in np.broadcast_arrays(*map(_objects, arrays)))

    def all(self, array: Any) -> Number:
        """Whether a condition holds everywhere."""
        return functools.reduce(functools.partial(self._tape.record, "and"), np.ravel(_objects(array)).tolist())

    def each(self, function: Callable[..., Sequence[Number]], *arrays: Any) -> tuple[Recorded, ...]:
        """Results of a function of scalars, which holds data by them, for each element of arrays that broadcast."""
        wide = np.broadcast_arrays(*map(_objects, arrays))
        found = [function(*(one[place] for one in wide)) for place in np.ndindex(wide[0].shape)]
        columns = (np.array(one, dtype=object) for one in zip(*found, strict=True))
        return tuple(Recorded(self._tape, np.reshape(one, wide[0].shape)) for one in columns)

    def loop(
        self, step: Callable[..., tuple[Sequence[Any], Any]], starts: Sequence[Any], steps: int
    ) -> tuple[Recorded, ...]:
        """Repeat a step on arrays until it ends for all elements, at most `steps` times."""
        wide = np.broadcast_arrays(*map(_objects, starts))
        shape, size = wide[0].shape, wide[0].size

        def arrays(values: Sequence[Number]) -> list[Recorded]:
            return [
                Recorded(self._tape, np.reshape(np.array(values[at : at + size], dtype=object), shape))
                for at in range(0, len(values), size)
            ]

        def flat(some: Sequence[Any]) -> list[Number]:
            return [one for each in some for one in np.broadcast_to(_objects(each), shape).ravel().tolist()]

        def each(*values: Number) -> tuple[list[Number], Number]:
            new, ends = step(*arrays(values))
            return flat(new), ends if isinstance(ends, bool) else self.all(ends)

        return tuple(arrays(self._tape.loop(each, flat(wide), steps)))


def vector(*components: Number) -> np.ndarray:
    """Numbers as an array, recorded if one of them is. (d,)"""
    numbers = [number(one) for one in components]
    for one in numbers:
        if isinstance(one, Value):
            return Recorded(one.tape, numbers)
    return np.array(numbers)


def _objects(value: Any) -> np.ndarray:
    return np.asarray(value, dtype=object)


def _plain(value: Any) -> Any:
    return _objects(value) if isinstance(value, (np.ndarray, Value)) else value


def _each(function: Callable[..., Number], *arrays: np.ndarray) -> np.ndarray:
    """A function of scalars on arrays that broadcast."""
    wide = np.broadcast_arrays(*arrays)
    found = np.empty(wide[0].shape, dtype=object)
    for place in np.ndindex(found.shape):
        found[place] = function(*(one[place] for one in wide))
    return found


def _recorded(tape: Tape, name: str, *values: Number) -> Number:
    if name == "square" or (name == "power" and not isinstance(values[1], Value) and values[1] == 2):
        return values[0] * values[0]
    if name in ("maximum", "minimum"):
        return getattr(TapeNamespace(tape), name)(*values)
    return tape.record(_NAMES.get(name, name), *values)


def _where(tape: Tape, condition: Any, yes: Any, no: Any) -> np.ndarray:
    return _each(functools.partial(tape.record, "where"), *map(_objects, (condition, yes, no)))


def _clip(tape: Tape, values: Any, low: Any, high: Any) -> np.ndarray:
    return _each(TapeNamespace(tape).clip, *map(_objects, (values, low, high)))


def _solve(tape: Tape, matrix: Any, right: Any) -> np.ndarray:
    """Solutions of linear equations with symmetric positive definite matrices, by the factors ``L D L^T``. (..., n, k)"""
    shape = np.broadcast_shapes(np.shape(matrix)[:-2], np.shape(right)[:-2])
    matrix = np.broadcast_to(_objects(matrix), (*shape, *np.shape(matrix)[-2:]))
    found = np.array(np.broadcast_to(_objects(right), (*shape, *np.shape(right)[-2:])))
    for place in np.ndindex(shape):
        lower, diagonal = _factors(matrix[place])
        x = found[place]
        for row in range(len(x)):
            x[row] = x[row] - sum(lower[row][i] * x[i] for i in range(row))
        for row in reversed(range(len(x))):
            x[row] = x[row] / diagonal[row] - sum(lower[i][row] * x[i] for i in range(row + 1, len(x)))
    return found


def _cholesky(tape: Tape, matrix: Any) -> np.ndarray:
    """Lower factor of a symmetric positive definite matrix. (n, n)"""
    lower, diagonal = _factors(_objects(matrix))
    found = np.zeros((len(lower), len(lower)), dtype=object)
    for column, pivot in enumerate(diagonal):
        size = tape.record("sqrt", pivot)
        found[column:, column] = [size, *(row[column] * size for row in lower[column + 1 :])]
    return found


def _least(tape: Tape, matrix: Any, right: Any) -> np.ndarray:
    """Solution of least squares (n,), the shortest if there are several; nan where rows and columns both depend on each other."""
    matrix, right = _objects(matrix), _objects(right)
    wide = matrix.shape[0] <= matrix.shape[1]
    product = matrix @ matrix.T if wide else matrix.T @ matrix
    found = _solve(tape, product, right if wide else matrix.T @ right)
    known = functools.partial(tape.record, "and")
    full = functools.reduce(
        known, (pivot > _INDEPENDENT * product[row, row] for row, pivot in enumerate(_factors(product)[1]))
    )
    return _where(tape, full, matrix.T @ found if wide else found, math.nan)


def _factors(matrix: np.ndarray) -> tuple[list[list[Number]], list[Number]]:
    """L, below its diagonal of ones, and D of a symmetric matrix."""
    lower: list[list[Number]] = []
    diagonal: list[Number] = []
    for row in range(len(matrix)):
        scaled: list[Number] = []
        for column in range(row):
            scaled.append(matrix[row, column] - sum(scaled[i] * lower[column][i] for i in range(column)))
        lower.append([one / by for one, by in zip(scaled, diagonal, strict=True)])
        diagonal.append(matrix[row, row] - sum(one * by for one, by in zip(scaled, lower[row], strict=True)))
    return lower, diagonal


_OWN: dict[Callable[..., Any], Callable[..., np.ndarray]] = {
    np.where: _where,
    np.clip: _clip,
    np.linalg.solve: _solve,
    np.linalg.cholesky: _cholesky,
}
"""Functions of NumPy that do not rearrange elements."""
