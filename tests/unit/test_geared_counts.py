"""Search over geared drives: each pair is a design, excluded by a limit or not judged; amplifiers that accept no power."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import infinivar as iv
from infinivar import Limit
from infinivar.parts import Amplifier, Guideway, Pulley
from internals import (
    Radii,
    RegionTask,
    braking_places,
    candidates,
    load_of,
    over_radius,
    region_points,
    size_geared,
    tasks_of,
)
from internals import geared_sample as sample
from internals import regeneration_returning as returning
from internals import regeneration_windows as windows
from internals import union_of_windows as union
from made import loaded
from nearest import nearest_geared
from part_tables import part_tables
from sampled import sampled

KNEE = loaded("knee_walking")
PULLEY = KNEE.drives["geared"]
RADII = (0.002, 0.06)
REACH = iv.DutyCycle(motion=iv.motion.Reaches(distance=0.2, time=0.6, pause=1.5), load_mass=0.8, force=-25.0)
SHAKE = iv.DutyCycle(motion=iv.motion.Sinusoid(distance=0.06, frequency=2.0), load_mass=1.5, force=-20.0)
LIFT = iv.DutyCycle(motion=iv.motion.Sinusoid(distance=0.1, frequency=0.5), load_mass=0.5, force=-12.0)
TIME = np.linspace(0.0, 3.0, 61)
RUN = iv.DutyCycle(
    motion=iv.motion.Recording(
        file="log", time=TIME, position=0.05 * np.sin(2.0 * TIME), force=-60.0 * np.cos(3.0 * TIME), closed=False
    ),
    load_mass=1.0,
    start_temperature=405.0,
)
"""Begins with windings warmer than some of them may be."""
REGION = iv.Requirement(force=80.0, speed=0.3, power=10.0, quadrants=4)


def accepting_none(friction=30.0):
    """A template that accepts no returned power; friction of the guideway carries part of the load."""
    return replace(
        PULLEY,
        amplifier=Amplifier(regeneration="none"),
        guideway=Guideway(friction=friction),
        pulley=Pulley(radius=0.012, friction_torque=0.05),
    )


CASES = {
    "burn": (PULLEY, {"reach": REACH, "shake": replace(SHAKE, load_mass=8.0, force=-150.0)}, None, "coulomb"),
    "region": (PULLEY, {}, iv.Requirement(force=300.0, speed=0.6, power=90.0, quadrants=4), "proportional"),
    "run": (PULLEY, {"run": RUN}, None, "coulomb"),
    "hot": (PULLEY, {"shake": replace(SHAKE, ambient=400.0)}, None, "coulomb"),
    "none": (accepting_none(10.0), {"lift": LIFT}, None, "proportional"),
    "none-region": (accepting_none(), {}, REGION, "proportional"),
}


def options_of(duty, region, loss_model):
    shared = {"samples": 60, "travel": 0.5, "objective": "mass"}
    return {"duty": duty, "requirement": region, "loss_model": loss_model, **shared}


@sampled("name", CASES, every=3)
@sampled("prune", [True, False], every=2)
def test_counts_add_up_over_radii(name, prune):
    """Pairs not judged, first excluded by each limit, and feasible designs are all pairs."""
    template, duty, region, loss_model = CASES[name]
    tables = part_tables(17, motors=6, gearheads=5, thermal=0.7)
    tables[0]["mass"][0] = np.nan
    options = options_of(duty, region, loss_model)
    found = size_geared(template, *tables, radius=RADII, top=1000, prune=prune, **options)
    assert found.excluded == {"motor mass not stated": 5}
    first = sum(count.first for count in found.counts)
    assert first + len(found.designs) + 5 == found.candidates == 30
    assert first
    assert len({one.pair for one in found.designs}) == len(found.designs)
    assert all(max(count.first, count.exceeded) <= count.checked for count in found.counts)
    if name == "hot":
        heat = next(count for count in found.counts if count.limit == Limit.TEMPERATURE)
        limit = tables[0]["max_winding_temperature"][1:]
        assert heat.exceeded >= 5 * np.sum(limit < 400.0) > 0


@sampled("name", CASES, every=3)
def test_counts_add_up_at_given_stages(name):
    template, duty, region, loss_model = CASES[name]
    tables = part_tables(18, motors=6, gearheads=5, thermal=0.7)
    stages = [replace(template.pulley, radius=radius) for radius in (0.004, 0.009, 0.016)]
    options = options_of(duty, region, loss_model)
    found = size_geared(template, *tables, stages=stages, top=1000, **options)
    assert sum(count.first for count in found.counts) + len(found.designs) == found.candidates == 90
    assert found.feasible.sum() == len(found.designs)
    assert all(count.first <= count.exceeded <= count.checked for count in found.counts)


def test_every_pair_that_fails_at_its_radii_is_counted_once():
    """All but those that came out feasible in one of their ranges, or were not evaluated in all; the first pair as well."""
    keys = [("walk", *key) for key in ((Limit.SPEED, "motor"), (Limit.THERMAL, "motor"))]
    places = np.array([0, 0, 1, 2, 2, 3, -1])
    first = SimpleNamespace(
        keys=keys,
        worst=np.array([2.0, 1.5, 3.0, 0.9, 4.0, 1.1, 9.0]),
        tightest=np.array([0, 1, 0, 1, 0, 1, 0]),
        able=np.array([False, False, False, True, False, False, False]),
        evaluated=np.array([True, True, True, True, True, False, True]),
    )
    counted = []
    tally = SimpleNamespace(tightest=lambda named, which: counted.append([named[one] for one in which]))
    over_radius._tally_evaluated(tally, first, places)
    assert counted == [[keys[1], keys[0]]]  # pairs 0, by the milder of its two ranges, and 1


def dense(found, tasks, radii):
    """Feasibility and returned power of every pair at every radius."""
    rows, every = np.repeat(found.usable, len(radii)), np.tile(radii, len(found.usable))
    pulley = found.template.pulley
    done = sample(found, rows, tasks, lambda places: replace(pulley, radius=every[places][:, None]))
    shape = len(found.usable), len(radii)
    returned = {
        key[0]: demand.reshape(shape) > 0.0 for key, demand in done.demands.items() if key[1] == Limit.REGENERATION
    }
    return done.feasible.reshape(shape), returned


@pytest.mark.slow
@pytest.mark.parametrize("loss_model", ["coulomb", "proportional"])
def test_radii_that_return_no_power_are_those_of_a_dense_grid(loss_model):
    """Instant by instant, with gaps: exact without thermal data, and never too narrow with them."""
    template = replace(accepting_none(10.0), output_inertia=2e-5)
    radii = np.geomspace(*RADII, 60)[1:-1]
    gaps = part = 0
    for thermal in (0.0, 1.0):
        motors, gearheads, pairs = part_tables(19, motors=4, gearheads=4, thermal=thermal, gaps=0.0)
        motors["no_load_current"] *= 3.0
        found = candidates(template, motors, gearheads, pairs, loss_model=loss_model, moving=True, stated=())
        tasks = tasks_of(template, {"lift": LIFT, "reach": REACH}, REGION, travel=None, samples=60)
        tasks = [region_points(task, template) if isinstance(task, RegionTask) else task for task in tasks]
        _, returned = dense(found, tasks, radii)
        for task in tasks:
            spans = returning(found, load_of(found, task, RADII), found.usable)
            inside = np.array([np.any((span[:, :1] < radii) & (radii < span[:, 1:]), axis=0) for span in spans])
            gaps += sum(len(span) > 1 for span in spans)
            if thermal == 0.0:
                np.testing.assert_array_equal(inside, returned[task.name])
                part += 0 < inside.sum() < inside.size
            else:
                assert np.all(returned[task.name] | ~inside)
    assert gaps
    assert part > 1


@pytest.mark.slow
def test_every_pair_with_a_radius_that_returns_no_power_is_found():
    """Windows of few per cent, against a dense grid; the least power of each window."""
    radii = np.geomspace(*RADII, 400)
    narrow = both = 0
    for loss_model in ("coulomb", "proportional"):
        for friction in (10.0, 16.0):
            template = accepting_none(friction)
            tables = part_tables(23, motors=6, gearheads=6, thermal=0.0, gaps=0.5)
            options = {"duty": {"lift": LIFT}, "radius": RADII, "loss_model": loss_model, "samples": 60, "top": 1000}
            found = candidates(template, *tables, loss_model=loss_model, moving=True, stated=())
            tasks = tasks_of(template, {"lift": LIFT}, None, travel=None, samples=60)
            feasible, _ = dense(found, tasks, radii)
            best = size_geared(template, *tables, **options)
            designs = {one.pair: one for one in best.designs}
            able = set(found.usable[feasible.any(axis=1)].tolist())
            assert able <= designs.keys()
            assert len(designs) == len(best.designs)
            for one in best.designs:
                assert iv.duty_cycle(one.drive, LIFT, samples=60).feasible
                low, high = one.radii
                narrow += high / low < 1.1
            both += len(able)
    assert both > 10
    assert narrow


@pytest.mark.slow
def test_the_points_of_a_region_that_return_power_are_found():
    """Few of its points decide, whatever pair and radius."""
    template = accepting_none(3.0)
    for loss_model in ("coulomb", "proportional"):
        tables = part_tables(29, motors=4, gearheads=4, gaps=0.0)
        found = candidates(template, *tables, loss_model=loss_model, moving=False, stated=())
        (task,) = tasks_of(template, {}, REGION, travel=None, samples=None)
        fewer = region_points(task, template)
        assert len(fewer.speed) < 0.05 * len(task.speed)
        random = np.random.default_rng(5)
        few = replace(task, speed=task.speed[::37], force=task.force[::37])  # of all, to save time
        radii = random.uniform(0.002, 0.03, 12)
        _, every = dense(found, [few], radii)
        _, some = dense(found, [fewer], radii)
        assert np.all(some["requirement"] | ~every["requirement"])
        assert 0 < some["requirement"].sum() < some["requirement"].size


def test_braking_places():
    """Of each torque below 0 the speeds in ratios of about two."""
    torque, speed = (one.ravel() for one in np.meshgrid([-2.0, -1.0, 0.0, 1.0], np.arange(1.0, 12.0), indexing="ij"))
    places = braking_places(np.stack([torque, speed], axis=-1))
    assert sorted(zip(torque[places], speed[places], strict=True)) == [
        (force, quick) for force in (-2.0, -1.0) for quick in (1.0, 2.0, 3.0, 5.0, 9.0, 11.0)
    ]


def test_intervals_and_windows():
    """Unions and complements of random intervals, against points."""
    random = np.random.default_rng(3)
    points = random.uniform(0.0, 1.0, 500)
    for _ in range(50):
        spans = np.sort(random.uniform(0.0, 1.0, (random.integers(0, 6), 2)), axis=-1)
        joined = union(spans)
        inside = np.any((spans[:, :1] < points) & (points < spans[:, 1:]), axis=0)
        np.testing.assert_array_equal(inside, np.any((joined[:, :1] < points) & (points < joined[:, 1:]), axis=0))
        assert np.all(np.diff(joined.ravel()) > 0.0)
        low, high = np.sort(random.uniform(0.0, 1.0, 2))
        places, left = windows([joined], Radii(np.array([low]), np.array([high])))
        open_ = np.any((left.low[:, None] <= points) & (points <= left.high[:, None]), axis=0)
        np.testing.assert_array_equal(open_, (low <= points) & (points <= high) & ~inside)
        assert np.all(places == 0)


@pytest.mark.slow
def test_the_nearest_miss_exceeds_something():
    """A pair that keeps all limits, but was not judged for its mass, is no miss."""
    motors, gearheads, pairs = part_tables(31, motors=4, gearheads=3, gaps=0.0)
    weightless = {**motors, "mass": np.full(4, np.nan)}
    options = {"duty": {"reach": REACH}, "radius": RADII, "loss_model": "coulomb", "samples": 60}
    assert size_geared(PULLEY, motors, gearheads, pairs, objective="mass", **options).designs
    found = size_geared(PULLEY, weightless, gearheads, pairs, objective="mass", **options)
    assert not found.designs
    assert found.excluded == {"motor mass not stated": 12}
    assert nearest_geared(PULLEY, weightless, gearheads, pairs, weighed=True, **options) is None
    miss = nearest_geared(PULLEY, weightless, gearheads, pairs, **options)
    assert miss is None or miss.margin < 1.0
    del options["radius"]
    for radius in (0.003, 0.008):
        stage = [replace(PULLEY.pulley, radius=radius)]
        miss = nearest_geared(PULLEY, weightless, gearheads, pairs, stages=stage, **options)
        assert miss is None or miss.margin < 1.0
