"""What the verdict of a search hangs on: its best designs again, with another answer to each open choice."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from infinivar.analysis.cycles.duty_cycle import energy_and_feasibility
from infinivar.analysis.deciding import best_speeds
from infinivar.analysis.hanging import Hanging, Judged, hang
from infinivar.analysis.region import covers
from infinivar.sizing.geared.search import equal_shares
from infinivar.sizing.geared.tally import SPARE
from infinivar.sizing.result import Sizing
from infinivar.sizing.studies import study_of
from infinivar.study.choices import Variant, variants
from infinivar.study.study import Study


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
    asked = [one for one in variants(study) if study.duty or one.scope == "all"]
    answers = asked if by_mass else [*asked, *best_speeds(study)]
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
