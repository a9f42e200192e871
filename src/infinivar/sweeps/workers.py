"""What a worker does: compute chunks, and end when the process that started it is gone."""

from __future__ import annotations

import importlib.metadata
import os
import signal
import threading
import time
from collections.abc import Mapping
from typing import NamedTuple

from infinivar import __version__
from infinivar._core.memory import kept
from infinivar._core.threads import at_most
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
    """Compute a chunk."""
    begin = time.perf_counter()
    chunk = job.problem.run(number)
    content = encoded(chunk, number, job.sweep)
    return Done(number, content, job.problem.best(chunk), time.perf_counter() - begin)


def compute_apart(job: Job, number: int) -> Done:
    """Compute a chunk in another process than the one that collects them.

    Raises
    ------
    InputError
        If this worker has other versions of the libraries than the process that collects the chunks.
    """
    here = versions()
    different = [
        f"{name} {here[name]} there, {other} here" for name, other in job.versions.items() if here[name] != other
    ]
    if different:
        raise InputError(f"a worker has other versions than this process: {'; '.join(different)}")
    with at_most(1), kept():
        return compute(job, number)


def watch(parent: int) -> None:
    """End this process soon after the one that started it is gone, and leave Ctrl-C to that one.

    A worker that waits for its first chunk must watch too: nobody would send it one.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def look() -> None:
        while os.getppid() == parent:
            time.sleep(_LOOK)
        os._exit(1)

    threading.Thread(target=look, name="parent watch", daemon=True).start()
