"""Workers keep the memory of large arrays, whatever the variable of the C library says that Dask sets for its own."""

import os
import subprocess
import sys

import pytest

from internals import workers

COUNT = """
import resource
import sys

import numpy as np

from infinivar.sweeps.workers import kept


def faults():
    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    for _ in range(50):
        np.ones(100_000)
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before


first = faults()
with kept():
    with kept():
        np.ones(100_000)
    inside = faults()
print(first, inside, faults())
"""


def counted(threshold):
    """Pages that 50 arrays of 200 pages each request: before, inside and after the block."""
    variables = {**os.environ, "MALLOC_TRIM_THRESHOLD_": threshold}
    done = subprocess.run([sys.executable, "-c", COUNT], env=variables, capture_output=True, text=True, check=True)
    return [int(number) for number in done.stdout.split()]


def test_pages_of_deleted_arrays_are_used_again():
    pytest.importorskip("resource")
    try:
        assert "glibc" in (os.confstr("CS_GNU_LIBC_VERSION") or "")
    except (AttributeError, ValueError, AssertionError):
        pytest.skip("another C library")
    before, inside, after = counted("65536")
    assert inside < 1000 < 5000 < min(before, after)


def test_other_c_libraries_are_left_alone(monkeypatch):

    for answer in ("musl 1.2", None):
        monkeypatch.setattr(os, "confstr", lambda name, answer=answer: answer, raising=False)
        with workers.kept():
            assert workers._library() is None
