r"""Parts of the bond graphs of machines: coordinates with their inertia, contacts, links, members, motors and servos.

Each contact is one resistance with a port at every coordinate that moves its carrier: it receives their flows, and returns
:math:`A_k^T f_k`, so that its losses are the power at its ports for every map A: a row of the Jacobian that the equations of
motion have. Masses that do not move on their own are dependent storages.

Source: faulring2006, section V, for the plants; karnopp2012 for rigid bodies, chapter 9.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from infinivar._core.array_namespace import Array, namespace
from infinivar.bondgraph import graph as bg
from infinivar.bondgraph.graph import BondGraph, Element, Parameter, Signal
from infinivar.contact.friction import coulomb
from infinivar.drivetrain.graphs import pieces
from infinivar.machines.linkage import LeggedMechanics
from infinivar.machines.motors import PowerMotor, SteeringServo
from infinivar.parts.shaft_bearings import ROLLERS, WheelLoad
from infinivar.transmission.mechanism import Mechanism
from infinivar.transmission.rolling_contact import RollingContact
from infinivar.transmission.spherical import SphericalIVT


class Bonds(NamedTuple):
    """Part of a graph, which others join at its 1-junctions."""

    elements: list[Element]
    chains: list[str]
    """Of bonds."""
    signals: list[Signal]

    @classmethod
    def of(cls, *parts: Bonds) -> Bonds:
        """Several parts as one."""
        elements, chains, signals = ([one for part in parts for one in part[place]] for place in range(3))
        return cls(elements, chains, signals)  # type: ignore[arg-type]


class Coordinate(NamedTuple):
    """A coordinate with an inertia of its own."""

    name: str
    """Of its 1-junction."""
    symbol: str
    storage: str
    """Name of its inertia."""
    letter: str
    """Symbol of that."""
    unit: str
    title: str


def inertias(coordinates: Sequence[Coordinate], inertia: np.ndarray) -> Bonds:
    """Coordinates with the diagonal of a mass matrix (N, N)."""
    elements: list[Element] = []
    for place, one in enumerate(coordinates):
        elements.append(bg.one(one.name, one.symbol))
        elements.append(bg.inertia(one.storage, one.letter, float(inertia[place, place]), one.unit, title=one.title))
    return Bonds(elements, [f"{one.name} > {one.storage}" for one in coordinates], [])


def axes_that_turn(
    name: str, symbol: str, chain: tuple[str, str], turn: str, momentum: Parameter, sign: float
) -> Bonds:
    """The force that keeps a momentum's direction in turning axes exchanges power between two of them.

    Parameters
    ----------
    name, symbol : str
    chain : two names      Of the coordinates, with those of the axes.
    turn : str             Signal of the rate at which they turn.
    momentum : Parameter   Mass, or moment of inertia.
    sign : float           1 or -1.
    """
    law = functools.partial(_momentum, sign)
    made = bg.gyrator(name, symbol, law, signals=(turn,), parameters={"mass": momentum})
    return Bonds([made], [f"{chain[0]} > {name} > {chain[1]}"], [])


def _momentum(sign: float, turn: Array, mass: Array) -> Array:
    return sign * mass * turn


def wheels(mechanism: Mechanism, ports: Sequence[str], stick_speed: float, *, quarter: bool = False) -> Bonds:
    """Contacts of a mechanism on the coordinates of its Jacobian; `quarter`: angles are from y, as on a cylinder."""
    stick, jacobian = Parameter(r"v_{\varepsilon}", stick_speed, "m/s"), np.asarray(mechanism.jacobian)
    return Bonds.of(
        *(
            contact(f"wheel_{place}", one, jacobian[place - 1], ports, f"phi_{place}", stick, quarter=quarter)
            for place, one in enumerate(mechanism.contacts, 1)  # type: ignore[arg-type]
        )
    )


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


def contact(
    name: str,
    wheel: RollingContact,
    rows: np.ndarray,
    ports: Sequence[str],
    angle: str,
    stick: Parameter,
    *,
    quarter: bool = False,
    surface: float | None = None,
) -> Bonds:
    """The multiport resistance of a contact, on the junctions that move it; rows (2, ports)."""
    moving = [place for place in range(len(ports)) if np.any(rows[:, place] != 0.0)]
    kept = tuple(tuple(float(row[place]) for place in moving) for row in rows)
    given = (wheel, kept, quarter, surface)
    made = bg.resistance(
        name,
        rf"F_{{{name.split('_')[1]}}}",
        functools.partial(_efforts, *given),
        signals=(angle,),
        parameters={"stick_speed": stick},
        losses=functools.partial(_losses, *given),
        title="contact",
    )
    return Bonds([made], [f"{ports[place]} > {name}" for place in moving], [])


def user(junctions: Sequence[str]) -> Bonds:
    """What the user exerts on coordinates."""
    sources = [
        bg.effort_source(f"user_{place + 1}", f"W_{{{place + 1}}}", title="user") for place in range(len(junctions))
    ]
    return Bonds(sources, [f"user_{place + 1} > {name}" for place, name in enumerate(junctions)], [])


def rollers(ivt: SphericalIVT, ports: Sequence[str], stick_speed: float) -> Bonds:
    """Rollers on a sphere, on its five coordinates."""
    stick = Parameter(r"v_{\varepsilon}", stick_speed, "m/s")
    jacobian, rolling = ivt.rolling_map()
    made: list[Bonds] = []
    for place, roller in enumerate(ivt.patches()):
        name = f"roller_{place + 1}"
        moving = [port for port in range(5) if np.any(jacobian[place][:, port] != 0.0) or rolling[place][port] != 0.0]
        given = (roller, place, ivt, _row(jacobian[place][:, moving]), tuple(map(float, rolling[place][moving])))
        one = bg.resistance(
            name,
            rf"F_{{r{place + 1}}}",
            functools.partial(_roller_efforts, *given),
            signals=("phi_1",),
            parameters={"stick_speed": stick},
            losses=functools.partial(_roller_losses, *given),
            title="roller",
        )
        made.append(Bonds([one], [f"{ports[port]} > {name}" for port in moving], []))
    return Bonds.of(*made)


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


def legs(mechanics: LeggedMechanics, stick_speed: float) -> Bonds:
    """Cylinder, links with their guideways, and wheels; links are the 1-junctions "link_1" ..."""
    stick = Parameter(r"v_{\varepsilon}", stick_speed, "m/s")
    elements: list[Element] = [
        bg.one("cylinder", r"\omega"),
        bg.inertia("J_c", "J_c", mechanics.cylinder_inertia, "kg m^2", title="cylinder"),
    ]
    chains = ["cylinder > J_c"]
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
        made = contact(
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
    return Bonds.of(Bonds(elements, chains, []), under_wheels(mechanics, stick_speed))


def jacobian(ports: Sequence[str], links: int) -> Bonds:
    """Links on transformers whose moduli are the entries of a Jacobian, signals "J_11" ..."""
    elements: list[Element] = []
    chains: list[str] = []
    signals: list[Signal] = []
    for row in range(1, links + 1):
        elements.append(bg.zero(f"rod_{row}", f"f_{{{row}}}"))
        chains.append(f"rod_{row} > link_{row}")
        for column, port in enumerate(ports, 1):
            entry = f"J_{row}{column}"
            symbol = f"J_{{{row}{column}}}"
            elements.append(bg.transformer(f"map_{row}{column}", symbol, _itself, signals=(entry,)))
            chains.append(f"{port} > map_{row}{column} > rod_{row}")
            signals.append(Signal(name=entry, symbol=symbol))
    return Bonds(elements, chains, signals)


def _itself(value: Array) -> Array:
    return value


def pulleys(radii: np.ndarray) -> Bonds:
    """Joints on links by pulleys."""
    places = range(1, len(radii) + 1)
    made = [bg.transformer(f"pulley_{one}", rf"\rho_{{{one}}}", float(radii[one - 1]), "m") for one in places]
    return Bonds(made, [f"q_{one} > pulley_{one} > link_{one}" for one in places], [])


def members(load: Any) -> Bonds:
    """Joints "q_1" ... with their members, each with two velocities and a turning rate of its centre of mass."""
    n, lengths, bodies = load.arm.joints, load.arm.lengths, load.bodies
    elements: list[Element] = []
    chains: list[str] = []
    signals = []
    for joint in range(1, n + 1):
        elements.append(bg.one(f"q_{joint}", rf"\dot{{q}}_{{{joint}}}"))
        signals.append(Signal(name=f"angle_{joint}", symbol=f"q_{{{joint}}}", of=f"q_{joint}", integral=True))
    for member, body in enumerate(bodies, 1):
        # Before the masses: what a member turns at follows from no other rate at any angle.
        place, moment = f"turn_{member}", body.inertia + (load.tip_inertia if member == n else 0.0)
        if not moment:
            continue
        elements += [
            bg.one(place, rf"\dot{{\theta}}_{{{member}}}"),
            bg.inertia(f"I_{member}", f"I_{{{member}}}", moment, "kg m^2", title="arm"),
            bg.zero(f"sum_{place}", f"M_{{{member}}}"),
        ]
        chains.append(f"sum_{place} > {place} > I_{member}")
        chains += [f"q_{joint} > sum_{place}" for joint in range(1, member + 1)]
    points = [(f"{member}", member, *body.centre, body.mass) for member, body in enumerate(bodies, 1)]
    if load.tip_mass:
        points.append(("tip", n, lengths[-1], 0.0, load.tip_mass))
    for label, member, along, across, mass in points:
        for axis, fall in zip(("x", "y"), load.gravity or (0.0, 0.0), strict=True):
            if not mass:
                continue
            place = f"{axis}_{label}"
            elements += [
                bg.zero(f"sum_{place}", f"F_{{{axis}{label}}}"),
                bg.one(place, rf"\dot{{{axis}}}_{{{label}}}"),
                bg.inertia(f"m_{place}", f"m_{{{label}}}", mass, "kg", title="arm"),
            ]
            chains.append(f"sum_{place} > {place} > m_{place}")
            if fall and label != "tip":  # the weight of a load is a part of the wrench
                weight = {"weight": Parameter(f"G_{{{axis}{label}}}", -mass * fall, "N")}
                name = f"weight_{place}"
                symbol = f"W_{{{axis}{label}}}"
                elements.append(bg.compliance(name, symbol, _weight, energy=_lifted, title="weight", parameters=weight))
                chains.append(f"{place} > {name}")
            for joint in range(1, member + 1):
                arms = tuple(float(length) for length in (*lengths[joint - 1 : member - 1], along))
                law = functools.partial(_lever, axis, joint, arms, float(across))
                name = f"lever_{place}_{joint}"
                used = tuple(f"angle_{one}" for one in range(1, member + 1))
                elements.append(bg.transformer(name, f"J_{{{axis}{label},{joint}}}", law, signals=used))
                chains.append(f"q_{joint} > {name} > sum_{place}")
    return Bonds(elements, chains, signals)


def _weight(lifted: Array, weight: Array) -> Array:
    """The same force at any height."""
    return weight + 0.0 * lifted


def _lifted(lifted: Array, weight: Array) -> Array:
    """Energy of a weight."""
    return weight * lifted


def _lever(axis: str, joint: int, arms: tuple[float, ...], across: float, *angles: Array) -> Array:
    """Velocity of a point of an arm along an axis, by the rate of a joint; `arms` are lengths from the joint to the point, which
    is beside the last one."""
    xp = namespace(*angles)
    total, direction = 0.0, sum(angles[: joint - 1])
    for place, length in enumerate(arms):
        direction = direction + angles[joint - 1 + place]
        total = total + length * (-xp.sin(direction) if axis == "x" else xp.cos(direction))
    if across:
        total = total - across * (xp.cos(direction) if axis == "x" else xp.sin(direction))
    return total


def servo_plant(servo: SteeringServo, number: int) -> BondGraph:
    """Motor, gear and bell of one steered axis; measures its angle as "phi_<number>".

    Source: faulring2006, Fig 11.
    """
    plant, motor = servo.plant, servo.plant.motor
    stick = Parameter(r"\varepsilon_s", servo.stick_speed, "rad/s")
    motor_stick = Parameter(r"\varepsilon_{m,s}", servo.stick_speed * plant.ratio, "rad/s")
    elements, chains, _ = pieces.motor_terminals(
        motor, servo.amplifier, f"{{s{number}}}", "current", motor_stick, "steering", "steering."
    )
    bell = (
        pieces.friction("bearing", rf"T_{{b,{number}}}", servo.bell_friction, "N m", stick, "steering bearing"),
        pieces.friction("patch", rf"T_{{p,{number}}}", servo.patch_friction, "N m", stick, "steering patch"),
    )
    attached, attached_chains = pieces.attach(bell=bell)
    return BondGraph(
        f"Steering {number}",
        [
            *elements,
            bg.one("bell", rf"\dot{{\phi}}_{{{number}}}"),
            bg.inertia("J_b", "J_b", plant.inertia_of_bell, "kg m^2", title="bell"),
            pieces.gear("gear", "n_s", plant.ratio),
            *attached,
        ],
        [*chains, "rotor > gear > bell > J_b", *attached_chains],
        [
            Signal(name=f"phi_{number}", symbol=rf"\phi_{{{number}}}", of="bell", integral=True),
            Signal(name=f"phi_rate_{number}", symbol=rf"\dot{{\phi}}_{{{number}}}", of="bell"),
        ],
    )


def motor_plant(motor: PowerMotor) -> BondGraph:
    """The power motor with its gearhead, open at "shaft".

    Source: faulring2006, Fig 12.
    """
    stick = Parameter(r"\varepsilon_{m,c}", motor.stick_speed, "rad/s")
    elements, chains, signals = pieces.motor_terminals(motor.motor, motor.amplifier, "c", "current", stick, "", "")
    gear, gear_chains, gear_signals = pieces.gearhead(motor.gearhead, motor.motor, "c", stick)
    return BondGraph(
        "Power motor",
        [*elements, *gear, bg.one("shaft")],
        [*chains, *gear_chains, "rotor > gear > shaft"],
        [*signals, *gear_signals],
    )


def under_wheels(mechanics: LeggedMechanics, stick_speed: float) -> Bonds:
    """Friction on the 1-junction "cylinder" under the wheels of links "link_1" ...; nothing without bearings."""
    bearings, element = mechanics.cylinder_bearings, mechanics.transmission
    if bearings is None:
        return Bonds([], [], [])
    radius, places = float(element.cylinder_radius), range(1, mechanics.count + 1)
    stick = Parameter(r"\varepsilon_c", stick_speed / radius, "rad/s")
    rolling = mechanics.count * float(element.groups(mechanics.set_speed).rolling_force)
    backed = float(bearings.roller_torque(rolling, radius))
    rollers = pieces.friction("backing_rollers", "T_{br}", backed, "N m", stick, ROLLERS)
    signals = [Signal(name=f"ldot_{one}", symbol=rf"\dot{{l}}_{{{one}}}", of=f"link_{one}") for one in places]
    inputs = [f"{name}_{one}" for name in ("phi", "ldot") for one in places]
    if bearings.span is not None and mechanics.load.slides:
        signals += [Signal(name=f"l_{one}", symbol=f"l_{{{one}}}", of=f"link_{one}", integral=True) for one in places]
        inputs += [f"l_{one}" for one in places]
    law = functools.partial(_under_all, mechanics, stick_speed)
    made = bg.resistance(
        "bearings", "T_{cb}", law, signals=tuple(inputs), parameters={"stick_speed": stick}, title=bearings.title
    )
    elements = [one for one in (made, rollers) if one is not None]
    return Bonds(elements, [f"cylinder > {one.name}" for one in elements], signals)


def _under_all(
    mechanics: LeggedMechanics, rolls_from: float, turning: Array, *given: Array, stick_speed: Array
) -> Array:
    """Friction torque under all wheels, from angles, speeds and, if they matter, positions of the links."""
    bearings, element, n = mechanics.cylinder_bearings, mechanics.transmission, mechanics.count
    assert bearings is not None
    xp, radius = namespace(turning, *given), element.cylinder_radius
    angles, speeds, positions = given[:n], given[n : 2 * n], given[2 * n :] or (0.0,) * n
    wheels = []
    for angle, speed, position, azimuth in zip(angles, speeds, positions, bearings.around(n), strict=True):
        found = element.wheel.act(
            (speed, -radius * turning),
            (xp.sin(angle), xp.cos(angle)),
            surface_speed=radius * abs(mechanics.set_speed),
            stick_speed=rolls_from,
        )
        wheels.append(WheelLoad(element.preload, radius * found.y, found.x, radius, position, azimuth))
    return coulomb(turning, bearings.moment(wheels, abs(mechanics.set_speed)), stick_speed)
