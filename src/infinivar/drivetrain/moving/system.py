r"""Equations of motion of a machine: a mechanism of contacts with inertia, a power motor, steering servos and a user.

With the rates :math:`\nu` of the mechanism's coordinates, its inertia M and the forces Q of contacts, guideways, motor and user,

.. math:: M(c)\,\dot\nu + h(c, \nu) = Q, \qquad \tfrac12 \frac{d}{dt}\left(\nu^T M \nu\right) = Q \cdot \nu

where h holds centrifugal and gyroscopic forces. The state is the configuration c, the rates, and the angles and rates of the
steered wheels. All functions take rows of states, as `infinivar._core.collocation` asks for several at a time.

Source: faulring2006, Fig 11 and Fig 12, for the motors; Newton and Euler.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np

from infinivar._core.collocation import Rates
from infinivar._core.fields import given
from infinivar.contact.friction import coulomb
from infinivar.drivetrain.drive import needed
from infinivar.drivetrain.steering import SteeringPlant
from infinivar.errors import ParameterError
from infinivar.limits import Limit
from infinivar.parts.amplifier import Amplifier
from infinivar.parts.gearhead import Gearhead, proportional_friction
from infinivar.parts.motor import Motor

if TYPE_CHECKING:
    from infinivar.drivetrain.moving.separate import LinkMotors

Angles = Callable[[float], Any]
"""Steering angles by time, where no servo sets them. [s] to (s,) [rad]"""

_STEP = 1e-6
"""Half the time over which prescribed angles are differenced. [s]"""


class Place(NamedTuple):
    """Where a mechanism stands, and what follows from it; m rows, N coordinates."""

    changes: np.ndarray
    """Time derivative of the configuration. (m, c)"""
    inertia: np.ndarray
    """M. (m, N, N)"""
    bias: np.ndarray
    """h. (m, N)"""
    kinematics: Any
    """What `Mechanics.act` needs."""


class Forces(NamedTuple):
    """Forces of contacts and guideways at m rows; s steered axes, k demands."""

    generalised: np.ndarray
    """On the coordinates. (m, N)"""
    resisting: np.ndarray
    """Moments of the contacts against steering. (m, s) [N m]"""
    losses: Mapping[str, np.ndarray]
    """(m,) each. [W]"""
    demand: np.ndarray
    """Demand over allowance. (m, k) [-]"""


class Mechanics(Protocol):
    """A mechanism of contacts with its inertia."""

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the rates; the user's wrench acts on the first ones."""
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


@dataclass(frozen=True, slots=True, kw_only=True)
class PowerMotor:
    """A motor with gearhead and amplifier on one coordinate of a machine.

    Raises
    ------
    ParameterError
        If the rotor's inertia is missing, or the gearhead has measured friction.
    """

    motor: Motor
    gearhead: Gearhead
    amplifier: Amplifier
    coordinate: int
    stick_speed: float
    """Of the motor shaft. [rad s^-1]"""
    inertia: float = field(init=False, default=0.0)
    """Of rotor and gearhead about the coordinate. [kg m^2]"""
    gear_friction: float = field(init=False, default=0.0)
    """Constant, at the motor. [N m]"""

    def __post_init__(self) -> None:
        """Compute what does not change."""
        rotor = needed(self.motor.rotor_inertia, "motor.rotor_inertia") + given(self.gearhead.inertia, 0.0)
        object.__setattr__(self, "inertia", rotor * self.gearhead.ratio**2)
        friction = 0.0
        if not self.gearhead.lossless:
            if self.gearhead.friction is not None:
                raise ParameterError(
                    f"gearhead.loss_model must be 'coulomb' or 'proportional' in a machine of many contacts that moves, got "
                    f"{self.gearhead.loss_model!r}, whose friction is measured; iv.simulate has it for one leg"
                )
            friction = float(self.gearhead.coulomb_friction(self.motor.continuous_torque))
        object.__setattr__(self, "gear_friction", friction)

    @property
    def gain(self) -> float:
        """Torque on the coordinate per current. [N m A^-1]"""
        return self.gearhead.ratio * self.motor.torque_constant

    @property
    def loaded(self) -> bool:
        """Whether friction of the gearhead depends on the torque that it transmits."""
        return self.gearhead.loss_model == "proportional" and not self.gearhead.lossless

    def load_friction(self, shaft: np.ndarray, torque: np.ndarray, free: np.ndarray, unit: np.ndarray) -> np.ndarray:
        r"""Friction torque at the motor of a gearhead whose loss is proportional to power. (m,) [N m]

        The torque p that it transmits follows from the rotor's balance,

        .. math:: p + F(p)\,(1 - J\,M^{-1}_{cc}) = \frac{\tau - J\,\dot\nu_c}{n}, \qquad F(p) = F(\mathrm{sgn}\,p)\,|p|,

        so that p has the sign of the right-hand side and is explicit.

        Parameters
        ----------
        shaft : (m,) float    Speed of the motor. [rad s^-1]
        torque : (m,) float   tau, on the coordinate without this friction. [N m]
        free : (m,) float     Acceleration of the coordinate without this friction. [rad s^-2]
        unit : (m,) float     Its acceleration by a unit torque. [kg^-1 m^-2]

        Source: Newton; `proportional_friction`.
        """
        balance = (torque - self.inertia * free) / self.gearhead.ratio
        way = np.where(balance < 0.0, -1.0, 1.0)
        forward = given(self.gearhead.efficiency, 1.0)
        back = given(self.gearhead.backdriving_efficiency, forward)
        share = proportional_friction(shaft, way, forward, back, self.stick_speed)
        passed = balance / (1.0 + way * share * (1.0 - self.inertia * unit))
        return share * np.abs(passed)

    def act(self, current: float, speed: np.ndarray) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Torque on the coordinate, and the power that the motor takes ("motor") with its losses, at coordinate speeds; without
        friction that depends on the load."""
        shaft, motor = self.gearhead.ratio * speed, self.motor
        rubbing = coulomb(shaft, motor.friction_torque, self.stick_speed)
        iron = given(motor.viscous_friction, 0.0) * shaft
        gear = coulomb(shaft, self.gear_friction, self.stick_speed)
        torque = self.gearhead.ratio * (motor.torque_constant * current - rubbing - iron - gear)
        winding = motor.resistance * current * current + 0.0 * shaft
        power = winding + motor.torque_constant * shaft * current
        taken, burnt, _ = self.amplifier.supply(power)
        return torque, {
            "supply": taken,
            "winding": winding,
            "motor friction": rubbing * shaft,
            "motor iron": iron * shaft,
            "gearhead": gear * shaft,
            "amplifier": burnt + 0.0 * shaft,
        }


@dataclass(frozen=True, slots=True, kw_only=True)
class SteeringServo:
    """Motor, gear and bell of each steered axis, all alike; friction of bell and, without spin, of the patch.

    Raises
    ------
    ParameterError
        If the rotor's inertia is missing.
    """

    plant: SteeringPlant
    amplifier: Amplifier
    patch_friction: float
    """At the bell. [N m]"""
    bell_friction: float
    stick_speed: float
    """Of the bell. [rad s^-1]"""
    inertia: float = field(init=False, default=0.0)
    """Of bell and rotor about the steering axis. [kg m^2]"""

    def __post_init__(self) -> None:
        """Compute what does not change."""
        rotor = needed(self.plant.motor.rotor_inertia, "steering.motor.rotor_inertia")
        object.__setattr__(self, "inertia", self.plant.bell_inertia + self.plant.ratio**2 * rotor)

    @property
    def gain(self) -> float:
        """Torque at the bell per current. [N m A^-1]"""
        return self.plant.ratio * self.plant.motor.torque_constant

    @property
    def friction(self) -> float:
        """Coulomb friction at the bell: of patch, bell and motor. [N m]"""
        return self.patch_friction + self.bell_friction + self.plant.ratio * self.plant.motor.friction_torque

    def act(self, currents: np.ndarray, turning: np.ndarray) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Torque at each bell but that of its contact, (m, s), and the powers of all together as in `PowerMotor`."""
        motor, ratio = self.plant.motor, self.plant.ratio
        share = coulomb(turning, 1.0, self.stick_speed)
        iron = given(motor.viscous_friction, 0.0) * ratio * ratio * turning
        torque = self.gain * currents - self.friction * share - iron
        winding = np.broadcast_to(motor.resistance * currents * currents, turning.shape)
        taken, burnt, _ = self.amplifier.supply(winding + self.gain * currents * turning)
        slid = np.sum(share * turning, axis=-1)
        return torque, {
            "steering supply": np.sum(taken, axis=-1),
            "steering winding": np.sum(winding, axis=-1),
            "steering motor friction": ratio * motor.friction_torque * slid,
            "steering motor iron": np.sum(iron * turning, axis=-1),
            "steering bearing": self.bell_friction * slid,
            "steering patch": self.patch_friction * slid,
            "steering amplifier": np.sum(burnt + 0.0 * turning, axis=-1),
        }


_MOTOR = ("winding", "motor friction", "motor iron", "gearhead", "amplifier")
_STEERING = ("winding", "motor friction", "motor iron", "bearing", "patch", "amplifier")


@dataclass(slots=True)
class Inputs:
    """What acts on a machine until the next sample."""

    current: float = 0.0
    """Of the power motor. [A]"""
    steering: np.ndarray = field(default_factory=lambda: np.zeros(0))
    """Currents of the servos. (s,) [A]"""
    links: np.ndarray = field(default_factory=lambda: np.zeros(()))
    """Currents of the motors of links, (n,) or one for all. [A]"""


@dataclass(frozen=True, slots=True, kw_only=True)
class System:
    """A machine: mechanics with an optional power motor and steering by servos or as prescribed, or with motors of links."""

    mechanics: Mechanics
    motor: PowerMotor | None = None
    links: LinkMotors | None = None
    servo: SteeringServo | None = None
    angles: Angles | None = None
    """Steering angles over time, without servo."""
    wrench: Callable[[float], np.ndarray] | None = None
    """Of the user, on the first coordinates, by time. None: none."""
    sources: tuple[str, ...] = field(init=False, default=())
    losses: tuple[str, ...] = field(init=False, default=())

    def __post_init__(self) -> None:
        """Name the powers, in the order of `rates`."""
        losses = list(self.mechanics.losses)
        sources = ["user"]
        if self.motor is not None:
            sources.append("supply")
            losses += _MOTOR
        if self.links is not None:
            sources.append("supply")
            losses += self.links.losses
        elif self.servo is None:
            sources.append("steering")
        else:
            sources.append("steering supply")
            losses += [f"steering {name}" for name in _STEERING]
        object.__setattr__(self, "sources", tuple(sources))
        object.__setattr__(self, "losses", tuple(losses))

    @property
    def places(self) -> tuple[int, int, int]:
        """Ends of configuration, rates and steering angles in a state."""
        first = len(self.mechanics.configuration)
        second = first + len(self.mechanics.coordinates)
        return first, second, second + (len(self.mechanics.steered) if self.servo is not None else 0)

    @property
    def balance(self) -> np.ndarray:
        """Signs of sources and losses in the balance of energies."""
        return np.array([1.0] * len(self.sources) + [-1.0] * len(self.losses))

    def steering(self, time: np.ndarray, state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Angles and rates of the steered axes. (m, s) each [rad], [rad s^-1]"""
        _, second, third = self.places
        if self.servo is not None:
            return state[:, second:third], state[:, third:]
        if self.angles is None:
            return np.zeros((len(state), len(self.mechanics.steered))), np.zeros(())
        # Columns of a Jacobian share their instant.
        instants, rows = np.unique(time, return_inverse=True)
        now, ahead, behind = (
            np.array([np.asarray(self.angles(float(one) + off), dtype=float) for one in instants])
            for off in (0.0, _STEP, -_STEP)
        )
        return now[rows], ((ahead - behind) / (2.0 * _STEP))[rows]

    def user(self, time: np.ndarray) -> np.ndarray:
        """Forces of the user on all coordinates. (m, N)"""
        found = np.zeros((len(time), len(self.mechanics.coordinates)))
        if self.wrench is not None:
            known: dict[float, Any] = {}
            for row, one in enumerate(time.tolist()):
                if one not in known:
                    known[one] = self.wrench(one)
                found[row, : len(known[one])] = known[one]
        return found

    def rates(self, inputs: Inputs, time: np.ndarray, state: np.ndarray) -> Rates:
        """Derivatives of states, powers of sources and losses, demands."""
        first, second, _ = self.places
        c, nu = state[:, :first], state[:, first:second]
        angles, turning = self.steering(time, state)
        place = self.mechanics.at(c, nu)
        forces = self.mechanics.act(place, nu, angles, turning)
        total = forces.generalised - place.bias
        powers: dict[str, Any] = dict(forces.losses)
        if self.wrench is not None:
            pushed = self.user(time)
            total += pushed
            powers["user"] = np.sum(pushed * nu, axis=-1)
        inertia = place.inertia
        if self.links is not None:
            link = place.kinematics
            onto, electric = self.links.act(inputs.links, link.speed)
            total += np.matmul(np.swapaxes(link.jacobian, -1, -2), onto[..., None])[..., 0]
            powers |= electric
        if self.motor is None:
            accelerations = np.linalg.solve(inertia, total[..., None])[..., 0]
        else:
            column = self.motor.coordinate
            torque, electric = self.motor.act(inputs.current, nu[:, column])
            total[:, column] += torque
            inertia = inertia.copy()
            inertia[:, column, column] += self.motor.inertia
            powers |= electric
            accelerations = self._driven(self.motor, inertia, total, torque, nu[:, column], powers)
        stored = 0.5 * np.sum(nu * np.matmul(inertia, nu[..., None])[..., 0], axis=-1)
        parts = [place.changes, accelerations]
        if self.servo is None:
            powers["steering"] = np.sum(forces.resisting * turning, axis=-1)
        else:
            torque, electric = self.servo.act(inputs.steering, turning)
            powers |= electric
            parts += [turning, (torque - forces.resisting) / self.servo.inertia]
            stored = stored + 0.5 * self.servo.inertia * np.sum(turning * turning, axis=-1)
        passed = np.zeros((len(state), len(self.sources) + len(self.losses)))
        for place_of, name in enumerate((*self.sources, *self.losses)):
            if name in powers:
                passed[:, place_of] = powers[name]
        return Rates(np.concatenate(parts, axis=-1), passed, stored, forces.demand)

    @staticmethod
    def _driven(
        motor: PowerMotor,
        inertia: np.ndarray,
        total: np.ndarray,
        torque: np.ndarray,
        speed: np.ndarray,
        powers: dict[str, Any],
    ) -> np.ndarray:
        """Accelerations with a motor; adds the loss of a gearhead that depends on the load."""
        if not motor.loaded:
            return np.linalg.solve(inertia, total[..., None])[..., 0]
        sides = np.zeros((*total.shape, 2))
        sides[:, :, 0] = total
        sides[:, motor.coordinate, 1] = 1.0
        free, unit = np.moveaxis(np.linalg.solve(inertia, sides), -1, 0)
        shaft, column = motor.gearhead.ratio * speed, motor.coordinate
        friction = motor.load_friction(shaft, torque, free[:, column], unit[:, column])
        powers["gearhead"] = powers["gearhead"] + friction * shaft
        return free - unit * (motor.gearhead.ratio * friction)[:, None]

    def energies(self, state: np.ndarray) -> np.ndarray:
        """Kinetic energies of machine, power motor and steering. (m, 3) [J]"""
        first, second, third = self.places
        nu = state[:, first:second]
        place = self.mechanics.at(state[:, :first], nu)
        body = 0.5 * np.sum(nu * np.matmul(place.inertia, nu[..., None])[..., 0], axis=-1)
        rotor = 0.0 * body if self.motor is None else 0.5 * self.motor.inertia * nu[:, self.motor.coordinate] ** 2
        bells = 0.0 * body
        if self.servo is not None:
            bells = 0.5 * self.servo.inertia * np.sum(state[:, third:] ** 2, axis=-1)
        return np.stack([body, rotor, bells], axis=-1)
