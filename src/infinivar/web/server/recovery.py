"""What each page edited last, in a file, so that the next server can offer it if this one is killed.

A server holds a lock on its file. A file without a holder was left by a server that did not stop as it should: the next server of
the same study takes over what is in it, offers it, and keeps it until a page has decided on it. A server that stops as it should
forgets what its own pages edited.
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

from infinivar._core import files

MOST_KEPT = 8
"""Pages whose study is kept, and studies that wait for a decision."""

_KEPT_DAYS = 30.0
_SUFFIX = ".json"


def state_folder() -> Path:
    """Folder of the files; INFINIVAR_STATE names another."""
    requested = os.environ.get("INFINIVAR_STATE")
    if requested:
        return Path(requested)
    return files.of_user("state")


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
        self._given: set[str] = set()
        self.found: list[dict[str, Any]] = []
        """What pages of killed servers edited last, newest first, until decided: id, name, tables and time of each."""
        self._prefix = f"{self._study}-"
        with contextlib.suppress(OSError, NotImplementedError):  # the latter where files cannot be locked
            self._begin()

    def _begin(self) -> None:
        """Begin a file with what killed servers of this study left, and remove theirs."""
        self._folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        left = []
        for file in self._folder.glob(f"{self._prefix}*{_SUFFIX}"):
            lock = FileLock(f"{file}.lock")
            with contextlib.suppress(Timeout, OSError):
                lock.acquire(timeout=0)
                left.append((file, lock))
        oldest = datetime.datetime.now(datetime.UTC) - datetime.timedelta(days=_KEPT_DAYS)
        found = [one for file, _ in left for one in _content(file) if one["time"] > _written(oldest)]
        newest = {_digest(one["tables"]): one for one in sorted(found, key=_time)}  # the same study once
        self.found = sorted(newest.values(), key=_time, reverse=True)[:MOST_KEPT]
        self._file = self._folder / f"{self._prefix}{os.urandom(6).hex()}{_SUFFIX}"
        self._lock = FileLock(f"{self._file}.lock")
        self._lock.acquire(timeout=0)
        if self.found:
            self._write()
        for file, lock in left:
            _remove(file, lock)

    def given(self, tables: Any) -> None:
        """Note a study as a page gets it: as long as it is unchanged, there is nothing to keep."""
        self._given.add(_digest(tables))

    def sent(self, client: str, name: Any, tables: Any) -> None:
        """Keep the study that a page sent last, if it is one and was edited."""
        if not (isinstance(name, str) and isinstance(tables, dict)):
            return
        before = self._sent.get(client)
        if before is not None and before["name"] == name and before["tables"] == tables:
            return
        # A page that was loaded again is another client with the same study.
        same = [one for one, kept in self._sent.items() if one == client or kept["tables"] == tables]
        for one in same:
            del self._sent[one]
        digest = _digest(tables)
        offered = [
            one for one in self.found if _digest(one["tables"]) != digest
        ]  # a page has what it was to be offered
        held, self.found = len(offered) < len(self.found), offered
        if digest in self._given:
            if same or held:
                self._kept()
            return
        now = _written(datetime.datetime.now(datetime.UTC))
        self._sent[client] = {"id": os.urandom(8).hex(), "name": name, "tables": tables, "time": now}
        while len(self._sent) > MOST_KEPT:
            del self._sent[next(iter(self._sent))]
        self._kept()

    def decided(self, key: str) -> None:
        """Forget what a page has taken back, or does not want."""
        self.found = [one for one in self.found if one["id"] != key]
        self._kept()

    def _kept(self) -> None:
        with contextlib.suppress(OSError):
            self._write()

    def _write(self) -> None:
        """Replace the file in one step, so that it is whole whenever the server is killed."""
        if self._file is None:
            return
        handle, scratch = tempfile.mkstemp(dir=self._folder, prefix=".", suffix=".tmp")
        try:
            with os.fdopen(handle, "w", encoding="utf-8") as stream:
                json.dump([*self._sent.values(), *self.found], stream)
            Path(scratch).replace(self._file)
        except BaseException:
            Path(scratch).unlink(missing_ok=True)
            raise

    def stop(self) -> None:
        """The server stops as it should: remove the file, or leave what is not decided."""
        self._sent.clear()
        if self._file is not None and self._lock is not None:
            if self.found:
                self._kept()
                self._lock.release()
            else:
                _remove(self._file, self._lock)
        self._file = self._lock = None


def _digest(tables: Any) -> str:
    """The same for the same tables; a page has no other word for 2.0 than 2."""
    plain = json.loads(json.dumps(tables), parse_float=_number)
    return hashlib.sha256(json.dumps(plain, sort_keys=True).encode()).hexdigest()


def _number(text: str) -> float:
    value = float(text)
    return int(value) if value.is_integer() else value


def _time(kept: dict[str, Any]) -> str:
    return kept["time"]


def _written(time: datetime.datetime) -> str:
    return time.isoformat(timespec="seconds")


def _content(file: Path) -> list[dict[str, Any]]:
    """What a file holds; nothing if it is not such a file."""
    try:
        found = json.loads(file.read_text("utf-8"))
        whole = all(
            isinstance(one["tables"], dict) and all(isinstance(one[key], str) for key in ("id", "name", "time"))
            for one in found
        )
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return []
    return found if whole else []


def _remove(file: Path, lock: FileLock) -> None:
    with contextlib.suppress(OSError):
        file.unlink(missing_ok=True)
        lock.release()
        Path(lock.lock_file).unlink(missing_ok=True)
