"""Times of another commit and of this checkout, in turn on one machine: ``python -m benchmarks.before COMMIT``.

Prints a table in Markdown: processor seconds of runs a simulated second, points of a map a second, and of commands with all
their files the time on the clock and of the processors. Each commit reads its own studies. Each time is one of a fresh process
after a run that does not count; commands run twice and the second counts. What the other commit cannot run says so.
"""

from __future__ import annotations

import argparse
import io
import os
import subprocess
import sys
import tarfile
import tempfile
from collections.abc import Callable
from pathlib import Path

from benchmarks._measure import ROOT
from benchmarks.commands import COMMANDS, Spent, spent

_RUN = """
import sys, time
{imports}
made = {call}
made()
start = {clock}()
made()
print({result})
"""
_DRIVE = (
    "import infinivar as iv; study = iv.load_study('studies/hand_controller.toml'); from dataclasses import replace"
)
_MAP = "import numpy as np, infinivar as iv; drive = iv.load_study('studies/hand_controller.toml').drives['{}']"

RUNS = {
    "cobotic drive, reach": (_DRIVE, "lambda: iv.simulate(study.drives['cobotic'], study.scenarios['reach'])", 2.0),
    "geared drive, reach": (_DRIVE, "lambda: iv.simulate(study.drives['motor2-gear4'], study.scenarios['reach'])", 2.0),
    "session of a cart": ("from benchmarks.sessions import planar", "planar", 2.0),
    "session of six legs": ("from benchmarks.sessions import legs", "legs", 0.5),
    "six legs on a circle": (
        "import infinivar as iv; from benchmarks.machine_motion import platform; machine, scenario = platform()",
        "lambda: iv.simulate_machine(machine, scenario)",
        0.4,
    ),
}
"""Imports, call, and simulated seconds of a run."""

MAPS = {"cobotic": "(2.0, 75.0)", "motor2-gear4": "(2.0, 75.0)"}
"""Drives of the hand controller, and the largest speed and force of a map of 3000 x 3000 points."""


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.before", description=__doc__)
    parser.add_argument("commit", help="the commit to compare with")
    commit = parser.parse_args().commit
    with tempfile.TemporaryDirectory() as scratch:
        archive = subprocess.run(
            ["git", "archive", commit, "src", "studies"], cwd=ROOT, capture_output=True, check=True
        ).stdout
        with tarfile.open(fileobj=io.BytesIO(archive)) as tar:
            tar.extractall(scratch, filter="data")
        sides = (Path(scratch), ROOT)
        print(f"| what | {commit} | now |\n| --- | --- | --- |", flush=True)
        for what, (imports, call, seconds) in RUNS.items():
            result = f"(time.process_time() - start) / {seconds}"
            text = _RUN.format(imports=imports, call=call, clock="time.process_time", result=result)
            _row(f"{what}, CPU s a simulated s", sides, lambda side, text=text: _script(text, side))
        for name, ends in MAPS.items():
            axes = f"[np.linspace(-end, end, 3000) for end in {ends}]"
            text = _RUN.format(
                imports=_MAP.format(name),
                call=f"lambda: iv.steady_map(drive, *{axes})",
                clock="time.perf_counter",
                result="9.0 / (time.perf_counter() - start)",
            )
            _row(f"map of {name}, million points/s", sides, lambda side, text=text: _script(text, side))
        for command in COMMANDS:
            _row(
                f"{command.words}: s, CPU s, s to the verdict",
                sides,
                lambda side, one=command: _command(one.words, side),
            )
    return 0


def _row(what: str, sides: tuple[Path, Path], measured: Callable[[Path], str]) -> None:
    print(f"| {what} | {' | '.join(measured(side) for side in sides)} |", flush=True)


def _script(text: str, side: Path) -> str:
    environment = os.environ | {"PYTHONPATH": f"{side / 'src'}{os.pathsep}{ROOT}"}
    done = subprocess.run([sys.executable, "-c", text], env=environment, cwd=side, capture_output=True, text=True)
    return f"{float(done.stdout):.3g}" if done.returncode == 0 else f"error: {done.stderr.strip().splitlines()[-1]}"


def _command(words: str, side: Path) -> str:
    verb, *study = words.split()
    words = " ".join([verb, *(str(side / "studies" / f"{name}.toml") for name in study)])
    try:
        found = [spent(words, side / "src") for _ in range(2)][-1]
    except RuntimeError as problem:
        return f"error: {str(problem).splitlines()[-1]}"
    return _shown(found)


def _shown(found: Spent) -> str:
    return f"{found.whole:.1f}, {found.user:.1f}, {found.first:.1f}"


if __name__ == "__main__":
    sys.exit(main())
