r"""Planar arms of n joints: from one common shaft, each joint by a wheel of its own, or joint to joint through n - 1 wheels.

Parallel arm: a leg drives each joint by a pulley of radius rho, ``rho qdot_i = ldot_i = -R omega tan(phi_i)``. Serial arm:
wheel i stands between joints i and i + 1, on pulleys or drums of one radius, so that ``qdot_(i+1) = -tan(phi_i) qdot_i`` and
one motor, or the user, moves all joints. A wrench F at the end point is the joint torques ``J^T F``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from annotated_types import Gt

from infinivar._core.array_namespace import Array, check_broadcast, namespace
from infinivar._core.arrays import real_array
from infinivar._core.fields import check, check_instance, quantities
from infinivar.errors import require
from infinivar.transmission.configuration import Configuration
from infinivar.transmission.mechanism import Mechanism
from infinivar.transmission.rolling_contact import RollingContact


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanarArm:
    """An arm of n joints in a plane; each angle is relative to the member before.

    Raises
    ------
    ParameterError
        If no length is given, or one is not > 0.
    """

    lengths: Sequence[float] = quantities("m", Gt(0), "Lengths of the members, from the base")

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        require(len(self.lengths) > 0, "lengths", "none", "one length or more")

    @property
    def joints(self) -> int:
        """Number of joints, n."""
        return len(self.lengths)

    def end_point(self, angles: Array) -> np.ndarray:
        """Position of the end point, and the direction of the last member.

        Parameters
        ----------
        angles : (..., n) float   Joint angles q. [rad]

        Returns
        -------
        (..., 3) float   x, y [m] and direction [rad].
        """
        direction = np.cumsum(self._angles(angles), axis=-1)
        lengths = np.asarray(self.lengths)
        return np.stack(
            [
                np.sum(lengths * np.cos(direction), axis=-1),
                np.sum(lengths * np.sin(direction), axis=-1),
                direction[..., -1],
            ],
            axis=-1,
        )

    def jacobian(self, angles: Array) -> np.ndarray:
        """Derivatives of `end_point` by the joint angles.

        Parameters
        ----------
        angles : (..., n) float   [rad]

        Returns
        -------
        (..., 3, n) float   Two rows in m, one of ones. Its transpose turns forces and a moment at the end point into torques.
        """
        direction = np.cumsum(self._angles(angles), axis=-1)
        lengths = np.asarray(self.lengths)

        def outward(values: np.ndarray) -> np.ndarray:
            """Sums from each joint to the end."""
            return np.flip(np.cumsum(np.flip(values, -1), axis=-1), -1)

        x, y = outward(lengths * np.cos(direction)), outward(lengths * np.sin(direction))
        return np.stack([-y, x, np.ones_like(x)], axis=-2)

    def joint_torques(self, angles: Array, force: Array) -> np.ndarray:
        """Torques ``J^T F`` on the joints by forces and a moment F at the end point.

        Parameters
        ----------
        angles : (..., n) float   [rad]
        force : (..., 3) float    Along x and y, and the moment. [N], [N m]

        Returns
        -------
        (..., n) float   [N m]
        """
        jacobian, given = self.jacobian(angles), real_array("force", force)
        require(given.shape[-1:] == (3,), "force", f"shape {given.shape}", "of shape (..., 3)")
        check_broadcast(angles=jacobian.shape[:-2], force=given.shape[:-1])
        return np.matmul(np.swapaxes(jacobian, -1, -2), given[..., None])[..., 0]

    def parallel(self, pulley_radius: Array) -> Configuration:
        """Joints driven by legs on a common cylinder, over pulleys.

        Parameters
        ----------
        pulley_radius : float or (n,) float   rho, > 0; cables without loss. [m]

        Returns
        -------
        Configuration   Twists are joint rates, wrenches are torques on the joints: see `joint_torques`.
        """
        return Configuration(jacobian=np.diag(self._radii(pulley_radius, self.joints, "pulley_radius")))

    def serial(self, wheel: RollingContact, drum_radius: Array) -> Mechanism:
        """Joints coupled by n - 1 wheels, one between each two.

        Parameters
        ----------
        wheel : RollingContact                    On a plane: cables or belts carry both motions to it.
        drum_radius : float or (n - 1,) float     rho of each wheel's two drums, > 0. [m]

        Returns
        -------
        Mechanism   With coordinates "q1" to "q<n>". Wheel i, headed at ``pi/2 - phi_i``, moves joint i + 1 at
            ``-tan(phi_i)`` times the rate of joint i.

        Raises
        ------
        ParameterError
            If the arm has one joint only, or the wheel is not one on a plane.
        """
        check_instance("wheel", wheel, RollingContact)
        require(wheel.surface == "plane", "wheel.surface", repr(wheel.surface), "'plane'")
        n = self.joints
        require(n >= 2, "lengths", f"{n} member", "two members or more, with a wheel between them")
        radii = self._radii(drum_radius, n - 1, "drum_radius")
        carriers, surface = np.zeros((n - 1, 2, n)), np.zeros((n - 1, n))
        for place, radius in enumerate(radii):
            carriers[place, 0, place + 1] = radius
            carriers[place, 1, place] = -radius
            surface[place, place] = radius
        return Mechanism(
            contacts=wheel, jacobian=carriers, surface=surface, coordinates=tuple(f"q{place + 1}" for place in range(n))
        )

    def _angles(self, angles: Array) -> Any:
        recorded = hasattr(angles, "__array_namespace__") and namespace(angles) is not np
        given: Any = angles if recorded else real_array("angles", angles)
        require(given.shape[-1:] == (self.joints,), "angles", f"shape {given.shape}", f"of shape (..., {self.joints})")
        require(recorded or bool(np.all(np.isfinite(given))), "angles", "nan or inf", "finite", "rad")
        return given

    @staticmethod
    def _radii(radius: Array, count: int, name: str) -> np.ndarray:
        given = real_array(name, radius)
        require(given.shape in ((), (count,)), name, f"shape {given.shape}", f"one number, or {count} of them")
        require(bool(np.all(given > 0) and np.all(np.isfinite(given))), name, given, "> 0", "m")
        return np.broadcast_to(given, (count,))
