"""Cylinder, wheel, bell and what carries them."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator, Mapping
from typing import Any

from infinivar._core.array_namespace import Array, as_floats, namespace, plain
from infinivar._core.fields import given
from infinivar.drivetrain.body import Body
from infinivar.drivetrain.building.base import UNKNOWN, Building, Frame, Load, held_by, kind_of, load_on, mm
from infinivar.parts import catalogue
from infinivar.parts.bearing import Bearing, ring_mass
from infinivar.parts.shaft_bearings import WheelLoad, spread
from infinivar.parts.structure import bodies
from infinivar.parts.structure.stock import StockSpring, stock_mass, stretch
from infinivar.parts.structure.tube import SHORTEST, THICKEST, Tube, thinnest
from infinivar.units import show

_SECTION, _THIN = 6e-3, 7e-3
"""Radial and axial size of a thin bearing around the bell: series 618 from 20 to 45 mm of bore. [m]"""
_NO_GEOMETRY = "transmission.geometry is missing"


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
        """See `Building.loads`: under the slip force, and with the wheel at the ends of the motions, or beside a bearing."""
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
            yield load_on(name, axle.bearing, radial, axial)
        if self.own_bell_bearing is not None:
            yield load_on("bell bearing", self.own_bell_bearing, force / element.wheels, preload)
        stated = None if support is None else support.bearing
        found = [(self.carried, force), (self.carried, 0.0)]
        if support is not None and support.span is not None and self.service.travel is not None:
            travels = self.service.reach or (-0.5 * self.service.travel, 0.5 * self.service.travel)
            wheels = [
                WheelLoad(preload, 0.0, sign * force, element.cylinder_radius, end)
                for end in travels
                for sign in (1, -1)
            ]
            ends = [support.reactions(spread(wheel, element.wheels)) for wheel in wheels]
            largest = [[max(float(one[place][of]) for one in ends) for of in (0, 1)] for place in (0, 1)]
            # What preloads that cancel leave is rounding.
            found = [tuple(load if load > 1e-9 * preload else 0.0 for load in one) for one in largest]
        bearing = stated or catalogue.lightest_part("bearings", self.carried)
        for name, (radial, axial) in zip(("cylinder bearing, first", "cylinder bearing, second"), found, strict=True):
            if bearing is not None:
                yield load_on(name, bearing, radial, axial)
        if self.carried > 0.0:
            yield self.on_rail()

    @functools.cached_property
    def held(self) -> Mapping[str, Any]:
        """Sizes of a bearing of the cylinder, beside which the wheel may stand."""
        stated = self.drive.cylinder_bearings
        return held_by(None if stated is None else stated.bearing, self.carried)

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
        yield Body("axle bearings", 2.0 * count * axle.weight, kind_of(axle), many(axle.name, 2), True)
        yield self._ring()
        yield self._bell_bearing()
        yield self._preload_spring()
        if count > 1:
            yield self._closing()
        yield self.carriage()

    def _preload_spring(self) -> Body:
        """The springs that press the wheels on the cylinder."""
        preload, least = self.drive.transmission.preload, self.structure.spring_deflection
        count, many, own = self.drive.transmission.wheels, self._many, self.structure.preload_spring
        if own is not None:
            lacking, mass = _too_weak(own, preload, least), stock_mass(own)
            if mass is None:
                lacking = lacking or f"{own.name}: the mass is not stated"
            if mass is None or lacking is not None:
                return Body("preload spring", None, "catalogue", lacking or "", True)
            xp = namespace(preload)
            all_of = xp.where(xp.asarray(_presses(own, preload, least)), count * mass, math.nan)
            return Body("preload spring", plain(all_of), kind_of(own), many(own.name), True)
        if not self.structure.stock_springs:
            wire = count * self._wire(0.5 * preload * least)
            return Body("preload spring", wire, "derived", many("wire for the energy stored"), True)
        found = catalogue.lightest("springs", preload, ("weight",), fits=lambda one: _presses(one, preload, least))
        if "name" in found and found["name"] is None:
            return Body(
                "preload spring", None, "catalogue", f"no spring of the catalogue {_needed(preload, least)}", True
            )
        words = many(found.get("name", "from the catalogue"))
        return Body("preload spring", count * found["weight"], "catalogue", words, True)

    def _wheel(self) -> Body:
        """Wheel and axle."""
        element, bell = self.drive.transmission, self.bell
        geometry = element.geometry
        axle: Bearing = geometry.axle_bearing
        rod = math.pi * 0.25 * axle.bore**2 * (bell.span + axle.breadth - geometry.wheel_width)
        density = geometry.wheel_material.density
        solid = bodies.crowned_volume(element.wheel_radius, geometry.crown_radius, geometry.wheel_width)
        words = f"{mm(2.0 * element.wheel_radius)} x {mm(geometry.wheel_width)}, and its axle"
        if density is None:
            words = "density of transmission.geometry.wheel_material is missing"
        mass = None if density is None else element.wheels * density * (solid + rod)
        return self.body("wheel", mass, words if density is None else self._many(words), moving=True)

    def _ring(self) -> Body:
        """The bell itself."""
        metal, bell = self.metal, self.bell
        mass = None if metal.density is None else self.drive.transmission.wheels * metal.density * bell.volume
        words = self._many(f"ring of {mm(2.0 * bell.outer)}, {mm(bell.drop + bell.rise)} high")
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
        words = f"ring of {mm(2.0 * radius)}, {mm(thick)} thick, {mm(width)} wide"
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
        xp = namespace(element.cylinder_radius, travel)
        needed = travel + geometry.wheel_width + 2.0 * self.structure.room
        tube = Tube(
            radius=element.cylinder_radius,
            wall=self.structure.least_wall,
            length=plain(xp.maximum(*as_floats(xp, needed, SHORTEST * element.cylinder_radius))),
            end_plate=self.structure.least_wall,
            material=material,
        )
        patch = (contact.patch.a * contact.patch.b) ** 0.5
        wall = thinnest(tube, element.preload, patch, self.structure.strength_margin, element.wheels)
        xp = namespace(wall)
        wall = xp.maximum(wall, xp.asarray(self.structure.least_wall))
        wall = xp.where(wall <= THICKEST * element.cylinder_radius, wall, math.nan)
        if wall.ndim == 0 and math.isnan(wall):
            return None
        return Tube(
            radius=tube.radius,
            wall=plain(wall),
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
            return UNKNOWN
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
            return Body("bell bearing", count * own.weight, kind_of(own), self._many(own.name), True)
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


def _presses(spring: StockSpring, preload: Array, least: float) -> Array:
    """Whether a spring is neither too weak nor too stiff to press a wheel; bool."""
    force, given_way = given(spring.permissible_force, math.inf), stretch(spring, preload)
    return (force >= preload) & (True if given_way is None else given_way >= least)


def _too_weak(spring: StockSpring, preload: Array, least: float) -> str | None:
    """Why one stated spring does not press one wheel; None if it does, or of many designs."""
    force = spring.permissible_force
    if not isinstance(preload, (int, float)):
        return None
    if force is not None and force < preload:
        return f"{spring.name} permits {show(force, 'N', 3)}, and the preload is {show(float(preload), 'N', 3)}"
    given_way = stretch(spring, preload)
    if given_way is not None and given_way < least:
        return f"{spring.name} gives way by {mm(given_way)} under the preload, less than structure.spring_deflection, {mm(least)}"
    return None


def _needed(preload: Array, least: float) -> str:
    return f"carries {show(float(preload), 'N', 3)} and gives way by {mm(least)}"


def _tube_words(tube: Tube) -> str:
    return f"tube of {mm(2.0 * tube.radius)}, wall {mm(tube.wall)}, {mm(tube.length)} long"
