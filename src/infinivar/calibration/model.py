"""Model fitted to rig data: the expected readings of a run for given parameters of the drive."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from infinivar._core.array_namespace import Array
from infinivar.calibration.data import RigData
from infinivar.contact import creep
from infinivar.contact.creep import CreepLaw
from infinivar.contact.friction import coulomb
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.parts.shaft_bearings import CylinderBearings, WheelLoad
from infinivar.study.rig import Rig
from infinivar.transmission.geometry import PRELOAD_POWERS
from infinivar.transmission.rotary_linear import RotaryLinearIVT, turning_as


class Parameter(NamedTuple):
    """A parameter that can be fitted."""

    unit: str
    shown_in: str
    meaning: str


PARAMETERS = {
    "creep_stiffness": Parameter("N", "N", "creep stiffness C = C22 G a b"),
    "rolling_torque": Parameter("N m", "mN m", "hysteresis torque of the rolling contact"),
    "bearing_torque": Parameter("N m", "mN m", "friction torque of the axle bearings"),
    "guideway_friction": Parameter("N", "N", "friction of the guideway"),
    "nominal_torque": Parameter("N m", "mN m", "no-load torque of motor, gearing and cylinder, at the motor"),
    "torque_constant": Parameter("N m/A", "mN m/A", "torque constant of the motor"),
    "resistance": Parameter("ohm", "ohm", "terminal resistance of the motor"),
}
"""Parameters by name; those that depend on the preload refer to the study's preload."""

USUAL = tuple(PARAMETERS)[:5]
"""Parameters fitted by default."""


class Readings(NamedTuple):
    """Sensor readings, one value per run; the voltage is given even if not recorded. [m], [A], [V]"""

    link_travel: np.ndarray
    motor_current: np.ndarray
    motor_voltage: np.ndarray


@dataclass(frozen=True, slots=True, kw_only=True)
class Errors:
    """Errors of settings and sensors common to all runs of a session; zero for an exact rig.

    `mass` has one error per run.
    """

    current_gain: Array = 0.0
    """Current read over true current, less 1. [-]"""
    preload: Array = 0.0
    """True preload over its setting, less 1. [-]"""
    steering_zero: Array = 0.0
    """True steering angle less what the encoder says. [rad]"""
    mass: Array = 0.0
    """True mass less what the balance says. [kg]"""


def known_values(drive: CoboticDrive) -> dict[str, float]:
    """The parameters as the study has them."""
    motor, gear = drive.motor, drive.gearhead
    groups = drive.transmission.groups(drive.cylinder_speed)
    nominal = motor.friction_torque + gear.coulomb_friction(motor.continuous_torque) + unloaded_bearings(drive)
    return {
        "creep_stiffness": float(groups.creep_stiffness),
        "rolling_torque": float(groups.rolling_torque),
        "bearing_torque": float(groups.bearing_torque),
        "guideway_friction": float(drive.guideway.friction_force(drive.transmission.preload)),
        "nominal_torque": float(nominal),
        "torque_constant": motor.torque_constant,
        "resistance": motor.resistance,
    }


def unloaded_bearings(drive: CoboticDrive) -> float:
    """Friction torque of the cylinder's bearings with the wheel lifted off, at the motor; 0 where none are stated. [N m]"""
    bearings = drive.cylinder_bearings
    return 0.0 if bearings is None else _alone(drive, bearings) / drive.gearhead.ratio


def _alone(drive: CoboticDrive, bearings: CylinderBearings) -> float:
    """The same at the cylinder. [N m]"""
    found = bearings.midway().unloaded(drive.cylinder_speed).torque
    assert found is not None
    return found


def _loaded_bearings(
    drive: CoboticDrive, preload: Array, torque: Array, force: Array, speed: Array, rolling: Array
) -> Array:
    """Torque on the cylinder that a pressed wheel adds to the friction of its bearings, which the study knows. [N m]"""
    bearings = drive.cylinder_bearings
    if bearings is None:
        return 0.0
    bearings = bearings.midway()
    wheel = WheelLoad(preload=preload, torque=torque, force=force, radius=drive.transmission.cylinder_radius)
    drag, _ = bearings.operate([wheel], speed, torque=torque, rolling=rolling)
    return drag - coulomb(speed, _alone(drive, bearings))


def load_on_wheel(
    drive: CoboticDrive, rig: Rig, data: RigData, guideway_friction: float, errors: Errors | None = None
) -> np.ndarray:
    """Force of the transmission on the link that lifts or lowers a mass against guideway friction.

    Parameters
    ----------
    guideway_friction : float   Friction at the study's preload; its preload-dependent part scales with that of the run. [N]

    Returns
    -------
    (n,) float   [N]

    Source: faulring2006, Eq 18.
    """
    errors = errors or Errors()
    guide = drive.guideway
    share = data.preload * (1.0 + errors.preload) / drive.transmission.preload
    whole = guide.friction_force(drive.transmission.preload)
    follows = guide.coefficient * drive.transmission.preload / whole if whole > 0 else 0.0
    size = guideway_friction * (1.0 - follows + follows * share)
    return (data.mass + errors.mass) * rig.gravity + coulomb(data.link_travel, size)


def _law_on_patch(known: RotaryLinearIVT) -> CreepLaw:
    """The creep law of the patch, as the element that is fitted has measured values and no geometry."""
    contact = known.contact
    return known.creep_law if contact is None else creep.pinned(known.creep_law, contact.axis_ratio, contact.poisson)


def _growth(element: RotaryLinearIVT, preload: Array, speed: float) -> dict[str, Array]:
    """Loss factors relative to the study's preload; for bearings by their model, if given."""
    share = preload / element.preload
    found = {name: share**power for name, power in PRELOAD_POWERS.items()}
    known = element.groups(speed)
    if element.geometry is not None and known.bearing_torque > 0:
        torque = element.geometry.axle_friction(
            wheel_radius=element.wheel_radius,
            preload=preload,
            slip_force=share * known.slip_force,
            surface_speed=element.cylinder_radius * abs(speed),
        )
        found["bearing_torque"] = torque / known.bearing_torque
    return found


def predict(
    drive: CoboticDrive, rig: Rig, data: RigData, values: Mapping[str, float], errors: Errors | None = None
) -> Readings:
    """Predict the readings of every run from its settings and the cylinder angle.

    Parameters
    ----------
    drive : CoboticDrive   Drive of the study: dimensions, gearing, creep law.
    rig : Rig
    data : RigData         Settings; of the measured values only the cylinder angle and the direction of travel.
    values : mapping       Values of all `PARAMETERS`, in SI.
    errors : Errors        Session errors; None for zero.

    Returns
    -------
    Readings   Zero travel with the wheel lifted off; nan where the wheel would slip.

    Source: `RotaryLinearIVT.operate` and `load_on_wheel`.
    """
    errors = errors or Errors()
    known, pressed = drive.transmission, data.pressed
    preload: Any = np.where(pressed, data.preload, known.preload) * (1.0 + errors.preload)
    growth = _growth(known, preload, drive.cylinder_speed)
    groups: dict[str, Any] = {name: values[name] * factor for name, factor in growth.items()}
    element = turning_as(
        RotaryLinearIVT(
            cylinder_radius=known.cylinder_radius,
            wheel_radius=known.wheel_radius,
            preload=preload,
            friction=known.friction_limit(drive.cylinder_speed),
            creep_law=_law_on_patch(known),
            **groups,
        ),
        known,
    )
    speed = data.cylinder_angle / data.duration
    force = load_on_wheel(drive, rig, data, values["guideway_friction"], errors)
    point = element.operate(
        cylinder_speed=speed,
        steering_angle=np.where(pressed, data.steering_angle + errors.steering_zero, 0.0),
        link_force=np.where(pressed, force, 0.0),
    )
    ratio = drive.gearhead.ratio
    rubbing = _loaded_bearings(drive, preload, point.torque, force, speed, element.groups(speed).rolling_force)
    passed = np.where(pressed, point.torque + rubbing, 0.0) / ratio
    torque = passed + coulomb(speed, values["nominal_torque"]) + drive.gearhead.load_friction(speed * ratio, passed)
    current = torque / values["torque_constant"]
    return Readings(
        link_travel=np.where(pressed, point.link_speed * data.duration, 0.0),
        motor_current=(1.0 + errors.current_gain) * current,
        motor_voltage=values["resistance"] * current + values["torque_constant"] * speed * ratio,
    )
