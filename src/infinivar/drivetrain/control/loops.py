"""Loops of sampled controllers whose bandwidth places their poles: a PI speed loop and a position servo, of limited output."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from infinivar._core.fields import given
from infinivar.parts.motor import Motor

_SLOWEST = 0.05
"""Least speed of a cylinder by which wheels are steered, over that at which it is set: below, it would give no angle."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Loop:
    """PI controller with limited output and anti-windup: the integral stops while the output is limited."""

    proportional: float
    integral: float
    limit: float

    def act(
        self, error: float, memory: float, period: float, ahead: Callable[[float], float] = lambda grown: grown
    ) -> tuple[float, float]:
        """Output and new integral; `memory` is the integral so far, `ahead` maps it to the output with feedforward."""
        grown = memory + self.integral * error * period
        demanded = self.proportional * error + ahead(grown)
        output = min(max(demanded, -self.limit), self.limit)
        return output, grown if output == demanded or (demanded > output) != (error > 0) else memory


def speed_loop(bandwidth: float, inertia: float, gain: float, limit: float) -> Loop:
    """PI loop that places both poles of an inertia at the bandwidth. [Hz], [kg m^2], [N m A^-1], [A]"""
    pole = 2.0 * math.pi * bandwidth
    return Loop(proportional=2.0 * pole * inertia / gain, integral=pole * pole * inertia / gain, limit=limit)


@dataclass(frozen=True, slots=True, kw_only=True)
class Servo:
    """Position servo of an inertia with known friction: two poles at the bandwidth, no integral action.

    Friction feedforward (`friction` [A]) acts in the commanded direction, in full from the speed `full_speed` [rad s^-1] on.
    """

    proportional: float
    damping: float
    friction: float
    full_speed: float
    limit: float

    @classmethod
    def place(
        cls, bandwidth: float, inertia: float, gain: float, limit: float, friction: float, full_speed: float
    ) -> Servo:
        """From bandwidth [Hz], inertia [kg m^2], torque per current [N m A^-1], current limit [A] and friction [N m]."""
        pole, scale = 2.0 * math.pi * bandwidth, inertia / gain
        return cls(
            proportional=pole**2 * scale,
            damping=2.0 * pole * scale,
            friction=friction / gain,
            full_speed=full_speed,
            limit=limit,
        )

    def act(self, error: float, speed: float, demanded_speed: float) -> float:
        """Current for an angle error, the angular speed and the commanded speed. [rad], [rad s^-1]"""
        heading = demanded_speed + self.proportional / self.damping * error
        current = (
            self.proportional * error
            + self.damping * (demanded_speed - speed)
            + self.friction * share_of(heading, self.full_speed)
        )
        return min(max(current, -self.limit), self.limit)


def share_of(value: float, full: float) -> float:
    """A value over that from which on it counts in full, within -1 and 1."""
    return min(max(value / full, -1.0), 1.0)


def turning_speed(speed: float, set_speed: float) -> float:
    """Speed of a cylinder by which wheels are steered, in the direction in which it is set. [rad s^-1]"""
    return math.copysign(max(abs(speed), _SLOWEST * abs(set_speed)), set_speed)


def largest_current(stated: float | None, motor: Motor) -> float:
    """Limit of a motor's current, as stated, or that of its stall. [A]"""
    return given(stated, motor.voltage / motor.resistance)
