"""Search over cobotic drives: against the public analyses of single drives, brute force and itself without pruning."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

import infinivar as iv
from infinivar import Limit, ParameterError
from internals import AXLE_LIMIT as AXLE
from internals import CONTACT_LIMIT as CONTACT
from internals import FREE_LIMIT as FREE
from internals import MOTOR_BOUND as MOTOR
from internals import (
    NOT_FEASIBLE,
    REQUIREMENT,
    Behind,
    CoboticRequest,
    MotionTask,
    RegionTask,
    SearchSpace,
    SideSampled,
    best_behind,
    cylinder_signals,
    judging_points,
    lower_bounds,
    size_cobotic,
    static_demands,
    steering_signals,
)
from internals import WheelPoints as Points
from internals import cobotic_least_power as least_power
from internals import cobotic_sample as sample
from internals import critical_wheels as critical
from internals import evaluate_wheels as evaluate
from internals import outer_region as outer
from internals import prepared_search as prepared
from internals import wheel_values as values_of
from made import loaded
from part_tables import part_tables
from sampled import sampled

KNEE = loaded("knee_walking")
SPIN = KNEE.drives["cobotic"]
SHEAR = replace(SPIN, transmission=replace(SPIN.transmission, steering_model="shear", steering_range=1.2))
NO_RETURN = replace(
    SPIN, amplifier=iv.parts.Amplifier(regeneration="store", storage_efficiency=0.6, efficiency=0.9, standby_power=0.3)
)
SHAKE = iv.DutyCycle(motion=iv.motion.Sinusoid(distance=0.04, frequency=1.5), load_mass=1.5, force=-20.0)
REGION = iv.Requirement(force=120.0, speed=0.3, power=16.0, quadrants=4)
SAMPLES = 120
AXLES = tuple(
    replace(SPIN.transmission.geometry.axle_bearing, name=name, bore=bore, dynamic_rating=dynamic, static_rating=static)
    for name, bore, dynamic, static in (
        ("6000", 0.010, 4750.0, 1960.0),
        ("6001", 0.012, 5400.0, 2360.0),
        ("small", 0.008, 3450.0, 1370.0),
    )
)
HELD = (SPIN.cylinder_bearings.bearing, replace(SPIN.cylinder_bearings.bearing, bore=0.012, static_rating=2400.0))


def run_of_knee():
    """A run that ends before anything has settled."""
    time = np.linspace(0.0, 3.0, 61)
    recording = iv.motion.Recording(
        file="log", time=time, position=0.05 * np.sin(2.0 * time), force=-60.0 * np.cos(3.0 * time), closed=False
    )
    return iv.DutyCycle(motion=recording, load_mass=1.0, start_temperature=320.0)


def parts(seed=1, motors=6, gearheads=5):
    """Motors, gearheads for slow cylinders, and all pairs."""
    found, gears, pairs = part_tables(seed, motors, gearheads)
    gears = {
        **gears,
        "ratio": np.linspace(25.0, 80.0, gearheads),
        "continuous_torque": 4.0 * gears["continuous_torque"],
        "intermittent_torque": 4.0 * gears["intermittent_torque"],
    }
    return found, gears, pairs


def problem(template=SPIN, duty=None, requirement=None, loss_model="coulomb", seed=1, **options):
    """Evaluation of wheel designs, and their box."""
    motors, gears, pairs = parts(seed)
    request = CoboticRequest(
        template=template,
        motors=motors,
        gearheads=gears,
        pairs=pairs,
        steering_motors=part_tables(seed + 1, 4)[0],
        steering_ratios=(8.0, 16.0, 40.0),
        bearings=AXLES,
        wheels=(1, 2, 3),
        cylinder_bearings=HELD,
        duty={"walk": KNEE.duty["walking"]} if duty is None else duty,
        requirement=requirement,
        loss_model=loss_model,
        travel=0.2,
        samples=SAMPLES,
        **{"ranges": {}, "life": 3.6e6, **options},
    )
    return prepared(request)


def some_points(box, count, seed, spread=0.35, wheels=None):
    """Wheel designs around the template, with any heads, or heads of one kind."""
    random = np.random.default_rng(seed)
    values = box.own.values * np.exp(random.uniform(-spread, spread, (count, len(FREE))))
    heads = np.array([place for place in range(len(box.heads)) if wheels in (None, box.heads[place].wheels)])
    return Points(values, random.choice(heads, count))


def single(evaluation, points, place, pair, steered):
    """One design as a drive of plain numbers."""
    drive = evaluation.space.one(points.values[place], int(points.head[place]))
    drive = replace(drive, link_mass=drive.mass_of_link)  # as in the search, with the steering motor of the template
    motor, gearhead = evaluation.sides[0].found.part(int(pair))
    turning, gear = evaluation.sides[1].found.part(int(steered))
    steering = replace(drive.steering, motor=turning, ratio=gear.ratio)
    return replace(drive, motor=motor, gearhead=gearhead, steering=steering)


@pytest.mark.parametrize("wheels", [1, 3])
@pytest.mark.parametrize("places", [[4, 0, 5], [2], [], [False, True, False, False, True, True]], ids=str)
def test_some_of_many_drives_are_as_if_made_alone(wheels, places):
    """Laws computed when a drive is made are taken over with its rows, not computed again: the same to the last digit."""
    evaluation, box = problem(requirement=REGION)
    points, places = some_points(box, 6, seed=5, wheels=wheels), np.array(places, dtype=type((places or [0])[0]))
    taken = evaluation.space.built(points).of(places)
    alone = points.of(places)
    assert alone.drive is None
    assert taken.drive is not None
    if not len(taken.head):
        assert np.shape(taken.drive.transmission.preload) == (0, 1)
        return
    own, again = (evaluate(evaluation.space, one, evaluation.tasks, life=3.6e6) for one in (taken, alone))
    assert own.demands.keys() == again.demands.keys()
    for key, demand in own.demands.items():
        np.testing.assert_array_equal(demand, again.demands[key])
    statics = static_demands(taken.drive), static_demands(evaluation.space.columns(alone))
    for key, demand in statics[0].items():
        np.testing.assert_array_equal(demand, statics[1][key])
    np.testing.assert_array_equal(evaluation.space.structure(taken), evaluation.space.structure(alone))


@sampled(
    ("template", "loss_model", "wheels"),
    [(SPIN, "coulomb", 2), (SHEAR, "proportional", 1), (NO_RETURN, "proportional", 3)],
    slow=3,
    ids=["spin", "shear", "store"],
)
def test_demands_are_those_of_duty_cycle_and_compare(template, loss_model, wheels):
    """Every demand and the power of random designs, computed many at once, against the public analyses one by one."""
    duty = {"walk": KNEE.duty["walking"], "shake": SHAKE, "run": run_of_knee()}
    evaluation, box = problem(template, duty, REGION, loss_model)
    points = some_points(box, 6, seed=3, wheels=wheels)
    random = np.random.default_rng(4)
    rows = [random.choice(side.rows, len(points.head)) for side in evaluation.sides]
    columns = evaluation.space.columns(points)
    rolled = evaluate(evaluation.space, points, evaluation.tasks, life=3.6e6)
    places = np.arange(len(points.head))
    done = [
        sample(side, row, places, evaluation.tasks, rolled.shafts, evaluation.shares, template.steering)
        for side, row in zip(evaluation.sides, rows, strict=True)
    ]
    static = static_demands(columns)
    seen, rolling = set(), 0
    for place in places:
        drive = single(evaluation, points, place, rows[0][place], rows[1][place])
        total = {
            key: values[place]
            for group in (static, rolled.demands, *(one.demands for one in done))
            for key, values in group.items()
        }
        for limit, expected in drive.transmission.utilisation.items():
            part = {Limit.BEARING: AXLE, Limit.CLEARANCE: AXLE, Limit.AXLE: "axle"}.get(limit, "wheel")
            assert total[CONTACT, limit, part] == pytest.approx(expected, rel=1e-9)
        power, slips = 0.0, False
        for task in evaluation.tasks:
            if isinstance(task, MotionTask):
                cycle = iv.duty_cycle(drive, task.duty, samples=SAMPLES, travel=0.2)
                power += evaluation.shares[task.name] * cycle.power_in
                found = dict(cycle.demands)
                found |= {
                    (Limit.TEMPERATURE, part): heat.demand for part, heat in cycle.heat.items() if heat is not None
                }
                slips |= math.isnan(cycle.power_in)
            else:
                speed, force, _ = REGION.sample()
                found = {}
                for limit, demand in drive.operate(speed=speed, force=force).utilisation.items():
                    part = next(key[2] for key in total if key[:2] == (REQUIREMENT, limit))
                    found[limit, part] = float(np.max(demand))
            for key, expected in found.items():
                if math.isfinite(expected):
                    assert total[task.name, *key] == pytest.approx(expected, rel=1e-9, abs=1e-12), (task.name, key)
                    seen.add(key)
        assert slips == bool(rolled.slipping[place] > 0.0)
        if not slips:
            rolling += 1
            assert sum(one.power[place] for one in done) == pytest.approx(power, rel=1e-9)
    assert rolling >= 2
    assert {limit for limit, part in seen if part == MOTOR} >= {
        Limit.THERMAL,
        Limit.PEAK,
        Limit.VOLTAGE,
        Limit.SPEED,
        Limit.TEMPERATURE,
    }
    assert {part for _, part in seen} >= {"wheel", "gearhead", "steering motor", "load"}


@sampled(
    ("template", "loss_model"),
    [(SPIN, "coulomb"), (NO_RETURN, "proportional")],
    slow=2,
    ids=["burn", "store"],
)
def test_bounds_are_below_the_truth(template, loss_model):
    """Lower bounds of every demand and of the power, of all candidates behind random wheels, and how near they come."""
    duty = {"walk": KNEE.duty["walking"], "run": run_of_knee()}
    evaluation, box = problem(template, duty, REGION, loss_model)
    points = some_points(box, 8, seed=5, spread=0.15, wheels=1)
    wheels = evaluate(evaluation.space, points, evaluation.tasks, life=None)
    able = np.flatnonzero(wheels.slipping == 0.0)
    assert able.size >= 3
    shafts = {name: shaft.of(able) for name, shaft in wheels.shafts.items()}
    near = []
    for side in evaluation.sides:
        rows, places = (part.ravel() for part in np.meshgrid(side.rows, np.arange(len(able)), indexing="ij"))
        for task in evaluation.tasks:
            if side.name != MOTOR and not isinstance(task, MotionTask):
                continue
            done = sample(side, rows, places, [task], shafts, {task.name: 1.0}, template.steering)
            signals = (
                cylinder_signals(task, shafts[task.name])
                if side.name == MOTOR
                else steering_signals(template.steering, shafts[task.name])
            )
            bounds = lower_bounds(side, task, signals)
            for key, bound in bounds.demands.items():
                true = done.demands.get((task.name, *key))
                if true is None:
                    assert key[0] in (Limit.TEMPERATURE, Limit.THERMAL)
                    continue
                applies = true >= 0.0
                assert np.all(bound.ravel()[applies] <= true[applies] * (1.0 + 1e-9)), (task.name, key)
                near.append(float(np.median(bound.ravel()[applies] / true[applies])))
            if isinstance(task, MotionTask):
                assert np.all(bounds.power.ravel() <= done.power * (1.0 + 1e-9) + 1e-12)
                near.append(float(np.median(bounds.power.ravel() / done.power)))
    assert np.median(near) > 0.95
    assert min(near) > 0.4


def test_life_wanted_against_the_turns_of_the_wheel():
    """The wheel turns with the rolling speed of the kinematics, under the loads at which its friction is computed."""
    evaluation, box = problem(life=7.2e6)
    points = some_points(box, 3, seed=9, spread=0.05)
    points = points._replace(head=box.heads.at(([0, 1, 2], [1, 1, 1], [0, 1, 0])))
    wheels = evaluate(evaluation.space, points, evaluation.tasks, life=7.2e6)
    for place in range(3):
        drive = evaluation.space.one(points.values[place], int(points.head[place]))
        element = drive.transmission
        cycle = iv.duty_cycle(drive, KNEE.duty["walking"], samples=SAMPLES)
        angle = np.arctan(cycle.point.states["steering_tangent"])
        surface = element.cylinder_radius * drive.cylinder_speed
        rolling = np.abs(cycle.instants.course.speed * np.sin(angle) - surface * np.cos(angle))
        turns = np.mean(rolling) / element.wheel_radius / (2.0 * np.pi) * 7.2e6
        lateral = element.geometry.lateral_share * element.wheel.slip_force
        reached = element.geometry.axle.life(element.preload, lateral, element.wheel_radius)
        expected = (turns / float(reached)) ** (1.0 / 3.0)
        assert wheels.demands["walk", Limit.LIFE, AXLE][place] == pytest.approx(expected, rel=1e-6)
        # Of the cylinder: each instant wears for its share of the turns, and both bearings must last.
        course = cycle.instants.course
        rolled = drive.roll(course, load_mass=KNEE.duty["walking"].moved_mass)
        loads = drive.held(rolled.wheel_torque, rolled.force, course.position)
        bearing, turns = drive.cylinder_bearings.bearing, drive.cylinder_speed / (2.0 * np.pi) * 7.2e6
        worn = [np.mean(turns / bearing.life(*np.broadcast_arrays(*one))) for one in loads]
        together = (worn[0] ** (10.0 / 9.0) + worn[1] ** (10.0 / 9.0)) ** (0.9 / 3.0)
        assert wheels.demands["walk", Limit.LIFE, "cylinder bearing"][place] == pytest.approx(together, rel=1e-6)


def some_candidates(seed, count=40, size=60):
    """Random bounds far below random truths, with ties: candidates, their demands and their powers."""
    random = np.random.default_rng(seed)
    power = random.integers(1, 30, (size, count)) * 1.0
    demand = random.uniform(0.5, 1.6, (size, count))
    demand[:, :5] += 1.0

    def evaluate_some(tried, places):
        at = tried - 100, places
        return SideSampled({("task", Limit.PEAK, "motor"): demand[at]}, power[at], demand[at] <= 1.0)

    behind = Behind(
        rows=np.arange(100, 100 + size),
        mass=random.integers(1, 30, size) * 0.125,  # sums are exact
        power=power * random.uniform(0.3, 1.0, power.shape),
        worst=demand * random.uniform(0.6, 1.0, power.shape),
        evaluate=evaluate_some,
    )
    return behind, demand, power


@pytest.mark.parametrize("by_mass", [False, True])
def test_the_order_of_bounds_ends_the_choice_only_when_nothing_can_be_better(by_mass):
    """The same choice as by looking at every candidate."""
    behind, demand, power = some_candidates(10)
    found = best_behind(behind, by_mass=by_mass, prune=True)
    whole = best_behind(behind, by_mass=by_mass, prune=False)
    value = np.where(demand <= 1.0, behind.mass[:, None] if by_mass else power, np.inf)
    np.testing.assert_array_equal(found.value, value.min(axis=0))
    np.testing.assert_array_equal(found.row, np.where(np.isfinite(found.value), 100 + value.argmin(axis=0), -1))
    for one, other in zip(found[:4], whole[:4], strict=True):
        np.testing.assert_array_equal(one, other)
    assert np.all(found.excess[:5] > 1.0)
    assert found.evaluated < 0.7 * whole.evaluated == 0.7 * power.size


def test_blocks_of_wheel_designs_are_chosen_for_as_together(monkeypatch):
    """Motors of a few wheel designs at a time, on threads, are those of all at once."""
    (evaluation, box), seen = problem(duty={"shake": SHAKE}), []
    points = some_points(box, 40, seed=8, spread=0.2)
    for block in (1000, 3):
        monkeypatch.setattr("infinivar.sizing.cobotic.evaluation._BLOCK", block)
        evaluation.sampled = 0
        seen.append((*evaluation.values(points), evaluation.sampled))
    for one, other in zip(*seen, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-13)
    assert np.sum(seen[0][0] < NOT_FEASIBLE) > 5


def test_the_first_generation_has_the_template_and_the_designs_that_are_known():
    _, box = problem()
    space = SearchSpace(box)
    known = some_points(box, 5, seed=3, spread=0.1)
    first = space.start(12, 4, known)
    own = space.points(first[:1].T)
    np.testing.assert_allclose(own.values, box.own.values)
    np.testing.assert_array_equal(own.head, box.own.head)
    np.testing.assert_allclose(space.points(first[1:6].T).values, known.values, rtol=1e-12)
    np.testing.assert_array_equal(space.points(first[1:6].T).head, known.head)
    np.testing.assert_allclose(first[6:], space.start(12, 4, None)[6:])


def test_values_of_infeasible_designs_lead_towards_feasible_ones():
    """A preload that damages the wheel ranks behind all that let it slip; in both, the further off, the worse."""
    evaluation, box = problem()
    place = FREE.index("preload")
    values = np.repeat(box.own.values, 8, axis=0)
    values[:, place] *= np.array([0.1, 0.25, 0.5, 1.0, 20.0, 60.0, 200.0, 600.0])
    found = evaluation.values(Points(values, np.zeros(8, dtype=int))).value
    slipping, broken = found[:3], found[4:]
    assert found[3] < NOT_FEASIBLE <= slipping[-1]
    assert np.all(np.diff(slipping) < 0.0)
    assert np.all(np.diff(broken) > 0.0)
    assert np.max(slipping) < np.min(broken)


@pytest.mark.parametrize("heaviest", [0.125, 0.25, 0.5, 1.5, 3.0, 10.0])
def test_the_least_power_under_a_mass_is_that_of_all_combinations(heaviest):
    """Both motors together, against the table of all their sums."""
    one, demand, power = some_candidates(11)
    other, demands, powers = some_candidates(12, size=25)
    total = np.where(demand <= 1.0, power, np.inf)[:, None] + np.where(demands <= 1.0, powers, np.inf)[None]
    mass = one.mass[:, None] + other.mass[None]
    total = np.where((mass <= heaviest)[:, :, None], total, np.inf).reshape(-1, 40)
    evaluated = []
    for prune in (True, False):
        found = least_power(one, other, heaviest, prune=prune)
        np.testing.assert_array_equal(found.power, total.min(axis=0))
        feasible = np.isfinite(found.power)
        first, second, designs = (
            found.cylinder[feasible] - 100,
            found.steering[feasible] - 100,
            np.flatnonzero(feasible),
        )
        assert np.all(demand[first, designs] <= 1.0)
        assert np.all(demands[second, designs] <= 1.0)
        np.testing.assert_array_equal(power[first, designs] + powers[second, designs], found.power[feasible])
        np.testing.assert_array_equal(one.mass[first] + other.mass[second], found.mass[feasible])
        assert np.all(found.mass[feasible] <= heaviest)
        assert np.all(found.excess[feasible] == 1.0)
        assert np.all(found.excess[~feasible] > 1.0)
        assert np.all(found.cylinder[~feasible] == -1)
        assert np.all(found.steering[~feasible] == -1)
        evaluated.append(found.evaluated)
    assert evaluated[0] <= evaluated[1]
    assert feasible.any() == (heaviest >= 0.25)


def test_pairs_left_out_are_too_fast_for_the_slowest_cylinder():
    """A pair is left out if, and only if, motor or gearhead is too fast at the least cylinder speed of the range."""
    evaluation, box = problem(ranges={"cylinder_speed": (15.0, 30.0)})
    found, rows = evaluation.sides[0].found, np.arange(30)
    turned = box.low[1] * found.values("gearhead", "ratio", rows)
    limits = found.values("motor", "max_speed", rows), found.values("gearhead", "max_input_speed", rows)
    fast = np.any([turned > limit for limit in limits], axis=0)
    assert 0 < fast.sum() < 30
    np.testing.assert_array_equal(found.usable, np.flatnonzero(~fast))
    assert sum(found.excluded.values()) == fast.sum()


@pytest.mark.full
def test_critical_instants_are_instants_of_the_motion():
    """A wheel that slips in the first look slips in the whole motion, with the same demand or a larger one."""
    evaluation, box = problem(duty={"walk": KNEE.duty["walking"], "shake": SHAKE}, requirement=REGION)
    points = some_points(box, 16, seed=6, spread=0.6, wheels=1)
    first = evaluate(evaluation.space, points, critical(evaluation.space.template, evaluation.tasks), life=None)
    whole = evaluate(evaluation.space, points, evaluation.tasks, life=None)
    for key, demand in first.demands.items():
        assert np.all(demand <= whole.demands[key] * (1.0 + 1e-9))
    slips = whole.slipping > 0.0
    assert 0 < slips.sum() < len(slips)
    assert np.mean(first.slipping[slips] > 0.0) > 0.9


@pytest.mark.parametrize("objective", ["energy", pytest.param("mass", marks=pytest.mark.slow)])
def test_pruning_changes_nothing(objective):
    """Values, and the motors chosen, of random wheel designs with bounds and by evaluation of every candidate."""
    found = []
    for prune in (True, False):
        evaluation, box = problem(objective=objective, prune=prune)
        points = some_points(box, 30, seed=7, spread=0.25)
        found.append((evaluation.values(points), evaluation.sampled))
    (one, few), (other, many) = found
    np.testing.assert_allclose(one.value, other.value, rtol=1e-12)
    np.testing.assert_array_equal(one.pair, other.pair)
    np.testing.assert_array_equal(one.steering, other.steering)
    assert 3 <= np.sum(one.value < NOT_FEASIBLE) < 30
    assert few < 0.4 * many


def small_search(**options):
    """A search over a small catalogue."""
    motors, gears, pairs = parts()
    usual = {"duty": {"walk": KNEE.duty["walking"]}, "samples": 60, "population": 16, "generations": 8}
    return size_cobotic(
        SPIN,
        motors,
        gears,
        pairs,
        steering_motors=part_tables(2, 3)[0],
        steering_ratios=(8.0, 16.0),
        bearings=AXLES,
        **{"wheels": (1, 2), "cylinder_bearings": HELD, **usual, **options},
    )


@pytest.mark.full
def test_a_search_is_repeatable_and_its_designs_are_those_of_the_public_analyses():
    """The same seed gives the same designs with and without pruning; the best is feasible in `duty_cycle`."""
    one, other, unpruned = small_search(), small_search(), small_search(prune=False, generations=8)
    for found in (other, unpruned):
        assert [
            (design.pair, design.bearing, design.wheels, design.steering, design.ratio) for design in found.designs
        ] == [(design.pair, design.bearing, design.wheels, design.steering, design.ratio) for design in one.designs]
        assert [design.values for design in found.designs] == [design.values for design in one.designs]
    assert one.sampled < 0.5 * unpruned.sampled
    best = one.best
    cycle = iv.duty_cycle(best.drive, KNEE.duty["walking"], samples=60)
    assert cycle.feasible
    assert cycle.power_in == pytest.approx(best.power, rel=1e-9)
    assert best.margin >= 1.0
    assert best.demands["walk", Limit.SLIP, "wheel"] == pytest.approx(cycle.demands[Limit.SLIP, "wheel"], rel=1e-9)
    assert all(two <= one for one, two in itertools.pairwise(one.history))
    # In the search the link carries the template's steering motor, in its designs their own.
    assert one.history[-1] == pytest.approx(best.power, rel=5e-3)
    assert one.front[0].power <= best.power * (1.0 + 1e-12)
    for two, three in itertools.pairwise(one.front):
        assert three.mass < two.mass
        assert three.power > two.power
    assert len(
        {(design.pair, design.bearing, design.wheels, design.steering, design.ratio) for design in one.designs}
    ) == len(one.designs)


def test_the_edge_of_a_region_is_beyond_all_its_points():
    """No point of any quadrant is beyond the edge, which has the corners; designs are judged at all of the edge and inside."""
    speed, force, _ = REGION.sample()
    task = RegionTask(speed=speed, force=force)
    few, most = outer(task), judging_points(task)
    assert len(few.speed) <= 4 * 60 < len(most.speed) < 0.1 * len(speed)
    corners = {(a * v, b * f) for v, f in ((0.3, 16.0 / 0.3), (16.0 / 120.0, 120.0)) for a in (-1, 1) for b in (-1, 1)}
    for one in (few, most):
        found = set(zip(one.speed.round(9).tolist(), one.force.round(9).tolist(), strict=True))
        assert {(round(v, 9), round(f, 9)) for v, f in corners} <= found
    whole = {(v, f) for v, f in zip(most.speed, most.force, strict=True)}
    assert {(v, f) for v, f in zip(few.speed, few.force, strict=True)} <= whole
    random = np.random.default_rng(0)
    for place in random.integers(0, len(speed), 300):
        same = (np.sign(most.speed) == np.sign(speed[place])) & (np.signbit(most.force) == np.signbit(force[place]))
        beyond = (np.abs(most.speed) >= np.abs(speed[place])) & (np.abs(most.force) >= np.abs(force[place]))
        assert np.any(same & beyond)


@pytest.mark.slow
def test_a_required_region_alone():
    """Without motions the lightest cylinder motor and gearhead are searched, and `compare` finds the region covered."""
    found = small_search(duty={}, objective="mass", requirement=REGION, population=8, generations=2).best
    assert found.steering == -1
    assert math.isnan(found.power)
    speed, force, _ = REGION.sample()
    point = found.drive.operate(speed=speed, force=force)
    assert all(np.max(demand) <= 1.0 + 1e-9 for demand in point.utilisation.values())


@pytest.mark.slow
def test_jax_gives_the_same_numbers():
    """Values of wheel designs by compiled laws, of bearings in columns and alone."""
    pytest.importorskip("jax")
    from internals import CompiledWheels

    evaluation, box = problem()
    points = some_points(box, 70, seed=8, spread=0.2)
    one = evaluation.values(points)
    evaluation.space.compiled = CompiledWheels(evaluation.space)
    other = evaluation.values(points)
    np.testing.assert_allclose(other.value, one.value, rtol=1e-9)
    np.testing.assert_array_equal(other.pair, one.pair)
    assert np.sum(one.value < NOT_FEASIBLE) > 5


@pytest.mark.full
def test_the_lightest_design_and_margins_wanted():
    """The least mass is no larger than that of the least energy; wanted margins are kept."""
    lightest = small_search(objective="mass", generations=12)
    assert lightest.best.mass <= small_search().best.mass
    wary = small_search(slip_margin=1.3, life=3.6e7, generations=12).best
    assert wary is not None
    cycle = iv.duty_cycle(wary.drive, KNEE.duty["walking"], samples=60)
    assert cycle.demands[Limit.SLIP, "wheel"] * 1.3 <= 1.0 + 1e-9
    assert wary.demands["walk", Limit.LIFE, AXLE] <= 1.0


@pytest.mark.full
def test_brute_force_finds_nothing_better():
    """A grid over cylinder speed and preload with every part of a small catalogue, evaluated one and all."""
    ranges = {name: (value, value) for name, value in zip(FREE, (0.08, 0.0, 0.035, 0.02, 0.0), strict=True)}
    ranges |= {"cylinder_speed": (6.0, 20.0), "preload": (1000.0, 3000.0)}
    options = {"ranges": ranges, "population": 24, "generations": 40}
    found = small_search(**options).best
    motors, gears, pairs = parts()
    request = CoboticRequest(
        template=SPIN,
        motors=motors,
        gearheads=gears,
        pairs=pairs,
        steering_motors=part_tables(2, 3)[0],
        steering_ratios=(8.0, 16.0),
        bearings=AXLES,
        wheels=(1, 2),
        cylinder_bearings=HELD,
        duty={"walk": KNEE.duty["walking"]},
        ranges=ranges,
        loss_model="coulomb",
        samples=60,
        prune=False,
    )
    evaluation, _ = prepared(request)
    speed, preload, head = (
        part.ravel() for part in np.meshgrid(np.geomspace(6.0, 20.0, 25), np.geomspace(1000.0, 3000.0, 31), range(12))
    )
    values = np.stack(
        [np.full_like(speed, 0.08), speed, np.full_like(speed, 0.035), np.full_like(speed, 0.02), preload], axis=-1
    )
    grid = evaluation.values(Points(values, head.astype(int)))
    best = grid.value.min()
    assert best < NOT_FEASIBLE
    assert found.power <= best * (1.0 + 1e-9)
    assert found.power >= 0.9 * best


@pytest.mark.slow
def test_the_front_has_both_ends_and_all_between():
    """The designs of both searches by one objective, none of the front beaten, and the same again."""
    front = small_search(objective="front", duty={"shake": SHAKE}, generations=6, population=8)
    energy = small_search(objective="energy", duty={"shake": SHAKE}, generations=6, population=8)
    values = np.array([(one.mass, one.power) for one in front.front])
    assert len(values) >= 3
    assert front.front[0].power <= energy.best.power
    lightest = min(front.designs, key=lambda one: one.mass)
    assert front.front[-1].mass <= lightest.mass
    assert np.all(np.diff(values[:, 0]) < 0.0)
    assert np.all(np.diff(values[:, 1]) > 0.0)
    for one in front.front[:: len(values) // 2]:
        cycle = iv.duty_cycle(one.drive, SHAKE, samples=60)
        assert cycle.feasible
        assert cycle.power_in == pytest.approx(one.power, rel=1e-9)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"objective": "power"}, "objective must be energy, mass, space, price or front"),
        ({"slip_margin": 0.5}, "slip_margin must be >= 1"),
        ({"slip_margin": math.inf}, "slip_margin must be >= 1 and finite"),
        ({"ranges": {"radius": (1.0, 2.0)}}, "ranges has an unknown entry 'radius'"),
        ({"ranges": {"preload": (0.0, 2.0)}}, "ranges\\['preload'\\] must be a range above 0"),
        ({"population": 2}, "population must be a whole number >= 5"),
        ({"life": -1.0}, "life must be > 0"),
    ],
)
def test_bad_arguments_are_named(options, words):
    """One message that names the argument."""
    with pytest.raises(ParameterError, match=words):
        small_search(**options)


@pytest.mark.full
def test_a_first_look_at_few_instants_ends_with_designs_of_all_instants():
    """Most generations at few instants: the designs returned are those of all instants, and about as good."""
    alone = {"samples": 400, "generations": 12, "wheels": (1,), "cylinder_bearings": ()}
    whole, quick = (small_search(first_samples=count, **alone) for count in (400, 80))
    best = quick.best
    cycle = iv.duty_cycle(best.drive, KNEE.duty["walking"], samples=400)
    assert cycle.feasible
    assert cycle.power_in == pytest.approx(best.power, rel=1e-9)
    assert best.power == pytest.approx(whole.best.power, rel=0.02)
    assert abs(len(quick.history) - len(whole.history)) <= 1  # shares of the generations, rounded


@pytest.mark.full
def test_starts_whose_designs_become_one_end_early():
    """The only free value has two per cent of room: one start ends before the others."""
    own = dict(zip(FREE, values_of(SPIN), strict=True))
    ranges = {name: (value, value) for name, value in own.items()}
    ranges["cylinder_speed"] = (0.98 * own["cylinder_speed"], 1.02 * own["cylinder_speed"])
    found = small_search(samples=20, generations=60, population=5, ranges=ranges)
    assert len(found.history) < 20 + 60
    assert all(two <= one for one, two in itertools.pairwise(found.history))


@pytest.mark.full
def test_two_seeds_find_the_same_lightest_drive():
    """Masses of motors change in steps, on which a search sees no way on: it goes on among the lighter ones."""
    study = iv.load_study("hand_controller")
    found = [iv.size(study, objective="mass", sets="shipped", drive="cobotic", seed=seed, top=1) for seed in (0, 1)]
    assert found[0].best.mass == pytest.approx(found[1].best.mass, rel=0.02)
    assert {one.best.parts["motor"].key for one in found} == {"dcx-22-s-24v"}
