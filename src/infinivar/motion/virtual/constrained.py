r"""Directions of motion that constraints ``A xi = 0`` leave free.

For a machine of the mass M, a symmetric positive definite matrix, the twists that the constraints leave free and
those that they would have to stop are perpendicular in the metric of the kinetic energy.

Source: featherstone2008, chapter 3; Gauss's principle of least constraint for the metric.
"""

from __future__ import annotations

import numpy as np

from infinivar._core.array_namespace import Array
from infinivar._core.arrays import real_array
from infinivar.errors import ParameterError, require

_DEPENDENT = 1e-9
"""Smallest singular value of rows of unit length, below which they are dependent."""


def independent_rows(name: str, rows: Array) -> np.ndarray:
    """Rows (k, d) of constraints as an array.

    Raises
    ------
    ParameterError
        If they are not finite, are dependent, or leave nothing free.
    """
    A = real_array(name, rows)
    fits = A.ndim == 2 and 0 < A.shape[0] < A.shape[1]
    require(fits, name, f"shape {A.shape}", "of shape (k, d) with 0 < k < d: at least one row, and one free dimension")
    require(bool(np.isfinite(A).all()), name, "nan or inf", "finite")
    zero = np.flatnonzero(~np.any(A, axis=1))
    require(
        len(zero) == 0, name, f"only zeros in row {zero[0] + 1 if len(zero) else ''}", "rows that constrain something"
    )
    if rank_of(A) < len(A):
        raise ParameterError(
            f"{name} must be independent, got {len(A)} rows of rank {rank_of(A)}: remove what others imply"
        )
    return A


def rank_of(rows: np.ndarray) -> int:
    """Number of independent rows among rows (k, d), none of them zero."""
    scaled = rows / np.max(np.abs(rows), axis=1, keepdims=True)
    size = np.sqrt(np.sum(scaled**2, axis=1, keepdims=True))
    return int(np.sum(np.linalg.svd(scaled / size, compute_uv=False) > _DEPENDENT))


def _metric(mass: Array | None, d: int) -> np.ndarray:
    if mass is None:
        return np.eye(d)
    M = real_array("mass", mass)
    require(M.shape == (d, d), "mass", f"shape {M.shape}", f"of shape ({d}, {d})")
    require(bool(np.isfinite(M).all()), "mass", "nan or inf", "finite")
    level = float(np.max(np.abs(M)))
    require(bool(np.all(np.abs(M - M.T) <= 1e-9 * level)), "mass", "an asymmetric matrix", "symmetric")
    scale = np.sqrt(np.abs(np.diag(M)))
    sound = bool(np.all(np.diag(M) > 0.0)) and float(np.linalg.eigvalsh(M / np.outer(scale, scale))[0]) > 1e-12
    require(sound, "mass", "a matrix that is not", "positive definite")
    return M


def free_basis(rows: Array, mass: Array | None = None) -> np.ndarray:
    """Basis of the free twists, orthonormal in the metric of a mass: ``A N = 0``, ``N^T M N = I``.

    Parameters
    ----------
    rows : (k, d) float            A, independent.
    mass : (d, d) float, optional  M; None: the unit matrix.

    Returns
    -------
    (d, d - k) float   One free twist a column.

    Raises
    ------
    ParameterError
        If rows are dependent, or the mass is not symmetric and positive definite.
    """
    A = independent_rows("rows", rows)
    M = _metric(mass, A.shape[1])
    lower = np.linalg.cholesky(M)
    scaled = np.linalg.solve(lower, A.T).T  # A L^-T, whose null space is L^T of that of A
    null = np.linalg.svd(scaled)[2][len(A) :]
    return np.linalg.solve(lower.T, null.T)
