"""Sweep over geared drives: all pairs of motor and gearhead, at the best radius of a pulley or at given output stages."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from infinivar.errors import ParameterError, require
from infinivar.parts.gearhead import LossModel
from infinivar.parts.linear import Pulley
from infinivar.parts.stage import OutputStage
from infinivar.sizing.found import Design
from infinivar.sizing.geared.candidates import Candidates
from infinivar.sizing.geared.search import best_geared, candidates_of, nearest_miss
from infinivar.sizing.geared.tally import design_of
from infinivar.sizing.of_geared import drive_of, listed, range_of, record_of, record_of_counts, requests_of
from infinivar.sizing.options import Aim
from infinivar.sizing.pool import PartPool
from infinivar.sizing.progress import best_so_far
from infinivar.sizing.records import SearchRecord
from infinivar.sizing.request import Found, StudyRequest, request_of
from infinivar.sizing.result import Sizing
from infinivar.sizing.size import sizing_of
from infinivar.sizing.tables import check_stages_or_radius
from infinivar.study.study import Study
from infinivar.sweeps.designs import column_of, demands_of, design_row, each, key_of, limit_counts, rows_of
from infinivar.sweeps.fingerprint import fingerprint
from infinivar.sweeps.problem import CANDIDATES, FRONT, LIST, TOP, Best, Chunk, Problem
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
class GearedSweep(Problem):
    """Search of `size` over geared drives in chunks: the best designs, the front and the counts are the same.

    Attributes
    ----------
    request   Study, template, parts, objectives and options.
    size      Pairs in a chunk.
    """

    kind: ClassVar[str] = "geared drives"
    request: StudyRequest
    size: int = PAIRS

    @property
    def title(self) -> str:
        """See `Problem`."""
        return f"{self.request.study.name}, geared drives like {self.request.name}"

    @property
    def parts(self) -> PartPool:
        """Motors, gearheads and pairs."""
        return self.request.parts

    @property
    def blocks(self) -> int:
        """Chunks of each output stage."""
        return max(1, math.ceil(len(self.parts.pairs) / self.size))

    @property
    def chunks(self) -> int:
        """See `Problem`."""
        return self.blocks * max(1, len(self.request.stages))

    @property
    def reducer(self) -> Best:
        """See `Problem`."""
        return Best(top=self.request.top, order=_ORDER, front=("mass_kg", "power_W"))

    @property
    def identity(self) -> Mapping[str, Any]:
        """See `Problem`."""
        request, study = self.request, self.request.study
        tables = self.parts.motors_as("motor"), self.parts.gearheads, self.parts.pairs
        radius = range_of(request)
        return {
            "study": study.name,
            "drive": request.name,
            "values of the drive": fingerprint(request.template),
            "requirement": fingerprint(study.requirement, study.travel),
            "motions": fingerprint(study.duty),
            "sets": [one.name for one in self.parts.sets],
            "parts": fingerprint(*tables),
            "objective": list(request.aims),
            "top": request.top,
            "radius [m]": None if radius is None else list(radius),
            "stages": fingerprint(request.stages) if request.stages else None,
            "loss model": request.loss_model or request.template.gearhead.loss_model,
            "pairs in a chunk": self.size,
        }

    def run(self, number: int) -> Chunk:
        """See `Problem`."""
        stage, block = divmod(number, self.blocks)
        start = block * self.size
        part = {"pairs": self.parts.pairs[start : start + self.size], "stages": self.request.stages[stage : stage + 1]}
        found = [best_geared(replace(one, **part)) for one in requests_of(self.request)]
        lists = zip((TOP, FRONT), listed(found), strict=True)
        rows = [self._row(name, one, start, stage) for name, some in lists for one in some]
        return Chunk(rows_of(rows), _counts(record_of(self.request, found)))

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
        request, counts = self.request, sweep.counts
        whole = requests_of(request)[0]
        found = candidates_of(replace(whole, objective="energy"))
        top, front = ([self._design(found, row) for row in each(sweep.list(name))] for name in (TOP, FRONT))
        nearest = nearest_miss(whole) if not top and sweep.candidates <= _FEW else None
        record = record_of_counts(
            request,
            candidates=sweep.candidates,
            left=counts["left"],
            evaluated=counts["evaluated"],
            excluded=counts["excluded"],
            counts=tuple(limit_counts(counts["limits"])),
            unchecked={key_of(f", {name}")[1:]: number for name, number in counts["unchecked"].items()},
            cloud=np.array([(one.mass, one.power) for one in (*top, *front)]).reshape(-1, 2),
            nearest=None if nearest is None else drive_of(request, nearest),
        )
        designs, best_front = ([drive_of(request, one) for one in some] for some in (top, front))
        return sizing_of(request, {request.name: Found(designs, best_front, record)})

    def _row(self, name: str, one: Design, start: int, stage: int) -> dict[str, Any]:
        parts = self.parts.motor("motor", one.motor), self.parts.part("gearheads", one.gearhead)
        own = {
            "worst": max(one.demands.values(), default=0.0),
            "pair": start + one.pair,
            "stage": stage,
            "motor": parts[0].part,
            "gearhead": parts[1].part,
            "radius_m": one.stage.radius if isinstance(one.stage, Pulley) else np.nan,
            "least_radius_m": one.radii[0],
            "largest_radius_m": one.radii[1],
        }
        return design_row(name, one, self.request.value(one), own)

    def _design(self, found: Candidates, row: Mapping[str, Any]) -> Design:
        request = self.request
        stage = request.stages[int(row["stage"])] if request.stages else request.template.stage
        if not request.stages and isinstance(stage, Pulley):
            stage = replace(stage, radius=float(row["radius_m"]))
        radii = float(row["least_radius_m"]), float(row["largest_radius_m"])
        return design_of(found, int(row["pair"]), stage, demands_of(row), float(row["power_W"]), radii)


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
    if size is None:
        size = PAIRS_AT_STAGE if stages or radii is not None else PAIRS
    for name, number in (("top", top), ("size", size)):
        require(isinstance(number, int) and not isinstance(number, bool) and number >= 1, name, number, ">= 1")
    check_stages_or_radius(stages, radius if radii is None else radii)
    request = request_of(
        study,
        "geared",
        objective=objective,
        top=top,
        sets=sets,
        drive=drive,
        radius=radius,
        stages=tuple(stages),
        loss_model=loss_model,
    )
    if radii is not None:
        request = replace(request, stages=_stages(request, radii))
    return GearedSweep(request=request, size=size)


def _stages(request: StudyRequest, count: int) -> tuple[Pulley, ...]:
    """Pulleys with radii in equal ratios."""
    template, radius = request.template, range_of(request)
    if template.pulley is None or radius is None:
        raise ParameterError(f"radii does not apply to a {template.stage.title}: only a pulley has a range of radii")
    require(isinstance(count, int) and count >= 2, "radii", count, "a whole number >= 2")
    require(0.0 < radius[0] <= radius[1] < math.inf, "radius", radius, "a range above 0 m, the least radius first")
    if radius[0] == radius[1]:
        raise ParameterError(
            f"radii: {count} radii need a range, but both ends of radius are {show_in(radius[0], 'm', 'mm')}; leave out radii to "
            "search at this radius, or state a wider range"
        )
    return tuple(replace(template.pulley, radius=float(one)) for one in np.geomspace(*radius, count))


def _counts(record: SearchRecord) -> dict[str, Any]:
    return {
        CANDIDATES: record.candidates,
        "left": record.left,
        "evaluated": record.evaluated,
        "excluded": dict(record.excluded),
        "limits": {
            column_of((one.task, one.limit, one.part)): {
                "checked": one.checked,
                "exceeded": one.exceeded,
                "first": one.first,
            }
            for one in record.counts
        },
        "unchecked": {f"{limit.name}, {part}": number for (limit, part), number in record.unchecked.items()},
    }
