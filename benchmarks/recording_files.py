"""Reading a recording of a minute at 1 kHz, four columns, with comma and point or semicolon and comma, against NumPy's reader.

The other side reads the numbers below a known heading with `numpy.loadtxt`, which is given the marks that the file uses. Ours
finds out marks, units and columns and keeps the number of each line.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks._measure import Line, in_turn, ratio_line, timed
from infinivar.motion.files.reading import read_table

PAIRS = 5
ROWS = 60_001
MOST = 3.0
"""Time of ours over that of the other side."""


def run() -> Iterator[Line]:
    """Measure both kinds of marks."""
    with tempfile.TemporaryDirectory() as directory:
        for marks in ((",", "."), (";", ",")):
            yield _line(Path(directory), *marks)


def _line(folder: Path, mark: str, decimal: str) -> Line:
    at = np.arange(ROWS) / 1000.0
    rows = [f"{t:.3f} {100 * np.sin(t):.4f} {np.cos(t):.5f} {t:.2f}" for t in at.tolist()]
    text = "\n".join(
        ["t [s] pos [mm] F [N] T [degC]".replace("] ", f"]{mark}"), *(row.replace(" ", mark) for row in rows)]
    )
    file = folder / "recording.csv"
    file.write_text(text.replace(".", decimal), "utf-8")

    def by_numpy() -> np.ndarray:
        said = file.read_text("utf-8").replace(decimal, ".").splitlines()
        return np.loadtxt(said, delimiter=mark, skiprows=1)

    if len(read_table(file)) != ROWS or by_numpy().shape != (ROWS, 4):
        raise RuntimeError("one side does not read every row")
    ours, theirs = in_turn(timed(lambda: read_table(file)), timed(by_numpy), PAIRS)
    what = f"read {ROWS:,} rows, columns by {mark!r}, decimals by {decimal!r}"
    return ratio_line(what, ours, theirs, rival="numpy.loadtxt", at_most=MOST)
