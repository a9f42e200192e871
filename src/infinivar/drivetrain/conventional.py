"""The conventional drive-train: motor, fixed-ratio gearhead, output stage and guideway."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

from annotated_types import Gt

from infinivar._core.array_namespace import Array, finite_floats, namespace
from infinivar._core.fields import check, component, quantity
from infinivar._core.labels import labelled
from infinivar.axis import ROTARY, Axis
from infinivar.drivetrain.control import ConventionalControl
from infinivar.drivetrain.drive import DrivePoint, MovingPoint, motor_side, needed, placed
from infinivar.drivetrain.output import Output
from infinivar.errors import ParameterError
from infinivar.motion.course import Course
from infinivar.parts.amplifier import Amplifier
from infinivar.parts.belt import Belt, Rack
from infinivar.parts.gearhead import Gearhead
from infinivar.parts.linear import Guideway, Pulley
from infinivar.parts.motor import Motor
from infinivar.parts.screw import Screw
from infinivar.parts.stage import OutputStage, Shaft

STAGES = ("pulley", "screw", "belt", "rack", "shaft")
"""Fields of the output stages, of which a conventional drive has exactly one."""


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
    output_inertia: float | None = quantity(
        "kg m^2", Gt(0), "Inertia of gear and output stage at the gear output", default=None
    )
    control: ConventionalControl = component(
        "Controllers for time-domain simulation", default_factory=ConventionalControl
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        given = [name for name in STAGES if getattr(self, name) is not None]
        if len(given) != 1:
            had = f"{' and '.join(given)} are given" if given else "pulley is missing"
            raise ParameterError(f"{had}: the drive must have exactly one of {', '.join(STAGES)}")

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
        return self.stage.axis if self.output.linkage is None else ROTARY

    @property
    def gear_output_inertia(self) -> float | None:
        """Inertia at the gear output, with that of the stage; None if neither is stated. [kg m^2]"""
        known = [one for one in (self.output_inertia, self.stage.own_inertia) if one is not None]
        return sum(known[1:], known[0]) if known else None

    @labelled
    def operate(self, *, speed: Array, force: Array) -> DrivePoint:
        """Steady operating point at a load speed and force, in all four quadrants.

        Parameters
        ----------
        speed : (...,) float   Load speed; at exactly 0 friction helps to hold. [m s^-1]
        force : (...,) float   Force applied by the drive to the load. [N]

        Returns
        -------
        DrivePoint   Inputs broadcast. Powers are finite where infeasible as well: they are the demand.

        Source: faulring2006, section VI-A and Fig 14.
        """
        xp = namespace(self, speed, force)
        speed, force = finite_floats(xp, speed=speed, force=force)
        drag, guide_loss = self.guideway.operate(force=force, speed=speed)
        stage = self.stage
        torque, turning, stage_loss = stage.operate(force=force + drag, speed=speed)
        side = motor_side(self.motor, self.gearhead, output_torque=torque, output_speed=turning)
        power_in, burnt, returned = self.amplifier.supply(side.power)
        return DrivePoint(
            power_in=power_in,
            power_out=force * speed,
            losses={**side.losses, "amplifier": burnt, stage.title: stage_loss, "guideway": guide_loss},
            utilisation={**side.utilisation, **returned, **stage.utilisation(force=force + drag, speed=speed)},
            states=side.states,
        )

    def check_motion(self) -> None:
        """Raise ParameterError if a value that motion requires is missing; the message names it."""
        needed(self.gear_output_inertia, "output_inertia")
        needed(self.motor.rotor_inertia, "motor.rotor_inertia")

    def unheld(self) -> ConventionalDrive:
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
        inertia = needed(self.gear_output_inertia, "output_inertia")
        stage = self.stage
        force = course.driving_force(load_mass).value
        drag, guide_loss = self.guideway.operate(force=force, speed=course.heading)
        torque, turning, stage_loss = stage.operate(force=force + drag, speed=course.heading)
        quickening = course.acceleration / stage.travel_per_radian
        torque = torque + inertia * quickening
        side = motor_side(
            self.motor, self.gearhead, output_torque=torque, output_speed=turning, output_acceleration=quickening
        )
        power_in, burnt, returned = self.amplifier.supply(side.power)
        return MovingPoint(
            power_in=power_in,
            power_out=force * course.speed,
            losses={**side.losses, "amplifier": burnt, stage.title: stage_loss, "guideway": guide_loss},
            stored={"motor": side.stored, f"gear and {stage.title}": inertia * quickening * turning},
            utilisation={
                **placed({**side.utilisation, **returned}),
                **placed(stage.utilisation(force=force + drag, speed=course.speed), stage.title),
            },
            states={**side.states, "gear_output_torque_Nm": torque},
        )
