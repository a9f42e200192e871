"""Read files: those named by the user, regular and of bounded size only, checked before reading, and those of the program."""

from __future__ import annotations

import os
import stat
import tomllib
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

from infinivar.errors import InputError, printable

if TYPE_CHECKING:
    import numpy as np

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
        If the file does not exist, is not a regular file (a folder, a device, a pipe that would block, a table of the
        system), is too large, or cannot be read.
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
            if not found.st_size and os.read(file.fileno(), 1):
                # A log or table of the system that looks like an empty file; reading on could wait, or not end.
                raise InputError(f"{printable(path)}: is not a regular file")
            return file.read(most + 1)[:most]
    except FileNotFoundError as problem:
        raise InputError(f"{printable(path)}: no such file") from problem
    except IsADirectoryError as problem:
        raise InputError(f"{printable(path)}: is a folder, not a file") from problem
    except (OSError, ValueError) as problem:  # ValueError: a name with a null character
        raise InputError(
            f"{printable(path)}: cannot be read: {getattr(problem, 'strerror', None) or problem}"
        ) from problem


def arrays(path: Path, most: int, what: str) -> dict[str, np.ndarray]:
    """Arrays of an archive of NumPy (npz) of unknown origin by name: no code in it is run.

    Parameters
    ----------
    path : Path
    most : int    Largest size of the file and of its content, unpacked. [bytes]
    what : str    What the archive should be, for messages: "set of parts".

    Raises
    ------
    InputError
        If the file cannot be read, is no such archive, or unpacks to more.
    """
    import io
    import zipfile

    import numpy as np

    content = read(path, most)
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            size = sum(one.file_size for one in archive.infolist())
            if size > most:
                raise InputError(f"{printable(path)}: unpacks to {size / 1e6:.3g} MB, more than {most / 1e6:g} MB")
            found = {}
            for one in archive.infolist():
                with archive.open(one) as member:
                    found[one.filename.removesuffix(".npy")] = np.lib.format.read_array(member, allow_pickle=False)
            return found
    except InputError:
        raise
    except Exception as problem:  # NumPy's reader of headers may fail in any way on a damaged file
        raise InputError(f"{printable(path)}: is no {what}: {problem}") from problem


def shipped(room: str, name: str) -> dict[str, Any]:
    """Content of a TOML file in the folder ``data`` of a room of the package: ``shipped("contact", "kalker")``."""
    return tomllib.loads((resources.files(f"infinivar.{room}") / "data" / f"{name}.toml").read_text("utf-8"))


def of_user(purpose: str) -> Path:
    """Folder in which the program keeps something for the user.

    Parameters
    ----------
    purpose : str   "cache", "data" or "state".

    Returns
    -------
    Path   As the system has it, by `platformdirs`. For a user without a home, as in some containers, one that cannot exist:
        nothing is found there, and what is written raises `OSError`.
    """
    import platformdirs

    try:
        return Path(getattr(platformdirs, f"user_{purpose}_path")("infinivar", appauthor=False)).expanduser().absolute()
    except RuntimeError:  # of platformdirs or of expanduser: neither a variable nor the system names a home
        return Path(os.devnull) / "infinivar"
