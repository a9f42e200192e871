"""Limits in a simulated run: intervals in which a demand exceeds its allowance, means over the run, and both in words."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from infinivar._core.frozen import FrozenDict
from infinivar._core.result import Frozen, result
from infinivar.limits import LEADING, ROOT_MEAN_SQUARE, Demand, Limit
from infinivar.units import plain, times

TOLERANCE = 1e-3
"""Excess of a simulated demand over its allowance that counts as on the limit; not for slip and linkages. [-]"""

START = 0.1
"""Largest share of a run that is called its start. [-]"""

ROUNDING = 1e-9
"""Excess that is rounding. [-]"""

_FEW = 5
"""Most intervals of one limit that are listed one by one."""


@result
class Event(Frozen):
    """Time interval in which a demand exceeded its allowance."""

    limit: Limit
    what: str
    """Part of the drive: "motor", "steering motor", "wheel" ..."""
    start: float
    end: float
    """Start and end, linearly interpolated between outputs. [s]"""
    worst: float
    """Largest demand over allowance; inf if nothing is allowed. [-]"""
    settling: bool = False
    """Whether it lies in the settling time of the scenario, by which the run is not judged."""

    @property
    def name(self) -> str:
        """Limit and part."""
        return name_of(self.limit, self.what)

    def __str__(self) -> str:
        """One-line description."""
        how = "" if self.worst == math.inf else f", up to {times(self.worst)} the allowance"
        when = "while settling, " if self.settling else ""
        return f"{self.name} exceeded {when}from {plain(self.start)} s to {plain(self.end)} s{how}"


def name_of(limit: Limit, what: str) -> str:
    """A limit and the part it belongs to."""
    return f"{limit.words} ({what})"


def begins(event: Event) -> float:
    """When an event begins, to sort by: parts that do the same begin together, whatever the tolerance. [s]"""
    return round(event.start, 7)


def events(
    time: Any, utilisation: Mapping[Demand, Any], settled: int = 0, peaks: Mapping[Demand, Any] = FrozenDict()
) -> tuple[Event, ...]:
    """Find the intervals in which a demand exceeds its allowance.

    Parameters
    ----------
    time : (n,) float                       [s]
    utilisation : Demand to (n,) float      Demand over allowance. [-]
    settled : int                           Instant at which the settling time ends; an interval across it is split.
    peaks : Demand to (n,) float            Largest demand since the instant before, where it is known.

    Returns
    -------
    tuple of Event   By start time. Intervals in which no demand exceeds 1 by more than `TOLERANCE` are left out, except those
        of slip and of a linkage out of reach.
    """
    most = {key: np.maximum(demand, peaks.get(key, demand)) for key, demand in utilisation.items()}
    # The peak of the instant at which the settling time ends lies before it.
    late = {
        key: np.append(demand[settled : settled + 1], most[key][settled + 1 :]) for key, demand in utilisation.items()
    }
    found = list(_events(time[settled:], late))
    if settled:
        early = {key: demand[: settled + 1] for key, demand in most.items()}
        found += [replace(event, settling=True) for event in _events(time[: settled + 1], early)]
    return tuple(sorted(found, key=begins))


def _events(time: Any, utilisation: Mapping[Demand, Any]) -> Iterator[Event]:
    for (limit, what), demand in utilisation.items():
        for first, last in intervals(demand > 1.0 + ROUNDING):
            worst = float(np.max(demand[first:last]))
            if worst <= 1.0 + TOLERANCE and limit not in LEADING:
                continue
            yield Event(
                limit=limit,
                what=what,
                start=_crossing(time, demand, first - 1, first),
                end=_crossing(time, demand, last, last - 1),
                # A contact carries no more than its slip force, however fast it slides.
                worst=math.inf if limit == Limit.SLIP else worst,
            )


def intervals(inside: np.ndarray) -> Iterator[tuple[int, int]]:
    """First place, and that after the last one, of each row of places that are inside."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], inside, [False]]).astype(int))).tolist()
    return zip(edges[::2], edges[1::2], strict=True)


def _crossing(time: Any, demand: Any, inside: int, beyond: int) -> float:
    """Time at which the demand passes 1 between outputs `inside` and `beyond`; the time of `beyond` at the ends."""
    if not 0 <= inside < len(time) or not np.isfinite(demand[beyond]):
        return float(time[beyond])
    share = (1.0 - demand[inside]) / (demand[beyond] - demand[inside])
    return float(time[inside] + min(max(share, 0.0), 1.0) * (time[beyond] - time[inside]))


def side(demand: Any) -> Any:
    """On which side of their allowances demands are: 0 up to them, 1 beyond by rounding only, 2 beyond."""
    return (demand > 1.0).astype(int) + (demand > 1.0 + ROUNDING)


def first_settled(time: np.ndarray, settling_time: float | None) -> int:
    """First instant at or after the end of a settling time; the last one if the run ended before."""
    if settling_time is None or not len(time):
        return 0
    return min(int(np.searchsorted(time, settling_time * (1.0 - ROUNDING))), len(time) - 1)


def root_mean_squares(
    time: Any, utilisation: Mapping[Demand, Any], settled: int = 0, squares: Mapping[Demand, Any] = FrozenDict()
) -> dict[Demand, float]:
    """Root mean square of the demands that it limits, over the run after settling; arguments of `events`. [-]

    `squares` are integrals of the squares since the instant before, (n,) [s], where they are known.
    """
    return {
        key: math.sqrt(
            lasting(time, squares[key], settled) if key in squares else mean(time[settled:], demand[settled:] ** 2)
        )
        for key, demand in utilisation.items()
        if key[0] in ROOT_MEAN_SQUARE
    }


def lasting(time: Any, sums: Any, settled: int = 0) -> float:
    """Mean over the run after settling, from integrals since the instant before each; 0 if no time is left."""
    span = float(time[-1] - time[settled])
    return float(np.sum(sums[settled + 1 :])) / span if span > 0.0 else 0.0


def mean(time: Any, values: Any) -> float:
    """Mean over time by the trapezoidal rule."""
    if len(time) < 2:
        return float(values[0])
    return float(np.trapezoid(values, time) / (time[-1] - time[0]))


def exceeded(found: Sequence[Event], means: Mapping[Demand, float]) -> tuple[str, ...]:
    """Names of the limits that make the run infeasible: any instant after settling, or the root mean square of a demand."""
    names = [event.name for event in found if _counts(event) and not event.settling]
    names += [name_of(*key) for key, share in means.items() if share > 1.0 + TOLERANCE]
    return tuple(dict.fromkeys(names))


def _counts(event: Event) -> bool:
    return event.limit not in ROOT_MEAN_SQUARE


def verdict(found: Sequence[Event], means: Mapping[Demand, float], duration: float, settling: float | None) -> str:
    """Exceeded limits in one line, and whether they are only exceeded at the start of the run.

    Parameters
    ----------
    found, means          Results of `events` and `root_mean_squares`.
    duration : float      [s]
    settling : float      Settling time; None without one. [s]
    """
    names = exceeded(found, means)
    after = "" if settling is None else f" after {plain(settling)} s of settling"
    words = f"within limits{after}"
    if names:
        counted = [event for event in found if _counts(event) and not event.settling]
        lasting = max((event.end for event in counted), default=duration)
        if lasting <= START * duration and all(share <= 1.0 + TOLERANCE for share in means.values()):
            after = f" only in the first {plain(lasting, 3)} s"
        words = f"limit{'s' if len(names) > 1 else ''} exceeded{after}: {', '.join(names)}"
    early = dict.fromkeys(event.name for event in found if _counts(event) and event.settling)
    early = [name for name in early if name not in names]
    return "; ".join([words, *([f"only while settling: {', '.join(early)}"] if early else [])])


def lines(found: Sequence[Event], means: Mapping[Demand, float]) -> tuple[str, ...]:
    """Explain a verdict: every interval beyond a limit, or all of one limit together if they are many.

    Limits on the root mean square have one line, where they are exceeded at any instant.
    """
    kinds = dict.fromkeys((event.limit, event.what, event.settling) for event in found if _counts(event))
    groups = [[event for event in found if (event.limit, event.what, event.settling) == kind] for kind in kinds]
    listed = [line for group in groups for line in _lines(group)]
    return (*listed, *_mean_lines(found, means))


def _lines(group: Sequence[Event]) -> list[str]:
    """One line for each interval in which one limit is exceeded, or one for all of them if they are many."""
    if len(group) <= _FEW:
        return [str(event) for event in group]
    whole = replace(group[0], end=group[-1].end, worst=max(event.worst for event in group))
    return [f"{whole}, {len(group)} times"]


def _mean_lines(found: Sequence[Event], means: Mapping[Demand, float]) -> Iterator[str]:
    for key, share in means.items():
        worst = max((e.worst for e in found if (e.limit, e.what) == key and not e.settling), default=0.0)
        if share > 1.0 + TOLERANCE:
            yield f"{name_of(*key)} exceeded: root mean square {times(share)} the allowance, at most {times(worst)}"
        elif worst:
            yield (
                f"{name_of(*key)}: root mean square {plain(share, 3)} of the allowance, which is what counts; momentarily "
                f"up to {times(worst)}"
            )
