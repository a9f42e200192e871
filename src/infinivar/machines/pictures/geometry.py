"""Points of drawings: circles, hulls, and space as a viewer sees it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

_ROUND = np.linspace(0.0, 2.0 * math.pi, 73)
CIRCLE = np.stack([np.cos(_ROUND), np.sin(_ROUND)], axis=-1)
"""A circle of radius 1. (m, 2)"""


class View:
    """Points in space as a viewer far away sees them: to the right and up; z is up."""

    def __init__(self, azimuth: float, elevation: float) -> None:
        """Take the direction from which the viewer looks, from x towards y and above the plane. [degrees]"""
        around, above = math.radians(azimuth), math.radians(elevation)
        self.viewer = np.array(
            [math.cos(above) * math.cos(around), math.cos(above) * math.sin(around), math.sin(above)]
        )
        self._right = np.array([-math.sin(around), math.cos(around), 0.0])
        self._up = np.cross(self.viewer, self._right)

    def __call__(self, points: Any) -> np.ndarray:
        """Places (..., 2) of points (..., 3)."""
        points = np.asarray(points, dtype=float)
        return np.stack([points @ self._right, points @ self._up], axis=-1)

    def toward(self, vector: Any) -> float:
        """How far a vector points to the viewer."""
        return float(np.asarray(vector, dtype=float) @ self.viewer)


def hull(points: Any) -> np.ndarray:
    """Corners of the convex hull of points in the plane, in order."""
    from scipy.spatial import ConvexHull

    points = np.asarray(points, dtype=float)
    return points[ConvexHull(points).vertices]


def off(point: Any, right: float, up: float) -> np.ndarray:
    """The point to the right of another and above it."""
    return np.asarray(point, dtype=float) + np.array([right, up])


def rim(centre: Any, radius: float, first: Any, second: Any) -> np.ndarray:
    """A circle about a point in space or in the plane, in the plane of two unit vectors. (m, d)"""
    return np.asarray(centre) + radius * CIRCLE @ np.stack([first, second])


def unit(angle: Any) -> np.ndarray:
    """Unit vectors at angles (...,) from x. (..., 2)"""
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def normalised(vector: Any) -> np.ndarray:
    """Vectors (..., d) at length 1; 0 of what has no length."""
    vector = np.asarray(vector, dtype=float)
    size = np.linalg.norm(vector, axis=-1, keepdims=True)
    return vector / np.where(size > 0.0, size, 1.0)


def round_number(below: float) -> float:
    """The largest of 1, 2 or 5 times a power of ten that is not above a number > 0."""
    power = 10.0 ** math.floor(math.log10(below))
    return max(step * power for step in (1.0, 2.0, 5.0) if step * power <= below * (1.0 + 1e-9))
