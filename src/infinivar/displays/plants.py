"""What moves between the samples of a display: hand, handle, structure, drive, and the filter of its force sensor."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np

from infinivar._core.arrays import shown
from infinivar._core.fields import given
from infinivar.contact.exact.spin_map import scales
from infinivar.drivetrain.cobotic import CoboticDrive
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


class Mover(NamedTuple):
    """What drives the handle: its mass, its own states, and what its force and their rates are."""

    mass: float
    states: tuple[str, ...]
    push: Callable[[Any, np.ndarray, Any], Any]
    """Force on the mass, by its speed, own states and current. [N]"""
    rates: Callable[[Any, np.ndarray, Any], list[Any]]


def mover_of(drive: CoboticDrive | ConventionalDrive, viscous_friction: float) -> Mover:
    """Wheel and link of a cobotic drive, or the reflected mass of a geared one."""
    if isinstance(drive, CoboticDrive):
        servo, contact = steering_of(drive), Contact.of(drive)
        iron = given(servo.plant.motor.viscous_friction, 0.0) * servo.plant.ratio**2

        def turn(speed: Any, own: np.ndarray, current: Any) -> list[Any]:
            torque = servo.gain * current - iron * own[1] - contact.moment(speed, own[0], own[1])
            return [own[1], torque / servo.inertia]

        return Mover(
            mass_of(drive),
            ("phi_rad", "phi_rate_rad_s"),
            lambda speed, own, current: contact.link_force(speed, own[0], own[1]),
            turn,
        )
    gain, damping = force_per_current_of(drive), viscous_of(drive) + viscous_friction
    return Mover(
        mass_of(drive), (), lambda speed, own, current: gain * current - damping * speed, lambda speed, own, current: []
    )


def plant_of(display: Any, mover: Mover, held: Held, filtered: int) -> Plant:
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


def viscous_of(drive: ConventionalDrive) -> float:
    """Viscous friction of the motor at the output. [N s m^-1]"""
    reduction = drive.gearhead.ratio / float(drive.stage.travel_per_radian)
    return given(drive.motor.viscous_friction, 0.0) * reduction**2


def force_per_current_of(drive: ConventionalDrive) -> float:
    """At the output. [N A^-1]"""
    return drive.motor.torque_constant * drive.gearhead.ratio / float(drive.stage.travel_per_radian)


def own_stiffness(drive: CoboticDrive | ConventionalDrive) -> tuple[float, str]:
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


def mass_of(drive: CoboticDrive | ConventionalDrive) -> float:
    """Of what the encoder measures. [kg]"""
    if isinstance(drive, CoboticDrive):
        return float(needed(drive.mass_of_link, "link_mass"))
    return (rotor_inertia(drive) + drive.gear_output_inertia) / float(drive.stage.travel_per_radian) ** 2


class _Passive(NamedTuple):
    """What moves with the handle."""

    mass: float
    damping: float
    stiffness: float


class Contact(NamedTuple):
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
    def of(cls, drive: CoboticDrive) -> Contact:
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


def steering_of(drive: CoboticDrive) -> SteeringServo:
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
