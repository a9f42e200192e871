"""The paper's bond graphs give the paper's equations, symbolically. No tolerance: differences must simplify to zero."""

import pytest
import sympy

from infinivar.bondgraph import Bond, derive
from internals import contact_balance, relative_velocities
from internals import plant_graphs as plants
from internals import trace_law as trace

R, PHI, OMEGA = (sympy.Symbol(name, real=True) for name in ("R", r"\phi", r"\omega"))


def symbols(*names):
    return [sympy.Symbol(name, real=True) for name in names]


def embedded(plant, flow=False):
    """A plant between a motor and a link that decide its speeds (or a force at its link)."""
    from internals import bond_graph_elements as bg

    drive = bg.BondGraph("drive", [bg.one("shaft"), bg.flow_source("turn", r"\omega")], ["turn > shaft"])
    source = bg.effort_source("load", "f_l") if not flow else bg.flow_source("load", r"\dot{l}")
    load = bg.BondGraph("load", [bg.one("end"), source], ["end > load"])
    return bg.join("whole", {"d": drive, "p": plant, "l": load}, ["d.shaft > p.surface", "p.link > l.end"])


@pytest.mark.source("faulring2006", "Fig 2", "Eq 1", "Eq 2")
def test_fig_2_gives_eqs_1_and_2(study):
    """faulring2006, Eqs 1 and 2: ldot/omega = -R tan(phi), fl/tau = -1/(R tan(phi))."""
    equations = derive(embedded(plants.lossless_transmission(study.drives["cobotic"].transmission)))
    into, out = Bond("d.shaft", "p.surface"), Bond("p.link", "l.end")
    ratio = equations.flows[out] / equations.flows[into]
    assert sympy.simplify(ratio + R * sympy.tan(PHI)) == 0
    assert sympy.simplify(equations.efforts[out] / equations.efforts[into] + 1 / (R * sympy.tan(PHI))) == 0


@pytest.mark.source("faulring2006", "Fig 6", "Eq 3", "Eq 4", "Eq 5", "Eq 6")
def test_fig_6_gives_eqs_3_to_6(study):
    """faulring2006, Eqs 3-6: creep and rolling velocity, torque and link force, in passive form."""
    element = study.drives["cobotic"].transmission
    plant = plants.transmission_plant(element, cylinder_speed=14.0)
    equations = derive(embedded(plant, flow=True))
    ldot, fu, rolling, axle = symbols(r"\dot{l}", "f_u", "f_{in}", "f_{wa}")
    u = equations.flows[Bond("p.lateral", "p.creep")]
    v = equations.flows[Bond("p.tractive", "p.rolling")]
    assert sympy.simplify(u - (ldot * sympy.cos(PHI) + R * OMEGA * sympy.sin(PHI))) == 0
    assert sympy.simplify(v - (ldot * sympy.sin(PHI) - R * OMEGA * sympy.cos(PHI))) == 0
    fr = rolling + axle
    tau, fl = equations.efforts[Bond("d.shaft", "p.surface")], equations.efforts[Bond("p.link", "l.end")]
    assert sympy.simplify(tau - R * (fu * sympy.sin(PHI) - fr * sympy.cos(PHI))) == 0
    assert sympy.simplify(fl - (-fu * sympy.cos(PHI) - fr * sympy.sin(PHI))) == 0


@pytest.mark.source("faulring2006", "Eq 3", "Eq 4", "Eq 5", "Eq 6")
def test_the_steady_element_has_the_same_equations(study):
    """The functions that the steady map calls and the graph say the same, expression by expression."""
    plant = plants.transmission_plant(study.drives["cobotic"].transmission, cylinder_speed=14.0)
    equations = derive(embedded(plant, flow=True))
    ldot, fu, rolling, axle = symbols(r"\dot{l}", "f_u", "f_{in}", "f_{wa}")
    u, v = trace(relative_velocities, ldot, R * OMEGA, sympy.cos(PHI), sympy.sin(PHI))
    tau, fl = trace(contact_balance, fu, rolling + axle, sympy.cos(PHI), sympy.sin(PHI), R)
    assert sympy.expand(u - equations.flows[Bond("p.lateral", "p.creep")]) == 0
    assert sympy.expand(v - equations.flows[Bond("p.tractive", "p.rolling")]) == 0
    assert sympy.expand(tau - equations.efforts[Bond("d.shaft", "p.surface")]) == 0
    assert sympy.expand(fl - equations.efforts[Bond("p.link", "l.end")]) == 0


@pytest.mark.source("faulring2006", "Fig 10")
def test_states_of_fig_10(study):
    """Three energies are free: those of load and link, of bell and steering motor, of cylinder and its motor.

    The link carries the load, and each motor its gear's output, without play or spring: link, steering motor and cylinder
    motor have dependent storages. The steering angle is a state because it sets the moduli, though it stores no energy;
    so is the link's position, which controllers measure. With inductance each motor current is one more.
    """
    drive = study.drives["cobotic"]
    equations = derive(plants.cobotic_graph(drive, load_mass=0.8))
    assert [state.name for state in equations.states] == ["load_mass", "steering.J_b", "cylinder.J_c", "phi", "l"]
    assert equations.causality.dependent == ("steering.J_m", "cylinder.J_m", "link.m_l")
    assert not equations.causality.looped
    voltage = derive(plants.cobotic_graph(drive, load_mass=0.8, electrical="voltage"))
    assert {state.name for state in voltage.states} - {state.name for state in equations.states} == {
        "steering.L",
        "cylinder.L",
    }


@pytest.mark.source("faulring2006", "Fig 10", "Fig 11", "Fig 12", "Fig 13")
def test_inertias_of_fig_10_add_up(study):
    """Each motor's inertia acts on its gear's output with the square of the ratio."""
    equations = derive(plants.cobotic_graph(study.drives["cobotic"], load_mass=0.8))
    m, ml, bell, motor, n = symbols("m", "m_l", "J_b", "J_{m,s}", "n_s")
    force, current, constant = symbols("f", "I_s", "K_s")
    link, steering, *_ = equations.derivatives
    assert sympy.simplify(link.diff(force) - 1 / (m + ml)) == 0
    assert sympy.simplify(steering.diff(current) - constant * n / (bell + motor * n**2)) == 0


@pytest.mark.source("faulring2006", "Fig 14")
def test_states_of_fig_14(study):
    """One energy is free: motor, pulley and load turn together. The load's position is a state for its controller."""
    equations = derive(plants.conventional_graph(study.drives["motor2-gear4"], load_mass=0.8))
    assert [state.name for state in equations.states] == ["load_mass", "l"]
    assert equations.causality.dependent == ("J_gpc", "J_m")


@pytest.mark.parametrize("loss", ["coulomb", "proportional"])
def test_a_gear_that_loses_a_share_is_solved_exactly(study, loss):
    """With both laws the torque into the gear balances motor, friction and rotor to rounding, driving and driven."""
    import numpy as np

    from internals import FloatNamespace
    from internals import bond_graph_model as model

    name = {"coulomb": "cobotic", "proportional": "cobotic-b"}[loss]
    graph = plants.cobotic_graph(study.drives[name], load_mass=0.8)
    made = model(graph)
    parameters = {symbol: parameter.value for symbol, parameter in graph.parameters.items()}
    outputs, motion = (made.function(code, FloatNamespace, parameters) for code in ("outputs", "motion"))
    random = np.random.default_rng(3)
    bonds = [*made.bonds, *made.bonds]
    for _ in range(200):
        state = (random.normal(size=5) * [0.3, 3.0, 10.0, 0.5, 0.1]).tolist()
        inputs = (random.normal() * 20.0, 0.0, random.normal())
        values = outputs(state, inputs, ())
        efforts = dict(zip(made.bonds, values[: len(made.bonds)], strict=True))
        flows = dict(zip(made.bonds, values[len(made.bonds) : len(bonds)], strict=True))
        derivative = motion(state, inputs, ())[made.states.index("cylinder.J_c")]
        passed, speed = efforts["cylinder.rotor", "cylinder.gear"], flows["cylinder.rotor", "cylinder.gear"]
        lost = efforts["cylinder.rotor", "cylinder.gear_loss"]
        assert efforts["cylinder.gear", "cylinder.cylinder"] == pytest.approx(57.0 * passed, rel=1e-12)
        assert efforts["cylinder.rotor", "cylinder.J_m"] == pytest.approx(1.49e-6 * 57.0 * derivative, rel=1e-9)
        if loss == "proportional" and abs(speed) > 1.0:
            expected = (1 / 0.88 - 1) if passed * speed > 0 else 1 - 0.88
            assert abs(lost) == pytest.approx(expected * abs(passed), rel=1e-9)
        assert lost * speed >= 0.0
