"""What a drive does over one period of a motion: demands, mean powers, and the definitions of performance."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from annotated_types import Interval

from infinivar._core.fields import check, component, quantity
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import MovingPoint
from infinivar.errors import AuditError
from infinivar.limits import Demand, Limit
from infinivar.motion.course import Course
from infinivar.parts.amplifier import Amplifier, Regeneration
from infinivar.power import AUDIT_TOLERANCE
from infinivar.units import percent, plain

AnyDrive = CoboticDrive | ConventionalDrive

Measure = Literal["exchange", "round trip", "printed"]

_RMS = (Limit.THERMAL, Limit.GEAR)
"""What heats or tires a part: its root mean square counts, not its peak."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Definition:
    """What performance over a cycle means. The default is as the paper seems to have it.

    `measure`:

    - ``exchange``: energy exchanged with the load, driving and braking both counted, over energy taken from the supply. May
      exceed 1, as the load's own energy comes back; nan where nothing is taken.
    - ``round trip``: energy that arrives, at the load when it is driven and at the supply when it is stored, over energy that
      sets out. A lossless drive has 1 if all that comes back is stored, a half if it is burnt.
    - ``printed``: the mean over time of load power over electrical power, sizes only, as the paper prints it. Electrical
      power passes zero, so the value depends on the samples and converges to nothing.

    `returned`: negative electrical power is burnt, stored with `storage_efficiency`, or cannot be taken at all (a limit).
    `common_bus`: one motor's returned power feeds the other first; else each motor's is clipped before they are added.
    `torque`: whether a motor's continuous torque bounds the root mean square of its torque, or the peak.

    Raises
    ------
    ParameterError
        If a choice is not one of those, or the storage efficiency is missing or out of range.

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
        """Refuse what is not a definition."""
        check(self)
        self.amplifier(Amplifier())

    def amplifier(self, given: Amplifier) -> Amplifier:
        """An amplifier that treats negative power as this definition does."""
        return replace(given, regeneration=self.returned, storage_efficiency=self.storage_efficiency)

    @property
    def words(self) -> str:
        """The definition in a few words, for figures."""
        measure = {
            "exchange": "energy exchanged with the load over energy taken from the supply",
            "round trip": "energy that arrives over energy that sets out",
            "printed": "mean of load power over electrical power",
        }[self.measure]
        returned = {
            "burn": "burnt",
            "store": f"stored at {percent(self.storage_efficiency or 0.0)}",
            "none": "not possible",
        }[self.returned]
        bus = "one DC bus" if self.common_bus else "each motor by itself"
        torque = {"rms": "RMS", "peak": "peak"}[self.torque]
        return f"{measure}; negative electrical power {returned}, {bus}; continuous torque bounds the {torque} torque"


PAPER = Definition()
"""As the paper seems to have it."""


Cylinder = Literal["constant", "flywheel"]
"""What the cylinder does: turn at constant speed, or at what a constant torque and its inertia make of it."""


def follow(
    drive: AnyDrive,
    course: Course,
    load_mass: Any,
    definition: Definition,
    *,
    cylinder: Cylinder = "constant",
    period: Any = None,
) -> MovingPoint:
    """Instants of a course under a definition's treatment of negative power; a flywheel needs the period. [s]"""
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


def demands(point: MovingPoint, torque: Literal["rms", "peak"] = "rms") -> dict[Demand, np.ndarray]:
    """Demand over allowance of each limit over a cycle: the last axis of the instants.

    Continuous torques of motors (unless `torque` says peak) and gearheads are held against the root mean square, all
    other limits against the peak. nan where the wheel slips, but for slip itself. [-]
    """
    shape = np.shape(point.power_out)
    found = {}
    for (limit, what), demand in point.utilisation.items():
        if np.ndim(demand) == 0:
            found[limit, what] = np.full(shape[:-1], float(demand))
        elif limit in _RMS and (torque == "rms" or limit == Limit.GEAR):
            found[limit, what] = np.sqrt(np.mean(np.square(demand), axis=-1))
        else:
            found[limit, what] = np.max(demand, axis=-1)
    return found


def mean(values: Any, shape: tuple[int, ...]) -> np.ndarray:
    """Mean over a cycle, of what may be the same at all instants."""
    return np.broadcast_to(np.mean(values, axis=-1) if np.ndim(values) else values, shape[:-1])


def means(group: Mapping[str, Any], shape: tuple[int, ...]) -> dict[str, np.ndarray]:
    """Mean of each over a cycle. [W]"""
    return {name: mean(values, shape) for name, values in group.items()}


def electrical_power(point: MovingPoint) -> Any:
    """Power at the terminals of all motors together, as it comes. [W]"""
    states = point.states
    found = states["motor_current_A"] * states["motor_voltage_V"]
    if "steering_current_A" in states:
        found = found + states["steering_current_A"] * states["steering_voltage_V"]
    return found


def performance(point: MovingPoint, measure: Measure = "exchange") -> np.ndarray:
    """Performance over a cycle, the last axis of the instants; limits are not looked at.

    Parameters
    ----------
    point : MovingPoint   At midpoints of equal steps of time.
    measure               See `Definition`.

    Returns
    -------
    (...,) float   nan where nothing is spent, and where the wheel slips. [-]

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
    """Energy of a cycle that is not accounted for, over the energy moved; nan where the wheel slips. [-]

    At each instant what the supply gives is what the load gets, what is lost and what flows into the drive's inertias.
    """
    missing = np.asarray(point.power_in - point.power_out)
    for flow in (*point.losses.values(), *point.stored.values()):
        missing = missing - flow
    moved = np.mean(np.abs(point.power_in) + np.abs(point.power_out), axis=-1)
    return np.abs(np.mean(missing, axis=-1)) / (moved + 1e-300)


def audit(point: MovingPoint, where: str) -> float:
    """Largest closure error over all cycles that are possible.

    Raises
    ------
    AuditError
        If it exceeds `infinivar.power.AUDIT_TOLERANCE`.
    """
    worst = float(np.fmax.reduce(closure(point), axis=None, initial=0.0))
    if not worst <= AUDIT_TOLERANCE:
        raise AuditError(f"{where}: the energy of a cycle misses {plain(worst, 3)} of what is moved")
    return worst
