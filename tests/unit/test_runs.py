"""Recordings that do not close: smoothing at their ends, energy and temperatures over the run, beside the closed cycle."""

import itertools
import math
from dataclasses import fields, replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar import DutyCycle, ParameterError, duty_cycle
from infinivar.analysis import policies, two_ways
from infinivar.motion import Recording
from infinivar.parts import heat
from internals import FourierSeries as Series
from internals import RunSeries, mixed_use, outcomes
from made import parameter_study

DRIVES = parameter_study("faulring2006").drives
PERIOD, CUTOFF = 1.25, 10.0
TURN = 2.0 * math.pi / PERIOD


def position(time):
    return 0.03 * np.sin(TURN * time) + 0.008 * np.sin(2 * TURN * time + 0.4)


def force(time):
    return -5.0 - 4.0 * np.cos(TURN * time + 0.3)


def recording(cycles, *, closed, rate=200.0):
    time = np.linspace(0.0, cycles * PERIOD, round(cycles * PERIOD * rate) + 1)
    return Recording(file="log", time=time, position=position(time), force=force(time), closed=closed)


def wave(frequency, size=0.01, phase=0.7, slope=0.1):
    turn = 2.0 * math.pi * frequency

    def chain(time):
        angle = turn * time + phase
        parts = (np.sin(angle), np.cos(angle), -np.sin(angle), -np.cos(angle), np.sin(angle))
        made = [size * turn**order * part for order, part in enumerate(parts)]
        return [made[0] + slope * time, made[1] + slope, *made[2:]]

    return chain


CLOSED_FORMS = {
    # Duration, quantity and derivatives, their scales (their largest values by default; those of the parabola that are zero:
    # its acceleration over 10 and 1 ms), and the largest errors up to the ends, relative to the scales.
    "parabola": (
        3.0,
        lambda t: [0.05 * t**2, 0.1 * t, 0.1 + 0.0 * t, 0.0 * t, 0.0 * t],
        (0.45, 0.3, 0.1, 10.0, 100.0),
        (1e-6, 5e-5, 4e-3, 2e-3, 1e-2),
    ),
    "half sine": (
        0.5,
        lambda t: [(2 * math.pi) ** n * np.sin(2 * math.pi * t + 0.5 * math.pi * n) for n in range(5)],
        tuple((2 * math.pi) ** n for n in range(5)),
        (1e-4, 6e-4, 3e-3, 0.03, 0.2),
    ),
    "ramp and 1 Hz": (3.0, wave(1.0), None, (1e-5, 6e-4, 0.01, 0.1, 0.6)),
    "ramp and 3 Hz": (3.0, wave(3.0), None, (2e-4, 0.015, 0.12, 0.4, 0.7)),
}


@pytest.mark.parametrize("name", CLOSED_FORMS)
def test_ends_of_a_run_do_not_ring(name):
    """Largest errors over the run including its ends, and two waves away from them."""
    duration, chain, scales, allowed = CLOSED_FORMS[name]
    time = np.linspace(0.0, duration, round(duration * 400) + 1)
    series = RunSeries.through(time, chain(time)[0], chain(time)[0], CUTOFF)
    at = np.linspace(0.0, duration, 1500)
    found, expected = series.derivatives(at, 4), chain(at)
    scales = scales or [np.max(np.abs(part)) for part in expected]
    inside = (at > 2.0 / CUTOFF) & (at < duration - 2.0 / CUTOFF)
    for order in range(5):
        off = np.abs(found[order] - expected[order]) / scales[order]
        assert np.max(off) < allowed[order], order
        assert np.max(off[inside]) < 0.5 * allowed[order], order


def test_a_run_is_not_bent_to_close():
    """The same ramp under a filter that assumes a cycle rings by half of its height; here not at all."""
    time = np.linspace(0.0, 2.0, 801)
    at = np.linspace(0.0, 2.0, 501)
    off = RunSeries.through(time, time, time, CUTOFF).derivatives(at, 2)
    assert_allclose(off[0], at, atol=1e-9)
    assert_allclose(off[1], 1.0, atol=1e-8)
    assert_allclose(off[2], 0.0, atol=1e-6)
    assert np.max(np.abs(Series.through(2.0, time[:-1], CUTOFF).derivatives(at, 0)[0] - at)) > 0.5


def test_derivatives_of_any_order_follow_from_one_another():
    """Up to the sixth, by differences."""
    time = np.linspace(0.0, 3.0, 1201)
    values = wave(1.3)(time)[0] + 0.002 * np.sin(2 * math.pi * 3.7 * time)
    series = RunSeries.through(time, values, values, CUTOFF)
    at = np.linspace(0.5, 2.5, 20001)
    found = series.derivatives(at, 6)
    for low, high in itertools.pairwise(found):
        slope = (low[2:] - low[:-2]) / (at[2:] - at[:-2])
        assert_allclose(slope, high[1:-1], atol=2e-5 * np.max(np.abs(high)))


def test_equal_steps_are_evaluated_as_single_instants_are():
    """The fast convolution and the plain sum, for a long series."""
    random = np.random.default_rng(1)
    series = Series(60.0, random.standard_normal(700), random.standard_normal(700))
    time = 3.0 + np.arange(6000) * 0.005
    fast = series.derivatives(time, 3)
    plain = [
        np.concatenate(parts)
        for parts in zip(*(series.derivatives(part, 3) for part in np.split(time, 50)), strict=True)
    ]
    for one, other in zip(fast, plain, strict=True):
        assert_allclose(one, other, atol=1e-9 * np.max(np.abs(other)))


def test_the_integral_of_a_recorded_speed_is_the_position():
    time = np.linspace(0.0, 3.0, 1201)
    chain = wave(1.0)
    run = Recording(file="v", time=time, speed=chain(time)[1], closed=False)
    at = np.linspace(0.0, 3.0, 301)
    assert_allclose(run.derivatives(at, 0)[0], chain(at)[0] - chain(np.zeros(1))[0], atol=2e-5)


def test_rest_at_the_ends_of_a_run_is_rest():
    """A run from rest at 0 to rest at 50 mm: no speed at all before and after the move, at two different places."""
    time = np.linspace(0.0, 3.0, 601)
    share = np.clip(time - 1.0, 0.0, 1.0)
    values = 0.05 * share**3 * (10.0 + share * (6.0 * share - 15.0))
    run = Recording(file="reach", time=time, position=values, closed=False)
    place, speed = run.derivatives(np.array([0.0, 0.3, 0.8, 2.2, 2.7, 3.0]), 1)
    assert np.all(speed == 0.0)
    assert_allclose(place, [0.0, 0.0, 0.0, 0.05, 0.05, 0.05], atol=1e-5)
    assert DutyCycle(motion=run).resting == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize("name", ["cobotic", "motor2-gear4"])
def test_identical_cycles_as_a_run_spend_the_cycles_energy(name):
    """With cold windings and equal instants, to 1e-4: linear interpolation to other steps, and the ends of the run."""
    drive = DRIVES[name]
    cycle = duty_cycle(drive, DutyCycle(motion=recording(1, closed=True), load_mass=0.8))
    for count in (4, 12):
        duty = DutyCycle(motion=recording(count, closed=False), load_mass=0.8)
        run = duty_cycle(drive, duty, samples=count * len(cycle.instants.time))
        assert run.duty.period == pytest.approx(count * PERIOD)
        assert run.closure < 1e-9
        assert run.cold_power * duty.period == pytest.approx(count * cycle.cold_power * PERIOD, rel=1e-4)
        # With the instants of a run, fewer in each cycle, friction reverses between them.
        assert duty_cycle(drive, duty).cold_power == pytest.approx(cycle.cold_power, rel=1e-3)


@pytest.mark.parametrize("name", ["cobotic", "motor2-gear4"])
def test_a_run_ends_as_hot_as_its_cycles_repeated(name):
    """16 cycles from ambient, as a run and in the history of the settled cycle."""
    drive = DRIVES[name]
    cycle = duty_cycle(drive, DutyCycle(motion=recording(1, closed=True), load_mass=0.8))
    duty = DutyCycle(motion=recording(16, closed=False), load_mass=0.8)
    run = duty_cycle(drive, duty, samples=16 * len(cycle.instants.time))
    for what, hot in run.heat.items():
        settled = cycle.heat[what]
        if hot is None or settled is None:
            continue
        assert hot.time[-1] == pytest.approx(16 * PERIOD)
        rise = hot.winding_history[-1] - hot.ambient
        expected = np.interp(hot.time[-1], settled.time, settled.winding_history) - settled.ambient
        assert rise == pytest.approx(expected, rel=0.01)


def test_a_hotter_start_ends_hotter_and_costs_more():
    run = recording(4, closed=False)
    cold, hot = (
        duty_cycle(DRIVES["motor2-gear4"], DutyCycle(motion=run, load_mass=0.8, start_temperature=start))
        for start in (None, 350.0)
    )
    assert cold.heat["motor"].winding_history[0] == pytest.approx(298.15)
    assert hot.heat["motor"].winding_history[0] == pytest.approx(350.0)
    assert hot.energy > cold.energy
    assert hot.cold_power == cold.cold_power
    assert "over the run" in hot.verdict
    assert "per cycle" not in hot.verdict
    assert "settles" not in hot.verdict
    assert {"energy_over_run_J", "mean_power_W"} < hot.to_dict().keys()


MOTOR = DRIVES["cobotic"].motor


def test_temperatures_over_a_run_in_closed_form():
    """Constant current, housing far slower than the winding: an exponential approach, and the time at which a limit is passed."""
    slow = iv.parts.Motor(**{**_fields(MOTOR), "housing_time_constant": 1e9, "housing_to_ambient": 1e-3})
    current, duration = 4.0, 30.0
    found = heat.heat_over_run(slow, np.full(400, current), 0.0, duration, ambient=300.0, start=300.0)
    inner, lag = slow.winding_to_housing, slow.winding_time_constant
    joule = slow.resistance * current**2
    rate = (1.0 - joule * heat.COPPER * inner) / lag
    target = 300.0 + joule * inner * (1.0 + heat.COPPER * (300.0 - heat.REFERENCE)) / (lag * rate)
    expected = target + (300.0 - target) * np.exp(-rate * found.time)
    assert_allclose(found.winding_history, expected, atol=2e-3)
    limit = 300.0 + 0.5 * (found.winding - 300.0)
    bounded = iv.parts.Motor(**{**_fields(slow), "max_winding_temperature": limit})
    passed = heat.heat_over_run(bounded, np.full(400, current), 0.0, duration, ambient=300.0, start=300.0)
    assert passed.time_to_limit == pytest.approx(-math.log((target - limit) / (target - 300.0)) / rate, rel=1e-4)
    assert not passed.within_limit
    assert "exceeded after" in passed.verdict


def _fields(motor):
    return {field.name: getattr(motor, field.name) for field in fields(motor)}


def test_two_ways_to_the_temperature_of_a_run():
    """Exact steps and the trapezoidal rule, for a current that changes."""
    current = 2.0 + 1.5 * np.sin(np.linspace(0.0, 9.0, 1200))
    exact = heat.heat_over_run(MOTOR, current, 0.3, 120.0, start=320.0)
    highest, mean = heat.through_run(MOTOR, current, np.full(1200, 0.3), 120.0, ambient=heat.REFERENCE, start=320.0)
    assert float(highest[0]) == pytest.approx(exact.winding, abs=0.05)
    assert float(mean[0]) == pytest.approx(exact.mean_winding, abs=0.05)


def test_a_run_judges_motors_by_temperature():
    """Continuous torque stands for a settled temperature: it limits the cycle, not a short run."""
    cycle = duty_cycle(DRIVES["cobotic-b"], DutyCycle(motion=recording(1, closed=True), load_mass=0.8))
    run = duty_cycle(DRIVES["cobotic-b"], DutyCycle(motion=recording(4, closed=False), load_mass=0.8))
    assert (iv.Limit.THERMAL, "steering motor") in cycle.demands
    assert (iv.Limit.THERMAL, "steering motor") not in run.demands
    assert run.heat["steering motor"] is not None


def test_outcomes_of_a_run_agree_with_its_result():
    duty = DutyCycle(motion=recording(4, closed=False), load_mass=0.8, start_temperature=330.0)
    drive = DRIVES["motor2-gear4"]
    found = duty_cycle(drive, duty)
    assert float(outcomes.energy(drive, duty)) == pytest.approx(found.energy, rel=1e-4)
    assert float(outcomes.temperature(drive, duty)) == pytest.approx(
        found.heat["motor"].winding - duty.ambient, abs=0.02
    )


def test_what_repeats_does_not_apply_to_a_run():
    duty = DutyCycle(motion=recording(4, closed=False), load_mass=0.8)
    assert [policy.name for policy in policies(DRIVES["cobotic"], duty)] == ["as given", "chosen for the cycle"]
    with pytest.raises(ParameterError, match="a run starts in motion"):
        two_ways(DRIVES["cobotic"], duty)
    with pytest.raises(ParameterError, match="start_temperature does not apply to a cycle"):
        DutyCycle(motion=recording(1, closed=True), start_temperature=320.0)


@pytest.mark.parametrize(("name", "usual", "largest"), [("parabola", 4.0, 6.0), ("ramp and 1 Hz", 16.0, 25.0)])
def test_noise_counts_little_more_at_the_ends(name, usual, largest):
    """20 um of noise at 200 Hz: the largest error of the acceleration anywhere, over its RMS away from the ends."""
    chain = CLOSED_FORMS[name][1]
    time, at = np.linspace(0.0, 6.0, 1201), np.linspace(0.0, 6.0, 2001)
    inside = (at > 0.3) & (at < 5.7)
    worst = []
    for seed in range(12):
        values = chain(time)[0] + 2e-5 * np.random.default_rng(seed).standard_normal(time.size)
        off = np.abs(RunSeries.through(time, values, values, CUTOFF).derivatives(at, 2)[2] - chain(at)[2])
        worst.append(np.max(off) / np.sqrt(np.mean(off[inside] ** 2)))
    assert np.median(worst) < usual
    assert max(worst) < largest


def test_the_temperature_of_a_winding_can_be_the_tightest_limit():
    """A start 4 K below the limit leaves little: rises above ambient are compared."""
    duty = DutyCycle(
        motion=recording(4, closed=False), load_mass=0.8, start_temperature=MOTOR.max_winding_temperature - 4
    )
    found = duty_cycle(DRIVES["cobotic"], duty)
    hot = found.heat["motor"]
    allowed = hot.permissible - duty.ambient
    assert found.feasible
    assert found.tightest[0] == (iv.Limit.TEMPERATURE, "motor")
    assert found.tightest[1] == pytest.approx(allowed / (hot.winding - duty.ambient))
    assert 1.0 < found.tightest[1] < 1.06
    assert found.verdict.startswith("feasible; tightest limit: motor winding temperature (margin 1.0")
    beyond = duty_cycle(DRIVES["cobotic"], replace(duty, start_temperature=500.0))
    assert not beyond.feasible
    assert beyond.tightest[0] == (iv.Limit.TEMPERATURE, "motor")
    assert beyond.tightest[1] == pytest.approx(allowed / (500.0 - duty.ambient), rel=1e-3)
    mixed = mixed_use({"run": {"a": beyond}}, {"run": 1.0})
    assert "infeasible; tightest limit: motor winding temperature in run (margin 0." in mixed.verdict_on("a")


def test_no_ambient_above_the_limit_leaves_a_margin():
    duty = DutyCycle(motion=recording(1, closed=True), load_mass=0.8, ambient=MOTOR.max_winding_temperature + 10.0)
    assert duty_cycle(DRIVES["cobotic"], duty).tightest == ((iv.Limit.TEMPERATURE, "motor"), 0.0)
