"""Springs: linear, progressive or one-sided, with preload and hysteresis; along a line or about a joint.

The laws and their signs are those of `infinivar.parts.elastic`; hysteresis is that of `infinivar.parts.elastic`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from annotated_types import Ge, Gt

from infinivar._core.array_namespace import Array, namespace
from infinivar._core.bounds import FINITE
from infinivar._core.fields import component, given, quantities, quantity
from infinivar.errors import ParameterError
from infinivar.parts.elastic import Elastic, SpringShape, SpringSide
from infinivar.parts.structure.stock import StockSpring, check_coils

SpringPlace = Literal["load", "drive"]

_WIDTH, _ANGULAR_WIDTH = 1e-4, 1e-3
"""Default width of the transition at contact. [m], [rad]"""

_AT = "Side on which a parallel spring acts, seen from the series spring: load or drive"
_SHAPE = "linear, progressive (a table), or one-sided (a stop or unilateral spring)"
_SIDE = "Side of the rest position on which a one-sided spring acts: positive (default) or negative"


@dataclass(frozen=True, slots=True, kw_only=True)
class Spring(Elastic, StockSpring):
    """Spring along a line, made to measure or from stock.

    Raises
    ------
    ParameterError
        If a field is outside its range, missing or not used by the shape, or if the table's curve falls anywhere.
    """

    shape: SpringShape = component(_SHAPE, default="linear")
    at: SpringPlace = component(_AT, default="load")
    stiffness: float | None = quantity(
        "N/m", Ge(0), "Stiffness of a linear or one-sided spring; 0: no spring", default=None
    )
    rest: float = quantity("m", FINITE, "Position at rest; of a one-sided spring: position of contact", default=0.0)
    preload: float = quantity("N", FINITE, "Force at the rest position", default=0.0)
    deflections: tuple[float, ...] | None = quantities(
        "m", FINITE, "Deflections of a progressive spring, increasing", default=None
    )
    forces: tuple[float, ...] | None = quantities("N", FINITE, "Forces at these deflections, increasing", default=None)
    side: SpringSide | None = component(_SIDE, default=None)
    contact_width: float | None = quantity(
        "m", Gt(0), "Width of the smooth transition at the contact of a one-sided spring; default: 0.1 mm", default=None
    )
    hysteresis: float | None = quantity("N", Ge(0), "Half the width of the force loop", default=None)
    presliding: float | None = quantity(
        "m",
        Gt(0),
        "Deflection over which the hysteresis force builds up; default: hysteresis over stiffness",
        default=None,
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        self._validate("m")
        check_coils(self)
        if self.absent and self.permissible_force is not None:
            raise ParameterError("stiffness must be > 0 with a permissible_force, got 0")

    @property
    def limited(self) -> bool:
        """Whether its deflection or its force has a limit."""
        return self.deflections is not None or self.permissible_force is not None

    def demand(self, position: Array) -> Array:
        """Deflection over that at the end of the table, or force over the permissible one, whichever is larger. [-]"""
        travel = Elastic.demand(self, position)
        if self.permissible_force is None:
            return travel
        xp = namespace(self, position)
        force = xp.abs(self.force(position)) / self.permissible_force
        return xp.where(force > travel, force, travel)

    @property
    def width(self) -> float:
        """Width of the transition at the contact of a one-sided spring. [m]"""
        return given(self.contact_width, _WIDTH)


@dataclass(frozen=True, slots=True, kw_only=True)
class TorsionSpring(Elastic):
    """Spring about a joint or shaft; the fields and laws of `Spring`, with moments and angles.

    Raises
    ------
    ParameterError
        As for `Spring`.
    """

    shape: SpringShape = component(_SHAPE, default="linear")
    at: SpringPlace = component(_AT, default="load")
    stiffness: float | None = quantity(
        "N m/rad", Ge(0), "Stiffness of a linear or one-sided spring; 0: no spring", default=None
    )
    rest: float = quantity("rad", FINITE, "Angle at rest; of a one-sided spring: angle of contact", default=0.0)
    preload: float = quantity("N m", FINITE, "Moment at the rest angle", default=0.0)
    deflections: tuple[float, ...] | None = quantities(
        "rad", FINITE, "Deflections of a progressive spring, increasing", default=None
    )
    forces: tuple[float, ...] | None = quantities(
        "N m", FINITE, "Moments at these deflections, increasing", default=None
    )
    side: SpringSide | None = component(_SIDE, default=None)
    contact_width: float | None = quantity(
        "rad",
        Gt(0),
        "Width of the smooth transition at the contact of a one-sided spring; default: 1 mrad",
        default=None,
    )
    hysteresis: float | None = quantity("N m", Ge(0), "Half the width of the moment loop", default=None)
    presliding: float | None = quantity(
        "rad",
        Gt(0),
        "Deflection over which the hysteresis moment builds up; default: hysteresis over stiffness",
        default=None,
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        self._validate("rad")

    @property
    def width(self) -> float:
        """Width of the transition at the contact of a one-sided spring. [rad]"""
        return given(self.contact_width, _ANGULAR_WIDTH)
