"""Wheel designs with their motors as drives, evaluated once more for their demands."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from infinivar._core.pareto import spread_front
from infinivar.drivetrain.envelope import Envelope
from infinivar.drivetrain.masses import with_tube
from infinivar.limits import Limit
from infinivar.sizing.cobotic.bounds import MOTOR, Side
from infinivar.sizing.cobotic.choice import NOT_CHOSEN
from infinivar.sizing.cobotic.evaluation import Evaluation
from infinivar.sizing.cobotic.evolution import Entry, Key, Record
from infinivar.sizing.cobotic.sampled import sample
from infinivar.sizing.cobotic.space import FREE, Points, Space
from infinivar.sizing.cobotic.wheels import CONTACT, Wheels, evaluate, static_demands
from infinivar.sizing.found import CoboticDesign
from infinivar.sizing.geared.candidates import ENVELOPE, LIMIT_FIELDS
from infinivar.sizing.geared.sampled import UNCHECKED
from infinivar.sizing.geared.tasks import RegionTask, Task
from infinivar.sizing.margins import TaskDemand
from infinivar.sizing.measures import mass_of, price_of, volume_of

_ROUNDING = 1e-9


def best_designs(evaluation: Evaluation, record: Record, whole: Sequence[Task], top: int) -> tuple[CoboticDesign, ...]:
    """The best feasible designs in order, each of other parts, judged by the whole tasks."""
    by_mass = evaluation.objective == "mass"
    ordered = sorted(record.best, key=lambda key: (record.best[key].mass if by_mass else record.best[key].value, key))
    return _feasible(evaluation, ((key, record.best[key]) for key in ordered), whole, top)


def front_designs(evaluation: Evaluation, record: Record, whole: Sequence[Task]) -> tuple[CoboticDesign, ...]:
    """Feasible designs of which no other has both less mass and less power, by power."""
    keys = record.front() if evaluation.request.moving else []
    found = _feasible(evaluation, ((key[0], record.light[key]) for key in keys), whole, len(keys))
    mass, power = (np.array([getattr(one, name) for one in found]) for name in ("mass", "power"))
    return tuple(found[place] for place in spread_front(mass, power))


def _feasible(
    evaluation: Evaluation, entries: Iterable[tuple[Key, Entry]], whole: Sequence[Task], most: int
) -> tuple[CoboticDesign, ...]:
    """The first designs that keep all limits; those found at some points of a required region may fail at others."""
    found: list[CoboticDesign] = []
    for (pair, _, steered), entry in entries:
        if len(found) == most:
            break
        made = _design(evaluation, entry.values, entry.head, (pair, steered), whole)
        # Limits of motions were judged at the same instants, with their own allowances for rounding.
        judged = {ENVELOPE, *_regions(whole)}
        beyond = [demand for (task, *_), demand in made.demands.items() if task in judged]
        if all(demand <= 1.0 + _ROUNDING for demand in beyond):
            found.append(made)
    return tuple(found)


def _regions(tasks: Sequence[Task]) -> set[str]:
    return {task.name for task in tasks if isinstance(task, RegionTask)}


def nearest_design(evaluation: Evaluation, record: Record, whole: Sequence[Task]) -> CoboticDesign | None:
    """The infeasible wheel design nearest to feasible, with the motors nearest to it."""
    if record.nearest is None:
        return None
    _, values, head = record.nearest
    points = Points(values[None], np.array([head]))
    wheels = evaluate(evaluation.space, points, evaluation.tasks, life=evaluation.request.life)
    rows: list[int] = []
    if not wheels.slipping[0]:
        rows = [evaluation.nearest(side, points, wheels) for side in evaluation.sides]
    return _design(evaluation, values, head, rows, whole)


def _design(
    evaluation: Evaluation, values: np.ndarray, head: int, rows: Sequence[int], whole: Sequence[Task]
) -> CoboticDesign:
    """A wheel design with a candidate of each side, or without motors."""
    points = Points(values[None], np.array([head]))
    # Sides without a task, such as steering in a required region, have no candidate.
    chosen = [(side, row) for side, row in zip(evaluation.sides, rows, strict=False) if row != NOT_CHOSEN]
    space = evaluation.space
    for side, row in chosen:
        if side.name != MOTOR:  # its mass moves with the link
            space = space.with_steering(side.found.part(row)[0])
    wheels = evaluate(space, points, whole, life=evaluation.request.life, compiled=False)
    demands = {**static_demands(space.columns(points)), **evaluation.with_slip_margin(wheels.demands)}
    power = 0.0 if chosen and evaluation.request.moving else math.nan
    for side, row in chosen:
        here, drawn = _of_side(evaluation, side, row, wheels, whole)
        demands |= here
        power += drawn
    return design_of(
        space,
        values,
        head,
        chosen,
        power=power,
        demands={name: float(demand[0]) for name, demand in demands.items()},
        envelope=evaluation.envelope if chosen else None,
    )


def _of_side(
    evaluation: Evaluation, side: Side, row: int, wheels: Wheels, whole: Sequence[Task]
) -> tuple[Mapping[TaskDemand, np.ndarray], float]:
    """Demands on a candidate, and the power that it draws."""
    plant = evaluation.space.template.steering
    done = sample(side, np.array([row]), np.array([0]), whole, wheels.shafts, evaluation.shares, plant)
    return {name: demand for name, demand in done.demands.items() if demand[0] != UNCHECKED}, float(done.power[0])


def design_of(
    space: Space,
    values: np.ndarray,
    head: int,
    chosen: Sequence[tuple[Side, int]],
    *,
    power: float,
    demands: Mapping[TaskDemand, float],
    envelope: Envelope | None = None,
) -> CoboticDesign:
    """A wheel design with a candidate of each side, or without motors, as a study would have it.

    Parameters
    ----------
    values : (5,) float   In the order of `FREE`.
    """
    drive, ratio, missing = space.one(values, head), math.nan, []
    pair = motor_row = gear_row = steering = NOT_CHOSEN
    for side, row in chosen:
        motor, gear = side.found.part(row)
        first, second = map(int, side.found.pairs[row])
        unstated = [key for key in LIMIT_FIELDS if not side.found.stated(key, np.array([row]))[0]]
        if side.name == MOTOR:
            drive = replace(drive, motor=motor, gearhead=gear)
            pair, motor_row, gear_row = row, first, second
            missing += unstated
        elif drive.steering is not None:
            steering, ratio = first, float(gear.ratio)
            drive = replace(drive, steering=replace(drive.steering, motor=motor, ratio=ratio))
            missing += [(limit, side.name) for limit, part in unstated if part == MOTOR]
    drive = with_tube(drive, space.service)
    axle, _, support = map(int, space.heads.places(head))
    walls = static_demands(drive, 1)
    own = {key: float(walls[key][0]) for key in ((CONTACT, Limit.WALL, "cylinder"),) if key in walls}
    if envelope is not None:
        own |= {(ENVELOPE, *key): float(demand) for key, demand in envelope.of(drive, space.service).items()}
    return CoboticDesign(
        pair=pair,
        motor=motor_row,
        gearhead=gear_row,
        bearing=axle,
        wheels=drive.transmission.wheels,
        support=support,
        steering=steering,
        ratio=ratio,
        values=dict(zip(FREE, map(float, values), strict=True)),
        drive=drive,
        mass=mass_of(drive, space.service) if chosen else math.nan,
        power=power,
        volume=volume_of(drive, space.service) if chosen else math.nan,
        price=price_of(drive),
        demands={**demands, **own},
        unchecked=tuple(missing),
    )
