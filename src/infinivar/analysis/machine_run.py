"""What a simulated run of a machine of many contacts returns."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from infinivar._core.result import Result, result
from infinivar.analysis import run_limits
from infinivar.analysis.animated import Animated
from infinivar.analysis.judged import Judged
from infinivar.analysis.run_limits import Event, first_settled
from infinivar.bondgraph.audit import CLOSURE
from infinivar.limits import Demand
from infinivar.machines.kind import Machine
from infinivar.motion.machine_scenario import MachineScenario
from infinivar.units import plain


@result
class MachineRun(Judged, Animated, Result):
    """A simulated run of a machine of many contacts, as returned by `simulate_machine`; t instants.

    Attributes
    ----------
    machine, scenario : arguments of the call.
    title : str
    time : (t,) float            [s]
    columns : name to (t,)       Configuration, rates, steering angles and rates, currents and voltages of motors, forces of
        the user on the coordinates ("user_1" ...), slip demand of each wheel; names end in their unit.
    supplied : name to (t,)      Energy from "supply", "steering supply" and "user" since the start; where angles are
        prescribed, by "steering". [J]
    lost : name to (t,)          Energy lost by part since the start. [J]
    stored : name to (t,)        Kinetic energy of machine, motor and steering. [J]
    residual : (t,)              Energy that is unaccounted for, over the energy moved. [-]
    events : tuple of Event      Intervals in which a demand exceeds its allowance, by start time.
    root_mean_squares            Of each demand that it limits.
    outcome : str                Empty, or why the run ended early.
    """

    machine: Machine
    scenario: MachineScenario
    title: str
    time: np.ndarray
    columns: Mapping[str, np.ndarray]
    supplied: Mapping[str, np.ndarray]
    lost: Mapping[str, np.ndarray]
    stored: Mapping[str, np.ndarray]
    residual: np.ndarray
    events: tuple[Event, ...]
    root_mean_squares: Mapping[Demand, float]
    outcome: str = ""

    @property
    def event_lines(self) -> tuple[str, ...]:
        """Demands beyond their allowance, in a line for each interval, or for all of one limit if they are many."""
        return run_limits.lines(self.events, self.root_mean_squares)

    @property
    def position_error(self) -> np.ndarray | None:
        """Distance from the position to follow, or the largest error of a joint; None without a motion. [m] or [rad]"""
        motion, names = self.scenario.motion, configuration_names(self.machine)
        if motion is None or self.scenario.steering != "controlled":
            return None
        off = np.stack([self.columns[name] for name in names], -1) - np.array([motion(one) for one in self.time])
        metres = [place for place, name in enumerate(names) if name.endswith("_m")]
        return np.linalg.norm(off[:, metres], axis=-1) if metres else np.max(np.abs(off), axis=-1)

    @property
    def supplied_after_settling(self) -> float:
        """Energy from all supplies after the settling time, of motor and steering. [J]"""
        first = first_settled(self.time, self.scenario.settling_time)
        return sum(float(energy[-1] - energy[first]) for name, energy in self.supplied.items() if "supply" in name)

    @property
    def mean_powers(self) -> dict[str, float]:
        """Mean power from each supply after the settling time: "supply" of power motors, "steering supply". [W]"""
        first = first_settled(self.time, self.scenario.settling_time)
        lasted = float(self.time[-1] - self.time[first])
        return {
            name: float(energy[-1] - energy[first]) / lasted if lasted else float("nan")
            for name, energy in self.supplied.items()
            if "supply" in name
        }

    @property
    def verdict(self) -> str:
        """One-line verdict: exceeded limits, position error, energy supplied, closure."""
        if not self.complete:
            return self.outcome
        settling = self.scenario.settling_time
        said = [run_limits.verdict(self.events, self.root_mean_squares, self.scenario.duration, settling)]
        error = self.position_error
        if error is not None:
            metres = any(name.endswith("_m") for name in configuration_names(self.machine))
            scale, unit = (1e3, "mm") if metres else (1.0, "rad")
            most, last = (plain(scale * float(one), 2) for one in (np.max(error), error[-1]))
            said.append(f"position error {most} {unit} at most, {last} {unit} at the end")
        supplies = [name for name in self.supplied if "supply" in name]
        if supplies:
            spent = sum(float(self.supplied[name][-1]) for name in supplies)
            said.append(f"{plain(spent)} J from the supply{self._mean_words() if settling is not None else ''}")
        said.append(f"energy balance closed to {plain(CLOSURE, 1)}")
        return "; ".join(said)

    def _mean_words(self) -> str:
        words = {"supply": "for power", "steering supply": "for steering"}
        return ", after settling " + " and ".join(
            f"{plain(power)} W {words[name]}" for name, power in self.mean_powers.items()
        )

    def to_dict(self) -> dict[str, Any]:
        """Plain values for JSON: final energies, events, verdict."""
        error = self.position_error
        return {
            "machine": self.title or type(self.machine).__name__,
            "verdict": self.verdict,
            "complete": self.complete,
            "feasible": self.feasible,
            "duration_s": float(self.time[-1]),
            "settling_time_s": self.scenario.settling_time,
            "supplied_after_settling_J": self.supplied_after_settling,
            "mean_power_W": self.mean_powers,
            **({} if error is None else {"largest_position_error": float(np.max(error))}),
            "supplied_J": {name: float(energy[-1]) for name, energy in self.supplied.items()},
            "lost_J": {name: float(energy[-1]) for name, energy in self.lost.items()},
            "stored_J": {name: float(energy[-1] - energy[0]) for name, energy in self.stored.items()},
            "closure": self.closure,
            "events": [
                {
                    "limit": event.limit.name,
                    "what": event.what,
                    "start_s": event.start,
                    "end_s": event.end,
                    "worst": event.worst,
                    "while_settling": bool(event.settling),
                }
                for event in self.events
            ],
        }


def configuration_names(machine: Machine) -> tuple[str, ...]:
    """Names of the configuration of a machine, with units."""
    return machine.mechanics(1e-4).configuration
