"""Result of a search over cobotic drives."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, NamedTuple

import numpy as np

from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.limits import Demand
from infinivar.sizing.geared.sampled import TaskDemand
from infinivar.sizing.margins import margin_of, tightest_of

Objective = Literal["energy", "mass", "front"]


class CoboticDesign(NamedTuple):
    """A drive, evaluated at every instant."""

    pair: int
    """Row of the pair of motor and gearhead; -1: the template's, as of motor and gearhead."""
    motor: int
    """Row of the motor."""
    gearhead: int
    """Row of the gearhead."""
    bearing: int
    """Place of the axle bearing."""
    steering: int
    """Row of the steering motor; -1: the template's, or none."""
    ratio: float
    """Of the steering motor's gear. [-]"""
    values: Mapping[str, float]
    """Continuous values by name, see `FREE`. In SI."""
    drive: CoboticDrive
    """As a study would have it; `duty_cycle` and `compare` give the same values."""
    mass: float
    """Of cylinder motor, gearhead and steering motor; nan if one is not stated. [kg]"""
    power: float
    """Mean power from the supply over all motions; nan without a motion. [W]"""
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


class CoboticSizing(NamedTuple):
    """Result of `size_cobotic`."""

    objective: Objective
    designs: tuple[CoboticDesign, ...]
    """The best found, in order: of each combination of parts the best values."""
    front: tuple[CoboticDesign, ...]
    """Of all feasible designs evaluated, those of which no other has both less mass and less power, by power."""
    wheels: int
    """Wheel designs looked at: a bearing and five values."""
    rolled: int
    """Of those, evaluated over the motions."""
    drives: int
    """Drives covered: wheel designs that roll, times all motors, gearheads, steering motors and ratios."""
    sampled: int
    """Motors evaluated at every instant behind a wheel; the others are excluded by bounds."""
    excluded: Mapping[str, int]
    """Parts without the values that a law needs, and those that no wheel design can use, by reason."""
    blocked: Mapping[TaskDemand, int]
    """Wheel designs that are infeasible whichever motors drive them, by the tightest limit."""
    history: np.ndarray
    """Value of the objective of the best design after each generation, inf before the first. (n,) [W] or [kg]"""
    cloud: np.ndarray
    """Mass and least power of each combination of parts that was the best behind a feasible wheel design. (n, 2) [kg], [W]"""
    candidates: int
    """Combinations of motor and gearhead, bearing, steering motor and ratio, also those without the values that a law needs."""
    unchecked: Mapping[Demand, int]
    """Pairs, or steering motors, whose data sheets do not state a limit."""
    nearest: CoboticDesign | None = None
    """If no design is feasible, the one found that is nearest: by the tightest limit of its motors, or of its wheel. Behind a
    wheel that slips are the template's motors, whose demands are not known."""

    @property
    def best(self) -> CoboticDesign | None:
        """The best design; None if none is feasible."""
        return self.designs[0] if self.designs else None
