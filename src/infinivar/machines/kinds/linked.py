"""What kinds share whose links are moved side by side: by legs on one common cylinder, or by a drive of its own each."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from infinivar.drivetrain.body import Body
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.control import CoboticControl, ConventionalControl
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import needed
from infinivar.drivetrain.service import Service
from infinivar.errors import ParameterError
from infinivar.machines.control.loops import following_pose, standing
from infinivar.machines.control.tasks import guide_of_legs, guide_of_motors
from infinivar.machines.course import MachineCourse
from infinivar.machines.kind import MachineDrive, MovingMachine, motor_of, servo_of
from infinivar.machines.linkage import LeggedMechanics, Load, SeparateMechanics
from infinivar.machines.links import RIM, Carried, lacking_of_leg, moved, with_legs, with_motors
from infinivar.machines.machine import TaskPoint, checked, lacking_of_drive
from infinivar.machines.many_legs import LeggedDrive
from infinivar.machines.motors import LinkMotors, PowerMotor, SteeringServo
from infinivar.machines.system import SteeringLaw
from infinivar.motion.histories import VectorHistory
from infinivar.motion.machine_scenario import MachineScenario
from infinivar.transmission.configuration import Configuration
from infinivar.transmission.rolling_contact import RollingContact


class OnCylinder(MovingMachine):
    """What machines with legs on a common cylinder share; `leg` is one of the legs."""

    __slots__ = ()
    leg: CoboticDrive

    @property
    def control(self) -> CoboticControl:
        """Settings of the controllers."""
        return self.leg.control

    @property
    def set_speed(self) -> float:
        """Speed of the motor's coordinate. [rad s^-1]"""
        return self.leg.cylinder_speed

    def servo(self, stick_speed: float) -> SteeringServo:
        """Servo of each leg."""
        return servo_of(self.leg.steering, self.leg.transmission, self.leg.steering_amplifier, stick_speed)

    def power_motor(self, stick_speed: float) -> PowerMotor | None:
        """Motor of the cylinder."""
        leg = self.leg
        return motor_of(leg.motor, leg.gearhead, leg.amplifier, -1, stick_speed / leg.transmission.cylinder_radius)

    def follow(self, mechanics: Any, motion: VectorHistory | None, pose: np.ndarray, duration: float) -> SteeringLaw:
        """Angles that move the links."""
        return following_pose(
            mechanics.load,
            standing(pose, duration) if motion is None else motion,
            gain=2.0 * math.pi * self.control.link_bandwidth,
            radius=mechanics.transmission.cylinder_radius,
            set_speed=self.set_speed,
            largest=mechanics.transmission.steering_range,
        )

    @property
    def contacts(self) -> Sequence[RollingContact]:
        """The wheel of a leg."""
        return [self.leg.transmission.wheel]

    def guide(self, task: Any) -> Any:
        """Guides of legs."""
        return guide_of_legs(task)

    def on_cylinder(self, load: Any, count: int, stick_speed: float) -> LeggedMechanics:
        """Mechanics of a load on as many legs."""
        leg = self.leg
        return LeggedMechanics(
            transmission=leg.transmission,
            load=load,
            count=count,
            link_mass=needed(leg.mass_of_link, "leg.link_mass"),
            cylinder_inertia=needed(leg.inertia_of_cylinder, "leg.cylinder_inertia"),
            guideway_friction=float(leg.guideway.friction_force(leg.transmission.preload)),
            set_speed=leg.cylinder_speed,
            stick_speed=stick_speed,
            cylinder_bearings=leg.cylinder_bearings,
        )


class OwnMotors(MovingMachine):
    """What machines with a motor for each link share."""

    __slots__ = ()
    own_motors: ClassVar[bool] = True
    ungraphed: ClassVar[str] = (
        "machine must have wheels, got one with a motor for each link: plant_graph has one such drive"
    )

    def guide(self, task: Any) -> Any:
        """Guides of motors."""
        return guide_of_motors(task)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SeparateMachine(OwnMotors):
    """A platform or arm whose links are moved by a geared motor each, without wheels; the rival of legs on one cylinder.

    `infinivar.machines.kinds.platform` makes it. Without steering, the source is always on.
    """

    separate: ConventionalDrive
    load: Load
    home: np.ndarray
    """Configuration at the start."""

    @property
    def control(self) -> ConventionalControl:
        """Settings of the controllers."""
        return self.separate.control

    @property
    def links(self) -> int:
        """Number of links."""
        return self.load.links

    def link_motors(self, stick_speed: float) -> LinkMotors:
        """Motors of the links; a drive about a joint sticks below the speed of the joint that the rim of 100 mm has."""
        rotary = self.separate.own_axis.rotary
        try:
            return LinkMotors(drive=self.separate, stick_speed=stick_speed / (RIM if rotary else 1.0))
        except ParameterError as problem:
            raise ParameterError(f"separate.{problem}") from None

    def mechanics(self, stick_speed: float) -> SeparateMechanics:
        """Inertia."""
        moved = self.link_motors(stick_speed).moved_mass
        return SeparateMechanics(load=self.load, count=self.links, link_mass=moved, stick_speed=stick_speed)


def check_leg(leg: Any) -> None:
    """Raise ParameterError unless a leg acts on a machine directly."""
    if not isinstance(leg, CoboticDrive):
        raise ParameterError(f"leg must be a CoboticDrive, got a {type(leg).__name__}")
    if leg.output.chain:
        raise ParameterError("leg.output must have no springs or linkage: the legs act on the machine directly")


class Linked(MachineDrive):
    """What platform and arm share: legs on one cylinder, or a drive for each link."""

    __slots__ = ()

    WORD: ClassVar[str]
    MASSES: ClassVar[tuple[str, ...]]
    """Fields of the masses that move with the links."""
    session: ClassVar[tuple[str, ...]] = ("load_mass", "load_inertia")
    leg: CoboticDrive | None
    separate: ConventionalDrive | None
    legs: LeggedDrive | None

    @property
    def _massless(self) -> str:
        """The first mass that moves with the links and is not stated; empty if all are."""
        return next((name for name in self.MASSES if getattr(self, name) is None), "")

    @property
    def commands(self) -> tuple[str, ...]:
        """Commands that work besides those of all machines."""
        return ("contact", "simulate", "size") if self.leg is not None else ("simulate", "size")

    @property
    def lacking(self) -> Mapping[str, str]:
        """What of its motion `follow` does not count, with the reason."""
        moves = {"moving masses": f"{self._massless} is missing"} if self._massless else {}
        own = lacking_of_drive(self.separate) if self.leg is None else lacking_of_leg(self.leg)
        return {**own, **moves}

    @property
    def steering_friction(self) -> float:
        """Torque at the bell against steering; nan without a steering plant. [N m]"""
        if self.leg is None or "steering" in lacking_of_leg(self.leg):
            return float("nan")
        return float(self.leg.steering.coulomb_torque(self.leg.transmission))  # type: ignore[union-attr]

    def drivetrain(self, service: Service) -> tuple[Body, ...]:
        """What moves the links: of legs one cylinder with its bearings and motor, of all else as much as there are links.

        Parameters
        ----------
        service : Service   Of one link.
        """
        own = self.separate if self.leg is None else self.leg
        return bodies_of_links(own, self.links, service)

    @property
    def links(self) -> int:
        """Number of links."""
        raise NotImplementedError

    @property
    def link_lever(self) -> float:
        """Radius over which a link along a line moves a joint; 1 for links that move nothing else. [m]"""
        return 1.0

    @property
    def link_travel(self) -> float | None:
        """Travel that the links must have, whatever a task asks; None if it follows from the tasks. [m]"""
        return None

    def link_positions(self, pose: np.ndarray) -> np.ndarray | None:
        """Positions of the links at poses (..., d); None where they do not follow from the pose. (..., n) [m]"""
        return None

    def carried(self, course: MachineCourse) -> Carried:
        """What the links carry along a course; it does not depend on what moves them."""
        raise NotImplementedError

    def follow(self, course: MachineCourse) -> TaskPoint:
        """Operation along a course with the inertia of the machine and its links, steering or rotors."""
        return self.along(self.carried(course))

    def along(self, carried: Carried) -> TaskPoint:
        """Links along a course; those whose own motion does not count as at steady points."""
        raise NotImplementedError

    def _along(
        self, carried: Carried, lever: float = 1.0, words: str = "leg", units: tuple[str, str] = ("N", "m/s")
    ) -> TaskPoint:
        parts = tuple(f"{words} {place + 1}" for place in range(carried.configuration.links))
        if self.leg is not None and "links" not in lacking_of_leg(self.leg):
            assert self.legs is not None
            return with_legs(carried, self.legs, self.leg, parts, lever, units)
        if self.separate is not None and not lacking_of_drive(self.separate):
            return with_motors(carried, self.separate, parts, lever, units)
        known = carried.configuration
        here = replace(
            known,
            jacobian=np.broadcast_to(known.jacobian[2], (*carried.delivered.shape, *known.jacobian.shape[-2:])),
            link_position=0.0,
            utilisation={limit: demand for (limit, _), demand in carried.kinematic.items()},
        )
        twist, load = np.broadcast_arrays(carried.twist[2], carried.load[1])
        point = moved(here, self.legs, self.separate, twist, load, lever=lever, words=words, units=units)
        return replace(point, power_out=carried.delivered, stored={"machine": carried.stored})

    def scenario(
        self, machine: Any, time: np.ndarray, pose: np.ndarray, wrench: np.ndarray, closed: bool
    ) -> MachineScenario:
        """Motion in closed loops along poses (t, d), under wrenches on the load (t, d); closed: whether half of it settles.

        Raises
        ------
        ParameterError
            If the poses are beyond reach.
        """
        # The wrench acts at the pose to follow; the pose error is small beside the machine.
        followed, forces = self.followed(pose, wrench)
        if not np.all(np.isfinite(followed)):
            raise ParameterError(f"the motion leaves the reach of the machine of type {self.WORD}")
        duration, motion = float(time[-1]), VectorHistory(time=time, values=followed)
        return MachineScenario(
            duration=duration,
            motion=motion,
            pose=None if self.legs is None else list(_started(self.legs, machine, motion, forces[0])),
            wrench=VectorHistory(time=time, values=forces, smooth=False) if np.any(forces) else None,
            settling_time=0.5 * duration if closed else None,
        )

    def _legs(self, count: int) -> LeggedDrive | None:
        """The drive of the common cylinder; None with separate drives."""
        checked(self)
        if self.leg is None:
            return None
        try:
            return LeggedDrive.of(self.leg, count)
        except ParameterError as problem:
            raise ParameterError(f"leg.{problem}") from None


_ONCE = ("cylinder motor", "gearhead", "cylinder", "cylinder bearings")
"""Bodies of a leg of which a machine has one."""


def bodies_of_links(own: Any, links: int, service: Service) -> tuple[Body, ...]:
    """Bodies of as many legs on one cylinder, or drives, whose values may be arrays of many designs; see `Linked.drivetrain`."""
    once = _ONCE if isinstance(own, CoboticDrive) else ()
    return tuple(
        body
        if body.name in once or body.mass is None
        else body._replace(mass=links * body.mass, basis=f"{links} times {body.basis}")
        for body in own.bodies(service)
    )


def motor_mass(drive: Any) -> float:
    """Mass of all motors of a machine, the steering motors included; nan where one is unknown or there is none. [kg]"""
    leg, separate, axle = (getattr(drive, name, None) for name in ("leg", "separate", "drive"))
    if leg is not None:
        steering = 0.0 if leg.steering is None else _mass(leg.steering.motor)
        return _mass(leg.motor) + drive.links * steering
    if separate is not None:
        return drive.links * _mass(separate.motor)
    if axle is not None:
        steering = 0.0 if drive.steering is None else _mass(drive.steering.motor)
        return len(drive.driven) * _mass(axle.motor) + drive.mechanism.wheels * steering
    return _mass(getattr(drive, "motor", None))


def _mass(motor: Any) -> float:
    mass = getattr(motor, "mass", None)
    return float("nan") if mass is None else float(mass)


def _started(legs: LeggedDrive, machine: Any, motion: VectorHistory, force: np.ndarray) -> np.ndarray:
    r"""Configuration at the start at which the controllers command the angles that exert a wrench in spite of creep.

    They command :math:`-R\omega\tan\phi = J(\xi + k\,e)` by the pose error e, so that
    :math:`k\,e = -J^{-1} R\omega\tan\phi - \xi`. Without it the wheels would first have to turn there.
    """
    mechanics = machine.mechanics(1.0)
    pose, twist = mechanics.load.along(motion, 0.0)
    standing = mechanics.load.at(pose[None], 0.0 * twist[None])
    jacobian, carried = standing.jacobian[0], force + standing.moved.bias[0]  # with the weight
    held = legs.operate(Configuration(jacobian=jacobian), wrench=carried, twist=twist).legs.steering_tangent
    surface = mechanics.transmission.cylinder_radius * machine.set_speed
    commanded = np.linalg.lstsq(jacobian, -surface * np.nan_to_num(held), rcond=None)[0]
    error = (commanded - twist) / (2.0 * np.pi * machine.control.link_bandwidth)
    return pose - error if np.all(np.isfinite(held)) else pose
