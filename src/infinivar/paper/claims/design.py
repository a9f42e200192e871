"""Checks of the design changes that the paper recommends (section VII), on the geometry of the reconstruction."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from infinivar.analysis.cycles.shaking import dynamic_map
from infinivar.analysis.design_trends import Duty, elasticities, with_friction
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.drive import motor_side, needed
from infinivar.paper.claims.bench import Bench
from infinivar.paper.claims.claim import Checked, Found, PaperMachine, Variant, row, yes
from infinivar.paper.claims.element import with_bearing
from infinivar.paper.claims.planes import PLANES
from infinivar.parts.bearing import SIZE_POWERS

_NAMES = {
    "friction": "friction coefficient at constant slip force",
    "wheel_radius": "wheel radius",
    "axle_bore": "size of the axle bearings",
    "preload": "preload",
    "hysteresis_factor": "hysteresis loss factor",
    "youngs_modulus": "elastic modulus",
    "crown_radius": "crown radius",
}
_Place = tuple[float, float]
"""Working point of an element: share of the slip force, and ratio."""
_Found = Callable[[CoboticDrive, _Place], Found]

_SHIPPED: _Place = (0.5, 8.0)
"""Working point of the paper's element."""
_ELSEWHERE = ((0.15, 8.0), (0.9, 8.0), (0.5, 50.0))
_LIGHTER = 0.99
_SLOWEST = 1.0
"""Lowest frequency at which the power drawn while shaking is compared. [Hz]"""
_RUN_UP_TIME = 1.5
"""Run-up time of the cylinder, as in the shipped scenario. [s]"""
_RUN_UPS = 60.0
"""Time between two run-ups. [s]"""


@functools.lru_cache(maxsize=256)
def _slopes(drive: CoboticDrive, parameter: str, place: _Place = _SHIPPED) -> dict[str, float]:
    """Change of each loss in percent per percent of a parameter, at a share of the slip force and a ratio."""
    load, ratio = place
    element = drive.transmission
    duty = Duty(cylinder_speed=drive.cylinder_speed, link_force=load * element.slip_force, ratio=ratio)
    return elasticities(element, parameter, duty)


def _with_bearings(drive: CoboticDrive, model: str) -> CoboticDrive:
    return replace(drive, transmission=with_bearing(drive.transmission, friction_model=model))


@dataclass(frozen=True, slots=True)
class _AtPlace:
    """A claim about the element at one working point; calling it with a machine returns the finding.

    Attributes
    ----------
    found      Check of one drive at a working point.
    why        Explanation of the verdict, from the numbers of the machine.
    variants   Findings elsewhere and with other choices.
    """

    found: _Found
    why: Callable[[PaperMachine], str]
    variants: Callable[[PaperMachine, _Found], Iterator[Variant]]

    def __call__(self, machine: PaperMachine) -> Checked:
        """Check the working point of the paper's element."""
        shown = self.found(machine.drive, _SHIPPED)
        return Checked(shown, lambda: self.why(machine), self.variants(machine, self.found))


def _elsewhere(machine: PaperMachine, found: _Found) -> Iterator[Variant]:
    """Findings at other operating points, for the other reconstruction, and with the other bearing model."""
    drive = machine.drive
    for load, ratio in _ELSEWHERE:
        yield row("choice", f"at {load:.0%} of the slip force and {ratio:g}:1", found(drive, (load, ratio)))
    yield row("value", "reconstruction B", found(machine.cobotic("cobotic-b"), _SHIPPED))
    skf = _with_bearings(drive, "skf")
    yield row("definition", "SKF's later friction model of the bearings", found(skf, _SHIPPED))


def _by_hysteresis(drive: CoboticDrive, place: _Place) -> Found:
    """S1: effect of the hysteresis loss factor."""
    slope = _slopes(drive, "hysteresis_factor", place)["total"]
    return Found(slope, "above 0 % of the loss per percent", yes(slope > 0))


def _why_hysteresis(machine: PaperMachine) -> str:
    groups = machine.element.groups(machine.cylinder_speed)
    bearing = float(groups.bearing_torque / (groups.bearing_torque + groups.rolling_torque))
    slope = _slopes(machine.drive, "hysteresis_factor")["total"]
    return (
        f"Lowering it by 1 % lowers the loss of the element at 8:1 by {slope:.2f} %: the axle bearings cause "
        f"{bearing:.0%} of the rolling loss, hysteresis the rest."
    )


def _turning(drive: CoboticDrive) -> dict[str, float]:
    """Change in percent of each friction torque on the bell per percent of mu, at constant slip force."""
    assert drive.steering is not None
    before = drive.steering.friction_torques(drive.transmission)
    after = drive.steering.friction_torques(with_friction(drive.transmission, 1.01 * drive.transmission.friction))
    return {name: 100.0 * (float(after[name] / before[name]) - 1.0) for name in before}


def _by_friction(drive: CoboticDrive, place: _Place) -> Found:
    """S2: effect of the friction coefficient, with the preload adjusted to keep the slip force."""
    slopes, steering = _slopes(drive, "friction", place), _turning(drive)
    falls = [slopes["rolling"], slopes["bearing"], *steering.values()]
    verdict = yes(max(falls) < 0 < slopes["creep"])
    return Found(slopes["total"], "creep above 0 % per percent, all others below", verdict)


def _why_friction(machine: PaperMachine) -> str:
    slopes, steering = _slopes(machine.drive, "friction"), _turning(machine.drive)
    return (
        f"Raising mu by 1 % changes the loss at 8:1 by {slopes['total']:+.2f} %: hysteresis {slopes['rolling']:+.2f} %, "
        f"bearings {slopes['bearing']:+.2f} %, creep {slopes['creep']:+.2f} %. The torque to turn the contact patch changes by "
        f"{steering['patch']:+.2f} %, the torque of the bell bearing by {steering['bell']:+.2f} %. The guideway friction due to "
        "the preload falls with the preload."
    )


def _by_modulus(drive: CoboticDrive, place: _Place) -> Found:
    """S3: effect of the elastic modulus of both bodies."""
    slope = _slopes(drive, "youngs_modulus", place)["creep"]
    return Found(slope, "below 0 % of the creep loss per percent", yes(slope < 0))


def _why_modulus(machine: PaperMachine) -> str:
    slopes = _slopes(machine.drive, "youngs_modulus")
    return (
        f"Raising the modulus by 1 % lowers the creep loss by only {-slopes['creep']:.2f} %, because a stiffer contact patch is "
        f"also smaller. The smaller patch lowers the hysteresis loss by {-slopes['rolling']:.2f} %."
    )


def _bell_slope(drive: CoboticDrive, model: str) -> float:
    """Change in percent of the bell bearing's starting torque per percent of its size, by a friction model."""
    assert drive.steering is not None
    bearing = needed(drive.steering.bell_bearing, "steering.bell_bearing")
    step = 0.01
    sizes = {name: getattr(bearing, name) * (1.0 + step) ** power for name, power in SIZE_POWERS.items()}
    before, after = (
        float(replace(bearing, friction_model=model, **size).starting_moment(0.0, drive.transmission.preload))
        for size in ({}, sizes)
    )
    return (after / before - 1.0) / step


def s4(machine: PaperMachine) -> Checked:
    """Effect of the size of the bearings, by both friction models."""

    def found(drive: CoboticDrive, place: _Place = _SHIPPED) -> Found:
        slope = _slopes(drive, "axle_bore", place)["bearing"]
        return Found(slope, "above 0 % of the bearing loss per percent", yes(slope > 0))

    def bell(model: str) -> Found:
        slope = _bell_slope(machine.drive, model)
        return Found(slope, "above 0 % of the bell bearing's torque per percent", yes(slope > 0))

    simple = _slopes(machine.drive, "axle_bore")["bearing"]
    skf = _slopes(_with_bearings(machine.drive, "skf"), "axle_bore")["bearing"]
    bells = {"a constant coefficient of friction": bell("coefficient"), "SKF's later friction model": bell("skf")}

    def variants() -> list[Variant]:
        return [
            *_elsewhere(machine, found),
            *(row("definition", f"bell bearing with {words}", tried) for words, tried in bells.items()),
        ]

    by_model = " and ".join(f"{tried.computed:+.2f} %" for tried in bells.values())
    why = (
        f"With a constant coefficient of friction, axle bearings 1 % larger change their loss by {simple:+.2f} %. With SKF's "
        f"later model, at the same load, they change it by {skf:+.2f} %: the sliding torque falls with size and only the rolling "
        f"torque rises. A bell bearing 1 % larger changes its torque by {by_model} in the two models."
    )
    value = f"{simple:+.2f} and {skf:+.2f} % per percent of size"
    return Checked(found(machine.drive)._replace(computed=value), why, variants)


def run_up_energy(drive: CoboticDrive, time: float = _RUN_UP_TIME) -> float:
    """Energy from the supply to run the cylinder up at constant acceleration with the link at rest. [J]"""
    steps = 200
    share = (np.arange(steps) + 0.5) / steps
    speed, acceleration = share * drive.cylinder_speed, drive.cylinder_speed / time
    element = drive.transmission.deliver(cylinder_speed=speed, link_speed=0.0, link_force=0.0)
    torque = element.torque + needed(drive.cylinder_inertia, "cylinder_inertia") * acceleration
    side = motor_side(
        drive.motor, drive.gearhead, output_torque=torque, output_speed=speed, output_acceleration=acceleration
    )
    power_in, _, _ = drive.amplifier.supply(side.power)
    return float(np.mean(power_in)) * time


@functools.lru_cache(maxsize=64)
def _shaken(bench: Bench, drive: CoboticDrive, cylinder: str) -> tuple[np.ndarray, np.ndarray]:
    """Power from the supply over part of the coarse plane [W], and where the drive works."""
    plane = PLANES["coarse", "linear"]
    found = dynamic_map(
        drive,
        plane.frequency[plane.frequency >= _SLOWEST],
        plane.fraction,
        power=bench.power,
        load_mass=bench.load_mass,
        samples=plane.samples,
        cylinder=cylinder,  # type: ignore[arg-type]
    )
    return found.power_in, found.works


def s5(machine: PaperMachine) -> Checked:
    """Effect of a 1 % lighter bell, link or cylinder on the power drawn while shaking a mass."""

    def mean_change(bench: Bench, drive: CoboticDrive, cylinder: str = "constant") -> float:
        """Mean change in percent of the power from the supply, where the drive works before and after."""
        (before, works), (after, still) = (_shaken(bench, one, cylinder) for one in (bench.cobotic, drive))
        both = works & still
        return 100.0 * float(np.mean((after / before - 1.0)[both])) if both.any() else float("nan")

    def lighter(drive: CoboticDrive) -> CoboticDrive:
        return replace(drive, cylinder_inertia=_LIGHTER * needed(drive.cylinder_inertia, "cylinder_inertia"))

    def of_run_ups(bench: Bench) -> float:
        """Change in percent of the mean power from the supply if the cylinder runs up periodically."""
        power_in, works = _shaken(bench, bench.cobotic, "constant")
        saved = run_up_energy(lighter(bench.cobotic)) - run_up_energy(bench.cobotic)
        return 100.0 * saved / _RUN_UPS / float(np.mean(power_in[works]))

    def found(name: str, case: str) -> Found:
        bench = Bench.of(machine, name)
        saved = {
            words: mean_change(bench, bench.moved(parameter, _LIGHTER).cobotic)
            for words, parameter in (("bell and steering motor", "steering_inertia"), ("link", "link_mass"))
        }
        saved["cylinder"] = {
            "constant": lambda: mean_change(bench, lighter(bench.cobotic)),
            "run-up": lambda: of_run_ups(bench),
            "flywheel": lambda: mean_change(bench, lighter(bench.cobotic), "flywheel"),
        }[case]()
        words = ", ".join(f"{part} {change:+.2g} %" for part, change in saved.items())
        return Found(words, "each below 0 % per percent lighter", yes(all(change < 0 for change in saved.values())))

    cases = {
        "constant": "cylinder at constant speed",
        "run-up": f"one run-up of the cylinder every {_RUN_UPS:g} s",
        "flywheel": "cylinder as a flywheel",
    }

    def variants() -> list[Variant]:
        return [
            row("value" if name == "cobotic-b" else "definition", f"{cases[case]}{letter}", found(name, case))
            for name, letter in (("cobotic", ""), ("cobotic-b", ", reconstruction B"))
            for case in cases
            if (name, case) != ("cobotic", "constant")
        ]

    benches = {name: Bench.of(machine, name) for name in ("cobotic", "cobotic-b")}
    flown = {name: mean_change(bench, lighter(bench.cobotic), "flywheel") for name, bench in benches.items()}
    drive = machine.drive
    inertia = needed(drive.cylinder_inertia, "cylinder_inertia")
    stored = 0.5 * inertia * drive.cylinder_speed**2
    whole = run_up_energy(drive)
    saved = whole - run_up_energy(lighter(drive))
    why = (
        "The computed values are changes in the power from the supply for 1 % less inertia or mass, averaged from "
        f"{_SLOWEST:g} to 30 Hz within limits. At constant speed, as in the paper, the inertia of the cylinder costs nothing. A "
        f"run-up in {_RUN_UP_TIME:g} s needs {whole:.2f} J, of which the cylinder stores {stored:.2f} J. A cylinder 1 % lighter "
        f"saves {1000 * saved:.1f} mJ, or {1e6 * saved / _RUN_UPS:.0f} microwatts with one run-up every {_RUN_UPS:g} s. If the "
        f"cylinder stores braking energy as a flywheel, lowering its inertia by 1 % changes the power by "
        f"{flown['cobotic']:+.1g} % (A) and {flown['cobotic-b']:+.1g} % (B)."
    )
    return Checked(found("cobotic", "constant"), why, variants)


def _ranked(drive: CoboticDrive, place: _Place) -> Found:
    """S6: parameters by their effect on the loss."""
    slopes = {name: _slopes(drive, name, place)["total"] for name in _NAMES}
    ranked = sorted(slopes, key=lambda name: -abs(slopes[name]))
    words = ", ".join(f"{_NAMES[name]} {slopes[name]:+.2f}" for name in ranked)
    return Found(words, "none: the paper prints no ranking", "undecidable")


def _why_ranked(machine: PaperMachine) -> str:
    return (
        "The computed values are changes in percent of the element's loss per percent of the parameter, at half the slip force "
        "and 8:1, with a constant coefficient of friction in the bearings. The paper refers to a ranking but does not print it."
    )


def _ranked_otherwise(machine: PaperMachine, found: _Found) -> Iterator[Variant]:
    """Rankings at another load, and with the other bearing model."""
    yield row("choice", "at 15 % of the slip force and 8:1", found(machine.drive, (0.15, 8.0)))
    skf = _with_bearings(machine.drive, "skf")
    yield row("definition", "SKF's later friction model of the bearings", found(skf, _SHIPPED))


CHECKS: Mapping[str, Callable[[PaperMachine], Checked]] = {
    "S1": _AtPlace(_by_hysteresis, _why_hysteresis, _elsewhere),
    "S2": _AtPlace(_by_friction, _why_friction, _elsewhere),
    "S3": _AtPlace(_by_modulus, _why_modulus, _elsewhere),
    "S4": s4,
    "S5": s5,
    "S6": _AtPlace(_ranked, _why_ranked, _ranked_otherwise),
}
