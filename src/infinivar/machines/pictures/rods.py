"""A platform on rods in space: its rods, platform and guideways, and wheels on a common cylinder, if it has one."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np

from infinivar.errors import InputError
from infinivar.machines.pictures.slides import Drum
from infinivar.machines.pictures.strokes import (
    CIRCLE,
    Arrow,
    Disc,
    Label,
    Line,
    Picture,
    Stroke,
    Turning,
    View,
    hull,
    length_words,
    off,
    part_rows,
    quantity,
    rim,
    round_number,
)
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
    """Ends of the rods of a platform at t instants; n rods. [m]"""

    lower: np.ndarray
    """Carried by the links. (t, n, 3)"""
    upper: np.ndarray
    """On the platform. (t, n, 3)"""
    link_position: np.ndarray
    """(t, n)"""


def rods_of(platform: Platform, pose: np.ndarray) -> RodEnds:
    """Rods of a platform at poses (t, 6): position and rotation vector."""
    turn = rotation_matrix(pose[:, 3:])
    link = platform.moving(pose[:, :3], turn, np.zeros_like(pose)).link_position
    upper = pose[:, None, :3] + np.einsum("tij,nj->tni", turn, platform.joints)
    lower = platform.base + link[..., None] * np.array([0.0, 0.0, 1.0])
    return RodEnds(lower, upper, link)


@dataclass(frozen=True, slots=True, kw_only=True)
class OnRods:
    """A body in space on rods, whose links slide along z."""

    shape: ClassVar[Literal["platform"]] = "platform"
    seen: ClassVar[Literal["space"]] = "space"
    """Whether the plane of the handle is also that of its frames."""

    platform: Platform
    mass: float
    """[kg]"""
    inertia: np.ndarray
    """About its axes. (3,) [kg m^2]"""
    link_mass: float
    """[kg]"""
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
        """The machine at a place among poses (t, 6), with the wheels' angles (t, n), if they slip, and the cylinder's (t,)."""
        rods = self.rods(configuration)
        names = {"steering": steering, "slips": slips, "turned": turned}

        def frame(place: int) -> list[Stroke]:
            known = {} if turned is None else {name: one[place] for name, one in names.items() if one is not None}
            ends = RodEnds(*(one[place] for one in rods))
            origin = configuration[place, :3]
            return list(strokes(placed(self.platform, ends, rods.link_position, self.drum, origin=origin, **known)))

        return frame


def heights(platform: Platform, links: np.ndarray, wheel: float) -> tuple[float, float]:
    """Range of heights of the guideways around positions of the links, with wheels of a radius. [m]"""
    ends = np.array([min(links.min(), *(platform.stroke or ())), max(links.max(), *(platform.stroke or ()))])
    low, high = float(np.mean(platform.base[:, 2])) + ends + np.array([-1.5, 1.5]) * wheel
    return float(low), float(high)


@dataclass(frozen=True, slots=True, kw_only=True)
class Standing:
    """A platform on n rods at one pose."""

    origin: np.ndarray
    """Of the platform. (3,) [m]"""
    lower: np.ndarray
    upper: np.ndarray
    """Ends of the rods. (n, 3) [m]"""
    ends: tuple[float, float]
    """Range of heights of the guideways. [m]"""
    wheel_radius: float
    """Without wheels, the size of the joints. [m]"""
    cylinder_radius: float | None = None
    """None without a cylinder. [m]"""
    steering: np.ndarray | None = None
    """Angles of the wheels. (n,) [rad]"""
    rolling: np.ndarray | None = None
    """Speeds at which the wheels roll. (n,) [m/s]"""
    cylinder_speed: float = 0.0
    """[rad/s]"""
    turned: float | None = None
    """Angle of the cylinder, shown by stripes; None: by lines that turn. [rad]"""
    shares: np.ndarray | None = None
    """Of the slip limits, from -1 to 1, as the rods have colours by it. (n,)"""
    slips: np.ndarray | None = None
    """Whether each wheel slips. (n,)"""

    @property
    def around(self) -> np.ndarray:
        """Angles of the rods about the cylinder. (n,) [rad]"""
        return np.arctan2(self.lower[:, 1], self.lower[:, 0])

    @property
    def outward(self) -> np.ndarray:
        """Unit normals of the cylinder at the wheels. (n, 3)"""
        return np.stack([np.cos(self.around), np.sin(self.around), 0.0 * self.around], axis=-1)

    @property
    def contacts(self) -> np.ndarray:
        """Points at which wheels touch the cylinder. (n, 3) [m]"""
        return self.cylinder_radius * self.outward + self.lower[:, 2:] * _UP  # type: ignore[operator]

    @property
    def headings(self) -> np.ndarray:
        """Unit vectors along which wheels roll. (n, 3)"""
        angle = np.asarray(self.steering)[:, None]
        return np.cos(angle) * np.cross(_UP, self.outward) + np.sin(angle) * _UP


def standing(platform: Platform, pose: Any, transmission: Any = None) -> Standing:
    """A platform at a pose (6,), on wheels of a transmission if it has some.

    Raises
    ------
    InputError
        If the platform does not reach the pose.
    """
    row = np.asarray(pose, dtype=float)
    rods = rods_of(platform, row[None])
    if row.shape != (6,) or not np.all(np.isfinite(rods.link_position)):
        raise InputError("a platform is drawn at one pose within reach, and does not reach this one")
    return placed(platform, RodEnds(*(one[0] for one in rods)), rods.link_position, transmission, origin=row[:3])


def placed(platform: Platform, rods: RodEnds, links: np.ndarray, drum: Any, **known: Any) -> Standing:
    """A platform with the ends of its rods (n, 3) at one pose.

    Parameters
    ----------
    platform : Platform
    rods : RodEnds      At the pose.
    links : array       Positions of the links at all poses that are drawn. [m]
    drum                What has the radii of cylinder and wheels; None without.
    known               What else `Standing` has.
    """
    radius, wheel = None, _SLENDER * platform.rod_length
    if drum is not None:
        radius = float(getattr(drum, "cylinder_radius", None) or drum.radius)
        wheel = float(np.max(drum.wheel_radius))
    return Standing(
        lower=rods.lower,
        upper=rods.upper,
        ends=heights(platform, links, wheel),
        wheel_radius=wheel,
        cylinder_radius=radius,
        **known,
    )


def picture(
    found: Standing, point: Any, arrows: Sequence[tuple[str, str, Any]], notes: tuple[str, ...] = ()
) -> Picture:
    """The machine in space, with arrows at the platform.

    Parameters
    ----------
    found : Standing
    point : TaskPoint or None       Where its links stand.
    arrows : (look, words, vector)  Forces and velocities (3,). [N], [m/s]
    notes : strings                 What is not to scale, or assumed.
    """
    rows = [] if found.cylinder_radius is None else [
        ("cylinder", quantity(30.0 / math.pi * found.cylinder_speed, "rpm"))
    ]  # fmt: skip
    said = [
        (look, words, length_words(vector, "m/s" if look == "velocity" else "N"), float(np.linalg.norm(vector)) > _REST)
        for look, words, vector in arrows
    ]
    return Picture(
        title="Platform on its rods",
        strokes=(*strokes(found), *_arrows(found, arrows)),
        keys=tuple((look, f"{words} {size}") for look, words, size, drawn in said if drawn),
        rows=(*rows, *((words, size) for _, words, size, _ in said), *(() if point is None else part_rows(point))),
        notes=notes,
    )


def strokes(found: Standing) -> Iterator[Stroke]:
    """The machine without forces, with its axes and a scale."""
    front = [VIEW.toward(one) > 0 for one in found.outward]
    count = range(len(found.lower))
    for place in count:
        if not front[place]:
            yield from _leg(found, place)
    if found.cylinder_radius is not None:
        yield from _cylinder(found)
    for place in count:
        if front[place]:
            yield from _leg(found, place)
    yield Line(hull(VIEW(found.upper)), "platform", closed=True)
    yield from _frame(found)


def _leg(found: Standing, place: int) -> Iterator[Stroke]:
    """Guideway, wheel with its carriage out to the rod, and rod with its number."""
    lower, see = found.lower[place], VIEW
    yield Line(see([[*lower[:2], end] for end in found.ends]), "guide")
    if found.cylinder_radius is not None:
        radius, outward, heading = found.wheel_radius, found.outward[place], found.headings[place]
        hub = found.contacts[place] + radius * outward
        yield Line(see(np.stack([hub, lower])), "carriage-line")
        yield Line(see(rim(hub, radius, outward, heading)), "wheel", closed=True)
        if found.rolling is not None:
            yield Turning(
                ends=(see(hub), see(hub)),
                cosine=(see(0.3 * radius * outward), see(radius * outward)),
                sine=(see(0.3 * radius * heading), see(radius * heading)),
                rate=float(found.rolling[place]) / radius,
                count=4,
                look="tread",
            )
    slips = found.slips is not None and bool(found.slips[place])
    share = None if found.shares is None else float(found.shares[place])
    yield Line(see(np.stack([lower, found.upper[place]])), "rod-slips" if slips else "rod", share=share)
    yield Disc(see(lower), 0.6 * found.wheel_radius, "joint")
    yield Label(see(lower), str(place + 1), look="number")


def _cylinder(found: Standing) -> Iterator[Stroke]:
    """The cylinder, upright, with what shows it turn."""
    radius, (low, high), see = found.cylinder_radius, found.ends, VIEW
    assert radius is not None
    circle = radius * np.pad(CIRCLE, ((0, 0), (0, 1)))
    lower, upper = (see(circle + end * _UP) for end in (low, high))
    yield Line(hull(np.concatenate([lower, upper])), "steel", closed=True)
    if found.turned is None:
        first, second = np.array([radius, 0.0, 0.0]), np.array([0.0, radius, 0.0])
        yield Turning(
            ends=(see(low * _UP), see(high * _UP)),
            cosine=(see(first), see(first)),
            sine=(see(second), see(second)),
            rate=found.cylinder_speed,
            count=10,
            face=(see.toward(first), see.toward(second)),
        )
    else:
        yield from _stripes(radius, found.ends, found.turned)
    yield Line(upper, "steel", closed=True)


def _stripes(radius: float, ends: tuple[float, float], turned: float) -> Iterator[Stroke]:
    """Stripes of the surface, where they are in front."""
    for start, look in ((0.0, "stripe"), (np.pi, "stripe-pale")):
        along = turned + start + np.linspace(0.0, _STRIPE, 13)
        out = np.stack([np.cos(along), np.sin(along), 0.0 * along], axis=-1)
        front = radius * out[out @ VIEW.viewer >= 0.0]
        if len(front) > 1:
            low, high = (front + end * _UP for end in ends)
            yield Line(VIEW(np.concatenate([low, high[::-1]])), look, closed=True)


def _arrows(found: Standing, arrows: Sequence[tuple[str, str, Any]]) -> Iterator[Stroke]:
    """Arrows at the platform: a force on its way to the platform if it points down."""
    length = 0.7 * (found.ends[1] - found.ends[0])
    taken = None
    for look, _, vector in arrows:
        size = np.linalg.norm(vector)
        if size <= _REST:
            continue
        inward = look == "force" and vector[2] < 0
        outer = found.origin + (-1.0 if inward else 1.0) * length * np.asarray(vector) / size
        start, end = VIEW(np.stack([found.origin, outer]))
        if taken is not None and np.linalg.norm(end - taken) < _NEAR * length:
            end = start + _SHORT * (end - start)
        taken = end
        yield Arrow(*((end, start) if inward else (start, end)), look)


def _frame(found: Standing) -> Iterator[Stroke]:
    """Axes x, y and z at the lower left, as long as a round number of millimetres."""
    span = float(np.max(np.linalg.norm(found.lower[:, :2], axis=1)))
    size = round_number(span)
    everything = VIEW(np.concatenate([found.lower, [[0.0, 0.0, found.ends[0]]]]))
    start = np.array([everything[:, 0].min() - 0.75 * size, everything[:, 1].min() - 0.35 * span])
    for name, unit in zip("xyz", np.eye(3), strict=True):
        yield Line(np.stack([start, start + 0.6 * size * VIEW(unit)]), "scale")
        yield Label(start + 0.75 * size * VIEW(unit), name)
    left = np.array([-0.5 * size, start[1] - 0.1 * size])
    yield Line(np.stack([left, off(left, size, 0.0)]), "scale")
    yield Label(off(left, 0.5 * size, -0.12 * size), f"{1e3 * size:g} mm", rises=-1)
