"""Motions and forces from CSV files: `read` loads the data once into the object, which no longer needs the file."""

from __future__ import annotations

import bisect
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Literal

import numpy as np
from annotated_types import Ge, Gt

from infinivar._core.arrays import HoldsArrays, locked, real_array, shown
from infinivar._core.fields import check_real, component, quantity
from infinivar.errors import InputError, ParameterError
from infinivar.motion.fourier import Series
from infinivar.motion.motion import NOTHING, MotionState, PeriodicMotion
from infinivar.motion.smoothing import Smoothed, smoothed
from infinivar.motion.strides import Strides
from infinivar.motion.tables import read_columns

CUTOFF = 10.0
"""Default cutoff of a recording. [Hz]"""

_START = "Time in the run at which the file's time is 0"
_NOT_READ = Smoothed(NOTHING, np.zeros((0, 3)), np.zeros((0, 2)), 0.0, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Recording(HoldsArrays, PeriodicMotion):
    """A recorded motion, smoothed, with the force on the load if recorded: one cycle, made periodic, or a run.

    Create it from a CSV file with `Recording.read`. Recordings of the same data are equal, regardless of their file names.

    Attributes
    ----------
    time : (n,) float              Increasing; the cycle or run lasts from the first to the last. [s]
    position, speed : (n,) float   Exactly one of the two. [m], [m s^-1]
    force : (n,) float             External force on the load, positive along the motion; None if not recorded. [N]
    lines : (n,) int               Line of the file for each row, used in messages; defaults to counting from 1.
    averaged : Strides             The strides of which the cycle is the mean; None if it is not an average.

    Raises
    ------
    ParameterError
        If a field is outside its range, or the recording is shorter than one period of the cutoff.
    InputError
        If the data have too few rows, or do not end where they begin.
    """

    shape: ClassVar[str] = "file"
    file: str = component(
        "CSV file with columns time, position or speed, and optionally force; units in the header", compare=False
    )
    cutoff: float = quantity("Hz", Gt(0), "Cutoff frequency; smoothing removes everything above it", default=CUTOFF)
    resolution: float | None = quantity(
        "m",
        Gt(0),
        "Resolution: the load counts as at rest while it stays within this distance to either side for one period of the "
        "cutoff; defaults to an estimate from the recording's steps and noise",
        default=None,
    )
    closed: bool = component(
        "Whether the recording is one cycle that ends where it starts; if false, it is a run, with its energy and "
        "temperatures from the start to the end",
        default=True,
    )
    strides: Literal["one", "average"] = component(
        "Whether the recording is one cycle, or several strides to average to one", default="one"
    )
    stride_time: float | None = quantity(
        "s",
        Gt(0),
        "Approximate time of a stride, where no column marks heel strikes or phase; defaults to the period of the motion",
        default=None,
    )
    time: np.ndarray = field(repr=False)
    position: np.ndarray | None = field(repr=False, default=None)
    speed: np.ndarray | None = field(repr=False, default=None)
    force: np.ndarray | None = field(repr=False, default=None)
    lines: tuple[int, ...] = field(repr=False, compare=False, default=())
    averaged: Strides | None = field(repr=False, compare=False, default=None)
    _period: float = field(init=False, repr=False, compare=False, default=0.0)
    _motion: Smoothed = field(init=False, repr=False, compare=False, default=_NOT_READ)
    _push: Smoothed | Series = field(init=False, repr=False, compare=False, default=NOTHING)
    _warnings: tuple[str, ...] = field(init=False, repr=False, compare=False, default=())

    @classmethod
    def read(
        cls, file: str, *, cutoff: float = CUTOFF, resolution: float | None = None, closed: bool = True
    ) -> Recording:
        """Read a CSV file with the columns time, position or speed, and optionally force.

        Raises
        ------
        InputError
            If the file is invalid; the message names the line.
        """
        wanted = (("time", "s"), ("position", "m"), ("speed", "m/s"), ("force", "N"))
        columns, lines = read_columns(file, wanted, ("time",))
        data: dict[str, Any] = {name: np.array(values) for name, values in columns.items()}
        if ("position" in columns) == ("speed" in columns):
            raise InputError(
                f"{file}: line 1 must name the columns time and position, or time and speed, but not position and speed"
            )
        return cls(
            file=file,
            cutoff=cutoff,
            resolution=resolution,
            closed=closed,
            lines=tuple(lines),
            **data,
        )

    def __post_init__(self) -> None:
        """Validate, copy, lock and smooth the data."""
        check_real(self)
        if (self.position is None) == (self.speed is None):
            raise ParameterError("position or speed must be given, but not both")
        if self.strides == "average" and not self.closed:
            raise ParameterError(
                "closed must be true with strides = 'average', which gives one cycle; remove one of them"
            )
        if self.strides == "one" and self.stride_time is not None:
            raise ParameterError(
                "stride_time does not apply with strides = 'one'; remove it, or set strides = 'average'"
            )
        columns = _columns_of(
            self, "time", *(name for name in ("position", "speed", "force") if getattr(self, name) is not None)
        )
        lines = self.lines or tuple(range(1, len(columns["time"]) + 1))
        found = smoothed(self.file, columns, lines, self.cutoff, self.resolution, closed=self.closed)
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
        """Time of the cycle or run. [s]"""
        return self._period

    @property
    def repeats(self) -> bool:
        """Whether the motion repeats; if not, it is a run."""
        return self.closed

    @property
    def fastest(self) -> float:
        """Highest frequency in the motion. [Hz]"""
        return self.cutoff

    @property
    def resolved(self) -> float:
        """Largest apparent displacement of a load at rest, to either side. [m]"""
        return self._motion.resolution

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of gaps, drift, possibly unrecognised rest and unusual strides."""
        unusual = {} if self.averaged is None else self.averaged.outliers
        return (
            *self._warnings,
            *(
                f"{self.file}: stride {number} is unusual: {reason}; it is averaged too"
                for number, reason in unusual.items()
            ),
        )

    @property
    def smoothed(self) -> Smoothed:
        """The smoothed position, with its intervals of rest."""
        return self._motion

    @property
    def as_run(self) -> Recording | None:
        """The run of all averaged strides; None if the cycle is not an average."""
        if self.averaged is None:
            return None
        data: dict[str, Any] = dict(self.averaged.record)
        return Recording(file=self.file, cutoff=self.cutoff, resolution=self.resolution, closed=False, **data)

    def derivatives(self, time: Any, orders: int) -> list[np.ndarray]:
        """Return position [m] and its time derivatives up to an order, at times in 0 to `period` [s]."""
        return self._motion.derivatives(time, orders)

    def push(self, time: Any, orders: int) -> list[np.ndarray]:
        """Return the recorded force on the load [N] and its derivatives up to an order."""
        return self._push.derivatives(time, orders)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Waypoints(HoldsArrays):
    """A motion through given positions: a cubic spline that starts and ends at rest, constant before and after.

    Create it from a CSV file with `Waypoints.read`.

    Attributes
    ----------
    time, position : (n,) float   Times increase. [s], [m]

    Raises
    ------
    ParameterError
        If a field is outside its range.
    """

    shape: ClassVar[str] = "file"
    file: str = component(
        "CSV file with columns time and position; units in its header, defaulting to SI", compare=False
    )
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
            If the file is invalid; the message names the line.
        """
        return cls(file=file, start=start, **_read(file, "position", "m"))

    def __post_init__(self) -> None:
        """Validate, copy and lock the data, and fit the spline."""
        check_real(self)
        columns = _columns_of(self, "time", "position")
        spline = _Spline.through(columns["time"].tolist(), columns["position"].tolist())
        for name, value in {**columns, "_spline": spline}.items():
            object.__setattr__(self, name, value)

    @property
    def breaks(self) -> Sequence[float]:
        """Times at which speed or acceleration may jump: none, as the spline is smooth and ends at rest. [s]"""
        return ()

    def at(self, time: float) -> MotionState:
        """Position [m], speed [m s^-1] and acceleration [m s^-2] at a time [s]."""
        return self._spline.at(time - self.start)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RecordedForce(HoldsArrays):
    """A force through given values: linear in between, constant before the first and after the last.

    Create it from a CSV file with `RecordedForce.read`.

    Attributes
    ----------
    time, force : (n,) float   Times increase; force positive along the motion. [s], [N]

    Raises
    ------
    ParameterError
        If a field is outside its range.
    """

    shape: ClassVar[str] = "file"
    file: str = component("CSV file with columns time and force; units in its header, defaulting to SI", compare=False)
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
            If the file is invalid; the message names the line.
        """
        return cls(file=file, start=start, **_read(file, "force", "N"))

    def __post_init__(self) -> None:
        """Validate, copy and lock the data."""
        check_real(self)
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
    """Read times and values from a CSV file; a heading without a unit means SI."""
    columns, _ = read_columns(file, (("time", "s"), (wanted, unit)), ("time", wanted), units_needed=False)
    return {name: np.array(columns[name]) for name in ("time", wanted)}


def _columns_of(instance: Any, *names: str) -> Mapping[str, np.ndarray]:
    """Return locked copies of the given columns.

    Raises
    ------
    ParameterError
        If values are not finite numbers, lengths differ, or times do not increase.
    """
    columns = {name: locked(real_array(name, getattr(instance, name))) for name in names}
    time = columns["time"]
    if time.ndim != 1 or len(time) < 2:
        raise ParameterError(f"time must be at least two numbers in a row, got {shown(instance.time)}")
    for name, values in columns.items():
        if values.shape != time.shape:
            raise ParameterError(f"{name} must have as many numbers as time, {len(time)}, got shape {values.shape}")
        if not np.all(np.isfinite(values)):
            raise ParameterError(f"{name} must be finite, got {values[~np.isfinite(values)][0]}")
    if not np.all(np.diff(time) > 0.0):
        row = int(np.flatnonzero(np.diff(time) <= 0.0)[0])
        raise ParameterError(f"time must increase from row to row, got {time[row]:g}, then {time[row + 1]:g}")
    return columns


def _place(times: list[float], time: float) -> tuple[int, float, float]:
    """Return the row at or before a time, the fraction of the step to the next row (0 or 1 outside), and the step."""
    low = min(max(bisect.bisect_right(times, time) - 1, 0), len(times) - 2)
    width = times[low + 1] - times[low]
    return low, min(max((time - times[low]) / width, 0.0), 1.0), width


@dataclass(frozen=True, slots=True)
class _Spline:
    """Cubic spline that starts and ends at rest; the position is constant before and after."""

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
