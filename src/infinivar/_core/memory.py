"""Memory of large arrays that stays with a worker from one array to the next.

The C library of GNU gives the memory of an array from 128 KiB on back to the system when the array is deleted. It raises that
size by itself, unless a threshold was set, as Dask's nanny does for its workers (MALLOC_TRIM_THRESHOLD_): then every page of
every array is requested anew, which takes several times as long as the computation.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import threading
from collections.abc import Iterator

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
