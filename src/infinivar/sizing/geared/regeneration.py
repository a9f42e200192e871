r"""Radii of a pulley at which a motor returns power, for amplifiers that accept none.

With the motion a motor takes the power ``I (R I + E)``, which is negative for currents between ``-E/R`` and 0. Both ends are
``A r + B/r + C = 0`` with factors of their own, so that each instant forbids at most a few intervals of radii. What all instants
leave may have gaps: below them friction and load keep the current positive, above them the motor brakes harder than a short
circuit would and draws power again.
"""

from __future__ import annotations

import numpy as np

from infinivar.limits import Limit
from infinivar.sizing.geared.candidates import Candidates
from infinivar.sizing.geared.extremes import braking_places
from infinivar.sizing.geared.radius_bounds import Radii
from infinivar.sizing.geared.radius_limits import Load, WithResistance, constants, with_resistances
from infinivar.sizing.geared.tasks import RegionTask

RETURNED = (Limit.REGENERATION, "motor")

_CELLS = 400_000
"""Intervals of instants and candidates handled at once, so that intermediate arrays stay small."""

Intervals = np.ndarray
"""Disjoint intervals of radii in rising order. (m, 2) [m]"""


def returning(found: Candidates, load: Load, rows: np.ndarray) -> list[Intervals]:
    """Radii of each candidate at which some instant returns power, whatever the temperature of the winding.

    Where no temperature sets the resistance, these are all such radii but their ends.
    """
    points = load.moving
    if isinstance(load.task, RegionTask):
        points = points[braking_places(points[:, [0, 2]])]
    # The current is positive where no load and no inertia drives.
    points = points[(points[:, 0] < 0.0) | (points[:, 1] < 0.0)]
    if not len(points):
        return [np.empty((0, 2))] * len(rows)
    spans: list[Intervals] = []
    size = max(1, _CELLS // (9 * len(points)))
    for start in range(0, len(rows), size):
        some = rows[start : start + size]
        low, high, negative = _cells(points, load, with_resistances(found, load.task, some))
        spans += [
            union(np.stack([low[one][negative[one]], high[one][negative[one]]], axis=-1)) for one in range(len(some))
        ]
    return spans


def _cells(points: np.ndarray, load: Load, who: WithResistance) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Ends of the radii between the zeros of current and voltage of each instant, and whether power is returned there.

    Source: the larger of the two forms of the current counts, see `radius_limits`.
    """
    slopes = [who.current.drive] if load.drives.all() else [who.current.drive, who.current.brake]
    short = (who.current.back_emf / who.high)[:, None] * points[:, 2]
    forms = []
    for slope in slopes:
        first, second, third, constant = (factor[:, None] for factor in constants(load, who.current, slope))
        inverse = second * points[:, 1] + third * points[:, 2]
        forms.append((first * points[:, 0], inverse, inverse + short, constant))
    low, high = load.range
    shape = np.broadcast_shapes(*(one.shape for one in forms[0]))
    edges = [np.full(shape, low), np.full(shape, high)]
    for linear, of_current, of_voltage, constant in forms:
        for inverse in (of_current, of_voltage):
            edges += [np.broadcast_to(one, shape) for one in _zeros(linear, inverse, constant, (low, high))]
    ends = np.sort(np.stack(edges, axis=-1), axis=-1)
    middle = np.sqrt(ends[..., :-1] * ends[..., 1:])
    drawn = np.zeros(middle.shape, dtype=bool)
    short_circuited = np.ones(middle.shape, dtype=bool)
    for linear, of_current, of_voltage, constant in forms:
        current, voltage = (
            linear[..., None] * middle + inverse[..., None] / middle + constant[..., None]
            for inverse in (of_current, of_voltage)
        )
        drawn |= current >= 0.0
        short_circuited &= voltage <= 0.0
    return ends[..., :-1], ends[..., 1:], ~drawn & ~short_circuited & (ends[..., :-1] < ends[..., 1:])


def _zeros(
    linear: np.ndarray, inverse: np.ndarray, constant: np.ndarray, within: tuple[float, float]
) -> tuple[np.ndarray, np.ndarray]:
    """Zeros of ``linear r + inverse/r + constant`` in a range of r; the end of the range where there is none."""
    root = constant * constant - 4.0 * linear * inverse
    with np.errstate(divide="ignore", invalid="ignore"):
        half = -0.5 * (constant + np.copysign(np.sqrt(np.where(root < 0.0, np.nan, root)), constant))
        found = half / linear, inverse / half
    low, high = within
    first, second = (np.where((one > low) & (one < high), one, high) for one in found)
    return first, second


def union(spans: Intervals) -> Intervals:
    """Disjoint intervals in rising order that cover the same radii as some intervals."""
    if not len(spans):
        return spans
    spans = spans[np.argsort(spans[:, 0], kind="stable")]
    reach = np.maximum.accumulate(spans[:, 1])
    begins = np.concatenate([[True], spans[1:, 0] > reach[:-1]])
    return np.stack([spans[begins, 0], reach[np.concatenate([begins[1:], [True]])]], axis=-1)


def windows(spans: list[Intervals] | None, bounds: Radii) -> tuple[np.ndarray, Radii]:
    """What the intervals of each candidate leave of its bounds; None for no intervals.

    Returns
    -------
    places : (m,) int   Candidate of each window, in rising order; one may have several, or none.
    bounds : Radii     Ends of each window. (m,)
    """
    if spans is None:
        able = np.flatnonzero(~bounds.empty)
        return able, Radii(bounds.low[able], bounds.high[able])
    places, low, high = [], [], []
    for place, (span, first, last) in enumerate(zip(spans, *bounds, strict=True)):
        if not first <= last:
            continue
        begins = np.concatenate([[first], np.maximum(span[:, 1], first)])
        ends = np.concatenate([np.minimum(span[:, 0], last), [last]])
        # A range may be a single radius; between intervals that touch nothing is left.
        wide = (begins < ends) | (first == last) & (begins <= ends)
        places += [place] * int(wide.sum())
        low.append(begins[wide])
        high.append(ends[wide])
    empty = np.empty(0)
    return np.array(places, dtype=int), Radii(np.concatenate([empty, *low]), np.concatenate([empty, *high]))
