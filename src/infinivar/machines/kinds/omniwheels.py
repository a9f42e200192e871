"""A platform on omniwheels, whose axles are turned by legs on one common cylinder, or by a drive of their own each.

The wheels roll on the ground without creep; their rollers and rims rub with forces in proportion to the load on the wheel.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np
from annotated_types import Ge, Gt

from infinivar._core.array_namespace import Array
from infinivar._core.bounds import FINITE
from infinivar._core.fields import brief, check, component, given, quantities, quantity, several
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import axis_of, needed
from infinivar.errors import ParameterError
from infinivar.limits import Demand, Limit
from infinivar.machines.bodies import Moved
from infinivar.machines.course import MachineCourse
from infinivar.machines.hand import Grip, PointGrip
from infinivar.machines.kinds.linked import Linked, OnCylinder, SeparateMachine, check_leg
from infinivar.machines.linkage import LeggedMechanics, LinkMotion, Load, Rubbing, rubbed
from infinivar.machines.links import Carried, moved
from infinivar.machines.machine import TaskPoint, rows
from infinivar.machines.many_legs import LeggedDrive
from infinivar.machines.pictures import wheeled
from infinivar.machines.pictures.slides import Drum
from infinivar.machines.pictures.strokes import Picture
from infinivar.machines.pictures.wheeled import Wheeled
from infinivar.machines.supply import fed, source_of
from infinivar.motion.vectors import Point
from infinivar.parts.battery import Battery
from infinivar.transmission.configuration import Configuration
from infinivar.transmission.omniwheels import Omniwheels, in_fixed_axes
from infinivar.units import STANDARD_GRAVITY

_UNITS = ("N m", "rad/s")
"""Of torque and speed of an axle."""


@dataclass(frozen=True, slots=True, kw_only=True)
class OmniwheelLoad(Load):
    """A body on omniwheels, its origin the centre of mass; pose and twist in fixed axes of the plane."""

    wheels: Omniwheels
    ratio: float
    """Speed of a link over that of the rim that it moves; about the axle 1/r. [-] or [m^-1]"""
    mass: float
    inertia: float
    """About the centre of mass. [kg m^2]"""
    rim_mass: float
    """Moment of inertia of a wheel about its axle over the square of its radius. [kg]"""
    rolling_force: float
    """Of a rim. [N]"""
    roller_force: float
    """Of a roller. [N]"""
    wheel_radius: float
    coordinates: tuple[str, ...] = ("v_x_m_s", "v_y_m_s", "w_rad_s")
    configuration: tuple[str, ...] = ("x_m", "y_m", "angle_rad")
    demands: tuple[tuple[Limit, str], ...] = ()
    losses: ClassVar[tuple[str, ...]] = ("wheels", "rollers")
    slides: ClassVar[bool] = False

    @property
    def links(self) -> int:
        """Number of wheels."""
        return len(self.wheels.rim_rows)

    def at(self, pose: np.ndarray, twist: np.ndarray) -> LinkMotion:
        """Kinematics and inertia."""
        angle, turning = pose[:, 2], twist[:, 2, None]
        rubbing = _rubbing(self.wheels, angle, self.rolling_force, self.roller_force)
        rims = rubbing[0].jacobian
        across = np.swapaxes(rims, -1, -2)
        # Rows turn with the body: their rate is that of their first two columns, a vector in the plane.
        rise = turning * (rims[..., 0] * twist[:, 1, None] - rims[..., 1] * twist[:, 0, None])
        inertia = np.diag([self.mass, self.mass, self.inertia]) + self.rim_mass * np.matmul(across, rims)
        bias = self.rim_mass * np.matmul(across, rise[..., None])[..., 0]
        speed = np.matmul(rims, twist[..., None])[..., 0]
        return LinkMotion(
            self.ratio * rims,
            self.ratio * speed,
            self.ratio * rise,
            twist,
            Moved(inertia, bias),
            np.zeros((len(pose), 0)),
            rubbing=rubbing,
        )

    def grip(self, coordinates: int) -> Grip:
        """The centre of mass."""
        return PointGrip(axes=("x", "y"), turns=("angle",), coordinates=coordinates)

    def outline(self, link_mass: float, drum: Drum | None) -> Wheeled:
        """Body and wheels."""
        return Wheeled(
            spots=np.asarray(self.wheels.positions, dtype=float),
            radii=np.full(self.links, self.wheel_radius),
            mass=self.mass,
            inertia=self.inertia,
            headings=np.asarray(self.wheels.headings, dtype=float),
        )


def _rubbing(wheels: Omniwheels, angle: Array, rolling_force: float, roller_force: float) -> tuple[Rubbing, Rubbing]:
    """Friction of rims and rollers of a body turned by angles (...,)."""
    ones = np.ones(len(wheels.rim_rows))
    return (
        Rubbing("wheels", in_fixed_axes(wheels.rim_rows, angle), rolling_force * ones),
        Rubbing("rollers", in_fixed_axes(wheels.roller_rows, angle), roller_force * ones),
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class OmniwheelMachine(OnCylinder):
    """A platform on omniwheels, each turned by a leg on a common cylinder; `OmniwheelDrive.moving` makes it."""

    leg: CoboticDrive
    load: OmniwheelLoad
    ungraphed: ClassVar[str] = "machine must have a bond graph: there is none of a platform on omniwheels"

    def __post_init__(self) -> None:
        """Validate the leg."""
        check_leg(self.leg)

    @property
    def home(self) -> np.ndarray:
        """Pose in the plane at the start."""
        return np.zeros(3)

    def mechanics(self, stick_speed: float) -> LeggedMechanics:
        """Contacts and inertia."""
        return self.on_cylinder(self.load, self.load.links, stick_speed)


@dataclass(frozen=True, slots=True, kw_only=True)
class OmniwheelDrive(Linked):
    """A platform on three omniwheels or more, each turned by a leg on one common cylinder, or by a drive of its own.

    Coordinates are those of the body's reference point, in axes of the plane.

    Source: `infinivar.transmission.omniwheels`.
    """

    WORD: ClassVar[str] = "omniwheels"
    # The speed of a cylinder that carries a whole body swings for nearly half a second, and the wheels steer against that.
    held_time: ClassVar[float] = 1.0
    shown: ClassVar[str] = (
        ", from above: wheels along their rolling directions, the axles of the rollers that stand on the ground, and the forces "
        "on the machine: those of the ground, the tractions of its motors or legs, and of its load."
    )
    MASSES: ClassVar[tuple[str, ...]] = ("mass", "inertia")
    one_of: ClassVar[tuple[str, ...]] = ("leg", "separate")
    """Fields of which exactly one is given."""

    positions: tuple[Point, ...] = several("Points of the wheels, x and y in axes of the body", Point)
    headings: tuple[float, ...] = quantities(
        "rad", FINITE, "Angles from x of the body to the rolling directions of the wheels"
    )
    roller_angles: tuple[float, ...] = quantities(
        "rad",
        FINITE,
        "Angles from the rolling direction to the axle of the roller on the ground, one for all wheels or one for each: "
        "0 for omniwheels, 45 or -45 deg for mecanum wheels",
        default=(0.0,),
    )
    wheel_radius: float = quantity("m", Gt(0), "Radius of the wheels")
    pulley_radius: float | None = quantity(
        "m",
        Gt(0),
        "Radius of the pulley by which a leg or linear drive turns an axle; by default that of the wheel",
        default=None,
    )
    leg: CoboticDrive | None = component("One leg with the motor of the common cylinder", default=None)
    separate: ConventionalDrive | None = component("Drive of each axle, with a motor of its own", default=None)
    battery: Battery | None = component("Battery that feeds all motors", default=None)
    mass: float | None = quantity("kg", Gt(0), "Mass of the platform without a load, for simulation", default=None)
    inertia: float | None = quantity(
        "kg m^2", Gt(0), "Moment of inertia about the reference point, the centre of mass, for simulation", default=None
    )
    wheel_inertia: float = quantity("kg m^2", Ge(0), "Moment of inertia of a wheel about its axle", default=0.0)
    largest_speed: float | None = quantity(
        "m/s", Gt(0), "Largest permissible speed of any wheel's centre", default=None
    )
    wheel_load: float | None = quantity(
        "N", Gt(0), "Load on each wheel; by default the weight of mass shared by all", default=None
    )
    rolling_friction: float = quantity("1", Ge(0), "Rolling resistance of a wheel over its load", default=0.0)
    roller_friction: float = quantity(
        "1", Ge(0), "Force at the rim of a roller that turns, over the load of its wheel", default=0.0
    )
    grip: float | None = quantity(
        "1", Gt(0), "Friction coefficient on the ground; without it slip there is not judged", default=None
    )
    wheels: Omniwheels = field(init=False, repr=False, compare=False, default=None)  # type: ignore[assignment]
    legs: LeggedDrive | None = field(init=False, repr=False, compare=False, default=None)

    __repr__ = brief

    def __post_init__(self) -> None:
        """Validate the fields and make the kinematic map."""
        check(self)
        points = []
        for place, point in enumerate(self.positions, 1):
            for name in point.beyond(("x", "y")):
                raise ParameterError(f"positions {place}: {name} does not apply to a point of a plane; remove it")
            points.append(point.row(("x", "y")))
        angles = self.roller_angles * (len(points) if len(self.roller_angles) == 1 else 1)
        made = Omniwheels(positions=points, headings=self.headings, roller_angles=angles)
        object.__setattr__(self, "wheels", made)
        object.__setattr__(self, "legs", self._legs(self.links))
        if self.wheel_load is None and self.mass is None:
            for name in ("rolling_friction", "roller_friction", "grip"):
                if getattr(self, name):
                    raise ParameterError(
                        f"wheel_load is missing: {name} needs it, or mass, whose weight the wheels share"
                    )

    @property
    def source(self) -> str:  # type: ignore[override]
        """What feeds it."""
        return source_of(self.battery)

    @property
    def links(self) -> int:
        """Number of wheels."""
        return len(self.positions)

    @property
    def coordinates(self) -> tuple[str, ...]:
        """In the plane."""
        return ("x", "y", "angle")

    @property
    def home(self) -> tuple[float, ...]:
        """The origin, with the axes of the body along those of the plane."""
        return (0.0, 0.0, 0.0)

    @property
    def link_lever(self) -> float:
        """Radius over which a linear drive turns an axle. [m]"""
        return given(self.pulley_radius, self.wheel_radius)

    @property
    def load_of_wheel(self) -> float:
        """On each wheel; 0 if not known. [N]"""
        return given(self.wheel_load, given(self.mass, 0.0) * STANDARD_GRAVITY / self.links)

    def configuration(self, pose: Array) -> Configuration:
        """The kinematic map from twists to links over the pulleys, at poses (..., 3)."""
        return self.wheels.at(np.asarray(pose, dtype=float)[..., 2], self.link_lever / self.wheel_radius)

    def part_speeds(self, pose: np.ndarray, twist: np.ndarray) -> np.ndarray:
        """Of the rims. (..., n) [m s^-1]"""
        return self.wheels.at(np.asarray(pose, dtype=float)[..., 2]).link_speeds(twist)

    def perform(self, *, pose: Array, twist: Array, wrench: Array) -> TaskPoint:
        """As `infinivar.machines.machine.Machine.perform`; at rest friction does not help to hold the load."""
        pose, twist, wrench = rows(self, pose, twist, wrench)
        load = wrench - rubbed(self._rubbing(pose), twist)[0]
        point = moved(
            self.configuration(pose),
            self.legs,
            self.separate,
            twist,
            load,
            lever=self.link_lever,
            words="wheel",
            units=_UNITS,
        )
        still = replace(point, power_out=np.sum(wrench * twist, axis=-1) + 0.0 * point.power_out)
        return fed(self._rubbed(still, pose, twist, np.zeros(())), self.battery)

    def picture(self, point: TaskPoint, pose: np.ndarray, twist: np.ndarray, wrench: np.ndarray) -> Picture:
        """Its wheels from above, with the forces of the ground."""
        return wheeled.picture(wheeled.rolled(self, point, pose, twist, wrench))

    def carried(self, course: MachineCourse) -> Carried:
        """What the wheels carry along a course: the wrench, what accelerates the platform, and its own friction.

        Source: Newton and Euler in fixed axes.
        """
        pose, twist, acceleration = np.broadcast_arrays(course.pose, course.twist, course.acceleration)
        load = course.wrench[1:4] - rubbed(self._rubbing(pose[1:4]), twist[1:4])[0]
        if not self._massless:
            body = self._load().at(pose[1:4].reshape(-1, 3), twist[1:4].reshape(-1, 3)).moved
            load = load + body.forces(acceleration[1:4])
        return Carried(course=course, configuration=self.configuration(course.pose), twist=course.twist, load=load)

    def along(self, carried: Carried) -> TaskPoint:
        """See `infinivar.machines.links`."""
        point = self._along(carried, self.link_lever, "wheel", _UNITS)
        course = carried.course
        rims = self.wheels.at(course.pose[..., 2]).link_speeds(course.twist)
        pushed = (
            self.wheel_inertia / self.wheel_radius**2 * course.rate(rims)[1] if not self._massless else np.zeros(())
        )
        made = self._rubbed(point, course.pose[2], course.twist[2], pushed)
        lost = sum(made.losses[name] for name in OmniwheelLoad.losses)
        return fed(replace(made, stored={**made.stored, "machine": made.stored["machine"] - lost}), self.battery)

    def moving(self, load_mass: float = 0.0, load_inertia: float = 0.0) -> OmniwheelMachine | SeparateMachine:
        """The platform with its inertia, and that of a load, for `infinivar.simulate_machine`.

        Parameters
        ----------
        load_mass, load_inertia : float   Moved with the reference point. [kg], [kg m^2]

        Raises
        ------
        ParameterError
            If an inertia that motion requires is missing, or a separate drive cannot be simulated.
        """
        needed(self.mass, "mass")
        needed(self.inertia, "inertia")
        load = self._load(load_mass, load_inertia)
        if self.leg is None:
            assert self.separate is not None
            return SeparateMachine(separate=self.separate, load=load, home=np.zeros(3))
        needed(self.leg.steering, "leg.steering")
        return OmniwheelMachine(leg=self.leg, load=load)

    def _load(self, load_mass: float = 0.0, load_inertia: float = 0.0) -> OmniwheelLoad:
        turns = self.separate is not None and axis_of(self.separate).rotary
        return OmniwheelLoad(
            wheels=self.wheels,
            ratio=(1.0 if turns else self.link_lever) / self.wheel_radius,
            mass=self.mass + load_mass,  # type: ignore[operator]
            inertia=self.inertia + load_inertia,  # type: ignore[operator]
            rim_mass=self.wheel_inertia / self.wheel_radius**2,
            rolling_force=self.rolling_friction * self.load_of_wheel,
            roller_force=self.roller_friction * self.load_of_wheel,
            wheel_radius=self.wheel_radius,
        )

    def _rubbing(self, pose: np.ndarray) -> tuple[Rubbing, Rubbing]:
        """Friction of wheels and rollers at poses (..., 3)."""
        load = self.load_of_wheel
        return _rubbing(self.wheels, pose[..., 2], self.rolling_friction * load, self.roller_friction * load)

    def _rubbed(self, point: TaskPoint, pose: np.ndarray, twist: np.ndarray, pushed: np.ndarray) -> TaskPoint:
        """The point with the losses of wheels and rollers, and slip on the ground; `pushed` accelerates the rims (..., n)."""
        lost = {name: loss + 0.0 * point.part_losses for name, loss in rubbed(self._rubbing(pose), twist)[1].items()}
        demands: dict[Demand, np.ndarray] = {}
        if self.grip is not None:
            traction = np.hypot(*self.on_ground(point, pose, twist, pushed))
            for place, part in enumerate(point.parts):
                demands[Limit.SLIP, f"{part} on the ground"] = traction[..., place] / (self.grip * self.load_of_wheel)
        if self.largest_speed is not None:
            # In axes of the body, as complex numbers: v + omega J p.
            spots = np.asarray(self.wheels.positions) @ np.array([1.0, 1.0j])
            along = (twist[..., 0] + 1.0j * twist[..., 1]) * np.exp(-1.0j * pose[..., 2])
            speed = np.abs(along[..., None] + 1.0j * twist[..., 2, None] * spots)
            demands[Limit.OUTPUT_SPEED, "platform, largest_speed"] = (
                np.max(speed, axis=-1) / self.largest_speed + 0.0 * point.power_in
            )
        return replace(
            point,
            losses={**point.losses, **{name: np.sum(one, axis=-1) for name, one in lost.items()}},
            part_losses=point.part_losses + sum(lost.values()),
            demands={**point.demands, **demands},
        )

    def on_ground(
        self, point: TaskPoint, pose: np.ndarray, twist: np.ndarray, pushed: Array = 0.0
    ) -> tuple[np.ndarray, np.ndarray]:
        """Forces of the ground on the wheels, along the axles of the rollers and across them.

        Parameters
        ----------
        point : TaskPoint              Of these poses and twists.
        pose, twist : (..., 3) float
        pushed : (..., n) float        What accelerates the wheels about their axles, at the rim. [N]

        Returns
        -------
        along, across : (..., n) float   [N]

        Source: balance of moments about the axle, and of forces on the roller; see `infinivar.transmission.omniwheels`.
        """
        rolling, roller = (one.against(twist)[0] for one in self._rubbing(pose))
        angle = np.asarray(self.wheels.roller_angles)
        rim = point.part_forces / self.wheel_radius - rolling - pushed
        return (rim - roller * np.sin(angle)) / np.cos(angle), -roller
