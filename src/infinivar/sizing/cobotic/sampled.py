"""Demands and energy of motors behind given wheels from every instant, by the laws of `duty_cycle` and `steady_map`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from infinivar._core.array_namespace import Array
from infinivar.analysis.cycles import performance
from infinivar.analysis.cycles.performance import heating
from infinivar.drivetrain.drive import MovingPoint, motor_side, placed
from infinivar.drivetrain.steering import SteeringPlant
from infinivar.limits import Demand
from infinivar.parts import heat
from infinivar.parts.motor import Motor
from infinivar.sizing.cobotic.bounds import MOTOR, Side
from infinivar.sizing.cobotic.wheels import Shaft
from infinivar.sizing.geared.sampled import sample_by
from infinivar.sizing.geared.tasks import MotionTask, RegionTask, Task, without_travel
from infinivar.sizing.margins import TaskDemand


class SideSampled(NamedTuple):
    """Results of some candidates of one side, each behind a wheel design. (m,) each"""

    demands: Mapping[TaskDemand, np.ndarray]
    """Demand over allowance; `UNCHECKED` where a limit does not apply. [-]"""
    power: np.ndarray
    """Mean power from the supply over all motions, by their shares of time. [W]"""
    feasible: np.ndarray
    """bool"""

    @property
    def worst(self) -> np.ndarray:
        """Largest demand over allowance, above 1 where a winding overheats by rounding only. [-]"""
        most = np.max([np.zeros(len(self.power)), *self.demands.values()], axis=0)
        return np.where(self.feasible, most, np.maximum(most, 1.0 + 1e-9))


def sample(
    side: Side,
    rows: np.ndarray,
    places: np.ndarray,
    tasks: Sequence[Task],
    shafts: Mapping[str, Shaft],
    shares: Mapping[str, float],
    plant: SteeringPlant | None,
) -> SideSampled:
    """Evaluate candidates of a side at every instant.

    Parameters
    ----------
    rows : (m,) int     Candidates, as rows of the side's table of pairs.
    places : (m,) int   Wheel design of each, as a row of the shafts.
    plant : SteeringPlant   Of the template, which has all but motor and ratio.
    """
    judged = [task for task in without_travel(tasks) if side.name == MOTOR or isinstance(task, MotionTask)]
    if not judged:
        return SideSampled({}, np.zeros(len(rows)), np.ones(len(rows), dtype=bool))

    def laws(some: np.ndarray) -> SideLaws:
        behind = {task.name: shafts[task.name].of(places[some]) for task in judged}
        return SideLaws(side, rows[some], behind, plant)

    done = sample_by(side.found, rows, judged, laws)
    drawn = sum((shares[name] * power for name, power in done.power.items()), np.zeros(len(rows)))
    return SideSampled(done.demands, drawn, done.feasible)


class SideLaws:
    """What many candidates of a side do behind wheel designs, each behind its own: a drive with the terms of one motor only."""

    def __init__(self, side: Side, rows: np.ndarray, shafts: Mapping[str, Shaft], plant: SteeringPlant | None) -> None:
        """Compute nothing yet; arguments as for `sample`, `shafts` having a row for each candidate."""
        self._side, self._shafts, self._plant = side, shafts, plant
        self._motor, self._gear = side.found.parts(rows)
        self.count = len(rows)

    @property
    def motors(self) -> Mapping[str, Motor]:
        """The motor of the side, by its name."""
        return {self._side.name: self._motor}

    def heat_sources(self, task: MotionTask) -> dict[str, tuple[Array, Array]]:
        """As `Laws.heat_sources`."""
        name = self._side.name
        return {} if heat.missing(self._motor) else {name: heating(self.run(self._motor, task.name), name)}

    def over(self, task: MotionTask, warm: Mapping[str, Any]) -> tuple[dict[Demand, Array], Array]:
        """As `Laws.over`."""
        motor = heat.warm(self._motor, warm[self._side.name]) if warm else self._motor
        point = self.run(motor, task.name)
        drawn = np.broadcast_to(point.power_in, np.shape(point.power_out))
        return performance.demands(point), np.mean(drawn, axis=-1)

    def within(self, task: RegionTask) -> dict[Demand, Array]:
        """As `Laws.within`."""
        point = self.run(self._motor, task.name)
        return {key: np.max(demand, axis=-1) for key, demand in point.utilisation.items()}

    def run(self, motor: Motor, name: str) -> MovingPoint:
        """Operating points in a task."""
        side, shaft = self._side, self._shafts[name]
        if side.name == MOTOR:
            made = motor_side(motor, self._gear, output_torque=shaft.torque, output_speed=shaft.turning)
        else:
            assert self._plant is not None
            made = shaft.steer(replace(self._plant, motor=motor, ratio=self._gear.ratio))
        power_in, burnt, met = side.amplifier.supply(made.power)
        limits: dict[Demand, Any] = dict(placed(made.utilisation, side.name))
        limits |= {(limit, side.name): demand for limit, demand in met.items()}
        return MovingPoint(
            power_in=power_in,
            power_out=np.zeros(shaft.torque.shape),
            losses={**made.losses, "amplifier": burnt},
            stored={},
            utilisation=limits,
            states=made.states,
        )
