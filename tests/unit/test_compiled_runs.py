"""Runs in compiled C: the same laws, exact derivatives, and motions no less exact than those of the other solvers."""

import ctypes
import functools
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import infinivar as iv
from infinivar.analysis import two_ways
from infinivar.bondgraph import solve
from internals import (
    FloatNamespace,
    bond_graph_model,
    c_code,
    c_library,
    casadi_namespace,
    closed_loop,
    kept,
    recorded_controller,
    run_text,
    stepper,
)
from internals import bond_graph_solver as solving
from internals import compiled_step as step
from made import loaded
from run_cli import run
from sampled import sampled

pytestmark = pytest.mark.skipif(c_library.compiler() is None, reason="no C compiler on this machine")

WARNINGS = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-Wconversion", "-pedantic")
HAND = loaded("hand_controller")


CASES = [
    *(f"hand_controller {name}" for name in ("cobotic", "cobotic-b", "motor1-gear1")),
    *(f"{study} {name}" for study in ("knee_walking", "ankle_walking") for name in loaded(study).drives),
]


@functools.cache
def case(name):
    """Drive and scenario: shaking, or walking with the controllers that a comparison simulates."""
    study, drive = name.split()
    drive = loaded(study).drives[drive]
    if study == "hand_controller":
        return drive, HAND.scenarios["shake"]
    return drive, two_ways(drive, loaded(study).duty["walking"]).simulation.scenario


def code_of(name):
    """Model, parameters and C of a case."""
    graph = closed_loop(*case(name)).graph
    parameters = {symbol: parameter.value for symbol, parameter in graph.parameters.items()}
    made = bond_graph_model(graph)
    return made, parameters, c_code(made, parameters)


def controller_of(name, made):
    """C of the controller of a case."""
    return recorded_controller(made, closed_loop(*case(name)).controller)


def called(function, sizes, *arrays):
    """What a C function writes into an array of that size."""
    out = np.full(sizes, np.nan)
    function(*(ctypes.c_void_p(one.ctypes.data) for one in (*arrays, out)))
    return out


@sampled("name", CASES, every=3)
def test_rates_are_those_of_the_python_source_and_slopes_their_derivatives(name):
    """And powers: at random states, some at rest, some slipping: to rounding; the slopes as CasADi derives the same source."""
    casadi = pytest.importorskip("casadi")
    made, parameters, code = code_of(name)
    library = c_library.library(run_text(code, None))
    given = code.given(parameters)
    constants = called(library.constants, code.constants, given)
    expected = made.function("dynamics", FloatNamespace, parameters)
    names = made.states, made.inputs, made.rates
    symbols = [casadi.SX.sym(name, len(some)) for name, some in zip("xur", names, strict=True)]
    derived = made.function("motion", casadi_namespace(), parameters)(*(casadi.vertsplit(one) for one in symbols))
    jacobian = casadi.Function("slopes", symbols, [casadi.jacobian(casadi.vertcat(*derived), symbols[0])])
    random, count = np.random.default_rng(3), len(made.states)
    scales = np.array([0.3 if kind != "flow" else 3.0 for kind in made.state_kinds])
    for place in range(100):
        states = scales * random.standard_normal(count) * random.choice([1e-4, 1e-2, 1.0], count)
        resting = random.random(count) < 0.1 * (place % 2)
        states[resting] = 0.0
        inputs, rates = 3.0 * random.standard_normal(len(made.inputs)), random.standard_normal(len(made.rates))
        wanted = np.array(expected(states.tolist(), inputs.tolist(), rates.tolist()))
        for function, one in ((library.rates_at, wanted[:count]), (library.powers_at, wanted[count:])):
            own = called(function, len(one), given, constants, states, inputs, rates)
            assert np.all(np.abs(own - one) <= 1e-12 * (np.abs(one) + 1e-3 * np.max(np.abs(one))))
        if not resting.any():  # where a size has no derivative
            slopes = called(library.slopes_at, (count, count), given, constants, states, inputs, rates)
            wanted = np.array(jacobian(states, inputs, rates))
            assert np.all(np.abs(slopes - wanted) <= 1e-9 * (np.abs(wanted) + 1e-3 * np.max(np.abs(wanted))))


@sampled("name", CASES, every=4)
def test_the_text_is_clean_and_always_the_same(name, tmp_path):
    """Without a warning of the compilers there are; values of parameters are no part of it."""
    made, parameters, code = code_of(name)
    other = c_code(
        made, {symbol: 1.01 * value if "a/b" not in symbol else value for symbol, value in parameters.items()}
    )
    assert code.text == other.text
    source = tmp_path / "model.c"
    source.write_text(run_text(code, controller_of(name, made)), "utf-8")
    for compiler in filter(None, map(shutil.which, ("gcc", "clang"))):
        done = subprocess.run(
            [compiler, *WARNINGS, "-O1", "-c", source, "-o", tmp_path / "model.o"], capture_output=True, text=True
        )
        assert done.returncode == 0, done.stderr


@sampled("name", CASES, slow=5)
def test_no_call_does_what_c_does_not_define(name, tmp_path):
    """A hundred thousand random calls, an eighth of the values no numbers or huge, under the sanitizers of gcc."""
    if shutil.which("gcc") is None:
        pytest.skip("gcc has the sanitizers")
    made, parameters, code = code_of(name)
    own = controller_of(name, made)
    numbers, gains, data = (
        ",".join(map(repr, one.tolist())) for one in (code.given(parameters), own.numbers, own.data)
    )
    folder = Path(__file__).parents[1]
    hostile = "".join((folder / name).read_text("utf-8") for name in ("hostile_numbers.c", "hostile.c"))
    source, program = tmp_path / "model.c", tmp_path / "model"
    source.write_text(run_text(code, own) + hostile, "utf-8")
    checks = ("-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=all")
    numbers = (
        f"-DPARAMETERS={numbers}",
        f"-DGAINS={gains}",
        f"-DDATA={data}",
        f"-DCONSTANTS={code.constants}",
        "-DCALLS=100000",
    )
    subprocess.run(["gcc", "-std=c99", "-O1", *checks, *numbers, source, "-o", program, "-lm"], check=True)
    done = subprocess.run([program], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    finite, reached = map(int, done.stdout.split())
    assert finite > 30_000
    assert reached >= 25  # all that begin at possible states


@sampled(
    ("name", "scenario"), [("motor1-gear1", "push"), ("cobotic", "shake"), ("cobotic", "push"), ("cobotic-b", "reach")]
)
def test_it_is_nearer_to_the_exact_motion_than_the_other_solver(name, scenario):
    """At the same tolerance, against a tolerance a thousand times smaller. A push begins within a friction of microseconds,
    which a step of collocation could pass over: as exact there."""
    drive, scenario = HAND.drives[name], HAND.scenarios[scenario]
    exact, plain, found = (
        iv.simulate(drive, replace(scenario, **options)).trajectory
        for options in ({"method": "Radau", "tolerance": 1e-13}, {"method": "LSODA"}, {})
    )
    assert scenario.method == "auto"
    for state, values in exact.states.items():
        size = np.max(np.abs(values))
        ours, theirs = (np.max(np.abs(one.states[state] - values)) for one in (found, plain))
        assert ours <= max(theirs, 1e-9 * size), state
        assert ours <= 1e-6 * size, state


@sampled("name", CASES, every=5)
def test_energies_and_events_are_those_of_the_other_solver(name, monkeypatch):
    """Of the error of a solver that integrates the energies 1e-6 is left; limits are passed at the same samples."""
    drive, scenario = case(name)
    monkeypatch.setitem(
        iv.simulate.__globals__, "solve", lambda *given, **options: solve(*given, **{**options, **AS_STATES})
    )
    found, expected = (iv.simulate(drive, replace(scenario, method=method)) for method in ("auto", "LSODA"))
    assert found.trajectory.outcome == expected.trajectory.outcome == ""
    moved = max(abs(one[-1]) for one in expected.trajectory.supplied.values())
    for element, energy in expected.trajectory.lost.items():
        assert found.trajectory.lost[element][-1] == pytest.approx(energy[-1], rel=1e-6, abs=2e-7 * moved), element
    assert [(one.limit, one.what) for one in found.events] == [(one.limit, one.what) for one in expected.events]
    begins = [[one.start for one in each.events] for each in (found, expected)]
    np.testing.assert_allclose(*begins, atol=1e-6)  # between samples, where the demand is one


def shaken(drive, frequency, **changes):
    motion = iv.motion.Sinusoid(distance=0.02, frequency=frequency)
    return HAND.drives[drive], replace(HAND.scenarios["shake"], motion=motion, duration=0.2, **changes)


def loose():
    drive, scenario = shaken("motor2-gear4", 4.0)
    return replace(drive, gearhead=replace(drive.gearhead, stiffness=50.0, backlash=0.01)), scenario


AS_STATES = {"energies_as_states": True}
FAST = {
    "geared, 4 Hz": lambda: shaken("motor1-gear1", 4.0),
    "backlash": loose,
    "geared, imposed": lambda: shaken("motor1-gear1", 4.0, link="imposed"),
    "geared, from rest": lambda: (HAND.drives["motor1-gear1"], HAND.scenarios["push"]),
    "cobotic, 4 Hz": lambda: shaken("cobotic", 4.0),
    "cobotic, 6 Hz": lambda: shaken("cobotic", 6.0),
    "cobotic, 8 Hz": lambda: shaken("cobotic-b", 8.0),
    "cobotic, imposed": lambda: shaken("cobotic-b", 4.0, link="imposed"),
    "cobotic, voltage": lambda: shaken("cobotic", 4.0, electrical="voltage"),
    "cobotic, from rest": lambda: (HAND.drives["cobotic"], HAND.scenarios["push"]),
}


def energies(name, **options):
    """Energy of every source and loss, one below the other, and their scale; the balance may stay open."""
    loop, duration = closed_loop(*FAST[name]()), FAST[name]()[1].duration
    given = {"inputs": loop.inputs, "initial": loop.initial, "controller": loop.controller}
    run = solve(loop.graph, np.linspace(0.0, duration, 201), closure=1.0, **given, **options)
    return np.array(list(run.by_element.values())), sum(abs(one[-1]) for one in run.supplied.values()), run


@sampled("name", FAST, every=3)
def test_energies_are_those_of_a_motion_that_integrates_them(name, monkeypatch):
    """Friction that reverses fast or sticks, backlash, motions imposed: in one run, a tenth of what the balance may miss off
    those of another solver at a tolerance a hundred times smaller."""
    made = []
    monkeypatch.setattr(solving, "stepper", lambda *given: made.append(given) or stepper(*given))
    found, _, run = energies(name)
    assert len(made) == 1
    assert run.closure < 1e-6
    expected, moved, _ = energies(name, method="LSODA", rtol=1e-12, **AS_STATES)
    assert np.max(np.abs(found - expected)) <= 1e-7 * moved


def test_an_imposed_motion_has_the_energies_of_a_third_solver():
    """LSODA misses them where they are sums, although its balance closes."""
    name = "geared, imposed"
    expected, moved, _ = energies(name, method="Radau", rtol=1e-12, **AS_STATES)
    assert np.max(np.abs(energies(name)[0] - expected)) <= 1e-7 * moved
    summed, _, run = energies(name, method="LSODA")
    assert np.max(np.abs(summed - expected)) >= 1e-6 * moved
    assert run.closure < 1e-9


@pytest.mark.parametrize("name", ["geared, 4 Hz", "cobotic, 4 Hz"])
def test_where_no_step_is_short_enough_the_other_solver_goes_on(monkeypatch, name):
    """With states, energies and the controller's memory where they are: of every 30 segments the last is not compiled."""
    expected, moved, _ = energies(name)
    calls, own = [], step.Loop.__call__

    def failing(self, segments, *given):
        calls.append(len(segments.pieces))
        if len(calls) % 2 == 0:
            return 0, np.empty((0, 0)), np.empty((0, 0)), list(given[1]), list(given[2])
        return own(self, segments.part(0, min(len(segments.pieces), 29)), *given)

    monkeypatch.setattr(step.Loop, "__call__", failing)
    found, _, run = energies(name)
    assert len(calls) > 10
    assert run.outcome == ""
    assert run.closure < 1e-6
    assert np.max(np.abs(found - expected)) <= 1e-6 * moved


class Foreign:
    """A controller of which only its samples are known: it has no C."""

    def __init__(self, controller):
        self.sample_time, self.start, self.sample = controller.sample_time, controller.start, controller.sample


def both_ways(drive, scenario):
    """The run whose controller is compiled, and the one that calls it in Python at every sample."""
    loop = closed_loop(drive, scenario)
    times = np.linspace(0.0, scenario.duration, round(scenario.duration * 400) + 1)
    given = {"inputs": loop.inputs, "initial": loop.initial, "closure": 1.0}
    return [solve(loop.graph, times, controller=one, **given) for one in (loop.controller, Foreign(loop.controller))]


def assert_same(found, expected):
    """To rounding, which friction at reversals enlarges."""
    assert found.outcome == expected.outcome == ""
    for name, values in (*expected.states.items(), *expected.inputs.items()):
        other = (found.states | found.inputs)[name]
        np.testing.assert_allclose(other, values, rtol=0.0, atol=1e-9 * max(1e-3, np.max(np.abs(values))), err_msg=name)


@sampled("name", CASES, every=2)
def test_the_controller_in_c_commands_what_it_does_in_python(name):
    drive, scenario = case(name)
    assert_same(*both_ways(drive, replace(scenario, duration=min(scenario.duration, 0.4))))


@sampled("place", range(140), every=20, slow=4)
def test_the_loop_in_c_is_that_in_python(place):
    """Of any drive, motion, force and start: those that stand still, are held, run up, or whose voltage is commanded, too.

    And the motion is that of the other solver at a tolerance ten times smaller, which never calls C: within what the balance of
    energies may miss.
    """
    drive, scenario = random_case(place)
    found, called = both_ways(drive, scenario)
    assert_same(found, called)
    loop = closed_loop(drive, scenario)
    given = {"inputs": loop.inputs, "initial": loop.initial, "controller": loop.controller}
    plain = solve(loop.graph, found.time, method="LSODA", rtol=1e-11, **given, **AS_STATES)
    assert found.closure < 1e-6
    for name, values in plain.states.items():
        np.testing.assert_allclose(found.states[name], values, rtol=0.0, atol=1e-6 * max(1e-3, np.max(np.abs(values))))
    moved = max(abs(one[-1]) for one in plain.supplied.values())
    for name, energy in plain.lost.items():
        assert found.lost[name][-1] == pytest.approx(energy[-1], abs=1e-6 * moved + 1e-12), name


def random_case(place):
    random = np.random.default_rng(place)
    drive = HAND.drives[random.choice(["cobotic", "cobotic-b", "motor1-gear1", "motor2-gear4"])]
    cobotic = isinstance(drive, iv.CoboticDrive)
    if not cobotic and random.random() < 0.5:
        friction = iv.parts.GearFriction(friction=2e-3, viscous=1e-4, friction_stribeck=1e-3, load_motor=0.05)
        gear = [
            {"loss_model": "proportional"},
            {"loss_model": "stribeck", "friction": friction, "efficiency": None},
            {"stiffness": 50.0},
        ]
        drive = replace(drive, gearhead=replace(drive.gearhead, **gear[random.integers(3)]))
    size = random.uniform(0.002, 0.02)
    motions = [
        iv.motion.Sinusoid(distance=size, frequency=random.uniform(0.5, 4.0)),
        iv.motion.Reach(distance=size, time=random.uniform(0.05, 0.2), start=0.02),
        iv.motion.Step(distance=0.2 * size, start=0.01),
        iv.motion.Cruise(speed=size, start=0.05),
    ]
    motion = motions[random.integers(4)]
    force = [None, iv.motion.ConstantForce(size=10.0), iv.motion.SinusoidalForce(size=8.0, frequency=3.0)]
    changes = {}
    if cobotic and random.random() < 0.3:
        changes = [
            {"cylinder": "run-up", "run_up_time": 0.1},
            {"steering": "held", "steering_angle": 0.2, "link": "imposed", "force": None},
        ][random.integers(2)]
        if "link" in changes:
            motion = motions[random.integers(2)]  # others need an infinite force
    if random.random() < 0.2:
        changes["electrical"] = "voltage"
    return drive, replace(
        HAND.scenarios["shake"],
        motion=motion,
        duration=random.uniform(0.15, 0.3),
        **{"force": force[random.integers(3)], **changes},
    )


def test_maker_s_friction_of_cylinder_bearings_runs_in_both_ways():
    """Where one of the bearings has no axial load, its law must not divide by nothing."""
    drive = HAND.drives["cobotic"]
    bearing = iv.parts.Bearing(
        name="6004",
        bore=0.02,
        outside_diameter=0.042,
        dynamic_rating=9950.0,
        static_rating=5000.0,
        friction_model="skf",
        series="60",
        viscosity=50e-6,
    )
    drive = replace(
        drive, cylinder_bearings=replace(loaded("knee_walking").drives["cobotic"].cylinder_bearings, bearing=bearing)
    )
    scenario = replace(HAND.scenarios["shake"], duration=0.1)
    found, expected = (iv.simulate(drive, replace(scenario, method=method)).trajectory for method in ("auto", "LSODA"))
    assert found.outcome == expected.outcome == ""
    assert found.lost["cylinder bearings"][-1] == pytest.approx(expected.lost["cylinder bearings"][-1], rel=1e-6)


@pytest.mark.parametrize("method", ["auto", "LSODA"])
def test_a_smooth_reach_with_a_proportional_gear_loss(method):
    """Its commands are numbers of NumPy, of which a sign is a number as well."""
    drive = HAND.drives["motor2-gear4"]
    drive = replace(drive, gearhead=replace(drive.gearhead, loss_model="proportional"))
    motion = iv.motion.Reach(distance=0.02, time=0.25, profile="smooth")
    scenario = replace(HAND.scenarios["reach"], motion=motion, duration=0.05, method=method)
    assert iv.simulate(drive, scenario).trajectory.outcome == ""


def test_what_is_kept_is_whole_or_not_used(tmp_path, monkeypatch):
    """A file that was cut, changed or replaced counts as none, and is made again."""
    monkeypatch.setattr(kept, "folder", lambda: tmp_path / "cache")
    assert kept.find("key", ".so") is None
    path = kept.keep("key", ".so", b"content")
    assert kept.find("key", ".so") == path
    for wrong in (b"cont", b"", b"contents", b"Content"):
        path.write_bytes(wrong)
        assert kept.find("key", ".so") is None
        assert kept.keep("key", ".so", b"content") == path
    assert [one.name for one in path.parent.iterdir()] == [path.name]
    monkeypatch.setattr(kept, "folder", lambda: path / "no folder")
    assert kept.keep("key", ".so", b"content") is None


def test_a_law_without_c_runs_in_python(monkeypatch):
    def refused(*arguments):
        raise TypeError("a recorded value has no truth value")

    monkeypatch.setattr(step, "c_code", refused)
    monkeypatch.setattr(step, "_CODES", {})
    assert_runs_in_python()
    assert list(step._CODES.values()) == [None]


def test_without_a_compiler_runs_are_those_of_the_other_solver(monkeypatch):
    monkeypatch.setattr(step, "compiler", lambda: None)
    assert_runs_in_python()


def assert_runs_in_python():
    drive, scenario = HAND.drives["cobotic"], replace(HAND.scenarios["shake"], duration=0.05)
    found, expected = (iv.simulate(drive, replace(scenario, method=method)) for method in ("auto", "LSODA"))
    for name, values in expected.trajectory.states.items():
        np.testing.assert_array_equal(found.trajectory.states[name], values)


@pytest.mark.parametrize(("switch", "said"), [("1", True), ("0", False)])
def test_a_missing_compiler_is_said_once(monkeypatch, tmp_path, switch, said):
    monkeypatch.setattr(c_library, "compiler", lambda: None)
    monkeypatch.setattr(step, "compiler", lambda: None)
    monkeypatch.setenv(c_library.SWITCH, switch)
    outcome = run("simulate", "hand_controller", "--drive", "motor1-gear1", "--scenario", "push", folder=tmp_path)
    assert outcome.code == 0
    assert outcome.out.count("no C compiler found") == said


def test_a_compiler_that_fails_is_none(monkeypatch):
    monkeypatch.setattr(c_library, "compiler", lambda: (shutil.which("false"),))
    assert c_library.library("int nothing(void) { return 1; } /* never made */") is None
