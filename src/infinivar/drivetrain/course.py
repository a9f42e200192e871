"""What a drive is to do: the motion of its load, and the force that acts on the load from outside."""

from __future__ import annotations

from dataclasses import dataclass

from infinivar._xp import Array
from infinivar.transmission.rates import Varying


@dataclass(frozen=True, slots=True, kw_only=True)
class Course:
    """Instants of a motion of the load, and of the force on it from outside; arrays that broadcast to one shape, SI.

    Attributes
    ----------
    speed, acceleration, jerk, snap : (...,) float       Of the load: its position differentiated one to four times.
    force, force_rate, force_curvature : (...,) float    From outside on the load, positive along the motion. [N] ...
    """

    speed: Array
    acceleration: Array
    jerk: Array = 0.0
    snap: Array = 0.0
    force: Array = 0.0
    force_rate: Array = 0.0
    force_curvature: Array = 0.0

    @property
    def varying_speed(self) -> Varying:
        """Speed with its derivatives. [m s^-1], [m s^-2], [m s^-3]"""
        return Varying(self.speed, self.acceleration, self.jerk)

    def driving_force(self, mass: Array) -> Varying:
        """Force that moves a mass along the course, with its derivatives. [N], [N s^-1], [N s^-2]

        Source: Newton's second law.
        """
        return Varying(
            mass * self.acceleration - self.force,
            mass * self.jerk - self.force_rate,
            mass * self.snap - self.force_curvature,
        )
