"""The tube on which wheels roll: its mass and inertia, and how it carries the preload between its end plates."""

from __future__ import annotations

import math
from dataclasses import dataclass

from annotated_types import Ge, Gt

from infinivar._core.array_namespace import Array
from infinivar._core.fields import check, component, quantity
from infinivar.contact.bodies import Material
from infinivar.parts.structure import beams, shells


@dataclass(frozen=True, slots=True, kw_only=True)
class Tube:
    """Tube with two end plates, which its bearings hold. Values may be arrays of many designs.

    Raises
    ------
    ParameterError
        If a field is outside its range; the message names field, value and unit. The wall must be less than the radius.
    """

    radius: Array = quantity("m", Gt(0), "Outer radius R, on which the wheel rolls")
    wall: Array = quantity("m", Gt(0), "Wall thickness t")
    length: Array = quantity("m", Gt(0), "Length L between the end plates")
    end_plate: Array = quantity("m", Ge(0), "Thickness of each end plate; 0 without", default=0.0)
    material: Material = component("Material of tube and end plates")

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)

    @property
    def section(self) -> beams.Section:
        """Cross section of the tube."""
        return beams.Section(self.radius, self.radius - self.wall)

    @property
    def shell(self) -> shells.Wall:
        """The wall as a shell."""
        return shells.Wall(
            self.radius - 0.5 * self.wall,
            self.wall,
            self.length,
            self.material.youngs_modulus,
            self.material.poisson,
        )

    @property
    def mass(self) -> Array | None:
        """Of tube and end plates; None if the density of the material is not stated. [kg]"""
        density = self.material.density
        if density is None:
            return None
        plates = 2.0 * math.pi * self.radius**2 * self.end_plate
        return density * (self.section.area * self.length + plates)

    @property
    def inertia(self) -> Array | None:
        """About the axis; None if the density of the material is not stated. [kg m^2]"""
        density = self.material.density
        if density is None:
            return None
        # About its axis, a section has twice the second moment of area about a diameter.
        return (
            2.0
            * density
            * (
                self.section.second_moment * self.length
                + 2.0 * beams.Section(self.radius).second_moment * self.end_plate
            )
        )

    def bending(self, place: Array) -> Array:
        """Deflection by bending and shear under a force at a place from one end plate [m], over the force. [m/N]"""
        return shells.bend(self.shell, place)

    def ovalisation(self, place: Array, count: int = 1) -> Array:
        """What the wall gives way under `count` equal forces evenly around, beyond bending, over one. [m/N]"""
        return shells.give(self.shell, place, count)

    def tension(self, place: Array, area: Array, count: int = 1) -> Array:
        """Largest tensile stress at the inside of the wall under the same forces on areas of a radius [m], over one. [Pa/N]"""
        return shells.tension(self.shell, place, area, count)

    @property
    def first_mode(self) -> Array | None:
        """First bending mode between the end plates; None if the density is not stated. [rad/s]"""
        material = self.material
        if material.density is None:
            return None
        ends = "supported-supported"
        return beams.critical_speed(self.section, self.length, ends, material.youngs_modulus, material.density)
