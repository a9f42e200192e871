"""A drive on the required region: coverage, mean loss, tightest limit and corners."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from infinivar import power
from infinivar._core.frozen import FrozenDict, frozen
from infinivar._core.result import Frozen, result
from infinivar.drivetrain.drive import Drive, operated
from infinivar.limits import LEADING, Limit, binding
from infinivar.study.requirement import Requirement

_CHUNK = 16384
"""Points at a time: their arrays stay in the processor's cache."""

_COARSE, _CLOSE = 41, 0.02
"""Points along each axis that settle coverage, unless the least margin is this close to 1; then all of `Requirement.sample`."""

PEAK_REACH = 10.0
"""Multiple of the required force and speed up to which the peak efficiency is searched."""

_SLOWEST, _FIRST = 1e-6, 64
"""Least multiple, and points along each axis and direction at which the search looks first."""

_WINDOW, _CLOSER, _FOUND, _ROUNDS = 9, 3.0, 1e-4, 60
"""Points along a side of the window around the best point, what it shrinks by once that is inside, the share of force and speed
down to which it does, and windows at most."""


@result
class Margin(Frozen):
    """Tightest limit of a drive in the required region."""

    limit: Limit
    value: float
    force: float
    speed: float


@result
class Corner(Frozen):
    """A drive at one corner of the required region. [m/s], [N], or [rad/s], [N m]; [W]"""

    speed: float
    force: float
    power_in: float
    losses: Mapping[str, float]
    efficiency: float
    limit: Limit
    margin: float


def against(name: str, drive: Drive, requirement: Requirement) -> tuple[dict[str, Any], np.ndarray, float]:
    """Evaluate a drive on a requirement: fields of `DriveResult`, efficiencies over the region, largest residual there."""
    speed, force, weight = _sample(requirement, None)
    region = _operated(drive, speed, force, name)
    margin, within = region.margin, region.limit == Limit.OK
    efficiency = power.efficiency_within(region.limit, region.power_in, region.power_out)
    # Among points of equal margin, report the one with the highest power.
    tight = int(np.argmax(np.where(margin <= margin.min() * (1 + 1e-9), np.abs(speed * force), -1.0)))
    worst = binding_at(operated(drive, speed=speed[tight], force=force[tight]).utilisation, 0)
    found = {
        "coverage": float(weight[within].sum()) if not within.all() else 1.0,
        "peak_efficiency_in_region": peak(efficiency),
        "mean_loss": _mean_loss(region, weight),
        "tightest": Margin(
            limit=worst, value=float(margin[tight]), force=float(force[tight]), speed=float(speed[tight])
        ),
        "corners": FrozenDict({label: corner(drive, *where) for label, where in requirement.corners().items()}),
    }
    return found, efficiency, region.residual


def covers(drive: Drive, requirement: Requirement, spare: float = 0.0) -> bool:
    """Whether a drive is within every limit at every required point: `DriveResult.covers`; a margin may lack `spare`."""
    for count in (_COARSE, None):
        speed, force, _ = _sample(requirement, count)
        least = float(_operated(drive, speed, force).margin.min())
        if abs(least - 1.0) > _CLOSE:
            break
    return least >= 1.0 - spare


def covers_with_loss(drive: Drive, requirement: Requirement, count: int | None = None) -> tuple[bool, float]:
    """`DriveResult.covers` and `DriveResult.mean_loss` [W], from the same points, or from fewer along each axis."""
    speed, force, weight = _sample(requirement, count)
    found = _operated(drive, speed, force)
    return float(found.margin.min()) >= 1.0, _mean_loss(found, weight)


@functools.lru_cache(maxsize=4)
def _sample(requirement: Requirement, count: int | None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """`Requirement.sample`, kept for the next of the drives that are compared."""
    return frozen(requirement.sample() if count is None else requirement.sample(count))


class _Points(NamedTuple):
    """A drive at many points (n,), and the largest residual of the power balance if it is requested."""

    power_in: np.ndarray
    power_out: np.ndarray
    limit: np.ndarray
    margin: np.ndarray
    residual: float


def _operated(drive: Drive, speed: np.ndarray, force: np.ndarray, audited: str = "") -> _Points:
    """Operate a drive at points (n,) in chunks; `audited` names it in the message of an audit."""
    found, residual = [], 0.0
    for start in range(0, speed.size, _CHUNK):
        here = slice(start, start + _CHUNK)
        point = operated(drive, speed=speed[here], force=force[here])
        fields = (point.power_in, point.power_out, *binding(point.utilisation))
        found.append([np.broadcast_to(one, speed[here].shape) for one in fields])
        if audited:
            residual = max(residual, power.audit(point.power_in, point.power_out, point.losses, audited))
    power_in, power_out, limit, margin = map(np.concatenate, zip(*found, strict=True))
    return _Points(power_in, power_out, limit, margin, residual)


def _mean_loss(found: _Points, weight: np.ndarray) -> float:
    """Mean over the points within limits; nan without any. [W]"""
    loss, within = found.power_in - found.power_out, found.limit == Limit.OK
    return float(np.average(loss[within], weights=weight[within])) if weight[within].sum() > 0 else float("nan")


def best_efficiency(
    drive: Drive, speed: float, force: float, signs: tuple[float, ...], audited: str
) -> tuple[float, float]:
    """Best efficiency within limits anywhere up to `PEAK_REACH` times a speed and a force, and the largest residual on the way.

    In each quadrant a window around the best point of a coarse grid follows it uphill, and shrinks where it stays inside: the
    best point often lies where limits meet, at which slopes say nothing. Along a limit, where efficiency is flat, the window may
    stop before its top: what is found is at most 2e-4 below it. nan where no point is within limits.
    """
    quadrants = np.array([(across, along) for across in signs for along in signs])
    low, high = np.log(_SLOWEST), np.log(PEAK_REACH)
    first = np.linspace(low, high, _FIRST)
    residual = 0.0

    def best(places: np.ndarray, ways: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Index and efficiency of the best of the points (q, n, 2), logarithms of multiples, of each quadrant."""
        nonlocal residual
        there = ways[:, None, :] * np.exp(places) * (speed, force)
        found = _operated(drive, there[..., 0].ravel(), there[..., 1].ravel(), audited)
        residual = max(residual, found.residual)
        efficiency = power.efficiency_within(found.limit, found.power_in, found.power_out).reshape(places.shape[:2])
        index = np.argmax(np.where(np.isnan(efficiency), -1.0, efficiency), axis=1)
        return index, np.take_along_axis(efficiency, index[:, None], axis=1)[:, 0]

    coarse = np.stack(np.meshgrid(first, first, indexing="ij"), axis=-1).reshape(1, -1, 2)
    index, found = best(np.repeat(coarse, len(quadrants), axis=0), quadrants)
    able = np.flatnonzero(~np.isnan(found))
    quadrants, centre, found = quadrants[able], coarse[0, index[able]], found[able]
    half = np.full(len(able), first[1] - first[0])
    side = np.linspace(-1.0, 1.0, _WINDOW)
    window = np.stack(np.meshgrid(side, side, indexing="ij"), axis=-1).reshape(1, -1, 2)
    for _ in range(_ROUNDS):
        if not np.any(half > _FOUND):
            break
        places = np.clip(centre[:, None, :] + half[:, None, None] * window, low, high)
        index, found = best(places, quadrants)
        inside = np.all((np.abs(window[0, index]) < 1.0) | (places[np.arange(len(index)), index] >= high), axis=1)
        centre, half = places[np.arange(len(index)), index], np.where(inside, half / _CLOSER, half)
    return peak(found), residual


def peak(efficiency: np.ndarray) -> float:
    """Largest efficiency; nan if none is known."""
    known = efficiency[~np.isnan(efficiency)]
    return float(known.max()) if known.size else float("nan")


def binding_at(utilisation: Mapping[Limit, Any], index: int) -> Limit:
    """The tightest limit at one point of a flat sample, exceeded or not."""
    demands = {
        limit: float(np.ravel(demand)[index if np.size(demand) > 1 else 0]) for limit, demand in utilisation.items()
    }
    if not demands:
        return Limit.OK
    for leading in reversed(LEADING):
        if demands.get(leading, 0.0) > 1.0:
            return leading
    return max(demands, key=lambda limit: -1.0 if np.isnan(demands[limit]) else demands[limit])


def corner(drive: Drive, speed: float, force: float) -> Corner:
    """Evaluate one operating point as plain numbers."""
    point = operated(drive, speed=speed, force=force)
    limit, margin = binding(point.utilisation)
    return Corner(
        speed=speed,
        force=force,
        power_in=float(point.power_in),
        losses=FrozenDict({name: float(loss) for name, loss in point.losses.items()}),
        efficiency=float(power.efficiency(point.power_in, point.power_out)),
        limit=Limit(int(limit)),
        margin=float(margin),
    )
