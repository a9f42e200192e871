"""What a kilogram costs to carry: the best design at every cost, against a search over all designs at each."""

from types import SimpleNamespace

import numpy as np
import pytest

import infinivar as iv
from infinivar import InputError, ParameterError
from internals import at_cost, best_carried, carried_lines


def some_designs(seed, count=60):
    random = np.random.default_rng(seed)
    power, mass = random.uniform(1.0, 10.0, count), random.uniform(0.2, 5.0, count)
    return [
        SimpleNamespace(template="one" if place % 2 else "other", power=one, mass=two)
        for place, (one, two) in enumerate(zip(power, mass, strict=True))
    ]


@pytest.mark.parametrize("seed", range(5))
def test_the_best_at_every_cost_is_that_of_all_designs(seed):
    designs = some_designs(seed)
    found = best_carried(designs)
    assert len(found) >= 2
    assert [one.cost for one in found] == sorted(one.cost for one in found)
    for cost in np.concatenate([[0.0], np.geomspace(1e-3, 1e4, 200)]):
        least = min(one.power + cost * one.mass for one in designs)
        assert at_cost(found, cost).at(cost) == pytest.approx(least, rel=1e-12)
    assert found[-1].mass == min(one.mass for one in designs)


def test_designs_of_unknown_mass_or_power_do_not_count():
    designs = [*some_designs(7, 6), SimpleNamespace(template="x", power=0.1, mass=np.nan)]
    assert "x" not in {one.template for one in best_carried(designs)}
    assert best_carried(designs[-1:]) == ()
    assert carried_lines((), 1.0) == []


def test_words_say_from_which_cost_on_another_drive_is_the_best():
    designs = [
        SimpleNamespace(template="cobotic", power=3.0, mass=2.0),
        SimpleNamespace(template="geared", power=4.0, mass=0.5),
    ]
    lines = carried_lines(best_carried(designs), 3.0)
    assert lines == [
        "If carrying a kilogram costs power: cobotic, geared from 0.667 W/kg on",
        "At 3 W/kg: geared, 4 W and 0.5 kg, 5.5 W together",
    ]


@pytest.mark.slow
def test_a_search_states_it_beside_its_verdict():
    """A short search for the shipped knee: the least sum of all its designs."""
    sizing = iv.size(iv.load_study("knee_walking"), sets="shipped", generations=2, carried=5.0)
    every = [*sizing.designs, *sizing.front]
    for cost in (0.0, 0.5, 5.0, 50.0):
        least = min(one.power + cost * one.mass for one in every)
        assert at_cost(sizing.carried, cost).at(cost) <= least * (1.0 + 1e-12)
    assert sizing.carrying[0].startswith("If carrying a kilogram costs power: cobotic, geared from")
    assert sizing.carrying[1].startswith("At 5 W/kg: geared, ")


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"carried": -1.0}, ParameterError, "carried must be >= 0"),
        ({"carried": float("nan")}, ParameterError, "carried must be >= 0"),
        ({"carried": 1.0, "objective": "mass"}, InputError, "carried needs both objectives"),
    ],
)
def test_bad_costs_are_refused(options, error, words):
    with pytest.raises(error, match=words):
        iv.size(iv.load_study("knee_walking"), **options)
