"""Demands and energy of motors behind given wheels from every instant, by the laws of `duty_cycle` and `steady_map`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from infinivar.analysis.cycles import performance
from infinivar.analysis.cycles.duty_cycle import heating
from infinivar.drivetrain.drive import MovingPoint, motor_side, placed
from infinivar.drivetrain.steering import SteeringPlant
from infinivar.limits import Demand, Limit
from infinivar.parts import heat
from infinivar.parts.heat_steps import windings
from infinivar.parts.motor import Motor
from infinivar.sizing.cobotic.bounds import MOTOR, Side
from infinivar.sizing.cobotic.wheels import Shaft
from infinivar.sizing.geared.sampled import UNCHECKED, batches, overheating, temperatures
from infinivar.sizing.geared.tasks import MotionTask, Task, heat_counts
from infinivar.sizing.margins import TaskDemand


class Sampled(NamedTuple):
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
) -> Sampled:
    """Evaluate candidates of a side at every instant.

    Parameters
    ----------
    rows : (m,) int     Candidates, as rows of the side's table of pairs.
    places : (m,) int   Wheel design of each, as a row of the shafts.
    plant : SteeringPlant   Of the template, which has all but motor and ratio.
    """
    demands: dict[TaskDemand, np.ndarray] = {}
    power, feasible = np.zeros(len(rows)), np.ones(len(rows), dtype=bool)
    judged = [task for task in tasks if side.name == MOTOR or isinstance(task, MotionTask)]
    for some in batches(side.found, rows, judged) if judged else ():
        motor, gear = side.found.parts(rows[some])
        for task in judged:
            run = _runner(side, plant, gear, shafts[task.name].of(places[some]))
            if isinstance(task, MotionTask):
                found, cool, drawn = _over_motion(side, task, motor, run)
                feasible[some] &= cool
                power[some] += shares[task.name] * drawn
            else:
                found = {key: np.max(demand, axis=-1) for key, demand in run(motor).utilisation.items()}
            for (limit, part), demand in found.items():
                key = task.name, limit, part
                demands.setdefault(key, np.full(len(rows), UNCHECKED))[some] = demand
                if limit != Limit.TEMPERATURE:  # judged with its own allowance for rounding
                    feasible[some] &= demands[key][some] <= 1.0
    return Sampled(demands, power, feasible)


def _runner(side: Side, plant: SteeringPlant | None, gear: Any, shaft: Shaft) -> Callable[[Motor], MovingPoint]:
    """Make a function that operates a motor behind wheels: as a point of the drive with the terms of that motor only."""
    nothing = np.zeros(shaft.torque.shape)

    def run(motor: Motor) -> MovingPoint:
        if side.name == MOTOR:
            made = motor_side(motor, gear, output_torque=shaft.torque, output_speed=shaft.turning)
        else:
            assert plant is not None
            made = shaft.steer(replace(plant, motor=motor, ratio=gear.ratio))
        power_in, burnt, met = side.amplifier.supply(made.power)
        limits: dict[Demand, Any] = dict(placed(made.utilisation, side.name))
        limits |= {(limit, side.name): demand for limit, demand in met.items()}
        return MovingPoint(
            power_in=power_in,
            power_out=nothing,
            losses={**made.losses, "amplifier": burnt},
            stored={},
            utilisation=limits,
            states=made.states,
        )

    return run


def _over_motion(
    side: Side, task: MotionTask, motor: Motor, run: Callable[[Motor], MovingPoint]
) -> tuple[dict[Demand, np.ndarray], np.ndarray, np.ndarray]:
    """Demands over a motion, whether windings stay within their limit, and the mean power."""
    duty, point, hot = task.duty, run(motor), None
    if motor.max_winding_temperature is not None:
        current, friction = heating(point, side.name)
        shape = np.shape(point.power_out)
        start = None if duty.closed else duty.start
        hot = windings(motor, np.asarray(current), np.broadcast_to(friction, shape), duty.period, duty.ambient, start)
        warm: Any = temperatures(motor, task, hot)
        point = run(heat.warm(motor, warm))
    found = performance.demands(point)
    cool = np.ones(len(point.power_out), dtype=bool)
    if hot is not None:
        found[Limit.TEMPERATURE, side.name], cool = overheating(motor, task, hot)
        if heat_counts(task):
            del found[Limit.THERMAL, side.name]
    return found, cool, np.mean(np.broadcast_to(point.power_in, np.shape(point.power_out)), axis=-1)
