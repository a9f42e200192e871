"""Duty cycles: motions that a drive repeats, or follows once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple, Self

import numpy as np
from annotated_types import Gt, Interval

from infinivar._core.bounds import FINITE
from infinivar._core.fields import check_kind, check_real, given, quantity, tagged
from infinivar._core.plugins import is_own
from infinivar.axis import LINEAR, ROTARY, Axis
from infinivar.errors import InputError, ParameterError
from infinivar.motion.course import Course
from infinivar.motion.gait import Gait, Running, Walking
from infinivar.motion.motion import PeriodicMotion
from infinivar.motion.motions import Hold, Reaches, Sinusoid, Tremor
from infinivar.motion.recordings import Recording
from infinivar.motion.task import Task, check_motion, check_task, enough
from infinivar.units import plain

CYCLES: dict[str, type] = {kind.shape: kind for kind in (Hold, Sinusoid, Reaches, Tremor, Walking, Running, Recording)}
"""Kinds of motion of a duty cycle, by their name in `shape`; defaults to the first."""

SAMPLES = 2000
"""Fewest instants per cycle; fast motions use more."""
_PER_WAVE = 40
"""Fewest instants per period of the highest frequency."""
_MOST_SAMPLES = 200_000

_ROUNDED = 0.005
"""Shares of rounded percentages add up to 1 within this."""


class Instants(NamedTuple):
    """A cycle at the midpoints of equal steps."""

    time: np.ndarray
    position: np.ndarray
    course: Course


@dataclass(frozen=True, slots=True, kw_only=True)
class DutyCycle(Task):
    """A periodic motion of the load, or a run, with the external force on it.

    The constant `force`, or `moment` about a joint, acts on the load, positive along the motion, in addition to the motion's own
    force: the torque of a joint, or a recorded force.

    Raises
    ------
    ParameterError
        If a field is outside its range, or the derivatives of a motion of another package are not those of its position.
    """

    motion: PeriodicMotion = tagged("Periodic motion of the load", CYCLES, flat=True)
    force: float | None = quantity("N", FINITE, "Constant external force on the load", default=None)
    moment: float | None = quantity("N m", FINITE, "Constant external moment on the load of a joint", default=None)
    ambient: float = quantity("K", Gt(0), "Ambient temperature of the motors", default=298.15)
    start_temperature: float | None = quantity(
        "K", Gt(0), "Temperature of the motors at the start of a run; defaults to ambient", default=None
    )
    time_share: float | None = quantity(
        "1",
        Interval(gt=0, le=1),
        "Share of the time spent in this cycle; those of all cycles add up to 100 %",
        default=None,
    )
    distance_per_cycle: float | None = quantity(
        "m", Gt(0), "Distance covered per cycle, such as the stride length; gives energy per metre", default=None
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_real(self)
        check_kind("motion", self.motion, CYCLES, "derivatives")
        if is_own(self.motion):
            check_motion(self.motion)
        _ = self.axis  # refuses a mixture
        if self.closed and self.start_temperature is not None:
            raise ParameterError(
                "start_temperature does not apply to a cycle, which is repeated until temperatures are steady; remove it, "
                "or set closed = false for a recording of a run"
            )

    def loaded(self, mass: float | None) -> Self:
        """Return the cycle with this load mass, unless it has its own; the torque of a gait already includes the leg. [kg]"""
        return self if isinstance(self.motion, Gait) else super(DutyCycle, self).loaded(mass)

    @property
    def axis(self) -> Axis:
        """Whether the load moves along a line or about a joint; a hold is about a joint if its moment or inertia is given."""
        pushes = [
            (name, axis) for name, axis in (("force", LINEAR), ("moment", ROTARY)) if getattr(self, name) is not None
        ]
        return self._common_axis(None if isinstance(self.motion, Hold) else self.motion.axis, *pushes)

    @property
    def push(self) -> float:
        """Constant external force on the load, or moment about its joint; 0 if none is set. [N], [N m]"""
        return given(self.force, given(self.moment, 0.0))

    @property
    def period(self) -> float:
        """Time of one cycle, or of the run. [s]"""
        return self.motion.period

    @property
    def closed(self) -> bool:
        """Whether the motion repeats; if not, it is a run."""
        return self.motion.repeats

    @property
    def per(self) -> str:
        """What energies refer to: "per cycle" or "over the run"."""
        return "per cycle" if self.closed else "over the run"

    @property
    def start(self) -> float:
        """Temperature of the motors at the start of a run. [K]"""
        return self.ambient if self.start_temperature is None else self.start_temperature

    @property
    def reference_mass(self) -> tuple[float, str] | None:
        """Mass to which energies refer, and its name: the body's, else that of a load along a line; None without one. [kg]"""
        body = getattr(self.motion, "body_mass", None)
        if body is not None:
            return body, "body mass"
        return None if not self.load_mass or self.axis.rotary else (self.load_mass, "load mass")

    @property
    def warnings(self) -> tuple[str, ...]:
        """Valid input that looks like an oversight."""
        if not isinstance(self.motion, Recording) or self.motion.force is not None or self.moved_mass or self.push:
            return self.motion.warnings
        keys, what = ("moment", "load_inertia"), "moment or inertia"
        if not self.axis.rotary:
            keys, what = ("force", "load_mass"), "force or mass"
        return (
            *self.motion.warnings,
            f"the load has no {what}, so that drives move only themselves; record the {keys[0]}, or state {' or '.join(keys)}",
        )

    @property
    def resting(self) -> float:
        """Time per cycle or run during which the load is at rest. [s]"""
        return float(np.mean(np.broadcast_to(self.instants().course.at_rest, self.samples()))) * self.period

    def samples(self, least: int = SAMPLES, per_wave: int = _PER_WAVE) -> int:
        """Number of instants per cycle: a multiple of 4, so that none falls on a reversal of a symmetric motion."""
        required = max(least, int(per_wave * self.motion.fastest * self.period))
        return 4 * -(-min(required, _MOST_SAMPLES) // 4)

    def at(self, time: Any, orders: int = 4) -> tuple[Any, Course]:
        """Position [m] and course of the load at times from 0 to `period`. [s]

        The course has derivatives of the position up to `orders`, 4 to 6, and of the force up to two less.
        """
        position, speed, acceleration, jerk, snap, *higher = enough(self.motion, "derivatives", time, orders)
        force, rate, curvature, *higher_forces = enough(self.motion, "push", time, orders - 2)
        return position, Course(
            **dict(zip(("fifth", "sixth"), higher, strict=False)),
            **dict(zip(("force_third", "force_fourth"), higher_forces, strict=False)),
            closes=self.closed,
            position=position,
            speed=speed,
            acceleration=acceleration,
            jerk=jerk,
            snap=snap,
            force=force + self.push,
            force_rate=rate,
            force_curvature=curvature,
        )

    def instants(self, samples: int | None = None, orders: int = 4) -> Instants:
        """Evaluate one cycle at the midpoints of equal steps; `samples` defaults to `samples()`, `orders` as for `at`."""
        count = samples or self.samples()
        time = (np.arange(count) + 0.5) * (self.period / count)
        return Instants(time, *self.at(time, orders))


def check_duty_cycle(duty: object) -> None:
    """Raise ParameterError unless it is a duty cycle; the message says what to write in place of a motion or a name."""
    check_task("duty", duty, DutyCycle, "duty")


def shares_of(duty: Mapping[str, Any], group: str = "duty.", what: str = "duty cycle") -> dict[str, float]:
    """Share of the time spent in each duty cycle, as stated in `time_share`.

    Parameters
    ----------
    duty : mapping   Duty cycles, or others with a `time_share`, by name.
    group, what      What stands before a name in a study, and what one is called.

    Returns
    -------
    dict of str to float   Divided by their sum, since percentages are often rounded; empty if no cycle states a share. [-]

    Raises
    ------
    InputError
        If only some cycles state a share, or the shares do not add up to 100 % within 0.5 %.
    """
    stated = {name: cycle.time_share for name, cycle in duty.items() if cycle.time_share is not None}
    if not stated:
        return {}
    first = next(iter(stated))
    for name in duty:
        if name not in stated:
            raise InputError(
                f"{group}{name}.time_share is missing: {group}{first} has one; state it for every {what} or for none"
            )
    total = sum(stated.values())
    if abs(total - 1.0) > _ROUNDED:
        listed = ", ".join(f"{group}{name} {plain(100 * share, 4)} %" for name, share in stated.items())
        raise InputError(f"time_share: the shares add up to {plain(100 * total, 4)} %, not to 100 %: {listed}")
    return {name: share / total for name, share in stated.items()}
