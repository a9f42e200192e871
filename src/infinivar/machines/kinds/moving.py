"""Machines of many contacts, with all that motion in time requires."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from annotated_types import Ge, Gt

from infinivar._core.arrays import real_array
from infinivar._core.bounds import NonZero
from infinivar._core.fields import check, component, quantities, quantity
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.control import CoboticControl, ConventionalControl
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import needed
from infinivar.drivetrain.steering import SteeringPlant
from infinivar.errors import ParameterError, require
from infinivar.machines.kinds.rolling import PlanarMechanics, SerialArmMechanics, SphereMechanics
from infinivar.machines.kinds.slides import SlideLoad
from infinivar.machines.linkage import ArmLoad, LeggedMechanics, PlatformLoad
from infinivar.machines.links import RIM
from infinivar.machines.motors import LinkMotors, PowerMotor, SteeringServo
from infinivar.machines.separate import SeparateMechanics
from infinivar.parts.amplifier import Amplifier
from infinivar.parts.gearhead import Gearhead
from infinivar.parts.motor import Motor
from infinivar.transmission.arm import PlanarArm
from infinivar.transmission.planar import PlanarCobot
from infinivar.transmission.platform import Platform
from infinivar.transmission.rolling_contact import RollingContact
from infinivar.transmission.spherical import SphericalIVT


class _OnCylinder:
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
        return _servo(self.leg.steering, self.leg.transmission, self.leg.steering_amplifier, stick_speed)

    def power_motor(self, stick_speed: float) -> PowerMotor | None:
        """Motor of the cylinder."""
        leg = self.leg
        return _motor(leg.motor, leg.gearhead, leg.amplifier, -1, stick_speed / leg.transmission.cylinder_radius)

    def _mechanics(self, load: Any, count: int, stick_speed: float) -> LeggedMechanics:
        leg = self.leg
        return LeggedMechanics(
            transmission=leg.transmission,
            load=load,
            count=count,
            link_mass=needed(leg.link_mass, "leg.link_mass"),
            cylinder_inertia=needed(leg.cylinder_inertia, "leg.cylinder_inertia"),
            guideway_friction=float(leg.guideway.friction_force(leg.transmission.preload)),
            set_speed=leg.cylinder_speed,
            stick_speed=stick_speed,
            cylinder_bearings=leg.cylinder_bearings,
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlatformMachine(_OnCylinder):
    """A platform on rods, moved by legs on a common cylinder. Its origin is the centre of mass.

    Raises
    ------
    ParameterError
        If a field is out of range, or the leg has springs or a linkage of its own.
    """

    leg: CoboticDrive = component("One of the legs, with its motor, cylinder, steering and control")
    platform: Platform = component("Geometry")
    mass: float = quantity("kg", Gt(0), "Mass of the platform with what it carries")
    inertia: Sequence[float] = quantities("kg m^2", Gt(0), "Moments of inertia about its axes x, y and z")

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        _check_leg(self.leg)
        require(len(self.inertia) == 3, "inertia", f"{len(self.inertia)} values", "three")

    @property
    def home(self) -> np.ndarray:
        """Pose at the start: unrotated, with all links at 0 on average. (6,)"""
        return np.array([0.0, 0.0, self.platform.home, 0.0, 0.0, 0.0])

    def mechanics(self, stick_speed: float) -> LeggedMechanics:
        """Contacts and inertia."""
        load = PlatformLoad(platform=self.platform, mass=self.mass, inertia=np.asarray(self.inertia))
        return self._mechanics(load, len(self.platform.base), stick_speed)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ArmMachine(_OnCylinder):
    """A planar arm, each joint moved over a pulley by a leg on a common cylinder. Members are uniform.

    Raises
    ------
    ParameterError
        If a field is out of range, numbers differ, or the leg has springs or a linkage of its own.
    """

    leg: CoboticDrive = component("One of the legs, with its motor, cylinder, steering and control")
    arm: PlanarArm = component("Geometry")
    pulley_radius: float | Sequence[float] = component("Radius of each joint's pulley [m]")
    member_masses: Sequence[float] = quantities("kg", Ge(0), "Masses of the members")
    tip_mass: float = quantity("kg", Ge(0), "Mass at the end point", default=0.0)
    tip_inertia: float = quantity(
        "kg m^2", Ge(0), "Moment of inertia at the end point, which turns with the last member", default=0.0
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        _check_leg(self.leg)
        _check_members(self.arm, self.member_masses)
        _ = self.arm.parallel(self.pulley_radius)

    @property
    def home(self) -> np.ndarray:
        """Joint angles at the start."""
        return np.zeros(self.arm.joints)

    def mechanics(self, stick_speed: float) -> LeggedMechanics:
        """Contacts and inertia."""
        radii = np.diag(self.arm.parallel(self.pulley_radius).jacobian)
        return self._mechanics(_arm_load(self, radii, self.tip_inertia), self.arm.joints, stick_speed)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SerialArmMachine:
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

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        _check_members(self.arm, self.member_masses)
        _ = self.arm.serial(self.wheel, self.drum_radius)

    @property
    def home(self) -> np.ndarray:
        """Joint angles at the start."""
        return np.zeros(self.arm.joints)

    @property
    def set_speed(self) -> float:
        """Speed of the motor's coordinate. [rad s^-1]"""
        return self.joint_speed

    def mechanics(self, stick_speed: float) -> SerialArmMechanics:
        """Contacts and inertia."""
        load = _arm_load(self, np.ones(self.arm.joints))
        return SerialArmMechanics(
            load=load, mechanism=self.arm.serial(self.wheel, self.drum_radius), stick_speed=stick_speed
        )

    def servo(self, stick_speed: float) -> SteeringServo:
        """Servo of each wheel."""
        return _servo(self.steering, self.wheel, self.amplifier, stick_speed)

    def power_motor(self, stick_speed: float) -> PowerMotor | None:
        """Motor of the first joint."""
        radius = float(np.max(np.asarray(self.drum_radius)))
        return _motor(self.motor, self.gearhead, self.amplifier, 0, stick_speed / radius)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlanarMachine:
    """A planar cobot with servos on its wheels, moved by a user.

    Raises
    ------
    ParameterError
        If the cobot has no mass or inertia.
    """

    cobot: PlanarCobot = component("Body and wheels")
    steering: SteeringPlant | None = component("Servo of each wheel", default=None)
    amplifier: Amplifier = component("Amplifier of the servos", default_factory=Amplifier)
    control: CoboticControl = component("Controllers", default_factory=CoboticControl)

    set_speed: ClassVar[float] = 0.0

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        for name in ("mass", "inertia"):
            needed(getattr(self.cobot, name), f"cobot.{name}")

    @property
    def home(self) -> np.ndarray:
        """Pose in the plane at the start."""
        return np.zeros(3)

    def mechanics(self, stick_speed: float) -> PlanarMechanics:
        """Contacts and inertia."""
        return PlanarMechanics(cobot=self.cobot, stick_speed=stick_speed)

    def servo(self, stick_speed: float) -> SteeringServo:
        """Servo of each wheel."""
        wheel = self.cobot.contacts[0]  # type: ignore[index]
        return _servo(self.steering, wheel, self.amplifier, stick_speed)

    def power_motor(self, stick_speed: float) -> PowerMotor | None:
        """None: the user is the source."""
        return None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SphereMachine:
    """A sphere between rollers with a source on shaft 1 and a load or user on shaft 2.

    Raises
    ------
    ParameterError
        If a field is out of range.
    """

    ivt: SphericalIVT = component("The transmission")
    input_inertia: float = quantity("kg m^2", Gt(0), "Inertia of shaft 1 with its rollers, without a motor")
    output_inertia: float = quantity("kg m^2", Gt(0), "Inertia of shaft 2 with its rollers and load")
    sphere_inertia: float = quantity("kg m^2", Gt(0), "Inertia of the sphere about its centre")
    motor: Motor | None = component("Motor on shaft 1", default=None)
    gearhead: Gearhead | None = component("Its gearhead", default=None)
    amplifier: Amplifier = component("Amplifier of the motor", default_factory=Amplifier)
    input_speed: float = quantity("rad/s", NonZero(), "Speed of shaft 1, if the motor holds it", default=1.0)
    steering: SteeringPlant | None = component("Servo of the steering", default=None)
    control: CoboticControl = component("Controllers", default_factory=CoboticControl)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)

    @property
    def home(self) -> np.ndarray:
        """Angles of the shafts at the start."""
        return np.zeros(2)

    @property
    def set_speed(self) -> float:
        """Speed of the motor's coordinate. [rad s^-1]"""
        return self.input_speed

    def mechanics(self, stick_speed: float) -> SphereMechanics:
        """Contacts and inertia."""
        return SphereMechanics(
            ivt=self.ivt,
            shaft_inertias=(self.input_inertia, self.output_inertia),
            sphere_inertia=self.sphere_inertia,
            stick_speed=stick_speed,
        )

    def servo(self, stick_speed: float) -> SteeringServo:
        """Servo of the steering."""
        return _servo(self.steering, self.ivt.steering, self.amplifier, stick_speed)

    def power_motor(self, stick_speed: float) -> PowerMotor | None:
        """Motor of shaft 1."""
        return _motor(self.motor, self.gearhead, self.amplifier, 0, stick_speed / self.ivt.drive.wheel_radius)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SeparateMachine:
    """A platform or arm whose links are moved by a geared motor each, without wheels; the rival of legs on one cylinder.

    `infinivar.machines.kinds.platform` makes it. Without steering, the source is always on.
    """

    separate: ConventionalDrive
    load: PlatformLoad | ArmLoad
    home: np.ndarray
    """Configuration at the start."""

    set_speed: ClassVar[float] = 0.0

    @property
    def control(self) -> ConventionalControl:
        """Settings of the controllers."""
        return self.separate.control

    @property
    def links(self) -> int:
        """Number of links."""
        return len(self.load.platform.base) if isinstance(self.load, PlatformLoad) else self.load.arm.joints

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
        return SeparateMechanics(load=self.load, count=self.links, link_mass=moved)

    def servo(self, stick_speed: float) -> None:
        """None: nothing is steered."""

    def power_motor(self, stick_speed: float) -> None:
        """None: there is one for each link."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SlideMachine(_OnCylinder):
    """A handle on translational axes, each moved by a leg on a common cylinder: a display of one to six axes.

    Raises
    ------
    ParameterError
        If a field is out of range, or the leg has springs or a linkage of its own.
    """

    leg: CoboticDrive = component("One of the legs, with its motor, cylinder, steering and control")
    masses: Sequence[float] = quantities("kg", Gt(0), "Mass moved along each axis, with the handle, without its link")

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        _check_leg(self.leg)
        require(len(self.masses) >= 1, "masses", "none", "one value for each axis", "kg")

    @property
    def home(self) -> np.ndarray:
        """Positions at the start."""
        return np.zeros(len(self.masses))

    def mechanics(self, stick_speed: float) -> LeggedMechanics:
        """Contacts and inertia."""
        return self._mechanics(SlideLoad(masses=np.array(self.masses)), len(self.masses), stick_speed)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GearedSlideMachine:
    """A handle on translational axes, each moved by a conventional geared drive: a display of one to six axes.

    Raises
    ------
    ParameterError
        If a field is out of range, or the drive turns a shaft, is elastic, or has friction that depends on its load.
    """

    drive: ConventionalDrive = component("Drive of each axis, with its control")
    masses: Sequence[float] = quantities("kg", Gt(0), "Mass moved along each axis, with the handle")

    set_speed: ClassVar[float] = 0.0

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        if not isinstance(self.drive, ConventionalDrive):
            raise ParameterError(f"drive must be a ConventionalDrive, got a {type(self.drive).__name__}")
        if self.drive.own_axis.rotary:
            raise ParameterError(
                "drive must have a pulley, screw, belt or rack: a shaft does not move the axis of a slide"
            )
        require(len(self.masses) >= 1, "masses", "none", "one value for each axis", "kg")
        _ = self.link_motors(1e-4)

    @property
    def control(self) -> ConventionalControl:
        """Settings of the controllers."""
        return self.drive.control

    @property
    def home(self) -> np.ndarray:
        """Positions at the start."""
        return np.zeros(len(self.masses))

    @property
    def links(self) -> int:
        """Number of axes."""
        return len(self.masses)

    def link_motors(self, stick_speed: float) -> LinkMotors:
        """Motors of the axes."""
        try:
            return LinkMotors(drive=self.drive, stick_speed=stick_speed)
        except ParameterError as problem:
            raise ParameterError(f"drive.{problem}") from None

    def mechanics(self, stick_speed: float) -> SeparateMechanics:
        """Inertia."""
        load = SlideLoad(masses=np.array(self.masses))
        return SeparateMechanics(load=load, count=self.links, link_mass=self.link_motors(stick_speed).moved_mass)

    def servo(self, stick_speed: float) -> None:
        """None: nothing is steered."""

    def power_motor(self, stick_speed: float) -> None:
        """None: there is one for each axis."""


Machine = (
    PlatformMachine | ArmMachine | SerialArmMachine | PlanarMachine | SphereMachine | SlideMachine | GearedSlideMachine
)
"""A machine of many contacts that can move in time, or its rival with a motor for each link."""

MACHINES: tuple[type, ...] = (
    PlatformMachine,
    ArmMachine,
    SerialArmMachine,
    PlanarMachine,
    SphereMachine,
    SeparateMachine,
    SlideMachine,
    GearedSlideMachine,
)


LINKED = (SeparateMachine, GearedSlideMachine)
"""Machines with a motor for each link."""


def _check_leg(leg: Any) -> None:
    if not isinstance(leg, CoboticDrive):
        raise ParameterError(f"leg must be a CoboticDrive, got a {type(leg).__name__}")
    if leg.output.chain:
        raise ParameterError("leg.output must have no springs or linkage: the legs act on the machine directly")


def _check_members(arm: PlanarArm, masses: Sequence[float]) -> None:
    require(len(masses) == arm.joints, "member_masses", f"{len(masses)} values", f"{arm.joints}, one for each member")
    require(masses[-1] > 0, "member_masses", f"{masses[-1]} at the end", "> 0 for the last member", "kg")


def _arm_load(machine: ArmMachine | SerialArmMachine, pulleys: np.ndarray, tip_inertia: float = 0.0) -> ArmLoad:
    masses = real_array("member_masses", machine.member_masses)
    return ArmLoad(arm=machine.arm, pulleys=pulleys, masses=masses, tip_mass=machine.tip_mass, tip_inertia=tip_inertia)


def _servo(plant: SteeringPlant | None, wheel: Any, amplifier: Amplifier, stick_speed: float) -> SteeringServo:
    plant = needed(plant, "steering")
    friction = plant.friction_torques(wheel)
    return SteeringServo(
        plant=plant,
        amplifier=Amplifier(
            regeneration=amplifier.regeneration,
            storage_efficiency=amplifier.storage_efficiency,
            efficiency=amplifier.efficiency,
        ),
        # A patch that rolls as it turns belongs to the contact.
        patch_friction=0.0 if wheel.turns_with_spin else float(friction["patch"]),
        bell_friction=float(friction["bell"]),
        stick_speed=stick_speed / wheel.wheel_radius,
    )


def _motor(
    motor: Motor | None, gearhead: Gearhead | None, amplifier: Amplifier, coordinate: int, stick_speed: float
) -> PowerMotor | None:
    if motor is None:
        return None
    gearhead = Gearhead(ratio=1.0, efficiency=1.0) if gearhead is None else gearhead
    return PowerMotor(
        motor=motor,
        gearhead=gearhead,
        amplifier=amplifier,
        coordinates=(coordinate,),
        stick_speed=stick_speed * gearhead.ratio,
    )
