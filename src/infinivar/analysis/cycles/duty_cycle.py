"""Duty cycles: energy, limits and heating of a drive in a periodic motion or a run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from infinivar._core.array_namespace import Array
from infinivar._core.frozen import FrozenDict
from infinivar._core.plugins import is_own
from infinivar.analysis.cycles import performance
from infinivar.analysis.cycles.duty_result import DutyResult, Holding, WithoutHelp, within_limits
from infinivar.analysis.cycles.performance import heating, motors_of
from infinivar.analysis.cycles.single_strides import stride_energies
from infinivar.drivetrain import extension_checks
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import (
    Drive,
    MovingPoint,
    axis_fault,
    check_drive,
    chosen,
    followed,
    operated,
    orders_of,
    smoothness_fault,
)
from infinivar.errors import ParameterError
from infinivar.limits import Demand, Limit
from infinivar.motion.duty_cycles import DutyCycle, Instants, check_duty_cycle
from infinivar.parts import heat
from infinivar.parts.heat import Heat
from infinivar.transmission.rates import Varying


def duty_cycle(
    drive: Drive,
    duty: DutyCycle,
    *,
    name: str = "",
    title: str = "",
    travel: float | None = None,
    samples: int | None = None,
    cylinder_speed: Varying | None = None,
) -> DutyResult:
    """Evaluate a drive in a duty cycle by inverse dynamics: settled and warm, or over a run from the start temperature.

    Parameters
    ----------
    drive : Drive         Any drive with the method `follow`; it must have the inertias that motion requires.
    duty : DutyCycle
    name, title : str         Names for reports.
    travel : float            End-to-end travel of the load; unlimited by default. [m]
    samples : int             Instants of the cycle; chosen from the motion by default.
    cylinder_speed : Varying  Cylinder speed of a cobotic drive at the instants; constant by default. [rad s^-1] ...

    Returns
    -------
    DutyResult   An exceeded limit is a result, not an error. Where the wheel slips or a linkage cannot reach, powers,
        energies and heat are nan. In a run, the continuous torque of a motor does not count where its temperature is known.

    Raises
    ------
    ParameterError
        If the drive lacks a value that motion requires, or its load moves along a line and the motion is about a joint or
        the reverse, if the drive's speed would jump behind a series spring, or if a power exceeds all numbers.
    AuditError
        If the energy balance of the cycle does not close, or a loss is negative.

    Source: faulring2006, section VI-C, for any motion; heat: maxon2020.
    """
    check_duty_cycle(duty)
    instants, follow = _prepared(drive, duty, samples, cylinder_speed)
    course, mass = instants.course, duty.moved_mass
    where = _where(duty)
    cold, point, found, lacking = _settled(drive, duty, instants, follow)
    closure = performance.audit(point, where)
    # Also of the program's own drives, in which a part may be of another package.
    extension_checks.check_losses(point.losses, point.power_in, point.power_out, where)
    if duty.closed and is_own(drive):
        extension_checks.check_returned(point.stored, f"{type(drive).__name__}.follow in {where}")
    demands = _demands(point, instants, travel, duty, found)
    without_help = None
    rests = np.broadcast_to(course.at_rest, instants.time.shape)
    if rests.any() and hasattr(drive, "without_static_friction"):
        _, bare, hot, _ = _settled(
            drive, duty, instants, lambda driven: chosen(rests, follow(_unheld(driven)), follow(driven))
        )
        kept = all(demand <= 1.0 for demand in _demands(bare, instants, travel, duty, hot).values())
        without_help = WithoutHelp(float(np.mean(bare.power_in)) * duty.period, kept and within_limits(hot))
    return DutyResult(
        name=name,
        title=title or name,
        drive=drive,
        duty=duty,
        instants=instants,
        point=point,
        cold_power=float(np.mean(cold.power_in)),
        demands=FrozenDict(demands),
        heat=FrozenDict(found),
        lacking=FrozenDict(lacking),
        closure=closure,
        holding=_largest_hold(drive, instants, mass),
        without_help=without_help,
        strides=stride_energies(drive, duty),
    )


def energy_and_feasibility(
    drive: Drive, duty: DutyCycle, travel: float | None = None, spare: float = 0.0
) -> tuple[float, bool]:
    """What decides between drives in a duty cycle: `DutyResult.energy` [J] and `DutyResult.feasible`, and nothing else.

    `spare` is the demand above 1 that still counts as within a limit.

    Raises
    ------
    ParameterError, AuditError
        As `duty_cycle`.
    """
    instants, follow = _prepared(drive, duty)
    _, point, found, _ = _settled(drive, duty, instants, follow)
    performance.audit(point, _where(duty))
    demands = _demands(point, instants, travel, duty, found)
    exceeded = any(demand > 1.0 + spare for demand in demands.values())
    return float(np.mean(point.power_in)) * duty.period, not exceeded and within_limits(found)


def _where(duty: DutyCycle) -> str:
    return duty.title or duty.motion.shape


def _prepared(
    drive: Drive, duty: DutyCycle, samples: int | None = None, cylinder_speed: Varying | None = None
) -> tuple[Instants, Callable[[Any], MovingPoint]]:
    """Instants of a cycle, and the function that moves a drive through them; ParameterError if it cannot follow."""
    check_drive(drive, "drive", ("operate", "follow"))
    fault = axis_fault(drive, duty.axis, "the drive", "the motion") or smoothness_fault(
        drive, duty, "the drive", "motion"
    )
    if fault is not None:
        raise ParameterError(fault)
    instants = duty.instants(samples, orders_of(drive))
    options: dict[str, Any] = {} if cylinder_speed is None else {"cylinder_speed": cylinder_speed}

    def follow(driven: Drive) -> MovingPoint:
        with np.errstate(over="ignore", invalid="ignore"):  # refused just below
            point = followed(driven, instants.course, load_mass=duty.moved_mass, **options)
        if np.any(np.isinf(point.power_in)):
            raise ParameterError(
                f"{_where(duty)}: the power exceeds all numbers; look for a value far too large or too small"
            )
        return point

    return instants, follow


def _settled(
    drive: Drive, duty: DutyCycle, instants: Instants, follow: Callable[[Any], MovingPoint]
) -> tuple[MovingPoint, MovingPoint, dict[str, Heat | None], dict[str, tuple[str, ...]]]:
    """Evaluate the cycle with cold and with settled windings, or those of the run; also heating, and missing data by motor."""
    cold = follow(drive)
    lacking = {what: tuple(heat.missing(motor)) for what, motor in motors_of(drive).items()}
    found = {what: None if lacking[what] else _heat(drive, what, cold, duty) for what in lacking}
    # A motor whose winding overheats must be stopped: its winding counts as at the permissible temperature.
    warm = {
        what: np.minimum(np.interp(instants.time, hot.time, hot.winding_history), hot.permissible)
        if not hot.repeated
        else min(hot.mean_winding, hot.permissible)
        for what, hot in found.items()
        if hot is not None
    }
    point = follow(warmed(drive, warm))
    shape = instants.time.shape
    point = replace(
        point, power_in=np.broadcast_to(point.power_in, shape), power_out=np.broadcast_to(point.power_out, shape)
    )
    return cold, point, found, lacking


def _demands(
    point: MovingPoint, instants: Instants, travel: float | None, duty: DutyCycle, heats: Mapping[str, Heat | None]
) -> dict[Demand, float]:
    found = {key: float(demand) for key, demand in performance.demands(point).items()}
    if not duty.closed:
        # Continuous torque stands for the temperature that it settles at, which a run need not reach.
        known = {(Limit.THERMAL, what) for what, hot in heats.items() if hot is not None}
        found = {key: demand for key, demand in found.items() if key not in known}
    if travel is not None:
        found[Limit.TRAVEL, "load"] = float(np.ptp(instants.position)) / travel
    return found


def _unheld(drive: Any) -> Any:
    """The drive without friction that helps to hold a load; itself if it does not say what that is."""
    return drive.without_static_friction() if hasattr(drive, "without_static_friction") else drive


def _largest_hold(drive: Drive, instants: Instants, mass: float) -> Holding:
    """Standstill under the largest force of a cycle; with springs or a linkage, at that force's instant and sign."""
    force = np.asarray(instants.course.driving_force(mass).value)
    output = getattr(drive, "output", None)
    if output is None or not output.chain:
        return holding(drive, float(np.max(np.abs(force))))
    place = int(np.argmax(np.abs(force)))
    spread = np.broadcast_to(force, instants.time.shape)
    return holding(drive, float(spread[place]), position=float(instants.position[place]))


def holding(drive: Drive, force: float, *, position: float = 0.0) -> Holding:
    """Power of a drive that holds a force at standstill, with and without the help of friction.

    The position of the load matters for springs and linkages.

    With the cylinder stopped, the locked wheel holds any force below slip without power; the amplifiers draw standby power
    only.
    """
    point, bare = (operated(held, speed=0.0, force=force, position=position) for held in (drive, _unheld(drive)))
    parked = run_up = None
    if isinstance(drive, CoboticDrive):
        parked = drive.amplifier.standby_power
        if drive.inertia_of_cylinder is not None:
            run_up = 0.5 * drive.turning_inertia * drive.cylinder_speed**2
    return Holding(
        force=force,
        power=float(point.power_in),
        without_help=float(bare.power_in),
        limit=Limit(int(point.limit)),
        parked=parked,
        run_up=run_up,
    )


def _heat(drive: Any, what: str, point: MovingPoint, duty: DutyCycle) -> Heat | None:
    current, friction = heating(point, what)
    if np.any(np.isnan(current)):
        return None
    if not duty.closed:
        motor, friction = motors_of(drive)[what], np.asarray(friction)
        return heat.heat_over_run(
            motor, np.asarray(current), friction, duty.period, ambient=duty.ambient, start=duty.start
        )
    return heat.heat(motors_of(drive)[what], np.asarray(current), friction, duty.period, duty.ambient)


def warmed(drive: Any, temperatures: Mapping[str, Array]) -> Any:
    """The drive with its windings at given temperatures."""
    if not isinstance(drive, (CoboticDrive, ConventionalDrive)):
        return drive.warmed(temperatures) if temperatures else drive
    if "motor" in temperatures:
        drive = replace(drive, motor=heat.warm(drive.motor, temperatures["motor"]))
    if "steering motor" in temperatures and isinstance(drive, CoboticDrive) and drive.steering is not None:
        steering = drive.steering
        drive = replace(
            drive, steering=replace(steering, motor=heat.warm(steering.motor, temperatures["steering motor"]))
        )
    return drive
