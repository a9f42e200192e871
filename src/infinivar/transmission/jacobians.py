"""Jacobians of positions by the complex step, for machines whose kinematics are given as positions."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from infinivar._core.array_namespace import Array
from infinivar._core.complex_step import Stepped, size_of_step


def jacobian(position: Callable[..., Sequence[Array]], *coordinates: Array) -> np.ndarray:
    """Derivatives of positions by coordinates, exact to rounding.

    Parameters
    ----------
    position : callable            Maps n coordinates (...,) to m positions (...,), written over an array namespace.
    coordinates : (...,) float     Where to differentiate; they broadcast.

    Returns
    -------
    (..., m, n) float   NumPy arrays only.

    Source: squire1998.
    """
    at = np.broadcast_arrays(*(np.asarray(value, dtype=float) for value in coordinates))
    columns = []
    for place, value in enumerate(at):
        size = size_of_step(value)
        given = [Stepped(value + 1j * size) if place == other else one for other, one in enumerate(at)]
        found = [one.slope / size if isinstance(one, Stepped) else np.zeros(value.shape) for one in position(*given)]
        columns.append(np.stack([np.broadcast_to(one, value.shape) for one in found], axis=-1))
    return np.stack(columns, axis=-1)
