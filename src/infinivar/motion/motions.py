"""Motions of the load given by formulas or published tables; `recordings` has those read from files."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np
from annotated_types import Ge, Gt

from infinivar._core.arrays import Whole
from infinivar._core.bounds import NonZero
from infinivar._core.fields import check_real, component, quantity
from infinivar.errors import require
from infinivar.motion.fourier import Series
from infinivar.motion.motion import NOTHING, AlongOrAbout, MotionState, PeriodicMotion

_START = "Start of the motion"

Profile = Literal["minimum-jerk", "smooth"]

_PROFILE = "minimum-jerk (the jerk jumps at both ends), or smooth (the first four derivatives vanish there)"

_SMOOTH = np.polynomial.Polynomial([0, 0, 0, 0, 0, 126, -420, 540, -315, 70])
"""Polynomial from 0 at 0 to 1 at 1, with four derivatives zero at both ends."""


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
class Cruise(AlongOrAbout, Whole):
    """Stay at 0, then move at constant `speed`, or `angular_speed`, from `start`.

    Raises
    ------
    ParameterError
        If a field is outside its range.
    """

    shape: ClassVar[str] = "cruise"
    either: ClassVar[tuple[str, str]] = ("speed", "angular_speed")
    speed: float | None = quantity("m/s", NonZero(), "Speed of the cruise", default=None)
    angular_speed: float | None = quantity("rad/s", NonZero(), "Speed of the cruise about a joint", default=None)
    start: float = quantity("s", Ge(0), _START, default=0.0)

    def __post_init__(self) -> None:
        """Validate the fields."""
        self._validate()

    @property
    def breaks(self) -> Sequence[float]:
        """Times at which speed or acceleration may jump. [s]"""
        return (self.start,)

    def at(self, time: float) -> MotionState:
        """Position [m], speed [m s^-1] and acceleration [m s^-2] at a time [s]."""
        since = time - self.start
        return MotionState(0.0, 0.0, 0.0) if since < 0.0 else MotionState(self.magnitude * since, self.magnitude, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Step(AlongOrAbout, Whole):
    """Stay at 0, then jump to `distance`, or `angle`, at `start`, to show the controllers' step response.

    Raises
    ------
    ParameterError
        If a field is outside its range.
    """

    shape: ClassVar[str] = "step"
    distance: float | None = quantity("m", NonZero(), "Length of the step", default=None)
    angle: float | None = quantity("rad", NonZero(), "Length of the step, about a joint", default=None)
    start: float = quantity("s", Ge(0), _START, default=0.0)

    def __post_init__(self) -> None:
        """Validate the fields."""
        self._validate()

    @property
    def breaks(self) -> Sequence[float]:
        """Times at which speed or acceleration may jump. [s]"""
        return (self.start,)

    def at(self, time: float) -> MotionState:
        """Position [m], speed [m s^-1] and acceleration [m s^-2] at a time [s]."""
        return MotionState(0.0 if time - self.start < 0.0 else self.magnitude, 0.0, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Reach(AlongOrAbout, Whole):
    """Stay at 0, make a move of `distance`, or `angle`, in `time` from `start`, then stay there.

    Raises
    ------
    ParameterError
        If a field is outside its range.
    """

    shape: ClassVar[str] = "reach"
    distance: float | None = quantity("m", NonZero(), "Length of the reach", default=None)
    angle: float | None = quantity("rad", NonZero(), "Length of the reach, about a joint", default=None)
    time: float = quantity("s", Gt(0), "Time of the reach")
    profile: Profile = component(_PROFILE, default="minimum-jerk")
    start: float = quantity("s", Ge(0), _START, default=0.0)

    def __post_init__(self) -> None:
        """Validate the fields."""
        self._validate()

    @property
    def breaks(self) -> Sequence[float]:
        """Times at which speed or acceleration may jump. [s]"""
        return (self.start, self.start + self.time)

    def at(self, time: float) -> MotionState:
        """Position [m], speed [m s^-1] and acceleration [m s^-2] at a time [s]."""
        since = time - self.start
        if since < 0.0:
            return MotionState(0.0, 0.0, 0.0)
        return MotionState(*reach(self.profile, self.magnitude, self.time, min(since, self.time), 2))

    def over(self, times: np.ndarray) -> list[np.ndarray]:
        """The same at many times. (n,) each"""
        since = times - self.start
        moved = reach(self.profile, self.magnitude, self.time, np.clip(since, 0.0, self.time), 2)
        return [np.where(since < 0.0, 0.0, one) for one in moved]


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
class Sinusoid(AlongOrAbout, PeriodicMotion):
    """Sinusoidal motion ``distance sin(2 pi frequency (t - start))``, or of an `angle`, also before `start`.

    Raises
    ------
    ParameterError
        If a field is outside its range.
    """

    shape: ClassVar[str] = "sinusoid"
    distance: float | None = quantity("m", NonZero(), "Amplitude", default=None)
    angle: float | None = quantity("rad", NonZero(), "Amplitude, about a joint", default=None)
    frequency: float = quantity("Hz", Gt(0), "Frequency")
    start: float = quantity("s", Ge(0), "Time of phase zero", default=0.0)

    def __post_init__(self) -> None:
        """Validate the fields."""
        self._validate()

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
        cosine = 0.0 - self.magnitude * math.sin(phase)
        series = Series(self.period, np.array([0.0, cosine]), np.array([0.0, self.magnitude * math.cos(phase)]))
        return series.derivatives(time, orders)

    def at(self, time: float) -> MotionState:
        """Position [m], speed [m s^-1] and acceleration [m s^-2] at a time [s]."""
        since, size, turn = time - self.start, self.magnitude, 2.0 * math.pi * self.frequency
        sine, cosine = math.sin(turn * since), math.cos(turn * since)
        return MotionState(size * sine, size * turn * cosine, -size * turn * turn * sine)


@dataclass(frozen=True, slots=True, kw_only=True)
class Reaches(AlongOrAbout, PeriodicMotion):
    """Make a move of `distance`, or `angle`, in `time`, pause, move back, pause; or only the first half of it, as a run.

    Raises
    ------
    ParameterError
        If a field is outside its range.
    """

    shape: ClassVar[str] = "reaches"
    distance: float | None = quantity("m", NonZero(), "Length of a reach", default=None)
    angle: float | None = quantity("rad", NonZero(), "Length of a reach, about a joint", default=None)
    time: float = quantity("s", Gt(0), "Time of one reach")
    pause: float = quantity("s", Ge(0), "Pause after each reach", default=0.0)
    profile: Profile = component(_PROFILE, default="minimum-jerk")
    back: bool = component("Whether it moves back; if not, it is a run of one reach", default=True)

    def __post_init__(self) -> None:
        """Validate the fields."""
        self._validate()

    @property
    def period(self) -> float:
        """Time of one cycle, or of the run. [s]"""
        return (2.0 if self.back else 1.0) * (self.time + self.pause)

    @property
    def repeats(self) -> bool:
        """Whether it moves back."""
        return self.back

    def over(self, times: np.ndarray) -> list[np.ndarray]:
        """As of any motion; a run stays at its end."""
        return self.derivatives(times % self.period if self.back else np.minimum(times, self.period), 2)

    @property
    def fastest(self) -> float:
        """Highest frequency in the motion. [Hz]"""
        return 1.0 / self.time

    @property
    def continuous(self) -> int:
        """Highest time derivative of the position that has no jumps."""
        return 2 if self.profile == "minimum-jerk" else 4

    def derivatives(self, time: Any, orders: int) -> list[np.ndarray]:
        """Return position [m] and its time derivatives up to an order, at times in 0 to `period` [s]."""
        time = np.asarray(time, dtype=float)
        half = self.time + self.pause
        back = (time >= half) & self.back
        since = np.where(back, time - half, time)
        moving = since < self.time
        along = reach(self.profile, self.magnitude, self.time, np.where(moving, since, self.time), orders)
        sign = np.where(back, -1.0, 1.0)
        position = np.where(back, self.magnitude, 0.0) + sign * along[0]
        return [position, *(np.where(moving, sign * part, 0.0) for part in along[1:])]


@dataclass(frozen=True, slots=True, kw_only=True)
class Tremor(AlongOrAbout, PeriodicMotion):
    """Hand tremor: sinusoids of equal amplitude in a frequency band, with an RMS displacement of `distance`, or `angle`.

    Raises
    ------
    ParameterError
        If a field is outside its range, or the band is empty.
    """

    shape: ClassVar[str] = "tremor"
    distance: float | None = quantity("m", Gt(0), "RMS displacement", default=None)
    angle: float | None = quantity("rad", Gt(0), "RMS displacement, about a joint", default=None)
    low_frequency: float = quantity("Hz", Gt(0), "Lower end of the band")
    high_frequency: float = quantity("Hz", Gt(0), "Upper end of the band")

    def __post_init__(self) -> None:
        """Validate the fields."""
        self._validate()
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
        size = self.magnitude * math.sqrt(2.0 / count)
        cosine, sine = np.zeros(last + 1), np.zeros(last + 1)
        cosine[first:], sine[first:] = size * np.cos(phase), -size * np.sin(phase)
        return Series(self.period, cosine, sine).derivatives(time, orders)


def reach(profile: Profile, distance: Any, duration: Any, since: Any, orders: int) -> list[Any]:
    """Position of a reach and its time derivatives up to an order, at most the sixth.

    Parameters
    ----------
    profile                      See `least_jerk`; "smooth" is the polynomial of least order whose first four derivatives
        vanish at both ends.
    distance, duration, since    As for `least_jerk`.

    Returns
    -------
    list of (...,) float   [m] to [m s^-6]

    Source: flash1985, Eq 2, or ten boundary conditions.
    """
    if profile == "minimum-jerk":
        return [*least_jerk(distance, duration, since), 720.0 * distance / duration**5, 0.0][: orders + 1]
    share = since / duration
    return [distance / duration**order * _SMOOTH.deriv(order)(share) for order in range(orders + 1)]


def least_jerk(distance: Any, duration: Any, since: Any) -> tuple[Any, Any, Any, Any, Any]:
    """Evaluate the minimum-jerk motion: a fifth-order polynomial that starts and ends at rest without acceleration.

    Parameters
    ----------
    distance, duration : (...,) float   Distance and time from rest to rest. [m], [s]
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
