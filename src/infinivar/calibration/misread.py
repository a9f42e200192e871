"""Find implausible readings run by run; exclude them if few, refuse the data if many."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from infinivar.calibration import bench
from infinivar.calibration.transmission import RigData
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.study.rig import Rig
from infinivar.units import plain

_SLOWEST = 100.0
"""Factor by which the rig's cylinder may be slower than the study's; confusing s and ms makes a factor of 1000."""

_SLIPS = {
    1e3: "is it in millimetres?",
    1e-3: "is it in metres?",
    180 / math.pi: "was an angle in radians labelled as degrees?",
    math.pi / 180: "was an angle in degrees labelled as radians?",
    2 * math.pi: "were turns labelled as radians?",
    0.5 / math.pi: "were radians labelled as turns?",
}
"""Likely cause of a wrong factor between travel and angles."""

_OFF = 5.0
"""Largest plausible error of a setting, in standard deviations."""

_PATTERN = 4
"""Implausible runs with a common setting that make a pattern: with 5 % of readings misread at random, four of the runs at
one ratio are affected in one session of 30,000."""

_ALIKE = 1e-3
"""Difference below which steering angles count as one setting. [rad]"""


def find(data: RigData, drive: CoboticDrive, rig: Rig) -> dict[int, str]:
    """Find runs that are physically impossible for this drive: wrong columns, units or sensors.

    Returns
    -------
    dict   Finding and likely cause, by index of the run.
    """
    return {row: said for row in range(len(data)) if (said := _fault(data, drive, rig, row)) is not None}


def refuse_unless_few(data: RigData, faults: Mapping[int, str]) -> None:
    """Refuse the data if the implausible runs are too many or too similar to be single misreadings.

    Raises
    ------
    InputError
        Lists the runs, one line each, and states why they are too many.
    """
    bench.refuse_unless_few(data, faults)
    kind = pattern(data, faults)
    if kind:
        bench.refuse(data, faults, f"{kind} are implausible: a systematic error, so no run is excluded")


def pattern(data: RigData, rows: Any) -> str:
    """A setting shared by most of the given runs, such as "12 of the 14 runs with 3.98 kg"; "" if none."""
    chosen = np.zeros(len(data), dtype=bool)
    chosen[list(rows)] = True
    for words, members in _kinds(data):
        found, count = np.count_nonzero(chosen & members), np.count_nonzero(members)
        if found >= _PATTERN and 2 * found > count:
            return f"{found} of the {count} runs {words}"
    return ""


def _kinds(data: RigData) -> Iterator[tuple[str, np.ndarray]]:
    """Groups of runs with a common setting; measured values do not count, as they may be wrong."""
    pressed, angle, size = data.pressed, data.steering_angle, np.round(np.abs(data.steering_angle) / _ALIKE)
    yield "with the wheel lifted off", ~pressed
    for steered in np.unique(size[pressed]):
        degrees = math.degrees(float(np.abs(angle[pressed & (size == steered)]).mean()))
        words = f"steered to {plain(degrees, 3)} deg in either direction" if steered else "with the wheel locked"
        yield words, pressed & (size == steered)
    for mass in np.unique(data.mass[pressed]):
        yield f"with {plain(mass)} kg", pressed & (data.mass == mass)
    for preload in np.unique(data.preload[pressed]):
        yield f"with a preload of {plain(preload)} N", data.preload == preload
    for words, way in (("forwards", angle < 0), ("backwards", angle > 0)):
        yield f"steered to move the link {words}", pressed & way & (size > 0)


def _fault(data: RigData, drive: CoboticDrive, rig: Rig, row: int) -> str | None:
    """The first fault of a run, if any."""
    return (
        _speed_fault(data, drive, rig, row)
        or _load_fault(data, drive, rig, row)
        or _travel_fault(data, drive, rig, row)
        or _voltage_fault(data, drive, row)
    )


def _speed_fault(data: RigData, drive: CoboticDrive, rig: Rig, row: int) -> str | None:
    motor, ratio = drive.motor, drive.gearhead.ratio
    turned, duration = float(data.cylinder_angle[row]), float(data.duration[row])
    speed, fastest = abs(turned) / duration, 1.5 * motor.no_load_speed / ratio
    current, stall = float(data.motor_current[row]), motor.voltage / motor.resistance
    if abs(turned) < 10 * rig.cylinder_resolution:
        return f"cylinder_angle is {plain(turned)} rad in {plain(duration, 3)} s: is the cylinder at rest or its encoder stuck?"
    if speed > fastest:
        hint = "; is it the motor angle instead of the cylinder angle?" if speed < 2 * fastest * ratio else ""
        return (
            f"cylinder_angle implies {plain(speed)} rad/s, but the motor reaches {plain(fastest)} rad/s at most{hint}"
        )
    if speed < abs(drive.cylinder_speed) / _SLOWEST:
        required = f"the study's cylinder turns at {plain(abs(drive.cylinder_speed))} rad/s"
        return (
            f"cylinder_angle and duration imply {plain(speed)} rad/s, but {required}: check the units of both headings"
        )
    if abs(current) > stall:
        hint = _swapped_hint(data, drive, row)
        return f"motor_current is {plain(current)} A, above the motor's stall current of {plain(stall, 3)} A{hint}"
    if data.preload[row] == 0 and current * turned < -5.0 * rig.current_noise * abs(turned):
        return f"motor_current is {plain(current)} A and brakes a cylinder that nothing drives: is a sign reversed?"
    return None


def _load_fault(data: RigData, drive: CoboticDrive, rig: Rig, row: int) -> str | None:
    """Fault if the load exceeds the slip force by more than the preload error allows."""
    mass, preload = float(data.mass[row]), float(data.preload[row])
    friction = float(drive.transmission.friction_limit(drive.cylinder_speed))
    pulls, slips = mass * rig.gravity, friction * preload
    lateral = pulls / math.cos(float(data.steering_angle[row]))
    if preload == 0 or lateral <= (1.0 + _OFF * rig.preload_deviation) * slips:
        return None
    swapped = pulls > 1.5 * slips and preload * rig.gravity < 1.5 * friction * mass
    hint = "are mass and preload swapped?" if swapped else f"is the study's friction of {plain(friction)} too low?"
    return f"mass loads the wheel with {plain(lateral)} N, but by the study the wheel slips at {plain(slips)} N; {hint}"


def _voltage_fault(data: RigData, drive: CoboticDrive, row: int) -> str | None:
    if data.motor_voltage is None:
        return None
    voltage, current = float(data.motor_voltage[row]), float(data.motor_current[row])
    required = _voltage(data, drive, row, current)
    if abs(voltage - required) <= 0.4 * abs(required) + 0.1 * drive.motor.voltage:
        return None
    hint = _swapped_hint(data, drive, row)
    return f"motor_voltage is {plain(voltage)} V, but current and speed require {plain(required)} V{hint}"


def _voltage(data: RigData, drive: CoboticDrive, row: int, current: float) -> float:
    """Motor voltage for a current at the speed of a run. [V]"""
    speed = float(data.cylinder_angle[row] / data.duration[row]) * drive.gearhead.ratio
    return drive.motor.resistance * current + drive.motor.torque_constant * speed


def _swapped_hint(data: RigData, drive: CoboticDrive, row: int) -> str:
    if data.motor_voltage is None:
        return ""
    swapped = _voltage(data, drive, row, float(data.motor_voltage[row]))
    wrong = abs(float(data.motor_current[row]) - swapped) < 0.4 * abs(swapped)
    return "; are motor_current and motor_voltage swapped?" if wrong else ""


def _travel_fault(data: RigData, drive: CoboticDrive, rig: Rig, row: int) -> str | None:
    """Fault if the travel differs from that of ideal rolling by more than creep and the steering zero allow."""
    if data.preload[row] == 0:
        return None
    element = drive.transmission
    groups = element.groups(drive.cylinder_speed)
    surface = element.cylinder_radius * float(data.cylinder_angle[row])
    angle, travel = float(data.steering_angle[row]), float(data.link_travel[row])
    ideal = -surface * math.tan(angle)
    # Five times the creep of the study's contact at slip, as the fitted contact may differ.
    creeps = abs(surface) * (5.0 / float(groups.creep_group) + 5.0 * rig.steering_zero_deviation)
    still = travel == 0.0 and abs(ideal) > 100.0 * rig.link_resolution
    if not still and abs(travel - ideal) <= creeps + 0.2 * abs(ideal) + 5.0 * rig.link_resolution:
        return None
    previous = data.link_travel[row - 1] if row else math.nan
    if travel == 0.0 or travel == previous:
        same = "is zero" if travel == 0.0 else "repeats the value of the previous line"
        return f"link_travel {same}, but the steering angle implies {plain(ideal)} m: is the encoder stuck?"
    factor = travel / ideal if ideal else math.inf
    hint = next((f"; {said}" for known, said in _SLIPS.items() if abs(abs(factor) / known - 1.0) < 0.25), "")
    if abs(factor + 1.0) < 0.25:
        hint = "; is a sign reversed?"
    if _near(float(data.cylinder_angle[row]), -element.cylinder_radius * math.tan(angle) * travel):
        hint = "; are link_travel and cylinder_angle swapped?"
    return f"link_travel is {plain(travel)} m, but steering and cylinder angle imply {plain(ideal)} m{hint}"


def _near(value: float, required: float) -> bool:
    return abs(value - required) < 0.25 * abs(required)
