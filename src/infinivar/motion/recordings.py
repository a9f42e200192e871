"""Motions and forces from recordings: `read` loads the data once into the object, which no longer needs the file."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar, Literal

import numpy as np
from annotated_types import Gt

from infinivar._core.arrays import HoldsArrays
from infinivar._core.bounds import FINITE
from infinivar._core.fields import check_real, chosen_words, component, named_texts, quantities, quantity
from infinivar.axis import LINEAR, ROTARY, Axis
from infinivar.errors import InputError, ParameterError, printable
from infinivar.motion.files.agreement import one_course
from infinivar.motion.files.fields import (
    BODY_MASS,
    COLUMNS,
    CYCLE_TIME,
    FILE,
    FLIP,
    FORCE_COLUMNS,
    FORCE_FILE,
    WINDOW,
    columns_of,
    how_read,
)
from infinivar.motion.files.table import BESIDE, ROLES, SIGNED, RecordedTable
from infinivar.motion.fourier import Series
from infinivar.motion.motion import NOTHING, PeriodicMotion
from infinivar.motion.smoothing import Smoothed, smoothed
from infinivar.motion.strides import Strides, strides_of
from infinivar.motion.two_files import read_recording

CUTOFF = 10.0
"""Default cutoff of a recording. [Hz]"""

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
    doubts : tuple of str          What in the file contradicts itself, for the warnings.
    averaged : Strides             The strides of which the cycle is the mean; None if it is not an average.

    Raises
    ------
    ParameterError
        If a field is outside its range, or the cutoff is too low for the recording: less than two periods of it
        in a cycle, or one in a run.
    InputError
        If the data have too few rows, or do not end where they begin.
    """

    shape: ClassVar[str] = "file"
    file: str = component(FILE, compare=False)
    columns: Mapping[str, str] | None = named_texts(names=tuple(ROLES), **how_read(COLUMNS))
    flip: tuple[str, ...] | None = chosen_words(words=SIGNED, **how_read(FLIP))
    force_file: str | None = component(**how_read(FORCE_FILE))
    force_columns: Mapping[str, str] | None = named_texts(names=BESIDE, **how_read(FORCE_COLUMNS))
    body_mass: float | None = quantity("kg", Gt(0), **how_read(BODY_MASS))
    cycle_time: float | None = quantity("s", Gt(0), **how_read(CYCLE_TIME))
    window: tuple[float, ...] | None = quantities("s", FINITE, **how_read(WINDOW))
    sample_rate: float | None = quantity(
        "Hz", Gt(0), **how_read("Rate to which the recording is resampled; defaults to its own rows")
    )
    resampling: Literal["linear", "cubic", "mean"] | None = component(
        "Method of resampling; defaults to cubic at a higher rate than that of the rows, else to linear",
        default=None,
        compare=False,
        repr=False,
    )
    cutoff: float = quantity("Hz", Gt(0), "Cutoff frequency; smoothing removes everything above it", default=CUTOFF)
    resolution: float | None = quantity("m", Gt(0), _RESOLUTION, default=None)
    angle_resolution: float | None = quantity("rad", Gt(0), "As resolution, about a joint", default=None, repr=False)
    closed: bool = component(
        "Whether the recording is one cycle that ends where it starts; if false, it is a run, with its energy and "
        "temperatures from the start to the end",
        default=True,
    )
    closure: Literal["checked", "spread"] = component(
        "What happens to a cycle that does not end where it starts: refused beyond 5 % of its range, or spread evenly over it",
        default="checked",
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
    doubts: tuple[str, ...] = field(repr=False, compare=False, default=())
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
        closure: Literal["checked", "spread"] = "checked",
        strides: Literal["one", "average"] = "one",
        stride_time: float | None = None,
        **how: Any,
    ) -> Recording:
        """Read a file with the columns time, position (or speed) and optionally force, or those of a joint.

        Parameters
        ----------
        file : str
        cutoff, resolution, angle_resolution : float   As the fields.
        closed, closure, strides, stride_time          As the fields. Strides are found by a column heel_strike or phase, or
            by the period of the motion.
        how                                            Keywords of `infinivar.motion.two_files.read_recording`: force_file,
            force_columns, columns, flip, body_mass, cycle_time, window, sample_rate and resampling.

        Raises
        ------
        InputError
            If the file is invalid; the message names line and column.
        """
        table = read_recording(file, **how)
        fields = {
            "cutoff": cutoff,
            "resolution": resolution,
            "angle_resolution": angle_resolution,
            "closed": closed,
            "closure": closure,
            "strides": strides,
            "stride_time": stride_time,
            **how,
            "file": file,
        }
        try:
            return cls.of(table, **fields)
        except InputError as problem:
            if not how.get("force_file") or not table.warnings:
                raise
            # Rows that the second file leaves out may be why the cycle does not close.
            raise InputError("; ".join((*table.warnings, str(problem)))) from problem

    @classmethod
    def of(cls, table: RecordedTable, **fields: Any) -> Recording:
        """Make a recording of a table with times; a speed beside a position is compared with it, and not used.

        Raises
        ------
        InputError
            If the table has neither position nor speed, or fewer than two strides to average.
        """
        table = one_course(table)
        values = table.values
        data: dict[str, Any] = {name: values[name] for name in ("time", "position", "speed", "force") if name in values}
        data["lines"] = tuple(table.lines.tolist())
        if fields.get("strides") != "average":
            if fields.get("closed", True):
                _check_one_stride(table)
        else:
            found = strides_of(table, fields.get("stride_time"))
            data = {name: values for name, values in found.mean_cycle.items() if name in data}
            data["averaged"] = found
        return cls(**{"file": table.file, **fields}, **data, rotary=table.axis.rotary, doubts=table.warnings)

    def __post_init__(self) -> None:
        """Validate, copy, lock and smooth the data."""
        check_real(self)
        if (self.position is None) == (self.speed is None):
            raise ParameterError("position or speed must be given, but not both")
        _check_strides(self)
        columns = columns_of(
            self, "time", *(name for name in ("position", "speed", "force") if getattr(self, name) is not None)
        )
        lines = self.lines or tuple(range(1, len(columns["time"]) + 1))
        if self.rotary and self.resolution is not None:
            raise ParameterError("resolution is a distance, but the motion is about a joint: state angle_resolution")
        if not self.rotary and self.angle_resolution is not None:
            raise ParameterError("angle_resolution is an angle, but the motion is along a line: state resolution")
        resolution = self.angle_resolution if self.rotary else self.resolution
        options = {"closed": self.closed, "spread": self.closure == "spread"}
        found = smoothed(printable(self.file), columns, lines, self.cutoff, resolution, self.axis, **options)
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
        """Warnings of columns that contradict each other, gaps, drift, possibly unrecognised rest and unusual strides."""
        unusual = {} if self.averaged is None else self.averaged.outliers
        name = printable(self.file)
        return (
            *self.doubts,
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

    @property
    def as_cycles(self) -> tuple[Recording, ...]:
        """Each averaged stride as a cycle, if strides end with values of their own; else none."""
        found = self.averaged
        if found is None or not found.separate:
            return ()
        cycles = []
        for stride, lasts in enumerate(found.times):
            data: dict[str, Any] = {
                name: rows[stride] for name, rows in found.curves.items() if getattr(self, name) is not None
            }
            data |= {"time": found.share * lasts, "strides": "one", "stride_time": None, "lines": (), "averaged": None}
            cycles.append(dataclasses.replace(self, **data))
        return tuple(cycles)

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
    if recording.closure != "checked" and not recording.closed:
        raise ParameterError(
            "closure does not apply with closed = false, as a run may end anywhere; remove one of them"
        )
    if recording.strides == "average" and not recording.closed:
        raise ParameterError("closed must be true with strides = 'average', which gives one cycle; remove one of them")


def _check_one_stride(table: RecordedTable) -> None:
    """Refuse a phase that starts again, unless strides are averaged."""
    phase = table.columns.get("phase")
    drops = np.flatnonzero(np.diff(phase.values) < -0.5) if phase is not None else np.zeros(0, int)
    # A cycle recorded from within one stride into the next passes the end of the phase once.
    if phase is not None and (drops.size > 1 or (drops.size and phase.values[-1] > phase.values[0])):
        raise InputError(
            f"{table.file}: {table.place} {table.lines[drops[0] + 1]}, column {phase.heading!r}: starts another stride; average "
            'the strides with strides = "average", choose one with a window, or take all as a run with closed = false'
        )
