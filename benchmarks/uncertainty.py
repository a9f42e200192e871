"""Maps of 10,000 builds and cycles of 2,000 with NumPy and with JAX, and a calibration of 200 runs.

Both map the same builds, drawn by quasi-Monte Carlo, on 60 x 60 points with all limits, and evaluate energy, heat and limits
of the first 2,000 in a cycle of 2000 instants; a ratio counts only if they agree. JAX is timed once compiled, and what compiling
takes is printed.
The calibration fits six parameters to runs of the virtual rig; its time is after import.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Iterator
from functools import partial

import numpy as np

import infinivar as iv
from benchmarks._measure import STUDY, Line, in_turn, ratio_line
from infinivar.analysis.robustness import outcomes
from infinivar.analysis.robustness.derivatives import values_of
from infinivar.analysis.robustness.sampling import Batch, low_discrepancy
from infinivar.analysis.robustness.verdicts import BuildsMap, Mapper
from infinivar.calibration import transmission, virtual_rig
from infinivar.calibration.calibrate import calibrate
from infinivar.drivetrain.cobotic import CoboticDrive

PAIRS = 3
BUILDS, IN_CYCLE, CELLS = 10_000, 2_000, 60
_PATHS = (
    "transmission.preload",
    "transmission.friction",
    "transmission.geometry.crown_radius",
    "transmission.geometry.axle_bearing.bore",
    "motor.resistance",
    "motor.torque_constant",
    "gearhead.efficiency",
    "guideway.coefficient",
)

_CYCLE = iv.DutyCycle(motion=iv.motion.Sinusoid(distance=0.03, frequency=2.0), load_mass=0.8)


def run() -> Iterator[Line]:
    """Measure both."""
    yield from _maps()
    yield _cycles()
    yield _calibration()


def _drive() -> CoboticDrive:
    drive = iv.load_study(STUDY).drives["cobotic"]
    assert isinstance(drive, CoboticDrive)
    return drive


def _maps() -> Iterator[Line]:
    drive = _drive()
    at = values_of(drive, _PATHS) * (0.95 + 0.1 * low_discrepancy(2**14, len(_PATHS))[:BUILDS])
    centres = (np.arange(CELLS) + 0.5) / CELLS
    axes = 1.4 * 1.05 * centres, 1.4 * 50.0 * centres
    plain = Mapper(drive, _PATHS, *axes)
    start = time.perf_counter()
    compiled = Mapper(drive, _PATHS, *axes, method="jax")
    compiled(at)
    whole = time.perf_counter() - start
    _agree(plain(at), compiled(at))

    def timed(mapper: Mapper) -> float:
        start = time.perf_counter()
        mapper(at)
        return time.perf_counter() - start

    a, b = in_turn(lambda: timed(compiled), lambda: timed(plain), PAIRS)
    print(f"uncertainty: JAX compiles, or loads what it compiled before, in {whole - statistics.median(a):.2g} s")
    what = f"{BUILDS:,} builds, {CELLS} x {CELLS} points"
    seconds = statistics.median(b)
    yield Line(
        what=f"{what}, NumPy", ours=f"{seconds:.3g} s", theirs="", ratio="", target="< 60 s", passed=seconds < 60.0
    )
    yield ratio_line(f"{what}, JAX", a, b, rival="NumPy", at_most=0.2)


def _cycles() -> Line:
    drive = _drive()
    at = values_of(drive, _PATHS) * (0.95 + 0.1 * low_discrepancy(2**14, len(_PATHS))[:IN_CYCLE])
    of = partial(outcomes.worked, duty=_CYCLE, travel=None)
    plain, compiled = (Batch(of, drive, _PATHS, width=3, engine=engine) for engine in ("numpy", "jax"))
    if not np.allclose(plain(at[:1000]), compiled(at[:1000]), rtol=1e-12, equal_nan=True):
        raise RuntimeError("NumPy and JAX differ in a cycle")

    def timed(batch: Batch) -> float:
        start = time.perf_counter()
        batch(at)
        return time.perf_counter() - start

    a, b = in_turn(lambda: timed(compiled), lambda: timed(plain), PAIRS)
    return ratio_line(f"{IN_CYCLE:,} builds in a cycle, JAX", a, b, rival="NumPy", at_most=0.25)


def _agree(one: BuildsMap, other: BuildsMap) -> None:
    for name in ("within", "efficiency", "spread"):
        a, b = getattr(one, name), getattr(other, name)
        if not np.allclose(a, b, rtol=1e-9, atol=1e-6, equal_nan=True):
            raise RuntimeError(f"NumPy and JAX differ in {name}")


def _calibration() -> Line:
    study, drive = iv.load_study(STUDY), _drive()
    settings = virtual_rig.protocol(drive, study.rig, ratios=tuple(np.geomspace(100.0, 1.0, 50)))
    data = virtual_rig.experiment(drive, study.rig, settings, simulated=False).data
    names = (*transmission.USUAL, "resistance")
    calibrate(study, "cobotic", data, parameters=names)
    taken = []
    for _ in range(PAIRS):
        start = time.perf_counter()
        calibrate(study, "cobotic", data, parameters=names)
        taken.append(time.perf_counter() - start)
    seconds = statistics.median(taken)
    return Line(
        what=f"calibration, {len(data)} runs, {len(names)} parameters",
        ours=f"{seconds:.3g} s",
        theirs="",
        ratio="",
        target="< 2 s",
        passed=seconds < 2.0,
    )
