"""The folder of a sweep: a description, one Parquet file for each chunk that is done, and a log of times.

Equal chunks give files of equal bytes, and damage is noticed. Every file is written under another name, synced and renamed, so
that a file under its own name is whole. The files are the manifest: what is there is done. `infinivar.tables` opens a chunk, but
does not read it: its columns are the program's own, texts among them, and must be those that its digest was made of.
"""

from __future__ import annotations

import base64
import contextlib
import errno
import hashlib
import importlib
import io
import json
import os
import re
import zlib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from infinivar._core import extras
from infinivar.errors import InputError, printable
from infinivar.sweeps.problem import Chunk
from infinivar.tables.formats import parquet_file

DESCRIPTION, LOG = "sweep.json", "times.jsonl"
_TEMPORARY = ".writing"
_CHUNK = re.compile(r"chunk-(\d+)\.parquet")
_OWN = (".infinivar.lock", ".infinivar.json")
"""Files of the lock on a folder."""
_FORMAT = 1


_KEY = b"infinivar"
_ARRAY = "array"
_LEVEL = 6


class DamagedError(Exception):
    """A file is not the chunk that it should be; the message says why."""


def check_installed() -> None:
    """Raise InputError if Parquet files cannot be written."""
    extras.load("pyarrow", "scale", "a sweep")


def encoded(chunk: Chunk, number: int, sweep: str) -> bytes:
    """Content of the file of a chunk.

    Parameters
    ----------
    chunk : Chunk
    number : int    Of the chunk.
    sweep : str     Digest of the sweep's description.
    """
    arrow, parquet = (importlib.import_module(name) for name in ("pyarrow", "pyarrow.parquet"))
    said = {"sweep": sweep, "chunk": number, "counts": _plain(chunk.counts), "digest": _digest(chunk)}
    columns = {
        name: arrow.array(column.tolist() if column.dtype.kind == "U" else column) for name, column in _rows(chunk)
    }
    table = arrow.table(columns).replace_schema_metadata({_KEY: json.dumps(said).encode()})
    content = io.BytesIO()
    parquet.write_table(table, content, compression="zstd")
    return content.getvalue()


def decoded(content: bytes, number: int, sweep: str) -> Chunk:
    """A chunk from the content of its file; other arguments as for `encoded`.

    Raises
    ------
    DamagedError
        If the content is cut short or changed, or is another chunk.
    """
    try:
        with parquet_file(content) as file:
            table = file.read(use_threads=False)
        said = json.loads((table.schema.metadata or {})[_KEY])
        found = said["chunk"], said["sweep"]
        counts = _restored(said["counts"])
        rows = {name: _column(table.column(name)) for name in table.column_names}
        chunk = Chunk(rows, counts)
        whole = said["digest"] == _digest(chunk)
    except Exception as problem:  # pyarrow raises many types on damaged files
        raise DamagedError(f"cannot be read: {problem}") from problem
    if found != (number, sweep):
        raise DamagedError("belongs to another sweep" if found[1] != sweep else f"is chunk {found[0]}")
    if not whole:
        raise DamagedError("its content does not match its digest")
    return chunk


def _rows(chunk: Chunk) -> list[tuple[str, np.ndarray]]:
    return [(name, np.asarray(column)) for name, column in chunk.rows.items()]


def _column(column: Any) -> np.ndarray:
    values = column.to_numpy()
    return values.astype(str) if values.dtype.kind == "O" else values


def _digest(chunk: Chunk) -> str:
    """Digest of rows and counts."""
    digest = hashlib.sha256(json.dumps(_plain(chunk.counts)).encode())
    for name, column in _rows(chunk):
        kind = column.dtype.kind
        digest.update(f"{name}\0{kind}{column.shape}\0".encode())
        digest.update("\0".join(column.tolist()).encode() if kind == "U" else np.ascontiguousarray(column).tobytes())
    return digest.hexdigest()


def _plain(value: Any) -> Any:
    """Counts as JSON has them."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        packed = zlib.compress(np.ascontiguousarray(value).tobytes(), _LEVEL)
        return {_ARRAY: base64.b64encode(packed).decode(), "type": value.dtype.str, "shape": list(value.shape)}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value.item() if isinstance(value, np.generic) else value


def _restored(value: Any) -> Any:
    if not isinstance(value, Mapping):
        return value
    if _ARRAY in value:
        content = zlib.decompress(base64.b64decode(value[_ARRAY]))
        return np.frombuffer(content, dtype=value["type"]).reshape(value["shape"])
    return {key: _restored(item) for key, item in value.items()}


class Times(NamedTuple):
    """What the log tells."""

    computing: float
    """Time to compute the chunks, over all workers. [s]"""
    elapsed: float
    """Time that all runs together lasted, as far as they were logged. [s]"""
    chunks: int
    """Chunks whose time is known."""


class SweepFolder:
    """Files of a sweep."""

    def __init__(self, path: str | Path) -> None:
        """Name the folder; nothing is read or written."""
        self.path = Path(path)
        self.description: Mapping[str, Any] = {}

    @property
    def digest(self) -> str:
        """Digest of the description, which each chunk carries."""
        return hashlib.sha256(json.dumps(self.description, sort_keys=True).encode()).hexdigest()[:32]

    def begin(self, description: Mapping[str, Any], resume: bool) -> None:
        """Begin a sweep, or continue the same one.

        Raises
        ------
        InputError
            If the folder holds other files or another sweep, or the same one and `resume` is False.
        """
        required = {"format": _FORMAT, **json.loads(json.dumps(description))}
        names = {entry.name for entry in self.path.iterdir()} - {*_OWN}
        if DESCRIPTION not in names:
            others = sorted(name for name in names if not name.endswith(_TEMPORARY))
            if others:
                raise InputError(
                    f"{printable(self.path)}: is not empty and holds no sweep ({printable(others[0])}); choose another folder"
                )
            self.description = required
            self._write(DESCRIPTION, (json.dumps(required, indent=1) + "\n").encode())
        else:
            self.load()
            different = list(_differences(self.description, required))
            if different:
                raise InputError(
                    f"{printable(self.path)}: holds another sweep, which cannot be continued with this: "
                    f"{'; '.join(different)}; choose another folder"
                )
            if not resume:
                raise InputError(
                    f"{printable(self.path)}: holds this sweep already, {len(self.numbers())} of {required['chunks']} chunks "
                    "done; continue with --resume (resume=True), or choose another folder"
                )
        for name in names:
            if name.endswith(_TEMPORARY):
                (self.path / name).unlink(missing_ok=True)

    def load(self) -> None:
        """Read the description.

        Raises
        ------
        InputError
            If there is none, or it cannot be read.
        """
        try:
            found = json.loads((self.path / DESCRIPTION).read_text("utf-8"))
            known = found["format"] == _FORMAT and isinstance(found["chunks"], int)
        except FileNotFoundError:
            raise InputError(f"{printable(self.path)}: holds no sweep: there is no file {DESCRIPTION}") from None
        except (OSError, ValueError, LookupError, TypeError) as problem:
            raise InputError(f"{printable(self.path / DESCRIPTION)}: cannot be read: {problem}") from problem
        if not known:
            raise InputError(f"{printable(self.path / DESCRIPTION)}: was written by another version of infinivar")
        self.description = found

    def numbers(self) -> list[int]:
        """Numbers of the chunks whose files are there, in order."""
        found = (_CHUNK.fullmatch(entry.name) for entry in self.path.iterdir())
        return sorted({int(match[1]) for match in found if match is not None})

    def read(self, number: int) -> Chunk:
        """A chunk from its file.

        Raises
        ------
        DamagedError
            If the file is not this chunk of this sweep.
        """
        try:
            content = self._place(number).read_bytes()
        except OSError as problem:
            raise DamagedError(f"cannot be read: {problem.strerror}") from problem
        return decoded(content, number, self.digest)

    def remove(self, number: int) -> None:
        """Remove the file of a chunk."""
        self._place(number).unlink(missing_ok=True)

    def write(self, number: int, content: bytes) -> None:
        """Write the file of a chunk.

        Raises
        ------
        OSError
            If it cannot be written; nothing is there then.
        """
        self._write(self._place(number).name, content)

    def note(self, **entry: Any) -> None:
        """Add a line to the log of times."""
        with contextlib.suppress(OSError), (self.path / LOG).open("a", encoding="utf-8") as file:
            file.write(json.dumps(entry) + "\n")

    def times(self) -> Times:
        """Sums over the log; lines that a crash cut short are left out."""
        seconds: dict[int, float] = {}
        ends: dict[str, float] = {}
        for line in self._lines():
            with contextlib.suppress(ValueError, LookupError, TypeError):
                said = json.loads(line)
                seconds[int(said["chunk"])] = float(said["seconds"])
                ends[str(said["run"])] = max(ends.get(str(said["run"]), 0.0), float(said["at"]))
        return Times(sum(seconds.values()), sum(ends.values()), len(seconds))

    def _lines(self) -> Iterable[str]:
        try:
            return (self.path / LOG).read_text("utf-8").splitlines()
        except (OSError, ValueError):
            return []

    def _place(self, number: int) -> Path:
        return self.path / f"chunk-{number:08d}.parquet"

    def _write(self, name: str, content: bytes) -> None:
        """Write a file, sync it, and give it its name."""
        scratch = self.path / f".{name}{_TEMPORARY}"
        try:
            with scratch.open("wb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            scratch.replace(self.path / name)
        except BaseException:
            with contextlib.suppress(OSError):
                scratch.unlink(missing_ok=True)
            raise
        _sync_folder(self.path)


def _sync_folder(path: Path) -> None:
    """Make sure that new names in a folder outlast a power failure, where the system can."""
    try:
        handle = os.open(path, os.O_RDONLY)
    except OSError:  # Windows opens no folders
        return
    try:
        os.fsync(handle)
    except OSError as problem:
        if problem.errno not in (errno.EINVAL, errno.ENOTSUP):
            raise
    finally:
        os.close(handle)


def _differences(known: Mapping[str, Any], required: Mapping[str, Any]) -> Iterable[str]:
    """What two descriptions differ in, in words."""
    if known == required:
        return
    if known.get("kind") != required["kind"]:
        yield f"it is a sweep of {printable(known.get('kind'))}, not of {required['kind']}"
        return
    for group in ("identity", "versions"):
        before, now = known.get(group, {}), required[group]
        for name in dict.fromkeys([*before, *now]):
            if before.get(name) != now.get(name):
                yield _changed(name, before.get(name), now.get(name))
    for name in ("chunks", "title", "merge"):
        if known.get(name) != required[name] and known.get("identity") == required["identity"]:
            yield _changed(name, known.get(name), required[name])


def _changed(name: str, before: Any, now: Any) -> str:
    if isinstance(before, str) and isinstance(now, str) and len(before) == len(now) == 32:
        return f"{name}: the content differs"
    return f"{name}: {_said(before)} there, {_said(now)} here"


def _said(value: Any) -> str:
    if isinstance(value, list):
        return ", ".join(map(_said, value))
    return "none" if value is None else printable(value)
