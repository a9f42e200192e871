"""Results of a drive in a duty cycle: energy, limits, heating, and the power to hold still."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from infinivar._core.described import at, derived, reported
from infinivar._core.result import Frozen, Result, result
from infinivar.analysis.cycles.performance import motors_of, windings_after
from infinivar.analysis.cycles.single_strides import StrideEnergies
from infinivar.drivetrain.drive import (
    Drive,
    MovingPoint,
)
from infinivar.errors import ParameterError
from infinivar.limits import LEADING, Demand, Limit, binding_demand, words_of
from infinivar.motion.duty_cycles import DutyCycle, Instants
from infinivar.parts.heat import Heat
from infinivar.units import celsius, margin_words, plain, times

POWERS = ("power_to_load_W", "power_from_supply_W")
"""Columns of powers, common to all drives."""

_TORQUES = {"motor": "motor_torque_Nm", "steering motor": "steering_torque_Nm"}
"""Columns of the torques at the motors' shafts."""

_ROUNDING = 1e-10
"""Mean over peak power below which a mean is rounding."""

_TIME = ("time",)
_SAME = 1e-3
"""Relative difference below which energies count as equal in the verdict."""


@result
class Holding(Frozen):
    """Power of a drive that holds a force at standstill, with its windings as given to it: cold, unless warmed.

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
    power: float = reported("W")
    without_help: float = reported("W", key="power_without_friction_W")
    limit: Limit = reported()
    parked: float | None = reported("W")
    run_up: float | None = reported("J")

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


def _some(lacking: Mapping[str, tuple[str, ...]]) -> dict[str, tuple[str, ...]]:
    return {what: names for what, names in lacking.items() if names}


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
    title: str = reported(attribute="title")
    drive: Drive
    duty: DutyCycle
    instants: Instants
    point: MovingPoint
    cold_power: float
    demands: Mapping[Demand, float] = reported("1")
    heat: Mapping[str, Heat | None] = reported()
    lacking: Mapping[str, tuple[str, ...]] = reported(key="heat_lacks", convert=_some)
    closure: float = reported("1")
    holding: Holding
    without_help: WithoutHelp | None = reported(key="without_friction_at_rest")
    strides: StrideEnergies | None = reported(key="single_strides", optional=True, default=None)

    _also = (
        at("duty.title", key="duty"),
        at("duty.closed"),
        at("duty.period", "s"),
        at("instants.time.size", key="samples"),
    )

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

    @derived("J/kg", key="energy_per_mass_J_kg")
    def energy_per_kilogram(self) -> float | None:
        """Energy from the supply per cycle and kilogram of `duty.reference_mass`; None without one. [J/kg]"""
        mass = self.duty.reference_mass
        return None if mass is None else self.energy / mass[0]

    @derived("J/m", key="energy_per_distance_J_m")
    def energy_per_metre(self) -> float | None:
        """Energy from the supply per metre of `duty.distance_per_cycle`; None without one. [J/m]"""
        covered = self.duty.distance_per_cycle
        return None if covered is None else self.energy / covered

    @derived(key="*")
    def powers(self) -> dict[str, float]:
        """Peak and net powers of the cycle, by their keys in `to_dict`; nan in slip or where a linkage cannot reach. [W]"""
        supply, load = np.asarray(self.point.power_in), np.asarray(self.point.power_out)
        found = {
            "power_from_supply_peak_W": float(np.max(supply)),
            "power_to_supply_peak_W": float(np.max(np.clip(-supply, 0.0, None))),
            "power_from_supply_net_W": self.power_in,
            "power_to_load_peak_W": float(np.max(np.clip(load, 0.0, None))),
            "power_of_load_peak_W": float(np.max(np.clip(-load, 0.0, None))),
            "power_to_load_net_W": _net(load),
        }
        states = self.point.states
        if "motor_torque_Nm" in states and "motor_speed_rad_s" in states:
            shaft = np.abs(np.asarray(states["motor_torque_Nm"]) * np.asarray(states["motor_speed_rad_s"]))
            found["motor_shaft_power_peak_W"] = float(np.max(shaft))
        return found

    @derived("J", key="work_on_load_J")
    def delivered(self) -> float:
        """Work of the drive on the load per cycle or over the run, while driving. [J]"""
        return float(np.mean(np.clip(self.point.power_out, 0.0, None))) * self.duty.period

    @derived("J", key="work_of_load_J")
    def absorbed(self) -> float:
        """Work of the load on the drive per cycle or over the run, while braking. [J]"""
        return float(np.mean(np.clip(-np.asarray(self.point.power_out), 0.0, None))) * self.duty.period

    @derived("J")
    def losses(self) -> dict[str, float]:
        """Losses per cycle or over the run, by name. [J]"""
        return {name: float(np.mean(loss)) * self.duty.period for name, loss in self.point.losses.items()}

    @derived("1", key="peak_torque_over_continuous")
    def peaks(self) -> dict[str, float]:
        """Peak torque at each motor's shaft over its continuous torque, which limits only the RMS; nan on slip. [-]"""
        states, motors = self.point.states, motors_of(self.drive)
        return {
            what: float(np.max(np.abs(states[column]))) / motors[what].continuous_torque
            for what, column in _TORQUES.items()
            if what in motors and column in states
        }

    @derived("1", key="peak_current_over_continuous")
    def current_peaks(self) -> dict[str, float]:
        """Peak current of each motor over its current at continuous torque, which includes no-load current. [-]"""
        found = self.point.utilisation.items()
        return {what: float(np.max(demand)) for (limit, what), demand in found if limit == Limit.THERMAL}

    @property
    def exceeded(self) -> tuple[Demand, ...]:
        """Exceeded limits: a linkage out of reach, then slip, then the others by decreasing demand."""
        found = [key for key, demand in self.demands.items() if demand > 1.0]
        return tuple(
            sorted(found, key=lambda key: (-LEADING.index(key[0]) if key[0] in LEADING else 1, -self.demands[key]))
        )

    @derived()
    def feasible(self) -> bool:
        """Whether every limit is kept and no winding overheats."""
        return not self.exceeded and within_limits(self.heat)

    @property
    def tightest(self) -> tuple[Demand, float]:
        """The tightest limit and its margin, allowance over demand; for winding temperatures, of rises above ambient. [-]"""
        demands = {
            **self.demands,
            **{(Limit.TEMPERATURE, what): hot.demand for what, hot in self._known_heat().items()},
        }
        if not demands:
            return (Limit.OK, "load"), math.inf
        place, margin = binding_demand({key: np.asarray(demand) for key, demand in demands.items()})
        if place:
            return list(demands)[int(place) - 1], float(margin)
        worst = max(demands, key=lambda key: demands[key])
        return worst, float(margin)

    @property
    def tightest_words(self) -> str:
        """The tightest limit and its margin as a clause."""
        limit, margin = self.tightest
        if margin == math.inf:
            return "no limit is loaded"
        return f"tightest limit: {words_of(limit)} (margin {margin_words(margin)})"

    def windings_after(self, time: float) -> dict[str, float]:
        """Highest winding temperature up to a time, by motor with thermal data. [K]

        Parameters
        ----------
        time : float   Since the start, at ambient or as the run states; a run ends after its duration. [s]

        Raises
        ------
        ParameterError
            If the time is negative or not finite.
        """
        if not 0.0 <= time < math.inf:
            raise ParameterError(f"time must be finite and >= 0 s, got {time}")
        duty = self.duty
        until, start = (time, None) if duty.closed else (min(time, duty.period), duty.start)
        return windings_after(self.drive, self.point, duty.period, until, ambient=duty.ambient, start=start)

    def _known_heat(self) -> dict[str, Heat]:
        return {what: found for what, found in self.heat.items() if found is not None}

    @derived(attribute="verdict")
    def verdict(self) -> str:
        """One-line verdict: feasibility, tightest limit, energy, heating."""
        known = self._known_heat()
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
            return [f"feasible; {self.tightest_words}"]
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

    @derived(dims=_TIME)
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

    @derived(key="*")
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

    @derived("W", "power lost in {}", _TIME, variable="loss_{}")
    def _lost(self) -> dict[str, np.ndarray]:
        shape = self.instants.time.shape
        return {name: np.broadcast_to(loss, shape) for name, loss in self.point.losses.items()}

    @derived(key="", attribute="energy")
    def _energy(self) -> dict[str, float]:
        return {"energy_per_cycle_J" if self.duty.closed else "energy_over_run_J": self.energy}

    @derived(key="holding")
    def _held(self) -> dict[str, Any]:
        """What it takes to hold still, with the force or moment held."""
        return {self.duty.axis.columns[2]: self.holding.force, **self.holding.to_dict()}


def _net(power: np.ndarray) -> float:
    """Mean power, 0 where it is only rounding beside the powers that cancel."""
    mean = float(np.mean(power))
    return 0.0 if abs(mean) < _ROUNDING * float(np.max(np.abs(power))) else mean


def _times(demand: float) -> str:
    return times(demand) if math.isfinite(demand) else "beyond"


def within_limits(heats: Mapping[str, Heat | None]) -> bool:
    """Whether no winding overheats; motors whose heat is not known count as within."""
    return all(found is None or found.within_limit for found in heats.values())
