"""What the program keeps in the user's cache folder: whole, or not at all."""

from __future__ import annotations

import hashlib
import tempfile
from pathlib import Path

from infinivar._core import files


def folder() -> Path:
    """Where it is kept, which need not exist."""
    return files.of_user("cache")


def find(key: str, ending: str) -> Path | None:
    """The file kept under a key, if its content is what was written."""
    try:
        for path in folder().glob(f"{key}.*{ending}"):
            if path.name == _name(key, ending, path.read_bytes()):
                return path
    except OSError:
        pass  # not readable: as if nothing were kept
    return None


def keep(key: str, ending: str, content: bytes) -> Path | None:
    """Keep a file under a key; None where it cannot be, which costs time only."""
    path = folder() / _name(key, ending, content)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=path.parent) as own:
            written = Path(own, path.name)
            written.write_bytes(content)
            written.replace(path)
    except OSError:
        return None
    return path


def _name(key: str, ending: str, content: bytes) -> str:
    """A name that tells whether the content is whole."""
    return f"{key}.{hashlib.sha256(content).hexdigest()[:16]}{ending}"
