"""Smooth curves through tables: interpolating splines over any array namespace, with a stated continuation beyond the table."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from infinivar._core.array_namespace import Array, namespace

DEGREE = 5
"""Highest degree of a spline; four derivatives are then continuous."""

Beyond = Literal["line", "constant"]
"""Continuation beyond the table: along the tangent at its end, or at its last value."""


@dataclass(frozen=True, slots=True)
class Pieces:
    """Piecewise polynomial: ``sum over k of coefficients[k][i] (x - anchors[i])^k`` between edges ``i - 1`` and ``i``."""

    edges: tuple[float, ...]
    anchors: tuple[float, ...]
    coefficients: tuple[tuple[float, ...], ...]

    def derivatives(self, x: Array, orders: int) -> list[Array]:
        """Value and derivatives by x up to an order.

        Parameters
        ----------
        x : (...,) float   Any value; the outermost pieces continue without end.
        orders : int       Highest derivative, >= 0.

        Returns
        -------
        list of (...,) float
        """
        anchor, *terms = self._selected(x)
        since = x - anchor
        found = []
        for order in range(orders + 1):
            value: Array = 0.0 * since
            for k in range(len(terms) - 1, order - 1, -1):
                value = value * since + math.perm(k, order) * terms[k]
            found.append(value)
        return found

    def _selected(self, x: Array) -> list[Array]:
        """Anchor and coefficients of the piece that contains x."""
        xp = namespace(x)
        if xp is np:  # a hysteresis that is inverted asks this hundreds of thousands of times
            edges, rows = _table(self)
            return list(rows[:, np.searchsorted(edges, x)])
        return [_bisected(xp, x, self.edges, values) for values in (self.anchors, *self.coefficients)]

    def integral(self) -> Pieces:
        """Antiderivative that is 0 at x = 0."""
        rows = [[0.0] * len(self.anchors), *([c / k for c in row] for k, row in enumerate(self.coefficients, 1))]
        for place, edge in enumerate(self.edges, 1):
            before, here = self.anchors[place - 1], self.anchors[place]
            rows[0][place] = sum(
                row[place - 1] * (edge - before) ** k - (row[place] * (edge - here) ** k if k else 0.0)
                for k, row in enumerate(rows)
            )
        raw = Pieces(self.edges, self.anchors, tuple(tuple(row) for row in rows))
        start = float(raw.derivatives(np.float64(0.0), 0)[0])
        return Pieces(self.edges, self.anchors, (tuple(c - start for c in rows[0]), *raw.coefficients[1:]))

    def lowest(self, order: int) -> tuple[float, float]:
        """Place and value of the lowest value of a derivative of this order between the first and last edge."""
        least = (self.edges[0], math.inf)
        for place in range(1, len(self.edges)):
            low, high, anchor = self.edges[place - 1], self.edges[place], self.anchors[place]
            polynomial = np.polynomial.Polynomial([row[place] for row in self.coefficients]).deriv(order)
            turns = polynomial.deriv().roots() if polynomial.degree() > 1 else np.zeros(0)
            inside = [anchor + root.real for root in turns if low < anchor + root.real < high]
            for x in (low, *inside, high):
                value = float(polynomial(x - anchor))
                if value < least[1]:
                    least = (x, value)
        return least


def _bisected(xp: Array, x: Array, edges: tuple[float, ...], values: tuple[float, ...]) -> Array:
    """Value of the interval between edges that contains x; choices nest as deep as the logarithm of their number."""
    if not edges:
        return values[0]
    middle = len(edges) // 2
    above = _bisected(xp, x, edges[middle + 1 :], values[middle + 1 :])
    below = _bisected(xp, x, edges[:middle], values[: middle + 1])
    return xp.where(x > edges[middle], above, below)


@functools.lru_cache(maxsize=64)
def _table(pieces: Pieces) -> tuple[np.ndarray, np.ndarray]:
    """Edges, and a row of anchors above one row for each power."""
    return np.array(pieces.edges), np.array([pieces.anchors, *pieces.coefficients])


@functools.lru_cache(maxsize=64)
def through(x: tuple[float, ...], y: tuple[float, ...], beyond: Beyond) -> Pieces:
    """Interpolating spline through a table, of degree five or one less than the number of rows.

    Parameters
    ----------
    x, y : tuple of at least two floats   x increases.
    beyond                                Continuation beyond the table.

    Source: deboor2001, chapter XIII (not-a-knot end conditions).
    """
    from scipy.interpolate import PPoly, make_interp_spline

    spline = make_interp_spline(np.array(x), np.array(y), k=min(DEGREE, len(x) - 1))
    pieces = PPoly.from_spline(spline)
    kept = np.flatnonzero((np.diff(pieces.x) > 0) & (pieces.x[:-1] >= x[0]) & (pieces.x[1:] <= x[-1]))
    rows = pieces.c[::-1, kept]
    edges = (*pieces.x[kept].tolist(), x[-1])
    slopes = [float(spline(end, 1)) if beyond == "line" else 0.0 for end in (x[0], x[-1])]
    coefficients = []
    for k, row in enumerate(rows):
        tails = (y[0], y[-1]) if k == 0 else slopes if k == 1 else (0.0, 0.0)
        coefficients.append((float(tails[0]), *row.tolist(), float(tails[1])))
    return Pieces(edges, (edges[0], *edges[:-1], edges[-1]), tuple(coefficients))
