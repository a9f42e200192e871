"""What a rig records: one row a run, with every row held against what a rig can give."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.rig import Rig
from infinivar.drivetrain.tables import read_columns
from infinivar.errors import InputError

COLUMNS = {
    "steering_angle": "rad",
    "mass": "kg",
    "preload": "N",
    "duration": "s",
    "cylinder_angle": "rad",
    "link_travel": "m",
    "motor_current": "A",
    "motor_voltage": "V",
}
"""Columns of a rig's data with their SI units; the voltage may be left out."""

_REQUIRED = tuple(name for name in COLUMNS if name != "motor_voltage")
_MOST = 12
"""Faults listed at once."""

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


@dataclass(frozen=True, slots=True, kw_only=True)
class RigData:
    """Runs of a rig: arrays of one length, SI.

    Signs are those of the transmission: a positive steering angle moves the link backwards on a cylinder that turns
    forwards, a mass pulls the link backwards, and lifting is a positive travel. A run without preload, its wheel lifted
    off, gives the torque that motor and gearing take by themselves.

    Attributes
    ----------
    steering_angle : as the steering encoder says. [rad]
    mass : that hangs on the link. [kg]
    preload : as the spring's setting says; 0 for a wheel that is lifted off. [N]
    duration : of the window over which the run is measured. [s]
    cylinder_angle, link_travel : in that window. [rad], [m]
    motor_current, motor_voltage : means over it; the voltage may be None. [A], [V]
    lines : of the file in which the runs stand.
    name : of the file.
    """

    steering_angle: np.ndarray
    mass: np.ndarray
    preload: np.ndarray
    duration: np.ndarray
    cylinder_angle: np.ndarray
    link_travel: np.ndarray
    motor_current: np.ndarray
    motor_voltage: np.ndarray | None
    lines: tuple[int, ...]
    name: str = "rig data"

    def __len__(self) -> int:
        """Number of runs."""
        return len(self.lines)

    @property
    def pressed(self) -> np.ndarray:
        """Which runs have the wheel on the cylinder."""
        return self.preload > 0

    @property
    def columns(self) -> dict[str, np.ndarray]:
        """The runs as columns under headings with their units, as `read` takes them."""
        found = {name: getattr(self, name) for name in COLUMNS}
        return {f"{name} [{COLUMNS[name]}]": values for name, values in found.items() if values is not None}

    def chosen(self, rows: Any) -> RigData:
        """Some of the runs, by index or mask."""
        picked = {
            name: None if getattr(self, name) is None else getattr(self, name)[rows]
            for name in (field.name for field in dataclasses.fields(self))
            if name not in ("lines", "name")
        }
        return dataclasses.replace(self, **picked, lines=tuple(np.asarray(self.lines)[rows].tolist()))


def read(file: str | Path) -> RigData:
    """Runs from a CSV file.

    Parameters
    ----------
    file : str or Path   A header that names the columns with their units, such as ``mass [kg]``, then one run a line.

    Returns
    -------
    RigData

    Raises
    ------
    InputError
        If the file cannot be read, a column or a unit is missing or of another kind, or a cell has no number.
    """
    columns, lines = read_columns(str(file), tuple(COLUMNS.items()), _REQUIRED, rising=None)
    arrays: dict[str, Any] = {name: np.asarray(values, dtype=float) for name, values in columns.items()}
    return RigData(**{"motor_voltage": None, **arrays}, lines=tuple(lines), name=str(file))


def check(data: RigData, drive: CoboticDrive, rig: Rig) -> None:
    """Refuse runs that no rig with this drive can have given: slips of columns, units and sensors.

    Raises
    ------
    InputError
        A line for each fault, with the row, what is found and what it suggests.
    """
    refuse(data, sorted(_faults(data, drive, rig)))


def refuse(data: RigData, faults: Sequence[tuple[int, str]]) -> None:
    """Raise InputError if there are faults, each the index of a run and words, with a line for each."""
    said = [f"{data.name}: line {data.lines[row]}: {words}" for row, words in faults[:_MOST]]
    if said:
        more = len(faults) - _MOST
        raise InputError("\n".join([*said, *([f"and {more} more"] if more > 0 else [])]))


def _faults(data: RigData, drive: CoboticDrive, rig: Rig) -> Iterator[tuple[int, str]]:
    """Row and words for every fault, the first of each row."""
    for row in range(len(data)):
        said = (
            _setting_fault(data, row)
            or _speed_fault(data, drive, rig, row)
            or _load_fault(data, drive, rig, row)
            or _travel_fault(data, drive, rig, row)
            or _voltage_fault(data, drive, row)
        )
        if said is not None:
            yield row, said


def _setting_fault(data: RigData, row: int) -> str | None:
    duration, mass, preload = (float(getattr(data, name)[row]) for name in ("duration", "mass", "preload"))
    angle = float(data.steering_angle[row])
    if duration <= 0:
        return f"duration must be > 0 s, got {duration:.4g}"
    if mass < 0 or preload < 0:
        name, value = ("mass", mass) if mass < 0 else ("preload", preload)
        return f"{name} must be >= 0, got {value:.4g}"
    if abs(angle) >= 0.5 * math.pi:
        return f"steering_angle must be within -90 and 90 deg, got {math.degrees(angle):.4g} deg"
    return None


def _speed_fault(data: RigData, drive: CoboticDrive, rig: Rig, row: int) -> str | None:
    motor, ratio = drive.motor, drive.gearhead.ratio
    turned, duration = float(data.cylinder_angle[row]), float(data.duration[row])
    speed, fastest = abs(turned) / duration, 1.5 * motor.no_load_speed / ratio
    current, stall = float(data.motor_current[row]), motor.voltage / motor.resistance
    if abs(turned) < 10 * rig.cylinder_resolution:
        return f"cylinder_angle is {turned:.4g} rad in {duration:.3g} s: does it turn, or is its encoder stuck?"
    if speed > fastest:
        hint = "; is it the angle of the motor, not of the cylinder?" if speed < 2 * fastest * ratio else ""
        return f"cylinder_angle means {speed:.4g} rad/s, and the motor reaches {fastest:.4g} rad/s at most{hint}"
    if speed < abs(drive.cylinder_speed) / _SLOWEST:
        wanted = f"the study's cylinder turns at {abs(drive.cylinder_speed):.4g} rad/s"
        return f"cylinder_angle and duration mean {speed:.4g} rad/s, and {wanted}: check the units of both headings"
    if abs(current) > stall:
        return f"motor_current is {current:.4g} A, more than the motor's stall current of {stall:.3g} A"
    if data.preload[row] == 0 and current * turned < -5.0 * rig.current_noise * abs(turned):
        return f"motor_current is {current:.4g} A and brakes a cylinder that nothing drives: is a sign turned round?"
    return None


def _load_fault(data: RigData, drive: CoboticDrive, rig: Rig, row: int) -> str | None:
    mass, preload, friction = float(data.mass[row]), float(data.preload[row]), drive.transmission.friction
    if preload == 0 or mass * rig.gravity <= 1.5 * friction * preload:
        return None
    hint = "; are mass and preload swapped?" if preload * rig.gravity < 1.5 * friction * mass else ""
    return f"mass pulls with {mass * rig.gravity:.4g} N where the wheel slips at {friction * preload:.4g} N{hint}"


def _voltage_fault(data: RigData, drive: CoboticDrive, row: int) -> str | None:
    if data.motor_voltage is None:
        return None
    voltage, current = float(data.motor_voltage[row]), float(data.motor_current[row])
    speed = float(data.cylinder_angle[row] / data.duration[row]) * drive.gearhead.ratio
    wanted = drive.motor.resistance * current + drive.motor.torque_constant * speed
    if abs(voltage - wanted) <= 0.4 * abs(wanted) + 0.1 * drive.motor.voltage:
        return None
    swapped = drive.motor.resistance * voltage + drive.motor.torque_constant * speed
    hint = "; are motor_current and motor_voltage swapped?" if abs(current - swapped) < 0.4 * abs(swapped) else ""
    return f"motor_voltage is {voltage:.4g} V where current and speed take {wanted:.4g} V{hint}"


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
        return f"link_travel {same} where the wheel points to {ideal:.4g} m: is its encoder stuck?"
    factor = travel / ideal if ideal else math.inf
    hint = next((f"; {said}" for known, said in _SLIPS.items() if abs(abs(factor) / known - 1.0) < 0.25), "")
    if abs(factor + 1.0) < 0.25:
        hint = "; is a sign turned round?"
    if _near(float(data.cylinder_angle[row]), -element.cylinder_radius * math.tan(angle) * travel):
        hint = "; are link_travel and cylinder_angle swapped?"
    return f"link_travel is {travel:.4g} m where steering and cylinder angle give {ideal:.4g} m{hint}"


def _near(value: float, wanted: float) -> bool:
    return abs(value - wanted) < 0.25 * abs(wanted)
