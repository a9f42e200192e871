"""Arrays in frozen values: copied, locked, compared by their values, and still so after pickling."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

import numpy as np

from infinivar._core.frozen import frozen, rebuilt
from infinivar.errors import ParameterError

_WHOLE = {float, int, bool, str, type(None)}
"""Types of most fields, which have no rows."""

F = TypeVar("F", bound=Callable[..., Any])

_FEW = 1000
"""Numbers of an array up to which its content is a quick key."""

_SHOWN = 60
"""Characters of a value shown in a message."""


def locked(values: Any) -> np.ndarray:
    """A copy of the values as floats that cannot be written to."""
    return frozen(np.asarray(values, dtype=float))


def remembered(function: F) -> F:
    """A pure function of numbers and arrays that computes once what it is asked again soon: floats, or small arrays of NumPy.

    They count as equal by their content, so that arrays may change later; results must not be written to.
    """

    @functools.lru_cache(maxsize=64)
    def known(*keys: Any) -> Any:
        return function(*(key if type(key) is float else np.frombuffer(key[1]).reshape(key[0]) for key in keys))

    @functools.wraps(function)
    def run(*arguments: Any, **named: Any) -> Any:
        if named:
            return function(*arguments, **named)
        keys = [_key(one) for one in arguments]
        return function(*arguments) if None in keys else known(*keys)

    return run  # type: ignore[return-value]


def _key(value: Any) -> Any:
    """What tells equal values; None for what is not remembered."""
    if type(value) is np.ndarray and value.dtype == np.float64 and 0 < value.size <= _FEW:
        return value.shape, value.tobytes()
    return value if type(value) is float else None


def shown(value: Any) -> str:
    """A value for a message, short: an array or a sequence of many numbers by its shape only."""
    if isinstance(value, np.ndarray) and value.size > 1:
        return f"an array of shape {value.shape}"
    said = repr(value)
    return said if len(said) <= _SHOWN else f"{said[:_SHOWN]}..."


def real_array(name: str, values: Any) -> np.ndarray:
    """The values as floats, not necessarily a copy.

    Raises
    ------
    ParameterError
        If they are not real numbers; the message names the argument.
    """
    try:
        array = np.asarray(values)
        wrong = array.dtype.kind not in "biufO"
        if array.dtype.kind == "O":
            wrong = any(value is None or isinstance(value, (str, bytes)) for value in array.flat)
        if not wrong:
            return array.astype(float, copy=False)
    except (TypeError, ValueError):
        pass  # rows of different lengths, or objects that are no numbers
    raise ParameterError(f"{name} must be a real number or an array of them, got {shown(values)}")


def rows_of(value: Any, places: Any) -> Any:
    """Some rows of a part that was made with columns of values, without the laws that its making computes.

    Parameters
    ----------
    value           A number, a column (k, 1), or a dataclass, tuple or mapping of these.
    places : int or bool array   Of the rows that are kept; columns of one row stay.

    Returns
    -------
    Any   The same with columns of these rows; what has none is shared with the value.
    """
    if isinstance(value, np.ndarray):
        return value[places] if value.ndim == 2 and len(value) > 1 else value
    if isinstance(value, (tuple, Mapping)):
        names: Any = value if isinstance(value, Mapping) else range(len(value))
        fields = {name: value[name] for name in names}
    elif dataclasses.is_dataclass(value):
        fields = {name: getattr(value, name) for name in _names(type(value))}
    else:
        return value
    kept = {name: one if type(one) in _WHOLE else rows_of(one, places) for name, one in fields.items()}
    if all(one is fields[name] for name, one in kept.items()):
        return value
    if isinstance(value, Mapping):
        return kept
    if isinstance(value, tuple):
        return type(value)(*kept.values()) if hasattr(value, "_fields") else tuple(kept.values())
    made = object.__new__(type(value))
    for name, one in kept.items():
        object.__setattr__(made, name, one)
    return made


@functools.cache
def _names(part: type) -> tuple[str, ...]:
    return tuple(one.name for one in dataclasses.fields(part))


class Whole:
    """Base of values that are one thing to NumPy: ``==`` with an array gives one bool, not one for each element."""

    __slots__ = ()
    __array_ufunc__ = None


class HoldsArrays(Whole):
    """Base of frozen dataclasses with arrays among their fields, declared with ``eq=False``.

    Two are equal if their compared fields are, arrays element by element; equal ones have one hash.
    """

    __slots__ = ()

    def _compared(self) -> tuple[Any, ...]:
        values = (getattr(self, field.name) for field in dataclasses.fields(self) if field.compare)  # type: ignore[arg-type]
        return tuple((value.shape, value.tobytes()) if isinstance(value, np.ndarray) else value for value in values)

    def __eq__(self, other: object) -> bool:
        """Whether the other is of the same class and has the same values."""
        return self._compared() == other._compared() if type(other) is type(self) else NotImplemented  # type: ignore[attr-defined]

    def __hash__(self) -> int:
        """From the compared values."""
        return hash((type(self), self._compared()))

    def __reduce__(self) -> tuple[Any, ...]:
        """Rebuild with locked arrays: NumPy forgets the lock."""
        values = {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}  # type: ignore[arg-type]
        return rebuilt, (type(self), values)
