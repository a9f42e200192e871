"""Pure functions on threads, results in order; one after the other where the system starts no more threads."""

from __future__ import annotations

import contextlib
import contextvars
import os
from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

T = TypeVar("T")
R = TypeVar("R")


_most: contextvars.ContextVar[int | None] = contextvars.ContextVar("threads", default=None)


@contextlib.contextmanager
def at_most(number: int) -> Iterator[None]:
    """No more threads than a number for `in_order` in the block, as other processes use the other processors."""
    before = _most.set(number)
    try:
        yield
    finally:
        _most.reset(before)


def in_order(function: Callable[[T], R], items: Sequence[T], *, workers: int | None = None) -> Iterator[R]:
    """Yield a pure function's result for each item, in order; on all processors by default.

    Where threads cannot start, everything is computed in the calling one. The first error ends all work.
    """
    workers = _most.get() or workers or os.cpu_count()
    if workers == 1 or len(items) < 2:
        yield from map(function, items)
        return
    from concurrent.futures import ThreadPoolExecutor

    pool = ThreadPoolExecutor(workers)
    try:
        try:
            pending = [pool.submit(function, item) for item in items]
        except RuntimeError:  # "can't start new thread": the limit of processes is reached
            pool.shutdown(cancel_futures=True)
            yield from map(function, items)
            return
        for one in pending:
            yield one.result()
    finally:
        pool.shutdown(cancel_futures=True)
