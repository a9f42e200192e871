"""Power motors, steering servos and motors of links of machines of many contacts: torques on the coordinates, and powers.

Motors of links are rigid behind them: rotor, gearhead and stage count as mass of the link. Friction is constant.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from infinivar._core.fields import given
from infinivar.contact.friction import coulomb
from infinivar.drivetrain.control.loops import largest_current
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import needed, shaft_inertia
from infinivar.drivetrain.steering import SteeringPlant
from infinivar.errors import ParameterError
from infinivar.limits import Demand
from infinivar.parts.amplifier import Amplifier
from infinivar.parts.gear_law import GearLaw
from infinivar.parts.gearhead import Gearhead
from infinivar.parts.motor import Motor

Powers = Callable[[], dict[str, np.ndarray]]
"""Computes powers by name, (m,) each, on request. [W]"""

POWER_LOSSES = ("winding", "motor friction", "motor iron", "gearhead", "amplifier")
STEERING_LOSSES = ("winding", "motor friction", "motor iron", "bearing", "patch", "amplifier")


class Shaft(NamedTuple):
    """A motor at m rows."""

    name: str
    """In columns."""
    part: str
    """In words."""
    motor: Motor
    current: np.ndarray
    """(m,) [A]"""
    speed: np.ndarray
    """(m,) [rad s^-1]"""
    stick_speed: float
    """[rad s^-1]"""

    @property
    def heat(self) -> tuple[np.ndarray, np.ndarray]:
        """Loss of the winding, and power of friction and iron loss. (m,) each [W]"""
        rubbed = coulomb(self.speed, self.motor.friction_torque, self.stick_speed)
        iron = given(self.motor.viscous_friction, 0.0) * self.speed
        return self.motor.resistance * self.current * self.current, (rubbed + iron) * self.speed

    @property
    def voltage(self) -> np.ndarray:
        """(m,) [V]"""
        return self.motor.resistance * self.current + self.motor.torque_constant * self.speed

    def utilisation(self) -> dict[Demand, np.ndarray]:
        """Demand over allowance, by limit and part. (m,)"""
        found = self.motor.utilisation(current=self.current, voltage=self.voltage, speed=self.speed)
        return {(limit, self.part): demand for limit, demand in found.items()}


def _electric(
    motor: Motor, amplifier: Amplifier, currents: np.ndarray, driven: np.ndarray, speed: np.ndarray
) -> dict[str, np.ndarray]:
    """What all motors take from the supply and lose in windings and amplifiers, (m,) each, at the torques or forces that their
    currents drive and the speeds there, (m, k). [W]"""
    winding = motor.resistance * currents * currents + 0.0 * speed
    taken, burnt, _ = amplifier.supply(winding + driven * speed)
    lost = {"supply": taken, "winding": winding, "amplifier": burnt + 0.0 * speed}
    return {name: one.sum(axis=-1) for name, one in lost.items()}


@dataclass(frozen=True, slots=True, kw_only=True)
class PowerMotor:
    """A motor with gearhead and amplifier on a coordinate of a machine, or one on each of several, all alike.

    Gearheads whose friction depends on their load need coordinates that no inertia couples.

    Raises
    ------
    ParameterError
        If the rotor's inertia is missing, or the gearhead has measured friction.
    """

    motor: Motor
    gearhead: Gearhead
    amplifier: Amplifier
    coordinates: tuple[int, ...]
    stick_speed: float
    """Of the motor shaft. [rad s^-1]"""
    travel: float = 1.0
    """Of the coordinate per angle of the gearhead's output: that of a stage, or 1. [m rad^-1]"""
    output_inertia: float = 0.0
    """Of gear and stage at the gearhead's output. [kg m^2]"""
    reduction: float = field(init=False, default=1.0)
    """Motor speed over that of the coordinate. [m^-1]"""
    rotor: float = field(init=False, default=0.0)
    """Inertia of rotor and gearhead about the coordinate. [kg m^2]"""
    inertia: float = field(init=False, default=0.0)
    """The same with that at the gearhead's output. [kg m^2]"""
    law: GearLaw = field(init=False)
    """Of the gearhead."""
    gear_friction: float = field(init=False, default=0.0)
    """Constant, at the motor. [N m]"""

    def __post_init__(self) -> None:
        """Compute what does not change."""
        rotor = shaft_inertia(self.motor, self.gearhead)
        reduction = self.gearhead.ratio / self.travel
        object.__setattr__(self, "reduction", reduction)
        object.__setattr__(self, "rotor", rotor * reduction**2)
        object.__setattr__(self, "inertia", self.rotor + self.output_inertia / self.travel**2)
        law = self.gearhead.law(self.motor.continuous_torque)
        if not law.is_zero and not law.factored:
            raise ParameterError(
                f"gearhead.loss_model must be 'coulomb' or 'proportional' in a machine of many contacts that moves, got "
                f"{self.gearhead.loss_model!r}, whose friction {law.ORIGIN}; iv.simulate has it for one leg"
            )
        object.__setattr__(self, "law", law)
        object.__setattr__(self, "gear_friction", float(law.constant))

    @property
    def gain(self) -> float:
        """Torque on the coordinate per current. [N m A^-1]"""
        return self.reduction * self.motor.torque_constant

    @property
    def loaded(self) -> bool:
        """Whether friction of the gearhead depends on the torque that it transmits."""
        return bool(self.law.OF_LOAD) and not self.law.is_zero

    def load_friction(self, shaft: np.ndarray, torque: np.ndarray, free: np.ndarray, unit: np.ndarray) -> np.ndarray:
        r"""Friction torque at the motor of a gearhead whose loss is proportional to power. (m, k) [N m]

        The torque p that it transmits follows from the rotor's balance,

        .. math:: p + F(p)\,(1 - J\,M^{-1}_{cc}) = \frac{\tau - J\,\dot\nu_c}{n}, \qquad F(p) = F(\mathrm{sgn}\,p)\,|p|,

        so that p has the sign of the right-hand side and is explicit.

        Parameters
        ----------
        shaft : (m, k) float    Speed of the motor. [rad s^-1]
        torque : (m, k) float   tau, on the coordinate without this friction. [N m]
        free : (m, k) float     Acceleration of the coordinate without this friction. [rad s^-2]
        unit : (m, k) float     Its acceleration by a unit torque. [kg^-1 m^-2]

        Source: Newton; `GearLaw.load_friction`.
        """
        balance = (torque - self.rotor * free) / self.reduction
        way = np.where(balance < 0.0, -1.0, 1.0)
        share = self.law.load_friction(shaft, way, self.stick_speed)
        passed = balance / (1.0 + way * share * (1.0 - self.rotor * unit))
        return share * np.abs(passed)

    def act(self, currents: np.ndarray, speeds: np.ndarray) -> tuple[np.ndarray, Powers]:
        """Torque on each coordinate, (m, k), and a function for the power that the motors take ("supply") with their losses, of
        all together; without friction that depends on the load.

        Parameters
        ----------
        currents : (k,) float    [A]
        speeds : (m, k) float    Of the coordinates.
        """
        shaft, motor = self.reduction * speeds, self.motor
        way = coulomb(shaft, 1.0, self.stick_speed)
        iron = given(motor.viscous_friction, 0.0) * shaft
        driven = motor.torque_constant * currents
        torque = self.reduction * (driven - (motor.friction_torque + self.gear_friction) * way - iron)

        def powers() -> dict[str, np.ndarray]:
            slid = (way * shaft).sum(axis=-1)
            return {
                **_electric(motor, self.amplifier, currents, driven, shaft),
                "motor friction": motor.friction_torque * slid,
                "motor iron": (iron * shaft).sum(axis=-1),
                "gearhead": self.gear_friction * slid,
            }

        return torque, powers


@dataclass(frozen=True, slots=True, kw_only=True)
class SteeringServo:
    """Motor, gear and bell of each steered axis, all alike; friction of bell and, without spin, of the patch.

    Raises
    ------
    ParameterError
        If the rotor's inertia is missing.
    """

    plant: SteeringPlant
    amplifier: Amplifier
    patch_friction: float
    """At the bell. [N m]"""
    bell_friction: float
    stick_speed: float
    """Of the bell. [rad s^-1]"""
    inertia: float = field(init=False, default=0.0)
    """Of bell and rotor about the steering axis. [kg m^2]"""
    gain: float = field(init=False, default=0.0)
    """Torque at the bell per current. [N m A^-1]"""
    friction: float = field(init=False, default=0.0)
    """Coulomb friction at the bell: of patch, bell and motor. [N m]"""

    def __post_init__(self) -> None:
        """Compute what does not change."""
        ratio, motor = self.plant.ratio, self.plant.motor
        object.__setattr__(self, "gain", ratio * motor.torque_constant)
        object.__setattr__(self, "friction", self.patch_friction + self.bell_friction + ratio * motor.friction_torque)
        rotor = needed(self.plant.motor.rotor_inertia, "steering.motor.rotor_inertia")
        object.__setattr__(self, "inertia", self.plant.inertia_of_bell + self.plant.ratio**2 * rotor)

    def act(self, currents: np.ndarray, turning: np.ndarray) -> tuple[np.ndarray, Powers]:
        """Torque at each bell but that of its contact, (m, s), and a function for the powers of all as in `PowerMotor`."""
        motor, ratio = self.plant.motor, self.plant.ratio
        share = coulomb(turning, 1.0, self.stick_speed)
        iron = given(motor.viscous_friction, 0.0) * ratio * ratio * turning
        driven = self.gain * currents
        torque = driven - self.friction * share - iron

        def powers() -> dict[str, np.ndarray]:
            slid = (share * turning).sum(axis=-1)
            found = {
                **_electric(motor, self.amplifier, currents, driven, turning),
                "motor friction": ratio * motor.friction_torque * slid,
                "motor iron": (iron * turning).sum(axis=-1),
                "bearing": self.bell_friction * slid,
                "patch": self.patch_friction * slid,
            }
            return {f"steering {name}": one for name, one in found.items()}

        return torque, powers


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkMotors:
    """A motor with gearhead, amplifier and output stage on each link, all alike.

    Raises
    ------
    ParameterError
        If the rotor's inertia is missing, friction depends on the load, or a part is elastic.
    """

    drive: ConventionalDrive
    stick_speed: float
    """Of a link. [m s^-1] or [rad s^-1]"""
    moved_mass: float = field(init=False, default=0.0)
    """Of rotor, gearhead and stage, at the link. [kg] or [kg m^2]"""
    ratio: float = field(init=False, default=1.0)
    """Angle of the motor per travel of the link. [rad/m] or [-]"""
    frictions: tuple[float, float, float, float] = field(init=False, default=(0.0, 0.0, 0.0, 0.0))
    """Of motor, gearhead, stage and guideway, at the link. [N] or [N m]"""

    def __post_init__(self) -> None:
        """Compute what does not change."""
        drive, gear, stage = self.drive, self.drive.gearhead, self.drive.stage
        rotor = shaft_inertia(drive.motor, gear)
        law = gear.law(drive.motor.continuous_torque)
        if law.OF_LOAD and not law.is_zero:
            raise ParameterError(
                f"gearhead.loss_model must be 'coulomb' for motors of links that move, got {gear.loss_model!r}, whose friction "
                "depends on the load"
            )
        losses = stage.efficiencies
        if losses is not None and tuple(losses) != (1.0, 1.0):
            raise ParameterError(
                f"{stage.title} must have no efficiency for motors of links that move, but a friction_torque; its friction would "
                "depend on the load"
            )
        if drive.output.chain or stage.stiffness is not None or gear.stiffness is not None:
            what = "output" if drive.output.chain else "gearhead" if gear.stiffness is not None else stage.title
            raise ParameterError(f"{what} must be rigid, without springs or linkage, for motors of links that move")
        travel = float(stage.travel_per_radian)
        ratio = gear.ratio / travel
        constant = float(law.constant)
        object.__setattr__(self, "ratio", ratio)
        object.__setattr__(self, "moved_mass", rotor * ratio**2 + drive.gear_output_inertia / travel**2)
        frictions = (
            drive.motor.friction_torque * ratio,
            constant * ratio,
            float(stage.shaft_friction) / travel,
            float(drive.guideway.friction_force()),
        )
        object.__setattr__(self, "frictions", frictions)

    @property
    def gain(self) -> float:
        """Force on a link per current. [N A^-1] or [N m A^-1]"""
        return self.ratio * self.drive.motor.torque_constant

    @property
    def current_limit(self) -> float:
        """Of the controller, or of a motor that is stalled. [A]"""
        return largest_current(self.drive.control.current_limit, self.drive.motor)

    @property
    def losses(self) -> tuple[str, ...]:
        """Names of the losses; the four of friction first."""
        return ("motor friction", "gearhead", self.drive.stage.title, "guideway", "winding", "motor iron", "amplifier")

    def act(self, currents: np.ndarray, speed: np.ndarray) -> tuple[np.ndarray, Powers]:
        """Forces on the links, (m, n), and a function for the powers of all motors together, at link speeds (m, n)."""
        motor = self.drive.motor
        way = coulomb(speed, 1.0, self.stick_speed)
        iron = given(motor.viscous_friction, 0.0) * self.ratio**2 * speed
        driven = self.gain * currents
        force = driven - sum(self.frictions) * way - iron

        def powers() -> dict[str, np.ndarray]:
            found = _electric(motor, self.drive.amplifier, currents, driven, speed)
            slid = {name: one * way * speed for name, one in zip(self.losses[:4], self.frictions, strict=True)}
            lost = {**slid, "motor iron": iron * speed}
            return {**found, **{name: one.sum(axis=-1) for name, one in lost.items()}}

        return force, powers
