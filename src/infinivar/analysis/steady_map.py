"""Steady map: power, every loss, efficiency and binding limit on a force-speed grid."""

from __future__ import annotations

import contextlib
import functools
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar import power
from infinivar._core.arrays import real_array
from infinivar._core.frozen import FrozenDict, frozen
from infinivar._core.labels import Labels, is_labelled, labels_of
from infinivar._core.result import Result, result
from infinivar.axis import LINEAR, Axis
from infinivar.drivetrain.drive import Drive, operated
from infinivar.errors import AuditError, InputError
from infinivar.limits import LEADING, Limit, binding

if TYPE_CHECKING:
    pass

_TILE = 65_536
"""Points computed at once, so that intermediate arrays fit the processor's caches and Python's overhead is small."""

_LOSS = "loss: "
"""Marks a loss among the fields of a tile."""

_TILES_WORTH_THREADS = 8
"""Smallest number of tiles for which threads pay off."""


@result
class SteadyMap(Result):
    """Map over speed (first axis) and force (second axis), in SI; arrays are read-only.

    Attributes
    ----------
    speed, force : (n,), (m,) float     Axes. [m s^-1], [N], or [rad s^-1], [N m] about a joint
    power_in, power_out : (n, m) float  Power from the supply and to the load; nan without steady motion. [W]
    losses : mapping of name to (n, m) float   [W]
    efficiency : (n, m) float           nan outside limits and where both sides feed the losses. [-]
    limit : (n, m) int8                 Values of `Limit`.
    margin : (n, m) float               Allowance over demand of the tightest limit. [-]
    audit_residual : float              Largest relative residual of the power balance. [-]
    labels : Labels or None             Labels of labelled axes.
    axis : Axis                         Whether the load moves along a line or about a joint.
    """

    speed: np.ndarray
    force: np.ndarray
    power_in: np.ndarray
    power_out: np.ndarray
    losses: Mapping[str, np.ndarray]
    efficiency: np.ndarray
    limit: np.ndarray
    margin: np.ndarray
    audit_residual: float
    labels: Labels | None = None
    axis: Axis = LINEAR


def _axis(name: str, values: Any) -> np.ndarray:
    axis = np.array(real_array(name, values), ndmin=1)
    if axis.ndim != 1 or axis.size == 0:
        raise InputError(f"{name} must be one-dimensional and not empty, got shape {axis.shape}")
    if not np.isfinite(axis).all():
        raise InputError(f"{name} must be finite, got {axis[~np.isfinite(axis)][0]}")
    return axis


def steady_map(
    drive: Drive,
    speed: Any,
    force: Any,
    *,
    position: float = 0.0,
    progress: Callable[[float], None] | None = None,
) -> SteadyMap:
    """Evaluate a drive on a grid and audit every point.

    Parameters
    ----------
    drive : Drive         Any object with the method `operate` of a `Drive`.
    speed : (n,) float    Speeds of the load; negative ones for the other quadrants. [m s^-1]
    force : (m,) float    Forces on the load. [N]
    position : float      Position of the load, which matters for drives with springs or a linkage. [m]
    progress              Called with the share done, 0 to 1.

    Returns
    -------
    SteadyMap

    Raises
    ------
    InputError
        If an axis is not a finite vector.
    ParameterError
        If the drive has no method `operate`, or it does not return a `DrivePoint`.
    AuditError
        If the power balance of a point does not close, or a power is nan although the wheel does not slip.
    """
    labels = _labels(speed, force)
    speed, force = _axis("speed", speed), _axis("force", force)
    shape = (speed.size, force.size)
    rows = max(1, _TILE // force.size)
    columns = min(force.size, _TILE)
    tiles = [
        np.s_[top : top + rows, left : left + columns]
        for top in range(0, speed.size, rows)
        for left in range(0, force.size, columns)
    ]
    # The first tile determines the fields and the axes on which they depend; a constant loss occupies a single number.
    # Threads then write to disjoint parts.
    operate = functools.partial(operated, drive, **({"position": position} if position else {}))
    first = _evaluated(operate, speed, force, tiles[0])
    tile_shape = first[0]["power_out"].shape
    room = {name: _room(value, tile_shape, shape) for name, value in first[0].items()}

    def compute(tile: tuple[slice, slice]) -> float:
        values, residual = first if tile is tiles[0] else _evaluated(operate, speed, force, tile)
        for name, value in values.items():
            store = room[name]
            store[tuple(part if size > 1 else np.s_[:] for part, size in zip(tile, store.shape, strict=True))] = value
        return residual

    worst = 0.0
    with _workers(len(tiles)) as run:
        for done, residual in enumerate(run(compute, tiles), start=1):
            worst = max(worst, residual)
            if progress is not None:
                progress(done / len(tiles))
    # One by one, so that a large map is never in memory twice.
    fields = {name: np.broadcast_to(frozen(room.pop(name)), shape) for name in list(room)}
    losses = {name.removeprefix(_LOSS): fields.pop(name) for name in list(fields) if name.startswith(_LOSS)}
    return SteadyMap(
        speed=speed,
        force=force,
        losses=FrozenDict(losses),
        audit_residual=worst,
        labels=labels,
        axis=getattr(drive, "axis", LINEAR),
        **fields,
    )


def _labels(speed: Any, force: Any) -> Labels | None:
    """Labels of the map from those of its axes; an unlabelled axis keeps its usual name."""
    axes = {"speed": speed, "force": force}
    given = {name: axis for name, axis in axes.items() if is_labelled(axis)}
    dims = tuple(str(given[name].dims[0]) if name in given and given[name].ndim == 1 else name for name in axes)
    if len(set(dims)) == 1:
        raise InputError(f"speed and force must be labelled with different dimensions, got {dims[0]!r} for both")
    return labels_of(given, dims) if given else None


def _room(value: Any, tile_shape: tuple[int, int], shape: tuple[int, int]) -> np.ndarray:
    """Empty array for a field of the whole map, of length 1 along axes on which the field does not depend."""
    value = np.asarray(value)
    extents = zip((1,) * (2 - value.ndim) + value.shape, tile_shape, shape, strict=True)
    return np.empty(tuple(1 if here == 1 < tile else whole for here, tile, whole in extents), dtype=value.dtype)


def _evaluated(
    operate: Callable[..., Any], speed: np.ndarray, force: np.ndarray, tile: tuple[slice, slice]
) -> tuple[dict[str, Any], float]:
    """Evaluate and audit one tile: its fields, losses included, and the largest residual."""
    point = operate(speed=speed[tile[0], None], force=force[None, tile[1]])
    residual = power.audit(point.power_in, point.power_out, point.losses, "steady map")
    limit, margin = binding(point.utilisation)
    if np.any(np.isnan(point.power_in) & ~np.isin(limit, (*LEADING, Limit.SPRING))):
        raise AuditError(
            "steady map: a power is nan although the wheel does not slip, linkages reach and no spring pulls"
        )
    fields = {
        "power_in": point.power_in,
        "power_out": point.power_out,
        "efficiency": power.efficiency_within(limit, point.power_in, point.power_out),
        "limit": limit,
        "margin": margin,
        **{_LOSS + name: loss for name, loss in point.losses.items()},
    }
    return fields, residual


@contextlib.contextmanager
def _workers(tasks: int) -> Iterator[Callable[..., Iterable[Any]]]:
    """Provide a `map` that computes tiles in threads on all processors if there are enough of them."""
    if tasks < _TILES_WORTH_THREADS:
        yield map
        return
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        yield pool.map
