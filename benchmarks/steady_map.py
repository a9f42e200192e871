"""Steady map of the shipped cobotic drive, 3000 x 3000 points with all losses and limits, against scripts by hand.

Theirs is what an engineer writes in an afternoon for this one machine: the same equations over whole arrays, in NumPy
(``by_hand/steady_map.py``) and in GNU Octave (``by_hand/steady_map.m``). The scripts hold the same outputs as
`SteadyMap` and read the same parameters. They are spared what the package does beyond that: other quadrants, other
laws, the power audit of every point; and outputs that do not vary over the grid are not filled in.

Each run is a fresh process that times the computation alone, so that interpreters and imports do not count, and
reports its peak memory. Whole arrays of this size come from the operating system page by page, which is part of the
scripts' cost; how large a part depends on the machine, so times of one machine do not carry over to another.

A ratio counts only if all outputs agree: NumPy's at every point, Octave's at every tenth along each axis.
"""

from __future__ import annotations

import json
import shutil
import statistics
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from benchmarks import _measure
from benchmarks._measure import ROOT, Line, in_turn, ratio_line

NUMPY_PAIRS, OCTAVE_PAIRS = 5, 3
AGREEMENT = 1e-9
"""Largest accepted difference of an output, relative to its value."""
MEMORY = 1.5
"""Largest accepted peak memory. [GiB]"""

_WHAT = "steady map, 3000 x 3000"
_BY_HAND = ROOT / "benchmarks" / "by_hand"
# Linux counts ru_maxrss in KiB, macOS in bytes.
_RSS_PER_GIB = 2**30 if sys.platform == "darwin" else 2**20

Run = dict[str, float]


def run() -> Iterator[Line]:
    """Measure both rivals, check that they compute the same, and report the memory."""
    octave = shutil.which("octave-cli")
    with tempfile.TemporaryDirectory() as directory:
        parameters, coarse = Path(directory) / "parameters.json", Path(directory) / "coarse.bin"
        worker = (sys.executable, "-m", "benchmarks._steady_map_worker")
        _measure.run([*worker, "parameters", parameters])

        def ours() -> Run:
            return json.loads(_measure.run([*worker, "ours", parameters]))

        def numpy() -> Run:
            return json.loads(_measure.run([sys.executable, _BY_HAND / "steady_map.py", parameters]))

        def in_octave() -> Run:
            return json.loads(
                _measure.run([str(octave), "--quiet", "--norc", _BY_HAND / "steady_map.m", parameters, coarse])
            )

        if octave is None:
            print("steady_map: octave-cli is not installed, the comparison with GNU Octave is left out")
        else:
            in_octave()  # leaves its outputs, which are compared before any ratio is said
        _agree(json.loads(_measure.run([*worker, "agree", parameters, coarse])))
        here, there = in_turn(ours, numpy, NUMPY_PAIRS)
        yield ratio_line(_WHAT, _seconds(here), _seconds(there), rival="NumPy by hand", at_most=1.0)
        yield _memory_line(here, there)
        if octave is not None:
            here, there = in_turn(ours, in_octave, OCTAVE_PAIRS)
            yield ratio_line(_WHAT, _seconds(here), _seconds(there), rival="Octave by hand", at_most=1 / 3)


def _agree(differences: dict[str, dict[str, float]]) -> None:
    for rival, by_output in differences.items():
        worst = max(by_output, key=by_output.__getitem__)
        print(f"steady_map: {rival} by hand agrees within {by_output[worst]:.0e} of each value (widest: {worst})")
        if not by_output[worst] <= AGREEMENT:
            raise RuntimeError(f"{rival} by hand does not compute the same: {by_output}")


def _seconds(runs: Sequence[Run]) -> list[float]:
    return [run["seconds"] for run in runs]


def _memory_line(ours: Sequence[Run], theirs: Sequence[Run]) -> Line:
    here, there = (statistics.median(run["maxrss"] for run in runs) / _RSS_PER_GIB for runs in (ours, theirs))
    return Line(
        what=f"{_WHAT}, peak memory",
        ours=f"{here:.2f} GiB",
        theirs=f"NumPy by hand: {there:.2f} GiB",
        ratio=f"{here / there:.2f}",
        target=f"ours <= {MEMORY} GiB",
        passed=here <= MEMORY,
    )
