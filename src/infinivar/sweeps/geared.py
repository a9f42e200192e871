"""Sweep over geared drives: all pairs of motor and gearhead, at the best radius of a pulley or at given output stages."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.errors import InputError, ParameterError, require
from infinivar.parts.gearhead import LossModel
from infinivar.parts.linear import Pulley
from infinivar.parts.stage import OutputStage
from infinivar.sizing.geared.candidates import LIMIT_FIELDS, Candidates, candidates
from infinivar.sizing.geared.result import Design, GearedSizing, best_so_far
from infinivar.sizing.geared.search import nearest_geared, size_geared
from infinivar.sizing.of_geared import RANGE, drive_of, excluded_by, stages_tried
from infinivar.sizing.pool import PartPool, pool_of
from infinivar.sizing.records import SearchRecord
from infinivar.sizing.request import Found
from infinivar.sizing.result import Sizing
from infinivar.sizing.size import Aim, aims_of, sizing_of, templates_of
from infinivar.study.check import check_study
from infinivar.study.study import Study
from infinivar.sweeps.designs import column_of, demands_of, each, key_of, limit_counts, rows_of
from infinivar.sweeps.fingerprint import fingerprint
from infinivar.sweeps.problem import CANDIDATES, FRONT, LIST, TOP, Best, Chunk
from infinivar.sweeps.sweep import Sweep, check_finished
from infinivar.units import show_in

TOP_OF_CHUNK = 50
"""Designs that each chunk keeps, besides those of its front."""
PAIRS = 20_000
"""Pairs in a chunk: some seconds of work, as each chunk evaluates its best at every instant."""
PAIRS_AT_STAGE = 200_000
"""The same with given output stages: what a stage asks of the gear's output is computed once for all pairs of a chunk."""

_ORDER = ("value", "worst", "stage", "pair")
_FEW = 10_000_000
"""Candidates among which the nearest miss is looked for."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GearedSweep:
    """Search of `size_geared` in chunks: the best designs, the front and the counts are the same.

    Attributes
    ----------
    study          With the requirement and the motions.
    drive          Name of the template in the study.
    parts          Motors, gearheads and pairs.
    objective      energy, mass or both; designs are ordered by the first.
    top            Number of designs to keep, besides those of the front.
    radius         Range of the pulley's radius; None with `stages`. [m]
    stages         Output stages to try with every pair; empty with `radius`.
    loss_model     Of all gearheads; None for that of the template's.
    size           Pairs in a chunk.
    """

    study: Study
    drive: str
    parts: PartPool
    objective: tuple[str, ...]
    top: int = TOP_OF_CHUNK
    radius: tuple[float, float] | None = None
    stages: tuple[OutputStage, ...] = ()
    loss_model: LossModel | None = None
    size: int = PAIRS

    @property
    def kind(self) -> str:
        """See `Problem`."""
        return "geared drives"

    @property
    def title(self) -> str:
        """See `Problem`."""
        return f"{self.study.name}, geared drives like {self.drive}"

    @property
    def template(self) -> ConventionalDrive:
        """Drive whose motor and gearhead are replaced."""
        found = self.study.drives[self.drive]
        assert isinstance(found, ConventionalDrive)
        return found

    @property
    def blocks(self) -> int:
        """Chunks of each output stage."""
        return max(1, math.ceil(len(self.parts.pairs) / self.size))

    @property
    def chunks(self) -> int:
        """See `Problem`."""
        return self.blocks * max(1, len(self.stages))

    @property
    def reducer(self) -> Best:
        """See `Problem`."""
        return Best(top=self.top, order=_ORDER, front=("mass_kg", "power_W"))

    @property
    def identity(self) -> Mapping[str, Any]:
        """See `Problem`."""
        tables = self.parts.motors_as("motor"), self.parts.gearheads, self.parts.pairs
        return {
            "study": self.study.name,
            "drive": self.drive,
            "values of the drive": fingerprint(self.template),
            "requirement": fingerprint(self.study.requirement, self.study.travel),
            "motions": fingerprint(self.study.duty),
            "sets": [one.name for one in self.parts.sets],
            "parts": fingerprint(*tables),
            "objective": list(self.objective),
            "top": self.top,
            "radius [m]": None if self.radius is None else list(self.radius),
            "stages": fingerprint(self.stages) if self.stages else None,
            "loss model": self.loss_model or self.template.gearhead.loss_model,
            "pairs in a chunk": self.size,
        }

    def run(self, number: int) -> Chunk:
        """See `Problem`."""
        stage, block = divmod(number, self.blocks)
        start = block * self.size
        pairs = self.parts.pairs[start : start + self.size]
        tables = self.template, self.parts.motors_as("motor"), self.parts.gearheads, pairs
        requested = self._asked(self.stages[stage : stage + 1])
        aims: list[Any] = [self.objective[0], *(["front"] if len(self.objective) > 1 else [])]
        found = [size_geared(*tables, **requested, objective=aim, top=self.top) for aim in aims]
        designs = [(TOP, one) for one in found[0].designs]
        designs += [(FRONT, one) for one in (found[1].designs if len(found) > 1 else ())]
        return Chunk(self._rows(designs, start, stage), _counts(found))

    def best(self, chunk: Chunk) -> tuple[float, str] | None:
        """See `Problem`."""
        places = np.flatnonzero(chunk.rows[LIST] == TOP) if chunk.rows else np.empty(0, dtype=int)
        if not places.size:
            return None
        first = places[np.argmin(chunk.rows["value"][places])]
        value, power, mass = (float(chunk.rows[name][first]) for name in ("value", "power_W", "mass_kg"))
        return value, best_so_far(power, mass)

    def result(self, sweep: Sweep) -> Sizing:
        """The best designs as drives, as `size` returns them; the cloud of the record has no others.

        Raises
        ------
        InputError
            If the sweep is not finished.
        """
        check_finished(sweep)
        found = candidates(
            self.template,
            self.parts.motors_as("motor"),
            self.parts.gearheads,
            self.parts.pairs,
            loss_model=self.loss_model or self.template.gearhead.loss_model,
            moving=bool(self.study.duty),
            weighed=False,
        )
        top, front = ([self._design(found, row) for row in each(sweep.list(name))] for name in (TOP, FRONT))
        nearest = self._nearest() if not top and sweep.candidates <= _FEW else None
        both = [*top, *front]
        counts = sweep.counts
        record = SearchRecord(
            candidates=sweep.candidates,
            left=counts["left"],
            evaluated=counts["evaluated"],
            excluded=counts["excluded"],
            counts=tuple(limit_counts(counts["limits"])),
            unchecked={key_of(f", {name}")[1:]: number for name, number in counts["unchecked"].items()},
            ranges={} if self.radius is None else {"pulley.radius": self.radius},
            cloud=np.array([(one.mass, one.power) for one in both]).reshape(-1, 2),
            nearest=None if nearest is None else drive_of(self.drive, self.parts, nearest),
            **stages_tried(self.stages),
        )
        designs, best_front = ([drive_of(self.drive, self.parts, one) for one in some] for some in (top, front))
        made = Found(designs, best_front, record)
        return sizing_of(self.study, self.parts, self.objective, {self.drive: made}, top=self.top)

    def _asked(self, stages: Sequence[OutputStage]) -> dict[str, Any]:
        """Arguments of the search."""
        return {
            "duty": self.study.duty,
            "requirement": self.study.requirement,
            "travel": self.study.travel,
            "radius": self.radius,
            "stages": list(stages) or None,
            "loss_model": self.loss_model,
        }

    def _nearest(self) -> Design | None:
        tables = self.template, self.parts.motors_as("motor"), self.parts.gearheads, self.parts.pairs
        return nearest_geared(*tables, **self._asked(self.stages), weighed=self.objective[0] == "mass")

    def _rows(self, designs: Sequence[tuple[str, Design]], start: int, stage: int) -> dict[str, np.ndarray]:
        """Designs as columns; a limit that does not load a design is nan."""
        aim = "mass" if self.objective[0] == "mass" else "power"
        rows: list[dict[str, Any]] = []
        for name, one in designs:
            parts = self.parts.motor("motor", one.motor), self.parts.part("gearheads", one.gearhead)
            rows.append(
                {
                    LIST: name,
                    "value": getattr(one, aim),
                    "worst": max(one.demands.values(), default=0.0),
                    "pair": start + one.pair,
                    "stage": stage,
                    "motor": parts[0].part,
                    "gearhead": parts[1].part,
                    "radius_m": one.stage.radius if isinstance(one.stage, Pulley) else np.nan,
                    "least_radius_m": one.radii[0],
                    "largest_radius_m": one.radii[1],
                    "mass_kg": one.mass,
                    "power_W": one.power,
                    **{column_of(key): demand for key, demand in one.demands.items()},
                }
            )
        return rows_of(rows)

    def _design(self, found: Candidates, row: Mapping[str, Any]) -> Design:
        pair = int(row["pair"])
        stage = self.stages[int(row["stage"])] if self.stages else self.template.stage
        if self.radius is not None and isinstance(stage, Pulley):
            stage = replace(stage, radius=float(row["radius_m"]))
        motor, gearhead = map(int, self.parts.pairs[pair])
        return Design(
            pair=pair,
            motor=motor,
            gearhead=gearhead,
            stage=stage,
            drive=found.drive(pair, stage),
            mass=float(row["mass_kg"]),
            power=float(row["power_W"]),
            radii=(float(row["least_radius_m"]), float(row["largest_radius_m"])),
            demands=demands_of(row),
            unchecked=tuple(key for key in LIMIT_FIELDS if not found.stated(key, np.array([pair]))[0]),
        )


def geared_sweep(
    study: Study,
    *,
    objective: Aim | Sequence[Aim] | None = None,
    top: int = TOP_OF_CHUNK,
    sets: str | Path | Sequence[str | Path] | None = None,
    drive: str | None = None,
    radius: tuple[float, float] | None = None,
    radii: int | None = None,
    stages: Sequence[OutputStage] = (),
    loss_model: LossModel | None = None,
    size: int | None = None,
) -> GearedSweep:
    """Prepare the search of `size` for geared drives as a sweep.

    Parameters
    ----------
    study, objective, top, sets, drive, radius, loss_model   As for `size`.
    radii : int         Number of radii of the range to try with every pair, in equal ratios, instead of the best one.
    stages : sequence   Output stages to try with every pair, instead of a range of the pulley's radius.
    size : int          Pairs in a chunk; by default 20,000, or 200,000 with given stages.

    Raises
    ------
    InputError
        As `size` does.
    """
    check_study(study)
    if size is None:
        size = PAIRS_AT_STAGE if stages or radii is not None else PAIRS
    for name, number in (("top", top), ("size", size)):
        require(isinstance(number, int) and not isinstance(number, bool) and number >= 1, name, number, ">= 1")
    if stages and (radius is not None or radii is not None):
        raise ParameterError("stages and radius are both given: state stages to try, or the range of a pulley's radius")
    name = _template(study, drive)
    template = study.drives[name]
    assert isinstance(template, ConventionalDrive)
    if template.pulley is not None and radius is None and not stages:
        radius = template.pulley.radius / RANGE, template.pulley.radius * RANGE
    if radii is not None:
        stages, radius = _stages(template, radius, radii), None
    return GearedSweep(
        study=study,
        drive=name,
        parts=pool_of(study, sets).like(study, name),
        objective=aims_of(study, objective),
        top=top,
        radius=radius,
        stages=tuple(stages),
        loss_model=loss_model,
        size=size,
    )


def _template(study: Study, drive: str | None) -> str:
    """Name of the geared drive that is the template."""
    names, notes = templates_of(study, drive)
    geared = [name for name in names if isinstance(study.drives[name], ConventionalDrive)]
    if not geared:
        why = notes[0] if notes else f"drives.{names[0]} is not one"
        raise InputError(f"the study has no geared drive that can be a template: {why}")
    return geared[0]


def _stages(template: ConventionalDrive, radius: tuple[float, float] | None, count: int) -> list[Pulley]:
    """Pulleys with radii in equal ratios."""
    if template.pulley is None or radius is None:
        raise ParameterError(f"radii does not apply to a {template.stage.title}: only a pulley has a range of radii")
    require(isinstance(count, int) and count >= 2, "radii", count, "a whole number >= 2")
    require(0.0 < radius[0] <= radius[1] < math.inf, "radius", radius, "a range above 0 m, the least radius first")
    if radius[0] == radius[1]:
        raise ParameterError(
            f"radii: {count} radii need a range, but both ends of radius are {show_in(radius[0], 'm', 'mm')}; leave out radii to "
            "search at this radius, or state a wider range"
        )
    return [replace(template.pulley, radius=float(one)) for one in np.geomspace(*radius, count)]


def _counts(found: Sequence[GearedSizing]) -> dict[str, Any]:
    first = found[0]
    return {
        CANDIDATES: first.candidates,
        "left": first.left,
        "evaluated": int(first.evaluated.sum()),
        "excluded": excluded_by(found),
        "limits": {
            column_of((one.task, one.limit, one.part)): {
                "checked": one.checked,
                "exceeded": one.exceeded,
                "first": one.first,
            }
            for one in first.counts
        },
        "unchecked": {f"{limit.name}, {part}": number for (limit, part), number in first.unchecked.items()},
    }
