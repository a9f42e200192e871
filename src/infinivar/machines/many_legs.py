"""Many legs behind one power motor: motor, gearhead and amplifier of a common cylinder, and a machine that its links move."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np
from annotated_types import Gt

from infinivar._core.array_namespace import Array, check_broadcast
from infinivar._core.arrays import real_array
from infinivar._core.bounds import FINITE, NonZero
from infinivar._core.fields import brief, check, check_number, component, quantity
from infinivar._core.result import Result, result
from infinivar.drivetrain.cobotic import CoboticDrive, TurnedCylinder
from infinivar.drivetrain.drive import motor_side, needed
from infinivar.errors import ParameterError, require
from infinivar.limits import Limit
from infinivar.parts.amplifier import Amplifier
from infinivar.parts.gearhead import Gearhead
from infinivar.parts.motor import Motor
from infinivar.parts.shaft_bearings import CylinderBearings, WheelLoad
from infinivar.power import PowerPoint
from infinivar.transmission.configuration import Configuration, over_links
from infinivar.transmission.legs import Legs, LegsPoint
from infinivar.transmission.wrench_set import WrenchSet

_HALVINGS = 40
"""Of the interval in which the largest wrench lies: 1e-12 of it remains."""

_BEYOND = 1.25
"""Multiple of the slip limit of an ideal wheel at which the search starts; rolling resistance adds a few percent at most."""


@result
class MachinePoint(PowerPoint, Result):
    """Operating point of a machine of many legs; arrays that broadcast to one shape, SI.

    Attributes
    ----------
    power_in : (...,) float          From the supply. [W]
    losses : name to (...,) float    From supply to load; those of legs are sums over the legs. [W]
    stored : (...,) float            Power into the inertia of cylinder, gearhead and rotor. [W]
    utilisation : Limit to (...)     Demand over allowance, of the worst leg. [-]
    states : name to (...,) float    Of the motor; each name ends in its unit.
    legs : LegsPoint                 The legs.
    """

    power_in: Array
    losses: Mapping[str, Array]
    stored: Array
    utilisation: Mapping[Limit, Array]
    states: Mapping[str, Array]
    legs: LegsPoint
    contact: ClassVar[str] = LegsPoint.contact

    @property
    def contact_losses(self) -> Mapping[str, Array]:
        """By name, of each leg. (..., n) [W]"""
        return self.legs.contact_losses

    @property
    def slip_demand(self) -> Array:
        """1 is the slip limit. (..., n) [-]"""
        return self.legs.slip_demand

    @property
    def power_out(self) -> Array:
        """Power to the load, ``W xi``. [W]"""
        return self.legs.power_out

    @property
    def loss(self) -> Array:
        """Sum of all losses. [W]"""
        return sum(self.losses.values())  # type: ignore[return-value]


class Driven(NamedTuple):
    """What is behind the cylinder; see `MachinePoint` for units."""

    power_in: Array
    losses: Mapping[str, Array]
    stored: Array
    utilisation: Mapping[Limit, Array]
    states: Mapping[str, Array]


@dataclass(frozen=True, slots=True, kw_only=True)
class LeggedDrive(TurnedCylinder):
    """One motor turns the common cylinder of n legs.

    Source: faulring2006, section I and section VI.
    """

    motor: Motor = component("Motor of the common cylinder")
    gearhead: Gearhead = component("Gearhead between motor and cylinder")
    legs: Legs = component("The legs")
    cylinder_speed: float = quantity("rad/s", NonZero(), "Speed of the cylinder")
    amplifier: Amplifier = component("Amplifier of the motor", default_factory=Amplifier)
    cylinder_inertia: float | None = quantity("kg m^2", Gt(0), "Inertia of the cylinder about its axis", default=None)
    cylinder_bearings: CylinderBearings | None = component(
        "The cylinder's own bearings, under the vector sum of the legs' loads; without them not counted", default=None
    )

    __repr__ = brief

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        if self.cylinder_bearings is not None:
            self.cylinder_bearings.around(self.legs.count)

    @classmethod
    def of(cls, leg: Any, count: int) -> LeggedDrive:
        """The drive with as many legs like that of a `CoboticDrive`, whose output must not have springs or a linkage.

        Raises
        ------
        ParameterError
            If it has, it is another drive, or the number of legs is not 1 or more.
        """
        if not isinstance(leg, CoboticDrive):
            raise ParameterError(f"leg must be a CoboticDrive, got a {type(leg).__name__}")
        if leg.output.chain:
            raise ParameterError("output must have no springs or linkage: the legs act on the machine directly")
        return cls(
            motor=leg.motor,
            gearhead=leg.gearhead,
            legs=Legs(transmission=leg.transmission, count=count, guideway=leg.guideway),
            cylinder_speed=leg.cylinder_speed,
            amplifier=leg.amplifier,
            cylinder_inertia=leg.inertia_of_cylinder,
            cylinder_bearings=leg.cylinder_bearings,
        )

    def operate(
        self,
        configuration: Configuration,
        *,
        wrench: Array,
        twist: Array | None = None,
        cylinder_speed: Array | None = None,
        cylinder_acceleration: Array | None = None,
    ) -> MachinePoint:
        """Steady operation at poses, all losses and limits.

        Parameters
        ----------
        configuration : Configuration            Of as many links as there are legs.
        wrench : (..., d) float                  W, which the machine applies to its load.
        twist : (..., d) float                   None: all wheels locked, see `Legs.operate`.
        cylinder_speed : (...,) float            By default that of the drive. [rad s^-1]
        cylinder_acceleration : (...,) float     Of a cylinder whose speed varies; this needs the inertias. [rad s^-2]

        Returns
        -------
        MachinePoint   Inputs broadcast. Where a wheel would slip or a rod does not reach, all powers are nan.

        Source: faulring2006, Fig 10, Fig 12 and Fig 13.
        """
        speed = real_array("cylinder_speed", self.cylinder_speed if cylinder_speed is None else cylinder_speed)
        rise = None if cylinder_acceleration is None else real_array("cylinder_acceleration", cylinder_acceleration)
        legs = self.legs.operate(configuration, cylinder_speed=speed, wrench=wrench, twist=twist)
        drag, _ = self.legs.guideway.operate(
            force=legs.link_force, speed=legs.link_speed, preload=self.legs.transmission.preload
        )
        rubbing, rubbed = self.turned(speed, legs.leg_torque, legs.link_force + drag, configuration.link_position)
        behind = self.driven(legs.torque + rubbing, speed, rise)
        utilisation = dict(legs.utilisation)
        for limit, demand in behind.utilisation.items():
            known = utilisation.get(limit)
            utilisation[limit] = demand if known is None else np.maximum(known, demand)
        return MachinePoint(
            power_in=behind.power_in,
            losses={**behind.losses, **rubbed, **legs.losses},
            stored=behind.stored,
            utilisation=utilisation,
            states=behind.states,
            legs=legs,
        )

    def driven(self, torque: Array, speed: Array, rise: Array | None = None) -> Driven:
        """Motor, gearhead, amplifier and inertia behind the torque on the cylinder.

        Parameters
        ----------
        torque : (...,) float        On the cylinder: of all legs, and of its bearings. [N m]
        speed, rise : (...,) float   Of the cylinder, and its acceleration; None where its speed is constant. [rad s^-1],
            [rad s^-2]

        Source: faulring2006, Fig 12.
        """
        stored = np.zeros(())
        if rise is not None:
            require(bool(np.all(np.isfinite(rise))), "cylinder_acceleration", "nan or inf", "finite", "rad/s^2")
            check_broadcast(cylinder_acceleration=np.shape(rise), points=np.shape(torque))
            turning = needed(self.cylinder_inertia, "cylinder_inertia") * rise
            torque, stored = torque + turning, turning * speed
        side = motor_side(
            self.motor,
            self.gearhead,
            output_torque=torque,
            output_speed=speed,
            output_acceleration=rise,
        )
        power_in, burnt, returned = self.amplifier.supply(side.power)
        return Driven(
            power_in,
            {**side.losses, "amplifier": burnt},
            stored + side.stored,
            {**side.utilisation, **returned},
            {**side.states, "cylinder_torque_Nm": torque},
        )

    def turned(
        self, speed: Array, torque: Array, force: Array, position: Array = 0.0
    ) -> tuple[Array, dict[str, np.ndarray]]:
        """Torque on the cylinder that its bearings need under all wheels, and the losses there; 0 and none if not stated.

        Parameters
        ----------
        speed : (...,) float              Of the cylinder. [rad s^-1]
        torque, force : (..., n) float    Of the cylinder on each wheel, and of each wheel on its link. [N m], [N]
        position : (..., n) float         Of the links. [m]

        Source: `infinivar.parts.shaft_bearings.CylinderBearings.operate`.
        """
        bearings, wheel, count = self.cylinder_bearings, self.legs.transmission, self.legs.count
        if bearings is None:
            return 0.0, {}
        shape = np.broadcast_shapes(np.shape(torque), np.shape(force))
        every = [np.broadcast_to(one, shape) for one in (wheel.preload, torque, force, position)]
        wheels = [
            WheelLoad(preload, tau, pushed, wheel.cylinder_radius, at, azimuth)
            for azimuth, preload, tau, pushed, at in zip(
                bearings.around(count), *(np.moveaxis(one, -1, 0) for one in every), strict=True
            )
        ]
        rolling = np.asarray(wheel.groups(np.asarray(speed)[..., None]).rolling_force)
        whole = np.sum(np.broadcast_to(rolling, (*rolling.shape[:-1], count)), axis=-1)
        return bearings.operate(wheels, np.asarray(speed), torque=over_links(np.add, every[1]), rolling=whole)

    def largest_wrench(
        self,
        configuration: Configuration,
        direction: Array,
        *,
        twist: Array | None = None,
        cylinder_speed: Array | None = None,
    ) -> np.ndarray:
        """Largest multiple of a wrench within all limits: slip, steering range, motor, gearhead, kinematics.

        Parameters
        ----------
        configuration : Configuration   Of as many links as components of the twist.
        direction : (..., d) float      The wrench that the machine applies to its load, such as 1 N along x.
        twist, cylinder_speed           As in `operate`; None: locked.

        Returns
        -------
        (...,) float   nan where a limit is exceeded without a wrench. [-]

        Notes
        -----
        By bisection: the first wrench beyond a limit on the way up, if limits are not met again beyond it.
        """
        self.legs.check_links(configuration)
        along = configuration.vector(direction, "direction")
        require(bool(np.all(np.any(along != 0, axis=-1))), "direction", "0", "a wrench that is not 0")
        with np.errstate(divide="ignore", invalid="ignore"):
            unit = np.max(np.abs(configuration.link_forces(along)), axis=-1)
            most = _BEYOND * np.max(self.legs.transmission.slip_force) / unit
        motion = {"twist": twist, "cylinder_speed": cylinder_speed}

        def within(multiple: np.ndarray) -> np.ndarray:
            return self.operate(configuration, wrench=multiple[..., None] * along, **motion).limit == Limit.OK

        sound = within(np.zeros_like(most))
        low, high = np.zeros(sound.shape), np.broadcast_to(np.where(np.isfinite(most), most, 0.0), sound.shape)
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            good = within(middle)
            low, high = np.where(good, middle, low), np.where(good, high, middle)
        return np.where(sound & np.isfinite(most), low, np.nan)

    def wrench_set(
        self, configuration: Configuration, *, twist: Array | None = None, cylinder_speed: float | None = None
    ) -> WrenchSet:
        """Wrenches on the load that ideal wheels exert at one pose without slip, within the continuous torque of the motor.

        Parameters
        ----------
        configuration : Configuration   One pose.
        twist : (d,) float              None: at rest, where the motor does not limit a wrench.
        cylinder_speed : float          By default that of the drive. [rad s^-1]

        Returns
        -------
        WrenchSet   The zonotope of ``mu P cos(phi)`` of each leg, cut where the power to or from the load would exceed that
            of the continuous torque with the losses without a wrench; see `largest_wrench` for the limits of real wheels.

        Raises
        ------
        ParameterError
            If the pose is singular, or the motor cannot sustain the motion without a wrench.
        """
        self.legs.check_links(configuration)
        speed = self.cylinder_speed if cylinder_speed is None else cylinder_speed
        check_number("cylinder_speed", speed, "rad/s", FINITE)
        if twist is None:
            return WrenchSet.of(configuration, np.broadcast_to(self.legs.transmission.slip_force, (self.legs.count,)))
        xi = configuration.vector(twist, "twist")
        require(xi.ndim == 1, "twist", f"shape {xi.shape}", f"one row of {configuration.freedoms}")
        require(bool(speed != 0 or not np.any(xi)), "cylinder_speed", "0", "other than 0 rad/s to move the machine")
        zonotope = WrenchSet.of(configuration, self.legs.force_limits(configuration.link_speeds(xi), np.asarray(speed)))
        if not np.any(xi):
            return zonotope
        unloaded = self.operate(configuration, wrench=np.zeros(configuration.freedoms), twist=xi, cylinder_speed=speed)
        idle = float(unloaded.states["cylinder_torque_Nm"] * speed)
        spare = self.continuous_power(speed) - idle
        if not spare >= 0.0:
            raise ParameterError(
                f"twist must be one that the motor sustains without a wrench; its power falls short by {-spare:.3g} W"
            )
        return zonotope.cut(xi, spare).cut(-xi, self.continuous_power(speed, braking=True) + idle)

    def continuous_power(self, cylinder_speed: float, *, braking: bool = False) -> float:
        """Power at the cylinder at the motor's continuous torque, into the cylinder or, braking, out of it. [W]"""
        low, high = 0.0, 2.0 * self.gearhead.ratio * float(self.motor.continuous_torque)
        sign = np.sign(cylinder_speed) * (-1.0 if braking else 1.0)
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            side = motor_side(
                self.motor,
                self.gearhead,
                output_torque=np.asarray(sign * middle),
                output_speed=np.asarray(cylinder_speed, dtype=float),
            )
            low, high = (middle, high) if np.all(side.utilisation[Limit.THERMAL] <= 1.0) else (low, middle)
        return low * abs(cylinder_speed)
