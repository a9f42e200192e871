"""Linear parts: the pulley or capstan that converts rotation to linear motion, and the guideway of the load."""

from __future__ import annotations

from dataclasses import dataclass

from annotated_types import Ge, Gt

from infinivar._core.array_namespace import Array
from infinivar._core.fields import check, quantity
from infinivar.contact.friction import coulomb


@dataclass(frozen=True, slots=True, kw_only=True)
class Pulley:
    """Pulley or capstan: converts torque to cable force, with Coulomb friction in its bearings.

    Raises
    ------
    ParameterError
        If a field is outside its range; the message names field, value and unit.
    """

    radius: float = quantity("m", Gt(0), "Effective radius at the cable")
    friction_torque: float = quantity("N m", Ge(0), "Coulomb friction torque of pulley and bearings", default=0.0)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)

    def operate(self, *, force: Array, speed: Array) -> tuple[Array, Array, Array]:
        """Shaft torque and speed for a cable force and speed; at rest, friction helps to hold.

        Parameters
        ----------
        force, speed : (...,) float   At the cable, power positive to the load. [N], [m s^-1]

        Returns
        -------
        torque, speed, loss : (...,) float   Torque and speed at the shaft, loss in the pulley. [N m], [rad s^-1], [W]

        Source: faulring2006, Fig 14 (transformer r_pulley).
        """
        turning = speed / self.radius
        torque = force * self.radius
        friction = coulomb(turning, self.friction_torque, held=torque)
        return torque + friction, turning, friction * turning


@dataclass(frozen=True, slots=True, kw_only=True)
class Guideway:
    """Linear guide with Coulomb friction: a constant part plus a part proportional to the preload.

    Raises
    ------
    ParameterError
        If a field is outside its range; the message names field, value and unit.
    """

    friction: float = quantity("N", Ge(0), "Friction force independent of preload", default=0.0)
    coefficient: float = quantity("1", Ge(0), "Friction coefficient c_l, force over preload", default=0.0)

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
