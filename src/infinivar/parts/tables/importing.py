"""Read files of parts into a set: good rows are kept, bad ones reported with file, line and reason."""

from __future__ import annotations

import contextlib
import datetime
import os
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from infinivar._core import files as reading
from infinivar._core.result import Frozen, result
from infinivar._core.text import counted
from infinivar.errors import InputError, nearest, printable
from infinivar.parts.catalogue import PARTS
from infinivar.parts.tables import delimited, tomls
from infinivar.parts.tables.checked_rows import DATE, Collector, Fault, Remark
from infinivar.parts.tables.columns import number_columns, text_columns
from infinivar.parts.tables.table import PartSet, PartTable, part_set
from infinivar.tables.encodings import text_of
from infinivar.tables.sheet import TextList

_FORMAT = 1
_MOST_BYTES_OF_SETS = 500_000_000
"""Largest content of a file, unpacked; a hundred times the largest known set."""


SUFFIXES = (".npz", ".toml", ".csv")
"""Files that can hold a set, in the order in which one name is looked up."""

_MOST_BYTES = 100_000_000
_MOST_SHOWN = 5


@result
class PartImport(Frozen):
    """A set that was read from files, and what was not taken over from them.

    Attributes
    ----------
    parts      The set of all good rows.
    faults     Rows that were refused, with file, line and reason.
    remarks    What was read in another way than written, or left out.
    """

    parts: PartSet
    faults: tuple[Fault, ...]
    remarks: tuple[Remark, ...]

    @property
    def verdict(self) -> str:
        """One line on the outcome."""
        refused = len(self.faults)
        return f"{self.parts.contents}; {counted(refused, 'rows') if refused else 'no rows'} refused"

    @property
    def unstated(self) -> dict[str, dict[str, int]]:
        """Number of rows that do not state an optional value which other rows state, by kind and column."""
        found: dict[str, dict[str, int]] = {}
        required = self.incomplete
        for kind, table in self.parts.tables.items():
            counts = {name: int(np.isnan(column).sum()) for name, column in table.columns.items()}
            some = {name: count for name, count in counts.items() if 0 < count < len(table)}
            some = {name: count for name, count in some.items() if name not in required.get(kind, {})}
            if some:
                found[kind] = some
        return found

    @property
    def incomplete(self) -> dict[str, dict[str, int]]:
        """Number of rows without a value that their part requires, by kind and value: they cannot be used in a drive."""
        found: dict[str, dict[str, int]] = {}
        for kind, table in self.parts.tables.items():
            counts: dict[str, int] = {}
            for row in (~table.complete).nonzero()[0]:
                for name in table.missing(int(row)):
                    counts[name] = counts.get(name, 0) + 1
            if counts:
                found[kind] = counts
        return found


def import_parts(
    files: str | Path | Sequence[str | Path],
    *,
    name: str | None = None,
    source: str | None = None,
    date: str | None = None,
    columns: Mapping[str, str] | None = None,
) -> PartImport:
    """Read files of parts into one set.

    Parameters
    ----------
    files : path or sequence of paths   CSV with units in its headings, CSV of the MGDB format, or TOML. In a CSV file with the
        columns motor and gearhead, or an MGDB file of compatibility, each line says what fits together; * stands for any text.
    name : str      Name of the set; by default that of the first file.
    source : str    Source of rows that state none; by default the name of their file.
    columns : mapping   Headings of a CSV file by name of a column, where they differ: ``{"resistance": "R [Ohm]"}``.
    date : str      Date of the source of rows that state none; by default the day of the import.

    Returns
    -------
    PartImport
        The set, the rows that were refused with file, line and reason, and remarks.

    Raises
    ------
    InputError
        If a file cannot be read at all, or has no row that can be taken.
    """
    paths = [Path(files)] if isinstance(files, str | Path) else [Path(one) for one in files]
    if not paths:
        raise InputError("files must name at least one file of parts")
    if date and not DATE.fullmatch(date):
        raise InputError(f"date {date!r} must be a year, month or day, such as 2026, 2026-03 or 2026-03-31")
    today = f"imported {datetime.datetime.now(datetime.UTC).date().isoformat()}"
    collector = Collector(defaults={"date": today if date is None else date, "kind": "catalogue"})
    for path in paths:
        collector.defaults = {**collector.defaults, "source": source or path.name}
        _read(collector, path, columns or {})
    if not any(collector.rows.values()):
        first = [str(fault) for fault in collector.faults[:_MOST_SHOWN]]
        raise InputError("\n".join([f"{', '.join(map(printable, paths))}: no row could be read", *first]))
    parts = collector.finished(name or paths[0].stem)
    return PartImport(
        parts=replace(parts, path=paths[0] if len(paths) == 1 else None),
        faults=tuple(collector.faults),
        remarks=collector.remarks,
    )


def read_set(path: Path, name: str | None = None) -> PartImport:
    """Read one file that holds a set: stored by the program, or TOML or CSV."""
    if path.suffix.lower() == ".npz":
        return PartImport(parts=read(path, name), faults=(), remarks=())
    return import_parts(path, name=name or path.stem, date="")


def _read(collector: Collector, path: Path, columns: Mapping[str, str]) -> None:
    suffix = path.suffix.lower()
    if suffix == ".npz":
        raise InputError(f"{printable(path)}: is a stored set already; copy the file to where sets are looked up")
    if suffix not in SUFFIXES:
        raise InputError(f"{printable(path)}: must be a .csv or .toml file{nearest(suffix, SUFFIXES)}")
    content = reading.read(path, _MOST_BYTES_OF_SETS)
    read = text_of(printable(path), content)
    if not read.encoding.startswith("UTF-8"):
        collector.remark(path.name, None, f"read as {read.encoding}")
    if suffix == ".toml":
        tomls.read(collector, "\n".join(read.lines), path.name)
    else:
        delimited.read(collector, TextList.of(printable(path), read.lines), path, columns)


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
    arrays = reading.arrays(path, _MOST_BYTES_OF_SETS, "set of parts")
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
