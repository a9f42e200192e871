r"""Kalker's simplified theory with longitudinal and lateral creep and spin: the FASTSIM algorithm for many contacts.

The surface is a bed of independent springs, with one flexibility for each kind of creep,

.. math:: L_1 = \frac{8 a}{3 C_{11} G}, \qquad L_2 = \frac{8 a}{3 C_{22} G}, \qquad
    L_3 = \frac{\pi a^2}{4 C_{23} G \sqrt{a b}},

so that small creepages give the forces of Kalker's linear theory. With creepages scaled by those forces, the only
remaining parameters are a/b and, for the exact direction of slip, C11/C22.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from infinivar._core.array_namespace import Array, _repeat, as_floats, namespace
from infinivar.errors import ParameterError

_BLOCK = 3200
"""Strips per pass with NumPy, so that the dozen arrays of a pass stay in the second-level cache."""


class PatchForces(NamedTuple):
    """Forces of a contact patch on the track; a positive creepage causes a positive force.

    Attributes
    ----------
    fx, fy : (...,) float    Longitudinal and lateral force over mu N. [-]
    mz : (...,) float        Moment about the contact normal over mu N sqrt(a b). [-]
    slip_share : (...,) float   Fraction of the patch area that slips, in whole cells. [-]
    """

    fx: Array
    fy: Array
    mz: Array
    slip_share: Array


def forces(
    k_x: Array,
    k_y: Array,
    psi: Array = 0.0,
    a_over_b: Array = 1.0,
    c11_over_c22: Array = 1.0,
    *,
    cells: int = 50,
    strips: int = 50,
) -> PatchForces:
    r"""Forces of an elliptic contact in steady rolling with creep and spin.

    With coordinates scaled by a and b, tractions scaled by ``2 mu N/(pi a b)`` and ``w = 9 pi k/32``, the tractions are
    zero at the leading edge of each strip and grow along it by

    .. math:: -\frac{\partial p_x}{\partial x} = 2 w_x - 2 \psi \frac{b}{a} y, \qquad
        -\frac{\partial p_y}{\partial x} = 2 w_y + 2 \psi x,

    and where their resultant exceeds the bound ``1 - x^2 - y^2`` it is reduced to the bound. FASTSIM keeps the direction,
    which is exact for equal flexibilities. If L1 and L2 differ, the slip is the traction removed times the flexibilities
    and must be parallel to the traction. With ``q = sqrt(C11/C22)`` and the relative excess r over the bound,

    .. math:: p_x \propto p_x^* (1 + r/q), \qquad p_y \propto p_y^* (1 + r q).

    Parameters
    ----------
    k_x, k_y : (...,) float   C11 G a b ux/(3 mu N) and C22 G a b uy/(3 mu N) with the creepages ux, uy; finite. [-]
    psi : (...,) float        Spin, C23 G (a b)^1.5 phi/(mu N); finite. [-]
    a_over_b : (...,) float   Rolling over lateral semi-axis of the patch, > 0, else nan. It matters only with spin. [-]
    c11_over_c22 : (...,) float   Kalker's coefficients; 1 is FASTSIM as published. [-]
    cells : int               Cells along each strip. [-]
    strips : int              Number of strips. [-]

    Returns
    -------
    PatchForces
        Inputs broadcast.

    Raises
    ------
    ParameterError
        If `cells` or `strips` is below 1.

    Notes
    -----
    Strips subtend equal angles, so they are narrower towards the sides; each cell holds the mean of its traction and of its
    bound. The linear forces ``3 k_x`` and ``3 k_y + psi``, and gross slip in one direction, are therefore exact for any
    number of cells. In between, 50 x 50 cells leave an error of 3e-4 of mu N relative to infinitely many, falling with the
    square of the number, as long as the traction keeps its direction; elsewhere the error is up to 8e-3 and proportional to
    the cell length, because the direction of slip lags by part of a cell. The moment has the correct sign but not Kalker's
    coefficients: in a bed of springs its lever arm is too short.

    Source: kalker1982, with kalker1990 for the flexibilities.
    """
    for name, number in (("cells", cells), ("strips", strips)):
        if number < 1:
            raise ParameterError(f"{name} must be >= 1, got {number}")
    arguments = (k_x, k_y, psi, a_over_b, c11_over_c22)
    xp = namespace(*arguments)
    given = xp.broadcast_arrays(*as_floats(xp, *arguments))
    shape = given[0].shape
    columns = [xp.reshape(value, (-1, 1)) for value in given]
    count, block = columns[0].shape[0], max(1, _BLOCK // strips)
    if xp.__name__ != "numpy" or count <= block:
        return PatchForces(*(xp.reshape(part, shape) for part in _march(xp, cells, strips, *columns)))
    parts = [
        _march(xp, cells, strips, *(column[start : start + block] for column in columns))
        for start in range(0, count, block)
    ]
    return PatchForces(*(xp.reshape(xp.concat(pieces), shape) for pieces in zip(*parts, strict=True)))


def _march(
    xp: Any, cells: int, strips: int, k_x: Array, k_y: Array, psi: Array, a_over_b: Array, c11_over_c22: Array
) -> tuple[Array, Array, Array, Array]:
    """Components of `PatchForces` for columns of contacts.

    In a strip of half-length c, x is scaled by c and tractions by c^2, so that all strips share cells and bound.
    """
    angle = (xp.arange(strips, dtype=xp.float64) + 0.5) * (math.pi / strips) - 0.5 * math.pi
    y, half = xp.sin(angle), xp.cos(angle)
    step, scale = 2.0 / cells, 9.0 * math.pi / 16.0
    a_over_b = xp.where(a_over_b > 0, a_over_b, xp.nan)
    grow_x = step * (scale * k_x - 2.0 * psi / a_over_b * y) / half
    grow_y = step * scale * k_y / half
    turn = 2.0 * step * psi
    root_ratio = xp.sqrt(c11_over_c22)

    def cell(state: tuple[Array, ...]) -> tuple[Array, ...]:
        """Advance from the means over one cell to those over the next; the growth is that at the edge between them."""
        index, p_x, p_y, sum_x, sum_y, arm, slipping = state
        edge = 1.0 - step * index
        centre = edge - 0.5 * step
        bound = 1.0 - centre * centre - step * step / 12.0
        p_x = p_x + grow_x
        p_y = p_y + (grow_y + turn * edge)
        square = p_x * p_x + p_y * p_y
        slips = square > bound * bound
        excess = xp.sqrt(xp.where(slips, square, bound * bound)) / bound - 1.0
        p_x, p_y = p_x * (1.0 + excess / root_ratio), p_y * (1.0 + excess * root_ratio)
        kept = bound / xp.sqrt(xp.where(slips, p_x * p_x + p_y * p_y, bound * bound))
        p_x, p_y = p_x * kept, p_y * kept
        slipping = slipping + xp.astype(slips, xp.float64)
        return index + 1.0, p_x, p_y, sum_x + p_x, sum_y + p_y, arm + centre * p_y, slipping

    # Start half a step before the leading edge, so that the first cell has its mean.
    none = xp.zeros_like(grow_x)
    before_y = -0.5 * grow_y - psi * (step + step * step / 3.0)
    start = (0.0, -0.5 * grow_x, before_y, none, none, none, none)
    _, _, _, sum_x, sum_y, arm, slipping = _repeat(xp, cell, start, cells)

    weight = (2.0 / strips) * half * half
    area = step * weight * half * half
    root = xp.sqrt(a_over_b)
    return (
        xp.sum(area * sum_x, axis=-1),
        xp.sum(area * sum_y, axis=-1),
        xp.sum(area * (root * half * arm - y / root * sum_x), axis=-1),
        xp.sum(weight * slipping, axis=-1) / cells,
    )
