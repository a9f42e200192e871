"""Heat in a motor: against the two-exponential solution, numerical integration and a data sheet."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import infinivar as iv
from infinivar import motors
from infinivar.parts import heat
from internals import heat_over as over
from internals import heat_windings as windings
from sampled import sampled

MOTOR = motors()["dc-max-26-s-24v"]
AMBIENT = 298.15


def exponentials(motor, current, friction, time):
    """The linear system of winding and housing solved by its two eigenvalues, from ambient."""
    matrix, vector = heat.rates(motor, current**2, friction, AMBIENT)
    values, vectors = (np.real(found) for found in np.linalg.eig(matrix[0]))  # which newer ones give as complex
    settled = -np.linalg.solve(matrix[0], vector[0])
    weights = np.linalg.solve(vectors, AMBIENT - settled)
    return settled + np.exp(np.multiply.outer(time, values)) * weights @ vectors.T


@pytest.mark.parametrize(("current", "friction"), [(0.5, 0.0), (1.0, 1.1), (1.5, 0.3)])
@pytest.mark.parametrize("period", [0.1, 7.0, 60.0])
def test_step_is_two_exponentials(current, friction, period):
    """Constant power: both temperatures at every time, to rounding."""
    found = heat.heat(MOTOR, current, friction, period)
    expected = exponentials(MOTOR, current, friction, found.time)
    np.testing.assert_allclose(found.winding_history, expected[:, 0], rtol=1e-9)
    np.testing.assert_allclose(found.housing_history, expected[:, 1], rtol=1e-9)


def test_cold_copper_gives_the_plain_resistances():
    """Where copper does not change, the winding is R_wh + R_ha of its power above ambient, friction through R_ha alone."""
    current, friction = 1e-3, 2.0
    found = heat.heat(MOTOR, current, friction, 1.0)
    joule = current**2 * MOTOR.resistance
    rise = joule * (MOTOR.winding_to_housing + MOTOR.housing_to_ambient) + friction * MOTOR.housing_to_ambient
    assert found.winding - AMBIENT == pytest.approx(rise, rel=1e-4)


@pytest.mark.slow
def test_long_cycle_against_integration():
    """A cycle of a minute with a burst: peak, housing and the time of passing, by SciPy step by step."""
    period, count = 60.0, 6000
    share = (np.arange(count) + 0.5) / count
    current = np.where(share < 0.3, 2.5, 0.3)
    friction = np.where(share < 0.3, 1.0, 0.2)
    found = heat.heat(MOTOR, current, friction, period)

    def slope(time, state):
        burst = time % period < 0.3 * period
        matrix, vector = heat.rates(MOTOR, 6.25 if burst else 0.09, 1.0 if burst else 0.2, AMBIENT)
        return matrix[0] @ state + vector[0]

    state, passed, winding = np.array([AMBIENT, AMBIENT]), math.inf, []
    for number in range(60):
        for start, end in ((0.0, 0.3 * period), (0.3 * period, period)):
            run = solve_ivp(
                slope,
                (number * period + start, number * period + end - 1e-9),
                state,
                max_step=0.5,
                rtol=1e-9,
                atol=1e-9,
            )
            state = run.y[:, -1]
            winding = [*winding[-2000:], *run.y[0]]
            above = np.flatnonzero(run.y[0] > MOTOR.max_winding_temperature)
            if above.size and passed == math.inf:
                passed = run.t[above[0]]
    assert found.time_to_limit == pytest.approx(passed, abs=0.6)  # the solver's steps are half a second
    assert found.winding == pytest.approx(max(winding[-300:]), abs=0.3)


def test_time_to_limit_is_on_the_curve():
    current, friction = 1.4, 1.1
    found = heat.heat(MOTOR, current, friction, 1.1)
    at = exponentials(MOTOR, current, friction, np.array([found.time_to_limit]))[0, 0]
    assert at == pytest.approx(MOTOR.max_winding_temperature, abs=0.02)
    assert not found.within_limit
    settled = exponentials(MOTOR, current, friction, np.array([1e6]))[0, 0] - 273.15
    assert found.verdict == f"winding reaches {settled:.0f} °C; limit 100 °C exceeded after 9 min"


def test_runaway_is_named():
    """Beyond the current at which copper's rise feeds itself nothing settles."""
    found = heat.heat(MOTOR, 4.0, 1.0, 1.0)
    assert found.winding == math.inf
    assert found.verdict == "winding temperature grows without bound; limit 100 °C exceeded after 15 s"
    assert 10 < found.time_to_limit < 20


@pytest.mark.parametrize("current", [4.0, 40.0, 4e3, 4e6])
@pytest.mark.parametrize("period", [1e-3, 1.0, 1e3, 1e6])
def test_runaway_reaches_the_limit_when_integration_says(current, period):
    """From the current at which nothing settles to absurd ones: when it passes, and the way there, without overflow."""
    found = heat.heat(MOTOR, np.full(100, current), 1.0, period)
    assert found.winding == found.housing == math.inf
    matrix, vector = heat.rates(MOTOR, current**2, 1.0, AMBIENT)
    run = solve_ivp(
        lambda time, state: matrix[0] @ state + vector[0],
        (0.0, 2.0 * found.time_to_limit),
        [AMBIENT, AMBIENT],
        method="Radau",
        rtol=1e-9,
        events=lambda time, state: state[0] - MOTOR.max_winding_temperature,
    )
    assert found.time_to_limit == pytest.approx(run.t_events[0][0], rel=1e-6)
    assert found.winding_history[-1] == pytest.approx(MOTOR.max_winding_temperature, rel=1e-8)
    assert np.all(np.diff(found.time) > 0)
    assert np.all(np.diff(found.winding_history) > 0)


@pytest.mark.parametrize("seed", range(40))
def test_any_cycle_is_judged(seed):
    """Bursts of any current in cycles of any length: finite curves, and a verdict that they bear out."""
    rng = np.random.default_rng(seed)
    motor = [motor for motor in motors().values() if not heat.missing(motor)][seed % 3]
    count = int(rng.choice([1, 2, 11, 100, 2000]))
    current = np.where(rng.random(count) < rng.random(), 10 ** rng.uniform(-3, 6), 0.0) * rng.random(count)
    ambient, period = rng.uniform(250, 350), 10 ** rng.uniform(-4, 6)
    found = heat.heat(motor, current, 10 ** rng.uniform(-3, 4), period, ambient)
    assert np.all(np.isfinite(found.winding_history))
    assert found.within_limit == (found.winding <= found.permissible * (1 + 1e-8))
    assert not np.isnan([found.winding, found.housing, found.mean_winding, found.time_to_limit]).any()


def bursts(motor, currents, times, friction, start=None):
    """Highest winding temperature of a cycle of currents [A], each for a time [s], or of one such run from a start [K].

    Written out and integrated by SciPy, piece by piece; a settled cycle starts where its end is (the equations are linear).
    """
    to_housing, to_ambient = motor.winding_to_housing, motor.housing_to_ambient
    winding, housing = motor.winding_time_constant / to_housing, motor.housing_time_constant / to_ambient

    def along(state):
        ends = [state]
        for current, time in zip(currents, times, strict=True):

            def slope(_, state, current=current):
                loss = current**2 * motor.resistance * (1.0 + 0.0039 * (state[0] - 298.15))
                inward = (state[0] - state[1]) / to_housing
                return [(loss - inward) / winding, (friction + inward - (state[1] - AMBIENT) / to_ambient) / housing]

            ends.append(solve_ivp(slope, (0.0, time), ends[-1], method="DOP853", rtol=1e-11, atol=1e-11).y[:, -1])
        return np.array(ends)

    begin = np.full(2, start)
    if start is None:
        none = along(np.zeros(2))[-1]
        cycle = np.stack([along(unit)[-1] - none for unit in np.eye(2)], axis=1)
        begin = np.linalg.solve(np.eye(2) - cycle, none)
    return along(begin)[:, 0].max()


@sampled(
    ("key", "period", "share", "count"),
    [
        ("dc-max-26-s-24v", 0.05, 0.0933, 2000),
        ("dc-max-26-s-24v", 60.0, 0.0933, 400),
        ("dc-max-26-s-24v", 300.0, 0.05, 2000),
        ("ec-45-flat-24v-397172", 125.23, 0.09, 400),
        ("dcx-19-s-24v", 138.2, 0.0915, 2000),
        ("ec-max-30-24v", 1481.0, 0.01, 100),
        ("ec-90-flat-24v", 3.31, 0.0905, 2000),
    ],
    every=4,
)
def test_bursts_of_three_times_the_continuous_current(key, period, share, count):
    """At 3.2 times of it, and a tenth otherwise: settled cycles and runs from ambient, on every way to the temperature.

    0.08 K with steps of many instants, at most an eighth of a cycle; 1e-6 K where every instant is a step.
    """
    motor, friction = motors()[key], 0.1
    burst = round(share * count) / count
    levels = 3.2 * motor.continuous_current, 0.1 * motor.continuous_current
    current = np.where(np.arange(count) < round(share * count), *levels)
    rubbed = np.full(count, friction)
    for start in (None, AMBIENT):
        expected = bursts(motor, levels, (burst * period, (1.0 - burst) * period), friction, start)
        if start is None:
            found, other = heat.heat(motor, current, friction, period), heat.settled(motor, current, rubbed, period)
        else:
            found = heat.heat_over_run(motor, current, friction, period)
            other = heat.through_run(motor, current, rubbed, period, ambient=AMBIENT, start=start)
        many = windings(motor, current[None], rubbed[None], period, AMBIENT, start)
        assert found.winding == pytest.approx(expected, abs=0.08)
        assert other[0][0] == pytest.approx(expected, abs=1e-6)
        assert found.mean_winding == pytest.approx(other[1][0], abs=0.02)
        assert many.highest[0] == pytest.approx(found.winding, rel=1e-12)
        hot = replace(motor, max_winding_temperature=expected - 0.3)
        again = (heat.heat if start is None else heat.heat_over_run)(hot, current, friction, period)
        assert not again.within_limit


@sampled("period", [0.1, 5.0, 300.0, 3e4], every=4)
def test_settled_cycles_of_any_length(period):
    """Of many of the winding's time constants, too, where exponentials overflowed; and motors that never settle."""
    current = np.where(np.arange(2000) < 700, 0.9, 0.2)
    found = heat.heat(MOTOR, current, 0.3, period)
    highest, mean = heat.settled(MOTOR, current, np.full(2000, 0.3), period)
    assert highest[0] == pytest.approx(found.winding, abs=0.02)
    assert mean[0] == pytest.approx(found.mean_winding, abs=0.02)
    many = np.array([[1.0], [10.0], [1e3], [1e6]]) * current
    highest, mean = heat.settled(MOTOR, many, np.full((4, 2000), 0.3), period)
    assert np.isfinite([highest[0, 0], mean[0, 0]]).all()
    assert np.isinf(highest[1:]).all()
    assert np.isinf(mean[1:]).all()


def test_nominal_current_heats_to_about_what_is_permissible():
    """The data sheet's nominal point (1.08 A at 8100 rpm) should bring the winding near its 100 C: 92 C, friction included.

    Source: maxon2020. Tolerance 10 K: the sheet rounds resistances, and says nothing of where friction goes.
    """
    speed = 8100 * 2 * math.pi / 60
    found = heat.heat(MOTOR, 1.08, MOTOR.friction_torque * speed, 1.0)
    assert found.winding - 273.15 == pytest.approx(100, abs=10)
    assert found.within_limit


def test_hot_start_passes_at_once():
    found = heat.heat(MOTOR, 0.1, 0.0, 1.0, ambient=400.0)
    assert found.time_to_limit == 0.0


def test_missing_data_is_named():
    with pytest.raises(ValueError, match="housing_time_constant is missing: the thermal model needs it"):
        heat.heat(replace(MOTOR, housing_time_constant=None), 1.0, 0.0, 1.0)


def test_warm_copper():
    """Copper at 100 C has 1 + 0.0039 x 75 of its resistance at 25 C (maxon2020)."""
    assert heat.warm(MOTOR, 373.15).resistance == pytest.approx(MOTOR.resistance * 1.2925)
    assert isinstance(heat.warm(MOTOR, 373.15), iv.parts.Motor)


@pytest.mark.parametrize("period", [1.0, 600.0, 86400.0, 1e19])
def test_long_steps_are_exact_too(period):
    """A constant power in a cycle of any length: the same settled state, and the same time until the limit."""
    current, friction = 1.4, 1.1
    found = heat.heat(MOTOR, np.full(2000, current), friction, period)
    settled = exponentials(MOTOR, current, friction, np.array([1e6]))[0]
    assert (found.winding, found.housing) == pytest.approx(
        tuple(settled), rel=1e-7
    )  # over the longest steps expm leaves 6e-9
    at = exponentials(MOTOR, current, friction, np.array([found.time_to_limit]))[0, 0]
    assert at == pytest.approx(MOTOR.max_winding_temperature, rel=1e-6)


@pytest.mark.parametrize("key", ["dcx-16-l-24v", "dcx-35-l-24v", "ec-4pole-30-24v"])
def test_the_closed_form_is_the_matrix_exponential(key):
    from scipy.linalg import expm

    motor, random = motors()[key], np.random.default_rng(5)
    # From a tenth of the continuous current to ten times of it: beyond the first few, temperatures run away.
    current = motor.continuous_current * np.logspace(-1, 1, 40)
    matrix, vector = heat.rates(motor, current**2, random.uniform(0.0, 3.0, 40), 298.15)
    time = 10.0 ** random.uniform(-4, 1, 40) / np.abs(np.linalg.eigvals(matrix)).max(axis=-1)
    generators = np.zeros((40, 3, 3))
    generators[:, :2, :2], generators[:, :2, 2] = matrix, vector
    maps = over(generators, time)
    np.testing.assert_allclose(maps[:, :2, :2], expm(matrix * time[:, None, None]), rtol=1e-9, atol=1e-14)
    # A int_0^t exp(A s) b ds = (exp(A t) - 1) b
    gained = np.einsum("nij,nj->ni", maps[:, :2, :2] - np.eye(2), vector)
    size = np.abs(gained).max(axis=1, keepdims=True)
    np.testing.assert_allclose(np.einsum("nij,nj->ni", matrix, maps[:, :2, 2]) / size, gained / size, atol=1e-9)
    np.testing.assert_array_equal(maps[:, 2], np.tile([0.0, 0.0, 1.0], (40, 1)))
    np.testing.assert_allclose(over(generators[0], 0.0), np.eye(3), atol=1e-15)


def test_many_motors_at_once_are_as_hot_as_each_alone():
    """Settled cycles and runs, one of them of a motor that never settles: the same temperatures to rounding."""
    random = np.random.default_rng(5)
    times = np.arange(200)
    cycles = 1.0 + random.uniform(-0.5, 0.5, (4, 1)) * np.sin(0.1 * times) + np.array([[0.0], [0.5], [1.0], [9.0]])
    rubbed = random.uniform(0.1, 0.5, (4, 200))
    lags = np.array([[12.0], [11.0], [14.0], [12.5]])
    many = replace(MOTOR, winding_time_constant=lags)
    for run in (False, True):
        options = {"start": 320.0} if run else {}
        found = windings(many, cycles, rubbed, 0.9, AMBIENT, **options)
        for place in range(4):
            one = replace(MOTOR, winding_time_constant=float(lags[place, 0]))
            alone = (heat.heat_over_run if run else heat.heat)(
                one, cycles[place], rubbed[place], 0.9, ambient=AMBIENT, **options
            )
            assert found.highest[place] == pytest.approx(alone.winding, rel=1e-12)
            assert found.mean[place] == pytest.approx(alone.mean_winding, rel=1e-12)
            if run:
                np.testing.assert_allclose(found.history[place], alone.winding_history, rtol=1e-12)
        assert run or found.highest[3] == math.inf


@pytest.mark.parametrize("number", [2, 3, 7.5])
def test_motors_on_one_shaft_are_as_hot_as_each_alone(number):
    """Each has its share of current and friction; the time constants stay."""
    motor = motors()["ec-i-40-36v"]
    current = 1.5 * motor.continuous_current * np.sin(np.linspace(0.0, 6.0, 40))
    one = heat.heat(motor, current, 0.4 + 0.0 * current, 2.0)
    many = heat.heat(motor.scaled(number), number * current, number * (0.4 + 0.0 * current), 2.0)
    for name in ("winding", "housing", "mean_winding"):
        assert getattr(many, name) == pytest.approx(getattr(one, name), rel=1e-12)
    assert many.within_limit == one.within_limit


def test_motors_on_one_shaft_lie_in_line():
    motor = replace(motors()["ec-i-40-36v"], length=0.03)
    three = motor.scaled(3)
    assert (three.diameter, three.length) == (motor.diameter, pytest.approx(0.09))
    assert motor.scaled(1) == replace(motor, name=f"1 x {motor.name}")
    part = motor.scaled(2.7)
    assert (part.diameter, part.length) == (None, None)


class TestUpToATime:
    """`highest_until`: constant power against two exponentials, a burst against single steps, and both ends of time."""

    @pytest.mark.parametrize("period", [0.5, 7.0, 1e4])
    def test_constant_power_is_two_exponentials(self, period):
        for time in (0.0, 3.0, 90.0, 1234.5):
            found = heat.highest_until(MOTOR, np.full(1000, 1.0), 0.4, period, time)
            # Up to the end of the last instant of the cycle, of which there are a thousand.
            low, high = exponentials(MOTOR, 1.0, 0.4, np.array([max(time - period / 1000, 0.0), time]))[:, 0]
            assert low * (1 - 1e-12) <= found <= high * (1 + 1e-12)

    def test_a_burst_step_by_step(self):
        """Cycles of a minute: the peak lies at the end of the burst, and stays the highest until the next burst."""
        period, count = 60.0, 600
        current = np.where((np.arange(count) + 0.5) / count < 0.3, 2.5, 0.3)
        state, ends, winding = np.array([AMBIENT, AMBIENT, 1.0]), [0.0], [AMBIENT]
        for number in range(5):
            for place, amperes in enumerate(current):
                matrix, vector = heat.rates(MOTOR, amperes**2, 0.5, AMBIENT)
                generator = np.zeros((3, 3))
                generator[:2, :2], generator[:2, 2] = matrix[0], vector[0]
                state = over(generator, period / count) @ state
                ends.append(number * period + (place + 1) * period / count)
                winding.append(state[0])
        for time in (9.05, 30.05, 75.05, 299.95):
            expected = max(one for end, one in zip(ends, winding, strict=True) if end <= time)
            found = heat.highest_until(MOTOR, current, 0.5, period, time)
            # Steps of constant power stand for several instants each.
            assert found - AMBIENT == pytest.approx(expected - AMBIENT, rel=2e-3)

    def test_late_is_settled(self):
        current = np.linspace(0.0, 2.0, 50)
        settled = heat.heat(MOTOR, current, 0.2, 3.0).winding
        assert heat.highest_until(MOTOR, current, 0.2, 3.0, 1e7) == pytest.approx(settled, rel=1e-12)

    def test_a_run_ends_warm_and_a_motor_that_runs_away_has_no_bound(self):
        current = np.linspace(3.0, 0.5, 400)
        run = heat.heat_over_run(MOTOR, current, 0.2, 50.0, start=310.0)
        found = heat.highest_until(MOTOR, current, 0.2, 50.0, 50.0, start=310.0)
        assert found == pytest.approx(run.winding, rel=1e-12)
        assert heat.highest_until(MOTOR, 50.0, 0.0, 1.0, 1e6) == math.inf
