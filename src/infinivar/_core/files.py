"""Read files named by the user: regular files of bounded size only, checked before reading."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from infinivar.errors import InputError, printable

_MB = 1_000_000


def read(path: Path, most: int) -> bytes:
    """Content of a regular file.

    Parameters
    ----------
    path : Path
    most : int    Maximum size in bytes.

    Returns
    -------
    bytes

    Raises
    ------
    InputError
        If the file does not exist, is not a regular file (a folder, a device, a pipe that would block), is too large, or
        cannot be read.
    """
    try:
        # O_NONBLOCK: opening a pipe would otherwise block until a writer opens it.
        with open(path, "rb", opener=lambda name, flags: os.open(name, flags | getattr(os, "O_NONBLOCK", 0))) as file:
            found = os.fstat(file.fileno())
            if not stat.S_ISREG(found.st_mode):
                raise InputError(f"{printable(path)}: is not a regular file")
            if found.st_size > most:
                raise InputError(
                    f"{printable(path)}: has {found.st_size / _MB:.3g} MB, more than the {most / _MB:g} MB allowed"
                )
            return file.read(most + 1)[:most]
    except FileNotFoundError as problem:
        raise InputError(f"{printable(path)}: no such file") from problem
    except IsADirectoryError as problem:
        raise InputError(f"{printable(path)}: is a folder, not a file") from problem
    except (OSError, ValueError) as problem:  # ValueError: a name with a null character
        raise InputError(
            f"{printable(path)}: cannot be read: {getattr(problem, 'strerror', None) or problem}"
        ) from problem
