"""Result of a search for the best drives: designs with margins and sources, and what excluded the other candidates."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from infinivar._core.result import Frozen, Result, result
from infinivar.limits import Demand
from infinivar.sizing.design import SizedDrive, exceeded_words, path_words
from infinivar.sizing.geared.result import LimitCount
from infinivar.sizing.pool import SearchedSet
from infinivar.sizing.studies import study_of
from infinivar.study.study import Study


@result
class SearchRecord(Frozen):
    """What became of the candidates for one template.

    Attributes
    ----------
    candidates     Number of candidates.
    left           Of these, those for which closed forms leave a radius; with given stages, the feasible ones.
    evaluated      Of these, evaluated at every instant; the others are infeasible, or cannot be among the best.
    excluded       Candidates without the values that a law needs, by reason.
    counts         Candidates that each limit excludes, in the order in which limits are checked.
    unchecked      Candidates whose data sheets do not state a limit.
    ranges         Ranges searched, by path. [m]
    cloud          Mass and mean power of the feasible candidates that were evaluated; nan where not known. (n, 2) [kg], [W]
    nearest        If no candidate is feasible, that with the tightest limit nearest to being kept.
    """

    candidates: int
    left: int
    evaluated: int
    excluded: Mapping[str, int]
    counts: tuple[LimitCount, ...]
    unchecked: Mapping[Demand, int]
    ranges: Mapping[str, tuple[float, float]]
    cloud: np.ndarray
    nearest: SizedDrive | None = None

    def to_dict(self) -> dict[str, Any]:
        """The same as plain numbers and texts."""
        return {
            "candidates": self.candidates,
            "left": self.left,
            "evaluated": self.evaluated,
            "excluded": dict(self.excluded),
            "limits": [{**count._asdict(), "limit": count.limit.name} for count in self.counts],
            "unchecked": [
                {"limit": limit.name, "part": part, "candidates": number}
                for (limit, part), number in self.unchecked.items()
            ],
            "ranges": {path: list(ends) for path, ends in self.ranges.items()},
            "nearest": None if self.nearest is None else self.nearest.to_dict(),
        }


@result
class Sizing(Result):
    """Result of `size`.

    Attributes
    ----------
    study          Study with the requirement, the motions and the templates.
    objective      What is made small: energy, mass or both; designs are ordered by the first.
    designs        The best designs, in order.
    front          With two objectives, every design of which no other has less of both, by power.
    searches       What became of the candidates, by template.
    sets           Sets searched.
    """

    study: Study
    objective: tuple[str, ...]
    designs: tuple[SizedDrive, ...]
    front: tuple[SizedDrive, ...]
    searches: Mapping[str, SearchRecord]
    sets: tuple[SearchedSet, ...]

    @property
    def feasible(self) -> bool:
        """Whether any design is feasible."""
        return bool(self.designs)

    @property
    def best(self) -> SizedDrive | None:
        """The best design; None if no candidate is feasible."""
        return self.designs[0] if self.designs else None

    @property
    def candidates(self) -> int:
        """Number of candidates of all searches."""
        return sum(search.candidates for search in self.searches.values())

    @property
    def verdict(self) -> str:
        """One line on the outcome."""
        names = ", ".join(one.name for one in self.sets)
        if self.best is not None:
            return f"least {self.objective[0]} of {self.candidates} pairs of {names}: {self.best.verdict}"
        nearest = self.nearest
        miss = "" if nearest is None else f"; nearest miss: {nearest.title}, {exceeded_words(nearest)}"
        return f"none of {self.candidates} pairs of {names} is feasible{miss}"

    @property
    def nearest(self) -> SizedDrive | None:
        """If no candidate is feasible, that of all searches with the tightest limit nearest to being kept."""
        found = [search.nearest for search in self.searches.values() if search.nearest is not None]
        return max(found, key=lambda one: one.margin, default=None)

    @property
    def cautions(self) -> tuple[str, ...]:
        """What the result leaves open: limits not checked for the best design, and pairs of which nothing says that they fit."""
        unstated = [one.name for one in self.sets if not one.pairs_stated]
        said = [
            f"the set {name} does not state which gearheads fit which motors: every pair was tried; check flange and shaft"
            for name in unstated
        ]
        if self.best is not None:
            ranges = self.searches[self.best.template].ranges
            said += [
                f"{path_words(path)} of the best design is at an end of the range searched; a wider range may hold a better one"
                for path, free in self.best.free.items()
                if any(math.isclose(free.value, end, rel_tol=1e-6) for end in ranges.get(path, ()))
            ]
        if self.best is not None and self.best.unchecked:
            named = ", ".join(limit.words for limit, _ in self.best.unchecked)
            said.append(f"not checked for the best design, as its data sheets state no value: {named}")
        if self.best is not None and not self.study.duty:
            said.append(
                "without a motion every point of the requirement counts as continuous; energy and heat are open"
            )
        return tuple(said)

    def study_of(self, design: SizedDrive, name: str = "design") -> Study:
        """Return the study with a design as its only drive: for `compare`, `simulate` and `save_study`."""
        return study_of(self.study, design, name)

    def to_dict(self) -> dict[str, Any]:
        """The same as plain numbers and texts."""
        return {
            "study": self.study.name,
            "objective": list(self.objective),
            "feasible": self.feasible,
            "verdict": self.verdict,
            "cautions": list(self.cautions),
            "sets": [
                {"name": one.name, "pairs": one.pairs, "pairs_stated": one.pairs_stated, "refused": list(one.refused)}
                for one in self.sets
            ],
            "designs": [design.to_dict() for design in self.designs],
            "front": [design.to_dict() for design in self.front],
            "searches": {name: search.to_dict() for name, search in self.searches.items()},
        }

    def _rows(self) -> Iterator[tuple[str, str]]:
        yield "verdict", self.verdict
        yield "candidates", str(self.candidates)
        for place, design in enumerate(self.designs[:5], 1):
            yield str(place), design.verdict
