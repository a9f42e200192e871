"""Sets of parts in one array file (npz): written at once or not at all, and read in milliseconds."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from infinivar._core import archives
from infinivar.errors import InputError, printable
from infinivar.parts.catalogue import PARTS
from infinivar.parts.tables.columns import number_columns, text_columns
from infinivar.parts.tables.table import PartSet, PartTable, part_set

_FORMAT = 1
_MOST_BYTES = 500_000_000
"""Largest content of a file, unpacked; a hundred times the largest known set."""


def write(parts: PartSet, path: Path) -> Path:
    """Write a set; a file of that name is replaced once the new one is complete.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    arrays: dict[str, np.ndarray] = {"format": np.array(_FORMAT)}
    if parts.pairs_stated:
        arrays["pairs"] = parts.pairs.astype(np.int32)
    for kind, one in parts.tables.items():
        if not one:
            continue
        names = [name for name, column in one.columns.items() if not np.isnan(column).all()]
        arrays[f"{kind}.columns"] = np.array(names)
        arrays[f"{kind}.numbers"] = (
            np.stack([one.columns[name] for name in names]) if names else np.empty((0, len(one)))
        )
        arrays[f"{kind}.key"] = one.texts["key"]
        for name, column in one.texts.items():
            if name != "key" and (column != "").any():
                arrays[f"{kind}.{name}"] = column[:1] if (column == column[0]).all() else column
    temporary = None
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=path.parent, prefix=f".{path.stem}-", suffix=".npz", delete=False) as file:
            temporary = file.name
            np.savez_compressed(file, allow_pickle=False, **arrays)
            file.flush()
            os.fsync(file.fileno())
        Path(temporary).replace(path)
    except OSError as problem:
        if temporary is not None:
            with contextlib.suppress(OSError):
                Path(temporary).unlink()
        raise InputError(f"{printable(path)}: cannot be written: {problem.strerror}") from problem
    return path


def read(path: Path, name: str | None = None) -> PartSet:
    """Read a set that `write` wrote.

    Raises
    ------
    InputError
        If the file cannot be read or is no such set.
    """
    arrays = archives.read(path, _MOST_BYTES, "set of parts")
    try:
        if "format" not in arrays:
            raise InputError(f"{printable(path)}: is no set of parts, but a NumPy archive of something else")
        if int(arrays["format"]) != _FORMAT:
            raise InputError(
                f"{printable(path)}: was written by another version of the program; import its files again"
            )
        tables = [_table(kind, arrays) for kind in PARTS if f"{kind}.key" in arrays]
        return part_set(name or path.stem, tables, arrays.get("pairs"), path)
    except InputError as problem:
        here = printable(path)
        raise InputError(str(problem) if str(problem).startswith(here) else f"{here}: {problem}") from None
    except Exception as problem:  # columns of other shapes or types than those of a set may fail in any way
        raise InputError(f"{printable(path)}: is no set of parts: {problem}") from problem


def _table(kind: str, arrays: Mapping[str, np.ndarray]) -> PartTable:
    keys = arrays[f"{kind}.key"]
    rows = keys.shape
    numbers = dict(zip(arrays[f"{kind}.columns"].tolist(), arrays[f"{kind}.numbers"], strict=True))
    texts = {name: arrays.get(f"{kind}.{name}", np.array([""])) for name in text_columns(kind)}
    unstated = np.broadcast_to(np.nan, rows)
    for name, column in numbers.items():
        if name not in number_columns(kind) or column.shape != rows or column.dtype.kind != "f":
            raise ValueError(f"{kind}.{name} is no column of {rows[0]} numbers")
    for name, column in texts.items():
        if column.dtype.kind != "U" or column.shape not in (rows, (1,)):
            raise ValueError(f"{kind}.{name} is no column of {rows[0]} texts")
    return PartTable(
        kind=kind,
        columns={name: numbers.get(name, unstated) for name in number_columns(kind)},
        texts={name: np.broadcast_to(column, rows) for name, column in texts.items()},
    )
