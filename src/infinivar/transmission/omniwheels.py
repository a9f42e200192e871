r"""A platform on omniwheels: wheels with free rollers at their rims, which stand on a plane.

A roller carries no force across its axle, so the hub of a wheel is free to move across it. With the velocity V of the hub, the
unit vector e along the heading of the wheel, the angle :math:`\gamma` from e to the axle of the roller on the ground, and the
unit vectors g along this axle and f at a right angle to it,

.. math:: V = v\,e + s\,f, \qquad v = \frac{g \cdot V}{\cos\gamma}, \qquad s = f \cdot V + v \sin\gamma

where v is the speed of the wheel's rim and s that of the roller's. The ground pushes the wheel along g: a force F at its rim,
from its motor, is :math:`F/\cos\gamma` there, and :math:`F v = (F/\cos\gamma)\, g \cdot V`. A roller resists with
:math:`c P\,\mathrm{sgn}(s)` and the wheel itself with :math:`c_r P\,\mathrm{sgn}(v)`.

Source: siegwart2004, Eq 3.19 for v, and Eq 3.20 for s, whose wheel term has the sign that leaves the rollers of a wheel at rest
when it rolls straight ahead; as printed they would turn; muir1987 for mecanum wheels. Principle of virtual power for the forces.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from infinivar._core.array_namespace import Array
from infinivar._core.arrays import real_array
from infinivar._core.fields import check, component
from infinivar.errors import ParameterError, require
from infinivar.transmission.configuration import Configuration

_STEEPEST = np.radians(80.0)
"""Largest angle of a roller, beyond which its wheel hardly drives."""

_SINGULAR = 1e-9
"""Least singular value over the largest, of rims by motions, below which wheels do not determine the motion. [-]"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Omniwheels:
    """Three omniwheels or more under a rigid body.

    Raises
    ------
    ParameterError
        If the numbers of values differ, an angle is out of range, or a motion of the body turns no wheel: all axles of rollers
        parallel, or all through one point.
    """

    positions: Sequence[Sequence[float]] = component("Points of the wheels, x and y in axes of the body, in m")
    headings: Sequence[float] = component("Angles from x of the body to the rolling directions of the wheels, in rad")
    roller_angles: Sequence[float] = component(
        "Angles from the rolling direction to the axle of the roller on the ground, in rad: 0 for omniwheels, +-pi/4 for "
        "mecanum wheels"
    )
    rim_rows: np.ndarray = field(init=False, repr=False, compare=False, default=None)  # type: ignore[assignment]
    """Rim speeds by twist in axes of the body. (n, 3)"""
    roller_rows: np.ndarray = field(init=False, repr=False, compare=False, default=None)  # type: ignore[assignment]
    """Speeds of the rollers' rims by twist in axes of the body. (n, 3)"""

    def __post_init__(self) -> None:
        """Validate the fields and compute what does not depend on the pose."""
        check(self)
        points = real_array("positions", self.positions)
        fits = points.ndim == 2 and points.shape[1:] == (2,) and len(points) >= 3
        said = f"{len(points)}" if points.ndim == 2 else f"shape {points.shape}"
        require(fits, "positions", said, "one row of x and y for each of three wheels or more")
        angles = {}
        for name in ("headings", "roller_angles"):
            values = real_array(name, getattr(self, name))
            require(
                values.shape == (len(points),),
                name,
                f"{values.size}",
                f"one value for each of {len(points)} wheels",
            )
            angles[name] = values
        for name, values in (("positions", points), *angles.items()):
            require(bool(np.all(np.isfinite(values))), name, "nan or infinity", "finite")
        heading, roller = angles.values()
        steep = np.abs(roller) > _STEEPEST
        require(not np.any(steep), "roller_angles", f"{roller[steep][:1]}", f"within +-{_STEEPEST:.3g}", "rad")
        ahead = np.stack([np.cos(heading + roller), np.sin(heading + roller)], axis=-1)
        across = np.stack([-ahead[:, 1], ahead[:, 0]], axis=-1)
        rims = _rows(points, ahead) / np.cos(roller)[:, None]
        object.__setattr__(self, "rim_rows", rims)
        object.__setattr__(self, "roller_rows", _rows(points, across) + np.sin(roller)[:, None] * rims)
        values = np.linalg.svd(rims * [1.0, 1.0, 1.0 / self.radius], compute_uv=False)
        if values[-1] < _SINGULAR * values[0]:
            raise ParameterError(
                "headings leave a motion that turns no wheel: the axles of the rollers must not all be parallel, nor all "
                "pass through one point"
            )

    @property
    def radius(self) -> float:
        """Root mean square distance of the wheels from the reference point. [m]"""
        points = np.asarray(self.positions, dtype=float)
        return float(np.sqrt(np.mean(np.sum(points * points, axis=1)))) or 1.0

    def at(self, angle: Array, ratio: float = 1.0) -> Configuration:
        """The kinematic map from a twist in fixed axes to the wheels, with the body turned by an angle.

        Parameters
        ----------
        angle : (...,) float   From x of the plane to x of the body. [rad]
        ratio : float          Speed of a link over that of the rim it moves: 1 for rims.

        Returns
        -------
        Configuration   With the coordinates x, y and angle.
        """
        return Configuration(jacobian=ratio * in_fixed_axes(self.rim_rows, angle))


def in_fixed_axes(rows: np.ndarray, angle: Array) -> np.ndarray:
    """Rows by a twist in fixed axes, of rows (n, 3) by one in axes of a body turned by an angle. (..., n, 3)"""
    cosine, sine = np.cos(angle)[..., None], np.sin(angle)[..., None]
    x, y = rows[:, 0], rows[:, 1]
    return np.stack([cosine * x - sine * y, sine * x + cosine * y, rows[:, 2] + 0.0 * cosine], axis=-1)


def _rows(points: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Components along unit vectors (n, 2) of the velocities of points (n, 2), by twist. (n, 3)"""
    turning = points[:, 0] * along[:, 1] - points[:, 1] * along[:, 0]
    return np.concatenate([along, turning[:, None]], axis=-1)
