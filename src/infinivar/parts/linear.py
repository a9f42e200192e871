"""Linear parts: the pulley or capstan that converts rotation to linear motion, and the guideway of the load."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from annotated_types import Ge, Gt

from infinivar._core.array_namespace import Array
from infinivar._core.fields import check, component, quantity
from infinivar.contact.friction import coulomb
from infinivar.parts.rail import Rail
from infinivar.parts.shaft_bearings import PulleyBearings
from infinivar.parts.stage import OutputStage


@dataclass(frozen=True, slots=True, kw_only=True)
class Pulley(OutputStage):
    """Pulley or capstan: converts torque to cable force, with Coulomb friction in its bearings.

    Raises
    ------
    ParameterError
        If a field is outside its range; the message names field, value and unit.
    """

    title: ClassVar[str] = "pulley"
    letter: ClassVar[str] = "p"

    radius: float = quantity("m", Gt(0), "Effective radius at the cable")
    friction_torque: float = quantity("N m", Ge(0), "Coulomb friction torque of pulley and bearings", default=0.0)
    bearings: PulleyBearings | None = component(
        "Bearings of the pulley's shaft under the pull of the cable, which add to friction_torque", default=None
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)

    @property
    def travel_per_radian(self) -> float:
        """The radius. [m/rad]"""
        return self.radius


@dataclass(frozen=True, slots=True, kw_only=True)
class Guideway:
    """Linear guide with Coulomb friction: a constant part plus a part proportional to the preload.

    Raises
    ------
    ParameterError
        If a field is outside its range; the message names field, value and unit.
    """

    USES: ClassVar[tuple[str, ...]] = ("friction_force", "operate")
    """What a drive uses of its guideway: an object with these can take its place."""

    friction: float = quantity("N", Ge(0), "Friction force independent of preload", default=0.0)
    coefficient: float = quantity("1", Ge(0), "Friction coefficient c_l, force over preload", default=0.0)
    rail: Rail | None = component(
        "Rail and carriage, for masses; default: the lightest of the catalogue that carries the load", default=None
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)

    def friction_force(self, preload: Array = 0.0) -> Array:
        """Magnitude of the friction force under a normal force. [N]

        Source: faulring2006, Fig 13 (``c_l P``).
        """
        return self.friction + self.coefficient * preload

    def operate(self, *, force: Array, speed: Array, preload: Array = 0.0) -> tuple[Array, Array]:
        """Friction force that opposes the motion, or at rest helps to hold a force, and its loss.

        Parameters
        ----------
        force : (...,) float     Force to be exerted on the load that the guide carries. [N]
        speed : (...,) float     [m s^-1]
        preload : (...,) float   Normal force on the guide. [N]

        Returns
        -------
        friction, loss : (...,) float   Friction with the sign of the speed, at rest with that of ``-force``. [N], [W]

        Source: faulring2006, Fig 13 and Eq 18 (``c_l P sgn(ldot)``).
        """
        friction = coulomb(speed, self.friction_force(preload), held=force)
        return friction, friction * speed
