"""How far the designs of a search withstand the spread of their parts."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from infinivar._core.described import derived, reported, rows
from infinivar._core.result import Frozen, Result, result
from infinivar.analysis.robustness.verdicts import band, percent
from infinivar.sizing.builds.spreads import Varied
from infinivar.sizing.design import limit_words
from infinivar.sizing.margins import TaskDemand
from infinivar.units import plain, show

CONFIDENCE = 0.95
"""Of intervals of shares. [-]"""


def interval(number: int, count: int) -> tuple[float, float]:
    """Interval of a share of which a number of independent samples out of a count were found, at 95 % confidence. [-]

    Source: clopper1934.
    """
    from scipy.special import betaincinv

    tail = 0.5 * (1.0 - CONFIDENCE)
    low = betaincinv(number, count - number + 1, tail) if number else 0.0
    high = betaincinv(number + 1, count - number, 1.0 - tail) if number < count else 1.0
    return float(low), float(high)


@result
class DesignBuilds(Frozen):
    """Builds of a design.

    Attributes
    ----------
    name           Of its study file, such as "design-01".
    title          Its parts.
    feasible       Whether a build keeps all limits. (n,) bool
    power          Mean power of a build from the supply; nan without a motion, or where a wheel slips. (n,) [W]
    exceeded       Number of builds beyond each limit, by motion or "requirement", limit and part, the most first; only if any is.
    best           Number of builds in which it is the best of the feasible designs.
    nominal        Mean power with the values of the data sheets. [W]
    """

    name: str = reported()
    title: str = reported()
    feasible: np.ndarray
    power: np.ndarray
    exceeded: Mapping[TaskDemand, int] = reported(convert=rows("task", "limit", "part", "builds"))
    best: int
    nominal: float

    @property
    def count(self) -> int:
        """Number of builds."""
        return len(self.feasible)

    @derived("1", key="feasible")
    def share(self) -> float:
        """Share of builds that keep all limits. [-]"""
        return float(np.mean(self.feasible))

    @derived("1", key="feasible_interval")
    def interval(self) -> tuple[float, float]:
        """Interval of that share at 95 % confidence, as of independent builds. [-]"""
        return interval(int(np.sum(self.feasible)), self.count)

    @derived("1", key="best")
    def best_share(self) -> float:
        """Share of builds in which it is the best of the feasible designs. [-]"""
        return self.best / self.count

    @property
    def weakest(self) -> TaskDemand | None:
        """Limit that most builds exceed; None if none does."""
        return next(iter(self.exceeded), None)

    @property
    def band(self) -> dict[str, float | None]:
        """5 % quantile, median and 95 % quantile of the power of feasible builds; None without any. [W]"""
        return band(self.power[self.feasible])

    @property
    def verdict(self) -> str:
        """One clause for people."""
        low, high = (percent(end, self.count) for end in self.interval)
        said = f"feasible in {percent(self.share, self.count)} of builds"
        said += f" ({low.removesuffix(' %')} to {high} at {percent(CONFIDENCE, self.count)} confidence)"
        if self.weakest is not None:
            often = percent(self.exceeded[self.weakest] / self.count, self.count)
            said += f"; {limit_words(self.weakest)} exceeded in {often}"
        least, most = self.band["low"], self.band["high"]
        if least is not None and most is not None and math.isfinite(self.nominal):
            said += f"; {plain(least, 3)} to {show(most, 'W', 3)} in 90 % of the feasible"
        return said

    @derived("1")
    def _best_interval(self) -> tuple[float, float]:
        return interval(self.best, self.count)

    @derived("W")
    def _power(self) -> dict[str, float | None]:
        return {"nominal": self.nominal, **self.band}


@result
class Doubt(Result):
    """Result of `doubt`.

    Attributes
    ----------
    objective      By which designs are compared: energy, mass, space or price.
    designs        Builds of the best designs of the search, in its order.
    front          Builds of each design of the front; these do not compete with the others.
    varied         Values that vary, each with the part to which it belongs.
    none           Number of builds in which no design is feasible.
    """

    objective: str = reported()
    designs: tuple[DesignBuilds, ...] = reported()
    front: tuple[DesignBuilds, ...] = reported()
    varied: tuple[Varied, ...] = reported()
    none: int

    @derived(key="builds")
    def count(self) -> int:
        """Number of builds."""
        return self.designs[0].count

    @property
    def runners_up(self) -> tuple[DesignBuilds, ...]:
        """Designs that are best in some builds, except the first; the most often best first."""
        return tuple(sorted((one for one in self.designs[1:] if one.best), key=lambda one: -one.best))

    @derived()
    def verdict(self) -> str:
        """One line on the winner of the search."""
        winner = self.designs[0]
        said = f"{winner.title}: {winner.verdict}"
        if len(self.designs) > 1:
            said += (
                f"; least {self.objective} of {len(self.designs)} designs in {percent(winner.best_share, self.count)}"
            )
        if self.none and len(self.designs) > 1:
            said += f"; no design is feasible in {percent(self.none / self.count, self.count)}"
        return said

    @property
    def stated(self) -> tuple[str, ...]:
        """Spreads that the study states, in words."""
        return tuple(one.words for one in self.varied if not one.assumed)

    @property
    def assumed(self) -> tuple[str, ...]:
        """Rules of the default spreads, in words, each once."""
        return tuple(dict.fromkeys(one.words for one in self.varied if one.assumed))

    @derived("1")
    def _none_feasible(self) -> float:
        return self.none / self.count

    def _rows(self) -> Iterator[tuple[str, str]]:
        yield "verdict", self.verdict
        yield "builds", str(self.count)
        for one in self.runners_up[:5]:
            yield one.name, f"best in {percent(one.best_share, self.count)}; {one.verdict}"
