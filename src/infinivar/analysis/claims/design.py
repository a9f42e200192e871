"""Checks of what the paper recommends to change (section VII), on the geometry of the reconstruction."""

from __future__ import annotations

import numpy as np

from infinivar.analysis.claims import shaking
from infinivar.analysis.claims.claim import Finding, Machine, yes
from infinivar.analysis.claims.element import with_friction_model
from infinivar.analysis.design_trends import Duty, sensitivity, with_friction
from infinivar.drivetrain.drive import needed
from infinivar.transmission.rotary_linear import RotaryLinearIVT

_NAMES = {
    "friction": "friction limit with the preload as its inverse",
    "wheel_radius": "wheel radius",
    "axle_bore": "size of the axle bearings",
    "preload": "preload",
    "hysteresis_factor": "hysteresis loss factor",
    "youngs_modulus": "modulus",
    "crown_radius": "crown radius",
}


def _duty(machine: Machine) -> Duty:
    """Half of the slip force at 8:1, where the paper's element is at work."""
    return Duty(cylinder_speed=machine.cylinder_speed, link_force=0.5 * machine.element.slip_force, ratio=8.0)


def _slopes(machine: Machine, parameter: str, element: RotaryLinearIVT | None = None) -> dict[str, float]:
    """Percent of each loss per percent of a parameter."""
    return sensitivity(machine.element if element is None else element, parameter, _duty(machine))


def s1(machine: Machine) -> Finding:
    """Hysteresis loss factor."""
    slope = _slopes(machine, "hysteresis_factor")["total"]
    why = f"One percent less of it takes {slope:.2f} % off the loss of the element at 8:1: it is the smaller rolling loss."
    return Finding(slope, yes(slope > 0), why)


def s2(machine: Machine) -> Finding:
    """Friction limit, the preload following so that the slip force stays."""
    slopes = _slopes(machine, "friction")
    drive, element = machine.drive, machine.element
    assert drive.steering is not None
    before = drive.steering.friction_torques(element)
    after = drive.steering.friction_torques(with_friction(element, 1.01 * element.friction))
    steering = {name: 100.0 * (after[name] / before[name] - 1.0) for name in before}
    holds = slopes["rolling"] < 0 and slopes["bearing"] < 0 and slopes["creep"] > 0
    holds = holds and all(change < 0 for change in steering.values())
    why = (
        f"Per percent of mu: hysteresis {slopes['rolling']:+.2f} %, bearings {slopes['bearing']:+.2f} %, creep "
        f"{slopes['creep']:+.2f} %, in all {slopes['total']:+.2f} % at 8:1; to turn the patch {steering['patch']:+.2f} %, "
        f"bell bearing {steering['bell']:+.2f} %, and the guideway's share in the preload falls with it."
    )
    return Finding(slopes["total"], yes(holds), why)


def s3(machine: Machine) -> Finding:
    """Modulus of both bodies."""
    slopes = _slopes(machine, "youngs_modulus")
    why = (
        f"But only by a third as much: a stiffer patch is also smaller. Creep {slopes['creep']:+.2f} % per percent, and the "
        f"smaller patch takes {-slopes['rolling']:.2f} % off the hysteresis."
    )
    return Finding(slopes["creep"], yes(slopes["creep"] < 0), why)


def s4(machine: Machine) -> Finding:
    """Size of the axle bearings, by both friction models."""
    simple = _slopes(machine, "axle_bore")["bearing"]
    skf = _slopes(machine, "axle_bore", with_friction_model(machine.element, "skf"))["bearing"]
    why = (
        f"By a constant coefficient of friction a percent of size is {simple:+.2f} % of the bearing loss; by SKF's later "
        f"model, at the same load, {skf:+.2f} %: its sliding torque falls with size and only its rolling torque rises. The "
        "model of the bearing decides how much there is to gain."
    )
    return Finding(f"{simple:+.2f} and {skf:+.2f} % per percent of size", yes(simple > 0 and skf > 0), why)


def s5(machine: Machine) -> Finding:
    """Cylinder, bell and link, each a percent lighter, in the power taken while shaking a mass."""
    bench = shaking.Bench.of(machine)
    before = bench.pair().cobotic
    saved = {}
    for name, parameter in (("bell and steering motor", "steering_inertia"), ("link", "link_mass")):
        after = bench.moved(parameter, 0.99).pair().cobotic
        both = before.works & after.works & (before.frequency >= 1.0)[:, None]
        saved[name] = 100.0 * float(np.mean((after.power_in / before.power_in - 1.0)[both]))
    inertia = needed(machine.drive.cylinder_inertia, "cylinder_inertia")
    energy = 0.5 * inertia * machine.cylinder_speed**2
    why = (
        "Percent of power from the supply per percent of inertia or mass, on average from 1 to 30 Hz within limits. At constant "
        f"speed the cylinder's inertia costs nothing; a run-up stores {energy:.2f} J in it."
    )
    found = ", ".join(f"{name} {change:+.3f} %" for name, change in saved.items()) + ", cylinder 0 %"
    return Finding(found, yes(all(change < 0 for change in saved.values())), why)


def s6(machine: Machine) -> Finding:
    """Ranking of the parameters by their effect on the loss at 8:1."""
    slopes = {name: _slopes(machine, name)["total"] for name in _NAMES}
    ranked = sorted(slopes, key=lambda name: -abs(slopes[name]))
    value = ", ".join(f"{_NAMES[name]} {slopes[name]:+.2f}" for name in ranked)
    why = (
        "Percent of the element's loss per percent of the parameter, at half the slip force and 8:1, bearings by a constant "
        "coefficient; the ranking that the paper refers to is not printed in it, so there is nothing to hold this against."
    )
    return Finding(value, "undecidable", why)


CHECKS = {"S1": s1, "S2": s2, "S3": s3, "S4": s4, "S5": s5, "S6": s6}
