"""Samples of a drive within its tolerances by quasi-Monte Carlo, and functions evaluated for many samples at once."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from infinivar._core import engine as engines
from infinivar._core.array_namespace import Array, namespace
from infinivar._core.engine import Engine
from infinivar._core.threads import in_order
from infinivar.analysis.cycles.performance import AnyDrive
from infinivar.analysis.robustness.derivatives import designs
from infinivar.study.spreads import Spread

_TOGETHER = 64
"""Designs computed at once: with some thousand points each, intermediate arrays fit the processor's caches."""

_COMPILED_TOGETHER = 16
"""The same for compiled code, which iterates until the last design has converged."""

WORTH_COMPILING = 8192
"""Smallest number of designs for which it pays off to import JAX and compile."""


def low_discrepancy(count: int, dimensions: int, seed: int = 0, start: int = 0) -> np.ndarray:
    """Scrambled points of a Sobol sequence in the open unit cube, from the point `start` on. (count, dimensions)

    Scrambling preserves the even spread of the sequence; a random shift does not, and a mean converges more slowly.

    Source: sobol1967, with the scrambling of matousek1998, by SciPy.
    """
    from scipy.stats import qmc

    sequence = qmc.Sobol(dimensions, scramble=True, rng=seed)
    if start:
        sequence.fast_forward(start)
    return np.clip(sequence.random(count), 1e-12, 1.0 - 1e-12)


def draw(spreads: Sequence[Spread], correlation: np.ndarray, count: int, seed: int = 0, start: int = 0) -> np.ndarray:
    """Draw samples, one row each, correlated by a Gaussian copula. (count, k)

    Parameters
    ----------
    spreads : sequence of Spread   Spreads of k fields.
    correlation : (k, k) float     Correlation of the normal scores; for normal spreads also of the values. [-]
    count : int                    Number of samples, a power of two.
    seed : int                     Seed of the scrambling.
    start : int                    Number of the first sample, so that a part of a larger draw can be had alone.
    """
    return placed(spreads, correlated(low_discrepancy(count, len(spreads), seed, start), correlation))


def correlated(shares: np.ndarray, correlation: np.ndarray) -> np.ndarray:
    """Independent shares, 0 to 1, with a correlation of their normal scores; the first column stays as it is. (count, k)"""
    from scipy.special import ndtr, ndtri

    if np.array_equal(correlation, np.eye(len(correlation))):
        return shares
    return ndtr(ndtri(shares) @ np.linalg.cholesky(correlation).T)


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
    for done, found in enumerate(in_order(function, pieces, workers=workers), start=1):
        yield found
        if progress is not None:
            progress(done / len(pieces))


class Batch:
    """A function of a drive for many designs: on all processors, compiled where that pays off.

    Attributes
    ----------
    engine, reason : str   numpy or jax, which computes; why not jax, or "".
    """

    def __init__(
        self,
        function: Callable[[AnyDrive], Array],
        drive: AnyDrive,
        paths: Sequence[str],
        *,
        width: int | None = None,
        engine: Engine = "auto",
        worth: bool = True,
    ) -> None:
        """Prepare, and compile if so decided; arguments as for `evaluated`, and whether compiling pays off.

        Raises
        ------
        InputError
            If JAX is requested and is not installed or cannot compile the function.
        """

        def run(piece: Array) -> Array:
            found = function(designs(drive, paths, piece))
            xp = namespace(piece, found)
            shape = (piece.shape[0],) if width is None else (piece.shape[0], width)
            return xp.broadcast_to(xp.asarray(found, dtype=xp.float64), shape)

        compiled, self.reason = engines.chosen(
            engine, worth=worth, compile=lambda: engines.compiled(run, [(_COMPILED_TOGETHER, len(paths))])
        )
        self.engine = "numpy" if compiled is None else "jax"
        self._run = run if compiled is None else functools.partial(padded, compiled, _COMPILED_TOGETHER)
        self._together = _TOGETHER if compiled is None else _COMPILED_TOGETHER

    def __call__(self, at: np.ndarray, progress: Callable[[float], None] | None = None) -> np.ndarray:
        """Evaluate designs; arguments and result as for `evaluated`."""
        return np.concatenate(list(in_pieces(self._run, at, self._together, progress=progress)))


def padded(compiled: Callable[[np.ndarray], Any], count: int, at: np.ndarray) -> Any:
    """Results of a function that is compiled for a number of rows, for no more than these. Arrays of rows, also in a tuple."""
    whole = at if len(at) == count else np.concatenate([at, np.repeat(at[-1:], count - len(at), axis=0)])
    found = compiled(whole)
    return tuple(part[: len(at)] for part in found) if isinstance(found, tuple) else found[: len(at)]


def evaluated(
    function: Callable[[AnyDrive], Array],
    drive: AnyDrive,
    paths: Sequence[str],
    at: np.ndarray,
    progress: Callable[[float], None] | None = None,
    width: int | None = None,
    engine: Engine = "auto",
) -> np.ndarray:
    """Evaluate a function for many designs, on all processors.

    Parameters
    ----------
    function : callable       Function of a drive, such as those of `infinivar.analysis.robustness.outcomes`.
    paths : sequence of str   Dotted paths of fields.
    at : (n, k) float         Values of the fields, one row per design.
    progress                  Called with the share done.
    width : int               Number of values per design, on a last axis; None for a single value.
    engine : str              numpy; jax, with the same numbers to rounding; or auto: jax for at least `WORTH_COMPILING`
        designs where it is installed and can compile the function.

    Returns
    -------
    (n,) or (n, width) float   nan where a design is infeasible.
    """
    worth = len(at) >= WORTH_COMPILING
    return Batch(function, drive, paths, width=width, engine=engine, worth=worth)(at, progress)
