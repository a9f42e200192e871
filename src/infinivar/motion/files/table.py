"""The table that every file format is read into: columns in SI by their role, and what was understood of the file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field

import numpy as np

from infinivar._core.result import Frozen, result
from infinivar.axis import LINEAR, ROTARY, Axis

ROLES: dict[str, str] = {
    "time": "s",
    "phase": "1",
    "position": "m",
    "speed": "m/s",
    "force": "N",
    "angle": "rad",
    "angular_speed": "rad/s",
    "moment": "N m",
    "heel_strike": "",
}
"""Roles of columns, with the SI units of their values. A phase is a share of the cycle; a heel strike is marked by a number
other than 0 and has no unit."""

ABOUT_A_JOINT = {"angle": "position", "angular_speed": "speed", "moment": "force"}
"""Roles of a motion about a joint, with the fields of a motion that hold them."""

BESIDE = ("time", "phase", "force", "moment")
"""Roles of the columns of a second file, which has the force beside the motion of the first."""

SIGNED = ("position", "speed", "force", "angle", "angular_speed", "moment")
"""Roles whose positive direction is a matter of convention."""


@result
class Column(Frozen):
    """One column of a recording.

    Attributes
    ----------
    role : str              One of `ROLES`.
    heading : str           Heading in the file.
    unit : str              Unit as written in the heading or in the study's `columns`, such as "mm"; "" without one.
    values : (n,) float     In the SI unit of the role.
    """

    role: str
    heading: str
    unit: str
    values: np.ndarray


@result
class RecordedTable(Frozen):
    """A recording as read from its file.

    Attributes
    ----------
    file : str                   Name of the file, for messages; control characters are escaped.
    format : str                 What was understood of the file: "CSV with semicolons and decimal commas, UTF-8".
    columns : mapping            Columns by role; all have the same length.
    ignored : tuple of str       Headings of the columns that are not used.
    lines : (n,) int             Line of the file for each row, used in messages; the row, from 1, where there are no lines.
    place : str                  What `lines` count: "line" or "row".
    top : str                    Where the headings stand, for messages: "line 1".
    ends : mapping               Values by role at 100 % of the strides whose next one starts with a row at 0 %, which stands for
                                 the same instant in `columns`. A stride ends with its own row. (m,)
    remarks : tuple of str       What was done to the columns: a flipped sign, a window, resampling.
    warnings : tuple of str      What in the file contradicts itself.
    """

    file: str
    format: str
    columns: Mapping[str, Column]
    ignored: tuple[str, ...]
    lines: np.ndarray
    place: str = "line"
    top: str = "line 1"
    remarks: tuple[str, ...] = ()
    ends: Mapping[str, np.ndarray] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()

    def __len__(self) -> int:
        """Number of rows."""
        return len(self.lines)

    @property
    def axis(self) -> Axis:
        """Whether the motion is along a line or about a joint."""
        return ROTARY if any(role in self.columns for role in ABOUT_A_JOINT) else LINEAR

    @property
    def values(self) -> dict[str, np.ndarray]:
        """Values by field of a motion: angle, angular speed and moment stand as position, speed and force."""
        return {ABOUT_A_JOINT.get(role, role): column.values for role, column in self.columns.items()}

    @property
    def end_values(self) -> dict[str, np.ndarray]:
        """Values of `ends` by field of a motion."""
        return {ABOUT_A_JOINT.get(role, role): values for role, values in self.ends.items()}
