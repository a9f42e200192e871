"""Best speed of a common cylinder: one for all motions, one for each, or varying over a cycle with its inertia counted.

A slow cylinder has little rolling loss and needs large steering angles, at which creep is large and wheels slip; all legs
share one speed, whichever of them moves fast or is loaded.
"""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
from annotated_types import Gt

from infinivar._core.array_namespace import Array
from infinivar._core.fields import check_instance, check_number
from infinivar._core.result import Result, result
from infinivar._core.threads import products_on_one_thread
from infinivar.analysis.cycles.cylinder_policy import HARMONICS, RANGE, schedule, schedules_within
from infinivar.errors import require
from infinivar.limits import ROOT_MEAN_SQUARE, Limit
from infinivar.machines.many_legs import LeggedDrive, MachinePoint
from infinivar.transmission.configuration import Configuration
from infinivar.transmission.rates import Varying

_GRID = 60
"""Speeds of the first search, over `RANGE` times the nominal speed in equal ratios."""

_GOLDEN = (5.0**0.5 - 1.0) / 2.0
_SECTIONS = 32
"""Golden sections after it; 1e-7 of a step of the grid remains."""

_LEAST_INSTANTS = 4 * HARMONICS
"""Of a cycle: with fewer, a schedule could change its speed between them at no cost."""

_INSIDE = 0.999
"""Largest demand of a schedule during the search. [-]"""


@result
class CommonSpeed(Result):
    """Speeds of a common cylinder for a set of motions, or for a cycle; powers are means over the motions.

    Attributes
    ----------
    nominal, nominal_power : float    The drive's own speed; its power is nan if infeasible. [rad s^-1], [W]
    fixed, fixed_power : float        The best constant speed within all limits; nan if there is none. [rad s^-1], [W]
    limit : int                       `Limit.OK`, or without such a speed the tightest limit at the nominal one.
    by_motion : (m,) float            The best speed of each motion on its own; nan where there is none. [rad s^-1]
    by_motion_power : float           Without the power that changes of speed need, so that it is no plan; a schedule can
        even need less, as the inertia of the cylinder smooths the motor's torque. [W]
    scheduled : Varying               Over a cycle: speed and rate at its instants; None without a period. [rad s^-1], ...
    scheduled_power : float           With the inertia of cylinder, gearhead and rotor; nan without a period. [W]
    """

    nominal: float
    nominal_power: float
    fixed: float
    fixed_power: float
    limit: int
    by_motion: Array
    by_motion_power: float
    scheduled: Varying | None
    scheduled_power: float


@products_on_one_thread()
def best_cylinder_speed(
    drive: LeggedDrive,
    configuration: Configuration,
    *,
    wrench: Array,
    twist: Array,
    period: float | None = None,
) -> CommonSpeed:
    """Find the cylinder speed of the lowest power from the supply.

    Parameters
    ----------
    drive : LeggedDrive             With a period, with the inertias of cylinder and rotor.
    configuration : Configuration   Of one pose, or of m poses.
    wrench, twist : (m, d) float    Of m motions; those of a cycle at equal intervals, the last one before its end. The wrench
        includes the inertia of platform and links, by d'Alembert. Over a cycle the motor's heating counts as its root mean
        square, else as the peak.
    period : float                  Of the cycle; None if the motions are not a cycle. [s]

    Returns
    -------
    CommonSpeed   The search is confined to `RANGE` times the drive's speed. The schedule's logarithm is a series of three
        harmonics, and never worse than the constant speed.

    Raises
    ------
    ParameterError
        If shapes do not fit, the period is not positive, its instants are too few, or an inertia that a schedule needs is
        missing.

    Source: lowest power by search; for creep alone the closed form is `infinivar.transmission.legs.least_creep_speed`.
    """
    check_instance("drive", drive, LeggedDrive)
    drive.legs.check_links(configuration)
    wrench, twist = configuration.vector(wrench, "wrench"), configuration.vector(twist, "twist")
    require(
        wrench.ndim == twist.ndim == 2, "wrench and twist", f"shapes {wrench.shape}, {twist.shape}", "of shape (m, d)"
    )
    motions = max(len(wrench), len(twist))
    require(len(wrench) > 0 and len(twist) > 0, "wrench and twist", "none", "those of one motion or more")
    poses = configuration.jacobian.shape[:-2]
    require(poses in ((), (1,), (motions,)), "configuration", f"{poses} poses", f"of one pose, or of {motions}")
    require(
        len(wrench) in (1, motions) and len(twist) in (1, motions),
        "twist",
        f"{len(twist)} rows",
        f"{len(wrench)}, as the wrench has",
    )
    if period is not None:
        check_number("period", period, "s", Gt(0))
        require(
            motions >= _LEAST_INSTANTS,
            "wrench and twist",
            f"{motions}",
            f"those of {_LEAST_INSTANTS} instants of a cycle or more",
        )

    def powers(speed: np.ndarray) -> np.ndarray:
        """From the supply where within limits, else inf: (..., m) for speeds (..., m) or (..., 1)."""
        point = drive.operate(configuration, wrench=wrench, twist=twist, cylinder_speed=speed)
        limit, power = np.broadcast_arrays(np.asarray(point.limit), point.power_in)
        return np.where(limit == Limit.OK, power, np.inf)

    def mean(speed: np.ndarray) -> np.ndarray:
        """Of all motions, for speeds (..., 1)."""
        if period is None:
            return np.mean(np.broadcast_to(powers(speed), (*speed.shape[:-1], motions)), axis=-1, keepdims=True)
        point = drive.operate(configuration, wrench=wrench, twist=twist, cylinder_speed=speed)
        power = np.mean(np.broadcast_to(point.power_in, (*speed.shape[:-1], motions)), axis=-1)
        return np.where(_worst(point, motions) <= 1.0, power, np.inf)[..., None]

    nominal = np.array([drive.cylinder_speed])
    fixed, fixed_power = _searched(mean, nominal)
    each, each_power = _searched(powers, np.broadcast_to(nominal, (motions,)))
    scheduled, scheduled_power = None, np.nan
    if period is not None and np.isfinite(fixed[0]):
        scheduled, scheduled_power = _best_schedule(drive, configuration, wrench, twist, period, float(fixed[0]))
    own = float(mean(nominal)[0])
    point = drive.operate(configuration, wrench=wrench, twist=twist, cylinder_speed=nominal)
    return CommonSpeed(
        nominal=drive.cylinder_speed,
        nominal_power=own if np.isfinite(own) else np.nan,
        fixed=float(fixed[0]),
        fixed_power=float(fixed_power[0]),
        limit=int(Limit.OK) if np.isfinite(fixed[0]) else _tightest(point),
        by_motion=each,
        by_motion_power=float(np.mean(each_power)),
        scheduled=scheduled,
        scheduled_power=scheduled_power,
    )


def _searched(cost: Any, nominal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Speeds of the lowest cost, element by element, and that cost; nan where none is finite."""
    factors = np.geomspace(*RANGE, _GRID)
    grid = factors[:, None] * nominal
    costs = np.broadcast_to(cost(grid), grid.shape)
    place = np.argmin(costs, axis=0)
    best, least = grid[place, np.arange(len(nominal))], costs[place, np.arange(len(nominal))]
    low = np.log(factors[np.maximum(place - 1, 0)])
    high = np.log(factors[np.minimum(place + 1, _GRID - 1)])
    for _ in range(_SECTIONS):
        left, right = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
        at_left, at_right = cost(np.exp(left) * nominal), cost(np.exp(right) * nominal)
        for logarithm, value in ((left, at_left), (right, at_right)):
            best = np.where(value < least, np.exp(logarithm) * nominal, best)
            least = np.minimum(value, least)
        # Towards slow cylinders lies slip: an infinite cost on both sides means that the feasible speeds lie above.
        go_left = at_left < at_right
        low, high = np.where(go_left, low, left), np.where(go_left, right, high)
    return np.where(np.isfinite(least), best, np.nan), np.where(np.isfinite(least), least, np.nan)


def _tightest(point: MachinePoint) -> int:
    """The limit of the motion that exceeds one the most, or the one nearest to being exceeded."""
    limit, margin = np.broadcast_arrays(point.limit, point.margin)
    beyond = np.where(limit == Limit.OK, np.inf, margin)
    return int(limit.flat[int(np.argmin(beyond))])


def _demands(point: MachinePoint, motions: int) -> list[np.ndarray]:
    """Demand over a cycle by limit: root mean squares of heating, peaks of all else; inf where a wheel slips."""
    found = []
    for limit, demand in point.utilisation.items():
        whole = np.broadcast_to(demand, (*np.shape(demand)[:-1], motions))
        over = np.sqrt(np.mean(whole * whole, axis=-1)) if limit in ROOT_MEAN_SQUARE else np.max(whole, axis=-1)
        found.append(np.where(np.isnan(over), np.inf, over))
    return found


def _worst(point: MachinePoint, motions: int) -> np.ndarray:
    """Largest of all demands over a cycle."""
    return functools.reduce(np.maximum, _demands(point, motions), np.zeros(()))


def _best_schedule(
    drive: LeggedDrive,
    configuration: Configuration,
    wrench: np.ndarray,
    twist: np.ndarray,
    period: float,
    fixed: float,
) -> tuple[Varying, float]:
    """Periodic speed of the lowest mean power, and that power."""
    drive.turning_inertia  # noqa: B018  raises what is missing, before the search
    motions = max(len(wrench), len(twist))
    time = np.arange(motions) * (period / motions)
    low, high = (np.log(end * abs(drive.cylinder_speed / fixed)) for end in RANGE)

    def run(parameters: np.ndarray) -> tuple[Varying, MachinePoint]:
        speed = schedule(fixed, period, parameters, time)
        point = drive.operate(
            configuration, wrench=wrench, twist=twist, cylinder_speed=speed.value, cylinder_acceleration=speed.rate
        )
        return speed, point

    def judged(parameters: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean power [W]; margins of all limits and of both ends of the range, on the last axis."""
        speed, point = run(parameters)
        power = np.mean(point.power_in, axis=-1)
        swing = np.log(speed.value / fixed)
        demands = [np.broadcast_to(demand, power.shape) for demand in _demands(point, motions)]
        ends = [high - np.max(swing, axis=-1), np.min(swing, axis=-1) - low]
        return power, np.stack([*(_INSIDE - demand for demand in demands), *ends], axis=-1)

    start = np.zeros(2 * HARMONICS + 1)
    best, point = run(start)
    least = float(np.mean(point.power_in))
    for found in schedules_within(judged, start, (low, high)):
        speed, point = run(found)
        power, swing = float(np.mean(point.power_in)), np.log(speed.value / fixed)
        within = _worst(point, motions) <= 1.0 and low <= np.min(swing) and np.max(swing) <= high
        if within and power < least:
            best, least = speed, power
    return best, least
