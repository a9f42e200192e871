"""The conventional drive-train: motor, fixed-ratio gearhead, pulley and guideway."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from annotated_types import Gt

from infinivar._core.array_namespace import Array, finite_floats, namespace
from infinivar._core.fields import check, component, quantity
from infinivar._core.labels import labelled
from infinivar.axis import LINEAR, Axis
from infinivar.drivetrain import chain
from infinivar.drivetrain.control import ConventionalControl
from infinivar.drivetrain.drive import DrivePoint, MovingPoint, motor_side, needed, placed
from infinivar.drivetrain.output import Output
from infinivar.motion.course import Course
from infinivar.parts.amplifier import Amplifier
from infinivar.parts.gearhead import Gearhead
from infinivar.parts.linear import Guideway, Pulley
from infinivar.parts.motor import Motor


@dataclass(frozen=True, slots=True, kw_only=True)
class ConventionalDrive:
    """Motor and fixed-ratio gearhead drive a pulley, which pulls the load along a guideway.

    Source: faulring2006, Fig 14.
    """

    motor: Motor = component("Motor")
    gearhead: Gearhead = component("Gearhead between motor and pulley")
    pulley: Pulley = component("Pulley or capstan")
    guideway: Guideway = component("Guideway of the load, including cable drag", default_factory=Guideway)
    amplifier: Amplifier = component("Amplifier of the motor", default_factory=Amplifier)
    output: Output = component("Springs and linkage between the drive and its load", default_factory=Output)
    output_inertia: float | None = quantity(
        "kg m^2", Gt(0), "Inertia of gear, pulley and cable at the gear output", default=None
    )
    control: ConventionalControl = component(
        "Controllers for time-domain simulation", default_factory=ConventionalControl
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        self.output.check_axis(self.own_axis)

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
        return LINEAR

    @property
    def orders(self) -> int:
        """Highest time derivative of the load's position that `follow` needs; that of the force is two less."""
        return 4

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
        load = chain.steady(self.output, position=position, speed=speed, force=force, axis=self.axis)
        speed, force = load.speed, load.force
        drag, guide_loss = self.guideway.operate(force=force, speed=speed)
        torque, turning, pulley_loss = self.pulley.operate(force=force + drag, speed=speed)
        side = motor_side(self.motor, self.gearhead, output_torque=torque, output_speed=turning)
        power_in, burnt, returned = self.amplifier.supply(side.power)
        return DrivePoint(
            power_in=power_in,
            power_out=load.power,
            losses={
                **side.losses,
                "amplifier": burnt,
                "pulley": pulley_loss,
                "guideway": guide_loss,
                **load.losses,
            },
            utilisation={**side.utilisation, **returned, **load.utilisation},
            states={**side.states, **load.states},
        )

    def check_motion(self) -> None:
        """Raise ParameterError if a value that motion requires is missing; the message names it."""
        needed(self.output_inertia, "output_inertia")
        needed(self.motor.rotor_inertia, "motor.rotor_inertia")

    def unheld(self) -> ConventionalDrive:
        """The drive without friction that helps to hold a load at rest: of motor, gearhead, pulley and guideway."""
        return replace(
            self,
            motor=self.motor.without_friction(),
            gearhead=self.gearhead.without_friction(),
            pulley=replace(self.pulley, friction_torque=0.0),
            guideway=Guideway(),
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
        inertia = needed(self.output_inertia, "output_inertia")
        power_out = course.driving_force(load_mass).value * course.speed
        load = chain.inward(self.output, course, load_mass, self.axis, (2, 0))
        course = load.course
        force = course.driving_force(load.mass).value
        drag, guide_loss = self.guideway.operate(force=force, speed=course.heading)
        torque, turning, pulley_loss = self.pulley.operate(force=force + drag, speed=course.heading)
        quickening = course.acceleration / self.pulley.radius
        torque = torque + inertia * quickening
        side = motor_side(
            self.motor, self.gearhead, output_torque=torque, output_speed=turning, output_acceleration=quickening
        )
        power_in, burnt, returned = self.amplifier.supply(side.power)
        return MovingPoint(
            power_in=power_in,
            power_out=power_out,
            losses={
                **side.losses,
                "amplifier": burnt,
                "pulley": pulley_loss,
                "guideway": guide_loss,
                **load.losses,
            },
            stored={"motor": side.stored, "gear and pulley": inertia * quickening * turning, **load.stored},
            utilisation={**placed({**side.utilisation, **returned}), **load.utilisation},
            states={**side.states, "gear_output_torque_Nm": torque, **load.states},
        )
