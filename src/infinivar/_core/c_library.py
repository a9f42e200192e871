"""Shared libraries made of C texts by the compiler of the system, and kept for the next time; none is needed to install."""

from __future__ import annotations

import ctypes
import functools
import hashlib
import os
import platform
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from infinivar._core import kept

FLAGS = ("-std=c99", "-O3", "-fPIC", "-shared", "-ffp-contract=off")
"""No contraction of products and sums: the same numbers as by single operations."""

SWITCH = "INFINIVAR_COMPILE"
"""Environment variable; 0 keeps every run in Python."""


def compiler() -> str | None:
    """Path of a C compiler: that of `CC`, or cc, gcc or clang; None without one."""
    if os.environ.get(SWITCH) == "0" or sys.platform == "win32":
        return None
    return _found(os.environ.get("CC", ""))


@functools.cache
def _found(own: str) -> str | None:
    return next((found for name in (own, "cc", "gcc", "clang") if name and (found := shutil.which(name))), None)


def no_compiler() -> str | None:
    """One line where the system lacks a compiler that nobody switched off."""
    if compiler() is not None or os.environ.get(SWITCH) == "0":
        return None
    return "no C compiler found (cc, gcc, clang or CC): simulated in Python, two to five times slower"


@functools.lru_cache(maxsize=64)
def library(text: str) -> ctypes.CDLL | None:
    """The library of a text, compiled unless it is known; None without a compiler, or where it cannot."""
    try:
        with tempfile.TemporaryDirectory() as folder:
            made = _compiled(text, FLAGS, Path(folder))
            return None if made is None else ctypes.CDLL(str(made))
    except OSError:
        return None


def binary(text: str, *flags: str) -> bytes | None:
    """Content of the library of a text, as `library`, compiled with flags."""
    try:
        with tempfile.TemporaryDirectory() as folder:
            made = _compiled(text, flags, Path(folder))
            return None if made is None else made.read_bytes()
    except OSError:
        return None


def _compiled(text: str, flags: Sequence[str], folder: Path) -> Path | None:
    """File of the library of a text: the one that is kept, or else in a folder."""
    own = compiler()
    if own is None:
        return None
    key = hashlib.sha256("\n".join([text, own, *flags, platform.machine()]).encode()).hexdigest()[:32]
    known = kept.find(key, ".so")
    if known is not None:
        return known
    source, made = folder / "model.c", folder / "model.so"
    source.write_text(text, "utf-8")
    try:
        subprocess.run([own, *flags, "-o", made, source, "-lm"], check=True, capture_output=True, timeout=120)
    except subprocess.SubprocessError:
        return None
    return kept.keep(key, ".so", made.read_bytes()) or made
