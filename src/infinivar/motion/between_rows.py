r"""Between the rows of a recording: a straight line, or a spline where the rows are coarse.

A straight line between rows a time h apart shrinks a frequency f by the factor ``sinc^2(f h)``, by ``(pi f h)^2/3`` to leading
order, and adds images of it at ``1/h - f``, whose acceleration is as large as that of the motion. Rows are coarse where that
changes what the filter passes unchanged, up to half of the cutoff, by more than 1 %: below nine rows in a period of the cutoff.
"""

from __future__ import annotations

import numpy as np

from infinivar.motion.fourier import Series
from infinivar.motion.runs import RunSeries

_COARSE = 9.0
"""Rows per period of the cutoff below which they are coarse: (pi/18)^2/3 = 1 % at half of the cutoff."""

STRAIGHT, CUBIC, QUINTIC, SEPTIC = 1, 3, 5, 7
"""Orders of the polynomials between rows."""


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
