"""A planar arm whose joints are coupled in series by wheels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from annotated_types import Ge

from infinivar._core.bounds import FINITE, NonZero
from infinivar._core.fields import check, component, quantities, quantity
from infinivar.drivetrain.control import CoboticControl
from infinivar.drivetrain.steering import SteeringPlant
from infinivar.limits import Limit
from infinivar.machines import bonds
from infinivar.machines.hand import Grip, without_point
from infinivar.machines.kind import MovingMachine, motor_of, servo_of
from infinivar.machines.kinds.arm import (
    CENTRES,
    GRAVITY,
    INERTIAS,
    OFFSETS,
    ArmLoad,
    arm_load,
    check_members,
)
from infinivar.machines.motors import PowerMotor, SteeringServo
from infinivar.machines.pictures.jointed import Chain
from infinivar.machines.rolling import ROLLING_LOSSES, judged, slip_demands
from infinivar.machines.system import Defaults, Forces, Place
from infinivar.parts.amplifier import Amplifier
from infinivar.parts.gearhead import Gearhead
from infinivar.parts.motor import Motor
from infinivar.transmission.arm import PlanarArm
from infinivar.transmission.mechanism import Mechanism
from infinivar.transmission.rolling_contact import RollingContact


@dataclass(frozen=True, slots=True, kw_only=True)
class SerialArmMechanics(Defaults):
    """A planar arm whose joints are coupled by wheels, one between each two."""

    load: ArmLoad
    mechanism: Mechanism
    stick_speed: float
    losses: tuple[str, ...] = ROLLING_LOSSES

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Joint rates."""
        return self.load.coordinates

    @property
    def configuration(self) -> tuple[str, ...]:
        """Joint angles."""
        return self.load.configuration

    @property
    def steered(self) -> tuple[str, ...]:
        """Steering angles, as for a wheel on a cylinder: 0 locks the next joint."""
        return tuple(f"phi_{place + 1}_rad" for place in range(self.mechanism.wheels))

    @property
    def demands(self) -> tuple[tuple[Limit, str], ...]:
        """Slip of each wheel."""
        return slip_demands(self.mechanism.wheels, "wheel")

    def at(self, configuration: np.ndarray, rates: np.ndarray) -> Place:
        """Inertia of the arm."""
        moved = self.load.inertia(configuration, rates)
        return Place(rates, moved.inertia, moved.bias, None, moved.potential)

    def act(self, place: Place, rates: np.ndarray, angles: np.ndarray, turning: np.ndarray) -> Forces:
        """Forces of the wheels."""
        found, exerted = self.mechanism.forces(rates, (np.sin(angles), np.cos(angles)), -turning, self.stick_speed)
        resisting: Any = -found.moment + 0.0 * angles
        return Forces(exerted, resisting, *judged(found.losses, found.slip_demand))

    def grip(self, handle: Sequence[float] = (0.0, 0.0)) -> Grip:
        """The end point."""
        without_point(handle)
        return self.load.grip(len(self.coordinates))

    def outline(self) -> Chain:
        """Members without pulleys."""
        return self.load.outline(0.0, None)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SerialArmMachine(MovingMachine):
    """A planar arm whose joints are coupled by wheels, one between each two; a motor or a user moves it.

    Raises
    ------
    ParameterError
        If a field is out of range, or numbers differ.
    """

    arm: PlanarArm = component("Geometry")
    wheel: RollingContact = component("Wheel between two joints")
    drum_radius: float | Sequence[float] = component("Radius of each wheel's drums [m]")
    member_masses: Sequence[float] = quantities("kg", Ge(0), "Masses of the members")
    tip_mass: float = quantity("kg", Ge(0), "Mass at the end point", default=0.0)
    motor: Motor | None = component("Motor of the first joint", default=None)
    gearhead: Gearhead | None = component("Its gearhead", default=None)
    amplifier: Amplifier = component("Amplifier of the motor", default_factory=Amplifier)
    joint_speed: float = quantity("rad/s", NonZero(), "Speed of the first joint, if the motor holds it", default=1.0)
    steering: SteeringPlant | None = component("Servo of each wheel", default=None)
    control: CoboticControl = component("Controllers", default_factory=CoboticControl)
    member_centres: Sequence[float] | None = quantities("m", FINITE, CENTRES, default=None)
    member_offsets: Sequence[float] | None = quantities("m", FINITE, OFFSETS, default=None)
    member_inertias: Sequence[float] | None = quantities("kg m^2", Ge(0), INERTIAS, default=None)
    gravity: Sequence[float] | None = quantities("m/s^2", FINITE, GRAVITY, default=None)

    driven: ClassVar[str] = "q_1"

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        check_members(self, self.arm.joints)
        _ = self.arm.serial(self.wheel, self.drum_radius)

    @property
    def home(self) -> np.ndarray:
        """Joint angles at the start."""
        return np.zeros(self.arm.joints)

    @property
    def set_speed(self) -> float:
        """Speed of the motor's coordinate. [rad s^-1]"""
        return self.joint_speed

    @property
    def contacts(self) -> Sequence[RollingContact]:
        """The wheel of a joint."""
        return [self.wheel]

    def bonds(self, stick_speed: float) -> bonds.Bonds:
        """Members, and wheels between the joints."""
        mechanics = self.mechanics(stick_speed)
        joints = [f"q_{joint}" for joint in range(1, self.arm.joints + 1)]
        wheels = bonds.wheels(mechanics.mechanism, joints, stick_speed, quarter=True)
        return bonds.Bonds.of(bonds.members(mechanics.load), wheels, bonds.user(joints))

    def mechanics(self, stick_speed: float) -> SerialArmMechanics:
        """Contacts and inertia."""
        load = arm_load(self, np.ones(self.arm.joints), tip_mass=self.tip_mass)
        return SerialArmMechanics(
            load=load, mechanism=self.arm.serial(self.wheel, self.drum_radius), stick_speed=stick_speed
        )

    def servo(self, stick_speed: float) -> SteeringServo:
        """Servo of each wheel."""
        return servo_of(self.steering, self.wheel, self.amplifier, stick_speed)

    def power_motor(self, stick_speed: float) -> PowerMotor | None:
        """Motor of the first joint."""
        radius = float(np.max(np.asarray(self.drum_radius)))
        return motor_of(self.motor, self.gearhead, self.amplifier, 0, stick_speed / radius)

    def roll(self, rates: np.ndarray, angles: np.ndarray) -> np.ndarray:
        """Of the joints."""
        return self.set_speed * np.cumprod([1.0, *(-np.tan(angles))])
