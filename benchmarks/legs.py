"""A machine of six legs: static points with all losses and limits, and a map of its workspace, against one leg at a time.

The other side is the drive with one leg, called for each of the six links of the same points: what a user would write who
has no machine of many legs, without the kinematics.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Any

import numpy as np

import infinivar as iv
from benchmarks._measure import STUDY, Line, in_turn, ratio_line

PAIRS = 5
POINTS = 200_000
RATE, MAP = 200_000.0, 5.0
"""Least static points a second, and longest time of a map of 100 x 100 x 21 poses. [1/s], [s]"""


def run() -> Iterator[Line]:
    """Measure static points and a map."""
    leg = iv.load_study(STUDY).drives["cobotic"]
    machine, platform = iv.machines.LeggedDrive.of(leg, 6), iv.transmission.Platform.hexapod()
    random = np.random.default_rng(0)
    home = np.array([0.0, 0.0, platform.home])
    poses: dict[str, Any] = {
        "position": home + random.uniform(-0.02, 0.02, (POINTS, 3)),
        "rotation": random.uniform(-0.2, 0.2, (POINTS, 3)),
        "twist": random.normal(size=(POINTS, 6)) * [0.1, 0.1, 0.1, 1.0, 1.0, 1.0],
        "wrench": random.normal(size=(POINTS, 6)) * [10.0, 10.0, 10.0, 0.3, 0.3, 0.3],
    }
    place = platform.at(poses["position"], poses["rotation"])
    speeds, forces = place.link_speeds(poses["twist"]), place.link_forces(poses["wrench"])

    def ours() -> float:
        start = time.perf_counter()
        found = iv.analysis.static_points(machine, platform, **poses)
        assert np.all(np.isfinite(found.loss))
        return time.perf_counter() - start

    def theirs() -> float:
        start = time.perf_counter()
        for link in range(6):
            leg.operate(speed=speeds[:, link], force=forces[:, link])
        return time.perf_counter() - start

    def mapped() -> float:
        start = time.perf_counter()
        iv.analysis.workspace_map(
            machine,
            platform,
            x=np.linspace(-0.06, 0.06, 100),
            y=np.linspace(-0.06, 0.06, 100),
            z=home[2] + np.linspace(-0.05, 0.05, 21),
            wrench=[0.0, -20.0, -20.0, 0.0, 0.0, 0.0],
            twist=[0.0, 0.1, 0.1, 0.0, 0.0, 0.0],
        )
        return time.perf_counter() - start

    seconds = in_turn(ours, theirs, PAIRS)
    rate = POINTS / float(np.median(seconds[0]))
    yield ratio_line(f"six legs, {POINTS} static points", *seconds, rival="six drives of one leg")
    yield Line(
        what="six legs, static points a second",
        ours=f"{rate:,.0f}",
        theirs="",
        ratio="",
        target=f">= {RATE:,.0f}",
        passed=rate >= RATE,
    )
    duration = float(np.median([mapped() for _ in range(PAIRS)]))
    yield Line(
        what="six legs, map of 100 x 100 x 21 poses",
        ours=f"{duration:.3g} s",
        theirs="",
        ratio="",
        target=f"<= {MAP:g} s",
        passed=duration <= MAP,
    )
