"""Tractions in rolling contact with dry friction: a semismooth Newton iteration on a projection."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from infinivar.contact.exact.grid import Floats

SETTLED = 1e-8
"""Residual at which an iteration has converged: error of the projected tractions relative to these, both as 2-norms."""

_STEPS = 80
_DAMPING, _TRIES = 0.4, 4

_TINY = 1e-100
"""In place of a slip of 0 in a denominator; its square is not 0."""

Outcome = Literal["converged", "too few cells", "not converged"]


class Solution(NamedTuple):
    """Tractions that a Newton iteration found.

    Attributes
    ----------
    traction : (2, n)    [-]
    slip : (2, n)        Slip that they oppose, see `Friction.opposed`. [-]
    slides : (n,) bool   Cells on their friction bound.
    steps : int
    outcome : Outcome
    """

    traction: Floats
    slip: Floats
    slides: np.ndarray
    steps: int
    outcome: Outcome


@dataclass(frozen=True, slots=True, eq=False)
class Friction:
    """Slip that depends linearly on tractions which friction bounds.

    Attributes
    ----------
    matrix : (2 n, 2 n)   Slip by traction. [-]
    bound : (n,)          Largest traction. [-]
    weight : (n,)         Traction by slip in the projection. The reciprocal row sums of the matrix make it contract. Larger
        ones, 0.3 to 1 over the diagonal, save a tenth of the steps of a rolling patch, but fail without rolling.
    after : (n,) int      The cell ahead of each in its row; the first cell's own number.
    """

    matrix: Floats
    bound: Floats
    weight: Floats
    after: np.ndarray

    @classmethod
    def of(cls, matrix: Floats, bound: Floats) -> Friction:
        """With the weights that the matrix asks for, for bounds (rows, cells)."""
        sums = np.abs(matrix).sum(axis=1).reshape(2, -1)
        after = np.arange(bound.size).reshape(bound.shape)
        after[:, :-1] += 1
        return cls(matrix, bound.ravel(), 1.0 / sums.max(axis=0), after.ravel())

    def solve(self, free_slip: Floats, start: Floats | None = None) -> Solution:
        r"""Tractions p with ``p = projection(p - weight * slip)`` onto the discs of the bounds.

        A cell sticks where ``z = p - weight * slip`` lies within its bound: there the slip is to vanish. Elsewhere the
        traction lies on the bound with the direction of z, only its angle varies, and slip across it is to vanish; the slip
        along it, which must oppose the traction, enters the diagonal. Steps that enlarge the residual are shortened.

        Parameters
        ----------
        free_slip : (2, n)   Slip without tractions. [-]
        start : (2, n)       Tractions to begin with; none by default. [-]

        Returns
        -------
        Solution   Whose tractions are nan if the iteration has not converged.

        Source: hueber2008 for semismooth Newton methods with friction; the weights and the damping are this program's own.
        """
        traction = np.zeros_like(free_slip) if start is None else start
        slip, z, residual = self._state(free_slip, traction)
        steps = 0
        while residual > SETTLED and steps < _STEPS:
            traction, slip, z, residual = self._step(free_slip, traction, z, residual)
            steps += 1
        slides = np.hypot(*z) > self.bound
        if not residual <= SETTLED:
            nothing = np.full_like(traction, np.nan)
            return Solution(nothing, nothing, slides, steps, "not converged")
        return Solution(traction, slip, slides, steps, "converged")

    def _state(self, free_slip: Floats, traction: Floats) -> tuple[Floats, Floats, float]:
        """Slip half a cell ahead, z and residual."""
        slip = free_slip + (self.matrix @ traction.ravel()).reshape(2, -1)
        z = traction - self.weight * opposed(slip, self.after)
        size = np.hypot(*z)
        projected = z * np.minimum(1.0, self.bound / np.maximum(size, self.bound))
        size = max(float(np.linalg.norm(projected)), _TINY)
        return slip, z, float(np.linalg.norm(traction - projected)) / size

    def _step(
        self, free_slip: Floats, traction: Floats, z: Floats, residual: float
    ) -> tuple[Floats, Floats, Floats, float]:
        """One step: tractions, slip, z and residual."""
        size = np.hypot(*z)
        slides = size > self.bound
        traction = np.where(slides, self.bound * z / np.where(slides, size, 1.0), traction)
        slip = free_slip + (self.matrix @ traction.ravel()).reshape(2, -1)
        change = Change(self, traction, slip, slides)
        step = change.solve(-change.residual)
        scale = 1.0
        for attempt in range(_TRIES):
            moved = change.moved(traction, scale * step)
            slip, z, smaller = self._state(free_slip, moved)
            if smaller < residual or attempt == _TRIES - 1:
                break
            scale *= _DAMPING
        return moved, slip, z, smaller  # pyright: ignore[reportPossiblyUnboundVariable]


class Change:
    """Linear equations for a change of tractions: both components where a cell sticks, the angle where it slides."""

    def __init__(self, friction: Friction, traction: Floats, slip: Floats, slides: np.ndarray) -> None:
        """At the given tractions, which lie on the bound wherever a cell slides."""
        n = len(friction.bound)
        self.sticking, self.sliding = np.flatnonzero(~slides), np.flatnonzero(slides)
        self.both = np.concatenate([self.sticking, self.sticking + n])
        self.bound = friction.bound[self.sliding]
        self.direction = traction[:, self.sliding] / self.bound
        across_x, across_y = -self.direction[1], self.direction[0]
        self.across = np.stack([across_x, across_y])

        sliding = self.sliding
        after = friction.after[sliding]
        middle = opposed(slip, friction.after)[:, sliding]
        self.own, self.ahead = _by_slip(slip[:, sliding], slip[:, after], self.across)
        self.after = after
        self.residual = np.concatenate([slip[:, self.sticking].ravel(), np.sum(self.across * middle, axis=0)])
        x, y = friction.matrix[:n], friction.matrix[n:]
        rows = np.concatenate(
            [
                friction.matrix[self.both],
                self.own[0][:, None] * x[sliding]
                + self.own[1][:, None] * y[sliding]
                + self.ahead[0][:, None] * x[after]
                + self.ahead[1][:, None] * y[after],
            ]
        )
        k = len(self.both)
        self.matrix = np.empty((len(rows), len(rows)))
        self.matrix[:, :k] = rows[:, self.both]
        self.matrix[:, k:] = rows[:, sliding] * across_x + rows[:, sliding + n] * across_y
        along = np.sum(self.direction * middle, axis=0)
        index = np.arange(k, len(rows))
        self.matrix[index, index] += np.maximum(-along, 0.0) / self.bound

    def by_slip(self, change: Floats) -> Floats:
        """Change of the residual with a change of the slip half a cell ahead, (2, n)."""
        across = np.sum(self.own * change[:, self.sliding] + self.ahead * change[:, self.after], axis=0)
        return np.concatenate([change[:, self.sticking].ravel(), across])

    def solve(self, right: Floats) -> Floats:
        """Changes of the unknowns."""
        return np.linalg.solve(self.matrix, right)

    def moved(self, traction: Floats, step: Floats) -> Floats:
        """Tractions after a step, turned along the bound where a cell slides."""
        k = len(self.both)
        moved = traction.copy()
        moved[:, self.sticking] += step[:k].reshape(2, -1)
        turn = np.arctan(step[k:] / self.bound)
        moved[:, self.sliding] = self.bound * (self.direction * np.cos(turn) + self.across * np.sin(turn))
        return moved

    def tractions(self, step: Floats) -> Floats:
        """Changes of the tractions with the unknowns, to first order: (2, n)."""
        k = len(self.both)
        change = np.zeros((2, len(self.sticking) + len(self.sliding)))
        change[:, self.sticking] = step[:k].reshape(2, -1)
        change[:, self.sliding] = self.across * step[k:]
        return change


def opposed(slip: Floats, after: np.ndarray) -> Floats:
    r"""Slip in the middle of each cell, whose direction the traction opposes.

    It is extrapolated from the slips half a cell ahead of it, s, and of the cell ahead, s', by

    .. math:: s + \tfrac12 \min(1, |s|/|s'|) (s - s'),

    so that its direction does not err by the turn along half a cell. It vanishes only with s. The mean of the slips ahead
    and behind would not see slip that alternates from cell to cell.

    Parameters
    ----------
    slip : (2, n)      Slip half a cell ahead of each cell. [-]
    after : (n,) int   The cell ahead of each.

    Returns
    -------
    (2, n)   [-]
    """
    next_slip = slip[:, after]
    return slip + 0.5 * _share(slip, next_slip) * (slip - next_slip)


def _share(slip: Floats, next_slip: Floats) -> Floats:
    """min(1, |s|/|s'|)."""
    size, next_size = np.hypot(*slip), np.hypot(*next_slip)
    return size / np.maximum(np.maximum(size, next_size), _TINY)


def _by_slip(slip: Floats, next_slip: Floats, across: Floats) -> tuple[Floats, Floats]:
    """Derivatives of the component `across` of `opposed` by the components of s and of s', (2, n) each."""
    share = _share(slip, next_slip)
    limited = 0.5 * (share < 1.0) * np.sum(across * (slip - next_slip), axis=0)
    size, next_size = np.maximum(np.hypot(*slip), _TINY), np.maximum(np.hypot(*next_slip), _TINY)
    own = (1.0 + 0.5 * share) * across + limited * slip / (size * next_size)
    return own, -0.5 * share * across - limited * share * next_slip / next_size**2
