"""Read a file of columns, whatever its format, into one table in SI."""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from pathlib import Path

import numpy as np

from infinivar import units
from infinivar._core.text import few
from infinivar.errors import InputError, require
from infinivar.motion.files.choice import SCALED, Chosen, by_heading, by_map, family_of, role_words
from infinivar.motion.files.table import ROLES, SIGNED, Column, RecordedTable
from infinivar.tables.formats import opened
from infinivar.tables.named import filled, known_names
from infinivar.tables.sheet import Source, fault, headings_of, listed, shown

_AT_END = 1e-9
"""Phase within which a row is at an end of the cycle. [-]"""

_DIGITISED = 0.005
"""Share of a cycle by which a phase may exceed it, as one read off a printed curve does: 1 mm of an axis of 200 mm."""

_FEWEST = 2
"""Fewest rows of a recording."""
_MOST_LINES = 5
"""Most rows listed in a warning."""

_LARGEST = 1e20
"""Magnitudes above this are mistakes, and their products would overflow."""


def read_table(
    file: str | Path,
    *,
    columns: Mapping[str, str] | None = None,
    flip: Sequence[str] = (),
    body_mass: float | None = None,
    usual: Mapping[str, str] | None = None,
    roles: Container[str] = ROLES,
    leave_out: bool = False,
) -> RecordedTable:
    """Read a recording as it comes.

    Text files with commas, semicolons, tabs or blanks between columns, decimal points or commas, UTF-8, UTF-16 or Latin-1;
    storage and motion files of OpenSim; Parquet files where pyarrow is installed. Headings such as ``Pos (mm)``,
    ``pos [mm]``, ``pos_mm`` and ``Ankle torque (N-m)`` are understood. A unit is never guessed.

    Parameters
    ----------
    file : str or Path
    columns : mapping     Heading of each column to read, by role: ``{"time": "t [ms]", "angle": "Knee angle"}``. The unit may
                          stand in brackets here where the file does not state it. By default the headings of the file decide.
    flip : sequence       Roles of columns whose sign is reversed, as laboratories differ in the direction called positive.
    body_mass : float     Multiplies forces and moments that the file states per kilogram; None if there are none. [kg]
    usual : mapping       Units of headings that are just the name of a role, by role, where a file may omit them.
    roles : container     Roles to look for where the headings decide.
    leave_out : bool      Whether a row with an empty cell is left out, with a warning, where a time or phase says when the others
                          are; if not, it is a fault. A heel strike that is empty is none.

    Returns
    -------
    RecordedTable   Times increase from row to row; a phase is within 0 and 1.

    Raises
    ------
    InputError
        If the file is invalid; the message names file, line and column, and what would be right.
    """
    known_names("columns", columns or {}, tuple(ROLES))
    known_names("flip", flip, SIGNED)
    flip = tuple(dict.fromkeys(flip))
    if body_mass is not None:
        require(body_mass > 0.0, "body_mass", body_mass, "> 0", "kg")
    source = opened(file, lambda one: family_of(one.name, one.unit) is not None)
    chosen = by_map(source, columns, usual or {}) if columns is not None else by_heading(source, usual or {}, roles)
    if not chosen:
        raise InputError(
            f"{source.file}: {source.top}: must name columns of a motion, such as 'time [s]' and 'position [mm]', got "
            f"{headings_of(source)}; if the columns have other names, state them in the study: columns = {{ time = ... }}"
        )
    _check_body_mass(source, chosen, body_mass)
    unknown = next((role for role in flip if role not in chosen), None)
    if unknown is not None:
        raise InputError(
            f"{source.file}: {source.top}: has no column of {role_words(unknown)} to flip; "
            f"found {', '.join(map(role_words, chosen))}"
        )
    leave_out = leave_out and ("time" in chosen or "phase" in chosen)
    raw, lines, said = source.numbers([one.place for one in chosen.values()], blank=leave_out)
    seen = lines
    raw, lines, empty = filled(raw, lines, list(chosen), zero=("heel_strike",))
    if empty and len(lines) < _FEWEST:
        line, cells = next(iter(empty.items()))
        raise InputError(f"{source.file}: {source.place} {line}, {cells}; without such rows, {len(lines)} are left")
    made, clipped = {}, ()
    if "phase" in chosen:
        place, factor = list(chosen).index("phase"), chosen["phase"].factor * (-1.0 if "phase" in flip else 1.0)
        phase, kept, clipped = _clipped(raw[:, place] * factor, lines, source.place)
        raw[:, place] = phase / factor
        raw, lines = raw[kept], lines[kept]
    for place, (role, one) in enumerate(chosen.items()):
        factor = one.factor * (body_mass if one.per_kg and body_mass is not None else 1.0)
        values = raw[:, place] * (-factor if role in flip else factor)
        _check_values(source, role, one, values, lines)
        made[role] = Column(role=role, heading=source.headings[one.place].text, unit=one.unit, values=values)
    used = {one.place for one in chosen.values()}
    return RecordedTable(
        file=source.file,
        format=said,
        columns=made,
        ignored=tuple(one.text for place, one in enumerate(source.headings) if place not in used),
        lines=lines,
        place=source.place,
        top=source.top,
        remarks=(
            *source.passed_over(seen),
            *clipped,
            *(f"sign of the {role_words(role)} reversed" for role in flip),
            *(
                f"{role_words(role)} per kilogram times {units.show(body_mass or 0.0, 'kg')}"
                for role, one in chosen.items()
                if one.per_kg
            ),
        ),
        warnings=_left_out(source, empty),
    )


def _left_out(source: Source, empty: Mapping[int, str]) -> tuple[str, ...]:
    """A warning for all rows that lack the same cells."""
    said = []
    for cells in dict.fromkeys(empty.values()):
        lines = [line for line, one in empty.items() if one == cells]
        plural = "" if len(lines) == 1 else "s"
        where = few([*map(str, lines)], _MOST_LINES)
        said.append(f"{source.file}: {source.place}{plural} {where} left out: {cells}")
    return tuple(said)


def headings_in(table: RecordedTable) -> str:
    """Return what was found in a file and what was not used, for a message about a missing column."""
    found = ", ".join(f"{shown(column.heading)} as {role_words(role)}" for role, column in table.columns.items())
    other = f"; other headings: {listed(table.ignored)}" if table.ignored else ""
    return f"found {found}{other}"


def _check_body_mass(source: Source, chosen: Mapping[str, Chosen], body_mass: float | None) -> None:
    """Check that there is a body mass if and only if a column is per kilogram."""
    scaled = [one for one in chosen.values() if one.per_kg]
    if scaled and body_mass is None:
        column = shown(source.headings[scaled[0].place].text)
        raise InputError(
            f"{source.file}: {source.top}, column {column}: is per kilogram of body mass; state that mass, such as "
            'body_mass = "75 kg"'
        )
    if body_mass is not None and not scaled:
        forces = [shown(source.headings[one.place].text) for role, one in chosen.items() if role in SCALED]
        said = f", column {forces[0]}: is not per kilogram" if forces else ": no column of force or moment is read"
        raise InputError(f"{source.file}: {source.top}{said}; body_mass does not apply, remove it from the study")


def _clipped(values: np.ndarray, lines: np.ndarray, place: str) -> tuple[np.ndarray, np.ndarray, tuple[str, ...]]:
    """A phase within the cycle where it exceeds it by what digitising explains, the rows that stay, and a remark.

    Of several rows beyond the same end, that next to the cycle stays, unless a row is at the end itself.
    """
    low, high = values < -_AT_END, values > 1.0 + _AT_END
    wrong, beyond = np.flatnonzero(low | high), float(np.max(np.maximum(-values, values - 1.0)))
    kept = np.ones(len(values), dtype=bool)
    if not wrong.size or beyond > _DIGITISED:
        return values, kept, ()
    rises = np.diff(values) > 0.0
    kept[:-1] &= ~(low[:-1] & rises & (values[1:] <= _AT_END))
    kept[1:] &= ~(high[1:] & rises & (values[:-1] >= 1.0 - _AT_END))
    most = f"{units.plain(100.0 * beyond, 3)} %"
    where = f"{place}{'' if wrong.size == 1 else 's'} {', '.join(map(str, lines[wrong].tolist()))}"
    done = "clipped" if kept.all() else "clipped or left out"
    return (
        np.clip(values, 0.0, 1.0),
        kept,
        (f"phase beyond the cycle by up to {most} {done}, as digitising explains: {where}",),
    )


def _check_values(source: Source, role: str, one: Chosen, values: np.ndarray, lines: np.ndarray) -> None:
    """Refuse values that are no motion: too large, times that do not increase, a phase beyond the cycle."""
    wrong = np.flatnonzero(~(np.abs(values) <= _LARGEST))
    if wrong.size:
        row = int(wrong[0])
        fault(source, int(lines[row]), one.place, f"must be within {_LARGEST:g} in SI units, got {values[row]:g}")
    if role == "time":
        wrong = np.flatnonzero(~(np.diff(values) > 0.0))
        if wrong.size:
            row = int(wrong[0])
            got = f"{units.plain(values[row + 1])} s after {units.plain(values[row])} s"
            fault(source, int(lines[row + 1]), one.place, f"must have a later time than the row above, got {got}")
    if role == "phase":
        wrong = np.flatnonzero((values < 0.0) | (values > 1.0 + 1e-9))
        if wrong.size:
            row = int(wrong[0])
            fault(
                source, int(lines[row]), one.place,
                f"must be within 0 and 100 % of the cycle, got {units.plain(100.0 * values[row])} %",
            )  # fmt: skip
