"""What is drawn of a machine in motion: its bodies as plain data, for figures, videos and scenes alike.

A kind of machine gives one of the four outlines. Each names its shape, by which drawings choose how to show it, and has a method
that places its parts at configurations.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal, NamedTuple

import numpy as np

from infinivar.transmission.platform import Platform, rotation_matrix


class Drum(NamedTuple):
    """A common cylinder with a steered wheel for each link."""

    radius: float
    """[m]"""
    wheel_radius: float
    """Of the largest wheel. [m]"""
    inertia: float
    """[kg m^2]"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Wheeled:
    """A body in the plane on wheels, which steer or have free rollers."""

    shape: ClassVar[Literal["planar"]] = "planar"

    spots: np.ndarray
    """Of the wheels in axes of the body. (k, 2) [m]"""
    radii: np.ndarray
    """(k,) [m]"""
    mass: float
    """[kg]"""
    inertia: float
    """About the origin. [kg m^2]"""
    headings: np.ndarray | None = None
    """Of wheels that do not steer. (k,) [rad]"""

    def link_positions(self, configuration: np.ndarray) -> np.ndarray:
        """None. (t, 0)"""
        return np.zeros((len(configuration), 0))


class RodEnds(NamedTuple):
    """Ends of the rods of a platform at t instants; n rods. [m]"""

    lower: np.ndarray
    """Carried by the links. (t, n, 3)"""
    upper: np.ndarray
    """On the platform. (t, n, 3)"""
    link_position: np.ndarray
    """(t, n)"""


@dataclass(frozen=True, slots=True, kw_only=True)
class OnRods:
    """A body in space on rods, whose links slide along z."""

    shape: ClassVar[Literal["platform"]] = "platform"

    platform: Platform
    mass: float
    """[kg]"""
    inertia: np.ndarray
    """About its axes. (3,) [kg m^2]"""
    link_mass: float
    """[kg]"""
    drum: Drum | None

    def rods(self, pose: np.ndarray) -> RodEnds:
        """Rods at poses (t, 6): position and rotation vector."""
        platform = self.platform
        turn = rotation_matrix(pose[:, 3:])
        link = platform.moving(pose[:, :3], turn, np.zeros_like(pose)).link_position
        upper = pose[:, None, :3] + np.einsum("tij,nj->tni", turn, platform.joints)
        lower = platform.base + link[..., None] * np.array([0.0, 0.0, 1.0])
        return RodEnds(lower, upper, link)

    def link_positions(self, configuration: np.ndarray) -> np.ndarray:
        """Of the links since their position 0. (t, n) [m]"""
        return self.rods(configuration).link_position


@dataclass(frozen=True, slots=True, kw_only=True)
class Chain:
    """Members in a plane, each turning about the end of the one before, over pulleys."""

    shape: ClassVar[Literal["arm"]] = "arm"

    lengths: np.ndarray
    """(n,) [m]"""
    masses: np.ndarray
    """Of the members, which are uniform. (n,) [kg]"""
    tip_mass: float
    """[kg]"""
    tip_inertia: float
    """[kg m^2]"""
    pulleys: np.ndarray
    """Radii over which links move the joints. (n,) [m]"""
    link_mass: float
    """[kg]"""
    drum: Drum | None

    def points(self, angles: np.ndarray) -> np.ndarray:
        """Base, joints and end point at joint angles (t, n). (t, n + 1, 2) [m]"""
        along = np.cumsum(angles, axis=-1)
        members = self.lengths[:, None] * np.stack([np.cos(along), np.sin(along)], axis=-1)
        return np.concatenate([np.zeros((len(angles), 1, 2)), np.cumsum(members, axis=1)], axis=1)

    def link_positions(self, configuration: np.ndarray) -> np.ndarray:
        """Of the links since their position 0. (t, n) [m]"""
        return self.pulleys * configuration


@dataclass(frozen=True, slots=True, kw_only=True)
class Slides:
    """A handle on axes, each moved by a link."""

    shape: ClassVar[Literal["slide"]] = "slide"

    masses: np.ndarray
    """Moved along each axis. (n,) [kg]"""
    link_mass: float
    """[kg]"""
    drum: Drum | None

    def link_positions(self, configuration: np.ndarray) -> np.ndarray:
        """Those of the axes. (t, n) [m]"""
        return configuration


Outline = Wheeled | OnRods | Chain | Slides
