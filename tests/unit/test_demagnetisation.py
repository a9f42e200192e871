"""A limit that only the motor states: the current that demagnetises its magnets, in every analysis that judges motors."""

from dataclasses import replace

import numpy as np
import pytest

import infinivar as iv
from infinivar import Limit
from internals import time_history
from made import loaded
from small_catalogue import SHELF

KNEE = loaded("knee_walking")
DRIVE = KNEE.drives["geared"]
KEY = (Limit.DEMAGNETISATION, "motor")


def with_current(drive, current):
    return replace(drive, motor=replace(drive.motor, demagnetisation_current=current))


def test_demand_is_the_current_over_that_allowed_in_all_quadrants():
    motor = replace(DRIVE.motor, demagnetisation_current=5.0)
    rng = np.random.default_rng(3)
    torque, speed = rng.uniform(-0.3, 0.3, 200), rng.uniform(-500.0, 500.0, 200)
    point = motor.operate(torque=torque, speed=speed)
    np.testing.assert_allclose(point.utilisation[Limit.DEMAGNETISATION], np.abs(point.current) / 5.0, rtol=1e-15)
    assert Limit.DEMAGNETISATION not in DRIVE.motor.operate(torque=torque, speed=speed).utilisation
    assert motor.scaled(3.0).demagnetisation_current == 15.0


def test_a_cycle_is_judged_by_its_largest_current():
    cycle = iv.duty_cycle(with_current(DRIVE, 3.0), KNEE.duty["walking"])
    most = cycle.current_peaks["motor"] * DRIVE.motor.continuous_current
    assert not cycle.feasible
    assert cycle.demands[KEY] == pytest.approx(most / 3.0, rel=1e-9)
    assert cycle.demands[KEY] > 1.0
    halved = iv.duty_cycle(with_current(DRIVE, 6.0), KNEE.duty["walking"])
    assert halved.demands[KEY] == pytest.approx(0.5 * cycle.demands[KEY], rel=1e-12)


@pytest.fixture
def searched(tmp_path):
    """Search over a range of radii, with a current that the shelf's motor b, which has two pairs, allows."""
    walking = replace(KNEE.with_drives("geared"), requirement=None)

    def search(low, high, current="4 A"):
        stated = f'[motors.b]\ndemagnetisation_current = "{current}"\n'
        (tmp_path / "shelf.toml").write_text(SHELF.replace("[motors.b]\n", stated), "utf-8")
        return iv.size(walking, sets=str(tmp_path / "shelf.toml"), radius=(low, high), builds=0)

    return search


def count_of(found):
    return next(one for one in found.searches["geared"].counts if (one.limit, one.part) == KEY)


@pytest.mark.full
def test_a_search_counts_the_pairs_that_exceed_it_at_every_radius(searched):
    """The larger ratio needs less current at every radius, so that pairs which exceed it everywhere do so where fewest do."""
    fixed = [count_of(searched(radius, radius)).exceeded for radius in np.geomspace(0.003, 0.05, 9)]
    over = count_of(searched(0.003, 0.05))
    assert over.checked == 2
    assert over.exceeded == min(fixed)
    assert max(fixed) > min(fixed)


@pytest.mark.slow
def test_designs_of_a_search_keep_it_as_their_cycles_do(searched):
    found = searched(0.003, 0.05, "4 A")
    assert "b" in {one.parts["motor"].key for one in found.designs}
    for one in found.designs:
        cycles = [iv.duty_cycle(one.drive, duty) for duty in found.study.duty.values()]
        assert all(cycle.feasible for cycle in cycles)
        if one.parts["motor"].key == "b":
            worst = max(cycle.demands[KEY] for cycle in cycles)
            stated = max(demand for (_, *key), demand in one.demands.items() if tuple(key) == KEY)
            assert stated == pytest.approx(worst, rel=1e-9)


def test_a_run_names_it_and_its_figure_shows_when():
    """As the peak torque, which is a current too."""
    motor = replace(DRIVE.motor, demagnetisation_current=0.5, peak_torque=0.005)
    scenario = iv.Scenario(motion=iv.motion.Sinusoid(distance=0.02, frequency=2.0), load_mass=1.0, duration=0.3)
    run = iv.simulate(replace(DRIVE, motor=motor), scenario)
    assert {Limit.DEMAGNETISATION, Limit.PEAK} <= {event.limit for event in run.events}
    shown = [words for _, _, words in time_history.data(run)["limits"]["current\n[A]"]]
    assert {"motor demagnetisation current (motor)", "motor peak torque (motor)"} <= {*shown}
