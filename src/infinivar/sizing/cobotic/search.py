"""Search for the best cobotic drive: parts of tables, and radii, cylinder speed and preload of ranges."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Literal, NamedTuple

import numpy as np

from infinivar._core.processes import apart, in_processes
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.drive import orders_of
from infinivar.drivetrain.masses import check_known
from infinivar.drivetrain.service import service_of
from infinivar.errors import ParameterError, require
from infinivar.limits import Demand, Limit
from infinivar.motion.duty_cycles import DutyCycle
from infinivar.parts.bearing import Bearing
from infinivar.parts.gearhead import LossModel
from infinivar.parts.structure.stock import StockTube
from infinivar.sizing.cobotic.bounds import MOTOR, STEERING, Side
from infinivar.sizing.cobotic.designs import best_designs, front_designs, nearest_design
from infinivar.sizing.cobotic.evaluation import Counts, Evaluation
from infinivar.sizing.cobotic.evolution import (
    Box,
    Hunt,
    Record,
    Stage,
    fill_front,
    find_least,
    find_lightest,
)
from infinivar.sizing.cobotic.space import FREE, Heads, Points, Space, heads_of, values_of
from infinivar.sizing.cobotic.wheels import CompiledWheels, check_template
from infinivar.sizing.found import CoboticDesign, CoboticSizing
from infinivar.sizing.geared.candidates import LIMIT_FIELDS, Pairs, pairs_of
from infinivar.sizing.geared.tasks import MotionTask, RegionTask, Task, judging_points, outer, tasks_of
from infinivar.sizing.progress import Progress, part_of
from infinivar.sizing.tables import CoboticRequest, Objective
from infinivar.study.requirement import Requirement
from infinivar.units import show_in

RANGE = 2.0
"""Values are searched from the template's divided by this to the template's times this, unless a range is given."""

_WEIGHTLESS = 1e-300
"""Mass of the steering gear, of which only the ratio is searched."""


def size_cobotic(
    template: CoboticDrive,
    motors: Mapping[str, Any],
    gearheads: Mapping[str, Any],
    pairs: Any,
    *,
    steering_motors: Mapping[str, Any],
    steering_ratios: Sequence[float],
    bearings: Sequence[Bearing],
    wheels: Sequence[int] = (),
    cylinder_bearings: Sequence[Bearing] = (),
    duty: Mapping[str, DutyCycle],
    requirement: Requirement | None = None,
    ranges: Mapping[str, tuple[float, float]] | None = None,
    objective: Objective = "energy",
    slip_margin: float = 1.0,
    life: float | None = None,
    travel: float | None = None,
    loss_model: LossModel | None = None,
    samples: int | None = None,
    population: int = 40,
    generations: int = 100,
    seed: int = 0,
    top: int = 20,
    first_samples: int = 100,
    prune: bool = True,
    method: Literal["numpy", "jax"] = "numpy",
    progress: Progress | None = None,
) -> CoboticSizing:
    """Find the best motors, gearhead, bearings, radii, cylinder speed and preload for a required region and motions.

    Parameters
    ----------
    template : CoboticDrive        Everything but what is searched; gearheads count as rigid.
    motors, gearheads : mapping    Columns by the names of the fields of `Motor` and `Gearhead`, in SI, nan where not stated. A
        limit that is not stated is not checked.
    pairs : (n, 2) int             Row of the motor and of the gearhead of each pair.
    steering_motors : mapping      As `motors`; every one is tried with every ratio.
    steering_ratios : sequence     Of the gear between steering motor and bell. [-]
    bearings : sequence            Of the axle.
    wheels : sequence              Numbers of wheels around the cylinder, of 1, 2 and 3; the template's by default.
    cylinder_bearings : sequence   Of the cylinder, instead of the part that the template states; that part by default.
    duty : mapping of DutyCycle    Motions by name; may be empty.
    requirement : Requirement      Required region; none by default.
    ranges : mapping               Least and largest cylinder_radius [m], cylinder_speed [rad s^-1], wheel_radius [m],
        crown_radius [m] and preload [N]; by default half and twice the template's. Equal ends fix a value.
    objective : str                energy: least mean power from the supply, over the motions by their shares of time, equal if
        none states one. mass: least mass of the whole drive. space: least volume of the box around it, with the motors that
        make it the lightest behind each wheel. price: least price of motors and gearhead, which all must state. front: energy
        and mass, and the least power at masses between.
    slip_margin : float            Slip force over lateral force that is wanted, at least 1. [-]
    life : float                   Wanted life of axle and cylinder bearings, at the loads of their friction; any by default. [s]
    travel, samples                As for `duty_cycle`.
    loss_model : str               coulomb, proportional or strain wave, of all gearheads; by default that of the template's.
    population, generations : int  Of differential evolution.
    seed : int                     The same seed gives the same result.
    top : int                      Number of designs to return, each of other parts.
    first_samples : int            Instants of a motion, at most, at which most generations are evaluated; the last tenth, and all
        designs returned, are evaluated at all instants. A required region is searched at points of its edge; the
        designs returned keep all limits at its whole edge and on a grid inside.
    prune : bool                   Whether bounds spare motors that cannot be feasible or best behind a wheel the evaluation at
        every instant. The result is the same without, only later.
    method : str                   numpy, or jax, which compiles for some ten seconds and is then faster.
    progress : callable            Called with words on the best value so far and the share of work done, 0 to 1.

    Returns
    -------
    CoboticSizing   Empty of designs if none that was found is feasible.

    Raises
    ------
    ParameterError
        If an argument is out of range or does not fit the others.

    Source: storn1997.
    """
    request = CoboticRequest(
        template=template,
        motors=motors,
        gearheads=gearheads,
        pairs=pairs,
        steering_motors=steering_motors,
        steering_ratios=tuple(steering_ratios),
        bearings=tuple(bearings),
        wheels=tuple(wheels),
        cylinder_bearings=tuple(cylinder_bearings),
        duty=duty,
        requirement=requirement,
        ranges=ranges or {},
        objective=objective,
        slip_margin=slip_margin,
        life=life,
        travel=travel,
        loss_model=loss_model,
        samples=samples,
        population=population,
        generations=generations,
        seed=seed,
        top=top,
        first_samples=first_samples,
        prune=prune,
        method=method,
    )
    return best_cobotic(request, progress)


def best_cobotic(request: CoboticRequest, progress: Progress | None = None) -> CoboticSizing:
    """Find the best drives; see `size_cobotic`."""
    evaluation, box = prepared(request)
    if request.method == "jax":
        evaluation.space.compiled = CompiledWheels(evaluation.space)
    sides = evaluation.sides
    whole = [judging_points(task) if isinstance(task, RegionTask) else task for task in evaluation.tasks]
    stages = _stages(request, whole)
    hunt = Hunt(evaluation, box, request.population, request.top)
    if not all(side.rows.size for side in sides):
        record, history, designs = Record(box.heads), np.empty(0), ()
    elif request.objective == "front":
        record, history, designs = _front(hunt, stages, whole, request.seed, progress)
    else:
        search = find_lightest if request.objective == "mass" else find_least
        record, history = search(hunt, stages, request.seed, progress)
        designs = best_designs(evaluation, record, whole, request.top)
    kept = np.array([(one.mass, one.power) for one in record.light.values()]).reshape(-1, 2)
    return CoboticSizing(
        objective=request.objective,
        designs=designs,
        front=front_designs(evaluation, record, whole),
        wheels=evaluation.wheels,
        rolled=evaluation.rolled,
        drives=evaluation.rolled * math.prod(len(side.rows) for side in sides),
        sampled=evaluation.sampled,
        excluded=excluded_of(sides),
        blocked=evaluation.blocked,
        history=history,
        cloud=kept if request.moving else np.empty((0, 2)),
        candidates=Searched(evaluation.space, sides, box).candidates,
        unchecked=unchecked_of(sides),
        nearest=None if designs else nearest_design(evaluation, record, whole),
    )


def _front(
    hunt: Hunt, stages: Sequence[Stage], whole: Sequence[Task], seed: int, progress: Progress | None
) -> tuple[Record, np.ndarray, tuple[CoboticDesign, ...]]:
    """Search for the least power, the least mass and what is between: the designs of the first two, and all in one record."""
    evaluation, top = hunt.evaluation, hunt.top
    together = evaluation.space.compiled is None and in_processes()
    if progress is not None and together:
        progress("searching for the least power and the least mass", 0.1)
    search = functools.partial(_end, hunt, stages, seed, None if together else progress)
    ends = (apart if together else map)(search, ("energy", "mass"))
    (record, history, counted), (light, _, more) = ends
    evaluation.count(*counted)
    evaluation.count(*more)
    evaluation.objective = "mass"
    lightest = best_designs(evaluation, light, whole, top)
    record.merge(light)
    evaluation.objective = "energy"
    rounds = 3 * sum(one.generations for one in stages) // 2
    fill_front(hunt, stages[-1], record, rounds, seed, part_of(progress, 0.6, 1.0))
    return record, history, (*best_designs(evaluation, record.by_power(), whole, top), *lightest)


def _end(
    hunt: Hunt, stages: Sequence[Stage], seed: int, progress: Progress | None, objective: Objective
) -> tuple[Record, np.ndarray, Counts]:
    """An end of the front, by what is made small there: record, history, and how many designs were evaluated."""
    evaluation = hunt.evaluation.anew(objective)
    hunt = hunt._replace(evaluation=evaluation)
    if objective == "energy":
        record, history = find_least(hunt, stages, seed, part_of(progress, 0.0, 0.4))
    else:
        record, history = find_lightest(hunt, [one.shorter(2) for one in stages], seed, part_of(progress, 0.4, 0.6))
    return record, history, evaluation.counts


def _stages(request: CoboticRequest, whole: Sequence[Task]) -> list[Stage]:
    """Most generations at few instants, the last ones at all; of a required region the outer points."""
    generations, most = request.generations, request.first_samples
    edge = [outer(task) if isinstance(task, RegionTask) else task for task in whole]
    few = [_thinned(request.template, task, most) if isinstance(task, MotionTask) else task for task in edge]
    last = max(1, generations // 10)
    if all(one is other for one, other in zip(edge, few, strict=True)) or last == generations:
        return [Stage(edge, edge, generations)]
    return [Stage(few, edge, generations - last), Stage(edge, edge, last)]


def _thinned(template: CoboticDrive, task: MotionTask, most: int) -> MotionTask:
    """A motion at fewer instants."""
    if len(task.instants.time) <= most:
        return task
    return replace(task, instants=task.duty.instants(most, orders_of(template)))


def excluded_of(sides: Sequence[Side]) -> dict[str, int]:
    """Parts without the values that a law needs, and those that no wheel design can use, by reason."""
    return {
        f"{side.name}: {reason.removeprefix('motor ')}": number
        for side in sides
        for reason, number in side.found.excluded.items()
    }


def unchecked_of(sides: Sequence[Side]) -> dict[Demand, int]:
    """Candidates whose data sheets do not state a limit; of steering motors each once."""
    found: dict[Demand, int] = {}
    for side in sides:
        rows = side.rows if side.name == MOTOR else _first_of_each(side.found.pairs[side.rows, 0], side.rows)
        for limit, part in LIMIT_FIELDS:
            if side.name == MOTOR or part == MOTOR:
                missing = int(np.sum(~side.found.stated((limit, part), rows)))
                if missing:
                    found[limit, part if side.name == MOTOR else side.name] = missing
    return found


def _first_of_each(motors: np.ndarray, rows: np.ndarray) -> np.ndarray:
    return rows[np.unique(motors, return_index=True)[1]]


def prepared(request: CoboticRequest) -> tuple[Evaluation, Box]:
    """What evaluates wheel designs, and where they are searched; errors as for `size_cobotic`."""
    request.check_motions()
    check_template(request.template, request.moving)
    searched = searched_of(request)
    tasks = tasks_of(searched.space.template, request.duty, request.requirement, request.travel, request.samples)
    if request.weighed:
        check_known(searched.space.template, searched.space.service)
    return Evaluation(searched.space, searched.sides, tasks, request), searched.box


class Searched(NamedTuple):
    """What is searched: wheel designs, and motors behind them."""

    space: Space
    sides: Sequence[Side]
    box: Box

    @property
    def candidates(self) -> int:
        """Combinations of parts, also those without the values that a law needs."""
        return math.prod(len(side.found.pairs) for side in self.sides) * len(self.box.heads)


def searched_of(request: CoboticRequest) -> Searched:
    """What is searched for a template that was checked; errors as for `size_cobotic`."""
    own, stated = request.template, request.stated
    template = replace(own, gearhead=replace(own.gearhead, stiffness=None, backlash=None))
    box = box_of(
        template, request.ranges, heads_of(template, request.bearings, request.wheels, request.cylinder_bearings)
    )
    found = pairs_of(
        request.motors, request.gearheads, request.pairs, loss_model=request.gear_law, moving=False, stated=stated
    )
    sides = [Side(name=MOTOR, found=fast_enough(found, box), amplifier=template.amplifier)]
    if request.moving:
        steered = steered_pairs(request.steering_motors, request.steering_ratios, stated)
        sides.append(Side(name=STEERING, found=steered, amplifier=template.steering_amplifier))
    service = service_of(template, request.duty, request.requirement, request.travel)
    return Searched(Space(template, box.heads, service), sides, box)


def steered_pairs(motors: Mapping[str, Any], ratios: Sequence[float], stated: Sequence[str]) -> Pairs:
    """Steering motors, each with every ratio of a gear that the law counts as lossless."""
    count, gears = len(next(iter(motors.values()), ())), len(ratios)
    if not gears:
        raise ParameterError("steering_ratios is empty: state at least one ratio between steering motor and bell")
    table = {"ratio": list(ratios), "efficiency": [1.0] * gears, "mass": [_WEIGHTLESS] * gears, "price": [0.0] * gears}
    grid = np.stack(np.meshgrid(np.arange(count), np.arange(gears), indexing="ij"), axis=-1).reshape(-1, 2)
    return pairs_of(motors, table, grid, loss_model="coulomb", moving=True, stated=stated)


def box_of(template: CoboticDrive, ranges: Mapping[str, tuple[float, float]], heads: Heads) -> Box:
    """Ranges of the continuous values, and the heads."""
    unknown = set(ranges) - set(FREE)
    if unknown:
        raise ParameterError(f"ranges has an unknown entry {min(unknown)!r}; known entries: {', '.join(FREE)}")
    searched = ranges_of(template, ranges, heads.wheels)
    for name, (low, high) in searched.items():
        require(0.0 < low <= high < np.inf, f"ranges[{name!r}]", (low, high), "a range above 0, least first")
    low, high = np.array(list(searched.values())).T
    return Box(low, high, heads, Points(values_of(template)[None], np.array([_own_head(template, heads)])))


def _own_head(template: CoboticDrive, heads: Heads) -> int:
    """Where a search begins: the template's wheels and cylinder bearing if they are tried, and an axle bearing of middle rank."""
    support = template.cylinder_bearings
    own = None, template.transmission.wheels, None if support is None else support.bearing
    middle = (int(order[(len(order) - 1) // 2]) for order in heads.orders)
    return int(
        heads.at(
            [some.index(one) if one in some else rank for some, one, rank in zip(heads.lists, own, middle, strict=True)]
        )
    )


def ranges_of(
    template: CoboticDrive, ranges: Mapping[str, tuple[float, float]], wheels: Sequence[int]
) -> dict[str, tuple[float, float]]:
    """Least and largest of each free value: those stated, others around the template's.

    Several wheels share what its preload has to hold, so that of each is searched down to that part of it.
    """
    own = zip(FREE, values_of(template).tolist(), strict=True)
    found = {name: (value / RANGE, value * RANGE) for name, value in own}
    low, high = found["preload"]
    most = max([1, *wheels]) / template.transmission.wheels
    if template.transmission.cylinder_tube is not None:
        found["cylinder_radius"] = _turned(template.transmission.cylinder_tube, ranges.get("cylinder_radius"))
    return {**found, "preload": (low / max(most, 1.0), high), **ranges}


def _turned(tube: StockTube, stated: tuple[float, float] | None) -> tuple[float, float]:
    """Range of radii to which a tube from stock can be turned down; a range that is stated must be within it. [m]"""
    least, largest = tube.radii
    if stated is not None and not least <= stated[0] <= stated[1] <= largest:
        ends = " to ".join(show_in(one, "m", "mm") for one in (least, largest))
        got = " to ".join(show_in(one, "m", "mm") for one in stated)
        raise ParameterError(
            f"ranges['cylinder_radius'] must be within {ends}, to which cylinder_tube can be turned, got {got}"
        )
    return least, largest


def fast_enough(found: Pairs, box: Box) -> Pairs:
    """Pairs whose motor and gearhead permit the slowest cylinder; a faster one turns them faster."""
    slowest, kept, excluded = box.low[FREE.index("cylinder_speed")], found.usable, dict(found.excluded)
    for limit in (Limit.SPEED, Limit.GEAR_SPEED):
        turned = slowest * found.values("gearhead", "ratio", kept)
        beyond = turned > found.allowance(limit, kept) * (1.0 + 1e-9)
        if beyond.any():
            excluded[f"{limit.words} below that of the slowest cylinder"] = int(beyond.sum())
        kept = kept[~beyond]
    return replace(found, usable=kept, excluded=excluded)
