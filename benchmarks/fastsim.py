"""FASTSIM, 50 x 50 cells, 1000 contacts in one call against one contact a call, per contact, both over NumPy.

The cells of a strip follow each other, so the time of a single contact is that of calling array functions on a row of
strips. Contacts side by side share the calls; their arrays are cut to stay in cache.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

import numpy as np

from benchmarks._measure import Line, in_turn, ratio_line
from infinivar.contact import fastsim

PAIRS = 9
TOGETHER, ALONE = 1000, 100
"""Number of contacts in one call, and number of those computed again, one per call."""


def run() -> Iterator[Line]:
    """Measure both, and check that they compute the same."""
    random = np.random.default_rng(1)
    contacts = [*random.uniform(-1, 1, (3, TOGETHER)), random.uniform(0.2, 5, TOGETHER), np.full(TOGETHER, 1.15)]
    singles = [tuple(float(values[i]) for values in contacts) for i in range(ALONE)]

    def batch() -> np.ndarray:
        return np.stack(fastsim.forces(*contacts))

    def loop() -> np.ndarray:
        return np.stack([np.stack(fastsim.forces(*single)) for single in singles], axis=1)

    difference = float(np.max(np.abs(batch()[:, :ALONE] - loop())))
    if not difference <= 1e-12:
        raise RuntimeError(f"contacts computed together and alone differ by {difference:.0e}")
    ours, theirs = in_turn(lambda: _seconds(batch) / TOGETHER, lambda: _seconds(loop) / ALONE, PAIRS)
    yield ratio_line("FASTSIM 50 x 50, a contact of 1000", ours, theirs, rival="one at a time", at_most=0.2)


def _seconds(function: Callable[[], np.ndarray]) -> float:
    start = time.perf_counter()
    function()
    return time.perf_counter() - start
