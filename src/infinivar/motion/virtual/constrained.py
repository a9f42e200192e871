r"""Motion under constraints ``A xi = 0``: free directions, projections by a mass, and accelerations.

For a machine of the mass M, a symmetric positive definite matrix, the twists that the constraints leave free and
those that they would have to stop are perpendicular in the metric of the kinetic energy:

.. math:: P = I - M^{-1} A^T (A M^{-1} A^T)^{-1} A, \qquad P^2 = P, \qquad A P = 0, \qquad M P = P^T M

Source: featherstone2008, chapter 3, for the equations of constrained motion; Gauss's principle of least constraint
for the metric.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from infinivar._core.array_namespace import Array
from infinivar._core.arrays import real_array
from infinivar.errors import ParameterError, require

_DEPENDENT = 1e-9
"""Smallest singular value of rows of unit length, below which they are dependent."""


class ConstrainedMotion(NamedTuple):
    """How a machine moves under constraints."""

    acceleration: np.ndarray
    """Of the twist. (d,)"""
    reaction: np.ndarray
    """lambda, of each row: force along it on the machine. (k,)"""


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


def free_projection(rows: Array, mass: Array | None = None) -> np.ndarray:
    """P, which keeps of a twist what the constraints leave free; ``I - P`` is what they stop. Parameters as
    `free_basis`.

    Returns
    -------
    (d, d) float

    Raises
    ------
    ParameterError
        As for `free_basis`.
    """
    A = independent_rows("rows", rows)
    M = _metric(mass, A.shape[1])
    back = np.linalg.solve(M, A.T)
    return np.eye(A.shape[1]) - back @ np.linalg.solve(A @ back, A)


def constrained_motion(
    *, mass: Array, force: Array, rows: Array, rates: Array | None = None, twist: Array | None = None
) -> ConstrainedMotion:
    r"""Acceleration and reactions of a machine under constraints.

    .. math:: M \dot\xi = F + A^T \lambda, \qquad A \dot\xi = -\dot A \xi

    Parameters
    ----------
    mass : (d, d) float             M, symmetric and positive definite.
    force : (d,) float              F, all forces but those of the constraints: also those of a changing inertia.
    rows, rates : (k, d) float      A, and its time derivative along the motion; None: constant.
    twist : (d,) float, optional    xi; None: at rest.

    Returns
    -------
    ConstrainedMotion   The reactions do no work: ``xi^T A^T lambda = 0`` for a twist with ``A xi = 0``.

    Raises
    ------
    ParameterError
        As for `free_basis`, or if shapes do not fit.

    Source: featherstone2008, chapter 3.
    """
    A = independent_rows("rows", rows)
    d = A.shape[1]
    M, F = _metric(mass, d), real_array("force", force)
    xi = np.zeros(d) if twist is None else real_array("twist", twist)
    dA = np.zeros_like(A) if rates is None else real_array("rates", rates)
    for name, value, expected in (("force", F, (d,)), ("twist", xi, (d,)), ("rates", dA, A.shape)):
        require(value.shape == expected, name, f"shape {value.shape}", f"of shape {expected}")
        require(bool(np.isfinite(value).all()), name, "nan or inf", "finite")
    back, free = np.linalg.solve(M, A.T), np.linalg.solve(M, F)
    reaction = np.linalg.solve(A @ back, -dA @ xi - A @ free)
    return ConstrainedMotion(free + back @ reaction, reaction)
