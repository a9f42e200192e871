"""Processes that answer, and who gets the next one: one computation a client, the newest of its requests, in turn.

Answers are computed in processes of their own, so that the server stays responsive, and one that takes too long or too much
memory can be ended. Quick answers and longer ones have separate processes: a map does not wait for a report.
"""

from __future__ import annotations

import asyncio
import collections
import contextlib
import itertools
import json
import os
import struct
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

ANSWER, REFUSED, FAULT, PROGRESS = b"A", b"R", b"F", b"P"

QUICK_SECONDS, LONG_SECONDS, JOB_SECONDS = 20.0, 120.0, 900.0
"""Longest that an answer, a longer one and a job may take. [s]"""

MOST_WAITING = 400
"""Requests that may wait for a process."""

MOST_JOBS, JOBS_KEPT = 2, 24
"""Jobs that run at a time; the results that are kept."""

_MOST_KINDS = 64
"""Kinds of requests of one client that are counted separately."""

_START_SECONDS = 60.0
_LARGEST_REPLY = 256 << 20
_BUFFER = 1 << 20


class StaleError(Exception):
    """A newer request of the same client has taken the place of this one."""


class BusyError(Exception):
    """Too many requests wait; the message says so."""


class UnusableError(Exception):
    """The request is refused; the message says why."""


class FailedError(Exception):
    """The program failed; the message says how."""


class TooLongError(Exception):
    """The computation was ended because it took too long; the message says how long."""


class Worker:
    """A process that answers one request at a time."""

    def __init__(self, study: str | None) -> None:
        """Prepare a process that answers about a study file or shipped study, by default the first one."""
        self._study = study
        self._process: asyncio.subprocess.Process | None = None
        self.title = ""

    async def start(self) -> None:
        """Start the process and wait until it has loaded the study.

        Raises
        ------
        UnusableError
            If the study is invalid.
        FailedError
            If the process does not start.
        """
        single = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
        given = [] if self._study is None else [self._study]
        self._process = await asyncio.create_subprocess_exec(
            *(sys.executable, "-P", "-m", "infinivar.web.server.worker", *given),
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
            limit=_BUFFER,
            env={**os.environ, **single, "MPLBACKEND": "Agg"},
        )
        try:
            kind, content = await asyncio.wait_for(self._frame(), _START_SECONDS)
        except (TimeoutError, FailedError) as problem:
            await self.stop()
            raise FailedError("a process that answers did not start") from problem
        if kind == REFUSED:
            await self.stop()
            raise UnusableError(content.decode())
        self.title = content.decode()

    @property
    def alive(self) -> bool:
        """Whether the process runs."""
        return self._process is not None and self._process.returncode is None

    async def call(
        self, name: str, body: bytes, seconds: float, report: Callable[[dict[str, Any]], None] | None = None
    ) -> bytes:
        """Answer a request.

        Raises
        ------
        UnusableError, FailedError
            If the request is refused, or the program failed.
        TooLongError
            If it took longer than some seconds; the process has been ended.
        """
        assert self._process is not None
        assert self._process.stdin is not None
        try:
            async with asyncio.timeout(seconds):
                request = name.encode() + b"\n" + body
                self._process.stdin.write(struct.pack("<I", len(request)) + request)
                await self._process.stdin.drain()
                while True:
                    kind, content = await self._frame()
                    if kind != PROGRESS:
                        break
                    if report is not None:
                        report(json.loads(content))
        except TimeoutError:
            await self.stop()
            raise TooLongError(f"the computation was ended after {seconds:g} s, the longest it may take") from None
        except (ConnectionError, FailedError) as problem:
            await self.stop()
            raise FailedError("the process that answers ended; it may have run out of memory") from problem
        except asyncio.CancelledError:
            await self.stop()
            raise
        if kind == REFUSED:
            raise UnusableError(content.decode("utf-8", "replace"))
        if kind == FAULT:
            raise FailedError(content.decode("utf-8", "replace"))
        return content

    async def _frame(self) -> tuple[bytes, bytes]:
        assert self._process is not None
        assert self._process.stdout is not None
        try:
            (length,) = struct.unpack("<I", await self._process.stdout.readexactly(4))
            if not 1 <= length <= _LARGEST_REPLY:
                raise FailedError("a reply is too large")
            content = await self._process.stdout.readexactly(length)
        except asyncio.IncompleteReadError as problem:
            raise FailedError("the process that answers ended") from problem
        return content[:1], content[1:]

    async def stop(self) -> None:
        """End the process at once."""
        if self._process is None:
            return
        with contextlib.suppress(ProcessLookupError):
            self._process.kill()
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(self._process.wait(), 5.0)


@dataclass(slots=True)
class _Waiting:
    """A request that waits."""

    name: str
    body: bytes
    future: asyncio.Future[bytes]


@dataclass(slots=True)
class _Client:
    """What a client asks: its newest request of each kind, and the last sequence number of each."""

    waiting: dict[str, _Waiting] = field(default_factory=dict)
    newest: dict[str, int] = field(default_factory=dict)
    busy: bool = False
    last: Worker | None = None


class Lane:
    """A few processes shared by all clients in turn; one computation a client at a time."""

    _MOST_CLIENTS = 512

    def __init__(self, workers: list[Worker], seconds: float) -> None:
        """Share these processes, begun when they are needed; each answer may take some seconds."""
        self._workers, self._seconds = workers, seconds
        self._cold, self._warming = list(workers), 0
        self._idle: list[Worker] = []
        self._clients: collections.OrderedDict[str, _Client] = collections.OrderedDict()
        self._tasks: set[asyncio.Task[None]] = set()
        self._anonymous = itertools.count()
        self._stopped = False

    async def start(self) -> str:
        """Start the first process; returns the title of the study. Others follow when clients wait for one another."""
        first = self._cold.pop(0)
        await first.start()
        self._idle.append(first)
        self._next()
        return first.title

    def warm(self) -> None:
        """Start a process in the background, if none is."""
        if len(self._cold) == len(self._workers):
            self._begin_another()

    def _begin_another(self) -> None:
        """Start one more process, unless one is about to be there."""
        if self._cold and not self._warming:
            self._begin(self._cold.pop(0))

    def _begin(self, worker: Worker) -> None:
        if not self._stopped:
            self._warming += 1
            self._run(self._joined(worker))

    def _run(self, *coroutines: Any) -> None:
        for one in coroutines:
            task = asyncio.create_task(one)
            self._tasks.add(task)
            task.add_done_callback(self._tasks.discard)

    async def _joined(self, worker: Worker) -> None:
        """Start a process that then takes part; one that does not start is left out and tried again."""
        try:
            for pause in (0.0, 1.0, 5.0, 20.0):
                await asyncio.sleep(pause)
                with contextlib.suppress(FailedError, UnusableError, OSError):
                    await worker.start()
                    self._idle.append(worker)
                    return
            self._cold.append(worker)
        finally:
            self._warming -= 1
            self._next()

    async def call(
        self, client: str | None, sequence: int | None, name: str, body: bytes, kind: str | None = None
    ) -> bytes:
        """Answer a request as soon as a process is free and it is the client's turn.

        Parameters
        ----------
        client, sequence   Who asks, and a number that rises with its requests, if it states them.
        name, body         Of the answer, and the payload.
        kind               Requests of one kind replace each other; by default those of the same name.

        Raises
        ------
        StaleError
            If the client has requested the same with a higher sequence number, or does so while this request waits.
        BusyError
            If too many requests wait.
        """
        if sum(len(one.waiting) for one in self._clients.values()) >= MOST_WAITING:
            raise BusyError("too many requests wait; try again in a moment")
        key = f"anonymous {next(self._anonymous)}" if client is None else client
        asks = self._clients.setdefault(key, _Client())
        self._forget()
        kind = name if kind is None else kind
        if kind not in asks.newest and len(asks.newest) >= _MOST_KINDS:
            raise BusyError("the page asks for too many kinds of answers")
        newest = asks.newest.setdefault(kind, -1)
        if sequence is not None:
            if sequence < newest:
                raise StaleError
            asks.newest[kind] = sequence
        replaced = asks.waiting.pop(kind, None)
        if replaced is not None and not replaced.future.done():
            replaced.future.set_exception(StaleError())
        waiting = _Waiting(name, body, asyncio.get_running_loop().create_future())
        asks.waiting[kind] = waiting
        self._next()
        try:
            return await waiting.future
        finally:
            if asks.waiting.get(kind) is waiting:
                del asks.waiting[kind]
            if client is None:
                self._clients.pop(key, None)

    def _forget(self) -> None:
        """Forget the clients without a request for the longest time."""
        for key in list(self._clients)[: max(0, len(self._clients) - self._MOST_CLIENTS)]:
            if not self._clients[key].waiting and not self._clients[key].busy:
                del self._clients[key]

    def _next(self) -> None:
        """Give idle processes to clients whose requests wait, in turn."""
        if self._stopped:
            return
        for key in list(self._clients):
            client = self._clients[key]
            if client.busy or not client.waiting:
                continue
            if not self._idle:
                self._begin_another()
                return
            waiting = client.waiting.pop(next(iter(client.waiting)))
            if waiting.future.done():
                continue
            # The process that answered last knows the client's study.
            worker = client.last if client.last in self._idle else self._idle[0]
            assert worker is not None
            self._idle.remove(worker)
            client.busy, client.last = True, worker
            self._clients.move_to_end(key)
            self._run(self._answer(worker, client, waiting))

    async def _answer(self, worker: Worker, client: _Client, waiting: _Waiting) -> None:
        try:
            found = await worker.call(waiting.name, waiting.body, self._seconds)
            if not waiting.future.done():
                waiting.future.set_result(found)
        except Exception as problem:
            if not waiting.future.done():
                waiting.future.set_exception(problem)
        finally:
            client.busy = False
            if worker.alive:
                self._idle.append(worker)
            else:
                self._begin(worker)
            self._next()

    async def stop(self) -> None:
        """End all processes."""
        self._stopped = True
        for task in list(self._tasks):
            task.cancel()
        for one in self._workers:
            await one.stop()


@dataclass(slots=True)
class Job:
    """A long computation with progress."""

    client: str
    task: asyncio.Task[None] | None = None
    share: float = 0.0
    words: str = "waiting"
    done: bool = False
    result: bytes | None = None
    error: str | None = None


class Jobs:
    """Long computations, each in a process of its own; a few at a time, one a client."""

    def __init__(self, study: str | None) -> None:
        """Prepare for computations on the study with which the explorer was started."""
        self._study = study
        self._room = asyncio.Semaphore(MOST_JOBS)
        self._jobs: collections.OrderedDict[str, Job] = collections.OrderedDict()

    def begin(self, client: str, body: bytes) -> str:
        """Begin a computation, and return its id.

        Raises
        ------
        BusyError
            If the client has one that is not done, or too many wait.
        """
        running = [one for one in self._jobs.values() if not one.done]
        if any(one.client == client for one in running):
            raise BusyError("a computation of this page is running; cancel it first, or wait until it is done")
        if len(running) >= JOBS_KEPT:
            raise BusyError("too many computations wait; try again later")
        key = os.urandom(12).hex()
        job = self._jobs[key] = Job(client)
        job.task = asyncio.create_task(self._work(job, body))
        for old in [name for name, one in self._jobs.items() if one.done][: max(0, len(self._jobs) - JOBS_KEPT)]:
            del self._jobs[old]
        return key

    def of(self, key: str) -> Job | None:
        """The job of an id; None if it is unknown, or forgotten."""
        return self._jobs.get(key)

    async def _work(self, job: Job, body: bytes) -> None:
        worker = Worker(self._study)

        def report(progress: dict[str, Any]) -> None:
            job.share, job.words = progress["share"], progress["words"]

        try:
            async with self._room:
                job.words = "starting"
                await worker.start()
                job.result = await worker.call("job", body, JOB_SECONDS, report)
                job.share, job.words = 1.0, "done"
        except (UnusableError, FailedError, TooLongError) as problem:
            job.error = str(problem)
        except asyncio.CancelledError:
            job.error = "cancelled"
        finally:
            job.done = True
            await worker.stop()

    async def cancel(self, key: str) -> bool:
        """End a computation; whether there was one to end."""
        job = self._jobs.get(key)
        if job is None or job.done or job.task is None:
            return False
        job.task.cancel()
        await asyncio.wait([job.task], timeout=5.0)
        if not job.done:  # cancelled before it began
            job.done, job.error = True, "cancelled"
        return True

    async def stop(self) -> None:
        """End all computations."""
        for key in list(self._jobs):
            await self.cancel(key)
