"""Shared libraries made of C texts by the compiler of the system, and kept for the next time; none is needed to install."""

from __future__ import annotations

import ctypes
import functools
import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from infinivar._core import files

FLAGS = ("-std=c99", "-O2", "-fPIC", "-shared", "-ffp-contract=off")
"""No contraction of products and sums: the same numbers as by single operations."""

SWITCH = "INFINIVAR_COMPILE"
"""Environment variable; 0 keeps every run in Python."""


@functools.cache
def compiler() -> str | None:
    """Path of a C compiler: that of `CC`, or cc, gcc or clang; None without one."""
    if os.environ.get(SWITCH) == "0" or sys.platform == "win32":
        return None
    names = (os.environ.get("CC", ""), "cc", "gcc", "clang")
    return next((found for name in names if name and (found := shutil.which(name)) is not None), None)


def no_compiler() -> str | None:
    """One line where the system lacks a compiler that nobody switched off."""
    if compiler() is not None or os.environ.get(SWITCH) == "0":
        return None
    return "no C compiler found (cc, gcc, clang or CC): simulated in Python, two to five times slower"


@functools.lru_cache(maxsize=64)
def library(text: str) -> ctypes.CDLL | None:
    """The library of a text, compiled unless it is known; None without a compiler, or where it cannot."""
    own = compiler()
    if own is None:
        return None
    key = hashlib.sha256("\n".join([text, own, *FLAGS]).encode()).hexdigest()[:32]
    kept = files.of_user("cache") / f"{key}.so"
    try:
        return ctypes.CDLL(str(kept))
    except OSError:
        pass  # not made yet, or damaged
    try:
        with tempfile.TemporaryDirectory() as folder:
            source, made = Path(folder, "model.c"), Path(folder, "model.so")
            source.write_text(text, "utf-8")
            subprocess.run([own, *FLAGS, "-o", made, source, "-lm"], check=True, capture_output=True, timeout=120)
            return ctypes.CDLL(str(_kept(made, kept)))
    except (OSError, subprocess.SubprocessError):
        return None


def _kept(made: Path, kept: Path) -> Path:
    """Where a library is for the next time; where it was made if it cannot be kept."""
    try:
        kept.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=kept.parent, delete=False) as file:
            file.write(made.read_bytes())
        Path(file.name).replace(kept)
    except OSError:
        return made
    return kept
