"""Result of a search for the best drives: designs with margins and sources, and what excluded the other candidates."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import field, replace
from typing import Any

from infinivar._core.described import derived, named, reported
from infinivar._core.result import Result, result
from infinivar.analysis.hanging import Hanging
from infinivar.analysis.whole_mass import WholeMass, mass_of
from infinivar.drivetrain.drive import is_machine
from infinivar.drivetrain.masses import tube_as_of
from infinivar.drivetrain.uncounted import not_counted
from infinivar.sizing.builds.result import Doubt
from infinivar.sizing.carrying import Carried, carried_lines
from infinivar.sizing.design import SizedDrive, at_end, demand_words, exceeded_words, path_words
from infinivar.sizing.machine_templates import weighed
from infinivar.sizing.machines.work import MachineWork
from infinivar.sizing.margins import nearest_among
from infinivar.sizing.measures import MEASURES, Measure
from infinivar.sizing.options import BOTH, SizeOptions
from infinivar.sizing.pool import SearchedSet
from infinivar.sizing.records import SearchRecord, WheelRecord
from infinivar.sizing.studies import study_of
from infinivar.sizing.what_if import WhatIf
from infinivar.study.study import Study

_NEAR_END = 0.02
"""Differential evolution stops this near an end of a range, which it approaches step by step."""

_COSTLESS = {("wheel radius", "largest"), ("crown radius", "least")}
"""Ends at which a wheel loses less at no cost that the search knows: only yield ends it."""


@result
class Sizing(Result):
    """Result of `size`.

    Attributes
    ----------
    study          Study with the requirement, the motions and the templates.
    objective      What is made small: energy, mass, space, price, or energy and mass; designs are ordered by the first.
    designs        The best designs, in order.
    front          With two objectives, designs of which no other has less of both, by power: of each template those that are
                   3 % of their mass apart, and the lightest.
    searches       What became of the candidates, by template.
    sets           Sets searched.
    best_of        The best design like each template, by template; without those that have none.
    what_if        What would have to change for the other templates to win, or to become feasible, by template.
    notes          Drives of the study that are not searched, sets that cannot be read, and what the data sheets of the designs'
                   parts state that contradicts itself.
    carried        With two objectives, the best designs of all templates by what a kilogram costs to carry, from none on.
    doubt          How far the designs withstand the spread of their parts; None if no builds were requested.
    hangs_on       Choices that no source settles, each with the best design it gives; None without designs.
    options        With which it was computed; None if a sweep computed it.
    """

    study: Study = reported(convert=named)
    objective: tuple[str, ...] = reported()
    designs: tuple[SizedDrive, ...] = reported()
    front: tuple[SizedDrive, ...] = reported()
    searches: Mapping[str, SearchRecord | WheelRecord] = reported()
    sets: tuple[SearchedSet, ...] = reported()
    best_of: Mapping[str, SizedDrive] = reported(default_factory=dict)
    what_if: Mapping[str, WhatIf] = reported(default_factory=dict)
    notes: tuple[str, ...] = ()
    carried: tuple[Carried, ...] = reported(default=())
    doubt: Doubt | None = reported(optional=True, default=None)
    hangs_on: Hanging | None = reported(optional=True, default=None)
    options: SizeOptions | None = field(default=None, compare=False, repr=False)

    @derived()
    def feasible(self) -> bool:
        """Whether any design is feasible."""
        return bool(self.designs)

    @property
    def best(self) -> SizedDrive | None:
        """The best design; None if no candidate is feasible."""
        return self.designs[0] if self.designs else None

    @property
    def masses(self) -> dict[str, WholeMass]:
        """What the best design like each template weighs, by template; without machines whose structure is not known."""
        study, found = self.study, {}
        for name, design in self.best_of.items():
            drive: Any = design.drive
            template: Any = study.drives[name]
            if is_machine(drive):
                if weighed(drive):
                    own = {"leg": tube_as_of(drive.leg, template.leg)} if drive.leg is not None else {}
                    found[name] = mass_of(replace(drive, **own), MachineWork.of(study, name).service)
                continue
            drive = tube_as_of(drive, template)  # so that its wall follows the factors
            found[name] = mass_of(drive, study.service(drive))
        return found

    @property
    def carrying(self) -> list[str]:
        """What a cost of carried mass does to the choice, in words; empty where it does nothing."""
        return carried_lines(self.carried, None if self.options is None else self.options.carried)

    @property
    def candidates(self) -> int:
        """Number of candidates of all searches."""
        return sum(search.candidates for search in self.searches.values())

    def named(self, design: SizedDrive) -> str:
        """Parts of a design; with its template, where there are several."""
        return f"{design.template}: {design.title}" if len(self.searches) > 1 else design.title

    def words_of(self, design: SizedDrive) -> str:
        """Verdict on a design; with its template, where there are several, and with what the objective asks for the least of."""
        like = [design.template] if len(self.searches) > 1 else []
        return ": ".join([*like, *self.measured(design), design.verdict])

    @property
    def measure(self) -> Measure | None:
        """What the objective asks for the least of; None of power and mass, which every design states."""
        return None if self.objective[0] in BOTH else MEASURES[self.objective[0]]

    def measured(self, design: SizedDrive) -> list[str]:
        """That of a design, in words; empty where there is none."""
        return [] if self.measure is None else [self.measure.said(design)]

    @property
    def searched(self) -> str:
        """What was searched, such as "7 pairs of shelf"."""
        return (
            f"{' and '.join(one.words for one in self.searches.values())} of {', '.join(one.name for one in self.sets)}"
        )

    @property
    def least(self) -> str:
        """What the designs have least of, and of what, such as "least mass of 7 pairs of shelf"."""
        return f"least {self.objective[0]} of {self.searched}"

    @derived()
    def verdict(self) -> str:
        """One line on the outcome."""
        if self.best is not None:
            prefix = "" if self.hangs_on is None else self.hangs_on.prefix
            return f"{prefix}{self.least}: {self.words_of(self.best)}"
        unjudged = [one.unjudged for one in self.searches.values()]
        if sum(sum(one.values()) for one in unjudged) == sum(one.candidates for one in self.searches.values()):
            reasons = ", ".join(f"{reason} ({number:,})" for one in unjudged for reason, number in one.items())
            return f"none of {self.searched} can be judged: {reasons}"
        nearest = self.nearest
        miss = "" if nearest is None else f"; nearest miss: {self.named(nearest)}, {exceeded_words(nearest)}"
        return f"none of {self.searched} is feasible{miss}"

    @property
    def nearest(self) -> SizedDrive | None:
        """If no candidate is feasible, that of all searches which comes nearest to keeping all limits."""
        found = [search.nearest for search in self.searches.values() if search.nearest is not None]
        place = nearest_among(found)
        return None if place is None else found[place]

    @derived()
    def cautions(self) -> tuple[str, ...]:
        """What the result leaves open: limits not checked for the best design, and pairs of which nothing says that they fit."""
        unstated = [one.name for one in self.sets if not one.pairs_stated]
        said = [
            f"the set {name} does not state which gearheads fit which motors: every pair was tried; check flange and shaft"
            for name in unstated
        ]
        said += self.notes
        for design in self.best_of.values():
            said += self._at_ends(design)
        left_out = not_counted({one.template: one.drive for one in self.best_of.values()}, self.study.titles)
        said += [left_out[:1].lower() + left_out[1:].rstrip(".")] if left_out else []
        if self.hangs_on is not None and self.hangs_on.rows:
            said.append(
                "what the verdict hangs on is judged by the designs found: a search with another answer may find better ones"
            )
        if self.best is not None and self.best.unchecked:
            named = ", ".join(demand_words(*demand) for demand in self.best.unchecked)
            said.append(f"not checked for the best design, as its data sheets state no value: {named}")
        if "price" in self.objective:
            said.append("prices are those of motors and gearheads; the structure has none")
        if "space" in self.objective and any(one.architecture == "cobotic" for one in self.best_of.values()):
            said.append("the motors of a cobotic drive are the lightest behind its wheel; others may need less space")
        if self.best is not None and not self.study.moves:
            said.append(
                "without a motion every point of the requirement counts as continuous; energy and heat are open"
            )
        return tuple(said)

    def _at_ends(self, design: SizedDrive) -> list[str]:
        """Which values of a design are at an end of their range."""
        ranges, cobotic = self.searches[design.template].ranges, design.architecture == "cobotic"
        near = _NEAR_END if cobotic else 1e-6
        ends = {
            path_words(path): "largest" if math.isclose(free.value, ends[1], rel_tol=near) else "least"
            for path, free in design.free.items()
            if (ends := ranges.get(path)) is not None
            and ends[0] < ends[1]
            and any(math.isclose(free.value, end, rel_tol=near) for end in ends)
        }
        owner = f"the best design of {design.template}" if len(self.searches) > 1 else "the best design"
        tried = [
            f"{path_words(path)} of {owner} is at an end of the values tried; values beyond it may give a better one"
            for path, free in design.free.items()
            if at_end(path, free)
        ]
        grown = [word for word, end in ends.items() if cobotic and (word, end) in _COSTLESS]
        said = tried + [
            f"{word} of {owner} is at an end of the range searched; a wider range may hold a better one"
            for word in ends
            if word not in grown
        ]
        if grown:
            said.append(
                f"{' and '.join(grown)} of {owner} {'are' if len(grown) > 1 else 'is'} at an end of the range searched: a larger "
                "wheel turns more slowly in its bearings, and a narrower crown resists steering less; its mass counts in the "
                "front of mass and energy, its space does not: state the range that can be built"
            )
        return said

    def study_of(self, design: SizedDrive, name: str = "design") -> Study:
        """Return the study with a design as its only drive: for `compare`, `simulate` and `save_study`."""
        return study_of(self.study, design, name)

    def _rows(self) -> Iterator[tuple[str, str]]:
        yield "verdict", self.verdict
        yield "candidates", f"{self.candidates:,}"
        for place, design in enumerate(self.designs[:5], 1):
            yield str(place), self.words_of(design)
