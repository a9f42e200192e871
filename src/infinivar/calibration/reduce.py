"""Reducing a rig's data by the paper's own equations: Eq 9 for the creep stiffness, Eq 18 for the efficiency."""

from __future__ import annotations

import math

import numpy as np

from infinivar import power
from infinivar._core.result import Frozen, result
from infinivar.calibration.data import RigData
from infinivar.calibration.model import load_on_wheel
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.study.rig import Rig

LOCKED = 1e-9
"""Steering angle below which a run counts as locked. [rad]"""

_IMPOSSIBLE = 5.0
"""Standard deviations above 1 from which on an efficiency is a fault of the data."""


@result
class Efficiencies(Frozen):
    """Efficiency of the element in each run; arrays of one length.

    Attributes
    ----------
    ratio : cylinder surface speed over link speed, without creep, 1/|tan phi|. [-]
    load : force on the link over slip force, as set. [-]
    lifts : whether the link lifts its mass: power flows from the cylinder to it.
    value, deviation : efficiency in the direction in which power flows, and its standard deviation; nan where both sides
        feed the losses, where the wheel is locked and where it is lifted off. [-]
    """

    ratio: np.ndarray
    load: np.ndarray
    lifts: np.ndarray
    value: np.ndarray
    deviation: np.ndarray


def nominal_torque(
    drive: CoboticDrive, data: RigData, otherwise: float, misread: np.ndarray | None = None
) -> tuple[float, float]:
    """Mean torque at the motor with the wheel lifted off, and in how many runs; `otherwise` where there are none. [N m], [-]

    Runs that are `misread`, (n,) bool, do not count.

    Source: faulring2006, section IV-B (tau_n,c).
    """
    lifted = ~data.pressed if misread is None else ~data.pressed & ~misread
    count = float(np.count_nonzero(lifted))
    if not count:
        return otherwise, 0.0
    current = data.motor_current * np.sign(data.cylinder_angle)
    return float(np.mean(current[lifted]) * drive.motor.torque_constant), count


def creep_stiffness(
    drive: CoboticDrive, rig: Rig, data: RigData, guideway_friction: float
) -> tuple[np.ndarray, np.ndarray]:
    """Creep stiffness from each locked run: force over creep, times the speed of the surface.

    Parameters
    ----------
    guideway_friction : float   At the study's preload. [N]

    Returns
    -------
    value, deviation : (n,) float   At the preload of the run; nan for runs that are not locked. [N]

    Source: faulring2006, Eq 9.
    """
    locked = data.pressed & (np.abs(data.steering_angle) < LOCKED) & (data.link_travel != 0) & (data.mass > 0)
    force = load_on_wheel(drive, rig, data, guideway_friction)
    surface = np.abs(drive.transmission.cylinder_radius * data.cylinder_angle)
    travel = np.where(locked, np.abs(data.link_travel), np.nan)
    value = surface * np.abs(force) / travel
    off = math.hypot(rig.steering_zero_deviation, rig.steering_resolution / math.sqrt(12.0))
    spread = np.hypot(surface * off / travel, rig.link_resolution / math.sqrt(6.0) / travel)
    return value, value * np.hypot(spread, rig.mass_deviation * rig.gravity / np.where(locked, force, np.nan))


def efficiencies(
    drive: CoboticDrive,
    rig: Rig,
    data: RigData,
    *,
    guideway_friction: float,
    guideway_deviation: float = 0.0,
    nominal: float,
    nominal_deviation: float = 0.0,
    misread: np.ndarray | None = None,
) -> Efficiencies:
    """Efficiency of the element in each run, from work on the link over work of the cylinder.

    Parameters
    ----------
    guideway_friction, guideway_deviation : float   At the study's preload, and its standard deviation. [N]
    nominal, nominal_deviation : float              Torque at the motor with the wheel lifted off, and its standard
        deviation, where no run says. [N m]
    misread : (n,) bool                             Runs that do not count for that torque, None for none.

    Returns
    -------
    Efficiencies

    Notes
    -----
    All that the gearing loses under load counts as the element's: with a gearhead of the proportional loss model the
    efficiency comes out too low.

    Source: faulring2006, Eq 18.
    """
    motor, gear = drive.motor, drive.gearhead
    nominal, counted = nominal_torque(drive, data, nominal, misread)
    force = load_on_wheel(drive, rig, data, guideway_friction)
    turning = np.sign(data.cylinder_angle)
    torque = motor.torque_constant * data.motor_current - nominal * turning
    work_in = torque * gear.ratio * data.cylinder_angle
    work_out = force * data.link_travel
    used = data.pressed & (np.abs(data.steering_angle) >= LOCKED)
    value = np.where(used, power.efficiency(work_in, work_out), np.nan)
    samples = np.maximum(rig.sample_rate * data.duration, 1.0)
    noise = motor.torque_constant * rig.current_noise / np.sqrt(samples)
    noise = noise * math.sqrt(1.0 + 1.0 / counted) if counted else np.hypot(noise, nominal_deviation)
    # Work that comes out while none goes in, or more than noise can hide comes back: no efficiency, but a fault.
    created = used & (work_out > 0) & (torque * turning < -_IMPOSSIBLE * noise)
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = np.sqrt(
            (noise / torque) ** 2
            + rig.current_gain_deviation**2
            + (np.hypot(rig.mass_deviation * rig.gravity, guideway_deviation) / force) ** 2
            + (rig.link_resolution / math.sqrt(6.0) / data.link_travel) ** 2
            + (rig.cylinder_resolution / math.sqrt(6.0) / data.cylinder_angle) ** 2
        )
        deviation = np.where(created, 0.0, value) * relative  # nan where the link's encoder stood still
        ratio = np.abs(1.0 / np.tan(data.steering_angle))
    return Efficiencies(
        ratio=np.where(used, ratio, np.inf),
        load=np.where(data.pressed, data.mass * rig.gravity / _slip(drive, data), np.nan),
        lifts=data.link_travel > 0,
        value=np.where(created, np.inf, value),
        deviation=deviation,
    )


def _slip(drive: CoboticDrive, data: RigData) -> np.ndarray:
    return drive.transmission.friction * np.where(data.pressed, data.preload, drive.transmission.preload)


def impossible(found: Efficiencies) -> dict[int, str]:
    """Runs whose efficiency is above 1 beyond what the sensors leave open: by index, with what is found."""
    faults, hint = {}, "check mass, motor_current and its sign, and the torque without load"
    for row in np.flatnonzero(found.value - _IMPOSSIBLE * found.deviation > 1.0).tolist():
        value = f"{found.value[row]:.3f} ± {found.deviation[row]:.3f}, above 1"
        said = value if np.isfinite(found.value[row]) else "above 1, as the link gets work and the cylinder gives none"
        faults[row] = f"efficiency by Eq 18 is {said}: {hint}"
    return faults
