"""How a drive is built: every body of both architectures, bought or derived from what it has to carry.

Left out of both alike: mounts, couplings, fasteners, covers, cables, sensors and electronics.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from infinivar._core.array_namespace import Array, as_floats, namespace
from infinivar._core.fields import given
from infinivar.contact.bodies import Material
from infinivar.drivetrain.body import Body
from infinivar.drivetrain.output import Output
from infinivar.drivetrain.service import Service
from infinivar.parts import catalogue
from infinivar.parts.bearing import Bearing, ring_mass
from infinivar.parts.shaft_bearings import WheelLoad, spread
from infinivar.parts.spring import TorsionSpring
from infinivar.parts.structure import beams, bodies
from infinivar.parts.structure.beams import STEEL_DENSITY, STEEL_MODULUS
from infinivar.parts.structure.structure import Structure
from infinivar.parts.structure.tube import THICKEST, Tube, thinnest
from infinivar.units import show, show_in

_SHEAR_MODULUS = STEEL_MODULUS / 2.6
_SECTION, _THIN = 6e-3, 7e-3
"""Radial and axial size of a thin bearing around the bell: series 618 from 20 to 45 mm of bore. [m]"""
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
        if mass is not None and namespace(mass).__name__ == "numpy" and getattr(mass, "ndim", 0) == 0:
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
            return made._replace(kind=_kind(own), basis=f"{count} x {own.name}")
        return _chosen_part(made, held, "bearing", load)

    def carriage(self) -> Body:
        """That of the guideway."""
        rail = self.rail
        made = self.body(
            "carriage", rail["carriage_mass"], f"{rail.get('name')}, {_mm(rail['width'])} wide", moving=True
        )
        return _chosen_part(made, rail, "rail", self.structure.rail_margin * self.carried)

    def rail_body(self) -> Body:
        """The rail of the guideway."""
        if self.service.travel is None:
            return self.body("rail", None, _UNKNOWN)
        rail, length = self.rail, self.rail_length
        made = self.body("rail", rail["rail_density"] * length, f"{_mm(length)} of {rail.get('name')}")
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
        bar = f"bar of {_mm(frame.length)}, {_mm(frame.width)} x {_mm(frame.height)}"
        return self.body("frame", mass, f"{bar}, and {frame.plates} plates of {_mm(frame.reach)} to the axis")

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
            stored = self.service.energies
            known = all(place.name in stored for place in springs)
            mass = sum(self._wire(stored[place.name], place.part) for place in springs) if known else None
            yield self.body("springs", mass, "wire for the energy stored" if known else "no motion states their energy")

    def _wire(self, energy: Array, spring: Any = None) -> Array:
        bent = isinstance(spring, TorsionSpring)
        modulus = STEEL_MODULUS if bent else _SHEAR_MODULUS
        return bodies.wire_mass(energy, self.structure.spring_strength, modulus, STEEL_DENSITY, bent=bent)


_NO_GEOMETRY = "transmission.geometry is missing"
_OPEN = "its arm or its load is not known"
_UNKNOWN = "travel is missing: state it in [requirement] (angle about a joint), or as structure.travel"


class CoboticBuilding(Building):
    """See `Building`."""

    def own(self) -> Iterator[Body]:
        """See `Building.own`."""
        drive, element = self.drive, self.drive.transmission
        geometry = element.geometry
        if geometry is None:
            yield self.body("cylinder", None, _NO_GEOMETRY)
            yield from self.moving()
            yield self.body("rail", None, _NO_GEOMETRY)
            yield self.body("frame", None, _NO_GEOMETRY)
            return
        tube = self.tube
        own = None if drive.cylinder_bearings is None else drive.cylinder_bearings.bearing
        yield self.body("cylinder", None if tube is None else tube.mass, self._words())
        yield self.bearings("cylinder bearings", 2, self.held, own, self.carried)
        yield from self.moving()
        yield self.rail_body()
        yield self.body("frame", None, self._words()) if tube is None else self.frame()

    def loads(self) -> Iterator[Load]:
        """See `Building.loads`: under the slip force, and with the wheel at the ends of the travel, or beside a bearing."""
        element, drive, force = self.drive.transmission, self.drive, given(self.service.force, 0.0)
        preload, geometry, support = element.preload, element.geometry, drive.cylinder_bearings
        if geometry is None:
            return
        axle = geometry.axle
        for name, (radial, axial) in zip(
            ("axle bearing, first", "axle bearing, second"),
            axle.loads(preload, geometry.lateral_share * element.wheel.slip_force, element.wheel_radius),
            strict=True,
        ):
            yield _load(name, axle.bearing, radial, axial)
        if self.own_bell_bearing is not None:
            yield _load("bell bearing", self.own_bell_bearing, force / element.wheels, preload)
        stated = None if support is None else support.bearing
        found = [(self.carried, force), (self.carried, 0.0)]
        if support is not None and support.span is not None and self.service.travel is not None:
            travels = (-0.5 * self.service.travel, 0.5 * self.service.travel)
            wheels = [
                WheelLoad(preload, 0.0, sign * force, element.cylinder_radius, end)
                for end in travels
                for sign in (1, -1)
            ]
            ends = [support.reactions(spread(wheel, element.wheels)) for wheel in wheels]
            found = [tuple(max(float(one[place][of]) for one in ends) for of in (0, 1)) for place in (0, 1)]
        bearing = stated or catalogue.lightest_part("bearings", self.carried)
        for name, (radial, axial) in zip(("cylinder bearing, first", "cylinder bearing, second"), found, strict=True):
            if bearing is not None:
                yield _load(name, bearing, radial, axial)
        if self.carried > 0.0:
            yield self.on_rail()

    @functools.cached_property
    def held(self) -> Mapping[str, Any]:
        """Sizes of a bearing of the cylinder, beside which the wheel may stand."""
        stated = self.drive.cylinder_bearings
        return _held(None if stated is None else stated.bearing, self.carried)

    def sizes(self) -> Frame | None:
        """See `Building.sizes`; the preload presses on the middle of the bar."""
        tube = self.tube
        if tube is None:
            return None
        element, structure, held = self.drive.transmission, self.structure, self.held
        rail, stated = self.rail, self.drive.cylinder_bearings
        span = given(None if stated is None else stated.span, tube.length + 2.0 * tube.end_plate + held["breadth"])
        if self.service.travel is not None:  # what turns with the bell swings between the plates, at both ends
            xp = namespace(span, *self.bell, rail["carriage_length"])
            bell, carriage, span = as_floats(xp, self.bell_bearing_sizes()[0], rail["carriage_length"], span)
            swing = xp.maximum(xp.maximum(bell, carriage), 2.0 * self.bell.outer)
            span = xp.maximum(span, self.service.travel + swing + 2.0 * structure.room + held["breadth"])
        height = self.bar(element.unbalanced_preload, 0.0, span, rail["width"])
        if height is None:
            return None
        across = held["outside_diameter"] + 4.0 * structure.least_wall
        reach = element.cylinder_radius + element.wheel_radius + self.top + rail["height"]
        ring = self.ring()
        reach = reach if ring is None else reach + ring[1]
        return Frame(span, rail["width"], height, reach, 0.5 * across, across, held["breadth"], 2)

    def moving(self) -> Iterator[Body]:
        """What moves with the link, but the steering motor."""
        element = self.drive.transmission
        geometry = element.geometry
        if geometry is None:
            yield self.body("wheel", None, _NO_GEOMETRY, moving=True)
            yield self.body("bell", None, _NO_GEOMETRY, moving=True)
            return
        axle: Bearing = geometry.axle_bearing
        yield self._wheel()
        count, many = element.wheels, self._many
        yield Body("axle bearings", 2.0 * count * axle.weight, _kind(axle), many(axle.name, 2), True)
        yield self._ring()
        yield self._bell_bearing()
        energy = 0.5 * element.preload * self.structure.spring_deflection
        wire = count * self._wire(energy)
        yield Body("preload spring", wire, "derived", many("wire for the energy stored"), True)
        if count > 1:
            yield self._closing()
        yield self.carriage()

    def _wheel(self) -> Body:
        """Wheel and axle."""
        element, bell = self.drive.transmission, self.bell
        geometry = element.geometry
        axle: Bearing = geometry.axle_bearing
        rod = math.pi * 0.25 * axle.bore**2 * (bell.span + axle.breadth - geometry.wheel_width)
        density = geometry.wheel_material.density
        solid = bodies.crowned_volume(element.wheel_radius, geometry.crown_radius, geometry.wheel_width)
        words = f"{_mm(2.0 * element.wheel_radius)} x {_mm(geometry.wheel_width)}, and its axle"
        if density is None:
            words = "density of transmission.geometry.wheel_material is missing"
        mass = None if density is None else element.wheels * density * (solid + rod)
        return self.body("wheel", mass, words if density is None else self._many(words), moving=True)

    def _ring(self) -> Body:
        """The bell itself."""
        metal, bell = self.metal, self.bell
        mass = None if metal.density is None else self.drive.transmission.wheels * metal.density * bell.volume
        words = self._many(f"ring of {_mm(2.0 * bell.outer)}, {_mm(bell.drop + bell.rise)} high")
        return self.body("bell", mass, words, moving=True)

    def _many(self, words: str, each: int = 1) -> str:
        """Words for what each of several wheels has."""
        count = self.drive.transmission.wheels
        return words if count == 1 else f"{each * count} x {words}"

    @property
    def carried(self) -> Array:
        """On rail, carriage and cylinder bearings: the preload, or the link's force where wheels hold each other. [N]"""
        element = self.drive.transmission
        return element.preload if element.wheels == 1 else given(self.service.force, 0.0)

    def ring(self) -> tuple[Array, Array, Array] | None:
        """Mean radius, thickness and width of the ring that holds several wheels; None where not known. [m] each

        Source: `infinivar.parts.structure.bodies.ring_thickness`; it passes the outer faces of the bells.
        """
        element, metal = self.drive.transmission, self.metal
        if element.wheels == 1 or metal.yield_strength is None:
            return None
        strength = metal.yield_strength / self.structure.strength_margin
        outside, _ = self.bell_bearing_sizes()
        radius = element.cylinder_radius + element.wheel_radius + self.top
        thick = bodies.ring_thickness(element.preload, radius, element.wheels, outside, strength)
        xp = namespace(thick)
        # Its inner face rests on the bells.
        thick = xp.maximum(xp.asarray(thick), xp.asarray(self.structure.least_wall))
        return radius + 0.5 * thick, thick, outside

    def _closing(self) -> Body:
        """Ring that closes the path of the preloads around the cylinder."""
        ring, density = self.ring(), self.metal.density
        if ring is None or density is None:
            missing = "density and yield strength of structure.material are missing"
            return self.body("carriage ring", None, missing, key="ring", moving=True)
        radius, thick, width = ring
        volume = bodies.ring_volume(radius - 0.5 * thick, thick, width)
        words = f"ring of {_mm(2.0 * radius)}, {_mm(thick)} thick, {_mm(width)} wide"
        return self.body("carriage ring", density * volume, words, key="ring", moving=True)

    @property
    def inertia(self) -> Array | None:
        """See `bell_inertia`."""
        axle, bell = self.drive.transmission.geometry.axle_bearing, self.bell
        wheel, ring = self._wheel().mass, self._ring().mass
        if wheel is None or ring is None:
            return None
        # The axle is a small part of what it carries, and counts as if it were the wheel.
        wheel, ring = wheel / (count := self.drive.transmission.wheels), ring / count  # masses are of all
        wheel = wheel * (0.25 * bell.wheel_radius**2 + bell.wheel_width**2 / 12.0)
        return ring * bell.second_moment / bell.volume + wheel + 0.5 * axle.weight * bell.span**2

    @functools.cached_property
    def tube(self) -> Tube | None:
        """The cylinder: as stated, else the thinnest tube as long as the travel needs; None where this is not known."""
        element, travel = self.drive.transmission, self.service.travel
        if element.tube is not None or travel is None:
            return element.tube
        geometry, contact = element.geometry, element.contact
        material = geometry.cylinder_material
        if contact is None or material.yield_strength is None or material.density is None:
            return None
        tube = Tube(
            radius=element.cylinder_radius,
            wall=self.structure.least_wall,
            length=travel + geometry.wheel_width + 2.0 * self.structure.room,
            end_plate=self.structure.least_wall,
            material=material,
        )
        patch = (contact.patch.a * contact.patch.b) ** 0.5
        wall = thinnest(tube, element.preload, patch, self.structure.strength_margin, element.wheels)
        xp = namespace(wall)
        wall = xp.minimum(xp.maximum(wall, xp.asarray(self.structure.least_wall)), THICKEST * element.cylinder_radius)
        if wall.ndim == 0 and math.isnan(wall):
            return None
        return Tube(
            radius=tube.radius,
            wall=float(wall) if wall.ndim == 0 else wall,
            length=tube.length,
            end_plate=tube.end_plate,
            material=material,
        )

    @property
    def lacking(self) -> str:
        """Why cylinder or frame are not known."""
        if self.drive.transmission.geometry is None:
            return _NO_GEOMETRY
        return "density or yield strength of structure.material is missing" if self.tube else self._words()

    def _words(self) -> str:
        """What the cylinder is, or what is missing."""
        if self.tube is not None:
            return _tube_words(self.tube)
        if self.service.travel is None:
            return _UNKNOWN
        lacking = [
            name
            for name in ("density", "yield_strength")
            if getattr(self.drive.transmission.geometry.cylinder_material, name) is None
        ]
        if lacking:
            verb = "are" if len(lacking) > 1 else "is"
            return f"{' and '.join(lacking)} of transmission.geometry.cylinder_material {verb} missing"
        return f"no wall carries {show(float(self.drive.transmission.preload), 'N', 3)}"

    @functools.cached_property
    def bell(self) -> bodies.Bell:
        """The bell around the wheel."""
        element = self.drive.transmission
        geometry = element.geometry
        return bodies.Bell(
            wheel_radius=element.wheel_radius,
            wheel_width=geometry.wheel_width,
            bearing_diameter=geometry.axle_bearing.outside_diameter,
            bearing_width=geometry.axle_bearing.breadth,
            wall=self.structure.least_wall,
        )

    @property
    def own_bell_bearing(self) -> Bearing | None:
        """The bearing of the bell, if it is stated."""
        return None if self.drive.steering is None else self.drive.steering.bell_bearing

    def _bell_bearing(self) -> Body:
        count, own = self.drive.transmission.wheels, self.own_bell_bearing
        if own is not None:
            return Body("bell bearing", count * own.weight, _kind(own), self._many(own.name), True)
        outside, thickness = self.bell_bearing_sizes()
        mass = count * ring_mass(outside - 2.0 * _SECTION, outside, thickness)
        return Body("bell bearing", mass, "derived", self._many("thin, around the bell"), True)

    @property
    def top(self) -> Array:
        """From the axis of the wheel to the carriage: a stated bearing stands on the bell, a thin one around it. [m]"""
        own = self.own_bell_bearing
        return self.bell.rise + (0.0 if own is None else own.breadth)

    def bell_bearing_sizes(self) -> tuple[Array, Array]:
        """Outside diameter and width of the bearing around the bell, as stated or of a thin one. [m], [m]"""
        own = self.own_bell_bearing
        if own is not None:
            return own.outside_diameter, own.breadth
        return 2.0 * (self.bell.outer + _SECTION), _THIN


class GearedBuilding(Building):
    """See `Building`."""

    def own(self) -> Iterator[Body]:
        """See `Building.own`."""
        stage, force = self.drive.stage, self.service.force
        names = {stage.title: "stage", f"{stage.title} bearings": "bearings", "rail": "rail", "frame": "frame"}
        if stage.title == "shaft":  # what turns a joint is bought whole
            return
        lacking = _UNKNOWN if self.service.travel is None or force is None else None
        if stage.title not in ("pulley", "belt", "rack", "screw"):
            lacking = f"what a {stage.title} weighs is not known"
        if lacking is not None or force is None:
            for name, key in names.items():
                yield self.body(name, None, lacking or _UNKNOWN, key=key)
            return
        own = getattr(stage, "bearings", None)
        bearing = None if own is None else own.bearing
        yield self._stage()
        yield self.bearings(f"{stage.title} bearings", 4 if self.belted else 2, self.held, bearing, 0.5 * self.pull)
        yield self.carriage()
        yield self.rail_body()
        yield self.frame()

    def loads(self) -> Iterator[Load]:
        """See `Building.loads`."""
        stage, force = self.drive.stage, self.service.force
        if stage.title == "shaft" or force is None:
            return
        own = getattr(stage, "bearings", None)
        bearing = (None if own is None else own.bearing) or catalogue.lightest_part("bearings", 0.5 * self.pull)
        if bearing is not None:
            along = stage.title == "screw"  # one of its bearings takes the thrust
            yield _load(f"{stage.title} bearing", bearing, 0.0 if along else 0.5 * self.pull, force if along else 0.0)
        yield self.on_rail()

    @property
    def carried(self) -> Array:
        """See `Building.carried`. [N]"""
        return given(self.service.force, math.nan)

    @property
    def belted(self) -> bool:
        """Whether a belt or cable runs around two pulleys, each between two bearings."""
        return self.drive.stage.title in ("pulley", "belt")

    @property
    def pull(self) -> Array:
        """Largest on both bearings of a shaft together, or along a screw. [N]"""
        own = getattr(self.drive.stage, "bearings", None)
        if not self.belted:
            return self.carried
        return self.structure.pull_ratio * self.carried if own is None or own.pull is None else own.pull

    @functools.cached_property
    def held(self) -> Mapping[str, Any]:
        """Sizes of a bearing of the stage."""
        own = getattr(self.drive.stage, "bearings", None)
        return _held(None if own is None else own.bearing, 0.5 * self.pull)

    @property
    def guided(self) -> Array:
        """See `Building.guided`: the nut."""
        stage = self.drive.stage
        return self.structure.nut_ratio * stage.diameter if stage.title == "screw" else 0.0

    @property
    def offset(self) -> Array:
        """From the axis of pulley, pinion or screw to the top of the carriage. [m]"""
        stage = self.drive.stage
        if stage.title == "screw":
            return stage.diameter  # of the nut, twice as thick
        return stage.travel_per_radian + (self.structure.pulley_width if stage.title == "rack" else 0.0)

    def sizes(self) -> Frame | None:
        """See `Building.sizes`; the pull at the axis bends the bar along its whole length."""
        held, rail = self.held, self.rail
        reach, across = self.offset + rail["height"], held["outside_diameter"] + 4.0 * self.structure.least_wall
        length = self.rail_length
        if self.belted:  # the carriage stops between the plates, and the pulleys do not touch
            apart = 2.0 * self.drive.stage.travel_per_radian + self.structure.least_wall
            xp = namespace(length, across, apart)
            length = xp.maximum(*as_floats(xp, length + across, apart))
        height = self.bar(0.0, self.pull * reach, length, rail["width"])
        if height is None:
            return None
        beyond, count = 0.5 * held["outside_diameter"], 4 if self.belted else 2
        return Frame(length, rail["width"], height, reach, beyond, across, held["breadth"], count)

    def _stage(self) -> Body:
        """Pulleys and cable, belt, rack and pinion, or screw and nut."""
        stage, structure, length = self.drive.stage, self.structure, self.rail_length
        if stage.title == "screw":
            nut = self.guided
            thread = beams.Section(0.5 * stage.diameter).area * given(stage.length, length)
            around = beams.Section(stage.diameter, 0.5 * stage.diameter).area * nut
            basis = f"thread of {_mm(stage.diameter)}, and nut"
            return self.body("screw", STEEL_DENSITY * (thread + around), basis, key="stage")
        radius, width = stage.travel_per_radian, structure.pulley_width
        disc = math.pi * radius**2 * width
        if stage.title == "rack":
            basis = f"pinion of {_mm(2.0 * radius)}, and rack"
            return self.body("rack", STEEL_DENSITY * (width**2 * length + disc), basis, key="stage")
        if self.metal.density is None:
            return self.body(stage.title, None, "density of structure.material is missing", key="stage")
        strand = structure.belt_density * (2.0 * length + 2.0 * math.pi * radius)
        basis = f"two of {_mm(2.0 * radius)}, and belt or cable"
        return self.body(stage.title, 2.0 * disc * self.metal.density + strand, basis, key="stage")


def _held(own: Bearing | None, load: Array) -> Mapping[str, Array]:
    """Sizes of a bearing: its own, else of the lightest that carries the load."""
    if own is not None:
        return {name: getattr(own, name) for name in _BEARING}
    return catalogue.lightest("bearings", load, _BEARING)


def _bought(name: str, part: Any, *, moving: bool = False) -> Body:
    # Parts of other packages need not have a mass or a name.
    mass, title = getattr(part, "mass", None), getattr(part, "name", type(part).__name__)
    basis = title if mass is not None else f"{title}: the mass is not stated"
    return Body(name, mass, "catalogue", basis, moving, chosen=True)


def _load(body: str, bearing: Bearing, radial: Array, axial: Array) -> Load:
    rating, margin = bearing.static_rating, float(bearing.static_safety(radial, axial))
    return Load(body, bearing.name, float(radial), float(axial), rating, margin)


def _chosen_part(made: Body, part: Mapping[str, Any], what: str, load: Array) -> Body:
    """A body that is a part of the catalogue, where it is for a single load."""
    if "name" not in part or made.kind == "stated":
        return made
    if part["name"] is None:
        return made._replace(mass=None, basis=f"no {what} of the catalogue carries {show(float(load), 'N', 3)}")
    return made if made.mass is None else made._replace(kind="catalogue")


def _kind(bearing: Bearing) -> str:
    return "derived" if bearing.mass is None else "catalogue"


def _tube_words(tube: Tube) -> str:
    return f"tube of {_mm(2.0 * tube.radius)}, wall {_mm(tube.wall)}, {_mm(tube.length)} long"


def _mm(value: Array) -> str:
    """A length in words; "" for many designs."""
    return show_in(float(value), "m", "mm", 3) if getattr(value, "ndim", 0) == 0 else ""
