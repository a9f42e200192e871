"""Exported machines of several coordinates: FMUs and C that importers accept and that move as a run of the same inputs."""

import functools
import importlib.util
import itertools
import shutil
import subprocess
import tempfile
import types
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import infinivar as iv
from fmu_unit import Unit, assert_defined
from internals import (
    March,
    SystemInputs,
    SystemOutside,
    c_library,
    heat_rates,
    is_machine,
    machine_of_export,
    moving_plant,
)
from machines import LEG, MACHINES
from made import loaded
from sampled import sampled

fmpy = pytest.importorskip("fmpy")
validation = pytest.importorskip("fmpy.validation")
pytestmark = pytest.mark.skipif(c_library.compiler() is None, reason="no C compiler on this machine")

WARNINGS = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-Wconversion", "-pedantic")
VERSIONS = ("fmu2", "fmu3")
STUDIES = ("guided_cart", "omniwheel_platform", "six_leg_display", "tool_on_six_legs", "two_joint_arm", "sphere_joint")
DRIVES = [f"{study} {name}" for study in STUDIES for name, one in loaded(study).drives.items() if is_machine(one)]
OTHERS = {
    "slide": iv.machines.SlideMachine(leg=LEG, masses=[0.5, 0.7]),
    "geared slide": iv.machines.GearedSlideMachine(
        drive=loaded("hand_controller").drives["motor1-gear1"], masses=[0.5]
    ),
    "serial arm": MACHINES["serial arm"][0],
    "sphere with servo": MACHINES["sphere"][0],
    "driven cart": replace(
        loaded("driven_cart").drives["rear"], steering=loaded("guided_cart").drives["cart"].steering
    ),
}
if importlib.util.find_spec("pinocchio"):  # the extra infinivar[robots] has pin
    ROBOTS = Path(__file__).parents[2] / "studies" / "robots"
    OTHERS["robot"] = iv.load_study(ROBOTS / "pick_and_place.toml").drives["geared-120"]
EVERY = [*DRIVES, *OTHERS]
BOTH = [f"{name} {version}" for name, version in itertools.product(EVERY, VERSIONS)]
FOLDER = tempfile.TemporaryDirectory(prefix="infinivar-machines-")
DURATION, STEP = 0.04, 1e-3


def drive_of(name):
    if name in OTHERS:
        return OTHERS[name]
    study, drive = name.split()
    return loaded(study).drives[drive]


@functools.cache
def exported(name, kind):
    found = iv.export(drive_of(name), kind, Path(FOLDER.name, f"{name}-{kind}".replace(" ", "-")), name=name)
    assert [one for one in found.notes if "rates of the steering angles are inputs" not in one] == []
    return found.files


@functools.cache
def plant_of(name):
    return moving_plant(machine_of_export(drive_of(name)))


def pushed(unit):
    """Inputs of each kind, the same over time."""
    sizes = {"current": 0.1, "rate": 0.2, "user": 0.3, "handle": 1.0}
    return {one: sizes[one.partition(".")[0]] * (-1) ** place for place, one in enumerate(unit.inputs)}


def acting(system, values):
    """Inputs of a system, and what acts on it from outside, by the values of an FMU's inputs in their order."""
    values = np.array(values)
    count, steered, first = len(system.motors), len(system.mechanics.steered), len(system.mechanics.configuration)
    motors, steering, user, force = np.split(values, np.cumsum([count, steered, first]))
    inputs = SystemInputs(currents=motors, steering=steering, turning=steering, links=motors)
    on_all = np.zeros((1, len(system.mechanics.coordinates)))
    on_all[0, :first] = user
    return inputs, SystemOutside(pushed=on_all, force=force[None] if len(force) else None)


class Held:
    """Commands the same inputs at all samples."""

    saturated = types.MappingProxyType({})

    def __init__(self, inputs):
        self.inputs = inputs

    def sample(self, time, state):
        return self.inputs


def own_motion(name, values):
    """States every step of a run with constant inputs."""
    made = plant_of(name)
    inputs, outside = acting(made.system, values)
    user, force = outside.pushed[0, : len(made.system.mechanics.configuration)], outside.force
    hand = None if force is None else replace(made.system.hand, force=lambda time: force[0])
    march = March(
        system=replace(made.system, wrench=lambda time: -user, hand=hand),
        motion=None,
        state=made.start,
        controller=Held(inputs),
        period=STEP,
        duration=DURATION,
        output_step=STEP,
        tolerance=1e-6,
    )
    found = march.over(lambda share: None)
    assert found.outcome == ""
    return found


@sampled("case", BOTH, every=9, slow=3)
def test_importers_find_nothing_to_say(case):
    """By the validator of FMPy; names are of bounded length, and all but the time have units."""
    name, version = case.rsplit(" ", 1)
    (file,) = exported(name, version)
    assert validation.validate_fmu(str(file)) == []
    variables = fmpy.read_model_description(str(file)).modelVariables
    assert max(len(one.name) for one in variables) <= 64
    assert [one.name for one in variables if not one.unit] == []


@sampled("case", BOTH, every=9, slow=3)
def test_it_moves_as_a_run_does(case):
    """Model Exchange by CVode of another program to 1e-6, Co-Simulation to 1e-4 of each state's largest value."""
    name, version = case.rsplit(" ", 1)
    (file,) = exported(name, version)
    with Unit(file) as unit:
        inputs, states = pushed(unit), unit.states
    expected = own_motion(name, list(inputs.values())).states
    given = np.array(
        [(time, *inputs.values()) for time in (0.0, DURATION)], dtype=[(one, float) for one in ("time", *inputs)]
    )
    # FMPy permits CVode 500 steps from one output to the next: contacts that begin to roll need more within 1 ms.
    for kind, error, interval in (("ModelExchange", 1e-6, STEP / 100), ("CoSimulation", 1e-4, STEP)):
        found = fmpy.simulate_fmu(
            str(file),
            fmi_type=kind,
            stop_time=DURATION,
            output_interval=interval,
            relative_tolerance=1e-11,
            input=given,
            output=states,
        )
        at = np.searchsorted(found["time"], STEP * np.arange(len(expected)) - 1e-9)
        for place, state in enumerate(states):
            size = max(np.max(np.abs(expected[:, place])), 1e-3)
            assert np.max(np.abs(found[state][at] - expected[:, place])) <= error * size, (kind, state)


def situations(name, unit, count=12):
    """Random states about the start, fast and slow, and inputs."""
    random, made = np.random.default_rng(3), plant_of(name)
    first = made.system.places[0]
    for place in range(count):
        state, size = made.start.copy(), (1e-3, 1e-1, 1.0)[place % 3]
        state[:first] += random.uniform(-0.005, 0.005, first)
        state[first:] += size * random.standard_normal(len(state) - first)
        values = size * random.standard_normal(len(unit.inputs))
        yield dict(zip([*unit.states, *unit.inputs], [*state, *values], strict=True))


@sampled("case", BOTH, every=9, slow=3)
def test_powers_balance_and_are_those_of_the_python_source(case):
    """Sources less losses are the rate of the energies, along the motion by the FMU's own directional derivatives, to 1e-9 of
    what moves; rates, powers and losses are those of Python, to rounding."""
    name, version = case.rsplit(" ", 1)
    system = plant_of(name).system
    with Unit(exported(name, version)[0], exchange=True) as unit:
        sources, losses, energies = (unit.names(one) for one in ("power.", "loss.", "energy."))
        rates = unit.rates
        for values in situations(name, unit):
            unit.set(values)
            supplied, lost = unit.get(sources), unit.get(losses)
            moved = np.abs(supplied).sum() + np.abs(lost).sum()
            growth = unit.change(energies, unit.states, unit.get(rates)).sum()
            assert abs(supplied.sum() - lost.sum() - growth) <= 1e-9 * (moved + abs(growth))
            assert np.all(lost >= -1e-9 * moved)
            state = np.array([values[one] for one in unit.states])
            inputs, outside = acting(system, [values[one] for one in unit.inputs])
            expected = system.moved(inputs, outside, state[None])
            size = np.max(np.abs(expected.derivative))
            np.testing.assert_allclose(unit.get(rates), expected.derivative[0], rtol=1e-9, atol=1e-12 * size)
            power = expected.balance().power[0]
            assert supplied.sum() == pytest.approx(power[: len(system.sources)].sum(), rel=1e-9, abs=1e-12 * moved)
            assert lost.sum() == pytest.approx(power[len(system.sources) :].sum(), rel=1e-9, abs=1e-12 * moved)
            energy = system.energies(np.zeros(1), state[None])[0, :3].sum()
            assert unit.get(energies).sum() == pytest.approx(energy, rel=1e-12)


@sampled("case", BOTH, every=7, slow=3)
def test_temperatures_follow_the_thermal_model_of_duty_cycles(case):
    """At random states, against the matrix of rates; heat of all windings and of friction of the motors is what they lose."""
    name, version = case.rsplit(" ", 1)
    system, ambient = plant_of(name).system, 285.0
    with Unit(exported(name, version)[0], exchange=True) as unit:
        for values in situations(name, unit):
            unit.set(values)
            state = np.array([values[one] for one in unit.states])[None]
            inputs, outside = acting(system, [values[one] for one in unit.inputs])
            shafts = system.shafts(inputs, state, system.steering(SystemOutside(), state, inputs.turning)[1])
            lost = dict(
                zip(
                    system.losses,
                    system.moved(inputs, outside, state).balance().power[0, len(system.sources) :],
                    strict=True,
                )
            )
            for place, word in enumerate(("winding", "motor friction")):
                of_motors = sum(
                    value for loss, value in lost.items() if loss.endswith((word, word.replace("friction", "iron")))
                )
                assert sum(one.heat[place][0] for one in shafts) == pytest.approx(of_motors, rel=1e-9)
            heated = [one for one in shafts if one.motor.max_winding_temperature is not None]
            assert len(unit.names("temperature.")) == 2 * len(heated)
            for one in heated:
                nodes = [f"temperature.{node}.{one.part.replace(' ', '_')}" for node in ("winding", "housing")]
                unit.set({**dict(zip(nodes, (350.0, 310.0), strict=True)), "ambient_temperature": ambient})
                matrix, vector = heat_rates(one.motor, one.current**2, one.heat[1], ambient)
                found = unit.get([f"der({node})" for node in nodes])
                np.testing.assert_allclose(found, matrix[0] @ (350.0, 310.0) + vector[0], rtol=1e-9)


@sampled("name", EVERY, every=5, slow=2)
def test_directional_derivatives_are_those_of_differences(name):
    """Of rates and outputs, along a random direction; the right width depends on how stiff a contact is."""
    random = np.random.default_rng(7)
    with Unit(exported(name, "fmu2")[0], exchange=True) as unit:
        unknowns = [*unit.rates, *unit.names("loss."), *unit.names("power."), *unit.names("position.")]
        knowns = [*unit.states, *unit.inputs]
        for values in situations(name, unit, 3):
            unit.set(values)
            at = np.array([values[one] for one in knowns])
            seed = random.standard_normal(len(knowns))
            found = unit.change(unknowns, knowns, seed)
            off = []
            for width in (1e-5, 1e-6, 1e-7, 1e-8):
                sides = []
                for side in (width, -width):
                    unit.set(dict(zip(knowns, at + side * seed, strict=True)))
                    sides.append(unit.get(unknowns))
                off.append(np.abs((sides[0] - sides[1]) / (2.0 * width) - found))
            assert np.all(np.min(off, axis=0) <= 1e-4 * np.abs(found) + 1e-6 * np.max(np.abs(found)))


@pytest.mark.parametrize("version", VERSIONS)
def test_steps_with_the_commands_of_a_run_give_its_motion(version):
    """The currents of the controllers of `simulate_machine`, of which a run records those up to each sample."""
    machine = OTHERS["sphere with servo"]
    given = {**MACHINES["sphere"][1], "duration": 0.02, "tolerance": 1e-5}
    period = 1.0 / machine.control.sample_rate
    run = iv.simulate_machine(machine, iv.motion.MachineScenario(**given, output_step=period))
    with Unit(exported("sphere with servo", version)[0]) as unit:
        names = [one for one in unit.inputs if one.startswith("current.")]
        columns = [run.columns[f"{one.partition('.')[2]}_current_A"] for one in names]
        rates = machine.mechanics(1e-4).coordinates
        unit.set({"user.w_2": -0.1})
        start = plant_of("sphere with servo").system.places[0]
        states = [*machine.mechanics(1e-4).configuration, *rates, "gamma_rad", "gamma_rate_rad_s"]
        unit.set({one: run.columns[name][0] for one, name in zip(unit.states, states, strict=True)})
        for row in range(len(run.time) - 1):
            unit.set({name: column[row + 1] for name, column in zip(names, columns, strict=True)})
            unit.step(run.time[row], period)
        for one, name in zip(unit.states[start:], states[start:], strict=True):
            size = np.max(np.abs(run.columns[name]))
            assert unit.get([one])[0] == pytest.approx(run.columns[name][-1], abs=1e-4 * size), name


@sampled("case", BOTH, every=11, slow=4)
def test_instances_resets_and_saved_states_give_the_same_bytes(case):
    name, version = case.rsplit(" ", 1)
    (file,) = exported(name, version)

    def steps(unit, begin, end):
        rows, inputs = [], pushed(unit)
        for row in range(begin, end):
            unit.set({one: value * (1.0 + 0.1 * row) for one, value in inputs.items()})
            unit.step(1e-3 * row, 1e-3)
            rows.append(unit.get(unit.states).tobytes())
        return rows

    with Unit(file) as one, Unit(file) as other:
        both = [(steps(one, row, row + 1), steps(other, row, row + 1)) for row in range(5)]
        assert all(first == second for first, second in both)
        one.assert_saved(lambda: steps(one, 5, 10))
        one.unit.reset()
        one.begin()
        assert steps(one, 0, 5) == [first for (first,), _ in both]


@sampled("case", BOTH, every=11, slow=6)
def test_no_call_does_what_c_does_not_define(case, tmp_path):
    """Random calls with references, sizes and values that no importer has, under the sanitizers of gcc."""
    name, version = case.rsplit(" ", 1)
    assert_defined(exported(name, version)[0], tmp_path)


@sampled("name", EVERY, every=7, slow=3)
def test_c_runs_alone(name, tmp_path):
    """Compiled without a warning, its program moves as the FMU does without inputs."""
    files = exported(name, "c")
    assert not any("laws" in file.name or "laws" in file.read_text("utf-8") for file in files if file.suffix == ".md")
    main = next(file for file in files if file.name.endswith("_main.c"))
    for compiler in filter(None, map(shutil.which, ("gcc", "clang"))):
        subprocess.run([compiler, *WARNINGS, "-O1", main, "-o", tmp_path / "run", "-lm"], check=True)
    out = subprocess.run([tmp_path / "run"], capture_output=True, text=True).stdout
    found = np.array([line.split(", ") for line in out.splitlines()][:6], dtype=float)
    with Unit(exported(name, "fmu2")[0]) as unit:
        for row in range(5):
            unit.step(0.01 * row, 0.01)
        np.testing.assert_allclose(unit.get(unit.every_state), found[-1, 1:], rtol=1e-5, atol=1e-6)


def test_what_cannot_be_exported_is_refused_by_name(tmp_path):
    """MuJoCo, controllers, a load of a machine that has its masses, and a machine that does not move in time."""
    cart, sphere = drive_of("guided_cart cart"), OTHERS["sphere with servo"]
    for drive, kind, given, word in (
        (cart, "mujoco", {}, "machine of type planar"),
        (cart, "fmu2", {"scenario": iv.Scenario(duration=1.0, link="free")}, "scenario"),
        (cart, "fmu2", {"closed": True}, "scenario"),
        (cart, "fmu3", {"load_mass": 1.0}, "load_mass"),
        (sphere, "fmu3", {"load_mass": 1.0}, "load_mass"),
        (loaded("planar_cart").drives["two-wheels"], "c", {}, "mass is missing"),
    ):
        with pytest.raises(iv.ParameterError, match=word):
            iv.export(drive, kind, tmp_path, **given)
    assert list(tmp_path.iterdir()) == []
