"""What a drive is to do: the motion of its load, and the force that acts on the load from outside."""

from __future__ import annotations

from infinivar._core.array_namespace import Array, namespace
from infinivar._core.result import Frozen, result
from infinivar.transmission.rates import Varying

_SETTING_OUT = 1e-200
"""Stands for a speed about to begin: with it no power is worth the name. [m s^-1]"""


@result
class Course(Frozen):
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
    def at_rest(self) -> Array:
        """Where the load stands still, without acceleration."""
        return (self.speed == 0) & (self.acceleration == 0)

    @property
    def heading(self) -> Array:
        """Speed, and as good as none where the load only sets out: friction there has the direction of the acceleration.

        At rest, without speed and acceleration, zero. [m s^-1]
        """
        xp = namespace(self.speed, self.acceleration)
        return xp.where(self.speed == 0, _SETTING_OUT * xp.sign(self.acceleration), self.speed)

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
