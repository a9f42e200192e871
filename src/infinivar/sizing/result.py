"""Result of a search for the best drives: designs with margins and sources, and what excluded the other candidates."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from infinivar._core.result import Frozen, Result, result
from infinivar.drivetrain.drive import Drive
from infinivar.limits import Demand
from infinivar.sizing.geared.result import LimitCount
from infinivar.sizing.geared.sampled import TaskDemand
from infinivar.sizing.pool import ChosenPart, SearchedSet
from infinivar.study.study import Study
from infinivar.units import plain, show, show_in


@result
class FreeValue(Frozen):
    """A value that the search chose from a range.

    Attributes
    ----------
    value          Chosen.
    low, high      Between these all limits are kept, with all else as chosen; nan if the design keeps them nowhere.
    unit           In SI.
    """

    value: float
    low: float
    high: float
    unit: str

    @property
    def words(self) -> str:
        """Value and range."""
        if math.isnan(self.low):
            return _shown(self.value, self.unit)
        return f"{_shown(self.value, self.unit)} (feasible from {_shown(self.low, self.unit)} to {_shown(self.high, self.unit)})"


@result
class SizedDrive(Frozen):
    """A candidate as a drive.

    Attributes
    ----------
    template       Drive of the study whose other parts it has.
    parts          Parts chosen, by role: "motor", "gearhead".
    free           Values chosen from a range, by their path in the drive, such as "pulley.radius".
    drive          Ready for `duty_cycle`, `steady_map` and `simulate`.
    mass           Of the parts chosen; nan if one does not state it. [kg]
    power          Mean power from the supply over all motions; nan without a motion. [W]
    demands        Demand over allowance, by motion or "requirement", limit and part. [-]
    unchecked      Limits that the data sheets do not state.
    """

    template: str
    parts: Mapping[str, ChosenPart]
    free: Mapping[str, FreeValue]
    drive: Drive
    mass: float
    power: float
    demands: Mapping[TaskDemand, float]
    unchecked: tuple[Demand, ...]

    @property
    def title(self) -> str:
        """The parts by name."""
        return ", ".join(part.name for part in self.parts.values())

    @property
    def tightest(self) -> TaskDemand | None:
        """Motion, limit and part with the largest demand; None if no limit is loaded."""
        return max(self.demands, key=lambda key: self.demands[key], default=None)

    @property
    def margin(self) -> float:
        """Allowance over demand of the tightest limit. [-]"""
        worst = max(self.demands.values(), default=0.0)
        return 1.0 / worst if worst > 0.0 else math.inf

    @property
    def exceeded(self) -> dict[TaskDemand, float]:
        """Demand over allowance of the limits exceeded, the worst first."""
        beyond = {key: demand for key, demand in self.demands.items() if not demand <= 1.0}
        return dict(sorted(beyond.items(), key=lambda item: -item[1]))

    @property
    def verdict(self) -> str:
        """One line: what it needs, weighs and keeps."""
        said = [self.title, *(f"{_last(path)} {value.words}" for path, value in self.free.items())]
        said += [show(self.power, "W", 3)] if math.isfinite(self.power) else []
        said.append("mass not stated" if math.isnan(self.mass) else show(self.mass, "kg", 3))
        if self.tightest is not None:
            said.append(f"margin {plain(self.margin, 3)} ({limit_words(self.tightest)})")
        return "; ".join(said)

    def to_dict(self) -> dict[str, Any]:
        """The same as plain numbers and texts."""
        return {
            "template": self.template,
            "title": self.title,
            "parts": {
                role: {
                    "part": part.part,
                    **{
                        name: getattr(part, name) for name in ("name", "manufacturer", "order_number", "source", "date")
                    },
                }
                for role, part in self.parts.items()
            },
            "free": {
                path: {"value": value.value, "low": value.low, "high": value.high, "unit": value.unit}
                for path, value in self.free.items()
            },
            "mass_kg": self.mass,
            "power_W": self.power,
            "margin": self.margin,
            "tightest": None if self.tightest is None else limit_words(self.tightest),
            "demands": [
                {"task": task, "limit": limit.name, "part": part, "demand_over_allowance": demand}
                for (task, limit, part), demand in self.demands.items()
            ],
            "unchecked": [limit.name for limit, _ in self.unchecked],
        }


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
                f"{_last(path)} of the best design is at an end of the range searched; a wider range may hold a better one"
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
        from infinivar.sizing.studies import study_of

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


def limit_words(key: TaskDemand) -> str:
    """Limit and part of a motion or the requirement, such as "motor continuous torque, walking"."""
    task, limit, _ = key
    return f"{limit.words}, {task}"


def exceeded_words(design: SizedDrive) -> str:
    """Limits that a design exceeds, and by how much."""
    said = [f"{limit_words(key)}: {_times(demand)}" for key, demand in design.exceeded.items()]
    return "; ".join(said[:3]) + (f"; {len(said) - 3} more" if len(said) > 3 else "")


def _times(demand: float) -> str:
    return f"{plain(demand, 3)} times the allowance" if math.isfinite(demand) else "out of reach"


def _shown(value: float, unit: str) -> str:
    return show_in(value, "m", "mm") if unit == "m" else show(value, unit)


def _last(path: str) -> str:
    return path.replace(".", " ").replace("_", " ")
