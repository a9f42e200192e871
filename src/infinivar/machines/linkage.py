"""Mechanics of legs on a common cylinder: a platform, or an arm with a leg for each joint."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol

import numpy as np

from infinivar.contact import creep
from infinivar.contact.friction import coulomb
from infinivar.limits import Limit
from infinivar.machines.bodies import Moved, planar_arm, rigid_body, rotation_rate
from infinivar.machines.system import Forces, Place
from infinivar.parts.shaft_bearings import ROLLERS, CylinderBearings, WheelLoad
from infinivar.transmission.arm import PlanarArm
from infinivar.transmission.platform import Platform, rotation_matrix
from infinivar.transmission.rotary_linear import RotaryLinearIVT


class Linkage(NamedTuple):
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


class Load(Protocol):
    """A body on links."""

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Components of the twist."""
        ...

    @property
    def configuration(self) -> tuple[str, ...]:
        """Components of the pose."""
        ...

    @property
    def demands(self) -> tuple[tuple[Limit, str], ...]:
        """Limits of the linkage."""
        ...

    def at(self, pose: np.ndarray, twist: np.ndarray) -> Linkage:
        """Kinematics and inertia."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class PlatformLoad:
    """A platform, its origin the centre of mass."""

    platform: Platform
    mass: float
    inertia: np.ndarray
    """About its axes. (3,) [kg m^2]"""
    coordinates: tuple[str, ...] = (
        "v_x_m_s",
        "v_y_m_s",
        "v_z_m_s",
        "w_x_rad_s",
        "w_y_rad_s",
        "w_z_rad_s",
    )
    configuration: tuple[str, ...] = (
        "x_m",
        "y_m",
        "z_m",
        "theta_x_rad",
        "theta_y_rad",
        "theta_z_rad",
    )
    demands: tuple[tuple[Limit, str], ...] = ((Limit.LINKAGE, "rods"), (Limit.TRAVEL, "links"))

    def at(self, pose: np.ndarray, twist: np.ndarray) -> Linkage:
        """Kinematics and inertia; nan beyond the reach of a rod."""
        position, rotation = pose[:, :3], pose[:, 3:]
        turn = rotation_matrix(rotation)
        moves = self.platform.moving(position, turn, twist)
        changes = np.concatenate([twist[:, :3], rotation_rate(rotation, twist[:, 3:])], axis=-1)
        demand = np.stack([moves.reach, self.platform.travel_demand(moves.link_position)], axis=-1)
        body = rigid_body(self.mass, self.inertia, turn, twist)
        return Linkage(moves.jacobian, moves.link_speed, moves.bias, changes, body, demand, moves.link_position)


@dataclass(frozen=True, slots=True, kw_only=True)
class ArmLoad:
    """An arm of uniform members, with a pulley on each joint and a mass at the end point."""

    arm: PlanarArm
    pulleys: np.ndarray
    """Radii. (n,) [m]"""
    masses: np.ndarray
    """Of the members. (n,) [kg]"""
    tip_mass: float
    tip_inertia: float = 0.0
    """Moment of inertia at the end point, which turns with the last member. [kg m^2]"""
    demands: tuple[tuple[Limit, str], ...] = ()

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Rates of the joints."""
        return tuple(f"q{place + 1}_rate_rad_s" for place in range(self.arm.joints))

    @property
    def configuration(self) -> tuple[str, ...]:
        """Joint angles."""
        return tuple(f"q{place + 1}_rad" for place in range(self.arm.joints))

    def inertia(self, angles: np.ndarray, rates: np.ndarray) -> Moved:
        """Of the arm without pulleys and links."""
        lengths = np.asarray(self.arm.lengths)
        inertias = self.masses * lengths**2 / 12.0
        inertias[-1] += self.tip_inertia
        return planar_arm(lengths, self.masses, inertias, self.tip_mass, angles, rates)

    def at(self, pose: np.ndarray, twist: np.ndarray) -> Linkage:
        """Kinematics and inertia."""
        jacobian = np.broadcast_to(np.diag(self.pulleys), (len(pose), *np.diag(self.pulleys).shape))
        nothing = np.zeros((len(pose), 0))
        return Linkage(jacobian, self.pulleys * twist, 0.0 * twist, twist, self.inertia(pose, twist), nothing)


@dataclass(frozen=True, slots=True, kw_only=True)
class LeggedMechanics:
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
    _surface: float = field(init=False, default=0.0)
    _rollers: float = field(init=False, default=0.0)
    """Torque on the cylinder of all backing rollers. [N m]"""

    def __post_init__(self) -> None:
        """Compute what does not change."""
        creep.law_in_motion(self.transmission.creep_law)
        object.__setattr__(self, "_surface", float(self.transmission.cylinder_radius * abs(self.set_speed)))
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
    def configuration(self) -> tuple[str, ...]:
        """Pose."""
        return self.load.configuration

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
        link = self.load.at(configuration, rates[:, :-1])
        d, m = link.jacobian.shape[-1], len(rates)
        across = np.swapaxes(link.jacobian, -1, -2)
        inertia = np.zeros((m, d + 1, d + 1))
        inertia[:, :d, :d] = link.moved.inertia + self.link_mass * np.matmul(across, link.jacobian)
        inertia[:, d, d] = self.cylinder_inertia
        bias = np.zeros((m, d + 1))
        bias[:, :d] = link.moved.bias + self.link_mass * np.matmul(across, link.bias[..., None])[..., 0]
        return Place(link.changes, inertia, bias, link)

    def act(self, place: Place, rates: np.ndarray, angles: np.ndarray, turning: np.ndarray) -> Forces:
        """Forces of wheels and guideways."""
        link: Linkage = place.kinematics
        radius, wheel = self.transmission.cylinder_radius, self.transmission.wheel
        # The heading of a wheel turns against its steering angle.
        spin = -turning if wheel.turns_with_spin else None
        carrier = (link.speed, -radius * rates[:, -1:] + 0.0 * link.speed)
        heading = (np.sin(angles), np.cos(angles))
        found = wheel.act(carrier, heading, spin=spin, surface_speed=self._surface, stick_speed=self.stick_speed)
        rubbing = coulomb(link.speed, self.guideway_friction, self.stick_speed)
        on_links = found.x - rubbing
        generalised = np.empty_like(rates)
        generalised[:, :-1] = np.matmul(on_links[:, None, :], link.jacobian)[:, 0]
        generalised[:, -1] = -radius * found.y.sum(axis=-1)
        rubbing_cylinder = self._turned(rates[:, -1], found, link)
        generalised[:, -1] -= sum(rubbing_cylinder.values())
        resisting = -found.moment + 0.0 * angles

        def losses() -> dict[str, np.ndarray]:
            lost = contact_losses(found.losses, found.slip_demand)
            lost["guideway"] = (rubbing * link.speed).sum(axis=-1)
            return lost | {name: torque * rates[:, -1] for name, torque in rubbing_cylinder.items()}

        def demand() -> np.ndarray:
            parts = [found.slip_demand]
            if self._steers_to_an_end:
                parts.append(np.abs(angles) / self.transmission.steering_range + 0.0 * found.slip_demand)
            return np.concatenate([*parts, link.demand], axis=-1)

        return Forces(generalised, resisting, losses, demand)

    def _turned(self, speed: np.ndarray, found: Any, link: Linkage) -> dict[str, np.ndarray]:
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


def judged(
    by_wheel: dict[str, np.ndarray], slip_demand: np.ndarray
) -> tuple[Callable[[], dict[str, np.ndarray]], Callable[[], np.ndarray]]:
    """Functions for the losses of all wheels, and for their demands, as in `Forces`."""
    return functools.partial(contact_losses, by_wheel, slip_demand), lambda: slip_demand


def contact_losses(by_wheel: dict[str, np.ndarray], slip_demand: np.ndarray) -> dict[str, np.ndarray]:
    """Losses of all wheels, with the creep of those that slide as "slip". (m,) each [W]"""
    found = {name: loss.sum(axis=-1) for name, loss in by_wheel.items()}
    slides = slip_demand > 1.0
    found["slip"] = 0.0 * found["creep"]
    if slides.any():
        found["slip"] = np.sum(np.where(slides, by_wheel["creep"], 0.0), axis=-1)
        found["creep"] = found["creep"] - found["slip"]
    return found
