"""What a simulated run of a machine of many contacts returns."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from infinivar._core.result import Result, result
from infinivar.analysis.animated import Animated
from infinivar.analysis.run import Run, error_words
from infinivar.analysis.run_limits import Event
from infinivar.limits import Demand
from infinivar.machines.kind import MovingMachine
from infinivar.motion.machine_scenario import MachineScenario
from infinivar.units import plain


@result
class MachineRun(Run, Animated, Result):
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

    machine: MovingMachine
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
    def position_error(self) -> np.ndarray | None:
        """Distance from the position to follow, or the largest error of a joint; None without a motion. [m] or [rad]"""
        motion, names = self.scenario.motion, configuration_names(self.machine)
        if motion is None or self.scenario.steering != "controlled":
            return None
        off = np.stack([self.columns[name] for name in names], -1) - np.array([motion(one) for one in self.time])
        metres = [place for place, name in enumerate(names) if name.endswith("_m")]
        return np.linalg.norm(off[:, metres], axis=-1) if metres else np.max(np.abs(off), axis=-1)

    @property
    def mean_powers(self) -> dict[str, float]:
        """Mean power from each supply after the settling time: "supply" of power motors, "steering supply". [W]"""
        lasted = float(self.time[-1] - self.time[self._settled])
        supplies = self._supplies(self._settled).items()
        return {name: energy / lasted if lasted else float("nan") for name, energy in supplies}

    @property
    def _settling_time(self) -> float | None:
        return self.scenario.settling_time

    def _achieved(self) -> Iterator[str]:
        error = self.position_error
        if error is not None:
            rotary = not any(name.endswith("_m") for name in configuration_names(self.machine))
            yield error_words("position", rotary, float(np.max(error)), float(error[-1]))

    def _spent(self) -> Iterator[str]:
        if not self._supplies():
            return
        words = {"supply": "for power", "steering supply": "for steering"}
        means = " and ".join(f"{plain(power)} W {words[name]}" for name, power in self.mean_powers.items())
        settled = "" if self._settling_time is None else f", after settling {means}"
        yield f"{plain(self._from_supply())} J from the supply{settled}"

    def to_dict(self) -> dict[str, Any]:
        """Plain values for JSON: final energies, events, verdict."""
        error = self.position_error
        return {
            "machine": self.title or type(self.machine).__name__,
            **self._judgement(),
            "duration_s": float(self.time[-1]),
            "settling_time_s": self.scenario.settling_time,
            "supplied_after_settling_J": self.supplied_after_settling,
            "mean_power_W": self.mean_powers,
            **({} if error is None else {"largest_position_error": float(np.max(error))}),
            **self._balance(),
            "events": self._log(),
        }


def configuration_names(machine: MovingMachine) -> tuple[str, ...]:
    """Names of the configuration of a machine, with units."""
    return machine.mechanics(1e-4).configuration
