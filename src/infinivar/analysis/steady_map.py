"""Steady map: power, every loss, efficiency and binding limit on a force-speed grid."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import field
from typing import Any

import numpy as np

from infinivar import power
from infinivar._core import engine as engines
from infinivar._core.array_namespace import Array, namespace
from infinivar._core.arrays import real_array
from infinivar._core.described import reported
from infinivar._core.engine import Engine
from infinivar._core.frozen import FrozenDict, Room
from infinivar._core.labels import Labels, is_labelled, labels_of
from infinivar._core.result import Result, result
from infinivar._core.threads import in_order
from infinivar.axis import LINEAR, PLANE, Axis, force_axis, speed_axis
from infinivar.drivetrain.drive import Drive, DrivePoint, operated
from infinivar.errors import AuditError, InputError
from infinivar.limits import LEADING, Limit, binding, codes

_TILE = 65_536
"""Points computed at once, so that intermediate arrays fit the processor's caches and Python's overhead is small."""

_COMPILED_TILE = 32, 1024
"""Speeds and forces computed at once by compiled code, whatever the size of the map: it is compiled once for a drive."""

WORTH_COMPILING = 4_000_000
"""Smallest number of points for which it pays off to import JAX and compile."""

_LOSS = "loss: "
"""Marks a loss among the fields of a tile."""

_TILES_WORTH_THREADS = 8
"""Smallest number of tiles for which threads pay off."""

Tile = tuple[slice, slice]
Fields = dict[str, Any]


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
    engine : str                        numpy or jax, which computed the map.
    engine_reason : str                 Why not jax; "" if jax did.
    """

    speed: np.ndarray = speed_axis()
    force: np.ndarray = force_axis()
    power_in: np.ndarray = reported("W", "power from the supply", PLANE)
    power_out: np.ndarray = reported("W", "power to the load", PLANE)
    losses: Mapping[str, np.ndarray] = reported("W", "power lost in {}", PLANE, variable="loss_{}")
    efficiency: np.ndarray = reported("1", "useful power over power spent", PLANE)
    limit: np.ndarray = reported("1", "limit exceeded", PLANE, notes=codes)
    margin: np.ndarray = reported("1", "allowance over demand of the tightest limit", PLANE)
    audit_residual: float = reported("1", attribute="audit_residual")
    labels: Labels | None = None
    axis: Axis = LINEAR
    engine: str = reported(attribute="engine", default="numpy", compare=False)
    engine_reason: str = field(default="", compare=False)


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
    engine: Engine = "auto",
    progress: Callable[[float], None] | None = None,
) -> SteadyMap:
    """Evaluate a drive on a grid and audit every point.

    Parameters
    ----------
    drive : Drive         Any object with the method `operate` of a `Drive`.
    speed : (n,) float    Speeds of the load; negative ones for the other quadrants. [m s^-1]
    force : (m,) float    Forces on the load. [N]
    position : float      Position of the load, which matters for drives with springs or a linkage. [m]
    engine : str          numpy; jax, compiled, with the same numbers to rounding; or auto: jax for maps of at least
        `WORTH_COMPILING` points where it is installed and can compile the drive.
    progress              Called with the share done, 0 to 1.

    Returns
    -------
    SteadyMap

    Raises
    ------
    InputError
        If an axis is not a finite vector, or JAX is requested and is not installed or cannot compile the drive.
    ParameterError
        If the engine is unknown, the drive has no method `operate`, or it does not return a `DrivePoint`.
    AuditError
        If the power balance of a point does not close, or a power is nan although the wheel does not slip.
    """
    labels = _labels(speed, force)
    speed, force = _axis("speed", speed), _axis("force", force)
    shape = (speed.size, force.size)
    # Drives of other packages may lack the argument.
    operate = functools.partial(operated, drive, **({"position": position} if position else {}))
    small = (min(speed.size, _COMPILED_TILE[0]), min(force.size, _COMPILED_TILE[1]))
    fast, reason = engines.chosen(
        engine,
        worth=speed.size * force.size >= WORTH_COMPILING,
        compile=lambda: engines.compiled(
            functools.partial(_tile, operate), [small[:1], small[1:]], key=("steady map", drive, position)
        ),
    )
    tiles = (
        _tiles(shape, (max(1, _TILE // force.size), min(force.size, _TILE))) if fast is None else _whole(shape, small)
    )

    def evaluate(tile: Tile) -> tuple[Fields, float]:
        if fast is not None:
            fields, worst, accepted = fast(speed[tile[0]], force[tile[1]])
            if accepted:
                return fields, float(worst)
        return _evaluated(operate, speed[tile[0]], force[tile[1]])

    # The first tile determines the fields and the axes on which they depend; a constant loss occupies a single number.
    # Threads then write to disjoint parts, or the same numbers where tiles overlap.
    first = evaluate(tiles[0])
    tile_shape = first[0]["power_out"].shape
    room = {name: _room(value, tile_shape, shape) for name, value in first[0].items()}

    def compute(tile: Tile) -> float:
        values, residual = first if tile is tiles[0] else evaluate(tile)
        for name, value in values.items():
            store = room[name].array
            store[tuple(part if size > 1 else np.s_[:] for part, size in zip(tile, store.shape, strict=True))] = value
        return residual

    worst = 0.0
    run = map if len(tiles) < _TILES_WORTH_THREADS else in_order
    for done, residual in enumerate(run(compute, tiles), start=1):
        worst = max(worst, residual)
        if progress is not None:
            progress(done / len(tiles))
    fields = {name: np.broadcast_to(room.pop(name).locked(), shape) for name in list(room)}
    losses = {name.removeprefix(_LOSS): fields.pop(name) for name in list(fields) if name.startswith(_LOSS)}
    return SteadyMap(
        speed=speed,
        force=force,
        losses=FrozenDict(losses),
        audit_residual=worst,
        labels=labels,
        axis=getattr(drive, "axis", LINEAR),
        engine="numpy" if fast is None else "jax",
        engine_reason=reason,
        **fields,
    )


def _tiles(shape: tuple[int, int], tile: tuple[int, int]) -> list[Tile]:
    """Parts of a map; those at the end of an axis may be smaller."""
    rows, columns = (
        [slice(start, start + size) for start in range(0, whole, size)] for whole, size in zip(shape, tile, strict=True)
    )
    return [(row, column) for row in rows for column in columns]


def _whole(shape: tuple[int, int], tile: tuple[int, int]) -> list[Tile]:
    """Parts of a map that all have one size; those at the end of an axis overlap the ones before."""
    return [
        tuple(
            slice(min(part.start, whole - size), min(part.stop, whole))
            for part, whole, size in zip(one, shape, tile, strict=True)
        )  # type: ignore[misc]
        for one in _tiles(shape, tile)
    ]


def _labels(speed: Any, force: Any) -> Labels | None:
    """Labels of the map from those of its axes; an unlabelled axis keeps its usual name."""
    axes = {"speed": speed, "force": force}
    given = {name: axis for name, axis in axes.items() if is_labelled(axis)}
    dims = tuple(str(given[name].dims[0]) if name in given and given[name].ndim == 1 else name for name in axes)
    if len(set(dims)) == 1:
        raise InputError(f"speed and force must be labelled with different dimensions, got {dims[0]!r} for both")
    return labels_of(given, dims) if given else None


def _room(value: Any, tile_shape: tuple[int, int], shape: tuple[int, int]) -> Room:
    """Room for a field of the whole map, of length 1 along axes on which the field does not depend."""
    value = np.asarray(value)
    extents = zip((1,) * (2 - value.ndim) + value.shape, tile_shape, shape, strict=True)
    return Room(tuple(1 if here == 1 < tile else whole for here, tile, whole in extents), value.dtype)


def _evaluated(operate: Callable[..., DrivePoint], speed: np.ndarray, force: np.ndarray) -> tuple[Fields, float]:
    """Evaluate and audit one tile: its fields, losses included, and the largest residual."""
    point = operate(speed=speed[:, None], force=force[None, :])
    residual = power.audit(point.power_in, point.power_out, point.losses, "steady map")
    fields = _fields(point)
    if np.any(_lost(fields)):
        raise AuditError(
            "steady map: a power is nan although the wheel does not slip, linkages reach and no spring pulls"
        )
    return fields, residual


def _tile(operate: Callable[..., DrivePoint], speed: Array, force: Array) -> tuple[Fields, Array, Array]:
    """As `_evaluated` over any array namespace: whether the audit accepts the tile comes last."""
    xp = namespace(speed, force)
    point = operate(speed=speed[:, None], force=force[None, :])
    worst, accepted = power.judged(point.power_in, point.power_out, point.losses)
    fields = _fields(point)
    return fields, worst, accepted & ~xp.any(_lost(fields))


def _fields(point: DrivePoint) -> Fields:
    limit, margin = binding(point.utilisation)
    return {
        "power_in": point.power_in,
        "power_out": point.power_out,
        "efficiency": power.efficiency_within(limit, point.power_in, point.power_out),
        "limit": limit,
        "margin": margin,
        **{_LOSS + name: loss for name, loss in point.losses.items()},
    }


def _lost(fields: Fields) -> Array:
    """Where the supply's power is nan although no limit explains it."""
    xp, limit = namespace(fields["power_in"]), fields["limit"]
    lost = xp.isnan(fields["power_in"])
    for explains in (*LEADING, Limit.SPRING):
        lost = lost & (limit != int(explains))
    return lost
