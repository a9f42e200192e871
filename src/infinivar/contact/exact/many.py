"""Forces of many rolling patches, extrapolated to infinitely many cells, with an estimate of their error."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from infinivar._core.array_namespace import finite_floats
from infinivar.contact.exact.grid import Floats
from infinivar.contact.exact.patch import RollingPatch, SteadyRolling
from infinivar.errors import ParameterError, require

ORDER = 1.5
"""Observed order of the forces' error in the length of a cell, which the border between stick and slip limits."""

ROUGH = 0.003
"""Estimated error above which twice the cells are used: the accuracy that 20 cells have elsewhere. [-]"""

_MOST = 60
"""Largest number of cells in a row."""

_PIECE = 32
"""Contacts that one process computes in a row, each from the state before."""


class Extrapolated(NamedTuple):
    """Forces on the track of one patch, from two grids; nan if an iteration has not converged.

    Attributes
    ----------
    forces : (3,)           fx, fy and mz over mu N and mu N c, extrapolated to infinitely many cells. [-]
    error : (3,)            Estimated error of them on the finer grid: the change by the extrapolation. [-]
    coarse, fine : SteadyRolling   States on the two grids.
    """

    forces: Floats
    error: Floats
    coarse: SteadyRolling
    fine: SteadyRolling


class RollingForces(NamedTuple):
    """Forces on the track of many patches; inputs broadcast. A positive creepage causes a positive force.

    Attributes
    ----------
    fx, fy : (...,) float   Forces over mu N. [-]
    mz : (...,) float       Moment about the normal over mu N c. [-]
    error : (..., 3) float  Estimated error of fx, fy and mz on the finest grid: the change by the extrapolation. [-]
    converged : (...,) bool   Where False, all numbers are nan: no solution was found, or the grid has too few cells, see
        `SteadyRolling.outcome`.
    """

    fx: Floats
    fy: Floats
    mz: Floats
    error: Floats
    converged: np.ndarray


def rolling_forces(
    a_over_b: Any,
    longitudinal: Any = 0.0,
    lateral: Any = 0.0,
    spin: Any = 0.0,
    *,
    poisson: Any = 0.3,
    turned: Any = 0.0,
    cells: int = 20,
    workers: int = 1,
    progress: Callable[[float], None] | None = None,
) -> RollingForces:
    """Forces of exact rolling contact in steady state, from two grids.

    Patches are computed with `cells` and half as many cells, and extrapolated at the order 1.5. Where the estimated error then
    exceeds 0.003, as under a large spin on slender patches, twice the cells are used if they are at most 60.

    Parameters
    ----------
    a_over_b, poisson, turned : (...,) float     As for `RollingPatch`. [-], [-], [rad]
    longitudinal, lateral, spin : (...,) float   Scaled creepages, as for `RollingPatch.steady`. [-]
    cells : int       Cells along each side of the finer grid, a multiple of 4 from 8 to 60.
    workers : int     Processes. With more than one, a script that calls this needs the usual
        ``if __name__ == "__main__":``.
    progress          Called with the share done, 0 to 1.

    Returns
    -------
    RollingForces

    Raises
    ------
    ParameterError
        If an argument is out of range.

    Source: kalker1990 for the problem; `contact.exact.patch` for the method.
    """
    require(isinstance(workers, int) and workers >= 1, "workers", repr(workers), "a whole number >= 1")
    if not isinstance(cells, int) or cells % 4 or cells < 8:
        raise ParameterError(f"cells must be a multiple of 4 from 8 to 60, got {cells!r}")
    named = {"a_over_b": a_over_b, "poisson": poisson, "turned": turned}
    creepages = {"longitudinal": longitudinal, "lateral": lateral, "spin": spin}
    columns = np.broadcast_arrays(*finite_floats(np, **named, **creepages))
    shape = columns[0].shape
    cases = np.stack([column.ravel() for column in columns], axis=1)
    # Neighbours in these orders share grids, and are good starts for each other.
    order = np.lexsort(cases.T[::-1])
    pieces = [order[start : start + _PIECE] for start in range(0, len(order), _PIECE)]
    found = np.empty((len(cases), 6))
    tasks = zip((cases[piece] for piece in pieces), itertools.repeat(cells))
    for done, (piece, forces) in enumerate(zip(pieces, _each(tasks, workers), strict=True), start=1):
        found[piece] = forces
        if progress is not None:
            progress(done / len(pieces))
    found = found.reshape(*shape, 6)
    fx, fy, mz = (found[..., place] for place in range(3))
    return RollingForces(fx, fy, mz, found[..., 3:], np.isfinite(fx))


def extrapolated(
    patch: RollingPatch, creepage: Iterable[float], coarse_cells: int, start: SteadyRolling | None = None
) -> Extrapolated:
    """Forces of a patch under longitudinal and lateral creepage and spin, from its grid and a coarser one.

    Parameters
    ----------
    patch : RollingPatch     With the finer grid.
    creepage : (3,)          Scaled creepages. [-]
    coarse_cells : int       Cells along each side of the coarser grid.
    start : SteadyRolling    State for that one to begin with; the finer begins with what it finds.

    Returns
    -------
    Extrapolated
    """
    before = replace(patch, cells=coarse_cells).steady(*creepage, start=start)
    fine = patch.steady(*creepage, start=before)
    change = (fine.forces - before.forces) / ((patch.cells / coarse_cells) ** ORDER - 1.0)
    return Extrapolated(fine.forces + change, np.abs(change), before, fine)


def refined(both: Extrapolated, patch: RollingPatch, creepage: Iterable[float], lever: float = 1.0) -> Extrapolated:
    """The same forces from twice the cells where the estimated error exceeds `ROUGH` and at most 60 cells result.

    Parameters
    ----------
    both : Extrapolated   Found on the grid of `patch` and a coarser one.
    patch : RollingPatch
    creepage : (3,)       Scaled creepages. [-]
    lever : float         Length over c by which the moment's error is judged. [-]

    Returns
    -------
    Extrapolated
    """
    if 2 * patch.cells > _MOST or np.max(both.error / [1.0, 1.0, lever]) <= ROUGH:
        return both
    return extrapolated(replace(patch, cells=2 * patch.cells), creepage, patch.cells, both.fine)


def _each(tasks: Iterator[tuple[Floats, int]], workers: int) -> Iterator[Floats]:
    """Forces of each task, in order."""
    if workers == 1:
        yield from itertools.starmap(_forces, tasks)
        return
    import multiprocessing
    from concurrent.futures import ProcessPoolExecutor

    with ProcessPoolExecutor(workers, multiprocessing.get_context("spawn")) as pool:
        yield from pool.map(_forces, *zip(*tasks, strict=True))


def _forces(cases: Floats, cells: int) -> Floats:
    """Extrapolated forces and estimated errors of some cases, (n, 6)."""
    found = np.empty((len(cases), 6))
    last: SteadyRolling | None = None
    for place, case in enumerate(cases):
        patch = RollingPatch(*case[:3], cells=cells)
        both = extrapolated(patch, case[3:], cells // 2, last)
        last = both.coarse
        both = refined(both, patch, case[3:])
        known = both.fine.outcome == "converged"
        found[place] = np.concatenate([both.forces, both.error]) if known else np.nan
    return found
