"""Failures in code of other packages: the message names the extension, its method and what was expected of it."""

from __future__ import annotations

import contextlib
import dataclasses
import inspect
from collections.abc import Iterator
from types import TracebackType
from typing import Any

from infinivar._core.plugins import is_own
from infinivar.errors import InfinivarError, ParameterError


@contextlib.contextmanager
def blaming(drive: Any, method: str, expected: str) -> Iterator[None]:
    """Turn any failure in an own drive's method, or in its own parts, into a ParameterError; others pass.

    Parameters
    ----------
    drive : Drive      Whose method runs in the context.
    method : str       Its name.
    expected : str     What an own drive's method takes and returns.
    """
    try:
        yield
    except InfinivarError:
        raise
    except Exception as problem:  # the code of others may fail in any way
        blame = f"{type(drive).__name__}.{method}", expected
        if not is_own(drive):
            blame = _part(_own_parts(drive), problem.__traceback__)
        if blame is None:
            raise
        raise ParameterError(
            f"{blame[0]} fails with {type(problem).__name__}: {problem}; expected {blame[1]}"
        ) from problem


def _own_parts(thing: Any) -> list[Any]:
    """Parts of a drive that are of other packages."""
    found = []
    for one in dataclasses.fields(thing) if dataclasses.is_dataclass(thing) else ():
        part = getattr(thing, one.name)
        if "meaning" not in one.metadata or part is None or isinstance(part, (float, int, str, tuple)):
            continue
        found += [part] if is_own(part) and type(part).__module__ != "numpy" else []
        found += _own_parts(part)
    return found


def _part(parts: list[Any], trace: TracebackType | None) -> tuple[str, str] | None:
    """Method that failed, or parts of which one returned what cannot be used; and what was expected. None without parts."""
    if not parts:
        return None
    while trace is not None:
        frame = trace.tb_frame
        one, name = frame.f_locals.get("self"), frame.f_code.co_name
        if any(one is part for part in parts):
            return f"{type(one).__name__}.{name}", _expected(type(one), name)
        trace = trace.tb_next
    named = " or ".join(dict.fromkeys(type(part).__name__ for part in parts))
    wanted = " and ".join(dict.fromkeys(_expected(type(part)) for part in parts))
    return f"the drive with the part {named}", wanted


def _expected(kind: type, method: str = "") -> str:
    base = next((one for one in kind.__mro__ if one.__module__.startswith("infinivar.")), None)
    if base is None:
        return "the methods of the part that it replaces, with the same arguments and results"
    if not hasattr(base, method):
        return f"the methods of {base.__name__}, with the same arguments and results"
    arguments = ", ".join(name for name in inspect.signature(getattr(base, method)).parameters if name != "self")
    return f"{method}({arguments}), with the result of {base.__name__}.{method}"
