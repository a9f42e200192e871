"""Fig 17, both drives on 60 x 60 cells of 200 samples, against GNU Octave by hand; and one duty cycle of 10,000 samples.

Theirs is a vectorised script of the same equations (``by_hand/dynamic.m``) that gives performance alone; ours gives
limits, margins, losses by element and the energy audit, too. Each run is a fresh process that times the computation.
The duty cycle, with settled temperatures, warm windings, limits, holding and losses by element, is compared with bare NumPy
inverse dynamics of the same drive (``by_hand/duty_cycle.py``) in this process. A ratio counts only if both agree.
"""

from __future__ import annotations

import json
import shutil
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks import _dynamic_worker, _measure
from benchmarks._measure import ROOT, Line, in_turn, ratio_line
from benchmarks.by_hand import duty_cycle as by_hand
from infinivar import DutyCycle
from infinivar.analysis.cycles.duty_cycle import duty_cycle
from infinivar.motion import Walking

PAIRS = 7
AGREEMENT = 1e-8
"""Largest accepted relative difference: by hand the angle is iterated until it moves by less than 1e-9."""
_DUTY = DutyCycle(
    motion=Walking(joint="knee", body_mass=20.0, stride_time=1.1, lever_arm=0.05, share=0.25), load_mass=0.0
)
_DUTY_SAMPLES = 10_000


def run() -> Iterator[Line]:
    """Measure both."""
    with tempfile.TemporaryDirectory() as directory:
        parameters, here, there = (Path(directory) / name for name in ("parameters.json", "ours.bin", "theirs.bin"))
        worker = (sys.executable, "-m", "benchmarks._dynamic_worker")
        _measure.run([*worker, "parameters", parameters, here])
        octave = shutil.which("octave-cli")
        if octave is None:
            print("dynamic: octave-cli is not installed, the comparison with GNU Octave is left out")
        else:
            yield _fig17(worker, octave, parameters, here, there)
        yield _duty(json.loads(parameters.read_text("utf-8")))


def _fig17(worker: tuple[str, ...], octave: str, parameters: Path, here: Path, there: Path) -> Line:
    def ours() -> float:
        return json.loads(_measure.run([*worker, "ours", parameters, here]))["seconds"]

    def theirs() -> float:
        script = ROOT / "benchmarks" / "by_hand" / "dynamic.m"
        return json.loads(_measure.run([octave, "--quiet", "--norc", script, parameters, there]))["seconds"]

    a, b = in_turn(ours, theirs, PAIRS)
    _agree("Octave", np.fromfile(here), np.fromfile(there))
    return ratio_line("Fig 17, both drives, 60 x 60 x 200", a, b, rival="Octave by hand", at_most=1.0)


def _duty(given: dict) -> Line:
    drive, _ = _dynamic_worker.drives()
    given = {**given, "load_mass": 0.0}
    instants = _DUTY.instants(_DUTY_SAMPLES)
    names = ("speed", "acceleration", "jerk", "snap", "force", "force_rate", "force_curvature")
    course = {name: np.asarray(getattr(instants.course, name)) for name in names}
    _agree(
        "NumPy",
        np.asarray(drive.follow(instants.course).power_in),
        by_hand.power_in(given, course),
    )

    def ours() -> float:
        start = time.perf_counter()
        duty_cycle(drive, _DUTY, samples=_DUTY_SAMPLES)
        return time.perf_counter() - start

    def theirs() -> float:
        start = time.perf_counter()
        by_hand.power_in(given, course)
        return time.perf_counter() - start

    a, b = in_turn(ours, theirs, 5 * PAIRS)
    return ratio_line("duty cycle, 10,000 samples", a, b, rival="bare NumPy inverse dynamics", at_most=20.0)


def _agree(rival: str, ours: np.ndarray, theirs: np.ndarray) -> None:
    known = ~np.isnan(ours)
    worst = float(np.max(np.abs(ours - theirs)[known] / np.maximum(np.abs(ours[known]), 1e-3)))
    print(f"dynamic: {rival} by hand agrees within {worst:.0e}")
    if not np.array_equal(known, ~np.isnan(theirs)) or not worst <= AGREEMENT:
        raise RuntimeError(f"{rival} by hand does not compute the same: {worst:g}")
