"""Search over machines with legs on one cylinder, by the search over cobotic drives, for all legs together.

A wheel design is that of every leg. What it asks of the motor of the cylinder is the sum over the legs, and each leg has its own
steering motor, all of one kind.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from infinivar._core.pareto import spread_front
from infinivar.drivetrain.body import own_mass
from infinivar.drivetrain.masses import with_tube
from infinivar.limits import Limit
from infinivar.machines.kinds.linked import bodies_of_links
from infinivar.machines.links import rolled_legs
from infinivar.machines.many_legs import LeggedDrive
from infinivar.sizing.cobotic.bounds import (
    MOTOR,
    STEERING,
    MotorBounds,
    Side,
)
from infinivar.sizing.cobotic.evaluation import Evaluation
from infinivar.sizing.cobotic.evolution import Hunt, Record, Stage, fill_front, find_least, find_lightest
from infinivar.sizing.cobotic.sampled import SideSampled
from infinivar.sizing.cobotic.search import box_of, excluded_of, fast_enough, steered_pairs, unchecked_of
from infinivar.sizing.cobotic.space import Points, Space, heads_of
from infinivar.sizing.cobotic.wheels import Shaft, Wheels
from infinivar.sizing.design import (
    AXLE_BEARING,
    COBOTIC_PATHS,
    CYLINDER_BEARING,
    STEERING_MOTOR,
    STEERING_RATIO,
    UNITS,
    FreeValue,
    SizedDrive,
)
from infinivar.sizing.geared.candidates import LIMIT_FIELDS, pairs_of
from infinivar.sizing.machines.behind import Asked, asked_of, bounds_behind, sampled_behind
from infinivar.sizing.machines.work import MachineWork
from infinivar.sizing.margins import TaskDemand
from infinivar.sizing.of_cobotic import POPULATION, bearings_of, ratios_of
from infinivar.sizing.progress import Progress, part_of
from infinivar.sizing.records import WheelRecord
from infinivar.sizing.request import Found, StudyRequest
from infinivar.sizing.tables import CoboticRequest

_CYLINDER, _STEERED = "cylinder", "steered"


class Legs:
    """Wheel designs as those of all legs of a machine; see `infinivar.sizing.cobotic.evaluation.Rolls`."""

    def __init__(self, work: MachineWork, space: Space) -> None:
        """What each task and path asks of both motors."""
        self.work, self.space = work, space
        links, turned, steered = work.machine.links, asked_of(work), list[Asked]()
        for one in turned:
            row = one.columns[:, None] * links + np.arange(links)
            # On a path each leg is judged by its own root mean square; in a task all legs at once, and their powers add up.
            each = row.T if one.root_mean_square else [row.ravel()]
            share = one.share * (links if len(each) == 1 else 1)
            steered += [replace(one, share=share, columns=columns) for columns in each]
        self._asked = {MOTOR: (_CYLINDER, turned), STEERING: (_STEERED, steered)}

    def wheels(self, points: Points, tasks: Any) -> Wheels:
        """See `Rolls.wheels`."""
        found = [self._one(points.values[place], int(points.head[place])) for place in range(len(points.head))]
        keys = dict.fromkeys(key for demands, *_ in found for key in demands)
        return Wheels(
            demands={key: np.array([demands[key] for demands, *_ in found]) for key in keys},
            slipping=np.array([slipping for _, slipping, _ in found]),
            shafts={
                name: Shaft(
                    *(
                        None if some[0] is None else np.concatenate(some)
                        for some in zip(*(shafts[name] for *_, shafts in found), strict=True)
                    )  # type: ignore[arg-type]
                )
                for name in (_CYLINDER, _STEERED)
            },
        )

    def _one(self, values: np.ndarray, head: int) -> tuple[dict[TaskDemand, float], float, dict[str, Shaft]]:
        """Demands of a wheel design, share of its instants without steady rolling, and what the motors have to give."""
        work, leg = self.work, self.space.one(values, head)
        legs = LeggedDrive.of(leg, work.machine.links)
        rolled = rolled_legs(work.carried, legs, leg)
        demands: dict[TaskDemand, float] = {}
        worst = {**rolled.utilisation, Limit.SLIP: np.max(rolled.slip, axis=-1)}
        for key, place in work.places.items():
            for limit, demand in worst.items():
                most = float(np.max(demand[place]))
                demands[work.name_of(key), limit, "wheel"] = most if most == most else math.inf
        assert leg.steering is not None
        friction, angle = leg.steering.friction_torques(leg.transmission), rolled.legs.steering
        flat = [np.broadcast_to(row, rolled.shape).reshape(1, -1) for row in (angle.rate, angle.curvature)]
        moment = rolled.legs.patch_moment
        one = np.ones((1, 1))
        turning, nothing = leg.cylinder_speed * one, np.empty((1, 0))
        shafts = {
            _CYLINDER: Shaft(turning, rolled.torque[None], nothing, nothing, one, one, None, one),
            _STEERED: Shaft(
                turning,
                np.zeros_like(flat[0]),
                flat[0],
                flat[1],
                friction["patch"] * one,
                friction["bell"] * one,
                None if moment is None else np.broadcast_to(moment, rolled.shape).reshape(1, -1),
                leg.steering.inertia_of_bell * one,
            ),
        }
        return demands, float(np.mean(np.isnan(rolled.torque))), shafts

    def bounds(self, side: Side, shafts: Mapping[str, Shaft], tasks: Any) -> list[tuple[float, MotorBounds]]:
        """See `Rolls.bounds`."""
        name, every = self._asked[side.name]
        return bounds_behind(side, every, shafts[name], self.space.template.steering)

    def sample(
        self, side: Side, rows: np.ndarray, places: np.ndarray, shafts: Mapping[str, Shaft], tasks: Any
    ) -> SideSampled:
        """See `Rolls.sample`."""
        name, every = self._asked[side.name]
        return sampled_behind(side, rows, every, shafts[name].of(places), self.space.template.steering)

    def structure(self, points: Points) -> np.ndarray:
        """See `Rolls.structure`."""
        bodies = bodies_of_links(self.space.columns(points), self.work.machine.links, self.work.service)
        return np.broadcast_to(np.ravel(own_mass(bodies)), points.head.shape)


def legged(request: StudyRequest, progress: Progress | None) -> Found:
    """Search over machines like one with legs on a common cylinder: the best designs, the front and the record."""
    work = MachineWork.of(request.study, request.name, slip_margin=request.slip_margin)
    search = _Search(request, work)
    if not all(side.rows.size for side in search.evaluation.sides):
        return Found([], [], search.record(Record(search.box.heads), np.empty(0), None, ()))
    both = len(request.aims) > 1
    ends, histories = [], []
    for place, aim in enumerate(request.aims):
        said = part_of(progress, 0.35 * place, 0.35 * (place + 1)) if both else progress
        found, history = search.run(aim, said)
        ends.append(found)
        histories.append(history)
    known = ends[0]
    if both:
        for other in ends[1:]:
            known.merge(other)
        search.between(known, part_of(progress, 0.7, 0.95))
    designs = search.best(known, request.aims[0])
    front = search.front(known) if both else []
    nearest = None if designs else search.nearest(known)
    return Found(designs, front, search.record(known, histories[0], nearest, [*designs, *front]))


class _Search:
    """The search over wheels and motors of the legs of a machine."""

    def __init__(self, request: StudyRequest, work: MachineWork) -> None:
        """Look up the parts."""
        self.request, self.work = request, work
        leg, parts = work.machine.leg, request.parts
        self.lists = bearings_of(leg, parts)
        self.ratios = ratios_of(leg.steering.ratio, request)
        stated = tuple(aim for aim in request.aims if aim != "energy")
        own = CoboticRequest(
            template=replace(leg, gearhead=replace(leg.gearhead, stiffness=None, backlash=None)),
            motors=parts.motors_as(MOTOR),
            gearheads=parts.gearheads,
            pairs=parts.pairs,
            duty={},
            loss_model=request.loss_model,
            top=request.top,
            steering_motors=_several(parts.motors_as(STEERING_MOTOR), work.machine.links),
            steering_ratios=self.ratios,
            bearings=tuple(one for _, one in self.lists[AXLE_BEARING]),
            cylinder_bearings=tuple(one for _, one in self.lists.get(CYLINDER_BEARING, ())),
            wheels=(1,),
            ranges=request.ranges,
            slip_margin=request.slip_margin,
            seed=request.seed,
        )
        heads = heads_of(own.template, own.bearings, own.wheels, own.cylinder_bearings)
        self.box = box_of(own.template, own.ranges, heads)
        found = pairs_of(own.motors, own.gearheads, own.pairs, loss_model=own.gear_law, moving=False, stated=stated)
        steered = steered_pairs(own.steering_motors, own.steering_ratios, stated)
        self.space = Space(own.template, heads, work.service)
        self.singles = steered_pairs(parts.motors_as(STEERING_MOTOR), own.steering_ratios, stated)
        self.evaluation = Evaluation(
            self.space,
            [
                Side(name=MOTOR, found=fast_enough(found, self.box), amplifier=leg.amplifier),
                Side(name=STEERING, found=steered, amplifier=leg.steering_amplifier),
            ],
            (),
            own,
            Legs(work, self.space),
        )

    def run(self, aim: str, progress: Progress | None) -> tuple[Record, np.ndarray]:
        """Search by one objective, first for the steering motor, whose mass moves with the link, and then with that mass."""
        generations, seed = self.request.generations, self.request.seed
        search: Any = find_least if aim == "energy" else find_lightest
        record, histories = Record(self.box.heads), []
        for part, (begin, end) in ((_FIRST, (0.0, 0.3)), (1, (0.3, 1.0))):
            evaluation = self._evaluation(record, aim)
            hunt = Hunt(evaluation, self.box, POPULATION, self.request.top)
            stages = [Stage((), (), max(1, generations // part))]
            record, history = search(hunt, stages, seed, part_of(progress, begin, end))
            self.evaluation.count(*evaluation.counts)
            histories.append(history)
        return record, np.concatenate(histories)

    def between(self, known: Record, progress: Progress | None) -> None:
        """Search along the front between the ends that are known."""
        evaluation = self._evaluation(known, "energy")
        hunt = Hunt(evaluation, self.box, POPULATION, self.request.top)
        fill_front(hunt, Stage((), (), 1), known, self.request.generations, self.request.seed, progress)
        self.evaluation.count(*evaluation.counts)

    def _evaluation(self, known: Record, aim: str) -> Evaluation:
        """The evaluation for an objective, with links as heavy as with the steering motor of the best design known."""
        made = self.evaluation.anew(aim)  # type: ignore[arg-type]
        if known.best:
            _, _, steered = min(known.best, key=lambda key: (known.best[key].value, key))
            made.space = self.space.with_steering(self.singles.part(steered)[0])
            made.rolls = Legs(self.work, made.space)
        return made

    def best(self, known: Record, aim: str) -> list[SizedDrive]:
        """The best designs, each of other parts, that keep all limits."""
        ordered = sorted(
            known.best, key=lambda key: (getattr(known.best[key], "power" if aim == "energy" else "mass"), key)
        )
        entries = ((key, known.best[key]) for key in ordered)
        found: list[SizedDrive] = []
        for design in self._feasible(entries):
            found.append(design)
            if len(found) == self.request.top:
                break
        return sorted(found, key=self.request.order)

    def front(self, known: Record) -> list[SizedDrive]:
        """Designs of which no other has less power and less mass, by power."""
        found = [*self._feasible((key[0], known.light[key]) for key in known.front())]
        mass, power = (np.array([getattr(one, name) for one in found]) for name in ("mass", "power"))
        return [found[place] for place in spread_front(mass, power)] if found else []

    def _feasible(self, entries: Any) -> Iterator[SizedDrive]:
        """Yield designs that keep all limits, of those whose margins rounding and the mass of a motor may have changed."""
        for (pair, _, steered), entry in entries:
            design = self.design(entry.values, entry.head, pair, steered)
            if not design.exceeded:
                yield design

    def nearest(self, known: Record) -> SizedDrive | None:
        """The design nearest to keeping all limits."""
        if known.nearest is None:
            return None
        _, values, head = known.nearest
        evaluation, points = self.evaluation, Points(values[None], np.array([head]))
        wheels = evaluation.rolls.wheels(points, ())
        rows = [
            side.rows[0] if wheels.slipping[0] else evaluation.nearest(side, points, wheels)
            for side in evaluation.sides
        ]
        return self.design(values, head, *rows)

    def design(self, values: np.ndarray, head: int, pair: int, steered: int) -> SizedDrive:
        """A wheel design with its motors, judged by the machine itself."""
        request, parts, (turning, _) = self.request, self.request.parts, self.evaluation.sides
        motor, gearhead = turning.found.part(pair)
        steerer, gear = self.singles.part(steered)
        space = self.space.with_steering(steerer)
        leg = space.one(values, head)
        assert leg.steering is not None
        leg = replace(
            leg, motor=motor, gearhead=gearhead, steering=replace(leg.steering, motor=steerer, ratio=float(gear.ratio))
        )
        leg = with_tube(leg, self.work.service)
        axle, _, support = map(int, space.heads.places(head))
        free = dict(zip(COBOTIC_PATHS.values(), map(float, values), strict=True)) | {STEERING_RATIO: float(gear.ratio)}
        first, second = map(int, turning.found.pairs[pair])
        chosen = {
            MOTOR: parts.motor(MOTOR, first),
            "gearhead": parts.part("gearheads", second),
            STEERING_MOTOR: parts.motor(STEERING_MOTOR, int(self.singles.pairs[steered, 0])),
        }
        places = {AXLE_BEARING: axle, CYLINDER_BEARING: support}
        chosen |= {role: part for role, some in self.lists.items() if (part := some[places[role]][0]) is not None}
        unchecked = [key for key in LIMIT_FIELDS if not turning.found.stated(key, np.array([pair]))[0]]
        unchecked += [
            (limit, STEERING)
            for limit, part in LIMIT_FIELDS
            if part == MOTOR and not self.singles.stated((limit, part), np.array([steered]))[0]
        ]
        return self.work.design(
            request.name,
            replace(self.work.machine, leg=leg),
            {f"leg.{role}": part for role, part in chosen.items()},
            {
                f"leg.{path}": FreeValue(value=value, low=math.nan, high=math.nan, unit=UNITS[path])
                for path, value in free.items()
            },
            unchecked,
        )

    def record(
        self, known: Record, history: np.ndarray, nearest: SizedDrive | None, found: Sequence[SizedDrive]
    ) -> WheelRecord:
        """What became of the candidates."""
        evaluation, sides = self.evaluation, self.evaluation.sides
        names = {path: tuple(bearing.name for _, bearing in some) for path, some in self.lists.items()}
        ends = zip(COBOTIC_PATHS.values(), self.box.low, self.box.high, strict=True)
        return WheelRecord(
            candidates=math.prod(len(side.found.pairs) for side in sides) * len(self.box.heads),
            wheels=evaluation.wheels,
            rolled=evaluation.rolled,
            drives=evaluation.rolled * math.prod(len(side.rows) for side in sides),
            evaluated=evaluation.sampled,
            excluded=excluded_of(sides),
            blocked=dict(sorted(evaluation.blocked.items(), key=lambda item: -item[1])),
            unchecked=unchecked_of(sides),
            ranges={f"leg.{path}": (float(low), float(high)) for path, low, high in ends},
            steering_ratios=self.ratios,
            bearings=names[AXLE_BEARING],
            cylinder_bearings=names.get(CYLINDER_BEARING, ()),
            numbers_of_wheels=(1,),
            cloud=np.array([(one.mass, one.power) for one in known.light.values()]).reshape(-1, 2),
            history=history,
            nearest=nearest,
        )


_FIRST = 4
"""Of all generations, the part that a first search for the steering motor has, divided by this."""


def _several(motors: Mapping[str, np.ndarray], count: int) -> dict[str, np.ndarray]:
    """Motors that weigh and cost as much as so many of them."""
    return {name: count * column if name in ("mass", "price") else column for name, column in motors.items()}
