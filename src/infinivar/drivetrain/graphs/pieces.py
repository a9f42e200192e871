"""Bond-graph components shared by the plants: the electrical side of a motor, gears, friction, a load.

Each function returns elements, chains of bonds between them, and signals.
"""

from __future__ import annotations

import functools
import math
from typing import Literal

from infinivar._core.array_namespace import Array, namespace
from infinivar.bondgraph import graph as bg
from infinivar.bondgraph.graph import Element, Parameter, Signal
from infinivar.contact.friction import coulomb
from infinivar.drivetrain.drive import needed
from infinivar.parts.amplifier import Amplifier
from infinivar.parts.gearhead import Gearhead
from infinivar.parts.motor import Motor

Electrical = Literal["current", "voltage"]
"""Output of the amplifier: a current, as in the paper, or a voltage controlled by a current loop."""

CURRENT_LOOP = 1000.0
"""Bandwidth of the amplifier's current loop in voltage drive. [Hz]"""


def motor_terminals(
    motor: Motor, amplifier: Amplifier, tag: str, electrical: Electrical, stick: Parameter, role: str, where: str
) -> tuple[list[Element], list[str], list[Signal]]:
    """Source, winding, gyrator and rotor of a motor, up to the 1-junction "rotor"; `tag` marks its symbols."""
    inertia = needed(motor.rotor_inertia, f"{where}motor.rotor_inertia")
    named = f"{role} " if role else ""
    resistance = Parameter(f"R_{tag}", motor.resistance, "ohm")
    constant = Parameter(f"K_{tag}", motor.torque_constant, "N m/A")
    lost = friction("motor_friction", f"T_{{m,{tag}}}", motor.friction_torque, "N m", stick, f"{named}motor friction")
    iron = None
    if motor.viscous_friction:
        iron = bg.resistance(
            "motor_iron", f"c_{{m,{tag}}}", motor.viscous_friction, "N m s", title=f"{named}motor iron"
        )
    attached, attached_chains = attach(rotor=(lost, iron))
    elements = [
        bg.one("electrical", "" if electrical == "current" else f"i_{tag}"),
        bg.resistance("winding", resistance.symbol, resistance.value, "ohm", title=f"{named}winding"),
        bg.gyrator("motor", constant.symbol, constant.value, "N m/A"),
        bg.one("rotor", rf"\omega_{{m,{tag}}}"),
        bg.inertia("J_m", f"J_{{m,{tag}}}", inertia, "kg m^2", title=f"{named}rotor"),
        *attached,
    ]
    chains = ["source > electrical > motor > rotor > J_m", "electrical > winding", *attached_chains]
    burnt = functools.partial(_amplifier_loss, amplifier)  # unlike a closure, it can be pickled
    if electrical == "current":
        return [bg.flow_source("source", f"I_{tag}", losses=burnt, title=f"{named}supply"), *elements], chains, []
    inductance = needed(motor.inductance, f"{where}motor.inductance")
    commanded, measured, turning = f"I_{tag}", f"i_{tag}", f"omega_{tag}"
    loop = {
        "resistance": resistance,
        "constant": constant,
        "gain": Parameter(f"k_{tag}", 2.0 * math.pi * CURRENT_LOOP * inductance, "V/A"),
        "largest": Parameter(f"V_{{{tag}}}", motor.voltage, "V"),
    }
    source = bg.effort_source(
        "source",
        f"V_{tag}",
        _current_loop,
        signals=(commanded, measured, turning),
        parameters=loop,
        losses=burnt,
        title=f"{named}supply",
    )
    signals = [
        Signal(name=commanded, symbol=f"I_{tag}"),
        Signal(name=measured, symbol=f"i_{tag}", of="electrical"),
        Signal(name=turning, symbol=rf"\omega_{{m,{tag}}}", of="rotor"),
    ]
    coil = bg.inertia("L", f"L_{tag}", inductance, "H", title=f"{named}inductance")
    return [source, coil, *elements], [*chains, "electrical > L"], signals


def _amplifier_loss(amplifier: Amplifier, power: Array, **given: Array) -> dict[str, Array]:
    """Loss in the amplifier as a function of motor power; in voltage drive it is passed the loop's parameters as well."""
    return {"amplifier": amplifier.supply(power)[1]}


def _inverse(ratio: Array) -> Array:
    return 1.0 / ratio


def _current_loop(
    commanded: Array, current: Array, speed: Array, resistance: Array, constant: Array, gain: Array, largest: Array
) -> Array:
    """Voltage of an amplifier with current control, limited to the supply voltage."""
    xp = namespace(commanded, current, speed)
    return xp.clip(resistance * commanded + constant * speed + gain * (commanded - current), -largest, largest)


def gearhead(
    gearhead: Gearhead, motor: Motor, tag: str, stick: Parameter
) -> tuple[list[Element], list[str], list[Signal]]:
    """Transformer of a gearhead, with its loss and inertia on the motor side."""
    elements = [gear("gear", f"n_{tag}", gearhead.ratio)]
    chains, signals = [], []
    if gearhead.inertia is not None:
        elements.append(bg.inertia("J_g", f"J_{{g,{tag}}}", gearhead.inertia, "kg m^2", title="gearhead inertia"))
        chains.append("rotor > J_g")
    law = gearhead.law(motor.continuous_torque)
    if law.is_zero:
        return elements, chains, signals
    said, passed = law.graph_law(tag), "gear_torque"
    if said.loaded:
        signals.append(Signal(name=passed, symbol=f"T_{{{tag}}}", of="gear"))
    elements.append(
        bg.resistance(
            "gear_loss",
            f"T_{{g,{tag}}}",
            said.law,
            signals=(passed,) if said.loaded else (),
            parameters={**said.parameters, "stick_speed": stick},
            solved=said.solved,
            title="gearhead",
        )
    )
    chains.append("rotor > gear_loss")
    return elements, chains, signals


def gear(name: str, symbol: str, ratio: float, unit: str = "") -> Element:
    """Reduction gear: the output shaft turns slower by `ratio`."""
    return bg.transformer(name, symbol, _inverse, parameters={"ratio": Parameter(symbol, ratio, unit)})


def friction(name: str, symbol: str, size: float, unit: str, stick: Parameter, title: str = "") -> Element | None:
    """Coulomb friction; None if its magnitude is zero."""
    if not size:
        return None
    parameters = {"size": Parameter(f"{{{symbol}}}^0", float(size), unit), "stick_speed": stick}
    return bg.resistance(name, symbol, coulomb, parameters=parameters, title=title)


def attach(**places: tuple[Element | None, ...]) -> tuple[list[Element], list[str]]:
    """Elements attached to junctions, given by junction name, and their bonds; skips None."""
    pairs = [(place, element) for place, elements in places.items() for element in elements if element is not None]
    return [element for _, element in pairs], [f"{place} > {element.name}" for place, element in pairs]


def motion_signals(of: str) -> list[Signal]:
    """Position and speed of the link."""
    return [Signal(name="l", symbol="l", of=of, integral=True), Signal(name="ldot", symbol=r"\dot{l}", of=of)]


def encoder_signals(of: str) -> list[Signal]:
    """Angle and speed of the motor, for controllers that measure there."""
    return [
        Signal(name="motor_angle", symbol=r"\theta_m", of=of, integral=True),
        Signal(name="motor_speed", symbol=r"\dot{\theta}_m", of=of),
    ]


def load(
    mass: float | None, imposed_motion: bool, at: str = "output", *, speed: str = r"\dot{l}", rotary: bool = False
) -> tuple[list[Element], list[str]]:
    """The 1-junction of the load with its mass, and the source of external force or motion; `speed` is a symbol."""
    elements, chains = [bg.one(at, speed)], []
    if mass:
        symbol, unit = ("J_L", "kg m^2") if rotary else ("m", "kg")
        elements.append(bg.inertia("load_mass", symbol, mass, unit, title="load"))
        chains.append(f"{at} > load_mass")
    if imposed_motion:
        return [*elements, bg.flow_source("motion", f"{speed}_e", title="load")], [*chains, f"motion > {at}"]
    push = bg.effort_source("force", "M_L" if rotary else "f", title="load")
    return [*elements, push], [*chains, f"force > {at}"]
