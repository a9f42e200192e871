"""What users wait for: commands on shipped studies, in a fresh process each, with all their files.

Ours is the time from start to end, and to the first line that a command prints, which is its verdict. Beside it stands the
processor time of the command with its processes, which other work on the machine changes less. Targets are for two cores that do
nothing else, and the second run of each command: the first compiles runs and bytecode.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from benchmarks._measure import ROOT, Line

RUNS = 2
"""Of each command; the last one counts."""


class Command(NamedTuple):
    """A command, and in how many seconds it should print its verdict and end."""

    words: str
    within: float
    verdict: float | None = None


COMMANDS = (
    Command("compare knee_walking", 5.0, 1.5),
    Command("simulate hand_controller", 2.0),
    Command("contact hand_controller", 3.0),
    Command("reproduce", 12.0),
    Command("size knee_walking", 20.0),
    Command("session guided_cart", 2.0),
)


class Spent(NamedTuple):
    """Seconds that a run takes."""

    first: float
    """To the first line."""
    whole: float
    user: float
    """Of the processors, in the program and for it in the system, with all processes."""


def spent(words: str, source: Path = ROOT / "src") -> Spent:
    """Run a command of the package in `source` in a fresh process and folder.

    Raises
    ------
    RuntimeError
        If it ends with another code than 0 or 1, an answer that is not feasible.
    """
    with tempfile.TemporaryDirectory() as directory:
        command = [sys.executable, "-m", "infinivar", *words.split(), "--out", directory]
        environment = os.environ | {"PYTHONPATH": str(source)}
        before, start = os.times(), time.perf_counter()
        with subprocess.Popen(
            command, cwd=directory, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        ) as process:
            assert process.stdout is not None
            process.stdout.readline()
            first = time.perf_counter() - start
            _, said = process.communicate()
        whole, after = time.perf_counter() - start, os.times()
    if process.returncode not in (0, 1):
        raise RuntimeError(f"{words} ended with {process.returncode}:\n{said}")
    user = sum(getattr(after, name) - getattr(before, name) for name in ("children_user", "children_system"))
    return Spent(first, whole, user)


def run() -> Iterator[Line]:
    """Measure the lines."""
    for words, within, verdict in COMMANDS:
        found = [spent(words) for _ in range(RUNS)][-1]
        processor = f"{found.user:.1f} s of processors"
        yield _line(words, found.whole, processor, within)
        if verdict is not None:
            yield _line(f"{words}, verdict", found.first, processor, verdict)


def _line(what: str, seconds: float, processor: str, within: float) -> Line:
    return Line(
        what=what,
        ours=f"{seconds:.1f} s",
        theirs=processor,
        ratio=f"{seconds / within:.2f}",
        target=f"<= {within:g} s",
        passed=seconds <= within,
    )
