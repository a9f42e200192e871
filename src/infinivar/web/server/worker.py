"""A process that answers: it reads requests from its standard input and writes replies to its standard output.

A request is a frame: its length as 4 bytes, little endian, the name of the answer, a line feed, and the payload as JSON. A reply
is a frame as well; its first byte says what follows: A an answer, R why a request is refused, F what is wrong with the program,
P progress of a job as JSON. The first reply, without a request, says that the study is loaded, or what is wrong with it.
"""

from __future__ import annotations

import contextlib
import json
import logging
import os
import queue
import signal
import struct
import sys
import threading
import time
from collections.abc import Callable
from typing import Any, BinaryIO

ANSWER, REFUSED, FAULT, PROGRESS = b"A", b"R", b"F", b"P"

LARGEST_MEMORY = 4 << 30
"""Address space of a process that answers. [bytes]"""

_PROGRESS_EVERY = 0.1
"""[s]"""


def main(study: str | None) -> None:
    """Answer until the standard input ends."""
    with contextlib.suppress(ValueError):
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the server, which then ends this process
    out = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a library prints does not mix with the replies
    logging.getLogger().addHandler(logging.NullHandler())  # what libraries log is not for the server's terminal
    _bound_memory()
    requests: queue.SimpleQueue[tuple[str, bytes]] = queue.SimpleQueue()
    threading.Thread(target=_read, args=(sys.stdin.buffer, requests), daemon=True).start()
    begun = _begun(study)
    write(out, *begun)
    if begun[0] == ANSWER:
        _warm()
    while True:
        name, body = requests.get()
        write(out, *_replied(name, body, lambda share, words: _report(out, share, words)))


def _bound_memory() -> None:
    """Keep this process from taking all memory, where the system can."""
    try:
        import resource
    except ImportError:
        return
    with contextlib.suppress(ValueError, OSError):
        _, most = resource.getrlimit(resource.RLIMIT_AS)
        limit = LARGEST_MEMORY if most == resource.RLIM_INFINITY else min(LARGEST_MEMORY, most)
        resource.setrlimit(resource.RLIMIT_AS, (limit, most))


def _read(stream: BinaryIO, requests: queue.SimpleQueue[tuple[str, bytes]]) -> None:
    """Read requests; end the process with the server, even if it computes."""
    while True:
        length = stream.read(4)
        if len(length) < 4:
            os._exit(0)
        name, _, body = stream.read(struct.unpack("<I", length)[0]).partition(b"\n")
        requests.put((name.decode("ascii", "replace"), body))


def write(out: BinaryIO, kind: bytes, content: bytes) -> None:
    """Write one reply."""
    try:
        out.write(struct.pack("<I", len(content) + 1) + kind + content)
        out.flush()
    except BrokenPipeError:  # the server is gone
        os._exit(0)


def _begun(study: str | None) -> tuple[bytes, bytes]:
    from infinivar.errors import InputError
    from infinivar.web.answers import document

    try:
        found = document.begin(study)
    except InputError as problem:
        return REFUSED, str(problem).encode()
    return ANSWER, found.title.encode()


def _warm() -> None:
    """Import and compute what the first answers need, while the page is on its way."""
    from infinivar.web.answers import dispatch

    payload = dict(dispatch.answered("start", {}).header["study"])
    with contextlib.suppress(Exception):  # the first question will tell
        dispatch.answered("study", payload)
        dispatch.answered("maps", {**payload, "count": 12}).pack()


_last_report = 0.0


def _report(out: BinaryIO, share: float, words: str) -> None:
    """Report progress, not too often."""
    global _last_report
    now = time.monotonic()
    if now - _last_report >= _PROGRESS_EVERY:
        _last_report = now
        write(out, PROGRESS, json.dumps({"share": min(max(float(share), 0.0), 1.0), "words": words}).encode())


def _replied(name: str, body: bytes, report: Callable[[float, str], None]) -> tuple[bytes, bytes]:
    """The reply to a request."""
    from infinivar.web.answers import answer, dispatch
    from infinivar.web.answers.jobs import JOBS, worked

    try:
        payload = parsed(body)
        made = worked(payload, report) if name in JOBS else dispatch.answered(name, payload)
        return ANSWER, made.pack()
    except (answer.RefusedError, RecursionError) as problem:
        words = str(problem) if isinstance(problem, answer.RefusedError) else "the request is nested too deeply"
        return REFUSED, words.encode("utf-8", "replace")
    except MemoryError:
        return REFUSED, f"this needs more than {LARGEST_MEMORY >> 30} GiB of memory".encode()
    except Exception as problem:
        import traceback

        traceback.print_exc()
        return FAULT, f"internal error: {type(problem).__name__}; the traceback is on the server's terminal".encode()


def parsed(body: bytes) -> Any:
    """The payload of a request.

    Raises
    ------
    RefusedError
        If it is not JSON, or holds nan or infinity, which JSON has not.
    """
    from infinivar.web.answers.answer import RefusedError

    def refuse(word: str) -> Any:
        raise RefusedError(f"the request is not JSON: {word}")

    try:
        return json.loads(body, parse_constant=refuse)
    except ValueError as problem:
        raise RefusedError(f"the request is not JSON: {problem}") from None


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else None)
