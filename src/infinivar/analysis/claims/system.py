"""Checks of the steady claims about the whole drive-trains (sections VI-A and VI-B)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from infinivar.analysis.claims.claim import Finding, Machine, about, yes
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.limits import Limit
from infinivar.parts.linear import Guideway

_SMALL = ("motor1-gear1", "motor1-gear2", "motor1-gear3")
_LARGE = "motor2-gear4"
_COBOTIC = {"A": "cobotic", "B": "cobotic-b"}
_READING = 0.01


def _conventional(machine: Machine, name: str) -> ConventionalDrive:
    drive = machine.comparison.study.drives[name]
    assert isinstance(drive, ConventionalDrive)
    return drive


def smallest_scale(machine: Machine, ratio: float) -> float:
    """Smallest scale of Motor 1 that covers the requirement on a fixed ratio, inf where none does. [-]"""
    from scipy.optimize import brentq

    large, motor = _conventional(machine, _LARGE), _conventional(machine, _SMALL[0]).motor
    speed, force, _ = machine.comparison.study.requirement.sample(41)

    def spare(scale: float) -> float:
        drive = replace(large, motor=motor.scaled(scale), gearhead=replace(large.gearhead, ratio=ratio))
        return float(drive.operate(speed=speed, force=force).margin.min()) - 1.0

    return brentq(spare, 0.5, 50.0, xtol=1e-6) if spare(50.0) > 0 else np.inf  # type: ignore[return-value]


def c1(machine: Machine) -> Finding:
    """Coverage of Motor 1 on three ratios."""
    shares = [machine.comparison.results[name].coverage for name in _SMALL]
    why = "Each ratio runs out of voltage at speed, of torque at force, or of both; the ratios are reconstructed."
    return Finding(", ".join(f"{share:.0%}" for share in shares), yes(max(shares) < 1.0), why)


def c2(machine: Machine) -> Finding:
    """Largest continuous power Motor 1 delivers to the load."""
    maps = [machine.comparison.results[name].map for name in _SMALL]
    value = max(float(steady.power_out[steady.limit == Limit.OK].max()) for steady in maps)
    required = machine.comparison.study.requirement.power or np.inf
    why = f"That many watts reach the load continuously on its best ratio; {required:.3g} W are required."
    return Finding(value, yes(value >= required), why)


def c3(machine: Machine) -> Finding:
    """Coverage of Motor 2."""
    result = machine.comparison.results[_LARGE]
    why = f"The tightest limit is {result.tightest.limit.words} with a margin of {result.tightest.value:.3f}."
    return Finding(f"{result.coverage:.0%}", yes(result.covers), why)


def c4(machine: Machine) -> Finding:
    """Smallest scale of Motor 1, over all ratios."""
    ratios = np.linspace(3.5, 4.6, 111)
    scales = np.array([smallest_scale(machine, ratio) for ratio in ratios])
    best = int(np.argmin(scales))
    shipped = _conventional(machine, _LARGE).gearhead.ratio
    why = (
        f"On the reconstructed {shipped:g}:1 the smallest scale is {smallest_scale(machine, shipped):.2f}, which rounds to "
        f"2.7, but {ratios[best]:.2f}:1 would need only {scales[best]:.2f}: the fourth ratio, not printed, decides."
    )
    return Finding(float(scales[best]), about(float(scales[best]), 2.7, 0.05), why)


def c5(machine: Machine) -> Finding:
    """Peak efficiency of Motor 2's drive."""
    result = machine.comparison.results[_LARGE]
    drive = replace(_conventional(machine, _LARGE), guideway=Guideway())
    free = drive.operate(speed=result.map.speed[:, None], force=result.map.force[None, :]).efficiency
    why = (
        f"Drag of 4.5 N at the load (assumed) costs the rest; without it the same motor and gear reach {np.nanmax(free):.2f}, "
        "and 0.87 x 0.97 = 0.84 bounds them anyway."
    )
    return Finding(result.peak_efficiency, about(result.peak_efficiency, 0.85, _READING), why)


def c6(machine: Machine) -> Finding:
    """Peak efficiency of Motor 2's drive in the region."""
    value = machine.comparison.results[_LARGE].peak_efficiency_in_region
    why = "Motor 2 is larger than the power needs, and in the region it works at low speed or low load; drag decides."
    return Finding(value, yes(value <= 0.65), why)


def c7(machine: Machine) -> Finding:
    """Share of winding loss of Motor 2's drive over the region."""
    speed, force, weight = machine.comparison.study.requirement.sample()
    point = _conventional(machine, _LARGE).operate(speed=speed, force=force)
    mean = {name: float(np.sum(weight * loss)) for name, loss in point.losses.items()}
    corner = machine.comparison.results[_LARGE].corners["maximum force"]
    power = float(np.sum(weight * point.power_in))
    largest = max(mean, key=lambda name: mean[name])
    why = (
        f"Averaged over the region winding heat is {mean['winding'] / sum(mean.values()):.0%} of the loss, and the largest "
        f"single loss is {largest}; at maximum force it is {corner.losses['winding'] / sum(corner.losses.values()):.0%}."
    )
    return Finding(f"{mean['winding'] / power:.0%} of the input", yes(largest == "winding"), why)


def b1(machine: Machine) -> Finding:
    """Coverage of the cobotic drive."""
    results = {letter: machine.comparison.results[name] for letter, name in _COBOTIC.items()}
    tight = results["A"].tightest
    why = f"With both reconstructions; in A the tightest margin is {tight.value:.2f} ({tight.limit.words})."
    found = ", ".join(f"{result.coverage:.0%} ({letter})" for letter, result in results.items())
    return Finding(found, yes(all(result.covers for result in results.values())), why)


def b2(machine: Machine) -> Finding:
    """Peak efficiency of the cobotic drive."""
    a, b = (machine.comparison.results[name].peak_efficiency for name in _COBOTIC.values())
    why = f"Reconstruction B, with a gear loss proportional to power, reaches {b:.3f}; both stay below 0.75."
    return Finding(a, yes(max(a, b) < 0.75), why)


def b3(machine: Machine) -> Finding:
    """Share of the region in which the cobotic drive beats Motor 2 on its gear."""
    speed, force, weight = machine.comparison.study.requirement.sample()
    drives = machine.comparison.study.drives
    moving = (speed > 0) & (force > 0)
    rival = drives[_LARGE].operate(speed=speed, force=force).power_in
    share = {}
    for letter, name in _COBOTIC.items():
        better = drives[name].operate(speed=speed, force=force).power_in < rival
        share[letter] = float(weight[better & moving].sum() / weight[moving].sum())
    why = (
        "Against Motor 2, the only conventional drive that covers; at light load a cylinder gear with constant friction "
        "torque (A) still pays for 14 rad/s, one that loses in proportion to power (B) does not: that law decides."
    )
    found = ", ".join(f"{value:.0%} of the region ({letter})" for letter, value in share.items())
    return Finding(found, yes(min(share.values()) >= 1.0), why)


def b4(machine: Machine) -> Finding:
    """Limits that bound the cobotic drive anywhere."""
    requirement = machine.comparison.study.requirement
    reach = np.geomspace(1e-2, 10.0, 300)
    drive = machine.comparison.study.drives[_COBOTIC["A"]]
    point = drive.operate(speed=(reach * requirement.speed)[:, None], force=(reach * requirement.force)[None, :])
    found = {Limit(int(code)) for code in np.unique(point.limit)} - {Limit.OK}
    why = "At 14 rad/s the motor keeps its speed, and its continuous torque runs out before its voltage does."
    words = " and ".join(limit.words for limit in sorted(found))
    return Finding(words, yes(found == {Limit.SLIP, Limit.THERMAL}), why)


def b5(machine: Machine) -> Finding:
    """Cylinder speed at 8040 rpm through 57:1."""
    value = 8040.0 * 2.0 * np.pi / 60.0 / 57.0
    why = "8040 rpm through 57:1 is 14.77 rad/s; 14 rad/s is 7620 rpm at the motor, 5 % less power at the same torque."
    return Finding(value, about(value, 14.0, 0.5), why)


CHECKS = {
    **{"C1": c1, "C2": c2, "C3": c3, "C4": c4, "C5": c5, "C6": c6, "C7": c7},
    **{"B1": b1, "B2": b2, "B3": b3, "B4": b4, "B5": b5},
}
