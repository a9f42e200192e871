"""The best drives for a study among all parts of some sets.

On request, the best designs are evaluated again with another answer to each open choice: what the verdict depends on.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from infinivar._core.fields import value_at
from infinivar._core.pareto import front
from infinivar.analysis.cycles.duty_cycle import energy_and_feasibility
from infinivar.analysis.deciding import best_speeds, hanging_machines
from infinivar.analysis.hanging import Hanging, Judged, hang
from infinivar.analysis.machines import compare_machines
from infinivar.analysis.region import covers
from infinivar.analysis.whole_mass import doubts, with_factor
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.drive import is_machine
from infinivar.drivetrain.masses import tube_as_of
from infinivar.errors import InputError, require
from infinivar.parts.gearhead import LossModel
from infinivar.parts.structure.structure import Structure
from infinivar.sizing.carrying import best_carried
from infinivar.sizing.design import SizedDrive, shown
from infinivar.sizing.geared.tally import SPARE
from infinivar.sizing.machine_changes import change_words
from infinivar.sizing.machine_templates import of_machines
from infinivar.sizing.machines.legged import legged
from infinivar.sizing.machines.rolling import rolling
from infinivar.sizing.machines.separate import separate
from infinivar.sizing.measures import MEASURES
from infinivar.sizing.of_cobotic import cobotic
from infinivar.sizing.of_geared import geared
from infinivar.sizing.options import Aim, SizeOptions
from infinivar.sizing.progress import Progress, part_of
from infinivar.sizing.request import Found, StudyRequest, request_of
from infinivar.sizing.result import Sizing
from infinivar.sizing.robustness import check_builds, with_builds
from infinivar.sizing.studies import not_simulated, not_taken_over, study_of
from infinivar.sizing.tables import equal_shares
from infinivar.sizing.tried import Search, search_tries
from infinivar.sizing.what_if import what_if
from infinivar.study.choices import Variant, variants
from infinivar.study.study import Study
from infinivar.units import show

_WORK: dict[Search, float] = {geared: 1.0, cobotic: 4.0, separate: 1.0, legged: 3.0, rolling: 3.0}
"""Parts of the time that the searches take, for the progress."""


def size(
    study: Study,
    *,
    objective: Aim | Sequence[Aim] | None = None,
    top: int = 20,
    sets: str | Path | Sequence[str | Path] | None = None,
    drive: str | Sequence[str] | None = None,
    radius: tuple[float, float] | None = None,
    tries: Mapping[str, Any] | None = None,
    ranges: Mapping[str, tuple[float, float]] | None = None,
    steering_ratios: Sequence[float] | None = None,
    wheels: Sequence[int] | None = None,
    slip_margin: float | None = None,
    life: float | None = None,
    loss_model: LossModel | None = None,
    generations: int | None = None,
    seed: int | None = None,
    carried: float | None = None,
    builds: int = 0,
    progress: Progress | None = None,
) -> Sizing:
    """Find the best geared and cobotic drives for a study among all parts of some sets.

    A geared and a cobotic drive of the study are the templates. Of a geared one, motor, gearhead and the radius of a pulley are
    searched; of a cobotic one both motors, the gearhead, axle and cylinder bearings, the number of wheels, the steering ratio and
    the five values of `ranges`.
    All else stays. Candidates are judged by the requirement and all duty cycles of the study.

    Of a study with tasks and paths, machines are searched: all links of one with separate drives have the same motor, gearhead
    and pulley, and all legs of one on a common cylinder the same wheel and steering motor.

    Parameters
    ----------
    study : Study
    objective : str or sequence   "energy", "mass", "space" (the box around the drive), "price" (of motors and gearheads, where
        all state one); or energy and mass: designs are ordered by the first, and both give their front as well. Both by
        default, energy first; mass for a study without motions.
    top : int                     Number of designs to return, besides those of the front.
    sets : name, path or several  Sets of parts; by default all that can be had: shipped, in a folder parts beside the study or in
        the working directory, yours, and those of installed packages.
    drive : str or several        Templates; by default the first geared and the first cobotic drive of the study that can be one.
    radius : (float, float)       Least and largest radius of the pulley of geared drives; by default a fifth and five times the
        template's. [m]
    tries : mapping               Values of a template to try, each combination with everything that the search chooses, by path,
        such as "drives.geared.screw.lead": numbers in SI, texts with units, or one text, "2 mm, 5 mm" or a range "2 mm..9 mm". Of
        a range, 7 values in equal ratios are tried, and then 2 on each side of the best. "drives.NAME.motor.scale" is the number
        of motors on one shaft.
    ranges : mapping              Of cobotic drives: least and largest cylinder_radius [m], cylinder_speed [rad s^-1],
        wheel_radius [m], crown_radius [m] and preload [N]; by default half and twice the template's. Equal ends fix a value.
    steering_ratios : sequence    Of cobotic drives, between steering motor and bell; by default five from half to twice the
        template's. [-]
    wheels : sequence             Of cobotic drives: numbers of wheels around the cylinder, 1, 2 and 3 by default.
    slip_margin : float           Of cobotic drives: slip force over lateral force that is wanted, at least 1; demands for slip
        count it; 1.1 by default. [-]
    life : float                  Of cobotic drives: wanted life of axle and cylinder bearings. [s]
    loss_model : str              coulomb, proportional or strain wave, of all gearheads; by default that of the template's.
    generations, seed : int       Of the search over cobotic drives, 40 and 0 by default; the same seed gives the same result.
    carried : float               What a kilogram costs to carry, which counts beside the power; see `Sizing.carrying`. [W/kg]
    builds : int                  Number of builds of the designs to judge, a power of two; 0 for none. See `doubt`.
    progress : callable           Called with words on the best design so far and the share of work done, 0 to 1.

    Returns
    -------
    Sizing   Empty of designs if no candidate is feasible; then with the nearest misses.

    Raises
    ------
    InputError
        If the study has no template or nothing to judge by, a set cannot be read, or an argument is out of range, or is for an
        architecture that is not searched.
    """
    if builds:
        check_builds(builds)
        builds = 0 if of_machines(study) else builds
    options = SizeOptions(
        objective=objective,
        top=top,
        sets=[sets] if isinstance(sets, str | Path) else sets,
        radius=radius,
        tries=tries,
        ranges=ranges,
        steering_ratios=steering_ratios,
        wheels=wheels,
        slip_margin=slip_margin,
        life=life,
        generations=generations,
        seed=seed,
        carried=carried,
        builds=builds,
    )
    searched = {name: value for name, value in options.arguments().items() if name not in ("builds", "carried")}
    request = request_of(study, drive=drive, loss_model=loss_model, **searched)
    if carried is not None:
        require(0.0 <= carried < math.inf, "carried", show(carried, "W/kg"), ">= 0 W/kg and finite")
        if len(request.aims) < 2:
            raise InputError(
                "carried needs both objectives, energy and mass, and a motion: it weighs one against the other"
            )
    found = _searched(request, progress)
    if progress is not None:
        progress("what would have to change", 1.0)
    made = replace(sizing_of(request, found), options=options)
    return with_builds(with_hanging(made), builds, progress)


def sizing_of(request: StudyRequest, found: Mapping[str, Found]) -> Sizing:
    """What searches found, by template, as one result."""
    study, parts, aims = request.study, request.parts, request.aims
    best_of = {name: each.designs[0] for name, each in found.items() if each.designs}
    missed = {name: each.record.nearest for name, each in found.items() if each.record.nearest is not None}
    designs = _ordered([one for each in found.values() for one in each.designs], request)
    best_front = _front([one for each in found.values() for one in each.front])
    chosen_parts = [named for one in (*designs, *best_front, *best_of.values()) for named in one.parts.items()]
    return Sizing(
        study=study,
        objective=aims,
        designs=tuple(designs),
        front=tuple(best_front),
        searches={name: each.record for name, each in found.items()},
        sets=parts.sets,
        best_of=best_of,
        carried=best_carried(
            [one for each in found.values() for one in (*each.designs, *each.front)] if len(request.aims) > 1 else []
        ),
        what_if={} if of_machines(study) else what_if(study, aims[0], best_of, missed, request.slip_margin),
        notes=(
            *request.notes,
            *(_changed(study, missed) if of_machines(study) else ()),
            *_left_out(request, found),
            *_coupled(best_of),
            *not_taken_over(study, best_of),
            *_not_simulated(study, best_of),
            *parts.unread,
            *parts.contradictions(chosen_parts),
        ),
    )


def _changed(study: Study, missed: Mapping[str, SizedDrive]) -> Iterator[str]:
    """What would make the nearest miss like each machine feasible."""
    for name, design in missed.items():
        found = change_words(study, design.drive)
        said = f"would be feasible with {', or with '.join(found)}" if found else "has no change tried that is enough"
        yield f"the nearest miss like {name} {said}"


def _left_out(request: StudyRequest, found: Mapping[str, Found]) -> Iterator[str]:
    """How many candidates each search leaves out, as they do not state what an envelope or the price needs."""
    needs = [("envelope", "mass")] * (request.study.envelope is not None)
    needs += [("objective = price", "price")] * ("price" in request.aims)
    for (what, name), (template, each) in itertools.product(needs, found.items()):
        excluded = each.record.excluded.items()
        number = sum(count for reason, count in excluded if reason.endswith(f"{name} not stated"))
        if number:
            yield f"{what}: {number} candidates like {template} were left out, whose {name} is not stated"


def _coupled(best_of: Mapping[str, SizedDrive]) -> Iterator[str]:
    """What a design with several wheels needs and is not counted."""
    for template, design in best_of.items():
        wheels = getattr(getattr(design.drive, "transmission", None), "wheels", 1)
        if wheels > 1:
            yield (
                f"not counted: what turns the bells of the {wheels} wheels of the best design like {template} together; their "
                "preloads are taken as equal, so that rail and cylinder bearings carry none"
            )


def _not_simulated(study: Study, best_of: Mapping[str, SizedDrive]) -> Iterator[str]:
    """Motions that the studies of designs do not have as scenarios, and why."""
    for template, design in best_of.items():
        for name, duty in study.duty.items():
            fault = not_simulated(design.drive, duty)
            if fault is not None and duty.closed and name not in study.scenarios:
                yield f"duty.{name} is not written as a scenario of designs like {template}: {fault}"


def _searched(request: StudyRequest, progress: Progress | None) -> dict[str, Found]:
    """What the search over drives like each template found."""
    names = request.templates
    searches = [_search_of(request.study.drives[name]) for name in names]
    work = [_WORK[search] for search in searches]
    ends = np.cumsum([0.0, *work]) / sum(work)
    found: dict[str, Found] = {}
    for place, (name, search) in enumerate(zip(names, searches, strict=True)):
        said = part_of(progress, float(ends[place]), float(ends[place + 1]), f"{name}: " if len(names) > 1 else "")
        found[name] = search_tries(request.like(name), search, said)
    return found


def _search_of(template: Any) -> Search:
    """The search over drives, or machines, like a template."""
    if is_machine(template):
        kinds = (("leg", legged), ("separate", separate))
        return next((search for kind, search in kinds if getattr(template, kind, None) is not None), rolling)
    return cobotic if isinstance(template, CoboticDrive) else geared


def _ordered(designs: list[SizedDrive], request: StudyRequest) -> list[SizedDrive]:
    """The first designs by the first objective; those of one template keep their order."""
    return sorted(designs, key=request.order)[: request.top]


def _front(designs: list[SizedDrive]) -> list[SizedDrive]:
    """Designs of which no other has less mass and less power, by power."""
    if not designs:
        return []
    mass, power = (np.array([getattr(one, name) for one in designs]) for name in ("mass", "power"))
    return [designs[place] for place in front(mass, power)]


def with_hanging(sizing: Sizing) -> Sizing:
    """The result with what its verdict hangs on, if it has designs."""
    of_power = sizing.objective[0] == "energy" or not of_machines(sizing.study)
    return replace(sizing, hangs_on=hanging_designs(sizing)) if sizing.best_of and of_power else sizing


def hanging_designs(sizing: Sizing) -> Hanging:
    """What the verdict hangs on: the best design like each template, as found, without another search.

    By energy, each is judged by its power alone: another search would find a design within all limits. By mass, space or price,
    by whether it is still feasible.
    """
    study = _designs(sizing)
    if of_machines(study):
        return hanging_machines(compare_machines(study))
    measure = MEASURES[sizing.objective[0]]
    shares = equal_shares(study.duty)
    services = {name: study.service(one.drive) for name, one in sizing.best_of.items()} if measure.built else {}

    def judge(name: str, drive: Any, variant: Variant) -> Judged:
        cycles = {task: energy_and_feasibility(drive, duty, study.travel, SPARE) for task, duty in study.duty.items()}
        if measure.built is None:
            power = sum(shares[task] * energy / study.duty[task].period for task, (energy, _) in cycles.items())
            return Judged(math.isfinite(power), (power,))
        able = all(feasible for _, feasible in cycles.values())
        if able and variant.scope == "all" and study.requirement is not None:
            able = covers(drive, study.requirement, SPARE)
        return Judged(able, (measure.scale * measure.built(drive, services[name]),))

    used = {name: Judged(True, (measure.scale * measure.of(one),)) for name, one in sizing.best_of.items()}
    requested = [one for one in variants(study) if study.duty or one.scope == "all"]
    answers = [*requested, *(_structures(sizing, study) if measure.built else best_speeds(study))]
    figure = f"{measure.name}, where feasible" if measure.built else f"{measure.words} of the best designs"
    return hang(answers, judge, used, study.titles, f"{figure}, without another search", measure.unit)


def _structures(sizing: Sizing, study: Study) -> Iterator[Variant]:
    """Yield the designs with each assumed factor of their structures wrong by `DOUBT`, in all of them alike."""
    anew = {name: tube_as_of(drive, sizing.study.drives[name]) for name, drive in study.drives.items()}
    unit = {one.name: one.metadata["unit"] for one in fields(Structure) if "unit" in one.metadata}
    for name, by in doubts(space=sizing.objective[0] == "space"):
        drives = {of: with_factor(drive, name, by) for of, drive in anew.items()}
        values = dict.fromkeys(getattr(value_at(drive, "structure"), name) for drive in study.drives.values())
        used, instead = (" or ".join(shown(factor * value, unit[name]) for value in values) for factor in (1.0, by))
        yield Variant(f"structure: {name.replace('_', ' ')}", used, instead, drives, "run")


def _designs(sizing: Sizing) -> Study:
    """The study with the best design like each template as its drives, and the source of each value."""
    each = [study_of(sizing.study, design, sizing.study.name) for design in sizing.best_of.values()]
    return replace(
        each[0],
        drives={name: one.drives[name] for name, one in zip(sizing.best_of, each, strict=True)},
        titles={name: name for name in sizing.best_of},
        provenance=tuple(row for one in each for row in one.provenance),
    )
