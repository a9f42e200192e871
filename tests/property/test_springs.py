"""Springs, hysteresis and linkages: derivatives and energies of every law, and power balances of whole drives behind them."""

from dataclasses import replace

import numpy as np
import pytest
from designs import POINTS, seeds
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.optimize import brentq
from test_motion import cobotic_drives, conventional_drives

import infinivar as iv
from infinivar import Limit, Output
from infinivar.motion import Course
from infinivar.parts import Linkage, Spring, TorsionSpring
from internals import FourierSeries as Series
from internals import chain, elastic
from internals import parts_history as history
from sampled import examples

TABLE = {"deflections": (-0.03, -0.01, 0.0, 0.01, 0.02, 0.04), "forces": (-400.0, -90.0, 0.0, 90.0, 220.0, 700.0)}
SPRINGS = {
    "linear": Spring(stiffness=1e4, preload=3.0, rest=0.01),
    "progressive": Spring(shape="progressive", **TABLE, preload=5.0, rest=0.002),
    "one-sided": Spring(shape="one-sided", stiffness=1e5, rest=0.01, contact_width=1e-3),
    "one-sided, preloaded": Spring(shape="one-sided", stiffness=1e5, rest=0.01, preload=40.0, contact_width=1e-3),
    "torsion": TorsionSpring(shape="one-sided", stiffness=100.0, rest=0.005, contact_width=2e-3),
}
LINKAGES = {
    "lever": Linkage(arm=0.05),
    "table": Linkage(
        shape="table", angles=(-1.0, -0.4, 0.1, 0.5, 1.1, 1.5), arms=(0.03, 0.04, 0.045, 0.046, 0.04, 0.03)
    ),
    "crank": Linkage(shape="crank", arm=0.05, base=0.3, offset=1.5),
    "four-bar": Linkage(shape="four-bar", arm=0.04, base=0.2, crank=0.03, coupler=0.21, offset=1.4),
}
LARGEST = 0.4
"""Largest joint angle within the range of every linkage. [rad]"""


def difference(function, at, step):
    """Derivative by central differences of fourth order."""
    return (function(at - 2 * step) - 8 * function(at - step) + 8 * function(at + step) - function(at + 2 * step)) / (
        12 * step
    )


@pytest.mark.parametrize("name", SPRINGS)
def test_derivatives_and_energy_of_springs(name):
    spring = SPRINGS[name]
    at = np.linspace(-0.02, 0.035, 37) + 1e-5
    found = [np.broadcast_to(row, at.shape) for row in spring.derivatives(at, 5)]
    for order, row in enumerate(found[1:]):
        expected = difference(lambda x, order=order: spring.derivatives(x, order)[order], at, 1e-5)
        assert_allclose(row, expected, rtol=1e-6, atol=1e-6 * np.max(np.abs(row)) + 1e-3)
    assert_allclose(difference(spring.energy, at, 1e-5), found[0], atol=1e-7 * np.max(np.abs(found[0])))
    assert np.all(np.diff(found[0]) >= 0)


@pytest.mark.parametrize("name", SPRINGS)
def test_deflection_is_the_inverse_of_force(name):
    spring = SPRINGS[name]
    at = np.linspace(0.012, 0.06, 37)
    force = spring.force(at)
    assert_allclose(spring.deflection(force), at, rtol=1e-12)
    found = [np.broadcast_to(row, at.shape) for row in spring.deflection_derivatives(force, 4)]
    for order, row in enumerate(found[1:]):
        step = 1e-4 * force
        expected = difference(lambda f, order=order: spring.deflection_derivatives(f, order)[order], force, step)
        assert_allclose(row, expected, rtol=1e-5, atol=1e-6 * np.max(np.abs(row)) + 1e-15)


def test_a_table_is_followed_and_continued_along_its_tangents():
    spring = Spring(shape="progressive", **TABLE)
    assert_allclose(spring.force(np.array(TABLE["deflections"])), TABLE["forces"], atol=1e-10)
    value, slope = spring.derivatives(np.array([0.04, 0.05]), 1)
    assert_allclose(value[1], value[0] + 0.01 * slope[0], rtol=1e-9)
    assert_allclose(spring.demand(np.array([-0.03, 0.005, 0.04, 0.075])), [1.0, 0.0, 1.0, 2.0], atol=1e-12)


def test_a_one_sided_series_spring_cannot_pull():
    spring = replace(SPRINGS["one-sided"], rest=0.0)
    assert_allclose(spring.pull_demand(np.array([-10.0, 0.0, 10.0])), [1.099, 0.999, 0.899], rtol=1e-12)
    loose = spring.deflection_derivatives(np.array([-5.0, 0.0]), 2)
    assert loose[0][0] == loose[0][1] < 0
    assert_allclose(loose[1:], 0.0)


@pytest.mark.parametrize("name", ["one-sided", "one-sided, preloaded", "torsion"])
def test_a_one_sided_spring_on_the_negative_side_is_the_mirror_image(name):
    spring = replace(SPRINGS[name], rest=0.0)
    mirrored = replace(spring, side="negative", rest=0.004)
    since, force = np.linspace(-0.03, 0.03, 41), np.linspace(-20.0, 80.0, 41)
    for order, (row, other) in enumerate(
        zip(spring.derivatives(since, 5), mirrored.derivatives(0.004 - since, 5), strict=True)
    ):
        assert_allclose(other, (-1.0) ** (order + 1) * row, rtol=1e-9, atol=1e-12 * np.max(np.abs(row)))
    assert_allclose(mirrored.energy(0.004 - since), spring.energy(since), rtol=1e-10)
    rows = zip(spring.deflection_derivatives(force, 4), mirrored.deflection_derivatives(-force, 4), strict=True)
    for order, (row, other) in enumerate(rows):
        assert_allclose(other - (0.004 if order == 0 else 0.0), (-1.0) ** (order + 1) * row, rtol=1e-9, atol=1e-15)
    assert_allclose(mirrored.pull_demand(-force), spring.pull_demand(force))
    with pytest.raises(iv.ParameterError, match="side does not apply with shape = 'linear'"):
        Spring(stiffness=1e3, side="negative")


forces = st.floats(0.1, 100)


@given(forces, st.floats(1e-5, 1e-2), seeds)
def test_hysteresis_never_creates_energy(largest, presliding, seed):
    """z x' is stored or lost at every state, and no way makes z larger than its bound."""
    random = np.random.default_rng(seed)
    state, speed = largest * random.uniform(-1, 1, POINTS), random.uniform(-1, 1, POINTS)
    speed[:9] = 0.0
    lost, stored = elastic.loss(state, speed, largest), elastic.stored(state, speed, largest, presliding)
    assert np.all(lost >= 0)
    assert_allclose(lost + stored, state * speed, atol=1e-12 * largest)
    after = elastic.after(state, presliding * random.uniform(-9, 9, POINTS), largest, presliding)
    assert np.all(np.abs(after) <= largest)


def test_hysteresis_force_follows_its_slope():
    state, way = np.linspace(-2.0, 2.0, 11), np.linspace(1e-4, 3e-3, 7)[:, None]
    for sign in (-1.0, 1.0):
        found = elastic.derivatives(elastic.after(state, sign * way, 2.0, 1e-3), np.float64(sign), 2.0, 1e-3, 4)
        for order, row in enumerate(found[1:]):

            def lower(x, order=order, sign=sign):
                return elastic.derivatives(elastic.after(state, x, 2.0, 1e-3), np.float64(sign), 2.0, 1e-3, order)[
                    order
                ]

            assert_allclose(row, difference(lower, sign * way, 1e-6), rtol=1e-6, atol=1e-6 * np.max(np.abs(row)))


@pytest.mark.parametrize("closes", [True, False])
@pytest.mark.parametrize("name", ["linear", "progressive"])
def test_series_hysteresis_is_that_of_the_deflection_it_finds(name, closes):
    """The force found along the deflection that belongs to a force is that force."""
    spring = replace(SPRINGS[name], hysteresis=20.0)
    time = (np.arange(900) + 0.5) / 900
    force = 60.0 * np.sin(2 * np.pi * time) + 35.0 * np.sin(6 * np.pi * time + 0.4)
    deflection, state = history.under_forces(spring, force, closes)
    assert_allclose(spring.force(deflection) + state, force, atol=1e-9)
    again = history.along_positions(spring, deflection, closes)
    assert_allclose(again, state, atol=1e-6)
    assert np.max(np.abs(state)) <= 20.0
    if not closes:
        assert state[0] == 0.0


def test_series_hysteresis_of_sampled_springs_is_that_of_each():
    """Values of a sampled spring broadcast with forces that are the same, or differ, from one to the next."""
    force = 60.0 * np.sin(2 * np.pi * (np.arange(50) + 0.5) / 50)
    drawn = {"stiffness": np.array([[0.9e4], [1.0e4], [1.2e4]]), "hysteresis": np.array([[20.0], [15.0], [30.0]])}
    springs = [replace(SPRINGS["linear"], **{key: row[k, 0] for key, row in drawn.items()}) for k in range(3)]
    sampled = replace(SPRINGS["linear"], **drawn)
    each = np.array([history.under_forces(one, force, True) for one in springs])
    assert_allclose(history.under_forces(sampled, force, True), np.moveaxis(each, 1, 0), rtol=1e-14)
    several = np.array([[[0.5]], [[1.0]]]) * force
    both = history.under_forces(sampled, several, True)
    assert both[0].shape == (2, 3, 50)
    assert_allclose([both[0][1], both[1][1]], np.moveaxis(each, 1, 0), rtol=1e-14)


@pytest.mark.parametrize("start", [0.0, 0.125])
@pytest.mark.parametrize(("largest", "presliding"), [(5.0, 0.1), (5000.0, 1.0), (5.0, 1e-9), (10.0, 1e-5), (2.0, 1e-6)])
def test_series_hysteresis_repeats_itself_in_a_closed_cycle(largest, presliding, start):
    """Against the closed loop of Dahl's law, also where a cycle forgets little of the state, from any start.

    Between reversals z = F_c - (F_c + z_0) exp(-d/x_s), so a symmetric loop has z_0 = F_c tanh(D/2x_s) at its ends; the spring
    itself makes k D + 2 z_0 = 2 A.
    """
    amplitude, stiffness = 3.16, 5e3
    spring = Spring(stiffness=stiffness, hysteresis=largest, presliding=presliding)
    force = 7.0 + amplitude * np.sin(2 * np.pi * ((np.arange(2000) + 0.5) / 2000 - start))
    deflection, state = history.under_forces(spring, force, closes=True)
    reach = np.ptp(force) / 2.0
    stroke = brentq(
        lambda d: stiffness * d + 2.0 * largest * np.tanh(d / (2.0 * presliding)) - 2.0 * reach,
        0.0,
        2.0 * reach / stiffness,
        xtol=1e-24,
        rtol=1e-14,
    )
    end = largest * np.tanh(stroke / (2.0 * presliding))
    lost = 2.0 * (largest * stroke + (largest + end) * presliding * np.expm1(-stroke / presliding))
    assert_allclose(deflection.max() - deflection.min(), stroke, rtol=1e-6 if presliding > 1e-8 else 1e-4)
    assert_allclose([state.min(), state.max()], [-end, end], rtol=1e-6)
    assert_allclose((deflection.max() + deflection.min()) / 2, 7.0 / stiffness, rtol=1e-9)
    middle = 0.5 * (state + np.roll(state, 1))
    assert_allclose(np.sum(middle * (deflection - np.roll(deflection, 1))), lost, rtol=1e-3)


@pytest.mark.parametrize("name", LINKAGES)
def test_derivatives_of_linkages(name):
    linkage = LINKAGES[name]
    at = np.linspace(-LARGEST, LARGEST, 23)
    found = [np.broadcast_to(row, at.shape) for row in linkage.derivatives(at, 6)]
    assert np.all(found[1] > 0)
    assert np.all(linkage.demand(at) < 1)
    for order, row in enumerate(found[1:]):
        expected = difference(lambda x, order=order: linkage.derivatives(x, order)[order] + 0.0 * x, at, 1e-4)
        assert_allclose(row, expected, rtol=1e-6, atol=1e-7 * np.max(np.abs(row)) + 1e-9 + 2e-5 * (name == "table"))


def test_a_linkage_ends_at_its_dead_centre():
    crank = LINKAGES["crank"]
    assert_allclose(crank.demand(np.array([-1.5, np.pi / 2 - 1.5, np.pi - 1.5])), [1.0, 0.0, 1.0], atol=1e-3)
    assert list(crank.beyond_reach(np.array([-1.5, np.pi / 2 - 1.5, np.pi - 1.5]))) == [True, False, True]
    # The demand says how far beyond, over 90 degrees.
    beyond = np.radians([10.0, 45.0, 90.0])
    assert_allclose(crank.demand(np.pi - 1.5 + beyond), 1.0 + np.array([10.0, 45.0, 90.0]) / 90.0, atol=1e-3)
    assert_allclose(crank.demand(-1.5 - beyond), 1.0 + np.array([10.0, 45.0, 90.0]) / 90.0, atol=1e-3)
    assert_allclose(crank.position(np.array([-1.5, np.pi - 1.5])), [0.25, 0.35], rtol=1e-12)
    bars = LINKAGES["four-bar"]
    at = np.linspace(-1.5, 1.5, 301)
    out = bars.demand(at) > 1
    assert out[0]
    assert out[-1]
    assert not out[150]
    parallel = Linkage(shape="four-bar", arm=0.04, base=0.2, crank=0.04, coupler=0.2, offset=1.4)
    assert_allclose(parallel.position(at[50:150]), at[50:150] + 1.4, atol=1e-12)


@st.composite
def springs(draw, kind=Spring, series=False):
    """A spring of any shape whose forces suit loads of about 50 N, or moments of about 5 N m."""
    scale, length = (50.0, 0.05) if kind is Spring else (5.0, 0.5)
    stiffness = scale / length * draw(st.floats(0.3, 30))
    hysteresis = draw(st.one_of(st.none(), st.floats(0.01, 0.3).map(lambda share: share * scale)))
    shape = draw(st.sampled_from(["linear", "progressive"] + ([] if series else ["one-sided"])))
    at = "load" if series else draw(st.sampled_from(["load", "drive"]))
    rest = length * draw(st.floats(-0.5, 0.5))
    if shape == "linear":
        preload = 0.0 if series else scale * draw(st.floats(-0.5, 0.5))
        return kind(stiffness=stiffness, rest=rest, preload=preload, hysteresis=hysteresis, at=at)
    if shape == "one-sided":
        side = draw(st.sampled_from([None, "positive", "negative"]))
        preload = scale * draw(st.floats(0, 0.5))
        return kind(shape=shape, stiffness=stiffness, rest=rest, preload=preload, at=at, side=side)
    rows = np.array([-2.0, -1.0, 0.0, 1.0, 2.0, 3.0])
    curve = rows + draw(st.floats(0, 0.1)) * rows**3
    table = {"deflections": tuple(length * rows), "forces": tuple(stiffness * length * curve)}
    return kind(shape=shape, **table, rest=rest, hysteresis=hysteresis, at=at)


@st.composite
def outputs(draw):
    """Any of the springs, and a linkage that a linear drive can have, or none."""
    linkage = draw(st.one_of(st.none(), st.sampled_from([LINKAGES[name] for name in ("lever", "table", "crank")])))
    named = {
        "parallel_spring": draw(st.one_of(st.none(), springs())),
        "series_spring": draw(st.one_of(st.none(), springs(series=True))),
    }
    if linkage is not None:
        named |= {
            "parallel_torsion_spring": draw(st.one_of(st.none(), springs(TorsionSpring))),
            "series_torsion_spring": draw(st.one_of(st.none(), springs(TorsionSpring, series=True))),
        }
    return Output(linkage=linkage, **named)


def assert_closed(power_in, power_out, *flows):
    total = np.abs(power_in) + np.abs(power_out) + sum(np.abs(flow) for flow in flows)
    assert np.all(np.abs(power_in - power_out - sum(flows)) <= 1e-11 * total + 1e-300)


INSTANTS = 200
"""Of a random course: 3,000 in all examples. Each is nearly a reversal, from which hysteresis is solved anew."""


def random_course(seed, rotary):
    """Instants in all four quadrants, with some at rest and some that start from rest, as a course in order of time."""
    random = np.random.default_rng(seed)
    size, force = (LARGEST, 5.0) if rotary else (0.05, 50.0)
    rows = [size * random.uniform(-1, 1, INSTANTS) * 3.0**order for order in range(7)]
    rows[1][:50], rows[2][:25] = 0.0, 0.0
    pushes = [force * random.uniform(-1, 1, INSTANTS) * 3.0**order for order in range(5)]
    for row in pushes[1:]:
        row[:25] = 0.0
    names = ("position", "speed", "acceleration", "jerk", "snap", "fifth", "sixth")
    named = ("force", "force_rate", "force_curvature", "force_third", "force_fourth")
    return Course(**dict(zip(names, rows, strict=True)), **dict(zip(named, pushes, strict=True)))


@examples(15)
@given(st.one_of(conventional_drives(), cobotic_drives()), outputs(), st.floats(0, 2), seeds)
def test_power_balance_of_drives_behind_springs_and_linkages(drive, output, mass, seed):
    """At every instant, driven, back-driven and at rest; no loss is below zero."""
    drive = replace(drive, output=output)
    rotary = drive.axis.rotary
    point = drive.follow(random_course(seed, rotary), load_mass=mass * (0.01 if rotary else 1.0))
    shape = (INSTANTS,)
    power_in, power_out = np.broadcast_to(point.power_in, shape), np.broadcast_to(point.power_out, shape)
    flows = [np.broadcast_to(flow, shape) for flow in (*point.losses.values(), *point.stored.values())]
    moves = np.isfinite(power_in)
    assert_closed(power_in[moves], power_out[moves], *(flow[moves] for flow in flows))
    scale = np.abs(power_in) + np.abs(power_out) + sum(np.abs(flow) for flow in flows)
    for loss in point.losses.values():
        assert np.all((np.broadcast_to(loss, shape) >= -1e-11 * scale)[moves])


@examples(15)
@given(st.one_of(conventional_drives(), cobotic_drives()), outputs(), seeds)
def test_power_balance_of_maps_at_a_position(drive, output, seed):
    drive = replace(drive, output=output)
    random = np.random.default_rng(seed)
    size, force = (LARGEST, 5.0) if drive.axis.rotary else (0.05, 50.0)
    speed = random.uniform(-2, 2, POINTS)
    speed[:20] = 0.0
    point = drive.operate(
        speed=speed, force=force * random.uniform(-1, 1, POINTS), position=size * random.uniform(-1, 1, POINTS)
    )
    moves = np.isfinite(np.broadcast_to(point.power_in, speed.shape))
    flows = [np.broadcast_to(flow, speed.shape)[moves] for flow in point.losses.values()]
    assert all(np.all(flow >= -1e-9) for flow in flows)
    power_in, power_out = (np.broadcast_to(power, speed.shape)[moves] for power in (point.power_in, point.power_out))
    assert_closed(power_in, power_out, *flows)


SMOOTH = {
    "series": Output(series_spring=SPRINGS["progressive"]),
    "both": Output(
        series_spring=SPRINGS["linear"], parallel_spring=replace(SPRINGS["one-sided, preloaded"], contact_width=4e-3)
    ),
    "joint": Output(
        linkage=LINKAGES["crank"],
        parallel_spring=Spring(stiffness=300.0, rest=0.3),
        series_spring=Spring(shape="progressive", **TABLE),
        parallel_torsion_spring=TorsionSpring(stiffness=3.0),
        series_torsion_spring=TorsionSpring(stiffness=40.0),
    ),
}


@pytest.mark.parametrize("name", SMOOTH)
def test_motion_on_the_drives_side_has_its_own_derivatives(name):
    """Position and force of the drive, differentiated by a Fourier series, are the derivatives found by the chain rule."""
    output = SMOOTH[name]
    joint = output.linkage is not None
    size = {"angle": 0.35} if joint else {"distance": 0.02}
    duty = iv.DutyCycle(motion=iv.motion.Sinusoid(**size, frequency=1.3))
    axis = duty.axis
    instants = duty.instants(2000, 6)
    found = chain.inward(output.chain, instants.course, 0.02 if joint else 4.0, axis, (4, 2))
    course = found.course
    for rows in (
        (course.position, course.speed, course.acceleration, course.jerk, course.snap),
        (course.force, course.force_rate, course.force_curvature),
    ):
        even = Series.through(duty.period, np.asarray(rows[0]), 120 / duty.period)
        shift = 0.5 * duty.period / 2000
        expected = even.derivatives(instants.time - shift, len(rows) - 1)
        for row, truth in zip(rows, expected, strict=True):
            assert_allclose(row, truth, atol=1e-5 * np.max(np.abs(truth)))


UNREACHABLE = {
    "through its dead centre": Linkage(shape="crank", arm=0.05, base=0.2, offset=0.0),
    "folded": Linkage(shape="crank", arm=0.2, base=0.2, offset=0.0),
    "up to its dead centre": Linkage(shape="crank", arm=0.05, base=0.2, offset=np.radians(10.0)),
    "too short": Linkage(shape="four-bar", crank=0.06, coupler=0.15, arm=0.08, base=0.2, offset=np.radians(50.0)),
}


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("name", UNREACHABLE)
def test_out_of_reach_no_energy_is_stated(name):
    """Where bars are in line no force of the drive moves the load: LINKAGE leads, and powers are nan, as in slip."""
    linkage = UNREACHABLE[name]
    geared = iv.load_study("studies/hand_controller.toml").drives["motor2-gear4"]
    if linkage.rotary_drive:
        geared = replace(geared, pulley=None, shaft=iv.parts.Shaft(), guideway=iv.parts.Guideway())
    drive = replace(geared, output=Output(linkage=linkage))
    duty = iv.DutyCycle(motion=iv.motion.Sinusoid(angle=np.radians(10.0), frequency=1.0), load_inertia=0.01)
    found = iv.duty_cycle(drive, duty)
    assert found.exceeded[0] == (Limit.LINKAGE, "linkage")
    assert found.tightest[0] == (Limit.LINKAGE, "linkage")
    assert np.isnan(found.energy)
    assert " J" not in found.verdict
    assert "linkage range" in found.verdict
    if name != "too short":
        lowest = 0.0 if name != "up to its dead centre" else -np.radians(10.0)
        point = drive.operate(speed=1.0, force=1.0, position=lowest)
        assert point.limit == Limit.LINKAGE
        assert np.isnan(point.power_in)
        assert np.isnan(point.power_out)
        start = {"start": 0.25} if lowest else {}
        motion = iv.motion.Sinusoid(angle=np.radians(10.0), frequency=1.0, **start)
        with pytest.raises(iv.ParameterError, match="at or beyond a dead centre of the drive's linkage"):
            iv.simulate(drive, iv.Scenario(duration=0.5, motion=motion, load_inertia=0.01))


def test_limits_name_spring_and_linkage():
    drive = iv.load_study("studies/hand_controller.toml").drives["cobotic"]
    joint = replace(drive, output=Output(linkage=LINKAGES["crank"]))
    duty = iv.DutyCycle(motion=iv.motion.Sinusoid(angle=1.7, frequency=0.1))
    found = iv.duty_cycle(joint, duty)
    assert not found.feasible
    assert found.demands[Limit.LINKAGE, "linkage"] > 1
    assert found.exceeded[0][0] == Limit.LINKAGE
    stiff = replace(drive, output=Output(parallel_spring=Spring(shape="progressive", **TABLE)))
    found = iv.duty_cycle(stiff, iv.DutyCycle(motion=iv.motion.Sinusoid(distance=0.05, frequency=0.1)))
    assert found.demands[Limit.SPRING, "parallel spring"] == pytest.approx(0.055 / 0.035, rel=1e-3)


def test_zero_stands_for_none():
    """Hysteresis, backlash, iron loss and the stiffness of a parallel spring may be swept from zero on."""
    drive = iv.load_study("studies/hand_controller.toml").drives["motor2-gear4"]
    duty = iv.DutyCycle(motion=iv.motion.Sinusoid(distance=0.01, frequency=2.0), load_mass=1.0)

    def energy(output=None, **changes):
        return iv.duty_cycle(replace(drive, output=output or Output(), **changes), duty).energy

    series = Spring(stiffness=5e3)
    assert energy(Output(parallel_spring=Spring(stiffness=0.0))) == energy()
    for spring in (series, Spring(stiffness=5e3, preload=2.0)):
        none = replace(spring, hysteresis=0.0)
        assert energy(Output(series_spring=none)) == energy(Output(series_spring=spring))
        assert energy(Output(parallel_spring=none)) == energy(Output(parallel_spring=spring))
    motor = replace(drive.motor, viscous_friction=0.0)
    assert energy(motor=motor) == pytest.approx(energy(), rel=1e-14)
    elastic = replace(drive.gearhead, stiffness=50.0)
    scenario = iv.Scenario(duration=0.02, motion=duty.motion, load_mass=1.0)
    one, other = (
        iv.simulate(replace(drive, gearhead=gearhead, motor=each), scenario)
        for gearhead, each in ((elastic, drive.motor), (replace(elastic, backlash=0.0), motor))
    )
    assert_allclose(other.columns["position_m"], one.columns["position_m"], rtol=1e-9, atol=1e-12)
    with pytest.raises(iv.ParameterError, match=r"series_spring\.stiffness must be > 0, got 0"):
        Output(series_spring=Spring(stiffness=0.0))
    with pytest.raises(iv.ParameterError, match="stiffness must be > 0 with a preload or hysteresis"):
        Spring(stiffness=0.0, preload=1.0)
