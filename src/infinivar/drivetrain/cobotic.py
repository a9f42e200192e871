"""The cobotic drive-train: a cylinder at constant speed, a steered wheel, a link on its guideway."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from annotated_types import Gt

from infinivar._core.array_namespace import Array, finite_floats, namespace
from infinivar._core.bounds import NonZero
from infinivar._core.fields import brief, check, component, quantity, value_at
from infinivar._core.labels import labelled
from infinivar.axis import LINEAR, Axis
from infinivar.contact import creep
from infinivar.contact.friction import STICK_SPEED
from infinivar.drivetrain import chain
from infinivar.drivetrain.body import Body
from infinivar.drivetrain.buildable import check_stated
from infinivar.drivetrain.building.base import Load
from infinivar.drivetrain.building.cobotic import CoboticBuilding
from infinivar.drivetrain.chain import Inward
from infinivar.drivetrain.control import CoboticControl
from infinivar.drivetrain.drive import DrivePoint, MotorSide, MovingPoint, motor_side, needed, placed, shaft_inertia
from infinivar.drivetrain.layout import Layout, cobotic_layout
from infinivar.drivetrain.masses import bell_inertia, cobotic_bodies, link_mass
from infinivar.drivetrain.output import Output
from infinivar.drivetrain.service import Service
from infinivar.drivetrain.steering import SteeringPlant
from infinivar.errors import ParameterError, require
from infinivar.limits import Demand, Limit
from infinivar.motion.course import Course
from infinivar.parts.amplifier import Amplifier
from infinivar.parts.gearhead import Gearhead
from infinivar.parts.linear import Guideway
from infinivar.parts.motor import Motor
from infinivar.parts.shaft_bearings import CylinderBearings, Reactions, WheelLoad, spread
from infinivar.parts.structure.structure import Structure
from infinivar.transmission import turning as turning_contact
from infinivar.transmission.rates import Varying, steering_rates
from infinivar.transmission.rotary_linear import RotaryLinearIVT

_COASTING_STEPS = 60
"""Most iterations for the coasting speed. Each reduces the error by the speed-dependent share of creep, so few suffice."""


class Rolled(NamedTuple):
    """What cylinder, wheel and link do along a course, whichever motors drive them."""

    load: Inward
    """Motion of the link and force on it."""
    cylinder_speed: Varying
    torque: Array
    """On the cylinder at constant speed: what the wheel takes, and friction of the cylinder's bearings. [N m]"""
    wheel_torque: Array
    """Applied by the cylinder to the wheel. [N m]"""
    force: Array
    """Of the transmission on the link. [N]"""
    steering: Varying
    """Tangent of the steering angle; rate and acceleration of the angle. [-], [rad s^-1], [rad s^-2]"""
    patch_moment: Array | None
    """Moment of the rolling patch against steering; None for a patch that turns on the spot. [N m]"""
    losses: Mapping[str, Array]
    """Of wheel, guideway, bearings; "creep" with what steering adds, see `infinivar.transmission.turning.shares`. [W]"""
    utilisation: Mapping[Limit, Array]
    """Of the wheel, and of the cylinder's bearings. [-]"""
    held: Reactions | None
    """Loads of the cylinder's bearings, if they are a part. [N]"""


class TurnedCylinder:
    """What motor, gearhead and cylinder of a drive turn together: a base of drives with these three fields."""

    __slots__ = ()

    @property
    def turning_inertia(self: Any) -> float:
        """Inertia of cylinder, gearhead and rotor about the cylinder's axis. [kg m^2]

        Raises
        ------
        ParameterError
            If an inertia that motion requires is missing.
        """
        of_motor = self.gearhead.ratio**2 * shaft_inertia(self.motor, self.gearhead)
        return needed(self.inertia_of_cylinder, "cylinder_inertia") + of_motor

    @property
    def inertia_of_cylinder(self: Any) -> float | None:
        """Inertia of the cylinder alone about its axis, if it is known. [kg m^2]"""
        return self.cylinder_inertia


@dataclass(frozen=True, slots=True, kw_only=True)
class CoboticDrive(TurnedCylinder):
    """Motor and gearhead turn a cylinder at constant speed; a steered wheel drives the link from it.

    Source: faulring2006, Fig 10, Fig 11, Fig 12 and Fig 13.
    """

    motor: Motor = component("Cylinder motor")
    gearhead: Gearhead = component("Gearhead between motor and cylinder")
    transmission: RotaryLinearIVT = component("The rotational-to-linear element")
    cylinder_speed: float = quantity("rad/s", NonZero(), "Constant speed of the cylinder")
    guideway: Guideway = component("Guideway of the link", default_factory=Guideway)
    amplifier: Amplifier = component("Amplifier of the cylinder motor", default_factory=Amplifier)
    cylinder_bearings: CylinderBearings | None = component(
        "The cylinder's own bearings, under preload and link force; without them their friction is not counted",
        default=None,
    )
    cylinder_inertia: float | None = quantity(
        "kg m^2",
        Gt(0),
        "Inertia of the cylinder about its axis; by default that of its tube. Required if its speed varies",
        default=None,
    )
    link_mass: float | None = quantity(
        "kg",
        Gt(0),
        "Mass of the moving link without load; by default that of wheel, bell, carriage and steering motor",
        default=None,
    )
    output: Output = component("Springs and linkage between the link and its load", default_factory=Output)
    structure: Structure = component("How it is built around its bought parts, for masses", default_factory=Structure)
    steering: SteeringPlant | None = component("Steering plant", default=None)
    control: CoboticControl = component("Controllers for time-domain simulation", default_factory=CoboticControl)

    __repr__ = brief

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        self.output.check_axis(self.own_axis)
        backed = self.cylinder_bearings is not None and self.cylinder_bearings.backing_rollers
        if backed and isinstance(self.guideway, Guideway):
            name = self.guideway.fields[1]
            if type(follows := value_at(self.guideway, name)) is float:
                allowed = "0 with cylinder_bearings.backing_rollers, which carry the preload; state guideway.friction"
                require(follows == 0.0, f"guideway.{name}", follows, allowed)
        check_stated(self)
        if self.cylinder_bearings is not None and self.transmission.wheels > 1:
            rollers, allowed = (
                self.cylinder_bearings.backing_rollers,
                "0 with transmission.wheels > 1, which hold each other",
            )
            require(rollers == 0, "cylinder_bearings.backing_rollers", rollers, allowed)
        rail, preload = getattr(self.guideway, "rail", None), self.transmission.unbalanced_preload
        if rail is not None and isinstance(preload, float) and isinstance(rail.static_rating, float):
            allowed = f">= transmission.preload, {preload:g} N, which the carriage carries"
            rated = f"{rail.static_rating:g} N"
            require(rail.static_rating >= preload, "guideway.rail.static_rating", rated, allowed)
        if self.steering is None:
            return
        if self.steering.bell_inertia is None and self.transmission.geometry is not None:
            object.__setattr__(self, "steering", replace(self.steering, derived_inertia=bell_inertia(self)))
        if self.steering.bells != self.transmission.wheels:
            object.__setattr__(self, "steering", replace(self.steering, bells=self.transmission.wheels))
        measured, derived = self.steering.patch_half_length is not None, self.transmission.geometry is not None
        if measured and derived:
            raise ParameterError("steering.patch_half_length and transmission.geometry exclude each other")
        if not measured and not derived:
            raise ParameterError("steering.patch_half_length is missing: give it, or transmission.geometry")

    @property
    def motors(self) -> Mapping[str, Motor]:
        """Cylinder motor and, if given, steering motor."""
        steering = {} if self.steering is None else {"steering": self.steering.motor}
        return {"cylinder": self.motor, **steering}

    @property
    def axis(self) -> Axis:
        """Whether the drive moves a load along a line or about a joint."""
        return self.output.axis(self.own_axis)

    @property
    def own_axis(self) -> Axis:
        """Whether the drive's own output, behind springs and linkage, moves along a line or about a shaft."""
        return LINEAR

    @property
    def inertia_of_cylinder(self) -> float | None:
        """Inertia of the cylinder about its axis: as stated, else that of its tube; None if neither is known. [kg m^2]"""
        if self.cylinder_inertia is not None or self.transmission.tube is None:
            return self.cylinder_inertia
        return self.transmission.tube.inertia

    @property
    def mass_of_link(self) -> Array | None:
        """Mass of the moving link: as stated, else derived; None if neither is known. [kg]

        Source: `infinivar.drivetrain.masses.link_mass`.
        """
        return self.link_mass if self.link_mass is not None else link_mass(self)

    @property
    def orders(self) -> int:
        """Highest time derivative of the load's position that `follow` needs; that of the force is two less."""
        return 6 if self.output.has_series_spring else 4

    @property
    def steering_amplifier(self) -> Amplifier:
        """Same type as the cylinder motor's amplifier, without standby power, which that amplifier accounts for."""
        return replace(self.amplifier, standby_power=0.0)

    def bodies(self, service: Service) -> tuple[Body, ...]:
        """What it weighs, body by body, where its output has to do a service; see `masses.cobotic_bodies`."""
        return cobotic_bodies(self, service)

    def loads(self, service: Service) -> tuple[Load, ...]:
        """Largest loads on its bearings and on the carriage, as far as they are known."""
        return tuple(CoboticBuilding(self, service).loads())

    def layout(self, service: Service) -> Layout:
        """Where its bodies are, and the space that they fill."""
        return cobotic_layout(self, service)

    @labelled
    def operate(self, *, speed: Array, force: Array, position: Array = 0.0) -> DrivePoint:
        """Steady operating point at a link speed and force, in all four quadrants; the steering angle follows.

        Parameters
        ----------
        speed : (...,) float   Link speed. Standing still under load requires a small steering angle. [m s^-1]
        force : (...,) float   Force applied by the drive to the load. [N]
        position : (...,) float   Position of the load, for springs and linkage; see `chain.steady`. [m]

        Returns
        -------
        DrivePoint   Inputs broadcast. Where the wheel would slip, no steady motion exists and all powers are nan. Power into
            parallel springs counts as power out.

        Source: faulring2006, section VI-B, Fig 10, Fig 12 and Fig 13.
        """
        xp = namespace(self, speed, force, position)
        speed, force, position = finite_floats(xp, speed=speed, force=force, position=position)
        load = chain.steady(self.output.chain, position=position, speed=speed, force=force, axis=self.axis)
        speed, force = load.speed, load.force
        drag, guide_loss = self.guideway.operate(force=force, speed=speed, preload=self.transmission.unbalanced_preload)
        element = self.transmission.deliver(
            cylinder_speed=self.cylinder_speed, link_speed=speed, link_force=force + drag
        )
        turning = xp.asarray(self.cylinder_speed, dtype=xp.float64)
        rubbing, rubbed = self.turned(turning, element.torque, force + drag, load.position)
        torque = element.torque + rubbing
        side = motor_side(self.motor, self.gearhead, output_torque=torque, output_speed=turning)
        power_in, burnt, returned = self.amplifier.supply(side.power)
        return DrivePoint(
            power_in=power_in,
            power_out=load.power,
            losses={
                **side.losses,
                "amplifier": burnt,
                **rubbed,
                **element.losses,
                "guideway": guide_loss,
                **load.losses,
            },
            utilisation={
                **element.utilisation,
                **self.supported(self.held(element.torque, force + drag, load.position), element.torque),
                **side.utilisation,
                **returned,
                **load.utilisation,
            },
            states={
                **side.states,
                "steering_tangent": element.steering_tangent,
                "cylinder_torque_Nm": torque,
                **load.states,
            },
        )

    def turned(
        self, speed: Array, torque: Array, force: Array, position: Array | None = None, *, legs: int = 1
    ) -> tuple[Array, dict[str, Array]]:
        """Torque on the cylinder that its bearings need, and the losses there; 0 and none where they are not stated.

        Parameters
        ----------
        speed : (...,) float            Of the cylinder. [rad s^-1]
        torque, force : (...,) float    Of the cylinder on a wheel, and of the transmission on a link. [N m], [N]
        position : (...,) float         Of the link; None: at 0. [m]
        legs : int                      Like wheels around the cylinder, whose loads add up as vectors.

        Source: `infinivar.parts.shaft_bearings.CylinderBearings.operate`.
        """
        bearings = self.cylinder_bearings
        if bearings is None:
            return 0.0, {}
        wheels = self._wheels(torque, force, position, legs)
        rolling = 0.0 if not bearings.backing_rollers else legs * self.transmission.groups(speed).rolling_force
        return bearings.operate(wheels, speed, torque=legs * torque, rolling=rolling)

    def _wheels(self, torque: Array, force: Array, position: Array | None, legs: int = 1) -> list[WheelLoad]:
        """What the wheels do to the cylinder; arguments as for `turned`."""
        assert self.cylinder_bearings is not None
        wheel = WheelLoad(
            preload=self.transmission.preload,
            torque=torque,
            force=force,
            radius=self.transmission.cylinder_radius,
            position=0.0 if position is None else position,
        )
        if legs == 1:
            return spread(wheel, self.transmission.wheels)
        return [wheel._replace(azimuth=angle) for angle in self.cylinder_bearings.around(legs)]

    def held(self, torque: Array, force: Array, position: Array | None) -> Reactions | None:
        """Loads of the cylinder's bearings, if they are a part; arguments as for `turned`. [N]"""
        bearings = self.cylinder_bearings
        if bearings is None or bearings.bearing is None:
            return None
        return bearings.reactions(self._wheels(torque, force, position))

    def supported(self, loads: Reactions | None, torque: Array) -> dict[Limit, Array]:
        """Demand over allowance of the cylinder's bearings under their loads, see `held`; none where they are no part. [-]"""
        bearings = self.cylinder_bearings
        if bearings is None or loads is None:
            return {}
        found = {Limit.SUPPORT: bearings.static_demand(loads)}
        if self.transmission.geometry is not None:
            found[Limit.JOURNAL] = bearings.journal_stress(loads, torque) / self.transmission.geometry.axle_strength
        return found

    def check_motion(self) -> None:
        """Raise ParameterError if a value that motion requires is missing; the message names it."""
        needed(self.mass_of_link, "link_mass")
        needed(needed(self.steering, "steering").motor.rotor_inertia, "steering.motor.rotor_inertia")
        try:
            creep.law_in_motion(self.transmission.creep_law)
        except ParameterError as problem:
            raise ParameterError(f"transmission.{problem}") from None

    def without_static_friction(self) -> CoboticDrive:
        """The drive without friction that helps to hold a load at rest: that of the guideway, as all else keeps turning."""
        return replace(self, guideway=Guideway())

    def pressed(self, preload: Array) -> CoboticDrive:
        """The same drive under another preload [N]; measured values of the contact scale with it.

        Source: johnson1985, section 4.2 for the patch; `RotaryLinearIVT.pressed`.
        """
        element, steering = self.transmission, self.steering
        if steering is not None and steering.patch_half_length is not None:
            length = steering.patch_half_length * (preload / element.preload) ** (1.0 / 3.0)
            steering = replace(steering, patch_half_length=length)
        return replace(self, transmission=element.pressed(preload), steering=steering)

    def inward(self, course: Course, load_mass: Array) -> Inward:
        """Motion of the link and force on it, for a load that follows a course; see `chain.inward`."""
        return chain.inward(self.output.chain, course, load_mass, self.axis, (4, 2))

    def _on_link(self, load: Inward) -> tuple[Varying, Array]:
        """Force that the transmission applies to the link to follow its course, and the loss in the guideway."""
        course = load.course
        driving = course.driving_force(load.mass + needed(self.mass_of_link, "link_mass"))
        drag, loss = self.guideway.operate(
            force=driving.value, speed=course.heading, preload=self.transmission.unbalanced_preload
        )
        return Varying(driving.value + drag, driving.rate, driving.curvature), loss

    def coast(self, course: Course, *, period: Array, load_mass: Array = 0.0) -> Varying:
        """Cylinder speed over a cycle at constant motor torque, with the cylinder as a flywheel.

        Parameters
        ----------
        course : Course            A whole cycle at the midpoints of equal steps, on the last axis.
        period : (...) float       Period of the cycle, without that axis. [s]
        load_mass : (...,) float   [kg]

        Returns
        -------
        Varying   Its mean is the drive's cylinder speed. nan for cycles in which the cylinder would stop or the wheel slip,
            or that are too close to this for the iteration to converge. The second derivative is a finite difference, which
            suffices for its small effect on steering.

        Raises
        ------
        ParameterError
            If a value that motion requires is missing.

        Source: energy balance of the cylinder: ``d(J omega^2/2)/dt = T omega - tau omega``.
        """
        import numpy as np

        inertia, aim = self.turning_inertia, self.cylinder_speed
        load = self.inward(course, load_mass)
        course = load.course
        link, _ = self._on_link(load)
        shape = np.broadcast_shapes(np.shape(course.speed), np.shape(link.value))
        step = np.asarray(period)[..., None] / shape[-1]
        speed, rest = np.full(shape, aim), 0.5 * inertia * aim**2
        torque, element, settled = np.zeros(shape), np.zeros(shape), np.zeros(shape, dtype=bool)
        for _ in range(_COASTING_STEPS):
            element = self.transmission.deliver(
                cylinder_speed=speed, link_speed=course.speed, link_force=link.value
            ).torque
            element = element + self.turned(speed, element, link.value, course.position)[0]
            torque = np.mean(element * speed, axis=-1, keepdims=True) / np.mean(speed, axis=-1, keepdims=True)
            gained = (torque - element) * speed * step
            energy = np.cumsum(gained, axis=-1) - 0.5 * gained
            energy = energy - np.mean(energy, axis=-1, keepdims=True) + rest
            new = np.sign(aim) * np.sqrt(2.0 * np.where(energy > 0, energy, np.nan) / inertia)
            rest = rest + inertia * aim * (aim - np.mean(new, axis=-1, keepdims=True))
            settled = np.all(np.abs(new - speed) <= 1e-11 * abs(aim), axis=-1, keepdims=True)
            speed = new
            if np.all(settled | np.isnan(speed)):
                break
        speed = np.where(settled, speed, np.nan)
        rate = (torque - element) / inertia
        return Varying(speed, rate, (np.roll(rate, -1, -1) - np.roll(rate, 1, -1)) / (2.0 * step))

    def roll(
        self,
        course: Course,
        *,
        load_mass: Array = 0.0,
        cylinder_speed: Varying | None = None,
        behind: Inward | None = None,
    ) -> Rolled:
        """What cylinder, wheel and link do along a course, whichever motors drive them; arguments as for `follow`.

        Source: faulring2006, section VI-C.
        """
        xp = namespace(self, course.speed)
        load = self.inward(course, load_mass) if behind is None else behind
        course = load.course
        turning = cylinder_speed or Varying(xp.asarray(self.cylinder_speed, dtype=xp.float64))
        link, guide_loss = self._on_link(load)
        motion = {"cylinder_speed": turning.value, "link_speed": course.speed, "link_force": link.value}
        element = self.transmission.deliver(**motion)
        rate, acceleration = steering_rates(
            self.transmission,
            tangent=element.steering_tangent,
            cylinder_speed=turning,
            link_speed=course.varying_speed,
            link_force=link,
        )
        moment = None
        if self.transmission.turns_with_spin:
            element, moment = turning_contact.deliver(self.transmission, **motion, steering_rate=rate)
        rubbing, rubbed = self.turned(turning.value, element.torque, link.value, course.position)
        held = self.held(element.torque, link.value, course.position)
        return Rolled(
            load,
            turning,
            element.torque + rubbing,
            element.torque,
            link.value,
            Varying(element.steering_tangent, rate, acceleration),
            moment,
            {**rubbed, **element.losses, "guideway": guide_loss},
            {**element.utilisation, **self.supported(held, element.torque)},
            held,
        )

    def steered(self, rolled: Rolled, stick_speed: float | None = None) -> tuple[MotorSide, dict[str, Array]]:
        """The steering motor while the wheel rolls, and losses of wheel, guideway and steering.

        Parameters
        ----------
        rolled : Rolled
        stick_speed : float   See `SteeringPlant.follow`. [m s^-1]

        Raises
        ------
        ParameterError
            If the steering plant or the inertia of its rotor is missing.

        Source: faulring2006, section V-A.1 and Fig 11.
        """
        steered = needed(self.steering, "steering").follow(
            self.transmission,
            rate=rolled.steering.rate,
            acceleration=rolled.steering.curvature,
            patch_moment=rolled.patch_moment,
            stick_speed=stick_speed,
        )
        by_creep, by_turning = rolled.losses["creep"], steered.losses["steering patch"]
        if rolled.patch_moment is not None:
            by_creep, by_turning = turning_contact.shares(by_creep, by_turning)
        return steered, {**rolled.losses, "creep": by_creep, **steered.losses, "steering patch": by_turning}

    def slow_friction(self, rolled: Rolled) -> Array:
        """Change of the supply's power by friction of steering that falls below the stick speed, as in a simulation. [W]"""
        full, slow = (
            self.steering_amplifier.supply(self.steered(rolled, stick)[0].power)[0] for stick in (None, STICK_SPEED)
        )
        return slow - full

    def follow(
        self,
        course: Course,
        *,
        load_mass: Array = 0.0,
        cylinder_speed: Varying | None = None,
        common_bus: bool = False,
        behind: Inward | None = None,
        rolled: Rolled | None = None,
    ) -> MovingPoint:
        """Operating points along a course, by inverse dynamics.

        Parameters
        ----------
        course : Course            Motion of the load, and the external force on it.
        load_mass : (...,) float   Mass of the load, in addition to the link's mass. [kg]
        cylinder_speed : Varying   Nonzero; by default the drive's constant cylinder speed. [rad s^-1] ...
        common_bus : bool          Whether power returned by one motor feeds the other before the amplifier; else each motor
            has its own amplifier.
        behind : Inward            `inward` of the same course and mass, for repeated calls; computed by default.
        rolled : Rolled            `roll` of the same arguments, for repeated calls with other motors; computed by default.

        Returns
        -------
        MovingPoint   Inputs broadcast. Where the wheel would slip, all powers are nan. At a reversal of the link, friction
            makes the steering angle jump; the energy for this jump is not included.

        Raises
        ------
        ParameterError
            If a value that motion requires is missing, or the creep law has a flow loss.

        Source: faulring2006, section VI-C.
        """
        power_out = course.driving_force(load_mass).value * course.speed
        if rolled is None:
            rolled = self.roll(course, load_mass=load_mass, cylinder_speed=cylinder_speed, behind=behind)
        load, turning = rolled.load, rolled.cylinder_speed
        course = load.course
        steered, lost = self.steered(rolled)
        inertia = 0.0 if cylinder_speed is None else needed(self.inertia_of_cylinder, "cylinder_inertia")
        torque = rolled.torque + inertia * turning.rate
        side = motor_side(
            self.motor,
            self.gearhead,
            output_torque=torque,
            output_speed=turning.value,
            output_acceleration=None if cylinder_speed is None else turning.rate,
        )
        if common_bus:
            supplies = {"amplifier": self.amplifier.supply(side.power + steered.power)}
        else:
            supplies = {
                "motor": self.amplifier.supply(side.power),
                "steering motor": self.steering_amplifier.supply(steered.power),
            }
        limits: dict[Demand, Array] = {(limit, part_of(limit)): demand for limit, demand in rolled.utilisation.items()}
        limits |= placed(side.utilisation) | placed(steered.utilisation, "steering motor")
        limits |= load.utilisation
        limits |= {(limit, what): demand for what, (_, _, met) in supplies.items() for limit, demand in met.items()}
        return MovingPoint(
            power_in=sum(drawn for drawn, _, _ in supplies.values()),
            power_out=power_out,
            losses={
                **side.losses,
                "amplifier": sum(burnt for _, burnt, _ in supplies.values()),
                **lost,
                **load.losses,
            },
            stored={
                "motor": side.stored,
                "cylinder": inertia * turning.rate * turning.value,
                "link": needed(self.mass_of_link, "link_mass") * course.acceleration * course.speed,
                "steering": steered.stored,
                **load.stored,
            },
            utilisation=limits,
            states={
                **side.states,
                "gear_output_torque_Nm": torque,
                "steering_tangent": rolled.steering.value,
                "steering_rate_rad_s": rolled.steering.rate,
                **steered.states,
                **load.states,
            },
        )


def part_of(limit: Limit) -> str:
    """The part to which a limit of `Rolled` belongs."""
    return "cylinder" if limit in (Limit.SUPPORT, Limit.JOURNAL) else "wheel"


def legs_of(drive: Any) -> CoboticDrive | None:
    """The cobotic leg of a machine, if it has one."""
    leg = getattr(drive, "leg", None)
    return leg if isinstance(leg, CoboticDrive) else None
