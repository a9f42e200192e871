"""Files that users name: regular ones of a bounded size, refused before anything of them is read."""

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
    most : int    Bytes that it may have.

    Returns
    -------
    bytes

    Raises
    ------
    InputError
        If there is no such file, it is no regular one (a folder, a device, a pipe that would never end), too large, or
        cannot be read.
    """
    try:
        # Without waiting: opening a pipe would wait for somebody to write to it.
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
