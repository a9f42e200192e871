"""Rest in recorded quantities: resolution, noise, and the intervals in which a quantity is constant or steady."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

_DEVIATIONS = 3.0
"""Tolerance on the mean slope over a wave, in standard errors."""

_ROUNDING = 1e-7
"""Finest resolution assumed, relative to the size of a quantity: that of seven digits or single precision."""

_UNEVEN = 0.1
"""Largest deviation of a difference from a multiple of a count, in counts."""

_IRREGULAR = 6
"""Order of the row-to-row differences that show noise but not motion."""

_FILTERS = 4
"""Waves to either side of a sample on which the filters of a value or a slope depend, and some more."""
_STEADY = 4.0
"""Shortest steady interval, in waves; around its largest speed any motion looks steady for a while."""


class Resolution(NamedTuple):
    """Apparent changes of a constant quantity in a recording. Any unit"""

    reach: float
    """Largest apparent deviation, to either side."""
    drift: float
    """Largest apparent drift of its mean over a wave."""

    @classmethod
    def of(cls, values: np.ndarray, noise: float, rows: float) -> Resolution:
        """Estimate from recorded values, their noise and the number of rows per wave.

        Source: expected maximum of a normal sample plus one standard deviation; error of a least-squares slope.
        """
        rounding = _ROUNDING * float(np.max(np.abs(values)))
        count = count_of(values)
        reach = (1.0 + math.sqrt(2.0 * math.log(2.0 * max(rows, 1.0)))) * noise
        drift = _DEVIATIONS * math.sqrt(12.0 / max(rows, 1.0)) * noise
        return cls(max(reach, 0.5 * count, rounding), max(drift, 1.5 * count, rounding))


class Stay(NamedTuple):
    """Start and end of a stay [s], and its value."""

    begin: float
    end: float
    value: float


def settled(inside: np.ndarray, own: float) -> tuple[int, int]:
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


def apart(stays: list[Stay], period: float, wave: float, within: float) -> list[Stay]:
    """Separate stays by at least a wave: join two stays if the short move between them returns, else shorten both."""
    joined: list[Stay] = []
    for stay in stays:
        last = joined[-1] if joined else None
        if last and stay.begin - last.end < wave and abs(stay.value - last.value) <= 2.0 * within:
            lengths = last.end - last.begin, stay.end - stay.begin
            value = (last.value * lengths[0] + stay.value * lengths[1]) / (sum(lengths) or 1.0)
            joined[-1] = Stay(last.begin, stay.end, value)
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


def count_of(values: np.ndarray) -> float:
    """Return the count of which all row-to-row differences are multiples, as from an encoder or rounding; 0 if none."""
    steps = np.abs(np.diff(values))
    steps = steps[steps > _ROUNDING * np.ptp(values)]
    if not steps.size:
        return 0.0
    counts = steps / steps.min()
    return float(steps.min()) if np.all(np.abs(counts - np.round(counts)) < _UNEVEN) else 0.0


def noise_of(values: np.ndarray, resampled: np.ndarray, smoothed: np.ndarray) -> float:
    """Estimate the standard deviation of a recording's noise.

    Return the smaller of two estimates: the part that smoothing removes and the irregularity from row to row. Each alone
    may contain motion: smoothing also removes fast motion, and sparse rows make motion look irregular. The medians ignore
    the corners of a motion.

    Source: huber1981 (median absolute deviation).
    """
    taken_off = float(np.median(np.abs(resampled - smoothed)))
    irregular = float(np.median(np.abs(np.diff(values, _IRREGULAR)))) / math.sqrt(math.comb(2 * _IRREGULAR, _IRREGULAR))
    return 1.4826 * min(taken_off, irregular)


def width_of(waves: float, count: int) -> int:
    """Return the number of samples per wave, made odd, from the length of a sample in waves."""
    return min(round(1.0 / waves) | 1, count - 1 + count % 2)


def mean_slope(values: np.ndarray, width: int, step: float) -> np.ndarray:
    """Return the least-squares slope over a wave centred at each sample."""
    from scipy.ndimage import correlate1d

    half = max(width // 2, 1)
    apart = np.arange(-half, half + 1)
    return correlate1d(values, apart / (step * np.sum(apart**2)), mode="nearest")


def within(values: np.ndarray, width: int, reach: float) -> np.ndarray:
    """Mark samples about which the quantity stays within `reach` to either side of some value for a wave."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    spread = maximum_filter1d(values, width, mode="wrap") - minimum_filter1d(values, width, mode="wrap")
    return spread <= 2.0 * reach * (1.0 + _ROUNDING)


def widened(mask: np.ndarray, width: int) -> np.ndarray:
    """Extend a mask from the centres of waves to all their samples."""
    from scipy.ndimage import maximum_filter1d

    return maximum_filter1d(mask.astype(np.int8), min(width, mask.size), mode="wrap").astype(bool)


def long_enough(mask: np.ndarray, samples: float) -> np.ndarray:
    """Keep the intervals of a periodic mask that have at least a given number of samples."""
    kept = np.zeros_like(mask)
    for first, last in intervals(mask):
        if last - first >= samples:
            kept[np.arange(first, last + 1) % mask.size] = True
    return kept


def intervals(mask: np.ndarray) -> list[tuple[int, int]]:
    """Return the first and last index of each interval of a periodic mask, in order; the last may exceed the end."""
    if mask.all():
        return [(0, mask.size)]
    starts, ends = np.flatnonzero(mask & ~np.roll(mask, 1)), np.flatnonzero(mask & ~np.roll(mask, -1))
    if ends.size and ends[0] < starts[0]:
        ends = np.append(ends[1:], ends[0] + mask.size)
    return list(zip(starts.tolist(), ends.tolist(), strict=True))


class Masks(NamedTuple):
    """Samples of a cycle or a run at which a quantity is constant, and at which it changes steadily."""

    still: np.ndarray
    steady: np.ndarray


def rest_of_value(courses: list[np.ndarray], step: float, cutoff: float, resolves: Resolution) -> Masks:
    """Find where a position or a force is constant or changes steadily, in the middle third of its courses."""
    width = width_of(cutoff * step, courses[0].size // 3)
    found = []
    for thrice in courses:
        course, middle = _around_middle(thrice, width)
        speed = mean_slope(course, width, step)
        still = widened(within(course, width, resolves.reach) & (np.abs(speed) <= resolves.drift * cutoff), width)
        steady = long_enough(widened(within(speed, width, resolves.drift * cutoff), width), _STEADY * width)
        # Each mean speed covers half a wave to both sides.
        found.append((still[middle], widened(steady, width)[middle]))
    return Masks(*np.logical_or.reduce(found))


def rest_of_speed(courses: list[np.ndarray], step: float, cutoff: float, resolves: Resolution) -> Masks:
    """Find where a position is constant or changes steadily from its recorded speed, in the middle third of its courses."""
    width = width_of(cutoff * step, courses[0].size // 3)
    found = []
    for thrice in courses:
        course, middle = _around_middle(thrice, width)
        constant = widened(within(course, width, resolves.reach), width)
        still = constant & (np.abs(course) <= 2.0 * resolves.reach)
        found.append((still[middle], long_enough(constant & ~still, _STEADY * width)[middle]))
    return Masks(*np.logical_or.reduce(found))


def _around_middle(thrice: np.ndarray, width: int) -> tuple[np.ndarray, slice]:
    """Return the second of three cycles with as much of the others as affects it, and its place therein."""
    once = thrice.size // 3
    more = min(once, math.ceil((_STEADY + _FILTERS) * width))
    return thrice[once - more : 2 * once + more], slice(more, more + once)
