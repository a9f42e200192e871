"""Springs and tubes that are bought from stock, as data sheets state them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

from annotated_types import Ge, Gt

from infinivar._core.array_namespace import Array, namespace
from infinivar._core.fields import check, component, given, quantity
from infinivar.errors import ParameterError, require
from infinivar.parts.structure.beams import STEEL_DENSITY, Section
from infinivar.units import show_in

SHEAR_MODULUS = 81.5e9
"""Of patented drawn spring wire (EN 10270-1). Stainless wire has 14 % less. [Pa]"""

_NOT_SPRUNG = 2.0
"""Coils that do not deflect: the closed ends of a compression spring, or the two hooks of an extension spring."""

DENSITIES = {"steel": STEEL_DENSITY, "aluminium": 2700.0}
"""Usual density of each metal; alloys of aluminium differ by 4 %. [kg m^-3]"""

_OTHER_METAL = 0.05
"""Relative difference of densities that alloys of one metal do not have."""

THINNEST = 0.005
"""Wall over radius below which an area of contact is no small part of it."""

_SAME = 1e-9
"""Relative difference of radii that only units can have made."""

_NONE = 1e-6
"""Wall over radius where a tube cannot be turned down to it: too thin for any load."""

Purpose = Literal["compression", "extension"]
Metal = Literal["steel", "aluminium"]


def wire_rate(wire: Array, coil: Array, coils: Array, modulus: Array = SHEAR_MODULUS) -> Array:
    r"""Stiffness of a helical spring of round wire.

    .. math:: k = \frac{G d^4}{8 D^3 n}

    Parameters
    ----------
    wire, coil : (...,) float   Diameter d of the wire and mean diameter D of the coils, > 0. [m]
    coils : (...,) float        Number n of the coils that deflect, > 0. [-]
    modulus : (...,) float      Shear modulus G. [Pa]

    Returns
    -------
    (...,) float   [N m^-1]

    Source: wahl1963.
    """
    return modulus * wire**4 / (8.0 * coil**3 * coils)


def wire_stress(force: Array, wire: Array, coil: Array) -> Array:
    r"""Shear stress in the wire of a helical spring, without the curvature of the wire, ``8 F D/(pi d^3)``. [Pa]

    Parameters and source as of `wire_rate`; force in N.
    """
    return 8.0 * force * coil / (math.pi * wire**3)


def coiled_mass(wire: Array, coil: Array, coils: Array, density: Array = STEEL_DENSITY) -> Array:
    r"""Mass of coiled round wire, ``rho pi^2 d^2 D n/4``.

    Parameters
    ----------
    wire, coil, coils : (...,) float   As of `wire_rate`, but all coils.
    density : (...,) float             [kg m^-3]

    Returns
    -------
    (...,) float   The pitch of the coils, of 1 % or less, is left out. [kg]

    Source: geometry.
    """
    return density * 0.25 * math.pi**2 * wire**2 * coil * coils


@dataclass(frozen=True, slots=True, kw_only=True)
class StockSpring:
    """Helical spring of round wire, as data sheets state it.

    Raises
    ------
    ParameterError
        If a field is outside its range; the message names field, value and unit. The wire must leave room within the coils.
    """

    name: str = component("Name for reports", default="spring")
    made_for: Purpose = component("compression or extension", default="compression")
    stiffness: float | None = quantity("N/m", Ge(0), "Stiffness of a spring from stock", default=None)
    permissible_force: float | None = quantity("N", Gt(0), "Permissible force at rest, a limit", default=None)
    initial_tension: float | None = quantity(
        "N", Ge(0), "Force below which an extension spring does not open", default=None
    )
    wire_diameter: float | None = quantity("m", Gt(0), "Diameter of the wire, for masses", default=None)
    outer_diameter: float | None = quantity("m", Gt(0), "Outer diameter of the coils, for masses", default=None)
    coils: float | None = quantity("1", Gt(0), "Number of coils that deflect, for masses", default=None)
    body_length: float | None = quantity(
        "m", Gt(0), "Length of the closed coils of an extension spring without load, for masses", default=None
    )
    free_length: float | None = quantity(
        "m", Gt(0), "Length without load; of an extension spring within its hooks", default=None
    )
    permissible_length: float | None = quantity("m", Gt(0), "Length under the permissible force", default=None)
    mass: float | None = quantity("kg", Gt(0), "Mass; by default that of its wire, of steel", default=None)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        check_coils(self)

    @property
    def weight(self) -> float:
        """Mass, by which springs are ordered: as stated, else of its wire; inf if neither is known. [kg]"""
        return given(stock_mass(self), math.inf)


def _mm(length: float) -> str:
    return show_in(length, "m", "mm")


def check_coils(spring: Any) -> None:
    """Raise ParameterError unless wire and coils of a stock spring fit each other."""
    wire, outer, body = spring.wire_diameter, spring.outer_diameter, spring.body_length
    if isinstance(wire, float) and isinstance(outer, float):
        require(outer > 2.0 * wire, "outer_diameter", _mm(outer), f"> {_mm(2.0 * wire)}, twice wire_diameter")
    if isinstance(wire, float) and isinstance(body, float):
        require(body > wire, "body_length", _mm(body), f"> {_mm(wire)}, wire_diameter")
    if spring.made_for == "compression":
        for name in ("initial_tension", "body_length"):
            if getattr(spring, name) is not None:
                raise ParameterError(f'{name} is of an extension spring: set made_for = "extension", or remove it')


def coils_of_body(length: Array, wire: Array) -> Array:
    """Coils that deflect of a body of closed coils: n of them are n + 1 wires long. [-]

    Source: geometry.
    """
    return length / wire - 1.0


def active_coils(spring: Any) -> Array | None:
    """Coils of a stock spring that deflect: as stated, else those of a body of closed coils; None if not known. [-]"""
    if spring.coils is not None or spring.body_length is None or spring.wire_diameter is None:
        return spring.coils
    return coils_of_body(spring.body_length, spring.wire_diameter)


def all_coils(active: Array) -> Array:
    """Coils with ends or hooks of a spring with a number of coils that deflect: two more. [-]

    Source: closed ends of compression springs, budynas2011, Table 10-1; hooks of extension springs, gutekunst2026.
    """
    return active + _NOT_SPRUNG


def stretch(spring: Any, force: Array) -> Array | None:
    """Deflection of a stock spring under a force beyond its initial tension; None if its stiffness is not known. [m]"""
    if not spring.stiffness:
        return None
    return (force - given(spring.initial_tension, 0.0)) / spring.stiffness


def stock_mass(spring: Any) -> Array | None:
    """Mass of a stock spring: as stated, else of its steel wire; None if neither is known. [kg]

    Source: `coiled_mass` and `all_coils`.
    """
    coils = active_coils(spring)
    if spring.mass is not None or coils is None or spring.wire_diameter is None or spring.outer_diameter is None:
        return spring.mass
    return coiled_mass(spring.wire_diameter, spring.outer_diameter - spring.wire_diameter, all_coils(coils))


@dataclass(frozen=True, slots=True, kw_only=True)
class StockTube:
    """Round tube, as data sheets state it.

    Raises
    ------
    ParameterError
        If a field is outside its range; the message names field, value and unit. The wall must be less than the radius.
    """

    name: str = component("Name for reports", default="tube")
    metal: Metal = component("steel or aluminium", default="steel")
    outer_diameter: float = quantity("m", Gt(0), "Outer diameter")
    wall: float = quantity("m", Gt(0), "Wall thickness")
    tube_density: float | None = quantity("kg/m", Gt(0), "Mass of the tube over its length", default=None)
    density: float | None = quantity("kg/m^3", Gt(0), "Density of the metal, where it is stated", default=None)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        half = 0.5 * self.outer_diameter
        if isinstance(self.wall, float) and isinstance(half, float):  # not while derivatives are taken
            require(self.wall < half, "wall", _mm(self.wall), f"< {_mm(half)}, half of outer_diameter")

    @property
    def weight(self) -> float:
        """Mass over the length: as stated, else of the usual density of its metal. [kg/m]"""
        return given(self.tube_density, self.metal_density * self.section.area)

    @property
    def section(self) -> Section:
        """Cross section."""
        return Section(0.5 * self.outer_diameter, 0.5 * self.outer_diameter - self.wall)

    @property
    def metal_density(self) -> float:
        """Of the metal: as stated, else what mass and section give, else usual. [kg m^-3]"""
        if self.density is None and self.tube_density is not None:
            return self.tube_density / self.section.area
        return given(self.density, DENSITIES[self.metal])

    @property
    def radii(self) -> tuple[float, float]:
        """Least and largest radius to which it can be turned down, of a wall that can carry a load. [m]"""
        return (0.5 * self.outer_diameter - self.wall) / (1.0 - THINNEST), 0.5 * self.outer_diameter

    def wall_at(self, radius: Array) -> Array:
        """Wall that is left of the tube, turned down to an outer radius; of many designs nearly none where it cannot be. [m]

        Raises
        ------
        ParameterError
            If a single radius is not within the wall.
        """
        inner, outer = 0.5 * self.outer_diameter - self.wall, 0.5 * self.outer_diameter * (1.0 + _SAME)
        if isinstance(radius, float) and isinstance(inner, float):
            if inner < radius <= outer:
                return radius - inner
            raise ParameterError(
                f"cylinder_radius must be > {_mm(inner)} and <= {_mm(outer)}, within the wall of cylinder_tube "
                f"({self.name}), got {_mm(radius)}"
            )
        xp = namespace(radius, inner)
        return xp.where((radius > inner) & (radius <= outer), radius - inner, _NONE * radius)

    def check_density(self, density: float | None) -> None:
        """Raise ParameterError unless a density can be that of the tube. [kg m^-3]"""
        own = self.metal_density
        if isinstance(density, float) and isinstance(own, float) and abs(density / own - 1.0) > _OTHER_METAL:
            raise ParameterError(
                f"geometry.cylinder_material must have a density within {100.0 * _OTHER_METAL:.0f} % of {own:.0f} kg/m^3, "
                f"that of cylinder_tube ({self.name}), got {density:.0f} kg/m^3"
            )
