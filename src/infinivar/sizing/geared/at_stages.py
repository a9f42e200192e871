"""Every pair of motor and gearhead at given output stages."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from infinivar._core.pareto import front
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.limits import Demand
from infinivar.parts.stage import OutputStage
from infinivar.sizing.found import GearedSizing
from infinivar.sizing.geared import closed_form
from infinivar.sizing.geared.candidates import Candidates
from infinivar.sizing.geared.closed_form import friction_factors, warmth
from infinivar.sizing.geared.sampled import HOT, sample
from infinivar.sizing.geared.tally import SPARE, Tally, mixed, ranked, unchecked
from infinivar.sizing.geared.tasks import MotionTask, RegionTask, Task
from infinivar.sizing.progress import Progress, best_so_far
from infinivar.sizing.tables import GearedRequest


def at_stages(
    found: Candidates, tasks: Sequence[Task], request: GearedRequest, progress: Progress | None = None
) -> GearedSizing:
    """Evaluate every pair at every stage."""
    stages, objective, prune = request.stages or (found.template.stage,), request.objective, request.prune
    count, rows, tally = len(found.pairs), found.usable, Tally(found)
    feasible, evaluated = (np.zeros((len(stages), count), dtype=bool) for _ in range(2))
    power, best = np.full((len(stages), count), np.nan), []
    mass = np.full((len(stages), count), np.nan)
    for place, stage in enumerate(stages):
        if progress is not None:
            first = min(best, key=lambda one: one[0])[1] if best else None
            said = best_so_far(np.nan, np.nan) if first is None else best_so_far(first.power, first.mass)
            progress(said, place / len(stages))
        here = tuple(task.critical(found.template, stage) if isinstance(task, RegionTask) else task for task in tasks)
        left = _left(found, here, stage, tally, prune)
        tried = rows[left] if prune else rows
        if not tried.size:
            continue
        done = sample(found, tried, here, stage)
        tally.heat(done, tried, left[left] if prune else left)
        tally.rest(done, tried, left[left] if prune else left)
        feasible[place, tried], evaluated[place, tried] = done.feasible, True
        power[place, tried], mass[place, tried] = mixed(done.power, request.shares), found.measure("mass", tried, stage)
        best += ranked(found, tried, stage, done, request)
    best.sort(key=lambda one: one[0])
    designs = [one for _, one in best]
    if objective == "front":
        weighs, drawn = (np.array([getattr(one, name) for one in designs]) for name in ("mass", "power"))
        designs = [designs[place] for place in front(weighs, drawn)]
    else:
        designs = designs[: request.top]
    return GearedSizing(
        objective=objective,
        candidates=count * len(stages),
        excluded={reason: number * len(stages) for reason, number in found.excluded.items()},
        counts=tally.counts(),
        designs=tuple(designs),
        feasible=feasible,
        evaluated=evaluated,
        power=power,
        mass=mass,
        radii=np.empty((0, 2)),
        unchecked=unchecked(found, len(stages)),
    )


def _left(found: Candidates, tasks: Sequence[Task], stage: OutputStage, tally: Tally, prune: bool) -> np.ndarray:
    """Usable pairs that closed forms do not exclude at a stage, which are counted by limit. (k,) bool"""
    left = np.ones(len(found.usable), dtype=bool)
    for key, demand in found.sized(found.usable, stage).items():
        beyond = ~(demand <= 1.0)
        tally.add(key, np.ones_like(beyond), beyond, beyond & left)
        left = left & ~beyond
    for task in tasks:
        for demand, utilisation in closed_forms(found, task, stage):
            checked = tally.checked(task, demand, found.usable)
            beyond = checked & ~(utilisation <= 1.0 + SPARE)  # also nan: a motion out of reach
            if demand != HOT:
                tally.add((task.name, *demand), checked, beyond, beyond & left)
            elif prune:  # the others are counted when they have been evaluated at every instant
                tally.add((task.name, *demand), beyond, beyond, beyond & left)
            left = left & ~beyond
    return left


def closed_forms(
    found: Candidates, task: Task, stage: OutputStage, *, all_of_them: bool = False
) -> Iterable[tuple[Demand, np.ndarray]]:
    """Demand over allowance of every limit in a task, for all usable pairs; see `closed_form.demands`.

    Where a limit that no candidate changes is exceeded, no other is looked at; with `all_of_them` only where the motion is out of
    reach, so that no other is defined.
    """
    rows, signals = found.usable, task.signals(found.template, stage)
    defined = np.isfinite(signals.moving).all() and np.isfinite(signals.resting).all()
    if any(not demand <= 1.0 for demand in signals.others.values()) and not (all_of_them and defined):
        return [(key, np.full(len(rows), demand)) for key, demand in signals.others.items()]
    heated, low, high = found.resistances(rows, task.coldest if isinstance(task, MotionTask) else np.nan)
    drive = closed_form.with_resistance(found.drives(rows, stage), low)
    made, current = closed_form.moments(signals), closed_form.linear(drive)
    demands = closed_form.demands(drive, current, task, signals, made, heated=heated, hottest=high)
    return itertools.chain(demands, _temperature(found, task, drive, made))


def _temperature(
    found: Candidates, task: Task, drive: ConventionalDrive, made: closed_form.Moments
) -> Iterator[tuple[Demand, np.ndarray]]:
    """Yield a lower bound of the demand for the winding temperature, where there is one; see `warmth`."""
    warm = warmth(found, task, found.usable)
    if warm is not None:
        moved, rested = closed_form.squares(closed_form.linear(drive), made)
        lost = np.ravel(drive.motor.resistance) * (moved + rested)
        linear, square = friction_factors(drive)
        rubbed = linear * made.all[3, 4] + square * made.all[3, 3]
        yield HOT, np.where(warm.hopeless, np.inf, warm.by_winding * lost + warm.by_friction * rubbed)
