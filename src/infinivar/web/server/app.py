"""Routes: the page and its files, the answers, and long computations with progress."""

from __future__ import annotations

import asyncio
import hashlib
import json
import mimetypes
import re
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from infinivar.web.server.recovery import Recovery
from infinivar.web.server.work import (
    BusyError,
    FailedError,
    Jobs,
    Lane,
    StaleError,
    TooLongError,
    UnusableError,
)

PAGE = Path(__file__).parents[1] / "page"

LARGEST_BODY = 1_000_000
"""Bytes of a request."""

BODY_SECONDS = 10.0
"""Longest that a request may take to arrive. [s]"""

LONG = frozenset({"judge", "contact", "motion", "plane", "export"})
"""Answers that may take seconds: they have processes of their own, so that maps do not wait for them."""

WHOLE = frozenset({"glance", "mend", "tasks"})
"""Answers that need the comparison of all drives or machines, which they share: no other answer waits for it."""

GIVING = frozenset({"start", "shipped", "open"})
"""Answers with which a page gets a study."""

_NAME = re.compile(r"[a-z_]{1,32}")
_CLIENT = re.compile(r"[A-Za-z0-9_-]{1,64}")
_LANE = re.compile(r"[A-Za-z0-9_. -]{1,64}")
_SEQUENCE = re.compile(r"[0-9]{1,15}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Explorer:
    """What the routes share: the processes that answer, long computations, and the studies last sent."""

    quick: Lane
    long: Lane
    whole: Lane
    jobs: Jobs
    recovery: Recovery

    async def answer(self, request: Request) -> Response:
        """An answer, by name."""
        name = request.path_params["name"]
        if not _NAME.fullmatch(name):
            raise HTTPException(404, "no such answer")
        client, sequence, kind = _asking(request)
        body, payload = await _json_body(request)
        if name == "start":
            body = json.dumps({**payload, "recovered": self.recovery.found}).encode()
        elif name == "study" and client is not None:
            # Asked once after each change; a slider waits for the maps, which have the same tables.
            self.recovery.sent(client, payload.get("name"), payload.get("tables"))
        lane = self.long if name in LONG else self.whole if name in WHOLE else self.quick
        try:
            found = await lane.call(client, sequence, name, body, kind and f"{name} {kind}")
        except StaleError:
            raise HTTPException(409, "a newer request has taken the place of this one") from None
        except BusyError as problem:
            raise HTTPException(429, str(problem)) from None
        except TooLongError as problem:
            raise HTTPException(413, str(problem)) from None
        except UnusableError as problem:
            raise HTTPException(400, str(problem)) from None
        if name in GIVING:
            header = _header_of(found)
            self.recovery.given(header.get("study", header).get("tables"))
        return _packed(found)

    async def decided(self, request: Request) -> Response:
        """Forget a study that was offered after a server was killed."""
        _, payload = await _json_body(request)
        self.recovery.decided(str(payload.get("id")))
        return JSONResponse({})

    async def job(self, request: Request) -> Response:
        """Begin a long computation."""
        client, _, _ = _asking(request)
        body, _ = await _json_body(request)
        try:
            return JSONResponse({"id": self.jobs.begin(client or "", body)})
        except BusyError as problem:
            raise HTTPException(429, str(problem)) from None

    async def progress(self, request: Request) -> Response:
        """How far a long computation is, and its result once it is done."""
        job = await self._job_of(request)
        result = None if job.result is None else _header_of(job.result)
        state = {"share": job.share, "words": job.words, "done": job.done, "error": job.error, "result": result}
        return JSONResponse(state, headers={"Cache-Control": "no-store"})

    async def cancel(self, request: Request) -> Response:
        """End a long computation."""
        _, payload = await _json_body(request)
        return JSONResponse({"cancelled": await self.jobs.cancel(str(payload.get("id")))})

    async def _job_of(self, request: Request) -> Any:
        _, payload = await _json_body(request)
        job = self.jobs.of(str(payload.get("id")))
        if job is None:
            raise HTTPException(404, "no such computation; its result may be gone")
        return job


def made_app(explorer: Explorer) -> Starlette:
    """The routes."""
    page = _Files(PAGE)
    app = Starlette(
        routes=[
            Route("/", page.index),
            Route("/api/job", explorer.job, methods=["POST"]),
            Route("/api/progress", explorer.progress, methods=["POST"]),
            Route("/api/cancel", explorer.cancel, methods=["POST"]),
            Route("/api/decided", explorer.decided, methods=["POST"]),
            Route("/api/{name}", explorer.answer, methods=["POST"]),
            Route("/page/{path:path}", page.file),
        ],
        exception_handlers={
            HTTPException: _refused,
            FailedError: _failed,
            ClientDisconnect: _gone,
        },  # type: ignore[arg-type]
    )
    app.router.redirect_slashes = False
    return app


class _Files:
    """Files of the page, read once: a browser asks for a dozen before the first map, and whether they have changed."""

    def __init__(self, folder: Path) -> None:
        # A browser refuses modules of another type, which some systems state.
        mimetypes.add_type("text/javascript", ".js")
        mimetypes.add_type("text/css", ".css")
        self._files: dict[str, tuple[bytes, str, str]] = {}
        for file in folder.rglob("*"):
            if file.is_file():
                content, kind = file.read_bytes(), mimetypes.guess_type(file.name)[0] or "text/plain"
                tag = f'"{hashlib.sha256(content).hexdigest()[:32]}"'
                self._files[file.relative_to(folder).as_posix()] = content, kind, tag

    async def index(self, request: Request) -> Response:
        """The page."""
        return self._response("index.html", request)

    async def file(self, request: Request) -> Response:
        """One of its files."""
        return self._response(request.path_params["path"], request)

    def _response(self, name: str, request: Request) -> Response:
        if name not in self._files:
            raise HTTPException(404, "no such file")
        content, kind, tag = self._files[name]
        headers = {"Cache-Control": "no-cache", "ETag": tag}
        if request.headers.get("if-none-match") == tag:
            return Response(status_code=304, headers=headers)
        return Response(content, media_type=kind, headers=headers)


def _header_of(content: bytes) -> Any:
    """The header of a packed answer."""
    (length,) = struct.unpack_from("<I", content)
    return json.loads(content[4 : 4 + length])


def _packed(content: bytes) -> Response:
    return Response(content, media_type="application/octet-stream", headers={"Cache-Control": "no-store"})


def _asking(request: Request) -> tuple[str | None, int | None, str | None]:
    """Who asks, the number of the request and its lane - requests of one lane replace each other - if the page states them."""
    client, sequence, lane = (request.headers.get(name) for name in ("x-client", "x-sequence", "x-lane"))
    if lane is not None and not _LANE.fullmatch(lane):
        raise HTTPException(400, "X-Lane must have 1 to 64 letters, digits, spaces and . - _")
    if client is not None and not _CLIENT.fullmatch(client):
        raise HTTPException(400, "X-Client must have 1 to 64 letters, digits, - and _")
    if sequence is not None and (client is None or not _SEQUENCE.fullmatch(sequence)):
        raise HTTPException(400, "X-Sequence must be a whole number, beside X-Client")
    return client, None if sequence is None else int(sequence), lane


async def _json_body(request: Request) -> tuple[bytes, dict[str, Any]]:
    """The body of a request, bounded in size and time, and the JSON object that it holds."""
    kind = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    if kind != "application/json":  # others can be sent by forms of any site
        raise HTTPException(415, "Content-Type must be application/json")
    body = bytearray()
    try:
        async with asyncio.timeout(BODY_SECONDS):
            async for part in request.stream():
                body += part
                if len(body) > LARGEST_BODY:
                    raise HTTPException(413, f"a request may have {LARGEST_BODY} bytes")
    except TimeoutError:
        raise HTTPException(408, "the request did not arrive in time", {"Connection": "close"}) from None
    try:
        payload = json.loads(bytes(body))
    except (ValueError, RecursionError):
        raise HTTPException(400, "the request is not JSON") from None
    if not isinstance(payload, dict):
        raise HTTPException(400, "the request must be a JSON object")
    return bytes(body), payload


async def _refused(request: Request, problem: HTTPException) -> Response:
    headers = {"Cache-Control": "no-store", **(problem.headers or {})}
    return JSONResponse({"error": problem.detail}, problem.status_code, headers)


async def _failed(request: Request, problem: FailedError) -> Response:
    return JSONResponse({"error": str(problem)}, 500, {"Cache-Control": "no-store"})


async def _gone(request: Request, problem: ClientDisconnect) -> Response:
    return Response(status_code=400)
