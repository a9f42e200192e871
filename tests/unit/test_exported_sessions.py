"""Exported sessions: a machine with its guide and sensors, and the arm of its user, inside an FMU or C, against `session`."""

import functools
import shutil
import subprocess
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import infinivar as iv
from fmu_unit import Unit, assert_defined
from internals import SessionSetup, c_library, session_arguments
from made import loaded
from run_cli import run
from sampled import sampled

fmpy = pytest.importorskip("fmpy")
sundials, validation = (pytest.importorskip(f"fmpy.{name}") for name in ("sundials", "validation"))
pytestmark = pytest.mark.skipif(c_library.compiler() is None, reason="no C compiler on this machine")

CASES = {
    "path": ("guided_cart", "cart", "path"),
    "display": ("one_axis_display", "cobotic", "free"),
    "plane": ("tool_on_six_legs", "six-legs", "plane"),
    "wall": ("guided_cart", "cart", "wall"),
    "geared": ("one_axis_display", "geared", "wall"),
    "caster": ("guided_cart", "cart", "free"),
    "held": ("one_axis_display", "cobotic", "hold"),
    "line": ("tool_on_six_legs", "six-legs", "line"),
    "steered wall": ("one_axis_display", "cobotic", "wall"),
    "six legs": ("six_leg_display", "one-motor-b", "plane"),
    "six motors": ("six_leg_display", "six-motors", "line"),
    "path from rest": ("guided_cart", "cart", "path"),
    "arm wall": ("two_joint_arm", "two-motors", "wall"),
    "arm path": ("two_joint_arm", "two-motors", "path"),
    "turned legs": ("tool_on_six_legs", "six-legs", "plane"),
    "turned cart": ("guided_cart", "cart", "free"),
}
TURNED = {
    "turned legs": iv.motion.ReachingUser(
        mass=0.5,
        damping=5.0,
        stiffness=100.0,
        inertia=2e-3,
        turning_damping=0.05,
        turning_stiffness=1.2,
        x=iv.motion.Cruise(speed=0.02),
        ry=iv.motion.Cruise(angular_speed=0.3),
    ),
    "turned cart": iv.motion.PushingUser(
        x=iv.motion.ConstantForce(size=3.0), angle=iv.motion.SinusoidalForce(moment=0.5, frequency=10.0)
    ),
}
"""Users of these cases."""
DURATIONS = {"path": 0.2, "wall": 0.2, "caster": 0.2, "display": 0.3, "geared": 0.35, "steered wall": 0.4}
"""Shorter than in the studies; of others 0.05 s. [s]"""
VERSIONS = ("fmu2", "fmu3")
BOTH = [(case, version) for case in CASES for version in VERSIONS]
WARNINGS = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-Wconversion", "-pedantic")
FOLDER = tempfile.TemporaryDirectory(prefix="infinivar-sessions-")


ARM = """
extends = "two_joint_arm"
drives.two-motors.member_masses = ["0.4 kg", "0.3 kg"]

[tasks.wall]
type = "wall"
surface = { shape = "half-space", point = ["0.302 m", "0 m"], direction = [-1, 0] }
stiffness = "4 N/mm"
damping = "20 N s/m"
user = { type = "force", x = { shape = "constant", size = "6 N" } }
duration = "0.05 s"

[tasks.path]
type = "path"
settling_length = "10 mm"
curve = { shape = "line", start = ["0 m", "0.25 m"], end = ["0.4 m", "0.25 m"] }
user = { type = "force", x = { shape = "constant", size = "2 N" } }
duration = "0.05 s"
"""


@functools.cache
def arm():
    file = Path(FOLDER.name, "arm.toml")
    file.write_text(ARM, "utf-8")
    return iv.load_study(file)


def task_of(case):
    study, drive, task = CASES[case]
    if case.startswith("arm"):
        found = arm().sessions[task]
        return arm().drives[drive], replace(found, sensing=replace(found.sensing, position_resolution=0.0))
    tasks = loaded("tool_on_six_legs" if study == "six_leg_display" else study).sessions
    found = replace(tasks[task], duration=DURATIONS.get(case, 0.05))
    if study == "six_leg_display":
        found = replace(found, load_mass=None, load_inertia=None)
    if case == "path from rest":
        found = replace(found, twist=iv.motion.Twist())
    if case in TURNED:
        found = replace(found, user=TURNED[case])
    if study == "one_axis_display":
        # A difference of 1e-10 may move a reading by a whole step of an encoder.
        found = replace(found, sensing=replace(found.sensing, position_resolution=0.0))
    return loaded(study).drives[drive], found


@functools.cache
def setup_of(case):
    drive, task = task_of(case)
    given = session_arguments(task, drive, "task", "drive")
    return SessionSetup(**{**given, "output_step": task.sensing.period, "tolerance": 1e-8})


@functools.cache
def exported(case, kind, closed=True):
    drive, task = task_of(case)
    folder = Path(FOLDER.name, f"{case} {kind} {closed}")
    found = iv.export(drive, kind, folder, name=CASES[case][1], scenario=task, closed=closed)
    assert found.notes == ()
    return found.files


@functools.cache
def expected(case):
    """States at each sample, by column, of the session itself."""
    setup = setup_of(case)
    found = setup.over(lambda share: None)
    assert found.outcome == ""
    mechanics = setup.system.mechanics
    turning = [one.replace("_rad", "_rate_rad_s") for one in mechanics.steered] if setup.system.servo else []
    steered = mechanics.steered if setup.system.places[2] > setup.system.places[1] else ()
    names = [*mechanics.configuration, *mechanics.coordinates, *steered, *turning]
    return np.array([found.columns[name] for name in names]).T


class User:
    """What the user of a session does, and the noise of its sensors as it draws them, as inputs of an FMU."""

    def __init__(self, case, unit):
        self.setup = setup_of(case)
        self.period, self.unit = self.setup.sensing.period, unit
        self.count = round(self.setup.duration / self.period)
        axes, ways = self.setup.system.hand.grip.axes, self.setup.system.hand.ways
        noise = np.random.default_rng(self.setup.sensing.seed).standard_normal((self.count + 1, len(axes)))
        self.noise = self.setup.sensing.force_noise * noise
        kinds = ("handle.{}", "handle.{}_rate", "intention.{}", "intention.{}_rate", "noise.{}")
        self.names = {kind: [kind.format(way) for way in ways] for kind in kinds}
        self.names["noise.{}"] = self.names["noise.{}"][: len(axes)]
        assert set(unit.inputs) == {one for names in self.names.values() for one in names if one in unit.place}

    def act(self, time, step=None):
        """Set the inputs of a time, or those of a step from it on, in which they go on with their rates."""
        outside = self.setup.system.outside(np.array([time, time + (step or self.period)]))
        force, intended = outside.force, outside.intended
        rows = [force[0], (force[1] - force[0]) / (step or self.period), None, None]
        if intended is not None:
            rows[2:] = intended[0], (intended[1] - intended[0]) / step if step else outside.intending[0]
        rows.append(self.noise[int(time / self.period + 1e-6)])
        known = {
            name: value
            for names, row in zip(self.names.values(), rows, strict=True)
            if row is not None
            for name, value in zip(names, row, strict=True)
            if name in self.unit.place
        }
        self.unit.set(known)


def coupled(case, file):
    """States at each sample of Co-Simulation, a step a sample, or ten with an arm, whose damper sees how the intention moves."""
    with Unit(file) as unit:
        user, rows = User(case, unit), [unit.get(unit.states)]
        steps = 10 if user.setup.system.hand.arm else 1
        for place in range(user.count * steps):
            user.act(place * user.period / steps, user.period / steps)
            unit.step(place * user.period / steps, user.period / steps)
            rows.append(unit.get(unit.states))
    return np.array(rows[::steps])


def exchanged(case, file):
    """States at each sample of Model Exchange by CVode, which asks for inputs at its own instants."""
    with Unit(file, exchange=True) as unit:
        user, one = User(case, unit), unit.unit
        rates, update = (
            (one.getContinuousStateDerivatives, one.updateDiscreteStates)
            if unit.third
            else (one.getDerivatives, one.newDiscreteStates)
        )

        def set_time(time):
            one.setTime(time)
            user.act(min(time, user.count * user.period))

        set_time(0.0)
        assert update()[-2:] == (True, pytest.approx(user.period))
        one.enterContinuousTimeMode()
        solver = sundials.CVodeSolver(
            nx=len(unit.every_state), nz=0, set_time=set_time, get_x=one.getContinuousStates, set_x=one.setContinuousStates,
            get_dx=rates, get_z=lambda *_: None, get_nominals=one.getNominalsOfContinuousStates,
            input=None, startTime=0.0, relativeTolerance=1e-12, maxNumSteps=100_000,
        )  # fmt: skip
        rows = [unit.get(unit.states)]
        for sample in range(1, user.count + 1):
            reached = sample * user.period
            solver.step(reached - user.period, reached)
            set_time(reached)
            rows.append(unit.get(unit.states))
            one.enterEventMode()
            assert update()[-2:] == (True, pytest.approx(reached + user.period))
            one.enterContinuousTimeMode()
            solver.reset(reached)
    return np.array(rows)


@sampled(("case", "version"), BOTH, every=5, slow=2)
def test_it_moves_as_the_session(case, version):
    """Model Exchange by CVode of another program to 1e-6, Co-Simulation to 1e-4 of each state's largest value; the validator has
    nothing to say."""
    (file,) = exported(case, version)
    assert validation.validate_fmu(str(file)) == []
    wanted = expected(case)
    size = np.maximum(np.max(np.abs(wanted), axis=0), 1e-3)
    assert np.max(np.abs(exchanged(case, file) - wanted) / size) <= 1e-6
    if case != "steered wall":  # what the user does within a sample decides at which one the wheel turns off the wall
        assert np.max(np.abs(coupled(case, file) - wanted) / size) <= 1e-4


@sampled(("case", "version"), BOTH, every=5, slow=2)
def test_powers_balance(case, version):
    """Sources less losses are the rate of the energies, along the motion by the FMU's own directional derivatives, to 1e-9 of
    what moves: at each tenth sample, with the arm's intention on its way."""
    (file,) = exported(case, version)
    with Unit(file) as unit:
        user, largest = User(case, unit), 0.0
        supplied, lost, energies = (unit.names(one) for one in ("power.", "loss.", "energy."))
        moving = [one for one in unit.inputs if one.endswith("_rate")]
        for sample in range(user.count):
            user.act(sample * user.period, user.period)
            unit.step(sample * user.period, user.period)
            if sample % 10:
                continue
            into, out = unit.get(supplied), unit.get(lost)
            moved = np.abs(into).sum() + np.abs(out).sum()
            on = [one.removesuffix("_rate") for one in moving]
            seed = [*unit.get(unit.rates), *unit.get(moving)]
            growth = unit.change(energies, [*unit.states, *on], seed).sum()
            assert abs(into.sum() - out.sum() - growth) <= 1e-9 * (moved + abs(growth))
            assert np.all(out >= -1e-9 * moved)
            largest = max(largest, moved)
        assert largest > (0.0 if case == "held" else 1e-3)  # locked wheels hold without power


@pytest.mark.parametrize("case", ["path", "display"])
def test_energies_are_those_of_the_session(case):
    """At its end, without what is stored in a part that has none."""
    setup = setup_of(case)
    found = setup.over(lambda share: None)
    (file,) = exported(case, "fmu2")
    with Unit(file, exchange=True) as unit:
        user = User(case, unit)
        user.act(user.count * user.period)
        unit.set(dict(zip(unit.states, expected(case)[-1], strict=True)))
        for name in unit.names("energy."):
            wanted = found.stored[name.partition(".")[2]][-1]
            assert unit.get([name])[0] == pytest.approx(wanted, rel=1e-9, abs=1e-12), name


@sampled(("case", "version"), BOTH, every=7, slow=2)
def test_instances_resets_and_saved_states_give_the_same_bytes(case, version):
    """With the memory of the controller, whose commands cannot be set."""
    (file,) = exported(case, version)
    commands = [
        one.name for one in fmpy.read_model_description(str(file)).modelVariables if one.variability == "discrete"
    ]

    def steps(unit, begin, end):
        user, rows = User(case, unit), []
        for sample in range(begin, end):
            user.act(sample * user.period, user.period)
            unit.step(sample * user.period, user.period)
            rows.append(unit.get([*unit.states, *commands]).tobytes())
        return rows

    with Unit(file) as one, Unit(file) as other:
        with pytest.raises(Exception, match="failed with status"):
            one.set({commands[0]: 1.0})
        both = [(steps(one, row, row + 1), steps(other, row, row + 1)) for row in range(10)]
        assert all(first == second for first, second in both)
        one.assert_saved(lambda: steps(one, 10, 20))
        one.unit.reset()
        one.begin()
        assert steps(one, 0, 10) == [first for (first,), _ in both]


@sampled(("case", "version"), BOTH, every=9, slow=3)
def test_no_call_does_what_c_does_not_define(case, version, tmp_path):
    """Random calls under the sanitizers of gcc."""
    assert_defined(exported(case, version)[0], tmp_path)


@sampled("case", CASES, every=4, slow=2)
def test_c_runs_alone(case, tmp_path):
    """Compiled without a warning, its program moves as the FMU does with the user of the start."""
    files = exported(case, "c")
    main = next(file for file in files if file.name.endswith("_main.c"))
    for compiler in filter(None, map(shutil.which, ("gcc", "clang"))):
        subprocess.run([compiler, *WARNINGS, "-O1", main, "-o", tmp_path / "run", "-lm"], check=True)
    out = subprocess.run([tmp_path / "run"], capture_output=True, text=True).stdout
    found = np.array([line.split(", ") for line in out.splitlines()][:3], dtype=float)
    with Unit(exported(case, "fmu2")[0]) as unit:
        rows = [unit.get(unit.every_state)]
        unit.set(dict.fromkeys([one for one in unit.inputs if one.endswith("_rate")], 0.0))
        for row in range(2):
            unit.step(0.01 * row, 0.01)
            rows.append(unit.get(unit.every_state))
    np.testing.assert_allclose(found[:, 1:], rows, rtol=1e-5, atol=1e-6)


def test_without_its_controller_a_session_is_the_plant_at_its_start():
    """Pose and twist of the study, the arm of the user, and what the controller commands at first as inputs."""
    for case in ("path", "display"):
        with Unit(exported(case, "fmu3")[0]) as one, Unit(exported(case, "fmu3", closed=False)[0]) as other:
            assert one.states == other.states
            np.testing.assert_array_equal(one.get(one.states), other.get(one.states))
            np.testing.assert_array_equal(one.get(one.states), expected(case)[0])
            commands = set(other.of("input")) - set(one.of("input"))
            assert commands
            assert all(name.startswith(("current.", "rate.")) for name in commands)
            np.testing.assert_allclose(one.get(one.rates), other.get(one.rates), rtol=1e-12)


def test_the_command_writes_it(tmp_path):
    done = run("export", "guided_cart", "--as", "fmu3", "--loop", "path", "--out", "out", folder=tmp_path)
    assert done.code == 0, done.err
    described = fmpy.read_model_description(str(tmp_path / "out" / "cart.fmu"))
    roles = {one.name: one.causality for one in described.modelVariables}
    assert [roles[one] for one in ("handle.x", "noise.y", "current.h_1")] == ["input", "input", "local"]
    for given, word in (
        (("guided_cart", "--as", "fmu3", "--loop", "paths"), "path"),
        (("hand_controller", "cobotic", "--as", "fmu3", "--loop", "path"), "reach"),
        (("two_joint_arm", "two-motors", "--as", "fmu2", "--loop", "reach"), "session"),
        (("guided_cart", "--as", "mujoco", "--loop", "path"), "mujoco"),
    ):
        wrong = run("export", *given, "--out", "wrong", folder=tmp_path)
        assert wrong.code == 2
        assert word in wrong.err
        assert len(wrong.err.strip().splitlines()) == 1
    assert not (tmp_path / "wrong").exists()


class Decides:
    """A guide that decides by a value, in Python only."""

    memory = ()

    def begin(self, plant):
        self.memory = []
        return self

    def __call__(self, measured):
        return iv.machines.Commands(
            steering=measured.steering if float(measured.time) > 1.0 else 0.0 * measured.steering
        )


class Forgets(Decides):
    """One that does not tell its memory."""

    def begin(self, plant):
        return lambda measured: iv.machines.Commands()


@pytest.mark.parametrize("guide", [Decides, Forgets])
def test_a_controller_of_python_alone_is_refused_by_name(guide, tmp_path, monkeypatch):
    drive, task = task_of("path")
    monkeypatch.setattr(type(drive.moving()), "guide", lambda self, task: guide())
    with pytest.raises(iv.InputError, match=f"{guide.__name__}, decides in Python alone and has no C; --scenario"):
        iv.export(drive, "fmu2", tmp_path, scenario=task, closed=True)
    assert list(tmp_path.iterdir()) == []
