"""Exported plants: FMUs that importers accept and that move as the program's own solver, and C that stands alone."""

import ctypes
import functools
import itertools
import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pint
import pytest

import infinivar as iv
from fmu_unit import Unit, assert_defined
from infinivar.bondgraph import solve
from infinivar.motion import Sinusoid
from internals import (
    FloatNamespace,
    Instants,
    bond_graph_model,
    c_library,
    casadi_namespace,
    closed_loop,
    default_export_scenario,
    demands_at,
    export_base_units,
    exported_plant,
    heat_over_run,
    heat_rates,
    plants_of_exports,
    with_values,
)
from made import loaded
from run_cli import run
from sampled import sampled

fmpy = pytest.importorskip("fmpy")
fmi1, validation = (pytest.importorskip(f"fmpy.{name}") for name in ("fmi1", "validation"))
pytestmark = pytest.mark.skipif(c_library.compiler() is None, reason="no C compiler on this machine")

WARNINGS = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-Wconversion", "-pedantic")
VERSIONS = ("fmu2", "fmu3")
STUDIES = ("hand_controller", "knee_walking", "ankle_walking", "one_axis_display", "reach_and_hold", "sphere_joint")
DRIVES = [
    f"{study} {name}"
    for study in STUDIES
    for name, drive in loaded(study).drives.items()
    if isinstance(drive, (iv.CoboticDrive, iv.ConventionalDrive))
]
BOTH = [f"{drive} {version}" for drive, version in itertools.product(DRIVES, VERSIONS)]
IMPOSED = iv.Scenario(duration=1.0, link="imposed", motion=Sinusoid(distance=0.05, frequency=2.0), electrical="voltage")
FOLDER = tempfile.TemporaryDirectory(prefix="infinivar-exports-")


def drive_of(case):
    study, name, *_ = case.split()
    return loaded(study).drives[name]


def scenario_of(case):
    return default_export_scenario(drive_of(case), loaded(case.split()[0]).load_mass)


@functools.cache
def exported(case, kind, scenario=None):
    """Files of a drive of a study."""
    study, name = (loaded(case.split()[0]), case.split()[1])
    folder = Path(FOLDER.name, f"{case}-{kind}-{hash(scenario)}".replace(" ", "-"))
    scenario = scenario or scenario_of(case)
    found = iv.export(study.drives[name], kind, folder, name=name, scenario=scenario, sources=study.provenance)
    assert found.notes == ()
    return found.files


def own_motion(drive, scenario, inputs, times):
    loop = closed_loop(drive, scenario)
    found = solve(loop.graph, times, inputs=inputs, initial=loop.initial)
    assert found.outcome == ""
    return found.states


def pushed(drive, scenario):
    """Inputs that move a drive, the same over time."""
    made = bond_graph_model(closed_loop(drive, scenario).graph)
    return {name: 2.0 if name == "force" else 0.3 for name in made.inputs}


@sampled("case", BOTH, every=8, slow=4)
def test_importers_find_nothing_to_say(case):
    """By the validator of FMPy: schema, names, start values, units, structure. Names are of bounded length."""
    drive, version = case.rsplit(" ", 1)
    (file,) = exported(drive, version)
    assert validation.validate_fmu(str(file)) == []
    assert max(len(one.name) for one in fmpy.read_model_description(str(file)).modelVariables) <= 64
    assert file.stat().st_size <= 200_000


@sampled("case", BOTH, every=9, slow=4)
def test_it_moves_as_the_program_does(case):
    """Model Exchange by CVode of another program to 1e-6, Co-Simulation to 1e-4 of each state's largest value."""
    name, version = case.rsplit(" ", 1)
    drive, scenario = drive_of(name), scenario_of(name)
    inputs, times = pushed(drive, scenario), np.linspace(0.0, 0.2, 101)
    expected = own_motion(drive, scenario, inputs, times)
    (file,) = exported(name, version)
    given = np.array(
        [(time, *inputs.values()) for time in (0.0, 0.2)], dtype=[(one, float) for one in ("time", *inputs)]
    )
    # FMPy permits CVode 500 steps from one output to the next.
    for kind, error, interval in (("ModelExchange", 1e-6, 2e-4), ("CoSimulation", 1e-4, 2e-3)):
        found = fmpy.simulate_fmu(
            str(file),
            fmi_type=kind,
            stop_time=0.2,
            output_interval=interval,
            relative_tolerance=1e-11,
            input=given,
            output=list(expected),
        )
        at = np.searchsorted(found["time"], times - 1e-9)
        for state, values in expected.items():
            size = max(np.max(np.abs(values)), 1e-3)
            assert np.max(np.abs(found[state][at] - values)) <= error * size, (kind, state)


@pytest.mark.parametrize("version", VERSIONS)
def test_steps_with_the_currents_of_a_simulation_give_its_motion(version):
    """The currents of the controllers of `simulate`, of which a run records those up to each sample."""
    drive, scenario = loaded("hand_controller").drives["cobotic"], loaded("hand_controller").scenarios["shake"]
    period = 1.0 / drive.control.sample_rate
    scenario = replace(scenario, duration=200 * period, output_step=period)
    run = iv.simulate(drive, scenario).trajectory
    (file,) = exported("hand_controller cobotic", version, scenario)
    with Unit(file) as unit:
        inputs = {name: run.inputs[name] for name in unit.inputs}
        for row in range(len(run.time) - 1):
            unit.set({name: values[row + 1] for name, values in inputs.items()})
            unit.step(run.time[row], period)
        for state, value in zip(run.states, unit.get(run.states), strict=True):
            assert value == pytest.approx(run.states[state][-1], rel=1e-6, abs=1e-6 * np.max(np.abs(run.states[state])))


@pytest.mark.parametrize("name", ["hand_controller cobotic", "hand_controller motor1-gear1"])
def test_an_imposed_motion_goes_on_with_its_rate(name):
    """Co-Simulation with a motion whose speed is given at the begin of each step: the error falls with the step's square."""
    drive, scenario = drive_of(name), IMPOSED
    (file,) = exported(name, "fmu2", scenario)
    loop = closed_loop(drive, scenario)
    commands = {name: 0.2 for name in bond_graph_model(loop.graph).inputs if name != "motion"}
    path = scenario.path
    expected = solve(
        loop.graph,
        np.linspace(0.0, 0.02, 3),
        inputs={**commands, "motion": loop.inputs["motion"]},
        initial=loop.initial,
    ).states
    errors = []
    for steps in (40, 80):
        with Unit(file) as unit:
            rated = "motion_rate" in unit.place
            for row in range(steps):
                at = path.at(0.02 * row / steps)
                motion = {"motion": at.speed, **({"motion_rate": at.acceleration} if rated else {})}
                unit.set({**commands, **motion})
                unit.step(0.02 * row / steps, 0.02 / steps)
            found = dict(zip(expected, unit.get(expected), strict=True))
            errors.append(
                max(abs(found[one] - values[-1]) / np.max(np.abs(values)) for one, values in expected.items())
            )
    assert errors[0] < (1e-3 if rated else 0.1)
    assert errors[1] < (0.3 if rated else 0.6) * errors[0]


def random_situations(unit, scales=(1e-3, 1e-1, 1.0), count=30):
    random = np.random.default_rng(5)
    for place in range(count):
        size = scales[place % len(scales)]
        names = [*unit.states, *unit.inputs]
        values = size * random.standard_normal(len(names))
        yield dict(zip(names, values, strict=True))


def assert_balanced(file, graph):
    kinds = {one.name: one.kind for one in graph.elements}
    sources = [name for name, kind in kinds.items() if kind in ("Se", "Sf")]
    with Unit(file, exchange=True) as unit:
        powers = unit.names("power.")
        losses = [one for one in unit.names("loss.") if one not in [f"loss.{source}" for source in sources]]
        signs = np.array([1.0 if one.partition(".")[2] in sources else -1.0 for one in powers])
        rates = [one for one in unit.inputs if one.endswith("_rate")]
        energies, stored = unit.names("energy."), [one.replace("energy.", "power.") for one in unit.names("energy.")]
        for values in random_situations(unit):
            unit.set(values)
            moved, lost = signs * unit.get(powers), unit.get(losses)
            assert abs(moved.sum() - lost.sum()) <= 1e-9 * (np.abs(moved).sum() + np.abs(lost).sum())
            assert np.all(lost >= -1e-9 * np.abs(moved).sum())
            along = [*unit.states, *(one.removesuffix("_rate") for one in rates)]
            growth = unit.change(energies, along, unit.get([*unit.rates, *rates]))
            np.testing.assert_allclose(growth, unit.get(stored), atol=1e-9 * np.abs(moved).sum(), rtol=1e-9)


@sampled("case", BOTH, every=7, slow=4)
def test_powers_balance_and_energies_change_by_them(case):
    """Sources = storages + losses to 1e-9 of what moves, at any state; and what a storage takes up is the derivative of its
    energy, here along the motion by the FMU's own directional derivatives."""
    name, version = case.rsplit(" ", 1)
    assert_balanced(exported(name, version)[0], closed_loop(drive_of(name), scenario_of(name)).graph)


@pytest.mark.parametrize("changes", [{}, {"electrical": "current"}, {"link": "free", "motion": None}])
@pytest.mark.parametrize("name", ["hand_controller cobotic", "hand_controller motor1-gear1"])
def test_powers_balance_with_other_loads_and_amplifiers(name, changes):
    steering = {"steering": "locked"} if "cobotic" in name and "link" in changes else {}
    scenario = replace(IMPOSED, **changes, **steering)
    (file,) = exported(name, "fmu3", scenario)
    assert validation.validate_fmu(str(file)) == []
    assert_balanced(file, closed_loop(drive_of(name), scenario).graph)


MOTOR = iv.motors()["dcx-32-l-24v"]
PROGRESSIVE = {"shape": "progressive", "deflections": (-0.3, 0.0, 0.3), "forces": (-2.0, 0.0, 3.0)}
TORSIONAL = iv.parts.TorsionSpring(**PROGRESSIVE)
LEVER = iv.Output(linkage=iv.parts.Linkage(shape="lever", arm=0.05), parallel_torsion_spring=TORSIONAL)
SOFT = iv.Output(series_spring=iv.parts.Spring(stiffness=3e4, hysteresis=2.0))
MEASURED = iv.parts.GearFriction(friction=0.02, viscous=0.001, load_motor=0.1, load_output=0.05, friction_stribeck=0.02)
GEARS = {
    "rigid": iv.parts.Gearhead(ratio=10, efficiency=0.85),
    "elastic": iv.parts.Gearhead(ratio=10, efficiency=0.85, stiffness=600.0, backlash=0.01),
    "measured": iv.parts.Gearhead(ratio=5, loss_model="stribeck", friction=MEASURED),
}
LOCKING = iv.parts.Screw(lead=0.01, diameter=0.016, friction_coefficient=0.3, inertia=1e-5)
STRETCHED = iv.parts.Belt(pitch=3e-3, teeth=20, specific_stiffness=1e5, span=0.5)
OTHERS = {
    "elastic shaft": iv.ConventionalDrive(
        motor=MOTOR, gearhead=GEARS["elastic"], shaft=iv.parts.Shaft(), output_inertia=1e-4
    ),
    "locking screw": iv.ConventionalDrive(motor=MOTOR, gearhead=GEARS["rigid"], screw=LOCKING),
    "stretched belt": iv.ConventionalDrive(motor=MOTOR, gearhead=GEARS["elastic"], belt=STRETCHED, output_inertia=1e-4),
    "measured rack": iv.ConventionalDrive(
        motor=MOTOR, gearhead=GEARS["measured"], rack=iv.parts.Rack(module=1e-3, teeth=20, efficiency=0.9)
    ),
    "screw with lever": iv.ConventionalDrive(
        motor=MOTOR,
        gearhead=GEARS["measured"],
        screw=iv.parts.Screw(lead=0.01, diameter=0.016, efficiency=0.85),
        output=LEVER,
        output_inertia=1e-6,
    ),
    "cobotic with lever": replace(loaded("hand_controller").drives["cobotic-b"], output=LEVER),
    "cobotic with spring": replace(loaded("hand_controller").drives["cobotic"], output=SOFT),
}


@sampled("name", OTHERS, every=3)
def test_other_parts_are_exported_as_well(name):
    """Elastic, self-locking and measured parts, springs and linkages: valid, balanced, all with units, and as the program."""
    drive = OTHERS[name]
    scenario = default_export_scenario(drive, 0.5)
    found = iv.export(drive, "fmu3", Path(FOLDER.name, name.replace(" ", "-")), scenario=scenario)
    assert validation.validate_fmu(str(found.files[0])) == []
    assert [one.name for one in fmpy.read_model_description(str(found.files[0])).modelVariables if not one.unit] == []
    assert_balanced(found.files[0], closed_loop(drive, scenario).graph)
    inputs, times = pushed(drive, scenario), np.linspace(0.0, 0.05, 11)
    expected = own_motion(drive, scenario, inputs, times)
    with Unit(found.files[0]) as unit:
        unit.set(inputs)
        for time in times[:-1]:
            unit.step(time, 5e-3)
        for one, value in zip(expected, unit.get(expected), strict=True):
            assert value == pytest.approx(expected[one][-1], abs=1e-4 * max(np.max(np.abs(expected[one])), 1e-6))


@sampled("case", BOTH, every=11, slow=6)
def test_values_are_those_of_the_python_source_and_directional_derivatives_exact(case):
    """Values to rounding, derivatives of all by all as CasADi derives the source."""
    casadi = pytest.importorskip("casadi")
    name, version = case.rsplit(" ", 1)
    graph = closed_loop(drive_of(name), scenario_of(name)).graph
    made = bond_graph_model(graph)
    parameters = {symbol: parameter.value for symbol, parameter in graph.parameters.items()}
    knowns = [*made.states, *made.inputs, *(f"{one}_rate" for one in made.rates)]
    sizes = [len(one) for one in (made.states, made.inputs, made.rates)]

    def computed(xp, given):
        groups = [list(one) for one in np.split(np.array(given, dtype=object), np.cumsum(sizes)[:-1])]
        outputs = made.function("outputs", xp, parameters)(*groups)
        return [*made.function("motion", xp, parameters)(*groups), *outputs[len(outputs) - len(made.losses) :]]

    symbols = casadi.SX.sym("known", len(knowns))
    found = casadi.vertcat(*computed(casadi_namespace(), casadi.vertsplit(symbols)))
    slopes = casadi.Function("slopes", [symbols], [casadi.jacobian(found, symbols)])
    (file,) = exported(name, version)
    with Unit(file, exchange=True) as unit:
        unknowns = [*unit.rates, *unit.names("loss.")]
        for values in random_situations(unit, scales=(0.1, 1.0), count=6):
            unit.set(values)
            given = [float(values[one]) for one in knowns]
            expected, got = np.array(computed(FloatNamespace, given)), unit.get(unknowns)
            assert np.all(np.abs(got - expected) <= 1e-12 * (np.abs(expected) + 1e-3 * np.max(np.abs(expected))))
            expected = np.array(slopes(given))
            got = np.array([unit.change(unknowns, [one], [1.0]) for one in knowns]).T
            scale = np.abs(expected) + 1e-3 * np.max(np.abs(expected), axis=1, keepdims=True)
            assert np.all(np.abs(got - expected) <= 1e-9 * scale)


@sampled("case", BOTH, every=11, slow=6)
def test_demands_are_those_that_a_simulation_judges(case):
    """At random states and inputs; of motors over the currents and voltages that the FMU shows."""
    name, version = case.rsplit(" ", 1)
    drive, graph = drive_of(name), closed_loop(drive_of(name), scenario_of(name)).graph
    made = bond_graph_model(graph)
    parameters = {symbol: parameter.value for symbol, parameter in graph.parameters.items()}
    with Unit(exported(name, version)[0], exchange=True) as unit:
        for values in random_situations(unit, scales=(0.1, 1.0), count=6):
            unit.set(values)
            groups = [[float(values[one]) for one in own] for own in (made.states, made.inputs)]
            rates = [float(values[f"{one}_rate"]) for one in made.rates]
            rows = [np.array([one]) for one in made.function("outputs", FloatNamespace, parameters)(*groups, rates)]
            count = len(made.bonds)
            at = Instants(
                graph=graph,
                time=np.zeros(1),
                states={one: np.array([values[one]]) for one in made.states},
                signals=dict(zip(made.signals, rows[2 * count :], strict=False)),
                efforts=dict(zip(made.bonds, rows, strict=False)),
                flows=dict(zip(made.bonds, rows[count:], strict=False)),
            )
            found = demands_at(drive, at)
            names = [one for one in unit.names("demand.") if not one.startswith("demand.TEMPERATURE.")]
            assert len(names) >= 3
            wanted = {
                f"demand.{limit.name}.{part.replace(' ', '_')}": demand[0] for (limit, part), demand in found.items()
            }
            np.testing.assert_allclose(unit.get(names), [wanted[one] for one in names], rtol=1e-9, atol=1e-12)
            source = "cylinder.source" if isinstance(drive, iv.CoboticDrive) else "source"
            voltage, current = unit.get([f"voltage.{source}", source])
            thermal, demand = unit.get(["demand.THERMAL.motor", "demand.VOLTAGE.motor"])
            assert thermal == pytest.approx(abs(current) / drive.motor.continuous_current)
            assert demand == pytest.approx(abs(voltage) / drive.motor.voltage)


@pytest.mark.slow
@pytest.mark.parametrize("version", VERSIONS)
def test_importers_build_it_from_its_sources(version, monkeypatch, tmp_path):
    """By FMPy's own rules for CMake, from the description of the build alone."""
    build = pytest.importorskip("fmpy.build")
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")
    if shutil.which("cmake") is None:
        pytest.skip("no CMake on this machine")
    monkeypatch.setenv(c_library.SWITCH, "0")
    found = iv.export(drive_of("hand_controller motor1-gear1"), version, tmp_path)
    folder = fmpy.extract(str(found.files[0]), tmp_path / "unpacked")
    (tmp_path / "build").mkdir()
    build.build_platform_binary(folder, tmp_path / "build")
    run = fmpy.simulate_fmu(folder, stop_time=0.1, start_values={"source": 0.5}, output=["l"])
    assert run["l"][-1] > 1e-3


@pytest.mark.parametrize("version", VERSIONS)
def test_what_is_not_finite_is_an_error_and_changes_nothing(version):
    (file,) = exported("hand_controller cobotic", version)
    error = fmi1.FMICallException
    with Unit(file) as unit:
        unit.set({"force": 2.0, "steering.source": 0.1})
        unit.step(0.0, 1e-2)
        every = [*unit.states, *unit.inputs, *unit.of("parameter"), "time"]
        before = unit.get(every)
        for number in (np.nan, np.inf):
            with pytest.raises(error):
                unit.set({"steering.source": 0.5, "force": number})
            with pytest.raises(error):
                unit.step(1e-2, number)
            np.testing.assert_array_equal(unit.get(every), before)
        for step in (0.0, -1e-3):
            with pytest.raises(error):
                unit.step(1e-2, step)
        for wrong in ("time", "der(l)", "loss.link.guideway"):
            with pytest.raises(error):
                unit.set({wrong: 0.0})
        np.testing.assert_array_equal(unit.get(every), before)
        unit.set({"force": 1e300})
        with pytest.raises(error):
            unit.step(1e-2, 1e-2)
        unit.set({"force": 2.0})
        np.testing.assert_array_equal(unit.get(every), before)
        unit.step(1e-2, 1e-2)
        assert np.all(np.isfinite(unit.get(unit.of("output"))))


@pytest.mark.parametrize("version", VERSIONS)
def test_a_parameter_keeps_the_bounds_of_its_part(version):
    """They are in the description; a value beyond them is refused with all others of the call, and the state before stays."""
    for name in ("hand_controller cobotic", "ankle_walking geared"):
        (file,) = exported(name, version)
        drive = drive_of(name)
        variables = {one.name: one for one in fmpy.read_model_description(str(file)).modelVariables}
        with Unit(file) as unit:
            every = [*unit.states, *unit.of("parameter")]
            before = unit.get(every)
            ranged = [one for one in unit.of("parameter") if variables[one].min is not None]
            for one in ranged:
                low = float(variables[one].min)
                assert low <= float(variables[one].start) <= float(variables[one].max or np.inf)
                with pytest.raises(fmi1.FMICallException):
                    unit.set({unit.states[0]: 0.1, one: np.nextafter(low, -np.inf)})
                np.testing.assert_array_equal(unit.get(every), before)
                unit.set({one: max(low, 1e-3)})
                unit.set({one: float(variables[one].start)})
            assert {one for one in every if one.startswith(("parameter.J_", "parameter.m", "parameter.R_"))} <= set(
                ranged
            )
        for symbol, path in {
            "J_m_c": "motor.rotor_inertia",
            "J_gpc": "screw.inertia",
            "K_n": "motor.torque_constant",
        }.items():
            if (one := variables.get(f"parameter.{symbol}")) is not None:
                with_values(drive, {path: float(one.min)})
                with pytest.raises(iv.ParameterError):
                    with_values(drive, {path: float(one.min) - 1e-12})


@pytest.mark.parametrize("version", VERSIONS)
def test_a_step_begins_at_the_time_that_is_reached(version):
    """Nothing changes then; after a saved state is set it may."""
    (file,) = exported("hand_controller cobotic", version)
    with Unit(file) as unit:
        unit.set({"force": 2.0})
        for row in range(10):  # as importers add up times
            unit.step(row * 1e-3, 1e-3)
        every = [*unit.states, "time"]
        before = unit.get(every)
        for time in (0.0, 9e-3, -1.0, 0.5):
            with pytest.raises(fmi1.FMICallException):
                unit.step(time, 1e-3)
            np.testing.assert_array_equal(unit.get(every), before)
        unit.step(sum([1e-3] * 10), 1e-3)
        assert unit.get(["time"])[0] == pytest.approx(11e-3)


@pytest.mark.parametrize("version", VERSIONS)
def test_instances_resets_and_saved_states_give_the_same_bytes(version):
    (file,) = exported("hand_controller cobotic", version)

    def steps(unit, begin, end):
        rows = []
        for row in range(begin, end):
            unit.set({"force": 1.0 + 0.1 * row, "steering.source": 0.02 * (-1) ** row})
            unit.step(1e-3 * row, 1e-3)
            rows.append(unit.get([*unit.states, *unit.of("output")]).tobytes())
        return rows

    with Unit(file) as one, Unit(file) as other:
        both = [(steps(one, row, row + 1), steps(other, row, row + 1)) for row in range(20)]
        assert all(first == second for first, second in both)
        one.assert_saved(lambda: steps(one, 20, 40))
        one.set({one.of("parameter")[0]: 1.0})
        one.unit.reset()
        one.begin()
        assert steps(one, 0, 20) == [first for (first,), _ in both]


def test_a_parameter_set_is_that_of_a_drive_built_with_it():
    drive = drive_of("hand_controller cobotic")
    (file,) = exported("hand_controller cobotic", "fmu2")
    heavier = replace(drive, motor=replace(drive.motor, resistance=3.0), cylinder_inertia=4e-3)
    found = iv.export(heavier, "fmu2", Path(FOLDER.name, "heavier"), scenario=scenario_of("hand_controller cobotic"))
    with Unit(file, exchange=True) as unit, Unit(found.files[0], exchange=True) as other:
        outputs = [*unit.rates, *unit.of("output")]
        assert not np.array_equal(unit.get(outputs), other.get(outputs))
        unit.set({"parameter.R_c": 3.0, "parameter.J_c": 4e-3})
        for values in random_situations(unit):
            unit.set(values)
            other.set(values)
            np.testing.assert_array_equal(unit.get(outputs), other.get(outputs))


def test_parameters_that_decide_tables_are_constants():
    """Their tables are data of the export, which a change would leave behind."""
    (file,) = exported("ankle_walking cobotic", "fmu2")
    description = fmpy.read_model_description(str(file))
    constant = [one.name for one in description.modelVariables if one.variability == "constant"]
    assert "parameter.a_over_b" in constant
    with Unit(file, exchange=True) as unit, pytest.raises(fmi1.FMICallException):
        unit.set({"parameter.a_over_b": 0.5})


def test_descriptions_say_what_the_study_says():
    (file,) = exported("hand_controller cobotic", "fmu3")
    said = {one.name: one for one in fmpy.read_model_description(str(file)).modelVariables}
    row = next(
        one for one in loaded("hand_controller").provenance if (one.owner, one.field) == ("cobotic", "motor.resistance")
    )
    assert said["parameter.R_c"].description.endswith(
        f"from motor.resistance = {row.written} ({row.kind}, {row.where})"
    )
    assert said["parameter.R_c"].unit == "ohm"
    assert float(said["cylinder.J_c"].start) == loaded("hand_controller").drives["cobotic"].cylinder_speed
    assert said["voltage.cylinder.source"].unit == "V"


def test_words_of_a_study_do_no_harm(tmp_path):
    """Marks of XML, of C and of tables, and control characters in names, titles and sources."""
    odd = 'a"b<c>&d\x01\n|*/\\'
    drive, study = drive_of("hand_controller motor1-gear1"), loaded("hand_controller")
    sources = [replace(row, owner=odd, where=odd) for row in study.provenance if row.owner == "motor1-gear1"]
    for kind in (*VERSIONS, "c"):
        found = iv.export(drive, kind, tmp_path, name=odd, title=odd, sources=sources)
        if kind == "c":
            subprocess.run(
                [*c_library.compiler(), *WARNINGS, found.files[1], "-o", tmp_path / "run", "-lm"], check=True
            )
        else:
            assert validation.validate_fmu(str(found.files[0])) == []


@pytest.mark.parametrize("version", VERSIONS)
def test_every_function_of_the_standard_is_there(version, tmp_path):
    """As the headers that FMPy ships list them; and without a warning of a compiler."""
    (file,) = exported("hand_controller cobotic", version)
    headers = Path(fmpy.__file__).parent / "c-code" / f"fmi{version[-1]}Functions.h"
    names = set(re.findall(rf"\bfmi{version[-1]}[A-Z]\w+(?=TYPE\b)", headers.read_text("utf-8")))
    assert len(names) > (30 if version == "fmu2" else 70)
    with zipfile.ZipFile(file) as archive:
        archive.extractall(tmp_path)
    binary = ctypes.CDLL(str(next((tmp_path / "binaries").rglob("*.so"))))
    assert [name for name in sorted(names) if not hasattr(binary, name)] == []
    assert not hasattr(binary, "cobotic_advance")
    (source,) = (tmp_path / "sources").glob("*.c")
    for compiler in filter(None, map(shutil.which, ("gcc", "clang"))):
        done = subprocess.run(
            [compiler, *WARNINGS, "-O1", "-c", source, "-o", tmp_path / "model.o"], capture_output=True, text=True
        )
        assert done.returncode == 0, done.stderr


@sampled("case", BOTH, every=13, slow=8)
def test_no_call_does_what_c_does_not_define(case, tmp_path):
    """Random calls with references, sizes and values that no importer has, under the sanitizers of gcc."""
    (file,) = exported(*case.rsplit(" ", 1))
    assert_defined(file, tmp_path)


@pytest.mark.parametrize("version", VERSIONS)
def test_a_state_of_another_model_or_of_none_is_refused(version):
    """By its bytes, of which those of the same length are of another drive's FMU, or all 0."""
    (file,), (other,) = exported("hand_controller cobotic", version), exported("hand_controller motor1-gear1", version)
    with Unit(file) as one, Unit(other) as another:
        suffix = "State" if one.third else "state"
        read = getattr(one.unit, f"deserializeFMU{suffix}" if one.third else f"deSerializeFMU{suffix}")
        content = getattr(one.unit, f"serializeFMU{suffix}")(getattr(one.unit, f"getFMU{suffix}")())
        foreign = getattr(another.unit, f"serializeFMU{suffix}")(getattr(another.unit, f"getFMU{suffix}")())
        read(content)
        for wrong in (bytes(len(content)), (foreign + content)[: len(content)], content[:-8]):
            with pytest.raises(Exception, match="failed with status"):
                read(wrong)


@pytest.mark.parametrize("sources", [5, "here", [None]])
def test_sources_that_are_no_provenance_are_refused(sources, tmp_path):
    with pytest.raises(iv.InputError, match=r"sources must be rows of provenance, such as study.provenance, got"):
        iv.export(drive_of("hand_controller cobotic"), "fmu2", tmp_path, sources=sources)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("version", VERSIONS)
def test_calls_before_the_initialisation_or_after_the_end_are_errors(version):
    """Values are known from the initialisation on, also after the end; steps are taken between the two."""
    (file,) = exported("hand_controller motor1-gear1", version)
    with Unit(file) as one:
        one.unit.reset()
        for call in (lambda: one.get(one.states), lambda: one.step(0.0, 1e-3)):
            with pytest.raises(Exception, match="failed with status"):
                call()
        one.begin()
        one.step(0.0, 1e-3)
        with pytest.raises(Exception, match="failed with status"):
            one.begin()
        one.unit.terminate()
        one.get(one.states)
        with pytest.raises(Exception, match="failed with status"):
            one.step(1e-3, 1e-3)


@sampled("name", DRIVES, every=5, slow=3)
def test_c_runs_alone(name, tmp_path):
    """Compiled without a warning, its program prints the motion of the program's own solver."""
    files = exported(name, "c")
    program = tmp_path / "run"
    main = next(file for file in files if file.name.endswith("_main.c"))
    for compiler in filter(None, map(shutil.which, ("gcc", "clang"))):
        subprocess.run([compiler, *WARNINGS, "-O1", main, "-o", program, "-lm"], check=True)
    rows = [line.split(", ") for line in subprocess.run([program], capture_output=True, text=True).stdout.splitlines()]
    found = np.array(rows, dtype=float)
    drive, scenario = drive_of(name), scenario_of(name)
    inputs = dict.fromkeys(pushed(drive, scenario), 0.0)
    expected = own_motion(drive, scenario, inputs, found[:, 0])
    for column, (state, values) in enumerate(expected.items(), start=1):
        np.testing.assert_allclose(
            found[:, column], values, rtol=1e-6, atol=1e-6 * np.max(np.abs(values)) + 1e-9, err_msg=state
        )


def test_several_plants_are_linked_into_one_program(tmp_path):
    """As C, and as FMUs whose functions have a prefix, which importers of sources ask for."""
    objects = []
    for name in ("hand_controller motor1-gear1", "hand_controller motor2-gear4"):
        source = exported(name, "c")[0]
        for version in VERSIONS:
            with zipfile.ZipFile(exported(name, version)[0]) as archive:
                (inner,) = [one for one in archive.namelist() if one.endswith(".c")]
                (tmp_path / f"{version}_{source.name}").write_bytes(archive.read(inner))
        for kind, file in (("c", source), *((one, tmp_path / f"{one}_{source.name}") for one in VERSIONS)):
            objects.append(tmp_path / f"{kind}_{source.stem}.o")
            prefix = f"-DFMI{kind[-1]}_FUNCTION_PREFIX={source.stem}_"
            compiler = c_library.compiler()
            subprocess.run([*compiler, "-std=c99", "-fPIC", prefix, "-c", file, "-o", objects[-1]], check=True)
    for kind in ("c", *VERSIONS):
        linked = tmp_path / f"{kind}.so"
        own = [one for one in objects if one.name.startswith(f"{kind}_")]
        subprocess.run([*c_library.compiler(), "-shared", "-o", linked, *own, "-lm"], check=True)
        library = ctypes.CDLL(str(linked))
        for drive in ("motor1_gear1", "motor2_gear4"):
            function = "advance" if kind == "c" else f"fmi{kind[-1]}GetVersion"
            assert hasattr(library, f"{drive}_{function}")


@pytest.mark.parametrize("kind", [*VERSIONS, "c"])
def test_the_same_drive_gives_the_same_bytes(kind, tmp_path):
    for file in exported("hand_controller motor1-gear1", kind):
        drive = drive_of("hand_controller motor1-gear1")
        again = iv.export(
            drive,
            kind,
            tmp_path,
            name="motor1-gear1",
            scenario=scenario_of("hand_controller motor1-gear1"),
            sources=loaded("hand_controller").provenance,
        )
        assert file.name in [one.name for one in again.files]
        assert (tmp_path / file.name).read_bytes() == file.read_bytes()


@pytest.mark.parametrize(
    ("version", "module", "name", "there", "why"),
    [
        ("fmu3", c_library, "_found", lambda own: None, "no C compiler"),
        ("fmu2", platform, "machine", lambda: "aarch64", "FMI 2.0 has no name for this platform"),
        ("fmu3", platform, "machine", lambda: "riscv64", "FMI 3.0 has no name for this platform"),
        ("fmu3", c_library, "_found", lambda own: shutil.which("false"), "the C compiler failed: without a word"),
    ],
)
def test_without_a_binary_an_fmu_holds_sources(version, module, name, there, why, monkeypatch, tmp_path):
    drive = drive_of("hand_controller motor1-gear1")
    monkeypatch.setattr(c_library.extras, "there", lambda library: False)
    expected = iv.export(drive, version, tmp_path / "first").files[0]
    monkeypatch.setattr(module, name, there)
    found = iv.export(drive, version, tmp_path)
    assert found.notes == (f"sources only ({why}): the importer must compile the FMU",)
    with zipfile.ZipFile(found.files[0]) as archive, zipfile.ZipFile(expected) as whole:
        names = [one for one in whole.namelist() if not one.startswith("binaries")]
        assert archive.namelist() == names
        assert all(archive.read(one) == whole.read(one) for one in names)
    assert validation.validate_fmu(str(found.files[0])) == []


def law(force):
    """A law of a user's own."""
    own = {"creepage": lambda x: x + 0.25 * x * abs(x), "slope": lambda x: 1.0 + 0.5 * abs(x), "force": force}
    return iv.contact.CreepLaw(name="soft", slip_creepage=1.25, **own)


def own_force(xi):
    xp = iv.array_namespace(xi)
    xi = xp.clip(xi, -1.25, 1.25)
    return 2.0 * xi / (1.0 + xp.sqrt(1.0 + xp.abs(xi)))


def force_of_numpy(xi):
    xi = np.clip(xi, -1.25, 1.25)
    return 2.0 * xi / (1.0 + np.sqrt(1.0 + np.abs(xi)))


def test_a_law_of_one_s_own_is_exported_if_it_has_c(tmp_path):
    drive = drive_of("hand_controller cobotic")
    with_law = [
        replace(drive, transmission=replace(drive.transmission, creep_law=law(force)))
        for force in (own_force, force_of_numpy)
    ]
    with pytest.raises(iv.InputError, match="a law of the drive has no C"):
        iv.export(with_law[1], "c", tmp_path / "out")
    assert list(tmp_path.iterdir()) == []
    found = iv.export(with_law[0], "fmu2", tmp_path)
    scenario = default_export_scenario(drive, None)
    inputs, times = pushed(drive, scenario), np.linspace(0.0, 0.05, 11)
    expected = own_motion(with_law[0], scenario, inputs, times)
    with Unit(found.files[0]) as unit:
        unit.set(inputs)
        for time in times[:-1]:
            unit.step(time, 5e-3)
        for one, value in zip(expected, unit.get(expected), strict=True):
            assert value == pytest.approx(expected[one][-1], rel=1e-6, abs=1e-9)


def test_a_law_that_fails_in_c_alone_is_bad_input(monkeypatch, tmp_path):
    def refused(*arguments):
        raise TypeError("a recorded value has no truth value")

    monkeypatch.setattr(plants_of_exports, "c_code", refused)
    with pytest.raises(iv.InputError, match="a law of the drive has no C"):
        iv.export(drive_of("hand_controller motor1-gear1"), "c", tmp_path / "out")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "unit",
    [
        "1",
        "N",
        "N m",
        "N m/A",
        "kg m^2",
        "ohm",
        "H",
        "V/A",
        "rad/s",
        "rad/s^2",
        "m/s^2",
        "rad/(N m)",
        "N m s",
        "W",
        "J",
    ],
)
def test_units_in_base_units_are_those_of_a_library_of_units(unit):
    """Of angles a library of units has none left."""
    short = {"kilogram": "kg", "meter": "m", "second": "s", "ampere": "A", "radian": "rad"}
    found = pint.UnitRegistry().Quantity(1.0, "" if unit == "1" else unit).to_base_units()
    assert found.magnitude == 1.0
    assert export_base_units(unit) == {short[name]: power for name, power in found._units.items()}


def test_every_variable_of_a_shipped_drive_has_a_unit():
    for case in DRIVES:
        made = exported_plant(drive_of(case), scenario_of(case), "one", "one", ())
        assert [one.name for one in made.variables if not one.unit] == []


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("hand_controller", "cobotic", "--as", "fmu1"), "--as 'fmu1' is not a format"),
        (("hand_controller", "cobotic"), "Missing option '--as'"),
        (
            ("hand_controller", "cobotix", "--as", "c"),
            ": drive 'cobotix' is not in the study (did you mean 'cobotic'?)",
        ),
        (("hand_controller", "cobotic", "--as", "c", "--scenario", "shak"), "--scenario 'shak' is not in the study"),
        (("hand_controller", "cobotic", "--as", "c", "--loop", "shak"), "--loop 'shak' is not in the study"),
        (
            ("hand_controller", "cobotic", "--as", "mujoco", "--loop", "shake"),
            "--loop does not apply to --as mujoco",
        ),
        (("six_leg_display", "one-motor", "--as", "mujoco"), "a machine of type platform"),
        (("hand_controller", "cobotic", "--as", "c", "--out", "file"), "file"),
    ],
)
def test_bad_input_is_one_message_and_no_file(arguments, said, tmp_path):
    (tmp_path / "file").write_text("taken")
    outcome = run("export", *arguments, folder=tmp_path)
    assert (outcome.code, outcome.out) == (2, "")
    assert said in outcome.err
    assert [one.name for one in tmp_path.iterdir()] == ["file"]


@pytest.mark.parametrize("number", [1, 2])
def test_the_first_drive_needs_no_name(number, tmp_path):
    drives = "".join(f'[drives.{name}]\nbase = "faulring2006.motor1-gear1"\n' for name in ("one", "two")[:number])
    (tmp_path / "study.toml").write_text(f'[requirement]\nbase = "faulring2006"\n{drives}')
    outcome = run("export", "study.toml", "--as", "fmu3", folder=tmp_path)
    assert (outcome.code, outcome.out) == (0, "Wrote out/one.fmu\n")
    assert ("no drive given: using one, the first of one, two" in outcome.err) == (number == 2)
    assert "--drive" not in outcome.err


@pytest.mark.parametrize("names", [("a-b", "a_b"), ("y" * 50 + "1", "y" * 50 + "2")])
def test_drives_of_one_name_in_c_are_refused(names, tmp_path):
    drives = "".join(f'[drives.{name}]\nbase = "faulring2006.motor1-gear1"\n' for name in names)
    (tmp_path / "study.toml").write_text(f'[requirement]\nbase = "faulring2006"\n{drives}')
    outcome = run("export", "study.toml", names[1], "--as", "c", folder=tmp_path)
    assert (outcome.code, outcome.out) == (2, "")
    assert f"drives '{names[1]}' and '{names[0]}' would both be written as" in outcome.err
    assert [one.name for one in tmp_path.iterdir()] == ["study.toml"]


def test_no_drive_overwrites_files_of_another(tmp_path):
    """Not even of one whose name it has with the ending of one of these files."""
    drive, written = loaded("hand_controller").drives["motor1-gear1"], []
    for name in ("a", "a-laws", "a-main", "a-laws-test", "a-laws-drive", "a_laws_laws"):
        written += [file.name for file in iv.export(drive, "c", tmp_path, name=name).files]
    assert len(set(written)) == len(written)


def test_the_command_writes_what_the_function_does(tmp_path):
    """Load, amplifier and start are those of a scenario."""
    outcome = run("export", "hand_controller", "cobotic", "--as", "fmu2", "--scenario", "shake", folder=tmp_path)
    assert (outcome.code, outcome.out) == (0, "Wrote out/cobotic.fmu\n")
    study = loaded("hand_controller")
    iv.export(
        study.drives["cobotic"],
        "fmu2",
        tmp_path / "again",
        name="cobotic",
        title=study.titles["cobotic"],
        scenario=study.scenarios["shake"],
        sources=study.provenance,
    )
    assert (tmp_path / "again" / "cobotic.fmu").read_bytes() == (tmp_path / "out" / "cobotic.fmu").read_bytes()


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"kind": "fmu4"}, "kind must be one of fmu2, fmu3, c, mujoco, got 'fmu4'"),
        ({"drive": "cobotic"}, "drive"),
        ({"drive": loaded("six_leg_display").drives["one-motor"], "kind": "mujoco"}, "machine"),
        ({"scenario": "shake"}, "scenario"),
        ({"out": 3}, "out must be the path"),
        ({"drive": replace(loaded("hand_controller").drives["cobotic"], steering=None)}, "steering is missing"),
    ],
)
def test_bad_arguments_are_one_message(changes, said, tmp_path):
    given = {"drive": drive_of("hand_controller cobotic"), "kind": "c", "out": tmp_path / "out", **changes}
    with pytest.raises(iv.InputError, match=re.escape(said)):
        iv.export(**given)
    assert list(tmp_path.iterdir()) == []


@sampled("case", BOTH, every=9, slow=4)
def test_temperatures_follow_the_thermal_model_of_duty_cycles(case):
    """At random states and temperatures, against the matrix of rates by the current and the friction that the FMU shows; and
    the demand is the rise over the permissible one."""
    name, version = case.rsplit(" ", 1)
    drive, ambient = drive_of(name), 285.0
    prefixes = (
        {"motor": "cylinder.", "steering motor": "steering."} if isinstance(drive, iv.CoboticDrive) else {"motor": ""}
    )
    motors = {"motor": drive.motor, **({"steering motor": drive.steering.motor} if len(prefixes) == 2 else {})}
    with Unit(exported(name, version)[0], exchange=True) as unit:
        heated = [what for what in motors if motors[what].max_winding_temperature is not None]
        assert len(unit.names("temperature.")) == 2 * len(heated)
        if heated:
            unit.set({"parameter.ambient_temperature": ambient})
        for values in random_situations(unit, scales=(0.1, 1.0), count=6):
            unit.set(values)
            for what in heated:
                motor, word = motors[what], what.replace(" ", "_")
                nodes = [f"temperature.{node}.{word}" for node in ("winding", "housing")]
                unit.set(dict(zip(nodes, (350.0, 310.0), strict=True)))
                current = unit.get([f"{prefixes[what]}source"])[0]
                friction = unit.get(unit.names(f"loss.{prefixes[what]}motor_friction")).sum()
                matrix, vector = heat_rates(motor, current**2, friction, ambient)
                found = unit.get([f"der({one})" for one in nodes])
                np.testing.assert_allclose(found, matrix[0] @ (350.0, 310.0) + vector[0], rtol=1e-9)
                rise = (350.0 - ambient) / (motor.max_winding_temperature - ambient)
                assert unit.get([f"demand.TEMPERATURE.{word}"])[0] == pytest.approx(rise, rel=1e-12)


@pytest.mark.parametrize("version", VERSIONS)
def test_a_stalled_motor_warms_up_as_over_a_run(version):
    """Five minutes in Co-Simulation at most of the continuous current, against `heat.heat_over_run`, to 1e-6 of the rise."""
    drive = drive_of("hand_controller motor1-gear1")
    current = 0.9 * drive.motor.continuous_current
    expected = heat_over_run(drive.motor, np.full(3000, current), np.zeros(3000), 300.0)
    held = drive.motor.torque_constant * current * drive.gearhead.ratio / drive.stage.travel_per_radian
    with Unit(exported("hand_controller motor1-gear1", version)[0]) as unit:
        unit.set({"source": current, "force": -held})
        for second in range(300):
            unit.step(float(second), 1.0)
        assert abs(unit.get(["ldot"])[0]) < 1e-3
        found = unit.get(["temperature.winding.motor", "temperature.housing.motor"])
    assert expected.winding > 310.0
    for one, wanted in zip(found, (expected.winding, expected.housing), strict=True):
        assert one - 298.15 == pytest.approx(wanted - 298.15, rel=1e-6)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize(
    "wrong", [{"tolerance": float("nan")}, {"tolerance": -1.0}, {"startTime": float("nan")}, {"stopTime": -1.0}]
)
def test_an_experiment_that_cannot_be_is_refused(version, wrong):
    """And the instance stays as it was made: a proper one is accepted afterwards."""
    (file,) = exported("hand_controller motor1-gear1", version)
    with Unit(file) as unit:
        unit.unit.reset()
        own = unit.unit
        begin = own.enterInitializationMode if unit.third else own.setupExperiment
        with pytest.raises(Exception, match="failed with status"):
            begin(**{"startTime": 0.0, **wrong})
        begin(tolerance=1e-6, startTime=0.0, stopTime=1.0)
        if not unit.third:
            own.enterInitializationMode()
        own.exitInitializationMode()
        unit.step(0.0, 1e-3)
