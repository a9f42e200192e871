"""Run benchmarks, all or those named, and print each line once it is measured: ``python -m benchmarks [NAME ...] [--strict]``.

All together take less than fifteen minutes on two cores that do nothing else.
"""

from __future__ import annotations

import argparse
import importlib
import os
import platform
import sys
import time
import traceback
from collections import Counter

from rich.console import Console
from rich.table import Table

NAMES = (
    "import_time",
    "steady_map",
    "steady_map_jax",
    "commands",
    "compare_cold",
    "element_curves",
    "exact_law",
    "exact_contact",
    "simulation",
    "dynamic",
    "recording",
    "recording_files",
    "uncertainty",
    "catalogue",
    "sizing_geared",
    "sizing_cobotic",
    "legs",
    "machine_motion",
    "sessions",
    "explorer",
)

_SHARES = {"what": 42, "ours": 18, "theirs": 26, "ratio": 20, "target": 13}
"""Columns, and how they share the width that the verdict leaves."""


def main() -> int:
    """Exit code: 0 done, 1 if a benchmark breaks, or misses its target under ``--strict``."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description="Ratios measured side by side.")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"any of {', '.join(NAMES)}; all if left out")
    parser.add_argument("--strict", action="store_true", help="exit with 1 if a target is missed")
    arguments = parser.parse_args()
    for name in arguments.names:
        if name not in NAMES:
            parser.error(f"no benchmark {name!r}; there are {', '.join(NAMES)}")

    start = time.perf_counter()
    # Piped into a file, lines must not be cut to 80 columns.
    console = Console(width=None if sys.stdout.isatty() else 160)
    machine = f"Python {platform.python_version()}, {platform.machine()}, {os.cpu_count()} cores"
    print(f"Ratios: ours over theirs, median of pairs (middle half). {machine}.")
    console.print(_row(*_SHARES, ""))
    verdicts: Counter[bool | None] = Counter()
    broken = []
    for name in arguments.names or NAMES:
        print(f"{name}: measuring ...", flush=True)
        try:
            for line in importlib.import_module(f"benchmarks.{name}").run():
                verdict = {True: "[green]PASS", False: "[bold red]MISS", None: ""}[line.passed]
                console.print(_row(line.what, line.ours, line.theirs, line.ratio, line.target, verdict))
                verdicts[line.passed] += 1
        except Exception:
            broken.append(name)
            traceback.print_exc()
    stopped = f"; stopped by an error: {', '.join(broken)}" if broken else ""
    seconds = time.perf_counter() - start
    print(f"Targets: {verdicts[True]} met, {verdicts[False]} missed; {seconds:.0f} s in total{stopped}.")
    return int(bool(broken) or (arguments.strict and verdicts[False] > 0))


def _row(*cells: str) -> Table:
    """A row of the table by itself, as columns must not wait for the rows that follow."""
    row = Table.grid(padding=(0, 2, 0, 0), expand=True)
    for heading, share in _SHARES.items():
        row.add_column(ratio=share, justify="left" if heading in ("what", "theirs") else "right")
    row.add_column(width=4)
    row.add_row(*cells)
    return row


if __name__ == "__main__":
    sys.exit(main())
