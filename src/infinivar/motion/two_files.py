"""A recording whose motion stands in one file and whose force or moment stands in another, on the instants of the first."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from infinivar.errors import InputError, ParameterError
from infinivar.motion.files.agreement import one_course
from infinivar.motion.files.choice import SCALED, apart, family_of, role_words
from infinivar.motion.files.reading import headings_in, read_table
from infinivar.motion.files.table import BESIDE, ROLES, RecordedTable
from infinivar.motion.files.timing import read_timed, resampled, timed, windowed
from infinivar.motion.smoothing import GAP
from infinivar.tables.headings import heading_of
from infinivar.tables.sheet import shown
from infinivar.units import plain

_WHOLE = 1e-6
"""Times that agree to this share of a step or cycle are the same."""
_HELD = 0.02
"""Longest share of the motion over which the force holds beyond its file, so that an odd last row does not shorten a cycle."""


def read_recording(
    file: str | Path,
    *,
    force_file: str | Path | None = None,
    force_columns: Mapping[str, str] | None = None,
    columns: Mapping[str, str] | None = None,
    flip: Sequence[str] | None = None,
    body_mass: float | None = None,
    cycle_time: float | None = None,
    window: Sequence[float] | None = None,
    sample_rate: float | None = None,
    resampling: str | None = None,
) -> RecordedTable:
    """Read a recording with its times as `read_timed`, its force or moment from a second file if there is one.

    The two files have one clock: both state times, or both a phase (or equal steps) of a cycle. The force is interpolated
    linearly at the rows of the motion. Of times, those in both files count: where the motion goes on beyond the second file,
    its rows are left out, with a warning; if only by a step of the coarser file and 2 % of the motion, the last value holds.
    The force of one cycle repeats. Strides by phase must have the same phases in both files, as nothing else says which belong
    together.

    Parameters
    ----------
    file : str or Path             Motion; a force in it is not used beside the second file.
    force_file : str or Path       Force or moment; a motion in it is not used. None if `file` holds all columns.
    force_columns : mapping        As `columns`, of the second file: time, phase, force and moment.
    flip, body_mass                As of `read_table`; those of force and moment apply to the second file.
    columns, cycle_time, window, sample_rate, resampling   As of `read_timed`.

    Raises
    ------
    InputError
        If a file is invalid, the second has no force along (or no moment about) the axis of the motion, or they have no time
        in common; the message names the file at fault.
    ParameterError
        If an argument is outside its range, or contradicts another.
    """
    how: dict[str, Any] = {"columns": columns, "flip": flip, "body_mass": body_mass, "leave_out": True}
    if force_file is None:
        if force_columns is not None:
            raise ParameterError("force_columns does not apply without force_file; state that file, or remove it")
        return read_timed(
            file, **how, cycle_time=cycle_time, window=window, sample_rate=sample_rate, resampling=resampling
        )
    twice = next((role for role in columns or {} if role in SCALED), None)
    if twice is not None:
        raise ParameterError(
            f"columns names a {twice}, and so does force_file; move it to force_columns, or remove one of them"
        )
    moving = tuple(role for role in ROLES if role not in SCALED)
    flipped = [one for one in flip or () if one not in SCALED]
    first = read_table(file, columns=columns, flip=flipped, roles=moving, leave_out=True)
    second = _beside(force_file, force_columns, [one for one in flip or () if one in SCALED], body_mass)
    _check_clocks(first, second)
    first, second = one_course(timed(first, cycle_time=cycle_time)), timed(second, cycle_time=cycle_time)
    role = _role(first, second, named=force_columns is not None)
    _check_strides(first, second, cycle_time)
    said = (
        *_unused(first, ("force",), f"the {role}", second),
        *_unused(second, ("position", "speed"), "the motion", first),
    )
    found = _with_force(windowed(first, window), second, role, cycle_time)
    found = dataclasses.replace(
        found,
        remarks=(*found.remarks, *(f"{second.file}: {one}" for one in second.remarks), *said),
        warnings=(*found.warnings, *second.warnings),
    )
    return resampled(found, sample_rate, resampling)


def _beside(
    file: str | Path, columns: Mapping[str, str] | None, flip: Sequence[str], body_mass: float | None
) -> RecordedTable:
    """Read the second file; messages about its columns name the key that states them."""
    wrong = next((role for role in columns or {} if role not in BESIDE), None)
    if wrong is not None:
        raise ParameterError(f"force_columns has a column {wrong!r}, must be one of {', '.join(BESIDE)}")
    try:
        return read_table(file, columns=columns, flip=flip, body_mass=body_mass, roles=BESIDE, leave_out=True)
    except InputError as problem:
        if "columns" not in str(problem):
            raise
        raise InputError(f"{problem} (for this file, the key is force_columns)") from problem


def _check_clocks(first: RecordedTable, second: RecordedTable) -> None:
    """Refuse times beside a share of the cycle: nothing says when the cycle starts."""
    with_time, without = (first, second) if "time" in first.columns else (second, first)
    if "time" not in with_time.columns or "time" in without.columns:
        return
    _refuse(
        without,
        "must name a column of time",
        f"as {with_time.file} does ({shown(with_time.columns['time'].heading)}), or both files a phase of the cycle",
    )


def _role(first: RecordedTable, second: RecordedTable, *, named: bool) -> str:
    """Return the role of the force in the second file: it must belong to the axis of the motion."""
    role, other = ("moment", "force") if first.axis.rotary else ("force", "moment")
    motion = next(one for name, one in first.columns.items() if name not in ("time", "phase", "heel_strike"))
    if role not in second.columns:
        axis = "about a joint" if first.axis.rotary else "along a line"
        wrong = f", not only of {other}" if other in second.columns else ""
        _refuse(second, f"must name a column of {role}{wrong}", f"as {first.file} moves {axis}")
    heading = second.columns[role].heading
    if not named and apart(motion.heading, heading):
        raise InputError(
            f"{second.file}: {second.top}, column {shown(heading)}: is of another joint or side than {shown(motion.heading)} of "
            f"{first.file}; if they belong together, name it with force_columns"
        )
    return role


def _refuse(table: RecordedTable, what: str, why: str) -> NoReturn:
    hint = "; if one of them is it, name it with force_columns" if table.ignored else ""
    raise InputError(f"{table.file}: {table.top}: {what}, {why}; {headings_in(table)}{hint}")


def _one_cycle(table: RecordedTable, cycle_time: float) -> bool:
    time = table.columns["time"].values
    return float(time[-1] - time[0]) <= cycle_time * (1.0 + _WHOLE)


def _check_strides(first: RecordedTable, second: RecordedTable, cycle_time: float | None) -> None:
    """Refuse several strides by phase whose rows are not the same in both files."""
    if cycle_time is None or (_one_cycle(first, cycle_time) and _one_cycle(second, cycle_time)):
        return
    one, two = (table.columns["time"].values for table in (first, second))
    if len(one) != len(two) or np.max(np.abs(one - two)) > _WHOLE * cycle_time:
        raise InputError(
            f"{second.file}: {second.top}: must have the same rows of phase as {first.file}, as one of them holds "
            f"several strides; got {len(two)} rows for {len(one)}"
        )


def _unused(table: RecordedTable, families: Sequence[str], what: str, beside: RecordedTable) -> tuple[str, ...]:
    """Return what is said of columns that the other file states too."""
    texts = [
        text
        for text in table.ignored
        if (one := heading_of(text)).name and family_of(one.name, one.unit) in families and one.unit
    ]
    return tuple(f"{shown(text)} of {table.file} is not used: {what} is that of {beside.file}" for text in texts)


def _with_force(first: RecordedTable, second: RecordedTable, role: str, cycle_time: float | None) -> RecordedTable:
    """Return the motion with the force of the second file at its rows.

    Raises
    ------
    InputError
        If fewer than two rows have times that the second file has too.
    """
    force, time, given = second.columns[role], first.columns["time"].values, second.columns["time"].values
    at, kept, said, doubts = time, np.ones(len(time), bool), "", []
    steps = np.diff(given)
    usual = float(np.median(steps))
    if cycle_time is not None:
        # The force of one cycle repeats; strides have the same rows in both files, so that nothing is outside.
        outside = (time < given[0]) | (time > given[-1])
        at = np.where(outside, given[0] + (time - given[0]) % cycle_time, time)
    else:
        near = min(max(usual, float(np.median(np.diff(time)))), _HELD * float(time[-1] - time[0])) + _WHOLE * usual
        before, after = (near if one <= near else _WHOLE * usual for one in (given[0] - time[0], time[-1] - given[-1]))
        kept = (time >= given[0] - before) & (time <= given[-1] + after)
        own = f"{plain(time[0], 4)} s to {plain(time[-1], 4)} s"
        if np.count_nonzero(kept) < 2:
            raise InputError(
                f"{second.file}: {second.place}s {second.lines[0]} to {second.lines[-1]}, column "
                f"{shown(second.columns['time'].heading)}: must have times in common with {first.file}, which has {own}, got "
                f"{plain(given[0], 4)} s to {plain(given[-1], 4)} s"
            )
        held = max(given[0] - np.min(time[kept]), np.max(time[kept]) - given[-1])
        if held > _WHOLE * usual:
            said = f"; the value at its end holds for up to {plain(held, 3)} s"
        if not np.all(kept):
            doubts.append(
                f"{first.file}: {len(time) - np.count_nonzero(kept)} of {len(time)} rows are left out: they are from {own}, but "
                f"{second.file} has the {role} from {plain(given[0], 4)} s to {plain(given[-1], 4)} s"
            )
    wide = int(np.argmax(steps))
    if steps[wide] > GAP * usual:
        doubts.append(
            f"{second.file}: {second.place} {second.lines[wide + 1]}: {plain(steps[wide], 3)} s without data, "
            f"{plain(steps[wide] / usual, 3)} times the median step; interpolated linearly"
        )
    columns = {name: dataclasses.replace(one, values=one.values[kept]) for name, one in first.columns.items()}
    columns[role] = dataclasses.replace(force, values=np.interp(at[kept], given, force.values))
    ends = first.ends if not first.ends else {**first.ends, role: second.ends[role]}
    count = np.count_nonzero(kept)
    remark = (
        f"{role_words(role)} {shown(force.heading)} of {second.file} ({second.format}), {len(given)} rows from "
        f"{plain(given[0], 4)} s to {plain(given[-1], 4)} s, interpolated linearly at {count} rows of the motion{said}"
    )
    return dataclasses.replace(
        first,
        columns=columns,
        lines=first.lines[kept],
        ends=ends,
        remarks=(*first.remarks, remark),
        warnings=(*first.warnings, *doubts),
    )
