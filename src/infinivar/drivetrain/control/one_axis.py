"""Sampled controllers of one axis, with limited current, as in a real machine.

The bandwidth of a loop places its poles. Inertias and torque constants then determine the gains of the cylinder's speed loop
and of the steering position loop, so a study gives one number per loop. Integral action against Coulomb friction causes a
limit cycle: the integral builds up until the part breaks away, and overshoots. Therefore the loops that move the load feed
the known friction forward. Where the motion stands still, they leave the load at rest once it is within the permitted error,
and friction holds what it can.

The controllers are formulas of a goal, of what is measured and of their memory: numbers all of them, so that the same source
computes with floats and is recorded as C.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from infinivar.bondgraph.scalars import arc_tangent, choose, share_of, signed, within
from infinivar.bondgraph.tape import Number
from infinivar.drivetrain.control.loops import Loop, Servo, turning_speed
from infinivar.motion.motion import Motion, states_over


class Goal(NamedTuple):
    """What a controller is to follow at one of its samples."""

    time: Number
    """[s]"""
    position: Number = 0.0
    speed: Number = 0.0
    acceleration: Number = 0.0
    load: Number = 0.0
    """Current for the planned force at the drive's output. [A]"""


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

    def near(self, rests: Any, goal: Any, position: Number) -> Any:
        """Whether to stop the load at its position; `rests` is whether it has been left at rest so far."""
        room = choose(rests, lambda: 2.0, lambda: 1.0)
        stays = (abs(goal.speed) <= self.sliding) & (abs(goal.acceleration) <= self.starting)
        return stays & (abs(goal.position - position) <= room * self.error)

    def still(self, rests: Any, speed: Number) -> Any:
        """Whether its speed is negligible."""
        return abs(speed) <= choose(rests, lambda: self.sliding, lambda: self.slow)


class _Sampled:
    """What controllers share: `goal`, `control` and `outputs` make the `sample` of a run in Python."""

    __slots__ = ()

    goal: ClassVar[type[Goal]] = Goal
    outputs: tuple[str, ...]
    control: Callable[..., tuple[tuple[Number, ...], tuple[Number, ...]]]
    goals: Callable[[Any], np.ndarray]

    def sample(
        self, time: float, measured: Mapping[str, float], memory: Sequence[float]
    ) -> tuple[dict[str, float], tuple[float, ...]]:
        """Motor currents and new memory."""
        (goal,) = self.goals([time]).tolist()
        currents, memory = self.control(Goal(*goal), measured, memory)
        return dict(zip(self.outputs, currents, strict=True)), memory


@dataclass(frozen=True, slots=True, kw_only=True)
class CoboticController(_Sampled):
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
    outputs: tuple[str, ...]

    def start(self, measured: Mapping[str, float]) -> tuple[float, ...]:
        """Integral of the cylinder loop, and whether the link is left at rest, 0 or 1."""
        return self.started["cylinder"], 0.0

    def goals(self, times: Any) -> np.ndarray:
        """A row of a `Goal` for each time."""
        return _goals(self.path, times)

    def control(
        self, goal: Goal, measured: Mapping[str, Number], memory: Sequence[Number]
    ) -> tuple[tuple[Number, ...], tuple[Number, ...]]:
        """Motor currents from cylinder speed, steering angle and rate, link position and speed; and the new memory."""
        integral, resting = memory
        share = 1.0
        if self.run_up_time > 0.0:
            share = choose(goal.time < self.run_up_time, lambda: goal.time / self.run_up_time, lambda: 1.0)
        cylinder, integral = self.cylinder.act(
            share * self.cylinder_speed - measured["omega"], integral, self.sample_time
        )
        demanded, turning, rests = self.steer(goal, measured, resting > 0.5)
        error = demanded - measured["phi"]
        steering = choose(rests > 0.5, lambda: 0.0, lambda: self.steering.act(error, measured["phi_rate"], turning))
        return (cylinder, steering), (integral, rests)

    def steer(self, goal: Goal, measured: Mapping[str, Number], rests: Any) -> tuple[Number, Number, Number]:
        """Commanded steering angle [rad] and rate [rad s^-1], and whether link and wheel are left at rest, 0 or 1."""
        if self.held_angle is not None:
            return self.held_angle, 0.0, 0.0
        surface = self._surface(measured["omega"])

        def stand() -> tuple[Number, Number, Number]:
            # The angle at which the link stands still, including creep, differs by the angle of the remaining link speed.
            standing = measured["phi"] + arc_tangent(measured["ldot"] / surface)
            left = choose(self.standstill.still(rests, measured["ldot"]), lambda: 1.0, lambda: 0.0)
            return standing, 0.0, left

        def move() -> tuple[Number, Number, Number]:
            slope = -(goal.speed + self.link_gain * (goal.position - measured["l"])) / surface
            change = -(goal.acceleration + self.link_gain * (goal.speed - measured["ldot"])) / surface
            angle, largest = arc_tangent(slope), self.largest_angle
            rate = choose(abs(angle) > largest, lambda: 0.0, lambda: change / (1.0 + slope * slope))
            return within(angle, largest), rate, 0.0

        return choose(self.standstill.near(rests, goal, measured["l"]), stand, move)

    def _surface(self, cylinder_speed: Number) -> Number:
        """Surface speed of the cylinder, where it turns. [m s^-1]"""
        return self.surface_radius * turning_speed(cylinder_speed, self.cylinder_speed)


class Encoder(NamedTuple):
    """Where a controller measures the load: signals, travel of the load per unit of them, and their zero."""

    position: str = "l"
    speed: str = "ldot"
    scale: float = 1.0
    zero: float = 0.0

    def read(self, measured: Mapping[str, Number]) -> tuple[Number, Number]:
        """Position and speed of the load as measured. [m], [m s^-1]"""
        return self.zero + self.scale * measured[self.position], self.scale * measured[self.speed]


@dataclass(frozen=True, slots=True, kw_only=True)
class ConventionalController(_Sampled):
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
    gear_friction: Callable[[Number, Number], tuple[Number, Number]]
    """Maps the current for the torque behind the gear [A] and the demanded speed [m s^-1] to the current for friction [A] that
    depends on both, and its slope over the first. [-]"""
    full_speed: float
    path: Motion | None
    standstill: Standstill
    holding: Callable[[Number], Number]
    """Maps the holding current without friction to the holding current with it. [A]"""
    encoder: Encoder
    started: float
    outputs: tuple[str, ...]
    planned: Callable[[float], float] | None
    """Maps time to the current for the planned force at the drive's output, if there is one. [A]"""

    def start(self, measured: Mapping[str, float]) -> tuple[float, ...]:
        """Integral of the speed loop, whether the load is left at rest, 0 or 1, and the current that then holds it."""
        return self.started, 0.0, 0.0

    def goals(self, times: Any) -> np.ndarray:
        """A row of a `Goal` for each time."""
        return _goals(self.path, times, self.planned)

    def control(
        self, goal: Goal, measured: Mapping[str, Number], memory: Sequence[Number]
    ) -> tuple[tuple[Number, ...], tuple[Number, ...]]:
        """Motor current from speed and position of the load, zero without a motion to follow; and the new memory."""
        integral, resting, held = memory
        if self.path is None:
            return (0.0,), (integral, resting, held)
        position, speed = self.encoder.read(measured)
        rests = resting > 0.5
        near = self.standstill.near(rests, goal, position)

        def hold() -> tuple[Number, ...]:
            current = choose(rests, lambda: held, lambda: self.holding(integral + goal.load) - goal.load)
            return within(current + goal.load, self.speed.limit), integral, 1.0, current

        def move() -> tuple[Number, ...]:
            return *self._move(goal, near, position, speed, integral), 0.0, 0.0

        current, *kept = choose(near & self.standstill.still(rests, speed), hold, move)
        return (current,), tuple(kept)

    def _move(self, goal: Goal, near: Any, position: Number, speed: Number, integral: Number) -> tuple[Number, Number]:
        """Motor current, and the new integral."""
        demanded = choose(near, lambda: 0.0, lambda: goal.speed + self.link_gain * (goal.position - position))
        # The current lasts for a sample, in whose middle a motion that starts or reverses may have another direction.
        ahead = choose(near, lambda: 0.0, lambda: 0.5 * self.sample_time * goal.acceleration)
        share = share_of(demanded + ahead, self.full_speed)

        known = self.inertia * goal.acceleration + goal.load
        # What the gear passes on, friction behind it included: a load that friction still brakes does not drive the motor.
        effort = integral + known + self.friction * share
        way = signed(share, share * effort)
        passed = 0.5 * (self.driving + self.driven) + 0.5 * way * (self.driving - self.driven)
        lost, slope = self.gear_friction(passed * effort, demanded)
        return self.speed.act(
            demanded - speed,
            integral,
            self._learnt(passed * (1.0 + share * slope), effort, share * (demanded - speed)) * self.sample_time,
            lambda grown: (
                passed * (grown + known + self.friction * share)
                + self.rotor * goal.acceleration
                + (self.motor_friction + lost) * share
            ),
        )

    def _learnt(self, passed: Number, effort: Number, short: Number) -> Number:
        """Share of the time over which the integral grows.

        `passed` is the motor's current per `effort`, the current for the load without losses; `short` is how much too slow it
        moves in the commanded direction. While a self-locking gear holds the load, the motor feels little of it. A
        self-locking screw must be driven either way, so that its current suits two loads: one that helps, and a smaller one
        that resists. The integral would settle at the helping one, far too large. It therefore rests there, and yields only if
        the load is so slow that another current than that for a helping load acts.
        """

        def locked() -> Number:
            slow = self.speed.proportional * short > abs(passed * effort)
            return choose(slow, lambda: -within(passed, 1.0), lambda: 0.0)

        return choose(passed < 0.0, locked, lambda: within(passed, 1.0))


def _goals(path: Motion | None, times: Any, planned: Callable[[float], float] | None = None) -> np.ndarray:
    """Rows of goals: at rest without a path. (n, 5)"""
    found = np.zeros((len(times), len(Goal._fields)))
    found[:, 0] = times
    if path is not None:
        found[:, 1:4] = states_over(path, times)
    if planned is not None:
        found[:, 4] = [planned(time) for time in found[:, 0].tolist()]
    return found
