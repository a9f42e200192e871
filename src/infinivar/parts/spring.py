r"""Springs: linear, progressive or one-sided, with preload and hysteresis; along a line or about a joint.

The elastic force of a spring at a deflection x is a smooth increasing function F(x):

- ``linear``: :math:`F = F_0 + k (x - x_0)`;
- ``progressive``: an interpolating spline through a table of deflections and forces, plus :math:`F_0`;
- ``one-sided``: 0 until the deflection reaches :math:`x_0`, then :math:`F_0 + k (x - x_0)`, with a smooth transition.

Hysteresis adds a friction force z that follows the deflection as in dahl1968.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from annotated_types import Gt

from infinivar._core.bounds import FINITE
from infinivar._core.fields import check, component, quantities, quantity

SpringShape = Literal["linear", "progressive", "one-sided"]
SpringPlace = Literal["load", "drive"]

_AT = "Side on which a parallel spring acts, seen from the series spring: load or drive"
_SHAPE = "linear, progressive (a table), or one-sided (a stop or unilateral spring)"


@dataclass(frozen=True, slots=True, kw_only=True)
class Spring:
    """Spring along a line."""

    shape: SpringShape = component(_SHAPE, default="linear")
    at: SpringPlace = component(_AT, default="load")
    stiffness: float | None = quantity("N/m", Gt(0), "Stiffness of a linear or one-sided spring", default=None)
    rest: float = quantity("m", FINITE, "Position at rest; of a one-sided spring: position of contact", default=0.0)
    preload: float = quantity("N", FINITE, "Force at the rest position", default=0.0)
    deflections: tuple[float, ...] | None = quantities(
        "m", FINITE, "Deflections of a progressive spring, increasing", default=None
    )
    forces: tuple[float, ...] | None = quantities("N", FINITE, "Forces at these deflections, increasing", default=None)
    hysteresis: float | None = quantity("N", Gt(0), "Half the width of the force loop", default=None)
    presliding: float | None = quantity(
        "m", Gt(0), "Deflection over which the hysteresis force builds up after a reversal", default=None
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class TorsionSpring:
    """Spring about a joint or shaft; the fields of `Spring`, with moments and angles."""

    shape: SpringShape = component(_SHAPE, default="linear")
    at: SpringPlace = component(_AT, default="load")
    stiffness: float | None = quantity("N m/rad", Gt(0), "Stiffness of a linear or one-sided spring", default=None)
    rest: float = quantity("rad", FINITE, "Angle at rest; of a one-sided spring: angle of contact", default=0.0)
    preload: float = quantity("N m", FINITE, "Moment at the rest angle", default=0.0)
    deflections: tuple[float, ...] | None = quantities(
        "rad", FINITE, "Deflections of a progressive spring, increasing", default=None
    )
    forces: tuple[float, ...] | None = quantities(
        "N m", FINITE, "Moments at these deflections, increasing", default=None
    )
    hysteresis: float | None = quantity("N m", Gt(0), "Half the width of the moment loop", default=None)
    presliding: float | None = quantity(
        "rad", Gt(0), "Deflection over which the hysteresis moment builds up after a reversal", default=None
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
