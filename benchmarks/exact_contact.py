"""Exact rolling contact: 20 x 20 cells against 40 x 40, a state each, and the time to build the matrices of one shape.

The error of each grid is the largest difference from the reference curves of lateral creep, which were computed with another
program at 40 x 40 elements, where it needs 0.11 s a state. Lateral creep is measured at all creepages of the curve, the rest at
every fourth.
"""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np

from benchmarks._measure import Line, in_turn, ratio_line
from infinivar.contact import RollingPatch, exact_tables, kalker
from infinivar.contact.exact import equations
from infinivar.contact.exact.grid import grid

PAIRS = 3
WARM, BUILD, RIVAL = 0.050, 0.2, 0.11
"""Longest times of a state and of the matrices of a shape; the other program's time for a state. [s]"""


def run() -> Iterator[Line]:
    """Measure states with and without spin and the building of matrices."""
    curve = exact_tables.lateral_creep()[1]
    linear = kalker.coefficients(curve["a_over_b"], 0.3)
    creepages = 3.0 * curve["scaled_creepage"] / float(linear.c22)
    for what, spin, longitudinal, step in (
        ("lateral creep", 0.0, 0.0, 1),
        ("with spin", 0.3, 0.0, 4),
        ("any creep", 0.3, 0.2, 4),
    ):
        errors = {}

        def states(cells: int, spin: float = spin, longitudinal: float = longitudinal, step: int = step) -> float:
            patch = RollingPatch(float(curve["a_over_b"]), 0.3, 0.0, cells)
            start = time.perf_counter()
            forces = [patch.steady(longitudinal, lateral, spin).fy for lateral in creepages[step - 1 :: step]]
            seconds = time.perf_counter() - start
            errors[cells] = float(np.max(np.abs(np.array(forces) - curve["force_ratio"][step - 1 :: step])))  # noqa: B023
            return seconds / len(forces)

        seconds = in_turn(lambda: states(20), lambda: states(40), PAIRS)
        known = "" if spin else f", error {errors[20]:.4f} and {errors[40]:.4f}"
        yield ratio_line(f"exact contact, {what}{known}", *seconds, rival="40 x 40 cells", at_most=1.0)
        ours = float(np.median(seconds[0]))
        yield _limit(f"exact contact, {what}, a state", ours, WARM)
        if not spin:
            yield _limit(f"exact contact, {what}, against the other program", ours, RIVAL / 3.0)
    yield _limit("exact contact, matrices of a shape", min(_build() for _ in range(PAIRS)), BUILD)


def _build() -> float:
    """Seconds for the matrices of one shape, nothing stored."""
    for stored in (grid, equations.influence, equations._corner_sums, equations.equations):
        stored.cache_clear()
    start = time.perf_counter()
    equations.equations(RollingPatch(0.7).grid, 0.3, True)
    return time.perf_counter() - start


def _limit(what: str, seconds: float, most: float) -> Line:
    return Line(
        what=what, ours=f"{seconds:.3g} s", theirs="", ratio="", target=f"<= {most:.3g} s", passed=seconds <= most
    )
