"""Sampled controllers of machines with many contacts: speed of the power motor, steering servos, and pose.

The pose loop commands the speeds of the links, or the direction of a body in the plane; the wheels' angles follow. What a
controller computes from the measurements of one sample acts from the next sample on.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from infinivar._core.fields import given
from infinivar.bondgraph.scalars import choose
from infinivar.bondgraph.tape import Number
from infinivar.drivetrain.control import LINK_BANDWIDTH, SPEED_BANDWIDTH, CoboticControl, ConventionalControl
from infinivar.drivetrain.control.loops import Loop, Servo, largest_current, speed_loop, turning_speed
from infinivar.machines.control.traction import TractionController
from infinivar.machines.linkage import LinkMotion, Load, SeparateMechanics
from infinivar.machines.motors import LinkMotors
from infinivar.machines.sampled import Known
from infinivar.machines.system import Inputs, SteeringLaw, System
from infinivar.motion.histories import VectorHistory
from infinivar.transmission.planar import PlanarCobot

_STEP = 1e-4
"""Half the time over which commanded angles are differenced. [s]"""


@dataclass(slots=True)
class Commands:
    """What a controller commands, to act from the next sample on; None: nothing.

    Wheels without command keep their angles by friction, and motors without command have no current.
    """

    steering: np.ndarray | None = None
    """Angles of the steered axes at the next sample. (s,) [rad]"""
    steering_rate: np.ndarray | None = None
    """Rates from then on. (s,) [rad s^-1]"""
    speed: Number | None = None
    """Of the coordinates of the power motors. [rad s^-1]"""
    currents: np.ndarray | None = None
    """Of the power motors, where it replaces `speed`, or of the motors of links. (k,) [A]"""


@dataclass(slots=True)
class Loops:
    """Current loops of a machine, with their memory: speed of the power motors, and steering servos."""

    system: System
    period: float
    motor: Loop | None
    """None: the power motors are without current."""
    servo: Servo | None
    integrals: np.ndarray
    """Of the speed loop of each power motor. (k,) [A]"""
    saturated: dict[str, float] = field(default_factory=dict)
    """Commanded over largest current of the last sample, by motor."""
    waiting: Inputs | None = None
    """Inputs of the last sample, which act from the next one on."""

    @property
    def memory(self) -> list[np.ndarray]:
        """Arrays that a sample changes: integrals, and inputs that wait."""
        assert self.waiting is not None
        return [self.integrals, *self.waiting]

    @memory.setter
    def memory(self, kept: Sequence[np.ndarray]) -> None:
        self.integrals, self.waiting = kept[0], Inputs(*kept[1:])

    def act(self, commands: Commands, speeds: np.ndarray, angles: np.ndarray, turning: np.ndarray) -> Inputs:
        """Inputs until the next sample: those of the commands at the last one; at the first, those of now.

        From commands, measured speeds of the power motors' coordinates, and steering angles and rates.
        """
        found = self._computed(commands, speeds, angles, turning)
        acting, self.waiting = (found if self.waiting is None else self.waiting), found
        return acting

    def _computed(self, commands: Commands, speeds: np.ndarray, angles: np.ndarray, turning: np.ndarray) -> Inputs:
        inputs = self.system.idle()
        if self.system.links is not None and commands.currents is not None:
            limit = self.system.links.current_limit
            inputs.links = np.clip(commands.currents, -limit, limit)
            self.saturated["motor"] = largest(inputs.links) / limit
        elif self.system.motor is not None and (commands.currents is not None or commands.speed is not None):
            limit = math.inf if self.motor is None else self.motor.limit
            if commands.currents is not None:
                inputs.currents = np.clip(commands.currents, -limit, limit)
            elif self.motor is not None:
                demanded, before = given(commands.speed, 0.0), self.integrals.tolist()
                acted = [
                    self.motor.act(demanded - speed, integral, self.period)
                    for speed, integral in zip(speeds.tolist(), before, strict=True)
                ]
                inputs.currents, self.integrals = np.zeros_like(speeds), np.zeros_like(speeds)
                inputs.currents[:], self.integrals[:] = zip(*acted, strict=True)
            self.saturated["motor"] = largest(inputs.currents) / limit
        if commands.steering is None:
            if commands.steering_rate is not None and self.servo is None:
                inputs.turning = np.array(commands.steering_rate, subok=True)
            return inputs
        rate = np.zeros(len(angles)) if commands.steering_rate is None else commands.steering_rate
        if self.servo is None:
            # A wheel that turns as commanded ends the sample where the command has gone by then.
            inputs.turning = rate + (commands.steering - angles) / self.period
            return inputs
        errors = (commands.steering - angles).tolist()
        inputs.steering = np.zeros_like(angles)
        inputs.steering[:] = [self.servo.act(*one) for one in zip(errors, turning.tolist(), rate.tolist(), strict=True)]
        self.saturated["steering motor"] = largest(inputs.steering) / self.servo.limit
        return inputs


def largest(values: np.ndarray) -> Number:
    """The largest size."""
    return functools.reduce(
        lambda one, other: choose(one > other, lambda: one, lambda: other), map(abs, values.tolist())
    )


@dataclass(slots=True)
class LinkController:
    """Pose loop with an inner speed loop, of all links together; inertia, centrifugal forces and friction are fed forward.

    The inertia of the machine decouples the links, so that every motion has the poles of the bandwidths. The integral, which
    begins with the force of the user at the start, converges to that force.
    """

    motors: LinkMotors
    mechanics: SeparateMechanics
    motion: VectorHistory
    integral: np.ndarray
    """Forces on the coordinates. (d,)"""
    limit: float = field(init=False, default=0.0)
    """Of the current of each motor. [A]"""

    def __post_init__(self) -> None:
        """Compute what does not change."""
        self.limit = self.motors.current_limit

    def act(self, time: float, pose: np.ndarray, rates: np.ndarray, angles: np.ndarray, period: float) -> np.ndarray:
        """Currents of the motors from the measurements of a time; they act for a period from the next sample on. (n,) [A]"""
        control = self.motors.drive.control
        pole = 2.0 * math.pi * given(control.speed_bandwidth, SPEED_BANDWIDTH)
        gain = 2.0 * math.pi * given(control.link_bandwidth, LINK_BANDWIDTH)
        load = self.mechanics.load
        goal, twist = load.along(self.motion, time)
        # In the middle of the sample in which the currents act.
        before, after = around(self.motion, min(time + 1.5 * period, float(self.motion.time[-1])))
        change = (load.along(self.motion, after)[1] - load.along(self.motion, before)[1]) / (after - before)
        demanded = twist + gain * load.apart(pose, goal)
        place = self.mechanics.at(pose[None], rates[None])
        link: LinkMotion = place.kinematics
        inertia, jacobian = place.inertia[0], link.jacobian[0]
        grown = self.integral + pole * pole * period * (inertia @ (demanded - rates))
        forces = inertia @ (change + 2.0 * pole * (demanded - rates)) + place.bias[0] + grown
        share = np.clip(jacobian @ demanded / self.motors.stick_speed, -1.0, 1.0)
        on_links = np.linalg.lstsq(jacobian.T, forces, rcond=None)[0] + sum(self.motors.frictions) * share
        currents = on_links / self.motors.gain
        if np.all(np.abs(currents) <= self.limit):
            self.integral = grown
        return np.clip(currents, -self.limit, self.limit)


@dataclass(slots=True)
class MachineController:
    """Controllers of a machine under a scenario: the shaft of the power motor is held, and wheels follow a law."""

    loops: Loops
    duration: float
    """Of the run; the controller looks no further ahead. [s]"""
    set_speed: float
    steering_law: SteeringLaw | None
    links: LinkController | TractionController | None = None
    """Of a machine with a motor for each link, instead of all others; or of the motors of a cart, beside its steering."""

    acting: Inputs | None = None

    @property
    def saturated(self) -> dict[str, float]:
        """As of `Loops`."""
        return self.loops.saturated

    @property
    def memory(self) -> list[np.ndarray] | None:
        """That of the loops, after the first sample; None where a law does not tell its goals ahead."""
        if self.loops.waiting is None or self.links is not None:
            return None
        plain = self.steering_law is None or self.loops.servo is None or hasattr(self.steering_law, "goals")
        return self.loops.memory if plain else None

    @memory.setter
    def memory(self, kept: Sequence[np.ndarray]) -> None:
        self.loops.memory = kept

    def ahead(self, times: np.ndarray) -> Known:
        """What is known of the next samples: with goals of the steering law."""
        goals, law = np.zeros((len(times), 0)), self.steering_law
        if self.loops.servo is not None and hasattr(law, "goals"):
            goals = law.goals(np.minimum(times + self.loops.period, self.duration))  # type: ignore[union-attr]
        return Known(times, self.loops.system.outside(times), goals)

    def past(self, samples: int) -> None:
        """Nothing that is drawn."""

    def act(self, known: Known, state: np.ndarray, acceleration: np.ndarray) -> Inputs:
        """Inputs until the next sample, as of `Loops`."""
        law: Any = self.steering_law
        return self._acted(state, lambda *now: law.steer(known.more[0], *now))

    def sample(self, time: float, state: np.ndarray) -> Inputs:
        """The same at a time."""
        law: Any = self.steering_law
        ahead = min(time + self.loops.period, self.duration)
        currents = None
        if self.links is not None:
            first, second, third = self.loops.system.places
            measured = state[:first], state[first:second], state[second:third]
            currents = self.links.act(time, *measured, self.loops.period)
        return self._acted(state, lambda *now: law(ahead, *now), currents)

    def _acted(self, state: np.ndarray, steered: Callable[..., Any], currents: np.ndarray | None = None) -> Inputs:
        loops, system = self.loops, self.loops.system
        first, second, third = system.places
        c, nu, angles, turning = state[:first], state[first:second], state[second:third], state[third:]
        speeds = np.zeros(0)
        commands = Commands(currents=currents)
        if loops.motor is not None and system.motor is not None:
            commands.speed, speeds = self.set_speed, nu[list(system.motor.coordinates)]
        if loops.servo is not None and self.steering_law is not None:
            commands.steering, commands.steering_rate = steered(c, nu, angles)
        self.acting = loops.act(commands, speeds, angles, turning)
        return self.acting


def placed_servo(system: System, control: CoboticControl | ConventionalControl) -> Servo | None:
    """Servo of the steered axes. It feeds friction forward as it acts: in full from the stick speed on."""
    if system.servo is None or isinstance(control, ConventionalControl):
        return None
    servo = system.servo
    limit = largest_current(control.steering_current_limit, servo.plant.motor)
    return Servo.place(control.steering_bandwidth, servo.inertia, servo.gain, limit, servo.friction, servo.stick_speed)


def placed_motor(system: System, control: CoboticControl | ConventionalControl, inertia: float) -> Loop | None:
    """Speed loop of each power motor; `inertia` is that of its coordinate without the motor."""
    if system.motor is None:
        return None
    motor = system.motor.motor
    limit = largest_current(control.current_limit, motor)
    if isinstance(control, ConventionalControl):
        bandwidth = given(control.speed_bandwidth, SPEED_BANDWIDTH)
    else:
        bandwidth = control.cylinder_bandwidth
    return speed_loop(bandwidth, inertia + system.motor.inertia, system.motor.gain, limit)


def begun_loops(
    system: System,
    control: CoboticControl | ConventionalControl,
    state: np.ndarray,
    period: float,
    held: bool = True,
) -> Loops:
    """Loops of the motors of a machine, which begin with the currents that keep its speeds.

    Parameters
    ----------
    system : System
    control : CoboticControl or ConventionalControl
    state : (n,) float   At the start.
    period : float       Of the samples. [s]
    held : bool          Whether power motors hold a speed; otherwise they are without loops.
    """
    motor, integrals = None, np.zeros(0)
    if system.motor is not None and held:
        first, second, _ = system.places
        columns = list(system.motor.coordinates)
        place = system.mechanics.at(state[None, :first], state[None, first:second])
        inertia = np.diagonal(place.inertia[0])[columns]
        motor = placed_motor(system, control, float(np.max(inertia)))
        rest = system.rates(system.idle(), np.zeros(1), state[None]).derivative[0, first:second]
        integrals = -(inertia + system.motor.inertia) * rest[columns] / system.motor.gain
    servo = placed_servo(system, control)
    return Loops(system=system, period=period, motor=motor, servo=servo, integrals=integrals)


def following_angles(angles: Callable[[float], Any]) -> SteeringLaw:
    """Angles over time, whatever the machine does."""

    def law(time: float, *_: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        ahead, behind = (np.asarray(angles(one), dtype=float) for one in (time + _STEP, max(time - _STEP, 0.0)))
        return np.asarray(angles(time), dtype=float), (ahead - behind) / (time + _STEP - max(time - _STEP, 0.0))

    return law


def standing(pose: np.ndarray, duration: float) -> VectorHistory:
    """The motion that keeps a pose."""
    return VectorHistory(time=[0.0, duration], values=[pose, pose])


def following_pose(
    load: Load, motion: VectorHistory, *, gain: float, radius: float, set_speed: float, largest: float
) -> SteeringLaw:
    """Angles of wheels on a cylinder that move a load along a motion.

    Parameters
    ----------
    load : Load
    motion : VectorHistory   Of poses.
    gain : float             Of the pose error. [s^-1]
    radius : float           Of the cylinder. [m]
    set_speed : float        Of the cylinder; a nearly stationary one counts as a twentieth of that. [rad s^-1]
    largest : float          Angle to which the wheels can be steered. [rad]
    """
    return _AlongPoses(load, motion, gain, radius, set_speed, largest)


@dataclass(frozen=True, slots=True)
class _AlongPoses:
    """The law of `following_pose`; what depends on the time alone is a goal."""

    load: Load
    motion: VectorHistory
    gain: float
    radius: float
    set_speed: float
    largest: float

    def goals(self, times: np.ndarray) -> np.ndarray:
        """Pose, twist, and accelerations of the links as planned, side by side. (m, k)"""
        ahead = [(time, *around(self.motion, time)) for time in times.tolist()]
        poses, twists = self.load.along(self.motion, *np.ravel(ahead).tolist())
        poses, twists = poses.reshape(len(ahead), 3, -1), twists.reshape(len(ahead), 3, -1)
        before, after = (self.load.at(poses[:, side], twists[:, side]).speed for side in (1, 2))
        spans = np.array([after - before for _, before, after in ahead])
        return np.concatenate([poses[:, 0], twists[:, 0], (after - before) / spans[:, None]], axis=1)

    def steer(
        self, goal: np.ndarray, c: np.ndarray, nu: np.ndarray, angles: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Angles and rates for a goal, as the machine is."""
        own = len(c)
        pose, twist, acceleration = goal[:own], goal[own : own + len(nu) - 1], goal[own + len(nu) - 1 :]
        jacobian = self.load.at(c[None], nu[None, :-1]).jacobian[0]
        surface = self.radius * turning_speed(nu[-1], self.set_speed)
        slope = -(jacobian @ (twist + self.gain * self.load.apart(c, pose))) / surface
        change = -(acceleration + self.gain * (jacobian @ (twist - nu[:-1]))) / surface
        found = np.clip(np.arctan(slope), -self.largest, self.largest)
        return found, np.where(np.abs(found) < self.largest, change / (1.0 + slope * slope), 0.0)

    def __call__(self, time: float, c: np.ndarray, nu: np.ndarray, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """As `SteeringLaw`."""
        return self.steer(self.goals(np.array([time]))[0], c, nu, angles)


def around(motion: VectorHistory, time: float) -> tuple[float, float]:
    """Two instants about a time, both on the same side of the end of a motion."""
    end = float(motion.time[-1])
    after = min(time + _STEP, end) if time <= end else time + _STEP
    return after - 2.0 * _STEP, after


def following_path(cobot: PlanarCobot, motion: VectorHistory, *, gain: float) -> SteeringLaw:
    """Headings of wheels on a plane along a motion of the body, whose speed is the user's."""

    def headings(twist: np.ndarray, angles: np.ndarray) -> np.ndarray:
        found = np.asarray(cobot.headings(twist))
        found = np.where(np.isfinite(found), found, angles)
        return angles + np.remainder(found - angles + 0.5 * np.pi, np.pi) - 0.5 * np.pi

    def law(time: float, c: np.ndarray, nu: np.ndarray, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        def twist(at: float) -> np.ndarray:
            off, rate = motion(at) - c, motion.rate(at)
            cosine, sine = math.cos(c[2]), math.sin(c[2])
            x, y, turning = rate + gain * off
            return np.array([cosine * x + sine * y, cosine * y - sine * x, turning])

        goal, (before, after) = headings(twist(time), angles), around(motion, time)
        return goal, (headings(twist(after), goal) - headings(twist(before), goal)) / (after - before)

    return law
