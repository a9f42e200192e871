"""Duty cycles: what a drive does over and over, by shape, from walking, or from a recording."""

from __future__ import annotations

import functools
import math
import tomllib
from dataclasses import dataclass, field
from importlib import resources
from typing import Any, Literal, NamedTuple

import numpy as np
from annotated_types import Ge, Gt, Interval

from infinivar._core.bounds import FINITE
from infinivar._core.fields import check, check_choice, component, quantity
from infinivar.errors import require
from infinivar.motion import recording
from infinivar.motion.course import Course
from infinivar.motion.fourier import Series
from infinivar.motion.profiles import least_jerk
from infinivar.motion.recording import Recording

DutyShape = Literal["hold", "sinusoid", "reaches", "tremor", "walking", "file"]
Joint = Literal["ankle", "knee", "hip"]

SAMPLES = 2000
"""Instants of a cycle at least; more where the motion has more to show."""
_PER_WAVE = 40
"""Instants of the shortest wave at least."""
_MOST_SAMPLES = 200_000
CUTOFF = 10.0
"""Of a recording, if none is given. [Hz]"""


class Instants(NamedTuple):
    """A cycle at the midpoints of equal steps."""

    time: np.ndarray
    position: np.ndarray
    course: Course


_NOTHING = Series(1.0, np.zeros(1), np.zeros(1))


@dataclass(frozen=True, slots=True)
class _BackAndForth:
    """Reaches by `way` [m] in `span` [s] and back, with a stay of `pause` [s] after each."""

    way: float
    span: float
    pause: float

    @property
    def half(self) -> float:
        return self.span + self.pause

    def derivatives(self, time: Any, orders: int) -> list[np.ndarray]:
        """Position and its derivatives, up to the fourth."""
        time = np.asarray(time, dtype=float)
        back = time >= self.half
        since = np.where(back, time - self.half, time)
        moving = since < self.span
        along = least_jerk(self.way, self.span, np.where(moving, since, self.span))
        sign = np.where(back, -1.0, 1.0)
        position = np.where(back, self.way, 0.0) + sign * along[0]
        return [position, *(np.where(moving, sign * part, 0.0) for part in along[1 : orders + 1])]


@dataclass(frozen=True, slots=True, kw_only=True)
class DutyCycle:
    """A motion of the load that repeats itself, with the force on it from outside.

    - ``hold``: stay for `time` against `force`;
    - ``sinusoid``: ``distance sin(2 pi frequency t)``;
    - ``reaches``: by `distance` in `time` with the least jerk, stay for `pause`, back, stay for `pause`;
    - ``tremor``: the hand's unwanted shaking: waves of equal size in the band from `low_frequency` to `high_frequency`, with an
      RMS displacement of `distance`;
    - ``walking``: a joint of the leg at level walking, through a `lever_arm` from joint to drive;
    - ``file``: a recording in a CSV file with the columns time and position or speed, and force if there is one, each with its
      unit in the header; smoothed with `cutoff`.

    `force` acts from outside on the load, positive along the motion, all the time, beside what the shape brings.

    Raises
    ------
    ParameterError
        If a field is outside its range, or one is missing that the shape needs.
    InputError
        If the file cannot be used; the message names the line.
    """

    title: str = component("Name for reports", default="")
    shape: DutyShape = component("hold, sinusoid, reaches, tremor, walking or file", default="hold")
    distance: float | None = quantity(
        "m", Gt(0), "Amplitude, way of a reach, or RMS displacement of tremor", default=None
    )
    frequency: float | None = quantity("Hz", Gt(0), "Frequency of the sinusoid", default=None)
    time: float | None = quantity("s", Gt(0), "Time of the hold, or of one reach", default=None)
    pause: float | None = quantity("s", Ge(0), "Stay after each reach", default=None)
    low_frequency: float | None = quantity("Hz", Gt(0), "Lower end of the tremor's band", default=None)
    high_frequency: float | None = quantity("Hz", Gt(0), "Upper end of the tremor's band", default=None)
    joint: Joint | None = component("Joint that walks: ankle, knee or hip", default=None)
    body_mass: float | None = quantity("kg", Gt(0), "Mass of the person who walks", default=None)
    stride_time: float | None = quantity("s", Gt(0), "Time of a stride, two steps", default=None)
    lever_arm: float | None = quantity("m", Gt(0), "Arm at which the drive acts on the joint", default=None)
    share: float | None = quantity(
        "1", Interval(gt=0, le=1), "Share of the joint's torque that the drive gives", default=None
    )
    file: str | None = component(
        "CSV file with the columns time and position or speed, and force, units in the header", default=None
    )
    cutoff: float | None = quantity("Hz", Gt(0), "Nothing of a recording above this frequency is kept", default=None)
    resolution: float | None = quantity(
        "m",
        Gt(0),
        "A recorded load is at rest while, for a wave of the cutoff, it moves no further than this to either side; "
        "as the recording's steps and noise show if left out",
        default=None,
    )
    force: float | None = quantity("N", FINITE, "Constant force on the load from outside", default=None)
    load_mass: float | None = quantity(
        "kg",
        Ge(0),
        "Mass of the load; the requirement's if left out, none where walking, whose torque has it",
        default=None,
    )
    ambient: float = quantity("K", Gt(0), "Temperature around the motors", default=298.15)
    period: float = field(init=False, repr=False, compare=False, default=math.nan)
    warnings: tuple[str, ...] = field(init=False, repr=False, compare=False, default=())
    _motion: Series | _BackAndForth | Recording = field(init=False, repr=False, compare=False, default=_NOTHING)
    _push: Series | Recording = field(init=False, repr=False, compare=False, default=_NOTHING)
    _fastest: float = field(init=False, repr=False, compare=False, default=0.0)

    def __post_init__(self) -> None:
        """Refuse what is incomplete, and make the motion ready."""
        check(self)
        check_choice(self, "shape", _NEEDS, _MAY)
        made = _MAKERS[self.shape](self)
        for name, value in made._asdict().items():
            object.__setattr__(self, name if name in ("period", "warnings") else f"_{name}", value)

    @property
    def moved_mass(self) -> float:
        """Mass of the load, 0 where there is none. [kg]"""
        return self.load_mass or 0.0

    @property
    def resting(self) -> float:
        """Time of a cycle for which the load is at rest. [s]"""
        return float(np.mean(np.broadcast_to(self.instants().course.at_rest, self.samples()))) * self.period

    @property
    def resolved(self) -> float:
        """How far a load at rest may move to either side: what a recording resolves; 0 for a motion by shape. [m]"""
        return self._motion.resolution if isinstance(self._motion, Recording) else 0.0

    def samples(self, least: int = SAMPLES, per_wave: int = _PER_WAVE) -> int:
        """Instants of a cycle: a multiple of 4, so that none lies on a reversal of a symmetric motion."""
        wanted = max(least, int(per_wave * self._fastest * self.period))
        return 4 * -(-min(wanted, _MOST_SAMPLES) // 4)

    def at(self, time: Any) -> tuple[Any, Course]:
        """Position [m] and course of the load at times from 0 to `period`. [s]"""
        position, speed, acceleration, jerk, snap = self._motion.derivatives(time, 4)
        force, rate, curvature = self._push.derivatives(time, 2)
        return position, Course(
            speed=speed,
            acceleration=acceleration,
            jerk=jerk,
            snap=snap,
            force=force + (self.force or 0.0),
            force_rate=rate,
            force_curvature=curvature,
        )

    def instants(self, samples: int | None = None) -> Instants:
        """One cycle at the midpoints of equal steps; `samples` of them, or as many as it needs."""
        count = samples or self.samples()
        time = (np.arange(count) + 0.5) * (self.period / count)
        return Instants(time, *self.at(time))


class _Made(NamedTuple):
    """What a shape comes to."""

    period: float
    motion: Series | _BackAndForth | Recording = _NOTHING
    push: Series | Recording = _NOTHING
    fastest: float = 0.0
    """Frequency of its shortest wave. [Hz]"""
    warnings: tuple[str, ...] = ()


def _given(value: float | None) -> float:
    assert value is not None
    return value


def _hold(duty: DutyCycle) -> _Made:
    return _Made(_given(duty.time))


def _sinusoid(duty: DutyCycle) -> _Made:
    frequency, size = _given(duty.frequency), _given(duty.distance)
    series = Series(1.0 / frequency, np.array([0.0, 0.0]), np.array([0.0, size]))
    return _Made(1.0 / frequency, series, fastest=frequency)


def _reaches(duty: DutyCycle) -> _Made:
    motion = _BackAndForth(_given(duty.distance), _given(duty.time), duty.pause or 0.0)
    return _Made(2.0 * motion.half, motion, fastest=1.0 / motion.span)


def _tremor(duty: DutyCycle) -> _Made:
    low, high = _given(duty.low_frequency), _given(duty.high_frequency)
    require(low < high, "low_frequency", low, f"< high_frequency = {high:g}", "Hz")
    spacing = (high - low) / 16.0
    first, last = max(1, round(low / spacing)), round(high / spacing)
    count = last - first + 1
    order = np.arange(count)
    # These phases keep the peaks of many equal waves low. Source: schroeder1970, for a flat spectrum.
    phase = -np.pi * order * (order - 1) / count
    size = _given(duty.distance) * math.sqrt(2.0 / count)
    cosine, sine = np.zeros(last + 1), np.zeros(last + 1)
    cosine[first:], sine[first:] = size * np.cos(phase), -size * np.sin(phase)
    series = Series(1.0 / spacing, cosine, sine)
    return _Made(1.0 / spacing, series, fastest=last * spacing)


@functools.cache
def _strides() -> dict[str, Any]:
    return tomllib.loads((resources.files("infinivar.motion") / "data" / "walking.toml").read_text("utf-8"))


def _walking(duty: DutyCycle) -> _Made:
    arm, stride = _given(duty.lever_arm), _given(duty.stride_time)
    table = _strides()[str(duty.joint)]
    speed = Series(stride, np.array(table["speed"]["cosine"]), np.array(table["speed"]["sine"])).scaled(arm)
    torque = Series(stride, np.array(table["torque"]["cosine"]), np.array(table["torque"]["sine"]))
    # What the drive gives to the joint is what the joint's load takes from the drive.
    push = torque.scaled(-_given(duty.body_mass) * (duty.share or 1.0) / arm)
    fastest = (len(speed.cosine) - 1) / stride
    return _Made(stride, speed.integral(), push, fastest)


def _file(duty: DutyCycle) -> _Made:
    cutoff = duty.cutoff or CUTOFF
    found = recording.read(str(duty.file), cutoff, duty.resolution)
    return _Made(found.period, found.motion, found.force or _NOTHING, cutoff, found.warnings)


_NEEDS = {
    "hold": ("time",),
    "sinusoid": ("distance", "frequency"),
    "reaches": ("distance", "time"),
    "tremor": ("distance", "low_frequency", "high_frequency"),
    "walking": ("joint", "body_mass", "stride_time", "lever_arm"),
    "file": ("file",),
}
_MAY = {"reaches": ("pause",), "walking": ("share",), "file": ("cutoff", "resolution")}
"""Fields that a shape needs, and those that it may have besides."""

_MAKERS = {
    "hold": _hold,
    "sinusoid": _sinusoid,
    "reaches": _reaches,
    "tremor": _tremor,
    "walking": _walking,
    "file": _file,
}
