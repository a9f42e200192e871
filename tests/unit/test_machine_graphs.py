"""Bond graphs of machines of many contacts against the functions that are integrated, and against the engine of the graphs."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar import machine_graph, simulate_machine
from infinivar.bondgraph import solve
from infinivar.motion import MachineScenario, VectorHistory
from infinivar.parts import CylinderBearings
from internals import FloatNamespace, System, rotation_matrix
from internals import SystemInputs as Inputs
from internals import bond_graph_figure as bond_graph
from internals import bond_graph_model as model
from machines import LEG, MACHINES
from sampled import sampled

STICK = 1e-4
BEARINGS = CylinderBearings(
    bearing=LEG.steering.bell_bearing, span=0.14, pull=80.0, pull_position=-0.02, backing_rollers=1
)
PROPORTIONAL = {"efficiency": 0.7, "backdriving_efficiency": 0.4, "loss_model": "proportional"}
UPRIGHT = {
    "member_centres": (0.12, 0.15),
    "member_offsets": (0.01, -0.03),
    "member_inertias": (4e-3, 2e-3),
    "gravity": (1.3, -9.7),
}
"""Members that are not uniform, with weight."""


def functions(machine, source=True):
    mechanics = machine.mechanics(STICK)
    motor = machine.power_motor(STICK) if source else None
    return System(mechanics=mechanics, motor=motor, servo=None)


def graph_at(machine, name, state, angles, current, push):
    """Rates of the coordinates by the graph's equations, powers of sources and losses."""
    graph = machine_graph(machine, stick_speed=STICK, servos=False)
    made = model(graph)
    parameters = {symbol: parameter.value for symbol, parameter in graph.parameters.items()}
    system = functions(machine)
    first, second, _ = system.places
    c, nu = state[:first], state[first:second]
    values = {f"user_{place + 1}": force for place, force in enumerate(push)}
    values |= {f"phi_{place + 1}": angle for place, angle in enumerate(angles)}
    values["motor.source"] = current
    rates = {}
    flows = nu.copy()
    if name == "platform":
        turn = rotation_matrix(c[None, 3:])[0]
        flows[3:6] = turn.T @ nu[3:6]
        values |= {f"user_{place + 4}": force for place, force in enumerate(turn.T @ push[3:])}
        step = 1e-6

        def jacobian(time):
            pose = c[None] + time * system.mechanics.at(c[None], nu[None]).changes
            found = system.mechanics.load.at(pose, nu[None, :-1]).jacobian[0]
            found[:, 3:] = found[:, 3:] @ rotation_matrix(pose[:, 3:])[0]
            return found

        here, slope = jacobian(0.0), (jacobian(step) - jacobian(-step)) / (2.0 * step)
        for row in range(6):
            for column in range(6):
                values[f"J_{row + 1}{column + 1}"] = here[row, column]
                rates[f"J_{row + 1}{column + 1}"] = slope[row, column]
    states = {
        "platform": ["I_v_x", "I_v_y", "I_v_z", "I_w_x", "I_w_y", "I_w_z", "J_c"],
        "planar": ["m_x", "m_y", "I"],
        "sphere": ["J_shaft_1", "J_shaft_2", "J_sphere_x", "J_sphere_y", "J_sphere_z"],
        "arm": ["m_1", "m_2", "J_c"],
        "serial arm": ["I_1", "I_2", "I_3"],
    }[name]
    if name == "arm":
        flows[:2] *= system.mechanics.load.pulleys
    if name == "serial arm":
        flows = np.cumsum(flows)
    lifted = {one: 0.0 for one in made.states if one.startswith("weight")}
    given = (
        lifted | dict(zip(states, flows, strict=True)) | {f"angle_{place + 1}": angle for place, angle in enumerate(c)}
    )
    if name == "platform":
        link = system.mechanics.load.at(c[None], nu[None, :-1])
        given |= {f"l_{place + 1}": position for place, position in enumerate(link.position[0])}
    dynamics = made.function("dynamics", FloatNamespace, parameters)
    found = dynamics(
        [float(given[one]) for one in made.states],
        [float(values[one]) for one in made.inputs],
        [float(rates[one]) for one in made.rates],
    )
    count, sources = len(made.states), len(made.sources)
    rate = dict(zip(made.states, found[:count], strict=True))
    changes = np.array([rate[one] for one in states])
    if name == "arm":
        changes[:2] /= system.mechanics.load.pulleys
    if name == "serial arm":
        changes = np.diff(changes, prepend=0.0)
    if name == "platform":
        changes[3:6] = turn @ changes[3:6]
    losses = {}
    for (_, title), value in zip(made.losses, found[count + sources :], strict=True):
        losses[title] = losses.get(title, 0.0) + value
    return changes, dict(zip(made.sources, found[count : count + sources], strict=True)), losses


@sampled(
    ("name", "changed"),
    [
        *((name, {}) for name in ("planar", "sphere", "arm", "serial arm", "platform")),
        ("arm", {"tip_inertia": 0.02}),
        ("arm", UPRIGHT),
        ("serial arm", {"gravity": (1.3, -9.7)}),
        *(
            (name, {"leg": replace(LEG, cylinder_bearings=BEARINGS, guideway=iv.parts.Guideway(friction=1.0))})
            for name in ("arm", "platform")
        ),
        ("sphere", {"gearhead": replace(LEG.gearhead, rated_torque=None, **PROPORTIONAL)}),
    ],
    every=8,
)
def test_graph_and_functions_have_the_same_accelerations_and_losses(name, changed):
    machine = replace(MACHINES[name][0], **changed)
    random = np.random.default_rng(3)
    system = functions(machine)
    first, second, _ = system.places
    steered, coordinates = len(system.mechanics.steered), second - first
    for _ in range(3):
        pose = machine.home + random.normal(size=first) * 0.01
        rates = 0.3 * random.normal(size=coordinates)
        if name in ("platform", "arm"):
            rates[:-1] *= 0.3
            rates[-1] = 14.0 + random.normal()
        push = random.normal(size=min(coordinates, 6 if name == "platform" else 3 if name != "sphere" else 2))
        if name in ("arm",):
            push = push[:2]
        angles, current = 0.4 * random.normal(size=steered), 0.05
        state = np.concatenate([pose, rates])
        held, wrench = (
            VectorHistory(time=[0, 1], values=[angles] * 2),
            VectorHistory(time=[0, 1], values=[-push] * 2),
        )
        moved = System(mechanics=system.mechanics, motor=system.motor, angles=held, wrench=wrench)
        found = moved.rates(Inputs(currents=np.array([current])), np.zeros(1), state[None])
        changes, sources, losses = graph_at(machine, name, state, angles, current, push)
        expected = found.derivative[0, first:]
        assert_allclose(changes, expected, rtol=1e-6, atol=1e-6 * np.abs(expected).max())
        powers = dict(zip((*moved.sources, *moved.losses), found.balance().power[0], strict=True))
        for title, loss in losses.items():
            assert_allclose(loss, powers[title], rtol=1e-9, atol=1e-12)
        assert sum(losses.values()) == pytest.approx(sum(powers[one] for one in moved.losses), rel=1e-9)
        pushed = sum(power for source, power in sources.items() if source.startswith("user"))
        assert_allclose(pushed, powers["user"], rtol=1e-9, atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "changed"),
    [("planar", {}), ("sphere", {}), ("serial arm", {}), ("serial arm", {"gravity": (1.3, -9.7)})],
)
def test_whole_motions_are_those_of_the_graph(name, changed):
    machine = replace(MACHINES[name][0], **changed)
    steered = len(machine.mechanics(STICK).steered)
    angles = [0.5, -0.3, 0.2][:steered] if name != "sphere" else [0.7]
    push = {"planar": [3.0, 1.0, 0.2], "sphere": [0.2, -0.05], "serial arm": [0.4, 0.2, -0.1]}[name]
    start = {}
    if name == "sphere":
        ideal = machine.ivt.ideal_speeds(0.7)
        rates = [float(ideal[0]), float(ideal[1]), math.cos(0.7), math.sin(0.7), 0.0]
        start = dict(zip(("J_shaft_1", "J_shaft_2", "J_sphere_x", "J_sphere_y", "J_sphere_z"), rates, strict=True))
    run = simulate_machine(
        machine,
        MachineScenario(
            duration=0.1,
            source="none",
            servos=False,
            steering=angles,
            wrench=[-force for force in push],
            output_step=0.02,
            rates=list(start.values()) or None,
        ),
    )
    graph = machine_graph(machine, stick_speed=STICK, servos=False, source=False)
    inputs = {f"user_{place + 1}": force for place, force in enumerate(push)}
    inputs |= {f"phi_{place + 1}": angle for place, angle in enumerate(angles)}
    with np.errstate(divide="ignore", invalid="ignore"):  # generated code evaluates both sides of a choice
        known = solve(graph, run.time, inputs=inputs, initial=start, rtol=1e-9)
    junctions = {
        "planar": ("v_x", "v_y", "w"),
        "sphere": ("shaft_1", "shaft_2", "sphere_x", "sphere_y", "sphere_z"),
        "serial arm": ("q_1", "q_2", "q_3"),
    }[name]
    for place, coordinate in enumerate(machine.mechanics(STICK).coordinates):
        if place < len(push):
            flow = known.flows[f"user_{place + 1}", junctions[place]]
            assert_allclose(run.columns[coordinate], flow, rtol=1e-5, atol=1e-5 * np.abs(flow).max())
    for title, lost in run.lost.items():
        assert_allclose(lost, known.lost[title], rtol=1e-4, atol=1e-7)
    stored, kept = (sum(one[-1] - one[0] for one in each.stored.values()) for each in (run, known))
    assert stored == pytest.approx(kept, rel=1e-4, abs=1e-7)
    assert run.closure < 1e-6
    assert known.closure < 1e-6


@sampled(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name in ("platform", "arm"))) for name in MACHINES], every=4
)
def test_graphs_with_servos_have_a_causality_and_a_drawing(name):
    machine = MACHINES[name][0]
    graph = machine_graph(machine, servos=name != "tetrahedral sphere")
    drawn = bond_graph.data(graph)
    assert all(stroke for _, _, stroke in drawn["bonds"])
    assert len(drawn["elements"]) == len(graph.elements)


def test_graph_refuses_contacts_with_spin():
    leg = replace(LEG, transmission=replace(LEG.transmission, creep_law="exact"))
    with pytest.raises(iv.ParameterError, match="steering_model must be 'shear'"):
        machine_graph(replace(MACHINES["platform"][0], leg=leg))
