"""Search over geared drives like a template."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from infinivar.parts.linear import Pulley
from infinivar.parts.screw import Screw
from infinivar.parts.stage import OutputStage
from infinivar.sizing.design import FreeValue, SizedDrive
from infinivar.sizing.found import Design, GearedSizing
from infinivar.sizing.geared.search import best_geared, nearest_miss
from infinivar.sizing.progress import Progress, part_of
from infinivar.sizing.records import OF_FRONT, SearchRecord
from infinivar.sizing.request import Found, StudyRequest
from infinivar.sizing.tables import GearedRequest

RANGE = 5.0
"""Radii are searched from the template's divided by this to the template's times this, unless a range is given."""


def geared(request: StudyRequest, progress: Progress | None) -> Found:
    """Search over geared drives: the best designs, the front and the record."""
    requests = requests_of(request)
    found: list[GearedSizing] = []
    for place, one in enumerate(requests):
        said = part_of(progress, place / len(requests), (place + 1) / len(requests))
        found.append(best_geared(one, said))
    nearest = None if found[0].designs else nearest_miss(requests[0])
    record = replace(
        record_of(request, found),
        cloud=_cloud(found),
        nearest=None if nearest is None else drive_of(request, nearest),
    )
    designs, front = ([drive_of(request, one) for one in some] for some in listed(found))
    return Found(designs, front, record)


def requests_of(request: StudyRequest) -> list[GearedRequest]:
    """Searches over tables for a template: by the first objective, and for the front of two."""
    own = {"stages": request.stages, "radius": range_of(request)}
    return [request.on_tables(GearedRequest, objective=one, **own) for one in request.objectives]


def range_of(request: StudyRequest) -> tuple[float, float] | None:
    """Radii to search; None without a pulley, or with given stages. [m]"""
    pulley = request.template.pulley
    if request.stages or pulley is None:
        return None
    return request.radius or (pulley.radius / RANGE, pulley.radius * RANGE)


def listed(found: Sequence[GearedSizing]) -> tuple[Sequence[Design], Sequence[Design]]:
    """The best designs, and those of the front, of the searches of `requests_of`."""
    return found[0].designs, found[1].designs if len(found) > 1 else ()


def record_of(request: StudyRequest, found: Sequence[GearedSizing]) -> SearchRecord:
    """What became of the candidates, without cloud and nearest miss."""
    first = found[0]
    return record_of_counts(
        request,
        candidates=first.candidates,
        left=first.left,
        evaluated=int(first.evaluated.sum()),
        excluded=_excluded(found),
        counts=first.counts,
        unchecked=first.unchecked,
        cloud=np.empty((0, 2)),
    )


def record_of_counts(request: StudyRequest, **counts: Any) -> SearchRecord:
    """What became of the candidates, from what was counted, by name, and what the search was over."""
    radius = range_of(request)
    ranges = {} if radius is None else {"pulley.radius": radius}
    return SearchRecord(**counts, ranges=ranges, **_stages_tried(request.stages))


def _stages_tried(stages: Sequence[OutputStage]) -> dict[str, Any]:
    """Entries of the record on the output stages given: their number, and what they differ in."""
    if not stages:
        return {}
    first, words = stages[0], "output stages"
    for kind, field, plural in ((Pulley, "radius", "radii"), (Screw, "lead", "leads")):
        if isinstance(first, kind):
            alike = (
                isinstance(one, kind) and replace(one, **{field: getattr(first, field)}) == first for one in stages
            )
            words = plural if all(alike) else words
    return {"stages": len(stages), "stage_words": words}


def _excluded(found: Sequence[GearedSizing]) -> dict[str, int]:
    """Reasons of the first search, and those for which the front alone leaves candidates out."""
    first = dict(found[0].excluded)
    more = {
        f"{reason}{OF_FRONT}": number
        for one in found[1:]
        for reason, number in one.excluded.items()
        if reason not in first
    }
    return {**first, **more}


def _cloud(found: Sequence[GearedSizing]) -> np.ndarray:
    """Mass and power of the feasible candidates evaluated. (n, 2)"""
    points = [np.stack([one.mass, one.power], axis=-1)[one.evaluated & np.isfinite(one.power)] for one in found]
    return np.concatenate(points)


def drive_of(request: StudyRequest, found: Design) -> SizedDrive:
    """A design of the search with its parts and where they are from."""
    parts = request.parts
    stage, (low, high) = found.stage, found.radii
    free = {}
    if isinstance(stage, Pulley):
        free["pulley.radius"] = FreeValue(value=stage.radius, low=low, high=high, unit="m")
    if isinstance(stage, Screw) and request.stages:
        free["screw.lead"] = FreeValue(value=stage.lead, low=math.nan, high=math.nan, unit="m")
    return SizedDrive(
        template=request.name,
        parts={"motor": parts.motor("motor", found.motor), "gearhead": parts.part("gearheads", found.gearhead)},
        free=free,
        drive=found.drive,
        mass=found.mass,
        power=found.power,
        volume=found.volume,
        price=None if math.isnan(found.price) else found.price,
        demands=found.checked,
        unchecked=found.unchecked,
    )
