"""Functions of formulas on scalars: they compute with floats, and are recorded from values of a tape."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from infinivar.bondgraph.tape import Number, Value


def number(value: Any) -> Any:
    """A number, also if it is an array of no dimensions."""
    return value[()] if isinstance(value, np.ndarray) else value


def choose(condition: Any, yes: Callable[[], Any], no: Callable[[], Any]) -> Any:
    """What one of two functions gives, numbers or tuples of them; of recorded values both are evaluated."""
    condition = number(condition)
    if not isinstance(condition, Value):
        return yes() if condition else no()
    return _chosen(condition, yes(), no())


def _chosen(condition: Value, yes: Any, no: Any) -> Any:
    if isinstance(yes, tuple):
        return tuple(_chosen(condition, *both) for both in zip(yes, no, strict=True))
    return condition.tape.record("where", condition, number(yes), number(no))


def within(value: Number, limit: float) -> Number:
    """A value, or the limit of its size."""
    value = number(value)
    if isinstance(value, Value):
        return value.__array_namespace__().clip(value, -limit, limit)
    return min(max(value, -limit), limit)


def share_of(value: Number, full: float) -> Number:
    """A value over that from which on it counts in full, within -1 and 1."""
    return within(value / full, 1.0)


def _either(name: str, function: Callable[..., float]) -> Callable[..., Number]:
    """A function of floats that is recorded by a name if one of its arguments is a value of a tape."""

    def found(*given: Number) -> Number:
        values = [number(one) for one in given]
        for one in values:
            if isinstance(one, Value):
                return one.tape.record(name, *values)
        return function(*values)

    return found


signed = _either("copysign", math.copysign)
"""A size with the sign of another number."""

sine, cosine, arc_sine, arc_tangent = (_either(name, getattr(math, name)) for name in ("sin", "cos", "asin", "atan"))
angle_of = _either("atan2", math.atan2)
"""Angle of a vector, from its components y and x. [rad]"""
root = _either("sqrt", math.sqrt)


floor = _either("floor", math.floor)


def wrapped(value: Number, whole: float) -> Number:
    """What a value has beyond the nearest multiple of a number."""
    return value - whole * floor(value / whole + 0.5)


def length_of(*components: Number) -> Number:
    """Length of a vector."""
    if any(isinstance(number(one), Value) for one in components):
        return root(sum(one * one for one in components))
    return math.hypot(*components)
