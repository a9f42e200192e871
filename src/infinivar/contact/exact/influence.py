"""Displacements and slip of two half-spaces under tangential tractions that are constant in each cell."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np

from infinivar.contact.exact.grid import Floats, Grid


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
    sums = _corner_sums(grid)
    k, k_turned, r = sums
    parts = np.stack([(1.0 - poisson) * k + k_turned, -poisson * r, (1.0 - poisson) * k_turned + k]) / np.pi
    if mirrored:
        half = grid.cells // 2
        upper = parts[:, half:]
        own, image = upper[..., half:, :], upper[..., half - 1 :: -1, :]
        xx, xy, yy = own[0] - image[0], own[1] + image[1], own[2] + image[2]
        yx = own[1] - image[1]
        length = grid.length[half:]
    else:
        (xx, xy, yy), yx, length = parts, parts[1], grid.length

    rows, cells = len(length), grid.cells
    blocks = np.stack([np.stack([xx, xy]), np.stack([yx, yy])]).reshape(2, 2, rows, cells + 2, rows * cells)
    slip = (blocks[:, :, :, :-1] - blocks[:, :, :, 1:]) / length[:, None, None]
    return Influence(_square(blocks[:, :, :, 1:-1]), _square(slip[:, :, :, 1:]), _square(slip[:, :, :, :-1]))


def _square(blocks: Floats) -> Floats:
    """Blocks (to x or y, from x or y, row, place, cell) as one matrix."""
    size = 2 * blocks.shape[-1]
    return blocks.transpose(0, 2, 3, 1, 4).reshape(size, size)


@functools.lru_cache(maxsize=2)
def _corner_sums(grid: Grid) -> Floats:
    """Sums over the corners of K, K' and R, (3, rows, cells + 2, rows, cells): of all cells at places along each row.

    The places are the cells' middles, one before the first and one after the last.
    """
    length = grid.length[:, None]
    middles = np.concatenate([grid.x[:, :1] - length, grid.x, grid.x[:, -1:] + length], axis=1)
    edges = np.concatenate([grid.x - 0.5 * length, grid.x[:, -1:] + 0.5 * length], axis=1)
    x = middles[:, :, None, None] - edges
    size = np.maximum(np.abs(x), 1e-300)
    apart = (grid.y[:, None] - grid.y)[:, None, :, None]
    total = np.zeros((3, *x.shape))
    for sign in (1.0, -1.0):
        y = apart + 0.5 * sign * grid.width
        total[0] += sign * x * np.arcsinh(y / size)
        total[1] += sign * y * np.arcsinh(x / np.abs(y))
        total[2] += sign * np.hypot(x, y)
    return total[..., :-1] - total[..., 1:]
