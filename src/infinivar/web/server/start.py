"""Start the explorer's server, and stop it cleanly."""

from __future__ import annotations

import asyncio
import contextlib
import os
import secrets
import signal
import socket
from collections.abc import Callable, Iterator
from typing import Any

from infinivar._core import extras
from infinivar.errors import InputError, printable
from infinivar.web.server.recovery import Recovery
from infinivar.web.server.security import Guard, is_loopback
from infinivar.web.server.work import LONG_SECONDS, QUICK_SECONDS, FailedError, Jobs, Lane, UnusableError, Worker

USUAL_PORT = 8642
"""Port that is tried first, so that a bookmark and the browser's storage keep their page; if it is taken, any free one."""

WAIT_SECONDS = 10.0
"""Longest that a peer may take to send the head of a request. [s]"""

_SPARE_SECONDS = 1.0
"""After the address is printed the page has this time to itself, before the process of longer answers starts. [s]"""

_MOST_QUICK = 3
_MOST_FILES = 16_384
_STOP_SECONDS = 2


def serve(
    study: str | None = None,
    *,
    host: str = "127.0.0.1",
    port: int | None = None,
    say: Callable[[str], None] = print,
    opened: Callable[[str], Any] | None = None,
) -> None:
    """Serve the explorer until it is interrupted.

    Parameters
    ----------
    study : str    Study file or shipped study; by default the first shipped one.
    host : str     Address to listen on. Anything wider than this machine needs the token of the printed address.
    port : int     By default `USUAL_PORT`, or a free one if that is taken.
    say            Called with the address, a line at a time.
    opened         Is called with the address once the page can be shown: opens a browser.

    Raises
    ------
    InputError
        If starlette, uvicorn or tomlkit is not installed, the study is invalid, or the port is taken.
    """
    for library in ("starlette", "uvicorn", "tomlkit"):
        extras.check(library, "web", "infinivar serve")
    _many_connections()
    with contextlib.closing(_listening(host, port)) as listening:
        asyncio.run(_serve(study, host, listening, say, opened))


def _many_connections() -> None:
    """Let this process have as many connections as the system permits: many may wait while others are answered."""
    with contextlib.suppress(ImportError, ValueError, OSError):
        import resource

        least, most = resource.getrlimit(resource.RLIMIT_NOFILE)
        required = _MOST_FILES if most == resource.RLIM_INFINITY else min(_MOST_FILES, most)
        resource.setrlimit(resource.RLIMIT_NOFILE, (max(least, required), most))


def _listening(host: str, port: int | None) -> socket.socket:
    """A socket that listens."""
    try:
        family, _, _, _, address = socket.getaddrinfo(host, 0, type=socket.SOCK_STREAM)[0]
    except (OSError, UnicodeError) as problem:
        raise InputError(f"--host {printable(host)!r} is not an address of this machine: {problem}") from None
    for tried in [port] if port is not None else [USUAL_PORT, 0]:
        # With the protocol named, connections send small replies at once, instead of 40 ms later, when a part is acknowledged.
        made = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)
        if os.name == "posix":
            made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            made.bind((address[0], tried, *address[2:]))
            made.listen(512)
            made.setblocking(False)
        except OSError as problem:
            made.close()
            if port is None and tried != 0:
                continue
            what = f"--port {port}" if port is not None else "a free port"
            raise InputError(
                f"{what}: cannot listen on {printable(host)}: {problem.strerror}; choose another port, or omit --port"
            ) from None
        return made
    raise AssertionError("the last port tried is any free one")


async def _serve(
    study: str | None,
    host: str,
    listening: socket.socket,
    say: Callable[[str], None],
    opened: Callable[[str], Any] | None,
) -> None:
    quick = Lane([Worker(study) for _ in range(min(_MOST_QUICK, _cores()))], QUICK_SECONDS)
    long, whole, jobs = Lane([Worker(study)], LONG_SECONDS), Lane([Worker(study)], LONG_SECONDS), Jobs(study)
    loading = asyncio.create_task(quick.start())
    await asyncio.sleep(0)  # the processes load the study while this one imports its libraries
    recovery = Recovery(study)
    port = listening.getsockname()[1]
    token = None if is_loopback(host) else secrets.token_urlsafe(24)
    try:
        server = _server(Guard(_app(quick, long, whole, jobs, recovery), host=host, port=port, token=token))
        with _stopping(server):
            serving = asyncio.create_task(server.serve(sockets=[listening]))
            try:
                title = await loading
            except (UnusableError, FailedError) as problem:
                server.should_exit = True
                await serving
                raise InputError(str(problem)) from None
            asyncio.get_running_loop().call_later(_SPARE_SECONDS, long.warm)
            address = f"http://{_shown(host)}:{port}/" + (f"?token={token}" if token else "")
            say(f"{title}: {address}")
            if token:
                say("Anyone with this address can use the page; it is not encrypted. Ctrl-C stops it.")
            else:
                say("Only this machine reaches it. Ctrl-C stops it.")
            if opened is not None and not server.should_exit:
                await asyncio.to_thread(opened, address)
            await serving
        recovery.stop()
    finally:
        loading.cancel()
        await jobs.stop()
        await asyncio.gather(quick.stop(), long.stop(), whole.stop())


def _cores() -> int:
    """Processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _shown(host: str) -> str:
    """The host as an address has it: this machine's name, if it listens on all addresses."""
    if host in ("0.0.0.0", "::"):
        return socket.gethostname()
    return f"[{host}]" if ":" in host else host


def _app(quick: Lane, long: Lane, whole: Lane, jobs: Jobs, recovery: Recovery) -> Any:
    from infinivar.web.server.app import Explorer, made_app

    return made_app(Explorer(quick=quick, long=long, whole=whole, jobs=jobs, recovery=recovery))


def _server(app: Any) -> Any:
    """A server of uvicorn that leaves signals to us and does not wait for peers that do not send."""
    import uvicorn

    from infinivar.web.server.connections import PatientProtocol

    class Server(uvicorn.Server):
        @contextlib.contextmanager
        def capture_signals(self) -> Iterator[None]:
            yield

    config = uvicorn.Config(
        app,
        http=PatientProtocol,
        ws="none",
        lifespan="off",
        log_level="error",
        access_log=False,
        server_header=False,
        proxy_headers=False,
        timeout_keep_alive=15,
        timeout_graceful_shutdown=_STOP_SECONDS,
        h11_max_incomplete_event_size=32_768,
    )
    return Server(config)


@contextlib.contextmanager
def _stopping(server: Any) -> Iterator[None]:
    """Stop the server on Ctrl-C and on a request to end, at once on the second."""
    loop = asyncio.get_running_loop()

    def stop() -> None:
        server.force_exit = server.should_exit
        server.should_exit = True

    required = (signal.SIGINT, signal.SIGTERM)
    try:
        for one in required:
            loop.add_signal_handler(one, stop)
    except NotImplementedError:  # Windows
        for one in required:
            signal.signal(one, lambda *_: loop.call_soon_threadsafe(stop))
    yield
