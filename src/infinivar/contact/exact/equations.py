"""Slip of one patch by creepages and tractions, for all of its cells or for one half of a mirrored state."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np

from infinivar.contact.exact.grid import Floats, Grid
from infinivar.contact.exact.influence import Influence, influence
from infinivar.contact.exact.newton import Friction


@dataclass(frozen=True, slots=True, eq=False)
class Equations:
    """Linear equations of one patch. Tractions act on the wheel here, against its slip.

    Attributes
    ----------
    grid : Grid               The cells.
    mirrored : bool           Whether only cells with y > 0 count, and those with y < 0 mirror them.
    influence : Influence     Displacements and slip by tractions.
    friction : Friction       Slip half a cell ahead, and bounds.
    ahead, behind : (3, 2, n) Slip of rigid bodies under a unit of longitudinal and lateral creepage and spin, half a cell
        ahead of the cells' middles and half a cell behind. [-]
    """

    grid: Grid
    mirrored: bool
    influence: Influence
    friction: Friction
    ahead: Floats
    behind: Floats

    def free_slip(self, creepage: Floats) -> Floats:
        """Slip of rigid bodies half a cell ahead of the cells' middles, (2, n)."""
        return np.tensordot(creepage, self.ahead, axes=1)

    def slip(self, creepage: Floats, traction: Floats) -> Floats:
        """Steady slip in the middle of each cell, the mean of that ahead and behind, (2, n)."""
        rigid = np.tensordot(creepage, self.ahead + self.behind, axes=1)
        return 0.5 * (rigid + times(self.influence.ahead, traction) + times(self.influence.behind, traction))

    def folded(self, vectors: Floats) -> Floats:
        """Vectors (2, rows, cells) in the cells of these equations, (2, n)."""
        return vectors[:, self.grid.counted(self.mirrored)].reshape(2, -1)

    def unfolded(self, vectors: Floats) -> Floats:
        """Vectors (2, n) in all cells, (2, rows, cells)."""
        x, y = (self.unfolded_scalar(part) for part in vectors)
        if self.mirrored:
            x[: self.grid.rows // 2] *= -1.0
        return np.stack([x, y])

    def unfolded_scalar(self, values: np.ndarray) -> np.ndarray:
        """Values (n,) in all cells, (rows, cells), equal in both halves."""
        rows = values.reshape(-1, self.grid.cells)
        return np.concatenate([rows[::-1], rows]) if self.mirrored else rows


@functools.lru_cache(maxsize=8)
def equations(grid: Grid, poisson: float, mirrored: bool) -> Equations:
    """Equations of a patch; `mirrored` for lateral creepage and spin of a symmetric one."""
    rows = grid.counted(mirrored)
    maps = influence(grid, poisson, mirrored)
    x, length = grid.x[rows], grid.length[rows, None]
    y = np.broadcast_to(grid.y[rows, None], x.shape).ravel()
    one, none = np.ones(x.size), np.zeros(x.size)

    def rigid(place: float) -> Floats:
        return np.array([[one, none], [none, one], [-y, (x + place * length).ravel()]])

    return Equations(grid, mirrored, maps, Friction.of(maps.ahead, grid.bound[rows]), rigid(0.5), rigid(-0.5))


def times(matrix: Floats, traction: Floats) -> Floats:
    """Product of a matrix (2 n, 2 n) with vectors (2, n), (2, n)."""
    return (matrix @ traction.ravel()).reshape(2, -1)


def totals(grid: Grid, traction: Floats) -> Floats:
    """Forces along x and y and the moment about the normal of tractions (2, rows, cells): (3,)."""
    fx, fy = grid.area * traction
    return np.array([fx.sum(), fy.sum(), (grid.x * fy - grid.y[:, None] * fx).sum()])
