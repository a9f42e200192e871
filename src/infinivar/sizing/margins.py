"""The tightest limit of a design, the margin that it leaves, and which of several misses is the nearest."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from typing import Any, Protocol, TypeVar

import numpy as np

from infinivar.limits import Limit

TaskDemand = tuple[str, Limit, str]
"""Name of a task, limit and part."""

Key = TypeVar("Key")

SAME = 1e-6
"""Share by which two demands may differ and count as equal: about as near as the best radius is found."""


def tightest_of(demands: Mapping[Key, float]) -> Key | None:
    """Limit with the largest demand over allowance; None if no limit is loaded."""
    return max(demands, key=lambda key: demands[key], default=None)


def margin_of(demands: Mapping[Key, float]) -> float:
    """Allowance over demand of the tightest limit. [-]"""
    worst = max(demands.values(), default=0.0)
    return 1.0 / worst if worst > 0.0 else math.inf


def shortfalls(demands: Any) -> np.ndarray:
    """Demands over allowance in falling order, 1 for a limit that is kept and inf for one out of reach.

    Parameters
    ----------
    demands : (m, k) float   By limit and candidate; nan out of reach. [-]
    """
    values = np.asarray(demands, dtype=float)
    return -np.sort(-np.where(np.isnan(values), np.inf, np.maximum(values, 1.0)), axis=0)


def nearest_of(demands: Any, mass: Any) -> int:
    """Place of the candidate that comes nearest to keeping all limits.

    The worst limits count first, of candidates that are equal there the next ones, and so on; then the mass, then the place.

    Parameters
    ----------
    demands : (m, k) float   As for `shortfalls`.
    mass : (k,) float        nan: not stated. [kg]
    """
    left = np.arange(len(mass))
    for beyond in shortfalls(demands):
        here = beyond[left]
        left = left[here <= here.min() * (1.0 + SAME)]
    return int(left[np.argmin(np.nan_to_num(np.asarray(mass, dtype=float)[left], nan=np.inf))])


class Missed(Protocol):
    """A design that exceeds limits."""

    @property
    def demands(self) -> Mapping[TaskDemand, float]:
        """Demand over allowance by limit. [-]"""
        ...

    @property
    def mass(self) -> float:
        """Its mass. [kg]"""
        ...


def nearest_among(missed: Sequence[Missed]) -> int | None:
    """Place of the design that comes nearest to keeping all limits; None if there are none."""
    if not missed:
        return None
    demands = list(itertools.zip_longest(*(one.demands.values() for one in missed), fillvalue=0.0))
    return nearest_of(demands, [one.mass for one in missed])
