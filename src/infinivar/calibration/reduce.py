"""Reduce rig data by the paper's equations: Eq 9 for the creep stiffness, Eq 18 for the efficiency."""

from __future__ import annotations

import math

import numpy as np

from infinivar import power
from infinivar._core.result import Frozen, result
from infinivar.calibration.transmission import RigData, load_on_wheel
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.study.rig import Rig

LOCKED = 1e-9
"""Steering angle below which a run counts as locked. [rad]"""

_IMPOSSIBLE = 5.0
"""Number of standard deviations above 1 at which an efficiency is a data fault."""


@result
class Efficiencies(Frozen):
    """Efficiency of the transmission in each run; arrays of equal length.

    Attributes
    ----------
    ratio : cylinder surface speed over link speed, without creep, 1/|tan phi|. [-]
    load : force on the link over slip force, as set. [-]
    lifts : whether the link lifts its mass, with power flowing from the cylinder to the link.
    value, deviation : efficiency in the direction of power flow, and its standard deviation; nan if both sides feed the
        losses, the wheel is locked, or the wheel is lifted off. [-]
    """

    ratio: np.ndarray
    load: np.ndarray
    lifts: np.ndarray
    value: np.ndarray
    deviation: np.ndarray


def nominal_torque(
    drive: CoboticDrive, data: RigData, otherwise: float, misread: np.ndarray | None = None
) -> tuple[float, float]:
    """Mean motor torque with the wheel lifted off, and number of such runs; `otherwise` without any. [N m], [-]

    `misread` runs, (n,) bool, are excluded.

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
    """Creep stiffness from each locked run: force over creep times surface speed.

    Parameters
    ----------
    guideway_friction : float   At the study's preload. [N]

    Returns
    -------
    value, deviation : (n,) float   At the preload of the run; nan unless locked. [N]

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
    """Efficiency of the transmission in each run: work on the link over work of the cylinder.

    Parameters
    ----------
    guideway_friction, guideway_deviation : float   Friction at the study's preload, and its standard deviation. [N]
    nominal, nominal_deviation : float              Motor torque with the wheel lifted off, and its standard deviation; used
        if no run measures it. [N m]
    misread : (n,) bool                             Runs excluded from that torque, None for none.

    Returns
    -------
    Efficiencies

    Notes
    -----
    Load-dependent gearing losses are attributed to the transmission: with the proportional loss model of the gearhead the
    efficiency is too low.

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
    # Output work without input work, beyond the noise, is a data fault and has no efficiency.
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
    element = drive.transmission
    return element.friction_limit(drive.cylinder_speed) * np.where(data.pressed, data.preload, element.preload)


def impossible(found: Efficiencies) -> dict[int, str]:
    """Runs whose efficiency exceeds 1 by more than the sensor errors: findings by index."""
    faults, hint = {}, "check mass, motor_current and its sign, and the no-load torque"
    for row in np.flatnonzero(found.value - _IMPOSSIBLE * found.deviation > 1.0).tolist():
        value = f"{found.value[row]:.3f} ± {found.deviation[row]:.3f}, above 1"
        said = (
            value
            if np.isfinite(found.value[row])
            else "above 1, as the link receives work but the cylinder supplies none"
        )
        faults[row] = f"efficiency by Eq 18 is {said}: {hint}"
    return faults
