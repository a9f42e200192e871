"""Compliances of a geared drive as bond graphs: torsion and backlash of the gearhead, stretch of the output stage.

Each is a C at a 0-junction between the parts that it connects, beside a damper: ``DAMPING`` of critical damping, for the inertia
on its motor side. With backlash the C has a dead zone, and the damper acts only while the flanks touch.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from infinivar._core.array_namespace import Array, namespace
from infinivar._core.fields import given
from infinivar.bondgraph import graph as bg
from infinivar.bondgraph.graph import Element, Parameter, Signal
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import shaft_inertia
from infinivar.parts.gear_law import Torsion

DAMPING = 0.05
"""Damping of gearhead and stage over critical damping; data sheets do not state it."""

TOUCH = 0.01
"""Depth over which the damping of touching flanks builds up, relative to the backlash."""


class Piece(NamedTuple):
    """Elements, chains of bonds, signals, and the 0-junction that belongs between two parts; "" if they are rigid."""

    elements: list[Element]
    chains: list[str]
    signals: list[Signal]
    node: str


RIGID = Piece([], [], [], "")


def dead_zone(angle: Array, stiffness: Array, backlash: Array) -> Array:
    """Torque of a spring with backlash: zero until the flanks touch, at half the backlash on either side.

    Parameters
    ----------
    angle : (...,) float       From the middle of the backlash. [rad]
    stiffness : (...,) float   [N m rad^-1]
    backlash : (...,) float    Free angle between both flanks, >= 0. [rad]

    Returns
    -------
    (...,) float   [N m]

    Source: Hooke's law for the angle beyond the free one.
    """
    return stiffness * _depth(angle, backlash)


def hardening(
    angle: Array, *, stiffness: Array, corner_1: Array, beyond_1: Array, corner_2: Array, beyond_2: Array
) -> Array:
    """Torque of a spring that is stiffer beyond two angles, and its stiffness there.

    Parameters
    ----------
    angle : (...,) float                  [rad]
    stiffness : (...,) float              Up to the first corner. [N m rad^-1]
    corner_1, corner_2 : (...,) float     0 < corner_1 <= corner_2. [rad]
    beyond_1, beyond_2 : (...,) float     Stiffness beyond each corner. [N m rad^-1]

    Returns
    -------
    (...,) float   [N m]

    Source: the inverse of `infinivar.parts.gear_law.Torsion.twist`.
    """
    first, second = _depth(angle, 2.0 * corner_1), _depth(angle, 2.0 * corner_2)
    return stiffness * angle + (beyond_1 - stiffness) * first + (beyond_2 - beyond_1) * second


def hardening_energy(
    angle: Array, *, stiffness: Array, corner_1: Array, beyond_1: Array, corner_2: Array, beyond_2: Array
) -> Array:
    """Energy of `hardening`, its integral. [J]"""
    first, second = _depth(angle, 2.0 * corner_1), _depth(angle, 2.0 * corner_2)
    steps = (beyond_1 - stiffness) * first * first + (beyond_2 - beyond_1) * second * second
    return 0.5 * (stiffness * angle * angle + steps)


def dead_zone_energy(angle: Array, stiffness: Array, backlash: Array) -> Array:
    """Energy of `dead_zone`, its integral. [J]

    Source: Hooke's law for the angle beyond the free one.
    """
    depth = _depth(angle, backlash)
    return 0.5 * stiffness * depth * depth


def touching_damper(speed: Array, angle: Array, damping: Array, backlash: Array) -> Array:
    """Torque of the damper of flanks that touch; it builds up with the depth and never creates energy. [N m]

    Source: none; as the impact dampers of flanks, it vanishes where they part.
    """
    xp = namespace(speed, angle, damping, backlash)
    return damping * speed * xp.clip(xp.abs(_depth(angle, backlash)) / (TOUCH * backlash), 0.0, 1.0)


def _depth(angle: Array, backlash: Array) -> Array:
    xp = namespace(angle, backlash)
    return angle - xp.clip(angle, -0.5 * backlash, 0.5 * backlash)


def rotor_inertia(drive: ConventionalDrive) -> float:
    """Inertia of rotor and gearhead at the gear output. [kg m^2]"""
    return drive.gearhead.ratio**2 * shaft_inertia(drive.motor, drive.gearhead)


def damping_of_gear(drive: ConventionalDrive) -> float:
    """Damping of the gearhead at its output; 0 if it is rigid. [N m s]"""
    stiffness = given(drive.gearhead.stiffness, 0.0)
    return 2.0 * DAMPING * math.sqrt(stiffness * rotor_inertia(drive))


def damping_of_stage(drive: ConventionalDrive) -> float:
    """Damping of the output stage at the load; 0 if it is rigid. [N s m^-1]"""
    turning = rotor_inertia(drive) + drive.gear_output_inertia
    stiffness = float(given(drive.stage.stiffness, 0.0))
    return 2.0 * DAMPING * math.sqrt(stiffness * turning) / float(drive.stage.travel_per_radian)


def gear_torsion(drive: ConventionalDrive) -> Piece:
    """Torsion and backlash between gearhead and output stage."""
    gear = drive.gearhead
    torsion = gear.torsion
    if torsion is None or gear.stiffness is None:
        return RIGID
    damping = damping_of_gear(drive)
    if torsion.corners:
        spring = bg.compliance(
            "gear_spring",
            "T_{k,g}",
            hardening,
            energy=hardening_energy,
            parameters=_hardening_parameters(torsion),
            title="gearhead spring",
        )
        damper = bg.resistance("gear_damping", "c_g", damping, "N m s", title="gearhead damping")
        return _joined("gear", spring, damper)
    if gear.backlash is None or not gear.slack:
        return _linear("gear", "g", "gearhead", gear.stiffness, damping, ("rad/(N m)", "N m s"))
    free = Parameter(r"\beta_g", gear.backlash, "rad")
    spring = bg.compliance(
        "gear_spring",
        "T_{k,g}",
        dead_zone,
        energy=dead_zone_energy,
        parameters={"stiffness": Parameter("k_g", gear.stiffness, "N m/rad"), "backlash": free},
        title="gearhead spring",
    )
    damper = bg.resistance(
        "gear_damping",
        "T_{c,g}",
        touching_damper,
        signals=("gear_twist_angle",),
        parameters={"damping": Parameter("c_g", damping, "N m s"), "backlash": free},
        title="gearhead damping",
    )
    angle = Signal(name="gear_twist_angle", symbol=r"\psi_g", of="gear_twist", integral=True)
    piece = _joined("gear", spring, damper)
    return piece._replace(signals=[angle])


def _hardening_parameters(torsion: Torsion) -> dict[str, Parameter]:
    """Of `hardening`; a spring of one corner has both corners there."""
    corners = [(float(torque), float(beyond)) for torque, beyond in torsion.corners]
    found = {"stiffness": Parameter("k_{g,1}", float(torsion.stiffness), "N m/rad")}
    for place in (1, 2):
        torque, beyond = corners[min(place, len(corners)) - 1]
        found[f"corner_{place}"] = Parameter(rf"\psi_{{g,{place}}}", float(torsion.twist(torque)), "rad")
        found[f"beyond_{place}"] = Parameter(f"k_{{g,{place + 1}}}", beyond, "N m/rad")
    return found


def stage_stretch(drive: ConventionalDrive) -> Piece:
    """Stretch of the output stage, between its transformer and the load."""
    stage = drive.stage
    if stage.stiffness is None:
        return RIGID
    damping = damping_of_stage(drive)
    return _linear(stage.title, stage.title[0], stage.title, float(stage.stiffness), damping, ("m/N", "N s/m"))


def _linear(name: str, tag: str, title: str, stiffness: float, damping: float, units: tuple[str, str]) -> Piece:
    spring = bg.compliance(f"{name}_spring", f"C_{tag}", 1.0 / stiffness, units[0], title=f"{title} spring")
    damper = bg.resistance(f"{name}_damping", f"c_{tag}", damping, units[1], title=f"{title} damping")
    return _joined(name, spring, damper)


def _joined(name: str, spring: Element, damper: Element) -> Piece:
    node, twist = f"{name}_node", f"{name}_twist"
    elements = [bg.zero(node), bg.one(twist), spring, damper]
    return Piece(elements, [f"{node} > {twist} > {spring.name}", f"{twist} > {damper.name}"], [], node)


def at_rest(drive: ConventionalDrive, force: float, inertial_torque: float = 0.0) -> dict[str, float]:
    """Displacements of the compliances that carry a force of the load, and a torque at the gear output, by element.

    The twist angle is also a signal of a gearhead with backlash.
    """
    found: dict[str, float] = {}
    stage, gear = drive.stage, drive.gearhead
    if stage.stiffness is not None:
        found[f"{stage.title}_spring"] = force / float(stage.stiffness)
    if gear.torsion is not None:
        torque = force * float(stage.travel_per_radian) + inertial_torque
        found["gear_spring"] = float(gear.torsion.twist(torque)) + math.copysign(0.5 * (gear.backlash or 0.0), torque)
        if gear.slack:
            found["gear_twist_angle"] = found["gear_spring"]
    return found
