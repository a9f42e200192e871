"""The best drives for a study among all parts of some sets.

If asked, the best designs are evaluated again with another answer to each open choice: what the verdict depends on.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from infinivar._core.pareto import front
from infinivar.analysis.cycles.duty_cycle import energy_and_feasibility
from infinivar.analysis.deciding import best_speeds
from infinivar.analysis.hanging import Hanging, Judged, hang
from infinivar.analysis.region import covers
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import axis_fault, refuse_machine
from infinivar.errors import InputError, ParameterError, nearest, require
from infinivar.parts.gearhead import LossModel
from infinivar.parts.linear import Pulley
from infinivar.parts.screw import Screw
from infinivar.sizing.cobotic.wheels import FREE, check_template
from infinivar.sizing.design import SizedDrive
from infinivar.sizing.geared.search import equal_shares
from infinivar.sizing.geared.tally import SPARE
from infinivar.sizing.of_cobotic import cobotic
from infinivar.sizing.of_geared import geared
from infinivar.sizing.pool import PartPool, pool_of
from infinivar.sizing.progress import Progress, part_of
from infinivar.sizing.request import Found, Request
from infinivar.sizing.result import Sizing
from infinivar.sizing.robustness import check_builds, with_builds
from infinivar.sizing.studies import not_simulated, not_taken_over, study_of
from infinivar.sizing.what_if import what_if
from infinivar.study.check import check_study
from infinivar.study.choices import Variant, variants
from infinivar.study.study import Study

Aim = Literal["energy", "mass"]

_AIMS = ("energy", "mass")

GENERATIONS = 40
"""Of the search over cobotic drives."""

SLIP_MARGIN = 1.1
"""Slip force over lateral force: a wheel that slips in a transient no longer steers."""

_OPTIONS = {
    "geared": ("radius", "leads"),
    "cobotic": ("ranges", "steering_ratios", "slip_margin", "life", "generations", "seed"),
}
"""Options for one architecture only."""

_WORK = {"geared": 1.0, "cobotic": 4.0}
"""Parts of the time that the searches take, for the progress."""


def size(
    study: Study,
    *,
    objective: Aim | Sequence[Aim] | None = None,
    top: int = 20,
    sets: str | Path | Sequence[str | Path] | None = None,
    drive: str | Sequence[str] | None = None,
    radius: tuple[float, float] | None = None,
    leads: Sequence[float] | None = None,
    ranges: Mapping[str, tuple[float, float]] | None = None,
    steering_ratios: Sequence[float] | None = None,
    slip_margin: float | None = None,
    life: float | None = None,
    loss_model: LossModel | None = None,
    generations: int | None = None,
    seed: int | None = None,
    builds: int = 0,
    progress: Progress | None = None,
) -> Sizing:
    """Find the best geared and cobotic drives for a study among all parts of some sets.

    A geared and a cobotic drive of the study are the templates. Of a geared one, motor, gearhead and the radius of a pulley are
    searched; of a cobotic one both motors, the gearhead, the axle bearing, the steering ratio and the five values of `ranges`.
    All else stays. Candidates are judged by the requirement and all duty cycles of the study.

    Parameters
    ----------
    study : Study
    objective : str or sequence   "energy", "mass" or both; designs are ordered by the first, and two give the front of both as
        well. Both by default, energy first; mass for a study without motions.
    top : int                     Number of designs to return, besides those of the front.
    sets : name, path or several  Sets of parts; by default all that can be had: shipped, in a folder parts beside the study or in
        the working directory, yours, and those of installed packages.
    drive : str or several        Templates; by default the first geared and the first cobotic drive of the study that can be one.
    radius : (float, float)       Least and largest radius of the pulley of geared drives; by default a fifth and five times the
        template's. [m]
    leads : sequence              Of geared drives with a screw: leads that can be bought, each tried with every pair; the
        screw's other values stay. Without them, and with other output stages, the stage stays as it is. [m]
    ranges : mapping              Of cobotic drives: least and largest cylinder_radius [m], cylinder_speed [rad s^-1],
        wheel_radius [m], crown_radius [m] and preload [N]; by default half and twice the template's. Equal ends fix a value.
    steering_ratios : sequence    Of cobotic drives, between steering motor and bell; by default five from half to twice the
        template's. [-]
    slip_margin : float           Of cobotic drives: slip force over lateral force that is wanted, at least 1; demands for slip
        count it; 1.1 by default. [-]
    life : float                  Of cobotic drives: wanted life of the axle bearings, at the loads of their friction. [s]
    loss_model : str              coulomb, proportional or strain wave, of all gearheads; by default that of the template's.
    generations, seed : int       Of the search over cobotic drives, 40 and 0 by default; the same seed gives the same result.
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
    check_study(study)
    aims = aims_of(study, objective)
    names, notes = templates_of(study, drive)
    require(isinstance(top, int) and not isinstance(top, bool) and top >= 1, "top", top, ">= 1")
    for word, number, least in (("generations", generations, 1), ("seed", seed, 0)):
        whole = number is None or (isinstance(number, int) and not isinstance(number, bool) and number >= least)
        require(whole, word, number, f"a whole number >= {least}")
    if builds:
        check_builds(builds)
    given: dict[str, Any] = {
        "radius": radius,
        "leads": leads,
        "ranges": ranges or None,
        "steering_ratios": steering_ratios,
        "slip_margin": slip_margin,
        "life": life,
        "generations": generations,
        "seed": seed,
    }
    check_options(study, names, {name: value for name, value in given.items() if value is not None})
    slip_margin = SLIP_MARGIN if slip_margin is None else slip_margin
    requested = Request(
        study=study,
        parts=pool_of(study, sets),
        aims=aims,
        top=top,
        radius=radius,
        leads=tuple(leads or ()),
        ranges=ranges or {},
        steering_ratios=None if steering_ratios is None else tuple(steering_ratios),
        slip_margin=slip_margin,
        life=life,
        loss_model=loss_model,
        generations=GENERATIONS if generations is None else generations,
        seed=seed or 0,
    )
    found = _searched(requested, names, progress)
    if progress is not None:
        progress("what would have to change", 1.0)
    made = sizing_of(study, requested.parts, aims, found, top=top, slip_margin=slip_margin, notes=notes)
    return with_builds(with_hanging(made), builds, progress)


def sizing_of(
    study: Study,
    parts: PartPool,
    aims: tuple[str, ...],
    found: Mapping[str, Found],
    *,
    top: int,
    slip_margin: float = SLIP_MARGIN,
    notes: Sequence[str] = (),
) -> Sizing:
    """What searches found, by template, as one result; other arguments as for `size`."""
    best_of = {name: each.designs[0] for name, each in found.items() if each.designs}
    missed = {name: each.record.nearest for name, each in found.items() if each.record.nearest is not None}
    designs = _ordered([one for each in found.values() for one in each.designs], aims)[:top]
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
        what_if=what_if(study, aims[0], best_of, missed, slip_margin),
        notes=(
            *notes,
            *not_taken_over(study, best_of),
            *_not_simulated(study, best_of),
            *parts.unread,
            *parts.contradictions(chosen_parts),
        ),
    )


def _not_simulated(study: Study, best_of: Mapping[str, SizedDrive]) -> Iterator[str]:
    """Motions that the studies of designs do not have as scenarios, and why."""
    for template, design in best_of.items():
        for name, duty in study.duty.items():
            fault = not_simulated(design.drive, duty)
            if fault is not None and duty.closed and name not in study.scenarios:
                yield f"duty.{name} is not written as a scenario of designs like {template}: {fault}"


def _searched(requested: Request, names: Sequence[str], progress: Progress | None) -> dict[str, Found]:
    """What the search over drives like each template found."""
    drives = [requested.study.drives[name] for name in names]
    work = [_WORK["cobotic" if isinstance(one, CoboticDrive) else "geared"] for one in drives]
    ends = np.cumsum([0.0, *work]) / sum(work)
    found: dict[str, Found] = {}
    for place, (name, template) in enumerate(zip(names, drives, strict=True)):
        said = part_of(progress, float(ends[place]), float(ends[place + 1]), f"{name}: " if len(names) > 1 else "")
        own = requested._replace(parts=requested.parts.like(requested.study, name))
        if isinstance(template, CoboticDrive):
            found[name] = cobotic(own, name, template, said)
        else:
            assert isinstance(template, ConventionalDrive)
            found[name] = geared(own, name, template, said)
    return found


def _ordered(designs: list[SizedDrive], aims: tuple[str, ...]) -> list[SizedDrive]:
    """Designs by the first objective; those of one template keep their order."""
    by_mass = aims[0] == "mass"
    return sorted(designs, key=lambda one: one.mass if by_mass else one.power)


def _front(designs: list[SizedDrive]) -> list[SizedDrive]:
    """Designs of which no other has less mass and less power, by power."""
    if not designs:
        return []
    mass, power = (np.array([getattr(one, name) for one in designs]) for name in ("mass", "power"))
    return [designs[place] for place in front(mass, power)]


def aims_of(study: Study, objective: Aim | Iterable[Aim] | None) -> tuple[str, ...]:
    """Objectives of a search for a study, those by default if none is given."""
    if objective is None:
        return _AIMS if study.duty else ("mass",)
    aims = (objective,) if isinstance(objective, str) else tuple(objective)
    if not aims or len({*aims}) < len(aims) or any(aim not in _AIMS for aim in aims):
        raise ParameterError(f"objective must be energy, mass or both, got {', '.join(map(str, aims)) or 'none'}")
    if "energy" in aims and not study.duty:
        raise InputError(
            "objective = energy needs a motion: add a table [duty.NAME] to the study, or use the objective mass"
        )
    return aims


def templates_of(study: Study, drive: str | Sequence[str] | None) -> tuple[list[str], tuple[str, ...]]:
    """Names of the templates, and why the study's only drive of an architecture is none."""
    for name, one in study.drives.items():
        refuse_machine(one, "size", f"drives.{name}")
    if drive is not None:
        names = [drive] if isinstance(drive, str) else list(dict.fromkeys(drive))
        if not names:
            raise InputError("drive must name at least one drive of the study")
        for name in names:
            fault = _fault(study, name)
            if fault is not None:
                raise InputError(f"drives.{name} cannot be a template: {fault}")
        return names, ()
    names, notes = [], []
    for kind in (ConventionalDrive, CoboticDrive):
        known = [name for name, one in study.drives.items() if isinstance(one, kind)]
        able = [name for name in known if _fault(study, name) is None]
        names += able[:1]
        if known and not able:
            notes.append(f"drives.{known[0]} was not searched: {_fault(study, known[0])}")
    if not names:
        raise InputError(
            notes[0]
            if notes
            else 'the study has no drive that can be a template: add a table [drives.NAME] with type = "conventional", or with a '
            "cobotic drive"
        )
    return names, tuple(notes)


def _fault(study: Study, name: str) -> str | None:
    """Why a drive cannot be a template; None if it can."""
    drive = study.drive(name)
    if not isinstance(drive, ConventionalDrive | CoboticDrive):
        return "the search is over drives of type conventional and cobotic drives"
    if isinstance(drive, CoboticDrive):
        try:
            check_template(drive, bool(study.duty))
        except ParameterError as problem:
            return str(problem)
    if study.requirement is not None:
        return axis_fault(drive, study.requirement.axis, f"drives.{name}", "the requirement")
    return None


def check_options(study: Study, names: Sequence[str], given: Mapping[str, Any]) -> None:
    """Raise InputError for an option that no template has a use for, or that is out of range; `given` has the options stated."""
    drives = [study.drives[name] for name in names]
    for kind, one in (("geared", ConventionalDrive), ("cobotic", CoboticDrive)):
        useless = [name for name in _OPTIONS[kind] if name in given]
        if useless and not any(isinstance(drive, one) for drive in drives):
            raise InputError(f"{', '.join(useless)}: for {kind} drives only; no {kind} drive is searched")
    stages = [drive.stage for drive in drives if isinstance(drive, ConventionalDrive)]
    for name, stage in (("radius", Pulley), ("leads", Screw)):
        if name in given and not any(isinstance(one, stage) for one in stages):
            fate = "whose radius is searched" if isinstance(stages[0], Pulley) else "which stays as it is"
            raise InputError(f"{name}: the template has no {stage.title}, but a {stages[0].title}, {fate}")
    for name, what, unit in (("leads", "lead", "m"), ("steering_ratios", "ratio", "")):
        values = tuple(given.get(name, (1.0,)))
        fine = len(values) > 0 and all(0.0 < one < math.inf for one in values) and len({*values}) == len(values)
        require(fine, name, values, f"one {what} or several different ones, each > 0", unit)
    for name, ends in given.get("ranges", {}).items():
        if name not in FREE:
            raise InputError(
                f"ranges has an unknown entry {name!r}{nearest(name, FREE)}; known entries: {', '.join(FREE)}"
            )
        fine = len(ends) == 2 and 0.0 < ends[0] <= ends[1] < math.inf
        require(fine, f"ranges[{name!r}]", tuple(ends), "a range above 0, least first")


def with_hanging(sizing: Sizing) -> Sizing:
    """The result with what its verdict hangs on, if it has designs."""
    return replace(sizing, hangs_on=hanging_designs(sizing)) if sizing.best_of else sizing


def hanging_designs(sizing: Sizing) -> Hanging:
    """What the verdict hangs on: the best design like each template, as found, without another search.

    By energy, each is judged by its power alone: another search would find a design within all limits. By mass, by whether it
    is still feasible.
    """
    study = _designs(sizing)
    by_mass = sizing.objective[0] == "mass"
    shares = equal_shares(study.duty)

    def judge(name: str, drive: Any, variant: Variant) -> Judged:
        cycles = {task: energy_and_feasibility(drive, duty, study.travel, SPARE) for task, duty in study.duty.items()}
        if not by_mass:
            power = sum(shares[task] * energy / study.duty[task].period for task, (energy, _) in cycles.items())
            return Judged(math.isfinite(power), (power,))
        able = all(feasible for _, feasible in cycles.values())
        if able and variant.scope == "all" and study.requirement is not None:
            able = covers(drive, study.requirement, SPARE)
        return Judged(able, (sizing.best_of[name].mass,))

    used = {name: Judged(True, (one.mass if by_mass else one.power,)) for name, one in sizing.best_of.items()}
    requested = [one for one in variants(study) if study.duty or one.scope == "all"]
    answers = requested if by_mass else [*requested, *best_speeds(study)]
    figure, unit = ("mass, where feasible", "kg") if by_mass else ("mean power of the best designs", "W")
    figure += ", without another search"
    return hang(answers, judge, used, study.titles, figure, unit)


def _designs(sizing: Sizing) -> Study:
    """The study with the best design like each template as its drives, and the source of each value."""
    each = [study_of(sizing.study, design, sizing.study.name) for design in sizing.best_of.values()]
    return replace(
        each[0],
        drives={name: one.drives[name] for name, one in zip(sizing.best_of, each, strict=True)},
        titles={name: name for name in sizing.best_of},
        provenance=tuple(row for one in each for row in one.provenance),
    )
