"""Where chunks are computed, in this process, in several processes of this machine or on a cluster, and what a worker does.

A worker ends when the process that started it is gone. The memory of large arrays stays with it from one array to the next: the C
library of GNU gives the memory of an array from 128 KiB on back to the system when the array is deleted. It raises that size by
itself, unless a threshold was set, as Dask's nanny does for its workers (MALLOC_TRIM_THRESHOLD_): then every page of every array
is requested anew, which takes several times as long as the computation.
"""

from __future__ import annotations

import contextlib
import ctypes
import importlib.metadata
import itertools
import os
import threading
import time
import warnings
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from concurrent.futures.process import BrokenProcessPool
from functools import partial
from queue import Empty, SimpleQueue
from typing import Any, NamedTuple

from infinivar import __version__
from infinivar._core import extras
from infinivar._core.processes import watch
from infinivar._core.threads import at_most
from infinivar.errors import InputError, printable, require
from infinivar.sweeps.problem import Problem
from infinivar.sweeps.storage import encoded

_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3
"""Parameters of `mallopt`."""
_KEPT = 2**28
"""Memory that stays though it is free. [bytes]"""
_LARGEST = 2**25
"""Largest array of which it does, the most that the library permits. [bytes]"""
_USUAL_LARGEST = 2**17
_VARIABLE = "MALLOC_TRIM_THRESHOLD_"

_lock, _inside = threading.Lock(), 0


@contextlib.contextmanager
def kept() -> Iterator[None]:
    """Keep the memory of deleted arrays in the block, and give it back after; nothing changes with other C libraries."""
    library = _library()
    if library is not None:
        _count(1, library)
    try:
        yield
    finally:
        if library is not None:
            _count(-1, library)


def _library() -> ctypes.CDLL | None:
    """The C library of GNU, if this process uses it."""
    try:
        if "glibc" not in (os.confstr("CS_GNU_LIBC_VERSION") or ""):
            return None
        return ctypes.CDLL(None)
    except (AttributeError, OSError, ValueError):  # no such name, or no such function on this system
        return None


def _count(change: int, library: ctypes.CDLL) -> None:
    """Enter or leave a block; the first and the last of all threads change the parameters."""
    global _inside
    with _lock:
        _inside += change
        if change > 0 and _inside == 1:
            library.mallopt(_MMAP_THRESHOLD, _LARGEST)
            library.mallopt(_TRIM_THRESHOLD, _KEPT)
        elif not _inside:
            before = os.environ.get(_VARIABLE, "")
            if before.isdecimal():
                library.mallopt(_MMAP_THRESHOLD, _USUAL_LARGEST)
                library.mallopt(_TRIM_THRESHOLD, min(int(before), 2**31 - 1))
            library.malloc_trim(ctypes.c_size_t(0))


_LOST_IN_A_ROW = 3
"""Times that workers may be lost without a chunk done in between."""
_WAITING = 3
"""Chunks at hand for each thread of a cluster, so that none waits for this process."""
_PATIENCE = 20
"""Time to connect to a cluster. [s]"""

_WARNINGS = "PYTHONWARNINGS"
"""Variable from which Python reads how to treat warnings, when it starts."""


_LIBRARIES = ("numpy", "scipy", "jax")
"""On the versions of which the last digits of a result depend, besides our own."""


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


Executor = Callable[[Job, Sequence[int]], Generator[Done, None, None]]
"""Yields the chunks of some numbers as they are done, in any order."""


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


@contextlib.contextmanager
def executor_of(workers: int | None, dask: str | None) -> Iterator[Executor]:
    """Choose where to compute, and stay connected to a cluster while the block lasts.

    Raises
    ------
    InputError
        If both are given, `workers` is no whole number above 0, a library is missing, or no scheduler answers.
    """
    if workers is not None and dask is not None:
        raise InputError("workers and dask are both given: choose processes of this machine, or a cluster")
    if dask is not None:
        extras.load("distributed", "scale", "a sweep on a cluster")
        with _connected(dask) as client:
            yield partial(on_cluster, client=client, address=dask)
    elif workers is None:
        yield in_this_process
    else:
        require(isinstance(workers, int) and not isinstance(workers, bool) and workers >= 1, "workers", workers, ">= 1")
        extras.load("joblib", "scale", "a sweep with several workers")
        yield partial(in_processes, workers=workers)


def in_this_process(job: Job, numbers: Sequence[int]) -> Generator[Done, None, None]:
    """Compute one chunk after the other."""
    for number in numbers:
        yield compute(job, number)


def in_processes(job: Job, numbers: Sequence[int], *, workers: int) -> Generator[Done, None, None]:
    """Compute in processes of this machine, by joblib; where one is lost, others take over its chunk.

    Raises
    ------
    InputError
        If workers are lost again and again.
    """
    left, lost = dict.fromkeys(numbers), 0
    while left:
        try:
            for done in _by_joblib(job, list(left), workers):
                del left[done.number]
                lost = 0
                yield done
        except BrokenProcessPool as problem:
            lost += 1
            if lost == _LOST_IN_A_ROW:
                raise InputError(
                    f"workers were lost {lost} times in a row, perhaps because memory ran out: {len(left)} chunks are left; "
                    "continue with --resume (resume=True) and fewer workers"
                ) from problem


def _by_joblib(job: Job, numbers: Sequence[int], workers: int) -> Generator[Done, None, None]:
    import joblib
    from joblib.externals.loky import get_reusable_executor

    # Memory shared by files would outlive a process that is killed; a job is small beside the work on a chunk.
    options: dict[str, Any] = {"batch_size": 1, "pre_dispatch": "2 * n_jobs", "max_nbytes": None}
    _start_tracker()
    with joblib.parallel_config("loky", inner_max_num_threads=1, initializer=watch, initargs=(os.getpid(),)):
        parallel: Any = joblib.Parallel(n_jobs=workers, return_as="generator_unordered", **options)
        found = parallel(joblib.delayed(compute_apart)(job, number) for number in numbers)
    try:
        for done in found:  # noqa: UP028 - closed below, not by `yield from`
            yield done
    except BaseException:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # of chunks that are done and not fetched
            found.close()
        get_reusable_executor().shutdown(wait=False, kill_workers=True)
        raise


def _start_tracker() -> None:
    """Start the process that removes semaphores after this one is killed, without the warning that it then prints."""
    from joblib.externals.loky.backend import resource_tracker

    before = os.environ.get(_WARNINGS)
    os.environ[_WARNINGS] = ",".join(filter(None, (before, "ignore:resource_tracker:UserWarning")))
    try:
        resource_tracker.ensure_running()
    finally:
        if before is None:
            del os.environ[_WARNINGS]
        else:
            os.environ[_WARNINGS] = before


def _connected(address: str) -> Any:
    """A client of the scheduler at an address."""
    import distributed

    try:
        return distributed.Client(address, timeout=_PATIENCE, set_as_default=False)
    except (OSError, ValueError) as problem:
        raise InputError(
            f"no scheduler of a cluster answers at {printable(address)}: {printable(problem)}"
        ) from problem


def on_cluster(job: Job, numbers: Sequence[int], *, client: Any, address: str) -> Generator[Done, None, None]:
    """Compute on a Dask cluster; the scheduler gives the chunks of a lost worker to others.

    Raises
    ------
    InputError
        If the cluster is lost, or a chunk loses one worker after another.
    """
    # A task, not data: data whose only worker is lost would be lost with it.
    shared = client.submit(_itself, job, pure=False)
    waiting, arriving, pending = iter(numbers), SimpleQueue(), set()

    def submit(count: int) -> None:
        for number in itertools.islice(waiting, count):
            future = client.submit(compute_apart, shared, number, pure=False)
            pending.add(future)
            future.add_done_callback(arriving.put)

    submit(_WAITING * max(1, _threads(client)))
    while pending:
        future = _next(arriving, client, address)
        pending.remove(future)
        yield _received(future, address)
        future.release()
        submit(1)


def _next(arriving: SimpleQueue[Any], client: Any, address: str) -> Any:
    """The next future that is done, unless the cluster has been without workers for a while."""
    idle = 0
    while True:
        try:
            return arriving.get(timeout=_PATIENCE)
        except Empty:
            idle = 0 if _threads(client) else idle + 1
        if idle > 1:
            raise InputError(
                f"the cluster at {printable(address)} has no workers; continue with --resume (resume=True) when it has"
            )


def _threads(client: Any) -> int:
    """Number of threads of all workers; 0 where the scheduler does not answer."""
    with contextlib.suppress(OSError):
        return sum(client.nthreads().values())
    return 0


def _itself(job: Job) -> Job:
    return job


def _received(future: Any, address: str) -> Done:
    """Result of a chunk from a cluster."""
    import distributed
    from distributed.comm.core import CommClosedError

    try:
        return future.result()
    except distributed.KilledWorker as problem:
        raise InputError(
            f"a chunk lost one worker of the cluster after another, perhaps because memory ran out: {printable(problem)}"
        ) from problem
    except (distributed.CancelledError, CommClosedError) as problem:
        raise InputError(
            f"the cluster at {printable(address)} was lost; continue with --resume (resume=True) when it is back"
        ) from problem
