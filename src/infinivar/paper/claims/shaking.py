"""Checks of the claims about shaking a mass (section VI-C and Fig 17), under every choice that the paper leaves open."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from infinivar._core.frozen import FrozenDict
from infinivar.analysis.cycles.performance import PAPER, Definition
from infinivar.analysis.cycles.shaking import DynamicMap
from infinivar.limits import words_of
from infinivar.paper.claims.bench import MOVES, TRACED, Bench, Pair
from infinivar.paper.claims.claim import (
    Checked,
    Found,
    Kind,
    PaperMachine,
    Range,
    Variant,
    either_way,
    row,
    yes,
)
from infinivar.paper.claims.plane_measures import (
    EXCEPTIONS,
    READING,
    SIMILAR,
    better,
    corners,
    highest,
    parts,
    similar,
    to_resistance,
    to_steering,
    trends,
)
from infinivar.paper.claims.planes import LEAST_FRACTION

FARTHEST = 30.0
"""Ranges of a verdict are searched up to this factor, either way."""


class Reading(NamedTuple):
    """An alternative definition of performance, and whether the paper leaves it open or contradicts it."""

    kind: Kind
    words: str
    definition: Definition


DEFINITIONS = (
    Reading("definition", "common DC bus: power returned by one motor feeds the other", Definition(common_bus=True)),
    Reading("definition", "continuous torque limits the peak, not the RMS", Definition(torque="peak")),
    Reading("contrary", "braking energy stored at 80 %", Definition(returned="store", storage_efficiency=0.8)),
    Reading("contrary", "no negative electrical power", Definition(returned="none")),
    Reading("contrary", "round trip, braking energy dissipated", Definition(measure="round trip")),
    Reading(
        "contrary",
        "round trip, braking energy stored at 80 %",
        Definition(measure="round trip", returned="store", storage_efficiency=0.8),
    ),
    Reading("contrary", "integral as printed, which has no finite value", Definition(measure="printed")),
)
"""Readings of "performance" other than the paper's, which dissipates returned power and counts energy in both directions."""

Check = Callable[[Pair], Found]

AXES: Mapping[str, Mapping[str, str]] = FrozenDict(
    {
        f"logarithmic axis of power, from {LEAST_FRACTION:.0%}": {"power_axis": "logarithmic"},
        "linear axis of frequency": {"frequency_axis": "linear"},
        "both": {"power_axis": "logarithmic", "frequency_axis": "linear"},
    }
)
"""Axes for weighting cells, other than those of the figure."""


def ranges(bench: Bench, check: Check) -> Iterator[Range]:
    """Range of each traced value over which the verdict of a check stays the same."""
    verdict = check(bench.pair()).verdict

    def edge(parameter: str, direction: int) -> float | None:
        """Factor at which the verdict changes, by bisection of its logarithm; None if it does not change."""
        inside, outside = 0.0, float(np.log(FARTHEST))
        if check(bench.moved(parameter, FARTHEST**direction).pair()).verdict == verdict:
            return None
        for _ in range(7):
            middle = 0.5 * (inside + outside)
            same = check(bench.moved(parameter, float(np.exp(direction * middle))).pair()).verdict == verdict
            inside, outside = (middle, outside) if same else (inside, middle)
        return float(np.exp(direction * inside))

    for parameter in TRACED:
        move = MOVES[parameter]
        shipped = move.value(bench)
        low, high = edge(parameter, -1), edge(parameter, 1)
        scaled = (None if factor is None else float(f"{factor * shipped:.3g}") for factor in (low, high))
        yield Range(move.words, move.unit, float(f"{shipped:.4g}"), *scaled)


def open_values(bench: Bench, found: Callable[[Bench], Found]) -> Iterator[Variant]:
    """Findings with each value that the paper does not print varied by `FACTOR`, one at a time."""
    for parameter, move in MOVES.items():
        yield from either_way(move.words, lambda factor, one=parameter: found(bench.moved(one, factor)))


@dataclass(frozen=True, slots=True)
class _OnPlane:
    """A claim about both drives on the plane of Fig 17; calling it with a machine returns the finding.

    Attributes
    ----------
    check     Check of one pair of maps.
    why       Explanation of the verdict, from the numbers of the machine.
    choices   The check with other choices that the paper leaves open, by description.
    axes      Other axes for weighting cells.
    """

    check: Check
    why: Callable[[PaperMachine], str]
    choices: Mapping[str, Check]
    axes: Mapping[str, Mapping[str, str]]

    def __call__(self, machine: PaperMachine) -> Checked:
        """Check reconstruction A on the plane of the figure."""
        bench, check = Bench.of(machine), self.check
        shown = check(bench.pair(cells="fine"))
        return Checked(shown, lambda: self.why(machine), self.variants(machine), lambda: ranges(bench, check))

    def variants(self, machine: PaperMachine) -> Iterator[Variant]:
        """Choices tried for both reconstructions, definitions and values with the shipped choices on a coarser plane."""
        check, bench, other = self.check, Bench.of(machine), Bench.of(machine, "cobotic-b")
        yield from (row("choice", words, found) for words, found in self.tried(bench))
        yield row("value", "reconstruction B", check(other.pair(cells="fine")))
        yield from (row("value", f"reconstruction B, {words}", found) for words, found in self.tried(other))
        yield row("choice", "24 x 16 cells instead of 60 x 60", check(bench.pair()))
        yield from (row(kind, words, check(bench.pair(definition))) for kind, words, definition in DEFINITIONS)
        yield from open_values(bench, lambda moved: check(moved.pair()))

    def tried(self, bench: Bench) -> Iterator[tuple[str, Found]]:
        """Findings with other axes and other choices."""
        for words, scale in self.axes.items():
            yield words, self.check(bench.pair(cells="fine", **scale))  # type: ignore[arg-type]
        for words, changed in self.choices.items():
            yield words, changed(bench.pair(cells="fine"))


def _thresholds(check: Callable[..., Found], name: str, shipped: float, one: float = 0.0) -> dict[str, Check]:
    """The check with half and with twice the threshold, measured from `one`."""
    return {
        words: partial(check, **{name: one + factor * (shipped - one)})
        for words, factor in (("half the tolerance", 0.5), ("twice the tolerance", 2.0))
    }


def _loss_choices(check: Callable[..., Found]) -> dict[str, Check]:
    return {
        "median instead of mean": partial(check, statistic="median"),
        "share of the summed loss instead of mean share": partial(check, statistic="of the sums"),
        "dissipated braking energy counted as a loss": partial(check, dissipated=True),
        "share of the power drawn instead of the loss": partial(check, of="power"),
        '"most" as more than any other loss': partial(check, of="largest"),
    }


def _listed(pair: Pair, drive: str) -> str:
    """The largest losses of a drive below 10 Hz and above 10 % of the power, as text."""
    steady: DynamicMap = getattr(pair, drive)
    losses = parts(steady, dissipated=False)
    whole, where = np.asarray(sum(losses.values())), pair.below & steady.works
    shares = {name: pair.mean(loss / whole, where) for name, loss in losses.items()}
    largest = sorted(shares, key=lambda name: -shares[name])[:3]
    return ", ".join(f"{name} {shares[name]:.0%}" for name in largest)


def _why_better(machine: PaperMachine) -> str:
    """Which drive performs better below 10 Hz and above 10 % of the power."""
    bench = Bench.of(machine)
    pair = bench.pair(cells="fine")
    alone = pair.mean(pair.cobotic.works & ~pair.conventional.works, pair.below)
    both = pair.below & pair.cobotic.works & pair.conventional.works
    least = float(np.min((pair.cobotic.performance / pair.conventional.performance)[both]))
    return (
        f'"In general" is taken to allow {EXCEPTIONS:.0%} of exceptions. Where either drive works, the cobotic drive works '
        f"alone in {alone:.0%} of the region. Where both work, its performance is at least {least:.2f} times the conventional "
        "drive's."
    )


def _why_similar(machine: PaperMachine) -> str:
    """How similar both drives are from 1 to 10 Hz."""
    pair = Bench.of(machine).pair(cells="fine")
    ours, theirs = pair.cobotic, pair.conventional
    both = ((ours.frequency >= 1.0) & (ours.frequency <= 10.0))[:, None] & ours.works & theirs.works
    shared = np.flatnonzero(both.any(axis=0))
    low, high = (
        pair.median(ours.performance / theirs.performance, both & (np.arange(ours.fraction.size) == column)[None, :])
        for column in (shared[0], shared[-1])
    )
    return (
        "The paper does not say how similar. The performance ratio (cobotic over conventional) is "
        f"{low:.2f} at {ours.fraction[shared[0]]:.1%} of the power and {high:.2f} at {ours.fraction[shared[-1]]:.0%}, the "
        "highest at which both work. The median therefore depends on the scale of the power axis."
    )


def _why_highest(machine: PaperMachine) -> str:
    """The highest performance of the cobotic drive."""
    bench = Bench.of(machine)
    shipped = highest(bench.pair(cells="fine")).computed
    trip = highest(bench.pair(Definition(measure="round trip"))).computed
    return (
        f"{shipped:.2f} exceeds the 0.75 of steady operation because energy exchanged with the load counts in both directions, "
        f"while braking draws no power. Counted as a round trip, the performance is {trip:.2f}."
    )


def _why_corners(machine: PaperMachine) -> str:
    """Which drive works in the upper corners."""
    ours, theirs = Bench.of(machine).pair(cells="fine")[:2]
    met = [steady.limit_at(*place) for place in ((0, -1), (-1, -1)) for steady in (ours, theirs)]
    words = ["none" if found is None else words_of(found) for found in met]
    stroke = 2.0 * ours.amplitude[0, -1]
    return (
        f"The tightest limits in the upper left cell are {words[0]} (cobotic) and {words[1]} (conventional), in the upper right "
        f"cell {words[2]} and {words[3]}. The stroke at the left, {stroke:.0f} m, exceeds the travel of any guideway, "
        "but travel is not limited here."
    )


def _why_steering(machine: PaperMachine) -> str:
    """Where the cobotic drive's power goes."""
    pairs = [Bench.of(machine, name).pair(cells="fine") for name in ("cobotic", "cobotic-b")]
    return (
        "Steering includes the bell bearing, the turning contact patch, and the winding and friction of the steering motor. The "
        f"largest single losses are {_listed(pairs[0], 'cobotic')} in A, and {_listed(pairs[1], 'cobotic')} in B. A and B differ "
        "in the loss law of the cylinder gear and in the steering plant; the paper prints neither."
    )


def half_from(frequency: Sequence[float] | np.ndarray, shares: Sequence[float]) -> float | None:
    """Lowest frequency above which every known share exceeds a half; None if it never stays above. [Hz]"""
    start = None
    for one, share in zip(frequency, shares, strict=True):
        if share <= 0.5:
            start = None
        elif share > 0.5 and start is None:
            start = float(one)
    return start


def _why_resistance(machine: PaperMachine) -> str:
    """Where the conventional drive's power goes."""
    pair = Bench.of(machine).pair(cells="fine")
    steady = pair.conventional
    where = pair.below & steady.works
    losses = parts(steady, dissipated=False)
    share = steady.losses["winding"] / np.asarray(sum(losses.values()))
    rising = [pair.mean(share, where & (steady.frequency == one)[:, None]) for one in steady.frequency]
    start = half_from(steady.frequency, rising)
    reached = f"reaches {np.nanmax(rising):.0%}" if start is None else f"exceeds half from {start:.1f} Hz"
    return (
        f"The largest losses are {_listed(pair, 'conventional')}; drag at the load is assumed. The share of winding resistance "
        f"rises with force, and so with frequency and power: it {reached}."
    )


def _why_trends(machine: PaperMachine) -> str:
    """How performance changes over the plane."""
    return (
        "Neighbouring cells are compared. Performance rises with power within limits. It falls with frequency above 10 Hz, "
        "beyond what the paper calls mid-range; this includes cells beyond the torque and voltage limits, because the "
        "conventional drive hardly works there."
    )


@dataclass(frozen=True, slots=True)
class _OnMaps:
    """A claim that compares two maps of the cobotic drive; calling it with a machine returns the finding.

    Attributes as in `_OnPlane`, except that `check` takes a bench and a definition of performance, and makes its own maps.
    """

    check: Callable[..., Found]
    why: Callable[[PaperMachine], str]
    choices: Mapping[str, Callable[..., Found]]

    def __call__(self, machine: PaperMachine) -> Checked:
        """Check reconstruction A."""
        return Checked(self.check(Bench.of(machine)), lambda: self.why(machine), self.variants(machine))

    def variants(self, machine: PaperMachine) -> Iterator[Variant]:
        """Every choice, definition and value tried."""
        check, bench = self.check, Bench.of(machine)
        yield row("value", "reconstruction B", check(Bench.of(machine, "cobotic-b")))
        yield from (row("choice", words, changed(bench)) for words, changed in self.choices.items())
        for kind, words, definition in DEFINITIONS:
            if definition.returned == "burn" and definition.measure != "printed":
                yield row(kind, words, check(bench, definition=definition))
        yield from open_values(bench, check)


def raised(before: DynamicMap, after: DynamicMap) -> Found:
    """D8: rise of performance where the drive worked before."""
    gained = (after.performance - before.performance)[before.works]
    value = float(np.nanmax(after.performance, initial=0.0))
    words = f"up to {value:.2f}, higher in {float(np.mean(gained > 0)):.0%} of the cells"
    return Found(words, "lower in none", yes(bool(np.all(gained >= 0))))


def recovered(bench: Bench, *, definition: Definition = PAPER, efficiency: float = 1.0) -> Found:
    """D8: performance with braking energy dissipated, and with it stored."""
    stored = replace(definition, returned="store", storage_efficiency=efficiency)
    return raised(bench.pair(definition).cobotic, bench.pair(stored).cobotic)


def _why_recovered(machine: PaperMachine) -> str:
    return (
        "The drive draws less power wherever any power comes back. By this definition performance has no upper limit: a "
        "lossless drive would draw nothing."
    )


def lighter(
    bench: Bench, *, definition: Definition = PAPER, factor: float = 0.5, exceptions: float = EXCEPTIONS
) -> Found:
    """D9: change of performance with a lower steering inertia and with a lower link mass."""
    before = bench.pair(definition).cobotic
    words, holds = [], True
    for parameter, name in (("steering_inertia", "steering inertia"), ("link_mass", "link mass")):
        after = bench.moved(parameter, factor).pair(definition).cobotic
        both = before.works & after.works
        gain = (after.performance / before.performance - 1.0)[both]
        worse = float(np.mean(gain < 0.0)) if gain.size else float("nan")
        wider = float(np.mean(after.works)) - float(np.mean(before.works))
        words.append(
            f"{factor:g} x the {name}: {np.min(gain, initial=np.inf):+.1%} to {np.max(gain, initial=-np.inf):+.1%}, "
            f"worse in {worse:.0%} of the cells, working region {wider:+.1%} of the plane"
        )
        holds = holds and worse <= exceptions and wider >= 0
    return Found("; ".join(words), f"worse in at most {exceptions:.1%} of the cells", yes(holds))


def _why_lighter(machine: PaperMachine) -> str:
    bus = Definition(common_bus=True)
    before, after = (
        one.pair(bus).cobotic for one in (Bench.of(machine), Bench.of(machine).moved("steering_inertia", 0.5))
    )
    both = before.works & after.works
    gain = np.where(both, after.performance / before.performance - 1.0, 0.0)
    row_of_worst, _ = np.unravel_index(np.argmin(gain), gain.shape)
    return (
        "The computed values are the change of performance in each cell in which the drive works before and after, and the "
        "change of the share of the plane in which it works. If both motors share a DC bus, half the steering inertia changes "
        f"the performance by {gain.min():+.1%} near {before.frequency[row_of_worst]:.1f} Hz."
    )


CHECKS: Mapping[str, Callable[[PaperMachine], Checked]] = {
    "D1": _OnPlane(better, _why_better, _thresholds(better, "exceptions", EXCEPTIONS), axes=AXES),
    "D2": _OnPlane(
        similar,
        _why_similar,
        {
            **_thresholds(similar, "within", SIMILAR, one=1.0),
            "mean instead of median": partial(similar, statistic="mean"),
            "geometric mean instead of median": partial(similar, statistic="geometric mean"),
            "difference instead of ratio": partial(similar, statistic="difference"),
            "only above 10 % of the power": partial(similar, least=0.1),
        },
        axes=AXES,
    ),
    "D3": _OnPlane(highest, _why_highest, _thresholds(highest, "tolerance", READING), axes={}),
    "D4": _OnPlane(
        corners,
        _why_corners,
        {
            "upper: above 60 % of the power": partial(corners, upper=0.6),
            "upper: above 90 % of the power": partial(corners, upper=0.9),
            "left and right: a fifth of the axis": partial(corners, side=0.2),
            "works at the left: in any cell": partial(corners, most=0.0),
            "works at the left: in nine out of ten cells": partial(corners, most=0.9),
        },
        axes={},
    ),
    "D5": _OnPlane(to_steering, _why_steering, _loss_choices(to_steering), axes=AXES),
    "D6": _OnPlane(to_resistance, _why_resistance, _loss_choices(to_resistance), axes=AXES),
    "D7": _OnPlane(
        trends,
        _why_trends,
        {
            **_thresholds(trends, "exceptions", EXCEPTIONS),
            "high frequency: above 5 Hz": partial(trends, fast=5.0),
            "falling within limits only, above 5 Hz": partial(trends, fast=5.0, within=True),
        },
        axes={},
    ),
    "D8": _OnMaps(
        recovered,
        _why_recovered,
        {f"stored at {share:.0%}": partial(recovered, efficiency=share) for share in (0.8, 0.5)},
    ),
    "D9": _OnMaps(
        lighter,
        _why_lighter,
        {
            **{f"{factor:g} times instead of half": partial(lighter, factor=factor) for factor in (0.9, 0.25)},
            **_thresholds(lighter, "exceptions", EXCEPTIONS),
        },
    ),
}
"""Claims about Fig 17: their checks, the explanations of their verdicts, and the other choices tried."""
