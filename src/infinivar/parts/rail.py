"""Linear guides: a profiled rail and the carriage that rolls on it."""

from __future__ import annotations

from dataclasses import dataclass

from annotated_types import Ge, Gt

from infinivar._core.fields import check, component, quantity


@dataclass(frozen=True, slots=True, kw_only=True)
class Rail:
    """Rail with one carriage, as data sheets state it.

    Raises
    ------
    ParameterError
        If a field is outside its range; the message names field, value and unit.
    """

    name: str = component("Name for reports", default="rail")
    static_rating: float = quantity("N", Gt(0), "Basic static load rating C0 of a carriage")
    dynamic_rating: float | None = quantity("N", Gt(0), "Basic dynamic load rating C of a carriage", default=None)
    carriage_mass: float = quantity("kg", Gt(0), "Mass of a carriage")
    rail_density: float = quantity("kg/m", Gt(0), "Mass of the rail over its length")
    width: float = quantity("m", Gt(0), "Width of the carriage")
    height: float = quantity("m", Gt(0), "Height of rail and carriage together")
    carriage_length: float = quantity("m", Gt(0), "Length of a carriage")
    seal_friction: float | None = quantity(
        "N", Ge(0), "Largest friction force of the seals of a carriage", default=None
    )
    friction_coefficient: float | None = quantity(
        "1", Ge(0), "Friction force over the load of a carriage", default=None
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)

    @property
    def weight(self) -> float:
        """Mass of a carriage and a rail as long as three carriages, by which rails are ordered. [kg]"""
        return self.carriage_mass + 3.0 * self.carriage_length * self.rail_density
