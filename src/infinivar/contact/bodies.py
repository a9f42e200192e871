"""The bodies of a rolling contact: their materials, and their shapes at the contact."""

from __future__ import annotations

from dataclasses import dataclass

from annotated_types import Gt, Interval

from infinivar._core.array_namespace import Array
from infinivar._core.fields import check, component, quantity


@dataclass(frozen=True, slots=True, kw_only=True)
class Material:
    """Elastic material with its strength and hysteresis.

    Raises
    ------
    ParameterError
        If a field is outside its range; the message names field, value and unit.
    """

    name: str = component("Name for reports", default="material")
    youngs_modulus: float = quantity("Pa", Gt(0), "Young's modulus E")
    poisson: float = quantity("1", Interval(ge=0, le=0.5), "Poisson's ratio nu")
    density: float | None = quantity("kg/m^3", Gt(0), "Density, which masses need", default=None)
    yield_strength: float | None = quantity("Pa", Gt(0), "Yield strength in tension", default=None)
    hardness: float | None = quantity(
        "Pa", Gt(0), "Indentation hardness as a pressure (HV times 9.807 MPa)", default=None
    )
    hysteresis_factor: float = quantity(
        "1",
        Interval(ge=0, le=1),
        "Hysteresis loss factor alpha_fr: fraction of the strain energy lost in rolling",
        default=0.01,
    )
    conductivity: float | None = quantity("W/m/K", Gt(0), "Thermal conductivity", default=None)
    heat_capacity: float | None = quantity(
        "J/m^3/K", Gt(0), "Heat capacity per volume: density times specific heat capacity", default=None
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)

    @property
    def shear_modulus(self) -> float:
        """Shear modulus G = E/(2 (1 + nu)). [Pa]"""
        return self.youngs_modulus / (2.0 * (1.0 + self.poisson))

    @property
    def plane_strain_compliance(self) -> float:
        """(1 - nu^2)/E, this body's contribution to the compliance of a contact. [1/Pa]"""
        return (1.0 - self.poisson**2) / self.youngs_modulus


@dataclass(frozen=True, slots=True, kw_only=True)
class Wheel:
    """Crowned wheel: a section of a torus that rolls on its largest circle."""

    rolling_radius: Array = quantity("m", Gt(0), "Rolling radius r")
    crown_radius: Array = quantity("m", Gt(0), "Crown radius of the profile, across the rolling direction")
    material: Material = component("Material of the wheel")

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class Cylinder:
    """Straight cylinder on which the wheel rolls."""

    radius: Array = quantity("m", Gt(0), "Cylinder radius R")
    material: Material = component("Material of the cylinder")

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)

    @property
    def curvatures(self) -> tuple[Array, Array]:
        """Along the circumference and along the axis. [1/m]"""
        return 1.0 / self.radius, 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Sphere:
    """Sphere on which the wheel rolls."""

    radius: Array = quantity("m", Gt(0), "Sphere radius")
    material: Material = component("Material of the sphere")

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)

    @property
    def curvatures(self) -> tuple[Array, Array]:
        """In any two directions. [1/m]"""
        return 1.0 / self.radius, 1.0 / self.radius


@dataclass(frozen=True, slots=True, kw_only=True)
class Plane:
    """Flat surface on which the wheel rolls."""

    material: Material = component("Material of the plane")

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)

    @property
    def curvatures(self) -> tuple[Array, Array]:
        """In any two directions. [1/m]"""
        return 0.0, 0.0


Surface = Cylinder | Sphere | Plane
"""What a wheel rolls on."""


def plane_strain_modulus(first: Material, second: Material) -> float:
    """E* of two bodies in contact; 1/E* is the sum of their plane-strain compliances. [Pa]

    Source: johnson1985, section 4.2.
    """
    return 1.0 / (first.plane_strain_compliance + second.plane_strain_compliance)
