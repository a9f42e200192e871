"""Checks of the steady claims about the whole drive-trains (sections VI-A and VI-B)."""

from __future__ import annotations

from collections.abc import Callable
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


def _spare(machine: Machine, drive: ConventionalDrive) -> float:
    """How far the least margin over the region is above 1. [-]"""
    speed, force, _ = machine.comparison.study.requirement.sample(41)
    return float(drive.operate(speed=speed, force=force).margin.min()) - 1.0


def smallest_scale(machine: Machine, ratio: float) -> float:
    """Smallest scale of Motor 1 that covers the requirement on a fixed ratio, inf where none does. [-]"""
    from scipy.optimize import brentq

    large, motor = _conventional(machine, _LARGE), _conventional(machine, _SMALL[0]).motor
    geared = replace(large, gearhead=replace(large.gearhead, ratio=ratio))

    def spare(scale: float) -> float:
        return _spare(machine, replace(geared, motor=motor.scaled(scale)))

    return brentq(spare, 0.5, 50.0, xtol=1e-6) if spare(50.0) > 0 else np.inf  # type: ignore[return-value]


def drag_at(machine: Machine, spare: Callable[[ConventionalDrive], float]) -> float:
    """Drag at the load at which `spare` of Motor 2's drive passes zero. [N]"""
    from scipy.optimize import brentq

    large = _conventional(machine, _LARGE)
    return brentq(lambda drag: spare(replace(large, guideway=Guideway(friction=drag))), 0.0, 20.0, xtol=1e-3)  # type: ignore[return-value]


def _region_peak(machine: Machine, drive: ConventionalDrive) -> float:
    speed, force, _ = machine.comparison.study.requirement.sample(61)
    return float(np.nanmax(drive.operate(speed=speed, force=force).efficiency))


def _region_losses(machine: Machine, drive: ConventionalDrive) -> dict[str, float]:
    """Mean of each loss over the region. [W]"""
    speed, force, weight = machine.comparison.study.requirement.sample(61)
    point = drive.operate(speed=speed, force=force)
    return {name: float(np.sum(weight * loss)) for name, loss in point.losses.items()}


def c1(machine: Machine) -> Finding:
    """Coverage of Motor 1 on three ratios."""
    shares = [machine.comparison.results[name].coverage for name in _SMALL]
    why = (
        "Each ratio runs out of voltage at speed, of torque at force, or of both; the ratios are assumed, and chosen so "
        "that they do, but no single ratio gives Motor 1 both."
    )
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
    most = drag_at(machine, lambda drive: _spare(machine, drive))
    drag = _conventional(machine, _LARGE).guideway.friction
    why = (
        f"The tightest limit is {result.tightest.limit.words} with a margin of {result.tightest.value:.3f}; it holds up to "
        f"{most:.1f} N of drag at the load, of which {drag:.1f} N are assumed."
    )
    return Finding(f"{result.coverage:.0%}", yes(result.covers), why)


def c4(machine: Machine) -> Finding:
    """Smallest scale of Motor 1, on the shipped ratio and over all ratios."""
    ratios = np.linspace(3.5, 4.6, 111)
    scales = np.array([smallest_scale(machine, ratio) for ratio in ratios])
    best = int(np.argmin(scales))
    shipped = _conventional(machine, _LARGE).gearhead.ratio
    at_shipped = smallest_scale(machine, shipped)
    why = (
        f"On the reconstructed {shipped:g}:1 the smallest scale is {at_shipped:.2f}, which rounds to 2.7, but "
        f"{ratios[best]:.2f}:1 would need only {scales[best]:.2f}: the fourth ratio, which the paper does not print, decides."
    )
    return Finding(f"{at_shipped:.2f} at {shipped:g}:1, {scales[best]:.2f} at {ratios[best]:.2f}:1", "undecidable", why)


def c5(machine: Machine) -> Finding:
    """Peak efficiency of Motor 2's drive."""
    result = machine.comparison.results[_LARGE]
    large = _conventional(machine, _LARGE)
    free = replace(large, guideway=Guideway())
    peak = np.nanmax(free.operate(speed=result.map.speed[:, None], force=result.map.force[None, :]).efficiency)
    why = (
        f"{large.guideway.friction:g} N of drag at the load (assumed) cost the rest; without drag it would be {peak:.2f}, but "
        f"then {_region_peak(machine, free):.2f} inside the regime, and C6 would fail: here C5 and C6 exclude each other."
    )
    return Finding(result.peak_efficiency, about(result.peak_efficiency, 0.85, _READING), why)


def c6(machine: Machine) -> Finding:
    """Peak efficiency of Motor 2's drive in the region."""
    value = machine.comparison.results[_LARGE].peak_efficiency_in_region
    least = drag_at(machine, lambda drive: 0.65 - _region_peak(machine, drive))
    drag = _conventional(machine, _LARGE).guideway.friction
    why = (
        f"It holds from {least:.1f} N of drag at the load; {drag:g} N are assumed, and chosen so that it does (see C5)."
    )
    return Finding(value, yes(value <= 0.65), why)


def c7(machine: Machine) -> Finding:
    """Share of winding loss of Motor 2's drive over the region."""
    large = _conventional(machine, _LARGE)
    mean = _region_losses(machine, large)
    corner = machine.comparison.results[_LARGE].corners["maximum force"]

    def lead(drive: ConventionalDrive) -> float:
        losses = _region_losses(machine, drive)
        return losses["winding"] - losses["guideway"]

    why = (
        f"Winding heat is {corner.losses['winding'] / sum(corner.losses.values()):.0%} of the loss at maximum force, but on "
        f"average over the regime {mean['winding'] / sum(mean.values()):.0%}, hardly more than drag at the load "
        f"({mean['guideway'] / sum(mean.values()):.0%}, assumed), which leads from {drag_at(machine, lead):.1f} N."
    )
    share = mean["winding"] / sum(mean.values())
    return Finding(f"{share:.0%} of the loss", yes(max(mean, key=lambda name: mean[name]) == "winding"), why)


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
    rival = drives[_LARGE].operate(speed=speed, force=force).power_in
    share = {}
    for letter, name in _COBOTIC.items():
        better = drives[name].operate(speed=speed, force=force).power_in < rival
        share[letter] = float(weight[better].sum())
    why = (
        "Against Motor 2, the only conventional drive that covers; at light load a cylinder gear with constant friction "
        "torque (A) still pays for 14 rad/s, one that loses in proportion to power (B) hardly: that law decides."
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
    turns = 14.0 * 57.0 * 60.0 / (2.0 * np.pi)
    why = f"8040 rpm through 57:1 is {value:.2f} rad/s; 14 rad/s is {turns:.0f} rpm at the motor, so one of the three is rounded."
    return Finding(value, about(value, 14.0, 0.5), why)


CHECKS = {
    **{"C1": c1, "C2": c2, "C3": c3, "C4": c4, "C5": c5, "C6": c6, "C7": c7},
    **{"B1": b1, "B2": b2, "B3": b3, "B4": b4, "B5": b5},
}
