"""What both architectures have in common: motors, guideway, frame, springs and linkage, and how parts are chosen.

Left out of both alike: mounts, couplings, fasteners, covers, cables, sensors and electronics.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from infinivar._core.array_namespace import Array, as_floats, is_number, namespace
from infinivar._core.fields import given
from infinivar.contact.bodies import Material
from infinivar.drivetrain.body import Body
from infinivar.drivetrain.output import Output
from infinivar.drivetrain.service import Service
from infinivar.parts import catalogue
from infinivar.parts.bearing import Bearing
from infinivar.parts.spring import TorsionSpring
from infinivar.parts.structure import bodies
from infinivar.parts.structure.beams import STEEL_DENSITY, STEEL_MODULUS
from infinivar.parts.structure.stock import StockSpring, stock_mass
from infinivar.parts.structure.structure import Structure
from infinivar.units import show, show_in

_SHEAR_MODULUS = STEEL_MODULUS / 2.6
_RAIL = ("carriage_mass", "rail_density", "width", "height", "carriage_length", "static_rating")
_BEARING = ("weight", "breadth", "outside_diameter", "bore", "static_rating")


class Frame(NamedTuple):
    """Sizes of a frame: a bar along the rail, and plates from the back of the rail to an axis and beyond; [m] each."""

    length: Array
    width: Array
    height: Array
    """Of the bar."""
    reach: Array
    """From the axis to the back of the rail."""
    beyond: Array
    """From the axis to the far edge of a plate."""
    across: Array
    """Width of a plate."""
    thickness: Array
    """Of a plate."""
    plates: int
    """How many."""


class Load(NamedTuple):
    """Largest load on a bearing or carriage; [N] each."""

    body: str
    part: str
    radial: float
    """Across a shaft, or on a carriage towards its rail."""
    axial: float
    """Along a shaft."""
    static_rating: float
    margin: float
    """Static rating over equivalent static load. [-]"""


class Building:
    """Makes the bodies of a drive; what depends on missing values is not known."""

    def __init__(self, drive: Any, service: Service) -> None:
        """A drive, whose values may be arrays of many designs, and what it has to do."""
        self.drive, self.service = drive, service
        self.structure: Structure = drive.structure

    @property
    def metal(self) -> Material:
        """Material of frame, bell, pulleys and linkage."""
        return given(self.structure.material, catalogue.parts("materials")["al-7075-t6"])

    def __iter__(self) -> Iterator[Body]:
        """Every body, motors first."""
        yield from self.motors()
        yield _bought("gearhead", self.drive.gearhead)
        yield from self.own()
        yield from self.output(self.drive.output)

    def motors(self) -> Iterator[Body]:
        """The motors; that which steers moves with the link."""
        for role, motor in self.drive.motors.items():
            name = "motor" if role == "motor" else f"{role} motor"
            yield _bought(name, motor, moving=role == "steering")

    def own(self) -> Iterator[Body]:
        """Bodies of the architecture."""
        raise NotImplementedError

    def loads(self) -> Iterator[Load]:
        """Loads on bearings and rail of one design, as far as they are known."""
        raise NotImplementedError

    def on_rail(self) -> Load:
        """The load of the carriage on its rail."""
        load, rail = self.carried, self.rail
        return Load("carriage", str(rail["name"]), load, 0.0, rail["static_rating"], rail["static_rating"] / load)

    def body(self, name: str, mass: Array | None, basis: str, *, key: str | None = None, moving: bool = False) -> Body:
        """A derived body, unless its mass is stated."""
        stated = getattr(self.structure, f"{key or name}_mass")
        if stated is not None:
            return Body(name, stated, "stated", "as stated", moving)
        # Of many designs alike those that no part carries are nan; one design says so.
        if mass is not None and is_number(mass):
            mass = float(mass)
            if math.isnan(mass):
                return Body(name, None, "derived", "what it depends on is not known", moving)
        return Body(name, mass, "derived", basis, moving)

    def bearings(self, name: str, count: int, held: Mapping[str, Any], own: Bearing | None, load: Array) -> Body:
        """Equal bearings that a drive states, or not."""
        made = self.body(name, count * held["weight"], f"{count} x {held.get('name')}", key="bearings")
        if made.kind == "stated":
            return made
        if own is not None:
            return made._replace(kind=kind_of(own), basis=f"{count} x {own.name}")
        return _chosen_part(made, held, "bearing", load)

    def carriage(self) -> Body:
        """That of the guideway."""
        rail = self.rail
        made = self.body(
            "carriage", rail["carriage_mass"], f"{rail.get('name')}, {mm(rail['width'])} wide", moving=True
        )
        return _chosen_part(made, rail, "rail", self.structure.rail_margin * self.carried)

    def rail_body(self) -> Body:
        """The rail of the guideway."""
        if self.service.travel is None:
            return self.body("rail", None, UNKNOWN)
        rail, length = self.rail, self.rail_length
        made = self.body("rail", rail["rail_density"] * length, f"{mm(length)} of {rail.get('name')}")
        return _chosen_part(made, rail, "rail", self.structure.rail_margin * self.carried)

    @property
    def rail_length(self) -> Array:
        """Travel, carriage, and room at both ends. [m]"""
        xp = namespace(self.rail["carriage_length"], self.guided)
        guided = xp.maximum(*as_floats(xp, self.rail["carriage_length"], self.guided))
        return given(self.service.travel, math.nan) + guided + 2.0 * self.structure.room

    @property
    def guided(self) -> Array:
        """Length of what else moves between the ends of the rail. [m]"""
        return 0.0

    @property
    def carried(self) -> Array:
        """Load of the carriage on its rail. [N]"""
        raise NotImplementedError

    @functools.cached_property
    def rail(self) -> Mapping[str, Any]:
        """Sizes of the rail: as stated for the guideway, else the lightest that carries the load."""
        own = getattr(self.drive.guideway, "rail", None)
        if own is not None:
            return {name: getattr(own, name) for name in (*_RAIL, "name")}
        return catalogue.lightest("rails", self.structure.rail_margin * self.carried, _RAIL)

    def frame(self) -> Body:
        """A bar under the rail, and plates that reach from it to bearings."""
        metal, frame = self.metal, self.sizes()
        if frame is None or metal.density is None:
            return self.body("frame", None, "density and yield strength of structure.material are missing")
        plates = frame.plates * frame.thickness * frame.across * (frame.reach + frame.beyond)
        mass = metal.density * (frame.width * frame.height * frame.length + plates)
        bar = f"bar of {mm(frame.length)}, {mm(frame.width)} x {mm(frame.height)}"
        return self.body("frame", mass, f"{bar}, and {frame.plates} plates of {mm(frame.reach)} to the axis")

    def sizes(self) -> Frame | None:
        """Of the frame; None where they are not known."""
        raise NotImplementedError

    def bar(self, force: Array, moment: Array, span: Array, width: Array) -> Array | None:
        """Height of the bar under the rail, for a force at its middle and a moment; None where not known. [m]"""
        metal = self.metal
        if metal.yield_strength is None:
            return None
        height = bodies.bar_height(
            force,
            moment,
            span,
            width,
            modulus=metal.youngs_modulus,
            sag=self.structure.frame_deflection * span,
            strength=metal.yield_strength / self.structure.strength_margin,
        )
        xp = namespace(height)
        return xp.maximum(height, xp.asarray(self.structure.least_wall))

    def output(self, output: Output) -> Iterator[Body]:
        """Linkage and springs between drive and load."""
        structure, metal, force = self.structure, self.metal, self.service.force
        if output.linkage is not None:
            arm, mass = output.linkage.arm, None
            if arm is not None and force is not None and metal.density and metal.yield_strength:
                # A bar twice as high as wide: W = h^3/12.
                height = (12.0 * force * arm * structure.strength_margin / metal.yield_strength) ** (1.0 / 3.0)
                mass = metal.density * 0.5 * height**2 * arm
            yield self.body("linkage", mass, "an arm that carries the largest force" if mass is not None else _OPEN)
        springs = [place for place in output.chain if place.kind in ("series", "parallel")]
        if springs:
            yield self._springs(springs)

    def _springs(self, places: Sequence[Any]) -> Body:
        """Springs from stock, and wire for the energy that others store."""
        stored = self.service.energies
        known = {place.name: mass for place in places if (mass := bought_spring(place.part)) is not None}
        made = [place for place in places if place.name not in known]
        if any(place.name not in stored for place in made):
            return self.body("springs", None, "no motion states their energy")
        masses = [*known.values(), *(self._wire(stored[place.name], place.part) for place in made)]
        words = [place.part.name for place in places if place.name in known]
        words += ["wire for the energy stored"] if made else []
        body = self.body("springs", sum(masses), " and ".join(words))
        if made or body.kind == "stated":
            return body
        return body._replace(kind="derived" if any(kind_of(one.part) == "derived" for one in places) else "catalogue")

    def _wire(self, energy: Array, spring: Any = None) -> Array:
        bent = isinstance(spring, TorsionSpring)
        modulus = STEEL_MODULUS if bent else _SHEAR_MODULUS
        return bodies.wire_mass(energy, self.structure.spring_strength, modulus, STEEL_DENSITY, bent=bent)


_OPEN = "its arm or its load is not known"
UNKNOWN = "travel is missing: state it in [requirement] (angle about a joint), or as structure.travel"


def bought_spring(part: Any) -> Array | None:
    """Mass of a spring from stock; None of one that is made, or whose mass is not known. [kg]"""
    return stock_mass(part) if hasattr(part, "wire_diameter") else None


def held_by(own: Bearing | None, load: Array) -> Mapping[str, Array]:
    """Sizes of a bearing: its own, else of the lightest that carries the load."""
    if own is not None:
        return {name: getattr(own, name) for name in _BEARING}
    return catalogue.lightest("bearings", load, _BEARING)


def _bought(name: str, part: Any, *, moving: bool = False) -> Body:
    # Parts of other packages need not have a mass or a name.
    mass, title = getattr(part, "mass", None), getattr(part, "name", type(part).__name__)
    basis = title if mass is not None else f"{title}: the mass is not stated"
    return Body(name, mass, "catalogue", basis, moving, chosen=True)


def load_on(body: str, bearing: Bearing, radial: Array, axial: Array) -> Load:
    """A radial and an axial load on a bearing [N]."""
    rating, margin = bearing.static_rating, float(bearing.static_safety(radial, axial))
    return Load(body, bearing.name, float(radial), float(axial), rating, margin)


def _chosen_part(made: Body, part: Mapping[str, Any], what: str, load: Array) -> Body:
    """A body that is a part of the catalogue, where it is for a single load."""
    if "name" not in part or made.kind == "stated":
        return made
    if part["name"] is None:
        return made._replace(mass=None, basis=f"no {what} of the catalogue carries {show(float(load), 'N', 3)}")
    return made if made.mass is None else made._replace(kind="catalogue")


def kind_of(part: Bearing | StockSpring) -> str:
    """Where the mass of a bearing or spring is from."""
    return "derived" if part.mass is None else "catalogue"


def mm(value: Array) -> str:
    """A length in words; "" for many designs, and where its value is not known yet."""
    return show_in(float(value), "m", "mm", 3) if is_number(value) else ""
