"""A platform on rods as the load of links: its kinematics, its inertia with that of the rods, and weights."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from infinivar.limits import Limit
from infinivar.machines.bodies import (
    Moved,
    angular_velocity,
    point_masses,
    rigid_body,
    rotation_between,
    rotation_rate,
)
from infinivar.machines.hand import Grip, PointGrip
from infinivar.machines.linkage import LinkMotion, Load
from infinivar.machines.pictures.rods import OnRods
from infinivar.machines.pictures.slides import Drum
from infinivar.motion.vectors import ROTATIONS, TRANSLATIONS
from infinivar.transmission.platform import Platform, PlatformMotion, crossed, rotation_matrix


@dataclass(frozen=True, slots=True, kw_only=True)
class PlatformLoad(Load):
    """A platform, its origin the centre of mass, on rods that are uniform and slender."""

    platform: Platform
    mass: float
    inertia: np.ndarray
    """About its axes. (3,) [kg m^2]"""
    rod_mass: float = 0.0
    """Of each rod. [kg]"""
    gravity: tuple[float, ...] | None = None
    """(3,) [m s^-2]"""
    load_mass: float = 0.0
    """Part of the mass whose weight is a part of the wrench. [kg]"""
    link_mass: float = 0.0
    """Of each link, which weighs along its guideway; the inertia of links is not the load's. [kg]"""
    coordinates: tuple[str, ...] = (
        "v_x_m_s",
        "v_y_m_s",
        "v_z_m_s",
        "w_x_rad_s",
        "w_y_rad_s",
        "w_z_rad_s",
    )
    configuration: tuple[str, ...] = (
        "x_m",
        "y_m",
        "z_m",
        "theta_x_rad",
        "theta_y_rad",
        "theta_z_rad",
    )
    demands: tuple[tuple[Limit, str], ...] = ((Limit.LINKAGE, "rods"), (Limit.TRAVEL, "links"))

    turns: ClassVar[bool] = True

    def at(self, pose: np.ndarray, twist: np.ndarray) -> LinkMotion:
        """Kinematics and inertia; nan beyond the reach of a rod."""
        position, rotation = pose[:, :3], pose[:, 3:]
        turn = rotation_matrix(rotation)
        moves = self.platform.moving(position, turn, twist)
        changes = self.changes(pose, twist)
        demand = np.stack([moves.reach, self.platform.travel_demand(moves.link_position)], axis=-1)
        body = rigid_body(self.mass, self.inertia, turn, twist)
        if self.rod_mass or self.gravity is not None:
            body = self._on_rods(body, position, turn, twist, moves)
        return LinkMotion(moves.jacobian, moves.link_speed, moves.bias, changes, body, demand, moves.link_position)

    def _on_rods(
        self, body: Moved, position: np.ndarray, turn: np.ndarray, twist: np.ndarray, moves: PlatformMotion
    ) -> Moved:
        r"""The body with its rods and all weights, whose energy is 0 or more within the stroke of the links.

        A uniform slender rod moves as :math:`m/6` at each end and :math:`2m/3` in its middle: its kinetic energy
        :math:`\tfrac{m}{6}(v_1^2 + v_1\cdot v_2 + v_2^2)` is that of these three.

        Source: Simpson's rule, which is exact for squares of a velocity that is linear along the rod.
        """
        arms = np.matmul(turn, np.swapaxes(self.platform.joints, 0, 1)).swapaxes(-1, -2)
        rows, count = len(position), self.links
        lower = np.zeros_like(arms, shape=(rows, count, 3, 6))
        lower[:, :, 2] = moves.jacobian
        upper = np.zeros_like(lower)
        upper[:, :, (0, 1, 2), (0, 1, 2)] = 1.0
        # The velocity w x a of a joint, by w.
        upper[:, :, (0, 1, 2), (4, 5, 3)] = arms[..., (2, 0, 1)]
        upper[:, :, (0, 1, 2), (5, 3, 4)] = -arms[..., (1, 2, 0)]
        turning = twist[:, None, 3:] + 0.0 * arms
        rising = np.zeros_like(arms)
        rising[..., 2] = moves.bias
        swinging = crossed(turning, crossed(turning, arms))
        masses = np.repeat(self.rod_mass * np.array([1.0, 4.0, 1.0]) / 6.0, count)
        gravity = np.zeros(3) if self.gravity is None else np.array(self.gravity)
        found = point_masses(
            masses,
            np.concatenate([lower, 0.5 * (lower + upper), upper], axis=1),
            np.concatenate([rising, 0.5 * (rising + swinging), swinging], axis=1),
            gravity,
        )
        own = self.mass - self.load_mass
        weight = self.link_mass * gravity[2] * moves.jacobian.sum(axis=-2)
        weight[:, :3] = weight[:, :3] + own * gravity
        bias = body.bias + found.bias - weight
        # Heights of rods and links are from the guideways, that of the body from their mean.
        base = self.platform.base
        ends = position[:, None] + arms - base
        fallen = own * ((position - base.mean(axis=0)) * gravity).sum(axis=-1)
        fallen = fallen + 0.5 * self.rod_mass * (ends * gravity).sum(axis=(-1, -2))
        fallen = fallen + (0.5 * self.rod_mass + self.link_mass) * gravity[2] * moves.link_position.sum(axis=-1)
        return Moved(body.inertia + found.inertia, bias, self._lowest(gravity) - fallen)

    def _lowest(self, gravity: np.ndarray) -> float:
        """Most that all masses can have fallen from the guideways, without a stroke with links a rod away. [J]"""
        platform = self.platform
        travel = platform.rod_length if platform.stroke is None else float(np.max(np.abs(platform.stroke)))
        reach = platform.rod_length + travel
        aside = np.linalg.norm(platform.joints, axis=-1) + np.linalg.norm(
            platform.base - platform.base.mean(axis=0), axis=-1
        )
        hanging = (self.mass - self.load_mass) * (reach + float(np.max(aside))) + self.links * self.rod_mass * reach
        return float(np.linalg.norm(gravity)) * hanging + self.links * self.link_mass * abs(float(gravity[2])) * travel

    def twist_of(self, pose: np.ndarray, rate: np.ndarray) -> np.ndarray:
        """With the angular velocity of the rotation vector."""
        return np.concatenate([rate[..., :3], angular_velocity(pose[..., 3:], rate[..., 3:])], axis=-1)

    def changes(self, pose: np.ndarray, twist: np.ndarray) -> np.ndarray:
        """With the rate of the rotation vector."""
        return np.concatenate([twist[:, :3], rotation_rate(pose[:, 3:], twist[:, 3:])], axis=-1)

    def apart(self, pose: np.ndarray, goal: np.ndarray) -> np.ndarray:
        """With the turn between the rotations."""
        return np.concatenate([(goal - pose)[:3], rotation_between(pose[3:], goal[3:])])

    @property
    def links(self) -> int:
        """Number of links."""
        return len(self.platform.base)

    def grip(self, coordinates: int) -> Grip:
        """The origin."""
        return PointGrip(axes=TRANSLATIONS, turns=ROTATIONS, coordinates=coordinates)

    def outline(self, link_mass: float, drum: Drum | None) -> OnRods:
        """Platform and rods."""
        return OnRods(
            platform=self.platform,
            mass=self.mass,
            inertia=self.inertia,
            rod_mass=self.rod_mass,
            link_mass=link_mass,
            drum=drum,
        )
