r"""Curves by arc length: quintic pieces, and the closest point on them.

A smooth curve r(u) is replaced by pieces that are quintic in the arc length s and meet its point, unit tangent and
curvature vector at their ends, so that tangent and curvature are continuous. Pieces are halved until they follow the
curve within `TOLERANCE` of its length.

Source of the bound of `_Pieces.nearest`: the triangle inequality. A point c of a piece of length h between the ends a
and b has ``|p - c| >= (|p - a| + |p - b| - h)/2``, as ``|a - c| + |c - b| <= h``.
"""

from __future__ import annotations

import bisect
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from infinivar.bondgraph.scalars import choose, floor, within
from infinivar.bondgraph.tape import Number, Value
from infinivar.errors import InputError

TOLERANCE = 1e-10
"""Largest distance of the pieces from the curve, at the same arc length, over its length."""

_MOST_PIECES = 40_000

_COARSEST = 1e-7
"""Rounding of the coordinates over the length of a curve, above which it has no shape."""

_CHUNK = 1 << 19
"""Distances held at a time while the closest pieces are looked for."""

_FEW = 12
"""Pieces that may hold the point closest to one point, above which NumPy pays off."""

_FLAT = 0.05
"""Second derivative of half the squared distance below which a step of Newton's method is not trusted."""

_FOLLOWED = 40
"""Most steps downhill to the closest point."""

Base = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray, np.ndarray]]
"""Points (n, d) of a curve at parameters (n,), and their first and second derivative by the parameter."""


class CurvePoint(NamedTuple):
    """The point of a curve that is closest to a given point; for rows of points, rows."""

    arc_length: float | np.ndarray
    """From the start of the curve. (...,) [m]"""
    point: np.ndarray
    """(..., d) [m]"""
    tangent: np.ndarray
    """Unit vector along the curve. (..., d)"""
    curvature_vector: np.ndarray
    """Derivative of the tangent by the arc length, towards the centre of curvature. (..., d) [m^-1]"""
    curvature: float | np.ndarray
    """In the plane, positive where the curve turns left; in space the length of the curvature vector. (...,) [m^-1]"""
    offset: float | np.ndarray
    """Of the given point from the curve, across the tangent: in the plane positive to the left; in space >= 0. (...,) [m]"""
    beyond: float | np.ndarray
    """Of the given point along the tangent, past the end of an open curve (> 0) or before its start (< 0); else 0. (...,) [m]"""


class Pieces:
    """A curve as quintic pieces over its arc length."""

    __slots__ = (
        "_lengths",
        "_lists",
        "_rounding",
        "_small",
        "_starts",
        "_steps",
        "closed",
        "coefficients",
        "dimension",
        "knots",
        "length",
        "nodes",
    )

    def __init__(self, knots: np.ndarray, coefficients: np.ndarray, closed: bool) -> None:
        """From arc lengths (n + 1,) at the ends of n pieces and coefficients (n, 6, d) of powers of the share of each."""
        self.knots, self.coefficients, self.closed = knots, coefficients, closed
        self.dimension = coefficients.shape[2]
        self.length = float(knots[-1])
        self._lengths = np.diff(knots)
        self.nodes = np.concatenate([coefficients[:, 0], coefficients[-1:].sum(axis=1)])
        self._rounding = 4e-16 * float(np.max(np.abs(self.nodes)))
        self._small = 1e-14 * self.length + self._rounding
        # Plain floats: a single point in a controller's loop costs several times more through NumPy.
        self._starts: list[float] = knots[:-1].tolist()
        self._steps: list[float] = self._lengths.tolist()
        self._lists: list[list[list[float]]] = coefficients.transpose(0, 2, 1).tolist()

    @classmethod
    def of(cls, base: Base, parameters: np.ndarray, closed: bool) -> Pieces:
        """Pieces of a smooth curve between increasing parameters (n + 1,), at which its third derivative may jump.

        Raises
        ------
        InputError
            If the pieces cannot follow the curve.
        """
        nodes = np.asarray(parameters, dtype=float)
        while True:
            lengths, shares = _lengths(base, nodes)
            knots = np.concatenate([[0.0], np.cumsum(lengths)])
            made = cls(knots, _hermite(base, nodes, lengths), closed)
            if made._rounding > _COARSEST * made.length:
                raise InputError(
                    f"the curve near {coordinates(made.nodes[0])} is too small for its distance from the origin: its length of "
                    f"{made.length:.3g} m is lost in rounding"
                )
            coarse = made._misses(base, nodes, shares)
            if not coarse.any():
                return made
            if len(nodes) > _MOST_PIECES:
                place = base(nodes[:-1][coarse][:1])[0][0]
                raise InputError(f"the curve cannot be followed near {coordinates(place)}: it is not smooth there")
            middles = 0.5 * (nodes[:-1] + nodes[1:])
            nodes = np.sort(np.concatenate([nodes, middles[coarse]]))

    def _misses(self, base: Base, nodes: np.ndarray, shares: np.ndarray) -> np.ndarray:
        """Which pieces are too far from the curve, at quarters of the parameter. (n,)"""
        wrong = np.zeros(len(self._lengths), dtype=bool)
        for place, quarter in enumerate((0.25, 0.5, 0.75)):
            expected, slope, _ = base(nodes[:-1] + quarter * np.diff(nodes))
            made, tangent, _ = _evaluated(self.coefficients, shares[place], self._lengths)
            slope = slope / _norm(slope)[:, None]
            wrong |= _norm(made - expected) > TOLERANCE * self.length + self._rounding
            wrong |= _norm(tangent - slope) > math.sqrt(TOLERANCE) + 10.0 * self._rounding / self._lengths
        return wrong

    def wrapped(self, arc_length: np.ndarray) -> np.ndarray:
        """Arc lengths on the curve: those of closed curves by their remainder, others no further than the ends."""
        if self.closed:
            return np.mod(arc_length, self.length)
        return np.clip(arc_length, 0.0, self.length)

    def at(self, arc_length: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Point, unit tangent and curvature vector, (..., d) each, at arc lengths (...,)."""
        there = self.wrapped(arc_length)
        piece = np.clip(np.searchsorted(self.knots, there, side="right") - 1, 0, len(self._lengths) - 1)
        share = (there - self.knots[piece]) / self._lengths[piece]
        point, slope, bend = _evaluated(self.coefficients[piece], share, self._lengths[piece])
        return point, slope / _norm(slope)[..., None], bend

    def nearest(self, points: np.ndarray) -> np.ndarray:
        """Arc lengths of the points of the curve closest to points (n, d); (n,)."""
        rows = max(1, _CHUNK // len(self.nodes))
        parts = [self._nearest(points[low : low + rows]) for low in range(0, len(points), rows)]
        return np.concatenate(parts) if parts else np.zeros(0)

    def _nearest(self, points: np.ndarray) -> np.ndarray:
        away = _norm(points[:, None, :] - self.nodes)
        least = away.min(axis=1)
        bound = 0.5 * (away[:, :-1] + away[:, 1:] - self._lengths)
        row, piece = np.nonzero(bound <= least[:, None] + TOLERANCE * self.length)
        share = self._shares(points[row], piece, away[row, piece] <= away[row, piece + 1])
        found = _norm(_evaluated(self.coefficients[piece], share, self._lengths[piece])[0] - points[row])
        order = np.lexsort((found, row))
        first = np.concatenate([[True], row[order][1:] != row[order][:-1]])
        best = order[first]
        return self.knots[piece[best]] + share[best] * self._lengths[piece[best]]

    def _shares(self, points: np.ndarray, piece: np.ndarray, first_nearer: np.ndarray) -> np.ndarray:
        """Share of each piece at its point closest to a point, by Newton's method within a shrinking bracket."""
        coefficients, lengths = self.coefficients[piece], self._lengths[piece]

        def slopes(share: np.ndarray, which: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            point, tangent, bend = _evaluated(coefficients[which], share, lengths[which])
            gap = point - points[which]
            return np.sum(gap * tangent, axis=-1), np.sum(tangent * tangent + gap * bend, axis=-1)

        every = np.arange(len(piece))
        at_start, at_end = slopes(np.zeros(len(piece)), every)[0], slopes(np.ones(len(piece)), every)[0]
        share = np.where(at_start >= 0.0, np.where((at_end < 0.0) & ~first_nearer, 1.0, 0.0), 1.0)
        inner = np.flatnonzero((at_start < 0.0) & (at_end > 0.0))
        low, high = np.zeros(len(inner)), np.ones(len(inner))
        guess = at_start[inner] / (at_start[inner] - at_end[inner])
        for _ in range(60):
            if not len(inner):
                break
            slope, curve = slopes(guess, inner)
            low, high = np.where(slope < 0.0, guess, low), np.where(slope < 0.0, high, guess)
            newton = guess - slope / np.where(curve > _FLAT, curve, np.inf) / lengths[inner]
            inside = (curve > _FLAT) & (newton >= low) & (newton <= high)
            new = np.where(inside, newton, 0.5 * (low + high))
            done = (np.abs(new - guess) <= 1e-13) | (slope == 0.0)
            share[inner] = np.where(slope == 0.0, guess, new)
            inner, low, high, guess = inner[~done], low[~done], high[~done], new[~done]
        return share

    def nearest_to(self, point: np.ndarray) -> float:
        """Arc length of the point of the curve closest to one point (d,)."""
        gaps = self.nodes - point
        away = np.sqrt(np.einsum("ij,ij->i", gaps, gaps))
        bound = 0.5 * (away[:-1] + away[1:] - self._lengths)
        likely = np.flatnonzero(bound <= away.min() + TOLERANCE * self.length)
        if len(likely) > _FEW:
            return float(self._nearest(point[None])[0])
        target, best, found = point.tolist(), math.inf, 0.0
        for piece in likely[np.argsort(bound[likely])].tolist():
            if bound[piece] > best:
                break
            share, far = self._share(target, piece, bool(away[piece] <= away[piece + 1]))
            if far < best:
                best, found = far, self._starts[piece] + share * self._steps[piece]
        return found

    def _share(self, point: list[float], piece: int, first_nearer: bool) -> tuple[float, float]:
        """As `_shares`, of one piece in plain floats; and its distance from the point."""
        low, high, share = 0.0, 1.0, 0.0
        at_start, _, square_start = self._slope(point, piece, 0.0)
        at_end, _, square_end = self._slope(point, piece, 1.0)
        if at_start >= 0.0 and (at_end >= 0.0 or first_nearer):
            return 0.0, math.sqrt(square_start)
        if at_end <= 0.0 or at_start >= 0.0:
            return 1.0, math.sqrt(square_end)
        share, square = at_start / (at_start - at_end), 0.0
        for _ in range(60):
            slope, curve, square = self._slope(point, piece, share)
            low, high = (share, high) if slope < 0.0 else (low, share)
            new = share - slope / curve / self._steps[piece] if curve > _FLAT else -1.0
            new = new if low <= new <= high else 0.5 * (low + high)
            if abs(new - share) <= 1e-13 or slope == 0.0:
                break
            share = new
        return share, math.sqrt(square)

    def _slope(self, point: list[Number], piece: Number, share: Number) -> tuple[Number, Number, Number]:
        """First and second derivative of half the squared distance from a point by the arc length, and the squared distance."""
        square = slope = curve = 0.0
        place, tangent, bend = self._local(piece, share)
        for a, p, t, k in zip(place, point, tangent, bend, strict=True):
            gap = a - p
            square += gap * gap
            slope += gap * t
            curve += t * t + gap * k
        return slope, curve, square

    def local(self, arc_length: Number) -> tuple[list[Number], list[Number], list[Number]]:
        """Point, tangent and curvature vector at one arc length within the curve, as plain numbers."""
        return self._local(*self._place(arc_length))

    def _place(self, arc_length: Number) -> tuple[Number, Number]:
        """The piece at an arc length, and the share of it."""
        if isinstance(arc_length, Value):
            return self._place_of_value(arc_length)
        piece = min(max(bisect.bisect_right(self._starts, arc_length) - 1, 0), len(self._starts) - 1)
        return piece, (arc_length - self._starts[piece]) / self._steps[piece]

    def _place_of_value(self, arc_length: Value) -> tuple[Number, Number]:
        """The same, recorded: by halving, as many times whatever the arc length."""
        take, piece, count = arc_length.__array_namespace__().take, 0.0, len(self._starts)
        begins, steps = self.knots, self._lengths
        half = 1 << max(count - 1, 1).bit_length() - 1
        while half:
            there = within(piece + half, float(count - 1))
            piece = choose(arc_length >= take(begins, there), lambda there=there: there, lambda piece=piece: piece)
            half >>= 1
        return piece, (arc_length - take(begins, piece)) / take(steps, piece)

    def _coefficients(self, piece: Number) -> list[list[Number]]:
        """Of the powers of the share, for each direction."""
        if not isinstance(piece, Value):
            return self._lists[int(piece)]
        take, six = piece.__array_namespace__().take, 6 * self.dimension
        return [
            [take(self.coefficients, six * piece + float(self.dimension * power + axis)) for power in range(6)]
            for axis in range(self.dimension)
        ]

    def _local(self, piece: Number, x: Number) -> tuple[list[Number], list[Number], list[Number]]:
        step = (
            piece.__array_namespace__().take(self._lengths, piece)
            if isinstance(piece, Value)
            else self._steps[int(piece)]
        )
        point, slope, bend = [], [], []
        for c0, c1, c2, c3, c4, c5 in self._coefficients(piece):
            point.append(c0 + x * (c1 + x * (c2 + x * (c3 + x * (c4 + x * c5)))))
            slope.append((c1 + x * (2.0 * c2 + x * (3.0 * c3 + x * (4.0 * c4 + x * 5.0 * c5)))) / step)
            bend.append((2.0 * c2 + x * (6.0 * c3 + x * (12.0 * c4 + x * 20.0 * c5))) / (step * step))
        return point, slope, bend

    def follow(self, point: list[Number], near: Number) -> Number | None:
        """Arc length of the closest point that is reached downhill from an arc length; None, recorded nan, if it is not found
        soon."""
        there = self._moved(near, 0.0)
        state: tuple[Number, ...] = there, there, math.inf, 0.0, 0.0
        if isinstance(there, Value):

            def step(*values: Value) -> tuple[tuple[Number, ...], Number]:
                new = self._downhill(point, *values[:4])
                return new, new[4] > 0.5

            found: Number
            there, *_, found = there.__array_namespace__().loop(step, state, _FOLLOWED)
            return choose(found > 0.5, lambda: there, lambda: math.nan)
        for _ in range(_FOLLOWED):
            state = self._downhill(point, *state[:4])
            if state[4]:
                return state[0]
        return None

    def _downhill(
        self, point: list[Number], there: Number, old: Number, before: Number, step: Number
    ) -> tuple[Number, ...]:
        """The next arc length, that from which it steps, the squared distance there, the step, and 1 if that is the last."""
        slope, curve, square = self._slope(point, *self._place(there))

        def back() -> tuple[Number, ...]:
            return self._moved(old, 0.5 * step), old, before, 0.5 * step, 0.0

        def on() -> tuple[Number, ...]:
            wanted = choose(curve > _FLAT, lambda: -slope / curve, lambda: -slope)
            new = within(wanted, 0.125 * self.length)
            moved = self._moved(there, new)
            last = choose((abs(new) <= self._small) | (moved == there), lambda: 1.0, lambda: 0.0)
            return moved, there, square, new, last

        farther = (square > before * (1.0 + 1e-12)) & (abs(step) > 1e-9 * self.length)
        return choose(farther, back, on)

    def _moved(self, arc_length: Number, step: Number) -> Number:
        there = arc_length + step
        if self.closed:
            return there - self.length * floor(there / self.length)
        capped = choose(there > self.length, lambda: self.length, lambda: there)
        return choose(there < 0.0, lambda: 0.0, lambda: capped)


def coordinates(place: np.ndarray) -> str:
    """A point for a message: "(0.1, 0.25) m"."""
    return f"({', '.join(f'{one:.6g}' for one in place)}) m"


def _norm(vectors: np.ndarray) -> np.ndarray:
    """Lengths of vectors (..., d), with d of 2 or 3; several times faster than `numpy.linalg.norm` for a few."""
    return np.sqrt(np.einsum("...i,...i->...", vectors, vectors))


_GAUSS, _WEIGHTS = np.polynomial.legendre.leggauss(12)


def _lengths(base: Base, nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lengths between parameters, (n,), and the share of each at the quarters of the parameter, (3, n), by Gauss's rule."""
    steps = np.diff(nodes)
    parts = []
    for quarter in range(4):
        here = nodes[:-1, None] + steps[:, None] * (quarter + 0.5 + 0.5 * _GAUSS) / 4.0
        speed = _norm(base(here.ravel())[1]).reshape(here.shape)
        parts.append(speed @ _WEIGHTS * steps / 8.0)
    upto = np.cumsum(parts, axis=0)
    return upto[-1], upto[:-1] / upto[-1]


def _hermite(base: Base, nodes: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Coefficients (n, 6, d) of the quintics over the share of each piece that meet the curve to second order at both ends."""
    point, first, second = base(nodes)
    speed = _norm(first)[:, None]
    tangent = first / speed
    bend = (second - np.sum(second * tangent, axis=-1, keepdims=True) * tangent) / speed**2
    h = lengths[:, None]
    p, m0, m1, a0, a1 = point[1:] - point[:-1], h * tangent[:-1], h * tangent[1:], h**2 * bend[:-1], h**2 * bend[1:]
    return np.stack(
        [
            point[:-1],
            m0,
            0.5 * a0,
            10.0 * p - 6.0 * m0 - 4.0 * m1 - 1.5 * a0 + 0.5 * a1,
            -15.0 * p + 8.0 * m0 + 7.0 * m1 + 1.5 * a0 - a1,
            6.0 * p - 3.0 * (m0 + m1) + 0.5 * (a1 - a0),
        ],
        axis=1,
    )


def _evaluated(
    coefficients: np.ndarray, share: np.ndarray, lengths: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points, and their first and second derivative by the arc length, (..., d), of pieces (..., 6, d) at shares (...,)."""
    x, h = share[..., None], lengths[..., None]
    c0, c1, c2, c3, c4, c5 = (coefficients[..., power, :] for power in range(6))
    point = c0 + x * (c1 + x * (c2 + x * (c3 + x * (c4 + x * c5))))
    slope = (c1 + x * (2.0 * c2 + x * (3.0 * c3 + x * (4.0 * c4 + x * 5.0 * c5)))) / h
    bend = (2.0 * c2 + x * (6.0 * c3 + x * (12.0 * c4 + x * 20.0 * c5))) / h**2
    return point, slope, bend
