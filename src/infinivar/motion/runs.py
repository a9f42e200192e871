"""Smoothing of a recorded run that does not close.

A filter that assumes periodicity would smear the end of a run into its start. The run is therefore continued beyond both
ends, until the continuation no longer affects the run, and only then made periodic:

1. Beyond an end at which the quantity is ``x_0`` and its second derivative ``a``, it continues as the odd reflection about the
   parabola: ``x(-t) = 2 (x_0 + a t^2/2) - x(t)``. Value and slope continue by the reflection, the second derivative by the
   parabola, which a least-squares fit gives: over the first wave, or up to three where noise dominates; where rows are
   coarse, the spline through them gives it. The continuation lasts three waves.
2. The straight line through the ends of the continued run is subtracted, which leaves zero at both ends, and the rest is
   reflected to an odd periodic function: a sine series with the low-pass filter of `infinivar.motion.fourier`.

Derivatives of any order follow from the series and the line.

Between the rows of a recording stands a straight line, or a spline where the rows are coarse. A straight line between rows a
time h apart shrinks a frequency f by the factor ``sinc^2(f h)``, by ``(pi f h)^2/3`` to leading order, and adds images of it
at ``1/h - f``, whose acceleration is as large as that of the motion. Rows are coarse where that changes what the filter
passes unchanged, up to half of the cutoff, by more than 1 %: below nine rows in a period of the cutoff.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial import polynomial

from infinivar.motion.fourier import Series

_COARSE = 9.0
"""Rows per period of the cutoff below which they are coarse: (pi/18)^2/3 = 1 % at half of the cutoff."""

STRAIGHT, CUBIC, QUINTIC, SEPTIC = 1, 3, 5, 7
"""Orders of the polynomials between rows."""


_LEAD = 3.0
"""Length of the continuation beyond each end, in waves (periods of the cutoff)."""

_FIT = 1.0
"""Length of the fit at each end, in waves."""

_LONGER = (1.5, 2.0, 3.0)
"""Lengths to which the fit is extended where noise dominates, in waves."""

_AGREES = 2.5
"""Largest change of the curvature with which a longer fit replaces a shorter one, in standard errors of the shorter."""

_CURVED = 3.0
"""A fit has a fourth-order term only if it exceeds this multiple of its standard error."""


@dataclass(frozen=True, slots=True)
class RunSeries:
    """A smoothed quantity over a run: a polynomial in time plus a sine series that starts `lead` before the run.

    Attributes
    ----------
    period : float        Twice the duration of the run: rest is located in the run and its mirror image. [s]
    lead : float          Time by which the series starts before the run. [s]
    series : Series       Sine series.
    polynomial : tuple    Coefficients in ascending order of the time in the run.
    """

    period: float
    lead: float
    series: Series
    polynomial: tuple[float, ...]

    @classmethod
    def through(
        cls,
        time: np.ndarray,
        values: np.ndarray,
        even: np.ndarray,
        cutoff: float,
        curvatures: tuple[float, float] | None = None,
    ) -> RunSeries:
        """Fit a run and remove frequencies above a cutoff.

        Parameters
        ----------
        time, values : (n,) float   Recorded rows; time from 0. [s], any unit
        even : (m + 1,) float       The values at equal steps from the start to the end.
        cutoff : float              [Hz]
        curvatures : (2,) float     Second derivative at both ends; fitted to the rows by default.
        """
        duration = float(time[-1])
        step = duration / (len(even) - 1)
        count = min(math.ceil(_LEAD / (cutoff * step)), len(even) - 1)
        ahead = np.arange(1, count + 1) * step
        if curvatures is None:
            first = _even_part(time, values, 1.0 / cutoff, ahead)
            last = _even_part(duration - time[::-1], values[::-1], 1.0 / cutoff, ahead)
        else:
            first, last = (end + 0.5 * bend * ahead**2 for end, bend in zip(even[[0, -1]], curvatures, strict=True))
        before = 2.0 * first - even[1 : count + 1]
        after = 2.0 * last - even[-2 : -count - 2 : -1]
        whole = np.concatenate([before[::-1], even, after])
        rise = (whole[-1] - whole[0]) / (len(whole) - 1)
        rest = whole - (whole[0] + rise * np.arange(len(whole)))
        odd = np.concatenate([rest[:-1], -rest[:0:-1]])
        lead, slope = count * step, rise / step
        series = Series.through(len(odd) * step, odd, cutoff)
        return cls(2.0 * duration, lead, series, (float(whole[0] + slope * lead), float(slope)))

    def derivatives(self, time: Any, orders: int) -> list[np.ndarray]:
        """Return the quantity and its time derivatives up to an order, at times in the run [s]."""
        time = np.asarray(time, dtype=float)
        found = self.series.derivatives(time + self.lead, orders)
        return [
            part + polynomial.polyval(time, polynomial.polyder(self.polynomial, order))
            for order, part in enumerate(found)
        ]

    def integral(self) -> RunSeries:
        """Integrate the quantity over time, starting at 0."""
        series = self.series.integral()
        offset = float(series.derivatives(np.array([self.lead]), 0)[0][0])
        _, *rising = polynomial.polyint(self.polynomial)
        return RunSeries(self.period, self.lead, series, (-offset, *map(float, rising)))


def odd_reflected(values: np.ndarray) -> np.ndarray:
    """Continue a run at both ends by its odd reflections: three runs in a row."""
    return np.concatenate([2.0 * values[0] - values[::-1], values, 2.0 * values[-1] - values[::-1]])


def mirrored(values: np.ndarray) -> np.ndarray:
    """Append the mirror image of a run, so that it becomes periodic over twice its duration."""
    return np.concatenate([values, values[-2:0:-1]])


def _even_part(time: np.ndarray, values: np.ndarray, wave: float, ahead: np.ndarray) -> np.ndarray:
    """Value and curvature of a quantity at time 0, as a parabola at times `ahead`. [s]

    They are fitted over the first wave, by a polynomial of fourth order where the data show the fourth, else of third. Where
    noise dominates, the fit is extended while the curvature stays the same within its error.
    """
    level, bend, error = _fitted(time, values, wave, _FIT, 4)
    if error == np.inf:
        level, bend, error = _fitted(time, values, wave, _FIT, 3)
    for waves in _LONGER:
        further = _fitted(time, values, wave, waves, 3)
        if not (further[2] < error and abs(further[1] - bend) <= _AGREES * error):
            break
        level, bend, error = further
    return level + bend * (ahead / wave) ** 2


def _fitted(time: np.ndarray, values: np.ndarray, wave: float, waves: float, order: int) -> tuple[float, float, float]:
    """Value, half the second derivative per square wave, and its standard error; inf if the highest order does not show."""
    count = max(int(np.searchsorted(time, waves * wave, side="right")), min(len(time), 6))
    if count < order + 2:
        order = min(order, count - 2)
    design = polynomial.polyvander(time[:count] / wave, order)
    best, *_ = np.linalg.lstsq(design, values[:count], rcond=None)
    spread = float(np.sum((values[:count] - design @ best) ** 2)) / (count - order - 1)
    errors = np.sqrt(spread * np.diag(np.linalg.inv(design.T @ design)))
    if order == 4 and abs(best[4]) <= _CURVED * errors[4]:
        return float(best[0]), float(best[2]), np.inf
    return float(best[0]), float(best[2]), float(errors[2])


def is_coarse(time: np.ndarray, cutoff: float) -> bool:
    """Whether straight lines between rows change what a cutoff [Hz] keeps, by their median step."""
    return float(np.median(np.diff(time))) * cutoff * _COARSE > 1.0


def between(time: np.ndarray, values: np.ndarray, even: np.ndarray, order: int, *, closed: bool = True) -> np.ndarray:
    """Values at equal steps: straight lines between rows, or a spline through them, that of a cycle periodic but for a ramp."""
    if order == STRAIGHT:
        return np.interp(even, time, values)
    from scipy.interpolate import make_interp_spline

    if not closed:
        return make_interp_spline(time, values, k=order)(even)
    rise = (values[-1] - values[0]) / time[-1]
    level = values - rise * time
    level[-1] = level[0]
    return make_interp_spline(time, level, k=order, bc_type="periodic")(even) + rise * even


def run_series(
    time: np.ndarray, values: np.ndarray, even: np.ndarray, cutoff: float, order: int
) -> tuple[RunSeries, np.ndarray]:
    """A run, smoothed, from straight lines between rows or a spline through them, and the values of these."""
    if order == STRAIGHT:
        raw = np.interp(even, time, values)
        return RunSeries.through(time, values, raw, cutoff), raw
    from scipy.interpolate import make_interp_spline

    spline = make_interp_spline(time, values, k=order)
    first, last = spline(time[[0, -1]], 2).tolist()
    raw = spline(even)
    return RunSeries.through(time, values, raw, cutoff, (first, last)), raw


def series_of(
    name: str, time: np.ndarray, values: np.ndarray, count: int, cutoff: float, order: int, *, closed: bool
) -> Series | RunSeries:
    """The position smoothed, without rest, from a recorded position or speed."""
    period = float(time[-1])
    even = np.arange(count + 1) * (period / count)
    if closed:
        share = time / period
        drift = np.trapezoid(values, share) if name == "speed" else (values[-1] - values[0]) * share
        series = Series.through(period, between(time, values - drift, even[:-1], order), cutoff)
    else:
        series, _ = run_series(time, values, even, cutoff, order)
    return series.integral() if name == "speed" else series
