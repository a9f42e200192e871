r"""Strides of a long recording: found, resampled to percent of cycle, and averaged.

Three ways to find them:

- **heel strikes**: a column that marks them, or their times;
- **phase**: a column that rises over each stride and drops to its start;
- **period**: the motion itself. Its autocorrelation gives the period. Each stride then starts where the motion around it
  best agrees with the mean of all strides, within a quarter of the period, so that strides may vary in time.

Each stride is resampled at equal shares of its own time, by cubics through the four nearest rows; their mean and standard
deviation follow for each share. For rows a step ``h`` apart, interpolation is off by at most ``3/128 h^4`` times the largest
fourth derivative: 4e-7 of the amplitude of a 1 Hz sinusoid at 100 Hz. These cubics have kinks at the rows, which coarse rows turn
into accelerations: strides of fewer than fifty rows are resampled to as many points by a cubic spline.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from infinivar._core.described import derived, reported
from infinivar._core.frozen import FrozenDict
from infinivar._core.result import Result, result
from infinivar.errors import InputError, ParameterError
from infinivar.motion.files.table import RecordedTable
from infinivar.motion.files.timing import unwrapped
from infinivar.units import percent, plain

POINTS = 201
"""Fewest points of a resampled stride, from 0 to 100 % of the cycle."""

_COARSE = 50
"""Rows in a stride below which they are coarse."""

_LEAST = 2
"""Fewest strides for an average."""

_MATCH = 0.5
"""Smallest autocorrelation at which a motion counts as periodic."""
_CLEAR = 0.7
"""The same where no stride time is given: moves to and fro at random agree with themselves by 0.6."""
_NEARLY = 0.9
"""Share of the largest autocorrelation from which the shortest period is chosen: two strides repeat as well as one."""
_ROOM = 0.25
"""Largest deviation of a stride's time from the period, as a share of it."""
_ROUNDS = 3
"""How often strides are matched with the mean of those found before."""
_MOST_LAGS = 20_000

_UNUSUAL = 3.5
"""Modified z-score above which a stride is an outlier."""
_LEAST_SPREAD = 0.005
"""Spread below which differences do not count as unusual: share of the stride time, or of the range of the motion."""


@result
class Strides(Result):
    """Strides of a recording over the share of the cycle.

    Attributes
    ----------
    method : str                    How they were found, in words.
    edges : (k + 1,) float          Starts of the strides, and the end of the last, in the recording's time. [s]
    share : (n,) float              Share of the cycle, from 0 to 1. [-]
    curves : mapping                Position, speed and force of each stride, as recorded, by field. (k, n) [SI]
    outliers : mapping              Reasons for which strides are unusual, by their number from 1. They are part of the average.
    record : mapping                The recording from the start of the first stride to the end of the last: time [s], and
                                    position, speed and force as recorded, by field. (m,)
    separate : bool                 Whether strides end with values of their own rather than with the start of the next.
    """

    method: str = reported()
    edges: np.ndarray
    share: np.ndarray
    curves: Mapping[str, np.ndarray]
    outliers: Mapping[int, str] = reported()
    record: Mapping[str, np.ndarray]
    separate: bool = False

    def __len__(self) -> int:
        """Number of strides."""
        return len(self.edges) - 1

    @property
    def times(self) -> np.ndarray:
        """Time of each stride. [s]"""
        return np.diff(self.edges)

    @derived("s", key="stride_time_s")
    def period(self) -> float:
        """Mean stride time. [s]"""
        return float(np.mean(self.times))

    @derived("s", key="stride_time_deviation_s")
    def scatter(self) -> float:
        """Standard deviation of the stride time. [s]"""
        return float(np.std(self.times, ddof=1)) if len(self) > 1 else 0.0

    @property
    def mean(self) -> dict[str, np.ndarray]:
        """Mean of each quantity at each share of the cycle, by field."""
        return {name: np.mean(curves, axis=0) for name, curves in self.curves.items()}

    @property
    def spread(self) -> dict[str, np.ndarray]:
        """Standard deviation of each quantity over the strides at each share of the cycle, by field."""
        freedom = min(1, len(self) - 1)
        return {name: np.std(curves, axis=0, ddof=freedom) for name, curves in self.curves.items()}

    @derived()
    def _strides(self) -> int:
        return len(self)

    @derived("s")
    def _starts(self) -> np.ndarray:
        return self.edges[:-1]

    @derived()
    def _largest_deviation(self) -> dict[str, float]:
        return {name: float(np.max(spread)) for name, spread in self.spread.items()}

    @property
    def mean_cycle(self) -> dict[str, np.ndarray]:
        """The mean as columns of a cycle over the mean stride time: time [s] and each quantity, by field."""
        return {"time": self.share * self.period, **self.mean}

    @property
    def verdict(self) -> str:
        """What was found, in one sentence."""
        unusual = f"; {len(self.outliers)} unusual" if self.outliers else ""
        times = f"{plain(self.period, 4)} s ± {plain(self.scatter, 2)} s"
        return f"{len(self)} strides by {self.method}: stride time {times}{unusual}"


def strides_of(table: RecordedTable, stride_time: float | None = None) -> Strides:
    """Find the strides of a recording that is read: by heel strikes, a phase that wraps, or the period of the motion.

    Parameters
    ----------
    table : RecordedTable   With times.
    stride_time : float     Approximate time of a stride; the period of the motion by default. [s]

    Raises
    ------
    InputError
        If there are not at least two whole strides.
    """
    marks, phase = (table.columns.get(role) for role in ("heel_strike", "phase"))
    wraps = phase is not None and bool(np.any(np.diff(phase.values) < -0.5))
    return find_strides(
        table.file,
        table.values,
        heel_strikes=None if marks is None else marks.values,
        phase=phase.values if phase is not None and wraps else None,
        period=stride_time,
        ends=table.end_values,
    )


def find_strides(
    name: str,
    columns: Mapping[str, np.ndarray],
    *,
    heel_strikes: Any = None,
    phase: Any = None,
    period: float | None = None,
    points: int | None = None,
    ends: Mapping[str, np.ndarray] | None = None,
) -> Strides:
    """Find the strides of a recording.

    Parameters
    ----------
    name : str                   Name of the recording in messages.
    columns : mapping            Increasing "time" [s], and any of position, speed and force. (n,)
    heel_strikes : (n,) or (m,)  A mark for each row, other than 0 from each heel strike on, or the times of the strikes. [s]
    phase : (n,) float           Share of the cycle for each row, which drops at the end of a stride. [-]
    period : float               Expected stride time, if there are neither heel strikes nor a phase; estimated by default. [s]
    points : int                 Points of a resampled stride; by default as many as rows in a stride, but 201 from 50 to 200.
    ends : mapping               "time" of edges at which a stride ends with values of its own, and these values. (m,)

    Returns
    -------
    Strides

    Raises
    ------
    InputError
        If there are not at least two whole strides.
    ParameterError
        If `period` is not positive.
    """
    time = np.asarray(columns["time"], dtype=float)
    if heel_strikes is not None:
        edges, method = _by_heel_strikes(time, np.asarray(heel_strikes, dtype=float)), "heel strikes"
    elif phase is not None:
        edges, method = _by_phase(time, np.asarray(phase, dtype=float)), "phase"
    else:
        edges, method = _by_period(name, time, columns, period)
    if len(edges) < _LEAST + 1:
        found = max(len(edges) - 1, 0)
        raise InputError(
            f"{name}: must have at least {_LEAST} whole strides to average, found {found} by {method} in "
            f"{plain(float(time[-1] - time[0]), 3)} s"
        )
    edges = np.asarray(edges, dtype=float)
    rows = round((len(time) - 1) * float(np.median(np.diff(edges))) / float(time[-1] - time[0]))
    coarse = rows < _COARSE
    count = points or (rows + 1 if coarse else max(POINTS, rows + 1))
    share = np.linspace(0.0, 1.0, count)
    parts = _parts(time, edges, ends or {})
    curves = {}
    for field in ("position", "speed", "force"):
        if field in columns:
            values = np.asarray(columns[field], dtype=float)
            curves[field] = np.concatenate(
                [resampled(*_with_end(time, values, part, field), part.edges, share, coarse=coarse) for part in parts]
            )
    return Strides(
        method=method,
        edges=edges,
        share=share,
        curves=FrozenDict(curves),
        outliers=FrozenDict(_outliers(np.diff(edges), curves)),
        record=FrozenDict(_between(time, columns, curves, edges)),
        separate=len(parts) > 1,
    )


class _Part(NamedTuple):
    """Strides that follow one another: rows, edges, and the time and values with which the last one ends, if it states them."""

    rows: slice
    edges: np.ndarray
    end: Mapping[str, float]


def _parts(time: np.ndarray, edges: np.ndarray, ends: Mapping[str, np.ndarray]) -> list[_Part]:
    """Divide strides where one ends with values of its own."""
    found, first, start = [], 0, 0
    near = 1e-3 * float(np.median(np.diff(edges)))
    for place in range(1, len(edges)):
        own = np.flatnonzero(np.abs(ends["time"] - edges[place]) < near) if ends else np.zeros(0, int)
        if own.size or place == len(edges) - 1:
            last = int(np.searchsorted(time, edges[place] - near)) if own.size else len(time)
            end = {field: float(values[own[0]]) for field, values in ends.items()} if own.size else {}
            found.append(_Part(slice(first, last), edges[start : place + 1], end))
            first, start = last, place
    return found


def _with_end(time: np.ndarray, values: np.ndarray, part: _Part, field: str) -> tuple[np.ndarray, np.ndarray]:
    """Times and values of the rows of a part, with those of its end."""
    time, values = time[part.rows], values[part.rows]
    return (np.append(time, part.end["time"]), np.append(values, part.end[field])) if part.end else (time, values)


def resampled(
    time: np.ndarray, values: np.ndarray, edges: np.ndarray, share: np.ndarray, *, coarse: bool = False
) -> np.ndarray:
    """Values at shares of each interval between edges, by a cubic through the four nearest rows, or a spline. (k, n)"""
    at = np.clip(edges[:-1, None] + np.diff(edges)[:, None] * share, time[0], time[-1])
    if coarse:
        from scipy.interpolate import CubicSpline

        return CubicSpline(time, values)(at)
    most = min(4, len(time))
    first = np.clip(np.searchsorted(time, at, side="right") - 2, 0, len(time) - most)
    rows = [first + row for row in range(most)]
    found = np.zeros(at.shape)
    for row in rows:
        weight = np.ones(at.shape)
        for other in rows:
            if other is not row:
                weight *= (at - time[other]) / (time[row] - time[other])
        found += weight * values[row]
    return found


def _between(
    time: np.ndarray, columns: Mapping[str, np.ndarray], curves: Mapping[str, np.ndarray], edges: np.ndarray
) -> dict[str, np.ndarray]:
    """Rows from the first edge to the last, with interpolated rows at both."""
    least = 1e-3 * float(
        np.median(np.diff(time))
    )  # rows that all but coincide with an edge would make a step of nearly 0
    inside = (time > edges[0] + least) & (time < edges[-1] - least)
    found = {"time": np.concatenate([edges[:1], time[inside], edges[-1:]])}
    for field, rows in curves.items():
        found[field] = np.concatenate([rows[:1, 0], np.asarray(columns[field], dtype=float)[inside], rows[-1:, -1]])
    return found


def _by_heel_strikes(time: np.ndarray, strikes: np.ndarray) -> np.ndarray:
    """Times of heel strikes from their marks or from their times."""
    if strikes.shape != time.shape:
        return strikes[(strikes >= time[0]) & (strikes <= time[-1])]
    marked = strikes != 0.0
    rises = marked & ~np.concatenate([[False], marked[:-1]])
    # A recording that begins in contact has no strike in its first row, unless marks last one row.
    rises[0] &= not np.any(marked[1:] & marked[:-1])
    return time[rises]


def _by_phase(time: np.ndarray, phase: np.ndarray) -> np.ndarray:
    """Times at which a phase passes the end of a cycle, interpolated."""
    rising = np.maximum.accumulate(unwrapped(phase))
    turns = np.arange(math.ceil(rising[0] - 1e-9), math.floor(rising[-1] + 1e-9) + 1)
    keep = np.concatenate([[True], np.diff(rising) > 0.0])
    return np.interp(turns, rising[keep], time[keep])


def _by_period(
    name: str, time: np.ndarray, columns: Mapping[str, np.ndarray], period: float | None
) -> tuple[np.ndarray, str]:
    """Strides that follow one another from the first row, and how they were found."""
    if period is not None and not period > 0.0:
        raise ParameterError(f"period must be > 0 s, got {period:g}")
    duration = float(time[-1] - time[0])
    values = np.asarray(columns["position" if "position" in columns else "speed"], dtype=float)
    count = min(max(len(time), 16), _MOST_LAGS)
    step = duration / (count - 1)
    even = np.interp(time[0] + np.arange(count) * step, time, values)
    even = even - np.polyval(np.polyfit(np.arange(count), even, 1), np.arange(count))
    lag, agreement = _main_lag(even, None if period is None else period / step)
    if not agreement >= (_CLEAR if period is None else _MATCH):
        best = (
            f"agrees with itself by {percent(agreement)} at best, after {plain(lag * step, 3)} s"
            if agreement > 0.0
            else "does not repeat"
        )
        raise InputError(
            f"{name}: no repeated stride found: the motion {best}; name a column of heel strikes, or set the stride time"
        )
    starts = _matched(even, lag)
    requested = "a given period" if period is not None else "period"
    said = f"{requested} ({plain(lag * step, 3)} s, autocorrelation {plain(agreement, 2)})"
    return time[0] + starts * step, said


def _main_lag(values: np.ndarray, requested: float | None) -> tuple[float, float]:
    """Lag of the first peak of the autocorrelation that is nearly the highest, and its height.

    The autocorrelation of each lag is relative to the two parts of the record that it compares. With a lag `requested` for, the
    highest peak within a quarter of it counts.
    """
    count = len(values)
    size = 1 << (2 * count - 1).bit_length()
    spectrum = np.fft.rfft(values, size)
    raw = np.fft.irfft(np.abs(spectrum) ** 2, size)[:count]
    energy = np.concatenate([[0.0], np.cumsum(values**2)])
    lags = np.arange(count)
    both = np.sqrt(energy[count - lags] * np.maximum(energy[-1] - energy[lags], 0.0))
    found = raw / np.where(both > 0.0, both, np.inf)
    last = count // 2 + 1
    # Before the autocorrelation first falls, its peaks are noise.
    inner = np.arange(int(np.argmax(found < _MATCH)) if np.any(found < _MATCH) else last, last - 1)
    inner = inner[inner > 0]
    peaks = inner[(found[inner] >= found[inner - 1]) & (found[inner] > found[inner + 1]) & (found[inner] > 0.0)]
    if requested is not None:
        peaks = peaks[np.abs(peaks - requested) <= _ROOM * requested]
        if not peaks.size:
            place = min(max(round(requested), 1), count - 1)
            return float(requested), float(found[place])
        best = int(peaks[np.argmax(found[peaks])])
    elif peaks.size:
        best = int(peaks[found[peaks] >= _NEARLY * np.max(found[peaks])][0])
    else:
        return float(last), 0.0
    return best + _vertex(*found[best - 1 : best + 2]), float(found[best])


def _vertex(before: float, at: float, after: float) -> float:
    """Place of the vertex of a parabola through three points in a row, relative to the middle one."""
    bend = before - 2.0 * at + after
    return 0.5 * (before - after) / bend if bend < 0.0 else 0.0


def _matched(values: np.ndarray, lag: float) -> np.ndarray:
    """Starts of strides in samples: the middles of the stretches that best agree with the mean of all."""
    width, reach = round(lag), max(1, round(_ROOM * lag))
    starts = np.arange(0.0, len(values) - width + 1e-9, lag)
    for _ in range(_ROUNDS):
        rows = np.arange(len(values))
        template = np.mean([np.interp(start + np.arange(width), rows, values) for start in starts], axis=0)
        template = template - np.mean(template)
        found = [starts[0]]
        while True:
            centre = round(found[-1] + lag)
            low, high = max(centre - reach, 0), min(centre + reach, len(values) - width)
            if high - low < 2:
                break
            scores = _agreement(values[low : high + width], template)
            best = int(np.argmax(scores))
            if not 0 < best < len(scores) - 1:
                break
            found.append(low + best + _vertex(*scores[best - 1 : best + 2]))
        if len(found) < _LEAST + 1:
            break
        starts = np.array(found)
    # Where strides differ in time, a stretch agrees best with the mean at its middle.
    return starts + 0.5 * width


def _agreement(values: np.ndarray, template: np.ndarray) -> np.ndarray:
    """Correlation coefficient of a template with each stretch of the values of its length."""
    stretches = np.lib.stride_tricks.sliding_window_view(values, len(template))
    off = stretches - np.mean(stretches, axis=-1, keepdims=True)
    return (off @ template) / (np.linalg.norm(off, axis=-1) * np.linalg.norm(template) + 1e-300)


def _outliers(times: np.ndarray, curves: Mapping[str, np.ndarray]) -> dict[int, str]:
    """Strides whose time or course is unusual, by the modified z-score of median and median absolute deviation.

    Source: iglewicz1993.
    """
    reasons: dict[int, list[str]] = {}
    for place, score in enumerate(_scores(times, _LEAST_SPREAD * float(np.median(times)))):
        if abs(score) > _UNUSUAL:
            word = "longer" if score > 0 else "shorter"
            reasons.setdefault(place + 1, []).append(f"{plain(times[place], 3)} s, {word} than usual")
    for name, rows in curves.items():
        away = np.sqrt(np.mean((rows - np.median(rows, axis=0)) ** 2, axis=-1))
        scale = float(np.ptp(np.median(rows, axis=0)))
        for place, score in enumerate(_scores(away, _LEAST_SPREAD * scale)):
            if score > _UNUSUAL:
                share = f", {percent(away[place] / scale)} of its range" if scale else ""
                reasons.setdefault(place + 1, []).append(f"{name} off the median{share} RMS")
    return {number: "; ".join(found) for number, found in sorted(reasons.items())}


def _scores(values: Sequence[float] | np.ndarray, least: float) -> np.ndarray:
    values = np.asarray(values, dtype=float)
    off = values - np.median(values)
    return 0.6745 * off / max(float(np.median(np.abs(off))), 0.6745 * least, 1e-300)
