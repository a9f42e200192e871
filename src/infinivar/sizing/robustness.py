"""In what share of builds the designs of a search stay feasible, and the winner stays the best."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from infinivar._core.processes import apart
from infinivar.analysis.robustness.sampling import in_pieces
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.errors import InputError, require
from infinivar.sizing.builds import compiled as engine
from infinivar.sizing.builds.evaluation import BuildResults, at_once, built, decisive, judge, points
from infinivar.sizing.builds.result import DesignBuilds, Doubt
from infinivar.sizing.builds.spreads import draw
from infinivar.sizing.design import SizedDrive
from infinivar.sizing.geared.sampled import Laws
from infinivar.sizing.geared.tasks import MotionTask, Task, tasks_of
from infinivar.sizing.margins import TaskDemand
from infinivar.sizing.measures import MEASURES
from infinivar.sizing.result import Sizing
from infinivar.sizing.tables import equal_shares
from infinivar.study.study import Study

BUILDS = 128
"""Number of builds, unless another is stated."""

JUDGED = 5
"""Most designs, and most of the front, that are judged."""

COMPILED_FROM = 30_000_000
"""Instants of all builds of geared designs of one structure from which compiling saves time."""
_UNKNOWN = 1e300
"""Stands for a mass that is not stated: heavier than all others."""


def doubt(
    sizing: Sizing,
    *,
    builds: int = BUILDS,
    seed: int = 0,
    compiled: bool | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> Doubt:
    """Judge builds of the designs of a search: how many stay feasible, and in how many the best design stays the best.

    Torque constant and winding resistance of a motor, efficiency of a gearhead and every other value with a spread in the study
    differ from build to build. They belong to a part: designs with the same part share its samples, those with different parts
    do not. What belongs to no part, such as the friction coefficient, is the same for all designs of a template.

    A spread that the study states for a part of the template counts for the part that replaces it, relative to the value, of an
    efficiency relative to the loss. Torque constant, resistance, gear loss and friction coefficient of the rolling contact have
    assumed spreads where the study states none.

    Parameters
    ----------
    sizing : Sizing           Of `size`; the first 5 designs and the best of each template are compared, and the first 5 of the
        front are judged as well.
    builds : int              Number of builds, a power of two from 16 to 2^20.
    seed : int                Seed of the sequence of samples.
    compiled : bool           Whether JAX computes; by default where it is installed and there is much to compute.
    progress : callable       Called with words and the share of work done, 0 to 1.

    Returns
    -------
    Doubt

    Raises
    ------
    InputError
        If the search found no design, or an argument is out of range.
    """
    if not sizing.designs:
        raise InputError("the search found no feasible design: there is nothing to judge")
    designs = {f"design-{place:02d}": one for place, one in enumerate(sizing.designs[:JUDGED], 1)}
    known = {_identity(one) for one in designs.values()}
    for name, one in sizing.best_of.items():
        if _identity(one) not in known:
            designs[f"best-{name}"] = one
    return judged_designs(
        sizing.study,
        designs,
        front={f"front-{place:02d}": one for place, one in enumerate(sizing.front[:JUDGED], 1)},
        objective=sizing.objective[0],
        builds=builds,
        seed=seed,
        compiled=compiled,
        progress=progress,
    )


def with_builds(sizing: Sizing, builds: int, progress: Callable[[str, float], None] | None) -> Sizing:
    """The result of a search with `doubt` of it; as it is for 0 builds, or if no candidate is feasible."""
    if not builds or not sizing.designs:
        return sizing
    return replace(sizing, doubt=doubt(sizing, builds=builds, progress=progress))


def judged_designs(
    study: Study,
    designs: Mapping[str, SizedDrive],
    *,
    front: Mapping[str, SizedDrive] | None = None,
    objective: str = "energy",
    builds: int = BUILDS,
    seed: int = 0,
    compiled: bool | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> Doubt:
    """Judge builds of designs, by name, by the requirement and all motions of a study; other arguments as for `doubt`.

    Parameters
    ----------
    designs : mapping   Compared with one another; the first is the winner.
    front : mapping     More designs to judge.
    objective : str     energy, mass, space or price: what makes one of the feasible designs the best.
    """
    require(objective in MEASURES, "objective", repr(objective), "energy, mass, space or price")
    check_builds(builds)
    if objective == "energy" and not study.duty:
        raise InputError('objective = "energy" needs a motion in the study')
    front = front or {}
    every = list({_identity(one): one for one in (*designs.values(), *front.values())}.values())
    draws = draw(every, study.uncertainty, builds, seed)
    found: dict[Any, BuildResults] = {}
    for design, judged in zip(every, _judged(study, every, draws.values, builds, compiled), strict=True):
        found[_identity(design)] = judged
        if progress is not None:
            progress("judging builds", len(found) / len(every))
    competing = [found[_identity(design)] for design in designs.values()]
    winners = _winners(list(designs.values()), competing, objective)
    return Doubt(
        objective=objective,
        designs=tuple(
            _summary(name, design, one, int(np.sum(winners == place)))
            for place, ((name, design), one) in enumerate(zip(designs.items(), competing, strict=True))
        ),
        front=tuple(_summary(name, design, found[_identity(design)], 0) for name, design in front.items()),
        varied=tuple(draws.varied.values()),
        none=int(np.sum(winners < 0)),
    )


def check_builds(builds: int) -> None:
    """Raise ParameterError unless it is a number of builds that can be sampled."""
    power_of_two = isinstance(builds, int) and not isinstance(builds, bool) and builds & (builds - 1) == 0
    require(power_of_two and 16 <= builds <= 2**20, "builds", builds, "a power of two from 16 to 1048576")


def _identity(design: SizedDrive) -> tuple[Any, ...]:
    """Equal for designs that are one: template, parts and values chosen."""
    parts = tuple((role, part.part) for role, part in design.parts.items())
    return design.template, parts, tuple((path, free.value) for path, free in design.free.items())


def _judged(
    study: Study,
    designs: Sequence[SizedDrive],
    values: Sequence[Mapping[str, np.ndarray]],
    count: int,
    compiled: bool | None,
) -> Iterator[BuildResults]:
    """Judge the builds of each design, those of one structure by the same compiled laws."""
    every_task = [tasks_of(one.drive, study.duty, study.requirement, study.travel) for one in designs]
    groups: dict[Any, list[int]] = {}
    for place, (design, columns) in enumerate(zip(designs, values, strict=True)):
        groups.setdefault((engine.structure(design.drive), tuple(columns), design.template), []).append(place)
    law_of: dict[int, engine.CompiledBuilds] = {}
    optional = compiled is None
    for places in groups.values():
        requested = _pays([designs[place] for place in places], every_task[places[0]], count) if optional else compiled
        if requested and values[places[0]]:
            made = engine.CompiledBuilds([designs[place].drive for place in places], tuple(values[places[0]]))
            law_of |= dict.fromkeys(places, made)
    shares = equal_shares(study.duty)
    jobs = [(one.drive, values[place], every_task[place], law_of.get(place)) for place, one in enumerate(designs)]
    compute = map if law_of else apart  # compiled laws stay in the process that compiled them
    yield from compute(functools.partial(_of_job, shares, count, optional), jobs)


def _of_job(shares: Mapping[str, float], count: int, optional: bool, job: tuple[Any, ...]) -> BuildResults:
    """Judge the builds of a design: drive, values, all tasks, and the compiled law, if there is one."""
    drive, values, tasks, law = job
    return _of_design(drive, values, decisive(drive, tasks, values), shares, count, law, optional)


def _pays(designs: Sequence[SizedDrive], tasks: Sequence[Task], count: int) -> bool:
    """Whether JAX is installed and saves time for designs of one structure: not where the contact takes most of it."""
    instants = sum(points(task) for task in tasks if isinstance(task, MotionTask))
    much = count * len(designs) * instants >= COMPILED_FROM
    return much and isinstance(designs[0].drive, ConventionalDrive) and engine.available()


def _of_design(
    drive: Any,
    values: Mapping[str, np.ndarray],
    tasks: Sequence[Task],
    shares: Mapping[str, float],
    count: int,
    law: engine.CompiledBuilds | None,
    optional: bool,
) -> BuildResults:
    """Judge the builds of one design, some at a time."""

    def run(rows: np.ndarray) -> BuildResults:
        columns = {path: column[rows, None] for path, column in values.items()}
        laws = Laws(built(drive, columns), len(rows)) if law is None else law.laws(drive, columns)
        return judge(laws, tasks, shares)

    def run_quietly(rows: np.ndarray) -> BuildResults:
        # Threads do not inherit the state of warnings.
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            return run(rows)

    size = at_once(tasks) if law is None else engine.TOGETHER
    try:
        pieces = list(in_pieces(run_quietly, np.arange(count), size))
    except TypeError:  # as JAX reports a law that decides by values
        if law is None or not optional:
            raise
        return _of_design(drive, values, tasks, shares, count, None, optional)
    return BuildResults(
        demands=_joined([one.demands for one in pieces]),
        exceeded=_joined([one.exceeded for one in pieces]),
        power=np.concatenate([one.power for one in pieces]),
        feasible=np.concatenate([one.feasible for one in pieces]),
    )


def _joined(parts: Sequence[Mapping[TaskDemand, np.ndarray]]) -> dict[TaskDemand, np.ndarray]:
    return {key: np.concatenate([one[key] for one in parts]) for key in parts[0]}


def _winners(designs: Sequence[SizedDrive], found: Sequence[BuildResults], objective: str) -> np.ndarray:
    """Place of the best feasible design in each build, the earlier of two that are equal; -1 where none is feasible. (n,)"""
    measure = MEASURES[objective]
    rank = np.stack(
        [
            np.where(
                one.feasible,
                one.power if objective == "energy" else np.nan_to_num(measure.of(design), nan=_UNKNOWN),
                np.inf,
            )
            for design, one in zip(designs, found, strict=True)
        ]
    )
    some = np.any([one.feasible for one in found], axis=0)
    return np.where(some, np.argmin(rank, axis=0), -1)


def _summary(name: str, design: SizedDrive, found: BuildResults, best: int) -> DesignBuilds:
    counts = {key: int(np.sum(beyond)) for key, beyond in found.exceeded.items()}
    worst = sorted((key for key in counts if counts[key]), key=lambda key: -counts[key])
    return DesignBuilds(
        name=name,
        title=design.title,
        feasible=found.feasible,
        power=found.power,
        exceeded={key: counts[key] for key in worst},
        best=best,
        nominal=design.power,
    )
