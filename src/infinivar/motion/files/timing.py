"""Times of a recording: from a phase or from equal steps of a cycle, within a window, at another sample rate."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from infinivar.errors import InputError, ParameterError, printable, require
from infinivar.motion.files.reading import read_table
from infinivar.motion.files.table import Column, RecordedTable
from infinivar.tables.sheet import shown
from infinivar.units import percent, plain

RESAMPLING = ("linear", "cubic", "mean")
"""Methods of resampling: straight lines between the rows, a cubic spline through them, or the mean of the straight lines over
each new step, which keeps out what the new rate cannot resolve."""

_MOST_ROWS = 2_000_000
_DROP = 0.5
"""A phase that drops by more than this share of a cycle starts the next stride."""

_LEFT_OUT = 0.02
"""Share of the cycle that a phase may leave out in any case."""
_MOST_STEPS = 2.5
"""Usual steps of a phase that it may leave out at its end."""

_WHOLE = 1e-6
"""A phase that covers the cycle to this share covers all of it."""


def read_timed(
    file: str | Path,
    *,
    columns: Mapping[str, str] | None = None,
    flip: Sequence[str] | None = None,
    body_mass: float | None = None,
    cycle_time: float | None = None,
    window: Sequence[float] | None = None,
    sample_rate: float | None = None,
    resampling: str | None = None,
    **options: Any,
) -> RecordedTable:
    """Read a recording with its times: `read_table`, then `timed`, `windowed` and `resampled`."""
    table = read_table(file, columns=columns, flip=flip or (), body_mass=body_mass, **options)
    return resampled(windowed(timed(table, cycle_time=cycle_time), window), sample_rate, resampling)


def timed(table: RecordedTable, *, cycle_time: float | None = None) -> RecordedTable:
    """Return the table with a column of time.

    A phase is multiplied by the cycle time, and each stride follows the one before. If a single one ends before 100 % of the
    cycle, a last row repeats the first one, a whole cycle later. A table with neither time nor phase holds equal steps from 0
    to 100 % of the cycle, both included.

    Parameters
    ----------
    table : RecordedTable
    cycle_time : float   Time of one cycle; None where the file states times. [s]

    Raises
    ------
    InputError
        If the file has no time and no cycle time is given, has both, or the phase does not increase.
    """
    where = f"{table.file}: {table.top}"
    _check_percent(table)
    if "time" in table.columns:
        if cycle_time is not None:
            heading = shown(table.columns["time"].heading)
            raise InputError(f"{where}, column {heading}: states times, so cycle_time does not apply; remove it")
        return table
    if cycle_time is None:
        phase = table.columns.get("phase")
        found = ", ".join(shown(column.heading) for column in table.columns.values())
        said = (
            f", column {shown(phase.heading)}: is a share of the cycle; state the time of a cycle"
            if phase is not None
            else f": must name a column of time, found {found}; if the rows are equal steps over one cycle, state its time"
        )
        raise InputError(f'{where}{said}: cycle_time = "1.1 s"')
    require(cycle_time > 0.0, "cycle_time", cycle_time, "> 0", "s")
    if "phase" not in table.columns:
        time = np.linspace(0.0, cycle_time, len(table))
        remark = f"equal steps from 0 to 100 % of a cycle of {plain(cycle_time)} s"
        return _with_time(table, time, "equal steps", remark)
    return _by_phase(table, cycle_time)


def _by_phase(table: RecordedTable, cycle_time: float) -> RecordedTable:
    """Return a table with the times of its phase, one stride after the other."""
    phase = table.columns["phase"]
    steps = np.diff(phase.values)
    wrong = np.flatnonzero((steps <= 0.0) & (steps >= -_DROP))
    if wrong.size:
        row = int(wrong[0])
        raise InputError(
            f"{table.file}: {table.place} {table.lines[row + 1]}, column {shown(phase.heading)}: must have a later phase than "
            f"the row above, or start the next stride, got {percent(phase.values[row + 1], 1)} after "
            f"{percent(phase.values[row], 1)}"
        )
    whole = unwrapped(phase.values)
    remark = f"phase times a cycle of {plain(cycle_time)} s"
    if np.any(steps < 0.0):
        # A stride that ends at 100 % and the next one, which starts at 0 %, state the same instant.
        kept = np.append(np.diff(whole) > 0.0, True)
        ends = {role: column.values[~kept] for role, column in table.columns.items()}
        ends["time"] = whole[~kept] * cycle_time
        table = dataclasses.replace(_rows(table, kept), ends={} if np.all(kept) else ends)
        remark += f", {1 + np.count_nonzero(steps < 0.0)} strides"
    _check_covered(table, whole)
    missing = 1.0 - float(whole[-1] - whole[0])
    if missing > _WHOLE:
        table = _closed(table)
        remark += f"; closed with the first row over the last {percent(missing, 1)}"
    return _with_time(table, unwrapped(table.columns["phase"].values) * cycle_time, phase.heading, remark)


def _check_percent(table: RecordedTable) -> None:
    """Refuse a phase in percent that never exceeds 1 %: it is a share from 0 to 1."""
    phase = table.columns.get("phase")
    if phase is not None and phase.unit != "1" and len(table) > 2 and 0.0 < np.max(phase.values) <= 0.01 + 1e-9:
        raise InputError(
            f"{table.file}: {table.top}, column {shown(phase.heading)}: is in %, but reaches only "
            f"{plain(100.0 * float(np.max(phase.values)))} %; if it counts the cycle from 0 to 1, state its unit: "
            f'columns = {{ phase = "{printable(phase.heading)} [1]", ... }}'
        )


def _check_covered(table: RecordedTable, whole: np.ndarray) -> None:
    """Refuse a phase that leaves out a part of the cycle between a stride and the next, or before the first row again."""
    phase = table.columns["phase"]
    steps = np.diff(whole)
    usual = float(np.median(steps[steps > 0.0]))
    most = max(_LEFT_OUT, _MOST_STEPS * usual)
    ends = np.append(np.flatnonzero(np.diff(phase.values) < -_DROP), len(whole) - 1)
    left = np.append(steps[ends[:-1]], 1.0 - (whole[-1] - whole[0]))
    wrong = np.flatnonzero(left > most + _WHOLE)
    if wrong.size:
        row, share = int(ends[wrong[0]]), float(left[wrong[0]])
        raise InputError(
            f"{table.file}: {table.place} {table.lines[row]}, column {shown(phase.heading)}: must cover the cycle, but ends at "
            f"{percent(phase.values[row], 1)} and leaves out {percent(share, 1)} of it, where the rows are "
            f"{percent(usual, 1)} apart; if the recording is no whole cycle, it needs a column of time and closed = false"
        )


def unwrapped(phase: np.ndarray) -> np.ndarray:
    """Return a phase that goes on rising where it drops to start the next stride. [cycles]"""
    return phase + np.concatenate([[0.0], np.cumsum(np.diff(phase) < -_DROP)])


def _rows(table: RecordedTable, kept: Any) -> RecordedTable:
    """Return some rows of a table."""
    columns = {role: dataclasses.replace(one, values=one.values[kept]) for role, one in table.columns.items()}
    return dataclasses.replace(table, columns=columns, lines=table.lines[kept])


def _with_time(table: RecordedTable, time: np.ndarray, heading: str, remark: str) -> RecordedTable:
    column = Column(role="time", heading=heading, unit="s", values=time)
    return dataclasses.replace(table, columns={"time": column, **table.columns}, remarks=(*table.remarks, remark))


def _closed(table: RecordedTable) -> RecordedTable:
    """Return the table with its first row again, a whole cycle later."""
    columns = {
        role: dataclasses.replace(
            column, values=np.append(column.values, column.values[0] + (1.0 if role == "phase" else 0.0))
        )
        for role, column in table.columns.items()
    }
    return dataclasses.replace(table, columns=columns, lines=np.append(table.lines, table.lines[0]))


def windowed(table: RecordedTable, window: Sequence[float] | None) -> RecordedTable:
    """Return the rows of a table with times in a window, both ends included.

    Parameters
    ----------
    table : RecordedTable   With a column of time.
    window : (2,) float     Start and end in the time of the file; None for all rows. [s]

    Raises
    ------
    InputError
        If the window is not inside the recording, or holds fewer than two rows.
    ParameterError
        If it is not a start and a later end.
    """
    if window is None:
        return table
    if len(window) != 2 or not window[0] < window[1]:
        raise ParameterError(
            f"window must be a start and a later end, got {' and '.join(f'{plain(one)} s' for one in window) or 'nothing'}"
        )
    column = table.columns["time"]
    time = column.values
    slack = 1e-9 * max(abs(float(time[0])), abs(float(time[-1])), float(time[-1] - time[0]))
    for name, bound in zip(("start", "end"), window, strict=True):
        if not time[0] - slack <= bound <= time[-1] + slack:
            row = 0 if bound < time[0] else -1
            raise InputError(
                f"{table.file}: {table.place} {table.lines[row]}, column {shown(column.heading)}: the recording "
                f"{'starts' if row == 0 else 'ends'} at {time[row]:.9g} s, so the {name} of window, {bound:.9g} s, is "
                "outside"
            )
    inside = np.flatnonzero((time >= window[0] - slack) & (time <= window[1] + slack))
    if inside.size < 2:
        near = min(int(np.searchsorted(time, window[0])), len(time) - 1)
        raise InputError(
            f"{table.file}: {table.place} {table.lines[near]}, column {shown(column.heading)}: the window from "
            f"{plain(window[0])} s to {plain(window[1])} s holds {inside.size} row{'' if inside.size == 1 else 's'}, must be at "
            "least two"
        )
    remark = f"window from {plain(window[0])} s to {plain(window[1])} s: {inside.size} of {len(table)} rows"
    table = _rows(table, slice(int(inside[0]), int(inside[-1]) + 1))
    return dataclasses.replace(table, remarks=(*table.remarks, remark))


def resampled(table: RecordedTable, rate: float | None, method: str | None = None) -> RecordedTable:
    """Return the table at equal steps from its first to its last time.

    Parameters
    ----------
    table : RecordedTable   With a column of time.
    rate : float            Sample rate, rounded so that whole steps fill the recording; None for the rows as they are. [Hz]
    method : str            One of `RESAMPLING`; by default cubic where the new rate is higher than that of the rows, else linear.

    Returns
    -------
    RecordedTable   ``lines`` are those of the rows at or before the new ones.

    Notes
    -----
    For a motion x(t) with rows a time h apart, straight lines are off by at most h^2/8 max|x''|, and a cubic spline by a
    multiple of h^4. A mean over a new step H adds H^2/24 x'' to leading order. The second derivative of straight lines is zero
    but at the rows: at a higher rate they state accelerations that the rows do not.
    """
    if rate is None:
        if method not in (None, RESAMPLING[0]):
            raise ParameterError(
                f"resampling = {method!r} does not apply without sample_rate, which sets the new rate; state it, or remove "
                "resampling"
            )
        return table
    require(rate > 0.0, "sample_rate", rate, "> 0", "Hz")
    require(method in (None, *RESAMPLING), "resampling", repr(method), f"one of {', '.join(RESAMPLING)}")
    time = table.columns["time"].values
    span = float(time[-1] - time[0])
    steps = max(1, round(span * rate))
    if method is None:
        method = "cubic" if span / steps < (1.0 - _WHOLE) * float(np.median(np.diff(time))) else "linear"
    if steps > _MOST_ROWS:
        raise ParameterError(
            f"sample_rate must be <= {plain(_MOST_ROWS / span, 3)} Hz for {plain(span)} s, got {plain(rate)} Hz"
        )
    even = time[0] + np.arange(steps + 1) * (span / steps)
    even[-1] = time[-1]
    before = np.clip(np.searchsorted(time, even, side="right") - 1, 0, len(time) - 1)
    columns = {
        role: dataclasses.replace(column, values=_values_at(even, time, role, column.values, method))
        for role, column in table.columns.items()
    }
    how = {"linear": "linear interpolation", "cubic": "a cubic spline", "mean": "means of linear interpolation"}[method]
    remark = f"resampled from {len(table)} rows to {plain(steps / span)} Hz by {how}"
    return dataclasses.replace(table, columns=columns, lines=table.lines[before], remarks=(*table.remarks, remark))


def _values_at(even: np.ndarray, time: np.ndarray, role: str, values: np.ndarray, method: str) -> np.ndarray:
    if role == "time":
        return even
    if role == "heel_strike":
        marks = np.zeros(even.size)
        step = (even[-1] - even[0]) / max(even.size - 1, 1)
        marks[np.rint((time[values != 0.0] - even[0]) / step).astype(int)] = 1.0
        return marks
    if role == "phase":
        whole = np.interp(even, time, unwrapped(values))
        return whole % 1.0 if np.any(np.diff(values) < 0.0) else whole
    if method == "cubic":
        from scipy.interpolate import CubicSpline

        return CubicSpline(time, values)(even)
    if method == "mean":
        return _means(even, time, values)
    return np.interp(even, time, values)


def _means(even: np.ndarray, time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return means over one new step around each new time, of the straight lines between rows; the ends are kept."""
    half = 0.5 * (even[1] - even[0])
    area = np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(time))])

    def integral(at: np.ndarray) -> np.ndarray:
        low = np.clip(np.searchsorted(time, at, side="right") - 1, 0, len(time) - 2)
        since = at - time[low]
        slope = (values[low + 1] - values[low]) / (time[low + 1] - time[low])
        return area[low] + since * (values[low] + 0.5 * since * slope)

    means = (integral(even[1:-1] + half) - integral(even[1:-1] - half)) / (2.0 * half)
    return np.concatenate([values[:1], means, values[-1:]])
