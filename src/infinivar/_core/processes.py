"""Pure functions in processes, results in order; one after the other where no command has opened any."""

from __future__ import annotations

import contextlib
import contextvars
import functools
import importlib
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

from infinivar._core import threads

if TYPE_CHECKING:
    from concurrent.futures import ProcessPoolExecutor

T = TypeVar("T")
R = TypeVar("R")

_MOST = 4
"""Processes of a command, unless more are asked for: more have nothing to do for most of the time."""

SWITCH = "INFINIVAR_PROCESSES"
"""Environment variable with the number of processes of a command, where it is not that of the processors, up to 4; 1 for none."""

_LOOK = 0.25
"""Time between two looks at the parent. [s]"""

_open: contextvars.ContextVar[ProcessPoolExecutor | None] = contextvars.ContextVar("processes", default=None)


@contextlib.contextmanager
def opened(*modules: str) -> Iterator[None]:
    """Let `apart` and `ahead` compute in processes in the block, as many as processors or as `SWITCH` says.

    Only for commands: a process begins with the script of the one that starts it, which may not be made for that. They start
    when they have work, or at once to import the modules that it will need; an error ends them all.
    """
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import get_context

    asked = os.environ.get(SWITCH, "")
    number = int(asked) if asked.isdecimal() else min(os.cpu_count() or 1, _MOST)
    if number <= 1:
        yield
        return
    pool = ProcessPoolExecutor(number, get_context("spawn"), _begin, (os.getpid(), *modules))
    if modules:
        pool.submit(int)
    before = _open.set(pool)
    try:
        yield
    except BaseException:
        for one in list(pool._processes.values()):
            one.kill()
        raise
    finally:
        _open.reset(before)
        pool.shutdown(cancel_futures=True)


def in_processes() -> bool:
    """Whether `apart` computes in other processes, which report no progress."""
    return _open.get() is not None


def apart(function: Callable[[T], R], items: Sequence[T]) -> Iterator[R]:
    """Yield the result of a pure function of a module for each item, in order.

    What takes longest should come first.
    """
    pool = _open.get()
    if pool is None or len(items) < 2:
        yield from map(function, items)
    else:
        yield from pool.map(function, items)


def ahead(function: Callable[..., R], *arguments: Any) -> Callable[[], R]:
    """Begin to compute a pure function of a module; what is returned waits for the result."""
    pool = _open.get()
    return functools.partial(function, *arguments) if pool is None else pool.submit(function, *arguments).result


def _begin(parent: int, *modules: str) -> None:
    watch(parent)
    threads.only_one()
    for name in modules:
        importlib.import_module(name)


def watch(parent: int) -> None:
    """End this process soon after the one that started it is gone, and leave Ctrl-C to that one.

    A worker that waits for its first work must watch too: nobody would send it any.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def look() -> None:
        while os.getppid() == parent:
            time.sleep(_LOOK)
        os._exit(1)

    threading.Thread(target=look, name="parent watch", daemon=True).start()
