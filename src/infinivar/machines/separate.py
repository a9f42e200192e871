"""A platform or arm whose links are moved by a geared motor each: its mechanics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from infinivar.limits import Limit
from infinivar.machines.linkage import Load
from infinivar.machines.system import Forces, Place


@dataclass(frozen=True, slots=True, kw_only=True)
class SeparateMechanics:
    """A load on links, without wheels or a cylinder."""

    load: Load
    count: int
    """Of links."""
    link_mass: float
    """With what moves it. [kg] or [kg m^2]"""
    losses: tuple[str, ...] = ()
    steered: tuple[str, ...] = ()

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Twist."""
        return self.load.coordinates

    @property
    def configuration(self) -> tuple[str, ...]:
        """Pose."""
        return self.load.configuration

    @property
    def demands(self) -> tuple[tuple[Limit, str], ...]:
        """Limits of the linkage."""
        return self.load.demands

    def at(self, configuration: np.ndarray, rates: np.ndarray) -> Place:
        """Inertia with that of the links, and kinematics."""
        link = self.load.at(configuration, rates)
        across = np.swapaxes(link.jacobian, -1, -2)
        inertia = link.moved.inertia + self.link_mass * np.matmul(across, link.jacobian)
        bias = link.moved.bias + self.link_mass * np.matmul(across, link.bias[..., None])[..., 0]
        return Place(link.changes, inertia, bias, link)

    def act(self, place: Place, rates: np.ndarray, angles: np.ndarray, turning: np.ndarray) -> Forces:
        """None: the motors act on the links, see `LinkMotors`."""
        return Forces(0.0 * rates, 0.0 * angles, dict, lambda: place.kinematics.demand)
