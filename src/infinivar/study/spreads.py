"""Spreads of a study: tolerances and standard deviations of its drives' parameters."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from infinivar import units
from infinivar._core.bounds import fits, permitted, words
from infinivar._core.described import derived, reported
from infinivar._core.fields import quantities_of, value_at, with_values
from infinivar._core.frozen import FrozenDict
from infinivar.drivetrain.drive import Drive
from infinivar.errors import InputError, ParameterError, nearest, printable
from infinivar.study.messages import StudyError, quoted
from infinivar.study.schema import KINDS, ORIGIN, SPREAD
from infinivar.units import plain

DRAWS = 1024
"""Number of samples of each drive that `compare` draws, unless the study states another."""

NORMAL_95 = 1.959963984540054
"""Half-width, in standard deviations, of the central 95 % interval of a normal distribution."""

_LEAST, _MOST = 16, 2**20
_FAR, _HALVINGS = 8.0, 50
"""Deviations beyond which a normal spread has no samples, and steps that look for the end of what a drive accepts."""
_FORMS = tuple(SPREAD)
_WRITE = 'write "5 %", or a table with tolerance, deviation, or low and high'


@dataclass(frozen=True, slots=True, kw_only=True)
class Spread:
    """Spread of one value of a drive.

    Without a `deviation`, the value is uniformly distributed from `low` to `high`; with one, it is normally distributed
    about `value` and truncated at `low` and `high`, the ends of the permitted range.
    """

    owner: str
    path: str = reported()
    unit: str = reported()
    value: float = reported()
    low: float
    high: float
    deviation: float | None
    kind: str = reported()
    where: str = reported()

    def at(self, share: Any) -> np.ndarray:
        """Return the quantile: the value that a share of the samples, 0 to 1, does not exceed."""
        if self.deviation is None:
            return self.low + np.asarray(share) * (self.high - self.low)
        from scipy.special import ndtr, ndtri

        below, above = (ndtr((end - self.value) / self.deviation) for end in (self.low, self.high))
        return self.value + self.deviation * ndtri(below + np.asarray(share) * (above - below))

    @derived(key="range")
    def words(self) -> str:
        """Text for reports: "617.5 to 682.5 N", or "32000 ± 560 N (95 %)"."""
        if self.deviation is None:
            return f"{plain(self.low)} to {units.show(self.high, self.unit)}"
        return f"{plain(self.value)} ± {units.show(NORMAL_95 * self.deviation, self.unit, 2)} (95 %)"


@dataclass(frozen=True, slots=True, kw_only=True)
class Uncertainty:
    """Spreads of a study's values and their correlations.

    Attributes
    ----------
    spreads        Spreads by drive.
    correlations   Correlation between two values of a drive, by drive and the two paths. [-]
    draws          Number of samples per drive.
    """

    spreads: Mapping[str, tuple[Spread, ...]] = field(default_factory=FrozenDict)
    correlations: Mapping[tuple[str, str, str], float] = field(default_factory=FrozenDict)
    draws: int = DRAWS

    def correlation(self, drive: str) -> np.ndarray:
        """Return the correlation matrix of the spreads of a drive. (k, k)"""
        paths = [spread.path for spread in self.spreads.get(drive, ())]
        matrix = np.eye(len(paths))
        for (owner, one, other), value in self.correlations.items():
            if owner == drive:
                i, j = paths.index(one), paths.index(other)
                matrix[i, j] = matrix[j, i] = value
        return matrix


def uncertainty_from(raw: Any, correlations: Any, drives: Mapping[str, Drive], origin: str) -> Uncertainty:
    """Read the tables ``[uncertainty.DRIVE]`` and ``[[correlations]]``.

    Raises
    ------
    StudyError
        If a spread or a correlation is invalid; lists every fault.
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
                f"{where}: the study has no such drive{nearest(drive, drives)}; its drives: {', '.join(drives)}"
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
            raise StudyError(f"correlations of {drive} contradict each other: their matrix is not positive definite")
    return made


def _is_count(draws: Any) -> bool:
    """Whether a number of samples is a power of two within the limits, as the Sobol sequence requires."""
    if isinstance(draws, bool) or not isinstance(draws, int):
        return False
    return _LEAST <= draws <= _MOST and draws & (draws - 1) == 0


def _spreads(drive: str, tree: Mapping[str, Any], origin: str, owner: Drive, problems: list[str]) -> Iterator[Spread]:
    """Yield the spreads of one drive; append faults to `problems`."""
    fields = quantities_of(owner)
    for path, written, kind, source in leaves(tree, "", "assumed", origin):
        try:
            yield _spread(drive, path, written, kind, source, owner, fields)
        except InputError as problem:
            problems.append(f"uncertainty.{printable(drive)}.{printable(path)}{_shown(written)} {problem}")


def is_group(table: Any) -> bool:
    """Whether a table contains spreads, rather than being one."""
    return isinstance(table, dict) and not any(form in table for form in _FORMS)


def leaves(
    tree: Mapping[str, Any], path: str = "", kind: Any = "assumed", where: Any = ""
) -> Iterator[tuple[str, Any, Any, Any]]:
    """Yield every spread in a table: its dotted path, its value as written, its kind and its source."""
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
        raise InputError(f"must be stated in exactly one way: {_WRITE}")
    deviation = given.get("deviation")
    low, high = _range(given, unit, value) if deviation is None else permitted(bound, value)
    if deviation is None:
        for end in (low, high):
            if not fits(bound, end):
                raise InputError(f"reaches {units.show(end, unit)}, but the value must be {words(bound)}")
            if (fault := _refusal(owner, path, end)) is not None:
                raise InputError(f"reaches {units.show(end, unit)}, which the drive refuses: {fault}")
    else:
        low, high = (accepted(owner, path, value, end, deviation) for end in (low, high))
    return Spread(
        owner=drive, path=path, unit=unit, value=value, low=low, high=high, deviation=deviation, kind=kind, where=where
    )


def _refusal(owner: Drive, path: str, value: float) -> str | None:
    """Why a drive refuses a value beside its other ones; None if it takes it."""
    try:
        with_values(owner, {path: value})
    except ParameterError as problem:
        return str(problem)
    return None


def accepted(owner: Drive, path: str, value: float, end: float, deviation: float) -> float:
    """The end of a normal spread, or where on the way there the drive begins to refuse values."""
    reached = min(max(end, value - _FAR * deviation), value + _FAR * deviation)
    if _refusal(owner, path, reached) is None:
        return end
    taken = value
    for _ in range(_HALVINGS):
        middle = 0.5 * (taken + reached)
        if _refusal(owner, path, middle) is None:
            taken = middle
        else:
            reached = middle
    return taken


def _check_spread(drive: str, path: str, kind: Any, where: Any, fields: Mapping[str, Any]) -> None:
    """Refuse a spread of an unknown value, or one with an invalid origin."""
    if path not in fields:
        raise InputError(f"is not a value of drives.{drive}{nearest(path, fields)}")
    if path.startswith("control."):
        raise InputError(
            "has no effect: neither steady operation nor prescribed motion depends on controllers; remove it"
        )
    if kind not in KINDS:
        raise InputError(f"must have one of {', '.join(KINDS)} as kind, got {quoted(kind)}")
    if not isinstance(where, str):
        raise InputError(f"must have text as where, naming the source, got {quoted(where)}")


def _range(given: Mapping[str, float], unit: str, value: float) -> tuple[float, float]:
    """Return the ends of a uniform spread."""
    if "tolerance" in given:
        return value - given["tolerance"], value + given["tolerance"]
    low, high = given["low"], given["high"]
    if not low < high:
        raise InputError("must have low below high")
    if not low <= value <= high:
        raise InputError(f"must include the value itself, {units.show(value, unit)}")
    return low, high


def _size(written: Any, unit: str, value: float, key: str) -> float:
    """Convert a tolerance or a value to SI; a percentage refers to the value."""
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
        raise InputError(f"drive = {quoted(drive)} must be a drive with a table [uncertainty.DRIVE]")
    pair = isinstance(between, list) and len(between) == 2 and all(one in known for one in between)
    if not pair or between[0] == between[1]:
        raise InputError(f"between = {quoted(between)} must be two of {', '.join(known)}")
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not -1 < value < 1:
        raise InputError(f"value = {quoted(value)} must be above -1 and below 1")
    return (drive, between[0], between[1]), float(value)


def _shown(written: Any) -> str:
    return "" if isinstance(written, dict) else f" = {quoted(written)}"
