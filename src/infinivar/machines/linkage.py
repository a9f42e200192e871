"""Mechanics of a load on links: legs on a common cylinder, or a geared motor for each link."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, NamedTuple

import numpy as np

from infinivar.contact import creep
from infinivar.contact.friction import coulomb
from infinivar.limits import Limit
from infinivar.machines.bodies import Moved
from infinivar.machines.hand import Grip, without_point
from infinivar.machines.pictures.slides import Drum
from infinivar.machines.rolling import contact_losses
from infinivar.machines.system import Defaults, Forces, Place
from infinivar.motion.histories import VectorHistory
from infinivar.parts.shaft_bearings import ROLLERS, CylinderBearings, WheelLoad
from infinivar.transmission.configuration import without_rounding
from infinivar.transmission.rotary_linear import RotaryLinearIVT

_NEARLY = 0.99
"""Reach of a rod over its length, beyond which a run that stops has reached the end of it."""


class Rubbing(NamedTuple):
    """Coulomb friction of a load at k speeds that are linear in the twist."""

    name: str
    """Of the loss."""
    jacobian: np.ndarray
    """(..., k, d)"""
    force: np.ndarray
    """(k,) [N]"""

    def against(self, twist: np.ndarray, stick_speed: float | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Friction that opposes the speeds at twists (..., d), and the speeds. (..., k) each

        Without a stick speed it is a step, and what moves by rounding alone rests.
        """
        speed = np.matmul(self.jacobian, twist[..., None])[..., 0]
        if stick_speed is None:
            speed = without_rounding(speed)
        return np.asarray(coulomb(speed, self.force, stick_speed)), speed


def rubbed(
    rubbing: Sequence[Rubbing], twist: np.ndarray, stick_speed: float | None = None
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Forces of a load's own friction on its coordinates at twists (..., d), and its losses by name (..., k)."""
    friction, losses = np.zeros_like(twist), {}
    for one in rubbing:
        against, speed = one.against(twist, stick_speed)
        friction = friction - np.matmul(against[..., None, :], one.jacobian)[..., 0, :]
        losses[one.name] = against * speed
    return friction, losses


class LinkMotion(NamedTuple):
    """Kinematics of links and inertia of what they move, at m rows; n links, d components of the twist."""

    jacobian: np.ndarray
    """(m, n, d)"""
    speed: np.ndarray
    """Of the links. (m, n) [m s^-1]"""
    bias: np.ndarray
    """Acceleration of the links without one of the twist. (m, n) [m s^-2]"""
    changes: np.ndarray
    """Time derivative of the configuration. (m, c)"""
    moved: Moved
    demand: np.ndarray
    """Of the linkage's limits. (m, k) [-]"""
    position: np.ndarray | float = 0.0
    """Of the links on the cylinder; of an arm, where pulleys may set them anywhere, in the middle. (m, n) [m]"""
    rubbing: tuple[Rubbing, ...] = ()
    """Friction of the load itself."""


class Load:
    """A body on links: what the kinds with links define, each by a subclass.

    A subclass has the names of the components of twist and pose, and the limits of the linkage.
    """

    __slots__ = ()
    coordinates: Any
    configuration: Any
    demands: Any
    turns: ClassVar[bool] = False
    """Whether the twist is that of a body in space, its pose a position and a rotation vector."""
    losses: ClassVar[tuple[str, ...]] = ()
    """Of its own friction: the names of `LinkMotion.rubbing`."""
    slides: ClassVar[bool] = True
    """Whether the links have places along the cylinder; pulleys may set them anywhere."""

    @property
    def links(self) -> int:
        """Number of links."""
        raise NotImplementedError

    def at(self, pose: np.ndarray, twist: np.ndarray) -> LinkMotion:
        """Kinematics and inertia at rows."""
        raise NotImplementedError

    def twist_of(self, pose: np.ndarray, rate: np.ndarray) -> np.ndarray:
        """Twist from the time derivative of the pose. (..., c)"""
        return rate

    def changes(self, pose: np.ndarray, twist: np.ndarray) -> np.ndarray:
        """Time derivative of the pose at rows. (m, c)"""
        return twist

    def apart(self, pose: np.ndarray, goal: np.ndarray) -> np.ndarray:
        """Twist that leads from a pose to another in unit time. (c,)"""
        return goal - pose

    def along(self, motion: VectorHistory, *times: float) -> tuple[np.ndarray, np.ndarray]:
        """Poses and twists of a motion at times: rows, but of a single time one row alone."""
        poses, rates = ([at(time) for time in times] for at in (motion, motion.rate))
        pose, rate = (np.array(rows) if len(times) > 1 else rows[0] for rows in (poses, rates))
        return pose, self.twist_of(pose, rate)

    def grip(self, coordinates: int) -> Grip:
        """The handle of a machine with as many coordinates."""
        raise NotImplementedError

    def outline(self, link_mass: float, drum: Drum | None) -> Any:
        """What is drawn, with links of a mass [kg], on a common cylinder or without."""
        raise NotImplementedError

    def on_links(
        self, pose: np.ndarray, twist: np.ndarray, link_mass: float
    ) -> tuple[LinkMotion, np.ndarray, np.ndarray]:
        """Kinematics, and inertia and bias with those of links of a mass. [kg]"""
        link = self.at(pose, twist)
        across = np.swapaxes(link.jacobian, -1, -2)
        inertia = link.moved.inertia + link_mass * np.matmul(across, link.jacobian)
        return link, inertia, link.moved.bias + link_mass * np.matmul(across, link.bias[..., None])[..., 0]


class _OnLinks(Defaults):
    """What mechanics with a load on links share."""

    __slots__ = ()
    load: Any
    link_mass: float
    coordinates: Any

    @property
    def configuration(self) -> tuple[str, ...]:
        """Pose."""
        return self.load.configuration

    def rates_of(self, configuration: np.ndarray, change: np.ndarray) -> np.ndarray:
        """Twist of the load."""
        return self.load.twist_of(configuration, change)

    def start(self, motion: VectorHistory) -> tuple[np.ndarray, np.ndarray]:
        """Along the motion."""
        pose, twist = self.load.along(motion, 0.0)
        return pose, np.append(twist, np.zeros(len(self.coordinates) - len(twist)))

    def grip(self, handle: Sequence[float] = (0.0, 0.0)) -> Grip:
        """That of the load."""
        without_point(handle)
        return self.load.grip(len(self.coordinates))

    def outline(self) -> Any:
        """That of the load."""
        return self.load.outline(self.link_mass, None)

    def stuck(self, configuration: np.ndarray, rates: np.ndarray) -> str:
        """Whether a rod reaches no further."""
        place = self.load.at(configuration, rates[:, : len(self.load.coordinates)])
        return "a rod is at the end of its reach" if place.demand.size and not place.demand[0, 0] < _NEARLY else ""


@dataclass(frozen=True, slots=True, kw_only=True)
class LeggedMechanics(_OnLinks):
    """Legs with one wheel each on a common cylinder; the last coordinate is the cylinder's.

    Friction limit and bearing friction are those at the set speed of the cylinder, as for one leg.
    """

    transmission: RotaryLinearIVT
    load: Load
    count: int
    link_mass: float
    cylinder_inertia: float
    guideway_friction: float
    """Of each link. [N]"""
    set_speed: float
    """Of the cylinder. [rad s^-1]"""
    stick_speed: float
    """[m s^-1]"""
    cylinder_bearings: CylinderBearings | None = None
    losses: tuple[str, ...] = ("creep", "slip", "spin", "rolling", "bearing", "guideway")
    surface_speed: float = field(init=False, default=0.0)
    """Of the cylinder at its set speed. [m s^-1]"""
    _rollers: float = field(init=False, default=0.0)
    """Torque on the cylinder of all backing rollers. [N m]"""

    def __post_init__(self) -> None:
        """Compute what does not change."""
        creep.law_in_motion(self.transmission.creep_law)
        object.__setattr__(self, "losses", (*self.losses, *self.load.losses))
        object.__setattr__(self, "surface_speed", float(self.transmission.cylinder_radius * abs(self.set_speed)))
        bearings, element = self.cylinder_bearings, self.transmission
        if bearings is None:
            return
        bearings.around(self.count)
        names = (bearings.title, ROLLERS) if bearings.backing_rollers else (bearings.title,)
        object.__setattr__(self, "losses", (*self.losses, *names))
        rolling = self.count * float(element.groups(self.set_speed).rolling_force)
        object.__setattr__(self, "_rollers", float(bearings.roller_torque(rolling, element.cylinder_radius)))

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Twist, and cylinder speed."""
        return (*self.load.coordinates, "cylinder_speed_rad_s")

    @property
    def steered(self) -> tuple[str, ...]:
        """Steering angles."""
        return tuple(f"phi_{place + 1}_rad" for place in range(self.count))

    @property
    def demands(self) -> tuple[tuple[Limit, str], ...]:
        """Slip and steering of each wheel, and limits of the linkage."""
        wheels = [f"wheel {place + 1}" for place in range(self.count)]
        steering = [(Limit.STEERING, wheel) for wheel in wheels] if self._steers_to_an_end else []
        return (*((Limit.SLIP, wheel) for wheel in wheels), *steering, *self.load.demands)

    @property
    def _steers_to_an_end(self) -> bool:
        return self.transmission.steering_range < 0.5 * np.pi

    def at(self, configuration: np.ndarray, rates: np.ndarray) -> Place:
        """Inertia with that of the links, and kinematics."""
        link, moved, forces = self.load.on_links(configuration, rates[:, :-1], self.link_mass)
        d, m = moved.shape[-1], len(rates)
        inertia, bias = np.zeros_like(rates, shape=(m, d + 1, d + 1)), np.zeros_like(rates, shape=(m, d + 1))
        inertia[:, :d, :d], inertia[:, d, d], bias[:, :d] = moved, self.cylinder_inertia, forces
        return Place(link.changes, inertia, bias, link, link.moved.potential)

    def act(self, place: Place, rates: np.ndarray, angles: np.ndarray, turning: np.ndarray) -> Forces:
        """Forces of wheels and guideways."""
        link: LinkMotion = place.kinematics
        radius, wheel = self.transmission.cylinder_radius, self.transmission.wheel
        # The heading of a wheel turns against its steering angle.
        spin = -turning if wheel.turns_with_spin else None
        carrier = (link.speed, -radius * rates[:, -1:] + 0.0 * link.speed)
        heading = (np.sin(angles), np.cos(angles))
        found = wheel.act(carrier, heading, spin=spin, surface_speed=self.surface_speed, stick_speed=self.stick_speed)
        rubbing = coulomb(link.speed, self.guideway_friction, self.stick_speed)
        on_links = found.x - rubbing
        generalised = np.empty_like(rates)
        generalised[:, :-1] = np.matmul(on_links[:, None, :], link.jacobian)[:, 0]
        generalised[:, -1] = -radius * found.y.sum(axis=-1)
        rubbing_cylinder = self._turned(rates[:, -1], found, link)
        generalised[:, -1] -= sum(rubbing_cylinder.values())
        own, of_load = rubbed(link.rubbing, rates[:, :-1], self.stick_speed)
        generalised[:, :-1] += own
        resisting = -found.moment + 0.0 * angles

        def losses() -> dict[str, np.ndarray]:
            lost = contact_losses(found.losses, found.slip_demand)
            lost["guideway"] = (rubbing * link.speed).sum(axis=-1)
            lost |= {name: torque * rates[:, -1] for name, torque in rubbing_cylinder.items()}
            return lost | {name: loss.sum(axis=-1) for name, loss in of_load.items()}

        def demand() -> np.ndarray:
            parts = [found.slip_demand]
            if self._steers_to_an_end:
                parts.append(np.abs(angles) / self.transmission.steering_range + 0.0 * found.slip_demand)
            return np.concatenate([*parts, link.demand], axis=-1)

        return Forces(generalised, resisting, losses, demand)

    def _turned(self, speed: np.ndarray, found: Any, link: LinkMotion) -> dict[str, np.ndarray]:
        """Friction torques of the cylinder's bearings by name, at the set speed of the cylinder. (m,) [N m]"""
        bearings, radius = self.cylinder_bearings, self.transmission.cylinder_radius
        if bearings is None:
            return {}
        position = np.broadcast_to(link.position, link.speed.shape)
        wheels = [
            WheelLoad(
                self.transmission.preload, radius * found.y[:, leg], found.x[:, leg], radius, position[:, leg], azimuth
            )
            for leg, azimuth in enumerate(bearings.around(self.count))
        ]
        stick = self.stick_speed / radius
        torques = {bearings.title: coulomb(speed, bearings.moment(wheels, abs(self.set_speed)), stick)}
        if bearings.backing_rollers:
            torques[ROLLERS] = coulomb(speed, self._rollers, stick)
        return torques

    def outline(self) -> Any:
        """That of the load, on the cylinder."""
        wheel = float(np.max(self.transmission.wheel_radius))
        drum = Drum(float(self.transmission.cylinder_radius), wheel, self.cylinder_inertia)
        return self.load.outline(self.link_mass, drum)


@dataclass(frozen=True, slots=True, kw_only=True)
class SeparateMechanics(_OnLinks):
    """A load on links, without wheels or a cylinder."""

    load: Load
    count: int
    """Of links."""
    link_mass: float
    """With what moves it. [kg] or [kg m^2]"""
    stick_speed: float
    """[m s^-1]"""
    steered: tuple[str, ...] = ()

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Twist."""
        return self.load.coordinates

    @property
    def losses(self) -> tuple[str, ...]:
        """Of the load's own friction."""
        return self.load.losses

    @property
    def demands(self) -> tuple[tuple[Limit, str], ...]:
        """Limits of the linkage."""
        return self.load.demands

    def at(self, configuration: np.ndarray, rates: np.ndarray) -> Place:
        """Inertia with that of the links, and kinematics."""
        link, inertia, bias = self.load.on_links(configuration, rates, self.link_mass)
        return Place(link.changes, inertia, bias, link, link.moved.potential)

    def act(self, place: Place, rates: np.ndarray, angles: np.ndarray, turning: np.ndarray) -> Forces:
        """Friction of the load; the motors act on the links, see `LinkMotors`."""
        link: LinkMotion = place.kinematics
        own, lost = rubbed(link.rubbing, rates, self.stick_speed)
        losses = {name: loss.sum(axis=-1) for name, loss in lost.items()}
        return Forces(own, 0.0 * angles, lambda: losses, lambda: link.demand)
