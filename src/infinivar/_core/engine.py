"""Formulas over `xp` compiled by JAX where it is installed: in float64, on the processor, kept on disk; else NumPy.

The numbers are those of NumPy to rounding. JAX is imported where something is compiled, and its settings are those of the
user again afterwards.
"""

from __future__ import annotations

import collections
import contextlib
import importlib
import os
import pickle
import sys
import threading
import warnings
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np

from infinivar._core import extras, files
from infinivar.errors import InputError, require

Engine = Literal["auto", "numpy", "jax"]
"""auto: JAX where it is installed, can compile the computation and saves time by it; else NumPy."""

ENGINES: tuple[Engine, ...] = ("auto", "numpy", "jax")

NOT_INSTALLED = "JAX is not installed"

_KEPT = 16
"""Compiled functions kept in memory."""

_LARGEST_CACHE = 64 * 2**20
"""Size of the folder of compiled functions. [bytes]"""

_SHOWN = 120
"""Most characters of a reason."""

_LOCK = threading.Lock()
"""Held while settings that JAX shares between threads differ from those of the user."""

_kept: collections.OrderedDict[bytes, Callable[..., Any] | NotCompiledError] = collections.OrderedDict()

_forked = False


def _after_fork() -> None:
    """A forked process lacks JAX's threads and would wait for them forever."""
    global _forked
    _forked = "jax" in sys.modules


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork)


class NotCompiledError(Exception):
    """A computation cannot be compiled; the message says why."""


def check(engine: str) -> None:
    """Raise ParameterError unless the engine is known."""
    require(engine in ENGINES, "engine", repr(engine), "auto, numpy or jax")


def unavailable() -> str | None:
    """Why JAX cannot be used; None if it can."""
    if _forked:
        return "the process was forked from one that uses JAX"
    if sys.modules.get("jax") is None and not extras.there("jax"):
        return NOT_INSTALLED
    try:
        probe = threading.Thread(target=bool)
        probe.start()
        probe.join()
    except RuntimeError:
        return "threads cannot start"
    return None


def chosen(
    engine: Engine, *, worth: bool, compile: Callable[[], Callable[..., Any]]
) -> tuple[Callable[..., Any] | None, str]:
    """Decide on an engine.

    Parameters
    ----------
    engine : str       The user's choice.
    worth : bool       Whether compiling pays off.
    compile            Compiles the computation by `compiled`.

    Returns
    -------
    function, reason   The compiled function; None and the reason where NumPy computes.

    Raises
    ------
    ParameterError
        If the engine is unknown.
    InputError
        If the user requested JAX, and it is not installed or cannot compile the computation.
    """
    check(engine)
    if engine == "numpy":
        return None, "as requested"
    if engine == "auto" and not worth:
        return None, "too small to compile"
    if engine == "jax":
        extras.load("jax", "jax", "engine jax")
    reason = unavailable()
    if reason is None:
        try:
            return compile(), ""
        except NotCompiledError as problem:
            reason = str(problem)
    if engine == "jax":
        raise InputError(f"engine jax cannot be used here: {reason}; choose auto or numpy")
    return None, reason


def compiled(function: Callable[..., Any], shapes: Sequence[tuple[int, ...]], key: Any = None) -> Callable[..., Any]:
    """Compile a function of float64 arrays, or take it from memory or disk.

    Parameters
    ----------
    function           Over any array namespace; returns arrays, in dictionaries and tuples.
    shapes             Shape of each argument.
    key                All that the function depends on; None if it is not to be kept in memory. It is compared by its pickle.

    Returns
    -------
    callable   Takes NumPy arrays of these shapes and returns read-only ones; thread-safe.

    Raises
    ------
    NotCompiledError
        If the function cannot be traced, or JAX fails.
    """
    found = None if key is None else _kept.get(_name(key, shapes))
    if found is None:
        try:
            found = _compile(function, shapes)
        except Exception as problem:  # whatever a formula or JAX raises: NumPy's way says what is wrong, if anything is
            found = NotCompiledError(_reason(problem))
        if key is not None:
            _keep(_name(key, shapes), found)  # named anew: a part may have stored what it has computed by now
    if isinstance(found, NotCompiledError):
        raise NotCompiledError(*found.args)
    return found


def _name(key: Any, shapes: Sequence[tuple[int, ...]]) -> bytes:
    """Name under which a function is kept; empty if it cannot be."""
    try:
        return pickle.dumps((key, tuple(shapes)))
    except Exception:  # parts of others may refuse in any way
        return b""


def _keep(name: bytes, found: Callable[..., Any] | NotCompiledError) -> None:
    if name:
        _kept[name] = found
        with contextlib.suppress(KeyError):  # another thread was faster
            while len(_kept) > _KEPT:
                _kept.popitem(last=False)


def _reason(problem: Exception) -> str:
    """The beginning of what went wrong."""
    lines = str(problem).strip().splitlines() or [""]
    said = f"{type(problem).__name__}: {lines[0]}"
    return said if len(said) <= _SHOWN else f"{said[: _SHOWN - 4]} ..."


def _compile(function: Callable[..., Any], shapes: Sequence[tuple[int, ...]]) -> Callable[..., Any]:
    import jax

    with local(jax):
        like = [jax.ShapeDtypeStruct(shape, np.float64) for shape in shapes]
        lowered = jax.jit(function).lower(*like)
        with _on_disk(jax):
            run = lowered.compile()

    def call(*arrays: np.ndarray) -> Any:
        with local(jax):
            return jax.tree.map(np.asarray, run(*arrays))

    return call


@contextlib.contextmanager
def local(jax: Any) -> Iterator[None]:
    """JAX in float64 on the processor, nan as a value, for the calling thread only."""
    # Before JAX 0.8 it was experimental.
    float64 = (jax if hasattr(jax, "enable_x64") else importlib.import_module("jax.experimental")).enable_x64
    with float64(True), jax.default_device(jax.devices("cpu")[0]), jax.debug_nans(False), jax.debug_infs(False):
        yield


def cache_folder() -> Path | None:
    """Folder of compiled functions, which only the user can write to; None where there is none."""
    folder = files.of_user("cache") / "compiled"
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    except OSError:
        return None
    return folder if os.access(folder, os.W_OK | os.X_OK) else None


@contextlib.contextmanager
def _on_disk(jax: Any) -> Iterator[None]:
    """What is compiled inside comes from the folder, or goes there; the user's own folder of JAX has precedence."""
    folder = None if jax.config.jax_compilation_cache_dir else cache_folder()
    if folder is None:
        yield
        return
    from jax.experimental.compilation_cache import compilation_cache

    required = {
        "jax_compilation_cache_dir": str(folder),
        "jax_compilation_cache_max_size": _LARGEST_CACHE,
        "jax_persistent_cache_min_compile_time_secs": 0.1,
    }
    with _LOCK, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a folder that fails costs time only
        before = {name: getattr(jax.config, name) for name in required}
        try:
            _set(jax, required)
            yield
        finally:
            _set(jax, before)
            compilation_cache.reset_cache()


def _set(jax: Any, values: dict[str, Any]) -> None:
    for name, value in values.items():
        jax.config.update(name, value)
