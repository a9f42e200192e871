"""Which values of an infeasible drive, changed, would bring it within all limits: one, or a few together."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from decimal import ROUND_CEILING, ROUND_FLOOR, Context
from typing import Any

import numpy as np

from infinivar._core.fields import value_at, with_values
from infinivar.errors import ParameterError
from infinivar.sizing.levers import Lever
from infinivar.sizing.what_if import Change, distance, nearest_change

TOGETHER, _FIRST = 3, 3
"""Values that are changed together at most, and of how many one is the first."""

_NODES = 6
"""Values looked at between the present one and each end."""

_HALVINGS = 16
_SHARE = 1e-6
"""Of the most that a value can lower the sum of excesses: values that lack no more ease a drive alike. [-]"""

_EASED = 0.02
"""Least share by which a value has to lower the sum of excesses to be changed with others. [-]"""

Ends = Mapping[str, tuple[float, float]]
"""Least and largest value looked at, by path of the field; its value is between them."""

Demands = Callable[[Any], np.ndarray]
"""Demands over allowances of a drive; a demand that is not known is infinite. (n,) [-]"""


def mending(drive: Any, ends: Ends, demands: Demands, most: int = TOGETHER) -> tuple[dict[str, Change], ...]:
    """Changes of one value each that keep all limits, the smallest first; where none is enough, of two or more together.

    Parameters
    ----------
    drive : CoboticDrive or ConventionalDrive
    ends : path to (2,) float
    demands : callable
    most : int                  Values that may change together.

    Returns
    -------
    tuple of path to Change   Of those together, all but the last are what lowers the sum of excesses over allowances most, each
        as small as does so; the last is then enough. Empty if nothing tried is.
    """

    def worst(made: Any) -> tuple[float, float]:
        return math.nan, float(np.max(demands(made), initial=0.0))

    alone: dict[str, Change] = {}
    for path, both in ends.items():
        enough = [
            one for end in both if (one := nearest_change(_lever(drive, path, end), drive, worst, math.inf, 1.0)).enough
        ]
        if enough:
            alone[path] = min(enough, key=distance)
    if alone or most == 1:
        return tuple({path: one} for path, one in sorted(alone.items(), key=lambda item: distance(item[1])))
    found = []
    for path, first in _easing(drive, ends, demands)[: _FIRST if most == TOGETHER else 1]:
        others = {one: both for one, both in ends.items() if one != path}
        eased = with_values(drive, {path: first.needed})
        found += [{path: first, **more} for more in mending(eased, others, demands, most - 1)]
    return tuple(sorted(found, key=lambda one: (len(one), sum(map(distance, one.values())))))


def _lever(drive: Any, path: str, end: float) -> Lever:
    start = float(value_at(drive, path))
    return Lever(words=path, unit="", start=start, end=end, made=lambda made, value: with_values(made, {path: value}))


def _easing(drive: Any, ends: Ends, demands: Demands) -> list[tuple[str, Change]]:
    """Changes of one value each that lower the sum of excesses, those that lower it most first."""
    present, eased = _excess(demands, drive, {}), []
    for path, both in ends.items():
        start = float(value_at(drive, path))
        values = [start + (end - start) * step / _NODES for end in both for step in range(1, _NODES + 1)]
        tried = [(_excess(demands, drive, {path: value}), value) for value in values]
        least = min(excess for excess, _ in tried)
        alike = least + _SHARE * (present - least)
        if not least < (1.0 - _EASED) * present:
            continue
        inside = min((value for excess, value in tried if excess <= alike), key=lambda one: abs(one - start))
        outside = start
        for _ in range(_HALVINGS):
            middle = 0.5 * (outside + inside)
            if _excess(demands, drive, {path: middle}) <= alike:
                inside = middle
            else:
                outside = middle
        rounding = ROUND_CEILING if inside > start else ROUND_FLOOR
        value = float(Context(prec=3, rounding=rounding).create_decimal_from_float(inside))
        change = Change(
            words=path, unit="", start=start, end=value, needed=value, stated=value, times=value / start, best=math.nan
        )
        eased.append((least, path, change))
    return [(path, change) for _, path, change in sorted(eased, key=lambda one: one[:2])]


def _excess(demands: Demands, drive: Any, values: Mapping[str, float]) -> float:
    """Sum of what demands exceed their allowances by; infinite if there is no such drive."""
    try:
        return float(np.sum(np.maximum(demands(with_values(drive, values)) - 1.0, 0.0)))
    except ParameterError:
        return math.inf
