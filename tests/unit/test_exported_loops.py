"""Exported closed loops: the controllers of a run inside an FMU or C, against `simulate`."""

import ctypes
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
from internals import c_library, closed_loop
from made import loaded
from run_cli import run

fmpy = pytest.importorskip("fmpy")
validation = pytest.importorskip("fmpy.validation")
pytestmark = pytest.mark.skipif(c_library.compiler() is None, reason="no C compiler on this machine")

HAND = loaded("hand_controller")
VERSIONS = ("fmu2", "fmu3")
CASES = {
    "steered": ("cobotic", replace(HAND.scenarios["reach"], duration=0.5)),
    "run up": ("cobotic-b", replace(HAND.scenarios["run-up"], duration=0.3)),
    "voltage": ("cobotic", replace(HAND.scenarios["shake"], duration=0.2, electrical="voltage")),
    "geared": ("motor1-gear1", replace(HAND.scenarios["shake"], duration=0.4)),
    "held": ("motor1-gear1", replace(HAND.scenarios["push"], duration=0.3)),
}
WARNINGS = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-Wconversion", "-pedantic")
FOLDER = tempfile.TemporaryDirectory(prefix="infinivar-loops-")


@functools.cache
def exported(case, kind):
    name, scenario = CASES[case]
    return iv.export(
        HAND.drives[name], kind, Path(FOLDER.name, f"{case} {kind}"), name=name, scenario=scenario, closed=True
    ).files


def given(case, names):
    """What an importer feeds at each sample: goal and force, by name."""
    name, scenario = CASES[case]
    loop = closed_loop(HAND.drives[name], scenario)
    times = np.arange(round(scenario.duration / loop.controller.sample_time) + 1) * loop.controller.sample_time
    force = loop.inputs["force"]
    columns = {
        **dict(zip(loop.controller.goal._fields, loop.controller.goals(times).T, strict=True)),
        "force": np.array([force if isinstance(force, float) else force.value(time) for time in times]),
    }
    own = [name for name in names if name == "force" or name.startswith("goal.")]
    rows = zip(times, *(columns[name.removeprefix("goal.")] for name in own), strict=True)
    return times, np.array(list(rows), dtype=[(one, float) for one in ("time", *own)])


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("case", CASES)
def test_it_moves_as_in_simulate(case, version):
    """Model Exchange by CVode of another program to 1e-6, Co-Simulation to 1e-4; the validator has nothing to say.

    The error of CVode, which begins anew at each sample, falls in proportion to its tolerance: a load held by friction needs a
    small one, at which CVode fails where currents settle within microseconds.
    """
    name, scenario = CASES[case]
    (file,) = exported(case, version)
    assert validation.validate_fmu(str(file)) == []
    described = fmpy.read_model_description(str(file))
    times, signals = given(case, [one.name for one in described.modelVariables if one.causality == "input"])
    drive = HAND.drives[name]
    expected = iv.simulate(drive, replace(scenario, output_step=float(times[1]))).trajectory.states
    for kind, error in (("ModelExchange", 1e-6), ("CoSimulation", 1e-4)):
        found = fmpy.simulate_fmu(
            str(file),
            fmi_type=kind,
            stop_time=float(times[-1]),
            output_interval=float(times[1]),
            relative_tolerance=1e-12 if case == "held" else 1e-11,
            input=signals,
            output=list(expected),
        )
        at = np.searchsorted(found["time"], times - 1e-9)
        for state, values in expected.items():
            size = max(np.max(np.abs(values)), 1e-3)
            assert np.max(np.abs(found[state][at] - values)) <= error * size, (kind, state)


def test_a_goal_goes_on_between_communication_steps():
    """With its speed and acceleration, at the samples of the controller: ten samples a step cost little."""
    name, scenario = CASES["steered"]
    (file,) = exported("steered", "fmu2")
    times, signals = given("steered", ["goal.position", "goal.speed", "goal.acceleration"])
    expected = iv.simulate(HAND.drives[name], scenario).trajectory.states["l"]
    ends = []
    for every in (1, 10):
        unit = fmpy.simulate_fmu(
            str(file),
            fmi_type="CoSimulation",
            stop_time=float(times[-1]),
            output_interval=every * float(times[1]),
            input=signals,
            output=["l"],
        )
        ends.append(abs(unit["l"][-1] - expected[-1]) / np.max(np.abs(expected)))
    assert ends[0] < 1e-6
    assert ends[1] < 2e-3


@pytest.mark.parametrize("version", VERSIONS)
def test_what_the_controller_commands_cannot_be_set_and_its_memory_is_part_of_the_state(version):
    (file,) = exported("geared", version)

    def steps(unit, begin, end):
        rows = []
        for row in range(begin, end):
            unit.set({"goal.position": 1e-3 * np.sin(0.1 * row), "force": 0.1 * row})
            unit.step(1e-3 * row, 1e-3)
            rows.append(unit.get([*unit.states, "source"]).tobytes())
        return rows

    with Unit(file) as one:
        with pytest.raises(Exception, match="failed with status"):
            one.set({"source": 1.0})
        begin = steps(one, 0, 15)
        first = one.assert_saved(lambda: steps(one, 15, 40))
        one.unit.reset()
        one.begin()
        assert steps(one, 0, 15) == begin
        assert len(set(first)) > 20


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("case", ["steered", "geared"])
def test_no_call_does_what_c_does_not_define(case, version, tmp_path):
    """Random calls under the sanitizers of gcc."""
    assert_defined(exported(case, version)[0], tmp_path)


@pytest.mark.parametrize("case", ["steered", "geared", "held"])
def test_c_of_a_controller_is_its_sample_in_python(case, tmp_path):
    """Over random goals, signals and memories; compiled without a warning, its program holds the goal as `simulate` does."""
    files = exported(case, "c")
    main = next(file for file in files if file.name.endswith("_main.c"))
    program = tmp_path / "run"
    for compiler in filter(None, map(shutil.which, ("gcc", "clang"))):
        subprocess.run([compiler, *WARNINGS, "-O1", main, "-o", program, "-lm"], check=True)
    printed = subprocess.run([program], capture_output=True, text=True).stdout.splitlines()
    assert len(printed) == 101

    name, scenario = CASES[case]
    controller, library = closed_loop(HAND.drives[name], scenario).controller, tmp_path / "lib.so"
    subprocess.run([*c_library.compiler(), "-O1", "-fPIC", "-shared", files[0], "-o", library, "-lm"], check=True)
    control = ctypes.CDLL(str(library))[f"{files[0].stem}_control"]
    measured = next(
        line for line in files[2].read_text("utf-8").splitlines() if line.startswith("Signals, in this order")
    )
    signals = [one.strip(" `.") for one in measured.split(":")[1].split(",")]
    random = np.random.default_rng(5)
    for _ in range(300):
        goal = random.standard_normal(5) * random.choice([0.0, 1e-5, 1e-2, 1.0], 5)
        goal[0] = abs(goal[0])
        values = random.standard_normal(len(signals)) * random.choice([0.0, 1e-5, 1e-2, 1.0], len(signals))
        start = np.array([0.3 * random.standard_normal(), random.integers(2), 0.1][: len(controller.start({}))])
        wanted, kept = controller.control(controller.goal(*goal), dict(zip(signals, values, strict=True)), tuple(start))
        memory, out = start.copy(), np.empty(len(wanted))
        inputs = np.concatenate([goal, values])
        control(*(ctypes.c_void_p(one.ctypes.data) for one in (inputs, memory, out)))
        np.testing.assert_allclose(out, wanted, rtol=1e-12, atol=1e-14)
        np.testing.assert_allclose(memory, kept, rtol=1e-12, atol=1e-14)


def test_the_command_writes_it(tmp_path):
    done = run(
        "export", "hand_controller", "motor1-gear1", "--as", "fmu3", "--loop", "reach", "--out", "out", folder=tmp_path
    )
    assert done.code == 0
    described = fmpy.read_model_description(str(tmp_path / "out" / "motor1_gear1.fmu"))
    roles = {one.name: one.causality for one in described.modelVariables}
    assert [roles[f"goal.{one}"] for one in ("position", "speed", "acceleration")] == ["input"] * 3
    assert roles["source"] == "local"
    wrong = run(
        *("export", "hand_controller", "motor1-gear1", "--as", "c", "--loop", "reach", "--scenario", "reach"),
        folder=tmp_path,
    )
    assert wrong.code == 2
    assert "--scenario and --loop exclude each other" in wrong.err
