"""Search over geared drives like a template."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.parts.linear import Pulley
from infinivar.parts.screw import Screw
from infinivar.parts.stage import OutputStage
from infinivar.sizing.design import FreeValue, SizedDrive
from infinivar.sizing.geared.result import Design, GearedSizing
from infinivar.sizing.geared.search import nearest_geared, size_geared
from infinivar.sizing.pool import PartPool
from infinivar.sizing.progress import Progress, part_of
from infinivar.sizing.records import OF_FRONT, SearchRecord
from infinivar.sizing.request import Found, Request

RANGE = 5.0
"""Radii are searched from the template's divided by this to the template's times this, unless a range is given."""


def geared(asked: Request, name: str, template: ConventionalDrive, progress: Progress | None) -> Found:
    """Search over geared drives: the best designs, the front and the record."""
    parts, study, radius = asked.parts, asked.study, None
    if template.pulley is not None:
        radius = asked.radius or (template.pulley.radius / RANGE, template.pulley.radius * RANGE)
    screw = template.screw
    stages = None if screw is None or not asked.leads else [replace(screw, lead=lead) for lead in asked.leads]
    ranges = {} if radius is None else {"pulley.radius": radius}
    if stages is not None:
        ranges["screw.lead"] = min(asked.leads), max(asked.leads)
    given: dict[str, Any] = {
        "duty": study.duty,
        "requirement": study.requirement,
        "radius": radius,
        "stages": stages,
        "travel": study.travel,
        "loss_model": asked.loss_model,
    }
    tables = template, parts.motors_as("motor"), parts.gearheads, parts.pairs
    searches: list[Any] = [asked.aims[0], *(["front"] if len(asked.aims) > 1 else [])]
    found: list[GearedSizing] = []
    for place, aim in enumerate(searches):
        said = part_of(progress, place / len(searches), (place + 1) / len(searches))
        found.append(size_geared(*tables, **given, objective=aim, top=asked.top, progress=said))
    first = found[0]
    nearest = None if first.designs else nearest_geared(*tables, **given, weighed="mass" in asked.aims[:1])
    record = SearchRecord(
        candidates=first.candidates,
        left=first.left,
        evaluated=int(first.evaluated.sum()),
        excluded=excluded_by(found),
        counts=first.counts,
        unchecked=first.unchecked,
        ranges=ranges,
        cloud=_cloud(parts, found),
        nearest=None if nearest is None else drive_of(name, parts, nearest),
        **stages_tried(stages or ()),
    )
    fronts = found[1].designs if len(found) > 1 else ()
    return Found(
        [drive_of(name, parts, one) for one in first.designs], [drive_of(name, parts, one) for one in fronts], record
    )


def stages_tried(stages: Sequence[OutputStage]) -> dict[str, Any]:
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


def excluded_by(found: Sequence[GearedSizing]) -> dict[str, int]:
    """Reasons of the first search, and those for which the front alone leaves candidates out."""
    first = dict(found[0].excluded)
    more = {
        f"{reason}{OF_FRONT}": number
        for one in found[1:]
        for reason, number in one.excluded.items()
        if reason not in first
    }
    return {**first, **more}


def _cloud(parts: PartPool, found: Sequence[GearedSizing]) -> np.ndarray:
    """Mass and power of the feasible candidates evaluated. (n, 2)"""
    mass = parts.motors_as("motor")["mass"][parts.pairs[:, 0]] + parts.gearheads["mass"][parts.pairs[:, 1]]
    points = [
        np.stack(np.broadcast_arrays(mass, one.power), axis=-1)[one.evaluated & np.isfinite(one.power)] for one in found
    ]
    return np.concatenate(points)


def drive_of(name: str, parts: PartPool, found: Design) -> SizedDrive:
    """A design of the search with its parts and where they are from; `name` is that of the template."""
    stage, (low, high) = found.stage, found.radii
    free = {}
    if isinstance(stage, Pulley):
        free["pulley.radius"] = FreeValue(value=stage.radius, low=low, high=high, unit="m")
    if isinstance(stage, Screw):
        free["screw.lead"] = FreeValue(value=stage.lead, low=math.nan, high=math.nan, unit="m")
    return SizedDrive(
        template=name,
        parts={"motor": parts.motor("motor", found.motor), "gearhead": parts.part("gearheads", found.gearhead)},
        free=free,
        drive=found.drive,
        mass=found.mass,
        power=found.power,
        demands=found.demands,
        unchecked=found.unchecked,
    )
