"""What a rig would read in a run, given the parameters of the drive: the model that is fitted to data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from infinivar._core.array_namespace import Array
from infinivar.calibration.data import RigData
from infinivar.contact.friction import coulomb
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.study.rig import Rig
from infinivar.transmission.geometry import PRELOAD_POWERS
from infinivar.transmission.rotary_linear import RotaryLinearIVT


class Parameter(NamedTuple):
    """What can be fitted."""

    unit: str
    shown_in: str
    meaning: str


PARAMETERS = {
    "creep_stiffness": Parameter("N", "N", "creep stiffness C = C22 G a b"),
    "rolling_torque": Parameter("N m", "mN m", "hysteresis torque of the rolling contact"),
    "bearing_torque": Parameter("N m", "mN m", "friction torque of the axle bearings"),
    "guideway_friction": Parameter("N", "N", "friction of the guideway"),
    "nominal_torque": Parameter("N m", "mN m", "torque at the motor that motor and gearing take by themselves"),
    "torque_constant": Parameter("N m/A", "mN m/A", "torque constant of the motor"),
    "resistance": Parameter("ohm", "ohm", "terminal resistance of the motor"),
}
"""By name; those that depend on the preload hold at the study's."""

USUAL = tuple(PARAMETERS)[:5]
"""What is fitted unless something else is asked for."""


class Readings(NamedTuple):
    """What the sensors of a rig read, a value a run; voltage whether recorded or not. [m], [A], [V]"""

    link_travel: np.ndarray
    motor_current: np.ndarray
    motor_voltage: np.ndarray


@dataclass(frozen=True, slots=True, kw_only=True)
class Errors:
    """How far settings and sensors are off in all runs of a session.

    `mass` is that of each run. Zero everywhere for a rig that tells the truth.
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
    nominal = motor.friction_torque + gear.coulomb_friction(motor.continuous_torque)
    return {
        "creep_stiffness": float(groups.creep_stiffness),
        "rolling_torque": float(groups.rolling_torque),
        "bearing_torque": float(groups.bearing_torque),
        "guideway_friction": float(drive.guideway.friction_force(drive.transmission.preload)),
        "nominal_torque": float(nominal),
        "torque_constant": motor.torque_constant,
        "resistance": motor.resistance,
    }


def load_on_wheel(
    drive: CoboticDrive, rig: Rig, data: RigData, guideway_friction: float, errors: Errors | None = None
) -> np.ndarray:
    """Force of the transmission on the link that lifts or lowers a mass against the guideway's friction.

    Parameters
    ----------
    guideway_friction : float   At the study's preload; its share in the preload follows that of the run. [N]

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


def _growth(element: RotaryLinearIVT, preload: Array, speed: float) -> dict[str, Array]:
    """By which factors losses are larger than at the study's preload; bearings as their model says where there is one."""
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
    """Readings of every run, from its settings and the angle that the cylinder turned.

    Parameters
    ----------
    drive : CoboticDrive   Of the study: dimensions, gearing, creep law.
    rig : Rig
    data : RigData         Settings; of what was measured the cylinder angle, and which way the link went.
    values : mapping       All of `PARAMETERS`, in SI.
    errors : Errors        None for none.

    Returns
    -------
    Readings   Of runs with the wheel lifted off no travel is expected. nan where the wheel would slip.

    Source: `RotaryLinearIVT.operate` and `load_on_wheel`.
    """
    errors = errors or Errors()
    known, pressed = drive.transmission, data.pressed
    preload: Any = np.where(pressed, data.preload, known.preload) * (1.0 + errors.preload)
    growth = _growth(known, preload, drive.cylinder_speed)
    groups: dict[str, Any] = {name: values[name] * factor for name, factor in growth.items()}
    element = RotaryLinearIVT(
        cylinder_radius=known.cylinder_radius,
        wheel_radius=known.wheel_radius,
        preload=preload,
        friction=known.friction,
        creep_law=known.creep_law,
        **groups,
    )
    speed = data.cylinder_angle / data.duration
    force = load_on_wheel(drive, rig, data, values["guideway_friction"], errors)
    point = element.operate(
        cylinder_speed=speed,
        steering_angle=np.where(pressed, data.steering_angle + errors.steering_zero, 0.0),
        link_force=np.where(pressed, force, 0.0),
    )
    ratio = drive.gearhead.ratio
    passed = np.where(pressed, point.torque, 0.0) / ratio
    torque = passed + coulomb(speed, values["nominal_torque"])
    if drive.gearhead.loss_model == "proportional":
        torque = torque + drive.gearhead.proportional_friction(speed * ratio, passed)
    current = torque / values["torque_constant"]
    return Readings(
        link_travel=np.where(pressed, point.link_speed * data.duration, 0.0),
        motor_current=(1.0 + errors.current_gain) * current,
        motor_voltage=values["resistance"] * current + values["torque_constant"] * speed * ratio,
    )
