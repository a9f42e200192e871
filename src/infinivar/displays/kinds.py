r"""Haptic displays of one axis, linearised about rest: what moves between samples, and what the controller computes.

**Admittance display.** Its controller measures the user's force, moves a virtual mass by it, and makes the drive move as that
mass does. A cobotic drive is steered. With the link at x, the wheel at the small angle :math:`\phi`, the surface speed S, and the
creep stiffness C, the contact applies to the link

.. math:: f_l = -\frac{C}{S}\left(\dot x + S\phi - \sigma\dot\phi\right) + F_0\phi ,

so that the link follows :math:`-S\phi` with the creep lag :math:`m S/C`. Where steering is spin, :math:`\sigma` couples it to the
lateral creep, as in linear theory, and the patch resists steering with a moment. The motor of a geared drive follows the virtual
mass by a position servo.

**Impedance display.** A drive of any fixed ratio whose controller measures the position and applies the force of a virtual wall.
It feels as the reflected mass of motor and gear, or, with a force sensor behind the handle that the motor helps g times, as that
over 1 + g.

**Structure.** The encoder is at the drive. The handle is one with it, or hangs on it by the stiffness of structure and force
sensor in series, with a damper beside; this adds a mode, and a wall of stiffness K is felt at the handle as
:math:`1/(1/K + 1/k)`. All mass of a drive counts as before that spring.

Left out of all, as they are not linear: Coulomb friction of motors, gears, bells, patches and guideways (a servo of the program
feeds it forward), quantisation of encoders, noise, limits of current and voltage, slip. The first three are in
`infinivar.displays.sampled_loop.run_in_time`, in passivity and in the Z-width. A motor is a source of current. Loss in a
gear that is proportional to its load counts as Coulomb friction. The patch is in steady rolling.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple, Self, TypeAlias

import numpy as np
from annotated_types import Ge, Gt

from infinivar._core.arrays import shown
from infinivar._core.fields import check_instance, check_real, component, given, quantity
from infinivar.contact.exact.spin_map import scales
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.control import SPEED_BANDWIDTH
from infinivar.drivetrain.control.loops import Servo
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import needed
from infinivar.drivetrain.graphs.compliances import DAMPING, rotor_inertia
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
class _OneAxis:
    """What both kinds have: a wall, a handle that hangs on the drive through structure and sensor, a filter, a delay."""

    wall_stiffness: float = quantity("N/m", Ge(0), "K, stiffness of the virtual wall; 0: free motion", default=0.0)
    wall_damping: float = quantity("N s/m", Ge(0), "B, damping of the virtual wall", default=0.0)
    handle_mass: float = quantity("kg", Ge(0), "Mass of the handle, beyond structure and sensor", default=0.0)
    structure_stiffness: float | None = quantity(
        "N/m",
        Gt(0),
        "Stiffness between what the encoder measures and the handle; default: that of gearhead and stage, else rigid",
        default=None,
    )
    structure_damping: float | None = quantity(
        "N s/m",
        Ge(0),
        "Damping beside structure and sensor; default: 0.05 of critical, as in simulations",
        default=None,
    )
    sensor_stiffness: float | None = quantity(
        "N/m", Gt(0), "Stiffness of the force sensor; default: rigid", default=None
    )
    filter_frequency: float | None = quantity(
        "Hz", Gt(0), "Corner of the force sensor's filter; default: none", default=None
    )
    samples_late: Literal[0, 1] = component("Samples by which what is computed acts late", default=1)
    encoder_resolution: float = quantity("m", Ge(0), "Travel of the drive for one count; 0: exact", default=0.0)
    coulomb_friction: float = quantity(
        "N", Ge(0), "Constant friction at the drive that is not fed forward; no linear result knows it", default=0.0
    )
    force_noise: float = quantity("N", Ge(0), "Noise of the force sensor, root mean square", default=0.0)

    @property
    def period(self) -> float:
        """Of a sample. [s]"""
        return 1.0 / float(self.drive.control.sample_rate)  # type: ignore[attr-defined]

    @property
    def drive_mass(self) -> float:
        """Mass of what the encoder measures, at the output. [kg]"""
        return _mass(self.drive)  # type: ignore[attr-defined]

    @property
    def series_stiffness(self) -> float:
        """Of structure and sensor in series, on which the handle hangs; inf if both are rigid. [N m^-1]"""
        structure = self.structure_stiffness or _own(self.drive)[0]  # type: ignore[attr-defined]
        return 1.0 / total if (total := 1.0 / structure + 1.0 / (self.sensor_stiffness or math.inf)) else math.inf

    @property
    def series_damping(self) -> float:
        """Beside that stiffness, by default `DAMPING` of critical for the mass of the drive. [N s m^-1]"""
        if not math.isfinite(self.series_stiffness):
            return 0.0
        return given(self.structure_damping, 2.0 * DAMPING * math.sqrt(self.series_stiffness * self.drive_mass))

    @property
    def carried_by(self) -> str:
        """Where the stiffness of the structure comes from, in words."""
        if self.structure_stiffness:
            return "stated"
        return _own(self.drive)[1] or "not stated: rigid"  # type: ignore[attr-defined]

    def at_handle(self, wall: float) -> float:
        """Stiffness at the handle of a wall at the drive, in series with structure and sensor. [N m^-1]"""
        return 1.0 / (1.0 / wall + 1.0 / self.series_stiffness) if wall else 0.0

    @property
    def least_force(self) -> float:
        """The user feels none below: noise of the force sensor, or without one the friction. [N]"""
        sensing = isinstance(self, AdmittanceDisplay) or getattr(self, "force_gain", 0.0) > 0.0
        return self.force_noise if sensing else self.coulomb_friction

    def softest(self) -> Self:
        """The same in free motion."""
        return replace(self, wall_stiffness=0.0, wall_damping=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class AdmittanceDisplay(_OneAxis):
    """A drive that moves as a virtual mass does under the force of the user.

    A cobotic drive is steered; the motor of a geared drive is a position servo of the virtual mass, with the bandwidth of its
    speed loop. The force sensor is between handle and drive, and its filter is analogue. Sample rate, bandwidth of the servo
    and, for `wall` = "virtual", of a link's position loop are those of ``drive.control``. The virtual mass is integrated by the
    implicit Euler method.

    Raises
    ------
    ParameterError
        If a field is outside its range, or the drive lacks what motion needs.
    """

    drive: CoboticDrive | ConventionalDrive = component("The drive: its output moves the handle")
    virtual_mass: float = quantity("kg", Gt(0), "Mass that the user is to feel")
    virtual_damping: float = quantity("N s/m", Ge(0), "Damping of the virtual mass", default=0.0)
    viscous_friction: float = quantity("N s/m", Ge(0), "Viscous friction of a geared drive at its output", default=0.0)
    filter_order: Literal[1, 2] = component("Order of that filter; 2: Butterworth", default=2)
    wall: Literal["measured", "virtual"] = component(
        "Whose penetration the wall resists: that of the measured drive, or of the virtual mass, which the drive then follows",
        default="measured",
    )
    rate_feedforward: bool = component(
        "Whether the servo receives the rate of the commanded angle, or the acceleration of the virtual mass, as well",
        default=True,
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        if not isinstance(self.drive, CoboticDrive | ConventionalDrive):
            check_instance("drive", self.drive, CoboticDrive)
        check_real(self)
        _check_flag("rate_feedforward", self.rate_feedforward)
        _check_drive(self.drive)
        if self.steered and self.viscous_friction:
            raise ParameterError("viscous_friction does not apply: it is that of a geared drive")
        if not self.steered and self.filter_frequency is None:
            raise ParameterError("filter_frequency is missing: the force sensor of a geared drive requires a filter")

    @property
    def steered(self) -> bool:
        """Whether the drive is cobotic."""
        return isinstance(self.drive, CoboticDrive)

    @property
    def surface_speed(self) -> float:
        """S, of the cylinder; 0 without one. [m s^-1]"""
        if not isinstance(self.drive, CoboticDrive):
            return 0.0
        return abs(float(self.drive.transmission.cylinder_radius * self.drive.cylinder_speed))

    @property
    def memory(self) -> tuple[str, ...]:
        """Names of what the controller keeps: speed of the virtual mass, and its position if wall or servo is there."""
        return ("v_m_s",) if self.steered and self.wall == "measured" else ("v_m_s", "x_v_m")

    def plant(self, held: Held = "free") -> Plant:
        """What moves between samples: handle with what holds it, drive, and filter of the force sensor.

        Source: faulring2006, section II, linearised at a steering angle of 0; contact as in `infinivar.transmission.spin_law`.
        """
        filtered = 0 if self.filter_frequency is None else self.filter_order
        return _plant(self, _mover(self.drive, self.viscous_friction), held, filtered)

    def act(self, memory: np.ndarray, sensed: Sensed) -> tuple[list[Any], Any]:
        """Memory and current of the motor that the controller computes from one sample.

        Source: `infinivar.drivetrain.control.loops.Servo`, without limit and friction; a wheel is steered as by the link loop.
        """
        period = self.period
        mass, damping, stiffness = self.virtual_mass, self.virtual_damping + self.wall_damping, self.wall_stiffness
        before = memory[0]
        if self.wall == "measured":
            speed = (mass * before + period * (sensed.force - stiffness * sensed.position)) / (mass + period * damping)
        else:
            push = sensed.force - stiffness * memory[1]
            speed = (mass * before + period * push) / (mass + period * (damping + period * stiffness))
        place = memory[1] + period * speed if len(self.memory) == 2 else None
        kept = [speed] if place is None else [speed, place]
        acceleration, servo = (speed - before) / period, self.servo
        if not self.steered:
            ahead = self._moved_mass / self._gain * acceleration if self.rate_feedforward else 0.0 * speed
            error = place - sensed.position
            return kept, servo.proportional * error + servo.damping * (speed - sensed.speed) + ahead
        demanded, surface = speed, self.surface_speed
        if place is not None:
            gain = 2.0 * math.pi * self.drive.control.link_bandwidth  # type: ignore[operator]
            demanded, acceleration = (
                speed + gain * (place - sensed.position),
                acceleration + gain * (speed - sensed.speed),
            )
        rate = -acceleration / surface if self.rate_feedforward else 0.0 * speed
        error = -demanded / surface - sensed.angle
        return kept, servo.proportional * error + servo.damping * (rate - sensed.turning)

    @property
    def servo(self) -> Servo:
        """Servo of the wheel or of the motor as the program places it, for small errors."""
        if isinstance(self.drive, CoboticDrive):
            found = _steering(self.drive)
            return Servo.place(self.drive.control.steering_bandwidth, found.inertia, found.gain, math.inf, 0.0, 1.0)
        bandwidth = given(self.drive.control.speed_bandwidth, SPEED_BANDWIDTH)
        return Servo.place(bandwidth, self._moved_mass, self._gain, math.inf, 0.0, 1.0)

    @property
    def _moved_mass(self) -> float:
        """Of a geared drive, with the handle. [kg]"""
        return self.drive_mass + self.handle_mass

    @property
    def _gain(self) -> float:
        return _force_per_current(self.drive)  # type: ignore[arg-type]


@dataclass(frozen=True, slots=True, kw_only=True)
class ImpedanceDisplay(_OneAxis):
    """A geared drive, with any ratio, that applies the force of a virtual wall from its measured position.

    The speed is the difference of two positions. The sample rate is that of ``drive.control``. The filter, a Butterworth one of
    second order, acts on the force sensor where there is a force gain.

    Raises
    ------
    ParameterError
        If a field is outside its range, or the drive lacks what motion needs, or moves a joint.
    """

    drive: ConventionalDrive = component("The drive: its output moves the handle")
    viscous_friction: float = quantity(
        "N s/m", Ge(0), "Viscous friction at the drive, beside that of the motor", default=0.0
    )
    force_gain: float = quantity(
        "1", Ge(0), "Force by which the motor helps over that of a sensor behind the handle; 0: no sensor", default=0.0
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_instance("drive", self.drive, ConventionalDrive)
        check_real(self)
        if self.force_gain and self.filter_frequency is None:
            raise ParameterError("filter_frequency is missing: a force gain requires that of the sensor's filter")
        _check_drive(self.drive)

    @property
    def reflected_mass(self) -> float:
        """Of rotor, gear and output stage, without the handle and without help by a force sensor. [kg]"""
        return self.drive_mass

    @property
    def damping(self) -> float:
        """b, viscous friction of motor and drive. [N s m^-1]"""
        return _viscous(self.drive) + self.viscous_friction

    @property
    def force_per_current(self) -> float:
        """At the drive. [N A^-1]"""
        return _force_per_current(self.drive)

    @property
    def memory(self) -> tuple[str, ...]:
        """Name of what the controller keeps: the last position."""
        return ("x_before_m",)

    def plant(self, held: Held = "free") -> Plant:
        """What moves between samples: drive and handle, with what holds it.

        Source: `infinivar.drivetrain.graphs.bandwidths`, of a rigid drive, or one on a spring.
        """
        return _plant(self, _mover(self.drive, self.viscous_friction), held, 2 if self.force_gain else 0)

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


class _Mover(NamedTuple):
    """What drives the handle: its mass, its own states, and what its force and their rates are."""

    mass: float
    states: tuple[str, ...]
    push: Callable[[Any, np.ndarray, Any], Any]
    """Force on the mass, by its speed, own states and current. [N]"""
    rates: Callable[[Any, np.ndarray, Any], list[Any]]


def _mover(drive: CoboticDrive | ConventionalDrive, viscous_friction: float) -> _Mover:
    if isinstance(drive, CoboticDrive):
        servo, contact = _steering(drive), _Contact.of(drive)
        iron = given(servo.plant.motor.viscous_friction, 0.0) * servo.plant.ratio**2

        def turn(speed: Any, own: np.ndarray, current: Any) -> list[Any]:
            torque = servo.gain * current - iron * own[1] - contact.moment(speed, own[0], own[1])
            return [own[1], torque / servo.inertia]

        return _Mover(
            _mass(drive),
            ("phi_rad", "phi_rate_rad_s"),
            lambda speed, own, current: contact.link_force(speed, own[0], own[1]),
            turn,
        )
    gain, damping = _force_per_current(drive), _viscous(drive) + viscous_friction
    return _Mover(
        _mass(drive), (), lambda speed, own, current: gain * current - damping * speed, lambda speed, own, current: []
    )


def _plant(display: Any, mover: _Mover, held: Held, filtered: int) -> Plant:
    """What moves between samples: handle with what holds it, mass of the drive, its own states, filter of the force.

    The handle is one with the mass of the drive, or hangs on it by the spring of structure and sensor. The force sensor feels
    what goes from one to the other.
    """
    arm, clamped = _held(held)
    beyond, spring = display.handle_mass + arm.mass, display.series_stiffness
    hung = math.isfinite(spring)
    if hung and not clamped and beyond == 0.0:
        raise ParameterError(
            "handle_mass must be > 0 kg, got 0: it hangs on structure and sensor, and nothing holds it"
        )
    total = mover.mass + (0.0 if hung else beyond)
    handle = () if clamped else ("x_m", "v_m_s")
    link = ("x_drive_m", "v_drive_m_s") if hung else ()
    count, own = len(handle), len(handle) + len(link)
    last = own + len(mover.states)
    corner = 2.0 * math.pi * given(display.filter_frequency, 1.0)

    def split(state: np.ndarray) -> tuple[Any, Any, Any, Any]:
        """Position and speed of the handle, and of the drive."""
        nothing = 0.0 * state[0] if len(state) else 0.0
        position, speed = (nothing, nothing) if clamped else (state[0], state[1])
        place, pace = (state[count], state[count + 1]) if hung else (position, speed)
        return position, speed, place, pace

    def moved(state: np.ndarray, current: Any, force: Any) -> tuple[Any, Any, Any]:
        """Force of the handle on the drive, and accelerations of handle and drive."""
        position, speed, place, pace = split(state)
        push = mover.push(pace, state[own:last], current)
        outside = force - arm.damping * speed - arm.stiffness * position
        if hung:
            felt = spring * (position - place) + display.series_damping * (speed - pace)
            return felt, (outside - felt) / (beyond or 1.0), (push + felt) / total
        acceleration = 0.0 * push if clamped else (push + outside) / total
        return mover.mass * acceleration - push, acceleration, acceleration

    def rates(state: np.ndarray, current: Any, force: Any) -> list[Any]:
        felt, of_handle, of_drive = moved(state, current, force)
        _, speed, _, pace = split(state)
        return [
            *(() if clamped else (speed, of_handle)),
            *((pace, of_drive) if hung else ()),
            *mover.rates(pace, state[own:last], current),
            *_filter(felt, state[last:], corner),
        ]

    def sensed(state: np.ndarray, force: Any) -> Sensed:
        nothing = 0.0 * force
        _, _, place, pace = split(state)
        angle = state[own:last] if mover.states else (nothing, nothing)
        felt = state[last] if filtered else moved(state, nothing, force)[0]
        return Sensed(felt, nothing + place, nothing + pace, *angle)

    names = (*handle, *link, *mover.states, *("filtered_N", "filtered_rate_N_s")[:filtered])
    return _linear(names, rates if names else None, sensed)


def _viscous(drive: ConventionalDrive) -> float:
    """Viscous friction of the motor at the output. [N s m^-1]"""
    reduction = drive.gearhead.ratio / float(drive.stage.travel_per_radian)
    return given(drive.motor.viscous_friction, 0.0) * reduction**2


def _force_per_current(drive: ConventionalDrive) -> float:
    return drive.motor.torque_constant * drive.gearhead.ratio / float(drive.stage.travel_per_radian)


def _own(drive: CoboticDrive | ConventionalDrive) -> tuple[float, str]:
    """Stiffness of a drive between encoder and output, and what has it: gearhead and stage in series.

    Of a cobotic drive no part states a stiffness along its link.
    """
    if isinstance(drive, CoboticDrive):
        return math.inf, ""
    parts = {
        "gearhead": given(drive.gearhead.stiffness, math.inf) / float(drive.stage.travel_per_radian) ** 2,
        drive.stage.title: float(given(drive.stage.stiffness, math.inf)),
    }
    soft = {name: one for name, one in parts.items() if math.isfinite(one)}
    return (1.0 / sum(1.0 / one for one in soft.values()), " and ".join(soft)) if soft else (math.inf, "")


def _mass(drive: CoboticDrive | ConventionalDrive) -> float:
    """Of what the encoder measures. [kg]"""
    if isinstance(drive, CoboticDrive):
        return float(needed(drive.mass_of_link, "link_mass"))
    return (rotor_inertia(drive) + drive.gear_output_inertia) / float(drive.stage.travel_per_radian) ** 2


def _check_drive(drive: CoboticDrive | ConventionalDrive) -> None:
    """Raise ParameterError unless the drive moves a handle along a line, and states what motion needs."""
    if drive.axis.rotary:
        raise ParameterError("drive must move a load along a line, got one that turns a shaft")
    _check_output(drive)
    drive.check_motion()


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
