"""What every motion and every force offers, whatever it is made from.

A study names a motion's kind by its `shape`. Each kind is a small frozen class with its own fields only:

- motions of a run: `Rest`, `Cruise`, `Step`, `Reach` and `Waypoints`, which end, and every motion that repeats;
- motions that repeat: `Hold`, `Sinusoid`, `Reaches`, `Tremor`, `Walking` and `Recording`;
- forces: `ConstantForce`, `SinusoidalForce`, `StepForce` and `RecordedForce`.
"""

from __future__ import annotations

import abc
from collections.abc import Sequence
from typing import Any, ClassVar, NamedTuple, Protocol

import numpy as np

from infinivar.motion.fourier import Series

NOTHING = Series(1.0, np.zeros(1), np.zeros(1))
"""Zero at all times, as a Fourier series."""


class MotionState(NamedTuple):
    """Where a motion is at one time."""

    position: float
    speed: float
    acceleration: float


class Motion(Protocol):
    """A motion of the load over time, as controllers follow it."""

    shape: ClassVar[str]
    """Its kind, as studies and reports name it."""

    @property
    def breaks(self) -> Sequence[float]:
        """Times at which speed or acceleration may jump. [s]"""
        ...

    def at(self, time: float) -> MotionState:
        """Position [m], speed [m s^-1] and acceleration [m s^-2] at a time [s]."""
        ...


class PeriodicMotion(abc.ABC):
    """A motion that repeats itself, with the force that belongs to it, as inverse dynamics needs them."""

    __slots__ = ()

    shape: ClassVar[str]

    @property
    @abc.abstractmethod
    def period(self) -> float:
        """Time of one cycle. [s]"""

    @abc.abstractmethod
    def derivatives(self, time: Any, orders: int) -> list[np.ndarray]:
        """Position [m] and its derivatives by time up to an order, at most the fourth, at times from 0 to `period` [s]."""

    def push(self, time: Any, orders: int) -> list[np.ndarray]:
        """Force on the load [N] that belongs to the motion, with its derivatives up to an order, at most the second."""
        return NOTHING.derivatives(time, orders)

    @property
    def fastest(self) -> float:
        """Frequency of the shortest wave; 0 for none. [Hz]"""
        return 0.0

    @property
    def resolved(self) -> float:
        """How far a load at rest may seem to move to either side; 0 for a motion that is given by formula. [m]"""
        return 0.0

    @property
    def warnings(self) -> tuple[str, ...]:
        """What looks like an oversight, though it can be computed."""
        return ()

    @property
    def breaks(self) -> Sequence[float]:
        """Times at which speed or acceleration may jump. [s]"""
        return ()

    def at(self, time: float) -> MotionState:
        """Position [m], speed [m s^-1] and acceleration [m s^-2] at a time [s]."""
        position, speed, acceleration = self.derivatives(np.array([time % self.period]), 2)
        return MotionState(float(position[0]), float(speed[0]), float(acceleration[0]))


class Force(Protocol):
    """A force on the load from outside, positive along the motion."""

    shape: ClassVar[str]
    """Its kind, as studies and reports name it."""

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
