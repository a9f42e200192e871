"""How many candidates each limit excludes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from infinivar.limits import Demand, Limit
from infinivar.sizing.geared.candidates import Candidates
from infinivar.sizing.geared.result import LimitCount
from infinivar.sizing.geared.sampled import HOT, UNCHECKED, Sampled, TaskDemand
from infinivar.sizing.geared.tasks import Task, heat_counts

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
