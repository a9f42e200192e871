r"""What is known of every motor with a given wheel, without its history in time: exact demands, or lower bounds of them.

At constant cylinder speed the current of its motor is linear in the torque of the cylinder, with one slope where the motor
drives and one where it is driven. The current of the steering motor is linear in torque, acceleration and speed of the bell.
Both are ``s I = a . b(t)`` with four signals b that no motor changes, so that mean squares, mean powers and largest values of all
motors follow from 4 x 4 moments and few instants of each wheel design.

Source: faulring2006, Fig 11 and Fig 12; linearity of the laws in these signals.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Protocol

import numpy as np

from infinivar.drivetrain.steering import SteeringPlant
from infinivar.limits import Demand, Limit
from infinivar.parts.amplifier import Amplifier
from infinivar.parts.gearhead import Gearhead
from infinivar.parts.motor import Motor
from infinivar.sizing.cobotic.wheels import Shaft
from infinivar.sizing.geared.candidates import Pairs
from infinivar.sizing.geared.closed_form import linear_of, supplied, warmth
from infinivar.sizing.geared.sampled import HOT
from infinivar.sizing.geared.tasks import MotionTask, RegionTask, heat_counts

MOTOR, STEERING = "motor", "steering motor"

_LEVELS = (0.0, 0.25, 0.5, 0.75)
"""Parts of the lowest signal above which instants count in a lower bound of the power drawn."""

_NO_INERTIA = Motor(
    voltage=1.0, resistance=1.0, torque_constant=1.0, no_load_current=0.0, continuous_torque=1.0, rotor_inertia=1e-300
)


class Judging(Protocol):
    """How a task judges motors."""

    @property
    def root_mean_square(self) -> bool:
        """Whether continuous torques bound the root mean square."""
        ...

    @property
    def coldest(self) -> float:
        """Lowest temperature that a winding can have; nan where it counts as at 25 °C. [K]"""
        ...


class MotorSignals(NamedTuple):
    """What a task asks of one motor, by wheel design."""

    moments: np.ndarray
    """Means of products of the four signals, of all instants and of those above each level. (levels + 1, k, 4, 4)"""
    points: np.ndarray
    """MotorSignals at instants at which current or voltage may be largest. (points, k, 4)"""
    peak: np.ndarray
    """Largest torque at the gear's output. (k,) [N m]"""
    lasting: np.ndarray
    """Root mean square of it; in a required region the largest. (k,) [N m]"""
    fastest: np.ndarray
    """Largest speed at the gear's output. (k,) [rad s^-1]"""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Side:
    """A motor of the drive with all its candidates: pairs of motor and gearhead, or of steering motor and ratio."""

    name: str
    found: Pairs
    amplifier: Amplifier

    @property
    def rows(self) -> np.ndarray:
        """Pairs whose laws can be evaluated. (p,)"""
        return self.found.usable

    @property
    def gearhead(self) -> str:
        """Whose limits those of the gear are; the gear of a steering motor has none."""
        return "gearhead" if self.name == MOTOR else "steering gear"


class MotorBounds(NamedTuple):
    """Lower bounds for all candidates of a side with some wheel designs. (p, k) each"""

    demands: Mapping[Demand, np.ndarray]
    power: np.ndarray
    """Mean power from the supply; 0 for a required region. [W]"""


def cylinder_signals(task: Judging, shaft: Shaft) -> MotorSignals:
    """What a task asks of the cylinder motor of wheel designs."""
    turning = shaft.turning[:, 0]
    along = shaft.torque * np.sign(turning)[:, None]
    fast = np.abs(turning)
    ones = np.ones_like(along)
    signals = np.stack([np.maximum(along, 0.0), np.minimum(along, 0.0), ones * fast[:, None], ones], axis=-1)
    places = np.stack([along.argmax(axis=-1), along.argmin(axis=-1)])
    points = np.stack([signals[np.arange(len(along)), place] for place in places])
    peak = np.abs(along).max(axis=-1)
    lasting = np.sqrt(np.mean(along**2, axis=-1)) if task.root_mean_square else peak
    return MotorSignals(_moments(signals, along), points, peak, lasting, fast)


def steering_signals(plant: SteeringPlant, shaft: Shaft) -> MotorSignals:
    """What a motion asks of the steering motor of wheel designs; instants at which steering rests count as without current."""
    side = shaft.steer(replace(plant, motor=_NO_INERTIA, ratio=1.0))
    sign = np.sign(shaft.rate)
    torque = np.asarray(side.states["steering_torque_Nm"])
    signals = np.stack([torque * sign, shaft.acceleration * sign, np.abs(shaft.rate), np.abs(sign)], axis=-1)
    ends = [signals[..., place] for place in range(3)]
    ends += [
        signals[..., 0] + 0.5 * np.abs(signals[..., 0]).max(axis=-1, keepdims=True) * _unit(signals[..., place])
        for place in (1, 2)
    ]
    places = [pick(end, axis=-1) for end in ends for pick in (np.argmax, np.argmin)]
    points = np.stack([signals[np.arange(len(torque)), place] for place in places])
    size = np.abs(torque * sign)
    return MotorSignals(
        _moments(signals, torque * sign),
        points,
        size.max(axis=-1),
        np.sqrt(np.mean(size**2, axis=-1)),
        np.abs(shaft.rate).max(axis=-1),
    )


def _unit(values: np.ndarray) -> np.ndarray:
    largest = np.abs(values).max(axis=-1, keepdims=True)
    return values / np.where(largest > 0.0, largest, 1.0)


def _moments(signals: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Means of products of signals, of all instants and of those in which torque along the motion exceeds each level."""
    low = np.minimum(along.min(axis=-1, keepdims=True), 0.0)
    count = signals.shape[-2]
    found = [np.swapaxes(signals, -1, -2) @ signals / count]
    for level in _LEVELS:
        some = signals * (along > level * low)[..., None]
        found.append(np.swapaxes(some, -1, -2) @ signals / count)
    return np.stack(found)


def lower_bounds(side: Side, task: Judging, signals: MotorSignals) -> MotorBounds:
    """Demands and power of all candidates of a side, each at most the true one.

    Exact are speed, torques of the gearhead and, for the cylinder motor, currents; and voltages where the resistance is known.
    What heat adds to voltage, power and temperature is not counted beyond what a cycle's mean losses prove.
    """
    found, rows = side.found, side.rows
    motor, gear = found.parts(rows)
    heated, low, high = found.resistances(rows, task.coldest)
    columns: Any = low[:, None]
    motor = motor.with_resistance(columns)
    current = linear_of(motor, gear)
    second = current.brake if side.name == MOTOR else current.inertia
    factors = np.stack([current.drive, second, current.viscous, current.friction], axis=-1)
    spread = (factors[:, :, None] * factors[:, None, :]).reshape(len(rows), 16)
    square = np.maximum(spread @ signals.moments[0].reshape(-1, 16).T, 0.0)
    demands = _of_gear(side, gear, signals)
    demands |= _of_motor(side, task, motor, low, high, heated, factors, current.back_emf, signals, square)
    if isinstance(task, RegionTask):
        return MotorBounds(demands, np.zeros_like(square))
    if isinstance(task, MotionTask):
        demands |= _temperature(side, task, motor, gear, signals, square)
    # Winding loss, and back-emf times current times speed, the third signal.
    weights = low[:, None] * spread
    weights[:, 2::4] += current.back_emf[:, None] * factors
    powers = [weights @ one.reshape(-1, 16).T for one in signals.moments]
    drawn = functools.reduce(np.maximum, powers, np.zeros_like(square))
    return MotorBounds(demands, supplied(side.amplifier, powers[0], drawn))


def _of_gear(side: Side, gear: Gearhead, signals: MotorSignals) -> dict[Demand, np.ndarray]:
    if side.name != MOTOR:
        return {}
    demands = gear.extreme_utilisation(signals.peak, signals.lasting, signals.fastest)
    return {(limit, side.gearhead): np.asarray(demand) for limit, demand in demands.items()}


def _of_motor(
    side: Side,
    task: Judging,
    motor: Motor,
    low: np.ndarray,
    high: np.ndarray,
    heated: np.ndarray,
    factors: np.ndarray,
    back_emf: np.ndarray,
    signals: MotorSignals,
    square: np.ndarray,
) -> dict[Demand, np.ndarray]:
    """Lower bounds of the demands for continuous and peak torque, speed and voltage."""
    highest, volts = np.zeros(square.shape), np.zeros(square.shape)
    turned = np.zeros(factors.shape)
    turned[:, 2] = back_emf
    cold, hot = low[:, None] * factors + turned, high[:, None] * factors + turned
    for point in signals.points:
        amps, least, most = (some @ point.T for some in (factors, cold, hot))
        np.maximum(highest, np.abs(amps, out=amps), out=highest)
        # The smaller size of both voltages; nothing where they differ in sign.
        np.maximum(volts, np.minimum(least, most, out=amps), out=volts)
        np.maximum(volts, np.negative(np.maximum(least, most, out=least), out=least), out=volts)
    lasting = np.sqrt(square) if task.root_mean_square else highest
    spared = heated[:, None] & heat_counts(task)
    fast = back_emf[:, None] / np.asarray(motor.torque_constant) * signals.fastest
    demand = motor.extreme_utilisation(current=highest, lasting=lasting, voltage=volts, speed=fast)
    demand[Limit.THERMAL] = np.where(spared, 0.0, demand[Limit.THERMAL])
    return {(limit, side.name): np.asarray(one) for limit, one in demand.items()}


def _temperature(
    side: Side, task: MotionTask, motor: Motor, gear: Gearhead, signals: MotorSignals, square: np.ndarray
) -> dict[Demand, np.ndarray]:
    """Lower bound of the rise of the winding over the permissible one; 0 where none is known."""
    heat = warmth(side.found, task, side.rows)
    if heat is None:
        return {}
    ratio = np.asarray(gear.ratio)
    viscous = 0.0 if motor.viscous_friction is None else np.asarray(motor.viscous_friction)
    speed, speed_square = signals.moments[0][:, 2, 3], signals.moments[0][:, 2, 2]
    rubbed = np.asarray(motor.friction_torque) * ratio * speed + viscous * ratio**2 * speed_square
    rise = heat.by_winding[:, None] * np.asarray(motor.resistance) * square + heat.by_friction[:, None] * rubbed
    # Where `known` is false, both factors are 0.
    return {(HOT[0], side.name): rise}
