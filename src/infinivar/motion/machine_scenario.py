"""Scenarios of machines with many contacts: what they follow, who pushes them, and for how long."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from annotated_types import Gt, Interval

from infinivar._core.arrays import real_array
from infinivar._core.fields import check, component, quantity
from infinivar.contact.friction import STICK_SPEED
from infinivar.errors import ParameterError, require
from infinivar.motion.histories import VectorHistory

_MOST_SEGMENTS = 1e6
"""Most samples or results of a run; more would take hours."""

History = VectorHistory | Callable[[float], Any] | Sequence[float]
"""By time, or constant."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MachineScenario:
    """One simulated run of a machine.

    - `source` ``held``: a sampled loop of the power motor holds its shaft at the set speed; ``off``: the motor is without
      current, and its friction brakes; ``none``: there is no motor, so that the machine coasts or a user moves it.
    - `steering` ``controlled``: the wheels follow `motion`; ``locked``: the servos hold all angles at 0; or angles over time.
    - `servos`: whether sampled servos steer the wheels; without, the angles are exactly those prescribed.

    Raises
    ------
    ParameterError
        If a field is out of range or conflicts with another; the message names it.
    """

    duration: float = quantity("s", Gt(0), "Duration of the run")
    motion: VectorHistory | None = component(
        "Pose to follow, as `pose`; None: the pose at the start",
        default=None,
    )
    wrench: History | None = component(
        "What the machine exerts on its load or user over time: force and moment of a platform [N, N m], torques of the joints "
        "of an arm [N m], force and moment of a cart in its own axes [N, N m], torques of both shafts of a sphere [N m]; None: "
        "none",
        default=None,
    )
    source: Literal["held", "off", "none"] = component("What the power motor does", default="held")
    steering: Any = component(
        'What the wheels do: "controlled", "locked" or a history of angles [rad], smooth without servos',
        default="controlled",
    )
    servos: bool = component("Whether servos steer the wheels", default=True)
    sample_rate: float | None = quantity(
        "Hz", Gt(0), "Rate of the controllers; by default that of the machine's control", default=None
    )
    pose: Sequence[float] | None = component(
        "Configuration at the start; by default the machine's own: position and rotation vector of a platform [m, rad], joint "
        "angles of an arm [rad], x, y and angle of a cart [m, rad], nothing for a sphere",
        default=None,
    )
    rates: Sequence[float] | None = component(
        "Rates of the machine's coordinates at the start: twist of a platform or joint rates of an arm, then the speed of the "
        "common cylinder; twist of a cart in its own axes; speeds of both shafts of a sphere and its angular velocity "
        "[m/s, rad/s]; by default those of the motion and of a held shaft",
        default=None,
    )
    stick_speed: float = quantity("m/s", Gt(0), "Speed below which friction sticks", default=STICK_SPEED)
    settling_time: float | None = quantity(
        "s", Gt(0), "Initial time by which the run is not judged; must be shorter than the run", default=None
    )
    output_step: float | None = quantity(
        "s", Gt(0), "Time between results; defaults to a thousandth of the run, or a sample", default=None
    )
    tolerance: float = quantity(
        "1",
        Interval(gt=0, le=1e-3),
        "Error allowed in a step, over the size of each state and of the energy",
        default=1e-4,
    )

    def __post_init__(self) -> None:
        """Validate the fields and their combination."""
        check(self)
        if isinstance(self.steering, str):
            words = ("controlled", "locked")
            require(self.steering in words, "steering", repr(self.steering), "controlled, locked, or angles over time")
        if self.motion is not None and not isinstance(self.motion, VectorHistory):
            raise ParameterError(f"motion must be a VectorHistory, got {self.motion!r}")
        if self.motion is not None and not self.motion.smooth:
            raise ParameterError("motion.smooth must be true: steering angles jump where a motion has a kink")
        if not self.servos and self.motion is not None:
            raise ParameterError("motion needs servos that follow it; leave servos true, or prescribe steering")
        for name in ("pose", "rates"):
            if getattr(self, name) is not None:
                values = real_array(name, getattr(self, name))
                finite = values.ndim == 1 and bool(np.all(np.isfinite(values)))
                require(finite, name, getattr(self, name), "a row of finite numbers")
                object.__setattr__(self, name, tuple(map(float, values)))
        if self.settling_time is not None:
            require(
                self.settling_time < self.duration,
                "settling_time",
                self.settling_time,
                f"shorter than the run, {self.duration:g} s",
                "s",
            )
        check_length(self.duration, self.sample_rate, self.output_step)


def check_length(duration: float, sample_rate: float | None, output_step: float | None) -> None:
    """Raise ParameterError if a run has too many samples or results. [s], [Hz], [s]"""
    fastest = max(sample_rate or 0.0, 0.0 if output_step is None else 1.0 / output_step)
    short = duration * fastest <= _MOST_SEGMENTS
    require(short, "duration", f"{duration:g} s", "at most a million samples long")


def over_time(name: str, given: History, count: int) -> Callable[[float], np.ndarray]:
    """A history as a function of time that returns (count,) values.

    Raises
    ------
    ParameterError
        If it has another number of values, or one is not a finite number.
    """
    function: Any = given if callable(given) else functools.partial(_constant, real_array(name, given))
    first = real_array(name, function(0.0))
    fits = first.shape == (count,) and bool(np.all(np.isfinite(first)))
    require(fits, name, f"{first}" if first.ndim else f"{given}", f"{count} finite numbers at each instant")
    return function


@dataclass(frozen=True, slots=True)
class SideBySide:
    """Values over time of several functions in a row: equal if these are."""

    functions: tuple[Callable[[float], np.ndarray], ...]

    def __call__(self, time: float) -> np.ndarray:
        """Values at a time."""
        return np.concatenate([np.asarray(one(time), dtype=float) for one in self.functions])


_STEP_ANGLE = 1e-4
"""Change of an angle between close instants above which it is a step. [rad]"""

_CLOSE = 1e-10
"""Time between close instants, over the duration. [-]"""


def check_continuous(name: str, function: Callable[[float], Any], instants: Sequence[float]) -> None:
    """Raise ParameterError if angles over time [rad] have a step between two of these increasing instants. [s]

    Where they change, the interval is halved towards the larger change, which then vanishes unless it is a step.
    """
    close = _CLOSE * (instants[-1] - instants[0])
    before = np.asarray(function(float(instants[0])), dtype=float)
    for begin, end in itertools.pairwise(map(float, instants)):
        after = np.asarray(function(end), dtype=float)
        low, high, at_low, at_high = begin, end, before, after
        while np.max(np.abs(at_high - at_low)) > _STEP_ANGLE:
            if high - low < close:
                size = float(np.max(np.abs(at_high - at_low)))
                raise ParameterError(
                    f"{name} must be continuous where no servos follow it, got a step of {size:.3g} rad at {high:.6g} s; "
                    "smooth it, or leave servos true"
                )
            middle = 0.5 * (low + high)
            between = np.asarray(function(middle), dtype=float)
            if np.max(np.abs(between - at_low)) > np.max(np.abs(at_high - between)):
                high, at_high = middle, between
            else:
                low, at_low = middle, between
        before = after


def _constant(value: np.ndarray, time: float) -> np.ndarray:
    return value
