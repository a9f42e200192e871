"""Histories of several quantities at once: the pose or angles that a machine follows, or the wrench of a user."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from annotated_types import Gt

from infinivar._core.array_namespace import Array
from infinivar._core.arrays import real_array
from infinivar._core.fields import check, check_number, component
from infinivar._core.frozen import frozen
from infinivar.errors import require


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class VectorHistory:
    """Values of d quantities over time; before and after, they stay what they are at the ends.

    Raises
    ------
    ParameterError
        If times do not increase, a value is not finite, or their numbers differ.
    """

    time: Array = component("Increasing instants, (n,) [s]")
    values: Array = component("Values at the instants, (n, d)")
    smooth: bool = component("Whether a cubic spline joins the values, or straight lines", default=True)
    _pieces: Any = field(init=False, repr=False, compare=False, default=None)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        time, values = real_array("time", self.time), real_array("values", self.values)
        rises = time.ndim == 1 and len(time) > 1 and bool(np.all(np.isfinite(time)) and np.all(np.diff(time) > 0))
        require(rises, "time", f"shape {time.shape}", "two increasing instants or more", "s")
        fits = values.ndim == 2 and len(values) == len(time)
        require(fits, "values", f"shape {values.shape}", f"of shape ({len(time)}, quantities)")
        require(bool(np.all(np.isfinite(values))), "values", "nan or inf", "finite")
        object.__setattr__(self, "time", frozen(time))
        object.__setattr__(self, "values", frozen(values))
        from scipy.interpolate import CubicSpline, PPoly

        slopes = np.diff(values, axis=0) / np.diff(time)[:, None]
        made = CubicSpline(time, values) if self.smooth else PPoly(np.stack([slopes, values[:-1]]), time)
        object.__setattr__(self, "_pieces", (made, made.derivative(), made.derivative(2)))

    @classmethod
    def of(cls, function: Callable[[float], Any], duration: float, points: int = 201) -> VectorHistory:
        """Samples of a smooth function of time over a duration [s].

        Raises
        ------
        ParameterError
            If it is not a function, or the duration or the number of points cannot be sampled; the message names it.
        """
        require(callable(function), "function", repr(function), "a function of time")
        check_number("duration", duration, "s", Gt(0))
        whole = isinstance(points, int) and not isinstance(points, bool) and points >= 2
        require(whole, "points", repr(points), "a whole number, 2 or more")
        time = np.linspace(0.0, duration, points)
        return cls(time=time, values=np.array([np.atleast_1d(function(float(one))) for one in time]))

    @property
    def count(self) -> int:
        """Number of quantities, d."""
        return self.values.shape[1]

    def __call__(self, time: float) -> np.ndarray:
        """Values at a time. (d,)"""
        return self._pieces[0](min(max(time, self.time[0]), self.time[-1]))

    def rate(self, time: float) -> np.ndarray:
        """Their time derivatives; 0 before and after. (d,)"""
        return self._derivative(1, time)

    def acceleration(self, time: float) -> np.ndarray:
        """Their second derivatives; 0 before and after. (d,)"""
        return self._derivative(2, time)

    def _derivative(self, order: int, time: float) -> np.ndarray:
        inside = self.time[0] <= time <= self.time[-1]
        return self._pieces[order](time) if inside else np.zeros(self.count)
