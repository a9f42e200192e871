"""Motions of the load given by formulas or published tables; `recordings` has those read from files."""

from __future__ import annotations

import functools
import math
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import resources
from typing import Any, ClassVar, Literal

import numpy as np
from annotated_types import Ge, Gt, Interval

from infinivar._core.arrays import Whole
from infinivar._core.bounds import NonZero
from infinivar._core.fields import check_real, component, quantity
from infinivar.errors import require
from infinivar.motion.fourier import Series
from infinivar.motion.motion import NOTHING, MotionState, PeriodicMotion

_START = "Start of the motion"


@dataclass(frozen=True, slots=True, kw_only=True)
class Rest(Whole):
    """Stay at 0 for the whole run."""

    shape: ClassVar[str] = "hold"

    @property
    def breaks(self) -> Sequence[float]:
        """Times at which speed or acceleration may jump. [s]"""
        return ()

    def at(self, time: float) -> MotionState:
        """Position [m], speed [m s^-1] and acceleration [m s^-2] at a time [s]."""
        return MotionState(0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Cruise(Whole):
    """Stay at 0, then move at constant `speed` from `start`.

    Raises
    ------
    ParameterError
        If a field is outside its range.
    """

    shape: ClassVar[str] = "cruise"
    speed: float = quantity("m/s", NonZero(), "Speed of the cruise")
    start: float = quantity("s", Ge(0), _START, default=0.0)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_real(self)

    @property
    def breaks(self) -> Sequence[float]:
        """Times at which speed or acceleration may jump. [s]"""
        return (self.start,)

    def at(self, time: float) -> MotionState:
        """Position [m], speed [m s^-1] and acceleration [m s^-2] at a time [s]."""
        since = time - self.start
        return MotionState(0.0, 0.0, 0.0) if since < 0.0 else MotionState(self.speed * since, self.speed, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Step(Whole):
    """Stay at 0, then jump to `distance` at `start`, to show the controllers' step response.

    Raises
    ------
    ParameterError
        If a field is outside its range.
    """

    shape: ClassVar[str] = "step"
    distance: float = quantity("m", NonZero(), "Length of the step")
    start: float = quantity("s", Ge(0), _START, default=0.0)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_real(self)

    @property
    def breaks(self) -> Sequence[float]:
        """Times at which speed or acceleration may jump. [s]"""
        return (self.start,)

    def at(self, time: float) -> MotionState:
        """Position [m], speed [m s^-1] and acceleration [m s^-2] at a time [s]."""
        return MotionState(0.0 if time - self.start < 0.0 else self.distance, 0.0, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Reach(Whole):
    """Stay at 0, make a minimum-jerk move of `distance` in `time` from `start`, then stay there.

    Raises
    ------
    ParameterError
        If a field is outside its range.
    """

    shape: ClassVar[str] = "reach"
    distance: float = quantity("m", NonZero(), "Length of the reach")
    time: float = quantity("s", Gt(0), "Time of the reach")
    start: float = quantity("s", Ge(0), _START, default=0.0)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_real(self)

    @property
    def breaks(self) -> Sequence[float]:
        """Times at which speed or acceleration may jump. [s]"""
        return (self.start, self.start + self.time)

    def at(self, time: float) -> MotionState:
        """Position [m], speed [m s^-1] and acceleration [m s^-2] at a time [s]."""
        since = time - self.start
        if since < 0.0:
            return MotionState(0.0, 0.0, 0.0)
        return MotionState(*least_jerk(self.distance, self.time, min(since, self.time))[:3])


@dataclass(frozen=True, slots=True, kw_only=True)
class Hold(PeriodicMotion):
    """Stay at 0, with a period of `time`, to show the cost of holding a force.

    Raises
    ------
    ParameterError
        If the field is outside its range.
    """

    shape: ClassVar[str] = "hold"
    time: float = quantity("s", Gt(0), "Time of the hold")

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_real(self)

    @property
    def period(self) -> float:
        """Time of one cycle. [s]"""
        return self.time

    def derivatives(self, time: Any, orders: int) -> list[np.ndarray]:
        """Return zeros for the position and each derivative."""
        return NOTHING.derivatives(time, orders)


@dataclass(frozen=True, slots=True, kw_only=True)
class Sinusoid(PeriodicMotion):
    """Sinusoidal motion ``distance sin(2 pi frequency (t - start))``, also before `start`.

    Raises
    ------
    ParameterError
        If a field is outside its range.
    """

    shape: ClassVar[str] = "sinusoid"
    distance: float = quantity("m", NonZero(), "Amplitude")
    frequency: float = quantity("Hz", Gt(0), "Frequency")
    start: float = quantity("s", Ge(0), "Time of phase zero", default=0.0)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_real(self)

    @property
    def period(self) -> float:
        """Time of one cycle. [s]"""
        return 1.0 / self.frequency

    @property
    def fastest(self) -> float:
        """Highest frequency in the motion. [Hz]"""
        return self.frequency

    def derivatives(self, time: Any, orders: int) -> list[np.ndarray]:
        """Return position [m] and its time derivatives up to an order, at times in 0 to `period` [s]."""
        phase = 2.0 * math.pi * self.frequency * self.start
        cosine = 0.0 - self.distance * math.sin(phase)
        series = Series(self.period, np.array([0.0, cosine]), np.array([0.0, self.distance * math.cos(phase)]))
        return series.derivatives(time, orders)

    def at(self, time: float) -> MotionState:
        """Position [m], speed [m s^-1] and acceleration [m s^-2] at a time [s]."""
        since, size, turn = time - self.start, self.distance, 2.0 * math.pi * self.frequency
        sine, cosine = math.sin(turn * since), math.cos(turn * since)
        return MotionState(size * sine, size * turn * cosine, -size * turn * turn * sine)


@dataclass(frozen=True, slots=True, kw_only=True)
class Reaches(PeriodicMotion):
    """Make a minimum-jerk move of `distance` in `time`, pause, move back, pause.

    Raises
    ------
    ParameterError
        If a field is outside its range.
    """

    shape: ClassVar[str] = "reaches"
    distance: float = quantity("m", NonZero(), "Length of a reach")
    time: float = quantity("s", Gt(0), "Time of one reach")
    pause: float = quantity("s", Ge(0), "Pause after each reach", default=0.0)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_real(self)

    @property
    def period(self) -> float:
        """Time of one cycle. [s]"""
        return 2.0 * (self.time + self.pause)

    @property
    def fastest(self) -> float:
        """Highest frequency in the motion. [Hz]"""
        return 1.0 / self.time

    def derivatives(self, time: Any, orders: int) -> list[np.ndarray]:
        """Return position [m] and its time derivatives up to an order, at times in 0 to `period` [s]."""
        time = np.asarray(time, dtype=float)
        half = self.time + self.pause
        back = time >= half
        since = np.where(back, time - half, time)
        moving = since < self.time
        along = least_jerk(self.distance, self.time, np.where(moving, since, self.time))
        sign = np.where(back, -1.0, 1.0)
        position = np.where(back, self.distance, 0.0) + sign * along[0]
        return [position, *(np.where(moving, sign * part, 0.0) for part in along[1 : orders + 1])]


@dataclass(frozen=True, slots=True, kw_only=True)
class Tremor(PeriodicMotion):
    """Hand tremor: sinusoids of equal amplitude in a frequency band, with an RMS displacement of `distance`.

    Raises
    ------
    ParameterError
        If a field is outside its range, or the band is empty.
    """

    shape: ClassVar[str] = "tremor"
    distance: float = quantity("m", Gt(0), "RMS displacement")
    low_frequency: float = quantity("Hz", Gt(0), "Lower end of the band")
    high_frequency: float = quantity("Hz", Gt(0), "Upper end of the band")

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_real(self)
        high = f"< high_frequency = {self.high_frequency:g}"
        require(self.low_frequency < self.high_frequency, "low_frequency", self.low_frequency, high, "Hz")

    @property
    def _spacing(self) -> float:
        """Spacing of the frequencies. [Hz]"""
        return (self.high_frequency - self.low_frequency) / 16.0

    @property
    def _last(self) -> int:
        """Number of periods of the highest frequency in a cycle."""
        return round(self.high_frequency / self._spacing)

    @property
    def period(self) -> float:
        """Time of one cycle. [s]"""
        return 1.0 / self._spacing

    @property
    def fastest(self) -> float:
        """Highest frequency in the motion. [Hz]"""
        return self._last * self._spacing

    def derivatives(self, time: Any, orders: int) -> list[np.ndarray]:
        """Return position [m] and its time derivatives up to an order, at times in 0 to `period` [s]."""
        first, last = max(1, round(self.low_frequency / self._spacing)), self._last
        count = last - first + 1
        order = np.arange(count)
        # These phases give a low crest factor. Source: schroeder1970, for a flat spectrum.
        phase = -np.pi * order * (order - 1) / count
        size = self.distance * math.sqrt(2.0 / count)
        cosine, sine = np.zeros(last + 1), np.zeros(last + 1)
        cosine[first:], sine[first:] = size * np.cos(phase), -size * np.sin(phase)
        return Series(self.period, cosine, sine).derivatives(time, orders)


@dataclass(frozen=True, slots=True, kw_only=True)
class Walking(PeriodicMotion):
    """A leg joint in level walking, coupled to the drive by a `lever_arm`, with the joint torque as the motion's force.

    Source: grimmer2014 (means over walkers, as Fourier series).

    Raises
    ------
    ParameterError
        If a field is outside its range.
    """

    shape: ClassVar[str] = "walking"
    joint: Literal["ankle", "knee", "hip"] = component("Joint: ankle, knee or hip")
    body_mass: float = quantity("kg", Gt(0), "Body mass of the person")
    stride_time: float = quantity("s", Gt(0), "Time of one stride (two steps); it does not change the joint angles")
    lever_arm: float = quantity("m", Gt(0), "Lever arm of the drive about the joint")
    share: float = quantity("1", Interval(gt=0, le=1), "Share of the joint torque that the drive supplies", default=1.0)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_real(self)

    @property
    def period(self) -> float:
        """Time of one cycle. [s]"""
        return self.stride_time

    @property
    def fastest(self) -> float:
        """Highest frequency in the motion. [Hz]"""
        return (len(_strides()[self.joint]["speed"]["cosine"]) - 1) / self.stride_time

    def _series(self, name: str) -> Series:
        table = _strides()[self.joint][name]
        return Series(self.stride_time, np.array(table["cosine"]), np.array(table["sine"]))

    def derivatives(self, time: Any, orders: int) -> list[np.ndarray]:
        """Return position [m] and its time derivatives up to an order, at times in 0 to `period` [s]."""
        # A quicker stride turns the joint through the same angles.
        quicker = _strides()["stride_time"] / self.stride_time
        return self._series("speed").scaled(self.lever_arm * quicker).integral().derivatives(time, orders)

    def push(self, time: Any, orders: int) -> list[np.ndarray]:
        """Return the joint's force on the load [N] and its derivatives up to an order."""
        factor = -self.body_mass * self.share / self.lever_arm
        return self._series("torque").scaled(factor).derivatives(time, orders)


@functools.cache
def _strides() -> dict[str, Any]:
    return tomllib.loads((resources.files("infinivar.motion") / "data" / "walking.toml").read_text("utf-8"))


def least_jerk(distance: float, duration: float, since: Any) -> tuple[Any, Any, Any, Any, Any]:
    """Evaluate the minimum-jerk motion: a fifth-order polynomial that starts and ends at rest without acceleration.

    Parameters
    ----------
    distance, duration : float   Distance and time from rest to rest. [m], [s]
    since : (...,) float         Time since the start, 0 to `duration`. [s]

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
