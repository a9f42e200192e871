"""Whether a position and a speed of one recording tell of the same motion; one of the two is used."""

from __future__ import annotations

import dataclasses
import json

import numpy as np

from infinivar import units
from infinivar.errors import InputError, printable
from infinivar.motion.files.choice import role_words
from infinivar.motion.files.reading import headings_in
from infinivar.motion.files.table import ROLES, RecordedTable
from infinivar.tables.headings import heading_of, unit_and_per_kg
from infinivar.tables.sheet import shown
from infinivar.units import percent

_MOTION = ("position", "angle", "speed", "angular_speed")
_OVER = 0.1
"""Time over which speeds are compared, so that noise and the counts of an encoder do not matter. [s]"""
_SHORT = 0.125
"""Longest share of the recording over which speeds are compared."""
_APART = 0.25
"""Difference between a speed and the slope of a position, as a share of the larger RMS, from which they contradict."""


def one_course(table: RecordedTable) -> RecordedTable:
    """Return a table that states its motion once: a speed beside a position is not used, but compared with it.

    Raises
    ------
    InputError
        If the table has neither position nor speed.
    """
    roles = [role for role in _MOTION if role in table.columns]
    if not roles:
        raise InputError(
            f"{table.file}: {table.top}: must name a column of position or speed, or of angle or angular speed; "
            f"{headings_in(table)}{_hint(table)}"
        )
    if len(roles) == 1:
        return table
    used, other = (table.columns[role] for role in roles[:2])
    off = _difference(table.columns["time"].values, used.values, other.values)
    both = f"{table.file}: {table.top}, columns {shown(used.heading)}, {shown(other.heading)}"
    said = (
        f"{both}: contradict each other: the {role_words(other.role)} is {percent(off)} off the slope of the "
        f"{role_words(used.role)}; the {role_words(other.role)} is not used"
    )
    return dataclasses.replace(
        table,
        columns={role: column for role, column in table.columns.items() if role != other.role},
        ignored=(*table.ignored, other.heading),
        remarks=(
            *table.remarks,
            f"{role_words(other.role)} {shown(other.heading)} is not used beside the {role_words(used.role)}",
        ),
        warnings=(*table.warnings, *((said,) if off > _APART else ())),
    )


def _difference(time: np.ndarray, position: np.ndarray, speed: np.ndarray) -> float:
    """RMS difference between the slope of a position and a speed, as a share of the larger RMS of the two. [-]

    Both are means over a short time: the way covered in it, and the integral of the speed.
    """
    lasts = float(time[-1] - time[0])
    over = min(max(min(_OVER, _SHORT * lasts), 2.0 * float(np.median(np.diff(time)))), 0.5 * lasts)
    way = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(time))])
    start = np.linspace(time[0], time[-1] - over, max(len(time), 100))
    slope, stated = (
        (np.interp(start + over, time, course) - np.interp(start, time, course)) / over for course in (position, way)
    )
    largest = float(max(np.sqrt(np.mean(slope**2)), np.sqrt(np.mean(stated**2))))
    return float(np.sqrt(np.mean((slope - stated) ** 2))) / largest if largest else 0.0


def _hint(table: RecordedTable) -> str:
    """Return how a study names the position; "" if every column is known."""
    if not table.ignored:
        return ""
    measured = (
        (role, text)
        for text in table.ignored
        for role in _MOTION
        if units.measures(unit_and_per_kg(heading_of(text).unit or "1")[0], ROLES[role])
    )
    role, text = next(measured, ("position", f"{table.ignored[0]} [unit]"))
    headings = {
        known: column.heading
        if heading_of(column.heading).unit or not column.unit
        else f"{column.heading} [{column.unit}]"
        for known, column in table.columns.items()
    } | {role: text}
    entries = ", ".join(f"{role} = {json.dumps(text, ensure_ascii=False)}" for role, text in headings.items())
    return f"; if one of them is the motion, name it with columns, such as columns = {{ {printable(entries)} }}"
