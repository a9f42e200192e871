r"""Haptic displays of one axis, linearised about a locked link: what moves between samples, and what the controller computes.

**Admittance display.** A cobotic drive whose controller measures the user's force, moves a virtual mass by it and steers the
wheel so that the link moves as that mass does. With the link at x, the wheel at the small angle :math:`\phi`, the surface
speed S, and the creep stiffness C, the contact applies to the link

.. math:: f_l = -\frac{C}{S}\left(\dot x + S\phi - \sigma\dot\phi\right) + F_0\phi ,

so that the link follows :math:`-S\phi` with the creep lag :math:`m S/C`. Where steering is spin, :math:`\sigma` couples it to the
lateral creep, as in linear theory, and the patch resists steering with a moment.

**Impedance display.** A geared drive whose controller measures the position and applies the force of a virtual wall. It feels as
the reflected mass of motor and gear, or, with a force sensor behind the handle that the motor helps g times, as that over 1 + g.

Left out of both, as they are not linear: Coulomb friction of motors, gears, bells, patches and guideways (a servo of the program
feeds it forward), quantisation of encoders, noise, limits of current and voltage, slip. A motor is a source of current. Loss in a
gear that is proportional to its load counts as Coulomb friction. The patch is in steady rolling.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
from annotated_types import Ge, Gt

from infinivar._core.arrays import shown
from infinivar._core.fields import check_instance, check_real, component, given, quantity
from infinivar.contact.exact.spin_map import scales
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.control.loops import Servo
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import needed
from infinivar.drivetrain.graphs.compliances import rotor_inertia
from infinivar.errors import ParameterError
from infinivar.machines.system import SteeringServo
from infinivar.motion.users import ArmModel
from infinivar.transmission.spin_law import TurningPatch

Held: TypeAlias = ArmModel | Literal["free", "clamped"]
"""What is at the handle: an arm, nothing, or a rigid clamp."""


class Plant(NamedTuple):
    """What moves between samples: ``p' = system p + current i + force F``, sensed as ``y = sensed p + passed F``."""

    states: tuple[str, ...]
    """Names, with units; none where a clamp holds all that could move."""
    system: np.ndarray
    current: np.ndarray
    """By the current of the motor that the controller commands. [A]"""
    force: np.ndarray
    """By a force of the user on the handle, beside that of the arm. [N]"""
    sensed: np.ndarray
    passed: np.ndarray

    @property
    def moves(self) -> bool:
        """Whether the handle can move."""
        return "x_m" in self.states


class Sensed(NamedTuple):
    """What a controller measures; each a number, or a row of them."""

    force: Any
    """Of the sensor behind the handle, filtered. [N]"""
    position: Any
    """Of the handle. [m]"""
    speed: Any
    angle: Any
    """Of the wheel; 0 without one. [rad]"""
    turning: Any


@dataclass(frozen=True, slots=True, kw_only=True)
class AdmittanceDisplay:
    """A cobotic drive that moves as a virtual mass does under the force of the user.

    The force sensor is between handle and link, and its filter is analogue. Sample rate, bandwidth of the steering servo and, for
    `wall` = "virtual", of the link's position loop are those of ``drive.control``. The virtual mass is integrated by the implicit
    Euler method.

    Raises
    ------
    ParameterError
        If a field is outside its range, or the drive lacks what motion needs.
    """

    drive: CoboticDrive = component("The drive: its link moves the handle")
    virtual_mass: float = quantity("kg", Gt(0), "Mass that the user is to feel")
    virtual_damping: float = quantity("N s/m", Ge(0), "Damping of the virtual mass", default=0.0)
    wall_stiffness: float = quantity("N/m", Ge(0), "K, stiffness of the virtual wall; 0: free motion", default=0.0)
    wall_damping: float = quantity(
        "N s/m", Ge(0), "B, damping of the virtual wall, on the speed of the virtual mass", default=0.0
    )
    handle_mass: float = quantity("kg", Ge(0), "Mass of the handle, beyond the force sensor", default=0.0)
    filter_frequency: float | None = quantity(
        "Hz", Gt(0), "Corner of the force sensor's filter; default: none", default=None
    )
    filter_order: Literal[1, 2] = component("Order of that filter; 2: Butterworth", default=2)
    wall: Literal["measured", "virtual"] = component(
        "Whose penetration the wall resists: that of the measured handle, or of the virtual mass, which the handle then follows",
        default="measured",
    )
    rate_feedforward: bool = component(
        "Whether the servo receives the rate of the commanded angle as well", default=True
    )
    samples_late: Literal[0, 1] = component("Samples by which what is computed acts late", default=1)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_instance("drive", self.drive, CoboticDrive)
        check_real(self)
        _check_flag("rate_feedforward", self.rate_feedforward)
        _check_output(self.drive)
        self.drive.check_motion()

    @property
    def period(self) -> float:
        """Of a sample. [s]"""
        return 1.0 / float(self.drive.control.sample_rate)

    @property
    def surface_speed(self) -> float:
        """S, of the cylinder. [m s^-1]"""
        return abs(float(self.drive.transmission.cylinder_radius * self.drive.cylinder_speed))

    @property
    def memory(self) -> tuple[str, ...]:
        """Names of what the controller keeps: speed of the virtual mass, and its position if the wall is there."""
        return ("v_m_s",) if self.wall == "measured" else ("v_m_s", "x_v_m")

    def softest(self) -> AdmittanceDisplay:
        """The same in free motion."""
        return replace(self, wall_stiffness=0.0, wall_damping=0.0)

    def plant(self, held: Held = "free") -> Plant:
        """What moves between samples: handle with what holds it, wheel, and filter of the force sensor.

        Source: faulring2006, section II, linearised at a steering angle of 0; contact as in `infinivar.transmission.spin_law`.
        """
        arm, clamped = _held(held)
        drive, filtered = self.drive, 0 if self.filter_frequency is None else self.filter_order
        link = float(needed(drive.mass_of_link, "link_mass"))
        mass = link + self.handle_mass + arm.mass
        servo, contact = _steering(drive), _Contact.of(drive)
        iron = given(servo.plant.motor.viscous_friction, 0.0) * servo.plant.ratio**2
        corner = 2.0 * math.pi * given(self.filter_frequency, 1.0)
        count = 0 if clamped else 2

        def split(state: np.ndarray) -> tuple[Any, Any, Any, Any]:
            position, speed = (0.0 * state[0], 0.0 * state[0]) if clamped else (state[0], state[1])
            return position, speed, state[count], state[count + 1]

        def sensor(state: np.ndarray, force: Any) -> tuple[Any, Any]:
            """Force between handle and link, and acceleration of both."""
            position, speed, angle, turning = split(state)
            driven = contact.link_force(speed, angle, turning)
            if clamped:
                return -driven, 0.0 * driven
            acceleration = (driven + force - arm.damping * speed - arm.stiffness * position) / mass
            return link * acceleration - driven, acceleration

        def rates(state: np.ndarray, current: Any, force: Any) -> list[Any]:
            _, speed, angle, turning = split(state)
            felt, acceleration = sensor(state, force)
            torque = servo.gain * current - iron * turning - contact.moment(speed, angle, turning)
            moving = [] if clamped else [speed, acceleration]
            return [*moving, turning, torque / servo.inertia, *_filter(felt, state[count + 2 :], corner)]

        def sensed(state: np.ndarray, force: Any) -> Sensed:
            raw = sensor(state, force)[0]
            return Sensed(state[count + 2] if filtered else raw, *split(state))

        moving = () if clamped else ("x_m", "v_m_s")
        names = (*moving, "phi_rad", "phi_rate_rad_s", *("filtered_N", "filtered_rate_N_s")[:filtered])
        return _linear(names, rates, sensed)

    def act(self, memory: np.ndarray, sensed: Sensed) -> tuple[list[Any], Any]:
        """Memory and current of the steering motor that the controller computes from one sample.

        Source: `infinivar.drivetrain.control.loops.Servo`, without limit and friction, steered as by its link loop.
        """
        period, surface, control = self.period, self.surface_speed, self.drive.control
        mass, damping, stiffness = self.virtual_mass, self.virtual_damping + self.wall_damping, self.wall_stiffness
        before = memory[0]
        if self.wall == "measured":
            speed = (mass * before + period * (sensed.force - stiffness * sensed.position)) / (mass + period * damping)
            kept, demanded, demanded_acceleration = [speed], speed, (speed - before) / period
        else:
            push = sensed.force - stiffness * memory[1]
            speed = (mass * before + period * push) / (mass + period * (damping + period * stiffness))
            place, gain = memory[1] + period * speed, 2.0 * math.pi * control.link_bandwidth
            kept, demanded = [speed, place], speed + gain * (place - sensed.position)
            demanded_acceleration = (speed - before) / period + gain * (speed - sensed.speed)
        servo = self.servo
        rate = -demanded_acceleration / surface if self.rate_feedforward else 0.0 * speed
        error = -demanded / surface - sensed.angle
        return kept, servo.proportional * error + servo.damping * (rate - sensed.turning)

    @property
    def servo(self) -> Servo:
        """Steering servo as the program places it, for small errors."""
        found = _steering(self.drive)
        return Servo.place(self.drive.control.steering_bandwidth, found.inertia, found.gain, math.inf, 0.0, 1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class ImpedanceDisplay:
    """A geared drive that applies the force of a virtual wall from the measured position.

    The speed is the difference of two positions. The sample rate is that of ``drive.control``.

    Raises
    ------
    ParameterError
        If a field is outside its range, or the drive is not rigid, lacks what motion needs, or moves a joint.
    """

    drive: ConventionalDrive = component("The drive: its output moves the handle")
    wall_stiffness: float = quantity("N/m", Ge(0), "K, stiffness of the virtual wall; 0: free motion", default=0.0)
    wall_damping: float = quantity("N s/m", Ge(0), "B, damping of the virtual wall", default=0.0)
    handle_mass: float = quantity("kg", Ge(0), "Mass of the handle and of the load that the drive moves", default=0.0)
    viscous_friction: float = quantity(
        "N s/m", Ge(0), "Viscous friction at the handle, beside that of the motor", default=0.0
    )
    force_gain: float = quantity(
        "1", Ge(0), "Force by which the motor helps over that of a sensor behind the handle; 0: no sensor", default=0.0
    )
    filter_frequency: float | None = quantity(
        "Hz", Gt(0), "Corner of that sensor's filter (second order, Butterworth); required with it", default=None
    )
    samples_late: Literal[0, 1] = component("Samples by which what is computed acts late", default=1)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_instance("drive", self.drive, ConventionalDrive)
        check_real(self)
        drive = self.drive
        if self.force_gain and self.filter_frequency is None:
            raise ParameterError("filter_frequency is missing: a force gain requires that of the sensor's filter")
        if drive.axis.rotary:
            raise ParameterError("drive must move a load along a line, got one that turns a shaft")
        for name, stiffness in (("gearhead", drive.gearhead.stiffness), (drive.stage.title, drive.stage.stiffness)):
            if stiffness is not None:
                raise ParameterError(f"drive.{name}.stiffness must be left out: the loop is that of a rigid drive")
        _check_output(drive)
        drive.check_motion()

    @property
    def period(self) -> float:
        """Of a sample. [s]"""
        return 1.0 / float(self.drive.control.sample_rate)

    @property
    def reflected_mass(self) -> float:
        """Of rotor, gear and output stage, without the handle and without help by a force sensor. [kg]"""
        travel = float(self.drive.stage.travel_per_radian)
        return (rotor_inertia(self.drive) + self.drive.gear_output_inertia) / travel**2

    @property
    def damping(self) -> float:
        """b, viscous friction of motor and handle. [N s m^-1]"""
        travel, ratio = float(self.drive.stage.travel_per_radian), self.drive.gearhead.ratio
        return given(self.drive.motor.viscous_friction, 0.0) * (ratio / travel) ** 2 + self.viscous_friction

    @property
    def force_per_current(self) -> float:
        """At the handle. [N A^-1]"""
        travel = float(self.drive.stage.travel_per_radian)
        return self.drive.motor.torque_constant * self.drive.gearhead.ratio / travel

    @property
    def memory(self) -> tuple[str, ...]:
        """Name of what the controller keeps: the last position."""
        return ("x_before_m",)

    def softest(self) -> ImpedanceDisplay:
        """The same in free motion."""
        return replace(self, wall_stiffness=0.0, wall_damping=0.0)

    def plant(self, held: Held = "free") -> Plant:
        """What moves between samples: drive and handle, with what holds it.

        Source: `infinivar.drivetrain.graphs.bandwidths`, of a rigid drive.
        """
        arm, clamped = _held(held)
        mass = self.reflected_mass + self.handle_mass + arm.mass
        damping, gain = self.damping + arm.damping, self.force_per_current
        moving = () if clamped else ("x_m", "v_m_s")
        names = (*moving, *(("filtered_N", "filtered_rate_N_s") if self.force_gain else ()))
        corner = 2.0 * math.pi * given(self.filter_frequency, 1.0)

        def rates(state: np.ndarray, current: Any, force: Any) -> list[Any]:
            if clamped:
                return _filter(-gain * current, state, corner)
            push = gain * current + force - damping * state[1] - arm.stiffness * state[0]
            acceleration = push / mass
            felt = self.reflected_mass * acceleration + self.damping * state[1] - gain * current
            return [state[1], acceleration, *_filter(felt, state[2:], corner)]

        def sensed(state: np.ndarray, force: Any) -> Sensed:
            nothing = 0.0 * force
            felt = state[len(moving)] if self.force_gain else nothing
            return Sensed(felt, state[0] if moving else nothing, nothing, nothing, nothing)

        return _linear(names, rates, sensed) if names else _linear((), None, sensed)

    def act(self, memory: np.ndarray, sensed: Sensed) -> tuple[list[Any], Any]:
        """Memory and current of the motor that the controller computes from one sample.

        Source: colgate1997, virtual wall with a backward difference; the help by the force sensor is proportional.
        """
        speed = (sensed.position - memory[0]) / self.period
        wall = self.wall_stiffness * sensed.position + self.wall_damping * speed
        # What helps the hand against the motor's inertia helps it against the wall: at the handle the wall is K and B.
        force = self.force_gain * sensed.force - (1.0 + self.force_gain) * wall
        return [sensed.position], force / self.force_per_current


Display: TypeAlias = AdmittanceDisplay | ImpedanceDisplay

TITLES = {"AdmittanceDisplay": "Admittance display", "ImpedanceDisplay": "Impedance display"}
"""Kinds of display for people."""


class _Passive(NamedTuple):
    """What moves with the handle."""

    mass: float
    damping: float
    stiffness: float


class _Contact(NamedTuple):
    """Linear contact of a wheel that is steered little about the locked state."""

    viscous: float
    """C/S. [N s m^-1]"""
    surface: float
    rolling: float
    """F_0, rolling resistance. [N]"""
    coupling: float
    """sigma: creep speed per steering rate. [m rad^-1]"""
    turning: float
    """Moment per steering rate, without creep. [N m s]"""

    @classmethod
    def of(cls, drive: CoboticDrive) -> _Contact:
        """Of a drive at its cylinder speed."""
        element = drive.transmission
        groups = element.groups(drive.cylinder_speed)
        surface = abs(float(element.cylinder_radius * drive.cylinder_speed))
        viscous, rolling = float(groups.creep_stiffness) / surface, float(groups.rolling_force)
        if element.contact is None or not element.turns_with_spin:
            return cls(viscous, surface, rolling, 0.0, 0.0)
        lever = float(TurningPatch.of(element, groups).lever)
        scale = scales(element.contact.axis_ratio, element.contact.poisson)
        return cls(viscous, surface, rolling, float(scale.by_spin) * lever, viscous * float(scale.turning) * lever**2)

    def link_force(self, speed: Any, angle: Any, turning: Any) -> Any:
        """Force of the transmission on the link; all arguments are small. [N]"""
        return self.rolling * angle - self.viscous * (speed + self.surface * angle - self.coupling * turning)

    def moment(self, speed: Any, angle: Any, turning: Any) -> Any:
        """Moment of the patch against steering. [N m]"""
        return self.turning * turning + self.viscous * self.coupling * (speed + self.surface * angle)


def _filter(force: Any, state: np.ndarray, corner: float) -> list[Any]:
    """Rates of a low-pass filter of the force, with as many states as its order.

    Source: none; first order, and Butterworth of second order.
    """
    if len(state) == 2:
        return [state[1], corner * corner * (force - state[0]) - math.sqrt(2.0) * corner * state[1]]
    return [corner * (force - state[0])] if len(state) else []


def _held(held: Held) -> tuple[_Passive, bool]:
    """What moves with the handle, and whether that is clamped."""
    if isinstance(held, ArmModel):
        return _Passive(held.mass, held.damping, held.stiffness), False
    if not isinstance(held, str) or held not in ("free", "clamped"):
        raise ParameterError(f"held must be an ArmModel, 'free' or 'clamped', got {shown(held)}")
    return _Passive(0.0, 0.0, 0.0), held == "clamped"


def _steering(drive: CoboticDrive) -> SteeringServo:
    """Inertia and gain of the steering; its Coulomb friction is left out."""
    plant = needed(drive.steering, "steering")
    return SteeringServo(plant=plant, amplifier=drive.amplifier, patch_friction=0.0, bell_friction=0.0, stick_speed=1.0)


def _linear(
    names: tuple[str, ...],
    rates: Callable[[np.ndarray, Any, Any], list[Any]] | None,
    sensed: Callable[[np.ndarray, Any], Sensed],
) -> Plant:
    """Matrices of linear rates: their values at unit states and inputs."""
    n = len(names)
    state = np.hstack([np.eye(n), np.zeros((n, 2))])
    current, force = np.zeros(n + 2), np.zeros(n + 2)
    current[n], force[n + 1] = 1.0, 1.0
    moved = np.zeros((0, n + 2)) if rates is None else np.array(rates(state, current, force))
    felt = np.array([np.broadcast_to(row, n + 2) for row in sensed(state, force)])
    return Plant(names, moved[:, :n], moved[:, n], moved[:, n + 1], felt[:, :n], felt[:, n + 1])


def _check_flag(name: str, value: Any) -> None:
    if not isinstance(value, bool):
        raise ParameterError(f"{name} must be true or false, got {value!r}")


def _check_output(drive: CoboticDrive | ConventionalDrive) -> None:
    if drive.output.chain:
        raise ParameterError("drive.output must have no springs or linkage: the handle is on the drive itself")
