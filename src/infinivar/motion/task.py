"""Fields shared by all tasks of a drive, a title and the load, and the check of the motions that other packages add to them."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from annotated_types import Ge

from infinivar._core.arrays import Whole
from infinivar._core.fields import component, given, quantity
from infinivar._core.plugins import is_own
from infinivar.axis import LINEAR, ROTARY, Axis
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


@dataclass(frozen=True, slots=True, kw_only=True)
class Task(Whole):
    """Base of `DutyCycle` and `Scenario`."""

    title: str = component("Name for reports", default="")
    load_mass: float | None = quantity(
        "kg",
        Ge(0),
        "Mass of the load; defaults to the requirement's, but to none for walking and running, where the torque includes it",
        default=None,
    )

    load_inertia: float | None = quantity(
        "kg m^2",
        Ge(0),
        "Moment of inertia of the load about the joint; defaults as load_mass does along a line",
        default=None,
    )

    @property
    def axis(self) -> Axis:
        """Whether the load moves along a line or about a joint."""
        raise NotImplementedError

    @property
    def moved_mass(self) -> float:
        """Mass of the load, or its moment of inertia about the joint; 0 if none is set. [kg], [kg m^2]"""
        return given(self.load_mass, given(self.load_inertia, 0.0))

    def loaded(self, mass: float | None) -> Self:
        """Return the task with this load mass, or inertia about its joint, unless it has its own. [kg], [kg m^2]"""
        if mass is None or self.load_mass is not None or self.load_inertia is not None:
            return self
        return dataclasses.replace(self, **{"load_inertia" if self.axis.rotary else "load_mass": mass})

    def _common_axis(self, motion: Axis | None, *others: tuple[str, Axis]) -> Axis:
        """Axis of the task's motion, mass and other parts; None for a motion that is at rest about any.

        Raises
        ------
        ParameterError
            If they differ.
        """
        stated = [(name, axis) for name, axis in _MASSES if getattr(self, name) is not None] + list(others)
        first, axis = ("the motion", motion) if motion is not None else stated[0] if stated else ("", LINEAR)
        for name, other in stated:
            if other is not axis:
                way = {True: "about a joint", False: "along a line"}
                hint = f"; write {_COUNTERPARTS[name]}" if name in _COUNTERPARTS else ""
                raise ParameterError(f"{name} is {way[other.rotary]}, but {first} is {way[axis.rotary]}{hint}")
        return axis


def check_task(field: str, value: object, kind: type[Task], group: str, more: str = "") -> None:
    """Raise ParameterError unless a value is a task of this kind; the message says what to write in its place.

    Parameters
    ----------
    field : str   Name of the argument.
    value : object
    kind : type   `DutyCycle` or `Scenario`.
    group : str   Tasks of the kind in a study: "duty".
    more : str    What the kind needs besides a motion, as written: ", duration=...".
    """
    if isinstance(value, kind):
        return
    how, what = "", f"a {type(value).__name__}"
    if isinstance(value, str):
        how, what = f"; write study.{group}[{value!r}]", repr(value)
    elif hasattr(value, "motion") or callable(getattr(value, "at", None)):
        motion = f"{field}.motion" if hasattr(value, "motion") else f"{field}"
        how = f"; write iv.{kind.__name__}(motion={motion}{more})"
    raise ParameterError(f"{field} must be a {kind.__name__}, got {what}{how}")


_MASSES = (("load_mass", LINEAR), ("load_inertia", ROTARY))

_COUNTERPARTS = {"load_mass": "load_inertia", "load_inertia": "load_mass", "force": "moment", "moment": "force"}
"""The key to write instead for the other axis."""


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
    """Return what a motion's `derivatives` or `push` gives; raises ParameterError if these are fewer than requested."""
    name = f"{type(motion).__name__}.{method}"
    required = f"{orders + 1} values for {orders} orders, the value itself and its derivatives"
    try:
        found = getattr(motion, method)(time, orders)
    except InfinivarError:
        raise
    except Exception as problem:  # the code of others may fail in any way
        if not is_own(motion):
            raise
        raise ParameterError(
            f"{name}(time, orders) fails with {type(problem).__name__}: {problem}; expected {required}"
        ) from problem
    if not isinstance(found, (list, tuple, np.ndarray)):
        raise ParameterError(f"{name} must return {required}; got a {type(found).__name__}")
    if len(found) <= orders:
        raise ParameterError(f"{name} must return {required}; got {len(found)}")
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
