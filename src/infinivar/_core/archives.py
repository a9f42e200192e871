"""Archives of NumPy arrays (npz) of unknown origin: read whole, within a size, and without code in them."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import numpy as np

from infinivar._core import files
from infinivar.errors import InputError, printable


def read(path: Path, most: int, what: str) -> dict[str, np.ndarray]:
    """Arrays of an archive by name.

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
    content = files.read(path, most)
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            size = sum(one.file_size for one in archive.infolist())
            if size > most:
                raise InputError(f"{printable(path)}: unpacks to {size / 1e6:.3g} MB, more than {most / 1e6:g} MB")
            arrays = {}
            for one in archive.infolist():
                with archive.open(one) as member:
                    arrays[one.filename.removesuffix(".npy")] = np.lib.format.read_array(member, allow_pickle=False)
            return arrays
    except InputError:
        raise
    except Exception as problem:  # NumPy's reader of headers may fail in any way on a damaged file
        raise InputError(f"{printable(path)}: is no {what}: {problem}") from problem
