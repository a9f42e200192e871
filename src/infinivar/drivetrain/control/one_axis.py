"""Sampled controllers of one axis, with limited current, as in a real machine.

The bandwidth of a loop places its poles. Inertias and torque constants then determine the gains of the cylinder's speed loop
and of the steering position loop, so a study gives one number per loop. Integral action against Coulomb friction causes a
limit cycle: the integral builds up until the part breaks away, and overshoots. Therefore the loops that move the load feed
the known friction forward. Where the motion stands still, they leave the load at rest once it is within the permitted error,
and friction holds what it can.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

from infinivar.drivetrain.control.loops import Loop, Servo, share_of, turning_speed
from infinivar.motion.motion import Motion, MotionState


@dataclass(frozen=True, slots=True, kw_only=True)
class Standstill:
    """Conditions under which a load is left at rest: stationary goal, small error, negligible speed. [m], [m s^-1]

    A goal is stationary if it moves no faster than `sliding` now, nor one sample later by its acceleration (`starting`
    [m s^-2]): where a motion starts or reverses, it does not rest. A load at rest remains so until its goal moves, or its
    error doubles, or it slides: friction that holds it still lets it creep slightly.
    """

    error: float
    slow: float
    sliding: float
    starting: float

    def near(self, rests: bool, goal: MotionState, position: float) -> bool:
        """Whether to stop the load at its position; `rests` is whether it has been left at rest so far."""
        room = 2.0 if rests else 1.0
        stays = abs(goal.speed) <= self.sliding and abs(goal.acceleration) <= self.starting
        return stays and abs(goal.position - position) <= room * self.error

    def still(self, rests: bool, speed: float) -> bool:
        """Whether its speed is negligible."""
        return abs(speed) <= (self.sliding if rests else self.slow)


@dataclass(frozen=True, slots=True, kw_only=True)
class CoboticController:
    """Cylinder at constant speed, steering servo, and the link's position loop, which commands steering angles.

    The wheel's direction sets the link speed: ``ldot = -R omega tan(phi)``. The position loop commands the angle for the speed
    of the motion plus a correction proportional to the position error. While the link is left at rest, friction holds the
    wheel at its angle.
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
    path: Motion
    standstill: Standstill
    started: Mapping[str, float]
    outputs: tuple[str, str]

    def start(self, measured: Mapping[str, float]) -> tuple[float, bool]:
        """Integral of the cylinder loop, and whether the link is left at rest."""
        return self.started["cylinder"], False

    def sample(
        self, time: float, measured: Mapping[str, float], memory: tuple[float, bool]
    ) -> tuple[dict[str, float], tuple[float, bool]]:
        """Motor currents from cylinder speed, steering angle and rate, link position and speed."""
        share = 1.0 if self.run_up_time <= 0.0 else min(time / self.run_up_time, 1.0)
        error = share * self.cylinder_speed - measured["omega"]
        cylinder, drive = self.cylinder.act(error, memory[0], self.sample_time)
        demanded, turning, rests = self.steer(self.path.at(time), measured, memory[1])
        steering = 0.0 if rests else self.steering.act(demanded - measured["phi"], measured["phi_rate"], turning)
        return dict(zip(self.outputs, (cylinder, steering), strict=True)), (drive, rests)

    def steer(self, goal: MotionState, measured: Mapping[str, float], rests: bool) -> tuple[float, float, bool]:
        """Commanded steering angle [rad] and rate [rad s^-1], and whether link and wheel are left at rest."""
        if self.held_angle is not None:
            return self.held_angle, 0.0, False
        surface = self._surface(measured["omega"])
        if self.standstill.near(rests, goal, measured["l"]):
            # The angle at which the link stands still, including creep, differs by the angle of the remaining link speed.
            standing = measured["phi"] + math.atan(measured["ldot"] / surface)
            return standing, 0.0, self.standstill.still(rests, measured["ldot"])
        slope = -(goal.speed + self.link_gain * (goal.position - measured["l"])) / surface
        change = -(goal.acceleration + self.link_gain * (goal.speed - measured["ldot"])) / surface
        angle = math.atan(slope)
        if abs(angle) > self.largest_angle:
            return math.copysign(self.largest_angle, angle), 0.0, False
        return angle, change / (1.0 + slope * slope), False

    def _surface(self, cylinder_speed: float) -> float:
        """Surface speed of the cylinder, where it turns. [m s^-1]"""
        return self.surface_radius * turning_speed(cylinder_speed, self.cylinder_speed)


class Encoder(NamedTuple):
    """Where a controller measures the load: signals, travel of the load per unit of them, and their zero."""

    position: str = "l"
    speed: str = "ldot"
    scale: float = 1.0
    zero: float = 0.0

    def read(self, measured: Mapping[str, float]) -> tuple[float, float]:
        """Position and speed of the load as measured. [m], [m s^-1]"""
        return self.zero + self.scale * measured[self.position], self.scale * measured[self.speed]


@dataclass(frozen=True, slots=True, kw_only=True)
class ConventionalController:
    """Position loop of the load with an inner speed loop.

    Inertia and friction of the load (`inertia` [A s^2 m^-1], `friction` [A]) and of the motor (`rotor`, `motor_friction`) are
    fed forward, multiplied by the gear's factors while it drives and while it is backdriven (`driving`, `driven` [-]), and so
    is measured friction of a gear, at the demanded speed and the known load (`gear_friction`). The integral, which begins with
    `started` [A], thus converges to the external force. While the load is left at rest, the motor supplies what friction does
    not hold. Springs and linkages between drive and load make a planned force there (`planned` [A] over time), which is fed
    forward as well; it then includes the inertia of the load and the external force.
    """

    sample_time: float
    speed: Loop
    link_gain: float
    inertia: float
    friction: float
    rotor: float
    motor_friction: float
    driving: float
    driven: float
    gear_friction: Callable[[float, float], tuple[float, float]]
    """Maps the current for the torque behind the gear [A] and the demanded speed [m s^-1] to the current for friction [A] that
    depends on both, and its slope over the first. [-]"""
    full_speed: float
    path: Motion | None
    standstill: Standstill
    holding: Callable[[float], float]
    """Maps the holding current without friction to the holding current with it. [A]"""
    encoder: Encoder
    started: float
    output: str
    planned: Callable[[float], float]
    """Maps time to the current for the planned force at the drive's output. [A]"""

    def start(self, measured: Mapping[str, float]) -> tuple[float, float | None]:
        """Integral of the speed loop, and the current that holds a load left at rest."""
        return self.started, None

    def sample(
        self, time: float, measured: Mapping[str, float], memory: tuple[float, float | None]
    ) -> tuple[dict[str, float], tuple[float, float | None]]:
        """Motor current from speed and position of the load; zero without a motion to follow."""
        if self.path is None:
            return {self.output: 0.0}, memory
        goal = self.path.at(time)
        position, speed = self.encoder.read(measured)
        integral, held = memory
        rests = held is not None
        near = self.standstill.near(rests, goal, position)
        if near and self.standstill.still(rests, speed):
            load = self.planned(time)
            held = self.holding(integral + load) - load if held is None else held
            return {self.output: min(max(held + load, -self.speed.limit), self.speed.limit)}, (integral, held)
        demanded = 0.0 if near else goal.speed + self.link_gain * (goal.position - position)
        # The current lasts for a sample, in whose middle a motion that starts or reverses may have another direction.
        share = share_of(demanded + (0.0 if near else 0.5 * self.sample_time * goal.acceleration), self.full_speed)

        known = self.inertia * goal.acceleration + self.planned(time)
        # What the gear passes on, friction behind it included: a load that friction still brakes does not drive the motor.
        effort = integral + known + self.friction * share
        way = math.copysign(share, share * effort)
        passed = 0.5 * (self.driving + self.driven) + 0.5 * way * (self.driving - self.driven)
        lost, slope = self.gear_friction(passed * effort, demanded)
        current, integral = self.speed.act(
            demanded - speed,
            integral,
            self._learnt(passed * (1.0 + share * slope), effort, share * (demanded - speed)) * self.sample_time,
            lambda grown: (
                passed * (grown + known + self.friction * share)
                + self.rotor * goal.acceleration
                + (self.motor_friction + lost) * share
            ),
        )
        return {self.output: current}, (integral, None)

    def _learnt(self, passed: float, effort: float, short: float) -> float:
        """Share of the time over which the integral grows.

        `passed` is the motor's current per `effort`, the current for the load without losses; `short` is how much too slow it
        moves in the commanded direction. While a self-locking gear holds the load, the motor feels little of it. A
        self-locking screw must be driven either way, so that its current suits two loads: one that helps, and a smaller one
        that resists. The integral would settle at the helping one, far too large. It therefore rests there, and yields only if
        the load is so slow that another current than that for a helping load acts.
        """
        if passed < 0.0:
            return min(-passed, 1.0) if self.speed.proportional * short > abs(passed * effort) else 0.0
        return min(passed, 1.0)
