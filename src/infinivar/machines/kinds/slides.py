"""Linkage of slides: a handle on translational axes, each moved by a leg on a common cylinder or by a geared drive."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from infinivar.limits import Limit
from infinivar.machines.bodies import Moved
from infinivar.machines.linkage import Linkage


def axes_of(count: int) -> tuple[str, ...]:
    """Names of as many axes: x, y and z, or numbers if they are more."""
    return ("x", "y", "z")[:count] if count <= 3 else tuple(str(place + 1) for place in range(count))


@dataclass(frozen=True, slots=True, kw_only=True)
class SlideLoad:
    """Masses on legs, one axis each: the linkage of a slide."""

    masses: np.ndarray
    """Moved along each axis, without its link. (n,) [kg]"""
    demands: tuple[tuple[Limit, str], ...] = ()

    @property
    def axes(self) -> tuple[str, ...]:
        """Names of the axes."""
        return axes_of(len(self.masses))

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Speeds of the axes."""
        return tuple(f"slide_{axis}_m_s" for axis in self.axes)

    @property
    def configuration(self) -> tuple[str, ...]:
        """Positions on the axes."""
        return tuple(f"slide_{axis}_m" for axis in self.axes)

    def at(self, pose: np.ndarray, twist: np.ndarray) -> Linkage:
        """Kinematics and inertia."""
        count, rows = len(self.masses), len(pose)
        inertia = np.broadcast_to(np.diag(self.masses), (rows, count, count))
        jacobian = np.broadcast_to(np.eye(count), (rows, count, count))
        nothing = np.zeros((rows, 0))
        return Linkage(jacobian, twist, 0.0 * twist, twist, Moved(inertia, 0.0 * twist), nothing, pose)
