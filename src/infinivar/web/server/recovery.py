"""The study last sent by each page, in a file, so that the next server can offer it if this one is killed.

A server holds a lock on its file. A file without a holder was left by a server that did not stop as it should: the next server of
the same study takes it over and offers what is in it. A server that stops as it should removes its file.
"""

from __future__ import annotations

import contextlib
import datetime
import hashlib
import json
import os
import tempfile
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout

MOST_CLIENTS = 8
"""Pages whose study is kept."""

_KEPT_DAYS = 30.0
_SUFFIX = ".json"


def state_folder() -> Path:
    """Folder of the files; INFINIVAR_STATE names another."""
    asked = os.environ.get("INFINIVAR_STATE")
    if asked:
        return Path(asked)
    import platformdirs

    return platformdirs.user_state_path("infinivar", appauthor=False)


class Recovery:
    """The file of one server. Where none can be written, nothing is kept."""

    def __init__(self, study: str | None, folder: Path | None = None) -> None:
        """Begin a file for the study with which the server was started, in a folder, by default that of the user's state."""
        self._folder = (state_folder() if folder is None else folder) / "explorer"
        path = "" if study is None else str(Path(study).absolute())
        self._study = hashlib.sha256(path.encode("utf-8", "replace")).hexdigest()[:16]
        self._file: Path | None = None
        self._lock: FileLock | None = None
        self._sent: dict[str, dict[str, Any]] = {}
        self.found: dict[str, Any] | None = None
        """The study that a killed server was last sent: name, tables and time."""
        self._prefix = f"{self._study}-"
        with contextlib.suppress(OSError, NotImplementedError):  # the latter where files cannot be locked
            self._begin()

    def _begin(self) -> None:
        """Take over the newest file that a killed server of this study left, and remove older ones; else begin a file."""
        self._folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        left = []
        for file in self._folder.glob(f"{self._prefix}*{_SUFFIX}"):
            lock = FileLock(f"{file}.lock")
            with contextlib.suppress(Timeout, OSError):
                lock.acquire(timeout=0)
                left.append((file.stat().st_mtime, file, lock))
        left.sort(key=lambda one: one[0], reverse=True)
        for stamp, file, lock in left:
            content = _content(file)
            fresh = datetime.datetime.now().timestamp() - stamp < _KEPT_DAYS * 86400.0
            if self.found is None and content is not None and fresh:
                self.found, self._file, self._lock = content, file, lock
            else:
                _remove(file, lock)
        if self._file is None:
            self._file = self._folder / f"{self._prefix}{os.urandom(6).hex()}{_SUFFIX}"
            self._lock = FileLock(f"{self._file}.lock")
            self._lock.acquire(timeout=0)

    def sent(self, client: str, name: str, tables: dict[str, Any]) -> None:
        """Keep the study that a page sent last."""
        before = self._sent.get(client)
        if before is not None and before["name"] == name and before["tables"] == tables:
            return
        now = datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
        self._sent.pop(client, None)
        self._sent[client] = {"name": name, "tables": tables, "time": now}
        while len(self._sent) > MOST_CLIENTS:
            del self._sent[next(iter(self._sent))]
        with contextlib.suppress(OSError):
            self._write(self._sent[client])

    def _write(self, last: dict[str, Any]) -> None:
        """Replace the file in one step, so that it is whole whenever the server is killed."""
        if self._file is None:
            return
        handle, scratch = tempfile.mkstemp(dir=self._folder, prefix=".", suffix=".tmp")
        try:
            with os.fdopen(handle, "w", encoding="utf-8") as stream:
                json.dump({"last": last, "pages": list(self._sent.values())}, stream)
            Path(scratch).replace(self._file)
        except BaseException:
            Path(scratch).unlink(missing_ok=True)
            raise

    def stop(self) -> None:
        """Remove the file: the server stops as it should."""
        if self._file is not None and self._lock is not None:
            _remove(self._file, self._lock)
        self._file = self._lock = None


def _content(file: Path) -> dict[str, Any] | None:
    """What a file holds; None if it is not such a file."""
    try:
        found = json.loads(file.read_text("utf-8"))["last"]
        whole = isinstance(found["tables"], dict) and isinstance(found["name"], str) and isinstance(found["time"], str)
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return None
    return found if whole else None


def _remove(file: Path, lock: FileLock) -> None:
    with contextlib.suppress(OSError):
        file.unlink(missing_ok=True)
        lock.release()
        Path(lock.lock_file).unlink(missing_ok=True)
