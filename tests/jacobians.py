"""Jacobians of positions by the complex step: a second way to those of arms and carts."""

import numpy as np

from internals import complex_step


def jacobian(position, *coordinates):
    """Derivatives of m positions (...,), a function of n coordinates (...,), exact to rounding: (..., m, n). squire1998"""
    at = np.broadcast_arrays(*(np.asarray(value, dtype=float) for value in coordinates))
    columns = []
    for place, value in enumerate(at):
        size = complex_step.size_of_step(value)
        stepped = complex_step.Stepped(value + 1j * size)
        found = position(*(stepped if place == other else one for other, one in enumerate(at)))
        slopes = [one.slope / size if isinstance(one, complex_step.Stepped) else np.zeros(value.shape) for one in found]
        columns.append(np.stack([np.broadcast_to(one, value.shape) for one in slopes], axis=-1))
    return np.stack(columns, axis=-1)
