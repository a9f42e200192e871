"""A sphere between rollers: map over steering angle and load, and efficiency by ratio."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from infinivar._core.array_namespace import finite_floats
from infinivar._core.arrays import real_array, shown
from infinivar._core.bounds import FINITE
from infinivar._core.described import reported
from infinivar._core.fields import check_instance, check_number
from infinivar._core.result import Result, result
from infinivar.errors import ParameterError, require
from infinivar.limits import Limit, codes
from infinivar.transmission.spherical import SphericalIVT, SphericalPoint

_GRID = ("steering_angle", "load")


@result
class SphereMap(Result):
    """Steady operation over steering angle and load at one speed of the sphere, as returned by `sphere_map`.

    Attributes
    ----------
    title : str                    Layout of the rollers.
    sphere_speed : float           Omega without creep. [rad s^-1]
    slip_force : float             mu P of a drive roller. [N]
    steering_angle : (n,)          gamma. [rad]
    load : (m,)                    kappa, scale of the forces of the drive rollers. [N]
    ratio : (n,)                   w_1/w_2 without creep; infinite where shaft 2 is locked. [-]
    input_speed, output_speed : (n, m)     w_1 and w_2. [rad s^-1]
    input_torque, output_torque : (n, m)   tau_1 applied to shaft 1, T_2 applied by shaft 2. [N m]
    power_in, power_out : (n, m)   Of shaft 1 and shaft 2, negative where power flows back. [W]
    efficiency : (n, m)            nan beyond limits, and where both shafts feed the losses. [-]
    losses : mapping of (n, m)     By name. [W]
    limit : (n, m)                 `Limit`; those that the preload alone exceeds are not counted.
    """

    title: str
    sphere_speed: float
    slip_force: float
    steering_angle: np.ndarray = reported("rad", "steering angle", _GRID[:1])
    load: np.ndarray = reported("N", "scale of the forces of the drive rollers", _GRID[1:])
    ratio: np.ndarray = reported("1", "speed ratio without creep", _GRID[:1])
    input_speed: np.ndarray = reported("rad s-1", "speed of shaft 1", _GRID)
    output_speed: np.ndarray = reported("rad s-1", "speed of shaft 2", _GRID)
    input_torque: np.ndarray = reported("N m", "torque applied to shaft 1", _GRID)
    output_torque: np.ndarray = reported("N m", "torque that shaft 2 applies to its load", _GRID)
    power_in: np.ndarray = reported("W", "power into shaft 1", _GRID)
    power_out: np.ndarray = reported("W", "power out of shaft 2", _GRID)
    efficiency: np.ndarray = reported("1", "useful power over power spent", _GRID)
    losses: Mapping[str, np.ndarray] = reported("W", "power lost in {}", _GRID, variable="loss_{}")
    limit: np.ndarray = reported("1", "limit exceeded", _GRID, notes=codes)

    @property
    def loss(self) -> np.ndarray:
        """All losses. (n, m) [W]"""
        return sum(self.losses.values())  # type: ignore[return-value]


def sphere_map(ivt: SphericalIVT, steering_angle: Any, load: Any, *, sphere_speed: float) -> SphereMap:
    """Steady operation over steering angle and load at one speed of the sphere.

    Parameters
    ----------
    ivt : SphericalIVT
    steering_angle : (n,) sequence   gamma. [rad]
    load : (m,) sequence             kappa, see `SphericalIVT.operate`. [N]
    sphere_speed : float             Omega without creep, not 0. [rad s^-1]

    Returns
    -------
    SphereMap

    Raises
    ------
    ParameterError
        If an argument is not a row of finite numbers, the sphere stands still, or it is another transmission.
    """
    check_instance("ivt", ivt, SphericalIVT)
    angles, loads = _row("steering_angle", steering_angle), _row("load", load)
    check_number("sphere_speed", sphere_speed, "rad/s", FINITE)
    require(sphere_speed != 0.0, "sphere_speed", sphere_speed, "finite and not 0", "rad/s")
    point = ivt.operate(steering_angle=angles[:, None], sphere_speed=sphere_speed, load=loads)
    first, second = ivt.ideal_speeds(angles)
    locked = np.abs(second) < 1e-12 * np.abs(first)
    ratio = np.where(locked, np.inf, first / np.where(locked, 1.0, second))
    slips = point.utilisation[Limit.SLIP] > 1.0
    lost = np.where(slips, np.nan, 0.0)
    return SphereMap(
        title=ivt.layout if _shipped(ivt) else "own rollers",
        sphere_speed=float(sphere_speed),
        slip_force=float(ivt.drive.slip_force),
        steering_angle=angles,
        load=loads,
        ratio=ratio,
        input_speed=point.input_speed + lost,
        output_speed=point.output_speed + lost,
        input_torque=point.input_torque + lost,
        output_torque=point.output_torque + lost,
        power_in=point.power_in + lost,
        power_out=point.power_out + lost,
        efficiency=efficiency_of(point),
        losses={name: one + lost for name, one in point.losses.items()},
        limit=np.where(slips, int(Limit.SLIP), int(Limit.OK)).astype(np.int8),
    )


def _shipped(ivt: SphericalIVT) -> bool:
    from infinivar.transmission.sphere_layout import LAYOUTS

    return tuple(ivt.rollers) == LAYOUTS[ivt.layout]  # type: ignore[arg-type]


def efficiency_of(point: SphericalPoint) -> np.ndarray:
    """Efficiency where no roller slips, else nan. (...,) [-]"""
    from infinivar.power import efficiency

    slips = point.utilisation[Limit.SLIP] > 1.0
    return np.where(slips, np.nan, efficiency(point.power_in, point.power_out))


def efficiency_by_ratio(ivt: SphericalIVT, ratio: Any, share: float, *, sphere_speed: float = 1.0) -> np.ndarray:
    """Efficiency over the speed ratio at a constant output torque, as gears are shown.

    Parameters
    ----------
    ivt : SphericalIVT
    ratio : (...,) float    w_1/w_2 without creep; negative for the other sense. [-]
    share : float           Force of the output drive roller over mu P. [-]
    sphere_speed : float    Matters only for bearings and friction limits that depend on speed. [rad s^-1]

    Returns
    -------
    (...,) float   nan where a roller slips. [-]
    """
    (known,) = finite_floats(np, ratio=ratio)
    check_number("share", share, "1", FINITE)
    one, two = ivt.ideal_speeds(np.array([0.5 * math.pi, 0.0]))
    # tan(gamma) over the ratio is that of the ideal speeds at both ends, for drive rollers a quarter turn apart.
    angle = np.arctan(known * (two[1] / one[0]))
    sine = np.sin(angle)
    load = share * ivt.drive.slip_force / np.where(sine == 0, np.nan, np.abs(sine))
    point = ivt.operate(steering_angle=angle, sphere_speed=sphere_speed, load=load * np.sign(sine))
    return efficiency_of(point)


def _row(name: str, values: Any) -> np.ndarray:
    row = np.atleast_1d(real_array(name, values))
    if row.ndim != 1 or not row.size or not np.all(np.isfinite(row)):
        raise ParameterError(f"{name} must be a row of finite numbers, got {shown(values)}")
    return row
