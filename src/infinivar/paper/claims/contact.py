"""Checks of what the paper says about the contact in passing: nonlinearities, lateral force on the axle, gears above 90 %."""

from __future__ import annotations

from typing import Any

import numpy as np

from infinivar.contact import creep
from infinivar.paper.claims.claim import Checked, Found, PaperMachine, either_way, row, yes
from infinivar.paper.claims.element import elements, gears, with_bearing, with_geometry, with_oil
from infinivar.transmission.rotary_linear import RotaryLinearIVT

_HALF = 0.5
_HIGH = 0.9
"""Efficiency that Fig 8's caption calls high. [-]"""
_VERY_STRONG = "alpha "
"""Maker of industrial planetary gears, from the names in the data."""
_ONE_STAGE = 10.0
"""Largest ratio of a planetary gear of one stage. [-]"""


def e12(machine: PaperMachine) -> Checked:
    """Stiction, friction, compliance and backlash of the element by the paper's own laws."""
    speed = machine.cylinder_speed

    def resisting(element: RotaryLinearIVT) -> tuple[float, float]:
        """Rolling resistance to break away, and while it turns, against the cylinder's surface. [N]"""
        return float(element.groups(0.0).rolling_force), float(element.groups(speed).rolling_force)

    def yields(element: RotaryLinearIVT) -> float:
        """Lateral creep over rolling speed at half load, with the link at rest. [-]"""
        point = element.deliver(cylinder_speed=speed, link_speed=0.0, link_force=_HALF * element.slip_force)
        return abs(float(point.creep_speed / point.rolling_speed))

    def found(element: RotaryLinearIVT = machine.element) -> Found:
        stuck, rubs = resisting(element)
        creeps = yields(element)
        words = f"stiction {stuck:.2g} N, friction {rubs:.2g} N, creep {creeps:.2%} at half load, no backlash"
        return Found(words, "none of the four", yes(max(stuck, rubs, creeps) == 0.0))

    def at_link(limit: float, threshold: str) -> Found:
        """What the link feels while the cylinder turns: a jump as it reverses, and a bend of the creep curve up to a load."""
        element, tiny = machine.element, 1e-9
        ends = [
            float(element.deliver(cylinder_speed=speed, link_speed=way * tiny, link_force=0.0).steering_tangent)
            for way in (-1.0, 1.0)
        ]
        jump = element.groups(speed).creep_stiffness * (
            abs(ends[1] - ends[0]) - 2.0 * tiny / (element.cylinder_radius * speed)
        )
        left = 1.0 if limit <= 0.7 else float(np.asarray(creep.faulring_flow_factor(np.float64(limit))[0]))
        words = f"jump {abs(round(float(jump), 6)):g} N, flow x {left:.2f} by Eq 17 at {limit:g} of mu P"
        return Found(words, threshold, yes(abs(jump) < 1e-3 and left == 1.0))

    felt = "at the link, while the cylinder turns"
    variants = [
        *(row("value", words, found(element)) for words, element in elements(machine)),
        row(
            "definition",
            "SKF's later friction model of the axle bearings",
            found(with_bearing(machine.element, friction_model="skf")),
        ),
        row("definition", f"as a nonlinearity felt {felt}", at_link(0.95, "no jump, and a straight creep curve")),
        row(
            "contrary",
            "the same, only up to 0.7 of mu P, where the paper's creep law is linear",
            at_link(0.7, "no jump, and a straight creep curve"),
        ),
    ]
    stuck, rubs = resisting(machine.element)
    why = (
        f"By the paper's own Eqs 12 and 14 the wheel rubs with {rubs:.2g} N whichever way it rolls, and holds {stuck:.2g} N at "
        f"rest; by its Eq 7 it yields to a lateral force by {yields(machine.element):.2%} at half load, and by its Eq 17 not in "
        "proportion. There is no backlash. While the cylinder turns, no friction is felt at the link as that reverses."
    )
    return Checked(found(), why, variants)


def e13(machine: PaperMachine) -> Checked:
    """Rise of the axle bearings' friction from no lateral force to the slip limit."""

    def rise(element: RotaryLinearIVT, first: float = 0.0) -> float:
        before, after = (
            float(with_geometry(element, lateral_share=share).groups(speed).bearing_torque) for share in (first, 1.0)
        )
        return after / before - 1.0

    speed, friction = machine.cylinder_speed, float(machine.element.friction)
    skf = with_bearing(machine.element, friction_model="skf")

    def found(element: RotaryLinearIVT = skf, most: float = friction, first: float = 0.0) -> Found:
        value = rise(element, first)
        return Found(value, f"at most {most:g}", yes(value <= most))

    other = with_bearing(machine.cobotic("cobotic-b").transmission, friction_model="skf")
    variants = [
        row("choice", "half the threshold", found(most=0.5 * friction)),
        row("choice", "twice the threshold", found(most=2.0 * friction)),
        row("choice", "from a thousandth of the slip force, not from none", found(first=1e-3)),
        *either_way("viscosity of the base oil", lambda factor: found(with_oil(skf, factor))),
        row("value", "reconstruction B", found(other)),
        # So far apart, the lateral force at the rim loads one of them and relieves the other.
        *(
            row("value", f"axle bearings {1e3 * span:g} mm apart", found(with_geometry(skf, bearing_span=span)))
            for span in (0.01, 0.02, 0.04)
        ),
        row("definition", "constant coefficient of friction in the bearings", found(machine.element)),
    ]
    at_once = (1.0 + rise(skf)) / (1.0 + rise(skf, 1e-3)) - 1.0
    why = (
        f'The paper gives as its reason for "slightly" that the lateral force is at most mu = {friction:g} of the preload: a '
        "torque that rises by no more than that counts as slight. SKF's later model of the same bearings (the paper used SKF's "
        f"calculator) gives {rise(skf):+.0%}, of which {at_once:+.0%} come as soon as any lateral force acts. "
        "A constant coefficient of friction gives none: the preload alone decides the equivalent load."
    )
    return Checked(found(), why, variants)


def e14(machine: PaperMachine) -> Checked:
    """Planetary gears above 90 % that are neither very strong nor a single pair."""
    own = machine.conventional("motor2-gear4").gearhead

    def found(*, most: float = 0.0, without: str = "", worst: str = "low", stated: bool = True) -> Found:
        """Gears above 90 % with a ratio above `most`; those of the paper itself among them if `stated`."""
        known: list[dict[str, Any]] = [
            gear
            for gear in gears(worst)
            if gear["efficiency"] > _HIGH
            and gear["ratio"] > most
            and not gear["product"].startswith(_VERY_STRONG)
            and not (without and gear["product"] == without)
        ]
        names = [f"{gear['product']} {gear['ratio']:g}:1 {gear['efficiency']:.2f}" for gear in known]
        if stated and own.efficiency is not None and own.efficiency > _HIGH and own.ratio > most:
            names.append(f"the paper's own, VI-A, {own.efficiency:.2f}")
        return Found(", ".join(names) or "none", "none", yes(not names))

    several = [gear for gear in gears() if gear["efficiency"] > _HIGH and gear["ratio"] > _ONE_STAGE]
    names = list(dict.fromkeys(gear["product"] for gear in several if not gear["product"].startswith(_VERY_STRONG)))
    only = names[0] if len(names) == 1 else ""
    stage = f"one planetary stage, up to {_ONE_STAGE:g}:1, as a single pair"
    variants = [
        row("value", "gears of high confidence only", found(worst="high")),
        row("value", "without the paper's own gears", found(stated=False)),
        row("definition", stage, found(most=_ONE_STAGE)),
    ]
    if only:
        variants.append(row("value", f"{stage}, without {only}", found(most=_ONE_STAGE, without=only)))
    why = (
        "The gears listed are neither very strong industrial ones nor single pairs. Section VI-A itself puts single-stage "
        f"planetary gears of {own.efficiency:.0%} behind a motor of 22 W. If one stage counts as a single pair, they conform, "
        f"and so do all but {' and '.join(names) or 'none'}, from a catalogue of 2020. The data state neither "
        'prices nor torques, so "very expensive" is not checked.'
    )
    return Checked(found(), why, variants)


CHECKS = {"E12": e12, "E13": e13, "E14": e14}
