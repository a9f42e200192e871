"""Motions and forces from CSV files: read once, by `read`; the value holds the data, and the file is not needed again."""

from __future__ import annotations

import bisect
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from annotated_types import Ge, Gt

from infinivar._core.arrays import HoldsArrays, locked
from infinivar._core.fields import check, component, quantity
from infinivar.errors import InputError, ParameterError
from infinivar.motion.fourier import Series
from infinivar.motion.motion import NOTHING, MotionState, PeriodicMotion
from infinivar.motion.smoothing import Smoothed, smoothed
from infinivar.motion.tables import read_columns

CUTOFF = 10.0
"""Of a recording, if none is given. [Hz]"""

_START = "Time of the run at which the file's time is 0"
_NOT_READ = Smoothed(NOTHING, np.zeros((0, 3)), np.zeros((0, 2)), 0.0, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Recording(HoldsArrays, PeriodicMotion):
    """One cycle of a recorded motion, with the force on the load if it was recorded: made periodic and smoothed.

    `Recording.read` makes it from a CSV file. Two recordings of the same data are equal, whatever their files are called.

    Attributes
    ----------
    time : (n,) float              Increasing; the cycle is from the first to the last. [s]
    position, speed : (n,) float   One of the two. [m], [m s^-1]
    force : (n,) float             On the load from outside, positive along the motion; None for none. [N]
    lines : (n,) int               Line of the file that each row stands in, for messages; counted from 1 if left out.

    Raises
    ------
    ParameterError
        If a field is outside its range, or not even one wave of the cutoff fits into the recording.
    InputError
        If the data are too few, or do not end where they begin.
    """

    shape: ClassVar[str] = "file"
    file: str = component(
        "CSV file with the columns time and position or speed, and force, units in the header", compare=False
    )
    cutoff: float = quantity("Hz", Gt(0), "Nothing of a recording above this frequency is kept", default=CUTOFF)
    resolution: float | None = quantity(
        "m",
        Gt(0),
        "A recorded load is at rest while, for a wave of the cutoff, it moves no further than this to either side; "
        "as the recording's steps and noise show if left out",
        default=None,
    )
    time: np.ndarray = field(repr=False)
    position: np.ndarray | None = field(repr=False, default=None)
    speed: np.ndarray | None = field(repr=False, default=None)
    force: np.ndarray | None = field(repr=False, default=None)
    lines: tuple[int, ...] = field(repr=False, compare=False, default=())
    _period: float = field(init=False, repr=False, compare=False, default=0.0)
    _motion: Smoothed = field(init=False, repr=False, compare=False, default=_NOT_READ)
    _push: Smoothed | Series = field(init=False, repr=False, compare=False, default=NOTHING)
    _warnings: tuple[str, ...] = field(init=False, repr=False, compare=False, default=())

    @classmethod
    def read(cls, file: str, *, cutoff: float = CUTOFF, resolution: float | None = None) -> Recording:
        """Read a CSV file with the columns time and position or speed, and force if there is one.

        Raises
        ------
        InputError
            If the file cannot be used; the message names the line.
        """
        wanted = (("time", "s"), ("position", "m"), ("speed", "m/s"), ("force", "N"))
        columns, lines = read_columns(file, wanted, ("time",))
        if ("position" in columns) == ("speed" in columns):
            raise InputError(
                f"{file}: line 1 must name the columns time and position, or time and speed, not both nor neither"
            )
        return cls(
            file=file,
            cutoff=cutoff,
            resolution=resolution,
            lines=tuple(lines),
            **{name: np.array(values) for name, values in columns.items()},
        )

    def __post_init__(self) -> None:
        """Refuse what cannot be used, copy and lock the data, and smooth them."""
        check(self)
        if (self.position is None) == (self.speed is None):
            raise ParameterError("position or speed must be given, and not both")
        columns = _columns_of(self, "time", "position", "speed", "force")
        lines = self.lines or tuple(range(1, len(columns["time"]) + 1))
        found = smoothed(self.file, columns, lines, self.cutoff, self.resolution)
        made = {
            "_period": found.period,
            "_motion": found.motion,
            "_push": found.force or NOTHING,
            "_warnings": found.warnings,
        }
        for name, value in {**columns, **made}.items():
            object.__setattr__(self, name, value)

    @property
    def period(self) -> float:
        """Time of one cycle. [s]"""
        return self._period

    @property
    def fastest(self) -> float:
        """Frequency of the shortest wave. [Hz]"""
        return self.cutoff

    @property
    def resolved(self) -> float:
        """How far a load at rest may seem to move to either side. [m]"""
        return self._motion.resolution

    @property
    def warnings(self) -> tuple[str, ...]:
        """Gaps, drift, and rest that may not be recognised."""
        return self._warnings

    @property
    def smoothed(self) -> Smoothed:
        """The position, smoothed, with its stays."""
        return self._motion

    def derivatives(self, time: Any, orders: int) -> list[np.ndarray]:
        """Position [m] and its derivatives by time up to an order, at times from 0 to `period` [s]."""
        return self._motion.derivatives(time, orders)

    def push(self, time: Any, orders: int) -> list[np.ndarray]:
        """Recorded force on the load [N] with its derivatives up to an order."""
        return self._push.derivatives(time, orders)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Waypoints(HoldsArrays):
    """A motion through given positions, by a cubic spline that starts and ends at rest; before and after, it stays.

    `Waypoints.read` makes it from a CSV file.

    Attributes
    ----------
    time, position : (n,) float   Times increase. [s], [m]

    Raises
    ------
    ParameterError
        If a field is outside its range.
    """

    shape: ClassVar[str] = "file"
    file: str = component("CSV file with the columns time and position, units in its header, SI without", compare=False)
    start: float = quantity("s", Ge(0), _START, default=0.0)
    time: np.ndarray = field(repr=False)
    position: np.ndarray = field(repr=False)
    _spline: _Spline = field(init=False, repr=False, compare=False)

    @classmethod
    def read(cls, file: str, *, start: float = 0.0) -> Waypoints:
        """Read a CSV file with the columns time and position; a heading without a unit means SI.

        Raises
        ------
        InputError
            If the file cannot be used; the message names the line.
        """
        return cls(file=file, start=start, **_read(file, "position", "m"))

    def __post_init__(self) -> None:
        """Refuse what cannot be used, copy and lock the data, and lay the spline through them."""
        check(self)
        columns = _columns_of(self, "time", "position")
        spline = _Spline.through(columns["time"].tolist(), columns["position"].tolist())
        for name, value in {**columns, "_spline": spline}.items():
            object.__setattr__(self, name, value)

    @property
    def breaks(self) -> Sequence[float]:
        """Times at which speed or acceleration may jump: none, the spline is smooth and rests at its ends. [s]"""
        return ()

    def at(self, time: float) -> MotionState:
        """Position [m], speed [m s^-1] and acceleration [m s^-2] at a time [s]."""
        return self._spline.at(time - self.start)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RecordedForce(HoldsArrays):
    """A force through given values, straight between them; before and after, it keeps the first and the last.

    `RecordedForce.read` makes it from a CSV file.

    Attributes
    ----------
    time, force : (n,) float   Times increase; force positive along the motion. [s], [N]

    Raises
    ------
    ParameterError
        If a field is outside its range.
    """

    shape: ClassVar[str] = "file"
    file: str = component("CSV file with the columns time and force, units in its header, SI without", compare=False)
    start: float = quantity("s", Ge(0), _START, default=0.0)
    time: np.ndarray = field(repr=False)
    force: np.ndarray = field(repr=False)
    _rows: tuple[list[float], list[float]] = field(init=False, repr=False, compare=False)

    @classmethod
    def read(cls, file: str, *, start: float = 0.0) -> RecordedForce:
        """Read a CSV file with the columns time and force; a heading without a unit means SI.

        Raises
        ------
        InputError
            If the file cannot be used; the message names the line.
        """
        return cls(file=file, start=start, **_read(file, "force", "N"))

    def __post_init__(self) -> None:
        """Refuse what cannot be used, and copy and lock the data."""
        check(self)
        columns = _columns_of(self, "time", "force")
        rows = columns["time"].tolist(), columns["force"].tolist()
        for name, value in {**columns, "_rows": rows}.items():
            object.__setattr__(self, name, value)

    @property
    def breaks(self) -> Sequence[float]:
        """Times at which the force or its slope jumps. [s]"""
        return tuple(time + self.start for time in self._rows[0])

    def value(self, time: float) -> float:
        """Force at a time. [N]"""
        times, forces = self._rows
        low, share, _ = _place(times, time - self.start)
        return forces[low] + share * (forces[low + 1] - forces[low])

    def rate(self, time: float) -> float:
        """Slope of the force over time. [N s^-1]"""
        times, forces = self._rows
        low, share, width = _place(times, time - self.start)
        return (forces[low + 1] - forces[low]) / width if 0.0 < share < 1.0 else 0.0


def _read(file: str, wanted: str, unit: str) -> dict[str, np.ndarray]:
    """Times and values of a CSV file; a heading without a unit means SI."""
    columns, _ = read_columns(file, (("time", "s"), (wanted, unit)), ("time", wanted), units_needed=False)
    return {name: np.array(columns[name]) for name in ("time", wanted)}


def _columns_of(instance: Any, *names: str) -> Mapping[str, np.ndarray]:
    """Locked copies of the columns that are given.

    Raises
    ------
    ParameterError
        If they are not finite, not of one length, or times do not increase.
    """
    columns = {name: locked(getattr(instance, name)) for name in names if getattr(instance, name) is not None}
    time = columns["time"]
    for name, values in columns.items():
        if values.ndim != 1 or values.shape != time.shape or len(values) < 2 or not np.all(np.isfinite(values)):
            raise ParameterError(f"{name} must be at least two finite numbers, as many as time, got {values!r}")
    if not np.all(np.diff(time) > 0.0):
        raise ParameterError(f"time must increase from row to row, got {time!r}")
    return columns


def _place(times: list[float], time: float) -> tuple[int, float, float]:
    """Row at or before a time, the share of the way to the next row (0 and 1 outside), and the distance of the two."""
    low = min(max(bisect.bisect_right(times, time) - 1, 0), len(times) - 2)
    width = times[low + 1] - times[low]
    return low, min(max((time - times[low]) / width, 0.0), 1.0), width


@dataclass(frozen=True, slots=True)
class _Spline:
    """Cubic spline that starts and ends at rest: before and after, the position stays."""

    times: list[float]
    coefficients: list[list[float]]

    @classmethod
    def through(cls, times: list[float], positions: list[float]) -> _Spline:
        from scipy.interpolate import CubicSpline

        spline = CubicSpline(times, positions, bc_type="clamped")
        return cls(times, spline.c.T.tolist())

    def at(self, time: float) -> MotionState:
        low, share, width = _place(self.times, time)
        cubic, square, linear, constant = self.coefficients[low]
        s = share * width
        position = constant + s * (linear + s * (square + s * cubic))
        if not self.times[0] <= time <= self.times[-1]:
            return MotionState(position, 0.0, 0.0)
        return MotionState(position, linear + s * (2.0 * square + 3.0 * s * cubic), 2.0 * square + 6.0 * s * cubic)
