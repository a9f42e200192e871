"""Curves through points, as smooth splines; kinks and cusps are found and refused."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from infinivar.errors import InputError, ParameterError, require
from infinivar.motion.virtual.arc_length import Base, Pieces, coordinates

KINK = math.radians(45.0)
"""Turn at one point, above which the neighbours must turn as well, or it is a kink. [rad]"""

_ALONE = 3.0
"""Times the mean turn of the neighbours by which the turn at a kink exceeds them."""

_BACK = math.radians(150.0)
"""Turn at one point that no smooth curve through a few points makes. [rad]"""

_SAME = 1e-9
"""Distance of points over the extent of all, below which they are the same point."""

_STOPS = 1e-4
"""Speed by the parameter, over its mean, below which the curve stops or turns back."""


def through(points: np.ndarray, closed: bool) -> Pieces:
    """A cubic spline through points (n, 2) or (n, 3), by the lengths of the chords.

    Raises
    ------
    ParameterError
        If there are too few points, two in a row are the same, or the curve has a kink.

    Source: deboor2001, chapter XVI, for the lengths of the chords as the parameter.
    """
    from scipy.interpolate import CubicSpline

    fewest = 3 if closed else 2
    require(
        len(points) >= fewest, "points", len(points), f"{fewest} or more of {'a closed' if closed else 'an open'} curve"
    )
    extent = float(np.max(np.ptp(points, axis=0)))
    all_points = np.concatenate([points, points[:1]]) if closed else points
    chords = np.diff(all_points, axis=0)
    sizes = np.sqrt(np.sum(chords**2, axis=1))
    repeated = np.flatnonzero(sizes <= _SAME * extent)
    if len(repeated):
        first, place = int(repeated[0]) + 1, coordinates(points[repeated[0]])
        if closed and first == len(points):
            raise ParameterError(
                f"points must not repeat the first at the end: the curve is closed; remove point {first} at {place}"
            )
        raise ParameterError(f"points {first} and {first + 1} must differ, got {place} twice")
    _refuse_kinks(points, chords / sizes[:, None], closed)
    parameter = np.concatenate([[0.0], np.cumsum(sizes)])
    spline = CubicSpline(parameter, all_points, bc_type="periodic" if closed else "not-a-knot")
    base = _base(spline)
    _refuse_stops(base, parameter)
    return Pieces.of(base, parameter, closed)


def _refuse_kinks(points: np.ndarray, ways: np.ndarray, closed: bool) -> None:
    """Raise ParameterError if the chords turn sharply at one point: unit chords (m, d), one after the other."""
    after = np.roll(ways, -1, axis=0) if closed else ways[1:]
    before = ways if closed else ways[:-1]
    turns = angle(before, after)  # at points 1, 2, ..., and 0 last of a closed curve
    if closed:
        beside = 0.5 * (np.roll(turns, 1) + np.roll(turns, -1))
    else:
        around = np.concatenate([turns[1:2], turns, turns[-2:-1]])  # an end turns as its neighbour
        beside = 0.5 * (around[:-2] + around[2:]) if len(turns) > 1 else turns
    kinks = (turns > _BACK) | ((turns > KINK) & (turns > _ALONE * beside))
    if kinks.any():
        worst = int(np.argmax(np.where(kinks, turns, 0.0)))
        place = (worst + 1) % len(points)
        raise ParameterError(
            f"points must lie on a smooth curve, got a kink of {math.degrees(turns[worst]):.0f} degrees at point {place + 1}, "
            f"{coordinates(points[place])}: round it by more points, or make two paths of it"
        )


def angle(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Angle between unit vectors (..., d), accurate near 0 and pi. [rad]"""
    apart, along = first - second, first + second
    return 2.0 * np.arctan2(np.sqrt(np.sum(apart**2, axis=-1)), np.sqrt(np.sum(along**2, axis=-1)))


def _base(spline: Any) -> Base:
    first, second = spline.derivative(1), spline.derivative(2)
    return lambda u: (spline(u), first(u), second(u))


def _refuse_stops(base: Base, parameter: np.ndarray) -> None:
    """Raise InputError where the point of the curve stands still as its parameter increases."""
    from scipy.optimize import minimize_scalar

    low, high = parameter[:-1, None], parameter[1:, None]
    dense = np.append((low + (high - low) * np.arange(8) / 8.0).ravel(), parameter[-1])
    speed = np.sqrt(np.sum(base(dense)[1] ** 2, axis=-1))
    mean = float(np.mean(speed))
    slow = np.flatnonzero((speed < 0.2 * mean) & (speed <= np.roll(speed, 1)) & (speed <= np.roll(speed, -1)))
    for place in slow[np.argsort(speed[slow])][:16]:
        ends = dense[max(place - 1, 0)], dense[min(place + 1, len(dense) - 1)]

        def at(u: float) -> float:
            return float(np.sqrt(np.sum(base(np.array([u]))[1] ** 2)))

        found: Any = minimize_scalar(at, bounds=ends, method="bounded", options={"xatol": 1e-9 * (ends[1] - ends[0])})
        least = min((float(found.fun), float(found.x)), (float(speed[place]), float(dense[place])))
        if least[0] < _STOPS * mean:
            where = coordinates(base(np.array([least[1]]))[0][0])
            raise InputError(f"the curve has a kink at {where}, where its point stands still or turns back")
