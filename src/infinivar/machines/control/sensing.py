"""Sensors of a sampled controller: encoders, speeds by differences, and a force sensor; and the controller behind them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from infinivar.machines.compiled import Motion, derivative_of
from infinivar.machines.control.controller import Law, Measured, checked
from infinivar.machines.control.loops import Commands, Loops
from infinivar.machines.control.sampling import Sensing
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
    derivative: Callable[[Inputs, float, np.ndarray], np.ndarray] = field(init=False)
    steps: np.ndarray = field(init=False)
    """Resolution of each component of the configuration. (c,)"""
    stepped: bool = field(init=False)
    """Whether one of them is not exact."""
    read: np.ndarray | None = field(init=False, default=None)
    turned: np.ndarray | None = field(init=False, default=None)
    filters: dict[str, _Filter] = field(init=False, default_factory=dict)
    noise: np.random.Generator = field(init=False)

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
        self.noise = np.random.default_rng(sensing.seed)

    def measure(self, time: float, state: np.ndarray, inputs: Inputs) -> Measured:
        """Readings at a sample; the true inputs determine the accelerations that a force sensor feels."""
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
        return Measured(
            time=time,
            configuration=position,
            rates=speeds,
            position=held.position[0],
            velocity=held.jacobian[0] @ speeds,
            force=self._force(time, state, c, nu, inputs),
            steering=heading,
            steering_rate=turning,
        )

    def _force(self, time: float, state: np.ndarray, c: np.ndarray, nu: np.ndarray, inputs: Inputs) -> np.ndarray:
        hand = self.system.hand
        assert hand is not None
        now, first = np.array([time]), len(c)
        acceleration = np.zeros((1, len(nu)))
        if hand.arm is not None:
            acceleration = self.derivative(inputs, time, state)[None, first : first + len(nu)]
        force = hand.felt(now, c[None], nu[None], acceleration)[0]
        if self.sensing.force_noise > 0.0:
            force = force + self.sensing.force_noise * self.noise.standard_normal(len(force))
        return self.filters["force"].act(force)


@dataclass(slots=True)
class GuidedController:
    """A controller behind its sensors, and the current loops that follow its commands."""

    loops: Loops
    sensors: Sensors
    law: Law
    acting: Inputs | None = None
    first: tuple[Measured, Commands] | None = None

    @property
    def saturated(self) -> Mapping[str, float]:
        """As of `Loops`."""
        return self.loops.saturated

    def start(self, state: np.ndarray) -> Commands:
        """Commands of the first sample, which act at once."""
        self.acting = self.loops.system.idle()
        measured = self.sensors.measure(0.0, state, self.acting)
        self.first = measured, self._commanded(measured)
        return self.first[1]

    def sample(self, time: float, state: np.ndarray) -> Inputs:
        """Inputs until the next sample, as of `Loops`."""
        system = self.loops.system
        if self.first is not None:
            measured, commands = self.first
            measured = self._begun(measured, state)
            self.first = None
        else:
            measured = self.sensors.measure(time, state, self.acting or system.idle())
            commands = self._commanded(measured)
        speeds = np.zeros(0) if system.motor is None else measured.rates[list(system.motor.coordinates)]
        self.acting = self.loops.act(commands, speeds, self._ahead(measured), measured.steering_rate)
        return self.acting

    def _commanded(self, measured: Measured) -> Commands:
        system = self.loops.system
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
    return np.where(steps > 0.0, whole * np.round(values / whole), values)
