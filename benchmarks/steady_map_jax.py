"""Steady map of 3000 x 3000 points, compiled by JAX against NumPy, both on all processors; compiling counted apart.

Both engines run in turn in one process, which has compiled before; all outputs must agree. The first map of a fresh process is
timed as well, with an empty folder of compiled functions and with one that has the drive's: it includes importing JAX.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
import time
from collections.abc import Iterator
from functools import partial

import numpy as np

import infinivar as iv
from benchmarks import _measure
from benchmarks._measure import STUDY, Line, in_turn, ratio_line
from infinivar.drivetrain.drive import Drive

POINTS, PAIRS = 3000, 5
REACH = 1.4
"""The map reaches this far beyond the required force and speed, in all four quadrants."""
AGREEMENT = 1e-12
"""Largest accepted difference of a power, relative to the largest power at the point, and of efficiency and margin."""
DRIVES = {"cobotic": 0.25, "motor2-gear4": None}
"""Largest accepted ratio of times, by drive."""

_WHAT = "steady map, 3000 x 3000"


def run() -> Iterator[Line]:
    """Measure both engines in turn, and fresh processes."""
    for name, at_most in DRIVES.items():
        drive, axes = _task(name)
        _agree(iv.steady_map(drive, *axes, engine="jax"), iv.steady_map(drive, *axes, engine="numpy"))
        fast, plain = in_turn(partial(_seconds, name, "jax"), partial(_seconds, name, "numpy"), PAIRS)
        yield ratio_line(f"{_WHAT}, {name}, JAX", fast, plain, rival="NumPy", at_most=at_most)
    plain = _fresh("numpy", None)
    with tempfile.TemporaryDirectory() as folder:
        for what in ("nothing", "the drive"):
            seconds = _fresh("jax", folder)
            yield Line(
                what=f"{_WHAT}, cobotic, first of a process, {what} compiled before",
                ours=f"{seconds:.3g} s",
                theirs=f"NumPy: {plain:.3g} s",
                ratio=f"{seconds / plain:.2f}",
            )


def _task(name: str) -> tuple[Drive, tuple[np.ndarray, np.ndarray]]:
    study = iv.load_study(STUDY)
    requirement = study.required("the benchmark")
    shares = np.linspace(-REACH, REACH, POINTS)
    return study.drives[name], (shares * requirement.speed, shares * requirement.force)


def _seconds(name: str, engine: str) -> float:
    drive, axes = _task(name)
    start = time.perf_counter()
    found = iv.steady_map(drive, *axes, engine=engine)  # type: ignore[arg-type]
    seconds = time.perf_counter() - start
    assert found.engine == engine
    return seconds


def _fresh(engine: str, folder: str | None) -> float:
    """Seconds of the first map of a process whose compiled functions are in a folder."""
    before = os.environ.get("XDG_CACHE_HOME")
    try:
        if folder is not None:
            os.environ["XDG_CACHE_HOME"] = folder
        return json.loads(_measure.run([sys.executable, "-m", "benchmarks.steady_map_jax", engine]))
    finally:
        if folder is not None:
            os.environ.pop("XDG_CACHE_HOME")
            os.environ |= {} if before is None else {"XDG_CACHE_HOME": before}


def _agree(fast: iv.SteadyMap, plain: iv.SteadyMap) -> None:
    size = np.maximum(np.abs(plain.power_in), np.abs(plain.power_out))
    powers = {"power_in": 1, "power_out": 1, **plain.losses}
    worst = {}
    for name in powers:
        a, b = (one.losses[name] if name in one.losses else getattr(one, name) for one in (fast, plain))
        worst[name] = float(np.nanmax(np.abs(a - b) / (size + 1e-300)))
    for name in ("efficiency", "margin"):
        a, b = getattr(fast, name), getattr(plain, name)
        worst[name] = float(np.nanmax(np.abs(a - b) / np.where(b == 0, 1.0, np.abs(b))))
    if not np.array_equal(fast.limit, plain.limit) or max(worst.values()) > AGREEMENT:
        raise RuntimeError(f"JAX and NumPy differ: {worst}")
    print(f"steady_map_jax: outputs agree within {max(worst.values()):.0e}, limits at every point")


if __name__ == "__main__":
    print(json.dumps(_seconds("cobotic", sys.argv[1])))
