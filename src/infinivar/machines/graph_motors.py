"""Bond graphs of the power motor, the steering servos and the bearings of the common cylinder of a machine of many contacts."""

from __future__ import annotations

import functools

from infinivar._core.array_namespace import Array, namespace
from infinivar.bondgraph import graph as bg
from infinivar.bondgraph.graph import BondGraph, Parameter, Signal
from infinivar.contact.friction import coulomb
from infinivar.drivetrain.graphs import pieces
from infinivar.drivetrain.graphs.cylinder_support import Support
from infinivar.machines.kinds.arm import ArmLoad
from infinivar.machines.linkage import LeggedMechanics
from infinivar.machines.motors import PowerMotor, SteeringServo
from infinivar.parts.shaft_bearings import ROLLERS, WheelLoad


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
            bg.inertia("J_b", "J_b", plant.bell_inertia, "kg m^2", title="bell"),
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


def under_wheels(mechanics: LeggedMechanics, stick_speed: float) -> Support:
    """Friction on the 1-junction "cylinder" under the wheels of links "link_1" ...; nothing without bearings."""
    bearings, element = mechanics.cylinder_bearings, mechanics.transmission
    if bearings is None:
        return Support()
    radius, places = float(element.cylinder_radius), range(1, mechanics.count + 1)
    stick = Parameter(r"\varepsilon_c", stick_speed / radius, "rad/s")
    rolling = mechanics.count * float(element.groups(mechanics.set_speed).rolling_force)
    backed = float(bearings.roller_torque(rolling, radius))
    rollers = pieces.friction("backing_rollers", "T_{br}", backed, "N m", stick, ROLLERS)
    signals = [Signal(name=f"ldot_{one}", symbol=rf"\dot{{l}}_{{{one}}}", of=f"link_{one}") for one in places]
    asked = [f"{name}_{one}" for name in ("phi", "ldot") for one in places]
    if bearings.span is not None and not isinstance(mechanics.load, ArmLoad):
        signals += [Signal(name=f"l_{one}", symbol=f"l_{{{one}}}", of=f"link_{one}", integral=True) for one in places]
        asked += [f"l_{one}" for one in places]
    law = functools.partial(_under_all, mechanics, stick_speed)
    made = bg.resistance(
        "bearings", "T_{cb}", law, signals=tuple(asked), parameters={"stick_speed": stick}, title=bearings.title
    )
    elements = tuple(one for one in (made, rollers) if one is not None)
    return Support(elements, tuple(f"cylinder > {one.name}" for one in elements), tuple(signals))


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
