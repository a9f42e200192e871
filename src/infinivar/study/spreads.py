"""How far the values of a study may be off: tolerances and standard deviations of its drives' parameters."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from infinivar import units
from infinivar._core.bounds import fits, permitted, words
from infinivar._core.fields import quantities_of, value_at
from infinivar._core.frozen import FrozenDict
from infinivar.drivetrain.drive import Drive
from infinivar.errors import InputError, nearest, printable
from infinivar.study.messages import StudyError, quoted
from infinivar.study.schema import KINDS, ORIGIN, SPREAD
from infinivar.units import plain

DRAWS = 1024
"""Builds of each drive that `compare` draws, unless the study asks for another number."""

NORMAL_95 = 1.959963984540054
"""Standard deviations to either side of an interval that holds 95 % of what is normally distributed."""

_LEAST, _MOST = 16, 2**20
_FORMS = tuple(SPREAD)
_WRITE = 'write "5 %", or a table with tolerance, deviation, or low and high'


@dataclass(frozen=True, slots=True, kw_only=True)
class Spread:
    """How far one value of a drive may be off.

    Without a `deviation` every value from `low` to `high` is as likely; with one they are normally distributed about
    `value`, cut off at `low` and `high`, the ends of what is permitted.
    """

    owner: str
    path: str
    unit: str
    value: float
    low: float
    high: float
    deviation: float | None
    kind: str
    where: str

    def at(self, share: Any) -> np.ndarray:
        """Value that a share of builds, 0 to 1, does not exceed."""
        if self.deviation is None:
            return self.low + np.asarray(share) * (self.high - self.low)
        from scipy.special import ndtr, ndtri

        below, above = (ndtr((end - self.value) / self.deviation) for end in (self.low, self.high))
        return self.value + self.deviation * ndtri(below + np.asarray(share) * (above - below))

    @property
    def words(self) -> str:
        """For people: "617.5 to 682.5 N", or "32000 ± 560 N (95 %)"."""
        if self.deviation is None:
            return f"{plain(self.low)} to {units.show(self.high, self.unit)}"
        return f"{plain(self.value)} ± {units.show(NORMAL_95 * self.deviation, self.unit, 2)} (95 %)"


@dataclass(frozen=True, slots=True, kw_only=True)
class Uncertainty:
    """What a study says about how far its values may be off.

    Attributes
    ----------
    spreads        By drive.
    correlations   Of two values of a drive, by drive and the two paths. [-]
    draws          Builds to draw of each drive.
    """

    spreads: Mapping[str, tuple[Spread, ...]] = field(default_factory=FrozenDict)
    correlations: Mapping[tuple[str, str, str], float] = field(default_factory=FrozenDict)
    draws: int = DRAWS

    def correlation(self, drive: str) -> np.ndarray:
        """Correlation matrix of the spreads of a drive. (k, k)"""
        paths = [spread.path for spread in self.spreads.get(drive, ())]
        matrix = np.eye(len(paths))
        for (owner, one, other), value in self.correlations.items():
            if owner == drive:
                i, j = paths.index(one), paths.index(other)
                matrix[i, j] = matrix[j, i] = value
        return matrix


def uncertainty_from(raw: Any, correlations: Any, drives: Mapping[str, Drive], origin: str) -> Uncertainty:
    """What the tables ``[uncertainty.DRIVE]`` and ``[[correlations]]`` say.

    Raises
    ------
    StudyError
        Naming every fault.
    """
    if not isinstance(raw, dict):
        raise StudyError(f"uncertainty = {quoted(raw)} must be tables [uncertainty.DRIVE]")
    draws = raw.get("draws", DRAWS)
    problems: list[str] = []
    if not _is_count(draws):
        problems.append(f"uncertainty.draws = {quoted(draws)} must be a power of two from {_LEAST} to {_MOST}")
    spreads: dict[str, tuple[Spread, ...]] = {}
    for drive, tree in raw.items():
        where = f"uncertainty.{printable(drive)}"
        if drive == "draws":
            continue
        if drive not in drives:
            problems.append(
                f"{where}: there is no such drive{nearest(drive, drives)}; the study has {', '.join(drives)}"
            )
        elif not isinstance(tree, dict):
            problems.append(f"{where} = {quoted(tree)} must be a table [{where}]")
        else:
            spreads[drive] = tuple(_spreads(drive, tree, origin, drives[drive], problems))
    pairs: dict[tuple[str, str, str], float] = {}
    if not problems:
        try:
            pairs = dict(_pairs(correlations, spreads))
        except InputError as problem:
            problems.append(str(problem))
    if problems:
        raise StudyError(*problems)
    made = Uncertainty(spreads=FrozenDict(spreads), correlations=FrozenDict(pairs), draws=draws)
    for drive in spreads:
        if np.linalg.eigvalsh(made.correlation(drive)).min(initial=1.0) <= 1e-10:
            raise StudyError(f"correlations of {drive} exclude one another: their matrix is not positive definite")
    return made


def _is_count(draws: Any) -> bool:
    """Whether it is a number of builds that the sequence of samples allows."""
    if isinstance(draws, bool) or not isinstance(draws, int):
        return False
    return _LEAST <= draws <= _MOST and draws & (draws - 1) == 0


def _spreads(drive: str, tree: Mapping[str, Any], origin: str, owner: Drive, problems: list[str]) -> Iterator[Spread]:
    """Spreads of one drive; a fault goes to the problems."""
    fields = quantities_of(owner)
    for path, written, kind, source in leaves(tree, "", "assumed", origin):
        try:
            yield _spread(drive, path, written, kind, source, owner, fields)
        except InputError as problem:
            problems.append(f"uncertainty.{printable(drive)}.{printable(path)}{_said(written)} {problem}")


def is_group(table: Any) -> bool:
    """Whether it holds spreads, rather than being one."""
    return isinstance(table, dict) and not any(form in table for form in _FORMS)


def leaves(
    tree: Mapping[str, Any], path: str = "", kind: Any = "assumed", where: Any = ""
) -> Iterator[tuple[str, Any, Any, Any]]:
    """Every spread in a table: its dotted path, what is written, and the kind and source that hold for it."""
    kind, where = tree.get("kind", kind), tree.get("where", where)
    for key, value in tree.items():
        if key in ORIGIN:
            continue
        if is_group(value):
            yield from leaves(value, f"{path}{key}.", kind, where)
        elif isinstance(value, dict):
            yield f"{path}{key}", value, value.get("kind", kind), value.get("where", where)
        else:
            yield f"{path}{key}", value, kind, where


def _spread(
    drive: str, path: str, written: Any, kind: Any, where: Any, owner: Drive, fields: Mapping[str, Any]
) -> Spread:
    _check_spread(drive, path, kind, where, fields)
    unit, bound = fields[path].metadata["unit"], fields[path].metadata["bound"]
    value = float(value_at(owner, path))
    table = written if isinstance(written, dict) else {"tolerance": written}
    unknown = [key for key in table if key not in (*_FORMS, *ORIGIN)]
    if unknown:
        raise InputError(f"has an unknown key {unknown[0]!r}{nearest(unknown[0], _FORMS)}; {_WRITE}")
    given = {key: _size(table[key], unit, value, key) for key in _FORMS if key in table}
    if set(given) not in ({"tolerance"}, {"deviation"}, {"low", "high"}):
        raise InputError(f"must be given one way: {_WRITE}")
    deviation = given.get("deviation")
    low, high = _range(given, unit, value) if deviation is None else permitted(bound, value)
    if deviation is None:
        for end in (low, high):
            if not fits(bound, end):
                raise InputError(f"reaches {units.show(end, unit)}, but the value must be {words(bound)}")
    return Spread(
        owner=drive, path=path, unit=unit, value=value, low=low, high=high, deviation=deviation, kind=kind, where=where
    )


def _check_spread(drive: str, path: str, kind: Any, where: Any, fields: Mapping[str, Any]) -> None:
    """Refuse a spread of no known value or of no proper origin."""
    if path not in fields:
        raise InputError(f"is no value that drives.{drive} has{nearest(path, fields)}")
    if path.startswith("control."):
        raise InputError("means nothing: neither steady operation nor prescribed motion depends on controllers")
    if kind not in KINDS:
        raise InputError(f"must have a kind of {', '.join(KINDS)}, got {quoted(kind)}")
    if not isinstance(where, str):
        raise InputError(f"must have its source as text in where, got {quoted(where)}")


def _range(given: Mapping[str, float], unit: str, value: float) -> tuple[float, float]:
    """Ends of a spread in which every value is as likely."""
    if "tolerance" in given:
        return value - given["tolerance"], value + given["tolerance"]
    low, high = given["low"], given["high"]
    if not low < high:
        raise InputError("must have low below high")
    if not low <= value <= high:
        raise InputError(f"leaves out the value itself, {units.show(value, unit)}")
    return low, high


def _size(written: Any, unit: str, value: float, key: str) -> float:
    """A tolerance or a value in SI; percent of the value where it is written so."""
    text = written.strip() if isinstance(written, str) else written
    if isinstance(text, str) and text.endswith("%") and key in ("tolerance", "deviation"):
        size = units.parse(text, "1") * abs(value)
    else:
        size = units.parse(text, unit)
    if key in ("tolerance", "deviation") and not size > 0:
        raise InputError(f"must have a {key} above zero{', and this value is zero' if value == 0 else ''}")
    return size


def _pairs(raw: Any, spreads: Mapping[str, tuple[Spread, ...]]) -> Iterator[tuple[tuple[str, str, str], float]]:
    if not isinstance(raw, list) or not all(isinstance(row, dict) for row in raw):
        raise InputError(f"correlations = {quoted(raw)} must be tables [[correlations]]")
    for place, row in enumerate(raw, 1):
        where = f"correlations (number {place})"
        if set(row) != {"drive", "between", "value"}:
            raise InputError(f"{where} must have drive, between and value, got {', '.join(map(printable, row))}")
        try:
            yield _pair(row["drive"], row["between"], row["value"], spreads)
        except InputError as problem:
            raise InputError(f"{where}: {problem}") from None


def _pair(
    drive: Any, between: Any, value: Any, spreads: Mapping[str, tuple[Spread, ...]]
) -> tuple[tuple[str, str, str], float]:
    known = [spread.path for spread in spreads.get(drive, ())] if isinstance(drive, str) else []
    if not known:
        raise InputError(f"drive = {quoted(drive)} must be one with a table [uncertainty.DRIVE]")
    pair = isinstance(between, list) and len(between) == 2 and all(one in known for one in between)
    if not pair or between[0] == between[1]:
        raise InputError(f"between = {quoted(between)} must be two of {', '.join(known)}")
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not -1 < value < 1:
        raise InputError(f"value = {quoted(value)} must be above -1 and below 1")
    return (drive, between[0], between[1]), float(value)


def _said(written: Any) -> str:
    return "" if isinstance(written, dict) else f" = {quoted(written)}"
