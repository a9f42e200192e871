"""Run benchmarks, all or those named, and print one table: ``python -m benchmarks [NAME ...] [--strict]``."""

from __future__ import annotations

import argparse
import importlib
import os
import platform
import sys
import traceback

from rich.console import Console
from rich.table import Table

from benchmarks._measure import Line

NAMES = (
    "import_time",
    "steady_map",
    "steady_map_jax",
    "compare_cold",
    "element_curves",
    "exact_law",
    "fastsim",
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


def main() -> int:
    """Exit code: 0 done, 1 if a benchmark breaks, or misses its target under ``--strict``."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description="Ratios measured side by side.")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"any of {', '.join(NAMES)}; all if left out")
    parser.add_argument("--strict", action="store_true", help="exit with 1 if a target is missed")
    arguments = parser.parse_args()
    for name in arguments.names:
        if name not in NAMES:
            parser.error(f"no benchmark {name!r}; there are {', '.join(NAMES)}")

    lines: list[Line] = []
    broken = False
    for name in arguments.names or NAMES:
        print(f"{name}: measuring ...", flush=True)
        try:
            lines += importlib.import_module(f"benchmarks.{name}").run()
        except Exception:
            broken = True
            traceback.print_exc()
    # Piped into a file, the table must not be cut to 80 columns.
    Console(width=None if sys.stdout.isatty() else 160).print(_table(lines))
    missed = any(line.passed is False for line in lines)
    return int(broken or (arguments.strict and missed))


def _table(lines: list[Line]) -> Table:
    machine = f"Python {platform.python_version()}, {platform.machine()}, {os.cpu_count()} cores"
    table = Table(caption=f"Ratios: ours over theirs, median of pairs (middle half). {machine}.")
    for heading in ("what", "ours", "theirs", "ratio", "target", "verdict"):
        table.add_column(heading, justify="left" if heading in ("what", "theirs") else "right")
    for line in lines:
        verdict = {True: "[green]PASS", False: "[bold red]MISS", None: ""}[line.passed]
        table.add_row(line.what, line.ours, line.theirs, line.ratio, line.target, verdict)
    return table


if __name__ == "__main__":
    sys.exit(main())
