"""The best drives for a study among all parts of some sets."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np

from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import axis_fault
from infinivar.errors import InputError, ParameterError, require
from infinivar.parts.gearhead import LossModel
from infinivar.sizing.design import FreeValue, SizedDrive
from infinivar.sizing.geared.result import Design, GearedSizing, Progress
from infinivar.sizing.geared.search import nearest_geared, size_geared
from infinivar.sizing.pool import PartPool, pool
from infinivar.sizing.result import SearchRecord, Sizing
from infinivar.study.study import Study

Aim = Literal["energy", "mass"]

RANGE = 5.0
"""Radii are searched from the template's divided by this to the template's times this, unless a range is given."""

_AIMS = ("energy", "mass")


def size(
    study: Study,
    *,
    objective: Aim | Sequence[Aim] | None = None,
    top: int = 20,
    sets: str | Path | Sequence[str | Path] | None = None,
    drive: str | None = None,
    radius: tuple[float, float] | None = None,
    loss_model: LossModel | None = None,
    progress: Progress | None = None,
) -> Sizing:
    """Find the best drives for a study among all motors and gearheads of some sets.

    A drive of the study is the template: its output stage, guideway, amplifier, springs, linkage and inertia count, its motor and
    gearhead are replaced. Candidates are judged by the requirement and all duty cycles of the study.

    Parameters
    ----------
    study : Study
    objective : str or sequence   "energy", "mass" or both; designs are ordered by the first, and two give the front of both as
        well. Both by default, energy first; mass for a study without motions.
    top : int                     Number of designs to return, besides those of the front.
    sets : name, path or several  Sets of parts; by default all that can be had: shipped, in a folder parts beside the study or in
        the working directory, yours, and those of installed packages.
    drive : str                   Template; by default the first drive of the study that can be one.
    radius : (float, float)       Least and largest radius of the template's pulley; by default a fifth and five times the
        template's. Other output stages stay as they are. [m]
    loss_model : str              coulomb or proportional, of all gearheads; by default that of the template's.
    progress : callable           Called with words on the best design so far and the share of work done, 0 to 1.

    Returns
    -------
    Sizing   Empty of designs if no candidate is feasible; then with the nearest miss.

    Raises
    ------
    InputError
        If the study has no template or nothing to judge by, a set cannot be read, or an argument is out of range.
    """
    aims = _aims(study, objective)
    name = _template(study, drive)
    require(isinstance(top, int) and not isinstance(top, bool) and top >= 1, "top", top, ">= 1")
    asked = [sets] if isinstance(sets, str | Path) else sets
    beside = [] if study.path is None else [study.path.parent / "parts"]
    parts = pool(asked, [*beside, Path("parts")])
    designs, front, record = _geared(study, name, parts, aims, top, radius, loss_model, progress)
    return Sizing(
        study=study,
        objective=aims,
        designs=tuple(designs),
        front=tuple(front),
        searches={name: record},
        sets=parts.sets,
    )


def _aims(study: Study, objective: Aim | Iterable[Aim] | None) -> tuple[str, ...]:
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


def _template(study: Study, drive: str | None) -> str:
    """Name of the template."""
    able = [name for name, one in study.drives.items() if isinstance(one, ConventionalDrive)]
    if drive is not None:
        found = study.drive(drive)
        if not isinstance(found, ConventionalDrive):
            known = f"; drives that can: {', '.join(able)}" if able else ""
            raise InputError(
                f"drives.{drive} cannot be a template: the search is over drives of type conventional{known}"
            )
        return drive
    if not able:
        raise InputError(
            'the study has no drive that can be a template: add a table [drives.NAME] with type = "conventional"'
        )
    return able[0]


def _geared(
    study: Study,
    name: str,
    parts: PartPool,
    aims: tuple[str, ...],
    top: int,
    radius: tuple[float, float] | None,
    loss_model: LossModel | None,
    progress: Progress | None,
) -> tuple[list[SizedDrive], list[SizedDrive], SearchRecord]:
    """Search over geared drives: the best designs, the front and the record."""
    template = study.drives[name]
    assert isinstance(template, ConventionalDrive)
    if study.requirement is not None:
        fault = axis_fault(template, study.requirement.axis, f"drives.{name}", "the requirement")
        if fault is not None:
            raise InputError(fault)
    if template.pulley is not None and radius is None:
        radius = template.pulley.radius / RANGE, template.pulley.radius * RANGE
    asked: dict[str, Any] = {
        "duty": study.duty,
        "requirement": study.requirement,
        "radius": radius,
        "travel": study.travel,
        "loss_model": loss_model,
    }
    tables = template, parts.motors, parts.gearheads, parts.pairs
    searches: list[Any] = [aims[0], *(["front"] if len(aims) > 1 else [])]
    found: list[GearedSizing] = []
    for place, aim in enumerate(searches):
        said = None if progress is None else _part_of(progress, place, len(searches))
        found.append(size_geared(*tables, **asked, objective=aim, top=top, progress=said))
    first = found[0]
    nearest = None if first.designs else nearest_geared(*tables, **asked)
    ranges = {} if radius is None else {"pulley.radius": radius}
    record = SearchRecord(
        candidates=first.candidates,
        left=int(first.feasible.sum()),
        evaluated=int(first.evaluated.sum()),
        excluded=_excluded(found),
        counts=first.counts,
        unchecked=first.unchecked,
        ranges=ranges,
        cloud=_cloud(parts, found),
        nearest=None if nearest is None else _design(name, parts, nearest),
    )
    fronts = found[1].designs if len(found) > 1 else ()
    return [_design(name, parts, one) for one in first.designs], [_design(name, parts, one) for one in fronts], record


def _part_of(progress: Progress, place: int, count: int) -> Callable[[str, float], None]:
    return lambda said, share: progress(said, (place + share) / count)


def _excluded(found: Sequence[GearedSizing]) -> dict[str, int]:
    """Reasons of the first search, and those for which the front alone leaves candidates out."""
    first = dict(found[0].excluded)
    more = {
        f"{reason}: left out of the front": number
        for one in found[1:]
        for reason, number in one.excluded.items()
        if reason not in first
    }
    return {**first, **more}


def _cloud(parts: PartPool, found: Sequence[GearedSizing]) -> np.ndarray:
    """Mass and power of the feasible candidates evaluated. (n, 2)"""
    mass = parts.motors["mass"][parts.pairs[:, 0]] + parts.gearheads["mass"][parts.pairs[:, 1]]
    points = [
        np.stack(np.broadcast_arrays(mass, one.power), axis=-1)[one.evaluated & np.isfinite(one.power)] for one in found
    ]
    return np.concatenate(points)


def _design(name: str, parts: PartPool, found: Design) -> SizedDrive:
    pulley, (low, high) = found.drive.pulley, found.radii
    free = {} if pulley is None else {"pulley.radius": FreeValue(value=pulley.radius, low=low, high=high, unit="m")}
    return SizedDrive(
        template=name,
        parts={"motor": parts.part("motors", found.motor), "gearhead": parts.part("gearheads", found.gearhead)},
        free=free,
        drive=found.drive,
        mass=found.mass,
        power=found.power,
        demands=found.demands,
        unchecked=found.unchecked,
    )
