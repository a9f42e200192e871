"""Bounds of physical fields: what a number may be, as `annotated_types`, in words and as ends of a range."""

from __future__ import annotations

import functools
import math
import operator
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

from annotated_types import BaseMetadata, Ge, Gt, Interval, Le, Lt


@dataclass(frozen=True, slots=True)
class NonZero(BaseMetadata):
    """Any number but zero."""


Bound: TypeAlias = Gt | Ge | Lt | Le | Interval | NonZero

FINITE = Interval()
"""Any number that is neither infinite nor nan."""

QUARTER_TURN = 0.5 * math.pi * (1.0 + 1e-12)
"""Largest angle of 90 degrees, with room for the rounding of its conversion. [rad]"""

_SIGNS: Mapping[type, str] = {Gt: ">", Ge: ">=", Lt: "<", Le: "<="}
_COMPARE: Mapping[str, Callable[[Any, Any], Any]] = {
    ">": operator.gt,
    ">=": operator.ge,
    "<": operator.lt,
    "<=": operator.le,
    "!=": operator.ne,
}
_NAMED_ENDS = {QUARTER_TURN: "pi/2", 1e-3: "1e-3"}
"""Ends that read better so than as numbers."""


@functools.cache
def _conditions(bound: Bound) -> tuple[tuple[str, Any], ...]:
    """Every comparison that a bound stands for: sign and number."""
    if isinstance(bound, NonZero):
        return (("!=", 0),)
    found = []
    for one in bound if isinstance(bound, Interval) else (bound,):
        sign = _SIGNS[type(one)]
        found.append((sign, getattr(one, type(one).__name__.lower())))
    return tuple(found)


def words(bound: Bound) -> str:
    """For messages and listings: "> 0 and <= 1"."""
    return " and ".join(f"{sign} {_NAMED_ENDS.get(end, f'{end:g}')}" for sign, end in _conditions(bound)) or "finite"


def within(bound: Bound, value: Any) -> Any:
    """Whether a number, or each element of an array, keeps the bound; nan does not."""
    kept = value == value
    for sign, end in _conditions(bound):
        kept = kept & _COMPARE[sign](value, end)
    return kept


def fits(bound: Bound, value: float) -> bool:
    """Whether a number is finite and keeps the bound."""
    return math.isfinite(value) and all(_COMPARE[sign](value, end) for sign, end in _conditions(bound))


def permitted(bound: Bound, value: float) -> tuple[float, float]:
    """Least and largest number within the bound, on the side of zero on which the value is."""
    low, high = -math.inf, math.inf
    least = 1e-9 * abs(value)  # distance from an end that is itself excluded
    for sign, end in _conditions(bound):
        if sign == "!=":
            return (least, math.inf) if value > 0 else (-math.inf, -least)
        if sign in (">", ">="):
            low = end + least if sign == ">" else float(end)
        else:
            high = end - least if sign == "<" else float(end)
    return low, high


def ends(bound: Bound) -> tuple[float, float]:
    """Least and largest number that keeps a bound, both included; infinite where there is none."""
    low, high = -math.inf, math.inf
    for sign, end in _conditions(bound):
        if sign == ">":
            low = math.nextafter(end, math.inf) if end else sys.float_info.min
        elif sign == ">=":
            low = float(end)
        elif sign == "<":
            high = math.nextafter(end, -math.inf) if end else -sys.float_info.min
        elif sign == "<=":
            high = float(end)
    return low, high
