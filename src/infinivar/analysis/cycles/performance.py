"""Drive over one period of a motion: demands, mean powers, and definitions of performance."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from annotated_types import Interval

from infinivar._core.array_namespace import Array, namespace
from infinivar._core.fields import check, component, quantity
from infinivar.drivetrain import extension_checks
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import DrivePoint, MovingPoint
from infinivar.errors import AuditError, ParameterError
from infinivar.limits import ROOT_MEAN_SQUARE, Demand, Limit
from infinivar.motion.course import Course
from infinivar.parts import heat
from infinivar.parts.amplifier import Amplifier, Regeneration
from infinivar.power import AUDIT_TOLERANCE
from infinivar.units import percent, plain

AnyDrive = CoboticDrive | ConventionalDrive

Measure = Literal["exchange", "round trip", "printed"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Definition:
    """Definition of performance over a cycle. The default is the most likely reading of the paper.

    `measure`:

    - ``exchange``: energy exchanged with the load, in driving and braking, over energy from the supply. May exceed 1, as the
      load returns its own energy; nan if the supply gives none.
    - ``round trip``: energy received, by the load when driven and by the supply when stored, over energy sent. 1 for a
      lossless drive that stores all returned energy, 0.5 if it burns it.
    - ``printed``: the time average of load power over electrical power, in magnitude, as printed in the paper. Electrical
      power crosses zero, so the value depends on the samples and does not converge.

    `returned`: negative electrical power is burnt, stored with `storage_efficiency`, or not accepted (a limit).
    `common_bus`: returned power of one motor first feeds the other; else each motor's power is clipped before the sum.
    `torque`: whether the continuous torque limits a motor's RMS torque or its peak torque.

    Raises
    ------
    ParameterError
        If a choice is unknown, or the storage efficiency is missing or out of range.

    Source: faulring2006, section VI-C.
    """

    measure: Measure = component("exchange, round trip or printed", default="exchange")
    returned: Regeneration = component("What happens to negative electrical power", default="burn")
    storage_efficiency: float | None = quantity(
        "1", Interval(ge=0, le=1), "Share of it stored and given back", default=None
    )
    common_bus: bool = component("Whether the motors share one DC bus", default=False)
    torque: Literal["rms", "peak"] = component("What the continuous torque bounds", default="rms")

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        self.amplifier(Amplifier())

    def amplifier(self, given: Amplifier) -> Amplifier:
        """An amplifier that treats negative power as this definition does."""
        return replace(given, regeneration=self.returned, storage_efficiency=self.storage_efficiency)

    @property
    def words(self) -> str:
        """Short description for figures."""
        measure = {
            "exchange": "energy exchanged with the load over energy from the supply",
            "round trip": "energy received over energy sent",
            "printed": "mean of load power over electrical power",
        }[self.measure]
        returned = {
            "burn": "burnt",
            "store": f"stored at {percent(self.storage_efficiency or 0.0)}",
            "none": "not possible",
        }[self.returned]
        bus = "one DC bus" if self.common_bus else "separate motor supplies"
        torque = {"rms": "RMS", "peak": "peak"}[self.torque]
        return f"{measure}; negative electrical power {returned}, {bus}; continuous torque limits the {torque} torque"


PAPER = Definition()
"""Most likely definition of the paper."""


Cylinder = Literal["constant", "flywheel"]
"""Cylinder at constant speed, or free-running under constant torque and its inertia."""


def follow(
    drive: AnyDrive,
    course: Course,
    load_mass: Any,
    definition: Definition,
    *,
    cylinder: Cylinder = "constant",
    period: Any = None,
) -> MovingPoint:
    """Operating points of a course, with negative power treated as defined; a flywheel requires the period. [s]"""
    if not isinstance(drive, (CoboticDrive, ConventionalDrive)):
        raise ParameterError(
            f"a drive of type {type(drive).__name__} has no amplifier that a definition of performance could replace"
        )
    drive = replace(drive, amplifier=definition.amplifier(drive.amplifier))
    if not isinstance(drive, CoboticDrive):
        return drive.follow(course, load_mass=load_mass)
    if cylinder == "constant":
        return drive.follow(course, load_mass=load_mass, common_bus=definition.common_bus)
    turning = drive.coast(course, period=period, load_mass=load_mass)
    point = drive.follow(course, load_mass=load_mass, cylinder_speed=turning, common_bus=definition.common_bus)
    stops = np.any(np.isnan(turning.value), axis=-1, keepdims=True)
    limits = {
        **point.utilisation,
        (Limit.SLIP, "wheel"): np.where(stops, 0.0, point.utilisation[Limit.SLIP, "wheel"]),
        (Limit.FLYWHEEL, "cylinder"): np.where(stops, np.inf, 0.0) + np.zeros(np.shape(turning.value)),
    }
    return replace(point, utilisation=limits)


def demands(point: MovingPoint, torque: Literal["rms", "peak"] = "rms") -> dict[Demand, Array]:
    """Demand over allowance of each limit over a cycle, the last axis of the instants. [-]

    Continuous torques of motors (unless `torque` is peak) and gearheads limit the root mean square, the rated life of a screw
    the cubic mean, all other limits the peak. Where the wheel slips, all but slip are nan.
    """
    xp = namespace(point.power_out, *point.utilisation.values())
    shape = np.shape(point.power_out)
    found = {}
    for (limit, what), demand in point.utilisation.items():
        if np.ndim(demand) == 0:
            found[limit, what] = xp.full(shape[:-1], demand, dtype=xp.float64)
        elif limit == Limit.LIFE:
            found[limit, what] = xp.mean(xp.abs(demand) ** 3, axis=-1) ** (1.0 / 3.0)
        elif limit in ROOT_MEAN_SQUARE and (torque == "rms" or limit == Limit.GEAR):
            found[limit, what] = xp.sqrt(xp.mean(xp.square(demand), axis=-1))
        else:
            found[limit, what] = xp.max(demand, axis=-1)
    return found


def mean(values: Any, shape: tuple[int, ...]) -> np.ndarray:
    """Mean over a cycle of values that may be constant."""
    return np.broadcast_to(np.mean(values, axis=-1) if np.ndim(values) else values, shape[:-1])


def means(group: Mapping[str, Any], shape: tuple[int, ...]) -> dict[str, np.ndarray]:
    """Mean of each value over a cycle. [W]"""
    return {name: mean(values, shape) for name, values in group.items()}


def electrical_power(point: MovingPoint) -> Any:
    """Signed power at the terminals of all motors together. [W]"""
    states = point.states
    found = states["motor_current_A"] * states["motor_voltage_V"]
    if "steering_current_A" in states:
        found = found + states["steering_current_A"] * states["steering_voltage_V"]
    return found


def performance(point: MovingPoint, measure: Measure = "exchange") -> np.ndarray:
    """Performance over a cycle, the last axis of the instants, regardless of limits.

    Parameters
    ----------
    point : MovingPoint   At midpoints of equal steps of time.
    measure               See `Definition`.

    Returns
    -------
    (...,) float   nan if no energy is spent or the wheel slips. [-]

    Source: faulring2006, section VI-C.
    """
    out, drawn = np.asarray(point.power_out), np.broadcast_to(point.power_in, np.shape(point.power_out))
    if measure == "printed":
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.mean(np.abs(out / electrical_power(point)), axis=-1)
    if measure == "exchange":
        gained, spent = np.mean(np.abs(out), axis=-1), np.mean(drawn, axis=-1)
    else:
        gained = np.mean(np.clip(out, 0.0, None) + np.clip(-drawn, 0.0, None), axis=-1)
        spent = np.mean(np.clip(drawn, 0.0, None) + np.clip(-out, 0.0, None), axis=-1)
    return np.where(spent > 0, gained, np.nan) / np.where(spent > 0, spent, 1.0)


def closure(point: MovingPoint) -> np.ndarray:
    """Residual of a cycle's energy balance over the energy moved; nan where the wheel slips. [-]

    At each instant, supply power equals load power plus losses plus power into the drive's inertias.
    """
    moved = np.mean(np.abs(point.power_in) + np.abs(point.power_out), axis=-1)
    return np.abs(np.mean(extension_checks.unbalanced(point), axis=-1)) / (moved + 1e-300)


def audit(point: MovingPoint, where: str) -> float:
    """Largest closure error over all feasible cycles, whose balance of power also closes at each instant.

    Raises
    ------
    AuditError
        If either exceeds `infinivar.power.AUDIT_TOLERANCE`, at an instant relative to the largest power.
    """
    extension_checks.check_balance(point, where)
    worst = float(np.fmax.reduce(closure(point), axis=None, initial=0.0))
    if not worst <= AUDIT_TOLERANCE:
        raise AuditError(f"{where}: the energy balance of a cycle does not close; relative residual {plain(worst, 3)}")
    return worst


def motors_of(drive: Any) -> dict[str, Any]:
    """Motors by their name in demands; none of a drive of another package that cannot be warmed."""
    if not isinstance(drive, (CoboticDrive, ConventionalDrive)) and not hasattr(drive, "warmed"):
        return {}
    return {
        "motor" if role in ("motor", "cylinder") else f"{role} motor": motor for role, motor in drive.motors.items()
    }


def heating(point: DrivePoint | MovingPoint, what: str) -> tuple[Array, Array]:
    """Heat sources of a motor at each instant: current, and power of friction and iron loss. [A], [W]"""
    prefix = "steering " if what == "steering motor" else ""
    housing = point.losses[f"{prefix}motor friction"]
    if f"{prefix}motor iron" in point.losses:
        housing = housing + point.losses[f"{prefix}motor iron"]
    return point.states[current_of(what)], housing


def current_of(what: str) -> str:
    """Name of a motor's current among the states of a drive."""
    return "steering_current_A" if what == "steering motor" else "motor_current_A"


def windings_after(
    drive: Any,
    point: DrivePoint | MovingPoint,
    period: float,
    time: float,
    *,
    ambient: float,
    start: float | None = None,
) -> dict[str, float]:
    """Highest winding temperature up to a time after a cold start, by motor that has a current and thermal data.

    Parameters
    ----------
    drive : Drive
    point          The drive at the instants of a cycle that it repeats, or a steady point that it holds.
    period : float         Of the cycle; a run and a steady point need at least the time. [s]
    time : float           Since the start. [s]
    ambient, start : float   Ambient temperature, and that of the motors at the start, by default the same. [K]

    Returns
    -------
    dict of str to float   [K]; nan where no steady motion exists, inf where a winding runs away.

    Source: maxon2020; see `infinivar.parts.heat`.
    """
    found = {}
    for what, motor in motors_of(drive).items():
        if heat.missing(motor) or current_of(what) not in point.states:
            continue
        current, friction = (np.asarray(one) for one in heating(point, what))
        found[what] = (
            math.nan
            if np.any(np.isnan(current))
            else heat.highest_until(motor, current, friction, period, time, ambient=ambient, start=start)
        )
    return found
