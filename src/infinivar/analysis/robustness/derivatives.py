"""Derivatives of an outcome with respect to a drive's parameters by complex step, JAX, or differences."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal

import numpy as np

from infinivar._core import complex_step, engine, extras
from infinivar._core.array_namespace import Array
from infinivar._core.bounds import permitted
from infinivar._core.fields import quantities_of, value_at, with_values
from infinivar.drivetrain.drive import with_rated_gear
from infinivar.errors import InputError

Method = Literal["complex", "jax", "difference"]

METHODS: tuple[Method, ...] = ("complex", "jax", "difference")

_ONE_SIDED = (-25 / 12, 4.0, -3.0, 4 / 3, -1 / 4)
"""Weights of a one-sided fourth-order difference at equal steps from the bound."""

_STEP = 2e-3
"""Relative step of differences; with Richardson extrapolation the error is of sixth order."""


def values_of(drive: Any, paths: Sequence[str]) -> np.ndarray:
    """Values of a drive's fields at dotted paths."""
    return np.asarray([value_at(drive, path) for path in paths], dtype=float)


def gradient(
    function: Callable[[Any], Array],
    drive: Any,
    paths: Sequence[str],
    *,
    at: Any = None,
    method: Method = "complex",
) -> tuple[np.ndarray, np.ndarray]:
    """Value of a function of a drive or part, and its derivatives with respect to fields.

    Parameters
    ----------
    function : callable       Function of a drive or part, over any array namespace, such as those of `outcomes`.
    drive : dataclass         Provides the fields not in `paths`.
    paths : sequence of str   Dotted paths of physical fields with values.
    at : (..., k) float       Values of the fields, for one or more designs; by default those of the drive.
    method : str              ``complex`` and ``jax`` are exact to rounding; ``difference`` is central, extrapolated.

    Returns
    -------
    value : (...) float
    derivatives : (..., k) float   nan where the value is nan.

    Raises
    ------
    InputError
        If the method is unknown, or JAX is requested but not installed.

    Source: squire1998 for the complex step.
    """
    at = values_of(drive, paths) if at is None else np.asarray(at, dtype=float)
    if method == "jax":
        return _by_jax(function, drive, paths, at)
    if method == "complex":
        return _by_complex_step(function, drive, paths, at)
    if method == "difference":
        return _by_difference(function, drive, paths, at)
    raise InputError(f"method must be one of {', '.join(METHODS)}, got {method!r}")


def varied(drive: Any, values: Mapping[str, Any]) -> Any:
    """The drive or part with other values at dotted paths; measured losses scale with the preload.

    Gearhead friction stays at the drive's rated torque if only the motor's continuous torque changes.
    """
    if "motor.continuous_torque" in values and "gearhead.rated_torque" not in values:
        drive = with_rated_gear(drive)
    preload = values.get("transmission.preload")
    if preload is None or drive.transmission.geometry is not None:
        return with_values(drive, values)
    others = {path: value for path, value in values.items() if path != "transmission.preload"}
    return with_values(drive, others).pressed(preload)


def designs(drive: Any, paths: Sequence[str], at: Any) -> Any:
    """Many designs as one drive, whose values at paths are arrays with a last axis of length 1 for points or instants."""
    return varied(drive, {path: at[..., place, None] for place, path in enumerate(paths)})


def _by_complex_step(
    function: Callable[[Any], Array], drive: Any, paths: Sequence[str], at: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    if at.ndim == 1 and paths:
        # One design: one row per field, in which only that field is perturbed.
        rows = np.broadcast_to(at, (at.size, at.size))
        steps = np.diag(complex_step.size_of_step(at))
        carried = {
            path: complex_step.Stepped(rows[:, k, None] + 1j * steps[:, k, None]) for k, path in enumerate(paths)
        }
        found = function(varied(drive, carried))
        if not isinstance(found, complex_step.Stepped):
            return np.asarray(found, dtype=float).ravel()[0], np.zeros(at.size)
        slope = found.slope / complex_step.size_of_step(at)
        return found.value[0], np.where(np.isnan(found.value), np.nan, slope)
    value, slopes = np.empty(at.shape[:-1]), np.empty(at.shape)
    for place, path in enumerate(paths):
        others = {other: at[..., k, None] for k, other in enumerate(paths) if k != place}

        def moved(x: Any, path: str = path, others: Mapping[str, Any] = others) -> Array:
            return function(varied(drive, {**others, path: x[..., None]}))

        found, slope = complex_step.derivative(moved, at[..., place])
        value, slopes[..., place] = np.broadcast_to(found, at.shape[:-1]), slope
    if not paths:
        value = np.broadcast_to(np.asarray(function(drive), dtype=float), at.shape[:-1])
    return value, np.where(np.isnan(value)[..., None], np.nan, slopes)


def _by_difference(
    function: Callable[[Any], Array], drive: Any, paths: Sequence[str], at: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    def value(x: np.ndarray) -> np.ndarray:
        return np.broadcast_to(np.asarray(function(designs(drive, paths, x)), dtype=float), x.shape[:-1])

    def along(place: int, steps: Any) -> np.ndarray:
        moved = at.copy()
        moved[..., place] += steps
        return value(moved)

    slopes = np.empty(at.shape)
    fields = quantities_of(drive)
    for place, path in enumerate(paths):
        size = _STEP * np.where(at[..., place] == 0, 1.0, np.abs(at[..., place]))
        ends = permitted(fields[path].metadata["bound"], 1.0 if np.all(at[..., place] >= 0) else -1.0)
        if np.any(at[..., place] + size > ends[1]) or np.any(at[..., place] - size < ends[0]):
            # At a bound, use a one-sided difference.
            inwards = size if np.any(at[..., place] - size < ends[0]) else -size
            slopes[..., place] = (
                sum(weight * along(place, count * inwards) for count, weight in enumerate(_ONE_SIDED)) / inwards
            )
            continue
        stage = [
            (along(place, part * size) - along(place, -part * size)) / (2.0 * part * size) for part in (1.0, 0.5, 0.25)
        ]
        once = [(4.0 * finer - coarser) / 3.0 for coarser, finer in itertools.pairwise(stage)]
        slopes[..., place] = (16.0 * once[1] - once[0]) / 15.0
    return value(at), slopes


def _by_jax(
    function: Callable[[Any], Array], drive: Any, paths: Sequence[str], at: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    jax = extras.load("jax", "jax", "method jax")

    def value(x: Any) -> Any:
        found = function(varied(drive, {path: x[place, None] for place, path in enumerate(paths)}))
        return jax.numpy.reshape(jax.numpy.asarray(found, dtype=jax.numpy.float64), ())

    def both(x: Any) -> tuple[Any, Any]:
        return value(x), jax.jacfwd(value)(x)

    with engine.local(jax):
        found, slopes = jax.jit(jax.vmap(both))(at.reshape(-1, at.shape[-1]))
    return np.asarray(found).reshape(at.shape[:-1]), np.asarray(slopes).reshape(at.shape)
