"""How many candidates each limit excludes, the order of designs, and the values that a design is returned with."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from infinivar._core.pareto import front
from infinivar.limits import Demand, Limit
from infinivar.parts.stage import OutputStage
from infinivar.sizing.found import Design, LimitCount
from infinivar.sizing.geared.candidates import LIMIT_FIELDS, Candidates
from infinivar.sizing.geared.sampled import HOT, UNCHECKED, Sampled
from infinivar.sizing.geared.tasks import Task, heat_counts
from infinivar.sizing.margins import TaskDemand
from infinivar.sizing.measures import price_of, volume_of
from infinivar.sizing.tables import MOVING, GearedRequest

SPARE = 1e-9
"""Share by which a closed form may exceed an allowance before it excludes a candidate: rounding."""


class Tally:
    """Counts of candidates by limit, in the order in which limits are first counted."""

    def __init__(self, found: Candidates) -> None:
        """Begin with no counts."""
        self.found = found
        self._counts: dict[TaskDemand, np.ndarray] = {}
        self._proved: set[TaskDemand] = set()

    def checked(self, task: Task, demand: Demand, rows: np.ndarray) -> np.ndarray:
        """Whether a limit is checked for candidates: if stated, and not replaced by the winding temperature. (k,) bool"""
        stated = self.found.stated(demand, rows)
        if demand[0] == Limit.THERMAL and heat_counts(task):
            return stated & ~self.found.stated(HOT, rows)
        return stated

    def add(self, key: TaskDemand, checked: np.ndarray, exceeded: np.ndarray, first: np.ndarray) -> None:
        """Count the candidates for which a limit is checked, which exceed it, and which nothing before it excludes."""
        self._proved.add(key)
        self._count(key, int(checked.sum()), checked & exceeded, checked & first)

    def heat(self, done: Sampled, rows: np.ndarray, left: np.ndarray) -> None:
        """Count the windings that overheat, of candidates that were evaluated at every instant."""
        known = self.found.stated(HOT, rows)
        for key, demand in done.demands.items():
            if key[1:] == HOT:
                beyond = ~(demand <= 1.0 + SPARE)
                self.add(key, known, beyond, beyond & left)

    def rest(self, done: Sampled, rows: np.ndarray, left: np.ndarray) -> None:
        """Count what else the candidates exceed that were evaluated at every instant, such as a voltage with a warm winding."""
        some = left & ~done.feasible
        open_ = some.copy()
        for key, demand in done.demands.items():
            if key[1:] == HOT:
                open_ &= demand <= 1.0 + SPARE
        for key, demand in done.demands.items():
            if key[1:] == HOT:
                continue
            beyond = ~(demand <= 1.0)
            known = key in self._proved
            judged = (some & beyond) if known else (self.found.stated(key[1:], rows) & (demand != UNCHECKED))
            if known:  # closed forms have counted for whom it is checked
                self._count(key, 0, judged, open_ & beyond)
            else:
                self._count(key, int(judged.sum()), judged & beyond, open_ & beyond)
            open_ = open_ & ~beyond

    def tightest(self, keys: Sequence[TaskDemand], which: np.ndarray) -> None:
        """Count candidates without a feasible radius by the limit that is the tightest at their best radius.

        Parameters
        ----------
        keys : sequence   Limits.
        which : (k,) int  Place of the limit of each candidate.
        """
        rows = self.found.usable
        for place in np.unique(which):
            key = keys[place]
            checked = 0 if key in self._counts else int(self.found.stated(key[1:], rows).sum())
            self._count(key, checked, np.zeros(0), which == place)

    def _count(self, key: TaskDemand, checked: int, exceeded: np.ndarray, first: np.ndarray) -> None:
        more = np.array([checked, int(exceeded.sum()), int(first.sum())])
        self._counts[key] = self._counts.get(key, np.zeros(3, dtype=int)) + more

    def counts(self) -> tuple[LimitCount, ...]:
        """Limits that were checked for any candidate."""
        return tuple(LimitCount(*key, *map(int, counts)) for key, counts in self._counts.items() if counts[0])


def unchecked(found: Candidates, stages: int) -> dict[Any, int]:
    """Number of candidates whose data sheets do not state a limit, of those that are judged."""
    missing = {key: int(np.sum(~found.stated(key, found.usable))) * stages for key in LIMIT_FIELDS}
    return {key: number for key, number in missing.items() if number}


def mixed(power: Mapping[str, np.ndarray], shares: Mapping[str, float]) -> Any:
    """Mean power over all motions, by their shares of time; nan without a motion. [W]"""
    return sum(shares[name] * drawn for name, drawn in power.items()) if power else np.nan


def ranked(
    found: Candidates,
    rows: np.ndarray,
    stage: OutputStage,
    done: Sampled,
    request: GearedRequest,
) -> list[tuple[tuple[float, ...], Design]]:
    """The best feasible designs at a stage, each with its rank."""
    able = np.flatnonzero(done.feasible)
    drawn = np.broadcast_to(mixed(done.power, request.shares), rows.shape)
    whole = found.measure("mass", rows, stage)
    first = drawn if request.objective in MOVING else found.measure(request.objective, rows, stage)
    if request.objective == "front":
        order = able[front(whole[able], drawn[able])]
    else:
        mass = np.nan_to_num(whole[able], nan=np.inf)
        order = able[np.lexsort((rows[able], done.worst[able], mass, first[able]))][: request.top]
    return [
        (
            (float(first[place]), _last(float(whole[place])), float(done.worst[place]), int(rows[place])),
            design(found, int(rows[place]), stage, done, int(place), float(drawn[place])),
        )
        for place in order
    ]


def _last(mass: float) -> float:
    """A mass, or infinity where it is not known, so that it comes last."""
    return np.inf if np.isnan(mass) else mass


def design(
    found: Candidates,
    row: int,
    stage: OutputStage,
    done: Sampled,
    place: int,
    power: float,
    radii: tuple[float, float] = (np.nan, np.nan),
) -> Design:
    """A candidate as a design, with what was found at a place of a sample."""
    demands = {key: float(demand[place]) for key, demand in done.demands.items() if demand[place] != UNCHECKED}
    return design_of(found, row, stage, demands, power, radii)


def design_of(
    found: Candidates,
    row: int,
    stage: OutputStage,
    demands: Mapping[TaskDemand, float],
    power: float,
    radii: tuple[float, float],
) -> Design:
    """A candidate as a design; demands count only where its data sheets state the limit."""
    lacking = tuple(key for key in LIMIT_FIELDS if not found.stated(key, np.array([row]))[0])
    motor, gearhead = map(int, found.pairs[row])
    drive = found.drive(row, stage)
    return Design(
        pair=row,
        motor=motor,
        gearhead=gearhead,
        stage=stage,
        drive=drive,
        mass=float(found.measure("mass", np.array([row]), stage)[0]),
        power=power,
        volume=volume_of(drive, found.service),
        price=price_of(drive),
        radii=radii,
        demands={key: demand for key, demand in demands.items() if key[1:] not in lacking},
        unchecked=lacking,
    )
