r"""A platform on rods, whose lower ends are carried by links along the axis of a common cylinder.

With the platform at position p and rotation Q, its joints at ``b_i`` on the platform and the guideways of the links at
``B_i``, all along z,

.. math:: c_i = p + Q b_i - B_i, \quad l_i = c_z - \sqrt{D^2 - c_x^2 - c_y^2}, \quad n_i = (c_i - l_i z)/D, \quad
    J_i = [n_i,\; (Q b_i) \times n_i]/n_{iz}, \quad \dot l = J \xi.

Source: merlet2006, chapters 2 and 3, for constant rods on linear actuators.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from annotated_types import Gt

from infinivar._core.array_namespace import Array, check_broadcast
from infinivar._core.arrays import real_array
from infinivar._core.bounds import FINITE
from infinivar._core.fields import check, check_number, component, quantity
from infinivar._core.frozen import frozen
from infinivar.errors import require
from infinivar.limits import Limit
from infinivar.transmission.configuration import Configuration, over_links

_STILL = 1e-8
"""Angle [rad] below which a rotation is linear in its vector to rounding."""


class PlatformMotion(NamedTuple):
    """Kinematics of a platform that moves; arrays over (..., n) rods."""

    jacobian: np.ndarray
    """J. (..., n, 6)"""
    link_position: np.ndarray
    """[m]"""
    reach: np.ndarray
    """Of the worst rod, over its length. (...,) [-]"""
    link_speed: np.ndarray
    """J xi. [m s^-1]"""
    bias: np.ndarray
    """Acceleration of the links without one of the twist, dJ/dt xi. [m s^-2]"""


_SINGULAR = 1e-6
"""Share of the volume spanned by the columns of a Jacobian below which a pose is singular; errors of rounding are near 1e-8."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Platform:
    """A rigid platform on n >= 6 rods of one length.

    Raises
    ------
    ParameterError
        If fewer than six rods are given, a position is not three finite numbers, or a range is empty.
    """

    base: Array = component("Positions B of the guideways, (n, 3) [m]")
    joints: Array = component("Positions b of the platform's joints in its own frame, (n, 3) [m]")
    rod_length: float = quantity("m", Gt(0), "Length D of the rods between their joints")
    stroke: tuple[float, float] | None = component(
        "Lowest and highest position of the links [m]; None: unlimited", default=None
    )
    provenance: str = component("Where the geometry is from", default="given")

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        check_number("rod_length", self.rod_length, "m", Gt(0))
        for name in ("base", "joints"):
            rows = real_array(name, getattr(self, name))
            fits = rows.ndim == 2 and rows.shape[-1:] == (3,) and len(rows) >= 6
            require(fits, name, f"shape {rows.shape}", "of shape (rods, 3), with six rods or more")
            require(bool(np.all(np.isfinite(rows))), name, "nan or inf", "finite")
            object.__setattr__(self, name, frozen(rows))
        require(
            len(self.base) == len(self.joints),
            "joints",
            f"{len(self.joints)} rows",
            f"one for each of {len(self.base)} guideways",
        )
        if self.stroke is not None:
            ends = real_array("stroke", self.stroke)
            rises = ends.shape == (2,) and bool(np.all(np.isfinite(ends)) and ends[0] < ends[1])
            require(rises, "stroke", f"{self.stroke} m", "a range from the lowest to the highest position")
            object.__setattr__(self, "stroke", (float(ends[0]), float(ends[1])))

    @classmethod
    def hexapod(
        cls,
        *,
        base_radius: float = 0.08,
        joint_radius: float = 0.04,
        base_spread: float = 0.15,
        joint_spread: float = 0.2,
        rod_length: float = 0.14,
        stroke: tuple[float, float] | None = (-0.05, 0.05),
    ) -> Platform:
        """Six rods in three pairs; every default is assumed.

        Parameters
        ----------
        base_radius, joint_radius : float   Of the circles of guideways and of platform joints. [m]
        base_spread, joint_spread : float   Half the angle between the guideways of a pair, and between the joints of two rods
            that meet. [rad]
        rod_length, stroke                  As in the class. [m]

        Returns
        -------
        Platform   Its provenance is "assumed": faulring2006 prints no geometry of its platform.
        """
        for name, radius in (("base_radius", base_radius), ("joint_radius", joint_radius)):
            check_number(name, radius, "m", Gt(0))
        for name, spread in (("base_spread", base_spread), ("joint_spread", joint_spread)):
            check_number(name, spread, "rad", FINITE)
        turn = 2.0 * np.pi / 3.0 * np.arange(3)
        low = np.stack([turn - base_spread, turn + base_spread], axis=-1).ravel()
        # Rods of neighbouring pairs meet at the platform, so that the joints are turned by a sixth of a revolution.
        high = np.stack([turn - np.pi / 3.0 + joint_spread, turn + np.pi / 3.0 - joint_spread], axis=-1).ravel()
        return cls(
            base=_circle(base_radius, low),
            joints=_circle(joint_radius, high),
            rod_length=rod_length,
            stroke=stroke,
            provenance="assumed",
        )

    @property
    def home(self) -> float:
        """Height of an unrotated platform over the links' position 0, on the axis, where all links are at 0 on average. [m]"""
        flat = self.joints - self.base
        room = self.rod_length**2 - flat[:, 0] ** 2 - flat[:, 1] ** 2
        require(
            bool(np.all(room > 0)),
            "rod_length",
            f"{self.rod_length:g} m",
            f"> {float(np.max(np.hypot(flat[:, 0], flat[:, 1]))):.4g} m to reach the platform on the axis",
        )
        return float(np.mean(np.sqrt(room) - flat[:, 2]))

    def at(self, position: Array, rotation: Array = (0.0, 0.0, 0.0)) -> Configuration:
        """The machine at poses of the platform.

        Parameters
        ----------
        position : (..., 3) float   p, of the platform's origin. [m]
        rotation : (..., 3) float   Rotation vector: axis times angle. [rad]

        Returns
        -------
        Configuration   For twists of the velocity of the platform's origin and its angular velocity, in fixed axes (m/s,
            rad/s), and wrenches of force and moment about that origin. Where a rod does not reach, the jacobian is nan and
            the demand of `Limit.LINKAGE` is 1 or more; beyond the stroke that of `Limit.TRAVEL`.

        Raises
        ------
        ParameterError
            If a position or rotation is not three finite numbers, or they do not broadcast.
        """
        p, turn = _three(position, "position"), _three(rotation, "rotation")
        check_broadcast(position=p.shape[:-1], rotation=turn.shape[:-1])
        arm = rotated(turn, self.joints)
        jacobian, link, reach = self._reach(p, arm)
        jacobian[reach >= 1.0] = np.nan
        utilisation = {Limit.LINKAGE: np.where(reach >= 1.0, np.maximum(reach, 1.0 + 1e-12), reach)}
        if self.stroke is not None:
            utilisation[Limit.TRAVEL] = self.travel_demand(link)
        return Configuration(jacobian=jacobian, link_position=link, utilisation=utilisation)

    def singular(self, jacobian: np.ndarray) -> np.ndarray:
        """Whether the rods leave a motion of the platform free, from their Jacobian (..., n, 6); False where it is nan. (...,)

        By the volume that the columns span, over that of columns at right angles, which is 1 at best; rotations count as the
        velocity of a joint.
        """
        joint = np.sqrt(np.mean(np.sum(self.joints * self.joints, axis=-1)))
        reaches = np.all(np.isfinite(jacobian), axis=(-2, -1))
        columns = np.nan_to_num(jacobian) / np.array([1.0, 1.0, 1.0, joint, joint, joint])
        spanned = np.linalg.det(np.matmul(np.swapaxes(columns, -1, -2), columns))
        most = np.prod(np.sum(columns * columns, axis=-2), axis=-1)
        return reaches & ~(spanned > _SINGULAR**2 * most)

    def travel_demand(self, link_position: np.ndarray) -> np.ndarray:
        """Distance of the worst link from the middle of the stroke, over half the stroke; 0 without a stroke. (...,) [-]"""
        if self.stroke is None:
            return np.zeros(link_position.shape[:-1])
        low, high = self.stroke
        off = np.abs(link_position - 0.5 * (low + high)) / (0.5 * (high - low))
        return over_links(np.maximum, off)

    def _reach(
        self, p: np.ndarray, arm: tuple[np.ndarray, np.ndarray, np.ndarray]
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Jacobian, positions of the links, and reach over the length of the rods of the worst rod; arm is Q b."""
        x, y, z = (p[..., axis, None] + arm[axis] - self.base[:, axis] for axis in range(3))
        sideways = x * x + y * y
        square = self.rod_length**2
        reach = np.sqrt(over_links(np.maximum, sideways)) / self.rod_length
        rise = np.sqrt(np.where(sideways < square, square - sideways, np.nan))
        # n/n_z, so that the last component is 1.
        over = 1.0 / rise
        nx, ny = x * over, y * over
        jacobian = np.empty_like(rise, shape=(*rise.shape, 6))
        jacobian[..., 0], jacobian[..., 1], jacobian[..., 2] = nx, ny, 1.0
        jacobian[..., 3] = arm[1] - arm[2] * ny
        jacobian[..., 4] = arm[2] * nx - arm[0]
        jacobian[..., 5] = arm[0] * ny - arm[1] * nx
        return jacobian, z - rise, reach

    def moving(self, position: np.ndarray, turn: np.ndarray, twist: np.ndarray) -> PlatformMotion:
        r"""The machine at poses that move, for motion in time; finite arguments are not checked.

        .. math:: \ddot l_i = J_i\dot\xi + \frac{\left(\omega\times(\omega\times Q b_i)\right)\cdot n_i}{n_{iz}}
            + \frac{|\dot c_i - \dot l_i z|^2}{D\,n_{iz}}

        Parameters
        ----------
        position : (..., 3) float    [m]
        turn : (..., 3, 3) float     Rotation matrix.
        twist : (..., 6) float       As in `at`. [m s^-1], [rad s^-1]

        Returns
        -------
        PlatformMotion   nan where a rod does not reach.

        Source: second derivative of ``|c_i - l_i z| = D``.
        """
        turned = np.matmul(turn, np.swapaxes(self.joints, 0, 1))
        arm = turned[..., 0, :], turned[..., 1, :], turned[..., 2, :]
        jacobian, link, reach = self._reach(position, arm)
        speed = np.matmul(jacobian, twist[..., None])[..., 0]
        wx, wy, wz = (twist[..., axis, None] for axis in (3, 4, 5))
        ax, ay, az = arm
        # omega x a, then centripetal: omega (omega a) - a omega^2.
        vx, vy, vz = wy * az - wz * ay, wz * ax - wx * az, wx * ay - wy * ax
        along, square = wx * ax + wy * ay + wz * az, wx * wx + wy * wy + wz * wz
        nx, ny = jacobian[..., 0], jacobian[..., 1]
        bias = (wx * along - ax * square) * nx + (wy * along - ay * square) * ny + wz * along - az * square
        rise = self.rod_length / np.sqrt(1.0 + nx * nx + ny * ny)
        dx, dy, dz = (
            twist[..., axis, None] + part - (speed if axis == 2 else 0.0) for axis, part in enumerate((vx, vy, vz))
        )
        return PlatformMotion(jacobian, link, reach, speed, bias + (dx * dx + dy * dy + dz * dz) / rise)


def rotated(rotation: np.ndarray, vectors: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Components, (..., n) each, of vectors (n, 3) turned by rotation vectors (..., 3)."""
    turned = np.matmul(rotation_matrix(rotation), np.asarray(vectors, dtype=float).T)
    return turned[..., 0, :], turned[..., 1, :], turned[..., 2, :]


def rotation_matrix(rotation: np.ndarray) -> np.ndarray:
    """Rotation by a vector, axis times angle. (..., 3) to (..., 3, 3). Source: Rodrigues' formula."""
    square = rotation[..., 0] ** 2 + rotation[..., 1] ** 2 + rotation[..., 2] ** 2
    angle = np.sqrt(square)
    turns = angle > _STILL
    safe = np.where(turns, angle, 1.0)
    one = np.where(turns, np.sin(angle) / safe, 1.0)
    # The half angle: 1 - cos would cancel.
    two = np.where(turns, 2.0 * (np.sin(0.5 * angle) / safe) ** 2, 0.5)
    x, y, z = (rotation[..., axis] for axis in range(3))
    found = two[..., None, None] * (rotation[..., :, None] * rotation[..., None, :])
    across = one[..., None] * rotation
    found[..., 0, 0], found[..., 1, 1], found[..., 2, 2] = (
        1.0 - two * (y * y + z * z),
        1.0 - two * (x * x + z * z),
        1.0 - two * (x * x + y * y),
    )
    found[..., (1, 2, 0), (2, 0, 1)] -= across
    found[..., (2, 0, 1), (1, 2, 0)] += across
    return found


NEXT, AFTER = [1, 2, 0], [2, 0, 1]
"""Axes after each axis, and after those."""


def crossed(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Cross product, also of recorded numbers. (..., 3)"""
    return one[..., NEXT] * other[..., AFTER] - one[..., AFTER] * other[..., NEXT]


def rotation_vector(turn: np.ndarray) -> np.ndarray:
    """Vector of a rotation, axis times angle, not longer than pi. (..., 3, 3) to (..., 3). Source: the rotation's quaternion."""
    diagonal = np.diagonal(turn, axis1=-2, axis2=-1)
    trace = diagonal.sum(axis=-1, keepdims=True)
    half = 0.5 * (turn[..., AFTER, NEXT] - turn[..., NEXT, AFTER])  # axis times sine
    # Four times the products of the quaternion's components; the row of the largest one is exact.
    square = 1.0 + np.concatenate([trace, 2.0 * diagonal - trace], axis=-1)
    mixed = turn + np.swapaxes(turn, -1, -2)
    products = np.zeros((*turn.shape[:-2], 4, 4))
    products[..., 0, 1:] = products[..., 1:, 0] = 2.0 * half
    products[..., 1:, 1:] = mixed
    products[..., range(4), range(4)] = square
    largest = np.argmax(square, axis=-1)[..., None, None]
    row = np.take_along_axis(products, largest, axis=-2)[..., 0, :]
    row = np.where(row[..., :1] < 0.0, -row, row)
    length = np.sqrt(np.sum(row[..., 1:] ** 2, axis=-1, keepdims=True))
    angle = 2.0 * np.arctan2(length, row[..., :1])
    turns = length > 0.0
    return row[..., 1:] * np.where(turns, angle / np.where(turns, length, 1.0), 0.0)


def _three(value: Array, name: str) -> np.ndarray:
    given = real_array(name, value)
    require(given.shape[-1:] == (3,), name, f"shape {given.shape}", "of shape (..., 3)")
    require(bool(np.all(np.isfinite(given))), name, "nan or inf", "finite")
    return given


def _circle(radius: float, angles: np.ndarray) -> np.ndarray:
    return np.stack([radius * np.cos(angles), radius * np.sin(angles), 0.0 * angles], axis=-1)
