"""What a rig records: one row a run."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

import numpy as np

from infinivar._core.result import Frozen, result
from infinivar.errors import InputError
from infinivar.motion.tables import read_columns
from infinivar.units import plain

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


class LeftOut(NamedTuple):
    """A run that was not fitted."""

    row: int
    """Of the data."""
    line: int
    """Of the file."""
    reason: str


@result
class RigData(Frozen):
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


def check(data: RigData) -> None:
    """Refuse settings that cannot be, such as a mass below zero.

    Raises
    ------
    InputError
        A line for each fault, with the row, what is found and what would be right.
    """
    faults = {row: said for row in range(len(data)) if (said := _setting_fault(data, row)) is not None}
    if faults:
        refuse(data, faults)


def refuse(data: RigData, faults: Mapping[int, str], closing: str = "") -> NoReturn:
    """Raise InputError with a line for each fault, index of a run and words, and one that says what they mean."""
    said = [f"{data.name}: line {data.lines[row]}: {faults[row]}" for row in sorted(faults)[:_MOST]]
    more = len(faults) - _MOST
    raise InputError("\n".join([*said, *([f"and {more} more"] if more > 0 else []), *([closing] if closing else [])]))


def _setting_fault(data: RigData, row: int) -> str | None:
    duration, mass, preload = (float(getattr(data, name)[row]) for name in ("duration", "mass", "preload"))
    angle = float(data.steering_angle[row])
    if duration <= 0:
        return f"duration must be > 0 s, got {plain(duration)}"
    if mass < 0 or preload < 0:
        name, value = ("mass", mass) if mass < 0 else ("preload", preload)
        return f"{name} must be >= 0, got {plain(value)}"
    if abs(angle) >= 0.5 * math.pi:
        return f"steering_angle must be within -90 and 90 deg, got {plain(math.degrees(angle))} deg"
    return None
