"""``infinivar compare`` from a cold start against importing the libraries it stands on.

Ours is the whole command in a fresh process: read the shipped study, compute and audit the maps of its drives, draw,
write report, results and NetCDF files. Theirs only imports NumPy, SciPy's optimizers and pyplot: what a script
that did the same would wait for before its first line. The ratio tells how much waiting the program adds.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from benchmarks._measure import STUDY, Line, in_turn, ratio_line, wall_time

PAIRS = 5
IMPORTS = "import numpy, scipy.optimize, matplotlib.pyplot"


def _compare() -> float:
    with tempfile.TemporaryDirectory() as directory:
        seconds = wall_time([sys.executable, "-m", "infinivar", "compare", STUDY, "--out", directory])
        written = {path.suffix for path in Path(directory).iterdir()}
    if not written >= {".html", ".json", ".nc"}:
        raise RuntimeError(f"compare wrote only {sorted(written)}")
    return seconds


def run() -> Iterator[Line]:
    """Measure the line."""
    ours, theirs = in_turn(_compare, lambda: wall_time([sys.executable, "-c", IMPORTS]), PAIRS)
    yield ratio_line("infinivar compare, cold", ours, theirs, rival="imports alone", at_most=4.0)
