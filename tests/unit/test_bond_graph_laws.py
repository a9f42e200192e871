"""Compliances with a law, conductances, and ratios set by an angle: equations, energy, code, and what is refused."""

import math

import casadi
import jax
import numpy as np
import pytest
import sympy
from numpy.testing import assert_allclose
from scipy.special import ellipk

from infinivar import AuditError
from infinivar import array_namespace as namespace
from infinivar.bondgraph import BondGraph, BondGraphError, Parameter, Signal, assign, derive, latex, solve, text
from internals import FloatNamespace, casadi_namespace
from internals import bond_graph_elements as bg
from internals import bond_graph_figure as drawing
from internals import bond_graph_model as model
from sampled import sampled

jax.config.update("jax_enable_x64", True)


def hardening(deflection, stiffness, cubic):
    return stiffness * deflection + cubic * deflection**3


def hardening_energy(deflection, stiffness, cubic):
    return 0.5 * stiffness * deflection**2 + 0.25 * cubic * deflection**4


def spring(stiffness=3.0, cubic=5.0, energy=hardening_energy, **changes):
    law = {"stiffness": Parameter("k", stiffness, "N/m"), "cubic": Parameter("b", cubic, "N/m^3")}
    return bg.compliance("spring", "F", hardening, energy=energy, parameters=law, **changes)


def oscillator(element, mass=1.0):
    return BondGraph("oscillator", [bg.one("x", "v"), bg.inertia("m", "m", mass), element], ["x > m", "x > spring"])


def test_equations_of_a_compliance_with_a_law():
    equations = derive(oscillator(spring()))
    k, b, m, q, v = sympy.symbols("k b m q_{spring} v", real=True)
    rates = {state.name: rate for state, rate in zip(equations.states, equations.derivatives, strict=True)}
    assert sympy.simplify(equations.expanded(rates["m"]) + (k * q + b * q**3) / m) == 0
    assert sympy.simplify(sympy.nsimplify(equations.stored["spring"]) - k * q**2 / 2 - b * q**4 / 4) == 0
    assert equations.stored["m"] == m * v**2 / 2
    said = text(equations)
    assert "d/dt v = -F/m" in said
    assert "F = b*q**3 + k*q\n      with q = q_{spring}" in said
    assert r"\paragraph{spring}" in latex(equations)
    with pytest.raises(BondGraphError, match="is not linear because of spring"):
        equations.state_space()


@pytest.mark.parametrize(("cubic", "size"), [(5.0, 0.7), (40.0, 1.0), (-2.0, 0.6)])
def test_period_of_a_duffing_oscillator(cubic, size):
    """Free oscillation of ``x'' = -k x - b x^3``: T = 4 K(m)/sqrt(k + b A^2), m = b A^2/(2 (k + b A^2))."""
    stiffness = 3.0
    stiff = stiffness + cubic * size**2
    period = 4.0 * ellipk(cubic * size**2 / (2.0 * stiff)) / math.sqrt(stiff)
    run = solve(oscillator(spring(cubic=cubic)), np.linspace(0.0, 3.0 * period, 301), initial={"spring": size})
    assert run.states["spring"][100::100] == pytest.approx(size, rel=1e-7)
    assert run.states["spring"][[25, 75]] == pytest.approx(0.0, abs=1e-7)
    total = run.stored["spring"] + run.stored["m"]
    assert_allclose(total, total[0], rtol=1e-8)


def test_energy_of_a_pendulum_is_constant():
    """The moment of a weight as the law of a compliance: a pendulum, here past the horizontal."""

    def weight(angle, moment):
        return moment * namespace(angle).sin(angle)

    def height(angle, moment):
        return moment * (1.0 - namespace(angle).cos(angle))

    law = {"moment": Parameter("m g l", 4.0, "N m")}
    pendulum = oscillator(bg.compliance("spring", "M", weight, energy=height, parameters=law), mass=0.5)
    run = solve(pendulum, np.linspace(0.0, 10.0, 501), initial={"spring": 2.5})
    total = run.stored["spring"] + run.stored["m"]
    assert_allclose(total, 4.0 * (1.0 - math.cos(2.5)), rtol=1e-7)
    assert run.closure < 1e-7
    assert np.ptp(run.states["spring"]) == pytest.approx(5.0, abs=1e-2)


def test_energy_that_is_not_the_integral_of_the_law_is_found():
    def wrong(deflection, stiffness, cubic):
        return 0.5 * stiffness * deflection**2

    with pytest.raises(AuditError, match="largest at C 'spring'"):
        solve(oscillator(spring(energy=wrong)), np.linspace(0.0, 1.0, 21), initial={"spring": 1.0})


@pytest.mark.parametrize(
    ("element", "said"),
    [
        (spring(energy=None), "C 'spring' has a law and needs its energy as well"),
        (bg.Element(name="spring", kind="C", law=hardening, energy=hardening, signals=("s",)), "not be modulated"),
    ],
)
def test_a_compliance_without_a_meaning_is_refused(element, said):
    with pytest.raises(BondGraphError, match=said):
        BondGraph(
            "g",
            [bg.one("x"), bg.inertia("m", "m", 1.0), element],
            ["x > m", "x > spring"],
            [Signal(name="s", symbol="s")],
        )


def test_a_law_that_needs_a_displacement_and_is_given_an_effort_is_named():
    graph = BondGraph("g", [bg.effort_source("push", "f"), bg.zero("n"), spring()], ["push > n > spring"])
    with pytest.raises(BondGraphError, match="law of C 'spring' needs a displacement, but 'push' imposes its effort"):
        assign(graph)


def between_two(load_side, drive_side):
    """Spring with a law between a moved drive and what is at the load, linear."""
    return BondGraph(
        "g",
        [
            *drive_side,
            bg.one("drive", "v_d"),
            bg.zero("node"),
            spring(),
            bg.one("load", "v_l"),
            *load_side,
        ],
        ["motion > drive > node > load", "node > spring", *(f"load > {element.name}" for element in load_side)],
    )


def test_a_dependent_compliance_follows_from_the_law():
    """Two springs in a row without a mass between them; the second one's force is the first one's."""
    soft = bg.compliance("soft", "c", 0.1)
    graph = between_two([soft], [bg.flow_source("motion", "u")])
    assert assign(graph).dependent == ("soft",)
    times = np.linspace(0.0, 2.0, 41)
    run = solve(graph, times, inputs={"motion": 0.4})
    force = hardening(run.states["spring"], 3.0, 5.0)
    assert_allclose(run.states["spring"] + 0.1 * force, 0.4 * times, rtol=1e-7, atol=1e-9)
    assert run.closure < 1e-6


def hysteretic(size=2.0, stiffness=400.0):
    """Dahl's friction on an imposed motion: a compliance 1/sigma, and a conductance |x'|/F_c beside it."""

    def yielding(force, speed, size):
        return namespace(force, speed).abs(speed) * force / size

    return BondGraph(
        "dahl",
        [
            bg.flow_source("motion", "u"),
            bg.one("x", "v"),
            bg.zero("z", "z"),
            bg.compliance("bristle", "c", 1.0 / stiffness),
            bg.conductance("yield", "w", yielding, signals=("v",), parameters={"size": Parameter("F_c", size)}),
        ],
        ["motion > x > z > bristle", "z > yield"],
        [Signal(name="v", symbol="v", of="x"), Signal(name="p", symbol="p", of="x", integral=True)],
    )


def test_dahl_friction_follows_its_closed_form():
    """Between reversals z = F_c s + (z0 - F_c s) exp(-sigma |x - x0|/F_c), s the direction (dahl1968)."""
    size, stiffness, speed = 2.0, 400.0, 0.03
    times = np.linspace(0.0, 1.0, 101)
    run = solve(hysteretic(size, stiffness), times, inputs={"motion": speed})
    z = stiffness * run.states["bristle"]
    assert_allclose(z, size * (1.0 - np.exp(-stiffness * speed * times / size)), rtol=1e-6, atol=1e-9)
    assert run.closure < 1e-6
    back = solve(hysteretic(size, stiffness), times, inputs={"motion": -speed}, initial={"bristle": z[-1] / stiffness})
    expected = -size + (z[-1] + size) * np.exp(-stiffness * speed * times / size)
    assert_allclose(stiffness * back.states["bristle"], expected, rtol=1e-6, atol=1e-9)
    assert np.all(np.diff(back.lost["yield"]) >= 0.0)


def test_a_conductance_that_is_given_a_flow_is_named():
    law = bg.conductance("leak", "w", lambda force: 2.0 * force)
    graph = BondGraph("g", [bg.flow_source("u", "u"), bg.one("n"), law], ["u > n > leak"])
    with pytest.raises(BondGraphError, match="law of R 'leak' needs an effort, but 'u' imposes its flow"):
        assign(graph)


def test_one_code_for_floats_numpy_jax_and_casadi():
    graph = BondGraph(
        "both",
        [
            bg.flow_source("motion", "u"),
            bg.one("x", "v"),
            spring(),
            bg.zero("z", "z"),
            bg.compliance("bristle", "c", 1.0 / 40.0),
            bg.conductance(
                "yield",
                "w",
                lambda force, speed, size: namespace(force, speed).abs(speed) * force / size,
                signals=("v",),
                parameters={"size": Parameter("F_c", 2.0)},
            ),
        ],
        ["motion > x > z > bristle", "z > yield", "x > spring"],
        [Signal(name="v", symbol="v", of="x")],
    )
    made = model(graph)
    parameters = {symbol: parameter.value for symbol, parameter in graph.parameters.items()}
    points, given = np.random.default_rng(1).normal(size=(20, len(made.states))), np.linspace(-1.0, 1.0, 20)
    for which in ("dynamics", "outputs"):
        numpy = np.array(np.broadcast_arrays(*made.function(which, np, parameters)(tuple(points.T), (given,), ()))).T
        symbols, moved = casadi.SX.sym("x", len(made.states)), casadi.SX.sym("u", 1)
        traced = jax.jit(made.function(which, jax.numpy, parameters))
        expression = made.function(which, casadi_namespace(), parameters)(casadi.vertsplit(symbols), (moved,), ())
        compiled = casadi.Function("f", [symbols, moved], [casadi.vertcat(*expression)])
        for row, point, at in zip(numpy, points, given, strict=True):
            floats = made.function(which, FloatNamespace, parameters)(point.tolist(), (float(at),), ())
            assert_allclose(floats, row, rtol=1e-12, atol=1e-12)
            assert_allclose(traced(tuple(point), (at,), ()), row, rtol=1e-12, atol=1e-12)
            assert_allclose(np.array(compiled(point, at)).ravel(), row, rtol=1e-12, atol=1e-12)


def test_drawing_shows_the_law():
    pytest.importorskip("igraph")
    numbers = drawing.data(oscillator(spring()))
    assert numbers["elements"]["spring"]["text"] == r"$\mathbf{C}:\,F$"
    assert ("x", "spring", "x") in numbers["bonds"]


def test_a_lever_arm_that_changes_with_the_angle():
    """A mass on a line, moved through a crank x = r sin(theta) by an inertia: energy, and both speeds by the ratio."""

    def ratio(angle, radius):
        return radius * namespace(angle).cos(angle)

    radius = {"radius": Parameter("r", 0.3)}
    graph = BondGraph(
        "crank",
        [
            bg.one("joint", r"\omega"),
            bg.inertia("J", "J", 0.2),
            bg.transformer("crank", "n", ratio, signals=("angle",), parameters=radius),
            bg.one("line", "v"),
            bg.inertia("m", "m", 3.0),
        ],
        ["joint > crank > line > m", "joint > J"],
        [Signal(name="angle", symbol=r"\theta", of="joint", integral=True)],
    )
    assert assign(graph).dependent == ("m",)
    run = solve(graph, np.linspace(0.0, 4.0, 201), initial={"J": 1.5})
    total = run.stored["J"] + run.stored["m"]
    assert_allclose(total, 0.5 * (0.2 + 3.0 * 0.3**2) * 1.5**2, rtol=1e-7)
    assert_allclose(run.flows["line", "m"], 0.3 * np.cos(run.signals["angle"]) * run.states["J"], rtol=1e-12)


def inverted(force, steps):
    """Solution x of ``x + x^3/10 = force`` by Newton's method; every step contains the last one three times."""
    x = 1.0 * force
    for _ in range(steps):
        x = x - (x + 0.1 * x**3 - force) / (1.0 + 0.3 * x**2)
    return x


@pytest.mark.slow
@sampled("where", ["resistance", "modulus"], every=2)
def test_repeated_steps_of_a_law_do_not_multiply_its_equations(where):
    """Written out, twelve steps would have 3^12 terms."""

    def system(steps):
        def law(*given):
            return 2.0 + inverted(given[0], steps)

        mass, inertia, end = bg.inertia("m", "m", 2.0), bg.inertia("J", "J", 0.5), bg.one("y", "w")
        if where == "resistance":
            return BondGraph(
                "damped", [bg.one("x", "v"), mass, bg.resistance("brake", "T", law)], ["x > m", "x > brake"]
            )
        lever = bg.transformer("lever", "n", law, signals=("s",))
        turning = Signal(name="s", symbol="s", of="y", integral=True)
        return BondGraph(
            "lever", [bg.one("x", "v"), mass, lever, end, inertia], ["x > m", "x > lever > y > J"], [turning]
        )

    few, many = (model(system(steps)) for steps in (6, 12))
    assert len(many.outputs) < 4 * len(few.outputs)
    at = {"m": 0.7, "J": 0.7, "s": 0.4}
    rates = many.function("motion", FloatNamespace, {"m": 2.0, "J": 0.5})(
        tuple(at[name] for name in many.states), (), ()
    )
    found = dict(zip(many.states, rates, strict=True))
    if where == "resistance":
        assert found["m"] == pytest.approx(-(2.0 + inverted(0.7, 12)) / 2.0, rel=1e-14)
        return
    # v = w/n and 0.5 w' = -f/n with f = 2 v' of the dependent mass, so (0.5 + 2/n^2) w' = 2 n' w/n^3, n' = w/(1 + 3 x^2/10).
    (name,) = set(found) - {"s"}
    x = inverted(0.4, 12)
    n, rate = 2.0 + x, 1.0 / (1.0 + 0.3 * x**2)
    if name == "J":
        assert found["J"] == pytest.approx(2.0 * rate * 0.7**2 / n**3 / (0.5 + 2.0 / n**2), rel=1e-12)
    else:
        rate *= n * 0.7
        assert found["m"] == pytest.approx(-0.5 * n * rate * 0.7 / (2.0 + 0.5 * n**2), rel=1e-12)
