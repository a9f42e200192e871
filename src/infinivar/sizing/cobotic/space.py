"""Where wheel designs are searched, and the drives that they are.

A wheel design has five values from ranges and a head from lists: the bearing of the axle, the number of wheels around the
cylinder, the bearing of the cylinder. Many of them are one drive with columns for values, through the laws of `CoboticDrive`.
"""

from __future__ import annotations

import copy
import dataclasses
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from infinivar._core.arrays import rows_of
from infinivar.drivetrain import layout
from infinivar.drivetrain.body import own_mass
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.service import Service
from infinivar.errors import ParameterError
from infinivar.parts.bearing import Bearing
from infinivar.parts.motor import Motor

FREE = ("cylinder_radius", "cylinder_speed", "wheel_radius", "crown_radius", "preload")
"""Continuous values of a wheel design, in this order. [m], [rad s^-1], [m], [m], [N]"""

WITHOUT: Mapping[str, Any] = {"mass": 1e-300, "diameter": None, "length": None}
"""Sizes of a part that is not there."""

_BEARING = tuple(one.name for one in dataclasses.fields(Bearing) if one.name != "name")
_OF_SKF = frozenset({"series", "lubrication"})
"""Words that only the skf model of friction uses."""


class Head(NamedTuple):
    """What a wheel design takes from lists."""

    axle: Bearing
    wheels: int
    support: Bearing | None
    """Of the cylinder; None where the drive states no part for it."""


@dataclass(frozen=True, slots=True, eq=False)
class Heads:
    """Every combination of what wheel designs take from lists, by its place."""

    axles: tuple[Bearing, ...]
    wheels: tuple[int, ...]
    supports: tuple[Bearing | None, ...]

    @property
    def lists(self) -> tuple[tuple[Any, ...], ...]:
        """In the order of `Head`."""
        return self.axles, self.wheels, self.supports

    @property
    def shape(self) -> tuple[int, ...]:
        """Length of each list."""
        return tuple(map(len, self.lists))

    def __len__(self) -> int:
        """Number of combinations."""
        return math.prod(self.shape)

    def __getitem__(self, place: int) -> Head:
        """One of them."""
        return Head(*(some[one] for some, one in zip(self.lists, self.places(place), strict=True)))

    def places(self, heads: Any) -> tuple[Any, ...]:
        """Places in the lists of some combinations."""
        return np.unravel_index(heads, self.shape)

    def at(self, places: Sequence[Any]) -> Any:
        """Combinations of places in the lists."""
        return np.ravel_multi_index(tuple(places), self.shape)

    def apart(self, head: int) -> int:
        """Number of an axle bearing with wheels: heads that differ in the cylinder's bearing alone have the same."""
        return head // len(self.supports)

    @property
    def orders(self) -> list[np.ndarray]:
        """Places in each list by what a search goes along: static ratings of bearings, numbers of wheels."""
        sizes = [[getattr(one, "static_rating", one or 0) for one in some] for some in self.lists]
        return [np.argsort(some, kind="stable") for some in sizes]


class Points(NamedTuple):
    """Wheel designs: five values each, and a head."""

    values: np.ndarray
    """In the order of `FREE`. (k, 5)"""
    head: np.ndarray
    """Place of the head. (k,) int"""
    heaviest: np.ndarray | None = None
    """Largest whole mass of each; None: any that the search permits. (k,) [kg]"""

    drive: CoboticDrive | None = None
    """The drives that they are, once `Space.built` has made them: their heads are then of one kind."""

    def of(self, places: Any) -> Points:
        """Some of them."""
        heaviest = None if self.heaviest is None else self.heaviest[places]
        return Points(self.values[places], self.head[places], heaviest, rows_of(self.drive, places))


class Space:
    """Makes drives of wheel designs: of a template, with other heads and values."""

    def __init__(self, template: CoboticDrive, heads: Heads, service: Service) -> None:
        """Bearings that differ in numbers only are computed together; the service is that of the structure."""
        self.service = service
        self.compiled: Any = None
        """Instead of `ask` and `look`, by another array library: a `CompiledWheels`."""
        self.template: CoboticDrive = with_own_inertias(template)
        self.heads = heads
        self._weighed = [[_weighed(one) for one in some] for some in (heads.axles, heads.supports)]
        axles, supports = ([_first_alike(some, one) for one in some] for some in self._weighed)
        alike = [np.array(places) for places in (axles, range(len(heads.wheels)), supports)]
        every = heads.places(np.arange(len(heads)))
        self.kinds: np.ndarray = heads.at([some[places] for some, places in zip(alike, every, strict=True)])
        """First head of the same kind, by head. (h,) int"""
        self._numbers: dict[int, dict[tuple[str, str], np.ndarray]] = {}

    def built(self, points: Points) -> Points:
        """The designs with the drives that they are; their heads must be of one kind."""
        return points._replace(drive=self.columns(points))

    def columns(self, points: Points) -> CoboticDrive:
        """Wheel designs as one drive with columns for values (k, 1); their heads must be of one kind."""
        if points.drive is not None:
            return points.drive
        first = int(points.head[0])
        numbers = {name: values[points.head, None] for name, values in self.numbers(first).items()}
        return self.drive({name: points.values[:, place, None] for place, name in enumerate(FREE)}, first, numbers)

    def numbers(self, head: int) -> dict[tuple[str, str], np.ndarray]:
        """Numbers of bearings by part and field over all heads, nan for another kind; none of a bearing alone of its kind."""
        kind = int(self.kinds[head])
        if kind not in self._numbers:
            self._numbers[kind] = dict(self._columns(kind))
        return self._numbers[kind]

    def _columns(self, kind: int) -> Iterator[tuple[tuple[str, str], np.ndarray]]:
        mine, places = self.heads.places(kind), self.heads.places(np.arange(len(self.heads)))
        for part, bearings, axis in zip(("axle", "support"), self._weighed, (0, 2), strict=True):
            own = bearings[mine[axis]]
            alike = [_alike(own, one) for one in bearings]
            if sum(alike) == 1:
                continue
            for name in (one for one in _BEARING if isinstance(getattr(own, one), float)):
                values = [getattr(one, name) if same else np.nan for one, same in zip(bearings, alike, strict=True)]
                yield (part, name), np.array(values)[places[axis]]

    def one(self, values: np.ndarray, head: int) -> CoboticDrive:
        """A single design as a drive of plain numbers."""
        return self.drive(dict(zip(FREE, map(float, values), strict=True)), head, {})

    def drive(self, given: dict[str, Any], head: int, numbers: Mapping[tuple[str, str], Any]) -> CoboticDrive:
        """A drive with values by the names of `FREE`, and a head whose bearings have other numbers."""
        transmission, support, chosen = self.template.transmission, self.template.cylinder_bearings, self.heads[head]
        axle, held = (
            None
            if one is None
            else replace(one, **{name: value for (of, name), value in numbers.items() if of == part})
            for part, one in (("axle", chosen.axle), ("support", chosen.support))
        )
        speed, crown = given.pop("cylinder_speed"), given.pop("crown_radius")
        assert transmission.geometry is not None
        geometry = replace(transmission.geometry, crown_radius=crown, axle_bearing=axle)
        transmission = replace(transmission, geometry=geometry, wheels=chosen.wheels, **given)
        if support is not None and held is not None:
            support = replace(support, bearing=held)
        return replace(self.template, transmission=transmission, cylinder_speed=speed, cylinder_bearings=support)

    def structure(self, points: Points) -> np.ndarray:
        """Mass of all but motors and gearheads; nan where no part carries the load. (k,) [kg]

        The heads of the designs must be of one kind.
        """
        carried = own_mass(self.columns(points).bodies(self.service))
        return np.broadcast_to(np.ravel(carried), points.head.shape)

    def box(
        self,
        points: Points,
        *,
        motor: Mapping[str, Any] = WITHOUT,
        gearhead: Mapping[str, Any] = WITHOUT,
        steering: Mapping[str, Any] = WITHOUT,
    ) -> layout.Space:
        """Boxes around drives, with sizes of parts that broadcast with (k, 1), or without these parts. (k, p) [m]

        The heads of the designs must be of one kind.
        """
        drive = self.columns(points)
        drive = replace(drive, motor=replace(drive.motor, **motor), gearhead=replace(drive.gearhead, **gearhead))
        if drive.steering is not None:
            steered = replace(drive.steering.motor, **steering)
            drive = replace(drive, steering=replace(drive.steering, motor=steered))
        return drive.layout(self.service).space

    def with_steering(self, motor: Motor) -> Space:
        """The same with a steering motor of another mass, which moves with the link."""
        steering = self.template.steering
        if steering is None:
            return self
        other = copy.copy(self)
        other.template = with_own_inertias(replace(self.template, steering=replace(steering, motor=motor)))
        other.compiled = None
        return other

    def batches(self, points: Points, size: int) -> Iterator[np.ndarray]:
        """Yield places of designs to be computed together."""
        kinds = self.kinds[points.head]
        for kind in np.unique(kinds):
            some = np.flatnonzero(kinds == kind)
            for start in range(0, len(some), size):
                yield some[start : start + size]


def _weighed(bearing: Bearing | None) -> Bearing | None:
    """A bearing whose width and mass are numbers."""
    return None if bearing is None else replace(bearing, width=bearing.breadth, mass=bearing.weight)


def _first_alike(bearings: Sequence[Bearing | None], one: Bearing | None) -> int:
    return next(place for place, other in enumerate(bearings) if _alike(one, other))


def _alike(one: Bearing | None, other: Bearing | None) -> bool:
    """Whether bearings differ in numbers only, so that they are computed together."""
    return one is other or all(_form(one, name) == _form(other, name) for name in _BEARING)


def _form(bearing: Bearing | None, name: str) -> Any:
    """What bearings that are computed together must have in common in a field."""
    value = getattr(bearing, name, None)
    if name in _OF_SKF and getattr(bearing, "friction_model", None) == "coefficient":
        return None
    return float if isinstance(value, float) else value


def with_own_inertias(drive: CoboticDrive) -> CoboticDrive:
    """The drive with the mass of its link and the inertias of bell and cylinder derived, where its parts state what they need.

    Those of a template belong to its own radii.
    """
    steering = drive.steering
    if steering is not None:
        free = replace(drive, steering=replace(steering, bell_inertia=None))
        assert free.steering is not None
        if free.steering.derived_inertia is not None:
            drive = free
    free = replace(drive, link_mass=None)
    return drive if free.mass_of_link is None else free


def values_of(drive: CoboticDrive) -> np.ndarray:
    """Values of a drive in the order of `FREE`."""
    element = drive.transmission
    assert element.geometry is not None
    return np.array(
        [
            element.cylinder_radius,
            drive.cylinder_speed,
            element.wheel_radius,
            element.geometry.crown_radius,
            element.preload,
        ]
    )


def heads_of(
    template: CoboticDrive, axles: Sequence[Bearing], wheels: Sequence[int], supports: Sequence[Bearing]
) -> Heads:
    """Heads to search, checked; the template's number of wheels and cylinder bearing where none are given."""
    own = template.cylinder_bearings
    for name, some in (("bearings", axles), ("cylinder_bearings", supports)):
        for place, bearing in enumerate(some):
            if bearing.type not in ("deep_groove", "angular_contact"):
                raise ParameterError(
                    f"{name}[{place}].type must be deep_groove or angular_contact, which carry preload and lateral force, got "
                    f"{bearing.type}"
                )
    if not axles:
        raise ParameterError("bearings is empty: state at least one bearing of the axle")
    if supports and (own is None or own.bearing is None):
        raise ParameterError("cylinder_bearings do not apply: the template states no bearing of its cylinder")
    held = tuple(supports) or (None if own is None else own.bearing,)
    for count in wheels:
        replace(template, transmission=replace(template.transmission, wheels=count))
    return Heads(tuple(axles), tuple(wheels) or (template.transmission.wheels,), held)
