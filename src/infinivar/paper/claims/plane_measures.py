"""What two planes of Fig 17 show: each statement of the paper about them as a measure with its thresholds."""

from __future__ import annotations

from functools import partial

import numpy as np

from infinivar.analysis.cycles.shaking import DynamicMap
from infinivar.paper.claims.bench import Pair
from infinivar.paper.claims.claim import Found, yes

EXCEPTIONS = 0.05
"""Share of cells that may be exceptions to "in general" and "both show"."""
SIMILAR = 1.25
"""Performances within this factor count as similar."""
DIFFERENCE = 0.1
"""Performances that differ by less than this also count as similar. [-]"""
READING = 0.02
"""Tolerance for reading a level in Fig 17. [-]"""
UPPER = 0.8
"""Fraction of the maximum power above which a cell of Fig 17 is "upper"."""
SIDE = 0.1
"""Share of the frequency axis that counts as "left", and as "right"."""


def better(pair: Pair, *, exceptions: float = EXCEPTIONS) -> Found:
    """D1: share of the region in which the cobotic drive performs better or works alone."""
    ours, theirs = pair.cobotic, pair.conventional
    ahead = ours.works & (~theirs.works | (ours.performance > theirs.performance))
    share = pair.mean(ahead, pair.below)
    return Found(f"in {share:.1%} of the region", f"in at least {1 - exceptions:.1%}", yes(share >= 1 - exceptions))


def similar(pair: Pair, *, within: float = SIMILAR, statistic: str = "median", least: float = 0.0) -> Found:
    """D2: ratio of the performances (cobotic over conventional) from 1 to 10 Hz where both work."""
    ours, theirs = pair.cobotic, pair.conventional
    band = ((ours.frequency >= 1.0) & (ours.frequency <= 10.0))[:, None] & ours.works & theirs.works
    band = band & (ours.fraction > least)[None, :]
    threshold = f"within a factor of {within:.4g}"
    if not band.any():
        return Found("no cell where both work", threshold, "undecidable")
    if statistic == "difference":
        middle = pair.median(ours.performance - theirs.performance, band)
        return Found(f"{middle:+.2f} (median difference)", f"within {DIFFERENCE:g}", yes(abs(middle) <= DIFFERENCE))
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = ours.performance / theirs.performance
        logarithm = np.log(ratio)
    middle = {
        "median": lambda: pair.median(ratio, band),
        "mean": lambda: pair.mean(ratio, band),
        "geometric mean": lambda: float(np.exp(pair.mean(logarithm, band))),
    }[statistic]()
    return Found(f"ratio {middle:.2f} ({statistic})", threshold, yes(1 / within <= middle <= within))


def highest(pair: Pair, *, tolerance: float = READING) -> Found:
    """D3: highest performance of the cobotic drive within limits."""
    value = float(np.nanmax(pair.cobotic.performance, initial=0.0))
    return Found(value, f"within {tolerance:g} of 0.85", yes(abs(value - 0.85) <= tolerance))


def corners(pair: Pair, *, upper: float = UPPER, side: float = SIDE, most: float = 0.5) -> Found:
    """D4: which drive works in the upper corners of the plane."""
    count = pair.cobotic.frequency.size
    width = int(side * count)
    high = pair.cobotic.fraction > upper
    left, right = slice(0, width), slice(count - width, count)
    ours, theirs = pair.cobotic.works[:, high], pair.conventional.works[:, high]
    shares = [float(np.mean(works[part])) for part in (left, right) for works in (ours, theirs)]
    words = "left {:.0%} and {:.0%}, right {:.0%} and {:.0%} of the cells (cobotic and conventional)".format(*shares)
    threshold = (
        f"left more than {most:.0%} and none, right none; "
        f"above {upper:.0%} of the power, {side:.0%} of the axis at either end"
    )
    return Found(words, threshold, yes(shares[0] > most and max(shares[1:]) == 0.0))


def parts(steady: DynamicMap, dissipated: bool) -> dict[str, np.ndarray]:
    """Losses of a drive. The amplifier dissipates energy of the load, so its loss counts only if `burnt` is set."""
    return {name: loss for name, loss in steady.losses.items() if dissipated or name != "amplifier"}


def most_lost(
    pair: Pair,
    drive: str,
    part: str,
    *,
    statistic: str = "mean",
    dissipated: bool = False,
    of: str = "loss",
) -> Found:
    """D5 and D6: share of the losses whose names start with `part`, where the drive works below 10 Hz and above 10 %."""
    steady: DynamicMap = getattr(pair, drive)
    where = pair.below & steady.works
    threshold = "more than 50 %" if of != "largest" else "more than any other loss"
    if not where.any():
        return Found("works nowhere", threshold, "undecidable")
    losses = parts(steady, dissipated)
    requested = np.asarray(sum(loss for name, loss in losses.items() if name.startswith(part)))
    whole = np.asarray(steady.power_in if of == "power" else sum(losses.values()))
    with np.errstate(divide="ignore", invalid="ignore"):
        share = requested / whole
    if of == "largest":
        others = {name: pair.mean(loss / whole, where) for name, loss in losses.items() if not name.startswith(part)}
        next_to = max(others, key=lambda name: others[name])
        mean = pair.mean(share, where)
        return Found(f"{mean:.1%}, {next_to} {others[next_to]:.1%}", threshold, yes(mean > others[next_to]))
    middle = {
        "mean": lambda: pair.mean(share, where),
        "median": lambda: pair.median(share, where),
        "of the sums": lambda: pair.mean(requested, where) / pair.mean(whole, where),
    }[statistic]()
    what = "the power drawn" if of == "power" else "its loss"
    return Found(f"{middle:.1%} of {what}", threshold, yes(middle > 0.5))


to_steering = partial(most_lost, drive="cobotic", part="steering")
"""D5: the steering plant's share of the cobotic drive's loss."""
to_resistance = partial(most_lost, drive="conventional", part="winding")
"""D6: the winding's share of the conventional drive's loss."""


def trends(pair: Pair, *, exceptions: float = EXCEPTIONS, fast: float = 10.0, within: bool = False) -> Found:
    """D7: share of cells where performance rises with power, and of high-frequency cells where it falls with frequency."""
    rising, falling = [], []
    for steady in (pair.cobotic, pair.conventional):
        known = steady.performance if within else steady.unlimited
        up, along = np.diff(steady.performance, axis=1), np.diff(known, axis=0)
        high = np.broadcast_to((steady.frequency[:-1] >= fast)[:, None], along.shape) & np.isfinite(along)
        for found, change, where in ((rising, up > 0, np.isfinite(up)), (falling, along < 0, high)):
            found.append(float(np.mean(change[where])) if where.any() else np.nan)
    threshold = f"in at least {1 - exceptions:.1%}"
    if not np.all(np.isfinite(rising + falling)):
        return Found("one drive works nowhere", threshold, "undecidable")
    words = "rises in {:.0%} and {:.0%}, falls in {:.0%} and {:.0%} of the cells".format(*rising, *falling)
    return Found(f"{words} (cobotic and conventional)", threshold, yes(min(rising + falling) >= 1 - exceptions))
