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
from dataclasses import dataclass, replace
from typing import Any, Literal, Self, TypeAlias

import numpy as np
from annotated_types import Ge, Gt

from infinivar._core.fields import check_instance, check_real, component, given, quantity
from infinivar.displays.plants import (
    Held,
    Plant,
    Sensed,
    force_per_current_of,
    mass_of,
    mover_of,
    own_stiffness,
    plant_of,
    steering_of,
    viscous_of,
)
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.control import SPEED_BANDWIDTH
from infinivar.drivetrain.control.loops import Servo
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.graphs.compliances import DAMPING
from infinivar.errors import ParameterError

RIGID = "not stated, rigid"
"""What carries a handle of which no stiffness is known."""


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
        return mass_of(self.drive)  # type: ignore[attr-defined]

    @property
    def series_stiffness(self) -> float:
        """Of structure and sensor in series, on which the handle hangs; inf if both are rigid. [N m^-1]"""
        structure = self.structure_stiffness or own_stiffness(self.drive)[0]  # type: ignore[attr-defined]
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
        return own_stiffness(self.drive)[1] or RIGID  # type: ignore[attr-defined]

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
        return plant_of(self, mover_of(self.drive, self.viscous_friction), held, filtered)

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
            found = steering_of(self.drive)
            return Servo.place(self.drive.control.steering_bandwidth, found.inertia, found.gain, math.inf, 0.0, 1.0)
        bandwidth = given(self.drive.control.speed_bandwidth, SPEED_BANDWIDTH)
        return Servo.place(bandwidth, self._moved_mass, self._gain, math.inf, 0.0, 1.0)

    @property
    def _moved_mass(self) -> float:
        """Of a geared drive, with the handle. [kg]"""
        return self.drive_mass + self.handle_mass

    @property
    def _gain(self) -> float:
        return force_per_current_of(self.drive)  # type: ignore[arg-type]


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
        return viscous_of(self.drive) + self.viscous_friction

    @property
    def force_per_current(self) -> float:
        """At the drive. [N A^-1]"""
        return force_per_current_of(self.drive)

    @property
    def memory(self) -> tuple[str, ...]:
        """Name of what the controller keeps: the last position."""
        return ("x_before_m",)

    def plant(self, held: Held = "free") -> Plant:
        """What moves between samples: drive and handle, with what holds it.

        Source: `infinivar.drivetrain.graphs.bandwidths`, of a rigid drive, or one on a spring.
        """
        return plant_of(self, mover_of(self.drive, self.viscous_friction), held, 2 if self.force_gain else 0)

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


def _check_drive(drive: CoboticDrive | ConventionalDrive) -> None:
    """Raise ParameterError unless the drive moves a handle along a line, and states what motion needs."""
    if drive.axis.rotary:
        raise ParameterError("drive must move a load along a line, got one that turns a shaft")
    _check_output(drive)
    drive.check_motion()


def _check_flag(name: str, value: Any) -> None:
    if not isinstance(value, bool):
        raise ParameterError(f"{name} must be true or false, got {value!r}")


def _check_output(drive: CoboticDrive | ConventionalDrive) -> None:
    if drive.output.chain:
        raise ParameterError("drive.output must have no springs or linkage: the handle is on the drive itself")
