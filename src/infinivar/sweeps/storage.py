"""A chunk as the content of a Parquet file: equal chunks give equal bytes, and damage is noticed."""

from __future__ import annotations

import base64
import hashlib
import importlib
import io
import json
import zlib
from collections.abc import Mapping
from typing import Any

import numpy as np

from infinivar._core import extras
from infinivar.sweeps.problem import Chunk

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
        table = _table(content)
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


def _table(content: bytes) -> Any:
    """Table of a Parquet file, read in this thread alone.

    `read_table` leaves the closing of a Python file to a thread of pyarrow; if that thread runs while the interpreter ends,
    the process aborts (exit code 134). A buffer of pyarrow, read without threads, has nothing to close late.
    """
    arrow, parquet = (importlib.import_module(name) for name in ("pyarrow", "pyarrow.parquet"))
    with parquet.ParquetFile(arrow.BufferReader(content)) as file:
        return file.read(use_threads=False)


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
