"""Motions and forces from recordings: `read` loads the data once into the object, which no longer needs the file."""

from __future__ import annotations

import bisect
import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Literal, Self

import numpy as np
from annotated_types import Ge, Gt

from infinivar._core.arrays import HoldsArrays, locked, real_array, shown
from infinivar._core.bounds import FINITE
from infinivar._core.fields import check_real, chosen_words, component, named_texts, quantities, quantity
from infinivar.axis import LINEAR, ROTARY, Axis
from infinivar.errors import InputError, ParameterError, printable
from infinivar.motion.files.reading import headings_in
from infinivar.motion.files.table import ROLES, SIGNED, RecordedTable
from infinivar.motion.files.timing import read_timed
from infinivar.motion.fourier import Series
from infinivar.motion.motion import NOTHING, MotionState, PeriodicMotion
from infinivar.motion.smoothing import Smoothed, smoothed
from infinivar.motion.strides import Strides, strides_of

CUTOFF = 10.0
"""Default cutoff of a recording. [Hz]"""

_START = "Time in the run at which the file's time is 0"
_FILE = "File of columns (CSV, text, OpenSim or Parquet) beside the study"
_COLUMNS = "Heading of each column to read, by role; without it the headings decide"
_FLIP = "Columns whose sign is reversed"
_BODY_MASS = "Multiplies a force or a moment that the file states per kilogram"
_CYCLE_TIME = "Time of one cycle, where the file has no times: only a phase, or equal steps from 0 to 100 %"
_WINDOW = "Start and end of the part that is used, in the time of the file"


def _how(meaning: Any) -> dict[str, Any]:
    """Options of a field that says how a file was read: it does not matter to what was read."""
    return {"meaning": meaning, "default": None, "compare": False, "repr": False}


_RESOLUTION = (
    "Resolution: the load counts as at rest while it stays within this distance to either side for one period of the cutoff; "
    "defaults to an estimate from the recording's steps and noise"
)
_NOT_READ = Smoothed(NOTHING, np.zeros((0, 3)), np.zeros((0, 2)), 0.0, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Recording(HoldsArrays, PeriodicMotion):
    """A recorded motion, smoothed, with the force on the load if recorded: one cycle, made periodic, or a run.

    Create it from a file with `Recording.read`. Recordings of the same data are equal, regardless of their file names and of
    how they were read.

    Attributes
    ----------
    time : (n,) float              Increasing; the cycle or run lasts from the first to the last. [s]
    position, speed : (n,) float   Exactly one of the two. [m], [m s^-1]; about a joint [rad], [rad s^-1]
    force : (n,) float             External force on the load, positive along the motion; None if not recorded. [N]; about a
                                   joint the moment on the load, positive along the angle. [N m]
    rotary : bool                  Whether the motion is about a joint.
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
    file: str = component(_FILE, compare=False)
    columns: Mapping[str, str] | None = named_texts(names=tuple(ROLES), **_how(_COLUMNS))
    flip: tuple[str, ...] | None = chosen_words(words=SIGNED, **_how(_FLIP))
    body_mass: float | None = quantity("kg", Gt(0), **_how(_BODY_MASS))
    cycle_time: float | None = quantity("s", Gt(0), **_how(_CYCLE_TIME))
    window: tuple[float, ...] | None = quantities("s", FINITE, **_how(_WINDOW))
    sample_rate: float | None = quantity(
        "Hz", Gt(0), **_how("Rate to which the recording is resampled; defaults to its own rows")
    )
    resampling: Literal["linear", "cubic", "mean"] = component(
        "Method of resampling", default="linear", compare=False, repr=False
    )
    cutoff: float = quantity("Hz", Gt(0), "Cutoff frequency; smoothing removes everything above it", default=CUTOFF)
    resolution: float | None = quantity("m", Gt(0), _RESOLUTION, default=None)
    angle_resolution: float | None = quantity("rad", Gt(0), "As resolution, about a joint", default=None, repr=False)
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
    rotary: bool = field(repr=False, default=False)
    lines: tuple[int, ...] = field(repr=False, compare=False, default=())
    averaged: Strides | None = field(repr=False, compare=False, default=None)
    _period: float = field(init=False, repr=False, compare=False, default=0.0)
    _motion: Smoothed = field(init=False, repr=False, compare=False, default=_NOT_READ)
    _push: Smoothed | Series = field(init=False, repr=False, compare=False, default=NOTHING)
    _warnings: tuple[str, ...] = field(init=False, repr=False, compare=False, default=())

    @classmethod
    def read(
        cls,
        file: str,
        *,
        cutoff: float = CUTOFF,
        resolution: float | None = None,
        angle_resolution: float | None = None,
        closed: bool = True,
        strides: Literal["one", "average"] = "one",
        stride_time: float | None = None,
        **how: Any,
    ) -> Recording:
        """Read a file with the columns time, position (or speed) and optionally force, or those of a joint.

        Parameters
        ----------
        file : str
        cutoff, resolution, angle_resolution : float   As the fields.
        closed, strides, stride_time                   As the fields. Strides are found by a column heel_strike or phase, or
            by the period of the motion.
        how                                            Keywords of `infinivar.motion.files.timing.read_timed`: columns, flip,
            body_mass, cycle_time, window, sample_rate and resampling.

        Raises
        ------
        InputError
            If the file is invalid; the message names line and column.
        """
        table = read_timed(file, **how)
        return cls.of(
            table,
            cutoff=cutoff,
            resolution=resolution,
            angle_resolution=angle_resolution,
            closed=closed,
            strides=strides,
            stride_time=stride_time,
            **{**how, "file": file},
        )

    @classmethod
    def of(cls, table: RecordedTable, **fields: Any) -> Recording:
        """Make a recording of a table with times; a speed beside a position is not used.

        Raises
        ------
        InputError
            If the table has neither position nor speed, or fewer than two strides to average.
        """
        values = table.values
        if "position" in values:
            values.pop("speed", None)
        if "position" not in values and "speed" not in values:
            raise InputError(
                f"{table.file}: {table.top}: must name a column of position or speed, or of angle or angular speed; "
                f"{headings_in(table)}"
            )
        data: dict[str, Any] = {name: values[name] for name in ("time", "position", "speed", "force") if name in values}
        data["lines"] = tuple(table.lines.tolist())
        if fields.get("strides") == "average":
            found = strides_of(table, fields.get("stride_time"))
            data = {name: values for name, values in found.mean_cycle.items() if name in data}
            data["averaged"] = found
        return cls(**{"file": table.file, **fields}, **data, rotary=table.axis.rotary)

    def __post_init__(self) -> None:
        """Validate, copy, lock and smooth the data."""
        check_real(self)
        if (self.position is None) == (self.speed is None):
            raise ParameterError("position or speed must be given, but not both")
        _check_strides(self)
        columns = _columns_of(
            self, "time", *(name for name in ("position", "speed", "force") if getattr(self, name) is not None)
        )
        lines = self.lines or tuple(range(1, len(columns["time"]) + 1))
        if self.rotary and self.resolution is not None:
            raise ParameterError("resolution is a distance, but the motion is about a joint: state angle_resolution")
        if not self.rotary and self.angle_resolution is not None:
            raise ParameterError("angle_resolution is an angle, but the motion is along a line: state resolution")
        resolution = self.angle_resolution if self.rotary else self.resolution
        found = smoothed(printable(self.file), columns, lines, self.cutoff, resolution, self.axis, closed=self.closed)
        made = {
            "_period": found.period,
            "_motion": found.motion,
            "_push": found.force or NOTHING,
            "_warnings": found.warnings,
        }
        for name, value in {**columns, **made}.items():
            object.__setattr__(self, name, value)

    @property
    def axis(self) -> Axis:
        """Whether the motion is along a line or about a joint."""
        return ROTARY if self.rotary else LINEAR

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
        """Largest apparent displacement of a load at rest, to either side. [m]; about a joint [rad]"""
        return self._motion.resolution

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of gaps, drift, possibly unrecognised rest and unusual strides."""
        unusual = {} if self.averaged is None else self.averaged.outliers
        name = printable(self.file)
        return (
            *self._warnings,
            *(
                f"{name}: stride {number} is unusual: {reason}; it is averaged too"
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
        data: dict[str, Any] = {"position": None, "speed": None, "force": None, **self.averaged.record}
        return dataclasses.replace(self, closed=False, strides="one", stride_time=None, lines=(), averaged=None, **data)

    def derivatives(self, time: Any, orders: int) -> list[np.ndarray]:
        """Return position [m] and its time derivatives up to an order, at times in 0 to `period` [s]."""
        return self._motion.derivatives(time, orders)

    def push(self, time: Any, orders: int) -> list[np.ndarray]:
        """Return the recorded force on the load [N] and its derivatives up to an order."""
        return self._push.derivatives(time, orders)


def _check_strides(recording: Recording) -> None:
    """Check that keys on strides agree with one another and with the data."""
    if recording.strides == "one" and recording.stride_time is not None:
        raise ParameterError("stride_time does not apply with strides = 'one'; remove it, or set strides = 'average'")
    if recording.strides == "average" and not recording.closed:
        raise ParameterError("closed must be true with strides = 'average', which gives one cycle; remove one of them")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Waypoints(HoldsArrays):
    """A motion through given positions: a cubic spline that starts and ends at rest, constant before and after.

    Create it from a file with `Waypoints.read`.

    Attributes
    ----------
    time, position : (n,) float   Times increase. [s], [m]; about a joint [rad]
    rotary : bool                 Whether the motion is about a joint.

    Raises
    ------
    ParameterError
        If a field is outside its range.
    """

    shape: ClassVar[str] = "file"
    file: str = component(_FILE, compare=False)
    columns: Mapping[str, str] | None = named_texts(names=tuple(ROLES), **_how(_COLUMNS))
    flip: tuple[str, ...] | None = chosen_words(words=SIGNED, **_how(_FLIP))
    cycle_time: float | None = quantity("s", Gt(0), **_how(_CYCLE_TIME))
    window: tuple[float, ...] | None = quantities("s", FINITE, **_how(_WINDOW))
    start: float = quantity("s", Ge(0), _START, default=0.0)
    time: np.ndarray = field(repr=False)
    position: np.ndarray = field(repr=False)
    rotary: bool = field(repr=False, default=False)
    _spline: _Spline = field(init=False, repr=False, compare=False)

    @classmethod
    def read(cls, file: str, *, start: float = 0.0, **how: Any) -> Self:
        """Read a file with the columns time and position, or angle; the bare headings ``time`` and ``position`` mean SI.

        Parameters
        ----------
        file : str
        start : float   As the field. [s]
        how             Keywords of `infinivar.motion.files.timing.read_timed`.

        Raises
        ------
        InputError
            If the file is invalid; the message names line and column.
        """
        return cls(start=start, **_read(file, "position", "m", "angle", how))

    def __post_init__(self) -> None:
        """Validate, copy and lock the data, and fit the spline."""
        check_real(self)
        columns = _columns_of(self, "time", "position")
        spline = _Spline.through(columns["time"].tolist(), columns["position"].tolist())
        for name, value in {**columns, "_spline": spline}.items():
            object.__setattr__(self, name, value)

    @property
    def axis(self) -> Axis:
        """Whether it is along a line or about a joint."""
        return ROTARY if self.rotary else LINEAR

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

    Create it from a file with `RecordedForce.read`.

    Attributes
    ----------
    time, force : (n,) float   Times increase; force positive along the motion. [s], [N]; about a joint [N m]
    rotary : bool              Whether it is a moment about a joint.

    Raises
    ------
    ParameterError
        If a field is outside its range.
    """

    shape: ClassVar[str] = "file"
    file: str = component(_FILE, compare=False)
    columns: Mapping[str, str] | None = named_texts(names=tuple(ROLES), **_how(_COLUMNS))
    flip: tuple[str, ...] | None = chosen_words(words=SIGNED, **_how(_FLIP))
    body_mass: float | None = quantity("kg", Gt(0), **_how(_BODY_MASS))
    cycle_time: float | None = quantity("s", Gt(0), **_how(_CYCLE_TIME))
    window: tuple[float, ...] | None = quantities("s", FINITE, **_how(_WINDOW))
    start: float = quantity("s", Ge(0), _START, default=0.0)
    time: np.ndarray = field(repr=False)
    force: np.ndarray = field(repr=False)
    rotary: bool = field(repr=False, default=False)
    _rows: tuple[list[float], list[float]] = field(init=False, repr=False, compare=False)

    @classmethod
    def read(cls, file: str, *, start: float = 0.0, **how: Any) -> Self:
        """Read a file with the columns time and force, or moment; the bare headings ``time`` and ``force`` mean SI.

        Parameters
        ----------
        file : str
        start : float   As the field. [s]
        how             Keywords of `infinivar.motion.files.timing.read_timed`.

        Raises
        ------
        InputError
            If the file is invalid; the message names line and column.
        """
        return cls(start=start, **_read(file, "force", "N", "moment", how))

    def __post_init__(self) -> None:
        """Validate, copy and lock the data."""
        check_real(self)
        columns = _columns_of(self, "time", "force")
        rows = columns["time"].tolist(), columns["force"].tolist()
        for name, value in {**columns, "_rows": rows}.items():
            object.__setattr__(self, name, value)

    @property
    def axis(self) -> Axis:
        """Whether it is along a line or about a joint."""
        return ROTARY if self.rotary else LINEAR

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


def _read(file: str, wanted: str, unit: str, rotary: str, how: Mapping[str, Any]) -> dict[str, Any]:
    """Read times and values from a file, as fields; the bare names of the two columns mean SI."""
    table = read_timed(file, usual={"time": "s", wanted: unit}, roles=("time", "phase", wanted, rotary), **how)
    values = table.values
    if wanted not in values:
        raise InputError(f"{table.file}: {table.top}: must name a column of {wanted} or {rotary}; {headings_in(table)}")
    found = {name: values[name] for name in ("time", wanted)}
    return {**how, **found, "file": file, "rotary": table.axis.rotary}


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
