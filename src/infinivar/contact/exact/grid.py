"""Cells of an elliptical contact patch in rows along the rolling direction, and the friction bound of each."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from infinivar._core.described import at
from infinivar._core.frozen import frozen
from infinivar.errors import ParameterError

Floats = np.ndarray[Any, np.dtype[np.floating[Any]]]

FEWEST, MOST = 4, 60
"""Cells along each side: fewer resolve no stick area; more need gigabytes."""

INSET = 0.1507
"""Part of a cell by which a row is longer than its cells.

Constant tractions reach half of this too far beyond an edge at which the true ones fall with a root: the value makes the
force of the two-dimensional contact without slip exact to first order of the cell's length.
"""

LONGEST = 12.0
"""Length of the longest cells over their width. Longer ones are made wider: with cells 20 times as long as wide and a Poisson
ratio of 0.5, slip by traction is not positive definite and the iteration may not converge."""

AHEAD = 0.25
"""Part of a cell by which all cells lie behind the middle of their row. Slip is taken half a cell ahead of each cell.

Half of that for the slip and half for the traction make lateral force by spin equal to moment by lateral creepage.
"""


CELLS = ("row", "cell")
"""Dimensions of what each cell of a patch has."""

OF_GRID = (
    at("grid.a_over_b", "1", attribute="a_over_b"),
    at("grid.x", "1", "along the rolling direction, over c", CELLS),
    at("grid.y", "1", "lateral, over c", CELLS[:1]),
    at("grid._component", dims=("component",), convert=list),
)
"""What results on a `grid` state of it for their data sets."""


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """Cells of one patch with semi-axes whose product is 1. Rows run along x, the rolling direction, and are ordered by y.

    Attributes
    ----------
    a_over_b : float     Ratio of the semi-axes; at no turn, that along the rolling direction over the other. [-]
    turned : float       Angle from the rolling direction to the first semi-axis, positive towards +y. [rad]
    cells : int          Cells in each row.
    reach : float        Half of the patch's extent in y. [-]
    y : (rows,)          Middle of each row. [-]
    length : (rows,)     Length of each row's cells along x. [-]
    width : float        Width of all cells along y. [-]
    x : (rows, cells)    Middle of each cell, from the trailing edge forwards. [-]
    bound : (rows, cells)   Largest traction under Hertz pressure, with friction times load 1; the forces of all cells add up
        to 1. [-]
    """

    a_over_b: float
    turned: float
    cells: int
    reach: float
    y: Floats
    length: Floats
    width: float
    x: Floats
    bound: Floats

    def __reduce__(self) -> tuple[Callable[..., Grid], tuple[float, float, int]]:
        """Copies and pickles are the stored grid of the same shape."""
        return grid, (self.a_over_b, self.turned, self.cells)

    @property
    def _component(self) -> tuple[str, str]:
        return ("x", "y")

    @property
    def rows(self) -> int:
        """Number of rows, an even one."""
        return len(self.y)

    def counted(self, mirrored: bool) -> slice:
        """The rows that count: those with y > 0 where the others mirror them, else all."""
        return slice(self.rows // 2 if mirrored else 0, None)

    @property
    def area(self) -> Floats:
        """Area of each cell, (rows, 1). [-]"""
        return (self.length * self.width)[:, None]

    @property
    def symmetric(self) -> bool:
        """Whether the patch is its own mirror image in the rolling direction."""
        return self.turned == 0.0 or self.a_over_b == 1.0


@functools.lru_cache(maxsize=8)
def grid(a_over_b: float, turned: float, cells: int) -> Grid:
    r"""Cells that follow the chords of an ellipse.

    A turned ellipse is a sheared one: with extent B in y, the chord at y has the half-length
    :math:`(1/B)\sqrt{1 - y^2/B^2}` about a middle that moves in proportion to y. The pressure then separates into a factor of
    the row and a factor of the place along its chord, for every angle, and both are integrated in closed form.

    Parameters
    ----------
    a_over_b : float   Ratio of the semi-axes, 0.05 to 20. [-]
    turned : float     Angle from the rolling direction to the first semi-axis. [rad]
    cells : int        Cells in each row; even, 4 to 60. There are as many rows, but fewer where cells would be longer than
        `LONGEST` widths.

    Returns
    -------
    Grid

    Raises
    ------
    ParameterError
        If `cells` is out of range.

    Source: kalker1990 for the problem; rows and insets are this program's own.
    """
    if isinstance(cells, bool) or not isinstance(cells, int) or not FEWEST <= cells <= MOST or cells % 2:
        raise ParameterError(f"cells must be an even number from {FEWEST} to {MOST}, got {cells!r}")
    a = math.sqrt(a_over_b)
    sine, cosine = math.sin(turned), math.cos(turned)
    reach = math.hypot(a * sine, cosine / a)
    shear = (a_over_b - 1.0 / a_over_b) * sine * cosine / reach**2

    rows = min(cells, 2 * math.ceil(0.5 * LONGEST * reach**2 * cells))
    width = 2.0 * reach / (rows + INSET)
    y = _middles(rows) * width
    length = 2.0 / reach * np.sqrt(1.0 - (y / reach) ** 2) / (cells + INSET)
    x = shear * y[:, None] + length[:, None] * (_middles(cells) - AHEAD)

    # The pressure over the whole patch is shared out, so that the outermost cells take what lies beyond them.
    chord = _pinned(2.0 / cells * (_middles(cells + 1) - AHEAD))
    borders = _pinned(2.0 / (rows + INSET) * _middles(rows + 1))
    along_chord = np.diff(chord * np.sqrt(1.0 - chord**2) + np.arcsin(chord)) / math.pi
    across_rows = np.diff(borders * (3.0 - borders**2)) / 4.0
    bound = across_rows[:, None] * along_chord / (length * width)[:, None]
    y, length, x, bound = frozen((y, length, x, bound))
    return Grid(a_over_b, turned, cells, reach, y, length, width, x, bound)


def _middles(count: int) -> Floats:
    """That many places at distances of 1 about 0."""
    return np.arange(count) - 0.5 * (count - 1)


def _pinned(edges: Floats) -> Floats:
    """The edges with the first and the last at the ends of the chord."""
    return np.concatenate([[-1.0], edges[1:-1], [1.0]])
