"""What all simulated runs have in common, of drives, of machines, and with a user at the handle: energies, limits, verdict."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Protocol

import numpy as np

from infinivar.analysis import run_limits
from infinivar.analysis.run_limits import Event
from infinivar.bondgraph.audit import CLOSURE
from infinivar.limits import Demand, Limit
from infinivar.units import plain


class History(Protocol):
    """Time, energies by part and outcome of a run; t instants. Energies are those since the start, by name. [J]"""

    @property
    def time(self) -> np.ndarray:
        """(t,) [s]"""
        ...

    @property
    def supplied(self) -> Mapping[str, np.ndarray]:
        """From each source. (t,) each"""
        ...

    @property
    def lost(self) -> Mapping[str, np.ndarray]:
        """By part. (t,) each"""
        ...

    @property
    def stored(self) -> Mapping[str, np.ndarray]:
        """By part. (t,) each"""
        ...

    @property
    def residual(self) -> np.ndarray:
        """Energy that is unaccounted for, over the energy moved. (t,) [-]"""
        ...

    @property
    def outcome(self) -> str:
        """Empty, or why the run ended early."""
        ...


class Run:
    """Base of results with a history, events and root mean squares of demands."""

    __slots__ = ()
    events: tuple[Event, ...]
    root_mean_squares: Mapping[Demand, float]

    @property
    def history(self) -> History:
        """Time, energies and outcome: those of the result itself, or of a part of it."""
        return self  # type: ignore[return-value]

    @property
    def closure(self) -> float:
        """Largest residual of the balance of energies. [-]"""
        return float(np.max(np.abs(self.history.residual)))

    @property
    def complete(self) -> bool:
        """Whether the run reached its end."""
        return not self.history.outcome

    @property
    def exceeded(self) -> tuple[str, ...]:
        """Names of the limits that make the run infeasible.

        Continuous torques of motors and gearheads limit the root mean square only; short overloads are feasible. All other
        limits apply to each instant after the settling time.
        """
        return run_limits.exceeded(self.events, self.root_mean_squares)

    @property
    def feasible(self) -> bool:
        """Whether the run is complete and within limits."""
        return self.complete and not self.exceeded

    @property
    def slips(self) -> tuple[float, ...]:
        """Instants at which a wheel begins to slip. [s]"""
        return tuple(event.start for event in self.events if event.limit == Limit.SLIP)

    @property
    def event_lines(self) -> tuple[str, ...]:
        """Demands beyond their allowance, in a line for each interval, or for all of one limit if they are many or count
        by their root mean square."""
        return run_limits.lines(self.events, self.root_mean_squares)

    @property
    def verdict(self) -> str:
        """One-line verdict: exceeded limits, errors, energy by source, closure."""
        if not self.complete:
            return self.history.outcome
        end = float(self.history.time[-1])
        limits = run_limits.verdict(self.events, self.root_mean_squares, end, self._settling_time)
        closed = f"energy balance closed to {plain(CLOSURE, 1)}"
        return "; ".join([limits, *self._achieved(), *self._spent(), closed, *self._doubts()])

    @property
    def supplied_after_settling(self) -> float:
        """Energy from all supplies after the settling time, of motor and steering. [J]"""
        return self._from_supply(self._settled)

    @property
    def _settling_time(self) -> float | None:
        """Time by which the run is not judged. [s]"""
        return None

    @property
    def _settled(self) -> int:
        """The first instant by which it is judged."""
        return run_limits.first_settled(self.history.time, self._settling_time)

    def _achieved(self) -> Iterator[str]:
        """What the run did, for the verdict."""
        yield from ()

    def _spent(self) -> Iterator[str]:
        """Energy by source, for the verdict."""
        yield from ()

    def _doubts(self) -> tuple[str, ...]:
        """What is doubtful, for the verdict."""
        return ()

    def _supplies(self, first: int = 0) -> dict[str, float]:
        """Energy from each electrical supply from an instant on. [J]"""
        energies = self.history.supplied.items()
        return {name: float(energy[-1] - energy[first]) for name, energy in energies if "supply" in name}

    def _from_supply(self, first: int = 0) -> float:
        """Energy from all of them. [J]"""
        return sum(self._supplies(first).values())

    def _judgement(self) -> dict[str, Any]:
        """Verdict for JSON."""
        return {"verdict": self.verdict, "complete": self.complete, "feasible": self.feasible}

    def _balance(self) -> dict[str, Any]:
        """Energies at the end, and their closure, for JSON."""
        return {
            "supplied_J": {name: float(energy[-1]) for name, energy in self.history.supplied.items()},
            "lost_J": {name: float(energy[-1]) for name, energy in self.history.lost.items()},
            "stored_J": {name: float(energy[-1] - energy[0]) for name, energy in self.history.stored.items()},
            "closure": self.closure,
        }

    def _log(self, settles: bool = True) -> list[dict[str, Any]]:
        """Events for JSON; with `settles`, whether they lie in a settling time."""
        return [
            {
                "limit": event.limit.name,
                "what": event.what,
                "start_s": event.start,
                "end_s": event.end,
                "worst": event.worst,
                **({"while_settling": bool(event.settling)} if settles else {}),
            }
            for event in self.events
        ]


def error_words(of: str, rotary: bool, most: float, last: float) -> str:
    """A position error in words, in millimetres or radians, from metres or radians."""
    scale, unit = (1.0, "rad") if rotary else (1e3, "mm")
    return f"{of} error {plain(scale * most, 2)} {unit} at most, {plain(scale * last, 2)} {unit} at the end"
