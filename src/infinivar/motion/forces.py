"""External forces on the load, or moments about its joint, given by formulas."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from annotated_types import Ge, Gt

from infinivar._core.arrays import Whole
from infinivar._core.bounds import NonZero
from infinivar._core.fields import quantity
from infinivar.motion.motion import AlongOrAbout


@dataclass(frozen=True, slots=True, kw_only=True)
class ConstantForce(AlongOrAbout, Whole):
    """Constant force.

    Raises
    ------
    ParameterError
        If the field is outside its range.
    """

    shape: ClassVar[str] = "constant"
    either: ClassVar[tuple[str, str]] = ("size", "moment")
    size: float | None = quantity("N", NonZero(), "Force, positive along the motion", default=None)
    moment: float | None = quantity("N m", NonZero(), "Moment about a joint, positive along the motion", default=None)

    def __post_init__(self) -> None:
        """Validate the fields."""
        self._validate()

    @property
    def breaks(self) -> Sequence[float]:
        """Times at which the force or its slope jumps. [s]"""
        return ()

    def value(self, time: float) -> float:
        """Force at a time. [N]"""
        return self.magnitude

    def rate(self, time: float) -> float:
        """Slope of the force over time. [N s^-1]"""
        return 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class StepForce(AlongOrAbout, Whole):
    """Zero force, then a constant force from `start`.

    Raises
    ------
    ParameterError
        If a field is outside its range.
    """

    shape: ClassVar[str] = "step"
    either: ClassVar[tuple[str, str]] = ("size", "moment")
    size: float | None = quantity("N", NonZero(), "Force after the step, positive along the motion", default=None)
    moment: float | None = quantity(
        "N m", NonZero(), "Moment about a joint after the step, positive along the motion", default=None
    )
    start: float = quantity("s", Ge(0), "Time of the step", default=0.0)

    def __post_init__(self) -> None:
        """Validate the fields."""
        self._validate()

    @property
    def breaks(self) -> Sequence[float]:
        """Times at which the force or its slope jumps. [s]"""
        return (self.start,)

    def value(self, time: float) -> float:
        """Force at a time. [N]"""
        return self.magnitude if time - self.start >= 0.0 else 0.0

    def rate(self, time: float) -> float:
        """Slope of the force over time. [N s^-1]"""
        return 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class SinusoidalForce(AlongOrAbout, Whole):
    """Sinusoidal force ``size sin(2 pi frequency (t - start))``, also before `start`.

    Raises
    ------
    ParameterError
        If a field is outside its range.
    """

    shape: ClassVar[str] = "sinusoid"
    either: ClassVar[tuple[str, str]] = ("size", "moment")
    size: float | None = quantity("N", NonZero(), "Amplitude", default=None)
    moment: float | None = quantity("N m", NonZero(), "Amplitude of a moment about a joint", default=None)
    frequency: float = quantity("Hz", Gt(0), "Frequency")
    start: float = quantity("s", Ge(0), "Time of phase zero", default=0.0)

    def __post_init__(self) -> None:
        """Validate the fields."""
        self._validate()

    @property
    def breaks(self) -> Sequence[float]:
        """Times at which the force or its slope jumps. [s]"""
        return ()

    def value(self, time: float) -> float:
        """Force at a time. [N]"""
        return self.magnitude * math.sin(2.0 * math.pi * self.frequency * (time - self.start))

    def rate(self, time: float) -> float:
        """Slope of the force over time. [N s^-1]"""
        turn = 2.0 * math.pi * self.frequency
        return self.magnitude * turn * math.cos(turn * (time - self.start))
