"""The nearest miss: all demands count in falling order, then the mass, against single drives one by one."""

from dataclasses import replace

import numpy as np
import pytest

import infinivar as iv
from infinivar import Limit
from infinivar.parts import Screw
from internals import candidates, margin_of, shortfalls
from internals import nearest_of_margins as nearest_of
from internals import tightest_of_margins as tightest_of
from made import loaded
from nearest import nearest_geared
from part_tables import part_tables

KNEE = loaded("knee_walking")
GEARED = KNEE.drives["geared"]
WALK = KNEE.duty["walking"]
SAMPLES = 200


def brute_force(template, tables, stages):
    """Demands beyond their allowance in falling order and mass of every pair at every stage, by `duty_cycle`."""
    motors, gearheads, pairs = tables
    found = candidates(template, motors, gearheads, pairs, loss_model="coulomb", moving=True, stated=())
    ranks = {}
    for place, stage in enumerate(stages):
        for row in map(int, found.usable):
            cycle = iv.duty_cycle(found.drive(row, stage), WALK, samples=SAMPLES)
            heat = [cycle.heat["motor"].demand] if cycle.heat["motor"] is not None else []
            beyond = sorted((max(one, 1.0) for one in (*cycle.demands.values(), *heat)), reverse=True)
            mass = float(found.mass(np.array([row]))[0])
            ranks[place, row] = (*np.round(beyond, 6), *(1.0,) * (20 - len(beyond)), mass)
    return ranks


@pytest.mark.slow
def test_of_misses_equal_in_the_worst_limit_the_better_in_the_next_wins():
    """A screw that permits less than the load: all pairs exceed that alike, and what else they exceed decides."""
    tables = part_tables(5, motors=12, gearheads=9)
    tables = ({**tables[0], "continuous_torque": 0.08 * tables[0]["continuous_torque"]}, *tables[1:])
    assert len(tables[2]) > 64
    stages = [
        Screw(lead=lead, diameter=0.01, friction_coefficient=0.05, permissible_force=force)
        for lead, force in ((0.004, 40.0), (0.03, 80.0), (0.03, 60.0))
    ]
    template = replace(GEARED, pulley=None, screw=stages[0])
    ranks = brute_force(template, tables, stages)
    first, second = sorted(ranks.values())[:2]
    assert first[0] == second[0] > first[1] > 1.0
    found = nearest_geared(template, *tables, duty={"walking": WALK}, stages=stages, samples=SAMPLES)
    best = min(ranks, key=ranks.get)
    assert (stages.index(found.stage), found.pair) == best
    assert found.tightest[1] == Limit.OUTPUT_FORCE


def test_of_misses_equal_in_all_limits_the_lighter_wins():
    motors, gearheads, _ = part_tables(3, motors=1, gearheads=1)
    same = {name: np.repeat(column, 4) for name, column in motors.items()}
    same |= {"mass": np.array([0.3, np.nan, 0.1, 0.2]), "continuous_torque": 1e-3 * same["continuous_torque"]}
    pairs = np.array([(row, 0) for row in range(4)])
    options = {"duty": {"walking": WALK}, "samples": SAMPLES}
    for given in ({"radius": (0.003, 0.05)}, {"stages": [GEARED.pulley]}):
        found = nearest_geared(GEARED, same, gearheads, pairs, **options, **given)
        assert found.margin < 1.0
        assert found.pair == 2


@pytest.mark.slow
def test_where_no_power_may_return_what_else_is_exceeded_decides():
    """All return power at every radius, which has no measure: the pair that keeps the rest is nearest, not the first one."""
    tables = part_tables(7, motors=8, gearheads=9)
    template = replace(GEARED, amplifier=replace(GEARED.amplifier, regeneration="none"))
    options = {"duty": {"walking": WALK}, "radius": (0.003, 0.05), "samples": SAMPLES}
    found = nearest_geared(template, *tables, **options)
    demands = dict(found.demands)
    assert np.isinf(demands.pop(("walking", Limit.REGENERATION, "motor")))
    assert max(demands.values()) <= 1.0


def test_demands_in_falling_order():
    demands = np.array([[2.0, 2.0 + 1e-7, 2.1, np.nan], [0.3, 1.5, 0.2, 1.0], [1.6, -1.0, 0.1, 1.0]])
    np.testing.assert_array_equal(
        shortfalls(demands).T, [[2.0, 1.6, 1.0], [2.0 + 1e-7, 1.5, 1.0], [2.1, 1.0, 1.0], [np.inf, 1.0, 1.0]]
    )
    assert nearest_of(demands, np.zeros(4)) == 1
    assert nearest_of(demands[:, [3, 2]], np.zeros(2)) == 1
    equal = np.array([[2.0] * 3, [1.5] * 3])
    assert nearest_of(equal, np.array([np.nan, 0.2, 0.2])) == 1
    assert nearest_of(equal, np.full(3, np.nan)) == 0


@pytest.mark.parametrize("order", [slice(None), slice(None, None, -1)])
def test_the_order_of_candidates_does_not_matter(order):
    rng = np.random.default_rng(4)
    demands = rng.choice([0.5, 1.0, 1.3, 1.7], (4, 300))
    mass = rng.permutation(300) / 300
    which = np.arange(300)[order][nearest_of(demands[:, order], mass[order])]
    rank = [(*sorted(np.maximum(demands[:, one], 1.0), reverse=True), mass[one]) for one in range(300)]
    assert which == min(range(300), key=rank.__getitem__)


def test_margin_without_load_is_unbounded():
    assert margin_of({}) == margin_of({Limit.SPEED: 0.0, Limit.THERMAL: 0.0}) == float("inf")
    assert tightest_of({}) is None
    assert margin_of({Limit.SPEED: 0.5, Limit.THERMAL: 0.25}) == 2.0
