"""Motions and forces of a scenario from files: `read` loads the data once into the object."""

from __future__ import annotations

import bisect
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Self

import numpy as np
from annotated_types import Ge, Gt

from infinivar._core.arrays import HoldsArrays
from infinivar._core.bounds import FINITE
from infinivar._core.fields import check_real, chosen_words, component, named_texts, quantities, quantity
from infinivar.axis import LINEAR, ROTARY, Axis
from infinivar.errors import InputError, printable
from infinivar.motion.files.fields import BODY_MASS, COLUMNS, CYCLE_TIME, FILE, FLIP, WINDOW, columns_of, how_read
from infinivar.motion.files.reading import headings_in
from infinivar.motion.files.table import ROLES, SIGNED
from infinivar.motion.files.timing import read_timed
from infinivar.motion.motion import MotionState
from infinivar.units import plain

_FEWEST = 4
"""Fewest rows whose speed at the ends is known."""
_MOVING = 0.1
"""Speed at an end, as a share of the largest, above which a motion does not start and end at rest."""

_START = "Time in the run at which the file's time is 0"


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
    file: str = component(FILE, compare=False)
    columns: Mapping[str, str] | None = named_texts(names=tuple(ROLES), **how_read(COLUMNS))
    flip: tuple[str, ...] | None = chosen_words(words=SIGNED, **how_read(FLIP))
    cycle_time: float | None = quantity("s", Gt(0), **how_read(CYCLE_TIME))
    window: tuple[float, ...] | None = quantities("s", FINITE, **how_read(WINDOW))
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
        columns = columns_of(self, "time", "position")
        spline = _Spline.through(columns["time"].tolist(), columns["position"].tolist())
        for name, value in {**columns, "_spline": spline}.items():
            object.__setattr__(self, name, value)

    @property
    def axis(self) -> Axis:
        """Whether it is along a line or about a joint."""
        return ROTARY if self.rotary else LINEAR

    @property
    def warnings(self) -> tuple[str, ...]:
        """Rows that begin or end in motion, which the spline brings to rest within a row or two."""
        from scipy.interpolate import CubicSpline

        free, clamped = (CubicSpline(self.time, self.position, bc_type=ends) for ends in ("not-a-knot", "clamped"))
        speeds = np.abs(free(self.time, 1))
        first, last = speeds[[0, -1]].tolist()
        if len(self.time) < _FEWEST or max(first, last) <= _MOVING * np.max(speeds):
            return ()
        most = " and ".join(plain(float(np.max(np.abs(each(self.time, 2)))), 3) for each in (clamped, free))
        unit = self.axis.speed_unit
        return (
            f"{printable(self.file)}: the rows begin at {plain(first, 3)} {unit} and end at {plain(last, 3)} {unit}, but a "
            f"scenario's motion starts and ends at rest: accelerations of up to {most} {unit}² with and without; begin and end "
            "the file with rows at rest",
        )

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
    file: str = component(FILE, compare=False)
    columns: Mapping[str, str] | None = named_texts(names=tuple(ROLES), **how_read(COLUMNS))
    flip: tuple[str, ...] | None = chosen_words(words=SIGNED, **how_read(FLIP))
    body_mass: float | None = quantity("kg", Gt(0), **how_read(BODY_MASS))
    cycle_time: float | None = quantity("s", Gt(0), **how_read(CYCLE_TIME))
    window: tuple[float, ...] | None = quantities("s", FINITE, **how_read(WINDOW))
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
        columns = columns_of(self, "time", "force")
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


def _read(file: str, required: str, unit: str, rotary: str, how: Mapping[str, Any]) -> dict[str, Any]:
    """Read times and values from a file, as fields; the bare names of the two columns mean SI."""
    table = read_timed(file, usual={"time": "s", required: unit}, roles=("time", "phase", required, rotary), **how)
    values = table.values
    if required not in values:
        raise InputError(
            f"{table.file}: {table.top}: must name a column of {required} or {rotary}; {headings_in(table)}"
        )
    found = {name: values[name] for name in ("time", required)}
    return {**how, **found, "file": file, "rotary": table.axis.rotary}


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
