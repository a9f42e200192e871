"""Unknowns of a calibration: parameters, each relative to a scale, then errors of the sensors in standard deviations."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

import numpy as np

STEP = 1e-5
"""Step of differences for unknowns of order 1; the error is about 1e-10."""

FARTHEST = 100.0
"""Bound of the errors of the sensors, in standard deviations."""

UNPREDICTED = 1e3
"""Residual, in standard deviations, of a reading that the model cannot predict, such as under slip."""


class Scaled(Protocol):
    """What has such unknowns."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters among the unknowns."""
        ...

    @property
    def known(self) -> Mapping[str, float]:
        """Values of all parameters in the study. [SI]"""
        ...

    @property
    def scales(self) -> np.ndarray:
        """Scales of the parameters among the unknowns. [SI]"""
        ...

    @property
    def errors(self) -> tuple[str, ...]:
        """Names of the errors among the unknowns."""
        ...

    @property
    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Bounds of the unknowns."""
        ...


def start_of(problem: Scaled) -> np.ndarray:
    """Unknowns at the study's values, moved inside the bounds."""
    given = np.asarray([problem.known[name] for name in problem.names]) / problem.scales
    low, high = problem.bounds
    return np.clip(np.concatenate([given, np.zeros(len(problem.errors))]), low, high)


def values_of(problem: Scaled, unknowns: np.ndarray) -> dict[str, Any]:
    """Every parameter, fitted or from the study. [SI]"""
    fitted = {name: unknowns[..., i : i + 1] * problem.scales[i] for i, name in enumerate(problem.names)}
    return {**problem.known, **fitted}


def jacobian_of(residuals: Callable[[np.ndarray], np.ndarray], unknowns: np.ndarray) -> np.ndarray:
    """Derivatives of residuals, by central differences in one pass. (residuals, unknowns)"""
    steps = STEP * np.eye(unknowns.size)
    return ((residuals(unknowns + steps) - residuals(unknowns - steps)) / (2.0 * STEP)).T
