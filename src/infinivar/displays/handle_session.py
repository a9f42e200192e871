"""Parts of a session at the handle, and what each costs a display, from quasi-static points over one period of the part.

All axes do the same at once. A display with legs on one cylinder is moved by inverse dynamics of its wheels and of the servos
that steer them; a display with geared drives commands currents from the force that it renders, as its controller does.
What a controller adds in time, such as noise, delay and vibration, is left out; `infinivar.session` has it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from annotated_types import Ge, Gt, Interval

from infinivar._core.fields import check_instance, check_real, quantity
from infinivar._core.result import Frozen, result
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import motor_side, needed
from infinivar.errors import ParameterError, require
from infinivar.limits import Limit
from infinivar.machines.motors import LinkMotors
from infinivar.motion.course import Course

MOVING, HELD = ("free", "explore"), ("contact", "hold", "idle")
"""Parts in which the handle moves, and in which it rests."""

PARTS = ("free", "contact", "hold", "explore", "idle")

_SHARE = Interval(ge=0, le=1)

_INSTANTS = 400
"""In one period of a part."""

_STICK = 1e-9
"""Speed below which friction of a geared drive counts as sticking; the instants are off rest. [m s^-1]"""


@dataclass(frozen=True, slots=True, kw_only=True)
class HandleSession:
    """What a user does at the handle over and over, in shares of the time; what is left is idle.

    Forces and speeds are those of each axis. *Free*: to and fro without a wall. *Contact*: pushing against a wall from 0 to the
    force and back. *Hold*: against a constant force, at rest. *Explore*: to and fro under a constant force, along a surface.

    Raises
    ------
    ParameterError
        If a field is outside its range, or the shares are more than 1 together.
    """

    round_time: float = quantity("s", Gt(0), "Time in which each part occurs once", default=20.0)
    free: float = quantity("1", _SHARE, "Share of free motion", default=0.25)
    contact: float = quantity("1", _SHARE, "Share of pushing against a wall", default=0.15)
    hold: float = quantity("1", _SHARE, "Share of holding a constant force", default=0.2)
    explore: float = quantity("1", _SHARE, "Share of exploring a surface", default=0.2)
    free_speed: float = quantity("m/s", Gt(0), "Amplitude of the speed in free motion", default=0.2)
    free_frequency: float = quantity("Hz", Gt(0), "Of free motion", default=1.0)
    contact_force: float = quantity("N", Ge(0), "Largest force against the wall", default=30.0)
    contact_frequency: float = quantity("Hz", Gt(0), "Of pushing against the wall", default=1.0)
    hold_force: float = quantity("N", Ge(0), "Force held", default=40.0)
    explore_force: float = quantity("N", Ge(0), "Force under which the surface is explored", default=15.0)
    explore_speed: float = quantity("m/s", Gt(0), "Amplitude of the speed as the surface is explored", default=0.1)
    explore_frequency: float = quantity("Hz", Gt(0), "Of exploring the surface", default=0.5)
    felt_mass: float = quantity(
        "kg", Gt(0), "Mass that a display with a force sensor lets feel, handle included", default=2.0
    )
    required_force: float = quantity("N", Ge(0), "That both displays must be able to hold on each axis", default=50.0)
    required_speed: float = quantity("m/s", Ge(0), "Of an axis without load, that both must reach", default=1.05)
    largest_friction: float | None = quantity(
        "N", Ge(0), "Friction that the user may feel at most; default: any", default=None
    )
    largest_mass: float | None = quantity(
        "kg", Gt(0), "Least mass felt that a display must reach; default: any", default=None
    )
    required_speed_at_force: float = quantity(
        "m/s", Ge(0), "That all axes must reach at once under the required force", default=0.0
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_real(self)
        total = self.free + self.contact + self.hold + self.explore
        words = "at most 1 together with contact, hold and explore"
        require(total <= 1.0 + 1e-12, "free", f"{self.free:g}, {total:g} with them", words)

    @property
    def shares(self) -> Mapping[str, float]:
        """Share of time of each part, with what is left for "idle"."""
        known = {name: float(getattr(self, name)) for name in PARTS[:-1]}
        return {**known, "idle": max(0.0, 1.0 - sum(known.values()))}

    @property
    def largest_force(self) -> float:
        """That is required, or that a part needs. [N]"""
        return max(self.required_force, self.contact_force, self.hold_force, self.explore_force)

    def course(self, part: str, *, felt_mass: float | None = None) -> Course:
        """Motion of the handle over one period of a part, and the force of the user on it.

        Parameters
        ----------
        part : str           One of `PARTS`.
        felt_mass : float    Mass that the user moves in free motion; by default that of the session. [kg]

        Returns
        -------
        Course   At the midpoints of equal steps; the user pushes along the motion.
        """
        angle = 2.0 * math.pi * (np.arange(_INSTANTS) + 0.5) / _INSTANTS
        zero = np.zeros(_INSTANTS)
        if part in MOVING:
            speed, frequency = (self.free_speed, self.free_frequency) if part == "free" else (
                self.explore_speed, self.explore_frequency)  # fmt: skip
            pulse = 2.0 * math.pi * frequency
            sine, cosine = np.sin(angle), np.cos(angle)
            moves = [speed * sine, speed * pulse * cosine, -speed * pulse**2 * sine, -speed * pulse**3 * cosine]
            if part == "explore":
                return Course(**_motion(moves), force=zero - self.explore_force, force_rate=zero, force_curvature=zero)
            mass = self.felt_mass if felt_mass is None else felt_mass
            push = [mass * one for one in (*moves[1:], speed * pulse**4 * sine)]
            return Course(**_motion(moves), force=push[0], force_rate=push[1], force_curvature=push[2])
        still = _motion([zero, zero, zero, zero])
        if part == "contact":
            half, pulse = 0.5 * self.contact_force, 2.0 * math.pi * self.contact_frequency
            return Course(
                **still,
                force=-half * (1.0 - np.cos(angle)),
                force_rate=-half * pulse * np.sin(angle),
                force_curvature=-half * pulse**2 * np.cos(angle),
            )
        force = zero - (self.hold_force if part == "hold" else 0.0)
        return Course(**still, force=force, force_rate=zero, force_curvature=zero)


@result
class PartPower(Frozen):
    """Mean powers of a display in one part of a session, all axes together.

    Attributes
    ----------
    supply : float          From the supply, power motors and steering. [W]
    steering : float        Of that, for steering. [W]
    user : float            From the user. [W]
    winding, steering_winding : float   Heat in the winding of one power motor, and of one steering motor. [W]
    heating, steering_heating : float   Mean square of their current over their continuous current. [-]
    tightest : float        Largest demand over allowance, of any limit but heat, which is judged over a session. [-]
    limit : int             Which limit that is.
    """

    supply: float
    steering: float
    user: float
    winding: float
    steering_winding: float
    heating: float
    steering_heating: float
    tightest: float
    limit: int


def cobotic_part(
    drive: CoboticDrive,
    session: HandleSession,
    part: str,
    *,
    axes: int,
    handle_mass: float,
    slip_feedforward: bool = False,
) -> PartPower:
    """Mean powers of a display of legs on one cylinder that turns.

    Parameters
    ----------
    drive : CoboticDrive     One leg, with steering and the motor of the cylinder.
    session : HandleSession
    part : str               One of `PARTS`.
    axes : int               Legs, one for each axis.
    handle_mass : float      Moved by each link, with the handle. [kg]
    slip_feedforward : bool  Whether wheels that push against a wall follow the slip angle without pause, against the friction of
        their bells. By default they rest; a servo is in between, as small angles do not overcome friction.

    Returns
    -------
    PartPower   nan where a wheel would slip.

    Source: faulring2006, section VI-C, with the torques of all legs on one cylinder; `CoboticDrive.roll`.
    """
    still = part in HELD
    course = session.course(part)
    leg = (
        drive.without_static_friction() if still else drive
    )  # a load that moves by a hair takes away what a guideway holds
    rolled = leg.roll(course, load_mass=handle_mass)
    turning = np.asarray(float(drive.cylinder_speed))
    rubbing, _ = leg.turned(turning, rolled.wheel_torque, rolled.force, course.position, legs=axes)
    side = motor_side(
        drive.motor,
        drive.gearhead,
        output_torque=axes * np.asarray(rolled.wheel_torque) + rubbing,
        output_speed=turning,
    )
    supply = np.asarray(drive.amplifier.supply(side.power)[0])
    moves = part not in ("hold", "idle") and (slip_feedforward or not still)
    scale = 1.0 if moves else 0.0
    steered = needed(drive.steering, "steering").follow(
        drive.transmission,
        rate=scale * np.asarray(rolled.steering.rate),
        acceleration=scale * np.asarray(rolled.steering.curvature),
        patch_moment=None if rolled.patch_moment is None else scale * np.asarray(rolled.patch_moment),
    )
    steering = axes * np.asarray(drive.steering_amplifier.supply(steered.power)[0])
    demands = {**side.utilisation, **rolled.utilisation}
    for limit, demand in steered.utilisation.items():
        demands[limit] = np.maximum(np.max(np.asarray(demands.get(limit, 0.0))), np.max(np.asarray(demand)))
    limit, tightest = _tightest(demands)
    return PartPower(
        supply=_mean(supply) + _mean(steering),
        steering=_mean(steering),
        user=axes * _mean(np.asarray(course.force) * course.speed),
        winding=_mean(side.losses["winding"]),
        steering_winding=_mean(steered.losses["steering winding"]),
        heating=_mean_square(side.utilisation[Limit.THERMAL]),
        steering_heating=_mean_square(steered.utilisation[Limit.THERMAL]),
        tightest=tightest,
        limit=limit,
    )


def stopped_part(drive: CoboticDrive) -> PartPower:
    """Mean powers of the same display with a cylinder at rest: its wheels hold by friction, and the amplifier stands by."""
    return PartPower(
        supply=float(drive.amplifier.standby_power),
        steering=0.0,
        user=0.0,
        winding=0.0,
        steering_winding=0.0,
        heating=0.0,
        steering_heating=0.0,
        tightest=0.0,
        limit=int(Limit.OK),
    )


def geared_part(
    drive: ConventionalDrive,
    session: HandleSession,
    part: str,
    *,
    axes: int,
    handle_mass: float,
    compensation: float = 0.0,
    friction_helps: bool = False,
    force_control: bool = False,
) -> PartPower:
    """Mean powers of a display with a drive of fixed ratio for each axis, which renders forces.

    Parameters
    ----------
    drive : ConventionalDrive   Of one axis.
    session : HandleSession
    part : str                  One of `PARTS`.
    axes : int
    handle_mass : float         Of the handle, on each axis. [kg]
    compensation : float        Share of the constant friction that is fed forward along the motion.
    friction_helps : bool       Whether friction of the drive carries its part of a force at rest. By default the motor carries it
        all, as a load that moves by a hair takes friction away.
    force_control : bool        Whether a force sensor makes it move as the mass of the session: its motor and not the user then
        overcomes friction and inertia.

    Returns
    -------
    PartPower

    Source: faulring2006, section VI-C and Fig 14, at the currents of an impedance display; `LinkMotors.act`.
    """
    motors = LinkMotors(drive=drive, stick_speed=_STICK)
    course = session.course(part, felt_mass=None if force_control else 0.0)
    speed, rendered = np.asarray(course.speed), -np.asarray(course.force)
    friction = sum(motors.frictions)
    if force_control:
        rendered = rendered + (motors.moved_mass + handle_mass) * np.asarray(course.acceleration)
        compensation = 1.0
    if friction_helps and part in HELD:
        rendered = np.maximum(rendered - friction, 0.0)
    current = (rendered + compensation * friction * np.sign(speed)) / motors.gain
    force, electric = motors.act(current[:, None], speed[:, None])
    powers = electric()
    push = (motors.moved_mass + handle_mass) * np.asarray(course.acceleration) - force[:, 0]
    voltage = drive.motor.resistance * current + drive.motor.torque_constant * motors.ratio * speed
    allowed = drive.motor.utilisation(current=current, voltage=voltage, speed=motors.ratio * speed)
    demands = {**allowed, Limit.PEAK: np.abs(current) / motors.current_limit}
    limit, tightest = _tightest(demands)
    return PartPower(
        supply=axes * _mean(powers["supply"]),
        steering=0.0,
        user=axes * _mean(push * speed),
        winding=_mean(powers["winding"]),
        steering_winding=0.0,
        heating=_mean_square(current / drive.motor.continuous_current),
        steering_heating=0.0,
        tightest=tightest,
        limit=limit,
    )


def check_displays(cobotic: object, geared: object) -> None:
    """Raise ParameterError unless both drives move a handle along a line and state what motion needs."""
    check_instance("cobotic", cobotic, CoboticDrive)
    check_instance("conventional", geared, ConventionalDrive)
    assert isinstance(cobotic, CoboticDrive)
    assert isinstance(geared, ConventionalDrive)
    for name, drive in (("cobotic", cobotic), ("conventional", geared)):
        if drive.axis.rotary or drive.output.chain:
            raise ParameterError(f"{name} must move the handle along a line, without springs or a linkage")
    try:
        cobotic.check_motion()
        needed(cobotic.inertia_of_cylinder, "cylinder_inertia")
    except ParameterError as problem:
        raise ParameterError(f"cobotic.{problem}") from None
    try:
        _ = LinkMotors(drive=geared, stick_speed=_STICK)
    except ParameterError as problem:
        raise ParameterError(f"conventional.{problem}") from None


def _motion(moves: list[np.ndarray]) -> dict[str, Any]:
    return dict(zip(("speed", "acceleration", "jerk", "snap"), moves, strict=True))


def _mean(values: object) -> float:
    return float(np.mean(np.asarray(values)))


def _mean_square(values: object) -> float:
    return float(np.mean(np.asarray(values) ** 2))


def _tightest(demands: Mapping[Limit, object]) -> tuple[int, float]:
    """The limit with the largest demand, but for heat."""
    found = {limit: float(np.max(np.asarray(demand))) for limit, demand in demands.items() if limit != Limit.THERMAL}
    worst = max(found, key=lambda limit: math.inf if math.isnan(found[limit]) else found[limit])
    return int(worst), found[worst]
