"""Verdicts of shipped studies with spreads from residuals, and with round numbers: ``python -m measured.verdicts``."""

from __future__ import annotations

import functools
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

import infinivar as iv
from infinivar._core.frozen import FrozenDict
from infinivar.analysis.robustness.verdicts import Builds, band, percent
from infinivar.study.default_spreads import with_default_spreads
from infinivar.study.study import Study
from infinivar.units import plain

STUDIES = ("knee_walking", "reach_and_hold", "ankle_walking", "hand_controller")
"""Shipped studies of drives of one axis with a requirement or a duty cycle."""

ROUND = {"resistance": 0.1, "efficiency": 0.2}
"""Round numbers that a designer would assume: tolerance of the resistance, and of the gear loss; both uniform. [-]"""


def with_round_numbers(study: Study) -> Study:
    """The study with round numbers in place of spreads from residuals; what is assumed in both stays."""
    filled = with_default_spreads(study)
    spreads = {}
    for name, each in filled.uncertainty.spreads.items():
        kept = []
        for one in each:
            field = one.path.rpartition(".")[2]
            size = ROUND.get(field, 0.0) * (1.0 - one.value if field == "efficiency" else one.value)
            if one.deviation is None:
                kept.append(one)
            elif size > 0.0:
                kept.append(replace(one, deviation=None, low=one.value - size, high=one.value + size, kind="assumed"))
        spreads[name] = tuple(kept)
    return replace(filled, uncertainty=replace(filled.uncertainty, spreads=FrozenDict(spreads)))


@functools.cache
def compared(study: str) -> tuple[iv.Comparison, iv.Comparison]:
    """The comparison of a study with round numbers, and with spreads from residuals."""
    loaded = iv.load_study(study)
    return iv.compare(with_round_numbers(loaded)), iv.compare(loaded, default_spreads=True)


def lines(study: str) -> Iterator[str]:
    """Rows of the page's table."""
    both = compared(study)
    for name in both[1].builds:
        best = both[1].best is both[1].results[name]
        nominal = (
            ("least energy" if both[1].duty else "least loss") if best else "able" if both[1].able(name) else "not able"
        )
        each = [one.builds[name] for one in both]
        cells = [words(one) for words in (_energy, _feasible, _covers) for one in each]
        yield f"| {study}, {name} | {nominal} | {' | '.join(cells)} |"


def _energy(one: Builds) -> str:
    found = [band(duty.energy) for duty in one.duty.values()]
    return (
        "; ".join(f"{plain(low, 3)} to {plain(high, 3)} J" for low, high in ((it["low"], it["high"]) for it in found))
        or "none"
    )


def _feasible(one: Builds) -> str:
    return "; ".join(percent(duty.share, one.count) for duty in one.duty.values()) or "none"


def _covers(one: Builds) -> str:
    return percent(one.covering, one.count) if one.margin.size else "none"


def wins(study: str, first: str, second: str) -> tuple[float, float]:
    """Share of pairs of independent builds in which the first needs less energy: with round numbers, and with residuals. [-]"""

    def share(found: iv.Comparison) -> float:
        one, other = (next(iter(found.builds[name].duty.values())).energy for name in (first, second))
        return float(np.mean(one[:, None] < other[None, :]))

    before, now = (share(found) for found in compared(study))
    return before, now


if __name__ == "__main__":
    print("\n".join(line for study in STUDIES for line in lines(study)))
