"""Steady map of the shipped cobotic drive, 1000 x 1000 points, with the creep law exact against vermeulen-johnson."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from benchmarks._measure import STUDY, Line, in_turn, ratio_line
from infinivar import CoboticDrive, load_study, steady_map

PAIRS = 5
POINTS = 1000
REACH = 1.4
"""The map reaches this far beyond the required force and speed."""


def run() -> Iterator[Line]:
    """Measure maps with both laws in turn, in one process."""
    study = load_study(STUDY)
    drive, requirement = study.drives["cobotic"], study.required("the benchmark")
    assert isinstance(drive, CoboticDrive)
    speed, force = (np.linspace(0.0, REACH * top, POINTS) for top in (requirement.speed, requirement.force))

    def seconds(law: str) -> float:
        bent = replace(drive, transmission=replace(drive.transmission, creep_law=law))
        start = time.perf_counter()
        steady_map(bent, speed, force)
        return time.perf_counter() - start

    ours, theirs = in_turn(lambda: seconds("exact"), lambda: seconds("vermeulen-johnson"), PAIRS)
    yield ratio_line("steady map, law exact", ours, theirs, rival="vermeulen-johnson", at_most=1.3)
