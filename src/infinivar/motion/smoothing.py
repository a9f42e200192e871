r"""Recorded motions: made periodic, smoothed, and set to rest where the recording resolves no motion.

A smoothed recording is never exactly at rest: filter ringing and rounding leave a small speed with a sign, and Coulomb
friction acts in full at any speed. Rest is therefore detected in the recording itself, by one rule for positions, speeds
and forces:

    a quantity is constant while, for at least one period of the cutoff (a *wave*), it stays within its resolution.

The resolution is the larger of half a count of the recording and the noise amplitude expected within a wave. In these
intervals, called stays, the quantity is constant; at their ends it blends into the smoothed one within half a wave. The
same rule, applied to the mean speed over one wave, detects steady motion: acceleration is zero there, so that noise does
not steer a wheel.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from infinivar.axis import LINEAR, Axis
from infinivar.errors import InputError, ParameterError
from infinivar.motion.fourier import Series
from infinivar.motion.rest import (
    Masks,
    Resolution,
    Stay,
    apart,
    intervals,
    long_enough,
    noise_of,
    rest_of_speed,
    rest_of_value,
    settled,
)
from infinivar.motion.runs import CUBIC, STRAIGHT, RunSeries, between, is_coarse, mirrored, odd_reflected, run_series
from infinivar.motion.smoothing_warnings import Rows, doubts, instants, steps_at_join
from infinivar.motion.spectrum import Density, density
from infinivar.units import percent, plain, rounded_up

_LEAST_ROWS = 8
_STAY_ROWS = 3.0
"""Shortest stay, in steps between rows: a smooth motion has two equal rows at a reversal, not four."""
GAP = 5.0
"""Steps longer than the median step by more than this factor count as gaps."""
DRIFT = 0.05
"""Largest difference between the start and the end of a recorded motion, as a share of its range."""

_REMOVED = 0.05
"""Largest share of the speed's power that smoothing removes without a warning. A motion at constant speed to and fro, whose
reversals are rounded, loses 4 % if its cutoff is ten times its frequency."""

_KEPT = 0.99
"""Share of the speed's power that a cutoff advised by a warning passes unchanged."""

_SLOW = 0.01
"""Share of the largest speed below which, for a while, the load may be meant to be at rest."""

_SLOW_WAVES = 3.0
"""Shortest slow interval considered, in waves."""

_SLOW_SHARE = 0.05
"""Largest total of slow intervals without a warning, as a share of the period."""

_BINOMIALS = tuple(tuple(math.comb(order, part) for part in range(order + 1)) for order in range(7))

_STEP = np.polynomial.Polynomial([0, 0, 0, 0, 0, 126, -420, 540, -315, 70])
"""Smooth step from 0 at 0 to 1 at 1, with four derivatives zero at both ends."""


@dataclass(frozen=True, slots=True)
class Smoothed:
    """A smoothed quantity over a cycle or a run, with constant intervals (stays); derivatives up to the sixth.

    Attributes
    ----------
    series                The quantity outside its stays.
    stays : (n, 3) float  Start, end and value of each stay, in order; an end may exceed the period. [s], [s], any unit
    steady : (m, 2) float Start and end of intervals in which all derivatives from the second up are zero. [s]
    blend : float         Time before and after a stay in which the quantity blends into the series. [s]
    resolution : float    Deviation within which the quantity counts as constant. Any unit
    """

    series: Series | RunSeries
    stays: np.ndarray
    steady: np.ndarray
    blend: float
    resolution: float

    def derivatives(self, time: Any, orders: int) -> list[np.ndarray]:
        """Return the quantity and its time derivatives up to an order, at times [s]."""
        time = np.asarray(time, dtype=float)
        found = self.series.derivatives(time, orders)
        period = self.series.period
        if len(self.stays):
            begin, end, value = self.stays.T
            last = (np.searchsorted(begin, time % period, side="right") - 1) % len(begin)
            following = (last + 1) % len(begin)
            since, length = (time - begin[last]) % period, (end - begin)[last]
            room = (begin[following] - begin[last]) % period
            room = np.where(room == 0.0, period, room)  # a single stay follows itself
            width = np.maximum(np.minimum(self.blend, 0.5 * (room - length)), 1e-9 * period)
            found = _blended(found, value[last], since - length, width, 1.0)
            found = _blended(found, value[following], room - since, width, -1.0)
            still = since <= length
            found = [np.where(still, 0.0 if order else value[last], part) for order, part in enumerate(found)]
        if len(self.steady):
            begin, end = self.steady.T
            last = (np.searchsorted(begin, time % period, side="right") - 1) % len(begin)
            steady = (time - begin[last]) % period <= (end - begin)[last]
            found = [np.where(steady, 0.0, part) if order > 1 else part for order, part in enumerate(found)]
        return found


def _blended(
    found: list[np.ndarray], value: np.ndarray, away: np.ndarray, width: np.ndarray, sign: float
) -> list[np.ndarray]:
    """Blend a quantity and its derivatives from a constant at the end of a stay to itself over `width` [s]."""
    share = np.clip(away / width, 0.0, 1.0)
    steps = [(sign / width) ** order * (_STEP.deriv(order) if order else _STEP)(share) for order in range(len(found))]
    off = [found[0] - value, *found[1:]]
    made = [
        sum(factor * steps[part] * off[order - part] for part, factor in enumerate(_BINOMIALS[order]))
        for order in range(len(found))
    ]
    return [np.where(away < width, part + (0.0 if order else value), found[order]) for order, part in enumerate(made)]


class Cycle(NamedTuple):
    """One smoothed cycle or run: duration [s], position [m], force on the load [N] if recorded, and warnings."""

    period: float
    motion: Smoothed
    force: Smoothed | None
    warnings: tuple[str, ...]


def smoothed(
    file: str,
    columns: Mapping[str, np.ndarray],
    lines: Sequence[int],
    cutoff: float,
    resolution: float | None = None,
    axis: Axis = LINEAR,
    *,
    closed: bool = True,
    spread: bool = False,
) -> Cycle:
    """Smooth one cycle of a motion, or a run, from recorded columns.

    Parameters
    ----------
    file : str           Name of the recording in messages.
    columns : mapping    Increasing times, either position or speed, and force if recorded, by name, in SI.
    lines : sequence     Line of the file for each row.
    cutoff : float       Frequency above which everything is removed. [Hz]
    resolution : float   Deviation within which the load counts as at rest; estimated from the recording by default. [m]
    axis : Axis          Whether the motion is along a line or about a joint, for messages.
    closed : bool        Whether it is one cycle, made periodic; if not, a run that may end anywhere.
    spread : bool        Whether a cycle is made periodic however far its end is from its start.

    Returns
    -------
    Cycle

    Raises
    ------
    InputError
        If the recording has too few rows, or a cycle does not end where it begins.
    ParameterError
        If a cycle is shorter than two periods of the cutoff, or a run than one.
    """
    time = columns["time"] - columns["time"][0]
    if len(time) < _LEAST_ROWS:
        raise InputError(f"{file}: line {lines[-1]}: must have at least {_LEAST_ROWS} rows of numbers, got {len(time)}")
    period, step = float(time[-1]), float(np.median(np.diff(time)))
    if cutoff < lowest_cutoff(period, closed=closed) * (1.0 - 1e-9):
        need = "to keep one cycle in" if closed else "one period in"
        raise ParameterError(
            f"cutoff must be >= {rounded_up(lowest_cutoff(period, closed=closed))} Hz, {need} a recording of "
            f"{plain(period, 3)} s, got {cutoff:g} Hz"
        )
    coarse = is_coarse(time, cutoff)
    warnings = _sampling(file, time, lines, step, cutoff, coarse=coarse)
    count = instants(time, cutoff)
    span = np.arange(count) * (period / count)

    moved = "position" if "position" in columns else "speed"
    without_drift = _closed(file, moved, columns[moved], time / period, warnings, axis, spread) if closed else None

    def made(name: str, cutoff: float = cutoff) -> Smoothed:
        requested = resolution if name == "position" else None
        order = CUBIC if is_coarse(time, cutoff) else STRAIGHT
        count = instants(time, cutoff)
        if not closed:
            return _fit_run(name, time, columns[name], count, cutoff, requested, order)
        drift = None if name == "force" else without_drift
        return _fit_cycle(name, time, columns[name], drift, count, cutoff, requested, order)

    motion = made(moved)
    warnings += _cut_off(file, density(time, columns[moved], moved, closed=closed), cutoff, axis)
    rows = Rows(time, columns[moved], moved, closed)
    lowest = lowest_cutoff(period, closed=closed)
    warnings += doubts(file, rows, lambda low: motion if low == cutoff else made(moved, low), cutoff, lowest, axis)
    if closed:
        speeds = float(np.ptp(motion.derivatives(span, 1)[1]))
        warnings += steps_at_join(file, time, columns, speeds, cutoff, axis)
    if resolution is None:
        warnings += _slow(file, motion, span, period, cutoff, axis)
    return Cycle(period, motion, made("force") if "force" in columns else None, tuple(warnings))


def lowest_cutoff(period: float, *, closed: bool) -> float:
    """Lowest cutoff for a recording [s]: one that passes a cycle's lowest frequency unchanged, or fits in a run. [Hz]"""
    return (2.0 if closed else 1.0) / period


def _cut_off(file: str, found: Density, cutoff: float, axis: Axis) -> list[str]:
    """Warn of a cutoff that removes a part of the motion itself."""
    share = found.removed(cutoff)
    if share <= _REMOVED:
        return []
    enough = rounded_up(2.0 * found.below(_KEPT))
    return [
        f"{file}: smoothing with a cutoff of {plain(cutoff, 3)} Hz removes {percent(share)} of the power of the recorded "
        f'{axis.speed} above its noise; cutoff = "{enough} Hz" keeps it'
    ]


def _sampling(
    file: str, time: np.ndarray, lines: Sequence[int], step: float, cutoff: float, *, coarse: bool
) -> list[str]:
    """Warn of gaps, and of steps too long for the cutoff."""
    warnings = [
        f"{file}: line {lines[place + 1]}: {plain(time[place + 1] - time[place], 3)} s without data, "
        f"{plain(width, 3)} times the median step; interpolated {'by a cubic spline' if coarse else 'linearly'}"
        for place, width in enumerate(np.diff(time) / step)
        if width > GAP
    ]
    if 2.0 * step * cutoff > 1.0:
        warnings.append(
            f"{file}: a step of {plain(step, 3)} s resolves frequencies up to {plain(0.5 / step, 3)} Hz only; "
            f"the cutoff is {plain(cutoff, 3)} Hz"
        )
    return warnings


def _fit_cycle(
    name: str,
    time: np.ndarray,
    values: np.ndarray,
    without_drift: np.ndarray | None,
    count: int,
    cutoff: float,
    resolution: float | None,
    order: int,
) -> Smoothed:
    """Smooth a column of a cycle, made periodic; `without_drift` are its values without what keeps it from closing, if any."""
    period = float(time[-1])
    step = period / count
    even = np.arange(count) * step
    raw = between(time, values, even, order)
    closed = raw if without_drift is None else between(time, without_drift, even, order)
    series = Series.through(period, closed, cutoff)
    resolves, own = _resolution(time, values, closed, series.derivatives(even, 0)[0], cutoff, resolution)
    # Include the neighbouring cycles, as a stay may extend past the end: once as recorded, in case all drift occurs in
    # the moves, and once made periodic, which removes the drift of a sensor.
    drift = float(values[-1] - values[0]) if name == "position" else 0.0
    rows = np.interp(even, time, values)
    courses = [np.concatenate([rows - drift, rows, rows + drift])]
    if without_drift is not None:
        courses.append(np.tile(np.interp(even, time, without_drift), 3))
    slow = _slowest(time, cutoff)
    if name == "speed":
        position = series.integral()
        masks = rest_of_speed(courses, step, slow, resolves)
        reach = resolves.reach / slow
        return _with_stays(position, position.derivatives(even, 0)[0], masks, slow, reach, reach)
    return _with_stays(series, closed, rest_of_value(courses, step, slow, resolves), slow, resolves.reach, own)


def _fit_run(
    name: str, time: np.ndarray, values: np.ndarray, count: int, cutoff: float, resolution: float | None, order: int
) -> Smoothed:
    """Smooth a column of a run; rest is located in the run followed by its mirror image, which is periodic."""
    step = float(time[-1]) / count
    even = np.arange(count + 1) * step
    series, raw = run_series(time, values, even, cutoff, order)
    resolves, own = _resolution(time, values, raw, series.derivatives(even, 0)[0], cutoff, resolution)
    courses = [odd_reflected(np.interp(even, time, values))]
    slow = _slowest(time, cutoff)
    if name == "speed":
        position = series.integral()
        masks = rest_of_speed(courses, step, slow, resolves)
        values, reach, own = position.derivatives(even, 0)[0], resolves.reach / slow, resolves.reach / slow
    else:
        position, values, reach = series, raw, resolves.reach
        masks = rest_of_value(courses, step, slow, resolves)
    return _with_stays(position, mirrored(values), Masks(*map(mirrored, masks)), slow, reach, own)


def _slowest(time: np.ndarray, cutoff: float) -> float:
    """Frequency of the wave for which rest lasts at least: the cutoff, or less where rows are coarse. [Hz]"""
    return min(cutoff, 1.0 / (_STAY_ROWS * float(np.median(np.diff(time)))))


def _resolution(
    time: np.ndarray,
    values: np.ndarray,
    resampled: np.ndarray,
    smooth: np.ndarray,
    cutoff: float,
    requested: float | None,
) -> tuple[Resolution, float]:
    """Resolution that counts, and that of the recording itself, regardless of the requested one."""
    rows = 1.0 / (cutoff * float(np.median(np.diff(time))))
    found = Resolution.of(values, noise_of(values, resampled, smooth), rows)
    return (found if requested is None else Resolution(requested, 2.0 * requested)), found.reach


def _slow(file: str, motion: Smoothed, even: np.ndarray, period: float, cutoff: float, axis: Axis) -> list[str]:
    """Warn if the load moves very slowly for a while without resting, as filtered noise does."""
    position, speed = motion.derivatives(even, 1)
    step = float(even[1])
    slow = (np.abs(speed) <= _SLOW * np.max(np.abs(speed))) & (speed != 0.0)
    found = intervals(long_enough(slow, _SLOW_WAVES / (cutoff * step)))
    lasts = sum(last - first for first, last in found) * step
    if lasts <= _SLOW_SHARE * period:
        return []
    spreads = [np.ptp(np.take(position, range(first, last + 1), mode="wrap")) for first, last in found]
    widest = float(max(spreads))
    setting = (
        f'angle_resolution = "{plain(math.degrees(widest), 2)} deg"'
        if axis.rotary
        else f'resolution = "{plain(1e3 * widest, 2)} mm"'
    )
    return [
        f"{file}: for {plain(lasts, 3)} of {plain(period, 3)} s the load moves at less than "
        f"{percent(_SLOW)} of its largest speed; if it is at rest there, set {setting}"
    ]


def _with_stays(
    series: Series | RunSeries, values: np.ndarray, masks: Masks, cutoff: float, resolved: float, own: float
) -> Smoothed:
    """Set a quantity to rest where it is constant; `own` is the resolution of the recording itself."""
    still, steady = masks
    step, wave = series.period / values.size, 1.0 / cutoff
    stays = []
    for first, last in intervals(still):
        inside = np.take(values, range(first, last + 1), mode="wrap")
        if resolved > own and last - first < values.size:
            begin, end = settled(inside, own)
            first, last, inside = first + begin, first + end, inside[begin : end + 1]
        stays.append(Stay(first * step, last * step, float(np.median(inside))))
    moving = [(first * step, last * step) for first, last in intervals(long_enough(steady & ~still, wave / step))]
    return Smoothed(
        series=series,
        stays=np.reshape(np.array(apart(stays, series.period, wave, resolved), dtype=float), (-1, 3)),
        steady=np.reshape(np.array(moving, dtype=float), (-1, 2)),
        blend=0.5 * wave,
        resolution=resolved,
    )


def _closed(
    file: str, name: str, values: np.ndarray, share: np.ndarray, warnings: list[str], axis: Axis, spread: bool
) -> np.ndarray:
    """Make recorded values periodic: remove the drift of a position, or the mean of a speed.

    Raises
    ------
    InputError
        If the drift or the mean is too large.
    """
    span = float(np.ptp(values)) or 1.0
    drift = float(np.trapezoid(values, share) if name == "speed" else values[-1] - values[0])
    if abs(drift) > DRIFT * span and not spread:
        raise InputError(
            f"{file}: must be one cycle that ends where it starts, but {open_end(name, drift, span, axis)}"
        )
    if abs(drift) > 1e-3 * span:
        warnings.append(f"{file}: {_finding(name, drift, span, axis, 1)}; removed evenly over the cycle")
    return values - (drift if name == "speed" else drift * share)


def _finding(name: str, drift: float, span: float, axis: Axis, digits: int = 0) -> str:
    """How far a recording ends from its start, or the mean of its speed."""
    said = (
        f"the mean {axis.speed} is {plain(drift, 3)} {axis.speed_unit}"
        if name == "speed"
        else f"the {axis.position} ends {plain(drift, 3)} {axis.position_unit} from its start"
    )
    return f"{said}, {percent(abs(drift) / span, digits)} of the range"


def open_end(name: str, drift: float, span: float, axis: Axis) -> str:
    """What keeps a recording of a position or speed from being a cycle, and the ways out, for messages."""
    speed = f"{axis.speed.replace(' ', '_')} = ..."
    by_speed = (
        "" if name == "speed" else f", read a column of {axis.speed} instead with columns = {{ time = ..., {speed} }}"
    )
    return (
        f"{_finding(name, drift, span, axis)}; cut out a whole cycle with window{by_speed}, remove the difference evenly with "
        'closure = "spread", or for a run, which may end anywhere, set closed = false'
    )
