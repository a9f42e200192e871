"""A platform on rods in space: its rods, platform and guideways, and wheels on a common cylinder, if it has one."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np

from infinivar.errors import InputError
from infinivar.machines.pictures.geometry import CIRCLE, View, hull, normalised, off, rim, round_number, unit
from infinivar.machines.pictures.slides import Drum
from infinivar.machines.pictures.strokes import Arrow, Disc, Label, Line, Picture, Stroke, Turning, treads
from infinivar.machines.pictures.words import length, part_rows, quantity
from infinivar.transmission.platform import Platform, rotation_matrix

VIEW = View(-62.0, 24.0)

_UP = np.array([0.0, 0.0, 1.0])
_NEAR, _SHORT = 0.35, 0.55
"""Distance of the ends of two arrows, over their length, from which the second is shortened, and to what share."""

_REST = 1e-12
"""Size below which an arrow is not drawn."""

_STRIPE = np.radians(60.0)
"""Of the surface of a cylinder, drawn dark, to see it turn."""

_SLENDER = 0.1
"""Size of the joints of rods without wheels, over the length of a rod."""


class RodEnds(NamedTuple):
    """Ends of the rods of a platform at t instants: lower, carried by the links, and upper, (t, n, 3); links (t, n) [m]."""

    lower: np.ndarray
    upper: np.ndarray
    link_position: np.ndarray


def rods_of(platform: Platform, pose: np.ndarray) -> RodEnds:
    """Rods of a platform at poses (t, 6): position and rotation vector."""
    turn = rotation_matrix(pose[:, 3:])
    link = platform.moving(pose[:, :3], turn, np.zeros_like(pose)).link_position
    upper = pose[:, None, :3] + np.einsum("tij,nj->tni", turn, platform.joints)
    lower = platform.base + link[..., None] * np.array([0.0, 0.0, 1.0])
    return RodEnds(lower, upper, link)


def heights(platform: Platform, links: np.ndarray, wheel: float) -> tuple[float, float]:
    """Range of heights of the guideways around positions of the links, with wheels of a radius. [m]"""
    ends = np.array([min(links.min(), *(platform.stroke or ())), max(links.max(), *(platform.stroke or ()))])
    low, high = float(np.mean(platform.base[:, 2])) + ends + np.array([-1.5, 1.5]) * wheel
    return float(low), float(high)


@dataclass(frozen=True, slots=True, kw_only=True)
class OnRods:
    """A body in space on rods, whose links slide along z.

    Attributes
    ----------
    platform : Platform
    mass, rod_mass, link_mass : float   [kg]
    inertia : (3,) float      Of the body about its axes. [kg m^2]
    drum : Drum or None
    """

    shape: ClassVar[Literal["platform"]] = "platform"
    seen: ClassVar[Literal["space"]] = "space"

    platform: Platform
    mass: float
    inertia: np.ndarray
    rod_mass: float
    link_mass: float
    drum: Drum | None

    def rods(self, pose: np.ndarray) -> RodEnds:
        """Rods at poses (t, 6): position and rotation vector."""
        return rods_of(self.platform, pose)

    def link_positions(self, configuration: np.ndarray) -> np.ndarray:
        """Of the links since their position 0. (t, n) [m]"""
        return self.rods(configuration).link_position

    def frames(
        self, configuration: np.ndarray, steering: np.ndarray, slips: np.ndarray, turned: np.ndarray | None
    ) -> Callable[[int], list[Stroke]]:
        """The machine at a place among poses (t, 6), with angles of wheels (t, n) and cylinder (t,), and which wheels slip."""
        rods = self.rods(configuration)
        radius, wheel = (None, None) if self.drum is None else (self.drum.radius, self.drum.wheel_radius)

        def frame(place: int) -> list[Stroke]:
            here = RodEnds(*(one[place] for one in rods))
            known = {} if turned is None else {"steering": steering[place], "turned": float(turned[place])}
            found = Standing.of(self.platform, here, rods.link_position, radius, wheel, **known)
            return list(strokes(found, slips=slips[place] if radius is not None else None))

        return frame


@dataclass(frozen=True, slots=True, kw_only=True)
class Standing:
    """A platform on n rods at one pose.

    Attributes
    ----------
    lower, upper : (n, 3) float       Ends of the rods. [m]
    ends : pair of float              Range of heights of the guideways. [m]
    wheel_radius : float              Without wheels, the size of the joints. [m]
    cylinder_radius : float or None   None without a cylinder. [m]
    steering : (n,) float             Angles of the wheels. [rad]
    cylinder_speed : float            [rad/s]
    turned : float or None            Angle of the cylinder, shown by stripes; None: by lines that turn. [rad]
    """

    lower: np.ndarray
    upper: np.ndarray
    ends: tuple[float, float]
    wheel_radius: float
    cylinder_radius: float | None
    steering: Any = None
    cylinder_speed: float = 0.0
    turned: float | None = None

    @classmethod
    def of(
        cls, platform: Platform, rods: RodEnds, links: np.ndarray, radius: float | None, wheel: Any, **known: Any
    ) -> Standing:
        """With the ends of its rods (n, 3) at one pose, positions of the links at all that are drawn, and radii. [m]"""
        wheel = _SLENDER * platform.rod_length if radius is None else float(np.max(wheel))
        ends = heights(platform, links, wheel)
        return cls(lower=rods.lower, upper=rods.upper, ends=ends, wheel_radius=wheel, cylinder_radius=radius, **known)

    @property
    def around(self) -> np.ndarray:
        """Angles of the rods about the cylinder. (n,) [rad]"""
        return np.arctan2(self.lower[:, 1], self.lower[:, 0])

    @property
    def outward(self) -> np.ndarray:
        """Unit normals of the cylinder at the wheels. (n, 3)"""
        return np.pad(unit(self.around), ((0, 0), (0, 1)))

    @property
    def contacts(self) -> np.ndarray:
        """Points at which wheels touch the cylinder. (n, 3) [m]"""
        return self.cylinder_radius * self.outward + self.lower[:, 2:] * _UP  # type: ignore[operator]

    @property
    def headings(self) -> np.ndarray:
        """Unit vectors along which wheels roll. (n, 3)"""
        cosine, sine = np.cos(self.steering)[:, None], np.sin(self.steering)[:, None]
        return cosine * np.cross(_UP, self.outward) + sine * _UP


def standing(platform: Platform, pose: Any, transmission: Any = None, **known: Any) -> Standing:
    """A platform at a pose (6,), on wheels of a transmission if it has some; known: what else `Standing` has.

    Raises
    ------
    InputError
        If the platform does not reach the pose.
    """
    row = np.asarray(pose, dtype=float)
    rods = rods_of(platform, row[None])
    if row.shape != (6,) or not np.all(np.isfinite(rods.link_position)):
        raise InputError("a platform is drawn at one pose within reach, and does not reach this one")
    radius, wheel = None, None
    if transmission is not None:
        radius, wheel = float(transmission.cylinder_radius), transmission.wheel_radius
    return Standing.of(platform, RodEnds(*(one[0] for one in rods)), rods.link_position, radius, wheel, **known)


Shown = Sequence[tuple[str, str, Any]]
"""Looks, names and vectors (3,) of forces and velocities at the platform. [N], [m/s]"""


def picture(
    found: Standing, origin: Any, shown: Shown, *, shares: Any = None, point: Any = None, notes: tuple[str, ...] = ()
) -> Picture:
    """The machine in space.

    Parameters
    ----------
    found : Standing
    origin : (3,) float     Of the platform. [m]
    shown : Shown
    shares : (n,) float     Of the slip limits, from -1 to 1, for colours of the rods.
    point : TaskPoint       Where its links stand, if that is listed.
    notes : strings         What is not to scale, or assumed.
    """
    rows = [(name, length(vector, "m/s" if look == "velocity" else "N")) for look, name, vector in shown]
    keys = [
        (look, f"{name} {size}") for (look, _, vector), (name, size) in zip(shown, rows, strict=True) if _moves(vector)
    ]
    if found.cylinder_radius is not None:
        rows.insert(0, ("cylinder", quantity(30.0 / math.pi * found.cylinder_speed, "rpm")))
    return Picture(
        title="Platform on its rods",
        strokes=(*strokes(found, shares=shares), *_arrows(found, np.asarray(origin, dtype=float), shown)),
        keys=tuple(keys),
        rows=(*rows, *(() if point is None else part_rows(point))),
        notes=notes,
    )


def strokes(found: Standing, *, shares: Any = None, slips: Any = None) -> Iterator[Stroke]:
    """The machine without forces, with its axes and a scale, and rods by shares of slip limits or whether their wheels slip."""
    legs: dict[bool, list[Stroke]] = {False: [], True: []}
    for place, outward in enumerate(found.outward):
        look = "rod-slips" if slips is not None and slips[place] else "rod"
        share = None if shares is None else float(shares[place])
        legs[VIEW.toward(outward) > 0] += _leg(found, place, look, share)
    yield from legs[False]
    if found.cylinder_radius is not None:
        yield from _cylinder(found, found.cylinder_radius)
    yield from legs[True]
    yield Line(hull(VIEW(found.upper)), "platform", closed=True)
    yield from _frame(found)


def _leg(found: Standing, place: int, look: str, share: float | None) -> Iterator[Stroke]:
    """Guideway, wheel with its carriage out to the rod, and rod with its number."""
    lower, see = found.lower[place], VIEW
    yield Line(see([[*lower[:2], end] for end in found.ends]), "guide")
    if found.cylinder_radius is not None:
        radius, outward, heading = found.wheel_radius, found.outward[place], found.headings[place]
        hub = found.contacts[place] + radius * outward
        yield Line(see(np.stack([hub, lower])), "carriage-line")
        yield Line(see(rim(hub, radius, outward, heading)), "wheel", closed=True)
        # Of a wheel that follows carrier and surface, without creep.
        rolling = -found.cylinder_speed * found.cylinder_radius / math.cos(found.steering[place])
        cosine, sine = (tuple(see(share * radius * way) for share in (0.3, 1.0)) for way in (outward, heading))
        yield treads((see(hub),) * 2, cosine, sine, rolling / radius, count=4)
    yield Line(see(np.stack([lower, found.upper[place]])), look, share=share)
    yield Disc(see(lower), 0.6 * found.wheel_radius, "joint")
    yield Label(see(lower), str(place + 1), look="number")


def _cylinder(found: Standing, radius: float) -> Iterator[Stroke]:
    """The cylinder, upright, with what shows it turn."""
    (low, high), see = found.ends, VIEW
    circle = radius * np.pad(CIRCLE, ((0, 0), (0, 1)))
    lower, upper = (see(circle + end * _UP) for end in (low, high))
    yield Line(hull(np.concatenate([lower, upper])), "steel", closed=True)
    if found.turned is None:
        first, second = radius * np.eye(3)[:2]
        yield Turning(
            ends=(see(low * _UP), see(high * _UP)),
            cosine=(see(first),) * 2,
            sine=(see(second),) * 2,
            rate=found.cylinder_speed,
            count=10,
            face=(see.toward(first), see.toward(second)),
        )
    else:
        for start, look in ((0.0, "stripe"), (np.pi, "stripe-pale")):
            out = np.pad(unit(found.turned + start + np.linspace(0.0, _STRIPE, 13)), ((0, 0), (0, 1)))
            front = radius * out[out @ see.viewer >= 0.0]
            if len(front) > 1:
                yield Line(see(np.concatenate([front + low * _UP, front[::-1] + high * _UP])), look, closed=True)
    yield Line(upper, "steel", closed=True)


def _moves(vector: Any) -> bool:
    return float(np.linalg.norm(vector)) > _REST


def _arrows(found: Standing, origin: np.ndarray, shown: Shown) -> Iterator[Stroke]:
    """Arrows at the platform: a force on its way to the platform if it points down."""
    size = 0.7 * (found.ends[1] - found.ends[0])
    taken = None
    for look, _, vector in shown:
        if not _moves(vector):
            continue
        inward = look == "force" and vector[2] < 0
        start, end = VIEW(np.stack([origin, origin + (-1.0 if inward else 1.0) * size * normalised(vector)]))
        if taken is not None and np.linalg.norm(end - taken) < _NEAR * size:
            end = start + _SHORT * (end - start)
        taken = end
        yield Arrow(*((end, start) if inward else (start, end)), look)


def _frame(found: Standing) -> Iterator[Stroke]:
    """Axes x, y and z at the lower left, as long as a round number of millimetres."""
    span = float(np.max(np.linalg.norm(found.lower[:, :2], axis=1)))
    size = round_number(span)
    everything = VIEW(np.concatenate([found.lower, [[0.0, 0.0, found.ends[0]]]]))
    start = np.array([everything[:, 0].min() - 0.75 * size, everything[:, 1].min() - 0.35 * span])
    yield from axes(start, size, -0.5 * size)


def axes(start: np.ndarray, size: float, left: float) -> Iterator[Stroke]:
    """Axes x, y and z from a point (2,), and below them a scale of a size, from a place to the right. [m]"""
    for name, way in zip("xyz", np.eye(3), strict=True):
        yield Line(np.stack([start, start + 0.6 * size * VIEW(way)]), "scale")
        yield Label(start + 0.75 * size * VIEW(way), name)
    begin = np.array([left, start[1] - 0.1 * size])
    yield Line(np.stack([begin, off(begin, size, 0.0)]), "scale")
    yield Label(off(begin, 0.5 * size, -0.12 * size), f"{1e3 * size:g} mm", rises=-1)
