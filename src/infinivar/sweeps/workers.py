"""What a worker does: compute chunks, and end when the process that started it is gone."""

from __future__ import annotations

import contextlib
import importlib.metadata
import os
import signal
import threading
import time
from collections.abc import Mapping
from typing import NamedTuple

from infinivar import __version__
from infinivar.errors import InputError
from infinivar.sweeps.problem import Problem
from infinivar.sweeps.storage import encoded

_LIBRARIES = ("numpy", "scipy", "jax")
"""On the versions of which the last digits of a result depend, besides our own."""
_LOOK = 0.25
"""Time between two looks at the parent. [s]"""


class Job(NamedTuple):
    """What every worker is sent."""

    problem: Problem
    sweep: str
    """Digest of the sweep's description."""
    versions: Mapping[str, str]
    """Of the process that collects the chunks."""


class Done(NamedTuple):
    """A chunk that was computed."""

    number: int
    content: bytes
    """Of its file."""
    best: tuple[float, str] | None
    """See `Problem.best`."""
    seconds: float
    """Time to compute it. [s]"""


def versions() -> dict[str, str]:
    """Versions of the libraries here."""
    found = {"infinivar": __version__}
    for name in _LIBRARIES:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            found[name] = "not installed"
    return found


def compute(job: Job, number: int) -> Done:
    """Compute a chunk.

    Raises
    ------
    InputError
        If this worker has other versions of the libraries than the process that collects the chunks.
    """
    begin = time.perf_counter()
    chunk = job.problem.run(number)
    content = encoded(chunk, number, job.sweep)
    return Done(number, content, job.problem.best(chunk), time.perf_counter() - begin)


def compute_apart(job: Job, number: int, parent: int | None) -> Done:
    """Compute a chunk in a process that another started, `parent` on the same machine; else as `compute`."""
    here = versions()
    different = [
        f"{name} {here[name]} there, {other} here" for name, other in job.versions.items() if here[name] != other
    ]
    if different:
        raise InputError(f"a worker has other versions than this process: {'; '.join(different)}")
    if parent not in (None, os.getpid()):  # joblib starts no process for a single worker
        _watch(parent)
    return compute(job, number)


_watched: set[int | None] = set()


def _watch(parent: int | None) -> None:
    """End this process soon after its parent is gone, and leave Ctrl-C to the parent."""
    if parent in _watched:
        return
    _watched.add(parent)
    with contextlib.suppress(ValueError):  # only the main thread can
        signal.signal(signal.SIGINT, signal.SIG_IGN)

    def look() -> None:
        while os.getppid() == parent:
            time.sleep(_LOOK)
        os._exit(1)

    threading.Thread(target=look, name="parent watch", daemon=True).start()
