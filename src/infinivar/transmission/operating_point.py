"""Operating point of a transmission element, as returned by `operate` and `deliver`."""

from __future__ import annotations

from collections.abc import Mapping

from infinivar._core.array_namespace import Array, namespace
from infinivar._core.described import derived, reported
from infinivar._core.labels import Labels
from infinivar._core.result import Result, result
from infinivar.limits import Limit
from infinivar.power import AT_POINT, PowerPoint


@result
class OperatingPoint(PowerPoint, Result):
    """Where the element stands: arrays that broadcast to one shape, SI.

    If the contact slips under a prescribed force, no steady motion exists: link speed, powers and losses are nan, and
    `limit` gives the reason. If it slips at a prescribed speed, the forces are those of gross sliding. The efficiency is
    nan where infeasible and where both sides feed the losses.
    """

    cylinder_speed: Array = reported("rad s-1", "cylinder speed", (...,))
    steering_tangent: Array
    torque: Array = reported("N m", "torque on the cylinder", (...,))
    link_speed: Array = reported("m s-1", "link speed", (...,))
    link_force: Array = reported("N", "force on the link", (...,))
    rolling_speed: Array = reported("m s-1", "rolling speed", (...,))
    creep_speed: Array = reported("m s-1", "creep speed", (...,))
    lateral_force: Array = reported("N", "lateral force of the contact", (...,))
    losses: Mapping[str, Array]
    utilisation: Mapping[Limit, Array]
    labels: Labels | None = None

    _also = AT_POINT

    @derived("rad", "steering angle", (...,))
    def steering_angle(self) -> Array:
        """Steering angle phi. [rad]"""
        return namespace(self.steering_tangent).atan(self.steering_tangent)

    @property
    def power_in(self) -> Array:
        """Power from the cylinder, tau omega. [W]"""
        return self.torque * self.cylinder_speed

    @property
    def power_out(self) -> Array:
        """Power to the link, fl ldot. [W]"""
        return self.link_force * self.link_speed + 0.0  # no negative zero
