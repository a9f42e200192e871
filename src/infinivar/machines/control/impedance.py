"""Impedance display with a geared motor for each link: walls, paths, fixtures, free motion and holding, by its currents.

The display measures positions and speeds and commands forces; what it renders is beside the inertia and friction of the drives.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from annotated_types import Ge, Interval

from infinivar._core.arrays import real_array
from infinivar._core.fields import check, component, quantity
from infinivar.bondgraph.recorded import vector
from infinivar.bondgraph.scalars import choose
from infinivar.bondgraph.tape import Number
from infinivar.errors import InputError, ParameterError, require
from infinivar.machines.control.controller import Law, Measured, Plant
from infinivar.machines.control.loops import Commands
from infinivar.machines.control.planar import Surface
from infinivar.machines.hand import Grip
from infinivar.machines.linkage import SeparateMechanics
from infinivar.machines.motors import LinkMotors
from infinivar.motion.virtual.fixtures import Allowed


def wall_force(depth: Any, inward: Any, stiffness: float, damping: float) -> Any:
    r"""Force of a virtual wall towards its free side, :math:`\max(K\,p + B\,\dot p, 0)` inside, 0 outside.

    Parameters
    ----------
    depth : (...,) float     p, of penetration. [m]
    inward : (...,) float    Its rate. [m s^-1]
    stiffness : float        K. [N m^-1]
    damping : float          B. [N s m^-1]

    Returns
    -------
    (...,) float   A wall does not pull. [N]

    Source: colgate1997, for the virtual wall.
    """
    return np.where(depth > 0.0, np.maximum(stiffness * depth + damping * inward, 0.0), 0.0)


def held_directions(allowed: Allowed, axes: tuple[str, ...]) -> np.ndarray:
    """Projection on the directions in which a fixture holds an end point that slides.

    Parameters
    ----------
    allowed : Allowed      Such as `AlongLine` or `InPlane`.
    axes : names           In which the end point moves, some of x, y, z.

    Returns
    -------
    (d, d) float

    Raises
    ------
    InputError
        If the fixture leads the end point round an axis: its directions then change with the position.
    """
    first, other = (allowed.rows(axes, place).rows for place in (np.zeros(3), np.array([1.0, 2.0, 3.0])))
    if not np.allclose(first, other, rtol=0.0, atol=1e-12):
        raise InputError("a display of separate axes has fixtures of fixed directions only: state a circle as a path")
    return np.linalg.pinv(first) @ first


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ImpedanceGuide:
    """A wall, a path, a fixture or a point, held by springs and dampers; or none of them: free motion.

    Raises
    ------
    ParameterError
        If a field is out of range, or the wall or curve lacks a member.
    """

    wall: Surface | None = component("Virtual wall: with distance(point) and normal(point)", default=None)
    two_sided: bool = component("Whether the wall holds the handle from both sides", default=False)
    hold: Any = component('Point to hold, one coordinate for each axis [m]; or "start"', default=None)
    curve: Any = component("Path along which the handle is free: with nearest(point, near)", default=None)
    ends: Literal["stop", "free"] = component("Whether an open path stops the handle at its ends", default="stop")
    allowed: Allowed | None = component(
        "Fixture, at the start of the session, of an end point that slides", default=None
    )
    stiffness: float = quantity("N/m", Ge(0), "Stiffness of what holds the handle", default=1000.0)
    damping: float = quantity("N s/m", Ge(0), "Damping of what holds the handle", default=5.0)
    compensation: float = quantity(
        "1", Interval(ge=0, le=1), "Share of the constant friction that is fed forward along the motion", default=0.0
    )
    compensation_speed: float = quantity("m/s", Interval(gt=0, le=10), "Speed from which that is in full", default=0.01)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        for name in ("distance", "normal"):
            if self.wall is not None and not hasattr(self.wall, name):
                raise ParameterError(
                    f"wall must have distance and normal, but a {type(self.wall).__name__} has no {name}"
                )
        if self.curve is not None and not hasattr(self.curve, "nearest"):
            raise ParameterError(f"curve must have nearest(point, near), got {self.curve!r}")
        if self.allowed is not None and not hasattr(self.allowed, "rows"):
            raise ParameterError(f"allowed must be a fixture, such as AlongLine or InPlane, got {self.allowed!r}")

    def begin(self, plant: Plant) -> Law:
        """The law of one session."""
        motors, mechanics = plant.system.links, plant.mechanics
        if motors is None or not isinstance(mechanics, SeparateMechanics):
            raise ParameterError(
                f"ImpedanceGuide drives a motor for each link, as of a GearedSlideMachine, not a {type(plant.machine).__name__}"
            )
        count = len(plant.grip.axes)
        kept = None if self.allowed is None else held_directions(self.allowed, plant.grip.axes)
        hold = self.hold
        if hold is not None and not (isinstance(hold, str) and hold == "start"):
            hold = real_array("hold", hold)
            fits = hold.shape == (count,) and bool(np.all(np.isfinite(hold)))
            require(fits, "hold", f"{self.hold}", f"{count} finite numbers, one for each axis", "m")
        return _Impedance(self, mechanics, motors, plant.grip, kept, hold)


@dataclass(slots=True)
class _Impedance:
    """Springs and dampers in a session."""

    settings: ImpedanceGuide
    mechanics: SeparateMechanics
    motors: LinkMotors
    grip: Grip
    kept: np.ndarray | None
    """Projection on the directions that a fixture holds."""
    hold: Any
    start: np.ndarray | None = None
    """Position of the handle at the first sample. (d,) [m]"""
    near: Number | None = None
    """Arc length of the closest point of a curve."""

    @property
    def memory(self) -> list[np.ndarray]:
        """The arc length, of a curve."""
        return [] if self.near is None else [np.array([self.near])]

    @memory.setter
    def memory(self, kept: Sequence[np.ndarray]) -> None:
        if kept:
            ((self.near,),) = kept

    def __call__(self, measured: Measured) -> Commands:
        """Currents of the motors."""
        settings, motors = self.settings, self.motors
        if self.start is None:
            self.start = measured.position.copy()
        force = self._force(measured, self.start)
        pose, rates = measured.configuration[None], measured.rates[None]
        link = self.mechanics.load.at(pose, rates)
        felt = self.grip.at(pose, rates).jacobian[0].T
        on_links = np.linalg.lstsq(link.jacobian[0].T, felt @ force, rcond=None)[0]
        share = np.clip(link.speed[0] / settings.compensation_speed, -1.0, 1.0)
        friction = settings.compensation * sum(motors.frictions)
        return Commands(currents=(on_links + friction * share) / motors.gain)

    def _force(self, measured: Measured, start: np.ndarray) -> np.ndarray:
        """On the handle. (d,) [N]"""
        settings, position, velocity = self.settings, measured.position, measured.velocity
        count, force = len(position), np.zeros_like(position)
        stiffness, damping = settings.stiffness, settings.damping
        wall = settings.wall
        if wall is not None:
            dimension = getattr(wall, "dimension", count)
            at, moves = position[:dimension], velocity[:dimension]
            normal = wall.normal(at)
            depth, inward = -wall.distance(at), -(normal @ moves)
            pushed = wall_force(depth, inward, stiffness, damping)
            if settings.two_sided:
                pushed = stiffness * depth + damping * inward
            force[:dimension] += pushed * normal
        if settings.curve is not None:
            there = settings.curve.nearest(position, self.near)
            self.near, along = there.arc_length, vector(*there.tangent)
            stopped = choose(settings.ends == "stop", lambda: there.beyond != 0.0, lambda: False)
            drawn = stiffness * (vector(*there.point) - position) - damping * velocity
            force = force + drawn - choose(stopped, lambda: 0.0, lambda: along @ drawn) * along
        if self.kept is not None:
            force = force - self.kept @ (stiffness * (position - start) + damping * velocity)
        if self.hold is not None:
            point = start if isinstance(self.hold, str) else self.hold
            force = force + stiffness * (point - position) - damping * velocity
        return force
