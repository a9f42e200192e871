"""Warnings about a smoothed recording: how far its rows determine the acceleration, and where a closed one joins its own start.

At the join, steps of force and speed are blurred by smoothing; the acceleration depends on what is between the rows, and on their
noise.

**Between rows.** Splines of order 3, 5 and 7 through coarse rows approach the motion: an image of a frequency f by a spline of
order p, rows a time h apart, has the acceleration of f times ``e^((p-1)/2)``, ``e = (f h/(1 - f h))^2``. With the largest
differences d and d' of neighbouring orders the error of the first, cubic, is the sum of a geometric series, ``d/(1 - d'/d)``. It
is that of the motion's highest frequency where the rows are furthest apart, so a gap among coarse rows is a coarser sampling.
Near the ends of a run, where high orders amplify rounding, it is the first difference alone.

**Noise.** What the rows have in the upper half of their frequencies is taken as noise, with the same power at all frequencies.
Noise of random numbers is added to the rows, which are read again, and its own power in the upper half is estimated the same way.
The ratio of the largest change of the acceleration to that estimate does not depend on the size of the noise. Its largest in
20 draws times the estimate from the rows is an error that 19 of 20 recordings do not exceed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import NamedTuple, Protocol

import numpy as np
from numpy.polynomial import polynomial

from infinivar.axis import Axis
from infinivar.motion.runs import CUBIC, QUINTIC, SEPTIC, STRAIGHT, is_coarse, series_of
from infinivar.motion.spectrum import density
from infinivar.units import percent, plain

_JUMP = 0.05
"""Step of a force or a recorded speed that is reported, as a share of its range."""
_OF_ROWS = 3.0
"""Least ratio of a reported step to the largest one between neighbouring rows."""

_KINK = 0.1
"""Step of the speed of a recorded position that is reported, as a share of the range of the speed."""
_SURE = 5.0
"""Least ratio of a reported step of the speed to its standard error."""
_WAVES = 0.5
"""Length of the fits that give the speed at the ends, in periods of the cutoff."""
_FEWEST = 8
_NEAREST = 4


_PER_WAVE = 40
"""Fewest resampled instants per period of the cutoff."""
_OFF = 0.1
"""Error of the acceleration that is reported, as a share of the largest."""
_LOST = _OFF**2
"""Largest share of the acceleration's power that an advised cutoff removes."""
_SLOWEST = 0.9
"""Largest ratio of differences that is followed: one of less than 1 % is not, as rows are coarse from 1 % up."""
_ENDS = 8.0
"""Rows from the ends of a run on which a spline of seventh order depends on its ends by more than 1 %: 0.54^8."""
_LOWER = 0.8
"""Ratio of cutoffs tried in turn for one with which the acceleration is determined."""
_DRAWS = 20
_FAR = 0.1
"""Share of the reported error below which a first draw is enough: the largest of 20 is not ten times as large."""
_ROWS = 4000
"""Rows of all draws together: the largest error in a long recording varies little."""


class _Read(Protocol):
    """A position as it was read, with its derivatives at times [s]."""

    def derivatives(self, time: np.ndarray, orders: int) -> list[np.ndarray]: ...


class Rows(NamedTuple):
    """Rows of a recording: times from 0 [s], what is recorded, "position" or "speed", and whether they are a cycle."""

    time: np.ndarray
    values: np.ndarray
    name: str
    closed: bool


class _Errors(NamedTuple):
    """Errors of the acceleration, as shares of the largest, and the largest itself. [-], [m s^-2, rad s^-2]"""

    between: float
    noise: float
    largest: float

    @property
    def total(self) -> float:
        return self.between + self.noise


def instants(time: np.ndarray, cutoff: float) -> int:
    """Number of equal steps at which a recording of times from 0 [s] is resampled for a cutoff [Hz]."""
    return max(2 * len(time), int(_PER_WAVE * cutoff * float(time[-1])))


def doubts(
    file: str, rows: Rows, read: Callable[[float], _Read], cutoff: float, lowest: float, axis: Axis
) -> list[str]:
    """Warn if the rows do not determine the acceleration within 10 % of the largest, with ways out.

    Parameters
    ----------
    file : str              Name of the recording in messages.
    rows : Rows
    read : callable         The position as read with a cutoff. [Hz]
    cutoff, lowest : float  The cutoff, and the lowest that the recording allows. [Hz]
    axis : Axis
    """
    order = QUINTIC if is_coarse(rows.time, cutoff) else STRAIGHT
    found = density(rows.time, rows.values, rows.name, order, closed=rows.closed)
    errors = _errors(rows, read(cutoff), found.noise, cutoff)
    if errors.total <= _OFF:
        return []
    lower = cutoff * _LOWER ** np.arange(1, 40)
    kept = (low for low in lower[lower >= lowest].tolist() if found.removed(low, 2) <= _LOST)
    enough = next((low for low in kept if _errors(rows, read(low), found.noise, low).total <= _OFF), None)
    ways = [f'set cutoff = "{plain(enough, 2)} Hz"'] if enough else []
    ways.append("record more rows")
    if rows.name == "position" and errors.noise > errors.between:
        ways.append(f"read a column of {axis.speed}")
    share = percent(found.noise / (float(np.ptp(rows.values)) or 1.0), 2)
    causes = {
        f"{percent(errors.between)} by what is between them": errors.between,
        f"{percent(errors.noise)} by their noise, {share} of the range": errors.noise,
    }
    said = " and ".join(cause for cause, error in causes.items() if error > _FAR * _OFF)
    return [
        f"{file}: the rows do not determine the acceleration: it may be off by up to {said}, of the largest, "
        f"{plain(errors.largest, 3)} {axis.speed_unit}²; {', or '.join(ways)}"
    ]


def _errors(rows: Rows, motion: _Read, noise: float, cutoff: float) -> _Errors:
    """Errors of the acceleration between rows, and of noise in 19 of 20 recordings."""
    time, values, name, closed = rows
    count = instants(time, cutoff)
    # Dense rows are resampled at more instants than the waves need.
    duration = float(time[-1])
    every = max(1, int(count / (_PER_WAVE * cutoff * duration)))
    step = every * duration / count
    span = np.arange(0, count, every) * duration / count

    def read(order: int, values: np.ndarray = values) -> np.ndarray:
        return series_of(name, time, values, count, cutoff, order, closed=closed).derivatives(span, 2)[2]

    coarse = is_coarse(time, cutoff)
    order, resampled = (CUBIC, QUINTIC) if coarse else (STRAIGHT, STRAIGHT)
    _, speed, own = motion.derivatives(span, 2)
    # Where noise hides all acceleration, constant speed may be read throughout.
    largest = float(np.max(np.abs(own)) or np.max(np.abs(read(order))))
    if not (largest and np.any(speed)):
        return _Errors(0.0, 0.0, largest)
    between = 0.0
    if coarse:
        quintic = read(QUINTIC)
        near, far = np.abs(own - quintic), np.abs(quintic - read(SEPTIC))
        ends = 0 if closed else math.ceil(_ENDS * float(np.median(np.diff(time))) / step)
        first, second = (float(np.max(one[ends : len(span) - ends], initial=0.0)) for one in (near, far))
        series_sum = first / (1.0 - min(second / first, _SLOWEST)) if first else 0.0
        between = max(float(np.max(near)), series_sum)
    random = np.random.default_rng(0)
    worst = 0.0
    for _ in range(min(_DRAWS, math.ceil(_ROWS / len(time)))):
        added = noise * random.standard_normal(len(time))
        level = density(time, added, name, resampled, closed=closed).noise
        if level:
            # Smoothing is linear: what noise adds to the rows, it adds by itself.
            worst = max(worst, float(np.max(np.abs(read(order, added)))) * noise / level)
        if worst < _FAR * _OFF * largest:
            break
    return _Errors(between / largest, worst / largest, largest)


def steps_at_join(
    file: str, time: np.ndarray, columns: Mapping[str, np.ndarray], speeds: float, cutoff: float, axis: Axis
) -> list[str]:
    """Warn of steps of force and speed from the end of a closed recording to its start.

    Parameters
    ----------
    file : str                  Name of the recording in messages.
    time : (n,) float           From 0. [s]
    columns : mapping           Position or speed, and force if recorded. (n,)
    speeds : float              Range of the smoothed speed. [m/s, rad/s]
    cutoff : float              [Hz]
    axis : Axis
    """
    found = []
    if "speed" in columns:
        found.append((axis.speed, axis.speed_unit, *_step(columns["speed"])))
    else:
        found.append((axis.speed, axis.speed_unit, *_kink(time, columns["position"], speeds, cutoff)))
    if "force" in columns:
        found.append((axis.force, axis.force_unit, *_step(columns["force"])))
    said = [
        f"the {word} jumps by {plain(abs(step), 3)} {unit}, {percent(share)} of its range"
        for word, unit, step, share in found
        if share
    ]
    if not said:
        return []
    return [
        f"{file}: from the end back to the start, {' and '.join(said)}: the end does not lead into the start, and smoothing "
        "blurs it; if the recording is not one whole cycle, cut it with window, average its strides, or set closed = false"
    ]


def _step(values: np.ndarray) -> tuple[float, float]:
    """Step from the last row to the first, and its share of the range; 0 if it is not to be reported."""
    step, span = float(values[0] - values[-1]), float(np.ptp(values))
    usual = float(np.max(np.abs(np.diff(values))))
    share = abs(step) / span if span else 0.0
    return step, share if share > _JUMP and abs(step) > _OF_ROWS * usual else 0.0


def _kink(time: np.ndarray, values: np.ndarray, speeds: float, cutoff: float) -> tuple[float, float]:
    """Step of the speed from the end to the start, and its share of the range; 0 if it is not to be reported."""
    last, last_error = _slope(float(time[-1]) - time[::-1], values[::-1], _WAVES / cutoff)
    first, first_error = _slope(time, values, _WAVES / cutoff)
    step = first + last  # the last is of the reversed time
    share = abs(step) / speeds if speeds else 0.0
    return step, share if share > _KINK and abs(step) > _SURE * np.hypot(first_error, last_error) else 0.0


def _slope(time: np.ndarray, values: np.ndarray, width: float) -> tuple[float, float]:
    """Slope at time 0 of a cubic through the rows within a width [s], and its standard error."""
    count = min(max(int(np.searchsorted(time, width, side="right")), _FEWEST), len(time))
    scale = float(time[count - 1])
    design = polynomial.polyvander(time[:count] / scale, 3)
    best, *_ = np.linalg.lstsq(design, values[:count], rcond=None)
    spread = float(np.sum((values[:count] - design @ best) ** 2)) / max(count - 4, 1)
    error = np.sqrt(spread * np.linalg.inv(design.T @ design)[1, 1])
    # Where rows are coarse, a cubic through several does not follow the motion: one through the nearest rows shows by how much.
    near, *_ = np.linalg.lstsq(design[:_NEAREST], values[:_NEAREST], rcond=None)
    error = np.hypot(error, (best[1] - near[1]) / _SURE)
    return float(best[1]) / scale, float(error) / scale
