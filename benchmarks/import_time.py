"""``import infinivar`` against ``import numpy``.

Both run in a fresh process of the same interpreter, whose start counts on both sides. NumPy is the fair measure because
every study needs it: a package that is imported in no more time costs its users nothing they do not pay anyway. As the
public names load on first use, a second line, which has no target, shows what it takes to have those of a steady map. The
third reads the shipped study, with which every script and every command begins.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from functools import partial

from benchmarks._measure import Line, in_turn, ratio_line, wall_time

PAIRS = 15
FIRST_USE = "from infinivar import load_study, steady_map"
STUDY = "from infinivar import load_study; load_study('hand_controller')"


def _seconds(statement: str) -> float:
    return wall_time([sys.executable, "-c", statement])


def run() -> Iterator[Line]:
    """Measure the three lines."""
    for what, statement, at_most in (
        ("import infinivar", "import infinivar", 1.3),
        (FIRST_USE, FIRST_USE, None),
        ("load the shipped study, cold", STUDY, 3.0),
    ):
        ours, theirs = in_turn(partial(_seconds, statement), partial(_seconds, "import numpy"), PAIRS)
        yield ratio_line(what, ours, theirs, rival="import numpy", at_most=at_most)
