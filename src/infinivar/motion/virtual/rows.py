"""Points and directions as arguments: checked, and as arrays."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from annotated_types import Interval

from infinivar._core.array_namespace import Array
from infinivar._core.arrays import real_array, shown
from infinivar.bondgraph.recorded import as_recorded
from infinivar.errors import require

FARTHEST = 1e9
"""Largest coordinate of a point. [m]"""

SIZE = Interval(ge=1e-9, le=FARTHEST)
"""Bound of radii: what squares and their inverses keep within the range of floats. [m]"""


def placed(
    name: str, value: Array | Sequence[float], dimension: int | None = None, *, on_axis: bool = False
) -> np.ndarray:
    """Points (..., d) as an array, with d coordinates, or 2 or 3 of one point if d is not given; `on_axis`: 1 as well.

    Raises
    ------
    ParameterError
        If there are more or fewer coordinates, or one is not finite or is beyond `FARTHEST`.

    Notes
    -----
    Points that are recorded are not known yet, and are returned as they are.
    """
    made = as_recorded(value)
    if made is not None:
        return made
    if on_axis:
        fits = np.shape(value) in ((1,), (2,), (3,))
        require(fits, name, shown(value), "a point of one to three coordinates")
        dimension = len(value)
    points = _components(name, value, dimension)
    far = np.abs(points) > FARTHEST
    require(not far.any(), name, f"{points[far][0] if far.any() else 0.0:g} m", f"within {FARTHEST:g} m of the origin")
    return points


def _components(name: str, value: Array | Sequence[float], dimension: int | None) -> np.ndarray:
    points = real_array(name, value)
    if dimension is None:
        require(points.shape in ((2,), (3,)), name, shown(value), "a point of two or three coordinates")
    else:
        fits = points.ndim > 0 and points.shape[-1] == dimension
        require(fits, name, f"shape {points.shape}", f"points of {dimension} coordinates")
    require(bool(np.isfinite(points).all()), name, shown(value), "finite")
    return points


def unit(name: str, value: Array | Sequence[float], dimension: int) -> np.ndarray:
    """A direction (d,) as a unit vector.

    Raises
    ------
    ParameterError
        If it has another number of components, or is zero or not finite.
    """
    vector = _components(name, value, dimension)
    require(vector.ndim == 1, name, f"shape {vector.shape}", f"one direction of {dimension} components")
    largest = float(np.max(np.abs(vector)))
    require(largest > 0.0, name, shown(value), "a direction, not zero")
    scaled = vector / largest
    return scaled / np.sqrt(scaled @ scaled)


def cross(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Cross product of two vectors in space; ten times faster than `numpy.cross` for two."""
    a, b, c = first.tolist()
    x, y, z = second.tolist()
    return np.array([b * z - c * y, c * x - a * z, a * y - b * x])


def perpendicular(direction: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors across a unit vector in space, the second along z if the direction is in the plane of x and y."""
    first, second = perpendicular_in_motion(direction, np.zeros(3))[0]
    return first, second


def perpendicular_in_motion(
    direction: np.ndarray, rate: np.ndarray
) -> tuple[tuple[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]:
    """The two vectors of `perpendicular`, and their rates if the direction changes at a rate."""
    x, y, z = direction
    dx, dy, dz = rate
    flat = x * x + y * y > 0.01
    across = np.array([-y, x, 0.0]) if flat else np.array([0.0, -z, y])
    turning = np.array([-dy, dx, 0.0]) if flat else np.array([0.0, -dz, dy])
    size = np.sqrt(across @ across)
    first = across / size
    d_first = (turning - (turning @ first) * first) / size
    pair = first, cross(direction, first)
    return pair, (d_first, cross(rate, first) + cross(direction, d_first))
