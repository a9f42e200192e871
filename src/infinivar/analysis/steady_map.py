"""Steady map: power, every loss, efficiency and binding limit on a force-speed grid."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar import power
from infinivar._core import extras, netcdf
from infinivar._core.frozen import FrozenDict
from infinivar.drivetrain.drive import Drive
from infinivar.errors import AuditError, InputError
from infinivar.limits import Limit, binding

if TYPE_CHECKING:
    from pathlib import Path

    import xarray

_TILE = 65_536
"""Points computed at once: the intermediate arrays of a tile fit the processor's caches, and dwarf Python's overhead."""

_LOSS = "loss: "
"""Marks a loss among the fields of a tile."""

_TILES_WORTH_THREADS = 8
"""Fewer tiles are done before threads have started."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SteadyMap:
    """Map over speed (first axis) and force (second axis); SI. The maps are read-only.

    Attributes
    ----------
    speed, force : (n,), (m,) float     Axes. [m s^-1], [N]
    power_in, power_out : (n, m) float  From the supply, to the load; nan where there is no steady motion. [W]
    losses : mapping of name to (n, m) float   [W]
    efficiency : (n, m) float           nan outside limits and where both sides feed the losses. [-]
    limit : (n, m) int8                 Values of `Limit`.
    margin : (n, m) float               Allowance over demand of the tightest limit. [-]
    audit_residual : float              Largest share of power that does not add up, checked when the map was made. [-]
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

    def to_xarray(self) -> xarray.Dataset:
        """Labelled data set with units, losses as ``loss_<name>``; needs the extra ``xarray``."""
        return extras.load("xarray", "xarray", "a labelled data set").Dataset(*self._labelled())

    def _labelled(self) -> tuple[dict[str, Any], dict[str, Any], dict[str, Any]]:
        """Variables, coordinates and attributes."""
        grid = ("speed", "force")

        def variable(values: np.ndarray, unit: str, meaning: str, **more: Any) -> tuple[Any, ...]:
            return grid, values, {"units": unit, "long_name": meaning, **more}

        losses = {
            f"loss_{name.replace(' ', '_')}": variable(values, "W", f"power lost in {name}")
            for name, values in self.losses.items()
        }
        codes = {
            "flag_values": np.array([limit.value for limit in Limit], dtype=np.int8),
            "flag_meanings": " ".join(limit.name for limit in Limit),
        }
        return (
            {
                "power_in": variable(self.power_in, "W", "power from the supply"),
                "power_out": variable(self.power_out, "W", "power to the load"),
                **losses,
                "efficiency": variable(self.efficiency, "1", "useful power over power spent"),
                "limit": variable(self.limit, "1", "limit that binds", **codes),
                "margin": variable(self.margin, "1", "allowance over demand of the tightest limit"),
            },
            {
                "speed": ("speed", self.speed, {"units": "m s-1", "long_name": "speed of the load"}),
                "force": ("force", self.force, {"units": "N", "long_name": "force on the load"}),
            },
            {"audit_residual": self.audit_residual},
        )

    def to_netcdf(self, path: str | Path) -> None:
        """Write the map as NetCDF (version 3, readable everywhere)."""
        netcdf.write(path, *self._labelled())


def _axis(name: str, values: Any, unit: str) -> np.ndarray:
    axis = np.atleast_1d(np.asarray(values, dtype=float))
    if axis.ndim != 1 or axis.size == 0:
        raise InputError(f"{name} must be one-dimensional and not empty, got shape {axis.shape}")
    if not np.isfinite(axis).all():
        raise InputError(f"{name} must be finite {unit}, got {axis[~np.isfinite(axis)][0]}")
    return axis


def steady_map(drive: Drive, speed: Any, force: Any, *, progress: Callable[[float], None] | None = None) -> SteadyMap:
    """Evaluate a drive-train on a grid and audit every point.

    Parameters
    ----------
    drive : Drive         Any drive-train.
    speed : (n,) float    Speeds of the load; negative ones for the other quadrants. [m s^-1]
    force : (m,) float    Forces on the load. [N]
    progress              Called with the share done, 0 to 1.

    Returns
    -------
    SteadyMap

    Raises
    ------
    InputError
        If an axis is not a finite vector.
    AuditError
        If powers and losses do not add up anywhere, or a power is nan where there should be one.
    """
    speed, force = _axis("speed", speed, "m/s"), _axis("force", force, "N")
    shape = (speed.size, force.size)
    rows = max(1, _TILE // force.size)
    columns = min(force.size, _TILE)
    tiles = [
        np.s_[top : top + rows, left : left + columns]
        for top in range(0, speed.size, rows)
        for left in range(0, force.size, columns)
    ]
    # The first tile says which fields there are, and on which axes they depend; a loss that is the same everywhere
    # takes the room of one number. Threads then write to disjoint parts.
    first = _evaluated(drive, speed, force, tiles[0])
    tile_shape = first[0]["power_out"].shape
    room = {name: _room(value, tile_shape, shape) for name, value in first[0].items()}

    def compute(tile: tuple[slice, slice]) -> float:
        values, residual = first if tile is tiles[0] else _evaluated(drive, speed, force, tile)
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
    fields = {name: np.broadcast_to(values, shape) for name, values in room.items()}
    losses = {name.removeprefix(_LOSS): fields.pop(name) for name in room if name.startswith(_LOSS)}
    return SteadyMap(speed=speed, force=force, losses=FrozenDict(losses), audit_residual=worst, **fields)


def _room(value: Any, tile_shape: tuple[int, int], shape: tuple[int, int]) -> np.ndarray:
    """Empty array for a field of the whole map, of length 1 along each axis on which the field does not depend."""
    value = np.asarray(value)
    extents = zip((1,) * (2 - value.ndim) + value.shape, tile_shape, shape, strict=True)
    return np.empty(tuple(1 if here == 1 < tile else whole for here, tile, whole in extents), dtype=value.dtype)


def _evaluated(
    drive: Drive, speed: np.ndarray, force: np.ndarray, tile: tuple[slice, slice]
) -> tuple[dict[str, Any], float]:
    """Fields of one tile, losses among them, audited, and the largest residual."""
    point = drive.operate(speed=speed[tile[0], None], force=force[None, tile[1]])
    residual = power.audit(point.power_in, point.power_out, point.losses, "steady map")
    limit, margin = binding(point.utilisation)
    if np.any(np.isnan(point.power_in) & (limit != Limit.SLIP)):
        raise AuditError("steady map: a power is nan although the wheel does not slip")
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
    """A `map` that uses all processors where there is enough to do: NumPy computes tiles side by side in threads."""
    if tasks < _TILES_WORTH_THREADS:
        yield map
        return
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        yield pool.map
