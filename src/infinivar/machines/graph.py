r"""Bond graphs of machines of many contacts: planar cobot, sphere, legs on a common cylinder, and arms.

Each contact is one resistance with a port at every coordinate that moves its carrier: it receives their flows, and returns
:math:`A_k^T f_k`, so that its losses are the power at its ports for every map A. Links of a platform hang on transformers whose
moduli are the entries of its Jacobian. Masses that do not move on their own are dependent storages.

The graphs are the source of the equations that `infinivar.machines.system` integrates by functions over arrays: the tests
compare both at random states, and whole motions of the machines with a constant Jacobian.

Source: faulring2006, section V, for the plants; karnopp2012 for rigid bodies, chapter 9.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Any

import numpy as np

from infinivar._core.array_namespace import Array, namespace
from infinivar.bondgraph import graph as bg
from infinivar.bondgraph.graph import BondGraph, Element, Parameter, Signal
from infinivar.drivetrain.graphs import pieces
from infinivar.errors import ParameterError
from infinivar.machines.graph_motors import motor_plant, servo_plant, under_wheels
from infinivar.machines.kind import Machine
from infinivar.machines.kinds.arm import ArmLoad, ArmMachine, SerialArmMachine
from infinivar.machines.kinds.linked import OwnMotors
from infinivar.machines.kinds.planar import PlanarMachine
from infinivar.machines.kinds.platform import PlatformLoad, PlatformMachine
from infinivar.machines.kinds.slide import SlideMachine
from infinivar.machines.kinds.sphere import SphereMachine
from infinivar.machines.linkage import LeggedMechanics
from infinivar.machines.registry import MACHINES
from infinivar.transmission.rolling_contact import RollingContact
from infinivar.transmission.spherical import SphericalIVT

Parts = tuple[list[Element], list[str], list[Signal]]
"""Elements, chains of bonds and signals."""


def machine_graph(
    machine: Machine, *, stick_speed: float = 1e-4, servos: bool = True, source: bool = True
) -> BondGraph:
    """The bond graph of a machine that moves.

    Parameters
    ----------
    machine : PlatformMachine, ArmMachine, SerialArmMachine, PlanarMachine or SphereMachine
    stick_speed : float    Speed below which friction sticks. [m s^-1]
    servos : bool          Whether servos steer the wheels; without, the angles are inputs.
    source : bool          Whether the power motor is part of it.

    Returns
    -------
    BondGraph
        Inputs are the user's wrench ("user_1" ...), currents of motor ("motor.source") and servos ("servo_1.source" ...) or
        angles ("phi_1" ...). For a platform the entries of the Jacobian ("J_11" ...) are inputs as well, of which the rates
        count: its body turns in its own axes, so that they are those of an angular velocity in these axes.

    Raises
    ------
    ParameterError
        If it is another machine, a value that motion requires is missing, or a contact turns with spin, which these graphs do
        not have.
    """
    if isinstance(machine, OwnMotors):
        raise ParameterError(
            "machine must have wheels, got one with a motor for each link: plant_graph has one such drive"
        )
    if isinstance(machine, SlideMachine):
        raise ParameterError("machine must not be a SlideMachine; plant_graph has one of its axes")
    if not isinstance(machine, MACHINES):
        names = ", ".join(kind.__name__ for kind in MACHINES)
        raise ParameterError(f"machine must be one of {names}, got a {type(machine).__name__}")
    for contact in _contacts(machine):
        if contact.turns_with_spin:
            raise ParameterError(
                "steering_model must be 'shear' for the bond graph of a machine of many contacts, got 'spin'; simulate_machine "
                "has contacts that turn with spin"
            )
    made = {
        PlanarMachine: _planar,
        SphereMachine: _sphere,
        PlatformMachine: _platform,
        ArmMachine: _arm,
        SerialArmMachine: _serial_arm,
    }[type(machine)](machine, stick_speed)
    elements, chains, signals = made
    mechanics = machine.mechanics(stick_speed)
    parts: dict[str, BondGraph] = {}
    if servos:
        servo = machine.servo(stick_speed)
        parts |= {f"servo_{place + 1}": servo_plant(servo, place + 1) for place in range(len(mechanics.steered))}
    motor = machine.power_motor(stick_speed) if source else None
    if motor is not None:
        parts["motor"] = motor_plant(motor)
        chains.append(f"motor.shaft > {_at(machine)}")
    known = {signal.name for signal in signals}
    for place in range(len(mechanics.steered)):
        if f"phi_{place + 1}" not in known and not servos:
            signals.append(Signal(name=f"phi_{place + 1}", symbol=rf"\phi_{{{place + 1}}}"))
    return bg.join(type(machine).__name__, parts, chains, elements=elements, signals=signals)


def _contacts(machine: Any) -> Sequence[RollingContact]:
    if isinstance(machine, PlanarMachine):
        return machine.cobot.contacts  # type: ignore[return-value]
    if isinstance(machine, SphereMachine):
        return machine.ivt.patches()
    return [machine.wheel if isinstance(machine, SerialArmMachine) else machine.leg.transmission.wheel]


def _at(machine: Machine) -> str:
    """The junction that the power motor turns."""
    return {SphereMachine: "shaft_1", SerialArmMachine: "q_1"}.get(type(machine), "cylinder")


# Contacts


def _contact_force(
    contact: RollingContact,
    rows: tuple[tuple[float, ...], tuple[float, ...]],
    quarter: bool,
    surface: float | None,
    *given: Array,
    stick_speed: Array,
) -> Any:
    """What a contact does at the flows of its ports and its angle; `quarter`: the angle is from y, as on a cylinder."""
    flows, angle = given[:-1], given[-1]
    xp = namespace(*flows, angle)
    vx, vy = (sum(entry * flow for entry, flow in zip(row, flows, strict=True)) for row in rows)
    cosine, sine = xp.cos(angle), xp.sin(angle)
    heading = (sine, cosine) if quarter else (cosine, sine)
    return contact.act((vx, vy), heading, surface_speed=surface, stick_speed=stick_speed)  # type: ignore[arg-type]


def _efforts(*given: Any, **parameters: Array) -> Any:
    """A^T f at the ports of a contact; arguments of `_contact_force`."""
    rows, found = given[1], _contact_force(*given, **parameters)
    made = tuple(-(a * found.x + b * found.y) for a, b in zip(*rows, strict=True))
    return next(iter(made)) if len(made) == 1 else made


def _losses(*given: Any, effort: Any, **parameters: Array) -> dict[str, Array]:
    """Losses of a contact by name; arguments of `_contact_force`."""
    found = _contact_force(*given, **parameters)
    xp = namespace(found.x)
    slides = found.slip_demand > 1.0
    creep = found.losses["creep"]
    return {
        "creep": xp.where(slides, 0.0, creep),
        "slip": xp.where(slides, creep, 0.0),
        "rolling": found.losses["rolling"],
        "bearing": found.losses["bearing"],
    }


def _contact(
    name: str,
    contact: RollingContact,
    rows: np.ndarray,
    ports: Sequence[str],
    angle: str,
    stick: Parameter,
    *,
    quarter: bool = False,
    surface: float | None = None,
) -> Parts:
    """The multiport resistance of a contact, on the junctions that move it; rows (2, ports)."""
    moving = [place for place in range(len(ports)) if np.any(rows[:, place] != 0.0)]
    kept = tuple(tuple(float(row[place]) for place in moving) for row in rows)
    given = (contact, kept, quarter, surface)
    made = bg.resistance(
        name,
        rf"F_{{{name.split('_')[1]}}}",
        functools.partial(_efforts, *given),
        signals=(angle,),
        parameters={"stick_speed": stick},
        losses=functools.partial(_losses, *given),
        title="contact",
    )
    return [made], [f"{ports[place]} > {name}" for place in moving], []


def _user(junctions: Sequence[str]) -> Parts:
    sources = [
        bg.effort_source(f"user_{place + 1}", f"W_{{{place + 1}}}", title="user") for place in range(len(junctions))
    ]
    return sources, [f"user_{place + 1} > {name}" for place, name in enumerate(junctions)], []


def _together(*parts: Parts) -> Parts:
    elements, chains, signals = ([one for part in parts for one in part[place]] for place in range(3))
    return elements, chains, signals  # type: ignore[return-value]


# Machines


def _planar(machine: PlanarMachine, stick_speed: float) -> Parts:
    cobot, ports = machine.cobot, ("v_x", "v_y", "w")
    stick = Parameter(r"v_{\varepsilon}", stick_speed, "m/s")
    assert cobot.mass is not None
    assert cobot.inertia is not None
    mass = Parameter("m", float(cobot.mass), "kg")
    body: Parts = (
        [
            bg.one("v_x", "v_x"),
            bg.one("v_y", "v_y"),
            bg.one("w", r"\omega"),
            bg.inertia("m_x", "m", mass.value, "kg", title="body"),
            bg.inertia("m_y", "m", mass.value, "kg", title="body"),
            bg.inertia("I", "I", float(cobot.inertia), "kg m^2", title="body"),
            # Axes that turn: the force that keeps a momentum's direction exchanges power between them.
            bg.gyrator("turning", r"-m\omega", _turned, signals=("turn",), parameters={"mass": mass}),
        ],
        ["v_x > m_x", "v_y > m_y", "w > I", "v_x > turning > v_y"],
        [Signal(name="turn", symbol=r"\omega", of="w")],
    )
    wheels = [
        _contact(
            f"wheel_{place + 1}", contact, np.asarray(cobot.mechanism.jacobian)[place], ports, f"phi_{place + 1}", stick
        )
        for place, contact in enumerate(cobot.contacts)  # type: ignore[arg-type]
    ]
    return _together(body, *wheels, _user(ports))


def _turned(turn: Array, mass: Array) -> Array:
    return -mass * turn


def _momentum(turn: Array, mass: Array) -> Array:
    return mass * turn


def _sphere(machine: SphereMachine, stick_speed: float) -> Parts:
    ivt, ports = machine.ivt, ("shaft_1", "shaft_2", "sphere_x", "sphere_y", "sphere_z")
    stick = Parameter(r"v_{\varepsilon}", stick_speed, "m/s")
    inertias = (machine.input_inertia, machine.output_inertia, *[machine.sphere_inertia] * 3)
    symbols = ("w_1", "w_2", r"\Omega_x", r"\Omega_y", r"\Omega_z")
    elements: list[Element] = []
    for place, (name, symbol, value) in enumerate(zip(ports, symbols, inertias, strict=True)):
        letter = f"J_{place + 1}" if place < 2 else "J_s"
        elements.append(bg.one(name, symbol))
        elements.append(bg.inertia(f"J_{name}", letter, value, "kg m^2", title="shaft" if place < 2 else "sphere"))
    body: Parts = (elements, [f"{name} > J_{name}" for name in ports], [])
    jacobian, rolling = ivt.rolling_map()
    rollers: list[Parts] = []
    for place, roller in enumerate(ivt.patches()):
        name = f"roller_{place + 1}"
        moving = [port for port in range(5) if np.any(jacobian[place][:, port] != 0.0) or rolling[place][port] != 0.0]
        given = (roller, place, ivt, _row(jacobian[place][:, moving]), tuple(map(float, rolling[place][moving])))
        made = bg.resistance(
            name,
            rf"F_{{r{place + 1}}}",
            functools.partial(_roller_efforts, *given),
            signals=("phi_1",),
            parameters={"stick_speed": stick},
            losses=functools.partial(_roller_losses, *given),
            title="roller",
        )
        rollers.append(([made], [f"{ports[port]} > {name}" for port in moving], []))
    return _together(body, *rollers, _user(ports[:2]))


def _row(rows: np.ndarray) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(map(float, row)) for row in rows)


def _roller(
    contact: RollingContact, place: int, ivt: SphericalIVT, rows: Any, rolling: Any, *given: Array, stick_speed: Array
) -> tuple[Any, Array, Array]:
    """Forces of a roller, the resistance to rolling of its axle, and its rolling speed."""
    flows, angle = given[:-1], given[-1]
    velocity = tuple(sum(entry * flow for entry, flow in zip(row, flows, strict=True)) for row in rows)
    heading = ivt.heading_of(place, angle)
    turned = sum(entry * flow for entry, flow in zip(rolling, flows, strict=True))
    driven = ivt.kinds[place] != "steering"
    speed = turned if driven else velocity[0] * heading[0] + velocity[1] * heading[1]
    found = contact.act(velocity, heading, surface_speed=speed, stick_speed=stick_speed)  # type: ignore[arg-type]
    axle = pieces.coulomb(turned, contact.groups(0.0).rolling_force, stick_speed) if driven else 0.0 * turned
    return found, axle, turned


def _roller_efforts(*given: Any, **parameters: Array) -> Any:
    rows, rolling = given[3], given[4]
    found, axle, _ = _roller(*given, **parameters)
    return tuple(-(a * found.x + b * found.y) + c * axle for a, b, c in zip(*rows, rolling, strict=True))


def _roller_losses(*given: Any, effort: Any, **parameters: Array) -> dict[str, Array]:
    contact = given[0]
    found, axle, turned = _roller(*given, **parameters)
    xp = namespace(found.x)
    slides, creep = found.slip_demand > 1.0, found.losses["creep"]
    groups = contact.groups(0.0)
    share = groups.rolling_torque / (groups.rolling_torque + groups.bearing_torque)
    return {
        "creep": xp.where(slides, 0.0, creep),
        "slip": xp.where(slides, creep, 0.0),
        "rolling": found.losses["rolling"] + share * axle * turned,
        "bearing": found.losses["bearing"] + (1.0 - share) * axle * turned,
    }


def _legs(mechanics: LeggedMechanics, stick_speed: float) -> Parts:
    """Cylinder, links with their guideways, and wheels; links are the 1-junctions "link_1" ..."""
    stick = Parameter(r"v_{\varepsilon}", stick_speed, "m/s")
    elements: list[Element] = [
        bg.one("cylinder", r"\omega"),
        bg.inertia("J_c", "J_c", mechanics.cylinder_inertia, "kg m^2", title="cylinder"),
    ]
    chains, signals = ["cylinder > J_c"], []
    surface = mechanics.transmission.cylinder_radius * abs(mechanics.set_speed)
    rows = np.array([[1.0, 0.0], [0.0, -mechanics.transmission.cylinder_radius]])
    for place in range(1, mechanics.count + 1):
        link = f"link_{place}"
        elements += [
            bg.one(link, rf"\dot{{l}}_{{{place}}}"),
            bg.inertia(f"m_{place}", "m_l", mechanics.link_mass, "kg", title="link"),
        ]
        chains.append(f"{link} > m_{place}")
        rubbing = pieces.friction(
            f"guideway_{place}", f"f_{{g,{place}}}", mechanics.guideway_friction, "N", stick, "guideway"
        )
        if rubbing is not None:
            elements.append(rubbing)
            chains.append(f"{link} > guideway_{place}")
        made = _contact(
            f"wheel_{place}",
            mechanics.transmission.wheel,
            rows,
            (link, "cylinder"),
            f"phi_{place}",
            stick,
            quarter=True,
            surface=float(surface),
        )
        elements += made[0]
        chains += made[1]
    support = under_wheels(mechanics, stick_speed)
    return [*elements, *support.elements], [*chains, *support.chains], [*signals, *support.signals]


def _platform(machine: PlatformMachine, stick_speed: float) -> Parts:
    mechanics = machine.mechanics(stick_speed)
    assert isinstance(mechanics.load, PlatformLoad)
    ports = ("v_x", "v_y", "v_z", "w_x", "w_y", "w_z")
    elements: list[Element] = []
    chains: list[str] = []
    signals: list[Signal] = []
    for place, name in enumerate(ports):
        turns = place >= 3
        symbol = rf"\omega_{name[-1]}" if turns else f"v_{name[-1]}"
        value = machine.inertia[place - 3] if turns else machine.mass
        letter = f"I_{name[-1]}" if turns else "m_p"
        elements += [
            bg.one(name, symbol),
            bg.inertia(f"I_{name}", letter, value, "kg m^2" if turns else "kg", title="platform"),
        ]
        chains.append(f"{name} > I_{name}")
        if turns:
            signals.append(Signal(name=f"turn_{name[-1]}", symbol=symbol, of=name))
    # Euler's equations: I_x dw_x = (I_y - I_z) w_y w_z; three gyrators, each modulated by a momentum about its own axis.
    for first, second, third in (("x", "y", "z"), ("y", "z", "x"), ("z", "x", "y")):
        name, moment = f"euler_{third}", Parameter(f"I_{third}", machine.inertia["xyz".index(third)], "kg m^2")
        elements.append(
            bg.gyrator(
                name, rf"I_{third}\omega_{third}", _momentum, signals=(f"turn_{third}",), parameters={"mass": moment}
            )
        )
        chains.append(f"w_{first} > {name} > w_{second}")
    for row in range(1, mechanics.count + 1):
        elements.append(bg.zero(f"rod_{row}", f"f_{{{row}}}"))
        chains.append(f"rod_{row} > link_{row}")
        for column, port in enumerate(ports, 1):
            entry = f"J_{row}{column}"
            symbol = f"J_{{{row}{column}}}"
            elements.append(bg.transformer(f"map_{row}{column}", symbol, _itself, signals=(entry,)))
            chains.append(f"{port} > map_{row}{column} > rod_{row}")
            signals.append(Signal(name=entry, symbol=symbol))
    return _together((elements, chains, signals), _legs(mechanics, stick_speed), _user(ports))


def _itself(value: Array) -> Array:
    return value


def _members(load: ArmLoad) -> Parts:
    """Joints "q_1" ... with their members, each with two velocities and a turning rate of its centre of mass."""
    n, lengths = load.arm.joints, load.arm.lengths
    elements: list[Element] = []
    chains: list[str] = []
    signals = []
    for joint in range(1, n + 1):
        elements.append(bg.one(f"q_{joint}", rf"\dot{{q}}_{{{joint}}}"))
        signals.append(Signal(name=f"angle_{joint}", symbol=f"q_{{{joint}}}", of=f"q_{joint}", integral=True))
    for member in range(1, n + 1):
        mass = float(load.masses[member - 1])
        if not mass:
            continue
        # Before the masses: what a member turns at follows from no other rate at any angle.
        place, moment = f"turn_{member}", mass * float(lengths[member - 1]) ** 2 / 12.0
        moment += load.tip_inertia if member == n else 0.0
        elements += [
            bg.one(place, rf"\dot{{\theta}}_{{{member}}}"),
            bg.inertia(f"I_{member}", f"I_{{{member}}}", moment, "kg m^2", title="arm"),
            bg.zero(f"sum_{place}", f"M_{{{member}}}"),
        ]
        chains.append(f"sum_{place} > {place} > I_{member}")
        chains += [f"q_{joint} > sum_{place}" for joint in range(1, member + 1)]
    points = [(f"{member}", member, 0.5, float(load.masses[member - 1])) for member in range(1, n + 1)]
    if load.tip_mass:
        points.append(("tip", n, 1.0, load.tip_mass))
    for label, member, share, mass in points:
        for axis in ("x", "y"):
            if not mass:
                continue
            place = f"{axis}_{label}"
            elements += [
                bg.zero(f"sum_{place}", f"F_{{{axis}{label}}}"),
                bg.one(place, rf"\dot{{{axis}}}_{{{label}}}"),
                bg.inertia(f"m_{place}", f"m_{{{label}}}", mass, "kg", title="arm"),
            ]
            chains.append(f"sum_{place} > {place} > m_{place}")
            for joint in range(1, member + 1):
                arms = tuple(
                    float(length) for length in (*lengths[joint - 1 : member - 1], share * lengths[member - 1])
                )
                law = functools.partial(_lever, axis, joint, arms)
                name = f"lever_{place}_{joint}"
                used = tuple(f"angle_{one}" for one in range(1, member + 1))
                elements.append(bg.transformer(name, f"J_{{{axis}{label},{joint}}}", law, signals=used))
                chains.append(f"q_{joint} > {name} > sum_{place}")
    return elements, chains, signals


def _lever(axis: str, joint: int, arms: tuple[float, ...], *angles: Array) -> Array:
    """Velocity of a point of an arm along an axis, by the rate of a joint; `arms` are lengths from the joint to the point."""
    xp = namespace(*angles)
    total, direction = 0.0, sum(angles[: joint - 1])
    for place, length in enumerate(arms):
        direction = direction + angles[joint - 1 + place]
        total = total + length * (-xp.sin(direction) if axis == "x" else xp.cos(direction))
    return total


def _arm(machine: ArmMachine, stick_speed: float) -> Parts:
    mechanics = machine.mechanics(stick_speed)
    assert isinstance(mechanics.load, ArmLoad)
    radii = mechanics.load.pulleys
    pulleys: Parts = (
        [
            bg.transformer(f"pulley_{joint}", rf"\rho_{{{joint}}}", float(radius), "m")
            for joint, radius in enumerate(radii, 1)
        ],
        [f"q_{joint} > pulley_{joint} > link_{joint}" for joint in range(1, len(radii) + 1)],
        [],
    )
    joints = [f"q_{joint}" for joint in range(1, len(radii) + 1)]
    # Links first: their masses are the independent storages.
    return _together(_legs(mechanics, stick_speed), pulleys, _members(mechanics.load), _user(joints))


def _serial_arm(machine: SerialArmMachine, stick_speed: float) -> Parts:
    mechanics = machine.mechanics(stick_speed)
    stick = Parameter(r"v_{\varepsilon}", stick_speed, "m/s")
    joints = [f"q_{joint}" for joint in range(1, machine.arm.joints + 1)]
    jacobian = np.asarray(mechanics.mechanism.jacobian)
    wheels = [
        _contact(f"wheel_{place + 1}", machine.wheel, jacobian[place], joints, f"phi_{place + 1}", stick, quarter=True)
        for place in range(len(jacobian))
    ]
    return _together(_members(mechanics.load), *wheels, _user(joints))
