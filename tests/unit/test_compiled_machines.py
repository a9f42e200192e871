"""Machines of many contacts in compiled C: the same laws, exact derivatives, and the same runs as in Python."""

import functools
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import infinivar as iv
from internals import (
    SessionSetup,
    SystemInputs,
    c_library,
    compiled_motion,
    compiled_step,
    inputs_of,
    machine_code,
    run_setup,
)
from machine_runs import STEERING, planar, platform
from machines import HEXAPOD, LEG, MACHINES, REAL_WHEEL, cart
from made import loaded
from sampled import sampled

pytestmark = pytest.mark.skipif(c_library.compiler() is None, reason="no C compiler on this machine")

WARNINGS = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-Wconversion", "-pedantic")
DRIVE = loaded("hand_controller").drives["motor1-gear1"]


def swung(time):
    return np.array([0.01 * np.sin(6.0 * time), 0.0, -0.005 * np.sin(5.0 * time)])


SESSIONS = {
    "cart pushed": lambda: SessionSetup(
        machine=cart(REAL_WHEEL, steering=STEERING),
        task=iv.motion.VirtualPath(curve=iv.motion.ArcCurve(centre=[0.0, 0.0], radius=0.5)),
        user=lambda at: [-6.0 * np.sin(at), 6.0 * np.cos(at)],
        pose=[0.5, 0.0, 0.0],
        rates=[0.0, 0.5, 0.0],
        duration=0.1,
    ),
    "cart with ideal servos": lambda: SessionSetup(
        machine=cart(REAL_WHEEL, steering=STEERING),
        user=[5.0, 1.0],
        rates=[0.3, 0.0, 0.0],
        servos="ideal",
        duration=0.05,
    ),
    "legs in a hand": lambda: SessionSetup(
        machine=HEXAPOD,
        controller=iv.machines.AdmittanceGuide(mass=2.0, damping=5.0),
        user=iv.motion.ArmModel.named("vanbeek2015"),
        intention=lambda at: HEXAPOD.home[:3] + swung(at),
        duration=0.03,
    ),
    "arm in a hand": lambda: SessionSetup(
        machine=MACHINES["arm"][0],
        controller=iv.machines.AdmittanceGuide(mass=3.0, damping=10.0),
        user=iv.motion.ArmModel.named("vanbeek2015"),
        intention=lambda at: np.asarray(MACHINES["arm"][0].arm.end_point(np.array([0.3, 0.8])))[:2] + swung(at)[:2],
        pose=[0.3, 0.8],
        duration=0.03,
    ),
    "slide at a wall": lambda: SessionSetup(
        machine=iv.machines.SlideMachine(leg=LEG, masses=[0.5, 0.7]),
        task=iv.motion.VirtualWall(surface=iv.motion.HalfSpace(point=[0.001, 0.0], direction=[-1.0, 0.0])),
        user=[20.0, 5.0],
        duration=0.05,
    ),
    "slide pushed suddenly": lambda: SessionSetup(
        machine=iv.machines.SlideMachine(leg=LEG, masses=[0.5]),
        task=iv.motion.Caster(),
        user=lambda at: [5.0 if at < 0.01234 else -8.0],
        duration=0.02,
    ),
    "geared slide": lambda: SessionSetup(
        machine=iv.machines.GearedSlideMachine(drive=DRIVE, masses=[0.5]),
        task=iv.motion.Caster(),
        user=[20.0],
        duration=0.02,
    ),
}


RUNS = MACHINES | {
    f"omniwheels {name}": (
        loaded("omniwheel_platform").drives[name].moving(),
        {
            "duration": 0.03,
            "motion": iv.motion.VectorHistory.of(lambda t: [0.1 * t, 0.05 * t * t, 0.2 * t], 0.1),
            "wrench": [5.0, -3.0, 0.4],
        },
    )
    for name in ("one-motor", "mecanum")
}
UPRIGHT = {
    "member_inertias": (4e-3, 2e-3),
    "member_offsets": (0.01, -0.03),
    "gravity": (1.3, -9.7),
    "payload_mass": 0.1,
}
RUNS |= {
    f"arm with weight, {name}": (
        replace(loaded("two_joint_arm").drives[name], **UPRIGHT).moving(0.1, 1e-4),
        {"duration": 0.03, "motion": iv.motion.VectorHistory.of(lambda t: [0.3 + t, 0.8 - 5.0 * t * t], 0.1)},
    )
    for name in ("one-motor", "two-motors")
}
RUNS["sphere of a study"] = (
    loaded("sphere_joint").drives["cubic"].moving(),
    {"duration": 0.02, "steering": lambda t: [0.7 + 0.3 * np.sin(8 * t)], "servos": False, "wrench": [0.0, 0.1]},
)
"""Of every kind; omniwheels and upright arms on a common cylinder, and with a motor each; and rollers with exact rolling
contact."""


@functools.cache
def moved(name):
    """A system and its state at the start."""
    if name in SESSIONS:
        made = SESSIONS[name]()
    else:
        machine, given = RUNS[name]
        made = run_setup(machine, iv.motion.MachineScenario(**given))
    return made.system, made.state


def states(system, start, count, seed=0):
    """States in all quadrants: near the pose, fast and slow, with any inputs."""
    random, (first, _, _) = np.random.default_rng(seed), system.places
    for _ in range(count):
        state = start.copy()
        state[:first] += random.uniform(-0.005, 0.005, first)
        size = 10.0 ** random.uniform(-5.0, 0.0, len(start) - first)
        state[first:] = random.choice([-1.0, 1.0], len(size)) * size * np.maximum(np.abs(start[first:]), 0.3)
        idle = system.idle()
        inputs = SystemInputs(
            *(random.normal(size=getattr(idle, one).shape) for one in ("currents", "steering", "turning", "links"))
        )
        yield state, inputs, system.outside(random.uniform(0.0, 0.02, 1))


def close(found, expected, share=1e-12):
    """Whether numbers are the same to a share of the largest."""
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=share * np.max(np.abs(expected), initial=1e-300))


@sampled("name", [*SESSIONS, *RUNS], every=3)
def test_rates_are_those_of_the_python_source_and_slopes_their_derivatives(name):
    """With powers and demands, at random states in all quadrants; the slopes by central differences."""
    system, start = moved(name)
    motion = compiled_motion(system)
    assert motion is not None
    for place, (state, inputs, outside) in enumerate(states(system, start, 60)):
        expected = system.moved(inputs, outside, state[None])
        balance, given = expected.balance(), inputs_of(inputs, outside)
        close(motion.called("rates_at", motion.states, state, given), expected.derivative[0])
        close(motion.called("powers_at", motion.powers, state, given), balance.power[0])
        count = len(system.mechanics.demands)
        close(motion.called("watched_at", motion.watched, state, given)[:count], balance.demand[0, :count])
        if place < 5:
            slopes = motion.called("slopes_at", motion.states**2, state, given).reshape(motion.states, -1)
            off = [np.abs(slopes - one) for one in differences(system, inputs, outside, state)]
            size = np.max(np.abs(slopes), axis=1, keepdims=True)
            assert np.all(np.min(off, axis=0) <= 1e-4 * size + 1e-6), name


def differences(system, inputs, outside, state):
    """Slopes by central differences of several widths: the right one depends on how stiff a contact is."""
    for width in (1e-4, 1e-5, 1e-6, 1e-7):
        steps = width * (1e-3 + np.abs(state))
        sides = [system.moved(inputs, outside, state + side * np.diag(steps)).derivative for side in (1.0, -1.0)]
        yield ((sides[0] - sides[1]) / (2.0 * steps[:, None])).T


def test_machines_that_differ_in_numbers_share_a_library():
    """Their numbers are data."""
    wheel = replace(REAL_WHEEL, preload=431.0, creep_stiffness=2.1e4)
    codes = [
        machine_code(SessionSetup(machine=cart(one, steering=STEERING), user=[1.0, 2.0], duration=0.1).system)
        for one in (REAL_WHEEL, wheel)
    ]
    assert codes[0].text == codes[1].text
    assert not np.array_equal(codes[0].given, codes[1].given)


def both(make, monkeypatch):
    """What is made with compiled code, and in Python."""
    found = make()
    with monkeypatch.context() as patched:
        patched.setenv(c_library.SWITCH, "0")
        return found, make()


def same(found, expected, within=1e-3):
    """Whether two runs are the same: states `within` of their size, energies within a tenth of it of the largest."""
    assert found.outcome == expected.outcome == ""
    assert found.closure < 1e-6
    assert expected.closure < 1e-6
    for name in (*found.machine.mechanics(1e-4).configuration, *found.machine.mechanics(1e-4).coordinates):
        size = np.max(np.abs(expected.columns[name]))
        off = np.max(np.abs(found.columns[name] - expected.columns[name]))
        assert off <= within * max(size, 1e-2), (name, off, size)
    most = max(np.max(np.abs(one)) for one in (*expected.supplied.values(), *expected.lost.values()))
    for each in ("supplied", "lost"):
        for name, energy in getattr(expected, each).items():
            assert getattr(found, each)[name][-1] == pytest.approx(energy[-1], rel=within, abs=0.1 * within * most), (
                name
            )
    assert [(one.limit, one.what) for one in found.events] == [(one.limit, one.what) for one in expected.events]
    begins = [[one.start for one in each.events] for each in (found, expected)]
    np.testing.assert_allclose(*begins, atol=2e-5)


@sampled("name", RUNS, every=3)
def test_runs_are_the_same(name, monkeypatch):
    """States, energies and events of every kind of machine that moves."""
    machine, given = RUNS[name]
    scenario = iv.motion.MachineScenario(**given)
    same(*both(lambda: iv.simulate_machine(machine, scenario), monkeypatch))


@sampled("name", SESSIONS, every=3)
def test_sessions_are_the_same(name, monkeypatch):
    """With a user who pushes or whose arm pulls, and a wall."""
    same(*both(lambda: SESSIONS[name]().over(lambda share: None), monkeypatch))


@sampled("seed", range(60), every=12, slow=2)
def test_random_runs_are_the_same(seed, monkeypatch):
    """Carts and platforms of random masses, wheels and loads, on random motions."""
    random = np.random.default_rng(seed)
    if seed % 2:
        wheel = replace(
            REAL_WHEEL, preload=random.uniform(200.0, 600.0), creep_stiffness=10.0 ** random.uniform(3.7, 4.7)
        )
        machine = cart(wheel, steering=STEERING)
        machine = replace(machine, cobot=replace(machine.cobot, mass=random.uniform(3.0, 30.0)))
        speed, turn = random.uniform(0.1, 0.6), random.uniform(-1.0, 1.0)
        motion = iv.motion.VectorHistory.of(lambda t: [speed * t, 0.3 * speed * t * t, turn * t], 0.1)
        given = {"wrench": random.normal(size=3) * [4.0, 4.0, 0.2], "rates": [speed, 0.0, turn]}
    else:
        machine = replace(HEXAPOD, mass=random.uniform(0.3, 3.0), inertia=random.uniform(5e-4, 4e-3, 3))
        size = random.uniform(-0.005, 0.005, 6) * [1.0, 1.0, 1.0, 8.0, 8.0, 8.0]
        motion = iv.motion.VectorHistory.of(lambda t: HEXAPOD.home + size * (1.0 - np.cos(8.0 * t)), 0.1)
        given = {"wrench": random.normal(size=6) * [8.0, 8.0, 8.0, 0.1, 0.1, 0.1]}
    scenario = iv.motion.MachineScenario(duration=0.03, motion=motion, tolerance=1e-8, **given)
    same(*both(lambda: iv.simulate_machine(machine, scenario), monkeypatch), within=1e-6)


@pytest.mark.parametrize("made", [planar, platform])
def test_without_a_compiler_a_run_is_that_of_python(made, monkeypatch):
    """And says nothing else."""
    monkeypatch.setenv(c_library.SWITCH, "0")
    assert compiled_motion(moved("cart pushed")[0]) is None
    assert made.__wrapped__().outcome == ""


@sampled("name", ["cart pushed", "slide at a wall"], slow=2)
def test_no_call_does_what_c_does_not_define(name, tmp_path):
    """Random calls, an eighth of the values no numbers or huge, under the sanitizers of gcc, and no warning."""
    if shutil.which("gcc") is None:
        pytest.skip("gcc has the sanitizers")
    code, folder = machine_code(moved(name)[0]), Path(__file__).parents[1]
    hostile = "".join((folder / one).read_text("utf-8") for one in ("hostile_numbers.c", "hostile.c"))
    source, program = tmp_path / "model.c", tmp_path / "model"
    source.write_text(code.text, "utf-8")
    done = subprocess.run(["gcc", *WARNINGS, "-c", source, "-o", tmp_path / "model.o"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    source.write_text(
        "\n".join([code.text, compiled_step.NO_CONTROLLER.text, compiled_step.data("sampled.c"), hostile]), "utf-8"
    )
    checks = ("-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=all")
    numbers = ",".join(map(repr, code.given.tolist()))
    given = (f"-DPARAMETERS={numbers}", f"-DCONSTANTS={code.constants}", "-DCALLS=20000", "-DGAINS=0", "-DDATA=0")
    subprocess.run(["gcc", "-std=c99", "-O1", *checks, *given, source, "-o", program, "-lm"], check=True)
    done = subprocess.run([program], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout.split()[0]) > 5_000
