"""Elements with the groups H and K that the paper's two printed efficiencies imply, within their rounding."""

from __future__ import annotations

import functools
from dataclasses import replace

import numpy as np

from infinivar.paper.claims.claim import at_ratio
from infinivar.transmission.rotary_linear import RotaryLinearIVT

PRINTED = (0.50, 0.94)
"""Efficiencies at half load, at 100:1 and near 8:1. Source: faulring2006, section IV-B."""

_DIGITS = {"H and K fitted to the printed 0.50 and 0.94": PRINTED}
_EDGES = {
    "H and K fitted to 0.505 and 0.935": (0.505, 0.935),
    "H and K fitted to 0.495 and 0.945": (0.495, 0.945),
}
_GUESS = (0.003, 250.0)
"""Starting values of H and K; the two efficiencies determine a unique solution."""


def with_groups(element: RotaryLinearIVT, rolling_group: float, creep_group: float) -> RotaryLinearIVT:
    """The element with H and K in place of a geometry: its efficiency depends on nothing else."""
    slip = element.slip_force
    return replace(
        element,
        geometry=None,
        steering_model="shear",
        creep_stiffness=creep_group * slip,
        rolling_torque=rolling_group * element.wheel_radius * slip,
        bearing_torque=0.0,
    )


@functools.lru_cache(maxsize=16)
def fitted(element: RotaryLinearIVT, at_100: float, at_8: float, ratio: float = 8.0) -> RotaryLinearIVT:
    """The element with H and K fitted to two efficiencies at half load, at 100:1 and near 8:1.

    Source: faulring2006, section IV-B.
    """
    from scipy.optimize import fsolve

    def missed(logarithms: np.ndarray) -> np.ndarray:
        made = with_groups(element, *(float(group) for group in np.exp(logarithms)))
        return at_ratio(made, 0.5, np.array([100.0, ratio])).efficiency - [at_100, at_8]

    found = fsolve(missed, np.log(_GUESS), xtol=1e-12)
    return with_groups(element, *(float(group) for group in np.exp(np.asarray(found))))


def fitted_elements(element: RotaryLinearIVT) -> dict[str, RotaryLinearIVT]:
    """Elements fitted to the printed efficiencies and to the extremes that their rounding allows."""
    return {words: fitted(element, *printed) for words, printed in {**_DIGITS, **_EDGES}.items()}
