"""Checks of the claims about shaking a mass (section VI-C and Fig 17), and how far they depend on what the paper leaves open."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from infinivar.analysis.claims.claim import Finding, Machine, Range, Variant, Verdict, yes
from infinivar.analysis.cycle import PAPER, Definition
from infinivar.analysis.dynamic import DynamicMap, dynamic_map
from infinivar.drivetrain.cobotic import CoboticDrive, SteeringPlant
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import needed
from infinivar.frozen import FrozenDict
from infinivar.limits import words_of
from infinivar.parts.linear import Guideway

_FREQUENCY, _FRACTION = np.geomspace(0.1, 30.0, 24), (np.arange(16) + 0.5) / 16
"""A coarser plane for all but the shipped machine."""
_COARSE_SAMPLES = 80
_READING = 0.02
"""Of a level in Fig 17. [-]"""
_SIMILAR = 1.25
"""Performances within this factor count as similar."""
FARTHEST = 30.0
"""Parameters are moved by up to this factor, either way."""

DEFINITIONS: Mapping[str, Definition] = FrozenDict(
    {
        "braking energy stored at 80 %": Definition(returned="store", storage_efficiency=0.8),
        "no negative electrical power": Definition(returned="none"),
        "one DC bus": Definition(common_bus=True),
        "round trip, burnt": Definition(measure="round trip"),
        "round trip, stored at 80 %": Definition(measure="round trip", returned="store", storage_efficiency=0.8),
        "printed integral": Definition(measure="printed"),
        "continuous torque bounds the peak": Definition(torque="peak"),
    }
)
"""Other readings of "performance" than the paper's."""


class Pair(NamedTuple):
    """Maps of the two drives that Fig 17 compares."""

    cobotic: DynamicMap
    conventional: DynamicMap

    @property
    def below(self) -> np.ndarray:
        """Cells below 10 Hz and above 10 % of the maximum power, where one drive at least works."""
        plane = (self.cobotic.frequency < 10.0)[:, None] & (self.cobotic.fraction > 0.1)[None, :]
        return plane & (self.cobotic.works | self.conventional.works)


Found = tuple[float | str | None, Verdict]
Check = Callable[[Pair], Found]


def _share(of: np.ndarray, where: np.ndarray) -> float:
    return float(np.mean(of[where])) if where.any() else float("nan")


def better(pair: Pair) -> Found:
    """D1: share of the region in which the cobotic drive works and does better, or works alone."""
    ours, theirs = pair.cobotic, pair.conventional
    ahead = ours.works & (~theirs.works | (ours.performance > theirs.performance))
    share = _share(ahead, pair.below)
    return f"in {share:.1%} of the region", yes(share >= 0.999)


def similar(pair: Pair) -> Found:
    """D2: ratio of the performances from 1 to 10 Hz where both work."""
    ours, theirs = pair.cobotic, pair.conventional
    band = ((ours.frequency >= 1.0) & (ours.frequency <= 10.0))[:, None] & ours.works & theirs.works
    if not band.any():
        return "no cell where both work", "undecidable"
    middle = float(np.nanmedian((ours.performance / theirs.performance)[band]))
    return f"{middle:.2f} times as much (median)", yes(1 / _SIMILAR <= middle <= _SIMILAR)


def highest(pair: Pair) -> Found:
    """D3: largest performance of the cobotic drive within limits."""
    value = float(np.nanmax(pair.cobotic.performance, initial=0.0))
    return value, yes(abs(value - 0.85) <= _READING)


def corners(pair: Pair) -> Found:
    """D4: who works in the upper corners, above 80 % of the power in the first and last tenth of the frequencies."""
    count = pair.cobotic.frequency.size
    high = pair.cobotic.fraction > 0.8
    left, right = slice(0, count // 10), slice(count - count // 10, count)
    ours, theirs = pair.cobotic.works[:, high], pair.conventional.works[:, high]
    shares = [float(np.mean(works[side])) for side in (left, right) for works in (ours, theirs)]
    words = "left {:.0%} and {:.0%}, right {:.0%} and {:.0%} of the cells (cobotic and conventional)".format(*shares)
    return words, yes(shares[0] > 0.5 and max(shares[1:]) == 0.0)


def _loss_share(steady: DynamicMap, part: Callable[[str], bool], where: np.ndarray) -> float:
    """Mean share of some parts in what a drive loses; the load's energy that its amplifier burns is not the drive's."""
    losses = {name: loss for name, loss in steady.losses.items() if name != "amplifier"}
    total = sum(losses.values())
    asked = sum(loss for name, loss in losses.items() if part(name))
    return _share(np.asarray(asked / total), where)


def _most(steady: DynamicMap, part: Callable[[str], bool], region: np.ndarray) -> Found:
    """Whether some parts take most of what a drive loses where it works in a region."""
    where = region & steady.works
    if not where.any():
        return "works nowhere", "undecidable"
    share = _loss_share(steady, part, where)
    return f"{share:.0%} of its loss on average", yes(share > 0.5)


def to_steering(pair: Pair) -> Found:
    """D5: share of the cobotic drive's loss in its steering plant, where it works in the region."""
    return _most(pair.cobotic, lambda name: name.startswith("steering"), pair.below)


def to_resistance(pair: Pair) -> Found:
    """D6: share of the conventional drive's loss in its winding, where it works in the region."""
    return _most(pair.conventional, lambda name: name == "winding", pair.below)


def trends(pair: Pair) -> Found:
    """D7: share of cells from which performance rises with power, and of those above 10 Hz from which it falls."""
    rising, falling = [], []
    for steady in pair:
        up, along = np.diff(steady.performance, axis=1), np.diff(steady.unlimited, axis=0)
        fast = np.broadcast_to((steady.frequency[:-1] >= 10.0)[:, None], along.shape)
        rising.append(_share(up > 0, np.isfinite(up)))
        falling.append(_share(along < 0, np.isfinite(along) & fast))
    if not np.all(np.isfinite(rising + falling)):
        return "one of them works nowhere", "undecidable"
    words = "rises in {:.0%} and {:.0%}, falls in {:.0%} and {:.0%} of the cells".format(*rising, *falling)
    return f"{words} (cobotic and conventional)", yes(min(rising + falling) >= 0.95)


@functools.lru_cache(maxsize=256)
def _coarse_map(
    drive: CoboticDrive | ConventionalDrive, power: float, load_mass: float, definition: Definition
) -> DynamicMap:
    """Map on the coarser plane; the claims ask for the same ones again and again."""
    return dynamic_map(
        drive,
        _FREQUENCY,
        _FRACTION,
        power=power,
        load_mass=load_mass,
        definition=definition,
        samples=_COARSE_SAMPLES,
    )


class Bench(NamedTuple):
    """A cobotic and a conventional drive, and a mass to shake."""

    cobotic: CoboticDrive
    conventional: ConventionalDrive
    power: float
    load_mass: float

    @classmethod
    def of(cls, machine: Machine, name: str = "cobotic") -> Bench:
        """One of the machine's cobotic drives and Motor 2's."""
        cobotic, conventional = machine.moving(name), machine.moving("motor2-gear4")
        assert isinstance(cobotic, CoboticDrive)
        assert isinstance(conventional, ConventionalDrive)
        return cls(cobotic, conventional, machine.power, machine.load_mass)

    def moved(self, parameter: str, factor: float) -> Bench:
        """The same with a parameter so many times as large."""
        cobotic, conventional = MOVES[parameter].move(self.cobotic, self.conventional, factor)
        return self._replace(cobotic=cobotic, conventional=conventional)

    def pair(self, definition: Definition = PAPER) -> Pair:
        """Maps on the coarser plane."""
        cobotic, conventional = (
            _coarse_map(drive, self.power, self.load_mass, definition) for drive in (self.cobotic, self.conventional)
        )
        return Pair(cobotic, conventional)

    def variants(self, check: Check, other: Bench) -> tuple[Variant, ...]:
        """What a check finds with the other reconstruction, and by other definitions."""
        return (
            Variant("reconstruction B", *check(other.pair())),
            *(Variant(words, *check(self.pair(definition))) for words, definition in DEFINITIONS.items()),
        )

    def ranges(self, check: Check) -> tuple[Range, ...]:
        """How far each parameter may move before a check's verdict changes."""
        verdict = check(self.pair())[1]

        def edge(parameter: str, direction: int) -> float | None:
            """Factor at which the verdict changes, by halving the way there in its logarithm; None if it does not."""
            inside, outside = 0.0, float(np.log(FARTHEST))
            if check(self.moved(parameter, FARTHEST**direction).pair())[1] == verdict:
                return None
            for _ in range(7):
                middle = 0.5 * (inside + outside)
                same = check(self.moved(parameter, float(np.exp(direction * middle))).pair())[1] == verdict
                inside, outside = (middle, outside) if same else (inside, middle)
            return float(np.exp(direction * inside))

        found = []
        for parameter, move in MOVES.items():
            shipped = move.value(self.cobotic, self.conventional)
            low, high = edge(parameter, -1), edge(parameter, 1)
            scaled = (None if factor is None else float(f"{factor * shipped:.3g}") for factor in (low, high))
            found.append(Range(move.words, move.unit, float(f"{shipped:.4g}"), *scaled))
        return tuple(found)


class Move(NamedTuple):
    """A parameter that the paper leaves open: its value, and drives in which it is so many times as large."""

    words: str
    unit: str
    value: Callable[[CoboticDrive, ConventionalDrive], float]
    move: Callable[[CoboticDrive, ConventionalDrive, float], tuple[CoboticDrive, ConventionalDrive]]


def _steering(drive: CoboticDrive) -> SteeringPlant:
    return needed(drive.steering, "steering")


def steering_inertia(drive: CoboticDrive) -> float:
    """Inertia of bell and steering motor about the steering axis. [kg m^2]"""
    steering = _steering(drive)
    return steering.bell_inertia + steering.ratio**2 * needed(steering.motor.rotor_inertia, "rotor_inertia")


def with_steering_inertia(drive: CoboticDrive, factor: float) -> CoboticDrive:
    """The drive with so many times the inertia of bell and steering motor."""
    steering = _steering(drive)
    motor = replace(steering.motor, rotor_inertia=factor * needed(steering.motor.rotor_inertia, "rotor_inertia"))
    return replace(drive, steering=replace(steering, motor=motor, bell_inertia=factor * steering.bell_inertia))


def bell_friction(drive: CoboticDrive) -> float:
    """Friction torque of the bell bearing. [N m]"""
    return float(_steering(drive).friction_torques(drive.transmission)["bell"])


def with_bell_friction(drive: CoboticDrive, factor: float) -> CoboticDrive:
    """The drive with so many times the friction of its bell bearing."""
    arm = factor * bell_friction(drive) / drive.transmission.preload
    return replace(drive, steering=replace(_steering(drive), bell_bearing=None, bell_friction=arm))


def with_link_mass(drive: CoboticDrive, factor: float) -> CoboticDrive:
    """The drive with so many times the link mass."""
    return replace(drive, link_mass=factor * needed(drive.link_mass, "link_mass"))


MOVES = {
    "steering_inertia": Move(
        "inertia about the steering axis",
        "kg m^2",
        lambda a, _: steering_inertia(a),
        lambda a, b, factor: (with_steering_inertia(a, factor), b),
    ),
    "link_mass": Move(
        "link mass of the cobotic drive",
        "kg",
        lambda a, _: needed(a.link_mass, "link_mass"),
        lambda a, b, factor: (with_link_mass(a, factor), b),
    ),
    "bell_friction": Move(
        "friction torque of the bell bearing",
        "N m",
        lambda a, _: bell_friction(a),
        lambda a, b, factor: (with_bell_friction(a, factor), b),
    ),
    "drag": Move(
        "drag at the load of the conventional drive",
        "N",
        lambda _, b: b.guideway.friction,
        lambda a, b, factor: (a, replace(b, guideway=Guideway(friction=factor * b.guideway.friction))),
    ),
}


def _checked(machine: Machine, check: Check, why: str) -> Finding:
    """The finding on the plane of Fig 17 for reconstruction A, with ranges and variants on a coarser one."""
    bench, other = Bench.of(machine), Bench.of(machine, "cobotic-b")
    found, verdict = check(Pair(machine.shaken["cobotic"], machine.shaken["motor2-gear4"]))
    return Finding(found, verdict, why, bench.ranges(check), bench.variants(check, other))


def d1(machine: Machine) -> Finding:
    """Who does better below 10 Hz and above 10 %."""
    why = (
        "Where neither works nothing is compared; where one works alone it is the better one. The cobotic motor idles at "
        "speed and pays little for force; the conventional one pays for every reversal of its own inertia, and for drag."
    )
    return _checked(machine, better, why)


def d2(machine: Machine) -> Finding:
    """How alike both are from 1 to 10 Hz."""
    why = (
        f"Counted as similar within a factor of {_SIMILAR:g} (median over the cells where both work). The conventional drive's "
        "performance is set by its assumed drag and by its motor's catalogue inertia."
    )
    return _checked(machine, similar, why)


def d3(machine: Machine) -> Finding:
    """The largest performance of the cobotic drive."""
    why = (
        "More than the 75 % of steady operation because energy exchanged counts in both directions while braking draws no "
        "power; counted as a round trip it is far less: the definition decides."
    )
    return _checked(machine, highest, why)


def d4(machine: Machine) -> Finding:
    """Who works in the upper corners."""
    ours, theirs = machine.shaken["cobotic"], machine.shaken["motor2-gear4"]
    met = [steady.limit_at(*place) for place in ((0, -1), (-1, -1)) for steady in (ours, theirs)]
    words = ["nothing" if found is None else words_of(found) for found in met]
    strokes = 2.0 * ours.amplitude[0, -1]
    why = (
        f"In the last cell at the left what binds is {words[0]} (cobotic) and {words[1]} (conventional), at the right {words[2]} "
        f"and {words[3]}; a stroke of {strokes:.0f} m at the left is not what a guideway allows, and is not counted here."
    )
    return _checked(machine, corners, why)


def d5(machine: Machine) -> Finding:
    """Where the cobotic drive's power goes."""
    why = (
        "Bell bearing, turning patch, and the steering motor's winding and friction together; most of the rest goes to the "
        "cylinder's gearing, whose law of loss the paper leaves open (B: in proportion to power), and to its motor."
    )
    return _checked(machine, to_steering, why)


def d6(machine: Machine) -> Finding:
    """Where the conventional drive's power goes."""
    steady = machine.shaken["motor2-gear4"]
    where = Pair(machine.shaken["cobotic"], steady).below & steady.works
    guide = _loss_share(steady, lambda name: name == "guideway", where)
    why = (
        f"Drag at the load (assumed) takes {guide:.0%}. The share of resistance rises with force, hence with frequency and "
        "power: from 5 Hz on it takes most. With less drag it takes most on average. Braking energy that is burnt is not "
        "counted as a loss of the drive."
    )
    return _checked(machine, to_resistance, why)


def d7(machine: Machine) -> Finding:
    """How performance changes over the plane."""
    return _checked(
        machine,
        trends,
        (
            "From cell to cell: rising within limits; falling from 10 Hz on, above what the paper calls mid-range, and beyond "
            "limits of torque and voltage, too, as the conventional drive hardly works there."
        ),
    )


def d8(machine: Machine) -> Finding:
    """Performance with all braking energy recovered."""
    bench, other = Bench.of(machine), Bench.of(machine, "cobotic-b")
    recovered = Definition(returned="store", storage_efficiency=1.0)

    def gain(bench: Bench) -> Found:
        before, after = bench.pair().cobotic, bench.pair(recovered).cobotic
        gained = (after.performance - before.performance)[before.works]
        value = float(np.nanmax(after.performance))
        return f"up to {value:.2f}", yes(bool(np.all(gained >= 0)))

    found, verdict = gain(bench)
    why = (
        "Less is taken from the supply wherever any power comes back. Counted so, performance has no bound: a lossless drive "
        "would take nothing."
    )
    return Finding(found, verdict, why, (), (Variant("reconstruction B", *gain(other)),))


def d9(machine: Machine) -> Finding:
    """Performance with half the steering inertia, and with half the link mass."""
    bench, other = Bench.of(machine), Bench.of(machine, "cobotic-b")

    def gain(bench: Bench) -> Found:
        before = bench.pair().cobotic
        words, holds = [], True
        for parameter, name in (("steering_inertia", "steering inertia"), ("link_mass", "link mass")):
            after = bench.moved(parameter, 0.5).pair().cobotic
            change = (after.performance - before.performance)[before.works & after.works]
            fast = (before.frequency >= 5.0)[:, None] & before.works & after.works
            mean = _share(after.performance / before.performance - 1.0, fast)
            wider = _share(after.works, np.ones_like(after.works)) - _share(before.works, np.ones_like(before.works))
            words.append(f"half the {name}: {mean:+.1%} above 5 Hz, works in {wider:+.1%} of the plane")
            holds = holds and bool(np.all(change >= -1e-9)) and wider >= 0
        return "; ".join(words), yes(holds)

    found, verdict = gain(bench)
    why = "Mean change where both work; it must not fall anywhere."
    return Finding(found, verdict, why, (), (Variant("reconstruction B", *gain(other)),))


CHECKS = {
    **{"D1": d1, "D2": d2, "D3": d3, "D4": d4, "D5": d5, "D6": d6, "D7": d7, "D8": d8, "D9": d9},
}
