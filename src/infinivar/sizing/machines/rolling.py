"""Search over machines whose wheels roll on a sphere or on the ground: preload, radii, and the motor of a sphere."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from infinivar._core.fields import quantities_of, value_at, with_values
from infinivar.drivetrain.drive import motor_side
from infinivar.errors import InputError, ParameterError
from infinivar.machines.machine import as_machine
from infinivar.sizing.cobotic.bounds import MOTOR, Side
from infinivar.sizing.cobotic.choice import NOT_CHOSEN, Behind, best_behind
from infinivar.sizing.cobotic.search import RANGE
from infinivar.sizing.cobotic.wheels import Shaft
from infinivar.sizing.design import FreeValue, SizedDrive
from infinivar.sizing.geared.candidates import LIMIT_FIELDS, Pairs, pairs_of
from infinivar.sizing.geared.tasks import DIRECT, PROBE
from infinivar.sizing.machine_templates import searched_values
from infinivar.sizing.machines.behind import asked_of, bounds_behind, sampled_behind
from infinivar.sizing.machines.work import MachineWork
from infinivar.sizing.margins import TaskDemand, tightest_of
from infinivar.sizing.progress import Progress
from infinivar.sizing.records import WheelRecord
from infinivar.sizing.request import Found, StudyRequest
from infinivar.units import show

_POPULATION = 12
_OF_MOTOR = (MOTOR, "gearhead")
_INFEASIBLE = 1e9
"""Value of an infeasible design, beside which its demand over allowance counts."""

_IMPOSSIBLE = 1e18
"""Value of what cannot be built, such as a roller that does not fit."""


class _Found(NamedTuple):
    """A design of some values with the best motor for them."""

    power: float
    """[W]; inf where a limit is exceeded."""
    worst: float
    """Largest demand over allowance."""
    pair: int
    values: np.ndarray


class _Search:
    """Evaluates values of wheels, and keeps what is best with each motor."""

    def __init__(self, request: StudyRequest, work: MachineWork, ranges: Mapping[str, tuple[float, float]]) -> None:
        """Look up the motors; none for a machine that a user pushes."""
        self.request, self.work, self.ranges = request, work, ranges
        self.asked, self.evaluated, self.rolled = asked_of(work), 0, 0
        self.blocked: dict[TaskDemand, int] = {}
        self.best: dict[int, _Found] = {}
        self.nearest: _Found | None = None
        machine, parts, self.side = work.machine, request.parts, None
        if getattr(machine, "motor", None) is not None:
            pairs = pairs_of(
                parts.motors_as(MOTOR),
                parts.gearheads,
                parts.pairs,
                loss_model=request.loss_model or machine.gearhead.loss_model,
                moving=False,
                stated=[aim for aim in request.aims if aim == "price"],
            )
            self.side = Side(name=MOTOR, found=pairs, amplifier=machine.amplifier)
            self.probe = replace(machine, motor=PROBE, gearhead=DIRECT)

    @property
    def pairs(self) -> Pairs | None:
        """Of motor and gearhead."""
        return None if self.side is None else self.side.found

    def made(self, values: np.ndarray, machine: Any = None) -> Any:
        """A machine with values in the order of the ranges."""
        own = self.work.machine if machine is None else machine
        return with_values(own, dict(zip(self.ranges, map(float, values), strict=True)))

    def value(self, values: np.ndarray) -> float:
        """What the search makes small: the power, or the price; of infeasible designs what they exceed."""
        self.evaluated += 1
        try:
            found = self._without_motor(values) if self.side is None else self._with_motor(self.side, values)
        except ParameterError:
            return _IMPOSSIBLE
        if self.nearest is None or found.worst < self.nearest.worst:
            self.nearest = found
        if not math.isfinite(found.power):
            return _INFEASIBLE * (2.0 - 1.0 / found.worst)
        known = self.best.get(found.pair)
        if known is None or found.power < known.power:
            self.best[found.pair] = found
        if self.request.aims[0] == "price":
            assert self.pairs is not None
            return float(self.pairs.price(np.array([found.pair]))[0])
        return found.power

    def _without_motor(self, values: np.ndarray) -> _Found:
        power, demands = self.work.judged(self.made(values))
        worst = self._worst(demands)
        return _Found(power if worst <= 1.0 else math.inf, worst, NOT_CHOSEN, values)

    def _worst(self, demands: Mapping[TaskDemand, float]) -> float:
        """Largest demand of the wheels; it counts which limit rules them out."""
        key = tightest_of(demands)
        worst = 0.0 if key is None else demands[key]
        if key is not None and worst > 1.0:
            self.blocked[key] = self.blocked.get(key, 0) + 1
        else:
            self.rolled += 1
        return worst

    def _with_motor(self, side: Side, values: np.ndarray) -> _Found:
        """The best pair behind the torque that shaft 1 needs; a motor without losses tells it."""
        machine, work = self.made(values, self.probe), self.work
        demands = {key: one for key, one in work.judged(machine)[1].items() if key[2] not in _OF_MOTOR}
        worst = self._worst(demands)
        if worst > 1.0:
            return _Found(math.inf, worst, NOT_CHOSEN, values)
        speed, torques, rest = float(machine.input_speed), [], 0.0
        for key, (point, _) in work.prepared.points(as_machine(machine)).items():
            torque = np.broadcast_to(point.states["motor_torque_Nm"], (work.sizes[key],))
            drawn = machine.amplifier.supply(motor_side(PROBE, DIRECT, output_torque=torque, output_speed=speed).power)[
                0
            ]
            # What a motor does not change, such as what a shaft at rest does not draw.
            others = np.broadcast_to(point.power_in - drawn, torque.shape)
            rest += work.shares[key] * float(np.mean(others) if work.lasts(key) else others[0])
            torques.append(torque)
        one, nothing = np.ones((1, 1)), np.empty((1, 0))
        shaft = Shaft(speed * one, np.concatenate(torques)[None], nothing, nothing, one, one, None, one)
        bounds = bounds_behind(side, self.asked, shaft, None)
        by_price = self.request.aims[0] == "price"
        behind = Behind(
            rows=side.rows,
            mass=side.found.price(side.rows) if by_price else side.found.mass(side.rows),
            power=np.sum([share * one.power for share, one in bounds], axis=0),
            worst=np.max([demand for _, one in bounds for demand in one.demands.values()], axis=0),
            evaluate=lambda rows, places: sampled_behind(side, rows, self.asked, shaft.of(places), None),
        )
        chosen = best_behind(behind, by_mass=by_price, prune=True)
        row = int(chosen.row[0])
        if row == NOT_CHOSEN:
            return _Found(math.inf, float(chosen.excess[0]), int(side.rows[np.argmin(behind.worst[:, 0])]), values)
        return _Found(rest + float(chosen.power[0]), worst, row, values)

    def design(self, found: _Found) -> SizedDrive:
        """What was found, judged by the machine itself."""
        machine, parts, unchecked, pairs = self.made(found.values), {}, [], self.pairs
        if pairs is not None and found.pair != NOT_CHOSEN:
            motor, gearhead = pairs.part(found.pair)
            machine = replace(machine, motor=motor, gearhead=gearhead)
            first, second = map(int, pairs.pairs[found.pair])
            parts = {
                MOTOR: self.request.parts.motor(MOTOR, first),
                "gearhead": self.request.parts.part("gearheads", second),
            }
            unchecked = [key for key in LIMIT_FIELDS if not pairs.stated(key, np.array([found.pair]))[0]]
        fields = quantities_of(machine)
        free = {
            path: FreeValue(value=float(value), low=math.nan, high=math.nan, unit=fields[path].metadata["unit"])
            for path, value in zip(self.ranges, found.values, strict=True)
        }
        return self.work.design(self.request.name, machine, parts, free, unchecked)


def rolling(request: StudyRequest, progress: Progress | None) -> Found:
    """Search over machines like a template: the best designs and the record.

    Source: storn1997.
    """
    from scipy.optimize import differential_evolution
    from scipy.stats import qmc

    work = MachineWork.of(request.study, request.name)
    ranges = _ranges(request)
    search, history = _Search(request, work, ranges), []
    low, high = np.log(np.array(list(ranges.values())).T)
    free = np.flatnonzero(high > low)
    own = np.log([value_at(work.machine, path) for path in ranges])
    start = np.clip(own, low, high)

    def objective(x: np.ndarray) -> float:
        at = start.copy()
        at[free] = x
        return search.value(np.exp(at))

    def said(intermediate_result: Any) -> None:
        best = float(intermediate_result.fun)
        history.append(best if best < _INFEASIBLE else math.inf)
        if progress is not None:
            words = f"best so far: {show(best, 'W', 3)}" if best < _INFEASIBLE else "no feasible design so far"
            progress(words, len(history) / request.generations)

    if search.side is not None and not search.side.rows.size:
        return Found([], [], _record(search, history, None))
    if len(free):
        random = np.random.default_rng(request.seed)
        first = low[free] + qmc.LatinHypercube(len(free), rng=random).random(_POPULATION) * (high - low)[free]
        first[0] = start[free]
        differential_evolution(
            objective,
            list(zip(low[free], high[free], strict=True)),
            init=first,
            maxiter=request.generations,
            tol=0.0,
            mutation=(0.4, 0.9),
            recombination=0.8,
            polish=False,
            rng=random,
            callback=said,
        )
    else:
        objective(start[free])
    designs = sorted(_feasible(search), key=request.order)[: request.top]
    nearest = None if designs or search.nearest is None else search.design(search.nearest)
    return Found(designs, [], _record(search, history, nearest))


def _feasible(search: _Search) -> Iterator[SizedDrive]:
    """Yield the best design with each motor."""
    for found in search.best.values():
        design = search.design(found)
        if not design.exceeded:
            yield design


def _ranges(request: StudyRequest) -> dict[str, tuple[float, float]]:
    """Range of each value: that stated by its last name, else half and twice the template's."""
    machine = request.template
    found, paths = {}, searched_values(machine)
    for name in request.ranges:
        if name not in {path.rpartition(".")[2] for path in paths}:
            raise InputError(
                f"ranges has an entry {name!r}, which drives.{request.name} does not have: {', '.join(paths)}"
            )
    for path in paths:
        value = float(value_at(machine, path))
        found[path] = request.ranges.get(path.rpartition(".")[2], (value / RANGE, value * RANGE))
    return found


def _record(search: _Search, history: list[float], nearest: SizedDrive | None) -> WheelRecord:
    pairs = search.pairs
    rows = np.empty(0, dtype=int) if pairs is None else pairs.usable
    return WheelRecord(
        candidates=1 if pairs is None else len(pairs.pairs),
        wheels=search.evaluated,
        rolled=search.rolled,
        drives=search.rolled * max(1, len(rows)),
        evaluated=search.rolled,
        excluded={} if pairs is None else pairs.excluded,
        blocked=dict(sorted(search.blocked.items(), key=lambda item: -item[1])),
        unchecked={}
        if pairs is None
        else {of: number for of in LIMIT_FIELDS if (number := int(np.sum(~pairs.stated(of, rows))))},
        ranges=search.ranges,
        steering_ratios=(),
        bearings=(),
        cylinder_bearings=(),
        numbers_of_wheels=(),
        cloud=np.empty((0, 2)),
        history=np.array(history),
        nearest=nearest,
    )
