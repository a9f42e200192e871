"""Value of wheel designs with the best motors behind them, in tiers: infeasible designs by what they exceed."""

from __future__ import annotations

import copy
import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum, unique
from typing import NamedTuple, Protocol

import numpy as np

from infinivar._core.threads import in_order
from infinivar.drivetrain import layout
from infinivar.drivetrain.masses import open_structure
from infinivar.limits import Limit
from infinivar.sizing.cobotic.bounds import MOTOR, MotorBounds, Side, cylinder_signals, lower_bounds, steering_signals
from infinivar.sizing.cobotic.choice import (
    NOT_CHOSEN,
    Behind,
    ChosenMotors,
    best_behind,
    least_power,
    together,
    towards_lighter,
)
from infinivar.sizing.cobotic.sampled import SideSampled, sample
from infinivar.sizing.cobotic.space import Points, Space
from infinivar.sizing.cobotic.wheels import (
    CONTACT,
    Shaft,
    Wheels,
    critical,
    evaluate,
    joined,
    named_static,
    shape_excess,
    static_demands,
)
from infinivar.sizing.geared.candidates import ENVELOPE
from infinivar.sizing.geared.tasks import MotionTask, Task
from infinivar.sizing.margins import TaskDemand, nearest_of
from infinivar.sizing.tables import CoboticRequest, Objective


@unique
class State(IntEnum):
    """How far the evaluation of an infeasible wheel design came; its number is above every value of a better state.

    Values of feasible designs, powers and masses, are below all of them.
    """

    WITHOUT_MOTORS = 1_000_000_000
    """The wheel keeps its limits, and no motors behind it keep theirs."""
    WHEEL = 2_000_000_000
    """The wheel slips or exceeds a limit at some instant."""
    CRITICAL = 2_010_000_000
    """It does so at a critical instant: the others were not looked at."""
    PRELOAD = 3_000_000_000
    """The preload alone exceeds a limit, or the patch is beyond the tables of the law."""

    def value_of(self, excess: np.ndarray) -> np.ndarray:
        """Value of designs in this state that rises with a demand over allowance above 1."""
        return self + _RISE * (1.0 - 1.0 / np.maximum(excess, 1.0))


NOT_FEASIBLE = State.WITHOUT_MOTORS
"""Least value of an infeasible design."""
_RISE = 1e6
"""By which values in one state differ at most; less than two states do."""
_NO_MOTION = 1e3
"""Excess of a wheel that slips where the demand has no number; twice that of one that slips all the time."""


_POINTS = 12_800
"""Instants of all designs computed at once, so that intermediate arrays fit the processor's caches."""
_POINTS_COMPILED = 400_000
"""The same where a compiler keeps intermediate values small, and the most whose results are kept to choose motors by."""
_BEHIND = 1_000_000
"""Candidates behind all designs computed at once."""
_BLOCK = 128
"""Wheel designs behind which one thread chooses motors. Of any number of threads, so that the last digits are the same."""
_NEAREST = 64
"""Candidates that are evaluated at every instant where none is feasible."""
_AT_ONCE = 1000
"""Wheel designs looked at together first."""


Counts = tuple[int, int, int, Mapping[TaskDemand, int]]
"""See `Evaluation.counts`."""


class Value(NamedTuple):
    """Values of wheel designs. (k,) each"""

    value: np.ndarray
    """Of the objective where feasible, otherwise that of a `State`."""
    pair: np.ndarray
    """Best pair of motor and gearhead; `NOT_CHOSEN` where none is feasible."""
    steering: np.ndarray
    """Best pair of steering motor and ratio; `NOT_CHOSEN` where none is feasible."""
    power: np.ndarray
    """[W]"""
    mass: np.ndarray
    """[kg]"""

    @property
    def feasible(self) -> np.ndarray:
        """Which of them keep all limits. (k,) bool"""
        return self.value < NOT_FEASIBLE


class Rolls(Protocol):
    """How wheel designs do what they have to: on one axis, or as the legs of a machine."""

    def wheels(self, points: Points, tasks: Sequence[Task]) -> Wheels:
        """Evaluate wheel designs, whose heads must be of one kind."""
        ...

    def bounds(
        self, side: Side, shafts: Mapping[str, Shaft], tasks: Sequence[Task]
    ) -> Sequence[tuple[float, MotorBounds]]:
        """Lower bounds of all candidates of a side, each with the share at which its power counts."""
        ...

    def sample(
        self, side: Side, rows: np.ndarray, places: np.ndarray, shafts: Mapping[str, Shaft], tasks: Sequence[Task]
    ) -> SideSampled:
        """Candidates of a side behind wheel designs, at every instant."""
        ...

    def structure(self, points: Points) -> np.ndarray:
        """Mass of all but motors and gearheads. (k,) [kg]"""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class OneAxis:
    """Wheel designs as drives of one axis; see `Rolls`."""

    space: Space
    life: float | None
    shares: Mapping[str, float]

    def wheels(self, points: Points, tasks: Sequence[Task]) -> Wheels:
        """See `Rolls.wheels`."""
        return evaluate(self.space, points, tasks, life=self.life)

    def bounds(self, side: Side, shafts: Mapping[str, Shaft], tasks: Sequence[Task]) -> list[tuple[float, MotorBounds]]:
        """See `Rolls.bounds`; steering rests in a required region."""
        found, plant = [], self.space.template.steering
        for task in tasks:
            share = self.shares.get(task.name, 0.0)
            if side.name == MOTOR:
                found.append((share, lower_bounds(side, task, cylinder_signals(task, shafts[task.name]))))
            elif isinstance(task, MotionTask) and plant is not None:
                found.append((share, lower_bounds(side, task, steering_signals(plant, shafts[task.name]))))
        return found

    def sample(
        self, side: Side, rows: np.ndarray, places: np.ndarray, shafts: Mapping[str, Shaft], tasks: Sequence[Task]
    ) -> SideSampled:
        """See `Rolls.sample`."""
        return sample(side, rows, places, tasks, shafts, self.shares, self.space.template.steering)

    def structure(self, points: Points) -> np.ndarray:
        """See `Rolls.structure`."""
        return self.space.structure(points)


class Evaluation:
    """Evaluates wheel designs, and counts."""

    def __init__(
        self,
        space: Space,
        sides: Sequence[Side],
        tasks: Sequence[Task],
        request: CoboticRequest,
        rolls: Rolls | None = None,
    ) -> None:
        """Nothing is counted yet."""
        self.space, self.sides, self.request = space, sides, request
        self.objective, self.shares = request.objective, request.shares
        self.rolls = OneAxis(space, request.life, request.shares) if rolls is None else rolls
        self.structured = not open_structure(space.template, space.service)
        """Whether the mass of the structure is known: where not, only motors and gearheads count."""
        self.look_at(tasks, tasks)
        self.envelope = request.envelope
        self.wheels = self.rolled = self.sampled = 0
        self.blocked: dict[TaskDemand, int] = {}

    def anew(self, objective: Objective) -> Evaluation:
        """The same for another objective, which has counted nothing yet."""
        made = copy.copy(self)
        made.objective, made.wheels, made.rolled, made.sampled, made.blocked = objective, 0, 0, 0, {}
        return made

    @property
    def counts(self) -> Counts:
        """Wheel designs, those that were rolled, drives sampled, and infeasible designs by their tightest limit."""
        return self.wheels, self.rolled, self.sampled, self.blocked

    def count(self, wheels: int, rolled: int, sampled: int, blocked: Mapping[TaskDemand, int]) -> None:
        """Add what another has counted."""
        self.wheels, self.rolled, self.sampled = self.wheels + wheels, self.rolled + rolled, self.sampled + sampled
        for key, number in blocked.items():
            self.blocked[key] = self.blocked.get(key, 0) + number

    def look_at(self, tasks: Sequence[Task], whole: Sequence[Task]) -> None:
        """Judge wheel designs by other tasks from now on, and first by the critical instants of all that there are."""
        self.tasks, self.first = tasks, critical(self.space.template, whole)

    @property
    def _rolled_at_once(self) -> int:
        """Number of wheel designs to evaluate together."""
        points = _POINTS if self.space.compiled is None else _POINTS_COMPILED
        longest = max(
            [1, *(len(one.instants.time if isinstance(one, MotionTask) else one.speed) for one in self.tasks)]
        )
        return max(1, points // longest)

    @property
    def _chosen_at_once(self) -> int:
        """Number of wheel designs behind which motors are chosen together: their instants are kept."""
        instants = sum(len(task.instants.time) for task in self.tasks if isinstance(task, MotionTask))
        candidates = max([1, *(len(side.rows) for side in self.sides)])
        return max(1, min(_POINTS_COMPILED // max(instants, 1), _BEHIND // candidates))

    def with_slip_margin(self, demands: Mapping[TaskDemand, np.ndarray]) -> dict[TaskDemand, np.ndarray]:
        """Demands with the margin wanted against slip."""
        return {
            key: demand * self.request.slip_margin if key[1] == Limit.SLIP else demand
            for key, demand in demands.items()
        }

    def values(self, points: Points) -> Value:
        """Evaluate wheel designs."""
        count = len(points.head)
        self.wheels += count
        result = _none(count)
        for some in self.space.batches(points, _AT_ONCE):
            looked = self.space.built(points.of(some))
            result.value[some], held = self._first_look(looked)
            some, looked = some[held], looked.of(held)
            for places in self.space.batches(looked, self._chosen_at_once):
                here = self._with_motors(looked.of(places))
                for whole, one in zip(result, here, strict=True):
                    whole[some[places]] = one
        return result

    def _first_look(self, points: Points) -> tuple[np.ndarray, np.ndarray]:
        """Value of designs that preload or the critical instants rule out, and which they do not. (k,), (k,) bool"""
        laws, known = self.space.compiled, None
        if laws is None:
            drive = self.space.columns(points)
            static, shape = static_demands(drive), shape_excess(drive)
        else:
            seen = laws.look(points, self.first)
            static, shape, known = named_static(seen.static, len(points.head)), seen.shape, seen.demanded
        excess = np.max([np.broadcast_to(np.ravel(shape), points.head.shape), *static.values()], axis=0)
        value, held = State.PRELOAD.value_of(excess), excess <= 1.0
        self._block(static, ~held)
        if self.first and held.any():
            some = np.flatnonzero(held)
            demanded = None if known is None else [one.of(some) for one in known]
            wheels = evaluate(self.space, points.of(some), self.first, life=None, demanded=demanded)
            with_slip_margin = self.with_slip_margin(wheels.demands)
            excess = _excess(with_slip_margin, wheels)
            self._block(with_slip_margin, excess > 1.0)
            value[some], held[some] = State.CRITICAL.value_of(excess), excess <= 1.0
        return value, held

    def _block(self, demands: Mapping[TaskDemand, np.ndarray], where: np.ndarray) -> None:
        """Count infeasible designs by their tightest limit."""
        if not demands or not where.any():
            return
        keys = list(demands)
        tight = np.argmax([demands[key][where] for key in keys], axis=0)
        for place, number in zip(*np.unique(tight, return_counts=True), strict=True):
            self.blocked[keys[place]] = self.blocked.get(keys[place], 0) + int(number)

    def _with_motors(self, points: Points) -> Value:
        """Value of wheels that the preload does not damage."""
        count = len(points.head)
        self.rolled += count
        parts = list(self.space.batches(points, self._rolled_at_once))
        wheels = joined(list(in_order(lambda some: self.rolls.wheels(points.of(some), self.tasks), parts)))
        with_slip_margin = self.with_slip_margin(wheels.demands)
        excess = _excess(with_slip_margin, wheels)
        result = _none(count)
        result.value[:] = State.WHEEL.value_of(excess)
        rolls = excess <= 1.0
        self._block(with_slip_margin, ~rolls)
        able = np.flatnonzero(rolls)
        structure = self._structure(points, able, result)
        able = able[np.isfinite(structure)]
        structure = structure[np.isfinite(structure)]
        if not able.size:
            return result
        heaviest = np.full(len(able), np.inf) if points.heaviest is None else points.heaviest[able]
        if self.envelope is not None and self.envelope.mass is not None:
            heaviest = np.minimum(heaviest, self.envelope.mass)
        if np.all(np.isfinite(heaviest)) and self.objective == "energy":
            self._choose_under(result, points, wheels, able, heaviest - structure)
            result.mass[able] += structure
            self._keep_within(result, points, able)
            return result
        chosen = [self._best(side, points, wheels, able) for side in self.sides]
        excess = np.max([one[0].excess for one in chosen], axis=0)
        feasible = np.all([one[0].row != NOT_CHOSEN for one in chosen], axis=0)
        total = np.sum([one[1] for one in chosen], axis=0)
        if self.objective == "mass":
            total = total + structure
        if self.objective == "space":
            held = np.flatnonzero(feasible)
            total[held] = np.ravel(self._space(points.of(able[held]), [one.row[held] for one, _ in chosen]).volume)
        result.value[able] = np.where(feasible, total, State.WITHOUT_MOTORS.value_of(excess))
        for column, (one, _) in zip((result.pair, result.steering), chosen, strict=False):
            column[able] = np.where(feasible, one.row, NOT_CHOSEN)
        result.power[able] = np.where(feasible, np.sum([one.power for one, _ in chosen], axis=0), np.nan)
        masses = [side.found.mass(np.maximum(one.row, 0)) for side, (one, _) in zip(self.sides, chosen, strict=True)]
        result.mass[able] = np.where(feasible, np.sum(masses, axis=0) + structure, np.nan)
        self._keep_within(result, points, able)
        return result

    def _keep_within(self, result: Value, points: Points, able: np.ndarray) -> None:
        """Take out the feasible ones of some designs that are too large or too heavy with both motors together."""
        held = able[result.feasible[able]]
        if self.envelope is None or not held.size:
            return
        space = self._space(points.of(held), (result.pair[held], result.steering[held]))
        demands = self.envelope.demands(space, result.mass[held][:, None])
        excess = np.max([np.ravel(np.broadcast_to(one, (len(held), 1))) for one in demands.values()], axis=0)
        beyond = excess > 1.0
        lost = held[beyond]
        result.value[lost] = State.WITHOUT_MOTORS.value_of(excess[beyond])
        result.pair[lost] = result.steering[lost] = NOT_CHOSEN
        result.power[lost] = result.mass[lost] = np.nan

    def _space(self, points: Points, rows: Sequence[np.ndarray]) -> layout.Space:
        """Boxes around wheel designs with candidates of each side. (k, 1)"""
        structure = self.space.template.structure
        parts = [side.found.sizes(one, structure) for side, one in zip(self.sides, rows, strict=False)]
        steering = {"steering": parts[1][0]} if len(parts) > 1 else {}
        return self.space.box(points, motor=parts[0][0], gearhead=parts[0][1], **steering)

    def _structure(self, points: Points, able: np.ndarray, result: Value) -> np.ndarray:
        """Mass of all but motors and gearheads; where no part carries it, nan, and its value is put in. [kg]"""
        found = np.zeros(len(able))
        if not self.structured or not able.size:
            return found
        for some in np.array_split(np.arange(len(able)), -(-len(able) // _BLOCK)):
            found[some] = self.rolls.structure(points.of(able[some]))
        beyond = able[~np.isfinite(found)]
        result.value[beyond] = State.PRELOAD.value_of(np.full(len(beyond), np.inf))
        if len(beyond):
            key = (CONTACT, Limit.WALL, "cylinder")
            self.blocked[key] = self.blocked.get(key, 0) + len(beyond)
        return found

    def _choose_under(
        self, result: Value, points: Points, wheels: Wheels, able: np.ndarray, heaviest: np.ndarray
    ) -> None:
        """Put in the motors of the least power that are together not heavier than wheel designs permit. (k,) [kg]"""
        cylinder, steering = (self._behind(side, points, wheels, able) for side in self.sides)
        found = least_power(cylinder, steering, heaviest, prune=self.request.prune)
        self.sampled += found.evaluated
        feasible = found.cylinder != NOT_CHOSEN
        result.value[able] = np.where(feasible, found.power, State.WITHOUT_MOTORS.value_of(found.excess))
        result.pair[able], result.steering[able] = found.cylinder, found.steering
        result.mass[able] = found.mass
        result.power[able] = np.where(feasible, found.power, np.nan)

    def nearest(self, side: Side, points: Points, wheels: Wheels) -> int:
        """Candidate of a side behind the first of some wheels that is nearest to feasible; the best if some are feasible."""
        shafts = {name: shaft.of(np.array([0])) for name, shaft in wheels.shafts.items()}
        chosen, _ = self._best(side, points, wheels, np.array([0]))
        if chosen.row[0] != NOT_CHOSEN:
            return int(chosen.row[0])
        bounds = [
            np.max(list(one.demands.values()), axis=0)[:, 0] for _, one in self.rolls.bounds(side, shafts, self.tasks)
        ]
        first = side.rows[np.argsort(np.max(bounds, axis=0), kind="stable")[:_NEAREST]]
        none = np.zeros(len(first), dtype=int)
        done = self.rolls.sample(side, first, none, shafts, self.tasks)
        return int(first[nearest_of(list(done.demands.values()), side.found.mass(first))])

    def _best(self, side: Side, points: Points, wheels: Wheels, able: np.ndarray) -> tuple[ChosenMotors, np.ndarray]:
        """Best candidate of a side behind wheels that roll, and its part of the value."""
        by_mass = self.objective != "energy"

        def choose(some: np.ndarray) -> tuple[ChosenMotors, np.ndarray]:
            behind = self._behind(side, points, wheels, some)
            if self.objective == "price":
                behind = behind._replace(mass=side.found.price(side.rows))
            chosen = best_behind(behind, by_mass=by_mass, prune=self.request.prune)
            return chosen, towards_lighter(behind.mass, behind.worst, chosen.value) if by_mass else chosen.value

        blocks = np.split(able, range(_BLOCK, len(able), _BLOCK))
        parts, values = zip(*in_order(choose, blocks), strict=True)
        self.sampled += sum(one.evaluated for one in parts)
        return together(parts), np.concatenate(values)

    def _behind(self, side: Side, points: Points, wheels: Wheels, able: np.ndarray) -> Behind:
        """Candidates of a side behind wheels that roll."""
        shafts = {name: shaft.of(able) for name, shaft in wheels.shafts.items()}
        bounds = self.rolls.bounds(side, shafts, self.tasks)
        nothing = np.zeros((len(side.rows), len(able)))
        drawn = [share * one.power for share, one in bounds]
        sized = self._sized(side, points.of(able))
        worst = functools.reduce(np.maximum, (demand for _, one in bounds for demand in one.demands.values()), nothing)
        worst = functools.reduce(np.maximum, sized.values(), worst)

        def evaluate_some(tried: np.ndarray, places: np.ndarray) -> SideSampled:
            done = self.rolls.sample(side, tried, places, shafts, self.tasks)
            rows = np.searchsorted(side.rows, tried)
            own = {key: demand[rows, places] for key, demand in sized.items()}
            fits = [demand <= 1.0 for demand in own.values()]
            return done._replace(
                demands={**done.demands, **own}, feasible=np.logical_and.reduce([done.feasible, *fits])
            )

        return Behind(
            rows=side.rows,
            mass=side.found.mass(side.rows),
            power=np.sum([nothing, *drawn], axis=0),
            worst=worst,
            evaluate=evaluate_some,
        )

    def _sized(self, side: Side, points: Points) -> dict[TaskDemand, np.ndarray]:
        """Demand over allowance of the envelope of wheel designs with candidates of one side alone. (p, k)"""
        if self.envelope is None:
            return {}
        motor, gearhead = (
            {name: one.T for name, one in part.items()}
            for part in side.found.sizes(side.rows, self.space.template.structure)
        )
        parts = {"motor": motor, "gearhead": gearhead} if side.name == MOTOR else {"steering": motor}
        shape = len(points.head), len(side.rows)
        found = self.envelope.demands(self.space.box(points, **parts))
        return {(ENVELOPE, *key): np.broadcast_to(demand, shape).T for key, demand in found.items()}


def _none(count: int) -> Value:
    """Values of designs of which none is feasible."""
    unknown = np.full(count, np.nan)
    return Value(
        np.full(count, np.inf), np.full(count, NOT_CHOSEN), np.full(count, NOT_CHOSEN), unknown, unknown.copy()
    )


def _excess(with_slip_margin: Mapping[TaskDemand, np.ndarray], wheels: Wheels) -> np.ndarray:
    """Largest demand on wheels; where they slip beyond it, by the share of instants that do. (k,)"""
    worst = np.max([np.zeros(len(wheels.slipping)), *with_slip_margin.values()], axis=0)
    slips = ~np.isfinite(worst) | (wheels.slipping > 0.0)
    return np.where(slips, _NO_MOTION * (1.0 + wheels.slipping), worst)
