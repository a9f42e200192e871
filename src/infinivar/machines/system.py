r"""Equations of motion of a machine: a mechanism of contacts with inertia, power motors, steering servos and a user.

With the rates :math:`\nu` of the mechanism's coordinates, its inertia M and the forces Q of contacts, guideways, motor and user,

.. math:: M(c)\,\dot\nu + h(c, \nu) = Q, \qquad \frac{d}{dt}\left(\tfrac12\nu^T M \nu + U(c)\right) = Q \cdot \nu

where h holds centrifugal and gyroscopic forces and weights, whose energy is U. The state is the configuration c, the rates, and
the angles and rates of the steered wheels. All functions take rows of states, as `infinivar._core.collocation` asks for several
at a time.

Source: faulring2006, Fig 11 and Fig 12, for the motors; Newton and Euler.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol

import numpy as np

from infinivar._core.collocation import Balance, Rates
from infinivar.errors import ParameterError
from infinivar.limits import Limit
from infinivar.machines.hand import Grasp, Grip, Hand, at_times, without_point
from infinivar.machines.motors import (
    POWER_LOSSES,
    STEERING_LOSSES,
    LinkMotors,
    PowerMotor,
    Powers,
    Shaft,
    SteeringServo,
)
from infinivar.motion.histories import VectorHistory
from infinivar.parts.motor import Motor

Angles = Callable[[float], Any]
"""Steering angles by time, where no servo sets them. [s] to (s,) [rad]"""

SteeringLaw = Callable[[float, np.ndarray, np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]
"""Steering angles and rates by the time at which they act, configuration, rates and present angles."""

_STEP = 1e-6
"""Half the time over which prescribed angles are differenced. [s]"""


class Place(NamedTuple):
    """Where a mechanism stands, and what follows from it; m rows, N coordinates."""

    changes: np.ndarray
    """Time derivative of the configuration. (m, c)"""
    inertia: np.ndarray
    """M. (m, N, N), or (1, N, N) where it is constant"""
    bias: np.ndarray
    """h. (m, N)"""
    kinematics: Any
    """What `Mechanics.act` needs."""
    potential: Any = 0.0
    """Energy of weights, nowhere negative. (m,) [J]"""


class Forces(NamedTuple):
    """Forces of contacts and guideways at m rows; s steered axes, k demands."""

    generalised: np.ndarray
    """On the coordinates. (m, N)"""
    resisting: np.ndarray
    """Moments of the contacts against steering. (m, s) [N m]"""
    losses: Callable[[], Mapping[str, np.ndarray]]
    """Computes (m,) each. [W]"""
    demand: Callable[[], np.ndarray]
    """Computes demand over allowance. (m, k) [-]"""


class Mechanics(Protocol):
    """A mechanism of contacts with its inertia."""

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the rates; the wrench on the load is that of the first ones."""
        ...

    @property
    def configuration(self) -> tuple[str, ...]:
        """Names of the configuration."""
        ...

    @property
    def steered(self) -> tuple[str, ...]:
        """Names of the axes that steer."""
        ...

    @property
    def demands(self) -> tuple[tuple[Limit, str], ...]:
        """Limit and part of each demand."""
        ...

    @property
    def losses(self) -> tuple[str, ...]:
        """Names of the losses."""
        ...

    def at(self, configuration: np.ndarray, rates: np.ndarray) -> Place:
        """Inertia and kinematics."""
        ...

    def act(self, place: Place, rates: np.ndarray, angles: np.ndarray, turning: np.ndarray) -> Forces:
        """Forces of contacts and guideways."""
        ...

    def rates_of(self, configuration: np.ndarray, change: np.ndarray) -> np.ndarray:
        """Rates that the configuration determines, from its time derivative. (c,) each"""
        ...

    def start(self, motion: VectorHistory) -> tuple[np.ndarray, np.ndarray]:
        """Configuration (c,) and rates (N,) with which a machine that follows a motion starts."""
        ...

    def grip(self, handle: Sequence[float] = (0.0, 0.0)) -> Grip:
        """The handle, of a body in the plane at a point of it. [m]

        Raises
        ------
        ParameterError
            If the machine has none.
        """
        ...

    def held_at(self, configuration: np.ndarray, position: np.ndarray) -> np.ndarray:
        """Point of a body in the plane, in its axes, that is at a position; of others 0. (2,) [m]"""
        ...

    def outline(self) -> Any:
        """What is drawn of it, one of the outlines of `infinivar.machines.pictures`; None if it is not drawn in motion."""
        ...

    def stuck(self, configuration: np.ndarray, rates: np.ndarray) -> str:
        """Why the machine cannot move on from rows of its states, or nothing."""
        ...


class Defaults:
    """What a `Mechanics` says unless its kind knows better."""

    __slots__ = ()

    def rates_of(self, configuration: np.ndarray, change: np.ndarray) -> np.ndarray:
        """The time derivative itself."""
        return change

    def start(self: Any, motion: VectorHistory) -> tuple[np.ndarray, np.ndarray]:
        """At rest."""
        return motion(0.0), np.zeros(len(self.coordinates))

    def grip(self, handle: Sequence[float] = (0.0, 0.0)) -> Grip:
        """None."""
        without_point(handle)
        raise ParameterError(
            "machine must have a handle: a planar cobot, platform, arm or slide; shafts of a sphere have none"
        )

    def held_at(self, configuration: np.ndarray, position: np.ndarray) -> np.ndarray:
        """Nowhere else."""
        return np.zeros(2)

    def outline(self) -> Any:
        """Not drawn."""
        return None

    def stuck(self, configuration: np.ndarray, rates: np.ndarray) -> str:
        """Nothing."""
        return ""


@dataclass(slots=True)
class Inputs:
    """What acts on a machine until the next sample."""

    currents: np.ndarray = field(default_factory=lambda: np.zeros(0))
    """Of the power motors. (k,) [A]"""
    steering: np.ndarray = field(default_factory=lambda: np.zeros(0))
    """Currents of the servos. (s,) [A]"""
    turning: np.ndarray = field(default_factory=lambda: np.zeros(0))
    """Rates of steered axes that turn as commanded. (s,) [rad s^-1]"""
    links: np.ndarray = field(default_factory=lambda: np.zeros(()))
    """Currents of the motors of links, (n,) or one for all. [A]"""

    def __iter__(self) -> Iterator[np.ndarray]:
        """The arrays in order."""
        return iter((self.currents, self.steering, self.turning, self.links))

    def copy(self) -> Inputs:
        """The same, with arrays of its own."""
        return Inputs(*(one.copy() for one in self))


class Outside(NamedTuple):
    """What acts on a machine from outside at m rows of time, where there is any."""

    pushed: np.ndarray | None = None
    """What a user or load without a hand exerts on the coordinates. (m, N)"""
    force: np.ndarray | None = None
    """On the handle, beside that of an arm. (m, d) [N]"""
    intended: np.ndarray | None = None
    """Where an arm wants the handle to be. (m, d) [m]"""
    intending: np.ndarray | None = None
    """Its rate. (m, d) [m s^-1]"""
    angles: np.ndarray | None = None
    """Prescribed steering. (m, s) [rad]"""
    turning: np.ndarray | None = None
    """Its rate. (m, s) [rad s^-1]"""

    def row(self, place: int) -> Outside:
        """One row of it."""
        return Outside(*(None if one is None else one[place : place + 1] for one in self))


class _Acting(NamedTuple):
    """What acts on a machine at m rows, from which powers and energies follow."""

    rates: np.ndarray
    """(m, N)"""
    turning: np.ndarray
    """Of the steered axes."""
    inertia: np.ndarray
    """With those of motors and arm."""
    potential: Any
    """Energy of weights. (m,) [J]"""
    forces: Forces
    pushed: np.ndarray | None
    """What a user without a hand exerts. (m, N)"""
    grasp: Grasp | None
    electric: list[Powers]
    """Of motors and servos."""
    gearing: np.ndarray | None
    """Loss of gearheads that depends on the load. (m,) [W]"""


@dataclass(frozen=True, slots=True, kw_only=True)
class System:
    """A machine: mechanics with optional power motors and steering by servos or as prescribed, or with motors of links; and a
    user at the handle."""

    mechanics: Mechanics
    motor: PowerMotor | None = None
    links: LinkMotors | None = None
    servo: SteeringServo | None = None
    angles: Angles | None = None
    """Steering angles over time, without servo."""
    prescribed_steering: bool = False
    """Whether, without servo, the angles are states that turn at the rates of the inputs."""
    wrench: Callable[[float], np.ndarray] | None = None
    """Of the first coordinates on the load, by time. None: none."""
    hand: Hand | None = None
    """The user at the handle."""
    watch: Callable[[np.ndarray], np.ndarray] | None = None
    """Further demands by the position of the handle, (m, k) to (m, w). Needs a hand."""
    sources: tuple[str, ...] = field(init=False, default=())
    losses: tuple[str, ...] = field(init=False, default=())
    places: tuple[int, int, int] = field(init=False, default=(0, 0, 0))
    """Ends of configuration, rates and steering angles in a state."""

    def __post_init__(self) -> None:
        """Name the powers, in the order of `rates`, and count the states."""
        losses = list(self.mechanics.losses)
        sources = ["user"]
        if self.motor is not None:
            sources.append("supply")
            losses += POWER_LOSSES
        if self.links is not None:
            sources.append("supply")
            losses += self.links.losses
        elif self.servo is None:
            sources.append("steering")
        else:
            sources.append("steering supply")
            losses += [f"steering {name}" for name in STEERING_LOSSES]
        if self.hand is not None and self.hand.arm is not None:
            losses.append("arm")
        object.__setattr__(self, "sources", tuple(sources))
        object.__setattr__(self, "losses", tuple(losses))
        first = len(self.mechanics.configuration)
        second = first + len(self.mechanics.coordinates)
        steers = self.servo is not None or self.prescribed_steering
        object.__setattr__(self, "places", (first, second, second + (len(self.mechanics.steered) if steers else 0)))

    @property
    def balance(self) -> np.ndarray:
        """Signs of sources and losses in the balance of energies."""
        return np.array([1.0] * len(self.sources) + [-1.0] * len(self.losses))

    @property
    def storages(self) -> tuple[str, ...]:
        """Names of the columns of `energies`."""
        return ("machine", "motor", "steering") if self.hand is None else ("machine", "motor", "steering", "arm")

    def idle(self) -> Inputs:
        """No currents, and wheels that do not turn."""
        steered = len(self.mechanics.steered)
        motors = 0 if self.motor is None else len(self.motor.coordinates)
        links = np.zeros(()) if self.links is None else np.zeros(self.mechanics.count)  # type: ignore[attr-defined]
        return Inputs(np.zeros(motors), np.zeros(steered), np.zeros(steered), links)

    def begun(self, configuration: np.ndarray, rates: np.ndarray) -> np.ndarray:
        """State of a configuration and rates, with wheels straight ahead that do not turn."""
        steered = np.zeros(len(self.mechanics.steered))
        steers = self.servo is not None or self.prescribed_steering
        return np.concatenate([configuration, rates, *[steered] * steers, *[steered] * (self.servo is not None)])

    @property
    def motors(self) -> tuple[str, ...]:
        """Names of the power motors, or of those of links."""
        if self.links is not None:
            return tuple(f"motor_{place + 1}" for place in range(self.mechanics.count))  # type: ignore[attr-defined]
        if self.motor is None or len(self.motor.coordinates) == 1:
            return () if self.motor is None else ("motor",)
        return tuple(f"motor_{place + 1}" for place in range(len(self.motor.coordinates)))

    def shafts(self, inputs: Inputs, state: np.ndarray, turning: np.ndarray) -> list[Shaft]:
        """Motors and servos at rows of states, by inputs with currents (m, k) or (k,), and rates of steering (m, s)."""
        first, second, _ = self.places
        rates, found = state[:, first:second], []
        known: list[tuple[Sequence[str], Sequence[str], Motor, Any, Any, float]] = []
        parts = [one.replace("_", " ") for one in self.motors]
        if self.motor is not None:
            speeds = self.motor.reduction * rates[:, list(self.motor.coordinates)]
            known.append((self.motors, parts, self.motor.motor, inputs.currents, speeds, self.motor.stick_speed))
        if self.links is not None:
            ratio, motor = self.links.ratio, self.links.drive.motor
            speeds = ratio * self.mechanics.at(state[:, :first], rates).kinematics.speed
            known.append((self.motors, parts, motor, inputs.links, speeds, ratio * self.links.stick_speed))
        if self.servo is not None:
            names = [one.removesuffix("_rad") for one in self.mechanics.steered]
            parts = [f"steering motor {one.partition('_')[2]}".strip() for one in names]
            ratio, motor = self.servo.plant.ratio, self.servo.plant.motor
            known.append((names, parts, motor, inputs.steering, ratio * turning, ratio * self.servo.stick_speed))
        for names, parts, motor, currents, speeds, stick in known:
            for place, (name, part) in enumerate(zip(names, parts, strict=True)):
                speed = speeds[:, place]
                found.append(Shaft(name, part, motor, currents[..., place] + 0.0 * speed, speed, stick))
        return found

    def steering(
        self, outside: Outside, state: np.ndarray, turning: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Angles and rates of the steered axes, (m, s) each; `turning` are the rates of those that turn as commanded. [rad],
        [rad s^-1]"""
        _, second, third = self.places
        if self.servo is not None:
            return state[:, second:third], state[:, third:]
        if self.prescribed_steering:
            angles = state[:, second:third]
            return angles, 0.0 * angles + (0.0 if turning is None else turning)
        if outside.angles is None or outside.turning is None:
            return np.zeros((len(state), len(self.mechanics.steered))), np.zeros(())
        return outside.angles, outside.turning

    def outside(self, time: np.ndarray) -> Outside:
        """What acts from outside at rows of time."""
        steered = self.servo is None and not self.prescribed_steering and self.angles is not None
        hand = self.hand
        intended = (None, None) if hand is None or hand.arm is None else hand.arm.intended(time)
        return Outside(
            pushed=None if self.wrench is None else self.user(time),
            force=None if hand is None else hand.pushed(time),
            intended=intended[0],
            intending=intended[1],
            **(self._prescribed(time) if steered else {}),
        )

    def _prescribed(self, time: np.ndarray) -> dict[str, np.ndarray]:
        """Prescribed angles and their rates."""
        prescribed: Any = self.angles
        now, ahead, behind = (
            at_times(lambda one, off=off: np.asarray(prescribed(one + off), dtype=float), time)
            for off in (0.0, _STEP, -_STEP)
        )
        return {"angles": now, "turning": (ahead - behind) / (2.0 * _STEP)}

    def user(self, time: np.ndarray) -> np.ndarray:
        """What a user or load without a hand exerts on all coordinates: the opposite of the wrench. (m, N)"""
        found = np.zeros((len(time), len(self.mechanics.coordinates)))
        if self.wrench is not None:
            wrench = at_times(self.wrench, time)
            found[:, : wrench.shape[-1]] = -wrench
        return found

    def rates(self, inputs: Inputs, time: np.ndarray, state: np.ndarray) -> Rates:
        """Derivatives of states; powers of sources and losses, stored energy and demands on request."""
        return self.moved(inputs, self.outside(time), state)

    def moved(self, inputs: Inputs, outside: Outside, state: np.ndarray) -> Rates:
        """As `rates`, with what acts from outside."""
        first, second, _ = self.places
        c, nu = state[:, :first], state[:, first:second]
        angles, turning = self.steering(outside, state, inputs.turning)
        place = self.mechanics.at(c, nu)
        forces = self.mechanics.act(place, nu, angles, turning)
        total, inertia = forces.generalised - place.bias, place.inertia
        electric: list[Powers] = []
        grasp, gearing = None, None
        pushed = outside.pushed
        if pushed is not None:
            total = total + pushed
        if self.hand is not None:
            grasp = self.hand.act(outside.force, outside.intended, outside.intending, c, nu)
            total = total + grasp.generalised
            if grasp.inertia is not None:
                inertia = inertia + grasp.inertia
        if self.links is not None:
            link = place.kinematics
            onto, powers = self.links.act(inputs.links, link.speed)
            electric.append(powers)
            total = total + np.matmul(onto[:, None, :], link.jacobian)[:, 0]
        if self.motor is None:
            accelerations = np.linalg.solve(inertia, total[..., None])[..., 0]
        else:
            columns = list(self.motor.coordinates)
            torque, powers = self.motor.act(inputs.currents, nu[:, columns])
            electric.append(powers)
            total[:, columns] += torque
            inertia = inertia.copy()
            inertia[:, columns, columns] += self.motor.inertia
            accelerations, gearing = self._driven(self.motor, inertia, total, torque, nu[:, columns])
        derivative = np.empty_like(state)
        derivative[:, :first], derivative[:, first:second] = place.changes, accelerations
        if self.servo is not None:
            torque, powers = self.servo.act(inputs.steering, turning)
            electric.append(powers)
            count = turning.shape[-1]
            derivative[:, second : second + count] = turning
            derivative[:, second + count :] = (torque - forces.resisting) / self.servo.inertia
        elif self.prescribed_steering:
            derivative[:, second:] = turning

        acting = _Acting(nu, turning, inertia, place.potential, forces, pushed, grasp, electric, gearing)
        return Rates(derivative, functools.partial(self._balance, acting))

    def _balance(self, acting: _Acting) -> Balance:
        """Powers in the order of sources and losses, stored energy, and demands."""
        nu, turning, inertia, potential, forces, pushed, grasp, electric, gearing = acting
        known: dict[str, Any] = dict(forces.losses())
        for one in electric:
            known |= one()
        known["user"] = 0.0 if pushed is None else (pushed * nu).sum(axis=-1)
        stored = 0.5 * (nu * np.matmul(inertia, nu[..., None])[..., 0]).sum(axis=-1) + potential
        demand = forces.demand()
        if grasp is not None:
            held = grasp.powers()
            known["user"], known["arm"] = known["user"] + held.user, held.arm
            stored = stored + held.wound
            if self.watch is not None:
                demand = np.concatenate([demand, self.watch(grasp.position)], axis=-1)
        if gearing is not None:
            known["gearhead"] = known["gearhead"] + gearing
        if self.servo is None:
            known["steering"] = (forces.resisting * turning).sum(axis=-1)
        else:
            stored = stored + 0.5 * self.servo.inertia * (turning * turning).sum(axis=-1)
        passed = np.zeros_like(nu, shape=(len(nu), len(self.sources) + len(self.losses)))
        for column, name in enumerate((*self.sources, *self.losses)):
            if name in known:
                passed[:, column] = known[name]
        return Balance(passed, stored, demand)

    @staticmethod
    def _driven(
        motor: PowerMotor, inertia: np.ndarray, total: np.ndarray, torque: np.ndarray, speeds: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray | None]:
        """Accelerations with motors, and the loss of gearheads that depends on the load, (m,), where it does."""
        if not motor.loaded:
            return np.linalg.solve(inertia, total[..., None])[..., 0], None
        columns = list(motor.coordinates)
        sides = np.zeros_like(total, shape=(*total.shape, 1 + len(columns)))
        sides[:, :, 0] = total
        sides[:, columns, range(1, 1 + len(columns))] = 1.0
        found = np.linalg.solve(inertia, sides)
        free, unit = found[:, :, 0], found[:, :, 1:]
        own = np.diagonal(unit[:, columns, :], axis1=-2, axis2=-1)
        shaft = motor.reduction * speeds
        friction = motor.load_friction(shaft, torque, free[:, columns], own)
        lost = (friction * shaft).sum(axis=-1)
        return free - np.matmul(unit, (motor.reduction * friction)[..., None])[..., 0], lost

    def energies(self, time: np.ndarray, state: np.ndarray) -> np.ndarray:
        """Energies stored in machine, power motors and steering, and in the arm of a hand; columns as `storages`. [J]"""
        first, second, third = self.places
        c, nu = state[:, :first], state[:, first:second]
        place = self.mechanics.at(c, nu)
        body = 0.5 * np.sum(nu * np.matmul(place.inertia, nu[..., None])[..., 0], axis=-1) + place.potential
        rotor = bells = 0.0 * body
        if self.motor is not None:
            rotor = 0.5 * self.motor.inertia * np.sum(nu[:, list(self.motor.coordinates)] ** 2, axis=-1)
        if self.servo is not None:
            bells = 0.5 * self.servo.inertia * np.sum(state[:, third:] ** 2, axis=-1)
        columns = [body, rotor, bells]
        if self.hand is not None:
            columns.append(self.hand.energy(time, c, nu))
        return np.stack(columns, axis=-1)
