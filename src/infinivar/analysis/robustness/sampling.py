"""Samples of a drive within its tolerances by quasi-Monte Carlo, and functions evaluated for many samples at once."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

from infinivar._core.array_namespace import Array
from infinivar.analysis.cycles.performance import AnyDrive
from infinivar.analysis.robustness.derivatives import designs
from infinivar.study.spreads import Spread

_TOGETHER = 64
"""Designs computed at once: with some thousand points each, intermediate arrays fit the processor's caches."""


def low_discrepancy(count: int, dimensions: int, seed: int = 0) -> np.ndarray:
    """Scrambled points of a Sobol sequence in the open unit cube. (count, dimensions)

    Scrambling preserves the even spread of the sequence; a random shift does not, and a mean converges more slowly.

    Source: sobol1967, with the scrambling of matousek1998, by SciPy.
    """
    from scipy.stats import qmc

    points = qmc.Sobol(dimensions, scramble=True, rng=seed).random(count)
    return np.clip(points, 1e-12, 1.0 - 1e-12)


def draw(spreads: Sequence[Spread], correlation: np.ndarray, count: int, seed: int = 0) -> np.ndarray:
    """Draw samples, one row each, correlated by a Gaussian copula. (count, k)

    Parameters
    ----------
    spreads : sequence of Spread   Spreads of k fields.
    correlation : (k, k) float     Correlation of the normal scores; for normal spreads also of the values. [-]
    count : int                    Number of samples, a power of two.
    seed : int                     Seed of the scrambling.
    """
    from scipy.special import ndtr, ndtri

    shares = low_discrepancy(count, len(spreads), seed)
    if not np.array_equal(correlation, np.eye(len(spreads))):
        shares = ndtr(ndtri(shares) @ np.linalg.cholesky(correlation).T)
    return placed(spreads, shares)


def placed(spreads: Sequence[Spread], shares: np.ndarray) -> np.ndarray:
    """Quantiles of the spreads at given shares, one column per spread. (count, k)"""
    return np.stack([spread.at(shares[:, place]) for place, spread in enumerate(spreads)], axis=-1)


def in_pieces(
    function: Callable[[np.ndarray], Any],
    at: np.ndarray,
    size: int,
    *,
    workers: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> Iterator[Any]:
    """Yield the function's result for each chunk of rows, in order; on all processors by default."""
    pieces = [at[start : start + size] for start in range(0, len(at), size)]
    with ThreadPoolExecutor(workers or os.cpu_count()) as pool:
        for done, found in enumerate(pool.map(function, pieces), start=1):
            yield found
            if progress is not None:
                progress(done / len(pieces))


def evaluated(
    function: Callable[[AnyDrive], Array],
    drive: AnyDrive,
    paths: Sequence[str],
    at: np.ndarray,
    progress: Callable[[float], None] | None = None,
    width: int | None = None,
) -> np.ndarray:
    """Evaluate a function for many designs, on all processors.

    Parameters
    ----------
    function : callable       Function of a drive, such as those of `infinivar.analysis.robustness.outcomes`.
    paths : sequence of str   Dotted paths of fields.
    at : (n, k) float         Values of the fields, one row per design.
    progress                  Called with the share done.
    width : int               Number of values per design, on a last axis; None for a single value.

    Returns
    -------
    (n,) or (n, width) float   nan where a design is infeasible.
    """

    def run(piece: np.ndarray) -> np.ndarray:
        found = np.asarray(function(designs(drive, paths, piece)), dtype=float)
        return np.broadcast_to(found, (len(piece),) if width is None else (len(piece), width))

    return np.concatenate(list(in_pieces(run, at, _TOGETHER, progress=progress)))
