"""The conventional drive-train: motor, fixed-ratio gearhead, output stage and guideway."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

from annotated_types import Ge

from infinivar._core.array_namespace import Array, finite_floats, namespace
from infinivar._core.fields import brief, check, component, quantity
from infinivar._core.labels import labelled
from infinivar.axis import Axis
from infinivar.drivetrain import chain
from infinivar.drivetrain.body import Body
from infinivar.drivetrain.buildable import check_stated
from infinivar.drivetrain.building.base import Load
from infinivar.drivetrain.building.geared import GearedBuilding
from infinivar.drivetrain.control import ConventionalControl
from infinivar.drivetrain.drive import DrivePoint, MovingPoint, motor_side, needed, placed
from infinivar.drivetrain.layout import Layout, geared_layout
from infinivar.drivetrain.masses import geared_bodies
from infinivar.drivetrain.output import Output, Place
from infinivar.drivetrain.service import Service
from infinivar.errors import ParameterError
from infinivar.motion.course import Course
from infinivar.parts.amplifier import Amplifier
from infinivar.parts.belt import Belt, Rack
from infinivar.parts.gear_law import Torsion
from infinivar.parts.gearhead import Gearhead
from infinivar.parts.linear import Guideway, Pulley
from infinivar.parts.motor import Motor
from infinivar.parts.screw import Screw
from infinivar.parts.spring import Spring
from infinivar.parts.stage import OutputStage, Shaft
from infinivar.parts.structure.structure import Structure
from infinivar.transmission.rates import Varying

STAGES = ("pulley", "screw", "belt", "rack", "shaft")
"""Fields of the output stages, of which a conventional drive has exactly one."""
ALONG_A_LINE = tuple(name for name in STAGES if name != "shaft")


@dataclass(frozen=True, slots=True, kw_only=True)
class ConventionalDrive:
    """Motor and fixed-ratio gearhead drive one output stage, which moves the load along a guideway or about a joint.

    The stage is a `pulley`, `screw`, `belt`, `rack` or `shaft`; exactly one of these fields is given.

    Source: faulring2006, Fig 14.
    """

    one_of: ClassVar[tuple[str, ...]] = STAGES
    """Fields of which exactly one is given."""

    motor: Motor = component("Motor")
    gearhead: Gearhead = component("Gearhead between motor and output stage")
    pulley: Pulley | None = component("Pulley or capstan", default=None)
    screw: Screw | None = component("Lead or ball screw", default=None)
    belt: Belt | None = component("Timing belt", default=None)
    rack: Rack | None = component("Rack and pinion", default=None)
    shaft: Shaft | None = component("Rotary output, for a load about a joint", default=None)
    guideway: Guideway = component("Guideway of the load, including cable drag", default_factory=Guideway)
    amplifier: Amplifier = component("Amplifier of the motor", default_factory=Amplifier)
    output: Output = component("Springs and linkage between the drive and its load", default_factory=Output)
    structure: Structure = component("How it is built around its bought parts, for masses", default_factory=Structure)
    output_inertia: float | None = quantity(
        "kg m^2",
        Ge(0),
        "Inertia of gear and output stage at the gear output, beside theirs; none by default",
        default=None,
    )
    control: ConventionalControl = component(
        "Controllers for time-domain simulation", default_factory=ConventionalControl
    )

    __repr__ = brief

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        given = [name for name in STAGES if getattr(self, name) is not None]
        if len(given) != 1:
            had = f"{' and '.join(given)} are given" if given else "pulley is missing"
            raise ParameterError(f"{had}: the drive must have exactly one of {', '.join(STAGES)}")
        if self.shaft is not None and self.guideway != Guideway():
            raise ParameterError(
                "guideway does not apply: the drive turns a shaft; state its friction as shaft.friction_torque, in N m, and "
                "leave the guideway out, or without friction"
            )
        self.output.check_axis(self.own_axis)
        check_stated(self)

    @property
    def stage(self) -> OutputStage:
        """The output stage: pulley, screw, belt, rack or shaft."""
        return next(stage for name in STAGES if (stage := getattr(self, name)) is not None)

    @property
    def motors(self) -> Mapping[str, Motor]:
        """The one motor."""
        return {"motor": self.motor}

    @property
    def axis(self) -> Axis:
        """Whether the drive moves a load along a line or about a joint."""
        return self.output.axis(self.own_axis)

    @property
    def own_axis(self) -> Axis:
        """Whether the drive's own output, behind springs and linkage, moves along a line or about a shaft."""
        return self.stage.axis

    @property
    def orders(self) -> int:
        """Highest time derivative of the load's position that `follow` needs; that of the force is two less."""
        return 6 if self.elastic_gear and any(place.kind == "series" for place in self.chain) else 4

    @property
    def elastic_gear(self) -> bool:
        """Whether the gearhead twists under its load."""
        return self.gearhead.stiffness is not None

    @property
    def chain(self) -> tuple[Place, ...]:
        """Springs and linkage of the output, and a stage that stretches under load and guideway, from the load to the drive."""
        if self.stage.stiffness is None:
            return self.output.chain
        return (
            *self.output.chain,
            Place("guideway", self.guideway, "guideway"),
            Place("series", Spring(stiffness=self.stage.stiffness), f"{self.stage.title} stretch"),
        )

    @property
    def gear_output_inertia(self) -> float:
        """Inertia at the gear output, with that of the stage; 0 if neither is stated, as the rotor has inertia. [kg m^2]"""
        known = [one for one in (self.output_inertia, self.stage.own_inertia) if one is not None]
        return sum(known[1:], known[0]) if known else 0.0

    def bodies(self, service: Service) -> tuple[Body, ...]:
        """What it weighs, body by body, where its output has to do a service; see `masses.geared_bodies`."""
        return geared_bodies(self, service)

    def loads(self, service: Service) -> tuple[Load, ...]:
        """Largest loads on its bearings and on the carriage, as far as they are known."""
        return tuple(GearedBuilding(self, service).loads())

    def layout(self, service: Service) -> Layout:
        """Where its bodies are, and the space that they fill."""
        return geared_layout(self, service)

    @labelled
    def operate(self, *, speed: Array, force: Array, position: Array = 0.0) -> DrivePoint:
        """Steady operating point at a load speed and force, in all four quadrants.

        Parameters
        ----------
        speed : (...,) float   Load speed; at exactly 0 friction helps to hold. [m s^-1]
        force : (...,) float   Force applied by the drive to the load. [N]
        position : (...,) float   Position of the load, for springs and linkage; see `chain.steady`. [m]

        Returns
        -------
        DrivePoint   Inputs broadcast. Powers are finite where infeasible as well: they are the demand. Power into parallel
            springs counts as power out.

        Source: faulring2006, section VI-A and Fig 14.
        """
        xp = namespace(self, speed, force, position)
        speed, force, position = finite_floats(xp, speed=speed, force=force, position=position)
        load = chain.steady(self.chain, position=position, speed=speed, force=force, axis=self.axis)
        speed, force = load.speed, load.force
        drag, guided = self._drag(force, speed)
        stage = self.stage
        torque, turning, stage_loss = stage.operate(force=force + drag, speed=speed)
        side = motor_side(self.motor, self.gearhead, output_torque=torque, output_speed=turning)
        power_in, burnt, returned = self.amplifier.supply(side.power)
        return DrivePoint(
            power_in=power_in,
            power_out=load.power,
            losses={
                **side.losses,
                "amplifier": burnt,
                stage.title: stage_loss,
                **guided,
                **load.losses,
            },
            utilisation={
                **side.utilisation,
                **returned,
                **stage.utilisation(force=force + drag, speed=speed),
                **load.utilisation,
            },
            states={**side.states, **load.states},
        )

    def check_motion(self) -> None:
        """Raise ParameterError if a value that motion requires is missing; the message names it."""
        needed(self.motor.rotor_inertia, "motor.rotor_inertia")

    def without_static_friction(self) -> ConventionalDrive:
        """The drive without friction that helps to hold a load at rest: of motor, gearhead, output stage and guideway."""
        return replace(
            self,
            motor=self.motor.without_friction(),
            gearhead=self.gearhead.without_friction(),
            guideway=Guideway(),
            **{self.stage.title: self.stage.without_friction()},
        )

    def follow(self, course: Course, *, load_mass: Array = 0.0) -> MovingPoint:
        """Operating points along a course, by inverse dynamics.

        Parameters
        ----------
        course : Course            Motion of the load, and the external force on it.
        load_mass : (...,) float   Mass of the load. [kg]

        Returns
        -------
        MovingPoint   Inputs broadcast. Powers are finite where infeasible as well: they are the demand.

        Raises
        ------
        ParameterError
            If an inertia that motion requires is missing.

        Source: faulring2006, section VI-C and Fig 14.
        """
        inertia = self.gear_output_inertia
        stage = self.stage
        power_out = course.driving_force(load_mass).value * course.speed
        load = chain.inward(
            self.chain, course, load_mass, self.axis, (2, 0) if self.gearhead.stiffness is None else (4, 2)
        )
        course = load.course
        moved, wound = self._behind_gear_spring(course, course.driving_force(load.mass), inertia)
        force = course.driving_force(load.mass).value
        drag, guided = self._drag(force, moved.heading)
        torque, turning, stage_loss = stage.operate(force=force + drag, speed=moved.heading)
        acceleration = course.acceleration / stage.travel_per_radian
        torque = torque + inertia * acceleration
        side = motor_side(
            self.motor,
            self.gearhead,
            output_torque=torque,
            output_speed=turning,
            output_acceleration=moved.acceleration / stage.travel_per_radian,
        )
        power_in, burnt, returned = self.amplifier.supply(side.power)
        return MovingPoint(
            power_in=power_in,
            power_out=power_out,
            losses={
                **side.losses,
                "amplifier": burnt,
                stage.title: stage_loss,
                **guided,
                **load.losses,
            },
            stored={
                "motor": side.stored,
                f"gear and {stage.title}": inertia * acceleration * (course.heading / stage.travel_per_radian),
                **wound,
                **load.stored,
            },
            utilisation={
                **placed({**side.utilisation, **returned}),
                **placed(stage.utilisation(force=force + drag, speed=course.speed), stage.title),
                **load.utilisation,
            },
            states={**side.states, "gear_output_torque_Nm": torque, **load.states},
        )

    def _drag(self, force: Array, speed: Array) -> tuple[Array, dict[str, Array]]:
        """Friction of a guideway that the stage moves, and its loss; of one that stretches the stage, the chain has them."""
        if self.stage.stiffness is not None:
            return 0.0, {}
        drag, loss = self.guideway.operate(force=force, speed=speed)
        return drag, {"guideway": loss}

    def _behind_gear_spring(self, course: Course, force: Varying, inertia: float) -> tuple[Course, dict[str, Array]]:
        """Motion that the gearhead gives at the stage, with its own twist, and the power into the gearhead's spring.

        The spring carries the torque of the load and of the inertia at the gear output. Friction of stage and guideway is
        counted on its motor side, so that a reversal of friction does not make the twist jump. Backlash is not included: it
        has no place in a motion that is prescribed at the load.
        """
        stiffness, travel = self.gearhead.stiffness, self.stage.travel_per_radian
        if stiffness is None:
            return course, {}
        # A gearhead of another package has a stiffness alone.
        torsion = getattr(self.gearhead, "torsion", Torsion(stiffness=stiffness))
        torque, rate, curvature = (
            push * travel + inertia * acceleration / travel
            for push, acceleration in zip(
                (force.value, force.rate, force.curvature), (course.acceleration, course.jerk, course.snap), strict=True
            )
        )
        stiffness = torsion.stiffness_at(torque)
        moved = replace(
            course,
            speed=course.speed + travel * rate / stiffness,
            acceleration=course.acceleration + travel * curvature / stiffness,
        )
        return moved, {"gearhead spring": torque * rate / stiffness}
