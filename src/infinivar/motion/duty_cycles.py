"""Duty cycles: what a drive does over and over."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple, Self

import numpy as np
from annotated_types import Gt

from infinivar._core.bounds import FINITE
from infinivar._core.fields import check, check_kind, quantity, tagged
from infinivar.motion.course import Course
from infinivar.motion.motion import PeriodicMotion
from infinivar.motion.motions import Hold, Reaches, Sinusoid, Tremor, Walking
from infinivar.motion.recordings import Recording
from infinivar.motion.task import Task

CYCLES: dict[str, type] = {kind.shape: kind for kind in (Hold, Sinusoid, Reaches, Tremor, Walking, Recording)}
"""Kinds of motion that a duty cycle's table can ask for, by the word in `shape`; the first if it has none."""

SAMPLES = 2000
"""Instants of a cycle at least; more where the motion has more to show."""
_PER_WAVE = 40
"""Instants of the shortest wave at least."""
_MOST_SAMPLES = 200_000


class Instants(NamedTuple):
    """A cycle at the midpoints of equal steps."""

    time: np.ndarray
    position: np.ndarray
    course: Course


@dataclass(frozen=True, slots=True, kw_only=True)
class DutyCycle(Task):
    """A motion of the load that repeats itself, with the force on it from outside.

    `force` acts on the load, positive along the motion, all the time, in addition to the force that belongs to the motion:
    a joint's torque, or what was recorded.

    Raises
    ------
    ParameterError
        If a field is outside its range.
    """

    motion: PeriodicMotion = tagged("Motion of the load that repeats", CYCLES, flat=True)
    force: float | None = quantity("N", FINITE, "Constant force on the load from outside", default=None)
    ambient: float = quantity("K", Gt(0), "Temperature around the motors", default=298.15)

    def __post_init__(self) -> None:
        """Refuse what is outside its range."""
        check(self)
        check_kind("motion", self.motion, CYCLES, "derivatives")

    def loaded(self, mass: float | None) -> Self:
        """The cycle with a load, unless it has one; the torque of a joint that walks moves the leg's mass, too. [kg]"""
        return self if isinstance(self.motion, Walking) else super(DutyCycle, self).loaded(mass)

    @property
    def period(self) -> float:
        """Time of one cycle. [s]"""
        return self.motion.period

    @property
    def warnings(self) -> tuple[str, ...]:
        """What looks like an oversight, though it can be computed."""
        return self.motion.warnings

    @property
    def resting(self) -> float:
        """Time of a cycle for which the load is at rest. [s]"""
        return float(np.mean(np.broadcast_to(self.instants().course.at_rest, self.samples()))) * self.period

    def samples(self, least: int = SAMPLES, per_wave: int = _PER_WAVE) -> int:
        """Instants of a cycle: a multiple of 4, so that none lies on a reversal of a symmetric motion."""
        wanted = max(least, int(per_wave * self.motion.fastest * self.period))
        return 4 * -(-min(wanted, _MOST_SAMPLES) // 4)

    def at(self, time: Any) -> tuple[Any, Course]:
        """Position [m] and course of the load at times from 0 to `period`. [s]"""
        position, speed, acceleration, jerk, snap = self.motion.derivatives(time, 4)
        force, rate, curvature = self.motion.push(time, 2)
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
