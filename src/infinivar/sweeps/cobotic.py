"""Sweep over the cobotic drives of a study: the search of `size` from many independent starts, and the best of all."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np

from infinivar._core.text import counted
from infinivar.errors import require
from infinivar.sizing.cobotic.bounds import Side
from infinivar.sizing.cobotic.choice import NOT_CHOSEN
from infinivar.sizing.cobotic.designs import design_of
from infinivar.sizing.cobotic.search import Searched, best_cobotic, excluded_of, searched_of, unchecked_of
from infinivar.sizing.cobotic.space import FREE
from infinivar.sizing.found import CoboticDesign, CoboticSizing
from infinivar.sizing.measures import MEASURES
from infinivar.sizing.of_cobotic import found_of, request_on_tables
from infinivar.sizing.options import GENERATIONS, Aim
from infinivar.sizing.request import StudyRequest, request_of
from infinivar.sizing.result import Sizing
from infinivar.sizing.size import sizing_of
from infinivar.sizing.tables import CoboticRequest
from infinivar.study.study import Study
from infinivar.sweeps.designs import (
    DEMAND,
    column_of,
    demands_of,
    design_row,
    design_words,
    each,
    key_of,
    row_of,
    rows_of,
)
from infinivar.sweeps.fingerprint import fingerprint
from infinivar.sweeps.geared import TOP_OF_CHUNK
from infinivar.sweeps.problem import CANDIDATES, FRONT, LIST, NEAREST, TOP, Best, Chunk, Problem
from infinivar.sweeps.sweep import Sweep, check_finished

_PARTS = ("pair", "bearing", "wheels", "support", "steering", "ratio")
"""Columns that identify a combination of parts."""
_TABLES = ("motors", "gearheads", "pairs", "steering_motors", "steering_ratios", "bearings", "cylinder_bearings")
_NOT_OPTIONS = (*_TABLES, "template", "duty", "requirement", "seed", "top")


class CoboticDesigns(NamedTuple):
    """Best designs of all starts."""

    designs: tuple[CoboticDesign, ...]
    """In order: of each combination of parts the best values found from any start."""
    front: tuple[CoboticDesign, ...]
    """Those of which no other has both less mass and less power, by power."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CoboticStudySweep(Problem):
    """Independent starts of the search of `size` over cobotic drives, one in each chunk.

    Attributes
    ----------
    label           Title for reports.
    request         What a start searches, all but its seed.
    starts          Number of starts; their seeds are 0, 1, 2, ...
    study_request   Study, template, parts, objectives and options.
    """

    kind: ClassVar[str] = "cobotic drives"
    label: str
    request: CoboticRequest
    starts: int
    study_request: StudyRequest

    @property
    def title(self) -> str:
        """See `Problem`."""
        return self.label

    @property
    def chunks(self) -> int:
        """See `Problem`."""
        return self.starts

    @property
    def reducer(self) -> Best:
        """See `Problem`."""
        order = ("value", "power_W", "seed", *_PARTS)
        return Best(top=self.request.top, order=order, front=("mass_kg", "power_W"), same=_PARTS, demands=DEMAND)

    @property
    def identity(self) -> Mapping[str, Any]:
        """See `Problem`; the number of starts is that of the chunks."""
        named = {one.name: getattr(self.request, one.name) for one in dataclasses.fields(self.request)}
        others = {name: value for name, value in named.items() if name not in _NOT_OPTIONS}
        return {
            "values of the drive": fingerprint(self.request.template),
            "parts": fingerprint({name: named[name] for name in _TABLES}),
            "requirement": fingerprint(self.request.requirement),
            "motions": fingerprint(self.request.duty),
            "options": fingerprint(dict(sorted(others.items()))),
            "top": self.request.top,
            "designs ordered by": self.study_request.aims[0],
        }

    def run(self, number: int) -> Chunk:
        """See `Problem`."""
        found = best_cobotic(replace(self.request, seed=number))
        designs = [(TOP, one) for one in found.designs] + [(FRONT, one) for one in found.front]
        if not designs and found.nearest is not None:
            designs = [(NEAREST, found.nearest)]
        return Chunk(rows_of([self._row(name, one, number) for name, one in designs]), _counts(found))

    def best(self, chunk: Chunk) -> tuple[float, str] | None:
        """See `Problem`."""
        if not chunk.rows or not (chunk.rows[LIST] == TOP).any():
            return None
        value = float(chunk.rows["value"][chunk.rows[LIST] == TOP].min())
        return value, f"best: {MEASURES[self.study_request.aims[0]].shown(value)}"

    def verdict(self, sweep: Sweep) -> str:
        """One line on the outcome of the starts that are done."""
        best, starts = sweep.list(TOP), counted(sweep.done, "starts")
        if not len(best.get(LIST, ())):
            return f"none of {sweep.counts.get('wheels', 0):,} wheel designs from {starts} is feasible"
        return f"least {self.study_request.aims[0]} from {starts}: {design_words(row_of(best, 0))}"

    def result(self, sweep: Sweep) -> CoboticDesigns:
        """The designs kept as drives; nothing is computed again.

        Raises
        ------
        InputError
            If the sweep is not finished.
        """
        check_finished(sweep)
        searched = searched_of(self.request)
        return CoboticDesigns(*(tuple(self.designs(searched, sweep.list(name))) for name in (TOP, FRONT)))

    def sizing(self, sweep: Sweep) -> Sizing:
        """The best designs of all starts as `size` returns them; the cloud of the record has no others, and no history.

        Raises
        ------
        InputError
            If the sweep is not finished.
        """
        kept, searched, counts = self.result(sweep), searched_of(self.request), sweep.counts
        both = [*kept.designs, *kept.front]
        found = CoboticSizing(
            objective=self.request.objective,
            designs=kept.designs,
            front=kept.front,
            wheels=counts["wheels"],
            rolled=counts["rolled"],
            drives=sweep.candidates,
            sampled=counts["sampled"],
            excluded=excluded_of(searched.sides),
            blocked={key_of(name): number for name, number in counts["blocked"].items()},
            history=np.empty(0),
            cloud=np.array([(one.mass, one.power) for one in both]).reshape(-1, 2),
            candidates=searched.candidates,
            unchecked=unchecked_of(searched.sides),
            nearest=next(self.designs(searched, sweep.list(NEAREST)), None),
        )
        request = self.study_request
        return sizing_of(request, {request.name: found_of(request, found)})

    def designs(self, searched: Searched, rows: Mapping[str, np.ndarray]) -> Iterator[CoboticDesign]:
        """Yield rows of a list as designs, with the demands and the power found by the start."""
        for row in each(rows):
            pair, bearing, wheels, support, steering = (int(row[name]) for name in _PARTS[:5])
            heads = searched.space.heads
            chosen = [(searched.sides[0], pair)] if pair != NOT_CHOSEN else []
            if steering != NOT_CHOSEN:
                chosen.append((searched.sides[1], _steered(searched.sides[1], steering, float(row["ratio"]))))
            yield design_of(
                searched.space,
                np.array([row[name] for name in FREE]),
                int(heads.at((bearing, heads.wheels.index(wheels), support))),
                chosen,
                power=float(row["power_W"]),
                demands=demands_of(row),
                envelope=self.study_request.study.envelope if chosen else None,
            )

    def _row(self, name: str, one: CoboticDesign, seed: int) -> dict[str, Any]:
        parts = {part: getattr(one, part) for part in _PARTS}
        return design_row(
            name, one, self.study_request.value(one), {"seed": seed, **parts, **self._names(one), **one.values}
        )

    def _names(self, one: CoboticDesign) -> dict[str, str]:
        """Names of the parts, where the tables have names; "" for one that is not chosen."""
        rows = {"motor": ("motors", one.motor), "gearhead": ("gearheads", one.gearhead)}
        rows["steering motor"] = ("steering_motors", one.steering)
        tables = {part: (getattr(self.request, table), row) for part, (table, row) in rows.items()}
        found = {
            part: str(table["name"][row]) if row != NOT_CHOSEN else ""
            for part, (table, row) in tables.items()
            if "name" in table
        }
        return {**found, "axle bearing": str(self.request.bearings[one.bearing].name)}


def _counts(found: CoboticSizing) -> dict[str, Any]:
    blocked: Mapping[Any, int] = found.blocked
    return {
        CANDIDATES: found.drives,
        "wheels": found.wheels,
        "rolled": found.rolled,
        "sampled": found.sampled,
        "blocked": {column_of(key): number for key, number in blocked.items()},
    }


def _steered(side: Side, motor: int, ratio: float) -> int:
    """Row of a steering motor with a ratio among the candidates of a side."""
    pairs, ratios = side.found.pairs, np.asarray(side.found.gearheads["ratio"])
    return int(np.flatnonzero((pairs[:, 0] == motor) & (ratios[pairs[:, 1]] == ratio))[0])


def cobotic_study_sweep(
    study: Study,
    *,
    starts: int,
    objective: Aim | Sequence[Aim] | None = None,
    top: int = TOP_OF_CHUNK,
    sets: str | Path | Sequence[str | Path] | None = None,
    drive: str | None = None,
    ranges: Mapping[str, tuple[float, float]] | None = None,
    steering_ratios: Sequence[float] | None = None,
    wheels: Sequence[int] | None = None,
    slip_margin: float | None = None,
    life: float | None = None,
    generations: int = GENERATIONS,
) -> CoboticStudySweep:
    """Prepare the search of `size` over cobotic drives from many starts as a sweep; arguments as for `size`.

    Raises
    ------
    InputError
        As `size` does.
    """
    require(isinstance(starts, int) and not isinstance(starts, bool) and starts >= 1, "starts", starts, ">= 1")
    request = request_of(
        study,
        "cobotic",
        objective=objective,
        top=top,
        sets=sets,
        drive=drive,
        ranges=ranges,
        steering_ratios=steering_ratios,
        wheels=wheels,
        slip_margin=slip_margin,
        life=life,
        generations=generations,
    )
    return CoboticStudySweep(
        label=f"{study.name}, cobotic drives like {request.name}",
        request=request_on_tables(request),
        starts=starts,
        study_request=request,
    )
