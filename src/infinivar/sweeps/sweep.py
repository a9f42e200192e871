"""Run a sweep, continue one, and read what one has found."""

from __future__ import annotations

import contextlib
import time
import uuid
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from infinivar._core.result import Result, result
from infinivar._core.text import few, joined
from infinivar.errors import InputError, printable
from infinivar.report.output import claimed
from infinivar.sweeps.designs import count_lines, design_words, list_title, row_of
from infinivar.sweeps.problem import CANDIDATES, LIST, Chunk, Problem, added, reducer_of, stacked, taken
from infinivar.sweeps.storage import DamagedError, SweepFolder, check_installed
from infinivar.sweeps.workers import Done, Executor, Job, executor_of, versions
from infinivar.units import plain

Progress = Callable[[str, float], None]
"""Called with words on the best so far and the share of work done."""


@result
class Sweep(Result):
    """What a sweep has found.

    Attributes
    ----------
    folder         Where its files are.
    kind, title    Of the problem.
    chunks         Number of chunks, and of those that are done.
    done           Number of chunks done.
    identity       What was swept, by name: numbers and texts, or a digest of a content.
    rows           Columns of the designs or samples that are kept.
    counts         Numbers summed over all chunks.
    computing      Time to compute the chunks, over all workers; nan where not logged. [s]
    elapsed        Time of all runs together; nan likewise. [s]
    damaged        Numbers, from 0, of the chunks whose files are damaged or of another sweep; they are not done.
    """

    folder: Path
    kind: str
    title: str
    chunks: int
    done: int
    identity: Mapping[str, Any]
    rows: Mapping[str, np.ndarray]
    counts: Mapping[str, Any]
    computing: float
    elapsed: float
    damaged: tuple[int, ...] = ()

    @property
    def finished(self) -> bool:
        """Whether all chunks are done."""
        return self.done == self.chunks

    @property
    def candidates(self) -> int:
        """Number of designs or samples that the chunks done cover."""
        return int(self.counts.get(CANDIDATES, 0))

    @property
    def rate(self) -> float:
        """Designs or samples per second of one worker. [1/s]"""
        return self.candidates / self.computing if self.computing > 0.0 else float("nan")

    def list(self, name: str) -> dict[str, np.ndarray]:
        """Rows of a list, "top" or "front", best first; all rows of a sweep without lists."""
        if LIST not in self.rows:
            return dict(self.rows)
        return taken(self.rows, np.flatnonzero(self.rows[LIST] == name))

    @property
    def verdict(self) -> str:
        """One line on how far it is."""
        state = "finished" if self.finished else f"{self.done} of {self.chunks} chunks done"
        rounded = float(f"{self.rate:.3g}")
        rate = f", {f'{rounded:,.0f}' if rounded >= 1e3 else plain(rounded, 3)} a second and worker"
        rate = rate if np.isfinite(self.rate) else ""
        return f"{self.title}: {state}; {self.candidates:,} {CANDIDATES}{rate}"

    def lines(self, top: int = 10) -> Iterator[str]:
        """Text for a terminal: the verdict, the first rows of each list, and the counts."""
        yield self.verdict
        if self.damaged:
            one = len(self.damaged) == 1
            yield (
                f"{'Chunk' if one else 'Chunks'} {_numbered(self.damaged)} {'is' if one else 'are'} damaged and "
                f"{'does' if one else 'do'} not count: the command of the sweep with --resume (resume=True) computes "
                f"{'it' if one else 'them'} again"
            )
        for name in dict.fromkeys(self.rows[LIST].tolist()) if LIST in self.rows else ():
            rows = self.list(name)
            yield list_title(name, len(rows[LIST]))
            for place in range(min(top, len(rows[LIST]))):
                yield f"  {place + 1}. {design_words(row_of(rows, place))}"
        yield from count_lines(self.counts)

    def to_dict(self, top: int | None = None) -> dict[str, Any]:
        """Plain numbers and texts, with the first rows of each list."""
        names = dict.fromkeys(self.rows[LIST].tolist()) if LIST in self.rows else ()
        return {
            "title": self.title,
            "kind": self.kind,
            "finished": self.finished,
            "chunks": self.chunks,
            "done": self.done,
            "damaged": list(self.damaged),
            "candidates": self.candidates,
            "rate_per_s": self.rate,
            "identity": dict(self.identity),
            "counts": _numbers(self.counts),
            "lists": {
                name: [
                    row_of(rows, place)
                    for place in range(min(len(rows[LIST]), len(rows[LIST]) if top is None else top))
                ]
                for name, rows in ((name, self.list(name)) for name in names)
            },
        }


def sweep(
    problem: Problem,
    folder: str | Path,
    *,
    workers: int | None = None,
    dask: str | None = None,
    resume: bool = False,
    progress: Progress | None = None,
) -> Sweep:
    """Compute all chunks of a problem and keep them in a folder.

    However it is stopped, the chunks that are done remain, and the sweep continues with the others. The result is that of a
    sweep that was never stopped, bit for bit, wherever its chunks were computed.

    Parameters
    ----------
    problem : Problem   Such as `GearedSweep`, `CoboticStudySweep` or `BuildsSweep`.
    folder : path       Created if there is none; must be empty, or hold this sweep and `resume` be True.
    workers : int       Processes on this machine, by joblib; by default the chunks are computed in this process.
    dask : str          Address of the scheduler of a Dask cluster, such as "tcp://10.0.0.1:8786", instead.
    resume : bool       Whether to continue what the folder holds.
    progress : callable Called with words on the best so far and the share of chunks done.

    Returns
    -------
    Sweep

    Raises
    ------
    InputError
        If the folder holds anything else or cannot be written to, a library is missing, no scheduler answers, or workers are
        lost again and again.
    """
    check_installed()
    place, here = SweepFolder(folder), versions()
    description = {
        "kind": problem.kind,
        "title": problem.title,
        "chunks": problem.chunks,
        "identity": dict(problem.identity),
        "versions": here,
        "merge": problem.reducer.to_dict(),
    }
    with executor_of(workers, dask) as run, claimed(place.path):
        place.begin(description, resume)
        _run(place, problem, run, Job(problem, place.digest, here), progress or (lambda words, share: None))
        return _merged(place)


def load_sweep(folder: str | Path) -> Sweep:
    """Read what a sweep has found so far, without computing anything.

    Raises
    ------
    InputError
        If the folder holds no sweep.
    """
    check_installed()
    place = SweepFolder(folder)
    place.load()
    return _merged(place)


def check_finished(found: Sweep) -> None:
    """Raise InputError if chunks are missing."""
    if not found.finished:
        raise InputError(f"the sweep is not finished: {found.done} of {found.chunks} chunks are done")


def _run(place: SweepFolder, problem: Problem, run: Executor, job: Job, progress: Progress) -> None:
    """Compute the chunks that are not there, or damaged, and write each as it is done."""
    best: tuple[float, str] | None = None
    done: set[int] = set()
    for number, chunk in _there(place):
        if chunk is None:
            place.remove(number)
        else:
            done.add(number)
            best = _better(best, problem.best(chunk))
    total, name, begin = problem.chunks, uuid.uuid4().hex, time.perf_counter()
    left = [number for number in range(total) if number not in done]

    def tell() -> None:
        progress(best[1] if best is not None else problem.title, (total - len(left)) / total)

    tell()
    with contextlib.closing(run(job, tuple(left))) as arriving:
        for one in arriving:
            _keep(place, one, f"{total - len(left)} of {total}")
            place.note(run=name, chunk=one.number, seconds=one.seconds, at=time.perf_counter() - begin)
            left.remove(one.number)
            best = _better(best, one.best)
            tell()


def _keep(place: SweepFolder, one: Done, state: str) -> None:
    try:
        place.write(one.number, one.content)
    except OSError as problem:
        raise InputError(
            f"{printable(place.path)}: cannot be written to: {problem.strerror}; {state} chunks are done and kept; "
            "continue with --resume (resume=True) when that is solved"
        ) from problem


def _better(one: tuple[float, str] | None, other: tuple[float, str] | None) -> tuple[float, str] | None:
    """The pair with the lesser value; of equals the first."""
    if one is None or other is None:
        return one or other
    return min(one, other, key=lambda found: found[0])


def _there(place: SweepFolder) -> Iterator[tuple[int, Chunk | None]]:
    """Yield each chunk whose file is there, in order; None where the file is damaged."""
    for number in place.numbers():
        try:
            yield number, place.read(number) if number < place.description["chunks"] else None
        except DamagedError:
            yield number, None


def _merged(place: SweepFolder) -> Sweep:
    """What all chunks that are done give together."""
    said = place.description
    reduce = reducer_of(said["merge"])
    there = list(_there(place))
    chunks = [chunk for _, chunk in there if chunk is not None]
    times = place.times()
    return Sweep(
        folder=place.path,
        kind=said["kind"],
        title=said["title"],
        chunks=said["chunks"],
        done=len(chunks),
        identity=said["identity"],
        rows=reduce(stacked([chunk.rows for chunk in chunks])),
        counts=added([chunk.counts for chunk in chunks]),
        computing=times.computing if times.chunks >= len(chunks) else float("nan"),
        elapsed=times.elapsed,
        damaged=tuple(number for number, chunk in there if chunk is None),
    )


def _numbers(counts: Mapping[str, Any]) -> dict[str, Any]:
    """Counts without their arrays."""
    return {
        name: _numbers(value) if isinstance(value, Mapping) else value
        for name, value in counts.items()
        if not isinstance(value, np.ndarray)
    }


def _numbered(numbers: Sequence[int]) -> str:
    """Some numbers in words, the first ones of many."""
    said = list(map(str, numbers))
    return few(said, _NAMED) if len(said) > _NAMED else joined(said)


_NAMED = 20
"""Most numbers of damaged chunks that are named."""
