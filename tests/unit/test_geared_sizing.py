"""Search over geared drives: against the public analyses of single drives, brute force and itself without pruning."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import infinivar as iv
from infinivar import Limit
from infinivar.parts import Guideway, Pulley, Screw
from internals import HOT_GEARED as HOT
from internals import (
    REQUIREMENT,
    Laurent,
    Radii,
    RegionTask,
    Resting,
    candidates,
    closed_forms,
    load_of,
    mean_square_below,
    own_mass,
    region_points,
    service_of,
    size_geared,
    tasks_of,
)
from internals import SPARE_WARMTH as SPARE
from internals import UNCHECKED_GEARED as UNCHECKED
from internals import geared_least_power as least_power
from internals import geared_limits as limits
from internals import geared_sample as sample
from internals import radius_below as below
from made import loaded
from part_tables import part_tables
from sampled import sampled

ROOT = Path(__file__).parents[2]
KNEE = loaded("knee_walking")
ANKLE = loaded("ankle_walking")
PULLEY = KNEE.drives["geared"]
HEAVY_PULLEY = replace(PULLEY, pulley=Pulley(radius=0.008, friction_torque=0.02), output_inertia=3e-5)
SHAKE = iv.DutyCycle(motion=iv.motion.Sinusoid(distance=0.06, frequency=2.0), load_mass=1.5, force=-20.0)
REACH = iv.DutyCycle(motion=iv.motion.Reaches(distance=0.2, time=0.6, pause=1.5), load_mass=0.8, force=-25.0)
"""Holds at rest under load for most of the time."""
HOLD = iv.DutyCycle(motion=iv.motion.Hold(time=2.0), force=-70.0)
REGION = iv.Requirement(force=120.0, speed=0.3, power=16.0, quadrants=4)
SAMPLES = 200


def run_of_knee():
    """A run that ends before anything has settled."""
    time = np.linspace(0.0, 3.0, 61)
    recording = iv.motion.Recording(
        file="log", time=time, position=0.05 * np.sin(2.0 * time), force=-60.0 * np.cos(3.0 * time), closed=False
    )
    return iv.DutyCycle(motion=recording, load_mass=1.0, start_temperature=320.0)


def brake():
    """A load that drives all the time: the voltage falls as the winding warms up."""
    time = np.linspace(0.0, 1.0, 101)
    turn = 2.0 * np.pi * time
    return iv.DutyCycle(
        motion=iv.motion.Recording(
            file="log", time=time, position=0.05 * np.sin(turn), force=120.0 * np.cos(turn), cutoff=8.0
        )
    )


def judged(template, tables, duty, requirement=None, loss_model="coulomb", samples=SAMPLES):
    motors, gearheads, pairs = tables
    found = candidates(template, motors, gearheads, pairs, loss_model=loss_model, moving=bool(duty), stated=())
    return found, tasks_of(template, duty, requirement, travel=None, samples=samples)


def one_by_one(found, stage, tasks, rows):
    """Demands and power of single drives by the public analyses."""
    demands, power, feasible = {}, {}, []
    for row in rows:
        drive, able = found.drive(int(row), stage), True
        for task in tasks:
            if isinstance(task, RegionTask):
                speed, force, _ = REGION.sample(41)
                utilisation = drive.operate(speed=speed, force=force).utilisation
                here = {(limit, None): float(np.max(demand)) for limit, demand in utilisation.items()}
                able &= all(demand <= 1.0 for demand in here.values())
            else:
                cycle = iv.duty_cycle(drive, task.duty, samples=len(task.instants.time))
                here = dict(cycle.demands)
                if cycle.heat["motor"] is not None:
                    here[Limit.TEMPERATURE, "motor"] = cycle.heat["motor"].demand
                power.setdefault(task.name, []).append(cycle.power_in)
                able &= cycle.feasible
            for (limit, part), demand in here.items():
                demands[task.name, limit, part, int(row)] = demand
        feasible.append(able)
    return demands, power, feasible


@pytest.mark.slow
@sampled("loss_model", ["coulomb", "proportional"], every=2)
@pytest.mark.parametrize("template", [PULLEY, HEAVY_PULLEY], ids=["light", "heavy"])
def test_demands_are_those_of_duty_cycle_and_steady_map(template, loss_model):
    """Every limit of random candidates, sampled and in closed form, against the public analyses of single drives."""
    duty = {
        "walk": KNEE.duty["walking"],
        "shake": SHAKE,
        "reach": REACH,
        "run": run_of_knee(),
        "hold": HOLD,
        "brake": brake(),
    }
    found, tasks = judged(template, part_tables(1), duty, REGION, loss_model)
    rows = np.random.default_rng(2).permutation(found.usable)[:8]
    found = replace(found, usable=rows)
    stage = template.stage
    judging = [task.critical(template, stage) if isinstance(task, RegionTask) else task for task in tasks]
    done = sample(found, rows, judging, stage)
    demands, power, feasible = one_by_one(found, stage, tasks, rows)
    assert list(done.feasible) == feasible
    for name, values in power.items():
        np.testing.assert_allclose(done.power[name], values, rtol=1e-9)
    seen = set()
    for (name, limit, part), values in done.demands.items():
        for place, row in enumerate(rows):
            expected = demands.get((name, limit, None if name == REQUIREMENT else part, int(row)))
            if expected is None:
                stated = found.stated((limit, part), rows[place : place + 1])[0]
                assert not stated or values[place] == UNCHECKED
            elif math.isfinite(expected):
                assert values[place] == pytest.approx(expected, rel=1e-9), (name, limit)
                seen.add((name, limit))
    assert {limit for _, limit in seen} >= {
        Limit.THERMAL,
        Limit.PEAK,
        Limit.VOLTAGE,
        Limit.SPEED,
        Limit.GEAR,
        Limit.GEAR_PEAK,
        Limit.GEAR_SPEED,
        Limit.TEMPERATURE,
    }
    exact = warm = 0
    for task in judging:
        heated = found.stated((Limit.TEMPERATURE, "motor"), rows) & (task.name != REQUIREMENT)
        for (limit, part), values in closed_forms(found, task, stage):
            sampled = done.demands[task.name, limit, part]
            applies = sampled >= 0.0
            assert np.all(values[applies] <= sampled[applies] * (1.0 + 1e-9)), (task.name, limit)
            if limit == Limit.TEMPERATURE:
                warm += int(np.sum(values[applies] > 0.5 * sampled[applies]))
                continue
            cold = applies & ~heated
            np.testing.assert_allclose(values[cold], sampled[cold], rtol=1e-9, err_msg=f"{task.name} {limit}")
            exact += int(cold.sum())
    assert exact > 50
    assert warm > 5


@sampled("loss_model", ["coulomb", "proportional"], every=2)
@pytest.mark.parametrize("duty", [SHAKE, REACH], ids=["shake", "reach"])
def test_bound_of_the_winding_temperature_is_tight_where_the_resistance_hardly_changes(duty, loss_model):
    """Windings that are cooled well, and slow, so that they stay at their mean: the bound is then all but the demand."""
    motors, gearheads, pairs = part_tables(4, thermal=1.0)
    ones = np.ones(len(motors["mass"]))
    motors |= {
        "winding_to_housing": 2e-3 * motors["winding_to_housing"],
        "housing_to_ambient": 2e-3 * motors["housing_to_ambient"],
        "max_winding_temperature": (duty.ambient + 0.5) * ones,
        "winding_time_constant": 500.0 * ones,
        "housing_time_constant": 5000.0 * ones,
        "no_load_current": 3.0 * motors["no_load_current"],
    }
    found, tasks = judged(PULLEY, (motors, gearheads, pairs), {"work": duty}, loss_model=loss_model)
    done = sample(found, found.usable, tasks, PULLEY.stage)
    (bound,) = (one for key, one in closed_forms(found, tasks[0], PULLEY.stage) if key == HOT)
    evaluated = done.demands[tasks[0].name, *HOT]
    mild = evaluated < 2.0
    assert np.sum(mild) > 10
    # 1 K is 0.4 % of the resistance.
    np.testing.assert_allclose((1.0 + SPARE) * bound[mild], evaluated[mild], rtol=0.005)


@pytest.mark.parametrize("name", ["geared", "geared-series", "geared-parallel"])
def test_screws_behind_linkages_and_springs(name):
    """Stages with efficiencies, a crank and springs: demands of several leads as `duty_cycle` finds them."""
    template = ANKLE.drives[name]
    duty = ANKLE.duty
    found, tasks = judged(template, part_tables(4), duty)
    rows = found.usable[::29]
    found = replace(found, usable=rows)
    for lead in (0.002, 0.006):
        stage = replace(template.screw, lead=lead)
        done = sample(found, rows, tasks, stage)
        demands, power, _ = one_by_one(found, stage, tasks, rows)
        np.testing.assert_allclose(done.power["walking"], power["walking"], rtol=1e-9)
        for (task, limit, part), values in done.demands.items():
            for place, row in enumerate(rows):
                expected = demands.get((task, limit, part, int(row)))
                if expected is not None and math.isfinite(expected):
                    assert values[place] == pytest.approx(expected, rel=1e-9), limit
        heated = found.stated((Limit.TEMPERATURE, "motor"), rows)
        for (limit, part), values in closed_forms(found, tasks[0], stage):
            sampled = done.demands["walking", limit, part]
            if limit != Limit.TEMPERATURE:
                np.testing.assert_allclose(values[~heated], sampled[~heated], rtol=1e-9, err_msg=str(limit))


@sampled("loss_model", ["coulomb", "proportional"], every=2)
def test_pruning_changes_nothing_at_given_stages(loss_model):
    """The same feasible set, energy of each and winners; counts that add up."""
    stages = [Pulley(radius=radius, friction_torque=0.005) for radius in (0.006, 0.009, 0.014)]
    tables = part_tables(7, motors=14, gearheads=12)
    options = {"duty": {"reach": REACH}, "stages": stages, "loss_model": loss_model, "samples": SAMPLES}
    pruned = size_geared(PULLEY, *tables, **options)
    whole = size_geared(PULLEY, *tables, prune=False, **options)
    np.testing.assert_array_equal(pruned.feasible, whole.feasible)
    assert 10 < pruned.feasible.sum() < pruned.evaluated.sum() < whole.evaluated.sum() == pruned.candidates
    np.testing.assert_array_equal(pruned.power[pruned.feasible], whole.power[pruned.feasible])
    assert [(one.pair, one.stage) for one in pruned.designs] == [(one.pair, one.stage) for one in whole.designs]
    best = pruned.designs[0]
    assert best.power == np.min(whole.power[whole.feasible])
    cycle = iv.duty_cycle(best.drive, REACH, samples=SAMPLES)
    assert cycle.feasible
    assert cycle.power_in == pytest.approx(best.power, rel=1e-12)
    assert cycle.tightest[1] == pytest.approx(best.margin, rel=1e-9)
    # Each candidate is excluded by one limit first, or feasible.
    assert sum(count.first for count in pruned.counts) + pruned.feasible.sum() == pruned.candidates
    assert all(count.first <= count.exceeded <= count.checked for count in pruned.counts)
    for count in whole.counts:
        stated = np.sum(~np.isnan(tables[0]["max_winding_temperature"])) / len(tables[0]["voltage"])
        if count.limit == Limit.TEMPERATURE:
            assert count.checked == pytest.approx(stated * whole.candidates)


def test_the_lightest_first():
    tables = part_tables(8, motors=14, gearheads=12)
    found = size_geared(PULLEY, *tables, duty={}, requirement=REGION, travel=0.08, objective="mass")
    masses = [one.mass for one in found.designs]
    assert masses == sorted(masses)
    able = np.flatnonzero(found.feasible[0])
    motors, gearheads, pairs = tables
    structure = own_mass(PULLEY.bodies(service_of(PULLEY, {}, REGION, 0.08)))
    assert 0.01 < structure < 0.3
    mass = motors["mass"][pairs[able, 0]] + gearheads["mass"][pairs[able, 1]] + structure
    assert masses[0] == mass.min()
    assert len(able) > 3
    assert math.isnan(found.best.power)
    for one in found.designs[:3]:
        speed, force, _ = REGION.sample()
        point = one.drive.operate(speed=speed, force=force)
        worst = max(float(np.max(demand)) for demand in point.utilisation.values())
        assert 1.0 / worst == pytest.approx(one.margin, rel=1e-12)


def brute_force(found, tasks, radii):
    """Feasibility and mean power of every pair at every radius."""
    rows = np.repeat(found.usable, len(radii))
    every = np.tile(radii, len(found.usable))
    pulley = found.template.pulley
    done = sample(found, rows, tasks, lambda places: replace(pulley, radius=every[places][:, None]))
    shape = len(found.usable), len(radii)
    drawn = sum(done.power.values()) / max(len(done.power), 1) if done.power else np.zeros(len(rows))
    return done.feasible.reshape(shape), np.reshape(drawn, shape)


SEARCHES = {
    f"{objective}-{weight}-{loss_model}": (objective, template, loss_model)
    for objective in ("energy", "mass")
    for weight, template in (("light", PULLEY), ("heavy", HEAVY_PULLEY))
    for loss_model in ("coulomb", "proportional")
}


@sampled("name", SEARCHES, slow=8)
def test_brute_force_over_radii_finds_nothing_better(name):
    """A dense grid of radii for every pair of a small catalogue, against the search with and without pruning."""
    objective, template, loss_model = SEARCHES[name]
    tables = part_tables(11, motors=6, gearheads=6, thermal=0.5)
    duty = {"reach": REACH, "shake": SHAKE}
    region = None
    if name != "mass-light-coulomb":
        duty["run"], region = run_of_knee(), iv.Requirement(force=60.0, speed=0.3, power=8.0, quadrants=4)
    options = {"duty": duty, "requirement": region, "radius": (0.003, 0.03), "loss_model": loss_model, "samples": 60}
    options["objective"] = objective
    pruned = size_geared(template, *tables, top=5, **options)
    whole = size_geared(template, *tables, top=5, prune=False, **options)
    assert [one.pair for one in pruned.designs] == [one.pair for one in whole.designs]
    assert pruned.best.stage.radius == pytest.approx(whole.best.stage.radius, rel=1e-3)
    assert pruned.evaluated.sum() < whole.evaluated.sum()
    found, tasks = judged(template, tables, duty, region, loss_model, samples=60)
    found = replace(found, service=service_of(template, duty, region))  # which the pulley's shaft has to carry
    tasks = [region_points(task, template) if isinstance(task, RegionTask) else task for task in tasks]
    radii = np.geomspace(0.003, 0.03, 120)
    feasible, power = brute_force(found, tasks, radii)
    assert feasible.any(axis=1).sum() >= 4
    # No pair with a feasible radius is lost, and none of these radii is left out.
    able = feasible.any(axis=1)
    assert np.all(pruned.feasible[0][found.usable][able])
    low, high = pruned.radii[found.usable].T
    assert np.all((low[:, None] <= radii) & (radii <= high[:, None]) | ~feasible)
    rows = np.repeat(found.usable, len(radii))
    every = np.tile(radii, len(found.usable))[:, None]
    whole_mass = found.measure("mass", rows, replace(template.pulley, radius=every))
    value = np.where(feasible, power if objective == "energy" else np.reshape(whole_mass, feasible.shape), np.inf)
    best = np.sort(value.min(axis=1))[: len(pruned.designs)]
    assert len(best) == min(5, able.sum())
    ours = [one.power if objective == "energy" else one.mass for one in pruned.designs]
    assert np.all(ours <= best * (1.0 + 1e-9))
    for one in pruned.designs:
        place = int(np.searchsorted(found.usable, one.pair))
        inside = (radii >= one.radii[0]) & (radii <= one.radii[1])
        assert np.all(feasible[place] == inside)
        if objective == "mass":
            assert one.stage.radius == pytest.approx(one.radii[0], rel=1e-9)


@sampled("loss_model", ["coulomb", "proportional"], every=2)
def test_radii_by_closed_forms_are_those_of_a_dense_grid(loss_model):
    """Limit by limit: exact without thermal data, for constant gear friction or a pulley without friction and inertia."""
    tables = part_tables(13, motors=6, gearheads=5, thermal=0.0, gaps=0.0)
    template = PULLEY if loss_model == "proportional" else HEAVY_PULLEY
    if loss_model == "proportional":
        template = replace(template, output_inertia=None)
    duty = {"walk": KNEE.duty["walking"], "reach": REACH, "hold": HOLD}
    found, tasks = judged(template, tables, duty, REGION, loss_model, samples=60)
    tasks = [region_points(task, template) if isinstance(task, RegionTask) else task for task in tasks]
    radii = np.geomspace(0.002, 0.06, 150)
    rows = np.repeat(found.usable, len(radii))
    every = np.tile(radii, len(found.usable))
    done = sample(found, rows, tasks, lambda places: replace(template.pulley, radius=every[places][:, None]))
    cut = 0
    for task in tasks:
        for (limit, part), bounds in limits(found, load_of(found, task, (0.002, 0.06)), found.usable):
            kept = done.demands[task.name, limit, part].reshape(-1, len(radii)) <= 1.0
            inside = (bounds.low[:, None] <= radii) & (radii <= bounds.high[:, None])
            np.testing.assert_array_equal(kept, inside, err_msg=f"{task.name} {limit}")
            cut += int(np.sum(kept.any(axis=1) & ~kept.all(axis=1)))
    assert cut > 50


@sampled("free", [False, True], slow=2, ids=["stages", "radius"])
def test_the_front_of_mass_and_power(free):
    """All designs that no other beats, by comparing each with each; pruning leaves none out."""
    tables = part_tables(44, motors=14, gearheads=8, thermal=0.5)
    where = {"radius": (0.004, 0.02)} if free else {"stages": [Pulley(radius=one) for one in (0.006, 0.009)]}
    options = {"duty": {"reach": REACH}, "samples": 60, "objective": "front", **where}
    pruned, whole = (size_geared(PULLEY, *tables, prune=prune, **options) for prune in (True, False))
    found = [[(one.pair, one.mass, one.power) for one in result.designs] for result in (pruned, whole)]
    assert [one[0] for one in found[0]] == [one[0] for one in found[1]]
    assert pruned.evaluated.sum() < whole.evaluated.sum()
    motors, gearheads, pairs = tables
    mass = np.broadcast_to(motors["mass"][pairs[:, 0]] + gearheads["mass"][pairs[:, 1]], whole.power.shape)
    service = service_of(PULLEY, options["duty"])
    if free:  # a pulley of the best radius, which the designs state
        mass = np.where(np.isfinite(whole.mass), whole.mass, mass)
    else:
        own = [own_mass(replace(PULLEY, pulley=stage).bodies(service)) for stage in where["stages"]]
        mass = mass + np.array(own)[:, None]
    able = whole.feasible & np.isfinite(whole.power)
    values = np.stack([mass[able], whole.power[able]], axis=-1)
    beaten = [np.any(np.all(values <= one, axis=1) & np.any(values < one, axis=1)) for one in values]
    front = sorted(map(tuple, values[~np.array(beaten)]), key=lambda one: one[1])
    assert len(front) > 3
    ours = np.array([one[1:] for one in found[0]])
    if not free:
        np.testing.assert_allclose(ours, front, rtol=1e-12)
        return
    # Ours has each pair at smaller radii as well, and lists designs that are 3 % of their mass apart.
    assert len(ours) > len(front)
    for one in front:
        assert np.any(np.all(ours <= np.array(one) * [1.0 / 0.97, 1.0 + 1e-5], axis=1))
    for one in ours:
        assert not np.any(np.all(values < one * (1.0 - 1e-5), axis=1))


def test_no_radius_is_lost_where_the_direction_of_power_depends_on_it():
    """Much inertia and friction at the pulley, and a lossy gear: the intervals contain every radius of a dense grid."""
    tables = part_tables(29, motors=6, gearheads=5, thermal=0.0, gaps=0.0)
    tables[1]["efficiency"][:], tables[1]["backdriving_efficiency"][:] = 0.5, 0.1
    template = replace(PULLEY, pulley=Pulley(radius=0.008, friction_torque=0.2), output_inertia=2e-3)
    found, tasks = judged(template, tables, {"shake": SHAKE, "brake": brake()}, None, "proportional", 60)
    radii = np.geomspace(0.004, 0.06, 100)
    rows, every = np.repeat(found.usable, len(radii)), np.tile(radii, len(found.usable))
    done = sample(found, rows, tasks, lambda places: replace(template.pulley, radius=every[places][:, None]))
    unsure, cut = 0, 0
    for task in tasks:
        load = load_of(found, task, (0.004, 0.06))
        unsure += int(np.sum(~load.drives & ~load.brakes))
        for (limit, part), bounds in limits(found, load, found.usable):
            kept = done.demands[task.name, limit, part].reshape(-1, len(radii)) <= 1.0
            inside = (bounds.low[:, None] <= radii) & (radii <= bounds.high[:, None])
            assert np.all(inside | ~kept), (task.name, limit)
            cut += int(np.sum(~inside))
    assert unsure > 20
    assert cut > 100


@pytest.mark.slow
def test_a_narrow_range_of_cool_radii_is_found():
    """A winding that stays within its limit over few per cent of the radius, between the radii tried first."""
    motors, gearheads, pairs = part_tables(31, motors=1, gearheads=4, thermal=1.0, gaps=0.0)
    motors["max_winding_temperature"][:] = 600.0
    options = {"duty": {"reach": REACH}, "radius": (0.002, 0.05), "samples": 60, "loss_model": "coulomb"}
    found, tasks = judged(PULLEY, (motors, gearheads, pairs), {"reach": REACH}, samples=60)
    radii = np.geomspace(0.002, 0.05, 600)
    feasible, _ = brute_force(found, tasks, radii)
    rows, every = np.repeat(found.usable, len(radii)), np.tile(radii, len(found.usable))
    done = sample(found, rows, tasks, lambda places: replace(PULLEY.pulley, radius=every[places][:, None]))
    rise = done.demands["reach", Limit.TEMPERATURE, "motor"].reshape(feasible.shape)
    coolest = float(np.where(feasible, rise, np.inf).min())
    motors["max_winding_temperature"][:] = 298.15 + coolest * (600.0 - 298.15) * 1.001
    for objective in ("energy", "mass"):
        best = size_geared(PULLEY, motors, gearheads, pairs, objective=objective, **options)
        assert len(best.designs) == 1
        low, high = best.best.radii
        assert 1.0 < high / low < 1.15
        assert iv.duty_cycle(best.best.drive, REACH, samples=60).feasible
        if objective == "energy":
            every = np.linspace(low, high, 50)
            rows = np.full(50, best.best.pair)
            done = sample(
                found, rows, tasks, lambda places, every=every: replace(PULLEY.pulley, radius=every[places][:, None])
            )
            assert best.best.power <= done.power["reach"].min() * (1.0 + 1e-7)


@sampled("amplifier", ["burn", "store"], every=2)
@pytest.mark.parametrize("loss_model", ["coulomb", "proportional"])
def test_the_bound_of_the_power_is_below_it_at_every_radius(loss_model, amplifier):
    kept = {"regeneration": "store", "storage_efficiency": 0.7} if amplifier == "store" else {}
    template = replace(HEAVY_PULLEY, amplifier=iv.parts.Amplifier(efficiency=0.9, standby_power=0.3, **kept))
    found, tasks = judged(
        template, part_tables(17, motors=6, gearheads=5), {"reach": REACH, "shake": SHAKE}, None, loss_model, 60
    )
    radii = np.geomspace(0.004, 0.02, 60)
    for task in tasks:
        load = load_of(found, task, (0.004, 0.02))
        _, power = brute_force(found, [task], radii)
        shape = np.full(len(found.usable), 0.004)
        bound = least_power(found, load, found.usable, Radii(shape, 5.0 * shape))
        share = bound / power.min(axis=1)
        assert np.all(share <= 1.0 + 1e-9)
        assert np.median(share) > 0.8


@pytest.mark.slow
def test_intervals_of_radii_from_random_coefficients():
    random = np.random.default_rng(3)
    radii = np.geomspace(1e-3, 1e3, 4000)
    first, second, constant, bound = random.normal(size=(4, 500))
    keeps = first[:, None] * radii + second[:, None] / radii + constant[:, None] <= bound[:, None]
    found = below(first, second, constant, bound)
    inside = (found.low[:, None] <= radii) & (radii <= found.high[:, None])
    assert np.all(inside | ~keeps)
    exact = (bound > constant) | (first > 0) | (second > 0)
    np.testing.assert_array_equal(inside[exact], keeps[exact])
    assert exact.mean() > 0.5
    # Means of squares, as the moments of random signals.
    signals = random.normal(size=(500, 3, 40))
    signals[:, 2] = np.abs(signals[:, 2])
    # Signals that cancel at two radii, with a peak of the mean square between them.
    signals[250:, 1] = signals[250:, 0] * np.exp(random.normal(size=(250, 1)))
    signals[250:, 2] = -3.0 * signals[250:, 0] + 0.3 * signals[250:, 2]
    a, b, c = signals[:, 0], signals[:, 1], signals[:, 2]
    square = Laurent(
        np.mean(a * a, -1),
        2 * np.mean(a * c, -1),
        np.mean(c * c + 2 * a * b, -1),
        2 * np.mean(b * c, -1),
        np.mean(b * b, -1),
    )
    most = np.exp(random.normal(1.5, 1.0, 500))
    found = mean_square_below(square, None, most, (1e-3, 1e3))
    keeps = np.stack([square.at(np.full(500, one)) for one in radii], axis=-1) <= most[:, None]
    inside = (found.low[:, None] <= radii) & (radii <= found.high[:, None])
    assert np.all(inside | ~keeps)
    np.testing.assert_array_equal(inside[square.convex], keeps[square.convex])
    assert 0.4 < square.convex.mean() < 0.8
    # At rest: friction carries the load at small radii.
    forces = np.sort(np.abs(random.normal(size=30)))
    powers = np.stack([np.ones(30), forces, forces**2], axis=-1)
    sums = np.concatenate([np.cumsum(powers[::-1], axis=0)[::-1], np.zeros((1, 3))])
    slope, friction = np.exp(random.normal(size=(2, 500)))
    rest = Resting(forces, sums, 30, slope, friction)
    falling = Laurent(*np.zeros((4, 500)), np.exp(random.normal(size=500)))
    held = np.maximum(slope[:, None, None] * forces * radii[:, None] - friction[:, None, None], 0.0)
    values = np.mean(held**2, axis=-1) + falling.e[:, None] / radii**2
    np.testing.assert_allclose(rest.at(np.full(500, radii[2500]))[0], np.mean(held[:, 2500] ** 2, axis=-1), rtol=1e-9)
    most = values.min(axis=-1) * random.uniform(1.001, 1.2, 500)
    found = mean_square_below(falling, rest, most, (1e-3, 1e3))
    inside = (found.low[:, None] <= radii) & (radii <= found.high[:, None])
    np.testing.assert_array_equal(inside, values <= most[:, None])


def test_rows_without_what_a_law_needs_are_counted():
    motors, gearheads, pairs = part_tables(19)
    motors["no_load_current"][0] = np.nan
    motors["resistance"][1] = -1.0
    motors["rotor_inertia"][2] = np.nan
    motors["no_load_current"][3] = 1e6
    motors["peak_torque"][:] = np.inf
    gearheads["efficiency"][0] = np.nan
    gearheads["efficiency"][1] = 1.2
    found = size_geared(PULLEY, motors, gearheads, pairs, duty={"reach": REACH}, samples=60)
    count = len(gearheads["ratio"])
    assert found.excluded == {
        "motor no_load_current not stated": count,
        "motor rotor_inertia not stated": count,
        "gearhead efficiency not stated": 10,
        "motor resistance not > 0": 9,
        "gearhead efficiency not > 0 and <= 1": 9,
        "motor no_load_current not below its stall current": 8,
    }
    assert (Limit.PEAK, "motor") in found.unchecked
    assert all((Limit.PEAK, "motor") in one.unchecked for one in found.designs)
    assert not any(count.limit == Limit.PEAK for count in found.counts)
    for one in found.designs:
        assert one.motor > 3
        assert one.gearhead > 1
        assert one.drive.motor.peak_torque is None


def test_a_motion_out_of_reach_leaves_no_design():
    tables = part_tables(23)
    found = size_geared(PULLEY, *tables, duty={"shake": SHAKE}, travel=0.01, samples=60)
    assert found.best is None
    assert {one.limit: one.first for one in found.counts if one.first} == {Limit.TRAVEL: found.candidates}
    over = size_geared(
        PULLEY, *tables, duty={"shake": SHAKE}, travel=0.01, radius=(0.004, 0.02), samples=60, prune=False
    )
    assert over.best is None
    assert not over.evaluated.any()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"objective": "speed"}, "objective must be energy, mass, space, price or front"),
        ({"duty": {}}, "duty is empty"),
        ({"duty": {}, "objective": "mass"}, "both missing"),
        ({"top": 0}, "top must be >= 1"),
        ({"radius": (0.0, 1.0)}, "radius must be"),
        ({"radius": (0.1, 0.2), "stages": [Pulley(radius=0.1)]}, "both given"),
        ({"loss_model": "stribeck"}, "loss_model must be coulomb, proportional or strain wave"),
        ({"duty": {"requirement": REACH}}, "choose another name"),
    ],
)
def test_arguments_out_of_range(change, message):
    arguments = {"duty": {"reach": REACH}, **change}
    with pytest.raises(iv.InputError, match=message):
        size_geared(PULLEY, *part_tables(1), **arguments)


def test_tables_that_are_none():
    motors, gearheads, pairs = part_tables(1)
    for tables, message in (
        (({**motors, "voltage": ["high"] * 12}, gearheads, pairs), "motors.voltage must be numbers"),
        (({**motors, "voltage": np.ones(3)}, gearheads, pairs), "motors.resistance must be a vector as long"),
        (({"voltage": np.ones(3)}, gearheads, pairs), "motors.resistance is missing"),
        ((motors, gearheads, pairs * 1.0), "pairs must be whole numbers"),
        ((motors, gearheads, pairs + 5), r"pairs\[\d+, 0\] must be a row of the motors, 0 to 11, got 12"),
    ):
        with pytest.raises(iv.ParameterError, match=message):
            size_geared(PULLEY, *tables, duty={"reach": REACH})
    with pytest.raises(iv.ParameterError, match="state the screws to try as stages"):
        size_geared(
            replace(PULLEY, pulley=None, screw=Screw(lead=0.004, diameter=0.012, efficiency=0.9), guideway=Guideway()),
            *part_tables(1),
            duty={"reach": REACH},
            radius=(0.01, 0.02),
        )


def test_each_allowance_of_a_part_is_the_field_that_its_limit_names():
    """What is listed is what `utilisation` checks, and twice the field allows twice the demand."""
    motor = iv.parts.Motor(
        voltage=24.0,
        resistance=0.6,
        torque_constant=0.02,
        no_load_current=0.0,
        continuous_torque=0.05,
        peak_torque=0.2,
        demagnetisation_current=20.0,
        max_speed=900.0,
    )
    gear = iv.parts.Gearhead(
        ratio=5.0, efficiency=0.9, continuous_torque=2.0, intermittent_torque=3.0, max_input_speed=1000.0
    )
    for part, demands in (
        (motor, lambda one: one.utilisation(current=3.0, voltage=10.0, speed=400.0)),
        (gear, lambda one: one.utilisation(1.0, 40.0)),
    ):
        assert {*part.ALLOWANCES} == {*demands(part)}
        for limit, name in part.ALLOWANCES.items():
            larger = replace(part, **{name: 2.0 * getattr(part, name)})
            assert demands(larger)[limit] == pytest.approx(0.5 * demands(part)[limit], rel=1e-12)
