"""Arrays in frozen values: copied, locked, compared by their values, and still so after pickling."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from infinivar._core.frozen import frozen, rebuilt
from infinivar.errors import ParameterError

_SHOWN = 60
"""Characters of a value shown in a message."""


def locked(values: Any) -> np.ndarray:
    """A copy of the values as floats that cannot be written to."""
    return frozen(np.asarray(values, dtype=float))


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
