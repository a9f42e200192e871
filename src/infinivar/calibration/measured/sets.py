"""Measured sets: a folder with rows in a CSV file, and measured.toml, which says where they come from and what is known."""

from __future__ import annotations

import math
import os
import tomllib
from collections.abc import Mapping
from dataclasses import field
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from infinivar import units
from infinivar._core import files
from infinivar._core.result import Frozen, result
from infinivar.calibration.measured.benches import BENCHES
from infinivar.calibration.measured.law import Law
from infinivar.errors import InputError, nearest, printable
from infinivar.tables.encodings import text_of
from infinivar.tables.named import named_columns
from infinivar.tables.sheet import TextList, decimal_commas, in_column, miscounted, number_in

FILE = "measured.toml"
ROWS = "rows.csv"

VARIABLE = "INFINIVAR_MEASURED"
"""Environment variable that names the user's folder of measured sets."""

_MOST_BYTES = 50_000_000

_TEXTS = ("title", "bench", "source", "licence")
_MORE = ("rows", "notice", "not_shown", "by", "run", "leave_out", "every")
_TABLES = ("columns", "known", "start", "goal", "least", "most", "reason")


@result
class Table(Frozen):
    """Rows of a file: known columns and readings in SI, and words.

    Attributes
    ----------
    numbers : (n,) columns by name. [SI]
    texts : (n,) words by the role of their column: "by", "run" and "leave_out".
    factors : SI over the unit of the file, by column.
    lines : line of each row.
    empty : rows left out, as a cell is empty: what is said of each, by line.
    """

    name: str
    numbers: Mapping[str, np.ndarray]
    texts: Mapping[str, tuple[str, ...]]
    factors: Mapping[str, float]
    lines: tuple[int, ...]
    empty: Mapping[int, str]

    def __len__(self) -> int:
        """Number of rows."""
        return len(self.lines)


@result
class MeasuredSet(Frozen):
    """A measured set without its rows, as measured.toml describes it.

    Attributes
    ----------
    name : name of the folder.
    title, source, licence, notice : what was measured, by whom, and under which terms.
    not_shown : what the set does not show.
    law : bench and law.
    rows : file of the rows; None if they are not part of the set.
    columns : headings by name of a column, where they differ.
    settings, starts : known numbers, and first guesses of parameters. [SI]
    goals : residual rms that is hoped for, by signal of all parts or "signal part", such as "torque worm". [SI, or a
        share of the mean if relative]
    relative : goals that are shares of the mean reading.
    reasons : why a goal is missed, by the same names.
    least, most : size of columns outside which rows are not fitted. [SI]
    by : column of words whose values are parts with parameters of their own.
    run : column of words that name runs, which have errors of their own.
    leave_out : column whose rows of one word are left out together; by default that of runs.
    every : of how many rows one is fitted, as neighbours in time are alike.
    """

    name: str
    title: str
    source: str
    licence: str
    law: Law
    rows: Path | None = None
    notice: str = ""
    not_shown: str = ""
    columns: Mapping[str, str] = field(default_factory=dict)
    settings: Mapping[str, float] = field(default_factory=dict)
    starts: Mapping[str, float] = field(default_factory=dict)
    goals: Mapping[str, float] = field(default_factory=dict)
    relative: tuple[str, ...] = ()
    reasons: Mapping[str, str] = field(default_factory=dict)
    least: Mapping[str, float] = field(default_factory=dict)
    most: Mapping[str, float] = field(default_factory=dict)
    by: str = ""
    run: str = ""
    leave_out: str = ""
    every: int = 1


def shipped_sets() -> dict[str, Path]:
    """Folders of the shipped sets by name."""
    folder = Path(str(resources.files("infinivar.calibration") / "data" / "measured"))
    return {one.name: one for one in sorted(folder.iterdir()) if (one / FILE).is_file()}


def users_folder() -> Path:
    """Folder of the user's own measured sets; INFINIVAR_MEASURED names another."""
    requested = os.environ.get(VARIABLE)
    return Path(requested) if requested else files.of_user("data") / "measured"


def known_sets() -> dict[str, Path]:
    """Folders of the shipped sets and of the user's own, by name."""
    own = users_folder()
    try:
        inside = sorted(own.iterdir())
    except OSError:  # no such folder: nobody has added a set
        inside = []
    return {**{one.name: one for one in inside if (one / FILE).is_file()}, **shipped_sets()}


def read_set(name: str | Path) -> MeasuredSet:
    """Read the description of a measured set.

    Parameters
    ----------
    name : str or Path   Name of a shipped set or of one of the user's own, or a folder with measured.toml.

    Returns
    -------
    MeasuredSet

    Raises
    ------
    InputError
        If there is no such set, or a key or value is wrong; the message names it.
    """
    known = known_sets()
    path = known.get(str(name), Path(name)) / FILE
    if not path.is_file():
        hint = nearest(str(name), known)
        raise InputError(f"{printable(path)}: no such file{hint}; known sets: {', '.join(known)}")
    return described(path)


def described(path: Path) -> MeasuredSet:
    """The measured set that a TOML file describes; InputError as for `read_set`."""
    try:
        stated = tomllib.loads("\n".join(text_of(printable(path), files.read(path, _MOST_BYTES)).lines))
    except tomllib.TOMLDecodeError as problem:
        raise InputError(f"{printable(path)}: is not valid TOML: {problem}") from problem
    try:
        return _made(path.parent, stated)
    except InputError as problem:
        raise InputError(f"{printable(path)}: {problem}") from None


def _made(folder: Path, stated: Mapping[str, Any]) -> MeasuredSet:
    for key, value in stated.items():
        if key not in (*_TEXTS, *_MORE, *_TABLES):
            raise InputError(f"unknown key {key!r}{nearest(key, (*_TEXTS, *_MORE, *_TABLES))}")
        required = dict if key in _TABLES else int if key == "every" else str
        if not isinstance(value, required) or isinstance(value, bool):
            words = {dict: "a table", int: "a whole number", str: "a text"}[required]
            raise InputError(f"{key} must be {words}, got {value!r}")
    for key in _TEXTS:
        if not stated.get(key):
            raise InputError(f"{key} is missing")
    if stated["bench"] not in BENCHES:
        known = ", ".join(BENCHES)
        raise InputError(f"bench {stated['bench']!r} is unknown{nearest(stated['bench'], BENCHES)}; benches: {known}")
    law = BENCHES[stated["bench"]]
    if stated.get("every", 1) < 1:
        raise InputError(f"every must be at least 1, got {stated['every']}")
    columns = {**law.known, **law.read}
    terms = {name: term.parameter.unit for name, term in law.terms.items()}
    goals = stated.get("goal", {})
    of_goal = {name: law.read.get(name.split(" ")[0], "") for name in goals}
    settings = _numbers("known", stated, law.settings)
    missing = [name for name in law.settings if name not in settings]
    if missing:
        raise InputError(f"known.{missing[0]} is missing, in {law.settings[missing[0]]}")
    rows = folder / stated.get("rows", ROWS)
    return MeasuredSet(
        name=folder.resolve().name,
        law=law,
        rows=rows if "rows" in stated or rows.is_file() else None,
        columns={name: str(value) for name, value in stated.get("columns", {}).items()},
        settings=settings,
        starts=_numbers("start", stated, terms),
        goals={
            name: units.parse(value, "1" if "%" in str(value) else of_goal[name])
            for name, value in _checked("goal", goals, {name: unit for name, unit in of_goal.items() if unit}).items()
        },
        relative=tuple(name for name, value in goals.items() if "%" in str(value)),
        reasons=dict(stated.get("reason", {})),
        least=_numbers("least", stated, columns),
        most=_numbers("most", stated, columns),
        **{key: stated[key] for key in (*_TEXTS, *_MORE) if key in stated and key not in ("bench", "rows")},
    )


def _checked(table: str, values: Mapping[str, Any], known: Mapping[str, str]) -> Mapping[str, Any]:
    for name in values:
        if name not in known:
            raise InputError(f"{table}.{name} is unknown{nearest(name, known)}; known: {', '.join(known)}")
    return values


def _numbers(table: str, stated: Mapping[str, Any], known: Mapping[str, str]) -> dict[str, float]:
    """Numbers of a table in SI, by their units."""
    values = _checked(table, stated.get(table, {}), known)
    try:
        return {name: units.parse(value, known[name]) for name, value in values.items()}
    except InputError as problem:
        raise InputError(f"[{table}]: {problem}") from None


def read_rows(of: MeasuredSet, file: str | Path | None = None) -> Table:
    """Read the rows of a measured set.

    Parameters
    ----------
    of : MeasuredSet
    file : str or Path   File in place of the set's own, with the same headings.

    Returns
    -------
    Table

    Raises
    ------
    InputError
        If the set has no rows, or the file cannot be read; the message names file, line and column.
    """
    path = of.rows if file is None else Path(file)
    if path is None:
        raise InputError(
            f"{of.name}: the rows are not part of this set ({of.licence}); give their file, from {of.source}"
        )
    name = printable(path)
    listed = TextList.of(name, text_of(name, files.read(path, _MOST_BYTES)).lines)
    words = {one for one in (of.by, of.run, of.leave_out) if one}
    si = {**of.law.known, **of.law.read}
    texts: Mapping[str, str | None] = dict.fromkeys(words - si.keys())
    found = named_columns(listed, {**si, **texts}, of.columns, bare=True)
    missing = [one for one in (*si, *texts) if one not in found]
    if missing:
        has = ", ".join(heading.text for heading in listed.headings)
        raise InputError(f"{name}: {listed.top}: has no column {missing[0]}; it has {has}")
    zero = {one: units.parse(f"0 {found[one].unit}", si[one]) if found[one].unit != "1" else 0.0 for one in si}
    rows = listed.rows[1:]
    comma = decimal_commas(cells[found[one].place] for _, cells in rows for one in si if found[one].place < len(cells))
    numbers: dict[str, list[float]] = {one: [] for one in si}
    said: dict[str, list[str]] = {one: [] for one in words}
    lines: list[int] = []
    empty: dict[int, str] = {}
    for line, cells in rows:
        if wrong := miscounted(listed, cells):
            raise InputError(f"{name}: line {line}, {in_column(listed, *wrong)}")
        gaps = [one for one in si if not cells[found[one].place]]
        if gaps:
            empty[line] = f"{' and '.join(gaps)}: empty cell"
            continue
        for one in si:
            try:
                value = number_in(cells[found[one].place], comma)
            except InputError as problem:
                raise InputError(f"{name}: line {line}, {in_column(listed, found[one].place, str(problem))}") from None
            numbers[one].append(zero[one] + value * (found[one].factor - zero[one]))
        for one in words:
            said[one].append(cells[found[one].place])
        lines.append(line)
    if not lines:
        raise InputError(f"{name}: has no complete row")
    roles = {role: getattr(of, role) for role in ("by", "run", "leave_out")}
    return Table(
        name=name,
        numbers={one: np.asarray(values) for one, values in numbers.items()},
        texts={role: tuple(said[one]) for role, one in roles.items() if one},
        factors={one: found[one].factor - zero[one] for one in si},
        lines=tuple(lines),
        empty=empty,
    )


def cold(table: Table, law: Law) -> list[str]:
    """Columns of temperatures that are too low to be in kelvin."""
    kelvin = [name for name, unit in {**law.known, **law.read}.items() if unit == "K"]
    return [name for name in kelvin if float(np.min(table.numbers[name])) < _COLDEST]


_COLDEST = 150.0
"""Temperature below which no motor is measured. [K]"""


def goal_of(of: MeasuredSet, name: str, mean: float) -> float:
    """Goal for the residual rms of a signal, or of "signal part"; nan without one. [SI]"""
    return of.goals.get(name, math.nan) * (mean if name in of.relative else 1.0)
