"""What a search over tables of parts finds: designs, what became of the candidates, and how many each limit excludes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.limits import Demand, Limit
from infinivar.parts.stage import OutputStage
from infinivar.sizing.margins import TaskDemand, margin_of, tightest_of
from infinivar.sizing.tables import Objective


@dataclass(frozen=True, slots=True, kw_only=True)
class FoundDesign:
    """A candidate of tables, evaluated at every instant.

    Attributes
    ----------
    pair        Row of the pair; -1: the template's, as of motor and gearhead.
    motor       Row of the motor.
    gearhead    Row of the gearhead.
    drive       As a study would have it; `duty_cycle` and `compare` give the same values.
    mass        Of the whole drive; nan if a body's is not known. [kg]
    power       Mean power from the supply over all motions; nan without a motion. [W]
    volume      Of the box around it; nan where no body is placed. [m^3]
    price       Of motors and gearhead, in the currency of their set; nan if one is not stated.
    demands     Demand over allowance by task, limit and part. [-]
    unchecked   Limits that the data sheets do not state.
    """

    pair: int
    motor: int
    gearhead: int
    drive: ConventionalDrive | CoboticDrive
    mass: float
    power: float
    volume: float
    price: float
    demands: Mapping[TaskDemand, float]
    unchecked: tuple[Demand, ...]

    @property
    def checked(self) -> dict[TaskDemand, float]:
        """Demands of limits that the data sheets state."""
        return {key: demand for key, demand in self.demands.items() if key[1:] not in self.unchecked}

    @property
    def margin(self) -> float:
        """Allowance over demand of the tightest limit. [-]"""
        return margin_of(self.demands)

    @property
    def tightest(self) -> TaskDemand | None:
        """Task, limit and part with the largest demand; None if no limit is loaded."""
        return tightest_of(self.demands)


@dataclass(frozen=True, slots=True, kw_only=True)
class Design(FoundDesign):
    """A geared drive.

    Attributes
    ----------
    stage   Output stage.
    radii   Least and largest feasible radius around the best; nan if stages were given. [m]
    """

    drive: ConventionalDrive
    stage: OutputStage
    radii: tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class CoboticDesign(FoundDesign):
    """A cobotic drive.

    Attributes
    ----------
    bearing    Place of the axle bearing.
    wheels     Around the cylinder.
    support    Place of the cylinder bearing.
    steering   Row of the steering motor; -1: the template's, or none.
    ratio      Of the steering motor's gear. [-]
    values     Continuous values by name, see `FREE`. In SI.
    """

    drive: CoboticDrive
    bearing: int
    wheels: int
    support: int
    steering: int
    ratio: float
    values: Mapping[str, float]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FoundDesigns:
    """Result of a search over tables.

    Attributes
    ----------
    objective    energy, mass, space, price or front.
    candidates   Combinations of parts and, of geared drives, output stages; also those without the values that a law needs.
    excluded     Candidates or parts without the values that a law needs, and parts that no design can use, by reason.
    designs      The best, in order.
    unchecked    Number of candidates whose data sheets do not state a limit; of steering motors each once.
    """

    objective: Objective
    candidates: int
    excluded: Mapping[str, int]
    designs: tuple[Any, ...]
    unchecked: Mapping[Demand, int]

    @property
    def best(self) -> Any:
        """The best design; None if none is feasible."""
        return next(iter(self.designs), None)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GearedSizing(FoundDesigns):
    """Result of `size_geared`. Rows of arrays are the stages, or one for a range of radii; columns are the pairs.

    Attributes
    ----------
    designs      The best, in order; of a front all, by power.
    counts       Candidates that each limit excludes, in the order in which limits are checked.
    feasible     Candidates that keep all limits; over a range of radii, those that the closed forms leave. (s, n) bool
    evaluated    Candidates that were evaluated at every instant. (s, n) bool
    power        Mean power from the supply of those; over a range of radii at the best radius. nan for others. (s, n) [W]
    mass         Whole mass of those. (s, n) [kg]
    radii        Bounds of the feasible radii by the closed forms, nan where there are none; empty if stages were given. (n, 2)
        [m]
    """

    designs: tuple[Design, ...]
    counts: tuple[LimitCount, ...]
    feasible: np.ndarray
    evaluated: np.ndarray
    power: np.ndarray
    mass: np.ndarray
    radii: np.ndarray

    @property
    def left(self) -> int:
        """Candidates that closed forms leave: with some radius, or at a given stage to be evaluated at every instant."""
        return int((self.feasible if self.radii.size else self.evaluated).sum())


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CoboticSizing(FoundDesigns):
    """Result of `size_cobotic`.

    Attributes
    ----------
    designs      The best found, in order: of each combination of parts the best values.
    front        Of all feasible designs evaluated, those of which no other has both less mass and less power, by power:
                 those that are 3 % of their mass apart, and the lightest.
    wheels       Wheel designs looked at: bearings, a number of wheels and five values.
    rolled       Of those, evaluated over the motions.
    drives       Drives covered: wheel designs that roll, times all motors, gearheads, steering motors and ratios.
    sampled      Motors evaluated at every instant behind a wheel; the others are excluded by bounds.
    blocked      Wheel designs that are infeasible whichever motors drive them, by the tightest limit.
    history      Value of the objective of the best design after each generation, inf before the first. (n,)
    cloud        Mass and least power of each combination of parts that was the best behind a feasible wheel design. (n, 2)
        [kg], [W]
    nearest      If no design is feasible, the one found that is nearest: by the tightest limit of its motors, or of its wheel.
        Behind a wheel that slips are the template's motors, whose demands are not known.
    """

    designs: tuple[CoboticDesign, ...]
    front: tuple[CoboticDesign, ...]
    wheels: int
    rolled: int
    drives: int
    sampled: int
    blocked: Mapping[TaskDemand, int]
    history: np.ndarray
    cloud: np.ndarray
    nearest: CoboticDesign | None = None


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
