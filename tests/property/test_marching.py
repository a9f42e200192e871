"""What a march keeps of its steps: the events found from it are those of all steps, and it grows with the events only."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import infinivar as iv
from internals import marching, run_limits, touches
from machines import MACHINES

KEYS = ((iv.Limit.SLIP, "wheel 1"), (iv.Limit.PEAK, "motor"))
LEVELS = st.sampled_from([0.2, 0.9, 1.0, 1.0 + 5e-10, 1.5, 2.0, np.inf])


@pytest.mark.slow
@settings(max_examples=300)
@given(st.lists(st.tuples(LEVELS, LEVELS, st.booleans()), min_size=2, max_size=40), st.integers(-1, 40))
def test_events_and_touches_are_those_of_all_steps(rows, split):
    time = 0.1 * np.arange(len(rows))
    demands = np.array([row[:2] for row in rows])
    settling = None if split < 0 else 0.1 * split
    log = marching._Log()
    for at, demand, (_, _, result) in zip(time.tolist(), demands, rows, strict=True):
        first = settling is not None and at >= settling * (1.0 - 1e-9) > at - 0.1
        log.watch(at, demand, first)
        log.needed |= result

    def events(time, demands):
        early = run_limits.first_settled(time, settling)
        return run_limits.events(time, dict(zip(KEYS, demands.T, strict=True)), early)

    kept, few = np.array(log.instants), np.array(log.demands)
    assert events(kept, few) == events(time, demands)
    assert touches(kept, few[:, 1] - 1.0) == touches(time, demands[:, 1] - 1.0)
    assert {at for at, row in zip(time.tolist(), rows, strict=True) if row[2]} <= set(log.instants)


def test_steps_within_limits_leave_nothing_behind():
    log = marching._Log()
    for at in range(10_000):
        log.watch(float(at), np.array([0.5, 0.9 + 0.05 * np.sin(at)]), needed=False)
        log.sample(float(at), {"motor": 0.3 + 0.1 * np.sin(at)})
    assert len(log.instants) <= 3
    assert len(log.sampled) == 1


@pytest.mark.slow
@pytest.mark.parametrize("name", ["arm", "serial arm", "planar"])
def test_motors_are_judged_at_every_sample(name):
    """However far apart the results are: a limit passed between them counts, and so does the current there."""
    machine, how = MACHINES[name]
    fine, coarse = (
        iv.simulate_machine(machine, iv.motion.MachineScenario(**{**how, "duration": 0.05, "output_step": step}))
        for step in (0.001, 0.05)
    )
    assert coarse.root_mean_squares == pytest.approx(fine.root_mean_squares, rel=1e-12)
    worst = [{(one.limit, one.what): one.worst for one in run.events} for run in (fine, coarse)]
    assert worst[1] == pytest.approx(worst[0], rel=1e-12)
