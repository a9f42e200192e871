"""Motors behind what the tasks and paths of a machine ask of a shaft: lower bounds of what they need, and their evaluation."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from infinivar.drivetrain.steering import SteeringPlant
from infinivar.limits import ROOT_MEAN_SQUARE
from infinivar.sizing.cobotic.bounds import (
    MOTOR,
    MotorBounds,
    Side,
    cylinder_signals,
    lower_bounds,
    steering_signals,
)
from infinivar.sizing.cobotic.sampled import SideLaws, SideSampled
from infinivar.sizing.cobotic.wheels import Shaft
from infinivar.sizing.machines.work import MachineWork


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Asked:
    """Some instants of a shaft that are judged together."""

    name: str
    root_mean_square: bool
    """Whether heating and fatigue count by their root mean square, on a path."""
    share: float
    """At which the mean power over them counts."""
    columns: np.ndarray
    coldest: float = math.nan


def asked_of(work: MachineWork) -> list[Asked]:
    """What all tasks and paths ask of one shaft, whose instants are side by side."""
    found, start = list[Asked](), 0
    for key, count in work.sizes.items():
        own, share, lasts = np.arange(start, start + count), work.shares[key], work.lasts(key)
        start += count
        # The power in a task is that of its own wrench, its first corner.
        drawn = own if lasts else own[:1]
        some = [(own, share if len(drawn) == len(own) else 0.0)]
        some += [(drawn, share)] if len(drawn) < len(own) else []
        name = work.name_of(key)
        found += [Asked(name=name, root_mean_square=lasts, share=part, columns=row) for row, part in some]
    return found


def bounds_behind(
    side: Side, asked: Sequence[Asked], shaft: Shaft, plant: SteeringPlant | None
) -> list[tuple[float, MotorBounds]]:
    """Lower bounds of all candidates of a side behind some designs, each with the share at which its power counts."""
    found = []
    for one in asked:
        cut = _cut(shaft, one.columns)
        if side.name == MOTOR:
            signals = cylinder_signals(one, cut)
        else:
            assert plant is not None
            signals = steering_signals(plant, cut)
        found.append((one.share, lower_bounds(side, one, signals)))
    return found


def sampled_behind(
    side: Side, rows: np.ndarray, asked: Sequence[Asked], shaft: Shaft, plant: SteeringPlant | None
) -> SideSampled:
    """Candidates (m,) of a side at every instant, each behind a design of its own (m, n)."""
    laws = SideLaws(side, rows, {"": shaft}, plant)
    (motor,) = laws.motors.values()
    point = laws.run(motor, "")
    demands, power = {}, np.zeros(len(rows))
    drawn = np.broadcast_to(point.power_in, shaft.torque.shape)
    for one in asked:
        power = power + one.share * np.mean(drawn[:, one.columns], axis=-1)
        for (limit, part), demand in point.utilisation.items():
            row = np.broadcast_to(demand, shaft.torque.shape)[:, one.columns]
            root = one.root_mean_square and limit in ROOT_MEAN_SQUARE
            most = np.sqrt(np.mean(row * row, axis=-1)) if root else np.max(row, axis=-1)
            key = one.name, limit, part
            demands[key] = np.maximum(demands[key], most) if key in demands else most
    return SideSampled(demands, power, np.logical_and.reduce([demand <= 1.0 for demand in demands.values()]))


def _cut(shaft: Shaft, columns: np.ndarray) -> Shaft:
    """Some instants of a shaft."""
    rows = ("torque", "rate", "acceleration", "moment")
    some = {name: row[:, columns] for name in rows if (row := getattr(shaft, name)) is not None and row.shape[-1]}
    return shaft._replace(**some)
