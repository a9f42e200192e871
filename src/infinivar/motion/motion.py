"""Interfaces of motions and forces.

A study selects a motion's kind by its `shape`. Each kind is a small frozen class with only its own fields:

- motions of a scenario: `Rest`, `Cruise`, `Step`, `Reach` and `Waypoints`, which end, and every periodic motion;
- periodic motions: `Hold`, `Sinusoid`, `Reaches`, `Tremor`, `Walking`, `Running` and `Recording`;
- forces: `ConstantForce`, `SinusoidalForce`, `StepForce` and `RecordedForce`.
"""

from __future__ import annotations

import abc
from collections.abc import Sequence
from typing import Any, ClassVar, NamedTuple, Protocol

import numpy as np

from infinivar._core.arrays import Whole
from infinivar._core.fields import check_one_of, check_real
from infinivar.axis import LINEAR, ROTARY, Axis
from infinivar.motion.fourier import Series

NOTHING = Series(1.0, np.zeros(1), np.zeros(1))
"""Zero at all times, as a Fourier series."""


class MotionState(NamedTuple):
    """State of a motion at one time."""

    position: float
    speed: float
    acceleration: float


class Motion(Protocol):
    """A motion of the load over time, for controllers to follow."""

    shape: ClassVar[str]
    """Name of its kind in studies and reports."""

    @property
    def breaks(self) -> Sequence[float]:
        """Times at which speed or acceleration may jump. [s]"""
        ...

    def at(self, time: float) -> MotionState:
        """Position [m], speed [m s^-1] and acceleration [m s^-2] at a time [s]."""
        ...


def states_over(path: Motion, times: Any) -> np.ndarray:
    """States of a motion at many times; at once if it has a method `over` for that. (n, 3) [m], [m s^-1], [m s^-2]"""
    over = getattr(path, "over", None)
    if over is not None and len(times) > 1:
        return np.stack(np.broadcast_arrays(*over(np.asarray(times))), axis=-1)
    return np.array([path.at(float(time)) for time in times], dtype=float).reshape(-1, 3)


class AlongOrAbout:
    """Base of motions and forces given by one of two fields: a value along a line, or one about a joint."""

    __slots__ = ()

    either: ClassVar[tuple[str, str]] = ("distance", "angle")
    """Names of both fields, of which exactly one is given."""

    def _validate(self) -> None:
        """Validate the fields."""
        check_real(self)
        check_one_of(self, *self.either)

    @property
    def magnitude(self) -> float:
        """The value along the line [m, m s^-1, N], or about the joint [rad, rad s^-1, N m]."""
        line, joint = self.either
        value = getattr(self, line)
        return getattr(self, joint) if value is None else value

    @property
    def axis(self) -> Axis:
        """Whether the value is along a line or about a joint."""
        return ROTARY if getattr(self, self.either[0]) is None else LINEAR


class PeriodicMotion(Whole, abc.ABC):
    """A periodic motion with its own force, as inverse dynamics needs them."""

    __slots__ = ()

    shape: ClassVar[str]

    @property
    def axis(self) -> Axis:
        """Whether the motion is along a line or about a joint; positions and forces are then angles and moments."""
        return LINEAR

    @property
    @abc.abstractmethod
    def period(self) -> float:
        """Time of one cycle. [s]"""

    @abc.abstractmethod
    def derivatives(self, time: Any, orders: int) -> list[np.ndarray]:
        """Return position [m] and its time derivatives up to an order, at most the sixth, at times in 0 to `period` [s]."""

    def push(self, time: Any, orders: int) -> list[np.ndarray]:
        """Return the motion's own force on the load [N] and its derivatives up to an order, at most the fourth."""
        return NOTHING.derivatives(time, orders)

    @property
    def repeats(self) -> bool:
        """Whether the motion repeats; if not, it is a run over `period`, which may end anywhere."""
        return True

    @property
    def fastest(self) -> float:
        """Highest frequency in the motion; 0 if it has none. [Hz]"""
        return 0.0

    @property
    def continuous(self) -> int:
        """Highest time derivative of the position that has no jumps, at most 6."""
        return 6

    @property
    def resolved(self) -> float:
        """Largest apparent displacement of a load at rest, to either side; 0 for a motion given by a formula. [m]"""
        return 0.0

    @property
    def warnings(self) -> tuple[str, ...]:
        """Valid input that looks like an oversight."""
        return ()

    @property
    def breaks(self) -> Sequence[float]:
        """Times at which speed or acceleration may jump. [s]"""
        return ()

    def at(self, time: float) -> MotionState:
        """Position [m], speed [m s^-1] and acceleration [m s^-2] at a time [s]."""
        return MotionState(*(float(one[0]) for one in self.over(np.array([time]))))

    def over(self, times: np.ndarray) -> list[np.ndarray]:
        """The same at many times. (n,) each"""
        return self.derivatives(times % self.period, 2)


class Force(Protocol):
    """An external force on the load, positive along the motion."""

    shape: ClassVar[str]
    """Name of its kind in studies and reports."""

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
