"""Check of a creep law that is given as functions: its properties are tested at a few force ratios."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from infinivar.errors import ParameterError

_RATIOS = np.array([0.0, 0.07, 0.23, 0.41, 0.62, 0.83, 0.96])
"""Force ratios of the probe; odd ones, away from where a law of pieces is likely to have its joints."""

_STEP = 1e-5
"""Step of the difference that `slope` is compared with."""

_ODD = 1e-9
_INVERSE = 0.005
"""Room for laws that interpolate between points of a table, in which force and creepage are separate curves."""

_STEEP = 0.05
"""The same for slopes, relative."""


def check_law(
    creepage: Callable[[Any], Any], slope: Callable[[Any], Any], force: Callable[[Any], Any], slip_creepage: float
) -> None:
    """Raise ParameterError unless the functions of a creep law fit together; the message names the function and the point.

    Probed are: creepage and force are odd, creepage has the sign of the force, so that creep takes power, slope is the
    derivative of creepage, 1 at 0 and never negative, force is the inverse of creepage, and slip begins at `slip_creepage`.
    """
    x = np.concatenate([-_RATIOS[:0:-1], _RATIOS])
    xi = _values("creepage", creepage, x)
    _hold("creepage", "odd in the force ratio", x, xi, -xi[::-1], _ODD)
    _hold("creepage", "of the sign of the force ratio", x, xi, np.sign(x) * np.abs(xi), 0.0)
    if slip_creepage == 1.0:
        _hold("creepage", "equal to the force ratio, as slip_creepage is 1", x, xi, x, _ODD)
    _hold("creepage", "at most slip_creepage", x, xi, np.clip(xi, -slip_creepage, slip_creepage), _INVERSE)
    steep = _values("slope", slope, x)
    _hold("slope", ">= 0", x, steep, np.abs(steep), 0.0)
    _hold("slope", "1", x[x == 0], steep[x == 0], np.ones(1), _STEEP)
    rise = (_values("creepage", creepage, x + _STEP) - _values("creepage", creepage, x - _STEP)) / (2.0 * _STEP)
    _hold("slope", "the derivative of creepage", x, steep, rise, _STEEP * np.maximum(1.0, np.abs(rise)))
    back = _values("force", force, xi)
    _hold("force", "the inverse of creepage", xi, back, x, _INVERSE, of="scaled creepage")
    if np.isfinite(slip_creepage):
        slip = np.array([-slip_creepage, slip_creepage])
        _hold(
            "force", "+-1 at slip_creepage", slip, _values("force", force, slip), np.sign(slip), _INVERSE, of="creepage"
        )


def check_flow(flow_factor: Callable[[Any], Any]) -> None:
    """Raise ParameterError unless a flow factor is even and within 0 to 1, so that it takes power."""
    x = np.concatenate([-_RATIOS[:0:-1], _RATIOS])
    factor = _values("flow_factor", lambda ratio: flow_factor(ratio)[0], x)
    _hold("flow_factor", "even in the force ratio", x, factor, factor[::-1], _ODD)
    _hold("flow_factor", "from 0 to 1", x, factor, np.clip(factor, 0.0, 1.0), 0.0)


def _values(name: str, function: Callable[[Any], Any], at: np.ndarray) -> np.ndarray:
    try:
        return np.broadcast_to(np.asarray(function(at), dtype=float), at.shape)
    except Exception as problem:  # the code of others may fail in any way
        raise ParameterError(
            f"{name} must be a function of a NumPy array of floats, but fails with {type(problem).__name__}: {problem}"
        ) from problem


def _hold(
    name: str, required: str, at: np.ndarray, found: np.ndarray, right: np.ndarray, room: Any, of: str = "force ratio"
) -> None:
    """Raise ParameterError at the first point at which values are not what they should be; nan never is."""
    off = ~(np.abs(found - right) <= room)
    if off.any():
        place = int(np.argmax(off))
        raise ParameterError(
            f"{name} must be {required}, got {found[place]:.6g} at the {of} {at[place]:.4g}"
            + (f" instead of {right[place]:.6g}" if required != ">= 0" else "")
        )
