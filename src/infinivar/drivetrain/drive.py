"""Common parts of all drive-trains: operating points, the protocol, and the motor side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple, Protocol, TypeVar, runtime_checkable

from infinivar._core.array_namespace import Array, namespace
from infinivar._core.described import reported
from infinivar._core.fields import given, missing_members
from infinivar._core.labels import Labels
from infinivar._core.plugins import is_own
from infinivar._core.result import Result, result
from infinivar.axis import LINEAR, Axis
from infinivar.drivetrain import extension_checks
from infinivar.errors import ParameterError
from infinivar.limits import Demand, Limit
from infinivar.motion.course import Course
from infinivar.motion.duty_cycles import DutyCycle
from infinivar.parts.gearhead import Gearhead, GearPoint
from infinivar.parts.motor import Motor, MotorPoint
from infinivar.power import AT_POINT, PowerPoint


@result
class DrivePoint(PowerPoint, Result):
    """Steady operating point of a drive-train; arrays that broadcast to one shape, SI.

    `losses` lists every loss from supply to load [W]. `states` holds currents, voltages, angles and similar values; each
    name ends in its unit. Where no steady motion exists, the powers are nan and `limit` gives the reason.
    """

    power_in: Array
    power_out: Array
    losses: Mapping[str, Array]
    utilisation: Mapping[Limit, Array]
    states: Mapping[str, Array] = reported(dims=(...,), default_factory=dict)
    labels: Labels | None = None

    _also = AT_POINT


_INSTANTS = (..., "instant")

T = TypeVar("T")

MOTOR_LIMITS = (*Motor.ALLOWANCES, Limit.REGENERATION)
"""Limits of the motor and its amplifier among those of a motor with its gearhead."""

GEAR_LIMITS = (*Gearhead.ALLOWANCES, Limit.GEAR_MOMENTARY, Limit.RATCHETING)
"""Limits of the gearhead among these."""


@result
class MovingPoint(Result):
    """Instants of a drive-train that follows a motion; arrays that broadcast to one shape, SI.

    Attributes
    ----------
    power_in, power_out : (...,) float    Power from the supply, and to the load including its mass. [W]
    losses : name to (...,) float         Losses from supply to load. [W]
    stored : name to (...,) float         Power into each inertia of the drive; negative where it is returned. [W]
    utilisation : (Limit, part) to (...,) float   Demand over allowance at each instant; for a motor's continuous torque it
        may exceed 1 temporarily. [-]
    states : name to (...,) float         Currents, voltages, angles and similar values; each name ends in its unit.
    """

    power_in: Array = reported("W", "power from the supply", _INSTANTS)
    power_out: Array = reported("W", "power to the load", _INSTANTS)
    losses: Mapping[str, Array] = reported("W", "power lost in {}", _INSTANTS, variable="loss_{}")
    stored: Mapping[str, Array] = reported("W", "power into the inertia of {}", _INSTANTS, variable="stored_{}")
    utilisation: Mapping[Demand, Array] = reported("1", "{}: demand over allowance", _INSTANTS, variable="demand_{}")
    states: Mapping[str, Array] = reported(dims=_INSTANTS)


def chosen(where: Array, one: MovingPoint, other: MovingPoint) -> MovingPoint:
    """Values of one point where a mask is true and of another elsewhere.

    A loss, flow or demand that only one of them has, such as the iron loss of a motor without friction, is 0 in the other;
    a state is nan.
    """
    xp = namespace(where)

    def mixed(name: str, missing: float = 0.0) -> dict:
        mine, others = getattr(one, name), getattr(other, name)
        return {key: xp.where(where, mine.get(key, missing), others.get(key, missing)) for key in {**others, **mine}}

    return MovingPoint(
        power_in=xp.where(where, one.power_in, other.power_in),
        power_out=xp.where(where, one.power_out, other.power_out),
        losses=mixed("losses"),
        stored=mixed("stored"),
        utilisation=mixed("utilisation"),
        states=mixed("states", xp.nan),
    )


DRIVE_NEEDS = ("operate",)
"""What every drive has."""


@runtime_checkable
class Drive(Protocol):
    """A drive-train that moves a load along a line, or about a joint.

    Any object with this method is a drive for steady maps and comparisons. What else a drive may have:

    - ``follow(course, *, load_mass)`` -> `MovingPoint`, for duty cycles: see `MovingDrive`;
    - ``check_motion()`` raises ParameterError if a value that `follow` requires is missing;
    - ``without_static_friction()`` returns the drive without friction that helps to hold a load at rest;
    - ``motors``, a mapping of motors by role, and ``warmed(temperatures)``, the drive with windings at temperatures [K] by
      role, for the heat of motors; `follow` then has the states and losses named in `infinivar.analysis.cycles.duty_cycle`;
    - ``axis``, `LINEAR` by default;
    - ``orders``, the highest time derivative of the load's position that `follow` needs, 4 to 6, by default 4;
    - `operate` may have the argument ``position`` of the load, for springs and linkages.
    """

    def operate(self, *, speed: Array, force: Array) -> DrivePoint:
        """Steady operating point at a load speed [m s^-1] and force on the load [N], in all four quadrants.

        Must be thread-safe: maps are computed on several threads.
        """
        ...


@runtime_checkable
class MovingDrive(Drive, Protocol):
    """A drive whose duty cycles can be computed."""

    def follow(self, course: Course, *, load_mass: Array = 0.0) -> MovingPoint:
        """Operating points along a course with a load [kg], by inverse dynamics."""
        ...


EVERY_MACHINE = ("check", "compare", "sensitivity", "export")
"""Commands that work with every machine: a drive with an end point of its own coordinates, instead of one axis."""


def is_machine(drive: Any) -> bool:
    """Whether a drive is a machine: see `infinivar.machines.machine`."""
    return not isinstance(drive, type) and hasattr(drive, "perform") and hasattr(drive, "coordinates")


def type_words(machine: Any) -> str:
    """The type of a machine as a study names it, such as "platform"."""
    return getattr(type(machine), "WORD", type(machine).__name__)


def commands_of(machine: Any, refused: str = "") -> str:
    """Words on the commands that work with a machine, without the one that was just refused, or without its form."""
    session = ("session",) if getattr(machine, "session", ()) else ()
    known = (*EVERY_MACHINE, *getattr(machine, "commands", ()), *session)
    said = (f"{one} in another form" if refused.startswith(f"{one} ") else one for one in known if one != refused)
    return f"commands for this machine: {', '.join(said)}"


def refuse_machine(drive: Any, what: str, where: str = "drive") -> None:
    """Raise ParameterError if a drive is a machine; the message names the commands that work with it.

    Parameters
    ----------
    drive : object
    what : str       Of drives of one axis: a command such as "sensitivity", or "this analysis".
    where : str      Path of the drive, such as "drives.cart".
    """
    if is_machine(drive):
        raise ParameterError(
            f"{where} is a machine of type {type_words(drive)}: {what} does not work with it; {commands_of(drive, what)}"
        )


def check_drive(drive: Any, where: str, needs: Sequence[str] = DRIVE_NEEDS) -> None:
    """Raise ParameterError unless an object has the methods of a drive; the message names the missing one."""
    refuse_machine(drive, "this analysis", where)
    missing = missing_members(drive, needs)
    if missing or isinstance(drive, type):
        what = f"the class {drive.__name__}" if isinstance(drive, type) else f"a {type(drive).__name__}"
        lacking = f", which has no method {missing[0]}" if missing else ", not an instance of it"
        if isinstance(drive, str):
            lacking += f"; write study.drives[{drive!r}]"
        raise ParameterError(f"{where} must be a drive, got {what}{lacking}")


def axis_of(drive: Any) -> Axis:
    """Whether a drive moves a load along a line or about a joint."""
    return getattr(drive, "axis", LINEAR)


def orders_of(drive: Any) -> int:
    """Highest time derivative of the load's position that a drive's `follow` needs."""
    return getattr(drive, "orders", 4)


def operated(drive: Any, *, speed: Array, force: Array, position: Array = 0.0) -> DrivePoint:
    """Steady operating point of any drive; what a drive of another package returns is checked first.

    The position of the load is passed on if it is not exactly the number 0.

    Raises
    ------
    ParameterError
        If the drive has no method `operate`, it fails or returns something else than a `DrivePoint`, a value is no number,
        or its utilisation is not of limits, nan or negative.
    AuditError
        If the power to the load is not force times speed.
    """
    check_drive(drive, "drive")
    placed_at = {} if isinstance(position, (int, float)) and position == 0 else {"position": position}
    with extension_checks.naming_failures(drive, "operate", "operate(*, speed, force), which returns a DrivePoint"):
        point = drive.operate(speed=speed, force=force, **placed_at)
        if is_own(drive):
            where = f"{type(drive).__name__}.operate"
            extension_checks.check_kind(point, DrivePoint, where)
            extension_checks.check_steady(point, speed * force, where)
    return point


def followed(drive: Any, course: Course, *, load_mass: Array = 0.0, **options: Any) -> MovingPoint:
    """Operating points of any drive along a course; those of a drive of another package are audited at each instant.

    Raises
    ------
    ParameterError
        If a method is missing, or `follow` fails, returns something else than a `MovingPoint`, or values that cannot be.
    AuditError
        If the power to the load is not force times speed, a loss is negative, a power is nan although the wheel does not
        slip, or the powers do not balance.
    """
    check_drive(drive, "drive", ("operate", "follow"))
    with extension_checks.naming_failures(drive, "follow", "follow(course, *, load_mass), which returns a MovingPoint"):
        point = drive.follow(course, load_mass=load_mass, **options)
        if is_own(drive):
            where = f"{type(drive).__name__}.follow"
            extension_checks.check_kind(point, MovingPoint, where)
            extension_checks.check_moving(point, course.driving_force(load_mass).value * course.speed, where)
    return point


def check_graph(drive: Any) -> None:
    """Raise ParameterError if a drive or a part is of another package: the equations of a simulation lack its law."""
    if is_own(drive):
        raise ParameterError(f"a drive of type {type(drive).__name__} has no bond graph")
    for place in extension_checks.own_parts(drive):
        raise ParameterError(
            f"{place.path} is of type {type(place.value).__name__}, whose law is in no bond graph, as simulation needs; "
            "steady maps and duty cycles work without"
        )


def axis_fault(drive: Drive, axis: Axis, name: str, task: str) -> str | None:
    """Say what does not fit if a drive's load moves along a line and a task is about a joint, or the reverse; else None."""
    if axis_of(drive) is axis:
        return None
    if axis.rotary:
        return f"{task} is about a joint; {name} moves along a line: give it a linkage, [{name}.output.linkage]"
    return f"{task} is along a line; {name} moves a joint: state the motion by angles and moments"


def smoothness_fault(drive: Drive, task: DutyCycle, name: str, where: str) -> str | None:
    """Say what does not fit if a motion would make a drive's speed jump behind a series compliance; else None.

    A compliance that carries the load's inertia needs a jerk without jumps, and so does an elastic gearhead, which carries the
    inertia at the gear output. Behind both, an inertia is moved by what already contains the jerk's rate.
    """
    output = getattr(drive, "output", None)
    passed = getattr(drive, "chain", () if output is None else output.chain)
    behind = [f"its {place.name}" for place in passed if place.kind == "series"] if task.moved_mass else []
    needed_order = _JERK if behind else 0
    if getattr(drive, "elastic_gear", False):
        needed_order = needed_order + 2 if behind else _JERK
        behind.append("its elastic gearhead")
    if task.motion.continuous >= needed_order:
        return None
    if needed_order == _JERK:
        what, how = "jerk", "set profile = 'smooth'"
    else:
        what, how = "fifth derivative", "use a sinusoid or a recording, or leave gearhead.stiffness out"
    return (
        f"{where}: the {what} of this motion jumps, and with it the speed of {name} behind {' and '.join(behind)}, by way of the "
        f"inertia that they carry; {how}"
    )


_JERK = 3
"""Order of the derivative of the load's position that sets the drive's speed behind a series compliance."""


class MotorSide(NamedTuple):
    """Motor and gearhead behind an output torque and speed."""

    power: Array
    """Electrical power at the motor; negative where it generates. [W]"""
    losses: dict[str, Array]
    utilisation: dict[Limit, Array]
    states: dict[str, Array]
    stored: Array
    """Power into the inertia of rotor and gearhead. [W]"""


def motor_side(
    motor: Motor,
    gearhead: Gearhead,
    *,
    output_torque: Array,
    output_speed: Array,
    output_acceleration: Array | None = None,
) -> MotorSide:
    """Operation of motor and gearhead at an output torque and speed.

    Parameters
    ----------
    output_torque, output_speed : (...,) float   Of the gearhead. [N m], [rad s^-1]
    output_acceleration : (...,) float           [rad s^-2]; None where the speed is constant.

    Raises
    ------
    ParameterError
        If the speed varies and the rotor inertia is missing.

    Source: faulring2006, Fig 12 and Fig 14.
    """
    gear = gearhead.operate(
        output_torque=output_torque, output_speed=output_speed, motor_rated_torque=motor.continuous_torque
    )
    if is_own(gearhead):
        extension_checks.check_kind(gear, GearPoint, f"{type(gearhead).__name__}.operate")
    torque, stored = gear.motor_torque, 0.0 * gear.motor_speed
    if output_acceleration is not None:
        extra = shaft_inertia(motor, gearhead) * gearhead.ratio * output_acceleration
        torque, stored = torque + extra, extra * gear.motor_speed
    electric = motor.operate(torque=torque, speed=gear.motor_speed)
    if is_own(motor):
        extension_checks.check_kind(electric, MotorPoint, f"{type(motor).__name__}.operate")
    states = {
        "motor_current_A": electric.current,
        "motor_voltage_V": electric.voltage,
        "motor_torque_Nm": torque,
        "motor_speed_rad_s": gear.motor_speed,
    }
    return MotorSide(
        electric.power,
        {**electric.losses, "gearhead": gear.loss},
        {**electric.utilisation, **gear.utilisation},
        states,
        stored,
    )


def placed(utilisation: Mapping[Limit, Array], motor: str = "motor") -> dict[Demand, Array]:
    """Demands on one motor and its gearhead, keyed by limit and part."""
    return {(limit, "gearhead" if limit in GEAR_LIMITS else motor): demand for limit, demand in utilisation.items()}


def needed(value: T | None, field: str) -> T:
    """The value; raises ParameterError if it is None, naming the field."""
    if value is None:
        raise ParameterError(f"{field} is missing: motion needs it")
    return value


def shaft_inertia(motor: Motor, gearhead: Gearhead) -> float:
    """Inertia of rotor and gearhead at the motor's shaft; ParameterError if that of the rotor is missing. [kg m^2]"""
    return needed(motor.rotor_inertia, "motor.rotor_inertia") + given(gearhead.inertia, 0.0)


def with_rated_gear(drive: T) -> T:
    """The drive with an explicit rated torque of its gear; by default that is the motor's continuous torque."""
    gearhead, motor = getattr(drive, "gearhead", None), getattr(drive, "motor", None)
    if not isinstance(gearhead, Gearhead) or motor is None:
        return drive
    rated = gearhead.rated_at(motor.continuous_torque)
    return drive if rated is gearhead else replace(drive, gearhead=rated)  # type: ignore[type-var]
