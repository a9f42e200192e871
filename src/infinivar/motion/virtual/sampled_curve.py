"""Curves from points and from functions of a parameter, as smooth splines; kinks and cusps are found and refused."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from infinivar._core.arrays import shown
from infinivar.errors import InputError, ParameterError, require
from infinivar.motion.virtual.arc_length import Base, Pieces, coordinates
from infinivar.motion.virtual.rows import FARTHEST

KINK = math.radians(45.0)
"""Turn at one point, above which the neighbours must turn as well, or it is a kink. [rad]"""

_ALONE = 3.0
"""Times the mean turn of the neighbours by which the turn at a kink exceeds them."""

_BACK = math.radians(150.0)
"""Turn at one point that no smooth curve through a few points makes. [rad]"""

_SAME = 1e-9
"""Distance of points over the extent of all, below which they are the same point; error of a fitted function as well."""

_ELSEWHERE = 0.3819660112501051
"""Share of a step, no fraction of small numbers, at which a fit is checked."""

_FEWEST, _MOST = 64, 16384
"""Steps of the parameter at which a function is evaluated."""

_TURN = 0.01
"""Turn of the tangent within no distance that is a kink. [rad]"""

_STOPS = 1e-4
"""Speed by the parameter, over its mean, below which the curve has a cusp or stops."""


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
    _refuse_stops(base, parameter, "a kink")
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


def _refuse_stops(base: Base, parameter: np.ndarray, what: str) -> None:
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
            raise InputError(f"the curve has {what} at {where}, where its point stands still or turns back")


def of_function(function: Callable[[float], Any], start: float, end: float, closed: bool) -> Pieces:
    """A smooth function of a parameter, by a quintic spline through as many of its points as it needs.

    Raises
    ------
    ParameterError
        If a value is not two or three finite coordinates, or a closed curve does not end where it starts.
    InputError
        If the curve jumps, has a kink or a cusp, or is not smooth.
    """
    from scipy.interpolate import make_interp_spline

    evaluate = _rows(function)
    count = _FEWEST
    parameter = np.linspace(start, end, count + 1)
    points = evaluate(parameter)
    while True:
        extent = float(np.max(np.ptp(points, axis=0)))
        require(extent > 0.0, "function", f"{coordinates(points[0])} everywhere", "a curve")
        spline = make_interp_spline(parameter, points, k=5)
        middles = 0.5 * (parameter[:-1] + parameter[1:])
        between = evaluate(middles)
        errors = np.sqrt(np.sum((spline(middles) - between) ** 2, axis=-1))
        if errors.max() <= _SAME * extent:
            # A wave that is zero at all nodes and middles is not zero here.
            elsewhere = parameter[:-1] + _ELSEWHERE * np.diff(parameter)
            errors = np.sqrt(np.sum((spline(elsewhere) - evaluate(elsewhere)) ** 2, axis=-1))
            if errors.max() <= 10.0 * _SAME * extent:
                break
        if count >= _MOST:
            raise InputError(_rough(evaluate, parameter, int(np.argmax(errors))))
        count *= 2
        merged = np.empty((count + 1, points.shape[1]))
        merged[::2], merged[1::2] = points, between
        parameter, points = np.linspace(start, end, count + 1), merged
    base = _base(spline)
    if closed:
        _check_closed(base, start, end, extent)
    _refuse_stops(base, parameter, "a cusp")
    return Pieces.of(base, parameter[:: max(1, count // 256)], closed)


def _rows(function: Callable[[float], Any]) -> Callable[[np.ndarray], np.ndarray]:
    """The function over many parameters; each value is checked."""
    size = 0

    def evaluate(parameters: np.ndarray) -> np.ndarray:
        nonlocal size
        rows = []
        for u in parameters.tolist():
            said = function(u)
            try:
                row = np.asarray(said, dtype=float)
            except (TypeError, ValueError):
                row = np.empty(0)
            size = size or row.size
            fits = row.shape in ((2,), (3,)) and row.size == size and bool(np.all(np.abs(row) <= FARTHEST))
            expected = f"{size} finite coordinates" if size in (2, 3) else "two or three finite coordinates"
            require(fits, "value of function", f"{shown(said)} at the parameter {u:g}", expected)
            rows.append(row)
        return np.array(rows)

    return evaluate


def _check_closed(base: Base, start: float, end: float, extent: float) -> None:
    point, slope, _ = base(np.array([start, end]))
    gap = float(np.sqrt(np.sum((point[1] - point[0]) ** 2)))
    if gap > 10.0 * _SAME * extent:
        raise ParameterError(
            f"function must end where it starts, as the curve is closed, got {coordinates(point[0])} at the parameter {start:g} "
            f"and {coordinates(point[1])} at {end:g}"
        )
    speed = np.sqrt(np.sum(slope**2, axis=-1, keepdims=True))
    if not (speed > 0.0).all():
        return  # a cusp, which is refused where all are looked for
    turn = float(angle(slope[0] / speed[0], slope[1] / speed[1]))
    if turn > _TURN:
        raise InputError(
            f"the curve has a kink of {math.degrees(turn):.0f} degrees where it closes, at {coordinates(point[0])}"
        )


def _rough(evaluate: Callable[[np.ndarray], np.ndarray], parameter: np.ndarray, worst: int) -> str:
    """Why a function could not be fitted, from its values near the worst place, ever closer."""
    low, high = parameter[max(worst - 2, 0)], parameter[min(worst + 3, len(parameter) - 1)]
    for _ in range(5):
        here = np.linspace(low, high, 33)
        place = _sharpest(evaluate(here))[0]
        low, high = here[max(place - 1, 0)], here[min(place + 3, 32)]
    here = np.linspace(low, high, 33)
    points = evaluate(here)
    place, turn, jump = _sharpest(points)
    where = f"at the parameter {here[place + 1]:g}, {coordinates(points[place + 1])}"
    if jump > 0.0:
        return f"the curve jumps by {jump:.3g} m {where}"
    if turn > _TURN:
        return f"the curve has a kink of {math.degrees(turn):.0f} degrees {where}"
    return f"the curve is not smooth {where}, or changes there within less than 1/{_MOST} of the parameter's range"


def _sharpest(points: np.ndarray) -> tuple[int, float, float]:
    """Place of the sharpest turn of a row of points, the turn [rad], and the width of a jump there, 0 for none [m]."""
    chords = np.diff(points, axis=0)
    sizes = np.sqrt(np.sum(chords**2, axis=-1))
    longest = int(np.argmax(sizes))
    if sizes[longest] > 0.9 * sizes.sum():
        return longest, 0.0, float(sizes[longest])
    ways = chords / np.where(sizes > 0.0, sizes, 1.0)[:, None]
    turns = angle(ways[:-1], ways[1:])
    place = int(np.argmax(turns))
    return place, float(turns[max(place - 1, 0) : place + 2].sum()), 0.0  # a kink lies at a point, or beside one
