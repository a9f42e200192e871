"""Bond graphs: what is refused, causality, equations, algebraic loops, and code for every array library."""

import math
from dataclasses import replace

import casadi
import jax
import numpy as np
import pytest
import sympy
import threadpoolctl
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar import AuditError, Scenario
from infinivar import array_namespace as namespace
from infinivar.bondgraph import (
    Bond,
    BondGraph,
    BondGraphError,
    Parameter,
    Signal,
    assign,
    derive,
    join,
    latex,
    solve,
    text,
)
from infinivar.motion import Step
from internals import FloatNamespace, Traced, casadi_namespace, coulomb, products_on_one_thread, stepper
from internals import bond_graph_audit as audit
from internals import bond_graph_elements as bg
from internals import bond_graph_march as march
from internals import bond_graph_model as model
from internals import bond_graph_models as models
from internals import bond_graph_solver as solving
from internals import clip_traced as clip
from internals import plant_graphs as plants
from internals import trace_law as trace
from sampled import sampled

jax.config.update("jax_enable_x64", True)

TIMES = np.linspace(0.0, 0.1, 11)


def motor(**changes):
    """DC motor with a gear, a load inertia behind it, and a spring."""
    elements = {
        "V": bg.effort_source("V", "V"),
        "i": bg.one("i", "i"),
        "L": bg.inertia("L", "L", 1e-3),
        "R": bg.resistance("R", "R", 2.0),
        "K": bg.gyrator("K", "K", 0.02),
        "shaft": bg.one("shaft", r"\omega"),
        "J": bg.inertia("J", "J", 1e-6),
        "n": bg.transformer("n", "n", 0.2),
        "out": bg.one("out"),
        "Jo": bg.inertia("Jo", "J_o", 1e-4),
        "k": bg.compliance("k", "c", 0.1),
        **changes,
    }
    return BondGraph(
        "motor", elements.values(), ["V > i > K > shaft > n > out > Jo", "i > R", "i > L", "shaft > J", "out > k"]
    )


@pytest.mark.parametrize(
    ("elements", "bonds", "signals", "said"),
    [
        ([bg.one("a"), bg.one("a")], [], [], "2 elements are called 'a'"),
        (
            [bg.one("node"), bg.inertia("m", "m", 1.0)],
            ["nod > m"],
            [],
            "'nod', which is no element.*did you mean 'node'",
        ),
        ([bg.one("a")], ["a > a"], [], "leads from a to itself"),
        ([bg.one("a"), bg.inertia("m", "m", 1.0)], ["m > a"], [], "must point towards it"),
        ([bg.one("a"), bg.inertia("m", "m", 1.0)], [], [], "I 'm' needs one bond, has 0"),
        ([bg.one("a"), bg.transformer("n", "n", 2.0)], ["a > n"], [], "TF 'n' needs one bond that arrives"),
        ([bg.one("a"), bg.transformer("n", "n", math.sin, signals=("phi",)), bg.one("b")], ["a > n > b"], [], "'phi'"),
        ([bg.one("a"), bg.inertia("m", "m", -1.0)], ["a > m"], [], "must be > 0, got -1"),
        ([bg.one("a"), bg.one("b"), bg.transformer("n", "n", 0.0)], ["a > n > b"], [], "must not be 0"),
        ([bg.one("a")], [], [Signal(name="x", symbol="x", of="b")], "measures 'b', which is no element"),
        ([bg.one("a"), bg.resistance("r", "R", 1.0)], ["a > r", "a > r"], [], "no law that relates them"),
        (
            [bg.one("a"), bg.inertia("m", "m", 1.0), bg.inertia("M", "m", 2.0)],
            ["a > m", "a > M"],
            [],
            "symbol m has two values, 1 and 2",
        ),
    ],
)
def test_a_graph_without_meaning_is_refused(elements, bonds, signals, said):
    with pytest.raises(BondGraphError, match=said):
        BondGraph("g", elements, bonds, signals)


def test_a_chain_must_be_a_chain():
    with pytest.raises(BondGraphError, match="must be a chain of bonds"):
        BondGraph("g", [bg.one("a")], ["a"])


def test_joining_prefixes_names_and_resolves_signals():
    one = BondGraph("One", [bg.one("a"), bg.inertia("m", "m", 1.0)], ["a > m"], [Signal(name="x", symbol="x", of="a")])
    two = BondGraph("Two", [bg.one("a"), bg.one("b")], ["a > b"], [Signal(name="x", symbol="x")])
    whole = join("Both", {"first": one, "second": two}, ["first.a > second.a"])
    assert whole["first.m"].parameter == Parameter("m", 1.0)
    assert whole.titles == {"first": "One", "second": "Two"}
    assert [(signal.name, signal.of) for signal in whole.signals] == [("x", "first.a")]
    with pytest.raises(BondGraphError, match=r"measured at first.a and at second.a"):
        join("Both", {"first": one, "second": one}, [])


def test_causality_prefers_integral_storage():
    causality = assign(motor())
    assert causality.independent == ("L", "J", "k")
    assert causality.dependent == ("Jo",)
    stroke = causality.stroke
    assert stroke[Bond("V", "i")] == "i"  # a source of effort imposes it on its junction
    assert stroke[Bond("shaft", "J")] == "J"
    assert stroke[Bond("out", "Jo")] == "out"  # derivative causality
    assert stroke[Bond("out", "k")] == "out"
    assert stroke[Bond("i", "K")] == "i"  # the coil decides the current, so the gyrator decides the voltage ...
    assert stroke[Bond("K", "shaft")] == "shaft"  # ... and its torque


def test_two_sources_of_one_flow_are_named():
    clash = BondGraph("g", [bg.flow_source("a", "a"), bg.flow_source("b", "b"), bg.one("i")], ["a > i > b"])
    with pytest.raises(BondGraphError, match="'b' and 'a' both determine the same quantity on the bond i > b"):
        assign(clash)


def test_a_law_that_is_given_an_effort_is_named():
    friction = bg.resistance("f", "f", coulomb, parameters={"size": Parameter("F", 1.0)})
    graph = BondGraph("g", [bg.effort_source("e", "e"), bg.zero("n"), friction], ["e > n > f"])
    with pytest.raises(BondGraphError, match=r"law of R 'f' needs a flow, but 'e' imposes its effort"):
        assign(graph)


def test_state_space_of_a_motor():
    """Against the equations a textbook writes for it, inertia behind the gear included."""
    a, b = derive(motor()).state_space()
    J, Jo, K, L, R, c, n = sympy.symbols("J J_o K L R c n", real=True)
    inertia = J + Jo * n**2
    assert sympy.simplify(
        a - sympy.Matrix([[-R / L, -K / L, 0], [K / inertia, 0, -n / (c * inertia)], [0, n, 0]])
    ).is_zero_matrix
    assert sympy.simplify(b - sympy.Matrix([1 / L, 0, 0])).is_zero_matrix


def test_a_linear_loop_is_solved_exactly():
    """A voltage divider that charges a capacitor: three resistances decide each other."""
    divider = BondGraph(
        "divider",
        [
            bg.effort_source("V", "V"),
            bg.one("i"),
            bg.resistance("R1", "R_1", 2.0),
            bg.zero("node"),
            bg.resistance("R2", "R_2", 3.0),
            bg.one("j"),
            bg.resistance("R3", "R_3", 5.0),
            bg.compliance("C", "C", 0.1),
        ],
        ["V > i > R1", "i > node > R2", "node > j > R3", "j > C"],
    )
    assert assign(divider).looped
    R1, R2, R3, C, V, q = sympy.symbols("R_1 R_2 R_3 C V q_{C}", real=True)
    node = (V / R1 + q / C / R3) / (1 / R1 + 1 / R2 + 1 / R3)  # Millman
    (rate,) = derive(divider).derivatives
    assert sympy.simplify(rate - (node - q / C) / R3) == 0


def test_a_loop_through_a_law_without_proportion_is_named():
    def curved(speed, torque):
        return speed * torque**2

    graph = BondGraph(
        "g",
        [
            bg.effort_source("e", "e"),
            bg.one("a", "w"),
            bg.inertia("J", "J", 1.0),
            bg.transformer("n", "n", 2.0),
            bg.one("b"),
            bg.inertia("M", "M", 1.0),
            bg.resistance("loss", "T", curved, signals=("t",)),
        ],
        ["e > a > n > b > M", "a > J", "a > loss"],
        [Signal(name="t", symbol="t", of="n")],
    )
    with pytest.raises(BondGraphError, match="law of 'loss' depends on its own value"):
        derive(graph)


def test_a_loop_through_a_bound_is_solved_exactly():
    """Friction cut off at a share of the torque passed on: what a gear of that share of loss does, written as a bound."""

    def cut_off(speed, torque, share):
        xp = namespace(speed, torque)
        return xp.clip(1e6 * speed, -share * xp.abs(torque), share * xp.abs(torque))

    ratio, motor_inertia, load, share = 5.0, 2e-5, 1e-3, 0.3
    law = bg.resistance("loss", "T", cut_off, signals=("t",), parameters={"share": Parameter("s", share)})
    graph = BondGraph(
        "g",
        [
            bg.effort_source("e", "e"),
            bg.one("a", "w"),
            bg.inertia("J", "J", motor_inertia),
            bg.transformer("n", "n", 1.0 / ratio),
            bg.one("b"),
            bg.inertia("M", "M", load),
            law,
        ],
        ["e > a > n > b > M", "a > J", "a > loss"],
        [Signal(name="t", symbol="t", of="n")],
    )
    run = solve(graph, TIMES, inputs={"e": 0.1}, initial={"J": 1.0})
    behind = load / ratio**2
    assert_allclose(run.states["J"], 1.0 + 0.1 / (motor_inertia + (1.0 + share) * behind) * TIMES, rtol=1e-8)


@pytest.mark.parametrize("place", range(3))
def test_slopes_of_a_value_between_bounds(place):
    """By each argument, in each of the three cases, against differences."""
    symbols = sympy.symbols("x low high", real=True)
    slope = clip(*symbols).diff(symbols[place])
    for point in ((-2.0, -1.0, 1.0), (0.3, -1.0, 1.0), (1.7, -1.0, 1.0)):
        ahead = [value + 1e-6 * (index == place) for index, value in enumerate(point)]
        difference = (np.clip(*ahead) - np.clip(*point)) / 1e-6
        assert float(slope.subs(dict(zip(symbols, point, strict=True)))) == pytest.approx(difference, abs=1e-6)


def test_a_function_without_a_name_in_the_namespace_is_refused():
    """A law that reaches past the array namespace has an expression, but no code."""
    law = bg.resistance("r", "F", lambda flow: Traced(sympy.sinh(flow.expression)))
    graph = BondGraph("g", [bg.one("a", "v"), bg.inertia("m", "m", 2.0), law], ["a > m", "a > r"])
    with pytest.raises(BondGraphError, match="sinh"):
        model(graph)


def test_a_mass_that_is_moved_needs_the_acceleration():
    graph = BondGraph(
        "g",
        [bg.flow_source("f", "f"), bg.one("j"), bg.inertia("m", "m", 1.0), bg.resistance("r", "R", 1.0)],
        ["f > j > m", "j > r"],
    )
    equations = derive(graph)
    assert not equations.states
    assert list(equations.rates) == ["f"]
    assert equations.efforts[Bond("j", "m")] == sympy.Symbol("m", real=True) * equations.rates["f"]


def test_letters_may_coincide_inside_a_law_and_must_not_outside():
    """A law's parameter called w, as its own flow is; a junction called like a parameter."""
    law = bg.resistance("r", "F", lambda flow, w: w * flow, parameters={"w": Parameter("w", 3.0)})
    graph = BondGraph("g", [bg.one("a", "v"), bg.inertia("m", "c_1", 2.0), law], ["a > m", "a > r"])
    run = solve(graph, np.linspace(0.0, 1.0, 11), initial={"m": 1.0})
    assert_allclose(run.states["m"], np.exp(-1.5 * run.time), rtol=1e-6)
    twice = BondGraph("g", [bg.one("a", "w"), bg.inertia("m", "m", 2.0), law], ["a > m", "a > r"])
    with pytest.raises(BondGraphError, match="symbol w is used for a parameter and for a state; rename one"):
        derive(twice)
    sources = [bg.effort_source("one", "V"), bg.effort_source("two", "V"), bg.one("a"), bg.inertia("m", "m", 1.0)]
    with pytest.raises(BondGraphError, match="symbol V is used for an input and for an input"):
        derive(BondGraph("g", sources, ["one > a > m", "two > a"]))


def test_tracing_refuses_branches():
    with pytest.raises(TypeError, match=r"use where\(\) to choose"):
        trace(lambda x: 1.0 if x > 0 else 2.0, sympy.Symbol("x"))


@pytest.mark.slow
@sampled("name", ["cobotic", "cobotic-b", "motor2-gear4", "held"], every=3)
@pytest.mark.parametrize("electrical", ["current", "voltage"])
def test_one_code_for_floats_numpy_jax_and_casadi(study, name, electrical):
    drive = study.drives["cobotic" if name == "held" else name]
    if name == "held":
        bearing = replace(drive.steering.bell_bearing, friction_model="skf")
        bearings = iv.parts.CylinderBearings(bearing=bearing, span=0.14, backing_rollers=1)
        drive = replace(drive, cylinder_bearings=bearings, guideway=iv.parts.Guideway(friction=1.0))
    graph = plants.plant_graph(drive, electrical=electrical, load_mass=0.8)
    made = model(graph)
    parameters = {symbol: parameter.value for symbol, parameter in graph.parameters.items()}
    random = np.random.default_rng(1)
    points = random.normal(size=(20, len(made.states)))
    inputs = random.normal(size=(20, len(made.inputs)))
    numpy = np.array(made.function("dynamics", np, parameters)(tuple(points.T), tuple(inputs.T), ())).T
    floats = made.function("dynamics", FloatNamespace, parameters)
    traced = jax.jit(made.function("dynamics", jax.numpy, parameters))
    symbols, given = casadi.SX.sym("x", len(made.states)), casadi.SX.sym("u", len(made.inputs))
    expression = made.function("dynamics", casadi_namespace(), parameters)(
        casadi.vertsplit(symbols), casadi.vertsplit(given), ()
    )
    compiled = casadi.Function("f", [symbols, given], [casadi.vertcat(*expression)])
    scale = np.abs(numpy).max(axis=0)
    for row, point, given_row in zip(numpy, points, inputs, strict=True):
        assert_allclose(floats(point.tolist(), given_row.tolist(), ()), row, rtol=1e-12, atol=1e-12 * scale.max())
        assert_allclose(traced(tuple(point), tuple(given_row), ()), row, rtol=1e-12, atol=1e-12 * scale.max())
        assert_allclose(np.array(compiled(point, given_row)).ravel(), row, rtol=1e-12, atol=1e-12 * scale.max())


def test_models_are_kept_between_runs(study, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(models, "_MODELS", {})
    graph = plants.cobotic_graph(study.drives["cobotic"], load_mass=0.8)
    first = model(graph)
    derived = models._derived
    monkeypatch.setattr(models, "_derived", lambda graph: pytest.fail("derived again"))
    assert model(graph) is first
    models._MODELS.clear()  # as in another process
    assert model(graph) == first
    heavier = plants.cobotic_graph(study.drives["cobotic"], load_mass=1.6)
    assert model(heavier) == first  # values are no part of a model
    (kept,) = (tmp_path / "infinivar").iterdir()
    kept.write_text("{", "utf-8")
    models._MODELS.clear()
    monkeypatch.setattr(models, "_derived", derived)
    assert model(graph) == first  # a file cut short is no reason to stop


def test_laws_of_users_are_not_kept(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    graph = BondGraph(
        "g", [bg.one("a"), bg.inertia("m", "m", 1.0), bg.resistance("r", "r", lambda w: 2.0 * w)], ["a > m", "a > r"]
    )
    model(graph)
    assert not (tmp_path / "infinivar").exists()


def test_another_law_is_another_model(study):
    drive = study.drives["cobotic"]
    bent = replace(drive, transmission=replace(drive.transmission, creep_law="vermeulen-johnson"))
    assert model(plants.cobotic_graph(drive)) != model(plants.cobotic_graph(bent))


def test_missing_and_unknown_names_are_named():
    graph = motor()
    with pytest.raises(BondGraphError, match=r"the input 'V' is missing"):
        solve(graph, [0.0, 1.0])
    with pytest.raises(BondGraphError, match=r"has no input 'v'.*did you mean 'V'|has no input 'v'.*it has V"):
        solve(graph, [0.0, 1.0], inputs={"v": 1.0})
    with pytest.raises(BondGraphError, match="has no state 'Jo'"):
        solve(graph, [0.0, 1.0], inputs={"V": 1.0}, initial={"Jo": 1.0})


def test_a_resistance_that_creates_power_is_named():
    graph = BondGraph(
        "g",
        [bg.one("a"), bg.inertia("m", "m", 1.0), bg.resistance("push", "F", lambda speed: -0.1 * speed)],
        ["a > m", "a > push"],
    )
    with pytest.raises(AuditError, match="R 'push' creates power at 0 s"):
        solve(graph, np.linspace(0.0, 1.0, 11), initial={"m": 1.0})


def test_losses_that_do_not_add_up_are_named():
    graph = BondGraph(
        "g",
        [
            bg.one("a"),
            bg.inertia("m", "m", 1.0),
            bg.resistance("r", "F", lambda w: w, losses=lambda w, effort: {"heat": 0.9 * effort * w}),
        ],
        ["a > m", "a > r"],
    )
    with pytest.raises(AuditError, match="R 'r' has losses that differ from the power it absorbs"):
        solve(graph, np.linspace(0.0, 1.0, 11), initial={"m": 1.0})


def test_a_balance_that_does_not_close_is_named():
    """A loose tolerance is found out by the energy balance, not hidden."""
    graph = motor()
    with pytest.raises(
        AuditError, match=r"residual of .* of the energy moved, above the limit of 1e-06, largest at \w+ '\w+'"
    ):
        solve(graph, np.linspace(0.0, 0.5, 11), inputs={"V": 5.0}, rtol=1e-3)


def test_equations_for_people():
    equations = derive(motor())
    shown = text(equations)
    assert r"d/dt \omega = (K*c*i - n*q_{k})/(c*(J + J_o*n**2))" in shown
    assert "J_o              Jo" in shown  # named as dependent
    document = latex(equations)
    assert r"\frac{d}{dt} i &= \frac{- K \omega - R i + V}{L}" in document
    assert document.count(r"\begin{") == document.count(r"\end{")


@pytest.mark.parametrize(
    ("bond", "named"), [(("n", "out"), "TF 'n'"), (("shaft", "J"), "1 'shaft'"), (("K", "shaft"), "GY 'K'")]
)
def test_an_element_that_passes_on_other_power_is_named(bond, named):
    """What a wrong equation would look like: one effort that its neighbours do not know."""
    graph = motor()
    run = solve(graph, np.linspace(0.0, 0.01, 11), inputs={"V": 5.0})
    efforts = {**run.efforts, bond: 1.001 * run.efforts[bond]}
    with pytest.raises(AuditError, match=f"{named} does not conserve power"):
        audit._check_elements(graph, efforts, run.flows, {("R", "R"): run.power("R")}, run.time)


def test_energies_of_every_element_add_up():
    """What comes to an element goes on, is lost or is stored; a source gives what goes out of it."""
    graph = motor()
    for at_once in (False, True):
        run = solve(graph, np.linspace(0.0, 0.05, 501), inputs={"V": 5.0}, energies_as_states=at_once)
        moved = run.supplied["V"][-1]
        for element in graph.elements:
            energy = run.energy(element.name)
            rest = energy.given + energy.came - energy.went - energy.lost - energy.stored
            assert np.abs(rest).max() < 2e-6 * moved, element.name
        assert run.energy("V").given[-1] == pytest.approx(moved)
        assert run.energy("R").lost[-1] == pytest.approx(run.lost["R"][-1])
        assert run.energy("Jo").stored[-1] == pytest.approx(run.stored["Jo"][-1])
        assert run.energy("n").came[-1] == pytest.approx(run.energy("n").went[-1], rel=1e-9)


@pytest.mark.parametrize(
    ("changed", "named"),
    [
        ({"lost": ("R", "R")}, {"R": 1.0}),
        ({"came": ("out", "k")}, {"k": 1.0, "out": 1.0}),
        ({"came": ("V", "i"), "lost": ("R", "R")}, {"i": 1.0, "V": 1.0, "R": 1.0}),
    ],
)
def test_energy_that_an_element_misses_is_found_at_it(changed, named):
    """A joule put wrongly into one loss, or into what passed through one bond, is missing there and nowhere else."""
    run = solve(motor(), np.linspace(0.0, 0.05, 501), inputs={"V": 5.0})
    lost, passed = dict(run.by_element), dict(run.passed)
    for what, where in changed.items():
        energies = lost if what == "lost" else passed
        energies[where] = energies[where] + np.linspace(0.0, 1.0, 501)
    wrong = replace(run, by_element=lost, passed=passed)
    for element in run.graph.elements:
        assert audit._missing(wrong, element.name) == pytest.approx(named.get(element.name, 0.0), abs=1e-6)


def test_a_graph_without_losses_or_sources_is_audited_too():
    spring = BondGraph("g", [bg.one("v"), bg.inertia("m", "m", 1.0), bg.compliance("c", "c", 1.0)], ["v > m", "v > c"])
    assert solve(spring, np.linspace(0.0, 9.0, 91), initial={"c": 1.0}).closure < 1e-7
    with pytest.raises(AuditError, match=r"energy balance has a residual"):
        solve(spring, np.linspace(0.0, 9.0, 91), initial={"c": 1.0}, rtol=1e-3, method="LSODA")


@pytest.mark.parametrize("times", [[0.0], [0.0, 0.0], [1.0, 0.0], [0.0, math.nan]])
def test_times_must_increase(times):
    with pytest.raises(BondGraphError, match="times must be at least two increasing values"):
        solve(motor(), times, inputs={"V": 1.0})


def test_sums_over_nodes_close_a_smooth_motion(monkeypatch):
    """One integration is enough: the energies need not become states."""
    made = []
    monkeypatch.setattr(solving, "stepper", lambda *given: made.append(given) or stepper(*given))
    run = solve(motor(), np.linspace(0.0, 0.05, 501), inputs={"V": 5.0})
    assert len(made) == 1
    assert run.closure < 1e-7


@pytest.mark.slow
def test_fastsim_has_a_value_in_slip(study):
    """Generated code took its arcsine past 1: a solver's trial steps get there when a soft wheel is steered in a step."""
    drive = study.drives["cobotic"]
    soft = iv.RotaryLinearIVT(
        cylinder_radius=0.0625,
        wheel_radius=0.01,
        preload=650.0,
        friction=0.12,
        creep_stiffness=7800.0,
        rolling_torque=0.0,
        bearing_torque=0.0,
        creep_law="fastsim",
    )
    drive = replace(
        drive,
        transmission=soft,
        cylinder_inertia=0.0078125,
        link_mass=1.0,
        guideway=iv.parts.Guideway(),
        steering=replace(drive.steering, patch_half_length=4e-4),
    )
    step = Step(distance=-0.015625, start=0.02)
    result = iv.simulate(drive, Scenario(duration=0.05, output_step=0.01, motion=step, load_mass=1.0))
    assert result.complete, result.trajectory.outcome


@pytest.mark.slow
def test_what_a_run_holds_does_not_grow_with_its_duration(monkeypatch):
    """Powers between the results are summed as it goes, in batches of any size the same."""
    study = iv.load_study("hand_controller")
    scenario = replace(study.scenarios["shake"], duration=0.2)
    whole = iv.simulate(study.drives["cobotic"], scenario).trajectory
    held = []
    summed = march.March._sum

    def watched(self, states, values, rates, times, widths, rows):
        held.append(len(widths))
        summed(self, states, values, rates, times, widths, rows)

    monkeypatch.setattr(march, "_MOST_INTERVALS", 10)
    monkeypatch.setattr(march.March, "_sum", watched)
    again = iv.simulate(study.drives["cobotic"], scenario).trajectory
    assert len(held) > 10
    assert max(held) <= 10
    for name, energy in whole.by_element.items():
        assert_allclose(again.by_element[name], energy, rtol=1e-12, atol=1e-15)


def test_products_on_one_thread_include_those_of_scipy():
    """Else the number of threads would change what a search finds, from the tenth digit on."""
    with products_on_one_thread():
        found = [one for one in threadpoolctl.threadpool_info() if one["user_api"] == "blas"]
    assert found
    assert {one["num_threads"] for one in found} == {1}
