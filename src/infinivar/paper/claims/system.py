"""Checks of the claims about whole drives in steady operation (sections VI-A and VI-B)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from infinivar import power
from infinivar._core.fields import given
from infinivar.analysis.region import PEAK_REACH, best_efficiency, binding_at
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import Drive, DrivePoint
from infinivar.drivetrain.drive import needed as stated
from infinivar.limits import Limit
from infinivar.paper.claims.bench import MOVES, Bench, demands, with_drag
from infinivar.paper.claims.claim import (
    FACTOR,
    Checked,
    Found,
    PaperMachine,
    Range,
    Variant,
    either_way,
    near,
    row,
    yes,
)
from infinivar.paper.claims.element import best_point
from infinivar.parts.linear import Guideway
from infinivar.units import plain

_SMALL = ("motor1-gear1", "motor1-gear2", "motor1-gear3")
_LARGE = "motor2-gear4"
_COBOTIC = {"A": "cobotic", "B": "cobotic-b"}
_READING = 0.01
"""Tolerance of whole percents, some read off a plot: half a point for rounding and half a point for reading. [-]"""
_COBOTIC_VALUES = ("preload", "cylinder_radius", "link_drag")
"""Those of `MOVES` that affect the cobotic drive in steady operation."""


def _over_region(machine: PaperMachine, drive: Drive, count: int = 41) -> tuple[DrivePoint, np.ndarray]:
    """Operating points of a drive over the required region, and the share of the area that each represents."""
    speed, force, weight = machine.requirement.sample(count)
    return drive.operate(speed=speed, force=force), weight


def _spare(machine: PaperMachine, drive: Drive) -> float:
    """Smallest margin over the required region, less 1. [-]"""
    return float(np.min(_over_region(machine, drive)[0].margin)) - 1.0


def _coverage(machine: PaperMachine, drive: Drive) -> float:
    """Share of the required region within all limits. [-]"""
    point, weight = _over_region(machine, drive)
    return float(weight[np.asarray(point.limit) == Limit.OK].sum())


def _with_drag(drive: ConventionalDrive, drag: float) -> ConventionalDrive:
    return replace(drive, guideway=Guideway(friction=drag))


def _with_ratio(drive: ConventionalDrive, ratio: float) -> ConventionalDrive:
    return replace(drive, gearhead=replace(drive.gearhead, ratio=ratio))


def smallest_scale(machine: PaperMachine, ratio: float, drag: float | None = None) -> float:
    """Smallest scale of Motor 1 that covers the required region with a fixed ratio; inf if none does. [-]"""
    from scipy.optimize import brentq

    large, motor = machine.conventional(_LARGE), machine.conventional(_SMALL[0]).motor
    geared = _with_ratio(large if drag is None else _with_drag(large, drag), ratio)

    def spare(scale: float) -> float:
        return _spare(machine, replace(geared, motor=motor.scaled(scale)))

    return brentq(spare, 0.5, 50.0, xtol=1e-6) if spare(50.0) > 0 else np.inf  # type: ignore[return-value]


def drag_at(machine: PaperMachine, spare: Callable[[ConventionalDrive], float]) -> float:
    """Drag at the load at which `spare` of the Motor 2 drive crosses zero. [N]"""
    from scipy.optimize import brentq

    large = machine.conventional(_LARGE)
    return brentq(lambda drag: spare(_with_drag(large, drag)), 0.0, 20.0, xtol=1e-3)  # type: ignore[return-value]


def _region_peak(machine: PaperMachine, drive: ConventionalDrive) -> float:
    point, _ = _over_region(machine, drive, 61)
    return float(np.nanmax(power.efficiency(point.power_in, point.power_out)))


def _drags(machine: PaperMachine) -> tuple[float, float, float]:
    """Drag at the load of the Motor 2 drive: assumed, smallest at which C6 holds, largest at which C3 holds. [N]"""
    shipped = machine.conventional(_LARGE).guideway.friction
    least = drag_at(machine, lambda drive: 0.65 - _region_peak(machine, drive))
    most = drag_at(machine, lambda drive: _spare(machine, drive))
    return shipped, least, most


def _drag_range(machine: PaperMachine, low: float | None, high: float | None) -> Range:
    ends = (None if end is None else float(f"{end:.3g}") for end in (low, high))
    return Range(MOVES["drag"].words, "N", machine.conventional(_LARGE).guideway.friction, *ends)


def _cobotic_values(machine: PaperMachine, found: Callable[[CoboticDrive], Found]) -> Iterator[Variant]:
    """Findings with the cobotic drive's values varied by `FACTOR`, one at a time."""
    bench = Bench.of(machine)
    for parameter in _COBOTIC_VALUES:
        words = MOVES[parameter].words
        yield from either_way(words, lambda factor, one=parameter: found(bench.moved(one, factor).cobotic))


def c1(machine: PaperMachine) -> Checked:
    """Coverage of Motor 1 with three ratios."""
    threshold = "each below 100 %"

    def found(drives: list[ConventionalDrive], requested: PaperMachine = machine) -> Found:
        shares = [_coverage(requested, drive) for drive in drives]
        return Found(
            ", ".join(f"{share:.0%}" for share in shares),
            threshold,
            yes(all(_spare(requested, drive) < 0.0 for drive in drives)),
        )

    drives = [machine.conventional(name) for name in _SMALL]
    bare = [_with_drag(drive, 0.0) for drive in drives]
    ratios = np.geomspace(2.0, 30.0, 60)

    def best(drag: float | None) -> Found:
        geared = [_with_ratio(drives[0] if drag is None else _with_drag(drives[0], drag), ratio) for ratio in ratios]
        shares = [_coverage(machine, drive) for drive in geared]
        place = int(np.argmax(shares))
        return Found(f"at best {shares[place]:.0%}, at {ratios[place]:.1f}:1", threshold, yes(shares[place] < 1.0))

    limits = {
        ratio: {Limit(int(code)).words for code in np.unique(_over_region(machine, drive)[0].limit) if code != Limit.OK}
        for ratio, drive in ((drive.gearhead.ratio, drive) for drive in drives)
    }
    met = "; ".join(f"{' and '.join(sorted(words))} at {ratio:g}:1" for ratio, words in limits.items())
    any_ratio = best(None)

    def variants() -> list[Variant]:
        return [
            row("value", f"any ratio from {ratios[0]:g}:1 to {ratios[-1]:g}:1", any_ratio),
            row("value", "no drag at the load", found(bare)),
            row("value", "any ratio, without drag at the load", best(0.0)),
            *either_way(MOVES["drag"].words, lambda factor: found([with_drag(drive, factor) for drive in drives])),
            *demands(machine, lambda requested: found(drives, requested)),
        ]

    why = f"Limits exceeded: {met}. The ratios are assumed; over all ratios the coverage is {any_ratio.computed}."
    return Checked(found(drives), why, variants)


def c2(machine: PaperMachine) -> Checked:
    """Largest continuous power that Motor 1 delivers to the load."""
    required = machine.power

    def found(name: str | None = None, least: float = required) -> Found:
        maps = [machine.comparison.results[other].map for other in ([name] if name else _SMALL)]
        value = max(float(steady.power_out[steady.limit == Limit.OK].max()) for steady in maps)
        return Found(value, f"at least {plain(least, 3)} W", yes(value >= least))

    def variants() -> list[Variant]:
        return [
            *(row("value", f"with {machine.study.titles[name].split(', ')[-1]} only", found(name)) for name in _SMALL),
            *demands(machine, lambda requested: found(least=requested.power), "power"),
        ]

    value = found()
    why = (
        f"With its best ratio it delivers {value.computed:.1f} W to the load continuously. The paper prints no required power; "
        f"{plain(required, 3)} W were chosen below that, so this tests nothing."
    )
    return Checked(value, why, variants, by_construction=True)


def c3(machine: PaperMachine) -> Checked:
    """Coverage of Motor 2."""
    result = machine.comparison.results[_LARGE]
    drag, _, most = _drags(machine)
    large = machine.conventional(_LARGE)

    def found(drive: ConventionalDrive, requested: PaperMachine = machine) -> Found:
        return Found(f"{_coverage(requested, drive):.1%}", "100 %", yes(_spare(requested, drive) >= 0.0))

    def variants() -> list[Variant]:
        return [
            row("value", "no drag at the load", found(_with_drag(large, 0.0))),
            row("value", f"drag at the load x {FACTOR:g}", found(_with_drag(large, FACTOR * drag))),
            row("value", "ratio 3.8:1", found(_with_ratio(large, 3.8))),
            row("value", "ratio 4.2:1", found(_with_ratio(large, 4.2))),
            *demands(machine, lambda requested: found(large, requested)),
        ]

    tight = stated(result.tightest, "tightest")
    why = (
        "The paper prints neither ratio nor drag. They were chosen so that the drive covers the regime, with a margin of "
        f"{tight.value:.3f} ({tight.limit.words}). It would do so with up to {most:.1f} N of drag at the "
        f"load; {drag:.1f} N are assumed."
    )
    return Checked(found(large), why, variants, [_drag_range(machine, None, most)], by_construction=True)


def c4(machine: PaperMachine) -> Checked:
    """Smallest scale of Motor 1, with the shipped ratio and over all ratios."""
    from scipy.optimize import minimize_scalar

    least: Any = minimize_scalar(
        lambda ratio: smallest_scale(machine, ratio), bounds=(3.0, 4.6), method="bounded", options={"xatol": 5e-3}
    )
    shipped = machine.conventional(_LARGE).gearhead.ratio
    drag = machine.conventional(_LARGE).guideway.friction

    def found(scale: float) -> Found:
        return Found(float(scale), "rounds to 2.7", yes(abs(scale - 2.7) <= 0.05))

    at_shipped = smallest_scale(machine, shipped)

    def variants() -> list[Variant]:
        return [
            row("value", f"ratio {least.x:.2f}:1, the best", found(float(least.fun))),
            *(row("value", f"ratio {ratio:g}:1", found(smallest_scale(machine, ratio))) for ratio in (3.6, 3.8, 4.2)),
            *either_way("drag at the load", lambda factor: found(smallest_scale(machine, shipped, factor * drag))),
            *demands(machine, lambda requested: found(smallest_scale(requested, shipped))),
        ]

    why = (
        "The verdict depends on the fourth ratio, which the paper does not print: the smallest scale is "
        f"{at_shipped:.2f} with the reconstructed {shipped:g}:1, and {least.fun:.2f} with {least.x:.2f}:1."
    )
    value = f"{at_shipped:.2f} at {shipped:g}:1, {least.fun:.2f} at {least.x:.2f}:1"
    return Checked(found(at_shipped)._replace(computed=value), why, variants)


def c5(machine: PaperMachine) -> Checked:
    """Peak efficiency of the Motor 2 drive."""
    result = machine.comparison.results[_LARGE]
    large = machine.conventional(_LARGE)

    def found(value: float, tolerance: float = _READING) -> Found:
        return near(value, 0.85, tolerance)

    free = _with_drag(large, 0.0)
    bare, drag = _peak(machine, free), large.guideway.friction
    product = large.motor.peak_efficiency * given(large.gearhead.efficiency, 1.0)

    def variants() -> list[Variant]:
        return [
            row(
                "choice", "half a point of tolerance, for rounding alone", found(result.peak_efficiency, 0.5 * _READING)
            ),
            row("choice", "twice the tolerance", found(result.peak_efficiency, 2 * _READING)),
            row("value", "no drag at the load", found(bare)),
            *either_way("drag at the load", lambda factor: found(_peak(machine, with_drag(large, factor)))),
            row("definition", "motor and gear alone, each at its peak", found(product)),
        ]

    why = (
        f"The assumed drag of {drag:g} N at the load explains most of the difference. Without drag the peak would be "
        f"{bare:.2f}, but {_region_peak(machine, free):.2f} inside the regime, which contradicts C6. If motor and gear had their "
        f"peaks at the same point, they would reach {product:.3f}."
    )
    return Checked(found(result.peak_efficiency), why, variants)


def c6(machine: PaperMachine) -> Checked:
    """Peak efficiency of the Motor 2 drive in the required region."""
    large = machine.conventional(_LARGE)
    drag, least, most = _drags(machine)

    def found(drive: ConventionalDrive, requested: PaperMachine = machine) -> Found:
        value = _region_peak(requested, drive)
        return Found(value, "at most 0.65", yes(value <= 0.65))

    def variants() -> list[Variant]:
        return [
            row("value", "no drag at the load", found(_with_drag(large, 0.0))),
            *either_way("drag at the load", lambda factor: found(with_drag(large, factor))),
            *demands(machine, lambda requested: found(large, requested)),
        ]

    why = (
        f"The paper does not print the drag at the load; {drag:g} N were chosen to satisfy this claim. It holds from "
        f"{least:.1f} N and C3 up to {most:.1f} N, which leaves little room."
    )
    return Checked(found(large), why, variants, [_drag_range(machine, least, None)], by_construction=True)


def c7(machine: PaperMachine) -> Checked:
    """Share of winding loss in the Motor 2 drive over the required region."""
    large = machine.conventional(_LARGE)
    drag, least, most = _drags(machine)

    def losses(
        drive: ConventionalDrive, requested: PaperMachine = machine
    ) -> tuple[dict[str, np.ndarray], np.ndarray, np.ndarray]:
        point, weight = _over_region(requested, drive, 61)
        return {name: np.asarray(loss) for name, loss in point.losses.items()}, np.asarray(point.power_in), weight

    def means(drive: ConventionalDrive, requested: PaperMachine = machine) -> dict[str, float]:
        parts, _, weight = losses(drive, requested)
        return {name: float(np.sum(weight * loss)) for name, loss in parts.items()}

    def largest(drive: ConventionalDrive, requested: PaperMachine = machine) -> Found:
        mean = means(drive, requested)
        other = max((name for name in mean if name != "winding"), key=lambda name: mean[name])
        total = sum(mean.values())
        words = f"{mean['winding'] / total:.1%} of the loss, {other} {mean[other] / total:.1%}"
        return Found(words, "more than any other loss", yes(mean["winding"] > mean[other]))

    def share(threshold: float, of: str = "loss") -> Found:
        parts, power_in, weight = losses(large)
        whole = sum(parts.values()) if of == "loss" else power_in
        value = float(np.sum(weight * parts["winding"]) / np.sum(weight * whole))
        words = f"{value:.1%} of the {'loss' if of == 'loss' else 'power drawn'}"
        return Found(words, f"at least {threshold:.0%}", yes(value >= threshold))

    def lead(drive: ConventionalDrive) -> float:
        mean = means(drive)
        return mean["winding"] - mean["guideway"]

    corner = machine.comparison.results[_LARGE].corners["maximum force"]
    crossing = drag_at(machine, lead)

    def variants() -> list[Variant]:
        return [
            row("choice", '"much": at least a quarter of the loss', share(0.25)),
            row("choice", '"much": at least half of the loss', share(0.5)),
            row("choice", '"much": at least a quarter of the power drawn', share(0.25, "power")),
            row(
                "value",
                f"drag at the load {least:.2f} N, the smallest at which C6 holds",
                largest(_with_drag(large, least)),
            ),
            row(
                "value",
                f"drag at the load {most:.2f} N, the largest at which C3 holds",
                largest(_with_drag(large, most)),
            ),
            *demands(machine, lambda requested: largest(large, requested)),
        ]

    mean = means(large)
    parts = {name: mean[name] / sum(mean.values()) for name in ("winding", "guideway")}
    why = (
        f"Winding loss is {corner.losses['winding'] / sum(corner.losses.values()):.0%} of the total at maximum force. Averaged "
        f"over the regime it is {parts['winding']:.1%}, and drag at the load {parts['guideway']:.1%}. The drag ({drag:g} N) is "
        f'assumed; above {crossing:.1f} N it would be the larger of the two. The paper does not define "much".'
    )
    return Checked(largest(large), why, variants, [_drag_range(machine, None, crossing)])


def b1(machine: PaperMachine) -> Checked:
    """Coverage of the cobotic drive."""

    def found(drive: CoboticDrive, requested: PaperMachine = machine) -> Found:
        point, _ = _over_region(requested, drive)
        margin = np.asarray(point.margin)
        worst = int(np.argmin(margin))
        words = f"{_coverage(requested, drive):.1%}, margin {margin[worst]:.2f} ({binding_at(point.utilisation, worst).words})"
        return Found(words, "100 %", yes(margin[worst] >= 1.0))

    _, force, _ = machine.requirement.sample(41)
    point, _ = _over_region(machine, machine.drive)
    torque, voltage = (float(np.nanmax(point.utilisation[limit])) for limit in (Limit.THERMAL, Limit.VOLTAGE))
    slip = machine.element.slip_force

    def variants() -> list[Variant]:
        return [
            row("value", "reconstruction B", found(machine.cobotic("cobotic-b"))),
            *_cobotic_values(machine, found),
            *demands(machine, lambda requested: found(machine.drive, requested)),
        ]

    why = (
        f"The paper does not print the preload. It was chosen so that the wheel slips at {slip:.0f} N, above the "
        f"{np.max(force):.0f} N required. Only the motor remains to be tested: it needs at most {torque:.0%} of its continuous "
        f"torque and {voltage:.0%} of the supply voltage."
    )
    return Checked(found(machine.drive), why, variants, by_construction=True)


def _peak(machine: PaperMachine, drive: Drive) -> float:
    """Peak efficiency within limits, inside the required region and far beyond it."""
    requirement = machine.requirement
    return best_efficiency(drive, requirement.speed, requirement.force, (1.0,), "peak efficiency")[0]


def b2(machine: PaperMachine) -> Checked:
    """Peak efficiency of the cobotic drive."""

    def found(value: float) -> Found:
        return Found(value, "below 0.75", yes(value < 0.75))

    a, b = (machine.comparison.results[name] for name in _COBOTIC.values())
    drive = machine.drive
    stages = drive.motor.peak_efficiency * given(drive.gearhead.efficiency, 1.0)
    own = best_point(machine.element)[0]
    free = [replace(machine.cobotic(name), guideway=Guideway()) for name in _COBOTIC.values()]

    def variants() -> list[Variant]:
        return [
            row("value", "reconstruction B", found(b.peak_efficiency)),
            row("definition", "inside the required region only", found(a.peak_efficiency_in_region)),
            *(
                row("value", f"no drag of the link, reconstruction {letter}", found(_peak(machine, bare)))
                for letter, bare in zip(_COBOTIC, free, strict=True)
            ),
            *_cobotic_values(machine, lambda moved: found(_peak(machine, moved))),
        ]

    why = (
        f"A reaches {a.peak_efficiency:.3f}; B, whose gear loss is proportional to power, reaches {b.peak_efficiency:.3f}. The "
        "three printed efficiencies were built into the machine, and stages in series cannot exceed the product of their peaks: "
        f"{stages * 0.98:.3f} with the printed 98 %, {stages * own:.3f} with the {own:.1%} of its element. So this tests nothing "
        "but that motor, gear and element do not have their peaks at the same point."
    )
    return Checked(found(a.peak_efficiency), why, variants, by_construction=True)


def b3(machine: PaperMachine) -> Checked:
    """Share of the required region in which the cobotic drive draws less power than the Motor 2 drive."""
    large = machine.conventional(_LARGE)

    def found(
        drive: CoboticDrive, rival: ConventionalDrive = large, least: float = 1.0, requested: PaperMachine = machine
    ) -> Found:
        speed, force, weight = requested.requirement.sample(121)
        ours, theirs = (other.operate(speed=speed, force=force).power_in for other in (drive, rival))
        share = float(weight[np.asarray(ours < theirs)].sum())
        return Found(f"{share:.0%} of the region", f"at least {least:.0%}", yes(share >= least))

    a, b = (machine.cobotic(name) for name in _COBOTIC.values())
    both = {letter: found(drive) for letter, drive in (("A", a), ("B", b))}

    def variants() -> list[Variant]:
        return [
            row("choice", '"any" as in 90 % of the region', found(a, least=0.9)),
            row("value", "reconstruction B", both["B"]),
            row("value", "reconstruction B, in 90 % of the region", found(b, least=0.9)),
            *either_way(f"reconstruction A, {MOVES['drag'].words}", lambda factor: found(a, with_drag(large, factor))),
            *either_way(f"reconstruction B, {MOVES['drag'].words}", lambda factor: found(b, with_drag(large, factor))),
            *_cobotic_values(machine, found),
            *demands(machine, lambda requested: found(a, requested=requested)),
        ]

    idle = {letter: float(drive.operate(speed=1e-9, force=0.0).power_in) for letter, drive in (("A", a), ("B", b))}
    words = f"{both['A'].computed} (A), {both['B'].computed} (B)"
    why = (
        "Compared with Motor 2, the only conventional drive that covers the regime. Idling at 14 rad/s costs A, whose cylinder "
        f"gear has a constant friction torque, {idle['A']:.1f} W, and B, whose gear loss is proportional to power, "
        f"{idle['B']:.1f} W. This loss law makes the difference at light load."
    )
    return Checked(both["A"]._replace(computed=words), why, variants)


def b4(machine: PaperMachine) -> Checked:
    """Limits that bound the operating range of the cobotic drive."""

    def found(drive: CoboticDrive, farthest: float = PEAK_REACH, requested: PaperMachine = machine) -> Found:
        requirement = requested.requirement
        reach = np.geomspace(1e-2, farthest, 150)
        point = drive.operate(speed=(reach * requirement.speed)[:, None], force=(reach * requirement.force)[None, :])
        met = {Limit(int(code)) for code in np.unique(point.limit)} - {Limit.OK}
        words = " and ".join(limit.words for limit in sorted(met))
        bounded = {Limit.SLIP, Limit.THERMAL}
        return Found(words or "none", "slip and motor torque only", yes(met == bounded))

    drive = machine.drive
    motor = drive.motor
    turning = abs(drive.cylinder_speed) * drive.gearhead.ratio
    needed = motor.operate(torque=motor.continuous_torque, speed=turning).voltage

    def variants() -> list[Variant]:
        return [
            row("value", "reconstruction B", found(machine.cobotic("cobotic-b"))),
            row("choice", "within 3 times the required force and speed", found(drive, 3.0)),
            row("choice", "within 100 times the required force and speed", found(drive, 100.0)),
            *_cobotic_values(machine, found),
            *demands(machine, lambda requested: found(drive, requested=requested)),
        ]

    why = (
        f"With the cylinder at {abs(drive.cylinder_speed):g} rad/s the motor turns at {turning:.0f} rad/s. Its continuous torque "
        f"there needs {float(needed):.1f} V of {motor.voltage:g} V, so the torque limit is reached before the voltage limit."
    )
    return Checked(found(drive), why, variants)


def b5(machine: PaperMachine) -> Checked:
    """Cylinder speed at 8040 rpm through 57:1."""

    def found(rpm: float, ratio: float) -> Found:
        return near(rpm * 2.0 * np.pi / 60.0 / ratio, 14.0, 0.5)

    def variants() -> list[Variant]:
        return [
            row("value", "8035 rpm, which rounds to 8040", found(8035.0, 57.0)),
            row("value", "57.5:1, which may be printed as 57", found(8040.0, 57.5)),
            row("value", "both", found(8035.0, 57.5)),
        ]

    value = found(8040.0, 57.0)
    turns = 14.0 * 57.0 * 60.0 / (2.0 * np.pi)
    why = (
        f"8040 rpm through 57:1 gives {value.computed:.2f} rad/s, and 14 rad/s corresponds to {turns:.0f} rpm at the motor. "
        "Rounding of the printed digits does not explain the difference."
    )
    return Checked(value, why, variants)


CHECKS = {
    **{"C1": c1, "C2": c2, "C3": c3, "C4": c4, "C5": c5, "C6": c6, "C7": c7},
    **{"B1": b1, "B2": b2, "B3": b3, "B4": b4, "B5": b5},
}
