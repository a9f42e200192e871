"""One power motor for n joints against a motor for each joint, in watts and kilograms.

All joints hold the same force for a share of the time (the duty) and nothing in the rest, in which they idle or move freely. A
fixed-ratio drive needs current while it holds and none while idle. A cobotic one holds by the wheels, but its cylinder turns:
while idle, too, unless it is stopped and run up again for each spell of holding.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from annotated_types import Gt, Interval

from infinivar._core.array_namespace import Array
from infinivar._core.arrays import real_array
from infinivar._core.bounds import FINITE
from infinivar._core.fields import check_number
from infinivar._core.result import Result, result
from infinivar.axis import LINEAR
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.drive import axis_of, check_drive, operated
from infinivar.errors import ParameterError, require
from infinivar.limits import Limit
from infinivar.machines.many_legs import LeggedDrive
from infinivar.transmission.configuration import Configuration

_RUN_UP_STEPS = 200
"""Instants of a run-up at constant acceleration."""


@result
class SharedMotor(Result):
    """Mean powers and masses over duty (D,), number of legs (N,) and holding force (F,); SI.

    Attributes
    ----------
    force, legs, duty : (F,), (N,), (D,)    The axes. [N], [-], [-]
    speed : float                           Of all links while they hold; 0: at rest. [m s^-1]
    turning : (D, N, F) float               Shared motor, cylinder always turning. [W]
    stopping : (D, N, F) float              Shared motor, cylinder stopped while idle, with the energy of the run-ups. [W]
    separate : (D, N, F) float              A motor for each joint. [W]
    turning_limit : (N, F) int8             The tightest limit where it is exceeded while holding; with a shared motor,
    separate_limit : (F,) int8              and with a motor for each joint.
    run_up_energy : (N,) float              Of one run-up; nan without the inertias. [J]
    shared_mass, separate_mass : (N,) float     Of motors: the power motor and a steering motor a leg, against a power motor a
        joint; nan where a mass is unknown. [kg]
    cylinder_mass : float                   The least that a cylinder of the given inertia and radius can have, J/R^2; nan if
        unknown. [kg]
    """

    force: Array
    legs: Array
    duty: Array
    speed: float
    turning: Array
    stopping: Array
    separate: Array
    turning_limit: Array
    separate_limit: Array
    run_up_energy: Array
    shared_mass: Array
    separate_mass: Array
    cylinder_mass: float

    @property
    def turning_feasible(self) -> np.ndarray:
        """Where all limits are kept while holding, with a shared motor. (N, F) bool"""
        return np.asarray(self.turning_limit) == Limit.OK

    @property
    def separate_feasible(self) -> np.ndarray:
        """Where all limits are kept while holding, with a motor for each joint. (F,) bool"""
        return np.asarray(self.separate_limit) == Limit.OK

    def least_legs(self, *, stopped: bool = False) -> np.ndarray:
        """Least number of legs, of those compared, from which the shared motor draws less power. (D, F) float, nan if none.

        Parameters
        ----------
        stopped : bool   Whether the cylinder stops while idle.
        """
        wins = (self.stopping if stopped else self.turning) < self.separate
        order = np.argsort(self.legs)
        wins, count = wins[:, order], np.asarray(self.legs, dtype=float)[order]
        # From there on: a win at some numbers and not at larger ones is none.
        lasting = np.flip(np.logical_and.accumulate(np.flip(wins, 1), axis=1), 1)
        return np.where(lasting.any(axis=1), count[np.argmax(lasting, axis=1)], np.nan)

    def least_force(self, *, stopped: bool = False) -> np.ndarray:
        """Holding force from which the shared motor draws less power, interpolated. (D, N) [N]; inf if none, nan if undefined.

        Parameters
        ----------
        stopped : bool   Whether the cylinder stops while idle.
        """
        excess = (self.stopping if stopped else self.turning) - self.separate
        found = np.full(excess.shape[:-1], np.inf)
        for place in np.ndindex(*found.shape):
            found[place] = _last_crossing(np.asarray(self.force), excess[place])
        return found


def share_motor(
    leg: Any,
    separate: Any,
    *,
    force: Array,
    legs: Sequence[int] = (1, 2, 3, 4, 6, 8, 12),
    duty: Array = 1.0,
    speed: float = 0.0,
    period: float | None = None,
    run_up_time: float = 1.5,
    held_by_friction: bool = False,
    free_share: float = 0.0,
    free_power: tuple[Array, float] | None = None,
) -> SharedMotor:
    """Compare n legs on one motor with n drives.

    Parameters
    ----------
    leg : CoboticDrive          One leg with the motor to be shared.
    separate : Drive            The drive of one joint with a motor of its own.
    force : (F,) float          Force of each joint on its load, rising, >= 0. [N]
    legs : (N,) int             Numbers of legs.
    duty : float or (D,) float  Shares of time in which the force is held, 0 to 1; the rest is idle, at no force, or free motion.
    speed : float               Of all joints while they hold. [m s^-1]
    period : float              From one spell of holding to the next, for the energy of run-ups; None: long. [s]
    run_up_time : float         Of the cylinder, at constant acceleration. [s]
    held_by_friction : bool     Whether friction of a guideway helps the drive with its own motor to hold at rest. By default
        it does not, as a load that moves by a hair takes it away.
    free_share : float          Of the time in which the force is not held: share in which all joints move freely.
    free_power : (N,) float, float   Mean power then, of the shared motor with the steering of all legs, and of one drive with
        a motor of its own. [W]

    Returns
    -------
    SharedMotor

    Raises
    ------
    ParameterError
        If a value is out of range or a drive moves a joint about an axis.

    Source: faulring2006, section I; `LeggedDrive`, and the drive's own `operate`.
    """
    check_drive(separate, "separate")
    if not isinstance(leg, CoboticDrive):
        raise ParameterError(f"leg must be a CoboticDrive, got a {type(leg).__name__}")
    if axis_of(separate) is not LINEAR or axis_of(leg) is not LINEAR:
        raise ParameterError("separate and leg must both move a load along a line")
    forces, counts, shares = _axes(force, legs, duty)
    check_number("speed", speed, "m/s", FINITE)
    check_number("run_up_time", run_up_time, "s", Gt(0))
    if period is not None:
        check_number("period", period, "s", Gt(0))
    free, free_alone = _free(free_share, free_power, len(counts))
    if not held_by_friction and speed == 0.0 and hasattr(separate, "without_static_friction"):
        separate = separate.without_static_friction()
    both = operated(separate, speed=np.where(np.append(forces, 0.0) > 0, speed, 0.0), force=np.append(forces, 0.0))
    alone = np.broadcast_to(both.power_in, (len(forces) + 1,))
    alone_limit = np.broadcast_to(both.limit, alone.shape)[:-1]

    held, idle, limits, starts = [], [], [], []
    for count in counts:
        machine = LeggedDrive.of(leg, int(count))
        joints = Configuration(jacobian=np.eye(int(count)))
        wrench = np.append(forces, 0.0)[:, None] * np.ones(int(count))
        moving = np.where(wrench != 0, speed, 0.0)
        point = machine.operate(joints, wrench=wrench, twist=moving)
        power = np.broadcast_to(point.power_in, wrench.shape[:1])
        held.append(power[:-1])
        idle.append(power[-1])
        limits.append(np.broadcast_to(point.limit, power.shape)[:-1])
        starts.append(run_up_energy(machine, run_up_time))
    idling = 1.0 - free_share
    turning = _mean(shares, np.array(held), (idling * np.array(idle) + free_share * free)[:, None])
    standby = float(leg.amplifier.standby_power)
    energy = np.array(starts)
    restart = 0.0 if period is None else energy[:, None] / period
    stopping = _mean(shares, np.array(held), (idling * standby + free_share * free)[:, None])
    # A cylinder that never idles is never stopped, and one that does nothing else never starts.
    stopped = (1.0 - shares) * idling
    stopping = stopping + np.where((stopped > 0) & (stopped < 1), 1.0, 0.0)[:, None, None] * restart
    return SharedMotor(
        force=forces,
        legs=counts,
        duty=shares,
        speed=float(speed),
        turning=turning,
        stopping=stopping,
        separate=_mean(
            shares, counts[:, None] * alone[:-1], counts[:, None] * (idling * alone[-1:] + free_share * free_alone)
        ),
        turning_limit=np.array(limits),
        separate_limit=alone_limit,
        run_up_energy=energy,
        shared_mass=_mass(leg.motor) + counts * (0.0 if leg.steering is None else _mass(leg.steering.motor)),
        separate_mass=counts * _mass(getattr(separate, "motor", None)),
        cylinder_mass=np.nan
        if leg.inertia_of_cylinder is None
        else float(leg.inertia_of_cylinder / leg.transmission.cylinder_radius**2),
    )


def run_up_energy(drive: LeggedDrive, time: float) -> float:
    """Energy from the supply to bring the cylinder to its speed at constant acceleration, legs locked and unloaded. [J]

    Parameters
    ----------
    drive : LeggedDrive   nan if an inertia is unknown.
    time : float          Of the run-up, > 0. [s]
    """
    if drive.inertia_of_cylinder is None or drive.motor.rotor_inertia is None:
        return float("nan")
    share = (np.arange(_RUN_UP_STEPS) + 0.5) / _RUN_UP_STEPS
    still = np.zeros(drive.legs.count)
    point = drive.operate(
        Configuration(jacobian=np.eye(drive.legs.count)),
        wrench=still,
        twist=still,
        cylinder_speed=share * drive.cylinder_speed,
        cylinder_acceleration=np.full(_RUN_UP_STEPS, drive.cylinder_speed / time),
    )
    return float(np.mean(point.power_in) * time)


def _axes(force: Array, legs: Sequence[int], duty: Array) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    forces, shares = np.atleast_1d(real_array("force", force)), np.atleast_1d(real_array("duty", duty))
    row = forces.ndim == 1 and forces.size > 0 and bool(np.all(np.isfinite(forces)))
    rising = row and bool(forces[0] >= 0 and np.all(np.diff(forces) > 0))
    require(rising, "force", force, "a row of forces >= 0 that rise", "N")
    counts = np.atleast_1d(np.asarray(legs))
    whole = counts.ndim == 1 and counts.dtype.kind == "i" and bool(np.all(counts >= 1))
    require(whole, "legs", legs, "whole numbers, 1 or more")
    part = shares.ndim == 1 and shares.size > 0 and bool(np.all((shares >= 0) & (shares <= 1)))
    require(part, "duty", duty, "between 0 and 1")
    return forces, counts, shares


def _free(share: float, power: tuple[Array, float] | None, count: int) -> tuple[np.ndarray, float]:
    """Mean powers in free motion, with the shared motor (N,) and of one separate drive."""
    check_number("free_share", share, "1", Interval(ge=0, le=1))
    if power is None:
        require(share == 0, "free_power", None, "given with a free_share")
        return np.zeros(count), 0.0
    pair = isinstance(power, Sequence) and len(power) == 2
    require(pair, "free_power", repr(power), "powers with a shared motor and that of a separate drive", "W")
    together, alone = np.atleast_1d(real_array("free_power", power[0])), power[1]
    check_number("free_power", alone, "W", FINITE)
    fits = together.shape == (count,) and bool(np.all(np.isfinite(together)))
    require(fits, "free_power", f"shape {together.shape}", f"{count} finite values, one for each number of legs", "W")
    return together, float(alone)


def _mean(duty: np.ndarray, held: np.ndarray, idle: np.ndarray) -> np.ndarray:
    """Mean power by duty: (D, N, F) from powers (N, F)."""
    share = duty[:, None, None]
    # Not a product with a share of 0: a force beyond a limit has no power.
    return np.where(share > 0, share * held, 0.0) + (1.0 - share) * idle


def _mass(motor: Any) -> float:
    mass = getattr(motor, "mass", None)
    return float("nan") if mass is None else float(mass)


def _last_crossing(force: np.ndarray, excess: np.ndarray) -> float:
    """Force above which an excess stays negative, interpolated; inf if it never does, nan with undefined powers only."""
    known = np.isfinite(excess)
    if not known.any():
        return float("nan")
    force, excess = force[known], excess[known]
    if excess[-1] >= 0:
        return float("inf")
    above = np.flatnonzero(excess >= 0)
    if len(above) == 0:
        return float(force[0])
    at = above[-1]
    return float(force[at] + (force[at + 1] - force[at]) * excess[at] / (excess[at] - excess[at + 1]))
