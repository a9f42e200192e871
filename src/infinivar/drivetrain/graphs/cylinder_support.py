"""The cylinder's own bearings in bond graphs: friction on the cylinder that depends on what its wheels transmit.

Bearing friction is that at the set speed of the cylinder, as the friction of the axles is.
"""

from __future__ import annotations

import functools
from typing import NamedTuple

from infinivar._core.array_namespace import Array, namespace
from infinivar.bondgraph import graph as bg
from infinivar.bondgraph.graph import Element, Parameter, Signal
from infinivar.contact.friction import coulomb
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.graphs import pieces
from infinivar.parts.shaft_bearings import ROLLERS, CylinderBearings, WheelLoad, spread

SIGNALS = ("f_u", "f_r", "phi", "l")
"""Of one leg: forces of the contact across and along the rolling direction, steering angle, position of the link."""


class Support(NamedTuple):
    """Friction of the cylinder's bearings, and of backing rollers."""

    elements: tuple[Element, ...] = ()
    chains: tuple[str, ...] = ()
    signals: tuple[Signal, ...] = ()


def under_wheel(drive: CoboticDrive, stick_speed: float) -> Support:
    """Friction on the cylinder of a system whose plants are "cylinder" and "transmission"; nothing without bearings."""
    bearings, element = drive.cylinder_bearings, drive.transmission
    if bearings is None:
        return Support()
    stick = _stick(drive, stick_speed)
    rollers = _rollers(drive, stick)
    if not bearings.depends_on_load:
        still = spread(WheelLoad(element.preload, 0.0, 0.0, element.cylinder_radius), element.wheels)
        made = pieces.friction(
            "bearings", "T_{cb}", float(bearings.moment(still, drive.cylinder_speed)), "N m", stick, bearings.title
        )
        return _on_cylinder((made, rollers), ())
    law = functools.partial(_friction, bearings, abs(float(drive.cylinder_speed)), element.wheels)
    parameters = {
        "preload": Parameter("P", float(element.preload), "N"),
        "radius": Parameter("R", float(element.cylinder_radius), "m"),
        "stick_speed": stick,
    }
    made = bg.resistance("bearings", "T_{cb}", law, signals=SIGNALS, parameters=parameters, title=bearings.title)
    measured = (
        Signal(name="f_u", symbol="f_u", of="transmission.lateral"),
        Signal(name="f_r", symbol="f_r", of="transmission.tractive"),
    )
    return _on_cylinder((made, rollers), measured)


def under_preload(drive: CoboticDrive, stick_speed: float) -> tuple[list[Element], list[str]]:
    """Friction on the 1-junction "cylinder" of a plant that stands alone: under the preload, without force on the link."""
    if drive.cylinder_bearings is None:
        return [], []
    element, stick = drive.transmission, _stick(drive, stick_speed)
    still = spread(WheelLoad(element.preload, 0.0, 0.0, element.cylinder_radius), element.wheels)
    size = float(drive.cylinder_bearings.moment(still, drive.cylinder_speed))
    rubbing = pieces.friction("bearings", "T_{cb}", size, "N m", stick, drive.cylinder_bearings.title)
    return pieces.attach(cylinder=(rubbing, _rollers(drive, stick)))


def _on_cylinder(made: tuple[Element | None, ...], signals: tuple[Signal, ...]) -> Support:
    elements = tuple(one for one in made if one is not None)
    return Support(elements, tuple(f"cylinder.cylinder > {one.name}" for one in elements), signals)


def _stick(drive: CoboticDrive, stick_speed: float) -> Parameter:
    return Parameter(r"\varepsilon_c", stick_speed / float(drive.transmission.cylinder_radius), "rad/s")


def _rollers(drive: CoboticDrive, stick: Parameter) -> Element | None:
    bearings, element = drive.cylinder_bearings, drive.transmission
    assert bearings is not None
    if not bearings.backing_rollers:
        return None
    torque = bearings.roller_torque(element.groups(drive.cylinder_speed).rolling_force, element.cylinder_radius)
    return pieces.friction("backing_rollers", "T_{br}", float(torque), "N m", stick, ROLLERS)


def _friction(
    bearings: CylinderBearings,
    speed: float,
    wheels: int,
    turning: Array,
    lateral: Array,
    tractive: Array,
    phi: Array,
    position: Array,
    preload: Array,
    radius: Array,
    stick_speed: Array,
) -> Array:
    """Friction torque under the wheels, from the forces of all contacts; balances: faulring2006, Eq 5 and Eq 6."""
    xp = namespace(turning, lateral)
    cosine, sine = xp.cos(phi), xp.sin(phi)
    wheel = WheelLoad(
        preload=preload,
        torque=radius * (lateral * sine - tractive * cosine),
        force=-lateral * cosine - tractive * sine,
        radius=radius,
        position=position,
    )
    return coulomb(turning, bearings.moment(spread(wheel, wheels), speed), stick_speed)
