"""The tightest limit of a machine, and wrenches, twists and poses in words."""

from __future__ import annotations

import functools
from collections.abc import Iterator, Mapping

import numpy as np

from infinivar.limits import LEADING, Demand, Limit, words_of
from infinivar.machines.machine import unit_of
from infinivar.units import margin_words, plain

_LOADED = 1e-6
"""Demand over allowance below which a limit counts as not loaded. [-]"""

ALIKE = 1e-9
"""Relative difference below which demands are equal but for rounding, as those of legs placed alike."""

_NO_DEMAND: Demand = (Limit.OK, "load")


def tightest_of(demands: Mapping[Demand, float]) -> tuple[Demand, float]:
    """The largest demand, the first of equal ones, with its margin.

    A linkage out of reach and slip take precedence, as in `infinivar.limits.binding`.
    """
    exceeded = [
        (limit.value, key)
        for limit in reversed(LEADING)
        for key in demands
        if key[0] is limit and not demands[key] <= 1.0
    ]
    if exceeded:
        first = exceeded[0][1][0]
        worst = functools.reduce(
            lambda one, other: other if _size(demands[other]) > _size(demands[one]) else one,
            [key for key in demands if key[0] is first],
        )
        return worst, 1.0 / _size(demands[worst])
    known = {key: value for key, value in demands.items() if value > _LOADED}  # infinite where an allowance is zero
    if not known:
        return _NO_DEMAND, float("inf")
    most = max(known.values())
    return next(key for key in known if known[key] >= most * (1.0 - ALIKE)), 1.0 / most


def _size(demand: float) -> float:
    return float("inf") if np.isnan(demand) else demand


def tight_words(demand: Demand, margin: float) -> str:
    """A tightest limit in words, with its margin."""
    if demand == _NO_DEMAND:
        return "no limit is loaded"
    if margin >= 1.0:
        return f"tightest limit: {words_of(demand)} (margin {margin_words(margin)})"
    if margin == 0.0 and demand[0] is Limit.LINKAGE:
        return "pose out of reach, or singular, where the links leave a motion of the machine free"
    if margin == 0.0:
        return f"no steady {'motion' if demand[0] in LEADING else 'operation'}: {words_of(demand)}"
    share = "just under 100" if margin >= 0.995 else f"{100 * margin:.0f}" if margin >= 0.005 else "less than 1"
    return f"tightest limit: {words_of(demand)}, {share} % of the demand"


def corner_words(coordinates: tuple[str, ...], values: np.ndarray, what: str) -> str:
    """A vector as "x 20 N, rz 0.1 N m", without zeros."""
    return ", ".join(vector_words(coordinates, values, what)) or "no load"


def vector_words(coordinates: tuple[str, ...], values: np.ndarray, what: str) -> Iterator[str]:
    """Yield each component that is not zero, with its unit; angles of poses in degrees."""
    for name, value in zip(coordinates, values, strict=True):
        unit = unit_of(name, what)
        if value != 0.0:
            yield (
                f"{name} {plain(float(np.degrees(value)), 3)}°"
                if unit == "rad"
                else f"{name} {plain(float(value), 3)} {unit}"
            )
