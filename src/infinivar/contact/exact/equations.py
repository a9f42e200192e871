"""Slip of one patch by creepages and tractions, for all of its cells or for one half of a mirrored state.

Two half-spaces deform under tangential tractions that are constant in each cell.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Literal

import numpy as np

from infinivar.contact.exact.grid import Floats, Grid
from infinivar.contact.exact.newton import Friction

Places = Literal["middles", "borders"]


@dataclass(frozen=True, slots=True, eq=False)
class Influence:
    """Linear maps from tractions (x of all cells, then y of all cells) to places of as many cells.

    Attributes
    ----------
    displacement : (2 n, 2 n)   Difference of the two surfaces' displacements in the middle of each cell. [-]
    ahead, behind : (2 n, 2 n)  Elastic part of the slip per distance rolled, half a cell ahead of the middles and half a
        cell behind them. [-]
    """

    displacement: Floats
    ahead: Floats
    behind: Floats


@functools.lru_cache(maxsize=4)
def influence(grid: Grid, poisson: float, mirrored: bool) -> Influence:
    r"""Influence of the cells of a grid on each other.

    The displacements of the surfaces, in units of the load times the friction coefficient over shear modulus and length, are
    sums over the corners (X, Y) of each loaded cell as seen from the point, of

    .. math:: \pi A_{xx} = (1-\nu) K + K', \quad \pi A_{xy} = -\nu R, \quad \pi A_{yy} = (1-\nu) K' + K, \qquad
        K = X \operatorname{asinh}\frac{Y}{|X|}, \quad K' = Y \operatorname{asinh}\frac{X}{|Y|}, \quad R = \sqrt{X^2+Y^2}.

    Parameters
    ----------
    grid : Grid        The cells.
    poisson : float    Poisson ratio. [-]
    mirrored : bool    Only the half y > 0 of a symmetric patch, with tractions along x that change sign with y and tractions
        along y that do not, as lateral creepage and spin cause them.

    Returns
    -------
    Influence   Of all cells of the grid, or of those with y > 0, row by row.

    Source: kalker1990, the displacements of a half-space under a loaded rectangle.
    """
    blocks = _blocks(grid, poisson, mirrored, "middles")
    length = grid.length[grid.counted(mirrored)]
    slip = (blocks[:, :, :, :-1] - blocks[:, :, :, 1:]) / length[:, None, None]
    return Influence(_square(blocks[:, :, :, 1:-1]), _square(slip[:, :, :, 1:]), _square(slip[:, :, :, :-1]))


@functools.lru_cache(maxsize=2)
def half_cell_displacements(grid: Grid, poisson: float, mirrored: bool) -> tuple[Floats, Floats]:
    """Displacements where slip is taken: half a cell ahead of the cells' middles and half a cell behind.

    Parameters
    ----------
    grid, poisson, mirrored   As for `influence`.

    Returns
    -------
    ahead, behind : (2 n, 2 n)   Maps from tractions. [-]

    Source: as `influence`.
    """
    blocks = _blocks(grid, poisson, mirrored, "borders")
    return _square(blocks[:, :, :, 1:]), _square(blocks[:, :, :, :-1])


def _blocks(grid: Grid, poisson: float, mirrored: bool, places: Places) -> Floats:
    """Displacements (to x or y, from x or y, row, place, cell)."""
    k, k_turned, r = _corner_sums(grid, places)
    parts = np.stack([(1.0 - poisson) * k + k_turned, -poisson * r, (1.0 - poisson) * k_turned + k]) / np.pi
    rows = grid.rows
    if mirrored:
        rows //= 2
        upper = parts[:, rows:]
        own, image = upper[..., rows:, :], upper[..., rows - 1 :: -1, :]
        xx, xy, yy = own[0] - image[0], own[1] + image[1], own[2] + image[2]
        yx = own[1] - image[1]
    else:
        (xx, xy, yy), yx = parts, parts[1]
    return np.stack([np.stack([xx, xy]), np.stack([yx, yy])]).reshape(2, 2, rows, -1, rows * grid.cells)


def _square(blocks: Floats) -> Floats:
    """Blocks (to x or y, from x or y, row, place, cell) as one matrix."""
    size = 2 * blocks.shape[-1]
    return blocks.transpose(0, 2, 3, 1, 4).reshape(size, size)


@functools.lru_cache(maxsize=2)
def _corner_sums(grid: Grid, places: Places) -> Floats:
    """Sums over the corners of K, K' and R, (3, rows, places, rows, cells): of all cells at places along each row.

    The places are the cells' middles, one before the first and one after the last; or the borders between cells.
    """
    length = grid.length[:, None]
    edges = np.concatenate([grid.x - 0.5 * length, grid.x[:, -1:] + 0.5 * length], axis=1)
    at = edges
    if places == "middles":
        at = np.concatenate([grid.x[:, :1] - length, grid.x, grid.x[:, -1:] + length], axis=1)
    x = at[:, :, None, None] - edges
    size = np.maximum(np.abs(x), 1e-300)
    apart = (grid.y[:, None] - grid.y)[:, None, :, None]
    total = np.zeros((3, *x.shape))
    for sign in (1.0, -1.0):
        y = apart + 0.5 * sign * grid.width
        total[0] += sign * x * np.arcsinh(y / size)
        total[1] += sign * y * np.arcsinh(x / np.abs(y))
        total[2] += sign * np.hypot(x, y)
    return total[..., :-1] - total[..., 1:]


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
