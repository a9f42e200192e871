r"""Radii of a pulley at which a candidate can keep its limits, in closed form.

At the pulley's radius r, friction torque T and inertia J_o, an instant with force, acceleration and speed of the load along the
motion, ``y = (F s, a s, |v|)``, asks for the current

.. math::
    s I = A r + B/r + C, \qquad A = \alpha y_1, \quad B = (\alpha J_o + \beta) y_2 + \gamma y_3, \quad C = \delta + \alpha T,

and so do torque and voltage with other factors. For a bound L of the peak, ``A r^2 + (C - L) r + B <= 0``: as long as friction
alone is below the bound, C < L, the radii are one interval, whose ends are roots of this quadratic. The mean square is
``a r^2 + b r + c + d/r + e/r^2``; where that is convex in r or in 1/r, the radii within a bound are one interval, too. It is
convex in r if d >= 0, as in every closed cycle, in which ``mean(a s) = 0``.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from infinivar.sizing.geared.extremes import highest_places

_HALVINGS = 48
"""Bisections of a range of radii on a logarithmic scale: to rounding."""
_ROWS = 512
"""Candidates handled at once, so that intermediate arrays stay small."""


class Radii(NamedTuple):
    """Least and largest radius of many candidates; the least above the largest where there is none. (k,), (k,) [m]"""

    low: np.ndarray
    high: np.ndarray

    @property
    def empty(self) -> np.ndarray:
        """Candidates without a radius. (k,) bool"""
        return ~(self.low <= self.high)

    def both(self, other: Radii) -> Radii:
        """Radii within both, which are intervals."""
        return Radii(np.maximum(self.low, other.low), np.minimum(self.high, other.high))

    def either(self, other: Radii) -> Radii:
        """The interval that spans both."""
        low = np.minimum(np.where(self.empty, np.inf, self.low), np.where(other.empty, np.inf, other.low))
        high = np.maximum(np.where(self.empty, 0.0, self.high), np.where(other.empty, 0.0, other.high))
        return Radii(low, high)


def below(linear: np.ndarray, inverse: np.ndarray, constant: np.ndarray, bound: np.ndarray) -> Radii:
    """Radii at which ``linear r + inverse/r + constant <= bound``, or an interval that contains them.

    Parameters
    ----------
    linear, inverse, constant, bound : (...,) float   A, B, C and L; exact unless A, B and L - C are all negative.

    Returns
    -------
    Radii   (...,) Ends from 0 to infinity.

    Source: quadratic formula; the signs of A and B decide which roots are positive (Descartes' rule of signs).
    """
    room = bound - constant
    root = room * room - 4.0 * linear * inverse
    # Without real roots the least comes out above the largest.
    none = (linear >= 0.0) & (inverse >= 0.0) & (room < 0.0)
    both = room + np.sqrt(np.maximum(root, 0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        low = np.where((inverse > 0.0) & (both > 0.0), 2.0 * inverse / both, 0.0)
        high = np.where(linear > 0.0, both / (2.0 * linear), np.inf)
    return Radii(np.where(none, np.inf, low), np.where(none, 0.0, high))


def all_below(points: np.ndarray, factors: tuple[np.ndarray, ...], bound: np.ndarray, *, sign: float = 1.0) -> Radii:
    """Radii at which instants keep a bound on ``sign (A r + B/r + C)``, for many candidates.

    Parameters
    ----------
    points : (n, 3) float   y of the instants.
    factors : 4 x (k,) float   Of y_1 in A, of y_2 and y_3 in B, none below 0; and C.
    bound : (k,) float      L.
    """
    count = len(bound)
    low, high = np.zeros(count), np.full(count, np.inf)
    if not len(points):
        return Radii(low, high)
    # The signal rises in every coordinate of y.
    signed = sign * points
    force, acceleration, speed = signed[highest_places(signed)].T
    for start in range(0, count, _ROWS):
        rows = slice(start, start + _ROWS)
        first, second, third, constant = (factor[rows, None] for factor in factors)
        found = below(first * force, second * acceleration + third * speed, sign * constant, bound[rows, None])
        low[rows], high[rows] = found.low.max(axis=-1), found.high.min(axis=-1)
    return Radii(low, high)


class Laurent(NamedTuple):
    """``a r^2 + b r + c + d/r + e/r^2`` for many candidates. (k,) each"""

    a: np.ndarray
    b: np.ndarray
    c: np.ndarray
    d: np.ndarray
    e: np.ndarray

    def at(self, radius: np.ndarray) -> np.ndarray:
        """Value at a radius of each candidate."""
        inverse = 1.0 / radius
        return (self.a * radius + self.b) * radius + self.c + (self.d + self.e * inverse) * inverse

    def slope(self, radius: np.ndarray) -> np.ndarray:
        """Derivative at a radius of each candidate."""
        inverse = 1.0 / radius
        return 2.0 * self.a * radius + self.b - (self.d + 2.0 * self.e * inverse) * inverse * inverse

    def plus(self, other: Laurent) -> Laurent:
        """Sum of both."""
        return Laurent(*(one + another for one, another in zip(self, other, strict=True)))

    @property
    def convex(self) -> np.ndarray:
        """Whether convex in r, or in 1/r, over all r > 0. (k,) bool

        ``r^4`` times the second derivative is ``2 (a r^4 + d r + 3 e)``, whose least value, at ``r^3 = -d/(4 a)``, is
        ``3/2 d r + 6 e``; in 1/r a and e, b and d change places.
        """
        return _convex(self.a, self.d, self.e) | _convex(self.e, self.b, self.a)

    def times(self, factor: np.ndarray) -> Laurent:
        """Product with a number of each candidate."""
        return Laurent(*(factor * one for one in self))

    def least_in(self, edges: np.ndarray) -> np.ndarray:
        """Lower bound in each cell between rising radii (k, n + 1): the sum of each term's least value there. (k, n)"""
        total = self.c[:, None]
        for factor, power in (
            (self.a, edges * edges),
            (self.b, edges),
            (self.d, 1.0 / edges),
            (self.e, 1.0 / (edges * edges)),
        ):
            term = factor[:, None] * power
            total = total + np.minimum(term[:, 1:], term[:, :-1])
        return total


def _convex(a: np.ndarray, d: np.ndarray, e: np.ndarray) -> np.ndarray:
    with np.errstate(divide="ignore", invalid="ignore"):
        place = np.cbrt(-d / (4.0 * a))
        dips = 1.5 * d * place + 6.0 * e >= 0.0
    return (a >= 0.0) & (e >= 0.0) & ((d >= 0.0) | ((a > 0.0) & dips))


class Resting(NamedTuple):
    """Mean over all instants of ``max(A F r - C, 0)^2`` at rest: convex and rising in r, and convex in 1/r."""

    forces: np.ndarray
    """In rising order. (m,) [N]"""
    sums: np.ndarray
    """Number, sum and sum of squares of the largest of them, without the first 0 to m. (m + 1, 3)"""
    instants: int
    """Number of instants."""
    linear: np.ndarray
    """A. (k,)"""
    friction: np.ndarray
    """C >= 0. (k,)"""

    def at(self, radius: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Value and derivative at a radius of each candidate."""
        if not self.forces.size:
            return np.zeros(len(radius)), np.zeros(len(radius))
        gain = self.linear * radius
        with np.errstate(divide="ignore", invalid="ignore"):
            first = np.searchsorted(self.forces, np.where(gain > 0.0, self.friction / gain, np.inf))
        number, force, square = np.moveaxis(self.sums[first], -1, 0)
        value = gain * gain * square - 2.0 * gain * self.friction * force + self.friction**2 * number
        rise = 2.0 * self.linear * (gain * square - self.friction * force)
        return np.maximum(value, 0.0) / self.instants, np.maximum(rise, 0.0) / self.instants


def mean_square_below(
    moving: Laurent, resting: Resting | None, bound: np.ndarray, within: tuple[float, float]
) -> Radii:
    """Radii of a range at which a mean square keeps a bound, for many candidates.

    Parameters
    ----------
    moving : Laurent            Of the instants in motion.
    resting : Resting           Of those at rest.
    bound : (k,) float          On the mean square.
    within : (float, float)     Least and largest radius to consider. [m]

    Returns
    -------
    Radii   The range itself where no proof of convexity holds.
    """
    shape = np.shape(bound)

    def excess(radius: np.ndarray) -> np.ndarray:
        value = moving.at(radius) - bound
        return value if resting is None else value + resting.at(radius)[0]

    def slope(radius: np.ndarray) -> np.ndarray:
        value = moving.slope(radius)
        return value if resting is None else value + resting.at(radius)[1]

    low, high = np.full(shape, within[0]), np.full(shape, within[1])
    least = _halved(lambda radius: slope(radius) > 0.0, low, high)
    # The halves end beside the root, and the least value of a range without one is at its end.
    for end in (low, high):
        least = np.where(excess(end) < excess(least), end, least)
    fits = excess(least) <= 0.0
    left = _halved(lambda radius: excess(radius) <= 0.0, low, least)
    right = _halved(lambda radius: excess(radius) > 0.0, least, high)
    left, right = np.where(excess(low) <= 0.0, low, left), np.where(excess(high) <= 0.0, high, right)
    known = moving.convex
    return Radii(np.where(known, np.where(fits, left, np.inf), low), np.where(known, np.where(fits, right, 0.0), high))


def _halved(beyond: object, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Place at which a condition begins to hold, between ends of a range, on a logarithmic scale."""
    low, high = np.log(low), np.log(high)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        holds = beyond(np.exp(middle))  # type: ignore[operator]
        low, high = np.where(holds, low, middle), np.where(holds, middle, high)
    return np.exp(0.5 * (low + high))
