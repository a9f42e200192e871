"""Points of a set at which functions of some kinds are largest or smallest."""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull, QhullError

_FLAT = 1e-12
"""Extent of a set along a direction, relative to the largest, below which it counts as flat."""
_FEW = 8
"""Number of points that are not worth a hull."""


def extreme_places(points: np.ndarray) -> np.ndarray:
    """Places of points at which every linear, and thus every convex function is largest.

    Parameters
    ----------
    points : (n, d) float

    Returns
    -------
    (k,) int   Corners of the convex hull, in rising order; of a flat set, those within its plane.
    """
    count = len(points)
    if count <= _FEW:
        return np.arange(count)
    size = np.max(np.abs(points), axis=0)
    moved = points / np.where(size > 0, size, 1.0)
    moved = moved - moved.mean(axis=0)
    _, spread, axes = np.linalg.svd(moved, full_matrices=False)
    flat = moved @ axes[spread > _FLAT * max(spread[0], _FLAT)].T
    if flat.shape[1] == 0:
        return np.array([0])
    if flat.shape[1] == 1:
        return np.unique([int(np.argmin(flat[:, 0])), int(np.argmax(flat[:, 0]))])
    try:
        return np.sort(ConvexHull(flat).vertices)
    except QhullError:  # too flat for a hull: every point stays
        return np.arange(count)


def least_places(points: np.ndarray) -> np.ndarray:
    """Places of points that no other point undercuts in every coordinate: where rising functions are smallest.

    Parameters
    ----------
    points : (n, 2) float

    Returns
    -------
    (k,) int
    """
    order = np.lexsort((points[:, 1], points[:, 0]))
    second = points[order, 1]
    before = np.concatenate([[np.inf], np.minimum.accumulate(second)[:-1]])
    return order[second < before]


def highest_places(points: np.ndarray) -> np.ndarray:
    """Places of points at which linear functions that rise in every coordinate are largest.

    Parameters
    ----------
    points : (n, d) float

    Returns
    -------
    (k,) int   Corners of the convex hull that no other corner exceeds in every coordinate.
    """
    if not len(points):
        return np.arange(0)
    places = extreme_places(points)
    corners = points[places]
    others = corners[None, :, :]
    exceeded = np.all(others >= corners[:, None, :], axis=-1) & np.any(others > corners[:, None, :], axis=-1)
    return places[~exceeded.any(axis=-1)]
