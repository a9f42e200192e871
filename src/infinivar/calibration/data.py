"""Rig data: one row per run."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

import numpy as np

from infinivar._core.result import Frozen, result
from infinivar.errors import InputError
from infinivar.tables.named import read_named
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
"""Columns of rig data with their SI units; the voltage is optional."""

_REQUIRED = tuple(name for name in COLUMNS if name != "motor_voltage")
_MOST = 12
"""Largest number of faults listed in one message."""


class LeftOut(NamedTuple):
    """A run excluded from the fit."""

    row: int
    """Row of the data."""
    line: int
    """Line of the file."""
    reason: str

    def to_dict(self) -> dict[str, Any]:
        """Line and reason, for scripts."""
        return {"line": self.line, "reason": self.reason}


@result
class RigData(Frozen):
    """Runs of a rig: arrays of equal length, SI.

    Sign convention of the transmission: on a cylinder that turns forwards, a positive steering angle moves the link
    backwards; a mass pulls the link backwards; lifting is a positive travel. A run without preload (wheel lifted off)
    gives the torque of motor and gearing alone.

    Attributes
    ----------
    steering_angle : reading of the steering encoder. [rad]
    mass : mass hanging on the link. [kg]
    preload : set preload; 0 with the wheel lifted off. [N]
    duration : length of the measuring window. [s]
    cylinder_angle, link_travel : change over the window. [rad], [m]
    motor_current, motor_voltage : means over the window; the voltage may be None. [A], [V]
    lines : line numbers of the runs in the file.
    name : name of the file.
    empty : runs left out, as a cell is empty: what is said of each, by its line.
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
    empty: Mapping[int, str] = dataclasses.field(default_factory=dict)

    def __len__(self) -> int:
        """Number of runs."""
        return len(self.lines)

    @property
    def pressed(self) -> np.ndarray:
        """Mask of the runs with the wheel pressed on the cylinder."""
        return self.preload > 0

    @property
    def columns(self) -> dict[str, np.ndarray]:
        """Columns under headings with units, in the format that `read` accepts."""
        found = {name: getattr(self, name) for name in COLUMNS}
        return {f"{name} [{COLUMNS[name]}]": values for name, values in found.items() if values is not None}

    def chosen(self, rows: Any) -> RigData:
        """Select runs by index or mask."""
        picked = {
            name: None if getattr(self, name) is None else getattr(self, name)[rows]
            for name in (field.name for field in dataclasses.fields(self))
            if name not in ("lines", "name", "empty")
        }
        return dataclasses.replace(self, **picked, lines=tuple(np.asarray(self.lines)[rows].tolist()))


def read(file: str | Path, columns: Mapping[str, str] | None = None) -> RigData:
    """Read runs from a file of columns: CSV with commas or semicolons, or any other that recordings may have.

    Parameters
    ----------
    file : str or Path   Header with column names and units, such as ``mass [kg]``, then one line per run; one with an empty
        cell is left out.
    columns : mapping    Headings by name of a column, where they differ: ``{"mass": "m [kg]"}``.

    Returns
    -------
    RigData

    Raises
    ------
    InputError
        If the file cannot be read, a column or unit is missing or wrong, or a cell is not a number.
    """
    found = read_named(file, COLUMNS, _REQUIRED, columns)
    arrays: dict[str, Any] = {"motor_voltage": None, **found.columns}
    return RigData(**arrays, lines=tuple(found.lines.tolist()), name=str(file), empty=found.empty)


def check(data: RigData) -> None:
    """Refuse impossible settings, such as a negative mass.

    Raises
    ------
    InputError
        Lists the faults, one line each, with line number, value found and permitted range.
    """
    faults = {row: said for row in range(len(data)) if (said := _setting_fault(data, row)) is not None}
    if faults:
        refuse(data, faults)


def refuse(data: Any, faults: Mapping[int, str], closing: str = "") -> NoReturn:
    """Raise InputError with one line per fault, given by index of the run, and a closing line."""
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
