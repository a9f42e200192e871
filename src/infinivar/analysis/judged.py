"""What is judged alike of all simulated motions of machines: closure, limits, slip."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from infinivar.analysis import run_limits
from infinivar.analysis.run_limits import Event
from infinivar.limits import Demand, Limit


class Judged:
    """Base of results with a residual, events, root mean squares and an outcome."""

    __slots__ = ()
    residual: np.ndarray
    events: tuple[Event, ...]
    root_mean_squares: Mapping[Demand, float]
    outcome: str

    @property
    def closure(self) -> float:
        """Largest residual of the balance of energies. [-]"""
        return float(np.max(self.residual))

    @property
    def complete(self) -> bool:
        """Whether the run reached its end."""
        return not self.outcome

    @property
    def exceeded(self) -> tuple[str, ...]:
        """Names of the limits that make the run infeasible; continuous torques limit the root mean square only."""
        return run_limits.exceeded(self.events, self.root_mean_squares)

    @property
    def feasible(self) -> bool:
        """Whether the run is complete and within limits."""
        return self.complete and not self.exceeded

    @property
    def slips(self) -> tuple[float, ...]:
        """Instants at which a wheel begins to slip. [s]"""
        return tuple(event.start for event in self.events if event.limit == Limit.SLIP)
