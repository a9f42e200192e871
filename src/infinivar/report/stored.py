"""Save a result with its report, and load it again."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import Any

import numpy as np

from infinivar._core import files, stored
from infinivar._core.presentation import presenter
from infinivar._core.result import Frozen
from infinivar.errors import InputError, nearest, path_of, printable
from infinivar.report import saving
from infinivar.report.output import all_or_nothing

_SUFFIX = ".result.npz"
_MOST_BYTES = 4_000_000_000
"""Largest result that is loaded, unpacked."""


def save(result: Any, directory: str | Path, **options: Any) -> list[Path]:
    """Write a result into a directory: its report with figures and data, if there is one, and a file to load it from.

    Files of the same names are replaced and others are left alone; nothing is replaced unless all files could be made.

    Parameters
    ----------
    result : any result, or a sequence of results of one type
    directory : path           Created if there is none.
    **options                  Runs and sessions have `name`, the stem of their files, and `reconstruction`, sentences on what is
                               assumed about the machine; a reproduction has `figure`, to draw only that figure.

    Returns
    -------
    list of Path               Files written: the report first, if there is one; the file for `load_result` last.

    Raises
    ------
    InputError
        If the directory cannot be written to, or the result holds something that cannot be saved, such as a function defined
        within another; nothing is changed then.
    TypeError
        If it is no result.

    Notes
    -----
    A result keeps the study, drives and motions that it was computed from, as they were.
    """
    kind = saving.one_type(result)
    if not issubclass(kind, Frozen):
        raise TypeError(f"result must be a result of infinivar, got {kind.__name__}")
    arrays = stored.to_arrays(tuple(result) if isinstance(result, list) else result, kind.__name__)
    report = [] if presenter(kind, "save") is None else saving.save(result, directory, **options)
    file = Path(directory) / f"{options.get('name', kind.__name__.lower())}{_SUFFIX}"
    with all_or_nothing(Path(directory), file.name) as scratch:
        np.savez_compressed(scratch / file.name, allow_pickle=False, **arrays)
    return [*report, file]


def load_result(path: str | Path, name: str | None = None, *, packages: Collection[str] = ()) -> Any:
    """Load a result that `save` wrote.

    Parameters
    ----------
    path : path          Folder of the result, or its file, such as ``comparison.result.npz``.
    name : str           Name that the result was saved by; needed only where a folder holds several.
    packages : names     Other packages whose classes and functions the result holds, such as your own; those of installed
                         extensions are known.

    Returns
    -------
    Result   Equal to the one saved, or a tuple of results. Its fields are as they were; nothing is computed anew.

    Raises
    ------
    InputError
        If there is no such file, it is damaged, or a version of this program wrote it whose results had other fields.
    """
    file = _file(path_of(path, "path"), name)
    try:
        return stored.from_arrays(files.arrays(file, _MOST_BYTES, "saved result"), packages)
    except InputError as problem:
        here = printable(file)
        raise InputError(str(problem) if str(problem).startswith(here) else f"{here}: {problem}") from problem


def _file(path: Path, name: str | None) -> Path:
    """The file of a result.

    Raises
    ------
    InputError
        If a folder holds none, none of the name, or several.
    """
    if not path.is_dir():
        return path
    names = sorted(file.name.removesuffix(_SUFFIX) for file in path.glob(f"*{_SUFFIX}"))
    if name is None and len(names) == 1:
        (name,) = names
    if name in names:
        return path / f"{name}{_SUFFIX}"
    listed = ", ".join(map(printable, names))
    if not names:
        raise InputError(f"{printable(path)}: holds no saved result; iv.save(result, folder) writes one")
    if name is None:
        raise InputError(f"{printable(path)}: holds several results; name one of {listed}")
    raise InputError(f"{printable(path)}: holds no result {name!r}{nearest(name, names)}; it has {listed}")
