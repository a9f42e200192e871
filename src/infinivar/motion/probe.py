"""Check of periodic motions of other packages: their derivatives belong together, and a cycle ends where it began."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from infinivar._core.plugins import is_own
from infinivar.errors import InfinivarError, ParameterError

_INSTANTS = 16
_ORDERS = 4
"""Derivatives that every drive needs."""

_STEPS = 2000
"""Steps of a cycle by which differences are taken, as in duty cycles; more for fast motions."""

_OFF = 0.02
"""Largest difference between a derivative and that of the order below it, relative to its largest value."""

_MOST_JUMPS = 0.25
"""Share of the instants at which they may differ all the same: a derivative may jump there."""

_CLOSES = 1e-6
"""Largest difference between start and end of a cycle, relative to the travel or the largest speed."""

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(3)


def check_motion(motion: Any) -> None:
    """Raise ParameterError unless a periodic motion is one: a period, finite derivatives that fit, and a cycle that closes."""
    name, period = type(motion).__name__, motion.period
    if not (isinstance(period, (int, float, np.number)) and math.isfinite(period) and period > 0):
        raise ParameterError(f"{name}.period must be > 0 s, got {period!r}")
    step = float(period) / max(_STEPS, 40.0 * motion.fastest * period)
    # Irregular, so that a motion that repeats within its period is not always at the same place.
    start = np.sort((0.5 + np.arange(_INSTANTS) * 0.618034) % 1.0) * (period - 2.0 * step) + 0.5 * step
    inner = start[:, None] + 0.5 * step * (1.0 + _NODES)
    time = np.concatenate([start, start + step, inner.ravel()])
    _check_rates(motion, "derivatives", time, _ORDERS, step)
    _check_rates(motion, "push", time, _ORDERS - 2, step)
    if motion.repeats:
        _check_closes(motion, time)


def enough(motion: Any, method: str, time: Any, orders: int) -> list[Any]:
    """Return what a motion's `derivatives` or `push` gives; raises ParameterError if these are fewer than asked for."""
    name = f"{type(motion).__name__}.{method}"
    wanted = f"{orders + 1} values for {orders} orders, the value itself and its derivatives"
    try:
        found = getattr(motion, method)(time, orders)
    except InfinivarError:
        raise
    except Exception as problem:  # the code of others may fail in any way
        if not is_own(motion):
            raise
        raise ParameterError(
            f"{name}(time, orders) fails with {type(problem).__name__}: {problem}; expected {wanted}"
        ) from problem
    if not isinstance(found, (list, tuple, np.ndarray)):
        raise ParameterError(f"{name} must return {wanted}; got a {type(found).__name__}")
    if len(found) <= orders:
        raise ParameterError(f"{name} must return {wanted}; got {len(found)}")
    return list(found)


def _check_rates(motion: Any, method: str, time: np.ndarray, orders: int, step: float) -> None:
    name = f"{type(motion).__name__}.{method}"
    found = [np.broadcast_to(np.asarray(one, dtype=float), time.shape) for one in enough(motion, method, time, orders)]
    for order, values in enumerate(found):
        if not np.all(np.isfinite(values)):
            bad = int(np.argmin(np.isfinite(values)))
            raise ParameterError(f"{name}: order {order} must be finite, got {values[bad]} at {time[bad]:.6g} s")
    for order in range(1, orders + 1):
        rate, below = found[order], found[order - 1]
        gained = below[_INSTANTS : 2 * _INSTANTS] - below[:_INSTANTS]
        integral = 0.5 * step * (rate[2 * _INSTANTS :].reshape(_INSTANTS, -1) @ _WEIGHTS)
        largest = max(step * float(np.max(np.abs(rate))), float(np.max(np.abs(gained))))
        rounding = 1e-13 * float(np.max(np.abs(below)))
        off = np.abs(gained - integral) > _OFF * largest + rounding
        if np.mean(off) > _MOST_JUMPS:
            worst = int(np.argmax(np.abs(gained - integral)))
            raise ParameterError(
                f"{name}: order {order} must be the time derivative of order {order - 1}; at {time[worst]:.4g} s it is "
                f"{integral[worst] / step:.4g} instead of {gained[worst] / step:.4g}"
            )


def _check_closes(motion: Any, time: np.ndarray) -> None:
    name = type(motion).__name__
    ends = enough(motion, "derivatives", np.array([0.0, float(motion.period)]), 1)
    course = enough(motion, "derivatives", time, 1)
    for order, (what, size) in enumerate((("position", np.ptp(course[0])), ("speed", np.max(np.abs(course[1]))))):
        first, last = np.broadcast_to(np.asarray(ends[order], dtype=float), (2,))
        if abs(last - first) > _CLOSES * float(size) + 1e-12 * abs(first):
            raise ParameterError(
                f"{name}: a motion that repeats must end where it began, but its {what} is {first:.6g} at 0 s and {last:.6g} "
                f"at the end of the period, {motion.period:.6g} s; a run has repeats = False"
            )
