"""Motions and forces as functions of time: what a scenario asks of a link, and what pushes its load."""

from __future__ import annotations

import bisect
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple, Protocol

from annotated_types import Ge, Gt

from infinivar._core.bounds import NonZero
from infinivar._core.fields import check, check_choice, component, quantity
from infinivar.motion.tables import read_columns

MotionShape = Literal["hold", "cruise", "sinusoid", "step", "reach", "file"]
ForceShape = Literal["constant", "sinusoid", "step", "file"]


class Motion(NamedTuple):
    """Where a motion is at one time."""

    position: float
    speed: float
    acceleration: float


class MotionPath(Protocol):
    """What a scenario's motion can do, whatever it is made from."""

    @property
    def shape(self) -> str:
        """A word for reports."""
        ...

    @property
    def breaks(self) -> Sequence[float]:
        """Times at which speed or acceleration may jump. [s]"""
        ...

    def at(self, time: float) -> Motion:
        """Position [m], speed [m s^-1] and acceleration [m s^-2] at a time [s]."""
        ...


class ForcePath(Protocol):
    """What a scenario's force can do, whatever it is made from."""

    @property
    def shape(self) -> str:
        """A word for reports."""
        ...

    @property
    def breaks(self) -> Sequence[float]:
        """Times at which the force or its slope jumps. [s]"""
        ...

    def value(self, time: float) -> float:
        """Force at a time. [N]"""
        ...

    def rate(self, time: float) -> float:
        """Slope of the force over time. [N s^-1]"""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class MotionProfile:
    """A motion of the link.

    - ``hold``: stay where it is; ``cruise``: at constant `speed`;
    - ``sinusoid``: ``distance sin(2 pi frequency (t - start))``, already under way at the beginning;
    - ``step``: by `distance` at `start`; ``reach``: by `distance` in `time` from `start`, with the least jerk;
    - ``file``: positions from the columns time [s] and position [m] of a CSV file, by a cubic spline through them.

    Raises
    ------
    ParameterError
        If a field is outside its range, or one is missing that the shape needs.
    InputError
        If the file cannot be read.
    """

    shape: MotionShape = component("hold, cruise, sinusoid, step, reach (least jerk) or file", default="hold")
    distance: float | None = quantity(
        "m", NonZero(), "Amplitude of the sinusoid, length of step or reach", default=None
    )
    speed: float | None = quantity("m/s", NonZero(), "Speed of the cruise", default=None)
    frequency: float | None = quantity("Hz", Gt(0), "Frequency of the sinusoid", default=None)
    time: float | None = quantity("s", Gt(0), "Time that the reach takes", default=None)
    start: float = quantity("s", Ge(0), "When it begins", default=0.0)
    file: str | None = component(
        "CSV file with the columns time and position, units in its header, SI without", default=None
    )
    _spline: _Spline | None = field(init=False, repr=False, compare=False, default=None)

    def __post_init__(self) -> None:
        """Refuse what is incomplete, and read the file."""
        check(self)
        check_choice(self, "shape", _MOTION_NEEDS)
        if self.shape == "file":
            object.__setattr__(self, "_spline", _Spline.through(*_columns(str(self.file), "position", "m")))

    @property
    def breaks(self) -> Sequence[float]:
        """Times at which speed or acceleration may jump. [s]"""
        if self.shape == "reach":
            return (self.start, self.start + (self.time or 0.0))
        return (self.start,) if self.shape in ("step", "cruise") else ()

    def at(self, time: float) -> Motion:
        """Position [m], speed [m s^-1] and acceleration [m s^-2] at a time [s]."""
        since = time - self.start
        size = self.distance or 0.0
        if self.shape == "sinusoid":
            turn = 2.0 * math.pi * (self.frequency or 0.0)
            sine, cosine = math.sin(turn * since), math.cos(turn * since)
            return Motion(size * sine, size * turn * cosine, -size * turn * turn * sine)
        if self.shape == "file" and self._spline is not None:
            return self._spline.at(since)
        if since < 0.0 or self.shape == "hold":
            return Motion(0.0, 0.0, 0.0)
        if self.shape == "cruise":
            return Motion((self.speed or 0.0) * since, self.speed or 0.0, 0.0)
        if self.shape == "step":
            return Motion(size, 0.0, 0.0)
        return Motion(*least_jerk(size, self.time or 1.0, min(since, self.time or 1.0))[:3])


_MOTION_NEEDS = {
    "hold": (),
    "cruise": ("speed",),
    "sinusoid": ("distance", "frequency"),
    "step": ("distance",),
    "reach": ("distance", "time"),
    "file": ("file",),
}


def least_jerk(distance: float, duration: float, since: Any) -> tuple[Any, Any, Any, Any, Any]:
    """The fifth-order polynomial that starts and ends at rest without acceleration.

    Parameters
    ----------
    distance, duration : float   Way and time from rest to rest. [m], [s]
    since : (...,) float         Time since its beginning, 0 to `duration`. [s]

    Returns
    -------
    tuple of (...,) float   Position, speed, acceleration, jerk and snap. [m] to [m s^-4]

    Source: flash1985, Eq 2.
    """
    s = since / duration
    rest = 1.0 - s
    return (
        distance * s**3 * (10.0 - s * (15.0 - 6.0 * s)),
        30.0 * distance / duration * (s * rest) ** 2,
        60.0 * distance / duration**2 * s * rest * (1.0 - 2.0 * s),
        60.0 * distance / duration**3 * (1.0 - 6.0 * s * rest),
        360.0 * distance / duration**4 * (2.0 * s - 1.0),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class ForceProfile:
    """A force that acts on the load from outside, positive along the motion.

    - ``constant``: `size` all the time; ``step``: `size` from `start` on;
    - ``sinusoid``: ``size sin(2 pi frequency (t - start))``;
    - ``file``: from the columns time [s] and force [N] of a CSV file, straight between its rows.

    Raises
    ------
    ParameterError
        If a field is outside its range, or one is missing that the shape needs.
    InputError
        If the file cannot be read.
    """

    shape: ForceShape = component("constant, sinusoid, step or file", default="constant")
    size: float | None = quantity("N", NonZero(), "Force, or amplitude of the sinusoid", default=None)
    frequency: float | None = quantity("Hz", Gt(0), "Frequency of the sinusoid", default=None)
    start: float = quantity("s", Ge(0), "When it begins", default=0.0)
    file: str | None = component(
        "CSV file with the columns time and force, units in its header, SI without", default=None
    )
    _rows: tuple[list[float], list[float]] | None = field(init=False, repr=False, compare=False, default=None)

    def __post_init__(self) -> None:
        """Refuse what is incomplete, and read the file."""
        check(self)
        check_choice(self, "shape", _FORCE_NEEDS)
        if self.shape == "file":
            object.__setattr__(self, "_rows", _columns(str(self.file), "force", "N"))

    @property
    def breaks(self) -> Sequence[float]:
        """Times at which the force or its slope jumps. [s]"""
        if self._rows is not None:
            return tuple(time + self.start for time in self._rows[0])
        return (self.start,) if self.shape == "step" else ()

    def value(self, time: float) -> float:
        """Force at a time. [N]"""
        since, size = time - self.start, self.size or 0.0
        if self._rows is not None:
            low, share, _ = _place(self._rows[0], since)
            forces = self._rows[1]
            return forces[low] + share * (forces[low + 1] - forces[low])
        if self.shape == "sinusoid":
            return size * math.sin(2.0 * math.pi * (self.frequency or 0.0) * since)
        return size if self.shape == "constant" or since >= 0.0 else 0.0

    def rate(self, time: float) -> float:
        """Slope of the force over time. [N s^-1]"""
        since = time - self.start
        if self._rows is not None:
            low, share, width = _place(self._rows[0], since)
            inside = 0.0 < share < 1.0
            return (self._rows[1][low + 1] - self._rows[1][low]) / width if inside else 0.0
        if self.shape == "sinusoid":
            turn = 2.0 * math.pi * (self.frequency or 0.0)
            return (self.size or 0.0) * turn * math.cos(turn * since)
        return 0.0


_FORCE_NEEDS = {"constant": ("size",), "sinusoid": ("size", "frequency"), "step": ("size",), "file": ("file",)}


def _columns(file: str, wanted: str, unit: str) -> tuple[list[float], list[float]]:
    """Times and values of a CSV file; a heading without a unit means SI."""
    columns, _ = read_columns(file, (("time", "s"), (wanted, unit)), ("time", wanted), units_needed=False)
    return columns["time"], columns[wanted]


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

    def at(self, time: float) -> Motion:
        low, share, width = _place(self.times, time)
        cubic, square, linear, constant = self.coefficients[low]
        s = share * width
        position = constant + s * (linear + s * (square + s * cubic))
        if not self.times[0] <= time <= self.times[-1]:
            return Motion(position, 0.0, 0.0)
        return Motion(position, linear + s * (2.0 * square + 3.0 * s * cubic), 2.0 * square + 6.0 * s * cubic)
