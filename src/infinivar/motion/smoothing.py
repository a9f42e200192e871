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

from infinivar.errors import InputError, ParameterError
from infinivar.motion.fourier import Series
from infinivar.units import percent, plain

_DEVIATIONS = 3.0
"""Tolerance on the mean slope over a wave, in standard errors."""

_ROUNDING = 1e-7
"""Finest resolution assumed, relative to the size of a quantity: that of seven digits or single precision."""

_LEAST_ROWS = 8
_PER_WAVE = 40
"""Fewest resampled instants per wave."""
_GAP = 5.0
"""Steps longer than the median step by more than this factor count as gaps."""
_DRIFT = 0.05
"""Largest difference between the start and the end of a recorded motion, as a share of its range."""

_SLOW = 0.01
"""Share of the largest speed below which, for a while, the load may be meant to be at rest."""

_SLOW_WAVES = 3.0
"""Shortest slow interval considered, in waves."""

_SLOW_SHARE = 0.05
"""Largest total of slow intervals without a warning, as a share of the period."""

_STEADY = 4.0
"""Shortest steady interval, in waves; around its largest speed any motion looks steady for a while."""

_UNEVEN = 0.1
"""Largest deviation of a difference from a multiple of a count, in counts."""

_IRREGULAR = 6
"""Order of the row-to-row differences that show noise but not motion."""

_BINOMIALS = tuple(tuple(math.comb(order, part) for part in range(order + 1)) for order in range(7))

_STEP = np.polynomial.Polynomial([0, 0, 0, 0, 0, 126, -420, 540, -315, 70])
"""Smooth step from 0 at 0 to 1 at 1, with four derivatives zero at both ends."""


@dataclass(frozen=True, slots=True)
class Smoothed:
    """A smoothed periodic quantity with constant intervals (stays); derivatives up to the sixth.

    Attributes
    ----------
    series : Series       The quantity outside its stays.
    stays : (n, 3) float  Start, end and value of each stay, in order; an end may exceed the period. [s], [s], any unit
    steady : (m, 2) float Start and end of intervals in which all derivatives from the second up are zero. [s]
    blend : float         Time before and after a stay in which the quantity blends into the series. [s]
    resolution : float    Deviation within which the quantity counts as constant. Any unit
    """

    series: Series
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
    """One smoothed cycle: period [s], position [m], force on the load [N] if recorded, and warnings."""

    period: float
    motion: Smoothed
    force: Smoothed | None
    warnings: tuple[str, ...]


def smoothed(
    file: str, columns: Mapping[str, np.ndarray], lines: Sequence[int], cutoff: float, resolution: float | None = None
) -> Cycle:
    """Smooth one cycle of a motion from recorded columns.

    Parameters
    ----------
    file : str           Name of the recording in messages.
    columns : mapping    Increasing times, either position or speed, and force if recorded, by name, in SI.
    lines : sequence     Line of the file for each row.
    cutoff : float       Frequency above which everything is removed. [Hz]
    resolution : float   Deviation within which the load counts as at rest; estimated from the recording by default. [m]

    Returns
    -------
    Cycle

    Raises
    ------
    InputError
        If the recording has too few rows, or does not end where it begins.
    ParameterError
        If the recording is shorter than one period of the cutoff.
    """
    time = columns["time"] - columns["time"][0]
    if len(time) < _LEAST_ROWS:
        raise InputError(f"{file}: must have at least {_LEAST_ROWS} rows of numbers, got {len(time)}")
    period, step = float(time[-1]), float(np.median(np.diff(time)))
    if cutoff * period < 1.0:
        raise ParameterError(
            f"cutoff must be >= {plain(1.0 / period, 3)} Hz, one period in the recording, got {cutoff:g}"
        )
    warnings = [
        f"{file}: line {lines[place + 1]}: {plain(time[place + 1] - time[place], 3)} s without data, "
        f"{plain(width, 3)} times the median step; interpolated linearly"
        for place, width in enumerate(np.diff(time) / step)
        if width > _GAP
    ]
    if 2.0 * step * cutoff > 1.0:
        warnings.append(
            f"{file}: a step of {plain(step, 3)} s resolves frequencies up to {plain(0.5 / step, 3)} Hz only; "
            f"the cutoff is {plain(cutoff, 3)} Hz"
        )
    count = max(2 * len(time), int(_PER_WAVE * cutoff * period))
    even = np.arange(count) * (period / count)

    def made(name: str) -> Smoothed:
        values = columns[name]
        raw = np.interp(even, time, values)
        closed = raw if name == "force" else np.interp(even, time, _closed(file, name, values, time / period, warnings))
        series = Series.through(period, closed, cutoff)
        resolves = _Resolution.of(values, _noise(values, closed, series), 1.0 / (cutoff * step))
        own = resolves.reach
        if name == "position" and resolution is not None:
            resolves = _Resolution(resolution, 2.0 * resolution)
        # Include the neighbouring cycles, as a stay may extend past the end: once as recorded, in case all drift occurs in
        # the moves, and once made periodic, which removes the drift of a sensor.
        drift = float(values[-1] - values[0]) if name == "position" else 0.0
        courses = [np.concatenate([raw - drift, raw, raw + drift])]
        if closed is not raw:
            courses.append(np.tile(closed, 3))
        if name == "speed":
            return _of_speed(series, courses, cutoff, resolves)
        return _of_value(series, courses, closed, cutoff, resolves, own)

    motion = made("position" if "position" in columns else "speed")
    if resolution is None:
        warnings += _slow(file, motion, even, cutoff)
    return Cycle(period, motion, made("force") if "force" in columns else None, tuple(warnings))


class _Resolution(NamedTuple):
    """Apparent changes of a constant quantity in a recording. Any unit"""

    reach: float
    """Largest apparent deviation, to either side."""
    drift: float
    """Largest apparent drift of its mean over a wave."""

    @classmethod
    def of(cls, values: np.ndarray, noise: float, rows: float) -> _Resolution:
        """Estimate from recorded values, their noise and the number of rows per wave.

        Source: expected maximum of a normal sample plus one standard deviation; error of a least-squares slope.
        """
        rounding = _ROUNDING * float(np.max(np.abs(values)))
        count = _count(values)
        reach = (1.0 + math.sqrt(2.0 * math.log(2.0 * max(rows, 1.0)))) * noise
        drift = _DEVIATIONS * math.sqrt(12.0 / max(rows, 1.0)) * noise
        return cls(max(reach, 0.5 * count, rounding), max(drift, 1.5 * count, rounding))


def _of_value(
    series: Series, courses: list[np.ndarray], closed: np.ndarray, cutoff: float, resolves: _Resolution, own: float
) -> Smoothed:
    """Smooth a position or a force from its series, its courses over three cycles, and one cycle made periodic.

    `own` is the resolution of the recording itself, regardless of the one requested.
    """
    count = closed.size
    step = series.period / count
    width = _width(cutoff * step, count)

    found = []
    for thrice in courses:
        speed = _mean_slope(thrice, width, step)
        still = _widened(_within(thrice, width, resolves.reach) & (np.abs(speed) <= resolves.drift * cutoff), width)
        steady = _long(_widened(_within(speed, width, resolves.drift * cutoff), width), _STEADY * width)
        # Each mean speed covers half a wave to both sides.
        found.append((_middle(still), _middle(_widened(steady, width))))
    still, steady = np.logical_or.reduce(found)
    return _recording(series, closed, still, steady, cutoff, resolves.reach, own)


def _of_speed(series: Series, courses: list[np.ndarray], cutoff: float, resolves: _Resolution) -> Smoothed:
    """Integrate a recorded speed to a smoothed position, from the speed's series and its courses over three cycles."""
    count = courses[0].size // 3
    step = series.period / count
    width = _width(cutoff * step, count)

    found = []
    for thrice in courses:
        constant = _widened(_within(thrice, width, resolves.reach), width)
        still = constant & (np.abs(thrice) <= 2.0 * resolves.reach)
        found.append((_middle(still), _middle(_long(constant & ~still, _STEADY * width))))
    position = series.integral()
    values = position.derivatives(np.arange(count) * step, 0)[0]
    within = resolves.reach / cutoff
    still, steady = np.logical_or.reduce(found)
    return _recording(position, values, still, steady, cutoff, within, within)


def _slow(file: str, motion: Smoothed, even: np.ndarray, cutoff: float) -> list[str]:
    """Warn if the load moves very slowly for a while without resting, as filtered noise does."""
    position, speed = motion.derivatives(even, 1)
    step = float(even[1])
    slow = (np.abs(speed) <= _SLOW * np.max(np.abs(speed))) & (speed != 0.0)
    found = _intervals(_long(slow, _SLOW_WAVES / (cutoff * step)))
    lasts = sum(last - first for first, last in found) * step
    if lasts <= _SLOW_SHARE * motion.series.period:
        return []
    spreads = [np.ptp(np.take(position, range(first, last + 1), mode="wrap")) for first, last in found]
    return [
        f"{file}: for {plain(lasts, 3)} of {plain(motion.series.period, 3)} s the load moves at less than "
        f"{percent(_SLOW)} of its largest speed; if it is at rest there, set "
        f'resolution = "{plain(1e3 * float(max(spreads)), 2)} mm"'
    ]


def _middle(thrice: np.ndarray) -> np.ndarray:
    """Return the second of three cycles."""
    return np.split(thrice, 3)[1]


def _recording(
    series: Series,
    values: np.ndarray,
    still: np.ndarray,
    steady: np.ndarray,
    cutoff: float,
    resolved: float,
    own: float,
) -> Smoothed:
    step, wave = series.period / values.size, 1.0 / cutoff
    stays = []
    for first, last in _intervals(still):
        inside = np.take(values, range(first, last + 1), mode="wrap")
        if resolved > own and last - first < values.size:
            begin, end = _settled(inside, own)
            first, last, inside = first + begin, first + end, inside[begin : end + 1]
        stays.append(_Stay(first * step, last * step, float(np.median(inside))))
    moving = [(first * step, last * step) for first, last in _intervals(_long(steady & ~still, wave / step))]
    return Smoothed(
        series=series,
        stays=np.reshape(np.array(_apart(stays, series.period, wave, resolved), dtype=float), (-1, 3)),
        steady=np.reshape(np.array(moving, dtype=float), (-1, 2)),
        blend=0.5 * wave,
        resolution=resolved,
    )


class _Stay(NamedTuple):
    """Start and end of a stay [s], and its value."""

    begin: float
    end: float
    value: float


def _settled(inside: np.ndarray, own: float) -> tuple[int, int]:
    """Return the first and last sample of a stay, without the approach and departure that a coarse resolution includes.

    The stay starts and ends where the quantity crosses the straight line through its middle half, or is as close to that
    line as in the middle half.
    """
    places = np.arange(inside.size)
    middle = slice(inside.size // 4, inside.size - inside.size // 4)
    slope, level = (
        np.polyfit(places[middle], inside[middle], 1) if inside[middle].size > 1 else (0.0, inside[middle][0])
    )
    off = inside - (level + slope * places)
    near = max(own, float(np.max(np.abs(off[middle]))))

    def first(ends: np.ndarray) -> int:
        return int(np.argmax((np.abs(ends) <= near) | (np.sign(ends) != np.sign(ends[0]))))

    return first(off), inside.size - 1 - first(off[::-1])


def _apart(stays: list[_Stay], period: float, wave: float, within: float) -> list[_Stay]:
    """Separate stays by at least a wave: join two stays if the short move between them returns, else shorten both."""
    joined: list[_Stay] = []
    for stay in stays:
        last = joined[-1] if joined else None
        if last and stay.begin - last.end < wave and abs(stay.value - last.value) <= 2.0 * within:
            lengths = last.end - last.begin, stay.end - stay.begin
            value = (last.value * lengths[0] + stay.value * lengths[1]) / (sum(lengths) or 1.0)
            joined[-1] = _Stay(last.begin, stay.end, value)
        else:
            joined.append(stay)
    count = len(joined)
    room = [
        max(0.0, wave - (joined[(i + 1) % count].begin - stay.end) % period) if count > 1 or stay.end < period else 0.0
        for i, stay in enumerate(joined)
    ]
    kept = [
        stay._replace(begin=stay.begin + 0.5 * room[i - 1], end=stay.end - 0.5 * room[i])
        for i, stay in enumerate(joined)
    ]
    return [stay for stay in kept if stay.end > stay.begin]


def _count(values: np.ndarray) -> float:
    """Return the count of which all row-to-row differences are multiples, as from an encoder or rounding; 0 if none."""
    steps = np.abs(np.diff(values))
    steps = steps[steps > _ROUNDING * np.ptp(values)]
    if not steps.size:
        return 0.0
    counts = steps / steps.min()
    return float(steps.min()) if np.all(np.abs(counts - np.round(counts)) < _UNEVEN) else 0.0


def _noise(values: np.ndarray, resampled: np.ndarray, series: Series) -> float:
    """Estimate the standard deviation of a recording's noise.

    Return the smaller of two estimates: the part that smoothing removes and the irregularity from row to row. Each alone
    may contain motion: smoothing also removes fast motion, and sparse rows make motion look irregular. The medians ignore
    the corners of a motion.

    Source: huber1981 (median absolute deviation).
    """
    smoothed = series.derivatives(np.arange(resampled.size) * (series.period / resampled.size), 0)[0]
    taken_off = float(np.median(np.abs(resampled - smoothed)))
    irregular = float(np.median(np.abs(np.diff(values, _IRREGULAR)))) / math.sqrt(math.comb(2 * _IRREGULAR, _IRREGULAR))
    return 1.4826 * min(taken_off, irregular)


def _width(waves: float, count: int) -> int:
    """Return the number of samples per wave, made odd, from the length of a sample in waves."""
    return min(round(1.0 / waves) | 1, count - 1 + count % 2)


def _mean_slope(values: np.ndarray, width: int, step: float) -> np.ndarray:
    """Return the least-squares slope over a wave centred at each sample."""
    from scipy.ndimage import correlate1d

    half = max(width // 2, 1)
    apart = np.arange(-half, half + 1)
    return correlate1d(values, apart / (step * np.sum(apart**2)), mode="nearest")


def _within(values: np.ndarray, width: int, reach: float) -> np.ndarray:
    """Mark samples about which the quantity stays within `reach` to either side of some value for a wave."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    spread = maximum_filter1d(values, width, mode="wrap") - minimum_filter1d(values, width, mode="wrap")
    return spread <= 2.0 * reach * (1.0 + _ROUNDING)


def _widened(mask: np.ndarray, width: int) -> np.ndarray:
    """Extend a mask from the centres of waves to all their samples."""
    from scipy.ndimage import maximum_filter1d

    return maximum_filter1d(mask.astype(np.int8), min(width, mask.size), mode="wrap").astype(bool)


def _long(mask: np.ndarray, samples: float) -> np.ndarray:
    """Keep the intervals of a periodic mask that have at least a given number of samples."""
    kept = np.zeros_like(mask)
    for first, last in _intervals(mask):
        if last - first >= samples:
            kept[np.arange(first, last + 1) % mask.size] = True
    return kept


def _intervals(mask: np.ndarray) -> list[tuple[int, int]]:
    """Return the first and last index of each interval of a periodic mask, in order; the last may exceed the end."""
    if mask.all():
        return [(0, mask.size)]
    starts, ends = np.flatnonzero(mask & ~np.roll(mask, 1)), np.flatnonzero(mask & ~np.roll(mask, -1))
    if ends.size and ends[0] < starts[0]:
        ends = np.append(ends[1:], ends[0] + mask.size)
    return list(zip(starts.tolist(), ends.tolist(), strict=True))


def _closed(file: str, name: str, values: np.ndarray, share: np.ndarray, warnings: list[str]) -> np.ndarray:
    """Make recorded values periodic: remove the drift of a position, or the mean of a speed.

    Raises
    ------
    InputError
        If the drift or the mean is too large.
    """
    span = float(np.ptp(values)) or 1.0
    if name == "speed":
        drift = float(np.trapezoid(values, share))
        finding = f"the mean speed is {plain(drift, 3)} m/s"
    else:
        drift = float(values[-1] - values[0])
        finding = f"the position ends {plain(drift, 3)} m from its start"
    if abs(drift) > _DRIFT * span:
        raise InputError(
            f"{file}: must be one cycle that ends where it starts, but {finding}, {percent(abs(drift) / span)} of the range"
        )
    if abs(drift) > 1e-3 * span:
        warnings.append(
            f"{file}: {finding}, {percent(abs(drift) / span, 1)} of the range; removed evenly over the cycle"
        )
    return values - (drift if name == "speed" else drift * share)
