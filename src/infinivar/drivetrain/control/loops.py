"""Loops of sampled controllers whose bandwidth places their poles: a PI speed loop and a position servo, of limited output.

They compute with floats, or record what they do on a tape, from which it is printed as C.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from infinivar._core.fields import given
from infinivar.bondgraph.scalars import choose, share_of, signed, within
from infinivar.bondgraph.tape import Number
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
        self, error: Number, memory: Number, period: Number, ahead: Callable[[Number], Number] = lambda grown: grown
    ) -> tuple[Number, Number]:
        """Output and new integral; `memory` is the integral so far, `ahead` maps it to the output with feedforward."""
        grown = memory + self.integral * error * period
        demanded = self.proportional * error + ahead(grown)
        output = within(demanded, self.limit)
        further = choose(demanded > output, lambda: error > 0, lambda: error <= 0)
        return output, choose(output == demanded, lambda: grown, lambda: choose(further, lambda: memory, lambda: grown))


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

    def act(self, error: Number, speed: Number, demanded_speed: Number) -> Number:
        """Current for an angle error, the angular speed and the commanded speed. [rad], [rad s^-1]"""
        heading = demanded_speed + self.proportional / self.damping * error
        current = (
            self.proportional * error
            + self.damping * (demanded_speed - speed)
            + self.friction * share_of(heading, self.full_speed)
        )
        return within(current, self.limit)


def turning_speed(speed: Number, set_speed: float) -> Number:
    """Speed of a cylinder by which wheels are steered, in the direction in which it is set. [rad s^-1]"""
    least = _SLOWEST * abs(set_speed)
    return signed(choose(abs(speed) > least, lambda: abs(speed), lambda: least), set_speed)


def largest_current(stated: float | None, motor: Motor) -> float:
    """Limit of a motor's current, as stated, or that of its stall. [A]"""
    return given(stated, motor.voltage / motor.resistance)
