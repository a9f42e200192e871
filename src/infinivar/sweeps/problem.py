"""What a sweep computes: a fixed number of chunks, each a pure function of its number."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple, Protocol

import numpy as np

from infinivar.sweeps.reducers import Reducer

CANDIDATES = "candidates"
"""Entry of the counts that every chunk has: how many designs or samples it covers."""


class Chunk(NamedTuple):
    """What is kept of a chunk."""

    rows: Mapping[str, np.ndarray]
    """Columns of one length: numbers, truth values or texts. (n,) each"""
    counts: Mapping[str, Any]
    """Numbers and arrays that are added over chunks, by name; groups of them may be nested."""


class Problem(Protocol):
    """What `sweep` runs. The chunks together are the whole result, and the same number always gives the same chunk.

    Instances are sent to other processes, so they must be picklable.
    """

    @property
    def kind(self) -> str:
        """Name of the kind of problem, such as "size"."""
        ...

    @property
    def title(self) -> str:
        """For reports."""
        ...

    @property
    def chunks(self) -> int:
        """Number of chunks, at least 1."""
        ...

    @property
    def reducer(self) -> Reducer:
        """How chunks are merged."""
        ...

    @property
    def identity(self) -> Mapping[str, Any]:
        """All that decides the result, by a name in words: numbers, texts, lists of them, or a `fingerprint`."""
        ...

    def run(self, number: int) -> Chunk:
        """Compute a chunk, 0 to `chunks` - 1."""
        ...

    def best(self, chunk: Chunk) -> tuple[float, str] | None:
        """A value of which less is better, with words for a progress bar; None if the chunk has nothing to tell."""
        ...
