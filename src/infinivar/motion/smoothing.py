r"""Recorded motions: read, made periodic, smoothed, and at rest where the recording resolves no motion.

A smoothed recording is never exactly at rest: what a filter spreads over a stay, or rounding leaves of it, has a speed
with a sign, and Coulomb friction acts in full on the slightest speed. So rest is told from the recording itself, by one
rule for positions, speeds and forces:

    a quantity stays where it is while, for at least one wave of the cutoff, it stays within its resolution.

The resolution is the larger of half a count of the recording and what its noise reaches within a wave. In these stays the
quantity is constant, and about their ends it goes over to the smoothed one within half a wave. By the same rule, asked of
the mean speed over one wave, a motion is steady: its acceleration is zero there, so that noise does not steer a wheel.
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
"""Standard errors by which the mean course over a wave may be off."""

_ROUNDING = 1e-7
"""Of the size of a quantity: no recording resolves less, which seven digits or single precision leave open."""

_LEAST_ROWS = 8
_PER_WAVE = 40
"""Instants of the shortest wave at which a recording is resampled, at least."""
_GAP = 5.0
"""Factor over the usual step from which on a step counts as a gap."""
_DRIFT = 0.05
"""Largest share of its range by which a recorded motion may miss its beginning at the end."""

_SLOW = 0.01
"""Of the largest speed: a load that is slower for a while may be meant to rest."""

_A_WHILE = 3.0
"""Waves of the cutoff."""

_OFTEN = 0.05
"""Of the period."""

_STEADY = 4.0
"""Waves for which a motion must be steady: about its largest speed any motion seems so for a while."""

_UNEVEN = 0.1
"""Of a count, by which differences may miss a multiple of it."""

_IRREGULAR = 6
"""Order of the differences from row to row that show noise and no motion."""

_BINOMIALS = ((1,), (1, 1), (1, 2, 1), (1, 3, 3, 1), (1, 4, 6, 4, 1))

_STEP = np.polynomial.Polynomial([0, 0, 0, 0, 0, 126, -420, 540, -315, 70])
"""From 0 at 0 to 1 at 1 with four derivatives zero at both ends."""


@dataclass(frozen=True, slots=True)
class Smoothed:
    """A smoothed periodic quantity that stays constant in some stretches of time; derivatives up to the fourth.

    Attributes
    ----------
    series : Series       What it is outside its stays.
    stays : (n, 3) float  Begin, end and value of each, in order; an end may be later than the period. [s], [s], any unit
    steady : (m, 2) float Begin and end of stretches in which all derivatives from the second on are zero. [s]
    blend : float         Time before and after a stay in which the quantity goes over to the series. [s]
    resolution : float    Within which it counts as unmoved. Any unit
    """

    series: Series
    stays: np.ndarray
    steady: np.ndarray
    blend: float
    resolution: float

    def derivatives(self, time: Any, orders: int) -> list[np.ndarray]:
        """The quantity and its derivatives by time up to an order, at times [s]."""
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
    """A quantity with its derivatives that is a value at the end of a stay, and itself from `width` [s] away on."""
    share = np.clip(away / width, 0.0, 1.0)
    steps = [(sign / width) ** order * (_STEP.deriv(order) if order else _STEP)(share) for order in range(len(found))]
    off = [found[0] - value, *found[1:]]
    made = [
        sum(factor * steps[part] * off[order - part] for part, factor in enumerate(_BINOMIALS[order]))
        for order in range(len(found))
    ]
    return [np.where(away < width, part + (0.0 if order else value), found[order]) for order, part in enumerate(made)]


class Cycle(NamedTuple):
    """What a recording comes to: the period [s], the position [m], the force on the load [N] if it has one, and what to know."""

    period: float
    motion: Smoothed
    force: Smoothed | None
    warnings: tuple[str, ...]


def smoothed(
    file: str, columns: Mapping[str, np.ndarray], lines: Sequence[int], cutoff: float, resolution: float | None = None
) -> Cycle:
    """One cycle of a motion from recorded columns.

    Parameters
    ----------
    file : str           Name of the recording in messages.
    columns : mapping    Times that increase, either position or speed, and force if it was recorded, by name, in SI.
    lines : sequence     Line of the file that each row stands in.
    cutoff : float       Nothing above this frequency is kept. [Hz]
    resolution : float   Within which the load counts as unmoved; as the recording shows if left out. [m]

    Returns
    -------
    Cycle

    Raises
    ------
    InputError
        If it is too short, or does not end where it begins.
    ParameterError
        If not even one wave of the cutoff fits into the recording.
    """
    time = columns["time"] - columns["time"][0]
    if len(time) < _LEAST_ROWS:
        raise InputError(f"{file}: must have at least {_LEAST_ROWS} lines of numbers, got {len(time)}")
    period, step = float(time[-1]), float(np.median(np.diff(time)))
    if cutoff * period < 1.0:
        raise ParameterError(
            f"cutoff must be >= {plain(1.0 / period, 3)} Hz, one wave in the recording, got {cutoff:g}"
        )
    warnings = [
        f"{file}: line {lines[place + 1]}: {plain(time[place + 1] - time[place], 3)} s without data, "
        f"{plain(width, 3)} times the usual step; bridged by a straight line"
        for place, width in enumerate(np.diff(time) / step)
        if width > _GAP
    ]
    if 2.0 * step * cutoff > 1.0:
        warnings.append(
            f"{file}: a step of {plain(step, 3)} s shows nothing above {plain(0.5 / step, 3)} Hz; cutoff is {plain(cutoff, 3)} Hz"
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
        # What it does before and after the cycle, too, as a stay may reach over the end: as recorded, where all of a drift may
        # lie in the moves, and as made periodic, which takes out a drift of the sensor.
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
    """What a recording leaves open about a quantity that does not change. Any unit"""

    reach: float
    """How far it may seem to be off, to either side."""
    drift: float
    """How far its mean course over a wave may seem to lead."""

    @classmethod
    def of(cls, values: np.ndarray, noise: float, rows: float) -> _Resolution:
        """From recorded values, their noise and the rows in a wave.

        Source: expected largest of a normal sample, and one standard deviation more; error of a least-squares slope.
        """
        rounding = _ROUNDING * float(np.max(np.abs(values)))
        count = _count(values)
        reach = (1.0 + math.sqrt(2.0 * math.log(2.0 * max(rows, 1.0)))) * noise
        drift = _DEVIATIONS * math.sqrt(12.0 / max(rows, 1.0)) * noise
        return cls(max(reach, 0.5 * count, rounding), max(drift, 1.5 * count, rounding))


def _of_value(
    series: Series, courses: list[np.ndarray], closed: np.ndarray, cutoff: float, resolves: _Resolution, own: float
) -> Smoothed:
    """The recording of a position or a force: its series, its courses over three cycles, and one cycle made periodic.

    `own` is the resolution of the recording itself, whatever is asked for.
    """
    count = closed.size
    step = series.period / count
    width = _width(cutoff * step, count)

    found = []
    for thrice in courses:
        speed = _mean_slope(thrice, width, step)
        still = _widened(_within(thrice, width, resolves.reach) & (np.abs(speed) <= resolves.drift * cutoff), width)
        steady = _long(_widened(_within(speed, width, resolves.drift * cutoff), width), _STEADY * width)
        # Each of the mean speeds reaches half a wave to both sides.
        found.append((_middle(still), _middle(_widened(steady, width))))
    still, steady = np.logical_or.reduce(found)
    return _recording(series, closed, still, steady, cutoff, resolves.reach, own)


def _of_speed(series: Series, courses: list[np.ndarray], cutoff: float, resolves: _Resolution) -> Smoothed:
    """The recording of the position that a speed leads to, from the speed's series and its courses over three cycles."""
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
    """A warning where the load hardly moves for a while and does not rest: noise that a filter has smoothed looks so."""
    position, speed = motion.derivatives(even, 1)
    step = float(even[1])
    slow = (np.abs(speed) <= _SLOW * np.max(np.abs(speed))) & (speed != 0.0)
    found = _stretches(_long(slow, _A_WHILE / (cutoff * step)))
    lasts = sum(last - first for first, last in found) * step
    if lasts <= _OFTEN * motion.series.period:
        return []
    spreads = [np.ptp(np.take(position, range(first, last + 1), mode="wrap")) for first, last in found]
    return [
        f"{file}: for {plain(lasts, 3)} of {plain(motion.series.period, 3)} s the load moves, but at less than "
        f"{percent(_SLOW)} of its largest speed; if it rests there, say so: "
        f'resolution = "{plain(1e3 * float(max(spreads)), 2)} mm"'
    ]


def _middle(thrice: np.ndarray) -> np.ndarray:
    """The second of three cycles."""
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
    for first, last in _stretches(still):
        inside = np.take(values, range(first, last + 1), mode="wrap")
        if resolved > own and last - first < values.size:
            begin, end = _settled(inside, own)
            first, last, inside = first + begin, first + end, inside[begin : end + 1]
        stays.append(_Stay(first * step, last * step, float(np.median(inside))))
    moving = [(first * step, last * step) for first, last in _stretches(_long(steady & ~still, wave / step))]
    return Smoothed(
        series=series,
        stays=np.reshape(np.array(_apart(stays, series.period, wave, resolved), dtype=float), (-1, 3)),
        steady=np.reshape(np.array(moving, dtype=float), (-1, 2)),
        blend=0.5 * wave,
        resolution=resolved,
    )


class _Stay(NamedTuple):
    """Begin and end [s], and where."""

    begin: float
    end: float
    value: float


def _settled(inside: np.ndarray, own: float) -> tuple[int, int]:
    """First and last sample of a stay without what leads into it and out of it within a resolution that is coarse.

    It begins and ends where the quantity is as near to the straight line through the middle half of the stay as it is there,
    or crosses that line.
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
    """Stays with a wave between them at least: shorter moves join two stays if they lead nowhere, else shorten both."""
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
    """The step of which all differences of neighbours are multiples, as behind an encoder or rounded; 0 if there is none."""
    steps = np.abs(np.diff(values))
    steps = steps[steps > _ROUNDING * np.ptp(values)]
    if not steps.size:
        return 0.0
    counts = steps / steps.min()
    return float(steps.min()) if np.all(np.abs(counts - np.round(counts)) < _UNEVEN) else 0.0


def _noise(values: np.ndarray, resampled: np.ndarray, series: Series) -> float:
    """Standard deviation of the noise of a recording: no more than what smoothing takes off, nor than what is irregular.

    Of both the median, which passes over the corners of a motion. What smoothing takes off is motion, too, and what is
    irregular from one row to the next can be a motion that hardly any rows show: noise is in both.

    Source: huber1981 (median absolute deviation).
    """
    smoothed = series.derivatives(np.arange(resampled.size) * (series.period / resampled.size), 0)[0]
    taken_off = float(np.median(np.abs(resampled - smoothed)))
    irregular = float(np.median(np.abs(np.diff(values, _IRREGULAR)))) / math.sqrt(math.comb(2 * _IRREGULAR, _IRREGULAR))
    return 1.4826 * min(taken_off, irregular)


def _width(waves: float, count: int) -> int:
    """Number of samples in a wave, made odd, from the length of a sample in waves."""
    return min(round(1.0 / waves) | 1, count - 1 + count % 2)


def _mean_slope(values: np.ndarray, width: int, step: float) -> np.ndarray:
    """Slope of the straight line through the samples of a wave about each, by least squares."""
    from scipy.ndimage import correlate1d

    half = max(width // 2, 1)
    apart = np.arange(-half, half + 1)
    return correlate1d(values, apart / (step * np.sum(apart**2)), mode="nearest")


def _within(values: np.ndarray, width: int, reach: float) -> np.ndarray:
    """Where a quantity stays within `reach` to either side of some value through a wave about each sample."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    spread = maximum_filter1d(values, width, mode="wrap") - minimum_filter1d(values, width, mode="wrap")
    return spread <= 2.0 * reach * (1.0 + _ROUNDING)


def _widened(mask: np.ndarray, width: int) -> np.ndarray:
    """A mask of waves' middles as one of all their samples."""
    from scipy.ndimage import maximum_filter1d

    return maximum_filter1d(mask.astype(np.int8), min(width, mask.size), mode="wrap").astype(bool)


def _long(mask: np.ndarray, samples: float) -> np.ndarray:
    """The stretches of a periodic mask that have at least a given number of samples."""
    kept = np.zeros_like(mask)
    for first, last in _stretches(mask):
        if last - first >= samples:
            kept[np.arange(first, last + 1) % mask.size] = True
    return kept


def _stretches(mask: np.ndarray) -> list[tuple[int, int]]:
    """First and last index of each stretch of a periodic mask, in order; the last index may pass the end."""
    if mask.all():
        return [(0, mask.size)]
    starts, ends = np.flatnonzero(mask & ~np.roll(mask, 1)), np.flatnonzero(mask & ~np.roll(mask, -1))
    if ends.size and ends[0] < starts[0]:
        ends = np.append(ends[1:], ends[0] + mask.size)
    return list(zip(starts.tolist(), ends.tolist(), strict=True))


def _closed(file: str, name: str, values: np.ndarray, share: np.ndarray, warnings: list[str]) -> np.ndarray:
    """Values of a recording made periodic: a motion ends where it begins, and a speed has no mean.

    Raises
    ------
    InputError
        If too much is missing for that.
    """
    span = float(np.ptp(values)) or 1.0
    if name == "speed":
        drift = float(np.trapezoid(values, share))
        said = f"a mean speed of {plain(drift, 3)} m/s"
    else:
        drift = float(values[-1] - values[0])
        said = f"position ends {plain(drift, 3)} m from where it begins"
    if abs(drift) > _DRIFT * span:
        raise InputError(
            f"{file}: must be one cycle that ends where it begins, but has {said}: {percent(abs(drift) / span)} of its range"
        )
    if abs(drift) > 1e-3 * span:
        warnings.append(
            f"{file}: {said}, {percent(abs(drift) / span, 1)} of its range; taken out evenly over the cycle"
        )
    return values - (drift if name == "speed" else drift * share)
