"""Impedance display with a geared motor for each link: walls, free motion and holding, by the currents of the motors.

The display measures positions and speeds and commands forces; what it renders is beside the inertia and friction of the drives.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from annotated_types import Ge, Interval

from infinivar._core.arrays import real_array
from infinivar._core.fields import check, component, quantity
from infinivar.drivetrain.guidance.controller import Law, Measured, Plant
from infinivar.drivetrain.guidance.planar import Surface
from infinivar.drivetrain.moving.control import Commands
from infinivar.drivetrain.moving.separate import SeparateMechanics
from infinivar.errors import ParameterError, require


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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ImpedanceGuide:
    """A wall, a point that is held, both, or neither: free motion.

    Raises
    ------
    ParameterError
        If a field is out of range, or the wall lacks a member.
    """

    wall: Surface | None = component("Virtual wall: with distance(point) and normal(point)", default=None)
    two_sided: bool = component("Whether the wall holds the handle from both sides", default=False)
    hold: Any = component('Point to hold, one coordinate for each axis [m]; or "start"', default=None)
    stiffness: float = quantity("N/m", Ge(0), "Stiffness of wall or hold", default=1000.0)
    damping: float = quantity("N s/m", Ge(0), "Damping of wall or hold", default=5.0)
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

    def begin(self, plant: Plant) -> Law:
        """The law of one session."""
        motors, mechanics = plant.system.links, plant.mechanics
        if motors is None or not isinstance(mechanics, SeparateMechanics):
            raise ParameterError(
                f"ImpedanceGuide drives a motor for each link, as of a GearedSlideMachine, not a {type(plant.machine).__name__}"
            )
        count = len(plant.grip.axes)
        starts = isinstance(self.hold, str) and self.hold == "start"
        held: list[np.ndarray] = []
        hold = None if self.hold is None or starts else real_array("hold", self.hold)
        if hold is not None:
            fits = hold.shape == (count,) and bool(np.all(np.isfinite(hold)))
            require(fits, "hold", f"{self.hold}", f"{count} finite numbers, one for each axis", "m")
        friction = self.compensation * sum(motors.frictions)

        def law(measured: Measured) -> Commands:
            force = np.zeros(count)
            if self.wall is not None:
                dimension = getattr(self.wall, "dimension", count)
                at, moves = measured.position[:dimension], measured.velocity[:dimension]
                normal = np.asarray(self.wall.normal(at))
                depth, inward = -float(self.wall.distance(at)), -float(normal @ moves)
                pushed = wall_force(depth, inward, self.stiffness, self.damping)
                if self.two_sided:
                    pushed = self.stiffness * depth + self.damping * inward
                force[:dimension] += pushed * normal
            if starts and not held:
                held.append(measured.position.copy())
            point = held[0] if starts else hold
            if point is not None:
                force += self.stiffness * (point - measured.position) - self.damping * measured.velocity
            pose, rates = measured.configuration[None], measured.rates[None]
            link = mechanics.load.at(pose, rates)
            across = plant.grip.at(pose, rates).jacobian[0].T
            on_links = np.linalg.lstsq(link.jacobian[0].T, across @ force, rcond=None)[0]
            share = np.clip(link.speed[0] / self.compensation_speed, -1.0, 1.0)
            return Commands(currents=(on_links + friction * share) / motors.gain)

        return law
