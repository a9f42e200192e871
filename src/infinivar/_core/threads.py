"""Pure functions on threads, results in order; one after the other where the system starts no more threads."""

from __future__ import annotations

import contextlib
import contextvars
import functools
import os
import threading
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController

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


def only_one() -> None:
    """No more than one thread for `in_order` in this process from now on, as others use the other processors."""
    _most.set(1)


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
    with products_on_one_thread():
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


_lock, _inside, _limit = threading.Lock(), 0, contextlib.ExitStack()


@contextlib.contextmanager
def products_on_one_thread() -> Iterator[None]:
    """Products of matrices start no threads in the block.

    Beside threads of the block they would wait for each other; and their rounding would be that of the number of threads, which
    a search carries from the last digit to the tenth.
    """
    _count(1)
    try:
        yield
    finally:
        _count(-1)


def _count(change: int) -> None:
    """Enter or leave a block; the first and the last of all threads change the library's number of threads."""
    global _inside
    with _lock:
        _inside += change
        if change > 0 and _inside == 1:
            _limit.enter_context(_libraries().limit(limits=1, user_api="blas"))
        elif not _inside:
            _limit.close()


@functools.cache
def _libraries() -> ThreadpoolController:
    import scipy.linalg  # noqa: F401  it has a library of its own, which is found only once it is loaded
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()
