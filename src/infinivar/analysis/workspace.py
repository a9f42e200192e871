"""Static points of a machine of many legs: many poses at a time, on all processors, and maps over its workspace."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from infinivar._core.array_namespace import Array, check_broadcast
from infinivar._core.arrays import real_array
from infinivar._core.fields import check_instance
from infinivar._core.result import Result, result
from infinivar._core.threads import in_order
from infinivar.errors import require
from infinivar.limits import Limit, binding
from infinivar.machines.many_legs import LeggedDrive, MachinePoint
from infinivar.power import audit
from infinivar.transmission.platform import Platform

_CHUNK = 4000
"""Poses at a time: their arrays fit into the cache of a processor."""


@result
class StaticPoints(Result):
    """Losses and limits of a machine at many poses; arrays (...,), SI.

    Attributes
    ----------
    power_in, power_out : (...,) float   From the supply, and to the user. [W]
    losses : name to (...,) float        From supply to user. [W]
    loss_of_legs : (..., n) float        Of wheel and guideway of each leg. [W]
    link_force : (..., n) float          [N]
    steering_tangent : (..., n) float    [-]
    torque : (...,) float                Of all legs on the cylinder. [N m]
    limit : (...,) int8                  The tightest limit where it is exceeded.
    margin : (...,) float                Allowance over demand of the tightest limit. [-]
    audit_residual : float               Largest residual of the power balance, relative to the largest power. [-]
    """

    power_in: Array
    power_out: Array
    losses: Mapping[str, Array]
    loss_of_legs: Array
    link_force: Array
    steering_tangent: Array
    torque: Array
    limit: Array
    margin: Array
    audit_residual: float

    @property
    def loss(self) -> Array:
        """Sum of all losses. [W]"""
        return sum(self.losses.values())  # type: ignore[return-value]

    @property
    def feasible(self) -> Array:
        """Where all limits are kept."""
        return np.asarray(self.limit) == Limit.OK


@result
class WorkspaceMap(Result):
    """Static points over a grid of positions.

    Attributes
    ----------
    x, y, z : (nx,), (ny,), (nz,) float   [m]
    rotation : (3,) float                 Of the platform, everywhere. [rad]
    points : StaticPoints                 Over (nx, ny, nz).
    """

    x: Array
    y: Array
    z: Array
    rotation: Array
    points: StaticPoints

    @property
    def share(self) -> float:
        """Share of the positions within all limits. [-]"""
        return float(np.mean(self.points.feasible))


def static_points(
    drive: LeggedDrive,
    platform: Platform,
    *,
    position: Array,
    rotation: Array = (0.0, 0.0, 0.0),
    wrench: Array,
    twist: Array | None = None,
    workers: int | None = None,
) -> StaticPoints:
    """Static points of a platform at many poses, in chunks on several threads.

    Parameters
    ----------
    drive : LeggedDrive
    platform : Platform           Of as many rods as there are legs.
    position : (..., 3) float     [m]
    rotation : (..., 3) float     Rotation vector. [rad]
    wrench : (..., 6) float       Force and moment of the platform on its load, at its origin. [N], [N m]
    twist : (..., 6) float        Velocity and angular velocity; None: all wheels locked. [m s^-1], [rad s^-1]
    workers : int                 Threads; all processors by default.

    Returns
    -------
    StaticPoints   Inputs broadcast.

    Raises
    ------
    ParameterError
        If a shape does not fit.
    AuditError
        If the powers of a point do not balance, which is a bug.
    """
    check_instance("drive", drive, LeggedDrive)
    check_instance("platform", platform, Platform)
    whole = isinstance(workers, int) and not isinstance(workers, bool) and workers >= 1
    require(workers is None or whole, "workers", repr(workers), "a whole number of threads, 1 or more")
    columns = {"position": (position, 3), "rotation": (rotation, 3), "wrench": (wrench, 6), "twist": (twist, 6)}
    known: dict[str, np.ndarray] = {}
    for name, (value, length) in columns.items():
        if value is None and name == "twist":
            continue
        known[name] = real_array(name, value)
        require(known[name].shape[-1:] == (length,), name, f"shape {known[name].shape}", f"of shape (..., {length})")
    shape = check_broadcast(**{name: value.shape[:-1] for name, value in known.items()})
    # What is the same at all poses stays one row.
    rows = {
        name: value.reshape(1, -1)
        if value.ndim == 1
        else np.broadcast_to(value, (*shape, value.shape[-1])).reshape(-1, value.shape[-1])
        for name, value in known.items()
    }
    count = int(np.prod(shape))
    require(count > 0, "position", "none", "one or more")

    def chunk(first: int) -> tuple[dict[str, Any], float]:
        part = {name: row if len(row) == 1 else row[first : first + _CHUNK] for name, row in rows.items()}
        found = platform.at(part.pop("position"), part.pop("rotation"))
        point = drive.operate(found, **part)
        off = audit(point.power_in, point.power_out, point.losses, "static points")
        return _kept(point, min(_CHUNK, count - first)), off

    pieces, residuals = zip(*in_order(chunk, range(0, count, _CHUNK), workers=workers), strict=True)
    joined = {name: _joined([piece[name] for piece in pieces], shape) for name in pieces[0]}
    return StaticPoints(**joined, audit_residual=max(residuals))


def workspace_map(
    drive: LeggedDrive,
    platform: Platform,
    *,
    x: Array,
    y: Array,
    z: Array,
    rotation: Array = (0.0, 0.0, 0.0),
    wrench: Array,
    twist: Array | None = None,
    workers: int | None = None,
) -> WorkspaceMap:
    """Losses and limits over a grid of positions of a platform.

    Parameters
    ----------
    x, y, z : (nx,), (ny,), (nz,) float   [m]
    rotation : (3,) float                 The same everywhere. [rad]
    wrench, twist : (6,) float            As in `static_points`, the same everywhere.

    Returns
    -------
    WorkspaceMap
    """
    axes = [np.atleast_1d(real_array(name, axis)) for name, axis in (("x", x), ("y", y), ("z", z))]
    for name, axis in zip("xyz", axes, strict=True):
        require(axis.ndim == 1 and len(axis) > 0, name, f"shape {axis.shape}", "a row of positions")
        require(bool(np.all(np.isfinite(axis))), name, "nan or inf", "finite", "m")
    for name, value, length in (("rotation", rotation, 3), ("wrench", wrench, 6), ("twist", twist, 6)):
        if value is not None or name != "twist":
            shape = np.shape(value)  # type: ignore[arg-type]
            require(shape == (length,), name, f"shape {shape}", f"{length} numbers")
    position = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    points = static_points(
        drive, platform, position=position, rotation=rotation, wrench=wrench, twist=twist, workers=workers
    )
    return WorkspaceMap(x=axes[0], y=axes[1], z=axes[2], rotation=np.asarray(rotation, dtype=float), points=points)


def _kept(point: MachinePoint, count: int) -> dict[str, Any]:
    """What `StaticPoints` keeps of a chunk, each value over all its poses."""
    limit, margin = binding(point.utilisation)
    legs = point.legs
    found = {
        "power_in": point.power_in,
        "power_out": point.power_out,
        "losses": dict(point.losses),
        "torque": legs.torque,
        "limit": limit,
        "margin": margin,
    }
    wide = {"loss_of_legs": legs.loss_of_legs, "link_force": legs.link_force, "steering_tangent": legs.steering_tangent}
    return {
        name: {key: np.broadcast_to(one, (count,)) for key, one in value.items()}
        if isinstance(value, dict)
        else np.broadcast_to(value, (count,))
        for name, value in found.items()
    } | {name: np.broadcast_to(value, (count, legs.link_force.shape[-1])) for name, value in wide.items()}


def _joined(pieces: list[Any], shape: tuple[int, ...]) -> Any:
    if isinstance(pieces[0], dict):
        return {name: _joined([piece[name] for piece in pieces], shape) for name in pieces[0]}
    whole = np.concatenate(pieces)
    return whole.reshape((*shape, *whole.shape[1:]))
