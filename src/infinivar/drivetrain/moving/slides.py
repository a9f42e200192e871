"""Mechanics of slides: a handle on translational axes, each moved by a leg on a common cylinder or by a geared drive."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from infinivar.contact.friction import coulomb
from infinivar.drivetrain.moving.bodies import Moved
from infinivar.drivetrain.moving.legged import Linkage
from infinivar.drivetrain.moving.system import Forces, Place
from infinivar.limits import Limit


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
        return Linkage(jacobian, twist, 0.0 * twist, twist, Moved(inertia, 0.0 * twist), nothing)


@dataclass(frozen=True, slots=True, kw_only=True)
class SlideMechanics:
    """Masses on guideways, one axis each, without contacts; motors act on the axes."""

    masses: np.ndarray
    """(n,) [kg]"""
    guideway_friction: float
    """Of each axis. [N]"""
    stage: str
    """Name of the output stage's loss."""
    stage_friction: float
    """Of the stage of each axis, at the axis. [N]"""
    stick_speed: float
    """[m s^-1]"""
    steered: tuple[str, ...] = ()
    demands: tuple[tuple[Limit, str], ...] = ()
    losses: tuple[str, ...] = field(init=False, default=())

    def __post_init__(self) -> None:
        """Name the losses."""
        object.__setattr__(self, "losses", ("guideway", self.stage))

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

    def at(self, configuration: np.ndarray, rates: np.ndarray) -> Place:
        """Constant inertia."""
        count = len(self.masses)
        inertia = np.broadcast_to(np.diag(self.masses), (len(rates), count, count))
        return Place(rates, inertia, 0.0 * rates, None)

    def act(self, place: Place, rates: np.ndarray, angles: np.ndarray, turning: np.ndarray) -> Forces:
        """Friction of guideways and stages."""
        share = coulomb(rates, 1.0, self.stick_speed)
        slid = np.sum(share * rates, axis=-1)
        losses = {"guideway": self.guideway_friction * slid, self.stage: self.stage_friction * slid}
        nothing = np.zeros((len(rates), 0))
        return Forces(-(self.guideway_friction + self.stage_friction) * share, nothing, losses, nothing)
