"""Duty cycles: energy, limits and heating of a drive in a periodic motion or a run."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from infinivar._core.array_namespace import Array
from infinivar._core.frozen import FrozenDict
from infinivar._core.result import Frozen, Result, result
from infinivar.analysis.cycles import performance
from infinivar.analysis.cycles.single_strides import StrideEnergies, stride_energies
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import (
    Drive,
    MovingDrive,
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
from infinivar.limits import Demand, Limit, binding_demand, words_of
from infinivar.motion.duty_cycles import DutyCycle, Instants
from infinivar.parts import heat
from infinivar.parts.heat import Heat
from infinivar.transmission.rates import Varying
from infinivar.units import celsius, plain

POWERS = ("power_to_load_W", "power_from_supply_W")
"""Columns of powers, common to all drives."""

_SAME = 1e-3
"""Relative difference below which energies count as equal in the verdict."""


@result
class Holding(Frozen):
    """Power of a drive that holds a force at standstill.

    Attributes
    ----------
    force : float              Force held. [N]
    power : float              Supply power, ready to move, with the help of friction; nan if the drive cannot hold the force. [W]
    without_help : float       Supply power without the help of friction. [W]
    limit : Limit              Binding limit, with the help of friction.
    parked : float | None      Supply power with the cylinder stopped and the wheel locked; None without a cylinder. [W]
    run_up : float | None      Minimum energy to bring the cylinder back to speed. [J]
    """

    force: float
    power: float
    without_help: float
    limit: Limit
    parked: float | None
    run_up: float | None

    @property
    def pays_after(self) -> float | None:
        """Shortest standstill for which stopping the cylinder saves energy; None without a cylinder. [s]"""
        if self.parked is None or self.run_up is None:
            return None
        saved = self.power - self.parked
        return self.run_up / saved if saved > 0 else math.inf


class WithoutHelp(NamedTuple):
    """Result of a duty cycle without friction that helps to hold the load at rest."""

    energy: float
    """Energy from the supply per cycle or over the run. [J]"""
    feasible: bool
    """Whether every limit is kept and no winding overheats."""


@result
class DutyResult(Result):
    """Result of a drive in a duty cycle, settled and warm, or over a run. At rest, friction carries what it can of the load.

    Attributes
    ----------
    drive, duty          Arguments of the call.
    instants             Sampling instants of the cycle.
    point                Operating point at each instant, with windings at their settled mean temperature, or at their
                         temperature in the run.
    cold_power           Mean power from the supply with windings at 25 °C. [W]
    demands              Demand over allowance over the cycle, by limit and part. [-]
    heat                 Heating by motor ("motor", "steering motor"); None if the data sheet lacks a value.
    lacking              Missing values by motor.
    closure              Relative residual of the cycle's energy balance. [-]
    holding              Standstill under the largest force of the cycle.
    without_help         Result without friction that helps to hold; None if the load never rests.
    strides              Energies of the single strides that a recording averages; None for other motions.
    """

    name: str
    title: str
    drive: MovingDrive
    duty: DutyCycle
    instants: Instants
    point: MovingPoint
    cold_power: float
    demands: Mapping[Demand, float]
    heat: Mapping[str, Heat | None]
    lacking: Mapping[str, tuple[str, ...]]
    closure: float
    holding: Holding
    without_help: WithoutHelp | None
    strides: StrideEnergies | None = None

    @property
    def power_in(self) -> float:
        """Mean power from the supply. [W]"""
        return float(np.mean(self.point.power_in))

    @property
    def energy(self) -> float:
        """Energy from the supply per cycle, or over the run. [J]"""
        return self.power_in * self.duty.period

    @property
    def watt_hours(self) -> float:
        """Energy from the supply per hour. [W h]"""
        return self.power_in

    @property
    def energy_per_kilogram(self) -> float | None:
        """Energy from the supply per cycle and kilogram of `duty.reference_mass`; None without one. [J/kg]"""
        mass = self.duty.reference_mass
        return None if mass is None else self.energy / mass[0]

    @property
    def energy_per_metre(self) -> float | None:
        """Energy from the supply per metre of `duty.distance_per_cycle`; None without one. [J/m]"""
        covered = self.duty.distance_per_cycle
        return None if covered is None else self.energy / covered

    @property
    def powers(self) -> dict[str, float]:
        """Peak and net powers of the cycle, by the names of their keys in `to_dict`; nan where the wheel slips. [W]"""
        supply, load = np.asarray(self.point.power_in), np.asarray(self.point.power_out)
        found = {
            "power_from_supply_peak_W": float(np.max(supply)),
            "power_to_supply_peak_W": float(np.max(np.clip(-supply, 0.0, None))),
            "power_from_supply_net_W": self.power_in,
            "power_to_load_peak_W": float(np.max(np.clip(load, 0.0, None))),
            "power_of_load_peak_W": float(np.max(np.clip(-load, 0.0, None))),
            "power_to_load_net_W": float(np.mean(load)),
        }
        states = self.point.states
        if "motor_torque_Nm" in states and "motor_speed_rad_s" in states:
            shaft = np.abs(np.asarray(states["motor_torque_Nm"]) * np.asarray(states["motor_speed_rad_s"]))
            found["motor_shaft_power_peak_W"] = float(np.max(shaft))
        return found

    @property
    def delivered(self) -> float:
        """Work of the drive on the load per cycle or over the run, while driving. [J]"""
        return float(np.mean(np.clip(self.point.power_out, 0.0, None))) * self.duty.period

    @property
    def absorbed(self) -> float:
        """Work of the load on the drive per cycle or over the run, while braking. [J]"""
        return float(np.mean(np.clip(-np.asarray(self.point.power_out), 0.0, None))) * self.duty.period

    @property
    def losses(self) -> dict[str, float]:
        """Losses per cycle or over the run, by name. [J]"""
        return {name: float(np.mean(loss)) * self.duty.period for name, loss in self.point.losses.items()}

    @property
    def peaks(self) -> dict[str, float]:
        """Peak torque of each motor over its continuous torque, which limits only the RMS torque. [-]"""
        found = self.point.utilisation.items()
        return {what: float(np.max(demand)) for (limit, what), demand in found if limit == Limit.THERMAL}

    @property
    def exceeded(self) -> tuple[Demand, ...]:
        """Exceeded limits: slip first, then by decreasing demand."""
        found = [key for key, demand in self.demands.items() if demand > 1.0]
        return tuple(sorted(found, key=lambda key: (key[0] != Limit.SLIP, -self.demands[key])))

    @property
    def feasible(self) -> bool:
        """Whether every limit is kept and no winding overheats."""
        return not self.exceeded and _within_limits(self.heat)

    @property
    def tightest(self) -> tuple[Demand, float]:
        """The tightest limit and its margin, allowance over demand. [-]"""
        place, margin = binding_demand({key: np.asarray(demand) for key, demand in self.demands.items()})
        if place:
            return list(self.demands)[int(place) - 1], float(margin)
        worst = max(self.demands, key=lambda key: self.demands[key])
        return worst, float(margin)

    @property
    def verdict(self) -> str:
        """One-line verdict: feasibility, tightest limit, energy, heating."""
        known = {what: found for what, found in self.heat.items() if found is not None}
        hot = {what: found for what, found in known.items() if not found.within_limit}
        clauses = self._on_limits(hot)
        if math.isnan(self.power_in):
            return "; ".join(clauses)
        held = [
            f"{what} winding at {celsius(min(found.mean_winding, found.permissible))}" for what, found in hot.items()
        ]
        at = f" with {' and '.join(held)}" if held else ""
        clauses.append(f"{', '.join(self._on_energy())}{at}")
        if self.feasible:
            clauses += [f"{what} {found.verdict}" for what, found in known.items()]
        return "; ".join([*clauses, *self._on_help()])

    def _on_energy(self) -> list[str]:
        """Energy per cycle, per kilogram and metre where stated, mean and peak power."""
        found = [f"{plain(self.energy, 3)} J {self.duty.per}"]
        if self.energy_per_kilogram is not None:
            found.append(f"{plain(self.energy_per_kilogram, 3)} J/kg")
        if self.energy_per_metre is not None:
            found.append(f"{plain(self.energy_per_metre, 3)} J/m")
        peak = self.powers["power_from_supply_peak_W"]
        return [*found, f"{plain(peak, 3)} W at peak, {plain(self.power_in, 3)} W on average"]

    def _on_limits(self, hot: Mapping[str, Heat]) -> list[str]:
        """Name the exceeded limits and overheated windings, or the tightest limit if all are kept."""
        if self.feasible:
            key, margin = self.tightest
            if margin == math.inf:
                return ["feasible; no limit is loaded"]
            return [f"feasible; tightest limit: {words_of(key)} (margin {margin:.2f})"]
        overheating = [f"{what} {found.verdict}" for what, found in hot.items()]
        if not self.exceeded:
            infeasible = "infeasible in continuous operation" if self.duty.closed else "infeasible"
            return [f"{infeasible}: {clause}" for clause in overheating[:1]] + overheating[1:]
        worst, *others = self.exceeded
        return [
            f"infeasible: {words_of(worst)}, {_times(self.demands[worst])} the allowance",
            *(f"{words_of(key)}, {_times(self.demands[key])}" for key in others[:2]),
            *overheating,
        ]

    def _on_help(self) -> list[str]:
        """Say how friction that helps to hold the load affects the verdict, if it does."""
        bare = self.without_help
        if bare is None or not abs(bare.energy - self.energy) > _SAME * abs(self.energy):
            return []
        energy = f"{plain(bare.energy, 3)} J {self.duty.per}"
        if self.feasible and not bare.feasible:
            return [f"feasible only because friction helps to hold the load; without it {energy}"]
        return [f"without friction holding the load, {energy}"]

    @property
    def columns(self) -> dict[str, np.ndarray]:
        """Time histories under names that end in their unit: time, position, speed, force, `POWERS`, states of the drive.

        The force is that of the drive on the load, including the load's inertia; about a joint it is a moment, "moment_Nm".
        """
        course, point = self.instants.course, self.point
        shape = self.instants.time.shape
        force = course.driving_force(self.duty.moved_mass).value
        values = (self.instants.time, self.instants.position, course.speed, force, point.power_out, point.power_in)
        found = dict(zip(("time_s", *self.duty.axis.columns, *POWERS), values, strict=True))
        found |= {name: state for name, state in point.states.items() if name != "steering_tangent"}
        if "steering_tangent" in point.states:
            found["steering_angle_rad"] = np.arctan(point.states["steering_tangent"])
        return {name: np.broadcast_to(np.asarray(value, dtype=float), shape) for name, value in found.items()}

    def _energies(self) -> dict[str, float]:
        """Energies from the supply under names that end in their unit."""
        cold = self.cold_power * self.duty.period
        if not self.duty.closed:
            return {"energy_over_run_J": self.energy, "mean_power_W": self.power_in, "energy_over_run_cold_J": cold}
        return {
            "energy_per_cycle_J": self.energy,
            "energy_per_hour_Wh": self.watt_hours,
            "energy_per_cycle_cold_J": cold,
        }

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers, for scripts."""
        return {
            "title": self.title,
            "duty": self.duty.title,
            "verdict": self.verdict,
            "feasible": self.feasible,
            "closed": self.duty.closed,
            "period_s": self.duty.period,
            "samples": len(self.instants.time),
            **self._energies(),
            "energy_per_mass_J_kg": self.energy_per_kilogram,
            "energy_per_distance_J_m": self.energy_per_metre,
            **self.powers,
            "without_friction_at_rest": None if self.without_help is None else self.without_help._asdict(),
            "work_on_load_J": self.delivered,
            "work_of_load_J": self.absorbed,
            "losses_J": self.losses,
            "demands": {f"{limit.name} ({what})": demand for (limit, what), demand in self.demands.items()},
            "peak_torque_over_continuous": self.peaks,
            "heat": {
                what: None
                if found is None
                else {
                    "winding_C": found.winding - 273.15,
                    "housing_C": found.housing - 273.15,
                    "permissible_C": found.permissible - 273.15,
                    "time_to_limit_s": found.time_to_limit,
                    "verdict": found.verdict,
                }
                for what, found in self.heat.items()
            },
            "heat_lacks": {what: list(names) for what, names in self.lacking.items() if names},
            "holding": {
                self.duty.axis.columns[2]: self.holding.force,
                "power_W": self.holding.power,
                "power_without_friction_W": self.holding.without_help,
                "limit": self.holding.limit.name,
                "parked_W": self.holding.parked,
                "run_up_J": self.holding.run_up,
            },
            **({} if self.strides is None else {"single_strides": self.strides.to_dict()}),
            "closure": self.closure,
        }


def _times(demand: float) -> str:
    return f"{plain(demand, 3)} times" if math.isfinite(demand) else "beyond"


def duty_cycle(
    drive: MovingDrive,
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
    drive : MovingDrive   Any drive with the method `follow`; it must have the inertias that motion requires.
    duty : DutyCycle
    name, title : str         Names for reports.
    travel : float            End-to-end travel of the load; unlimited by default. [m]
    samples : int             Instants of the cycle; chosen from the motion by default.
    cylinder_speed : Varying  Cylinder speed of a cobotic drive at the instants; constant by default. [rad s^-1] ...

    Returns
    -------
    DutyResult   An exceeded limit is a result, not an error. Where the wheel slips, powers, energies and heat are nan. In
        a run, the continuous torque of a motor does not count where its temperature is known.

    Raises
    ------
    ParameterError
        If the drive lacks a value that motion requires, or its load moves along a line and the motion is about a joint or
        the reverse, or if the drive's speed would jump behind a series spring.
    AuditError
        If the energy balance of the cycle does not close.

    Source: faulring2006, section VI-C, for any motion; heat: maxon2020.
    """
    check_drive(drive, "drive", ("operate", "follow"))
    fault = axis_fault(drive, duty.axis, "the drive", "the motion") or smoothness_fault(
        drive, duty, "the drive", "motion"
    )
    if fault is not None:
        raise ParameterError(fault)
    instants = duty.instants(samples, orders_of(drive))
    course, mass = instants.course, duty.moved_mass
    options: dict[str, Any] = {} if cylinder_speed is None else {"cylinder_speed": cylinder_speed}

    def follow(driven: MovingDrive) -> MovingPoint:
        return followed(driven, course, load_mass=mass, **options)

    cold, point, found, lacking = _settled(drive, duty, instants, follow)
    demands = _demands(point, instants, travel, duty, found)
    without_help = None
    rests = np.broadcast_to(course.at_rest, instants.time.shape)
    if rests.any() and hasattr(drive, "unheld"):
        _, bare, hot, _ = _settled(
            drive, duty, instants, lambda driven: chosen(rests, follow(_unheld(driven)), follow(driven))
        )
        kept = all(demand <= 1.0 for demand in _demands(bare, instants, travel, duty, hot).values())
        without_help = WithoutHelp(float(np.mean(bare.power_in)) * duty.period, kept and _within_limits(hot))
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
        closure=performance.audit(point, duty.title or duty.motion.shape),
        holding=_largest_hold(drive, instants, mass),
        without_help=without_help,
        strides=stride_energies(drive, duty),
    )


def _settled(
    drive: MovingDrive, duty: DutyCycle, instants: Instants, follow: Callable[[Any], MovingPoint]
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


def _within_limits(heats: Mapping[str, Heat | None]) -> bool:
    return all(found is None or found.within_limit for found in heats.values())


def _unheld(drive: Any) -> Any:
    """The drive without friction that helps to hold a load; itself if it does not say what that is."""
    return drive.unheld() if hasattr(drive, "unheld") else drive


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
        if drive.cylinder_inertia is not None:
            run_up = 0.5 * drive.turning_inertia * drive.cylinder_speed**2
    return Holding(
        force=force,
        power=float(point.power_in),
        without_help=float(bare.power_in),
        limit=Limit(int(point.limit)),
        parked=parked,
        run_up=run_up,
    )


def motors_of(drive: Any) -> dict[str, Any]:
    """Motors by their name in demands; none of a drive of another package that cannot be warmed."""
    if not isinstance(drive, (CoboticDrive, ConventionalDrive)) and not hasattr(drive, "warmed"):
        return {}
    return {
        "motor" if role in ("motor", "cylinder") else f"{role} motor": motor for role, motor in drive.motors.items()
    }


def heating(point: MovingPoint, what: str) -> tuple[Array, Array]:
    """Heat sources of a motor at each instant: current, and power of friction and iron loss. [A], [W]"""
    prefix, tag = ("steering ", "steering_") if what == "steering motor" else ("", "motor_")
    housing = point.losses[f"{prefix}motor friction"]
    if f"{prefix}motor iron" in point.losses:
        housing = housing + point.losses[f"{prefix}motor iron"]
    return point.states[f"{tag}current_A"], housing


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
