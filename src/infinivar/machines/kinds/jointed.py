"""What arms in a plane and in space share: joints moved side by side, from the pose of the end point to their torques."""

from __future__ import annotations

from typing import Any

import numpy as np

from infinivar._core.array_namespace import Array
from infinivar._core.fields import given
from infinivar.drivetrain.drive import axis_of
from infinivar.errors import ParameterError
from infinivar.limits import Limit
from infinivar.machines.course import MachineCourse
from infinivar.machines.kinds.linked import Linked
from infinivar.machines.links import Carried, lifting, moved
from infinivar.machines.machine import TaskPoint, rows
from infinivar.transmission.configuration import Configuration


def check_payload(machine: Any) -> None:
    """Raise `ParameterError` if what an arm carries has a centre or a moment of inertia, but no mass."""
    for name in ("payload_centre", "payload_inertia"):
        if getattr(machine, name) not in (None, 0.0) and not machine.payload_mass:
            raise ParameterError(f"payload_mass is missing or 0 kg: {name} is stated, which is of a mass > 0 kg")


class Jointed(Linked):
    """An arm; a subclass has its joint angles at poses, the Jacobian of its end point, and its masses."""

    __slots__ = ()

    pulley_radius: float | None
    gravity: tuple[float, ...] | None

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Of the end point."""
        raise NotImplementedError

    @property
    def home(self) -> tuple[float, ...]:
        """Pose of the end point at home."""
        raise NotImplementedError

    @property
    def links(self) -> int:
        """Number of joints."""
        raise NotImplementedError

    def angles(self, pose: Array) -> np.ndarray:
        """Joint angles at which the end point is at poses (..., d); nan beyond reach. (..., n) [rad]"""
        raise NotImplementedError

    def _solved(self, pose: np.ndarray) -> tuple[np.ndarray, dict[Limit, np.ndarray]]:
        """Joint angles, nan beyond reach, and the demands on the geometry."""
        raise NotImplementedError

    def _jacobian(self, angles: np.ndarray) -> np.ndarray:
        """Of the end point in `coordinates`. (..., n, n)"""
        raise NotImplementedError

    def _members(self) -> Any:
        """Masses of the arm with its payload, an `infinivar.machines.linkage.Load` with a method ``inertia``."""
        raise NotImplementedError

    @property
    def link_lever(self) -> float:
        """Radius of the pulley of a joint; of one that a drive turns directly any. [m]"""
        return given(self.pulley_radius, 1.0)

    def _check_pulley(self) -> None:
        """Raise ParameterError if links or belts move the joints over pulleys of no radius."""
        over = self.leg is not None or (self.separate is not None and not axis_of(self.separate).rotary)
        if over and self.pulley_radius is None:
            raise ParameterError("pulley_radius is missing: a leg or a linear drive moves each joint over a pulley")

    def link_positions(self, pose: np.ndarray) -> np.ndarray:
        """See `Linked.link_positions`: along the rims of the pulleys."""
        return self.link_lever * np.unwrap(self._solved(pose)[0], axis=0)

    def part_speeds(self, pose: np.ndarray, twist: np.ndarray) -> np.ndarray:
        """Of the links, or of belts at the joints' pulleys; nan beyond reach. (..., n) [m s^-1]"""
        return self.link_lever * self._placed(pose, twist, 0.0 * twist)[1]

    def perform(self, *, pose: Array, twist: Array, wrench: Array) -> TaskPoint:
        """As `infinivar.machines.machine.Machine.perform`; beyond reach all is nan."""
        pose, twist, wrench = rows(self, pose, twist, wrench)
        angles, rates, torques, configuration = self._placed(pose, twist, wrench)
        weight = None
        if self.gravity is not None:
            n = self.links
            weight = self._members().inertia(angles.reshape(-1, n), np.zeros((angles.size // n, n))).bias
            weight = weight.reshape(angles.shape)
        point = moved(
            configuration,
            self.legs,
            self.separate,
            rates,
            torques if weight is None else torques + weight,
            lever=self.link_lever,
            words="joint",
            units=("N m", "rad/s"),
        )
        return point if weight is None else lifting(point, weight, rates)

    def carried(self, course: MachineCourse) -> Carried:
        """What the joints carry along a course, with weight and what accelerates the members; beyond reach all is nan.

        Source: `infinivar.machines.bodies`.
        """
        angles, rates, torques, configuration = self._placed(course.pose, course.twist, course.wrench)
        load = torques[1:4]
        if not self._massless:
            n = self.links
            members = self._members().inertia(angles[1:4].reshape(-1, n), rates[1:4].reshape(-1, n))
            load = load + members.forces(course.rate(rates))
        return Carried(course=course, configuration=configuration, twist=rates, load=load)

    def along(self, carried: Carried) -> TaskPoint:
        """See `infinivar.machines.links`."""
        return self._along(carried, self.link_lever, "joint", ("N m", "rad/s"))

    def _placed(
        self, pose: np.ndarray, twist: np.ndarray, wrench: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, Configuration]:
        """Joint angles, rates and torques, and the links over the pulleys; nan beyond reach."""
        angles, utilisation = self._solved(pose)
        n, within = self.links, np.asarray(np.isfinite(angles).all(axis=-1))
        safe = np.where(within[..., None], angles, np.linspace(0.3, 0.6, n))
        jacobian = np.where(within[..., None, None], self._jacobian(safe), np.eye(n))
        rates = np.linalg.solve(jacobian, twist[..., None])[..., 0]
        torques = np.matmul(np.swapaxes(jacobian, -1, -2), wrench[..., None])[..., 0]
        rim = np.diag(np.full(n, self.link_lever))
        configuration = Configuration(jacobian=np.where(within[..., None, None], rim, np.nan), utilisation=utilisation)
        return safe, rates, torques, configuration

    def followed(self, pose: Array, wrench: Array) -> tuple[np.ndarray, np.ndarray]:
        """Joint angles (..., n), without turns between neighbours, and joint torques of poses and wrenches (..., n) of the end
        point; nan beyond reach."""
        angles = self.angles(pose)
        if angles.ndim > 1:
            angles = np.unwrap(angles, axis=0)
        across = np.swapaxes(self._jacobian(np.nan_to_num(angles)), -1, -2)
        torques = np.matmul(across, np.asarray(wrench, dtype=float)[..., None])[..., 0]
        return angles, torques + 0.0 * angles
