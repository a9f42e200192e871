"""Drives and parts of other packages: failures in their code are named, and what they return is checked.

A message names the extension, its method and what was expected of it. Results must have the type and keys of a drive's points,
and a balance of powers that closes at every point.
"""

from __future__ import annotations

import contextlib
import inspect
from collections.abc import Iterator, Mapping
from types import TracebackType
from typing import Any

import numpy as np

from infinivar._core.array_namespace import Array
from infinivar._core.fields import Place, walk
from infinivar._core.plugins import is_own
from infinivar.errors import AuditError, InfinivarError, ParameterError
from infinivar.limits import Limit
from infinivar.power import AUDIT_TOLERANCE

_KEPT = 0.01
"""Largest mean of a stored power over a cycle, relative to the mean of its magnitude: sampling of jumps leaves 1e-3."""


@contextlib.contextmanager
def naming_failures(drive: Any, method: str, expected: str) -> Iterator[None]:
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
        failed = f"{type(drive).__name__}.{method}", expected
        if not is_own(drive):
            failed = _part([place.value for place in own_parts(drive)], problem.__traceback__)
        if failed is None:
            raise
        raise ParameterError(
            f"{failed[0]} fails with {type(problem).__name__}: {problem}; expected {failed[1]}"
        ) from problem


def own_parts(drive: Any) -> Iterator[Place]:
    """Yield the parts of a drive that are of other packages."""
    for place in walk(drive):
        number_or_text = isinstance(place.value, float | int | str | tuple) or type(place.value).__module__ == "numpy"
        if not number_or_text and is_own(place.value):
            yield place


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
    expected = " and ".join(dict.fromkeys(_expected(type(part)) for part in parts))
    return f"the drive with the part {named}", expected


def _expected(kind: type, method: str = "") -> str:
    base = next((one for one in kind.__mro__ if one.__module__.startswith("infinivar.")), None)
    if base is None:
        return "the methods of the part that it replaces, with the same arguments and results"
    if not hasattr(base, method):
        return f"the methods of {base.__name__}, with the same arguments and results"
    arguments = ", ".join(name for name in inspect.signature(getattr(base, method)).parameters if name != "self")
    return f"{method}({arguments}), with the result of {base.__name__}.{method}"


def check_kind(point: Any, kind: type, where: str) -> None:
    """Raise ParameterError unless a drive returned an operating point of that kind."""
    if not isinstance(point, kind):
        raise ParameterError(f"{where} must return a {kind.__name__}, got a {type(point).__name__}")


def check_steady(point: Any, expected: Array, where: str) -> None:
    """Check the demands of a steady point and the power to the load, which must be `expected` [W]."""
    for key in point.utilisation:
        if not isinstance(key, Limit):
            raise ParameterError(f"{where}: each key of utilisation must be a Limit, got {key!r}")
    _check_numbers(point, where)
    _check_demands({key.name: demand for key, demand in point.utilisation.items()}, np.isnan(point.power_in), where)
    _check_delivery(point.power_out, expected, where)


def check_moving(point: Any, expected: Array, where: str) -> None:
    """Check the demands of a moving point, the power to the load and, at each instant, losses and power balance."""
    for key in point.utilisation:
        if not (isinstance(key, tuple) and len(key) == 2 and isinstance(key[0], Limit) and isinstance(key[1], str)):
            raise ParameterError(
                f"{where}: each key of utilisation must be a Limit and the name of a part, such as (Limit.SPEED, 'motor'), "
                f"got {key!r}"
            )
    _check_numbers(point, where)
    slips = np.asarray(False)
    for (limit, _), demand in point.utilisation.items():
        slips = slips | ((limit == Limit.SLIP) & (np.asarray(demand) > 1.0))
    _check_demands({f"{key[0].name} of {key[1]}": demand for key, demand in point.utilisation.items()}, slips, where)
    flows = {"power_in": point.power_in, "power_out": point.power_out}
    named = {
        **flows,
        **{f"the {name} loss": loss for name, loss in point.losses.items()},
        **{f"the power stored in {name}": flow for name, flow in point.stored.items()},
    }
    for name, flow in named.items():
        if np.any(~np.isfinite(np.asarray(flow, dtype=float)) & ~slips):
            raise AuditError(f"{where}: {name} is not finite although the wheel does not slip")
    _check_delivery(point.power_out, expected, where)
    check_losses(point.losses, point.power_in, point.power_out, where)
    check_balance(point, where)


def _check_numbers(point: Any, where: str) -> None:
    """Raise ParameterError unless powers, losses and demands are real numbers."""
    named = {"power_in": point.power_in, "power_out": point.power_out}
    groups = (("losses", point.losses), ("stored", getattr(point, "stored", {})), ("utilisation", point.utilisation))
    for group, values in groups:
        named |= {f"{group}[{key!r}]": value for key, value in values.items()}
    for name, value in named.items():
        kind = np.asarray(value).dtype
        if kind.kind not in "fiub":
            raise ParameterError(f"{where}: {name} must be real numbers, got {_kind(kind, value)}")


def _kind(kind: np.dtype, value: Any) -> str:
    return "complex numbers" if kind.kind == "c" else repr(value)[:60]


def _check_demands(demands: Mapping[str, Array], undefined: Any, where: str) -> None:
    """Raise ParameterError if a demand is negative, or nan where powers are defined: it would count as within its limit."""
    for name, demand in demands.items():
        wrong = (np.asarray(demand) < 0) | (np.isnan(demand) & ~undefined)
        if np.any(wrong):
            bad = np.broadcast_to(demand, wrong.shape)[wrong].ravel()[0]
            raise ParameterError(
                f"{where}: utilisation of {name} must be a demand over its allowance, >= 0, got {bad:.3g}"
            )


def unbalanced(point: Any) -> Any:
    """Power from the supply without those to the load, into losses and into stores, at each instant. [W]"""
    missing = np.asarray(point.power_in - point.power_out)
    for flow in (*point.losses.values(), *point.stored.values()):
        missing = missing - flow
    return missing


def check_balance(point: Any, where: str) -> None:
    """Raise AuditError unless the balance of power closes at each instant, relative to the largest power of the cycle."""
    missing = unbalanced(point)
    flows = (point.power_in, point.power_out, *point.losses.values(), *point.stored.values())
    off, *sizes = (
        np.fmax.reduce(np.abs(np.broadcast_to(flow, missing.shape)), axis=-1, initial=0.0)
        if missing.ndim
        else abs(flow)
        for flow in (missing, *flows)
    )
    if np.any(off > AUDIT_TOLERANCE * np.fmax.reduce(sizes, axis=0)):
        raise AuditError(
            f"{where}: power_in differs from power_out, losses and stored powers together by up to {np.nanmax(off):.3g} W"
        )


def check_losses(losses: Mapping[str, Array], power_in: Array, power_out: Array, where: str) -> None:
    """Raise AuditError if a loss is negative at any instant, by more than rounding of the largest power."""
    scale = sum(np.fmax.reduce(np.abs(flow), axis=None, initial=0.0) for flow in (power_in, power_out))
    for name, loss in losses.items():
        least = np.fmin.reduce(loss, axis=None, initial=0.0)
        if least < -AUDIT_TOLERANCE * scale:
            raise AuditError(f"{where}: the {name} loss is negative, down to {least:.3g} W")


def check_returned(stored: Mapping[str, Array], where: str) -> None:
    """Raise AuditError if something stores or returns energy cycle after cycle."""
    for name, flow in stored.items():
        mean, size = float(np.mean(flow)), float(np.mean(np.abs(flow)))
        if abs(mean) > _KEPT * size:
            what = "stores" if mean > 0 else "returns"
            raise AuditError(
                f"{where}: {name} {what} {abs(mean):.3g} W on average, cycle after cycle; over a closed cycle what is stored is "
                "returned"
            )


def _check_delivery(power_out: Array, expected: Array, where: str) -> None:
    off = np.abs(np.asarray(power_out) - expected)
    if np.any(off > AUDIT_TOLERANCE * np.max(np.abs(expected), initial=0.0)):
        raise AuditError(f"{where}: power_out differs from force times speed by up to {np.nanmax(off):.3g} W")
