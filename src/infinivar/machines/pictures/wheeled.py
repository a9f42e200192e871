"""A body on wheels from above: steered wheels with the normals of their headings, or wheels with free rollers."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np

from infinivar.errors import InputError
from infinivar.machines.pictures.geometry import CIRCLE, hull, normalised, off, unit
from infinivar.machines.pictures.strokes import Arrow, Disc, Label, Line, Picture, Stroke, tyre
from infinivar.machines.pictures.words import length, quantity, share_of_slip, slip_rows
from infinivar.transmission.driven_body import ground_forces
from infinivar.transmission.mechanism import MechanismPoint
from infinivar.transmission.planar import PlanarCarriage, PlanarCobot, instant_centre

_NEAR = 3.0
"""Distance of an instant centre within the drawing, over the size of the body."""

_LIMIT, _LONGEST = 0.4, 0.45
"""Radius of the circle of the largest slip limit, and longest arrow of force where none is known, over the size of the body."""

_OF_BODY = ("x of the body [m]", "y of the body [m]")

_ROUNDING = 1e-9
"""Force or moment over that of the forces on the wheels and of the load below which it is rounding."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Wheeled:
    """A body in the plane on wheels, which steer or have free rollers.

    Attributes
    ----------
    spots : (k, 2) float            Of the wheels in axes of the body. [m]
    radii : (k,) float              [m]
    mass, inertia : float           The inertia about the origin. [kg], [kg m^2]
    headings : (k,) float or None   Of wheels that do not steer. [rad]
    """

    shape: ClassVar[Literal["planar"]] = "planar"
    seen: ClassVar[Literal["above"]] = "above"

    spots: np.ndarray
    radii: np.ndarray
    mass: float
    inertia: float
    headings: np.ndarray | None = None

    @property
    def around(self) -> np.ndarray:
        """Outline of the body. (m, 2) [m]"""
        return around(self.spots, self.radii)

    @property
    def size(self) -> float:
        """Of the body. [m]"""
        return size_of(self.spots, self.radii)

    def link_positions(self, configuration: np.ndarray) -> np.ndarray:
        """None. (t, 0)"""
        return np.zeros((len(configuration), 0))

    def frames(
        self, configuration: np.ndarray, steering: np.ndarray, slips: np.ndarray, turned: np.ndarray | None
    ) -> Callable[[int], list[Stroke]]:
        """Body and wheels at a place among configurations (t, c), with the wheels' angles (t, k) and whether they slip."""
        body = self.around

        def frame(place: int) -> list[Stroke]:
            x, y, turn = configuration[place]
            axes, origin = np.stack([unit(turn), unit(turn + 0.5 * np.pi)]), np.array([x, y])
            halves = self.radii[:, None] * unit(steering[place] if self.headings is None else self.headings)
            looks = ["wheel-slips" if one else "wheel" for one in slips[place]] or ["wheel"] * len(halves)
            wheels = zip(origin + self.spots @ axes, halves @ axes, looks, strict=True)
            made: list[Stroke] = [Line(origin + body @ axes, "plate", closed=True)]
            return made + [one for spot, half, look in wheels for one in tyre(spot, half, look=look)]

        return frame


def size_of(spots: np.ndarray, radii: np.ndarray) -> float:
    """Size of a body with wheels at spots (k, 2) of radii (k,). [m]"""
    return float(np.max(np.linalg.norm(spots - spots.mean(axis=0), axis=1))) or 4.0 * float(radii.max())


def around(spots: np.ndarray, radii: np.ndarray) -> np.ndarray:
    """Outline of a body, a little way around its wheels. (m, 2) [m]"""
    return hull((spots[:, None] + 0.12 * size_of(spots, radii) * CIRCLE).reshape(-1, 2))


@dataclass(frozen=True, slots=True, kw_only=True)
class OnGround:
    """A body on k wheels at one point, about its reference point.

    Attributes
    ----------
    title, axes, notes, lever          As of a picture.
    positions, headings : (k, 2)       Of the wheels [m], and unit vectors along them.
    radius : (k,) float                [m]
    twist : (3,) float
    force : (k, 2) float               Of the ground on each wheel. [N]
    applied : look, name, wrench (3,)  Wrenches on the machine beside those of the ground.
    limit : (k,) float or None         Slip forces at rest, where they have circles. [N]
    slip : (k,) float or None          Demand over allowance.
    centre : (2,) float or None        Instant centre, perhaps infinite; None if wheels are not along normals to it. [m]
    axles : (k, 2) float or None       Unit vectors along the axles of the rollers on the ground.
    rolling : (k,) float or None       Speeds at which the wheels roll. [m/s]
    traction : (k,) float or None      Torques on the axles over the wheels' radii, along the headings. [N]
    driver : str                       What exerts them: "motor" or "leg".
    """

    title: str
    axes: tuple[str, str]
    positions: np.ndarray
    headings: np.ndarray
    radius: np.ndarray
    twist: np.ndarray
    force: np.ndarray
    applied: tuple[tuple[str, str, np.ndarray], ...]
    limit: np.ndarray | None = None
    slip: np.ndarray | None = None
    centre: np.ndarray | None = None
    axles: np.ndarray | None = None
    rolling: np.ndarray | None = None
    traction: np.ndarray | None = None
    driver: str = "motor"
    notes: tuple[str, ...] = ()
    lever: float = 0.0

    @property
    def size(self) -> float:
        """Of the body. [m]"""
        return size_of(self.positions, self.radius)

    @property
    def near(self) -> bool:
        """Whether the instant centre is within the drawing."""
        if self.centre is None or not np.all(np.isfinite(self.centre)):
            return False
        return bool(np.linalg.norm(self.centre - self.positions.mean(axis=0)) < _NEAR * self.size)


def steered(
    cobot: PlanarCobot | PlanarCarriage, point: MechanismPoint, wrench: Sequence[float] | np.ndarray | None = None
) -> OnGround:
    """Geometry and forces of one motion on steered wheels, in axes of the body.

    Parameters
    ----------
    cobot : PlanarCobot or PlanarCarriage   The machine; a carriage does not turn.
    point : MechanismPoint                  One point of its mechanism, in motion.
    wrench : (3,) or (2,) float             Of the machine on its load; the rest of what the wheels exert is on the user or slide
        that pushes. Without it source and load are drawn together. Where motors drive the wheels, it is all that they exert.

    Raises
    ------
    InputError
        If there are many points, or one without a steady motion.
    """
    turns, count = isinstance(cobot, PlanarCobot), len(cobot.mechanism.coordinates)  # type: ignore[arg-type]
    drives = len(point.coordinates) > count
    rates, cosine, sine = np.asarray(point.rates)[..., :count], np.asarray(point.cosine), np.asarray(point.sine)
    if rates.shape != ((3,) if turns else (2,)) or not np.all(np.isfinite([*rates, *np.asarray(point.lateral_force)])):
        raise InputError("a planar cobot is drawn at one point in steady motion, at which all wheels roll or slide")
    contacts = cobot.mechanism.contacts
    radii = np.array([float(one.wheel_radius) for one in contacts])  # type: ignore[union-attr]
    twist, applied = _spatial(rates), -_spatial(np.asarray(point.applied)[: len(rates)])
    both: tuple[tuple[str, str, np.ndarray], ...] = (("force", "applied force", applied),)
    if drives:
        force, traction = ground_forces(cobot.mechanism, point), -np.asarray(point.applied)[len(rates) :] / radii
        both = (("load-force", "force of the load", applied),)
    else:
        forces, _ = cobot.mechanism.forces(rates, (cosine, sine), np.asarray(point.steering_rate))
        force, traction = np.stack([np.asarray(forces.x), np.asarray(forces.y)], axis=-1), None
    if wrench is not None and not drives:
        load, who = -_spatial(wrench), "user" if turns else "source"
        both = (("force", f"push of the {who}", applied - load), ("load-force", "force of the load", load))
    return OnGround(
        title="Cart from above",
        axes=_OF_BODY,
        positions=spots_of(cobot),
        headings=np.stack([cosine, sine], axis=-1),
        radius=radii,
        twist=twist,
        force=force,
        applied=both,
        limit=np.array([float(one.slip_force) for one in contacts]),  # type: ignore[union-attr]
        slip=np.asarray(point.slip_demand),
        centre=np.array([float(one) for one in instant_centre(twist)]) if turns else np.full(2, np.inf),
        rolling=np.asarray(point.rolling_speed),
        traction=traction,
        notes=("dotted circles are the slip limits, to the scale of the forces; axes of the body",),
    )


def rolled(drive: Any, point: Any, pose: Any, twist: Any, wrench: Any) -> OnGround:
    """Geometry and forces of a `infinivar.machines.OmniwheelDrive` at an operating point of it, in axes of the plane.

    Parameters
    ----------
    drive : OmniwheelDrive
    point : TaskPoint                  Of it.
    pose, twist, wrench : (3,) float   In its coordinates; the wrench on the load.

    Raises
    ------
    InputError
        If there is no steady motion.
    """
    place, rate, load = (np.asarray(one, dtype=float) for one in (pose, twist, wrench))
    along, across = drive.on_ground(point, place, rate)
    if not np.all(np.isfinite([*along, *across])):
        raise InputError("a platform on omniwheels is drawn in steady motion, in which no wheel of a leg slips")
    turn, wheels, load = place[2], drive.wheels, 0.0 - load
    heading = turn + np.asarray(wheels.headings)
    headings, axles = unit(heading), unit(heading + np.asarray(wheels.roller_angles))
    force = along[:, None] * axles + across[:, None] * np.stack([-axles[:, 1], axles[:, 0]], axis=-1)
    grip = None if drive.grip is None else np.linalg.norm(force, axis=1) / (drive.grip * drive.load_of_wheel)
    return OnGround(
        title="Platform from above",
        axes=("x from the reference point [m]", "y from the reference point [m]"),
        positions=np.asarray(wheels.positions, dtype=float) @ np.stack([unit(turn), unit(turn + 0.5 * np.pi)]),
        headings=headings,
        radius=np.full(len(force), drive.wheel_radius),
        twist=rate,
        force=force,
        applied=(("load-force", "force of the load", load),) if np.any(load) else (),
        slip=grip,
        axles=axles,
        rolling=drive.part_speeds(place, rate),
        traction=np.asarray(point.part_forces) / drive.wheel_radius,
        driver="motor" if drive.leg is None else "leg",
        lever=drive.link_lever,
    )


def _spatial(row: Any) -> np.ndarray:
    """Components along x and y, and about the normal, 0 of what does not turn. (3,)"""
    return np.append(np.asarray(row, dtype=float), np.zeros(3 - len(row)))


def spots_of(cobot: PlanarCobot | PlanarCarriage) -> np.ndarray:
    """Positions of the wheels. (k, 2) [m]"""
    return np.array(cobot.positions) if isinstance(cobot, PlanarCobot) else np.zeros((1, 2))


def picture(found: OnGround) -> Picture:
    """Body and wheels, with all forces on the machine and its velocity."""
    speed, turning = length(found.twist[:2], "m/s"), quantity(found.twist[2], "rad/s")
    shown = (
        ("contact-force", "force of the ground on a wheel", True),
        ("limit", "slip limit, to the same scale", found.limit is not None),
        ("force", f"traction of a {found.driver}, {_newtons(found)} at most", found.traction is not None),
        *((look, _said(found, name, wrench), True) for look, name, wrench in found.applied),
        ("velocity", f"velocity {speed}, turning at {turning}", np.any(found.twist)),
        ("heading", "normal of a heading", found.centre is not None),
        ("axis", "axle of the roller on the ground", found.axles is not None),
    )
    rows = [(name, length(wrench[:2], "N")) for _, name, wrench in found.applied] + [("velocity", speed)]
    rows += [] if found.traction is None else [(f"largest traction of a {found.driver}", _newtons(found))]
    if found.slip is not None:
        rows += slip_rows((f"wheel {place + 1}" for place in range(len(found.slip))), found.force, found.slip)
    return Picture(
        title=found.title,
        axes=found.axes,
        strokes=(*_wheels(found), *_motion(found), *_labels(found)),
        keys=tuple((look, words) for look, words, drawn in shown if drawn),
        rows=tuple(rows),
        notes=found.notes,
        heading="" if found.centre is None or found.near else _far(found.centre),
        lever=found.lever,
    )


def at_rest(cobot: PlanarCobot | PlanarCarriage, radius: float, wrench: np.ndarray) -> Picture:
    """A body on steered wheels that does not move, so that their headings are free, under a wrench on its load."""
    spots, load = spots_of(cobot), -_spatial(wrench)
    size = size_of(spots, np.array([radius]))
    force = Arrow(np.zeros(2), 0.5 * size * normalised(load[:2]), "load-force")
    body = Line(around(spots, np.array([radius])), "plate", closed=True)
    return Picture(
        title="Cart from above",
        axes=_OF_BODY,
        strokes=(body, *(Disc(spot, radius, "wheel") for spot in spots), *([force] if np.any(load[:2]) else [])),
        keys=(("load-force", f"force of the load {length(load[:2], 'N')}"),) if np.any(load[:2]) else (),
        notes=("at rest the wheels are locked; their headings are free, and drawn as circles",),
    )


def _far(centre: np.ndarray) -> str:
    if not np.all(np.isfinite(centre)):
        return "instant centre at infinity"
    return f"instant centre at ({centre[0]:.3g}, {centre[1]:.3g}) m"


def _scale(found: OnGround) -> float:
    """Length of an arrow of 1 N. [m]"""
    if found.limit is not None:
        return _LIMIT * found.size / float(found.limit.max())
    largest = max(float(np.linalg.norm(one[..., :2], axis=-1).max()) for one in (found.force, *_wrenches(found)))
    return _LONGEST * found.size / (largest or 1.0)


def _wheels(found: OnGround) -> Iterator[Stroke]:
    size, scale = found.size, _scale(found)
    yield Line(around(found.positions, found.radius), "plate", closed=True)
    for place, spot in enumerate(found.positions):
        heading, radius = found.headings[place], found.radius[place]
        if found.centre is not None:
            across = np.array([-heading[1], heading[0]])
            yield Line(spot + np.outer([-9.0 * size, 9.0 * size], across), "heading", framed=False)
        if found.limit is not None:
            yield Disc(spot, scale * found.limit[place], "limit")
        yield from tyre(spot, radius * heading, None if found.rolling is None else found.rolling[place] / radius)
        if found.axles is not None:
            yield Line(spot + np.outer([-1.6 * radius, 1.6 * radius], found.axles[place]), "axis")
        yield Arrow(spot, spot + scale * found.force[place], "contact-force")
        if found.traction is not None and abs(found.traction[place]) > _ROUNDING * np.max(np.abs(found.traction)):
            beside = spot + 0.6 * radius * np.array([-heading[1], heading[0]])
            yield Arrow(beside, beside + scale * found.traction[place] * heading, "force")


def _newtons(found: OnGround) -> str:
    """The largest traction."""
    return "" if found.traction is None else quantity(float(np.max(np.abs(found.traction))), "N")


def _motion(found: OnGround) -> Iterator[Stroke]:
    """Velocity of the reference point, and forces applied there."""
    origin = np.zeros(2)
    if np.any(found.twist[:2]):
        yield Arrow(origin, 0.5 * found.size * normalised(found.twist[:2]), "velocity")
    for look, _, wrench in found.applied:
        if np.any(wrench[:2]):
            yield Arrow(origin, _scale(found) * wrench[:2], look)
    yield Disc(origin, 0.015 * found.size, "point")


def _labels(found: OnGround) -> Iterator[Stroke]:
    """Force of each wheel, beside its slip limit or away from the middle, and the instant centre."""
    size = found.size
    for place, spot in enumerate(found.positions):
        out, rises = normalised(spot - found.positions.mean(axis=0)), 0
        at = spot + 0.62 * size * out
        if found.limit is not None:
            rises = 1 if out[1] > 0.3 else -1
            at = off(spot, 0.0, rises * 1.12 * _scale(found) * found.limit[place])
        more = "" if found.slip is None else share_of_slip(found.slip[place])
        yield Label(at, f"wheel {place + 1}: {length(found.force[place], 'N')}", more=more, rises=rises)
    if found.near:
        yield Disc(found.centre, 0.04 * size, "joint")
        yield Label(off(found.centre, 0.08 * size, 0.05 * size), "instant centre", anchor="start")


def _wrenches(found: OnGround) -> list[np.ndarray]:
    return [wrench for _, _, wrench in found.applied]


def _said(found: OnGround, name: str, wrench: np.ndarray) -> str:
    """A wrench in words, without what is rounding of those of wheels and loads."""
    arms, wheels = np.linalg.norm(found.positions, axis=1), np.linalg.norm(found.force, axis=1)
    largest = max([float(wheels.sum()), *(float(np.linalg.norm(one[:2])) for one in _wrenches(found))])
    turning = max([float(wheels @ arms), *(abs(float(one[2])) for one in _wrenches(found))])
    force, moment = float(np.linalg.norm(wrench[:2])), float(wrench[2])
    force = 0.0 if force <= _ROUNDING * largest else force
    moment = 0.0 if abs(moment) <= _ROUNDING * turning else moment
    return f"{name} {quantity(force, 'N')}, with {quantity(moment, 'N m')}"
