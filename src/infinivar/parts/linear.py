"""Linear parts: the pulley or capstan that converts rotation to linear motion, and the guideway of the load."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

from annotated_types import Ge, Gt

from infinivar._core.array_namespace import Array
from infinivar._core.fields import check, component, quantity, value_at
from infinivar.contact.friction import coulomb
from infinivar.errors import ParameterError, require
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


_FIELDS = {"stated": ("friction", "coefficient"), "rail": ("rail.seal_friction", "rail.friction_coefficient")}


@dataclass(frozen=True, slots=True, kw_only=True)
class Guideway:
    """Linear guide with Coulomb friction: a constant part plus a part proportional to the preload.

    Raises
    ------
    ParameterError
        If a field is outside its range, or the rail does not state the friction that is to be its own.
    """

    USES: ClassVar[tuple[str, ...]] = ("friction_force", "operate")
    """What a drive uses of its guideway: an object with these can take its place."""

    friction: float = quantity("N", Ge(0), "Friction force independent of preload", default=0.0)
    coefficient: float = quantity("1", Ge(0), "Friction coefficient c_l, force over preload", default=0.0)
    friction_model: Literal["stated", "rail"] = component(
        "stated: `friction` and `coefficient` (default); rail: seal_friction and friction_coefficient of `rail`",
        default="stated",
    )
    rail: Rail | None = component(
        "Rail and carriage, for masses; default: the lightest of the catalogue that carries the load", default=None
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        if self.friction_model == "stated":
            return
        for name in ("rail", *self.fields):
            if value_at(self, name) is None:
                raise ParameterError(f'{name} is missing: friction_model = "rail" needs it')
        for name in _FIELDS["stated"]:
            if isinstance(value := getattr(self, name), float):
                require(value == 0.0, name, value, '0 with friction_model = "rail", also where a base states another')

    @property
    def fields(self) -> tuple[str, str]:
        """Fields with the friction that does not depend on the preload, and with the coefficient of that which does."""
        return _FIELDS[self.friction_model]

    def friction_force(self, preload: Array = 0.0) -> Array:
        """Magnitude of the friction force under a normal force. [N]

        Source: faulring2006, Fig 13 (``c_l P``); hiwin2018, Eq 1.11, with the friction of the seals.
        """
        constant, coefficient = (value_at(self, name) for name in self.fields)
        return constant + coefficient * preload

    def follows(self, preload: float) -> float:
        """Share of the friction under a normal force [N] that is proportional to it. [-]"""
        whole = self.friction_force(preload)
        return value_at(self, self.fields[1]) * preload / whole if whole > 0 else 0.0

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
