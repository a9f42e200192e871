"""Fig 7, five curves of 2,000 ratios: an element made from geometry, with each creep law, against one with given groups.

Both are timed from the numbers of the design to the efficiencies; the element with given groups has the linear law.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from benchmarks._measure import Line, in_turn, ratio_line
from infinivar.contact import creep
from infinivar.paper.claims.claim import PaperMachine, at_ratio
from infinivar.paper.figures.curves import LOADS
from infinivar.transmission.rotary_linear import RotaryLinearIVT

PAIRS = 25
RATIOS = np.geomspace(0.3, 1000.0, 2000)


def run() -> Iterator[Line]:
    """Measure each law but fastsim, whose inverse takes an iteration of its own."""
    designed = PaperMachine().element
    groups = designed.groups(14.0)
    given = replace(
        designed,
        geometry=None,
        creep_stiffness=groups.creep_stiffness,
        rolling_torque=groups.rolling_torque,
        bearing_torque=groups.bearing_torque,
    )
    if not np.array_equal(_curves(designed), _curves(given), equal_nan=True):
        raise RuntimeError("geometry and its groups give different curves")
    for law in creep.LAWS:
        if law != "fastsim":
            ours, theirs = in_turn(lambda law=law: _seconds(designed, law), lambda: _seconds(given, "linear"), PAIRS)
            yield ratio_line(f"Fig 7 from geometry, {law}", ours, theirs, rival="given groups", at_most=2.0)


def _curves(element: RotaryLinearIVT) -> np.ndarray:
    return np.stack([at_ratio(element, load, RATIOS).efficiency for load in LOADS])


def _seconds(element: RotaryLinearIVT, law: str) -> float:
    start = time.perf_counter()
    _curves(replace(element, creep_law=law))  # made anew: the wheel is pressed on the cylinder each time
    return time.perf_counter() - start
