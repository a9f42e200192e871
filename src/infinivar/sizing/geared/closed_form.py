r"""Demands of many candidates at one stage, without sampling.

With the sign s of the speed and ``x = (torque s, acceleration s, |speed|)`` at the gear's output, the current of a candidate
is linear where the gear drives and where it is driven:

.. math::
    s I = \alpha x_1 + \beta x_2 + \gamma x_3 + \delta, \qquad
    \alpha = \frac{e}{n k}, \quad \beta = \frac{n J}{k}, \quad \gamma = \frac{n c}{k}, \quad \delta = \frac{\tau_g + \tau_m}{k}

with :math:`e = 1/\eta` while the motor drives, the backdriving efficiency while the load drives, and 1 for constant gear
friction :math:`\tau_g`. Its mean square is a quadratic form of the moments of x, one matrix for all candidates; current and
voltage are extreme at corners of the convex hull of x. At rest friction carries what it can: ``|I| = max(alpha |torque| -
delta, 0)``.

Over a settled cycle the heat that enters winding and housing leaves them, so that with the mean powers of winding loss J and
friction F the winding is ``(R_wh + R_ha) J + R_ha F`` above ambient on average, and thus at some instant. It is nowhere below
ambient, where its resistance gives a lower bound of J. The law divides the cycle into steps of at most a fiftieth of the
winding's time constant, within which temperatures err by a small part of their change in a step, for which `SPARE` leaves
ample room; where steps are longer, the bound is not used.

Source: faulring2006, Fig 14; moments and hulls: linearity of the laws in x.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from infinivar._core.fields import given
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.limits import Demand, Limit
from infinivar.parts.amplifier import Amplifier
from infinivar.parts.gearhead import Gearhead
from infinivar.parts.heat_steps import step_count
from infinivar.parts.motor import Motor
from infinivar.sizing.geared.candidates import Pairs
from infinivar.sizing.geared.extremes import extreme_places
from infinivar.sizing.geared.sampled import HOT
from infinivar.sizing.geared.tasks import MotionTask, StageSignals, Task, heat_counts

SPARE = 0.01
"""Share by which the bound may exceed the permissible rise before it excludes a candidate."""
_SHORT = 1.0 / 50.0 * (1.0 + 1e-9)
"""Longest step, in multiples of the winding's time constant."""


_ROWS = 4096
"""Candidates handled at once, so that intermediate arrays stay small."""


class Linear(NamedTuple):
    """Coefficients of the current of many candidates. (k,)"""

    drive: np.ndarray
    """alpha while the motor drives. [A N^-1 m^-1]"""
    brake: np.ndarray
    """alpha while the load drives, and at rest. [A N^-1 m^-1]"""
    inertia: np.ndarray
    """beta. [A s^2]"""
    viscous: np.ndarray
    """gamma. [A s]"""
    friction: np.ndarray
    """delta. [A]"""
    back_emf: np.ndarray
    """Voltage per speed at the gear's output, n k. [V s]"""


class Moments(NamedTuple):
    """Means over all instants of products of ``(torque s while driving, torque s while driven, acceleration s, |speed|, 1)``."""

    all: np.ndarray
    """(5, 5)"""
    resting: np.ndarray
    """Torques at rest in rising order. (m,) [N m]"""
    sums: np.ndarray
    """Sums of the largest of them: number, torques and their squares, without the first 0 to m. (m + 1, 3)"""
    instants: int
    """Number of instants."""


def linear(drive: ConventionalDrive) -> Linear:
    """Coefficients of many drives, whose values are arrays of shape (k, 1)."""
    return linear_of(drive.motor, drive.gearhead)


def linear_of(motor: Motor, gear: Gearhead) -> Linear:
    """Coefficients of many motors with their gearheads, whose values are arrays of shape (k, 1)."""
    constant, ratio = np.asarray(motor.torque_constant), np.asarray(gear.ratio)
    law = gear.law(motor.continuous_torque)
    forward, backward = law.load_factors
    inertia = given(motor.rotor_inertia, 0.0) + given(gear.inertia, 0.0)
    friction = law.constant + motor.friction_torque
    found = (
        forward / (ratio * constant),
        backward / (ratio * constant),
        ratio * inertia / constant,
        ratio * (given(motor.viscous_friction, 0.0) + law.viscous) / constant,
        friction / constant,
        ratio * constant,
    )
    return Linear(*(np.broadcast_to(part, ratio.shape)[:, 0] for part in found))


def moments(signals: StageSignals) -> Moments:
    """Moments of a task at a stage, for all candidates."""
    torque, acceleration, speed = signals.moving.T
    drives = torque > 0.0
    columns = np.stack(
        [np.where(drives, torque, 0.0), np.where(drives, 0.0, torque), acceleration, speed, np.ones_like(speed)]
    )
    count = max(signals.total, 1)
    rest = signals.resting
    powers = np.stack([np.ones_like(rest), rest, rest * rest], axis=-1)
    sums = np.concatenate([np.cumsum(powers[::-1], axis=0)[::-1], np.zeros((1, 3))])
    return Moments(columns @ columns.T / count, rest, sums, count)


def squares(current: Linear, made: Moments) -> tuple[np.ndarray, np.ndarray]:
    """Mean square of the current in motion and at rest, over all instants. (k,), (k,) [A^2]"""
    factors = np.stack([current.drive, current.brake, current.inertia, current.viscous, current.friction], axis=-1)
    moved = np.einsum("ki,ij,kj->k", factors, made.all, factors, optimize=True)
    return np.maximum(moved, 0.0), resting_square(made, current.brake, current.friction)


def resting_square(made: Moments, slope: np.ndarray, friction: np.ndarray) -> np.ndarray:
    """Mean over all instants of ``max(slope torque - friction, 0)^2`` at rest. (k,)"""
    if not made.resting.size:
        return np.zeros(np.shape(slope))
    with np.errstate(divide="ignore", invalid="ignore"):
        first = np.searchsorted(made.resting, np.where(slope > 0, friction / slope, np.inf))
    number, torque, square = np.moveaxis(made.sums[first], -1, 0)
    return (
        np.maximum(slope * slope * square - 2.0 * slope * friction * torque + friction * friction * number, 0.0)
        / made.instants
    )


def supplied(amplifier: Amplifier, everything: np.ndarray, drawn: np.ndarray) -> np.ndarray:
    """Mean power from the supply, from the mean of the motor's power and of its positive part. [W]

    Source: `Amplifier.supply`, which is linear in the positive and the negative part of the power.
    """
    unit, _, _ = amplifier.supply(np.array([0.0, 1.0, -1.0]))
    standby, rise, fall = unit[0], unit[1] - unit[0], unit[0] - unit[2]
    return standby + fall * everything + (rise - fall) * drawn


def demands(
    drive: ConventionalDrive,
    current: Linear,
    task: Task,
    signals: StageSignals,
    made: Moments,
    *,
    heated: np.ndarray,
    hottest: np.ndarray,
) -> Iterator[tuple[Demand, np.ndarray]]:
    """Yield demand over allowance of every limit, for all candidates, in the order in which they are checked. (k,)

    Parameters
    ----------
    drive : ConventionalDrive   Many, as arrays of shape (k, 1), with the least resistance that their windings can have.
    heated : (k,) bool          Candidates whose winding temperature is known, and sets the resistance in a motion: their demand
        for voltage is a lower bound, and so are those for current of a motor with iron loss. All other values are those of
        `duty_cycle` and `steady_map`.
    hottest : (k,) float        Largest resistance that the windings can have. [ohm]
    """
    shape = current.drive.shape
    motor, gear = drive.motor, drive.gearhead
    for key, demand in signals.others.items():
        yield key, np.full(shape, demand)
    largest = float(signals.moving[:, 2].max(initial=0.0))
    sizes = np.concatenate([np.abs(signals.moving[:, 0]), signals.resting])
    peak = float(sizes.max(initial=0.0))
    lasting = float(np.sqrt(np.mean(sizes**2))) if task.root_mean_square and sizes.size else peak
    for limit, demand in gear.extreme_utilisation(peak, lasting, largest).items():
        yield (limit, "gearhead"), np.broadcast_to(demand, (*shape, 1))[:, 0]
    turning = current.back_emf / np.ravel(motor.torque_constant) * largest
    highest, volts = _extremes(drive, current, signals, heated, hottest)
    moved, rested = squares(current, made)
    lasting_current = np.sqrt(moved + rested) if task.root_mean_square else highest
    largest_of = {"current": highest, "lasting": lasting_current, "voltage": volts, "speed": turning}
    columns: Any = {name: values[:, None] for name, values in largest_of.items()}
    spared = heated & heat_counts(task)
    for limit, demand in motor.extreme_utilisation(**columns).items():
        found = np.asarray(demand)[:, 0]
        yield (limit, "motor"), np.where(spared, 0.0, found) if limit == Limit.THERMAL else found


def _extremes(
    drive: ConventionalDrive, current: Linear, signals: StageSignals, heated: np.ndarray, hottest: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Largest size of current, and of voltage or a lower bound of it where the resistance is not known. (k,), (k,)"""
    low = np.ravel(drive.motor.resistance)
    drives = signals.moving[:, 0] > 0.0
    parts = []
    for part, slope in ((signals.moving[drives], current.drive), (signals.moving[~drives], current.brake)):
        if len(part):
            parts.append((part[extreme_places(part)], slope))
    top = float(signals.resting[-1]) if signals.resting.size else 0.0
    highest = np.maximum(current.brake * top - current.friction, 0.0)
    volts = low * highest
    for start in range(0, len(highest), _ROWS):
        rows = slice(start, start + _ROWS)
        for points, slope in parts:
            factors = np.stack([slope, current.inertia, current.viscous], axis=-1)[rows]
            amps = factors @ points.T + current.friction[rows, None]
            highest[rows] = np.maximum(highest[rows], np.abs(amps).max(axis=-1))
            turned = current.back_emf[rows, None] * points[:, 2]
            least = amps * low[rows, None] + turned
            size = np.abs(least)
            if heated[rows].any():
                most = amps * hottest[rows, None] + turned
                size = np.where(least * most > 0.0, np.minimum(size, np.abs(most)), 0.0)
            volts[rows] = np.maximum(volts[rows], size.max(axis=-1))
    return highest, volts


def with_resistance(drive: ConventionalDrive, resistance: np.ndarray) -> ConventionalDrive:
    """Many drives with other resistances of their windings (k,). [ohm]"""
    column: Any = resistance[:, None]
    return replace(drive, motor=drive.motor.with_resistance(column))


class Warmth(NamedTuple):
    """Thermal values of many candidates. (k,) each"""

    known: np.ndarray
    """Whether the bound applies. bool"""
    by_winding: np.ndarray
    """Rise per winding loss, over the permissible rise; 0 where the bound does not apply. [W^-1]"""
    by_friction: np.ndarray
    """Rise per friction and iron loss, over the permissible rise. [W^-1]"""
    hopeless: np.ndarray
    """Whether the surroundings alone are warmer than the winding may be. bool"""


def warmth(found: Pairs, task: Task, rows: np.ndarray) -> Warmth | None:
    """Thermal values of candidates; None for a task other than a cycle, and where no motor has them."""
    if not isinstance(task, MotionTask) or not task.duty.closed:
        return None
    inner, outer, lag, limit = (
        found.values("motor", name, rows)
        for name in ("winding_to_housing", "housing_to_ambient", "winding_time_constant", "max_winding_temperature")
    )
    allowed, stated = limit - task.duty.ambient, found.stated(HOT, rows)
    known, hopeless = stated & (allowed > 0.0), stated & (allowed < 0.0)
    count = step_count(np.where(known, lag, 1.0), task.period, len(task.instants.time))
    known = known & (task.period <= _SHORT * count * lag)
    if not (known | hopeless).any():
        return None
    most = np.where(known, allowed, 1.0) * (1.0 + SPARE)
    return Warmth(known, np.where(known, (inner + outer) / most, 0.0), np.where(known, outer / most, 0.0), hopeless)


def friction_factors(drive: ConventionalDrive) -> tuple[np.ndarray, np.ndarray]:
    """Friction and iron loss of many motors per speed of the gear's output, and per square of it. (k,), (k,) [W s], [W s^2]"""
    motor, ratio = drive.motor, np.ravel(drive.gearhead.ratio)
    viscous = 0.0 if motor.viscous_friction is None else np.ravel(motor.viscous_friction)
    return np.ravel(motor.friction_torque) * ratio, viscous * ratio * ratio
