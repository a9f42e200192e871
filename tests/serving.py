"""A server of the explorer in a process of its own, and clients of it, for tests."""

from __future__ import annotations

import contextlib
import json
import os
import re
import signal
import socket
import struct
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import httpx
import numpy as np
import pytest

ADDRESS = re.compile(r"(http://(\S+?):(\d+)/)(?:\?token=(\S+))?")


@dataclass
class Served:
    """A server that runs."""

    process: subprocess.Popen[str]
    address: str
    port: int
    token: str | None
    seconds: float
    errors: Path
    """What it prints on stderr."""

    def client(self, name: str | None = "test", **options: Any) -> httpx.Client:
        headers = {} if name is None else {"X-Client": name}
        # Certificates, which no test needs, take long to load.
        return httpx.Client(
            base_url=self.address, headers=headers, timeout=60, trust_env=False, verify=False, **options
        )

    def ask(self, name: str, payload: Any, client: httpx.Client | None = None) -> tuple[dict, dict]:
        """Header and arrays of an answer."""
        with contextlib.ExitStack() as stack:
            own = client or stack.enter_context(self.client(None))
            reply = own.post(f"api/{name}", json=payload)
        assert reply.status_code == 200, reply.text
        return unpacked(reply.content)

    def stop(self, how: signal.Signals = signal.SIGTERM) -> int:
        self.process.send_signal(how)
        return self.process.wait(20)

    def memory(self) -> int:
        """Memory of the server and its processes. [bytes]"""
        own = [self.process.pid, *children(self.process.pid)]
        pages = sum(int(Path(f"/proc/{one}/statm").read_text().split()[1]) for one in own)
        return pages * os.sysconf("SC_PAGE_SIZE")


def children(pid: int) -> list[int]:
    """Processes that a process began. Linux only."""
    found = []
    for task in Path(f"/proc/{pid}/task").iterdir():
        with contextlib.suppress(FileNotFoundError):
            found += [int(one) for one in (task / "children").read_text().split()]
    return found


def unpacked(content: bytes) -> tuple[dict, dict]:
    """Header and arrays of a packed answer, read as a page does: independent of the program."""
    (length,) = struct.unpack("<I", content[:4])
    header = json.loads(content[4 : 4 + length].decode("utf-8"))
    start = 4 + length
    assert start % 8 == 0
    arrays = {}
    for one in header.get("arrays", []):
        assert one["offset"] % 8 == 0
        dtype = {"float32": "<f4", "float64": "<f8", "uint8": "u1"}[one["dtype"]]
        count = int(np.prod(one["shape"]))
        arrays[one["name"]] = np.frombuffer(content, dtype, count, start + one["offset"]).reshape(one["shape"])
    return header, arrays


def begun(
    *arguments: str, folder: Path, stderr: int | IO[str] = subprocess.PIPE, **environment: str
) -> subprocess.Popen[str]:
    """A server that may not run yet; its state is kept in a folder."""
    import infinivar

    source = str(Path(infinivar.__file__).parents[1])
    path = os.pathsep.join([source, *filter(None, [os.environ.get("PYTHONPATH")])])
    return subprocess.Popen(
        [sys.executable, "-P", "-m", "infinivar", "serve", "--no-browser", *arguments],
        stdout=subprocess.PIPE,
        stderr=stderr,
        text=True,
        cwd=folder,
        env={**os.environ, "PYTHONPATH": path, "INFINIVAR_STATE": str(folder / "state"), **environment},
    )


@contextlib.contextmanager
def serving(*arguments: str, folder: Path, **environment: str) -> Iterator[Served]:
    """A server that runs; it is ended with the block."""
    pytest.importorskip("starlette")
    pytest.importorskip("uvicorn")
    begin = time.perf_counter()
    # A pipe that nobody reads fills up with tracebacks, and the server then waits for ever.
    errors = folder / "stderr.txt"
    with errors.open("w") as file:
        process = begun(*arguments, folder=folder, stderr=file, **environment)
    try:
        assert process.stdout is not None
        line = process.stdout.readline()
        found = ADDRESS.search(line)
        if found is None:
            process.wait(20)
            raise AssertionError(f"the server printed {line!r}, and on stderr {errors.read_text()!r}")
        yield Served(process, found[1], int(found[3]), found[4], time.perf_counter() - begin, errors)
    finally:
        if process.poll() is None:
            process.kill()
        process.communicate()


def free_port() -> int:
    """A port that nobody listens on."""
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]
