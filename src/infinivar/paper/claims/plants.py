"""Checks of what the paper says about the plants around the contact (sections V to VII): steering, gears, motor, steel."""

from __future__ import annotations

import functools
import math
from dataclasses import replace

import numpy as np

from infinivar.analysis.cycles.performance import PAPER
from infinivar.analysis.cycles.shaking import shaking
from infinivar.analysis.design_trends import with_friction, with_material
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.drive import needed
from infinivar.drivetrain.graphs.compliances import DAMPING
from infinivar.paper.claims.claim import (
    FACTOR,
    Checked,
    Found,
    PaperMachine,
    at_ratio,
    either_way,
    near,
    row,
    yes,
)
from infinivar.paper.claims.planes import PLANES, plane_map
from infinivar.parts.motor import Motor
from infinivar.study.catalogue import materials
from infinivar.transmission import spin_law
from infinivar.transmission.rotary_linear import RotaryLinearIVT

_HALF = 0.5
_WHOLE_PERCENT = 0.005
"""Half a point: what changes no printed percent. [-]"""
_READING = 0.01
_FASTEST, _SLOW = 75.0, 2.0
"""Largest steering rates: when shaking at 10 Hz and full power, and in free motion at 1 Hz with 0.2 m/s. [rad s^-1]"""

_WIND_UP = math.radians(0.3)
"""Twist of a gear train under the continuous torque of its motor, assumed; small gears have a tenth of a degree to one. [rad]"""
_SOFT, _STIFF = math.radians(1.0), math.radians(0.1)
_LOST = 2.0 * math.pi * DAMPING
"""Share of the energy put into a spring that its damper loses, with the damping of geared drives in simulations. [-]"""


@functools.lru_cache(maxsize=32)
def passed_power(element: RotaryLinearIVT, load: float, ratio: float, fastest: float = _FASTEST) -> tuple[float, float]:
    """Largest power that the patch of an element with spin passes between steering and rolling, and the power delivered. [W]

    A patch dissipates ``f_u u + M rate`` in all. Where one of the two is negative, that much goes from the other plant into this
    one: the moment of a loaded patch turns the bell, or the bell drives the link.

    Source: `infinivar.transmission.spin_law`.
    """
    point = at_ratio(element, load, ratio)
    patch = spin_law.TurningPatch.of(element, element.groups(14.0))
    rolling, lateral = float(point.rolling_speed), float(point.lateral_force)
    reach = 3.0 * abs(rolling) * float(patch.slip_force / patch.creep_stiffness)
    most = 0.0
    rates = np.geomspace(0.01, fastest, 60)
    for rate in np.concatenate([-rates, rates]):
        slip = reach + 2.0 * float(patch.lever) * abs(rate)
        creeping = np.linspace(-slip, slip, 1001)
        force, moment = spin_law.law(creeping, np.full_like(creeping, rate), rolling, **patch._asdict())
        rising = np.asarray(force)
        speed = float(np.interp(lateral, rising, creeping))
        turned = float(np.interp(speed, creeping, np.asarray(moment)))
        most = max(most, -turned * float(rate), -lateral * speed)
    return most, abs(float(point.power_out))


def g1(machine: PaperMachine) -> Checked:
    """Power between the steering plant and the transmission, by exact rolling theory with spin."""

    def found(
        element: RotaryLinearIVT, load: float = _HALF, ratio: float = 8.0, share: float = 0.0, fastest: float = _FASTEST
    ) -> Found:
        spinning = replace(element, creep_law="exact", steering_model="spin")
        passed, delivered = passed_power(spinning, load, ratio, fastest)
        words = f"up to {1e3 * passed:.2g} mW, {passed / delivered:.2%} of the power delivered"
        threshold = "none" if not share else f"at most {share:.1%} of the power delivered"
        return Found(words, threshold, yes(passed <= share * delivered))

    element = machine.element
    negligible = '"no" as too little to change a printed percent'
    variants = [
        row("definition", negligible, found(element, share=_WHOLE_PERCENT)),
        *(
            row("definition", f"{negligible}, {words}", found(element, share=_WHOLE_PERCENT, **how))
            for words, how in (
                ("at 10 % of the slip force", {"load": 0.1}),
                (f"at steering rates up to {_SLOW:g} rad/s", {"fastest": _SLOW}),
            )
        ),
        *(
            row("choice", f"at {load:.0%} of the slip force and {ratio:g}:1", found(element, load, ratio))
            for load, ratio in ((0.1, 8.0), (0.9, 8.0), (_HALF, 50.0))
        ),
        row("value", "reconstruction B", found(machine.cobotic("cobotic-b").transmission)),
        row(
            "contrary",
            "the paper's resistance to steering, a constant torque that depends on no load",
            Found("0 W, by definition", "none", yes(True)),
        ),
    ]
    why = (
        "A loaded patch has a moment about its normal, which turns the bell or resists it by the sense of steering; and a patch "
        "that turns fast enough pushes the link. The paper's graph has no bond for either. Steering rates up to "
        f"{_FASTEST:g} rad/s, either way, at half load and 8:1."
    )
    return Checked(found(element), why, variants)


@functools.lru_cache(maxsize=8)
def _wound(machine: PaperMachine, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Energy put into the gear trains' springs per second and radian of wind-up over the power drawn, where the drive works.

    Cylinder and steering are added. Source: Hooke's law, ``T^2/(2 k)`` with ``k`` the continuous torque over the wind-up.
    """
    drive: CoboticDrive = machine.cobotic(name)
    plane = PLANES["coarse", "linear"]
    known = plane_map(drive, machine.power, machine.load_mass, PAPER, "coarse", "linear")
    steering = needed(drive.steering, "steering")
    springs = (
        drive.motor.continuous_torque * drive.gearhead.ratio,
        steering.motor.continuous_torque * steering.ratio,
    )
    share = np.zeros_like(known.power_in)
    for place, frequency in enumerate(known.frequency):
        rolled = drive.roll(shaking(known.amplitude[place], frequency, plane.samples), load_mass=machine.load_mass)
        turned = steering.follow(drive.transmission, rate=rolled.steering.rate, acceleration=rolled.steering.curvature)
        torques = rolled.torque, steering.ratio * np.asarray(turned.states["steering_torque_Nm"])
        for torque, continuous in zip(torques, springs, strict=True):
            stored = 0.5 * np.square(np.broadcast_to(torque, (len(known.fraction), plane.samples))) / continuous
            rises = np.maximum(np.roll(stored, -1, axis=-1) - stored, 0.0).sum(-1)
            share[place] += frequency * rises / known.power_in[place]
    return share, known.works


def g2(machine: PaperMachine) -> Checked:
    """Energy that elastic gear trains would dissipate over the plane of Fig 17."""

    def found(wind_up: float = _WIND_UP, lost: float = _LOST, worst: bool = False, name: str = "cobotic") -> Found:
        share, works = _wound(machine, name)
        kept = share[works]
        value = float(np.max(kept) if worst else np.mean(kept)) * wind_up * lost
        words = f"the power drawn rises by {value:.2%}{' at worst' if worst else ' on average'}"
        return Found(words, f"by less than {_WHOLE_PERCENT:.1%}", yes(value < _WHOLE_PERCENT))

    degrees = {wind_up: f"wind-up of {math.degrees(wind_up):g}°" for wind_up in (_STIFF, _SOFT)}
    variants = [
        *(row("value", words, found(wind_up)) for wind_up, words in degrees.items()),
        row("value", "all energy put into the springs is lost", found(lost=1.0)),
        row("choice", "in the worst cell", found(worst=True)),
        *(
            row("choice", f"{words}, in the worst cell", found(wind_up, worst=True))
            for wind_up, words in degrees.items()
        ),
        row("value", "reconstruction B", found(name="cobotic-b")),
        row(
            "value",
            f"reconstruction B, {degrees[_SOFT]}, in the worst cell",
            found(_SOFT, worst=True, name="cobotic-b"),
        ),
    ]
    share, works = _wound(machine, "cobotic")
    bound = math.degrees(_WHOLE_PERCENT / float(np.max(share[works])) / _LOST)
    why = (
        "A spring loses only what damps it. The paper prints neither stiffness nor damping; assumed are a wind-up of "
        f"{math.degrees(_WIND_UP):g}° under continuous torque and a damping of {DAMPING:g} of critical, which loses "
        f"{_LOST:.0%} of the energy put in, in the gears of cylinder and steering. Half a point would change a printed percent: "
        f"up to a wind-up of {bound:.2f}° no cell of Fig 17 reaches it."
    )
    return Checked(found(), why, variants)


def _scanned(motor: Motor) -> float:
    """Highest efficiency of a motor at its supply voltage, over all torques. [-]"""
    stall = motor.torque_constant * (motor.voltage / motor.resistance - motor.no_load_current)
    torque = np.linspace(0.0, stall, 4001)[1:-1]
    current = torque / motor.torque_constant + motor.no_load_current
    speed = (motor.voltage - motor.resistance * current) / motor.torque_constant
    point = motor.operate(torque=torque, speed=speed)
    return float(np.max(torque * speed / np.asarray(point.power)))


def c8(machine: PaperMachine) -> Checked:
    """Peak efficiency of both motors at their supply voltage."""
    small, large = (machine.conventional(name).motor for name in ("motor1-gear1", "motor2-gear4"))

    def found(motor: Motor, tolerance: float = _READING) -> Found:
        return near(_scanned(motor), 0.87, tolerance)

    variants = [
        row("choice", "half a point of tolerance, for rounding alone", found(small, _WHOLE_PERCENT)),
        row("value", "Motor 2", found(large)),
        *either_way(
            "no-load current", lambda factor: found(replace(small, no_load_current=factor * small.no_load_current))
        ),
    ]
    why = (
        f"The data sheet of the paper's motor is lost; {small.name} was chosen because it has this peak, so this tests nothing. "
        "Motor 2 is several such motors on one shaft, the only scaling that keeps efficiency, speed and voltage."
    )
    return Checked(found(small), why, variants, by_construction=True)


def _instead(drive: CoboticDrive, material: str, friction: float = 1.0) -> CoboticDrive:
    """The drive with both bodies of another material and a multiple of its friction, at the same slip force."""
    element = with_material(drive.transmission, material)
    if friction != 1.0:
        element = with_friction(element, friction * float(drive.transmission.friction))
    steering = needed(drive.steering, "steering")
    steering = replace(steering, sliding_friction=friction * steering.sliding_friction)
    return replace(drive, transmission=element, steering=steering)


def _turning(drive: CoboticDrive) -> float:
    return float(sum(needed(drive.steering, "steering").friction_torques(drive.transmission).values()))


def s7(machine: PaperMachine) -> Checked:
    """Steering torque and creep of steel on steel, over those of other materials at the same slip force."""
    steel = "bearing-steel"

    def found(name: str, friction: float = 1.0, drive: CoboticDrive = machine.drive) -> Found:
        base, other = (_instead(drive, body, one) for body, one in ((steel, 1.0), (name, friction)))
        torque = _turning(base) / _turning(other) - 1.0
        stiff = [float(one.transmission.groups(machine.cylinder_speed).creep_stiffness) for one in (base, other)]
        words = f"torque to steer {torque:+.1%}, creep {stiff[1] / stiff[0] - 1.0:+.1%}"
        return Found(words, "each below 0 %", yes(torque < 0.0 and stiff[1] < stiff[0]))

    softer = "al-7075-t6"
    variants = (
        row("value", materials()["ti-6al-4v"].name, found("ti-6al-4v")),
        *(
            row(
                "value",
                f"the softer material with {factor:g} times the friction, and so less preload",
                found(softer, factor),
            )
            for factor in (FACTOR, 2.0, 3.0)
        ),
        row("value", "reconstruction B", found(softer, drive=machine.cobotic("cobotic-b"))),
    )
    parts = needed(machine.drive.steering, "steering").friction_torques(machine.element)
    why = (
        f"Steel is compared with {materials()[softer].name} at the same slip force; the paper does not say with what. A stiffer "
        f"patch is smaller: it turns more easily and creeps less. Of the torque, {parts['bell'] / sum(parts.values()):.0%} are "
        "of the bell bearing, which carries the preload: a material with more friction needs less of it."
    )
    return Checked(found(softer), why, variants)


CHECKS = {"C8": c8, "G1": g1, "G2": g2, "S7": s7}
