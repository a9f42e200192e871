"""Shared libraries made of C texts by the compiler of the system or zig's, kept for the next time; none is needed to install."""

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

from infinivar._core import extras, kept

FLAGS = ("-std=c99", "-O3", "-fPIC", "-shared", "-ffp-contract=off")
"""No contraction of products and sums: the same numbers as by single operations."""

SWITCH = "INFINIVAR_COMPILE"
"""Environment variable; 0 keeps every run in Python."""

_LONGEST = 900.0
"""Longest time of a call: zig builds the libraries of a platform at the first one, for minutes. [s]"""


class CompilerError(Exception):
    """A C compiler failed; the line of its words that says why."""


def compiler() -> tuple[str, ...] | None:
    """Command of a C compiler: that of `CC`, or cc, gcc or clang, else zig's; None without one."""
    if os.environ.get(SWITCH) == "0" or sys.platform == "win32":
        return None
    own = _found(os.environ.get("CC", ""))
    return zig() if own is None else (own,)


@functools.cache
def _found(own: str) -> str | None:
    return next((found for name in (own, "cc", "gcc", "clang") if name and (found := shutil.which(name))), None)


def zig() -> tuple[str, ...] | None:
    """Command of zig's C compiler, which compiles for every platform; None where the extra `compiled` is missing."""
    if os.environ.get(SWITCH) == "0" or not extras.there("ziglang"):
        return None
    return sys.executable, "-m", "ziglang", "cc"


def no_compiler() -> str | None:
    """One line where the system lacks a compiler that nobody switched off."""
    if compiler() is not None or os.environ.get(SWITCH) == "0":
        return None
    return "no C compiler found (cc, gcc, clang or CC): simulated in Python, two to five times slower"


@functools.lru_cache(maxsize=64)
def library(text: str, flags: tuple[str, ...] = FLAGS) -> ctypes.CDLL | None:
    """The library of a text, compiled unless it is known; None without a compiler, or where it cannot."""
    try:
        with tempfile.TemporaryDirectory() as folder:
            made = _compiled(compiler(), text, flags, Path(folder, "model.so"))
            return None if made is None else ctypes.CDLL(str(made))
    except (OSError, CompilerError):
        return None


def binary(text: str, name: str, *flags: str, target: str = "") -> bytes | None:
    """Content of the library of a text, compiled with flags, for a platform of zig or this one; None without a compiler.

    A file has the name of its library within it.

    Raises
    ------
    CompilerError
        If the compiler fails.
    """
    command = compiler() if not target else zig()
    if command is not None and target:
        command = *command, "-target", target
    try:
        with tempfile.TemporaryDirectory() as folder:
            made = _compiled(command, text, flags, Path(folder, name))
            return None if made is None else made.read_bytes()
    except OSError:
        return None


def _compiled(command: tuple[str, ...] | None, text: str, flags: Sequence[str], made: Path) -> Path | None:
    """File of the library of a text: the one that is kept, or else in a folder."""
    if command is None:
        return None
    if command[0] == sys.executable:  # the processor may be another one when a library that is kept is used
        command = *command, "-mcpu=baseline"
    key = hashlib.sha256("\n".join([text, *command, *flags, platform.machine()]).encode()).hexdigest()[:32]
    known = kept.find(key, made.suffix)
    if known is not None:
        return known
    source = made.with_name("model.c")
    source.write_text(text, "utf-8")
    try:
        call = [*command, *flags, "-o", made, source, "-lm"]
        subprocess.run(call, check=True, capture_output=True, timeout=_LONGEST)
    except subprocess.CalledProcessError as problem:
        lines = [line.strip() for line in problem.stderr.decode("utf-8", "replace").splitlines() if line.strip()]
        why = next((line for line in lines if "error" in line), lines[-1] if lines else "without a word")
        raise CompilerError(why.replace(str(source), source.name)) from problem
    except subprocess.TimeoutExpired as problem:
        raise CompilerError(f"it took more than {_LONGEST:g} s") from problem
    return kept.keep(key, made.suffix, made.read_bytes()) or made
