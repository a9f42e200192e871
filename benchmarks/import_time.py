"""``import infinivar`` against ``import numpy``.

Both run in a fresh process of the same interpreter, whose start counts on both sides. NumPy is the fair measure because
every study needs it: a package that is imported in no more time costs its users nothing they do not pay anyway. As the
public names load on first use, a second line, which has no target, shows what it takes to have those of a steady map. The
third reads the shipped study, with which every script and every command begins.
"""

from __future__ import annotations

import sys

from benchmarks._measure import Line, in_turn, ratio_line, wall_time

PAIRS = 15
FIRST_USE = "from infinivar import load_study, steady_map"
STUDY = "from infinivar import load_study; load_study('hand_controller')"


def _seconds(statement: str) -> float:
    return wall_time([sys.executable, "-c", statement])


def run() -> list[Line]:
    """Measure the three lines."""
    bare, numpy = in_turn(lambda: _seconds("import infinivar"), lambda: _seconds("import numpy"), PAIRS)
    used, numpy_again = in_turn(lambda: _seconds(FIRST_USE), lambda: _seconds("import numpy"), PAIRS)
    loaded, numpy_third = in_turn(lambda: _seconds(STUDY), lambda: _seconds("import numpy"), PAIRS)
    return [
        ratio_line("import infinivar", bare, numpy, rival="import numpy", at_most=1.3),
        ratio_line(FIRST_USE, used, numpy_again, rival="import numpy"),
        ratio_line("load the shipped study, cold", loaded, numpy_third, rival="import numpy", at_most=3.0),
    ]
