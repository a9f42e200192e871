"""How many candidates each limit excludes."""

from __future__ import annotations

import numpy as np

from infinivar.limits import Demand, Limit
from infinivar.sizing.geared.candidates import Candidates
from infinivar.sizing.geared.result import LimitCount
from infinivar.sizing.geared.sampled import HOT, Sampled, TaskDemand
from infinivar.sizing.geared.tasks import Task, heat_counts

SPARE = 1e-9
"""Share by which a closed form may exceed an allowance before it excludes a candidate: rounding."""


class Tally:
    """Counts of candidates by limit, in the order in which limits are first counted."""

    def __init__(self, found: Candidates) -> None:
        """Begin with no counts."""
        self.found = found
        self._counts: dict[TaskDemand, np.ndarray] = {}

    def checked(self, task: Task, demand: Demand, rows: np.ndarray) -> np.ndarray:
        """Whether a limit is checked for candidates: if stated, and not replaced by the winding temperature. (k,) bool"""
        stated = self.found.stated(demand, rows)
        if demand[0] == Limit.THERMAL and heat_counts(task):
            return stated & ~self.found.stated(HOT, rows)
        return stated

    def add(self, key: TaskDemand, checked: np.ndarray, exceeded: np.ndarray, first: np.ndarray) -> None:
        """Count the candidates for which a limit is checked, which exceed it, and which nothing before it excludes."""
        more = np.array([checked.sum(), (checked & exceeded).sum(), (checked & first).sum()])
        self._counts[key] = self._counts.get(key, np.zeros(3, dtype=int)) + more

    def heat(self, done: Sampled, rows: np.ndarray, left: np.ndarray) -> None:
        """Count the windings that overheat, of candidates that were evaluated at every instant."""
        known = self.found.stated(HOT, rows)
        for key, demand in done.demands.items():
            if key[1:] == HOT:
                beyond = ~(demand <= 1.0 + SPARE)
                self.add(key, known, beyond, beyond & left)

    def counts(self) -> tuple[LimitCount, ...]:
        """Limits that were checked for any candidate."""
        return tuple(LimitCount(*key, *map(int, counts)) for key, counts in self._counts.items() if counts[0])
