"""Builds of a drive: values drawn within their tolerances by quasi-Monte Carlo, and functions of many drives at once."""

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
"""Designs computed at once: with some thousand points each, intermediate arrays stay within the processor's caches."""


def low_discrepancy(count: int, dimensions: int, seed: int = 0) -> np.ndarray:
    """Points of a Sobol sequence in the unit cube, scrambled at random; none is 0 or 1. (count, dimensions)

    Scrambled points stay as evenly spread as the sequence; shifted ones do not, so a mean over them converges more slowly.

    Source: sobol1967, with the scrambling of matousek1998, by SciPy.
    """
    from scipy.stats import qmc

    points = qmc.Sobol(dimensions, scramble=True, rng=seed).random(count)
    return np.clip(points, 1e-12, 1.0 - 1e-12)


def draw(spreads: Sequence[Spread], correlation: np.ndarray, count: int, seed: int = 0) -> np.ndarray:
    """Values of builds, one row each; correlated by a Gaussian copula. (count, k)

    Parameters
    ----------
    spreads : sequence of Spread   k of them.
    correlation : (k, k) float     Of the normal scores: for normal spreads that of the values. [-]
    count : int                    A power of two.
    seed : int                     Of the scrambling.
    """
    from scipy.special import ndtr, ndtri

    shares = low_discrepancy(count, len(spreads), seed)
    if not np.array_equal(correlation, np.eye(len(spreads))):
        shares = ndtr(ndtri(shares) @ np.linalg.cholesky(correlation).T)
    return placed(spreads, shares)


def placed(spreads: Sequence[Spread], shares: np.ndarray) -> np.ndarray:
    """Values below which given shares of the builds lie, a spread a column. (count, k)"""
    return np.stack([spread.at(shares[:, place]) for place, spread in enumerate(spreads)], axis=-1)


def in_pieces(
    function: Callable[[np.ndarray], Any],
    at: np.ndarray,
    size: int,
    *,
    workers: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> Iterator[Any]:
    """What a function makes of so many rows at a time, in their order; on all processors unless said otherwise."""
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
    """Values of a function for many designs, on all processors.

    Parameters
    ----------
    function : callable       Of a drive, as those of `infinivar.analysis.robustness.outcomes`.
    paths : sequence of str   Dotted paths of fields.
    at : (n, k) float         Their values, a design a row.
    progress                  Called with the share done.
    width : int               How many values a design gives, on a last axis; None for a single one.

    Returns
    -------
    (n,) or (n, width) float   nan where a design cannot do it.
    """

    def run(piece: np.ndarray) -> np.ndarray:
        found = np.asarray(function(designs(drive, paths, piece)), dtype=float)
        return np.broadcast_to(found, (len(piece),) if width is None else (len(piece), width))

    return np.concatenate(list(in_pieces(run, at, _TOGETHER, progress=progress)))
