"""Result of a search: the best designs, how many candidates each limit excludes, and which limits could not be checked."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Literal, NamedTuple

import numpy as np

from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.limits import Demand, Limit
from infinivar.parts.stage import OutputStage
from infinivar.sizing.geared.sampled import TaskDemand
from infinivar.sizing.margins import margin_of, tightest_of

Objective = Literal["energy", "mass", "front"]


def best_so_far(power: float, mass: float) -> str:
    """Words on the best design that a search has found until now."""
    said = [f"{value:.3g} {unit}" for value, unit in ((power, "W"), (mass, "kg")) if math.isfinite(value)]
    return f"best: {', '.join(said)}" if said else "no feasible design yet"


class LimitCount(NamedTuple):
    """Candidates that a limit excludes in a motion or in the required region."""

    task: str
    limit: Limit
    part: str
    checked: int
    """Candidates for which the limit was evaluated; a limit that a data sheet does not state is not."""
    exceeded: int
    """Of these, candidates that exceed it; over a range of radii, at every radius by the closed forms."""
    first: int
    """Of these, candidates that no limit before it in the list excludes; over a range of radii, that have no radius left.

    Candidates that only the evaluation at every instant excludes count here once; over a range of radii under the limit that is
    the tightest at their best radius. Every candidate that is judged and infeasible is thus counted once.
    """


class Design(NamedTuple):
    """A feasible candidate, evaluated at every instant."""

    pair: int
    """Row of the pair."""
    motor: int
    """Row of the motor."""
    gearhead: int
    """Row of the gearhead."""
    stage: OutputStage
    drive: ConventionalDrive
    """As a study would have it; `duty_cycle` and `compare` give the same values."""
    mass: float
    """Of motor and gearhead; nan if one is not stated. [kg]"""
    power: float
    """Mean power from the supply over all motions; nan without a motion. [W]"""
    radii: tuple[float, float]
    """Least and largest feasible radius around the best; nan if stages were given. [m]"""
    demands: Mapping[TaskDemand, float]
    """Demand over allowance by task, limit and part. [-]"""
    unchecked: tuple[Demand, ...]
    """Limits that the data sheets do not state."""

    @property
    def margin(self) -> float:
        """Allowance over demand of the tightest limit. [-]"""
        return margin_of(self.demands)

    @property
    def tightest(self) -> TaskDemand | None:
        """Task, limit and part with the largest demand; None if no limit is loaded."""
        return tightest_of(self.demands)


class GearedSizing(NamedTuple):
    """Result of `size_geared`. Rows of arrays are the stages, or one for a range of radii; columns are the pairs."""

    objective: Objective
    candidates: int
    """Pairs, times stages."""
    excluded: Mapping[str, int]
    """Candidates without the values that a law needs, by reason."""
    counts: tuple[LimitCount, ...]
    """In the order in which limits are checked."""
    designs: tuple[Design, ...]
    """The best, in order; of a front all, by power."""
    feasible: np.ndarray
    """Candidates that keep all limits; over a range of radii, those that the closed forms leave. (s, n) bool"""
    evaluated: np.ndarray
    """Candidates that were evaluated at every instant. (s, n) bool"""
    power: np.ndarray
    """Mean power from the supply of those; over a range of radii at the best radius. nan for others. (s, n) [W]"""
    radii: np.ndarray
    """Bounds of the feasible radii by the closed forms, nan where there are none; empty if stages were given. (n, 2) [m]"""
    unchecked: Mapping[Demand, int]
    """Number of candidates whose data sheets do not state a limit."""

    @property
    def best(self) -> Design | None:
        """The best design; None if no candidate is feasible."""
        return self.designs[0] if self.designs else None

    @property
    def left(self) -> int:
        """Candidates that closed forms leave: with some radius, or at a given stage to be evaluated at every instant."""
        return int((self.feasible if self.radii.size else self.evaluated).sum())
