"""What `size` and the sweeps of its searches have to find: one frozen value with all options, checked."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import Drive, axis_fault, refuse_machine
from infinivar.errors import InputError, ParameterError, nearest, require
from infinivar.parts.gearhead import LossModel
from infinivar.parts.linear import Pulley
from infinivar.parts.stage import OutputStage
from infinivar.sizing.cobotic.space import FREE
from infinivar.sizing.cobotic.wheels import check_template
from infinivar.sizing.design import RANGED, SizedDrive
from infinivar.sizing.found import FoundDesign
from infinivar.sizing.machine_templates import check_machine_options, machine_templates, of_machines, weighed
from infinivar.sizing.measures import MEASURES
from infinivar.sizing.options import BOTH, GENERATIONS, OBJECTIVES, SLIP_MARGIN, Aim, SizeOptions, fine_aims
from infinivar.sizing.pool import PartPool, pool_of
from infinivar.sizing.records import SearchRecord, WheelRecord
from infinivar.sizing.tries import Try, tries_of
from infinivar.study.check import check_study
from infinivar.study.study import Study

R = TypeVar("R")

_OPTIONS = {
    "geared": SizeOptions.GEARED,
    "cobotic": (*SizeOptions.COBOTIC, "generations", "seed"),
}
"""Options for one architecture only."""

_KINDS: Mapping[str, type[Drive]] = {"geared": ConventionalDrive, "cobotic": CoboticDrive}
"""Architectures that are searched."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StudyRequest:
    """What a search for a study has to find, and among what; made by `request_of`.

    Attributes
    ----------
    study             With the requirement, the motions and the templates.
    templates         Names of the drives of the study whose other parts all candidates have.
    notes             Why the study's only drive of an architecture is no template.
    parts             Motors, gearheads and pairs.
    aims              Objectives, of `MEASURES`; designs are ordered by the first, and two ask for a front.
    top               Number of designs to return, besides those of the front.
    radius            Range of the pulley of geared drives; None for that around the template's. [m]
    stages            Output stages of geared drives to try with every pair instead.
    tries             Values of the templates to try, by template; each combination is a search.
    ranges            Of the free values of cobotic drives, by name.
    wheels            Numbers of wheels of cobotic drives; empty for 1, 2 and 3.
    steering_ratios   Between steering motor and bell; None for those around the template's. [-]
    slip_margin       Slip force over lateral force that is wanted. [-]
    life              Of axle and cylinder bearings of cobotic drives; None for any. [s]
    loss_model        Of all gearheads; None for that of the template's.
    generations, seed   Of the search over cobotic drives.
    """

    study: Study
    templates: tuple[str, ...]
    notes: tuple[str, ...] = ()
    parts: PartPool
    aims: tuple[str, ...]
    top: int
    radius: tuple[float, float] | None = None
    stages: tuple[OutputStage, ...] = ()
    tries: Mapping[str, tuple[Try, ...]] = field(default_factory=dict)
    ranges: Mapping[str, tuple[float, float]]
    wheels: tuple[int, ...] = ()
    steering_ratios: tuple[float, ...] | None = None
    slip_margin: float = SLIP_MARGIN
    life: float | None = None
    loss_model: LossModel | None = None
    generations: int = GENERATIONS
    seed: int = 0

    @property
    def objectives(self) -> list[Any]:
        """Objectives of the searches over geared drives: the first, and the front of two."""
        return [self.aims[0], *(["front"] if len(self.aims) > 1 else [])]

    def order(self, design: SizedDrive | FoundDesign) -> tuple[float, float, float]:
        """By which designs are ordered: the first objective, of equals the mass, then the power; what is not known comes last."""
        mass, power = (math.inf if math.isnan(one) else one for one in (design.mass, design.power))
        return self.value(design), mass, power

    def value(self, design: SizedDrive | FoundDesign) -> float:
        """What the first objective makes small."""
        return MEASURES[self.aims[0]].of(design)

    @property
    def name(self) -> str:
        """Of the first template."""
        return self.templates[0]

    @property
    def template(self) -> Any:
        """The first template."""
        return self.study.drives[self.name]

    def on_tables(self, kind: Callable[..., R], **own: Any) -> R:
        """The search over tables for the first template; `own` has the options of its architecture."""
        study, parts = self.study, self.parts
        return kind(
            template=self.template,
            motors=parts.motors_as("motor"),
            gearheads=parts.gearheads,
            pairs=parts.pairs,
            duty=study.duty,
            requirement=study.requirement,
            travel=study.travel,
            envelope=study.envelope,
            loss_model=self.loss_model,
            top=self.top,
            **own,
        )

    def like(self, name: str) -> StudyRequest:
        """The search over drives like one template."""
        return replace(self, templates=(name,), parts=self.parts.like(self.study, name))


class Found(NamedTuple):
    """What a search over drives like one template found."""

    designs: list[SizedDrive]
    front: list[SizedDrive]
    record: SearchRecord | WheelRecord


def request_of(
    study: Study,
    kind: str | None = None,
    *,
    objective: Aim | Iterable[Aim] | None,
    top: int,
    sets: str | Path | Sequence[str | Path] | None,
    drive: str | Sequence[str] | None,
    loss_model: LossModel | None = None,
    **options: Any,
) -> StudyRequest:
    """Check what a search is given; arguments and errors as for `size`, `options` being those for one architecture.

    With a `kind`, geared or cobotic, the search is over drives like the first template of this architecture alone.
    """
    check_study(study)
    aims = _aims(study, objective)
    for name, one in study.drives.items() if kind is not None else ():
        refuse_machine(one, "sweep", f"drives.{name}")
    templates, notes = _templates(study, drive)
    if objective is None and of_machines(study) and not all(weighed(study.drives[name]) for name in templates):
        aims = ("energy",)
    if kind is not None:
        templates, notes = [_first(study, templates, notes, kind)], ()
    require(isinstance(top, int) and not isinstance(top, bool) and top >= 1, "top", top, ">= 1")
    for word, least in (("generations", 1), ("seed", 0)):
        number = options.get(word)
        whole = number is None or (isinstance(number, int) and not isinstance(number, bool) and number >= least)
        require(whole, word, number, f"a whole number >= {least}")
    ranges, tries = options.pop("ranges", None) or {}, options.pop("tries", None)
    stated = {name: value for name, value in options.items() if value is not None}
    given = stated | ({"ranges": ranges} if ranges else {}) | ({} if tries is None else {"tries": tries})
    if of_machines(study):
        check_machine_options(study, templates, aims, given)
    _check_options(study, templates, given)
    kinds = {"steering_ratios": float, "wheels": int}
    several = {name: tuple(map(kind, stated[name])) for name, kind in kinds.items() if name in stated}
    request = StudyRequest(
        study=study,
        templates=tuple(templates),
        notes=notes,
        parts=pool_of(study, sets),
        aims=aims,
        top=top,
        ranges=ranges,
        tries={} if tries is None else tries_of(study, templates, tries),
        loss_model=loss_model,
        **{**stated, **several},
    )
    return request if kind is None else request.like(request.name)


def _first(study: Study, names: Sequence[str], notes: Sequence[str], kind: str) -> str:
    """Name of the first template of an architecture."""
    found = next((name for name in names if isinstance(study.drives[name], _KINDS[kind])), None)
    if found is None:
        why = notes[0] if notes else f"drives.{names[0]} is not one"
        raise InputError(f"the study has no {kind} drive that can be a template: {why}")
    return found


def _aims(study: Study, objective: Aim | Iterable[Aim] | None) -> tuple[str, ...]:
    """Objectives of a search for a study, those by default if none is given."""
    if objective is None:
        return BOTH if study.moves else ("mass",)
    aims = (objective,) if isinstance(objective, str) else tuple(objective)
    if not fine_aims(aims):
        raise ParameterError(f"objective must be {OBJECTIVES}, got {', '.join(map(str, aims)) or 'none'}")
    if "energy" in aims and not study.moves:
        raise InputError(
            "objective = energy needs a motion: add a table [duty.NAME] to the study, or use the objective mass"
        )
    return aims


def _templates(study: Study, drive: str | Sequence[str] | None) -> tuple[list[str], tuple[str, ...]]:
    """Names of the templates, and why the study's only drive of an architecture is none."""
    stated = [drive] if isinstance(drive, str) else None if drive is None else list(dict.fromkeys(drive))
    if stated == []:
        raise InputError("drive must name at least one drive of the study")
    if of_machines(study):
        return machine_templates(study, stated)
    if stated is not None:
        names = stated
        for name in names:
            fault = _fault(study, name)
            if fault is not None:
                raise InputError(f"drives.{name} cannot be a template: {fault}")
        return names, ()
    names, notes = [], []
    for kind in _KINDS.values():
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


def _check_useful(drives: Sequence[Any], given: Mapping[str, Any]) -> None:
    """Raise InputError for an option that no template has a use for."""
    for kind, one in _KINDS.items():
        useless = [name for name in _OPTIONS[kind] if name in given]
        if useless and not any(isinstance(drive, one) for drive in drives):
            raise InputError(f"{', '.join(useless)}: for {kind} drives only; no {kind} drive is searched")
    stages = [drive.stage for drive in drives if isinstance(drive, ConventionalDrive)]
    if "radius" in given and not any(isinstance(one, Pulley) for one in stages):
        raise InputError(f"radius: the template has no pulley, but a {stages[0].title}, which stays as it is")


def _check_options(study: Study, names: Sequence[str], given: Mapping[str, Any]) -> None:
    """Raise InputError for an option that no template has a use for, or that is out of range; `given` has the options stated."""
    if not of_machines(study):
        _check_useful([study.drives[name] for name in names], given)
    ratios = tuple(given.get("steering_ratios", (1.0,)))
    fine = len(ratios) > 0 and all(0.0 < one < math.inf for one in ratios) and len({*ratios}) == len(ratios)
    require(fine, "steering_ratios", ratios, "one ratio or several different ones, each > 0")
    numbers = tuple(given.get("wheels", (1,)))
    fine = len({*numbers}) == len(numbers) > 0 and {*numbers} <= {1, 2, 3}
    said = ", ".join(f"{one:g}" for one in numbers) or "none"
    require(fine, "wheels", said, "one or several of 1, 2 and 3, each once")
    for name, ends in given.get("ranges", {}).items():
        known = RANGED if of_machines(study) else FREE
        if name not in known:
            raise InputError(
                f"ranges has an unknown entry {name!r}{nearest(name, known)}; known entries: {', '.join(known)}"
            )
        fine = len(ends) == 2 and 0.0 < ends[0] <= ends[1] < math.inf
        require(fine, f"ranges[{name!r}]", tuple(ends), "a range above 0, least first")
