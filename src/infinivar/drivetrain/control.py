"""Controllers that a real machine would have, sampled at a rate, with limited current.

A loop's bandwidth places its poles: the cylinder's speed loop and the steering's position loop follow from the inertias
and torque constants, so that a study gives one number a loop.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from infinivar.drivetrain.profiles import MotionPath
from infinivar.errors import ParameterError
from infinivar.quantities import check, quantity


@dataclass(frozen=True, slots=True, kw_only=True)
class CoboticControl:
    """Loops of a cobotic drive: cylinder speed, steering angle, and link position above it."""

    sample_rate: float = quantity("Hz", "> 0", "Rate at which controllers sample", default=1000.0)
    cylinder_bandwidth: float = quantity("Hz", "> 0", "Bandwidth of the cylinder's speed loop", default=4.0)
    steering_bandwidth: float = quantity("Hz", "> 0", "Bandwidth of the steering servo", default=25.0)
    link_bandwidth: float = quantity("Hz", "> 0", "Bandwidth of the link's position loop", default=4.0)
    current_limit: float | None = quantity(
        "A", "> 0", "Largest current of the cylinder motor; stall current if left out", default=None
    )
    steering_current_limit: float | None = quantity(
        "A", "> 0", "Largest current of the steering motor; stall current if left out", default=None
    )

    def __post_init__(self) -> None:
        """Refuse what is not physical."""
        check(self)
        _slower(self, "cylinder_bandwidth", "steering_bandwidth", "link_bandwidth")


@dataclass(frozen=True, slots=True, kw_only=True)
class ConventionalControl:
    """Loops of a conventional drive: motor speed, and load position above it."""

    sample_rate: float = quantity("Hz", "> 0", "Rate at which controllers sample", default=1000.0)
    speed_bandwidth: float = quantity("Hz", "> 0", "Bandwidth of the speed loop", default=25.0)
    link_bandwidth: float = quantity("Hz", "> 0", "Bandwidth of the load's position loop", default=4.0)
    current_limit: float | None = quantity(
        "A", "> 0", "Largest current of the motor; stall current if left out", default=None
    )

    def __post_init__(self) -> None:
        """Refuse what is not physical."""
        check(self)
        _slower(self, "speed_bandwidth", "link_bandwidth")


def _slower(control: Any, *names: str) -> None:
    for name in names:
        if not getattr(control, name) <= 0.1 * control.sample_rate:
            raise ParameterError(
                f"{name} must be <= a tenth of sample_rate ({0.1 * control.sample_rate:g} Hz), got {getattr(control, name)}"
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class Loop:
    """PI control with limited output: the integral stops where the output is cut off."""

    proportional: float
    integral: float
    limit: float

    def act(self, error: float, damping: float, memory: float, period: float) -> tuple[float, float]:
        """Output and new integral. `damping` is taken off the output; `memory` is the integral so far."""
        grown = memory + self.integral * error * period
        wanted = self.proportional * error + grown - damping
        output = min(max(wanted, -self.limit), self.limit)
        return output, grown if output == wanted or (wanted > output) != (error > 0) else memory


def speed_loop(bandwidth: float, inertia: float, gain: float, limit: float) -> Loop:
    """PI loop that places both poles of an inertia at the bandwidth. [Hz], [kg m^2], [N m A^-1], [A]"""
    pole = 2.0 * math.pi * bandwidth
    return Loop(proportional=2.0 * pole * inertia / gain, integral=pole * pole * inertia / gain, limit=limit)


@dataclass(frozen=True, slots=True, kw_only=True)
class Servo:
    """Position servo of an inertia: three poles at the bandwidth."""

    loop: Loop
    damping: float

    @classmethod
    def place(cls, bandwidth: float, inertia: float, gain: float, limit: float) -> Servo:
        """From bandwidth [Hz], inertia [kg m^2], torque per current [N m A^-1] and current limit [A]."""
        pole, scale = 2.0 * math.pi * bandwidth, inertia / gain
        loop = Loop(proportional=3.0 * pole**2 * scale, integral=pole**3 * scale, limit=limit)
        return cls(loop=loop, damping=3.0 * pole * scale)


@dataclass(frozen=True, slots=True, kw_only=True)
class CoboticController:
    """Cylinder at constant speed, steering servo, and the link's position loop, which asks for steering angles.

    The link follows where the wheel points: ``ldot = -R omega tan(phi)``. Its loop asks for the speed of the motion and a
    correction in proportion to the position error, and for the angle that gives that speed.
    """

    sample_time: float
    cylinder: Loop
    steering: Servo
    link_gain: float
    surface_radius: float
    cylinder_speed: float
    run_up_time: float
    largest_angle: float
    held_angle: float | None
    path: MotionPath
    started: Mapping[str, float]
    outputs: tuple[str, str]

    def start(self, measured: Mapping[str, float]) -> tuple[float, float]:
        """Integrals of cylinder loop and steering servo."""
        return self.started["cylinder"], 0.0

    def sample(
        self, time: float, measured: Mapping[str, float], memory: tuple[float, float]
    ) -> tuple[dict[str, float], tuple[float, float]]:
        """Motor currents from cylinder speed, steering angle and rate, and link position."""
        share = 1.0 if self.run_up_time <= 0.0 else min(time / self.run_up_time, 1.0)
        error = share * self.cylinder_speed - measured["omega"]
        cylinder, drive = self.cylinder.act(error, 0.0, memory[0], self.sample_time)
        wanted = self.angle(time, measured)
        damping = self.steering.damping * measured["phi_rate"]
        steering, turn = self.steering.loop.act(wanted - measured["phi"], damping, memory[1], self.sample_time)
        return dict(zip(self.outputs, (cylinder, steering), strict=True)), (drive, turn)

    def angle(self, time: float, measured: Mapping[str, float]) -> float:
        """Steering angle wanted. [rad]"""
        if self.held_angle is not None:
            return self.held_angle
        goal = self.path.at(time)
        speed = goal.speed + self.link_gain * (goal.position - measured["l"])
        surface = self.surface_radius * measured["omega"]
        # A cylinder that hardly turns moves nothing: it is not steered after.
        least = 0.05 * self.surface_radius * abs(self.cylinder_speed)
        surface = math.copysign(max(abs(surface), least), self.cylinder_speed)
        return min(max(-math.atan(speed / surface), -self.largest_angle), self.largest_angle)


@dataclass(frozen=True, slots=True, kw_only=True)
class ConventionalController:
    """Speed loop of the load at the motor, under a position loop."""

    sample_time: float
    speed: Loop
    link_gain: float
    path: MotionPath | None
    output: str

    def start(self, measured: Mapping[str, float]) -> float:
        """Integral of the speed loop."""
        return 0.0

    def sample(self, time: float, measured: Mapping[str, float], memory: float) -> tuple[dict[str, float], float]:
        """Motor current from speed and position of the load; none where nothing is to be followed."""
        if self.path is None:
            return {self.output: 0.0}, memory
        goal = self.path.at(time)
        error = goal.speed + self.link_gain * (goal.position - measured["l"]) - measured["ldot"]
        current, integral = self.speed.act(error, 0.0, memory, self.sample_time)
        return {self.output: current}, integral
