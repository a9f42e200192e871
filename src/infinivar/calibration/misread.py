"""Readings that no rig can give: found run by run, left out where they are few, refused where they are not."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from infinivar.calibration.data import RigData, refuse
from infinivar.calibration.fit import FEW
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.study.rig import Rig
from infinivar.units import plain

_SLOWEST = 100.0
"""How much slower than in the study a cylinder on a rig may turn; seconds for milliseconds make a thousand."""

_SLIPS = {
    1e3: "is it in millimetres?",
    1e-3: "is it in metres?",
    180 / math.pi: "is an angle in radians taken for degrees?",
    math.pi / 180: "is an angle in degrees taken for radians?",
    2 * math.pi: "are turns taken for radians?",
    0.5 / math.pi: "are radians taken for turns?",
}
"""What a factor between travel and angles suggests."""

_OFF = 5.0
"""Standard deviations by which a setting may be off."""

_PATTERN = 4
"""Runs of a kind that must be wrong before they count as a pattern: with one reading in twenty misread at random, four
of the runs at one ratio are in one session of 30,000."""

_ALIKE = 1e-3
"""Steering angles that count as one setting. [rad]"""


def find(data: RigData, drive: CoboticDrive, rig: Rig) -> dict[int, str]:
    """Runs that no rig with this drive can have given: slips of columns, units and sensors.

    Returns
    -------
    dict   By the index of the run: what is found and what it suggests.
    """
    return {row: said for row in range(len(data)) if (said := _fault(data, drive, rig, row)) is not None}


def refuse_unless_few(data: RigData, faults: Mapping[int, str]) -> None:
    """Refuse the data if wrong runs are too many, or too alike, to be single misread values.

    Raises
    ------
    InputError
        A line for each of them, and what makes them too many.
    """
    if len(faults) > FEW * len(data):
        refuse(data, faults, f"{len(faults)} of {len(data)} runs are too many to be left out as misread")
    kind = pattern(data, faults)
    if kind:
        refuse(data, faults, f"{kind}: that is no single misread value, so none is left out")


def pattern(data: RigData, rows: Any) -> str:
    """The kind of run of which most are among some, such as "12 of the 14 runs with 3.98 kg"; "" if there is none."""
    chosen = np.zeros(len(data), dtype=bool)
    chosen[list(rows)] = True
    for words, members in _kinds(data):
        found, count = np.count_nonzero(chosen & members), np.count_nonzero(members)
        if found >= _PATTERN and 2 * found > count:
            return f"{found} of the {count} runs {words}"
    return ""


def _kinds(data: RigData) -> Iterator[tuple[str, np.ndarray]]:
    """Runs with a setting in common. Settings alone: what was measured may be what is wrong."""
    pressed, angle, size = data.pressed, data.steering_angle, np.round(np.abs(data.steering_angle) / _ALIKE)
    yield "with the wheel lifted off", ~pressed
    for steered in np.unique(size[pressed]):
        degrees = math.degrees(float(np.abs(angle[pressed & (size == steered)]).mean()))
        words = f"steered to {plain(degrees, 3)} deg either way" if steered else "with the wheel locked"
        yield words, pressed & (size == steered)
    for mass in np.unique(data.mass[pressed]):
        yield f"with {plain(mass)} kg", pressed & (data.mass == mass)
    for preload in np.unique(data.preload[pressed]):
        yield f"with a preload of {plain(preload)} N", data.preload == preload
    for words, way in (("forwards", angle < 0), ("backwards", angle > 0)):
        yield f"steered to move the link {words}", pressed & way & (size > 0)


def _fault(data: RigData, drive: CoboticDrive, rig: Rig, row: int) -> str | None:
    """The first fault of a run."""
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
        return (
            f"cylinder_angle is {plain(turned)} rad in {plain(duration, 3)} s: does it turn, or is its encoder stuck?"
        )
    if speed > fastest:
        hint = "; is it the angle of the motor, not of the cylinder?" if speed < 2 * fastest * ratio else ""
        return f"cylinder_angle means {plain(speed)} rad/s, and the motor reaches {plain(fastest)} rad/s at most{hint}"
    if speed < abs(drive.cylinder_speed) / _SLOWEST:
        wanted = f"the study's cylinder turns at {plain(abs(drive.cylinder_speed))} rad/s"
        return f"cylinder_angle and duration mean {plain(speed)} rad/s, and {wanted}: check the units of both headings"
    if abs(current) > stall:
        hint = _swapped_hint(data, drive, row)
        return f"motor_current is {plain(current)} A, more than the motor's stall current of {plain(stall, 3)} A{hint}"
    if data.preload[row] == 0 and current * turned < -5.0 * rig.current_noise * abs(turned):
        return f"motor_current is {plain(current)} A and brakes a cylinder that nothing drives: is a sign turned round?"
    return None


def _load_fault(data: RigData, drive: CoboticDrive, rig: Rig, row: int) -> str | None:
    """What is wrong if the load was more than the wheel holds by the study, and the preload may be off."""
    mass, preload, friction = float(data.mass[row]), float(data.preload[row]), drive.transmission.friction
    pulls, slips = mass * rig.gravity, friction * preload
    lateral = pulls / math.cos(float(data.steering_angle[row]))
    if preload == 0 or lateral <= (1.0 + _OFF * rig.preload_deviation) * slips:
        return None
    swapped = pulls > 1.5 * slips and preload * rig.gravity < 1.5 * friction * mass
    hint = "are mass and preload swapped?" if swapped else f"is the study's friction of {plain(friction)} too small?"
    return f"mass loads the wheel with {plain(lateral)} N where by the study it slips at {plain(slips)} N; {hint}"


def _voltage_fault(data: RigData, drive: CoboticDrive, row: int) -> str | None:
    if data.motor_voltage is None:
        return None
    voltage, current = float(data.motor_voltage[row]), float(data.motor_current[row])
    wanted = _voltage(data, drive, row, current)
    if abs(voltage - wanted) <= 0.4 * abs(wanted) + 0.1 * drive.motor.voltage:
        return None
    hint = _swapped_hint(data, drive, row)
    return f"motor_voltage is {plain(voltage)} V where current and speed take {plain(wanted)} V{hint}"


def _voltage(data: RigData, drive: CoboticDrive, row: int, current: float) -> float:
    """What a current and the speed of a run take. [V]"""
    speed = float(data.cylinder_angle[row] / data.duration[row]) * drive.gearhead.ratio
    return drive.motor.resistance * current + drive.motor.torque_constant * speed


def _swapped_hint(data: RigData, drive: CoboticDrive, row: int) -> str:
    if data.motor_voltage is None:
        return ""
    swapped = _voltage(data, drive, row, float(data.motor_voltage[row]))
    wrong = abs(float(data.motor_current[row]) - swapped) < 0.4 * abs(swapped)
    return "; are motor_current and motor_voltage swapped?" if wrong else ""


def _travel_fault(data: RigData, drive: CoboticDrive, rig: Rig, row: int) -> str | None:
    """What is wrong if the link did not go where the wheel points, as far as creep and the encoder's zero let it."""
    if data.preload[row] == 0:
        return None
    element = drive.transmission
    groups = element.groups(drive.cylinder_speed)
    surface = element.cylinder_radius * float(data.cylinder_angle[row])
    angle, travel = float(data.steering_angle[row]), float(data.link_travel[row])
    ideal = -surface * math.tan(angle)
    # Five times the creep of the study's contact at slip: what is fitted may be another.
    creeps = abs(surface) * (5.0 / float(groups.creep_group) + 5.0 * rig.steering_zero_deviation)
    still = travel == 0.0 and abs(ideal) > 100.0 * rig.link_resolution
    if not still and abs(travel - ideal) <= creeps + 0.2 * abs(ideal) + 5.0 * rig.link_resolution:
        return None
    previous = data.link_travel[row - 1] if row else math.nan
    if travel == 0.0 or travel == previous:
        same = "does not move" if travel == 0.0 else "has the value of the line before"
        return f"link_travel {same} where the wheel points to {plain(ideal)} m: is its encoder stuck?"
    factor = travel / ideal if ideal else math.inf
    hint = next((f"; {said}" for known, said in _SLIPS.items() if abs(abs(factor) / known - 1.0) < 0.25), "")
    if abs(factor + 1.0) < 0.25:
        hint = "; is a sign turned round?"
    if _near(float(data.cylinder_angle[row]), -element.cylinder_radius * math.tan(angle) * travel):
        hint = "; are link_travel and cylinder_angle swapped?"
    return f"link_travel is {plain(travel)} m where steering and cylinder angle give {plain(ideal)} m{hint}"


def _near(value: float, wanted: float) -> bool:
    return abs(value - wanted) < 0.25 * abs(wanted)
