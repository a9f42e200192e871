"""Measuring two sides in turn, and one line of the table for what came out."""

from __future__ import annotations

import os
import statistics
import subprocess
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

T = TypeVar("T")

ROOT = Path(__file__).resolve().parents[1]
STUDY = ROOT / "studies" / "hand_controller.toml"


@dataclass(frozen=True, slots=True, kw_only=True)
class Line:
    """One line of the table; `passed` is None where there is no target."""

    what: str
    ours: str
    theirs: str
    ratio: str
    target: str = ""
    passed: bool | None = None


def run(command: Sequence[str | Path]) -> str:
    """Standard output of a fresh process.

    Bytecode is cached, as it is for any installed program, whatever the environment says.

    Raises
    ------
    RuntimeError
        If the process does not end with 0; the message has its errors.
    """
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(map(str, command))} ended with {done.returncode}:\n{done.stderr}")
    return done.stdout


def wall_time(command: Sequence[str | Path]) -> float:
    """Seconds that a fresh process takes, start to end."""
    start = time.perf_counter()
    run(command)
    return time.perf_counter() - start


def timed(call: Callable[[], object]) -> Callable[[], float]:
    """Seconds that a call takes, as a function."""

    def seconds() -> float:
        start = time.perf_counter()
        call()
        return time.perf_counter() - start

    return seconds


def in_turn(ours: Callable[[], T], theirs: Callable[[], T], pairs: int) -> tuple[list[T], list[T]]:
    """Results of both sides, run A B A B ... after one run of each that warms the caches and does not count."""
    ours()
    theirs()
    results = [(ours(), theirs()) for _ in range(pairs)]
    return [a for a, _ in results], [b for _, b in results]


def ratio_line(
    what: str, ours: Sequence[float], theirs: Sequence[float], *, rival: str, at_most: float | None = None
) -> Line:
    """Line for seconds of two sides measured in turn.

    The ratio is the median over the pairs, as both runs of a pair see the machine in the same mood; its middle half
    is printed beside it.
    """
    ratios = [a / b for a, b in zip(ours, theirs, strict=True)]
    low, middle, high = statistics.quantiles(ratios, n=4, method="inclusive")
    return Line(
        what=what,
        ours=f"{statistics.median(ours):.3g} s",
        theirs=f"{rival}: {statistics.median(theirs):.3g} s",
        ratio=f"{middle:.2f} ({low:.2f} to {high:.2f})",
        target="" if at_most is None else f"<= {at_most:.3g}",
        passed=None if at_most is None else middle <= at_most,
    )
