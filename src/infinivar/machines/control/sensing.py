"""Sensors of a sampled controller: encoders, speeds by differences, and a force sensor; and the controller behind them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from infinivar.bondgraph.recorded import Recorded
from infinivar.machines.compiled import Motion, derivative_of
from infinivar.machines.control.controller import Law, Measured, checked
from infinivar.machines.control.loops import Commands, Loops
from infinivar.machines.control.sampling import Sensing
from infinivar.machines.sampled import Known
from infinivar.machines.system import Inputs, Outside, System


@dataclass(slots=True)
class _Filter:
    """First-order low-pass, exact for an input held between samples; begins at its first input."""

    share: float
    value: np.ndarray | None = None

    @classmethod
    def of(cls, cut_off: float | None, period: float) -> _Filter:
        return cls(1.0 if cut_off is None else -math.expm1(-2.0 * math.pi * cut_off * period))

    def act(self, value: np.ndarray) -> np.ndarray:
        self.value = value if self.value is None else self.value + self.share * (value - self.value)
        return self.value


@dataclass(slots=True)
class Sensors:
    """Sensors in a session, with their memory."""

    sensing: Sensing
    system: System
    motion: Motion | None = None
    """Of the system, where it is compiled."""
    derivative: Callable[[Inputs, Outside, np.ndarray], np.ndarray] = field(init=False)
    steps: np.ndarray = field(init=False)
    """Resolution of each component of the configuration. (c,)"""
    stepped: bool = field(init=False)
    """Whether one of them is not exact."""
    read: np.ndarray | None = field(init=False, default=None)
    turned: np.ndarray | None = field(init=False, default=None)
    filters: dict[str, _Filter] = field(init=False, default_factory=dict)
    noise: np.random.Generator = field(init=False)
    drawn: np.ndarray = field(init=False)
    """Noise of samples ahead. (k, d) [N]"""

    def __post_init__(self) -> None:
        """Begin without memory."""
        sensing = self.sensing
        self.derivative = derivative_of(self.system, self.motion)
        names = self.system.mechanics.configuration
        self.steps = np.array(
            [sensing.position_resolution if name.endswith("_m") else sensing.angle_resolution for name in names]
        )
        self.stepped = bool(np.any(self.steps > 0.0))
        for name, cut_off in (
            ("speed", sensing.speed_filter),
            ("steering", sensing.speed_filter),
            ("force", sensing.force_filter),
        ):
            self.filters[name] = _Filter.of(cut_off, sensing.period)
        hand = self.system.hand
        axes = 0 if hand is None or not sensing.force_noise > 0.0 else len(hand.grip.axes)
        self.noise, self.drawn = np.random.default_rng(sensing.seed), np.zeros((0, axes))

    @property
    def memory(self) -> list[np.ndarray]:
        """Arrays that a sample changes: what was read, and filters."""
        assert self.read is not None
        assert self.turned is not None
        return [self.read, self.turned, *(one.value for one in self.filters.values() if one.value is not None)]

    @memory.setter
    def memory(self, kept: Sequence[np.ndarray]) -> None:
        self.read, self.turned = kept[:2]
        for one, value in zip(self.filters.values(), kept[2:], strict=True):
            one.value = value

    def noise_ahead(self, samples: int) -> np.ndarray:
        """Noise of the force at the next samples. (samples, d) [N]"""
        missing = samples - len(self.drawn)
        if missing > 0:
            fresh = self.sensing.force_noise * self.noise.standard_normal((missing, self.drawn.shape[1]))
            self.drawn = np.concatenate([self.drawn, fresh])
        return self.drawn[:samples]

    def measure(self, known: Known, state: np.ndarray, acceleration: np.ndarray) -> Measured:
        """Readings at a sample; a force sensor feels the acceleration of the coordinates."""
        system, sensing = self.system, self.sensing
        first, second, _ = system.places
        c, nu = state[:first], state[first:second]
        position = quantised(c, self.steps) if self.stepped else c
        angles, turning = (row[0] for row in system.steering(Outside(), state[None]))
        heading = angles
        if sensing.steering_resolution > 0.0:
            heading = quantised(angles, np.full(len(angles), sensing.steering_resolution))
        speeds = nu
        if sensing.differenced:
            before = position if self.read is None else self.read
            moved = system.mechanics.rates_of(position, (position - before) / sensing.period)
            speeds = nu.copy()
            speeds[: len(moved)] = moved
            turning = (heading - (heading if self.turned is None else self.turned)) / sensing.period
        self.read, self.turned = position, heading
        speeds = self.filters["speed"].act(speeds)
        turning = self.filters["steering"].act(turning)
        assert system.hand is not None
        held = system.hand.grip.at(position[None], speeds[None])
        outside = known.outside
        force = system.hand.felt(
            outside.force, outside.intended, outside.intending, c[None], nu[None], acceleration[None]
        )[0]
        count = len(system.hand.grip.axes)
        if known.more.size:
            force = np.append(force[:count] + known.more[0], force[count:])
        force = self.filters["force"].act(force)
        return Measured(
            time=known.time,
            configuration=position,
            rates=speeds,
            position=held.position[0],
            velocity=held.jacobian[0] @ speeds,
            force=force[:count],
            steering=heading,
            steering_rate=turning,
            moment=force[count:],
        )


@dataclass(slots=True)
class GuidedController:
    """A controller behind its sensors, and the current loops that follow its commands."""

    loops: Loops
    sensors: Sensors
    law: Law
    acting: Inputs | None = None
    first: tuple[Measured, Commands] | None = None

    @property
    def saturated(self) -> dict[str, float]:
        """As of `Loops`."""
        return self.loops.saturated

    def start(self, state: np.ndarray) -> Commands:
        """Commands of the first sample, which act at once."""
        self.acting = self.loops.system.idle()
        known = self._next(0.0)
        measured = self.sensors.measure(known, state, self.acceleration(known, state))
        self.first = measured, self._commanded(measured)
        return self.first[1]

    def sample(self, time: float, state: np.ndarray) -> Inputs:
        """Inputs until the next sample, as of `Loops`."""
        if self.first is None:
            known = self._next(time)
            return self.act(known, state, self.acceleration(known, state))
        measured, commands = self.first
        self.first = None
        return self._acted(self._begun(measured, state), commands)

    def act(self, known: Known, state: np.ndarray, acceleration: np.ndarray) -> Inputs:
        """Inputs by what is known of a sample, and the state there with the acceleration of its rates."""
        measured = self.sensors.measure(known, state, acceleration)
        return self._acted(measured, self._commanded(measured))

    def ahead(self, times: np.ndarray) -> Known:
        """What is known of the next samples: with the noise of the force."""
        return Known(times, self.loops.system.outside(times), self.sensors.noise_ahead(len(times)))

    def past(self, samples: int) -> None:
        """Go on behind some samples."""
        self.sensors.drawn = self.sensors.drawn[samples:]

    def _next(self, time: float) -> Known:
        """What is known of the next sample, which is then past."""
        known = self.ahead(np.array([time]))
        self.past(1)
        return known.row(0)

    @property
    def memory(self) -> list[np.ndarray] | None:
        """Arrays that a sample changes, after the first one; None if the law does not tell its own."""
        own = getattr(self.law, "memory", None)
        if own is None or self.first is not None or self.loops.waiting is None:
            return None
        return [*self.sensors.memory, *self.loops.memory, *own]

    @memory.setter
    def memory(self, kept: Sequence[np.ndarray]) -> None:
        first, second = len(self.sensors.memory), len(self.loops.memory)
        self.sensors.memory, self.loops.memory = kept[:first], kept[first : first + second]
        self.law.memory = kept[first + second :]  # type: ignore[attr-defined]

    def acceleration(self, known: Known, state: np.ndarray) -> np.ndarray:
        """Of the rates, by the inputs that act; not computed where nobody feels it. (N,)"""
        system = self.loops.system
        first, second, _ = system.places
        assert system.hand is not None
        if system.hand.arm is None:
            return np.zeros(second - first)
        return self.sensors.derivative(self.acting or system.idle(), known.outside, state)[first:second]

    def _acted(self, measured: Measured, commands: Commands) -> Inputs:
        system = self.loops.system
        speeds = np.zeros(0) if system.motor is None else measured.rates[list(system.motor.coordinates)]
        self.acting = self.loops.act(commands, speeds, self._ahead(measured), measured.steering_rate)
        return self.acting

    def _commanded(self, measured: Measured) -> Commands:
        system = self.loops.system
        if isinstance(measured.rates, Recorded):
            return self.law(measured)  # what is not finite is found where it is used
        motors = 0 if system.motor is None else len(system.motor.coordinates)
        if system.links is not None:
            motors = system.mechanics.count  # type: ignore[attr-defined]
        return checked(self.law(measured), len(system.mechanics.steered), motors)

    def _ahead(self, measured: Measured) -> np.ndarray:
        """Angles at which the commands meet the wheels: those that turn as commanded know what they do until then."""
        waiting = self.loops.waiting
        if self.loops.servo is None and waiting is not None:
            return measured.steering + self.loops.period * waiting.turning
        return measured.steering

    def _begun(self, measured: Measured, state: np.ndarray) -> Measured:
        """The first measurement with wheels and motors as they begin."""
        first, second, third = self.loops.system.places
        rates, motor = measured.rates.copy(), self.loops.system.motor
        if motor is not None:
            columns = list(motor.coordinates)
            rates[columns] = state[first:second][columns]
        return replace(measured, steering=state[second:third].copy(), rates=rates)


def quantised(values: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """Values to the nearest multiple of a step; a step of 0 leaves them."""
    whole = np.where(steps > 0.0, steps, 1.0)
    return np.where(steps > 0.0, whole * np.floor(values / whole + 0.5), values)
