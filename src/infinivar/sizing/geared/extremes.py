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


def braking_places(points: np.ndarray) -> np.ndarray:
    """Places of points of a region whose loads decide whether a motor returns power.

    A motor returns power while its current is below 0 and its voltage above. Both rise with the speed at one torque, and current
    by less than back-emf over resistance, as the no-load current is below half of the stall current. The speeds at which power
    is returned then are one interval, which at one torque and any candidate either has its upper end at twice its lower
    or more, or lies beyond the largest speed: speeds in ratios of two, the least and the largest find it.

    Parameters
    ----------
    points : (n, 2) float   Torque and speed with the motion, speeds of one torque in equal steps.

    Returns
    -------
    (k,) int   Points at which the load drives: of each torque those at the first, second, third, fifth, ninth speed and so on.
    """
    driven = np.flatnonzero(points[:, 0] < 0.0)
    order = driven[np.lexsort((points[driven, 1], points[driven, 0]))]
    torque, every = points[order, 0], np.arange(len(order))
    place = every - np.searchsorted(torque, torque, side="left")
    last = every == np.searchsorted(torque, torque, side="right") - 1
    return order[last | (place & (place - 1) == 0)]
