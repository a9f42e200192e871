"""What became of the candidates of a search, by template."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from infinivar._core.described import derived, finite, reported, rows
from infinivar._core.result import Frozen, result
from infinivar._core.text import counted
from infinivar.limits import Demand
from infinivar.sizing.design import SizedDrive, limit_words
from infinivar.sizing.found import LimitCount
from infinivar.sizing.margins import TaskDemand

OF_FRONT = ": left out of the front"
"""End of a reason for which candidates are left out of the front alone."""

_UNCHECKED_ROWS = rows("limit", "part", "candidates")


@result
class TriedValue(Frozen):
    """A value of a template that was tried, and the best found with it.

    Attributes
    ----------
    path           In the drive.
    value          In SI.
    unit           In SI.
    candidates     Number of candidates with it.
    feasible       Whether one of them keeps all limits.
    design         The best of them, or the nearest miss; None if there is neither.
    """

    path: str = reported()
    value: float = reported()
    unit: str = reported()
    candidates: int = reported()
    feasible: bool = reported()
    design: SizedDrive | None

    @derived("W")
    def power(self) -> float:
        """Mean power of the best design; nan if none is feasible, or without a motion. [W]"""
        return self.design.power if self.feasible and self.design is not None else math.nan

    @derived("kg")
    def mass(self) -> float:
        """Mass of the best design; nan if none is feasible. [kg]"""
        return self.design.mass if self.feasible and self.design is not None else math.nan

    @derived("1")
    def margin(self) -> float:
        """Margin of the best design, or of the nearest miss; nan if there is neither. [-]"""
        return math.nan if self.design is None else self.design.margin


@result
class SearchRecord(Frozen):
    """What became of the candidates for a geared template.

    Attributes
    ----------
    candidates     Number of candidates: pairs of motor and gearhead, times the output stages that are given.
    left           Of these, those for which closed forms leave a radius; with given stages, those that closed forms leave.
    evaluated      Of these, evaluated at every instant: with given stages all; the others cannot be among the best.
    excluded       Candidates without the values that a law needs, by reason.
    counts         Candidates that each limit excludes, in the order in which limits are checked.
    unchecked      Candidates whose data sheets do not state a limit.
    ranges         Ranges searched, by path. [m]
    cloud          Mass and mean power of the feasible candidates that were evaluated; nan where not known. (n, 2) [kg], [W]
    nearest        If no candidate is feasible, that which comes nearest to keeping all limits, see `nearest_of`.
    stages         Number of output stages, or combinations of values, tried with every pair.
    stage_words    What they differ in: radii, leads, or "output stages".
    tried          Values of the template that were tried, each with the best design.
    closed         Whether closed forms left out candidates; of machines, every one is evaluated.
    """

    candidates: int = reported()
    left: int = reported()
    evaluated: int = reported()
    excluded: Mapping[str, int] = reported()
    counts: tuple[LimitCount, ...] = reported(key="limits")
    unchecked: Mapping[Demand, int] = reported(convert=_UNCHECKED_ROWS)
    ranges: Mapping[str, tuple[float, float]] = reported()
    cloud: np.ndarray
    nearest: SizedDrive | None = reported(default=None)
    stages: int = reported(default=1)
    stage_words: str = "output stages"
    tried: tuple[TriedValue, ...] = reported(default=(), optional=True)
    closed: bool = True

    @property
    def counted_as(self) -> str:
        """What a candidate is: one of the pairs, or a pair at one of the output stages."""
        return "pairs" if self.stages == 1 else "candidates"

    @property
    def words(self) -> str:
        """Number of candidates, such as "7 pairs" or "14 candidates (7 pairs with 2 radii each)"."""
        if self.stages == 1:
            return counted(self.candidates, "pairs")
        pairs = counted(self.candidates // self.stages, "pairs")
        return f"{counted(self.candidates, 'candidates')} ({pairs} with {self.stages:,} {self.stage_words} each)"

    @property
    def unjudged(self) -> dict[str, int]:
        """Candidates that could not be judged by any limit, by reason."""
        return {reason: number for reason, number in self.excluded.items() if not reason.endswith(OF_FRONT)}


@result
class WheelRecord(Frozen):
    """What became of the candidates for a cobotic template.

    Attributes
    ----------
    candidates     Combinations of motor and gearhead, bearings, number of wheels, steering motor and ratio.
    wheels         Wheel designs looked at: bearings, number of wheels, radii of wheel and cylinder, its speed, preload.
    rolled         Of these, those that neither preload nor slip at some instants rules out.
    drives         Drives covered: wheel designs that roll, times all motors, gearheads, steering motors and ratios.
    evaluated      Motors evaluated at every instant behind a wheel; bounds exclude the others.
    excluded       Parts without the values that a law needs, and those that no wheel design can use, by reason.
    blocked        Wheel designs infeasible with any motor, by the tightest limit.
    unchecked      Pairs, or steering motors, whose data sheets do not state a limit.
    ranges         Ranges searched, by path. In SI.
    steering_ratios   Ratios tried between steering motor and bell.
    bearings       Axle bearings tried, by name.
    cylinder_bearings   Bearings of the cylinder tried, by name; none where the template states none.
    numbers_of_wheels   Numbers of wheels tried.
    cloud          Mass and least mean power of each combination of parts that was the best behind a feasible wheel design. (n, 2)
        [kg], [W]
    history        Best value of the first objective after each generation, inf before the first; the last generations count
        more instants. (n,) [W] or [kg]
    compiled       Whether JAX compiled the laws of the wheel.
    nearest        If no candidate is feasible, the one found that is nearest.
    stages         Number of combinations of values of the template that were tried.
    stage_words    What they differ in.
    tried          Values of the template that were tried, each with the best design.
    """

    candidates: int = reported()
    wheels: int = reported(key="wheel_designs")
    rolled: int = reported()
    drives: int = reported()
    evaluated: int = reported()
    excluded: Mapping[str, int] = reported()
    blocked: Mapping[TaskDemand, int] = reported(convert=rows("task", "limit", "part", "wheel_designs"))
    unchecked: Mapping[Demand, int] = reported(convert=_UNCHECKED_ROWS)
    ranges: Mapping[str, tuple[float, float]] = reported()
    steering_ratios: tuple[float, ...] = reported()
    bearings: tuple[str, ...] = reported()
    cylinder_bearings: tuple[str, ...] = reported()
    numbers_of_wheels: tuple[int, ...] = reported()
    cloud: np.ndarray
    history: np.ndarray = reported(convert=finite)
    compiled: bool = reported(default=False)
    nearest: SizedDrive | None = reported(default=None)
    stages: int = 1
    stage_words: str = ""
    tried: tuple[TriedValue, ...] = reported(default=(), optional=True)

    @property
    def words(self) -> str:
        """Number of candidates."""
        found = counted(self.candidates, "cobotic combinations")
        return found if self.stages == 1 else f"{found} ({self.stages:,} {self.stage_words})"

    @property
    def unjudged(self) -> dict[str, int]:
        """None: combinations without the values that a law needs are counted by part."""
        return {}


def merged(records: Sequence[Any], best: Any) -> Any:
    """One record of several searches over drives like one template; what cannot be added is that of the best."""
    added = ("candidates", "left", "evaluated", "wheels", "rolled", "drives", "excluded", "blocked", "unchecked")
    own: dict[str, Any] = {name: _sum([getattr(one, name) for one in records]) for name in added if hasattr(best, name)}
    if isinstance(best, SearchRecord):
        counts = _sum([{count[:3]: np.array(count[3:]) for count in one.counts} for one in records])
        own["counts"] = tuple(LimitCount(*key, *map(int, numbers)) for key, numbers in counts.items())
    return replace(best, **own, cloud=np.concatenate([one.cloud for one in records]))


def _sum(values: Sequence[Any]) -> Any:
    """Sum of numbers, or of the numbers of each entry."""
    if not isinstance(values[0], Mapping):
        return sum(values)
    keys = dict.fromkeys(key for one in values for key in one)
    return {key: sum(one[key] for one in values if key in one) for key in keys}


def limit_lines(counts: Iterable[LimitCount]) -> Iterator[str]:
    """Yield a line for each limit that excludes candidates, on its own or in addition to those checked before it."""
    beyond = [count for count in counts if count.exceeded or count.first]
    for place, count in enumerate(beyond):
        where = limit_words((count.task, count.limit, count.part))
        said = f"{where}: rules out {count.exceeded:,} of {count.checked:,} on its own"
        if place or count.first != count.exceeded:
            said += f", {f'{count.first:,}' if count.first else 'none'} in addition to the limits above"
        yield said
