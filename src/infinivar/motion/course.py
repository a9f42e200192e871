"""Prescribed motion of the load, and the external force on it."""

from __future__ import annotations

from infinivar._core.array_namespace import Array, namespace
from infinivar._core.result import Frozen, result
from infinivar.transmission.rates import Varying

_STARTING_SPEED = 1e-200
"""Speed of a load about to move; small enough that its power is negligible. [m s^-1]"""


def heading(speed: Array, acceleration: Array) -> Array:
    """Speed, or a negligible one along the acceleration where it is zero: it sets the direction of friction. [m s^-1]"""
    xp = namespace(speed, acceleration)
    return xp.where(speed == 0, _STARTING_SPEED * xp.sign(acceleration), speed)


@result
class Course(Frozen):
    """Motion of the load and external force on it, at instants of time; arrays that broadcast to one shape, SI.

    About a joint these are the angle, its derivatives and the external moment.

    Attributes
    ----------
    speed, acceleration, jerk, snap : (...,) float       First to fourth derivative of the load's position.
    force, force_rate, force_curvature : (...,) float    External force on the load, positive along the motion. [N] ...
    position : (...,) float                              Of the load; drives with springs or a linkage need it. [m]
    fifth, sixth, force_third, force_fourth : (...,) float   Higher derivatives; a series spring behind a cobotic
        transmission needs them.
    closes : bool   Whether the instants, on the last axis, are in order and one cycle that repeats; else a run. It matters
        for springs with hysteresis only.
    """

    speed: Array
    acceleration: Array
    jerk: Array = 0.0
    snap: Array = 0.0
    force: Array = 0.0
    force_rate: Array = 0.0
    force_curvature: Array = 0.0
    position: Array | None = None
    fifth: Array | None = None
    sixth: Array | None = None
    force_third: Array | None = None
    force_fourth: Array | None = None
    closes: bool = True

    @property
    def at_rest(self) -> Array:
        """Where the load is at rest, without acceleration."""
        return (self.speed == 0) & (self.acceleration == 0)

    @property
    def heading(self) -> Array:
        """Speed; a negligible one along the acceleration where the load starts from rest, to set the friction's direction.

        Zero at rest, without acceleration. [m s^-1]
        """
        return heading(self.speed, self.acceleration)

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
