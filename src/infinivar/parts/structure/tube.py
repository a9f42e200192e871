"""The tube on which wheels roll: its mass and inertia, and how it carries the preload between its end plates."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from annotated_types import Ge, Gt

from infinivar._core.array_namespace import Array, namespace
from infinivar._core.fields import check, component, quantity
from infinivar.contact.bodies import Material
from infinivar.errors import ParameterError
from infinivar.parts.structure import beams, shells
from infinivar.parts.structure.stock import THINNEST, StockTube
from infinivar.units import plain, show_in

THICKEST = 0.9
"""Wall over radius up to which, and from `THINNEST` on, `shells` has a meaning."""

SHORTEST, _LONGEST = 0.5, 20.0
"""Length over radius."""


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

    def demand(self, preload: Array, area: Array, count: int = 1) -> Array:
        """Tension under a wheel half way along over the yield strength, which must be known; inf where the wall does not fit. [-]

        Parameters as of `tension`, and the force of each wheel. [N]
        """
        stretched = preload * self.tension(0.5 * self.length, area, count) / self.material.yield_strength
        xp, share = namespace(stretched, self.radius, self.wall), self.wall / self.radius
        # Of many designs some may have a wall that does not fit their radius.
        return xp.where(xp.asarray((share >= THINNEST) & (share <= THICKEST)), stretched, xp.inf)

    @property
    def first_mode(self) -> Array | None:
        """First bending mode between the end plates; None if the density is not stated. [rad/s]"""
        material = self.material
        if material.density is None:
            return None
        ends = "supported-supported"
        return beams.critical_speed(self.section, self.length, ends, material.youngs_modulus, material.density)


def thinnest(tube: Tube, preload: Array, area: Array, margin: Array, count: int = 1) -> Array:
    """Least wall of a tube that carries a wheel half way along.

    Parameters
    ----------
    tube : Tube                     Its wall does not matter; the yield strength of its material must be known.
    preload, area, count            As of `Tube.demand`. [N], [m]
    margin : (...,) float           Wanted yield strength over tension, > 0. [-]

    Returns
    -------
    (...,) float   Between `THINNEST` and `THICKEST` times the radius; nan where even the thickest is too weak. [m]

    Source: `Tube.tension`, which falls nearly as a power of the wall: secants on logarithms.
    """
    import numpy as np

    radius, force = np.asarray(tube.radius, dtype=float), margin * preload / tube.material.yield_strength
    shape = np.broadcast_shapes(*map(np.shape, (radius, tube.length, force, area)))
    low, high = (np.broadcast_to(np.log(share * radius), shape) for share in (THINNEST, THICKEST))

    def excess(logarithm: np.ndarray) -> np.ndarray:
        return np.log(force * replace(tube, wall=np.exp(logarithm)).tension(0.5 * tube.length, area, count))

    # A wall as thick as a plate needs under a force on a small area, give or take a factor.
    before = np.clip(np.log(np.sqrt(np.broadcast_to(force, shape))), low, high - 0.2)
    at, slope, rose = before + 0.1, np.full(shape, -2.0), excess(before)
    for _ in range(_SECANTS):
        here, moved = excess(at), at - before
        slope = np.where(moved == 0.0, slope, np.clip((here - rose) / np.where(moved == 0.0, 1.0, moved), -4.0, -1.0))
        before, rose, at = at, here, np.clip(at - here / slope, low, high)
        if np.max(np.abs(at - before), initial=0.0) < 1e-7:  # the error is of the order of its power 1.6
            break
    return np.where((at >= high) & (excess(high) > 0.0), np.nan, np.exp(at))


_SECANTS = 30
"""Most steps; 6 suffice."""


def tube_of_cylinder(
    *,
    radius: Array,
    wall: Array | None,
    stock: StockTube | None = None,
    length: Array | None,
    end_plate: Array,
    material: Material | None,
) -> Tube | None:
    """The cylinder of a transmission as a tube; None if neither its wall nor the tube that it is made of is stated.

    Raises
    ------
    ParameterError
        If a value is missing or out of range; the message names the field of the transmission.
    """
    source = "cylinder_wall"
    if stock is not None:
        source = "cylinder_tube"
        if wall is not None:
            raise ParameterError("cylinder_wall must be removed: it follows from cylinder_tube and cylinder_radius")
        wall = stock.wall_at(radius)
    if wall is None:
        for name, value in (("cylinder_length", length), ("cylinder_end_plate", end_plate or None)):
            if value is not None:
                raise ParameterError(f"cylinder_wall is missing: {name} is of a tube")
        return None
    if length is None:
        raise ParameterError(f"cylinder_length is missing: {source} needs it")
    for name, value, low, high in (
        ("cylinder_wall", wall, THINNEST, THICKEST),
        ("cylinder_length", length, SHORTEST, _LONGEST),
        ("cylinder_end_plate", end_plate, 0.0, 1.0),
    ):
        alone = isinstance(value, (int, float)) and isinstance(radius, (int, float))
        if alone and not low * radius <= value <= high * radius:
            ends = " to ".join(show_in(share * radius, "m", "mm") for share in (low, high))
            raise ParameterError(
                f"{name} must be {ends}, {plain(low)} to {plain(high)} times cylinder_radius, "
                f"got {show_in(value, 'm', 'mm')}"
            )
    if material is None:
        raise ParameterError(f"geometry is missing: it states the material of the cylinder, which {source} needs")
    if stock is not None:
        stock.check_density(material.density)
    return Tube(radius=radius, wall=wall, length=length, end_plate=end_plate, material=material)
