"""The space and mass that a drive may have."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

from annotated_types import Gt

from infinivar._core.array_namespace import Array, as_floats, namespace
from infinivar._core.fields import check, quantity
from infinivar.drivetrain.body import total
from infinivar.drivetrain.layout import Space
from infinivar.drivetrain.service import Service
from infinivar.errors import ParameterError
from infinivar.limits import Demand, Limit


@dataclass(frozen=True, slots=True, kw_only=True)
class Envelope:
    """Largest length, width, height, diameter and mass of a whole drive; what is not stated is free.

    Raises
    ------
    ParameterError
        If nothing is stated or a value is out of range.
    """

    length: float | None = quantity("m", Gt(0), "Length along the travel of the load, the drive at rest", default=None)
    width: float | None = quantity("m", Gt(0), "Width, or height: a drive may be turned about its length", default=None)
    height: float | None = quantity("m", Gt(0), "Height, or width", default=None)
    diameter: float | None = quantity("m", Gt(0), "Inner diameter of a tube along the length", default=None)
    mass: float | None = quantity("kg", Gt(0), "Mass of the whole drive", default=None)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        if all(getattr(self, one.name) is None for one in fields(self)):
            raise ParameterError("length is missing: state length, width, height, diameter or mass")

    @property
    def sizes(self) -> tuple[str, ...]:
        """Names of the lengths stated."""
        return tuple(name for name in ("length", "width", "height", "diameter") if getattr(self, name) is not None)

    def of(self, drive: Any, service: Service) -> dict[Demand, Array]:
        """Demand over allowance of a drive, whose values may be arrays of many designs; see `demands`."""
        mass = None if self.mass is None else total(drive.bodies(service))
        return self.demands(drive.layout(service).space, mass)

    def demands(self, space: Space, mass: Array | None = None) -> dict[Demand, Array]:
        """Demand over allowance of what the envelope states.

        Parameters
        ----------
        space : Space         Of a drive.
        mass : (...,) float   Of the whole drive; None is not judged. [kg]

        Returns
        -------
        dict of Demand to (...,) float   [-]
        """
        found: dict[Demand, Array] = {}
        if self.length is not None:
            found[Limit.SPACE, "length"] = space.length / self.length
        if self.width is not None or self.height is not None:
            xp = namespace(space.width, space.height)
            width, height = as_floats(xp, space.width, space.height)
            across, up = (1.0 / side if side is not None else 0.0 for side in (self.width, self.height))
            upright, turned = (xp.maximum(a * across, b * up) for a, b in ((width, height), (height, width)))
            found[Limit.SPACE, "width and height"] = xp.minimum(upright, turned)
        if self.diameter is not None:
            found[Limit.SPACE, "diameter"] = space.diameter / self.diameter
        if self.mass is not None and mass is not None:
            found[Limit.MASS, "mass"] = mass / self.mass
        return found
